//! Settings of CODESYS and TwinCAT that change what is executed.

use super::drawings::{bound, checked, only, program, refused, st, vendors, written};
use super::scanbound;
use scanbound::audit::{Request, audit};
use scanbound::base::facts::Facts;
use scanbound::front::Input;

/// Additional data of CODESYS.
fn of_codesys(name: &str, content: &str) -> String {
    format!(
        "<addData><data name=\"http://www.3s-software.com/plcopenxml/{name}\">{content}</data></addData>"
    )
}

#[test]
fn settings_that_change_what_is_executed_are_read_or_refused() {
    let unit = |data: &str| vendors(data, &st(""), &st(""));
    let build = |property: &str| {
        let set = format!("<BuildProperties><{property}>true</{property}></BuildProperties>");
        unit(&of_codesys("buildproperties", &set))
    };
    refused("build-external.xml", &build("External"), "the build property External is set");
    assert_eq!(checked("build-link.xml", &build("LinkAlways")).code, Some(0));
    let flag = |used: &str| {
        let flags = format!("<Flags><Pause Declare=\"true\" Use=\"{used}\"/></Flags>");
        unit(&of_codesys("sfcsettings", &format!("<SFCSettings>{flags}</SFCSettings>")))
    };
    refused("flag-used.xml", &flag("true"), "the settings of the chart use the flag SFCPause");
    assert_eq!(checked("flag-unused.xml", &flag("false")).code, Some(0));
    // The tool declares these, so the chart may restart.
    for restart in ["Init", "Reset"] {
        let used = flag("true").replace("<Pause", &format!("<{restart}"));
        assert_eq!(checked("flag-restart.xml", &used).code, Some(0));
    }
    let analysis = flag("true").replace("<Pause Declare=\"true\"", "<SFCErrorAnalyzation");
    refused("flag-analysis.xml", &analysis, "the flag SFCErrorAnalyzation");
    // A retained variable may start with any value that a scan left in it: here, a value within a scan.
    let variable = "<variable name=\"n\"><type><INT/></type></variable>";
    let code = "IF n &gt; 5 THEN c(); END_IF; n := n + 1; IF n &gt; 5 THEN n := 0; END_IF;";
    let counting = |data: &str| {
        let text = vendors("", "", &st(code)).replace("<interface><localVars><variable name=\"c\"><type><derived name=\"Cost4\"/></type></variable><variable name=\"f\"",
            &format!("<interface>{data}<localVars>{variable}<variable name=\"c\"><type><derived name=\"Cost4\"/></type></variable><variable name=\"f\""));
        assert!(text.contains(variable));
        text
    };
    let mixed = of_codesys(
        "mixedattrsvarlist",
        &format!(
            "<MixedAttrsVarList><localVars retain=\"true\">{variable}</localVars></MixedAttrsVarList>"
        ),
    );
    let proved = |name: &str, data: &str| {
        let path = written(name, &counting(data));
        let facts = "--table zero.csv --facts calls.toml --limit 1us --trust all";
        scanbound("attack", &format!("check {} {facts}", path.display())).code == Some(0)
    };
    assert!(proved("mixed-none.xml", ""));
    assert!(!proved("mixed-retain.xml", &mixed));
}

#[test]
fn conditions_of_charts_of_codesys_may_all_be_evaluated() {
    let bound = |setting: &str| {
        let chart = format!(
            "<SFC><step localId=\"1\" name=\"S0\" initialStep=\"true\"/>{}{}{}{}</SFC>",
            "<transition localId=\"2\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn><condition><inline name=\"\"><ST><p>F() AND b</p></ST></inline></condition></transition>",
            "<step localId=\"3\" name=\"S1\"><connectionPointIn><connection refLocalId=\"2\"/></connectionPointIn></step>",
            "<transition localId=\"4\"><connectionPointIn><connection refLocalId=\"3\"/></connectionPointIn><condition><inline name=\"\"><ST><p>F() AND b</p></ST></inline></condition></transition>",
            "<jumpStep localId=\"5\" targetName=\"S0\"><connectionPointIn><connection refLocalId=\"4\"/></connectionPointIn></jumpStep>"
        );
        let function = "<pou name=\"F\" pouType=\"function\"><interface><returnType><BOOL/></returnType></interface><body><ST><p>F := TRUE;</p></ST></body></pou>";
        let settings = of_codesys("sfcsettings", setting) + &of_codesys("objectid", "<ObjectId/>");
        let settings = settings.replace("</addData><addData>", "");
        let text = program("b:BOOL", &chart)
            .replace("<pous>", &format!("<pous>{function}"))
            .replace("</body></pou></pous>", &format!("</body>{settings}</pou></pous>"));
        bound("d.xml", &text, &only("CAL"))
    };
    let set = |value: &str| {
        format!("<SFCSettings><CalcActiveTransOnly>{value}</CalcActiveTransOnly></SFCSettings>")
    };
    let only_active = bound(&set("true"));
    assert!(only_active > 0);
    assert!(bound(&set("false")) > only_active);
    assert!(bound("") > only_active, "it is not said");
}

/// A block FF with a chart that its second step's condition calls F in, and a program that restarts it in each scan.
/// `settings`: those of the chart. `text`: the declarations of the block as text.
fn restarted(settings: &str, text: &str) -> String {
    let variable =
        |name: &str| format!("<variable name=\"{name}\"><type><BOOL/></type></variable>");
    let chart = chart("c.z", "F()");
    let function = "<pou name=\"F\" pouType=\"function\"><interface><returnType><BOOL/></returnType></interface><body><ST><p>F := TRUE;</p></ST></body></pou>";
    let data = of_codesys("sfcsettings", &format!("<SFCSettings>{settings}</SFCSettings>"))
        + &of_codesys(
            "interfaceasplaintext",
            &format!(
                "<InterfaceAsPlainText><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{text}</xhtml></InterfaceAsPlainText>"
            ),
        );
    let data = data.replace("</addData><addData>", "");
    let inputs = format!("<interface><inputVars>{}</inputVars>", variable("SFCReset"));
    vendors("", &chart, &st("f(SFCReset := TRUE);"))
        .replace("<pous>", &format!("<pous>{function}"))
        .replace(
            "<pou name=\"FF\" pouType=\"functionBlock\"><interface>",
            &format!("<pou name=\"FF\" pouType=\"functionBlock\">{inputs}"),
        )
        .replace(
            "</localVars></interface><body><SFC>",
            &format!("{}</localVars></interface><body><SFC>", variable("SFCInit")),
        )
        .replace("</SFC></body>", &format!("</SFC></body>{data}"))
}

/// A drawn chart of two steps that follow each other, with the conditions of its transitions.
fn chart(first: &str, second: &str) -> String {
    let transition = |id: &str, from: &str, condition: &str| {
        format!(
            "<transition localId=\"{id}\"><connectionPointIn><connection refLocalId=\"{from}\"/></connectionPointIn><condition><inline name=\"\"><ST><p>{condition}</p></ST></inline></condition></transition>"
        )
    };
    format!(
        "<SFC><step localId=\"1\" name=\"S0\" initialStep=\"true\"/>{}<step localId=\"3\" name=\"S1\"><connectionPointIn><connection refLocalId=\"2\"/></connectionPointIn></step>{}<jumpStep localId=\"5\" targetName=\"S0\"><connectionPointIn><connection refLocalId=\"4\"/></connectionPointIn></jumpStep></SFC>",
        transition("2", "1", first),
        transition("4", "3", second)
    )
}

#[test]
fn flags_control_a_chart_where_the_file_says_so_and_which_they_are() {
    let flags = "<Flags><Init Declare=\"true\" Use=\"true\"/><Reset Declare=\"true\" Use=\"true\"/></Flags>";
    let stated = format!(
        "<CalcActiveTransOnly>true</CalcActiveTransOnly><UseDefaults>false</UseDefaults>{flags}"
    );
    let declared = "FUNCTION_BLOCK FF VAR_INPUT SFCReset : BOOL; END_VAR VAR c : Cost4; END_VAR";
    let calls = |name: &str, settings: &str, text: &str| {
        bound(name, &restarted(settings, text), &only("CAL"))
    };
    // The call of FF alone: F is called in the second step.
    let restarts = calls("flags-stated.xml", &stated, declared);
    let ordinary = [
        // The settings of the project hold.
        (stated.replace("<UseDefaults>false", "<UseDefaults>true"), declared),
        (stated.replace("<UseDefaults>false</UseDefaults>", ""), declared),
        // The variables may be others than those that the tool declares.
        (stated.clone(), ""),
        (
            stated.clone(),
            "FUNCTION_BLOCK FF VAR_INPUT SFCReset : BOOL; END_VAR VAR c : Cost4; SFCInit : BOOL; END_VAR",
        ),
        // One flag has no effect.
        (
            stated.replace(
                "<Reset Declare=\"true\" Use=\"true\"",
                "<Reset Declare=\"true\" Use=\"false\"",
            ),
            declared,
        ),
    ];
    for (at, (settings, text)) in ordinary.iter().enumerate() {
        let calls = calls(&format!("flags-{at}.xml"), settings, text);
        assert_eq!(calls, restarts + 10_000, "{settings} {text}");
    }
}

#[test]
fn scans_of_charts_evaluate_all_conditions_where_the_file_says_so() {
    let lower = |settings: &str| {
        let data = of_codesys("sfcsettings", &format!("<SFCSettings>{settings}</SFCSettings>"));
        let text = program("b:BOOL", &chart("b", "b"))
            .replace("</body></pou></pous>", &format!("</body>{data}</pou></pous>"));
        let inputs = [Input { name: "e.xml".to_owned(), bytes: text.into_bytes() }];
        let (facts, table) = (Facts::default(), only("CLEAR"));
        let request = Request { table: Some(&table), ..Request::new(&inputs, &facts) };
        let found = audit(&request).unwrap_or_else(|failure| panic!("{failure:?}"));
        (found.bound.lower.0 / 1_000_000, found.bound.upper.0 / 1_000_000)
    };
    let all = "<CalcActiveTransOnly>false</CalcActiveTransOnly>";
    let own = "<UseDefaults>false</UseDefaults>";
    assert_eq!(lower(&format!("{all}{own}")), (20, 20));
    assert_eq!(lower(&format!("{}{own}", all.replace("false", "true"))), (10, 10));
    // The settings of the project, which are not in the file, may hold.
    assert_eq!(lower(all), (10, 20));
    assert_eq!(lower(&format!("{all}{}", own.replace("false", "true"))), (10, 20));
}

#[test]
fn private_methods_of_a_base_are_refused_where_another_has_the_name() {
    let method = |data: &str| {
        let body = st(";");
        format!(
            "<data name=\"http://www.3s-software.com/plcopenxml/method\"><Method name=\"m\"><interface>{data}</interface><body>{body}</body></Method></data>"
        )
    };
    let private = of_codesys("accessmodifiers", "<AccessModifiers Private=\"true\"/>");
    let project = |data: &str| {
        let derived = format!(
            "<pou name=\"GG\" pouType=\"functionBlock\"><interface><addData><data name=\"http://www.3s-software.com/plcopenxml/pouinheritance\"><Inheritance><Extends>FF</Extends></Inheritance></data></addData></interface><body>{}</body><addData>{}</addData></pou>",
            st("SUPER^();"),
            method("")
        );
        vendors("", &st("m();"), &st("f();"))
            .replace(
                "</body></pou><pou name=\"p\"",
                &format!(
                    "</body><addData>{}</addData></pou>{derived}<pou name=\"p\"",
                    method(data)
                ),
            )
            .replace("<derived name=\"FF\"/>", "<derived name=\"GG\"/>")
    };
    assert_eq!(checked("method-public.xml", &project("")).code, Some(0));
    let run = checked("method-private.xml", &project(&private));
    assert!(run.stderr.contains("m is also a PRIVATE method of a base"), "{}", run.stderr);
}

#[test]
fn a_file_that_only_its_header_ascribes_to_codesys_is_refused_where_tools_differ() {
    let header =
        "<fileHeader companyName=\"\" productName=\"CODESYS\" productVersion=\"1\"/><types>";
    let drawn = vendors("", &st(""), "<LD/>").replace("<types>", header);
    refused("header-drawn.xml", &drawn, "the file has no data of CODESYS");
    let text = vendors("", &st(""), &st("")).replace("<types>", header);
    assert_eq!(checked("header-text.xml", &text).code, Some(0));
    let other = drawn.replace("CODESYS", "other");
    assert_eq!(checked("header-other.xml", &other).code, Some(0));
}

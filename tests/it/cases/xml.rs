//! PLCopen XML: what stands in declarations and beside them, and what names no code.

use super::{Run, case, lower_ns, upper_ns};
use crate::command::binary;
use std::path::Path;

/// Runs the command on these files in a directory of their own, with the tables of the attack.
fn run(files: &[(&str, &str)], command: &str, arguments: &str) -> Run {
    let directory = tempfile::tempdir().expect("a directory");
    let place = |name: &str| directory.path().join(name);
    for name in ["zero.csv", "calls.toml"] {
        std::fs::copy(case("attack").join(name), place(name)).expect("a copy");
    }
    for (name, text) in files {
        let path = place(name);
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new("."))).expect("a directory");
        std::fs::write(path, text).expect("a file");
    }
    let programs = files.iter().map(|(name, _)| *name).filter(|name| !name.ends_with("toml"));
    let output = binary()
        .arg(command)
        .args(programs)
        .args(arguments.split_whitespace())
        .current_dir(directory.path())
        .output()
        .expect("the command runs");
    Run::of(&output)
}

/// A project of a block that takes 4 us and a program: declarations of types, variables, what stands beside them, and a
/// body.
fn project(types: &str, variables: &str, beside: &str, body: &str) -> String {
    format!(
        "<project xmlns=\"http://www.plcopen.org/xml/tc6_0200\"><types><dataTypes>{types}</dataTypes><pous>\
         <pou name=\"Cost4\" pouType=\"functionBlock\"><interface><inputVars><variable name=\"z\"><type><BOOL/></type></variable></inputVars></interface></pou>\
         <pou name=\"p\" pouType=\"program\"><interface><localVars><variable name=\"c\"><type><derived name=\"Cost4\"/></type></variable></localVars>{variables}</interface>{beside}<body>{body}</body></pou>\
         </pous></types><instances><configurations/></instances></project>"
    )
}

fn st(text: &str) -> String {
    format!("<ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{text}</xhtml></ST>")
}

fn constant(of: &str, initial: &str) -> String {
    format!(
        "<localVars constant=\"true\"><variable name=\"k\"><type>{of}</type><initialValue>{initial}</initialValue></variable></localVars>"
    )
}

/// The bounds of such a project in nanoseconds.
fn bounds(text: &str) -> (u64, u64) {
    let run = run(&[("p.xml", text)], "audit", "--table zero.csv --facts calls.toml --format json");
    assert_eq!(run.code, Some(0), "{text}\n{}", run.stderr);
    let report = run.json();
    (report["scan"]["lower_ps"].as_u64().expect("a time") / 1000, upper_ns(&report))
}

fn refused(text: &str, why: &str) {
    let run = run(&[("p.xml", text)], "audit", "--table zero.csv --facts calls.toml");
    assert_eq!(run.code, Some(2), "{text}\n{}", run.stdout);
    assert!(run.stderr.contains(why), "{text}\n{}", run.stderr);
}

#[test]
fn initial_values_are_read_wherever_they_stand() {
    let simple = |value: &str| format!("<simpleValue value=\"{value}\"/>");
    let array = "<array><dimension lower=\"0\" upper=\"2\"/><baseType><INT/></baseType></array>";
    let values = format!(
        "<arrayValue><value repetitionValue=\"2\">{}</value><value>{}</value></arrayValue>",
        simple("7"),
        simple("8")
    );
    for (of, initial, never) in [
        ("<INT/>", simple("5"), "k &lt;&gt; 5"),
        ("<INT/>", "5".to_owned(), "k &lt;&gt; 5"),
        ("<INT/>", " 5\n".to_owned(), "k &lt;&gt; 5"),
        (array, values, "k[0] &lt;&gt; 7 OR k[1] &lt;&gt; 7 OR k[2] &lt;&gt; 8"),
    ] {
        let body = st(&format!("IF {never} THEN c(); END_IF;"));
        let text = project("", &constant(of, &initial), "", &body);
        assert_eq!(bounds(&text), (0, 0), "{initial}");
    }
    // What cannot be read is some value.
    for initial in ["five plus", "", "<simpleValue value=\"5\"/>6", "<other value=\"5\"/>"] {
        let body = st("IF k &lt;&gt; 5 THEN c(); END_IF;");
        let text = project("", &constant("<INT/>", initial), "", &body);
        assert_eq!(bounds(&text), (0, 4000), "{initial}");
    }
    // Types give their variables values, too.
    let types = "<dataType name=\"n\"><baseType><INT/></baseType><initialValue><simpleValue value=\"5\"/></initialValue></dataType>";
    let variables = "<localVars constant=\"true\"><variable name=\"k\"><type><derived name=\"n\"/></type></variable></localVars>";
    let body = st("IF k &lt;&gt; 5 THEN c(); END_IF;");
    assert_eq!(bounds(&project(types, variables, "", &body)), (0, 0));
}

#[test]
fn attributes_and_declarations_as_text_are_read_or_refused() {
    let beside = |name: &str, inner: &str| {
        format!(
            "<addData><data name=\"http://www.3s-software.com/plcopenxml/{name}\" handleUnknown=\"implementation\">{inner}</data></addData>"
        )
    };
    let attribute = |name: &str| {
        beside(
            "attributes",
            &format!("<Attributes><Attribute Name=\"{name}\" Value=\"\"/></Attributes>"),
        )
    };
    let body = st("c();");
    assert_eq!(bounds(&project("", "", &attribute("qualified_only"), &body)), (4000, 4000));
    refused(&project("", "", &attribute("anything"), &body), "the attribute anything");
    let interface = |text: &str| {
        beside(
            "interfaceasplaintext",
            &format!(
                "<InterfaceAsPlainText><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{text}</xhtml></InterfaceAsPlainText>"
            ),
        )
    };
    let plain = |text: &str| {
        let variables =
            "<localVars><variable name=\"x\"><type><BOOL/></type></variable></localVars>";
        project("", variables, &interface(text), &st("IF x THEN c(); END_IF;"))
    };
    // The address is said there alone.
    let report = run(
        &[("p.xml", &plain("PROGRAM p VAR x AT %IX0.0 : BOOL; END_VAR"))],
        "audit",
        "--table zero.csv --facts calls.toml --trust all --format json",
    );
    assert_eq!(report.code, Some(0), "{}", report.stderr);
    assert_eq!(report.json()["scan"]["lower_kind"], "reached", "an input is free");
    refused(&plain("PROGRAM p VAR x AT : BOOL; END_VAR"), "p.xml:1");
    refused(&plain("PROGRAM p VAR CONSTANT x ; END_VAR"), "p.xml:1");
    // What says nothing that the elements do not say may be written in any form.
    assert_eq!(bounds(&plain("PROGRAM p VAR x ; END_VAR")).1, 4000);
}

#[test]
fn what_names_no_code_is_refused() {
    let step = "<step localId=\"1\" name=\"A\" initialStep=\"true\"><connectionPointIn><connection refLocalId=\"2\"/></connectionPointIn><connectionPointOut/><connectionPointOutAction/></step>";
    let way = "<transition localId=\"2\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn><connectionPointOut/><condition><inline><ST><p>TRUE</p></ST></inline></condition></transition>";
    let chart = |point: &str, action: &str| {
        let block = format!("<actionBlock localId=\"3\">{point}{action}</actionBlock>");
        project("", "", "", &format!("<SFC>{step}{way}{block}</SFC>"))
    };
    let point = "<connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn>";
    let inline = format!("<action qualifier=\"N\"><inline>{}</inline></action>", st("c();"));
    assert_eq!(bounds(&chart(point, &inline)).1, 4000);
    refused(&chart(point, "<action qualifier=\"N\"/>"), "it names no action");
    refused(&chart(point, "<action qualifier=\"N\"><inline/></action>"), "no code");
    refused(&chart("", &inline), "no step is connected to it");
    refused(&chart("<connectionPointIn/>", &inline), "no step is connected to it");
    let file = case("execute-box").join("execute-box.xml");
    let drawn = std::fs::read_to_string(file).expect("the case");
    let twice = drawn.replace("</STCode>", "</STCode><STCode xmlns=\"\">x := 1;</STCode>");
    let run = run(&[("p.xml", &twice)], "audit", "");
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert!(run.stderr.contains("structured text twice"), "{}", run.stderr);
}

#[test]
fn conditions_that_are_drawn_with_blocks_rest_on_no_reading_that_is_not_stated() {
    // The chart's timer is executed in each scan, or only while its first step is active.
    let text =
        std::fs::read_to_string(case("chart-timer").join("chart-timer.xml")).expect("the case");
    let audit = |facts: &str| {
        let files = [("p.xml", text.as_str()), ("f.toml", facts)];
        let run = run(&files, "audit", "--table iec --facts f.toml --trust all --format json");
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.json()
    };
    // What else controllers do in different ways.
    let other =
        "[controller]\n\"actions have no final scan\" = false\n[sfc]\naction_order = \"named\"\n";
    let (open, stated) = (audit(other), audit(&format!("{other}drawn_conditions = \"last-scan\"")));
    assert_eq!(upper_ns(&open), upper_ns(&stated));
    assert!(open.to_string().contains("drawn_conditions"), "the reading is named");
    let exact = |report: &serde_json::Value| report["scan"]["exact"].as_bool();
    assert_eq!((exact(&open), exact(&stated)), (Some(false), Some(true)));
    assert!(
        lower_ns(&open) <= lower_ns(&stated) - 2000,
        "the timer's own time counts only where it is stated"
    );
    assert_ne!(open["scan"]["lower_kind"], "reached");
    let wrong = run(
        &[("p.xml", &text), ("f.toml", "[sfc]\ndrawn_conditions = \"now\"")],
        "audit",
        "--facts f.toml",
    );
    assert_eq!(wrong.code, Some(2), "{}", wrong.stdout);
    assert!(wrong.stderr.contains("last-scan"), "{}", wrong.stderr);
}

#[test]
fn facts_name_files_of_one_name_with_their_directories() {
    let block = "FUNCTION_BLOCK B VAR x : BOOL; END_VAR\n{ f(); }\nEND_FUNCTION_BLOCK";
    let program = "PROGRAM p VAR b : B; i : INT; n AT %IW0 : INT; END_VAR\nb();\nWHILE i < n DO i := i + 1; END_WHILE;\nEND_PROGRAM";
    let files = |facts: &'static str| [("a/m.st", block), ("b/m.st", program), ("f.toml", facts)];
    let facts =
        "[calls]\n\"a/m.st:2\" = { time = \"5us\", writes = [] }\n[counts]\n\"b/m.st:3\" = [0, 3]";
    let good = run(&files(facts), "audit", "--facts f.toml");
    assert_eq!(good.code, Some(0), "{}", good.stderr);
    for facts in [
        "[calls]\n\"m.st:2\" = { time = \"5us\", writes = [] }\n[counts]\n\"b/m.st:3\" = [0, 3]",
        "[calls]\n\"a/m.st:2\" = { time = \"5us\", writes = [] }\n[counts]\n\"m.st:3\" = [0, 3]",
    ] {
        let bare = run(&files(facts), "audit", "--facts f.toml");
        assert_eq!(bare.code, Some(2), "{facts}: {}", bare.stdout);
    }
}

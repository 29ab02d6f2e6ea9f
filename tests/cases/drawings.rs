//! Drawings (FBD, LD, charts in XML), and bodies that no front reads.

use super::{Run, audit, case, scanbound, upper_ns};
use std::path::PathBuf;

/// Writes a file for one test; its path, without blanks.
fn written(name: &str, text: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

/// A project with a block `Cost4` that takes 4 us, a block `FF`, further parts of `FF`, and a program's body.
fn vendors(parts: &str, of_block: &str, body: &str) -> String {
    let variable =
        |name: &str, of: &str| format!("<variable name=\"{name}\"><type>{of}</type></variable>");
    let cost = variable("c", "<derived name=\"Cost4\"/>");
    let own = variable("f", "<derived name=\"FF\"/>") + &variable("b", "<BOOL/>");
    format!(
        "<project xmlns=\"http://www.plcopen.org/xml/tc6_0200\"><types><dataTypes/><pous>\
         <pou name=\"Cost4\" pouType=\"functionBlock\"><interface><inputVars>{}</inputVars></interface></pou>\
         <pou name=\"FF\" pouType=\"functionBlock\"><interface><localVars>{cost}</localVars></interface>{parts}<body>{of_block}</body></pou>\
         <pou name=\"p\" pouType=\"program\"><interface><localVars>{cost}{own}</localVars></interface><body>{body}</body></pou>\
         </pous></types><instances><configurations/></instances></project>",
        variable("z", "<BOOL/>")
    )
}

fn st(text: &str) -> String {
    format!("<ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{text}</xhtml></ST>")
}

/// `check --limit 1us` with the tables of the attack.
fn checked(name: &str, text: &str) -> Run {
    let path = written(name, text);
    let path = path.display();
    let facts = "--table zero.csv --facts calls.toml --limit 1us";
    scanbound("attack", &format!("check {path} {facts} --format json"))
}

/// Refused because of what is not read, with the place.
fn refused(name: &str, text: &str, why: &str) {
    let run = checked(name, text);
    assert_eq!(run.code, Some(2), "{name}: {}{}", run.stdout, run.stderr);
    assert!(run.stderr.contains(why), "{name}: {}", run.stderr);
    assert!(run.stderr.contains(&format!("{name}:1")), "{name}: {}", run.stderr);
}

#[test]
fn bodies_in_languages_that_are_not_read_prove_nothing() {
    for file in ["xml-act-cfc.xml", "xml-cfc-el.xml", "xml-cfc-real.xml"] {
        let arguments = format!("check {file} --table zero.csv --facts calls.toml --limit 1us");
        let run = scanbound("attack", &arguments);
        assert_eq!(run.code, Some(2), "{file}: {}", run.stdout);
        assert!(run.stderr.contains("not read"), "{file}: {}", run.stderr);
    }
    let cfc = "<CFC><block localId=\"2\" typeName=\"Cost4\" instanceName=\"c\"/></CFC>";
    let data = format!(
        "<addData><data name=\"http://www.3s-software.com/plcopenxml/cfc\">{cfc}</data></addData>"
    );
    let empty = "<ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\"/></ST>";
    let calls = st("f();");
    for (number, body) in
        [cfc.to_owned(), format!("{empty}{data}"), data.clone()].iter().enumerate()
    {
        let name = |place: &str| format!("cfc-{place}-{number}.xml");
        refused(&name("block"), &vendors("", body, &calls), "not read");
        let action = format!("<actions><action name=\"A\"><body>{body}</body></action></actions>");
        refused(&name("action"), &vendors(&action, empty, &calls), "not read");
        let way = format!(
            "<transitions><transition name=\"T\"><body>{body}</body></transition></transitions>"
        );
        refused(&name("transition"), &vendors(&way, empty, &calls), "FF");
        let member = |inner: &str| {
            format!(
                "<addData><data name=\"http://www.3s-software.com/plcopenxml/{inner}</data></addData>"
            )
        };
        let method = member(&format!(
            "method\"><Method name=\"M\"><interface/><body>{body}</body></Method>"
        ));
        refused(&name("method"), &vendors(&method, empty, &calls), "not read");
        let property = member(&format!(
            "property\"><Property name=\"P\"><interface/><GetAccessor><interface/><body>{body}</body></GetAccessor></Property>"
        ));
        refused(&name("property"), &vendors(&property, empty, &calls), "not read");
        // An action of a chart's step, and the condition behind it.
        let step = "<step localId=\"1\" name=\"s\" initialStep=\"true\"/>";
        let inline = format!(
            "<SFC>{step}<actionBlock localId=\"2\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn><action><inline>{body}</inline></action></actionBlock></SFC>"
        );
        refused(&name("inline"), &vendors("", empty, &inline), "not read");
    }
}

#[test]
fn what_vendors_add_to_a_unit_proves_nothing() {
    let run = scanbound("attack", "audit xml-vendor.xml --table zero.csv");
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert!(run.stderr.contains("vendorElement with localId 90"), "{}", run.stderr);
    let drawn = |more: &str| {
        let rail = "<leftPowerRail localId=\"1\"><connectionPointOut/></leftPowerRail>";
        let coil = "<coil localId=\"3\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn><variable>b</variable></coil>";
        vendors("", &st(""), &format!("<LD>{rail}{coil}{more}</LD>"))
    };
    let text = "<alternativeText><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">c();</xhtml></alternativeText>";
    refused(
        "vendor-bare.xml",
        &drawn(&format!("<vendorElement localId=\"9\">{text}</vendorElement>")),
        "vendorElement",
    );
    let of_type = |of: &str| {
        drawn(&format!(
            "<vendorElement localId=\"9\">{text}<addData><data name=\"http://www.3s-software.com/plcopenxml/fbdelementtype\"><ElementType xmlns=\"\">{of}</ElementType></data></addData></vendorElement>"
        ))
    };
    refused("vendor-composer.xml", &of_type("composer"), "vendorElement");
    assert_eq!(checked("vendor-title.xml", &of_type("networktitle")).code, Some(0));
    let wired = "<inputVariables><variable formalParameter=\"EN\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn></variable></inputVariables>";
    let titled =
        of_type("networktitle").replace("</vendorElement>", &format!("{wired}</vendorElement>"));
    refused("vendor-wired.xml", &titled, "<inputVariables>");
    let data = |text: &str| {
        format!("<addData><data name=\"http://vendor.example/run\">{text}</data></addData>")
    };
    refused("vendor-data.xml", &drawn(&data("<run>c();</run>")), "http://vendor.example/run");
    refused("vendor-text.xml", &drawn(&data("c();")), "http://vendor.example/run");
    let coil = drawn("").replace("</coil>", &format!("{}</coil>", data("<run/>")));
    refused("vendor-coil.xml", &coil, "coil with localId 3");
    refused("vendor-element.xml", &drawn("<script localId=\"8\">c();</script>"), "<script>");
    refused("vendor-unit.xml", &vendors("<methods/>", &st(""), &st("")), "<methods>");
    refused("vendor-body.xml", &vendors("", &st(""), "c();"), "text stands in it");
    refused("vendor-st.xml", &vendors("", "", &st("<script>c();</script>")), "<script>");
    // What two elements say of which one is read.
    let twice = vendors("<actions/><actions/>", "", &st(""));
    refused("vendor-twice.xml", &twice, "twice");
    // Numbers of objects, and nothing.
    let harmless = "<addData><data name=\"http://www.3s-software.com/plcopenxml/objectid\"><ObjectId>1</ObjectId></data><data name=\"http://vendor.example/x\"/></addData>";
    assert_eq!(checked("vendor-harmless.xml", &vendors(harmless, "", &st(""))).code, Some(0));
}

#[test]
fn paragraphs_and_breaks_end_lines_of_text() {
    let arguments =
        "check xml-st-br.xml --table zero.csv --facts calls.toml --limit 1us --format json";
    let run = scanbound("attack", arguments);
    assert_eq!((run.code, upper_ns(&run.json())), (Some(1), 4_000), "{}", run.stdout);
    for (name, text) in [
        ("br.xml", "// x<br/>c();"),
        ("br-two.xml", "// x<br></br>// y<br/>c();"),
        ("p.xml", "<p>// x</p><p>c();</p>"),
        ("div.xml", "// x<div>c();</div>"),
        ("behind.xml", "<p>// x</p>c();"),
        ("span.xml", "c<span>()</span>;"),
    ] {
        let run = checked(name, &vendors("", "", &st(text)));
        assert_eq!(run.code, Some(1), "{name}: {}{}", run.stdout, run.stderr);
    }
    let list = vendors("", "", "<IL><p>LD TRUE</p><p>ST b</p><p>CAL c()</p></IL>");
    assert_eq!(checked("il.xml", &list).code, Some(1));
    // What no line ends is behind the comment.
    let behind = vendors("", "", &st("// x<span>c();</span>"));
    assert_eq!(checked("comment.xml", &behind).code, Some(0));
}

#[test]
fn boxes_with_structured_text_are_carried_out() {
    let text = upper_ns(&audit("execute-box", "execute-box.st"));
    assert_eq!(text, 1_152_700);
    let text = text - 100;
    for arguments in [
        "execute-box.xml",
        "execute-box.xml execute-lib.xml",
        "execute-box.xml --facts execute.toml",
        "execute-box.xml execute-lib.xml --facts execute.toml",
    ] {
        assert_eq!(upper_ns(&audit("execute-box", arguments)), text, "{arguments}");
    }
    let file = case("execute-box").join("execute-box.xml");
    let drawn = std::fs::read_to_string(file).expect("the case");
    let bound = |name: &str, text: &str| {
        let path = written(name, text);
        upper_ns(&audit("execute-box", &path.display().to_string()))
    };
    // OpenPLC writes it under its own name.
    let other =
        drawn.replace("www.3s-software.com/plcopenxml/stcode", "openplc.org/plcopenxml/stcode");
    assert!(bound("execute-openplc.xml", &other) >= text);
    // Without a wire at EN it always runs.
    let begin = drawn.find("<inputVariables>").expect("pins");
    let end = drawn.find("</inputVariables>").expect("pins");
    let mut always = drawn.clone();
    always.replace_range(begin..end, "<inputVariables>");
    assert!(bound("execute-always.xml", &always) > 1_152_000);
    let says = |name: &str, text: &str, why: &str| {
        let path = written(name, text);
        let run =
            scanbound("execute-box", &format!("audit {} --facts execute.toml", path.display()));
        assert_eq!(run.code, Some(2), "{name}: {}", run.stdout);
        assert!(run.stderr.contains(why), "{name}: {}", run.stderr);
    };
    says("execute-other.xml", &drawn.replace("\"EXECUTE\"", "\"FOO\""), "no EXECUTE box");
    says("execute-return.xml", &drawn.replace("END_FOR", "END_FOR RETURN;"), "RETURN");
    says("execute-wrong.xml", &drawn.replace("END_FOR", "END_FOO"), "execute-wrong.xml:22");
    says("execute-pin.xml", &drawn.replace("\"ENO\"", "\"Q\""), "other pins");
}

#[test]
fn drawings_and_texts_of_any_size_end_with_a_message() {
    let script = case("attack").join("ld-chain.py");
    let Ok(made) = std::process::Command::new("python3").arg(script).output() else { return };
    let chain = written("ld-chain.xml", &String::from_utf8_lossy(&made.stdout));
    let run = scanbound("attack", &format!("audit {}", chain.display()));
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    assert!(run.stderr.contains("stand in a row"), "{}", run.stderr);
    let blocks = |count: u32| {
        let block = |id: u32| {
            let pin = format!("<connection refLocalId=\"{}\"/>", id - 1);
            format!(
                "<block localId=\"{id}\" typeName=\"NOT\"><inputVariables><variable formalParameter=\"IN\"><connectionPointIn>{pin}</connectionPointIn></variable></inputVariables><inOutVariables/><outputVariables><variable formalParameter=\"OUT\"><connectionPointOut/></variable></outputVariables></block>"
            )
        };
        let all: String = (2..count + 2).map(block).collect();
        let last = count + 1;
        let end = format!(
            "<outVariable localId=\"{}\"><connectionPointIn><connection refLocalId=\"{last}\"/></connectionPointIn><expression>b</expression></outVariable>",
            last + 1
        );
        let begin = "<inVariable localId=\"1\"><expression>b</expression></inVariable>";
        vendors("", "", &format!("<FBD>{begin}{all}{end}</FBD>"))
    };
    refused("fbd-chain.xml", &blocks(10_000), "stand in a row");
    assert_eq!(checked("fbd-row.xml", &blocks(140)).code, Some(0));
    let spaces = "<e xmlns:n=\"u\">".repeat(3_000) + &"</e>".repeat(3_000);
    refused("spaces.xml", &vendors(&spaces, "", &st("")), "name spaces");
}

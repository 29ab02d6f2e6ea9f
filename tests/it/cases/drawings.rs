//! Drawings (FBD, LD, charts in XML), and bodies that no front reads.

use super::{Run, audit, case, lower_ns, scanbound, upper_ns};
use crate::command::binary;
use common::model_bound::model_bounds;
use scanbound::audit::{Failure, Request};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::timing::table::{CLASSES, Table};
use std::path::PathBuf;

/// Writes a file for one test; its path, without blanks.
pub(super) fn written(name: &str, text: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

/// A project with a block `Cost4` that takes 4 us, a block `FF`, further parts of `FF`, and a program's body.
pub(super) fn vendors(parts: &str, of_block: &str, body: &str) -> String {
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

pub(super) fn st(text: &str) -> String {
    format!("<ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{text}</xhtml></ST>")
}

/// `check --limit 1us` with the tables of the attack.
pub(super) fn checked(name: &str, text: &str) -> Run {
    let path = written(name, text);
    let path = path.display();
    let facts = "--table zero.csv --facts calls.toml --limit 1us";
    scanbound("attack", &format!("check {path} {facts} --format json"))
}

/// Refused because of what is not read, with the place.
pub(super) fn refused(name: &str, text: &str, why: &str) {
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
    refused("vendor-body.xml", &vendors("", &st(""), "c();"), "it contains text");
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
    // The contact leads to nothing then.
    let begin = always.find("<contact").expect("a contact");
    let end = always.find("</contact>").expect("a contact") + "</contact>".len();
    always.replace_range(begin..end, "");
    assert!(bound("execute-always.xml", &always) > 1_152_000);
    let says = |name: &str, text: &str, why: &str| {
        let path = written(name, text);
        let run =
            scanbound("execute-box", &format!("audit {} --facts execute.toml", path.display()));
        assert_eq!(run.code, Some(2), "{name}: {}", run.stdout);
        assert!(run.stderr.contains(why), "{name}: {}", run.stderr);
    };
    says("execute-other.xml", &drawn.replace("\"EXECUTE\"", "\"FOO\""), "not an EXECUTE box");
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
    assert!(run.stderr.contains("in series"), "{}", run.stderr);
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
    refused("fbd-chain.xml", &blocks(10_000), "in series");
    assert_eq!(checked("fbd-row.xml", &blocks(140)).code, Some(0));
    let spaces = "<e xmlns:n=\"u\">".repeat(3_000) + &"</e>".repeat(3_000);
    refused("spaces.xml", &vendors(&spaces, "", &st("")), "namespaces");
}

/// A table in which this row takes 10 us, and nothing else takes anything.
pub(super) fn only(row: &str) -> Table {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES.iter().filter(|class| **class != row) {
        rows += &format!("@{class},0,0\n");
    }
    let class = if CLASSES.contains(&row) { "@" } else { "" };
    rows += &format!("{class}{row},10,10\n");
    if row != "end" {
        rows += "@end,0,\n";
    }
    Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table
}

/// What a drawing or a text may be charged for.
const ROWS: &[&str] = &[
    "LD",
    "ST",
    "AND",
    "OR",
    "XOR",
    "NOT",
    "ADD",
    "SUB",
    "GT",
    "EQ",
    "SEL",
    "MAX",
    "FUNCTION",
    "JMP",
    "CAL",
    "RET",
    "TON",
    "R_TRIG",
    "F_TRIG",
    "SR",
    "RS",
    "CTU",
    "S",
    "R",
    "INIT",
    "STEP",
    "TRANSITION",
    "CLEAR",
    "ACTION",
    "CONVERT",
    "MOVE",
    "PROGRAM",
];

/// The bound of a text or a drawing in nanoseconds, by a table.
pub(super) fn bound(name: &str, text: &str, table: &Table) -> u64 {
    let inputs = [Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request { table: Some(table), ..Request::new(&inputs, &facts) };
    match scanbound::audit::audit(&request) {
        Ok(found) => found.bound.upper.0 / 1000,
        Err(Failure::Input(faults)) => panic!("{faults:#?}\n{text}"),
        Err(other) => panic!("{other:?}\n{text}"),
    }
}

/// Whether a drawing and the text that generators write of it are charged alike, whatever an instruction takes.
fn alike(drawing: &str, text: &str) {
    let rows: Vec<&str> = ROWS.iter().copied().chain(CLASSES).collect();
    let tables: Vec<Table> = rows.iter().map(|row| only(row)).collect();
    let drawn = model_bounds("d.xml", drawing, &tables);
    for ((row, drawn), written) in rows.iter().zip(&drawn).zip(model_bounds("t.st", text, &tables))
    {
        assert_eq!(*drawn, written, "{row}\n{text}\n{drawing}");
    }
    let charged = drawn.iter().filter(|drawn| drawn.0 > 0).count();
    assert!(charged > 2, "{text}");
}

fn read_case(name: &str) -> String {
    std::fs::read_to_string(case(name)).expect("the case")
}

/// Elements of a drawing: `a` a variable that is read, `> a` one that is written, `AND 1 2` a function of these
/// elements, `t:TON IN=1 PT=2` an instance, `EN=3` its pin of that name, `5.Q` an output, `[a] 1` a contact, `(a) 1` a
/// coil, `|` the left rail.
fn elements(all: &[&str], numbers: &[u32]) -> String {
    let from = |text: &str| {
        let (id, output) = text.split_once('.').map_or((text, String::new()), |(id, output)| {
            (id, format!(" formalParameter=\"{output}\""))
        });
        format!("<connection refLocalId=\"{id}\"{output}/>")
    };
    let into = |text: &str| format!("<connectionPointIn>{}</connectionPointIn>", from(text));
    let element = |(at, text): (usize, &&str)| {
        let id = at + 1;
        let number = numbers.get(at).filter(|number| **number > 0);
        let number =
            number.map_or(String::new(), |number| format!(" executionOrderId=\"{number}\""));
        let head =
            format!("localId=\"{id}\"{number}><position x=\"{}\" y=\"{}\"/>", id * 50, id * 200);
        let words: Vec<&str> = text.split(' ').collect();
        match words[..] {
            ["|"] => format!("<leftPowerRail {head}<connectionPointOut/></leftPowerRail>"),
            [one] => format!(
                "<inVariable {head}<connectionPointOut/><expression>{one}</expression></inVariable>"
            ),
            [">", of, source] => format!(
                "<outVariable {head}{}<expression>{of}</expression></outVariable>",
                into(source)
            ),
            [of, source] if of.starts_with('[') => format!(
                "<contact {head}{}<connectionPointOut/><variable>{}</variable></contact>",
                into(source),
                of.trim_matches(['[', ']'])
            ),
            [of, source] if of.starts_with('(') => format!(
                "<coil {head}{}<connectionPointOut/><variable>{}</variable></coil>",
                into(source),
                of.trim_matches(['(', ')'])
            ),
            [of, ref given @ ..] => {
                let (instance, of) =
                    of.split_once(':').map_or((String::new(), of), |(name, of)| {
                        (format!(" instanceName=\"{name}\""), of)
                    });
                let has_enable = given.iter().any(|one| one.starts_with("EN="));
                let is_single = given.len() - usize::from(has_enable) == 1;
                let pin = |(at, one): (usize, &&str)| {
                    let (name, source) = one.split_once('=').map_or_else(
                        || {
                            (
                                if is_single {
                                    "IN".to_owned()
                                } else {
                                    format!("IN{}", at + 1 - usize::from(has_enable))
                                },
                                *one,
                            )
                        },
                        |(name, source)| (name.to_owned(), source),
                    );
                    format!("<variable formalParameter=\"{name}\">{}</variable>", into(source))
                };
                let pins: String = given.iter().enumerate().map(pin).collect();
                let mut outputs: Vec<&str> = match of {
                    "TON" => vec!["Q", "ET"],
                    "CTU" => vec!["Q", "CV"],
                    "SR" | "RS" => vec!["Q1"],
                    "R_TRIG" => vec!["Q"],
                    _ => vec!["OUT"],
                };
                if has_enable {
                    outputs.insert(0, "ENO");
                }
                let outputs: String = outputs
                    .iter()
                    .map(|name| {
                        format!(
                            "<variable formalParameter=\"{name}\"><connectionPointOut/></variable>"
                        )
                    })
                    .collect();
                let head = head.replacen('>', &format!(" typeName=\"{of}\"{instance}>"), 1);
                format!(
                    "<block {head}<inputVariables>{pins}</inputVariables><inOutVariables/><outputVariables>{outputs}</outputVariables></block>"
                )
            }
            [] => String::new(),
        }
    };
    all.iter().enumerate().map(element).collect()
}

/// A program with variables `name:TYPE` and a body.
pub(super) fn program(variables: &str, body: &str) -> String {
    let variable = |(name, of): (&str, &str)| {
        let of = match of {
            "BOOL" | "INT" | "TIME" | "WORD" => format!("<{of}/>"),
            _ => format!("<derived name=\"{of}\"/>"),
        };
        format!("<variable name=\"{name}\"><type>{of}</type></variable>")
    };
    let all: String =
        variables.split(' ').filter_map(|one| one.split_once(':')).map(variable).collect();
    format!(
        "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><dataTypes/><pous><pou name=\"Main\" pouType=\"program\"><interface><localVars>{all}</localVars></interface><body>{body}</body></pou></pous></types><instances><configurations/></instances></project>"
    )
}

fn in_text(variables: &str, more: &str, body: &str) -> String {
    let all: String = format!("{variables} {more}")
        .split(' ')
        .filter_map(|one| one.split_once(':'))
        .map(|(name, of)| format!("{name} : {of}; "))
        .collect();
    format!("PROGRAM Main\nVAR {all}END_VAR\n{body}\nEND_PROGRAM\n")
}

/// Drawings, the variables of both forms, those of the text alone, and the text that generators write.
const PAIRS: &[(&str, &[&str], &str, &str, &str)] = &[
    // A function block's input, and the result of a function behind it.
    (
        "FBD",
        &["run", "AND 1 5.OUT", "T#1s", "t:TON IN=2.OUT PT=3", "NOT 4.Q", "> lamp 5.OUT"],
        "run:BOOL lamp:BOOL t:TON",
        "r2:BOOL r5:BOOL",
        "r2 := run AND r5; t(IN := r2, PT := T#1s); r5 := NOT(t.Q); lamp := r5;",
    ),
    // Functions alone.
    (
        "FBD",
        &["run", "AND 1 3.OUT", "OR 1 2.OUT", "> lamp 3.OUT"],
        "run:BOOL lamp:BOOL",
        "r2:BOOL r3:BOOL",
        "r2 := run AND r3; r3 := run OR r2; lamp := r3;",
    ),
    // The complement of a word.
    ("FBD", &["w", "NOT 1", "> v 2.OUT"], "w:WORD v:WORD", "r2:WORD", "r2 := NOT(w); v := r2;"),
    // A number that adds up.
    (
        "FBD",
        &["up", "ADD 1 2.OUT", "> sum 2.OUT"],
        "up:INT sum:INT",
        "r2:INT",
        "r2 := up + r2; sum := r2;",
    ),
    // A comparison within the loop, and a choice.
    (
        "FBD",
        &["n", "GT 1 4.OUT", "limit", "SEL G=2.OUT IN0=1 IN1=3", "> m 4.OUT"],
        "n:INT limit:INT m:INT",
        "r2:BOOL r4:INT",
        "r2 := n > r4; r4 := SEL(r2, n, limit); m := r4;",
    ),
    // Two loops through one block.
    (
        "FBD",
        &["a", "AND 1 4.OUT", "OR 1 4.OUT", "XOR 2.OUT 3.OUT", "> x 4.OUT"],
        "a:BOOL x:BOOL",
        "r2:BOOL r3:BOOL r4:BOOL",
        "r2 := a AND r4; r3 := a OR r4; r4 := r2 XOR r3; x := r4;",
    ),
    // Two loops apart.
    (
        "FBD",
        &[
            "a",
            "AND 1 3.OUT",
            "NOT 2.OUT",
            "> x 3.OUT",
            "b",
            "OR 5 7.OUT",
            "NOT 6.OUT",
            "> y 7.OUT",
        ],
        "a:BOOL b:BOOL x:BOOL y:BOOL",
        "r2:BOOL r3:BOOL r6:BOOL r7:BOOL",
        "r2 := a AND r3; r3 := NOT(r2); x := r3; r6 := b OR r7; r7 := NOT(r6); y := r7;",
    ),
    // Instances that feed each other: what they put out stays where it is.
    (
        "FBD",
        &["a", "f:SR S1=1 R=3.Q1", "g:RS S=2.Q1 R1=1", "> x 3.Q1"],
        "a:BOOL x:BOOL f:SR g:RS",
        "",
        "f(S1 := a, R := g.Q1); g(S := f.Q1, R1 := a); x := g.Q1;",
    ),
    // Through contacts, to a coil.
    (
        "LD",
        &["|", "[a] 1", "AND 2 5.OUT", "[b] 3.OUT", "OR 4 2", "(x) 5.OUT"],
        "a:BOOL b:BOOL x:BOOL",
        "r3:BOOL r5:BOOL",
        "r3 := a AND r5; r5 := (r3 AND b) OR a; x := r5;",
    ),
    // What leads back goes through a contact.
    (
        "LD",
        &["|", "[a] 1", "AND 2 4", "[b] 3.OUT", "(x) 4"],
        "a:BOOL b:BOOL x:BOOL",
        "r3:BOOL",
        "r3 := a AND (r3 AND b); x := r3 AND b;",
    ),
    // The result is fed back to EN, and ENO on.
    (
        "FBD",
        &["n", "m", "GT EN=5.OUT 1 2", "b", "OR 4 3.ENO", "> x 5.OUT"],
        "n:INT m:INT b:BOOL x:BOOL",
        "r3:BOOL e3:BOOL r5:BOOL",
        "r3 := GT(EN := r5, IN1 := n, IN2 := m, ENO => e3); r5 := b OR e3; x := r5;",
    ),
    // Nothing is fed back.
    (
        "FBD",
        &["a", "n", "m", "MAX EN=1 2 3", "> k 4.OUT", "> y 4.ENO"],
        "a:BOOL n:INT m:INT k:INT y:BOOL",
        "r4:INT e4:BOOL",
        "r4 := MAX(EN := a, IN1 := n, IN2 := m, ENO => e4); IF e4 THEN k := r4; END_IF; IF e4 THEN y := e4; END_IF;",
    ),
    (
        "FBD",
        &["n", "m", "ADD 1 2", "MAX 3.OUT 1", "> k 4.OUT", "> l 3.OUT"],
        "n:INT m:INT k:INT l:INT",
        "r3:INT r4:INT",
        "r3 := n + m; r4 := MAX(r3, n); k := r4; l := r3;",
    ),
    (
        "LD",
        &["|", "[a] 1", "[b] 2", "(x) 3", "(y) 3"],
        "a:BOOL b:BOOL x:BOOL y:BOOL",
        "",
        "x := a AND b; y := a AND b;",
    ),
    (
        "FBD",
        &["a", "c:CTU CU=1 R=3 PV=4", "NOT 2.Q", "n", "> x 3"],
        "a:BOOL x:BOOL n:INT c:CTU",
        "r3:BOOL",
        "c(CU := a, R := r3, PV := n); r3 := NOT(c.Q); x := r3;",
    ),
];

#[test]
fn drawings_cost_what_the_text_costs_that_generators_write() {
    for (language, drawn, variables, more, text) in PAIRS {
        let text = in_text(variables, more, text);
        let drawing = |numbers: &[u32]| {
            program(variables, &format!("<{language}>{}</{language}>", elements(drawn, numbers)))
        };
        alike(&drawing(&[]), &text);
        // In the other order of the file, and on the page.
        let turned: Vec<String> = {
            let count = drawn.len();
            let renumbered = |text: &str| {
                let number = |word: &str| {
                    let (name, source) =
                        word.split_once('=').map_or(("", word), |(name, source)| (name, source));
                    let (id, output) =
                        source.split_once('.').map_or((source, ""), |(id, output)| (id, output));
                    let Ok(id) = id.parse::<usize>() else { return word.to_owned() };
                    let dot = if output.is_empty() { "" } else { "." };
                    let sign = if name.is_empty() { "" } else { "=" };
                    format!("{name}{sign}{}{dot}{output}", count + 1 - id)
                };
                let mut words = text.split(' ');
                let first = words.next().unwrap_or_default().to_owned();
                std::iter::once(first).chain(words.map(number)).collect::<Vec<_>>().join(" ")
            };
            drawn.iter().rev().map(|one| renumbered(one)).collect()
        };
        let turned: Vec<&str> = turned.iter().map(String::as_str).collect();
        let other = format!("<{language}>{}</{language}>", elements(&turned, &[]));
        alike(&program(variables, &other), &text);
    }
}

#[test]
fn a_set_or_reset_coil_costs_no_less_than_the_text_or_its_row() {
    let elements = elements(&["|", "[a] 1", "(x) 2"], &[]);
    for (storage, row, value) in [("set", "S", "TRUE"), ("reset", "R", "FALSE")] {
        let coil = elements.replace("<coil", &format!("<coil storage=\"{storage}\""));
        let drawing = program("a:BOOL x:BOOL", &format!("<LD>{coil}</LD>"));
        let text = in_text("a:BOOL x:BOOL", "", &format!("IF a THEN x := {value}; END_IF;"));
        let tables: Vec<Table> = ROWS.iter().copied().chain(CLASSES).map(only).collect();
        let drawn = model_bounds("d.xml", &drawing, &tables);
        for (drawn, written) in drawn.iter().zip(model_bounds("t.st", &text, &tables)) {
            assert!(*drawn >= written, "{storage}");
        }
        assert_eq!(bound("d.xml", &drawing, &only(row)), 10_000);
        let generated = bound("t.st", &text, &only("JMP"));
        assert!(generated > 0);
        assert_eq!(bound("d.xml", &drawing, &only("JMP")), generated);
    }
}

/// The bound of a drawing and of the text that generators write of it, if copies of strings alone take time.
fn copies(drawing: &str, text: &str) -> (u64, u64) {
    let table = Table::parse(
        "t.csv",
        (CLASSES.iter().fold("instruction,on_us,off_us\n".to_owned(), |rows, class| {
            rows + &format!("@{class},0,\n")
        }) + "COPY_TEXT,10,10\n")
            .as_bytes(),
    );
    let table = table.unwrap_or_else(|faults| panic!("{faults:?}")).table;
    (bound("d.xml", drawing, &table), bound("t.st", text, &table))
}

#[test]
fn texts_that_a_drawn_function_gives_are_copied_in_full() {
    let function = "<pou name=\"F\" pouType=\"function\"><interface><returnType><BOOL/></returnType><inputVars><variable name=\"a\"><type><BOOL/></type></variable></inputVars><outputVars><variable name=\"o\"><type><string/></type></variable></outputVars></interface><body><ST><p>F := a;</p></ST></body></pou>";
    let block = "<block localId=\"2\" typeName=\"F\"><position x=\"0\" y=\"20\"/><inputVariables><variable formalParameter=\"a\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn></variable></inputVariables><inOutVariables/><outputVariables><variable formalParameter=\"OUT\"><connectionPointOut/></variable><variable formalParameter=\"o\"><connectionPointOut/></variable></outputVariables></block>";
    let body = elements(&["a"], &[]) + block;
    let drawing = program("a:BOOL", &format!("<FBD>{body}</FBD>"))
        .replace("<pous>", &format!("<pous>{function}"));
    let text = "FUNCTION F : BOOL VAR_INPUT a : BOOL; END_VAR VAR_OUTPUT o : STRING; END_VAR F := a; END_FUNCTION\n".to_owned()
        + &in_text("a:BOOL", "r:BOOL s:STRING", "r := F(a := a, o => s);");
    let (drawn, written) = copies(&drawing, &text);
    assert!(drawn == written && written > 10_000, "{drawn} {written}");
}

#[test]
fn feedback_is_loaded_and_stored_as_in_text() {
    for case in ["feedback-load/feedback-load", "feedback-20us/feedback-20us"] {
        alike(&read_case(&format!("{case}.xml")), &read_case(&format!("{case}.st")));
    }
    for (file, arguments, bound) in [
        ("feedback-load.xml", "", 55_200),
        ("feedback-load.xml", "--time LD=10us", 104_700),
        ("feedback-load.st", "--time LD=10us", 104_700),
    ] {
        let report = audit("feedback-load", &format!("{file} {arguments}"));
        assert_eq!((upper_ns(&report), lower_ns(&report)), (bound, bound), "{file} {arguments}");
    }
    for file in ["feedback-20us.xml", "feedback-20us.st"] {
        let report = audit("feedback-20us", file);
        assert_eq!((upper_ns(&report), lower_ns(&report)), (55_800, 55_800), "{file}");
    }
    // By numbers the inverter comes first, and takes what the scan before left.
    let drawn = ["run", "AND 1 3.OUT", "NOT 2.OUT", "> lamp 3.OUT"];
    let variables = "run:BOOL lamp:BOOL";
    for numbers in [[0, 2, 1, 3], [0, 1, 2, 3]] {
        let drawing = program(variables, &format!("<FBD>{}</FBD>", elements(&drawn, &numbers)));
        let text =
            in_text(variables, "r2:BOOL r3:BOOL", "r3 := NOT(r2); r2 := run AND r3; lamp := r3;");
        alike(&drawing, &text);
    }
}

#[test]
fn results_in_functions_begin_anew_with_each_call() {
    let drawn = ["a", "NOT 1", "AND 1 2.OUT", "> F 3.OUT"];
    let function = format!(
        "<pou name=\"F\" pouType=\"function\"><interface><returnType><BOOL/></returnType><inputVars><variable name=\"a\"><type><BOOL/></type></variable></inputVars></interface><body><FBD>{}</FBD></body></pou>",
        elements(&drawn, &[])
    );
    let body = "<ST><p>x := F(x);</p></ST>";
    let drawing = program("x:BOOL", body).replace("<pous>", &format!("<pous>{function}"));
    let text = "FUNCTION F : BOOL VAR_INPUT a : BOOL; END_VAR VAR r2, r3 : BOOL; END_VAR\nr2 := NOT(a); r3 := a AND r2; F := r3;\nEND_FUNCTION\n".to_owned()
        + &in_text("x:BOOL", "", "x := F(x);");
    alike(&drawing, &text);
    // A ring of two: each result has one variable.
    let ring = ["a", "XOR 1 3.OUT", "AND 1 2.OUT", "> F 3.OUT"];
    let body = |drawn: &[&str]| elements(drawn, &[]);
    let drawing = drawing.replace(&body(&drawn), &body(&ring));
    let text = text.replace("r2 := NOT(a); r3 := a AND r2;", "r2 := a XOR r3; r3 := a AND r2;");
    alike(&drawing, &text);
}

#[test]
fn blocks_of_drawn_conditions_are_carried_out_by_an_action() {
    alike(&read_case("chart-timer/chart-timer.xml"), &read_case("chart-timer/chart-timer.st"));
    let report = audit("chart-timer", "chart-timer.xml");
    assert_eq!(upper_ns(&report), 58_700);
    assert_eq!(upper_ns(&audit("chart-timer", "chart-timer.st")), 58_700);
    // A function in the condition, and an edge.
    let chart = |drawn: &str| {
        let step = |id: u32, name: &str, from: u32, more: &str| {
            format!(
                "<step localId=\"{id}\" name=\"{name}\"{more}><connectionPointIn><connection refLocalId=\"{from}\"/></connectionPointIn><connectionPointOut/></step>"
            )
        };
        let way = |id: u32, from: u32, condition: &str| {
            format!(
                "<transition localId=\"{id}\"><connectionPointIn><connection refLocalId=\"{from}\"/></connectionPointIn><condition>{condition}</condition></transition>"
            )
        };
        let point = "<connectionPointIn><connection refLocalId=\"3\" formalParameter=\"OUT\"/></connectionPointIn>";
        let inline = "<inline><ST><p>b</p></ST></inline>";
        format!(
            "<SFC>{drawn}{}{}{}{}</SFC>",
            step(11, "A", 14, " initialStep=\"true\""),
            way(12, 11, point),
            step(13, "B", 12, ""),
            way(14, 13, inline)
        )
    };
    let text = |own: &str, action: &str, condition: &str| {
        in_text(
            "a:BOOL b:BOOL",
            own,
            &format!(
                "INITIAL_STEP A: C(S); END_STEP ACTION C: {action} END_ACTION TRANSITION FROM A TO B := {condition}; END_TRANSITION STEP B: END_STEP TRANSITION FROM B TO A := b; END_TRANSITION"
            ),
        )
    };
    let drawn = elements(&["a", "b", "AND 1 2"], &[]);
    alike(&program("a:BOOL b:BOOL", &chart(&drawn)), &text("r3:BOOL", "r3 := a AND b;", "r3"));
    let drawn =
        elements(&["|", "b", "[a] 1"], &[]).replace("<contact ", "<contact edge=\"rising\" ");
    let edge = chart(&drawn).replace(" formalParameter=\"OUT\"", "");
    alike(&program("a:BOOL b:BOOL", &edge), &text("e:R_TRIG", "e(CLK := a);", "e.Q"));
}

#[test]
fn transitions_are_read_as_beremiz_writes_them() {
    for file in ["beremiz-transition.xml", "beremiz-transition-without.xml"] {
        assert_eq!(upper_ns(&audit("beremiz-transition", file)), 53_950, "{file}");
    }
    let text = read_case("beremiz-transition/beremiz-transition.xml");
    for body in [
        ":=go AND x < 5;",
        ":= go AND x < 5",
        "(* when *) := go AND x < 5;",
        "\n:= go\n AND x < 5 ;\n",
    ] {
        let path = written("transition.xml", &text.replace(":= go AND x < 5;", body));
        let report = audit("beremiz-transition", &path.display().to_string());
        assert_eq!(upper_ns(&report), 53_950, "{body}");
    }
}

#[test]
fn what_has_no_code_is_refused_where_a_controller_would_carry_it_out() {
    let project = |pou: &str| {
        format!(
            "<?xml version=\"1.0\" encoding=\"utf-8\"?><project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><fileHeader companyName=\"a\" productName=\"b\" productVersion=\"1\" creationDateTime=\"2026-01-01T00:00:00\"/><contentHeader name=\"c\"><coordinateInfo><fbd><scaling x=\"1\" y=\"1\"/></fbd><ld><scaling x=\"1\" y=\"1\"/></ld><sfc><scaling x=\"1\" y=\"1\"/></sfc></coordinateInfo></contentHeader><types><dataTypes/><pous>{pou}</pous></types><instances><configurations/></instances></project>"
        )
    };
    let st = |text: &str| {
        format!(
            "<body><ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{text}</xhtml></ST></body>"
        )
    };
    let directory = tempfile::tempdir().expect("a directory");
    let code = |pou: &str| {
        let file = directory.path().join("p.xml");
        std::fs::write(&file, project(pou)).expect("written");
        let output = binary()
            .args(["check", "--limit", "1s"])
            .arg(&file)
            .output()
            .expect("the command runs");
        output.status.code()
    };
    let program =
        |inner: &str| format!("<pou name=\"p\" pouType=\"program\"><interface/>{inner}</pou>");
    let call = st("Z();");
    assert_eq!(code(&program(&st("n:=n;").replace("n:=n;", ""))), Some(0), "an empty ST is code");
    for faulty in [
        String::new(),
        "<body/>".to_owned(),
        format!("<actions><action name=\"Z\"><body/></action></actions>{call}"),
        format!("<actions><action name=\"Z\"/></actions>{call}"),
    ] {
        assert_eq!(code(&program(&faulty)), Some(2), "{faulty}");
    }
}

//! Ladder and function block diagrams of PLCopen XML as the analysis follows them, where a slip would make a bound too low.

use scanbound::audit::{Failure, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// The longest scan in microseconds, where a store takes one and nothing else anything.
fn bound(text: &str) -> Result<u64, Vec<String>> {
    bound_of(text, "ST")
}

/// The same where this takes one, and nothing else anything.
fn bound_of(text: &str, row: &str) -> Result<u64, Vec<String>> {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += &format!("{row},1,1\n@end,0,\n");
    let table =
        Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table;
    let inputs = [Input { name: "main.xml".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request =
        Request { table: Some(&table), trust: Trust::None, ..Request::new(&inputs, &facts) };
    match audit(&request) {
        Ok(found) => Ok(found.bound.upper.0.div_ceil(Picos(1_000_000).0)),
        Err(Failure::Input(faults)) => Err(faults.into_iter().map(|fault| fault.message).collect()),
        Err(other) => panic!("{other:?}"),
    }
}

/// A project: units, variables in a list of globals, the program's body, and a condition that is asked for behind it.
fn project(units: &str, variables: &str, body: &str, condition: &str) -> String {
    let variable = |(name, of): (&str, &str)| {
        let of = match of {
            "BOOL" | "INT" => format!("<{of}/>"),
            _ => format!("<derived name=\"{of}\"/>"),
        };
        let address = if name == "a" { " address=\"%IX0.0\"" } else { "" };
        format!("<variable name=\"{name}\"{address}><type>{of}</type></variable>")
    };
    let all = format!("a:BOOL {variables}");
    let globals: String =
        all.split_whitespace().filter_map(|one| one.split_once(':')).map(variable).collect();
    let condition = condition.replace('<', "&lt;");
    format!(
        "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><dataTypes/><pous>{units}\
         <pou name=\"main\" pouType=\"program\"><interface/><body>{body}</body></pou>\
         <pou name=\"behind\" pouType=\"program\"><interface><localVars><variable name=\"heavy\"><type><INT/></type></variable></localVars></interface>\
         <body><ST><p>IF {condition} THEN FOR heavy := 1 TO 50 DO ; END_FOR END_IF</p></ST></body></pou></pous></types>\
         <instances><configurations><configuration name=\"c\"><resource name=\"r\"><globalVars>{globals}</globalVars></resource></configuration></configurations></instances></project>"
    )
}

/// Whether a condition may hold behind a program.
fn may(units: &str, variables: &str, body: &str, condition: &str) -> bool {
    let text = project(units, variables, body, condition);
    bound(&text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}")) > 50
}

/// An element with what leads to it.
fn at(head: &str, id: u32, from: &[(u32, &str)], inner: &str) -> String {
    let from: String = from
        .iter()
        .map(|(id, output)| {
            format!("<connection refLocalId=\"{id}\" formalParameter=\"{output}\"/>")
        })
        .collect();
    let name = head.split(' ').next().unwrap_or_default();
    format!(
        "<{head} localId=\"{id}\"><position x=\"{id}\" y=\"0\"/><connectionPointIn>{from}</connectionPointIn>{inner}</{name}>"
    )
}

fn contact(id: u32, more: &str, from: u32, of: &str) -> String {
    at(&format!("contact {more}"), id, &[(from, "")], &format!("<variable>{of}</variable>"))
}

fn coil(id: u32, from: u32, of: &str) -> String {
    at("coil", id, &[(from, "")], &format!("<variable>{of}</variable>"))
}

fn wired(id: u32, of: &str) -> String {
    at("inVariable", id, &[], &format!("<expression>{of}</expression>"))
}

fn out(id: u32, from: (u32, &str), of: &str) -> String {
    at("outVariable", id, &[from], &format!("<expression>{of}</expression>"))
}

fn block(id: u32, head: &str, inputs: &[(&str, (u32, &str))], outputs: &[&str]) -> String {
    let input = |(name, (from, output)): &(&str, (u32, &str))| {
        format!(
            "<variable formalParameter=\"{name}\"><connectionPointIn><connection refLocalId=\"{from}\" formalParameter=\"{output}\"/></connectionPointIn></variable>"
        )
    };
    let inputs: String = inputs.iter().map(input).collect();
    let output = |name: &&str| {
        let negated = if name.starts_with('!') { " negated=\"true\"" } else { "" };
        let name = name.trim_start_matches('!');
        format!("<variable formalParameter=\"{name}\"{negated}><connectionPointOut/></variable>")
    };
    let outputs: String = outputs.iter().map(output).collect();
    format!(
        "<block {head} localId=\"{id}\"><position x=\"{id}\" y=\"0\"/><inputVariables>{inputs}</inputVariables><inOutVariables/>\
         <outputVariables>{outputs}</outputVariables></block>"
    )
}

const RAIL: &str = "<leftPowerRail localId=\"0\"/>";

#[test]
fn what_stands_behind_a_coil_has_what_led_to_it() {
    // x turns over; y has what x became.
    let body = format!(
        "<LD>{RAIL}{}{}{}</LD>",
        contact(1, "negated=\"true\"", 0, "x"),
        coil(2, 1, "x"),
        coil(3, 2, "y")
    );
    assert!(may("", "x:BOOL y:BOOL", &body, "x AND y"));
    assert!(may("", "x:BOOL y:BOOL", &body, "NOT x AND NOT y"));
}

#[test]
fn where_a_way_forks_a_contact_may_be_looked_at_once_or_again() {
    let body = format!(
        "<LD>{RAIL}{}{}{}</LD>",
        contact(1, "negated=\"true\"", 0, "x"),
        coil(2, 1, "x"),
        coil(3, 1, "y")
    );
    assert!(may("", "x:BOOL y:BOOL", &body, "x = y"));
    assert!(may("", "x:BOOL y:BOOL", &body, "x <> y"));
    // Nothing between has written what it is made of.
    let body = format!(
        "<LD>{RAIL}{}{}{}</LD>",
        contact(1, "negated=\"true\"", 0, "a"),
        coil(2, 1, "x"),
        coil(3, 1, "y")
    );
    assert!(!may("", "x:BOOL y:BOOL", &body, "x <> y"));
    // Two ways in a row.
    let body = format!(
        "<LD>{RAIL}{}{}{}{}{}</LD>",
        contact(1, "negated=\"true\"", 0, "x"),
        contact(2, "", 1, "a"),
        coil(3, 1, "x"),
        coil(4, 2, "y"),
        coil(5, 2, "z")
    );
    assert!(may("", "x:BOOL y:BOOL z:BOOL", &body, "a AND x = y"));
    assert!(may("", "x:BOOL y:BOOL z:BOOL", &body, "a AND x <> y"));
    assert!(!may("", "x:BOOL y:BOOL z:BOOL", &body, "NOT a AND y"));
}

#[test]
fn nothing_is_taken_over_from_a_function_that_is_not_enabled() {
    let body = format!(
        "<LD>{RAIL}{}{}{}{}{}</LD>",
        contact(1, "", 0, "a"),
        wired(2, "7"),
        block(3, "typeName=\"MOVE\"", &[("EN", (1, "")), ("IN", (2, ""))], &["ENO", "OUT"]),
        out(4, (3, "OUT"), "n"),
        coil(5, 3, "x").replace("formalParameter=\"\"", "formalParameter=\"ENO\"")
    );
    assert!(!may("", "n:INT x:BOOL", &body, "a AND n <> 7"));
    assert!(may("", "n:INT x:BOOL", &body, "NOT a AND n = 7"));
    assert!(may("", "n:INT x:BOOL", &body, "NOT a AND n = 5"));
    assert!(!may("", "n:INT x:BOOL", &body, "a <> x"));
    // ENO says what EN was, whatever the block itself writes.
    let unit = "<pou name=\"B\" pouType=\"functionBlock\"><interface><inOutVars><variable name=\"c\"><type><BOOL/></type></variable></inOutVars></interface>\
                <body><ST><p>c := FALSE;</p></ST></body></pou>";
    let handed = "<inOutVariables><variable formalParameter=\"c\"><connectionPointIn><connection refLocalId=\"2\"/></connectionPointIn></variable></inOutVariables>";
    let body = format!(
        "<LD>{RAIL}{}{}{}{}</LD>",
        contact(1, "", 0, "x"),
        wired(2, "x"),
        block(3, "typeName=\"B\" instanceName=\"b\"", &[("EN", (1, ""))], &["ENO"])
            .replace("<inOutVariables/>", handed),
        coil(5, 3, "y").replace("formalParameter=\"\"", "formalParameter=\"ENO\"")
    );
    assert!(may(unit, "x:BOOL y:BOOL b:B", &body, "y AND NOT x"));
    assert!(!may(unit, "x:BOOL y:BOOL b:B", &body, "y AND x"));
}

#[test]
fn outputs_of_a_block_are_told_apart() {
    let body = format!(
        "<FBD>{}{}{}{}{}{}{}</FBD>",
        wired(1, "a"),
        wired(2, "FALSE"),
        block(
            3,
            "typeName=\"CTUD\" instanceName=\"c\"",
            &[("CU", (1, "")), ("CD", (2, "")), ("R", (2, "")), ("LD", (2, ""))],
            &["!QU", "!QD", "CV"]
        ),
        out(4, (3, "QU"), "x"),
        out(5, (3, "QD"), "y"),
        out(6, (3, "QU"), "z"),
        out(7, (3, "QD"), "v")
    );
    assert!(!may("", "x:BOOL y:BOOL z:BOOL v:BOOL c:CTUD", &body, "x <> z OR y <> v"));
    assert!(may("", "x:BOOL y:BOOL z:BOOL v:BOOL c:CTUD", &body, "x <> y"));
}

#[test]
fn variables_of_lists_with_different_names_are_different_ones() {
    let list = |name: &str, value: &str| {
        format!(
            "<globalVars name=\"{name}\"><variable name=\"n\"><type><INT/></type><initialValue><simpleValue value=\"{value}\"/></initialValue></variable></globalVars>"
        )
    };
    let body = "<ST><p>One.n := 1; Two.n := 2;</p></ST>";
    let text = |condition: &str| {
        let lists = format!("{}{}<globalVars>", list("One", "4"), list("Two", "0"));
        project("", "", body, condition).replacen("<globalVars>", &lists, 1)
    };
    assert!(bound(&text("One.n = 1 AND Two.n = 2")).expect("a bound") > 50);
    assert!(bound(&text("One.n <> 1 OR Two.n <> 2")).expect("a bound") < 50);
}

/// A chart of one step, whose action blocks have bodies of their own.
fn chart(bodies: &[String], condition: &str) -> String {
    let actions: String = bodies
        .iter()
        .map(|body| format!("<action qualifier=\"N\"><inline>{body}</inline></action>"))
        .collect();
    format!(
        "<SFC><step localId=\"1\" name=\"s\" initialStep=\"true\"/>{}{}{}</SFC>",
        at("actionBlock", 2, &[(1, "")], &actions),
        at("transition", 3, &[(1, "")], &format!("<condition>{condition}</condition>")),
        at("jumpStep targetName=\"s\"", 4, &[(3, "")], "")
    )
}

#[test]
fn actions_in_blocks_number_their_elements_by_themselves() {
    let rising = |of: &str, to: &str| {
        format!("<LD>{RAIL}{}{}</LD>", contact(1, "edge=\"rising\"", 0, of), coil(2, 1, to))
    };
    let always = "<inline><ST><p>TRUE</p></ST></inline>";
    // Two triggers see two variables: the first one has seen x, whatever y is.
    let body = chart(&[rising("x", "p"), rising("y", "q")], always);
    let condition = "was AND x AND p";
    let before = "<pou name=\"first\" pouType=\"program\"><interface/><body><ST><p>y := FALSE; IF s THEN was := x; ELSE was := FALSE; END_IF x := TRUE; s := TRUE;</p></ST></body></pou>";
    assert!(may(before, "x:BOOL y:BOOL p:BOOL q:BOOL was:BOOL s:BOOL", &body, "x AND p"));
    let sum = |from: (&str, &str), to: &str| {
        format!(
            "<FBD>{}{}{}{}</FBD>",
            wired(1, from.0),
            wired(2, from.1),
            block(
                3,
                "typeName=\"ADD\"",
                &[("EN", (1, "")), ("IN1", (2, "")), ("IN2", (2, ""))],
                &["ENO", "OUT"]
            ),
            out(4, (3, "OUT"), to)
        )
    };
    let body = chart(&[sum(("TRUE", "3"), "n"), sum(("a", "4"), "m")], always);
    assert!(!may("", "n:INT m:INT", &body, "n <> 6 AND n = m AND a"));
    assert!(may("", "n:INT m:INT", &body, "a AND m = 8"));
    let _ = condition;
}

#[test]
fn drawn_conditions_may_fork_and_compare() {
    let value = "<connectionPointIn><connection refLocalId=\"14\" formalParameter=\"OUT\"/></connectionPointIn>";
    let drawn = format!(
        "{}{}{}",
        wired(11, "n"),
        wired(12, "3"),
        block(14, "typeName=\"GT\"", &[("IN1", (11, "")), ("IN2", (12, ""))], &["OUT"])
    );
    let set = "<ST><p>x := FALSE;</p></ST>".to_owned();
    let body = chart(&[set], value).replace("</SFC>", &format!("{drawn}</SFC>"));
    assert!(bound(&project("", "n:INT x:BOOL", &body, "x")).is_ok());
    // What a condition would have to remember is refused, never left out.
    let trigger = block(14, "typeName=\"R_TRIG\" instanceName=\"t\"", &[("CLK", (11, ""))], &["Q"]);
    let value = value.replace("OUT", "Q");
    let body = chart(&["<ST><p>x := FALSE;</p></ST>".to_owned()], &value)
        .replace("</SFC>", &format!("{}{trigger}</SFC>", wired(11, "a")));
    let faults = bound(&project("", "t:R_TRIG x:BOOL", &body, "x")).expect_err("refused");
    assert!(faults[0].contains("remembers"), "{faults:?}");
}

#[test]
fn what_has_no_position_is_carried_out_as_the_file_has_it() {
    let bare = |text: String| {
        let (front, back) = text.split_once("<position").expect("a position");
        format!("{front}{}", back.split_once("/>").expect("its end").1)
    };
    let body = format!(
        "<LD>{RAIL}{}{}{}{}</LD>",
        bare(contact(1, "", 0, "x")),
        bare(coil(2, 1, "y")),
        bare(contact(3, "", 0, "a")),
        bare(coil(10, 3, "x"))
    );
    assert!(may("", "x:BOOL y:BOOL", &body, "y AND NOT x"));
    assert!(!may("", "x:BOOL y:BOOL", &body, "a AND NOT x"));
}

#[test]
fn variables_that_are_wired_in_and_out_are_written() {
    let through = at("inOutVariable", 2, &[(1, "")], "<expression>x</expression>");
    let body = format!("<FBD>{}{through}{}</FBD>", wired(1, "a"), out(3, (2, ""), "y"));
    assert!(!may("", "x:BOOL y:BOOL", &body, "a AND NOT x"));
    assert!(!may("", "x:BOOL y:BOOL", &body, "a AND NOT y"));
}

#[test]
fn coils_to_which_nothing_leads_may_be_left_as_they_are() {
    let body = format!("<LD>{}</LD>", at("coil", 2, &[], "<variable>x</variable>"));
    assert!(may("", "x:BOOL", &body, "x"));
    assert!(may("", "x:BOOL", &body, "NOT x"));
}

#[test]
fn an_edge_beside_the_power_rail_is_looked_at_all_the_same() {
    let body = format!(
        "<LD>{RAIL}{}{}</LD>",
        contact(1, "edge=\"rising\"", 0, "a"),
        at("coil", 2, &[(0, ""), (1, "")], "<variable>x</variable>"),
    );
    let project = scanbound::iec::read("main.xml", &project("", "x:BOOL", &body, "x"));
    let project = project.expect("a project");
    let main = project.pous.iter().find(|pou| pou.name == "main").expect("the program");
    assert!(main.variables.iter().any(|one| one.name.contains("e1")), "{:?}", main.variables);
}

#[test]
fn a_thousand_ways_are_joined() {
    let ways: String = (1..=1000).map(|id| contact(id, "", 0, "x")).collect();
    let from: Vec<(u32, &str)> = (1..=1000).map(|id| (id, "")).collect();
    let body =
        format!("<LD>{RAIL}{ways}{}</LD>", at("coil", 2000, &from, "<variable>y</variable>"));
    assert!(!may("", "x:BOOL y:BOOL", &body, "x AND NOT y"));
}

#[test]
fn a_block_of_actions_belongs_to_all_steps_that_it_hangs_on() {
    let block = at(
        "actionBlock",
        5,
        &[(1, ""), (3, "")],
        "<action qualifier=\"N\"><reference name=\"x\"/></action>",
    );
    let always = "<condition><inline><ST><p>TRUE</p></ST></inline></condition>";
    let body = format!(
        "<SFC><step localId=\"1\" name=\"s\" initialStep=\"true\"/>{}{}{}{}{block}</SFC>",
        at("transition", 2, &[(1, "")], always),
        at("step name=\"t\"", 3, &[(2, "")], ""),
        at("transition", 4, &[(3, "")], always),
        at("jumpStep targetName=\"s\"", 6, &[(4, "")], "")
    );
    let project = scanbound::iec::read("main.xml", &project("", "x:BOOL", &body, "x"));
    let project = project.expect("a project");
    let charts = project.charts();
    let blocks: Vec<usize> = charts[0].2.steps.iter().map(|step| step.blocks.len()).collect();
    assert_eq!(blocks, [1, 1]);
}

#[test]
fn what_a_drawing_says_and_is_not_followed_is_refused() {
    let refused = |body: &str, why: &str| {
        let text = project("", "x:BOOL y:BOOL", body, "x");
        let faults = bound(&text).expect_err("a refusal");
        assert!(faults.iter().any(|fault| fault.contains(why)), "{faults:?}");
    };
    let inline = |inner: &str| format!("<inline>{inner}</inline>");
    let two = format!("<LD>{RAIL}{}{}</LD>", coil(2, 0, "x"), coil(3, 0, "y"));
    refused(&chart(&[], &inline(&two)), "several elements");
    let always = inline("<ST><p>TRUE</p></ST>");
    let plain = chart(&["<ST><p>x := TRUE;</p></ST>".to_owned()], &always);
    refused(&plain.replace("<actionBlock", "<actionBlock negated=\"true\""), "negated");
    refused(&plain.replace("<transition", "<transition priority=\"1x\""), "priority");
    refused(&plain.replace("</SFC>", &format!("{}</SFC>", coil(9, 1, "y"))), "carries it out");
    refused(&format!("{plain}</body><body>{plain}"), "second body");
    refused("<ST><p>x := TRUE;</p></ST><IL>LD y</IL>", "several languages");
    let edge = contact(1, "edge=\"both\"", 0, "a");
    refused(&format!("<LD>{RAIL}{edge}{}</LD>", coil(2, 1, "x")), "both");
    let returns = at("return edge=\"rising\"", 2, &[(0, "")], "");
    refused(&format!("<LD>{RAIL}{returns}</LD>"), "rising");
    let jump = "<jump localId=\"7\" label=\"l\"/><label localId=\"8\" label=\"l\"/>";
    refused(&format!("<LD>{jump}</LD>"), "nothing leads to it");
}

/// An element that stands elsewhere.
fn moved(text: &str, x: u32, y: u32) -> String {
    let (front, back) = text.split_once("<position").expect("a position");
    let behind = back.split_once("/>").expect("its end").1;
    format!("{front}<position x=\"{x}\" y=\"{y}\"/>{behind}")
}

#[test]
fn contacts_are_charged_for_each_coil_that_they_lead_to() {
    let coils: String = (4..=6).map(|id| coil(id, 3, &format!("x{id}"))).collect();
    let drawn = |edge: &str| {
        let row = format!(
            "{}{}{}",
            contact(1, "", 0, "a"),
            contact(2, edge, 1, "b"),
            contact(3, "", 2, "c")
        );
        project(
            "",
            "b:BOOL c:BOOL x4:BOOL x5:BOOL x6:BOOL",
            &format!("<LD>{RAIL}{row}{coils}</LD>"),
            "TRUE",
        )
    };
    // Three contacts for each of three coils; where they lead to one coil twice, they are looked at once.
    let text = drawn("");
    assert_eq!(bound_of(&text, "LD").expect("a bound"), 9 + loads_behind());
    let diamond = format!(
        "<LD>{RAIL}{}{}{}{}</LD>",
        contact(1, "", 0, "a"),
        contact(2, "", 1, "b"),
        contact(3, "", 1, "c"),
        at("coil", 4, &[(2, ""), (3, "")], "<variable>x4</variable>")
    );
    let text = project("", "b:BOOL c:BOOL x4:BOOL", &diamond, "TRUE");
    assert_eq!(bound_of(&text, "LD").expect("a bound"), 3 + loads_behind());
    // Each coil has an edge of its own, too.
    let text = drawn("edge=\"rising\"");
    assert_eq!(bound_of(&text, "R_TRIG").expect("a bound"), 3);
}

/// How many variables the program behind loads.
fn loads_behind() -> u64 {
    let text = project("", "", "<LD></LD>", "TRUE");
    bound_of(&text, "LD").expect("a bound")
}

#[test]
fn an_edge_behind_a_fork_may_be_one_for_all_or_one_for_each() {
    // The second coil's edge sees what the first one wrote.
    let body = format!(
        "<LD>{RAIL}{}{}{}{}</LD>",
        contact(1, "edge=\"rising\"", 0, "x"),
        coil(2, 1, "y"),
        moved(&coil(3, 0, "x"), 3, 50),
        moved(&coil(4, 1, "z"), 4, 90)
    );
    assert!(may("", "x:BOOL y:BOOL z:BOOL", &body, "z AND NOT y"));
    assert!(may("", "x:BOOL y:BOOL z:BOOL", &body, "z = y"));
    let body = format!(
        "<LD>{RAIL}{}{}{}</LD>",
        contact(1, "edge=\"rising\"", 0, "a"),
        coil(2, 1, "y"),
        coil(3, 1, "z")
    );
    assert!(!may("", "y:BOOL z:BOOL", &body, "z <> y"));
}

#[test]
fn results_of_functions_are_stored_and_loaded() {
    let body = format!(
        "<FBD>{}{}{}{}</FBD>",
        wired(1, "n"),
        wired(2, "3"),
        block(3, "typeName=\"ADD\"", &[("IN1", (1, "")), ("IN2", (2, ""))], &["OUT"]),
        out(4, (3, "OUT"), "m")
    );
    let text = project("", "n:INT m:INT", &body, "TRUE");
    let behind = bound(&project("", "", "<LD></LD>", "TRUE")).expect("a bound");
    assert_eq!(bound(&text).expect("a bound"), 2 + behind);
    assert_eq!(bound_of(&text, "LD").expect("a bound"), 2 + loads_behind());
}

#[test]
fn blocks_may_come_in_their_place_or_behind_the_coils() {
    // A trigger that no coil asks for stands above a coil that reads its output, and one that writes its clock.
    let body = format!(
        "<LD>{RAIL}{}{}{}{}</LD>",
        moved(&wired(1, "a"), 0, 0),
        moved(
            &block(2, "typeName=\"R_TRIG\" instanceName=\"t\"", &[("CLK", (1, ""))], &["Q"]),
            50,
            0
        ),
        moved(&contact(3, "", 0, "t.Q"), 0, 100),
        moved(&coil(4, 3, "x"), 50, 100)
    );
    let variables = "t:R_TRIG x:BOOL";
    assert!(may("", variables, &body, "t.Q AND x"));
    assert!(may("", variables, &body, "t.Q AND NOT x"));
    // CODESYS carries out its drawings itself.
    let data = "<addData><data name=\"http://www.3s-software.com/plcopenxml/x\" handleUnknown=\"discard\"/></addData>";
    let text = project("", variables, &body, "t.Q AND NOT x")
        .replace("<types>", &format!("{data}<types>"));
    assert!(bound(&text).expect("a bound") < 50);
    // By its number it comes first.
    let numbered = body.replace("localId=\"2\"", "localId=\"2\" executionOrderId=\"1\"");
    assert!(!may("", variables, &numbered, "t.Q AND NOT x"));
}

#[test]
fn coils_come_from_top_to_bottom_or_as_the_file_has_them() {
    let two = |y: u32| {
        format!(
            "<LD>{RAIL}{}{}{}{}</LD>",
            moved(&contact(1, "", 0, "a"), 0, 0),
            moved(&coil(2, 1, "x"), 50, y),
            moved(&contact(3, "", 0, "x"), 0, 20),
            moved(&coil(4, 3, "y"), 40, 20)
        )
    };
    // x stands in the file before y, and above, below or in its row further right.
    assert!(!may("", "x:BOOL y:BOOL", &two(0), "x <> y"));
    assert!(may("", "x:BOOL y:BOOL", &two(100), "x <> y"));
    assert!(may("", "x:BOOL y:BOOL", &two(100), "a AND x AND y"));
    assert!(may("", "x:BOOL y:BOOL", &two(12), "x <> y"));
}

#[test]
fn instances_that_feed_each_other_begin_with_the_first_or_with_the_one_that_is_asked_for() {
    let set = |id: u32, name: &str, from: u32, x: u32| {
        let head = format!("typeName=\"RS\" instanceName=\"{name}\"");
        moved(&block(id, &head, &[("S", (from, "Q1")), ("R1", (9, ""))], &["Q1"]), x, 0)
    };
    let body = format!(
        "<FBD>{}{}{}{}{}</FBD>",
        moved(&wired(9, "FALSE"), 0, 0),
        moved(&wired(1, "a"), 0, 10),
        set(2, "p", 5, 10),
        set(3, "q", 2, 20),
        moved(
            &block(5, "typeName=\"OR\"", &[("IN1", (1, "")), ("IN2", (3, "Q1"))], &["OUT"]),
            5,
            0
        )
    )
    .replace("refLocalId=\"5\" formalParameter=\"Q1\"", "refLocalId=\"5\" formalParameter=\"OUT\"");
    // Begun with p, both are set at once; begun with q, q is one scan behind.
    assert!(may("", "p:RS q:RS", &body, "p.Q1 AND q.Q1"));
    assert!(may("", "p:RS q:RS", &body, "p.Q1 AND NOT q.Q1"));
}

#[test]
fn variables_right_at_the_pins_of_blocks_are_read_and_written() {
    let pin = |name: &str, point: &str, of: &str| {
        format!(
            "<variable formalParameter=\"{name}\"><{point}><expression>{of}</expression></{point}></variable>"
        )
    };
    let body = format!(
        "<LD>{RAIL}<block localId=\"1\" typeName=\"SR\" instanceName=\"t\"><inputVariables>{}{}</inputVariables><inOutVariables/>\
         <outputVariables>{}</outputVariables></block></LD>",
        pin("S1", "connectionPointIn", "a"),
        pin("R", "connectionPointIn", "NOT a"),
        pin("Q1", "connectionPointOut", "x"),
    );
    assert!(!may("", "t:SR x:BOOL", &body, "a <> x"));
    assert!(may("", "t:SR x:BOOL", &body, "x"));
    // CODESYS counts EN among the inputs of an operator.
    let counted = format!(
        "<LD>{RAIL}{}{}{}{}</LD>",
        wired(1, "n"),
        wired(2, "3"),
        block(
            3,
            "typeName=\"GE\"",
            &[("EN", (0, "")), ("In2", (1, "")), ("In3", (2, ""))],
            &["ENO", "Out1"]
        ),
        coil(4, 3, "x").replace("formalParameter=\"\"", "formalParameter=\"Out1\"")
    );
    assert!(!may("", "n:INT x:BOOL", &counted, "x AND n < 3"));
    assert!(may("", "n:INT x:BOOL", &counted, "x"));
}

#[test]
fn what_is_handed_in_and_out_stands_on_both_sides() {
    let unit = "<pou name=\"B\" pouType=\"functionBlock\"><interface><inOutVars><variable name=\"c\"><type><INT/></type></variable></inOutVars></interface>\
                <body><ST><p>c := 7;</p></ST></body></pou>";
    for both in [true, false] {
        let handed = block(2, "typeName=\"B\" instanceName=\"b\"", &[("c", (1, ""))], &["c"]);
        let handed = if both {
            handed
        } else {
            let (front, back) = handed.split_once("<inputVariables>").expect("inputs");
            let (pins, rest) =
                back.split_once("</inputVariables><inOutVariables/>").expect("their end");
            format!("{front}<inputVariables/><inOutVariables>{pins}</inOutVariables>{rest}")
        };
        let body = format!("<FBD>{}{handed}{}</FBD>", wired(1, "n"), out(3, (2, "c"), "m"));
        assert!(!may(unit, "n:INT m:INT b:B", &body, "n <> 7 OR m <> 7"));
    }
}

#[test]
fn what_constants_make_wraps_as_they_do() {
    for sum in ["(4+1)+n", "(4/1)+n", "MAX(4,1)+n", "SEL(a,4,1)+n", "LIMIT(1,2,4)+n", "(9 MOD 5)+n"]
    {
        let body = format!("<ST><p>x := {sum} >= 3;</p></ST>");
        let text = project("", "n:INT x:BOOL", &body, "NOT x AND n > 32765");
        assert!(bound(&text).expect("a bound") > 50, "{sum}");
    }
    let list = "<IL>LD 4\nADD 1\nADD n\nGE 3\nST x\n</IL>";
    assert!(may("", "n:INT x:BOOL", list, "NOT x AND n > 32765"));
    let body = "<ST><p>x := (4+1)+n >= 3;</p></ST>";
    assert!(!may("", "n:INT x:BOOL", body, "NOT x AND n > 0 AND n < 32000"));
    // What does not fit the type of what it is used with.
    let body = "<ST><p>x := (30000*30000)+n >= 3;</p></ST>";
    assert!(may("", "n:INT x:BOOL", body, "NOT x"));
    assert!(!may("", "n:DINT x:BOOL", body, "NOT x AND n > 0 AND n < 9"));
}

#[test]
fn what_lists_and_drawings_leave_unclear_is_refused() {
    let refused = |variables: &str, body: &str, why: &str| {
        let faults = bound(&project("", variables, body, "x")).expect_err("a refusal");
        assert!(faults.iter().any(|fault| fault.contains(why)), "{faults:?}");
    };
    refused("c:CTD x:BOOL", "<IL>LD c\nST x\n</IL>", "instance");
    refused("x:BOOL n:INT", "<IL>LD x\nS n\n</IL>", "not set");
    refused("x:BOOL", "<IL>LD x\nJMPC l\nl:\nl:\nST x\n</IL>", "two labels");
    refused("x:BOOL", "<ST><p>IF 5 THEN x := TRUE; END_IF</p></ST>", "truth value");
    let pin = block(2, "typeName=\"TOF\" instanceName=\"t\"", &[("IN", (0, ""))], &["Q"]);
    let text = format!("<LD>{RAIL}{pin}</LD>");
    let own = project("", "x:BOOL", &text, "x").replace(
        "<pou name=\"main\" pouType=\"program\"><interface/>",
        "<pou name=\"main\" pouType=\"program\"><interface><localVars><variable name=\"t\"><type><derived name=\"TON\"/></type></variable></localVars></interface>",
    );
    let faults = bound(&own).expect_err("a refusal");
    assert!(faults.iter().any(|fault| fault.contains("drawn as TOF")), "{faults:?}");
    let numbered = format!(
        "<LD>{RAIL}{}{}{}</LD>",
        wired(1, "n"),
        block(3, "typeName=\"NOT\"", &[("IN", (1, ""))], &["OUT"]),
        out(4, (3, "OUT"), "n").replace("localId", "executionOrderId=\"1\" localId")
    );
    refused("n:INT x:BOOL", &numbered, "which of them comes first");
    let always = "<inline><ST><p>TRUE</p></ST></inline>";
    let plain = chart(&["<ST><p>x := TRUE;</p></ST>".to_owned()], always);
    refused("x:BOOL", &plain.replace("qualifier=\"N\"", "qualifier=\"SD\""), "no time");
    let twice = "<step localId=\"9\" name=\"u\"/>";
    let both = plain
        .replace("</SFC>", &format!("{twice}</SFC>"))
        .replace("<transition localId=\"3\"><position x=\"3\" y=\"0\"/><connectionPointIn>", "<transition localId=\"3\"><position x=\"3\" y=\"0\"/><connectionPointIn><connection refLocalId=\"9\"/>");
    refused("x:BOOL", &both, "several steps");
    let told = plain.replace("<condition>", "<condition><reference name=\"t\"/>");
    refused("x:BOOL", &told, "two ways");
}

#[test]
fn lists_have_labels_ampersands_and_lists_as_inputs() {
    let list = "<IL>l1: LD a\n&amp; b\n&amp;N c\nST x\nCAL t(CLK := (\n LD a\n ANDN b\n))\nLD t.Q\nST y\n</IL>";
    let variables = "b:BOOL c:BOOL x:BOOL y:BOOL t:R_TRIG";
    assert!(!may("", variables, list, "x <> (a AND b AND NOT c)"));
    assert!(!may("", variables, list, "y AND b"));
    assert!(may("", variables, list, "y"));
    // Enough instructions to look like a list of another maker.
    let long = format!("<IL>\n{}</IL>", "LD a\nST x\n".repeat(40));
    assert!(!may("", "x:BOOL", &long, "a <> x"));
}

/// Two units whose instances may feed each other; the second one says that it was carried out.
fn feeding() -> String {
    let unit = |name: &str, extern_: &str, body: &str| {
        format!(
            "<pou name=\"{name}\" pouType=\"functionBlock\"><interface><inputVars><variable name=\"x\"><type><BOOL/></type></variable></inputVars>\
             <outputVars><variable name=\"q\"><type><BOOL/></type></variable></outputVars>{extern_}</interface><body><ST><p>{body}</p></ST></body></pou>"
        )
    };
    let seen =
        "<externalVars><variable name=\"seen\"><type><BOOL/></type></variable></externalVars>";
    unit("F", "", "q := TRUE;") + &unit("G", seen, "q := x; seen := TRUE;")
}

#[test]
fn a_loop_that_has_begun_goes_on_in_its_own_time() {
    let numbered = |text: String, order: u32| {
        text.replacen("localId", &format!("executionOrderId=\"{order}\" localId"), 1)
    };
    let first = block(1, "typeName=\"F\" instanceName=\"f\"", &[("x", (2, "q"))], &["q"]);
    let second = block(2, "typeName=\"G\" instanceName=\"g\"", &[("x", (1, "q"))], &["q"]);
    let end = at("return", 5, &[(1, "q")], "");
    // What the return leaves out is not carried out before it.
    let with =
        |first: String, second: String, end: String| format!("<FBD>{first}{second}{end}</FBD>");
    let body =
        with(numbered(first.clone(), 1), numbered(second.clone(), 9), numbered(end.clone(), 5));
    let variables = "seen:BOOL f:F g:G";
    assert!(may(&feeding(), variables, &body, "NOT seen"));
    assert!(!may(&feeding(), variables, &body, "seen AND NOT seen"));
    let places = with(moved(&first, 0, 0), moved(&second, 0, 200), moved(&end, 0, 100));
    assert!(may(&feeding(), variables, &places, "NOT seen"));
    // From top to bottom: v has what f put out, and g had not been carried out.
    let wire = moved(&out(5, (1, "q"), "v"), 0, 100);
    let seen = moved(&at("outVariable", 6, &[(7, "")], "<expression>w</expression>"), 0, 150);
    let asks = moved(&wired(7, "seen"), 0, 140);
    let clear = moved(&coil(8, 9, "seen"), 0, 0).replace("<coil", "<coil storage=\"reset\"");
    let body = format!(
        "<LD><leftPowerRail localId=\"9\"/>{clear}{}{}{wire}{seen}{asks}</LD>",
        moved(&first, 50, 0),
        moved(&second, 0, 200)
    );
    assert!(may(&feeding(), "seen:BOOL v:BOOL w:BOOL f:F g:G", &body, "v AND NOT w"));
}

#[test]
fn a_way_that_is_looked_at_before_a_block_is_not_taken_to_come_behind_it() {
    // x has v as it was before the block set it, or as it is then.
    let unit = "<pou name=\"T\" pouType=\"functionBlock\"><interface><inOutVars><variable name=\"c\"><type><BOOL/></type></variable></inOutVars>\
                <outputVars><variable name=\"q\"><type><BOOL/></type></variable></outputVars></interface><body><ST><p>c := TRUE; q := FALSE;</p></ST></body></pou>";
    let sets = block(2, "typeName=\"T\" instanceName=\"t\"", &[], &["q"]).replace(
        "<inOutVariables/>",
        "<inOutVariables><variable formalParameter=\"c\"><connectionPointIn><connection refLocalId=\"3\"/></connectionPointIn></variable></inOutVariables>",
    );
    let clears = coil(9, 0, "v").replace("<coil", "<coil storage=\"reset\"");
    for edge in ["", "edge=\"rising\""] {
        let body = format!(
            "<LD>{RAIL}{}{}{}{}{}{}{}</LD>",
            moved(&clears, 0, 0),
            moved(&at("coil", 6, &[(2, "q")], "<variable>z</variable>"), 50, 300),
            moved(&contact(1, edge, 0, "v"), 0, 20),
            moved(&wired(3, "v"), 0, 20),
            moved(&sets, 50, 500),
            moved(&at("coil", 5, &[(1, ""), (2, "q")], "<variable>x</variable>"), 50, 40),
            moved(&coil(7, 1, "w"), 50, 60),
        );
        let variables = "v:BOOL x:BOOL w:BOOL z:BOOL t:T";
        assert!(may(unit, variables, &body, "x"), "{edge}");
        assert!(may(unit, variables, &body, "NOT x"), "{edge}");
    }
}

#[test]
fn outputs_with_numbers_at_their_ends_are_kept_apart() {
    let unit = "<pou name=\"P\" pouType=\"functionBlock\"><interface><outputVars><variable name=\"Q\"><type><BOOL/></type></variable>\
                <variable name=\"Q_2\"><type><BOOL/></type></variable></outputVars></interface><body><ST><p>Q := FALSE; Q_2 := TRUE;</p></ST></body></pou>";
    let body = format!(
        "<LD>{RAIL}{}{}{}{}</LD>",
        moved(&block(1, "typeName=\"P\" instanceName=\"p\"", &[], &["!Q", "!Q_2"]), 0, 0),
        moved(&at("coil", 11, &[(1, "Q")], "<variable>x</variable>"), 0, 20),
        moved(&at("coil", 12, &[(1, "Q"), (1, "Q_2")], "<variable>y</variable>"), 0, 40),
        moved(&at("coil", 13, &[(1, "Q_2"), (1, "Q")], "<variable>z</variable>"), 0, 60),
    );
    assert!(!may(unit, "p:P x:BOOL y:BOOL z:BOOL", &body, "NOT y OR NOT z"));
}

/// A chart of two steps in turn, of which the first one has attributes as CODESYS and TwinCAT write them; actions that say
/// that they were carried out.
fn attributed(attributes: &[(&str, &str)]) -> String {
    let of = |(guid, text): &(&str, &str)| format!("<attribute guid=\"{guid}\">{text}</attribute>");
    let all: String = attributes.iter().map(of).collect();
    let data = format!(
        "<addData><data name=\"http://www.3s-software.com/plcopenxml/sfc/element\"><attributes xmlns=\"\">{all}</attributes></data></addData>"
    );
    let always = "<condition><inline><ST><p>TRUE</p></ST></inline></condition>";
    let chart = format!(
        "<SFC><step localId=\"1\" name=\"s\" initialStep=\"true\">{data}</step>{}{}{}{}</SFC>",
        at("transition", 2, &[(1, "")], always),
        at("step name=\"t\"", 3, &[(2, "")], ""),
        at("transition", 4, &[(3, "")], always),
        at("jumpStep targetName=\"s\"", 5, &[(4, "")], "")
    );
    let action = |name: &str| {
        format!("<action name=\"{name}\"><body><ST><p>{name}_ran := TRUE;</p></ST></body></action>")
    };
    let actions: String = ["first", "last", "during"].into_iter().map(action).collect();
    project(
        "",
        "first_ran:BOOL last_ran:BOOL during_ran:BOOL",
        &chart,
        "first_ran AND last_ran AND during_ran",
    )
    .replacen(
        "<interface/><body>",
        &format!("<interface/><actions>{actions}</actions><body>"),
        1,
    )
}

#[test]
fn steps_have_actions_on_entry_while_active_and_on_exit() {
    const ENTRY: &str = "a6b08bd8-b696-47e3-9cbf-7408b61c9ff8";
    const EXIT: &str = "a2621e18-7de3-4ea6-ae6d-89e9e0b7befd";
    const ACTIVE: &str = "700a583f-b4d4-43e4-8c14-629c7cd3bec8";
    let own = [(ENTRY, "first"), (EXIT, "last"), (ACTIVE, "during")];
    let text = attributed(&own);
    let read = scanbound::iec::read("main.xml", &text).expect("a project");
    let charts = read.charts();
    let step = &charts[0].2.steps[0];
    let name =
        |path: &Option<scanbound::iec::ast::Path>| path.as_ref().map(|one| one.first.clone());
    let names = [name(&step.entry), name(&step.exit), name(&step.active)];
    assert_eq!(names.map(Option::unwrap_or_default), ["first", "last", "during"]);
    // Each stores once; what begins comes with what is active, what ends by itself.
    let cost = |own: &[(&str, &str)]| bound(&attributed(own)).expect("a bound");
    let none = cost(&[]);
    assert_eq!(cost(&own[..1]), none + 1);
    assert_eq!(cost(&own[1..2]), none + 1);
    assert_eq!(cost(&own[2..]), none + 1);
    assert_eq!(cost(&own), none + 2);
    let refused = |guid: &str, text: &str, why: &str| {
        let faults = bound(&attributed(&[(guid, text)])).expect_err("a refusal");
        assert!(faults.iter().any(|fault| fault.contains(why)), "{faults:?}");
    };
    refused("01580b27-6378-448b-8ecb-0e4b795b58d6", "TRUE", "excluded");
    refused("cacf1a68-236e-47c2-b7b1-1cf9199718cb", "T#2s", "least time");
    refused("00000000-0000-0000-0000-000000000000", "first", "names an action");
}

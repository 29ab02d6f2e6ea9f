//! Ladder and function block diagrams of PLCopen XML as the analysis follows them, where a slip would make a bound too low.

use scanbound::audit::{Failure, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// The longest scan in microseconds, where a store takes one and nothing else anything.
fn bound(text: &str) -> Result<u64, Vec<String>> {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += "ST,1,1\n@end,0,\n";
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
    let jump = "<jump localId=\"7\" label=\"l\"/><label localId=\"8\" label=\"l\"/>";
    refused(&format!("<LD>{jump}</LD>"), "nothing leads to it");
}

//! Ladder and function block diagrams of PLCopen XML as the analysis follows them, where a slip would make a bound too
//! low.

use common::iec::xml as iec_xml;

use iec_xml::{
    RAIL, as_drawn, at, block, bound, bound_of, chart, coil, contact, may, out, project, wired,
};
use scanbound::iec::chart::coactive;

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
    let body = format!(
        "<LD>{RAIL}{}{}{}{}</LD>",
        contact(1, "", 0, "x"),
        wired(2, "x"),
        block(3, "typeName=\"B\" instanceName=\"b\"", &[("EN", (1, "")), ("c", (2, ""))], &["ENO"]),
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
    // A block that remembers is executed in each scan.
    let trigger = block(14, "typeName=\"R_TRIG\" instanceName=\"t\"", &[("CLK", (11, ""))], &["Q"]);
    let value = value.replace("OUT", "Q");
    let body = chart(&["<ST><p>x := FALSE;</p></ST>".to_owned()], &value)
        .replace("</SFC>", &format!("{}{trigger}</SFC>", wired(11, "a")));
    assert_eq!(bound_of(&project("", "t:R_TRIG x:BOOL", &body, "x"), "R_TRIG"), Ok(1));
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
    assert_eq!(bound_of(&project("", "x:BOOL", &body, "x"), "R_TRIG"), Ok(1));
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
    refused(&chart(&[], &inline(&two)), "several coils or outputs");
    let always = inline("<ST><p>TRUE</p></ST>");
    let plain = chart(&["<ST><p>x := TRUE;</p></ST>".to_owned()], &always);
    refused(&plain.replace("<actionBlock", "<actionBlock negated=\"true\""), "negated");
    refused(&plain.replace("<transition", "<transition priority=\"1x\""), "priority");
    refused(&plain.replace("</SFC>", &format!("{}</SFC>", coil(9, 1, "y"))), "executes it");
    refused(&format!("{plain}</body><body>{plain}"), "second body");
    refused("<ST><p>x := TRUE;</p></ST><IL>LD y</IL>", "several languages");
    let edge = contact(1, "edge=\"both\"", 0, "a");
    refused(&format!("<LD>{RAIL}{edge}{}</LD>", coil(2, 1, "x")), "both");
    let returns = at("return edge=\"rising\"", 2, &[(0, "")], "");
    refused(&format!("<LD>{RAIL}{returns}</LD>"), "rising");
    let jump = "<jump localId=\"7\" label=\"l\"/><label localId=\"8\" label=\"l\"/>";
    refused(&format!("<LD>{jump}</LD>"), "nothing is connected to it");
}

#[test]
fn eno_is_followed_in_a_condition_only_where_the_block_gives_it_itself() {
    let told = |head: &str, enable: &str, pin: &str, output: &str| {
        let value = format!(
            "<connectionPointIn><connection refLocalId=\"14\" formalParameter=\"{output}\"/></connectionPointIn>"
        );
        let result = if head.contains("MOVE") { "OUT" } else { "Q" };
        let pins = [("EN", (11, "")), (pin, (12, ""))];
        let drawn = block(14, head, &pins, &["ENO", result])
            .replace("formalParameter=\"EN\"", &format!("formalParameter=\"EN\"{enable}"));
        let drawn = wired(11, "a") + &wired(12, "x") + &drawn;
        let body = chart(&["<ST><p>x := FALSE;</p></ST>".to_owned()], &value)
            .replace("</SFC>", &format!("{drawn}</SFC>"));
        bound(&project("", "x:BOOL t:TON r:R_TRIG", &body, "x"))
    };
    for (head, pin) in [
        ("typeName=\"TON\" instanceName=\"t\"", "IN"),
        ("typeName=\"R_TRIG\" instanceName=\"r\"", "CLK"),
        ("typeName=\"MOVE\"", "IN"),
    ] {
        for enable in ["", " edge=\"rising\""] {
            let found = told(head, enable, pin, "ENO");
            match (enable, head.contains("instanceName")) {
                ("", false) => assert!(found.is_ok(), "{found:?}"),
                _ => {
                    let faults = found.expect_err("a refusal");
                    let says = |one: &String| one.contains("ENO of this block is not followed");
                    assert!(faults.iter().any(says), "{faults:?}");
                }
            }
        }
    }
    assert!(told("typeName=\"TON\" instanceName=\"t\"", "", "IN", "Q").is_ok());
}

/// A chart of two steps in turn, of which the first one has attributes as CODESYS and TwinCAT write them; actions that
/// say that they were carried out.
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
    let found = coactive::analyse_by(charts[0].2, 1000, coactive::Rule::One);
    let pairs: Vec<&str> = found.pairs.iter().map(|pair| pair.action.as_str()).collect();
    assert_eq!(pairs, ["first"], "with what is active, on one step");
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
    refused("cacf1a68-236e-47c2-b7b1-1cf9199718cb", "T#2s", "minimum time");
    refused("00000000-0000-0000-0000-000000000000", "first", "names an action");
}

#[test]
fn expressions_cost_what_generators_write() {
    let own = |id: u32, of: &str, from: &[u32]| {
        let from: Vec<(u32, &str)> = from.iter().map(|id| (*id, "")).collect();
        at("contact", id, &from, &format!("<variable>{of}</variable>"))
    };
    let ends = |from: &[u32]| {
        let from: Vec<(u32, &str)> = from.iter().map(|id| (*id, "")).collect();
        at("coil", 9, &from, "<variable>x</variable>")
    };
    let (c, a, b) = (own(1, "c", &[0]), own(2, "a", &[1]), own(3, "b", &[1]));
    let fork = format!("{c}{a}{b}");
    for (drawn, [loads, ands, ors]) in [
        // x := (a OR b) AND c
        (fork.clone() + &ends(&[2, 3]), [3, 1, 1]),
        // x := (a OR b) AND c OR d
        (fork.clone() + &own(4, "d", &[0]) + &ends(&[2, 3, 4]), [4, 1, 2]),
        // x := d AND (a OR b) AND c
        (fork.clone() + &own(4, "d", &[2, 3]) + &ends(&[4]), [4, 2, 1]),
        // x := d AND (a OR b) AND c OR e AND c
        (fork.clone() + &own(4, "d", &[2, 3]) + &own(5, "e", &[1]) + &ends(&[4, 5]), [6, 3, 2]),
        // x := (d OR e) AND (a OR b), whatever the order of the connections
        (
            own(2, "a", &[0])
                + &own(3, "b", &[0])
                + &own(4, "d", &[2, 3])
                + &own(5, "e", &[3, 2])
                + &ends(&[4, 5]),
            [4, 1, 2],
        ),
        // c := TRUE; x := a AND TRUE
        (coil(1, 0, "c") + &own(2, "a", &[1]) + &ends(&[2]), [1, 1, 0]),
        // c := a; x := b AND a
        (own(1, "a", &[0]) + &coil(2, 1, "c") + &own(3, "b", &[2]) + &ends(&[3]), [3, 1, 0]),
    ] {
        let variables = "b:BOOL c:BOOL d:BOOL e:BOOL x:BOOL";
        let text = project("", variables, &format!("<LD>{RAIL}{drawn}</LD>"), "FALSE");
        for (row, times) in [("LD", loads), ("AND", ands), ("OR", ors)] {
            assert_eq!(bound_of(&text, row), Ok(times), "{row}: {drawn}");
        }
    }
}

#[test]
fn a_block_that_an_expression_calls_may_change_its_contacts() {
    let unit = "<pou name=\"B\" pouType=\"functionBlock\"><interface><inputVars><variable name=\"u\"><type><BOOL/></type></variable></inputVars>\
                <outputVars><variable name=\"o\"><type><BOOL/></type></variable></outputVars></interface>\
                <body><ST><p>v := FALSE; o := FALSE;</p></ST></body></pou>";
    // Where v was on, x is on for those who looked at it before, and for generators where v is off.
    for (fork, negated) in [(true, true), (true, false), (false, true), (false, false)] {
        let read = contact(1, &format!("negated=\"{negated}\""), 0, "v");
        let taken = if fork { coil(2, 1, "y") } else { String::new() };
        let called = block(3, "typeName=\"B\" instanceName=\"b\"", &[("u", (0, ""))], &["o"]);
        let called = called.replace("x=\"3\"", "x=\"5\"");
        let ends = at("coil", 4, &[(1, ""), (3, "o")], "<variable>x</variable>");
        let first = coil(9, 0, "v").replace("x=\"9\"", "x=\"0\"");
        let body = format!("<LD>{RAIL}{first}{read}{taken}{called}{ends}</LD>");
        for condition in ["x", "NOT x"] {
            assert!(may(unit, "b:B v:BOOL x:BOOL y:BOOL", &body, condition), "{condition} {body}");
        }
    }
}

#[test]
fn texts_and_structures_are_copied_into_the_results_of_functions() {
    const TYPES: &str = "<dataTypes><dataType name=\"S\"><baseType><struct><variable name=\"p\"><type><INT/></type></variable></struct></baseType></dataType></dataTypes>";
    let variable = |ty: &str| {
        let ty = ty.to_owned();
        move |name: &str| format!("<variable name=\"{name}\"><type>{ty}</type></variable>")
    };
    let drawn = |ty: &str| {
        let drawn = block(2, "typeName=\"MOVE\"", &[("IN", (1, ""))], &["OUT"]);
        let body = format!("<FBD>{}{drawn}{}</FBD>", wired(1, "s"), out(3, (2, "OUT"), "t"));
        let text = project("", "", &body, "FALSE");
        let variables: String = ["s", "t"].map(&variable(ty)).concat();
        let own = format!("<interface><localVars>{variables}</localVars></interface>");
        text.replacen("<interface/>", &own, 1).replace("<dataTypes/>", TYPES)
    };
    let written = |ty: &str| {
        let variables: String = ["s", "t", "r"].map(&variable(ty)).concat();
        let text = project("", "", "<ST><p>r := MOVE(s); t := r;</p></ST>", "FALSE");
        let own = format!("<interface><localVars>{variables}</localVars></interface>");
        text.replacen("<interface/>", &own, 1).replace("<dataTypes/>", TYPES)
    };
    // The result of a function whose type depends on the controller is a text, too.
    let left = |text: String| {
        let two = "<variable formalParameter=\"IN1\">";
        let text = text.replace("<variable formalParameter=\"IN\">", two);
        text.replace("\"MOVE\"", "\"LEFT\"").replace("MOVE(s)", "LEFT(s)")
    };
    let of_left = bound_of(&left(drawn("<string/>")), "COPY_TEXT").expect("a bound");
    assert_eq!(bound_of(&left(written("<string/>")), "COPY_TEXT"), Ok(of_left));
    assert!(of_left >= 2, "{of_left}");
    for (ty, row) in [("<string/>", "COPY_TEXT"), ("<derived name=\"S\"/>", "COPY")] {
        let generated = bound_of(&drawn(ty), row).expect("a bound");
        assert_eq!(Ok(generated), bound_of(&written(ty), row), "{ty}");
        assert!(generated >= 2, "{ty}: {generated}");
    }
    let of = |text: &str| bound_of(text, "COPY_TEXT").expect("a bound");
    assert!(of(&as_drawn(&drawn("<string/>"))) < of(&drawn("<string/>")));
}

#[test]
fn what_is_passed_to_a_pin_apart_from_the_inputs_is_refused() {
    // Generators pass nothing to it, so that the block works on another variable.
    let unit = "<pou name=\"T\" pouType=\"functionBlock\"><interface><inOutVars><variable name=\"c\"><type><BOOL/></type></variable></inOutVars></interface>\
                <body><ST><p>c := TRUE;</p></ST></body></pou>";
    let passed = block(2, "typeName=\"T\" instanceName=\"t\"", &[("c", (1, ""))], &[]);
    let input = passed.find("<variable formalParameter").expect("a pin");
    let end = passed.find("</inputVariables>").expect("an end");
    let pin = &passed[input..end];
    let apart = passed
        .replacen(pin, "", 1)
        .replace("<inOutVariables/>", &format!("<inOutVariables>{pin}</inOutVariables>"));
    let body = |block: &str| format!("<FBD>{}{block}</FBD>", wired(1, "v"));
    let (variables, condition) = ("v:BOOL t:T", "NOT v");
    assert!(!may(unit, variables, &body(&passed), condition));
    let text = project(unit, variables, &body(&apart), condition);
    let refusal = bound(&text).expect_err("it is refused").join("; ");
    assert!(refusal.contains("move it to <inputVariables>"), "{refusal}");
    assert!(bound(&as_drawn(&text)).is_ok());
}

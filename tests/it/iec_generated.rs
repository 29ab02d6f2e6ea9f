//! Drawings as generators of text make programs of them (Beremiz, OpenPLC), where that differs from the standard; and
//! what of a drawing is refused, since it would be left out.

use common::iec::xml as iec_xml;

use scanbound::base::facts::{ActionOrder, Facts};

use iec_xml::{
    RAIL, as_drawn, at, block, bound, chart, coil, contact, may, moved, out, project, wired,
};

/// Whether a condition may hold behind a drawing that generators make text of, and behind the same as it is drawn.
fn either(units: &str, variables: &str, body: &str, condition: &str) -> (bool, bool) {
    let text = as_drawn(&project(units, variables, body, condition));
    let drawn = bound(&text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}")) > 50;
    (may(units, variables, body, condition), drawn)
}

/// Why a project is refused.
pub fn refusal(text: &str) -> String {
    bound(text).expect_err(text).join("; ")
}

fn numbered(element: &str, number: u32) -> String {
    element.replacen("localId", &format!("executionOrderId=\"{number}\" localId"), 1)
}

/// A function block whose only output q is worked out so; b is its input.
fn unit(code: &str) -> String {
    format!(
        "<pou name=\"T\" pouType=\"functionBlock\"><interface><inputVars><variable name=\"b\"><type><BOOL/></type></variable></inputVars>\
         <outputVars><variable name=\"q\"><type><BOOL/></type></variable></outputVars></interface><body><ST><p>{code}</p></ST></body></pou>"
    )
}

const T: &str = "typeName=\"T\" instanceName=\"t\"";

#[test]
fn generators_leave_out_the_signs_of_variables() {
    // w holds what x was before.
    let with = |head: &str, source: &str| {
        let written = at(head, 4, &[(3, "")], "<expression>x</expression>");
        format!("<FBD>{}{}{source}{written}</FBD>", wired(1, "x"), out(2, (1, ""), "w"))
    };
    let (plain, variables) = (wired(3, "v"), "v:BOOL w:BOOL x:BOOL");
    let negated = plain.replace("<inVariable", "<inVariable negated=\"true\"");
    for (body, condition) in [
        (with("outVariable", &negated), "x = v"),
        (with("outVariable negated=\"true\"", &plain), "x = v"),
        (with("inOutVariable negatedIn=\"true\"", &plain), "x = v"),
        (with("outVariable storage=\"set\"", &plain), "w AND NOT v AND NOT x"),
        (with("outVariable storage=\"reset\"", &plain), "v AND x"),
        (with("outVariable edge=\"falling\"", &plain), "v AND x"),
    ] {
        assert_eq!(either("", variables, &body, condition), (true, false), "{body}");
    }
    for (body, condition) in [
        (with("outVariable", &negated), "x <> v"),
        (with("outVariable storage=\"set\"", &plain), "w AND NOT v AND x"),
        (with("outVariable", &plain), "x = v"),
    ] {
        assert_eq!(either("", variables, &body, condition), (true, true), "{body}");
    }
    let plain = with("outVariable", &plain);
    assert_eq!(either("", variables, &plain, "x <> v"), (false, false));
}

#[test]
fn generators_follow_one_sign_of_an_element() {
    let variables = "v:BOOL w:BOOL x:BOOL t:T";
    let with = |on_contact: &str, on_coil: &str| {
        let last = at(&format!("coil {on_coil}"), 4, &[(3, "")], "<variable>x</variable>");
        let (was, read) = (contact(1, "", 0, "x"), contact(3, on_contact, 0, "v"));
        format!("<LD>{RAIL}{was}{}{read}{last}</LD>", coil(2, 1, "w"))
    };
    for (body, condition) in [
        // They write NOT v, and set nothing; they look at no edge of what is negated, or sets.
        (with("", "negated=\"true\" storage=\"set\""), "v AND w AND NOT x"),
        (with("", "negated=\"true\" edge=\"falling\""), "v AND NOT x"),
        (with("", "storage=\"set\" edge=\"falling\""), "v AND NOT w AND x"),
        (with("negated=\"true\" edge=\"falling\"", ""), "v AND NOT x"),
    ] {
        assert_eq!(either(&unit(""), variables, &body, condition), (true, false), "{body}");
    }
    let pin = block(2, T, &[("b", (1, ""))], &["q"])
        .replace("\"b\"", "\"b\" negated=\"true\" edge=\"falling\"");
    let body = format!("<FBD>{}{pin}</FBD>", wired(1, "v"));
    let found = either(&unit("q := b;"), variables, &body, "v AND NOT t.q");
    assert_eq!(found, (true, false));
}

#[test]
fn generators_look_at_the_numbers_of_blocks_and_outputs_alone() {
    let variables = "u:BOOL v:BOOL x:BOOL t:T s:T";
    // They execute the block first.
    let body = format!(
        "<LD>{RAIL}{}{}{}{}</LD>",
        contact(1, "", 0, "u"),
        numbered(&coil(2, 1, "v"), 1),
        contact(3, "", 0, "v"),
        numbered(&block(4, T, &[("b", (3, ""))], &["q"]), 2)
    );
    assert_eq!(either(&unit("q := b;"), variables, &body, "t.q <> v"), (true, false));
    // They execute what an output asks for before it, but nothing that a block with a number asks for.
    let turns = unit("IF b THEN q := NOT q; ELSE q := b; END_IF");
    let asked = numbered(&block(4, T, &[("b", (1, ""))], &["q"]), 2);
    let body =
        format!("<FBD>{}{asked}{}</FBD>", wired(1, "TRUE"), numbered(&out(5, (4, "q"), "x"), 1));
    assert_eq!(either(&turns, variables, &body, "x = t.q"), (true, false));
    assert_eq!(either(&turns, variables, &body, "x <> t.q"), (true, true));
    let second =
        numbered(&block(6, "typeName=\"U\" instanceName=\"s\"", &[("b", (4, "q"))], &["q"]), 3);
    let units = turns + &unit("q := b;").replace("\"T\"", "\"U\"");
    let variables = variables.replace("s:T", "s:U");
    let body = format!(
        "<FBD>{}{asked}{second}{}</FBD>",
        wired(1, "TRUE"),
        numbered(&out(5, (6, "q"), "x"), 1)
    );
    assert_eq!(either(&units, &variables, &body, "x <> t.q AND x = s.q"), (true, false));
}

#[test]
fn generators_take_over_eno_where_it_is_true() {
    let variables = "e:BOOL v:BOOL w:BOOL x:BOOL t:T";
    for (head, pin) in [("typeName=\"MOVE\"", "IN"), (T, "b")] {
        let result = if pin == "IN" { "OUT" } else { "q" };
        let box_of =
            |connected: &[(&str, (u32, &str))]| block(5, head, connected, &["ENO", result]);
        let body = |drawn: &str| {
            format!(
                "<FBD>{}{}{}{}{drawn}{}</FBD>",
                wired(1, "x"),
                out(2, (1, ""), "w"),
                wired(3, "e"),
                wired(4, "v"),
                out(6, (5, "ENO"), "x")
            )
        };
        let enabled = body(&box_of(&[("EN", (3, "")), (pin, (4, ""))]));
        assert_eq!(either(&unit(""), variables, &enabled, "w AND NOT e AND x"), (true, false));
        assert_eq!(either(&unit(""), variables, &enabled, "w AND NOT e AND NOT x"), (true, true));
        assert_eq!(either(&unit(""), variables, &enabled, "NOT w AND NOT e AND x"), (false, false));
    }
}

#[test]
fn generators_hand_en_to_blocks_which_may_take_inputs_where_it_is_false() {
    let first = block(3, T, &[("b", (1, ""))], &["q"]);
    let second = block(5, T, &[("EN", (4, "")), ("b", (2, ""))], &["q"]);
    let body = format!(
        "<FBD>{}{}{first}{}{second}</FBD>",
        wired(1, "TRUE"),
        wired(2, "FALSE"),
        wired(4, "e")
    );
    assert_eq!(either(&unit(""), "e:BOOL t:T", &body, "NOT e AND NOT t.b"), (true, false));
    assert_eq!(either(&unit(""), "e:BOOL t:T", &body, "NOT e AND t.b"), (true, true));
    assert_eq!(either(&unit(""), "e:BOOL t:T", &body, "e AND t.b"), (false, false));
    // EN keeps its value in a call that leaves it out.
    let body = body.replace("localId=\"3\"", "localId=\"9\"").replace("x=\"3\"", "x=\"9\"");
    assert_eq!(either(&unit("q := b;"), "e:BOOL t:T", &body, "NOT e AND NOT t.q"), (true, false));
}

#[test]
fn an_output_is_negated_however_its_name_is_written() {
    let drawn = |output: &str| {
        let drawn = block(2, T, &[("b", (1, ""))], &["!Q"]);
        format!("<FBD>{}{drawn}{}</FBD>", wired(1, "v"), out(3, (2, output), "x"))
    };
    for output in ["q", "Q"] {
        let (body, variables) = (drawn(output), "v:BOOL x:BOOL t:T");
        assert_eq!(either(&unit("q := b;"), variables, &body, "x = v"), (false, false));
    }
}

#[test]
fn outputs_that_generators_may_take_for_others_are_refused() {
    let variables = "v:BOOL w:BOOL x:BOOL t:T";
    let text = |head: &str, pins: &[(&str, (u32, &str))], outputs: &[&str], taken: &str| {
        let drawn = block(3, head, pins, outputs);
        let ends = out(4, (3, taken), "x").replace(" formalParameter=\"\"", "");
        let second = pins.get(1).map_or(String::new(), |_| wired(2, "w"));
        let body = format!("<FBD>{}{second}{drawn}{ends}</FBD>", wired(1, "v"));
        let function =
            unit("q := b;").replace("functionBlock", "function").replace("\"T\"", "\"F\"");
        let function =
            function.replace("<interface>", "<interface><returnType><BOOL/></returnType>");
        project(&(unit("q := b;") + &function), variables, &body, "TRUE")
    };
    // Which output leads on is not said.
    let two = text(T, &[("b", (1, ""))], &["ENO", "q"], "");
    assert!(refusal(&two).contains("does not name the output of block with localId 3"));
    assert!(bound(&as_drawn(&two)).is_ok());
    assert!(bound(&text(T, &[("b", (1, ""))], &["q"], "")).is_ok());
    // ENO alone is given the result.
    let alone = text("typeName=\"MOVE\"", &[("EN", (1, "")), ("IN", (2, ""))], &["ENO"], "ENO");
    assert!(refusal(&alone).contains("only its output ENO is drawn"));
    assert!(bound(&as_drawn(&alone)).is_ok());
    // The first output is given the result.
    let of = "typeName=\"F\"";
    for outputs in [&["q"][..], &["q", "F"]] {
        let told = refusal(&text(of, &[("b", (1, ""))], outputs, "q"));
        assert!(told.contains("is not its result"), "{told}");
    }
    assert!(bound(&text(of, &[("b", (1, ""))], &["F", "q"], "q")).is_ok());
}

#[test]
fn rows_are_those_of_coils_and_blocks_alone() {
    // A contact stands above both coils, which are one row: the one on the left comes first, for older generators.
    let drawn = |second: (u32, u32)| {
        let first = coil(1, 0, "v").replace("<coil", "<coil storage=\"reset\"");
        format!(
            "<LD>{RAIL}{}{}{}</LD>",
            moved(&first, 100, 8),
            moved(&contact(2, "", 0, "v"), 5, 0),
            moved(&coil(3, 2, "x"), second.0, second.1)
        )
    };
    let variables = "v:BOOL x:BOOL";
    assert_eq!(either("", variables, &drawn((50, 14)), "x"), (true, false));
    assert_eq!(either("", variables, &drawn((50, 18)), "x"), (false, false));
}

#[test]
fn elements_between_rows_are_refused_where_their_order_matters() {
    let drawn = |middle: &str, height: u32| {
        let body = format!(
            "<LD>{RAIL}{}{}{}{}</LD>",
            moved(&coil(1, 0, "u"), 0, 0),
            moved(&coil(2, 0, middle), 100, 8),
            moved(&contact(3, "", 0, "v"), 5, 300),
            moved(&coil(4, 3, "x"), 50, height)
        );
        project("", "u:BOOL v:BOOL w:BOOL x:BOOL", &body, "x")
    };
    let told = refusal(&drawn("v", 16));
    assert!(
        told.contains("coil with localId 2: whether it comes before coil with localId 4"),
        "{told}"
    );
    // Nothing of the one is read by the other, or the rows are apart; a tool that executes the drawing itself sorts
    // nothing.
    assert!(bound(&drawn("w", 16)).is_ok());
    assert!(bound(&drawn("v", 18)).is_ok());
    assert!(bound(&as_drawn(&drawn("v", 16))).is_ok());
}

#[test]
fn what_says_twice_which_element_comes_first_is_refused() {
    let drawn = |number: u32| {
        let coils = numbered(&coil(1, 0, "x"), 1) + &numbered(&coil(2, 0, "v"), number);
        project("", "v:BOOL x:BOOL", &format!("<LD>{RAIL}{coils}</LD>"), "TRUE")
    };
    assert!(refusal(&drawn(1)).contains("another element has its executionOrderId"));
    assert!(bound(&drawn(2)).is_ok());
    for place in ["x=\"1\" y=\"1e2\"", "x=\"1\"", "x=\"\" y=\"2\""] {
        let text = drawn(2).replace("x=\"1\" y=\"0\"", place);
        assert!(refusal(&text).contains("its position is not a pair of numbers"));
    }
}

#[test]
fn signs_that_are_not_followed_are_refused() {
    let variables = "v:BOOL x:BOOL t:T";
    let row = |more: &str, of: &str| {
        let (read, written) = (contact(1, "", 0, "v"), coil(2, 1, "x"));
        let (front, back) = (wired(3, "v"), out(4, (3, ""), "x"));
        let both = out(5, (3, ""), "x").replace("outVariable", "inOutVariable");
        let called = block(6, T, &[("b", (3, ""))], &["q"]);
        let all = read + &written + &front + &back + &both + &called;
        let all = all.replacen(&format!("<{of}"), &format!("<{of} {more}"), 1);
        project(&unit(""), variables, &format!("<LD>{RAIL}{all}</LD>"), "TRUE")
    };
    for (more, of) in [
        ("negatedOut=\"true\"", "contact"),
        ("negatedIn=\"1\"", "contact"),
        ("negatedOut=\"true\"", "coil"),
        ("negatedIn=\"true\"", "inVariable"),
        ("negatedOut=\"true\"", "outVariable"),
        ("negated=\"true\"", "inOutVariable"),
        ("edgeIn=\"rising\"", "inOutVariable"),
        ("edgeOut=\"falling\"", "inOutVariable"),
        ("storageIn=\"set\"", "inOutVariable"),
        ("storageOut=\"reset\"", "inOutVariable"),
        ("negatedIn=\"true\"", "variable formalParameter=\"b\""),
    ] {
        let told = refusal(&row(more, of));
        let name = more.split('=').next().unwrap_or_default();
        assert!(told.contains(&format!("{name} is not followed")), "{told}");
    }
    assert!(bound(&row("edgeIn=\"none\" negatedIn=\"false\"", "inOutVariable")).is_ok());
}

#[test]
fn signs_in_drawn_conditions_are_refused_where_generators_leave_them_out() {
    let told = |source: &str, negated: &str| {
        let value = "<connectionPointIn><connection refLocalId=\"14\"/></connectionPointIn>";
        let body = chart(&[], value).replace("<condition>", &format!("<condition{negated}>"));
        let body = body.replace("</SFC>", &format!("<leftPowerRail localId=\"0\"/>{source}</SFC>"));
        project("", "v:BOOL x:BOOL", &body, "TRUE")
    };
    let plain = wired(14, "v");
    let text = told(&plain, "");
    assert!(bound(&text).is_ok(), "{:?}", bound(&text));
    let negated = plain.replace("<inVariable", "<inVariable negated=\"true\"");
    let edge = contact(14, "negated=\"true\" edge=\"rising\"", 0, "v");
    for text in [told(&negated, ""), told(&edge, "")] {
        let told = refusal(&text);
        assert!(told.contains("ignore a negation or an edge of it"), "{told}");
    }
    assert!(bound(&as_drawn(&told(&negated, ""))).is_ok());
    let whole = told(&plain, " negated=\"true\"");
    assert!(refusal(&whole).contains("ignore the negation of its condition"));
    assert!(bound(&as_drawn(&whole)).is_ok());
}

/// A function block with a chart of two steps in turn, whose conditions are what these outputs give; what is drawn
/// beside it, and its variables.
fn turning(drawn: &str, variables: &str, outputs: [(u32, &str); 2]) -> String {
    let variable = |(name, of): (&str, &str)| {
        format!("<variable name=\"{name}\"><type><derived name=\"{of}\"/></type></variable>")
    };
    let variables: String =
        variables.split_whitespace().filter_map(|one| one.split_once(':')).map(variable).collect();
    let transition = |id: u32, from: u32, (of, output): (u32, &str)| {
        let value = format!("<connection refLocalId=\"{of}\" formalParameter=\"{output}\"/>");
        let value =
            format!("<condition><connectionPointIn>{value}</connectionPointIn></condition>");
        at("transition", id, &[(from, "")], &value)
    };
    format!(
        "<pou name=\"F\" pouType=\"functionBlock\"><interface><localVars>{variables}</localVars></interface><body><SFC>{}{}{}{}{drawn}</SFC></body></pou>",
        at("step name=\"s\" initialStep=\"true\"", 1, &[(4, "")], ""),
        at("step name=\"u\"", 3, &[(2, "")], ""),
        transition(2, 1, outputs[0]),
        transition(4, 3, outputs[1])
    )
}

/// A project with these units, in which f of F is called, and a condition is asked for before and behind that, by the
/// fact that conditions read what the scan before has left.
fn turned(
    units: &str,
    variables: &str,
    (before, condition): (&str, &str),
) -> Result<bool, Vec<String>> {
    let call = format!("<ST><p>{before} f();</p></ST>");
    let text = project(units, &format!("f:F {variables}"), &call, condition);
    let facts = Facts { drawn_last_scan: true, ..Facts::default() };
    iec_xml::bound_by(&text, "ST", &facts).map(|found| found > 50)
}

#[test]
fn a_block_that_two_conditions_use_is_executed_once() {
    let counts = unit("q := b; n := n + 1;")
        .replace("<outputVars>", "<outputVars><variable name=\"n\"><type><INT/></type></variable>");
    let shared = wired(5, "TRUE") + &block(6, T, &[("b", (5, ""))], &["q"]);
    let chart = counts.clone() + &turning(&shared, "t:T", [(6, "q"), (6, "q")]);
    let asked = |count: u32| {
        let condition = format!("k > 0 AND k < 100 AND f.t.n = k + {count}");
        turned(&chart, "k:INT", ("k := f.t.n;", &condition)).expect("a bound")
    };
    assert!(asked(1) && !asked(2));
    // A block for each of them, of one instance: which comes first is not known.
    let apart = shared + &block(7, T, &[("b", (5, ""))], &["q"]);
    let chart = counts.clone() + &turning(&apart, "t:T", [(6, "q"), (7, "q")]);
    let told = turned(&chart, "k:INT", ("", "TRUE")).expect_err("a refusal").join("; ");
    assert!(told.contains("which of them comes first is not known"), "{told}");
    // Blocks that write nothing but what is their own may come in any order.
    let edge = |id: u32, of: &str| {
        let head = format!("typeName=\"R_TRIG\" instanceName=\"{of}\"");
        block(id, &head, &[("CLK", (5, ""))], &["Q"])
    };
    let apart = wired(5, "TRUE") + &edge(6, "r") + &edge(7, "t");
    let chart = turning(&apart, "r:R_TRIG t:R_TRIG", [(6, "Q"), (7, "Q")]);
    assert!(turned(&chart, "k:INT", ("", "TRUE")).is_ok());
}

#[test]
fn conditions_that_depend_on_each_others_blocks_are_refused_in_any_order_of_the_file() {
    let told = |units: &str, drawn: &[String], outputs| {
        let chart = units.to_owned() + &turning(&drawn.concat(), "t:T s:T r:R_TRIG", outputs);
        let told = turned(&chart, "v:BOOL w:BOOL", ("", "TRUE")).err()?.join("; ");
        assert!(told.contains("which of them comes first is not known"), "{told}");
        Some(told)
    };
    const R: &str = "typeName=\"R_TRIG\" instanceName=\"r\"";
    // A block writes v, of which the other condition looks at the edge.
    let behind = at("contact", 8, &[(6, "q")], "<variable>w</variable>");
    let edge = contact(7, "edge=\"rising\"", 0, "v");
    let drawn =
        [wired(5, "TRUE"), block(6, T, &[("b", (5, ""))], &["q"]), behind, RAIL.into(), edge];
    for turn in 0..drawn.len() {
        let mut drawn = drawn.clone();
        drawn.rotate_left(turn);
        let plain = drawn
            .clone()
            .map(|one| one.replace(T, R).replace("\"b\"", "\"CLK\"").replace("\"q\"", "\"Q\""));
        assert!(told(&unit("v := b;"), &drawn, [(8, ""), (7, "")]).is_some(), "{turn}");
        assert!(told(&unit("v := b;"), &drawn, [(7, ""), (8, "")]).is_some(), "{turn}");
        assert_eq!(told(&unit(""), &plain, [(8, ""), (7, "")]), None, "{turn}");
    }
    // The block leads to the edge: it is looked at first, but for the other condition behind the block.
    let edge = at("contact edge=\"rising\"", 7, &[(6, "q")], "<variable>v</variable>");
    let behind = at("contact", 8, &[(6, "q")], "<variable>w</variable>");
    let drawn = [wired(5, "TRUE"), block(6, T, &[("b", (5, ""))], &["q"]), behind, edge];
    assert!(told(&unit("v := b;"), &drawn, [(8, ""), (7, "")]).is_some());
    let [wire, writes, _, edge] = drawn;
    assert_eq!(told(&unit("v := b;"), &[wire, writes, edge], [(7, ""), (7, "")]), None);
    // Two blocks feed each other: each condition begins with another one.
    let other = "typeName=\"T\" instanceName=\"s\"";
    let ring =
        [block(5, T, &[("b", (6, "q"))], &["q"]), block(6, other, &[("b", (5, "q"))], &["q"])];
    assert!(told(&unit("q := b;"), &ring, [(5, "q"), (6, "q")]).is_some());
    assert_eq!(told(&unit("q := b;"), &ring, [(5, "q"), (5, "q")]), None);
}

#[test]
fn what_generators_do_otherwise_with_a_drawn_condition_is_refused() {
    let drawn = |number: u32| {
        let edge = block(6, "typeName=\"R_TRIG\" instanceName=\"r\"", &[("CLK", (5, ""))], &["Q"]);
        let edge = if number > 0 { numbered(&edge, number) } else { edge };
        turning(&(wired(5, "TRUE") + &edge), "r:R_TRIG", [(6, "Q"), (6, "Q")])
    };
    assert!(turned(&drawn(0), "", ("", "TRUE")).is_ok());
    let told = turned(&drawn(1), "", ("", "TRUE")).expect_err("a refusal").join("; ");
    assert!(told.contains("it has an executionOrderId in a condition"), "{told}");
    // A transition with an edge that the chart names twice.
    let named = |edge: &str, second: &str| {
        let body = format!("<LD>{RAIL}{}{}</LD>", contact(1, edge, 0, "v"), coil(2, 1, "Go"));
        let transition = |id: u32, from: u32, name: &str| {
            let value = format!("<condition><reference name=\"{name}\"/></condition>");
            at("transition", id, &[(from, "")], &value)
        };
        let chart = at("step name=\"s\" initialStep=\"true\"", 1, &[(4, "")], "")
            + &at("step name=\"u\"", 3, &[(2, "")], "")
            + &transition(2, 1, "Go")
            + &transition(4, 3, second);
        let text = project("", "v:BOOL", &format!("<SFC>{chart}</SFC>"), "TRUE");
        let transitions = format!(
            "<transitions><transition name=\"Go\"><body>{body}</body></transition></transitions>"
        );
        text.replacen("<interface/>", &format!("<interface/>{transitions}"), 1)
    };
    let rising = "edge=\"rising\"";
    let told = refusal(&named(rising, "go"));
    assert!(told.contains("several transitions of the chart refer to this one"), "{told}");
    assert!(bound(&named(rising, "v")).is_ok());
    assert!(bound(&named("", "Go")).is_ok());
}

#[test]
fn what_leads_to_nothing_is_refused_unless_generators_leave_it_out() {
    let refuses = |text: &str| {
        bound(text)
            .is_err_and(|told| told.concat().contains("connected to nothing that is executed"))
    };
    let both = |text: &str| (refuses(text), refuses(&as_drawn(text)));
    let drawn = |ends: &str| {
        let body = format!("<LD>{RAIL}{}{ends}</LD>", contact(1, "", 0, "v"));
        project("", "v:BOOL x:BOOL", &body, "TRUE")
    };
    let rail = at("rightPowerRail", 2, &[(1, "")], "");
    let connector = at("connector name=\"k\"", 2, &[(1, "")], "");
    for ends in ["", &rail, &(rail.clone() + &coil(3, 0, "x")), &connector] {
        assert_eq!(both(&drawn(ends)), (true, true), "{ends}");
    }
    assert_eq!(both(&drawn(&(rail + &coil(3, 1, "x")))), (false, false));
    let continued = coil(3, 4, "x") + &at("continuation name=\"k\"", 4, &[], "");
    assert_eq!(both(&drawn(&(connector + &continued))), (false, false));
    // Generators execute what outputs, coils and blocks ask for.
    let beside = |more: &str| {
        let body = format!("<FBD>{}{more}{}</FBD>", wired(1, "n + 1"), out(4, (5, ""), "x"));
        project("", "n:INT x:BOOL", &(body.replace("</FBD>", &wired(5, "TRUE")) + "</FBD>"), "TRUE")
    };
    let rail = at("rightPowerRail", 2, &[(1, "")], "");
    let connector = at("connector name=\"k\"", 2, &[(1, "")], "");
    for more in ["", &rail, &connector] {
        assert_eq!(both(&beside(more)), (false, true), "{more}");
    }
    assert_eq!(both(&beside(&out(2, (1, ""), "n"))), (false, false));
    assert_eq!(both(&beside("").replace("n + 1", "1")), (false, false));
    // The same beside a chart and in the condition of a transition.
    let block = |id: u32, from: u32| block(id, "typeName=\"NOT\"", &[("IN", (from, ""))], &["OUT"]);
    let chart = |more: &str| {
        let chart = turning(&(wired(5, "TRUE") + more), "", [(5, ""), (5, "")]);
        project(&chart, "f:F n:INT v:BOOL", "<ST><p>f();</p></ST>", "TRUE")
    };
    assert_eq!(both(&chart(&wired(6, "n + 1"))), (false, true));
    for more in [block(6, 5), RAIL.to_owned() + &contact(6, "", 0, "v"), block(6, 7) + &block(7, 6)]
    {
        assert_eq!(both(&chart(&more)), (true, true), "{more}");
    }
}

#[test]
fn generators_declare_actions_as_they_come_to_them() {
    let asked = |named: [&str; 2], condition: &str| {
        let action = |name: &str, code: &str| {
            format!("<action name=\"{name}\"><body><ST><p>{code}</p></ST></body></action>")
        };
        let actions = action("Reads", "x := v;") + &action("Writes", "v := TRUE;");
        let blocks = named
            .map(|name| format!("<action qualifier=\"N\"><reference name=\"{name}\"/></action>"));
        let step = at("step name=\"s\" initialStep=\"true\"", 1, &[], "");
        let chart = step + &at("actionBlock", 2, &[(1, "")], &blocks.concat());
        let unit = format!(
            "<pou name=\"F\" pouType=\"functionBlock\"><interface/><actions>{actions}</actions><body><SFC>{chart}</SFC></body></pou>"
        );
        let call = "<ST><p>v := FALSE; f();</p></ST>";
        let text = project(&unit, "f:F v:BOOL x:BOOL", call, condition);
        let facts = Facts { action_order: Some(ActionOrder::Declared), ..Facts::default() };
        iec_xml::bound_by(&text, "ST", &facts).expect("a bound") > 50
    };
    // As the step names them, which is not the order of the file.
    assert!(asked(["Writes", "Reads"], "x"));
    assert!(asked(["Reads", "Writes"], "NOT x"));
    assert!(!asked(["Reads", "Writes"], "x"));
}

#[test]
fn what_leads_to_a_connector_is_charged_for_each_of_its_continuations() {
    let continuation = |id: u32| at("continuation name=\"k\"", id, &[], "");
    let drawn = |ends: &[(u32, &str)]| {
        let row = contact(1, "", 0, "v") + &contact(2, "", 1, "w");
        let connector = at("connector name=\"k\"", 3, &[(2, "")], "");
        let ends = at("coil", 6, ends, "<variable>x</variable>");
        let body =
            format!("<LD>{RAIL}{row}{connector}{}{}{ends}</LD>", continuation(4), continuation(5));
        let text = project("", "v:BOOL w:BOOL x:BOOL", &body, "TRUE");
        iec_xml::bound_of(&text, "LD").expect("a bound")
    };
    let (one, two) = (drawn(&[(4, "")]), drawn(&[(4, ""), (5, "")]));
    assert!(two >= one + 2, "{one} {two}");
}

#[test]
fn connectors_of_one_unit_have_names_of_their_own() {
    let drawn = |name: &str| {
        let row = |id: u32, name: &str| {
            let ends = at(&format!("connector name=\"{name}\""), id, &[(0, "")], "");
            format!("<LD>{RAIL}{ends}</LD>")
        };
        let action =
            format!("<actions><action name=\"A\"><body>{}</body></action></actions>", row(1, "k"));
        let text = project("", "x:BOOL", &row(2, name), "TRUE");
        text.replacen("<interface/>", &format!("<interface/>{action}"), 1)
    };
    assert!(refusal(&drawn("k")).contains("another connector of the unit is called k"));
    assert!(bound(&drawn("l")).is_ok());
    assert!(bound(&as_drawn(&drawn("k"))).is_ok());
}

#[test]
fn no_program_is_left_out_for_want_of_a_name_or_a_kind() {
    let text = project("", "x:BOOL", "<ST><p>;</p></ST>", "TRUE");
    let task = |instances: &str| {
        let task = format!(
            "<resource name=\"r\"><task name=\"k\" priority=\"1\" interval=\"PT0.1S\">{instances}</task>"
        );
        text.replacen("<resource name=\"r\">", &task, 1)
    };
    let named = task(
        "<pouInstance name=\"m\" typeName=\"main\"/><pouInstance name=\"b\" typeName=\"behind\"/>",
    );
    let found = bound(&named).expect("a bound");
    assert!(found > 50);
    assert_eq!(bound(&named.replace("name=\"b\" ", "")).expect("a bound"), found);
    let twice = "<pouInstance typeName=\"behind\"/>".repeat(2);
    assert!(refusal(&task(&twice)).contains("have no name"));
    assert!(refusal(&task("<pouInstance/>")).contains("neither a name nor a type"));
    let kind = text.replacen("pouType=\"program\"", "pouType=\"Program\"", 1);
    assert!(refusal(&kind).contains("the pouType Program is not known"));
}

/// A function block with a variable that is handed over in and out.
fn counting() -> String {
    "<pou name=\"N\" pouType=\"functionBlock\"><interface><inOutVars><variable name=\"n\"><type><INT/></type></variable></inOutVars>\
     <outputVars><variable name=\"o\"><type><INT/></type></variable></outputVars></interface><body><ST><p>n := n + 1; o := n;</p></ST></body></pou>"
        .to_owned()
}

#[test]
fn what_generators_copy_from_an_instance_is_refused() {
    let of = |id: u32, name: &str, from: (u32, &str)| {
        let head = format!("typeName=\"N\" instanceName=\"{name}\"");
        block(id, &head, &[("n", from)], &["n", "o"])
    };
    let refuses = |parts: &[String]| {
        let text = project(
            &counting(),
            "i:INT k:INT f:N g:N",
            &format!("<FBD>{}</FBD>", parts.concat()),
            "TRUE",
        );
        assert!(bound(&as_drawn(&text)).is_ok(), "{text}");
        bound(&text).is_err_and(|told| told.concat().contains("generators copy"))
    };
    let first = [wired(1, "i"), of(2, "f", (1, ""))];
    for (second, refused) in [
        (of(3, "g", (2, "n")), true),
        (of(3, "g", (2, "o")), true),
        (out(3, (2, "n"), "k"), true),
        (out(3, (2, "o"), "k"), false),
        (of(3, "g", (1, "")), false),
    ] {
        assert_eq!(
            refuses(&[&first[..], std::slice::from_ref(&second)].concat()),
            refused,
            "{second}"
        );
    }
}

#[test]
fn or_that_generators_write_beside_and_without_parentheses_is_refused() {
    let variables = "b:BOOL c:BOOL d:BOOL x:BOOL";
    let refuses = |body: &str| {
        let text = project("", variables, &format!("<LD>{RAIL}{body}</LD>"), "TRUE");
        assert!(bound(&as_drawn(&text)).is_ok(), "{text}");
        bound(&text).is_err_and(|told| told.concat().contains("no parentheses"))
    };
    let and = |id: u32, of: &[(u32, &str)]| at("contact", id, of, "<variable>c</variable>");
    let ends = |from: u32| coil(9, from, "x");
    let continued = |inputs: &[(u32, &str)]| {
        at("connector name=\"k\"", 5, inputs, "") + &at("continuation name=\"k\"", 6, &[], "")
    };
    let (b, d) = (contact(1, "", 0, "b"), contact(2, "", 0, "d"));
    for (body, refused) in [
        (wired(1, "b OR d") + &and(3, &[(1, "")]) + &ends(3), true),
        (wired(1, "b XOR d") + &and(3, &[(1, "")]) + &ends(3), true),
        (wired(1, "b AND d") + &and(3, &[(1, "")]) + &ends(3), false),
        (wired(1, "b OR d") + &ends(1), false),
        (wired(1, "b OR d") + &d + &and(3, &[(1, ""), (2, "")]) + &ends(3), false),
        (contact(1, "", 0, "b OR d") + &ends(1), false),
        (contact(1, "", 0, "b OR d") + &and(3, &[(1, "")]) + &ends(3), true),
        (d.clone() + &contact(1, "", 2, "b OR d") + &ends(1), true),
        (d.clone() + &contact(1, "negated=\"true\"", 2, "b OR d") + &ends(1), false),
        (b.clone() + &d + &continued(&[(1, ""), (2, "")]) + &and(3, &[(6, "")]) + &ends(3), true),
        (b.clone() + &d + &continued(&[(1, ""), (2, "")]) + &ends(6), false),
        (b + &continued(&[(1, "")]) + &and(3, &[(6, "")]) + &ends(3), false),
    ] {
        assert_eq!(refuses(&body), refused, "{body}");
    }
}

#[test]
fn generators_leave_out_jumps_and_functions_that_are_given_nothing() {
    let head = |name: &str, of: &str| format!("{name} executionOrderId=\"{of}\"");
    let body = format!(
        "<LD>{RAIL}{}{}</LD>",
        at(&head("return", "1"), 2, &[(0, "")], ""),
        numbered(&out(3, (0, ""), "x"), 2)
    );
    assert_eq!(either("", "x:BOOL y:BOOL", &body, "x AND y"), (true, true));
    let text = project("", "x:BOOL", &body, "TRUE");
    assert_eq!(
        (bound(&text).expect("a bound"), bound(&as_drawn(&text)).expect("a bound")),
        (52, 51)
    );
    // They look at an edge before they execute the block that leads to it.
    let edge = at("contact edge=\"falling\"", 4, &[(2, "q")], "<variable>v</variable>");
    let writes = block(2, T, &[("b", (1, ""))], &["q"]);
    let body = format!("<LD>{}{writes}{edge}{}</LD>", wired(1, "TRUE"), coil(5, 4, "x"));
    let unit_of = unit("v := b; q := b;");
    assert_eq!(either(&unit_of, "t:T v:BOOL x:BOOL", &body, "v AND x"), (true, false));
    // A function with EN alone takes its time for others.
    let units = unit("F := TRUE; F := TRUE;")
        .replace("functionBlock", "function")
        .replace("\"T\"", "\"F\"");
    let units = units.replace("<interface>", "<interface><returnType><BOOL/></returnType>");
    let function = block(2, "typeName=\"F\"", &[("EN", (1, ""))], &["F"]);
    let text =
        project(&units, "v:BOOL", &format!("<FBD>{}{function}</FBD>", wired(1, "v")), "FALSE");
    assert!(bound(&text).expect("a bound") >= 2);
}

#[test]
fn pins_that_generators_would_swap_are_refused() {
    let drawn = |of: &str, pins: [&str; 2]| {
        let pins = [(pins[0], (1, "")), (pins[1], (2, ""))];
        let drawn = block(3, &format!("typeName=\"{of}\""), &pins, &["OUT"]);
        let body = format!(
            "<FBD>{}{}{drawn}{}</FBD>",
            wired(1, "i"),
            wired(2, "k"),
            out(4, (3, "OUT"), "x")
        );
        project("", "i:INT k:INT x:BOOL", &body, "TRUE")
    };
    for of in ["GT", "&lt;="] {
        let swapped = drawn(of, ["IN2", "IN1"]);
        assert!(refusal(&swapped).contains("the order of their names"));
        assert!(bound(&as_drawn(&swapped)).is_ok());
        assert!(bound(&drawn(of, ["IN1", "IN2"])).is_ok());
    }
    assert!(bound(&drawn("EQ", ["IN2", "IN1"])).is_ok());
}

#[test]
fn functions_with_an_unconnected_pin_before_a_connected_one_are_refused() {
    let drawn = |of: &str, pins: &[(&str, bool)]| {
        let all: Vec<_> = pins.iter().map(|(name, _)| (*name, (1, ""))).collect();
        let mut drawn = block(3, &format!("typeName=\"{of}\""), &all, &["OUT"]);
        for (name, _) in pins.iter().filter(|(_, is_connected)| !is_connected) {
            let pin = format!("\"{name}\"><connectionPointIn>");
            let wire = "<connection refLocalId=\"1\" formalParameter=\"\"/>";
            drawn = drawn.replace(&format!("{pin}{wire}"), &pin);
        }
        let body = format!("<FBD>{}{drawn}{}</FBD>", wired(1, "b"), out(4, (3, "OUT"), "x"));
        project("", "b:BOOL x:BOOL", &body, "TRUE")
    };
    let user = drawn("F", &[("u", false), ("v", true)]);
    assert!(refusal(&user).contains("an unconnected pin stands before a connected one"));
    for of in ["AND", "OR"] {
        let enabled = drawn(of, &[("EN", true), ("IN1", true), ("IN2", true)]);
        assert!(refusal(&enabled).contains("it has EN, but no ENO"));
        let gap = drawn(of, &[("IN1", true), ("IN2", true), ("IN3", false), ("IN4", true)]);
        assert!(refusal(&gap).contains("an unconnected pin stands before a connected one"));
        assert!(bound(&drawn(of, &[("IN1", true), ("IN2", true), ("IN3", false)])).is_ok());
    }
}

#[test]
fn coils_that_join_connections_are_refused_before_other_elements() {
    let edge = contact(1, "edge=\"rising\"", 0, "b");
    for (from, other) in [(0, String::new()), (5, contact(5, "", 0, "a"))] {
        let joins = at("coil", 2, &[(1, ""), (from, "")], "<variable>x</variable>");
        let drawn = |behind: &str, condition: &str| {
            let body = format!("<LD>{RAIL}{edge}{other}{joins}{behind}</LD>");
            project("", "b:BOOL x:BOOL y:BOOL", &body, condition)
        };
        let refuses = |behind: &str| {
            let told = bound(&drawn(behind, "TRUE"));
            told.is_err_and(|told| told.concat().contains("join them by AND"))
        };
        assert!(refuses(&coil(3, 2, "y")));
        assert!(refuses(&(contact(3, "", 2, "b") + &coil(4, 3, "y"))));
        assert!(!refuses(&at("rightPowerRail", 3, &[(2, "")], "")));
        assert!(!refuses(""));
        // Other tools join them by OR.
        let drawn = |condition: &str| bound(&as_drawn(&drawn(&coil(3, 2, "y"), condition)));
        assert!(drawn("x AND y").is_ok_and(|bound| bound > 50));
    }
}

#[test]
fn paths_that_fork_again_and_again_are_refused_at_once() {
    let declared = "v:BOOL x:BOOL";
    // Each of three contacts in a row is fed by two of the row before.
    let grid = |rows: u32| {
        let pairs = [(0, 1), (0, 2), (1, 2)];
        let contacts: String = (0..3 * rows)
            .map(|at| {
                let (row, (one, two)) = (at / 3, pairs[at as usize % 3]);
                let first = 3 * row.saturating_sub(1) + 1;
                let from = match row {
                    0 => vec![(0, "")],
                    _ => vec![(first + one, ""), (first + two, "")],
                };
                self::at("contact", at + 1, &from, "<variable>v</variable>")
            })
            .collect();
        let last: Vec<(u32, &str)> = (3 * rows - 2..=3 * rows).map(|id| (id, "")).collect();
        let coil = self::at("coil", 3 * rows + 1, &last, "<variable>x</variable>");
        project("", declared, &format!("<LD>{RAIL}{contacts}{coil}</LD>"), "x")
    };
    assert!(bound(&grid(3)).is_ok());
    assert!(refusal(&grid(40)).contains("fork and join too often"));
    // Each connector has two continuations, which join before the next one.
    let chain = |connectors: u32| {
        let mut body = RAIL.to_owned() + &contact(1, "", 0, "v");
        let mut last = vec![(1, "")];
        for at in 0..connectors {
            let id = 3 * at + 2;
            body += &self::at(&format!("connector name=\"k{at}\""), id, &last, "");
            for id in [id + 1, id + 2] {
                body += &self::at(&format!("continuation name=\"k{at}\""), id, &[], "");
            }
            last = vec![(id + 1, ""), (id + 2, "")];
        }
        body += &self::at("coil", 3 * connectors + 2, &last, "<variable>x</variable>");
        project("", declared, &format!("<LD>{body}</LD>"), "x")
    };
    assert!(bound(&chain(4)).is_ok());
    assert!(refusal(&chain(40)).contains("fork and join too often"));
}

//! Drawings of PLCopen XML as tools carry them out: in which order, how often contacts are looked at, and what that
//! costs.

use common::iec::xml as iec_xml;

use iec_xml::{
    RAIL, as_drawn, at, block, bound, bound_of, chart, coil, contact, may, moved, out, project,
    wired,
};

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
        let text = project(unit, "n:INT m:INT b:B", &body, "n <> 7 OR m <> 7");
        assert!(bound(&as_drawn(&text)).expect("a bound") <= 50);
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
    refused("x:BOOL", "<ST><p>IF 5 THEN x := TRUE; END_IF</p></ST>", "a Boolean is required");
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
    refused("x:BOOL", &told, "two conditions");
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
    let sets = block(2, "typeName=\"T\" instanceName=\"t\"", &[("c", (3, ""))], &["q"]);
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

/// A variable with a type of its own.
fn declared(name: &str, of: &str) -> String {
    format!("<variable name=\"{name}\"><type>{of}</type></variable>")
}

/// A drawing that resets v, calls a block `T` that nothing of it takes anything from, and takes v over into x.
fn resets_and_reads(more: &str, pins: &[(&str, (u32, &str))]) -> String {
    let reset = coil(1, 0, "v").replace("<coil", "<coil storage=\"reset\"");
    format!(
        "<LD>{RAIL}{}{more}{}{}{}</LD>",
        moved(&reset, 10, 0),
        moved(&block(2, "typeName=\"T\" instanceName=\"t\"", pins, &["q"]), 10, 50),
        moved(&contact(3, "", 0, "v"), 5, 500),
        moved(&coil(4, 3, "x"), 100, 500)
    )
}

/// The block `T`.
fn called(interface: &str, code: &str) -> String {
    format!(
        "<pou name=\"T\" pouType=\"functionBlock\"><interface>{interface}<outputVars>{}</outputVars></interface><body><ST><p>{code}</p></ST></body></pou>",
        declared("q", "<BOOL/>")
    )
}

/// A program p with a drawn action A, behind which the time of a loop is taken where a condition holds.
fn with_action(
    unit: &str,
    variables: &str,
    drawn: &str,
    (before, condition): (&str, &str),
) -> bool {
    let own = declared("t", "<derived name=\"T\"/>") + &declared("x", "<BOOL/>");
    let own = own + &declared("heavy", "<INT/>");
    let text = format!(
        "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><dataTypes/><pous>{unit}\
         <pou name=\"p\" pouType=\"program\"><interface><localVars>{own}</localVars>{variables}</interface>\
         <actions><action name=\"A\"><body>{drawn}</body></action></actions>\
         <body><ST><p>{before} A(); IF {condition} THEN FOR heavy := 1 TO 50 DO ; END_FOR END_IF</p></ST></body></pou></pous></types>\
         <instances><configurations><configuration name=\"c\"><resource name=\"r\"><task name=\"k\" priority=\"1\" interval=\"PT0.1S\"><pouInstance name=\"i\" typeName=\"p\"/></task>\
         <globalVars>{}</globalVars></resource></configuration></configurations></instances></project>",
        declared("w", "<BOOL/>")
    );
    bound(&text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}")) >= 50
}

#[test]
fn what_a_called_block_writes_of_the_drawing_s_own_variables_depends_on_the_order() {
    let v = declared("v", "<BOOL/>");
    let local = format!("<localVars>{v}</localVars>");
    let plain = resets_and_reads("", &[]);
    // Through a pointer that the drawing hands over, or that the block has already.
    let pointer = declared("r", "<pointer><baseType><BOOL/></baseType></pointer>");
    let through = called(&format!("<inputVars>{pointer}</inputVars>"), "r^ := TRUE; q := TRUE;");
    let address = moved(&wired(5, "ADR(v)"), 0, 50);
    let handed = resets_and_reads(&address, &[("r", (5, ""))]);
    // By the name of the program, or of its instance.
    let by_name = |name: &str| called("", &format!("{name}.v := TRUE; q := TRUE;"));
    let input = format!("<inputVars>{v}</inputVars>");
    // A variable of another list, which is shared in any case.
    let external =
        |name: &str| format!("<externalVars>{}</externalVars>", declared(name, "<BOOL/>"));
    let shared = called(&external("w"), "w := TRUE; q := TRUE;");
    for (unit, variables, drawn, before) in [
        (&through, &local, &handed, ""),
        (&through, &local, &plain, "t.r := ADR(v);"),
        (&by_name("p"), &local, &plain, ""),
        (&by_name("i"), &local, &plain, ""),
        (&by_name("p"), &input, &plain, ""),
        (&shared, &external("w"), &plain.replace(">v<", ">w<"), ""),
    ] {
        assert!(with_action(unit, variables, drawn, (before, "x")), "{unit}");
        assert!(with_action(unit, variables, drawn, (before, "NOT x")), "{unit}");
    }
    // Nothing of it is reached by a block that writes only what is its own.
    let own = called("", "q := TRUE;");
    assert!(!with_action(&own, &local, &plain, ("", "x")));
    let other = called(&external("w"), "w := TRUE; q := TRUE;");
    assert!(!with_action(&other, &local, &plain, ("", "x")));
}

#[test]
fn what_a_called_block_writes_of_a_global_instance_around_it_depends_on_the_order() {
    let outer = |name: &str| format!("<externalVars>{}</externalVars>", declared("g", name));
    let around = |of: &str, own: &str, body: &str| {
        format!(
            "<pou name=\"{of}\" pouType=\"functionBlock\"><interface>{own}</interface><body>{body}</body></pou>"
        )
    };
    let drawn = around(
        "Outer",
        &format!(
            "<inputVars>{}</inputVars><outputVars>{}</outputVars><localVars>{}</localVars>",
            declared("v", "<BOOL/>"),
            declared("x", "<BOOL/>"),
            declared("t", "<derived name=\"T\"/>")
        ),
        &resets_and_reads("", &[]),
    );
    let whole = around(
        "Whole",
        &format!("<localVars>{}</localVars>", declared("o", "<derived name=\"Outer\"/>")),
        "<ST><p>o();</p></ST>",
    );
    for (of, inner) in [("Outer", ""), ("Whole", ".o")] {
        let of = format!("<derived name=\"{of}\"/>");
        let sets = called(&outer(&of), &format!("g{inner}.v := TRUE; q := TRUE;"));
        let units = format!("{sets}{drawn}{whole}");
        for condition in ["x", "NOT x"] {
            let call = "<ST><p>g();</p></ST>";
            let condition = condition.replace('x', &format!("g{inner}.x"));
            let text = project(&units, "", call, &condition).replace(
                "<variable name=\"a\"",
                &format!("{}<variable name=\"a\"", declared("g", &of)),
            );
            assert!(bound(&text).expect("a bound") >= 50, "{condition}");
        }
    }
}

#[test]
fn a_drawing_with_too_many_values_that_controllers_differ_in_is_refused() {
    // A block between coils may change what leads to them.
    let unit =
        called(&format!("<externalVars>{}</externalVars>", declared("v", "<BOOL/>")), "v := TRUE;");
    let drawn = |count: u32| {
        let numbered = |text: &str, order: u32| {
            moved(text, 10, 10 * order).replacen(
                "localId",
                &format!("executionOrderId=\"{order}\" localId"),
                1,
            )
        };
        let pair = |at: u32| {
            let call = block(1000 + 2 * at, "typeName=\"T\" instanceName=\"t\"", &[], &["q"]);
            let coil = coil(1001 + 2 * at, 2, "x");
            numbered(&call, 2 * at + 1) + &numbered(&coil, 2 * at + 2)
        };
        let pairs: String = (0..count).map(pair).collect();
        let row = contact(1, "", 0, "v") + &contact(2, "", 1, "w");
        let body = format!("<LD>{RAIL}{row}{pairs}</LD>");
        project(&unit, "v:BOOL w:BOOL x:BOOL t:T", &body, "TRUE")
    };
    let loads = |count| bound_of(&drawn(count), "LD");
    let (few, more) = (loads(100).expect("a bound"), loads(300).expect("a bound"));
    assert!(more >= few + 2 * 200, "{few} {more}");
    let refused = loads(1100).expect_err("a refusal");
    assert!(refused.iter().any(|fault| fault.contains("differ in more than 1000")), "{refused:?}");
}

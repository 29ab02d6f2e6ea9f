//! What matiec, CODESYS and TwinCAT do with charts, as their sources and documentation have it.

use super::drawings::{checked, program, refused, st, vendors};
use scanbound::audit::{Audit, Failure, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// The audit of a text in which SIN takes 1 us, COS 2 us, and nothing else anything.
fn audited(text: &str, facts: &str, trust: Trust) -> Result<Audit, Failure> {
    let classes: String = CLASSES.iter().map(|class| format!("@{class},0,0\n")).collect();
    let rows = format!("instruction,on_us,off_us\n{classes}SIN,1,1\nCOS,2,2\n@end,0,\n");
    let table = Table::parse("t.csv", rows.as_bytes()).expect("a table").table;
    let inputs = [Input { name: "p.st".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::parse("facts.toml", facts).unwrap_or_else(|faults| panic!("{faults:?}"));
    audit(&Request { table: Some(&table), trust, ..Request::new(&inputs, &facts) })
}

/// The upper and the lower bound in microseconds.
fn bounds(text: &str, facts: &str, trust: Trust) -> (u64, u64) {
    let found = audited(text, facts, trust).unwrap_or_else(|failure| panic!("{failure:?}\n{text}"));
    (found.bound.upper.0 / 1_000_000, found.bound.lower.0 / 1_000_000)
}

/// A program that calls a block with this chart and executes SIN where `condition` is true after it.
fn after(chart: &str, condition: &str) -> String {
    format!(
        "FUNCTION_BLOCK FBX
         VAR_INPUT i0, i1 : BOOL; END_VAR
         VAR_OUTPUT v, cx : BOOL; END_VAR
         {chart}
         END_FUNCTION_BLOCK
         PROGRAM main
         VAR i0 AT %IX0.0 : BOOL; i1 AT %IX0.1 : BOOL; f : FBX; x : REAL; END_VAR
         f(i0 := i0, i1 := i1);
         IF {condition} THEN x := SIN(x); END_IF;
         END_PROGRAM"
    )
}

const DECLARED: &str = "[sfc]\naction_order = \"declared\"\n";

#[test]
fn each_block_of_a_boolean_variable_may_write_it() {
    let in_turn = "INITIAL_STEP A: END_STEP
         TRANSITION FROM A TO B := i0; END_TRANSITION
         TRANSITION FROM B TO C := i1; END_TRANSITION
         TRANSITION FROM C TO A := i0 AND i1; END_TRANSITION";
    let parallel = "INITIAL_STEP A: END_STEP
         TRANSITION FROM A TO (B, C) := i0; END_TRANSITION
         TRANSITION FROM (B, C) TO A := i1; END_TRANSITION";
    for (ways, b, c) in [
        // The time of SL is over while N has the variable on.
        (in_turn, "v(SL, T#2s);", "v(N); cx(N);"),
        (parallel, "v(SL, T#2s);", "v(N); cx(N);"),
        // R against pulses.
        (parallel, "v(P1); cx(P1);", "v(R);"),
        (in_turn, "v(P0); cx(P0);", "v(R);"),
        // What S has stored ends with the step that has N.
        (in_turn, "v(S);", "v(N); cx(P0);"),
    ] {
        let chart = format!("{ways} STEP B: {b} END_STEP STEP C: {c} END_STEP");
        for trust in [Trust::Counts, Trust::All] {
            for facts in ["", DECLARED] {
                let (upper, _) = bounds(&after(&chart, "f.cx AND NOT f.v"), facts, trust);
                assert_eq!(upper, 1, "{chart} {trust:?} {facts}");
            }
        }
    }
    // The reverse: no scan on matiec has the variable on while R is active.
    let chart = format!("{parallel} STEP B: v(P1); cx(P1); END_STEP STEP C: v(R); END_STEP");
    for trust in [Trust::Counts, Trust::All] {
        let (upper, lower) = bounds(&after(&chart, "f.cx AND f.v"), DECLARED, trust);
        assert_eq!((upper, lower), (1, 0), "{trust:?}");
    }
}

#[test]
fn a_boolean_variable_of_an_action_may_begin_with_true() {
    // N does not write it before its step is active. By the standard, it is FALSE after the first scan.
    let chart = "INITIAL_STEP A: cx(N); END_STEP STEP B: v(N); END_STEP
         TRANSITION FROM A TO B := i0; END_TRANSITION
         TRANSITION FROM B TO A := i1; END_TRANSITION";
    let text = after(chart, "f.cx AND f.v");
    assert_eq!(bounds(&text, "", Trust::All).0, 0);
    for (plain, other) in [
        ("VAR_OUTPUT v, cx", "VAR_OUTPUT RETAIN v : BOOL; END_VAR VAR_OUTPUT cx"),
        ("VAR_OUTPUT v, cx", "VAR_OUTPUT v : BOOL := TRUE; END_VAR VAR_OUTPUT cx"),
        ("f : FBX;", "f : FBX := (v := TRUE);"),
    ] {
        assert_eq!(bounds(&text.replace(plain, other), "", Trust::All).0, 1, "{other}");
    }
}

#[test]
fn a_time_that_is_over_in_the_scan_that_begins_it_again_may_count() {
    // R does not end the delay of SD on matiec: it is over in the scan that enters B again.
    let chart =
        "INITIAL_STEP A: END_STEP STEP B: v(SD, T#5s); cx(P1); END_STEP STEP C: v(R); END_STEP
         TRANSITION FROM A TO B := i0; END_TRANSITION
         TRANSITION FROM B TO C := i1; END_TRANSITION
         TRANSITION FROM C TO B := i0; END_TRANSITION";
    let again = "[controller]\n\"the time of SD or SL restarts when its step is entered again\" = true\n\"an SD delay continues although R is active\" = true\n";
    for trust in [Trust::Counts, Trust::All] {
        let text = after(chart, "f.cx AND f.v");
        assert_eq!(bounds(&text, &format!("{DECLARED}{again}"), trust).0, 1, "{trust:?}");
    }
}

#[test]
fn a_variable_in_a_block_without_a_qualifier_is_refused() {
    let chart = |block: &str| {
        format!(
            "INITIAL_STEP A: END_STEP STEP B: {block} cx(N); END_STEP
             TRANSITION FROM A TO B := i0; END_TRANSITION
             TRANSITION FROM B TO A := i1; END_TRANSITION"
        )
    };
    for block in ["v();", "v;"] {
        let told = audited(&after(&chart(block), "f.cx AND NOT f.v"), "", Trust::Counts);
        let told = format!("{:?}", told.err());
        assert!(told.contains("the block of the Boolean variable v has no qualifier"), "{told}");
    }
    assert_eq!(bounds(&after(&chart("v(N);"), "f.v"), "", Trust::Counts).0, 1);
}

#[test]
fn the_time_of_an_initial_step_may_run_before_its_chart_is_first_executed() {
    let program = |block: &str, condition: &str| {
        format!(
            "PROGRAM main
             VAR i0 AT %IX0.0 : BOOL; first : BOOL := TRUE; x : REAL; END_VAR
             INITIAL_STEP A: heavy({block}); one(N); END_STEP
             STEP B: END_STEP
             TRANSITION FROM A TO B := i0; END_TRANSITION
             ACTION heavy: IF {condition} THEN x := SIN(x); END_IF; END_ACTION
             ACTION one: IF first THEN x := COS(x); END_IF; first := FALSE; END_ACTION
             END_PROGRAM"
        )
    };
    for (block, condition) in
        [("D, T#5s", "TRUE"), ("N", "A.T > T#5s"), ("N", "A.T > T#1d AND A.T < T#2d")]
    {
        let (upper, _) = bounds(&program(block, condition), "", Trust::All);
        assert_eq!(upper, 3, "SIN in the first scan: {block} {condition}");
    }
    let stated = "[controller]\n\"the times of initial steps run before their chart is first executed\" = false\n";
    let (upper, _) = bounds(&program("D, T#5s", "TRUE"), stated, Trust::All);
    assert_eq!(upper, 2);
    // On such a controller, A is never active for less than 5 s.
    for (block, condition) in [("L, T#5s", "TRUE"), ("N", "A.T < T#5s")] {
        let text = program(block, condition).replace("COS(x)", "x");
        assert_eq!(bounds(&text, "", Trust::Counts), (1, 0), "{block} {condition}");
    }
}

/// What only CODESYS and TwinCAT do.
const CODESYS: &str = "[sfc]\naction_order = \"alphabetical\"\n";

#[test]
fn step_flags_of_codesys_change_where_the_chart_is_executed_next() {
    let chart = "INITIAL_STEP A: END_STEP STEP B: M(N); END_STEP
         TRANSITION FROM A TO B := i0; END_TRANSITION
         TRANSITION FROM B TO A := i1; END_TRANSITION
         ACTION M: cx := COS(1.0) > 0.5; END_ACTION";
    for trust in [Trust::None, Trust::Counts, Trust::All] {
        // B is active while its transition clears, and its flag is read after the call: COS and SIN.
        let left = after(chart, "f.B.X AND i1");
        assert_eq!(bounds(&left, CODESYS, trust), (3, 3), "{trust:?}");
        // The flag of B is on only after a call that has executed its action.
        let entered = after(chart, "f.B.X");
        assert_eq!(bounds(&entered, CODESYS, trust), (3, 3), "{trust:?}");
        let without = after(chart, "f.B.X AND NOT f.cx");
        let with_action = "ACTION M: cx := TRUE; END_ACTION";
        let without = without.replace("ACTION M: cx := COS(1.0) > 0.5; END_ACTION", with_action);
        let once = without.replace("cx := TRUE", "cx := TRUE; x := x");
        let once = once.replace("VAR_OUTPUT v, cx", "VAR x : REAL; END_VAR VAR_OUTPUT v, cx");
        assert_eq!(bounds(&once, CODESYS, trust).0, 0, "{trust:?}");
    }
}

#[test]
fn transitions_that_return_leaves_out_do_not_clear_again() {
    // RETURN in M ends the chart in the scan that enters B: in the next one, B is active and A is not, and the state
    // keeps what is known of charts.
    let chart = "VAR n : INT; END_VAR
         INITIAL_STEP A: END_STEP STEP B: M(N); END_STEP
         TRANSITION FROM A TO B := TRUE; END_TRANSITION
         TRANSITION FROM B TO A := FALSE; END_TRANSITION
         ACTION M: n := n + 1; cx := n = 2; RETURN; END_ACTION";
    let facts =
        format!("{CODESYS}[controller]\n\"RETURN in an action ends the whole chart\" = true\n");
    let found = audited(&after(chart, "f.cx"), &facts, Trust::All);
    let found = found.unwrap_or_else(|failure| panic!("{failure:?}"));
    assert_eq!(found.bound.lower.0, 1_000_000);
    assert!(found.is_reached(), "the second scan of B");
}

#[test]
fn flags_of_codesys_among_global_variables_are_refused() {
    let chart = "INITIAL_STEP A: END_STEP STEP B: cx(N); END_STEP
         TRANSITION FROM A TO B := i0; END_TRANSITION
         TRANSITION FROM B TO A := i1; END_TRANSITION";
    for flag in ["SFCTip", "SFCPause", "SFCInit", "SFCReset"] {
        let text = format!("VAR_GLOBAL {flag} : BOOL; END_VAR\n{}", after(chart, "f.cx"));
        let told = format!("{:?}", audited(&text, CODESYS, Trust::Counts).err());
        assert!(told.contains(&format!("the flag {flag} is not followed")), "{told}");
    }
}

#[test]
fn a_restart_may_execute_what_the_end_of_a_step_does() {
    let chart = "VAR SFCReset : BOOL; x : REAL; END_VAR
         INITIAL_STEP A: M(N); END_STEP STEP B: L(N); END_STEP
         TRANSITION FROM A TO B := i0; END_TRANSITION
         TRANSITION FROM B TO A := i1; END_TRANSITION
         ACTION L: x := SIN(x); END_ACTION
         ACTION M: x := COS(x); END_ACTION";
    let text = after(chart, "FALSE").replace("f(i0", "f.SFCReset := i1; f(i0");
    for trust in [Trust::Counts, Trust::All] {
        let (upper, lower) = bounds(
            &text.replace(" := i1; END_TRANSITION", " := FALSE; END_TRANSITION"),
            CODESYS,
            trust,
        );
        assert!(upper == 3 && lower < 3, "{upper} {lower} {trust:?}");
    }
}

#[test]
fn an_action_block_names_an_inherited_action_before_a_global_variable() {
    let text = "VAR_GLOBAL A : BOOL; END_VAR
         FUNCTION_BLOCK B
         VAR x : REAL; END_VAR
         x := x;
         ACTION A: x := SIN(x); END_ACTION
         END_FUNCTION_BLOCK
         FUNCTION_BLOCK D EXTENDS B
         INITIAL_STEP S0: A(N); END_STEP
         END_FUNCTION_BLOCK
         PROGRAM main VAR d1 : D; END_VAR d1(); END_PROGRAM";
    assert_eq!(bounds(text, CODESYS, Trust::Counts).0, 1);
}

#[test]
fn an_action_block_names_an_action_or_a_boolean_variable() {
    let with = |name: &str| {
        format!(
            "FUNCTION_BLOCK Q VAR x : REAL; END_VAR x := SIN(x); END_FUNCTION_BLOCK
             PROGRAM main
             VAR one : Q; n : INT; b : BOOL; END_VAR
             INITIAL_STEP S0: {name}(N); END_STEP
             END_PROGRAM"
        )
    };
    for name in ["one", "n"] {
        let told = format!("{:?}", audited(&with(name), "", Trust::Counts).err());
        assert!(told.contains("is neither an action nor a Boolean variable"), "{told}");
    }
    assert_eq!(bounds(&with("b"), "", Trust::Counts).0, 0);
}

#[test]
fn a_drawn_condition_that_names_a_transition_of_the_unit_is_refused() {
    let chart = "<SFC><step localId=\"1\" name=\"S0\" initialStep=\"true\"/><inVariable localId=\"5\"><expression>T1</expression></inVariable><transition localId=\"2\"><connectionPointIn><connection refLocalId=\"1\"/></connectionPointIn><condition><connectionPointIn><connection refLocalId=\"5\"/></connectionPointIn></condition></transition><step localId=\"3\" name=\"S1\"><connectionPointIn><connection refLocalId=\"2\"/></connectionPointIn></step></SFC>";
    let own = format!(
        "<transitions><transition name=\"T1\"><body>{}</body></transition></transitions><body><SFC>",
        st("T1 := b;")
    );
    let text = program("b:BOOL T1:BOOL", chart);
    assert_eq!(checked("transition-variable.xml", &text).code, Some(0));
    let text = text.replace("<body><SFC>", &own);
    refused("transition-object.xml", &text, "the condition T1 may be the transition");
    // A file without charts has no such question.
    assert_eq!(checked("transition-none.xml", &vendors("", &st(""), &st(""))).code, Some(0));
}

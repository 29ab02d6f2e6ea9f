//! What controllers do differently: the bound takes all that any of them does, and no more than each does by itself.

use scanbound::audit::{Audit, Failure, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::{FileKind, Input, detect};
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// What a scan takes, where a store takes a microsecond and nothing else anything.
pub(crate) fn audited(name: &str, text: &str, facts: &str) -> Result<Audit, Failure> {
    trusted(name, text, facts, Trust::None)
}

fn trusted(name: &str, text: &str, facts: &str, trust: Trust) -> Result<Audit, Failure> {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += "ST,1,1\n@end,0,\n";
    let table =
        Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table;
    let inputs = [Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::parse("facts.toml", facts).unwrap_or_else(|faults| panic!("{faults:?}"));
    let request = Request { table: Some(&table), trust, ..Request::new(&inputs, &facts) };
    audit(&request)
}

/// The most that the longest scan takes if nobody else writes what the program writes.
fn alone(text: &str) -> u64 {
    let found = trusted("main.st", text, "", Trust::All).unwrap_or_else(|why| panic!("{why:?}"));
    found.bound.upper.0 / Picos(1_000_000).0
}

/// The most microseconds that the longest scan takes, and the most of any scan found on one of the controllers.
fn bounds(text: &str, facts: &str) -> (u64, u64) {
    let audit = |facts: &str| {
        audited("main.st", text, facts).unwrap_or_else(|failure| panic!("{failure:?}"))
    };
    let us = |time: Picos| time.0 / Picos(1_000_000).0;
    let found = audit(facts);
    let (upper, any) = (us(found.bound.upper), us(found.bound.lower));
    // Controllers that follow the standard, that differ from it in one point, and in two.
    let points = found.readings.len();
    let others = (0..points).flat_map(|one| (one..points).map(move |other| vec![one, other]));
    let others = [vec![]].into_iter().chain((0..points).map(|one| vec![one])).chain(others);
    let mut lower = any;
    for others in others {
        if lower == upper {
            break;
        }
        let stated = found.readings.iter().enumerate();
        let stated = stated.map(|(at, one)| format!("{one:?} = {}\n", others.contains(&at)));
        let stated = format!("{facts}\n[controller]\n{}", stated.collect::<String>());
        let found = audit(&stated);
        assert!(us(found.bound.upper) <= upper, "{stated}");
        assert!(any <= us(found.bound.upper), "a scan is shorter there: {stated}");
        lower = lower.max(us(found.bound.lower));
    }
    (upper, lower)
}

/// The same of a program's variables and statements, of which those under a condition take what it is about.
fn of(variables: &str, body: &str) -> (u64, u64) {
    bounds(
        &format!(
            "PROGRAM main VAR x, y : BOOL; a AT %IX0.0 : BOOL; {variables} END_VAR {body} END_PROGRAM"
        ),
        "",
    )
}

/// The same of a chart with the inputs `a` to `d`.
fn chart(text: &str) -> String {
    format!(
        "PROGRAM main
         VAR x, y : BOOL; a AT %IX0.0 : BOOL; b AT %IX0.1 : BOOL; c AT %IX0.2 : BOOL; d AT %IX0.3 : BOOL; END_VAR
         {text}
         END_PROGRAM"
    )
}

fn of_chart(text: &str) -> (u64, u64) {
    bounds(&chart(text), "")
}

/// Three steps in a ring, each with its blocks.
fn ring(blocks: [&str; 3], actions: &str) -> String {
    let [one, two, three] = blocks;
    format!(
        "INITIAL_STEP S0: {one} END_STEP STEP S1: {two} END_STEP STEP S2: {three} END_STEP
         TRANSITION FROM S0 TO S1 := a; END_TRANSITION
         TRANSITION FROM S1 TO S2 := b; END_TRANSITION
         TRANSITION FROM S2 TO S0 := c; END_TRANSITION
         {actions}"
    )
}

#[test]
fn the_time_of_a_step_may_stay_and_is_one_in_a_scan() {
    let asked = |step: &str, condition: &str| {
        let action = format!("ACTION h: IF {condition} THEN x := TRUE; END_IF; END_ACTION");
        let blocks = match step {
            "S1" => ["", "h(N);", ""],
            "P1" => ["", "h(P1);", ""],
            _ => ["", "", "h(N);"],
        };
        of_chart(&ring(blocks, &action))
    };
    assert_eq!(asked("S2", "S1.T > T#1s"), (1, 1), "its last time");
    assert_eq!(asked("S2", "S1.T = T#0s"), (1, 1), "or none");
    assert_eq!(asked("S1", "S1.T > T#5s AND S1.T < T#7s"), (1, 1));
    assert_eq!(asked("S1", "S1.T > T#5s AND S1.T < T#3s"), (0, 0));
    assert_eq!(asked("S1", "S1.T < T#0s"), (0, 0));
    // It begins with 0; the final scan does without a step.
    assert_eq!(asked("P1", "S1.T > T#0s AND S1.X"), (0, 0));
}

/// Two ways out of a step, each to a step with an action of one store.
fn fork(one: &str, other: &str) -> String {
    chart(&format!(
        "INITIAL_STEP S0: END_STEP STEP S1: h(N); END_STEP STEP S2: k(N); END_STEP
         TRANSITION {one}; END_TRANSITION
         TRANSITION {other}; END_TRANSITION
         TRANSITION FROM S1 TO S0 := c; END_TRANSITION
         TRANSITION FROM S2 TO S0 := d; END_TRANSITION
         ACTION h: x := TRUE; END_ACTION
         ACTION k: x := TRUE; END_ACTION"
    ))
}

const FIRST: &str = "[sfc]\nselection = 'first'\n";
const ALL: &str = "[sfc]\nselection = 'all'\n";

#[test]
fn of_those_that_compete_without_priorities_the_first_or_all_clear() {
    let text = |one: &str, two: &str| {
        fork(&format!("{one} FROM S0 TO S1 := a"), &format!("{two} FROM S0 TO S2 := b"))
    };
    let (none, both) = (text("", ""), text("(PRIORITY := 1)", "(PRIORITY := 2)"));
    assert_eq!(bounds(&none, FIRST), (1, 1));
    assert_eq!(bounds(&none, ALL), (2, 2));
    assert_eq!(bounds(&none, "").0, 2, "either");
    // Where one has a priority and another has none, no document says which comes first.
    let mixed = audited("main.st", &text("(PRIORITY := 1)", ""), ALL);
    let mixed = format!("{:?}", mixed.err());
    assert!(
        mixed.contains("only some of the transitions after step S0 have a priority"),
        "{mixed}"
    );
    for facts in ["", FIRST, ALL] {
        assert_eq!(bounds(&both, facts), (1, 1), "{facts}");
    }
    // Those that execute actions in these orders let one clear.
    for order in ["named", "alphabetical"] {
        let facts = format!("[sfc]\naction_order = '{order}'\n");
        assert_eq!(bounds(&none, &facts), (1, 1), "{order}");
    }
    assert_eq!(bounds(&none, "[sfc]\naction_order = 'declared'\n").0, 2);
    assert!(Facts::parse("facts.toml", "[sfc]\nselection = 'both'\n").is_err());
    // The report says it, and which fact states which.
    let found = audited("main.st", &none, "").unwrap_or_else(|why| panic!("{why:?}"));
    let says =
        |one: &str| found.approximations.iter().any(|own| own.what.to_string().contains(one));
    assert!(says("[sfc] selection states which"));
}

#[test]
fn conditions_that_exclude_each_other_do_not_compete() {
    let text = |one: &str, two: &str| {
        fork(&format!("FROM S0 TO S1 := {one}"), &format!("FROM S0 TO S2 := {two}"))
    };
    assert_eq!(bounds(&text("a", "NOT a"), ""), (1, 1));
    assert_eq!(bounds(&text("a AND b", "NOT a AND b"), ""), (1, 1));
    assert_eq!(bounds(&text("a OR b", "NOT a"), "").0, 2);
    // What a condition calls may change what the next one reads.
    let calls = text("a", "NOT a AND flips(x)")
        + " FUNCTION flips : BOOL VAR_IN_OUT v : BOOL; END_VAR v := NOT v; flips := TRUE; END_FUNCTION";
    assert!(bounds(&calls, "").0 >= 2);
}

#[test]
fn a_stored_delay_may_outlast_r() {
    let text = |of: &str| {
        format!(
            "INITIAL_STEP S0: END_STEP STEP S1: h({of}); END_STEP STEP S2: h(R); END_STEP
             STEP S3: k(N); END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S1 TO S2 := b; END_TRANSITION
             TRANSITION FROM S2 TO S3 := c; END_TRANSITION
             TRANSITION FROM S3 TO S0 := d; END_TRANSITION
             ACTION h: x := TRUE; END_ACTION
             ACTION k: x := TRUE; END_ACTION"
        )
    };
    assert_eq!(of_chart(&text("SD, T#1s")), (2, 2));
    assert_eq!(of_chart(&text("S")), (1, 1));
    assert_eq!(of_chart(&text("DS, T#1s")), (1, 1));
}

#[test]
fn an_action_that_two_steps_have_may_come_once_for_each() {
    let actions = "ACTION h: x := TRUE; END_ACTION ACTION k: x := TRUE; END_ACTION";
    let of = |kind: &str| {
        of_chart(&ring(["", &format!("h({kind});"), &format!("h({kind}); k(N);")], actions))
    };
    assert_eq!(of("P1"), (2, 2));
    assert_eq!(of("P"), (2, 2));
    assert_eq!(of("N"), (2, 2));
    // The time of D may begin anew: k, and what else S2 has.
    let anew = ring(
        ["", "h(D, T#1s);", "h(D, T#1s);"],
        "ACTION h: IF NOT S2.X THEN y := FALSE; END_IF; END_ACTION",
    );
    assert_eq!(of_chart(&anew), (1, 1));
    // N in a step that is left and R in one that is entered.
    let held =
        ring(["", "h(N); h(R);", ""], "ACTION h: IF S1.X THEN x := TRUE; END_IF; END_ACTION");
    assert_eq!(of_chart(&held), (1, 1));
}

#[test]
fn actions_may_have_no_final_scan() {
    let text = "INITIAL_STEP S0: h(N); END_STEP STEP S1: k(P1); END_STEP
         TRANSITION FROM S0 TO S1 := a; END_TRANSITION
         TRANSITION FROM S1 TO S0 := b; END_TRANSITION
         ACTION h: y := S0.X; END_ACTION
         ACTION k: IF y THEN x := TRUE; x := TRUE; x := TRUE; END_IF; END_ACTION";
    // The last run would clear y, and takes a store.
    let named = "[sfc]\naction_order = 'named'\n";
    assert_eq!(bounds(&chart(text), named), (3, 3));
    assert_eq!(of_chart(text).0, 4, "if k comes first");
    assert_eq!(of_chart(&text.replace("IF y THEN", "IF y AND S0.X THEN")), (1, 1));
}

/// What a scan takes at most that has three more stores where this holds behind the call of a chart.
fn behind_call(transitions: &str, guard: &str) -> u64 {
    let text = format!(
        "VAR_GLOBAL y : BOOL; END_VAR
         FUNCTION_BLOCK chart VAR_INPUT a, b : BOOL; END_VAR {transitions} END_FUNCTION_BLOCK
         PROGRAM main
         VAR a AT %IX0.0 : BOOL; b AT %IX0.1 : BOOL; c : chart; x, p0, p5 : BOOL; END_VAR
         p0 := c.S0.X; p5 := c.S5.X; y := FALSE;
         c(a := a, b := b);
         IF {guard} THEN x := TRUE; x := TRUE; x := TRUE; END_IF
         END_PROGRAM"
    );
    bounds(&text, "").0
}

#[test]
fn the_time_of_sl_may_end_what_another_step_stores() {
    let chart = |first: &str| {
        format!(
            "INITIAL_STEP S0: END_STEP STEP S1: Act({first}); END_STEP
             STEP S2: Act(S); END_STEP STEP S5: Act(R); END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S1 TO S2 := b; END_TRANSITION
             TRANSITION FROM S2 TO S5 := a; END_TRANSITION
             TRANSITION FROM S5 TO S0 := b; END_TRANSITION
             ACTION Act: y := TRUE; END_ACTION"
        )
    };
    let off = "c.S2.X AND NOT y";
    for (first, more) in [("SL, T#100ms", true), ("S", false), ("N", false), ("SD, T#100ms", false)]
    {
        let without = behind_call(&chart(first), "FALSE");
        assert_eq!(behind_call(&chart(first), off) > without, more, "{first}");
    }
}

#[test]
fn a_transition_with_a_priority_may_end_its_steps_at_once() {
    let chart = |priority: &str| {
        format!(
            "INITIAL_STEP I: END_STEP STEP S0: END_STEP STEP S1: END_STEP
             STEP S5: END_STEP STEP S6: END_STEP
             TRANSITION FROM I TO (S0, S5) := TRUE; END_TRANSITION
             TRANSITION t1 {priority} FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION t2 FROM S5 TO S6 := NOT S0.X; END_TRANSITION
             TRANSITION FROM (S1, S6) TO I := b; END_TRANSITION"
        )
    };
    let both = "p0 AND p5 AND c.S1.X AND c.S6.X";
    for (priority, more) in [("(PRIORITY := 1)", true), ("", false)] {
        let without = behind_call(&chart(priority), "FALSE");
        assert_eq!(behind_call(&chart(priority), both) > without, more, "{priority}");
    }
}

#[test]
fn a_boolean_variable_may_stay_as_others_write_it() {
    let text = |before: &str| {
        format!(
            "VAR_GLOBAL v, a : BOOL; END_VAR
             PROGRAM one VAR_EXTERNAL v : BOOL; END_VAR {before} END_PROGRAM
             PROGRAM two VAR_EXTERNAL v, a : BOOL; END_VAR
             INITIAL_STEP S0: END_STEP STEP S1: v(N); END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S1 TO S0 := NOT a; END_TRANSITION
             END_PROGRAM
             PROGRAM three VAR_EXTERNAL v, a : BOOL; END_VAR VAR x : BOOL; END_VAR
             IF v AND NOT a THEN x := TRUE; x := TRUE; END_IF;
             END_PROGRAM
             CONFIGURATION c RESOURCE r ON p TASK t(INTERVAL := T#10ms, PRIORITY := 1);
             PROGRAM i1 WITH t : one; PROGRAM i2 WITH t : two; PROGRAM i3 WITH t : three;
             END_RESOURCE END_CONFIGURATION"
        )
    };
    // A store for the variable of the action, and for the other one.
    assert_eq!(bounds(&text("v := TRUE;"), ""), (4, 4));
    assert_eq!(alone(&text("")), 1, "nobody else writes it");
    assert_eq!(bounds(&text(""), ""), (3, 3), "an HMI may");
    let begins_on =
        text("").replace("VAR_GLOBAL v, a : BOOL;", "VAR_GLOBAL v : BOOL := TRUE; a : BOOL;");
    assert_eq!(bounds(&begins_on, ""), (3, 3));
}

#[test]
fn actions_of_one_scan_come_in_any_order_where_it_matters() {
    // Only in this order: clear, then write, then ask.
    let text = |named: &str, declared: [&str; 3]| {
        let body = |name: &str| match name.chars().last() {
            Some('1') => "n := 0;",
            Some('2') => "n := 5;",
            _ => "IF n = 5 THEN x := TRUE; x := TRUE; x := TRUE; END_IF;",
        };
        let actions = declared.map(|name| format!("ACTION {name}: {} END_ACTION ", body(name)));
        chart(&format!(
            "INITIAL_STEP S0: {named} END_STEP STEP S1: END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S1 TO S0 := b; END_TRANSITION {}",
            actions.concat()
        ))
        .replace("VAR x", "VAR n : INT; x")
    };
    let order = |of: &str| format!("[sfc]\naction_order = '{of}'\n");
    let long = text("a1(N); c3(N); b2(N);", ["a1", "c3", "b2"]);
    assert_eq!(bounds(&long, ""), (5, 5));
    assert_eq!(bounds(&long, &order("named")), (2, 2));
    assert_eq!(bounds(&long, &order("alphabetical")), (5, 5));
    assert_eq!(bounds(&long, &order("declared")), (2, 2));
    let declared = text("a1(N); b3(N); c2(N);", ["a1", "c2", "b3"]);
    assert_eq!(bounds(&declared, ""), (5, 5));
    assert_eq!(bounds(&declared, &order("named")), (2, 2));
    assert_eq!(bounds(&declared, &order("alphabetical")), (2, 2));
    assert_eq!(bounds(&declared, &order("declared")), (5, 5));
    // An order that none of these has: it is covered, and no run is shown.
    let other = text("a1(N); b3(N); c2(N);", ["a1", "b3", "c2"]);
    assert_eq!(bounds(&other, ""), (5, 2));
    assert!(Facts::parse("facts.toml", "[sfc]\naction_order = 'last'\n").is_err());
}

#[test]
fn actions_that_have_ended_may_come_before_the_others() {
    // In the scan in which S2 begins, aa and cc have ended, and bb has just begun.
    let text = chart(&ring(
        ["aa(N); bb(N);", "aa(N); cc(N);", "bb(N);"],
        "ACTION aa: n := 0; END_ACTION ACTION cc: n := 5; END_ACTION
         ACTION bb: IF S2.X AND n = 5 THEN x := TRUE; x := TRUE; x := TRUE; END_IF; END_ACTION",
    ))
    .replace("VAR x", "VAR n : INT; x");
    let order = |of: &str| format!("[sfc]\naction_order = '{of}'\n");
    assert_eq!(bounds(&text, &order("alphabetical")).0, 5);
    let named = bounds(&text, &order("named"));
    assert!(named.0 < 5, "{named:?}");
    assert_eq!(bounds(&text, ""), (5, 5));
}

#[test]
fn a_boolean_variable_may_be_written_before_actions() {
    let text = chart(&ring(
        ["", "h(P1); v(N);", ""],
        "ACTION h: IF v THEN x := TRUE; x := TRUE; END_IF; END_ACTION",
    ))
    .replace("VAR x", "VAR v : BOOL; x");
    // One store for the variable.
    assert_eq!(alone(&text), 3);
    let facts = "[sfc]\naction_order = 'named'\n";
    let found =
        trusted("main.st", &text, facts, Trust::All).unwrap_or_else(|why| panic!("{why:?}"));
    assert_eq!(found.bound.upper.0 / 1_000_000, 1);
}

/// Functions that change what they are handed, and what is global.
const CHANGING: &str = "VAR_GLOBAL g : INT; END_VAR
    FUNCTION F : INT VAR_IN_OUT v : INT; END_VAR v := v + 1; F := 0; END_FUNCTION
    FUNCTION T : BOOL VAR_IN_OUT v : INT; END_VAR v := v + 1; T := TRUE; END_FUNCTION
    FUNCTION D : INT VAR_IN_OUT v : INT; END_VAR v := v * 2; D := 0; END_FUNCTION
    FUNCTION G : INT VAR_INPUT a, b : INT; END_VAR G := a; END_FUNCTION
    FUNCTION H : INT VAR_EXTERNAL g : INT; END_VAR g := g + 1; H := 0; END_FUNCTION ";

#[test]
fn operands_are_worked_out_from_left_to_right_or_from_right_to_left() {
    let may = |body: &str, then: &str| {
        let text = |then: &str| {
            format!(
                "{CHANGING} PROGRAM main VAR x : BOOL; n, m : INT; b : ARRAY[0..9] OF INT; END_VAR
                 n := 3; g := 3; {body} IF {then} THEN x := TRUE; END_IF END_PROGRAM"
            )
        };
        let (without, with) = (bounds(&text("FALSE"), ""), bounds(&text(then), ""));
        (with.0 > without.0, with.1 > without.1)
    };
    let (yes, no) = ((true, true), (false, false));
    for (body, either, never) in [
        ("m := n + F(v := n);", ["m = 3", "m = 4"], "m = 5"),
        ("m := F(v := n) + n;", ["m = 3", "m = 4"], "m = 5"),
        ("m := g - H();", ["m = 3", "m = 4"], "m = 5"),
        ("m := MAX(n, F(v := n));", ["m = 3", "m = 4"], "m = 5"),
        ("m := G(n, F(v := n));", ["m = 3", "m = 4"], "m = 5"),
        ("IF n = 3 AND T(v := n) THEN m := 1; ELSE m := 2; END_IF;", ["m = 1", "m = 2"], "n < 3"),
        ("x := n = F(v := n) + 4; m := SEL(x, 0, 1);", ["m = 0", "m = 1"], "n <> 4"),
        ("m := F(v := n) + D(v := n);", ["n = 7", "n = 8"], "n = 6"),
        ("b[3] := 0; b[4] := 0; b[n] := F(v := n) + 9;", ["b[3] = 9", "b[4] = 9"], "n <> 4"),
        ("b[3] := 1; b[4] := 2; m := b[n] + F(v := n);", ["m = 1", "m = 2"], "m = 3"),
        ("b[0] := 7; m := n + b[F(v := n)];", ["m = 10", "m = 11"], "m = 12"),
        ("m := 2 * n + G(1, n) + m * F(v := n) - m * 0 - 1;", ["m = 8", "m = 8"], "n = 3"),
    ] {
        // The last one is a chain of which both ends agree but for what F changes.
        let own = if body.starts_with("m := 2") { &either[..0] } else { &either[..] };
        for then in own {
            assert_eq!(may(body, then), yes, "{body} {then}");
        }
        assert_eq!(may(body, never), no, "{body} {never}");
    }
    // What changes nothing else is worked out once.
    let pure = |body: &str| {
        let text =
            format!("{CHANGING} PROGRAM main VAR x : BOOL; n, m : INT; END_VAR {body} END_PROGRAM");
        audited("main.st", &text, "").unwrap_or_else(|why| panic!("{why:?}")).instructions
    };
    assert_eq!(pure("m := n + G(n, 1);"), pure("m := G(n, 1) + n;"));
    assert!(pure("m := n + G(n, 1);") < pure("m := n + F(v := n);"));
}

#[test]
fn so_many_calls_whose_order_matters_are_refused() {
    let chain = ["F(v := n)"; 7].join(" + ");
    let text = format!("{CHANGING} PROGRAM main VAR n, m : INT; END_VAR m := {chain}; END_PROGRAM");
    let told = audited("main.st", &text, "").map(|_| ());
    assert!(matches!(told, Err(Failure::Input(_))), "{told:?}");
}

#[test]
fn a_falling_edge_may_be_seen_in_the_first_call() {
    let of = |kind: &str| {
        alone(&format!(
            "PROGRAM main VAR x, done : BOOL; f : {kind}; a AT %IX0.0 : BOOL; END_VAR
             f(CLK := a); IF f.Q AND NOT done THEN x := TRUE; x := TRUE; END_IF; done := TRUE;
             END_PROGRAM"
        ))
    };
    // Two stores in every scan.
    assert_eq!(of("F_TRIG"), 4);
    assert_eq!(of("R_TRIG"), 4);
}

#[test]
fn a_timer_at_rest_may_keep_its_time_or_lose_it() {
    let is = |kind: &str, calls: &str, then: &str| {
        let body = format!("{calls} IF {then} THEN x := TRUE; END_IF");
        let (upper, _) = of(&format!("t : {kind};"), &body);
        upper - u64::try_from(calls.matches(":=").count()).expect("few")
    };
    let (on, off) = ("t(IN := TRUE, PT := T#1s);", "t(IN := FALSE, PT := T#1s);");
    let over = format!("{on}{off}{off}");
    assert_eq!(is("TOF", &over, "NOT t.Q AND t.ET = T#1s"), 1);
    assert_eq!(is("TOF", &over, "NOT t.Q AND t.ET = T#0s"), 1);
    assert_eq!(is("TOF", &over, "NOT t.Q AND t.ET = T#2s"), 0);
    let pulse = format!("{off}{on}{off}");
    assert_eq!(is("TP", &pulse, "NOT t.Q AND t.ET = T#0s"), 1);
    assert_eq!(is("TP", &pulse, "NOT t.Q AND t.ET = T#1s"), 1);
}

#[test]
fn counters_may_stop_at_their_preset_and_at_0() {
    let up = "c(CU := FALSE, PV := 3); n := c.CV; c(CU := TRUE, PV := 3);";
    let up =
        |then: &str| of("c : CTU; n : INT;", &format!("{up} IF {then} THEN x := TRUE; END_IF"));
    let calls = up("FALSE").0;
    assert_eq!(up("c.CV = n AND n >= 3 AND n < 100").0, calls + 1);
    assert_eq!(up("c.CV = n + 1 AND n >= 3 AND n < 100").0, calls + 1);
    assert_eq!(up("c.CV = n AND n > 0 AND n < 3").0, calls);
    assert_eq!(up("n < 100 AND n >= 0 AND c.CV > n + 1").0, calls);
    assert_eq!(up("NOT c.Q AND n >= 3"), (calls, calls));
    let down =
        "c(CD := FALSE, LD := FALSE, PV := 3); n := c.CV; c(CD := TRUE, LD := FALSE, PV := 3);";
    let down =
        |then: &str| of("c : CTD; n : INT;", &format!("{down} IF {then} THEN x := TRUE; END_IF"));
    let calls = down("FALSE").0;
    assert_eq!(down("c.CV = n AND n = 0").0, calls + 1);
    assert_eq!(down("c.CV = -1 AND n = 0").0, calls + 1);
    assert_eq!(down("c.CV = n AND n > 0").0, calls);
    let both = "c(CU := FALSE, CD := FALSE, R := FALSE, LD := FALSE, PV := 3); n := c.CV;
        c(CU := FALSE, CD := TRUE, R := FALSE, LD := FALSE, PV := 3);";
    let both =
        |then: &str| of("c : CTUD; n : INT;", &format!("{both} IF {then} THEN x := TRUE; END_IF"));
    let calls = both("FALSE").0;
    assert_eq!(both("c.CV = n AND n = 0").0, calls + 1);
    assert_eq!(both("c.CV = n AND n = 1").0, calls);
}

#[test]
fn a_time_as_a_number_may_be_in_any_unit() {
    let is = |variables: &str, body: &str, then: &str| {
        of(variables, &format!("{body} IF {then} THEN x := TRUE; END_IF")).0
    };
    assert_eq!(is("n : DINT;", "n := TIME_TO_DINT(T#5s);", "n = 5"), 2);
    assert_eq!(is("n : DINT;", "n := TIME_TO_DINT(T#5s);", "n = 5000"), 2);
    assert_eq!(is("t : TIME;", "t := DINT_TO_TIME(5);", "t = T#5s"), 2);
    assert_eq!(is("t : TIME;", "t := TO_TIME(5);", "t = T#5ms"), 2);
    assert_eq!(is("n : REAL;", "n := TIME_TO_REAL(T#5s);", "n = 5.0"), 2);
    assert_eq!(is("t, u : TIME;", "t := T#5s; u := t;", "u <> T#5s"), 2, "only the stores");
}

#[test]
fn crossed_limits_give_either() {
    let is = |limits: &str, then: &str| {
        let body = format!("n := 3; n := LIMIT({limits}); IF {then} THEN x := TRUE; END_IF");
        of("n, low, high : INT;", &body)
    };
    assert_eq!(is("10, n, 5", "n = 10"), (3, 3));
    assert_eq!(is("10, n, 5", "n = 5"), (3, 3));
    assert_eq!(is("10, n, 5", "n = 3"), (2, 2));
    assert_eq!(is("4, n, 5", "n = 5"), (2, 2));
    assert_eq!(is("low, n, high", "low <= high AND (n < low OR n > high)"), (2, 2));
}

#[test]
fn timers_whose_time_changes_are_asked_anew_or_not_and_others_keep_what_they_gave() {
    // Two calls with a time of 0 have it on, whatever was before.
    let ton = |preset: &str, then: &str| {
        let body = format!(
            "t(IN := TRUE, PT := T#0s); t(IN := TRUE, PT := T#0s);
             IF t.Q THEN t(IN := TRUE, PT := {preset}); IF {then} THEN x := TRUE; END_IF END_IF"
        );
        of("t : TON;", &body).0
    };
    let calls = ton("T#24h", "FALSE");
    assert_eq!(ton("T#24h", "NOT t.Q"), calls + 1);
    assert_eq!(ton("T#24h", "t.Q"), calls + 1);
    assert_eq!(ton("T#0s", "NOT t.Q"), calls, "the time is always the same");
    let tof = "t(IN := FALSE, PT := T#1s); IF NOT t.Q THEN t(IN := FALSE, PT := T#1h); IF t.Q THEN x := TRUE; END_IF END_IF";
    assert_eq!(of("t : TOF;", tof).0, 5);
    assert_eq!(of("t : TOF;", &tof.replace("T#1h", "T#1s")).0, 4);
}

#[test]
fn the_time_that_has_elapsed_lies_within_the_preset_and_begins_with_0() {
    let is = |kind: &str, calls: &str, then: &str| {
        let body = format!("{calls} IF {then} THEN x := TRUE; END_IF");
        let (upper, lower) = of(&format!("t : {kind};"), &body);
        let stores = u64::try_from(calls.matches(":=").count()).expect("few");
        (upper - stores, lower - stores)
    };
    let on = "t(IN := TRUE, PT := T#1s);";
    let off = "t(IN := FALSE, PT := T#1s);";
    for kind in ["TON", "TOF", "TP"] {
        assert_eq!(is(kind, on, "t.ET > T#1s AND t.PT = T#1s AND t.Q"), (0, 0), "{kind}");
        assert_eq!(is(kind, on, "t.ET < T#0s AND t.Q"), (0, 0), "{kind}");
    }
    assert_eq!(is("TON", on, "t.ET > T#300ms AND NOT t.Q"), (1, 1));
    assert_eq!(is("TON", on, "t.ET < T#1s AND t.Q"), (0, 0));
    // Controllers measure times more finely than in milliseconds.
    assert_eq!(is("TON", on, "t.ET > T#1ms AND t.ET < T#2ms"), (1, 1));
    assert_eq!(is("TON", on, "t.ET > T#0s AND t.ET < T#1ms"), (1, 1));
    assert_eq!(is("TON", on, "t.ET > T#999ms AND NOT t.Q"), (1, 1));
    assert_eq!(is("TON", on, "t.ET >= T#1s AND NOT t.Q"), (0, 0));
    assert_eq!(is("TON", on, "t.Q AND t.ET <> T#1s AND t.PT = T#1s"), (0, 0));
    assert_eq!(is("TON", &format!("{on}{off}"), "t.ET > T#0s"), (0, 0));
    assert_eq!(is("TON", &format!("{off}{on}"), "t.ET > T#0s"), (0, 0));
    assert_eq!(is("TOF", &format!("{off}{on}"), "t.ET > T#0s"), (0, 0));
    assert_eq!(is("TOF", off, "t.ET > T#300ms AND t.Q"), (1, 1));
    assert_eq!(is("TP", on, "t.ET > T#300ms AND t.Q"), (1, 1));
    // What has run does not run back; how two moments within one millisecond follow each other is not known.
    let twice = format!("{on} u := t.ET; {on}");
    let body = format!("{twice} IF t.ET + T#1ms < u AND NOT t.Q THEN x := TRUE; END_IF");
    assert_eq!(of("t : TON; u : TIME;", &body), (5, 5));
}

#[test]
fn a_pin_with_two_names_is_one() {
    let is = |kind: &str, call: &str, then: &str| {
        of(&format!("s : {kind};"), &format!("s({call}); IF {then} THEN x := TRUE; END_IF"))
    };
    assert_eq!(is("SR", "S1 := FALSE, R := TRUE", "s.Q1"), (2, 2));
    assert_eq!(is("SR", "SET1 := FALSE, RESET := TRUE", "s.Q1"), (2, 2));
    assert_eq!(is("SR", "SET1 := TRUE, RESET := TRUE", "NOT s.Q1"), (2, 2));
    assert_eq!(is("RS", "SET := TRUE, RESET1 := FALSE", "NOT s.Q1"), (2, 2));
    assert_eq!(is("RS", "S := TRUE, R1 := TRUE", "s.Q1"), (2, 2));
    assert_eq!(is("CTU", "RESET := TRUE, PV := 3", "s.CV <> 0"), (2, 2));
    assert_eq!(is("CTU", "R := TRUE, PV := 3", "s.RESET"), (3, 3));
    assert_eq!(is("CTD", "LOAD := TRUE, PV := 3", "s.CV <> 3"), (2, 2));
}

#[test]
fn return_ends_an_action_or_the_whole_chart() {
    let text = "INITIAL_STEP S0: h(N); k(N); END_STEP STEP S1: END_STEP
         TRANSITION FROM S0 TO S1 := a; END_TRANSITION
         TRANSITION FROM S1 TO S0 := b; END_TRANSITION
         ACTION h: y := TRUE; RETURN; END_ACTION
         ACTION k: y := FALSE; END_ACTION";
    assert_eq!(of_chart(text).0, 2);
    // The rest of the chart may be left out.
    let behind = format!(
        "FUNCTION_BLOCK f VAR_INPUT a, b : BOOL; END_VAR VAR_OUTPUT y : BOOL; END_VAR
         {text} END_FUNCTION_BLOCK
         PROGRAM main VAR i : f; x : BOOL; END_VAR
         i(); IF i.S0.X AND i.y THEN x := TRUE; x := TRUE; x := TRUE; END_IF;
         END_PROGRAM"
    );
    let named = "[sfc]\naction_order = 'named'\n";
    assert_eq!(bounds(&behind, named), (4, 4));
    assert_eq!(bounds(&behind, "").0, 5, "if k comes first");
    let without = behind.replace("RETURN;", "");
    assert_eq!(bounds(&without, named), (2, 2));
}

/// A project in XML: units, and the elements of the program's drawing.
fn drawn(units: &str, variables: &str, body: &str) -> String {
    format!(
        r#"<project xmlns="http://www.plcopen.org/xml/tc6_0201"><types><dataTypes/><pous>{units}
        <pou name="main" pouType="program"><interface>{variables}</interface><body>{body}</body></pou></pous></types>
        <instances><configurations><configuration name="c"><resource name="r"><task name="t" priority="0" interval="T#10ms">
        <pouInstance name="p" typeName="main"/></task><globalVars><variable name="G"><type><BOOL/></type></variable></globalVars>
        </resource></configuration></configurations></instances></project>"#
    )
}

fn variable(name: &str, of: &str) -> String {
    format!(r#"<variable name="{name}"><type>{of}</type></variable>"#)
}

fn of_type(name: &str) -> String {
    format!(r#"<derived name="{name}"/>"#)
}

/// A function block with an input `go`.
fn block(name: &str, variables: &str, body: &str) -> String {
    let go = variable("go", "<BOOL/>");
    format!(
        r#"<pou name="{name}" pouType="functionBlock"><interface><inputVars>{go}</inputVars>{variables}</interface>
        <body><ST><p xmlns="http://www.w3.org/1999/xhtml">{body}</p></ST></body></pou>"#
    )
}

fn placed(kind: &str, id: u32, y: u32, more: &str, inner: &str) -> String {
    format!(r#"<{kind} localId="{id}" {more}><position x="{}" y="{y}"/>{inner}</{kind}>"#, id * 10)
}

fn from(id: u32) -> String {
    format!(r#"<connectionPointIn><connection refLocalId="{id}"/></connectionPointIn>"#)
}

fn call(id: u32, y: u32, of: &str, instance: &str, input: u32, more: &str) -> String {
    let go = format!(
        r#"<inputVariables><variable formalParameter="go">{}</variable></inputVariables>"#,
        from(input)
    );
    let more = format!(r#"typeName="{of}" instanceName="{instance}" {more}"#);
    placed("block", id, y, &more, &format!("{go}<inOutVariables/><outputVariables/>"))
}

#[test]
fn a_contact_may_be_looked_at_again_behind_a_block_that_writes_its_variable() {
    let heavy = block(
        "heavy",
        &format!("<localVars>{}</localVars>", variable("x", "<BOOL/>")),
        "IF go THEN x := TRUE; x := TRUE; x := TRUE; END_IF;",
    );
    let external = format!("<externalVars>{}</externalVars>", variable("G", "<BOOL/>"));
    let flip = block("flip", &external, "G := NOT go;");
    let locals = [
        variable("off", "<BOOL/>"),
        variable("c", "<BOOL/>"),
        variable("f", &of_type("flip")),
        variable("h", &of_type("heavy")),
    ];
    let variables = format!("<localVars>{}</localVars>{external}", locals.concat());
    let rail = placed("leftPowerRail", 1, 0, "", "");
    let named = |name: &str| format!("<variable>{name}</variable>");
    let body = |first: &str| {
        [
            rail.clone(),
            // What is set first settles which way it is.
            placed("contact", 2, 5, r#"negated="false""#, &(from(1) + &named("off"))),
            placed("coil", 3, 5, r#"negated="false""#, &(from(2) + &named("G"))),
            placed("contact", 4, 20, r#"negated="false""#, &(from(1) + &named("G"))),
            call(5, 20, first, "f", 4, ""),
            placed("coil", 6, 60, r#"negated="false""#, &(from(4) + &named("c"))),
            placed("contact", 7, 100, r#"negated="false""#, &(from(1) + &named("c"))),
            placed("contact", 8, 100, r#"negated="true""#, &(from(7) + &named("off"))),
            call(9, 100, "heavy", "h", 8, ""),
        ]
        .concat()
    };
    let text = drawn(&(heavy + &flip), &variables, &format!("<LD>{}</LD>", body("flip")));
    let found = audited("main.xml", &text, "").unwrap_or_else(|failure| panic!("{failure:?}"));
    // Two coils, two inputs, what flips, and the heavy part.
    assert_eq!(found.bound.upper.0 / 1_000_000, 8);
}

#[test]
fn return_in_an_action_block_ends_it_alone_or_the_whole_chart() {
    let inline = |id: u32, body: &str| {
        format!(
            r#"<action localId="{id}" qualifier="N"><inline name=""><ST><p xmlns="http://www.w3.org/1999/xhtml">{body}</p></ST></inline></action>"#
        )
    };
    let step = |id: u32, name: &str, initial: bool, input: &str| {
        let more = format!(r#"name="{name}" initialStep="{initial}""#);
        placed("step", id, id * 10, &more, input)
    };
    let transition = |id: u32, of: u32| {
        let condition = r#"<condition><inline name=""><ST><p xmlns="http://www.w3.org/1999/xhtml">a</p></ST></inline></condition>"#;
        placed("transition", id, id * 10, "", &(from(of) + condition))
    };
    let chart = [
        step(1, "S0", true, ""),
        placed(
            "actionBlock",
            2,
            10,
            "",
            &(from(1)
                + &inline(3, "y := TRUE; RETURN; y := FALSE; y := FALSE;")
                + &inline(4, "y := FALSE;")),
        ),
        transition(5, 1),
        step(6, "S1", false, &from(5)),
        transition(7, 6),
        placed("jumpStep", 8, 100, r#"targetName="S0""#, &from(7)),
    ];
    let variables = [variable("a", "<BOOL/>"), variable("y", "<BOOL/>")].concat();
    let variables = format!("<localVars>{variables}</localVars>");
    let text = drawn("", &variables, &format!("<SFC>{}</SFC>", chart.concat()));
    let found = audited("main.xml", &text, "").unwrap_or_else(|failure| panic!("{failure:?}"));
    assert_eq!(found.bound.upper.0 / 1_000_000, 2);
}

#[test]
fn a_label_without_a_number_among_numbers_is_refused() {
    let heavy = block(
        "heavy",
        &format!("<localVars>{}</localVars>", variable("x", "<BOOL/>")),
        "IF go THEN x := TRUE; END_IF;",
    );
    let variables = format!("<localVars>{}</localVars>", variable("h", &of_type("heavy")));
    let body = |number: &str| {
        let yes = placed("inVariable", 1, 0, "", "<expression>TRUE</expression>");
        let jump = placed("jump", 2, 10, r#"label="lab" executionOrderId="1""#, &from(1));
        let label = placed("label", 3, 50, &format!(r#"label="lab" {number}"#), "");
        let call = call(4, 70, "heavy", "h", 1, r#"executionOrderId="3""#);
        drawn(&heavy, &variables, &format!("<FBD>{}</FBD>", [yes, jump, label, call].concat()))
    };
    match audited("main.xml", &body(""), "") {
        Err(Failure::Input(faults)) => {
            let told = &faults[0].message;
            assert!(
                told.contains("label with localId 3") && told.contains("executionOrderId"),
                "{told}"
            );
        }
        other => panic!("{:?}", other.map(|found| found.bound.upper)),
    }
    let numbered = audited("main.xml", &body(r#"executionOrderId="2""#), "");
    let numbered = numbered.unwrap_or_else(|failure| panic!("{failure:?}"));
    assert_eq!(numbered.bound.upper.0 / 1_000_000, 2);
}

#[test]
fn structured_text_with_many_commas_is_known_as_such() {
    for text in [
        "PROGRAM p\nVAR x : INT; y : BOOL; END_VAR\nCASE x OF\na, b, c, d, e, f, g:\ny := TRUE;\nEND_CASE\nEND_PROGRAM\n",
        "PROGRAM p\nVAR x :\nINT; END_VAR CASE x OF one, two, three, four, five, six, 7: x := 1; END_CASE END_PROGRAM\n",
        "PROGRAM p\nVAR a : INT;\nb, c, d, e, f, g, h : INT;\nEND_VAR\nEND_PROGRAM\n",
        "PROGRAM p VAR\nx : INT;\nEND_VAR\nx := 1; x := 2; x := 3; x := 4; x := 5; x := 6;\nEND_PROGRAM\n",
        "TYPE t :\n(a, b, c, d, e, f,\ng, h, i, j, k, l, m);\nEND_TYPE\n",
    ] {
        let input = Input { name: "p.st".to_owned(), bytes: text.as_bytes().to_vec() };
        match detect(&input) {
            Ok(FileKind::Program(dialect)) => assert_eq!(dialect.name, "iec-text", "{text}"),
            other => panic!("{other:?}\n{text}"),
        }
    }
}

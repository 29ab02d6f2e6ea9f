//! Bounds of charts cover all controllers, and no lower bound rests on what only some of them do.

use scanbound::audit::{Audit, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};
use std::fmt::Write as _;

const TRUSTS: [Trust; 3] = [Trust::None, Trust::Counts, Trust::All];

/// A table in which a transition whose condition is true takes 5 us, one whose condition is false 1 us, and nothing
/// else anything.
fn table() -> Table {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        let _ = writeln!(rows, "@{class},0,0");
    }
    rows += "CLEAR,5,1\n@end,0,\n";
    Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table
}

/// The audit of a program with the blocks or functions `F0` (20 us), `F1` (11 us) and `F2` (2 us).
fn audited(text: &str, facts: &str, trust: Trust) -> Audit {
    let calls = [("F0", 20), ("F1", 11), ("F2", 2)].into_iter();
    let calls = calls.filter(|(name, _)| text.contains(name));
    let calls: String =
        calls.map(|(name, time)| format!("{name} = {{ time = '{time}us' }}\n")).collect();
    let facts = format!("[calls]\n{calls}{facts}");
    let input = Input { name: "p.st".to_owned(), bytes: text.as_bytes().to_vec() };
    let (inputs, table) = ([input], table());
    let facts = Facts::parse("facts.toml", &facts).unwrap_or_else(|faults| panic!("{faults:?}"));
    let request = Request { table: Some(&table), trust, ..Request::new(&inputs, &facts) };
    audit(&request).unwrap_or_else(|failure| panic!("{failure:?}"))
}

/// A program with a chart, the inputs `a` and `b`, the variable `v` and the blocks `C0` to `C2`.
fn program(chart: &str) -> String {
    format!(
        "PROGRAM p
         VAR a AT %IX0.0 : BOOL; b AT %IX0.1 : BOOL; v : BOOL; C0 : F0; C1 : F1; C2 : F2; END_VAR
         {chart}
         END_PROGRAM
         FUNCTION_BLOCK F0 END_FUNCTION_BLOCK
         FUNCTION_BLOCK F1 END_FUNCTION_BLOCK
         FUNCTION_BLOCK F2 END_FUNCTION_BLOCK"
    )
}

/// Upper and lower bound in microseconds.
fn microseconds(found: &Audit) -> (u64, u64) {
    let us = |time: Picos| time.0 / 1_000_000;
    (us(found.bound.upper), us(found.bound.lower))
}

/// Upper and lower bound of a chart in microseconds.
fn bounds(chart: &str, facts: &str, trust: Trust) -> (u64, u64) {
    microseconds(&audited(&program(chart), facts, trust))
}

#[test]
fn no_scan_starts_with_steps_that_are_never_active() {
    // Nothing leads out of S0.
    let stays = "INITIAL_STEP S0: v(SL, T#3s); A1(DS, T#1s); END_STEP
         STEP S1: A1(P1); v(S); A0(N); END_STEP
         STEP S2: END_STEP
         TRANSITION FROM S0 TO S1 := NOT (TRUE); END_TRANSITION
         TRANSITION FROM S1 TO S2 := NOT (TRUE); END_TRANSITION
         TRANSITION FROM S2 TO S0 := NOT (TRUE); END_TRANSITION
         TRANSITION FROM S2 TO S1 := TRUE; END_TRANSITION
         ACTION A1: C2(); END_ACTION
         ACTION A0: C0(); IF a THEN v := S0.T >= T#2s; C1(); END_IF; END_ACTION";
    // S2 is active only after S4, and S4 only after S2.
    let circle = "INITIAL_STEP S0: A0(P0); END_STEP
         STEP S1: A1(DS, T#1s); END_STEP
         STEP S2: A1(DS, T#2s); END_STEP
         STEP S3: A1(S); END_STEP
         STEP S4: A1(SD, T#3s); A1(R); END_STEP
         TRANSITION (PRIORITY := 1) FROM S0 TO S1 := a; END_TRANSITION
         TRANSITION (PRIORITY := 5) FROM S1 TO S2 := S4.T >= T#1s; END_TRANSITION
         TRANSITION (PRIORITY := 2) FROM S2 TO S3 := S3.X; END_TRANSITION
         TRANSITION (PRIORITY := 3) FROM S3 TO S4 := NOT (b); END_TRANSITION
         TRANSITION (PRIORITY := 4) FROM S4 TO S0 := ((TRUE) OR (S4.X)); END_TRANSITION
         ACTION A1: C2(); END_ACTION
         ACTION A0: C0(); END_ACTION";
    for trust in TRUSTS {
        for facts in ["", "[sfc]\nselection = 'all'\n", "[sfc]\nselection = 'first'\n"] {
            for (chart, most) in [(stays, 3), (circle, 25)] {
                let (upper, lower) = bounds(chart, facts, trust);
                assert!(lower <= most && most <= upper, "{lower} {upper} {trust:?} {facts}");
            }
        }
    }
}

/// A chart of S0, S1 with A0, which takes 20 us, and S2 with A1, which takes 11 us.
fn two_actions(transitions: &str) -> String {
    format!(
        "INITIAL_STEP S0: END_STEP STEP S1: A0(N); END_STEP STEP S2: A1(N); END_STEP
         {transitions}
         ACTION A0: C0(); END_ACTION
         ACTION A1: C1(); END_ACTION"
    )
}

#[test]
fn no_scan_starts_with_branches_that_only_one_rule_of_selection_lets_be_active_together() {
    let text = two_actions(
        "TRANSITION FROM S0 TO S1 := a; END_TRANSITION
         TRANSITION FROM S0 TO S2 := b; END_TRANSITION
         TRANSITION FROM S1 TO S1 := a; END_TRANSITION",
    );
    for trust in TRUSTS {
        let (upper, lower) = bounds(&text, "", trust);
        assert!(lower <= 25 && upper >= 31, "{lower} {upper} {trust:?}");
        assert_eq!(bounds(&text, "[sfc]\nselection = 'all'\n", trust), (41, 41), "{trust:?}");
        assert_eq!(bounds(&text, "[sfc]\nselection = 'first'\n", trust), (25, 25), "{trust:?}");
    }
}

#[test]
fn no_scan_starts_with_what_only_some_controllers_store() {
    // S0 is never entered again: on matiec nothing of it begins.
    for block in ["P", "P1", "SL, T#1s", "SD, T#1s", "DS, T#1s"] {
        let text = format!(
            "INITIAL_STEP S0: A0({block}); END_STEP STEP S1: END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             ACTION A0: C0(); END_ACTION"
        );
        for trust in TRUSTS {
            // The transition takes 5 us on every controller.
            let (upper, lower) = bounds(&text, "", trust);
            assert!(upper >= 20 && lower <= 5, "{block}: {lower} {upper} {trust:?}");
        }
    }
    // Whether R ends the delay, controllers differ.
    let outlasts =
        "INITIAL_STEP S0: END_STEP STEP S1: A0(SD, T#1s); END_STEP STEP S2: A0(R); END_STEP
         STEP S3: A1(N); END_STEP
         TRANSITION FROM S0 TO S1 := TRUE; END_TRANSITION
         TRANSITION FROM S1 TO S2 := TRUE; END_TRANSITION
         TRANSITION FROM S2 TO S3 := TRUE; END_TRANSITION
         ACTION A0: C0(); END_ACTION
         ACTION A1: C1(); END_ACTION";
    for trust in TRUSTS {
        let (upper, lower) = bounds(outlasts, "", trust);
        assert!(upper >= 31 && lower <= 16, "{lower} {upper} {trust:?}");
    }
}

#[test]
fn scans_that_every_controller_makes_remain_a_lower_bound() {
    let text = two_actions(
        "TRANSITION FROM S0 TO S1 := a; END_TRANSITION
         TRANSITION FROM S1 TO S2 := b; END_TRANSITION
         TRANSITION FROM S2 TO S0 := a; END_TRANSITION",
    );
    for trust in TRUSTS {
        let found = audited(&program(&text), "", trust);
        // With a final scan 36 us, without one 25 us.
        assert!(found.bound.lower >= Picos(25_000_000), "{trust:?}");
        let facts = "[controller]\n\"actions have no final scan\" = false\n";
        let found = audited(&program(&text), facts, trust);
        assert_eq!((found.bound.upper, found.bound.lower), (Picos(36_000_000), Picos(36_000_000)));
    }
}

#[test]
fn of_several_blocks_of_an_action_any_may_be_the_last() {
    let facts = "[controller]\n\"of several blocks of an action, the last one decides\" = true\n\"actions have no final scan\" = true\n";
    let own = "\"each step of an action has pulses and times of its own\" = true\n";
    for blocks in [
        ["A0(P); A0(N);", ""],
        ["A0(N); A0(P);", ""],
        ["A0(N); A0(P0);", ""],
        ["A0(P0); A0(N);", ""],
        ["A0(P0); A0(P1);", ""],
        ["A0(D, T#1s); A0(P0);", ""],
        ["A0(P);", "A0(P);"],
        ["A0(P1);", "A0(P1);"],
        ["A0(P0);", "A0(P0);"],
        ["A0(L, T#1s);", "A0(P0);"],
    ] {
        let text = format!(
            "INITIAL_STEP S0: END_STEP STEP S1: {} END_STEP STEP S2: {} END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S1 TO S2 := b; END_TRANSITION
             TRANSITION FROM S2 TO S0 := a; END_TRANSITION
             ACTION A0: C0(); END_ACTION",
            blocks[0], blocks[1]
        );
        let shares = blocks[0] == blocks[1];
        for more in ["", own].into_iter().filter(|more| shares || more.is_empty()) {
            let (upper, lower) = bounds(&text, &format!("{facts}{more}"), Trust::All);
            assert!(upper >= 25, "{blocks:?} {more}: {lower} {upper}");
        }
    }
}

#[test]
fn et_of_a_timer_that_is_over_changes_with_a_time_that_changes_or_not() {
    // TON is over with 10 s, and then gets 100 ms.
    let text = "PROGRAM p
         VAR a AT %IX0.0 : BOOL; b AT %IX0.1 : BOOL; t : TON; pt : TIME; END_VAR
         pt := T#100ms;
         IF b THEN pt := T#10s; END_IF;
         t(IN := a, PT := pt);
         IF NOT b AND t.ET > T#100ms THEN F2(); END_IF;
         END_PROGRAM
         FUNCTION F2 : BOOL END_FUNCTION";
    let of = |facts: &str| {
        let facts = if facts.is_empty() { "" } else { &format!("[controller]\n{facts}") };
        microseconds(&audited(text, facts, Trust::All))
    };
    let anew = |is| format!("\"expired timers test a changed PT again\" = {is}\n");
    let stays = |is| format!("\"ET of an expired timer stays the same when PT changes\" = {is}\n");
    assert_eq!(of(&(anew(true) + &stays(false))), (0, 0), "ET is at most 100 ms");
    assert_eq!(of(&(anew(true) + &stays(true))), (2, 2), "ET is 10 s");
    assert_eq!(of(&(anew(false) + &stays(true))).0, 2);
    for facts in [String::new(), anew(true)] {
        assert_eq!(of(&facts), (2, 0), "either: {facts}");
    }
}

#[test]
fn a_condition_that_excludes_another_one_is_evaluated_where_all_clear_that_are_true() {
    // The first condition takes 5 us, the second one 1 us.
    for second in ["NOT a", "NOT a AND b"] {
        let text = format!(
            "INITIAL_STEP S0: END_STEP STEP S1: A0(P1); END_STEP STEP S2: END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S0 TO S2 := {second}; END_TRANSITION
             ACTION A0: C0(); END_ACTION"
        );
        for trust in TRUSTS {
            let of = |facts| bounds(&text, facts, trust);
            assert_eq!(of("[sfc]\nselection = 'first'\n"), (25, 25), "{second} {trust:?}");
            assert_eq!(of("[sfc]\nselection = 'all'\n"), (26, 26), "{second} {trust:?}");
            assert_eq!(of(""), (26, 25), "{second} {trust:?}");
        }
    }
}

#[test]
fn a_chart_that_begins_anew_with_each_call_has_the_variants_of_the_first_scan() {
    let text = |chart: &str| {
        format!(
            "FUNCTION_BLOCK Blk
             VAR_INPUT x : BOOL; END_VAR
             {chart}
             END_FUNCTION_BLOCK
             PROGRAM p
             VAR_TEMP i : Blk; END_VAR
             i(x := TRUE);
             END_PROGRAM
             FUNCTION F2 : BOOL END_FUNCTION"
        )
    };
    let looks = "INITIAL_STEP S0: END_STEP STEP S1: A0(N); END_STEP
         TRANSITION FROM S0 TO S1 := x; END_TRANSITION
         ACTION A0: F2(); END_ACTION";
    let enters = "INITIAL_STEP S0: A0(P1); END_STEP STEP S1: END_STEP
         TRANSITION FROM S0 TO S1 := FALSE; END_TRANSITION
         ACTION A0: F2(); END_ACTION";
    for chart in [looks, enters] {
        let (upper, lower) = microseconds(&audited(&text(chart), "", Trust::All));
        assert!(upper >= 2 && lower < 2, "{lower} {upper}: {chart}");
    }
}

#[test]
fn an_initial_step_may_be_active_before_its_chart_is_first_executed() {
    let text = |condition: &str| {
        format!(
            "FUNCTION_BLOCK Blk
             VAR_INPUT x : BOOL; END_VAR
             INITIAL_STEP S0: END_STEP STEP S1: END_STEP
             TRANSITION FROM S0 TO S1 := x; END_TRANSITION
             END_FUNCTION_BLOCK
             PROGRAM p
             VAR a AT %IX0.0 : BOOL; i : Blk; k : INT; END_VAR
             IF k = 0 AND {condition} THEN F0(); END_IF;
             k := 1;
             i(x := a);
             END_PROGRAM
             FUNCTION F0 : BOOL END_FUNCTION"
        )
    };
    for condition in ["i.S0.X", "NOT i.S0.X"] {
        let early = "initial steps are active before their chart is first executed";
        let of = |facts: &str| microseconds(&audited(&text(condition), facts, Trust::All));
        let stated = |is: bool| of(&format!("[controller]\n{early:?} = {is}\n"));
        let (upper, lower) = of("");
        assert!(upper >= 20 && lower < 20, "{lower} {upper}: {condition}");
        assert!(stated(condition == "i.S0.X").0 >= 20, "{condition}");
        let (upper, lower) = stated(condition != "i.S0.X");
        assert!(lower < 20, "{lower} {upper}: {condition}");
    }
}

#[test]
fn no_lower_bound_rests_on_whether_a_time_of_0_is_over_at_once() {
    let of = |body: &str| {
        let text = format!(
            "PROGRAM p
             VAR a AT %IX0.0 : BOOL; t : TON; f : TOF; u : TP; p : BOOL; END_VAR
             {body}
             p := a;
             END_PROGRAM
             FUNCTION F2 : BOOL END_FUNCTION"
        );
        microseconds(&audited(&text, "", Trust::All))
    };
    for body in [
        "t(IN := a, PT := T#0s); IF a AND NOT t.Q THEN F2(); END_IF;",
        "t(IN := a, PT := T#0s); IF t.Q AND NOT p THEN F2(); END_IF;",
        "f(IN := a, PT := T#0s); IF f.Q AND NOT a THEN F2(); END_IF;",
        "f(IN := a, PT := T#0s); IF p AND NOT f.Q AND NOT a THEN F2(); END_IF;",
        "u(IN := a, PT := T#0s); IF u.Q THEN F2(); END_IF;",
        "u(IN := a, PT := T#0s); IF a AND NOT p AND NOT u.Q THEN F2(); END_IF;",
    ] {
        let (upper, lower) = of(body);
        assert!(upper >= 2 && lower < 2, "{lower} {upper}: {body}");
    }
    for qualifier in ["SD", "DS", "D", "L", "SL"] {
        let text = format!(
            "INITIAL_STEP S0: END_STEP STEP S1: A0({qualifier}, T#0s); END_STEP
             TRANSITION FROM S0 TO S1 := TRUE; END_TRANSITION
             ACTION A0: C0(); END_ACTION"
        );
        let (upper, lower) = bounds(&text, "", Trust::All);
        assert!(upper >= 25 && lower <= 5, "{qualifier}: {lower} {upper}");
    }
}

#[test]
fn no_lower_bound_rests_on_how_often_a_scan_looks_at_the_clock() {
    for (condition, ms) in [("t.Q", 1), ("NOT t.Q", 1), ("t.Q", 10_000), ("NOT t.Q", 10_000)] {
        let text = format!(
            "PROGRAM p
             VAR a AT %IX0.0 : BOOL; t : TON; END_VAR
             t(IN := FALSE, PT := T#{ms}ms);
             t(IN := a, PT := T#{ms}ms);
             slow();
             t(IN := a, PT := T#{ms}ms);
             IF a AND {condition} THEN F2(); END_IF;
             END_PROGRAM
             FUNCTION slow : BOOL END_FUNCTION
             FUNCTION F2 : BOOL END_FUNCTION"
        );
        let found = audited(&text, "slow = { time = '50ms' }\n", Trust::All).bound;
        let short = Picos(50_000_000_000);
        let (upper, lower) = (found.upper > short, found.lower > short);
        match ms {
            1 => assert!(upper && !lower, "{condition}"),
            _ => assert!(!lower || condition == "NOT t.Q", "{condition}"),
        }
    }
}

#[test]
fn a_transition_without_a_priority_may_come_before_those_with_one_or_after_them() {
    // In this order S9 is active for the first condition, and no longer for the third one.
    let text = |conditions: [&str; 2]| {
        format!(
            "INITIAL_STEP S: END_STEP STEP S0: END_STEP STEP S9: END_STEP STEP S8: END_STEP
             STEP S1: A0(P); END_STEP STEP S2: A1(P); END_STEP
             TRANSITION FROM S TO (S0, S9) := TRUE; END_TRANSITION
             TRANSITION FROM S0 TO S1 := {}; END_TRANSITION
             TRANSITION (PRIORITY := 1) FROM S9 TO S8 := a; END_TRANSITION
             TRANSITION FROM S0 TO S2 := {}; END_TRANSITION
             ACTION A0: C0(); END_ACTION
             ACTION A1: C1(); END_ACTION",
            conditions[0], conditions[1]
        )
    };
    let early = "\"a transition with a priority clears its step flags at once\" = true\n";
    for conditions in [["S9.X", "NOT S9.X"], ["S9.X OR FALSE", "NOT S9.X OR FALSE"]] {
        for facts in ["", "[sfc]\nselection = 'all'\n"] {
            for facts in [facts.to_owned(), format!("{facts}[controller]\n{early}")] {
                for trust in TRUSTS {
                    let (upper, lower) = bounds(&text(conditions), &facts, trust);
                    // Three transitions clear.
                    assert!(upper >= 46 && lower <= 46, "{lower} {upper} {conditions:?} {facts}");
                }
            }
        }
    }
}

/// The faults of a chart that is refused.
fn refusal(chart: &str) -> String {
    let input = Input { name: "p.st".to_owned(), bytes: program(chart).into_bytes() };
    let calls = "[calls]\nF0 = { time = '1us' }\nF1 = { time = '1us' }\nF2 = { time = '1us' }\n";
    let facts = Facts::parse("facts.toml", calls).unwrap_or_else(|faults| panic!("{faults:?}"));
    let (inputs, table) = ([input], table());
    let request = Request { table: Some(&table), ..Request::new(&inputs, &facts) };
    match audit(&request) {
        Err(failure) => format!("{failure:?}"),
        Ok(_) => "accepted".to_owned(),
    }
}

#[test]
fn flags_that_control_a_chart_are_followed_or_refused() {
    let with = |flags: &str, qualifier: &str| {
        format!(
            "VAR {flags} : BOOL; END_VAR
             INITIAL_STEP S0: END_STEP
             STEP S1: A0({qualifier}); END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S1 TO S0 := b; END_TRANSITION
             ACTION A0: C0(); END_ACTION"
        )
    };
    for flag in ["SFCTip", "SFCTipMode", "SFCPause", "SFCQuitError", "SFCError", "SFCTrans"] {
        let told = refusal(&with(flag, "N"));
        assert!(told.contains(&format!("the flag {flag} is not followed")), "{told}");
    }
    for flag in ["SFCInit", "SFCReset"] {
        assert_eq!(refusal(&with(flag, "N")), "accepted");
        for qualifier in ["S", "SD, T#1s", "DS, T#1s", "SL, T#1s"] {
            assert_eq!(refusal(&with(flag, qualifier)), "accepted");
        }
    }
    assert_eq!(refusal(&with("other", "S")), "accepted");
}

#[test]
fn actions_may_stay_stored_where_a_chart_restarts() {
    let stored = |qualifier: &str, flag: &str, facts: &str, trust| {
        let chart = format!(
            "VAR {flag} : BOOL; END_VAR
             INITIAL_STEP S0: A1(N); END_STEP
             STEP S1: A0({qualifier}); END_STEP
             STEP S2: A0(R); END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S1 TO S2 := b; END_TRANSITION
             TRANSITION FROM S2 TO S0 := a; END_TRANSITION
             ACTION A0: C0(); END_ACTION
             ACTION A1: C1(); END_ACTION"
        );
        let facts = format!("[controller]\n\"actions have no final scan\" = true\n{facts}");
        bounds(&chart, &facts, trust)
    };
    let stay = "\"SFCInit and SFCReset leave stored actions stored\" = ";
    for qualifier in ["S", "SD, T#1s", "DS, T#1s", "SL, T#1s"] {
        for trust in TRUSTS {
            let (ends, _) = stored(qualifier, "SFCReset", &format!("{stay}false\n"), trust);
            let (stays, _) = stored(qualifier, "SFCReset", &format!("{stay}true\n"), trust);
            // A1 of the initial step beside A0, which S1 has stored.
            assert!(stays >= 31, "{qualifier} {trust:?} {stays}");
            assert!(ends < 31 || qualifier != "S", "{qualifier} {trust:?} {ends}");
            for flag in ["SFCInit", "SFCReset"] {
                let (either, lower) = stored(qualifier, flag, "", trust);
                assert!(either >= stays.max(ends), "{qualifier} {flag} {either}");
                assert!(lower <= ends, "{qualifier} {flag} {lower} {ends}");
            }
        }
    }
}

#[test]
fn charts_that_begin_anew_may_leave_their_first_step_at_once() {
    // The chart begins anew with each scan. A0 ends its first step, A1 is that of its second.
    let bound = |actions: &str, facts: &str| {
        let text = format!(
            "PROGRAM p
             VAR a AT %IX0.0 : BOOL; END_VAR
             VAR_TEMP c : B; END_VAR
             c(x := a); c(x := a);
             END_PROGRAM
             FUNCTION_BLOCK B
             VAR_INPUT x : BOOL; END_VAR
             VAR C0 : F0; END_VAR
             {actions}
             TRANSITION FROM S0 TO S1 := x; END_TRANSITION
             TRANSITION FROM S1 TO S0 := x; END_TRANSITION
             ACTION A0: C0(); END_ACTION
             END_FUNCTION_BLOCK
             FUNCTION_BLOCK F0 END_FUNCTION_BLOCK"
        );
        microseconds(&audited(&text, facts, Trust::Counts)).0
    };
    let left = "INITIAL_STEP S0: A0(P0); END_STEP STEP S1: END_STEP";
    let entered = "INITIAL_STEP S0: END_STEP STEP S1: A0(P1); END_STEP";
    let alphabetical = "[sfc]\naction_order = 'alphabetical'\n";
    for (chart, facts) in [(left, ""), (entered, ""), (left, alphabetical), (entered, alphabetical)]
    {
        assert!(bound(chart, facts) >= 25, "{chart} {facts}");
    }
    let none = "[controller]\n\"transitions are evaluated in the first scan\" = false\n";
    assert!(bound("INITIAL_STEP S0: END_STEP STEP S1: END_STEP", none) < 20);
}

#[test]
fn the_order_of_actions_matters_in_a_chart_that_begins_anew() {
    // A1 gives v its value, and A0, which is declared before it, reads v.
    let text = "PROGRAM p VAR v : BOOL; END_VAR v := FX(); END_PROGRAM
         FUNCTION FX : BOOL VAR c : B; END_VAR c(x := TRUE); END_FUNCTION
         FUNCTION_BLOCK B VAR_INPUT x : BOOL; END_VAR VAR v : BOOL; C0 : F0; END_VAR
         INITIAL_STEP S0: END_STEP
         STEP S1: A1(N); A0(N); END_STEP
         TRANSITION FROM S0 TO S1 := TRUE; END_TRANSITION
         ACTION A0: IF v THEN C0(); END_IF; END_ACTION
         ACTION A1: v := x; END_ACTION
         END_FUNCTION_BLOCK
         FUNCTION_BLOCK F0 END_FUNCTION_BLOCK";
    let facts = "[controller]\n\"transitions are evaluated in the first scan\" = true\n";
    let (upper, lower) = microseconds(&audited(text, facts, Trust::All));
    assert!(upper >= 20 && lower < 20, "{upper} {lower}");
}

#[test]
fn functions_and_methods_have_no_charts() {
    let chart = "INITIAL_STEP S0: END_STEP STEP S1: END_STEP
         TRANSITION FROM S0 TO S1 := TRUE; END_TRANSITION
         TRANSITION FROM S1 TO S0 := TRUE; END_TRANSITION";
    for (unit, call) in [
        (format!("FUNCTION F : BOOL {chart} END_FUNCTION"), "v := F();"),
        (format!("FUNCTION_BLOCK B METHOD m {chart} END_METHOD END_FUNCTION_BLOCK"), "c.m();"),
    ] {
        let own = if call.starts_with('c') { "VAR c : B; END_VAR" } else { "" };
        let told = refusal(&format!("{own} {call} C0(); END_PROGRAM {unit} PROGRAM other"));
        assert!(told.contains("keep no steps from call to call"), "{told}");
    }
}

#[test]
fn a_time_below_1_ms_may_be_over_at_once() {
    let chart = |time: &str| {
        format!(
            "INITIAL_STEP S0: END_STEP
             STEP S1: A0(D, {time}); END_STEP
             STEP S2: END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S1 TO S2 := TRUE; END_TRANSITION
             TRANSITION FROM S2 TO S0 := TRUE; END_TRANSITION
             ACTION A0: IF S1.X AND NOT S2.X THEN C0(); END_IF; END_ACTION"
        )
    };
    // S1 is active for one scan. A transition whose condition is true takes 5 us, the block 20 us.
    assert!(bounds(&chart("T#0.5ms"), "", Trust::Counts).0 >= 25);
    assert!(bounds(&chart("T#1ms"), "", Trust::Counts).0 < 25);
}

#[test]
fn an_underscore_stands_before_or_after_letters_in_alphabetical_orders() {
    // The first action gives w its value, which begins with FALSE in each scan, and the second reads it.
    let chart = |first: &str, second: &str| {
        format!(
            "VAR_TEMP w : BOOL; END_VAR
             INITIAL_STEP S0: {first}(N); {second}(N); END_STEP
             STEP S1: END_STEP
             TRANSITION FROM S0 TO S1 := a; END_TRANSITION
             TRANSITION FROM S1 TO S0 := b; END_TRANSITION
             ACTION {second}: IF w THEN C0(); END_IF; END_ACTION
             ACTION {first}: w := TRUE; END_ACTION"
        )
    };
    let facts = "[sfc]\naction_order = 'alphabetical'\n";
    let upper =
        |first: &str, second: &str| bounds(&chart(first, second), facts, Trust::All).0 >= 20;
    assert!(upper("A_B", "AA"), "`_` may come before letters");
    assert!(upper("AA", "A_B"), "or after them");
    assert!(upper("A1", "A2"));
    assert!(!upper("A2", "A1"));
}

#[test]
fn a_run_is_shown_up_to_the_scan_to_which_every_controller_has_come() {
    let text = "FUNCTION_BLOCK Blk
        INITIAL_STEP S0: END_STEP STEP S1: END_STEP STEP S2: END_STEP
        TRANSITION FROM S0 TO S1 := TRUE; END_TRANSITION
        TRANSITION FROM S1 TO S2 := TRUE; END_TRANSITION
        END_FUNCTION_BLOCK
        PROGRAM p
        VAR i : Blk; once : BOOL; END_VAR
        i();
        IF i.S2.X AND NOT once THEN F0(); once := TRUE; END_IF;
        END_PROGRAM
        FUNCTION F0 : BOOL END_FUNCTION";
    let scans = |facts: &str| {
        let found = audited(text, facts, Trust::All);
        let took = found.witness_run.iter().map(|scan| scan.took.0 / 1_000_000);
        assert_eq!(took.max(), Some(microseconds(&found).1), "{facts}");
        found.witness_run.last().map_or(0, |scan| scan.number)
    };
    let first = "transitions are evaluated in the first scan";
    let [early, late] = [true, false].map(|is| scans(&format!("[controller]\n{first:?} = {is}\n")));
    assert!(0 < early && early < late, "{early} {late}");
    assert_eq!(scans(""), late);
}

//! Programs of IEC 61131-3 as the analysis follows them, where a slip would make a bound too low.

use scanbound::audit::{Audit, Failure, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// The longest scan in microseconds, where a store takes one and nothing else anything.
fn bound(text: &str) -> Result<u64, Vec<Code>> {
    audited(text).map(|found| found.bound.upper.0.div_ceil(Picos(1_000_000).0))
}

/// What a scan takes, where a store takes a microsecond and nothing else anything.
fn audited(text: &str) -> Result<Audit, Vec<Code>> {
    trusting(Trust::None, text)
}

fn trusting(trust: Trust, text: &str) -> Result<Audit, Vec<Code>> {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += "ST,1,1\n@end,0,\n";
    let table =
        Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table;
    let inputs = [Input { name: "main.st".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request {
        table: Some(&table),
        trust,
        dialect: Some("iec-text"),
        ..Request::new(&inputs, &facts)
    };
    match audit(&request) {
        Ok(found) => Ok(found),
        Err(Failure::Input(faults)) => Err(faults.into_iter().map(|fault| fault.code).collect()),
        Err(other) => panic!("{other:?}"),
    }
}

/// The same of a program's variables and statements.
fn of(variables: &str, body: &str) -> Result<u64, Vec<Code>> {
    bound(&format!(
        "PROGRAM main VAR x, y, z : BOOL; a AT %IX0.0 : BOOL; {variables} END_VAR {body} END_PROGRAM"
    ))
}

#[test]
fn what_excludes_each_other_is_not_added_up() {
    assert_eq!(of("", "IF a THEN x := TRUE; ELSE x := FALSE; y := FALSE; END_IF"), Ok(2));
    let case = "CASE n OF 1: x := TRUE; 2..4: x := TRUE; y := TRUE; ELSE z := TRUE; END_CASE";
    assert_eq!(of("n : INT;", case), Ok(2));
    assert_eq!(
        of(
            "n : INT;",
            "IF n < 3 THEN x := TRUE; END_IF IF n > 5 THEN y := TRUE; z := TRUE; END_IF"
        ),
        Ok(2)
    );
    // Signed and unsigned numbers, widened.
    assert_eq!(of("n : INT; d : DINT;", "d := n; IF d > 40000 THEN x := TRUE; END_IF"), Ok(1));
    assert_eq!(of("n : UINT; d : DINT;", "d := n; IF d > 40000 THEN x := TRUE; END_IF"), Ok(2));
    // A sum that does not fit its type: some compilers keep all of it.
    assert_eq!(of("n : SINT;", "IF n + n = 254 THEN x := TRUE; END_IF"), Ok(1));
    let stored = "n := n + n; d := n; IF d = 254 THEN x := TRUE; END_IF";
    assert_eq!(of("n : SINT; d : DINT;", stored), Ok(2));
}

#[test]
fn loops_count_their_turns() {
    assert_eq!(of("i : INT;", "FOR i := 1 TO 5 DO x := TRUE; END_FOR"), Ok(11));
    assert_eq!(of("i : INT;", "FOR i := 5 TO 1 BY -2 DO x := TRUE; END_FOR"), Ok(7));
    assert_eq!(of("i : INT;", "FOR i := 5 TO 1 DO x := TRUE; END_FOR"), Ok(1));
    assert_eq!(
        of("i : INT;", "FOR i := 1 TO 5 DO IF i = 3 THEN EXIT; END_IF x := TRUE; END_FOR"),
        Ok(5)
    );
    // As often as a number of 16 bits can be.
    assert_eq!(of("n : INT;", "WHILE n > 0 DO n := n - 1; END_WHILE"), Ok(32_767));
}

#[test]
fn loops_that_may_go_round_more_often_are_not_cut_short() {
    // A variable of the same name hides a constant.
    let to_run = |variables: &str, before: &str| {
        bound(&format!(
            "TYPE Mode : (Idle, Run); END_TYPE PROGRAM main VAR x : BOOL; i : INT; {variables} END_VAR \
             {before} FOR i := 1 TO Run DO x := TRUE; END_FOR END_PROGRAM"
        ))
    };
    assert_eq!(to_run("", ""), Ok(3));
    assert_eq!(to_run("Run : INT;", "Run := 4;"), Ok(10));
    let element = "TYPE Mode : (Idle, Run); END_TYPE PROGRAM main VAR x, y : BOOL; Run : INT; f : ARRAY[0..2] OF BOOL; \
        END_VAR f[1] := FALSE; Run := 2; f[Run] := TRUE; IF f[2] THEN x := TRUE; y := TRUE; END_IF END_PROGRAM";
    assert_eq!(bound(element), Ok(5));
    // Both ends so far apart that the difference does not fit 32 bits: no end of it is seen.
    let to = |end: &str| {
        audited(&format!(
            "PROGRAM main VAR x : BOOL; i, n : DINT; END_VAR n := {end}; \
             FOR i := -10 TO n DO x := TRUE; END_FOR END_PROGRAM"
        ))
    };
    assert!(!to("2147483640").unwrap().unbounded.is_empty());
    assert!(to("-11").unwrap().unbounded.is_empty());
    // Whatever is called may set the variable back.
    let called = |action: &str| {
        bound(&format!(
            "PROGRAM main VAR x : BOOL; i : INT; END_VAR FOR i := 0 TO 3 DO act(); END_FOR \
             ACTION act: {action} END_ACTION END_PROGRAM"
        ))
    };
    assert_eq!(called("i := 0;"), Err(vec![Code::LoopCount]));
    assert_eq!(called("x := TRUE;"), Ok(9));
}

#[test]
fn constants_are_as_wide_as_they_have_to_be() {
    // None of these constants fits the variable, with its sign or without: what holds always, or never, does so.
    let taken = |variables: &str, condition: &str| {
        of(variables, &format!("IF {condition} THEN x := TRUE; y := TRUE; ELSE z := TRUE; END_IF"))
    };
    assert_eq!(taken("n : INT;", "n < 70000"), Ok(2));
    assert_eq!(taken("n : INT;", "n > 70000"), Ok(1));
    assert_eq!(taken("n : UINT;", "n > -40000"), Ok(2));
    assert_eq!(taken("n : UINT;", "n < -40000"), Ok(1));
    assert_eq!(taken("n : USINT;", "300 > n"), Ok(2));
    // These fit it by their bits, by which some controllers compare.
    assert_eq!(taken("n : INT;", "n > 40000"), Ok(2));
    assert_eq!(taken("n : UINT;", "n < -1"), Ok(2));
    // NOT of a number is a number.
    assert_eq!(of("n : INT;", "n := NOT 5; IF n = -6 THEN x := TRUE; y := TRUE; END_IF"), Ok(3));
}

#[test]
fn timers_may_run_out_or_not_but_not_as_they_begin() {
    let timer =
        |time: &str, rest: &str| of("t : TON;", &format!("t(IN := a, PT := {time}); {rest}"));
    assert_eq!(timer("T#1s", "IF t.Q THEN x := TRUE; ELSE y := TRUE; z := TRUE; END_IF"), Ok(4));
    assert_eq!(
        timer("T#1s", "IF t.Q AND NOT a THEN x := TRUE; END_IF"),
        Ok(2),
        "never without its input"
    );
    // Half a millisecond is not nothing: it may not be over at once.
    assert_eq!(timer("T#500us", "IF a AND NOT t.Q THEN x := TRUE; END_IF"), Ok(3));
    assert_eq!(
        of("d : TIME;", "IF d > T#40d THEN x := TRUE; ELSE y := TRUE; z := TRUE; END_IF"),
        Ok(2)
    );
}

#[test]
fn what_is_handed_over_comes_back() {
    let block = "FUNCTION_BLOCK b VAR_IN_OUT io : BOOL; END_VAR io := TRUE; END_FUNCTION_BLOCK ";
    let program = |call: &str| {
        format!(
            "{block} PROGRAM main VAR x, y : BOOL; i : b; END_VAR x := FALSE; i({call}); IF x THEN y := TRUE; END_IF END_PROGRAM"
        )
    };
    // The store before, the hand-over, the store inside, the way back, the last store.
    assert_eq!(bound(&program("io := x")), Ok(5));
    assert_eq!(bound(&program("x")), Ok(5));
}

#[test]
fn values_reach_what_is_called_as_they_are() {
    let function = "FUNCTION larger : INT VAR_INPUT a : INT; b : INT := 7; END_VAR \
        larger := MAX(a, b); END_FUNCTION ";
    let is = |value: &str, number: i32| {
        bound(&format!(
            "{function} PROGRAM main VAR x, y : BOOL; n : INT; d : DINT; u : USINT; END_VAR u := 3; d := 70000; \
             n := {value}; IF n = {number} THEN x := TRUE; y := TRUE; END_IF END_PROGRAM"
        ))
    };
    let stores =
        |value: &str, number: i32| (is(value, number).unwrap(), is(value, number + 1).unwrap());
    let taken = |value: &str, number: i32| {
        let (yes, no) = stores(value, number);
        assert_eq!(yes, no + 2, "{value}");
    };
    // One call within another's arguments, an input that is not given after one that was.
    taken("larger(20, larger(1, 2))", 20);
    taken("larger(larger(1, 2), 20)", 20);
    taken("larger(1, 9) + larger(2)", 16);
    // Of two kinds the wider one.
    taken("DINT_TO_INT(MIN(n, d) - n)", 0);
    taken("DINT_TO_INT(MAX(u, d) - 69990)", 10);
    taken("SEL(TRUE, u, 300)", 300);
}

#[test]
fn enumerations_begin_with_their_first_value() {
    // In a function, where a variable begins anew, and at power-up.
    let text = "TYPE Mode : (Run := 3, Idle := 4); END_TYPE FUNCTION f : INT VAR m : Mode; END_VAR \
        IF m = Run THEN f := 1; END_IF END_FUNCTION \
        PROGRAM main VAR x, y, z : BOOL; END_VAR IF f() = 1 THEN x := TRUE; y := TRUE; END_IF END_PROGRAM";
    assert_eq!(bound(text), Ok(3));
}

#[test]
fn shared_memory_is_seen_by_both_and_unknown_names_are_refused() {
    let tested = "IF n THEN x := TRUE; END_IF";
    let word = |body: &str| of("m AT %MW0 : INT; n AT %MX0.0 : BOOL;", body);
    assert_eq!(word(&format!("n := FALSE; m := 1; {tested}")), Ok(3));
    let bit = |body: &str| of("n AT %QX0.0 : BOOL;", body);
    assert_eq!(bit(&format!("n := FALSE; %QX0.0 := TRUE; {tested}")), Ok(3));
    assert_eq!(bit(&format!("n := TRUE; %QX0.0 := FALSE; {tested}")), Ok(2));
    // A copy of what is handed over would not see what the other one takes on.
    let handed = "FUNCTION_BLOCK f VAR_IN_OUT v : INT; END_VAR v := 0; END_FUNCTION_BLOCK
        PROGRAM main VAR i : f; m AT %MW0 : INT; n AT %MX0.0 : BOOL; END_VAR i(v := m); END_PROGRAM";
    assert_eq!(bound(handed), Err(vec![Code::NotModelled]));
    assert_eq!(of("", "q := TRUE;"), Err(vec![Code::UnknownName]));
    assert_eq!(of("t : FB_Pump;", "x := TRUE;"), Err(vec![Code::UnknownType]));
}

#[test]
fn loops_on_conditions_go_round_as_often_as_what_they_count_says() {
    // The first store, then two in each turn.
    let turns = |start: i32, body: &str| of("i : INT;", &format!("i := {start}; {body}"));
    let up = "WHILE i < 5 DO x := TRUE; i := i + 1; END_WHILE";
    for (start, stores) in [(0, 11), (3, 5), (5, 1), (9, 1), (-2, 15)] {
        assert_eq!(turns(start, up), Ok(stores), "{start}");
    }
    let down = "WHILE a AND (0 <= i) DO x := TRUE; i := i - 2; END_WHILE";
    for (start, stores) in [(0, 3), (1, 3), (2, 5), (-1, 1), (7, 9)] {
        assert_eq!(turns(start, down), Ok(stores), "{start}");
    }
    let until = "REPEAT x := TRUE; i := i + 3; UNTIL i > 6 OR a END_REPEAT";
    for (start, stores) in [(0, 7), (3, 5), (4, 3), (100, 3)] {
        assert_eq!(turns(start, until), Ok(stores), "{start}");
    }
    for unknown in [
        "WHILE a DO x := TRUE; END_WHILE",
        "WHILE i < 5 DO IF a THEN i := i + 1; END_IF END_WHILE",
        "WHILE i < 5 DO i := i + 1; i := 0; END_WHILE",
        "WHILE i < 5 DO IF a THEN CONTINUE; END_IF i := i + 1; END_WHILE",
        "WHILE i < 5 DO i := i - 1; END_WHILE",
        "WHILE i < n DO i := i + 1; n := n + 1; END_WHILE",
        "REPEAT i := i + 2; UNTIL i = 5 END_REPEAT",
        "REPEAT i := i + 1; UNTIL i > 5 AND a END_REPEAT",
    ] {
        assert_eq!(of("i, n : INT;", unknown), Err(vec![Code::LoopCount]), "{unknown}");
    }
}

#[test]
fn loops_that_never_pass_their_end_have_no_count() {
    let to = |end: i32| of("i : USINT;", &format!("FOR i := 250 TO {end} DO x := TRUE; END_FOR"));
    // The start, and in each of five turns the body's store and the loop's own.
    assert_eq!(to(254), Ok(11));
    assert_eq!(to(255), Err(vec![Code::LoopCount]));
    let moved = "FOR i := 1 TO n DO n := n + 1; END_FOR";
    assert_eq!(of("i, n : INT;", moved), Err(vec![Code::LoopCount]));
    let wide = "FOR i := 0 TO n DO x := TRUE; END_FOR";
    assert_eq!(of("i, n : UDINT;", wide), Err(vec![Code::LoopCount]));
    // What a loop counts may be changed where it is handed over.
    let handed = "FUNCTION_BLOCK g VAR_IN_OUT v : INT; END_VAR v := 0; END_FUNCTION_BLOCK
        PROGRAM main VAR f : g; i : INT; END_VAR FOR i := 0 TO 3 DO f(v := i); END_FOR END_PROGRAM";
    assert_eq!(bound(handed), Err(vec![Code::LoopCount]));
}

#[test]
fn a_loop_begins_with_what_its_start_was_before_it() {
    // Sixteen turns, of two stores each.
    let own = "i := 0; FOR i := i + 5 TO 20 DO x := TRUE; END_FOR";
    assert_eq!(of("i : INT;", own), Ok(34));
    let down = "i := 3; FOR i := 2 * i TO 0 BY -2 DO x := TRUE; END_FOR";
    assert_eq!(of("i : INT;", down), Ok(10));
    // 250 is -6 in eight bits.
    let short = "n := 250; FOR i := n TO 10 DO x := TRUE; END_FOR";
    assert_eq!(of("i : SINT; n : INT;", short), Ok(36));
    // Once alone is it worked out.
    let called = |end: &str| {
        bound(&format!(
            "FUNCTION F : INT VAR_IN_OUT v : INT; END_VAR v := v + 1; F := v; END_FUNCTION
             PROGRAM main VAR i, n : INT; x : BOOL; END_VAR
             n := 0; FOR i := F(v := n) TO {end} DO x := TRUE; END_FOR END_PROGRAM"
        ))
    };
    // Stores: n, what is handed over, two in the function, back, the start, and two in each turn.
    assert_eq!((called("3"), called("1")), (Ok(12), Ok(8)));
    // An end that the loop moves by counting: some controllers see that, others do not.
    for end in ["i", "10 - i", "w[i]", "g + 0"] {
        let body = format!("FOR i := 1 TO {end} DO x := TRUE; END_FOR");
        let variables = "i AT %MW0 : INT; g AT %MW1 : INT; w : ARRAY[0..3] OF INT;";
        assert_eq!(of(variables, &body), Err(vec![Code::LoopCount]), "{end}");
    }
}

#[test]
fn behind_a_loop_its_variable_is_beyond_the_end_or_its_last() {
    let after = |variables: &str, body: &str, condition: &str| {
        may("", &format!("i, n : INT; b : BOOL; {variables}"), body, condition)
    };
    let to_ten = "FOR i := 1 TO 10 DO b := TRUE; END_FOR";
    assert!(after("", to_ten, "i = 10"));
    assert!(after("", to_ten, "i = 11"));
    assert!(!after("", to_ten, "i < 10 OR i > 11"));
    let by_three = "FOR i := 10 TO 1 BY -3 DO b := TRUE; END_FOR";
    assert!(after("", by_three, "i = 1") && after("", by_three, "i = -2"));
    assert!(!after("", by_three, "i <> 1 AND i <> -2"));
    // None goes round, or EXIT ends it: all agree.
    assert!(!after("", "FOR i := 5 TO 1 DO b := TRUE; END_FOR", "i <> 5"));
    let counted = "n := 0; IF a THEN n := 3; END_IF FOR i := 1 TO n DO b := TRUE; END_FOR";
    assert!(after("", counted, "n > 0 AND i = n") && after("", counted, "i = n + 1"));
    assert!(!after("", counted, "n = 0 AND i <> 1"));
    let left = "FOR i := 1 TO 10 DO IF i = 4 THEN EXIT; END_IF END_FOR";
    assert!(!after("", left, "i <> 4"));
    // A loop around sees it, too.
    let nested =
        "n := 0; FOR k := 1 TO 2 DO FOR i := 1 TO 3 DO b := TRUE; END_FOR n := n + i; END_FOR";
    assert!(after("k : INT;", nested, "n = 6") && after("k : INT;", nested, "n = 8"));
}

#[test]
fn the_result_of_a_function_begins_anew_with_every_call() {
    let units = "TYPE E : (p, q, r); END_TYPE
        FUNCTION F : BOOL VAR_INPUT x : BOOL; END_VAR IF x THEN F := TRUE; END_IF END_FUNCTION
        FUNCTION N : INT VAR_INPUT x : INT; END_VAR IF x > 0 THEN N := x; END_IF END_FUNCTION
        FUNCTION K : E VAR_INPUT x : BOOL; END_VAR IF x THEN K := r; END_IF END_FUNCTION
        FUNCTION_BLOCK B VAR q : BOOL; END_VAR
        METHOD M : BOOL VAR_INPUT x : BOOL; END_VAR IF x THEN M := TRUE; END_IF END_METHOD
        q := q; END_FUNCTION_BLOCK";
    let variables = "b : BOOL; n : INT; e : E; f : B;";
    for (body, holds, never) in [
        ("b := F(TRUE); b := F(FALSE);", "NOT b", "b"),
        ("b := f.M(x := TRUE); b := f.M(x := FALSE);", "NOT b", "b"),
        ("n := N(7) + N(0);", "n = 7", "n <> 7"),
        ("e := K(TRUE); e := K(FALSE);", "e = E#p", "e <> E#p"),
    ] {
        assert!(may(units, variables, body, holds), "{body} {holds}");
        assert!(!may(units, variables, body, never), "{body} {never}");
    }
}

#[test]
fn what_is_called_may_change_a_loops_variable_by_whichever_name() {
    let looping = |units: &str, variables: &str, body: &str| {
        bound(&format!(
            "VAR_GLOBAL g, h : INT; END_VAR {units} PROGRAM main VAR n : INT; {variables} END_VAR
             {body} END_PROGRAM"
        ))
    };
    let refused = Err(vec![Code::LoopCount]);
    let handed = |what: &str| {
        format!(
            "FUNCTION In : BOOL VAR_IN_OUT x : INT; END_VAR x := 0; END_FUNCTION
             FUNCTION Give : BOOL VAR_OUTPUT o : INT; END_VAR o := 0; END_FUNCTION
             FUNCTION_BLOCK Out VAR b : BOOL; END_VAR {what} END_FUNCTION_BLOCK"
        )
    };
    let in_for = "FOR g := 1 TO 10 DO n := n + 1; o(); END_FOR";
    let in_while = "WHILE g < 10 DO o(); g := g + 1; END_WHILE";
    for what in ["b := In(x := g);", "b := In(g);", "Give(o => g);", "FOR g := 0 TO 1 DO ; END_FOR"]
    {
        for body in [in_for, in_while] {
            assert_eq!(looping(&handed(what), "o : Out;", body), refused, "{what} {body}");
        }
    }
    assert!(looping(&handed("b := In(x := h);"), "o : Out;", in_for).is_ok());
    // A variable of an instance, which it writes itself.
    let block = "FUNCTION_BLOCK F VAR i : INT; END_VAR i := 0; END_FUNCTION_BLOCK
        FUNCTION_BLOCK G VAR f : F; END_VAR f(); END_FUNCTION_BLOCK";
    assert_eq!(looping(block, "f : F;", "FOR f.i := 1 TO 3 DO f(); END_FOR"), refused);
    assert_eq!(looping(block, "k : G;", "FOR k.f.i := 1 TO 3 DO k(); END_FOR"), refused);
    assert!(looping(block, "f : F; i : INT;", "FOR i := 1 TO 3 DO f(); END_FOR").is_ok());
}

#[test]
fn names_and_first_values_are_taken_for_no_others() {
    // A range that does not hold 0 does not begin with it.
    let text = "PROGRAM main VAR n : INT (5..10); x, y : BOOL; END_VAR
                IF n = 5 THEN x := TRUE; y := TRUE; END_IF IF y THEN n := 0; END_IF END_PROGRAM";
    let found = trusting(Trust::All, text).expect("a sound program");
    assert_eq!(found.bound.upper, Picos(3_000_000));
    // Two enumerations have the same name with different numbers.
    let types = "TYPE A : (p, q, r); B : (r, q, p); END_TYPE ";
    let end = |end: &str| {
        bound(&format!(
            "{types} PROGRAM main VAR i : INT; x : BOOL; END_VAR FOR i := 0 TO {end} DO x := TRUE; END_FOR END_PROGRAM"
        ))
    };
    assert!(end("r").is_err());
    assert_eq!((end("A#r"), end("B.p"), end("q")), (Ok(7), Ok(7), Ok(5)));
}

#[test]
fn a_block_without_a_body_may_or_may_not_carry_out_that_of_its_base() {
    let units =
        "FUNCTION_BLOCK base VAR x, on : BOOL; END_VAR x := TRUE; on := TRUE; END_FUNCTION_BLOCK
                 FUNCTION_BLOCK own EXTENDS base VAR z : BOOL; END_VAR END_FUNCTION_BLOCK ";
    let main = "PROGRAM main VAR f : own; x, y : BOOL; END_VAR f.on := FALSE; f();
                IF NOT f.on THEN x := TRUE; y := TRUE; x := FALSE; END_IF END_PROGRAM";
    // Not carried out: one store and three; carried out: one and two.
    assert_eq!(bound(&format!("{units}{main}")), Ok(4));
}

/// What is handed over in and out is the caller's own variable, so nothing called may know it by another name.
#[test]
fn what_is_handed_over_in_and_out_has_one_name() {
    let called = |body: &str, call: &str| {
        bound(&format!(
            "FUNCTION_BLOCK f VAR_IN_OUT a, b : INT; END_VAR VAR_EXTERNAL g : INT; END_VAR VAR k : INT; END_VAR \
             {body} END_FUNCTION_BLOCK \
             PROGRAM main VAR u, v : INT; w : ARRAY[0..3] OF INT; i : f; END_VAR VAR_EXTERNAL g, h : INT; END_VAR \
             {call} END_PROGRAM \
             CONFIGURATION c VAR_GLOBAL g, h : INT; END_VAR RESOURCE r ON PLC TASK t(INTERVAL := T#10ms, PRIORITY := 1); \
             PROGRAM inst WITH t : main; END_RESOURCE END_CONFIGURATION"
        ))
    };
    // With one variable for both the loop would never end.
    let body = "FOR a := 1 TO 3 DO b := 0; END_FOR";
    let refused = Err(vec![Code::NotModelled]);
    assert!(called(body, "i(a := u, b := v);").is_ok());
    assert!(called(body, "i(a := u, b := h);").is_ok());
    assert_eq!(called(body, "i(a := u, b := u);"), refused);
    assert_eq!(called(body, "i(u, u);"), refused);
    assert_eq!(called(body, "i(a := w[u], b := w[v]);"), refused);
    // What it names itself, and what is its own.
    assert_eq!(called("a := 1; IF g = 1 THEN b := 2; END_IF", "i(a := g, b := u);"), refused);
    assert_eq!(called("a := 1; IF k = 1 THEN b := 2; END_IF", "i(a := i.k, b := u);"), refused);
}

#[test]
fn what_is_handed_over_may_be_reached_through_its_instance() {
    let refused = Err(vec![Code::NotModelled]);
    let through = |reaches: &str| {
        bound(&format!(
            "VAR_GLOBAL ga : A; END_VAR
             FUNCTION_BLOCK A VAR v, o : INT; h : H; END_VAR
             METHOD SetV : BOOL VAR_INPUT n : INT; END_VAR v := n; END_METHOD
             h(x := v); END_FUNCTION_BLOCK
             FUNCTION_BLOCK H VAR_IN_OUT x : INT; END_VAR VAR_EXTERNAL ga : A; END_VAR VAR b : BOOL; k : INT; END_VAR
             x := 5; {reaches} END_FUNCTION_BLOCK
             PROGRAM main VAR_EXTERNAL ga : A; END_VAR ga(); END_PROGRAM"
        ))
    };
    assert_eq!(through("b := ga.SetV(n := 0);"), refused);
    assert_eq!(through("k := ga.v;"), refused);
    assert_eq!(through("ga.v := 0;"), refused);
    assert!(through("k := ga.o;").is_ok());
    let program = |given: &str, reaches: &str| {
        bound(&format!(
            "FUNCTION_BLOCK H VAR_IN_OUT x : INT; END_VAR VAR k : INT; END_VAR x := 5; {reaches} END_FUNCTION_BLOCK
             FUNCTION_BLOCK I VAR n : INT; END_VAR n := n; END_FUNCTION_BLOCK
             PROGRAM main VAR_OUTPUT g, o : INT; END_VAR VAR h : H; i : I; END_VAR h(x := {given}); END_PROGRAM"
        ))
    };
    assert_eq!(program("g", "k := main.g;"), refused);
    assert_eq!(program("i.n", "main.i.n := 0;"), refused);
    assert!(program("g", "k := main.o;").is_ok());
    // A chart's conditions and blocks name variables, too.
    let chart = |condition: &str, action: &str| {
        bound(&format!(
            "FUNCTION_BLOCK H VAR_IN_OUT x : BOOL; END_VAR VAR k : BOOL; END_VAR VAR_EXTERNAL g, o : BOOL; END_VAR
             INITIAL_STEP a: END_STEP STEP b: {action}(N); END_STEP
             TRANSITION FROM a TO b := {condition}; END_TRANSITION TRANSITION FROM b TO a := x; END_TRANSITION
             END_FUNCTION_BLOCK VAR_GLOBAL g, o : BOOL; END_VAR
             PROGRAM main VAR_EXTERNAL g, o : BOOL; END_VAR VAR h : H; END_VAR h(x := g); END_PROGRAM"
        ))
        .map(|_| ())
    };
    assert_eq!(chart("g", "k"), Err(vec![Code::NotModelled]));
}

#[test]
fn which_element_is_assigned_does_not_hang_on_its_value() {
    let with = |body: &str| {
        bound(&format!(
            "FUNCTION F : INT VAR_IN_OUT v : INT; END_VAR v := 1; F := 5; END_FUNCTION
             PROGRAM main VAR b : ARRAY[0..3] OF INT; i, j : INT; END_VAR {body} END_PROGRAM"
        ))
    };
    assert!(with("i := 0; b[i] := F(v := i);").is_ok());
    assert!(with("i := 0; b[i] := F(v := j);").is_ok());
}

#[test]
fn what_a_configuration_connects_is_copied_before_and_behind() {
    let with = |connected: &str| {
        bound(&format!(
            "PROGRAM main VAR_INPUT n : INT; END_VAR VAR_OUTPUT o : INT; END_VAR VAR x, k : INT; END_VAR
             IF n > 5 THEN FOR k := 1 TO n DO x := k; END_FOR; END_IF; o := 7; END_PROGRAM
             PROGRAM last VAR_EXTERNAL h : INT; END_VAR VAR x, k : INT; END_VAR
             IF h = 7 THEN FOR k := 1 TO 500 DO x := k; END_FOR; END_IF; END_PROGRAM
             PROGRAM first VAR_EXTERNAL g, h : INT; END_VAR g := 20; h := 0; END_PROGRAM
             CONFIGURATION c VAR_GLOBAL g, h, n : INT; END_VAR RESOURCE r ON PLC TASK t(INTERVAL := T#10ms, PRIORITY := 1);
             PROGRAM a WITH t : first; PROGRAM q WITH t : main {connected}; PROGRAM z WITH t : last;
             END_RESOURCE END_CONFIGURATION"
        ))
    };
    let of = |connected: &str| with(connected).unwrap_or_else(|codes| panic!("{codes:?}"));
    // A constant that leaves the loop out, and what an output leaves as it is.
    let none = of("(n := 5)");
    assert_eq!(of("(n := -4)"), none);
    let twenty = of("(n := g)");
    assert!(twenty > none + 15, "{twenty}, {none}");
    assert_eq!(of("(n := 20)"), twenty);
    assert!(of("(n := g, o => h)") > twenty + 400, "behind the program");
    assert_eq!(of("(n := g, o => g)"), twenty + 1, "a store");
    for wrong in ["(m := g)", "(o := g)", "(n => g)", "(n := nothing)"] {
        assert!(with(wrong).is_err_and(|codes| !codes.is_empty()), "{wrong}");
    }
    assert_eq!(with("(n := g + 1)"), Err(vec![Code::NotModelled]));
}

#[test]
fn what_stands_in_what_is_retained_is_retained() {
    // Two bits that no scan leaves on together: an earlier run may have stopped in between.
    let block = "FUNCTION_BLOCK F VAR_INPUT i1 : BOOL; END_VAR VAR a, b : BOOL; n : INT; END_VAR
        IF a AND b THEN FOR n := 1 TO 50 DO ; END_FOR END_IF
        a := TRUE; b := i1; IF i1 THEN a := FALSE; END_IF END_FUNCTION_BLOCK
        FUNCTION_BLOCK G VAR f : F; END_VAR VAR_INPUT x : BOOL; END_VAR f(i1 := x); END_FUNCTION_BLOCK ";
    let with = |declared: &str, call: &str| {
        let text = format!(
            "{block} VAR_GLOBAL p : BOOL; END_VAR PROGRAM main {declared} VAR x : BOOL; END_VAR {call} END_PROGRAM"
        );
        let found = trusting(Trust::All, &text).unwrap_or_else(|codes| panic!("{text}: {codes:?}"));
        found.bound.upper > Picos(50_000_000)
    };
    assert!(!with("VAR f : F; END_VAR", "f(i1 := x);"));
    for section in ["RETAIN", "PERSISTENT"] {
        assert!(with(&format!("VAR {section} f : F; END_VAR"), "f(i1 := x);"), "{section}");
        assert!(with(&format!("VAR {section} g : G; END_VAR"), "g(x := x);"), "{section}");
        let array = format!("VAR {section} f : ARRAY[0..1] OF F; END_VAR");
        assert!(with(&array, "f[1](i1 := x);"), "{section}");
    }
    let program = |retained: &str| {
        let text = format!(
            "{block} PROGRAM main VAR f : F; x : BOOL; END_VAR f(i1 := x); END_PROGRAM CONFIGURATION c
             RESOURCE r ON PLC TASK t(INTERVAL := T#10ms, PRIORITY := 1); PROGRAM {retained} q WITH t : main;
             END_RESOURCE END_CONFIGURATION"
        );
        trusting(Trust::All, &text).expect("a program").bound.upper > Picos(50_000_000)
    };
    assert!(program("RETAIN"));
    assert!(!program(""));
}

#[test]
fn blocks_with_two_of_the_one_before_are_refused_once_there_are_too_many() {
    let nested = |levels: usize| {
        let mut text = "FUNCTION_BLOCK F0 VAR_INPUT x : BOOL; END_VAR VAR q : BOOL; END_VAR \
                        q := x; END_FUNCTION_BLOCK\n"
            .to_owned();
        for level in 1..=levels {
            let before = level - 1;
            text += &format!(
                "FUNCTION_BLOCK F{level} VAR_INPUT x : BOOL; END_VAR VAR a, b : F{before}; END_VAR \
                 a(x := x); b(x := NOT x); END_FUNCTION_BLOCK\n"
            );
        }
        text + &format!("PROGRAM Main VAR f : F{levels}; i : BOOL; END_VAR f(x := i); END_PROGRAM")
    };
    // Each call stores what is handed over, the innermost one more.
    assert_eq!(bound(&nested(3)), Ok(1 + 2 + 4 + 8 + 8));
    assert_eq!(bound(&nested(60)), Err(vec![Code::TooLarge]));
}

#[test]
fn structures_and_arrays_are_copied_as_wholes() {
    let types = "TYPE S : STRUCT x : BOOL; n : INT; END_STRUCT; END_TYPE ";
    let given = "FUNCTION_BLOCK F VAR_IN_OUT s : S; END_VAR s.x := TRUE; END_FUNCTION_BLOCK ";
    let taken = "FUNCTION_BLOCK G VAR_OUTPUT s : S; a : ARRAY[0..1] OF INT; END_VAR s.n := 5; a[1] := 4; END_FUNCTION_BLOCK ";
    let main = |body: &str| {
        bound(&format!(
            "{types}{given}{taken}PROGRAM main VAR st, t2 : S; f : F; g : G; y : BOOL; b, c : ARRAY[0..1] OF INT; END_VAR {body} END_PROGRAM"
        ))
    };
    // What is called changes the caller's own structure: three stores that hand over, in the body and back, and one
    // more.
    assert_eq!(main("st.x := FALSE; f(s := st); IF st.x THEN y := TRUE; END_IF"), Ok(5));
    assert_eq!(main("st.x := FALSE; f(s := st); IF NOT st.x THEN y := TRUE; END_IF"), Ok(4));
    // Results. Copies of wholes are no stores: `COPY` prices them (tests/it/iec_wholes.rs).
    assert_eq!(main("t2.n := 0; g(s => t2); IF t2.n = 5 THEN y := TRUE; END_IF"), Ok(4));
    assert_eq!(main("b[1] := 0; g(a => b); IF b[1] = 4 THEN y := TRUE; END_IF"), Ok(4));
    // Assignments.
    assert_eq!(main("t2.n := 3; st := t2; IF st.n = 3 THEN y := TRUE; END_IF"), Ok(2));
    assert_eq!(main("t2.n := 3; st := t2; IF st.n <> 3 THEN y := TRUE; END_IF"), Ok(1));
    assert_eq!(main("b[0] := 3; c := b; IF c[0] <> 3 THEN y := TRUE; END_IF"), Ok(1));
}

#[test]
fn what_is_evaluated_first_is_not_changed_by_a_later_call() {
    let with = |body: &str| {
        bound(&format!(
            "FUNCTION f : INT VAR_IN_OUT v : INT; END_VAR v := 9; f := 1; END_FUNCTION \
             FUNCTION_BLOCK B VAR_INPUT a, b : INT; END_VAR VAR x : BOOL; END_VAR \
             IF a = 5 THEN x := TRUE; END_IF END_FUNCTION_BLOCK \
             PROGRAM main VAR n, m : INT; y : BOOL; k : B; END_VAR {body} END_PROGRAM"
        ))
    };
    // Stores: n, the argument, v, f, back, m.
    assert_eq!(with("n := 5; m := n + f(v := n);"), Ok(6));
    assert_eq!(with("n := 5; m := n + f(v := n); IF m = 6 THEN y := TRUE; END_IF"), Ok(7));
    // Or from right to left.
    assert_eq!(with("n := 5; m := n + f(v := n); IF m = 10 THEN y := TRUE; END_IF"), Ok(7));
    let neither = "n := 5; m := n + f(v := n); IF m <> 6 AND m <> 10 THEN y := TRUE; END_IF";
    assert_eq!(with(neither), Ok(6));
    assert_eq!(with("n := 5; k(a := n, b := f(v := n));"), Ok(8));
}

#[test]
fn times_below_a_millisecond_and_below_zero_may_be_any() {
    assert_eq!(of("t : TIME;", "t := T#1ms / 2; IF t > T#0ms THEN x := TRUE; END_IF"), Ok(2));
    let below = "t := T#1s; t := t - T#2s; IF t > T#1h THEN x := TRUE; END_IF";
    assert_eq!(of("t : TIME;", below), Ok(3));
    let above = "t := T#2s; t := t - T#1s; IF t <> T#1s THEN x := TRUE; END_IF";
    assert_eq!(of("t : TIME;", above), Ok(2));
}

#[test]
fn operators_are_functions_too() {
    assert_eq!(of("", "IF AND(a, NOT(a)) THEN x := TRUE; END_IF"), Ok(0));
    assert_eq!(of("", "IF XOR(a, a) OR OR(a, NOT a) THEN x := TRUE; END_IF"), Ok(1));
}

#[test]
fn an_instance_with_a_chart_is_not_handed_over_in_and_out() {
    let found = bound(
        "FUNCTION_BLOCK W INITIAL_STEP a: END_STEP STEP b: END_STEP \
         TRANSITION FROM a TO b := TRUE; END_TRANSITION TRANSITION FROM b TO a := TRUE; END_TRANSITION \
         END_FUNCTION_BLOCK FUNCTION_BLOCK G VAR_IN_OUT w : W; END_VAR w(); END_FUNCTION_BLOCK \
         PROGRAM main VAR w : W; g : G; END_VAR w(); g(w := w); END_PROGRAM",
    );
    assert_eq!(found, Err(vec![Code::NotModelled]));
}

#[test]
fn the_element_that_is_handed_over_stays_the_same() {
    let with = |body: &str| {
        bound(&format!(
            "FUNCTION_BLOCK F VAR_IN_OUT e, i : INT; END_VAR e := 1; i := 2; END_FUNCTION_BLOCK \
             PROGRAM main VAR f : F; b : ARRAY[0..3] OF INT; i, j : INT; END_VAR {body} END_PROGRAM"
        ))
    };
    assert_eq!(with("i := 1; f(e := b[i], i := i);"), Err(vec![Code::NotModelled]));
    assert_eq!(with("i := 1; f(e := b[i], i := j);"), Ok(7));
}

/// Whether a condition may hold at a program's end: more stores than it has otherwise are carried out then.
fn may(units: &str, variables: &str, body: &str, condition: &str) -> bool {
    let text = format!(
        "{units} PROGRAM main VAR a AT %IX0.0 : BOOL; w AT %IW2 : INT; heavy : INT; {variables} END_VAR {body}
         IF {condition} THEN FOR heavy := 1 TO 50 DO ; END_FOR END_IF END_PROGRAM"
    );
    bound(&text).unwrap_or_else(|codes| panic!("{codes:?}\n{text}")) > 50
}

#[test]
fn calls_with_en_are_carried_out_only_where_it_is_true() {
    let units = "FUNCTION F : INT VAR_INPUT i : INT; END_VAR VAR_IN_OUT c : INT; END_VAR c := 0; F := i; END_FUNCTION
        FUNCTION_BLOCK B VAR_INPUT i : INT; END_VAR VAR_OUTPUT o : INT; END_VAR o := i; END_FUNCTION_BLOCK";
    let calls = "x := 1; y := F(EN := a, i := 7, c := x);";
    assert!(may(units, "x, y : INT;", calls, "NOT a AND x = 1"));
    assert!(!may(units, "x, y : INT;", calls, "a AND x = 1"));
    assert!(!may(units, "x, y : INT;", calls, "a AND y <> 7"));
    // What a function gives that is not carried out is not said.
    assert!(may(units, "x, y : INT;", calls, "NOT a AND y = 3"));
    let calls = "b(i := 1); b(EN := a, i := 2, ENO => ok);";
    assert!(may(units, "b : B; ok : BOOL;", calls, "b.o = 1"));
    assert!(!may(units, "b : B; ok : BOOL;", calls, "b.o = 1 AND ok"));
    assert!(!may(units, "b : B; ok : BOOL;", calls, "a <> ok"));
    let calls = "x := ADD(EN := a, IN1 := w, IN2 := 1, ENO => ok);";
    assert!(!may("", "x : INT; ok : BOOL;", calls, "ok AND w < 100 AND x <> w + 1"));
    assert!(may("", "x : INT; ok : BOOL;", calls, "NOT ok AND x <> w + 1"));
    let calls = "t(EN := a, CLK := TRUE);";
    assert!(may("", "t : R_TRIG;", "t(CLK := FALSE); t(EN := a, CLK := TRUE);", "NOT t.Q"));
    assert!(may("", "t : R_TRIG;", calls, "NOT a AND t.Q"));
}

#[test]
fn variables_of_var_temp_begin_anew_with_every_call() {
    let unit = "FUNCTION_BLOCK B VAR_OUTPUT o : INT; END_VAR VAR_TEMP t : INT; u : INT := 4; END_VAR o := t + u; t := 5; u := 6; END_FUNCTION_BLOCK";
    assert!(may(unit, "b : B;", "b(); b();", "b.o = 4"));
    assert!(!may(unit, "b : B;", "b(); b();", "b.o <> 4"));
}

#[test]
fn of_an_input_with_r_edge_a_block_sees_edges() {
    let unit = "FUNCTION_BLOCK B VAR_INPUT c : BOOL R_EDGE; END_VAR VAR_OUTPUT o : BOOL; END_VAR o := c; END_FUNCTION_BLOCK";
    assert!(may(unit, "b : B;", "b(c := a);", "a AND NOT b.o"));
    assert!(!may(unit, "b : B;", "b(c := FALSE); b(c := a);", "a AND NOT b.o"));
    assert!(!may(unit, "b : B;", "b(c := TRUE); b(c := a);", "b.o"));
    let bare = "FUNCTION F : BOOL VAR_INPUT c : BOOL F_EDGE; END_VAR F := c; END_FUNCTION PROGRAM main VAR x : BOOL; END_VAR x := F(c := x); END_PROGRAM";
    assert!(bound(bare).is_err(), "a function remembers nothing");
}

#[test]
fn an_operand_that_calls_something_may_be_left_out() {
    let unit = "FUNCTION F : BOOL VAR_IN_OUT c : INT; END_VAR c := 0; F := TRUE; END_FUNCTION";
    for operator in ["AND", "OR"] {
        let body = format!("x := 1; z := a {operator} F(c := x);");
        let left_out = if operator == "AND" { "NOT a" } else { "a" };
        assert!(may(unit, "x : INT; z : BOOL;", &body, "x = 1"), "{operator}");
        assert!(may(unit, "x : INT; z : BOOL;", &body, &format!("x = 0 AND {left_out}")));
        let kept = format!("x = 1 AND NOT ({left_out})");
        assert!(!may(unit, "x : INT; z : BOOL;", &body, &kept), "{operator}");
        let is = if operator == "AND" { "z <> a" } else { "NOT z" };
        assert!(!may(unit, "x : INT; z : BOOL;", &body, is), "{operator}");
    }
    // These always leave it out.
    for operator in ["AND_THEN", "OR_ELSE"] {
        let body = format!("x := 1; z := a {operator} F(c := x);");
        let left_out = if operator == "AND_THEN" { "NOT a" } else { "a" };
        assert!(!may(unit, "x : INT; z : BOOL;", &body, &format!("(x = 0) = ({left_out})")));
        let is = if operator == "AND_THEN" { "z <> a" } else { "NOT z" };
        assert!(!may(unit, "x : INT; z : BOOL;", &body, is), "{operator}");
    }
}

#[test]
fn inputs_of_functions_that_are_named_stand_in_any_order() {
    assert!(may("", "x : INT;", "x := SUB(IN2 := 5, IN1 := 8);", "x = 3"));
    assert!(!may("", "x : INT;", "x := SUB(IN2 := 5, IN1 := 8);", "x <> 3"));
    assert!(!may("", "x : INT;", "x := SEL(IN1 := 1, IN0 := 2, G := TRUE);", "x <> 1"));
    assert!(!may("", "x : INT;", "x := LIMIT(MX := 5, IN := 9, MN := 1);", "x <> 5"));
    // One that is left out holds what its declaration says, which is not known.
    assert!(may("", "x : INT;", "x := SUB(IN2 := w);", "x <> w"));
}

#[test]
fn the_sign_of_eight_bits_is_a_bit_like_others() {
    assert!(!may("", "s : SINT;", "s := 0; s.7 := TRUE;", "s <> -128"));
    assert!(!may("", "s : SINT;", "s := -1; s.7 := FALSE;", "s <> 127"));
    assert!(!may("", "s : USINT;", "s := 0; s.7 := TRUE;", "s <> 128"));
}

#[test]
fn a_units_own_constant_hides_a_global_one() {
    let units = "VAR_GLOBAL CONSTANT n : INT := 3; m : INT := 4; END_VAR
        FUNCTION F : INT VAR_INPUT i : INT; END_VAR VAR CONSTANT n : INT := 5; END_VAR VAR k : INT := n; END_VAR F := k + m; END_FUNCTION";
    assert!(!may(units, "x : INT;", "x := F(i := 1);", "x <> 9"));
    assert!(!may(units, "", "", "n <> 3"));
    // Loops count to constants.
    let text = "PROGRAM main VAR CONSTANT n : INT := 5; END_VAR VAR i : INT; x : BOOL; END_VAR FOR i := 1 TO n DO x := TRUE; END_FOR END_PROGRAM";
    assert_eq!(bound(text), Ok(11));
}

#[test]
fn enumerations_stand_in_declarations_and_have_types() {
    for declared in
        ["(D, B, C)", "(D, B, C) UINT", "INT (D, B, C)", "USINT (D := 0, B := 1, C := 2) := D"]
    {
        let unit = format!("TYPE E : {declared}; END_TYPE");
        assert!(!may(&unit, "e : E;", "e := B;", "e <> E#B OR e = C"), "{declared}");
    }
    assert!(!may(
        "",
        "e : (red, green, blue);",
        "IF a THEN e := red; ELSE e := blue; END_IF",
        "e = green"
    ));
    let large = "TYPE E : DINT (D := 0, B := 65536); END_TYPE";
    assert!(!may(large, "e : E;", "e := B;", "e = D"));
    assert!(may(large, "e : E;", "e := B;", "e = B"));
}

/// The same of an instruction list.
fn list_may(units: &str, variables: &str, list: &str, condition: &str) -> bool {
    let text = format!(
        "{units} VAR_GLOBAL a AT %IX0.0 : BOOL; {variables} END_VAR PROGRAM main\n{list}\nEND_PROGRAM
         PROGRAM behind VAR heavy : INT; END_VAR
         IF {condition} THEN FOR heavy := 1 TO 50 DO ; END_FOR END_IF END_PROGRAM"
    );
    bound(&text).unwrap_or_else(|codes| panic!("{codes:?}\n{text}")) > 50
}

#[test]
fn the_result_of_a_list_goes_with_jumps_and_calls() {
    let list = "LD a\nJMPC out\nLD FALSE\nout:\nST x";
    assert!(list_may("", "x : BOOL;", list, "x"));
    assert!(!list_may("", "x : BOOL;", list, "x <> a"));
    // Numbers, too; and what is not of one kind may be anything.
    let list = "LD a\nJMPC out\nLD 5\nout:\nST x";
    assert!(list_may("", "x : INT;", list, "x = 9"));
    let list = "LD TRUE\nST x\nLD x\nCAL b(c := x)\nST y";
    let unit = "FUNCTION_BLOCK B VAR_IN_OUT c : BOOL; END_VAR c := FALSE; END_FUNCTION_BLOCK";
    assert!(!list_may(unit, "x, y : BOOL; b : B;", list, "x OR NOT y"));
    // A function is carried out, whoever asks for what it gives; its operands stand in its line.
    let unit = "FUNCTION F : INT VAR_INPUT i : INT; END_VAR n := i; F := 2; END_FUNCTION";
    let list = "LD 7\nF\nLD 1\nST x\nLD x\nMAX 3\nABS\nST y";
    assert!(!list_may(unit, "n, x, y : INT;", list, "n <> 7 OR y <> 3"));
    let list = "LD TRUE\nCLK t\nLD FALSE\nCLK t\nLD a\nCLK t\nLD t.Q\nST x";
    assert!(!list_may("", "x : BOOL; t : R_TRIG;", list, "x <> a"));
}

//! Programs of IEC 61131-3 as the analysis follows them, where a slip would make a bound too low.

use scanbound::audit::{Failure, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// The longest scan in microseconds, where a store takes one and nothing else anything.
fn bound(text: &str) -> Result<u64, Vec<Code>> {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += "ST,1,1\n@end,0,\n";
    let table =
        Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table;
    let inputs = [Input { name: "main.st".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request =
        Request { table: Some(&table), trust: Trust::None, ..Request::new(&inputs, &facts) };
    match audit(&request) {
        Ok(found) => Ok(found.bound.upper.0.div_ceil(Picos(1_000_000).0)),
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
    assert_eq!(of("n : SINT;", "IF n + n = 254 THEN x := TRUE; END_IF"), Ok(0));
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
    assert_eq!(of("n : INT;", "WHILE n > 0 DO n := n - 1; END_WHILE"), Err(vec![Code::LoopCount]));
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
fn shared_memory_and_unknown_names_are_refused() {
    assert_eq!(of("m AT %MW0 : INT; n AT %MX0.0 : BOOL;", "m := 1;"), Err(vec![Code::NotModelled]));
    assert_eq!(of("m AT %QX0.0 : BOOL;", "%QX0.0 := TRUE;"), Err(vec![Code::NotModelled]));
    assert_eq!(of("", "q := TRUE;"), Err(vec![Code::UnknownName]));
    assert_eq!(of("t : FB_Pump;", "x := TRUE;"), Err(vec![Code::UnknownType]));
}

//! What controllers do differently in calls: what they do where EN is false, in which order they pass inputs and take
//! outputs, and how often they call what is an operand.

use common::audited::{audited, table};
use common::iec::probe;
use scanbound::base::facts::Facts;
use scanbound::passes::values::Trust;

const UNITS: &str = "
    FUNCTION F : INT VAR_INPUT a : INT; b : INT := 3; END_VAR VAR_OUTPUT o : INT; END_VAR VAR l : INT := 7; END_VAR
        o := a; F := a; END_FUNCTION
    FUNCTION Is : BOOL VAR_INPUT a : BOOL; END_VAR Is := a; END_FUNCTION
    FUNCTION H : INT VAR_OUTPUT o, p : INT; END_VAR o := 1; p := 2; H := 3; END_FUNCTION
    FUNCTION_BLOCK C VAR_OUTPUT o : INT; b : BOOL; END_VAR VAR_IN_OUT x : INT; END_VAR o := 1; x := 5; END_FUNCTION_BLOCK
    FUNCTION_BLOCK B VAR_INPUT n, k : INT; END_VAR VAR_OUTPUT o, p : INT; b, c : BOOL; END_VAR
        METHOD M : INT VAR_INPUT k : INT; END_VAR M := k; END_METHOD
        METHOD Up : INT n := n + 1; Up := n; END_METHOD END_FUNCTION_BLOCK
    FUNCTION_BLOCK D VAR_INPUT a, b, c : INT; END_VAR END_FUNCTION_BLOCK
    TYPE S : STRUCT m, n : INT; END_STRUCT END_TYPE";

/// The longest scan of a program with this statement, and the longest scan found, if only this row takes time: as
/// multiples of it.
fn times(statement: &str, row: &str) -> Result<(u64, u64), String> {
    let variables =
        "x, y, r, v : INT; w : WORD; f : B; g : C; d : D; t : TON; q : BOOL; a AT %IX0.0 : BOOL;
         ts : ARRAY[0..3] OF TON; s : ARRAY[0..3] OF S;";
    let text = format!("{UNITS} PROGRAM main VAR {variables} END_VAR {statement} END_PROGRAM");
    let table = table(&format!("PROGRAM,0,\n{row},1,\n@end,0,\n"));
    let found = audited("iec-text", None, &[("p.st", &text)], &table, &Facts::default())?;
    let bound = &found.audit.bound;
    Ok((bound.upper.0 / 1_000_000, bound.lower.0 / 1_000_000))
}

#[test]
fn arguments_that_are_worked_out_where_en_is_false_take_time() {
    for (statement, costs) in [
        // The argument is loaded and passed, the output loaded and stored; the result is stored in any case.
        (
            "r := F(EN := FALSE, a := x, o => v);",
            &[("LD", 2, 0), ("ST", 3, 1), ("CAL", 1, 0), ("JMP", 1, 1), ("INIT", 4, 0)][..],
        ),
        (
            "r := ADD(EN := FALSE, IN1 := x * y, IN2 := y);",
            &[("LD", 3, 0), ("MUL", 1, 0), ("ADD", 1, 0), ("JMP", 1, 1), ("ST", 1, 1)],
        ),
        ("r := f.M(EN := FALSE, k := x);", &[("LD", 1, 0), ("CAL", 1, 0), ("JMP", 1, 1)]),
        ("f(EN := FALSE);", &[("CAL", 1, 0), ("JMP", 1, 1)]),
        ("f(EN := FALSE, n := x, o => v);", &[("LD", 2, 0), ("ST", 2, 0), ("CAL", 1, 0)]),
        ("t(EN := FALSE, IN := q);", &[("LD", 1, 0), ("ST", 1, 0), ("TON", 1, 0)]),
        // Where EN may be true, all of it is.
        ("r := ADD(EN := a, IN1 := x * y, IN2 := y);", &[("LD", 4, 4), ("MUL", 1, 1)]),
    ] {
        for &(row, upper, lower) in costs {
            assert_eq!(times(statement, row), Ok((upper, lower)), "{statement} {row}");
        }
    }
}

#[test]
fn no_order_is_taken_between_en_and_an_argument_that_changes_it() {
    for statement in [
        "r := F(EN := f.n > 3, a := f.Up());",
        "r := ADD(EN := f.Up() > 3, IN1 := f.n, IN2 := 1);",
        "t(EN := f.n > 3, IN := f.Up() > 3);",
    ] {
        let refused = times(statement, "LD").expect_err(statement);
        assert!(refused.contains("an argument and EN"), "{statement}: {refused}");
    }
    assert!(times("r := F(EN := x > 3, a := f.Up());", "LD").is_ok());
}

#[test]
fn a_call_that_depends_on_the_order_of_its_inputs_or_outputs_is_refused() {
    for statement in [
        "f(n := x, k := f.n);",
        "f(k := f.n + 1, n := f.k);",
        "f(n := x, k := f.Up());",
        "t(IN := t.PT > T#1s, PT := T#2s);",
        "f(o => x, p => x);",
        "d(c := f.Up(), a := f.Up(), b := f.Up());",
        "FOR y := 0 TO 3 DO ts[y](IN := ts[x].PT > T#1s, PT := T#2s); END_FOR;",
        "g(x := v, o => v);",
        "x := H(o => v, p => v);",
        "g(x := v, ENO => q, b => q);",
    ] {
        assert!(times(statement, "LD").is_err(), "{statement}");
    }
    for statement in [
        "f(n := f.n + 1, k := f.o);",
        "f(o => x, p => y);",
        "f(n := x, o => x);",
        "f(o => w.0, p => w.1);",
        "t(IN := NOT t.Q, PT := T#2s);",
        "d(a := f.Up(), b := f.Up(), c := f.Up());",
        "FOR y := 0 TO 3 DO ts[y](IN := NOT ts[y].Q, PT := T#1s); END_FOR;",
        "FOR y := 1 TO 3 DO ts[y](IN := ts[y - 1].Q, PT := T#1s); END_FOR;",
        "x := 2; f(o => s[x].m, p => s[x].n);",
    ] {
        let found = times(&statement.replace("o => w.0, p => w.1", "b => w.0, c => w.1"), "LD");
        assert!(found.is_ok(), "{statement}: {found:?}");
    }
}

#[test]
fn a_negated_output_of_a_standard_function_is_written() {
    for call in ["x := MOVE(IN := 1, NOT OUT => q);", "x := MOVE(IN := 1, OUT => q);"] {
        for (before, condition) in [("FALSE", "q"), ("TRUE", "NOT q")] {
            let statement = format!(
                "q := {before}; {call} IF {condition} THEN FOR y := 1 TO 50 DO r := 1; END_FOR END_IF"
            );
            let (upper, _) = times(&statement, "ST").expect(call);
            assert!(upper > 50, "{statement}: {upper}");
        }
    }
}

#[test]
fn operands_of_xor_and_mod_may_be_worked_out_twice() {
    for (statement, upper, lower) in [
        // The left side of XOR, and the divisor of MOD.
        ("q := Is(a) XOR a;", 2, 1),
        ("q := a XOR Is(a);", 1, 1),
        ("q := Is(a) XOR Is(q) XOR Is(a);", 7, 3),
        ("x := y MOD F(a := 3);", 2, 1),
        ("x := F(a := 3) MOD y;", 1, 1),
        ("x := x XOR F(a := 3);", 1, 1),
    ] {
        assert_eq!(times(statement, "CAL"), Ok((upper, lower)), "{statement}");
    }
    // What leaves more than its value is refused: the other operand may be worked out twice then, too, or not at all.
    for statement in [
        "q := (f.Up() > 0) XOR a;",
        "q := (f.n > 0) XOR (f.Up() > 0);",
        "x := f.Up() MOD y;",
        "x := y MOD f.Up();",
    ] {
        assert!(times(statement, "CAL").is_err(), "{statement}");
    }
    assert!(times("x := f.Up() MOD 3;", "CAL").is_ok());
    let chain = "Is(a) XOR ".repeat(12);
    assert!(times(&format!("q := {chain} a;"), "CAL").is_err());
}

#[test]
fn a_variable_that_hides_a_function_is_not_called() {
    for variable in ["Is : INT;", "Is : REF_TO INT;"] {
        let text = |call: &str| {
            format!(
                "FUNCTION Is : BOOL Is := TRUE; END_FUNCTION
                 PROGRAM main VAR {variable} n : INT; END_VAR {call} n := 1; END_PROGRAM"
            )
        };
        let audit = |call: &str| probe::audited(&[("m.st", &text(call))], "", Trust::None);
        assert!(audit("").is_ok());
        assert!(audit("Is();").is_err_and(|why| why.contains("cannot be called")), "{variable}");
    }
}

#[test]
fn whatever_takes_time_in_an_operand_is_evaluated_again() {
    for (statement, row, upper) in [
        ("q := (NOT a) XOR q;", "NOT", 2),
        ("x := y MOD (-x);", "SUB", 2),
        ("q := a XOR q XOR a XOR q XOR a;", "XOR", 15),
        // The index of an element within the index of another one.
        ("x := s[1 MOD s[1 MOD x].m].n;", "MOD", 3),
    ] {
        let (found, _) = times(statement, row).expect("read");
        assert!(found >= upper, "{statement}: {found}");
    }
    let nested = (0..20).fold("x".to_owned(), |inner, _| format!("s[1 MOD {inner}].m"));
    assert!(times(&format!("x := {nested};"), "MOD").is_err());
    assert!(times(&format!("q := {} a;", "a XOR ".repeat(9)), "XOR").is_err());
}

#[test]
fn a_name_alone_whose_index_calls_something_is_refused() {
    assert!(times("s[F(a := 1)];", "CAL").is_err());
    assert_eq!(times("s[1].m;", "CAL"), Ok((0, 0)));
}

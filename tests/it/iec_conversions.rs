//! Conversions, numbers with and without a sign, and counters: the bound takes all that any controller does with them.

use scanbound::audit::{Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::timing::table::{CLASSES, Table};

/// Whether a condition may hold behind these statements, by the bound.
fn may(variables: &str, body: &str, then: &str) -> bool {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += "LN,1000,1000\n@end,0,\n";
    let table =
        Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table;
    let text = format!(
        "PROGRAM main VAR r : REAL; a AT %IX0.0 : BOOL; {variables} END_VAR
         {body} IF {then} THEN r := LN(r); END_IF END_PROGRAM"
    );
    let inputs = [Input { name: "main.st".to_owned(), bytes: text.into_bytes() }];
    let facts = Facts::parse("facts.toml", "").unwrap_or_else(|faults| panic!("{faults:?}"));
    let request = Request { table: Some(&table), ..Request::new(&inputs, &facts) };
    let found = audit(&request).unwrap_or_else(|failure| panic!("{failure:?}"));
    found.bound.upper >= Picos(1_000_000_000)
}

#[test]
fn short_numbers_stay_within_their_type() {
    let is = |body: &str, then: &str| may("s, q : SINT; b : BYTE; x : INT;", body, then);
    assert!(is("q := -128; s := ABS(q);", "s < 0"));
    assert!(!is("q := -128; s := ABS(q);", "s > 0"));
    assert!(!is("q := -128; s := ABS(q); x := s;", "x = 128"));
    assert!(is("q := -128; x := ABS(q);", "x = 128"), "more bits may be kept of it");
    assert!(!is("q := -5; s := ABS(q);", "s <> 5"));
    assert!(!is("q := -128; s := -q; x := s;", "x <> -128"));
    assert!(is("s := 16#FF;", "s = -1"));
    assert!(!is("b := -1; x := b;", "x <> 255"));
}

#[test]
fn a_number_becomes_true_by_all_its_bits_or_the_last() {
    let is = |body: &str, then: &str| may("w : WORD; b : BYTE; x : BOOL;", body, then);
    for of in ["w := 2; x := WORD_TO_BOOL(w);", "b := 2; x := BYTE_TO_BOOL(b);"] {
        assert!(is(of, "x") && is(of, "NOT x"), "{of}");
    }
    assert!(is("x := WORD_TO_BOOL(2);", "NOT x"));
    assert!(is("w := 6; x := TO_BOOL(w);", "NOT x"));
    assert!(!is("w := 3; x := WORD_TO_BOOL(w);", "NOT x"));
    assert!(!is("w := 0; x := WORD_TO_BOOL(w);", "x"));
}

#[test]
fn reals_and_bit_strings_are_converted_by_number_or_by_bits() {
    let is = |body: &str, then: &str| may("d : DWORD; u : UDINT; x : REAL;", body, then);
    let to = "d := 16#3F800000; x := DWORD_TO_REAL(d);";
    assert!(is(to, "x = 1.0") && is(to, "x = 1065353216.0"));
    assert!(!is(to, "x = 2.0"));
    let from = "x := 1.0; d := REAL_TO_DWORD(x);";
    assert!(is(from, "d = 1") && is(from, "d = 16#3F800000"));
    assert!(!is(from, "d = 2"));
    assert!(!is("u := 5; x := UDINT_TO_REAL(u);", "x <> 5.0"), "numbers are converted");
    assert!(!is("x := 5.0; u := REAL_TO_UDINT(x);", "u <> 5"));
}

#[test]
fn what_a_real_becomes_beyond_its_new_type_is_any() {
    let is = |body: &str, then: &str| may("x : REAL; u : UINT; s : SINT;", body, then);
    for value in [0, 65534, 7] {
        assert!(is("x := -2.0; u := REAL_TO_UINT(x);", &format!("u = {value}")));
    }
    assert!(is("x := 200.0; s := REAL_TO_SINT(x);", "s = 127"));
    assert!(!is("x := 2.0; u := REAL_TO_UINT(x);", "u <> 2"));
    assert!(!is("u := 40000; x := UINT_TO_REAL(u);", "x <> 40000.0"));
}

#[test]
fn bits_above_a_number_that_becomes_a_longer_bit_string_are_its_sign_or_0() {
    let is = |body: &str, then: &str| may("s : SINT; w : WORD;", body, then);
    let below = "s := -1; w := SINT_TO_WORD(s);";
    assert!(is(below, "w = 16#FF") && is(below, "w = 16#FFFF"));
    assert!(!is(below, "w <> 16#FF AND w <> 16#FFFF"));
    assert!(is("w := SINT_TO_WORD(-1);", "w = 16#FF"));
    assert!(!is("s := 5; w := SINT_TO_WORD(s);", "w <> 5"));
}

#[test]
fn numbers_with_a_sign_meet_those_without_as_numbers_or_by_their_bits() {
    let is = |body: &str, then: &str| {
        let variables = "x, y : DINT; u : UDINT; d : DWORD; i : INT; n : UINT; s : SINT;";
        may(variables, body, then)
    };
    assert!(is("x := -1; u := 1;", "x > u") && is("x := -1; u := 1;", "x < u"));
    assert!(is("x := -1; d := 16#FFFFFFFF;", "x = d"));
    assert!(is("x := -1;", "x = 16#FFFFFFFF"));
    assert!(!is("x := -1; u := 5;", "x = u"), "no bits of these are the same");
    assert!(!is("x := 3; u := 5;", "x >= u"));
    assert!(is("i := -1; n := 3; x := MAX(i, n);", "x <> 3"));
    assert!(!is("i := 2; n := 3; x := MAX(i, n);", "x <> 3"));
    assert!(is("i := -4; n := 2; x := i / n;", "x <> -2"));
    assert!(!is("i := 4; n := 2; x := i / n;", "x <> 2"));
    assert!(is("i := -1; n := 0; x := i + n;", "x = 65535"));
    assert!(!is("i := -1; n := 8; i := i + n;", "i <> 7"), "all agree in its own bits");
    assert!(!is("i := 1; n := 8; x := i + n;", "x <> 9"));
    assert!(!is("x := -1; n := 1;", "x > n"), "the longer one holds both");
    assert!(is("s := -1; n := 1;", "s > n"));
}

#[test]
fn counters_count_numbers_with_a_sign_or_without() {
    let is = |body: &str, then: &str| may("c : CTU; w : WORD; x : DINT; i : INT;", body, then);
    let large = "w := 40000; c(CU := a, R := FALSE, PV := w);";
    assert!(is(large, "c.Q") && is(large, "NOT c.Q"));
    assert!(is("c(CU := a, R := FALSE, PV := 5); x := c.CV;", "x > 32767"));
    assert!(!is("c(CU := a, R := FALSE, PV := 5); i := c.CV;", "i < 3 AND i >= 0 AND c.Q"));
    assert!(!is("c(CU := a, R := TRUE, PV := 5);", "c.CV <> 0 OR c.Q"));
}

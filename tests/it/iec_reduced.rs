//! Small IEC 61131-3 programs that were made from random ones whose bound was too low, or that were refused without a reason.

use scanbound::audit::{Failure, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// What the probe behind a condition takes, in microseconds; nothing else takes any time.
const PROBE: u64 = 1000;

/// Whether a condition may hold behind some statements. Panics where the program is refused.
fn may(units: &str, variables: &str, body: &str, condition: &str) -> bool {
    bound(units, variables, body, condition).unwrap_or_else(|faults| panic!("{faults:?}")) >= PROBE
}

fn bound(units: &str, variables: &str, body: &str, condition: &str) -> Result<u64, Vec<String>> {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += &format!("TON,{PROBE},{PROBE}\n@end,0,\n");
    let table =
        Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table;
    let text = format!(
        "{units} PROGRAM main VAR a AT %IX0.0 : BOOL; w AT %IW2 : INT; probe : TON; {variables} END_VAR
         {body} IF {condition} THEN probe(); END_IF END_PROGRAM"
    );
    let inputs = [Input { name: "main.st".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request =
        Request { table: Some(&table), trust: Trust::None, ..Request::new(&inputs, &facts) };
    match audit(&request) {
        Ok(found) => Ok(found.bound.upper.0 / 1_000_000),
        Err(Failure::Input(faults)) => Err(faults.into_iter().map(|fault| fault.message).collect()),
        Err(other) => panic!("{other:?}"),
    }
}

/// It holds in every scan.
fn always(units: &str, variables: &str, body: &str, condition: &str) {
    assert!(!may(units, variables, body, &format!("NOT ({condition})")), "{body}: {condition}");
    assert!(may(units, variables, body, condition), "{body}: never {condition}");
}

#[test]
fn a_loop_downwards_in_larger_steps_ends_before_its_end() {
    let variables = "i, n : INT;";
    for (ends, turns, last, beyond) in [
        ("4 TO 1 BY -2", 2, 2, 0),
        ("4 TO 0 BY -2", 3, 0, -2),
        ("5 TO -5 BY -4", 3, -3, -7),
        ("0 TO 5 BY 2", 3, 4, 6),
    ] {
        let body = format!("n := 0; FOR i := {ends} DO n := n + 1; END_FOR");
        always("", variables, &body, &format!("n = {turns} AND (i = {last} OR i = {beyond})"));
        assert!(may("", variables, &body, &format!("i = {last}")), "{ends}");
        assert!(may("", variables, &body, &format!("i = {beyond}")), "{ends}");
    }
}

#[test]
fn an_instance_can_be_referred_to_though_it_is_handed_variables() {
    let units = "
        INTERFACE I METHOD M : INT END_METHOD END_INTERFACE
        FUNCTION F : INT VAR_IN_OUT c : INT; END_VAR c := c + 1; F := c; END_FUNCTION
        FUNCTION_BLOCK B IMPLEMENTS I
          VAR_IN_OUT io : INT; END_VAR VAR_OUTPUT n : INT; END_VAR
          io := io + 1;
          METHOD M : INT M := F(c := n); END_METHOD
        END_FUNCTION_BLOCK";
    let variables = "o, t : B; i : I; p : POINTER TO B; x, y : INT;";
    let body = "x := 0; o.n := 4; t.n := 7; IF a THEN i := o; ELSE i := t; END_IF y := i.M(); o(io := x); p := ADR(t); p^(io := x);";
    always(units, variables, body, "x = 2 AND (a = (y = 5)) AND (a <> (y = 8))");
    // What the last call handed over is meant.
    for body in ["p := ADR(o); p^.io := 3;", "p := ADR(o); x := p^.io;"] {
        assert!(bound(units, variables, body, "a").is_err(), "{body}");
    }
}

#[test]
fn a_bit_of_an_element_is_that_of_the_element_that_is_meant() {
    let variables = "f : ARRAY[-1..1] OF WORD; g : ARRAY[1..2] OF S; n : INT; x : BOOL; d : ARRAY[0..1, 0..1] OF WORD;";
    let units = "TYPE S : STRUCT b : BYTE; END_STRUCT; END_TYPE";
    let body = "f[-1] := 0; f[0] := 0; f[1] := 0; n := LIMIT(-1, w, 1); f[n].3 := TRUE;";
    let one = "(n = -1) = (f[-1] = 8) AND (n = 0) = (f[0] = 8) AND (n = 1) = (f[1] = 8)";
    always(units, variables, body, one);
    for n in -1..=1 {
        assert!(may(units, variables, body, &format!("f[{n}] = 8")), "{n}");
    }
    let body = "f[-1] := 4; f[0] := 0; f[1] := 6; n := LIMIT(-1, w, 1); x := f[n].2;";
    always(units, variables, body, "x = (n <> 0)");
    let body = "g[1].b := 1; g[2].b := 2; n := SEL(a, 1, 2); x := g[n].b.0; g[n].b.7 := NOT x;";
    assert!(
        may(units, variables, body, "g[2].b = 130") && may(units, variables, body, "g[2].b = 2")
    );
    // It is not followed which element of a table is meant.
    assert!(bound(units, variables, "n := SEL(a, 0, 1); x := d[n, 0].3;", "x").is_err());
}

#[test]
fn arguments_may_be_worked_out_though_the_call_is_not_enabled() {
    let units = "
        FUNCTION F : INT VAR_IN_OUT c : INT; END_VAR c := c + 1; F := c; END_FUNCTION
        FUNCTION G : INT VAR_INPUT n : INT; END_VAR G := n; END_FUNCTION";
    for call in ["G(EN := a, n := F(c := x))", "ADD(EN := a, IN1 := F(c := x), IN2 := 1)"] {
        let body = format!("x := 0; y := {call};");
        let may = |condition: &str| may(units, "x, y : INT;", &body, condition);
        // Controllers that hand EN over with the other arguments do, others jump over all of them.
        assert!(may("NOT a AND x = 1") && may("NOT a AND x = 0"), "{call}");
        assert!(!may("a AND x <> 1"), "{call}");
    }
}

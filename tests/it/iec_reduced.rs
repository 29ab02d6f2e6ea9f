//! Small IEC 61131-3 programs that were made from random ones whose bound was too low, or that were refused without a
//! reason.

use common::iec::probe::{self, PROBE, audited};
use scanbound::passes::values::Trust;

/// Whether a condition may hold behind some statements. Panics where the program is refused.
fn may(units: &str, variables: &str, body: &str, condition: &str) -> bool {
    bound(units, variables, body, condition).unwrap_or_else(|fault| panic!("{fault}")) >= PROBE
}

fn bound(units: &str, variables: &str, body: &str, condition: &str) -> Result<u64, String> {
    let text = format!(
        "{units} PROGRAM main VAR a AT %IX0.0 : BOOL; w AT %IW2 : INT; probe : TON; {variables} END_VAR
         {body} IF {condition} THEN probe(); END_IF END_PROGRAM"
    );
    let rows = format!("TON,{PROBE},{PROBE}\n");
    let found = audited(&[("main.st", &text)], &rows, Trust::None)?;
    match found.unbounded.is_empty() {
        true => Ok(probe::bound(&found)),
        false => Err("a loop without an end".to_owned()),
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
    always(units, variables, body, "g[1].b = 1 AND (a = (g[2].b = 130)) AND (a <> (g[2].b = 2))");
    let body = "d[0, 0] := 0; d[0, 1] := 8; d[1, 0] := 8; d[1, 1] := 0; n := SEL(a, 0, 1); x := d[n, n].3 OR NOT d[1 - n, n].3;";
    always(units, variables, body, "NOT x");
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

#[test]
fn the_instance_of_a_table_is_called_that_its_indices_mean() {
    let units = "FUNCTION_BLOCK B VAR_INPUT n : INT; END_VAR VAR c : INT; END_VAR c := c + n;
        METHOD M : INT M := c; END_METHOD METHOD A c := c + 10; END_METHOD END_FUNCTION_BLOCK";
    let variables = "f : ARRAY[0..1, 1..3] OF B; i, j, y : INT; t : ARRAY[0..1, 0..1] OF R_TRIG;";
    let clear = "FOR i := 0 TO 1 DO FOR j := 1 TO 3 DO f[i, j].c := 0; END_FOR END_FOR i := SEL(a, 0, 1); j := LIMIT(1, w, 3);";
    let sum = "f[0, 1].c + f[0, 2].c + f[0, 3].c + f[1, 1].c + f[1, 2].c + f[1, 3].c";
    let body = format!("{clear} f[i, j](n := 5); f[i, 2].A(); f[1, j](n := 1); y := f[i, j].M();");
    always(
        units,
        variables,
        &body,
        &format!("{sum} = 16 AND (y = 6 OR y = 5 OR y = 15 OR y = 16)"),
    );
    always(units, variables, &body, "(a AND w >= 3) = (f[1, 3].c = 6)");
    always(units, variables, &body, "(NOT a AND w = 2) = (f[0, 2].c = 15)");
    let body =
        "t[0, 0](CLK := FALSE); t[0, 1](CLK := FALSE); i := SEL(a, 0, 1); t[0, i](CLK := TRUE);";
    always(units, variables, body, "t[0, 1].Q = a AND t[0, 0].Q <> a");
    let wide = "f : ARRAY[0..9, 0..9] OF B; i, j : INT;";
    assert!(bound(units, wide, "f[i, j](n := 5);", "a").is_err());
}

#[test]
fn a_turn_that_continues_counts_if_it_comes_to_the_count_before() {
    for (body, ends) in [
        (
            "i := 0; WHILE i < 10 DO i := i + 1; IF i = 3 THEN CONTINUE; END_IF n := n + 1; END_WHILE",
            "i = 10 AND n = 9",
        ),
        (
            "i := 0; REPEAT i := i + 1; IF i = 3 THEN CONTINUE; END_IF n := n + 1; UNTIL i >= 10 END_REPEAT",
            "i = 10 AND n = 9",
        ),
        // That of an inner loop is none of the outer one's.
        (
            "i := 0; WHILE i < 3 DO FOR k := 1 TO 3 DO IF k = 2 THEN CONTINUE; END_IF n := n + 1; END_FOR i := i + 1; END_WHILE",
            "i = 3 AND n = 6",
        ),
    ] {
        always("", "i, k, n : INT;", &format!("n := 0; {body}"), ends);
    }
    let before = "WHILE i < 10 DO IF a THEN CONTINUE; END_IF i := i + 1; END_WHILE";
    assert!(bound("", "i : INT;", before, "a").is_err());
}

#[test]
fn a_first_turn_without_a_test_may_leave_the_type() {
    for (of, first, turn, until) in [
        ("INT", "32766", "k + 2", "k >= 5"),
        ("SINT", "127", "k + 1", "k > -100"),
        ("UINT", "0", "k - 1", "k <= 5"),
        ("DINT", "-2147483647", "k - 3", "k < -9"),
        ("SINT", "INT_TO_SINT(w)", "k + 2", "k >= 5"),
    ] {
        let body = format!("k := {first}; REPEAT k := {turn}; UNTIL {until} END_REPEAT");
        let fault = bound("", &format!("k : {of};"), &body, "a").expect_err(&body);
        assert!(fault.contains("without an end"), "{body}: {fault:?}");
    }
    // Beyond the end, but within the type: one turn.
    let body = "n := 0; k := 32766; REPEAT k := k + 1; n := n + 1; UNTIL k >= 5 END_REPEAT";
    always("", "k, n : INT;", body, "n = 1 AND k = 32767");
}

#[test]
fn a_block_has_the_variables_that_its_base_has_for_all_instances() {
    let units = "VAR_GLOBAL s : INT := 7; END_VAR
        FUNCTION_BLOCK A VAR_STAT s : INT; END_VAR s := s + 1; END_FUNCTION_BLOCK
        FUNCTION_BLOCK B EXTENDS A VAR_OUTPUT n : INT; END_VAR s := s + 10; n := s;
            METHOD Clear s := 0; END_METHOD END_FUNCTION_BLOCK
        FUNCTION_BLOCK C EXTENDS B METHOD M : INT M := s; END_METHOD END_FUNCTION_BLOCK";
    let body = "b.Clear(); b(); a0(); a1();";
    always(units, "a0, a1 : A; b : B; c : C; x : INT;", body, "b.n = 10 AND c.M() = 12");
}

#[test]
fn a_value_of_two_enumerations_is_told_with_both() {
    let units = "TYPE c1 : (red, green); c2 : (blue, red); END_TYPE";
    let fault = bound(units, "v : c1; u : c2;", "v := red;", "a").expect_err("not said");
    assert!(fault.contains("red is a value of the enumerations c1 and c2"), "{fault}");
    always(units, "v : c1; u : c2;", "v := c1#red; u := c2#red;", "v <> u");
}

#[test]
fn words_of_8_bits_start_within_them() {
    let units = "TYPE S : STRUCT b : BYTE; END_STRUCT; END_TYPE
        FUNCTION_BLOCK B VAR_INPUT y : SINT; END_VAR VAR_OUTPUT t : ARRAY[0..1] OF USINT; END_VAR END_FUNCTION_BLOCK";
    let variables = "r : ARRAY[0..2] OF SINT; t : ARRAY[0..1, 2..3] OF BYTE; s : ARRAY[0..1] OF S; f : B; g : ARRAY[1..2] OF B; i : INT;";
    for never in [
        "r[1] > SINT#127",
        "BYTE_TO_INT(t[1, 2]) > 255",
        "BYTE_TO_INT(s[1].b) > 255",
        "f.y < SINT#-128",
        "g[2].t[1] > USINT#255",
        "r[i] > SINT#127",
    ] {
        let body = "i := LIMIT(0, w, 2);";
        assert!(!may(units, variables, body, never), "{never}");
        assert!(may(units, variables, body, &format!("NOT ({never})")), "{never}");
    }
}

#[test]
fn what_the_condition_of_a_loop_calls_may_set_its_count_back() {
    let units = "FUNCTION G : BOOL VAR_IN_OUT x : INT; END_VAR x := 0; G := TRUE; END_FUNCTION
        FUNCTION H : BOOL VAR_INPUT x : INT; END_VAR H := x > 9; END_FUNCTION
        FUNCTION_BLOCK B VAR k : INT; END_VAR METHOD M : BOOL k := 0; M := TRUE; END_METHOD
        METHOD Run k := 0; WHILE k < 5 AND M() DO k := k + 1; END_WHILE END_METHOD END_FUNCTION_BLOCK";
    for body in [
        "k := 0; WHILE k < 5 AND G(k) DO k := k + 1; END_WHILE",
        "k := 0; WHILE G(k) AND_THEN k < 5 DO k := k + 1; END_WHILE",
        "k := 0; REPEAT k := k + 1; UNTIL k >= 5 OR NOT G(k) END_REPEAT",
        "k := 0; WHILE k < n AND G(n) DO k := k + 1; END_WHILE",
        "b.Run();",
    ] {
        assert!(bound(units, "k, n : INT; b : B;", body, "a").is_err(), "{body}");
    }
    let body = "k := 0; REPEAT k := k + 1; UNTIL k >= 5 OR H(k) END_REPEAT";
    always(units, "k : INT;", body, "k = 5");
}

#[test]
fn en_may_keep_its_value_in_a_call_that_leaves_it_out() {
    let units = "FUNCTION_BLOCK B VAR_OUTPUT n : INT; END_VAR n := n + 1; END_FUNCTION_BLOCK";
    let body = "f.n := 0; f(EN := a); f();";
    for (condition, holds) in [
        ("NOT a AND f.n = 0", true),
        ("NOT a AND f.n = 1", true),
        ("a AND f.n <> 2", false),
        ("f.n > 2", false),
    ] {
        assert_eq!(may(units, "f, g : B;", body, condition), holds, "{condition}");
    }
    // In the scan before.
    assert!(may(units, "f : B;", "f.n := 0; f(); IF a THEN f(EN := FALSE); END_IF", "f.n = 0"));
    // What is passed in and out is called by another name.
    let through =
        format!("{units} FUNCTION_BLOCK C VAR_IN_OUT x : B; END_VAR x(); END_FUNCTION_BLOCK");
    let body = "f.n := 0; f(EN := a); c(x := f);";
    assert!(may(&through, "f : B; c : C;", body, "NOT a AND f.n = 0"));
    let gives = through.replace("x();", "x(EN := FALSE);");
    assert!(may(&gives, "f : B; c : C;", "c(x := f); f.n := 0; f();", "f.n = 0"));
    // Each instance has its own.
    assert!(!may(units, "f, g : B;", "g.n := 0; f(EN := a); g();", "g.n <> 1"));
}

#[test]
fn eno_may_say_that_a_function_has_failed() {
    let ok = |call: &str, condition: &str| {
        let body = format!("ok := FALSE; y := {call};");
        may("", "ok : BOOL; y : INT; s : SINT; d : DINT; x : REAL;", &body, condition)
    };
    for call in [
        "DIV(EN := TRUE, IN1 := 7, IN2 := w, ENO => ok)",
        "MUX(EN := TRUE, K := w, IN0 := 1, IN1 := 2, ENO => ok)",
        "DINT_TO_INT(EN := TRUE, IN := d, ENO => ok)",
        "ADD(EN := TRUE, IN1 := w, IN2 := 1, ENO => ok)",
    ] {
        assert!(ok(call, "ok") && ok(call, "NOT ok"), "{call}");
    }
    for call in [
        "DIV(EN := TRUE, IN1 := w, IN2 := 7, ENO => ok)",
        "MAX(EN := TRUE, IN1 := w, IN2 := 7, ENO => ok)",
        "SINT_TO_INT(EN := TRUE, IN := s, ENO => ok)",
    ] {
        assert!(!ok(call, "NOT ok"), "{call}");
    }
    assert!(!ok("ADD(EN := TRUE, IN1 := w, IN2 := 1, ENO => ok)", "w < 100 AND NOT ok"));
}

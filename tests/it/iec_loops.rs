//! How often loops of IEC 61131-3 programs are repeated at most.

use crate::iec_exact::{audited, costing, costing_by, logarithms, micros};
use scanbound::audit::verdict::{Check, Margin, Verdict};
use scanbound::base::code::Code;
use scanbound::base::time::Picos;
use scanbound::passes::values::Trust;

#[test]
fn loops_that_end_at_one_value_have_a_count() {
    let of = |body: &str| {
        let text = format!(
            "PROGRAM main VAR x : BOOL; n, m : INT; u : UINT; s : SINT; END_VAR {body} END_PROGRAM"
        );
        let found = audited("main.st", &text).map_err(|faults| faults[0])?;
        Ok::<_, Code>(found.unbounded.is_empty().then(|| micros(&found)))
    };
    // A store in each turn, one that counts, and those before.
    assert_eq!(of("n := 4; WHILE n <> 0 DO x := TRUE; n := n - 1; END_WHILE"), Ok(Some(9)));
    assert_eq!(of("n := 4; REPEAT x := TRUE; n := n - 1; UNTIL n = 0 END_REPEAT"), Ok(Some(9)));
    assert_eq!(of("u := u MOD 4; WHILE u <> 0 DO u := u - 1; END_WHILE"), Ok(Some(4)));
    assert_eq!(of("n := 1; WHILE n <> 6 DO n := n + 1; x := TRUE; END_WHILE"), Ok(Some(11)));
    // From beyond, or from anywhere, it goes through all values.
    assert_eq!(of("n := -1; WHILE n <> 0 DO n := n - 1; END_WHILE"), Ok(None));
    assert_eq!(of("n := 0; REPEAT n := n - 1; UNTIL n = 0 END_REPEAT"), Ok(None));
    assert_eq!(of("WHILE n <> m DO n := n + 1; END_WHILE"), Ok(None));
    // Steps of more than one end where the last one still fits the variable.
    let of_word = |first: u32| of(&format!("u := {first}; WHILE u > 0 DO u := u - 3; END_WHILE"));
    assert_eq!((of_word(9), of_word(10)), (Ok(Some(4)), Ok(None)));
    assert_eq!(of("s := 0; WHILE s < 100 DO s := s + 50; END_WHILE"), Ok(Some(3)));
    assert_eq!(of("s := 1; WHILE s < 100 DO s := s + 50; END_WHILE"), Ok(Some(3)));
    assert_eq!(of("s := -1; WHILE s < 100 DO s := s + 50; END_WHILE"), Ok(None));
    let most = "s := LIMIT(10, s, 30); WHILE s >= -90 DO s := s - 37; END_WHILE";
    assert_eq!(of(most), Ok(Some(5)));
    // An unsigned variable never goes beyond an end that some controllers take for a very large number.
    assert_eq!(of("m := n MOD 3; FOR u := 0 TO m - 1 DO x := TRUE; END_FOR"), Ok(None));
    assert_eq!(of("m := n MOD 3; u := 0; WHILE u <= m - 1 DO u := u + 1; END_WHILE"), Ok(None));
    assert_eq!(
        of("FOR s := 0 TO LIMIT(1, n, 4) - 1 DO x := TRUE; END_FOR").map(|us| us.is_some()),
        Ok(true)
    );
    // Constants are of a type.
    assert_eq!(of("FOR n := 0 TO UINT#3 - UINT#5 DO x := TRUE; END_FOR"), Ok(None));
    // One without a known end stays so within another loop that is not followed turn by turn.
    let inner = "u := 3; WHILE u <> 65534 DO u := u + 1; END_WHILE";
    assert_eq!(of(inner), Ok(None));
    assert_eq!(of(&format!("FOR m := 0 TO 3 DO {inner} END_FOR")), Ok(None));
    assert_eq!(of(&format!("m := 0; WHILE m < 4 DO {inner} m := m + 1; END_WHILE")), Ok(None));
    // A step of more than one may never meet it, and few values are gone through.
    assert_eq!(of("n := 4; WHILE n <> 0 DO n := n - 2; END_WHILE"), Err(Code::LoopCount));
    assert_eq!(of("s := 4; WHILE s <> 0 DO s := s - 1; END_WHILE"), Err(Code::LoopCount));
}

#[test]
fn a_loop_without_end_is_reached_with_what_real_runs_showed() {
    let text = "PROGRAM main VAR n AT %IW2 : INT; i, k, m, o : INT; b : BOOL; \
        a : ARRAY[0..1, 1..2] OF INT; END_VAR k := 0; \
        WHILE k < LIMIT(0, a[1, LIMIT(1, m, 2)], 4) AND b DO k := k + 1; \
        FOR i := 1 TO MAX(n + 1, 3) DO ; END_FOR END_WHILE END_PROGRAM";
    let found = audited("main.st", text).expect("an audit");
    assert_eq!(found.unbounded.len(), 1);
}

#[test]
fn a_loop_that_nothing_is_known_to_end_refutes_no_limit() {
    let text = "PROGRAM main VAR u : UINT; END_VAR u := 10; WHILE u > 0 DO u := u - 3; END_WHILE END_PROGRAM";
    let found = audited("main.st", text).expect("an audit");
    assert!(found.unbounded.len() == 1 && !found.is_endless());
    let check = Check::new(&found, Picos(u64::MAX), Margin::default());
    assert!(matches!(check.verdict, Verdict::Undecided(_)), "{:?}", check.verdict);
}

#[test]
fn ends_of_loops_that_the_program_limits_bound_them() {
    let of = |body: &str| {
        let text = format!(
            "PROGRAM main VAR_INPUT n, m : INT; END_VAR VAR i, k : INT; d : DINT; u : UINT; r : REAL;
            s : STRING(20); END_VAR {body} END_PROGRAM"
        );
        logarithms(&text).unwrap_or_else(|faults| panic!("{body}: {faults:?}"))
    };
    let turns = |from_to: &str| of(&format!("FOR i := {from_to} DO r := LN(r); END_FOR"));
    assert_eq!(turns("1 TO LIMIT(0, m, 20)"), (20, 0));
    assert_eq!(turns("1 TO LIMIT(-5, m, 20)"), (20, 0));
    assert_eq!(turns("1 TO MIN(m, 20)"), (20, 0));
    assert_eq!(turns("MAX(m, 1) TO 20"), (20, 0));
    assert_eq!(turns("1 TO LEN(s)"), (20, 0));
    assert_eq!(turns("1 TO FIND(s, 'a')"), (20, 0));
    let after = |before: &str, from_to: &str| {
        of(&format!("{before} FOR i := {from_to} DO r := LN(r); END_FOR"))
    };
    assert_eq!(after("k := n; IF k > 20 THEN k := 20; END_IF", "1 TO k"), (20, 0));
    assert_eq!(after("k := n; IF k > 20 OR k < 0 THEN k := 7; END_IF", "0 TO k"), (21, 0));
    assert_eq!(after("d := LIMIT(0, n, 20);", "0 TO d BY 2"), (11, 0));
    assert_eq!(after("d := n; IF d > 20 THEN d := 20; END_IF", "3 TO d BY 4"), (5, 0));
    assert_eq!(after("u := LIMIT(UINT#5, INT_TO_UINT(n), UINT#20);", "1 TO u"), (20, 0));
    assert_eq!(
        of("IF n >= 0 AND n <= 20 THEN FOR i := n TO 20 DO r := LN(r); END_FOR END_IF"),
        (21, 0)
    );
    assert_eq!(of("i := 0; WHILE i < MIN(m, 9) DO r := LN(r); i := i + 1; END_WHILE"), (9, 0));
    // Compilers differ in the bits that they keep of the sum, and the limits hold for all of them.
    assert_eq!(turns("1 TO LIMIT(0, m + 1, 20)"), (20, 0));
    // Within a loop of too many turns to follow, too.
    let inner = "FOR i := 2 TO LIMIT(0, m / 5, 20) DO r := LN(r); END_FOR";
    assert_eq!(of(&format!("FOR k := 1 TO 30000 DO {inner} END_FOR")), (30_000 * 19, 0));
    // Nothing limits these.
    assert_eq!(turns("n TO 20").1, 1);
    assert!(turns("1 TO MAX(m, 20)").0 > 30_000);
}

#[test]
fn what_leads_to_the_end_of_a_loop_is_paid_for_at_each_turn() {
    let of = |end: &str| {
        let text = format!(
            "PROGRAM main VAR n, m, i : INT; END_VAR n := 2; m := 5; FOR i := 1 TO {end} DO ; END_FOR END_PROGRAM"
        );
        costing("MUL,1,1\n", &text).expect("a bound")
    };
    assert_eq!(of("n * m"), (11, 0));
    assert_eq!(of("3 * 4"), (0, 0));
}

#[test]
fn what_keeps_its_value_or_is_only_limited_is_set_by_others() {
    let unit = |called: &str, body: &str| {
        format!(
            "TYPE Recipe : STRUCT n : INT; en : BOOL; d : DINT; END_STRUCT; END_TYPE
             FUNCTION_BLOCK Steps VAR_IN_OUT r : Recipe; END_VAR
             r.d := r.d + 1; IF r.d > 9 THEN r.d := 0; END_IF END_FUNCTION_BLOCK
             FUNCTION_BLOCK Run VAR_INPUT b : BOOL; END_VAR VAR_IN_OUT c : INT; END_VAR
             VAR i : INT; x : REAL; END_VAR {called} END_FUNCTION_BLOCK
             FUNCTION Limited : INT VAR_INPUT v : INT; END_VAR
             Limited := LIMIT(1, v, 20);
             END_FUNCTION
             PROGRAM main VAR_INPUT b : BOOL; END_VAR
             VAR n, i : INT; d : DINT; w : WORD; x : REAL; f : Run; r : Recipe;
             s : Steps; END_VAR
             {body} END_PROGRAM"
        )
    };
    let turns = |called: &str, body: &str| {
        let text = unit(called, body);
        let found = costing("LN,1,1\n", &text).unwrap_or_else(|codes| panic!("{text} {codes:?}"));
        (found.1 == 0).then_some(found.0)
    };
    let counts = "FOR i := 1 TO c DO x := LN(x); END_FOR";
    for called in [counts, &format!("IF b THEN c := 3; END_IF {counts}")] {
        for body in ["f(b := b, c := n);", "f(b := b, c := r.n);"] {
            assert_eq!(turns(called, body), None, "{called} {body}");
        }
    }
    assert_eq!(turns(&format!("c := 3; {counts}"), "f(c := n);"), Some(3));
    assert_eq!(turns("c := 3;", "FOR i := 1 TO n DO x := LN(x); END_FOR f(c := n);"), Some(3));
    // What comes back to its value, or only counts down to a limit.
    for body in [
        "n := n + 1; n := n - 1; IF n < 1 THEN n := 1; END_IF",
        "i := n + 1; n := i - 1; IF n < 1 THEN n := 1; END_IF",
        "n := n - 1; IF n < 1 THEN n := 1; END_IF",
        "n := MAX(n - 1, 1);",
    ] {
        assert_eq!(
            turns("", &format!("{body} FOR i := 1 TO n DO x := LN(x); END_FOR")),
            None,
            "{body}"
        );
    }
    for (body, most) in [
        ("n := n + 1; IF n > 9 THEN n := 1; END_IF", 9),
        ("n := n - 1; IF n < 1 THEN n := 9; END_IF", 9),
        (
            "w := SHL(INT_TO_WORD(n), 4); n := WORD_TO_INT(SHR(w, 4)); IF n < 1 THEN n := 1; END_IF",
            4095,
        ),
    ] {
        let body = format!("{body} FOR i := 1 TO n DO x := LN(x); END_FOR");
        assert_eq!(turns("", &body), Some(most), "{body}");
    }
    let input = |body: &str| {
        format!(
            "PROGRAM main VAR_INPUT n : INT; END_VAR VAR i : INT; x : REAL; END_VAR {body} END_PROGRAM"
        )
    };
    let read = input("FOR i := 1 TO n DO x := LN(x); END_FOR n := 5;");
    assert_eq!(costing("LN,1,1\n", &read).map(|found| found.1), Ok(1));
    let limited = ["LIMIT(1, n, 20)", "MIN(n, 20)", "Limited(n)"];
    for value in limited {
        let body = format!("n := {value}; FOR i := 1 TO n DO x := LN(x); END_FOR");
        assert_eq!(turns("", &body), Some(20), "{value}");
    }
    // What is only cleared, and words of which only bits are written.
    let loop_to_n = "FOR i := 1 TO n DO x := LN(x); END_FOR";
    assert_eq!(turns("", &format!("{loop_to_n} n := 0;")), None);
    assert_eq!(turns("", &format!("{loop_to_n} n := 3; n := 0;")), Some(0));
    let bits = format!("w.8 := b; n := WORD_TO_INT(w AND 16#000F); {loop_to_n}");
    assert_eq!(turns("", &bits), Some(15));
    let cleared = format!("n := WORD_TO_INT(w AND 16#000F); {loop_to_n} w := 0; w.15 := b;");
    assert_eq!(turns("", &cleared), Some(15));
    let down = "FOR i := 1 TO MIN(n, 9) DO x := LN(x); END_FOR n := LIMIT(0, n - 1, 20);";
    assert_eq!(turns("", down), Some(9));
    for down in ["n := n - 1; IF n < 0 THEN n := 0; END_IF", "n := n - 1; n := MAX(n, 0);"] {
        let body = format!("FOR i := 1 TO MIN(n, 9) DO x := LN(x); END_FOR {down}");
        assert_eq!(turns("", &body), Some(9), "{down}");
    }
    for (step, most) in [("n - 1", 99), ("n / 2", 99), ("n MOD 3", 99), ("n * 3", 10)] {
        let body =
            format!("FOR i := 1 TO MIN(n, 99) DO x := LN(x); END_FOR n := LIMIT(1, {step}, 10);");
        assert_eq!(turns("", &body), Some(most), "{step}");
    }
    // A sequence that only others start.
    for next in [
        "CASE n OF 3: n := 1; 1: n := 2; ELSE n := 0; END_CASE",
        "IF n = 3 THEN n := 1; ELSE n := 0; END_IF",
    ] {
        let body = format!("FOR i := 1 TO MIN(n, 9) DO x := LN(x); END_FOR {next}");
        assert_eq!(turns("", &body), Some(9), "{next}");
    }
    // What the program counts, or writes bit by bit, is its own.
    let counted = "s(r := r); FOR i := 1 TO DINT_TO_INT(r.d) DO x := LN(x); END_FOR";
    assert_eq!(turns("", counted), Some(9));
    let value = |bit: u8| if bit < 3 { "b" } else { "FALSE" };
    let bits: String = (0..16).map(|bit| format!("w.{bit} := {};", value(bit))).collect();
    let bits = format!("{bits} n := WORD_TO_INT(w); {loop_to_n}");
    assert_eq!(turns("", &bits), Some(7));
    let mask = format!("w := w OR 16#0100; n := WORD_TO_INT(w AND 16#000F); {loop_to_n}");
    assert_eq!(turns("", &mask), Some(15));
    // With all trusted that the program writes, too.
    let all = |body: &str| costing_by(Trust::All, "LN,1,1\n", &unit("", body));
    let compared = "IF n = 5 THEN x := LN(x); END_IF";
    for body in [
        "n := 0;",
        "n := MAX(n - 1, 0);",
        "n := LIMIT(0, n, 20);",
        "n := LIMIT(1, n, 20);",
        "n := MAX(n, 1);",
        "n := SEL(n < 1, n, 1);",
        "n := UDINT_TO_INT(LIMIT(1, INT_TO_UDINT(n), 20));",
    ] {
        assert_eq!(all(&format!("{compared} {body}")), Ok((1, 0)), "{body}");
    }
    let counted = format!("{compared} n := n + 1; IF n > 3 THEN n := 0; END_IF");
    assert_eq!(all(&counted), Ok((0, 0)));
    let bits = "IF (w AND 16#00FF) = 16#0080 THEN x := LN(x); END_IF w.15 := FALSE; w.14 := b;";
    assert_eq!(all(bits), Ok((1, 0)));
    let down = "IF d = 70000 THEN x := LN(x); END_IF d := d - 1; IF d < 0 THEN d := 0; END_IF";
    assert_eq!(all(down), Ok((1, 0)));
    let long = "IF d = 70000 THEN x := LN(x); END_IF d := 5;";
    assert_eq!(all(long), Ok((0, 0)));
    let compared = unit("IF c = 2 AND b THEN x := LN(x); END_IF", "f(b := b, c := n);");
    assert_eq!(costing_by(Trust::All, "LN,1,1\n", &compared), Ok((1, 0)));
    let cleared = unit("IF c = 2 THEN c := 0; x := LN(x); END_IF", "f(c := n);");
    assert_eq!(costing_by(Trust::All, "LN,1,1\n", &cleared), Ok((1, 0)));
    let kept = unit("IF c = 2 THEN x := LN(x); END_IF c := 1;", "f(c := n);");
    assert_eq!(costing_by(Trust::All, "LN,1,1\n", &kept), Ok((0, 0)));
}

#[test]
fn an_end_or_a_step_beyond_the_type_of_a_loop_is_refused() {
    let of = |variables: &str, head: &str| {
        let text = format!(
            "PROGRAM main VAR {variables} x : REAL; END_VAR FOR i := {head} DO x := LN(x); END_FOR END_PROGRAM"
        );
        costing("LN,1,1\n", &text).map(|found| found.0).map_err(|codes| codes[0])
    };
    for head in ["10 TO 1 BY 16#FFFF", "1 TO 10 BY -40000", "1 TO -(200 * 200) / 1000"] {
        assert_eq!(of("i : INT;", head), Err(Code::LoopCount), "{head}");
    }
    assert_eq!(of("i : DINT;", "10 TO 1 BY -3"), Ok(4));
    assert_eq!(of("i : USINT;", "10 TO 5 BY -4"), Ok(2));
}

#[test]
fn a_reference_outside_of_its_array_may_lead_anywhere() {
    let text = "PROGRAM main VAR p : ARRAY[0..1] OF POINTER TO INT; a, b, k : INT; x : REAL; END_VAR \
        p[0] := ADR(a); p[1] := ADR(b); a := 1; b := 1; k := 2; IF p[k]^ = 9 THEN x := LN(x); END_IF END_PROGRAM";
    assert_eq!(costing("LN,1,1\n", text), Ok((1, 0)));
}

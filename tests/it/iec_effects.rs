//! What calls read and change out of sight: in the index of a called instance, in EN and ENO, in the flags of steps,
//! and behind references.

use common::audited::{audited, table};
use scanbound::base::facts::Facts;

const UNITS: &str = "
    VAR_GLOBAL n : INT; g : INT; t1, t2 : T; END_VAR
    TYPE T : STRUCT a, b : INT; END_STRUCT END_TYPE
    TYPE U : STRUCT t : T; z : INT; END_STRUCT END_TYPE
    FUNCTION F : INT VAR_EXTERNAL n : INT; END_VAR n := n - 1; F := 1; END_FUNCTION
    FUNCTION G : INT VAR_EXTERNAL n : INT; END_VAR n := n + 1; G := 7; END_FUNCTION
    FUNCTION P : INT VAR_EXTERNAL n : INT; END_VAR P := n; END_FUNCTION
    FUNCTION Is : BOOL VAR_EXTERNAL g : INT; END_VAR g := 5; Is := TRUE; END_FUNCTION
    FUNCTION Gives : INT VAR_INPUT a : INT; END_VAR VAR_OUTPUT o : INT; END_VAR o := a; END_FUNCTION
    FUNCTION_BLOCK Both VAR_INPUT a : INT; END_VAR VAR_IN_OUT io : INT; END_VAR io := io + a; END_FUNCTION_BLOCK
    FUNCTION_BLOCK K VAR_INPUT a : INT; END_VAR VAR_OUTPUT o : INT; END_VAR VAR q : INT; END_VAR
        METHOD M : INT VAR_INPUT k : INT; END_VAR o := k; M := 3; END_METHOD
        o := a;
        ACTION act: q := q + 1; END_ACTION END_FUNCTION_BLOCK
    FUNCTION_BLOCK Moves VAR_INPUT a : INT; END_VAR VAR_OUTPUT o : INT; END_VAR VAR_EXTERNAL n : INT; END_VAR
        o := a; n := 1; END_FUNCTION_BLOCK
    FUNCTION_BLOCK Inner VAR_INPUT v : INT; END_VAR END_FUNCTION_BLOCK
    FUNCTION_BLOCK O VAR_INPUT i : Inner; p : BOOL; w : INT; END_VAR END_FUNCTION_BLOCK
    FUNCTION_BLOCK Parts VAR_OUTPUT p : T; q : INT; b, c : BOOL; END_VAR
        p.b := 1; q := 2; b := TRUE; c := FALSE; END_FUNCTION_BLOCK
    FUNCTION_BLOCK Chart VAR_INPUT go : BOOL; END_VAR
        INITIAL_STEP S0: END_STEP
        TRANSITION FROM S0 TO S1 := go; END_TRANSITION
        STEP S1: END_STEP
        TRANSITION FROM S1 TO S0 := NOT go; END_TRANSITION END_FUNCTION_BLOCK";

/// Arrays of several dimensions may not stand beside references.
const REFERENCES: &str = "
    TYPE R : STRUCT p1 : REF_TO T; p2 : REF_TO U; END_STRUCT END_TYPE
    VAR_GLOBAL chain : R; END_VAR
    FUNCTION Turn : INT VAR_EXTERNAL chain : R; t2 : T; END_VAR chain.p1 := REF(t2); Turn := 0; END_FUNCTION";

const VARIABLES: &[&str] = &[
    "ks : ARRAY[0..3] OF K",
    "ms : ARRAY[0..1] OF Moves",
    "ts : ARRAY[0..1] OF TON",
    "grid : ARRAY[0..1, 0..1] OF K",
    "refs : ARRAY[0..3] OF REF_TO K",
    "c : ARRAY[0..2] OF INT",
    "bs : ARRAY[0..3] OF BOOL",
    "pi : REF_TO INT",
    "pm : REF_TO Moves",
    "chains : REF_TO R",
    "r : REAL",
    "i : INT",
    "j : INT",
    "v : INT",
    "y : INT",
    "x : BOOL",
    "b : BOOL",
    "q : BOOL",
    "inner : Inner",
    "o : O",
    "both : Both",
    "ctu : CTU",
    "parts : Parts",
    "u : U",
    "s : R",
    "ch : Chart",
    "m AT %MW0 : WORD",
    "l AT %MB1 : BYTE",
];

/// The bound of a program with this body in milliseconds, if only SQRT takes time: 1 ms. Or what it is refused for.
fn bound(body: &str) -> Result<u64, String> {
    let is_named = |declared: &&&str| {
        let name = declared.split_whitespace().next().unwrap_or_default();
        body.split(|c: char| !c.is_alphanumeric()).any(|word| word == name)
    };
    let variables: String =
        VARIABLES.iter().filter(is_named).map(|one| format!("{one}; ")).collect();
    let (references, chain) = match body.contains("REF(") {
        true => (REFERENCES, "chain : R;"),
        false => ("", ""),
    };
    let text = format!(
        "{UNITS} {references} PROGRAM main VAR_EXTERNAL n : INT; g : INT; t1, t2 : T; {chain} END_VAR
         VAR {variables} END_VAR {body} END_PROGRAM"
    );
    bound_of(&text)
}

fn bound_of(text: &str) -> Result<u64, String> {
    let table = table("PROGRAM,0,\nSQRT,1000,\n@end,0,\n");
    let found = audited("iec-text", None, &[("p.st", text)], &table, &Facts::default())?;
    match found.audit.unbounded.is_empty() {
        true => Ok(found.audit.bound.upper.0 / 1_000_000_000),
        false => Err("a loop without an end".to_owned()),
    }
}

/// A body is followed, and nothing in it takes time.
fn accepted(body: &str) {
    assert_eq!(bound(body), Ok(0), "{body}");
}

fn refused(body: &str, why: &str) {
    let told = bound(body).expect_err(body);
    assert!(told.contains(why), "{body}: {told}");
}

const PROBE: &str = "r := SQRT(r);";

#[test]
fn an_index_of_a_called_instance_may_write_what_a_loop_counts() {
    for call in ["ks[F()]();", "ks[F()].act();", "ks[F()].M();", "refs[F()]^();"] {
        let refs = "refs[0] := REF(ks[0]); refs[1] := REF(ks[1]);";
        let body = format!("{refs} n := 0; WHILE n < 10 DO {call} {PROBE} n := n + 1; END_WHILE;");
        refused(&body, "the iteration count of WHILE or REPEAT");
        let body = body.replace("F()", "P() - 1");
        assert!(bound(&body).is_ok_and(|bound| bound == 10), "{body}: {:?}", bound(&body));
    }
    refused(&format!("FOR n := 1 TO 5 DO y := ks[F()].M(k := 1); {PROBE} END_FOR;"), "loop");
    let body = format!("n := 5; y := ks[F()].M(k := 1) + n; IF y = 8 THEN {PROBE} END_IF;");
    assert_eq!(bound(&body), Ok(1));
}

#[test]
fn a_call_that_moves_its_own_instance_is_refused() {
    for body in [
        "n := 0; ks[n](a := G());",
        "n := 0; ks[n].M(k := G());",
        "n := 0; ts[n](IN := G() = 7);",
        "n := 0; ms[n](a := 7, o => v);",
        "n := 0; ks[n](a := 7, o => n);",
        "ks[F()](a := 7);",
        "ks[ks[0].a](a := 1);",
        "y := ks[F()].M(EN := x, k := 1);",
        "grid[n, 1](a := G());",
        "pm := REF(ms[n]); refs[n]^(a := G());",
        "refs[0] := REF(ks[0]); refs[1] := REF(ks[1]); refs[n]^(a := G());",
    ] {
        refused(body, "may change within its call");
    }
    for body in [
        "FOR i := 0 TO 1 DO ts[i](IN := NOT ts[i].Q, PT := T#1s); END_FOR;",
        "FOR i := 0 TO 3 DO ks[i](a := c[i], o => v); END_FOR;",
        "FOR i := 0 TO 1 DO FOR j := 0 TO 1 DO grid[i, j](a := 1, o => v); y := grid[i, j].M(k := v); END_FOR; END_FOR;",
        "n := 0; ms[n]();",
        "ks[1](a := G(), o => n);",
        "n := 0; y := ks[n].M(k := P());",
    ] {
        accepted(body);
    }
}

#[test]
fn en_and_eno_of_functions_are_seen_where_orders_differ() {
    for body in [
        "g := 0; y := ADD(EN := Is(), IN1 := 1, IN2 := 2) + g; IF y = 3",
        "g := 0; y := SEL(Is(), 0, 3) + g; IF y = 3",
        "x := FALSE; y := ADD(EN := TRUE, 1, 2, ENO => x) + SEL(x, 10, 20); IF y = 13",
        "x := FALSE; y := ADD(EN := TRUE, 1, 2, ENO => x) + SEL(x, 10, 20); IF y = 23",
        "x := FALSE; b := FALSE; q := b AND (ADD(EN := TRUE, IN1 := 1, IN2 := 2, ENO => x) = 3); IF NOT x",
        "x := FALSE; b := FALSE; q := b AND (ADD(EN := TRUE, IN1 := 1, IN2 := 2, ENO => x) = 3); IF x",
        "n := 5; y := SEL(REF(c[F()]) = pi, 3, 3) + n; IF y = 8",
    ] {
        assert_eq!(bound(&format!("{body} THEN {PROBE} END_IF;")), Ok(1), "{body}");
    }
    for body in ["ks[0].act(EN := x);", "ks[i].act(ENO => x);"] {
        refused(body, "EN and ENO of an action");
    }
    for body in
        ["o(p := FALSE, w := ADD(EN := o.p, IN1 := 5, IN2 := 5));", "o(EN := o.p, p := TRUE);"]
    {
        refused(body, "is passed by a call that also reads it");
    }
    accepted("o(p := FALSE, w := ADD(EN := x, IN1 := o.w, IN2 := 5));");
}

#[test]
fn an_end_of_a_loop_may_stand_in_en_or_be_the_flag_of_a_step() {
    for (end, body) in [
        ("SEL(ch.S1.X, 2, 10)", "ch(go := TRUE);"),
        ("ADD(EN := b, IN1 := 1, IN2 := 1)", "b := FALSE;"),
        ("SEL(Is(), 1, 2)", ""),
    ] {
        refused(&format!("FOR i := 1 TO {end} DO {body} {PROBE} END_FOR;"), "its own end");
    }
    let body = format!("FOR i := 1 TO SEL(ch.S1.X, 2, 10) DO v := i; {PROBE} END_FOR;");
    assert_eq!(bound(&body), Ok(10));
}

#[test]
fn a_part_of_an_input_is_the_input() {
    refused("o(i := inner, w := o.i.v);", "is passed by a call that also reads it");
    accepted("o(p := TRUE, w := o.i.v);");
}

#[test]
fn outputs_to_parts_are_kept_apart_only_within_one_variable() {
    for body in [
        "s.p2 := REF(u); s.p1 := REF(u.t); parts(p => s.p2^.t, q => s.p1^.b);",
        "parts(b => m.8, c => l.0);",
        "y := ADD(EN := TRUE, IN1 := 1, IN2 := 2, OUT2 => x, ENO => x);",
    ] {
        refused(body, "is given two values by one call");
    }
    for body in [
        "parts(p => u.t, q => u.z);",
        "parts(b => m.8, c => m.9);",
        "parts(b => c[i].0, c => c[j].1);",
        "parts(b => c[0].0, c => y.0);",
    ] {
        accepted(body);
    }
}

#[test]
fn arguments_may_not_move_the_element_that_takes_an_output() {
    for body in [
        "y := Gives(a := G(), o => c[n]);",
        "y := Gives(a := G(), ENO => bs[n]);",
        "y := ADD(EN := TRUE, IN1 := G(), IN2 := 1, ENO => bs[n]);",
        "ts[0](IN := G() = 7, PT := T#0s, Q => bs[n]);",
        "ctu(RESET := TRUE, PV := 0, CV => i, Q => bs[i]);",
        "both(a := G(), io := c[n]);",
        "ks[0](a := 1, o => c[ks[0].a]);",
        "both(a := 1, io := c[F()]);",
    ] {
        refused(body, "may change while the call runs");
    }
    for body in [
        "y := Gives(a := P(), o => c[n]);",
        "y := ADD(EN := TRUE, IN1 := P(), IN2 := 1, ENO => bs[n]);",
        "ctu(RESET := TRUE, PV := 0, CV => i, Q => bs[j]);",
        "both(a := P(), io := c[n]);",
    ] {
        accepted(body);
    }
}

#[test]
fn each_reference_on_a_path_is_read() {
    let begin = "chains := REF(chain); chain.p1 := REF(t1); t1.a := 1; t2.a := 2;";
    for y in [1, 2] {
        let body = format!("{begin} y := Turn() + chains^.p1^.a; IF y = {y} THEN {PROBE} END_IF;");
        assert_eq!(bound(&body), Ok(1), "{body}");
    }
}

#[test]
fn what_a_compiler_to_c_may_evaluate_again_takes_its_time_again() {
    const ROOT: &str = "REAL_TO_INT(SQRT(r))";
    for (body, most) in [
        ("q := (SQRT(r) > 1.0) XOR x;".to_owned(), 2),
        ("q := x XOR (SQRT(r) > 1.0);".to_owned(), 1),
        (format!("y := v MOD {ROOT};"), 2),
        (format!("y := {ROOT} MOD v;"), 1),
        (format!("q := (bs[{ROOT}] XOR x) XOR b;"), 4),
        (format!("ks[LIMIT(0, {ROOT}, 3)]();"), 1),
        (format!("ks[LIMIT(0, {ROOT}, 3)](a := 1, o => v);"), 3),
        (format!("y := ks[LIMIT(0, {ROOT}, 3)].M(k := 1);"), 1),
    ] {
        assert_eq!(bound(&body), Ok(most), "{body}");
    }
    let body = "q := (ADD(EN := TRUE, IN1 := 1, IN2 := 2, ENO => b) = 3) XOR x;";
    refused(body, "evaluate it twice");
}

#[test]
fn an_element_that_is_set_may_not_be_named_by_a_call() {
    refused("bs[F()] S= TRUE;", "which element is set may change");
    accepted("bs[n + 1] S= x;");
}

#[test]
fn en_is_kept_where_instances_are_copied_or_passed() {
    let units = "
        FUNCTION_BLOCK B VAR_OUTPUT out : BOOL := TRUE; END_VAR out := FALSE; END_FUNCTION_BLOCK
        FUNCTION_BLOCK Of VAR b : B; END_VAR VAR_INPUT off, on : BOOL; END_VAR
            IF off THEN b(EN := FALSE); END_IF; IF on THEN b(); END_IF; END_FUNCTION_BLOCK
        FUNCTION_BLOCK W VAR_IN_OUT h : Of; END_VAR h(off := TRUE, on := FALSE); END_FUNCTION_BLOCK
        TYPE S : STRUCT b : B; END_STRUCT END_TYPE
        FUNCTION_BLOCK V VAR_INPUT b : B; END_VAR b(); END_FUNCTION_BLOCK";
    for body in [
        "c(EN := FALSE); b := c; b(); x := b.out;",
        "s.b(EN := FALSE); t := s; t.b(); x := t.b.out;",
        "c(EN := FALSE); v(b := c); x := v.b.out;",
        "w(h := held); held(off := FALSE, on := TRUE); x := held.b.out;",
    ] {
        let variables = "b, c : B; s, t : S; v : V; w : W; held : Of; x : BOOL; r : REAL;";
        let text = format!(
            "{units} PROGRAM main VAR {variables} END_VAR {body} IF x THEN {PROBE} END_IF; END_PROGRAM"
        );
        assert_eq!(bound_of(&text), Ok(1), "{body}");
    }
}

#[test]
fn a_type_may_not_say_what_references_mean() {
    let read = |types: &str, of: &str, path: &str| {
        let text = format!(
            "VAR_GLOBAL g1, g2 : INT; END_VAR {types}
             PROGRAM main VAR_EXTERNAL g1, g2 : INT; END_VAR VAR s : {of}; q : REF_TO INT; r : REAL; END_VAR
             q := REF(g2); {path}^ := 5; IF g1 = 5 THEN {PROBE} END_IF; END_PROGRAM"
        );
        bound_of(&text)
    };
    let part =
        |initial: &str| format!("TYPE S : STRUCT p : REF_TO INT{initial}; END_STRUCT END_TYPE");
    for (types, path) in [
        (part(" := REF(g1)"), "s.p"),
        (part("") + " TYPE T : STRUCT s : S := (p := REF(g1)); END_STRUCT END_TYPE", "s.s.p"),
        ("TYPE S : REF_TO INT := REF(g1); END_TYPE".to_owned(), "s"),
    ] {
        let of = if path == "s.s.p" { "T" } else { "S" };
        let told = read(&types, of, path).expect_err(&types);
        assert!(told.contains("a type gives references"), "{types}: {told}");
    }
    assert_eq!(read(&part(""), "S := (p := REF(g1))", "s.p"), Ok(1));
    assert!(read(&part(" := NULL"), "S", "s.p").is_ok());
}

/// Controllers evaluate the index of an assigned element before or after the value, and the index may change the value.
#[test]
fn an_assigned_value_is_read_before_or_after_the_index_changes_it() {
    for (value, is_reached) in [(0, true), (1, true), (2, false)] {
        let body =
            format!("n := 0; c[LIMIT(0, G() - 7, 2)] := n; IF c[0] = {value} THEN {PROBE} END_IF");
        assert_eq!(bound(&body), Ok(u64::from(is_reached)), "{value}");
    }
}

/// Controllers evaluate the indices of a path in different orders, and each once.
#[test]
fn a_call_in_an_index_may_not_change_other_parts_of_the_path() {
    let list = "TYPE Row : ARRAY[0..1] OF INT; END_TYPE";
    let program = |body: &str| {
        format!(
            "{list} {UNITS} PROGRAM main VAR_EXTERNAL n : INT; END_VAR VAR s : ARRAY[0..1] OF Row; \
             a : ARRAY[0..9] OF INT; p : REF_TO INT; r : REAL; END_VAR {body} END_PROGRAM"
        )
    };
    for (body, why) in [
        ("s[n][G() - 7] := 5;", "different orders"),
        ("s[G() - 7][n] := 5;", "different orders"),
        ("n := s[n][G() - 7];", "different orders"),
        ("p := REF(s[n][1]); p^ := 4;", "taking the address"),
    ] {
        let told = bound_of(&program(body)).expect_err(body);
        assert!(told.contains(why), "{body}: {told}");
    }
    for body in [
        "s[n][P()] := 5;",
        "s[1][G() - 7] := 5;",
        "p := REF(a[n]); p^ := 4;",
        "p := REF(a[P()]); p^ := 4;",
    ] {
        assert_eq!(bound_of(&program(body)), Ok(0), "{body}");
    }
    // The call in the index of an address is executed once.
    let referred = |told: &str| {
        format!("n := 0; a[7] := 0; p := REF(a[G()]); p^ := 4; IF {told} THEN {PROBE} END_IF")
    };
    for (told, bound) in [("a[7] = 4", 1), ("n = 1", 1), ("n = 2", 0), ("a[7] = 0", 0)] {
        assert_eq!(bound_of(&program(&referred(told))), Ok(bound), "{told}");
    }
}

/// The variables of a chained assignment are evaluated once, at a time that does not matter.
#[test]
fn a_chained_assignment_evaluates_nothing_twice() {
    refused("v := c[G() - 7] := 3;", "chained assignment");
    refused("c[n] := n := 1;", "chained assignment");
    refused("pi := REF(v); pi^ := y := 3;", "is a reference");
    let body = |told: &str| {
        format!("c[1] := 4; v := y := c[2] := c[1]; IF v = {told} AND c[2] = 4 THEN {PROBE} END_IF")
    };
    assert_eq!((bound(&body("4")), bound(&body("5"))), (Ok(1), Ok(0)));
    let property = "FUNCTION_BLOCK V VAR k : INT; END_VAR PROPERTY W : INT GET W := k; END_GET \
                    SET k := W + 1; END_SET END_PROPERTY END_FUNCTION_BLOCK";
    let program = |body: &str| {
        format!("{property} PROGRAM main VAR f : V; a : INT; END_VAR {body} END_PROGRAM")
    };
    assert_eq!(bound_of(&program("f.W := 3; a := f.W;")), Ok(0));
    let told = bound_of(&program("a := f.W := 3;")).expect_err("a property");
    assert!(told.contains("is a property"), "{told}");
}

/// An index outside the array may end the scan where the address of an element is taken.
#[test]
fn no_scan_is_found_behind_an_address_outside_the_array() {
    let found = |index: &str| {
        let text = format!(
            "PROGRAM main VAR_INPUT k : INT; END_VAR VAR a : ARRAY[0..3] OF INT; p : REF_TO INT; r : REAL; END_VAR
             p := REF(a[k]); IF k = {index} THEN {PROBE} END_IF END_PROGRAM"
        );
        let table = table("PROGRAM,0,\nSQRT,1000,\n@end,0,\n");
        let found = audited("iec-text", None, &[("p.st", &text)], &table, &Facts::default());
        let bound = found.expect("a program").audit.bound;
        (bound.lower.0 / 1_000_000_000, bound.upper.0 / 1_000_000_000)
    };
    assert_eq!((found("3"), found("7")), ((1, 1), (0, 1)));
}

/// With an index outside the array, no element is meant: nothing in the array is written, and what is read may be any.
#[test]
fn what_is_outside_the_array_is_none_of_its_elements() {
    let bound = |action: &str, told: &str| {
        let text = format!(
            "FUNCTION_BLOCK B VAR o : INT; END_VAR METHOD St : INT VAR_INPUT k : INT; END_VAR o := k; St := k; \
             END_METHOD END_FUNCTION_BLOCK \
             PROGRAM main VAR_INPUT k : INT; END_VAR VAR t : ARRAY[0..1] OF INT; w : ARRAY[0..1] OF WORD; f : ARRAY[0..1] OF B; \
             p : REF_TO INT; a : INT; r : REAL; END_VAR \
             t[0] := 1; t[1] := 2; w[0] := 1; w[1] := 2; a := f[0].St(k := 1); a := f[1].St(k := 2); {action} \
             IF k = 7 AND {told} THEN {PROBE} END_IF END_PROGRAM"
        );
        bound_of(&text)
    };
    let kept = [
        ("p := REF(t[k]); p^ := 9;", "t[0] = 1 AND t[1] = 2"),
        ("p := REF(t[k]); a := p^;", "a = 9"),
        ("a := f[k].St(k := 9);", "f[0].o = 1 AND f[1].o = 2"),
        ("w[k].4 := TRUE;", "w[0] = 1 AND w[1] = 2"),
    ];
    for (action, told) in kept {
        assert_eq!(bound(action, told), Ok(1), "{action}");
    }
    assert_eq!(bound("p := REF(t[LIMIT(0, k, 1)]); p^ := 9;", "t[0] = 1 AND t[1] = 2"), Ok(0));
}

/// A whole variable behind NULL ends a run, also as an argument.
#[test]
fn no_scan_is_found_behind_a_whole_variable_at_null() {
    let text = format!(
        "TYPE E : STRUCT x : INT; END_STRUCT END_TYPE \
         FUNCTION FE : INT VAR_IN_OUT z : E; END_VAR z.x := 1; FE := z.x; END_FUNCTION \
         PROGRAM main VAR_INPUT on : BOOL; END_VAR VAR a : INT; s : E; p : REF_TO E; r : REAL; END_VAR \
         IF on THEN p := REF(s); ELSE p := NULL; END_IF a := FE(z := p^); IF NOT on THEN {PROBE} END_IF END_PROGRAM"
    );
    let table = table("PROGRAM,0,\nSQRT,1000,\n@end,0,\n");
    let found = audited("iec-text", None, &[("p.st", &text)], &table, &Facts::default());
    assert_eq!(found.expect("a program").audit.bound.lower.0, 0);
}

/// A call of an instance outside the array may be executed, on memory behind the array.
#[test]
fn a_call_outside_the_array_takes_its_time() {
    let of = |call: &str| {
        let text = format!(
            "FUNCTION_BLOCK C VAR_INPUT i : INT; END_VAR VAR r : REAL; END_VAR \
             METHOD M : INT r := SQRT(r); END_METHOD r := SQRT(r); END_FUNCTION_BLOCK \
             FUNCTION H : INT VAR r : REAL; END_VAR r := SQRT(r); END_FUNCTION \
             PROGRAM main VAR_INPUT k : INT; END_VAR VAR c : ARRAY[0..1] OF C; t : ARRAY[0..1] OF TON; a : INT; END_VAR \
             IF k > 1 THEN {call} END_IF END_PROGRAM"
        );
        bound_of(&text)
    };
    assert_eq!(of("c[k]();"), Ok(1));
    assert_eq!(of("a := c[k].M();"), Ok(1));
    assert_eq!(of("c[k](i := H());"), Ok(2));
    assert_eq!(of("t[k](IN := H() > k, PT := T#1s);"), Ok(1));
}

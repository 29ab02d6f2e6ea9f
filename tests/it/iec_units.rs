//! Calls of programs, actions and base bodies, and variables that share memory by their addresses: no bound is below
//! what some controller does.

use crate::iec_exact::logarithms;
use crate::iec_readings::audited;
use scanbound::base::code::Code;

/// Asserts the largest number of logarithms that a scan may compute.
fn costs(text: &str, most: u64) {
    assert_eq!(logarithms(text), Ok((most, 0)), "{text}");
}

#[test]
fn called_programs_and_actions_give_back_what_they_write() {
    let called = |units: &str, call: &str| {
        format!(
            "{units} PROGRAM main VAR x : INT; b : B; r : REAL; END_VAR x := 0; {call} IF x = 7 THEN r := LN(1.0); END_IF END_PROGRAM"
        )
    };
    let block = "FUNCTION_BLOCK B VAR_INPUT a : INT; END_VAR VAR_OUTPUT o : INT; END_VAR VAR n : INT; END_VAR n := a; \
        ACTION act: o := a; END_ACTION END_FUNCTION_BLOCK";
    costs(&called(block, "b.act(a := 7, o => x);"), 1);
    costs(&called(block, "b.act(a := 6, o => x);"), 0);
    let program = "PROGRAM P VAR_INPUT a : INT; END_VAR VAR_OUTPUT o : INT; END_VAR VAR_IN_OUT i : INT; END_VAR o := a; \
        i := i + a; END_PROGRAM";
    let text = |call: &str| called(&format!("{block} {program}"), call);
    costs(&text("P(a := 7, i := b.n, o => x);"), 1);
    costs(&text("P(a := 7, i := x);"), 1);
    costs(&text("P(a := 6, i := x);"), 0);
}

#[test]
fn a_program_that_another_one_calls_runs_only_then() {
    let text = |call: &str| {
        format!(
            "PROGRAM Reset VAR_EXTERNAL g : INT; END_VAR g := 0; END_PROGRAM \
            PROGRAM main VAR_EXTERNAL g : INT; END_VAR VAR r : REAL; c AT %IX0.0 : BOOL; END_VAR \
            IF g = 1 THEN r := LN(1.0); END_IF g := 1; {call} END_PROGRAM VAR_GLOBAL g : INT; END_VAR"
        )
    };
    costs(&text("IF c THEN Reset(); END_IF"), 1);
    // Nothing calls it, so it runs by itself, before main.
    costs(&text(""), 0);
    // Calls in code that never runs, and those of programs that call each other, leave no program out.
    let dead = "PROGRAM P VAR r : REAL; END_VAR r := LN(1.0); END_PROGRAM FUNCTION_BLOCK B P(); END_FUNCTION_BLOCK \
        PROGRAM main VAR x : INT; END_VAR x := 1; END_PROGRAM";
    costs(dead, 1);
    let mutual = "PROGRAM P Q(); END_PROGRAM PROGRAM Q P(); END_PROGRAM PROGRAM main VAR x : INT; END_VAR x := 1; END_PROGRAM";
    assert_eq!(logarithms(mutual), Err(vec![Code::Recursion]));
}

#[test]
fn the_body_of_a_base_is_a_call_of_its_own() {
    let text = |base: &str, body: &str| {
        format!(
            "FUNCTION_BLOCK B0 {base} END_FUNCTION_BLOCK FUNCTION_BLOCK B1 EXTENDS B0 VAR y : INT; END_VAR END_FUNCTION_BLOCK \
            FUNCTION_BLOCK D EXTENDS B1 {body} END_FUNCTION_BLOCK PROGRAM main VAR d : D; END_VAR d(); END_PROGRAM"
        )
    };
    // Its temporary variables begin anew at each.
    let counts = "VAR_TEMP t : INT; END_VAR VAR r : REAL; END_VAR IF t = 0 THEN r := LN(1.0); END_IF t := t + 1;";
    costs(&text(counts, "SUPER^(); SUPER^();"), 2);
    // Those of the derived block stay.
    let own = "VAR_TEMP u : INT; END_VAR u := 5; SUPER^(); IF u = 5 THEN r := LN(1.0); END_IF";
    costs(&text("VAR r : REAL; x : INT; END_VAR x := 0;", own), 1);
    // Controllers differ in whether an empty body between them executes that of its base.
    let clears = "VAR x : INT; r : REAL; END_VAR x := 0;";
    costs(&text(clears, "x := 1; SUPER^(); IF x = 1 THEN r := LN(1.0); END_IF"), 1);
    costs(&text(clears, "x := 1; SUPER^(); IF x = 0 THEN r := LN(1.0); END_IF"), 1);
}

/// Units and the body of a program, with `H`, which writes the globals `g` and `k` and moves the pointer `gp`.
fn with_initial(units: &str, variables: &str, body: &str) -> String {
    format!(
        "VAR_GLOBAL g, k, a0, b0 : INT; gp : POINTER TO INT; END_VAR \
        FUNCTION H : INT g := 5; k := 1; gp := ADR(b0); H := 0; END_FUNCTION {units} \
        PROGRAM main VAR {variables} x, i : INT; r : REAL; END_VAR g := 1; k := 0; gp := ADR(a0); {body} END_PROGRAM"
    )
}

#[test]
fn an_initial_value_of_a_call_reaches_no_argument_by_another_name() {
    let function = |variables: &str| {
        format!(
            "FUNCTION F : INT VAR_IN_OUT q : INT; END_VAR {variables} q := q; F := q; END_FUNCTION"
        )
    };
    let method = "INTERFACE IX METHOD m : INT VAR_IN_OUT q : INT; END_VAR END_METHOD END_INTERFACE \
        FUNCTION_BLOCK A IMPLEMENTS IX METHOD m : INT VAR_IN_OUT q : INT; END_VAR VAR t : INT := H(); END_VAR m := q; END_METHOD \
        END_FUNCTION_BLOCK";
    let member = "FUNCTION_BLOCK A VAR_IN_OUT q : INT; END_VAR VAR z : INT; END_VAR \
        METHOD m : INT VAR t : INT := q; END_VAR m := t; END_METHOD z := q; END_FUNCTION_BLOCK";
    let base = |section: &str| {
        format!(
            "FUNCTION_BLOCK B VAR x0 : INT; END_VAR {section} t : INT := H(); END_VAR x0 := t; END_FUNCTION_BLOCK"
        )
    };
    let derived = format!(
        "{} FUNCTION_BLOCK A EXTENDS B METHOD m : INT VAR_IN_OUT q : INT; END_VAR SUPER^(); m := q; END_METHOD x0 := 0; \
        END_FUNCTION_BLOCK",
        base("VAR_TEMP")
    );
    let local = function("VAR t : INT := H(); END_VAR");
    let table = "VAR_GLOBAL CONSTANT c : ARRAY[0..1] OF INT := [1, 2]; END_VAR";
    let indexed = |variables: &str| format!("{table} {}", function(variables));
    for (units, variables, body) in [
        (&*local, "", "x := F(q := g);"),
        (&function("VAR_OUTPUT o : INT := H(); END_VAR"), "", "x := F(q := g);"),
        (&function("VAR_INPUT o : INT := H(); END_VAR"), "", "x := F(q := g);"),
        (&function("VAR_INPUT o : INT := g; END_VAR"), "", "x := F(q := x);"),
        (&function("VAR t : INT := g; END_VAR"), "", "x := F(q := g);"),
        (&function("VAR t : INT := u; u : INT := 5; END_VAR"), "", "x := F(q := g);"),
        (&indexed("VAR_INPUT o : INT := c[g]; END_VAR"), "", "x := F(q := x);"),
        (&indexed("VAR_INPUT o : INT := %MW7; END_VAR"), "", "x := F(q := x);"),
        (&indexed("VAR t : INT := c[u]; u : INT := 1; END_VAR"), "", "x := F(q := x);"),
        (&local, "v : ARRAY[0..1] OF INT;", "x := F(q := v[k]);"),
        (&local, "", "x := F(q := gp^);"),
        (method, "f : A;", "x := f.m(q := g);"),
        (method, "f : A; it : IX;", "it := f; x := it.m(q := g);"),
        (member, "f : A;", "f(q := x); x := 5; x := f.m();"),
        (&derived, "f : A;", "x := f.m(q := g);"),
    ] {
        let text = with_initial(units, variables, body);
        assert_eq!(logarithms(&text), Err(vec![Code::NotModelled]), "{text}");
    }
    let loops = "FUNCTION_BLOCK A EXTENDS B VAR i : INT; r : REAL; END_VAR \
        g := 3; FOR i := 1 TO g DO SUPER^(); r := LN(1.0); END_FOR END_FUNCTION_BLOCK";
    let looped =
        |section: &str| with_initial(&format!("{} {loops}", base(section)), "f : A;", "f();");
    assert_eq!(logarithms(&looped("VAR_TEMP")), Err(vec![Code::LoopCount]));
    costs(
        &with_initial(&local, "", "x := 0; x := F(q := x); IF x = 0 THEN r := LN(1.0); END_IF"),
        1,
    );
    // A block evaluates the initial values of its own variables before the first scan, not in a call.
    costs(&looped("VAR"), 3);
    let block = "FUNCTION_BLOCK A VAR_IN_OUT q : INT; END_VAR VAR t : INT := H(); END_VAR END_FUNCTION_BLOCK";
    costs(&with_initial(block, "f : A;", "f(q := g); IF g = 5 THEN r := LN(1.0); END_IF"), 0);
}

#[test]
fn controllers_differ_in_which_temporary_variables_a_body_initialises() {
    let text = |units: &str, body: &str| {
        format!(
            "VAR_GLOBAL g : INT; END_VAR FUNCTION F : INT VAR r : REAL; END_VAR r := LN(1.0); g := 0; F := 0; END_FUNCTION \
            {units} PROGRAM main VAR d : D; r : REAL; END_VAR g := 1; {body} END_PROGRAM"
        )
    };
    let temporary = "VAR_TEMP t : INT := F(); END_VAR";
    let base = |own: &str, derived: &str| {
        format!(
            "FUNCTION_BLOCK B VAR n : INT; r : REAL; END_VAR {own} n := 1; END_FUNCTION_BLOCK \
            FUNCTION_BLOCK D EXTENDS B {derived} END_FUNCTION_BLOCK"
        )
    };
    // A derived block without a body: its empty body begins with its own.
    costs(&text(&base("", temporary), "d();"), 1);
    let between = "FUNCTION_BLOCK M EXTENDS B VAR_TEMP t : INT := F(); END_VAR END_FUNCTION_BLOCK";
    let units = base("", "SUPER^();").replace("EXTENDS B", "EXTENDS M");
    // Those of M begin with the body of D, or with SUPER^, or with both.
    costs(&text(&format!("{between} {units}"), "d();"), 2);
    // The body of a derived block may or may not initialise those of its base.
    let tests = |value: u8| {
        format!("n := 0; IF g = {value} THEN r := LN(1.0); r := LN(1.0); r := LN(1.0); END_IF")
    };
    costs(&text(&base(temporary, &tests(1)), "d();"), 3);
    costs(&text(&base(temporary, &tests(0)), "d();"), 4);
    costs(&text(&base(temporary, "SUPER^(); SUPER^();"), "d();"), 3);
    // A scan is known to take only what it takes either way.
    let units = base("VAR_TEMP t : INT := F(); END_VAR", "n := 2;");
    let bounds = |facts: &str| {
        let found = audited("main.st", &text(&units, "d();"), facts);
        found
            .map(|found| (found.bound.lower, found.bound.upper))
            .unwrap_or_else(|why| panic!("{why:?}"))
    };
    let stated = |only: bool| {
        bounds(&format!(
            "[controller]\n\"a body initialises only the VAR_TEMP of its own block, not of its bases\" = {only}\n"
        ))
    };
    let (least, most) = (stated(true).1, stated(false).1);
    assert!(least < most);
    assert_eq!(bounds(""), (least, most));
    // A function has no base.
    let function = "FUNCTION G : INT VAR_TEMP t : INT := F(); END_VAR G := t; END_FUNCTION";
    costs(
        &text(&format!("{function} {}", base("", "")), "n := G();")
            .replace("VAR d", "VAR n : INT; d"),
        1,
    );
}

#[test]
fn variables_with_addresses_share_memory_as_on_any_controller() {
    let text = |variables: &str, body: &str| {
        format!(
            "TYPE S : STRUCT b : BYTE; d : DINT; e : BYTE; END_STRUCT END_TYPE \
            TYPE T : STRUCT b : BOOL; n : INT; END_STRUCT END_TYPE \
            PROGRAM main VAR {variables} r : REAL; END_VAR {body} THEN r := LN(1.0); END_IF END_PROGRAM"
        )
    };
    for (variables, body) in [
        // Each size has a memory of its own on OpenPLC.
        ("a AT %IX0.0 : BOOL; w AT %IW0 : WORD;", "IF a AND w = 0"),
        // A bit address counts words on some CPUs.
        ("b AT %MB6 : BYTE; x AT %MX3.1 : BOOL;", "x := FALSE; b := 2; IF x"),
        ("a AT %IX0.8 : BOOL; b AT %IX1.0 : BOOL;", "IF a AND NOT b"),
        // A number of eight bits has its sign in the highest.
        ("a AT %MB0 : BYTE; b AT %MB0 : SINT;", "a := 200; IF b < 0"),
        // A text is as long as declared.
        ("s AT %MB100 : STRING(20); b AT %MB105 : BYTE;", "b := 0; s := 'abcdefghijk'; IF b <> 0"),
    ] {
        costs(&text(variables, body), 1);
    }
    // The parts of a structure are aligned, and the bit before a number takes a byte. What lies behind is not in it.
    for (variables, body) in [
        ("s AT %MB0 : S; x AT %MB8 : BYTE;", "x := 0; s.e := 5; IF x = 5"),
        ("s AT %MB0 : T; x AT %MB3 : BYTE;", "x := 0; s.n := 16#500; IF x = 5"),
    ] {
        assert_eq!(logarithms(&text(variables, body)), Err(vec![Code::NotModelled]));
    }
    costs(&text("s AT %MB0 : S; x AT %MB12 : BYTE;", "x := 0; s.e := 5; IF x = 5"), 0);
    costs(&text("a AT %MW0 : INT; b AT %MW0 : WORD;", "a := 7; IF b <> 7"), 0);
    // A reference leads to the same memory.
    let looped = "PROGRAM main VAR i AT %MW0 : INT; b AT %MW0 : INT; p : REFERENCE TO INT; r : REAL; END_VAR \
        p REF= b; FOR i := 1 TO 3 DO p := 0; r := LN(1.0); END_FOR END_PROGRAM";
    assert_eq!(logarithms(looped), Err(vec![Code::LoopCount]));
    // So does a member of an element whose index is calculated.
    let member = |end: &str| {
        format!(
            "FUNCTION_BLOCK B VAR v AT %MW0 : INT; u : INT; END_VAR END_FUNCTION_BLOCK \
            PROGRAM main VAR f : ARRAY[0..1] OF B; n AT %MW0 : INT; i, k : INT; r : REAL; END_VAR f[0](); f[1](); \
            k := 1; f[0].u := 3; f[1].u := 3; n := 3; FOR i := 1 TO f[k].{end} DO n := 5; r := LN(1.0); END_FOR END_PROGRAM"
        )
    };
    assert_eq!(logarithms(&member("v")), Err(vec![Code::LoopCount]));
    costs(&member("u"), 3);
    // So does a member of an instance that nothing calls.
    let uncalled = |variables: &str, body: &str| {
        format!(
            "FUNCTION_BLOCK B VAR v AT %MW0 : INT; END_VAR END_FUNCTION_BLOCK TYPE S : STRUCT m : INT; b : B; END_STRUCT END_TYPE \
            PROGRAM main VAR n AT %MW0 : INT; {variables} r : REAL; END_VAR n := 3; {body} IF n = 5 THEN r := LN(1.0); END_IF END_PROGRAM"
        )
    };
    costs(&uncalled("f : S;", "f.b.v := 5;"), 1);
    for k in 0..2 {
        let one = format!("k := {k}; f[k].b.v := 5;");
        costs(&uncalled("f : ARRAY[0..1] OF S; k : INT;", &one), 1);
    }
    costs(&uncalled("f, g : B;", "g := f;"), 0);
}

#[test]
fn an_argument_passed_by_a_pointer_stays_where_it_is() {
    let text = |second: &str| {
        format!(
            "FUNCTION Foo : INT VAR_IN_OUT x : INT; END_VAR VAR_INPUT y : INT; END_VAR x := 7; Foo := y; END_FUNCTION \
            FUNCTION SetP : INT VAR_EXTERNAL p : POINTER TO INT; b : INT; END_VAR p := ADR(b); SetP := 1; END_FUNCTION \
            PROGRAM main VAR_EXTERNAL p : POINTER TO INT; a, b : INT; END_VAR VAR k : INT; r : REAL; END_VAR \
            a := 0; b := 0; p := ADR(a); k := Foo(x := p^, y := {second}); IF a = 7 THEN r := LN(1.0); END_IF END_PROGRAM \
            VAR_GLOBAL p : POINTER TO INT; a, b : INT; END_VAR"
        )
    };
    costs(&text("3"), 1);
    assert_eq!(logarithms(&text("SetP()")), Err(vec![Code::NotModelled]));
}

#[test]
fn texts_passed_by_reference_have_their_own_length() {
    for (section, argument, most) in
        [("VAR_IN_OUT", "a", 30), ("VAR_IN_OUT CONSTANT", "a", 30), ("VAR_INPUT", "a", 5)]
    {
        costs(
            &format!(
                "FUNCTION Sum : INT {section} s : STRING[5]; END_VAR VAR i : INT; z : REAL; END_VAR \
                FOR i := 1 TO LEN(s) DO z := LN(1.0); END_FOR END_FUNCTION \
                PROGRAM main VAR a : STRING[30]; n : INT; END_VAR n := Sum(s := {argument}); END_PROGRAM"
            ),
            most,
        );
    }
}

#[test]
fn a_literal_that_only_an_unsigned_type_holds_is_compared_by_its_bits_too() {
    for (of, literal, may) in [
        ("INT", "16#FFFFFFFF", 1),
        ("INT", "3000000000", 0),
        ("INT", "16#7FFFFFFF", 0),
        ("SINT", "16#FFFF", 1),
        ("DINT", "16#FFFFFFFF", 1),
    ] {
        costs(
            &format!(
                "PROGRAM main VAR x : {of}; z : REAL; END_VAR x := -1; IF x = {literal} THEN z := LN(1.0); END_IF END_PROGRAM"
            ),
            may,
        );
    }
}

#[test]
fn an_input_with_an_edge_keeps_what_was_passed() {
    let text = |section: &str, body: &str| {
        format!(
            "FUNCTION_BLOCK E VAR_INPUT c : BOOL {section}; END_VAR VAR r : REAL; END_VAR IF c THEN r := LN(1.0); END_IF END_FUNCTION_BLOCK \
            PROGRAM main VAR f : E; END_VAR {body} END_PROGRAM"
        )
    };
    // TRUE stays TRUE where nothing is passed: no edge.
    costs(&text("R_EDGE", "f(c := FALSE); f(c := TRUE); f(); f();"), 1);
    costs(&text("R_EDGE", "f(c := FALSE); f(c := TRUE); f(c := FALSE); f(c := TRUE);"), 2);
    costs(&text("F_EDGE", "f(c := TRUE); f(); f(c := FALSE); f();"), 1);
    // A derived block has the input without its edge, and the end of the body overwrites what it wrote to the input.
    let refused = |base: &str, units: &str| {
        let text = format!(
            "VAR_GLOBAL f : D; END_VAR PROGRAM P f.c := FALSE; END_PROGRAM FUNCTION_BLOCK E VAR_INPUT c : BOOL R_EDGE; END_VAR VAR n : INT; END_VAR \
            {base} END_FUNCTION_BLOCK {units} PROGRAM main VAR_EXTERNAL f : D; END_VAR f(c := TRUE); f(c := TRUE); END_PROGRAM"
        );
        logarithms(&text) == Err(vec![Code::NotModelled])
    };
    let derived = |body: &str| {
        format!("FUNCTION_BLOCK D EXTENDS E VAR r : REAL; END_VAR {body} END_FUNCTION_BLOCK")
    };
    assert!(refused("n := 1;", &derived("IF NOT c THEN r := LN(1.0); END_IF")));
    assert!(refused("P();", &derived("")));
    assert!(refused("c := n > 0;", &derived("")));
    assert!(!refused("n := 1;", &derived("")));
}

#[test]
fn a_kept_or_selected_constant_may_be_an_unsigned_number() {
    let text = |variables: &str, body: &str| {
        format!(
            "PROGRAM main VAR {variables} r : REAL; END_VAR {body} THEN r := LN(1.0); END_IF END_PROGRAM"
        )
    };
    for (body, may) in [
        ("k := 0; y := MUX(k, x, 40000); IF y <> -1", 1),
        ("k := 0; y := MUX(k, x, 16#FFFF); IF y > 40000", 1),
        ("y := MUX(0, x, 40000); IF y <> -1", 1),
        ("k := 0; y := MUX(k, x, 30000); IF y <> -1", 0),
    ] {
        costs(&text("x, k : INT; y : DINT;", &format!("x := -1; {body}")), may);
    }
    let list = "PROGRAM main VAR x, y : DINT; u : UDINT; r : REAL; END_VAR
        LD -1\nST x\nLD 4294967294\nADD 1\nST u\nEQ x\nJMPCN fin\nLD 1.0\nLN\nST r\nfin:\nLD 0\nST y\nEND_PROGRAM";
    costs(list, 1);
    costs(&text("l : LINT; q : REAL;", "q := 1.0E12; l := TRUNC(q); IF l > 2147483647"), 1);
}

#[test]
fn a_calculated_text_has_the_length_that_any_controller_gives_it() {
    let sum = "FUNCTION Sum : INT VAR_IN_OUT CONSTANT s : STRING[5]; END_VAR VAR i : INT; z : REAL; END_VAR \
        FOR i := 1 TO LEN(s) DO z := LN(1.0); END_FOR END_FUNCTION";
    let called = format!(
        "{sum} PROGRAM main VAR a, b : STRING[10]; n : INT; END_VAR n := Sum(s := CONCAT(a, b)); END_PROGRAM"
    );
    assert_eq!(logarithms(&called), Err(vec![Code::NotModelled]));
    for (of, least) in [("'\u{3042}\u{3044}'", 6), ("DINT_TO_STRING(n)", 255)] {
        let text = format!(
            "PROGRAM main VAR i : INT; n : DINT; z : REAL; END_VAR FOR i := 1 TO LEN({of}) DO z := LN(1.0); END_FOR END_PROGRAM"
        );
        assert!(logarithms(&text).is_ok_and(|(most, _)| most >= least), "{of}");
    }
}

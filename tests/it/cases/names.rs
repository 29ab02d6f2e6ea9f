//! Names, calls and initial values of IEC 61131-3 programs.

use super::{Run, audit, case, lower_ns, scanbound, upper_ns};
use serde_json::Value;

const FACTS: &str = "--table zero.csv --facts calls.toml";

/// Blocks that take 1 us and 4 us, and instances of them.
pub(super) const BLOCKS: &str = "
FUNCTION_BLOCK FOp1 VAR_INPUT x : BOOL; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK FOp4 VAR_INPUT x : BOOL; END_VAR END_FUNCTION_BLOCK
VAR_GLOBAL Op1 : FOp1; Op4 : FOp4; END_VAR
FUNCTION One : INT VAR_INPUT x : INT; END_VAR Op1(); One := x; END_FUNCTION
FUNCTION Four : INT VAR_INPUT x : INT; END_VAR Op4(); Four := x; END_FUNCTION
";

/// Runs the command on texts, each a file: `0.st` and so on.
pub(super) fn run_of(texts: &[&str], command: &str, arguments: &str) -> Run {
    let directory = tempfile::tempdir().expect("a directory");
    let place = |name: &str| directory.path().join(name);
    for name in ["zero.csv", "calls.toml"] {
        std::fs::copy(case("attack").join(name), place(name)).expect("a copy");
    }
    let names: Vec<String> = (0..texts.len()).map(|at| format!("{at}.st")).collect();
    for (name, text) in names.iter().zip(texts) {
        std::fs::write(place(name), text).expect("a file");
    }
    super::run(&format!("{command} {} {FACTS} {arguments}", names.join(" ")), directory.path())
}

/// The report on a program in which [`BLOCKS`] are declared.
fn report(text: &str) -> Value {
    let run = run_of(&[text, BLOCKS], "audit", "--format json");
    assert_eq!(run.code, Some(0), "{text}\n{}{}", run.stdout, run.stderr);
    run.json()
}

/// The bound of such a program in nanoseconds.
fn bound(text: &str) -> u64 {
    upper_ns(&report(text))
}

/// That such a program is refused, and what is said.
fn refused(text: &str) -> String {
    let run = run_of(&[text, BLOCKS], "audit", "");
    assert_eq!(run.code, Some(2), "{text}\n{}{}", run.stdout, run.stderr);
    run.stderr
}

/// That a case is refused, and what is said.
fn refused_case(name: &str) -> String {
    let run = scanbound("attack", &format!("audit {name} {FACTS}"));
    assert_eq!(run.code, Some(2), "{name}\n{}{}", run.stdout, run.stderr);
    run.stderr
}

#[test]
fn a_name_that_is_declared_twice_is_refused_with_both_places() {
    let told = refused_case("dup-function.st");
    assert!(told.contains("dup-function.st:2") && told.contains("dup-function.st:1"), "{told}");
    let program = "PROGRAM p VAR n : INT; END_VAR n := One(1); END_PROGRAM\n";
    for twice in [
        "FUNCTION_BLOCK b END_FUNCTION_BLOCK FUNCTION_BLOCK B n(); END_FUNCTION_BLOCK",
        "FUNCTION One : INT VAR_INPUT x : INT; END_VAR Op4(); END_FUNCTION",
        "TYPE t : INT; END_TYPE TYPE T : DINT; END_TYPE",
        "TYPE t : INT; END_TYPE FUNCTION_BLOCK T END_FUNCTION_BLOCK",
        "TYPE t : STRUCT a : INT; A : DINT; END_STRUCT; END_TYPE",
        "TYPE t : (a, b, A); END_TYPE",
        "VAR_GLOBAL g : INT; END_VAR VAR_GLOBAL G : DINT; END_VAR",
        "VAR_GLOBAL p : INT; END_VAR",
        "FUNCTION_BLOCK b VAR x : INT; X : DINT; END_VAR END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK b VAR x : INT; END_VAR VAR_INPUT x : INT; END_VAR END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK b METHOD m One(1); END_METHOD METHOD M Four(1); END_METHOD END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK b VAR m : INT; END_VAR METHOD m END_METHOD END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK b METHOD m VAR x : INT; x : INT; END_VAR END_METHOD END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK b Op1(); ACTION a: Op1(); END_ACTION ACTION A: Op4(); END_ACTION END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK b PROPERTY q : INT GET q := 1; END_GET GET q := 2; END_GET END_PROPERTY END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK b PROPERTY q : INT GET q := 1; END_GET END_PROPERTY METHOD Q : INT END_METHOD END_FUNCTION_BLOCK",
        "FUNCTION f : INT VAR F : INT; END_VAR END_FUNCTION",
        "FUNCTION_BLOCK b VAR x : INT; END_VAR END_FUNCTION_BLOCK
         FUNCTION_BLOCK c EXTENDS b VAR X : DINT; END_VAR END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK b VAR x : INT; END_VAR END_FUNCTION_BLOCK
         FUNCTION_BLOCK c EXTENDS b METHOD x END_METHOD END_FUNCTION_BLOCK",
        "PROGRAM q END_PROGRAM CONFIGURATION c TASK t(INTERVAL := T#1s); PROGRAM i WITH t : p; PROGRAM i WITH t : q; END_CONFIGURATION",
    ] {
        let told = refused(&format!("{program}{twice}"));
        assert!(told.contains("a second time"), "{twice}\n{told}");
    }
    // A method may take the place of an inherited one.
    let kept = "FUNCTION_BLOCK b METHOD m One(1); END_METHOD END_FUNCTION_BLOCK
         FUNCTION_BLOCK c EXTENDS b METHOD m Four(1); END_METHOD END_FUNCTION_BLOCK";
    assert_eq!(bound(&format!("{program}{kept}")), 1000);
}

#[test]
fn copies_of_a_library_s_file_are_one_and_programs_are_not() {
    let library =
        "FUNCTION Two : INT VAR_INPUT x : INT; END_VAR Op1(); Op1(); Two := x; END_FUNCTION
        VAR_GLOBAL g : INT; END_VAR TYPE t : (a, b); END_TYPE";
    let program = "PROGRAM p VAR n : INT; END_VAR n := Two(1); END_PROGRAM";
    let run = run_of(&[program, library, library, BLOCKS], "audit", "--format json");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(upper_ns(&run.json()), 2000);
    let other = library.replace("Op1(); Op1();", "Op1();");
    for texts in [[program, library, &other, BLOCKS], [program, program, library, BLOCKS]] {
        let run = run_of(&texts, "audit", "");
        assert_eq!(run.code, Some(2), "{}", run.stdout);
        assert!(run.stderr.contains("a second time"), "{}", run.stderr);
    }
}

#[test]
fn members_of_drawings_are_told_apart_by_name() {
    let action = |name: &str, op: &str| {
        format!(
            "<action name=\"{name}\"><body><ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{op}();</xhtml></ST></body></action>"
        )
    };
    let project = |actions: &str| {
        format!(
            "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><dataTypes/><pous><pou name=\"p\" pouType=\"program\">
             <interface/><actions>{actions}</actions><body><ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">a();</xhtml></ST></body>
             </pou></pous></types></project>"
        )
    };
    let run = |text: &str| {
        let directory = tempfile::tempdir().expect("a directory");
        let place = |name: &str| directory.path().join(name);
        for name in ["zero.csv", "calls.toml"] {
            std::fs::copy(case("attack").join(name), place(name)).expect("a copy");
        }
        std::fs::write(place("p.xml"), text).expect("a file");
        std::fs::write(place("b.st"), BLOCKS).expect("a file");
        super::run(&format!("audit p.xml b.st {FACTS} --format json"), directory.path())
    };
    let once = run(&project(&(action("a", "Op1") + &action("b", "Op4"))));
    if once.code == Some(0) {
        assert_eq!(upper_ns(&once.json()), 1000);
    }
    let twice = run(&project(&(action("a", "Op1") + &action("A", "Op4"))));
    assert_eq!(twice.code, Some(2), "{}", twice.stdout);
}

#[test]
fn the_constant_that_is_nearest_bounds_arrays_and_texts() {
    let report = audit("attack", &format!("local-constant-shadowed.st {FACTS}"));
    assert_eq!(upper_ns(&report), 6000);
    let begin = "VAR_GLOBAL CONSTANT N : INT := 3; END_VAR\n";
    let walks = "FOR i := LOWER_BOUND(k, 1) TO UPPER_BOUND(k, 1) DO Op1(); END_FOR;";
    for (unit, turns) in [
        // Of a function, a method, a base, a method's own against its block's, in terms of another one, a list's own.
        (format!("FUNCTION H : INT VAR CONSTANT N : INT := 5; END_VAR VAR k : ARRAY[1..N] OF INT; i : INT; END_VAR {walks} END_FUNCTION
          PROGRAM p VAR n : INT; END_VAR n := H(); END_PROGRAM"), 5),
        (format!("FUNCTION_BLOCK H VAR CONSTANT N : INT := 5; END_VAR METHOD m VAR k : ARRAY[1..N] OF INT; i : INT; END_VAR {walks} END_METHOD END_FUNCTION_BLOCK
          PROGRAM p VAR h : H; END_VAR h.m(); END_PROGRAM"), 5),
        (format!("FUNCTION_BLOCK H VAR CONSTANT N : INT := 5; END_VAR METHOD m VAR CONSTANT N : INT := 7; END_VAR VAR k : ARRAY[1..N] OF INT; i : INT; END_VAR {walks} END_METHOD END_FUNCTION_BLOCK
          PROGRAM p VAR h : H; END_VAR h.m(); END_PROGRAM"), 7),
        (format!("FUNCTION_BLOCK A VAR CONSTANT N : INT := 6; END_VAR END_FUNCTION_BLOCK
          FUNCTION_BLOCK H EXTENDS A VAR k : ARRAY[1..N] OF INT; i : INT; END_VAR {walks} END_FUNCTION_BLOCK
          PROGRAM p VAR h : H; END_VAR h(); END_PROGRAM"), 6),
        (format!("FUNCTION_BLOCK H VAR CONSTANT N : INT := 4; M : INT := N * 2; END_VAR VAR k : ARRAY[1..M] OF INT; i : INT; END_VAR {walks} END_FUNCTION_BLOCK
          PROGRAM p VAR h : H; END_VAR h(); END_PROGRAM"), 8),
        (format!("TYPE t : ARRAY[1..N] OF INT; END_TYPE
          FUNCTION_BLOCK H VAR CONSTANT N : INT := 9; END_VAR VAR k : t; i : INT; END_VAR {walks} END_FUNCTION_BLOCK
          PROGRAM p VAR h : H; END_VAR h(); END_PROGRAM"), 3),
        (format!("FUNCTION_BLOCK H VAR k : ARRAY[1..N] OF INT; i : INT; END_VAR {walks} END_FUNCTION_BLOCK
          PROGRAM p VAR h : H; END_VAR VAR CONSTANT N : INT := 9; END_VAR h(); END_PROGRAM"), 3),
    ] {
        assert_eq!(bound(&format!("{begin}{unit}")), turns * 1000, "{unit}");
    }
    // No constant: hidden by a variable, which bounds nothing.
    refused(&format!(
        "{begin}PROGRAM p VAR N : INT := 9; k : ARRAY[1..N] OF INT; END_VAR Op1(); END_PROGRAM"
    ));
    let text = |length: &str| {
        format!(
            "VAR_GLOBAL CONSTANT N : INT := 3; END_VAR
             PROGRAM p VAR CONSTANT N : INT := 200; END_VAR VAR s : STRING({length}); END_VAR
             IF LEN(s) > 100 THEN Op4(); END_IF; END_PROGRAM"
        )
    };
    assert_eq!(["N", "200", "3"].map(|length| bound(&text(length))), [4000, 4000, 0]);
}

#[test]
fn a_local_constant_is_what_a_variable_begins_with() {
    let text = |own: &str| {
        format!(
            "VAR_GLOBAL CONSTANT N : INT := 1; END_VAR
             PROGRAM p VAR CONSTANT N : INT := 6; END_VAR VAR k : INT := {own}; i : INT; END_VAR
             FOR i := 1 TO k DO Op1(); END_FOR; k := 2; END_PROGRAM"
        )
    };
    assert_eq!(bound(&text("6")), 6000);
    let other = bound(&text("N"));
    assert!(other >= 6000, "{other}");
}

#[test]
fn a_unit_s_own_method_or_property_hides_global_names() {
    let report = audit("attack", &format!("own-method-shadowed.st {FACTS}"));
    assert_eq!(upper_ns(&report), 4000);
    let foo = "METHOD Foo : INT VAR_INPUT x : INT; END_VAR Op4(); Foo := x; END_METHOD";
    let global = "FUNCTION Foo : INT VAR_INPUT x : INT; END_VAR Op1(); Foo := x; END_FUNCTION\n";
    for (unit, most) in [
        // As a statement, inherited, from a method, behind THIS^, overridden.
        (format!("FUNCTION_BLOCK H Foo(1); {foo} END_FUNCTION_BLOCK"), 4000),
        (format!("FUNCTION_BLOCK A {foo} END_FUNCTION_BLOCK
          FUNCTION_BLOCK H EXTENDS A VAR n : INT; END_VAR n := Foo(1); END_FUNCTION_BLOCK"), 4000),
        (format!("FUNCTION_BLOCK H VAR n : INT; END_VAR m(); METHOD m n := Foo(1) + 1; END_METHOD {foo} END_FUNCTION_BLOCK"), 4000),
        (format!("FUNCTION_BLOCK H VAR n : INT; END_VAR n := THIS^.Foo(1); {foo} END_FUNCTION_BLOCK"), 4000),
        // A method that only what extends a block has is none of the block's own.
        (format!("FUNCTION_BLOCK A METHOD m Foo(1); END_METHOD END_FUNCTION_BLOCK
          FUNCTION_BLOCK H EXTENDS A m(); {foo} END_FUNCTION_BLOCK"), 1000),
        (format!("FUNCTION_BLOCK A METHOD m VAR n : INT; END_VAR n := Foo(1); END_METHOD END_FUNCTION_BLOCK
          FUNCTION_BLOCK H EXTENDS A m(); {foo} END_FUNCTION_BLOCK"), 1000),
    ] {
        let text = format!("{global}{unit} PROGRAM p VAR h : H; END_VAR h(); END_PROGRAM");
        assert_eq!(bound(&text), most, "{unit}");
    }
    let property = "PROPERTY g : INT GET Op4(); g := 1; END_GET SET Op4(); END_SET END_PROPERTY";
    for (body, most) in [("n := g;", 4000), ("g := 1;", 4000), ("n := g + g;", 8000)] {
        let text = format!(
            "VAR_GLOBAL g : INT; END_VAR FUNCTION_BLOCK H VAR n : INT; END_VAR {body} {property} END_FUNCTION_BLOCK
             PROGRAM p VAR h : H; END_VAR h(); END_PROGRAM"
        );
        assert_eq!(bound(&text), most, "{body}");
    }
    let function = "FUNCTION UPPER_BOUND : INT VAR_INPUT x, y : INT; END_VAR Op4(); END_FUNCTION
        PROGRAM p VAR n : INT; END_VAR n := UPPER_BOUND(n, 1); END_PROGRAM";
    assert_eq!(bound(function), 4000);
}

#[test]
fn a_global_name_that_may_mean_several_things_is_refused() {
    for text in [
        "TYPE t : (e, f); END_TYPE VAR_GLOBAL e : INT; END_VAR PROGRAM p VAR n : INT; END_VAR n := e; END_PROGRAM",
        "VAR_GLOBAL Four : FOp1; END_VAR PROGRAM p Four(1); END_PROGRAM",
    ] {
        let told = refused(text);
        assert!(told.contains("may mean"), "{told}");
    }
    let local = "TYPE t : (e, f); END_TYPE VAR_GLOBAL e : INT; END_VAR
        PROGRAM p VAR n, e : INT; END_VAR n := e; Op1(); END_PROGRAM";
    assert_eq!(bound(local), 1000);
}

#[test]
fn initial_values_that_call_take_their_time_with_each_call() {
    let report = audit("attack", &format!("init-call.st {FACTS}"));
    assert_eq!(upper_ns(&report), 1000);
    for (text, most) in [
        ("FUNCTION K : INT VAR t : INT := One(1) + Four(1); END_VAR K := t; END_FUNCTION
          PROGRAM p VAR n : INT; END_VAR n := K(); END_PROGRAM", 5000),
        ("FUNCTION K : INT VAR_INPUT x : INT := Four(1); END_VAR K := x; END_FUNCTION
          PROGRAM p VAR n : INT; END_VAR n := K(x := 2); END_PROGRAM", 0),
        ("PROGRAM p VAR_TEMP t : INT := Four(1); END_VAR Op1(); END_PROGRAM", 5000),
        ("FUNCTION_BLOCK H METHOD m VAR t : INT := Four(1); END_VAR Op1(); END_METHOD END_FUNCTION_BLOCK
          PROGRAM p VAR h : H; END_VAR h.m(); END_PROGRAM", 5000),
        ("FUNCTION_BLOCK H VAR t : INT := 3; END_VAR METHOD m VAR i : INT; t2 : INT := t; END_VAR
            FOR i := 1 TO t2 DO Op1(); END_FOR; END_METHOD t := 5; END_FUNCTION_BLOCK
          PROGRAM p VAR h : H; END_VAR h(); h.m(); END_PROGRAM", 5000),
    ] {
        assert_eq!(bound(text), most, "{text}");
    }
    for of in [
        "VAR t : ARRAY[1..2] OF INT := [Four(1), Four(2)]; END_VAR",
        "VAR t : ARRAY[1..4] OF INT := [2(Four(1)), Four(2)]; END_VAR",
        "VAR t : s := (x := Four(1)); END_VAR",
        "VAR t : calling; END_VAR",
        "VAR t : H; END_VAR",
        "VAR t : ARRAY[1..2] OF H; END_VAR",
        "VAR CONSTANT t : INT := Four(1); END_VAR",
        "VAR_INPUT t : INT := Four(1); END_VAR",
    ] {
        let text = format!(
            "TYPE s : STRUCT x : INT; END_STRUCT; calling : STRUCT x : INT := Four(1); END_STRUCT; END_TYPE
             FUNCTION_BLOCK H VAR x : INT := Four(1); END_VAR Op1(); END_FUNCTION_BLOCK
             FUNCTION K : INT {of} K := 1; END_FUNCTION PROGRAM p VAR n : INT; END_VAR n := K(); END_PROGRAM"
        );
        let told = refused(&text);
        assert!(told.contains("begins anew with each call"), "{told}");
    }
    // What is called before the first scan may write variables: none is known to begin with 0.
    let text = "VAR_GLOBAL g : INT; END_VAR FUNCTION W : INT g := 7; W := 1; END_FUNCTION
        PROGRAM p VAR a : INT := W(); END_VAR IF g = 7 THEN Op4(); END_IF; g := 0; END_PROGRAM";
    let run = run_of(&[text, BLOCKS], "audit", "--format json --trust all");
    assert_eq!(upper_ns(&run.json()), 4000);
}

#[test]
fn functions_for_implicit_checks_are_refused() {
    refused_case("implicit-checks.st");
    for name in [
        "checkbounds",
        "CheckDivDInt",
        "CheckDivReal",
        "CheckRangeSigned",
        "CheckLRangeUnsigned",
        "CheckPointer",
    ] {
        let text = format!(
            "FUNCTION {name} : DINT VAR_INPUT x : DINT; END_VAR Op4(); END_FUNCTION PROGRAM p Op1(); END_PROGRAM"
        );
        let told = refused(&text);
        assert!(told.contains("implicit checks"), "{told}");
    }
    let other = "FUNCTION CheckDivision : INT Op4(); END_FUNCTION PROGRAM p Op1(); END_PROGRAM";
    assert_eq!(bound(other), 1000);
}

#[test]
fn instances_of_derived_blocks_keep_their_own_methods() {
    refused_case("inout-derived.st");
    let blocks = "FUNCTION_BLOCK A VAR m : INT; END_VAR m := One(1); METHOD Go m := One(1); END_METHOD END_FUNCTION_BLOCK
        FUNCTION_BLOCK B EXTENDS A m := Four(1); METHOD Go m := Four(1); END_METHOD END_FUNCTION_BLOCK\n";
    let takes = "FUNCTION K : INT VAR_IN_OUT x : A; END_VAR x.Go(); END_FUNCTION\n";
    for text in [
        "FUNCTION K2 : INT VAR_IN_OUT x : A; END_VAR x(); END_FUNCTION
         PROGRAM p VAR b : B; n : INT; END_VAR n := K2(b); END_PROGRAM",
        "FUNCTION_BLOCK C VAR_IN_OUT x : A; END_VAR x.Go(); END_FUNCTION_BLOCK
         PROGRAM p VAR b : B; c : C; END_VAR c(x := b); END_PROGRAM",
        "FUNCTION_BLOCK C METHOD d VAR_IN_OUT x : A; END_VAR x.Go(); END_METHOD END_FUNCTION_BLOCK
         PROGRAM p VAR b : B; c : C; END_VAR c.d(b); END_PROGRAM",
        "PROGRAM p VAR b : ARRAY[1..2] OF B; n : INT; END_VAR n := K(b[1]); END_PROGRAM",
        "PROGRAM p VAR b : ARRAY[1..2] OF B; n : INT; END_VAR n := K(b[n]); END_PROGRAM",
        "PROGRAM p VAR b : B; r : REFERENCE TO A; n : INT; END_VAR r REF= b; n := K(r); END_PROGRAM",
        "PROGRAM p VAR b : B; r : POINTER TO A; n : INT; END_VAR r := ADR(b); n := K(r^); END_PROGRAM",
        "FUNCTION_BLOCK D EXTENDS A METHOD u VAR n : INT; END_VAR n := K(THIS^); END_METHOD END_FUNCTION_BLOCK
         PROGRAM p VAR d : D; END_VAR d.u(); END_PROGRAM",
        "FUNCTION V : INT VAR_INPUT x : A; END_VAR x.Go(); END_FUNCTION
         PROGRAM p VAR b : B; n : INT; END_VAR n := V(b); END_PROGRAM",
        "PROGRAM p VAR b : B; a : A; END_VAR a := b; a.Go(); END_PROGRAM",
    ] {
        refused(&format!("{blocks}{takes}{text}"));
    }
    for (text, most) in [
        ("PROGRAM p VAR a : A; n : INT; END_VAR n := K(a); END_PROGRAM", 1000),
        ("PROGRAM p VAR b : B; r : REFERENCE TO A; END_VAR r REF= b; r.Go(); END_PROGRAM", 4000),
    ] {
        assert_eq!(bound(&format!("{blocks}{takes}{text}")), most, "{text}");
    }
}

#[test]
fn counters_without_a_sign_begin_anew_below_zero() {
    refused_case("for-ulint.st");
    for of in ["USINT", "UINT", "UDINT", "ULINT", "BYTE", "WORD", "DWORD", "LWORD"] {
        for range in ["3 TO 0 BY -1", "5 TO 1 BY -2", "3 TO -1 BY -1", "0 TO -1", "0 TO -5 BY -1"] {
            refused(&format!(
                "PROGRAM p VAR q : {of}; END_VAR FOR q := {range} DO Op1(); END_FOR; END_PROGRAM"
            ));
        }
        for range in ["n TO 0 BY -1", "0 TO n"] {
            let text = format!(
                "PROGRAM p VAR q : {of}; n AT %IW0 : INT; END_VAR FOR q := {range} DO Op1(); END_FOR; END_PROGRAM"
            );
            let run = run_of(&[&text, BLOCKS], "check", "--limit 1s");
            assert!(matches!(run.code, Some(1..=3)), "{of} {range}\n{}{}", run.stdout, run.stderr);
            assert!(!run.stdout.contains("PROVED"), "{of} {range}\n{}", run.stdout);
        }
        let text = format!(
            "PROGRAM p VAR q : {of}; END_VAR FOR q := 1 TO 3 DO Op1(); END_FOR; END_PROGRAM"
        );
        assert_eq!(bound(&text), 3000);
    }
    let down =
        "PROGRAM p VAR q : LINT; END_VAR FOR q := 3 TO 0 BY -1 DO Op1(); END_FOR; END_PROGRAM";
    assert_eq!(bound(down), 4000);
}

#[test]
fn a_block_without_a_body_is_a_doubt_whatever_it_declares() {
    let name = "lib-inputs-only.st";
    let run = scanbound("attack", &format!("check {name} {FACTS} --limit 1ms"));
    assert_eq!(run.code, Some(3), "{}", run.stdout);
    assert!(run.stdout.contains("LB"), "{}", run.stdout);
    for (text, what) in [
        (
            "FUNCTION_BLOCK LB END_FUNCTION_BLOCK PROGRAM p VAR f : LB; END_VAR f(); END_PROGRAM",
            "LB",
        ),
        ("FUNCTION LF VAR_INPUT x : INT; END_VAR END_FUNCTION PROGRAM p LF(1); END_PROGRAM", "LF"),
        (
            "FUNCTION_BLOCK LB METHOD m VAR_INPUT x : INT; END_VAR END_METHOD END_FUNCTION_BLOCK
          PROGRAM p VAR f : LB; END_VAR f.m(1); END_PROGRAM",
            "LB.m",
        ),
        (
            "FUNCTION_BLOCK LB VAR_INPUT x : INT; END_VAR METHOD m END_METHOD END_FUNCTION_BLOCK
          PROGRAM p VAR f : LB; END_VAR f(x := 1); END_PROGRAM",
            "LB",
        ),
    ] {
        let run = run_of(&[text, BLOCKS], "check", "--limit 1ms");
        assert_eq!(run.code, Some(3), "{text}\n{}{}", run.stdout, run.stderr);
        assert!(run.stdout.contains(what), "{}", run.stdout);
    }
    let whole = "FUNCTION_BLOCK B METHOD m END_METHOD METHOD n Op1(); END_METHOD END_FUNCTION_BLOCK
        PROGRAM p VAR f : B; END_VAR f(); f.m(); f.n(); END_PROGRAM";
    let run = run_of(&[whole, BLOCKS], "check", "--limit 1ms");
    assert_eq!(run.code, Some(0), "{}", run.stdout);
}

#[test]
fn what_needs_itself_is_refused() {
    refused_case("constant-cycle.st");
    let chain = (0..20_000).map(|at| format!("c{at} : INT := c{} + 1;", (at + 1) % 20_000));
    let chain = format!("VAR_GLOBAL CONSTANT {} END_VAR", chain.collect::<String>());
    let doubling = (0..60).map(|at| format!("d{at} : INT := d{0} + d{0};", at + 1));
    let doubling =
        format!("VAR_GLOBAL CONSTANT {} d60 : INT := d0; END_VAR", doubling.collect::<String>());
    let nested = (0..60).map(|at| format!("s{at} : STRUCT a, b : s{}; END_STRUCT;", (at + 1) % 60));
    let nested = format!("TYPE {} END_TYPE", nested.collect::<String>());
    let extended =
        (1..2000).map(|at| format!("FUNCTION_BLOCK b{at} EXTENDS b{} END_FUNCTION_BLOCK ", at - 1));
    let extended = format!("FUNCTION_BLOCK b0 END_FUNCTION_BLOCK {}", extended.collect::<String>());
    for circle in [
        "VAR_GLOBAL CONSTANT A : INT := B; B : INT := A; END_VAR",
        "TYPE t : (a := b, b := a); END_TYPE",
        "TYPE t : (a := u#b, c); u : (b := t#a, d); END_TYPE",
        "FUNCTION f : INT VAR CONSTANT N : INT := N; END_VAR END_FUNCTION",
        "FUNCTION f : INT VAR CONSTANT N : INT := M; M : INT := N + 1; END_VAR END_FUNCTION",
        "FUNCTION_BLOCK A EXTENDS A END_FUNCTION_BLOCK",
        "FUNCTION_BLOCK A EXTENDS B END_FUNCTION_BLOCK FUNCTION_BLOCK B EXTENDS C END_FUNCTION_BLOCK
         FUNCTION_BLOCK C EXTENDS A END_FUNCTION_BLOCK",
        "INTERFACE I EXTENDS J END_INTERFACE INTERFACE J EXTENDS I END_INTERFACE",
        "FUNCTION_BLOCK A VAR a : ARRAY[0..1] OF B; END_VAR END_FUNCTION_BLOCK
         FUNCTION_BLOCK B VAR a : A; END_VAR END_FUNCTION_BLOCK",
        "TYPE t EXTENDS t : STRUCT x : INT; END_STRUCT; END_TYPE",
        "TYPE t EXTENDS u : STRUCT x : INT; END_STRUCT; u EXTENDS t : STRUCT y : INT; END_STRUCT; END_TYPE",
        "TYPE t : u; u : t; END_TYPE",
        "TYPE t : STRUCT x : t; END_STRUCT; END_TYPE",
        &extended,
        &chain,
        &doubling,
        &nested,
    ] {
        refused(&format!("PROGRAM p Op1(); END_PROGRAM {circle}"));
    }
    // Through a pointer, a structure may lead to another one of its type.
    let linked = "TYPE t : STRUCT x : INT; next : POINTER TO t; END_STRUCT; END_TYPE
        PROGRAM p VAR t1 : t; END_VAR t1.x := 1; Op1(); END_PROGRAM";
    assert_eq!(bound(linked), 1000);
}

#[test]
fn one_input_has_one_value_under_all_its_names() {
    let run = scanbound("attack", &format!("check same-input-twice.st {FACTS} --limit 1us"));
    assert_eq!(run.code, Some(0), "{}", run.stdout);
    let report = audit("attack", &format!("same-input-twice.st {FACTS}"));
    assert_eq!((upper_ns(&report), lower_ns(&report)), (0, 0));
    let exact = |text: &str| {
        let report = report_trusting_all(text);
        (upper_ns(&report), lower_ns(&report))
    };
    for (text, most) in [
        (
            "PROGRAM p VAR a AT %IX0.0 : BOOL; b AT %IX0.0 : BOOL; END_VAR IF a AND b THEN Op4(); END_IF; END_PROGRAM",
            4000,
        ),
        (
            "PROGRAM p VAR a AT %IX0.0 : BOOL; b AT %IX0.1 : BOOL; END_VAR IF NOT a AND b THEN Op4(); END_IF; END_PROGRAM",
            4000,
        ),
        (
            "PROGRAM p VAR a AT %IX0.0 : BOOL; END_VAR IF NOT a AND %IX0.0 THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
        (
            "PROGRAM p VAR a AT %IW4 : INT; b AT %IW4 : WORD; END_VAR IF a < 0 AND b < 16#8000 THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
        (
            "PROGRAM p VAR a AT %IB4 : SINT; b AT %IB4 : BYTE; END_VAR IF a < 0 AND b < 16#80 THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
        (
            "PROGRAM p VAR a AT %IW0 : ARRAY[0..3] OF INT; b AT %IW0 : INT; END_VAR IF a[0] <> b THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
        (
            "PROGRAM p VAR a AT %IX1.0 : BOOL; b AT %IX1.0 : BOOL; END_VAR a := b; IF b <> a THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
        (
            "VAR_GLOBAL g AT %IX0.0 : BOOL; END_VAR PROGRAM p VAR a AT %IX0.0 : BOOL; END_VAR IF g <> a THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
        (
            "PROGRAM p VAR a AT %IB0 : USINT; b AT %IB1 : SINT; END_VAR IF a > 255 OR b > 127 OR b < -128 THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
        (
            "PROGRAM p VAR a AT %IB0 : USINT; b AT %IB1 : SINT; END_VAR IF a = 255 AND b = -128 THEN Op4(); END_IF; END_PROGRAM",
            4000,
        ),
        (
            "PROGRAM p VAR a AT %IX0.0 : BOOL; b AT %IX0.0 : BOOL; c AT %IX0.0 : BOOL; END_VAR IF a <> b OR b <> c THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
    ] {
        assert_eq!(exact(text), (most, most), "{text}");
    }
    // Memory and outputs, too: an HMI may have written them, under all their names at once.
    for (text, most) in [
        (
            "PROGRAM p VAR a AT %MX0.0 : BOOL; b AT %MX0.0 : BOOL; END_VAR IF NOT a AND b THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
        (
            "PROGRAM p VAR a AT %MX0.0 : BOOL; b AT %MX0.0 : BOOL; END_VAR IF a AND b THEN Op4(); END_IF; END_PROGRAM",
            4000,
        ),
        (
            "PROGRAM p VAR a AT %MX0.0 : BOOL; b AT %MX0.0 : BOOL; END_VAR a := TRUE; IF NOT b THEN Op4(); END_IF; END_PROGRAM",
            0,
        ),
        (
            "PROGRAM p VAR a AT %QW0 : WORD; b AT %QW0 : INT; END_VAR IF b < 0 AND a < 16#8000 THEN Op4(); END_IF; a := a + 1; END_PROGRAM",
            0,
        ),
    ] {
        for trust in ["none", "counts", "all"] {
            let run = run_of(&[text, BLOCKS], "audit", &format!("--format json --trust {trust}"));
            assert_eq!(run.code, Some(0), "{text}\n{}", run.stderr);
            let report = run.json();
            assert_eq!((upper_ns(&report), lower_ns(&report)), (most, most), "{trust}: {text}");
        }
    }
    let two = "PROGRAM p VAR a AT %IX0.0 : BOOL; m : BOOL; END_VAR g := a; END_PROGRAM
        PROGRAM q VAR a AT %IX0.0 : BOOL; END_VAR IF g <> a THEN Op4(); END_IF; END_PROGRAM VAR_GLOBAL g : BOOL; END_VAR";
    assert_eq!(exact(two), (0, 0));
    // On some controllers, addresses of different sizes have memories of their own.
    for text in [
        "PROGRAM p VAR a AT %IX0.3 : BOOL; b AT %IB0 : BYTE; END_VAR IF NOT a AND b.3 THEN Op4(); END_IF; END_PROGRAM",
        "PROGRAM p VAR a AT %IX0.3 : BOOL; b AT %IB0 : BYTE; END_VAR IF a AND b < 8 THEN Op4(); END_IF; END_PROGRAM",
        "PROGRAM p VAR a AT %IX0.3 : BOOL; b AT %IB0 : BYTE; END_VAR IF a AND b < 9 THEN Op4(); END_IF; END_PROGRAM",
        "PROGRAM p VAR a AT %MB0 : BYTE; b AT %MX0.0 : BOOL; END_VAR IF NOT b AND a.0 THEN Op4(); END_IF; END_PROGRAM",
        "PROGRAM p VAR a AT %IX0.0 : BOOL; b AT %IW0 : WORD; END_VAR IF a AND NOT b.0 AND NOT b.8 THEN Op4(); END_IF; END_PROGRAM",
    ] {
        assert_eq!(exact(text), (4000, 0), "{text}");
    }
    // Which byte of a word comes first, and whether %IW1 is the bytes 1 and 2 or 2 and 3, differs by controller:
    // nothing is refuted by one of them alone.
    for text in [
        "PROGRAM p VAR a AT %IX0.0 : BOOL; b AT %IW0 : WORD; END_VAR IF NOT a AND b.0 THEN Op4(); END_IF; END_PROGRAM",
        "PROGRAM p VAR a AT %IX2.0 : BOOL; b AT %IW1 : WORD; END_VAR IF NOT a AND b.0 THEN Op4(); END_IF; END_PROGRAM",
        "PROGRAM p VAR a AT %IX0.0 : BOOL; b AT %ID0 : DWORD; END_VAR IF NOT a AND b.0 THEN Op4(); END_IF; END_PROGRAM",
        "PROGRAM p VAR a AT %IB0 : BYTE; b AT %IW0 : WORD; END_VAR IF a = 0 AND b = 1 THEN Op4(); END_IF; END_PROGRAM",
    ] {
        assert_eq!(exact(text).1, 0, "{text}");
    }
    let told = refused(
        "TYPE t : STRUCT x : BOOL; y : INT; END_STRUCT; END_TYPE
         PROGRAM p VAR a AT %IB0 : t; b AT %IX0.0 : BOOL; END_VAR IF b THEN Op4(); END_IF; END_PROGRAM",
    );
    assert!(told.contains("shares bits"), "{told}");
}

/// The report on a program in which [`BLOCKS`] are declared, of which all that it writes is trusted.
fn report_trusting_all(text: &str) -> Value {
    let run = run_of(&[text, BLOCKS], "audit", "--format json --trust all");
    assert_eq!(run.code, Some(0), "{text}\n{}{}", run.stdout, run.stderr);
    run.json()
}

#[test]
fn a_variable_of_8_bits_begins_with_no_more() {
    for (of, never, may) in [
        ("BYTE", "v > 255", "v = 255"),
        ("USINT", "v > 255", "v = 255"),
        ("SINT", "v > 127 OR v < -128", "v = -128"),
    ] {
        for (place, name) in [
            ("PROGRAM p VAR", "v"),
            ("VAR_GLOBAL", "v"),
            ("PROGRAM p VAR s : t; END_VAR VAR", "s.v"),
        ] {
            for (when, most) in [(never, 0), (may, 4000)] {
                let test = when.replace('v', name);
                let program = if place.starts_with("VAR_GLOBAL") { "PROGRAM p" } else { "" };
                let text = format!(
                    "TYPE t : STRUCT v : {of}; END_STRUCT; END_TYPE
                     {place} v : {of}; END_VAR {program} IF {test} THEN Op4(); END_IF; END_PROGRAM"
                );
                let run = run_of(&[&text, BLOCKS], "audit", "--format json --trust none");
                assert_eq!(run.code, Some(0), "{text}\n{}", run.stderr);
                let report = run.json();
                assert_eq!((upper_ns(&report), lower_ns(&report)), (most, most), "{text}");
            }
        }
    }
}

#[test]
fn many_variables_are_read_in_time_that_grows_with_their_number() {
    // Reading each by going through all took minutes: the limit on time would run out here.
    let all: String = (0..100_000).map(|at| format!("v{at} : INT := {}; ", at % 9)).collect();
    let text = format!("PROGRAM p VAR {all} END_VAR v5 := v6; Op1(); END_PROGRAM");
    let run = run_of(&[&text, BLOCKS], "audit", "--format json --time-limit 60s");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(upper_ns(&run.json()), 1000);
}

//! What variables and constants hold, and scans that a controller does not finish.

use super::names::{BLOCKS, run_of};
use super::{audit, lower_ns, scanbound, upper_ns};
use crate::command::binary;
use serde_json::Value;

/// The report on a program in which [`BLOCKS`] are declared.
fn report(text: &str, options: &str) -> Value {
    let run = run_of(&[text, BLOCKS], "audit", &format!("{options} --format json"));
    assert_eq!(run.code, Some(0), "{text}\n{}{}", run.stdout, run.stderr);
    run.json()
}

/// Both bounds in microseconds, and whether they are called exact.
fn bounds(text: &str, options: &str) -> (u64, u64, bool) {
    let report = report(text, options);
    let exact = report["scan"]["exact"].as_bool().expect("a truth value");
    (lower_ns(&report) / 1000, upper_ns(&report) / 1000, exact)
}

fn program(variables: &str, body: &str) -> String {
    format!("PROGRAM p {variables} {body} END_PROGRAM")
}

#[test]
fn times_beyond_12_days_are_in_any_order() {
    let upper = |body: &str, condition: &str| {
        let variables = "VAR a AT %IX0.0 : BOOL; w AT %IW2 : INT; x, y : TIME; t : TON; END_VAR";
        let body = format!("{body} IF {condition} THEN Op4(); END_IF;");
        bounds(&program(variables, &body), "").1
    };
    let edge = "T#12d10h15m41s823ms";
    let above = format!("y > {edge}");
    for (body, condition) in [
        ("x := T#10d; y := x + x;", above.as_str()),
        ("y := T#20d;", &above),
        ("t(IN := a, PT := T#20d); y := t.ET;", &above),
        ("x := T#1h * w; y := x;", &above),
        ("y := T#10d; y := y + y; x := T#12d10h15m41s823ms;", "y > x"),
        ("x := T#12d10h15m41s823ms; y := x + T#1ms;", "y > x"),
        ("x := T#10d; x := x + x; y := x + T#1d;", "x > T#12d10h15m41s822ms AND y > x"),
        ("x := T#10d; x := x + x; y := x - T#1ms;", &above),
        ("x := T#0s - T#10d; y := x + x;", "y < T#0s - T#12d10h15m41s824ms"),
        ("x := T#0s - T#10d; y := x + x;", "NOT (y < T#0s - T#12d10h15m41s824ms)"),
        ("x := T#10d; x := x - (T#0s - T#10d); y := x;", &above),
        ("t(IN := a, PT := T#20d);", "t.ET > T#12d10h15m41s822ms AND NOT t.Q"),
        (
            "x := T#0s - T#10d; x := x + x; y := ABS(x);",
            "x < T#0s - T#12d10h15m41s823ms AND y > T#0s",
        ),
    ] {
        assert_eq!(upper(body, condition), 4, "{body} {condition}");
    }
    // What shares the bits of a time is refused, as controllers differ in these.
    let shared = program(
        "VAR d AT %MD0 : DWORD; s AT %MD0 : TIME; END_VAR",
        "d := 16#F0000000; IF s > T#1d THEN Op4(); END_IF;",
    );
    assert_eq!(run_of(&[&shared, BLOCKS], "audit", "").code, Some(2));
    assert_eq!(upper("x := T#5s; y := x + x;", "y <> T#10s"), 0);
    assert_eq!(upper("x := T#5s; y := x - T#2s;", "y > x"), 0);
    assert_eq!(upper("t(IN := a, PT := T#5s); y := t.ET;", "y > T#5s"), 0);
}

#[test]
fn operands_that_are_always_skipped_cost_nothing_then() {
    let audited =
        |body: &str| bounds(&program("VAR n : BOOL; a AT %IX0.0 : BOOL; END_VAR", body), "");
    // The call takes 1 us, and is made only where `a` decides nothing.
    assert_eq!(audited("n := a AND_THEN One(1) = 1; IF NOT a THEN Op4(); END_IF;"), (4, 4, true));
    assert_eq!(audited("n := a OR_ELSE One(1) = 1; IF a THEN Op4(); END_IF;"), (4, 4, true));
    assert_eq!(audited("IF One(0) = 1 AND_THEN One(1) = 1 THEN ; END_IF;"), (1, 1, true));
    assert_eq!(audited("n := FALSE; IF n AND_THEN One(1) = 1 THEN ; END_IF;"), (0, 0, true));
}

#[test]
fn types_that_give_values_to_instances_do_so() {
    let block = "FUNCTION_BLOCK B VAR_INPUT k : INT; END_VAR VAR i : INT; END_VAR FOR i := 1 TO k DO Op4(); END_FOR; k := k; END_FUNCTION_BLOCK TYPE T : ARRAY[0..1] OF B := [(k := 50), (k := 60)]; END_TYPE ";
    for trust in ["counts", "all"] {
        let text = format!("{block}{}", program("VAR all : T; END_VAR", "all[0]();"));
        let run = run_of(&[&text, BLOCKS], "check", &format!("--limit 1us --trust {trust}"));
        assert_ne!(run.code, Some(0), "{trust}: {}", run.stdout);
    }
}

#[test]
fn constants_hold_their_values_in_every_scan() {
    let types = "TYPE e : (off, on := 5, last); n : INT := 4; s : STRUCT a : INT := 2; b : e; c : ARRAY[0..1] OF INT; END_STRUCT; END_TYPE ";
    for (declared, never) in [
        ("t : TIME := T#5s;", "t <> T#5s"),
        ("m : TIME := T#5s; t : TIME := m;", "t <> T#5s"),
        ("r : REAL := -1.5;", "r > -1.0"),
        ("r : REAL := 3;", "r <> 3.0"),
        ("m : INT := 3; k : INT := m + 1;", "k <> 4"),
        ("b : BOOL := NOT FALSE;", "NOT b"),
        ("c : e;", "c <> off"),
        ("c : e := last;", "c <> last"),
        ("k : n;", "k <> 4"),
        ("k : INT(2..9) := 3;", "k <> 3"),
        ("a : ARRAY[1..3] OF INT := [1, 2];", "a[1] <> 1 OR a[2] <> 2 OR a[3] <> 0"),
        (
            "m : INT := 2; a : ARRAY[1..3] OF INT := [2(7), 8];",
            "a[1] <> 7 OR a[2] <> 7 OR a[3] <> 8",
        ),
        ("a : ARRAY[0..1, 0..1] OF INT := [1, 2, 3];", "a[0,1] <> 2 OR a[1,0] <> 3 OR a[1,1] <> 0"),
        ("v : s;", "v.a <> 2 OR v.b <> off"),
        ("v : s := (b := on, c := [7]);", "v.a <> 2 OR v.b <> on OR v.c[0] <> 7 OR v.c[1] <> 0"),
        ("v : ARRAY[0..1] OF s := [(a := 9)];", "v[0].a <> 9 OR v[1].a <> 2"),
    ] {
        let body = format!("IF {never} THEN Op4(); END_IF; Op1();");
        let own = types.to_owned() + &program(&format!("VAR CONSTANT {declared} END_VAR"), &body);
        let global = format!(
            "{types} VAR_GLOBAL CONSTANT {declared} END_VAR {}",
            program("VAR x : INT; END_VAR", &body)
        );
        for text in [own, global] {
            for trust in ["none", "counts", "all"] {
                let found = bounds(&text, &format!("--trust {trust}"));
                assert_eq!(found, (1, 1, true), "{text} --trust {trust}");
            }
        }
    }
}

#[test]
fn no_scan_rests_on_the_value_of_a_constant_that_is_not_worked_out() {
    for declared in [
        "k : INT := MAX(3, 4);",
        "a : ARRAY[1..2] OF INT := [MAX(3, 4), 2]; k : INT := 4;",
        "k : INT := ABS(-4);",
    ] {
        let read = if declared.starts_with('a') { "a[1]" } else { "k" };
        let body = format!("IF {read} <> 4 THEN Op4(); END_IF;");
        let text = program(&format!("VAR CONSTANT {declared} END_VAR"), &body);
        for trust in ["none", "all"] {
            assert_eq!(bounds(&text, &format!("--trust {trust}")), (0, 4, false), "{text}");
        }
        let run = run_of(&[&text, BLOCKS], "check", "--limit 1us");
        assert_eq!(run.code, Some(3), "{}", run.stdout);
        assert!(report(&text, "").to_string().contains("is not known: it may be"), "{text}");
    }
}

#[test]
fn runs_begin_with_the_values_that_are_declared() {
    let types = "TYPE e : (off, on := 5, last); n : INT := 4; s : STRUCT a : INT := 2; b : e; c : BOOL := TRUE; END_STRUCT; END_TYPE ";
    // What the variable is assigned, which is what it begins with, and what it never holds.
    for (declared, same, never) in [
        ("v : s;", "v.a := 2;", "v.a <> 2"),
        ("v : s := (a := 7);", "v.a := 7;", "v.a <> 7"),
        ("v : s := (b := on);", "v.b := on;", "v.b = last"),
        ("v : n;", "v := 4;", "v <> 4"),
        ("v : INT(0..9) := 3;", "v := 3;", "v <> 3"),
        ("v : e := last;", "v := last;", "v <> last"),
        ("v : ARRAY[0..2] OF INT := [3(6)];", "v[1] := 6;", "v[1] <> 6"),
    ] {
        for section in ["VAR", "VAR RETAIN"] {
            let body = format!("IF {never} THEN Op4(); END_IF; {same} Op1();");
            let text = types.to_owned() + &program(&format!("{section} {declared} END_VAR"), &body);
            assert_eq!(bounds(&text, "--trust all"), (1, 1, true), "{text}");
            assert_eq!(report(&text, "--trust all")["scan"]["lower_kind"], "reached", "{text}");
            // Others may write it otherwise.
            assert_eq!(bounds(&text, "--trust none").1, 5, "{text}");
        }
    }
    // Whether a subrange begins with 0 or with its lowest value, controllers differ.
    let text = program("VAR v : INT(2..9); END_VAR", "IF v <> 2 THEN Op4(); END_IF; v := 2;");
    let report = report(&text, "--trust all");
    assert_eq!(upper_ns(&report), 4000);
    assert_ne!(report["scan"]["lower_kind"], "reached");
}

#[test]
fn a_scan_that_writes_outside_an_array_is_none() {
    let array = "VAR h : ARRAY[1..3] OF INT; g : ARRAY[0..1, 0..2] OF BOOL; i AT %IW0 : INT; x : INT; END_VAR";
    for body in [
        "h[i] := 1; IF i > 3 THEN Op4(); END_IF;",
        "x := h[i]; IF i < 1 THEN Op4(); END_IF;",
        "g[1, i] := TRUE; IF i > 2 THEN Op4(); END_IF;",
        "g[i, 0] := TRUE; IF i = 2 THEN Op4(); END_IF;",
        "IF g[i, i] AND i > 1 THEN Op4(); END_IF;",
        "h[i + 1] := 1; IF i = 3 THEN Op4(); END_IF;",
    ] {
        for trust in ["none", "all"] {
            let text = program(array, body);
            let found = bounds(&text, &format!("--trust {trust}"));
            assert_eq!((found.0, found.2), (0, found.1 == 0), "{body}");
            // Where the controller goes on, memory is destroyed.
            let run = run_of(&[&text, BLOCKS], "check", &format!("--limit 1us --trust {trust}"));
            assert_ne!(run.code, Some(1), "{body}: {}", run.stdout);
        }
    }
    // No scan at all is possible, whichever way it takes.
    let input = "VAR i AT %IW0 : INT; a AT %IX9.0 : BOOL; b AT %IX9.1 : BOOL; h : ARRAY[2..2] OF INT; x : INT; END_VAR";
    let body = "x := i MOD 2; IF a THEN Op4(); x := x * x; END_IF; IF b THEN Op1(); END_IF; h[x] := 1; IF a OR b THEN Op4(); END_IF; IF i > 7 THEN Op1(); END_IF;";
    let (lower, upper, exact) = bounds(&program(input, body), "--trust all");
    assert_eq!((lower, upper, exact), (0, 10, false));
    let inside = program(array, "h[i] := 1; IF i = 3 THEN Op4(); END_IF;");
    assert_eq!(bounds(&inside, "--trust all"), (4, 4, true));
}

#[test]
fn the_lowest_value_divided_by_minus_one_is_no_scan() {
    for (of, lowest) in [("DINT", "-2147483648"), ("INT", "-32768"), ("SINT", "-128")] {
        let address = if of == "DINT" { "%ID0" } else { "%IW0" };
        let address = if of == "SINT" { "%IB0" } else { address };
        let variables = format!(
            "VAR x AT {address} : {of}; y : {of}; END_VAR VAR CONSTANT m : {of} := -1; END_VAR"
        );
        for body in ["y := x / -1;", "y := x / m;", "y := x MOD -1;"] {
            let text = program(&variables, &format!("{body} IF x = {lowest} THEN Op4(); END_IF;"));
            assert_eq!(bounds(&text, "--trust all").0, 0, "{text}");
        }
        let text =
            program(&variables, &format!("y := x / -1; IF x = {lowest} + 1 THEN Op4(); END_IF;"));
        assert_eq!(bounds(&text, "--trust all"), (4, 4, true), "{text}");
    }
}

#[test]
fn a_controller_that_stops_in_its_first_scan_makes_no_other() {
    let report = audit(
        "attack",
        "null-interface-reached.st --table zero.csv --facts calls.toml --trust all",
    );
    assert_eq!((lower_ns(&report), upper_ns(&report)), (0, 1000));
    assert_eq!(report["scan"]["exact"], false);
    let between = report["scan"]["stands_between"].as_str().expect("a reason");
    assert!(between.contains("stops the CPU in every scan"), "{between}");
    let run = scanbound(
        "attack",
        "check null-interface-reached.st --table zero.csv --facts calls.toml --trust all --limit 500ns",
    );
    assert_eq!(run.code, Some(3), "{}", run.stdout);
    for (variables, body) in [
        ("p : POINTER TO INT; x : INT;", "p^ := 1; Op1(); p := ADR(x);"),
        ("p : REFERENCE TO INT; x : INT;", "p := 1; Op1(); p REF= x;"),
        ("p : ARRAY[0..1] OF POINTER TO INT; x : INT;", "p[0]^ := 1; Op1(); p[0] := ADR(x);"),
        ("n : INT; x : INT;", "x := 3 / n; Op1(); n := 1;"),
    ] {
        let text = program(&format!("VAR {variables} END_VAR"), body);
        let (lower, _, exact) = bounds(&text, "--trust all");
        assert_eq!((lower, exact), (0, false), "{text}");
    }
    // One that comes to something first is none of these.
    let good = program("VAR p : POINTER TO INT; x : INT; END_VAR", "p := ADR(x); p^ := 1; Op1();");
    assert_eq!(bounds(&good, "--trust all"), (1, 1, true));
}

#[test]
fn a_run_that_is_not_followed_to_its_end_is_not_reached_where_an_error_may_come() {
    // What the function's own structure begins with is not followed, and the division always fails.
    let text = "TYPE s : STRUCT m : ARRAY[0..1] OF INT; END_STRUCT; END_TYPE
        FUNCTION f : INT VAR l : s := (m := [0, 0]); END_VAR f := 1 / l.m[0]; END_FUNCTION
        PROGRAM p VAR x : INT; END_VAR Op1(); x := f(); END_PROGRAM";
    assert_ne!(report(text, "--trust all")["scan"]["lower_kind"], "reached");
}

#[test]
fn variables_of_lists_with_names_are_apart() {
    let list = "VAR_GLOBAL x : INT; END_VAR";
    let other = "\nVAR_GLOBAL x : INT := 3; END_VAR";
    let uses = program("", "IF \"0\".x <> 0 THEN Op4(); END_IF;").replace("\"0\"", "a");
    let directory = tempfile::tempdir().expect("a directory");
    let run = |files: &[(&str, &str)]| {
        for (name, text) in files {
            std::fs::write(directory.path().join(name), text).expect("a file");
        }
        let files = files.iter().map(|(name, _)| directory.path().join(name));
        let output = binary().arg("audit").args(files).output().expect("the command runs");
        super::Run::of(&output)
    };
    let blocks = ("blocks.st", BLOCKS);
    let both = run(&[("a.st", list), ("b.st", other), ("p.st", &uses), blocks]);
    assert_eq!(both.code, Some(0), "{}", both.stderr);
    let bare = program("", "IF x <> 0 THEN Op4(); END_IF;");
    let unclear = run(&[("a.st", list), ("b.st", other), ("p.st", &bare), blocks]);
    assert_eq!(unclear.code, Some(2), "{}", unclear.stdout);
    assert!(unclear.stderr.contains("X may mean"), "{}", unclear.stderr);
}

#[test]
fn a_block_of_a_library_is_not_the_one_of_the_project() {
    let own = "\nFUNCTION_BLOCK TON VAR_INPUT IN : BOOL; END_VAR Op4(); END_FUNCTION_BLOCK";
    for of in ["Standard.TON", "Standard . ton"] {
        let text = program(&format!("VAR t : {of}; END_VAR"), "t();") + own;
        let run = run_of(&[&text, BLOCKS], "audit", "");
        assert_eq!(run.code, Some(2), "{}", run.stdout);
        assert!(run.stderr.contains("of a library"), "{}", run.stderr);
    }
    let text = program("VAR t : TON; END_VAR", "t();") + own;
    assert_eq!(bounds(&text, ""), (4, 4, true));
    let text = program("VAR t : Standard.TON; END_VAR", "t();");
    assert_eq!(bounds(&text, ""), (0, 0, true));
}

#[test]
fn measured_times_lie_between_milliseconds_too() {
    let upper = |body: &str, condition: &str| {
        let variables = "VAR a AT %IX0.0 : BOOL; x, y : TIME; t, u : TON; END_VAR";
        let body = format!(
            "t(IN := a, PT := T#5s); u(IN := a, PT := T#5s); {body} IF {condition} THEN Op4(); END_IF;"
        );
        bounds(&program(variables, &body), "").1
    };
    let within = |time: &str| format!("{time} > T#1ms AND {time} < T#2ms");
    for (body, condition) in [
        ("", within("t.ET")),
        ("x := t.ET; y := x;", within("y")),
        ("x := t.ET + T#3ms;", "x > T#4ms AND x < T#5ms".to_owned()),
        ("x := T#3ms - t.ET;", within("x")),
        ("", format!("{} AND {} AND t.ET < u.ET", within("t.ET"), within("u.ET"))),
        ("x := t.ET + u.ET;", format!("{} AND {} AND x > T#3ms", within("t.ET"), within("u.ET"))),
        ("x := t.ET + u.ET;", format!("{} AND {} AND x < T#3ms", within("t.ET"), within("u.ET"))),
    ] {
        assert_eq!(upper(body, &condition), 4, "{body} {condition}");
    }
    for (body, condition) in [
        ("", "t.ET > T#2ms AND t.ET < T#2ms"),
        ("", "NOT t.Q AND t.ET >= T#5s"),
        ("x := T#7ms; y := x + T#3ms;", "y <> T#10ms"),
        ("x := T#7ms;", "x > T#6ms AND x < T#7ms"),
    ] {
        assert_eq!(upper(body, condition), 0, "{body} {condition}");
    }
}

#[test]
fn a_property_behind_and_then_is_read_only_where_its_left_side_does_not_decide() {
    let block = "FUNCTION_BLOCK B VAR c : INT; END_VAR
        PROPERTY PUBLIC P : BOOL GET c := c + 1; P := TRUE; END_GET END_PROPERTY
        PROPERTY PUBLIC N : INT GET c := c + 1; N := 5; END_GET END_PROPERTY
        END_FUNCTION_BLOCK";
    let upper = |value: &str, condition: &str| {
        let body = format!("b.c := 0; x := {value}; IF {condition} THEN Op4(); END_IF;");
        let text = program("VAR a AT %IX0.0 : BOOL; x : BOOL; b : B; END_VAR", &body);
        bounds(&format!("{text} {block}"), "").1
    };
    for getter in ["b.P", "NOT b.P", "(b.N > 3)"] {
        let (and, or) = (format!("a AND_THEN {getter}"), format!("a OR_ELSE {getter}"));
        assert_eq!(upper(&and, "b.c = 1 AND NOT a"), 0, "{getter}");
        assert_eq!(upper(&and, "b.c = 0 AND a"), 0, "{getter}");
        assert_eq!(upper(&and, "b.c = 1 AND a"), 4, "{getter}");
        assert_eq!(upper(&or, "b.c = 1 AND a"), 0, "{getter}");
        assert_eq!(upper(&or, "b.c = 1 AND NOT a"), 4, "{getter}");
        // AND may leave out its right side.
        let plain = format!("a AND {getter}");
        assert_eq!(upper(&plain, "b.c = 1 AND NOT a"), 4, "{getter}");
        assert_eq!(upper(&plain, "b.c = 0 AND NOT a"), 4, "{getter}");
        assert_eq!(upper(&plain, "b.c = 0 AND a"), 0, "{getter}");
    }
}

#[test]
fn a_word_that_is_compared_for_a_bit_starts_with_what_every_scan_leaves_in_it() {
    for body in [
        "n := n + 6; b := n > 10; IF b THEN Op4(); END_IF; n := 0;",
        "n := n + 6; i := SEL(n > 10, 0, 1); IF i = 1 THEN Op4(); END_IF; n := 0;",
        "n := n + 6; b := SEL(n > 10, FALSE, TRUE); IF b THEN Op4(); END_IF; n := 0;",
        "n := n + 6; b := n > 11; IF b THEN Op4(); END_IF; n := 5;",
        "r := r + 6.0; b := r > 10.0; IF b THEN Op4(); END_IF; r := 1.5;",
        "\nLD n\nADD 6\nST n\nGT 10\nJMPCN e\nCAL Op4()\ne:\nLD 0\nST n\n",
    ] {
        let text = program("VAR n, i : INT; b : BOOL; r : REAL; END_VAR", body);
        assert_eq!(bounds(&text, "--trust all"), (0, 0, true), "{text}");
        assert_eq!(bounds(&text, "--trust none").1, 4, "{text}");
    }
}

#[test]
fn a_copy_of_a_time_begins_with_what_some_scan_leaves() {
    // The output of TOF is off once ET is PT. The program never writes the upper word of ET other than 0.
    let more = "VAR a AT %IX0.0 : BOOL; t : TOF; q : BOOL; e : TIME; END_VAR";
    let lower = |least: &str| {
        let body = format!(
            "IF q AND e >= T#{least} THEN Op4(); END_IF; t(IN := a, PT := T#1s); q := t.Q; e := t.ET;"
        );
        bounds(&program(more, &body), "--trust all").0
    };
    assert_eq!((lower("1s"), lower("40s")), (0, 0));
}

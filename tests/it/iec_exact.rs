//! What is followed exactly of IEC 61131-3: that it is, that the report says so, and that it says what is not.

use scanbound::audit::{Audit, Exactness, Failure, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// An audit with a table by which a store takes a microsecond, and nothing else anything.
pub(crate) fn audited(name: &str, text: &str) -> Result<Audit, Vec<Code>> {
    trusting(Trust::None, name, text)
}

fn trusting(trust: Trust, name: &str, text: &str) -> Result<Audit, Vec<Code>> {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += "ST,1,1\nTON,100,100\n@end,0,\n";
    let table =
        Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table;
    let inputs = [Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request {
        table: Some(&table),
        trust,
        dialect: name.ends_with(".st").then_some("iec-text"),
        ..Request::new(&inputs, &facts)
    };
    match audit(&request) {
        Ok(found) => Ok(found),
        Err(Failure::Input(faults)) => Err(faults.into_iter().map(|fault| fault.code).collect()),
        Err(other) => panic!("{other:?}"),
    }
}

fn program(variables: &str, body: &str) -> Audit {
    let text = format!("PROGRAM main VAR x, y : BOOL; {variables} END_VAR {body} END_PROGRAM");
    audited("main.st", &text).unwrap_or_else(|faults| panic!("{body}: {faults:?}"))
}

fn exactness(found: &Audit) -> &Exactness {
    found.exactness.as_ref().expect("statements are told")
}

pub(crate) fn micros(found: &Audit) -> u64 {
    found.bound.upper.0.div_ceil(Picos(1_000_000).0)
}

/// Whether `x` may be set where a condition holds behind some statements. They store as often in every scan.
fn may_be(variables: &str, before: &str, condition: &str) -> bool {
    let without = micros(&program(variables, before));
    let found = program(variables, &format!("{before} IF {condition} THEN x := TRUE; END_IF"));
    match micros(&found) - without {
        0 => false,
        1 => true,
        more => panic!("{more}"),
    }
}

#[test]
fn whole_numbers_are_followed_exactly() {
    let all = "n, m : INT; d : DINT; u, v : UINT; w : WORD; b : BYTE; s : SINT;";
    for (before, never, at_times) in [
        ("n := LIMIT(-100, n, 100); m := n * 2;", "m = 7", "m = 8"),
        ("n := LIMIT(-100, n, 100); m := n * n;", "m = 3", "m = 9"),
        ("v := LIMIT(0, v, 255); u := v * v;", "u = 2", "u = 16#E100"),
        ("d := LIMIT(0, d, 9); d := d * 20000;", "d = 1", "d = 180000"),
        ("m := n / 10;", "m > 3276", "m = -3276"),
        ("m := n / -10;", "m < -3276", "m = 3276"),
        ("m := n MOD 8;", "m = 8 OR m = -8", "m = -7"),
        ("u := v / 3; v := v - u * 3;", "v > 2", "v = 2"),
        ("d := d / 100000;", "d > 21474", "d = -21474"),
        ("s := LIMIT(-64, s, 63); s := s * 2;", "s = 3", "s = -128"),
        ("w := SHL(w, 4);", "w.0 OR w.3", "w.4"),
        ("w := SHR(w, 12);", "w > 15", "w = 15"),
        ("b := SHL(b, 7);", "b <> 0 AND b <> 128", "b = 128"),
        ("w := ROL(w AND 16#8001, 1);", "w.15 OR w.2", "w = 3"),
        ("w := UINT_TO_BCD_WORD(v MOD 100);", "w > 16#99 OR w = 16#1A", "w = 16#42"),
        ("n := n MOD 2; n := n * n; m := MUX(n, 4, 6);", "m = 5", "m = 6"),
        ("m := LIMIT(MX := 9, IN := n, MN := 3);", "m > 9 OR m < 3", "m = 7"),
        ("m := SEL(G := x, IN1 := 5, IN0 := 6);", "m < 5 OR m > 6", "m = 5"),
    ] {
        let found = program(all, before);
        let (statements, exact) = exactness(&found).total();
        assert_eq!(statements, exact, "{before}: {:?}", exactness(&found).constructs);
        assert!(!may_be(all, before, never), "{before} {never}");
        assert!(may_be(all, before, at_times), "{before} {at_times}");
    }
}

#[test]
fn what_the_language_leaves_open_may_be_anything() {
    for (before, condition) in [
        ("m := n / m;", "m = 1234"),
        ("w := SHL(w, u);", "w = 3 AND u = 16"),
        ("m := MUX(n, 4, 6);", "m = 5"),
        ("u := BCD_TO_UINT(w);", "u > 9999"),
        ("u := UINT_TO_BCD(v);", "u = 16#000A"),
        // A product that does not fit, and what shows how many bits are kept in the midst of an expression.
        ("m := n * 2;", "m = 7"),
        ("d := d * 3;", "d = 7"),
        ("m := n * 200 / 1000;", "m = 400"),
        ("d := n * 1000;", "d > 40000"),
        ("d := n + n;", "d > 40000"),
        ("d := INT_TO_DINT(n + n);", "d > 40000"),
        ("d := INT_TO_DINT(EN := TRUE, IN := n + n);", "d > 40000"),
        ("u := (u - v) / 2;", "u > 40000"),
        ("m := DIV(MUL(n, 200), 1000);", "m = 400"),
        ("u := SHR(u + v, 1);", "u > 40000"),
        ("w := SHL(1, u);", "u = 9 AND w = 0"),
        ("t := T#20d; t := t * 2;", "t < T#1d"),
        ("t := T#20d; t := t + t;", "t < T#1d"),
        ("a[n] := 1; m := a[n];", "m = 2"),
    ] {
        let all = "n, m : INT; d : DINT; u, v : UINT; w : WORD; t : TIME; a : ARRAY[1..3] OF INT;";
        assert!(may_be(all, before, condition), "{before} {condition}");
    }
}

#[test]
fn a_sum_that_does_not_fit_its_type_may_be_longer() {
    let all = "k : INT; n, d, c : DINT; s, r : SINT; m : INT; v : USINT; b : BYTE; w : WORD; u : UINT; l : LINT; \
        a : ARRAY[0..300] OF INT; t : BOOL;";
    for (before, condition) in [
        ("k := 20000; n := 0; CASE k + k OF 40000: n := 1; END_CASE", "n = 1"),
        ("v := 200; a[290] := 7; a[34] := 0;", "a[v + 90] = 7"),
        ("s := 100; m := LIMIT(0, s + s, 1000);", "m = 200"),
        ("s := 100; m := MAX(0, s + s);", "m = 200"),
        ("s := 100; m := SEL(TRUE, 0, s + s);", "m = 200"),
        ("s := 100; m := MOVE(s + s);", "m = 200"),
        ("s := 100; m := ADD(s, s);", "m = 200"),
        ("k := 32767;", "k + 1 > 0"),
        ("k := 32767;", "GT(k + 1, 0)"),
        ("k := -32768;", "-k > 0"),
        ("k := -32768;", "ABS(k) > 0"),
        ("k := -32768; m := -1;", "k / m > 0"),
        ("u := 1; m := 2;", "u - 2 < 0"),
        ("k := 300;", "k * k = 90000"),
        ("k := 20000; n := k + k;", "n = 40000"),
        ("k := 20000; n := (k + k) / 2;", "n = 20000"),
        ("k := 20000; m := (k + k) / 2;", "m = 20000"),
        ("k := 20000; m := (k + k) MOD 7;", "m = 2"),
        ("n := 2147483647; l := n + n; t := l > 3000000000;", "t"),
        ("n := 2147483647; l := MAX(n + n, 0); t := l > 3000000000;", "t"),
        ("b := 1;", "NOT b <> 254"),
        ("b := 1;", "NOT(b) <> 254"),
        ("w := 1;", "(NOT w) <> 65534"),
        ("b := 255;", "SHL(b, 4) = 16#FF0"),
        ("b := 255; w := SHL(b, 4);", "w = 16#FF0"),
        ("b := 255;", "(NOT b) <> 0"),
        // And what a compiler comes to that wraps at once.
        ("k := 32767;", "k + 1 < 0"),
        ("s := 100; m := LIMIT(-1000, s + s, 1000);", "m = -56"),
        ("b := 1;", "NOT b = 254"),
    ] {
        assert!(may_be(all, before, condition), "{before} {condition}");
    }
}

#[test]
fn a_sum_that_fits_its_type_is_followed_exactly() {
    let all = "k, m : INT; n : DINT; s : SINT; u : UINT; b : BYTE; w, z : WORD; a : ARRAY[0..9] OF INT; e : REAL;";
    for (before, never, at_times) in [
        ("k := LIMIT(0, k, 100);", "k + 1 > 101", "k + 1 > 100"),
        ("k := LIMIT(0, k, 100); m := LIMIT(0, m, 100);", "k + m > 200", "k + m = 200"),
        ("k := LIMIT(-100, k, 100); m := LIMIT(0, m, 100);", "k - m < -200", "k - m = -200"),
        ("k := LIMIT(-100, k, 100);", "100 - k > 200", "100 - k = 200"),
        ("k := LIMIT(-100, k, 100);", "-k > 100", "-k = 100"),
        ("u := LIMIT(5, u, 9);", "u - 5 > 4", "u - 5 = 4"),
        ("s := LIMIT(-60, s, 60);", "s + s > 120", "s + s = 120"),
        ("k := LIMIT(0, k, 100); n := k + 1;", "n > 101 OR n < 1", "n = 101"),
        ("k := LIMIT(0, k, 8); a[k + 1] := 5;", "a[k + 1] <> 5", "a[9] = 5"),
        ("k := LIMIT(0, k, 8); k := (k + 1) MOD 9;", "k > 8", "k = 0"),
        ("k := LIMIT(0, k, 8); k := MIN(k + 1, 5);", "k > 5 OR k < 1", "k = 5"),
        (
            "k := LIMIT(0, k, 8); m := 0; CASE k + 1 OF 10: m := 1; 9: m := 2; END_CASE",
            "m = 1",
            "m = 2",
        ),
        ("k := LIMIT(0, k, 50);", "k * 2 > 100", "k * 2 = 100"),
        // What does not fit is lost where it is assigned to the same type, and masked where it is taken together.
        ("k := 32767; k := k + 1;", "k <> -32768", "k = -32768"),
        ("b := 1; b := NOT b;", "b <> 254", "b = 254"),
        ("w := w AND NOT z;", "(w AND z) <> 0", "w = 16#FFFF"),
        ("", "(w AND NOT w) <> 0", "(w AND NOT z) <> 0"),
        ("b := 16#0F;", "SHL(b, 4) <> 16#F0", "SHL(b, 4) = 16#F0"),
    ] {
        assert!(!may_be(all, before, never), "{before} {never}");
        assert!(may_be(all, before, at_times), "{before} {at_times}");
        let found = program(all, &format!("{before} IF {at_times} THEN x := TRUE; END_IF"));
        let (statements, exact) = exactness(&found).total();
        assert_eq!(statements, exact, "{before}: {:?}", exactness(&found).constructs);
    }
}

#[test]
fn the_ends_of_loops_may_be_sums_that_do_not_fit() {
    let turns = |end: &str| {
        let text = format!(
            "PROGRAM main VAR d, n : DINT; k : INT; x : BOOL; END_VAR k := 20000; n := 0; {end} END_PROGRAM"
        );
        audited("main.st", &text).unwrap_or_else(|faults| panic!("{faults:?}")).unbounded.len()
    };
    assert_eq!(turns("FOR d := 0 TO k + k DO n := n + 1; END_FOR"), 1);
    assert_eq!(turns("d := 0; WHILE d < k + k DO d := d + 1; END_WHILE"), 1);
    assert_eq!(turns("FOR d := 0 TO k + 10 DO n := n + 1; END_FOR"), 0);
    assert_eq!(turns("d := 0; WHILE d < k + 10 DO d := d + 1; END_WHILE"), 0);
}

/// The bound of a text whose loop goes round a thousand times, if what is said of it is possible.
fn may_loop(text: &str) -> bool {
    micros(&audited("main.st", text).unwrap_or_else(|faults| panic!("{text}: {faults:?}"))) > 900
}

#[test]
fn what_a_product_is_handed_to_may_show_more_of_its_bits() {
    let text = |m: &str, condition: &str| {
        format!(
            "FUNCTION_BLOCK fb VAR_INPUT d : DINT; END_VAR VAR_OUTPUT o : DINT; END_VAR o := d;
            END_FUNCTION_BLOCK PROGRAM main VAR f : fb; m, n, i : INT; x : BOOL; END_VAR
            n := LIMIT(0, n, 100); f(d := {m}); IF {condition} THEN
            FOR i := 1 TO 1000 DO x := NOT x; END_FOR END_IF END_PROGRAM"
        )
    };
    assert!(may_loop(&text("n * 1000", "f.o > 40000")));
    assert!(!may_loop(&text("n", "f.o > 100")));
    let counted = |most: u32, to: &str| {
        let text = format!(
            "PROGRAM main VAR d : DINT; n : INT; x : BOOL; END_VAR n := LIMIT(0, n, {most});
            FOR d := 1 TO {to} DO x := NOT x; END_FOR END_PROGRAM"
        );
        audited("main.st", &text).unwrap_or_else(|faults| panic!("{faults:?}")).unbounded.len()
    };
    assert_eq!((counted(2, "n * 20000"), counted(2, "n * 5"), counted(1, "n")), (1, 0, 0));
}

#[test]
fn globals_of_one_name_have_an_address_each() {
    let text = |address: &str| {
        format!(
            r#"<project xmlns="http://www.plcopen.org/xml/tc6_0200"><types><dataTypes/><pous>
            <pou name="Main" pouType="program"><interface><localVars>
            <variable name="k" address="%MW10"><type><INT/></type></variable>
            <variable name="i"><type><INT/></type></variable>
            <variable name="x"><type><BOOL/></type></variable></localVars></interface>
            <body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">
            GA.x := 0; k := 0; GB.x := 5; IF k = 5 THEN FOR i := 1 TO 1000 DO x := NOT x; END_FOR; END_IF;
            </xhtml></ST></body></pou></pous></types><instances><configurations>
            <configuration name="C"><resource name="R">
            <task name="T" interval="T#10ms" priority="1"><pouInstance name="P" typeName="Main"/></task>
            <globalVars name="GA"><variable name="x" address="%MW100"><type><INT/></type></variable></globalVars>
            <globalVars name="GB"><variable name="x" address="{address}"><type><INT/></type></variable></globalVars>
            </resource></configuration></configurations></instances></project>"#
        )
    };
    let bound = |address| micros(&audited("main.xml", &text(address)).expect("an audit"));
    assert!(bound("%MW10") > 900);
    assert!(bound("%MW200") < 900);
}

#[test]
fn constants_that_are_handed_over_are_none() {
    let looping = "FOR i := 1 TO n DO x := NOT x; END_FOR";
    let block = |section: &str, call: &str| {
        format!(
            "FUNCTION_BLOCK fb {section} n : INT := 5; END_VAR VAR i : INT; x : BOOL; END_VAR {looping}
            END_FUNCTION_BLOCK PROGRAM main VAR f : fb; m : INT := 1000; END_VAR {call} END_PROGRAM"
        )
    };
    assert!(may_loop(&block("VAR_INPUT CONSTANT", "f(n := 1000);")));
    assert!(may_loop(&block("VAR_IN_OUT CONSTANT", "f(n := m);")));
    assert!(!may_loop(&block("VAR CONSTANT", "f();")));
    let function = format!(
        "FUNCTION fn : INT VAR_INPUT CONSTANT n : INT := 5; END_VAR VAR i : INT; x : BOOL; END_VAR
        {looping} END_FUNCTION PROGRAM main VAR m : INT; END_VAR m := fn(n := 1000); END_PROGRAM"
    );
    assert!(may_loop(&function));
}

#[test]
fn what_controllers_do_where_en_is_false_is_left_open() {
    let heavy = "FOR i := 1 TO 1000 DO x := NOT x; END_FOR";
    let program = |units: &str, body: &str| {
        format!(
            "{units} PROGRAM main VAR f : fb; e, x : BOOL; i, r, v : INT; END_VAR
            {body} THEN {heavy} END_IF END_PROGRAM"
        )
    };
    let units = "FUNCTION_BLOCK fb VAR_INPUT n : INT; END_VAR VAR_OUTPUT o : INT; END_VAR o := n;
        END_FUNCTION_BLOCK
        FUNCTION fn : INT VAR_INPUT a : INT; END_VAR VAR_OUTPUT o : INT; END_VAR o := a; fn := a; END_FUNCTION
        FUNCTION_BLOCK other VAR v : INT; END_VAR METHOD two : INT v := 2; two := 2; END_METHOD END_FUNCTION_BLOCK";
    let handed = "f(n := 1); f(EN := e, n := 3); f(); IF NOT e AND f.o = 3";
    assert!(may_loop(&program(units, handed)));
    assert!(may_loop(&program(units, "f(n := 1); f(EN := e, n := 3); f(); IF NOT e AND f.o = 1")));
    assert!(!may_loop(&program(units, "f(n := 1); f(EN := e, n := 3); f(); IF e AND f.o = 1")));
    let result = "v := 1; r := fn(EN := e, a := 3, o => v); IF NOT e AND v = 0";
    assert!(may_loop(&program(units, result)));
    assert!(!may_loop(&program(units, "v := 1; r := fn(EN := e, a := 3, o => v); IF e AND v = 0")));
}

#[test]
fn an_input_that_calls_something_may_be_left_out() {
    let text = |chosen: &str| {
        format!(
            "FUNCTION_BLOCK fb VAR v : INT; END_VAR METHOD two : INT v := 2; two := 2; END_METHOD
            END_FUNCTION_BLOCK PROGRAM main VAR g : fb; k, x : BOOL; i, n : INT; END_VAR
            g.v := 0; n := {chosen}; IF k AND g.v = 0 THEN FOR i := 1 TO 1000 DO x := NOT x; END_FOR END_IF
            END_PROGRAM"
        )
    };
    assert!(may_loop(&text("SEL(k, g.two(), 5)")));
    assert!(!may_loop(&text("g.two()")));
}

#[test]
fn elements_are_followed_by_their_index() {
    let all = "n, m : INT; a : ARRAY[1..3] OF INT; b : ARRAY[0..9] OF BOOL; d : ARRAY[0..4] OF DINT; e : DINT;";
    let within = "n := LIMIT(1, n, 3); a[n] := 7; m := a[n];";
    assert!(!may_be(all, within, "m <> 7"));
    assert!(may_be(all, "n := LIMIT(1, n, 3); a[2] := 5; a[n] := 7; m := a[2];", "m = 5"));
    assert!(!may_be(all, "n := LIMIT(1, n, 3); a[2] := 5; a[n] := 7; m := a[2];", "m = 6"));
    let bits = "n := LIMIT(0, n, 9); b[n] := TRUE; y := b[n];";
    assert!(!may_be(all, bits, "NOT y"));
    let long = "n := LIMIT(0, n, 4); d[n] := 100000; e := d[n];";
    assert!(!may_be(all, long, "e <> 100000"));
    for body in [within, bits, long] {
        let found = program(all, body);
        let (statements, exact) = exactness(&found).total();
        assert_eq!(statements, exact, "{body}: {:?}", exactness(&found).constructs);
    }
}

#[test]
fn the_rest_is_told_with_what_it_is() {
    let text = "
FUNCTION_BLOCK scaled
VAR_INPUT raw : INT; END_VAR
VAR_OUTPUT value : REAL; END_VAR
value := INT_TO_REAL(raw);
value := value * 0.1;
END_FUNCTION_BLOCK
FUNCTION_BLOCK unused
VAR k : INT; END_VAR
k := k + 1;
END_FUNCTION_BLOCK
PROGRAM main
VAR one, other : scaled; text : STRING; x : BOOL; n : INT; END_VAR
one(raw := n);
other(raw := n);
IF n > 3 THEN
  x := FIND(text, 'a') = 3;
END_IF
INITIAL_STEP_IS_NONE := FALSE;
END_PROGRAM";
    let text = text.replace("INITIAL_STEP_IS_NONE := FALSE;", "n := n + 1;");
    let found = audited("main.st", &text).expect("an audit");
    let all = exactness(&found);
    assert_eq!(all.languages.len(), 1);
    let st = &all.languages[0];
    // Of the block two statements, though it has two instances; of the program five.
    assert_eq!((st.language, st.called, st.uncalled), ("ST", 2, 1));
    assert_eq!((st.statements, st.exact), (7, 4));
    let places: Vec<(u32, &str)> = all
        .constructs
        .iter()
        .flat_map(|one| &one.places)
        .map(|place| (place.at.line, place.body.as_str()))
        .collect();
    assert_eq!(all.constructs.iter().map(|one| one.statements).sum::<u64>(), 3);
    for place in [(5, "scaled"), (6, "scaled"), (17, "main")] {
        assert!(places.contains(&place), "{places:?}");
    }
    let what = |line: u32| {
        let has =
            |one: &&scanbound::audit::Construct| one.places.iter().any(|at| at.at.line == line);
        all.constructs.iter().find(has).map(|one| one.what.as_str())
    };
    assert_eq!(what(6), Some("any value is assumed for arithmetic of REAL"));
    assert_eq!(what(17), Some("the result of FIND may be any value"));
}

#[test]
fn charts_count_conditions_and_blocks_of_actions() {
    let text = "
PROGRAM main
VAR go, x, y : BOOL; n, m : INT; END_VAR
INITIAL_STEP A: x(S); fill(N); END_STEP
STEP B: x(R); y(N); END_STEP
TRANSITION FROM A TO B := go; END_TRANSITION
TRANSITION FROM B TO A := n + m = 6; END_TRANSITION
ACTION fill: n := n + 1; END_ACTION
END_PROGRAM";
    let found = audited("main.st", text).expect("an audit");
    let of = |language: &str| {
        let own = exactness(&found).languages.iter().find(|one| one.language == language);
        own.map(|one| (one.called, one.statements, one.exact))
    };
    // Two transitions and four blocks; the action's only statement.
    assert_eq!(of("SFC"), Some((1, 6, 6)));
    assert_eq!(of("ST"), Some((1, 1, 1)));
}

#[test]
fn what_shares_memory_takes_on_what_is_written() {
    // The same address and type: one variable with two names.
    let same = "a AT %MW4 : INT; b AT %MW4 : INT;";
    assert!(!may_be(same, "a := 5; b := 5;", "a <> 5"));
    assert!(!may_be(same, "a := 5;", "b <> 5"));
    // A word and a bit of it, or words that overlap if addresses count bytes.
    for other in ["b AT %MX4.3 : BOOL; m AT %MW5 : INT;", "b AT %MX8.1 : BOOL; m AT %MW3 : INT;"] {
        let all = format!("a AT %MW4 : INT; {other}");
        assert!(may_be(&all, "m := 3; a := 5;", "m <> 3"), "{other}");
        assert!(may_be(&all, "b := FALSE; a := 5;", "b"), "{other}");
    }
    let apart = "a AT %MW4 : INT; m AT %MW8 : INT;";
    assert!(!may_be(apart, "m := 3; a := 5;", "m <> 3"));
    // They begin with what either of them declares.
    let text = "PROGRAM main VAR a AT %QX0.0 : BOOL := TRUE; b AT %QX0.0 : BOOL; x : BOOL; END_VAR
IF b THEN x := TRUE; END_IF a := a; END_PROGRAM";
    for trust in [Trust::None, Trust::All] {
        let longest = micros(&trusting(trust, "main.st", text).expect("an audit"));
        assert_eq!(longest, 2, "{trust:?}");
    }
    // So do variables of a block that has several instances.
    let text = "
FUNCTION_BLOCK f VAR_INPUT v : INT; END_VAR VAR q AT %QW0 : INT; END_VAR q := v; END_FUNCTION_BLOCK
PROGRAM main VAR one, two : f; x : BOOL; END_VAR
one(v := 1); two(v := 2); IF one.q <> 2 THEN x := TRUE; END_IF END_PROGRAM";
    let longest = micros(&audited("main.st", text).expect("an audit"));
    assert_eq!(longest, 4);
}

#[test]
fn instruction_lists_lose_nothing() {
    let of = |list: &str| {
        let text =
            format!("PROGRAM main VAR a, x : BOOL; t : TON; f : SR; END_VAR\n{list}\nEND_PROGRAM");
        audited("main.st", &text)
    };
    // An input of an instance as an instruction calls it.
    let found = of("LD a\nIN t\nLD t.Q\nST x").expect("an audit");
    assert!(micros(&found) >= 100, "{}", micros(&found));
    let found = of("LD a\nS1 f\nLD a\nR f\nLD f.Q1\nST x").expect("an audit");
    assert_eq!(exactness(&found).total(), (3, 3));
    // A function that stands alone in its line has the result as its input.
    let text = "PROGRAM main VAR w, v : WORD; x : BOOL; END_VAR
LD w
BCD_TO_UINT
MUL 2
ST v
EQ 7
JMPCN out
LD TRUE
ST x
out:
END_PROGRAM";
    let listed = audited("main.st", text).expect("an audit");
    assert_eq!(exactness(&listed).total(), (3, 3));
    // Of what jumps bring to a label either may be there.
    assert!(of("LD a\nJMPC out\nLD 0\nout:\nST x").is_ok());
}

#[test]
fn the_instance_of_a_number_is_called() {
    let text = "
FUNCTION_BLOCK f VAR_INPUT v : INT; END_VAR VAR k : INT; END_VAR
METHOD PUBLIC twice : INT VAR_INPUT w : INT; END_VAR twice := w * 2; END_METHOD
k := v; END_FUNCTION_BLOCK
PROGRAM main VAR all : ARRAY[1..3] OF f; t : ARRAY[0..1] OF TON; n : INT; x : BOOL; END_VAR
n := LIMIT(1, n, 3);
all[2](v := 0);
all[n](v := 7);
BODY
END_PROGRAM";
    let longest = |body: &str| {
        let found = audited("main.st", &text.replace("BODY", body)).expect("an audit");
        let (statements, exact) = exactness(&found).total();
        assert_eq!(statements, exact, "{body}: {:?}", exactness(&found).constructs);
        micros(&found)
    };
    // A store for the number, and for each call one that hands over and that of the block.
    assert_eq!(longest(""), 5);
    assert_eq!(longest("IF n = 2 AND all[2].k <> 7 THEN x := TRUE; END_IF"), 5);
    assert_eq!(longest("IF n = 1 AND all[2].k <> 7 THEN x := TRUE; END_IF"), 6);
    // Only one of two timers runs.
    assert_eq!(longest("t[n - 1](IN := x);"), 106);
    // A method in text hands over and stores its result.
    assert_eq!(longest("IF all[1].twice(w := 3) <> 6 THEN x := TRUE; END_IF"), 7);
}

/// Two blocks that feed each other.
const FEEDBACK: &str = r#"<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201"><fileHeader companyName="" productName="" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="c"><coordinateInfo><fbd><scaling x="1" y="1"/></fbd><ld><scaling x="1" y="1"/></ld><sfc><scaling x="1" y="1"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes/><pous><pou name="main" pouType="program"><interface><localVars>
<variable name="f"><type><derived name="SR"/></type></variable><variable name="g"><type><derived name="RS"/></type></variable>
<variable name="x"><type><BOOL/></type></variable></localVars></interface><body><FBD>
<block localId="1" typeName="SR" instanceName="f"><position x="10" y="10"/><inputVariables><variable formalParameter="S1"><connectionPointIn><connection refLocalId="2" formalParameter="Q1"/></connectionPointIn></variable></inputVariables><inOutVariables/><outputVariables><variable formalParameter="Q1"><connectionPointOut/></variable></outputVariables></block>
<block localId="2" typeName="RS" instanceName="g"><position x="50" y="10"/><inputVariables><variable formalParameter="S"><connectionPointIn><connection refLocalId="1" formalParameter="Q1"/></connectionPointIn></variable></inputVariables><inOutVariables/><outputVariables><variable formalParameter="Q1"><connectionPointOut/></variable></outputVariables></block>
<outVariable localId="3"><position x="90" y="10"/><connectionPointIn><connection refLocalId="2" formalParameter="Q1"/></connectionPointIn><expression>x</expression></outVariable>
</FBD></body></pou></pous></types><instances><configurations/></instances></project>"#;

#[test]
fn what_is_fed_back_is_what_the_scan_before_left() {
    let found = audited("main.xml", FEEDBACK).expect("an audit");
    let all = |found: &Audit| (micros(found), found.bound.exact(), exactness(found).total());
    assert_eq!(all(&found), (3, true, (3, 3)));
    // Functions keep their results in variables of the unit, as the generated text does.
    let function = FEEDBACK
        .replace(" instanceName=\"f\"", "")
        .replace(" instanceName=\"g\"", "")
        .replace("typeName=\"SR\"", "typeName=\"AND\"")
        .replace("typeName=\"RS\"", "typeName=\"OR\"");
    let found = audited("main.xml", &function).expect("an audit");
    assert_eq!(all(&found), (3, true, (3, 1)));
}

/// The bound by a table by which a logarithm takes a microsecond, an addition to a text's or a number's type none.
pub(crate) fn logarithms(text: &str) -> Result<(u64, usize), Vec<Code>> {
    costing("LN,1,1\n", text)
}

/// The bound in microseconds where only these rows cost anything, and how many loops nothing known ends.
pub(crate) fn costing(rows: &str, text: &str) -> Result<(u64, usize), Vec<Code>> {
    costing_by(Trust::Counts, rows, text)
}

pub(crate) fn costing_by(trust: Trust, rows: &str, text: &str) -> Result<(u64, usize), Vec<Code>> {
    let mut table = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        table += &format!("@{class},0,0\n");
    }
    table += &format!("{rows}@end,0,\n");
    let table = Table::parse("t.csv", table.as_bytes()).unwrap_or_else(|_| panic!("{rows}")).table;
    let inputs = [Input { name: "main.st".into(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request {
        table: Some(&table),
        trust,
        dialect: Some("iec-text"),
        ..Request::new(&inputs, &facts)
    };
    match audit(&request) {
        Ok(found) => Ok((micros(&found), found.unbounded.len())),
        Err(Failure::Input(faults)) => Err(faults.iter().map(|fault| fault.code).collect()),
        Err(other) => panic!("{text}: {other:?}"),
    }
}

#[test]
fn values_of_which_only_the_type_is_known_are_converted_for_the_same_price() {
    let of = |statement: &str| {
        let text = format!(
            "FUNCTION G : LREAL VAR_INPUT v : LREAL; END_VAR G := v; END_FUNCTION
            PROGRAM main VAR r, q : REAL; l : LREAL; n : INT; li : LINT; s : STRING; x : BOOL; END_VAR
            {statement} END_PROGRAM"
        );
        costing("CONVERT,1,1\n", &text).unwrap_or_else(|faults| panic!("{statement}: {faults:?}")).0
    };
    for (statement, conversions) in [
        ("r := ABS(q);", 0),
        ("r := SQRT(q);", 0),
        ("l := ABS(r);", 1),
        ("l := LN(r);", 1),
        ("r := TRUNC(q);", 1),
        ("n := TRUNC(q);", 0),
        ("n := LEN(s);", 0),
        ("r := li * li;", 1),
        ("l := li * li;", 1),
        ("l := G(ABS(r));", 1),
        ("l := G(SQRT(r));", 1),
        // Given to what works with reals or long reals, and taken from it: one or the other.
        ("r := SIN(n);", 2),
    ] {
        assert_eq!(of(statement), conversions, "{statement}");
    }
}

#[test]
fn what_comes_of_sums_is_open_behind_functions_and_quotients_too() {
    let of = |set: &str, condition: &str| {
        let text = format!(
            "PROGRAM main VAR i, j, k : INT; d, d2, q : DINT; u1, u2 : USINT; u : UINT; b1 : BYTE; w1 : WORD;
            dw : DWORD; r : REAL; END_VAR {set} IF {condition} THEN r := LN(r); END_IF END_PROGRAM"
        );
        logarithms(&text).unwrap_or_else(|faults| panic!("{set} {condition}: {faults:?}")).0 == 1
    };
    // With 16 bits, with 32, and where nothing is lost.
    for (set, may) in [
        ("i := 30000; j := 0;", "i + LIMIT(0, i + j, 32000) < 0"),
        ("i := 30000; j := 0;", "i + LIMIT(0, i + j, 32000) > 0"),
        ("i := 30000; j := 0; q := i + ABS(i + j);", "q = -5536"),
        ("i := 30000; j := 0; q := i + ABS(i + j);", "q = 60000"),
        ("i := 30000; j := 0; k := 1;", "(i + j) / k + i < 0"),
        ("i := -32768; j := 0; q := ABS(i + j);", "q = -32768"),
        ("i := -32768; j := 0; q := ABS(i + j);", "q = 32768"),
        ("i := -1; j := 0; dw := INT_TO_DWORD(i + j);", "dw = 16#FFFF"),
        ("i := 16#7000; j := 0; q := SHL(i + j, 4);", "q = 0"),
        ("u1 := 10; u2 := 210; u := 0; q := (u1 - u2) + u;", "q = -200"),
        ("u1 := 200; i := 0;", "(u1 * u1) + i > 32767"),
        ("b1 := 1; w1 := NOT SHL(b1, 1);", "w1 = 16#FFFD"),
        ("d := 2147483647; d2 := 1;", "(d + d2) / 2 = 1073741824"),
    ] {
        assert!(of(set, may), "{set} {may}");
    }
    // Literals that REAL does not hold, and numbers of which some have a sign.
    for (set, may) in [
        ("r := 0.1;", "r > 0.1"),
        ("r := 0.1;", "MAX(r, 0.1) > r"),
        ("i := -5; u := 10;", "LIMIT(0, i, u) = 10"),
        ("i := -5; u := 10;", "MAX(i, 0, u) = 65531"),
    ] {
        assert!(of(set, may), "{set} {may}");
    }
    assert!(!of("r := 0.5;", "r <> 0.5"));
    assert!(!of("i := 300; j := 5;", "MAX(i + j, 0) <> 305"));
    assert!(!of("i := 300; j := 5;", "(i + j) / 5 <> 61"));
    assert!(!of("i := 300; j := 5; d := INT_TO_DINT(i + j);", "d <> 305"));
}

#[test]
fn first_values_are_known_of_what_the_program_writes() {
    let units = "TYPE E : (Idle, Run, Stop); END_TYPE ";
    let of = |trust: Trust, variables: &str, body: &str| {
        let text = format!(
            "{units} PROGRAM main VAR a AT %IX0.0 : BOOL; x : BOOL; {variables} END_VAR {body} END_PROGRAM"
        );
        micros(&trusting(trust, "main.st", &text).unwrap_or_else(|_| panic!("{body}")))
    };
    for (variables, steps) in [
        ("s : INT := 1;", ["1", "2", "3"]),
        ("s : USINT := 2;", ["1", "2", "3"]),
        ("s : E;", ["E.Idle", "E.Run", "E.Stop"]),
        ("s : E := E.Run;", ["E.Idle", "Run", "E#Stop"]),
    ] {
        let [one, two, three] = steps;
        let body = format!(
            "IF s = {one} THEN s := {two}; ELSIF s = {two} THEN s := {three}; ELSIF s = {three} THEN s := {one};
             ELSE x := TRUE; x := TRUE; END_IF"
        );
        assert_eq!(of(Trust::All, variables, &body), 1, "{variables}");
        assert_eq!(of(Trust::None, variables, &body), 2, "{variables}");
    }
    // Bits of which one is on from the first scan on.
    let turns =
        "IF a AND s1 THEN s1 := FALSE; s2 := TRUE; ELSIF s2 THEN s2 := FALSE; s1 := TRUE; END_IF
                 IF s1 AND s2 THEN x := TRUE; x := TRUE; x := TRUE; END_IF";
    assert_eq!(of(Trust::All, "s1 : BOOL := TRUE; s2 : BOOL;", turns), 2);
    // What the program reads alone is a parameter, and what a loss of power leaves is not what is declared.
    assert_eq!(of(Trust::All, "p : INT := 7;", "IF p <> 7 THEN x := TRUE; END_IF"), 1);
    let retained = "END_VAR VAR RETAIN s : INT := 1;";
    let body = "IF s = 1 THEN s := 2; s := 3; END_IF IF s = 2 THEN x := TRUE; x := TRUE; END_IF";
    assert_eq!(of(Trust::All, retained, body), 2);
    assert_eq!(of(Trust::All, "s : INT := 1;", body), 2);
    // The first scan begins with them.
    let once = "IF first THEN first := FALSE; x := TRUE; END_IF n := 1; n := n + 1;";
    assert_eq!(of(Trust::All, "first : BOOL := TRUE; n : INT;", once), 4);
}

#[test]
fn controllers_that_look_at_transitions_in_the_first_scan_may_leave_the_initial_step_at_once() {
    let of = |qualifier: &str, condition: &str| {
        let text = format!(
            "PROGRAM main VAR go AT %IX0.0 : BOOL; x : BOOL := TRUE; y : BOOL; END_VAR
            INITIAL_STEP A : act({qualifier}); END_STEP
            STEP B : late(N); END_STEP
            TRANSITION FROM A TO B := {condition}; END_TRANSITION
            TRANSITION FROM B TO A := NOT go; END_TRANSITION
            ACTION act : x := FALSE; END_ACTION
            ACTION late : IF x THEN y := TRUE; y := TRUE; y := TRUE; y := TRUE; END_IF END_ACTION
            END_PROGRAM"
        );
        micros(&trusting(Trust::All, "main.st", &text).expect("an audit"))
    };
    // Without its action carried out, or as one that was there before and is not entered.
    assert!(of("N", "go") >= 4);
    assert!(of("P1", "go AND A.T > T#0s") >= 4);
}

#[test]
fn units_without_a_body_are_doubts() {
    let text = |body: &str| {
        format!(
            "FUNCTION_BLOCK Logger VAR_OUTPUT ok : BOOL; END_VAR {body} END_FUNCTION_BLOCK
            FUNCTION_BLOCK Nothing VAR_INPUT m : INT; END_VAR END_FUNCTION_BLOCK
            PROGRAM main VAR l : Logger; n : Nothing; END_VAR l(); n(m := 1); END_PROGRAM"
        )
    };
    let found = audited("main.st", &text("")).expect("an audit");
    let doubts: Vec<String> = found.all_doubts().iter().map(ToString::to_string).collect();
    assert!(
        doubts.len() == 1 && doubts[0].contains("Nothing, Logger (first in main.st:2)"),
        "{doubts:?}"
    );
    let whole = text("ok := TRUE;")
        .replace("END_VAR END_FUNCTION_BLOCK", "END_VAR ; m; END_FUNCTION_BLOCK");
    let found = audited("main.st", &whole).expect("an audit");
    assert!(found.all_doubts().is_empty(), "{:?}", found.all_doubts());
}

#[test]
fn markings_after_an_early_end_of_flags_are_not_excluded() {
    // matiec ends S1 as soon as the first transition clears, so the second one does in the same scan.
    let text = "PROGRAM main VAR b AT %IX0.0 : BOOL; t : TON; END_VAR
        INITIAL_STEP I: END_STEP
        STEP S1: END_STEP STEP S2: END_STEP STEP S3: END_STEP STEP S4: END_STEP STEP S6: A(N); END_STEP
        TRANSITION FROM I TO (S1, S3) := b; END_TRANSITION
        TRANSITION t1 (PRIORITY := 1) FROM S1 TO S2 := b; END_TRANSITION
        TRANSITION FROM S3 TO S4 := NOT S1.X AND NOT S2.X; END_TRANSITION
        TRANSITION FROM (S2, S4) TO S6 := b; END_TRANSITION
        ACTION A: t(IN := b, PT := T#1s); END_ACTION
        END_PROGRAM";
    for trust in [Trust::None, Trust::All] {
        let found = trusting(trust, "main.st", text).expect("an audit");
        assert!(micros(&found) >= 100, "{trust:?}");
    }
}

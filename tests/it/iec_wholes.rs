//! Structures, arrays, instances and texts as wholes, conversions and powers of IEC 61131-3: what they are charged, and
//! that charts in instances which begin anew with every call begin anew, too.

use scanbound::audit::{Failure, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// The longest scan in microseconds, where only these rows cost anything.
fn bound(rows: &str, text: &str) -> Result<u64, Vec<Code>> {
    bound_as("iec-text", rows, text)
}

/// The same of a text in a dialect.
fn bound_as(dialect: &str, rows: &str, text: &str) -> Result<u64, Vec<Code>> {
    let mut all = "instruction,on_us,off_us,per_unit_us\n".to_owned();
    for class in CLASSES {
        if !rows.contains(&format!("@{class},")) {
            all += &format!("@{class},0,0,\n");
        }
    }
    all += rows;
    if !rows.contains("@base") {
        all += "\n@end,0,,\n";
    }
    let table =
        Table::parse("t.csv", all.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table;
    let inputs = [Input { name: "main.st".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request {
        table: Some(&table),
        trust: Trust::None,
        dialect: Some(dialect),
        ..Request::new(&inputs, &facts)
    };
    match audit(&request) {
        Ok(found) => Ok(found.bound.upper.0 / Picos(1_000_000).0),
        Err(Failure::Input(faults)) => Err(faults.into_iter().map(|fault| fault.code).collect()),
        Err(other) => panic!("{other:?}"),
    }
}

/// Elements and characters of wholes, each a microsecond.
const MOVED: &str = "COPY,0,0,1\nCOMPARE,0,0,1\nCOPY_TEXT,0,0,1";

/// What the elements and characters of wholes come to, each a microsecond.
fn moved(units: &str, variables: &str, body: &str) -> u64 {
    let text = format!("{units} PROGRAM main VAR {variables} END_VAR {body} END_PROGRAM");
    let found = bound(MOVED, &text);
    found.unwrap_or_else(|codes| panic!("{codes:?}\n{text}"))
}

#[test]
fn copies_are_charged_by_their_elements() {
    let large = "p, q : ARRAY[0..99999] OF DINT;";
    assert_eq!(moved("", large, "q := p;"), 100_000);
    assert_eq!(moved("", large, "IF q = p THEN ; END_IF"), 100_000);
    assert_eq!(moved("", large, "q := MOVE(p);"), 200_000, "into the block, and out of it");
    let table = "p : ARRAY[1..3, 0..4] OF LREAL; q : ARRAY[1..3, 0..4] OF LREAL;";
    assert_eq!(moved("", table, "q := p;"), 15);
    let units =
        "TYPE S : STRUCT a : INT; b : ARRAY[0..9] OF BOOL; c : STRING[20]; END_STRUCT; END_TYPE";
    assert_eq!(moved(units, "p, q : S;", "q := p;"), 31);
    assert_eq!(moved(units, "i : INT; p : ARRAY[0..3] OF S;", "p[i] := p[1];"), 31);
    // The edge that it remembers, too.
    assert_eq!(moved("", "p, q : R_TRIG;", "q := p;"), 3);
    let units = "FUNCTION_BLOCK B VAR n : INT; t : TON; END_VAR END_FUNCTION_BLOCK";
    assert_eq!(moved(units, "p, q : B;", "q := p;"), 6);
}

#[test]
fn texts_are_charged_by_the_length_that_is_declared() {
    assert_eq!(moved("", "s, t : STRING[2000];", "s := t;"), 2000);
    assert_eq!(moved("", "s : STRING[2000];", "s := 'abc';"), 4, "what ends it, too");
    assert_eq!(moved("", "s, t : STRING;", "s := t;"), 254);
    let constant = "VAR_GLOBAL CONSTANT n : INT := 30; END_VAR";
    assert_eq!(moved(constant, "s, t : STRING(n);", "s := t;"), 30);
    // The price of a function of texts holds 80 characters.
    assert_eq!(moved("", "s, t : STRING[100];", "IF s = t THEN ; END_IF"), 20);
    assert_eq!(moved("", "s, t : STRING[80];", "IF s = t THEN ; END_IF"), 0);
    assert_eq!(moved("", "s, t : STRING[100];", "s := CONCAT(s, t);"), 120 + 100);
    assert_eq!(moved("", "s : STRING[200]; n : INT;", "n := LEN(s);"), 120);
}

#[test]
fn texts_that_methods_and_properties_give_are_as_long_as_they_say() {
    let units = "FUNCTION_BLOCK F
          METHOD M : STRING[2000] END_METHOD
          PROPERTY P : STRING[2000] GET END_GET END_PROPERTY
        END_FUNCTION_BLOCK";
    // Each result begins anew.
    for (body, calls) in [
        ("IF f.M() = f.M() THEN ; END_IF", 2),
        ("IF f.P = f.P THEN ; END_IF", 2),
        ("n := LEN(f.M());", 1),
        ("n := LEN(f.P);", 1),
    ] {
        assert_eq!(moved(units, "f : F; n : INT;", body), 1920 + calls * 2000, "{body}");
    }
}

#[test]
fn a_text_that_a_drawing_hands_on_is_as_long_as_it_may_be() {
    let from = |name: &str, block: u32| {
        format!(
            r#"<variable formalParameter="{name}"><connectionPointIn><connection refLocalId="{block}"/></connectionPointIn></variable>"#
        )
    };
    let block = |id: u32, name: &str, inputs: String| {
        format!(
            r#"<block localId="{id}" typeName="{name}"><position x="{id}0" y="0"/><inputVariables>{inputs}</inputVariables>
            <inOutVariables/><outputVariables><variable formalParameter="OUT"><connectionPointOut/></variable></outputVariables></block>"#
        )
    };
    let both = |block: u32| from("IN1", block) + &from("IN2", block);
    let text = format!(
        r#"<project xmlns="http://www.plcopen.org/xml/tc6_0201"><types><dataTypes/><pous><pou name="main" pouType="program">
        <interface><localVars><variable name="s"><type><string length="1000"/></type></variable>
        <variable name="x"><type><BOOL/></type></variable></localVars></interface><body><FBD>
        <inVariable localId="1"><position x="0" y="0"/><connectionPointOut/><expression>s</expression></inVariable>
        {}{}
        <outVariable localId="4"><position x="50" y="0"/><connectionPointIn><connection refLocalId="3"/></connectionPointIn>
        <expression>x</expression></outVariable>
        </FBD></body></pou></pous></types><instances><configurations/></instances></project>"#,
        block(2, "CONCAT", both(1)),
        block(3, "EQ", both(2)),
    );
    // CONCAT is given 2000 characters. Generators copy its result into a STRING without a length, which may hold 254,
    // and EQ is given twice as many. Each of these rows is for 80 but the copy's.
    let found = bound_as("plcopen-xml", MOVED, &text);
    assert_eq!(found, Ok(2000 - 80 + 254 + 2 * 254 - 80));
}

#[test]
fn assumed_times_are_named_by_the_row_that_would_price_them() {
    let text = "PROGRAM main VAR p, q : ARRAY[0..9] OF INT; END_VAR q := p; q[0] := 1; END_PROGRAM";
    let inputs = [Input { name: "main.st".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request { dialect: Some("iec-text"), ..Request::new(&inputs, &facts) };
    let found = audit(&request).unwrap_or_else(|failure| panic!("{failure:?}"));
    let names: Vec<&str> = found.table.assumed.iter().map(|one| one.name.as_str()).collect();
    assert!(names.contains(&"COPY") && names.contains(&"ST"), "{names:?}");
    assert!(!names.iter().any(|name| name.starts_with('q')), "{names:?}");
}

#[test]
fn what_is_handed_over_by_value_and_begins_anew_is_charged_by_its_elements() {
    let of = |section: &str| {
        format!(
            "FUNCTION F : INT {section} k : ARRAY[0..999] OF DINT; END_VAR F := 1; END_FUNCTION"
        )
    };
    let variables = "n : INT; a : ARRAY[0..999] OF DINT;";
    assert_eq!(moved(&of("VAR_INPUT"), variables, "n := F(a);"), 1000);
    assert_eq!(moved(&of("VAR_INPUT"), variables, "n := F(k := a);"), 1000);
    assert_eq!(moved(&of("VAR"), variables, "n := F();"), 1000);
    assert_eq!(moved(&of("VAR_OUTPUT"), variables, "n := F(k => a);"), 2000);
    // Of what is handed over in and out the address is.
    assert_eq!(moved(&of("VAR_IN_OUT"), variables, "n := F(k := a);"), 0);
    let units = "TYPE A : ARRAY[0..9] OF INT; END_TYPE
        FUNCTION F : A F[0] := 1; END_FUNCTION
        FUNCTION_BLOCK B VAR_TEMP t : ARRAY[0..99] OF INT; END_VAR
        METHOD M : INT VAR s : STRING[50]; END_VAR M := 1; END_METHOD END_FUNCTION_BLOCK";
    assert_eq!(moved(units, "a : A;", "a := F();"), 20, "begun and given back");
    assert_eq!(moved(units, "b : B;", "b();"), 100);
    assert_eq!(moved(units, "b : B; n : INT;", "n := b.M();"), 50);
    // One value is one.
    let unit = "FUNCTION F : INT VAR i, j : INT := 3; END_VAR F := i; END_FUNCTION";
    let text = format!("{unit} PROGRAM main VAR n : INT; END_VAR n := F(); END_PROGRAM");
    assert_eq!(bound("INIT,1,1,", &text), Ok(3));
}

#[test]
fn a_copy_takes_at_least_as_long_by_the_built_in_table_as_its_loads_and_stores() {
    let micros = |body: &str| {
        let text = format!(
            "PROGRAM main VAR p, q : ARRAY[0..99999] OF DINT; s, t : STRING[2000]; END_VAR {body} END_PROGRAM"
        );
        let inputs = [Input { name: "main.st".to_owned(), bytes: text.into_bytes() }];
        let facts = Facts::default();
        let request = Request { dialect: Some("iec-text"), ..Request::new(&inputs, &facts) };
        audit(&request).expect("it has a bound").bound.upper.0 / 1_000_000
    };
    let one = micros("q[0] := p[0];") - micros("");
    assert!(micros("q := p;") - micros("") >= 100_000 * one);
    assert!(micros("q := p;") - micros("") >= 20_000);
    assert!(micros("s := t;") - micros("") >= 400);
}

/// How many conversions are charged.
fn conversions(variables: &str, body: &str) -> u64 {
    let text = format!("PROGRAM main VAR {variables} END_VAR {body} END_PROGRAM");
    bound("CONVERT,1,1,", &text).unwrap_or_else(|codes| panic!("{codes:?}\n{text}"))
}

#[test]
fn conversions_that_are_not_written_are_charged_as_those_that_are() {
    let all = "i : INT; d : DINT; r : REAL; l : LREAL; x : BOOL;";
    for (body, count) in [
        ("r := INT_TO_REAL(i);", 1),
        ("r := i;", 1),
        ("l := i;", 1),
        ("l := r;", 1),
        ("r := r + i;", 1),
        ("x := i < r;", 1),
        ("l := i * 1.5;", 2),
        ("r := MAX(r, i);", 2),
        ("r := TO_REAL(i);", 1),
        // Constants are converted beforehand; a whole number is loaded at whichever length.
        ("r := 1;", 0),
        ("r := r + 1;", 0),
        ("d := i;", 0),
    ] {
        assert_eq!(conversions(all, body), count, "{body}");
    }
    let unit = "FUNCTION F : REAL VAR_INPUT r : REAL; END_VAR F := r; END_FUNCTION";
    let text = format!("{unit} PROGRAM main VAR i : INT; r : REAL; END_VAR r := F(i); END_PROGRAM");
    assert_eq!(bound("INT_TO_REAL,1,1,", &text), Ok(1));
}

#[test]
fn powers_and_conversions_of_texts_are_charged_as_functions_of_their_kind() {
    for body in [
        "r := r ** 2.5;",
        "r := EXPT(r, 2.5);",
        "i := i ** 2;",
        "s := INT_TO_STRING(i);",
        "s := REAL_TO_STRING(r);",
        "r := STRING_TO_REAL(s);",
        "i := TO_INT(s);",
        "s := TO_STRING(i);",
    ] {
        let text =
            format!("PROGRAM main VAR i : INT; r : REAL; s : STRING; END_VAR {body} END_PROGRAM");
        assert_eq!(bound("@special,20,20,", &text), Ok(20), "{body}");
    }
}

const CHART: &str = "FUNCTION_BLOCK Chart VAR_INPUT a : BOOL; END_VAR
    INITIAL_STEP S0: END_STEP STEP S1: END_STEP TRANSITION FROM S0 TO S1 := a; END_TRANSITION
    END_FUNCTION_BLOCK";

/// Whether a bit may be set where a condition holds behind some statements.
fn may(units: &str, variables: &str, before: &str, condition: &str) -> bool {
    let text = format!(
        "{CHART} {units} PROGRAM main VAR x, y : BOOL; r : REAL; {variables} END_VAR
        {before} IF {condition} THEN r := LN(r); END_IF END_PROGRAM"
    );
    let found = bound("LN,100,100,", &text);
    found.unwrap_or_else(|codes| panic!("{codes:?}\n{text}")) == 100
}

#[test]
fn a_chart_that_begins_anew_with_every_call_is_in_its_first_step() {
    // Each call is the chart's first, in which controllers evaluate transitions or not.
    let body = "k(a := TRUE);";
    let function = |body: &str| {
        format!("FUNCTION F : BOOL VAR k : Chart; END_VAR {body} F := k.S0.X; END_FUNCTION")
    };
    assert!(may(&function(body), "", "x := F(); x := F();", "x"));
    assert!(may(&function(body), "", "x := F(); x := F();", "NOT x"));
    assert!(!may(&function("k(a := FALSE);"), "", "x := F(); x := F();", "NOT x"));
    let method = format!(
        "FUNCTION_BLOCK G METHOD M : BOOL VAR k : Chart; END_VAR {body} M := k.S0.X; END_METHOD END_FUNCTION_BLOCK"
    );
    assert!(may(&method, "g : G;", "x := g.M(); x := g.M();", "x"));
    assert!(may(&method, "g : G;", "x := g.M(); x := g.M();", "NOT x"));
    let temporary = format!(
        "FUNCTION_BLOCK G VAR_OUTPUT x : BOOL; END_VAR VAR_TEMP k : Chart; END_VAR {body} x := k.S0.X; END_FUNCTION_BLOCK"
    );
    assert!(may(&temporary, "g : G;", "g(); g();", "g.x"));
    assert!(may(&temporary, "g : G;", "g(); g();", "NOT g.x"));
    // In structures, arrays and other instances, too; and before it is called its initial step is active or not.
    let within = "TYPE S : STRUCT c : Chart; END_STRUCT; END_TYPE
        FUNCTION_BLOCK Outer VAR s : ARRAY[1..2] OF S; END_VAR s[2].c(a := TRUE); END_FUNCTION_BLOCK
        FUNCTION F : BOOL VAR k : Outer; END_VAR F := k.s[2].c.S0.X; k(); x1 := k.s[2].c.S0.X; END_FUNCTION
        VAR_GLOBAL x1 : BOOL; END_VAR";
    assert!(may(within, "", "x := F(); x := F();", "x1"));
    assert!(may(within, "", "x := F(); x := F();", "x"));
    assert!(may(within, "", "x := F(); x := F();", "NOT x"));
    // Called once in a program it goes on.
    assert!(may("", "k : Chart;", body, "k.S1.X"));
}

#[test]
fn an_instance_with_a_chart_is_not_copied() {
    let units = "TYPE S : STRUCT c : Chart; n : INT; END_STRUCT; END_TYPE
        FUNCTION F : INT VAR_INPUT c : Chart; END_VAR F := 1; END_FUNCTION
        FUNCTION H : Chart H.a := TRUE; END_FUNCTION
        FUNCTION_BLOCK B VAR_OUTPUT c : Chart; END_VAR END_FUNCTION_BLOCK";
    for body in [
        "d := c;",
        "d := MOVE(c);",
        "q := p;",
        "r[1] := r[0];",
        "r[i] := c;",
        "q.c := p.c;",
        "i := F(c);",
        "d := H();",
        "b(c => d);",
    ] {
        let text = format!(
            "{CHART} {units} PROGRAM main VAR c, d : Chart; p, q : S; r : ARRAY[0..1] OF Chart; i : INT; b : B;
            END_VAR {body} END_PROGRAM"
        );
        let found = bound("ST,1,1,", &text);
        assert!(
            matches!(&found, Err(codes) if codes.contains(&Code::NotModelled)),
            "{body} {found:?}"
        );
    }
}

#[test]
fn a_steps_flag_is_loaded_like_a_variable() {
    let loads = |value: &str| {
        let text = format!(
            "{CHART} PROGRAM main VAR k : Chart; x, y : BOOL; END_VAR x := {value}; END_PROGRAM"
        );
        bound("LD,1,1,", &text).unwrap_or_else(|codes| panic!("{codes:?}\n{text}"))
    };
    assert_eq!(
        [loads("TRUE"), loads("y"), loads("k.S0.X"), loads("k.S0.X AND k.S1.X")],
        [0, 1, 1, 2]
    );
}

#[test]
fn a_step_of_a_base_is_not_asked_for_where_another_chart_takes_its_place() {
    let text = |own: &str| {
        format!(
            "{} METHOD asks : BOOL asks := S0.X; END_METHOD END_FUNCTION_BLOCK
            FUNCTION_BLOCK Derived EXTENDS Chart {own} END_FUNCTION_BLOCK
            PROGRAM main VAR d : Derived; x : BOOL; END_VAR d(); x := d.asks(); END_PROGRAM",
            CHART.replace("END_FUNCTION_BLOCK", "")
        )
    };
    assert_eq!(bound("LD,0,0,", &text("")), Ok(0));
    let own = "INITIAL_STEP S0: END_STEP STEP S2: END_STEP TRANSITION FROM S0 TO S2 := TRUE; END_TRANSITION";
    assert_eq!(bound("LD,0,0,", &text(own)), Err(vec![Code::NotModelled]));
}

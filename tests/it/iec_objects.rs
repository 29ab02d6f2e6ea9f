//! Interfaces, references, pointers, properties and inherited calls of IEC 61131-3: each says exactly what it says on a
//! PLC.

use scanbound::audit::{Audit, Failure, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};
use std::fmt::Write as _;

/// What the timer behind a condition takes, in microseconds; a store takes one.
const PROBE: u64 = 1_000_000;

fn audited(name: &str, text: &str) -> Result<Audit, Vec<(Code, String)>> {
    trusting(Trust::None, name, text)
}

/// Only stores and timers cost anything.
fn table() -> Table {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        let _ = writeln!(rows, "@{class},0,0");
    }
    let _ = writeln!(rows, "ST,1,1\nTON,{PROBE},{PROBE}\n@end,0,");
    Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table
}

fn trusting(trust: Trust, name: &str, text: &str) -> Result<Audit, Vec<(Code, String)>> {
    let table = table();
    let inputs = [Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request = Request { table: Some(&table), trust, ..Request::new(&inputs, &facts) };
    match audit(&request) {
        Ok(found) => Ok(found),
        Err(Failure::Input(faults)) => {
            Err(faults.into_iter().map(|fault| (fault.code, fault.message)).collect())
        }
        Err(other) => panic!("{other:?}"),
    }
}

fn micros(found: &Audit) -> u64 {
    found.bound.upper.0.div_ceil(1_000_000)
}

fn program(units: &str, variables: &str, body: &str, condition: &str) -> String {
    format!(
        "{units} PROGRAM main VAR a AT %IX0.0 : BOOL; b AT %IX0.1 : BOOL; w AT %IW2 : INT; probe : TON; {variables} END_VAR
         {body} IF {condition} THEN probe(); END_IF END_PROGRAM"
    )
}

/// Whether a condition may hold behind some statements.
pub(super) fn may(units: &str, variables: &str, body: &str, condition: &str) -> bool {
    let text = program(units, variables, body, condition);
    let found = audited("main.st", &text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}"));
    micros(&found) >= PROBE
}

/// It holds in every scan.
fn always(units: &str, variables: &str, body: &str, condition: &str) {
    assert!(!may(units, variables, body, &format!("NOT ({condition})")), "{body}: {condition}");
    assert!(may(units, variables, body, condition), "{body}: never {condition}");
}

fn refused(units: &str, variables: &str, body: &str) -> Vec<(Code, String)> {
    let text = program(units, variables, body, "a");
    audited("main.st", &text).err().unwrap_or_else(|| panic!("{text}"))
}

const UNITS: &str = "
    INTERFACE I_Named METHOD Id : INT END_METHOD END_INTERFACE
    INTERFACE I_Motor EXTENDS I_Named
      METHOD PUBLIC Run : BOOL VAR_INPUT n : INT; END_VAR END_METHOD
      PROPERTY Speed : INT GET END_GET SET END_SET END_PROPERTY
    END_INTERFACE
    FUNCTION_BLOCK Base IMPLEMENTS I_Motor
      VAR v : INT; END_VAR VAR_OUTPUT bodies : INT; END_VAR
      bodies := 1;
      METHOD Run : BOOL VAR_INPUT n : INT; END_VAR v := n; Run := Id() = 1; END_METHOD
      METHOD Id : INT Id := 1; END_METHOD
      PROPERTY PUBLIC Speed : INT
        GET Speed := v; END_GET
        SET v := Speed + 100; END_SET
      END_PROPERTY
    END_FUNCTION_BLOCK
    FUNCTION_BLOCK FINAL Derived EXTENDS Base
      VAR runs : INT; END_VAR
      SUPER^(); bodies := bodies + 10;
      METHOD Run : BOOL VAR_INPUT n : INT; END_VAR
        runs := 5; Run := SUPER^.Run(n := n + 1); THIS^.v := v + 1;
      END_METHOD
      METHOD Id : INT Id := SUPER^.Id() + 1; END_METHOD
    END_FUNCTION_BLOCK
    FUNCTION_BLOCK ABSTRACT Alone IMPLEMENTS I_Named
      METHOD ABSTRACT Id : INT END_METHOD
    END_FUNCTION_BLOCK";

#[test]
fn a_call_through_an_interface_is_that_of_the_instance_that_it_means() {
    let variables = "one : Base; two : Derived; m : I_Motor; named : I_Named; ok : BOOL; n : INT;";
    // The base's method calls the one that the instance has.
    always(UNITS, variables, "m := one; ok := m.Run(7);", "ok AND one.v = 7");
    always(UNITS, variables, "m := two; ok := m.Run(n := 7);", "NOT ok AND two.v = 9");
    let chosen = "one.v := 0; two.v := 0; IF a THEN m := one; ELSE m := two; END_IF m.Run(7);";
    always(UNITS, variables, chosen, "(a AND one.v = 7 AND two.v = 0) OR (NOT a AND two.v = 9)");
    assert!(
        may(UNITS, variables, chosen, "one.v = 7") && may(UNITS, variables, chosen, "two.v = 9")
    );
    // Whatever the scan before has left in it: one of those whose addresses are taken.
    let kept = "one.v := 0; two.v := 0; m.Run(3); IF a THEN m := one; ELSE m := two; END_IF";
    always(UNITS, variables, kept, "(one.v = 3) <> (two.v = 5)");
    assert!(may(UNITS, variables, kept, "one.v = 3") && may(UNITS, variables, kept, "two.v = 5"));
    // An interface that another one extends.
    let wider = "IF a THEN m := one; ELSE m := two; END_IF named := m; n := named.Id();";
    always(UNITS, variables, wider, "a = (n = 1) AND a = (n <> 2)");
    always(
        UNITS,
        variables,
        "m := one; IF a THEN m := 0; END_IF",
        "a = (m = 0) AND a <> (m <> NULL)",
    );
}

#[test]
fn properties_are_read_and_written_by_their_methods() {
    let variables = "one : Base; two : Derived; m : I_Motor; n : INT;";
    always(UNITS, variables, "one.Speed := 5; n := one.Speed;", "n = 105 AND one.v = 105");
    always(UNITS, variables, "two.Speed := 5;", "two.Speed = 105 AND two.v = 105");
    let chosen = "one.v := 0; two.v := 0; IF a THEN m := one; ELSE m := two; END_IF
        m.Speed := w; n := m.Speed;";
    assert!(!may(
        UNITS,
        variables,
        chosen,
        "a AND w = 3 AND (one.v <> 103 OR two.v <> 0 OR n <> 103)"
    ));
    assert!(may(UNITS, variables, chosen, "NOT a AND two.v = 103 AND n = 103"));
    // What a property does counts where a loop goes by what it may change.
    let unit = "FUNCTION_BLOCK B VAR n : INT; END_VAR PROPERTY P : INT GET n := 0; P := 1; END_GET END_PROPERTY
        WHILE n < 10 DO n := n + P; END_WHILE END_FUNCTION_BLOCK";
    assert_eq!(refused(unit, "o : B;", "o();")[0].0, Code::LoopCount);
    let unit = "FUNCTION_BLOCK B VAR n, k : INT; END_VAR PROPERTY P : INT GET k := 0; P := 1; END_GET END_PROPERTY
        METHOD M VAR n : INT; END_VAR n := 3; END_METHOD
        n := 0; WHILE n < 10 DO n := n + 1; k := P; M(); END_WHILE END_FUNCTION_BLOCK";
    always(unit, "o : B;", "o();", "o.n = 10");
}

#[test]
fn a_part_of_what_a_property_gives_is_taken_behind_its_call() {
    let units = "TYPE T : STRUCT a, b : INT; e : ARRAY[1..2] OF INT; END_STRUCT; END_TYPE
        FUNCTION_BLOCK Inner VAR x : INT; END_VAR METHOD Put VAR_INPUT n : INT; END_VAR x := n; END_METHOD
        END_FUNCTION_BLOCK
        FUNCTION_BLOCK Outer VAR v : INT; inner, other : Inner; k : INT; END_VAR
        PROPERTY P : T GET P.a := v; P.b := v + 1; P.e[2] := 5; v := v + 10; END_GET END_PROPERTY
        PROPERTY W : WORD GET W := 8; END_GET END_PROPERTY
        PROPERTY R : REFERENCE TO Inner
          GET IF v = 0 THEN R REF= inner; ELSE R REF= other; END_IF END_GET END_PROPERTY
        PROPERTY Q : REFERENCE TO INT GET Q REF= k; END_GET END_PROPERTY
        METHOD Own : INT Own := P.b; END_METHOD
        METHOD Turn : INT v := 1 - v; Turn := R.x; v := 1 - v; END_METHOD
        END_FUNCTION_BLOCK
        FUNCTION_BLOCK More EXTENDS Outer
        PROPERTY P : T GET P.b := 40; END_GET END_PROPERTY
        METHOD Base : INT Base := SUPER^.P.b; END_METHOD
        END_FUNCTION_BLOCK";
    let variables = "o : Outer; m : More; l : ARRAY[1..2] OF Outer; i, n : INT; ok : BOOL;";
    always(units, variables, "o.v := 3; n := o.P.a + o.P.b;", "n = 17 AND o.v = 23");
    always(units, variables, "n := o.P.e[2]; ok := o.W.3 AND NOT o.W.2;", "n = 5 AND ok");
    always(units, variables, "o.v := 1; n := o.Own();", "n = 2");
    // The one that the instance has, or that of its base.
    always(units, variables, "m.v := 7; n := m.Own();", "n = 40");
    always(units, variables, "m.v := 7; n := m.Base();", "n = 8");
    // What a reference means is written.
    always(
        units,
        variables,
        "o.v := 0; o.inner.x := 0; o.R.x := 3; o.v := 1; o.R.Put(4); n := o.R.x;",
        "o.inner.x = 3 AND o.other.x = 4 AND n = 4",
    );
    always(units, variables, "o.k := 6; n := o.Q;", "n = 6");
    // Whether one that stands alone is read, controllers differ.
    let alone = "o.v := 1; o.P;";
    assert!(may(units, variables, alone, "o.v = 1") && may(units, variables, alone, "o.v = 11"));
    // A part of a value that is only a copy, an instance of unknown number, and what changes before it is looked at.
    for body in ["o.P.a := 1;", "n := l[i].P.a;", "o.R.x := o.Turn();", "SETS(o.P.a);"] {
        let setting = "FUNCTION SETS : INT VAR_IN_OUT x : INT; END_VAR x := 1; END_FUNCTION";
        let told = refused(&format!("{units} {setting}"), variables, body);
        assert_eq!(told[0].0, Code::NotModelled, "{body}: {told:?}");
    }
    // Where a property stands in the end of a loop, it may be moved.
    let told = refused(units, variables, "FOR i := 1 TO o.P.a DO n := n + 1; END_FOR");
    assert_eq!(told[0].0, Code::LoopCount);
}

#[test]
fn the_base_is_called_as_the_base_and_this_as_the_instance() {
    let variables = "two : Derived; n : INT; ok : BOOL;";
    always(UNITS, variables, "two();", "two.bodies = 11");
    always(UNITS, variables, "ok := two.Run(1); n := two.Id();", "two.runs = 5 AND n = 2");
    // The base's body is carried out by the loop that it is called in.
    let units = "FUNCTION_BLOCK B VAR i : INT; END_VAR i := 0; END_FUNCTION_BLOCK
        FUNCTION_BLOCK D EXTENDS B WHILE i < 5 DO i := i + 1; SUPER^(); END_WHILE END_FUNCTION_BLOCK";
    assert_eq!(refused(units, "d : D;", "d();")[0].0, Code::LoopCount);
    let units = "FUNCTION_BLOCK B VAR p : POINTER TO B; x : INT; END_VAR p := THIS; x := 3; p^.x := x + 1; END_FUNCTION_BLOCK";
    always(units, "o : B;", "o();", "o.x = 4");
    let units = "FUNCTION_BLOCK B VAR p : POINTER TO B; i : INT; END_VAR p := THIS; i := 0;
        WHILE i < 5 DO i := i + 1; p^.i := 0; END_WHILE END_FUNCTION_BLOCK";
    assert_eq!(refused(units, "o : B;", "o();")[0].0, Code::LoopCount);
}

#[test]
fn references_and_pointers_stand_for_variables() {
    let variables = "x, y, z : INT; f : ARRAY[1..3] OF INT; r, s : REFERENCE TO INT; p : POINTER TO INT; ok : BOOL;";
    always("", variables, "x := 1; r REF= x; r := r + 1; y := r;", "x = 2 AND y = 2");
    always(
        "",
        variables,
        "x := 1; y := 1; p := ADR(x); p^ := 5; p := ADR(y); p^ := p^ + 6;",
        "x = 5 AND y = 7",
    );
    let either =
        "x := 1; y := 1; IF a THEN p := ADR(x); ELSE p := ADR(y); END_IF p^ := 9; z := p^;";
    always("", variables, either, "z = 9 AND (a = (x = 9)) AND (a <> (y = 9))");
    always("", variables, "r REF= x; s REF= r; s := 4; ok := __ISVALIDREF(s);", "x = 4 AND ok");
    always(
        "",
        variables,
        "p := ADR(x); IF a THEN p := 0; END_IF",
        "a = (p = 0) AND a <> (p <> NULL)",
    );
    // Which element is meant is worked out where its address is taken.
    let element =
        "f[1] := 0; f[2] := 0; f[3] := 0; z := LIMIT(1, w, 3); p := ADR(f[z]); z := 1; p^ := 8;";
    always(
        "",
        variables,
        element,
        "f[1] + f[2] + f[3] = 8 AND (w <= 1) = (f[1] = 8) AND (w = 2) = (f[2] = 8)",
    );
    let shown = "S : STRUCT n : INT; q : POINTER TO INT; END_STRUCT;";
    let units = format!("TYPE {shown} END_TYPE");
    let more = "s1, s2 : S; x : INT; ps : POINTER TO S;";
    let body = "s1.n := 1; s2.n := 2; IF a THEN ps := ADR(s1); ELSE ps := ADR(s2); END_IF ps^.q := ADR(x); ps^.q^ := ps^.n;";
    always(&units, more, body, "(a AND x = 1) OR (NOT a AND x = 2)");
    // A function is handed a reference.
    let units = "FUNCTION Two : INT VAR_INPUT r : REFERENCE TO INT; END_VAR r := r * 2; Two := r; END_FUNCTION";
    always(units, variables, "x := 3; y := 4; z := Two(x) + Two(y);", "x = 6 AND y = 8 AND z = 14");
}

#[test]
fn what_is_meant_at_first_is_found() {
    let variables =
        "x : INT; y : DINT; p : POINTER TO INT := ADR(x); r : REFERENCE TO DINT REF= y;";
    // Only these can be meant, and the scan says nothing else.
    always("", variables, "x := 0; y := 0; p^ := 3; r := 4;", "x = 3 AND y = 4");
    let units = "INTERFACE I METHOD M END_METHOD END_INTERFACE
        FUNCTION_BLOCK A IMPLEMENTS I VAR_OUTPUT n : INT; END_VAR METHOD M n := 1; END_METHOD END_FUNCTION_BLOCK
        FUNCTION_BLOCK B IMPLEMENTS I VAR_OUTPUT n : INT; END_VAR METHOD M n := 2; END_METHOD END_FUNCTION_BLOCK
        FUNCTION_BLOCK User VAR_INPUT i : I; END_VAR VAR j : I; END_VAR
          METHOD FB_Init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; k : I; END_VAR j := k; END_METHOD
          METHOD Both i.M(); j.M(); END_METHOD
        END_FUNCTION_BLOCK";
    for declared in ["u : User(k := t);", "u : User := (k := t);"] {
        let variables = format!("o : A; t : B; {declared}");
        let body = "o.n := 0; t.n := 0; u.i := o; u.Both();";
        assert!(may(units, &variables, body, "t.n = 2") && may(units, &variables, body, "o.n = 1"));
    }
    let listed = "o : A; t : B; all : ARRAY[1..2] OF I := [o, t]; k : INT;";
    let body = "o.n := 0; t.n := 0; FOR k := 1 TO 2 DO all[k].M(); END_FOR";
    assert!(may(units, listed, body, "o.n = 1") && may(units, listed, body, "t.n = 2"));
    // What FB_Init leaves is not known to be 0.
    let left = "FUNCTION_BLOCK L VAR_OUTPUT n : INT; END_VAR METHOD FB_Init : BOOL n := 3; END_METHOD END_FUNCTION_BLOCK";
    assert!(
        trusting(Trust::All, "main.st", &program(left, "l : L;", "l();", "l.n = 3"))
            .is_ok_and(|found| micros(&found) >= PROBE)
    );
    let global = format!("{units} VAR_GLOBAL o : A; t : B; i : I := t; END_VAR");
    // A variable of the program's own hides nothing from a list of global variables.
    always(&global, "t : A;", "i.M();", "main.t.n = main.t.n");
    assert!(may(&global, "x : INT;", "t.n := 0; i.M();", "t.n = 2"));
}

#[test]
fn what_is_not_followed_is_refused() {
    let variables = "x : INT; d : DINT; p : POINTER TO INT; r : REFERENCE TO INT; q : POINTER TO DINT; n : UDINT;";
    for body in [
        "p^ := 1;",
        "r := 1;",
        "p := n; p^ := 1;",
        "p := ADR(x) + 2; p^ := 1;",
        "q := ADR(x); q^ := 1;",
        "p := ADR(x); q := p; q^ := 1;",
    ] {
        assert!(
            refused("", variables, body).iter().all(|(code, _)| *code == Code::NotModelled),
            "{body}"
        );
    }
    assert!(!refused("", variables, "p := ADR(x); p[1] := 1;").is_empty());
    // What it inherits is not there, and would cost nothing.
    for units in [
        "FUNCTION_BLOCK B EXTENDS Missing END_FUNCTION_BLOCK",
        "TYPE B EXTENDS Missing : STRUCT n : INT; END_STRUCT END_TYPE",
    ] {
        assert_eq!(refused(units, "o : B;", "")[0].0, Code::UnknownType, "{units}");
    }
    // A copy has no address of its own.
    let units = "FUNCTION_BLOCK B VAR_IN_OUT io : INT; END_VAR VAR p : POINTER TO INT; END_VAR p := ADR(io); p^ := 1; END_FUNCTION_BLOCK";
    assert_eq!(refused(units, "o : B; x : INT;", "o(io := x);")[0].0, Code::NotModelled);
    // Nor has an instance that is handed over so, whose own method says where it is.
    let units = "FUNCTION_BLOCK I VAR_OUTPUT n : INT; END_VAR METHOD Tell known := THIS; END_METHOD END_FUNCTION_BLOCK
        FUNCTION_BLOCK B VAR_IN_OUT io : I; END_VAR io.Tell(); END_FUNCTION_BLOCK
        VAR_GLOBAL known : POINTER TO I; END_VAR";
    assert_eq!(
        refused(units, "o : B; i : I;", "o(io := i); known^.n := 1;")[0].0,
        Code::NotModelled
    );
    // An instance of a method's own carries out FB_Init with each call.
    let units = "FUNCTION_BLOCK I VAR_OUTPUT n : INT; END_VAR METHOD FB_Init : BOOL n := 3; END_METHOD END_FUNCTION_BLOCK
        FUNCTION_BLOCK B METHOD M VAR i : I; END_VAR i(); END_METHOD END_FUNCTION_BLOCK";
    assert_eq!(refused(units, "o : B;", "o.M();")[0].0, Code::NotModelled);
    // What is called may write what it is handed over in and out through a pointer, too.
    let units = "FUNCTION_BLOCK B VAR_IN_OUT io : INT; END_VAR VAR_INPUT p : POINTER TO INT; END_VAR p^ := 1; io := io + 1; END_FUNCTION_BLOCK";
    assert_eq!(
        refused(units, "o : B; x : INT;", "o(io := x, p := ADR(x));")[0].0,
        Code::NotModelled
    );
    always(units, "o : B; x, y : INT;", "x := 1; o(io := x, p := ADR(y));", "x = 2 AND y = 1");
    // A loop that writes its own variable through a pointer.
    let loops = "i : INT; x : INT; p : POINTER TO INT;";
    assert_eq!(
        refused("", loops, "p := ADR(i); i := 0; WHILE i < 9 DO i := i + 1; p^ := 0; END_WHILE")[0]
            .0,
        Code::LoopCount
    );
    always(
        "",
        loops,
        "p := ADR(x); i := 0; WHILE i < 9 DO i := i + 1; p^ := 0; END_WHILE",
        "i = 9 AND x = 0",
    );
}

#[test]
fn variables_of_all_instances_and_of_methods_keep_their_values() {
    let units = "FUNCTION_BLOCK B VAR_STAT all : INT; END_VAR VAR own : INT; END_VAR
          METHOD Reset VAR_INST times : INT; END_VAR all := 0; own := 0; times := 3; END_METHOD
          METHOD Count : INT VAR_INST times : INT; END_VAR all := all + 1; own := own + 1; times := own; Count := times; END_METHOD
        END_FUNCTION_BLOCK";
    let body =
        "o.Reset(); t.Reset(); x := o.Count(); y := t.Count(); y := t.Count(); z := o.Count();";
    always(units, "o, t : B; x, y, z : INT;", body, "x = 1 AND y = 2 AND z = 2 AND o.own = 2");
    let units = "FUNCTION_BLOCK B VAR_STAT n : INT; END_VAR VAR_INPUT begin : BOOL; END_VAR VAR_OUTPUT c : INT; END_VAR
        IF begin THEN n := 0; END_IF n := n + 1; c := n; END_FUNCTION_BLOCK";
    always(units, "o, t : B;", "o(begin := TRUE); t(begin := FALSE);", "o.c = 1 AND t.c = 2");
    let types = "TYPE Part : STRUCT n : INT; END_STRUCT Whole EXTENDS Part : STRUCT m : INT; END_STRUCT END_TYPE";
    always(types, "s : Whole;", "s.n := 1; s.m := 2;", "s.n + s.m = 3");
    always("", "x, y, z : INT;", "x := y := z := 4;", "x = 4 AND y = 4 AND z = 4");
}

/// As CODESYS writes it: methods, properties, interfaces and what is extended stand in additional data.
#[test]
fn additional_data_of_xml_say_the_same_as_text() {
    let data = |name: &str, inner: &str| {
        format!(
            "<data name=\"http://www.3s-software.com/plcopenxml/{name}\" handleUnknown=\"implementation\">{inner}</data>"
        )
    };
    let st = |text: &str| {
        format!(
            "<body><ST><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{text}</xhtml></ST></body>"
        )
    };
    let plain = |text: &str| {
        format!(
            "<InterfaceAsPlainText><xhtml xmlns=\"http://www.w3.org/1999/xhtml\">{text}</xhtml></InterfaceAsPlainText>"
        )
    };
    let variable =
        |name: &str, of: &str| format!("<variable name=\"{name}\"><type>{of}</type></variable>");
    let returns = |of: &str| format!("<returnType>{of}</returnType>");
    let inherits = |what: &str| {
        format!(
            "<addData>{}</addData>",
            data("pouinheritance", &format!("<Inheritance>{what}</Inheritance>"))
        )
    };
    let property = |get: &str, set: &str| {
        let interface = returns("<INT/>");
        data("property", &format!("<Property name=\"Speed\"><interface>{interface}</interface>
            <GetAccessor><interface/>{}</GetAccessor><SetAccessor><interface/>{}</SetAccessor></Property>", st(get), st(set)))
    };
    let method = |name: &str, of: &str, text: &str, declared: &str| {
        data(
            "method",
            &format!(
                "<Method name=\"{name}\"><interface>{of}</interface>{}{}</Method>",
                st(text),
                plain(declared)
            ),
        )
    };
    let base = format!(
        "<pou name=\"Base\" pouType=\"functionBlock\"><interface><localVars>{}</localVars>{}</interface>{}<addData>{}{}{}</addData></pou>",
        variable("v", "<INT/>"),
        inherits("<Implements>I</Implements>"),
        st(""),
        // A method declares variables of its own, which are none of the block.
        method(
            "Run",
            &returns("<INT/>"),
            "times := v; Run := times;",
            "METHOD Run : INT VAR_INST times : INT; END_VAR VAR CONSTANT v2 : INT; END_VAR"
        ),
        property("Speed := v;", "v := Speed + 1;"),
        data(
            "interfaceasplaintext",
            &plain("FUNCTION_BLOCK Base IMPLEMENTS I VAR v : INT; END_VAR")
        ),
    );
    let derived = format!(
        "<pou name=\"Derived\" pouType=\"functionBlock\"><interface>{}</interface>{}<addData>{}</addData></pou>",
        inherits("<Extends>Base</Extends>"),
        st(""),
        method("Run", &returns("<INT/>"), "Run := SUPER^.Run() * 2;", "METHOD Run : INT"),
    );
    let interface = data("interface", &format!(
        "<Interface name=\"I\"><Methods><Method name=\"Run\"><interface>{0}</interface></Method></Methods>
         <Properties><Property name=\"Speed\"><interface>{0}</interface><GetAccessor/><SetAccessor/></Property></Properties>{1}</Interface>",
        returns("<INT/>"), plain("INTERFACE I"),
    ));
    let xml = |condition: &str| {
        let variables: String = [
            ("o", "<derived name=\"Base\"/>"),
            ("t", "<derived name=\"Derived\"/>"),
            ("i", "<derived name=\"I\"/>"),
            ("r", "<derived name=\"REFERENCE TO INT\"/>"),
            ("q", "<pointer><baseType><INT/></baseType></pointer>"),
            ("n", "<INT/>"),
            ("m", "<INT/>"),
            ("probe", "<derived name=\"TON\"/>"),
        ]
        .iter()
        .map(|(name, of)| variable(name, of))
        .collect();
        let text = format!("i := t; i.Speed := 4; n := i.Run(); i := o; i.Speed := 1; r REF= m; q := ADR(m); r := i.Run(); q^ := q^ + 5;
            IF {condition} THEN probe(); END_IF");
        let text = text.replace('<', "&lt;");
        let main = format!(
            "<pou name=\"main\" pouType=\"program\"><interface><localVars>{variables}</localVars></interface>{}</pou>",
            st(&text)
        );
        format!("<?xml version=\"1.0\" encoding=\"utf-8\"?><project xmlns=\"http://www.plcopen.org/xml/tc6_0200\">
            <types><dataTypes/><pous>{main}{base}{derived}</pous></types><addData>{interface}</addData></project>")
    };
    let bound = |condition: &str| {
        micros(&audited("main.xml", &xml(condition)).unwrap_or_else(|faults| panic!("{faults:?}")))
    };
    assert!(bound("n = 10 AND m = 7 AND o.v = 2 AND t.v = 5") >= PROBE);
    assert!(bound("n <> 10 OR m <> 7 OR o.v <> 2 OR t.v <> 5") < PROBE);
}

#[test]
fn what_is_handed_over_in_and_out_is_reached_by_calls_alone() {
    let unit = "FUNCTION_BLOCK F VAR_IN_OUT x : INT; END_VAR VAR y : INT; END_VAR
        METHOD Look : INT Look := x; END_METHOD
        METHOD Around : INT Around := THIS^.Look(); END_METHOD
        METHOD Own : INT VAR x : INT; END_VAR Own := x + y; END_METHOD
        PROPERTY P : INT GET P := x; END_GET END_PROPERTY
        y := Look(); Act();
        ACTION Act: x := 5; END_ACTION
        END_FUNCTION_BLOCK
        FUNCTION_BLOCK D EXTENDS F END_FUNCTION_BLOCK";
    let of = |statements: &str| {
        audited(
            "main.st",
            &format!("{unit} PROGRAM main VAR f1 : F; d1 : D; g, n : INT; END_VAR {statements} END_PROGRAM"),
        )
        .map(|_| ())
        .map_err(|faults| faults[0].0)
    };
    assert_eq!(of("f1(x := g); n := f1.Own(); n := f1.y;"), Ok(()));
    for outside in [
        "n := f1.Look();",
        "n := f1.Around();",
        "n := f1.P;",
        "f1.Act();",
        "f1.x := 5;",
        "n := f1.x;",
        "n := d1.Look();",
        "f1();",
    ] {
        assert_eq!(of(&format!("f1(x := g); {outside}")), Err(Code::NotModelled), "{outside}");
    }
}

#[test]
fn a_private_method_of_a_base_is_not_taken_for_another() {
    let of = |access: &str| {
        let text = format!(
            "FUNCTION_BLOCK B METHOD {access} M ; END_METHOD METHOD R M(); END_METHOD END_FUNCTION_BLOCK
            FUNCTION_BLOCK F EXTENDS B METHOD M ; END_METHOD END_FUNCTION_BLOCK
            PROGRAM main VAR f1 : F; END_VAR f1.R(); END_PROGRAM"
        );
        audited("main.st", &text).map(|_| ()).map_err(|faults| faults[0].0)
    };
    assert_eq!(of("PRIVATE"), Err(Code::NotModelled));
    assert_eq!(of("PROTECTED"), Ok(()));
    assert_eq!(of(""), Ok(()));
}

#[test]
fn where_an_output_goes_stays_the_same_while_the_call_runs() {
    let of = |given: &str| {
        let text = format!(
            "VAR_GLOBAL idx : INT; END_VAR
            FUNCTION_BLOCK F VAR_INPUT n : INT; END_VAR VAR_OUTPUT o : INT; END_VAR VAR_EXTERNAL idx : INT; END_VAR
            o := n; idx := 2; END_FUNCTION_BLOCK
            PROGRAM main VAR f1 : F; ga : ARRAY[1..3] OF INT; k : INT; END_VAR VAR_EXTERNAL idx : INT; END_VAR
            k := LIMIT(1, k, 3); f1({given}); END_PROGRAM"
        );
        audited("main.st", &text).map(|_| ()).map_err(|faults| faults[0].0)
    };
    assert_eq!(of("n := ga[k], o => ga[k]"), Ok(()));
    assert_eq!(of("n := ga[idx], o => k"), Ok(()));
    assert_eq!(of("o => ga[idx]"), Err(Code::NotModelled));
}

#[test]
fn instances_within_structures_are_called_by_numbers_that_are_worked_out() {
    let units = "TYPE S : STRUCT t : ARRAY[1..2] OF TON; n : INT; END_STRUCT END_TYPE";
    let variables = "s : ARRAY[0..3] OF S; k, j : INT;";
    let calls =
        "FOR k := 0 TO 3 DO FOR j := 1 TO 2 DO s[k].t[j](IN := TRUE, PT := T#1s); END_FOR END_FOR";
    let text = program(units, variables, calls, "a AND NOT a");
    let found = audited("main.st", &text).unwrap_or_else(|faults| panic!("{faults:?}"));
    assert_eq!(micros(&found) / PROBE, 8);
}

#[test]
fn of_a_library_the_declaration_and_the_time_are_enough() {
    let units = "VAR_GLOBAL last : INT; other : INT; END_VAR
        FUNCTION_BLOCK LOGGER VAR_INPUT level : INT; END_VAR VAR_OUTPUT done : BOOL; END_VAR VAR_IN_OUT count : INT; END_VAR
        METHOD Pending : INT VAR_INPUT now : BOOL; END_VAR END_METHOD END_FUNCTION_BLOCK
        FUNCTION_BLOCK QUIET EXTENDS LOGGER SUPER^(); END_FUNCTION_BLOCK
        FUNCTION CHECKSUM : INT VAR_INPUT a, b : INT; END_VAR END_FUNCTION
        FUNCTION HANDED : INT VAR_INPUT p : POINTER TO INT; END_VAR END_FUNCTION";
    let facts = "[calls]\nLOGGER = { time = '20us' }\n'LOGGER.Pending' = { time = '3us' }
        CHECKSUM = { time = '7us', writes = ['last'] }\nHANDED = { time = '1us' }\n";
    let of = |facts: &str, statements: &str| {
        let text = format!(
            "{units} PROGRAM main VAR log, two : LOGGER; q : QUIET; n, io : INT; d : DWORD; t : TON; END_VAR
             VAR_EXTERNAL last, other : INT; END_VAR {statements} END_PROGRAM"
        );
        let facts = Facts::parse("facts.toml", facts).expect("facts");
        let table = table();
        let inputs = [Input { name: "main.st".to_owned(), bytes: text.into_bytes() }];
        let request = Request {
            table: Some(&table),
            dialect: Some("iec-text"),
            ..Request::new(&inputs, &facts)
        };
        match audit(&request) {
            Ok(found) => Ok(micros(&found)),
            Err(Failure::Input(faults)) => Err(faults[0].code),
            Err(other) => panic!("{statements}: {other:?}"),
        }
    };
    let stores = |statements: &str, took: u64| {
        let found = of(facts, statements).unwrap_or_else(|code| panic!("{statements}: {code:?}"));
        assert!((took..took + 10).contains(&found), "{statements}: {found}");
    };
    stores("log(count := io);", 20);
    stores("log(count := io); two(count := io); n := CHECKSUM(1, 2);", 47);
    stores("n := log.Pending(TRUE) + log.Pending(FALSE);", 6);
    let may = |statements: &str, condition: &str| {
        let text = format!("{statements} IF {condition} THEN t(); END_IF");
        of(facts, &text).expect("a bound") >= PROBE
    };
    let call = "io := 1; log(level := 3, count := io);";
    for what in ["log.done", "NOT log.done", "io <> 1", "log.level <> 3", "n <> 1"] {
        assert!(may(&format!("{call} n := CHECKSUM(1, 2);"), what), "{what}");
    }
    assert!(may("last := 1; n := CHECKSUM(1, 2);", "last <> 1"));
    // What it is not handed it does not write.
    assert!(!may(
        &format!("n := 1; other := 1; {call}"),
        "n <> 1 OR other <> 1 OR two.level <> two.level"
    ));
    // Nor where an address may be.
    for address in ["n := HANDED(ADR(io));", "d := ADR(io);", "d := ADR(io) + 2;"] {
        let text = format!("{address} {call}");
        assert_eq!(of(facts, &text), Err(Code::NotModelled), "{address}");
    }
    assert_eq!(
        of("[calls]\nCHECKSUM = { time = '7us', writes = ['nowhere'] }", "n := CHECKSUM(1, 2);"),
        Err(Code::Fact)
    );
    assert_eq!(of("", "n := UNDECLARED(1);"), Err(Code::UnknownName));
    // A body that is there is followed.
    assert!(!may("q(count := io);", "FALSE"));
    stores("q(count := io);", 20);
}

#[test]
fn what_nothing_calls_does_not_move_a_loops_end() {
    let of = |methods: &str, other: &str| {
        let text = format!(
            "INTERFACE I METHOD M : INT END_METHOD END_INTERFACE
            FUNCTION_BLOCK A IMPLEMENTS I VAR inner : Mgr2; END_VAR METHOD M : INT {other} END_METHOD END_FUNCTION_BLOCK
            FUNCTION_BLOCK Mgr2 VAR cnt : INT; END_VAR METHOD Clr cnt := 0; END_METHOD END_FUNCTION_BLOCK
            FUNCTION_BLOCK Mgr VAR t : I; cnt : INT; END_VAR
            METHOD Add IF cnt < 3 THEN cnt := cnt + 1; END_IF END_METHOD {methods}
            METHOD Run VAR k : INT; END_VAR FOR k := 1 TO cnt DO t.M(); END_FOR END_METHOD
            PROPERTY P : INT GET P := cnt; cnt := 0; END_GET END_PROPERTY
            END_FUNCTION_BLOCK
            VAR_GLOBAL mm : Mgr; END_VAR
            PROGRAM main VAR o : A; END_VAR mm.t := o; mm.cnt := 2; mm.Add(); mm.Run(); END_PROGRAM"
        );
        audited("main.st", &text).map(|_| ()).map_err(|faults| faults[0].0)
    };
    assert_eq!(of("", "M := 1;"), Ok(()));
    assert_eq!(of("METHOD M2 cnt := 0; END_METHOD", "M := 1;"), Ok(()));
    let clear = "METHOD Clr cnt := 0; END_METHOD";
    // What is called of another unit writes its own variable, whatever it is called.
    for own in [
        clear,
        "METHOD Clr ; END_METHOD",
        "METHOD Clr Clr2(); END_METHOD METHOD Clr2 cnt := 0; END_METHOD",
    ] {
        assert_eq!(of(own, "inner.Clr();"), Ok(()));
    }
    assert_eq!(of(clear, "mm.Clr();"), Err(Code::LoopCount));
    assert_eq!(of("METHOD Clr ; END_METHOD", "mm.Clr();"), Ok(()));
    assert_eq!(of("", "M := mm.P;"), Err(Code::LoopCount));
}

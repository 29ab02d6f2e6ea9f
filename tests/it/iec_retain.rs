//! What keeps its values when the power fails: it may come up with what a scan left that was cut off anywhere, beside
//! what begins anew.

use scanbound::audit::{Request, audit};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// What the probe takes, in microseconds; nothing else takes anything.
const PROBE: u64 = 1000;

fn bound(text: &str) -> u64 {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += &format!("LN,{PROBE},{PROBE}\n@end,0,\n");
    let table = Table::parse("t.csv", rows.as_bytes()).expect("a table").table;
    let inputs = [Input { name: "main.st".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::default();
    let request =
        Request { table: Some(&table), trust: Trust::All, ..Request::new(&inputs, &facts) };
    let found = audit(&request).unwrap_or_else(|failure| panic!("{failure:?}\n{text}"));
    found.bound.upper.0 / 1_000_000
}

/// Two bits of a block of which each scan leaves one on. One that is cut off between its two stores may leave both.
const BLOCK: &str = "FUNCTION_BLOCK Pair VAR b, x : BOOL; END_VAR VAR_INPUT i : BOOL; END_VAR VAR_OUTPUT o : BOOL; END_VAR \
    o := b AND x; x := NOT i; b := i; END_FUNCTION_BLOCK \
    FUNCTION_BLOCK Around VAR_INPUT i : BOOL; END_VAR VAR pair : Pair; END_VAR pair(i := i); END_FUNCTION_BLOCK \
    FUNCTION_BLOCK Kept VAR_INPUT i : BOOL; END_VAR VAR RETAIN pair : Pair; END_VAR pair(i := i); END_FUNCTION_BLOCK ";

fn program(kept: &str, instance: &str, output: &str) -> String {
    format!(
        "{BLOCK} PROGRAM main VAR {kept} fb : {instance}; END_VAR VAR a AT %IX0.0 : BOOL; probe : REAL; END_VAR \
         fb(i := a); IF fb.{output} THEN probe := LN(probe); END_IF END_PROGRAM"
    )
}

#[test]
fn an_instance_keeps_all_that_is_in_it() {
    for (instance, output) in [("Pair", "o"), ("Around", "pair.o"), ("ARRAY[0..1] OF Pair", "o")] {
        let text = |kept: &str| {
            let text = program(kept, instance, output);
            if instance.starts_with("ARRAY") {
                text.replace("fb(", "fb[1](").replace("fb.", "fb[1].")
            } else {
                text
            }
        };
        assert_eq!(bound(&text("")), 0, "{instance}");
        assert_eq!(bound(&text("RETAIN")), PROBE, "{instance}");
    }
    assert_eq!(bound(&program("", "Kept", "pair.o")), PROBE);
}

#[test]
fn lists_of_globals_and_programs_keep_what_is_in_them() {
    let global = |kept: &str| {
        format!(
            "{BLOCK} PROGRAM main VAR_EXTERNAL fb : Pair; END_VAR VAR a AT %IX0.0 : BOOL; probe : REAL; END_VAR \
             fb(i := a); IF fb.o THEN probe := LN(probe); END_IF END_PROGRAM \
             CONFIGURATION c VAR_GLOBAL {kept} fb : Pair; END_VAR PROGRAM one : main; END_CONFIGURATION"
        )
    };
    assert_eq!((bound(&global("")), bound(&global("RETAIN"))), (0, PROBE));
    let whole = |kept: &str| {
        program("", "Pair", "o")
            + &format!(" CONFIGURATION c PROGRAM {kept} one : main; END_CONFIGURATION")
    };
    assert_eq!((bound(&whole("")), bound(&whole("NON_RETAIN"))), (0, 0));
    assert_eq!(bound(&whole("RETAIN")), PROBE);
}

#[test]
fn a_chart_that_is_kept_goes_on_where_the_power_failed() {
    // Both steps are never active together; but a controller may be cut off while it moves from one to the other.
    let text = |kept: &str| {
        format!(
            "FUNCTION_BLOCK Walk VAR i AT %IX0.0 : BOOL; END_VAR
             INITIAL_STEP a: END_STEP STEP b: END_STEP
             TRANSITION FROM a TO b := i; END_TRANSITION TRANSITION FROM b TO a := i; END_TRANSITION
             END_FUNCTION_BLOCK
             PROGRAM main VAR {kept} fb : Walk; END_VAR VAR probe : REAL; END_VAR
             fb(); IF fb.a.X AND fb.b.X THEN probe := LN(probe); END_IF END_PROGRAM"
        )
    };
    assert_eq!((bound(&text("")), bound(&text("RETAIN"))), (0, PROBE));
    // Also an instance that has no variables.
    let bare = |kept: &str| {
        text(kept).replace("VAR i AT %IX0.0 : BOOL; END_VAR", "").replace(":= i;", ":= TRUE;")
    };
    assert_eq!((bound(&bare("")), bound(&bare("RETAIN"))), (0, PROBE));
    // Also where some block begins with a method.
    let begins = |kept: &str| {
        "FUNCTION_BLOCK B VAR n : INT; END_VAR METHOD FB_Init : BOOL n := 1; END_METHOD END_FUNCTION_BLOCK "
            .to_owned()
            + &text(kept).replace("VAR probe", "VAR b : B; probe")
    };
    assert_eq!((bound(&begins("")), bound(&begins("RETAIN"))), (0, PROBE));
}

/// A call changes its caller's variable itself. If power cuts it off, the variable keeps what the call has written.
#[test]
fn a_retained_argument_keeps_what_a_call_wrote_that_was_cut_off() {
    let block = |body: &str| {
        format!(
            "TYPE S : STRUCT b : BOOL; n : INT; END_STRUCT; END_TYPE \
             FUNCTION_BLOCK Writes VAR_IN_OUT z : INT; END_VAR VAR p : INT; END_VAR p := z; z := -5; z := p; \
             END_FUNCTION_BLOCK \
             FUNCTION_BLOCK Passes VAR_IN_OUT y : INT; END_VAR VAR i : Writes; END_VAR i(z := y); END_FUNCTION_BLOCK \
             FUNCTION_BLOCK Parts VAR_IN_OUT z : S; END_VAR VAR p : INT; END_VAR p := z.n; z.n := -5; z.n := p; \
             END_FUNCTION_BLOCK \
             FUNCTION Fun : INT VAR_IN_OUT z : INT; END_VAR VAR p : INT; END_VAR p := z; z := -5; z := p; Fun := p; \
             END_FUNCTION \
             PROGRAM main {body} END_PROGRAM"
        )
    };
    for (kept, bound_in_us) in [("RETAIN", PROBE), ("", 0)] {
        for (ty, part, call) in [
            ("INT", "", "w(z := n);"),
            ("INT", "", "v(y := n);"),
            ("INT", "", "k := Fun(z := n);"),
            ("S", ".n", "u(z := n);"),
            ("S", ".n", "w(z := n.n);"),
            ("ARRAY[0..1] OF INT", "[1]", "w(z := n[1]);"),
        ] {
            let text = block(&format!(
                "VAR {kept} n : {ty}; END_VAR VAR w : Writes; v : Passes; u : Parts; k : INT; probe : REAL; END_VAR \
                 {call} IF n{part} = -5 THEN probe := LN(probe); END_IF n{part} := 1;"
            ));
            assert_eq!(bound(&text), bound_in_us, "{kept} {call}");
        }
    }
}

//! Projects of several tasks: each is bounded by itself, what others write may change at any moment, and how long each
//! takes where others interrupt it is worked out.

use scanbound::audit::{Audit, Failure, Request, TaskUse, conclude, follow, tasks};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};

/// A store takes a microsecond, and nothing else anything.
fn table() -> Table {
    let mut rows = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        rows += &format!("@{class},0,0\n");
    }
    rows += "ST,1,1\n@end,0,\n";
    Table::parse("t.csv", rows.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table
}

fn audited(text: &str, task: Option<&str>, facts: &Facts) -> Result<Audit, Vec<Code>> {
    let table = table();
    let inputs = [Input { name: "main.st".to_owned(), bytes: text.as_bytes().to_vec() }];
    let request =
        Request { table: Some(&table), trust: Trust::None, task, ..Request::new(&inputs, facts) };
    let found = follow(&request).and_then(|followed| {
        let mut concluded = conclude(followed, &request)?;
        tasks(&mut concluded, &request)?;
        Ok(concluded.audit)
    });
    found.map_err(|failure| match failure {
        Failure::Input(faults) => faults.into_iter().map(|fault| fault.code).collect(),
        other => panic!("{other:?}"),
    })
}

fn micros(time: Picos) -> u64 {
    time.0.div_ceil(1_000_000)
}

/// A fast program and a slow one, which share `g`.
fn project(fast: &str, slow: &str) -> String {
    format!(
        "FUNCTION three : INT VAR_INPUT n : INT; END_VAR VAR i, s : INT; END_VAR \
         FOR i := 1 TO 3 DO s := s + n; END_FOR three := s; END_FUNCTION \
         FUNCTION_BLOCK Walk INITIAL_STEP a: END_STEP STEP b: END_STEP \
         TRANSITION FROM a TO b := TRUE; END_TRANSITION TRANSITION FROM b TO a := TRUE; END_TRANSITION \
         END_FUNCTION_BLOCK \
         PROGRAM quick VAR x, y : BOOL; n : INT; END_VAR {fast} END_PROGRAM \
         PROGRAM main VAR x, y : BOOL; n : INT; END_VAR {slow} END_PROGRAM \
         CONFIGURATION c VAR_GLOBAL g : BOOL; walk : Walk; END_VAR RESOURCE r ON plc \
         TASK fast(INTERVAL := T#10ms, PRIORITY := 1); TASK slow(INTERVAL := T#100ms, PRIORITY := 5); \
         PROGRAM one WITH fast : quick; PROGRAM two WITH slow : main; \
         END_RESOURCE END_CONFIGURATION"
    )
}

/// The bounds of the slow and the fast task.
fn bounds(fast: &str, slow: &str) -> [Option<u64>; 2] {
    let found = audited(&project(fast, slow), None, &Facts::default()).expect("a project");
    let own = |name: &str| {
        let is = |one: &&TaskUse| one.name == name;
        found.tasks.iter().find(is).and_then(|one| one.upper).map(micros)
    };
    [own("slow"), own("fast")]
}

#[test]
fn each_task_is_bounded_by_itself() {
    let text = project("x := TRUE; y := TRUE;", "x := TRUE; y := TRUE; x := FALSE;");
    let found = audited(&text, None, &Facts::default()).expect("a project");
    let names: Vec<&str> = found.tasks.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["slow", "fast"]);
    assert_eq!(micros(found.bound.upper), 3, "the fast one's time is not in it");
    let [slow, fast] = [&found.tasks[0], &found.tasks[1]];
    assert_eq!((slow.upper.map(micros), fast.upper.map(micros)), (Some(3), Some(2)));
    assert_eq!(
        (slow.interrupted_by.as_slice(), fast.interrupted_by.len()),
        (&["fast".to_owned()][..], 0)
    );
    assert_eq!(slow.programs, ["two"]);
    assert_eq!(slow.response.clone().map(micros), Ok(5));
    assert_eq!(fast.response.clone().map(micros), Ok(2));
    // It is said that the fast one may interrupt the scan, not that the slow one does.
    let told = |audit: &Audit| audit.doubts.iter().map(ToString::to_string).collect::<String>();
    assert!(told(&found).contains("how often fast interrupts"), "{}", told(&found));
    let other = audited(&text, Some("FAST"), &Facts::default()).expect("a project");
    assert_eq!((micros(other.bound.upper), other.tasks[0].name.as_str()), (2, "fast"));
    assert_eq!(told(&other), "");
    assert_eq!(other.tasks[1].upper.map(micros), Some(3));
}

#[test]
fn how_often_one_interrupts_another_can_be_stated() {
    let text = project("x := TRUE; y := TRUE;", "x := TRUE; y := TRUE; x := FALSE;");
    let facts = Facts::parse("facts.toml", "[interrupts]\nfast = 4\n").expect("facts");
    let found = audited(&text, None, &facts).expect("a project");
    assert_eq!(micros(found.bound.upper), 3 + 4 * 2);
    assert!(found.doubts.is_empty(), "{:?}", found.doubts);
    // By itself it takes no longer for that.
    assert_eq!(found.tasks[0].upper.map(micros), Some(3));
}

#[test]
fn a_task_that_is_not_there_is_refused() {
    let text = project("x := TRUE;", "x := TRUE;");
    let found = audited(&text, Some("medium"), &Facts::default());
    assert_eq!(found.map(|_| ()), Err(vec![Code::UnknownName]));
    let alone = "PROGRAM main VAR x : BOOL; END_VAR x := TRUE; END_PROGRAM";
    let found = audited(alone, Some("main"), &Facts::default());
    assert_eq!(found.map(|_| ()), Err(vec![Code::UnknownName]));
}

#[test]
fn what_another_task_writes_may_change_at_any_moment() {
    let slow =
        "g := FALSE; IF g THEN x := TRUE; x := FALSE; END_IF IF NOT g THEN y := TRUE; END_IF";
    assert_eq!(bounds("x := g;", slow), [Some(2), Some(1)], "the fast one only reads it");
    assert_eq!(bounds("g := TRUE;", slow), [Some(4), Some(1)]);
    // So it is for the fast one: the slow one is in its midst or waits.
    let fast = "IF g THEN x := TRUE; END_IF IF NOT g THEN y := TRUE; END_IF";
    assert_eq!(bounds(fast, "x := g;")[1], Some(1));
    assert_eq!(bounds(fast, "g := FALSE;")[1], Some(2), "any value at any moment is taken");
}

#[test]
fn a_loop_whose_variable_another_task_writes_has_no_count() {
    let slow = |writes: &str, variable: &str| {
        let text = format!(
            "VAR_GLOBAL g, h : INT; one : Own; END_VAR
             FUNCTION_BLOCK Own VAR i : INT; x : BOOL; END_VAR FOR i := 1 TO 10 DO x := TRUE; END_FOR END_FUNCTION_BLOCK
             PROGRAM quick VAR x : BOOL; END_VAR {writes} END_PROGRAM
             PROGRAM main VAR x : BOOL; END_VAR {variable} END_PROGRAM
             CONFIGURATION c RESOURCE r ON plc
             TASK fast(INTERVAL := T#10ms, PRIORITY := 1); TASK slow(INTERVAL := T#100ms, PRIORITY := 5);
             PROGRAM p WITH fast : quick; PROGRAM q WITH slow : main; END_RESOURCE END_CONFIGURATION"
        );
        let found = audited(&text, None, &Facts::default()).expect("a project");
        let is = |one: &&TaskUse| one.name == "slow";
        found.tasks.iter().find(is).and_then(|one| one.upper).map(micros)
    };
    let counting = "FOR g := 1 TO 10 DO x := TRUE; END_FOR";
    assert_eq!(slow("g := 0;", counting), None);
    assert_eq!(slow("x := g > 0;", counting), Some(21), "it only reads");
    assert_eq!(slow("h := 0;", counting), Some(21), "it writes another");
    // An instance that both carry out, or one of its variables.
    assert_eq!(slow("one();", "one();"), None);
    assert_eq!(slow("one.i := 0;", "one();"), None);
    assert_eq!(slow("x := one.x;", "one();"), Some(21));
}

#[test]
fn tasks_have_functions_of_their_own() {
    // The loop takes three stores and four of its variable; the input, the result and what it is assigned to take one
    // each.
    let call = "n := three(n := 2); IF n <> 6 THEN x := TRUE; END_IF";
    assert_eq!(bounds("x := TRUE;", call)[0], Some(10));
    assert_eq!(bounds(call, call), [Some(10), Some(10)]);
}

#[test]
fn charts_that_two_tasks_carry_out_keep_nothing_apart() {
    let slow = "walk(); IF walk.a.X THEN x := TRUE; END_IF IF walk.b.X THEN y := TRUE; END_IF";
    assert_eq!(bounds("x := TRUE;", slow)[0], Some(1));
    assert_eq!(bounds("walk();", slow)[0], Some(2));
}

#[test]
fn programs_of_no_task_stand_behind_all_others() {
    let text = "PROGRAM a VAR x : BOOL; END_VAR x := TRUE; END_PROGRAM \
        PROGRAM b VAR x : BOOL; END_VAR x := TRUE; x := FALSE; END_PROGRAM \
        CONFIGURATION c RESOURCE r ON plc TASK t(INTERVAL := T#1ms, PRIORITY := 0); \
        PROGRAM one WITH t : a; PROGRAM two : b; END_RESOURCE END_CONFIGURATION";
    let found = audited(text, None, &Facts::default()).expect("a project");
    let own: Vec<(&str, Option<u64>)> =
        found.tasks.iter().map(|one| (one.name.as_str(), one.upper.map(micros))).collect();
    assert_eq!(own, [("background", Some(2)), ("t", Some(1))]);
    assert_eq!(found.tasks[0].response.clone().map(micros), Ok(3));
}

#[test]
fn what_changes_while_a_call_runs_is_not_handed_over_in_and_out() {
    let block = "FUNCTION_BLOCK Twice VAR_IN_OUT v : BOOL; END_VAR VAR x, y : BOOL; END_VAR \
        IF v THEN x := TRUE; END_IF; IF NOT v THEN y := TRUE; END_IF; END_FUNCTION_BLOCK ";
    let calls = |fast: &str, with: &str| {
        let slow = format!("twice(v := {with});");
        let text = project(fast, &slow).replace("main VAR", "main VAR twice : Twice;");
        audited(&format!("{block}{text}"), None, &Facts::default()).map(|_| ())
    };
    assert_eq!(calls("g := NOT g;", "g"), Err(vec![Code::NotModelled]));
    assert_eq!(calls("x := g;", "g"), Ok(()));
    assert_eq!(calls("g := NOT g;", "x"), Ok(()));
}

#[test]
fn tasks_are_told_apart_by_their_names() {
    let text = project("x := TRUE;", "y := TRUE;");
    assert!(audited(&text, None, &Facts::default()).is_ok());
    let loose =
        text.replace("TASK slow(", "TASK background(").replace("WITH slow", "WITH background");
    let loose = loose.replace("PROGRAM one WITH fast", "PROGRAM one");
    assert_eq!(audited(&loose, None, &Facts::default()).map(|_| ()), Err(vec![Code::NotModelled]));
}

#[test]
fn inputs_change_while_other_tasks_run() {
    let both = "IF %IX0.0 THEN x := TRUE; END_IF; IF NOT %IX0.0 THEN y := TRUE; END_IF;";
    assert_eq!(bounds("n := 1;", both)[0], Some(2));
}

#[test]
fn instances_of_one_name_are_refused_and_a_program_that_is_named_twice_is_called_twice() {
    // Every second call takes longer, of each instance by itself.
    let code = "x := NOT x; IF x THEN n := 1; n := 2; n := 3; END_IF";
    let of = |instances: &str| {
        let text = format!(
            "PROGRAM p VAR x : BOOL; n : INT; END_VAR {code} END_PROGRAM \
             CONFIGURATION c RESOURCE r ON plc TASK t(INTERVAL := T#10ms, PRIORITY := 1); \
             TASK u(INTERVAL := T#20ms, PRIORITY := 2); {instances} END_RESOURCE END_CONFIGURATION"
        );
        audited(&text, None, &Facts::default()).map(|found| micros(found.bound.upper))
    };
    assert_eq!(of("PROGRAM i WITH t : p; PROGRAM j WITH t : p;"), Ok(8));
    assert_eq!(of("PROGRAM p WITH t : p; PROGRAM p WITH t : p;"), Ok(5));
    for second in ["PROGRAM i WITH t : p;", "PROGRAM I WITH u : p;", "PROGRAM i : p;"] {
        let told = of(&format!("PROGRAM i WITH t : p; {second}"));
        assert_eq!(told, Err(vec![Code::DeclaredTwice]), "{second}");
    }
}

#[test]
fn tasks_of_two_resources_are_not_taken_for_one() {
    let text = |one: &str, other: &str| {
        format!(
            "PROGRAM p VAR_EXTERNAL g : BOOL; END_VAR IF g AND NOT g THEN g := g; END_IF; END_PROGRAM
             PROGRAM q VAR_EXTERNAL g : BOOL; END_VAR g := NOT g; END_PROGRAM
             CONFIGURATION c VAR_GLOBAL g : BOOL; END_VAR
             RESOURCE r1 ON plc {one} END_RESOURCE RESOURCE r2 ON plc {other} END_RESOURCE
             END_CONFIGURATION"
        )
    };
    let task = |name: &str, program: &str| {
        format!(
            "TASK {name}(INTERVAL := T#20ms, PRIORITY := 1); PROGRAM i{program} WITH {name} : {program};"
        )
    };
    let facts = Facts::default();
    let same = audited(&text(&task("t", "p"), &task("t", "q")), None, &facts);
    assert_eq!(same.err(), Some(vec![Code::NotModelled]));
    let loose = audited(&text("PROGRAM i1 : p;", "PROGRAM i2 : q;"), None, &facts);
    assert_eq!(loose.err(), Some(vec![Code::NotModelled]));
    // What a task of another processor writes may change at any moment.
    let apart = audited(&text(&task("t", "p"), &task("u", "q")), Some("t"), &facts);
    assert_eq!(apart.map(|found| micros(found.bound.upper)), Ok(1));
}

#[test]
fn a_verdict_names_the_task_if_there_are_several() {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("two-tasks.st");
    let text = project("x := TRUE;", "y := TRUE;");
    let told = |text: &str| {
        std::fs::write(&path, text).expect("a file");
        let mut check = std::process::Command::new(env!("CARGO_BIN_EXE_scanbound"));
        let run = check.args(["check", "--limit", "1s"]).arg(&path).output().expect("a run");
        String::from_utf8_lossy(&run.stdout).into_owned()
    };
    let interrupted = told(&text);
    assert!(interrupted.contains("for task slow is within"), "{interrupted}");
    let alone = told(&text.replace("PRIORITY := 1", "PRIORITY := 5"));
    assert!(alone.starts_with("PROVED: no scan of task slow takes longer than"), "{alone}");
}

//! Macro steps: charts with them are run as they are drawn, each macro step with its own chart, and held against the
//! charts in which they are replaced, against these written without them, and against the bound.

use crate::command::binary;
use common::charts;
use common::macros;
use common::tape::cases;

use charts::Dice;
use common::chart_run::control::Output;
use common::chart_run::evaluate::Value;
use common::chart_run::run::{Options, Run};
use macros::{Ask, Drawn, MS, Machine, Plan, drawn};
use scanbound::audit::{Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::iec::chart::Qualifier;
use scanbound::iec::chart::coactive::{BUDGET, Basis, Finding, Other, analyse};
use scanbound::iec::chart::plain::plain;
use scanbound::iec::{Body, Pou, Project, xml};
use scanbound::passes::values::Trust;
use scanbound::timing::table::{CLASSES, Table};
use std::collections::{BTreeMap, BTreeSet};

/// A project around a chart: inputs, and actions that store so often as says their weight.
fn project(sfc: &str, inputs: usize, actions: usize) -> String {
    let mut text = "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\"><types><pous>\
        <pou name=\"main\" pouType=\"program\"><interface><localVars>"
        .to_owned();
    for input in 0..inputs {
        let (byte, bit) = (input / 8, input % 8);
        text += &format!(
            "<variable name=\"i{input}\" address=\"%IX{byte}.{bit}\"><type><BOOL/></type></variable>"
        );
    }
    text += "<variable name=\"v\"><type><BOOL/></type></variable></localVars></interface><actions>";
    for action in 0..actions {
        let body = "v := TRUE; ".repeat(weight(action));
        text += &format!("<action name=\"m{action}\"><body><ST><p>{body}</p></ST></body></action>");
    }
    text + "</actions><body>"
        + sfc
        + "</body></pou></pous></types><instances><configurations>\
        <configuration name=\"c\"><resource name=\"r\"><task name=\"t\" interval=\"T#20ms\" priority=\"1\">\
        <pouInstance name=\"main\" typeName=\"main\"/></task></resource></configuration></configurations></instances></project>"
}

/// What an action takes, in stores.
fn weight(action: usize) -> usize {
    4 << action
}

fn read(source: &str) -> Project {
    xml::file("main.xml", source).unwrap_or_else(|faults| panic!("{faults:?}\n{source}"))
}

/// Each action by its name; one that the chart does not name is off.
fn by_number(run: &Run<'_>, outputs: &[Output], actions: usize) -> Vec<Output> {
    let known: BTreeMap<&str, Output> =
        run.actions().iter().map(String::as_str).zip(outputs.iter().copied()).collect();
    let name = |action| format!("m{action}");
    (0..actions).map(|action| known.get(&*name(action)).copied().unwrap_or_default()).collect()
}

/// A run of a chart in which macro steps are replaced, as long as the machine's.
struct Beside<'a> {
    run: Run<'a>,
    pou: &'a Pou,
}

impl<'a> Beside<'a> {
    fn new(pou: &'a Pou) -> Beside<'a> {
        let Body::Chart(chart) = &pou.body else { panic!("a chart") };
        Beside { run: Run::new(chart, pou, Options::default()), pou }
    }

    fn scan(&mut self, now: i64, values: &[bool], actions: usize) -> Vec<Output> {
        for (input, &value) in values.iter().enumerate() {
            self.run.memory.set(&format!("i{input}"), Value::Bool(value));
        }
        let outputs = self.run.scan(now).expect("a scan");
        by_number(&self.run, &outputs, actions)
    }

    fn is_active(&self, name: &str) -> bool {
        let Body::Chart(chart) = &self.pou.body else { panic!("a chart") };
        let own = chart.flagged(name).unwrap_or_else(|| panic!("no {name}"));
        own.into_iter().any(|step| self.run.active()[step])
    }
}

#[test]
fn charts_run_as_they_are_drawn() {
    let (mut seen, mut deep, mut clashing) = (0, 0, 0);
    for seed in 0..cases(400) {
        let mut dice = Dice::new(seed + 31_000_000);
        let actions = 3;
        let qualifiers = Qualifier::ALL.to_vec();
        let mut plan = Plan { actions, qualifiers, own_inputs: false, inputs: 3 };
        let depth = dice.below(3);
        let drawn = drawn(&mut dice, &mut plan, depth, 3);
        if !drawn.has_macros() {
            continue;
        }
        let source = project(&drawn.xml(&mut dice, &[]), 3, actions);
        let read = read(&source);
        let pou = &read.pous[0];
        let without = plain(pou).unwrap_or(None);
        let written = without.as_ref().map(|pou| {
            let one = Project { pous: vec![pou.clone()], ..read.clone() };
            let text = xml::write::project(&one).expect("XML");
            xml::file("again.xml", &text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}"))
        });
        seen += 1;
        let mut machine = Machine::new(&drawn, actions);
        let mut first = Beside::new(pou);
        let mut second = written.as_ref().map(|project| Beside::new(&project.pous[0]));
        let mut now = 0;
        let lazy = 1 + dice.below(3);
        for scan in 0..60 {
            let values: Vec<bool> = (0..3).map(|_| dice.one_in(lazy)).collect();
            let asked = machine.scan(now, &|input| values[input]);
            let told = first.scan(now, &values, actions);
            assert_eq!(told, asked, "scan {scan}\n{source}");
            for (name, is, time, is_macro) in machine.flags(now) {
                assert_eq!(first.is_active(&name), is, "{name} in scan {scan}\n{source}");
                let memory = &first.run.memory;
                assert_eq!(
                    memory.is(&format!("{name}.X")),
                    is,
                    "{name}.X in scan {scan}\n{source}"
                );
                let elapsed = memory.get(&format!("{name}.T"));
                assert_eq!(elapsed, Some(Value::Time(time)), "{name}.T in scan {scan}\n{source}");
                deep += u64::from(is_macro && name.contains('.') && is);
                clashing += u64::from(name.ends_with(".s0") && is);
            }
            if let Some(second) = &mut second {
                assert_eq!(second.scan(now, &values, actions), asked, "written, {scan}\n{source}");
            }
            now += i64::try_from(dice.below(5)).expect("small") * 5 * MS;
        }
    }
    assert!(seen > cases(150_u32) && deep > 500 && clashing > 500, "{seen} {deep} {clashing}");
}

/// A table in which stores, steps, transitions and their clearing take a microsecond each, and nothing else anything.
fn table() -> Table {
    let mut text = "instruction,on_us,off_us\n".to_owned();
    for class in CLASSES {
        text += &format!("@{class},0,0\n");
    }
    text += "ST,1,1\nSTEP,1,0\nTRANSITION,1,0\nCLEAR,1,0\n@end,0,\n";
    Table::parse("t.csv", text.as_bytes()).unwrap_or_else(|faults| panic!("{faults:?}")).table
}

fn bound(source: &str) -> Picos {
    let inputs = [Input { name: "main.xml".to_owned(), bytes: source.as_bytes().to_vec() }];
    // Of competing transitions the first clears, as the machine of these tests has it.
    let facts = Facts::parse("facts.toml", "[sfc]\nselection = 'first'\n").expect("facts");
    let table = table();
    let request =
        Request { table: Some(&table), trust: Trust::None, ..Request::new(&inputs, &facts) };
    audit(&request).unwrap_or_else(|failure| panic!("{failure:?}\n{source}")).bound.upper
}

fn cost(machine: &Machine<'_>, outputs: &[Output]) -> Picos {
    let active = machine.flags(0).iter().filter(|(_, is, ..)| *is).count() as u64;
    let runs = outputs.iter().enumerate().filter(|(_, output)| output.runs);
    let stores: u64 = runs.map(|(action, _)| weight(action) as u64).sum();
    Picos((active + machine.enabled + machine.cleared + stores) * 1_000_000)
}

/// The most that a scan takes, over all states that can be reached and all inputs; `None` if there are too many.
fn most(drawn: &Drawn, actions: usize, inputs: usize) -> Option<Picos> {
    let mut first = Machine::new(drawn, actions);
    let outputs = first.scan(0, &|_| false);
    let mut largest = cost(&first, &outputs);
    let mut known = BTreeSet::from([first.state()]);
    let mut open = vec![first];
    while let Some(machine) = open.pop() {
        for mask in 0..1_u32 << inputs {
            let mut next = machine.clone();
            let outputs = next.scan(0, &|input| mask >> input & 1 == 1);
            largest = largest.max(cost(&next, &outputs));
            if known.insert(next.state()) {
                if known.len() > 3_000 {
                    return None;
                }
                open.push(next);
            }
        }
    }
    Some(largest)
}

#[test]
fn small_charts_have_the_bound_that_the_machine_finds() {
    // Whether a pulse of P was on is not known of every state, and times are in none of these.
    let qualifiers = [Qualifier::N, Qualifier::R, Qualifier::S, Qualifier::P0, Qualifier::P1];
    let (mut equal, mut above) = (0, Vec::new());
    for seed in 0..cases(40) {
        let mut dice = Dice::new(seed + 32_000_000);
        let actions = 2;
        let qualifiers = qualifiers.to_vec();
        let mut plan = Plan { actions, qualifiers, own_inputs: true, inputs: 0 };
        let depth = dice.below(2);
        let drawn = drawn(&mut dice, &mut plan, depth, 2);
        if !drawn.has_macros() || plan.inputs > 10 {
            continue;
        }
        let Some(most) = most(&drawn, actions, plan.inputs) else { continue };
        let source = project(&drawn.xml(&mut dice, &[]), plan.inputs, actions);
        let upper = bound(&source);
        assert!(upper >= most, "{} below {}\n{source}", upper.us_text(), most.us_text());
        let project = read(&source);
        let Body::Chart(chart) = &project.pous[0].body else { panic!("a chart") };
        // Of many markings the bound knows only which steps exclude each other.
        let is_small =
            matches!(analyse(chart, BUDGET).basis, Basis::Markings(count) if count <= 64);
        if upper == most {
            equal += 1;
        } else if is_small && charts::is_done_alike(chart) {
            above.push(format!("{} above {}\n{source}", upper.us_text(), most.us_text()));
        }
    }
    assert!(equal > cases(6_u32) && above.is_empty(), "{equal} equal, above: {above:#?}");
}

#[test]
fn no_scan_of_a_long_run_takes_longer_than_the_bound() {
    let mut flags = 0;
    for seed in 0..cases(8) {
        let mut dice = Dice::new(seed + 33_000_000);
        let actions = 3;
        let qualifiers = Qualifier::ALL.to_vec();
        let mut plan = Plan { actions, qualifiers, own_inputs: false, inputs: 3 };
        let depth = dice.below(3);
        let drawn = drawn(&mut dice, &mut plan, depth, 2);
        let asks = drawn.ways.iter().flat_map(|way| &way.asks);
        flags += asks.filter(|(ask, _)| matches!(ask, Ask::Flag(..) | Ask::Young(..))).count();
        let source = project(&drawn.xml(&mut dice, &[]), 3, actions);
        let upper = bound(&source);
        let mut machine = Machine::new(&drawn, actions);
        let mut now = 0;
        let lazy = 1 + dice.below(3);
        for scan in 0..300 {
            let values: Vec<bool> = (0..3).map(|_| dice.one_in(lazy)).collect();
            let outputs = machine.scan(now, &|input| values[input]);
            let took = cost(&machine, &outputs);
            let told = || format!("{}, bound {}\n{source}", took.us_text(), upper.us_text());
            assert!(took <= upper, "scan {scan} takes {}", told());
            now += i64::try_from(dice.below(6)).expect("small") * 5 * MS;
        }
    }
    assert!(flags > 6, "{flags}");
}

/// A program whose chart has this body.
fn with_body(body: &str) -> String {
    project(&format!("<SFC>{body}</SFC>"), 4, 0)
}

fn at(kind: &str, id: u32, more: &str, from: &[u32], inner: &str) -> String {
    let from: String = from.iter().map(|id| format!("<connection refLocalId=\"{id}\"/>")).collect();
    let point = if from.is_empty() {
        from
    } else {
        format!("<connectionPointIn>{from}</connectionPointIn>")
    };
    format!("<{kind} localId=\"{id}\" {more}>{point}{inner}</{kind}>")
}

fn step(id: u32, name: &str, from: &[u32]) -> String {
    at("step", id, &format!("name=\"{name}\""), from, "")
}

fn clears(id: u32, from: u32, condition: &str) -> String {
    let condition =
        format!("<condition><inline name=\"\"><ST><p>{condition}</p></ST></inline></condition>");
    at("transition", id, "", &[from], &condition)
}

/// A chart of a start, a macro step `M` with this body, and the way back.
fn around(body: &str) -> String {
    let start = at("step", 1, "name=\"start\" initialStep=\"true\"", &[], "");
    let own = at("macroStep", 3, "name=\"M\"", &[2], &format!("<body><SFC>{body}</SFC></body>"));
    let jump = at("jumpStep", 5, "targetName=\"start\"", &[4], "");
    with_body(&[start, clears(2, 1, "i0"), own, clears(4, 3, "i1"), jump].concat())
}

#[test]
fn macro_steps_that_are_not_clear_are_refused_with_the_place() {
    let two = [step(1, "a", &[]), clears(2, 1, "i2"), step(3, "b", &[2])].concat();
    let mark = |name: &str, text: &str| {
        text.replace(&format!("name=\"{name}\""), &format!("name=\"{name}\" initialStep=\"true\""))
    };
    let nested = |name: &str, inner: &str| {
        at("macroStep", 1, &format!("name=\"{name}\""), &[], &format!("<body>{inner}</body>"))
    };
    let ring =
        [step(1, "a", &[4]), clears(2, 1, "i2"), step(3, "b", &[2]), clears(4, 3, "i2")].concat();
    let deep = (0..40).fold(format!("<SFC>{two}</SFC>"), |inner, level| {
        format!("<SFC>{}</SFC>", nested(&format!("N{level}"), &inner))
    });
    for (body, told) in [
        (String::new(), "main: the chart of the macro step M has no step"),
        (
            ring.clone(),
            "main: the macro step M has no entry step: a transition leads into each of its steps",
        ),
        (
            mark("a", &ring),
            "main: the macro step M has no exit step: a transition follows each of its steps",
        ),
        (
            [&two, &*step(4, "c", &[])].concat(),
            "main: the macro step M has several possible entry steps: no transition leads into a, c",
        ),
        (
            [&two, &*clears(5, 1, "i2"), &*step(6, "c", &[5])].concat(),
            "main: the macro step M has several possible exit steps: no transition follows b, c",
        ),
        (
            mark("b", &two),
            "main: the entry step of the macro step M is not clear: its step b is marked as an initial step, and no transition leads into a",
        ),
        (mark("a", &mark("b", &two)), "main: the macro step M has several initial steps: a, b"),
        (
            nested("m", &format!("<SFC>{two}</SFC>")),
            "main: macroStep m with localId 1: it stands in a macro step of its own name",
        ),
        (
            deep["<SFC>".len()..deep.len() - "</SFC>".len()].to_owned(),
            "main: macroStep N8 with localId 1: it stands in 32 macro steps",
        ),
        (nested("N", "<LD/>"), "main: macroStep N with localId 1: its body is not a chart"),
        (
            [&*two, &*clears(4, 1, "i2"), &*at("jumpStep", 5, "targetName=\"nowhere\"", &[4], "")]
                .concat(),
            "main: a transition with localId 4 names the step nowhere, which does not exist",
        ),
        (two.replace("name=\"b\"", "name=\"A\""), "main: there are two steps M.A: localId 1, 3"),
        (
            [&*step(1, "a", &[]), &*clears(2, 9, "i2"), &*step(3, "b", &[2])].concat(),
            "main: transition with localId 2: a connection refers to localId 9, which does not exist",
        ),
    ] {
        let source = around(&body);
        let faults = xml::file("a.xml", &source).expect_err(&source);
        let messages: Vec<&str> = faults.iter().map(|fault| fault.message.as_str()).collect();
        assert_eq!(messages, [told], "{source}");
        assert!(faults[0].line > 0);
    }
}

#[test]
fn the_step_that_is_entered_may_be_marked_or_not() {
    let two = [step(1, "a", &[]), clears(2, 1, "i2"), step(3, "b", &[2])].concat();
    let shown = |source: &str| {
        let project = read(source);
        let Body::Chart(chart) = &project.pous[0].body else { panic!("a chart") };
        let ways: Vec<String> =
            (0..chart.transitions.len()).map(|at| chart.transition_name(at)).collect();
        (chart.initial(), ways, chart.macros.clone())
    };
    let plain = shown(&around(&two));
    assert_eq!(plain.0, [0]);
    assert_eq!(plain.1, ["M.a -> M.b", "start -> M.a", "M.b -> start"]);
    let marked = two.replace("name=\"a\"", "name=\"a\" initialStep=\"true\"");
    assert_eq!(shown(&around(&marked)), plain);
    // Where nothing else of the chart is active at first, the mark in the macro step says that it is.
    let alone = around(&marked).replace("name=\"start\" initialStep=\"true\"", "name=\"start\"");
    assert_eq!(shown(&alone).0, [1]);
    let unmarked = around(&two).replace("name=\"start\" initialStep=\"true\"", "name=\"start\"");
    let faults = xml::file("a.xml", &unmarked).expect_err("no initial step");
    assert!(
        faults[0].message.starts_with("main: the chart has no initial step: its first step is")
    );
    // The macro step itself may be marked.
    let own = unmarked.replace("name=\"M\"", "name=\"M\" initialStep=\"true\"");
    assert_eq!(shown(&own).0, [1]);
}

#[test]
fn macro_steps_in_each_other_are_each_looked_at_once() {
    // In a macro step that is entered and left by the one in it, both ends would double what there is to look at.
    let inside = |name: &str, level: usize, id: u32, from: &[u32], body: &str| {
        let body = format!("<body><SFC>{body}</SFC></body>");
        at("macroStep", id, &format!("name=\"{name}{level}\""), from, &body)
    };
    let own = step(1, "s", &[]);
    let (mut body, mut first, mut last) = (own.clone(), "s".to_owned(), "s".to_owned());
    for level in 0..31 {
        body = inside("N", level, 1, &[], &body);
        (first, last) = (format!("N{level}.{first}"), format!("N{level}.{last}"));
        if level % 8 == 3 {
            body += &clears(2, 1, "i2");
            body += &inside("X", level, 3, &[2], &own);
            body += &clears(4, 3, "i3");
            body += &inside("Y", level, 5, &[4], &own);
            last = format!("Y{level}.s");
        }
    }
    let project = read(&around(&body));
    let Body::Chart(chart) = &project.pous[0].body else { panic!("a chart") };
    assert_eq!(chart.macros.len(), 32 + 2 * 4);
    let ways: Vec<String> =
        (0..chart.transitions.len()).map(|at| chart.transition_name(at)).collect();
    for way in [format!("start -> M.{first}"), format!("M.{last} -> start")] {
        assert!(ways.contains(&way), "{way} of {ways:?}");
    }
}

#[test]
fn what_is_wrong_in_a_macro_step_is_told_by_its_steps_full_names() {
    // A parallel in a macro step whose branches meet as a selection does.
    let body = [
        step(1, "a", &[]),
        clears(2, 1, "i2"),
        at("simultaneousDivergence", 3, "", &[2], ""),
        step(4, "b", &[3]),
        step(5, "c", &[3]),
        clears(6, 4, "i2"),
        clears(7, 5, "i3"),
        step(8, "d", &[6, 7]),
    ];
    let project = read(&around(&body.concat()));
    let Body::Chart(chart) = &project.pous[0].body else { panic!("a chart") };
    let found = analyse(chart, BUDGET);
    let twice = found.findings.iter().find_map(|one| match one {
        Finding::EnteredTwice(step, _) => Some(chart.steps[*step].name.as_str()),
        _ => None,
    });
    assert!(twice.is_some_and(|name| name.starts_with("M.")), "{:?}", found.findings);
    // One whose branches wait for each other wrongly: the exit is never reached.
    let body = [
        step(1, "a", &[]),
        clears(2, 1, "i2"),
        clears(3, 1, "i3"),
        step(4, "b", &[2]),
        step(5, "c", &[3]),
        at("simultaneousConvergence", 6, "", &[4, 5], ""),
        clears(7, 6, "TRUE"),
        step(8, "d", &[7]),
    ];
    let project = read(&around(&body.concat()));
    let Body::Chart(chart) = &project.pous[0].body else { panic!("a chart") };
    let found = analyse(chart, BUDGET);
    let exit = chart.step("M.d").expect("a step");
    assert!(found.findings.contains(&Finding::NeverActive(exit)), "{:?}", found.findings);
    assert!(found.findings.iter().any(|one| matches!(one, Finding::Deadlock(..))));
    assert_eq!(found.pairs.iter().filter(|pair| matches!(pair.other, Other::Step(_))).count(), 0);
}

/// What `scanbound sfc` writes of a file, to each side, and its exit code.
fn sfc(text: &str, name: &str, arguments: &[&str]) -> (String, String, Option<i32>) {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join(name), text).expect("written");
    let output = binary()
        .args(["sfc", name])
        .args(arguments)
        .current_dir(directory.path())
        .output()
        .expect("the program starts");
    let [out, told] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    (out, told, output.status.code())
}

#[test]
fn the_washer_is_shown_drawn_and_written_without_its_macro_steps() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/sfc/macros.xml");
    let text = std::fs::read_to_string(file).expect("the sample");
    let (out, told, code) = sfc(&text, "washer.xml", &[]);
    assert_eq!((told.as_str(), code), ("", Some(0)));
    for line in [
        "  9 steps, 8 transitions; 1 loop, 0 selections, 1 parallel; 8 markings",
        "    Wash.Heat: Wash.Heat.Low, Wash.Heat.High, Wash.Heat.Out",
        "          Wash.Heat.High  [N lamp, L heater T#90s]",
        "    heater",
        "      in parallel (way 2): step Wash.Turn; action motor",
    ] {
        assert!(out.lines().any(|own| own == line), "{line} in\n{out}");
    }
    let (out, _, _) = sfc(&text, "washer.xml", &["--format", "dot"]);
    let count = |what: &str| out.matches(what).count();
    assert_eq!((count("subgraph"), count("label=\"Wash.Heat\"")), (3, 1));
    assert_eq!(count("{"), count("}"));
    let (out, _, _) = sfc(&text, "washer.xml", &["--format", "svg"]);
    assert_eq!(out.matches("class=\"macro\"").count(), 2, "a frame each\n{out}");
    let (out, _, _) = sfc(&text, "washer.xml", &["--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let own = &json["charts"][0]["macros"][1];
    assert_eq!(own["name"], "Wash.Heat");
    assert_eq!(own["steps"][2], "Wash.Heat.Out");
    let (out, told, code) = sfc(&text, "washer.xml", &["--explicit", "-o", "-"]);
    assert_eq!(
        (told.as_str(), code),
        ("washer: lock, stored by S, is now the branch lock_on\n", Some(0))
    );
    assert!(out.contains("name=\"Wash_Heat_Low\"") && !out.contains("macroStep"));
    let flags = ["Fill", "Heat_Low", "Heat_High", "Heat_Out", "Turn", "Drain"];
    let any = flags.map(|step| format!("Wash_{step}.X")).join(" OR ");
    assert!(out.contains(&format!("start AND NOT ({any})")), "{out}");
    let (_, told, code) = sfc(&out, "again.xml", &[]);
    assert_eq!((told.as_str(), code), ("", Some(0)));
}

#[test]
fn nothing_is_said_to_be_rewritten_that_is_not_written() {
    let text = "FUNCTION_BLOCK f METHOD m : BOOL END_METHOD
        INITIAL_STEP s0: END_STEP STEP s1: a(S); END_STEP STEP s2: a(R); END_STEP
        TRANSITION FROM s0 TO s1 := TRUE; END_TRANSITION
        TRANSITION FROM s1 TO s2 := TRUE; END_TRANSITION
        TRANSITION FROM s2 TO s0 := TRUE; END_TRANSITION END_FUNCTION_BLOCK";
    let (out, told, code) = sfc(text, "a.st", &["--explicit", "-o", "-"]);
    assert!(out.is_empty() && code == Some(2), "{code:?} {out}");
    assert!(told.contains("f: PLCopen XML cannot express methods such as m"), "{told}");
    assert!(!told.contains("is now the branch"), "{told}");
}

#[test]
fn what_has_no_form_without_macro_steps_is_refused() {
    let two = [step(1, "a", &[]), clears(2, 1, "i2"), step(3, "b", &[2])].concat();
    let text = around(&two).replace("<p>i1</p>", "<p>M.T &gt; T#1s</p>");
    let (_, told, code) = sfc(&text, "a.xml", &["--explicit", "-o", "-"]);
    assert!(told.contains("main: M.T cannot be written without the macro step"), "{told}");
    assert_eq!(code, Some(2));
    let asks = "<actions><action name=\"look\"><body><ST><p>v := M.a.X;</p></ST></body></action></actions>";
    let text = around(&two).replace("<actions></actions>", asks);
    let (_, told, code) = sfc(&text, "a.xml", &["--explicit", "-o", "-"]);
    assert!(told.contains("main: action look reads steps"), "{told}");
    assert_eq!(code, Some(2));
}

#[test]
fn a_step_of_a_macro_step_is_known_by_its_own_name_where_only_one_has_it() {
    let two = [step(1, "a", &[]), clears(2, 1, "i2"), step(3, "b", &[2])].concat();
    let ask = |what: &str| {
        let asks = format!(
            "<actions><action name=\"look\"><body><ST><p>v := {what};</p></ST></body></action></actions>"
        );
        let block = at(
            "actionBlock",
            9,
            "",
            &[1],
            "<action qualifier=\"N\"><reference name=\"look\"/></action>",
        );
        let text = around(&two).replace("<actions></actions>", &asks);
        text.replacen("<transition", &format!("{block}<transition"), 1)
    };
    let audited = |source: &str| {
        let inputs = [Input { name: "main.xml".to_owned(), bytes: source.as_bytes().to_vec() }];
        let (facts, table) = (Facts::default(), table());
        audit(&Request { table: Some(&table), ..Request::new(&inputs, &facts) }).is_ok()
    };
    for (what, known) in
        [("M.a.X", true), ("a.X", true), ("M.X", true), ("c.X", false), ("M.c.X", false)]
    {
        assert_eq!(audited(&ask(what)), known, "{what}");
    }
    // A variable of this name is the variable; a step of the chart around is that step.
    let both = ask("a.X")
        .replace("name=\"start\"", "name=\"a\"")
        .replace("targetName=\"start\"", "targetName=\"a\"");
    let project = read(&both);
    let Body::Code(_, statements) = &project.pous[0].actions[0].body else { panic!("an action") };
    assert_eq!(scanbound::iec::show::statements(statements, 0), "v := a.X;\n");
}

//! Flowchart programs: the bound against an interpreter of their own, over everything that can be open in a pass
//! and over many passes; the documents' cases with bound and way.

use common::flowcharts::{Every, Weather, generate};
use common::tape::{Tape, cases, on_tapes};
use scanbound::audit::verdict::{Check, Margin, Verdict};
use scanbound::audit::{Audit, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::front::flowchart::decode::{decode, mnemonic};
use scanbound::front::flowchart::interpret::{Ended, Machine, PassResult, State};
use scanbound::front::flowchart::{Op, Source, read_text};
use scanbound::timing::table::{Row, Table};
use std::collections::BTreeSet;

fn audited(name: &str, text: &str, table: &Table, latched: bool) -> Result<Audit, String> {
    let facts = Facts { latched: latched.then_some(true), ..Facts::default() };
    let inputs = [Input { name: name.to_owned(), bytes: text.as_bytes().to_vec() }];
    let request =
        Request { dialect: Some("flowchart"), table: Some(table), ..Request::new(&inputs, &facts) };
    audit(&request).map_err(|failure| format!("{failure:?}"))
}

/// The rows with the times of each instruction.
fn rows<'a>(source: &Source, table: &'a Table) -> Vec<&'a Row> {
    source.instructions.iter().map(|one| table.row(mnemonic(one.op)).expect("a time")).collect()
}

fn cost(rows: &[&Row], pass: &PassResult) -> Picos {
    let one = |&(at, held): &(usize, bool)| if held { rows[at].on } else { rows[at].off };
    pass.ran.iter().map(one).sum()
}

fn check(tape: &[u16], latched: bool) -> Result<(), String> {
    let (text, table) = generate(&mut Tape::new(tape));
    let told = |what: String| format!("{what}\n{text}\n{table}");
    let table = Table::parse("times", table.as_bytes()).map_err(|f| told(format!("{f:?}")))?.table;
    let source = read_text("random", &text).map_err(|faults| told(format!("{faults:?}")))?;
    let audit = audited("random", &text, &table, latched).map_err(told)?;
    let rows = rows(&source, &table);
    let upper = audit.bound.upper;
    // What GS does to a group that runs nobody tells: no lower bound rests on it.
    let settled = !source.instructions.iter().any(|one| matches!(one.op, Op::Start(_)));
    if settled && !audit.bound.exact() {
        return Err(told(format!("not exact: {:?}", audit.bound)));
    }
    let (mut most, mut endless, mut complete) = (Picos::ZERO, false, true);
    let mut passes = 0;
    let mut known: BTreeSet<State> = BTreeSet::new();
    let mut open = vec![Machine::switched_on(&source, latched)];
    // Every state that is ever reached, and from each every pass.
    'all: while let Some(machine) = open.pop() {
        let mut every = Every::default();
        loop {
            passes += 1;
            let mut machine = machine.clone();
            let pass = machine.pass(&mut every);
            if pass.ended == Ended::Never || passes == 3_000 {
                endless = pass.ended == Ended::Never;
                complete = false;
                break 'all;
            }
            let cost = cost(&rows, &pass);
            if cost > upper && audit.unbounded.is_empty() {
                return Err(told(format!("the bound is {upper}, a pass takes {cost}: {pass:?}")));
            }
            most = most.max(cost);
            if known.insert(machine.state().clone()) {
                open.push(machine);
            }
            if !every.advance() {
                break;
            }
        }
    }
    if endless && audit.unbounded.is_empty() {
        return Err(told("a pass never ends, and the audit does not say so".to_owned()));
    }
    if complete && !audit.unbounded.is_empty() {
        return Err(told(format!("every pass ends, the audit says {:?}", audit.unbounded)));
    }
    if complete && most != upper {
        return Err(told(format!("the bound is {upper}, the longest pass takes {most}")));
    }
    if complete && audit.bound.lower > most {
        return Err(told(format!("{} at least, the longest pass takes {most}", audit.bound.lower)));
    }
    // Many passes from switching on.
    let mut machine = Machine::switched_on(&source, latched);
    let mut weather = Weather(tape.iter().map(|&word| u64::from(word)).sum());
    for _ in 0..200 {
        let pass = machine.pass(&mut weather);
        if pass.ended == Ended::Never {
            if audit.unbounded.is_empty() {
                return Err(told("a pass never ends, and the audit does not say so".to_owned()));
            }
            break;
        }
        let cost = cost(&rows, &pass);
        if cost > upper && audit.unbounded.is_empty() {
            return Err(told(format!("the bound is {upper}, a later pass takes {cost}: {pass:?}")));
        }
    }
    Ok(())
}

#[test]
fn the_bound_of_random_programs_is_the_longest_pass() {
    on_tapes(cases(30), 120, |tape| check(tape, false));
    on_tapes(cases(30), 120, |tape| check(tape, true));
}

/// The documents' cases.
const CASES: [&str; 14] = [
    "self-holding-stop",
    "self-holding-stop-inner-loop",
    "self-holding-start",
    "flip-flop",
    "flip-flop-wait",
    "interval",
    "interval-group",
    "delay",
    "delay-group",
    "repeat",
    "repeat-group",
    "traffic-signals",
    "star-delta",
    "star-delta-group",
];

fn case(name: &str, latched: bool) -> (Source, Table, Audit) {
    let path = format!("{}/samples/flowchart/{name}.lst", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect(name);
    let table = Table::builtin("flowchart-pc").expect("built in");
    let source = read_text(name, &text).expect(name);
    let audit = audited(name, &text, &table, latched).expect(name);
    (source, table, audit)
}

#[test]
fn every_case_is_among_the_samples() {
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/flowchart");
    let files = std::fs::read_dir(directory).expect("samples");
    let mut found: Vec<String> = files
        .map(|entry| entry.expect("a file").file_name().to_string_lossy().replace(".lst", ""))
        .collect();
    found.sort();
    let mut cases = CASES.to_vec();
    cases.sort_unstable();
    assert_eq!(found, cases);
}

#[test]
fn the_cases_with_bound_and_way() {
    let mut told = String::new();
    for name in CASES {
        let (_, _, audit) = case(name, false);
        assert!(audit.unbounded.is_empty() && audit.doubts.is_empty());
        // A pass that starts a group again that runs, or goes on with the rest of a timer behind CNR TIM, is no lower
        // bound.
        let settled = audit.bound.exact();
        let least =
            if settled { String::new() } else { format!(", {} at least", audit.bound.lower) };
        told += &format!("{name}: {}{least}\n", audit.bound.upper);
        let mut via: &[String] = &[];
        for step in &audit.path {
            if step.via != via {
                via = &step.via;
                told += &format!("  -- {}\n", via.last().map_or("main", String::as_str));
            }
            // Whether GS starts a running group again costs nothing, so either may be shown.
            let either = step.held || step.instruction.starts_with("GS");
            let no = if either { "" } else { ", no" };
            let (line, time) = (step.at.line, step.cost.us_text());
            told += &format!("  {line:>2} {} ({time} us{no})\n", step.instruction);
        }
        let sum: Picos = audit.path.iter().map(|step| step.cost).sum();
        assert_eq!(sum, audit.bound.lower, "{name}");
    }
    insta::assert_snapshot!(told);
}

#[test]
fn the_cases_that_are_not_exact_rest_on_the_rest_of_a_timer() {
    // Their longest pass goes on with the rest of a timer behind CNR TIM. Which of both a PLC does no lower bound rests
    // on.
    let open = ["interval", "delay-group", "repeat", "star-delta"];
    // Of these no run from power-up is found: timers of two seconds and more follow each other in them, and a group
    // that GS starts again may go on as it is.
    let not_reached = ["interval-group", "repeat-group", "traffic-signals", "star-delta-group"];
    for name in CASES {
        let (_, _, audit) = case(name, false);
        assert_eq!(audit.bound.exact(), !open.contains(&name), "{name}: {:?}", audit.bound);
        assert_eq!(audit.is_reached(), !not_reached.contains(&name), "{name}");
        let says =
            |what: &str| audit.approximations.iter().any(|one| one.what.to_string().contains(what));
        assert!(!open.contains(&name) || says("CNR TIM may reset the timer"), "{name}");
        assert!(
            !not_reached.contains(&name) || says("GS may or may not restart a group"),
            "{name}"
        );
    }
}

#[test]
fn no_pass_of_the_cases_is_longer_than_the_bound_and_some_pass_attains_it() {
    for (name, latched) in CASES.into_iter().flat_map(|name| [(name, false), (name, true)]) {
        let (source, table, audit) = case(name, latched);
        let stated: Vec<String> = audit.facts.iter().map(ToString::to_string).collect();
        let told = latched.then_some("the inputs are copied to an image once per pass");
        assert_eq!(stated, told.into_iter().collect::<Vec<_>>());
        let rows = rows(&source, &table);
        let mut most = Picos::ZERO;
        let mut machine = Machine::switched_on(&source, latched);
        let mut weather = Weather(7);
        for number in 0..30_000 {
            // What is done for good, such as an output that nothing turns off again, is undone so.
            if number % 100 == 0 {
                machine = Machine::switched_on(&source, latched);
            }
            let pass = machine.pass(&mut weather);
            assert_eq!(pass.ended, Ended::Pass, "{name}");
            most = most.max(cost(&rows, &pass));
        }
        assert_eq!(most, audit.bound.upper, "{name}");
    }
}

#[test]
fn an_image_of_the_inputs_is_stated_or_each_test_reads_its_input() {
    let bound = |name: &str, latched| case(name, latched).2.bound.upper.us_text();
    let changed = CASES.into_iter().filter(|name| bound(name, false) != bound(name, true));
    let told: Vec<_> = changed.map(|name| (name, bound(name, false), bound(name, true))).collect();
    insta::assert_debug_snapshot!(told);
}

#[test]
fn a_group_that_need_not_wait_has_no_bound() {
    let main = "LBL0: AND 1\nCJP LBL1\nGJ\nJMP LBL0\nLBL1: GS 0\nGJ\nJMP LBL0\n";
    let table = Table::builtin("flowchart-pc").expect("built in");
    let judged = |group: &str, latched| {
        let text = format!("{main}{group}");
        let audit = audited("a", &text, &table, latched).expect("an audit");
        let verdict = Check::new(&audit, Picos(u64::MAX), Margin::default()).verdict;
        let loops: Vec<_> =
            audit.unbounded.iter().map(|one| (one.from.line, one.to.line)).collect();
        assert_eq!(loops.is_empty(), audit.doubts.is_empty());
        (loops, verdict)
    };
    let check = |group: &str| judged(group, false);
    let refuted = |line| (vec![(9, line)], Verdict::Refuted);
    assert_eq!(check("GN 0\nLBL5: OUT 200\nJMP LBL5\n"), refuted(10));
    assert_eq!(check("GN 0\nLBL5: AND 5\nWAIT\nOUT 200\nJMP LBL5\n"), refuted(12));
    assert_eq!(check("GN 0\nLBL5: TIM 10 #30\nCJP LBL6\nJMP LBL5\nLBL6: GE 0\n"), refuted(11));
    let proved = (Vec::new(), Verdict::Proved);
    assert_eq!(check("GN 0\nLBL5: TIM 10 #30\nWAIT\nOUT 200\nJMP LBL5\n"), proved);
    // An input may change between its two tests, and again, unless it has an image.
    let both = "GN 0\nLBL5: AND 5\nWAIT\nAND NOT 5\nWAIT\nJMP LBL5\n";
    assert_eq!((check(both), judged(both, true)), (refuted(13), proved.clone()));
    // Once round, then 200 is on and ends it.
    assert_eq!(check("GN 0\nLBL5: AND 200\nCJP LBL6\nOUT 200\nJMP LBL5\nLBL6: GE 0\n"), proved);
}

#[test]
fn a_timer_started_without_time_has_run_out_wherever_it_is_asked_for_next() {
    let rest = "CJP LBL1\nTIM 1 #5\nCJP LBL2\nLBL1: JMP LBL0\nLBL2: OUT 1\nOUT 2\nJMP LBL0\n";
    let table = Table::parse("t.csv", b"instruction,on_us,off_us\n@base,flowchart-pc\nOUT,1000");
    let table = table.expect("a table").table;
    let bound = |time: &str| {
        let text = format!("LBL0: CNR TIM 1\nTIM 1 #{time}\n{rest}");
        audited("a", &text, &table, false).expect("an audit").bound.upper
    };
    assert!(bound("0") > Picos(2_000_000_000));
    // CNR TIM may have left it the rest of its time.
    assert!(bound("5") > Picos(2_000_000_000));
}

#[test]
fn a_program_of_too_many_states_is_bounded_all_the_same() {
    let mut text = "LBL0: AND 1\nCJP LBL1\nGJ\nJMP LBL0\nLBL1:\n".to_owned();
    let groups = 8;
    (0..groups).for_each(|group| {
        text +=
            &format!("AND {}\nCJP LBL{}\nGS {group}\nLBL{}:\n", group + 2, group + 50, group + 50)
    });
    text += "GJ\nJMP LBL0\n";
    for group in 0..groups {
        text += &format!("GN {group}\nLBL{}:\n", group + 10);
        (0..4).for_each(|wait| {
            text += &format!("OUT {}\nTIM {} #10\nWAIT\n", 200 + group, group * 10 + wait)
        });
        text += &format!("JMP LBL{}\n", group + 10);
    }
    let table = Table::builtin("flowchart-pc").expect("built in");
    let source = read_text("a", &text).expect("a program");
    let audit = audited("a", &text, &table, false).expect("an audit");
    assert!(audit.unbounded.is_empty());
    let rows = rows(&source, &table);
    let mut machine = Machine::switched_on(&source, false);
    let mut weather = Weather(3);
    for _ in 0..3_000 {
        let pass = machine.pass(&mut weather);
        assert!(cost(&rows, &pass) <= audit.bound.upper);
    }
}

#[test]
fn a_flowchart_of_many_labels_stays_small() {
    let labels = 2_400;
    let text = |one: &dyn Fn(usize) -> String| (0..labels).map(one).collect::<String>();
    let main = "LBL9000: AND 1\nCJP LBL9001\nGJ\nJMP LBL9000\nLBL9001: GS 0\nGJ\nJMP LBL9000\n";
    let waits = |i| format!("LBL{i}: OUT {}\nTIM {i} #3\nWAIT\n", i + 5000);
    let polls = |i| format!("LBL{i}: AND {i}\nCJP LBL{i}\n");
    let backs =
        |i| format!("LBL{i}: AND {}\nCJP LBL{}\nOUT {}\n", i + 5000, i / 2, i * 17 % 2400 + 5000);
    for text in [
        text(&polls) + "JMP LBL0\n",
        format!("{main}GN 0\n{}JMP LBL0\n", text(&waits)),
        format!("{main}GN 0\n{}GE 0\n", text(&backs)),
    ] {
        let source = read_text("a", &text).expect("a program");
        let program = decode(&source, false);
        let effects: usize = program.instructions.iter().map(|one| one.effects.len()).sum();
        assert!(
            program.instructions.len() + effects < 300_000,
            "{} {effects}",
            program.instructions.len()
        );
    }
}

//! The interpreter of charts that other tests compare with, tested by itself.

use common::chart_run::control::{Control, Input, Output};
use common::chart_run::evaluate::{Memory, Value};
use common::chart_run::run::{Options, Run};
use scanbound::iec::chart::Qualifier as K;
use scanbound::iec::parse::{expression, file, statements};
use scanbound::iec::{Body, Pou};

const MS: i64 = 1_000_000;

/// The action's state in scans 10 ms apart; a row a block, `#` where its step is active.
fn told(blocks: &[(K, i64, &str)]) -> String {
    let mut control = Control::default();
    let scans = blocks[0].2.len();
    (0..scans)
        .map(|scan| {
            let input = |&(qualifier, time, row): &(K, i64, &str)| Input {
                qualifier,
                time: time * MS,
                active: row.as_bytes()[scan] == b'#',
            };
            let inputs: Vec<Input> = blocks.iter().map(input).collect();
            let out = control.scan(&inputs, scan as i64 * 10 * MS, false);
            if out.q { '#' } else { '.' }
        })
        .collect()
}

#[test]
fn every_qualifier_does_what_the_standard_says() {
    for (blocks, is) in [
        (&[(K::N, 0, ".###..")][..], ".###.."),
        (&[(K::S, 0, ".#...."), (K::R, 0, "....#.")], ".###.."),
        (&[(K::L, 20, ".####.")], ".##..."),
        (&[(K::L, 20, "##..####")], "##..##.."),
        (&[(K::D, 20, ".####.")], "...##."),
        (&[(K::D, 20, ".##...")], "......"),
        (&[(K::P, 0, ".##.#.")], ".#..#."),
        (&[(K::P1, 0, ".##.#.")], ".#..#."),
        (&[(K::P0, 0, ".##.#.")], "...#.#"),
        (&[(K::Sd, 20, ".#......"), (K::R, 0, "......#.")], "...###.."),
        (&[(K::Ds, 20, ".###...."), (K::R, 0, "......#.")], "...###.."),
        (&[(K::Ds, 20, ".##....."), (K::R, 0, "......#.")], "........"),
        (&[(K::Sl, 20, ".#......"), (K::R, 0, "......#.")], ".##....."),
        (&[(K::Sl, 50, ".#......"), (K::R, 0, "...#....")], ".##....."),
    ] {
        assert_eq!(told(blocks), is, "{blocks:?}");
    }
}

#[test]
fn corners_are_as_docs_sfc_says() {
    for (blocks, is) in [
        // SL again after its time, without R between: nothing.
        (&[(K::Sl, 20, ".#...#..")][..], ".##....."),
        // R while SD is pending: it never comes.
        (&[(K::Sd, 30, ".#......"), (K::R, 0, "...#....")], "........"),
        // S and R in one scan: R wins; S again when R has ended, since its step is still active.
        (&[(K::S, 0, ".###...."), (K::R, 0, ".##.....")], "...#####"),
        // Several steps with S on one action, reset once.
        (&[(K::S, 0, ".#......"), (K::S, 0, "...#...."), (K::R, 0, ".....#..")], ".####..."),
        // R also holds off what is not stored.
        (&[(K::N, 0, ".######."), (K::R, 0, "...##...")], ".##..##."),
    ] {
        assert_eq!(told(blocks), is, "{blocks:?}");
    }
}

#[test]
fn the_final_scan_runs_the_body_once_more() {
    let mut control = Control::default();
    let mut runs = |active, final_scan| {
        let input = [Input { qualifier: K::N, time: 0, active }];
        control.scan(&input, 0, final_scan)
    };
    assert!(runs(true, true).runs);
    assert_eq!(runs(false, true), Output { q: false, runs: true });
    assert_eq!(runs(false, true), Output::default());
    assert!(runs(true, false).runs && !runs(false, false).runs);
}

#[test]
fn bodies_do_what_they_say() {
    let mut memory = Memory::default();
    memory.set("On", Value::Bool(true));
    let text = "FOR i := 1 TO 4 DO s := s + i; END_FOR\nIF on AND s = 10 THEN a[s] := T#2s; ELSE a[0] := T#1s; END_IF";
    memory.run(&statements(text, 1).expect("statements")).expect("carried out");
    assert_eq!(
        (memory.get("S"), memory.get("a[10]")),
        (Some(Value::Int(10)), Some(Value::Time(2_000_000_000)))
    );
    let later = expression("a[10] >= T#1s AND NOT (s > 10)", 1).expect("an expression");
    assert_eq!(memory.truth(&later), Ok(true));
    let endless = statements("FOR i := 1 TO 4 DO i := 1; END_FOR", 1).expect("statements");
    assert!(memory.run(&endless).is_err());
}

fn unit(text: &str) -> Pou {
    file("a.st", text).expect("a unit").pous.remove(0)
}

#[test]
fn the_first_of_those_that_compete_clears_and_a_step_that_is_left_and_entered_stays() {
    let pou = unit(
        "PROGRAM p VAR go, x, y : BOOL; END_VAR
         INITIAL_STEP a: x(N); END_STEP STEP b: y(P); END_STEP STEP c: END_STEP
         TRANSITION FROM a TO b := go; END_TRANSITION
         TRANSITION FROM a TO c := go; END_TRANSITION
         TRANSITION FROM b TO b := b.T >= T#30ms AND go; END_TRANSITION
         END_PROGRAM",
    );
    let Body::Chart(chart) = &pou.body else { panic!("a chart") };
    let mut run = Run::new(chart, &pou, Options::default());
    run.memory.set("go", Value::Bool(true));
    let mut told = Vec::new();
    for scan in 0..6 {
        run.scan(scan * 10_000_000).expect("a scan");
        told.push((run.active().to_vec(), run.memory.is("x"), run.memory.is("y")));
    }
    let b = [false, true, false];
    assert_eq!(told[0], ([true, false, false].to_vec(), true, false));
    assert_eq!(told[1], (b.to_vec(), false, true), "P once");
    assert!(
        told[2..].iter().all(|one| *one == (b.to_vec(), false, false)),
        "no edge of a step that stays"
    );
    assert_eq!(run.memory.get("b.t"), Some(Value::Time(40_000_000)));
}

#[test]
fn parallels_wait_for_each_other() {
    let pou = unit(
        "PROGRAM p VAR n : INT; one, two : BOOL; END_VAR
         INITIAL_STEP s: END_STEP STEP a: count(N); END_STEP STEP b: END_STEP STEP e: END_STEP
         TRANSITION FROM s TO (a, b) := TRUE; END_TRANSITION
         TRANSITION FROM (a, b) TO e := one AND two; END_TRANSITION
         ACTION count: n := n + 1; END_ACTION
         END_PROGRAM",
    );
    let Body::Chart(chart) = &pou.body else { panic!("a chart") };
    let mut run = Run::new(chart, &pou, Options::default());
    run.memory.set("n", Value::Int(0));
    for scan in 0..4 {
        run.memory.set("one", Value::Bool(true));
        run.memory.set("two", Value::Bool(scan == 3));
        run.scan(scan).expect("a scan");
    }
    assert_eq!(run.active(), [false, false, false, true]);
    assert_eq!(run.memory.get("n"), Some(Value::Int(3)), "twice, and the final scan");
}

//! Checks that every kind of step is charged each time it is executed, in the model and in the interpreter.

use scanbound_base::time::{Picos, Times};
use scanbound_ir::{ChoiceId, Join, Logic, Program, Step, Summary, Witness, WordSource, testing};
use scanbound_model::Assignment;
use scanbound_replay::replay;
use scanbound_scan::scan_model;
use std::collections::BTreeSet;

/// A number for each kind of step. A new kind gets the next number, and must be added to [`programs`] and counted in
/// [`KINDS`].
fn kind(step: &Step) -> usize {
    match step {
        Step::Logic { .. } => 0,
        Step::AndBlock => 1,
        Step::OrBlock => 2,
        Step::Save(_) => 3,
        Step::Fetch(_) => 4,
        Step::Act { .. } => 5,
        Step::Jump { .. } => 6,
        Step::Call { .. } => 7,
        Step::Return => 8,
        Step::End => 9,
        Step::Stop { .. } => 10,
        Step::Unbounded { .. } => 11,
        Step::ForBegin { .. } => 12,
        Step::ForEnd => 13,
        Step::Summary(_) => 14,
        Step::MasterControlBegin { .. } => 15,
        Step::MasterControlEnd { .. } => 16,
        Step::Nothing => 17,
    }
}

const KINDS: usize = 18;

const ALWAYS: Logic = Logic::Const(true);

/// Programs that together contain every kind of step. Each step comes with the number of its executions in a scan.
fn programs() -> Vec<Vec<(Step, u64)>> {
    let contact = |join| Step::Logic { join, value: ALWAYS };
    let act = || Step::Act { fires: Logic::Condition };
    let loop_to = |end| Step::ForBegin { count: WordSource::Const(2), least: 0, most: 5, end };
    let summary = |end| {
        let charges = vec![(end - 1, 3)];
        let choice = ChoiceId(0);
        Step::Summary(Box::new(Summary {
            end,
            charges,
            havocs: vec![],
            choice,
            exits: vec![],
            iterations: None,
        }))
    };
    vec![
        vec![
            (contact(Join::Start), 1),
            (contact(Join::Load), 1),
            (Step::AndBlock, 1),
            (contact(Join::Load), 1),
            (Step::OrBlock, 1),
            (Step::Save(0), 1),
            (Step::Fetch(0), 1),
            (Step::MasterControlBegin { level: 0, fires: Logic::Condition }, 1),
            (act(), 1),
            (Step::MasterControlEnd { level: 0 }, 1),
            (Step::Jump { fires: ALWAYS, target: 12 }, 1),
            (act(), 0),
            (loop_to(14), 1),
            (Step::Nothing, 2),
            (Step::ForEnd, 2),
            (summary(17), 1),
            (act(), 3),
            (Step::ForEnd, 0),
            (Step::End, 1),
            (act(), 0),
        ],
        vec![
            (Step::Call { fires: ALWAYS, target: 3 }, 1),
            (Step::Stop { fires: ALWAYS }, 1),
            (act(), 0),
            (act(), 1),
            (Step::Return, 1),
        ],
        vec![(Step::Unbounded { from: 0, certain: true }, 1), (act(), 0)],
    ]
}

#[test]
fn every_kind_of_step_is_charged_as_often_as_it_is_executed() {
    let mut seen = BTreeSet::new();
    for steps in programs() {
        seen.extend(steps.iter().map(|(step, _)| kind(step)));
        // Each instruction has its own digit in the sum.
        let times: Vec<Times> = (0..steps.len() as u32)
            .map(|place| Picos(1 << (3 * place)))
            .map(|time| Times::new(time, time))
            .collect();
        let expected: Picos =
            steps.iter().zip(&times).map(|((_, times), cost)| cost.on.times(*times)).sum();
        let count = steps.len();
        let program = Program {
            mains: vec![0..count; 1],
            choices: 1,
            ..testing::program(steps.into_iter().map(|(step, _)| step))
        };
        assert_eq!(replay(&program, &times, &Witness::default()).total, expected);
        let model = scan_model(&program, &times).unwrap();
        let all: Vec<usize> = (0..model.charges.len()).collect();
        let zeros = Assignment(vec![0; model.variables.len()]);
        assert_eq!(model.cost(&all, &zeros), expected);
    }
    assert_eq!(seen, (0..KINDS).collect());
}

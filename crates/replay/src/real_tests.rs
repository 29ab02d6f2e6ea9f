//! Tests of real runs: unknown values, undeclared writes of operations, loops with one iteration or none.

use super::control_tests::{bit, instruction, program, word};
use super::*;
use scanbound_base::time::Picos;
use scanbound_ir::Cell;
use scanbound_ir::meaning::{ChoiceKind, Meaning, Operation, OperationInput, Target};
use scanbound_ir::{
    ChoiceId, Effect, Join, Logic, Region, Step, When, WordSource, WordTarget, Write,
};

fn run(program: &Program) -> RealRun {
    let times = vec![Times::new(Picos(10), Picos(1)); program.instructions.len()];
    let witness = Witness::default();
    real(program, &times, || &witness, 1000)
}

fn act(write: Write) -> scanbound_ir::Instruction {
    let effects = vec![Effect { when: When::Fired, write }];
    instruction(Step::Act { fires: Logic::Const(true) }, effects)
}

fn contact(cell: Cell) -> scanbound_ir::Instruction {
    instruction(Step::Logic { join: Join::Start, value: Logic::cell(cell) }, vec![])
}

fn jump(target: usize) -> scanbound_ir::Instruction {
    instruction(Step::Jump { fires: Logic::Condition, target }, vec![])
}

#[test]
fn what_is_not_known_costs_the_lesser_time_and_decides_no_way() {
    let havoc = act(Write::Havoc(Region::Range { first: bit(0), count: 1 }, ChoiceId(0)));
    let mut p = program(vec![havoc, contact(bit(0)), jump(3), contact(bit(1))]);
    let found = run(&p);
    assert_eq!(found.stopped.as_ref().map(|stopped| stopped.at), Some(2));
    assert_eq!(found.stopped.map(|stopped| stopped.reason), Some(StopReason::Unknown(0)));
    assert_eq!(found.replay.total, Picos(10 + 1 + 1));
    // A value from outside is a value like any other.
    p.kinds.insert(ChoiceId(0), ChoiceKind::External);
    assert_eq!(run(&p).stopped, None);
}

#[test]
fn a_write_of_what_is_there_already_leaves_it_known() {
    let havoc = act(Write::Havoc(Region::Range { first: bit(0), count: 1 }, ChoiceId(0)));
    let reset = Write::Bit(scanbound_ir::BitTarget::Cell(bit(1)), Logic::Const(false));
    let perhaps = |write| {
        let effects = vec![Effect { when: When::Fired, write }];
        instruction(Step::Act { fires: Logic::cell(bit(0)) }, effects)
    };
    let p = program(vec![havoc.clone(), perhaps(reset), contact(bit(1)), jump(4), contact(bit(2))]);
    assert_eq!(run(&p).stopped, None);
    let set = Write::Bit(scanbound_ir::BitTarget::Cell(bit(1)), Logic::Const(true));
    let p = program(vec![havoc, perhaps(set), contact(bit(1)), jump(4), contact(bit(2))]);
    assert_eq!(run(&p).stopped.map(|stopped| stopped.reason), Some(StopReason::Unknown(0)));
}

#[test]
fn an_operation_that_writes_beyond_its_effects_is_told() {
    let havoc = act(Write::Havoc(Region::Range { first: word(0), count: 1 }, ChoiceId(0)));
    let mut p = program(vec![havoc]);
    let meaning = |cell| Meaning {
        operation: Operation::Copy,
        inputs: vec![OperationInput::Words(vec![WordSource::Const(7)])],
        outputs: vec![Target::Words(vec![WordTarget::Cell(cell)])],
    };
    p.kinds.insert(ChoiceId(0), ChoiceKind::Exact(Box::new(meaning(word(0)))));
    assert_eq!(run(&p).undeclared_writes, []);
    p.kinds.insert(ChoiceId(0), ChoiceKind::Exact(Box::new(meaning(word(1)))));
    assert_eq!(run(&p).undeclared_writes, [(0, word(1))]);
}

#[test]
fn a_loop_of_one_turn_or_none_takes_the_cheaper() {
    let body = |body: Vec<scanbound_ir::Instruction>| {
        let count = WordSource::Free(ChoiceId(0));
        let end = body.len() + 1;
        let mut all = vec![instruction(Step::ForBegin { count, least: 0, most: 9, end }, vec![])];
        all.extend(body);
        all.push(instruction(Step::ForEnd, vec![]));
        // The code behind the loop is long enough that an iteration which sets M1 gives the shorter path.
        all.extend([contact(bit(1)), jump(end + 7)]);
        all.extend((0..4).map(|_| instruction(Step::Nothing, vec![])));
        all.push(instruction(Step::Nothing, vec![]));
        let mut p = program(all);
        p.kinds.insert(ChoiceId(0), ChoiceKind::Iterations(WordSource::Const(0)));
        run(&p)
    };
    let set = Write::Bit(scanbound_ir::BitTarget::Cell(bit(1)), Logic::Const(true));
    let ran = |real: &RealRun| real.replay.events.iter().any(|event| event.instruction == 1);
    assert!(ran(&body(vec![act(set)])));
    assert!(!ran(&body(vec![instruction(Step::Nothing, vec![])])));
}

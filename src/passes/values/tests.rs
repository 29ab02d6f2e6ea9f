//! What the pass says of programs as no front writes them: ways that meet within a rung, routines that end by
//! themselves, results that are asked for behind a loop.

use super::*;
use crate::program::{
    Area, AreaId, AreaKind, Counted, Effect, Instruction, Join, Logic, Number, Radix, TimingKey,
    When, WordSource, WordTarget, testing,
};

fn m(index: u32) -> Logic {
    Logic::cell(Cell { area: AreaId(0), index })
}

fn d(index: u32) -> Cell {
    Cell { area: AreaId(1), index }
}

const ALWAYS: Logic = Logic::Const(true);
const NEVER: Logic = Logic::Const(false);

fn start(value: Logic) -> Instruction {
    testing::instruction(Step::Logic { join: Join::Start, value })
}

/// Puts a number into D0 if it fires.
fn put(fires: Logic, value: u16) -> Instruction {
    let number = Number::Words(vec![WordSource::Const(value)]);
    let write = Write::Words(vec![WordTarget::Cell(d(0))], number);
    testing::with_effects(Step::Act { fires }, vec![Effect { when: When::Fired, write }])
}

fn jump(fires: Logic, target: usize) -> Instruction {
    testing::instruction(Step::Jump { fires, target })
}

/// Handles as many units as D0 says.
fn count() -> Instruction {
    let words = vec![WordSource::Cell(d(0))];
    let units = Units::Counted(Counted { words, each: 1, most: 65_535, executes_up_to: 65_535 });
    let timing = TimingKey {
        names: Vec::new(),
        class: "",
        units,
        dearer: false,
        optional: false,
        touched: crate::program::Touched::default(),
    };
    let act = testing::instruction(Step::Act { fires: ALWAYS });
    Instruction { timing: Some(Box::new(timing)), ..act }
}

/// The most units that are counted, whatever memory holds when the scan starts. The first `main` instructions are the main
/// routine.
fn most(main: usize, instructions: Vec<Instruction>) -> u64 {
    let area = |name: &str, kind| Area::new(name, kind, Radix::Decimal);
    let mut program = Program {
        areas: vec![area("M", AreaKind::Bit), area("D", AreaKind::Word)],
        mains: vec![0..main; 1],
        instructions,
        ..Program::default()
    };
    (PASS.run)(&mut program, &Settings { trust: Trust::None, budget: None }).expect("no fault");
    let counted = program.instructions.iter().find_map(Instruction::counted);
    counted.expect("something is counted").most
}

#[test]
fn a_routine_ends_by_itself_where_it_does_not_return() {
    let step = testing::instruction;
    let called = vec![
        put(ALWAYS, 1),
        step(Step::Call { fires: ALWAYS, target: 4 }),
        count(),
        step(Step::End),
        jump(m(0), 6),
        step(Step::Return),
        put(ALWAYS, 9),
    ];
    assert_eq!(most(4, called), 9);
}

#[test]
fn a_result_is_the_one_of_either_way_that_leads_to_it() {
    for (before, then, expected) in [(20, 9, 20), (1, 9, 9)] {
        for (jumped, passed) in [(ALWAYS, NEVER), (NEVER, ALWAYS)] {
            let rung = vec![
                put(ALWAYS, before),
                start(jumped),
                jump(m(0), 4),
                start(passed),
                put(Logic::Condition, then),
                count(),
            ];
            assert_eq!(most(6, rung), expected, "{before}, then perhaps {then}");
        }
    }
}

#[test]
fn what_one_way_did_not_save_is_not_what_the_other_did() {
    let (save, fetch) =
        (|| testing::instruction(Step::Save(0)), || testing::instruction(Step::Fetch(0)));
    // What is asked of an empty slot is true.
    let passed = vec![
        put(ALWAYS, 1),
        start(ALWAYS),
        jump(m(0), 5),
        start(NEVER),
        save(),
        fetch(),
        put(Logic::Condition, 9),
        count(),
    ];
    assert_eq!(most(8, passed), 9);
    let jumped = vec![
        put(ALWAYS, 20),
        start(ALWAYS),
        jump(m(0), 6),
        start(NEVER),
        save(),
        jump(ALWAYS, 7),
        testing::instruction(Step::Nothing),
        fetch(),
        put(Logic::Condition, 9),
        count(),
    ];
    assert_eq!(most(10, jumped), 20);
}

#[test]
fn behind_a_loop_that_may_make_no_turn_nothing_is_known_of_its_results() {
    let rung = vec![
        put(ALWAYS, 1),
        start(ALWAYS),
        testing::instruction(Step::ForBegin {
            count: WordSource::Cell(d(1)),
            least: 0,
            most: 3,
            end: 4,
        }),
        start(NEVER),
        testing::instruction(Step::ForEnd),
        put(Logic::Condition, 9),
        count(),
    ];
    assert_eq!(most(7, rung), 9);
}

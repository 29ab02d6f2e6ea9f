//! Tests on programs that no front generates: paths that join within a rung, routines that end early, results that are
//! read after a loop.

use super::*;
use scanbound_ir::meaning::OperationInput;
use scanbound_ir::{
    Area, AreaId, AreaKind, Compare, Counted, Effect, Instruction, Interrupt, Join, Logic, Number,
    NumberFormat, Radix, Relation, TimingKey, When, WordSource, WordTarget, testing,
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

/// Writes a number to D0 if it fires.
fn put(fires: Logic, value: u16) -> Instruction {
    let number = Number::Words(vec![WordSource::Const(value)]);
    let write = Write::Words(vec![WordTarget::Cell(d(0))], number);
    testing::with_effects(Step::Act { fires }, vec![Effect { when: When::Fired, write }])
}

fn jump(fires: Logic, target: usize) -> Instruction {
    testing::instruction(Step::Jump { fires, target })
}

/// An instruction that processes as many units as D0 says.
fn count() -> Instruction {
    let words = vec![WordSource::Cell(d(0))];
    let units = Units::Counted(Counted { words, each: 1, most: 65_535, executes_up_to: 65_535 });
    let timing = TimingKey {
        names: Vec::new(),
        class: "",
        units,
        use_larger_time: false,
        optional: false,
        accessed: scanbound_ir::AccessedDevices::default(),
    };
    let act = testing::instruction(Step::Act { fires: ALWAYS });
    Instruction { timing: Some(Box::new(timing)), ..act }
}

/// A program whose first `main` instructions are the main routine.
fn program(main: usize, instructions: Vec<Instruction>) -> Program {
    let area = |name: &str, kind| Area::new(name, kind, Radix::Decimal);
    Program {
        areas: vec![area("M", AreaKind::Bit), area("D", AreaKind::Word)],
        mains: vec![0..main; 1],
        instructions,
        ..Program::default()
    }
}

/// The largest number of units, for any values at the start of the scan.
fn counted_at_most(program: &mut Program) -> u64 {
    (PASS.run)(program, &Settings { trust: Trust::None, budget: None }).expect("no fault");
    let counted = program.instructions.iter().find_map(Instruction::counted);
    counted.expect("something is counted").most
}

/// The largest number of units in a program of these instructions, for any values at the start of the scan.
fn most(main: usize, instructions: Vec<Instruction>) -> u64 {
    counted_at_most(&mut program(main, instructions))
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

/// If a routine or a program has two ends, the states at both are joined.
#[test]
fn a_routine_and_a_program_end_at_either_of_their_ends() {
    let step = testing::instruction;
    let called = vec![
        step(Step::Call { fires: ALWAYS, target: 3 }),
        count(),
        step(Step::End),
        jump(m(0), 6),
        put(ALWAYS, 9),
        step(Step::Return),
        put(ALWAYS, 1),
        step(Step::Return),
    ];
    assert_eq!(most(3, called), 9);
    let ended = vec![
        jump(m(0), 3),
        put(ALWAYS, 9),
        step(Step::End),
        put(ALWAYS, 1),
        step(Step::End),
        count(),
    ];
    let mut ended = program(5, ended);
    ended.mains.push(5..6);
    assert_eq!(counted_at_most(&mut ended), 9);
}

/// If two paths with different stack depths join, the last result is unknown.
#[test]
fn results_of_unlike_depth_are_not_taken_for_each_other() {
    let load = testing::instruction(Step::Logic { join: Join::Load, value: ALWAYS });
    let rung =
        vec![put(ALWAYS, 9), start(NEVER), jump(m(0), 4), load, put(Logic::Condition, 1), count()];
    assert_eq!(most(6, rung), 9);
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
    // Reading an empty slot gives true.
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

/// The effects of a contact in series do not depend on the contacts before it.
#[test]
fn what_a_contact_does_does_not_hang_on_those_before_it() {
    let is_seven = Logic::Compare(Box::new(Compare {
        relation: Relation::Equal,
        format: NumberFormat::Signed,
        left: Number::Words(vec![WordSource::Cell(d(0))]),
        right: Number::Words(vec![WordSource::Const(7)]),
    }));
    let nine = put(ALWAYS, 9).effects;
    let contact = Step::Logic { join: Join::And, value: is_seven };
    let does = vec![
        put(ALWAYS, 7),
        put(m(0), 1),
        start(m(0)),
        testing::with_effects(contact.clone(), nine),
        start(ALWAYS),
        count(),
    ];
    assert_eq!(most(6, does), 9);
    let counts = vec![
        put(ALWAYS, 7),
        put(m(0), 1),
        start(m(0)),
        Instruction { timing: count().timing, ..testing::instruction(contact) },
    ];
    assert_eq!(most(4, counts), 7);
}

/// Rungs that change nothing relevant are skipped, unless control can jump into them, or a later rung reads a slot or
/// result that they leave.
#[test]
fn rungs_that_matter_to_others_are_not_passed_over() {
    let step = testing::instruction;
    let contact = |value| step(Step::Logic { join: Join::And, value });
    let entered = vec![
        put(ALWAYS, 9),
        jump(m(0), 4),
        put(ALWAYS, 1),
        start(m(1)),
        contact(m(2)),
        start(ALWAYS),
        count(),
    ];
    assert_eq!(most(7, entered), 9);
    let saved = vec![
        put(ALWAYS, 9),
        start(NEVER),
        step(Step::Save(0)),
        start(ALWAYS),
        step(Step::Fetch(0)),
        put(Logic::Condition, 1),
        count(),
    ];
    assert_eq!(most(7, saved), 9);
    let asked = vec![put(ALWAYS, 9), start(ALWAYS), put(Logic::Condition, 8), start(NEVER)];
    let asked = [asked, vec![put(Logic::Condition, 1), count()]].concat();
    assert_eq!(most(6, asked), 8);
}

/// An iteration reads the results that the previous one left, even if nothing else has changed.
#[test]
fn a_loops_first_turn_says_nothing_of_the_others_results() {
    let turns = |count: u16, most: u32| {
        let count = WordSource::Const(count);
        testing::instruction(Step::ForBegin { count, least: 0, most, end: 5 })
    };
    let looped = vec![
        put(ALWAYS, 1),
        start(NEVER),
        turns(2, 3),
        put(Logic::Condition, 9),
        start(ALWAYS),
        testing::instruction(Step::ForEnd),
        start(ALWAYS),
        count(),
    ];
    assert_eq!(most(8, looped), 9);
}

/// An interrupt may occur at any moment of the scan, not only at its end.
#[test]
fn what_an_interrupt_counts_it_may_count_before_the_scan_is_over() {
    let copied = Meaning::of(OperationInput::Words(vec![WordSource::Cell(d(0))]));
    let mut counted = count();
    if let Some(Units::Counted(units)) = counted.timing.as_mut().map(|key| &mut key.units) {
        units.words = vec![WordSource::Free(ChoiceId(0))];
    }
    let instructions = vec![
        put(ALWAYS, 9),
        put(ALWAYS, 1),
        testing::instruction(Step::End),
        counted,
        testing::instruction(Step::Return),
    ];
    let mut program = Program {
        kinds: [(ChoiceId(0), ChoiceKind::Exact(Box::new(copied)))].into(),
        choices: 1,
        interrupts: vec![Interrupt { name: "I0".to_owned(), entry: 3, times: 1, stated: true }],
        ..program(3, instructions)
    };
    assert!(counted_at_most(&mut program) >= 9);
}

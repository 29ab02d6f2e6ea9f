//! Tests of the interpreter's control: stack, slots, master control regions, jumps, calls, loops and the order of
//! routines.

use super::*;
use scanbound_base::time::Picos;
use scanbound_ir::AreaKind;
use scanbound_ir::{
    Area, AreaId, BitSource, BitTarget, ChoiceId, Effect, Exit, Instruction, Interrupt, Join,
    Logic, Radix, Region, Step, Summary, When, WordSource, Write,
};
use scanbound_ir::{Cell, ChoiceKey, Frame};

const ON: u64 = 100;
const OFF: u64 = 1;

pub(super) fn bit(index: u32) -> Cell {
    Cell { area: AreaId(0), index }
}

pub(super) fn word(index: u32) -> Cell {
    Cell { area: AreaId(1), index }
}

pub(super) use scanbound_ir::testing::with_effects as instruction;

/// A program of one main routine over the bit area M and the word area D.
pub(super) fn program(instructions: Vec<Instruction>) -> Program {
    let area = |name: &str, kind| Area::new(name, kind, Radix::Decimal);
    Program {
        areas: vec![area("M", AreaKind::Bit), area("D", AreaKind::Word)],
        mains: vec![0..instructions.len(); 1],
        instructions,
        choices: 100,
        ..Program::default()
    }
}

/// What was executed, with whether it fired; every instruction costs 100 ps on and 1 ps off.
fn run(program: &Program, ones: &[u32]) -> Vec<(usize, bool)> {
    let mut witness = Witness::default();
    witness.start.extend(ones.iter().map(|&m| (bit(m), 1)));
    run_on(program, &witness)
}

fn run_on(program: &Program, witness: &Witness) -> Vec<(usize, bool)> {
    let times = vec![Times::new(Picos(ON), Picos(OFF)); program.instructions.len()];
    let replay = replay(program, &times, witness);
    assert_eq!(replay.total, replay.events.iter().map(|event| event.cost).sum());
    replay.events.iter().map(|event| (event.instruction, event.fired)).collect()
}

fn fired(program: &Program, ones: &[u32], at: usize) -> bool {
    let events = run(program, ones);
    events.iter().find(|(instruction, _)| *instruction == at).expect("reached").1
}

fn m(index: u32) -> Logic {
    Logic::cell(bit(index))
}

fn logic(join: Join, value: Logic) -> Instruction {
    instruction(Step::Logic { join, value }, vec![])
}

fn ld(index: u32) -> Instruction {
    logic(Join::Start, m(index))
}

fn act() -> Instruction {
    instruction(Step::Act { fires: Logic::Condition }, vec![])
}

fn step(step: Step) -> Instruction {
    instruction(step, vec![])
}

fn set(index: u32) -> Instruction {
    let write = Write::Bit(BitTarget::Cell(bit(index)), Logic::Const(true));
    instruction(Step::Act { fires: Logic::Condition }, vec![Effect { when: When::Fired, write }])
}

fn for_begin(count: WordSource, end: usize) -> Instruction {
    step(Step::ForBegin { count, least: 0, most: 10, end })
}

#[test]
fn the_empty_program_costs_nothing() {
    let empty = program(vec![]);
    assert_eq!(replay(&empty, &[], &Witness::default()).total, Picos::ZERO);
}

#[test]
fn joins_build_the_condition() {
    // (M0 and M1) or M2
    let p = program(vec![ld(0), logic(Join::And, m(1)), logic(Join::Or, m(2)), act()]);
    for (ones, want) in
        [(&[][..], false), (&[0], false), (&[1], false), (&[0, 1], true), (&[2], true)]
    {
        assert_eq!(fired(&p, ones, 3), want, "{ones:?}");
    }
    // M0 (M1 or M2 as a block)
    let p = program(vec![
        ld(0),
        logic(Join::Load, m(1)),
        logic(Join::Or, m(2)),
        step(Step::AndBlock),
        act(),
    ]);
    for (ones, want) in [(&[0][..], false), (&[1, 2], false), (&[0, 1], true), (&[0, 2], true)] {
        assert_eq!(fired(&p, ones, 4), want, "{ones:?}");
    }
    let p = program(vec![ld(0), logic(Join::Load, m(1)), step(Step::OrBlock), act()]);
    for (ones, want) in [(&[][..], false), (&[0], true), (&[1], true)] {
        assert_eq!(fired(&p, ones, 3), want, "{ones:?}");
    }
}

#[test]
fn the_empty_stack_is_true_and_start_empties_it() {
    assert!(fired(&program(vec![act()]), &[], 0));
    // Start drops what is left over, so that the block join finds nothing below M1.
    let p = program(vec![ld(0), ld(1), step(Step::AndBlock), act()]);
    assert!(fired(&p, &[1], 3));
    let p = program(vec![step(Step::Fetch(7)), act(), logic(Join::Replace, m(0)), act()]);
    assert_eq!(run(&p, &[]), [(0, true), (1, true), (2, false), (3, false)]);
}

#[test]
fn replace_negates_the_result() {
    let p = program(vec![ld(0), logic(Join::Replace, Logic::Condition.not()), act()]);
    assert_eq!(run(&p, &[]), [(0, false), (1, true), (2, true)]);
    assert_eq!(run(&p, &[0]), [(0, true), (1, false), (2, false)]);
}

#[test]
fn slots_keep_a_branch() {
    let p = program(vec![
        ld(0),
        step(Step::Save(1)),
        logic(Join::And, m(1)),
        act(),
        step(Step::Fetch(1)),
        logic(Join::And, m(2)),
        act(),
    ]);
    assert!(!fired(&p, &[0, 2], 3) && fired(&p, &[0, 2], 6));
    assert!(fired(&p, &[0, 1], 3) && !fired(&p, &[0, 1], 6));
}

#[test]
fn zones_hold_off_what_acts_but_not_contacts_and_loops() {
    let master = |level| step(Step::MasterControlBegin { level, fires: Logic::Condition });
    let p = program(vec![
        ld(0),
        master(0),
        ld(1),
        master(1),
        ld(2),
        act(),
        step(Step::MasterControlEnd { level: 1 }),
        ld(2),
        act(),
        step(Step::MasterControlEnd { level: 0 }),
        ld(2),
        act(),
    ]);
    let acts = |ones| [fired(&p, ones, 5), fired(&p, ones, 8), fired(&p, ones, 11)];
    assert_eq!(acts(&[2]), [false, false, true]);
    assert_eq!(acts(&[1, 2]), [false, false, true]);
    assert!(!fired(&p, &[1, 2], 3), "the inner region is held off too");
    assert!(fired(&p, &[2], 4), "a contact in a region that is off reads its device");
    assert_eq!(acts(&[0, 2]), [false, true, true]);
    assert_eq!(acts(&[0, 1, 2]), [true, true, true]);

    // Ending the outer level ends the inner one with it.
    let p = program(vec![
        ld(0),
        master(0),
        master(1),
        step(Step::MasterControlEnd { level: 0 }),
        ld(1),
        act(),
    ]);
    assert!(fired(&p, &[1], 5));

    // The loop in a master control region that is off is made, its body held off.
    let p = program(vec![
        ld(0),
        master(0),
        for_begin(WordSource::Const(2), 5),
        ld(1),
        act(),
        step(Step::ForEnd),
        step(Step::MasterControlEnd { level: 0 }),
    ]);
    let events = run(&p, &[1]);
    assert_eq!(events.iter().filter(|e| **e == (4, false)).count(), 2);
}

#[test]
fn a_constant_act_is_not_held_off() {
    let p = program(vec![ld(0), step(Step::Act { fires: Logic::Const(true) })]);
    assert!(fired(&p, &[], 1));
}

#[test]
fn jumps_skip_and_what_is_skipped_costs_nothing() {
    let jump = step(Step::Jump { fires: Logic::Condition, target: 4 });
    let p = program(vec![ld(0), jump, set(1), act(), ld(1), act()]);
    assert_eq!(run(&p, &[0]), [(0, true), (1, true), (4, false), (5, false)]);
    let times = vec![Times::new(Picos(ON), Picos(OFF)); 6];
    assert_eq!(replay(&p, &times, &Witness::default()).total, Picos(6 * OFF));
    // A jump may go to the very end.
    let jump = step(Step::Jump { fires: Logic::Const(true), target: 2 });
    assert_eq!(run(&program(vec![jump, act()]), &[]), [(0, true)]);
}

#[test]
fn a_called_routine_has_its_own_stack_slots_and_zones() {
    let call = step(Step::Call { fires: Logic::Condition, target: 8 });
    let mut p = program(vec![
        ld(0),
        step(Step::Save(1)),
        step(Step::MasterControlBegin { level: 0, fires: Logic::Not(Box::new(m(1))) }),
        logic(Join::Start, Logic::Const(true)),
        call,
        act(),
        step(Step::End),
        act(), // never reached
        act(), // the routine: stack and master control regions are empty
        logic(Join::Start, Logic::Const(false)),
        step(Step::Fetch(1)),
        act(), // the slot is empty there
        logic(Join::Start, Logic::Const(false)),
        step(Step::Return),
    ]);
    p.mains = vec![0..7; 1];
    let events = run(&p, &[]);
    assert_eq!(events[4..8], [(4, true), (8, true), (9, false), (10, true)]);
    assert_eq!(events[8..], [(11, true), (12, false), (13, true), (5, true), (6, true)]);
    assert_eq!(run(&p, &[1])[4..], [(4, false), (5, false), (6, true)], "held off by the region");
}

#[test]
fn an_end_in_a_called_routine_ends_its_main_and_the_next_main_begins_afresh() {
    let mut p = program(vec![
        step(Step::MasterControlBegin { level: 0, fires: Logic::Const(false) }),
        logic(Join::Start, Logic::Const(false)),
        step(Step::Call { fires: Logic::Const(true), target: 4 }),
        act(),
        step(Step::End),
        act(),
        act(),
    ]);
    p.mains = vec![0..4, 5..7];
    assert_eq!(run(&p, &[]), [(0, false), (1, false), (2, true), (4, true), (5, true), (6, true)]);
    let times = [Times::new(Picos(ON), Picos(OFF)); 7];
    let replay = replay(&p, &times, &Witness::default());
    assert_eq!(replay.events[4].frames[..], [], "the call was left");
}

#[test]
fn a_stop_ends_all_but_the_interrupts() {
    let mut p = program(vec![
        step(Step::Stop { fires: m(0) }),
        act(),
        act(),
        act(), // interrupt
        step(Step::Stop { fires: m(1) }),
        step(Step::Return),
    ]);
    p.mains = vec![0..2, 2..3];
    p.interrupts = vec![Interrupt { name: "I0".to_owned(), entry: 3, times: 2, stated: true }];
    let tail = [(3, true), (4, false), (5, true), (3, true), (4, false), (5, true)];
    assert_eq!(run(&p, &[0]), [vec![(0, true)], tail.to_vec()].concat());
    assert_eq!(run(&p, &[])[..3], [(0, false), (1, true), (2, true)]);
    assert_eq!(run(&p, &[0, 1])[1..], [(3, true), (4, true), (3, true), (4, true)]);
    let times = [Times::new(Picos(ON), Picos(OFF)); 6];
    let events = replay(&p, &times, &Witness::default()).events;
    let frame = |iteration| [Frame { at: 3, iteration }];
    assert_eq!((&events[3].frames[..], &events[6].frames[..]), (&frame(0)[..], &frame(1)[..]));
}

#[test]
fn loops_turn_as_often_as_counted() {
    let p = |count, least, most| {
        let begin = step(Step::ForBegin { count, least, most, end: 2 });
        program(vec![begin, act(), step(Step::ForEnd), act()])
    };
    let iterations = |p: &Program, value: u16| {
        let mut witness = Witness::default();
        witness.start.insert(word(0), value);
        run_on(p, &witness).iter().filter(|(at, _)| *at == 1).count()
    };
    for (value, want) in [(0, 0), (1, 1), (3, 3), (9, 5), (0xFFFF, 0), (0x8000, 0)] {
        assert_eq!(iterations(&p(WordSource::Cell(word(0)), 0, 5), value), want, "{value}");
    }
    assert_eq!(iterations(&p(WordSource::Const(0xFFFF), 2, 5), 0), 2);
    // No iteration: the end of the iteration is not reached either.
    assert_eq!(run(&p(WordSource::Const(0), 0, 5), &[]), [(0, true), (3, true)]);
}

#[test]
fn the_count_is_read_once_and_frames_tell_the_turns() {
    let clear = Write::Words(
        vec![scanbound_ir::WordTarget::Cell(word(0))],
        scanbound_ir::Number::Words(vec![WordSource::Const(0)]),
    );
    let body = instruction(
        Step::Act { fires: Logic::Condition },
        vec![Effect { when: When::Always, write: clear }],
    );
    let p = program(vec![
        for_begin(WordSource::Cell(word(0)), 4),
        body,
        for_begin(WordSource::Const(2), 3),
        step(Step::ForEnd),
        step(Step::ForEnd),
    ]);
    let mut witness = Witness::default();
    witness.start.insert(word(0), 2);
    let times = [Times::new(Picos(ON), Picos(OFF)); 5];
    let frames: Vec<Vec<(usize, u32)>> = replay(&p, &times, &witness)
        .events
        .iter()
        .map(|event| event.frames.iter().map(|frame| (frame.at, frame.iteration)).collect())
        .collect();
    let iteration =
        |n| [vec![(0, n)], vec![(0, n)], vec![(0, n), (2, 0)], vec![(0, n), (2, 1)], vec![(0, n)]];
    assert_eq!(frames, [&[vec![]][..], &iteration(0), &iteration(1)].concat());
}

#[test]
fn a_jump_out_ends_the_loops_and_a_return_too() {
    let jump = |target| step(Step::Jump { fires: m(0), target });
    let inner = |target| {
        program(vec![
            for_begin(WordSource::Const(2), 5),
            for_begin(WordSource::Const(2), 4),
            jump(target),
            act(),
            step(Step::ForEnd),
            step(Step::ForEnd),
            act(),
        ])
    };
    let at = |p: &Program, at: usize| run(p, &[0]).iter().filter(|e| e.0 == at).count();
    // To the inner loop's end: both loops go on.
    assert_eq!((at(&inner(4), 2), at(&inner(4), 3), at(&inner(4), 5)), (4, 0, 2));
    // To the outer loop's end: the inner one ends.
    assert_eq!((at(&inner(5), 2), at(&inner(5), 4), at(&inner(5), 5)), (2, 0, 2));
    // Behind both.
    assert_eq!((at(&inner(6), 2), at(&inner(6), 5), at(&inner(6), 6)), (1, 0, 1));
    let times = [Times::new(Picos(ON), Picos(OFF)); 7];
    let mut witness = Witness::default();
    witness.start.insert(bit(0), 1);
    let events = replay(&inner(6), &times, &witness).events;
    assert_eq!(events.last().map(|event| event.frames.len()), Some(0));

    let mut p = program(vec![
        step(Step::Call { fires: Logic::Const(true), target: 3 }),
        act(),
        step(Step::End),
        for_begin(WordSource::Const(3), 5),
        step(Step::Return),
        step(Step::ForEnd),
    ]);
    p.mains = vec![0..3; 1];
    assert_eq!(run(&p, &[]), [(0, true), (3, true), (4, true), (1, true), (2, true)]);
}

#[test]
fn a_loop_summary_charges_the_larger_times_havocs_and_leaves_by_its_first_open_exit() {
    let summary = Step::Summary(Box::new(Summary {
        end: 2,
        charges: vec![(1, 7), (2, 3)],
        havocs: vec![Region::Range { first: bit(0), count: 1 }],
        choice: ChoiceId(0),
        exits: vec![(ChoiceId(1), Exit::To(4)), (ChoiceId(2), Exit::To(3))],
        iterations: None,
    }));
    let p = program(vec![step(summary), act(), step(Step::ForEnd), ld(0), ld(1)]);
    let times = [(5, 6), (1, 2), (20, 10), (100, 0), (1000, 0)]
        .map(|(on, off)| Times::new(Picos(on), Picos(off)));
    let go = |choices: &[(u32, Option<Cell>)]| {
        let mut witness = Witness::default();
        witness.start.insert(bit(0), 0);
        for &(choice, cell) in choices {
            let key = ChoiceKey { frames: vec![], choice: ChoiceId(choice), cell };
            witness.choices.insert(key, 1);
        }
        replay(&p, &times, &witness)
    };
    let base = 5 + 7 * 2 + 3 * 20;
    assert_eq!(go(&[]).total, Picos(base));
    assert_eq!(go(&[(0, Some(bit(0)))]).total, Picos(base + 100));
    assert_eq!(go(&[(0, Some(bit(0))), (1, None)]).total, Picos(base), "gone to 4");
    let at: Vec<usize> = go(&[(1, None), (2, None)]).events.iter().map(|e| e.instruction).collect();
    assert_eq!(at, [0, 1, 2, 4]);
    let at: Vec<usize> = go(&[(2, None)]).events.iter().map(|e| e.instruction).collect();
    assert_eq!(at, [0, 1, 2, 3, 4]);
    let fired: Vec<bool> = go(&[]).events.iter().map(|e| e.fired).collect();
    assert_eq!(fired[..3], [true, false, true]);
}

#[test]
fn choices_differ_by_turn_and_not_within_one() {
    let free = Logic::Bit(BitSource::Free(ChoiceId(3)));
    let p = program(vec![
        for_begin(WordSource::Const(2), 3),
        logic(Join::Start, free.clone()),
        logic(Join::Start, free),
        step(Step::ForEnd),
    ]);
    let mut witness = Witness::default();
    let frames = vec![Frame { at: 0, iteration: 1 }];
    witness.choices.insert(ChoiceKey { frames, choice: ChoiceId(3), cell: None }, 1);
    let contacts: Vec<bool> =
        run_on(&p, &witness).iter().filter(|e| e.0 == 1 || e.0 == 2).map(|e| e.1).collect();
    assert_eq!(contacts, [false, false, true, true]);
}

#[test]
#[should_panic(expected = "time overflow")]
fn a_sum_of_times_never_wraps() {
    let p = program(vec![act(), act()]);
    let times = [Times::new(Picos(u64::MAX), Picos::ZERO); 2];
    let _ = replay(&p, &times, &Witness::default());
}

#[test]
fn a_scan_is_given_up_where_it_goes_round_for_ever() {
    let mut p = program(vec![
        instruction(Step::Jump { fires: m(0), target: 2 }, vec![]),
        instruction(Step::Unbounded { from: 0, certain: true }, vec![]),
        instruction(Step::Nothing, vec![]),
    ]);
    let times = vec![Times::new(Picos(ON), Picos(OFF)); 3];
    let mut witness = Witness::default();
    let lost = replay(&p, &times, &witness);
    assert_eq!((lost.unbounded, lost.events.len()), (Some(1), 2));
    p.invariants = vec![m(0), m(1).not()];
    assert_eq!(replay(&p, &times, &witness).broken_invariants, [0]);
    witness.start.insert(bit(0), 1);
    let ended = replay(&p, &times, &witness);
    assert_eq!((ended.unbounded, ended.events.len()), (None, 2));
    assert!(ended.broken_invariants.is_empty());
}

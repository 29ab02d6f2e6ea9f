//! Tests of choices that are computed when they are read or written, and of stack results that only one path leaves.

use super::*;
use scanbound_base::time::Picos;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::meaning::{Meaning, Operation, OperationInput, Target};
use scanbound_ir::{
    Area, AreaId, AreaKind, ChoiceId, Compare, Instruction, Join, Number, NumberFormat, Radix,
    Region, Relation, WordTarget, testing,
};
use scanbound_model::{Assignment, Origin, VarKind};

const COST: Picos = Picos(100);
const ALWAYS: Logic = Logic::Const(true);

fn m(index: u32) -> Cell {
    Cell { area: AreaId(0), index }
}

fn d(index: u32) -> Cell {
    Cell { area: AreaId(1), index }
}

fn is_on(index: u32) -> Logic {
    Logic::cell(m(index))
}

fn act(fires: Logic, when: &[When], writes: Vec<Write>) -> Instruction {
    let effects = when.iter().zip(writes).map(|(&when, write)| Effect { when, write });
    testing::with_effects(Step::Act { fires }, effects.collect())
}

fn put(to: u32, from: WordSource) -> Write {
    Write::Words(vec![WordTarget::Cell(d(to))], Number::Words(vec![from]))
}

/// The last instruction, the only one with a cost: it fires if a word equals this number.
fn asks(word: u32, number: u16) -> Instruction {
    let words = |word| Number::Words(vec![word]);
    let compare = Compare {
        relation: Relation::Equal,
        format: NumberFormat::Signed,
        left: words(WordSource::Cell(d(word))),
        right: words(WordSource::Const(number)),
    };
    act(Logic::Compare(Box::new(compare)), &[], Vec::new())
}

/// A program with one choice: a copy of this word.
fn program(from: WordSource, to: Vec<Target>, instructions: Vec<Instruction>) -> Program {
    let area = |name: &str, kind| Area::new(name, kind, Radix::Decimal);
    let inputs = vec![OperationInput::Words(vec![from])];
    let meaning = Meaning { operation: Operation::Copy, inputs, outputs: to };
    Program {
        areas: vec![area("M", AreaKind::Bit), area("D", AreaKind::Word)],
        mains: vec![0..instructions.len(); 1],
        instructions,
        choices: 1,
        kinds: [(ChoiceId(0), ChoiceKind::Exact(Box::new(meaning)))].into(),
        ..Program::default()
    }
}

/// Whether the last instruction may fire in a scan that starts with all relays off and with any of these values in the
/// unknown words.
fn may_fire(program: &Program, words: &[u16]) -> bool {
    let mut times = vec![Times::new(Picos::ZERO, Picos::ZERO); program.instructions.len()];
    *times.last_mut().expect("instructions") = Times::new(COST, Picos::ZERO);
    let model = scan_model(program, &times).expect("followed");
    let all: Vec<usize> = (0..model.charges.len()).collect();
    let cost = |value: u16| {
        let of = |variable: &scanbound_model::Variable| match (variable.kind, &variable.origin) {
            (VarKind::Bit, Origin::Start(_)) => 0,
            _ => value,
        };
        model.cost(&all, &Assignment(model.variables.iter().map(of).collect()))
    };
    words.iter().any(|&value| cost(value) == COST)
}

#[test]
fn a_choice_that_was_read_on_some_ways_is_worked_out_anew_on_the_others() {
    let fired = |fires, write| act(fires, &[When::Fired], vec![write]);
    let other = || Logic::All(vec![is_on(2), is_on(1).not()]);
    let choice = WordSource::Free(ChoiceId(0));
    // D0 is 1 if M1 is on, 2 if only M2 is on, else 3; it is read in each of the three cases.
    let instructions = vec![
        fired(ALWAYS, put(0, WordSource::Const(3))),
        fired(is_on(1), put(0, WordSource::Const(1))),
        fired(other(), put(0, WordSource::Const(2))),
        fired(is_on(1), put(1, choice)),
        fired(other(), put(1, choice)),
        fired(ALWAYS, put(2, choice)),
        asks(2, 3),
    ];
    let program = program(WordSource::Cell(d(0)), Vec::new(), instructions);
    assert!(may_fire(&program, &[0]));
}

#[test]
fn what_is_written_where_an_instruction_fires_may_be_written_where_it_does_not_too() {
    let havoc = || Write::Havoc(Region::Range { first: d(0), count: 1 }, ChoiceId(0));
    let instructions = vec![
        act(ALWAYS, &[When::Fired], vec![put(0, WordSource::Const(0))]),
        act(is_on(1), &[When::Fired, When::Always], vec![havoc(), havoc()]),
        asks(0, 5),
    ];
    let to = vec![Target::Words(vec![WordTarget::Cell(d(0))])];
    let program = program(WordSource::Const(5), to, instructions);
    assert!(may_fire(&program, &[0, 5]));
}

#[test]
fn a_result_that_one_way_did_not_save_is_not_the_one_that_another_saved() {
    let step = testing::instruction;
    let (save, fetch) = (|| step(Step::Save(0)), || step(Step::Fetch(0)));
    let start = |value| step(Step::Logic { join: Join::Start, value });
    let jump = |fires, target| step(Step::Jump { fires, target });
    let passed =
        vec![start(ALWAYS), jump(is_on(1), 4), start(Logic::Const(false)), save(), fetch()];
    let jumped = vec![
        start(ALWAYS),
        jump(is_on(1), 5),
        start(Logic::Const(false)),
        save(),
        jump(ALWAYS, 6),
        step(Step::Nothing),
        fetch(),
    ];
    for instructions in [passed, jumped] {
        let last = instructions.len() - 1;
        let program = program(WordSource::Const(0), Vec::new(), instructions);
        let times = vec![Times::new(COST, COST); program.instructions.len()];
        let found = scan_model(&program, &times).map(|_| ());
        assert_eq!(found, Err(ScanError::NoResult { instruction: last }));
    }
}

//! What indices lead to, with no dialect in front: random programs in which choices read and write by an index, of
//! which one instruction may read some under several conditions. From no start does a real scan exceed the bound.

use common::bound::bound;
use common::ir::{bit, times, word};
use common::tape::{Tape, cases, on_tapes};
use scanbound::base::location::Location;
use scanbound::base::time::{Picos, Times};
use scanbound::program::meaning::{
    Address, ChoiceKind, Count, Meaning, Operation, OperationInput, Shape, Target, Term,
};
use scanbound::program::{
    Area, AreaKind, BitTarget, Cell, ChoiceId, ChoiceKey, Compare, Effect, Instruction, Join,
    Logic, Number, NumberFormat, Program, Radix, Region, Relation, Step, When, WordSource,
    WordTarget, Write,
};
use scanbound::replay::{FreeValues, real};
use scanbound::scan::scan_model;
use scanbound::solve::Method;
use std::cell::Cell as Shared;

/// The words that an index leads to, and behind them the index itself.
const LED_TO: u32 = 3;
const INDEX: u32 = LED_TO;
/// What each word may start with.
const VALUES: [u16; 3] = [0, 1, 2];

struct Generator<'t, 'a> {
    tape: &'t mut Tape<'a>,
    program: Program,
}

impl Generator<'_, '_> {
    fn put(&mut self, step: Step, effects: Vec<Effect>) -> usize {
        let at = self.program.instructions.len();
        self.program.instructions.push(instruction(at, step, effects));
        at
    }

    fn exactly(&mut self, meaning: Meaning) -> ChoiceId {
        let choice = ChoiceId(self.program.choices);
        self.program.choices += 1;
        self.program.kinds.insert(choice, ChoiceKind::Exact(Box::new(meaning)));
        choice
    }

    fn address(&mut self) -> Address {
        let base = self.tape.pick(&[0, 1, -1]);
        let term = Term::signed(WordSource::Cell(word(INDEX)));
        Address::within(word(0), LED_TO, base, vec![term])
    }

    /// A constant, a word, or the word that the index leads to.
    fn source(&mut self, shared: &mut Vec<ChoiceId>) -> WordSource {
        match self.tape.below(6) {
            0 => WordSource::Const(self.tape.pick(&[1, 0, 2])),
            1 => WordSource::Cell(word(self.tape.below(1 + LED_TO as usize) as u32)),
            2..=4 if !shared.is_empty() => WordSource::Free(self.tape.pick(&shared[..])),
            _ => {
                let run = OperationInput::Run(self.address(), Shape::Cells, Count::Exactly(1));
                let choice = self.exactly(Meaning::of(run));
                shared.push(choice);
                WordSource::Free(choice)
            }
        }
    }

    fn compare(&mut self, shared: &mut Vec<ChoiceId>) -> Logic {
        let left = match self.tape.below(3) {
            0 => self.source(shared),
            1 => WordSource::Cell(word(self.tape.below(LED_TO as usize) as u32)),
            _ => WordSource::Cell(word(INDEX)),
        };
        self.against(left)
    }

    /// A word against a constant.
    fn against(&mut self, left: WordSource) -> Logic {
        let relation = self.tape.pick(&[Relation::Equal, Relation::Less, Relation::NotEqual]);
        let right = WordSource::Const(self.tape.pick(&[1, 0, 2]));
        let [left, right] = [left, right].map(|word| Number::Words(vec![word]));
        Logic::Compare(Box::new(Compare { relation, format: NumberFormat::Signed, left, right }))
    }

    fn logic(&mut self, shared: &mut Vec<ChoiceId>) -> Logic {
        match self.tape.below(4) {
            0 => Logic::cell(bit(self.tape.below(2) as u32)),
            _ => self.compare(shared),
        }
    }

    fn effect(&mut self, shared: &mut Vec<ChoiceId>) -> Effect {
        let when = self.tape.pick(&[When::Fired, When::Always]);
        let write = match self.tape.below(6) {
            0 => Write::Bit(BitTarget::Cell(bit(self.tape.below(2) as u32)), self.logic(shared)),
            1 => {
                let constant = WordSource::Const(self.tape.pick(&[1, 0, 2]));
                let source = if self.tape.percent(70) { constant } else { self.source(shared) };
                Write::Words(vec![WordTarget::Cell(word(INDEX))], Number::Words(vec![source]))
            }
            2 | 3 => {
                let to = word(self.tape.below(LED_TO as usize) as u32);
                Write::Words(vec![WordTarget::Cell(to)], Number::Words(vec![self.source(shared)]))
            }
            _ => {
                let input = OperationInput::Words(vec![self.source(&mut Vec::new())]);
                let outputs = vec![Target::Run(self.address(), Shape::Cells)];
                let meaning = Meaning { operation: Operation::Copy, inputs: vec![input], outputs };
                let region = Region::Range { first: word(0), count: LED_TO };
                Write::Havoc(region, self.exactly(meaning))
            }
        };
        Effect { when, write }
    }

    fn rung(&mut self) {
        // Often it is known of the index behind it.
        let value = if self.tape.percent(50) {
            self.against(WordSource::Cell(word(INDEX)))
        } else {
            self.logic(&mut Vec::new())
        };
        self.put(Step::Logic { join: Join::Start, value }, vec![]);
        if self.tape.percent(40) {
            let value = self.logic(&mut Vec::new());
            self.put(Step::Logic { join: Join::And, value }, vec![]);
        }
        for _ in 0..1 + self.tape.below(2) {
            let mut shared = Vec::new();
            let fires = match self.tape.below(3) {
                0 => Logic::All(vec![Logic::Condition, self.logic(&mut shared)]),
                _ => Logic::Condition,
            };
            let effects = (0..self.tape.below(4)).map(|_| self.effect(&mut shared)).collect();
            self.put(Step::Act { fires }, effects);
        }
    }
}

fn instruction(at: usize, step: Step, effects: Vec<Effect>) -> Instruction {
    let place = Location { file: 0, line: at as u32 + 1, step: None };
    let (text, operands) = (format!("{at}").into(), [].into());
    Instruction { place, block: 0, text, operands, timing: None, effects, step }
}

fn generate(tape: &mut Tape<'_>) -> Program {
    let area = |name: &str, kind| Area::new(name, kind, Radix::Decimal);
    let areas = vec![area("M", AreaKind::Bit), area("D", AreaKind::Word)];
    let mut g = Generator { tape, program: Program { areas, ..Program::default() } };
    for _ in 0..1 + g.tape.below(4) {
        if g.tape.percent(25) {
            let count = WordSource::Const(2);
            let begin = g.put(Step::ForBegin { count, least: 0, most: 2, end: 0 }, vec![]);
            g.rung();
            let at = g.put(Step::ForEnd, vec![]);
            if let Step::ForBegin { end, .. } = &mut g.program.instructions[begin].step {
                *end = at;
            }
        }
        g.rung();
    }
    // What is left costs more or less.
    for cell in 0..LED_TO {
        let value = g.against(WordSource::Cell(word(cell)));
        g.put(Step::Logic { join: Join::Start, value }, vec![]);
        g.put(Step::Act { fires: Logic::Condition }, vec![]);
    }
    g.program.mains.push(0..g.program.instructions.len());
    g.program
}

/// Start values; what else is asked is not known.
struct Start([u16; 6]);

impl FreeValues for Start {
    fn start(&mut self, cell: Cell, kind: AreaKind) -> u16 {
        let first = if kind == AreaKind::Bit { 4 } else { 0 };
        self.0[first + cell.index as usize]
    }

    fn choice(&mut self, _: &ChoiceKey, _: AreaKind) -> u16 {
        0
    }
}

/// All starts.
fn starts() -> impl Iterator<Item = [u16; 6]> {
    (0..81 * 4).map(|n: usize| {
        let value = |place: u32| VALUES[n / 4 / 3usize.pow(place) % 3];
        [value(0), value(1), value(2), value(3), n as u16 & 1, n as u16 >> 1 & 1]
    })
}

fn check(tape: &[u16], reached: &Shared<u32>) -> Result<(), String> {
    let mut tape = Tape::new(tape);
    let program = generate(&mut tape);
    let times = times(&mut tape, program.instructions.len());
    let told = |why: String| {
        let line =
            |(one, times): (&Instruction, _)| format!("{:?} {:?} {times:?}", one.step, one.effects);
        let lines: Vec<String> = program.instructions.iter().zip(&times).map(line).collect();
        format!("{why}\n{}\n{:?}", lines.join("\n"), program.kinds)
    };
    let found = bound(&program, &times, Method::Auto).map_err(|why| told(why.to_string()))?;
    let mut most = 0;
    for start in starts() {
        let run = real(&program, &times, || Start(start), 1_000);
        if run.replay.total > found.upper {
            let (upper, total) = (found.upper, run.replay.total);
            return Err(told(format!("{start:?} takes {total:?}, the bound is {upper:?}")));
        }
        most = most.max(run.replay.total.0);
    }
    reached.set(reached.get() + u32::from(most == found.upper.0));
    Ok(())
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn no_start_leads_an_index_beyond_the_bound() {
    let reached = Shared::new(0);
    on_tapes(cases(80), 80, |tape| check(tape, &reached));
    println!("{} of {} bounds reached", reached.get(), cases(80_u32));
    assert!(reached.get() * 3 > cases(80), "{} reached", reached.get());
}

/// The last iteration's result is no result where the loop may end before it.
#[test]
fn a_loop_that_may_end_earlier_leaves_no_result() {
    let leaves = |least: u32| {
        let area = |name: &str, kind| Area::new(name, kind, Radix::Decimal);
        let count = WordSource::Cell(word(0));
        let value = Logic::cell(bit(0));
        let steps = [
            Step::ForBegin { count, least, most: 2, end: 2 },
            Step::Logic { join: Join::Start, value },
            Step::ForEnd,
            Step::Act { fires: Logic::Condition },
        ];
        let instructions: Vec<Instruction> =
            steps.into_iter().zip(0..).map(|(step, at)| instruction(at, step, vec![])).collect();
        let program = Program {
            areas: vec![area("M", AreaKind::Bit), area("D", AreaKind::Word)],
            mains: std::iter::once(0..4).collect(),
            instructions,
            ..Program::default()
        };
        scan_model(&program, &times(&mut Tape::new(&[]), 4)).is_ok()
    };
    assert!(leaves(2) && !leaves(0) && !leaves(1));
}

/// One instruction reads a choice where its condition holds, and then wherever control is: the index is known in the
/// first place alone.
#[test]
fn what_is_read_again_where_less_is_known_is_worked_out_again() {
    let area = |name: &str, kind| Area::new(name, kind, Radix::Decimal);
    let words = |source| Number::Words(vec![source]);
    let index = WordSource::Cell(word(INDEX));
    let is = |cell, value| {
        let (left, right) = (words(WordSource::Cell(word(cell))), words(WordSource::Const(value)));
        let (relation, format) = (Relation::Equal, NumberFormat::Signed);
        Logic::Compare(Box::new(Compare { relation, format, left, right }))
    };
    let start = |value| Step::Logic { join: Join::Start, value };
    let write = |when, to, source| Effect {
        when,
        write: Write::Words(vec![WordTarget::Cell(word(to))], words(source)),
    };
    let act = || Step::Act { fires: Logic::Condition };
    let address = Address::within(word(0), LED_TO, 0, vec![Term::signed(index)]);
    let run = OperationInput::Run(address, Shape::Cells, Count::Exactly(1));
    let choice = WordSource::Free(ChoiceId(0));
    let known = vec![
        write(When::Always, 0, WordSource::Const(2)),
        write(When::Always, 1, WordSource::Const(0)),
        write(When::Always, INDEX, WordSource::Const(0)),
    ];
    let twice = vec![write(When::Fired, 5, choice), write(When::Always, 2, choice)];
    let instructions = vec![
        instruction(0, start(Logic::Const(true)), known),
        instruction(1, start(Logic::cell(bit(0))), vec![]),
        instruction(2, act(), vec![write(When::Fired, INDEX, WordSource::Const(1))]),
        instruction(3, start(is(INDEX, 1)), vec![]),
        instruction(4, act(), twice),
        instruction(5, start(is(2, 2)), vec![]),
        instruction(6, act(), vec![]),
    ];
    let program = Program {
        areas: vec![area("M", AreaKind::Bit), area("D", AreaKind::Word)],
        mains: std::iter::once(0..7).collect(),
        instructions,
        choices: 1,
        kinds: [(ChoiceId(0), ChoiceKind::Exact(Box::new(Meaning::of(run))))].into(),
        ..Program::default()
    };
    let mut times = vec![Times::default(); 7];
    times[6].on = Picos(100);
    let found = bound(&program, &times, Method::Auto).expect("a bound");
    assert_eq!((found.upper, found.lower), (Picos(100), Picos(100)));
}

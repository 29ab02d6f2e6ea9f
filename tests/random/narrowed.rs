//! What words are found to hold takes nothing away from any scan: random programs, with no dialect in front, are run as
//! they were and as the pass left them, which lowered what they count, how often they repeat and where their indices
//! write. Each scan must count as much, repeat as often and write as far.

use common::ir::{Taste, bit, generate, word};
use common::tape::{Tape, cases, on_tapes};
use scanbound::base::location::Location;
use scanbound::base::time::{Picos, Times};
use scanbound::passes::values::{self, Trust};
use scanbound::passes::{Settings, interrupts};
use scanbound::program::meaning::{
    Address, ChoiceKind, Count, Meaning, Operation, OperationInput, Shape, Target, Term, Unary,
};
use scanbound::program::{
    AreaId, AreaKind, BitTarget, Cell, ChoiceId, ChoiceKey, Effect, IndexedWrite, Instruction,
    Join, Length, Logic, Number, Program, Region, StartRange, Step, Units, When, WordSource,
    WordTarget, Write,
};
use scanbound::replay::emulated::Emulated;
use scanbound::replay::{FreeValues, real};
use std::cell::Cell as Shared;

/// So many words are used.
const WORDS: u32 = 6;
const BITS: u32 = 6;
/// A run is followed no further.
const MAX_EXECUTED: u64 = 20_000;

const TASTE: Taste =
    Taste { words: true, arithmetic: true, reals: false, choices: false, control: true, items: 7 };

/// Adds to a random program what it does not have: operations, indices, longer loops, words that are known.
struct Additions<'t, 'a> {
    tape: &'t mut Tape<'a>,
    program: Program,
}

impl Additions<'_, '_> {
    fn choice(&mut self, kind: Option<ChoiceKind>) -> ChoiceId {
        let choice = ChoiceId(self.program.choices);
        self.program.choices += 1;
        self.program.kinds.extend(kind.map(|kind| (choice, kind)));
        choice
    }

    fn exactly(&mut self, meaning: Meaning) -> ChoiceId {
        self.choice(Some(ChoiceKind::Exact(Box::new(meaning))))
    }

    fn cell(&mut self) -> Cell {
        word(self.tape.below(WORDS as usize) as u32)
    }

    fn source(&mut self) -> WordSource {
        match self.tape.below(4) {
            0 => WordSource::Const(self.tape.pick(&[1, 0, 2, 3, 7, 20, 0xFFFF, 0x8000])),
            _ => WordSource::Cell(self.cell()),
        }
    }

    fn words(&mut self, most: usize) -> OperationInput {
        let count = 1 + self.tape.below(most);
        OperationInput::Words((0..count).map(|_| self.source()).collect())
    }

    fn constant(&mut self, of: &[u16]) -> OperationInput {
        OperationInput::Words(vec![WordSource::Const(self.tape.pick(of))])
    }

    fn address(&mut self) -> Address {
        let mut terms = vec![Term::signed(WordSource::Cell(self.cell()))];
        if self.tape.percent(20) {
            let second = Term::unsigned(self.source());
            terms.push(Term { factor: self.tape.pick(&[1, 2, -1]), ..second });
        }
        Address::within(word(0), 64, self.tape.pick(&[0, 1, 2]), terms)
    }

    /// An operation with its inputs, and how many words each of its results has.
    fn operation(&mut self) -> (Operation, Vec<OperationInput>, Vec<usize>) {
        match self.tape.below(14) {
            0 => {
                let (a, b) = (self.words(1), self.words(1));
                (Operation::Multiply { signed: true }, vec![a, b], vec![2])
            }
            1 | 2 => {
                let by = if self.tape.percent(70) {
                    self.constant(&[2, 3, 1, 7])
                } else {
                    self.words(1)
                };
                (Operation::Divide { signed: true }, vec![self.words(1), by], vec![1, 1])
            }
            3 => {
                let count = self.tape.pick(&[1, 2]);
                (Operation::Resize(count), vec![self.words(2)], vec![count.into()])
            }
            4 | 5 => {
                let (left, signed) = (self.tape.percent(50), self.tape.percent(50));
                let places = self.constant(&[1, 2, 3, 15]);
                (Operation::Shift { left, signed }, vec![self.words(1), places], vec![1, 1])
            }
            6 => (Operation::PickBit, vec![self.words(1), self.words(1)], vec![1]),
            7 => (Operation::CountBits(1), vec![self.words(2)], vec![1]),
            8 => {
                let list = (0..3).map(|_| self.source()).collect();
                let inputs = vec![self.words(1), OperationInput::Words(list)];
                (Operation::Find { halving: false }, inputs, vec![2])
            }
            9 => {
                let (low, high) = (self.constant(&[0, 1, 0xFFFE]), self.constant(&[3, 9, 40]));
                (Operation::Limit, vec![low, high, self.words(1)], vec![1])
            }
            10 => (Operation::Each(Unary::Negate), vec![self.words(1)], vec![1]),
            11 => (Operation::Each(Unary::ToBcd), vec![self.words(1)], vec![1]),
            12 => {
                let product = Box::new(Operation::Multiply { signed: true });
                let inputs = vec![self.words(1), self.words(1)];
                (Operation::WithFlags { operation: product, words: 1 }, inputs, vec![2])
            }
            _ => {
                let run = OperationInput::Run(self.address(), Shape::Cells, Count::Exactly(1));
                (Operation::Copy, vec![run], vec![1])
            }
        }
    }

    /// The first word that an operation gives, a timer's present value, or what the outside says.
    fn result(&mut self) -> WordSource {
        let kind = match self.tape.below(8) {
            0 => ChoiceKind::External,
            1 => {
                let contact = bit(self.tape.below(BITS as usize) as u32);
                ChoiceKind::PresentValue { contact, setting: self.tape.pick(&[5, 1, 30]) }
            }
            _ => {
                let (operation, inputs, _) = self.operation();
                ChoiceKind::Exact(Box::new(Meaning { operation, inputs, outputs: Vec::new() }))
            }
        };
        WordSource::Free(self.choice(Some(kind)))
    }

    /// What the outside writes.
    fn outside(&mut self, when: When) -> Effect {
        let region = match self.tape.below(3) {
            0 => Region::Range { first: bit(self.tape.below(4) as u32), count: 2 },
            1 => Region::Area(AreaId(self.tape.below(2) as u16)),
            _ => Region::Range { first: word(self.tape.below(4) as u32), count: 2 },
        };
        Effect { when, write: Write::Havoc(region, self.choice(Some(ChoiceKind::External))) }
    }

    /// What adds to a word.
    fn counts(&mut self, when: When) -> Effect {
        let cell = self.cell();
        let by = WordSource::Const(self.tape.pick(&[1, 2, 5, 0xFFFF]));
        let [from, by] =
            [WordSource::Cell(cell), by].map(|word| Box::new(Number::Words(vec![word])));
        Effect { when, write: Write::Words(vec![WordTarget::Cell(cell)], Number::Add(from, by)) }
    }

    /// What writes an operation's results.
    fn operated(&mut self, when: When, effects: &mut Vec<Effect>) {
        let (operation, inputs, lengths) = self.operation();
        let mut outputs = Vec::new();
        let mut regions = Vec::new();
        for length in lengths {
            let first = self.tape.below(WORDS as usize + 1 - length) as u32;
            let targets = (0..length as u32).map(|n| WordTarget::Cell(word(first + n)));
            if self.tape.percent(20) {
                outputs.push(Target::Nowhere);
                continue;
            }
            outputs.push(Target::Words(targets.collect()));
            regions.push(Region::Range { first: word(first), count: length as u32 });
        }
        if matches!(operation, Operation::WithFlags { .. }) {
            for _ in 0..2 {
                let to = bit(self.tape.below(BITS as usize) as u32);
                outputs.push(Target::Bits(vec![BitTarget::Cell(to)]));
                regions.push(Region::Range { first: to, count: 1 });
            }
        }
        let choice = self.exactly(Meaning { operation, inputs, outputs });
        let effect = |region| Effect { when, write: Write::Havoc(region, choice) };
        effects.extend(regions.into_iter().map(effect));
    }

    /// What writes by an index.
    fn indexed(&mut self, when: When) -> Effect {
        let (index, base) = (self.cell(), self.tape.pick(&[0, 1, 3]));
        let length = 1 + self.tape.below(2) as u32;
        let address =
            Address::within(word(0), 64, base, vec![Term::signed(WordSource::Cell(index))]);
        let input = OperationInput::Words((0..length).map(|_| self.source()).collect());
        let outputs = vec![Target::Run(address, Shape::Cells)];
        let meaning = Meaning { operation: Operation::Copy, inputs: vec![input], outputs };
        let choice = self.exactly(meaning);
        let indexed = IndexedWrite {
            first: word(base as u32),
            indices: vec![vec![WordSource::Cell(index)]],
            length: Length::Exactly(length),
            stated: None,
            proved: Vec::new(),
        };
        self.program.indexed.insert(choice, indexed);
        Effect { when, write: Write::Havoc(Region::Area(AreaId(1)), choice) }
    }

    /// A rung of its own, before all others or behind them.
    fn main(&mut self, place: usize) {
        let from = self.program.instructions.len();
        let mut effects = Vec::new();
        for cell in (0..WORDS).map(word) {
            let number = match self.tape.below(5) {
                0 => Number::Words(vec![WordSource::Const(self.tape.below(40) as u16)]),
                1 | 2 => {
                    let mask = WordSource::Const(self.tape.pick(&[3, 1, 7, 12, 15]));
                    let from = WordSource::Cell(self.cell());
                    let [from, mask] = [from, mask].map(|word| Box::new(Number::Words(vec![word])));
                    Number::And(from, mask)
                }
                _ => continue,
            };
            let write = Write::Words(vec![WordTarget::Cell(cell)], number);
            effects.push(Effect { when: When::Fired, write });
        }
        let start = Step::Logic { join: Join::Start, value: Logic::Const(true) };
        for (step, effects) in [(start, vec![]), (Step::Act { fires: Logic::Condition }, effects)] {
            let at = self.program.instructions.len();
            let place = Location { file: 0, line: at as u32 + 1, step: None };
            self.program.instructions.push(Instruction {
                place,
                block: 0,
                text: format!("{at}").into(),
                operands: [].into(),
                timing: None,
                effects,
                step,
            });
        }
        self.program.mains.insert(place, from..self.program.instructions.len());
    }

    fn all(&mut self, iterations: bool) {
        for at in 0..self.program.instructions.len() {
            let mut effects = std::mem::take(&mut self.program.instructions[at].effects);
            if matches!(self.program.instructions[at].step, Step::Act { .. }) {
                let when = self.tape.pick(&[When::Fired, When::Fired, When::Always]);
                match self.tape.below(9) {
                    0 | 1 => self.operated(when, &mut effects),
                    2 => effects.push(self.indexed(when)),
                    3 => effects.push(self.outside(when)),
                    4 | 5 => effects.push(self.counts(when)),
                    _ => {}
                }
            }
            self.program.instructions[at].effects = effects;
            let other = if self.tape.percent(20) { Some(self.result()) } else { None };
            let timing = self.program.instructions[at].timing.as_mut();
            if let Some(Units::Counted(counted)) = timing.map(|timing| &mut timing.units) {
                // Only what the pass finds lowers it.
                (counted.most, counted.executes_up_to) = (u32::MAX.into(), u32::MAX.into());
                counted.words = other.map_or_else(|| counted.words.clone(), |word| vec![word]);
            }
            if let Step::ForBegin { least, most, .. } = self.program.instructions[at].step {
                let (least, most) = match self.tape.below(8) {
                    0..=2 => (0, 9),
                    3 if iterations => (0, 3000),
                    _ => (least, most),
                };
                let from = self.source();
                let kind = match self.tape.below(6) {
                    0 if iterations => Some(ChoiceKind::Iterations(from)),
                    1 => Some(ChoiceKind::UnsignedIterations(from)),
                    _ => None,
                };
                let other = kind.map(|kind| WordSource::Free(self.choice(Some(kind))));
                if let Step::ForBegin { count, least: l, most: m, .. } =
                    &mut self.program.instructions[at].step
                {
                    (*l, *m) = (least, most);
                    *count = other.unwrap_or(*count);
                }
            }
        }
        if self.tape.percent(70) {
            self.main(0);
        }
    }
}

/// A program, and what its instructions take: each more with every unit and every iteration.
fn program(tape: &mut Tape<'_>, iterations: bool) -> (Program, Vec<Times>) {
    let (mut program, _) = generate(tape, TASTE);
    program.stated_ranges.retain(|range| range.cells.len() == 1);
    if tape.percent(30) {
        program.stated_ranges =
            vec![StartRange { cells: vec![word(0)], low: 0, high: 5, values: Vec::new() }];
    }
    let mut additions = Additions { tape, program };
    additions.all(iterations);
    let mut program = additions.program;
    (interrupts::PASS.run)(&mut program, &Settings::default()).expect("no fault");
    let times = Times { per_unit: Picos(1), ..Times::new(Picos(1_000_000), Picos(900_000)) };
    let times = vec![times; program.instructions.len()];
    (program, times)
}

/// The same as the pass leaves it.
fn narrowed(program: &Program, trust: Trust) -> Program {
    let mut narrowed = program.clone();
    (values::PASS.run)(&mut narrowed, &Settings { trust, budget: None }).expect("no fault");
    narrowed
}

fn told(program: &Program) -> String {
    let line = |(at, one): (usize, &Instruction)| {
        let counted = one.counted().map(|counted| (&counted.words, counted.most));
        format!("{at}: {:?} {:?} {counted:?}", one.step, one.effects)
    };
    let lines: Vec<String> = program.instructions.iter().enumerate().map(line).collect();
    format!(
        "{}\nmains {:?}\nkinds {:?}\nranges {:?}\ntrusted {:?}",
        lines.join("\n"),
        program.mains,
        program.kinds,
        program.stated_ranges,
        program.trusted_ranges
    )
}

/// What stands in memory by chance: numbers of every size, small ones above all.
#[derive(Clone, Copy)]
struct Start(u64);

impl Start {
    fn number(self, of: u64) -> u64 {
        // splitmix64
        let mut z = self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) ^ of;
        z = z.wrapping_add(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn word(self, of: u64) -> u16 {
        let z = self.number(of);
        let few = [0, 1, 2, 3, 0x7FFF, 0x8000, 0xFFFF, 4];
        match z % 8 {
            0 => (z >> 8) as u16,
            1..=3 => (z >> 8) as u16 % 12,
            _ => few[(z >> 8) as usize % few.len()],
        }
    }
}

impl FreeValues for Start {
    fn start(&mut self, cell: Cell, kind: AreaKind) -> u16 {
        let of = u64::from(cell.area.0) << 32 | u64::from(cell.index);
        if kind == AreaKind::Bit { self.number(of) as u16 >> 3 & 1 } else { self.word(of) }
    }

    fn choice(&mut self, key: &ChoiceKey, kind: AreaKind) -> u16 {
        let frames =
            key.frames.iter().map(|frame| (frame.at as u64) << 8 | u64::from(frame.iteration));
        let cell =
            key.cell.map_or(0, |cell| 1 + u64::from(cell.area.0) + 4 * u64::from(cell.index));
        let asked = frames.chain([u64::from(key.choice.0), cell]);
        let of = asked.fold(7, |of, more| self.number(of).wrapping_add(more));
        if kind == AreaKind::Bit { self.number(of) as u16 >> 3 & 1 } else { self.word(of) }
    }
}

/// How many programs there were, and in how many the pass found something.
#[derive(Default)]
struct Tally {
    programs: Shared<u32>,
    narrowed: Shared<u32>,
    trusted: Shared<u32>,
}

impl Tally {
    fn add(&self, before: &Program, after: &Program) {
        self.programs.set(self.programs.get() + 1);
        let closer = before.instructions != after.instructions;
        self.narrowed.set(self.narrowed.get() + u32::from(closer));
        self.trusted.set(self.trusted.get() + u32::from(!after.trusted_ranges.is_empty()));
    }
}

fn within(tape: &[u16], tally: &Tally) -> Result<(), String> {
    let (before, times) = program(&mut Tape::new(tape), true);
    let after = narrowed(&before, Trust::None);
    tally.add(&before, &after);
    for seed in 0..30 {
        let full = real(&before, &times, || Start(seed), MAX_EXECUTED);
        if !full.is_possible() {
            continue;
        }
        let less = real(&after, &times, || Start(seed), MAX_EXECUTED);
        // Where less is lost to an index more is known, and costs more.
        if less.replay.total < full.replay.total || !less.undeclared_writes.is_empty() {
            return Err(format!(
                "start {seed}: {:?}, narrowed {:?}, beyond {:?}\n{}\nbefore: {}",
                full.replay.total,
                less.replay.total,
                less.undeclared_writes,
                told(&after),
                told(&before)
            ));
        }
    }
    Ok(())
}

fn across(tape: &[u16], tally: &Tally) -> Result<(), String> {
    let mut tape = Tape::new(tape);
    let trust = tape.pick(&[Trust::Counts, Trust::Counts, Trust::All]);
    let (mut before, _) = program(&mut tape, false);
    let mut additions = Additions { tape: &mut tape, program: before };
    additions.main(additions.program.mains.len());
    before = additions.program;
    before.power_up.cleared = vec![Region::Area(AreaId(0)), Region::Area(AreaId(1))];
    let times = Times { per_unit: Picos(1), ..Times::new(Picos(1_000_000), Picos(900_000)) };
    let times = vec![times; before.instructions.len()];
    let after = narrowed(&before, trust);
    tally.add(&before, &after);
    let mut cpus = [Emulated::new(&before, &times), Emulated::new(&after, &times)];
    for scan in 0..60 {
        if scan % 20 == 0 {
            cpus = [Emulated::new(&before, &times), Emulated::new(&after, &times)];
        }
        let others = Start(scan);
        for cell in (0..WORDS).map(word) {
            let stated = before.stated_ranges.iter().find(|range| range.cells == [cell]);
            let trusted = after.trusted_ranges.iter().any(|one| one.cell == cell);
            let value = cpus[0].value(cell);
            let holds = |value: u16| {
                let value = i64::from(value.cast_signed());
                stated.is_none_or(|range| (range.low..=range.high).contains(&value))
            };
            let drawn = others.word(cell.index.into());
            let chosen = match stated {
                Some(range) => (range.low + i64::from(drawn) % (range.high - range.low + 1)) as u16,
                None => drawn,
            };
            let stays = trusted || others.number(100 + u64::from(cell.index)).is_multiple_of(3);
            if !stays || !trusted && !holds(value) {
                cpus.iter_mut().for_each(|cpu| cpu.set(cell, chosen));
            } else if !holds(value) {
                // No scan starts so.
                return Ok(());
            }
        }
        for cell in (0..BITS).map(bit) {
            let on = others.number(200 + u64::from(cell.index)) as u16 & 1;
            cpus.iter_mut().for_each(|cpu| cpu.set(cell, on));
        }
        let [full, less] = cpus.each_mut().map(|cpu| cpu.scan(MAX_EXECUTED));
        let lost = |one: &&scanbound::program::TrustedRange| {
            let value = i64::from(cpus[0].value(one.cell).cast_signed());
            full.stopped.is_none() && !(one.low..=one.high).contains(&value)
        };
        let broken = after.trusted_ranges.iter().find(lost);
        if less.total < full.total || broken.is_some() {
            return Err(format!(
                "scan {scan}: {:?}, narrowed {:?}, {broken:?}\n{}",
                full.total,
                less.total,
                told(&after)
            ));
        }
        if full.stopped.is_some() || less.stopped.is_some() {
            break;
        }
    }
    Ok(())
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn no_scan_counts_repeats_or_writes_less_than_it_did() {
    let tally = Tally::default();
    on_tapes(cases(2000), 400, |tape| within(tape, &tally));
    let (programs, narrowed) = (tally.programs.get(), tally.narrowed.get());
    println!("{narrowed} of {programs} narrowed");
    assert!(narrowed * 3 > programs, "{narrowed} of {programs}");
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn no_scan_from_power_up_counts_repeats_or_writes_less_than_it_did() {
    let tally = Tally::default();
    on_tapes(cases(1000), 400, |tape| across(tape, &tally));
    let (programs, trusted) = (tally.programs.get(), tally.trusted.get());
    println!("{trusted} of {programs} with trusted words");
    assert!(trusted * 20 > programs, "{trusted} of {programs}");
}

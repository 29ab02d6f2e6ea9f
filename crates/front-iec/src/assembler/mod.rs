//! What both ways of lowering share: instructions, choices, values between instructions and what is resolved behind the
//! last instruction. It knows neither names nor variables.

pub(crate) mod arithmetic;
pub(crate) mod block;
pub(crate) mod charges;
pub(crate) mod competing;
pub(crate) mod control;
pub(crate) mod convert;
pub(crate) mod counted;
pub(crate) mod differs;
pub(crate) mod invariant;
pub(crate) mod loops;
pub(crate) mod memory;
pub(crate) mod mixed;
pub(crate) mod numbers;
pub(crate) mod open;
pub(crate) mod results;
pub(crate) mod selected;
pub(crate) mod step_time;
pub(crate) mod tally;
pub(crate) mod time_range;
pub(crate) mod timer;
pub(crate) mod turns;
pub(crate) mod types;
pub(crate) mod value;
pub(crate) mod whole;

use scanbound_base::location::Location;
use scanbound_front::builder::{Builder, always};
use scanbound_iec::fault::Fault;
use scanbound_ir::errors::is_zero;
use scanbound_ir::meaning::{Arithmetic, Meaning, Operation, OperationInput as Input, Target};
use scanbound_ir::{
    AccessedDevices, AreaId, BitTarget, Cell, Logic, Number, Program, Region, Step, Tag, TimingKey,
    Units, WordSource, WordTarget, Write,
};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use tally::Tally;
use types::Kind;
use value::{sources, targets};

/// The areas of variables, of what charts remember, and of values between.
pub(crate) const VARIABLES: [AreaId; 2] = [AreaId(0), AreaId(1)];
pub(crate) const HIDDEN: [AreaId; 2] = [AreaId(2), AreaId(3)];
pub(crate) const BETWEEN: [AreaId; 2] = [AreaId(4), AreaId(5)];

/// What is carried out in one of several rounds.
pub(crate) struct Turn {
    /// For each round, the instruction that says whether it is carried out in it.
    pub(crate) says: Vec<usize>,
    /// For each round, the instructions that carry it out.
    pub(crate) copies: Vec<std::ops::Range<usize>>,
}

/// Something that makes no difference if the rest of the program is as it mostly is.
pub(crate) enum OpenEnd {
    /// The instruction writes a bit that is false if a timer's preset, these two words, never changes.
    Preset { at: usize, preset: Cell },
    /// The instruction writes a bit that is false if nothing but these instructions writes a variable.
    Variable { at: usize, cell: Cell, own: Vec<usize> },
    /// In which of several orders these have their turns, if none of them writes what another one reads or writes.
    Turns(Vec<Turn>),
    /// These instructions tell how long a step is active, which need not be told if nobody asks for it.
    StepTime { cell: Cell, own: Vec<usize> },
}

/// Instructions while they are put together.
pub(crate) struct Assembler {
    pub(crate) builder: Builder,
    /// The file of the code that is lowered.
    pub(crate) file: usize,
    /// Faults and their files.
    pub(crate) faults: Vec<(usize, Fault)>,
    /// Those of `faults` that lowering has found, to take note of each once.
    noted_faults: HashSet<(usize, Fault)>,
    pub(crate) tally: Tally,
    /// What the user states of the controller: whether it was asked for, and whether it does something in another way
    /// than the standard has it.
    pub(crate) stated_readings: BTreeMap<String, (bool, bool)>,
    pub(crate) open_ends: Vec<OpenEnd>,
    /// The presets of timers that are called without one.
    pub(crate) presets_left: BTreeSet<Cell>,
    /// The times of steps that are asked for.
    pub(crate) times_read: BTreeSet<Cell>,
    /// What counters stand at, and where they are through, as far as it is asked for.
    pub(crate) counts: BTreeSet<Cell>,
    between: [u32; 2],
    /// Whether the controller stops at a division by zero and the like.
    pub(crate) stops_on_error: bool,
}

impl Assembler {
    pub(crate) fn new(program: Program) -> Assembler {
        Assembler {
            builder: Builder::new(program),
            file: 0,
            faults: Vec::new(),
            noted_faults: HashSet::new(),
            tally: Tally::default(),
            stated_readings: BTreeMap::new(),
            open_ends: Vec::new(),
            presets_left: BTreeSet::new(),
            times_read: BTreeSet::new(),
            counts: BTreeSet::new(),
            between: [0, 0],
            stops_on_error: true,
        }
    }

    /// Takes note of a fault in the code that is lowered.
    pub(crate) fn fault(&mut self, fault: Fault) {
        let fault = (self.file, fault);
        if self.noted_faults.insert(fault.clone()) {
            self.faults.push(fault);
        }
    }

    /// What is done for something that is charged as a whole.
    pub(crate) fn charged_already<T>(&mut self, work: impl FnOnce(&mut Assembler) -> T) -> T {
        let from = self.builder.next();
        let found = work(self);
        self.charge_nothing(from);
        found
    }

    /// Takes the charges away from what was added since then.
    pub(crate) fn charge_nothing(&mut self, from: usize) {
        for instruction in &mut self.builder.program.instructions[from..] {
            instruction.timing = None;
        }
    }

    pub(crate) fn program(&mut self) -> &mut Program {
        &mut self.builder.program
    }

    /// Memory of a chart.
    pub(crate) fn hidden(&mut self, name: &str, of: scanbound_ir::Type) -> Option<Tag> {
        self.program().tags.add(HIDDEN, name, of)
    }

    /// What is added from here on stands at this line of a unit's file.
    pub(crate) fn at(&mut self, line: u32, text: &str) {
        let file = u32::try_from(self.file).unwrap_or(u32::MAX);
        let text: String = text.chars().take(120).collect();
        self.builder.at(Location { file, line, step: None }, text.into(), [].into());
        self.program().blocks += 1;
    }

    /// How something is priced: by its rows' names, the most specific first, else by its class.
    pub(crate) fn key(names: &[&str], class: &'static str) -> TimingKey {
        TimingKey {
            names: names.iter().map(|name| (*name).to_owned()).collect(),
            class,
            units: Units::None,
            use_larger_time: false,
            optional: false,
            accessed: AccessedDevices::default(),
        }
    }

    /// The price of a jump.
    pub(crate) fn jump_key() -> Option<TimingKey> {
        Some(Self::key(&["JMP"], "jump"))
    }

    /// Charges something that changes nothing by itself.
    pub(crate) fn cost(&mut self, names: &[&str], class: &'static str) {
        self.builder.add(Some(Self::key(names, class)), Vec::new(), Step::Nothing);
    }

    /// Writes, without a charge.
    pub(crate) fn write(&mut self, writes: Vec<Write>) -> usize {
        self.builder.add(None, writes.into_iter().map(always).collect(), Step::Nothing)
    }

    /// Writes where a condition holds; charged, if a row is named.
    pub(crate) fn write_if(
        &mut self,
        fires: Logic,
        writes: Vec<Write>,
        key: Option<TimingKey>,
    ) -> usize {
        let effects = writes.into_iter().map(scanbound_front::builder::fired).collect();
        self.builder.add(key, effects, Step::Act { fires })
    }

    /// Whether a cell is for values between.
    pub(crate) fn is_between(cell: Cell) -> bool {
        BETWEEN.contains(&cell.area)
    }

    /// Whether a cell is a bit.
    pub(crate) fn is_bit(cell: Cell) -> bool {
        [VARIABLES[0], HIDDEN[0], BETWEEN[0]].contains(&cell.area)
    }

    /// A bit for a value between.
    pub(crate) fn bit_between(&mut self) -> Cell {
        self.between[0] += 1;
        Cell { area: BETWEEN[0], index: self.between[0] - 1 }
    }

    /// Words for a value between; the first.
    pub(crate) fn words_between(&mut self, words: u32) -> Cell {
        self.between[1] += words;
        Cell { area: BETWEEN[1], index: self.between[1] - words }
    }

    /// The words of a number, kept between if they have to be.
    pub(crate) fn words(&mut self, number: Number, words: u32) -> Vec<WordSource> {
        match number {
            Number::Words(words) => words,
            number => self.copied(number, words),
        }
    }

    /// The words of a number as they are now.
    pub(crate) fn copied(&mut self, number: Number, words: u32) -> Vec<WordSource> {
        let first = self.words_between(words);
        self.write(vec![Write::Words(targets(first, words), number)]);
        sources(first, words)
    }

    /// A bit kept as it is now.
    pub(crate) fn keep_bit(&mut self, value: Logic) -> Logic {
        if matches!(value, Logic::Const(_)) {
            return value;
        }
        let cell = self.bit_between();
        self.write(vec![Write::Bit(BitTarget::Cell(cell), value)]);
        Logic::cell(cell)
    }

    /// A number that an operation gives, in so many words; any value, where it has no meaning.
    pub(crate) fn worked_out(
        &mut self,
        words: u32,
        meaning: Option<(Operation, Vec<Input>, u32)>,
    ) -> Number {
        let first = self.words_between(words);
        let choice = self.builder.choice();
        let mut error = None;
        if let Some((operation, inputs, wide)) = meaning {
            // What the operation gives beyond the words that are asked for is lost.
            let target = |at| match at < words {
                true => WordTarget::Cell(first.plus(at)),
                false => WordTarget::Discard,
            };
            let outputs = vec![Target::Words((0..wide).map(target).collect())];
            let meaning = Meaning { operation, inputs, outputs };
            error = self.error_of(&meaning);
            self.builder.define_followed(choice, meaning);
        }
        let at = self.write(vec![Write::Havoc(Region::Range { first, count: words }, choice)]);
        self.program().errors.extend(error.map(|error| (at, error)));
        Number::Words(sources(first, words))
    }

    /// When a controller stops where it works something out: at a divisor of zero, and at an element that is not there.
    fn error_of(&self, meaning: &Meaning) -> Option<Logic> {
        let divisor = match (&meaning.operation, &meaning.inputs[..]) {
            (Operation::Real(Arithmetic::Divide), [_, Input::Number(divisor)]) => {
                let size = [u16::MAX, 0x7FFF].map(WordSource::Const).to_vec();
                let size = Box::new(Number::Words(size));
                Some(is_zero(&Number::And(Box::new(divisor.clone()), size)))
            }
            (Operation::DivideJoined { .. } | Operation::Copy, _) => meaning.operand_error(),
            _ => None,
        };
        divisor.filter(|_| self.stops_on_error)
    }

    /// Notes that the controller stops here where this holds.
    pub(crate) fn stops_where(&mut self, error: Logic) {
        if self.stops_on_error {
            self.not_followed_where(error);
        }
    }

    /// Notes that no run is followed from here on where this holds: memory may be destroyed, if the controller goes on.
    pub(crate) fn not_followed_where(&mut self, error: Logic) {
        let at = self.builder.add(None, Vec::new(), Step::Nothing);
        self.program().errors.insert(at, error);
    }

    /// Any number, and why.
    pub(crate) fn any_number(&mut self, kind: Kind, why: &str) -> Number {
        let number = self.worked_out(kind.words(), None);
        let at = self.builder.next() - 1;
        self.program().approximate(at, why);
        number
    }

    /// Any bit, and why.
    pub(crate) fn any_bit(&mut self, why: &str) -> Logic {
        let bit = self.builder.free_bit();
        let kept = self.keep_bit(bit);
        let at = self.builder.next() - 1;
        self.program().approximate(at, why);
        kept
    }

    /// A bit that is on where a controller may do what has no effect but its time.
    pub(crate) fn extra_time(&mut self) -> Logic {
        let choice = self.builder.choice();
        self.program().kinds.insert(choice, scanbound_ir::ChoiceKind::ExtraTime);
        self.keep_bit(Logic::Bit(scanbound_ir::BitSource::Free(choice)))
    }

    /// A bit of how much time has passed, which a run from power-up does not count.
    pub(crate) fn uncounted_bit(&mut self) -> Logic {
        let choice = self.builder.external_choice();
        self.builder.program.timekeeping.untracked.insert(choice);
        Logic::Bit(scanbound_ir::BitSource::Free(choice))
    }

    /// A bit that the outside gives.
    pub(crate) fn world_bit(&mut self) -> Logic {
        Logic::Bit(scanbound_ir::BitSource::Free(self.builder.external_choice()))
    }

    /// Adds writes with a charge.
    pub(crate) fn add_always(&mut self, key: TimingKey, writes: Vec<Write>) {
        let effects = writes.into_iter().map(always).collect();
        self.builder.add(Some(key), effects, Step::Nothing);
    }

    /// A jump whose target is set later.
    pub(crate) fn jump(&mut self, fires: Logic, key: Option<TimingKey>) -> usize {
        self.builder.add(key, Vec::new(), Step::Jump { fires, target: 0 })
    }

    /// Lets a jump go to what is added next.
    pub(crate) fn land(&mut self, jump: usize) {
        let next = self.builder.next();
        if let Step::Jump { target, .. } = &mut self.builder.program.instructions[jump].step {
            *target = next;
        }
    }

    /// Somewhere for jumps to land that need not be a statement.
    pub(crate) fn landing(&mut self) {
        self.builder.add(None, Vec::new(), Step::Nothing);
    }
}

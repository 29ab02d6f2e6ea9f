//! Builds the instructions of a program: choices, temporary values, charges, and the deferred decisions that are
//! resolved when all instructions are known. This module knows neither names nor variables of the source.

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
use value::{Value, sources, targets};

/// The bit area and the word area of variables.
pub(crate) const VARIABLES: [AreaId; 2] = [AreaId(0), AreaId(1)];
/// The bit area and the word area of the state of charts.
pub(crate) const HIDDEN: [AreaId; 2] = [AreaId(2), AreaId(3)];
/// The bit area and the word area of temporary values.
pub(crate) const BETWEEN: [AreaId; 2] = [AreaId(4), AreaId(5)];

/// An action that is lowered once for each possible order of execution (round) of its chart.
pub(crate) struct Turn {
    /// For each round, the instruction that writes the bit which selects this round.
    pub(crate) says: Vec<usize>,
    /// For each round, the instructions of this copy of the action.
    pub(crate) copies: Vec<std::ops::Range<usize>>,
}

/// A decision that is deferred until the whole program is lowered, because it depends on the rest of the program.
pub(crate) enum OpenEnd {
    /// Instruction `at` writes a bit. The bit is false if nothing changes the timer preset (two words from `preset`).
    Preset { at: usize, preset: Cell },
    /// Instruction `at` writes a bit. The bit is false if the variable at `cell` is 0 after power-up, and only the
    /// instructions `own` write it.
    Variable { at: usize, cell: Cell, own: Vec<usize> },
    /// In which of several orders these actions run. Any order gives the same result for an action that shares no
    /// written cell with the others. `memory` is that of the chart's instance.
    Turns { actions: Vec<Turn>, memory: Vec<Region> },
    /// Instructions `own` keep the elapsed time of a step in `cell`. They are dropped if nothing reads it.
    StepTime { cell: Cell, own: Vec<usize> },
}

/// The program under construction, with the state that building it needs.
pub(crate) struct Assembler {
    pub(crate) builder: Builder,
    /// Index of the source file that is being lowered.
    pub(crate) file: usize,
    /// Faults found so far, each with its file index.
    pub(crate) faults: Vec<(usize, Fault)>,
    /// The faults that [`Assembler::fault`] has added, so that each is added once.
    noted_faults: HashSet<(usize, Fault)>,
    pub(crate) tally: Tally,
    /// Statements of the user about the controller, by their text: whether this project depends on it (set during
    /// lowering), and whether the user states it as true.
    pub(crate) stated_readings: BTreeMap<String, (bool, bool)>,
    pub(crate) open_ends: Vec<OpenEnd>,
    /// The PT cells of standard blocks called without a PT input: their preset keeps its value.
    pub(crate) presets_left: BTreeSet<Cell>,
    /// Cells of step times (`STEP.T`) that the program reads.
    pub(crate) times_read: BTreeSet<Cell>,
    /// Cells of the values (CV) and presets (PV) of counters, as far as the program reads them.
    pub(crate) counts: BTreeSet<Cell>,
    /// The first place at which an address becomes a number.
    pub(crate) address_as_number: Option<Location>,
    between: [u32; 2],
    /// Whether the controller stops at an arithmetic error such as division by zero.
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
            address_as_number: None,
            between: [0, 0],
            stops_on_error: true,
        }
    }

    /// Records a fault in the current file. An equal one in the same file is recorded once.
    pub(crate) fn fault(&mut self, fault: Fault) {
        let fault = (self.file, fault);
        if self.noted_faults.insert(fault.clone()) {
            self.faults.push(fault);
        }
    }

    /// Runs `work` and removes the charges of the instructions that it adds, because the caller charges the whole
    /// itself.
    pub(crate) fn charged_already<T>(&mut self, work: impl FnOnce(&mut Assembler) -> T) -> T {
        let from = self.builder.next();
        let found = work(self);
        self.charge_nothing(from);
        found
    }

    /// Removes the charges of all instructions from index `from` on.
    pub(crate) fn charge_nothing(&mut self, from: usize) {
        for instruction in &mut self.builder.program.instructions[from..] {
            instruction.timing = None;
        }
    }

    pub(crate) fn program(&mut self) -> &mut Program {
        &mut self.builder.program
    }

    /// Adds a tag in the areas of chart state, where no code writes directly. None if it cannot be placed.
    pub(crate) fn hidden(&mut self, name: &str, of: scanbound_ir::Type) -> Option<Tag> {
        self.program().tags.add(HIDDEN, name, of)
    }

    /// Sets the source place for the instructions that follow: this line of the current file, with at most 120
    /// characters of its text. Begins a new block.
    pub(crate) fn at(&mut self, line: u32, text: &str) {
        let file = u32::try_from(self.file).unwrap_or(u32::MAX);
        let text: String = text.chars().take(120).collect();
        self.builder.at(Location { file, line, step: None }, text.into(), [].into());
        self.program().blocks += 1;
    }

    /// Notes the place if this value, which becomes a number, is an address.
    pub(crate) fn note_address(&mut self, value: &Value) {
        if matches!(value, Value::Address(..)) {
            let place = self.builder.place();
            self.address_as_number.get_or_insert(place);
        }
    }

    /// A timing key: the names of the rows that may give the time, the most specific first, and the class that is used
    /// if no row has any of these names.
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

    /// The timing key of a jump; always Some.
    pub(crate) fn jump_key() -> Option<TimingKey> {
        Some(Self::key(&["JMP"], "jump"))
    }

    /// Adds an instruction that takes time but has no effect.
    pub(crate) fn cost(&mut self, names: &[&str], class: &'static str) {
        self.builder.add(Some(Self::key(names, class)), Vec::new(), Step::Nothing);
    }

    /// Adds an instruction without a charge that always makes these writes. Returns its index.
    pub(crate) fn write(&mut self, writes: Vec<Write>) -> usize {
        self.builder.add(None, writes.into_iter().map(always).collect(), Step::Nothing)
    }

    /// Adds an instruction that makes these writes where `fires` is true; charged if `key` is given. Returns its index.
    pub(crate) fn write_if(
        &mut self,
        fires: Logic,
        writes: Vec<Write>,
        key: Option<TimingKey>,
    ) -> usize {
        let effects = writes.into_iter().map(scanbound_front::builder::fired).collect();
        self.builder.add(key, effects, Step::Act { fires })
    }

    /// Whether a cell holds a temporary value.
    pub(crate) fn is_between(cell: Cell) -> bool {
        BETWEEN.contains(&cell.area)
    }

    /// Whether a cell is in one of the three bit areas.
    pub(crate) fn is_bit(cell: Cell) -> bool {
        [VARIABLES[0], HIDDEN[0], BETWEEN[0]].contains(&cell.area)
    }

    /// A new bit cell for a temporary value.
    pub(crate) fn bit_between(&mut self) -> Cell {
        self.between[0] += 1;
        Cell { area: BETWEEN[0], index: self.between[0] - 1 }
    }

    /// The first of `words` new consecutive word cells for a temporary value.
    pub(crate) fn words_between(&mut self, words: u32) -> Cell {
        self.between[1] += words;
        Cell { area: BETWEEN[1], index: self.between[1] - words }
    }

    /// The words of a number. A number that is not given as words is first copied to `words` temporary cells.
    pub(crate) fn words(&mut self, number: Number, words: u32) -> Vec<WordSource> {
        match number {
            Number::Words(words) => words,
            number => self.copied(number, words),
        }
    }

    /// Copies a number to `words` new temporary cells and returns these. Later writes do not change the copy.
    pub(crate) fn copied(&mut self, number: Number, words: u32) -> Vec<WordSource> {
        let first = self.words_between(words);
        self.write(vec![Write::Words(targets(first, words), number)]);
        sources(first, words)
    }

    /// Copies a bit to a new temporary cell, so that later writes do not change it. A constant is returned as it is.
    pub(crate) fn keep_bit(&mut self, value: Logic) -> Logic {
        if matches!(value, Logic::Const(_)) {
            return value;
        }
        let cell = self.bit_between();
        self.write(vec![Write::Bit(BitTarget::Cell(cell), value)]);
        Logic::cell(cell)
    }

    /// The result of an operation in `words` new temporary words. `meaning` is the operation, its inputs and the size
    /// of its output in words; with None, the result may be any value.
    pub(crate) fn worked_out(
        &mut self,
        words: u32,
        meaning: Option<(Operation, Vec<Input>, u32)>,
    ) -> Number {
        let first = self.words_between(words);
        let choice = self.builder.choice();
        let mut error = None;
        if let Some((operation, inputs, wide)) = meaning {
            // Words of the output beyond those requested are discarded.
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

    /// The condition under which a controller stops at this operation: a zero divisor, or an array index out of range.
    /// None if it never stops, or if the user states that it does not stop on errors.
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

    /// Records that the controller stops here where `error` is true. Does nothing if it does not stop on errors.
    pub(crate) fn stops_where(&mut self, error: Logic) {
        if self.stops_on_error {
            self.not_followed_where(error);
        }
    }

    /// Records that no run is followed past this point where `error` is true: if the controller continues, it may have
    /// overwritten any memory.
    pub(crate) fn not_followed_where(&mut self, error: Logic) {
        let at = self.builder.add(None, Vec::new(), Step::Nothing);
        self.program().errors.insert(at, error);
    }

    /// A number of this kind with any value, reported as over-approximated with the reason `why`.
    pub(crate) fn any_number(&mut self, kind: Kind, why: &str) -> Number {
        let number = self.worked_out(kind.words(), None);
        let at = self.builder.next() - 1;
        self.program().approximate(at, why);
        number
    }

    /// A bit with either value, reported as over-approximated with the reason `why`.
    pub(crate) fn any_bit(&mut self, why: &str) -> Logic {
        let kept = self.free_bit();
        let at = self.builder.next() - 1;
        self.program().approximate(at, why);
        kept
    }

    /// A bit with either value.
    pub(crate) fn free_bit(&mut self) -> Logic {
        let bit = self.builder.free_bit();
        self.keep_bit(bit)
    }

    /// A free bit that says whether the controller executes here what others do not. It is off in a real run.
    pub(crate) fn extra_time(&mut self) -> Logic {
        let choice = self.builder.choice();
        self.program().kinds.insert(choice, scanbound_ir::ChoiceKind::ExtraTime);
        self.keep_bit(Logic::Bit(scanbound_ir::BitSource::Free(choice)))
    }

    /// A free bit that is on once this many units of half a millisecond, if they are known, have passed since the bit
    /// `running` came on. A run from power-up does not track that time.
    pub(crate) fn time_bit(&mut self, running: Cell, units: Option<u32>) -> Logic {
        let choice = self.builder.external_choice();
        let timekeeping = &mut self.builder.program.timekeeping;
        timekeeping.untracked.insert(choice);
        timekeeping.ends.extend(units.map(|units| (choice, (running, units))));
        Logic::Bit(scanbound_ir::BitSource::Free(choice))
    }

    /// A free bit that an input from outside the program determines.
    pub(crate) fn world_bit(&mut self) -> Logic {
        Logic::Bit(scanbound_ir::BitSource::Free(self.builder.external_choice()))
    }

    /// Adds an instruction with a charge that always makes these writes.
    pub(crate) fn add_always(&mut self, key: TimingKey, writes: Vec<Write>) {
        let effects = writes.into_iter().map(always).collect();
        self.builder.add(Some(key), effects, Step::Nothing);
    }

    /// Adds a forward jump and returns its index. [`Assembler::land`] sets its target.
    pub(crate) fn jump(&mut self, fires: Logic, key: Option<TimingKey>) -> usize {
        self.builder.add(key, Vec::new(), Step::Jump { fires, target: 0 })
    }

    /// Sets the target of a jump to the next instruction that is added.
    pub(crate) fn land(&mut self, jump: usize) {
        let next = self.builder.next();
        if let Step::Jump { target, .. } = &mut self.builder.program.instructions[jump].step {
            *target = next;
        }
    }

    /// Adds an instruction without time or effect as a target for jumps.
    pub(crate) fn landing(&mut self) {
        self.builder.add(None, Vec::new(), Step::Nothing);
    }
}

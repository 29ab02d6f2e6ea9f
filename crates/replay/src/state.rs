//! The state of one scan: the memory, the values computed from it, and which of them are unknown in a real run.

use super::cases::Cases;
use super::free::{FreeValues, Mode};
use super::trace::Trace;
use rustc_hash::FxHashMap;
use scanbound_base::time::Picos;
use scanbound_ir::meaning::{ChoiceKind, Knowledge, Read};
use scanbound_ir::{
    AreaId, AreaKind, BitSource, BitTarget, Cell, ChoiceId, ChoiceKey, Compare, Frame, Logic,
    Number, NumberFormat, Program, Region, Resolution, Source, StartRange, WordSource, WordTarget,
    Write,
};
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The instruction because of which a value is unknown. `None` if the value is known.
pub(super) type Doubt = Option<usize>;

/// A truth value, and whether it is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Truth {
    pub(super) value: bool,
    pub(super) doubt: Doubt,
}

impl Truth {
    /// Known to be true.
    pub(super) const TRUE: Truth = Truth { value: true, doubt: None };

    /// Conjunction. If one side is known to be false, the result is known.
    pub(super) fn and(self, other: Truth) -> Truth {
        let decides = |one: Truth| !one.value && one.doubt.is_none();
        if decides(self) {
            return self;
        }
        if decides(other) {
            return other;
        }
        Truth { value: self.value && other.value, doubt: self.doubt.or(other.doubt) }
    }

    pub(super) fn or(self, other: Truth) -> Truth {
        self.not().and(other.not()).not()
    }

    pub(super) fn not(self) -> Truth {
        Truth { value: !self.value, doubt: self.doubt }
    }
}

/// One havoc of a region: its choice, its call context, and the instruction because of which the new values are
/// unknown.
#[derive(Clone)]
struct HavocRecord {
    region: Region,
    choice: ChoiceId,
    frames: Arc<[Frame]>,
    doubt: Doubt,
}

/// A cell's value, and the number of havocs in its area when it was written. Kept small: large programs have very many
/// of these.
#[derive(Clone, Copy)]
struct CellValue {
    value: u16,
    /// The mask of the value's unknown bits. 0 if the value is known.
    unknown: u16,
    havocs: u32,
    /// The instruction because of which these bits are unknown. [`KNOWN`] if none is.
    because: u32,
}

const KNOWN: u32 = u32::MAX;

impl CellValue {
    fn doubt(self) -> Doubt {
        (self.because != KNOWN).then_some(self.because as usize)
    }
}

/// The computed values of choices of the kind [`ChoiceKind::Exact`], by call context and choice, each with the
/// instruction because of which it is unknown.
type ComputedChoices = BTreeMap<(Arc<[Frame]>, ChoiceId), (u16, Doubt)>;

/// The state of one scan: the cells, and the frames of the current call context.
pub(super) struct State<'p> {
    pub(super) program: &'p Program,
    /// Boxed, so that the interpreter is compiled once, here, and not for each source of values in the crates above.
    pub(super) free: Box<dyn FreeValues + 'p>,
    cells: FxHashMap<Cell, CellValue>,
    /// The havocs of each area, oldest first.
    havocs: Vec<Vec<HavocRecord>>,
    /// The start values of the cells in `Program::stated_ranges`. `None` while the scan has not read the cell.
    started: BTreeMap<Cell, Option<u16>>,
    frames: Arc<[Frame]>,
    pub(super) mode: Mode,
    /// The instruction that is being executed.
    pub(super) at: usize,
    /// The execution condition of the current instruction.
    pub(super) condition: Truth,
    /// Why the value being computed is unknown, if part of it is.
    pub(super) doubt: Doubt,
    /// Whether an interrupt routine is running.
    pub(super) interrupting: bool,
    /// What the current operation has read. `None` outside of operations.
    pub(super) reading: Option<Vec<Read>>,
    /// Whether anything that the operation has read may change at any moment.
    pub(super) changing: bool,
    /// Whether the current operation has accessed a cell that not each PLC has, or a cell through an address.
    pub(super) needs_devices: bool,
    /// The two words that certainly hold an address, by their low word: the first cell of the addressed range
    /// ([`ChoiceKind::AddressOf`]).
    pub(super) pointers: FxHashMap<Cell, Cell>,
    /// The number of devices of each area that each PLC has that can run the program.
    certain_devices: Vec<u32>,
    /// For each area of which the run accessed more devices than each PLC has: how many it needs.
    pub(super) needed: BTreeMap<AreaId, u32>,
    /// The values of choices that operations computed so far in this scan.
    pub(super) known: ComputedChoices,
    /// The results of operations: the ones that this real run has computed, or the ones that a run of the model uses.
    pub(super) learned: Knowledge,
    /// Whether an operation wrote through an address where the user states that none leads.
    pub(super) is_excluded: bool,
    /// Writes of operations to cells that their effects do not declare.
    pub(super) undeclared_writes: Vec<(usize, Cell)>,
    /// Time since the scan began.
    pub(super) now: Picos,
    /// The memory cells of timers, each with the value that it has while its timer is at rest.
    pub(super) memories: FxHashMap<Cell, u16>,
    /// The cells among `memories` whose timer was at rest at some moment of this scan.
    pub(super) rested: BTreeSet<Cell>,
    /// The cells of the present values of timers. For each, the instruction that first read the value at the start of
    /// the scan; `None` while no instruction has read it.
    pub(super) presents: FxHashMap<Cell, Option<usize>>,
    /// The number of changes of cells so far, plus the number of reads whose answer may be different the next time. If
    /// it does not change during an iteration, the next iteration is identical.
    pub(super) changes: u64,
    /// Which way a real run takes at points that are left open.
    pub(super) cases: Cases,
    /// What the run has read and written so far, if it is traced.
    pub(super) trace: Option<Box<Trace>>,
}

impl<'p> State<'p> {
    pub(super) fn new(program: &'p Program, free: Box<dyn FreeValues + 'p>, mode: Mode) -> Self {
        let ranged = program.stated_ranges.iter().flat_map(|range| &range.cells);
        let expiries = program.timekeeping.expiries.values();
        let timers =
            program.timekeeping.instructions.values().filter(|timed| timed.kind.is_timer());
        State {
            program,
            free,
            cells: FxHashMap::default(),
            havocs: vec![Vec::new(); program.areas.len()],
            started: ranged.map(|&cell| (cell, None)).collect(),
            frames: Arc::from([]),
            mode,
            at: 0,
            condition: Truth::TRUE,
            doubt: None,
            interrupting: false,
            reading: None,
            changing: false,
            needs_devices: false,
            pointers: FxHashMap::default(),
            certain_devices: {
                let mut all = vec![u32::MAX; program.areas.len()];
                for (area, &count) in &program.certain_devices {
                    all[usize::from(area.0)] = count;
                }
                all
            },
            needed: BTreeMap::new(),
            known: ComputedChoices::new(),
            learned: Knowledge::new(),
            is_excluded: false,
            undeclared_writes: Vec::new(),
            now: Picos::ZERO,
            memories: expiries.map(|one| (one.memory, one.idle)).collect(),
            rested: BTreeSet::new(),
            presents: match mode {
                Mode::Model => FxHashMap::default(),
                Mode::Real => timers.map(|timed| (timed.present, None)).collect(),
            },
            changes: 0,
            cases: Cases::default(),
            trace: None,
        }
    }

    pub(super) fn program(&self) -> &'p Program {
        self.program
    }

    /// The current call context: calls and iterations, outermost first.
    pub(super) fn frames(&self) -> &Arc<[Frame]> {
        &self.frames
    }

    pub(super) fn enter(&mut self, frame: Frame) {
        self.frames = self.frames.iter().copied().chain([frame]).collect();
    }

    pub(super) fn leave(&mut self) {
        self.frames = self.frames[..self.frames.len() - 1].into();
    }

    pub(super) fn choose(&mut self, choice: ChoiceId, kind: AreaKind) -> u16 {
        if let Some(value) = self.free.register(choice) {
            return value;
        }
        if let Some(is_over) = self.free.is_over(choice) {
            return is_over.into();
        }
        if self.mode == Mode::Real
            && self.free.simulates_time()
            && let Some(present) = self.program.timekeeping.between_instructions.get(&choice)
        {
            return present.map_or(0, |cell| self.read(cell));
        }
        self.changes += 1;
        let key = ChoiceKey { frames: self.frames.to_vec(), choice, cell: None };
        if self.mode == Mode::Model {
            if let Some(&most) = self.program.timekeeping.most_ticks.get(&choice) {
                return most;
            }
            return match self.learned_value(choice) {
                Some(value) => value,
                None => self.free.choice(&key, kind),
            };
        }
        let value = match self.program.kinds.get(&choice) {
            Some(ChoiceKind::External) => {
                let given = self.outside_value(&key, kind);
                if self.is_uncounted(choice) {
                    self.doubt = self.doubt.or(Some(self.at));
                }
                self.expiry(choice, given)
            }
            Some(&ChoiceKind::StableExternal(source)) => self.stable(source),
            Some(&ChoiceKind::Reading(number)) => match self.cases.reading(number, self.at) {
                Some(value) => value.into(),
                None => {
                    self.doubt = self.doubt.or(Some(self.at));
                    0
                }
            },
            Some(&ChoiceKind::PresentValue { contact, setting }) => {
                if self.read(contact) & 1 == 1 {
                    setting
                } else {
                    Some(self.outside_value(&key, kind))
                        .filter(|&value| value < setting)
                        .unwrap_or(0)
                }
            }
            Some(ChoiceKind::ScanTicks { goes_on: true, .. }) => {
                let most = self.program.timekeeping.most_ticks.get(&choice);
                most.copied().unwrap_or(i16::MAX.cast_unsigned())
            }
            // A timer that starts in this scan does not time out in it, unless its set value is 0.
            Some(ChoiceKind::ScanTicks { .. } | ChoiceKind::ExtraTime | ChoiceKind::Parameter) => 0,
            // Such a choice is asked for only as the count of a loop.
            None
            | Some(
                ChoiceKind::Iterations(_)
                | ChoiceKind::UnsignedIterations(_)
                | ChoiceKind::AddressOf { .. },
            ) => {
                self.doubt = self.doubt.or(Some(self.at));
                self.free.choice(&key, kind)
            }
            Some(ChoiceKind::Unreachable(list)) => {
                let (address, count) = &**list;
                if !self.reaches(address, count) {
                    self.doubt = self.doubt.or(Some(self.at));
                }
                0
            }
            Some(ChoiceKind::Exact(meaning)) => match self.value_of(choice, meaning) {
                Some(value) => value,
                None => self.free.choice(&key, kind),
            },
        };
        if let Some(reads) = &mut self.reading {
            reads.push(Read::Choice(key, value));
        }
        value
    }

    /// The value of a choice that something outside the program determines. It counts as unknown if all such values
    /// are.
    fn outside_value(&mut self, key: &ChoiceKey, kind: AreaKind) -> u16 {
        if self.free.outside_is_unknown() {
            self.doubt = self.doubt.or(Some(self.at));
        }
        self.free.choice(key, kind)
    }

    pub(super) fn choose_bit(&mut self, choice: ChoiceId) -> bool {
        self.choose(choice, AreaKind::Bit) & 1 == 1
    }

    /// How the analysis resolved a choice in the current call context. `None` if it let the choice have any value.
    pub(super) fn resolution(&self, choice: ChoiceId) -> Option<&Resolution> {
        self.free.resolutions()?.choice(&self.frames, choice)
    }

    /// Whether the analysis read the number of units of this instruction in a call context in which
    /// [`scanbound_ir::Counted::is_read`] is false.
    pub(super) fn was_counted(&self) -> bool {
        self.free.resolutions().is_some_and(|known| known.counted(&self.frames, self.at))
    }

    /// The current value of the cell. A value from outside is stored, so that it is asked for only once.
    pub(super) fn read(&mut self, cell: Cell) -> u16 {
        self.read_masked(cell, u16::MAX)
    }

    /// As [`Self::read`], but the value counts as unknown only if a bit of `mask` is. The whole word is returned.
    pub(super) fn read_masked(&mut self, cell: Cell, mask: u16) -> u16 {
        let held = self.current(cell);
        self.doubt = self.doubt.or(held.doubt().filter(|_| held.unknown & mask != 0));
        if self.reading.is_some() {
            let changes = self.program.volatile.iter().any(|region| region.contains(cell));
            self.changing |= changes || self.interrupting;
        }
        if let Some(reads) = &mut self.reading {
            reads.push(Read::Cell(cell, mask, held.value & mask));
        }
        held.value
    }

    /// The current value of the cell with its unknown bits. Asks for values from outside.
    fn current(&mut self, cell: Cell) -> CellValue {
        let held = self.cells.get(&cell).copied();
        let since = held.map_or(0, |held| held.havocs as usize);
        let havocs = &self.havocs[usize::from(cell.area.0)];
        let havoc = havocs[since..].iter().rev().find(|havoc| havoc.region.contains(cell));
        let kind = self.program.areas[usize::from(cell.area.0)].kind;
        let continued = havoc.map(|havoc| havoc.choice);
        let continued = continued.and_then(|choice| self.continued_time(choice, cell));
        let havocs = &self.havocs[usize::from(cell.area.0)];
        let havoc = havocs[since..].iter().rev().find(|havoc| havoc.region.contains(cell));
        let (value, doubt, unknown) = match (havoc, held) {
            _ if continued.is_some() => (continued.unwrap_or_default(), None, 0),
            (Some(havoc), _) => {
                let unseen = self.free.outside_is_unknown().then_some(self.at);
                let (frames, doubt) = (havoc.frames.to_vec(), havoc.doubt.or(unseen));
                let key = ChoiceKey { frames, choice: havoc.choice, cell: Some(cell) };
                if let (Some(trace), None) = (&mut self.trace, doubt) {
                    trace.delivered.insert(cell, key.clone());
                }
                (self.free.choice(&key, kind), doubt, u16::MAX)
            }
            (None, Some(held)) => (held.value, held.doubt(), held.unknown),
            (None, None) => {
                let value = self.free.start(cell, kind);
                if let Some(started) = self.started.get_mut(&cell) {
                    *started = Some(value);
                }
                if let Some(read) = self.presents.get_mut(&cell) {
                    read.get_or_insert(self.at);
                }
                let unknown = self.free.unknown(cell);
                (value, (unknown != 0).then_some(self.at), unknown)
            }
        };
        let value = if kind == AreaKind::Bit { value & 1 } else { value };
        self.hold(cell, value, doubt, unknown)
    }

    /// A word of a time that goes on from scan to scan, where an emulated PLC tracks it.
    fn continued_time(&mut self, choice: ChoiceId, cell: Cell) -> Option<u16> {
        let passed = self.free.passed()?;
        let &[time, before] = self.program.timekeeping.continued.get(&choice)?;
        let so_far = u64::from(self.read(before)) | u64::from(self.read(before.plus(1))) << 16;
        Some((so_far.saturating_add(passed) >> (16 * (cell.index - time.index))) as u16)
    }

    /// The value of the cell at the end of the scan, and the mask of its unknown bits.
    pub(super) fn end_value(&mut self, cell: Cell) -> (u16, u16) {
        let held = self.current(cell);
        (held.value, held.unknown)
    }

    /// The cells that the scan read or wrote: the final value and the mask of unknown bits of each.
    pub(super) fn accessed_cells(&mut self) -> Vec<(Cell, u16, u16)> {
        let cells: Vec<Cell> = self.cells.keys().copied().collect();
        let left = |cell| {
            let (value, unknown) = self.end_value(cell);
            (cell, value, unknown)
        };
        cells.into_iter().map(left).collect()
    }

    /// The regions that were havocked.
    pub(super) fn lost(&self) -> Vec<Region> {
        self.havocs.iter().flatten().map(|one| one.region).collect()
    }

    fn hold(&mut self, cell: Cell, value: u16, doubt: Doubt, unknown: u16) -> CellValue {
        let havocs = self.havocs[usize::from(cell.area.0)].len();
        let unknown = if doubt.is_some() { unknown } else { 0 };
        // A program with that many instructions does not fit into memory.
        let number = |index: usize| u32::try_from(index).unwrap_or(KNOWN - 1);
        let because = doubt.filter(|_| unknown != 0).map_or(KNOWN, number);
        let held = CellValue { value, unknown, havocs: number(havocs), because };
        if cell.index >= self.certain_devices[usize::from(cell.area.0)] {
            let needed = self.needed.entry(cell.area).or_default();
            *needed = (*needed).max(cell.index + 1);
        }
        if self.memories.get(&cell) == Some(&value) {
            self.rested.insert(cell);
        }
        let before = self.cells.insert(cell, held);
        let same = |before: CellValue| {
            (before.value, before.unknown, before.because) == (value, unknown, because)
        };
        if !before.is_some_and(same) {
            self.changes += 1;
        }
        held
    }

    /// Writes the bits of `mask` if `fired`. `doubt` says why the value is unknown, if it is. If it is unknown whether
    /// the write happens, the bits become unknown, unless they have the value already.
    pub(super) fn write_bits(
        &mut self,
        cell: Cell,
        mask: u16,
        value: u16,
        doubt: Doubt,
        fired: Truth,
    ) {
        if fired.doubt.is_none() && !fired.value {
            return;
        }
        if let Some(trace) = &mut self.trace {
            trace.writes.entry(cell).or_default().push(trace.event);
        }
        if !self.pointers.is_empty() {
            self.pointers.remove(&cell);
            if let Some(index) = cell.index.checked_sub(1) {
                self.pointers.remove(&Cell { index, ..cell });
            }
        }
        if fired.doubt.is_none() && mask == u16::MAX {
            self.hold(cell, value, doubt, u16::MAX);
            return;
        }
        let old = self.current(cell);
        let (kept, written) = (old.value & !mask, value & mask);
        if fired.doubt.is_none() {
            let unknown = old.unknown & !mask | if doubt.is_some() { mask } else { 0 };
            self.hold(cell, kept | written, doubt.or(old.doubt()), unknown);
            return;
        }
        // If the value is already there, it does not matter whether the write happens.
        if old.value & mask == written && old.unknown & mask == 0 && doubt.is_none() {
            return;
        }
        let value = if fired.value { kept | written } else { old.value };
        self.hold(cell, value, fired.doubt, old.unknown | mask);
    }

    fn read_bit(&mut self, cell: Cell) -> bool {
        self.read(cell) & 1 == 1
    }

    pub(super) fn bit(&mut self, source: BitSource) -> bool {
        let is_traced = self.begin_read();
        let value = match source {
            BitSource::Const(value) => value,
            BitSource::Cell(cell) => self.read_bit(cell),
            BitSource::WordBit(cell, bit) => self.read_masked(cell, 1 << bit) >> bit & 1 == 1,
            BitSource::Free(choice) => self.choose_bit(choice),
        };
        if is_traced {
            self.end_read(Source::Bit(source), value.into());
        }
        value
    }

    pub(super) fn word(&mut self, source: WordSource) -> u16 {
        let is_traced = self.begin_read();
        let value = self.word_of(source);
        if is_traced {
            self.end_read(Source::Word(source), value);
        }
        value
    }

    fn word_of(&mut self, source: WordSource) -> u16 {
        match source {
            WordSource::Const(value) => value,
            WordSource::Cell(cell) => self.read(cell),
            WordSource::Bits { first, count } => (0..count)
                .map(|n| u16::from(self.read_bit(first.plus(u32::from(n)))) << n)
                .fold(0, |word, bit| word | bit),
            WordSource::Free(choice) => self.choose(choice, AreaKind::Word),
        }
    }

    /// The words of the number, least significant first.
    pub(super) fn number(&mut self, number: &Number) -> Vec<u16> {
        match number {
            Number::Words(sources) => sources.iter().map(|&source| self.word(source)).collect(),
            Number::Add(a, b) => add(&self.number(a), &self.number(b), false),
            Number::Sub(a, b) => {
                let (a, b) = (self.number(a), self.number(b));
                // Two's complement: a difference is the sum with the inverse plus one.
                add(&a, &b.iter().map(|word| !word).collect::<Vec<_>>(), true)
            }
            Number::And(a, b) => zip(&self.number(a), &self.number(b), |a, b| a & b),
            Number::Or(a, b) => zip(&self.number(a), &self.number(b), |a, b| a | b),
            Number::Xor(a, b) => zip(&self.number(a), &self.number(b), |a, b| a ^ b),
        }
    }

    fn compare(&mut self, compare: &Compare) -> bool {
        let (left, right) = (self.number(&compare.left), self.number(&compare.right));
        let order = match compare.format {
            NumberFormat::Signed => signed(&left).cmp(&signed(&right)),
            NumberFormat::Unsigned => left.iter().rev().cmp(right.iter().rev()),
            NumberFormat::Real(choice) => match real(&left).zip(real(&right)) {
                Some((left, right)) => {
                    left.partial_cmp(&right).expect("normal numbers can be compared")
                }
                None => return self.choose_bit(choice),
            },
        };
        compare.relation.holds(order, Ordering::Equal)
    }

    /// The truth value of `logic` in this state. `condition` is the execution condition of the instruction.
    pub(super) fn logic(&mut self, logic: &Logic, condition: Truth) -> Truth {
        match logic {
            Logic::Condition => condition,
            Logic::Not(inner) => self.logic(inner, condition).not(),
            // In a real run all parts are evaluated, so that what is learned does not depend on their order.
            Logic::All(parts) => {
                let parts = parts.iter().map(|part| self.logic(part, condition));
                parts.fold(Truth::TRUE, Truth::and)
            }
            Logic::Any(parts) => {
                let parts = parts.iter().map(|part| self.logic(part, condition));
                parts.fold(Truth::TRUE.not(), Truth::or)
            }
            Logic::Const(value) => Truth { value: *value, doubt: None },
            Logic::Bit(source) => self.doubted(|state| state.bit(*source)),
            Logic::Compare(compare) => self.doubted(|state| state.compare(compare)),
        }
    }

    /// Evaluates `work`, and returns its result together with whether it is known.
    fn doubted(&mut self, work: impl FnOnce(&mut Self) -> bool) -> Truth {
        let outer = self.doubt.take();
        let value = work(self);
        let doubt = std::mem::replace(&mut self.doubt, outer);
        Truth { value, doubt }
    }

    /// Performs a write if `fired`. `condition` is the execution condition of the instruction.
    pub(super) fn write(&mut self, write: &Write, condition: Truth, fired: Truth) {
        if !fired.value && fired.doubt.is_none() {
            return;
        }
        match write {
            Write::Bit(target, value) => {
                let value = self.logic(value, condition);
                self.put_bit(*target, value, fired);
            }
            Write::Words(targets, number) => {
                let pointer = self.pointer(number).filter(|_| fired == Truth::TRUE);
                let outer = self.doubt.take();
                let words = self.number(number);
                let doubt = std::mem::replace(&mut self.doubt, outer);
                for (target, word) in targets.iter().zip(words) {
                    self.put_word(*target, word, doubt, fired);
                }
                if let (Some(pointer), &[WordTarget::Cell(low), WordTarget::Cell(high)]) =
                    (pointer, &targets[..])
                    && high == low.plus(1)
                {
                    self.pointers.insert(low, pointer);
                }
            }
            Write::Havoc(region, choice) => self.havoc(*region, *choice, fired),
        }
    }

    pub(super) fn put_bit(&mut self, target: BitTarget, value: Truth, fired: Truth) {
        let bit = u16::from(value.value);
        match target {
            BitTarget::Cell(cell) => self.write_bits(cell, u16::MAX, bit, value.doubt, fired),
            BitTarget::WordBit(cell, at) => {
                self.write_bits(cell, 1 << at, bit << at, value.doubt, fired)
            }
        }
    }

    pub(super) fn put_word(&mut self, target: WordTarget, word: u16, doubt: Doubt, fired: Truth) {
        match target {
            WordTarget::Cell(cell) => self.write_bits(cell, u16::MAX, word, doubt, fired),
            WordTarget::Bits { first, count } => {
                for n in 0..count {
                    self.write_bits(
                        first.plus(u32::from(n)),
                        u16::MAX,
                        word >> n & 1,
                        doubt,
                        fired,
                    );
                }
            }
            WordTarget::Discard => {}
        }
    }

    /// Havocs a region if `fired`. In a real run, its cells are known afterwards only if their values come from
    /// outside.
    pub(super) fn havoc(&mut self, region: Region, choice: ChoiceId, fired: Truth) {
        self.changes += 1;
        if let (Mode::Real, Region::Range { first: low, count: 2 }) = (self.mode, region)
            && let Some(&ChoiceKind::AddressOf { number, first }) = self.program.kinds.get(&choice)
        {
            let doubt = fired.doubt.or(Some(self.at));
            self.write_bits(low, u16::MAX, number as u16, doubt, fired);
            self.write_bits(low.plus(1), u16::MAX, (number >> 16) as u16, doubt, fired);
            if fired == Truth::TRUE {
                self.pointers.insert(low, first);
            }
            return;
        }
        if let Some(trace) = &mut self.trace {
            trace.havocs.push((trace.event, region));
        }
        self.pointers.retain(|low, _| !region.contains(*low) && !region.contains(low.plus(1)));
        let world = self.program.kinds.get(&choice) == Some(&ChoiceKind::External);
        let doubt = match self.mode {
            Mode::Model => None,
            Mode::Real if world && !self.is_uncounted(choice) => fired.doubt,
            Mode::Real => fired.doubt.or(Some(self.at)),
        };
        let regions = match self.resolution(choice) {
            Some(Resolution::Within(closer))
                if self.mode == Mode::Model
                    && self
                        .program
                        .indexed
                        .get(&choice)
                        .is_some_and(|one| one.shares_area(region)) =>
            {
                region.intersections(closer)
            }
            _ => vec![region],
        };
        for region in regions {
            let havoc = HavocRecord { region, choice, frames: self.frames.clone(), doubt };
            match region {
                Region::Range { first, .. } => self.havocs[usize::from(first.area.0)].push(havoc),
                Region::Area(area) => self.havocs[usize::from(area.0)].push(havoc),
                Region::Everything => {
                    self.havocs.iter_mut().for_each(|area| area.push(havoc.clone()));
                }
            }
        }
    }

    /// The stated ranges that the start values violate, whatever the cells hold that were not read.
    pub(super) fn broken_ranges(&self) -> Vec<usize> {
        let ranges = self.program.stated_ranges.iter().enumerate();
        ranges.filter(|(_, range)| !self.meets(range)).map(|(index, _)| index).collect()
    }

    /// The ranges that hold at the start and not at the end, with the values at the end. Only known values count.
    pub(super) fn range_violations(&mut self) -> Vec<(usize, i64)> {
        let number = |words: &[u16]| match *words {
            [word] => Some(i64::from(word.cast_signed())),
            [low, high] => Some(double(low, high)),
            _ => None,
        };
        let mut left = Vec::new();
        for (index, range) in self.program.stated_ranges.iter().enumerate() {
            let cells = range.cells.iter();
            let mut is_known = true;
            let (mut start, mut end) = (Vec::new(), Vec::new());
            for &cell in cells {
                start.push(self.free.start(cell, AreaKind::Word));
                let (value, unknown) = self.end_value(cell);
                is_known &= unknown == 0 && self.free.unknown(cell) == 0;
                end.push(value);
            }
            let within = |value: i64| range.contains(value);
            if let (true, Some(start), Some(end)) = (is_known, number(&start), number(&end))
                && within(start)
                && !within(end)
            {
                left.push((index, end));
            }
        }
        left
    }

    fn meets(&self, range: &StartRange) -> bool {
        let read: Vec<Option<u16>> =
            range.cells.iter().map(|cell| self.started.get(cell).copied().flatten()).collect();
        let within = |value: i64| range.contains(value);
        match read[..] {
            [Some(word)] => within(i64::from(word.cast_signed())),
            [Some(low), Some(high)] => within(double(low, high)),
            [Some(low), None] => (0..=u16::MAX).any(|high| within(double(low, high))),
            [None, Some(high)] => {
                range.low <= double(u16::MAX, high) && double(0, high) <= range.high
            }
            _ => true,
        }
    }
}

fn double(low: u16, high: u16) -> i64 {
    i64::from((u32::from(high) << 16 | u32::from(low)).cast_signed())
}

fn zip(a: &[u16], b: &[u16], mut join: impl FnMut(u16, u16) -> u16) -> Vec<u16> {
    a.iter().zip(b).map(|(&a, &b)| join(a, b)).collect()
}

/// The sum with a carry into the least significant word, wrapped around.
fn add(a: &[u16], b: &[u16], carry: bool) -> Vec<u16> {
    let mut carry = u32::from(carry);
    zip(a, b, |a, b| {
        let sum = u32::from(a) + u32::from(b) + carry;
        carry = sum >> 16;
        (sum & 0xFFFF) as u16
    })
}

/// Converts words so that comparing them, most significant first, orders them as signed numbers.
fn signed(words: &[u16]) -> Vec<u16> {
    let mut ordered: Vec<u16> = words.iter().rev().copied().collect();
    if let Some(top) = ordered.first_mut() {
        *top ^= 0x8000;
    }
    ordered
}

/// The IEEE 754 single, if it is a normal number or +0.
fn real(words: &[u16]) -> Option<f32> {
    let &[low, high] = words else { return None };
    let bits = u32::from(high) << 16 | u32::from(low);
    let value = f32::from_bits(bits);
    (bits == 0 || value.is_normal()).then_some(value)
}

//! Consecutive scans from power-up on: each is a real run that starts in the state that the one before it left.

use super::cases::{Cases, Readings};
use super::free::{FreeValues, Mode};
use super::machine::Machine;
use super::memory::{Memory, ScanChanges};
use super::outcome::RealRun;
use super::timed::{TimedInputs, TimerMemory};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::OperationInput;
use scanbound_ir::timers::TimerOrCounter;
use scanbound_ir::{
    AreaId, AreaKind, BitTarget, Cell, ChoiceKey, ChoiceKind, Program, Region, WordSource, flow,
};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// The values that come from outside the program in one scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutsideValues<'p> {
    /// Values of the inputs that are set from outside ([`Outside::sets`]). A cell that is not listed is 0.
    pub inputs: BTreeMap<Cell, u16>,
    /// The values of choices. A choice that is not listed has the value 0.
    pub choices: &'p BTreeMap<ChoiceKey, u16>,
    /// If set, choices of the kind [`ChoiceKind::External`] have pseudo-random values with this seed instead. Inputs
    /// are not affected. `None`: `choices` gives their values too.
    pub seed: Option<u64>,
}

/// Which cells are set from outside the program.
pub struct Outside<'p> {
    program: &'p Program,
    /// The regions that the program may write in the areas in which it has inputs.
    written: Vec<Region>,
    /// If values from outside are unknown: the cells that the program writes individually. `None` otherwise.
    program_written: Option<BTreeSet<Cell>>,
}

/// If the program writes a region with more cells than this, the region does not count as written individually.
const LARGEST: u32 = 4096;

impl<'p> Outside<'p> {
    /// The cells of this program that are set from outside, with known values.
    #[must_use]
    pub fn of(program: &'p Program) -> Outside<'p> {
        Outside { program, written: written(program), program_written: None }
    }

    /// The outside of this program with unknown values: everything from outside is unknown, and in the first scan also
    /// every cell that the program does not write individually.
    #[must_use]
    pub fn with_unknown_values(program: &'p Program) -> Outside<'p> {
        let mut own = BTreeSet::new();
        for region in (0..program.instructions.len()).flat_map(|at| flow::written(program, at)) {
            if let Region::Range { first, count } = region
                && count <= LARGEST
            {
                own.extend((0..count).map(|n| first.plus(n)));
            }
        }
        Outside { program_written: Some(own), ..Outside::of(program) }
    }

    /// The program to which the values from outside are given.
    #[must_use]
    pub fn program(&self) -> &'p Program {
        self.program
    }

    /// A placeholder for an unknown value: the value nearest to 0 in the cell's range in `Program::stated_ranges`, or 0
    /// if it has none.
    fn placeholder(&self, cell: Cell) -> u16 {
        let range = self.program.stated_ranges.iter().find(|range| range.cells == [cell]);
        range.map_or(0, |range| range.nearest_to_zero() as u16)
    }

    /// If values from outside are unknown: whether the start value of the cell is. It is for inputs and for cells that
    /// others write, and in the first scan for cells that the program does not write individually.
    fn is_unknown(&self, cell: Cell, is_first: bool) -> bool {
        let Some(own) = &self.program_written else { return false };
        let is_others = self.program.external.iter().any(|region| region.contains(cell));
        is_others || self.sets(cell) || is_first && !own.contains(&cell)
    }

    /// Whether the cell is set from outside before each scan: it is an input, and the program does not write it.
    #[must_use]
    pub fn sets(&self, cell: Cell) -> bool {
        let inputs = &self.program.power_up.inputs;
        inputs.iter().any(|region| region.contains(cell))
            && !self.written.iter().any(|region| region.contains(cell))
    }
}

/// A PLC since power-up, and its state after the scans so far.
pub struct Run<'p> {
    outside: &'p Outside<'p>,
    /// The times of each instruction, parallel to `Program::instructions`.
    times: &'p [Times],
    /// The overhead of a scan: its time besides its instructions.
    overhead: Picos,
    memory: Memory,
    /// Whether the next scan is the first.
    is_first: bool,
    /// Time since power-up at which the next scan begins.
    now: Picos,
    timer_memory: RefCell<TimerMemory>,
    /// For each running timer, by its memory cell: the earliest and the latest time at which it was started.
    began: BTreeMap<Cell, (Picos, Picos)>,
    /// The bit of a word that is on in the first scan only, if the program does not write that word.
    first_scan_flag: Option<(Cell, u8)>,
    /// Which readings of a standard the controller follows, and what the scans so far depend on.
    cases: Cases,
    /// The start values that the last scan read.
    asked: RefCell<BTreeMap<Cell, u16>>,
    /// The time of the last scan, if scans with the same inputs repeat it until a timer times out. Otherwise `None`.
    steady: Option<Picos>,
    /// The cells of timers' present values.
    presents: BTreeSet<Cell>,
    /// Whether instructions other than those of timers and counters read one of `presents`.
    reads_presents: bool,
}

/// The values of cells and choices at the start of a scan of the run.
struct Start<'r, 'p> {
    run: &'r Run<'p>,
    given: &'r OutsideValues<'p>,
}

impl<'p> Run<'p> {
    /// A PLC at power-up. `times` is parallel to `Program::instructions`. Each scan takes `overhead` in addition. All
    /// readings of a standard are unknown.
    #[must_use]
    pub fn new(outside: &'p Outside<'p>, times: &'p [Times], overhead: Picos) -> Run<'p> {
        // Counters count scans, not time: a scan that changes a counter differs from the next scan.
        let coils = outside.program.timekeeping.instructions.values();
        let timers = coils.filter(|timed| timed.kind.is_timer());
        let presents: BTreeSet<Cell> = timers.map(|timed| timed.present).collect();
        let first_scan_flag = match outside.program.power_up.after_clear {
            Some(BitTarget::WordBit(word, bit))
                if !flow::may_write(outside.program, Region::Range { first: word, count: 1 }) =>
            {
                Some((word, bit))
            }
            _ => None,
        };
        Run {
            outside,
            first_scan_flag,
            cases: Cases::of_run(Readings::new()),
            times,
            overhead,
            memory: Memory::default(),
            is_first: true,
            now: Picos::ZERO,
            timer_memory: RefCell::default(),
            began: BTreeMap::new(),
            asked: RefCell::default(),
            steady: None,
            reads_presents: reads(outside.program, &presents),
            presents,
        }
    }

    /// Runs the next scan. It stops after `most` instructions, and at a loop of which the manuals do not say whether it
    /// makes one iteration or none. Do not call it again after a scan that stopped early.
    pub fn scan(&mut self, given: &OutsideValues<'p>, most: u64) -> RealRun {
        let program = self.outside.program;
        self.asked.borrow_mut().clear();
        self.timer_memory.borrow_mut().begin_scan();
        let start = Start { run: self, given };
        let machine = Machine::new(program, self.times, start, Mode::Real);
        // This run does not try both cases of a loop that makes one iteration or none: it stops at such a loop.
        let (real, mut state) = machine.real(most, self.cases.clone());
        let changes = ScanChanges::of(&mut state);
        let rested = std::mem::take(&mut state.rested);
        let cases = std::mem::take(&mut state.cases);
        drop(state);
        self.cases = cases;
        let changed = self.memory.apply(changes);
        let scratch = &program.timekeeping.scratch;
        let matters = |cell: &Cell| !self.presents.contains(cell) && !scratch.contains(&cell.area);
        let is_steady = !self.is_first && !changed.iter().any(matters);
        let took = self.overhead + real.replay.total;
        self.steady = is_steady.then_some(took);
        for expiry in program.timekeeping.expiries.values() {
            let memory = expiry.memory;
            if self.memory.get(memory).is_none_or(|(value, _)| value == expiry.idle) {
                self.began.remove(&memory);
            } else if rested.contains(&memory) || !self.began.contains_key(&memory) {
                self.began.insert(memory, (self.now, self.now + took));
            }
        }
        self.now += took;
        self.is_first = false;
        real
    }

    /// The bit of this word that is on in the first scan only. 0 if it has no such bit, or the program may write it.
    fn first_scan_flag(&self, cell: Cell) -> u16 {
        match self.first_scan_flag {
            Some((word, bit)) if word == cell => 1 << bit,
            _ => 0,
        }
    }

    /// Lets the controller follow these readings of a standard. All others stay unknown.
    #[must_use]
    pub fn with_readings(mut self, readings: Readings) -> Run<'p> {
        self.cases = Cases::of_run(readings);
        self
    }

    /// A reading that is unknown, and on which the run so far depends or may depend. `None` if it depends on none.
    #[must_use]
    pub fn undecided(&self) -> Option<u32> {
        self.cases.undecided()
    }

    /// The start values that the last scan read, by cell.
    #[must_use]
    pub fn started(&self) -> BTreeMap<Cell, u16> {
        self.asked.borrow().clone()
    }

    /// Whether the last scan changed nothing but present values of timers and scratch memory, so that the same inputs
    /// repeat it until a timer times out. The first scan never counts.
    #[must_use]
    pub fn is_steady(&self) -> bool {
        self.steady.is_some()
    }

    /// Skips the scans that repeat the last one, up to the next moment at which a timer may change something: advances
    /// the clock and returns their number. `None` if the last scan changed something or no timer runs.
    pub fn wait(&mut self) -> Option<u64> {
        let took = self.steady?;
        let program = self.outside.program;
        let timer_memory = self.timer_memory.borrow();
        let known = |cell: Cell| self.memory.get(cell).filter(|(_, unknown)| *unknown == 0);
        let coils = program.timekeeping.instructions.values().filter_map(|timed| {
            let setting = match timed.setting {
                WordSource::Const(value) => value,
                WordSource::Cell(cell) => known(cell)?.0,
                WordSource::Bits { .. } | WordSource::Free(_) => return None,
            };
            timer_memory.next(timed, [setting, known(timed.present)?.0], self.reads_presents)
        });
        let expiries = program.timekeeping.expiries.values().filter_map(|expiry| {
            let &(_, latest) = self.began.get(&expiry.memory)?;
            let words = expiry.setting.iter().rev().try_fold(0u64, |all, word| match *word {
                WordSource::Const(value) => Some(all << 16 | u64::from(value)),
                WordSource::Cell(cell) => Some(all << 16 | u64::from(known(cell)?.0)),
                WordSource::Bits { .. } | WordSource::Free(_) => None,
            })?;
            // The moment at which the timer has certainly timed out.
            let is_followed = !expiry.is_decimal;
            let end = expiry.unit.0.checked_mul(words.checked_add(expiry.tick + 1)?)?;
            latest.0.checked_add(end).filter(|_| is_followed).map(Picos)
        });
        let expiries = expiries.filter(|&moment| moment > self.now);
        let next = coils.chain(expiries).min()?;
        drop(timer_memory);
        let scans = next.0.saturating_sub(self.now.0).div_ceil(took.0.max(1));
        self.timer_memory.borrow_mut().repeat_scan(scans);
        self.now += Picos(took.0.checked_mul(scans)?);
        Some(scans)
    }
}

impl Start<'_, '_> {
    /// The bits of a start value that are unknown. The flag of the first scan in a word may be among them.
    fn unknown_bits(&self, cell: Cell) -> u16 {
        let outside = self.run.outside;
        let program = outside.program;
        let power_up = &program.power_up;
        let is_in = |regions: &[Region]| regions.iter().any(|region| region.contains(cell));
        if power_up.first_scan.contains(&cell) {
            return 0;
        }
        if outside.is_unknown(cell, self.run.is_first) {
            return u16::MAX;
        }
        if outside.sets(cell) {
            return 0;
        }
        // Cells that are written by others at any time are unknown.
        if is_in(&program.volatile)
            || program.networks.iter().any(|(region, _)| region.contains(cell))
        {
            return u16::MAX;
        }
        match self.run.memory.get(cell) {
            Some((_, unknown)) => unknown,
            None if is_in(&power_up.cleared) => 0,
            None => u16::MAX,
        }
    }
}

impl FreeValues for Start<'_, '_> {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        let Run { outside, memory, is_first, .. } = self.run;
        let value = if outside.program_written.is_none() && outside.sets(cell) {
            self.given.inputs.get(&cell).copied().unwrap_or(0)
        } else if outside.program.power_up.first_scan.contains(&cell) {
            u16::from(*is_first)
        } else {
            let value = match memory.get(cell) {
                Some((value, _)) => value,
                None if outside.is_unknown(cell, true) => outside.placeholder(cell),
                None => outside.program.power_up.initial_value(cell),
            };
            let flag = self.run.first_scan_flag(cell);
            if *is_first { value | flag } else { value & !flag }
        };
        self.run.asked.borrow_mut().insert(cell, value);
        value
    }

    fn unknown(&mut self, cell: Cell) -> u16 {
        self.unknown_bits(cell) & !self.run.first_scan_flag(cell)
    }

    fn outside_is_unknown(&self) -> bool {
        self.run.outside.program_written.is_some()
    }

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        if let Some(seed) = self.given.seed
            && self.run.outside.program.kinds.get(&key.choice) == Some(&ChoiceKind::External)
        {
            return at_random(seed, key);
        }
        self.given.choices.get(key).copied().unwrap_or(0)
    }

    fn timed(&mut self, timed: &TimerOrCounter, found: &TimedInputs) -> Option<(bool, u16)> {
        let found = TimedInputs { now: self.run.now + found.now, ..found.clone() };
        self.run.timer_memory.borrow_mut().execute(timed, &found)
    }

    fn lose_timed(&mut self, timed: &TimerOrCounter) {
        self.run.timer_memory.borrow_mut().lose(timed);
    }

    fn simulates_time(&self) -> bool {
        // If values from outside are unknown, scans may also take longer than simulated.
        !self.outside_is_unknown()
    }

    fn counts_time(&self) -> bool {
        self.simulates_time()
    }

    fn ran_for(&mut self, memory: Cell) -> Option<(Picos, Picos)> {
        if !self.simulates_time() {
            return None;
        }
        let (earliest, latest) = self.run.began.get(&memory).copied().unwrap_or_default();
        let since = |moment: Picos| self.run.now.checked_sub(moment).unwrap_or_default();
        Some((since(latest), since(earliest)))
    }
}

/// A pseudo-random value that depends only on the seed, the choice and the call context.
fn at_random(seed: u64, key: &ChoiceKey) -> u16 {
    const ODD: u64 = 0x9E37_79B9_7F4A_7C15;
    let frames = key.frames.iter().flat_map(|frame| [frame.at as u64, frame.iteration.into()]);
    let all = [u64::from(key.choice.0)].into_iter().chain(frames);
    let mixed = all.fold(seed, |mixed, part| (mixed ^ part).wrapping_mul(ODD).rotate_left(29));
    (mixed.wrapping_mul(ODD) >> 48) as u16
}

/// Whether an instruction other than that of a timer or counter reads one of these cells.
fn reads(program: &Program, cells: &BTreeSet<Cell>) -> bool {
    let mut found = false;
    for (at, instruction) in program.instructions.iter().enumerate() {
        if program.timekeeping.instructions.contains_key(&at) {
            continue;
        }
        instruction.each_read(&mut |source| {
            if let Some(Region::Range { first, count }) = source.region() {
                found |= (0..count).any(|n| cells.contains(&first.plus(n)));
            }
        });
    }
    let areas: BTreeSet<AreaId> = cells.iter().map(|cell| cell.area).collect();
    for kind in program.kinds.values() {
        kind.each_word(&mut |word| {
            if let WordSource::Cell(cell) = word {
                found |= cells.contains(&cell);
            }
        });
        if let ChoiceKind::Exact(meaning) = kind {
            found |= meaning.inputs.iter().any(|input| match input {
                OperationInput::Run(address, ..) => {
                    address.ranges.iter().any(|one| areas.contains(&one.first.area))
                }
                _ => false,
            });
        }
    }
    found
}

/// All regions that the program may write in the areas in which it has inputs; the regions need not be inputs. If a bit
/// of a word is written, the whole word counts.
fn written(program: &Program) -> Vec<Region> {
    let inputs = &program.power_up.inputs;
    let all = (0..program.instructions.len()).flat_map(|at| flow::written(program, at));
    // Only areas with inputs are of interest.
    let area = |region: &Region| match *region {
        Region::Range { first, .. } => Some(first.area),
        Region::Area(area) => Some(area),
        Region::Everything => None,
    };
    let mut written: Vec<Region> = all
        .filter(|region| {
            inputs.iter().any(|input| {
                area(region).zip(area(input)).is_none_or(|(written, input)| written == input)
            })
        })
        .collect();
    written.sort_unstable();
    written.dedup();
    written
}

//! Scans that follow each other from power-up on: real runs, each in the state that the one before has left.

use super::clockwork::{Clockwork, Found};
use super::machine::{MOST_ASKED, Machine};
use super::memory::{Left, Memory};
use super::{FreeValues, Mode, RealRun};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::Operand;
use scanbound_ir::timed::Timed;
use scanbound_ir::{
    AreaId, AreaKind, Cell, ChoiceKey, ChoiceKind, Program, Region, WordSource, flow,
};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// What the outside gives in one scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Given<'p> {
    /// Inputs, and what else [`Outside::sets`]; 0 where it is not named.
    pub inputs: BTreeMap<Cell, u16>,
    /// Choices in the scan; 0 where one is not named.
    pub choices: &'p BTreeMap<ChoiceKey, u16>,
    /// Choices that the outside makes are at random instead, by this seed.
    pub chance: Option<u64>,
}

/// What the outside of a program sets.
pub struct Outside<'p> {
    program: &'p Program,
    /// What the program may write by itself where inputs are.
    written: Vec<Region>,
    /// Where nothing is known of what the outside gives: the cells that the program writes by themselves.
    own: Option<BTreeSet<Cell>>,
}

/// Larger stretches of cells are not taken as the program's own.
const LARGEST: u32 = 4096;

impl<'p> Outside<'p> {
    /// The program's.
    #[must_use]
    pub fn of(program: &'p Program) -> Outside<'p> {
        Outside { program, written: written(program), own: None }
    }

    /// The program's, where nothing is known of what it gives, nor of any cell that the program does not write by itself.
    #[must_use]
    pub fn unseen(program: &'p Program) -> Outside<'p> {
        let mut own = BTreeSet::new();
        for region in (0..program.instructions.len()).flat_map(|at| flow::written(program, at)) {
            if let Region::Range { first, count } = region
                && count <= LARGEST
            {
                own.extend((0..count).map(|n| first.plus(n)));
            }
        }
        Outside { own: Some(own), ..Outside::of(program) }
    }

    /// A value that is not known: one that is stated to be possible, 0 where that is.
    fn stated(&self, cell: Cell) -> u16 {
        let range = self.program.ranges.iter().find(|range| range.cells == [cell]);
        range.map_or(0, |range| range.least() as u16)
    }

    /// Whether nothing is known of what the cell holds whenever a scan starts, or at power-up.
    fn hides(&self, cell: Cell, is_first: bool) -> bool {
        let Some(own) = &self.own else { return false };
        let is_others = self.program.external.iter().any(|region| region.holds(cell));
        is_others || self.sets(cell) || is_first && !own.contains(&cell)
    }

    /// Whether the outside sets the cell before each scan: an input that the program leaves alone.
    #[must_use]
    pub fn sets(&self, cell: Cell) -> bool {
        let inputs = &self.program.power_up.inputs;
        inputs.iter().any(|region| region.holds(cell))
            && !self.written.iter().any(|region| region.holds(cell))
    }
}

/// A PLC that was switched on, and the scans that it has made.
pub struct Run<'p> {
    outside: &'p Outside<'p>,
    /// What each instruction costs at least.
    times: &'p [Times],
    /// What a scan takes besides its instructions.
    overhead: Picos,
    memory: Memory,
    /// Whether no scan was made yet.
    is_first: bool,
    /// How long it was running when the next scan begins.
    now: Picos,
    clockwork: RefCell<Clockwork>,
    /// When timers that run began to, by their memories: at the earliest and at the latest.
    began: BTreeMap<Cell, (Picos, Picos)>,
    /// The values with which the last scan began, as far as it asked for them.
    asked: RefCell<BTreeMap<Cell, u16>>,
    /// What the last scan took, if a further one with the same inputs does the same until some timer is over.
    steady: Option<Picos>,
    /// The words of timers' present values, and whether the program reads one.
    presents: BTreeSet<Cell>,
    reads_presents: bool,
}

/// The values with which a scan of a run starts.
struct Start<'r, 'p> {
    run: &'r Run<'p>,
    given: &'r Given<'p>,
}

impl<'p> Run<'p> {
    /// Power-up. `times` is parallel to `Program::instructions`, and a scan takes `overhead` besides.
    #[must_use]
    pub fn new(outside: &'p Outside<'p>, times: &'p [Times], overhead: Picos) -> Run<'p> {
        // Counters count scans and not time: a scan that changes one differs from the next.
        let coils = outside.program.timekeeping.coils.values();
        let timers = coils.filter(|timed| timed.manner.is_timer());
        let presents: BTreeSet<Cell> = timers.map(|timed| timed.present).collect();
        Run {
            outside,
            times,
            overhead,
            memory: Memory::default(),
            is_first: true,
            now: Picos::ZERO,
            clockwork: RefCell::default(),
            began: BTreeMap::new(),
            asked: RefCell::default(),
            steady: None,
            reads_presents: reads(outside.program, &presents),
            presents,
        }
    }

    /// Makes the next scan, of at most `most` instructions. After one that was not followed to its end none follows.
    pub fn scan(&mut self, given: &Given<'p>, most: u64) -> RealRun {
        let program = self.outside.program;
        self.asked.borrow_mut().clear();
        let start = Start { run: self, given };
        let machine = Machine::new(program, self.times, start, Mode::Real);
        // One run cannot try both cases of a loop that makes one iteration or none: it ends there.
        let (real, mut state) = machine.real_from(most, MOST_ASKED);
        let left = Left::by(&mut state);
        let rested = std::mem::take(&mut state.rested);
        drop(state);
        let changed = self.memory.take(left);
        let scratch = &program.timekeeping.scratch;
        let matters = |cell: &Cell| !self.presents.contains(cell) && !scratch.contains(&cell.area);
        let is_steady = !self.is_first && !changed.iter().any(matters);
        let took = self.overhead + real.replay.total;
        self.steady = is_steady.then_some(took);
        for expiry in program.timekeeping.expiries.values() {
            let memory = expiry.memory;
            if self.memory.get(memory).is_none_or(|(value, _)| value == expiry.rest) {
                self.began.remove(&memory);
            } else if rested.contains(&memory) || !self.began.contains_key(&memory) {
                self.began.insert(memory, (self.now, self.now + took));
            }
        }
        self.now += took;
        self.is_first = false;
        real
    }

    /// The values with which the last scan began, as far as they matter.
    #[must_use]
    pub fn started(&self) -> BTreeMap<Cell, u16> {
        self.asked.borrow().clone()
    }

    /// Whether the last scan changed nothing.
    #[must_use]
    pub fn is_steady(&self) -> bool {
        self.steady.is_some()
    }

    /// Lets scans like the last one follow, until the next one may differ since time has passed for a timer: how many.
    /// `None` if the last scan changed something, or no timer runs.
    pub fn wait(&mut self) -> Option<u64> {
        let took = self.steady?;
        let program = self.outside.program;
        let clockwork = self.clockwork.borrow();
        let known = |cell: Cell| self.memory.get(cell).filter(|(_, unknown)| *unknown == 0);
        let coils = program.timekeeping.coils.values().filter_map(|timed| {
            let setting = match timed.setting {
                WordSource::Const(value) => value,
                WordSource::Cell(cell) => known(cell)?.0,
                WordSource::Bits { .. } | WordSource::Free(_) => return None,
            };
            clockwork.next(timed, [setting, known(timed.present)?.0], self.reads_presents)
        });
        let expiries = program.timekeeping.expiries.values().filter_map(|expiry| {
            let &(_, latest) = self.began.get(&expiry.memory)?;
            let words = expiry.setting.iter().rev().try_fold(0u64, |all, word| match *word {
                WordSource::Const(value) => Some(all << 16 | u64::from(value)),
                WordSource::Cell(cell) => Some(all << 16 | u64::from(known(cell)?.0)),
                WordSource::Bits { .. } | WordSource::Free(_) => None,
            })?;
            // The next moment from which on it is over for certain.
            let is_followed = !expiry.is_decimal;
            let end = expiry.unit.0.checked_mul(words.checked_add(2)?)?;
            latest.0.checked_add(end).filter(|_| is_followed).map(Picos)
        });
        let expiries = expiries.filter(|&moment| moment > self.now);
        let next = coils.chain(expiries).min()?;
        drop(clockwork);
        let scans = next.0.saturating_sub(self.now.0).div_ceil(took.0.max(1));
        self.now += Picos(took.0.checked_mul(scans)?);
        Some(scans)
    }
}

impl FreeValues for Start<'_, '_> {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        let Run { outside, memory, is_first, .. } = self.run;
        let value = if outside.own.is_none() && outside.sets(cell) {
            self.given.inputs.get(&cell).copied().unwrap_or(0)
        } else if outside.program.power_up.first_scan.contains(&cell) {
            u16::from(*is_first)
        } else {
            match memory.get(cell) {
                Some((value, _)) => value,
                None if outside.hides(cell, true) => outside.stated(cell),
                None => outside.program.power_up.word(cell),
            }
        };
        self.run.asked.borrow_mut().insert(cell, value);
        value
    }

    fn unknown(&mut self, cell: Cell) -> u16 {
        let outside = self.run.outside;
        let program = outside.program;
        let power_up = &program.power_up;
        let is_in = |regions: &[Region]| regions.iter().any(|region| region.holds(cell));
        if power_up.first_scan.contains(&cell) {
            return 0;
        }
        if outside.hides(cell, self.run.is_first) {
            return u16::MAX;
        }
        if outside.sets(cell) {
            return 0;
        }
        // What others write comes to the program as they please.
        if is_in(&program.volatile) || program.networks.iter().any(|(region, _)| region.holds(cell))
        {
            return u16::MAX;
        }
        match self.run.memory.get(cell) {
            Some((_, unknown)) => unknown,
            None if is_in(&power_up.cleared) => 0,
            None => u16::MAX,
        }
    }

    fn is_unseen(&self) -> bool {
        self.run.outside.own.is_some()
    }

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        if let Some(seed) = self.given.chance
            && self.run.outside.program.kinds.get(&key.choice) == Some(&ChoiceKind::World)
        {
            return at_random(seed, key);
        }
        self.given.choices.get(key).copied().unwrap_or(0)
    }

    fn timed(&mut self, timed: &Timed, found: &Found) -> Option<(bool, u16)> {
        let found = Found { now: self.run.now + found.now, ..found.clone() };
        self.run.clockwork.borrow_mut().execute(timed, &found)
    }

    fn keeps_time(&self) -> bool {
        // Where nothing is known of the outside, scans may also take longer.
        !self.is_unseen()
    }

    fn counts_time(&self) -> bool {
        self.keeps_time()
    }

    fn ran_for(&mut self, memory: Cell) -> Option<(Picos, Picos)> {
        if !self.keeps_time() {
            return None;
        }
        let (earliest, latest) = self.run.began.get(&memory).copied().unwrap_or_default();
        let since = |moment: Picos| self.run.now.checked_sub(moment).unwrap_or_default();
        Some((since(latest), since(earliest)))
    }
}

/// A value that depends on nothing but the seed and what is asked.
fn at_random(seed: u64, key: &ChoiceKey) -> u16 {
    const ODD: u64 = 0x9E37_79B9_7F4A_7C15;
    let frames = key.frames.iter().flat_map(|frame| [frame.at as u64, frame.iteration.into()]);
    let all = [u64::from(key.choice.0)].into_iter().chain(frames);
    let mixed = all.fold(seed, |mixed, part| (mixed ^ part).wrapping_mul(ODD).rotate_left(29));
    (mixed.wrapping_mul(ODD) >> 48) as u16
}

/// Whether the program reads one of these cells but where it executes a timer or counter.
fn reads(program: &Program, cells: &BTreeSet<Cell>) -> bool {
    let mut found = false;
    for (at, instruction) in program.instructions.iter().enumerate() {
        if program.timekeeping.coils.contains_key(&at) {
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
                Operand::Run(address, ..) => {
                    address.stretches.iter().any(|one| areas.contains(&one.first.area))
                }
                _ => false,
            });
        }
    }
    found
}

/// What the program may write where inputs are; words of which a bit is written count whole.
fn written(program: &Program) -> Vec<Region> {
    let inputs = &program.power_up.inputs;
    let all = (0..program.instructions.len()).flat_map(|at| flow::written(program, at));
    // Only inputs are asked for.
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

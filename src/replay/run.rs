//! Scans that follow each other from power-up on: real runs, each in the state that the one before has left.

use super::machine::{MOST_ASKED, Machine};
use super::state::State;
use super::{Free, Mode, Real};
use crate::base::time::Times;
use crate::program::{AreaKind, Cell, ChoiceKey, Program, Region, flow};
use std::collections::{BTreeMap, BTreeSet};

/// What the outside gives in one scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Given<'p> {
    /// Inputs, and what else [`Outside::sets`]; 0 where it is not named.
    pub inputs: BTreeMap<Cell, u16>,
    /// Choices in the scan; 0 where one is not named.
    pub choices: &'p BTreeMap<ChoiceKey, u16>,
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
    last: Option<State<'p, Start<'p>>>,
}

/// The values with which a scan of a run starts.
struct Start<'p> {
    outside: &'p Outside<'p>,
    given: Given<'p>,
    /// The scan before; none at power-up.
    before: Option<Box<State<'p, Start<'p>>>>,
}

impl<'p> Run<'p> {
    /// Power-up. `times` is parallel to `Program::instructions`.
    #[must_use]
    pub fn new(outside: &'p Outside<'p>, times: &'p [Times]) -> Run<'p> {
        Run { outside, times, last: None }
    }

    /// Makes the next scan, of at most `most` instructions. After one that was not followed to its end none follows.
    pub fn scan(&mut self, given: Given<'p>, most: u64) -> Real {
        let start = Start { outside: self.outside, given, before: self.last.take().map(Box::new) };
        let machine = Machine::new(self.outside.program, self.times, start, Mode::Real);
        // One run cannot try both cases of a loop that makes one iteration or none: it ends there.
        let (real, state) = machine.real_from(most, MOST_ASKED);
        self.last = Some(state);
        real
    }
}

impl Free for Start<'_> {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        if self.outside.own.is_none() && self.outside.sets(cell) {
            return self.given.inputs.get(&cell).copied().unwrap_or(0);
        }
        match &mut self.before {
            _ if self.outside.program.power_up.first_scan.contains(&cell) => {
                u16::from(self.before.is_none())
            }
            Some(before) => before.after(cell).0,
            None if self.outside.hides(cell, true) => self.outside.stated(cell),
            None => self.outside.program.power_up.word(cell),
        }
    }

    fn unknown(&mut self, cell: Cell) -> u16 {
        let program = self.outside.program;
        let power_up = &program.power_up;
        let is_in = |regions: &[Region]| regions.iter().any(|region| region.holds(cell));
        if power_up.first_scan.contains(&cell) {
            return 0;
        }
        if self.outside.hides(cell, self.before.is_none()) {
            return u16::MAX;
        }
        if self.outside.sets(cell) {
            return 0;
        }
        // What others write comes to the program as they please.
        if is_in(&program.volatile) || program.networks.iter().any(|(region, _)| region.holds(cell))
        {
            return u16::MAX;
        }
        match &mut self.before {
            Some(before) => before.after(cell).1,
            None if is_in(&power_up.cleared) => 0,
            None => u16::MAX,
        }
    }

    fn is_unseen(&self) -> bool {
        self.outside.own.is_some()
    }

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        self.given.choices.get(key).copied().unwrap_or(0)
    }
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

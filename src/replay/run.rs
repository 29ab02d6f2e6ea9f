//! Scans that follow each other from power-up on: real runs, each in the state that the one before has left.

use super::machine::{MOST_ASKED, Machine};
use super::state::State;
use super::{Free, Mode, Real};
use crate::base::time::Times;
use crate::program::{AreaKind, Cell, ChoiceKey, Program, Region, flow};
use std::collections::BTreeMap;
use std::rc::Rc;

/// What the outside gives in one scan.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Given {
    /// Inputs, and what else [`Run::sets`]; 0 where it is not named.
    pub inputs: BTreeMap<Cell, u16>,
    /// Choices in the scan; 0 where one is not named.
    pub choices: Rc<BTreeMap<ChoiceKey, u16>>,
}

/// A PLC that was switched on, and the scans that it has made.
pub struct Run<'p> {
    program: &'p Program,
    /// What each instruction costs at least.
    times: &'p [Times],
    /// What the program writes by itself.
    written: Rc<Vec<Region>>,
    last: Option<State<'p, Start<'p>>>,
}

/// The values with which a scan of a run starts.
struct Start<'p> {
    program: &'p Program,
    written: Rc<Vec<Region>>,
    given: Given,
    /// The scan before; none at power-up.
    before: Option<Box<State<'p, Start<'p>>>>,
}

impl<'p> Run<'p> {
    /// Power-up. `times` is parallel to `Program::instructions`.
    #[must_use]
    pub fn new(program: &'p Program, times: &'p [Times]) -> Run<'p> {
        Run { program, times, written: Rc::new(written(program)), last: None }
    }

    /// Whether the outside sets the cell before each scan: an input that the program leaves alone.
    #[must_use]
    pub fn sets(&self, cell: Cell) -> bool {
        is_set(self.program, &self.written, cell)
    }

    /// Makes the next scan, of at most `most` instructions. After one that was not followed to its end none follows.
    pub fn scan(&mut self, given: Given, most: u64) -> Real {
        let start = Start {
            program: self.program,
            written: self.written.clone(),
            given,
            before: self.last.take().map(Box::new),
        };
        let machine = Machine::new(self.program, self.times, start, Mode::Real);
        // One run cannot try both cases of a loop that makes one iteration or none: it ends there.
        let (real, state) = machine.real_from(most, MOST_ASKED);
        self.last = Some(state);
        real
    }
}

impl Free for Start<'_> {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        if is_set(self.program, &self.written, cell) {
            return self.given.inputs.get(&cell).copied().unwrap_or(0);
        }
        match &mut self.before {
            _ if self.program.power_up.first_scan.contains(&cell) => {
                u16::from(self.before.is_none())
            }
            Some(before) => before.after(cell).0,
            None => 0,
        }
    }

    fn unknown(&mut self, cell: Cell) -> u16 {
        let power_up = &self.program.power_up;
        let is_in = |regions: &[Region]| regions.iter().any(|region| region.holds(cell));
        if is_set(self.program, &self.written, cell) || power_up.first_scan.contains(&cell) {
            return 0;
        }
        // What others write comes to the program as they please.
        if is_in(&self.program.volatile)
            || self.program.networks.iter().any(|(region, _)| region.holds(cell))
        {
            return u16::MAX;
        }
        match &mut self.before {
            Some(before) => before.after(cell).1,
            None if is_in(&power_up.cleared) => 0,
            None => u16::MAX,
        }
    }

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        self.given.choices.get(key).copied().unwrap_or(0)
    }
}

fn is_set(program: &Program, written: &[Region], cell: Cell) -> bool {
    let inputs = &program.power_up.inputs;
    inputs.iter().any(|region| region.holds(cell))
        && !written.iter().any(|region| region.holds(cell))
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

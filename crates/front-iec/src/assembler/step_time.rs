//! Lowers step times (`STEP.T`): how long a step has been active.
//!
//! The time of an active step advances once per scan, so all readers in one scan see the same value. After the step, it
//! keeps its last value, as in the standard, or becomes 0: controllers differ.

use super::memory::{Memory, all, any};
use super::timer::{double, put};
use super::value::constant;
use super::{Assembler, OpenEnd};
use scanbound_iec::chart::Chart;
use scanbound_ir::{Cell, Logic};
use std::collections::BTreeSet;

impl Assembler {
    /// Advances the times of all active steps by any amount.
    pub(crate) fn times_go_on(&mut self, memory: &Memory) {
        for time in &memory.times {
            let (later, [found, least]) = self.later_than(time.cell);
            let active = memory.active(&time.steps);
            let at = self.write_if(active, vec![put(time.cell, double(later))], None);
            self.told(time.cell, vec![found, least, at]);
        }
    }

    /// Sets the times of the initial steps to 0 where the chart begins; on some controllers, those of all steps.
    pub(crate) fn times_begin(&mut self, memory: &Memory, begins: &Logic) {
        let ends = self.differs("the time of a step that is not active is 0");
        for time in &memory.times {
            let initial = Logic::Const(time.initial);
            let begins = all([begins.clone(), any([initial, ends.clone()])]);
            self.zero(time.cell, begins);
        }
    }

    /// Sets the times of steps that are being entered to 0, before the step flags change.
    pub(crate) fn times_of_entered(&mut self, chart: &Chart, memory: &Memory) {
        let again =
            self.differs("the time of a step restarts if the step is left and entered in one scan");
        let mut entering = vec![Vec::new(); chart.steps.len()];
        for (at, transition) in chart.transitions.iter().enumerate() {
            transition.to.iter().for_each(|&step| entering[step].push(at));
        }
        for time in &memory.times {
            let entered: BTreeSet<usize> =
                time.steps.iter().flat_map(|&step| &entering[step]).copied().collect();
            let entered = any(entered.into_iter().map(|at| Logic::cell(memory.clears[at])));
            let before = memory.active(&time.steps);
            let new = match time.steps.len() {
                1 => any([before.not(), again.clone()]),
                // A change of step within a macro step does not enter the macro step.
                _ => before.not(),
            };
            self.zero(time.cell, all([entered, new]));
        }
    }

    /// Sets the times of inactive steps to 0, on the controllers that do so.
    pub(crate) fn times_end(&mut self, memory: &Memory) {
        let ends = self.differs("the time of a step that is not active is 0");
        for time in &memory.times {
            let ended = all([memory.active(&time.steps).not(), ends.clone()]);
            self.zero(time.cell, ended);
        }
    }

    fn zero(&mut self, time: Cell, fires: Logic) {
        let at = self.write_if(fires, vec![put(time, constant(0, 2))], None);
        self.told(time, vec![at]);
    }

    fn told(&mut self, cell: Cell, own: Vec<usize>) {
        self.open_ends.push(OpenEnd::StepTime { cell, own });
    }
}

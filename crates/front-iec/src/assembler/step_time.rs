//! Lowers step times (`STEP.T`): how long a step has been active.
//!
//! The time of an active step advances once per scan, so all readers in one scan see the same value. After the step, it
//! keeps its last value, as in the standard, or becomes 0: controllers differ.

use super::memory::{Memory, all, any};
use super::timer::{double, put};
use super::value::constant;
use super::{Assembler, OpenEnd};
use scanbound_iec::chart::Chart;
use scanbound_ir::{BitTarget, Cell, Logic, Region, Write};
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

    /// Gives any value to the times of the initial steps where the chart is first executed, on the controllers where
    /// they run before that (`early`). `entered_again`: the initial steps to which a transition leads.
    pub(crate) fn times_run_early(
        &mut self,
        memory: &Memory,
        early: &Logic,
        entered_again: &[usize],
    ) {
        for time in memory.times.iter().filter(|time| time.initial) {
            if time.steps.iter().any(|step| entered_again.contains(step)) {
                let (later, [found, least]) = self.later_than(time.cell);
                let at = self.write_if(early.clone(), vec![put(time.cell, double(later))], None);
                self.told(time.cell, vec![found, least, at]);
                continue;
            }
            let any = self.words_between(2);
            let choice = self.builder.choice();
            // The step is active in one stretch only. Some controllers have only times from 0 on there, others only
            // long ones: no lower bound rests on it.
            self.program().statements.undefined_by_language.insert(choice);
            let sign = BitTarget::WordBit(any.plus(1), 15);
            let writes = vec![
                Write::Havoc(Region::Range { first: any, count: 2 }, choice),
                Write::Bit(sign, Logic::Const(false)),
            ];
            let found = self.write(writes);
            let at = self.write_if(early.clone(), vec![put(time.cell, double(any))], None);
            self.told(time.cell, vec![found, at]);
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

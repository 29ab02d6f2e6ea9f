//! Transitions that compete for a step without priorities: controllers clear only the first one that is true, or all
//! that are true.

use super::Assembler;
use super::memory::{Memory, any};
use scanbound_base::facts::{ActionOrder, Facts};
use scanbound_iec::Project;
use scanbound_iec::chart::{Chart, apart};
use scanbound_ir::{BitSource, Logic};
use scanbound_nets::Net;
use std::collections::BTreeSet;

const WHY: &str = "if several transitions after one step are true and not all have a priority, controllers fire the first (as in the standard) or all (Beremiz, OpenPLC): either ([sfc] selection states which)";

/// How competing transitions clear, as far as it is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Competing {
    /// Whether all true transitions clear. `None`: either all, or only the first.
    all_clear: Option<bool>,
    /// Whether only calls in conditions can change what conditions read during their evaluation.
    is_steady: bool,
}

impl Competing {
    pub(crate) fn new(
        project: &Project,
        facts: &Facts,
        actions_first: bool,
        tasks: usize,
    ) -> Competing {
        // All clear only on matiec, which evaluates transitions first and has its own action order.
        let may_be_matiec =
            !actions_first && matches!(facts.action_order, None | Some(ActionOrder::Declared));
        // The accessor methods of a property have a dot in their names.
        let has_properties =
            project.pous.iter().any(|pou| pou.methods.iter().any(|one| one.name.contains('.')));
        Competing {
            all_clear: facts.all_clear.or((!may_be_matiec).then_some(false)),
            is_steady: tasks == 1 && !has_properties,
        }
    }

    /// Whether several competing transitions may clear at once.
    pub(crate) fn may_all_clear(self) -> bool {
        self.all_clear != Some(false)
    }

    /// The net of a chart's steps that allows every behaviour of the controllers on which it may run.
    pub(crate) fn net(self, chart: &Chart) -> Net {
        match self.may_all_clear() {
            true => chart.net_of_all(&self.never_both(chart)),
            false => chart.net_of_any(),
        }
    }

    /// Returns a test whether the conditions of two transitions can never be true together, judged by their text alone.
    fn never_both(self, chart: &Chart) -> impl Fn(usize, usize) -> bool {
        let is_steady = self.is_steady && apart::calls_nothing(chart);
        move |one, other| {
            let condition = |at: usize| &chart.transitions[at].condition;
            is_steady && apart::never_both(condition(one), condition(other))
        }
    }
}

impl Assembler {
    /// For transition `number`: the conditions under which the earlier transitions `before`, which leave the same step,
    /// let it clear.
    pub(crate) fn rivals(
        &mut self,
        competing: Competing,
        chart: &Chart,
        memory: &Memory,
        number: usize,
        before: &BTreeSet<usize>,
    ) -> Vec<Logic> {
        if before.is_empty() {
            return Vec::new();
        }
        let never_both = competing.never_both(chart);
        let mut either = None;
        let mut found = Vec::new();
        for &other in before {
            let keeps_out = Logic::cell(memory.clears[other]).not();
            match competing.all_clear {
                _ if !chart.compete(number, other) => found.push(keeps_out),
                Some(true) => {}
                Some(false) => found.push(keeps_out),
                // Where all true transitions clear, this condition is evaluated although it is false.
                None if never_both(number, other) => {
                    let evaluated = self.extra_time();
                    found.push(any([keeps_out, evaluated]));
                }
                None => {
                    let choice = *either.get_or_insert_with(|| self.builder.choice());
                    found.push(any([keeps_out, Logic::Bit(BitSource::Free(choice))]));
                }
            }
        }
        if let Some(choice) = either {
            let at = self.builder.next();
            let program = self.program();
            program.statements.undefined_by_language.insert(choice);
            program.approximate(at, WHY);
        }
        found
    }
}

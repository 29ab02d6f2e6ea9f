//! Tasks, of which one may interrupt another.

use super::{Interrupt, Program};
use scanbound_base::time::Picos;

/// A task that calls programs: again and again, or when something happens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// Its name.
    pub name: String,
    /// How long after its beginning it begins again, where it is cyclic.
    pub interval: Option<Picos>,
    /// Its priority: 0 is the highest.
    pub priority: Option<i64>,
    /// The programs that it calls, in their order.
    pub programs: Vec<String>,
}

impl Task {
    /// Whether it interrupts another; where a priority is not known, it may.
    #[must_use]
    pub fn interrupts(&self, other: &Task) -> bool {
        self.priority.zip(other.priority).is_none_or(|(own, others)| own < others)
    }

    /// Whether another that is ready at the same time may have to wait for it.
    #[must_use]
    pub fn delays(&self, other: &Task) -> bool {
        self.priority.zip(other.priority).is_none_or(|(own, others)| own <= others)
    }
}

impl Program {
    /// The interrupt routines of which nobody states how often they come; tasks of no higher priority do not interrupt a scan.
    pub fn unstated_interrupts(&self) -> impl Iterator<Item = &Interrupt> {
        let is_task = |one: &Interrupt| self.tasks.iter().find(|task| task.name == one.name);
        let comes = move |one: &&Interrupt| {
            is_task(one).zip(self.tasks.first()).is_none_or(|(task, own)| task.interrupts(own))
        };
        self.interrupts.iter().filter(|one| !one.stated).filter(comes)
    }
}

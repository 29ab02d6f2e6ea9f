//! Tasks, some of which may interrupt others.

use scanbound_base::time::Picos;

/// A task that runs programs cyclically or at an event.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// Its name.
    pub name: String,
    /// The interval of a cyclic task.
    pub interval: Option<Picos>,
    /// Its priority; 0 is the highest.
    pub priority: Option<i64>,
    /// The programs that it runs, in order.
    pub programs: Vec<String>,
}

impl Task {
    /// Whether this task may interrupt another. If a priority is unknown, it may.
    #[must_use]
    pub fn interrupts(&self, other: &Task) -> bool {
        self.priority.zip(other.priority).is_none_or(|(own, others)| own < others)
    }

    /// Whether a task that is ready at the same time may have to wait for this one. If a priority is unknown, it may.
    #[must_use]
    pub fn delays(&self, other: &Task) -> bool {
        self.priority.zip(other.priority).is_none_or(|(own, others)| own <= others)
    }
}

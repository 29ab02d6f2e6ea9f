//! Tasks, some of which may interrupt others.

use scanbound_base::time::Picos;

/// A task that runs programs cyclically or at an event.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// The name of the task.
    pub name: String,
    /// The interval of a cyclic task; `None` if the task is not cyclic, or the interval is unknown.
    pub interval: Option<Picos>,
    /// The priority of the task; 0 is the highest. `None` if it is unknown.
    pub priority: Option<i64>,
    /// The programs that the task runs, in this order.
    pub programs: Vec<String>,
}

impl Task {
    /// Whether this task may interrupt the task `other`, because its priority is higher. True if a priority is unknown.
    #[must_use]
    pub fn interrupts(&self, other: &Task) -> bool {
        self.priority.zip(other.priority).is_none_or(|(own, others)| own < others)
    }

    /// Whether the task `other`, if it is ready at the same time, may have to wait for this one: its priority is not
    /// higher. True if a priority is unknown.
    #[must_use]
    pub fn delays(&self, other: &Task) -> bool {
        self.priority.zip(other.priority).is_none_or(|(own, others)| own <= others)
    }
}

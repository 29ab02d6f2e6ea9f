//! Sequential function charts with what they name. Steps, transitions and macro steps have the numbers that they have
//! in the chart as it is written, which says how they hang together.

pub use crate::code::StepFlag;
use crate::code::{Expr, Place, Statement};
use crate::ids::{RoutineId, VarId};
use scanbound_iec::Language;
use scanbound_iec::fault::Fault;

/// A chart.
#[derive(Debug, Clone)]
pub struct Chart {
    /// As it is written.
    pub written: scanbound_iec::chart::Chart,
    /// The steps.
    pub steps: Vec<Hooks>,
    /// The conditions of the transitions.
    pub conditions: Vec<Expr>,
    /// The actions, in the order in which blocks first name them.
    pub actions: Vec<Action>,
    /// In which order controllers execute them.
    pub orders: Orders,
    /// The variable that stops the chart in its initial state while it is true (`SFCInit`).
    pub halt: Option<VarId>,
    /// The variable that takes the chart back to its initial state (`SFCReset`).
    pub restart: Option<VarId>,
}

/// What a step executes besides its action blocks.
#[derive(Debug, Clone)]
pub struct Hooks {
    /// Once when it has ended.
    pub exit: Option<Statement>,
    /// Once when it becomes active.
    pub entry: Option<Statement>,
    /// While it is active.
    pub active: Option<Statement>,
}

/// In which order actions are executed, by their numbers. The third order is the one in which blocks first name them.
#[derive(Debug, Clone)]
pub struct Orders {
    /// As they are declared: Boolean variables first, then the unit's actions, then all others. Of a chart that is
    /// drawn as generators declare them in text.
    pub declared: Vec<usize>,
    /// Whether it is known in which order they are declared.
    pub declared_is_clear: bool,
    /// By their names.
    pub alphabetical: Vec<usize>,
}

/// An action of a chart.
#[derive(Debug, Clone)]
pub struct Action {
    /// Its name, for messages.
    pub name: String,
    /// The times of the inputs of its control.
    pub times: Vec<Option<Expr>>,
    /// How many blocks name it.
    pub blocks: usize,
    /// What is done while it is on.
    pub body: ActionBody,
    /// The line of the first block that names it.
    pub line: u32,
}

/// What an action does.
#[derive(Debug, Clone)]
pub enum ActionBody {
    /// What stands in a block itself, and its language.
    Inline(Language, Code),
    /// A Boolean variable is true.
    Variable(Place),
    /// An action is called.
    Call(Statement),
    /// The blocks of drawn conditions are executed, by a call of this action of the unit.
    Computed(Statement, RoutineId),
}

/// What is executed.
#[derive(Debug, Clone)]
pub enum Code {
    /// Statements.
    Statements(Vec<Statement>),
    /// A chart.
    Chart(Box<Chart>),
    /// What could not be read, and why.
    Unread(Fault),
}

impl Code {
    /// Whether there is nothing to execute.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        matches!(self, Code::Statements(all) if all.is_empty())
    }
}

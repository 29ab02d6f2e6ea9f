//! Resolved sequential function charts. Steps, transitions and macro steps keep the indices of the syntax tree's chart,
//! which holds the connections.

pub use crate::code::StepFlag;
use crate::code::{Expr, Place, Statement};
use crate::ids::{RoutineId, VarId};
use scanbound_iec::Language;
use scanbound_iec::fault::Fault;

/// A resolved sequential function chart.
#[derive(Debug, Clone)]
pub struct Chart {
    /// The chart of the syntax tree.
    pub written: scanbound_iec::chart::Chart,
    /// The code of each step outside its action blocks.
    pub steps: Vec<Hooks>,
    /// The condition of each transition.
    pub conditions: Vec<Expr>,
    /// The actions, in the order in which action blocks first name them.
    pub actions: Vec<Action>,
    /// The possible execution orders of the actions.
    pub orders: Orders,
    /// The Boolean variable `SFCInit`: while it is true, the chart stays in its initial state. `None` if not declared.
    pub halt: Option<VarId>,
    /// The Boolean variable `SFCReset`: while it is true, the chart returns to its initial state. `None` if not
    /// declared.
    pub restart: Option<VarId>,
    /// Another variable by which CODESYS controls a chart or tells its state, such as `SFCPause`. `None` if none is
    /// declared.
    pub other_flag: Option<&'static str>,
}

/// The code of a step outside its action blocks (CODESYS).
#[derive(Debug, Clone)]
pub struct Hooks {
    /// Runs once when the step has ended.
    pub exit: Option<Statement>,
    /// Runs once when the step becomes active.
    pub entry: Option<Statement>,
    /// Runs while the step is active.
    pub active: Option<Statement>,
}

/// The orders in which controllers may execute the actions, as indices into [`Chart::actions`]. A third possible order
/// is that of `actions` itself.
#[derive(Debug, Clone)]
pub struct Orders {
    /// The order of declaration: Boolean variables first, then the unit's actions, then all others. For a drawn chart,
    /// the order in which generators declare them in text.
    pub declared: Vec<usize>,
    /// Whether `declared` is certain to be the order of declaration.
    pub declared_is_clear: bool,
    /// By name, ignoring case: with `_` after letters and digits, and before them.
    pub alphabetical: [Vec<usize>; 2],
}

/// An action of a chart.
#[derive(Debug, Clone)]
pub struct Action {
    /// Its name, for messages.
    pub name: String,
    /// The times of its action control inputs; `None` for an input without a time.
    pub times: Vec<Option<Expr>>,
    /// The number of action blocks that name it.
    pub blocks: usize,
    /// The effect of the action.
    pub body: ActionBody,
    /// The line of the first block that names it, from 1.
    pub line: u32,
}

/// The effect of an action.
#[derive(Debug, Clone)]
pub enum ActionBody {
    /// A body written in the block itself, with its language.
    Inline(Language, Code),
    /// A Boolean variable, which is true while the action is active.
    Variable(Place),
    /// A call of an action.
    Call(Statement),
    /// A call of the action that executes the blocks in drawn conditions; the routine is that action of the unit.
    Computed(Statement, RoutineId),
}

/// The code of a routine or an inline action.
#[derive(Debug, Clone)]
pub enum Code {
    /// Statements in order.
    Statements(Vec<Statement>),
    /// A sequential function chart.
    Chart(Box<Chart>),
    /// Code that could not be read, with the reason.
    Unread(Fault),
}

impl Code {
    /// Whether it has no statements. A chart and unreadable code do not count as empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        matches!(self, Code::Statements(all) if all.is_empty())
    }
}

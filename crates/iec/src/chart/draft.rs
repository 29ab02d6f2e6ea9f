//! A chart while it is read: transitions name their steps, and nothing is checked yet.

use super::{Block, Step};
use crate::ast::Expr;

/// A transition whose steps are named.
#[derive(Debug, Clone)]
pub struct DraftTransition {
    /// Its name.
    pub name: Option<String>,
    /// The steps in front of it.
    pub from: Vec<String>,
    /// The steps behind it.
    pub to: Vec<String>,
    /// Its condition.
    pub condition: Expr,
    /// Its priority, the smallest first; without one, it comes as it stands.
    pub priority: Option<u32>,
    /// Its line.
    pub line: u32,
    /// Its number in the source.
    pub id: Option<String>,
}

/// A macro step with a chart of its own.
#[derive(Debug, Clone)]
pub struct DraftMacro {
    /// Its name.
    pub name: String,
    /// Whether it is marked as active at first.
    pub initial: bool,
    /// Its action blocks: on while one of its steps is active.
    pub blocks: Vec<Block>,
    /// Its chart.
    pub inside: Draft,
    /// How many steps stand in front of it.
    pub at: usize,
    /// Its line.
    pub line: u32,
}

/// A chart while it is read.
#[derive(Debug, Clone)]
pub struct Draft {
    /// The steps.
    pub steps: Vec<Step>,
    /// The macro steps that have charts of their own.
    pub macros: Vec<DraftMacro>,
    /// The transitions in the order of the source.
    pub transitions: Vec<DraftTransition>,
    pub(super) line: u32,
}

impl Draft {
    /// An empty chart that begins at a line.
    #[must_use]
    pub fn new(line: u32) -> Draft {
        Draft { steps: Vec::new(), macros: Vec::new(), transitions: Vec::new(), line }
    }
}

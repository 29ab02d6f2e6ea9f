//! A chart while it is read: transitions refer to steps by name, and nothing is checked yet.

use super::{Block, Step};
use crate::ast::Expr;

/// A transition that refers to steps by name.
#[derive(Debug, Clone)]
pub struct DraftTransition {
    /// Its name.
    pub name: Option<String>,
    /// The names of the preceding steps.
    pub from: Vec<String>,
    /// The names of the following steps.
    pub to: Vec<String>,
    /// Its condition.
    pub condition: Expr,
    /// Its priority; a smaller number comes first. `None`: its position in the source decides.
    pub priority: Option<u32>,
    /// Its line, from 1.
    pub line: u32,
    /// The identifier of its element in the source, if it has one.
    pub id: Option<String>,
}

/// A macro step with a chart of its own.
#[derive(Debug, Clone)]
pub struct DraftMacro {
    /// Its name.
    pub name: String,
    /// Whether it is marked as initial.
    pub initial: bool,
    /// Its action blocks, which apply while any of its steps is active.
    pub blocks: Vec<Block>,
    /// The chart that it contains.
    pub inside: Draft,
    /// The number of steps before it in the surrounding chart.
    pub at: usize,
    /// Its line, from 1.
    pub line: u32,
}

/// A chart while it is read.
#[derive(Debug, Clone, Default)]
pub struct Draft {
    /// The steps.
    pub steps: Vec<Step>,
    /// The macro steps that have charts of their own; others are in `steps`.
    pub macros: Vec<DraftMacro>,
    /// The transitions in the order of the source.
    pub transitions: Vec<DraftTransition>,
    /// [`Chart::generated`](crate::body::Chart::generated), if it is known.
    pub generated: Vec<usize>,
    pub(super) line: u32,
}

impl Draft {
    /// An empty chart that begins at this line.
    #[must_use]
    pub fn new(line: u32) -> Draft {
        Draft { line, ..Draft::default() }
    }
}

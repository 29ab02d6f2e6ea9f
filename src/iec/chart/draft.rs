//! A chart while it is read: transitions name their steps, and nothing is checked yet.

use super::expansion::{Flat, flat};
use super::{Block, Chart, Step, Transition};
use crate::base::code::Code;
use crate::iec::ast::Expr;
use crate::iec::fault::Fault;
use crate::iec::same;

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
    line: u32,
}

fn fault(line: u32, message: String, help: &str) -> Fault {
    Fault::new(line, message).code(Code::Chart).help(help)
}

impl Draft {
    /// An empty chart that begins at a line.
    #[must_use]
    pub fn new(line: u32) -> Draft {
        Draft { steps: Vec::new(), macros: Vec::new(), transitions: Vec::new(), line }
    }

    /// The chart. The charts of macro steps stand in their places.
    ///
    /// # Errors
    /// The first fault: a step that is not there, or twice, a transition without steps, no initial step, a macro step of
    /// which it is not clear where it is entered or left.
    pub fn finish(self) -> Result<Chart, Fault> {
        let line = self.line;
        let Flat { steps, mut transitions, macros } = flat(self)?;
        if !steps.iter().any(|step| step.initial) {
            let help = "mark the step that is active at first as the initial step";
            return Err(fault(line, "the chart has no initial step".to_owned(), help));
        }
        // A stable sort: what has no number stays where it is among its like, behind those that have one.
        transitions.sort_by_key(|transition| transition.priority.unwrap_or(u32::MAX));
        let place = |name: &String, line| {
            let found = steps.iter().position(|step| same(&step.name, name));
            let message = format!("a transition names the step {name}, which is not there");
            found.ok_or_else(|| fault(line, message, "name a step of the chart"))
        };
        let mut placed = Vec::new();
        for one in &transitions {
            let line = one.line;
            let places = |names: &[String]| -> Result<Vec<usize>, Fault> {
                let mut found =
                    names.iter().map(|name| place(name, line)).collect::<Result<Vec<_>, _>>()?;
                found.sort_unstable();
                found.dedup();
                Ok(found)
            };
            let (from, to) = (places(&one.from)?, places(&one.to)?);
            if from.is_empty() || to.is_empty() {
                let side = if from.is_empty() { "in front of" } else { "behind" };
                let message = format!("no step stands {side} a transition");
                return Err(fault(line, message, "let steps and transitions follow each other"));
            }
            placed.push(Transition {
                name: one.name.clone(),
                from,
                to,
                condition: one.condition.clone(),
                has_priority: one.priority.is_some(),
                line,
                id: one.id.clone(),
            });
        }
        Ok(Chart { steps, transitions: placed, macros, line, span: None })
    }
}

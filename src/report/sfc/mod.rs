//! What was found of sequential function charts, in each format.

pub mod dot;
pub mod json;
mod layout;
pub mod svg;
pub mod text;

use crate::iec::chart::Chart;
use crate::iec::chart::coactive::{Analysis, Finding, How};
use crate::iec::chart::structure::Part;

/// A chart and what was found of it.
#[derive(Debug)]
pub struct Study<'a> {
    /// What it belongs to: a unit, or an action or method in one.
    pub name: String,
    /// The file.
    pub file: &'a str,
    /// The chart.
    pub chart: &'a Chart,
    /// Its tree.
    pub structure: Part,
    /// What is active together, and what is wrong.
    pub analysis: Analysis,
}

impl Study<'_> {
    /// Whether nothing is wrong with how the chart hangs together. That a stored action is not reset in it is no fault: what
    /// it controls may be reset elsewhere.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.analysis.findings.iter().all(|finding| matches!(finding, Finding::NeverReset(..)))
    }

    fn step(&self, step: usize) -> &str {
        &self.chart.steps[step].name
    }

    fn steps(&self, steps: &[usize]) -> String {
        steps.iter().map(|&step| self.step(step)).collect::<Vec<_>>().join(", ")
    }

    /// A way from the start, told by the transitions that clear.
    fn way(&self, path: &[usize]) -> String {
        if path.is_empty() {
            return "at the start".to_owned();
        }
        let names: Vec<String> = path.iter().map(|&at| self.chart.transition_name(at)).collect();
        format!("by {}", names.join("; "))
    }

    fn how(&self, how: &How) -> String {
        match how {
            How::Parallel => "in parallel".to_owned(),
            How::SameStep => "on one step".to_owned(),
            How::Stored { by, until } if until.is_empty() => {
                format!("stored by {} and not reset", self.steps(by))
            }
            How::Stored { by, until } => {
                format!("stored by {} until {}", self.steps(by), self.steps(until))
            }
        }
    }

    fn finding(&self, finding: &Finding) -> String {
        match finding {
            Finding::EnteredTwice(step, path) => {
                format!(
                    "step {} is entered while it is active, {}",
                    self.step(*step),
                    self.way(path)
                )
            }
            Finding::NeverActive(step) => format!("step {} is never active", self.step(*step)),
            Finding::NeverClears(at) => format!(
                "transition {} never clears: the steps in front of it are never active together",
                self.chart.transition_name(*at)
            ),
            Finding::Deadlock(steps, path) if steps.is_empty() => {
                format!("no step is active any more, {}", self.way(path))
            }
            Finding::Deadlock(steps, path) => {
                format!(
                    "with {} active, nothing can clear any more, {}",
                    self.steps(steps),
                    self.way(path)
                )
            }
            Finding::NeverReset(action, by) => {
                format!(
                    "action {action} is stored by {} and not reset in this chart",
                    self.steps(by)
                )
            }
        }
    }
}

/// The name of a kind of finding.
fn kind(finding: &Finding) -> &'static str {
    match finding {
        Finding::EnteredTwice(..) => "entered-twice",
        Finding::NeverActive(_) => "never-active",
        Finding::NeverClears(_) => "never-clears",
        Finding::Deadlock(..) => "deadlock",
        Finding::NeverReset(..) => "never-reset",
    }
}

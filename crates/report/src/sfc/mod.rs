//! What was found of sequential function charts, in each format.

pub mod dot;
pub mod json;
pub mod svg;
pub mod text;

use scanbound_iec::chart::coactive::{Analysis, Finding, How, Rule, resetting, storing};
use scanbound_iec::chart::structure::Outline;
use scanbound_iec::chart::{Chart, Step, told};
use scanbound_iec::{same, show};

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
    pub structure: Outline,
    /// What is active together, and what is wrong.
    pub analysis: Analysis,
    /// By which rule competing transitions clear.
    pub rule: Rule,
    /// Blocks of other charts of the same unit that store or reset actions of this one.
    pub elsewhere: Vec<Elsewhere>,
}

/// Blocks of another chart that store or reset an action.
#[derive(Debug)]
pub struct Elsewhere {
    /// The action.
    pub action: String,
    /// Whether they reset it; else they store it.
    pub resets: bool,
    /// The chart.
    pub chart: String,
    /// The steps of the blocks.
    pub steps: Vec<String>,
}

impl Elsewhere {
    /// What other charts of a unit do with the actions that are stored or reset in one.
    #[must_use]
    pub fn of(chart: &Chart, others: &[(String, &Chart)]) -> Vec<Elsewhere> {
        let mut found = Vec::new();
        for action in chart.actions() {
            let (stores, resets) = (storing(chart, &action), resetting(chart, &action));
            // What a chart both stores and resets is its own.
            for (is_reset, is_own) in [(true, stores.is_empty()), (false, resets.is_empty())] {
                let both = !stores.is_empty() && !resets.is_empty();
                if both || is_own {
                    continue;
                }
                for (name, other) in others {
                    let own = if is_reset { resetting } else { storing };
                    let steps: Vec<String> = own(other, &action)
                        .into_iter()
                        .map(|step| other.steps[step].name.clone())
                        .collect();
                    if !steps.is_empty() {
                        let (action, chart) = (action.clone(), name.clone());
                        found.push(Elsewhere { action, resets: is_reset, chart, steps });
                    }
                }
            }
        }
        found
    }
}

impl Study<'_> {
    /// Whether nothing is wrong with how the chart hangs together. That a stored action is not reset in it is no fault:
    /// what it controls may be reset elsewhere.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.analysis.findings.iter().all(|finding| matches!(finding, Finding::NeverReset(..)))
    }

    fn step(&self, step: usize) -> &str {
        &self.chart.steps[step].name
    }

    fn steps(&self, steps: &[usize]) -> String {
        told::steps(self.chart, steps)
    }

    /// A way from the start, told by the transitions that clear.
    fn way(&self, path: &[usize]) -> String {
        told::way(self.chart, path)
    }

    /// The blocks of other charts that reset an action.
    fn reset_elsewhere(&self, action: &str) -> Option<String> {
        let own = self.elsewhere.iter().filter(|one| one.resets && same(&one.action, action));
        let told = own.map(|one| format!("{} of {}", one.steps.join(", "), one.chart));
        let told: Vec<String> = told.collect();
        (!told.is_empty()).then(|| told.join(", "))
    }

    fn how(&self, action: &str, how: &How) -> String {
        match how {
            How::Parallel => "in parallel".to_owned(),
            How::SameStep => "on one step".to_owned(),
            How::Stored { by, until } if until.is_empty() => {
                let reset = self.reset_elsewhere(action);
                let reset = reset.map_or("and not reset".to_owned(), |by| format!("until {by}"));
                format!("stored by {} {reset}", self.steps(by))
            }
            How::Stored { by, until } => {
                format!("stored by {} until {}", self.steps(by), self.steps(until))
            }
        }
    }

    fn finding(&self, finding: &Finding) -> String {
        match finding {
            Finding::NeverReset(action, by) if self.reset_elsewhere(action).is_some() => {
                let (by, other) =
                    (self.steps(by), self.reset_elsewhere(action).unwrap_or_default());
                format!("action {action} is stored here, by {by}, and reset by {other}")
            }
            other => told::finding(self.chart, other),
        }
    }
}

/// The name of a kind of finding.
fn kind(study: &Study<'_>, finding: &Finding) -> &'static str {
    match finding {
        Finding::NeverReset(action, _) if study.reset_elsewhere(action).is_some() => {
            "reset-elsewhere"
        }
        Finding::EnteredTwice(..) => "entered-twice",
        Finding::NeverActive(_) => "never-active",
        Finding::NeverClears(_) | Finding::NeverTrue(..) => "never-clears",
        Finding::Deadlock(..) => "deadlock",
        Finding::NeverReset(..) => "never-reset",
    }
}

/// What a step does: the qualifier of a block, or when an action of its own is carried out, the time, and the action.
struct Row {
    qualifier: &'static str,
    time: Option<String>,
    action: String,
}

/// All that a step does.
fn rows(step: &Step) -> impl Iterator<Item = Row> + '_ {
    let own = [("entry", &step.entry), ("active", &step.active), ("exit", &step.exit)];
    let own = own.into_iter().filter_map(|(qualifier, path)| {
        Some(Row { qualifier, time: None, action: show::path(path.as_ref()?) })
    });
    own.chain(step.blocks.iter().map(|block| Row {
        qualifier: block.qualifier.name(),
        time: block.time.as_ref().map(show::expr),
        action: block.target.name(),
    }))
}

//! Descriptions of a chart's findings for messages.

use super::coactive::Finding;
use super::{Chart, Transition};

/// The names of steps, separated by commas.
#[must_use]
pub fn steps(chart: &Chart, steps: &[usize]) -> String {
    steps.iter().map(|&step| chart.steps[step].name.as_str()).collect::<Vec<_>>().join(", ")
}

/// A path from the initial situation, described by the transitions that fire.
#[must_use]
pub fn way(chart: &Chart, path: &[usize]) -> String {
    if path.is_empty() {
        return "at the start".to_owned();
    }
    let mut told = String::new();
    let mut before: Option<&Transition> = None;
    for &at in path {
        let one = &chart.transitions[at];
        let is_plain = |one: &Transition| one.name.is_none();
        match before {
            Some(last) if is_plain(last) && is_plain(one) && last.to == one.from => {
                told += &format!(" -> {}", steps(chart, &one.to));
            }
            _ => {
                told += if before.is_some() { "; " } else { "" };
                told += &chart.transition_name(at);
            }
        }
        before = Some(one);
    }
    format!("by {told}")
}

/// The message of a finding.
#[must_use]
pub fn finding(chart: &Chart, finding: &Finding) -> String {
    let name = |step: usize| &chart.steps[step].name;
    let transition = |at: usize| chart.transition_name(at);
    match finding {
        Finding::EnteredTwice(step, path) => {
            format!("step {} is entered while it is active, {}", name(*step), way(chart, path))
        }
        Finding::NeverActive(step) => format!("step {} is never active", name(*step)),
        Finding::NeverClears(at) => format!(
            "transition {} never clears: the steps before it are never active together",
            transition(*at)
        ),
        Finding::NeverTrue(at, flags) => format!(
            "transition {} never clears: its condition requires {} while the steps before it are active, which never happens",
            transition(*at),
            asked(chart, flags)
        ),
        Finding::Deadlock(dead, path) if dead.is_empty() => {
            format!("no step is active any more, {}", way(chart, path))
        }
        Finding::Deadlock(dead, path) => format!(
            "with {} active, no transition can clear any more, {}",
            steps(chart, dead),
            way(chart, path)
        ),
        Finding::NeverReset(action, by) => {
            let by = steps(chart, by);
            format!("action {action} is stored by {by} and not reset in this chart")
        }
    }
}

/// The step flags that a condition requires, joined by AND.
fn asked(chart: &Chart, flags: &[(usize, bool)]) -> String {
    let one = |&(step, is_asked): &(usize, bool)| {
        let not = if is_asked { "" } else { "NOT " };
        format!("{not}{}.X", chart.steps[step].name)
    };
    flags.iter().map(one).collect::<Vec<_>>().join(" AND ")
}

/// The steps that a finding concerns, and the path that leads to it, if it has one.
#[must_use]
pub fn concerns<'a>(chart: &Chart, finding: &'a Finding) -> (Vec<usize>, Option<&'a [usize]>) {
    match finding {
        Finding::EnteredTwice(step, path) => (vec![*step], Some(path)),
        Finding::NeverActive(step) => (vec![*step], None),
        Finding::NeverClears(at) | Finding::NeverTrue(at, _) => {
            (chart.transitions[*at].from.clone(), None)
        }
        Finding::Deadlock(steps, path) => (steps.clone(), Some(path)),
        Finding::NeverReset(_, by) => (by.clone(), None),
    }
}

/// The line of a finding, from 1.
#[must_use]
pub fn line(chart: &Chart, finding: &Finding) -> u32 {
    match finding {
        Finding::NeverClears(at) | Finding::NeverTrue(at, _) => chart.transitions[*at].line,
        Finding::NeverReset(action, _) => {
            let mut stores = chart.blocks_of(action).filter(|(_, one)| one.qualifier.is_stored());
            stores.next().map_or(chart.line, |(_, block)| block.line)
        }
        other => {
            concerns(chart, other).0.first().map_or(chart.line, |&step| chart.steps[step].line)
        }
    }
}

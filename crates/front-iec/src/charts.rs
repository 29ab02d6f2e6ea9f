//! Findings about SFC charts by themselves, whether or not a program runs them.

use super::lower::{SourceTraits, decode};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_iec::Project;
use scanbound_iec::chart::coactive::{BUDGET, Finding, faults};
use scanbound_iec::chart::{Chart, told};

/// Warns of each step that can be entered while it is active (the chart is not safe), and of each deadlock, where no
/// transition can ever clear again.
#[must_use]
pub fn hang(project: &Project) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for (name, pou, chart) in project.charts() {
        for finding in faults(chart, BUDGET) {
            let help = match finding {
                Finding::EnteredTwice(..) => {
                    "the bound assumes that all its steps may be active together: join its branches as they began"
                }
                Finding::Deadlock(..) => {
                    "the chart stays there for ever: add a transition out of it, or join its parallel branches"
                }
                _ => continue,
            };
            let message = format!("{name}: {}", told::finding(chart, &finding));
            let line = told::line(chart, &finding);
            let file = &project.files[pou.file];
            found.push(Diagnostic::line(Code::Chart, file, line, "", message, help).warning());
        }
    }
    found
}

/// Warns of the faults that an audit would report in charts: faults in conditions and action blocks, and undeclared
/// names anywhere in the project. It also lowers function blocks with charts that no program has an instance of.
#[must_use]
pub fn refused(project: &Project, facts: &Facts) -> Vec<Diagnostic> {
    let charts = project.charts();
    let mut own = project.clone();
    own.inherit_parts();
    own.tasks.clear();
    own.connected.clear();
    let asked = scanbound_front::Options::new(facts);
    let Err(all) = decode(&own, "", SourceTraits::default(), true, &asked) else {
        return Vec::new();
    };
    let mut found: Vec<Diagnostic> = Vec::new();
    for mut one in all {
        let here = charts.iter().filter(|(_, pou, _)| project.files[pou.file] == one.file);
        let place = here.filter_map(|(name, _, chart)| place(name, chart, &one)).next();
        if place.is_none() && one.code != Code::UnknownName {
            continue;
        }
        if let Some(place) = place {
            let why = one.message.split_once(": ").map_or(&one.message[..], |(_, why)| why);
            one.message = format!("{place}: {why}");
        }
        let is_known = |other: &Diagnostic| {
            (&other.file, other.line, &other.text) == (&one.file, one.line, &one.text)
        };
        if !found.iter().any(is_known) {
            found.push(one.warning());
        }
    }
    found
}

/// Names the transition or action block of a chart in the line of a fault, as `chart, step NAME` or `chart, transition
/// NAME`. None if the fault has no line, or the chart has nothing in that line.
fn place(name: &str, chart: &Chart, fault: &Diagnostic) -> Option<String> {
    let line = fault.line?;
    let transitions = 0..chart.transitions.len();
    let mut transitions = transitions.filter(|&at| chart.transitions[at].line == line);
    let blocks = chart.steps.iter().flat_map(|step| step.blocks.iter().map(move |one| (step, one)));
    let mut blocks = blocks.filter(|(_, block)| block.line == line);
    // Where several elements are on one line, the fault's text decides: it is the block's name.
    let named = blocks.clone().find(|(_, block)| block.target.name() == fault.text);
    if let Some((step, _)) = named {
        return Some(format!("{name}, step {}", step.name));
    }
    if let Some(at) = transitions.next() {
        return Some(format!("{name}, transition {}", chart.transition_name(at)));
    }
    blocks.next().map(|(step, _)| format!("{name}, step {}", step.name))
}

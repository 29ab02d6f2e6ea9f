//! Charts as JSON.

use super::{Study, kind};
use crate::iec::chart::coactive::{Basis, How, Other};
use crate::iec::chart::structure::Part;
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};

/// The document.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Report<'a> {
    schema: &'static str,
    charts: Vec<One<'a>>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct One<'a> {
    name: &'a str,
    file: &'a str,
    line: u32,
    steps: Vec<Step<'a>>,
    transitions: Vec<Transition<'a>>,
    macros: Vec<Macro<'a>>,
    structure: String,
    basis: &'static str,
    markings: usize,
    together: Vec<Together<'a>>,
    findings: Vec<Found>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Step<'a> {
    name: &'a str,
    initial: bool,
    line: u32,
    actions: Vec<Block>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Block {
    action: String,
    qualifier: &'static str,
    time: Option<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Transition<'a> {
    name: String,
    from: Vec<&'a str>,
    to: Vec<&'a str>,
    condition: String,
    line: u32,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Macro<'a> {
    name: &'a str,
    steps: Vec<&'a str>,
    line: u32,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Together<'a> {
    action: &'a str,
    step: Option<&'a str>,
    other: Option<&'a str>,
    how: &'static str,
    stored_by: Vec<&'a str>,
    reset_by: Vec<&'a str>,
    path: Option<Vec<String>>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Found {
    kind: &'static str,
    message: String,
}

/// Writes the document.
///
/// # Errors
/// Where it cannot be written.
pub fn write(studies: &[Study<'_>], out: &mut dyn Write) -> io::Result<()> {
    let charts = studies.iter().map(one).collect();
    serde_json::to_writer_pretty(&mut *out, &Report { schema: "scanbound.sfc/1", charts })?;
    writeln!(out)
}

fn one<'a>(study: &'a Study<'_>) -> One<'a> {
    let names =
        |steps: &[usize]| -> Vec<&'a str> { steps.iter().map(|&step| study.step(step)).collect() };
    let ways = |path: &[usize]| path.iter().map(|&at| study.chart.transition_name(at)).collect();
    let steps = study.chart.steps.iter().map(|step| Step {
        name: &step.name,
        initial: step.initial,
        line: step.line,
        actions: step
            .blocks
            .iter()
            .map(|block| Block {
                action: block.target.name(),
                qualifier: block.qualifier.name(),
                time: block.time.as_ref().map(crate::iec::show::expr),
            })
            .collect(),
    });
    let transitions = study.chart.transitions.iter().enumerate().map(|(at, one)| Transition {
        name: study.chart.transition_name(at),
        from: names(&one.from),
        to: names(&one.to),
        condition: crate::iec::show::expr(&one.condition),
        line: one.line,
    });
    let macros = study.chart.macros.iter().map(|one| Macro {
        name: &one.name,
        steps: names(&one.steps),
        line: one.line,
    });
    let together = study.analysis.pairs.iter().map(|pair| {
        let (how, stored_by, reset_by) = match &pair.how {
            How::Parallel => ("parallel", Vec::new(), Vec::new()),
            How::SameStep => ("same-step", Vec::new(), Vec::new()),
            How::Stored { by, until } => ("stored", names(by), names(until)),
        };
        let (step, other) = match &pair.other {
            Other::Step(step) => (Some(study.step(*step)), None),
            Other::Action(action) => (None, Some(action.as_str())),
        };
        let path = pair.path.as_deref().map(ways);
        Together { action: &pair.action, step, other, how, stored_by, reset_by, path }
    });
    let (basis, markings) = match study.analysis.basis {
        Basis::Markings(count) => ("markings", count),
        Basis::Invariants(count) => ("invariants", count),
        Basis::Unsafe(count) => ("unsafe", count),
    };
    let found = |finding| Found { kind: kind(finding), message: study.finding(finding) };
    One {
        name: &study.name,
        file: study.file,
        line: study.chart.line,
        steps: steps.collect(),
        transitions: transitions.collect(),
        macros: macros.collect(),
        structure: tree(study, &study.structure),
        basis,
        markings,
        together: together.collect(),
        findings: study.analysis.findings.iter().map(found).collect(),
    }
}

/// The tree on one line: `loop(sequence(..))`.
fn tree(study: &Study<'_>, part: &Part) -> String {
    let all = |name: &str, parts: &[Part]| {
        let inner: Vec<String> =
            parts.iter().map(|part| tree(study, part)).filter(|text| !text.is_empty()).collect();
        format!("{name}({})", inner.join(", "))
    };
    match part {
        Part::Step(step) => study.step(*step).to_owned(),
        Part::Transition(_) => String::new(),
        Part::Sequence(parts) => all("sequence", parts),
        Part::Selection(parts) => all("selection", parts),
        Part::Parallel(parts) => all("parallel", parts),
        Part::Loop(body, back) => all("loop", &[(**body).clone(), (**back).clone()]),
        Part::Tangle(parts) => all("not-nested", parts),
    }
}

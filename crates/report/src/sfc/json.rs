//! Charts as JSON.

use super::{Row, Study, kind, rows};
use scanbound_iec::chart::coactive::{Basis, How, Other, Rule};
use scanbound_iec::chart::structure::Part;
use scanbound_iec::chart::told;
use schemars::JsonSchema;
use serde::Serialize;
use std::borrow::Cow;
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
    structure: Tree<'a>,
    jumps: Vec<String>,
    rule: &'static str,
    basis: &'static str,
    markings: usize,
    together: Vec<Together<'a>>,
    findings: Vec<Found<'a>>,
    elsewhere: Vec<OtherChart<'a>>,
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

/// A part of the tree: a step or a transition with its name, or one that consists of others.
#[derive(Debug, Serialize, JsonSchema)]
struct Tree<'a> {
    kind: Kind,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<Cow<'a, str>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    children: Vec<Tree<'a>>,
}

/// What a part of the tree is.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Step,
    Transition,
    Sequence,
    Selection,
    Parallel,
    /// What is gone through, and the way from its end to its beginning.
    Loop,
    /// What is gone through, and a way from its end that does not come back into what nests.
    Exit,
    /// Parts to which only jumps lead from the others.
    Apart,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Found<'a> {
    kind: &'static str,
    message: String,
    steps: Vec<&'a str>,
    line: u32,
    path: Option<Vec<String>>,
}

/// What another chart of the unit does with an action of this one.
#[derive(Debug, Serialize, JsonSchema)]
struct OtherChart<'a> {
    action: &'a str,
    does: &'static str,
    chart: &'a str,
    steps: &'a [String],
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
        actions: rows(step)
            .map(|Row { qualifier, time, action }| Block { action, qualifier, time })
            .collect(),
    });
    let transitions = study.chart.transitions.iter().enumerate().map(|(at, one)| Transition {
        name: study.chart.transition_name(at),
        from: names(&one.from),
        to: names(&one.to),
        condition: scanbound_iec::show::expr(&one.condition),
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
        Basis::Open(count) => ("open", count),
        Basis::Unsafe(count) => ("unsafe", count),
    };
    let rule = match study.rule {
        Rule::One => "one",
        Rule::All => "all",
    };
    let found = |finding| {
        let (steps, path) = told::concerns(study.chart, finding);
        Found {
            kind: kind(study, finding),
            message: study.finding(finding),
            line: told::line(study.chart, finding),
            steps: names(&steps),
            path: path.map(ways),
        }
    };
    One {
        name: &study.name,
        file: study.file,
        line: study.chart.line,
        steps: steps.collect(),
        transitions: transitions.collect(),
        macros: macros.collect(),
        structure: tree(study, &study.structure.part),
        jumps: ways(&study.structure.jumps),
        rule,
        basis,
        markings,
        together: together.collect(),
        findings: study.analysis.findings.iter().map(found).collect(),
        elsewhere: study
            .elsewhere
            .iter()
            .map(|one| OtherChart {
                action: &one.action,
                does: if one.resets { "resets" } else { "stores" },
                chart: &one.chart,
                steps: &one.steps,
            })
            .collect(),
    }
}

fn tree<'a>(study: &'a Study<'_>, part: &Part) -> Tree<'a> {
    let named = |kind, name| Tree { kind, name: Some(name), children: Vec::new() };
    let all = |kind, parts: &[&Part]| {
        let children = parts.iter().map(|part| tree(study, part)).collect();
        Tree { kind, name: None, children }
    };
    let these = |kind, parts: &[Part]| all(kind, &parts.iter().collect::<Vec<_>>());
    match part {
        Part::Step(step) => named(Kind::Step, study.step(*step).into()),
        Part::Transition(at) => named(Kind::Transition, study.chart.transition_name(*at).into()),
        Part::Sequence(parts) => these(Kind::Sequence, parts),
        Part::Selection(parts) => these(Kind::Selection, parts),
        Part::Parallel(parts) => these(Kind::Parallel, parts),
        Part::Loop(body, back) => all(Kind::Loop, &[body, back]),
        Part::Exit(body, way) => all(Kind::Exit, &[body, way]),
        Part::Tangle(parts) => these(Kind::Apart, parts),
    }
}

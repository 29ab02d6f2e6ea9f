//! Charts for the terminal.

use super::Study;
use crate::iec::chart::coactive::{Basis, Other, Pair};
use crate::iec::chart::structure::Part;
use std::fmt::Write;

/// All that was found, chart by chart.
#[must_use]
pub fn render(studies: &[Study<'_>]) -> String {
    let all: Vec<String> = studies.iter().map(one).collect();
    all.join("\n")
}

fn one(study: &Study<'_>) -> String {
    let chart = study.chart;
    let mut text = String::new();
    let basis = match study.analysis.basis {
        Basis::Markings(1) => "1 marking".to_owned(),
        Basis::Markings(count) => format!("{count} markings"),
        Basis::Invariants(count) => {
            format!(
                "more than {count} markings: what is apart is known by place invariants, the rest may be together"
            )
        }
        Basis::Unsafe(_) => "not safe: anything may be active together".to_owned(),
    };
    let [selections, parallels, loops] = study.structure.count();
    let _ = writeln!(text, "chart {}  {}:{}", study.name, study.file, chart.line);
    let _ = writeln!(
        text,
        "  {}, {}; {}, {}, {}; {basis}",
        counted(chart.steps.len(), "step"),
        counted(chart.transitions.len(), "transition"),
        counted(loops, "loop"),
        counted(selections, "selection"),
        counted(parallels, "parallel"),
    );
    if !chart.macros.is_empty() {
        text += "  macro steps\n";
    }
    for one in &chart.macros {
        let _ = writeln!(text, "    {}: {}", one.name, study.steps(&one.steps));
    }
    text += "  structure\n";
    part(study, &study.structure, 2, &mut text);
    if !study.analysis.pairs.is_empty() {
        text += "  active together\n";
    }
    let mut pairs = &study.analysis.pairs[..];
    while let Some(first) = pairs.first() {
        // Those of one action that come about in the same way are told together, with the way to the first.
        let alike = |pair: &&Pair| {
            pair.action == first.action && pair.how == first.how && is_step(pair) == is_step(first)
        };
        let count = pairs.iter().take_while(alike).count();
        let others: Vec<String> = pairs[..count].iter().map(|pair| name(study, pair)).collect();
        let what = match (is_step(first), count) {
            (true, 1) => "step",
            (true, _) => "steps",
            (false, 1) => "action",
            (false, _) => "actions",
        };
        let way =
            first.path.as_ref().map(|path| format!(" ({})", study.way(path))).unwrap_or_default();
        let how = study.how(&first.how);
        let _ = writeln!(
            text,
            "    action {} and {what} {}: {how}{way}",
            first.action,
            others.join(", ")
        );
        pairs = &pairs[count..];
    }
    if !study.analysis.findings.is_empty() {
        text += "  to look at\n";
    }
    for finding in &study.analysis.findings {
        let _ = writeln!(text, "    {}", study.finding(finding));
    }
    text
}

fn is_step(pair: &Pair) -> bool {
    matches!(pair.other, Other::Step(_))
}

fn name(study: &Study<'_>, pair: &Pair) -> String {
    match &pair.other {
        Other::Step(step) => study.step(*step).to_owned(),
        Other::Action(action) => action.clone(),
    }
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn part(study: &Study<'_>, one: &Part, level: usize, text: &mut String) {
    let pad = "  ".repeat(level);
    let mut group = |name: &str, parts: &[Part]| {
        let _ = writeln!(text, "{pad}{name}");
        parts.iter().for_each(|inner| part(study, inner, level + 1, text));
    };
    match one {
        Part::Step(step) => {
            let blocks = study.chart.steps[*step].blocks.iter().map(|block| {
                let time =
                    block.time.as_ref().map(|time| format!(" {}", crate::iec::show::expr(time)));
                format!(
                    "{} {}{}",
                    block.qualifier.name(),
                    block.target.name(),
                    time.unwrap_or_default()
                )
            });
            let blocks: Vec<String> = blocks.collect();
            let blocks = if blocks.is_empty() {
                String::new()
            } else {
                format!("  [{}]", blocks.join(", "))
            };
            let _ = writeln!(text, "{pad}{}{blocks}", study.step(*step));
        }
        // A transition is told where nothing else is on the way.
        Part::Transition(_) => {}
        Part::Sequence(parts) => parts.iter().for_each(|inner| part(study, inner, level, text)),
        Part::Selection(parts) => branches(study, "selection", parts, level, text),
        Part::Parallel(parts) => branches(study, "parallel", parts, level, text),
        Part::Loop(body, back) => group("loop", &[(**body).clone(), (**back).clone()]),
        Part::Tangle(parts) => group("not nested", parts),
    }
}

fn branches(study: &Study<'_>, name: &str, parts: &[Part], level: usize, text: &mut String) {
    let pad = "  ".repeat(level);
    let _ = writeln!(text, "{pad}{name}");
    for (number, inner) in parts.iter().enumerate() {
        let _ = writeln!(text, "{pad}  branch {}", number + 1);
        let before = text.len();
        part(study, inner, level + 2, text);
        if text.len() == before {
            let _ = writeln!(text, "{pad}    straight on");
        }
    }
}

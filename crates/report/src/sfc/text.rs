//! Charts for the terminal.

use super::{Study, rows};
use crate::wrap;
use scanbound_iec::chart::coactive::{Basis, How, Other, Pair, Rule, resetting};
use scanbound_iec::chart::structure::Part;
use scanbound_iec::show;
use std::fmt::Write;

/// How wide the page is.
const WIDTH: usize = 80;

/// All that was found, chart by chart.
#[must_use]
pub fn render(studies: &[Study<'_>]) -> String {
    let all: Vec<String> = studies.iter().map(one).collect();
    all.join("\n")
}

/// A paragraph whose further lines stand a little to the right.
fn told(indent: usize, text: &str, into: &mut String) {
    for (number, line) in wrap::lines(text, WIDTH - indent - 2).iter().enumerate() {
        let indent = indent + if number == 0 { 0 } else { 2 };
        let _ = writeln!(into, "{}{}", " ".repeat(indent), line.trim());
    }
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
        Basis::Open(count) => {
            format!("more than {count} markings: anything may be active together")
        }
        Basis::Unsafe(_) => "not safe: anything may be active together".to_owned(),
    };
    let rule = match study.rule {
        _ if !chart.competes() => "",
        Rule::One => "; of competing transitions one clears",
        Rule::All => "; of competing transitions all clear that are true",
    };
    let [selections, parallels, loops] = study.structure.count();
    let _ = writeln!(text, "chart {}  {}:{}", study.name, study.file, chart.line);
    let counts = format!(
        "{}, {}; {}, {}, {}; {basis}{rule}",
        counted(chart.steps.len(), "step"),
        counted(chart.transitions.len(), "transition"),
        counted(loops, "loop"),
        counted(selections, "selection"),
        counted(parallels, "parallel"),
    );
    told(2, &counts, &mut text);
    if !chart.macros.is_empty() {
        text += "  macro steps\n";
    }
    for one in &chart.macros {
        told(4, &format!("{}: {}", one.name, study.steps(&one.steps)), &mut text);
    }
    text += "  structure\n";
    part(study, &study.structure.part, 2, &mut text);
    across(study, &mut text);
    together(study, &mut text);
    if !study.analysis.findings.is_empty() {
        text += "  to look at\n";
    }
    // What is stored here and reset elsewhere is told as a finding.
    let stored = study.elsewhere.iter().filter(|one| !one.resets).map(|one| {
        let resets = resetting(chart, &one.action);
        let (action, by, steps) = (&one.action, study.steps(&resets), one.steps.join(", "));
        format!("action {action} is reset here, by {by}, and stored by {steps} of {}", one.chart)
    });
    let stored: Vec<String> = stored.collect();
    if study.analysis.findings.is_empty() && !stored.is_empty() {
        text += "  to look at\n";
    }
    stored.iter().for_each(|one| told(4, one, &mut text));
    for finding in &study.analysis.findings {
        let line = scanbound_iec::chart::told::line(chart, finding);
        told(4, &format!("{} (line {line})", study.finding(finding)), &mut text);
    }
    text
}

/// Of a chart that does not nest: what breaks the nesting, and all ways.
fn across(study: &Study<'_>, text: &mut String) {
    let jumps = &study.structure.jumps;
    if jumps.is_empty() {
        return;
    }
    text.push_str("  does not nest for\n");
    jumps.iter().for_each(|&at| told(4, &transition(study, at), text));
    text.push_str("  all ways\n");
    let order = study.structure.part.steps();
    let place = |at: &usize| {
        let from = study.chart.transitions[*at].from.iter();
        from.map(|step| order.iter().position(|one| one == step)).max()
    };
    let mut all: Vec<usize> = (0..study.chart.transitions.len()).collect();
    all.sort_by_key(place);
    all.iter().for_each(|&at| told(4, &transition(study, at), text));
}

/// From where to where a transition leads, and its condition.
fn transition(study: &Study<'_>, at: usize) -> String {
    let one = &study.chart.transitions[at];
    let condition = show::expr(&one.condition);
    let name = one.name.as_ref().filter(|name| **name != condition);
    let name = name.map(|name| format!("{name}: ")).unwrap_or_default();
    format!("{} -> {}  [{name}{condition}]", study.steps(&one.from), study.steps(&one.to))
}

/// Pairs that come about in the same way.
struct Group<'a> {
    how: &'a How,
    path: Option<&'a Vec<usize>>,
    steps: Vec<&'a str>,
    actions: Vec<&'a str>,
}

/// What can be active together, by action; ways that lead there are told once.
fn together(study: &Study<'_>, text: &mut String) {
    let mut pairs = &study.analysis.pairs[..];
    if pairs.is_empty() {
        return;
    }
    text.push_str("  active together\n");
    let mut ways: Vec<&Vec<usize>> = Vec::new();
    while let Some(first) = pairs.first() {
        let count = pairs.iter().take_while(|pair| pair.action == first.action).count();
        let groups = grouped(study, &pairs[..count]);
        pairs = &pairs[count..];
        told(4, &first.action, text);
        for group in groups {
            let list = |one: &str, names: &[&str]| match names.len() {
                0 => None,
                1 => Some(format!("{one} {}", names[0])),
                _ => Some(format!("{one}s {}", names.join(", "))),
            };
            let lists = [list("step", &group.steps), list("action", &group.actions)];
            let lists: Vec<String> = lists.into_iter().flatten().collect();
            let way = group.path.map(|path| {
                let known = ways.iter().position(|one| *one == path).unwrap_or_else(|| {
                    ways.push(path);
                    ways.len() - 1
                });
                format!(" (way {})", known + 1)
            });
            let how = study.how(&first.action, group.how);
            told(6, &format!("{how}{}: {}", way.unwrap_or_default(), lists.join("; ")), text);
        }
    }
    if !ways.is_empty() {
        text.push_str("  ways there, each to the first of those that it is told with\n");
    }
    for (number, way) in ways.into_iter().enumerate() {
        told(4, &format!("{}: {}", number + 1, study.way(way)), text);
    }
}

/// Those of one action that come about in the same way, with the way to the first.
fn grouped<'a>(study: &'a Study<'_>, pairs: &'a [Pair]) -> Vec<Group<'a>> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    for pair in pairs {
        let at = groups.iter().position(|one| *one.how == pair.how).unwrap_or_else(|| {
            let (how, steps, actions) = (&pair.how, Vec::new(), Vec::new());
            groups.push(Group { how, path: None, steps, actions });
            groups.len() - 1
        });
        let group = &mut groups[at];
        group.path = group.path.or(pair.path.as_ref());
        match &pair.other {
            Other::Step(step) => group.steps.push(study.step(*step)),
            Other::Action(action) => group.actions.push(action),
        }
    }
    groups
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn part(study: &Study<'_>, one: &Part, level: usize, text: &mut String) {
    let pad = "  ".repeat(level);
    match one {
        Part::Step(step) => {
            let blocks = rows(&study.chart.steps[*step]).map(|row| {
                let time = row.time.map(|time| format!(" {time}")).unwrap_or_default();
                format!("{} {}{time}", row.qualifier, row.action)
            });
            let blocks: Vec<String> = blocks.collect();
            let blocks = if blocks.is_empty() {
                String::new()
            } else {
                format!("  [{}]", blocks.join(", "))
            };
            told(2 * level, &format!("{}{blocks}", study.step(*step)), text);
        }
        // A transition is told where nothing else is on the way.
        Part::Transition(_) => {}
        Part::Sequence(parts) => parts.iter().for_each(|inner| part(study, inner, level, text)),
        Part::Selection(parts) => branches(study, "selection", parts, level, text),
        Part::Parallel(parts) => branches(study, "parallel", parts, level, text),
        Part::Loop(body, back) => {
            let _ = writeln!(text, "{pad}loop");
            part(study, body, level + 1, text);
            part(study, back, level + 1, text);
        }
        Part::Exit(body, way) => {
            part(study, body, level, text);
            let to: Vec<String> =
                way.last().iter().map(|&at| study.steps(&study.chart.transitions[at].to)).collect();
            let before = text.len();
            let _ = writeln!(text, "{pad}or");
            let head = text.len();
            part(study, way, level + 1, text);
            if let Some(to) = to.first() {
                let jump = format!("jump to {to}");
                if text.len() == head {
                    text.truncate(before);
                    told(2 * level, &format!("or {jump}"), text);
                } else {
                    told(2 * level + 2, &jump, text);
                }
            }
        }
        Part::Tangle(parts) => {
            branches(study, "apart, reached by what does not nest", parts, level, text)
        }
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

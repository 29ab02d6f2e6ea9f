//! How the groups' maxima were found, as text: a line for the report, and a search step by step.

use super::columns::{columns, left, right};
use scanbound_audit::method::{ConditionUse, Step, TraceUse};
use scanbound_audit::{Audit, Engine, GroupUse, Opinion, SUBSET_SOLVER};
use scanbound_base::time::Picos;
use std::time::Duration;
use unicode_width::UnicodeWidthStr;

/// Lines of a trace are no longer than this, but for names that are.
const WIDTH: usize = 80;

/// Answers begin in this column.
const ANSWERS: usize = 36;

/// How much of a trace is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Groups.
    pub groups: usize,
    /// Conditions of a group.
    pub conditions: usize,
    /// Steps of a group.
    pub steps: usize,
}

/// What a terminal shows.
pub const TERMINAL: Extent = Extent { groups: 12, conditions: 40, steps: 200 };

/// What a file holds.
pub const FILE: Extent = Extent { groups: usize::MAX, conditions: 200, steps: usize::MAX };

/// Which search found the groups' maxima, in one line; `None` if there are no groups.
pub fn searched(audit: &Audit) -> Option<String> {
    let by = |engine: Engine| -> Vec<&GroupUse> {
        audit.groups.iter().filter(|group| group.search.engine == engine).collect()
    };
    let (subsets, cores) = (by(Engine::Subsets), by(Engine::Cores));
    Some(match (subsets.is_empty(), cores.is_empty()) {
        (true, true) => return None,
        (false, true) => format!("{} by subsets, on {SUBSET_SOLVER}", all(&subsets)),
        (true, false) => format!("{} by unsatisfiable cores, on BatSat", all(&cores)),
        (false, false) => format!(
            "{} by unsatisfiable cores, on BatSat; {} by subsets, on {SUBSET_SOLVER}",
            numbers(&cores),
            numbers(&subsets)
        ),
    })
}

/// What Z3 says of the groups' maxima, in one line; `None` if it was not asked.
pub fn confirmed(audit: &Audit) -> Option<String> {
    let of = |opinion: Opinion| -> Vec<&GroupUse> {
        audit.groups.iter().filter(|group| group.search.opinion == Some(opinion)).collect()
    };
    let confirmed = of(Opinion::Confirmed);
    let open: Vec<String> = [
        (of(Opinion::TooLarge), "too large to ask"),
        (of(Opinion::RanOut), "not answered within its budget"),
        (of(Opinion::NoSolver), "not asked, since this build has no Z3"),
    ]
    .into_iter()
    .filter(|(groups, _)| !groups.is_empty())
    .map(|(groups, why)| format!("{}: {why}", numbers(&groups)))
    .collect();
    let said = "no scan costs a picosecond more, the best one costs what is said";
    match (confirmed.len(), open.is_empty()) {
        (0, true) => None,
        (0, false) => Some(format!("by Z3: none; {}", open.join("; "))),
        (_, true) => Some(format!("by Z3: {} ({said})", all(&confirmed))),
        _ => Some(format!("by Z3: {} ({said}); {}", numbers(&confirmed), open.join("; "))),
    }
}

fn all(groups: &[&GroupUse]) -> String {
    match groups.len() {
        1 => format!("group {}", groups[0].id),
        2 => "both groups".to_owned(),
        count => format!("all {count} groups"),
    }
}

/// "group 1", "groups 1, 3 to 7": the first few, and how many more there are.
fn numbers(groups: &[&GroupUse]) -> String {
    let mut ranges: Vec<(usize, usize)> = Vec::new();
    for id in groups.iter().map(|group| group.id) {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == id => *last = id,
            _ => ranges.push((id, id)),
        }
    }
    let shown: Vec<String> = ranges
        .iter()
        .take(4)
        .map(|&(first, last)| match last - first {
            0 => first.to_string(),
            1 => format!("{first}, {last}"),
            _ => format!("{first} to {last}"),
        })
        .collect();
    let more: usize = ranges.iter().skip(4).map(|(first, last)| last - first + 1).sum();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let word = if groups.len() == 1 { "group" } else { "groups" };
    format!("{word} {}{more}", shown.join(", "))
}

/// The searches of an audit's groups, step by step.
#[must_use]
pub fn trace(audit: &Audit, extent: Extent) -> String {
    let mut text = String::new();
    for group in audit.groups.iter().take(extent.groups) {
        if let Some(trace) = &group.search.trace {
            text += &searching(group, trace, extent);
        }
    }
    let left = audit.groups.len().saturating_sub(extent.groups);
    if left > 0 {
        text += &format!("And {left} more groups; --trace-search=FILE holds them all\n");
    }
    if audit.groups.is_empty() {
        text += "There is nothing to search: no state of the plant changes what a scan costs.\n";
    }
    text
}

fn searching(group: &GroupUse, trace: &TraceUse, extent: Extent) -> String {
    let by = match group.search.engine {
        Engine::Subsets => format!("by subsets, on {SUBSET_SOLVER}"),
        Engine::Cores => "by unsatisfiable cores, on BatSat".to_owned(),
    };
    let mut text = format!("Search of group {}: {by}\n", group.id);
    text += &conditions(trace, extent);
    let steps = &trace.trace.steps;
    if steps.is_empty() {
        text += "  no question is needed: the first scan tried costs as much as any can\n";
    }
    let mut lines = Lines { labels: &trace.conditions, asked: 0, heading: false, text };
    steps.iter().take(extent.steps).for_each(|step| lines.step(step));
    let mut text = lines.text;
    let left = steps.len().saturating_sub(extent.steps) + trace.trace.left_out;
    if left > 0 {
        let all =
            if trace.trace.left_out == 0 { "; --trace-search=FILE holds them all" } else { "" };
        text += &note(&format!("{left} more steps{all}"));
    }
    let most = if group.exact() { "maximum" } else { "at most" };
    text + &format!("  {most} {}\n\n", us(group.upper))
}

/// Each condition with what it costs, the others under it where they do not fit beside it.
fn conditions(trace: &TraceUse, extent: Extent) -> String {
    let shown = &trace.conditions[..trace.conditions.len().min(extent.conditions)];
    let rows: Vec<_> = shown
        .iter()
        .map(|one| {
            let more =
                if one.others > 0 { format!(" and {} more", one.others) } else { String::new() };
            vec![
                left(format!("rung {}", one.label)),
                right(us(one.cost)),
                left(format!("{}{more}", one.instruction)),
                left(format!("line {}", one.at.line)),
            ]
        })
        .collect();
    let mut text = "  what costs more, and when\n".to_owned();
    for (row, one) in columns(4, &rows).lines().zip(shown) {
        let condition = &one.condition;
        if row.width() + 2 + condition.width() <= WIDTH {
            text += &format!("{row}  {condition}\n");
        } else {
            text += &format!("{row}\n");
            text += &folded("        ", &condition.split(' ').collect::<Vec<_>>());
        }
    }
    let left = trace.conditions.len() - shown.len();
    if left > 0 {
        text += &note(&format!("{left} more"));
    }
    if trace.constant > Picos::ZERO {
        text += &format!("  and always {}\n", us(trace.constant));
    }
    if trace.deducted > Picos::ZERO {
        text += &format!("  less {}: units that are missing were counted\n", us(trace.deducted));
    }
    text
}

/// The steps as lines.
struct Lines<'a> {
    labels: &'a [ConditionUse],
    asked: usize,
    /// Whether the questions have their heading.
    heading: bool,
    text: String,
}

impl Lines<'_> {
    fn step(&mut self, step: &Step) {
        match step {
            Step::Asked { items, total, together, time, most } => {
                if !self.heading {
                    self.heading = true;
                    self.text += "  can these be together in one scan?\n";
                }
                self.asked += 1;
                let answer = if *together { "sat" } else { "unsat" };
                let head = format!("{:>5}  ", self.asked);
                let tail = format!("{answer:<5}  {:>8}  T_MAX {}", ms(*time), us(*most));
                let set = self.set(items);
                let line = format!("{head}{set}  {}", us(*total));
                if line.width() + 2 + tail.width() <= WIDTH {
                    let blanks = ANSWERS.saturating_sub(line.width()).max(2);
                    let blanks = blanks.min(WIDTH - line.width() - tail.width());
                    self.text += &format!("{line}{}{tail}\n", " ".repeat(blanks));
                } else {
                    let set = format!("{set}  {}", us(*total));
                    self.text += &folded(&head, &set.split(' ').collect::<Vec<_>>());
                    self.text += &format!("{}{tail}\n", " ".repeat(ANSWERS));
                }
            }
            Step::TakenOver => {
                self.text +=
                    "  the budget for subsets is used up: the cores go on with these bounds\n";
            }
            Step::Partitions { count: 1, .. } => self.text += "  the whole at once\n",
            Step::Partitions { count, size } => {
                self.text += &format!("  {count} partitions of {size} variables\n");
            }
            Step::Cases => self.text += "  case by case, by what decides most\n",
            Step::Propagation => self.text += "  what propagation shows of the whole\n",
            Step::Core { items, counts, weight } => {
                let names = items.iter().map(|&item| self.labels[item].label.as_str());
                let counts = match counts {
                    0 => None,
                    1 => Some("one count of earlier cores".to_owned()),
                    n => Some(format!("{n} counts of earlier cores")),
                };
                let what: Vec<String> = names.map(str::to_owned).chain(counts).collect();
                let what = format!("{}; less {}", what.join(", "), us(*weight));
                self.text += &folded("    not together: ", &what.split(' ').collect::<Vec<_>>());
            }
            Step::Bounds { upper, lower } if upper == lower => {
                self.text += &format!("    the bounds meet at {}\n", us(*upper));
            }
            Step::Bounds { upper, lower } => {
                self.text += &format!("    at least {}, at most {}\n", us(*lower), us(*upper));
            }
        }
    }

    /// A set of conditions, by what it leaves out if that is shorter.
    fn set(&self, items: &[usize]) -> String {
        let name = |item: &usize| self.labels[*item].label.as_str();
        let without: Vec<usize> =
            (0..self.labels.len()).filter(|item| items.binary_search(item).is_err()).collect();
        if items.len() <= 8 || items.len() < without.len() {
            return format!("{{{}}}", items.iter().map(name).collect::<Vec<_>>().join(", "));
        }
        match without.as_slice() {
            [] => format!("{{all {}}}", items.len()),
            some => format!("{{all but {}}}", some.iter().map(name).collect::<Vec<_>>().join(", ")),
        }
    }
}

fn note(text: &str) -> String {
    format!("    and {text}\n")
}

/// Words behind a label, and under each other where a line is full.
fn folded(label: &str, words: &[&str]) -> String {
    let indent = " ".repeat(label.width());
    let (mut text, mut used) = (label.to_owned(), label.width());
    for (index, word) in words.iter().enumerate() {
        if index > 0 && used + 1 + word.width() > WIDTH {
            text += &format!("\n{indent}");
            used = indent.len();
        } else if index > 0 {
            text.push(' ');
            used += 1;
        }
        text += word;
        used += word.width();
    }
    text.push('\n');
    text
}

fn us(time: Picos) -> String {
    format!("{} us", time.us_text())
}

fn ms(time: Duration) -> String {
    let micros = time.as_micros();
    format!("{}.{:02} ms", micros / 1000, micros % 1000 / 10)
}

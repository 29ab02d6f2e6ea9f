//! What a result has to say at which line: what code hosts show beside the source.

use super::diff::text as diff;
use super::format::{Checked, Project};
use super::text::verdict;
use scanbound_audit::breakdown::{By, Part, Piece};
use scanbound_audit::difference::{ChangeKind, Difference};
use scanbound_audit::verdict::{Check, Verdict};
use scanbound_audit::{Audit, Doubt, Share};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::location::Location;
use scanbound_base::time_text::{about, at_most};
use scanbound_measured::Comparison;

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// What makes a check fail.
    Error,
    /// What is to be looked at.
    Warning,
    /// What is good to know.
    Note,
}

/// A kind of finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rule {
    /// Its name, which stays the same.
    pub name: &'static str,
    /// What it means.
    pub about: &'static str,
    /// Its page: what it means, an example, what to do.
    pub page: &'static str,
}

/// All kinds but the codes of faults in the input (`base::code`).
pub mod rules {
    use super::Rule;

    const fn rule(name: &'static str, about: &'static str, page: &'static str) -> Rule {
        Rule { name, about, page }
    }

    /// The answer to a check that holds, and of an audit.
    pub const BOUND: Rule =
        rule("scan-bound", "The bound on the scan time", include_str!("../codes/scan-bound.md"));
    /// The limit is broken.
    pub const REFUTED: Rule = rule(
        "limit-refuted",
        "A scan takes longer than the limit",
        include_str!("../codes/limit-refuted.md"),
    );
    /// The limit is not decided.
    pub const UNDECIDED: Rule = rule(
        "limit-undecided",
        "It is not known whether a scan takes longer than the limit",
        include_str!("../codes/limit-undecided.md"),
    );
    /// A loop may not end.
    pub const ENDLESS: Rule = rule(
        "endless-loop",
        "A scan can go round this loop without end",
        include_str!("../codes/endless-loop.md"),
    );
    /// A rung takes much time.
    pub const DEAR: Rule = rule(
        "dear-rung",
        "One of the rungs in which most of the bound goes",
        include_str!("../codes/dear-rung.md"),
    );
    /// A count is not known.
    pub const UNKNOWN: Rule = rule(
        "unknown-count",
        "The bound depends on a count that nobody stated",
        include_str!("../codes/unknown-count.md"),
    );
    /// Something is not stated.
    pub const NOT_STATED: Rule = rule(
        "not-stated",
        "What is not stated may make the bound too low",
        include_str!("../codes/not-stated.md"),
    );
    /// A word is trusted.
    pub const TRUSTED: Rule = rule(
        "trusted-word",
        "The bound holds if only the program writes this word",
        include_str!("../codes/trusted-word.md"),
    );
    /// Something about the input.
    pub const INPUT: Rule =
        rule("input", "Something about the files or the table", include_str!("../codes/input.md"));
    /// The bound of two versions.
    pub const CHANGED: Rule = rule(
        "bound-changed",
        "The bound of another version",
        include_str!("../codes/bound-changed.md"),
    );
    /// What a change costs.
    pub const CHANGE: Rule = rule(
        "costly-change",
        "What a changed rung costs",
        include_str!("../codes/costly-change.md"),
    );
    /// A measured scan is above the bound.
    pub const ABOVE: Rule = rule(
        "measured-above-bound",
        "A measured scan takes longer than the bound",
        include_str!("../codes/measured-above-bound.md"),
    );

    /// All of them.
    pub const ALL: &[Rule] = &[
        BOUND, REFUTED, UNDECIDED, ENDLESS, DEAR, UNKNOWN, NOT_STATED, TRUSTED, INPUT, CHANGED,
        CHANGE, ABOVE,
    ];
}

/// Something to be said, at a place if it has one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Its kind.
    pub rule: Rule,
    /// How much it matters.
    pub level: Level,
    /// The words.
    pub message: String,
    /// The file as the user named it, and the line.
    pub place: Option<(String, Option<u32>)>,
}

/// Rungs that take less of the bound are not told.
const WORTH_TELLING: Share = Share(10);

/// So many of a kind are told, since hosts show a few only.
const MAX_FINDINGS: usize = 10;

/// What an audit found, and the check of it; the gravest first.
#[must_use]
pub fn of_audit(audit: &Audit, check: Option<&Check>) -> Vec<Finding> {
    let at = |at: Location| Some((at.of(&audit.files).clone(), Some(at.line)));
    let parts = audit.breakdown(By::Rung);
    let largest = parts.iter().filter_map(|part| match &part.piece {
        Piece::Rung { at, instruction, .. } => Some((part, *at, instruction)),
        _ => None,
    });
    let endless = audit.unbounded.first().and_then(|one| at(one.from));
    let first = endless.or_else(|| largest.clone().next().and_then(|(_, place, _)| at(place)));
    let (rule, level) = match check.map(|check| &check.verdict) {
        None | Some(Verdict::Proved) => (rules::BOUND, Level::Note),
        Some(Verdict::Refuted) => (rules::REFUTED, Level::Error),
        Some(Verdict::Undecided(_)) => (rules::UNDECIDED, Level::Error),
    };
    let reasons = verdict::reasons(check);
    let message = [vec![verdict::answer(audit, check).plain()], reasons].concat().join("\n");
    let mut found = vec![Finding { rule, level, message, place: first }];
    let mut add = |rule, level, message, place| found.push(Finding { rule, level, message, place });
    for one in audit.unbounded.iter().take(MAX_FINDINGS) {
        let what = match one.certain {
            true => "a scan can go round this loop without end",
            false => "nothing is known that ends this loop",
        };
        let message = format!("{what}: `{}` to `{}`", one.begins, one.ends);
        add(rules::ENDLESS, Level::Error, message, at(one.from));
    }
    for one in audit.unknowns.iter().take(MAX_FINDINGS) {
        let Some((place, instruction)) = one.places.first() else { continue };
        let hang = match one.counts() {
            Some(counts) => {
                format!(
                    "up to {} of the bound depend on {}, of which",
                    about(counts.cost),
                    one.word
                )
            }
            None => format!("the bound may depend on {}{}, of which", one.word, one.origin()),
        };
        let message = format!(
            "{hang} nothing is known in `{instruction}`: state it in a facts file: [{}] {}",
            one.table(),
            one.fact
        );
        add(rules::UNKNOWN, Level::Warning, message, at(*place));
    }
    for doubt in audit.all_doubts().iter().take(MAX_FINDINGS) {
        let place = match doubt {
            Doubt::Networks { first: (file, line), .. }
            | Doubt::Bodiless { first: (file, line), .. } => Some((file.clone(), Some(*line))),
            _ => None,
        };
        add(rules::NOT_STATED, Level::Warning, doubt.to_string(), place);
    }
    for one in &audit.warnings {
        let place = Some((one.file.clone(), one.line)).filter(|(file, _)| !file.is_empty());
        add(rules::INPUT, Level::Warning, one.message.clone(), place);
    }
    let much = |part: &Part| part.share(audit) >= WORTH_TELLING;
    for (part, place, instruction) in largest.filter(|(part, ..)| much(part)).take(MAX_FINDINGS) {
        let message = format!(
            "this rung takes {} of the bound of {} ({}), most of it `{instruction}`",
            about(part.time),
            at_most(audit.bound.upper),
            part.share(audit)
        );
        add(rules::DEAR, Level::Note, message, at(place));
    }
    for one in audit.assumptions.iter().take(MAX_FINDINGS) {
        let message = format!("the bound holds if only the program writes {}", one.name());
        add(
            rules::TRUSTED,
            Level::Note,
            message,
            one.written.first().and_then(|(place, _)| at(*place)),
        );
    }
    placed(found, &audit.files)
}

/// What has no place of its own, or a directory for one, is told of the first file: code hosts take no finding without
/// a file, nor do they see through a `.` in front.
fn placed(mut found: Vec<Finding>, files: &[String]) -> Vec<Finding> {
    let whole = files.first().map(|file| (file.clone(), None));
    let within = |file: &str, directory: &str| {
        file.strip_prefix(directory).is_some_and(|rest| rest.starts_with(['/', '\\']))
    };
    for one in &mut found {
        let own = one.place.take();
        let own = own.filter(|(place, _)| !files.iter().any(|file| within(file, place)));
        one.place = own.or_else(|| whole.clone());
        if let Some((file, _)) = &mut one.place {
            *file = file.strip_prefix("./").unwrap_or(file).to_owned();
        }
    }
    found
}

/// What became of a project that was checked among others.
#[must_use]
pub fn of_project(project: &Project<'_>) -> Vec<Finding> {
    let fault =
        |message, place| Finding { rule: rules::INPUT, level: Level::Error, message, place };
    let found = match &project.checked {
        Checked::Audited(audit, check) => return of_audit(audit, Some(check)),
        Checked::Faulty(faults) => {
            let place = |one: &Diagnostic| {
                Some((one.file.clone(), one.line)).filter(|(file, _)| !file.is_empty())
            };
            faults.iter().map(|one| fault(told(one), place(one))).collect()
        }
        Checked::Failed(why) => vec![fault(why.clone(), None)],
    };
    placed(found, &[project.file.to_owned()])
}

/// A fault in a sentence, without its place.
fn told(one: &Diagnostic) -> String {
    match one.help.as_str() {
        "" => one.message.clone(),
        help => format!("{}: {help}", one.message),
    }
}

/// What a comparison found.
#[must_use]
pub fn of_comparison(found: &Comparison) -> Vec<Finding> {
    let place = found.files.first().map(|file| (file.clone(), None));
    let message = super::compare::text::answer(found);
    let (rule, level) = match found.above {
        Some(_) => (rules::ABOVE, Level::Error),
        None => (rules::BOUND, Level::Note),
    };
    vec![Finding { rule, level, message, place }]
}

/// What two versions differ in.
#[must_use]
pub fn of_difference(found: &Difference) -> Vec<Finding> {
    let level = if found.is_above() { Level::Error } else { Level::Note };
    let message = diff::answer(found);
    let mut all = vec![Finding { rule: rules::CHANGED, level, message, place: None }];
    let largest =
        found.changes.iter().filter(|one| one.delta() != 0 && one.kind != ChangeKind::Same);
    all.extend(largest.take(MAX_FINDINGS).map(|one| Finding {
        rule: rules::CHANGE,
        level: if one.delta() > 0 { Level::Warning } else { Level::Note },
        message: format!("{} of the bound: {}", diff::signed(one.delta()), diff::words(one)),
        place: one.new.as_ref().map(|side| (side.file.clone(), Some(side.at.line))),
    }));
    placed(all, &found.new_files)
}

//! The answer in a sentence: a check's verdict, or an audit's bound.

use super::style::{BAD, BOLD, CARE, GOOD};
use super::words::place;
use crate::columns::paint;
use crate::wrap;
use anstyle::Style;
use scanbound_audit::verdict::{Check, Measure, Verdict};
use scanbound_audit::{Audit, Doubt, Reason, UnstatedPoints};
use scanbound_base::time::Picos;
use scanbound_base::time_text::{at_least, at_most};
use scanbound_timing::table::Evidence;
use std::collections::BTreeSet;

/// A word that stands out, and what is to be said.
pub(crate) struct Answer {
    style: Style,
    word: &'static str,
    told: String,
}

impl Answer {
    /// In one line.
    pub(crate) fn plain(&self) -> String {
        match self.word {
            "" => self.told.clone(),
            word => format!("{word}: {}", self.told),
        }
    }

    /// The same with the word that stands out marked as Markdown does.
    pub(crate) fn markdown(&self) -> String {
        match self.word {
            "" => format!("**{}**", self.told),
            word => format!("**{word}**: {}", self.told),
        }
    }

    /// On lines of this width, with colour codes.
    pub(super) fn lines(&self, width: usize) -> String {
        let text = wrap::paragraph(0, &self.plain(), width);
        match self.word {
            "" => format!("{}\n", paint(self.style, text.trim_end())),
            word => text.replacen(word, &paint(self.style, word), 1),
        }
    }
}

/// The verdict of a check, or what an audit found.
pub(crate) fn answer(audit: &Audit, check: Option<&Check>) -> Answer {
    let mut answer = match check {
        Some(check) => verdict(audit, check),
        None => bound(audit),
    };
    // Such a bound is no statement about any controller that there is.
    if audit.cpu.is_none() && audit.table.is_all_assumed {
        answer.told = format!(
            "{} (table {}, all times assumed, no controller named){}",
            answer.told.trim_end_matches('.'),
            audit.table.name,
            if answer.told.ends_with('.') { "." } else { "" }
        );
    }
    answer
}

fn bound(audit: &Audit) -> Answer {
    if let Some(first) = audit.unbounded.first() {
        let place = place(audit, first.from);
        let told = match first.certain {
            true => {
                format!("Nothing bounds the scan: it can go round the loop at {place} without end.")
            }
            false => format!(
                "Nothing is known to bound the scan: the loop at {place} may go round any number of times."
            ),
        };
        return Answer { style: BAD, word: "", told };
    }
    let upper = audit.bound.upper;
    let told = match audit.proved() {
        None => format!(
            "The bound of {} may be too low, since this is not stated: {}. The longest scan found takes {}{}.",
            at_most(upper),
            not_stated(audit).join(", "),
            at_least(audit.lower_without_points()),
            without_points(audit)
        ),
        Some(proved) if proved > upper => {
            let seen: Vec<String> =
                audit.points.iter().map(|one| format!("{} {}", one.taken, one.side)).collect();
            let found = audit.lower_on_least_bases();
            let with_seen = match found == upper {
                true => format!("the longest takes {}", at_most(upper)),
                false => format!(
                    "none takes longer than {}, and the longest found takes {}{}",
                    at_most(upper),
                    at_least(found),
                    on_least_bases(found < audit.possible())
                ),
            };
            format!(
                "No scan takes longer than {} with all the points that the CPU can have; with the {} points that the program names, {with_seen}.",
                at_most(proved),
                seen.join(" and ")
            )
        }
        Some(_) => {
            let found = audit.lower_without_points();
            match upper == found {
                true => format!("The longest scan takes {}: none takes longer.", at_most(upper)),
                false => format!(
                    "No scan takes longer than {}; the longest found takes {}{}.",
                    at_most(upper),
                    at_least(found),
                    without_points(audit)
                ),
            }
        }
    };
    let wait = audit.cycle.longest().filter(|&most| most > upper);
    let wait = wait.map(|most| {
        format!(" With the wait for the constant scan time a scan lasts up to {}.", at_most(most))
    });
    Answer { style: BOLD, word: "", told: told + &wait.unwrap_or_default() }
}

/// What the bound needs and nobody stated, in a word or two each.
pub(super) fn not_stated(audit: &Audit) -> Vec<&'static str> {
    let topics: BTreeSet<&str> = audit.all_doubts().iter().map(Doubt::topic).collect();
    topics.into_iter().collect()
}

/// What is left out of [`Audit::lower_without_points`], to be read behind its time.
fn without_points(audit: &Audit) -> &'static str {
    let is_less = audit.lower_without_points() < audit.possible();
    match audit.points.iter().any(|points| points.time > Picos::ZERO) {
        true if is_less => " without the I/O points that are not stated",
        _ => on_least_bases(is_less),
    }
}

fn on_least_bases(is_less: bool) -> &'static str {
    if is_less { " on the cheapest base units" } else { "" }
}

fn verdict(audit: &Audit, check: &Check) -> Answer {
    let limit = told(check.limit);
    let most = upper(check.longest, check.limit);
    let [none_longer, none_more, takes] = measured(audit, check.measure);
    let for_task = task(audit, "for");
    let margin = |time: String| match check.margin.is_none() {
        true => String::new(),
        false => format!(" ({time} with the margin of {})", check.margin),
    };
    let above = margin(upper(check.upper, check.limit));
    let below = margin(lower(check.lower, check.limit));
    let points = all_points(audit);
    let without = match check.took == audit.lower_without_points() {
        true => without_points(audit),
        false => "",
    };
    match &check.verdict {
        Verdict::Proved => Answer {
            style: GOOD,
            word: "PROVED",
            told: format!(
                "{none_longer} {most}{above}{points}, the limit is {limit}{}",
                rests(check)
            ),
        },
        Verdict::Refuted => {
            let told = match audit.unbounded.iter().find(|one| one.certain) {
                Some(first) => {
                    format!(
                        "a scan can go round the loop at {} without end",
                        place(audit, first.from)
                    )
                }
                None => format!(
                    "{takes} {}{below}{}, the limit is {limit}{}{}",
                    lower(check.took, check.limit),
                    without,
                    rests(check),
                    match check.is_reached {
                        true => "",
                        false => "; no run from power-up to its start state was found",
                    }
                ),
            };
            Answer { style: BAD, word: "REFUTED", told }
        }
        Verdict::Undecided(_) if !audit.unbounded.is_empty() => {
            let told = format!("{}; the limit is {limit}", bound(audit).told.trim_end_matches('.'));
            Answer { style: CARE, word: "UNDECIDED", told }
        }
        Verdict::Undecided(reasons) if check.upper <= check.limit => {
            let doubts = reasons.iter().any(|reason| !matches!(reason, Reason::Assumed { .. }));
            // The sentence stands alone on stderr and in other formats: the reasons may not follow it.
            let told = match doubts {
                true => format!(
                    "the bound of {most}{above}{points}{for_task} is within the limit of {limit}, but may be too low"
                ),
                false => format!(
                    "{none_longer} {most}{above}{points}, the limit is {limit}; but more of it than is allowed rests on assumed times"
                ),
            };
            Answer { style: CARE, word: "UNDECIDED", told }
        }
        Verdict::Undecided(_) => {
            let found = match check.took {
                Picos::ZERO => String::new(),
                found => format!("{takes} {}{below}{without}, ", lower(found, check.limit)),
            };
            let bound = match audit.proved() {
                Some(_) => format!("{none_more} {most}{above}{points}"),
                None => format!("the bound{for_task} is {most}{above}{points} and may be too low"),
            };
            let and = if found.is_empty() { "" } else { "and " };
            let told = format!("the limit is {limit}; {found}{and}{bound}");
            Answer { style: CARE, word: "UNDECIDED", told }
        }
    }
}

/// The task to which a verdict applies, after this preposition; empty if there is only one task.
fn task(audit: &Audit, preposition: &str) -> String {
    audit.bounded_task.as_ref().map_or(String::new(), |name| format!(" {preposition} task {name}"))
}

/// How it is said that none is longer, and that one takes so long.
fn measured(audit: &Audit, measure: Measure) -> [String; 3] {
    let of = task(audit, "of");
    match measure {
        Measure::Cycle | Measure::Execution => [
            format!("no scan{of} takes longer than"),
            format!("no scan{of} takes more than"),
            format!("a scan{of} takes"),
        ],
        Measure::Stretch => [
            "the watchdog is restarted (WDT, or the end of the scan) after no more than",
            "never more than",
            "between two restarts of the watchdog pass",
        ]
        .map(str::to_owned),
    }
}

/// Why a check is undecided, each reason a sentence.
pub(crate) fn reasons(check: Option<&Check>) -> Vec<String> {
    match check.map(|check| &check.verdict) {
        Some(Verdict::Undecided(reasons)) => reasons.iter().map(ToString::to_string).collect(),
        _ => Vec::new(),
    }
}

/// An upper bound beside a limit: exact where rounding would put it on the other side.
fn upper(time: Picos, limit: Picos) -> String {
    beside(time, limit, at_most(time))
}

fn lower(time: Picos, limit: Picos) -> String {
    beside(time, limit, at_least(time))
}

fn beside(time: Picos, limit: Picos, told: String) -> String {
    let shown: Result<Picos, _> = told.parse();
    match shown.is_ok_and(|shown| shown.cmp(&limit) == time.cmp(&limit)) {
        true => told,
        false => time.best_text(),
    }
}

/// A time that the user gave, as exact as it was given.
fn told(time: Picos) -> String {
    let told = at_most(time);
    if told.parse() == Ok(time) { told } else { time.best_text() }
}

/// Whether a check's answer says how much of it rests on assumed times.
pub(super) fn tells_assumed(check: &Check) -> bool {
    !rests(check).is_empty()
}

/// On what the time that decides a check rests.
fn rests(check: &Check) -> String {
    let assumed = &check.assumed;
    match (assumed.time, assumed.at_most) {
        (Picos::ZERO, _) => String::new(),
        (_, false) => format!(" ({} of it on assumed times)", assumed.share()),
        (_, true) => format!(" (at most {} of it on assumed times)", assumed.share()),
    }
}

/// What was counted beyond the parts of the bound where points are not stated.
fn all_points(audit: &Audit) -> String {
    let counted =
        |points: &&UnstatedPoints| points.most.as_ref().is_some_and(|most| most.more > Picos::ZERO);
    let counted: Vec<_> = audit.points.iter().filter(counted).collect();
    let most = counted.iter().filter_map(|points| Some((points.side, points.most.as_ref()?)));
    let all: Vec<String> =
        most.clone().map(|(side, most)| format!("{} {side}", most.points)).collect();
    if all.is_empty() {
        return String::new();
    }
    let assumed = most.into_iter().any(|(_, most)| most.evidence == Evidence::Assumed);
    let assumed = if assumed { " (assumed)" } else { "" };
    format!(", even with all {} points that the CPU can have{assumed}", all.join(" and "))
}

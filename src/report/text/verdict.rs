//! The answer in a sentence: a check's verdict, or an audit's bound.

use super::style::{BAD, BOLD, CARE, GOOD};
use super::words::place;
use crate::audit::verdict::{Check, Verdict};
use crate::audit::{Audit, Reason, UnstatedPoints};
use crate::base::spoken::{at_least, at_most};
use crate::base::time::Picos;
use crate::report::columns::paint;
use crate::report::wrap;
use crate::timing::table::Evidence;
use anstyle::Style;

/// A word that stands out, and what is to be said.
pub(in crate::report) struct Answer {
    style: Style,
    word: &'static str,
    told: String,
}

impl Answer {
    /// In one line.
    pub(in crate::report) fn plain(&self) -> String {
        match self.word {
            "" => self.told.clone(),
            word => format!("{word}: {}", self.told),
        }
    }

    /// The same with the word that stands out marked as Markdown does.
    pub(in crate::report) fn markdown(&self) -> String {
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
pub(in crate::report) fn answer(audit: &Audit, check: Option<&Check>) -> Answer {
    match check {
        Some(check) => verdict(audit, check),
        None => bound(audit),
    }
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
    let (upper, lower) = (audit.bound.upper, audit.possible());
    let besides = match audit.networks.is_empty() {
        true => "",
        false => ", network refresh (not stated) not counted",
    };
    let told = match upper == lower {
        true => format!("The longest scan takes {}{besides}: none takes longer.", at_most(upper)),
        false => format!(
            "No scan takes longer than {}{besides}; the longest found takes {}.",
            at_most(upper),
            at_least(lower)
        ),
    };
    Answer { style: BOLD, word: "", told }
}

fn verdict(audit: &Audit, check: &Check) -> Answer {
    let limit = told(check.limit);
    let most = upper(audit.upper_with_all_points(), check.limit);
    let margin = |time: String| match check.margin.is_none() {
        true => String::new(),
        false => format!(" ({time} with the margin of {})", check.margin),
    };
    let above = margin(upper(check.upper, check.limit));
    let below = margin(lower(check.lower, check.limit));
    let points = all_points(audit);
    match &check.verdict {
        Verdict::Proved => Answer {
            style: GOOD,
            word: "PROVED",
            told: format!(
                "no scan takes longer than {most}{above}{points}, the limit is {limit}{}",
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
                    "a scan takes {}{below}, the limit is {limit}{}{}",
                    lower(audit.possible(), check.limit),
                    rests(check),
                    match audit.is_reached() {
                        true => "",
                        false => "; unless a PLC cannot come to the state in which it starts",
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
            let but = match doubts {
                true => "the bound may be too low",
                false => "more of it than is allowed rests on assumed times",
            };
            let told = format!(
                "no scan takes longer than {most}{above}{points}, the limit is {limit}; but {but}"
            );
            Answer { style: CARE, word: "UNDECIDED", told }
        }
        Verdict::Undecided(_) => Answer {
            style: CARE,
            word: "UNDECIDED",
            told: format!(
                "the limit is {limit}; a scan takes {}{below}, and none is known to take more than {most}{above}",
                lower(audit.lower_without_points(), check.limit),
            ),
        },
    }
}

/// Why a check is undecided, each reason a sentence.
pub(in crate::report) fn reasons(check: Option<&Check>) -> Vec<String> {
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

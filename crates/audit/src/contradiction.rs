//! Facts that no scan satisfies: finds which stated facts contradict the program, and which limits can be offered as
//! facts without a contradiction.

use super::Audit;
use super::confirmed::CONTRADICTION;
use super::counts::instructions_at_key;
use super::failure::Failure;
use super::request::Request;
use super::stated;
use super::unknown::{self, Unknown};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{Facts, Part};
use scanbound_base::time::Picos;
use scanbound_ir::{Program, flow};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// The time limit for a search for contradicting facts or for limits to offer, unless the request sets a shorter one.
const LONGEST: Duration = Duration::from_secs(20);

/// The upper limits that may be offered for a number of iterations or units, or for an index. The first one with which
/// some scan satisfies all facts is offered.
const OFFERED: [u32; 5] = [20, 100, 1_000, 10_000, i16::MAX as u32];

/// The functions that read and audit a project. The pipeline passes them, so that this module does not depend on it.
#[derive(Clone, Copy)]
pub(super) struct Stages {
    pub read: fn(&Request<'_>) -> Result<Program, Failure>,
    pub audit: fn(&Request<'_>) -> Result<Audit, Failure>,
}

/// Audits with these facts in place of those of the request. Returns whether some scan satisfies them. Also true if the
/// time limit or an internal error left that undecided; false after any other error.
fn is_kept(stages: Stages, request: &Request<'_>, facts: &Facts) -> bool {
    let request = Request {
        facts,
        proves_facts: false,
        limit: Some(Picos(u64::MAX)),
        trace: false,
        confirm: false,
        response: None,
        warnings: &[],
        progress: &|_| {},
        ..*request
    };
    match (stages.audit)(&request) {
        Err(Failure::Input(faults)) => faults.iter().all(|fault| fault.code == Code::Time),
        Ok(_) | Err(Failure::Internal(_)) => true,
    }
}

/// The deadline of a search that begins now: after the request's time limit, or after [`LONGEST`] if that is shorter.
fn deadline(request: &Request<'_>) -> Instant {
    Instant::now() + request.time_limit.map_or(LONGEST, |limit| limit.min(LONGEST))
}

/// Replaces the failure of an audit by one that names the contradicting facts, if the failure is that no scan satisfies
/// the stated facts, the request is not one that only tries facts ([`Request::proves_facts`] is true), and such facts
/// are found. Other failures are returned unchanged.
pub(super) fn with_contradicting_facts(
    stages: Stages,
    request: &Request<'_>,
    failure: Failure,
) -> Failure {
    let is_one = |fault: &Diagnostic| fault.message == CONTRADICTION;
    match failure {
        // Facts that are only tried are not analysed for contradictions.
        Failure::Input(faults) if request.proves_facts && faults.iter().any(is_one) => {
            let named = contradicting(stages, request);
            Failure::Input(if named.is_empty() { faults } else { named })
        }
        failure => failure,
    }
}

/// An error for each stated range or count that no scan satisfies even without the other ranges and counts. If there is
/// none: for each one without which some scan satisfies all other facts. Empty if the time is over before one is found.
fn contradicting(stages: Stages, request: &Request<'_>) -> Vec<Diagnostic> {
    let end = deadline(request);
    let facts = request.facts;
    let bare = Facts { counts: BTreeMap::new(), ranges: BTreeMap::new(), ..facts.clone() };
    let Ok(program) = (stages.read)(&Request { facts: &bare, ..*request }) else {
        return Vec::new();
    };
    let mut faults = Vec::new();
    for (key, &(low, high)) in &facts.counts {
        // A word may be the count at several places.
        let places = instructions_at_key(&program, key).unwrap_or_default();
        let at = places.iter().map(|&at| program.instructions[at].place);
        let keys: Vec<String> = at.map(|place| unknown::key(&program, place)).collect();
        for (&at, place) in places.iter().zip(keys) {
            let counts = BTreeMap::from([(place, (low, high))]);
            if Instant::now() < end && !is_kept(stages, request, &Facts { counts, ..bare.clone() })
            {
                let message = count_message(&program, at, low, high);
                let help = "state a number of iterations or units that can occur there, or remove the statement";
                let fact = ["counts", key.as_str()];
                faults.push(facts.fault(fact, Part::Value, Code::Facts, message, help));
            }
        }
    }
    for (key, &(low, high)) in &facts.ranges {
        let ranges = BTreeMap::from([(key.clone(), (low, high))]);
        if Instant::now() < end && !is_kept(stages, request, &Facts { ranges, ..bare.clone() }) {
            let message = format!(
                "[ranges] states a value from {low} to {high} in {key}, but no scan can start with such a value"
            );
            let help = "state a range that can occur when a scan starts, or remove the statement";
            let fact = ["ranges", key.as_str()];
            faults.push(facts.fault(fact, Part::Value, Code::Facts, message, help));
        }
    }
    if faults.is_empty() { together(stages, request, end) } else { faults }
}

/// An error for each stated range or count without which some scan satisfies the other facts, as far as they can be
/// tried until `end`.
fn together(stages: Stages, request: &Request<'_>, end: Instant) -> Vec<Diagnostic> {
    let facts = request.facts;
    let is_one = |fewer: &Facts| Instant::now() < end && is_kept(stages, request, fewer);
    let fault = |table: &'static str, key: &str, (low, high): (i64, i64)| {
        let message =
            format!("no scan satisfies {key} = {low} to {high} together with the other facts");
        let help = "look for a second fact about the same word, and correct one of the two facts";
        facts.fault([table, key], Part::Value, Code::Facts, message, help)
    };
    let mut all = Vec::new();
    for (key, &range) in &facts.counts {
        let mut fewer = facts.clone();
        fewer.counts.remove(key);
        all.extend(is_one(&fewer).then(|| fault("counts", key, range)));
    }
    for (key, &range) in &facts.ranges {
        let mut fewer = facts.clone();
        fewer.ranges.remove(key);
        all.extend(is_one(&fewer).then(|| fault("ranges", key, range)));
    }
    all
}

/// The message that the number of iterations or units of instruction `at` cannot be in the stated range. It names the
/// instruction that writes the word: the last one before `at` in the program, otherwise the first one from `at` on.
fn count_message(program: &Program, at: usize, low: i64, high: i64) -> String {
    let place = |at: usize| {
        let one = &program.instructions[at];
        let file = &one.place.of(&program.files).name;
        format!("`{}` ({file}:{})", one.text, one.place.line)
    };
    let never = format!(
        "the number of iterations or units of {} cannot be {low} to {high} as stated",
        place(at)
    );
    let word = unknown::word(program, at);
    let Some((word, cell)) =
        word.and_then(|word| Some((word.clone(), stated::cell(program, &word)?)))
    else {
        return never;
    };
    let writes =
        |&other: &usize| flow::written(program, other).iter().any(|one| one.contains(cell));
    let before = (0..at).rev().find(writes);
    let by = before.or_else(|| (at..program.instructions.len()).find(writes));
    by.map_or(never.clone(), |by| format!("{never}: {} writes {word}", place(by)))
}

/// Audits the project and returns the errors about stated facts that no scan satisfies, or that the program violates.
/// Empty if no counts, ranges or exclusive bits are stated.
pub(super) fn of(stages: Stages, request: &Request<'_>) -> Vec<Diagnostic> {
    let facts = request.facts;
    if facts.counts.is_empty() && facts.ranges.is_empty() && facts.exclusive.is_empty() {
        return Vec::new();
    }
    let time_limit = request.time_limit.map_or(LONGEST, |limit| limit.min(LONGEST));
    let asked = Request {
        limit: Some(Picos(u64::MAX)),
        time_limit: Some(time_limit),
        progress: &|_| {},
        ..*request
    };
    match (stages.audit)(&asked) {
        Err(Failure::Input(faults)) => {
            let is_one = |one: &Diagnostic| matches!(one.code, Code::Facts | Code::BrokenFact);
            faults.into_iter().filter(is_one).collect()
        }
        Ok(_) | Err(Failure::Internal(_)) => Vec::new(),
    }
}

/// The upper limit to offer for each unknown count or index, by its key in a facts file, so that some scan satisfies
/// all of them together with the stated facts. A count or index is left out if no limit allows such a scan, or if the
/// time is over.
pub(super) fn offered_limits(
    stages: Stages,
    request: &Request<'_>,
    unknowns: &[Unknown],
) -> BTreeMap<String, u32> {
    let numbers = || unknowns.iter().filter(|one| one.is_number());
    let mut facts = request.facts.clone();
    numbers().for_each(|one| one.state(&mut facts, OFFERED[0]));
    if is_kept(stages, request, &facts) {
        return numbers().map(|one| (one.key.clone(), OFFERED[0])).collect();
    }
    let end = deadline(request);
    let (mut facts, mut offered) = (request.facts.clone(), BTreeMap::new());
    for one in numbers() {
        let most = OFFERED.into_iter().find(|&most| {
            let mut more = facts.clone();
            one.state(&mut more, most);
            Instant::now() < end && is_kept(stages, request, &more)
        });
        if let Some(most) = most {
            one.state(&mut facts, most);
            offered.insert(one.key.clone(), most);
        }
    }
    offered
}

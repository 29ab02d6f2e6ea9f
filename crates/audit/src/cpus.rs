//! One program by every table of its family: on which CPU it keeps to a limit.

use super::pipeline::{Prepared, conclude};
use super::request::Request;
use super::verdict::{Check, Margin, MostAssumed, Verdict};
use super::{Audit, Doubt, Failure, Share};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_timing::table::{Table, builtin};
use std::cmp::Reverse;

/// The limit that is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The same for every CPU.
    Time(Picos),
    /// Each CPU's watchdog.
    Watchdog,
}

/// What each table is held against.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Condition {
    /// The limit, if there is one.
    pub limit: Option<Limit>,
    /// What is added to the scan before it is held against the limit.
    pub margin: Margin,
    /// How much may rest on assumed times, if that is a condition.
    pub max_assumed: Option<MostAssumed>,
}

/// A program by all tables of its family, that with the highest bound first, those without a bound last.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    /// The program's files.
    pub files: Vec<String>,
    /// What the tables were held against.
    pub condition: Condition,
    /// The tables.
    pub candidates: Vec<Candidate>,
}

impl Choice {
    /// The slowest CPU that is proved to keep to the limit: of those tables the one with the highest bound.
    #[must_use]
    pub fn slowest(&self) -> Option<&Candidate> {
        self.candidates.iter().find(|one| one.is_proved())
    }
}

/// A table, and what the program's scan takes by it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    /// The table's name.
    pub table: String,
    /// What it is for, one line.
    pub title: String,
    /// The CPUs it is for.
    pub cpus: Vec<String>,
    /// Whether it is the one that prices the program unless another is named.
    pub is_own: bool,
    /// The CPU that the program or the user names, where it is that.
    pub cpu: Option<String>,
    /// What was found, or why nothing: instructions that have no time there.
    pub outcome: Result<Found, Vec<Diagnostic>>,
}

impl Candidate {
    /// Whether it is proved to keep to the limit.
    #[must_use]
    pub fn is_proved(&self) -> bool {
        let check = self.outcome.as_ref().ok().and_then(|found| found.check.as_ref());
        check.is_some_and(|check| check.verdict == Verdict::Proved)
    }
}

/// What a scan takes by a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// No scan takes longer; none where a scan may never end.
    pub upper: Option<Picos>,
    /// The same with all points that the CPU can have, where it is not stated how many are fitted: what a limit is held
    /// against.
    pub all_points: Option<Picos>,
    /// A scan that nothing known excludes takes so long.
    pub lower: Picos,
    /// How much of the bound rests on assumed times, at most.
    pub assumed: Share,
    /// The answer to the limit, if there is one for this CPU.
    pub check: Option<Check>,
    /// Why the bound may be too low.
    pub doubts: Vec<Doubt>,
    /// Whether the time limit or the user cut a stage short.
    pub is_cut: bool,
}

/// Audits a program by every built-in table of its family, and by the table that the user names. It is read, and what its
/// words can hold is worked out, once; each table has the time limit for itself.
///
/// # Errors
/// All faults of the program at once, or that the analysis and the interpreter disagree.
pub fn choose(request: &Request<'_>, condition: Condition) -> Result<Choice, Failure> {
    let prepared = Prepared::of(request)?;
    let own = prepared.table().name.clone();
    let mut tables = prepared.table().family.as_deref().map(builtin::of_family).unwrap_or_default();
    if tables.iter().all(|table| table.name != own) {
        tables.extend(request.table.cloned().or_else(|| Table::builtin(&own)));
    }
    let files = prepared.program().files.iter().map(|file| file.name.clone()).collect();
    let mut choice = Choice { files, condition, candidates: Vec::new() };
    for table in tables {
        let (name, title, cpus) = (table.name.clone(), table.title.clone(), table.cpus.clone());
        let is_own = name == own;
        let named = request.cpu.or(prepared.program().cpu.as_deref());
        let cpu = named.filter(|_| is_own).map(str::to_owned);
        let outcome = match prepared.with_table(table, request).priced(request) {
            Ok(followed) => Ok(found(&conclude(followed, request)?.audit, condition)),
            Err(Failure::Input(faults)) => Err(faults),
            Err(why) => return Err(why),
        };
        choice.candidates.push(Candidate { table: name, title, cpus, is_own, cpu, outcome });
    }
    choice.candidates.sort_by_key(|one| {
        let found = one.outcome.as_ref().ok();
        let bound = found.map(|found| found.upper.unwrap_or(Picos(u64::MAX)));
        (bound.is_none(), Reverse(bound))
    });
    Ok(choice)
}

fn found(audit: &Audit, condition: Condition) -> Found {
    let check = match condition.limit {
        None => None,
        Some(Limit::Time(limit)) => Some(Check::new(audit, limit, condition.margin)),
        Some(Limit::Watchdog) => Check::of_watchdog(audit, condition.margin),
    };
    let check = check.map(|check| match condition.max_assumed {
        Some(most) => check.if_assumed_at_most(audit, most),
        None => check,
    });
    Found {
        upper: audit.unbounded.is_empty().then_some(audit.bound.upper),
        all_points: audit.unbounded.is_empty().then_some(audit.upper_with_all_points()),
        lower: audit.bound.lower,
        assumed: audit.assumed_share(),
        check,
        doubts: audit.all_doubts(),
        is_cut: !audit.cuts.is_empty(),
    }
}

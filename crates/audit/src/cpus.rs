//! Compares the timing tables of a CPU family: on which CPUs the program stays within a limit.

use super::pipeline::{PreparedProject, conclude};
use super::request::Request;
use super::verdict::{Check, Margin, MostAssumed, Verdict};
use super::{Audit, Doubt, Failure, Share};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_timing::table::{Table, builtin};
use std::cmp::Reverse;

/// The limit with which the scan times are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The limit is this time for every CPU.
    Time(Picos),
    /// The limit is each CPU's watchdog time.
    Watchdog,
}

/// The condition that each CPU is checked against.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CpuCheck {
    /// The limit with which the scan times are compared. `None`: nothing is checked.
    pub limit: Option<Limit>,
    /// The safety margin that is added to the scan time before it is compared with the limit.
    pub margin: Margin,
    /// The largest share of assumed times with which a limit counts as proved, if there is such a condition.
    pub max_assumed: Option<MostAssumed>,
}

/// The scan time of one program with each timing table of its CPU family.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CpuComparison {
    /// The program's files.
    pub files: Vec<String>,
    /// The condition that was checked.
    pub condition: CpuCheck,
    /// One result for each timing table, the highest bound first. A scan that may never end comes before all others,
    /// and a table that lacks times comes last.
    pub candidates: Vec<CpuResult>,
}

impl CpuComparison {
    /// The slowest CPU on which the program is proved to stay within the limit: of all such CPUs, the one with the
    /// highest bound. `None` if there is no such CPU, or no limit.
    #[must_use]
    pub fn slowest(&self) -> Option<&CpuResult> {
        self.candidates.iter().find(|one| one.is_proved())
    }
}

/// A timing table, and the scan time of the program by it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CpuResult {
    /// The name of the timing table.
    pub table: String,
    /// The title of the table, one line.
    pub title: String,
    /// The names of the CPUs for which the table gives the times.
    pub cpus: Vec<String>,
    /// Whether an audit of the program uses this table: the one that the user names, otherwise the one for the
    /// program's CPU.
    pub is_own: bool,
    /// The CPU that the user names, otherwise the one that the program names. `None` for tables that an audit does not
    /// use (`is_own`), and if neither names one.
    pub cpu: Option<String>,
    /// The scan time, or the errors that prevent a bound, mostly instructions for which the table has no time.
    pub outcome: Result<CpuScanTime, Vec<Diagnostic>>,
}

impl CpuResult {
    /// Whether the program is proved to stay within the limit on this CPU. False if there is no limit.
    #[must_use]
    pub fn is_proved(&self) -> bool {
        let check = self.outcome.as_ref().ok().and_then(|found| found.check.as_ref());
        check.is_some_and(|check| check.verdict == Verdict::Proved)
    }
}

/// The bounds of the scan time by one table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CpuScanTime {
    /// The upper bound, with the points that were charged. `None` if a scan may never end.
    pub upper: Option<Picos>,
    /// The upper bound with all points that the CPU can have, where their number is not stated; elsewhere as `upper`.
    /// The limit is compared with this bound. `None` if a scan may never end.
    pub all_points: Option<Picos>,
    /// The admissible lower bound: the time of a scan that nothing known here excludes.
    pub lower: Picos,
    /// The largest share of the bound that can rest on assumed times.
    pub assumed: Share,
    /// The verdict on the limit. `None` if there is no limit, or if it is the watchdog time and that is unknown for
    /// this CPU.
    pub check: Option<Check>,
    /// All reasons why the bound may be too low, including unstated points.
    pub doubts: Vec<Doubt>,
    /// Whether the time limit or the user ended a stage early, so that the bound may be higher than necessary.
    pub is_cut: bool,
}

/// Audits a program with every built-in table of its family, and with the table that the user names. The program is
/// read and its value ranges are computed once. Each table may use the whole time limit.
///
/// # Errors
/// All faults of the program at once, or that the analysis and the interpreter disagree. Times that a table lacks are
/// no error: they are the outcome for that table.
pub fn compare_cpus(request: &Request<'_>, condition: CpuCheck) -> Result<CpuComparison, Failure> {
    let prepared = PreparedProject::of(request)?;
    let own = prepared.table().name.clone();
    let mut tables = prepared.table().family.as_deref().map(builtin::of_family).unwrap_or_default();
    if tables.iter().all(|table| table.name != own) {
        tables.extend(request.table.cloned().or_else(|| Table::builtin(&own)));
    }
    let files = prepared.program().files.iter().map(|file| file.name.clone()).collect();
    let mut choice = CpuComparison { files, condition, candidates: Vec::new() };
    for table in tables {
        let (name, title, cpus) = (table.name.clone(), table.title.clone(), table.cpus.clone());
        let is_own = name == own;
        let named = request.cpu.or(prepared.program().cpu.as_deref());
        let cpu = named.filter(|_| is_own).map(str::to_owned);
        let outcome = match prepared.with_table(table, request).priced(request) {
            Ok(followed) => Ok(scan_time_of(&conclude(followed, request)?.audit, condition)),
            Err(Failure::Input(faults)) => Err(faults),
            Err(why) => return Err(why),
        };
        choice.candidates.push(CpuResult { table: name, title, cpus, is_own, cpu, outcome });
    }
    choice.candidates.sort_by_key(|one| {
        let found = one.outcome.as_ref().ok();
        let bound = found.map(|found| found.upper.unwrap_or(Picos(u64::MAX)));
        (bound.is_none(), Reverse(bound))
    });
    Ok(choice)
}

fn scan_time_of(audit: &Audit, condition: CpuCheck) -> CpuScanTime {
    let check = match condition.limit {
        None => None,
        Some(Limit::Time(limit)) => Some(Check::new(audit, limit, condition.margin)),
        Some(Limit::Watchdog) => Check::of_watchdog(audit, condition.margin),
    };
    let check = check.map(|check| match condition.max_assumed {
        Some(most) => check.if_assumed_at_most(audit, most),
        None => check,
    });
    CpuScanTime {
        upper: audit.unbounded.is_empty().then_some(audit.bound.upper),
        all_points: audit.unbounded.is_empty().then_some(audit.upper_with_all_points()),
        lower: audit.bound.lower,
        assumed: audit.assumed_share(),
        check,
        doubts: audit.all_doubts(),
        is_cut: !audit.cuts.is_empty(),
    }
}

//! One program by every table of its family as JSON, schema `scanbound.cpus/1` (docs/json.md).

use scanbound_audit::cpus::{CpuComparison, CpuResult, Limit};
use scanbound_audit::verdict::{Check, Verdict};
use scanbound_base::diagnostic::Diagnostic;
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};

#[derive(Serialize, JsonSchema)]
pub(crate) struct Report<'a> {
    schema: &'static str,
    files: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    limit: Option<Asked>,
    #[serde(skip_serializing_if = "Option::is_none")]
    slowest: Option<&'a str>,
    tables: Vec<Row<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Asked {
    #[serde(skip_serializing_if = "Option::is_none")]
    ps: Option<u64>,
    watchdog: bool,
    margin: String,
}

#[derive(Serialize, JsonSchema)]
struct Row<'a> {
    name: &'a str,
    title: &'a str,
    cpus: &'a [String],
    own: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    bound: Option<Bound>,
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<Verdicts>,
    faults: Vec<Fault<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Bound {
    upper_ps: Option<u64>,
    lower_ps: u64,
    upper_with_all_points_ps: Option<u64>,
    assumed_thousandths: u64,
    cut_short: bool,
    doubts: Vec<String>,
}

#[derive(Serialize, JsonSchema)]
struct Verdicts {
    limit_ps: u64,
    upper_with_margin_ps: u64,
    verdict: &'static str,
    reasons: Vec<String>,
}

#[derive(Serialize, JsonSchema)]
struct Fault<'a> {
    code: &'static str,
    file: &'a str,
    line: Option<u32>,
    message: &'a str,
}

/// Writes the choice on indented lines.
///
/// # Errors
/// Where what is written to takes no more.
pub fn write(choice: &CpuComparison, out: &mut dyn Write) -> io::Result<()> {
    let report = Report {
        schema: "scanbound.cpus/1",
        files: &choice.files,
        limit: choice.condition.limit.map(|limit| Asked {
            ps: match limit {
                Limit::Time(time) => Some(time.0),
                Limit::Watchdog => None,
            },
            watchdog: limit == Limit::Watchdog,
            margin: choice.condition.margin.to_string(),
        }),
        slowest: choice.slowest().map(|one| one.table.as_str()),
        tables: choice.candidates.iter().map(row).collect(),
    };
    serde_json::to_writer_pretty(&mut *out, &report)?;
    out.write_all(b"\n")
}

fn row(one: &CpuResult) -> Row<'_> {
    let found = one.outcome.as_ref().ok();
    let faults = one.outcome.as_ref().err();
    Row {
        name: &one.table,
        title: &one.title,
        cpus: &one.cpus,
        own: one.is_own,
        bound: found.map(|found| Bound {
            upper_ps: found.upper.map(|time| time.0),
            lower_ps: found.lower.0,
            upper_with_all_points_ps: found.all_points.map(|time| time.0),
            assumed_thousandths: found.assumed.0,
            cut_short: found.is_cut,
            doubts: found.doubts.iter().map(ToString::to_string).collect(),
        }),
        check: found.and_then(|found| found.check.as_ref()).map(check),
        faults: faults.into_iter().flatten().map(fault).collect(),
    }
}

fn check(check: &Check) -> Verdicts {
    Verdicts {
        limit_ps: check.limit.0,
        upper_with_margin_ps: check.upper.0,
        verdict: check.verdict.name(),
        reasons: match &check.verdict {
            Verdict::Undecided(reasons) => reasons.iter().map(ToString::to_string).collect(),
            Verdict::Proved | Verdict::Refuted => Vec::new(),
        },
    }
}

fn fault(fault: &Diagnostic) -> Fault<'_> {
    Fault { code: fault.code.name(), file: &fault.file, line: fault.line, message: &fault.message }
}

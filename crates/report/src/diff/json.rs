//! The difference of two versions as JSON, schema `scanbound.diff/1` (docs/json.md).

use scanbound_audit::difference::{Change, Difference, Side};
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};

#[derive(Serialize, JsonSchema)]
pub(crate) struct Report<'a> {
    schema: &'static str,
    old: Version<'a>,
    new: Version<'a>,
    delta_ps: i64,
    delta_thousandths: i64,
    besides_ps: i64,
    doubtful: bool,
    endless: bool,
    above_allowed: bool,
    unchanged: usize,
    changes: Vec<Row<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Version<'a> {
    files: &'a [String],
    upper_ps: u64,
}

#[derive(Serialize, JsonSchema)]
struct Row<'a> {
    kind: &'static str,
    delta_ps: i64,
    #[serde(skip_serializing_if = "Option::is_none")]
    old: Option<Rung<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    new: Option<Rung<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Rung<'a> {
    file: u32,
    line: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<u32>,
    text: &'a str,
    ps: u64,
}

/// Writes the difference on indented lines.
pub(crate) fn write(found: &Difference, out: &mut dyn Write) -> io::Result<()> {
    let report = Report {
        schema: "scanbound.diff/1",
        old: Version { files: &found.old_files, upper_ps: found.old.0 },
        new: Version { files: &found.new_files, upper_ps: found.new.0 },
        delta_ps: number(found.delta()),
        delta_thousandths: number(found.thousandths()),
        besides_ps: number(found.besides),
        doubtful: found.is_doubtful,
        endless: found.is_endless,
        above_allowed: found.is_above(),
        unchanged: found.unchanged,
        changes: found.changes.iter().map(row).collect(),
    };
    serde_json::to_writer_pretty(&mut *out, &report)?;
    out.write_all(b"\n")
}

/// Times are below 213 days, so that differences fit.
fn number(delta: i128) -> i64 {
    i64::try_from(delta).unwrap_or(if delta < 0 { i64::MIN } else { i64::MAX })
}

fn row(one: &Change) -> Row<'_> {
    Row {
        kind: one.kind.name(),
        delta_ps: number(one.delta()),
        old: one.old.as_ref().map(rung),
        new: one.new.as_ref().map(rung),
    }
}

fn rung(side: &Side) -> Rung<'_> {
    Rung {
        file: side.at.file,
        line: side.at.line,
        step: side.at.step,
        text: &side.text,
        ps: side.time.0,
    }
}

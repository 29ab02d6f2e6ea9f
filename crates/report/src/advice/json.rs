//! Which statement lowers a bound most as JSON, schema `scanbound.advice/1` (docs/json.md).

use scanbound_audit::advise::{Advice, Measured};
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};
use std::ops::Not;

#[derive(Serialize, JsonSchema)]
pub(crate) struct Report<'a> {
    schema: &'static str,
    files: &'a [String],
    upper_ps: Option<u64>,
    advice: Vec<Row<'a>>,
    useless: usize,
    untried: usize,
}

#[derive(Serialize, JsonSchema)]
struct Row<'a> {
    kind: &'static str,
    table: &'static str,
    fact: &'a str,
    what: &'a str,
    upper_ps: u64,
    #[serde(skip_serializing_if = "Not::not")]
    cut: bool,
    gain_ps: u64,
    places: Vec<Place<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Place<'a> {
    file: u32,
    line: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<u32>,
    instruction: &'a str,
}

/// Writes the advice on indented lines.
///
/// # Errors
/// Where what is written to takes no more.
pub fn write(advice: &Advice, out: &mut dyn Write) -> io::Result<()> {
    let report = Report {
        schema: "scanbound.advice/1",
        files: &advice.files,
        upper_ps: advice.upper.map(|upper| upper.0),
        advice: advice.found.iter().map(|one| row(advice, one)).collect(),
        useless: advice.useless,
        untried: advice.untried,
    };
    serde_json::to_writer_pretty(&mut *out, &report)?;
    out.write_all(b"\n")
}

fn row<'a>(advice: &Advice, one: &'a Measured) -> Row<'a> {
    let gain =
        advice.upper.and_then(|upper| upper.checked_sub(one.bound.upper)).unwrap_or_default();
    let places = one.statement.places.iter().map(|(at, instruction)| Place {
        file: at.file,
        line: at.line,
        step: at.step,
        instruction,
    });
    Row {
        kind: one.statement.kind.name(),
        table: one.statement.table,
        fact: &one.statement.line,
        what: &one.statement.what,
        upper_ps: one.bound.upper.0,
        cut: one.bound.cut,
        gain_ps: gain.0,
        places: places.collect(),
    }
}

//! What is known of an instruction as JSON, schema `scanbound.explain/1` (docs/json.md).

use scanbound_audit::explain::{ExplainedInstruction, FormUse};
use scanbound_timing::table::Row;
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};

#[derive(Serialize, JsonSchema)]
pub(crate) struct Report<'a> {
    schema: &'static str,
    name: &'a str,
    tables: Vec<Of<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Of<'a> {
    name: &'a str,
    title: &'a str,
    variants: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    factor: Option<&'a str>,
    forms: Vec<Form<'a>>,
    extras: Vec<Times<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Form<'a> {
    line: &'a str,
    class: &'static str,
    by_class: bool,
    on_ps: Option<u64>,
    off_ps: Option<u64>,
    follow: &'static str,
    approximations: &'a [String],
    rows: Vec<Times<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Times<'a> {
    name: &'a str,
    on_ps: u64,
    off_ps: u64,
    per_unit_ps: u64,
    unit: &'a str,
    evidence: &'static str,
    source: &'a str,
}

/// Writes an instruction by some tables on indented lines.
///
/// # Errors
/// Where what is written to takes no more.
pub fn write(found: &[ExplainedInstruction], out: &mut dyn Write) -> io::Result<()> {
    let report = Report {
        schema: "scanbound.explain/1",
        name: found.first().map_or("", |one| one.name.as_str()),
        tables: found.iter().map(of).collect(),
    };
    serde_json::to_writer_pretty(&mut *out, &report)?;
    out.write_all(b"\n")
}

fn of(found: &ExplainedInstruction) -> Of<'_> {
    Of {
        name: &found.table,
        title: &found.title,
        variants: &found.variants,
        factor: found.factor.as_ref().map(|factor| factor.text.as_str()),
        forms: found.forms.iter().map(form).collect(),
        extras: found.extras.iter().map(times).collect(),
    }
}

fn form(form: &FormUse) -> Form<'_> {
    Form {
        line: &form.line,
        class: form.class,
        by_class: form.by_class,
        on_ps: form.price.as_ref().map(|price| price.on.0),
        off_ps: form.price.as_ref().map(|price| price.off.0),
        follow: form.follow.name(),
        approximations: &form.approximations,
        rows: form.rows.iter().map(times).collect(),
    }
}

fn times(row: &Row) -> Times<'_> {
    Times {
        name: &row.name,
        on_ps: row.on.0,
        off_ps: row.off.0,
        per_unit_ps: row.per_unit.0,
        unit: &row.unit,
        evidence: row.evidence.word(),
        source: &row.source,
    }
}

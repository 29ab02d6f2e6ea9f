//! What of a project is read and what stands in the way of a bound as JSON, schema `scanbound.doctor/1` (docs/json.md).

use scanbound_audit::doctor::{Diagnosis, ExaminedFile, ExaminedKind, Finding};
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};

#[derive(Serialize, JsonSchema)]
pub(crate) struct Report<'a> {
    schema: &'static str,
    sound: bool,
    files: Vec<File<'a>>,
    cpu: Option<&'a str>,
    table: Option<&'a str>,
    findings: Vec<Row<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct File<'a> {
    name: &'a str,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    dialect: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    instructions: Option<usize>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    standby: bool,
}

#[derive(Serialize, JsonSchema)]
struct Row<'a> {
    section: &'static str,
    grave: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    code: Option<&'static str>,
    message: &'a str,
    help: &'a str,
    places: Vec<Place<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Place<'a> {
    file: &'a str,
    line: Option<u32>,
}

/// Writes the diagnosis on indented lines.
///
/// # Errors
/// Where what is written to takes no more.
pub fn write(found: &Diagnosis, out: &mut dyn Write) -> io::Result<()> {
    let report = Report {
        schema: "scanbound.doctor/1",
        sound: found.is_sound(),
        files: found.files.iter().map(file).collect(),
        cpu: found.cpu.as_deref(),
        table: found.table.as_deref(),
        findings: found.findings.iter().map(row).collect(),
    };
    serde_json::to_writer_pretty(&mut *out, &report)?;
    out.write_all(b"\n")
}

fn file(seen: &ExaminedFile) -> File<'_> {
    let (kind, dialect) = match seen.what {
        ExaminedKind::Program(dialect) => ("program", Some(dialect)),
        ExaminedKind::Comments => ("comments", None),
        ExaminedKind::Refused => ("refused", None),
    };
    let ExaminedFile { name, instructions, standby, .. } = seen;
    File { name, kind, dialect, instructions: *instructions, standby: *standby }
}

fn row(one: &Finding) -> Row<'_> {
    Row {
        section: one.section.name(),
        grave: one.section.is_grave(),
        code: one.code.map(|code| code.name()),
        message: &one.message,
        help: &one.help,
        places: one.places.iter().map(|(file, line)| Place { file, line: *line }).collect(),
    }
}

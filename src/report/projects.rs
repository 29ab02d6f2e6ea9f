//! The checks of several projects as one JSON document, schema `scanbound.checks/1` (docs/json.md), written project by
//! project.

use super::json;
use crate::audit::Audit;
use crate::audit::verdict::Check;
use crate::base::diagnostic::Diagnostic;
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};

/// The document's schema.
pub(super) const SCHEMA: &str = "scanbound.checks/1";

/// What became of a project's check.
pub enum Checked<'a> {
    /// It was audited.
    Audited(&'a Audit, &'a Check),
    /// It was not, for these faults.
    Faulty(&'a [Diagnostic]),
    /// It was not, for what this says.
    Failed(String),
}

#[derive(Serialize, JsonSchema)]
pub(super) struct Project<'a> {
    file: &'a str,
    exit_code: u8,
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<json::Report<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    errors: Vec<Fault<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Fault<'a> {
    code: Option<&'a str>,
    file: Option<&'a str>,
    line: Option<u32>,
    message: &'a str,
    help: Option<&'a str>,
}

/// Writes what stands before the first project.
///
/// # Errors
/// Where what is written to takes no more.
pub fn begin(out: &mut dyn Write) -> io::Result<()> {
    write!(out, "{{\n\"schema\": \"{SCHEMA}\",\n\"projects\": [")
}

/// Writes a project, told by its file: the `number`-th, from 0.
///
/// # Errors
/// As for [`begin`].
pub fn project(
    number: usize,
    file: &str,
    exit_code: u8,
    checked: &Checked<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let (report, errors) = match checked {
        Checked::Audited(audit, check) => (Some(json::report(audit, Some(check))), Vec::new()),
        Checked::Faulty(faults) => (None, faults.iter().map(fault).collect()),
        Checked::Failed(message) => {
            (None, vec![Fault { code: None, file: None, line: None, message, help: None }])
        }
    };
    out.write_all(if number == 0 { b"\n" } else { b",\n" })?;
    serde_json::to_writer_pretty(&mut *out, &Project { file, exit_code, report, errors })?;
    Ok(())
}

/// Writes what stands behind the last project.
///
/// # Errors
/// As for [`begin`].
pub fn end(out: &mut dyn Write) -> io::Result<()> {
    out.write_all(b"\n]\n}\n")
}

fn fault(one: &Diagnostic) -> Fault<'_> {
    Fault {
        code: Some(one.code.name()),
        file: Some(one.file.as_str()).filter(|file| !file.is_empty()),
        line: one.line,
        message: &one.message,
        help: Some(&one.help),
    }
}

//! The checks of several projects as one JSON document, schema `scanbound.checks/1` (docs/json.md), written project by
//! project.

use crate::format::{self, Checked, Checks, Extent};
use scanbound_base::diagnostic::Diagnostic;
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};

/// The document's schema.
pub(crate) const SCHEMA: &str = "scanbound.checks/1";

#[derive(Serialize, JsonSchema)]
pub(crate) struct Project<'a> {
    file: &'a str,
    exit_code: u8,
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<super::Report<'a>>,
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

/// The document while it is written.
#[derive(Default)]
pub(super) struct Document {
    written: usize,
}

impl Document {
    fn begin(&self, out: &mut dyn Write) -> io::Result<()> {
        match self.written {
            0 => write!(out, "{{\n\"schema\": \"{SCHEMA}\",\n\"projects\": [\n"),
            _ => out.write_all(b",\n"),
        }
    }
}

impl Checks for Document {
    fn add(
        &mut self,
        project: &format::Project<'_>,
        _: Extent,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let (report, errors) = match &project.checked {
            Checked::Audited(audit, check) => (Some(super::report(audit, Some(check))), Vec::new()),
            Checked::Faulty(faults) => (None, faults.iter().map(fault).collect()),
            Checked::Failed(message) => {
                (None, vec![Fault { code: None, file: None, line: None, message, help: None }])
            }
        };
        self.begin(out)?;
        self.written += 1;
        let format::Project { file, exit_code, .. } = *project;
        serde_json::to_writer_pretty(&mut *out, &Project { file, exit_code, report, errors })?;
        Ok(())
    }

    fn end(&mut self, out: &mut dyn Write) -> io::Result<()> {
        if self.written == 0 {
            self.begin(out)?;
        }
        out.write_all(b"\n]\n}\n")
    }
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

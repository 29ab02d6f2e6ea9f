//! The languages of IEC 61131-3, as PLCopen XML and as text: charts, ladder and function block diagrams, structured text
//! and instruction lists, as one program.
//!
//! What is read stands in [`crate::iec`]; this says what it means to the analysis. A unit's instance is a routine with
//! memory of its own, a chart is bits of steps and of stored actions that nobody else writes (`docs/sfc.md`).

mod address;
mod arithmetic;
mod begin;
mod block;
mod by_reference;
mod chart;
pub mod charts;
mod connected;
mod control;
mod convert;
mod counted;
pub mod decode;
mod differs;
mod emit;
mod enable;
mod expr;
mod extent;
mod first_values;
mod forget;
mod function;
mod invariant;
mod loops;
mod memory;
mod method;
mod mixed;
mod numbered;
mod open;
mod operands;
mod reach;
mod refer;
mod references;
mod resolve;
mod retained;
mod selected;
mod stand_in;
mod statement;
mod step_time;
mod tally;
mod timer;
mod turns;
mod types;
mod value;
mod walk;
mod whole;
mod within;

use super::{Dialect, Front, Input, Project, Sniff, decoded};
use crate::base::diagnostic::Diagnostic;
use crate::iec::{self, parse, xml};
use crate::program::Program;

/// PLCopen XML.
pub const XML: &str = "plcopen-xml";
/// Text.
pub const TEXT: &str = "iec-text";

static DIALECTS: [Dialect; 2] = [
    Dialect {
        name: XML,
        what: "PLCopen TC6 XML (SFC, LD, FBD, ST, IL)",
        sniff: Sniff::Text(xml::begins),
    },
    Dialect {
        name: TEXT,
        what: "IEC 61131-3 in text (PROGRAM, FUNCTION_BLOCK; SFC, ST, IL)",
        sniff: Sniff::Text(parse::is_units),
    },
];

/// The languages of IEC 61131-3.
pub struct Iec;

/// The registry's entry.
pub const FRONT: Iec = Iec;

/// What the files of a project say.
#[derive(Debug)]
pub struct Source {
    dialect: &'static str,
    project: iec::Project,
    options: decode::Options,
}

impl Front for Iec {
    fn dialects(&self) -> &'static [Dialect] {
        &DIALECTS
    }

    fn read(
        &self,
        dialect: &Dialect,
        programs: &[&Input],
        _beside: &[&Input],
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        let mut project = iec::Project::default();
        let mut options = decode::Options::default();
        let mut faults = Vec::new();
        for input in programs {
            let text = match decoded(input, &[]) {
                Ok(text) => text,
                Err(fault) => {
                    faults.push(fault);
                    continue;
                }
            };
            options.begins_with_more |= text.contains("call_after_");
            options.actions_first |= text.contains("3s-software.com");
            match iec::read(&input.name, &text) {
                Ok(more) => project.join(more),
                Err(more) => {
                    faults.extend(more.into_iter().map(|fault| fault.in_file(&input.name)))
                }
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        project.inherit_parts();
        let dialect =
            DIALECTS.iter().find(|own| own.name == dialect.name).map_or(XML, |own| own.name);
        Ok(Box::new(Source { dialect, project, options }))
    }
}

impl Project for Source {
    fn cpu(&self) -> Option<&str> {
        Some("IEC")
    }

    fn warnings(&self) -> Vec<Diagnostic> {
        charts::hang(&self.project)
    }

    fn decode(&self, options: &super::Options<'_>) -> Result<Program, Vec<Diagnostic>> {
        decode::decode(&self.project, self.dialect, self.options, options)
    }
}

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
mod constants;
mod control;
mod convert;
mod counted;
mod declared;
pub mod decode;
mod differs;
mod emit;
mod enable;
mod expr;
mod extent;
mod first_values;
mod forget;
mod function;
mod inputs;
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
use crate::base::code::Code;
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
    /// The drawings, to find the elements that faults are about.
    drawn: Vec<(String, String)>,
}

impl Source {
    /// The same faults with the elements of drawings that ask for what is not there.
    fn placed(&self, mut faults: Vec<Diagnostic>) -> Vec<Diagnostic> {
        for (name, text) in &self.drawn {
            let own: Vec<usize> = (0..faults.len())
                .filter(|&at| faults[at].code == Code::UnknownName && faults[at].file == *name)
                .collect();
            if own.is_empty() {
                continue;
            }
            let asked: Vec<(u32, &str)> = own
                .iter()
                .map(|&at| (faults[at].line.unwrap_or(0), faults[at].text.as_str()))
                .collect();
            let found = xml::named(text, &asked);
            for (at, found) in own.into_iter().zip(found) {
                let fault = &mut faults[at];
                if let Some(found) = found {
                    let why = fault.message.rsplit_once(": ").map_or("", |(_, why)| why);
                    fault.message = format!("{found}: {why}");
                }
            }
        }
        faults
    }
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
        let mut drawn = Vec::new();
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
                Ok(more) => {
                    project.join(more);
                    if xml::begins(&text) {
                        drawn.push((input.name.clone(), text.into_owned()));
                    }
                }
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
        Ok(Box::new(Source { dialect, project, options, drawn }))
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
        let decoded = decode::decode(&self.project, self.dialect, self.options, options);
        decoded.map_err(|faults| self.placed(faults))
    }
}

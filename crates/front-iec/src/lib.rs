//! Front end for IEC 61131-3: reads SFC charts, ladder (LD) and function block diagrams (FBD), structured text (ST) and
//! instruction lists (IL), from PLCopen XML or text files, and lowers a project to one program.
//!
//! The crate [`scanbound_iec`] parses the files; this crate lowers what it parsed. Each instance of a unit (PROGRAM,
//! FUNCTION_BLOCK, FUNCTION) becomes a routine with memory of its own. A chart becomes bits for its steps and stored
//! actions that no other code writes (`docs/sfc.md`).

mod assembler;
pub mod charts;
mod lower;

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::encoding::candidates;
use scanbound_front::{
    Dialect, Front, Input, MachineOptions, Project, Sniff, SourceOptions, decoded,
};
use scanbound_iec::fault::Fault;
use scanbound_iec::{parse, xml};
use scanbound_iec_tree::blocks::StandardBlock;
use scanbound_ir::Program;
use std::borrow::Cow;

/// Name of the dialect for PLCopen XML files.
pub const XML: &str = "plcopen-xml";
/// Name of the dialect for IEC 61131-3 source text.
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

/// The front end for the two IEC 61131-3 dialects, [`XML`] and [`TEXT`].
pub struct Iec;

/// The front end as it is registered in the list of front ends.
pub const FRONT: Iec = Iec;

/// A parsed IEC project, not lowered yet.
#[derive(Debug)]
pub struct Source {
    dialect: &'static str,
    project: scanbound_iec::Project,
    options: lower::SourceTraits,
    /// Warnings from reading the files, such as a guessed text encoding.
    warnings: Vec<Diagnostic>,
}

/// Decodes a file. A text file that is neither UTF-8 nor marked with its encoding is read in the first encoding that
/// fits, with a warning. It is an error if another candidate encoding would give different code.
fn source_text<'a>(
    input: &'a Input,
    warnings: &mut Vec<Diagnostic>,
) -> Result<Cow<'a, str>, Diagnostic> {
    let candidates = candidates(&input.bytes);
    let is_xml = candidates.first().is_some_and(|(_, text)| xml::begins(text));
    let [(name, text), others @ ..] = &candidates[..] else { return decoded(input, &[]) };
    if is_xml {
        return decoded(input, &[]);
    }
    let help =
        "state the encoding with --encoding (such as windows-1252), or save the file as UTF-8";
    if let Some((other, _)) = others.iter().find(|(_, other)| !parse::reads_alike(text, other)) {
        let told =
            format!("this file is not UTF-8, and reads differently as {name} and as {other}");
        return Err(Diagnostic::file(Code::Encoding, &input.name, told, help));
    }
    let told = format!(
        "this file is not UTF-8: it was read as {name}. In other encodings its code is the same, but comments may differ"
    );
    warnings.push(Diagnostic::file(Code::Encoding, &input.name, told, help).warning());
    Ok(text.clone())
}

/// Finds a standard block that the text takes from a library by a qualified name (`LIB.TON`), while the project
/// declares a unit of the same name. Returns the fault at the first such line, or None.
fn of_library(project: &scanbound_iec::Project, text: &str) -> Option<Fault> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let own = project.pous.iter().filter(|pou| StandardBlock::named(&pou.name).is_some());
    for pou in own {
        for (number, line) in text.lines().enumerate() {
            let upper = line.to_ascii_uppercase();
            let found = upper.match_indices(&pou.name.to_ascii_uppercase()).any(|(at, name)| {
                upper[..at].trim_end().strip_suffix('.').is_some_and(|before| {
                    before.trim_end().ends_with(is_word)
                        && !upper[at + name.len()..].starts_with(is_word)
                })
            });
            if found {
                let told = format!(
                    "{} of a library is used here, and the project has a unit of the same name",
                    pou.name
                );
                let help = "give the project's unit another name: it is not known which of the two is meant";
                let line_number = u32::try_from(number + 1).unwrap_or(u32::MAX);
                let fault = Fault::new(line_number, told).code(Code::DeclaredTwice);
                return Some(fault.text(line.trim()).help(help));
            }
        }
    }
    None
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
        reading: SourceOptions,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        let mut project = scanbound_iec::Project::default();
        let mut options = lower::SourceTraits::default();
        let (mut faults, mut warnings, mut texts) = (Vec::new(), Vec::new(), Vec::new());
        for input in programs {
            let text = match source_text(input, &mut warnings) {
                Ok(text) => text,
                Err(fault) => {
                    faults.push(fault);
                    continue;
                }
            };
            options.begins_with_more |= text.to_ascii_lowercase().contains("call_after_");
            match scanbound_iec::read_as(&input.name, &text, reading.comments) {
                Ok(more) => {
                    project.join(more);
                    texts.push(text);
                }
                Err(more) => {
                    faults.extend(more.into_iter().map(|fault| fault.in_file(&input.name)))
                }
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        for (input, text) in programs.iter().zip(&texts) {
            faults.extend(of_library(&project, text).map(|fault| fault.in_file(&input.name)));
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        project.inherit_parts();
        project.name_lists();
        let dialect =
            DIALECTS.iter().find(|own| own.name == dialect.name).map_or(XML, |own| own.name);
        Ok(Box::new(Source { dialect, project, options, warnings }))
    }
}

impl Project for Source {
    fn cpu(&self) -> Option<&str> {
        Some("IEC")
    }

    fn machine_options(&self) -> MachineOptions {
        MachineOptions { controller: true, ..MachineOptions::default() }
    }

    fn warnings(&self) -> Vec<Diagnostic> {
        let charts = charts::hang(&self.project);
        self.warnings.iter().cloned().chain(charts).collect()
    }

    fn decode(&self, options: &scanbound_front::Options<'_>) -> Result<Program, Vec<Diagnostic>> {
        lower::decode(&self.project, self.dialect, self.options, false, options)
    }
}

//! The MELSEC dialects: GX Works2 and GX Works3 CSV exports, and list text.

mod catalog;
mod comments;
mod csv;
pub mod decode;
mod examples;
mod list;
mod lower;
pub mod memory;
mod mnemonic;
pub mod operand;
pub mod project;
mod resolve;
pub mod source;
mod structure;
#[cfg(test)]
mod tests;
mod words;

use decode::DecodeOptions;
use memory::Family;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{
    Dialect, Examples, Front, Input, MachineOptions, Options, Project, Sniff, SourceOptions,
};
use scanbound_ir::Program;
use source::RawProject;

/// The dialects of this front. All are text files, recognised by their beginning.
static DIALECTS: [Dialect; 3] = [
    Dialect {
        name: "melsec-csv",
        what: "a program's CSV from GX Works2 or GX Developer",
        sniff: Sniff::Text(|text| {
            csv::layout(text).is_some_and(|layout| layout.tool == csv::Tool::Works2)
        }),
    },
    Dialect {
        name: "melsec-gx3-csv",
        what: "a program's CSV from GX Works3",
        sniff: Sniff::Text(|text| {
            csv::layout(text).is_some_and(|layout| layout.tool == csv::Tool::Works3)
        }),
    },
    Dialect {
        name: list::DIALECT,
        what: "MELSEC list text (LD X0, one instruction per line)",
        sniff: Sniff::Text(list::sniff),
    },
];

/// Reads MELSEC programs: the implementation of [`Front`] for the three dialects.
pub struct Melsec;

/// The value of [`Melsec`] that the list of all fronts contains.
pub const FRONT: Melsec = Melsec;

impl Front for Melsec {
    fn dialects(&self) -> &'static [Dialect] {
        &DIALECTS
    }

    /// Whether a file holds device comments. Its contents decide; an empty file counts if it is named COMMENT, because
    /// the tools export that file even without comments.
    fn is_comment_file(&self, name: &str, beginning: &str) -> bool {
        let is_named = || scanbound_front::stem(name).eq_ignore_ascii_case("COMMENT");
        comments::sniff(beginning) || (beginning.trim().is_empty() && is_named())
    }

    fn known_words(&self) -> Vec<&'static str> {
        project::known_words()
    }

    fn instructions(&self) -> Vec<String> {
        examples::all()
    }

    fn examples(&self, name: &str, family: &str) -> Option<Examples> {
        examples::examples(name, Family::named(family)?)
    }

    fn read(
        &self,
        dialect: &Dialect,
        programs: &[&Input],
        comment_files: &[&Input],
        _reading: SourceOptions,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        Ok(Box::new(project::read(dialect, programs, comment_files)?))
    }
}

impl Project for RawProject {
    fn cpu(&self) -> Option<&str> {
        self.files.iter().find_map(|file| file.cpu.as_deref())
    }

    fn warnings(&self) -> Vec<Diagnostic> {
        self.warnings.clone()
    }

    fn machine_options(&self) -> MachineOptions {
        MachineOptions { index: true, ..MachineOptions::default() }
    }

    fn decode(&self, options: &Options<'_>) -> Result<Program, Vec<Diagnostic>> {
        let Options { facts, is_user_instruction, absent_calls_take_no_time, .. } = *options;
        let cpu = options.cpu.or(self.cpu());
        let named = || options.family.and_then(Family::named);
        let family = cpu.and_then(Family::of_cpu).or_else(named).unwrap_or(Family::Q);
        let options =
            DecodeOptions { family, is_user_instruction, facts, absent_calls_take_no_time };
        decode::decode(self, &options)
    }
}

//! The OMRON dialects: mnemonics in the notations of the C200H and of CX-Programmer, and CX-Programmer's text files.

mod accessed;
mod application;
mod builder;
mod catalog;
mod cxt;
mod data;
mod decode;
mod exact;
mod examples;
mod extent;
mod list;
mod loops;
mod lower;
mod memory;
mod operand;
pub mod project;
mod resolve;
pub mod source;
mod structure;
mod symbols;
#[cfg(test)]
mod tests;
mod timers;
mod words;

use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{Dialect, Examples, Front, Input, Options, Project, Sniff, SourceOptions};
use scanbound_ir::Program;
use source::{C, CX, CXT, RawProject};

/// The dialects, and how each is recognised.
static DIALECTS: [Dialect; 3] = [
    Dialect {
        name: C,
        what: "OMRON mnemonics as for C200H (LD NOT 00300, MOV(21))",
        sniff: Sniff::Text(list::sniff_c),
    },
    Dialect {
        name: CX,
        what: "OMRON mnemonics as in CX-Programmer (LDNOT 0.00, MOV(021))",
        sniff: Sniff::Text(list::sniff_cx),
    },
    Dialect {
        name: CXT,
        what: "a CX-Programmer project saved as text (.cxt)",
        sniff: Sniff::Text(cxt::sniff),
    },
];

/// Reads OMRON programs: the implementation of [`Front`] for the three dialects.
pub struct Omron;

/// The value of [`Omron`] that the list of all fronts contains.
pub const FRONT: Omron = Omron;

impl Front for Omron {
    fn dialects(&self) -> &'static [Dialect] {
        &DIALECTS
    }

    fn is_comment_file(&self, _name: &str, beginning: &str) -> bool {
        symbols::sniff(beginning)
    }

    fn instructions(&self) -> Vec<String> {
        examples::all()
    }

    fn examples(&self, name: &str, family: &str) -> Option<Examples> {
        let family = match family {
            "c" => source::Family::C,
            "cs" => source::Family::Cs,
            _ => return None,
        };
        examples::examples(name, family)
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

    fn decode(&self, options: &Options<'_>) -> Result<Program, Vec<Diagnostic>> {
        decode::decode(self, options)
    }
}

//! Fronts: each reads the dialects of one kind of PLC and says what programs in them mean.
//!
//! A front is a directory and its line in `fronts!`. What is behind a [`Program`] knows none of them.

pub mod absent;
pub mod builder;
pub mod catalog;
pub mod encoding;
pub mod faults;
mod foreign;
pub mod numbering;
mod place;
mod registry;
pub mod specimen;
pub mod text;

use scanbound_base::code::Code;
use std::any::Any;
use std::fmt;

pub use encoding::Named as Encoding;
pub use faults::Faults;
pub use faults::shown;
pub use place::Places;
pub use place::{Pointer, spans, within};
pub use registry::{Fronts, Kind};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_iec::comment::Comments;
use scanbound_ir::Program;
pub use specimen::{Form, Specimen, Specimens};
pub use text::stem;
pub use text::{BEGINNING, decoded};

/// A file as it was handed over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// Its name as the user gave it.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

impl Input {
    /// Makes UTF-8 of text in an encoding; of what declares another one, is none of this one, or is an
    /// image of one of the fronts' dialects, nothing.
    pub fn recode(&mut self, encoding: Encoding, fronts: Fronts) {
        let mut images = fronts.dialects().filter_map(|dialect| match dialect.sniff {
            Sniff::Bytes(sniff) => Some(sniff),
            Sniff::Text(_) => None,
        });
        if images.any(|is_image| is_image(&self.bytes)) {
            return;
        }
        if let Some(text) = encoding.recoded(&self.bytes) {
            self.bytes = text.into_bytes();
        }
    }
}

/// A dialect: a way in which programs are written down.
#[derive(Debug, Clone, Copy)]
pub struct Dialect {
    /// Its name for `--dialect` and reports.
    pub name: &'static str,
    /// What it is, in words.
    pub what: &'static str,
    /// How its files are recognised.
    pub sniff: Sniff,
}

/// How files of a dialect are recognised. A file that two dialects claim is refused, so neither may claim in doubt.
#[derive(Debug, Clone, Copy)]
pub enum Sniff {
    /// Whether a file whose text begins so is written in it.
    Text(fn(&str) -> bool),
    /// Whether these bytes, which need not be text, are a whole file of it.
    Bytes(fn(&[u8]) -> bool),
}

/// What reads the dialects of one kind of PLC.
pub trait Front: Sync {
    /// Its dialects, and how each is recognised.
    fn dialects(&self) -> &'static [Dialect];

    /// Whether a file of this name that begins so is no program, and lies beside programs to name their devices.
    fn is_beside(&self, name: &str, beginning: &str) -> bool {
        let _ = (name, beginning);
        false
    }

    /// Words that files in its dialects hold, to tell code pages apart.
    fn marks(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// The names of the instructions that it knows.
    fn instructions(&self) -> Vec<String> {
        Vec::new()
    }

    /// Lines that show an instruction, by its name in upper case, of a family as timing tables name it; `None` if the family
    /// has none of this name, or is another front's.
    fn specimens(&self, name: &str, family: &str) -> Option<Specimens> {
        let _ = (name, family);
        None
    }

    /// Reads programs, all written in `dialect`, in the given order, and what lies beside them (not all of it need be
    /// this front's).
    ///
    /// # Errors
    /// The faults of all files.
    fn read(
        &self,
        dialect: &Dialect,
        programs: &[&Input],
        beside: &[&Input],
        reading: Reading,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>>;
}

/// How source text is read where its language leaves it open.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Reading {
    /// How comments that hold the beginning of another one are read; `None`: they are refused.
    pub comments: Option<Comments>,
}

/// A project as its front has read it: what its files say, nothing interpreted yet.
pub trait Project: Any + fmt::Debug {
    /// The CPU that it names, or that alone runs its dialect.
    fn cpu(&self) -> Option<&str>;

    /// What was noticed on reading and does not stop the audit.
    fn warnings(&self) -> Vec<Diagnostic> {
        Vec::new()
    }

    /// What of its machine the user may state.
    fn open(&self) -> Open {
        Open::default()
    }

    /// What it means.
    ///
    /// # Errors
    /// All faults of all files.
    fn decode(&self, options: &Options<'_>) -> Result<Program, Vec<Diagnostic>>;
}

impl dyn Project {
    /// The project as the front has it whose type this is; `None` if another read it.
    #[must_use]
    pub fn into_of<P: Project>(self: Box<dyn Project>) -> Option<P> {
        let any: Box<dyn Any> = self;
        any.downcast().ok().map(|project| *project)
    }
}

/// What the user may state of a machine; of other machines it is known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Open {
    /// The clock, of which each word of a program takes one period.
    pub clock: bool,
    /// Whether inputs are read once a scan.
    pub latched: bool,
    /// How indices and indirect addresses work: how many bits an index to extended registers has, which devices are
    /// written through `@`.
    pub index: bool,
}

/// What a front needs to know besides the source to say what it means.
pub struct Options<'a> {
    /// The CPU as the user names it.
    pub cpu: Option<&'a str>,
    /// The family that the timing table is for, as it names it.
    pub family: Option<&'a str>,
    /// Whether the timing table has an instruction of the user's of this name.
    pub is_user_instruction: &'a dyn Fn(&str) -> bool,
    /// What the user states.
    pub facts: &'a Facts,
    /// Whether calls of routines that are not there, and of which nothing is stated, are taken to take no time, to see what
    /// else a bound hangs on. Otherwise each is a fault.
    pub incomplete: bool,
    /// The task whose scan is asked for, where the project has several.
    pub task: Option<&'a str>,
    /// Whether that scan is asked for as if no other task interrupted it, whatever is stated.
    pub alone: bool,
    /// Whether others than the program may write its variables between scans.
    pub others_write: bool,
}

impl<'a> Options<'a> {
    /// Nothing but what the user states.
    #[must_use]
    pub fn new(facts: &'a Facts) -> Options<'a> {
        Options {
            cpu: None,
            family: None,
            is_user_instruction: &|_| false,
            facts,
            incomplete: false,
            task: None,
            alone: false,
            others_write: true,
        }
    }
}

/// Warns of files beside the programs that hold nothing.
pub fn empty_beside(beside: &[&Input]) -> Vec<Diagnostic> {
    let is_blank = |input: &&&Input| text::beginning(&input.bytes, &[]).trim().is_empty();
    let told = beside.iter().filter(is_blank).map(|input| {
        let help = "export the comments again if devices have any";
        Diagnostic::file(Code::EmptyFile, &input.name, "the device comments are empty", help)
            .warning()
    });
    told.collect()
}

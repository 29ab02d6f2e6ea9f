//! What a front is: its dialects, how it reads their files, and what these mean.

use super::example::Examples;
use super::input::Input;
use scanbound_base::budget::{Budget, StopReason};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_iec::comment::Comments;
use scanbound_ir::Program;
use std::any::Any;
use std::fmt;

/// A dialect: one format in which the programs of a kind of PLC are written, such as a tool's CSV export or an
/// instruction list.
#[derive(Debug, Clone, Copy)]
pub struct Dialect {
    /// The name of the dialect for `--dialect` and reports.
    pub name: &'static str,
    /// A description of the dialect's files for messages, with an example where it helps.
    pub what: &'static str,
    /// The test that recognises files of this dialect.
    pub sniff: Sniff,
}

/// How files of a dialect are recognised. The first dialect with [`Sniff::Bytes`] that accepts a file has it. Otherwise
/// exactly one with [`Sniff::Text`] must accept it: a file that two accept is refused, so each must reject doubtful
/// files.
#[derive(Debug, Clone, Copy)]
pub enum Sniff {
    /// Whether a file whose text begins like this is in the dialect. The text is that of its first 64 KiB.
    Text(fn(&str) -> bool),
    /// Whether these bytes, which may be binary, are a complete file of the dialect.
    Bytes(fn(&[u8]) -> bool),
}

/// Reads the dialects of one kind of PLC.
pub trait Front: Sync {
    /// All dialects of the front.
    fn dialects(&self) -> &'static [Dialect];

    /// Whether a file with this name and beginning holds device comments, not a program. False unless the front says
    /// otherwise.
    fn is_comment_file(&self, name: &str, beginning: &str) -> bool {
        let _ = (name, beginning);
        false
    }

    /// Words that occur in files of these dialects. They show which code page a file is in.
    fn known_words(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// The mnemonics of all instructions that the front knows. Empty if it has no catalog of instructions.
    fn instructions(&self) -> Vec<String> {
        Vec::new()
    }

    /// Example lines of an instruction. `name` is its mnemonic in upper case, `family` the CPU family as timing tables
    /// name it. `None` if this front does not have the family, or the family does not have the instruction.
    fn examples(&self, name: &str, family: &str) -> Option<Examples> {
        let _ = (name, family);
        None
    }

    /// Reads programs in one dialect, in the given order, and files with device comments. A file with device comments
    /// may belong to another front.
    ///
    /// # Errors
    /// The errors of all files; warnings may be among them. A front may list only some of a file's errors and count the
    /// others.
    fn read(
        &self,
        dialect: &Dialect,
        programs: &[&Input],
        comment_files: &[&Input],
        reading: SourceOptions,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>>;
}

/// How to read source text where the language standard allows several ways.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SourceOptions {
    /// How to read a comment that contains the beginning of another comment; `None`: refuse it.
    pub comments: Option<Comments>,
}

/// A project as its front has parsed it, before it is lowered to a [`Program`].
pub trait Project: Any + fmt::Debug {
    /// The CPU that the project names, or the only CPU that has its dialect. `None` if the project names none.
    fn cpu(&self) -> Option<&str>;

    /// Warnings about the files, which do not stop the audit. Empty unless the front says otherwise.
    fn warnings(&self) -> Vec<Diagnostic> {
        Vec::new()
    }

    /// Which properties of the project's PLC the user may state: none, unless the front says otherwise.
    fn machine_options(&self) -> MachineOptions {
        MachineOptions::default()
    }

    /// Lowers the project to a program.
    ///
    /// # Errors
    /// The errors of the files, options and facts that keep the front from making a program; warnings may be among
    /// them.
    fn decode(&self, options: &Options<'_>) -> Result<Program, Vec<Diagnostic>>;
}

impl dyn Project {
    /// The project as the type of one front; `None` if a different front read it.
    #[must_use]
    pub fn downcast<P: Project>(self: Box<dyn Project>) -> Option<P> {
        let any: Box<dyn Any> = self;
        any.downcast().ok().map(|project| *project)
    }
}

/// Which properties of a PLC the user may state. A field is false if the front knows the property, or does not need it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MachineOptions {
    /// Whether the user may state the clock: for PLCs that execute one program word in each clock period.
    pub clock: bool,
    /// Whether the user may state that the CPU reads its inputs only once in a scan.
    pub latched: bool,
    /// Whether the user may state how many bits an index to file registers and extended data registers has, and which
    /// devices are written through indirect addresses (`@D0`).
    pub index: bool,
    /// Whether the user may state where the controller behaves as IEC 61131-3 says and where it does not.
    pub controller: bool,
}

/// What a front needs to lower the source, besides the source itself.
pub struct Options<'a> {
    /// The CPU as the user named it. `None` if the user named none.
    pub cpu: Option<&'a str>,
    /// The CPU family of the timing table. `None` if it is unknown.
    pub family: Option<&'a str>,
    /// Whether the timing table has a user-defined instruction of this name.
    pub is_user_instruction: &'a dyn Fn(&str) -> bool,
    /// The user's facts.
    pub facts: &'a Facts,
    /// How to treat a call of a routine that is not in the files and whose time the facts do not state. `true`: the
    /// call takes no time, which makes the bound too low, but shows which other facts the bound needs. `false`: the
    /// call is an error.
    pub absent_calls_take_no_time: bool,
    /// The task whose scan is analysed, as the user named it. `None` if the user named none.
    pub task: Option<&'a str>,
    /// Whether the task's scan is analysed without interruptions by other tasks, even if the facts state them.
    pub uninterrupted: bool,
    /// Whether an HMI or a second PLC may write the program's variables between scans.
    pub others_write: bool,
    /// The time budget. If it is over before the source is lowered, there is no program and therefore no bound: that is
    /// an error ([`stopped`]). `None`: no limit.
    pub budget: Option<&'a Budget<'a>>,
}

impl<'a> Options<'a> {
    /// Options with these facts and nothing else stated: no CPU, family, task, time budget or user-defined
    /// instructions; others may write variables between scans.
    #[must_use]
    pub fn new(facts: &'a Facts) -> Options<'a> {
        Options {
            cpu: None,
            family: None,
            is_user_instruction: &|_| false,
            facts,
            absent_calls_take_no_time: false,
            task: None,
            uninterrupted: false,
            others_write: true,
            budget: None,
        }
    }
}

/// The error that the time limit, or the user, ended the audit before the source in `file` was lowered.
#[must_use]
pub fn stopped(reason: StopReason, file: &str) -> Diagnostic {
    let message = format!("{reason} ended the audit before the program was read");
    let help = match reason {
        StopReason::TimeLimit(_) => {
            "give the audit more time (--time-limit): there is no bound before the whole program is read"
        }
        StopReason::Cancelled => "there is no bound before the whole program is read",
    };
    Diagnostic::file(Code::Stopped, file, message, help)
}

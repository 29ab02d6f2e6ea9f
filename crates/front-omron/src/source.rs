//! A parsed OMRON project: programs of mnemonics and operands, not interpreted yet.

use std::collections::BTreeMap;
use std::sync::Arc;

use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{Caret, WordPositions};

/// The dialect name of the C200H notation.
pub const C: &str = "omron-c200h";
/// The dialect name of the CX-Programmer notation.
pub const CX: &str = "omron-cx";
/// The dialect name of CX-Programmer's text files.
pub const CXT: &str = "omron-cxt";

/// The memory map and the instruction set of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// C200H and similar (C200HS, C200HX, CQM1, CPM): two-digit function numbers, areas IR, HR, AR, LR, DM, and one
    /// area for timers and counters.
    C,
    /// CS, CJ, CP: three-digit function numbers, areas CIO, W, H, A, D, E, and separate areas for timers and counters.
    Cs,
}

/// A function number after a mnemonic, as in `MOV(21)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FunctionNumber {
    /// The number.
    pub value: u16,
    /// The number of digits as written: two on the C series, three on CS, CJ and CP.
    pub digits: u8,
}

/// The prefix that makes an instruction execute only on an edge of its condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// `@`
    Rising,
    /// `%`
    Falling,
}

/// One instruction as written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawInstruction {
    /// The line on which it begins, from 1.
    pub line: u32,
    /// Its program address, if the source has one.
    pub step: Option<u32>,
    /// The prefix `@` or `%`.
    pub edge: Option<Edge>,
    /// Whether it has the prefix `!` (immediate refresh).
    pub immediate: bool,
    /// The mnemonic in upper case (`LD NOT` as `LDNOT`); empty if only a function number is written.
    pub mnemonic: String,
    /// The function number, if written.
    pub number: Option<FunctionNumber>,
    /// The operands; an area and its number count as one (`DM 0100`).
    pub operands: Vec<String>,
    /// The source text with single blanks between words.
    pub text: Arc<str>,
    /// The positions of mnemonic and operands in the source.
    pub places: WordPositions,
}

impl RawInstruction {
    /// For diagnostics that point at a part of it; `source` is the text of its file.
    pub(crate) fn caret<'a>(&'a self, source: &'a str) -> Caret<'a> {
        Caret {
            line: self.line,
            text: &self.text,
            mnemonic: &self.mnemonic,
            operands: &self.operands,
            places: &self.places,
            source,
        }
    }
}

/// When a program runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// In each scan. This is the case for files that contain only mnemonics.
    Each,
    /// As the cyclic task with this number. The project may switch it off.
    Cyclic(u32),
    /// As the interrupt task with this number.
    Interrupt(u32),
}

/// A symbol: a name for an address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symbol {
    /// The address as written, or the value of a number.
    pub address: String,
    /// The data type as written (`BOOL`, `WORD[11]`, `NUMBER`).
    pub kind: String,
    /// The comment; may be empty.
    pub comment: String,
}

/// Symbols by name.
pub type Symbols = BTreeMap<String, Symbol>;

/// One program, which one task runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawProgram {
    /// Its name.
    pub name: String,
    /// When it runs.
    pub task: Task,
    /// Local symbols. They hide global ones of the same name.
    pub symbols: Symbols,
    /// The instructions in source order.
    pub instructions: Vec<RawInstruction>,
}

/// One file with its programs, in the order in which they run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RawFile {
    /// The file's name as the user gave it.
    pub name: String,
    /// The programs.
    pub programs: Vec<RawProgram>,
    /// Global symbols.
    pub symbols: Symbols,
    /// The CPU as the file names it (`CJ2M CPU33`).
    pub cpu: Option<String>,
    /// The file's text, to show lines of it.
    pub source: String,
}

/// A project: its files in the order in which they run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawProject {
    /// The dialect name of list text.
    pub dialect: &'static str,
    /// The memory map and instruction set.
    pub family: Family,
    /// The files.
    pub files: Vec<RawFile>,
    /// Warnings that do not stop the audit.
    pub warnings: Vec<Diagnostic>,
}

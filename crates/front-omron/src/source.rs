//! An OMRON project as its source has it: programs of mnemonics and operands, nothing interpreted yet.

use std::collections::BTreeMap;
use std::sync::Arc;

use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{Caret, WordPositions};

/// The name of the C200H's spelling.
pub const C: &str = "omron-c200h";
/// The name of CX-Programmer's spelling.
pub const CX: &str = "omron-cx";
/// The name of CX-Programmer's text files.
pub const CXT: &str = "omron-cxt";

/// Which memory map and which instruction set a program is written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// C200H and its kin (C200HS, C200HX, CQM1, CPM): two-digit functions, IR, HR, AR, LR, DM, one area for
    /// timers and counters.
    C,
    /// CS, CJ, CP: three-digit functions, CIO, W, H, A, D, E, timers apart from counters.
    Cs,
}

/// The function number behind a mnemonic, as in `MOV(21)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FunctionNumber {
    /// The number.
    pub value: u16,
    /// With how many digits it is written: two on the C series, three on CS, CJ and CP.
    pub digits: u8,
}

/// The mark in front of a mnemonic that confines it to an edge of its condition.
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
    /// Its program address, where the source gives one.
    pub step: Option<u32>,
    /// The mark `@` or `%`.
    pub edge: Option<Edge>,
    /// The mark `!`.
    pub immediate: bool,
    /// The mnemonic in upper case, `LD NOT` as `LDNOT`; empty where only the number is given.
    pub mnemonic: String,
    /// The function number, where one is written.
    pub number: Option<FunctionNumber>,
    /// The operands; an area and its number are one operand (`DM 0100`).
    pub operands: Vec<String>,
    /// As in the source, with one blank between each two words.
    pub text: Arc<str>,
    /// Where mnemonic and operands stand.
    pub places: WordPositions,
}

impl RawInstruction {
    /// What points at a part of it; `source` is its file's text.
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
    /// In each scan: a file that is handed over as a program.
    Each,
    /// As the cyclic task of this number, which the project may also hold back.
    Cyclic(u32),
    /// As the interrupt task of this number.
    Interrupt(u32),
}

/// A symbol: a name for an address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symbol {
    /// The address as written, or a number's value.
    pub address: String,
    /// The data type as written (`BOOL`, `WORD[11]`, `NUMBER`).
    pub kind: String,
    /// What it is for; may be empty.
    pub comment: String,
}

/// Symbols by name.
pub type Symbols = BTreeMap<String, Symbol>;

/// One program: what one task runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawProgram {
    /// Its name.
    pub name: String,
    /// When it runs.
    pub task: Task,
    /// Symbols of its own, which hide global ones of the same name.
    pub symbols: Symbols,
    /// The instructions, in the order of the source.
    pub instructions: Vec<RawInstruction>,
}

/// One file and its programs, in the order in which they run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RawFile {
    /// The file's name as the user gave it.
    pub name: String,
    /// The programs.
    pub programs: Vec<RawProgram>,
    /// Symbols of all programs.
    pub symbols: Symbols,
    /// The CPU as the file names it (`CJ2M CPU33`).
    pub cpu: Option<String>,
    /// Its text, for showing lines.
    pub source: String,
}

/// A project: its files in the order in which they run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawProject {
    /// The dialect's name.
    pub dialect: &'static str,
    /// The memory map and instruction set.
    pub family: Family,
    /// The files.
    pub files: Vec<RawFile>,
    /// What was noticed but does not stop the audit.
    pub warnings: Vec<Diagnostic>,
}

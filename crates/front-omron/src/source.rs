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

/// The CPU family of a program, which decides its memory map and its instruction set.
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
    /// The function number, such as 21 for MOV(21).
    pub value: u16,
    /// The number of digits as written: two on the C series, three on CS, CJ and CP.
    pub digits: u8,
}

/// The prefix that makes an instruction execute only on an edge of its condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// The prefix `@`: executed at the rising edge of the condition.
    Rising,
    /// The prefix `%`: executed at the falling edge of the condition.
    Falling,
}

/// One instruction as written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawInstruction {
    /// The line on which the instruction begins, from 1.
    pub line: u32,
    /// The program address (step number) of the instruction. `None` if the source has none.
    pub step: Option<u32>,
    /// The prefix `@` or `%` of the instruction. `None` if it has neither.
    pub edge: Option<Edge>,
    /// Whether the instruction has the prefix `!` (immediate refresh).
    pub immediate: bool,
    /// The mnemonic in upper case (`LD NOT` as `LDNOT`); empty if only a function number is written.
    pub mnemonic: String,
    /// The function number, if it is written.
    pub number: Option<FunctionNumber>,
    /// The operands; an area and its number count as one (`DM 0100`).
    pub operands: Vec<String>,
    /// The source text with single blanks between words.
    pub text: Arc<str>,
    /// The positions of the mnemonic and the operands in the source.
    pub places: WordPositions,
}

impl RawInstruction {
    /// The data with which a diagnostic points at a part of the instruction; `source` is the text of its file.
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

/// When a program runs: in each scan, or as an interrupt task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// In each scan, as the programs of files that contain only mnemonics; but as an interrupt program if the facts
    /// state runs for its name.
    Each,
    /// In each scan, as the cyclic task with this number. The project may switch the task off.
    Cyclic(u32),
    /// When an interrupt starts the interrupt task with this number.
    Interrupt(u32),
}

/// A symbol: a name for an address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symbol {
    /// The address as written. For a symbol of the type NUMBER, its value.
    pub address: String,
    /// The data type as written (`BOOL`, `WORD[11]`, `NUMBER`).
    pub kind: String,
    /// The comment of the symbol. May be empty.
    pub comment: String,
}

/// Symbols by name.
pub type Symbols = BTreeMap<String, Symbol>;

/// One program, which one task runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawProgram {
    /// The name of the program.
    pub name: String,
    /// When the program runs.
    pub task: Task,
    /// The local symbols of the program. They hide global ones of the same name.
    pub symbols: Symbols,
    /// The instructions in source order.
    pub instructions: Vec<RawInstruction>,
}

/// One file with its programs, in source order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RawFile {
    /// The file's name as the user gave it.
    pub name: String,
    /// The programs.
    pub programs: Vec<RawProgram>,
    /// The global symbols of the file, and those of the symbol tables that were given with it.
    pub symbols: Symbols,
    /// The CPU as the file names it (`CJ2M CPU33`). `None` if it names none, as in a list of mnemonics.
    pub cpu: Option<String>,
    /// The file's text, to show lines of it.
    pub source: String,
}

/// A project: its files in the order in which they run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawProject {
    /// The name of the dialect in which the files are written: [`C`], [`CX`] or [`CXT`].
    pub dialect: &'static str,
    /// The CPU family: its memory map and instruction set.
    pub family: Family,
    /// The files.
    pub files: Vec<RawFile>,
    /// Warnings about the files, which do not stop the audit.
    pub warnings: Vec<Diagnostic>,
}

//! A parsed MELSEC project: files of mnemonics and operands, not interpreted yet.

use std::collections::BTreeMap;
use std::sync::Arc;

use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{Caret, WordPositions};

/// One instruction (or label) as written in the source, not interpreted yet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawInstruction {
    /// The line on which the instruction begins, from 1.
    pub line: u32,
    /// The step number that the source gives the instruction. `None` if it gives none.
    pub step: Option<u32>,
    /// The mnemonic as written (`LD`, `D+P`, `SwOp0`), or a label on its own (`P50`, `I0`).
    pub mnemonic: String,
    /// The operands as written; a string keeps its quotes (`"text"`).
    pub operands: Vec<String>,
    /// Mnemonic and operands, separated by single blanks.
    pub text: Arc<str>,
    /// The positions in the source of the mnemonic and of each operand, for messages that point at one of them.
    pub places: WordPositions,
}

impl RawInstruction {
    /// The data from which a diagnostic finds the line and column of a part of the instruction, in the given file.
    pub(crate) fn caret<'a>(&'a self, file: &'a RawFile) -> Caret<'a> {
        Caret {
            line: self.line,
            text: &self.text,
            mnemonic: &self.mnemonic,
            operands: &self.operands,
            places: &self.places,
            source: &file.source,
        }
    }
}

/// One program file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawFile {
    /// The file's name as the user gave it.
    pub name: String,
    /// The program's name: the file name without directory and extension.
    pub program: String,
    /// The CPU as the file names it (`Q26UDV`, `FX3U/FX3UC`, `R08`). `None` if it names none, as in list text.
    pub cpu: Option<String>,
    /// The instructions in source order.
    pub instructions: Vec<RawInstruction>,
    /// The whole text of a list file, from which messages show lines; empty for a CSV file.
    pub source: String,
}

/// A project: program files, which run one after another in each scan, and device comments.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RawProject {
    /// `melsec-csv`, `melsec-gx3-csv` or `melsec-list`.
    pub dialect: &'static str,
    /// The program files in the order in which they run.
    pub files: Vec<RawFile>,
    /// The comment of each device, by the device name as written in the comment file.
    pub comments: BTreeMap<String, String>,
    /// Warnings that do not stop the audit.
    pub warnings: Vec<Diagnostic>,
}

//! A MELSEC project as its source has it: files of mnemonics and operands, nothing interpreted yet.

use std::collections::BTreeMap;
use std::sync::Arc;

use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{Caret, WordPositions};

/// One instruction as written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawInstruction {
    /// The physical line on which it begins, from 1.
    pub line: u32,
    /// The PLC's step number, where the source gives one.
    pub step: Option<u32>,
    /// The mnemonic as written (`LD`, `D+P`, `SwOp0`), or a pointer on its own (`P50`, `I0`).
    pub mnemonic: String,
    /// The operands as written; a string keeps its quotes (`"text"`).
    pub operands: Vec<String>,
    /// Mnemonic and operands as in the source, with one blank between each two.
    pub text: Arc<str>,
    /// Where they stand.
    pub places: WordPositions,
}

impl RawInstruction {
    /// What points at a part of it.
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
    /// The program's name: the file's name without its directory and extension.
    pub program: String,
    /// The CPU as the file names it (`Q26UDV`, `FX3U/FX3UC`, `R08`).
    pub cpu: Option<String>,
    /// The instructions, in the order of the source.
    pub instructions: Vec<RawInstruction>,
    /// The text in which they stand, for showing lines; empty where they stand in a table's cells.
    pub source: String,
}

/// A project: its program files, run one after another in each scan, and its device comments.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RawProject {
    /// `melsec-csv`, `melsec-gx3-csv` or `melsec-list`.
    pub dialect: &'static str,
    /// The program files, in the order in which they run.
    pub files: Vec<RawFile>,
    /// Device comments by the device's written name.
    pub comments: BTreeMap<String, String>,
    /// What was noticed but does not stop the audit.
    pub warnings: Vec<Diagnostic>,
}

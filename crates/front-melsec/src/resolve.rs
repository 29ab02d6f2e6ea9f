//! Finds what each instruction is, by its mnemonic, and parses its operands once.

use std::borrow::Cow;
use std::ops::Range;

use super::catalog::{CatalogMatch, NotFound, close, find};
use super::memory::Family;
use super::mnemonic::{OperandType, compared, contact};
use super::operand::{Operand, parse, upper};
use super::source::{RawFile, RawInstruction, RawProject};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_front::Faults;
use scanbound_ir::{Join, Relation};

/// Instructions that add an index to all devices of a part of the program.
const INDEXES_ALL: [&str; 4] = ["IX", "IXEND", "IXDEV", "IXSET"];

/// Instructions that call, stop or start programs by name; each has a pulse form.
const SWITCH_PROGRAMS: [&str; 6] = ["ECALL", "EFCALL", "PSTOP", "POFF", "PSCAN", "PLOW"];

/// What decoding needs besides the source.
pub struct DecodeOptions<'a> {
    /// The CPU family of the project.
    pub family: Family,
    /// Whether the timing table has a user-defined instruction of this name.
    pub is_user_instruction: &'a dyn Fn(&str) -> bool,
    /// The user's facts.
    pub facts: &'a Facts,
    /// Whether calls of missing routines take no time: see [`scanbound_front::Options`].
    pub absent_calls_take_no_time: bool,
}

/// A project whose instructions are each resolved.
pub(super) struct Resolved<'a> {
    pub(super) project: &'a RawProject,
    /// The instructions of all files, one file after another.
    pub(super) items: Vec<Item<'a>>,
    /// The range of items of each file.
    pub(super) files: Vec<Range<usize>>,
}

impl Resolved<'_> {
    /// The file whose program has this name; a file name extension in `name` is ignored.
    pub(super) fn named(&self, name: &str) -> Option<usize> {
        let stem = name.split('.').next().unwrap_or(name);
        self.project.files.iter().position(|file| file.program.eq_ignore_ascii_case(stem))
    }

    /// Which programs need not run in every scan: those that are called by name (their type is usually standby) and
    /// those that are stopped. If an operand is not a name, it may mean any program.
    pub(super) fn may_be_skipped(&self) -> Vec<bool> {
        let mut skip_targets = vec![false; self.files.len()];
        for item in &self.items {
            let is_named =
                |name: &&str| item.name.strip_prefix(*name).is_some_and(|p| ["", "P"].contains(&p));
            if !SWITCH_PROGRAMS.iter().any(is_named) {
                continue;
            }
            let is_call = matches!(item.category, Category::Control(Control::Call));
            let text = item.raw.operands.first().map_or("", String::as_str).trim_matches('"');
            match self.named(text) {
                Some(file) => skip_targets[file] = true,
                // A call that names a missing program calls no other one.
                None if is_call && !text.is_empty() => {}
                None => skip_targets.fill(true),
            }
        }
        skip_targets
    }
}

/// A resolved instruction.
pub(super) struct Item<'a> {
    pub(super) raw: &'a RawInstruction,
    /// The mnemonic in upper case.
    pub(super) name: Cow<'a, str>,
    /// The category of the instruction, and its data.
    pub(super) category: Category,
    /// The parsed operands of the instruction, or why one is invalid.
    pub(super) operands: Vec<Result<Operand, String>>,
}

/// An error at an instruction; `part` is a slice of the instruction's text or one of its words.
pub(super) fn fault(
    raw: &RawInstruction,
    file: &RawFile,
    (code, part): (Code, &str),
    message: impl Into<String>,
    help: &str,
) -> Diagnostic {
    raw.caret(file).at(part, code, &file.name, message, help).at_step(raw.step)
}

/// The error that says that the instruction does not have `count` operands. `None` if it has.
pub(super) fn miscounted(raw: &RawInstruction, file: &RawFile, count: usize) -> Option<Diagnostic> {
    let found = raw.operands.len();
    let message = || format!("`{}` takes {}, but has {found}", raw.mnemonic, operands(count));
    let part = raw.operands.get(count).unwrap_or(&raw.mnemonic);
    let help = "see the description of the instruction";
    (found != count).then(|| fault(raw, file, (Code::OperandCount, part), message(), help))
}

/// The category of an instruction.
pub(super) enum Category {
    Contact {
        join: Join,
        /// The edge that the contact detects: rising (`true`), falling (`false`), or none.
        rising: Option<bool>,
        negated: bool,
    },
    /// A comparison contact.
    Comparison { join: Join, sort: OperandType, relation: Relation },
    /// A contact that is true while a program runs.
    ProgramCheck(Join),
    /// An instruction that connects two blocks of contacts: ANB or ORB.
    Block,
    /// An instruction of a branch: MPS, MRD or MPP.
    Branch,
    /// An instruction that changes the result of the rung (INV, MEP, EGP and similar).
    Result,
    /// An instruction of the control structure.
    Control(Control),
    /// A coil: OUT, SET and similar instructions.
    Coil,
    /// An application instruction of the catalog.
    Listed(CatalogMatch),
    /// A user-defined instruction with a row in the timing table.
    User,
    /// An unknown instruction, which was already reported. `is_output`: it counts as the output of its rung.
    Unknown { is_output: bool },
}

/// Control instructions, and those that begin and end regions whose coils are off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Control {
    /// A pointer label.
    Label(u32),
    /// The start of an interrupt program.
    Interrupt,
    /// A jump to a label.
    Jump,
    /// A jump to the program's end.
    JumpToEnd,
    Call,
    /// RET; it also ends a step ladder.
    Return,
    /// An instruction that only ends a routine: SRET or IRET.
    OnlyReturn,
    /// The end of a step ladder: RETSTL.
    LadderEnd,
    End,
    For,
    Next,
    Break,
    Stop,
    Master,
    MasterEnd,
    /// A state of a step ladder (STL).
    LadderState,
}

/// Resolves the instructions of a project, and reports the unknown ones.
pub(super) fn resolve<'a>(
    project: &'a RawProject,
    options: &DecodeOptions<'_>,
    faults: &mut [Faults<'a>],
) -> Resolved<'a> {
    let mut resolved = Resolved { project, items: Vec::new(), files: Vec::new() };
    for (file, faults) in project.files.iter().zip(faults) {
        let first = resolved.items.len();
        for raw in &file.instructions {
            resolved.items.push(item(raw, file, options, faults));
            // After this many errors, the file is not a program.
            if faults.give_up() {
                break;
            }
        }
        resolved.files.push(first..resolved.items.len());
    }
    resolved
}

fn item<'a>(
    raw: &'a RawInstruction,
    file: &RawFile,
    options: &DecodeOptions<'_>,
    faults: &mut Faults<'_>,
) -> Item<'a> {
    let name = upper(&raw.mnemonic);
    let operands = raw.operands.iter().map(|text| parse(text, options.family)).collect();
    let own = in_rung(&name).or_else(|| control(&name, raw, options).map(Category::Control));
    let is_coil = matches!(&*name, "OUT" | "OUTH" | "SET" | "RST" | "PLS" | "PLF" | "FF");
    let own = own.or_else(|| is_coil.then_some(Category::Coil));
    let mut item = Item { raw, name, category: Category::User, operands };
    item.category = own.unwrap_or_else(|| category_of_application(&item, file, options, faults));
    item
}

/// The category of a contact, or of an instruction that connects results or changes them. `None` for others.
fn in_rung(name: &str) -> Option<Category> {
    if let Some((join, rising, negated)) = contact(name) {
        return Some(Category::Contact { join, rising, negated });
    }
    Some(match name {
        "ANB" | "ORB" => Category::Block,
        "MPS" | "MRD" | "MPP" => Category::Branch,
        "INV" | "MEP" | "MEF" | "EGP" | "EGF" => Category::Result,
        "LDPCHK" => Category::ProgramCheck(Join::Load),
        "ANDPCHK" | "PCHK" => Category::ProgramCheck(Join::And),
        "ORPCHK" => Category::ProgramCheck(Join::Or),
        _ => {
            let (join, sort, relation) = compared(name)?;
            Category::Comparison { join, sort, relation }
        }
    })
}

fn control(name: &str, raw: &RawInstruction, options: &DecodeOptions<'_>) -> Option<Control> {
    Some(match name {
        "CJ" | "SCJ" | "JMP" => Control::Jump,
        "GOEND" => Control::JumpToEnd,
        "CALL" | "CALLP" | "FCALL" | "FCALLP" | "ECALL" | "ECALLP" | "EFCALL" | "EFCALLP"
        | "XCALL" => Control::Call,
        "RET" => Control::Return,
        "SRET" | "IRET" => Control::OnlyReturn,
        "RETSTL" => Control::LadderEnd,
        "FEND" | "END" => Control::End,
        "FOR" => Control::For,
        "NEXT" => Control::Next,
        "BREAK" | "BREAKP" => Control::Break,
        "STOP" => Control::Stop,
        "MC" => Control::Master,
        "MCR" => Control::MasterEnd,
        "STL" => Control::LadderState,
        _ if raw.operands.is_empty() => match parse(name, options.family) {
            Ok(Operand::Pointer(label)) => Control::Label(label),
            Ok(Operand::Interrupt(_)) => Control::Interrupt,
            _ => return None,
        },
        _ => return None,
    })
}

/// The category of an instruction of the catalog or of the timing table. Reports an error if it is in neither.
fn category_of_application(
    item: &Item<'_>,
    file: &RawFile,
    options: &DecodeOptions<'_>,
    faults: &mut Faults<'_>,
) -> Category {
    let written = &item.raw.mnemonic;
    let mut refuse = |code, message: String, help: &str, is_output| {
        faults.push(fault(item.raw, file, (code, written), message, help));
        Category::Unknown { is_output }
    };
    match find(&item.name, item.raw.operands.len()) {
        Ok(found) => Category::Listed(found),
        Err(NotFound::Unknown) if (options.is_user_instruction)(written) => Category::User,
        Err(NotFound::Unknown) if INDEXES_ALL.contains(&&*item.name) => {
            let message = format!(
                "`{}` adds index registers to all devices between IX and IXEND, which scanbound does not support",
                item.name
            );
            let help = "write the index registers at each device (D0Z1)";
            refuse(Code::NotModelled, message, help, false)
        }
        Err(NotFound::Unknown) => {
            let own = "a user-defined instruction needs a row in the timing table";
            let help = match close(&item.name) {
                Some(close) => format!("did you mean `{close}`? {own}"),
                None => own.to_owned(),
            };
            let message = format!("unknown instruction `{written}`");
            refuse(Code::UnknownInstruction, message, &help, true)
        }
        Err(NotFound::OperandCount { expected }) => {
            let expected: Vec<String> = expected.into_iter().map(operands).collect();
            let found = item.raw.operands.len();
            let message = format!("`{written}` takes {}, but has {found}", expected.join(" or "));
            let help = "see the description of the instruction";
            refuse(Code::OperandCount, message, help, true)
        }
    }
}

/// The number of operands in words: `1 operand`, `3 operands`.
fn operands(count: usize) -> String {
    match count {
        0 => "no operand".to_owned(),
        1 => "1 operand".to_owned(),
        n => format!("{n} operands"),
    }
}

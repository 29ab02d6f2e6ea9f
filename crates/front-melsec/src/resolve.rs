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

/// Instructions that call programs by name; each has a pulse form.
const CALL_PROGRAMS: [&str; 2] = ["ECALL", "EFCALL"];
/// Instructions that stop or start programs by name; each has a pulse form.
const START_PROGRAMS: [&str; 4] = ["PSTOP", "POFF", "PSCAN", "PLOW"];

/// The options of decoding a project.
pub struct DecodeOptions<'a> {
    /// The CPU family of the project.
    pub family: Family,
    /// Whether the timing table has a row for a user-defined instruction of this name (as written in the source).
    pub is_user_instruction: &'a dyn Fn(&str) -> bool,
    /// What the user states about the project in the facts file.
    pub facts: &'a Facts,
    /// Whether a call of a routine that is not in the given files takes no time, instead of being an error: see
    /// [`scanbound_front::Options`].
    pub absent_calls_take_no_time: bool,
}

/// A project with the category and the parsed operands of each instruction.
pub(super) struct Resolved<'a> {
    pub(super) project: &'a RawProject,
    /// The instructions of all files, one file after another.
    pub(super) items: Vec<Item<'a>>,
    /// For each file, in the order of the project: the range of its instructions in `items`.
    pub(super) files: Vec<Range<usize>>,
}

impl Resolved<'_> {
    /// The index of the file whose program has this name; a file name extension in `name` is ignored. `None` if no
    /// given file has it.
    pub(super) fn named(&self, name: &str) -> Option<usize> {
        let stem = name.split('.').next().unwrap_or(name);
        self.project.files.iter().position(|file| file.program.eq_ignore_ascii_case(stem))
    }

    /// For each file: whether its program need not run in every scan. These are the programs that are called by name
    /// (their type is usually standby), and those that instructions stop or start. If an operand is not a known name,
    /// it may mean any program.
    pub(super) fn may_be_skipped(&self) -> Vec<bool> {
        let mut skip_targets = vec![false; self.files.len()];
        for item in &self.items {
            if !item.has_name(&CALL_PROGRAMS) && !item.has_name(&START_PROGRAMS) {
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

    /// Whether instructions stop or start programs, so that a program's type is not the same in all scans.
    pub(super) fn starts_programs(&self) -> bool {
        self.items.iter().any(|item| item.has_name(&START_PROGRAMS))
    }
}

/// An instruction with its category and its parsed operands; other parts of this crate call it an item, and refer to it
/// by its index in [`Resolved::items`].
pub(super) struct Item<'a> {
    pub(super) raw: &'a RawInstruction,
    /// The mnemonic in upper case.
    pub(super) name: Cow<'a, str>,
    /// The category of the instruction, and its data.
    pub(super) category: Category,
    /// Each operand parsed, or what is wrong with it.
    pub(super) operands: Vec<Result<Operand, String>>,
}

impl Item<'_> {
    /// Whether the instruction has one of these mnemonics, in its plain or its pulse form.
    fn has_name(&self, names: &[&str]) -> bool {
        let is_one =
            |name: &&str| self.name.strip_prefix(*name).is_some_and(|p| ["", "P"].contains(&p));
        names.iter().any(is_one)
    }
}

/// Makes an error at an instruction; `part` is a slice of its text or one of its words, at which the message points.
pub(super) fn fault(
    raw: &RawInstruction,
    file: &RawFile,
    (code, part): (Code, &str),
    message: impl Into<String>,
    help: &str,
) -> Diagnostic {
    raw.caret(file).at(part, code, &file.name, message, help).at_step(raw.step)
}

/// The error for an instruction that does not have `count` operands. `None` if it has.
pub(super) fn miscounted(raw: &RawInstruction, file: &RawFile, count: usize) -> Option<Diagnostic> {
    let found = raw.operands.len();
    let message = || format!("`{}` takes {}, but has {found}", raw.mnemonic, operands(count));
    let part = raw.operands.get(count).unwrap_or(&raw.mnemonic);
    let help = "write the operands that the CPU's manual gives for this instruction";
    (found != count).then(|| fault(raw, file, (Code::OperandCount, part), message(), help))
}

/// What an instruction is, which decides how it is lowered.
pub(super) enum Category {
    /// A contact that reads a bit: LD, ANI, ORP and similar.
    Contact {
        join: Join,
        /// The edge that the contact detects: rising (`true`) or falling (`false`). `None` if it detects no edge.
        rising: Option<bool>,
        negated: bool,
    },
    /// A contact that compares two operands.
    Comparison { join: Join, sort: OperandType, relation: Relation },
    /// A contact that is true while the program in its operand runs (PCHK and similar).
    ProgramCheck(Join),
    /// An instruction that connects two blocks of contacts: ANB or ORB.
    Block,
    /// An instruction of a branch: MPS, MRD or MPP.
    Branch,
    /// An instruction that changes the result of the rung (INV, MEP, EGP and similar).
    Result,
    /// A jump, call, loop, label, end or similar.
    Control(Control),
    /// A coil: OUT, SET and similar instructions.
    Coil,
    /// An application instruction that the catalog lists, or a dedicated one for which a row was made up.
    Listed(CatalogMatch),
    /// A user-defined instruction with a row in the timing table.
    User,
    /// An instruction that is unknown, not supported, or has a wrong number of operands, which was already reported.
    /// `is_output`: it counts as the output of its rung.
    Unknown { is_output: bool },
}

/// Control instructions, and those that begin and end regions whose coils are off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Control {
    /// A pointer label.
    Label(u32),
    /// The start of an interrupt program.
    Interrupt,
    /// A jump to a label: CJ, SCJ, JMP.
    Jump,
    /// A jump to the END of the program (GOEND).
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

/// Resolves the instructions of a project, and reports the unknown ones. After too many errors in a file, the rest of
/// that file is left out.
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
            let own =
                "if it is a user-defined instruction, state its time in the table or with --time";
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
            let help = "write the operands that the CPU's manual gives for this instruction";
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

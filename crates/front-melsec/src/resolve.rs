//! From written instructions to what each of them is, by its name, with its operands read once.

use std::borrow::Cow;
use std::ops::Range;

use super::catalog::{Found, NotFound, close, find};
use super::memory::Family;
use super::mnemonic::{Sort, compared, contact};
use super::operand::{Operand, parse, upper};
use super::source::{RawFile, RawInstruction, RawProject};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_front::Faults;
use scanbound_ir::{Join, Relation};

/// What makes all devices of a part of the program indexed ones.
const INDEXES_ALL: [&str; 4] = ["IX", "IXEND", "IXDEV", "IXSET"];

/// Instructions that call, stop or start programs by their names; each has a pulse form.
const SWITCH_PROGRAMS: [&str; 6] = ["ECALL", "EFCALL", "PSTOP", "POFF", "PSCAN", "PLOW"];

/// What decoding needs to know besides the source.
pub struct DecodeOptions<'a> {
    /// The CPU family.
    pub family: Family,
    /// Whether the timing table has an instruction of the user's of this name.
    pub is_user_instruction: &'a dyn Fn(&str) -> bool,
    /// What the user states.
    pub facts: &'a Facts,
    /// As [`scanbound_front::Options`] has it.
    pub absent_calls_take_no_time: bool,
}

/// A project's instructions, each understood by itself.
pub(super) struct Resolved<'a> {
    pub(super) project: &'a RawProject,
    /// Those of all files, one file behind the other.
    pub(super) items: Vec<Item<'a>>,
    /// Which of them each file has.
    pub(super) files: Vec<Range<usize>>,
}

impl Resolved<'_> {
    /// The file whose program has this name; what stands behind a dot says its kind.
    pub(super) fn named(&self, name: &str) -> Option<usize> {
        let stem = name.split('.').next().unwrap_or(name);
        self.project.files.iter().position(|file| file.program.eq_ignore_ascii_case(stem))
    }

    /// Which files' programs need not run in every scan: those that are called by name are commonly on standby, and
    /// those that are stopped rest. An operand that is no name may be any of them.
    pub(super) fn may_rest(&self) -> Vec<bool> {
        let mut rests = vec![false; self.files.len()];
        for item in &self.items {
            let is_named =
                |name: &&str| item.name.strip_prefix(*name).is_some_and(|p| ["", "P"].contains(&p));
            if !SWITCH_PROGRAMS.iter().any(is_named) {
                continue;
            }
            let is_call = matches!(item.category, Category::Control(Control::Call));
            let text = item.raw.operands.first().map_or("", String::as_str).trim_matches('"');
            match self.named(text) {
                Some(file) => rests[file] = true,
                // A call that names a program calls no other: this one is not there.
                None if is_call && !text.is_empty() => {}
                None => rests.fill(true),
            }
        }
        rests
    }
}

/// An instruction that is understood.
pub(super) struct Item<'a> {
    pub(super) raw: &'a RawInstruction,
    /// Its mnemonic in upper case.
    pub(super) name: Cow<'a, str>,
    /// What it is.
    pub(super) category: Category,
    /// What its operands say, or why they say nothing.
    pub(super) operands: Vec<Result<Operand, String>>,
}

/// A fault of an instruction; `part` is a slice of it or a word of it.
pub(super) fn fault(
    raw: &RawInstruction,
    file: &RawFile,
    (code, part): (Code, &str),
    message: impl Into<String>,
    help: &str,
) -> Diagnostic {
    raw.caret(file).at(part, code, &file.name, message, help).at_step(raw.step)
}

/// The fault that an instruction has more or fewer operands than `count`, if it has.
pub(super) fn miscounted(raw: &RawInstruction, file: &RawFile, count: usize) -> Option<Diagnostic> {
    let found = raw.operands.len();
    let message = || format!("`{}` takes {}, here are {found}", raw.mnemonic, operands(count));
    let part = raw.operands.get(count).unwrap_or(&raw.mnemonic);
    let help = "compare the line with the instruction's description";
    (found != count).then(|| fault(raw, file, (Code::OperandCount, part), message(), help))
}

/// What an instruction is.
pub(super) enum Category {
    /// A contact.
    Contact {
        join: Join,
        /// The edge that it looks for.
        rising: Option<bool>,
        negated: bool,
    },
    /// A contact that compares.
    Comparison { join: Join, sort: Sort, relation: Relation },
    /// A contact that is true while a program runs.
    ProgramCheck(Join),
    /// ANB, ORB.
    Block,
    /// MPS, MRD, MPP.
    Branch,
    /// What changes the result.
    Result,
    /// A part of the program's frame.
    Control(Control),
    /// OUT, SET and their kin.
    Coil,
    /// One that the catalog has.
    Listed(Found),
    /// The user's own, which the timing table has.
    User,
    /// Not known, which has been told; whether it is taken to be its rung's output.
    Unknown { is_output: bool },
}

/// What makes the frame of a program: where control goes, and regions that hold coils off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Control {
    /// A pointer's label.
    Label(u32),
    /// An interrupt program's beginning.
    Interrupt,
    /// A jump to a label.
    Jump,
    /// A jump to the end of the program.
    JumpToEnd,
    Call,
    /// RET, which also ends a step ladder.
    Return,
    /// SRET, IRET.
    OnlyReturn,
    /// RETSTL.
    LadderEnd,
    End,
    For,
    Next,
    Break,
    Stop,
    Master,
    MasterEnd,
    /// A state of a step ladder.
    State,
}

/// Understands the instructions of a project, and tells which are not known.
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
            // What follows so many faults is no program either.
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
    item.category = own.unwrap_or_else(|| listed(&item, file, options, faults));
    item
}

/// Contacts, and what works on the results of contacts.
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
        "STL" => Control::State,
        _ if raw.operands.is_empty() => match parse(name, options.family) {
            Ok(Operand::Pointer(label)) => Control::Label(label),
            Ok(Operand::Interrupt(_)) => Control::Interrupt,
            _ => return None,
        },
        _ => return None,
    })
}

/// An instruction of the catalog or of the user's, or the fault that it is neither.
fn listed(
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
                "`{}` adds index registers to every device between IX and IXEND",
                item.name
            );
            let help = "write the index registers at the devices themselves";
            refuse(Code::NotModelled, message, help, false)
        }
        Err(NotFound::Unknown) => {
            let own = "an instruction of your own needs a row in the timing table";
            let help = match close(&item.name) {
                Some(close) => format!("did you mean `{close}`? {own}"),
                None => own.to_owned(),
            };
            let message = format!("the instruction `{written}` is not known");
            refuse(Code::UnknownInstruction, message, &help, true)
        }
        Err(NotFound::OperandCount { expected }) => {
            let expected: Vec<String> = expected.into_iter().map(operands).collect();
            let found = item.raw.operands.len();
            let message = format!("`{written}` takes {}, here are {found}", expected.join(" or "));
            let help = "compare the line with the instruction's description";
            refuse(Code::OperandCount, message, help, true)
        }
    }
}

/// `1 operand`, `3 operands`.
fn operands(count: usize) -> String {
    match count {
        0 => "no operand".to_owned(),
        1 => "1 operand".to_owned(),
        n => format!("{n} operands"),
    }
}

//! Resolves instructions to catalog rows, parses their operands, and reports all errors.

use super::catalog::{self, Amount, Connection, Extent, OperandSpec, Role, Row, Timing};
use super::memory::Memory;
use super::operand::{Expected, Operand, Reader};
use super::source::{Family, RawInstruction};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::Faults;
use scanbound_front::shown;

/// An instruction of the source with its catalog row and its parsed operands.
#[derive(Debug, Clone)]
pub(super) struct Item<'a> {
    pub(super) raw: &'a RawInstruction,
    /// The name in the catalog, with the connection of a comparison (`AND=`); for a user-defined instruction the name
    /// as written.
    pub(super) name: String,
    /// The row of the instruction in the catalog; `None` for a user-defined instruction.
    pub(super) row: Option<&'static Row>,
    pub(super) lead: Option<Connection>,
    pub(super) operands: Vec<Operand>,
}

impl Item<'_> {
    /// The keyword in the column `meaning` of the instruction's row; `user` for a user-defined instruction.
    pub(super) fn meaning(&self) -> &'static str {
        self.row.map_or("user", |row| row.meaning)
    }

    /// The number in the first operand, such as that of a jump or a subroutine. `None` if it is not a constant.
    pub(super) fn number(&self, family: Family) -> Option<u32> {
        self.operands.first().and_then(|operand| operand.count(family))
    }
}

/// The number of the temporary relay in `OUT TR0` or `LD TR0`. `None` for other instructions.
pub(super) fn branch(raw: &RawInstruction) -> Option<u32> {
    let number = raw.operands.first()?.to_ascii_uppercase();
    let number = number.strip_prefix("TR")?.trim().parse().ok()?;
    (["LD", "OUT"].contains(&raw.mnemonic.as_str()) && raw.operands.len() == 1 && number < 16)
        .then_some(number)
}

/// Finds an instruction in the catalog and parses its operands. Reports why this is not possible, and then returns
/// `None`. A name for which `is_user` is true is a user-defined instruction with any operands.
pub(super) fn resolve<'a>(
    raw: &'a RawInstruction,
    reader: &Reader<'_>,
    is_user: &dyn Fn(&str) -> bool,
    source: &str,
    faults: &mut Faults<'_>,
) -> Option<Item<'a>> {
    let family = reader.memory.family;
    let at = |code, message: String, help: &str, faults: &mut Faults<'_>| {
        let fault = raw.caret(source).at(&raw.mnemonic, code, faults.file(), message, help);
        faults.push(fault.at_step(raw.step));
    };
    let name = match (raw.mnemonic.as_str(), raw.number) {
        ("", Some(number)) => match catalog::numbered(number.value, family) {
            Some(name) => name.to_owned(),
            None => {
                at(
                    Code::UnknownInstruction,
                    format!("{} is not a function number of this CPU family", number.value),
                    "write the instruction's name instead",
                    faults,
                );
                return None;
            }
        },
        (name, _) => name.to_owned(),
    };
    let upper = name.to_ascii_uppercase();
    let Some(found) = catalog::find(&upper, family) else {
        if is_user(&name) {
            let read = |text: &String| {
                reader.read(text, Expected::Word).or_else(|_| reader.read(text, Expected::Bit))
            };
            let operands =
                raw.operands.iter().map(|text| read(text).unwrap_or(Operand::Anywhere)).collect();
            return Some(Item { raw, name, row: None, lead: None, operands });
        }
        let (message, help) = if catalog::knows(&upper) {
            (
                format!(
                    "{upper} is not an instruction of {}",
                    if family == Family::C { "the C series" } else { "CS, CJ and CP" }
                ),
                "if the program is for the other CPU family, state its dialect with --dialect",
            )
        } else {
            (
                format!("unknown instruction '{}'", shown(&name)),
                "if this name is that of a function block or of an instruction of a special unit, state its time in the table or with --time: scanbound then assumes that it may write any values to its operands",
            )
        };
        at(Code::UnknownInstruction, message, help, faults);
        return None;
    };
    check_number(raw, &upper, &found.rows, family, faults);
    let row = found.rows.iter().copied().find(|row| row.takes(raw.operands.len()));
    let Some(row) = row else {
        let counts: Vec<String> =
            found.rows.iter().map(|row| row.operands.len().to_string()).collect();
        at(
            Code::Operands,
            format!(
                "{upper} takes {} operands, but the line has {}",
                counts.join(" or "),
                raw.operands.len()
            ),
            "check the line for a missing blank, and whether a line with operands was lost",
            faults,
        );
        return None;
    };
    if branch(raw).is_some() {
        return Some(Item { raw, name: upper, row: Some(row), lead: None, operands: Vec::new() });
    }
    let mut operands = Vec::new();
    let mut sound = true;
    for (text, slot) in raw.operands.iter().zip(&row.operands) {
        match read(text, *slot, reader) {
            Ok(operand) => operands.push(operand),
            Err((message, help)) => {
                sound = false;
                let fault = raw.caret(source).at(text, Code::Operand, faults.file(), message, help);
                faults.push(fault.at_step(raw.step));
            }
        }
    }
    sound.then_some(Item { raw, name: upper, row: Some(row), lead: found.lead, operands })
}

/// Reports an error if a function number is written that does not belong to the mnemonic.
fn check_number(
    raw: &RawInstruction,
    name: &str,
    rows: &[&Row],
    family: Family,
    faults: &mut Faults<'_>,
) {
    let Some(number) = raw.number else { return };
    if rows.iter().any(|row| row.extra.number == Some(number.value)) {
        return;
    }
    let other = catalog::numbered(number.value, family);
    if rows.iter().any(|row| row.extra.assignable) && other.is_none() {
        return;
    }
    let own = rows.iter().find_map(|row| row.extra.number);
    let is = |name: &str, own: Option<u16>| match own {
        Some(own) => format!("that of {name} is {own}"),
        None => format!("{name} has no function number"),
    };
    let message = match other {
        Some(other) => {
            format!("function number {} belongs to {other}, but {}", number.value, is(name, own))
        }
        None => {
            format!("the line gives the function number {}, but {}", number.value, is(name, own))
        }
    };
    let file = faults.file().to_owned();
    let help = "correct the name or the function number, so that they agree";
    faults.push(
        Diagnostic::line(Code::FunctionNumber, &file, raw.line, shown(&raw.text), message, help)
            .at_step(raw.step),
    );
}

fn read(
    text: &str,
    slot: OperandSpec,
    reader: &Reader<'_>,
) -> Result<Operand, super::operand::OperandError> {
    let want = match (slot.role, slot.extent) {
        (Role::Address, _) => {
            return reader.read(text, Expected::Word).or_else(|_| reader.read(text, Expected::Bit));
        }
        (Role::Number, _) => Expected::Number,
        (Role::Extra(Timing::Counter), _) => Expected::Completion("C"),
        (Role::Extra(Timing::Timer | Timing::TimerOrCounter), _) => Expected::Completion("T"),
        (_, Extent::Bits(_)) => Expected::Bit,
        _ => Expected::Word,
    };
    let operand = reader.read(text, want)?;
    let memory: Memory = reader.memory;
    if let (Operand::Constant(value, _), Some(Amount::Fixed(count))) = (&operand, slot.read_words())
        && !fits(*value, count)
    {
        return Err((
            format!("{text} does not fit in {count} words of 16 bits"),
            "use the instruction's variant for double words, or a smaller constant",
        ));
    }
    if let (Operand::Word(cell), Some(Amount::Fixed(count))) =
        (&operand, slot.read_words().or(slot.written_words()))
        && count <= 4
        && cell.index + count > memory.size(cell.area)
    {
        return Err((
            format!("{count} words from {text} on exceed the end of the area"),
            "check the address",
        ));
    }
    let Some(wanted) = wanted(&operand, slot, memory) else { return Ok(operand) };
    Err((format!("'{text}' is not {wanted}"), "check the order of the operands and the address"))
}

/// What the operand should be, for an error message. `None` if the operand is what the catalog requires.
fn wanted(operand: &Operand, slot: OperandSpec, memory: Memory) -> Option<&'static str> {
    let mut none = || scanbound_ir::ChoiceId(0);
    let is_word = !matches!(operand, Operand::Flag(_) | Operand::Bit(..) | Operand::Text);
    let (fits, wanted) = match (slot.role, slot.extent) {
        (Role::Number | Role::Address, _) | (Role::Source, Extent::Words(Amount::Unknown)) => {
            return None;
        }
        (Role::Extra(_), _) => (
            matches!(operand, Operand::Flag(_)) || operand.is_indirect(),
            "the number of a timer or counter",
        ),
        (Role::Source, Extent::Words(Amount::Fixed(count))) => {
            (operand.sources(count, memory, &mut none).is_some(), "a word or a constant")
        }
        (Role::Source, _) => (operand.bit_source(memory, &mut none).is_some(), "a bit"),
        (Role::ReadWriteIfDevice, _) => (is_word, "a word or a constant"),
        (Role::Destination | Role::ReadWrite, Extent::Bits(_)) => {
            (operand.bit_target().is_some() || operand.is_indirect(), "a bit that can be written")
        }
        (Role::Destination | Role::ReadWrite, _) => (
            is_word && !matches!(operand, Operand::Constant(..) | Operand::Real(_)),
            "a word that can be written",
        ),
    };
    (!fits).then_some(wanted)
}

/// Whether a constant fits in this many words, signed or unsigned.
fn fits(value: i64, words: u32) -> bool {
    words >= 4 || (-(1_i64 << (16 * words - 1)) <= value && value < 1_i64 << (16 * words))
}

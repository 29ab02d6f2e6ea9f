//! The catalog of application instructions in `catalog.csv`: their operands, timing class and effect.

use std::borrow::Cow;
use std::sync::LazyLock;

use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{self, StrDeserializer};

use scanbound_front::catalog::{self, Catalog, Line, Row};
pub(crate) use scanbound_front::catalog::{Amount, Extent};

/// The extensions of the MELSEC catalog: the role `a`, and the column `pulse`, which contains `P` if the instruction
/// has a pulse form.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Vocabulary;

impl catalog::Vocabulary for Vocabulary {
    type Role = Axis;
    type Meaning = InstructionEffect;
    type Extra = Extra;

    fn role(word: &str) -> Option<Axis> {
        (word == "a").then_some(Axis)
    }

    fn meaning(word: &'static str) -> Option<InstructionEffect> {
        let word: StrDeserializer<'_, value::Error> = word.into_deserializer();
        InstructionEffect::deserialize(word).ok()
    }

    fn extra(line: &Line<'_>) -> Option<Extra> {
        match line.cell("pulse") {
            "" => Some(Extra { pulse: false }),
            "P" => Some(Extra { pulse: true }),
            _ => None,
        }
    }
}

/// The role `a` of an operand: the output for pulses. If the operand is a bit, it is this output. Otherwise it is an
/// axis, whose parameters select an output, so that any Y may be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Axis;

/// The values of the columns that only the MELSEC catalog has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Extra {
    /// Whether the instruction has a pulse form.
    pub(crate) pulse: bool,
}

/// What an instruction does with an operand: reads it, writes it, or both.
pub(crate) type Role = catalog::Role<Axis>;
/// One operand in a catalog row: its role, and how many cells the instruction accesses from it on.
pub(crate) type Operand = catalog::Operand<Axis>;
/// One row of the catalog: one form of an instruction, with a fixed number of operands. Its mnemonic is written without
/// the suffix P of the pulse form.
pub(crate) type Entry = Row<Vocabulary>;

/// What an instruction writes to its destinations. Unless said otherwise, it writes only when it fires.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InstructionEffect {
    /// The destinations get any value when the instruction fires: the catalog has no exact effect for it.
    Havoc,
    /// The destinations may get any value whether the condition is true or false.
    HavocAlways,
    /// The destinations may get any value at any moment, even later than this scan: the instruction starts something
    /// that runs in parallel with the program.
    HavocAnytime,
    /// The instruction writes no device, but must come after a condition, like an output of a rung.
    Nothing,
    /// The instruction writes no device, and needs no condition before it, as NOP.
    Free,
    /// Copies the words of the first operand to the second. All are read before any is written.
    Copy,
    /// Copies the first operand to each of the counted units (words or double words) of the second.
    Fill,
    /// Adds the two sources; with only two operands, adds the first operand to the second.
    Add,
    /// Subtracts the second source from the first; with only two operands, subtracts the first operand from the second.
    Subtract,
    /// Adds one to the operand.
    Increment,
    /// Subtracts one from the operand.
    Decrement,
    /// Bitwise AND; operands as for `Add`.
    WordAnd,
    /// Bitwise OR; operands as for `Add`.
    WordOr,
    /// Bitwise exclusive OR; operands as for `Add`.
    WordXor,
    /// Bitwise exclusive NOR; operands as for `Add`.
    WordXnr,
    /// Stores the source with every bit inverted in the last operand.
    WordNot,
    /// Negates the operand (two's complement).
    Negate,
    /// Exchanges the values of the two operands.
    Exchange,
    /// Exchanges the two bytes of each word.
    Swap,
    /// Clears the first operand over its whole extent.
    Clear,
    /// Clears all devices from the first operand to the second.
    ClearRange,
    /// Sets the bit of the first operand whose number is the second operand (its low four bits).
    SetBit,
    /// Clears the bit of the first operand whose number is the second operand (its low four bits).
    ResetBit,
    /// Copies the bit with the next lower number to the bit of the operand, and clears the copied bit.
    ShiftOne,
    /// Inverts the bit of the operand.
    Alternate,
    /// Moves the value of each counted word or bit to the next higher device number; the lowest device becomes zero.
    SlideUp,
    /// Moves the value of each counted word or bit to the next lower device number; the highest device becomes zero.
    SlideDown,
    /// Computes each counted word of the third operand (each bit, for comparisons) from those words of the first two
    /// operands that have the same position; either of these may be a constant instead.
    Pairwise,
    /// Stores a text and a closing zero byte in the second operand.
    Text,
    /// Writes three consecutive bits, from the third operand on: whether the first operand is larger than the second,
    /// equal, or smaller.
    Order,
}

/// The catalog row that applies to an instruction.
#[derive(Debug, Clone)]
pub struct CatalogMatch {
    /// The row for the mnemonic and its number of operands; a made-up one for a dedicated instruction that the catalog
    /// does not list.
    pub entry: Cow<'static, Entry>,
    /// Whether the mnemonic is the pulse form, which executes on the rising edge of its condition.
    pub pulsed: bool,
}

/// Why the catalog has no row for an instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NotFound {
    /// The catalog has no such mnemonic.
    Unknown,
    /// The mnemonic exists, but takes a different number of operands.
    OperandCount {
        /// The numbers of operands that the mnemonic takes, in ascending order.
        expected: Vec<usize>,
    },
}

/// The catalog of all MELSEC application instructions.
static CATALOG: LazyLock<Catalog<Vocabulary>> =
    LazyLock::new(|| Catalog::new(include_str!("catalog.csv")));

/// The word in the column `also` that stands for all areas: the instruction may write any device.
pub const EVERYWHERE: &str = "*";
/// Prefixes of the dedicated instructions of modules and networks.
const DEDICATED: [&str; 12] =
    ["G.", "GP.", "Z.", "ZP.", "J.", "JP.", "D.", "DP.", "S.", "SP.", "M.", "MP."];
/// Dedicated instructions (without a number at the end) that write no device of their own station except their
/// operands: messages to and from other stations and modules, sockets, files, positioning, other CPUs, the clock.
/// Sorted.
const WRITES_ONLY_OPERANDS: [&str; 75] = [
    "ABRST", "BBLKRD", "BBLKWR", "BIDIN", "BIDOUT", "BUFRCVS", "CCPASET", "CHGA", "CHGAS", "CHGT",
    "CHGV", "CHGVS", "CSET", "DATE+", "DATE-", "DATERD", "DDRD", "DDWR", "DEVLD", "DEVST", "FREAD",
    "FWRITE", "GETE", "GINT", "MBREQ", "MBRW", "MRECV", "MSEND", "OFFGAN", "OGLOAD", "OGSTOR",
    "ONDEMAND", "PFWRT", "PINIT", "PSTRT", "PUTE", "READ", "RECV", "RECVS", "REMFR", "REMTO",
    "REQ", "RIFR", "RIRCV", "RIRD", "RISEND", "RITO", "RIWT", "RSTR", "RTREAD", "RTWRITE", "SEND",
    "SFCS", "SOCCINF", "SOCCLOS", "SOCCLOSE", "SOCCSET", "SOCOPEN", "SOCRCV", "SOCRCVS",
    "SOCRDATA", "SOCRMODE", "SOCSND", "SPBUSY", "SREAD", "SVST", "SWRITE", "TEACH", "TO", "UINI",
    "WRITE", "ZNFR", "ZNRD", "ZNTO", "ZNWR",
];
/// The timing class of dedicated instructions.
const DEDICATED_CLASS: &str = "dedicated";
/// Dedicated instructions that finish before the next instruction. The results of all other ones arrive later.
const SYNCHRONOUS: [&str; 5] = ["BUFRCVS", "DATE+", "DATE-", "DATERD", "DEVLD"];
/// The largest number of words that a dedicated instruction moves, apart from file access: that of MRECV of an Ethernet
/// module (QJ71E71 manual).
const DEDICATED_WORDS: u64 = 6517;
/// File access instructions: a word of their control data says how many words they move.
const OF_FILES: [&str; 2] = ["FREAD", "FWRITE"];
/// The largest number of words that a file access instruction moves.
const FILE_WORDS: u64 = 65_535;
/// A mnemonic is suggested only if at most one letter in this many must be changed, but one change is always allowed.
const LETTERS_PER_SLIP: usize = 3;

/// Finds the row for an instruction with this number of operands. A dedicated instruction without a row gets a made-up
/// one: each operand is read and written up to the end of its area; every other device may be written too, unless the
/// instruction is known to write only its operands.
///
/// # Errors
///
/// The mnemonic is unknown, or takes another number of operands.
pub fn find(mnemonic: &str, operands: usize) -> Result<CatalogMatch, NotFound> {
    let named = CATALOG.rows(mnemonic).map(|entries| (entries, false));
    let pulsed = || {
        let entries = CATALOG.rows(&unpulsed(mnemonic)?)?;
        entries.iter().any(|entry| entry.extra.pulse).then_some((entries, true))
    };
    if let Some((entries, pulsed)) = named.or_else(pulsed) {
        return entries
            .iter()
            .find(|entry| entry.operands.len() == operands && (entry.extra.pulse || !pulsed))
            .map(|entry| CatalogMatch { entry: Cow::Borrowed(entry), pulsed })
            .ok_or_else(|| NotFound::OperandCount { expected: counts(entries) });
    }
    if mnemonic.contains('.')
        && DEDICATED
            .iter()
            .any(|prefix| mnemonic.len() > prefix.len() && mnemonic.starts_with(prefix))
    {
        return Ok(dedicated(mnemonic, operands));
    }
    Err(NotFound::Unknown)
}

/// The mnemonic without its pulse suffix: `MOV` of `MOVP`, `+_U` of `+P_U`, `$MOV_WS` of `$MOVP_WS`, `Z.OPEN` of
/// `ZP.OPEN`. `None` if it has none.
pub fn unpulsed(mnemonic: &str) -> Option<String> {
    if mnemonic.contains('.')
        && let Some((prefix, rest)) = mnemonic.split_once("P.")
    {
        return Some(format!("{prefix}.{rest}"));
    }
    for kind in ["_U", "_WS"] {
        if let Some(base) = mnemonic.strip_suffix(kind) {
            return base.strip_suffix('P').map(|base| format!("{base}{kind}"));
        }
    }
    mnemonic.strip_suffix('P').map(str::to_owned)
}

/// The mnemonics of all catalog rows, without pulse forms.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    CATALOG.names()
}

/// The rows of a mnemonic as it is written in the catalog, one for each number of operands. `None` if there is none.
pub(super) fn rows(name: &str) -> Option<&'static [Entry]> {
    CATALOG.rows(name)
}

/// The rows of an instruction; of a pulse form, those rows that have one. `None` if there is none.
pub(super) fn forms(mnemonic: &str) -> Option<Vec<&'static Entry>> {
    if let Some(rows) = rows(mnemonic) {
        return Some(rows.iter().collect());
    }
    let plain = rows(&unpulsed(mnemonic)?)?;
    let forms: Vec<&Entry> = plain.iter().filter(|entry| entry.extra.pulse).collect();
    (!forms.is_empty()).then_some(forms)
}

fn counts(entries: &[Entry]) -> Vec<usize> {
    let mut counts: Vec<usize> = entries.iter().map(|entry| entry.operands.len()).collect();
    counts.sort_unstable();
    counts
}

fn dedicated(mnemonic: &str, operands: usize) -> CatalogMatch {
    let (prefix, name) = mnemonic.split_once('.').unwrap_or_default();
    let pulsed = prefix.ends_with('P');
    let also = match WRITES_ONLY_OPERANDS
        .binary_search(&name.trim_end_matches(|c: char| c.is_ascii_digit()))
    {
        Ok(_) => Vec::new(),
        Err(_) => vec![EVERYWHERE],
    };
    let meaning = match SYNCHRONOUS.contains(&name) {
        true => InstructionEffect::Havoc,
        false => InstructionEffect::HavocAnytime,
    };
    let operand = Operand { role: Role::ReadWrite, extent: Extent::Devices(Amount::Unknown) };
    let entry = Entry {
        mnemonic: match unpulsed(mnemonic).filter(|_| pulsed) {
            Some(plain) => plain.into(),
            None => mnemonic.to_owned().into(),
        },
        operands: vec![operand; operands],
        optional: false,
        class: DEDICATED_CLASS,
        units: None,
        unit_size: 1,
        most_units: Some(if OF_FILES.contains(&name) { FILE_WORDS } else { DEDICATED_WORDS }),
        meaning,
        also,
        extra: Extra { pulse: true },
    };
    CatalogMatch { entry: Cow::Owned(entry), pulsed }
}

/// The mnemonic of the catalog that is most similar to an unknown one, for a suggestion. `None` if none is similar
/// enough.
pub fn close(mnemonic: &str) -> Option<String> {
    let slips = (mnemonic.chars().count() / LETTERS_PER_SLIP).max(1);
    CATALOG
        .names()
        .map(|name| (strsim::damerau_levenshtein(mnemonic, name), name))
        .filter(|(distance, _)| *distance <= slips)
        .min()
        .map(|(_, name)| name.to_owned())
}

#[cfg(test)]
mod tests;

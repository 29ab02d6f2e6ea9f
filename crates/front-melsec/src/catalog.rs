//! The catalog of application instructions: each one's operands, timing class and effect, read from
//! `catalog.csv`.

use std::borrow::Cow;
use std::sync::LazyLock;

use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{self, StrDeserializer};

use scanbound_front::catalog::{self, Catalog, Line, Row};
pub(crate) use scanbound_front::catalog::{Amount, Extent};

/// What the MELSEC catalog adds to the language of catalogs: the role `a`, and the column `pulse`: `P` where the
/// instruction has a pulse form.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Vocabulary;

impl catalog::Vocabulary for Vocabulary {
    type Role = Axis;
    type Meaning = Operation;
    type Extra = Extra;

    fn role(word: &str) -> Option<Axis> {
        (word == "a").then_some(Axis)
    }

    fn meaning(word: &'static str) -> Option<Operation> {
        let word: StrDeserializer<'_, value::Error> = word.into_deserializer();
        Operation::deserialize(word).ok()
    }

    fn extra(line: &Line<'_>) -> Option<Extra> {
        match line.cell("pulse") {
            "" => Some(Extra { pulse: false }),
            "P" => Some(Extra { pulse: true }),
            _ => None,
        }
    }
}

/// An output that pulses are put out to; where it is no bit, an axis whose parameters name outputs: any Y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Axis;

/// The columns of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Extra {
    /// Whether a pulse form exists.
    pub(crate) pulse: bool,
}

/// What an instruction does with an operand.
pub(crate) type Role = catalog::Role<Axis>;
/// One operand of an instruction.
pub(crate) type Operand = catalog::Operand<Axis>;
/// One form of an instruction; its name is without the pulse suffix.
pub(crate) type Entry = Row<Vocabulary>;

/// What an instruction does to its destinations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Operation {
    /// They take any value when it is executed.
    Havoc,
    /// They may take any value whether its condition is true or false.
    HavocAlways,
    /// They may take any value at any moment, even between scans of the instruction: it starts something
    /// that runs beside the program.
    HavocAnytime,
    /// It writes no device; it needs a condition.
    Nothing,
    /// It writes no device and needs no condition.
    Free,
    /// The first operand's words go to the second, all read before any is written.
    Copy,
    /// The first operand goes to each of the counted units of the second.
    Fill,
    /// Sum: of the two sources, or of destination and source.
    Add,
    /// Difference: first source minus second, or destination minus source.
    Subtract,
    /// One more.
    Increment,
    /// One less.
    Decrement,
    /// Bitwise and, as `Add`.
    WordAnd,
    /// Bitwise or, as `Add`.
    WordOr,
    /// Bitwise exclusive or, as `Add`.
    WordXor,
    /// Bitwise equivalence, as `Add`.
    WordXnr,
    /// Every bit of the source inverted.
    WordNot,
    /// The negative of the operand, two's complement.
    Negate,
    /// The operands change places.
    Exchange,
    /// The bytes of each word change places.
    Swap,
    /// Zero, from the first operand on as far as its extent.
    Clear,
    /// Zero, from the first operand's device to the second's.
    ClearRange,
    /// Sets the bit of the first operand whose number is the second (its low four bits).
    SetBit,
    /// Clears that bit.
    ResetBit,
    /// The bit takes the value of the bit before it, which is cleared.
    ShiftOne,
    /// The bit is inverted.
    Alternate,
    /// Each of the counted units takes the place of the next higher one; the lowest becomes zero.
    SlideUp,
    /// Each takes the place of the next lower one; the highest becomes zero.
    SlideDown,
    /// Each of the counted units of the third operand is worked out from those of the first two at its place.
    Pairwise,
    /// The second operand takes a text and a closing NUL.
    Text,
    /// Three bits: whether the first operand is larger than the second, equal, smaller.
    Order,
}

/// An instruction that the catalog holds.
#[derive(Debug, Clone)]
pub struct Found {
    /// Its entry.
    pub entry: Cow<'static, Entry>,
    /// Whether its pulse form was written: it is executed at its condition's rising edge.
    pub pulsed: bool,
}

/// Why no entry was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NotFound {
    /// There is no such mnemonic.
    Unknown,
    /// The mnemonic takes other numbers of operands.
    OperandCount {
        /// Which, ascending.
        expected: Vec<usize>,
    },
}

/// The catalog.
static CATALOG: LazyLock<Catalog<Vocabulary>> =
    LazyLock::new(|| Catalog::new(include_str!("catalog.csv")));

/// Any area, where an entry lists what may be written besides.
pub const EVERYWHERE: &str = "*";
/// What begins the names of instructions that modules and networks bring.
const DEDICATED: [&str; 12] =
    ["G.", "GP.", "Z.", "ZP.", "J.", "JP.", "D.", "DP.", "S.", "SP.", "M.", "MP."];
/// What of those, whatever the digits behind, writes no device of its own station but the operands: messages to and
/// from other stations and modules, sockets, files, positioning, other CPUs, the clock. Sorted.
const KEPT_TO_OPERANDS: [&str; 75] = [
    "ABRST", "BBLKRD", "BBLKWR", "BIDIN", "BIDOUT", "BUFRCVS", "CCPASET", "CHGA", "CHGAS", "CHGT",
    "CHGV", "CHGVS", "CSET", "DATE+", "DATE-", "DATERD", "DDRD", "DDWR", "DEVLD", "DEVST", "FREAD",
    "FWRITE", "GETE", "GINT", "MBREQ", "MBRW", "MRECV", "MSEND", "OFFGAN", "OGLOAD", "OGSTOR",
    "ONDEMAND", "PFWRT", "PINIT", "PSTRT", "PUTE", "READ", "RECV", "RECVS", "REMFR", "REMTO",
    "REQ", "RIFR", "RIRCV", "RIRD", "RISEND", "RITO", "RIWT", "RSTR", "RTREAD", "RTWRITE", "SEND",
    "SFCS", "SOCCINF", "SOCCLOS", "SOCCLOSE", "SOCCSET", "SOCOPEN", "SOCRCV", "SOCRCVS",
    "SOCRDATA", "SOCRMODE", "SOCSND", "SPBUSY", "SREAD", "SVST", "SWRITE", "TEACH", "TO", "UINI",
    "WRITE", "ZNFR", "ZNRD", "ZNTO", "ZNWR",
];
/// The class of those.
const DEDICATED_CLASS: &str = "dedicated";
/// Those that have ended when the next instruction begins. What others are asked for is delivered at some later moment.
const AT_ONCE: [&str; 5] = ["BUFRCVS", "DATE+", "DATE-", "DATERD", "DEVLD"];
/// No dedicated instruction moves more words, but those of files: what MRECV of an Ethernet module receives (QJ71E71
/// manual).
const DEDICATED_WORDS: u64 = 6517;
/// Instructions of files, and the words that these move: as many as their control data say.
const OF_FILES: [&str; 2] = ["FREAD", "FWRITE"];
const FILE_WORDS: u64 = 65_535;
/// A mnemonic is worth suggesting if a letter in so many would have to change.
const LETTERS_PER_SLIP: usize = 3;

/// The entry of an instruction with so many operands. A dedicated instruction that is not listed gets an
/// entry by which each operand is read and written as far as its area reaches, and, where what it does is not
/// known from its name either, every other device may be written as well.
///
/// # Errors
///
/// The mnemonic is unknown, or known with other numbers of operands only.
pub fn find(mnemonic: &str, operands: usize) -> Result<Found, NotFound> {
    let named = CATALOG.rows(mnemonic).map(|entries| (entries, false));
    let pulsed = || {
        let entries = CATALOG.rows(&unpulsed(mnemonic)?)?;
        entries.iter().any(|entry| entry.extra.pulse).then_some((entries, true))
    };
    if let Some((entries, pulsed)) = named.or_else(pulsed) {
        return entries
            .iter()
            .find(|entry| entry.operands.len() == operands && (entry.extra.pulse || !pulsed))
            .map(|entry| Found { entry: Cow::Borrowed(entry), pulsed })
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

/// The mnemonic whose pulse form this would be: `MOV` of `MOVP`, `+_U` of `+P_U`, `$MOV_WS` of `$MOVP_WS`, `Z.OPEN`
/// of `ZP.OPEN`.
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

/// The names of all instructions, without their pulse forms.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    CATALOG.names()
}

/// The entries of a name as it stands in the catalog.
pub(super) fn rows(name: &str) -> Option<&'static [Entry]> {
    CATALOG.rows(name)
}

/// The entries of an instruction, a pulse form too.
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

fn dedicated(mnemonic: &str, operands: usize) -> Found {
    let (prefix, name) = mnemonic.split_once('.').unwrap_or_default();
    let pulsed = prefix.ends_with('P');
    let also = match KEPT_TO_OPERANDS
        .binary_search(&name.trim_end_matches(|c: char| c.is_ascii_digit()))
    {
        Ok(_) => Vec::new(),
        Err(_) => vec![EVERYWHERE],
    };
    let meaning = match AT_ONCE.contains(&name) {
        true => Operation::Havoc,
        false => Operation::HavocAnytime,
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
    Found { entry: Cow::Owned(entry), pulsed }
}

/// The mnemonic most like an unknown one, if one is near.
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

//! The catalog of application instructions: each one's operands, timing class and effect, read from
//! `catalog.csv`.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{LazyLock, OnceLock};

use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{self, StrDeserializer};

/// What an instruction does with an operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Reads it.
    Source,
    /// Writes it.
    Destination,
    /// Reads and writes it.
    Both,
    /// As `Both` where it is a device; the families differ in what stands there, and a constant or pointer is taken too.
    Either,
    /// Takes a count or another number from it: a constant or a word (two words in 32-bit instructions).
    Count,
    /// An output that pulses are put out to; where it is no bit, an axis whose parameters name outputs: any Y.
    Axis,
    /// Takes it as a name or an address; it is not written.
    Other,
}

/// How many units an operand has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Amount {
    /// So many.
    Fixed(u32),
    /// `unit` for each that another operand counts.
    Counted {
        /// How many bits or words one counted thing has.
        unit: u32,
        /// The counting operand, from 0.
        operand: usize,
    },
    /// Two to the power of what another operand counts.
    Power {
        /// The counting operand, from 0.
        operand: usize,
    },
    /// Not known: anything from the device to its area's end.
    Unknown,
}

impl Amount {
    /// The operand, from 0, that the amount depends on.
    #[must_use]
    pub fn counter(self) -> Option<usize> {
        match self {
            Amount::Counted { operand, .. } | Amount::Power { operand } => Some(operand),
            Amount::Fixed(_) | Amount::Unknown => None,
        }
    }
}

/// How far an operand reaches from the device that is written there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// So many bits.
    Bits(Amount),
    /// So many words; of a bit device sixteen bits each, or what a digit designation says.
    Words(Amount),
    /// So many devices of the kind that is written there: a bit device is one bit, a word device one word, a timer or
    /// counter its contact, coil and value.
    Devices(Amount),
    /// Text up to its closing NUL: of unknown length.
    Text,
}

impl Extent {
    /// How many units it has: words, else bits or devices.
    #[must_use]
    pub fn amount(self) -> Amount {
        match self {
            Extent::Bits(amount) | Extent::Words(amount) | Extent::Devices(amount) => amount,
            Extent::Text => Amount::Unknown,
        }
    }
}

/// One operand of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operand {
    /// Whether it is read or written.
    pub role: Role,
    /// How much of it.
    pub extent: Extent,
}

/// What an instruction does to its destinations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Operation {
    /// They take any value when it is executed.
    Forget,
    /// They may take any value whether its condition is true or false.
    Always,
    /// They may take any value at any moment, even between scans of the instruction: it starts something
    /// that runs beside the program.
    Anytime,
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
    Sub,
    /// One more.
    Inc,
    /// One less.
    Dec,
    /// Bitwise and, as `Add`.
    And,
    /// Bitwise or, as `Add`.
    Or,
    /// Bitwise exclusive or, as `Add`.
    Xor,
    /// Bitwise equivalence, as `Add`.
    Xnr,
    /// Every bit of the source inverted.
    Not,
    /// The negative of the operand, two's complement.
    Neg,
    /// The operands change places.
    Exchange,
    /// The bytes of each word change places.
    Swap,
    /// Zero, from the first operand on as far as its extent.
    Clear,
    /// Zero, from the first operand's device to the second's.
    ClearRange,
    /// Sets the bit of the first operand whose number is the second (its low four bits).
    BitSet,
    /// Clears that bit.
    BitReset,
    /// The bit takes the value of the bit before it, which is cleared.
    Shift1,
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

/// One form of an instruction: a mnemonic with a number of operands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// As it is written, without the pulse suffix.
    pub mnemonic: String,
    /// In the order in which they are written.
    pub operands: Vec<Operand>,
    /// The timing class.
    pub class: &'static str,
    /// The operand, from 0, that counts the units of a time per unit.
    pub units: Option<usize>,
    /// How many units each counted thing has: 2 where double words are counted.
    pub unit_size: u64,
    /// The most units there can be, where no operand counts them.
    pub most_units: Option<u64>,
    /// What happens to the destinations.
    pub operation: Operation,
    /// Whether a pulse form exists.
    pub pulse: bool,
    /// Areas, by their names in the program, any cell of which may be written too, as `Operation::Forget`;
    /// `*` stands for all areas.
    pub also: Vec<String>,
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

/// The file.
const TEXT: &str = include_str!("catalog.csv");
/// What begins a line that says nothing.
const COMMENT: char = '#';

/// The rows, by mnemonic.
static CATALOG: LazyLock<BTreeMap<&'static str, Rows>> = LazyLock::new(|| {
    let mut catalog: BTreeMap<&str, Rows> = BTreeMap::new();
    for line in TEXT.lines().skip(1).filter(|line| !line.starts_with(COMMENT)) {
        let mnemonic = line.split(',').next().unwrap_or_default();
        catalog.entry(mnemonic).or_default().lines.push(line);
    }
    catalog
});

/// The rows of one mnemonic, each for another number of operands. No program has more than a few of the mnemonics,
/// so they are understood where they are asked for.
#[derive(Default)]
struct Rows {
    lines: Vec<&'static str>,
    entries: OnceLock<Vec<Entry>>,
}

impl Rows {
    fn entries(&self) -> &[Entry] {
        self.entries.get_or_init(|| {
            let entries = self.lines.iter().map(|line| entry(line));
            entries.collect::<Result<_, _>>().expect("every row is well formed, as a test holds")
        })
    }
}

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
    let named = CATALOG.get(mnemonic).map(|rows| (rows.entries(), false));
    let pulsed = || {
        let entries = CATALOG.get(&*unpulsed(mnemonic)?)?.entries();
        entries.iter().any(|entry| entry.pulse).then_some((entries, true))
    };
    if let Some((entries, pulsed)) = named.or_else(pulsed) {
        return entries
            .iter()
            .find(|entry| entry.operands.len() == operands && (entry.pulse || !pulsed))
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

/// Every area, or `*` for all, that an instruction may write besides its operands.
pub fn also() -> impl Iterator<Item = &'static str> {
    CATALOG.values().flat_map(Rows::entries).flat_map(|entry| &entry.also).map(String::as_str)
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
        Err(_) => vec![EVERYWHERE.to_owned()],
    };
    let operand = Operand { role: Role::Both, extent: Extent::Devices(Amount::Unknown) };
    let entry = Entry {
        mnemonic: unpulsed(mnemonic).filter(|_| pulsed).unwrap_or_else(|| mnemonic.to_owned()),
        operands: vec![operand; operands],
        class: DEDICATED_CLASS,
        units: None,
        unit_size: 1,
        most_units: Some(if OF_FILES.contains(&name) { FILE_WORDS } else { DEDICATED_WORDS }),
        operation: Operation::Forget,
        pulse: true,
        also,
    };
    Found { entry: Cow::Owned(entry), pulsed }
}

/// The mnemonic most like an unknown one, if one is near.
pub fn close(mnemonic: &str) -> Option<String> {
    let slips = (mnemonic.chars().count() / LETTERS_PER_SLIP).max(1);
    CATALOG
        .keys()
        .map(|name| (strsim::damerau_levenshtein(mnemonic, name), name))
        .filter(|(distance, _)| *distance <= slips)
        .min()
        .map(|(_, name)| (*name).to_owned())
}

/// Reads a row of the file: mnemonic, pulse form, operands, class, units, effect, other areas. Operands are tokens
/// `role:extent` apart by blanks.
///
/// Roles: `s` read, `d` written, `sd` both, `sd?` both where it is a device, `n` count, `a` axis, `x` other. Extents: `b` a bit, `w` a word, `v` a
/// device, with a fixed number before (`7w`) or a counting operand, from 1, behind (`w*3`, `2w*3` for
/// two words each, `b*^3` for two to its power, `w*?` for an unknown number); `e` a real (two words), `$` text.
///
/// Units: the counting operand, from 1; `2*3` if what it counts has two units each; `<=8` for at most so many.
fn entry(line: &'static str) -> Result<Entry, String> {
    let cells: Vec<&str> = line.split(',').collect();
    let [mnemonic, pulse, operands, class, units, effect, also] = cells[..] else {
        return Err(format!("{line}: {} columns", cells.len()));
    };
    let operands: Vec<Operand> =
        operands.split_whitespace().map(operand).collect::<Result<_, _>>()?;
    let counters = operands.iter().filter_map(|operand| operand.extent.amount().counter());
    let units = units_of(units).ok_or_else(|| format!("{line}: units {units}"))?;
    if counters
        .chain(units.operand)
        .any(|counter| operands.get(counter).is_none_or(|by| by.role != Role::Count))
    {
        return Err(format!("{line}: counted by an operand that is no count"));
    }
    let pulse = match pulse {
        "" => false,
        "P" => true,
        other => return Err(format!("{line}: pulse form {other}")),
    };
    let effect: StrDeserializer<'_, value::Error> = effect.into_deserializer();
    let operation = Operation::deserialize(effect).map_err(|error| format!("{line}: {error}"))?;
    Ok(Entry {
        mnemonic: mnemonic.to_owned(),
        operands,
        class,
        units: units.operand,
        unit_size: units.size,
        most_units: units.most,
        operation,
        pulse,
        also: also.split_terminator(';').map(str::to_owned).collect(),
    })
}

/// The units column.
struct Counting {
    operand: Option<usize>,
    size: u64,
    most: Option<u64>,
}

fn units_of(text: &str) -> Option<Counting> {
    let none = Counting { operand: None, size: 1, most: None };
    if text.is_empty() {
        return Some(none);
    }
    if let Some(most) = text.strip_prefix("<=") {
        return Some(Counting { most: Some(most.parse().ok()?), ..none });
    }
    let (size, operand) = text.split_once('*').unwrap_or(("1", text));
    let operand = operand.parse::<usize>().ok()?.checked_sub(1)?;
    Some(Counting { operand: Some(operand), size: size.parse().ok()?, ..none })
}

fn operand(token: &str) -> Result<Operand, String> {
    let (role, extent) = token.split_once(':').unwrap_or((token, "w"));
    let role = match role {
        "s" => Role::Source,
        "d" => Role::Destination,
        "sd" => Role::Both,
        "sd?" => Role::Either,
        "n" => Role::Count,
        "a" => Role::Axis,
        "x" => Role::Other,
        _ => return Err(format!("operand {token}")),
    };
    let extent = extent_of(extent).ok_or_else(|| format!("operand {token}"))?;
    Ok(Operand { role, extent })
}

fn extent_of(text: &str) -> Option<Extent> {
    match text {
        "$" => return Some(Extent::Text),
        "e" => return Some(Extent::Words(Amount::Fixed(2))),
        _ => {}
    }
    let (unit, counter) = match text.split_once('*') {
        Some((unit, counter)) => (unit, Some(counter)),
        None => (text, None),
    };
    let kind = unit.trim_start_matches(|c: char| c.is_ascii_digit());
    let number = &unit[..unit.len() - kind.len()];
    let unit = if number.is_empty() { 1 } else { number.parse().ok()? };
    let amount = match counter {
        None => Amount::Fixed(unit),
        Some("?") => Amount::Unknown,
        Some(counter) => {
            let number = counter.strip_prefix('^');
            let operand = number.unwrap_or(counter).parse::<usize>().ok()?.checked_sub(1)?;
            match number {
                Some(_) => Amount::Power { operand },
                None => Amount::Counted { unit, operand },
            }
        }
    };
    match kind {
        "b" => Some(Extent::Bits(amount)),
        "w" => Some(Extent::Words(amount)),
        "v" => Some(Extent::Devices(amount)),
        _ => None,
    }
}

#[cfg(test)]
mod tests;

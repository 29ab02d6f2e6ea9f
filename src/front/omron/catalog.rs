//! The OMRON instructions as data: function numbers, operands, meaning, timing class and condition flags.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::source::Family;

/// The catalog's text; its columns are described at [`Row`].
const TEXT: &str = include_str!("catalog.csv");

/// How many words an operand reaches over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Extent {
    /// So many.
    Words(u32),
    /// As many as the operand of this place says.
    Counted(usize),
    /// Up to the word that the operand of this place names.
    UpTo(usize),
    /// Not told by the operands.
    Unknown,
}

/// What an operand is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// So many words that are read (`s`, `s2`, `c`); `None` for a block of any length (`s*`).
    Source(Option<u32>),
    /// An address or place that is not read itself (`sa`, `e`).
    Address,
    /// Words that are written (`d`), or read and written (`x`).
    Target(Extent),
    /// So many words, written where it names words, and read (`y1`, `y2`): a constant is only read.
    Either(u32),
    /// A bit that is read (`sb`).
    SourceBit,
    /// A bit that is written (`db`).
    TargetBit,
    /// A plain number: of a jump, a subroutine, a port (`n`).
    Number,
    /// A timer's number (`t`).
    Timer,
    /// A counter's number (`k`).
    Counter,
    /// A timer or a counter, by its letter (`tk`).
    TimerOrCounter,
}

/// One instruction of one family. Columns of the file: `mnemonic`; `family` (`c`, `cs`, `*` both); `number` (`~`:
/// may be assigned by the user); `operands`; `meaning`, the word by which `decode` knows it; `class`, the timing
/// class; `flags`: the condition flags it may change besides what its meaning says, `*` all, `~` those that some CPUs of CS, CJ
/// and CP turn off and others leave.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Row {
    pub(super) mnemonic: &'static str,
    pub(super) family: Option<Family>,
    pub(super) number: Option<u16>,
    /// Whether the number can be assigned by the user, so that no number contradicts the name.
    pub(super) assignable: bool,
    pub(super) operands: Vec<Role>,
    /// Which of the operands are both read and written (`x`).
    pub(super) changed: Vec<usize>,
    /// Whether the last operand may be missing.
    pub(super) optional: bool,
    pub(super) meaning: &'static str,
    pub(super) class: &'static str,
    pub(super) flags: &'static str,
}

impl Row {
    fn is_of(&self, family: Family) -> bool {
        self.family.is_none_or(|own| own == family)
    }

    /// Whether so many operands fit.
    pub(super) fn takes(&self, operands: usize) -> bool {
        let most = self.operands.len();
        operands == most || (self.optional && operands + 1 == most)
    }
}

/// How a contact with a comparison or a bit test joins the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lead {
    /// `LD=`
    Load,
    /// `AND=`
    And,
    /// `OR=`
    Or,
}

/// An instruction found in the catalog.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// Its rows, which differ in the number of operands.
    pub(super) rows: &'static [Row],
    /// For comparisons and bit tests, how they join.
    pub(super) lead: Option<Lead>,
}

static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| {
    let mut rows: Vec<Row> = TEXT.lines().skip(1).filter_map(row).collect();
    rows.sort_by_key(|row| (row.mnemonic, row.family.map(|family| family == Family::Cs)));
    rows
});

/// Ranges of `ROWS` by mnemonic.
static NAMES: LazyLock<BTreeMap<&'static str, std::ops::Range<usize>>> = LazyLock::new(|| {
    let mut names: BTreeMap<&'static str, std::ops::Range<usize>> = BTreeMap::new();
    for (at, row) in ROWS.iter().enumerate() {
        names.entry(row.mnemonic).or_insert(at..at).end = at + 1;
    }
    names
});

fn row(line: &'static str) -> Option<Row> {
    let mut cells = line.split(',');
    let mut cell = || cells.next().unwrap_or_default();
    let (mnemonic, family, number, operands) = (cell(), cell(), cell(), cell());
    let (meaning, class, flags) = (cell(), cell(), cell());
    let words: Vec<&str> = operands.split_whitespace().collect();
    Some(Row {
        mnemonic,
        family: match family {
            "c" => Some(Family::C),
            "cs" => Some(Family::Cs),
            _ => None,
        },
        number: number.trim_end_matches('~').parse().ok(),
        assignable: number.ends_with('~'),
        operands: words.iter().filter_map(|word| role(word.trim_end_matches('?'))).collect(),
        changed: (0..words.len()).filter(|&at| words[at].starts_with('x')).collect(),
        optional: words.last().is_some_and(|word| word.ends_with('?')),
        meaning,
        class,
        flags,
    })
    .filter(|row| row.operands.len() == words.len())
}

fn role(word: &str) -> Option<Role> {
    Some(match word {
        "sb" => Role::SourceBit,
        "db" => Role::TargetBit,
        "sa" | "e" => Role::Address,
        "n" => Role::Number,
        "t" => Role::Timer,
        "k" => Role::Counter,
        "tk" => Role::TimerOrCounter,
        "c" | "s" => Role::Source(Some(1)),
        "s*" => Role::Source(None),
        "d" | "x" => Role::Target(Extent::Words(1)),
        "d*" | "x*" => Role::Target(Extent::Unknown),
        _ => {
            let (kind, rest) = word.split_at(1);
            match kind {
                "s" => Role::Source(Some(rest.parse().ok()?)),
                "y" => Role::Either(rest.parse().ok()?),
                "d" | "x" => Role::Target(if let Some(at) = rest.strip_prefix("..") {
                    Extent::UpTo(at.parse().ok()?)
                } else if let Some(at) = rest.strip_prefix('@') {
                    Extent::Counted(at.parse().ok()?)
                } else {
                    Extent::Words(rest.parse().ok()?)
                }),
                _ => return None,
            }
        }
    })
}

fn rows(mnemonic: &str, family: Family) -> Option<&'static [Row]> {
    let range = NAMES.get(mnemonic)?.clone();
    let rows = &ROWS[range];
    let start = rows.iter().position(|row| row.is_of(family))?;
    let count = rows[start..].iter().take_while(|row| row.is_of(family)).count();
    Some(&rows[start..start + count])
}

/// The instruction of this name.
pub(super) fn find(mnemonic: &str, family: Family) -> Option<Found> {
    let joins = |rows: &[Row]| {
        rows[0].meaning.starts_with("compare") || rows[0].meaning.starts_with("test")
    };
    if let Some(rows) = rows(mnemonic, family).filter(|rows| !joins(rows)) {
        return Some(Found { rows, lead: None });
    }
    [("LD", Lead::Load), ("AND", Lead::And), ("OR", Lead::Or)].into_iter().find_map(
        |(word, lead)| {
            let rows = rows(mnemonic.strip_prefix(word)?, family).filter(|rows| joins(rows))?;
            Some(Found { rows, lead: Some(lead) })
        },
    )
}

/// The instruction of this function number.
pub(super) fn numbered(number: u16, family: Family) -> Option<&'static str> {
    let fits = |row: &&Row| row.number == Some(number) && row.is_of(family) && !row.assignable;
    ROWS.iter().find(fits).map(|row| row.mnemonic)
}

/// Whether any family has an instruction of this name with so many operands. (A number may name it instead.)
pub(super) fn takes(mnemonic: &str, operands: usize) -> bool {
    let found = [Family::C, Family::Cs].into_iter().filter_map(|family| find(mnemonic, family));
    mnemonic.is_empty() || found.flat_map(|found| found.rows).any(|row| row.takes(operands))
}

/// Whether any family has an instruction of this name.
pub(super) fn knows(mnemonic: &str) -> bool {
    [Family::C, Family::Cs].into_iter().any(|family| find(mnemonic, family).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_line_of_the_catalog_is_read() {
        assert_eq!(ROWS.len(), TEXT.lines().count() - 1);
        assert!(ROWS.iter().all(|row| !row.class.is_empty() && !row.flags.is_empty()));
    }

    #[test]
    fn a_number_names_one_instruction_of_a_family() {
        for family in [Family::C, Family::Cs] {
            let mut seen = BTreeSet::new();
            let fixed = ROWS.iter().filter(|row| row.is_of(family) && !row.assignable);
            let named: BTreeSet<(u16, &str)> =
                fixed.filter_map(|row| Some((row.number?, row.mnemonic))).collect();
            for (number, name) in named {
                assert!(seen.insert(number), "{number} of {family:?} is {name} and another");
            }
        }
    }

    #[test]
    fn references_to_operands_point_to_operands() {
        for row in ROWS.iter() {
            for role in &row.operands {
                if let Role::Target(Extent::UpTo(at) | Extent::Counted(at)) = role {
                    assert!(*at < row.operands.len(), "{}", row.mnemonic);
                }
            }
        }
    }

    #[test]
    fn names_are_found_with_their_lead() {
        assert_eq!(find("AND<>SL", Family::Cs).unwrap().lead, Some(Lead::And));
        assert_eq!(find("LDTSTN", Family::Cs).unwrap().rows[0].mnemonic, "TSTN");
        assert!(find("=", Family::Cs).is_none() && find("LD=", Family::C).is_none());
        assert_eq!(find("WSFT", Family::C).unwrap().rows.len(), 2);
        assert_eq!(numbered(21, Family::C), Some("MOV"));
        assert_eq!(numbered(400, Family::Cs), Some("+"));
        assert!(find("ADD", Family::C).is_some() && find("ADD", Family::Cs).is_none());
    }
}

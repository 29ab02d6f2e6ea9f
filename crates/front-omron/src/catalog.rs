//! The OMRON instructions as data: function numbers, operands, meaning, timing class and condition flags.

use std::sync::LazyLock;

use super::source::Family;
use scanbound_front::catalog::{self, Catalog, Line};
pub(super) use scanbound_front::catalog::{Amount, Extent};

/// All keywords of the column `meaning`; the later stages compare with these.
const MEANINGS: &str = "\
    add and and-block and-not break call clear-carry compare compare-real compare-signed compare-unknown \
    complement copy counter counter-reversible decrement end exchange fall fill flags-compare flags-compare-signed \
    flags-zone flags-zone-signed for havoc havoc-always increment interlock interlock-end interlock-number \
    interlock-number-end invert jump jump-end jump-if jump-zero jump-zero-end keep load load-not macro move \
    move-bit move-not next nothing or or-block or-not out out-bit out-not pulse-fall pulse-rise refresh-units \
    reset reset-bit reset-bits reset-timers return rise routine set set-bit set-bits set-carry shift-register \
    shift-words step subtract task test test-not timer timer-holding timer-unknown word-and word-or word-xnr \
    word-xor";

/// The extensions of the OMRON catalog: the roles `t` (timer), `k` (counter) and `tk` (either), the meaning keywords,
/// and the columns `family` (`c`, `cs`, `*` for both), `number` (function number; `~`: the user may assign it) and
/// `flags`: the condition flags that the instruction may change in addition to its meaning; `*` means all, `~` those
/// that some CPUs of CS, CJ and CP turn off and others leave unchanged.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Vocabulary;

impl catalog::Vocabulary for Vocabulary {
    type Role = Timing;
    type Meaning = &'static str;
    type Extra = Extra;

    fn role(word: &str) -> Option<Timing> {
        match word {
            "t" => Some(Timing::Timer),
            "k" => Some(Timing::Counter),
            "tk" => Some(Timing::TimerOrCounter),
            _ => None,
        }
    }

    fn meaning(word: &'static str) -> Option<&'static str> {
        MEANINGS.split(' ').any(|known| known == word).then_some(word)
    }

    fn extra(line: &Line<'_>) -> Option<Extra> {
        let number = line.cell("number");
        Some(Extra {
            family: match line.cell("family") {
                "c" => Some(Family::C),
                "cs" => Some(Family::Cs),
                "*" => None,
                _ => return None,
            },
            number: number.trim_end_matches('~').parse().ok(),
            assignable: number.ends_with('~'),
            flags: Some(line.cell("flags")).filter(|flags| !flags.is_empty())?,
        })
    }
}

/// The roles of timer and counter numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Timing {
    /// The number of a timer.
    Timer,
    /// The number of a counter.
    Counter,
    /// A timer or counter number with its letter.
    TimerOrCounter,
}

/// The values of the columns that only the OMRON catalog has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Extra {
    /// The CPU family that has the instruction; `None` if both have it.
    pub(super) family: Option<Family>,
    /// The function number of the instruction, or the usual one if the user can assign it. `None` if it has none.
    pub(super) number: Option<u16>,
    /// Whether the user can assign the function number. If so, every number that does not belong to another instruction
    /// is accepted.
    pub(super) assignable: bool,
    /// The names of the condition flags that the instruction may change, separated by blanks; `*` means all. See
    /// [`Vocabulary`] for `~`.
    pub(super) flags: &'static str,
}

/// What an instruction does with an operand.
pub(super) type Role = catalog::Role<Timing>;
/// One operand of an instruction.
pub(super) type OperandSpec = catalog::Operand<Timing>;
/// One form of an instruction.
pub(super) type Row = catalog::Row<Vocabulary>;

fn is_of(row: &Row, family: Family) -> bool {
    row.extra.family.is_none_or(|own| own == family)
}

/// How a comparison or bit test contact is connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Connection {
    /// As the first contact of a branch, such as `LD=`.
    Load,
    /// In series, such as `AND=`.
    And,
    /// In parallel, such as `OR=`.
    Or,
}

/// What the catalog says about a mnemonic.
#[derive(Debug, Clone)]
pub(super) struct CatalogMatch {
    /// The rows of the mnemonic, one for each number of operands.
    pub(super) rows: Vec<&'static Row>,
    /// How the contact is connected, for comparisons and bit tests. `None` for other instructions.
    pub(super) lead: Option<Connection>,
}

/// The catalog of all OMRON instructions.
static CATALOG: LazyLock<Catalog<Vocabulary>> =
    LazyLock::new(|| Catalog::new(include_str!("catalog.csv")));

fn rows(mnemonic: &str, family: Family) -> Option<Vec<&'static Row>> {
    let rows = CATALOG.rows(mnemonic)?.iter().filter(|row| is_of(row, family));
    Some(rows.collect()).filter(|rows: &Vec<&Row>| !rows.is_empty())
}

/// Finds an instruction of this family by name. A comparison or bit test is found only with its connection (`LD=`,
/// `ANDTST`). `None` if the family does not have the instruction.
pub(super) fn find(mnemonic: &str, family: Family) -> Option<CatalogMatch> {
    let joins = |rows: &Vec<&Row>| {
        rows[0].meaning.starts_with("compare") || rows[0].meaning.starts_with("test")
    };
    if let Some(rows) = rows(mnemonic, family).filter(|rows| !joins(rows)) {
        return Some(CatalogMatch { rows, lead: None });
    }
    [("LD", Connection::Load), ("AND", Connection::And), ("OR", Connection::Or)]
        .into_iter()
        .find_map(|(word, lead)| {
            let rows = rows(mnemonic.strip_prefix(word)?, family).filter(|rows| joins(rows))?;
            Some(CatalogMatch { rows, lead: Some(lead) })
        })
}

/// The names of all instructions, including each connection of comparisons.
pub(super) fn all_names() -> impl Iterator<Item = &'static str> {
    static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
        let known = |name: &String| knows(name);
        let joined = |name: &str| ["LD", "AND", "OR"].map(|join| format!("{join}{name}"));
        let of = |name: &'static str| [vec![name.to_owned()], joined(name).to_vec()].concat();
        let mut names: Vec<String> = CATALOG.names().flat_map(of).filter(known).collect();
        names.sort_unstable();
        names.dedup();
        names
    });
    NAMES.iter().map(String::as_str)
}

/// The mnemonic of the instruction of this family that has this function number. `None` if there is none. Numbers that
/// the user assigns are not found.
pub(super) fn numbered(number: u16, family: Family) -> Option<&'static str> {
    let fits = |row: &&Row| {
        row.extra.number == Some(number) && is_of(row, family) && !row.extra.assignable
    };
    CATALOG.all().find(fits).map(|row| &*row.mnemonic)
}

/// Whether any family has an instruction with this name and number of operands. True for an empty name, with which only
/// a function number is written.
pub(super) fn takes(mnemonic: &str, operands: usize) -> bool {
    let found = [Family::C, Family::Cs].into_iter().filter_map(|family| find(mnemonic, family));
    mnemonic.is_empty() || found.flat_map(|found| found.rows).any(|row| row.takes(operands))
}

/// Whether any family has an instruction with this name.
pub(super) fn knows(mnemonic: &str) -> bool {
    [Family::C, Family::Cs].into_iter().any(|family| find(mnemonic, family).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_line_of_the_catalog_is_read_and_every_meaning_is_had() {
        let used: BTreeSet<&str> = CATALOG.all().map(|row| row.meaning).collect();
        assert!(used.iter().copied().eq(MEANINGS.split(' ')), "{used:?}");
    }

    #[test]
    fn its_own_words_are_checked() {
        let heads = ["mnemonic", "family", "number", "operands", "class", "meaning", "flags"];
        let read = |text| catalog::row::<Vocabulary>(&heads, text);
        assert!(read("A,cs,20~,tk d:w..1,timer,havoc-always,*").is_ok());
        for wrong in [
            "A,,,d,move,havoc,*",
            "A,c,,a,move,havoc,*",
            "A,*,,d,move,forget,*",
            "A,*,,d,move,havoc,",
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_number_names_one_instruction_of_a_family() {
        for family in [Family::C, Family::Cs] {
            let mut seen = BTreeSet::new();
            let fixed = CATALOG.all().filter(|row| is_of(row, family) && !row.extra.assignable);
            let named: BTreeSet<(u16, &str)> =
                fixed.filter_map(|row| Some((row.extra.number?, &*row.mnemonic))).collect();
            for (number, name) in named {
                assert!(seen.insert(number), "{number} of {family:?} is {name} and another");
            }
        }
    }

    #[test]
    fn names_are_found_with_their_lead() {
        assert_eq!(find("AND<>SL", Family::Cs).unwrap().lead, Some(Connection::And));
        assert_eq!(find("LDTSTN", Family::Cs).unwrap().rows[0].mnemonic, "TSTN");
        assert!(find("=", Family::Cs).is_none() && find("LD=", Family::C).is_none());
        assert_eq!(find("WSFT", Family::C).unwrap().rows.len(), 2);
        assert_eq!(numbered(21, Family::C), Some("MOV"));
        assert_eq!(numbered(400, Family::Cs), Some("+"));
        assert!(find("ADD", Family::C).is_some() && find("ADD", Family::Cs).is_none());
    }
}

//! The language of the instruction catalogs of all fronts, and its parser.
//!
//! A catalog is a CSV text. The first line names the columns, in any order; lines that begin with `#` are comments.
//! Each other line is one form of an instruction: a mnemonic that takes other operands in another form has several
//! lines. The columns `also` and `units` and the dialect's own columns are optional.
//!
//! | column | content |
//! |---|---|
//! | `mnemonic` | the name as programs write it |
//! | `operands` | in source order, separated by blanks; the last one stands in brackets if it is optional |
//! | `class` | the timing class, whose time applies if the timing table does not name the instruction |
//! | `meaning` | the front's keyword for what the instruction does |
//! | `units` | the number of the operand (from 1) that gives the count for a time per unit; `2*3`: two units for each that operand 3 counts; `<=8`: no operand gives it, at most 8 |
//! | `also` | areas, separated by `;`, in which the instruction may write any cell besides its operands; `*` means all areas |
//!
//! An operand is written `role:extent`. Without an extent it is one word.
//!
//! | role | what the instruction does with the operand |
//! |---|---|
//! | `s` | reads it |
//! | `d` | writes it |
//! | `sd` | reads and writes it |
//! | `y` | reads and writes it if it is a device; only reads it if it is a constant |
//! | `n` | takes it as a number: a count, a position, the number of a jump |
//! | `x` | takes it as a name or an address; reads and writes nothing there |
//!
//! | extent | size of the operand |
//! |---|---|
//! | `w`, `4w` | one word, four words |
//! | `b`, `3b` | one bit, three bits |
//! | `v`, `2v` | one device of any type (bit or word), two of them |
//! | `w*3`, `2w*3` | one word, two words for each that operand 3 counts |
//! | `b*^3` | two to the power of operand 3, in bits |
//! | `w..2` | all words up to the one that operand 2 names |
//! | `w*?` | unknown: up to the end of the area |
//! | `e` | a real number (two words) |
//! | `$` | a text up to its closing NUL |
//!
//! Each dialect has a [`Vocabulary`] with its own roles, meaning keywords and columns. Three keywords exist in all
//! dialects: `havoc` (everything that the instruction writes gets any value when it fires), `havoc-always` (the same
//! also when its condition is false) and `nothing` (it writes nothing).

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::OnceLock;

/// The first character of a comment line.
const COMMENT: char = '#';

/// What a dialect adds to the format of catalogs.
pub trait Vocabulary: Debug + Clone + PartialEq + 'static {
    /// The roles of operands that only this dialect has.
    type Role: Debug + Copy + PartialEq;
    /// What an instruction does: a value for each keyword of the column `meaning`.
    type Meaning: Debug + Copy + PartialEq;
    /// The values of the columns that only this dialect has.
    type Extra: Debug + Clone + PartialEq;

    /// Parses a role of this dialect. `None` if the word is none.
    fn role(word: &str) -> Option<Self::Role>;
    /// Parses a keyword of the column `meaning`. `None` if the word is none.
    fn meaning(word: &'static str) -> Option<Self::Meaning>;
    /// Parses the columns that only this dialect has. `None` if one is malformed.
    fn extra(line: &Line<'_>) -> Option<Self::Extra>;
}

/// One line of a catalog, split into columns.
pub struct Line<'h> {
    heads: &'h [&'static str],
    cells: Vec<&'static str>,
}

impl Line<'_> {
    /// The content of the named column; empty if the catalog does not have it.
    pub fn cell(&self, head: &str) -> &'static str {
        let at = self.heads.iter().position(|one| *one == head);
        at.and_then(|at| self.cells.get(at).copied()).unwrap_or_default()
    }
}

/// What an instruction does with an operand. The letters are those of the catalog.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role<Extra> {
    /// The instruction reads the operand (`s`).
    Source,
    /// The instruction writes the operand (`d`).
    Destination,
    /// The instruction reads and writes the operand (`sd`).
    ReadWrite,
    /// The instruction reads and writes a device, but only reads a constant or pointer (`y`).
    ReadWriteIfDevice,
    /// The instruction takes a number from the operand (`n`).
    Number,
    /// The instruction takes the operand as a name or an address (`x`).
    Address,
    /// A role that only this dialect has.
    Extra(Extra),
}

/// How many bits, words or devices an operand covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Amount {
    /// A fixed number of bits, words or devices.
    Fixed(u32),
    /// `unit` bits, words or devices for each item that the value of an operand counts.
    Counted {
        /// The number of bits, words or devices for each counted item.
        unit: u32,
        /// The index of the operand that holds the number of items, from 0.
        operand: usize,
    },
    /// Two to the power of the value of an operand, in bits, words or devices.
    Power {
        /// The index of the operand with the exponent, from 0.
        operand: usize,
    },
    /// All cells from this operand up to the device that a second operand names.
    UpTo {
        /// The index of the second operand, from 0.
        operand: usize,
    },
    /// An unknown number: possibly up to the end of the area.
    Unknown,
}

impl Amount {
    /// The index (from 0) of the operand that determines the amount. `None` if it is fixed or unknown.
    pub fn counter(self) -> Option<usize> {
        match self {
            Amount::Counted { operand, .. }
            | Amount::Power { operand }
            | Amount::UpTo { operand } => Some(operand),
            Amount::Fixed(_) | Amount::Unknown => None,
        }
    }
}

/// The bits, words or devices that an operand covers, starting at the device that is written there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// The operand covers this number of bits.
    Bits(Amount),
    /// The operand covers this number of words. In a bit area a word is sixteen bits, or as many as the digit
    /// designation (`K4M0`) says.
    Words(Amount),
    /// Devices of the type that is written there: a bit, a word, or a timer or counter with contact, coil and current
    /// value.
    Devices(Amount),
    /// A text up to its closing zero byte, of unknown length.
    Text,
}

impl Extent {
    /// The number of words, bits or devices that the operand covers; unknown for a text.
    pub fn amount(self) -> Amount {
        match self {
            Extent::Bits(amount) | Extent::Words(amount) | Extent::Devices(amount) => amount,
            Extent::Text => Amount::Unknown,
        }
    }
}

/// One operand of a catalog row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operand<Extra> {
    /// How the instruction uses the operand.
    pub role: Role<Extra>,
    /// The number of bits, words or devices that the operand covers.
    pub extent: Extent,
}

impl<Extra> Operand<Extra> {
    /// The number of words that the instruction reads from the operand, if its role is [`Role::Source`]. `None` for
    /// other roles, and for bits, devices and texts.
    pub fn read_words(&self) -> Option<Amount> {
        match (&self.role, self.extent) {
            (Role::Source, Extent::Words(amount)) => Some(amount),
            _ => None,
        }
    }

    /// The number of words that the instruction writes, if the operand's role is [`Role::Destination`] or
    /// [`Role::ReadWrite`]. `None` for other roles (also for [`Role::ReadWriteIfDevice`]), and for bits, devices and
    /// texts.
    pub fn written_words(&self) -> Option<Amount> {
        match (&self.role, self.extent) {
            (Role::Destination | Role::ReadWrite, Extent::Words(amount)) => Some(amount),
            _ => None,
        }
    }
}

/// One form of an instruction: one line of a catalog.
#[derive(Debug, Clone, PartialEq)]
pub struct Row<V: Vocabulary> {
    /// The mnemonic as programs write it.
    pub mnemonic: Cow<'static, str>,
    /// The operands in source order.
    pub operands: Vec<Operand<V::Role>>,
    /// Whether the last operand is optional.
    pub optional: bool,
    /// The timing class of the instruction: its time applies if the timing table does not name the instruction.
    pub class: &'static str,
    /// What the instruction does: the dialect's value for the keyword in the column `meaning`.
    pub meaning: V::Meaning,
    /// The index (from 0) of the operand that holds the number of units. `None` if no operand does: the time does not
    /// depend on units, or [`Row::most_units`] limits them.
    pub units: Option<usize>,
    /// The number of units for each item that the operand [`Row::units`] counts: 2 if it counts double words and a unit
    /// is a word.
    pub unit_size: u64,
    /// The largest number of units, for an instruction without a counting operand. `None` if the catalog gives no such
    /// limit.
    pub most_units: Option<u64>,
    /// Areas, by their names in the program, in which the instruction may also write any cell; `*` means all areas.
    pub also: Vec<&'static str>,
    /// The values of the columns that only this dialect has.
    pub extra: V::Extra,
}

impl<V: Vocabulary> Row<V> {
    /// Whether the row accepts this number of operands: all, or all but the last if that is optional.
    pub fn takes(&self, operands: usize) -> bool {
        let most = self.operands.len();
        operands == most || (self.optional && operands + 1 == most)
    }
}

/// The lines of one mnemonic. They are parsed on first use, because a program uses only a few of the mnemonics.
#[derive(Debug)]
struct Lines<V: Vocabulary> {
    lines: Vec<&'static str>,
    rows: OnceLock<Vec<Row<V>>>,
}

/// The instructions of a dialect by mnemonic.
#[derive(Debug)]
pub struct Catalog<V: Vocabulary> {
    heads: Vec<&'static str>,
    names: BTreeMap<&'static str, Lines<V>>,
}

impl<V: Vocabulary> Catalog<V> {
    /// Splits a catalog into lines, without parsing them.
    pub fn new(text: &'static str) -> Self {
        let mut all = text.lines().filter(|line| !line.starts_with(COMMENT));
        let heads: Vec<&str> = all.next().unwrap_or_default().split(',').collect();
        let at = heads.iter().position(|head| *head == "mnemonic").unwrap_or(0);
        let mut names: BTreeMap<&str, Lines<V>> = BTreeMap::new();
        for line in all {
            let name = line.split(',').nth(at).unwrap_or_default();
            let empty = || Lines { lines: Vec::new(), rows: OnceLock::new() };
            names.entry(name).or_insert_with(empty).lines.push(line);
        }
        Catalog { heads, names }
    }

    /// All forms of one instruction. `None` if the catalog does not have the mnemonic.
    pub fn rows(&self, mnemonic: &str) -> Option<&[Row<V>]> {
        self.names.get(mnemonic).map(|lines| self.read(lines))
    }

    /// All forms of all instructions.
    pub fn all(&self) -> impl Iterator<Item = &Row<V>> {
        self.names.values().flat_map(|lines| self.read(lines))
    }

    /// All mnemonics.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.names.keys().copied()
    }

    fn read<'c>(&'c self, lines: &'c Lines<V>) -> &'c [Row<V>] {
        lines.rows.get_or_init(|| {
            let rows = lines.lines.iter().map(|line| row(&self.heads, line));
            rows.collect::<Result<_, _>>().expect("a test of each front parses every row")
        })
    }
}

/// Parses one line of a catalog; `heads` are the column names.
///
/// # Errors
/// A message with the line and what is malformed in it.
pub fn row<V: Vocabulary>(heads: &[&'static str], text: &'static str) -> Result<Row<V>, String> {
    let line = Line { heads, cells: text.split(',').collect() };
    let wrong = |what: &str| format!("{text}: {what}");
    if line.cells.len() != heads.len() {
        return Err(wrong("the line has more or fewer columns than the first line"));
    }
    let words: Vec<&str> = line.cell("operands").split_whitespace().collect();
    let optional = words.last().is_some_and(|word| optional_operand(word).is_some());
    let last = words.len().saturating_sub(1);
    let operands = words.iter().enumerate().map(|(at, word)| {
        let word = optional_operand(word).filter(|_| at == last).unwrap_or(word);
        operand::<V>(word).ok_or_else(|| wrong(&format!("operand {word}")))
    });
    let operands: Vec<Operand<V::Role>> = operands.collect::<Result<_, _>>()?;
    let units = units(line.cell("units")).ok_or_else(|| wrong("units"))?;
    let names = |operand: &Operand<V::Role>| matches!(operand.extent.amount(), Amount::UpTo { .. });
    let counters = operands.iter().filter(|operand| !names(operand));
    let counters = counters.filter_map(|operand| operand.extent.amount().counter());
    let counts = |by: &Operand<V::Role>| matches!(by.role, Role::Number | Role::Source);
    if counters.chain(units.operand).any(|counter| !operands.get(counter).is_some_and(counts)) {
        return Err(wrong(
            "an extent or `units` takes its count from an operand that the row does not have, or that is neither a number nor a source",
        ));
    }
    let ends = operands.iter().filter(|operand| names(operand));
    let mut ends = ends.filter_map(|operand| operand.extent.amount().counter());
    if let Some(end) = ends.find(|&end| end >= operands.len()) {
        let (n, count) = (end + 1, operands.len());
        return Err(wrong(&format!(
            "the extent `..{n}` names operand {n}, but the row has only {count} operands"
        )));
    }
    Ok(Row {
        mnemonic: line.cell("mnemonic").into(),
        operands,
        optional,
        class: Some(line.cell("class"))
            .filter(|class| !class.is_empty())
            .ok_or_else(|| wrong("class"))?,
        meaning: V::meaning(line.cell("meaning")).ok_or_else(|| wrong("meaning"))?,
        units: units.operand,
        unit_size: units.size,
        most_units: units.most,
        also: line.cell("also").split_terminator(';').collect(),
        extra: V::extra(&line)
            .ok_or_else(|| wrong("a column that only this dialect's catalog has is malformed"))?,
    })
}

/// The text inside the brackets of an optional operand. `None` if the word has no brackets.
fn optional_operand(word: &str) -> Option<&str> {
    word.strip_prefix('[')?.strip_suffix(']')
}

/// The content of the column `units`: which operand counts the units, and their size and limit.
struct Counting {
    operand: Option<usize>,
    size: u64,
    most: Option<u64>,
}

fn units(text: &str) -> Option<Counting> {
    let none = Counting { operand: None, size: 1, most: None };
    if text.is_empty() {
        return Some(none);
    }
    if let Some(most) = text.strip_prefix("<=") {
        return Some(Counting { most: Some(most.parse().ok()?), ..none });
    }
    let (size, operand) = text.split_once('*').unwrap_or(("1", text));
    Some(Counting { operand: Some(number(operand)?), size: size.parse().ok()?, ..none })
}

/// An operand number of a catalog, which begins at 1, as an index from 0. `None` if the text is not such a number.
fn number(text: &str) -> Option<usize> {
    text.parse::<usize>().ok()?.checked_sub(1)
}

fn operand<V: Vocabulary>(word: &str) -> Option<Operand<V::Role>> {
    let (role, extent) = word.split_once(':').unwrap_or((word, "w"));
    let role = match role {
        "s" => Role::Source,
        "d" => Role::Destination,
        "sd" => Role::ReadWrite,
        "y" => Role::ReadWriteIfDevice,
        "n" => Role::Number,
        "x" => Role::Address,
        other => Role::Extra(V::role(other)?),
    };
    Some(Operand { role, extent: self::extent(extent)? })
}

fn extent(text: &str) -> Option<Extent> {
    match text {
        "$" => return Some(Extent::Text),
        "e" => return Some(Extent::Words(Amount::Fixed(2))),
        _ => {}
    }
    let end = text.find(['*', '.']).unwrap_or(text.len());
    let (unit, amount) = text.split_at(end);
    let kind = unit.trim_start_matches(|c: char| c.is_ascii_digit());
    let count = &unit[..unit.len() - kind.len()];
    let unit = if count.is_empty() { 1 } else { count.parse().ok()? };
    let amount = if amount.is_empty() {
        Amount::Fixed(unit)
    } else if amount == "*?" {
        Amount::Unknown
    } else if let Some(power) = amount.strip_prefix("*^") {
        Amount::Power { operand: number(power)? }
    } else if let Some(counter) = amount.strip_prefix('*') {
        Amount::Counted { unit, operand: number(counter)? }
    } else {
        Amount::UpTo { operand: number(amount.strip_prefix("..")?)? }
    };
    match kind {
        "b" => Some(Extent::Bits(amount)),
        "w" => Some(Extent::Words(amount)),
        "v" => Some(Extent::Devices(amount)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A dialect that has one role, one meaning and one column of its own.
    #[derive(Debug, Clone, PartialEq)]
    struct Toy;

    impl Vocabulary for Toy {
        type Role = char;
        type Meaning = &'static str;
        type Extra = bool;

        fn role(word: &str) -> Option<char> {
            word.chars().next().filter(|_| word == "t")
        }

        fn meaning(word: &'static str) -> Option<&'static str> {
            ["havoc", "add"].into_iter().find(|known| *known == word)
        }

        fn extra(line: &Line<'_>) -> Option<bool> {
            Some(line.cell("pulse") == "P")
        }
    }

    const HEADS: [&str; 6] = ["mnemonic", "pulse", "operands", "class", "units", "meaning"];

    fn read(text: &'static str) -> Result<Row<Toy>, String> {
        row(&HEADS, text)
    }

    fn extents(operands: &str) -> Vec<Extent> {
        let all = operands.split(' ').map(|word| operand::<Toy>(word).expect(word).extent);
        all.collect()
    }

    #[test]
    fn extents_say_how_far_operands_reach() {
        let words = |amount| Extent::Words(amount);
        assert_eq!(
            extents("s s:4w d:3b sd:2v y:e s:$"),
            [
                words(Amount::Fixed(1)),
                words(Amount::Fixed(4)),
                Extent::Bits(Amount::Fixed(3)),
                Extent::Devices(Amount::Fixed(2)),
                words(Amount::Fixed(2)),
                Extent::Text,
            ]
        );
        assert_eq!(
            extents("d:w*3 d:2w*3 d:b*^3 d:w..2 d:w*?"),
            [
                words(Amount::Counted { unit: 1, operand: 2 }),
                words(Amount::Counted { unit: 2, operand: 2 }),
                Extent::Bits(Amount::Power { operand: 2 }),
                words(Amount::UpTo { operand: 1 }),
                words(Amount::Unknown),
            ]
        );
    }

    #[test]
    fn a_row_has_what_its_line_says() {
        let found = read("ADD,P,s:2w t [d:2w],sum,2*1,add").expect("a row");
        assert!(
            found.extra && found.optional && found.takes(2) && found.takes(3) && !found.takes(1)
        );
        assert_eq!(found.operands[1].role, Role::Extra('t'));
        assert_eq!(found.operands[2].written_words(), Some(Amount::Fixed(2)));
        assert_eq!((found.units, found.unit_size, found.most_units), (Some(0), 2, None));
        assert_eq!((found.class, found.meaning, &found.also[..]), ("sum", "add", &[][..]));
        assert_eq!(read("A,,d:w,move,<=8,havoc").expect("a row").most_units, Some(8));
    }

    #[test]
    fn what_is_not_understood_is_refused() {
        for wrong in [
            "A,,r:w,move,,havoc",
            "A,,s:q,move,,havoc",
            "A,,s:w.2 x,move,,havoc",
            "A,,[s:w] d:w,move,,havoc",
            "A,,d:w*2 d,move,,havoc",
            "A,,d:w*0 n,move,,havoc",
            "A,,d:w..3 x,move,,havoc",
            "A,,s:w d:w,move,3,havoc",
            "A,,d:w n,move,0,havoc",
            "A,,d:w n,move,<3,havoc",
            "A,,d:w,move,,spoil",
            "A,,d:w,,,havoc",
            "A,,d:w,move,havoc",
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn forms_of_an_instruction_stand_together() {
        let catalog: Catalog<Toy> = Catalog::new(
            "mnemonic,pulse,operands,class,units,meaning\n# Sums\nB,,d,sum,,havoc\nA,P,sd,sum,,add\nB,,s d,sum,,add\n",
        );
        let counts = |name| {
            catalog
                .rows(name)
                .map(|rows| rows.iter().map(|row| row.operands.len()).collect::<Vec<_>>())
        };
        assert_eq!((counts("B"), counts("C")), (Some(vec![1, 2]), None));
        assert_eq!(
            (catalog.all().count(), catalog.names().collect::<Vec<_>>()),
            (3, vec!["A", "B"])
        );
    }
}

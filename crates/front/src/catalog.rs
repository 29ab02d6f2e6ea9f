//! Instructions as data: the language in which the catalogs of all fronts are written, and its reader.
//!
//! A catalog is a text of lines with commas; the first line names the columns, in any order, and lines that begin with
//! `#` say nothing. Each line is one form of an instruction: what stands there under the same name with other operands
//! has a line of its own. `also`, `units` and the dialect's own columns may be missing.
//!
//! | column | what stands there |
//! |---|---|
//! | `mnemonic` | the name as it is written |
//! | `operands` | in the order in which they are written, apart by blanks; the last in brackets if it may be missing |
//! | `class` | the timing class, by which it is priced where a table does not name it |
//! | `meaning` | the word by which the front knows what it does |
//! | `units` | what a time per unit counts: the number of an operand, from 1, `2*3` if what the third operand counts has two units each, `<=8` for at most so many |
//! | `also` | areas, apart by `;`, any cell of which may be written besides the operands; `*` for all |
//!
//! An operand is `role:extent`; without an extent it is one word.
//!
//! | role | what the instruction does there |
//! |---|---|
//! | `s` | it reads |
//! | `d` | it writes |
//! | `sd` | it reads and writes |
//! | `y` | it reads and writes what is memory; what is none, such as a constant, it reads |
//! | `n` | it takes a number: a count, a place, the number of a jump |
//! | `x` | it takes a name or an address and neither reads nor writes there |
//!
//! | extent | how far the operand reaches |
//! |---|---|
//! | `w`, `4w` | a word, four words |
//! | `b`, `3b` | a bit, three bits |
//! | `v`, `2v` | a device of any kind, two of them |
//! | `w*3`, `2w*3` | as many words as the third operand says, two for each |
//! | `b*^3` | two to the power of what the third operand says |
//! | `w..2` | words up to the one that the second operand names |
//! | `w*?` | not known: to the end of the area |
//! | `e` | a real number, two words |
//! | `$` | a text, up to its closing NUL |
//!
//! Every dialect has a [`Vocabulary`]: further roles, the words for meanings, and columns of its own. These words for
//! meanings are common: `havoc` leaves any value in all that the instruction writes, `havoc-always` does so also where its
//! condition is false, and `nothing` writes nothing.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::OnceLock;

/// What begins a line that says nothing.
const COMMENT: char = '#';

/// What a dialect adds to the language.
pub trait Vocabulary: Debug + Clone + PartialEq + 'static {
    /// Roles that operands have in this dialect alone.
    type Role: Debug + Copy + PartialEq;
    /// What an instruction does.
    type Meaning: Debug + Copy + PartialEq;
    /// What the dialect's own columns say.
    type Own: Debug + Clone + PartialEq;

    /// The role of this name.
    fn role(word: &str) -> Option<Self::Role>;
    /// The meaning of this name.
    fn meaning(word: &'static str) -> Option<Self::Meaning>;
    /// The dialect's own columns of a line.
    fn own(line: &Line<'_>) -> Option<Self::Own>;
}

/// A line of a catalog by its columns.
pub struct Line<'h> {
    heads: &'h [&'static str],
    cells: Vec<&'static str>,
}

impl Line<'_> {
    /// What stands in a column; nothing in one that is missing.
    pub fn cell(&self, head: &str) -> &'static str {
        let at = self.heads.iter().position(|one| *one == head);
        at.and_then(|at| self.cells.get(at).copied()).unwrap_or_default()
    }
}

/// What an instruction does with an operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role<Own> {
    /// Reads it (`s`).
    Source,
    /// Writes it (`d`).
    Destination,
    /// Reads and writes it (`sd`).
    Both,
    /// As `Both` where it is memory; a constant or pointer is taken too (`y`).
    Either,
    /// Takes a number from it (`n`).
    Number,
    /// Takes it as a name or an address (`x`).
    Address,
    /// What only this dialect has.
    Own(Own),
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
    /// Up to what another operand names.
    UpTo {
        /// That operand, from 0.
        operand: usize,
    },
    /// Not known: anything up to the area's end.
    Unknown,
}

impl Amount {
    /// The operand, from 0, that the amount depends on.
    pub fn counter(self) -> Option<usize> {
        match self {
            Amount::Counted { operand, .. }
            | Amount::Power { operand }
            | Amount::UpTo { operand } => Some(operand),
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
    pub fn amount(self) -> Amount {
        match self {
            Extent::Bits(amount) | Extent::Words(amount) | Extent::Devices(amount) => amount,
            Extent::Text => Amount::Unknown,
        }
    }
}

/// One operand of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operand<Own> {
    /// Whether it is read or written.
    pub role: Role<Own>,
    /// How much of it.
    pub extent: Extent,
}

impl<Own> Operand<Own> {
    /// The words that are read here, if that is all that is done.
    pub fn read_words(&self) -> Option<Amount> {
        match (&self.role, self.extent) {
            (Role::Source, Extent::Words(amount)) => Some(amount),
            _ => None,
        }
    }

    /// The words that are written here, whatever stands here.
    pub fn written_words(&self) -> Option<Amount> {
        match (&self.role, self.extent) {
            (Role::Destination | Role::Both, Extent::Words(amount)) => Some(amount),
            _ => None,
        }
    }
}

/// One form of an instruction.
#[derive(Debug, Clone, PartialEq)]
pub struct Row<V: Vocabulary> {
    /// As it is written.
    pub mnemonic: Cow<'static, str>,
    /// In the order in which they are written.
    pub operands: Vec<Operand<V::Role>>,
    /// Whether the last operand may be missing.
    pub optional: bool,
    /// The timing class.
    pub class: &'static str,
    /// What it does.
    pub meaning: V::Meaning,
    /// The operand, from 0, that counts the units of a time per unit.
    pub units: Option<usize>,
    /// How many units each counted thing has: 2 where double words are counted.
    pub unit_size: u64,
    /// The most units there can be, where no operand counts them.
    pub most_units: Option<u64>,
    /// Areas, by their names in the program, any cell of which may be written too; `*` stands for all areas.
    pub also: Vec<&'static str>,
    /// What the dialect's own columns say.
    pub own: V::Own,
}

impl<V: Vocabulary> Row<V> {
    /// Whether so many operands fit.
    pub fn takes(&self, operands: usize) -> bool {
        let most = self.operands.len();
        operands == most || (self.optional && operands + 1 == most)
    }
}

/// The lines of one mnemonic. No program has more than a few of the mnemonics, so they are understood where they are
/// asked for.
#[derive(Debug)]
struct Lines<V: Vocabulary> {
    lines: Vec<&'static str>,
    rows: OnceLock<Vec<Row<V>>>,
}

/// A dialect's instructions by their mnemonics.
#[derive(Debug)]
pub struct Catalog<V: Vocabulary> {
    heads: Vec<&'static str>,
    names: BTreeMap<&'static str, Lines<V>>,
}

impl<V: Vocabulary> Catalog<V> {
    /// The catalog of this text.
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

    /// The forms of an instruction.
    pub fn rows(&self, mnemonic: &str) -> Option<&[Row<V>]> {
        self.names.get(mnemonic).map(|lines| self.read(lines))
    }

    /// All forms of all instructions.
    pub fn all(&self) -> impl Iterator<Item = &Row<V>> {
        self.names.values().flat_map(|lines| self.read(lines))
    }

    /// The names of all instructions.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.names.keys().copied()
    }

    fn read<'c>(&'c self, lines: &'c Lines<V>) -> &'c [Row<V>] {
        lines.rows.get_or_init(|| {
            let rows = lines.lines.iter().map(|line| row(&self.heads, line));
            rows.collect::<Result<_, _>>()
                .expect("every row is well formed, as a test of its front holds")
        })
    }
}

/// Reads a line.
///
/// # Errors
/// What of it is not understood.
pub fn row<V: Vocabulary>(heads: &[&'static str], text: &'static str) -> Result<Row<V>, String> {
    let line = Line { heads, cells: text.split(',').collect() };
    let wrong = |what: &str| format!("{text}: {what}");
    if line.cells.len() != heads.len() {
        return Err(wrong("the number of columns"));
    }
    let words: Vec<&str> = line.cell("operands").split_whitespace().collect();
    let optional = words.last().is_some_and(|word| bare(word).is_some());
    let last = words.len().saturating_sub(1);
    let operands = words.iter().enumerate().map(|(at, word)| {
        let word = bare(word).filter(|_| at == last).unwrap_or(word);
        operand::<V>(word).ok_or_else(|| wrong(&format!("operand {word}")))
    });
    let operands: Vec<Operand<V::Role>> = operands.collect::<Result<_, _>>()?;
    let units = units(line.cell("units")).ok_or_else(|| wrong("units"))?;
    let names = |operand: &Operand<V::Role>| matches!(operand.extent.amount(), Amount::UpTo { .. });
    let counters = operands.iter().filter(|operand| !names(operand));
    let counters = counters.filter_map(|operand| operand.extent.amount().counter());
    let counts = |by: &Operand<V::Role>| matches!(by.role, Role::Number | Role::Source);
    if counters.chain(units.operand).any(|counter| !operands.get(counter).is_some_and(counts)) {
        return Err(wrong("counted by an operand that is no number"));
    }
    let mut ends = operands.iter().filter(|operand| names(operand));
    if ends.any(|operand| operand.extent.amount().counter() >= Some(operands.len())) {
        return Err(wrong("up to an operand that is none"));
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
        own: V::own(&line).ok_or_else(|| wrong("the dialect's own columns"))?,
    })
}

/// What stands in the brackets of an operand that may be missing.
fn bare(word: &str) -> Option<&str> {
    word.strip_prefix('[')?.strip_suffix(']')
}

/// The units column.
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

/// The number of an operand, which is written from 1, from 0.
fn number(text: &str) -> Option<usize> {
    text.parse::<usize>().ok()?.checked_sub(1)
}

fn operand<V: Vocabulary>(word: &str) -> Option<Operand<V::Role>> {
    let (role, extent) = word.split_once(':').unwrap_or((word, "w"));
    let role = match role {
        "s" => Role::Source,
        "d" => Role::Destination,
        "sd" => Role::Both,
        "y" => Role::Either,
        "n" => Role::Number,
        "x" => Role::Address,
        other => Role::Own(V::role(other)?),
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

    /// A dialect with a role, a meaning and a column of its own.
    #[derive(Debug, Clone, PartialEq)]
    struct Toy;

    impl Vocabulary for Toy {
        type Role = char;
        type Meaning = &'static str;
        type Own = bool;

        fn role(word: &str) -> Option<char> {
            word.chars().next().filter(|_| word == "t")
        }

        fn meaning(word: &'static str) -> Option<&'static str> {
            ["havoc", "add"].into_iter().find(|known| *known == word)
        }

        fn own(line: &Line<'_>) -> Option<bool> {
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
        assert!(found.own && found.optional && found.takes(2) && found.takes(3) && !found.takes(1));
        assert_eq!(found.operands[1].role, Role::Own('t'));
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

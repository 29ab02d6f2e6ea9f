//! A timing table: the times of each instruction of a CPU, the evidence for them, and how a row is found.

pub mod builtin;
mod clock;
mod parse;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt;

use scanbound_base::time::Picos;

pub use clock::StatedClock;
pub use parse::{Override, Parsed, parse_override};
#[cfg(test)]
pub(crate) use parse::{POINTS, SINGLE, VARIED};

/// The timing classes. Every built-in table that names a CPU family has an `@class` row for each of them.
pub const CLASSES: [&str; 39] = [
    "arithmetic",
    "arithmetic-double",
    "bit",
    "block",
    "call",
    "clock",
    "coil",
    "compare",
    "compare-double",
    "compare-real",
    "compare-string",
    "contact",
    "conversion",
    "counter",
    "dedicated",
    "divide",
    "divide-double",
    "interrupt",
    "jump",
    "logic",
    "logic-double",
    "loop",
    "master",
    "module",
    "move",
    "move-double",
    "multiply",
    "multiply-double",
    "nothing",
    "pulse",
    "real",
    "search",
    "set",
    "shift",
    "special",
    "stack",
    "string",
    "table",
    "timer",
];

/// How reliable a time is. The weakest comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Evidence {
    /// The table's author assumed it: nobody has published or measured it.
    Assumed,
    /// The user gave the time, or a table gives it without naming its evidence.
    Stated,
    /// The time was measured on the CPU.
    Measured,
    /// The time is in the manufacturer's document that the row names.
    Published,
}

impl Evidence {
    /// All kinds of evidence, the strongest first.
    pub const ALL: [Evidence; 4] =
        [Evidence::Published, Evidence::Measured, Evidence::Stated, Evidence::Assumed];

    /// The word for the kind of evidence in tables and reports.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Evidence::Assumed => "assumed",
            Evidence::Stated => "stated",
            Evidence::Measured => "measured",
            Evidence::Published => "published",
        }
    }
}

impl fmt::Display for Evidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

/// One row of a timing table that gives a time: of an instruction, of a class of instructions, or of the whole scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// The name as written: an instruction, an instruction with a variant (`OUT:T`), or an `@` row.
    pub name: String,
    /// The on-time. For an `@` row (a class of instructions, or a part of the scan) with only one number, that number.
    pub on: Picos,
    /// The off-time: the time if control reaches the instruction but it does not fire. Equal to `on` if the table gives
    /// none.
    pub off: Picos,
    /// The time that is added to `on` for each unit.
    pub per_unit: Picos,
    /// What is counted as a unit: words, digits or points. Empty if nothing is.
    pub unit: String,
    /// The evidence for the times.
    pub evidence: Evidence,
    /// The document and page of the times, or the reason for an assumption; may be empty.
    pub source: String,
    /// The table from which the row comes. A table that amends a built-in one has rows of both.
    pub table: String,
    /// Whether the user adds the row to another table: it is in a table that amends a built-in one, or was given on the
    /// command line or in the facts. It replaces a row of the same name.
    pub amends: bool,
}

/// A factor on the whole scan, at least 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Factor {
    /// The factor in millionths.
    pub millionths: u64,
    /// The factor as it is written in the table.
    pub text: String,
    /// The evidence for the factor.
    pub evidence: Evidence,
    /// The source of the factor, or the reason for it.
    pub source: String,
}

impl Factor {
    /// The time multiplied by the factor, rounded up to a whole picosecond. `None` if it is too large.
    #[must_use]
    pub fn apply(&self, time: Picos) -> Option<Picos> {
        let product = u128::from(time.0) * u128::from(self.millionths);
        u64::try_from(product.div_ceil(1_000_000)).ok().map(Picos)
    }

    /// The time divided by the factor, rounded up to a whole picosecond.
    #[must_use]
    pub fn taken_off(&self, time: Picos) -> Picos {
        taken_off(self.millionths, time)
    }
}

/// The time divided by a factor that is given in millionths and is at least 1, rounded up to a whole picosecond.
#[must_use]
pub fn taken_off(millionths: u64, time: Picos) -> Picos {
    let whole = u128::from(time.0) * 1_000_000;
    Picos(u64::try_from(whole.div_ceil(u128::from(millionths.max(1)))).unwrap_or(time.0))
}

/// The largest number of inputs or outputs that a CPU can have itself. Points above it belong to a network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MostPoints {
    /// The largest number of points.
    pub points: u32,
    /// The evidence for the number of points.
    pub evidence: Evidence,
    /// The document and page of the number, or the reason for an assumption; may be empty.
    pub source: String,
}

/// A timing table.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Table {
    /// The name of the built-in table, or the file's name as the user gave it.
    pub name: String,
    /// What the table is for, in one line. Empty if the table does not say.
    pub title: String,
    /// The date of the table's last change, such as `2026-11-21`. `None` if the table does not say.
    pub date: Option<String>,
    /// The SHA-256 of the bytes of the table's file.
    pub sha256: String,
    /// The CPU family whose instruction set the table prices, such as `q` or `fx5`. `None` if the table names none.
    pub family: Option<String>,
    /// The CPUs for which the table is, in upper case, without the word CPU.
    pub cpus: Vec<String>,
    /// The name of the built-in table that this table amends: its rows hold where this table has none. `None` if it
    /// amends none.
    pub base: Option<String>,
    /// What the table's times do not include, for the reader of a report.
    pub notes: Vec<String>,
    /// The factor on the whole scan. `None` if the table has none.
    pub factor: Option<Factor>,
    /// The largest number of input points that the CPU can have. `None` if the table does not give it.
    pub most_inputs: Option<MostPoints>,
    /// The largest number of output points that the CPU can have. `None` if the table does not give it.
    pub most_outputs: Option<MostPoints>,
    rows: Vec<Row>,
    index: BTreeMap<String, usize>,
}

impl Table {
    /// All rows with times, in the order of the file. Rows of an amended table come first.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The row of this name. Letter case and surrounding blanks are ignored. `None` if there is none.
    #[must_use]
    pub fn row(&self, name: &str) -> Option<&Row> {
        self.index.get(&*folded(name)).map(|&at| &self.rows[at])
    }

    /// Whether the table has a row for exactly this instruction. An instruction that only the table knows is a user's
    /// own instruction.
    #[must_use]
    pub fn knows(&self, mnemonic: &str) -> bool {
        !mnemonic.starts_with('@') && self.row(mnemonic).is_some()
    }

    /// The number of rows with this evidence.
    #[must_use]
    pub fn count(&self, evidence: Evidence) -> usize {
        self.rows.iter().filter(|row| row.evidence == evidence).count()
    }

    /// The rows of one kind of overhead: for `@end`, the rows `@end` and `@end:NAME`.
    pub(crate) fn terms<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a Row> {
        self.rows.iter().filter(|row| row.name.starts_with('@')).filter(move |row| {
            let folded_name = folded(&row.name);
            folded_name
                .strip_prefix(&*folded(kind))
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(':'))
        })
    }

    /// Whether any row adds to the times of instructions by the operands that they use (`@+ZR`).
    pub(crate) fn has_extras(&self) -> bool {
        self.rows.iter().any(|row| row.name.starts_with("@+"))
    }

    /// The CPU's default watchdog time. `None` if the table does not give it.
    #[must_use]
    pub fn watchdog(&self) -> Option<Picos> {
        self.row("@watchdog").map(|row| row.on)
    }

    /// Sets the times of an instruction as the user stated them. They replace the table's row of this name.
    pub fn amend(&mut self, name: &str, on: Picos, off: Picos) {
        self.replace(Row {
            name: name.trim().to_owned(),
            on,
            off,
            per_unit: Picos::ZERO,
            unit: String::new(),
            evidence: Evidence::Stated,
            source: "stated on the command line".to_owned(),
            table: self.name.clone(),
            amends: true,
        });
    }

    /// The time multiplied by the table's factor, rounded up; the time itself if the table has no factor. `None` if it
    /// is too large.
    #[must_use]
    pub fn scaled(&self, time: Picos) -> Option<Picos> {
        self.factor.as_ref().map_or(Some(time), |factor| factor.apply(time))
    }

    /// Forgets how many inputs and outputs the CPU can have if these numbers are only assumed (`--strict-times`).
    pub fn refuse_assumed_points(&mut self) {
        for most in [&mut self.most_inputs, &mut self.most_outputs] {
            most.take_if(|most| most.evidence == Evidence::Assumed);
        }
    }

    /// Treats areas with these names as the same cells: the largest times of their `@+` rows apply to all of them.
    /// Nothing changes if none has such a row.
    pub fn join_cells(&mut self, areas: &[&str]) {
        let names: Vec<String> = areas.iter().map(|name| format!("@+{name}")).collect();
        let rows: Vec<Row> = names.iter().filter_map(|name| self.row(name).cloned()).collect();
        let Some(mut row) = rows.first().cloned() else { return };
        for other in rows {
            row.on = row.on.max(other.on);
            row.off = row.off.max(other.off);
            row.per_unit = row.per_unit.max(other.per_unit);
            row.evidence = row.evidence.min(other.evidence);
        }
        for name in names {
            let known = self.row(&name);
            let same = |known: &Row| {
                (known.on, known.off, known.per_unit) == (row.on, row.off, row.per_unit)
            };
            if !known.is_some_and(same) {
                self.replace(Row { name, ..row.clone() });
            }
        }
    }

    fn replace(&mut self, row: Row) {
        match self.index.entry(folded(&row.name).into_owned()) {
            Entry::Occupied(known) => self.rows[*known.get()] = row,
            Entry::Vacant(new) => {
                new.insert(self.rows.len());
                self.rows.push(row);
            }
        }
    }
}

/// A name in the form in which names are compared: upper case, without surrounding blanks.
pub(crate) fn folded(name: &str) -> Cow<'_, str> {
    let name = name.trim();
    if name.bytes().any(|byte| byte.is_ascii_lowercase()) {
        Cow::Owned(name.to_ascii_uppercase())
    } else {
        Cow::Borrowed(name)
    }
}

#[cfg(test)]
mod tests;

//! A timing table: what each instruction of a CPU costs, with the evidence for it, and how a row is found.

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

/// The timing classes: each has its `@class` row in every built-in table.
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

/// How well a time is founded, the weakest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Evidence {
    /// Nobody has published or measured it: a table's author supposed it.
    Assumed,
    /// The user gave it, and did not say from where.
    Stated,
    /// Measured on the CPU.
    Measured,
    /// In the maker's document that the row names.
    Published,
}

impl Evidence {
    /// All, the best first.
    pub const ALL: [Evidence; 4] =
        [Evidence::Published, Evidence::Measured, Evidence::Stated, Evidence::Assumed];

    /// The word that tables and reports use.
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

/// One row with times.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// As written: an instruction, an instruction with a variant (`OUT:T`), or an `@` row.
    pub name: String,
    /// The time when it fires; for `@` rows that have one number only, that number.
    pub on: Picos,
    /// The time when it is reached and does not fire.
    pub off: Picos,
    /// Added to `on` for each unit.
    pub per_unit: Picos,
    /// What is counted; empty if nothing is.
    pub unit: String,
    /// How well founded.
    pub evidence: Evidence,
    /// Document and page, or the reason for an assumption; may be empty.
    pub source: String,
    /// The table it comes from: a table that amends another holds rows of both.
    pub table: String,
    /// Whether the user stated it over the rows of a table: in one that amends another, or on the command line.
    pub amends: bool,
}

/// A factor on the whole scan, at least 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Factor {
    /// In millionths.
    pub millionths: u64,
    /// As written.
    pub text: String,
    /// How well founded.
    pub evidence: Evidence,
    /// Why there is one.
    pub source: String,
}

impl Factor {
    /// The time multiplied by the factor, rounded up to a whole picosecond; `None` if too large.
    #[must_use]
    pub fn apply(&self, time: Picos) -> Option<Picos> {
        let product = u128::from(time.0) * u128::from(self.millionths);
        u64::try_from(product.div_ceil(1_000_000)).ok().map(Picos)
    }

    /// What a time that holds the factor is without it, rounded up.
    #[must_use]
    pub fn taken_off(&self, time: Picos) -> Picos {
        taken_off(self.millionths, time)
    }
}

/// What a time that holds a factor, given in millionths and at least 1, is without it, rounded up.
#[must_use]
pub fn taken_off(millionths: u64, time: Picos) -> Picos {
    let whole = u128::from(time.0) * 1_000_000;
    Picos(u64::try_from(whole.div_ceil(u128::from(millionths.max(1)))).unwrap_or(time.0))
}

/// The most points of inputs or of outputs that a CPU refreshes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MostPoints {
    /// How many.
    pub points: u32,
    /// How well founded.
    pub evidence: Evidence,
    /// Document and page, or the reason for an assumption; may be empty.
    pub source: String,
}

/// A timing table.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Table {
    /// The built-in name, or the file's name as the user gave it.
    pub name: String,
    /// What it is for, one line; empty if it does not say.
    pub title: String,
    /// The day of its last change, as `2026-11-21`.
    pub date: Option<String>,
    /// The SHA-256 of its file's bytes.
    pub sha256: String,
    /// The family whose instruction set it prices, as a built-in table names it (`q`, `fx5`).
    pub family: Option<String>,
    /// The CPUs it is for, upper case, without the word CPU.
    pub cpus: Vec<String>,
    /// The built-in table that it amends.
    pub base: Option<String>,
    /// What its times do not hold, in words for the reader of a report.
    pub notes: Vec<String>,
    /// The factor on the whole scan.
    pub factor: Option<Factor>,
    /// The most input points that can be fitted.
    pub most_inputs: Option<MostPoints>,
    /// The most output points that can be fitted.
    pub most_outputs: Option<MostPoints>,
    rows: Vec<Row>,
    index: BTreeMap<String, usize>,
}

impl Table {
    /// All rows with times, in the order of the file; those of an amended table first.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The row of this name; letter case does not count.
    #[must_use]
    pub fn row(&self, name: &str) -> Option<&Row> {
        self.index.get(&*folded(name)).map(|&at| &self.rows[at])
    }

    /// Whether the table prices an instruction of this very name: what the dialect does not know but the
    /// table does is a user's instruction.
    #[must_use]
    pub fn knows(&self, mnemonic: &str) -> bool {
        !mnemonic.starts_with('@') && self.row(mnemonic).is_some()
    }

    /// How many rows rest on this evidence.
    #[must_use]
    pub fn count(&self, evidence: Evidence) -> usize {
        self.rows.iter().filter(|row| row.evidence == evidence).count()
    }

    /// Rows of one per-scan kind: `@end` and `@end:NAME` for `@end`.
    pub(crate) fn terms<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a Row> {
        self.rows.iter().filter(|row| row.name.starts_with('@')).filter(move |row| {
            let folded_name = folded(&row.name);
            folded_name
                .strip_prefix(&*folded(kind))
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(':'))
        })
    }

    /// Whether any row adds to the times of instructions by what they touch (`@+ZR`).
    pub(crate) fn has_extras(&self) -> bool {
        self.rows.iter().any(|row| row.name.starts_with("@+"))
    }

    /// The watchdog time that the CPU has by default.
    #[must_use]
    pub fn watchdog(&self) -> Option<Picos> {
        self.row("@watchdog").map(|row| row.on)
    }

    /// Prices an instruction by name as the user stated it, over whatever the table has for this name.
    pub fn amend(&mut self, name: &str, on: Picos, off: Picos) {
        self.put(Row {
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

    /// A time with the table's factor; `None` if too large.
    #[must_use]
    pub fn scaled(&self, time: Picos) -> Option<Picos> {
        self.factor.as_ref().map_or(Some(time), |factor| factor.apply(time))
    }

    /// Leaves out the most points where nobody has published them.
    pub fn refuse_assumed_points(&mut self) {
        for most in [&mut self.most_inputs, &mut self.most_outputs] {
            most.take_if(|most| most.evidence == Evidence::Assumed);
        }
    }

    /// Takes areas of these names for the same cells: what the `@+` row of one says holds for all, the dearest of them.
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
                self.put(Row { name, ..row.clone() });
            }
        }
    }

    fn put(&mut self, row: Row) {
        match self.index.entry(folded(&row.name).into_owned()) {
            Entry::Occupied(known) => self.rows[*known.get()] = row,
            Entry::Vacant(new) => {
                new.insert(self.rows.len());
                self.rows.push(row);
            }
        }
    }
}

/// A name as it is compared: without blanks around, in upper case.
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

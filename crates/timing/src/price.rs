//! Gives each instruction its on-time and off-time from a timing table, and each scan its overhead.

mod networks;
mod overhead;
mod refresh;
pub mod touched;

use scanbound_base::code::Code;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::table::{Factor, Row, Table, folded};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::{Area, Instruction, Program, TimingKey, Units};

pub use crate::table::Evidence;
pub use networks::NetworkUse;
pub use overhead::OverheadTerm;
use overhead::charged;
use refresh::Refresh;
pub use refresh::{
    MorePoints, UnstatedBase, UnstatedPoints, more_points, own_points, uncertain_refresh,
};
use touched::Cells;

/// The times of an instruction and where they come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Price {
    /// The on-time, with the largest number of units that the instruction may handle.
    pub on: Picos,
    /// The off-time: the time if control reaches the instruction but it does not fire.
    pub off: Picos,
    /// A lower bound on the on-time: without the time of units and of operands (`@+` rows), if the number of units is
    /// unknown or is read from words. Otherwise equal to `on`.
    pub least: Picos,
    /// A lower bound on the off-time: as `least` if the off-time equals the on-time, otherwise equal to `off`.
    pub least_off: Picos,
    /// The part of the on-time that does not depend on the number of units, if words give this number. Otherwise equal
    /// to `on`.
    pub base: Picos,
    /// Added to `base` for each unit that words count. Zero if words do not give the number of units.
    pub per_unit: Picos,
    /// The weakest evidence among the rows used. The evidence of the table's factor is in [`Prices::factor`].
    pub evidence: Evidence,
    /// The names of the rows used, joined by ` + `.
    pub row: Arc<str>,
    /// If the first row is a class row: the most general name under which the table could have a row for the
    /// instruction itself. Otherwise `None`.
    pub instead_of: Option<Arc<str>>,
    /// If the number of units is unknown or read from words: the largest possible number, which is in `on`. `None` if
    /// the number is known or does not matter.
    pub at_most_units: Option<u64>,
}

/// The times of a program's instructions, and the overhead of a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Prices {
    /// The price of each instruction, parallel to `Program::instructions`. `None`: it takes no time. Instructions with
    /// equal prices share one `Price`.
    pub instructions: Vec<Option<Arc<Price>>>,
    /// The overhead, charged once in each scan.
    pub overhead: Vec<OverheadTerm>,
    /// The factor that the times of the instructions and the overhead already contain. `None` if the table has none.
    pub factor: Option<Factor>,
    /// Inputs or outputs for which the number of refreshed points is not stated.
    pub points: Vec<UnstatedPoints>,
    /// Inputs or outputs for which the base units are not stated.
    pub bases: Vec<UnstatedBase>,
    /// The devices that a network refreshes and the program uses, and a station that it accesses, if neither the table
    /// nor the user gives a time for the refresh.
    pub networks: Vec<NetworkUse>,
}

impl Prices {
    /// The on-time, off-time and time per unit of each instruction, parallel to `instructions`. For an instruction
    /// whose units words count, the on-time is without units. Zero for an instruction that takes no time.
    #[must_use]
    pub fn times(&self) -> Vec<Times> {
        self.each(|price| Times { on: price.base, off: price.off, per_unit: price.per_unit })
    }

    /// Lower bounds on the times of each instruction, parallel to `instructions`. If the number of units is unknown or
    /// read from words, the on-time is without units. The time per unit is that of [`Prices::times`].
    #[must_use]
    pub fn least_times(&self) -> Vec<Times> {
        self.each(|price| Times { on: price.least, off: price.least_off, per_unit: price.per_unit })
    }

    fn each(&self, times: impl Fn(&Price) -> Times) -> Vec<Times> {
        let times = |price: &Option<Arc<Price>>| price.as_deref().map(&times);
        self.instructions.iter().map(|price| times(price).unwrap_or_default()).collect()
    }

    /// The additional time if all points that the CPU can have are refreshed, for inputs and outputs whose number is
    /// not stated. Where the table does not give the largest number, nothing is added.
    #[must_use]
    pub fn more_points(&self) -> Picos {
        more_points(&self.points)
    }

    /// The part of the charged refresh time that may not occur, because points or base units are not stated.
    #[must_use]
    pub fn uncertain_refresh(&self) -> Picos {
        uncertain_refresh(&self.points, &self.bases)
    }

    /// The sum of all overhead terms: the time of a scan besides its instructions.
    #[must_use]
    pub fn overhead_sum(&self) -> Picos {
        self.overhead.iter().map(|term| term.time).sum()
    }
}

/// Why an instruction has no price.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoPrice {
    /// Neither the instruction nor its class has a row, but the instruction needs one.
    Missing,
    /// No name of the instruction has a row, and it does not need one: it takes no time (a label).
    Free,
    /// The time exceeds the largest time that can be represented.
    TooLarge,
}

/// How often each tag of the `@+` rows occurs in an instruction's operands. For the name of an area: how many of its
/// cells are read or written. For `WORDBIT`: how many bits of words.
pub type OperandTags = BTreeMap<String, u64>;

/// Everything that a price depends on: the timing key's names, class, units and switches, the tags of the operands, and
/// whether a rung or an interrupt routine begins at the instruction.
type PriceInput<'a> = (&'a [String], &'static str, &'a Units, [bool; 2], OperandTags, [bool; 2]);

/// The tag for single bits of words (`@+WORDBIT`).
const WORD_BIT: &str = "WORDBIT";

/// Prices every instruction and the overhead of a scan.
///
/// # Errors
/// Every instruction that has no time, each with its line. If there is none: base units in the facts for which the
/// table has no times, or overhead that is too large.
pub fn price(program: &Program, table: &Table, facts: &Facts) -> Result<Prices, Vec<Diagnostic>> {
    let tag = |area: &Area| {
        Some(folded(&area.name).into_owned()).filter(|tag| table.row(&format!("@+{tag}")).is_some())
    };
    let extras = table.has_extras();
    let tagged: Vec<Option<String>> = program.areas.iter().map(tag).collect();
    // Most instructions have the same price as many others.
    let mut known: FxHashMap<PriceInput<'_>, PricedInstruction> = FxHashMap::default();
    let rung = table.row("@rung");
    let entry = table.row("@interrupt-entry");
    let entries: BTreeSet<usize> = match entry {
        Some(_) => program.interrupt_entries(),
        None => BTreeSet::new(),
    };
    let mut faults = Vec::new();
    let mut instructions = Vec::with_capacity(program.instructions.len());
    let mut block = 0;
    let absent: BTreeMap<usize, Picos> =
        program.missing_routines.iter().map(|one| (one.entry, one.time)).collect();
    for (at, instruction) in program.instructions.iter().enumerate() {
        if let Some(&time) = absent.get(&at) {
            instructions.push(match stated_time(table, time) {
                Ok(price) => Some(Arc::new(price)),
                Err(why) => {
                    faults.push(fault(program, table, instruction, why));
                    None
                }
            });
            continue;
        }
        // The cost of a rung is charged at its first instruction. So it is not charged if the rung is skipped, and
        // charged again in each iteration of a loop.
        let begins = rung.filter(|_| instruction.block != block);
        // The cost of an interrupt is charged at the first instruction of its routine, once for each occurrence.
        let entered = entry.filter(|_| entries.contains(&at));
        let PricedInstruction { price, begun } = match &instruction.timing {
            None => priced(table, Err(NoPrice::Free), begins, entered),
            Some(key) => {
                let touched = if extras {
                    tags(&Cells::of(instruction, units(&key.units), &program.indexed), &tagged)
                } else {
                    OperandTags::new()
                };
                let switches = [key.use_larger_time, key.optional];
                let here = [begins.is_some(), entered.is_some()];
                let asked = (&*key.names, key.class, &key.units, switches, touched, here);
                let known = known.entry(asked).or_insert_with_key(|(.., touched, _)| {
                    priced(table, sum_of(table, key, touched), begins, entered)
                });
                known.clone()
            }
        };
        if begun {
            block = instruction.block;
        }
        instructions.push(match price {
            Ok(price) => Some(price),
            Err(NoPrice::Free) => None,
            Err(why) => {
                faults.push(fault(program, table, instruction, why));
                None
            }
        });
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let (overhead, refresh) = overhead(program, table, facts)?;
    let Refresh { points, bases, .. } = refresh;
    let networks = match networks::is_priced(table, facts) {
        true => Vec::new(),
        false => networks::used(program, table),
    };
    let factor = table.factor.clone();
    Ok(Prices { instructions, overhead, factor, points, bases, networks })
}

/// The price of a missing routine whose time the user states: the table's factor applies to it.
fn stated_time(table: &Table, time: Picos) -> Result<Price, NoPrice> {
    let row = Row {
        name: "stated".to_owned(),
        on: time,
        off: time,
        per_unit: Picos::ZERO,
        unit: String::new(),
        evidence: Evidence::Stated,
        source: String::new(),
        table: String::new(),
        amends: true,
    };
    Sum::new(&row, 0).price(table)
}

/// An instruction's price, and whether it includes the time of the rung that begins at the instruction.
#[derive(Clone)]
struct PricedInstruction {
    price: Result<Arc<Price>, NoPrice>,
    begun: bool,
}

/// The price of an instruction, including the time of a rung or an interrupt that begins at it.
fn priced<'a>(
    table: &Table,
    mut sum: Result<Sum<'a>, NoPrice>,
    begins: Option<&'a Row>,
    entered: Option<&'a Row>,
) -> PricedInstruction {
    let mut begun = false;
    if let (Some(rung), Ok(sum)) = (begins, &mut sum) {
        sum.add(rung, 1, 0);
        begun = true;
    }
    match (entered, &mut sum) {
        (Some(entry), Ok(sum)) => sum.add(entry, 1, 0),
        (Some(entry), Err(NoPrice::Free)) => sum = Ok(Sum::new(entry, 0)),
        _ => {}
    }
    PricedInstruction { price: sum.and_then(|sum| sum.price(table)).map(Arc::new), begun }
}

/// The price of an instruction, in this order: the row of the first of its names that has one, otherwise the row of its
/// class; the `@+` rows for its operands; the larger of both times for both, if the key asks for that; the factor. A
/// time that the user states for a less specific name also holds for this one, if it is larger than the table's.
///
/// # Errors
/// If there is no row, or the time is too large.
pub fn price_of(table: &Table, key: &TimingKey, tags: &OperandTags) -> Result<Price, NoPrice> {
    sum_of(table, key, tags)?.price(table)
}

fn sum_of<'a>(
    table: &'a Table,
    key: &TimingKey,
    touched: &OperandTags,
) -> Result<Sum<'a>, NoPrice> {
    let mut rows = key.names.iter().filter_map(|name| table.row(name).map(|row| (name, row)));
    let mut sum = match rows.next() {
        Some((name, row)) => {
            let sum = with_extras(table, key, touched, row, variant(name));
            let stated = if row.amends { None } else { rows.find(|(_, row)| row.amends) };
            match stated {
                Some((name, row)) => {
                    sum.larger_of(with_extras(table, key, touched, row, variant(name)))
                }
                None => sum,
            }
        }
        None if key.optional => return Err(NoPrice::Free),
        None => {
            let row = table.row(&format!("@{}", key.class)).ok_or(NoPrice::Missing)?;
            let sum = with_extras(table, key, touched, row, None);
            let name = key.names.last().map_or("", String::as_str);
            Sum { instead_of: Some(name.into()), ..sum }
        }
    };
    if key.use_larger_time {
        sum.on = sum.on.max(sum.off);
        sum.off = sum.on;
    }
    match &key.units {
        Units::AtMost(most) => sum.at_most_units = Some(*most).filter(|_| sum.counts_units()),
        Units::Counted(counted) => {
            sum.by_words = true;
            sum.at_most_units = Some(counted.most_units()).filter(|_| sum.counts_units());
        }
        Units::None | Units::Exactly(_) => {}
    }
    Ok(sum)
}

/// The sum of an instruction's row and of the rows that add time for its operands (`@+ZR`), except those that the row's
/// own variant (`MOV:ZR`) already includes.
fn with_extras<'a>(
    table: &'a Table,
    key: &TimingKey,
    touched: &OperandTags,
    row: &'a Row,
    included: Option<String>,
) -> Sum<'a> {
    let units = units(&key.units);
    let mut sum = Sum::new(row, units);
    let mut tags = touched.clone();
    for tag in key.names.iter().filter_map(|name| variant(name)) {
        tags.entry(tag).or_insert(1);
    }
    for (tag, &times) in tags.iter().filter(|(tag, _)| included.as_ref() != Some(tag)) {
        if let Some(extra) = table.row(&format!("@+{tag}")) {
            sum.add(extra, times, units);
            // The number of cells touched depends on the count.
            sum.counted += u128::from(extra.on.0) * u128::from(times);
        }
    }
    sum
}

/// The rows of the table that are added up for one price.
struct Sum<'a> {
    on: u128,
    off: u128,
    /// The part of the on-time that a smaller number of units can reduce: the time of the units, and what `@+` rows add
    /// for operands.
    counted: u128,
    /// The time of one unit, added up over the rows.
    per_unit: u128,
    /// The number of units in the on-time.
    units: u64,
    evidence: Evidence,
    rows: Vec<&'a str>,
    instead_of: Option<Arc<str>>,
    /// Whether the number of units is read from memory words at run time, so that it can differ from scan to scan.
    by_words: bool,
    at_most_units: Option<u64>,
}

impl<'a> Sum<'a> {
    fn new(row: &'a Row, units: u64) -> Sum<'a> {
        let mut sum = Sum {
            on: 0,
            off: 0,
            counted: 0,
            per_unit: 0,
            units,
            evidence: row.evidence,
            rows: Vec::new(),
            instead_of: None,
            by_words: false,
            at_most_units: None,
        };
        sum.add(row, 1, units);
        sum
    }

    fn add(&mut self, row: &'a Row, times: u64, units: u64) {
        let wide = u128::from;
        self.on += wide(row.on.0) * wide(times) + wide(row.per_unit.0) * wide(units);
        self.off += wide(row.off.0) * wide(times);
        self.counted += wide(row.per_unit.0) * wide(units);
        if units > 0 {
            self.per_unit += wide(row.per_unit.0);
        }
        self.evidence = self.evidence.min(row.evidence);
        self.rows.push(&row.name);
    }

    fn counts_units(&self) -> bool {
        self.per_unit > 0
    }

    /// The part of the on-time that does not depend on the number of units.
    fn base(&self) -> u128 {
        self.on.saturating_sub(self.per_unit * u128::from(self.units))
    }

    /// For the base, the time per unit and the off-time: the larger one of `self` and `stated`. If one of the two gives
    /// all of them, it is the result.
    fn larger_of(self, stated: Sum<'a>) -> Sum<'a> {
        let parts = |sum: &Sum<'_>| [sum.base(), sum.per_unit, sum.off];
        let (ours, theirs) = (parts(&self), parts(&stated));
        if theirs.iter().zip(ours).all(|(theirs, ours)| *theirs >= ours) {
            return stated;
        }
        if ours.iter().zip(theirs).all(|(ours, theirs)| *ours >= theirs) {
            return self;
        }
        // Each of the two rows gives one of the times.
        let evidence = self.evidence.min(stated.evidence);
        let [base, per_unit, off] = [0, 1, 2].map(|part| ours[part].max(theirs[part]));
        let rows = [stated.rows, self.rows].concat();
        let on = base + per_unit * u128::from(self.units);
        let counted = self.counted.max(stated.counted);
        Sum { on, off, counted, per_unit, evidence, rows, ..self }
    }

    fn price(self, table: &Table) -> Result<Price, NoPrice> {
        let fit = |time: u128| u64::try_from(time).ok().and_then(|time| table.scaled(Picos(time)));
        let fit = |time: u128| fit(time).ok_or(NoPrice::TooLarge);
        let counted = if self.at_most_units.is_some() { self.counted } else { 0 };
        let by_words = self.by_words && self.counts_units();
        let (base, per_unit) = if by_words {
            (fit(self.base())?, fit(self.per_unit)?)
        } else {
            (fit(self.on)?, Picos::ZERO)
        };
        // With a factor, the time per unit is rounded up, and so is the rest.
        let on = u128::from(base.0) + u128::from(per_unit.0) * u128::from(self.units);
        let on = u64::try_from(on).map(Picos).map_err(|_| NoPrice::TooLarge)?;
        Ok(Price {
            least: fit(self.on.saturating_sub(counted))?,
            // The off-time contains units only if it is the on-time.
            least_off: match self.off == self.on {
                true => fit(self.on.saturating_sub(counted))?,
                false => fit(self.off)?,
            },
            on,
            base,
            per_unit,
            off: fit(self.off)?,
            evidence: self.evidence,
            row: self.rows.join(" + ").into(),
            instead_of: self.instead_of,
            at_most_units: self.at_most_units,
        })
    }
}

/// The number of units of an instruction, or the largest possible one if it is not fixed; 1 if it has no units.
fn units(units: &Units) -> u64 {
    match units {
        Units::None => 1,
        Units::Exactly(n) | Units::AtMost(n) => *n,
        Units::Counted(counted) => counted.most_units(),
    }
}

/// The part of a row name after the colon in upper case, such as `T` of `OUT:T`. `None` without a colon.
fn variant(name: &str) -> Option<String> {
    name.split_once(':').map(|(_, variant)| folded(variant).into_owned())
}

fn tags(cells: &Cells, tagged: &[Option<String>]) -> OperandTags {
    let mut tags = OperandTags::new();
    for of in &cells.areas {
        if let Some(tag) = &tagged[usize::from(of.area.0)] {
            tags.insert(tag.clone(), of.count);
        }
    }
    if cells.word_bits > 0 {
        tags.insert(WORD_BIT.to_owned(), cells.word_bits);
    }
    tags
}

fn fault(program: &Program, table: &Table, at: &Instruction, why: NoPrice) -> Diagnostic {
    let name = at.timing.as_ref().and_then(|key| key.names.last()).map_or("", String::as_str);
    let (message, help) = match why {
        NoPrice::TooLarge => (
            format!("the time of {name} is too large when it is multiplied by the number of units"),
            "check the number of units and the time per unit in the table".to_owned(),
        ),
        NoPrice::Missing | NoPrice::Free => (
            format!("the table {} has no time for {name}", table.name),
            format!(
                "add the row {name},ON,OFF in microseconds to a table, or give --time {name}=12.5us"
            ),
        ),
    };
    program.fault(at, Code::NoTime, message, help)
}

fn overhead(
    program: &Program,
    table: &Table,
    facts: &Facts,
) -> Result<(Vec<OverheadTerm>, Refresh), Vec<Diagnostic>> {
    let mut terms = Vec::new();
    let mut charge = |row: &Row, times: u64, name: String, why: String| {
        let time = charged(table, row, times)?;
        terms.push(OverheadTerm { name, time, evidence: row.evidence, why });
        Ok::<(), Vec<Diagnostic>>(())
    };
    for row in table.terms("@end") {
        let name = row.name.split_once(':').map_or("END processing", |(_, name)| name);
        charge(row, 1, name.to_owned(), row.source.clone())?;
    }
    if let Some(row) = table.row("@program") {
        let count = program.mains.len() as u64;
        let why = format!("{count} x {} us; {}", row.on.us_text(), row.source);
        charge(row, count, "program starts".to_owned(), why)?;
    }
    let further = program.mains.len().saturating_sub(1) as u64;
    if let Some(row) = table.row("@further-program").filter(|_| further > 0) {
        let why = format!("{further} x {} us; {}", row.on.us_text(), row.source);
        charge(row, further, "further programs".to_owned(), why)?;
    }
    let refresh = refresh::refresh(program, table, facts)?;
    terms.extend(refresh.terms.iter().cloned());
    terms.extend(networks::terms(table, facts)?);
    Ok((terms, refresh))
}

#[cfg(test)]
mod tests;

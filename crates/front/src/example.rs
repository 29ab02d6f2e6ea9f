//! Example lines of instructions. `explain` and the calibration decode them, so that an instruction's properties are
//! written only in the catalog.

use super::catalog::{Extent, Operand, Role, Row, Vocabulary};

/// The examples of one instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Examples {
    /// The dialect in which the lines are written.
    pub dialect: &'static str,
    /// The names of variants of the instruction, such as the pulsed, double-word or unsigned one.
    pub variants: Vec<String>,
    /// One entry for each form of the instruction: a form takes other operands than the others.
    pub forms: Vec<ExampleForm>,
}

/// The examples of one form of an instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExampleForm {
    /// Lines of this form with a program around each. The first one that decodes without errors is the example.
    pub candidates: Vec<Example>,
}

/// A line, and a program that contains it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Example {
    /// A line with the instruction.
    pub line: String,
    /// A complete program that contains the line.
    pub program: String,
}

/// The kind of device or constant that an example operand must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sample {
    /// A device that is a bit.
    Bit,
    /// A word, the first of several words, the beginning of a text, or a device of any type.
    Word,
    /// A constant number.
    Number,
    /// A name or an address.
    Address,
    /// An operand with a role that only this dialect has.
    Extra,
}

/// The kind of example operand for each operand of a row, including the optional one.
pub fn samples<V: Vocabulary>(row: &Row<V>) -> Vec<Sample> {
    let counters = row.operands.iter().filter_map(|one| one.extent.amount().counter());
    let counters: Vec<usize> = counters.chain(row.units).collect();
    let sample = |(at, operand): (usize, &Operand<V::Role>)| match (&operand.role, operand.extent) {
        (Role::Extra(_), _) => Sample::Extra,
        (Role::Number, _) => Sample::Number,
        // A counting operand is a constant in examples, so that the count is known.
        (Role::Source, _) if counters.contains(&at) => Sample::Number,
        (Role::Address, _) => Sample::Address,
        (_, Extent::Bits(_)) => Sample::Bit,
        (_, Extent::Words(_) | Extent::Devices(_) | Extent::Text) => Sample::Word,
    };
    row.operands.iter().enumerate().map(sample).collect()
}

/// A form from its possible lines. Each line is a candidate in each frame: a program in which `{}` stands for the line.
pub fn form(lines: &[String], frames: &[&str]) -> ExampleForm {
    let candidates = lines.iter().flat_map(|line| {
        frames.iter().map(move |frame| Example {
            line: line.clone(),
            program: frame.replace("{}", line) + "\n",
        })
    });
    ExampleForm { candidates: candidates.collect() }
}

/// Those of `names` that differ from `name` only by prefixes in `before` and suffixes in `behind`, at most one of each
/// on either side.
pub fn variants_of<'n>(
    name: &str,
    names: impl Iterator<Item = &'n str>,
    before: &[&str],
    behind: &[&str],
) -> Vec<String> {
    let bare = |name: &str| -> Vec<String> {
        let heads = before.iter().filter_map(|head| name.strip_prefix(head)).chain([name]);
        let both = heads.flat_map(|rest| {
            behind.iter().filter_map(move |tail| rest.strip_suffix(tail)).chain([rest])
        });
        both.filter(|rest| !rest.is_empty()).map(str::to_owned).collect()
    };
    let own = bare(name);
    // They match if they are equal without a prefix and a suffix on either side.
    let is_variant =
        |other: &&str| *other != name && bare(other).iter().any(|rest| own.contains(rest));
    names.filter(is_variant).map(str::to_owned).collect()
}

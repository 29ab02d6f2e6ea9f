//! Lines that show what an instruction looks like, so that what a front knows of it can be read off a program instead of
//! being written down a second time.

use super::catalog::{Extent, Operand, Role, Row, Vocabulary};

/// An instruction by its name, with lines that show its forms.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Specimens {
    /// The dialect in which they are written.
    pub dialect: &'static str,
    /// Instructions that do the same in another way: with a pulse, of two words, without a sign.
    pub variants: Vec<String>,
    /// Its forms.
    pub forms: Vec<Form>,
}

/// One form of an instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Form {
    /// Lines of this form, and a program around each: the first that is sound shows it.
    pub tries: Vec<Specimen>,
}

/// A line and a program in which it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Specimen {
    /// The line.
    pub line: String,
    /// The program.
    pub program: String,
}

/// What a sample of an operand has to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sample {
    /// A bit.
    Bit,
    /// A word, or the first of several.
    Word,
    /// A number.
    Number,
    /// A name or an address.
    Address,
    /// What only the dialect has.
    Own,
}

/// What samples of a row's operands have to be, all that may be missing among them.
pub fn samples<V: Vocabulary>(row: &Row<V>) -> Vec<Sample> {
    let counters = row.operands.iter().filter_map(|one| one.extent.amount().counter());
    let counters: Vec<usize> = counters.chain(row.units).collect();
    let sample = |(at, operand): (usize, &Operand<V::Role>)| match (&operand.role, operand.extent) {
        (Role::Own(_), _) => Sample::Own,
        (Role::Number, _) => Sample::Number,
        // What counts others is known in the line: a word might say anything.
        (Role::Source, _) if counters.contains(&at) => Sample::Number,
        (Role::Address, _) => Sample::Address,
        (_, Extent::Bits(_)) => Sample::Bit,
        (_, Extent::Words(_) | Extent::Devices(_) | Extent::Text) => Sample::Word,
    };
    row.operands.iter().enumerate().map(sample).collect()
}

/// A form by the lines in which it may be written, each in every frame.
pub fn form(lines: &[String], frames: &[&str]) -> Form {
    let tries = lines.iter().flat_map(|line| {
        frames.iter().map(move |frame| Specimen {
            line: line.clone(),
            program: frame.replace("{}", line) + "\n",
        })
    });
    Form { tries: tries.collect() }
}

/// Names that differ from one by what stands before and behind it.
pub fn akin<'n>(
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
    // One must be the other with something before or behind it, or both the same with something else.
    let is_akin =
        |other: &&str| *other != name && bare(other).iter().any(|rest| own.contains(rest));
    names.filter(is_akin).map(str::to_owned).collect()
}

//! The areas of memory, and what people call the devices in them.

use super::Cell;

/// What an area holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AreaKind {
    /// One bit a cell.
    Bit,
    /// Sixteen bits a cell.
    Word,
}

/// How an area's indices are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Radix {
    /// Base 10.
    Decimal,
    /// Base 16, upper case.
    Hexadecimal,
    /// Base 8.
    Octal,
}

/// What an area is for, as far as the stages behind ask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// What a program keeps, or what the machine keeps for it.
    Memory,
    /// Points that come in from terminals, one a cell.
    Input,
    /// Points that go out to terminals, one a cell.
    Output,
    /// What a front makes for itself, such as what an instruction remembers: no device that anybody knows.
    Hidden,
}

/// A named area of memory, such as all `D` registers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Area {
    /// The letters in front of the index, as users write them.
    pub name: String,
    /// Other letters by which timing tables may name the same cells.
    pub aliases: &'static [&'static str],
    /// What it is for.
    pub role: Role,
    /// Bits or words.
    pub kind: AreaKind,
    /// How indices are written.
    pub radix: Radix,
}

impl Area {
    /// An area of memory.
    pub fn new(name: impl Into<String>, kind: AreaKind, radix: Radix) -> Area {
        Area { name: name.into(), aliases: &[], role: Role::Memory, kind, radix }
    }
}

/// What people call a device: a cell, or a bit of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Device {
    /// The cell; of a device that has several, the one that is read by its plain name.
    pub cell: Cell,
    /// The bit of that word.
    pub bit: Option<u8>,
}

/// An operand that names a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operand {
    /// Where it stands in the instruction's text: from this byte on.
    pub start: u32,
    /// Up to this byte.
    pub end: u32,
    /// The device, the first of several; where an index is added to it, the one for index 0.
    pub device: Device,
}

impl Operand {
    /// As the source has it; `text` is its instruction's.
    #[must_use]
    pub fn written(self, text: &str) -> &str {
        text.get(self.start as usize..self.end as usize).unwrap_or_default()
    }
}

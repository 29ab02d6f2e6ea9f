//! Memory areas, and the devices in them.

use super::Cell;

/// The size of an area's cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AreaKind {
    /// One bit for each cell.
    Bit,
    /// Sixteen bits for each cell.
    Word,
}

/// The notation of an area's indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Radix {
    /// Base 10.
    Decimal,
    /// Base 16, upper case.
    Hexadecimal,
    /// Base 8.
    Octal,
}

/// The use of an area, as far as later stages need it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// Memory of the program or of the CPU.
    Memory,
    /// Input points on terminals, one for each cell.
    Input,
    /// Output points on terminals, one for each cell.
    Output,
    /// Internal memory that the front adds, such as the previous condition of an edge instruction. Users do not know
    /// these cells.
    Internal,
}

/// A named memory area, such as all `D` registers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Area {
    /// The letters before the index, as users write them.
    pub name: String,
    /// Other letters that timing tables may use for the same cells.
    pub aliases: &'static [&'static str],
    /// Its use.
    pub role: Role,
    /// Bits or words.
    pub kind: AreaKind,
    /// The notation of its indices.
    pub radix: Radix,
}

impl Area {
    /// An area with role `Memory` and without aliases.
    pub fn new(name: impl Into<String>, kind: AreaKind, radix: Radix) -> Area {
        Area { name: name.into(), aliases: &[], role: Role::Memory, kind, radix }
    }
}

/// A device: a cell, or a bit of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Device {
    /// The cell. If the device has several (such as a timer), the one that its plain name reads.
    pub cell: Cell,
    /// The bit number, for a bit of a word.
    pub bit: Option<u8>,
}

/// An operand that names a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operand {
    /// The byte offset in the instruction's text at which it begins.
    pub start: u32,
    /// The byte offset at which it ends.
    pub end: u32,
    /// The device, or the first of several. For an indexed operand, the device at index 0.
    pub device: Device,
}

impl Operand {
    /// The operand's text; `text` is the text of its instruction.
    #[must_use]
    pub fn source_text(self, text: &str) -> &str {
        text.get(self.start as usize..self.end as usize).unwrap_or_default()
    }
}

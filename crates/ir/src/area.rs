//! Memory areas, and the devices in them.

use super::Cell;

/// Whether an area's cells are bits or words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AreaKind {
    /// One bit for each cell.
    Bit,
    /// Sixteen bits for each cell.
    Word,
}

/// The base in which the indices of an area's cells are written in device names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Radix {
    /// Indices are written in base 10.
    Decimal,
    /// Indices are written in base 16, upper case.
    Hexadecimal,
    /// Indices are written in base 8.
    Octal,
}

/// What the cells of an area are used for, as far as later stages need to know it.
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
    /// Other letters that timing tables may use for the cells of the area.
    pub aliases: &'static [&'static str],
    /// What the area's cells are used for: memory, inputs, outputs, or memory that the front adds.
    pub role: Role,
    /// Whether the cells are bits or words.
    pub kind: AreaKind,
    /// The base in which the indices of the cells are written.
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
    /// The cell of the device. If the device has several cells (such as a timer), the one that its plain name reads.
    pub cell: Cell,
    /// The number of the bit in the word, 0 to 15. `None` if the device is a whole cell.
    pub bit: Option<u8>,
}

/// An operand that names a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operand {
    /// The byte offset in the instruction's text at which the operand begins.
    pub start: u32,
    /// The byte offset in the instruction's text at which the operand ends.
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

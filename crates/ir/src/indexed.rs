//! The cells that an instruction writes through an index, or up to a count.

use super::{Cell, Region, WordSource};

/// The cells that an instruction may write if an index selects them, or if a word gives their number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IndexedWrite {
    /// The first cell that is written if the index is 0.
    pub first: Cell,
    /// The possible interpretations of the index, each a signed number, low word first. If there are several, it is
    /// unknown which one the CPU uses. The constant 0 if no index selects the cells.
    pub indices: Vec<Vec<WordSource>>,
    /// The number of cells that are written.
    pub length: Length,
    /// The least and the largest index that the user stated. `None` if none is stated.
    pub stated: Option<(i64, i64)>,
    /// The ranges of cells (first and last index in the area) that `passes::values` proved the write to stay in; empty
    /// if it proved none.
    pub proved: Vec<(u32, u32)>,
}

impl IndexedWrite {
    /// Whether a region is in the same area as these cells. Regions in other areas that the instruction writes with the
    /// same choice are not part of the indexed write.
    #[must_use]
    pub fn shares_area(&self, region: Region) -> bool {
        match region {
            Region::Area(area) => area == self.first.area,
            Region::Range { first, .. } => first.area == self.first.area,
            Region::Everything => false,
        }
    }

    /// The region of the area of [`IndexedWrite::first`] from the cell with index `least` to the one with index
    /// `largest`, inclusive.
    #[must_use]
    pub fn range(&self, (least, largest): (u32, u32)) -> Region {
        let first = Cell { index: least, ..self.first };
        Region::Range { first, count: largest - least + 1 }
    }

    /// Whether a region stands for everything that the write may reach: the whole area, or a range of several cells
    /// that begins at [`IndexedWrite::first`].
    #[must_use]
    pub fn may_reach(&self, region: Region) -> bool {
        match region {
            Region::Area(area) => area == self.first.area,
            Region::Range { first, count } => first == self.first && count > 1,
            Region::Everything => false,
        }
    }

    /// Whether a region stands for all cells that the write may reach if nothing is known of the index: see
    /// [`IndexedWrite::may_reach`], or a range in the same area of more than 65,535 cells.
    #[must_use]
    pub fn is_unknown_in(&self, region: Region) -> bool {
        let is_all = match region {
            Region::Range { first, count } => {
                first.area == self.first.area && count > u32::from(u16::MAX)
            }
            Region::Area(_) | Region::Everything => false,
        };
        is_all || self.may_reach(region)
    }
}

/// The number of cells that an instruction writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Length {
    /// A constant number of cells.
    Exactly(u32),
    /// The number of cells is the value of this word times this constant.
    Counted(WordSource, u32),
    /// An unknown number of cells.
    Unknown,
}

//! What is written at a device that has an index, or as far as a word counts.

use super::{Cell, Region, WordSource};

/// The cells that an instruction writes whose device has an index, or of which a word counts how many there are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Indexed {
    /// The first cell if the index is 0.
    pub first: Cell,
    /// The index, each way in which it may be read: a signed number, its least word first. Which holds is not known.
    pub readings: Vec<Vec<WordSource>>,
    /// How many cells are written from there on.
    pub length: Length,
    /// What the user stated of the index: the least and the largest.
    pub stated: Option<(i64, i64)>,
    /// Between which cells, both included, those lie that are written, as `passes::values` found; empty where it did not.
    pub found: Vec<(u32, u32)>,
}

impl Indexed {
    /// Whether a region lies in the area of these cells. Another that is written with them is none of theirs, and none that
    /// is written with the same choice lies there besides.
    #[must_use]
    pub fn shares_area(&self, region: Region) -> bool {
        match region {
            Region::Area(area) => area == self.first.area,
            Region::Range { first, .. } => first.area == self.first.area,
            Region::Everything => false,
        }
    }

    /// The cells of this area from one number to another, both included.
    #[must_use]
    pub fn stretch(&self, (least, largest): (u32, u32)) -> Region {
        let first = Cell { index: least, ..self.first };
        Region::Range { first, count: largest - least + 1 }
    }

    /// Whether a region is what these cells are some of: their area, or all from the first on.
    #[must_use]
    pub fn may_reach(&self, region: Region) -> bool {
        match region {
            Region::Area(area) => area == self.first.area,
            Region::Range { first, count } => first == self.first && count > 1,
            Region::Everything => false,
        }
    }

    /// Whether a region is what these cells are some of and nothing narrows it: all that the index's bits can say, if no
    /// more.
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

/// How many cells an instruction writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Length {
    /// A known number.
    Exactly(u32),
    /// A number for each that a word counts.
    Counted(WordSource, u32),
    /// It is not known.
    Unknown,
}

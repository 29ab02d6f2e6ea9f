//! Elements with their places on a sheet.

/// A point of the grid: columns to the right, rows down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Spot {
    /// The column.
    pub x: i32,
    /// The row.
    pub y: i32,
}

/// What stands somewhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Node {
    /// An index into `Diagram::places`.
    Place(usize),
    /// An index into `Diagram::transitions`.
    Transition(usize),
}

/// An element with its place on the sheet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawn {
    /// What it is.
    pub node: Node,
    /// Whether it belongs to another page, and is shown as the end of an arc.
    pub is_guest: bool,
    /// The middle of its symbol's first row.
    pub at: Spot,
    /// How many rows it takes.
    pub rows: i32,
    /// How far it reaches to the left and to the right, with what is written beside it.
    pub reach: (i32, i32),
}

/// How far a symbol reaches to either side of its middle.
pub const HALF: i32 = 2;

/// The rows of a place's symbol.
pub const ROWS: i32 = 3;

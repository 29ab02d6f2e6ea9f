//! Elements with their places on a sheet.

/// A point of the grid: columns to the right, rows down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Spot {
    /// The column.
    pub x: i32,
    /// The row.
    pub y: i32,
}

/// An element of the drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Node {
    /// An index into `Diagram::places`.
    Place(usize),
    /// An index into `Diagram::transitions`.
    Transition(usize),
}

/// An element with its position on the sheet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawn {
    /// The element.
    pub node: Node,
    /// Whether it belongs to another page and is drawn only as the end of an arc.
    pub is_guest: bool,
    /// The centre of the first row of its symbol.
    pub at: Spot,
    /// The number of rows.
    pub rows: i32,
    /// The extent to the left and right, including its label.
    pub reach: (i32, i32),
}

/// Half the width of a symbol, in columns.
pub const HALF: i32 = 2;

/// The height of a place's symbol, in rows.
pub const ROWS: i32 = 3;

//! What a net says about the relays of the code generated from it, for an audit of that code.

/// The relays of a net's code, and which of them the net never turns on together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Relays {
    /// The net's file.
    pub file: String,
    /// The places and transitions that have relays.
    pub elements: Vec<Element>,
    /// Sets of elements, by number, whose relays are never all on at the end of a scan.
    pub exclusive: Vec<Vec<usize>>,
    /// The names of the relays for each type of CPU. A program uses the first entry whose characteristic device it
    /// contains.
    pub spellings: Vec<Spelling>,
}

/// A place or transition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Its name.
    pub name: String,
    /// Whether it is a place, that is a box, timer or counter.
    pub is_place: bool,
}

/// The names of relays for one type of CPU.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spelling {
    /// A word device that only CPUs of this type have; `None` for the type without such a device.
    pub sign: Option<&'static str>,
    /// The device of each element; `None` if this type of CPU has no such relay.
    pub devices: Vec<Option<String>>,
}

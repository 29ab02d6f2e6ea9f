//! What a net says about the relays of its code, for an audit of that code.

/// The relays of a net's code, and which of them the net never turns on together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Relays {
    /// The net's file.
    pub file: String,
    /// The places and transitions that have relays.
    pub elements: Vec<Element>,
    /// Sets of elements, by their numbers, whose relays are never all on when a scan ends.
    pub exclusive: Vec<Vec<usize>>,
    /// How each kind of CPU calls the relays. The first whose sign a program has is the one of that program.
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

/// What a kind of CPU calls relays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spelling {
    /// A word that only CPUs of this kind have; `None` for those that have none of the others' signs.
    pub sign: Option<&'static str>,
    /// The device of each element; `None` if this kind of CPU has no such relay.
    pub devices: Vec<Option<String>>,
}

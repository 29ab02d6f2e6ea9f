//! State for counting statements during lowering.

use std::collections::BTreeMap;

/// The statements counted so far, and the body that is being lowered.
#[derive(Default)]
pub(crate) struct Tally {
    /// The statements recorded so far, by body and number within it. A body that is lowered several times counts once.
    pub(super) known: BTreeMap<(usize, u32), usize>,
    /// The body that is being lowered; None if its statements are not counted.
    pub(crate) current: Option<Current>,
}

/// The body that is being lowered.
#[derive(Clone, Copy)]
pub(crate) struct Current {
    pub(crate) body: usize,
    /// Number of the next statement in the body.
    pub(crate) next: u32,
    /// Whether the body is a diagram or an instruction list, so that values are kept between statements.
    pub(crate) keeps: bool,
    /// The first instruction, and its line, of the statements that only keep a value for the next one.
    pub(crate) kept_from: Option<(usize, u32)>,
    /// Whether lowering is inside a statement that counts for everything in it.
    pub(crate) is_within: bool,
}

//! What is known of statements while a program is put together.

use std::collections::BTreeMap;

/// What is counted while a program is put together.
#[derive(Default)]
pub(crate) struct Tally {
    /// Statements that are known, by their body and their number there.
    pub(super) known: BTreeMap<(usize, u32), usize>,
    /// The body that is put together.
    pub(crate) current: Option<Current>,
}

/// A body that is put together.
#[derive(Clone, Copy)]
pub(crate) struct Current {
    pub(crate) body: usize,
    /// The number of its next statement.
    pub(crate) next: u32,
    /// Whether it is drawn or a list, so that values are kept between its statements.
    pub(crate) keeps: bool,
    /// Where the instructions begin that keep a value for the next statement, and in which line.
    pub(crate) kept_from: Option<(usize, u32)>,
    /// Whether what is put together stands in a statement that counts for all in it.
    pub(crate) is_within: bool,
}

//! Addresses that words hold: a real run knows to which device they lead, but not which numbers they are.

use super::state::State;
use scanbound_ir::{Cell, Number, WordSource};

impl State<'_> {
    /// If the number is an address that is moved: the first cell of the addressed range. Where a number is added to an
    /// address the sum is not known: no manual page says that consecutive devices have consecutive addresses.
    pub(super) fn pointer(&self, number: &Number) -> Option<Cell> {
        let Number::Words(words) = number else { return None };
        match words[..] {
            [WordSource::Cell(low), WordSource::Cell(high)] if high == low.plus(1) => {
                self.pointers.get(&low).copied()
            }
            _ => None,
        }
    }
}

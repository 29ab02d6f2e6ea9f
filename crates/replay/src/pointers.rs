//! Addresses that words hold: a real run knows to which device they lead, but not which numbers they are.

use super::state::State;
use scanbound_ir::{Cell, Number, WordSource};

impl State<'_> {
    /// If the number is certainly an address: the first cell of the addressed range. It is if it is moved, or if a
    /// known number is added or subtracted: in indirect specification, consecutive words have consecutive addresses.
    pub(super) fn pointer(&mut self, number: &Number) -> Option<Cell> {
        if self.pointers.is_empty() {
            return None;
        }
        match number {
            Number::Words(words) => match words[..] {
                [WordSource::Cell(low), WordSource::Cell(high)] if high == low.plus(1) => {
                    self.pointers.get(&low).copied()
                }
                _ => None,
            },
            Number::Add(a, b) => match (self.pointer(a), self.pointer(b)) {
                (Some(pointer), None) if self.is_known(b) => Some(pointer),
                (None, Some(pointer)) if self.is_known(a) => Some(pointer),
                _ => None,
            },
            Number::Sub(a, b) => self.pointer(a).filter(|_| self.is_known(b)),
            Number::And(..) | Number::Or(..) | Number::Xor(..) => None,
        }
    }

    fn is_known(&mut self, number: &Number) -> bool {
        let outer = self.doubt.take();
        self.number(number);
        std::mem::replace(&mut self.doubt, outer).is_none()
    }
}

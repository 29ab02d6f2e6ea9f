//! The cells that a write by an index may reach.

use super::integers::Integers;

/// So many stretches of cells are told apart.
const MOST_STRETCHES: u32 = 32;

/// The cells that a write by an index may reach: as many from the first on, and from every `step`th behind it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reach {
    first: u32,
    /// The first cell of the last ones.
    last: u32,
    /// How far apart the first ones are; 0 if there is but one.
    step: u32,
    /// How many are written from each of them on.
    length: u32,
}

impl Reach {
    /// So many cells from one of these on; `None` if that is beyond all areas.
    pub fn of(cells: &Integers, length: i64) -> Option<Reach> {
        let reach = Reach {
            first: u32::try_from(cells.low).ok()?,
            last: u32::try_from(cells.high).ok()?,
            step: u32::try_from(cells.step()).ok()?,
            length: u32::try_from(length).ok()?,
        };
        reach.last.checked_add(reach.length)?;
        Some(reach)
    }

    /// The cells of both.
    pub fn join(self, other: Reach) -> Reach {
        let cells =
            |one: Reach| Integers::progression(one.first.into(), one.last.into(), one.step.into());
        let both = cells(self).join(&cells(other));
        Reach {
            first: self.first.min(other.first),
            last: self.last.max(other.last),
            step: u32::try_from(both.step()).unwrap_or(1),
            length: self.length.max(other.length),
        }
    }

    /// The last of all.
    fn end(self) -> u32 {
        self.last + (self.length - 1)
    }

    /// The cells where both hold.
    pub fn closer(self, other: Reach) -> Reach {
        let is_within = |one: Reach, of: Reach| of.first <= one.first && one.end() <= of.end();
        match (is_within(self, other), is_within(other, self)) {
            (true, true) if other.stretches().len() > self.stretches().len() => other,
            (true, _) => self,
            (_, true) => other,
            // Neither lies in the other: what both reach, one after the other.
            _ => {
                let (first, last) = (self.first.max(other.first), self.end().min(other.end()));
                if first > last { self } else { Reach { first, last, step: 1, length: 1 } }
            }
        }
    }

    /// The stretches of cells, the first and the last of each.
    pub fn stretches(self) -> Vec<(u32, u32)> {
        if self.step <= self.length || (self.last - self.first) / self.step >= MOST_STRETCHES {
            return vec![(self.first, self.end())];
        }
        let all = (self.first..=self.last).step_by(self.step as usize);
        all.map(|first| (first, first + (self.length - 1))).collect()
    }
}

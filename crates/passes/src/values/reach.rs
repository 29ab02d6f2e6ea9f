//! The cells that an indexed write may reach, as ranges at equal distances.

use super::integers::Integers;

/// If there are more separate ranges of cells than this, they count as one range.
const MAX_STRETCHES: u32 = 32;

/// The cells that an indexed write may reach: `length` cells from `first` on, and from every `step`-th cell after it up
/// to `last`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reach {
    first: u32,
    /// The first cell of the last range.
    last: u32,
    /// The distance between the beginnings of two ranges; 0 if there is only one range.
    step: u32,
    /// The number of cells in each range.
    length: u32,
}

impl Reach {
    /// The ranges of `length` cells that begin at these cell numbers; `None` if a number or the length is negative or
    /// does not fit into 32 bits.
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

    /// A set of ranges that includes both sets.
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

    /// The last cell of the last range.
    fn end(self) -> u32 {
        self.last + (self.length - 1)
    }

    /// A set of ranges that includes every cell which is in both sets: the set that lies between the ends of the other
    /// (if both do, the one with more ranges); otherwise, without gaps, the range between the larger first and the
    /// smaller last cell. `self` if that range is empty.
    pub fn meet(self, other: Reach) -> Reach {
        let is_within = |one: Reach, of: Reach| of.first <= one.first && one.end() <= of.end();
        match (is_within(self, other), is_within(other, self)) {
            (true, true) if other.stretches().len() > self.stretches().len() => other,
            (true, _) => self,
            (_, true) => other,
            // Neither contains the other: use the range that both have in common, without gaps.
            _ => {
                let (first, last) = (self.first.max(other.first), self.end().min(other.end()));
                if first > last { self } else { Reach { first, last, step: 1, length: 1 } }
            }
        }
    }

    /// The ranges of cells, each as first and last cell; one range from the first to the last cell if they leave no
    /// gaps, or are more than [`MAX_STRETCHES`].
    pub fn stretches(self) -> Vec<(u32, u32)> {
        if self.step <= self.length || (self.last - self.first) / self.step >= MAX_STRETCHES {
            return vec![(self.first, self.end())];
        }
        let all = (self.first..=self.last).step_by(self.step as usize);
        all.map(|first| (first, first + (self.length - 1))).collect()
    }
}

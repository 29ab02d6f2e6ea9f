//! A set of small integers as a bit set, for markings and relations.

/// A set of integers below a limit that is fixed at creation.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Bits(Vec<u64>);

impl Bits {
    /// The empty set of numbers below `limit`.
    #[must_use]
    pub fn new(limit: usize) -> Bits {
        Bits(vec![0; limit.div_ceil(64)])
    }

    /// The set of these members.
    #[must_use]
    pub fn of(limit: usize, members: &[usize]) -> Bits {
        let mut bits = Bits::new(limit);
        members.iter().for_each(|&member| bits.insert(member));
        bits
    }

    /// Whether the set contains the number.
    #[must_use]
    pub fn contains(&self, member: usize) -> bool {
        self.0[member / 64] >> (member % 64) & 1 == 1
    }

    /// Adds a number.
    pub fn insert(&mut self, member: usize) {
        self.0[member / 64] |= 1 << (member % 64);
    }

    /// Removes a number.
    pub fn remove(&mut self, member: usize) {
        self.0[member / 64] &= !(1 << (member % 64));
    }

    /// Adds all members of another set. Returns whether the set has changed.
    pub fn union_with(&mut self, other: &Bits) -> bool {
        let mut changed = false;
        for (own, more) in self.0.iter_mut().zip(&other.0) {
            changed |= *more & !*own != 0;
            *own |= more;
        }
        changed
    }

    /// Removes all members of another set.
    pub fn remove_all(&mut self, other: &Bits) {
        for (own, less) in self.0.iter_mut().zip(&other.0) {
            *own &= !less;
        }
    }

    /// The smallest member above this number.
    #[must_use]
    pub fn next_after(&self, member: usize) -> Option<usize> {
        let start = member + 1;
        let first = self.0.get(start / 64)? & (u64::MAX << (start % 64));
        let mut words = std::iter::once(first).chain(self.0[start / 64 + 1..].iter().copied());
        let at = words.position(|word| word != 0)?;
        let word = if at == 0 { first } else { self.0[start / 64 + at] };
        Some((start / 64 + at) * 64 + word.trailing_zeros() as usize)
    }

    /// Whether this set contains all members of the other.
    #[must_use]
    pub fn is_superset(&self, other: &Bits) -> bool {
        self.0.iter().zip(&other.0).all(|(own, asked)| asked & !own == 0)
    }

    /// The members in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().enumerate().flat_map(|(at, &word)| {
            let mut rest = word;
            std::iter::from_fn(move || {
                let bit = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
                rest &= rest - 1;
                Some(at * 64 + bit)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_holds_what_was_put_in() {
        let mut bits = Bits::of(130, &[0, 64, 129]);
        bits.remove(64);
        bits.insert(5);
        assert_eq!(bits.iter().collect::<Vec<_>>(), [0, 5, 129]);
        assert!(bits.contains(129) && !bits.contains(64));
        let after = [0, 4, 5, 63, 128, 129].map(|member| bits.next_after(member));
        assert_eq!(after, [Some(5), Some(5), Some(129), Some(129), Some(129), None]);
        let mut rest = bits.clone();
        rest.remove_all(&Bits::of(130, &[1, 5]));
        assert_eq!(rest.iter().collect::<Vec<_>>(), [0, 129]);
        assert!(
            bits.union_with(&Bits::of(130, &[7])) && !bits.clone().union_with(&Bits::of(130, &[7]))
        );
    }
}

//! A set of small numbers, as markings and relations need them.

/// A set of numbers below a limit that is fixed when it is made.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Bits(Vec<u64>);

impl Bits {
    /// The empty set of numbers below `limit`.
    #[must_use]
    pub fn new(limit: usize) -> Bits {
        Bits(vec![0; limit.div_ceil(64)])
    }

    /// The set of these.
    #[must_use]
    pub fn of(limit: usize, members: &[usize]) -> Bits {
        let mut bits = Bits::new(limit);
        members.iter().for_each(|&member| bits.insert(member));
        bits
    }

    /// Whether it has the number.
    #[must_use]
    pub fn has(&self, member: usize) -> bool {
        self.0[member / 64] >> (member % 64) & 1 == 1
    }

    /// Takes a number in.
    pub fn insert(&mut self, member: usize) {
        self.0[member / 64] |= 1 << (member % 64);
    }

    /// Takes a number out.
    pub fn remove(&mut self, member: usize) {
        self.0[member / 64] &= !(1 << (member % 64));
    }

    /// Takes all of another set in; whether that changed anything.
    pub fn join(&mut self, other: &Bits) -> bool {
        let mut changed = false;
        for (own, more) in self.0.iter_mut().zip(&other.0) {
            changed |= *more & !*own != 0;
            *own |= more;
        }
        changed
    }

    /// Whether it has all of another set.
    #[must_use]
    pub fn has_all(&self, other: &Bits) -> bool {
        self.0.iter().zip(&other.0).all(|(own, asked)| asked & !own == 0)
    }

    /// Its numbers, the least first.
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
        assert!(bits.has(129) && !bits.has(64));
        assert!(bits.join(&Bits::of(130, &[7])) && !bits.clone().join(&Bits::of(130, &[7])));
    }
}

//! What a word may hold: consecutive values on the ring of 65,536, so that numbers about 0 need no sign.

/// Values from `low` on, `span` more behind it, going round at 65,535.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Ring {
    low: u16,
    span: u16,
}

impl Ring {
    /// Anything.
    pub const TOP: Ring = Ring { low: 0, span: u16::MAX };

    /// One value.
    pub const fn constant(value: u16) -> Ring {
        Ring { low: value, span: 0 }
    }

    /// The integers of a range, each modulo 65,536: anything if that is all of them.
    pub fn of(low: i64, high: i64) -> Ring {
        match u16::try_from(high - low) {
            Ok(span) if span < u16::MAX => Ring { low: low as u16, span },
            _ => Ring::TOP,
        }
    }

    /// The first of the values.
    #[must_use]
    pub fn first(self) -> u16 {
        self.low
    }

    /// How many more are behind it.
    #[must_use]
    pub fn span(self) -> u16 {
        self.span
    }

    /// The value, if there is but one.
    pub fn as_constant(self) -> Option<u16> {
        (self.span == 0).then_some(self.low)
    }

    /// The least and the largest as signed numbers.
    pub fn signed(self) -> (i64, i64) {
        let low = i64::from(self.low.cast_signed());
        let high = low + i64::from(self.span);
        if high > i64::from(i16::MAX) { (i16::MIN.into(), i16::MAX.into()) } else { (low, high) }
    }

    /// The least and the largest as unsigned numbers.
    pub fn unsigned(self) -> (i64, i64) {
        let low = i64::from(self.low);
        let high = low + i64::from(self.span);
        if high > i64::from(u16::MAX) { (0, u16::MAX.into()) } else { (low, high) }
    }

    /// All values but those from one to another, both included.
    #[must_use]
    pub fn but(low: u16, high: u16) -> Ring {
        Ring { low: high.wrapping_add(1), span: low.wrapping_sub(high).wrapping_sub(2) }
    }

    /// Each value and another, modulo 65,536.
    #[must_use]
    pub fn plus(self, other: Ring) -> Ring {
        let low = self.low.wrapping_add(other.low);
        match self.span.checked_add(other.span) {
            Some(span) if span < u16::MAX => Ring { low, span },
            _ => Ring::TOP,
        }
    }

    /// Whether no value is in both.
    #[must_use]
    pub fn is_apart(self, other: Ring) -> bool {
        self.low.wrapping_sub(other.low) > other.span
            && other.low.wrapping_sub(self.low) > self.span
    }

    /// Whether it has all of the other's values.
    #[must_use]
    pub fn holds(self, other: Ring) -> bool {
        let from = u32::from(other.low.wrapping_sub(self.low));
        self.span == u16::MAX || from + u32::from(other.span) <= u32::from(self.span)
    }

    /// The closer of two, or what lies in both: any value that lies in both lies in it.
    pub fn closer(self, other: Ring) -> Ring {
        if other.holds(self) {
            return self;
        }
        if self.holds(other) {
            return other;
        }
        let from = u32::from(other.low.wrapping_sub(self.low));
        let back = u32::from(self.low.wrapping_sub(other.low));
        match (from <= self.span.into(), back <= other.span.into()) {
            // They meet at both ends.
            (true, true) => {
                if self.span <= other.span {
                    self
                } else {
                    other
                }
            }
            (true, false) => Ring { low: other.low, span: self.span - from as u16 },
            (false, true) => Ring { low: self.low, span: other.span - back as u16 },
            // None lies in both.
            (false, false) => self,
        }
    }

    /// All values of both, and as few others as can be.
    pub fn join(self, other: Ring) -> Ring {
        if self.holds(other) {
            return self;
        }
        if other.holds(self) {
            return other;
        }
        let on_from = |first: Ring, then: Ring| {
            let from = u32::from(then.low.wrapping_sub(first.low));
            let span = (from + u32::from(then.span)).max(first.span.into());
            u16::try_from(span).map_or(Ring::TOP, |span| Ring { low: first.low, span })
        };
        let (a, b) = (on_from(self, other), on_from(other, self));
        if a.span <= b.span { a } else { b }
    }
}

/// The least and largest value of a signed number of one or two words.
fn ends(words: &[Ring]) -> Option<(i64, i64)> {
    match words {
        [word] => Some(word.signed()),
        [low, high] => {
            let ((low, most), (upper, uppermost)) = (low.unsigned(), high.signed());
            Some((upper * 65_536 + low, uppermost * 65_536 + most))
        }
        _ => None,
    }
}

/// Between which ends a signed number of one or two words lies: two stretches where one word passes from the largest
/// number to the least; none if it has more words.
#[must_use]
pub fn stretches(words: &[Ring]) -> Vec<(i64, i64)> {
    let (least, largest) = (i64::from(i16::MIN), i64::from(i16::MAX));
    match words {
        [Ring::TOP] => vec![(least, largest)],
        [word] => {
            let low = i64::from(word.low.cast_signed());
            let high = low + i64::from(word.span);
            match high - largest {
                more @ 1.. => vec![(low, largest), (least, least + more - 1)],
                _ => vec![(low, high)],
            }
        }
        words => ends(words).into_iter().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: [i64; 12] = [-32_768, -32_767, -300, -2, -1, 0, 1, 5, 299, 32_766, 32_767, 32_768];

    fn rings() -> Vec<Ring> {
        let spans = [0, 1, 5, 400, 32_767, 32_768, 65_534, 65_535];
        ENDS.iter().flat_map(|&low| spans.map(|span| Ring::of(low, low + span))).collect()
    }

    fn has(ring: Ring, value: i64) -> bool {
        ring.holds(Ring::constant(value as u16))
    }

    #[test]
    fn what_is_joined_holds_the_values_and_ends_do() {
        for a in rings() {
            for b in rings() {
                let joined = a.join(b);
                for value in ENDS {
                    if has(a, value) || has(b, value) {
                        assert!(has(joined, value), "{a:?} {b:?} {value}");
                    }
                }
            }
            let ((low, high), (least, largest)) = (a.signed(), a.unsigned());
            for value in ENDS.into_iter().filter(|&value| has(a, value)) {
                assert!((low..=high).contains(&i64::from((value as u16).cast_signed())));
                assert!((least..=largest).contains(&i64::from(value as u16)));
            }
        }
    }

    #[test]
    fn small_things_stay_small() {
        assert_eq!(Ring::constant(0).join(Ring::constant(19)), Ring::of(0, 19));
        assert_eq!(Ring::of(-2, 1).join(Ring::constant(3)), Ring::of(-2, 3));
        assert_eq!(Ring::of(0, 65_535), Ring::TOP);
    }

    #[test]
    fn two_words_end_where_both_do() {
        assert_eq!(ends(&[Ring::of(-1, 4)]), Some((-1, 4)));
        assert_eq!(ends(&[Ring::of(1, 5), Ring::of(-1, 2)]), Some((-65_535, 131_077)));
        assert_eq!(ends(&[Ring::of(-1, 0), Ring::constant(1)]), Some((65_536, 131_071)));
        assert_eq!(ends(&[Ring::TOP; 3]), None);
    }

    #[test]
    fn sums_and_complements_hold_what_they_should_and_no_more() {
        let values: Vec<u16> = ENDS.iter().map(|&value| value as u16).collect();
        for (a, b) in rings().into_iter().flat_map(|a| rings().into_iter().map(move |b| (a, b))) {
            let sum = a.plus(b);
            let of = |ring: Ring| values.iter().copied().filter(move |&v| has(ring, v.into()));
            for x in of(a) {
                for y in of(b) {
                    assert!(has(sum, x.wrapping_add(y).into()), "{a:?} {b:?}");
                }
            }
            let shared = values.iter().any(|&v| has(a, v.into()) && has(b, v.into()));
            assert!(!(shared && a.is_apart(b)), "{a:?} {b:?}");
        }
        for low in [0u16, 1, 300, 0x7FFF, 0xFFFE] {
            for high in [1u16, 300, 0x7FFF, 0x8000, 0xFFFE].into_iter().filter(|&high| high >= low)
            {
                let but = Ring::but(low, high);
                for value in values.iter().copied().chain([low, high]) {
                    let inside = (low..=high).contains(&value);
                    assert_eq!(has(but, value.into()), !inside, "{value} {low} {high}");
                }
            }
        }
        assert!(
            Ring::of(0, 5).is_apart(Ring::of(6, 9)) && !Ring::of(0, 5).is_apart(Ring::of(5, 9))
        );
        assert_eq!(Ring::of(1, 5).plus(Ring::of(-1, 2)), Ring::of(0, 7));
    }
}

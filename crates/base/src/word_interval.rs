//! The abstract value of a 16-bit word: an interval of consecutive values modulo 65,536 (a wrapped interval), which
//! serves for signed and unsigned numbers alike.

/// The values `low`, `low + 1`, … `low + span`, each modulo 65,536. Never empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct WordInterval {
    low: u16,
    span: u16,
}

impl WordInterval {
    /// All 65,536 values.
    pub const TOP: WordInterval = WordInterval { low: 0, span: u16::MAX };

    /// The interval that contains only this value.
    pub const fn constant(value: u16) -> WordInterval {
        WordInterval { low: value, span: 0 }
    }

    /// The interval of the integers `low..=high`, each modulo 65,536; all values if the range is as long as that or
    /// longer, or if `low` is above `high`.
    pub fn of(low: i64, high: i64) -> WordInterval {
        match u16::try_from(high - low) {
            Ok(span) if span < u16::MAX => WordInterval { low: low as u16, span },
            _ => WordInterval::TOP,
        }
    }

    /// The first value of the interval. It is above the last one if the interval wraps around from 65,535 to 0.
    #[must_use]
    pub fn first(self) -> u16 {
        self.low
    }

    /// The number of values minus 1.
    #[must_use]
    pub fn span(self) -> u16 {
        self.span
    }

    /// The value, if the interval contains only one; otherwise `None`.
    pub fn as_constant(self) -> Option<u16> {
        (self.span == 0).then_some(self.low)
    }

    /// The smallest and the largest value as signed numbers. All signed values if the interval passes from 32,767 to
    /// -32,768.
    pub fn signed(self) -> (i64, i64) {
        let low = i64::from(self.low.cast_signed());
        let high = low + i64::from(self.span);
        if high > i64::from(i16::MAX) { (i16::MIN.into(), i16::MAX.into()) } else { (low, high) }
    }

    /// The smallest and the largest value as unsigned numbers. All unsigned values if the interval passes from 65,535
    /// to 0.
    pub fn unsigned(self) -> (i64, i64) {
        let low = i64::from(self.low);
        let high = low + i64::from(self.span);
        if high > i64::from(u16::MAX) { (0, u16::MAX.into()) } else { (low, high) }
    }

    /// The complement: all values except `low..=high`. `low` must not be above `high`, and `low..=high` not all values.
    #[must_use]
    pub fn all_except(low: u16, high: u16) -> WordInterval {
        WordInterval { low: high.wrapping_add(1), span: low.wrapping_sub(high).wrapping_sub(2) }
    }

    /// The interval of the sums modulo 65,536 of a value of one interval and a value of the other.
    #[must_use]
    pub fn wrapping_add(self, other: WordInterval) -> WordInterval {
        let low = self.low.wrapping_add(other.low);
        match self.span.checked_add(other.span) {
            Some(span) if span < u16::MAX => WordInterval { low, span },
            _ => WordInterval::TOP,
        }
    }

    /// Whether the two intervals have no value in common.
    #[must_use]
    pub fn is_disjoint(self, other: WordInterval) -> bool {
        self.low.wrapping_sub(other.low) > other.span
            && other.low.wrapping_sub(self.low) > self.span
    }

    /// Whether this interval contains every value of the other.
    #[must_use]
    pub fn contains(self, other: WordInterval) -> bool {
        let from = u32::from(other.low.wrapping_sub(self.low));
        self.span == u16::MAX || from + u32::from(other.span) <= u32::from(self.span)
    }

    /// An over-approximation of the intersection: every value that lies in both intervals lies in the result. If the
    /// intersection is one interval, the result is exact. If it consists of two intervals, the result is the smaller of
    /// `self` and `other`; if it is empty, the result is `self`.
    pub fn meet(self, other: WordInterval) -> WordInterval {
        if other.contains(self) {
            return self;
        }
        if self.contains(other) {
            return other;
        }
        let from = u32::from(other.low.wrapping_sub(self.low));
        let back = u32::from(self.low.wrapping_sub(other.low));
        match (from <= self.span.into(), back <= other.span.into()) {
            // The intersection consists of two intervals.
            (true, true) => {
                if self.span <= other.span {
                    self
                } else {
                    other
                }
            }
            (true, false) => WordInterval { low: other.low, span: self.span - from as u16 },
            (false, true) => WordInterval { low: self.low, span: other.span - back as u16 },
            // The intersection is empty, which an interval cannot express.
            (false, false) => self,
        }
    }

    /// The smallest interval that contains both intervals.
    pub fn join(self, other: WordInterval) -> WordInterval {
        if self.contains(other) {
            return self;
        }
        if other.contains(self) {
            return other;
        }
        let on_from = |first: WordInterval, then: WordInterval| {
            let from = u32::from(then.low.wrapping_sub(first.low));
            let span = (from + u32::from(then.span)).max(first.span.into());
            u16::try_from(span)
                .map_or(WordInterval::TOP, |span| WordInterval { low: first.low, span })
        };
        let (a, b) = (on_from(self, other), on_from(other, self));
        if a.span <= b.span { a } else { b }
    }
}

/// The smallest and the largest value of a signed number of one or two words (low word first). `None` for other numbers
/// of words.
fn signed_bounds(words: &[WordInterval]) -> Option<(i64, i64)> {
    match words {
        [word] => Some(word.signed()),
        [low, high] => {
            let ((low, most), (upper, uppermost)) = (low.unsigned(), high.signed());
            Some((upper * 65_536 + low, uppermost * 65_536 + most))
        }
        _ => None,
    }
}

/// The ranges, each from its least to its largest value, in which a signed number of one or two words (low word first)
/// lies. A single word whose interval passes from 32,767 to -32,768 gives two ranges, unless it may have all values.
/// Empty for other numbers of words.
#[must_use]
pub fn signed_ranges(words: &[WordInterval]) -> Vec<(i64, i64)> {
    let (least, largest) = (i64::from(i16::MIN), i64::from(i16::MAX));
    match words {
        [WordInterval::TOP] => vec![(least, largest)],
        [word] => {
            let low = i64::from(word.low.cast_signed());
            let high = low + i64::from(word.span);
            match high - largest {
                more @ 1.. => vec![(low, largest), (least, least + more - 1)],
                _ => vec![(low, high)],
            }
        }
        words => signed_bounds(words).into_iter().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: [i64; 12] = [-32_768, -32_767, -300, -2, -1, 0, 1, 5, 299, 32_766, 32_767, 32_768];

    fn rings() -> Vec<WordInterval> {
        let spans = [0, 1, 5, 400, 32_767, 32_768, 65_534, 65_535];
        ENDS.iter().flat_map(|&low| spans.map(|span| WordInterval::of(low, low + span))).collect()
    }

    fn has(ring: WordInterval, value: i64) -> bool {
        ring.contains(WordInterval::constant(value as u16))
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
        assert_eq!(
            WordInterval::constant(0).join(WordInterval::constant(19)),
            WordInterval::of(0, 19)
        );
        assert_eq!(
            WordInterval::of(-2, 1).join(WordInterval::constant(3)),
            WordInterval::of(-2, 3)
        );
        assert_eq!(WordInterval::of(0, 65_535), WordInterval::TOP);
    }

    #[test]
    fn two_words_end_where_both_do() {
        assert_eq!(signed_bounds(&[WordInterval::of(-1, 4)]), Some((-1, 4)));
        assert_eq!(
            signed_bounds(&[WordInterval::of(1, 5), WordInterval::of(-1, 2)]),
            Some((-65_535, 131_077))
        );
        assert_eq!(
            signed_bounds(&[WordInterval::of(-1, 0), WordInterval::constant(1)]),
            Some((65_536, 131_071))
        );
        assert_eq!(signed_bounds(&[WordInterval::TOP; 3]), None);
    }

    #[test]
    fn sums_and_complements_hold_what_they_should_and_no_more() {
        let values: Vec<u16> = ENDS.iter().map(|&value| value as u16).collect();
        for (a, b) in rings().into_iter().flat_map(|a| rings().into_iter().map(move |b| (a, b))) {
            let sum = a.wrapping_add(b);
            let of =
                |ring: WordInterval| values.iter().copied().filter(move |&v| has(ring, v.into()));
            for x in of(a) {
                for y in of(b) {
                    assert!(has(sum, x.wrapping_add(y).into()), "{a:?} {b:?}");
                }
            }
            let shared = values.iter().any(|&v| has(a, v.into()) && has(b, v.into()));
            assert!(!(shared && a.is_disjoint(b)), "{a:?} {b:?}");
        }
        for low in [0u16, 1, 300, 0x7FFF, 0xFFFE] {
            for high in [1u16, 300, 0x7FFF, 0x8000, 0xFFFE].into_iter().filter(|&high| high >= low)
            {
                let but = WordInterval::all_except(low, high);
                for value in values.iter().copied().chain([low, high]) {
                    let inside = (low..=high).contains(&value);
                    assert_eq!(has(but, value.into()), !inside, "{value} {low} {high}");
                }
            }
        }
        assert!(
            WordInterval::of(0, 5).is_disjoint(WordInterval::of(6, 9))
                && !WordInterval::of(0, 5).is_disjoint(WordInterval::of(5, 9))
        );
        assert_eq!(
            WordInterval::of(1, 5).wrapping_add(WordInterval::of(-1, 2)),
            WordInterval::of(0, 7)
        );
    }
}

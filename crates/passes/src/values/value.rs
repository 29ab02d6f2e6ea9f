//! The abstract value of a word: a strided interval modulo 65,536, or a small set of values.
//!
//! A strided interval is an arithmetic progression that may wrap around (T. Reps, G. Balakrishnan, J. Lim:
//! Intermediate-representation recovery from low-level code, PEPM 2006), on the wrapped intervals of `base`.

use scanbound_base::word_interval::WordInterval;

/// Sets of at most this many values are represented exactly. The model of the scan distinguishes the same number of
/// values of an index.
pub const MAX_EXACT: usize = 8;
/// At most this many values of a word are listed in a constraint on the start of a scan.
const MAX_LISTED_VALUES: u32 = 256;
/// The number of different values that a word can have.
const ALL: u32 = 1 << 16;

/// The abstract value of a word: a set of numbers that contains every value that the word may have. Never empty.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Value {
    /// The interval from the first value to the last one; it may wrap around.
    ring: WordInterval,
    /// The stride: the first value and every `step`-th value after it; 0 for a single value.
    step: u16,
    /// The number of values in `few`; 0 if there are too many values to list.
    count: u8,
    /// The values in ascending unsigned order, if `count` is not 0.
    few: [u16; MAX_EXACT],
}

impl std::fmt::Debug for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.list() {
            Some(few) => write!(f, "{few:?}"),
            None => write!(f, "{:?} by {}", self.ring, self.step),
        }
    }
}

/// How far widening extends a value that keeps growing.
#[derive(Debug, Clone, Copy)]
pub enum Growth<'a> {
    /// To the next of these signed numbers, which are sorted; beyond the last one, to the smallest or largest number.
    To(&'a [i64]),
    /// To 0 or the largest signed number; to all values if there are negative numbers.
    Ends,
}

/// The greatest common divisor; of 0 and a number, the number.
pub fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn gcd_of(all: &[u32]) -> u32 {
    all.iter().fold(0, |all, &one| gcd(all.into(), one.into()) as u32)
}

impl Value {
    /// The set of all values.
    pub const TOP: Value =
        Value { ring: WordInterval::TOP, step: 1, count: 0, few: [0; MAX_EXACT] };

    /// The set that contains only this value.
    pub const fn constant(value: u16) -> Value {
        let mut few = [0; MAX_EXACT];
        few[0] = value;
        Value { ring: WordInterval::constant(value), step: 0, count: 1, few }
    }

    /// The integers of `low..=high`, each modulo 65,536; all values if they are more than 65,536.
    pub fn range(low: i64, high: i64) -> Value {
        match u32::try_from(high - low) {
            Ok(span) if span < ALL => Value::progression(low as u16, span, 1),
            _ => Value::TOP,
        }
    }

    /// All values of an interval.
    pub fn of(ring: WordInterval) -> Value {
        Value::progression(ring.first(), ring.span().into(), 1)
    }

    /// The values `first`, `first + step`, ..., up to `first + span`, each modulo 65,536.
    pub fn progression(first: u16, span: u32, step: u32) -> Value {
        let step = step.max(1);
        let span = span - span % step;
        if span / step < MAX_EXACT as u32 && span < ALL {
            let all = (0..=span / step).map(|place| first.wrapping_add((place * step) as u16));
            return Value::few_of(&mut all.collect::<Vec<u16>>());
        }
        if span >= ALL - 1 {
            return Value::TOP;
        }
        let ring = WordInterval::of(first.into(), i64::from(first) + i64::from(span));
        Value { ring, step: step as u16, count: 0, few: [0; MAX_EXACT] }
    }

    /// All values with the same remainder as `to` by a divisor. With wraparound only the part of the divisor that is a
    /// power of two counts.
    pub fn congruent(to: u16, divisor: u32) -> Value {
        let divisor = gcd_of(&[divisor, ALL]);
        Value::progression((u32::from(to) % divisor) as u16, ALL - divisor, divisor)
    }

    /// The set of these values, over-approximated if there are more than [`MAX_EXACT`]; `None` if there are none.
    pub fn of_values(values: impl IntoIterator<Item = u16>) -> Option<Value> {
        let mut all: Vec<u16> = values.into_iter().collect();
        (!all.is_empty()).then(|| Value::few_of(&mut all))
    }

    fn few_of(all: &mut Vec<u16>) -> Value {
        if let [one] = all[..] {
            return Value::constant(one);
        }
        all.sort_unstable();
        all.dedup();
        // The interval begins after the widest gap.
        let gap = |place: usize| all[(place + 1) % all.len()].wrapping_sub(all[place]);
        let widest = (0..all.len()).max_by_key(|&place| (gap(place), place)).unwrap_or(0);
        let (first, last) = (all[(widest + 1) % all.len()], all[widest]);
        let from_first: Vec<u32> =
            all.iter().map(|value| u32::from(value.wrapping_sub(first))).collect();
        let (span, step) = (last.wrapping_sub(first), gcd_of(&from_first));
        if all.len() > MAX_EXACT {
            return Value::progression(first, span.into(), step);
        }
        let mut few = [0; MAX_EXACT];
        few[..all.len()].copy_from_slice(all);
        let ring = WordInterval::of(first.into(), i64::from(first) + i64::from(span));
        Value { ring, step: step as u16, count: all.len() as u8, few }
    }

    /// The smallest interval known to contain all values; it may wrap around.
    pub fn ring(&self) -> WordInterval {
        self.ring
    }

    /// The stride; 0 for a single value.
    pub fn step(&self) -> u32 {
        self.step.into()
    }

    /// The list of values in ascending unsigned order; `None` if they are more than [`MAX_EXACT`].
    pub fn list(&self) -> Option<&[u16]> {
        (self.count > 0).then(|| &self.few[..self.count.into()])
    }

    /// The value, if there is only one.
    pub fn as_constant(&self) -> Option<u16> {
        self.ring.as_constant()
    }

    /// The smallest and the largest value as signed numbers.
    pub fn signed(&self) -> (i64, i64) {
        match self.list() {
            Some(few) => ends_of(few.iter().map(|value| i64::from(value.cast_signed()))),
            None => self.ring.signed(),
        }
    }

    /// The smallest and the largest value as unsigned numbers.
    pub fn unsigned(&self) -> (i64, i64) {
        match self.list() {
            Some(few) => ends_of(few.iter().map(|&value| i64::from(value))),
            None => self.ring.unsigned(),
        }
    }

    /// The list of values for a constraint on the start of a scan; `None` if they are all numbers of a range, or more
    /// than [`MAX_LISTED_VALUES`].
    pub fn list_for_start(&self) -> Option<Vec<u16>> {
        let (low, high) = self.signed();
        if *self == Value::range(low, high) || self.size() > MAX_LISTED_VALUES {
            return None;
        }
        let place = |place: u32| self.ring.first().wrapping_add((place * self.step()) as u16);
        Some(match self.list() {
            Some(few) => few.to_vec(),
            None => (0..self.size()).map(place).collect(),
        })
    }

    /// The same set if a constraint on the start of a scan can list its values, otherwise the whole signed range.
    #[must_use]
    pub fn as_start(self) -> Value {
        let (low, high) = self.signed();
        if self.list_for_start().is_some() { self } else { Value::range(low, high) }
    }

    /// The number of values.
    fn size(&self) -> u32 {
        match self.list() {
            Some(few) => few.len() as u32,
            None => u32::from(self.ring.span()) / self.step() + 1,
        }
    }

    /// Whether this is one of the values.
    pub fn contains_value(&self, value: u16) -> bool {
        match self.list() {
            Some(few) => few.contains(&value),
            None => {
                let from = u32::from(value.wrapping_sub(self.ring.first()));
                from <= self.ring.span().into() && from.is_multiple_of(self.step())
            }
        }
    }

    /// Whether this set certainly contains all values of `other`.
    pub fn contains(&self, other: &Value) -> bool {
        match (self.list(), other.list()) {
            (_, Some(few)) => few.iter().all(|&value| self.contains_value(value)),
            (Some(_), None) => false,
            (None, None) => {
                self.ring.contains(other.ring)
                    && self.contains_value(other.ring.first())
                    && other.step().is_multiple_of(self.step())
            }
        }
    }

    /// A set that contains all values of both sets.
    pub fn join(self, other: Value) -> Value {
        if self.contains(&other) {
            return self;
        }
        if other.contains(&self) {
            return other;
        }
        if let (Some(few), Some(more)) = (self.list(), other.list()) {
            return Value::few_of(&mut [few, more].concat());
        }
        let (a, b) = (self.ring.first(), other.ring.first());
        let ring = self.ring.join(other.ring);
        if ring.span() == u16::MAX {
            let apart = u32::from(a.wrapping_sub(b));
            return Value::congruent(a, gcd_of(&[self.step(), other.step(), apart]));
        }
        let from = |first: u16| u32::from(first.wrapping_sub(ring.first()));
        let step = gcd_of(&[self.step(), other.step(), from(a), from(b)]);
        Value::progression(ring.first(), ring.span().into(), step)
    }

    /// A set that contains the common values of both sets; `None` if they have none.
    pub fn meet(self, other: Value) -> Option<Value> {
        if let Some(few) = self.list() {
            return Value::of_values(
                few.iter().copied().filter(|&value| other.contains_value(value)),
            );
        }
        if let Some(few) = other.list() {
            return Value::of_values(
                few.iter().copied().filter(|&value| self.contains_value(value)),
            );
        }
        let (one, two) = (self.restricted(other.ring)?, other.restricted(self.ring)?);
        Some(if one.size() <= two.size() { one } else { two })
    }

    /// A set that contains the common values of both sets; `self` if they have none.
    pub fn closer(self, other: Value) -> Value {
        self.meet(other).unwrap_or(self)
    }

    /// The values that lie in an interval; `self` if those would be two ranges. `None` if there are none.
    fn restricted(self, to: WordInterval) -> Option<Value> {
        let (own, span, step) =
            (self.ring.first(), u32::from(self.ring.span()), self.step().max(1));
        let from = u32::from(to.first().wrapping_sub(own));
        let end = from + u32::from(to.span());
        let ahead = (from <= span).then(|| (from, end.min(span)));
        // After wraparound the progression continues from the beginning.
        let round = (end >= ALL).then(|| (0, (end - ALL).min(span)));
        let (low, high) = match (ahead, round) {
            (Some(_), Some(_)) => return Some(self),
            (one, other) => one.or(other)?,
        };
        let low = low.next_multiple_of(step);
        let high = high - high % step;
        let first = own.wrapping_add(low as u16);
        (low <= high).then(|| Value::progression(first, high - low, step))
    }

    /// Widening: the union, extended so that repeated application reaches a fixpoint soon. A set that remains small may
    /// grow by single values, unless `growth` is [`Growth::Ends`].
    #[must_use]
    pub fn widen(self, other: Value, growth: Growth<'_>) -> Value {
        let joined = self.join(other);
        if joined == self {
            return self;
        }
        let ((low, high), (was, had)) = (joined.signed(), self.signed());
        let (least, largest) = (i64::from(i16::MIN), i64::from(i16::MAX));
        let (to_low, to_high) = match growth {
            Growth::To(_) if joined.list().is_some() => return joined,
            Growth::To(limits) => {
                let below = limits.partition_point(|&limit| limit <= low);
                let above = limits.partition_point(|&limit| limit < high);
                let end = if low < 0 { least } else { 0 };
                let below = below.checked_sub(1).map_or(end, |place| limits[place].max(end));
                (below, limits.get(above).copied().unwrap_or(largest))
            }
            Growth::Ends if low < 0 => return Value::TOP,
            Growth::Ends => (0, largest),
        };
        let low = if low < was { to_low } else { low };
        let high = if high > had { to_high } else { high };
        // Other known properties are preserved, because the joined values have them.
        let step = match growth {
            Growth::Ends if joined.step != self.step => 1,
            _ => joined.step().max(1),
        };
        let (Some(first), Some(last)) = (joined.first_signed(), joined.last_signed()) else {
            return Value::range(low, high);
        };
        let step = i64::from(step);
        let (low, high) = (first - (first - low) / step * step, last + (high - last) / step * step);
        match u32::try_from(high - low) {
            Ok(span) if span < ALL => Value::progression(low as u16, span, step as u32),
            _ => Value::TOP,
        }
    }

    /// The first value of the interval as a signed number; `None` if it is not the smallest, because of wraparound.
    fn first_signed(&self) -> Option<i64> {
        let first = i64::from(self.ring.first().cast_signed());
        (first == self.signed().0).then_some(first)
    }

    /// The last value of the interval as a signed number; `None` if it is not the largest, because of wraparound.
    fn last_signed(&self) -> Option<i64> {
        let last = self.ring.first().wrapping_add(self.ring.span());
        let last = i64::from(last.cast_signed());
        (last == self.signed().1).then_some(last)
    }

    /// A set that contains the sums of a value of each set, modulo 65,536.
    #[must_use]
    pub fn add(self, other: Value) -> Value {
        if let Some(found) = self.each_pair(other, u16::wrapping_add) {
            return found;
        }
        let first = self.ring.first().wrapping_add(other.ring.first());
        let span = u32::from(self.ring.span()) + u32::from(other.ring.span());
        let step = gcd_of(&[self.step(), other.step()]);
        if span < ALL - 1 {
            return Value::progression(first, span, step);
        }
        Value::congruent(first, step)
    }

    /// The negatives of all values, modulo 65,536.
    #[must_use]
    pub fn negated(self) -> Value {
        if let Some(few) = self.list() {
            let all = Value::of_values(few.iter().map(|value| value.wrapping_neg()));
            return all.unwrap_or(self);
        }
        let last = self.ring.first().wrapping_add(self.ring.span());
        Value::progression(last.wrapping_neg(), self.ring.span().into(), self.step())
    }

    /// The results of a function on all pairs of values; `None` if one set has more than [`MAX_EXACT`] values.
    pub fn each_pair(self, other: Value, of: impl Fn(u16, u16) -> u16) -> Option<Value> {
        let (a, b) = (self.list()?, other.list()?);
        let pairs = a.iter().flat_map(|&a| b.iter().map(move |&b| (a, b)));
        Value::of_values(pairs.map(|(a, b)| of(a, b)))
    }

    /// A set that contains the results of a bitwise AND of a value of each set.
    #[must_use]
    pub fn and(self, other: Value) -> Value {
        if let Some(found) = self.each_pair(other, |a, b| a & b) {
            return found;
        }
        let high = self.unsigned().1.min(other.unsigned().1);
        let unit = self.zeros().max(other.zeros());
        let (value, mask) = match (self.as_constant(), other.as_constant()) {
            (Some(mask), _) => (other, mask),
            (_, Some(mask)) => (self, mask),
            _ => return Value::progression(0, high as u32, unit),
        };
        if mask.count_ones() <= MAX_EXACT.ilog2() {
            // Enumerates the subsets of the mask's bits, from the least to the mask itself.
            let next = |part: &u16| (*part != mask).then(|| part.wrapping_sub(mask) & mask);
            let parts =
                std::iter::successors(Some(0), next).filter(|&part| i64::from(part) <= high);
            return Value::of_values(parts).unwrap_or(Value::TOP);
        }
        if mask.trailing_ones() == mask.count_ones() && value.unsigned().1 <= mask.into() {
            return value;
        }
        Value::progression(0, high as u32, unit)
    }

    /// A power of two that divides all values.
    fn zeros(&self) -> u32 {
        gcd_of(&[self.step(), self.ring.first().into(), ALL])
    }

    /// A set that contains the results of a bitwise OR, or exclusive OR if `is_exclusive`, of a value of each set.
    #[must_use]
    pub fn or(self, other: Value, is_exclusive: bool) -> Value {
        let found = self.each_pair(other, |a, b| if is_exclusive { a ^ b } else { a | b });
        if let Some(found) = found {
            return found;
        }
        // For the highest bit alone, exclusive OR equals addition.
        const HIGHEST: u16 = 1 << 15;
        if is_exclusive && [self, other].contains(&Value::constant(HIGHEST)) {
            return self.add(other);
        }
        let ((a, ah), (b, bh)) = (self.unsigned(), other.unsigned());
        let low = if is_exclusive { 0 } else { a.max(b) };
        let high = (ah.max(bh) as u64 + 1).next_power_of_two() as i64 - 1;
        let unit = self.zeros().min(other.zeros());
        let low = (low as u32).next_multiple_of(unit);
        Value::progression(low as u16, (high as u32).saturating_sub(low), unit)
    }
}

fn ends_of(values: impl Iterator<Item = i64> + Clone) -> (i64, i64) {
    (values.clone().min().unwrap_or(0), values.max().unwrap_or(0))
}

//! What a word may hold: a range on the ring of 65,536 with a stride, or a few values.
//!
//! A stride makes of a range an arithmetic progression that may go round: strided intervals (T. Reps, G. Balakrishnan,
//! J. Lim: Intermediate-representation recovery from low-level code, PEPM 2006) on the ring of `base::ring`.

use scanbound_base::ring::Ring;

/// So many values are told one by one; the scan's model tells as many values of an index apart.
pub const MOST_FEW: usize = 8;
/// So many values of a word are told apart when a scan starts.
const MOST_APART: u32 = 256;
/// How many values a word has.
const ALL: u32 = 1 << 16;

/// What a word may hold.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Value {
    /// From the first to the last of them.
    ring: Ring,
    /// The first and every so manieth behind it; 0 if there is but one.
    step: u16,
    /// How many they are if they are few, else 0; and then these, in their order as unsigned numbers.
    count: u8,
    few: [u16; MOST_FEW],
}

impl std::fmt::Debug for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.few() {
            Some(few) => write!(f, "{few:?}"),
            None => write!(f, "{:?} by {}", self.ring, self.step),
        }
    }
}

/// How far what grows again and again is let grow.
#[derive(Debug, Clone, Copy)]
pub enum Growth<'a> {
    /// To the next of these signed numbers, which are in order; beyond them to an end of the numbers.
    To(&'a [i64]),
    /// To an end of the numbers.
    Ends,
}

/// The greatest common divisor; that of 0 and a number is the number.
pub fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn gcd_of(all: &[u32]) -> u32 {
    all.iter().fold(0, |all, &one| gcd(all.into(), one.into()) as u32)
}

impl Value {
    /// Anything.
    pub const TOP: Value = Value { ring: Ring::TOP, step: 1, count: 0, few: [0; MOST_FEW] };

    /// One value.
    pub const fn constant(value: u16) -> Value {
        let mut few = [0; MOST_FEW];
        few[0] = value;
        Value { ring: Ring::constant(value), step: 0, count: 1, few }
    }

    /// The integers of a range, each modulo 65,536.
    pub fn range(low: i64, high: i64) -> Value {
        match u32::try_from(high - low) {
            Ok(span) if span < ALL => Value::progression(low as u16, span, 1),
            _ => Value::TOP,
        }
    }

    /// All of a ring.
    pub fn of(ring: Ring) -> Value {
        Value::progression(ring.first(), ring.span().into(), 1)
    }

    /// From the first on every `step`th, up to `span` behind it.
    pub fn progression(first: u16, span: u32, step: u32) -> Value {
        let step = step.max(1);
        let span = span - span % step;
        if span / step < MOST_FEW as u32 && span < ALL {
            let all = (0..=span / step).map(|place| first.wrapping_add((place * step) as u16));
            return Value::few_of(&mut all.collect::<Vec<u16>>());
        }
        if span >= ALL - 1 {
            return Value::TOP;
        }
        let ring = Ring::of(first.into(), i64::from(first) + i64::from(span));
        Value { ring, step: step as u16, count: 0, few: [0; MOST_FEW] }
    }

    /// All that leave the same remainder as this by a divisor, also of what goes round: by its part of 65,536.
    pub fn congruent(to: u16, divisor: u32) -> Value {
        let divisor = gcd_of(&[divisor, ALL]);
        Value::progression((u32::from(to) % divisor) as u16, ALL - divisor, divisor)
    }

    /// These values, or more; `None` if there are none.
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
        // They begin behind the widest gap.
        let gap = |place: usize| all[(place + 1) % all.len()].wrapping_sub(all[place]);
        let widest = (0..all.len()).max_by_key(|&place| (gap(place), place)).unwrap_or(0);
        let (first, last) = (all[(widest + 1) % all.len()], all[widest]);
        let from_first: Vec<u32> =
            all.iter().map(|value| u32::from(value.wrapping_sub(first))).collect();
        let (span, step) = (last.wrapping_sub(first), gcd_of(&from_first));
        if all.len() > MOST_FEW {
            return Value::progression(first, span.into(), step);
        }
        let mut few = [0; MOST_FEW];
        few[..all.len()].copy_from_slice(all);
        let ring = Ring::of(first.into(), i64::from(first) + i64::from(span));
        Value { ring, step: step as u16, count: all.len() as u8, few }
    }

    /// The range in which they lie.
    pub fn ring(&self) -> Ring {
        self.ring
    }

    /// The first of them and every so manieth behind it; 0 if there is but one.
    pub fn step(&self) -> u32 {
        self.step.into()
    }

    /// All of them, if they are few.
    pub fn few(&self) -> Option<&[u16]> {
        (self.count > 0).then(|| &self.few[..self.count.into()])
    }

    /// The value, if there is but one.
    pub fn as_constant(&self) -> Option<u16> {
        self.ring.as_constant()
    }

    /// The least and the largest as signed numbers.
    pub fn signed(&self) -> (i64, i64) {
        match self.few() {
            Some(few) => ends_of(few.iter().map(|value| i64::from(value.cast_signed()))),
            None => self.ring.signed(),
        }
    }

    /// The least and the largest as unsigned numbers.
    pub fn unsigned(&self) -> (i64, i64) {
        match self.few() {
            Some(few) => ends_of(few.iter().map(|&value| i64::from(value))),
            None => self.ring.unsigned(),
        }
    }

    /// The values one by one where they are not all of a range and no more than a scan's start is told apart by.
    pub fn apart(&self) -> Option<Vec<u16>> {
        let (low, high) = self.signed();
        if *self == Value::range(low, high) || self.size() > MOST_APART {
            return None;
        }
        let place = |place: u32| self.ring.first().wrapping_add((place * self.step()) as u16);
        Some(match self.few() {
            Some(few) => few.to_vec(),
            None => (0..self.size()).map(place).collect(),
        })
    }

    /// The same or more: what a constraint on a scan's start says, a range or some values.
    #[must_use]
    pub fn as_start(self) -> Value {
        let (low, high) = self.signed();
        if self.apart().is_some() { self } else { Value::range(low, high) }
    }

    /// How many values there are.
    fn size(&self) -> u32 {
        match self.few() {
            Some(few) => few.len() as u32,
            None => u32::from(self.ring.span()) / self.step() + 1,
        }
    }

    /// Whether this is one of them.
    pub fn has(&self, value: u16) -> bool {
        match self.few() {
            Some(few) => few.contains(&value),
            None => {
                let from = u32::from(value.wrapping_sub(self.ring.first()));
                from <= self.ring.span().into() && from.is_multiple_of(self.step())
            }
        }
    }

    /// Whether it has all of the other's values.
    pub fn holds(&self, other: &Value) -> bool {
        match (self.few(), other.few()) {
            (_, Some(few)) => few.iter().all(|&value| self.has(value)),
            (Some(_), None) => false,
            (None, None) => {
                self.ring.holds(other.ring)
                    && self.has(other.ring.first())
                    && other.step().is_multiple_of(self.step())
            }
        }
    }

    /// All values of both.
    pub fn join(self, other: Value) -> Value {
        if self.holds(&other) {
            return self;
        }
        if other.holds(&self) {
            return other;
        }
        if let (Some(few), Some(more)) = (self.few(), other.few()) {
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

    /// All values that lie in both, and perhaps others of one of them; `None` if there are none.
    pub fn meet(self, other: Value) -> Option<Value> {
        if let Some(few) = self.few() {
            return Value::of_values(few.iter().copied().filter(|&value| other.has(value)));
        }
        if let Some(few) = other.few() {
            return Value::of_values(few.iter().copied().filter(|&value| self.has(value)));
        }
        let (one, two) = (self.restricted(other.ring)?, other.restricted(self.ring)?);
        Some(if one.size() <= two.size() { one } else { two })
    }

    /// The same, but what both say where it cannot be true together is the first.
    pub fn closer(self, other: Value) -> Value {
        self.meet(other).unwrap_or(self)
    }

    /// Those of many values that lie in a range; all where these are two stretches. `None` if there are none.
    fn restricted(self, to: Ring) -> Option<Value> {
        let (own, span, step) =
            (self.ring.first(), u32::from(self.ring.span()), self.step().max(1));
        let from = u32::from(to.first().wrapping_sub(own));
        let end = from + u32::from(to.span());
        let ahead = (from <= span).then(|| (from, end.min(span)));
        // Behind the last number it goes on from the first.
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

    /// All values of both; where that is more, it grows so far that it soon grows no more. What stays few may grow by
    /// single values, but not to the ends.
    #[must_use]
    pub fn widen(self, other: Value, growth: Growth<'_>) -> Value {
        let joined = self.join(other);
        if joined == self {
            return self;
        }
        let ((low, high), (was, had)) = (joined.signed(), self.signed());
        let (least, largest) = (i64::from(i16::MIN), i64::from(i16::MAX));
        let (to_low, to_high) = match growth {
            Growth::To(_) if joined.few().is_some() => return joined,
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
        // Whatever else is known of them stays: the values joined are among these.
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

    /// The first of them as a signed number if it is the least.
    fn first_signed(&self) -> Option<i64> {
        let first = i64::from(self.ring.first().cast_signed());
        (first == self.signed().0).then_some(first)
    }

    /// The last of them as a signed number if it is the largest.
    fn last_signed(&self) -> Option<i64> {
        let last = self.ring.first().wrapping_add(self.ring.span());
        let last = i64::from(last.cast_signed());
        (last == self.signed().1).then_some(last)
    }

    /// Each value and another, modulo 65,536.
    #[must_use]
    pub fn plus(self, other: Value) -> Value {
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

    /// Each value from 0, modulo 65,536.
    #[must_use]
    pub fn negated(self) -> Value {
        if let Some(few) = self.few() {
            let all = Value::of_values(few.iter().map(|value| value.wrapping_neg()));
            return all.unwrap_or(self);
        }
        let last = self.ring.first().wrapping_add(self.ring.span());
        Value::progression(last.wrapping_neg(), self.ring.span().into(), self.step())
    }

    /// What a function makes of each value of one and each of another, if they are few.
    pub fn each_pair(self, other: Value, of: impl Fn(u16, u16) -> u16) -> Option<Value> {
        let (a, b) = (self.few()?, other.few()?);
        let pairs = a.iter().flat_map(|&a| b.iter().map(move |&b| (a, b)));
        Value::of_values(pairs.map(|(a, b)| of(a, b)))
    }

    /// The bits that both have.
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
        if mask.count_ones() <= MOST_FEW.ilog2() {
            // Each part of the mask, from the least to the mask itself.
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

    /// A power of two of which all of them are multiples.
    fn zeros(&self) -> u32 {
        gcd_of(&[self.step(), self.ring.first().into(), ALL])
    }

    /// The bits that one of both has at least, or, `is_exclusive`, exactly one of them.
    #[must_use]
    pub fn or(self, other: Value, is_exclusive: bool) -> Value {
        let found = self.each_pair(other, |a, b| if is_exclusive { a ^ b } else { a | b });
        if let Some(found) = found {
            return found;
        }
        // The highest bit alone comes out as it does in a sum.
        const HIGHEST: u16 = 1 << 15;
        if is_exclusive && [self, other].contains(&Value::constant(HIGHEST)) {
            return self.plus(other);
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

//! Integers read from one or more words, and arithmetic on them without wraparound.

use super::value::{Value, gcd};

/// The number of values of a word.
const WORD: i64 = 1 << 16;
/// Sets of at most this many numbers are kept as lists.
const MAX_EXACT: usize = 64;

/// A non-empty set of integers, over-approximated: an arithmetic progression from `low` to `high`, or a list of
/// numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Integers {
    pub low: i64,
    pub high: i64,
    /// The stride; 0 for a single number.
    step: i64,
    /// All numbers in ascending order; `None` if they are more than [`MAX_EXACT`].
    some: Option<Vec<i64>>,
}

impl Integers {
    /// A single number.
    pub fn constant(value: i64) -> Integers {
        Integers { low: value, high: value, step: 0, some: Some(vec![value]) }
    }

    /// All numbers of `low..=high`.
    pub fn range(low: i64, high: i64) -> Integers {
        Integers::progression(low, high, 1)
    }

    /// The numbers `low`, `low + step`, ... up to `high`.
    pub fn progression(low: i64, high: i64, step: i64) -> Integers {
        let step = step.max(1);
        let high = high - (high - low) % step;
        let some = ((high - low) / step < MAX_EXACT as i64)
            .then(|| (0..=(high - low) / step).map(|place| low + place * step).collect());
        let step = if low == high { 0 } else { step };
        Integers { low, high, step, some }
    }

    /// The set of these numbers, over-approximated if there are too many; `None` if there are none.
    fn of(numbers: impl IntoIterator<Item = i64>) -> Option<Integers> {
        let mut all: Vec<i64> = numbers.into_iter().collect();
        all.sort_unstable();
        all.dedup();
        let (&low, &high) = (all.first()?, all.last()?);
        let step = all.iter().fold(0, |step, one| gcd(step, one.abs_diff(low)));
        Some(Integers {
            low,
            high,
            step: step as i64,
            some: Some(all).filter(|all| all.len() <= MAX_EXACT),
        })
    }

    /// The signed number in one or two words, low word first; `None` for another count of words.
    pub fn signed(words: &[Value]) -> Option<Integers> {
        Integers::read(words, true)
    }

    /// The number in one or two words, low word first; `None` for another count of words.
    pub fn read(words: &[Value], is_signed: bool) -> Option<Integers> {
        match words {
            [word] => Some(Integers::word(word, is_signed)),
            [lower, upper] => {
                let upper = Integers::word(upper, is_signed).multiply(&Integers::constant(WORD))?;
                upper.add(&Integers::word(lower, false))
            }
            _ => None,
        }
    }

    /// The numbers that a word with these values stands for, signed or unsigned.
    pub fn word(value: &Value, is_signed: bool) -> Integers {
        let number = |value: u16| match is_signed {
            true => i64::from(value.cast_signed()),
            false => i64::from(value),
        };
        if let Some(found) =
            value.list().and_then(|few| Integers::of(few.iter().map(|&one| number(one))))
        {
            return found;
        }
        let (ring, step) = (value.ring(), i64::from(value.step()));
        let (first, span) = (number(ring.first()), i64::from(ring.span()));
        let (least, largest) = if is_signed { (-WORD / 2, WORD / 2 - 1) } else { (0, WORD - 1) };
        if first + span <= largest {
            return Integers::progression(first, first + span, step);
        }
        // With wraparound, only the part of the stride that divides 65,536 remains valid.
        let step = gcd(step.unsigned_abs(), WORD as u64) as i64;
        Integers::progression(least + (first - least).rem_euclid(step), largest, step)
    }

    /// The values of the low `count` words of the number, low word first.
    pub fn words(&self, count: usize) -> Vec<Value> {
        (0..count).map(|place| self.above(place as u32 * 16)).collect()
    }

    /// The values of the 16 bits of the number from this bit up.
    fn above(&self, bit: u32) -> Value {
        let word = |number: i64| (number >> bit.min(63)) as u16;
        if let Some(found) =
            self.some.as_ref().and_then(|all| Value::of_values(all.iter().map(|&one| word(one))))
        {
            return found;
        }
        let (low, high) = (self.low >> bit.min(63), self.high >> bit.min(63));
        let unit = 1i64 << bit.min(62);
        let step = if self.step % unit == 0 { self.step / unit } else { 1 };
        match u32::try_from(high - low) {
            Ok(span) if span < WORD as u32 => {
                Value::progression(low as u16, span, u32::try_from(step).unwrap_or(u32::MAX))
            }
            _ => Value::congruent(low as u16, (step % WORD) as u32),
        }
    }

    /// Whether all numbers fit into this many words, as signed numbers (of at most 63 bits).
    pub fn fits(&self, words: usize) -> bool {
        let least = -(1i64 << (16 * words as u32 - 1).min(62));
        least <= self.low && self.high < -least
    }

    /// The number, if there is only one.
    pub fn as_constant(&self) -> Option<i64> {
        (self.low == self.high).then_some(self.low)
    }

    /// The list of numbers; `None` if they are more than [`MAX_EXACT`].
    pub fn list(&self) -> Option<&[i64]> {
        self.some.as_deref()
    }

    /// The stride; 0 for a single number.
    pub fn step(&self) -> u64 {
        self.step.unsigned_abs()
    }

    /// Whether the two sets certainly have no number in common.
    pub fn is_disjoint(&self, other: &Integers) -> bool {
        let apart = gcd(self.step(), other.step());
        self.high < other.low
            || other.high < self.low
            || (apart > 1 && !self.low.abs_diff(other.low).is_multiple_of(apart))
            || matches!((&self.some, &other.some), (Some(a), Some(b)) if !a.iter().any(|one| b.contains(one)))
    }

    /// The numbers that lie within `low..=high`; `None` if there are none.
    pub fn within(&self, low: i64, high: i64) -> Option<Integers> {
        if let Some(all) = &self.some {
            return Integers::of(all.iter().copied().filter(|one| (low..=high).contains(one)));
        }
        let step = self.step.max(1);
        let low = low.max(self.low);
        let low = low + (self.low - low).rem_euclid(step);
        let high = high.min(self.high);
        (low <= high).then(|| Integers::progression(low, high, step))
    }

    /// A set that contains all numbers of both sets.
    #[must_use]
    pub fn join(&self, other: &Integers) -> Integers {
        if let (Some(a), Some(b)) = (&self.some, &other.some)
            && let Some(found) = Integers::of(a.iter().chain(b).copied())
        {
            return found;
        }
        let (low, high) = (self.low.min(other.low), self.high.max(other.high));
        let apart = self.low.abs_diff(other.low);
        let step = gcd(gcd(self.step(), other.step()), apart);
        Integers::progression(low, high, step as i64)
    }

    /// The results of a function on all pairs of numbers; `None` if a set has too many numbers to be listed, or there
    /// are more than 1,024 pairs.
    fn each_pair(&self, other: &Integers, of: impl Fn(i64, i64) -> i64) -> Option<Integers> {
        let (a, b) = (self.some.as_ref()?, other.some.as_ref()?);
        if a.len() * b.len() > MAX_EXACT * MAX_EXACT / 4 {
            return None;
        }
        Integers::of(a.iter().flat_map(|&a| b.iter().map(move |&b| (a, b))).map(|(a, b)| of(a, b)))
    }

    /// A set that contains the sums of a number of each set. `None` if they overflow 64 bits.
    pub fn add(&self, other: &Integers) -> Option<Integers> {
        let (low, high) = (self.low.checked_add(other.low)?, self.high.checked_add(other.high)?);
        let found = self.each_pair(other, |a, b| a + b);
        let step = gcd(self.step(), other.step());
        found.or_else(|| Some(Integers::progression(low, high, i64::try_from(step).ok()?)))
    }

    /// The negatives of all numbers. `None` if they overflow 64 bits.
    pub fn negated(&self) -> Option<Integers> {
        let (low, high) = (self.high.checked_neg()?, self.low.checked_neg()?);
        let some = self.some.as_ref().map(|all| all.iter().rev().map(|one| -one).collect());
        Some(Integers { low, high, step: self.step, some })
    }

    /// A set that contains the products of a number of each set. `None` if they overflow 64 bits.
    pub fn multiply(&self, other: &Integers) -> Option<Integers> {
        let (a, b) = (self, other);
        let ends = [
            a.low.checked_mul(b.low)?,
            a.low.checked_mul(b.high)?,
            a.high.checked_mul(b.low)?,
            a.high.checked_mul(b.high)?,
        ];
        if let Some(found) = a.each_pair(b, |a, b| a * b) {
            return Some(found);
        }
        let (low, high) = (ends.into_iter().min()?, ends.into_iter().max()?);
        // (a + m s) (b + n t) = a b + a n t + b m s + m n s t
        let parts =
            [a.low.checked_mul(b.step)?, b.low.checked_mul(a.step)?, a.step.checked_mul(b.step)?];
        let step = parts.iter().fold(0, |step, part| gcd(step, part.unsigned_abs()));
        Some(Integers::progression(low, high, i64::try_from(step).ok()?))
    }

    /// Sets that contain the quotients (rounded towards zero) and the remainders (with the sign of the dividend).
    /// `None` if a divisor may be 0 or negative, or 64 bits overflow.
    pub fn divided(&self, by: &Integers) -> Option<[Integers; 2]> {
        if by.low <= 0 {
            return None;
        }
        if let (Some(quotient), Some(rest)) =
            (self.each_pair(by, |a, b| a / b), self.each_pair(by, |a, b| a % b))
        {
            return Some([quotient, rest]);
        }
        let ends = [self.low / by.low, self.low / by.high, self.high / by.low, self.high / by.high];
        let (low, high) = (ends.into_iter().min()?, ends.into_iter().max()?);
        let most = (by.high - 1).min(self.low.abs().max(self.high.abs()));
        let rest = Integers::range(
            if self.low < 0 { -most } else { 0 },
            if self.high > 0 { most } else { 0 },
        );
        let Some(divisor) = by.as_constant() else {
            return Some([Integers::range(low, high), rest]);
        };
        // If the stride is a multiple of the divisor, the quotients have a constant stride too, except across 0.
        let whole = self.step % divisor == 0 && (self.low >= 0 || self.low % divisor == 0);
        let quotient =
            Integers::progression(low, high, if whole { self.step / divisor } else { 1 });
        let unit = gcd(self.step(), divisor.unsigned_abs()) as i64;
        let least = rest.low + (self.low - rest.low).rem_euclid(unit);
        let rest =
            if least > rest.high { rest } else { Integers::progression(least, rest.high, unit) };
        let rest = if (0..divisor).contains(&self.low) && self.high < divisor {
            self.clone()
        } else {
            rest
        };
        Some([quotient, rest])
    }

    /// The numbers, each moved to the nearest end of `low..=high` if it lies outside; `None` if `low > high`.
    pub fn limited(&self, low: i64, high: i64) -> Option<Integers> {
        if low > high {
            return None;
        }
        let limited = self.some.as_ref().map(|all| all.iter().map(|one| (*one).clamp(low, high)));
        if let Some(found) = limited.and_then(Integers::of) {
            return Some(found);
        }
        if low <= self.low && self.high <= high {
            return Some(self.clone());
        }
        Some(Integers::range(self.low.clamp(low, high), self.high.clamp(low, high)))
    }
}

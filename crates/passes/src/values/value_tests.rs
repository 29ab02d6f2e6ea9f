//! Compares abstract values and integers with plain sets of numbers.

use super::integers::Integers;
use super::reach::Reach;
use super::value::{Growth, MAX_EXACT, Value};
use std::collections::BTreeSet;

/// Pseudo-random numbers: xorshift64.
pub struct Chance(pub u64);

impl Chance {
    pub fn below(&mut self, most: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 8) % most
    }

    fn word(&mut self) -> u16 {
        const ENDS: [u16; 12] =
            [0, 1, 2, 7, 8, 100, 0x7FFE, 0x7FFF, 0x8000, 0x8001, 0xFFF8, 0xFFFF];
        match self.below(3) {
            0 => ENDS[self.below(12) as usize],
            1 => self.below(40) as u16,
            _ => self.below(65_536) as u16,
        }
    }

    /// A random value, and the set of numbers that it must contain.
    fn value(&mut self) -> (Value, BTreeSet<u16>) {
        match self.below(6) {
            0 => {
                let word = self.word();
                (Value::constant(word), [word].into())
            }
            1 | 2 => {
                let count = 1 + self.below(12);
                let all: BTreeSet<u16> = (0..count).map(|_| self.word()).collect();
                let value = Value::of_values(all.iter().copied()).expect("some");
                match all.len() <= MAX_EXACT {
                    true => (value, all),
                    false => {
                        (value, (0..=u16::MAX).filter(|&one| value.contains_value(one)).collect())
                    }
                }
            }
            3 | 4 => {
                let step = [1, 1, 2, 3, 10, 16, 1000][self.below(7) as usize];
                let span = [0, 5, 60, 300, 20_000, 40_000, 65_534][self.below(7) as usize];
                let first = self.word();
                let all = (0..=span / step).map(|place| first.wrapping_add((place * step) as u16));
                (Value::progression(first, span, step), all.collect())
            }
            _ => {
                let divisor = 1u32 << self.below(17);
                let to = self.word();
                let all = (0..=u16::MAX)
                    .filter(|&one| u32::from(one) % divisor == u32::from(to) % divisor);
                (Value::congruent(to, divisor), all.collect())
            }
        }
    }

    /// A sample of a set: the first, the last, and some others.
    fn list(&mut self, all: &BTreeSet<u16>) -> Vec<u16> {
        let mut some: Vec<u16> =
            all.iter().copied().take(2).chain(all.iter().rev().copied().take(2)).collect();
        let listed: Vec<u16> = all.iter().copied().collect();
        some.extend((0..6).map(|_| listed[self.below(listed.len() as u64) as usize]));
        some
    }
}

#[test]
fn a_value_has_what_it_was_made_of_and_nothing_else() {
    let mut chance = Chance(1);
    for _ in 0..1500 {
        let (value, all) = chance.value();
        for one in (0..40).map(|_| chance.word()).chain(all.iter().copied().take(50)) {
            assert_eq!(value.contains_value(one), all.contains(&one), "{value:?} {one}");
        }
        let (low, high) = value.signed();
        let (least, largest) = value.unsigned();
        for one in chance.list(&all) {
            assert!((low..=high).contains(&i64::from(one.cast_signed())), "{value:?} {one}");
            assert!((least..=largest).contains(&i64::from(one)), "{value:?} {one}");
        }
        assert_eq!(value.as_constant().is_some(), all.len() == 1, "{value:?}");
    }
}

#[test]
fn joined_met_and_widened_values_have_what_they_should() {
    let mut chance = Chance(2);
    let limits = [-100, -1, 0, 9, 10, 11, 50, 1000, 20_000];
    let (mut closer, mut none) = (0, 0);
    for _ in 0..3000 {
        let ((a, all), (b, more)) = (chance.value(), chance.value());
        let joined = a.join(b);
        let widened = [a.widen(b, Growth::Ends), a.widen(b, Growth::To(&limits))];
        for one in chance.list(&all).into_iter().chain(chance.list(&more)) {
            assert!(joined.contains_value(one), "{a:?} {b:?} {joined:?} {one}");
            assert!(
                widened.iter().all(|wider| wider.contains_value(one)),
                "{a:?} {b:?} {widened:?} {one}"
            );
        }
        assert!(!a.contains(&b) || more.is_subset(&all), "{a:?} {b:?}");
        let both: Vec<u16> = all.intersection(&more).copied().collect();
        match a.meet(b) {
            None => {
                none += 1;
                assert!(both.is_empty(), "{a:?} {b:?}");
            }
            Some(met) => {
                assert!(both.iter().all(|&one| met.contains_value(one)), "{a:?} {b:?} {met:?}");
                assert!(a.contains(&met) || b.contains(&met), "{a:?} {b:?} {met:?}");
                closer += u32::from(met != a && met != b);
            }
        }
    }
    assert!(closer > 100 && none > 100, "{closer} {none}");
}

#[test]
fn what_grows_stops_growing() {
    let mut chance = Chance(3);
    let limits = [-100, 0, 9, 10, 11, 50, 1000, 20_000];
    for _ in 0..20 {
        for growth in [Growth::Ends, Growth::To(&limits)] {
            let (mut value, mut steps) = (chance.value().0, 0);
            for _ in 0..100 {
                let wider = value.widen(chance.value().0, growth);
                steps += u32::from(wider != value);
                value = wider;
            }
            // Widening to the ends takes few steps; widening to limits takes one step for each limit, each value of a
            // small set and each stride.
            let most = if matches!(growth, Growth::Ends) { 6 } else { 60 };
            assert!(steps <= most, "{steps} {growth:?}");
        }
    }
}

#[test]
fn words_are_worked_with_as_a_plc_does() {
    let mut chance = Chance(4);
    for _ in 0..3000 {
        let ((a, all), (b, more)) = (chance.value(), chance.value());
        let (one, other) = (chance.list(&all), chance.list(&more));
        for (&x, &y) in one.iter().flat_map(|x| other.iter().map(move |y| (x, y))) {
            for (found, value, name) in [
                (a.add(b), x.wrapping_add(y), "+"),
                (a.add(b.negated()), x.wrapping_sub(y), "-"),
                (a.and(b), x & y, "and"),
                (a.or(b, false), x | y, "or"),
                (a.or(b, true), x ^ y, "xor"),
            ] {
                assert!(
                    found.contains_value(value),
                    "{a:?} {name} {b:?} is {found:?}: {x} {y} {value}"
                );
            }
        }
    }
}

/// The words of a number, with samples of their values.
fn words(chance: &mut Chance, count: usize) -> (Vec<Value>, Vec<Vec<u16>>) {
    let parts = (0..count).map(|_| {
        let (value, all) = chance.value();
        (value, chance.list(&all))
    });
    parts.unzip()
}

/// Some numbers that consist of these words.
fn numbers(some: &[Vec<u16>], is_signed: bool) -> Vec<i64> {
    let word = |word: u16| if is_signed { i64::from(word.cast_signed()) } else { word.into() };
    match some {
        [only] => only.iter().map(|&one| word(one)).collect(),
        [lower, upper] => {
            let pairs = lower.iter().zip(upper).chain(lower.iter().rev().zip(upper));
            pairs.map(|(&lower, &upper)| word(upper) * 65_536 + i64::from(lower)).collect()
        }
        _ => unreachable!(),
    }
}

fn holds(of: &Integers, number: i64) -> bool {
    let step = of.step().max(1);
    (of.low..=of.high).contains(&number)
        && (number - of.low).unsigned_abs().is_multiple_of(step)
        && of.list().is_none_or(|some| some.contains(&number))
}

fn in_words(words: &[Value], number: i64) -> bool {
    words
        .iter()
        .enumerate()
        .all(|(place, word)| word.contains_value((number >> (16 * place)) as u16))
}

#[test]
fn integers_are_worked_with_as_integers_are() {
    let mut chance = Chance(5);
    let (mut divided, mut apart, mut empty) = (0, 0, 0);
    for round in 0..3000 {
        let (count, is_signed) = (1 + round % 2, round % 3 > 0);
        let ((a, some), (b, more)) = (words(&mut chance, count), words(&mut chance, count));
        let [x, y] = [&a, &b].map(|words| Integers::read(words, is_signed).expect("two words"));
        let (xs, ys) = (numbers(&some, is_signed), numbers(&more, is_signed));
        assert!(xs.iter().all(|&one| holds(&x, one)), "{a:?} {x:?}");
        assert!(xs.iter().all(|&one| in_words(&x.words(count), one)), "{a:?} {x:?}");
        let joined = x.join(&y);
        assert!(xs.iter().chain(&ys).all(|&one| holds(&joined, one)), "{x:?} {y:?}");
        let (low, high) = (i64::from(chance.word()) - 200, i64::from(chance.word()));
        let within = x.within(low, high);
        let limited = x.limited(low, high);
        assert_eq!(limited.is_none(), low > high);
        empty += u32::from(within.is_none());
        for &one in &xs {
            if (low..=high).contains(&one) {
                assert!(
                    within.as_ref().is_some_and(|within| holds(within, one)),
                    "{x:?} {low} {high}"
                );
            }
            if let Some(limited) = &limited {
                assert!(holds(limited, one.clamp(low, high)), "{x:?} {low} {high}");
            }
        }
        if let Some(within) = &within {
            assert!(low <= within.low && within.high <= high);
        }
        let results = x.divided(&y);
        apart += u32::from(x.is_disjoint(&y));
        divided += u32::from(results.is_some());
        for (&one, &other) in xs.iter().zip(&ys) {
            // Products of unsigned double words are not supported.
            let factor = if is_signed { y.clone() } else { Integers::constant(3) };
            let by = if is_signed { other } else { 3 };
            let found =
                [(x.add(&y), one + other), (x.multiply(&factor), one * by), (x.negated(), -one)];
            for (found, number) in found {
                let found = found.expect("no overflow");
                assert!(holds(&found, number), "{x:?} {y:?} {found:?} {number}");
                assert!(in_words(&found.words(4), number), "{x:?} {y:?} {found:?} {number}");
                assert!(!found.fits(1) || i16::try_from(number).is_ok(), "{found:?} {number}");
            }
            assert!(!(x.is_disjoint(&y) && one == other), "{x:?} {y:?}");
            if let Some([quotient, rest]) = &results {
                assert!(holds(quotient, one / other), "{x:?} / {y:?}: {quotient:?} {one} {other}");
                assert!(holds(rest, one % other), "{x:?} % {y:?}: {rest:?} {one} {other}");
            }
        }
    }
    assert!(divided > 100 && apart > 100 && empty > 100, "{divided} {apart} {empty}");
}

/// Numbers close to each other, so that strides and ends overlap. Every number of each set is tried.
#[test]
fn small_integers_are_worked_with_number_by_number() {
    let mut chance = Chance(6);
    let mut small = || {
        let (low, step) = (chance.below(60) as i64 - 30, 1 + chance.below(12) as i64);
        let count = 1 + chance.below(90) as i64;
        let all: Vec<i64> = (0..count).map(|place| low + place * step).collect();
        (Integers::progression(low, low + (count - 1) * step, step), all)
    };
    for _ in 0..600 {
        let ((x, xs), (y, ys)) = (small(), small());
        let (sum, product) = (x.add(&y).expect("small"), x.multiply(&y).expect("small"));
        let results = x.divided(&y);
        let is_apart = x.is_disjoint(&y);
        for (&one, &other) in xs.iter().flat_map(|one| ys.iter().map(move |other| (one, other))) {
            assert!(holds(&sum, one + other) && holds(&product, one * other), "{x:?} {y:?}");
            assert!(!is_apart || one != other, "{x:?} {y:?}");
            if let Some([quotient, rest]) = &results {
                assert!(holds(quotient, one / other), "{x:?} / {y:?}: {quotient:?} {one} {other}");
                assert!(holds(rest, one % other), "{x:?} % {y:?}: {rest:?} {one} {other}");
            }
        }
    }
}

#[test]
fn strides_and_few_values_stay_what_they_are() {
    let few = |all: &[u16]| Value::of_values(all.iter().copied()).expect("some");
    let digits = Value::range(0, 15);
    assert_eq!(few(&[0, 19]).join(few(&[5])).list(), Some(&[0, 5, 19][..]));
    assert_eq!(Value::TOP.and(Value::constant(12)).list(), Some(&[0, 4, 8, 12][..]));
    assert_eq!(digits.and(Value::constant(0xFF)), digits);
    let tens = Integers::signed(&[digits]).and_then(|all| all.multiply(&Integers::constant(10)));
    let [tens] = tens.expect("a product").words(1)[..] else { panic!() };
    assert_eq!((tens.signed(), tens.step()), ((0, 150), 10));
    assert_eq!(tens.add(Value::constant(3)).signed(), (3, 153));
    assert_eq!(tens.meet(Value::range(45, 75)).expect("some").list(), Some(&[50, 60, 70][..]));
    assert!(!tens.contains_value(45) && tens.meet(Value::constant(45)).is_none());
    let all = Value::TOP.add(Value::TOP);
    assert_eq!(all, Value::TOP);
    let even = Integers::signed(&[Value::TOP]).and_then(|all| all.multiply(&Integers::constant(2)));
    assert_eq!(even.expect("a product").words(1)[0], Value::congruent(0, 2));
    let limits = [9, 10, 11, 1000];
    let to = |from: Value, more: Value| from.widen(more, Growth::To(&limits)).signed();
    assert_eq!(to(Value::range(0, 20), Value::range(0, 21)), (0, 1000));
    assert_eq!(to(Value::range(0, 8), Value::range(0, 9)), (0, 9));
    assert_eq!(to(tens, tens.add(Value::constant(10))), (0, 1000));
    assert_eq!(tens.widen(tens.add(Value::constant(10)), Growth::To(&limits)).step(), 10);
    assert_eq!(Value::range(0, 20).widen(Value::range(0, 21), Growth::Ends).signed(), (0, 32_767));
}

#[test]
fn what_an_index_reaches_has_all_cells_of_both_ways() {
    let mut chance = Chance(7);
    let mut reach = || {
        let (low, step) = (chance.below(50) as i64, 1 + chance.below(9) as i64);
        let count = 1 + chance.below(40) as i64;
        let length = 1 + chance.below(6) as i64;
        let first = Integers::progression(low, low + (count - 1) * step, step);
        let cells = (0..count).flat_map(|place| (0..length).map(move |n| low + place * step + n));
        let found = Reach::of(&first, length).expect("in the area");
        (found, cells.collect::<BTreeSet<i64>>())
    };
    let has = |reach: Reach, cell: i64| {
        let mut stretches = reach.stretches().into_iter();
        stretches.any(|(low, high)| (i64::from(low)..=i64::from(high)).contains(&cell))
    };
    let mut apart = 0;
    for _ in 0..2000 {
        let ((one, cells), (other, more)) = (reach(), reach());
        apart += u32::from(one.stretches().len() > 1);
        assert!(cells.iter().all(|&cell| has(one, cell)), "{one:?}");
        let both = one.join(other);
        assert!(cells.union(&more).all(|&cell| has(both, cell)), "{one:?} {other:?} {both:?}");
        let closer = one.meet(other);
        assert!(cells.intersection(&more).all(|&cell| has(closer, cell)), "{one:?} {other:?}");
    }
    assert!(apart > 500, "{apart}");
    assert!(Reach::of(&Integers::range(-1, 4), 1).is_none());
    assert!(Reach::of(&Integers::range(0, u32::MAX.into()), 1).is_none());
    let tens = Reach::of(&Integers::progression(10, 40, 10), 3).expect("in the area");
    assert_eq!(tens.stretches(), [(10, 12), (20, 22), (30, 32), (40, 42)]);
}

/// Two ranges whose smallest common range is all numbers: where they meet, the stride changes.
#[test]
fn strides_end_where_numbers_go_round() {
    for step in [2, 3, 8, 10, 1000] {
        for first in (0..60_000).step_by(7_001) {
            let all = |first: u16| {
                let numbers =
                    (0..40_000 / step).map(move |n| first.wrapping_add((n * step) as u16));
                (Value::progression(first, 39_999, step), numbers)
            };
            let ((a, one), (b, other)) = (all(first), all(first.wrapping_add(30_000)));
            let both = [a.join(b), b.join(a)];
            for number in one.chain(other) {
                assert!(
                    both.iter().all(|joined| joined.contains_value(number)),
                    "{a:?} {b:?} {both:?}"
                );
            }
        }
    }
}

//! Executes operations on blocks, bits, bytes, reals and times. The result is `None` where no manual defines it.

use super::words::{number, words_of};
use scanbound_ir::meaning::{Arithmetic, Operation};

/// The largest number of repetitions of [`Operation::Repeat`].
const MAX_LENGTH: u16 = 0x7FFF;
/// The first year of [`Operation::Date`].
const FIRST_YEAR: u16 = 1980;
/// The number of days from 1 January 1980 to 31 December 2079; in these years each fourth one is a leap year.
const CLOCK_DAYS: u16 = 100 * 365 + 25;
/// The day of the week of 1 January 1980, a Tuesday.
const FIRST_WEEKDAY: u16 = 2;

/// The results of an operation on lists, as [`Operation`] defines them. `None` if it says that the result is unknown.
pub(super) fn run(operation: &Operation, inputs: &[Vec<u16>]) -> Option<Vec<Vec<u16>>> {
    let first = inputs.first()?;
    let signed = |at: usize| number(inputs.get(at)?, true);
    let second_word = || inputs.get(1)?.first().copied();
    let result = match *operation {
        Operation::Limit | Operation::Band => {
            let (low, high, value) = (signed(0)?, signed(1)?, signed(2)?);
            if low > high {
                return None;
            }
            let inside = value.clamp(low, high);
            let value = if *operation == Operation::Limit { inside } else { value - inside };
            fitting(value, inputs.get(2)?.len())?
        }
        Operation::Zone => {
            let (below, above, value) = (signed(0)?, signed(1)?, signed(2)?);
            if below > above {
                return None;
            }
            let bias = match value {
                ..0 => below,
                0 => 0,
                1.. => above,
            };
            fitting(value + bias, inputs.get(2)?.len())?
        }
        Operation::Resize(words) => fitting(signed(0)?, usize::from(words))?,
        Operation::Repeat => {
            let times = second_word().filter(|times| (1..=MAX_LENGTH).contains(times))?;
            first.repeat(usize::from(times))
        }
        Operation::Total(words) => {
            let sum = numbers(first, words)?.iter().sum();
            fitting(sum, 2 * usize::from(words))?
        }
        Operation::Mean(words) => {
            let numbers = numbers(first, words)?;
            let (sum, count) = (numbers.iter().sum::<i128>(), numbers.len() as i128);
            if count == 0 || sum % count != 0 {
                return None;
            }
            fitting(sum / count, usize::from(words))?
        }
        Operation::Extreme { words, greatest } => {
            let numbers = numbers(first, words)?;
            let best = *if greatest { numbers.iter().max() } else { numbers.iter().min() }?;
            let mut result = words_of(best, usize::from(words));
            result.extend(places(&numbers, best)?);
            result
        }
        Operation::Find { halving: true } => return None,
        Operation::Find { halving: false } => {
            let words = u8::try_from(first.len()).ok()?;
            places(&numbers(inputs.get(1)?, words)?, signed(0)?)?
        }
        Operation::CompareEach { relation, signed, words } => {
            let numbers = |at: usize| -> Option<Vec<i128>> {
                let words = inputs.get(at)?.chunks_exact(usize::from(words));
                words.map(|one| number(one, signed)).collect()
            };
            let pairs = numbers(0)?.into_iter().zip(numbers(1)?);
            let holds: Vec<u16> = pairs.map(|(a, b)| u16::from(relation.holds(a, b))).collect();
            let all = holds.iter().all(|&one| one == 1);
            return Some(vec![holds, vec![u16::from(all)]]);
        }
        Operation::Split(bits) => {
            let groups = 16 / usize::from(bits);
            let group = |n: usize| {
                let word = first.get(n / groups)?;
                Some(word >> (usize::from(bits) * (n % groups)) & mask(bits))
            };
            (0..usize::from(second_word()?)).map(group).collect::<Option<_>>()?
        }
        Operation::Combine(bits) => {
            let joined = |words: &[u16]| {
                words.iter().rev().fold(0, |word, part| word << bits | (part & mask(bits)))
            };
            first.chunks(16 / usize::from(bits)).map(joined).collect()
        }
        Operation::ToDecimalText => {
            let value = signed(0)?;
            let sign = if value < 0 { '-' } else { ' ' };
            let text = format!("{sign}{:>5}", value.unsigned_abs());
            let pair = |two: &[u8]| u16::from_le_bytes([two[0], two[1]]);
            text.as_bytes().chunks_exact(2).map(pair).chain([0]).collect()
        }
        Operation::PickBit => {
            let place = usize::from(second_word()?) % (16 * first.len());
            vec![first[place / 16] >> (place % 16) & 1]
        }
        Operation::PutBit(value) => {
            let place = usize::from(second_word()?) % (16 * first.len());
            let mut words = first.clone();
            let bit = 1 << (place % 16);
            words[place / 16] =
                if value { words[place / 16] | bit } else { words[place / 16] & !bit };
            words
        }
        Operation::ToReal => {
            let value = signed(0)?;
            let real = value as f32;
            (real as i128 == value).then(|| bits(real))?
        }
        Operation::FromReal(words) => {
            let value = real(first)?;
            (value.fract() == 0.0).then_some(())?;
            fitting(value as i128, usize::from(words))?
        }
        Operation::Real(arithmetic) => {
            bits(exactly(arithmetic, real(first)?, real(inputs.get(1)?)?)?)
        }
        Operation::ToSeconds => {
            let &[hours, minutes, seconds] = &first[..] else { return None };
            let is_time = hours < 24 && minutes < 60 && seconds < 60;
            let sum = (i128::from(hours) * 60 + i128::from(minutes)) * 60 + i128::from(seconds);
            is_time.then(|| words_of(sum, 2))?
        }
        Operation::FromSeconds => {
            let all = signed(0).filter(|all| (0..86_400).contains(all))?;
            vec![(all / 3600) as u16, (all / 60 % 60) as u16, (all % 60) as u16]
        }
        Operation::Date => {
            let &[day, minute, second] = &first[..] else { return None };
            let [year, month, date, weekday] = day_of_clock(day);
            let minute = minute % (24 * 60);
            vec![year, month, date, minute / 60, minute % 60, second % 60, weekday]
        }
        Operation::Elapsed => {
            let (before, setting) = (signed(1)?, signed(2)?);
            if first.first()? & 1 == 1 || setting < 1 || !(0..setting).contains(&before) {
                return None;
            }
            words_of(signed(3)?.clamp(before, setting - 1), 1)
        }
        Operation::Counted => {
            let was_on = first.first()? & 1 == 1;
            let was_through = second_word()? & 1 == 1;
            let (before, setting) = (signed(2)?, signed(3)?);
            if setting < 1 || !(0..=setting).contains(&before) || was_through != (before == setting)
            {
                return None;
            }
            words_of(before + i128::from(!was_on && !was_through), 1)
        }
        _ => return None,
    };
    Some(vec![result])
}

/// A signed number in this many words. `None` if it does not fit.
fn fitting(value: i128, words: usize) -> Option<Vec<u16>> {
    let result = words_of(value, words);
    (number(&result, true)? == value).then_some(result)
}

/// The signed numbers that a list holds, each of this many words. `None` if a number has too many words.
fn numbers(list: &[u16], words: u8) -> Option<Vec<i128>> {
    list.chunks(usize::from(words)).map(|words| number(words, true)).collect()
}

/// The position of the first occurrence of a number, counted from 1, and the number of its occurrences. Both are 0 if
/// it does not occur. `None` if one of them does not fit into a word.
fn places(numbers: &[i128], wanted: i128) -> Option<Vec<u16>> {
    let first = numbers.iter().position(|&number| number == wanted).map_or(0, |at| at + 1);
    let count = numbers.iter().filter(|&&number| number == wanted).count();
    Some(vec![u16::try_from(first).ok()?, u16::try_from(count).ok()?])
}

fn mask(bits: u8) -> u16 {
    (1 << bits) - 1
}

/// The single-precision number in two words, if it is normal or +0.
fn real(words: &[u16]) -> Option<f32> {
    let &[low, high] = words else { return None };
    normal_or_zero(f32::from_bits(u32::from(low) | u32::from(high) << 16))
}

fn normal_or_zero(value: f32) -> Option<f32> {
    (value.is_normal() || value.to_bits() == 0).then_some(value)
}

fn bits(value: f32) -> Vec<u16> {
    words_of(i128::from(value.to_bits()), 2)
}

/// The result if it is exact, so that the rounding mode of the PLC does not matter. `None` if it must be rounded, or is
/// neither normal nor +0.
fn exactly(arithmetic: Arithmetic, a: f32, b: f32) -> Option<f32> {
    let (x, y) = (f64::from(a), f64::from(b));
    let result = match arithmetic {
        Arithmetic::Add => a + b,
        Arithmetic::Sub => a - b,
        Arithmetic::Multiply => a * b,
        Arithmetic::Divide => a / b,
    };
    let result = normal_or_zero(result)?;
    let wide = f64::from(result);
    // The product of two singles fits into a double. A sum is exact if subtracting either number gives the other.
    let is_exact = match arithmetic {
        Arithmetic::Multiply => x * y == wide,
        Arithmetic::Divide => b != 0.0 && wide * y == x,
        Arithmetic::Add => is_sum(x, y, wide),
        Arithmetic::Sub => is_sum(x, -y, wide),
    };
    is_exact.then_some(result)
}

/// Whether `sum` is exactly the sum of two singles: the double sum is equal, and it lost nothing by rounding.
fn is_sum(x: f64, y: f64, sum: f64) -> bool {
    let wide = x + y;
    let (big, small) = if x.abs() >= y.abs() { (x, y) } else { (y, x) };
    // The rounding error of the double sum is itself a double.
    wide == sum && small - (wide - big) == 0.0
}

/// Year, month, day and day of the week of the day with this number, modulo the number of days of the clock.
fn day_of_clock(number: u16) -> [u16; 4] {
    let number = number % CLOCK_DAYS;
    let (mut year, mut month, mut rest) = (FIRST_YEAR, 1, number);
    loop {
        let days = match month {
            2 if year % 4 == 0 => 29,
            2 => 28,
            4 | 6 | 9 | 11 => 30,
            _ => 31,
        };
        if rest < days {
            return [year, month, rest + 1, (number % 7 + FIRST_WEEKDAY) % 7];
        }
        rest -= days;
        (year, month) = if month == 12 { (year + 1, 1) } else { (year, month + 1) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_ir::Relation;

    fn one(operation: Operation, inputs: &[&[u16]]) -> Option<Vec<u16>> {
        let inputs: Vec<Vec<u16>> = inputs.iter().map(|input| input.to_vec()).collect();
        run(&operation, &inputs).map(|results| results.concat())
    }

    #[test]
    fn limits_and_zones_end_where_numbers_do() {
        let minus = |value: i16| value.cast_unsigned();
        assert_eq!(one(Operation::Limit, &[&[3], &[9], &[minus(-4)]]), Some(vec![3]));
        assert_eq!(one(Operation::Limit, &[&[9], &[3], &[5]]), None);
        assert_eq!(one(Operation::Band, &[&[3], &[9], &[12]]), Some(vec![3]));
        assert_eq!(one(Operation::Band, &[&[minus(-9)], &[minus(-3)], &[0x7FFF]]), None);
        assert_eq!(
            one(Operation::Zone, &[&[minus(-3)], &[9], &[minus(-4)]]),
            Some(vec![minus(-7)])
        );
        assert_eq!(one(Operation::Zone, &[&[0], &[1], &[0x7FFF]]), None);
        assert_eq!(one(Operation::Zone, &[&[5], &[minus(-5)], &[1]]), None);
        assert_eq!(one(Operation::Zone, &[&[5], &[5], &[1]]), Some(vec![6]));
        assert_eq!(one(Operation::Resize(1), &[&[0, 1]]), None);
        assert_eq!(one(Operation::Resize(2), &[&[0x8000]]), Some(vec![0x8000, 0xFFFF]));
    }

    #[test]
    fn lists_are_summed_searched_split_and_joined() {
        assert_eq!(one(Operation::Total(1), &[&[0x8000, 0x8000]]), Some(vec![0, 0xFFFF]));
        assert_eq!(one(Operation::Mean(1), &[&[3, 4]]), None);
        let most = Operation::Extreme { words: 1, greatest: true };
        assert_eq!(one(most, &[&[3, 0xFFFF, 7, 7]]), Some(vec![7, 3, 2]));
        assert_eq!(one(Operation::Find { halving: false }, &[&[7], &[3, 7, 7]]), Some(vec![2, 2]));
        assert_eq!(
            one(Operation::Find { halving: false }, &[&[7, 0], &[3, 7, 7, 0]]),
            Some(vec![2, 1])
        );
        assert_eq!(one(Operation::Split(4), &[&[0x4321], &[3]]), Some(vec![1, 2, 3]));
        assert_eq!(one(Operation::Split(8), &[&[0x4321], &[3]]), None);
        assert_eq!(one(Operation::Combine(8), &[&[0x21, 0x143, 5]]), Some(vec![0x4321, 5]));
        assert_eq!(one(Operation::Repeat, &[&[5, 6], &[2]]), Some(vec![5, 6, 5, 6]));
        assert_eq!(one(Operation::Repeat, &[&[5], &[0]]), None);
        let text = |number: i16| one(Operation::ToDecimalText, &[&[number.cast_unsigned()]]);
        assert_eq!(text(325), Some(vec![0x2020, 0x3320, 0x3532, 0]));
        assert_eq!(text(-32768), Some(vec![0x332D, 0x3732, 0x3836, 0]));
        assert_eq!(one(Operation::PickBit, &[&[0, 4], &[18]]), Some(vec![1]));
        assert_eq!(one(Operation::PutBit(false), &[&[7], &[17]]), Some(vec![5]));
    }

    #[test]
    fn blocks_are_compared_pair_by_pair() {
        let run = |relation, signed, words, inputs: &[&[u16]]| {
            let inputs: Vec<Vec<u16>> = inputs.iter().map(|input| input.to_vec()).collect();
            run(&Operation::CompareEach { relation, signed, words }, &inputs)
        };
        let (less, equal) = (Relation::Less, Relation::Equal);
        let (minus, plus) = (&[0xFFFF, 2][..], &[1, 2][..]);
        assert_eq!(run(less, true, 1, &[minus, plus]), Some(vec![vec![1, 0], vec![0]]));
        assert_eq!(run(less, false, 1, &[minus, plus]), Some(vec![vec![0, 0], vec![0]]));
        assert_eq!(run(less, false, 2, &[plus, &[0, 3]]), Some(vec![vec![1], vec![1]]));
        assert_eq!(run(equal, true, 1, &[plus, plus]), Some(vec![vec![1, 1], vec![1]]));
    }

    #[test]
    fn reals_are_known_where_they_are_exact() {
        let of = |value: f32| bits(value);
        let real = |arithmetic, a: f32, b: f32| one(Operation::Real(arithmetic), &[&of(a), &of(b)]);
        assert_eq!(real(Arithmetic::Add, 1.5, 2.25), Some(of(3.75)));
        assert_eq!(real(Arithmetic::Add, 0.1, 0.2), None);
        assert_eq!(real(Arithmetic::Add, 1e30, 1.0), None);
        assert_eq!(real(Arithmetic::Sub, 1.0, 1e-30), None);
        assert_eq!(real(Arithmetic::Sub, 3.0, 3.0), Some(of(0.0)));
        assert_eq!(real(Arithmetic::Multiply, 0.1, 0.1), None);
        assert_eq!(real(Arithmetic::Multiply, -0.5, 6.0), Some(of(-3.0)));
        assert_eq!(real(Arithmetic::Multiply, 1e30, 1e30), None);
        assert_eq!(real(Arithmetic::Multiply, -1.0, 0.0), None);
        assert_eq!(real(Arithmetic::Divide, 1.0, 3.0), None);
        assert_eq!(real(Arithmetic::Divide, 1.0, 0.0), None);
        assert_eq!(real(Arithmetic::Divide, 7.0, 4.0), Some(of(1.75)));
        assert_eq!(one(Operation::ToReal, &[&[1, 0x100]]), None);
        assert_eq!(one(Operation::FromReal(1), &[&of(-32768.0)]), Some(vec![0x8000]));
        assert_eq!(one(Operation::FromReal(1), &[&of(32768.0)]), None);
        assert_eq!(one(Operation::FromReal(2), &[&of(0.5)]), None);
    }

    #[test]
    fn times_of_day_end_at_midnight() {
        assert_eq!(one(Operation::ToSeconds, &[&[23, 59, 59]]), Some(vec![0x517F, 1]));
        assert_eq!(one(Operation::ToSeconds, &[&[24, 0, 0]]), None);
        assert_eq!(one(Operation::FromSeconds, &[&[0x517F, 1]]), Some(vec![23, 59, 59]));
        assert_eq!(one(Operation::FromSeconds, &[&[0x5180, 1]]), None);
    }

    #[test]
    fn every_number_chooses_a_day_that_exists() {
        let date = |day, minute, second| one(Operation::Date, &[&[day, minute, second]]);
        assert_eq!(date(0, 0, 0), Some(vec![1980, 1, 1, 0, 0, 0, 2]));
        assert_eq!(date(59, 1439, 59), Some(vec![1980, 2, 29, 23, 59, 59, 5]));
        assert_eq!(date(16861, 60, 61), Some(vec![2026, 3, 1, 1, 0, 1, 0]));
        assert_eq!(date(36524, 1440, 0), Some(vec![2079, 12, 31, 0, 0, 0, 0]));
        assert_eq!(date(36525, 0, 0), date(0, 0, 0));
    }
}

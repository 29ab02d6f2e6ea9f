//! Executes operations on lists of words. The result is `None` where no manual defines it.

use super::lists;
use super::words::{bcd, number, words_of};
use scanbound_ir::meaning::{Operation, Unary};

/// The results of the operation on these inputs, as [`Operation`] defines them. `None` if it says that the result is
/// unknown.
pub fn run(operation: &Operation, inputs: &[Vec<u16>]) -> Option<Vec<Vec<u16>>> {
    match operation {
        Operation::Copy => Some(inputs.to_vec()),
        Operation::Each(unary) => each(*unary, inputs.first()?).map(|result| vec![result]),
        Operation::Rotate { left, through } => rotate(*left, *through, inputs),
        Operation::Shift { left, signed } => shift(*left, *signed, inputs),
        Operation::CountBits(words) => {
            let ones: u32 = inputs.first()?.iter().map(|word| word.count_ones()).sum();
            Some(vec![words_of(i128::from(ones), usize::from(*words))])
        }
        Operation::Decode => {
            let bits = u32::from(*inputs.get(1)?.first()?);
            if !(1..=8).contains(&bits) {
                return None;
            }
            let count = 1usize << bits;
            let set = usize::from(*inputs.first()?.first()?) & (count - 1);
            Some(vec![(0..count).map(|bit| u16::from(bit == set)).collect()])
        }
        Operation::Encode => {
            let highest = inputs.first()?.iter().rposition(|&bit| bit & 1 == 1)?;
            Some(vec![vec![u16::try_from(highest).ok()?]])
        }
        Operation::Multiply { signed } => {
            let (a, b) = (inputs.first()?, inputs.get(1)?);
            let product = number(a, *signed)?.checked_mul(number(b, *signed)?)?;
            Some(vec![words_of(product, a.len() + b.len())])
        }
        Operation::Divide { signed } => {
            let (a, b) = (inputs.first()?, inputs.get(1)?);
            let (dividend, divisor) = (number(a, *signed)?, number(b, *signed)?);
            let quotient = dividend.checked_div(divisor)?;
            let result = words_of(quotient, a.len());
            let fits = number(&result, *signed)? == quotient;
            fits.then(|| vec![result, words_of(dividend % divisor, b.len())])
        }
        Operation::Sum { subtract } => {
            let count = inputs.first()?.len();
            let sum = sum(*subtract, inputs, &|words| number(words, false))?;
            let out = u16::from(!(0..1i128 << (16 * count)).contains(&sum));
            Some(vec![words_of(sum, count), vec![out]])
        }
        Operation::Carry { subtract } => {
            let results = run(&Operation::Sum { subtract: *subtract }, inputs)?;
            Some(vec![results.get(1)?.clone()])
        }
        Operation::DecimalSum { subtract } => {
            let count = inputs.first()?.len();
            let all = 10i128.checked_pow(u32::try_from(4 * count).ok()?)?;
            let sum = sum(*subtract, inputs, &bcd)?;
            let out = u16::from(!(0..all).contains(&sum));
            Some(vec![digits(sum.rem_euclid(all), count), vec![out]])
        }
        Operation::DecimalMultiply => {
            let (a, b) = (inputs.first()?, inputs.get(1)?);
            Some(vec![digits(bcd(a)?.checked_mul(bcd(b)?)?, a.len() + b.len())])
        }
        Operation::DecimalDivide => {
            let (a, b) = (inputs.first()?, inputs.get(1)?);
            let (dividend, divisor) = (bcd(a)?, bcd(b)?);
            let quotient = dividend.checked_div(divisor)?;
            Some(vec![[digits(quotient, a.len()), digits(dividend % divisor, b.len())].concat()])
        }
        Operation::DivideJoined { signed } => {
            Some(vec![run(&Operation::Divide { signed: *signed }, inputs)?.concat()])
        }
        Operation::WithFlags { operation, words } => {
            let mut results = run(operation, inputs)?;
            let judged = results.first()?.get(..usize::from(*words))?;
            let is_zero = judged.iter().all(|&word| word == 0);
            let highest = judged.last()? >> 15;
            results.extend([vec![u16::from(is_zero)], vec![highest]]);
            Some(results)
        }
        Operation::EachWord(unary) => {
            let words = inputs.first()?.iter().map(|&word| each(*unary, &[word]));
            Some(vec![words.collect::<Option<Vec<_>>>()?.concat()])
        }
        _ => lists::run(operation, inputs),
    }
}

/// Adds or subtracts the first two inputs and the carry bit in the third (0 if missing). `read` converts words to a
/// number, and gives `None` if they are not valid.
fn sum(subtract: bool, inputs: &[Vec<u16>], read: &dyn Fn(&[u16]) -> Option<i128>) -> Option<i128> {
    let (a, b) = (read(inputs.first()?)?, read(inputs.get(1)?)?);
    let carry = inputs.get(2).and_then(|carry| carry.first()).map_or(0, |carry| carry & 1);
    let second = b + i128::from(carry);
    Some(if subtract { a - second } else { a + second })
}

/// The lowest decimal digits of a number as BCD: this many words of four digits, low word first.
fn digits(value: i128, words: usize) -> Vec<u16> {
    let digit = |n: usize| (value / 10i128.pow(n as u32) % 10) as u16;
    (0..words).map(|w| (0..4).fold(0, |word, n| word | digit(4 * w + n) << (4 * n))).collect()
}

fn each(unary: Unary, words: &[u16]) -> Option<Vec<u16>> {
    let count = words.len();
    match unary {
        Unary::ToBcd => {
            let value = number(words, true)?;
            let most = 10i128.checked_pow(u32::try_from(4 * count).ok()?)? - 1;
            if !(0..=most).contains(&value) {
                return None;
            }
            let digit = |n: usize| (value / 10i128.pow(n as u32) % 10) as u16;
            let word = |w: usize| (0..4).fold(0, |word, n| word | digit(4 * w + n) << (4 * n));
            Some((0..count).map(word).collect())
        }
        Unary::FromBcd => Some(words_of(bcd(words)?, count)),
        Unary::SwapBytes => Some(words.iter().map(|word| word.swap_bytes()).collect()),
        Unary::Reverse => Some(words.iter().rev().map(|word| word.reverse_bits()).collect()),
        Unary::Negate => Some(words_of(-number(words, false)?, count)),
        Unary::ToGray | Unary::FromGray if words.last()? >> 15 == 1 => None,
        Unary::ToGray => {
            let value = number(words, false)?;
            Some(words_of(value ^ (value >> 1), count))
        }
        Unary::FromGray => {
            let value = number(words, false)?;
            Some(words_of((0..16 * count).fold(0, |sum, bit| sum ^ (value >> bit)), count))
        }
    }
}

/// The bits of the words, least significant first.
fn bits_of(words: &[u16]) -> Vec<bool> {
    words.iter().flat_map(|word| (0..16).map(move |bit| word >> bit & 1 == 1)).collect()
}

fn words_of_bits(bits: &[bool]) -> Vec<u16> {
    let word = |bits: &[bool]| bits.iter().rev().fold(0, |word, &bit| word << 1 | u16::from(bit));
    bits.chunks(16).map(word).collect()
}

fn rotate(left: bool, through: bool, inputs: &[Vec<u16>]) -> Option<Vec<Vec<u16>>> {
    let mut bits = bits_of(inputs.first()?);
    let places = usize::from(*inputs.get(1)?.first()?);
    let carry = inputs.get(2).and_then(|carry| carry.first()).map(|carry| carry & 1 == 1);
    if places > bits.len() {
        return None;
    }
    let count = bits.len();
    let mut carry = if through { Some(carry?) } else { carry };
    if through {
        bits.extend(carry);
    }
    if left {
        bits.rotate_right(places)
    } else {
        bits.rotate_left(places)
    }
    if through {
        carry = bits.pop();
    } else if places > 0 {
        // The last bit rotated out is at the end at which it came in.
        carry = Some(if left { bits[0] } else { bits[count - 1] });
    }
    Some(vec![words_of_bits(&bits), carry.map(u16::from).into_iter().collect()])
}

fn shift(left: bool, signed: bool, inputs: &[Vec<u16>]) -> Option<Vec<Vec<u16>>> {
    let bits = bits_of(inputs.first()?);
    let places = usize::from(*inputs.get(1)?.first()?);
    let count = bits.len();
    if places > count {
        return None;
    }
    let filled = signed && !left && bits.last().copied()?;
    let at = |bit: usize| match left {
        true => bit >= places && bits[bit - places],
        false => bits.get(bit + places).copied().unwrap_or(filled),
    };
    let moved: Vec<bool> = (0..count).map(at).collect();
    let out = match places {
        0 => inputs.get(2).and_then(|old| old.first()).map(|old| old & 1 == 1),
        _ => Some(if left { bits[count - places] } else { bits[places - 1] }),
    };
    Some(vec![words_of_bits(&moved), out.map(u16::from).into_iter().collect()])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(operation: Operation, inputs: &[&[u16]]) -> Option<Vec<Vec<u16>>> {
        let inputs: Vec<Vec<u16>> = inputs.iter().map(|input| input.to_vec()).collect();
        run(&operation, &inputs)
    }

    #[test]
    fn bits_go_round_and_the_last_is_the_carry() {
        let left = Operation::Rotate { left: true, through: false };
        assert_eq!(one(left.clone(), &[&[0x8001], &[1], &[0]]), Some(vec![vec![3], vec![1]]));
        assert_eq!(one(left.clone(), &[&[0x8001], &[0], &[1]]), Some(vec![vec![0x8001], vec![1]]));
        assert_eq!(one(left.clone(), &[&[5, 0], &[17], &[0]]), Some(vec![vec![0, 10], vec![0]]));
        assert_eq!(one(left, &[&[1], &[17], &[0]]), None);
        let right = Operation::Rotate { left: false, through: true };
        assert_eq!(one(right.clone(), &[&[1], &[1], &[0]]), Some(vec![vec![0], vec![1]]));
        assert_eq!(one(right, &[&[0], &[1], &[1]]), Some(vec![vec![0x8000], vec![0]]));
    }

    #[test]
    fn shifts_fill_with_zeros_or_the_sign() {
        let right = |signed| Operation::Shift { left: false, signed };
        assert_eq!(one(right(false), &[&[0x8003], &[1]]), Some(vec![vec![0x4001], vec![1]]));
        assert_eq!(one(right(true), &[&[0x8003], &[2]]), Some(vec![vec![0xE000], vec![1]]));
        assert_eq!(one(right(false), &[&[0x8000], &[16]]), Some(vec![vec![0], vec![1]]));
    }

    #[test]
    fn a_judged_result_tells_of_zero_and_the_highest_bit() {
        let divide = Operation::DivideJoined { signed: false };
        let judged = |words| Operation::WithFlags { operation: Box::new(divide.clone()), words };
        assert_eq!(one(judged(1), &[&[3], &[4]]), Some(vec![vec![0, 3], vec![1], vec![0]]));
        assert_eq!(one(judged(2), &[&[3], &[4]]), Some(vec![vec![0, 3], vec![0], vec![0]]));
        assert_eq!(
            one(judged(1), &[&[0x8000], &[1]]),
            Some(vec![vec![0x8000, 0], vec![0], vec![1]])
        );
        assert_eq!(one(judged(1), &[&[3], &[0]]), None);
    }

    #[test]
    fn decimal_digits_and_their_limits() {
        let to = Operation::Each(Unary::ToBcd);
        assert_eq!(one(to.clone(), &[&[9876]]), Some(vec![vec![0x9876]]));
        assert_eq!(one(to.clone(), &[&[10_000]]), None);
        assert_eq!(one(to, &[&[0xFFFF]]), None);
        assert_eq!(one(Operation::Each(Unary::FromBcd), &[&[0x1234]]), Some(vec![vec![1234]]));
        assert_eq!(one(Operation::Each(Unary::FromBcd), &[&[0x00A0]]), None);
    }

    #[test]
    fn division_goes_towards_zero_and_never_beyond_its_words() {
        let divide = Operation::Divide { signed: true };
        let minus = |value: i16| value.cast_unsigned();
        assert_eq!(
            one(divide.clone(), &[&[minus(-7)], &[2]]),
            Some(vec![vec![minus(-3)], vec![minus(-1)]])
        );
        assert_eq!(one(divide.clone(), &[&[7], &[0]]), None);
        assert_eq!(one(divide, &[&[0x8000], &[0xFFFF]]), None);
        let multiply = Operation::Multiply { signed: true };
        assert_eq!(one(multiply, &[&[minus(-2)], &[3]]), Some(vec![vec![minus(-6), 0xFFFF]]));
    }

    #[test]
    fn bits_are_counted_found_and_set() {
        assert_eq!(one(Operation::CountBits(2), &[&[0xF, 1]]), Some(vec![vec![5, 0]]));
        assert_eq!(one(Operation::Decode, &[&[6], &[2]]), Some(vec![vec![0, 0, 1, 0]]));
        assert_eq!(one(Operation::Encode, &[&[0, 1, 1, 0]]), Some(vec![vec![2]]));
        assert_eq!(one(Operation::Encode, &[&[0, 0]]), None);
    }
}

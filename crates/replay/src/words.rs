//! Numbers stored in words, least significant word first.

/// The number in at most four words. `None` if there are more.
pub fn number(words: &[u16], signed: bool) -> Option<i128> {
    if words.len() > 4 {
        return None;
    }
    let value = words.iter().rev().fold(0i128, |value, &word| value << 16 | i128::from(word));
    let negative = signed && words.last()? >> 15 == 1;
    Some(if negative { value - (1i128 << (16 * words.len())) } else { value })
}

/// The lowest `count` words of a number.
pub fn words_of(value: i128, count: usize) -> Vec<u16> {
    (0..count).map(|n| (value >> (16 * n)) as u16).collect()
}

/// The number in BCD words. `None` if a digit is above 9.
pub fn bcd(words: &[u16]) -> Option<i128> {
    let digits =
        words.iter().rev().flat_map(|word| (0..4).rev().map(move |n| word >> (4 * n) & 15));
    digits.into_iter().try_fold(0i128, |value, digit| {
        let digit = (digit <= 9).then_some(i128::from(digit))?;
        value.checked_mul(10)?.checked_add(digit)
    })
}

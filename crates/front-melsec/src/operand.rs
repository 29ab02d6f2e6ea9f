//! Parses one MELSEC operand: constants, devices with bit, digit, index and indirect forms, module access, strings.

use std::borrow::Cow;

use super::memory::{DeviceType, FUNCTION_WORDS, Family, Name, is_digit, name_of};
use scanbound_ir::{Cell, Radix};

/// The help text of a diagnostic about an invalid operand.
pub const HOW_TO_WRITE: &str =
    "write it as in the vendor's tool, such as X1F, D100, D100.A, K4M0, D0Z1, K10, H0FF";

/// A parsed operand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Operand {
    /// `K` or `H`: an integer constant, from -2^31 to 2^32 - 1.
    Constant(i64),
    /// `E`: a real constant in the range of single precision, as the bits of an IEEE 754 single.
    Real(u32),
    /// `E`: a real constant that exceeds the range of single precision. Its value is not kept.
    Double,
    /// `U3`: a module, by the upper digits of its start I/O number (in hexadecimal, possibly with an index register).
    /// The number is not kept.
    Module,
    /// A string, without its quotation marks.
    Text(String),
    /// A pointer (label), such as `P50`: its number.
    Pointer(u32),
    /// An interrupt pointer, such as `I0`: its number.
    Interrupt(u32),
    /// A nesting level of a master control region, from `N0` to `N14`.
    Nesting(u32),
    /// A device, an indexed constant, or memory outside the program.
    Device(Device),
}

/// An operand that names a device. Indexed constants (`K10Z1`), indirect access (`@D0`) and operands with a backslash
/// (`U0\G5`, `J1\W5`, `BL0\S5`) are devices here, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Device {
    /// The device's letters (`D`, `ZR`); for an indexed constant `K` or `H`; for a step of an SFC block [`SFC_BLOCK`];
    /// empty for indirect access and for other operands with a backslash.
    pub name: &'static str,
    /// Which device it is: bit, word, digit designation or other form, with its number where this is known.
    pub place: Place,
    /// The index register that is added to the device number. `None` without an index, and for operands whose index is
    /// not kept: indexed constants, indirect access, operands with a backslash, and an index after a bit number
    /// (`D0.AZ1`).
    pub index: Option<Index>,
    /// Which further forms the operand uses: an index, a digit designation, a bit number, a backslash.
    pub modifiers: Modifiers,
    /// For indirect access, the words that hold the address. `None` for other operands, and where the text after the
    /// `@` is not a device with a number or index.
    pub address: Option<AddressWords>,
}

/// The forms that an operand uses besides a plain device. Any number of them may be true.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Modifiers {
    /// Whether the operand has a backslash (or yen sign): module access (`U0\G5`), link access (`J1\W5`) or a step of
    /// an SFC block (`BL0\S5`).
    pub module: bool,
    /// Whether the operand has an index register in any part, or is an indirect access.
    pub indexed: bool,
    /// Whether the operand has a digit designation (`K4M0`).
    pub digits: bool,
    /// Whether the operand selects a bit of a word by its number (`D0.3`, `U0\G5.3`).
    pub word_bit: bool,
}

impl Modifiers {
    /// The modifiers that at least one of `self` and `other` has.
    #[must_use]
    pub fn or(self, other: Modifiers) -> Modifiers {
        Modifiers {
            module: self.module || other.module,
            indexed: self.indexed || other.indexed,
            digits: self.digits || other.digits,
            word_bit: self.word_bit || other.word_bit,
        }
    }
}

/// The two consecutive words that hold the address for an indirect access (`D0` and `D1` for `@D0`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AddressWords {
    /// The device type of the words that hold the address.
    pub kind: DeviceType,
    /// The number of the first word; `None` if an index is added to it.
    pub first: Option<u32>,
}

/// An index register of an operand, and the device number to which its value is added: `D100Z1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Index {
    /// The device number as written (100); for a digit designation that of its first bit, for `FD` that of its first
    /// word.
    pub number: u32,
    /// The number of the bit, from 0 to 15, if the operand is a bit of a word. `None` otherwise.
    pub bit: Option<u8>,
    /// The letters of the index register: `Z`, `ZZ`, `LZ` or `V`.
    pub letters: &'static str,
    /// The number of the index register; 0 if the operand gives none.
    pub register: u32,
}

/// Which device an operand means, as far as its text says. Numbers count devices; those of `FD` count words,
/// [`FUNCTION_WORDS`] for each register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// One whole device (`D100`, `M5`, `T0`), by its type and number.
    At(DeviceType, u32),
    /// A bit of a word device: the word's number, and the bit from 0 to 15.
    BitOf(DeviceType, u32, u8),
    /// A digit designation (`K4M0`): the number of the first bit, and the number of digits (1 to 8) of four bits.
    Digits(DeviceType, u32, u8),
    /// An indexed device of this type, whose number is not known here (`D100Z1`); also an indexed constant, as a
    /// volatile word. `true`: a bit of an indexed word (`D0Z1.A`).
    Indexed(DeviceType, bool),
    /// A digit designation with an index (`K4M0Z1`): the type of its bits, and the number of digits.
    IndexedDigits(DeviceType, u8),
    /// Indirect access (`@D0`): a device of any type and number.
    Indirect,
    /// An operand with a backslash: memory of a module (`U0\G5`), a link device of a network (`J1\W5`), or a step of an
    /// SFC block (`BL0\S5`). `true`: a bit of it; `false`: a word or a digit designation.
    Foreign(bool),
    /// A relay that is always on (`true`: `SM400`, `M8000`) or always off (`false`: `SM401`, `M8001`).
    Fixed(bool),
    /// A relay that tells the first scan. `true`: on in the first scan only (`SM402`, `M8002`); `false`: on in all
    /// scans but the first (`SM403`, `M8003`).
    FirstScan(bool),
}

impl DeviceType {
    /// The cell of the device with this number; for a timer or counter, that of its contact. `None` for a device that
    /// changes without the program, because it has no cell.
    #[must_use]
    pub fn cell(self, index: u32) -> Option<Cell> {
        match self {
            DeviceType::Bit(area) | DeviceType::Word(area) => Some(Cell { area, index }),
            DeviceType::Timed(timed) => Some(Cell { area: timed.contact, index }),
            DeviceType::VolatileBit | DeviceType::VolatileWord => None,
        }
    }
}

/// Parses the text of one operand. Letters may be in upper or lower case; blanks around the operand are ignored, except
/// around a string.
///
/// # Errors
///
/// What is wrong with the operand, as the text of a message (without a full stop).
pub fn parse(text: &str, family: Family) -> Result<Operand, String> {
    if let Some(inner) = text.strip_prefix('"') {
        let inner = inner.strip_suffix('"').ok_or("the string has no closing quotation mark")?;
        return Ok(Operand::Text(inner.to_owned()));
    }
    let upper = upper(text.trim());
    if upper.is_empty() {
        return Err("the operand is empty".to_owned());
    }
    if let Some(inner) = upper.strip_prefix('@') {
        return indirect(inner, family).map(Operand::Device);
    }
    if upper.contains(['\\', '¥']) {
        return foreign(&upper, family);
    }
    let mut letters = upper.chars();
    let (letter, rest) = (letters.next().unwrap_or_default(), letters.as_str());
    let numeric = |rest: &str| !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit());
    match letter {
        'K' if is_indexed_constant(rest, Radix::Decimal, family) => Ok(indexed_constant("K")),
        'H' if is_indexed_constant(rest, Radix::Hexadecimal, family) => Ok(indexed_constant("H")),
        'K' => {
            let mut letters = rest.chars();
            if let (Some(digits @ '1'..='8'), Some('A'..='Z')) = (letters.next(), letters.next()) {
                return self::digits(&rest[1..], digits as u8 - b'0', family);
            }
            let value: i64 =
                rest.parse().map_err(|_| format!("`{text}` is not a decimal constant"))?;
            constant(value, text)
        }
        'H' => {
            let value = u64::from_str_radix(rest, 16)
                .map_err(|_| format!("`{text}` is not a hexadecimal constant"))?;
            match i64::try_from(value) {
                Ok(value) if value <= 0xFFFF_FFFF => Ok(Operand::Constant(value)),
                _ => Err(format!("the constant `{text}` does not fit in 32 bits")),
            }
        }
        'E' if rest.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
            real(rest, text)
        }
        'U' if is_module(rest) => Ok(Operand::Module),
        'P' if numeric(rest) => number(rest, Radix::Decimal, text).map(Operand::Pointer),
        'I' if numeric(rest) => number(rest, Radix::Decimal, text).map(Operand::Interrupt),
        'N' if numeric(rest) => match number(rest, Radix::Decimal, text)? {
            level @ 0..=14 => Ok(Operand::Nesting(level)),
            _ => Err(format!("`{text}`: nesting levels are N0 to N14")),
        },
        _ => device(&upper, family).map(Operand::Device),
    }
}

/// The text in upper case.
pub(super) fn upper(text: &str) -> Cow<'_, str> {
    if text.bytes().any(|b| b.is_ascii_lowercase()) {
        Cow::Owned(text.to_ascii_uppercase())
    } else {
        Cow::Borrowed(text)
    }
}

fn constant(value: i64, text: &str) -> Result<Operand, String> {
    if (-0x8000_0000..=0xFFFF_FFFF).contains(&value) {
        Ok(Operand::Constant(value))
    } else {
        Err(format!("the constant `{text}` does not fit in 32 bits"))
    }
}

/// Parses a real constant: `E1.5`, or `E1.5+3` and `E1.5E+3` with a power of ten.
fn real(rest: &str, text: &str) -> Result<Operand, String> {
    let mut number = rest.to_owned();
    if !rest.contains('E')
        && let Some(sign) = rest.rfind(['+', '-']).filter(|&at| at > 0)
    {
        number.insert(sign, 'E');
    }
    let is_plain = number.bytes().all(|b| b.is_ascii_digit() || b"+-.E".contains(&b));
    match number.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(Operand::Real(value.to_bits())),
        // It exceeds the range of a single.
        Ok(_) if is_plain => Ok(Operand::Double),
        _ => Err(format!("`{text}` is not a real constant")),
    }
}

/// Whether the text after `U` is a module number of one to three hexadecimal digits, possibly with an index register.
fn is_module(rest: &str) -> bool {
    let (head, index) = rest.split_once('Z').unwrap_or((rest, "0"));
    (1..=3).contains(&head.len())
        && head.bytes().all(|b| b.is_ascii_hexdigit())
        && !index.is_empty()
        && index.bytes().all(|b| b.is_ascii_digit())
}

fn number(digits: &str, radix: Radix, text: &str) -> Result<u32, String> {
    let (base, what) = match radix {
        Radix::Decimal => (10, "decimal"),
        Radix::Hexadecimal => (16, "hexadecimal"),
        Radix::Octal => (8, "octal"),
    };
    match u32::from_str_radix(digits, base) {
        // No CPU has device numbers above this; it also keeps cell indices far from overflow.
        Ok(value) if value < 0x4000_0000 => Ok(value),
        Ok(_) => Err(format!("`{text}`: the device number is higher than on any CPU")),
        Err(_) if digits.is_empty() => Err(format!("`{text}` has no device number")),
        Err(_) => Err(format!("`{text}`: `{digits}` is not a {what} number")),
    }
}

/// Splits the text of a device (in upper case) into its name, its number, and the rest (`.A`, `Z3`).
fn split(text: &str, family: Family) -> Result<(&'static Name, u32, &str), String> {
    let (name, radix) = name_of(text, family).ok_or_else(|| unknown(text))?;
    let rest = &text[name.letters.len()..];
    let end = rest.bytes().position(|b| !is_digit(b, radix)).unwrap_or(rest.len());
    Ok((name, number(&rest[..end], radix, text)?, &rest[end..]))
}

fn unknown(text: &str) -> String {
    format!("`{text}` is not a device of this CPU family")
}

fn device(text: &str, family: Family) -> Result<Device, String> {
    let (name, index, suffix) = split(text, family)?;
    let kind = name.kind(index, family).ok_or_else(|| unknown(text))?;
    let name = name.letters;
    let index = match name {
        "FD" if index < 0x1_0000 => index * FUNCTION_WORDS,
        "FD" => return Err(unknown(text)),
        _ => index,
    };
    // Whether an index after the bit is added to the word number is not documented.
    let is_behind_bit = suffix.starts_with('.');
    let (bit, suffix) = bit_and_index(text, suffix)?;
    let suffix = &*suffix;
    let modifiers =
        Modifiers { indexed: !suffix.is_empty(), word_bit: bit.is_some(), ..Modifiers::default() };
    let place = match (suffix.is_empty() || is_index(suffix, family), suffix.is_empty(), bit) {
        (false, ..) => {
            return Err(format!("`{text}`: `{suffix}` is not a valid bit, digit or index"));
        }
        (_, false, bit) => Place::Indexed(kind, bit.is_some()),
        (_, true, Some(bit)) => Place::BitOf(kind, index, bit),
        (_, true, None) => match (name, index, family) {
            ("SM", 400, _) | ("M", 8000, Family::Fx) => Place::Fixed(true),
            ("SM", 401, _) | ("M", 8001, Family::Fx) => Place::Fixed(false),
            ("SM", 402, _) | ("M", 8002, Family::Fx) => Place::FirstScan(true),
            ("SM", 403, _) | ("M", 8003, Family::Fx) => Place::FirstScan(false),
            ("SM", 8000, Family::Fx5) => Place::Fixed(true),
            ("SM", 8001, Family::Fx5) => Place::Fixed(false),
            _ => Place::At(kind, index),
        },
    };
    if bit.is_some() && !matches!(kind, DeviceType::Word(_) | DeviceType::VolatileWord) {
        return Err(format!("`{text}`: only a word device has bits .0 to .F"));
    }
    let index = index_of(suffix).filter(|_| !is_behind_bit).map(|(letters, register)| Index {
        number: index,
        bit,
        letters,
        register,
    });
    Ok(Device { name, place, index, modifiers, address: None })
}

/// Parses an indirect access; `text` is the part after the `@`, which must be a device.
fn indirect(text: &str, family: Family) -> Result<Device, String> {
    let address = device(text, family)?;
    let words = match address.place {
        Place::At(kind, first) | Place::BitOf(kind, first, _) => {
            Some(AddressWords { kind, first: Some(first) })
        }
        Place::Indexed(kind, _) => Some(AddressWords { kind, first: None }),
        _ => None,
    };
    let modifiers = Modifiers { indexed: true, ..address.modifiers };
    Ok(Device { name: "", place: Place::Indirect, index: None, modifiers, address: words })
}

/// The operand for a constant with an index register; `name` is `K` or `H`. It is a word that may have any value at
/// each read.
fn indexed_constant(name: &'static str) -> Operand {
    let place = Place::Indexed(DeviceType::VolatileWord, false);
    let modifiers = Modifiers { indexed: true, ..Modifiers::default() };
    Operand::Device(Device { name, place, index: None, modifiers, address: None })
}

/// Whether the text after `K` or `H` is a constant with an index register, as in `K10Z1`.
fn is_indexed_constant(text: &str, radix: Radix, family: Family) -> bool {
    let text = text.strip_prefix('-').unwrap_or(text);
    let end = text.bytes().position(|byte| !is_digit(byte, radix));
    end.is_some_and(|end| end > 0 && is_index(&text[end..], family))
}

/// The index register with which a suffix begins: its letters, and its number (0 if missing). `None` if it begins with
/// none.
fn index_of(suffix: &str) -> Option<(&'static str, u32)> {
    let letters = ["LZ", "ZZ", "Z", "V"].into_iter().find(|name| suffix.starts_with(name))?;
    let digits = &suffix[letters.len()..];
    if digits.is_empty() { Some((letters, 0)) } else { Some((letters, digits.parse().ok()?)) }
}

/// Whether the suffix is an index register: `Z3`, `ZZ0` or `LZ0` on all families, on the FX and FX5 also `V3` and
/// letters without a number.
fn is_index(suffix: &str, family: Family) -> bool {
    let digits = suffix
        .strip_prefix("LZ")
        .or_else(|| suffix.strip_prefix("ZZ"))
        .or_else(|| suffix.strip_prefix('Z'))
        .or_else(|| suffix.strip_prefix('V').filter(|_| family.octal_inputs()));
    digits.is_some_and(|digits| {
        (!digits.is_empty() || family.octal_inputs())
            && digits.len() <= 2
            && digits.bytes().all(|b| b.is_ascii_digit())
    })
}

fn digits(text: &str, count: u8, family: Family) -> Result<Operand, String> {
    let (name, index, suffix) = split(text, family)?;
    let kind = name.kind(index, family).ok_or_else(|| unknown(text))?;
    if matches!(kind, DeviceType::Word(_) | DeviceType::VolatileWord) {
        return Err(format!("`K{count}{text}`: a digit designation needs a bit device"));
    }
    let place = match suffix {
        "" => Place::Digits(kind, index, count),
        suffix if is_index(suffix, family) => Place::IndexedDigits(kind, count),
        _ => return Err(format!("`K{count}{text}`: `{suffix}` is not a valid index")),
    };
    let index = index_of(suffix).map(|(letters, register)| Index {
        number: index,
        bit: None,
        letters,
        register,
    });
    let modifiers = Modifiers { digits: true, indexed: !suffix.is_empty(), ..Modifiers::default() };
    let name = name.letters;
    Ok(Operand::Device(Device { name, place, index, modifiers, address: None }))
}

/// The name, in [`Device::name`], of a step of an SFC block (`BL0\S5`).
pub const SFC_BLOCK: &str = "BL";

/// Parses an operand with a backslash or yen sign (in upper case): module access `U0\G74` or `U3E0\HG0`, link access
/// `J1\W10`, or a step of an SFC block `BL0\S5`. Each part may have an index and a digit designation; the device may
/// have a bit number.
fn foreign(text: &str, family: Family) -> Result<Operand, String> {
    let wrong = || {
        format!(
            "`{text}` is not an access to a module or network: write module access as U0\\G100, link access as J1\\W10"
        )
    };
    let (unit, rest) = text.split_once(['\\', '¥']).ok_or_else(wrong)?;
    let (unit_digits, unit) = without_digits(unit);
    let (rest_digits, rest) = without_digits(rest);
    let digits = unit_digits || rest_digits;
    // The device, whether it is a bit, and the radix of its number.
    let (head, (number, is_bit, radix)) = match unit.as_bytes() {
        [b'U', ..] => {
            let number = rest.trim_start_matches('H').strip_prefix('G').ok_or_else(wrong)?;
            (&unit[1..], (number, false, Radix::Decimal))
        }
        [b'J', ..] => {
            let names = ["SB", "SW", "B", "W", "X", "Y"];
            let name = names.into_iter().find(|name| rest.starts_with(name)).ok_or_else(wrong)?;
            (&unit[1..], (&rest[name.len()..], !name.ends_with('W'), Radix::Hexadecimal))
        }
        // A step of an SFC block.
        [b'B', b'L', ..] => {
            let number = rest.strip_prefix('S').ok_or_else(wrong)?;
            (&unit[2..], (number, true, Radix::Decimal))
        }
        _ => return Err(wrong()),
    };
    let is_numbered = |text: &str| text.starts_with(|c: char| c.is_ascii_hexdigit());
    if !is_numbered(head) || !is_numbered(number) {
        return Err(wrong());
    }
    let behind = |text: &'_ str, radix| {
        text.bytes().position(|byte| !is_digit(byte, radix)).unwrap_or(text.len())
    };
    let unit_index = &head[behind(head, Radix::Hexadecimal)..];
    let (bit, index) = bit_and_index(text, &number[behind(number, radix)..])?;
    for index in [unit_index, &index] {
        if !index.is_empty() && !is_index(index, family) {
            return Err(format!("`{text}`: `{index}` is not a valid index"));
        }
    }
    let modifiers = Modifiers {
        module: true,
        indexed: !unit_index.is_empty() || !index.is_empty(),
        digits,
        word_bit: bit.is_some(),
    };
    let place = Place::Foreign((is_bit && !digits) || bit.is_some());
    let name = if unit.starts_with(SFC_BLOCK) { SFC_BLOCK } else { "" };
    Ok(Operand::Device(Device { name, place, index: None, modifiers, address: None }))
}

/// Whether a part of an operand begins with a digit designation such as `K4`, and the text after the designation.
fn without_digits(part: &str) -> (bool, &str) {
    match part.as_bytes() {
        [b'K', b'1'..=b'8', ..] => (true, &part[2..]),
        _ => (false, part),
    }
}

/// The bit number (`None` without one) and the index text (empty without one) after a device number; either may come
/// first (`D0.AZ1`, `D0Z1.A`).
fn bit_and_index<'s>(text: &str, suffix: &'s str) -> Result<(Option<u8>, Cow<'s, str>), String> {
    let Some((before, rest)) = suffix.split_once('.') else {
        return Ok((None, Cow::Borrowed(suffix)));
    };
    let digit = rest.chars().next().filter(char::is_ascii).and_then(|c| c.to_digit(16));
    let digit = digit.ok_or_else(|| format!("`{text}`: the bits of a word are .0 to .F"))?;
    Ok((Some(digit as u8), Cow::Owned(format!("{before}{}", &rest[1..]))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::area;

    fn place(text: &str, family: Family) -> Place {
        match parse(text, family) {
            Ok(Operand::Device(device)) => device.place,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn every_form_that_occurs_is_understood() {
        let q = |text| place(text, Family::Q);
        let (bit, word) = (|name| DeviceType::Bit(area(name)), |name| DeviceType::Word(area(name)));
        assert_eq!(q("X0C21"), Place::At(bit("X"), 0xC21));
        assert_eq!(q("XA0"), Place::At(bit("X"), 0xA0));
        assert_eq!(q("d100"), Place::At(word("D"), 100));
        assert_eq!(q("D281.A"), Place::BitOf(word("D"), 281, 10));
        assert_eq!(q("W9A0.0"), Place::BitOf(word("W"), 0x9A0, 0));
        assert_eq!(q("R12.3"), Place::BitOf(word("ZR"), 12, 3));
        assert_eq!(q("K8M7120"), Place::Digits(bit("M"), 7120, 8));
        assert_eq!(q("K2X0CA0"), Place::Digits(bit("X"), 0xCA0, 2));
        assert_eq!(q("K4L20000"), Place::Digits(bit("L"), 20_000, 4));
        assert_eq!(q("ZR42050Z11"), Place::Indexed(word("ZR"), false));
        assert_eq!(q("M1024Z4"), Place::Indexed(bit("M"), false));
        assert_eq!(q("D0Z1.A"), Place::Indexed(word("D"), true));
        assert_eq!(q("D0.AZ1"), Place::Indexed(word("D"), true));
        assert_eq!(q("K8Y1AA0Z1"), Place::IndexedDigits(bit("Y"), 8));
        assert_eq!(q("V0Z3"), Place::Indexed(bit("V"), false));
        assert_eq!(q("@D504"), Place::Indirect);
        assert_eq!(q("K100Z1"), Place::Indexed(DeviceType::VolatileWord, false));
        assert_eq!(q("H1FZ10"), Place::Indexed(DeviceType::VolatileWord, false));
        for (text, is_bit) in [
            ("U0Z0\\G74", false),
            ("U6\\G20480", false),
            ("U3E0\\G10000.3", true),
            ("J1\\B0", true),
            ("BL0\\S5", true),
        ] {
            assert_eq!(q(text), Place::Foreign(is_bit), "{text}");
        }
        assert!(matches!(q("ST110"), Place::At(DeviceType::Timed(timed), 110) if timed.retentive));
        assert!(matches!(q("T5"), Place::At(DeviceType::Timed(timed), 5) if !timed.retentive));
        assert_eq!(q("Z3"), Place::At(word("Z"), 3));
        assert_eq!(q("ZR5"), Place::At(word("ZR"), 5));
        assert_eq!(q("S5"), Place::At(bit("S"), 5));
        assert_eq!(q("SM400"), Place::Fixed(true));
        assert_eq!(place("M8000", Family::Fx), Place::Fixed(true));
        assert_eq!(place("V3", Family::Fx), Place::At(word("V index "), 3));
        assert_eq!(place("D0V2", Family::Fx), Place::Indexed(word("D"), false));
        assert_eq!(place("X017", Family::Fx), Place::At(bit("X"), 0o17));
    }

    #[test]
    fn constants_and_names_are_understood() {
        let q = |text| parse(text, Family::Q);
        assert_eq!(q("K-1"), Ok(Operand::Constant(-1)));
        assert_eq!(q("H0C"), Ok(Operand::Constant(12)));
        assert_eq!(q("E80"), Ok(Operand::Real(80f32.to_bits())));
        assert_eq!(q("E-1.5"), Ok(Operand::Real((-1.5f32).to_bits())));
        assert_eq!(q("E1.5+3"), Ok(Operand::Real(1500f32.to_bits())));
        assert_eq!(q("\"text\""), Ok(Operand::Text("text".to_owned())));
        assert_eq!(q("P50"), Ok(Operand::Pointer(50)));
        assert_eq!(q("I0"), Ok(Operand::Interrupt(0)));
        assert_eq!(q("N14"), Ok(Operand::Nesting(14)));
    }

    #[test]
    fn what_is_no_operand_is_refused() {
        for text in [
            "",
            "K",
            "KX",
            "H",
            "HXY",
            "K99999999999",
            "N15",
            "D",
            "D-1",
            "Q5",
            "M1.5",
            "D5.",
            "D5.é",
            "D0Q",
            "U\\G",
            "\"open",
            "日本",
        ] {
            assert!(parse(text, Family::Q).is_err(), "{text}");
        }
        assert!(parse("X8", Family::Fx).is_err());
        assert!(parse("D99999999999", Family::Q).is_err());
    }
}

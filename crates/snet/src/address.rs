//! Addresses of bits in the memory of the C200H, and which of them a program may write.

use std::fmt;
use std::str::FromStr;

/// An area of relays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Area {
    /// Inputs, outputs, internal and special relays (IR, SR); written without letters.
    Internal,
    /// Holding relays (HR), which keep their state at power-off.
    Holding,
    /// Auxiliary relays (AR), which the CPU itself writes.
    Auxiliary,
    /// Link relays (LR).
    Link,
}

impl Area {
    const ALL: [Area; 4] = [Area::Internal, Area::Holding, Area::Auxiliary, Area::Link];

    /// The letters of the area in an address.
    #[must_use]
    pub const fn letters(self) -> &'static str {
        match self {
            Area::Internal => "",
            Area::Holding => "HR",
            Area::Auxiliary => "AR",
            Area::Link => "LR",
        }
    }

    /// The last word of the area.
    const fn last_word(self) -> u16 {
        match self {
            Area::Internal => 255,
            Area::Holding => 99,
            Area::Auxiliary => 27,
            Area::Link => 63,
        }
    }

    const fn digits(self) -> usize {
        match self {
            Area::Internal => 5,
            _ => 4,
        }
    }
}

/// The first word after those of input and output points.
const POINTS: u16 = 30;

/// The first word of the special relays.
const SPECIAL: u16 = 236;

/// The number of timers and counters, which share one set of numbers.
pub const TIMERS: u16 = 512;

/// A bit of the C200H's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// The area.
    pub area: Area,
    /// The word in it.
    pub word: u16,
    /// The bit of the word.
    pub bit: u8,
}

impl Address {
    /// A bit of the internal relays.
    #[must_use]
    pub const fn internal(word: u16, bit: u8) -> Address {
        Address { area: Area::Internal, word, bit }
    }

    /// Whether a program may write it with OUT: it is not a special relay or one that the CPU writes.
    #[must_use]
    pub fn is_writable(self) -> bool {
        match self.area {
            Area::Internal => self.word < SPECIAL,
            Area::Holding | Area::Link => true,
            Area::Auxiliary => false,
        }
    }

    /// Whether its word can belong to input or output points (words 000 to 029).
    #[must_use]
    pub fn is_point(self) -> bool {
        self.area == Area::Internal && self.word < POINTS
    }

    /// Whether it keeps its state at power-off.
    #[must_use]
    pub fn is_held(self) -> bool {
        self.area == Area::Holding
    }

    /// The next bit, if the area has one.
    #[must_use]
    pub fn next(self) -> Option<Address> {
        if self.bit < 15 {
            return Some(Address { bit: self.bit + 1, ..self });
        }
        (self.word < self.area.last_word()).then(|| Address { word: self.word + 1, bit: 0, ..self })
    }
}

impl fmt::Display for Address {
    /// Writes it in the usual notation: `00305`, `HR0107`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.area.digits() - 2;
        write!(f, "{}{:0width$}{:02}", self.area.letters(), self.word, self.bit)
    }
}

impl FromStr for Address {
    type Err = String;

    /// Parses `00305`, `HR0107` or `hr107`; the error says what is wrong.
    fn from_str(text: &str) -> Result<Address, String> {
        let upper = text.to_ascii_uppercase();
        let at = upper.find(|c: char| c.is_ascii_digit()).unwrap_or(upper.len());
        let (letters, digits) = upper.split_at(at);
        let letters = if letters == "IR" || letters == "SR" { "" } else { letters };
        let Some(area) = Area::ALL.into_iter().find(|area| area.letters() == letters) else {
            return Err(format!(
                "the C200H has no area `{letters}`; use IR and SR (written without letters), HR, AR or LR"
            ));
        };
        let count = digits.len();
        if !digits.bytes().all(|b| b.is_ascii_digit()) || !(3..=area.digits()).contains(&count) {
            return Err(format!(
                "write a relay of this area with {} digits, word and bit: {}",
                area.digits(),
                Address { area, word: 3, bit: 5 }
            ));
        }
        let (word, bit) = digits.split_at(count - 2);
        let (word, bit): (u16, u8) =
            (word.parse().unwrap_or(u16::MAX), bit.parse().unwrap_or(u8::MAX));
        if bit > 15 {
            return Err(format!("a word has bits 00 to 15, not {bit:02}"));
        }
        if word > area.last_word() {
            let last = Address { area, word: area.last_word(), bit: 15 };
            return Err(format!("this area of the C200H ends at {last}"));
        }
        Ok(Address { area, word, bit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_and_written() {
        for text in ["00305", "23515", "25315", "HR0107", "AR2715", "LR0000"] {
            assert_eq!(text.parse::<Address>().map(|one| one.to_string()).as_deref(), Ok(text));
        }
        assert_eq!("hr107".parse::<Address>().unwrap().to_string(), "HR0107");
        assert_eq!("305".parse::<Address>().unwrap().to_string(), "00305");
    }

    #[test]
    fn what_the_cpu_lacks_is_refused() {
        for text in ["00316", "25600", "HR10000", "AR2800", "LR6400", "DM0000", "X0", "", "0x305"] {
            assert!(text.parse::<Address>().is_err(), "{text}");
        }
    }

    #[test]
    fn special_and_auxiliary_relays_are_not_written() {
        let is_writable = |text: &str| text.parse::<Address>().unwrap().is_writable();
        assert!(is_writable("00300") && is_writable("HR0000") && is_writable("23515"));
        assert!(!is_writable("25315") && !is_writable("AR0000") && !is_writable("23600"));
    }

    #[test]
    fn bits_follow_each_other() {
        let next = |text: &str| text.parse::<Address>().unwrap().next().map(|a| a.to_string());
        assert_eq!(next("00315").as_deref(), Some("00400"));
        assert_eq!(next("HR9915"), None);
    }
}

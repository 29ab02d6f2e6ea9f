//! Addresses of single bits in the C200H's memory, and which of them a program may write.

use std::fmt;
use std::str::FromStr;

/// An area of relays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Area {
    /// Inputs, outputs and internal relays, with the special relays behind them: written without letters.
    Internal,
    /// Holding relays: they keep their state without power.
    Holding,
    /// Auxiliary relays, which the CPU itself writes.
    Auxiliary,
    /// Link relays.
    Link,
}

impl Area {
    const ALL: [Area; 4] = [Area::Internal, Area::Holding, Area::Auxiliary, Area::Link];

    /// The letters in front of an address.
    #[must_use]
    pub const fn letters(self) -> &'static str {
        match self {
            Area::Internal => "",
            Area::Holding => "HR",
            Area::Auxiliary => "AR",
            Area::Link => "LR",
        }
    }

    /// The last word that the area has.
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

/// The words of input and output points end before this one.
const POINTS: u16 = 30;

/// The words from which on internal relays are special ones.
const SPECIAL: u16 = 236;

/// Timers and counters have numbers below this, one set for both.
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

    /// Whether a program may write it by OUT: neither a special relay nor one that the CPU writes.
    #[must_use]
    pub fn is_writable(self) -> bool {
        match self.area {
            Area::Internal => self.word < SPECIAL,
            Area::Holding | Area::Link => true,
            Area::Auxiliary => false,
        }
    }

    /// Whether it lies in a word that may serve input or output points: words 000 to 029.
    #[must_use]
    pub fn is_point(self) -> bool {
        self.area == Area::Internal && self.word < POINTS
    }

    /// Whether it keeps its state without power.
    #[must_use]
    pub fn is_held(self) -> bool {
        self.area == Area::Holding
    }

    /// The bit behind this one, if its area has one.
    #[must_use]
    pub fn next(self) -> Option<Address> {
        if self.bit < 15 {
            return Some(Address { bit: self.bit + 1, ..self });
        }
        (self.word < self.area.last_word()).then(|| Address { word: self.word + 1, bit: 0, ..self })
    }
}

impl fmt::Display for Address {
    /// As it is written: `00305`, `HR0107`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.area.digits() - 2;
        write!(f, "{}{:0width$}{:02}", self.area.letters(), self.word, self.bit)
    }
}

impl FromStr for Address {
    type Err = String;

    /// Reads `00305`, `HR0107` or `hr107`; the error says what is wrong with it.
    fn from_str(text: &str) -> Result<Address, String> {
        let upper = text.to_ascii_uppercase();
        let at = upper.find(|c: char| c.is_ascii_digit()).unwrap_or(upper.len());
        let (letters, digits) = upper.split_at(at);
        let letters = if letters == "IR" || letters == "SR" { "" } else { letters };
        let Some(area) = Area::ALL.into_iter().find(|area| area.letters() == letters) else {
            return Err(format!(
                "the C200H has no relays `{letters}`; there are IR and SR (written without letters), HR, AR and LR"
            ));
        };
        let count = digits.len();
        if !digits.bytes().all(|b| b.is_ascii_digit()) || !(3..=area.digits()).contains(&count) {
            return Err(format!(
                "a relay of this area is written with {} digits, word and bit: {}",
                area.digits(),
                Address { area, word: 3, bit: 5 }
            ));
        }
        let (word, bit) = digits.split_at(count - 2);
        let (word, bit): (u16, u8) =
            (word.parse().unwrap_or(u16::MAX), bit.parse().unwrap_or(u8::MAX));
        if bit > 15 {
            return Err(format!("a word has the bits 00 to 15, and this names {bit:02}"));
        }
        if word > area.last_word() {
            let last = Address { area, word: area.last_word(), bit: 15 };
            return Err(format!("the C200H's area ends at {last}"));
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

//! Devices by their names and by their codes in frames: an area and a number.

use std::fmt;

/// Whether an area's devices are bits or words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AreaKind {
    /// Bits.
    Bit,
    /// Words.
    Word,
}

/// An area of a PLC's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Area {
    /// Its name.
    pub name: &'static str,
    /// Its code in frames.
    pub code: u8,
    /// Whether it holds bits or words.
    pub kind: AreaKind,
    /// Whether its devices are numbered in hexadecimal.
    pub hexadecimal: bool,
}

/// A device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Device {
    /// Its area.
    pub area: &'static Area,
    /// Its number.
    pub index: u32,
    /// If it is a bit of a word: the number of the bit.
    pub bit: Option<u8>,
}

impl Device {
    /// The device with this name in these areas. `None` if no area has this name, or if no number follows.
    #[must_use]
    pub fn named(name: &str, areas: &'static [Area]) -> Option<Device> {
        let name = name.trim().to_ascii_uppercase();
        // The area with the longest matching name: SD100 is in SD, not in S.
        let fits = areas.iter().filter(|area| name.starts_with(area.name));
        let mut fits: Vec<&'static Area> = fits.collect();
        fits.sort_by_key(|area| std::cmp::Reverse(area.name.len()));
        fits.into_iter().find_map(|area| {
            let rest = name[area.name.len()..].trim();
            let (number, bit) = match rest.split_once('.') {
                Some((number, bit)) if area.kind == AreaKind::Word => {
                    let radix = if area.hexadecimal || bit.len() == 1 { 16 } else { 10 };
                    let bit = u8::from_str_radix(bit, radix).ok().filter(|bit| *bit < 16)?;
                    (number, Some(bit))
                }
                Some(_) => return None,
                None => (rest, None),
            };
            let radix = if area.hexadecimal { 16 } else { 10 };
            let digits = !number.is_empty() && number.chars().all(|c| c.is_digit(radix));
            let index = digits.then(|| u32::from_str_radix(number, radix).ok()).flatten()?;
            Some(Device { area, index, bit })
        })
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.area.hexadecimal {
            true => write!(f, "{}{:X}", self.area.name, self.index)?,
            false => write!(f, "{}{}", self.area.name, self.index)?,
        }
        match self.bit {
            Some(bit) => write!(f, ".{bit:X}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{fins, slmp};

    #[test]
    fn names_are_read_by_the_longest_area() {
        let device = |name| Device::named(name, slmp::AREAS).map(|one| (one.area.name, one.index));
        assert_eq!(device("SD520"), Some(("SD", 520)));
        assert_eq!(device("x1f"), Some(("X", 0x1F)));
        assert_eq!(device("ZR100"), Some(("ZR", 100)));
        assert_eq!(device("D"), None);
        assert_eq!(device("Q1"), None);
        assert_eq!(device("M1.2"), None);
        assert_eq!(Device::named("D100.a", slmp::AREAS).and_then(|one| one.bit), Some(10));
        let device = |name| Device::named(name, fins::AREAS).map(|one| one.to_string());
        assert_eq!(device("A264").as_deref(), Some("A264"));
        assert_eq!(device("W3.05").as_deref(), Some("W3.5"));
        assert_eq!(device("W3.16"), None);
    }
}

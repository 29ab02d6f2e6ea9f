//! Charges for copying, comparing and initialising whole variables, by their number of elements.

use super::Assembler;
use super::types::{Extent, Kind};
use scanbound_ir::{TimingKey, Units};

/// The time of a text function covers this many characters.
const TEXT_HELD: u64 = 80;

impl Assembler {
    /// Charges the size of a moved value that the time of the function does not cover.
    pub(crate) fn charge_whole(&mut self, extent: Extent) {
        match extent {
            Extent::One => {}
            Extent::Elements(count) => self.charge("COPY", "block", count),
            Extent::Characters(count) => self.charge_beyond(count),
        }
    }

    /// Charges the comparison of two whole values by their elements; of two texts, by the shorter one.
    pub(crate) fn charge_comparison(&mut self, one: Extent, two: Extent) {
        match (one, two) {
            (Extent::Elements(one), Extent::Elements(two)) => {
                self.charge("COMPARE", "block", one.max(two))
            }
            (Extent::Elements(count), _) | (_, Extent::Elements(count)) => {
                self.charge("COMPARE", "block", count);
            }
            (Extent::Characters(one), Extent::Characters(two)) => {
                self.charge_beyond(one.min(two));
            }
            (Extent::Characters(count), _) | (_, Extent::Characters(count)) => {
                self.charge_beyond(count);
            }
            (Extent::One, Extent::One) => {}
        }
    }

    /// Charges the characters beyond those that the time of a text function covers.
    fn charge_beyond(&mut self, characters: u64) {
        if characters > TEXT_HELD {
            self.charge("COPY_TEXT", "string", characters - TEXT_HELD);
        }
    }

    /// Charges a conversion to or from REAL, LREAL and dates as the corresponding conversion function. Other
    /// conversions take no time.
    pub(crate) fn charge_conversion(&mut self, from: Kind, to: Kind) {
        if from != to && (is_real(from) || is_real(to)) {
            let name = format!("{}_TO_{}", name_of(from), name_of(to));
            self.cost(&[&name, "CONVERT"], "conversion");
        }
    }

    /// Charges the conversion of a value of unknown type, if the target is REAL, LREAL or a date.
    pub(crate) fn charge_any_conversion(&mut self, to: Kind) {
        if is_real(to) {
            self.cost(&[&format!("ANY_TO_{}", name_of(to)), "CONVERT"], "conversion");
        }
    }

    fn charge(&mut self, name: &str, class: &'static str, units: u64) {
        let key = counted(name, class, units);
        self.builder.add(Some(key), Vec::new(), scanbound_ir::Step::Nothing);
    }
}

pub(crate) fn counted(name: &str, class: &'static str, units: u64) -> TimingKey {
    TimingKey { units: Units::Exactly(units), ..Assembler::key(&[name], class) }
}

fn is_real(kind: Kind) -> bool {
    matches!(kind, Kind::Real | Kind::Opaque(_))
}

fn name_of(kind: Kind) -> &'static str {
    match kind {
        Kind::Whole { bits: ..=8, signed: true } => "SINT",
        Kind::Whole { bits: ..=8, signed: false } => "USINT",
        Kind::Whole { bits: ..=16, signed: true } => "INT",
        Kind::Whole { bits: ..=16, signed: false } => "UINT",
        Kind::Whole { bits: ..=32, signed: true } => "DINT",
        Kind::Whole { bits: ..=32, signed: false } => "UDINT",
        Kind::Whole { signed: true, .. } => "LINT",
        Kind::Whole { signed: false, .. } => "ULINT",
        Kind::Real => "REAL",
        Kind::Time => "TIME",
        Kind::Opaque(_) => "LREAL",
    }
}

/// The number of characters of a text constant, with its terminator: of bytes, as controllers with UTF-8 count.
pub(crate) fn characters(text: &str) -> u64 {
    u64::try_from(text.len()).unwrap_or(u64::MAX).saturating_add(1)
}

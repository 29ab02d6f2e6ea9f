//! The standard's function blocks and their pins.

use crate::elementary::Elementary;
use scanbound_iec::same;

/// A standard function block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "their names are the standard's")]
pub enum StandardBlock {
    Ton,
    Tof,
    Tp,
    Ctu,
    Ctd,
    Ctud,
    RTrig,
    FTrig,
    Sr,
    Rs,
}

/// A memory cell of a standard block's instance: an input, an output or internal state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "their names are the standard's")]
pub enum Pin {
    In,
    Pt,
    Q,
    Et,
    Cu,
    Cd,
    R,
    Ld,
    Pv,
    Qu,
    Qd,
    Cv,
    Clk,
    S1,
    S,
    R1,
    Q1,
    /// Internal state: the value of the edge-sensitive input in the previous call.
    Was,
    /// Internal state of `CTUD`: the value of `CD` in the previous call.
    WasDown,
}

impl Pin {
    /// The name in the standard; for internal state, a made-up name in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        [
            "IN", "PT", "Q", "ET", "CU", "CD", "R", "LD", "PV", "QU", "QD", "CV", "CLK", "S1", "S",
            "R1", "Q1", "was", "was_down",
        ][self as usize]
    }

    /// The type of its value.
    #[must_use]
    pub fn of(self) -> Elementary {
        match self {
            Pin::Pt | Pin::Et => Elementary::Time,
            Pin::Pv | Pin::Cv => Elementary::Int,
            _ => Elementary::Bool,
        }
    }
}

impl StandardBlock {
    /// All blocks with their names, in the order of the enum.
    const ALL: [(StandardBlock, &'static str); 10] = [
        (StandardBlock::Ton, "TON"),
        (StandardBlock::Tof, "TOF"),
        (StandardBlock::Tp, "TP"),
        (StandardBlock::Ctu, "CTU"),
        (StandardBlock::Ctd, "CTD"),
        (StandardBlock::Ctud, "CTUD"),
        (StandardBlock::RTrig, "R_TRIG"),
        (StandardBlock::FTrig, "F_TRIG"),
        (StandardBlock::Sr, "SR"),
        (StandardBlock::Rs, "RS"),
    ];

    /// The name in the standard, which is also the row name in timing tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        StandardBlock::ALL[self as usize].1
    }

    /// The block of this name, ignoring case; `None` if there is none.
    #[must_use]
    pub fn named(name: &str) -> Option<StandardBlock> {
        StandardBlock::ALL.iter().find(|(_, own)| same(own, name)).map(|(one, _)| *one)
    }

    /// The inputs, in the order of positional arguments.
    #[must_use]
    pub fn inputs(self) -> &'static [Pin] {
        match self {
            StandardBlock::Ton | StandardBlock::Tof | StandardBlock::Tp => &[Pin::In, Pin::Pt],
            StandardBlock::Ctu => &[Pin::Cu, Pin::R, Pin::Pv],
            StandardBlock::Ctd => &[Pin::Cd, Pin::Ld, Pin::Pv],
            StandardBlock::Ctud => &[Pin::Cu, Pin::Cd, Pin::R, Pin::Ld, Pin::Pv],
            StandardBlock::RTrig | StandardBlock::FTrig => &[Pin::Clk],
            StandardBlock::Sr => &[Pin::S1, Pin::R],
            StandardBlock::Rs => &[Pin::S, Pin::R1],
        }
    }

    /// The outputs and internal state, which follow the inputs in memory.
    fn rest(self) -> &'static [Pin] {
        match self {
            StandardBlock::Ton | StandardBlock::Tof | StandardBlock::Tp => {
                &[Pin::Q, Pin::Et, Pin::Was]
            }
            StandardBlock::Ctu | StandardBlock::Ctd => &[Pin::Q, Pin::Cv, Pin::Was],
            StandardBlock::Ctud => &[Pin::Qu, Pin::Qd, Pin::Cv, Pin::Was, Pin::WasDown],
            StandardBlock::RTrig | StandardBlock::FTrig => &[Pin::Q, Pin::Was],
            StandardBlock::Sr | StandardBlock::Rs => &[Pin::Q1],
        }
    }

    /// All inputs, outputs and internal state, in memory order.
    pub fn pins(self) -> impl Iterator<Item = Pin> {
        self.inputs().iter().chain(self.rest()).copied()
    }

    /// The index of a pin in memory order; `None` if the block does not have it.
    #[must_use]
    pub fn position(self, pin: Pin) -> Option<usize> {
        self.pins().position(|one| one == pin)
    }

    /// The pin of this name, ignoring case. Alternative names such as `RESET` for `R` are accepted; `None` if there is
    /// none.
    #[must_use]
    pub fn pin(self, name: &str) -> Option<Pin> {
        let second = match (self, name.to_ascii_uppercase().as_str()) {
            (StandardBlock::Sr, "SET1") => Some(Pin::S1),
            (StandardBlock::Rs, "SET") => Some(Pin::S),
            (StandardBlock::Rs, "RESET1") => Some(Pin::R1),
            (StandardBlock::Sr | StandardBlock::Ctu | StandardBlock::Ctud, "RESET") => Some(Pin::R),
            (StandardBlock::Ctd | StandardBlock::Ctud, "LOAD") => Some(Pin::Ld),
            _ => None,
        };
        second.or_else(|| self.pins().find(|pin| same(pin.name(), name)))
    }

    /// Whether it is `TON`, `TOF` or `TP`.
    #[must_use]
    pub fn is_timer(self) -> bool {
        matches!(self, StandardBlock::Ton | StandardBlock::Tof | StandardBlock::Tp)
    }

    /// Whether it is `CTU`, `CTD` or `CTUD`.
    #[must_use]
    pub fn is_counter(self) -> bool {
        matches!(self, StandardBlock::Ctu | StandardBlock::Ctd | StandardBlock::Ctud)
    }
}

#[cfg(test)]
mod tests {
    use super::{Pin, StandardBlock};
    use std::collections::BTreeSet;

    fn letters(text: &str) -> String {
        text.replace('_', "").to_uppercase()
    }

    #[test]
    fn blocks_stand_at_their_numbers() {
        for (at, (one, name)) in StandardBlock::ALL.into_iter().enumerate() {
            assert_eq!(one as usize, at, "{one:?}");
            assert_eq!(letters(name), letters(&format!("{one:?}")));
        }
    }

    #[test]
    fn the_names_of_pins_stand_at_their_numbers() {
        let blocks = StandardBlock::ALL.into_iter();
        let pins: BTreeSet<Pin> = blocks.flat_map(|(one, _)| one.pins()).collect();
        assert_eq!(pins.len(), Pin::WasDown as usize + 1);
        for pin in pins {
            assert_eq!(letters(pin.name()), letters(&format!("{pin:?}")));
        }
    }
}

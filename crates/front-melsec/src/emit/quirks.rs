//! What switches in a project change of instructions' meaning: special relays that it may set, blocks of registers.

use super::errors::highest;
use crate::memory::{Family, Kind};
use crate::operand::{Device, Operand, Place};
use crate::resolve::Item;
use scanbound_ir::AreaId;
use std::collections::BTreeMap;

/// What the project's instructions may switch.
pub(super) struct Quirks {
    /// The block of the file register, so that `R` may be any `ZR`.
    pub switches_file_register: bool,
    /// FX, FX5: special relays that change what moves do: M8024 turns BMOV round, M8160 lets XCH swap bytes.
    pub turns_moves: bool,
    /// FX: with M8023 on, sums and differences of double words are of real numbers.
    pub sums_reals: bool,
    /// Q, L: with SM702 on, searches take their blocks for sorted ones.
    pub searches_by_halves: bool,
    /// FX, FX5: M8040, or IST, may keep a step ladder from moving on.
    pub states_may_stay: bool,
    /// FX: with M8164 on, FROM and TO move as many words as D8164 says.
    pub counts_elsewhere: bool,
    /// How many devices of an area there are at least, since the program names the last of them: areas whose devices lie
    /// one behind the other.
    pub named: BTreeMap<AreaId, u32>,
    /// The same of all areas, wherever their devices lie.
    pub highest: BTreeMap<AreaId, u32>,
}

impl Quirks {
    /// Those of a project.
    pub fn of(items: &[Item<'_>], family: Family) -> Quirks {
        let has = |names: &[&str]| items.iter().any(|item| names.contains(&&*item.name));
        let touches = |relays: &[u32]| items.iter().any(|item| touches(item, relays));
        let is_fx = matches!(family, Family::Fx | Family::Fx5);
        Quirks {
            switches_file_register: has(&["RSET", "RSETP", "QDRSET", "QDRSETP"]),
            turns_moves: is_fx && touches(&[8024, 8160]),
            sums_reals: family == Family::Fx && touches(&[8023]),
            searches_by_halves: touches(&[702]),
            states_may_stay: is_fx && (touches(&[8040]) || has(&["IST"])),
            counts_elsewhere: family == Family::Fx && touches(&[8164]),
            named: named(items),
            highest: highest(items.iter().flat_map(|item| &item.operands).filter_map(device)),
        }
    }
}

fn device(operand: &Result<Operand, String>) -> Option<&Device> {
    match operand {
        Ok(Operand::Device(device)) => Some(device),
        _ => None,
    }
}

/// How many devices the program names of areas that are one piece. D and W are not: beyond the CPU's own lie extended ones.
fn named(items: &[Item<'_>]) -> BTreeMap<AreaId, u32> {
    let mut named: BTreeMap<AreaId, u32> = BTreeMap::new();
    for operand in items.iter().flat_map(|item| &item.operands) {
        let Ok(Operand::Device(device)) = operand else { continue };
        let (area, number) = match device.place {
            Place::At(Kind::Bit(area), number) => (area, number),
            Place::At(Kind::Word(area), number) if matches!(device.name, "R" | "ZR") => {
                (area, number)
            }
            _ => continue,
        };
        let known = named.entry(area).or_default();
        *known = (*known).max(number.saturating_add(1));
    }
    named
}

/// Whether an instruction names one of these special relays of the FX (`M8023`) or FX5 (`SM8023`), alone, among digits or
/// the devices that ZRST clears, or may by an index.
fn touches(item: &Item<'_>, relays: &[u32]) -> bool {
    let touched = |first: u32, last: u32| relays.iter().any(|relay| (first..=last).contains(relay));
    let in_name = |operand: &Result<Operand, String>| match operand {
        Ok(Operand::Device(device)) if matches!(device.name, "M" | "SM") => match device.place {
            Place::At(_, relay) => touched(relay, relay),
            Place::Digits(_, first, digits) => {
                // Blocks begin with them.
                touched(first, first + 4 * u32::from(digits) - 1)
                    || (first >= FIRST_SPECIAL && touched(first, u32::MAX))
            }
            Place::Indexed(Kind::VolatileBit, _) | Place::IndexedDigits(Kind::VolatileBit, _) => {
                true
            }
            _ => false,
        },
        _ => false,
    };
    let number = |operand: &Result<Operand, String>| match operand {
        Ok(Operand::Device(Device { place: Place::At(_, at), .. })) => Some(*at),
        _ => None,
    };
    let between = match &item.operands[..] {
        [first, last] if item.name.starts_with("ZRST") => {
            number(first).zip(number(last)).is_some_and(|(from, to)| touched(from, to))
        }
        _ => false,
    };
    between || item.operands.iter().any(in_name)
}

/// From here on the FX's relays are special ones.
const FIRST_SPECIAL: u32 = 8000;

//! Finds the special relays and instructions in a project that change the meaning of other instructions, and other
//! facts about the whole project that lowering needs.

use super::named::NamedDevices;
use super::written::{index_values, unpulsed};
use crate::memory::{DeviceType, Family};
use crate::operand::{Device, Operand, Place};
use crate::resolve::{Category, Control, Item};
use scanbound_ir::{AreaId, Cell, Region, RegionSet};
use std::collections::BTreeMap;

/// What lowering needs to know about the whole project: the special relays and instructions in it that change the
/// meaning of other instructions, and which devices it names.
pub(super) struct Modes {
    /// Whether the program switches the file register block, so that `R` may be any `ZR`.
    pub switches_file_register: bool,
    /// FX, FX5: whether the program uses special relays that change moves: M8024 reverses BMOV, M8160 makes XCH swap
    /// bytes.
    pub changes_moves: bool,
    /// FX: whether the program uses M8023. With it on, double-word additions and subtractions work on real numbers.
    pub sums_reals: bool,
    /// Whether the program uses SM702 (or M702). With SM702 on, searches of Q and L use binary search and expect sorted
    /// blocks.
    pub uses_binary_search: bool,
    /// Q, L, iQ-R: whether contacts read SM704, which only block comparisons set. Whether interrupt programs keep it is
    /// unknown. (MELSEC-Q/L programming manual, common instructions, BKCMP.)
    pub reads_block_result: bool,
    /// Q, L: the numbers of the special relays that are states of the CPU's surroundings, and that the program only
    /// reads.
    pub switched_outside: Vec<u32>,
    /// Whether the program uses SM701 (or M701). With SM701 on, numbers become texts of another form on Q and L.
    pub uses_text_forms: bool,
    /// FX, FX5: whether the program uses M8040 or IST, which may inhibit transitions of a step ladder.
    pub states_may_stay: bool,
    /// FX: whether the program uses M8164. With it on, FROM and TO move as many words as D8164 says.
    pub counts_in_d8164: bool,
    /// Whether the project has interrupt programs.
    pub has_interrupts: bool,
    /// The cells that instructions reset or may reset; see [`Modes::may_reset`].
    resets: RegionSet,
    /// FX, FX5: for each index register that the program writes, 0 and the constants that it moves there. `None` if it
    /// writes other values.
    pub index_values: BTreeMap<(&'static str, u32), Option<Vec<i64>>>,
    /// FX, FX5: whether index registers may also have other values than `index_values` says; see
    /// [`Lowering::writes_other_indices`](super::Lowering::writes_other_indices).
    pub index_is_open: bool,
    /// For each area of bits, and for the file register: the number of devices that the CPU has at least, since the
    /// program names the highest one. Areas whose numbers may have gaps (D, W) are missing.
    pub named: BTreeMap<AreaId, u32>,
    /// As `named`, but for all areas, also those whose numbers may have gaps.
    pub devices: NamedDevices,
}

impl Modes {
    /// Finds what the instructions of a project use. `written_by_others` says whether something other than its
    /// instructions may write one of these special relays.
    pub fn of(
        items: &[Item<'_>],
        family: Family,
        written_by_others: impl Fn(&[u32]) -> bool,
    ) -> Modes {
        let has = |names: &[&str]| items.iter().any(|item| names.contains(&&*item.name));
        let is_used = |relays: &[u32]| {
            items.iter().any(|item| touches(item, relays)) || written_by_others(relays)
        };
        let is_fx = matches!(family, Family::Fx | Family::Fx5);
        let is_contact = |item: &&Item<'_>| matches!(item.category, Category::Contact { .. });
        let has_interrupts =
            items.iter().any(|item| matches!(item.category, Category::Control(Control::Interrupt)));
        let is_only_read = |relay: u32| {
            let mut others = items.iter().filter(|item| !is_contact(item));
            !others.any(|item| touches(item, &[relay])) && !written_by_others(&[relay])
        };
        let is_switched = matches!(family, Family::Q | Family::L);
        let switched = SURROUNDINGS.into_iter().filter(|_| is_switched);
        Modes {
            reads_block_result: !is_fx
                && !has_interrupts
                && is_only_read(704)
                && items.iter().any(|item| touches(item, &[704])),
            switched_outside: switched.filter(|&relay| is_only_read(relay)).collect(),
            switches_file_register: has(&["RSET", "RSETP", "QDRSET", "QDRSETP"]),
            changes_moves: is_fx && is_used(&[8024, 8160]),
            sums_reals: family == Family::Fx && is_used(&[8023]),
            uses_binary_search: is_used(&[702]),
            uses_text_forms: is_used(&[701]),
            states_may_stay: is_fx && (is_used(&[8040]) || has(&["IST"])),
            counts_in_d8164: family == Family::Fx && is_used(&[8164]),
            has_interrupts,
            resets: resets(items),
            index_values: if is_fx { index_values(items) } else { BTreeMap::new() },
            index_is_open: false,
            named: named(items),
            devices: NamedDevices::of(items),
        }
    }

    /// Whether an instruction may reset the timer or counter with this contact.
    pub fn may_reset(&self, contact: Cell) -> bool {
        self.resets.overlaps(Region::Range { first: contact, count: 1 })
    }
}

fn device(operand: &Result<Operand, String>) -> Option<&Device> {
    match operand {
        Ok(Operand::Device(device)) => Some(device),
        _ => None,
    }
}

/// The cells that instructions reset or may reset; for a timer or counter, this is the cell of its contact.
fn resets(items: &[Item<'_>]) -> RegionSet {
    let mut found = Vec::new();
    for item in items {
        let name = unpulsed(&item.name);
        let exact = match (name, &item.operands[..]) {
            ("RST", [Ok(Operand::Device(device))]) => cell(device).map(|first| (first, 1)),
            ("ZRST", [Ok(Operand::Device(first)), Ok(Operand::Device(last))]) => {
                let ends = cell(first).zip(cell(last));
                let ends = ends.filter(|(first, last)| first.area == last.area);
                ends.and_then(|(first, last)| {
                    Some((first, last.index.checked_sub(first.index)?.checked_add(1)?))
                })
            }
            ("BKRST", [Ok(Operand::Device(device)), Ok(Operand::Constant(count))]) => {
                cell(device).zip(u32::try_from(*count).ok())
            }
            ("RST" | "ZRST" | "BKRST", _) => None,
            _ => continue,
        };
        match exact {
            Some((first, count)) => found.push(Region::Range { first, count }),
            None => {
                let areas = item.operands.iter().filter_map(device).filter_map(cell_area);
                found.extend(areas.map(Region::Area));
            }
        }
    }
    found.into_iter().collect()
}

/// The cell of a plain device; for a timer or counter, the cell of its contact. `None` for other forms of operands.
fn cell(device: &Device) -> Option<Cell> {
    match device.place {
        Place::At(kind, index) => kind.cell(index),
        _ => None,
    }
}

/// The area of the cells that a device may be; for a timer or counter, the area of its contacts. `None` if it has no
/// such area.
fn cell_area(device: &Device) -> Option<AreaId> {
    match device.place {
        Place::At(kind, _)
        | Place::Indexed(kind, _)
        | Place::Digits(kind, ..)
        | Place::IndexedDigits(kind, _) => kind.cell(0).map(|cell| cell.area),
        _ => None,
    }
}

/// For each area of bits, and for the file register: the number of devices that the CPU has at least. D and W are left
/// out, because extended registers follow them with other numbers.
fn named(items: &[Item<'_>]) -> BTreeMap<AreaId, u32> {
    let mut named: BTreeMap<AreaId, u32> = BTreeMap::new();
    for operand in items.iter().flat_map(|item| &item.operands) {
        let Ok(Operand::Device(device)) = operand else { continue };
        let (area, number) = match device.place {
            Place::At(DeviceType::Bit(area), number) => (area, number),
            Place::At(DeviceType::Word(area), number) if matches!(device.name, "R" | "ZR") => {
                (area, number)
            }
            _ => continue,
        };
        let known = named.entry(area).or_default();
        *known = (*known).max(number.saturating_add(1));
    }
    named
}

/// Whether an instruction may access one of these special relays, as `M` or `SM` with this number: directly, as part of
/// a digit designation or a ZRST range, or through an index on a special relay.
fn touches(item: &Item<'_>, relays: &[u32]) -> bool {
    let touched = |first: u32, last: u32| relays.iter().any(|relay| (first..=last).contains(relay));
    let in_name = |operand: &Result<Operand, String>| match operand {
        // Special relays are M8000 and above, or SM; M below that are ordinary relays.
        Ok(Operand::Device(device))
            if device.name == "SM"
                || device.name == "M" && relays.iter().all(|&relay| relay >= FIRST_SPECIAL) =>
        {
            match device.place {
                Place::At(_, relay) => touched(relay, relay),
                Place::Digits(_, first, digits) => {
                    // A digit designation covers four relays for each digit.
                    touched(first, first + 4 * u32::from(digits) - 1)
                        || (first >= FIRST_SPECIAL && touched(first, u32::MAX))
                }
                Place::Indexed(DeviceType::VolatileBit, _)
                | Place::IndexedDigits(DeviceType::VolatileBit, _) => true,
                _ => false,
            }
        }
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

/// Special relays of Q and L that are states of the battery (SM51, SM52), the supply (SM53), fuses and modules (SM60,
/// SM61), and networks (SM255 and above, SM1255). (MELSEC-Q/L user's manual, hardware design, list of special relays.)
const SURROUNDINGS: [u32; 18] =
    [51, 52, 53, 60, 61, 255, 256, 257, 260, 261, 262, 265, 266, 267, 270, 271, 272, 1255];

/// The number of the first special relay of the FX.
const FIRST_SPECIAL: u32 = 8000;

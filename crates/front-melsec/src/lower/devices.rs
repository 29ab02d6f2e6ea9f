//! The numbers of devices: how many each CPU has that can run the program, and how many the CPU of a real run has.

use super::named::NamedDevices;
use super::state::Lowering;
use crate::memory::{DeviceType, Family, area, kind};
use crate::resolve::DecodeOptions;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Part;
use scanbound_ir::meaning::{Address, AddressRange, Term};
use scanbound_ir::{AreaId, Cell};

/// The largest number of file registers of a QCPU with a memory card: ZR0 to ZRFE7FF (intelligent communication module
/// QD51, programming manual, page 4-14). Extended data and link registers are part of them (LCPU, user's manual on
/// functions and programming, page 268).
const FILE_REGISTERS: u32 = 0xFE800;
/// The number of file registers of one block, R0 to R32767.
const BLOCK: u32 = 0x8000;
/// The largest number of relays of one kind that a QCPU can be set to (QnUCPU, user's manual on functions and
/// programming, page App-72).
const RELAYS: u32 = 0x8000;
/// The number of devices that an index of 16 bits can reach above a device.
const INDEX_REACH: u32 = 0x8000;

impl Lowering<'_> {
    /// The number of devices that an area surely has: every CPU of the family has them, the program names the last one,
    /// or the facts state the number. `None` if nothing is known.
    pub(super) fn points(&self, cells: AreaId, letters: &str) -> Option<u32> {
        let named = match (letters, self.is_switched(letters)) {
            ("D" | "W", _) | (_, true) => None,
            _ => self.modes.named.get(&cells).copied(),
        };
        let known = named.max(certain_points(self.family, cells, letters));
        match self.stated_devices(cells) {
            Some(stated) if matches!(letters, "D" | "W") => {
                Some(known.map_or(stated, |known| known.min(stated)))
            }
            Some(stated) if !self.is_switched(letters) => Some(stated),
            _ => known,
        }
    }

    /// The number of devices of an area that the facts state.
    fn stated_devices(&self, cells: AreaId) -> Option<u32> {
        let stated = self.options.facts.devices.iter();
        let mut stated = stated.filter_map(|(letters, &count)| {
            (changeable(letters, self.family)? == cells).then_some(count)
        });
        stated.next()
    }

    /// The number of devices of an area on the CPU of a real run: what the facts state, else the default number, or
    /// more if the program names more. The number of file registers is the largest that a CPU can have, since a
    /// parameter and a memory card decide it. `None` if it is unknown.
    pub(super) fn devices_of(&self, cells: AreaId) -> Option<u32> {
        let ends = self.named_beyond(cells);
        if let Some(stated) = self.stated_devices(cells) {
            return Some(stated);
        }
        if cells == const { area("ZR") } {
            let extended = [const { area("D") }, const { area("W") }].into_iter();
            let extended: u32 = extended.filter_map(|one| self.extended(one)).sum();
            let most = (self.family == Family::Q).then(|| FILE_REGISTERS.saturating_sub(extended));
            return ends.max(most);
        }
        let default = default_devices(self.family, cells)?;
        if let Some(more) = self.extended(cells) {
            return Some(default + more);
        }
        let relays = ["M", "L", "B"].map(area);
        Some(match ends {
            Some(ends) if self.family == Family::Q && relays.contains(&cells) => ends.max(RELAYS),
            _ => ends.unwrap_or(default),
        })
    }

    /// If the program names a device beyond the default number: the number of devices with those that it names, and
    /// with the blocks of constant length that begin at these.
    fn named_beyond(&self, cells: AreaId) -> Option<u32> {
        let named = &self.modes.devices;
        let highest = named.highest.get(&cells).copied()?;
        let is_beyond = highest > default_devices(self.family, cells).unwrap_or(0);
        named.with_blocks.get(&cells).copied().filter(|_| is_beyond)
    }

    /// The number of extended data or link registers that follow those of the default number on the CPU of a real run.
    /// `None` if there are none.
    fn extended(&self, cells: AreaId) -> Option<u32> {
        let is_register = [const { area("D") }, const { area("W") }].contains(&cells);
        let default = default_devices(self.family, cells)?;
        let ends = self.named_beyond(cells).filter(|_| is_register && self.family == Family::Q)?;
        Some(ends - default + INDEX_REACH)
    }

    /// The address of device number `base` plus an index, if these letters name the device: the cells that each CPU has
    /// and those that the CPU of a real run has. `None` if neither is known.
    pub(super) fn device_address(
        &self,
        (cells, letters): (AreaId, &str),
        base: i64,
        terms: Vec<Term>,
    ) -> Option<Address> {
        if self.is_switched(letters) {
            return None;
        }
        let certain = self.points(cells, letters);
        let chosen = match letters {
            "R" => self.devices_of(cells).map(|count| count.min(BLOCK)),
            _ => self.devices_of(cells),
        };
        let chosen = chosen.filter(|_| self.family != Family::Fx);
        let count = certain.or(chosen.map(|_| 0))?;
        let chosen = chosen.unwrap_or(0).max(count);
        // An index does not lead from the data registers to the extended ones, or back.
        let from = match default_devices(self.family, cells) {
            Some(default) if matches!(letters, "D" | "W") && chosen > default => default,
            _ => 0,
        };
        let range = match base >= i64::from(from) && from > 0 {
            true => AddressRange {
                from: from.into(),
                count: count.saturating_sub(from),
                chosen: chosen - from,
                first: Cell { area: cells, index: from },
            },
            false => {
                let chosen = if from > 0 { from.max(count) } else { chosen };
                AddressRange { from: 0, count, chosen, first: Cell { area: cells, index: 0 } }
            }
        };
        Some(Address { base, terms, ranges: vec![range] })
    }

    /// Whether an index of this device has 16 or 32 bits by a CPU parameter: file registers, and data and link
    /// registers beyond the default number.
    pub(super) fn is_extended(&self, cells: AreaId, letters: &str, number: u32) -> bool {
        let is_large = matches!(self.family, Family::Q | Family::L);
        let default = default_devices(self.family, cells);
        match letters {
            "R" | "ZR" => true,
            "D" | "W" => is_large && default.is_some_and(|default| number >= default),
            _ => false,
        }
    }

    /// How many devices of an area there are from number `first` on, on the CPU of a real run. A block does not lead
    /// from the data registers to the extended ones. `None` if it is unknown.
    pub(super) fn room(&self, cells: AreaId, first: u32) -> Option<u32> {
        let all = self.devices_of(cells)?;
        let default = default_devices(self.family, cells).unwrap_or(0);
        let end = match self.extended(cells) {
            Some(_) if first < default => default,
            _ => all,
        };
        Some(end.saturating_sub(first))
    }

    /// Records how many devices each CPU has that can run the program, for areas whose number is a parameter.
    pub(super) fn note_devices(&mut self) {
        if self.family == Family::Fx {
            return;
        }
        for letters in ["M", "L", "B", "D", "W", "ZR"] {
            let cells = area(letters);
            let named = self.modes.devices.with_blocks.get(&cells).copied();
            let all =
                [named, certain_points(self.family, cells, letters), self.stated_devices(cells)];
            let certain = all.into_iter().flatten().max().unwrap_or(0);
            self.out.program.certain_devices.insert(cells, certain);
        }
    }
}

/// Checks the numbers of devices that the facts state. Returns the errors in them.
pub(super) fn faults(options: &DecodeOptions<'_>, named: &NamedDevices) -> Vec<Diagnostic> {
    let facts = options.facts;
    let check = |(letters, &count): (&String, &u32)| {
        let fault = |part, message, help: &str| {
            Some(facts.fault(["devices", letters], part, Code::Fact, message, help))
        };
        let Some(area) = changeable(letters, options.family) else {
            let message = format!("the number of devices '{letters}' cannot be stated");
            return fault(Part::Key, message, "state numbers of M, L, B, D, W or ZR");
        };
        let highest = named.highest.get(&area).copied().unwrap_or(0);
        if count >= highest {
            return None;
        }
        let message = format!(
            "[devices] states {count} devices {letters}, but the program names one with the number {}",
            highest - 1
        );
        fault(Part::Value, message, "write the number of devices in the CPU's parameters")
    };
    facts.devices.iter().filter_map(check).collect()
}

/// The area of devices with these letters if a parameter gives their number.
fn changeable(letters: &str, family: Family) -> Option<AreaId> {
    let letters = letters.to_ascii_uppercase();
    let is_one = ["M", "L", "B", "D", "W", "ZR"].contains(&letters.as_str());
    match kind(&letters, 0, family).filter(|_| is_one && family != Family::Fx)? {
        DeviceType::Bit(area) | DeviceType::Word(area) => Some(area),
        _ => None,
    }
}

/// The number of devices of an area by default. `None` if unknown.
fn default_devices(family: Family, cells: AreaId) -> Option<u32> {
    let defaults: &[(&str, u32)] = match family {
        Family::Q | Family::L => &[
            ("X", 8192),
            ("Y", 8192),
            ("M", 8192),
            ("L", 8192),
            ("B", 8192),
            ("D", 12_288),
            ("W", 8192),
        ],
        Family::Iqr => &[("M", 12_288), ("L", 8192), ("B", 8192), ("D", 18_432), ("W", 8192)],
        Family::Fx5 => &[("M", 7680), ("L", 7680), ("B", 256), ("D", 8000), ("W", 512)],
        Family::Fx => &[],
    };
    let found = defaults.iter().find(|(name, _)| area(name) == cells);
    found.map(|(_, count)| *count)
}

/// The number of devices of an area that every CPU of the family has, if written with these letters. `None` if unknown.
pub(super) fn certain_points(family: Family, cells: AreaId, letters: &str) -> Option<u32> {
    if family == Family::Fx || family == Family::Fx5 {
        return match letters {
            "D" => Some(256),
            "M" => Some(512),
            _ => None,
        };
    }
    let points = [
        // The Basic model QCPU has fewest.
        ("X", 0x800),
        ("Y", 0x800),
        ("M", 8192),
        ("L", 2048),
        ("B", 0x800),
        ("D", 11_136),
        ("W", 0x800),
    ];
    let found = points.iter().find(|(name, _)| *name == letters && area(name) == cells);
    found.map(|(_, points)| *points)
}

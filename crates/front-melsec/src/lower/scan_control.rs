//! Instructions that affect the permitted scan time: WDT, and writes to the special devices for watchdog and constant
//! scan.

use super::state::Lowering;
use crate::catalog::{InstructionEffect, Role};
use crate::memory::{DeviceType, Family};
use crate::operand::{Device, Operand, Place};
use crate::resolve::{Category, Item};
use scanbound_base::time::Picos;
use scanbound_ir::{Instruction, ScanControl, Setting, Step, Switch};

/// The number of picoseconds in one unit of D8000 and D8039, a millisecond.
const MS: u64 = 1_000_000_000;
/// The number of the register with the watchdog time (FX3 programming manual; FX5: special devices compatible with FX).
const WATCHDOG: u32 = 8000;
/// The number of the register with the constant scan time, and of the relay that enables it (same sources).
const CONSTANT: u32 = 8039;
/// The largest number of words in a block of an FX instruction.
const LONGEST_BLOCK: u32 = 512;

/// How the CPUs of a family can change the limits of their scan time.
pub(super) fn of_family(family: Family) -> ScanControl {
    let devices = match family {
        Family::Fx => ["D8000", "D8039", "M8039"],
        Family::Fx5 => ["SD8000", "SD8039", "SM8039"],
        _ => [""; 3],
    };
    let by_parameters = (family != Family::Fx).then_some("constant scan");
    ScanControl { devices, by_parameters, ..ScanControl::default() }
}

impl Lowering<'_> {
    /// Records how the instructions from index `first` on, all lowered from one item, change the limits of the scan
    /// time.
    pub(super) fn note_scan_control(&mut self, item: &Item<'_>, first: usize) {
        // CPUs start with interrupts disabled: where EI may come late, requests of earlier scans wait for it, too.
        let may_leave = |step: &Step| {
            matches!(
                step,
                Step::Jump { .. }
                    | Step::Stop { .. }
                    | Step::Call { .. }
                    | Step::MasterControlBegin { .. }
                    | Step::ForBegin { .. }
            )
        };
        let is_late = |one: &Instruction| may_leave(&one.step);
        let earlier = &self.out.program.instructions[..first];
        let waits = match &*item.name {
            "DI" | "IMASK" | "SIMASK" => true,
            "EI" => earlier.iter().any(is_late),
            _ => false,
        };
        self.out.program.scan_control.holds_interrupts |= waits;
        let priced =
            self.out.program.instructions[first..].iter().rposition(|one| one.timing.is_some());
        let Some(at) = priced.map(|offset| first + offset) else { return };
        if matches!(&*item.name, "WDT" | "WDTP") {
            self.out.program.scan_control.restarts.insert(at);
            return;
        }
        if !matches!(self.family, Family::Fx | Family::Fx5) {
            return;
        }
        let written = self.written(item);
        // An indirect address may point to any of the registers.
        let is_any = |device: &Device| matches!(device.place, Place::Indirect);
        let of = |names: [&str; 2]| -> Vec<Device> {
            let all = written.iter().copied();
            all.filter(|device| names.contains(&device.name) || is_any(device)).collect()
        };
        let (registers, relays) = (of(["D", "SD"]), of(["M", "SM"]));
        for register in [WATCHDOG, CONSTANT] {
            if registers.iter().any(|device| self.may_reach(item, device, register)) {
                let setting = self.setting(item, register);
                let control = &mut self.out.program.scan_control;
                match register {
                    WATCHDOG => control.watchdog.insert(at, setting),
                    _ => control.constant.insert(at, setting),
                };
            }
        }
        if relays.iter().any(|device| self.may_reach(item, device, CONSTANT)) {
            let is_alone = matches!(relays[..], [Device { place: Place::At(..), .. }]);
            let switch = match &*item.name {
                "OUT" if is_alone => Switch::Condition,
                "SET" if is_alone => Switch::On,
                "RST" | "ZRST" | "ZRSTP" => Switch::Off,
                _ => Switch::Unknown,
            };
            self.out.program.scan_control.switches.insert(at, switch);
        }
    }

    /// The devices that the instruction may write.
    fn written(&self, item: &Item<'_>) -> Vec<Device> {
        let is_written = |operand: usize| match &item.category {
            Category::Coil => operand == 0,
            Category::User | Category::Unknown { .. } => true,
            Category::Listed(found) => found.entry.operands.get(operand).is_none_or(|one| {
                matches!(one.role, Role::Destination | Role::ReadWrite | Role::ReadWriteIfDevice)
            }),
            _ => false,
        };
        let operands = item.operands.iter().enumerate();
        let device = |(at, operand): (usize, &Result<Operand, String>)| match operand {
            Ok(Operand::Device(device)) if is_written(at) => Some(*device),
            _ => None,
        };
        operands.filter_map(device).collect()
    }

    /// Whether an instruction that writes a block from this device on may write the special device of this number.
    fn may_reach(&self, item: &Item<'_>, device: &Device, special: u32) -> bool {
        let number = |operand: &Operand| match operand {
            Operand::Device(Device { place: Place::At(_, number), .. }) => Some(*number),
            _ => None,
        };
        let first = match device.place {
            Place::At(_, first) | Place::BitOf(_, first, _) if first == special => return true,
            Place::At(_, first) | Place::BitOf(_, first, _) => first,
            Place::Digits(_, first, digits) => {
                return (first..first + 4 * u32::from(digits)).contains(&special)
                    || first < special
                        && self.block_length(item) > 1
                        && special - first < 16 * LONGEST_BLOCK;
            }
            Place::Indexed(DeviceType::VolatileBit | DeviceType::VolatileWord, _)
            | Place::IndexedDigits(DeviceType::VolatileBit, _)
            | Place::Indirect => return true,
            Place::Indexed(..) | Place::IndexedDigits(..) => {
                return self.index_reaches(device, special);
            }
            _ => return false,
        };
        if first > special {
            return false;
        }
        if item.name.starts_with("ZRST") {
            let last = item.operands.iter().filter_map(|one| number(one.as_ref().ok()?)).max();
            return last.is_some_and(|last| last >= special);
        }
        special - first < self.block_length(item)
    }

    /// The largest number of devices that an instruction may write, from its operand on.
    fn block_length(&self, item: &Item<'_>) -> u32 {
        let found = match &item.category {
            Category::Listed(found) => found,
            Category::User | Category::Unknown { .. } => return LONGEST_BLOCK,
            _ => return 1,
        };
        if unpulsed(&item.name) == "DECO" {
            let exponent = match item.operands.last() {
                Some(Ok(Operand::Constant(exponent))) => u32::try_from(*exponent).unwrap_or(8),
                _ => 8,
            };
            return 1 << exponent.min(8);
        }
        match found.entry.meaning {
            InstructionEffect::Copy
            | InstructionEffect::Fill
            | InstructionEffect::Havoc
            | InstructionEffect::HavocAlways
            | InstructionEffect::HavocAnytime
            | InstructionEffect::Clear
            | InstructionEffect::SlideUp
            | InstructionEffect::SlideDown
            | InstructionEffect::Pairwise
            | InstructionEffect::Text => {
                let is_move = matches!(unpulsed(&item.name), "MOV" | "CML" | "SMOV");
                let is_long = matches!(unpulsed(&item.name), "DMOV" | "DCML" | "EMOV" | "DEMOV");
                let constants = item.operands.iter().filter_map(|operand| match operand {
                    Ok(Operand::Constant(count)) => u32::try_from(*count).ok(),
                    _ => None,
                });
                let words = item
                    .operands
                    .iter()
                    .skip(1)
                    .any(|operand| matches!(operand, Ok(Operand::Device(_))));
                match (is_move, is_long) {
                    (true, _) => 1,
                    (_, true) => 2,
                    // A count in a word may have any value.
                    _ if item.operands.len() > 2
                        && words
                        && !matches!(item.operands.last(), Some(Ok(Operand::Constant(_)))) =>
                    {
                        LONGEST_BLOCK
                    }
                    // The count of a block of double words is that of its double words.
                    _ => {
                        let words = if item.name.starts_with('D') { 2 } else { 1 };
                        (words * constants.max().unwrap_or(4).min(LONGEST_BLOCK))
                            .clamp(4, LONGEST_BLOCK)
                    }
                }
            }
            _ => 4,
        }
    }

    /// Whether an index may lead to the device, if the program assigns only constants to this index register. A
    /// computed index is assumed not to exceed the end of the area, as everywhere.
    fn index_reaches(&self, device: &Device, special: u32) -> bool {
        let Some(index) = device.index else { return false };
        let register = format!("{}{}", index.letters, index.register);
        self.resolved.items.iter().any(|item| match item.operands.first() {
            Some(Ok(Operand::Constant(value))) => {
                item.raw.operands.last().is_some_and(|to| to.eq_ignore_ascii_case(&register))
                    && i64::from(index.number) + value == i64::from(special)
            }
            _ => false,
        })
    }

    /// The time to which an instruction that writes the register sets it.
    fn setting(&self, item: &Item<'_>, register: u32) -> Setting {
        let is_move = matches!(unpulsed(&item.name), "MOV" | "DMOV" | "FMOV");
        let is_plain = matches!(item.operands.get(1), Some(Ok(Operand::Device(Device { place: Place::At(_, at), .. }))) if *at == register);
        let unknown = || {
            let is_plain_device = |operand: &&Result<Operand, String>| {
                matches!(operand, Ok(Operand::Device(Device { place: Place::At(..), .. })))
            };
            match item.operands.first().filter(is_plain_device) {
                Some(_) if is_move && is_plain => Setting::Device(item.raw.operands[0].clone()),
                _ => Setting::Computed(item.raw.text.to_string()),
            }
        };
        if item.name.starts_with("RST") || item.name.starts_with("ZRST") {
            return Setting::Range(Picos::ZERO, Picos::ZERO);
        }
        if !is_move || !(is_plain || item.name.starts_with("FMOV")) {
            return unknown();
        }
        match item.operands.first() {
            Some(Ok(Operand::Constant(value))) => {
                let time = Picos(MS).times(u64::from(*value as u16));
                Setting::Range(time, time)
            }
            Some(Ok(Operand::Device(device))) => {
                self.stated_times(device, &item.raw.operands[0]).unwrap_or_else(unknown)
            }
            _ => unknown(),
        }
    }

    /// The time setting that the stated range of a word gives, if the program writes to the word only constants in this
    /// range.
    fn stated_times(&self, word: &Device, name: &str) -> Option<Setting> {
        let Place::At(_, number) = word.place else { return None };
        let ranges = &self.options.facts.ranges;
        let stated = ranges.iter().find(|(own, _)| own.eq_ignore_ascii_case(name));
        let (low, high) = *stated?.1;
        let keeps = |item: &Item<'_>| {
            let constant = match item.operands.first() {
                Some(Ok(Operand::Constant(value))) if unpulsed(&item.name) == "MOV" => Some(value),
                _ => None,
            };
            self.written(item).iter().all(|device| match device.place {
                Place::At(_, first) if device.name == word.name && first == number => {
                    constant.is_some_and(|value| (low..=high).contains(value))
                }
                Place::Indirect => false,
                Place::Indexed(..) | Place::IndexedDigits(..) => device.name != word.name,
                _ => device.name != word.name || !self.may_reach(item, device, number),
            })
        };
        let time = |value: i64| Some(Picos(MS).times(u64::try_from(value).ok()?));
        let all = self.resolved.items.iter().all(keeps);
        if all { Some(Setting::Range(time(low)?, time(high)?)) } else { None }
    }
}

/// The mnemonic without the suffix P of its pulse form.
fn unpulsed(name: &str) -> &str {
    name.strip_suffix('P').unwrap_or(name)
}

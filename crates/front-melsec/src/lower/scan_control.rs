//! Instructions that affect the permitted scan time: WDT, and writes to the special devices for watchdog and constant
//! scan.

use super::ranges::{self, INDEX_REGISTERS, has_special, others_write};
use super::state::Lowering;
use super::written::{LONGEST_BLOCK, block_length, known_length, unpulsed, written};
use crate::catalog::EVERYWHERE;
use crate::memory::{DeviceType, Family, area};
use crate::operand::{Device, Index, Operand, Place};
use crate::resolve::{Category, Item};
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use scanbound_ir::{AreaId, Cell, Instruction, Region, ScanControl, Setting, Step, Switch};

/// One unit of D8000 and D8039, a millisecond, in ps.
const MS: u64 = 1_000_000_000;
/// The number of the register with the watchdog time (FX3 programming manual; FX5: special devices compatible with FX).
const WATCHDOG: u32 = 8000;
/// The number of the register with the constant scan time, and of the relay that enables the constant scan (FX3
/// programming manual; FX5: special devices compatible with FX).
const CONSTANT: u32 = 8039;
/// The areas of the index registers.
const INDEX_AREAS: [AreaId; 2] = [area("Z"), area("V index ")];

/// How the CPUs of a family can change the limits of their scan time: the devices for watchdog time, constant scan time
/// and the relay that enables it (empty names on Q, L and iQ-R, which have none), and whether CPU parameters set a
/// constant scan (all but the FX).
pub(super) fn of_family(family: Family) -> ScanControl {
    let devices = match family {
        Family::Fx => ["D8000", "D8039", "M8039"],
        Family::Fx5 => ["SD8000", "SD8039", "SM8039"],
        _ => [""; 3],
    };
    let other_names = match family {
        Family::Fx => ["SD8000", "SD8039", "SM8039"],
        _ => [""; 3],
    };
    let by_parameters = (family != Family::Fx).then_some("constant scan");
    ScanControl { devices, other_names, by_parameters, ..ScanControl::default() }
}

/// The smallest and the largest value that the facts state for an index register. `None` if they state none.
fn stated_values(facts: &Facts, index: Index) -> Option<(i64, i64)> {
    let register = format!("{}{}", index.letters, index.register);
    let mut stated = facts.indices.iter();
    stated.find(|(name, _)| name.eq_ignore_ascii_case(&register)).map(|(_, &values)| values)
}

/// Whether the catalog says that the instruction may write any device.
fn writes_everywhere(item: &Item<'_>) -> bool {
    matches!(&item.category, Category::Listed(found) if found.entry.also.contains(&EVERYWHERE))
}

impl Lowering<'_> {
    /// Records how the instructions from index `first` on, all lowered from one item, change the limits of the scan
    /// time, and whether interrupts may have to wait.
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
        if writes_everywhere(item) {
            self.set_all(at);
            return;
        }
        let written = written(item);
        // An indirect address may point to any of the registers.
        let is_any = |device: &Device| matches!(device.place, Place::Indirect);
        let of = |names: [&str; 2]| -> Vec<Device> {
            let all = written.iter().copied();
            all.filter(|device| names.contains(&device.name) || is_any(device)).collect()
        };
        let (registers, relays) = match self.family {
            Family::Fx => (of(["D", "SD"]), of(["M", "SM"])),
            // D8000 of the FX5 is an ordinary register.
            _ => (of(["SD", "SD"]), of(["SM", "SM"])),
        };
        for register in [WATCHDOG, CONSTANT] {
            if let Some(is_certain) = self.reaches(item, &registers, register) {
                let setting = match is_certain {
                    true => self.setting(item, register),
                    false => Setting::Possible,
                };
                let control = &mut self.out.program.scan_control;
                match register {
                    WATCHDOG => control.watchdog.insert(at, setting),
                    _ => control.constant.insert(at, setting),
                };
            }
        }
        if let Some(is_certain) = self.reaches(item, &relays, CONSTANT) {
            let is_alone = matches!(relays[..], [Device { place: Place::At(..), .. }]);
            let switch = match &*item.name {
                "OUT" if is_alone => Switch::Condition,
                "SET" if is_alone => Switch::On,
                "RST" | "ZRST" | "ZRSTP" if is_certain => Switch::Off,
                "RST" | "ZRST" | "ZRSTP" => Switch::PossiblyOff,
                _ => Switch::Unknown,
            };
            self.out.program.scan_control.switches.insert(at, switch);
        }
        let by_index = &mut self.out.program.scan_control.by_index;
        let is_unstated = |device: &Device| {
            device.index.is_some_and(|index| stated_values(self.options.facts, index).is_none())
        };
        if registers.iter().any(is_unstated) {
            by_index.insert(at, None);
        }
        if relays.iter().any(is_unstated) {
            let resets = matches!(&*item.name, "RST" | "ZRST" | "ZRSTP");
            by_index.insert(at, Some(if resets { Switch::PossiblyOff } else { Switch::Unknown }));
        }
    }

    /// Records that the instruction `at`, a call of the missing routine `name`, may set the special devices for
    /// watchdog and constant scan that the facts let the routine write.
    pub(super) fn note_missing_routine(&mut self, at: usize, name: &str) {
        let writes = self.options.facts.calls.get(name).and_then(|stated| stated.writes.as_ref());
        let Some(writes) = writes else { return self.set_all(at) };
        let [watchdog, constant, relay] = self.out.program.scan_control.devices;
        let is_written =
            |special| writes.iter().any(|text| has_special(text, special, self.family));
        let control = &mut self.out.program.scan_control;
        if is_written(watchdog) {
            control.watchdog.insert(at, Setting::Computed);
        }
        if is_written(constant) {
            control.constant.insert(at, Setting::Computed);
        }
        if is_written(relay) {
            control.switches.insert(at, Switch::Unknown);
        }
    }

    /// Records that the instruction `at` may write any special device for watchdog and constant scan.
    fn set_all(&mut self, at: usize) {
        if !matches!(self.family, Family::Fx | Family::Fx5) {
            return;
        }
        let control = &mut self.out.program.scan_control;
        control.watchdog.insert(at, Setting::Possible);
        control.constant.insert(at, Setting::Possible);
        control.switches.insert(at, Switch::Unknown);
    }

    /// FX, FX5: whether index registers may get other values than [`index_values`](super::written::index_values) finds:
    /// through an instruction that writes them without an operand, through a special register or an indirect address,
    /// from a missing routine or from other stations.
    pub(super) fn writes_other_indices(&self) -> bool {
        if !matches!(self.family, Family::Fx | Family::Fx5) {
            return false;
        }
        let in_index = |region: &Region| match *region {
            Region::Range { first: Cell { area, .. }, .. } | Region::Area(area) => {
                INDEX_AREAS.contains(&area)
            }
            Region::Everything => true,
        };
        let is_index = |text: &String| {
            let regions = ranges::written(text, self.family, false);
            regions.is_some_and(|regions| regions.iter().any(in_index))
        };
        let by_item = |item: &Item<'_>| {
            let also = match &item.category {
                Category::Listed(found) => &found.entry.also[..],
                _ => &[],
            };
            also.iter().any(|&name| name == EVERYWHERE || INDEX_AREAS.contains(&area(name)))
                || written(item).iter().any(|device| match device.place {
                    Place::Indirect => true,
                    _ if self.family == Family::Fx && device.name == "D" => INDEX_REGISTERS
                        .into_iter()
                        .flatten()
                        .any(|one| self.may_reach(item, device, one)),
                    _ => false,
                })
        };
        others_write(self.structure, self.options, is_index)
            || self.resolved.items.iter().any(by_item)
    }

    /// Whether an instruction that writes these devices certainly writes the special device of number `special`. `None`
    /// if it certainly does not. The caller has checked that the devices have the right type.
    fn reaches(&self, item: &Item<'_>, devices: &[Device], special: u32) -> Option<bool> {
        let reached = devices.iter().filter(|device| self.may_reach(item, device, special));
        reached
            .map(|device| certainly_reaches(item, device, special, self.family))
            .reduce(|one, other| one || other)
    }

    /// Whether an instruction that writes a block from this device on may write the special device of number `special`.
    /// The caller has checked that the device has the right type.
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
                        && block_length(item, self.family) > 1
                        && special - first < 16 * LONGEST_BLOCK;
            }
            Place::Indexed(DeviceType::VolatileBit | DeviceType::VolatileWord, _)
            | Place::IndexedDigits(DeviceType::VolatileBit, _)
            | Place::Indirect => return true,
            Place::Indexed(..) | Place::IndexedDigits(..) => {
                return self.index_reaches(item, device, special);
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
        special - first < block_length(item, self.family)
    }

    /// Whether a write to an indexed device may reach the device of number `special`. The values of an index register
    /// are known if they are stated, or if the program assigns only constants to it; otherwise it may.
    fn index_reaches(&self, item: &Item<'_>, device: &Device, special: u32) -> bool {
        // The other end of the range may be anywhere.
        let (Some(index), false) = (device.index, item.name.starts_with("ZRST")) else {
            return true;
        };
        let length = match device.place {
            Place::IndexedDigits(_, digits) => {
                4 * u32::from(digits) * block_length(item, self.family)
            }
            _ => block_length(item, self.family),
        };
        let leads = |value: i64| {
            let first = i64::from(index.number) + value;
            (first..first + i64::from(length)).contains(&i64::from(special))
        };
        if let Some((low, high)) = stated_values(self.options.facts, index) {
            let first = i64::from(index.number) + low;
            let end = i64::from(index.number) + high + i64::from(length);
            return (first..end).contains(&i64::from(special));
        }
        if self.modes.index_is_open {
            return true;
        }
        match self.modes.index_values.get(&(index.letters, index.register)) {
            None => leads(0),
            Some(values) => values.as_ref().is_none_or(|all| all.iter().copied().any(leads)),
        }
    }

    /// What is known about the time to which an instruction that certainly writes the register sets it.
    fn setting(&self, item: &Item<'_>, register: u32) -> Setting {
        let is_plain = |operand: usize, number: u32| {
            let is_here =
                |device: &Device| matches!(device.place, Place::At(_, at) if at == number);
            matches!(item.operands.get(operand), Some(Ok(Operand::Device(device))) if is_here(device))
        };
        match (unpulsed(&item.name), item.operands.first()) {
            ("RST", _) if is_plain(0, register) => Setting::Range(Picos::ZERO, Picos::ZERO),
            ("ZRST", _) => Setting::Range(Picos::ZERO, Picos::ZERO),
            ("MOV" | "DMOV", _) if !is_plain(1, register) => Setting::Computed,
            ("MOV" | "DMOV" | "FMOV", Some(Ok(Operand::Constant(value)))) => {
                let time = Picos(MS).times(u64::from(*value as u16));
                Setting::Range(time, time)
            }
            ("MOV" | "DMOV" | "FMOV", Some(Ok(Operand::Device(device)))) => {
                let (name, is_word) =
                    (&item.raw.operands[0], matches!(device.place, Place::At(..)));
                let stated = self.stated_times(device, name);
                let unknown =
                    || if is_word { Setting::Device(name.clone()) } else { Setting::Computed };
                stated.unwrap_or_else(unknown)
            }
            _ => Setting::Computed,
        }
    }

    /// The time setting that the stated range of a word gives. `None` if no range is stated, or if an instruction may
    /// write another value to the word than a constant in this range.
    fn stated_times(&self, word: &Device, name: &str) -> Option<Setting> {
        let Place::At(DeviceType::Word(own), number) = word.place else { return None };
        let ranges = &self.options.facts.ranges;
        let stated = ranges.iter().find(|(own, _)| own.eq_ignore_ascii_case(name));
        let (low, high) = *stated?.1;
        let keeps = |item: &Item<'_>| {
            let constant = match item.operands.first() {
                Some(Ok(Operand::Constant(value))) if unpulsed(&item.name) == "MOV" => Some(value),
                _ => None,
            };
            written(item).iter().all(|device| match device.place {
                Place::At(DeviceType::Word(area), first) if area == own && first == number => {
                    constant.is_some_and(|value| (low..=high).contains(value))
                }
                Place::Indirect => false,
                Place::Indexed(DeviceType::Word(area), _) => area != own,
                Place::At(DeviceType::Word(area), _) | Place::BitOf(DeviceType::Word(area), ..) => {
                    area != own || !self.may_reach(item, device, number)
                }
                _ => true,
            })
        };
        let time = |value: i64| Some(Picos(MS).times(u64::try_from(value).ok()?));
        let all = self.resolved.items.iter().all(keeps);
        if all { Some(Setting::Range(time(low)?, time(high)?)) } else { None }
    }
}

/// Whether an instruction that writes a block from this device on certainly writes the special device of number
/// `special`. The caller has checked that it may.
fn certainly_reaches(item: &Item<'_>, device: &Device, special: u32, family: Family) -> bool {
    let first = match device.place {
        Place::At(_, first) | Place::BitOf(_, first, _) => first,
        _ => return false,
    };
    let number = |operand: &Result<Operand, String>| match operand {
        Ok(Operand::Device(Device { place: Place::At(_, number), .. })) => Some(*number),
        _ => None,
    };
    if item.name.starts_with("ZRST") {
        let ends: Option<Vec<u32>> = item.operands.iter().map(number).collect();
        // If the first is above the last, the FX resets the first one alone; for the others it is an operation error.
        return matches!(ends.as_deref(), Some(&[first, last])
            if (family == Family::Fx && first == special) || (first..=last).contains(&special));
    }
    match unpulsed(&item.name) {
        // A count of 0 writes nothing, one in a word may, and one above 512 is an operation error on the FX.
        "FMOV" => known_length(item)
            .is_some_and(|length| (1..=512).contains(&length) && special - first < length),
        _ => first == special || known_length(item).is_some(),
    }
}

//! The emulated CPU's memory as seen over a connection.

use super::Cpu;
use scanbound_ir::{AreaId, AreaKind, Cell, WordSource};
use scanbound_link::{Coil, Memory, Setting, State};

/// No area of any CPU has more devices.
const MAX_DEVICES: u32 = 1_000_000;

/// The names of areas in protocols, and in programs.
const NAMES: &[(&str, &str)] = &[
    ("R", "ZR"),
    ("TS", "T"),
    ("TC", "T coil "),
    ("TN", "T value "),
    ("CS", "C"),
    ("CC", "C coil "),
    ("CN", "C value "),
];

/// Relays that the CPU keeps on, by area and number: the always-on relay, and those that are on in RUN.
const ON: &[(&str, u32)] = &[("SM", 400), ("SM", 403), ("M", 8000)];

/// The register with the operating state, and its value for STOP.
const OPERATING: (&str, u32, u16) = ("SD", 203, 2);

/// The first special register or relay of each area.
const SPECIAL: &[(&str, u32)] = &[("SD", 0), ("SM", 0), ("D", 8000), ("M", 8000)];

/// The areas in which words with set values may be.
const SETTINGS: [&str; 5] = ["IR", "LR", "HR", "AR", "DM"];

impl Cpu<'_> {
    /// The area and its kind for a protocol's name. `None` if it contains only registers that the CPU itself maintains.
    fn known(&self, name: &str) -> Option<(Option<AreaId>, AreaKind)> {
        let own = NAMES.iter().find(|(one, _)| *one == name).map_or(name, |(_, own)| *own);
        if let Some(area) = self.area(own).or_else(|| self.area(name)) {
            return Some((Some(area), self.program.area(area).kind));
        }
        // Only CPUs that keep their scan times in such registers have them.
        let has = self.registers.is_some_and(|registers| registers.current.area == "SD");
        (has && name == "SD").then_some((None, AreaKind::Word))
    }

    /// Whether devices of this area may be asked for by the name that a protocol has for several CPUs' areas.
    fn device(&self, name: &str, area: Option<AreaId>, index: u32) -> u16 {
        let special = SPECIAL.iter().any(|(one, first)| *one == name && index >= *first);
        // Only one kind of CPU has special relays and registers among ordinary ones.
        let among = index >= 8000 && self.registers.is_none_or(|one| one.current.area != "D");
        if special && !among {
            let running = self.state == State::Run;
            if ON.contains(&(name, index)) {
                return u16::from(running || index == 400);
            }
            if (name, index) == (OPERATING.0, OPERATING.1) {
                return if running { 0 } else { OPERATING.2 };
            }
            if let Some(value) = self.cpu.register(name, index) {
                return value;
            }
        }
        area.map_or(0, |area| self.cpu.value(Cell { area, index }))
    }
}

impl Memory for Cpu<'_> {
    fn words(&mut self, name: &str, first: u32, count: u32) -> Option<Vec<u16>> {
        let (area, kind) = self.known(name)?;
        let each = if kind == AreaKind::Bit { 16 } else { 1 };
        first.checked_add(count.checked_mul(each)?).filter(|end| *end <= MAX_DEVICES)?;
        let word = |at: u32| match kind {
            AreaKind::Word => self.device(name, area, first + at),
            AreaKind::Bit => (0..16).fold(0, |word, bit| {
                word | (self.device(name, area, first + 16 * at + bit) & 1) << bit
            }),
        };
        Some((0..count).map(word).collect())
    }

    fn bits(&mut self, name: &str, first: u32, count: u32) -> Option<Vec<bool>> {
        let (area, kind) = self.known(name)?;
        first.checked_add(count).filter(|end| *end <= MAX_DEVICES && kind == AreaKind::Bit)?;
        Some((first..first + count).map(|at| self.device(name, area, at) & 1 == 1).collect())
    }

    fn setting(&mut self, coil: Coil, number: u32, from: u32) -> Option<Setting> {
        let begins = |at: usize| self.program.instructions.get(at).map_or("", |one| &*one.text);
        let found = self.program.timekeeping.instructions.iter().find(|(at, timed)| {
            let name = begins(**at).split(' ').next().unwrap_or("");
            // Some mnemonics are written with the function's number behind them.
            let name = name.split('(').next().unwrap_or("");
            let address = self.program.instructions[..**at].iter();
            let address = address.filter(|before| before.timing.is_some()).count();
            name.eq_ignore_ascii_case(coil.name())
                && timed.flag.index == number
                && u32::try_from(address).is_ok_and(|address| address >= from)
        })?;
        match found.1.setting {
            WordSource::Const(word) => {
                let digits = (0..4).map(|place| word >> (4 * place) & 15);
                let sum = digits.zip([1, 10, 100, 1000]).map(|(digit, unit)| digit * unit).sum();
                Some(Setting::Number(if found.1.is_decimal { sum } else { word }))
            }
            WordSource::Cell(cell) => {
                let name = &*self.program.area(cell.area).name;
                let area = SETTINGS.iter().find(|known| **known == name)?;
                Some(Setting::Word { area, index: cell.index })
            }
            WordSource::Bits { .. } | WordSource::Free(_) => None,
        }
    }

    fn state(&mut self) -> State {
        self.state
    }

    fn model(&mut self) -> String {
        self.model.clone()
    }

    fn scan_times(&mut self) -> [u32; 3] {
        const TENTH: u64 = 100_000_000;
        let [current, least, most] = self.measured.unwrap_or_default();
        // The mean is not kept, so the last scan time stands for it.
        [current, most, least].map(|time| u32::try_from(time.0 / TENTH).unwrap_or(u32::MAX))
    }
}

//! A CPU that goes on scanning: real runs that follow each other, and only what each takes.

use super::clockwork::{Clockwork, Found};
use super::machine::Machine;
use super::memory::{Left, Memory};
use super::{FreeValues, Mode, Stopped};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::timed::Timed;
use scanbound_ir::{AreaKind, BitTarget, Cell, ChoiceId, ChoiceKey, Program};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// A CPU whose memory was cleared, and the scans that it has made.
pub struct Emulated<'p> {
    program: &'p Program,
    times: &'p [Times],
    memory: Memory,
    /// What registers hold that it sets by itself, by area and number; 0 where one is not named.
    registers: BTreeMap<(String, u32), u16>,
    /// Whether no scan was made yet.
    first: bool,
    /// How long it was running when the scan began.
    now: Picos,
    clockwork: RefCell<Clockwork>,
}

/// One scan of an emulated CPU.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scan {
    /// What its instructions take.
    pub total: Picos,
    /// How many it executed.
    pub executed: u64,
    /// Where it is followed no further: what the program does then depends on what is not known here.
    pub stopped: Option<Stopped>,
    /// The instruction at which it goes round without end.
    pub unbounded: Option<usize>,
}

/// The values with which a scan starts.
struct Start<'e, 'p> {
    cpu: &'e Emulated<'p>,
}

impl<'p> Emulated<'p> {
    /// Power-up with cleared memory. `times` is parallel to `Program::instructions`.
    #[must_use]
    pub fn new(program: &'p Program, times: &'p [Times]) -> Emulated<'p> {
        let (memory, registers) = (Memory::default(), BTreeMap::new());
        let (now, clockwork) = (Picos::ZERO, RefCell::default());
        let mut cpu = Emulated { program, times, memory, registers, first: true, now, clockwork };
        cpu.flag_first(true);
        cpu
    }

    /// Sets or clears the bit of a word that says that this is the first scan since memory was cleared.
    fn flag_first(&mut self, is_first: bool) {
        if let Some(BitTarget::WordBit(cell, bit)) = self.program.power_up.fresh {
            let word = self.value(cell);
            let mask = 1 << bit;
            let word = if is_first { word | mask } else { word & !mask };
            self.memory.set(cell, word);
        }
    }

    /// Sets a cell from outside.
    pub fn set(&mut self, cell: Cell, value: u16) {
        self.memory.set(cell, value);
    }

    /// Sets a register that the CPU keeps by itself.
    pub fn set_register(&mut self, area: &str, index: u32, value: u16) {
        self.registers.insert((area.to_owned(), index), value);
    }

    /// What such a register holds.
    #[must_use]
    pub fn register(&self, area: &str, index: u32) -> Option<u16> {
        self.registers.get(&(area.to_owned(), index)).copied()
    }

    /// What a cell holds.
    #[must_use]
    pub fn value(&self, cell: Cell) -> u16 {
        self.memory.get(cell).map_or(0, |(value, _)| value)
    }

    /// Says how long it has been running when the next scan begins.
    pub fn set_clock(&mut self, now: Picos) {
        self.now = now;
    }

    /// Makes the next scan, of at most `most` instructions.
    pub fn scan(&mut self, most: u64) -> Scan {
        let start = Start { cpu: self };
        let machine = Machine::new(self.program, self.times, start, Mode::Real).summing();
        let (total, executed, stopped, unbounded, mut state) = machine.summed(most);
        let left = Left::by(&mut state);
        drop(state);
        self.memory.take(left);
        self.first = false;
        self.flag_first(false);
        Scan { total, executed, stopped, unbounded }
    }
}

impl FreeValues for Start<'_, '_> {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        match self.cpu.program.power_up.first_scan.contains(&cell) {
            true => u16::from(self.cpu.first),
            false => self.cpu.value(cell),
        }
    }

    fn unknown(&mut self, cell: Cell) -> u16 {
        if self.cpu.program.power_up.first_scan.contains(&cell) {
            return 0;
        }
        self.cpu.memory.get(cell).map_or(0, |(_, unknown)| unknown)
    }

    fn choice(&mut self, _key: &ChoiceKey, _kind: AreaKind) -> u16 {
        0
    }

    fn timed(&mut self, timed: &Timed, found: &Found) -> Option<(bool, u16)> {
        let now = self.cpu.now + found.now;
        let found = Found { now, ..found.clone() };
        self.cpu.clockwork.borrow_mut().execute(timed, &found)
    }

    fn keeps_time(&self) -> bool {
        true
    }

    fn register(&mut self, choice: ChoiceId) -> Option<u16> {
        let (area, index) = self.cpu.program.registers.get(&choice)?;
        Some(self.cpu.register(area, *index).unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_base::facts::Facts;
    use scanbound_front::{Input, Options};
    use scanbound_ir::AreaId;

    /// Runs a program for so many scans, each instruction taking a nanosecond, and gives each scan's time and what D0
    /// holds then.
    fn runs(text: &str, scans: usize) -> Vec<(u64, u16)> {
        let input = Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() };
        let facts = Facts::default();
        let options = Options { family: Some("q"), ..Options::new(&facts) };
        let project = scanbound_fronts::read(&[input], Some("melsec-list")).expect("a program");
        let program = project.decode(&options).expect("a sound one");
        let times = vec![Times::new(Picos(1), Picos(1)); program.instructions.len()];
        let mut cpu = Emulated::new(&program, &times);
        let area = program.areas.iter().position(|area| area.name == "D").expect("an area");
        let d0 = Cell { area: AreaId(area as u16), index: 0 };
        (0..scans)
            .map(|_| {
                cpu.set_register("SD", 520, 7);
                let scan = cpu.scan(1_000_000);
                assert_eq!((scan.stopped, scan.unbounded), (None, None));
                assert_eq!(scan.executed, scan.total.0);
                (scan.total.0, cpu.value(d0))
            })
            .collect()
    }

    #[test]
    fn memory_lasts_from_scan_to_scan() {
        assert_eq!(runs("LD SM400\nINC D0\nEND\n", 3), [(3, 1), (3, 2), (3, 3)]);
        assert_eq!(runs("LD SM402\nMOV K5 D0\nLDI SM402\nMOV K6 D0\nEND\n", 2), [(5, 5), (5, 6)]);
    }

    #[test]
    fn registers_are_what_the_cpu_sets() {
        assert_eq!(runs("LD SM400\nMOV SD520 D0\nEND\n", 1), [(3, 7)]);
    }

    #[test]
    fn iterations_that_are_alike_are_charged_as_if_they_were_run() {
        // FOR, 1000 times LD, MOV and NEXT, then END.
        let alike = "FOR K1000\nLD SM400\nMOV K3 D0\nNEXT\nEND\n";
        assert_eq!(runs(alike, 2), [(3002, 3), (3002, 3)]);
        // Each iteration differs: all are run.
        let counts = "FOR K1000\nLD SM400\nINC D0\nNEXT\nEND\n";
        assert_eq!(runs(counts, 2), [(3002, 1000), (3002, 2000)]);
        // The last iterations are like the ones before, but the first are not.
        let ends = "FOR K100\nLD< D0 K5\nINC D0\nLD= D0 K5\nBREAK D1 P0\nNEXT\nP0\nEND\n";
        let jumped = runs(ends, 1)[0];
        assert_eq!(jumped.1, 5);
        // Loops within loops.
        let nested = "FOR K10\nFOR K10\nLD SM400\nINC D0\nNEXT\nNEXT\nEND\n";
        assert_eq!(runs(nested, 1), [(1 + 10 * (1 + 30 + 1) + 1, 100)]);
        let idle = "FOR K10\nFOR K10\nLD SM400\nMOV K1 D0\nNEXT\nNEXT\nEND\n";
        assert_eq!(runs(idle, 1), [(1 + 10 * (1 + 30 + 1) + 1, 1)]);
    }
}

//! An emulated CPU that repeats scans: runs one real run after the other and reports the time of each, and what it
//! changed. A value from outside is what was set last, and 0 before.

use super::free::{FreeValues, Mode};
use super::machine::Machine;
use super::memory::{Memory, ScanChanges};
use super::outcome::Stopped;
use super::timed::{TimedInputs, TimerMemory};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::timers::{TIME_UNIT, TimerOrCounter};
use scanbound_ir::{
    AreaKind, BitSource, BitTarget, Cell, ChoiceId, ChoiceKey, ChoiceKind, Program, Source,
};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// A CPU that started with cleared memory, and its state after the scans so far.
pub struct Emulated<'p> {
    program: &'p Program,
    times: &'p [Times],
    memory: Memory,
    /// Values of registers that the CPU itself sets, by area and number. A register that is not listed holds 0.
    registers: BTreeMap<(String, u32), u16>,
    /// Whether the next scan is the first.
    first: bool,
    /// Time since power-up at which the next scan begins. Only [`Emulated::set_clock`] changes it.
    now: Picos,
    /// Time since power-up at which the last scan began.
    before: Picos,
    timer_memory: RefCell<TimerMemory>,
    /// The inputs that instructions read directly, by the choices for their values.
    direct_inputs: BTreeMap<ChoiceId, Cell>,
    /// For each running timer of an expiry or an end of time, by its memory cell: the beginning of the scan in which it
    /// started.
    began: BTreeMap<Cell, Picos>,
}

/// The result of one scan of an emulated CPU.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scan {
    /// The sum of the times of all executed instructions.
    pub total: Picos,
    /// The number of executed instructions.
    pub executed: u64,
    /// Where and why the scan stopped early: at an unknown value, at an operation error, at a count that is excluded,
    /// or at the limit of instructions. `None` if it ended normally or at an unbounded loop.
    pub stopped: Option<Stopped>,
    /// The [`Step::Unbounded`](scanbound_ir::Step::Unbounded) at which the scan stopped, because the loop never ends.
    /// `None` if it reached none.
    pub unbounded: Option<usize>,
    /// The cells that the scan read or wrote and that now hold something else than before it, or were not accessed
    /// before.
    pub changed: Vec<Cell>,
}

/// The values of cells and choices at the start of a scan of the emulated CPU.
struct Start<'e, 'p> {
    cpu: &'e Emulated<'p>,
}

impl<'p> Emulated<'p> {
    /// A CPU at power-up with cleared memory. `times` is parallel to `Program::instructions`.
    #[must_use]
    pub fn new(program: &'p Program, times: &'p [Times]) -> Emulated<'p> {
        let (memory, registers) = (Memory::default(), BTreeMap::new());
        let (now, before, timer_memory) = (Picos::ZERO, Picos::ZERO, RefCell::default());
        let (direct_inputs, began) = (direct_inputs(program), BTreeMap::new());
        let mut cpu = Emulated {
            program,
            times,
            memory,
            registers,
            first: true,
            now,
            before,
            timer_memory,
            direct_inputs,
            began,
        };
        cpu.flag_first(true);
        cpu
    }

    /// Sets or clears the bit that is on only in a scan after memory was cleared
    /// ([`PowerUp::after_clear`](scanbound_ir::PowerUp::after_clear)), if it is a bit of a word.
    fn flag_first(&mut self, is_first: bool) {
        if let Some(BitTarget::WordBit(cell, bit)) = self.program.power_up.after_clear {
            let word = self.value(cell);
            let mask = 1 << bit;
            let word = if is_first { word | mask } else { word & !mask };
            self.memory.set(cell, word);
        }
    }

    /// Writes a value into a cell from outside the program.
    pub fn set(&mut self, cell: Cell, value: u16) {
        self.memory.set(cell, value);
    }

    /// Writes a register that the CPU itself maintains, such as its clock.
    pub fn set_register(&mut self, area: &str, index: u32, value: u16) {
        self.registers.insert((area.to_owned(), index), value);
    }

    /// The value that [`Emulated::set_register`] last wrote to a register. `None` if it never wrote one.
    #[must_use]
    pub fn register(&self, area: &str, index: u32) -> Option<u16> {
        self.registers.get(&(area.to_owned(), index)).copied()
    }

    /// The current value of a cell: its initial value if nothing has written it. A value that the scans left unknown is
    /// arbitrary.
    #[must_use]
    pub fn value(&self, cell: Cell) -> u16 {
        let written = self.memory.get(cell).map(|(value, _)| value);
        written.unwrap_or_else(|| self.program.power_up.initial_value(cell))
    }

    /// As [`Emulated::value`]; `None` if the scans left the value unknown.
    #[must_use]
    pub fn known_value(&self, cell: Cell) -> Option<u16> {
        let is_known = self.memory.get(cell).is_none_or(|(_, unknown)| unknown == 0);
        is_known.then(|| self.value(cell))
    }

    /// Sets the time since power-up at which the next scan begins. A scan does not advance it.
    pub fn set_clock(&mut self, now: Picos) {
        self.now = now;
    }

    /// Runs the next scan. It stops after `most` instructions, and where its path depends on an unknown value.
    pub fn scan(&mut self, most: u64) -> Scan {
        let start = Start { cpu: self };
        let machine = Machine::new(self.program, self.times, start, Mode::Real).summing();
        let (total, executed, stopped, unbounded, mut state) = machine.summed(most);
        let changes = ScanChanges::of(&mut state);
        drop(state);
        let changed = self.memory.apply(changes);
        self.note_timers();
        self.before = self.now;
        self.first = false;
        self.flag_first(false);
        Scan { total, executed, stopped, unbounded, changed }
    }

    /// Notes which timers run after a scan, and when they started.
    fn note_timers(&mut self) {
        let timekeeping = &self.program.timekeeping;
        let expiries = timekeeping.expiries.values().map(|expiry| (expiry.memory, expiry.idle));
        let ends = timekeeping.ends.values().map(|&(running, _)| (running, 0));
        for (memory, idle) in expiries.chain(ends) {
            if self.memory.get(memory).is_none_or(|(value, _)| value == idle) {
                self.began.remove(&memory);
            } else {
                self.began.entry(memory).or_insert(self.now);
            }
        }
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

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        let expiries = &self.cpu.program.timekeeping.expiries;
        match self.cpu.direct_inputs.get(&key.choice) {
            Some(&input) => self.cpu.value(input),
            // A timer that may be over with this scan or with the next one is over with the next one.
            None => expiries.get(&key.choice).map_or(0, |expiry| expiry.while_running.into()),
        }
    }

    fn timed(&mut self, timed: &TimerOrCounter, found: &TimedInputs) -> Option<(bool, u16)> {
        let now = self.cpu.now + found.now;
        let found = TimedInputs { now, was_reset: false, ..found.clone() };
        self.cpu.timer_memory.borrow_mut().execute(timed, &found)
    }

    fn simulates_time(&self) -> bool {
        true
    }

    fn ran_for(&mut self, memory: Cell) -> Option<(Picos, Picos)> {
        let began = self.cpu.began.get(&memory).copied().unwrap_or(self.cpu.now);
        let since = self.cpu.now.checked_sub(began).unwrap_or_default();
        Some((since, since))
    }

    fn is_over(&self, choice: ChoiceId) -> Option<bool> {
        let &(running, units) = self.cpu.program.timekeeping.ends.get(&choice)?;
        let time = TIME_UNIT.times(units.into());
        let is_over = |began: &Picos| self.cpu.now.0 - began.0 >= time.0;
        Some(self.cpu.began.get(&running).is_some_and(is_over))
    }

    fn passed(&self) -> Option<u64> {
        Some(self.cpu.now.0 / TIME_UNIT.0 - self.cpu.before.0 / TIME_UNIT.0)
    }

    fn register(&mut self, choice: ChoiceId) -> Option<u16> {
        let (area, index) = self.cpu.program.registers.get(&choice)?;
        Some(self.cpu.register(area, *index).unwrap_or(0))
    }
}

/// The inputs that instructions read directly, by the choices for their values. An instruction that names several
/// inputs counts with the first.
fn direct_inputs(program: &Program) -> BTreeMap<ChoiceId, Cell> {
    let mut found = BTreeMap::new();
    let inputs = &program.power_up.inputs;
    let is_input = |cell: &Cell| inputs.iter().any(|region| region.contains(*cell));
    for instruction in &program.instructions {
        let mut named = instruction.operands.iter().map(|operand| operand.device.cell);
        let Some(input) = named.find(is_input) else { continue };
        instruction.each_read(&mut |source| {
            if let Source::Bit(BitSource::Free(choice)) = source
                && program.kinds.get(&choice) == Some(&ChoiceKind::External)
            {
                found.insert(choice, input);
            }
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_base::facts::Facts;
    use scanbound_front::{Input, Options};
    use scanbound_ir::AreaId;

    /// Runs a program for this number of scans with one nanosecond per instruction. Returns each scan's time in ns and
    /// the value of D0 after it.
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
        // FOR, then 1000 times LD, MOV and NEXT, then END.
        let alike = "FOR K1000\nLD SM400\nMOV K3 D0\nNEXT\nEND\n";
        assert_eq!(runs(alike, 2), [(3002, 3), (3002, 3)]);
        // Every iteration differs, so all are executed.
        let counts = "FOR K1000\nLD SM400\nINC D0\nNEXT\nEND\n";
        assert_eq!(runs(counts, 2), [(3002, 1000), (3002, 2000)]);
        // The last iterations are identical, the first are not.
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

//! An emulated CPU: runs a program scan by scan with a table's times, and keeps the scan times as a CPU does.
//!
//! It scans what [`replay`](scanbound_replay) executes of each instruction, so a test against it is one against the
//! analysis' judge. Timers and counters go by its own clock (`Program::timekeeping`), whose ticks are those of one
//! clock for all: a timer is over up to one tick early, as CPUs are. What comes from outside is 0 unless it is set.

mod memory;

use crate::devices;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::{AreaId, AreaKind, Cell, Program};
use scanbound_link::State;
use scanbound_link::registers::{Register, Registers};
use scanbound_replay::StopReason;
use scanbound_replay::emulated::{Emulated, Scan};

/// Disturbances that make scans longer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Disturbance {
    /// The longest random extension of each scan.
    pub jitter: Picos,
    /// Something that interrupts the program: its duration and its interval.
    pub interrupt: Option<(Picos, Picos)>,
    /// The seed of the random numbers.
    pub seed: u64,
}

/// The most instructions that one scan may execute.
const MAX_INSTRUCTIONS: u64 = 200_000_000;

/// Why the CPU went to STOP by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Halt {
    /// The program's path depends on the result of this instruction, which is unknown.
    Unknown(usize),
    /// The scan does not end: it stays in a loop at this instruction, or executes too many instructions.
    Endless(usize),
}

/// An emulated CPU.
pub struct Cpu<'p> {
    program: &'p Program,
    model: String,
    registers: Option<&'static Registers>,
    /// The overhead of a scan.
    overhead: Picos,
    disturbance: Disturbance,
    random: Pcg64Mcg,
    cpu: Emulated<'p>,
    state: State,
    halted: Option<Halt>,
    /// Time since power-up.
    clock: Picos,
    /// The number of scans so far.
    scans: u64,
    /// The last scan time, the shortest and the longest, as the CPU measured them.
    measured: Option<[Picos; 3]>,
}

impl<'p> Cpu<'p> {
    /// A CPU at power-up. `times` is parallel to the program's instructions. `registers` says where it keeps its scan
    /// times.
    #[must_use]
    pub fn new(
        program: &'p Program,
        times: &'p [Times],
        overhead: Picos,
        registers: Option<&'static Registers>,
        disturbance: Disturbance,
    ) -> Cpu<'p> {
        Cpu {
            program,
            model: program.cpu.clone().unwrap_or_else(|| "EMULATED".to_owned()),
            registers,
            overhead,
            disturbance,
            random: Pcg64Mcg::seed_from_u64(disturbance.seed),
            cpu: Emulated::new(program, times),
            state: State::Run,
            halted: None,
            clock: Picos::ZERO,
            scans: 0,
            measured: None,
        }
    }

    /// Sets the CPU's name, if the program does not name it.
    pub fn call(&mut self, model: &str) {
        if self.program.cpu.is_none() {
            self.model = model.to_owned();
        }
    }

    /// Whether it is in RUN.
    #[must_use]
    pub fn running(&self) -> bool {
        self.state == State::Run
    }

    /// Sets it to RUN or to STOP.
    pub fn switch(&mut self, state: State) {
        self.state = state;
    }

    /// Why it went to STOP by itself.
    #[must_use]
    pub fn halted(&self) -> Option<Halt> {
        self.halted
    }

    /// Time since power-up.
    #[must_use]
    pub fn clock(&self) -> Picos {
        self.clock
    }

    /// The number of scans so far.
    #[must_use]
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// The last scan time, and the shortest and longest since the second scan, as in its registers.
    #[must_use]
    pub fn measured(&self) -> Option<[Picos; 3]> {
        self.measured
    }

    /// Runs a scan and returns its time. `None` if the CPU is in STOP, or goes to STOP.
    pub fn scan(&mut self) -> Option<Picos> {
        if self.state == State::Stop {
            return None;
        }
        self.cpu.set_clock(self.clock);
        let Scan { total, stopped, unbounded, .. } = self.cpu.scan(MAX_INSTRUCTIONS);
        let halt = match (stopped, unbounded) {
            (Some(stopped), _) => Some(match stopped.reason {
                StopReason::Unknown(cause) => Halt::Unknown(cause),
                StopReason::Excluded | StopReason::Error => Halt::Unknown(stopped.at),
                StopReason::TooLong => Halt::Endless(stopped.at),
            }),
            (None, at) => at.map(Halt::Endless),
        };
        if halt.is_some() {
            (self.halted, self.state) = (halt, State::Stop);
            return None;
        }
        let undisturbed = total + self.overhead;
        let time = undisturbed + self.disturbed(undisturbed);
        let end = self.clock + time;
        self.scans += 1;
        self.keep(self.clock, end);
        self.clock = end;
        Some(time)
    }

    /// By how much disturbances make a scan longer.
    fn disturbed(&mut self, time: Picos) -> Picos {
        let jitter = match self.disturbance.jitter.0 {
            0 => 0,
            most => self.random.next_u64() % (most + 1),
        };
        let mut longer = Picos(jitter);
        if let Some((takes, every)) = self.disturbance.interrupt
            && every > takes
        {
            // An interrupt during an earlier one makes the scan longer still.
            let mut come = 0;
            loop {
                let end = self.clock + time + longer;
                let due = end.0 / every.0 - self.clock.0 / every.0;
                if due == come {
                    break;
                }
                longer += takes.times(due - come);
                come = due;
            }
        }
        longer
    }

    /// Writes the scan's time into the CPU's registers: the difference of two readings of a clock with steps.
    fn keep(&mut self, begin: Picos, end: Picos) {
        let Some(registers) = self.registers else { return };
        let step = registers.step.0.max(1);
        let current = Picos((end.0 / step - begin.0 / step) * step);
        // The first scan initialises, so it does not count.
        let [_, least, most] = self.measured.unwrap_or([current; 3]);
        let (least, most) = match self.scans {
            0..=2 => (current, current),
            _ => (least.min(current), most.max(current)),
        };
        self.measured = Some([current, least, most]);
        self.put(registers.current, current);
        for (register, time) in [(registers.least, least), (registers.most, most)] {
            if let Some(register) = register {
                self.put(register, time);
            }
        }
    }

    fn put(&mut self, register: Register, time: Picos) {
        let cell = self.area(register.area).map(|area| Cell { area, index: register.first });
        for (word, at) in register.form.write(time).into_iter().zip(0..) {
            self.cpu.set_register(register.area, register.first + at, word);
            // The program reads the register as a cell.
            if let Some(cell) = cell {
                self.cpu.set(cell.plus(at), word);
            }
        }
    }

    /// The area of that name.
    fn area(&self, name: &str) -> Option<AreaId> {
        devices::area(self.program, name)
    }

    /// The cell of a device as users write it (`X1F`, `D100`). `None` if there is no such device.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<Cell> {
        devices::cell(self.program, name)
    }

    /// Sets a device as users write it, or a bit of a word (`00001`, `HR0107`, `IR0.01`). Returns false if there is
    /// none.
    pub fn set_named(&mut self, name: &str, value: u16) -> bool {
        if let Some((word, bit)) = devices::bit_of_word(self.program, name) {
            let rest = self.value(word) & !(1 << bit);
            self.set(word, rest | (value & 1) << bit);
            return true;
        }
        let cell = self.named(name);
        if let Some(cell) = cell {
            self.set(cell, value);
        }
        cell.is_some()
    }

    /// The value of a device as users write it, or of a bit of a word.
    #[must_use]
    pub fn value_named(&self, name: &str) -> Option<u16> {
        match devices::bit_of_word(self.program, name) {
            Some((word, bit)) => Some(self.value(word) >> bit & 1),
            None => self.named(name).map(|cell| self.value(cell)),
        }
    }

    /// Sets a device from outside, until the program writes it.
    pub fn set(&mut self, cell: Cell, value: u16) {
        let bit = self.program.area(cell.area).kind == AreaKind::Bit;
        self.cpu.set(cell, if bit { value & 1 } else { value });
    }

    /// The value of a cell.
    #[must_use]
    pub fn value(&self, cell: Cell) -> u16 {
        self.cpu.value(cell)
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod timer_tests;

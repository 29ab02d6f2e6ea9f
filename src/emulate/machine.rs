//! The machine: program counter, accumulator, devices, and what happens between its words.

use super::Settings;
use super::clock::Oscillator;
use super::counter::Counter;
use super::filter::Filter;
use super::stimulus::{Change, Stimulus, What};
use crate::dialect::minasec::{Device, WORDS, Word};
use crate::time::Picos;
use std::ops::ControlFlow;

/// The addresses that no store changes.
const INPUTS: u32 = 0xFF;
/// The first address that is more than a latch: T0.
const SPECIAL: u32 = 28;
/// No event is to come.
const NEVER: u64 = u64::MAX;

/// What can be seen of the machine at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct View {
    /// What each device reads as, by its address: inputs as latched, outputs as their latches, relays, timers'
    /// contacts, whether the count equals the setting.
    pub devices: u32,
    /// What the program wrote to T0 (bit 0), T1, C0 and its clear.
    pub coils: u8,
    /// The output terminals.
    pub outputs: u8,
    /// The count.
    pub count: u8,
    /// Whether the program runs: power is on and the reset switch is not.
    pub running: bool,
}

impl View {
    /// What a device reads as.
    #[must_use]
    pub fn device(&self, device: Device) -> bool {
        self.devices >> device.address() & 1 == 1
    }

    /// The latched inputs.
    #[must_use]
    pub fn inputs(&self) -> u8 {
        self.devices as u8
    }
}

/// One scan as it was emulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scan {
    /// When it began.
    pub start: Picos,
    /// How long it took.
    pub time: Picos,
    /// The machine at its end.
    pub view: View,
}

/// Who looks on. Moments come in order.
pub trait Observer {
    /// A scan begins; its inputs are latched.
    fn scan(&mut self, at: Picos, view: View);
    /// Something may have changed.
    fn change(&mut self, at: Picos, view: View);
}

/// Nobody.
impl Observer for () {
    fn scan(&mut self, _at: Picos, _view: View) {}
    fn change(&mut self, _at: Picos, _view: View) {}
}

/// An on-delay timer.
#[derive(Debug, Clone, Copy)]
struct Timer {
    delay: u64,
    coil: bool,
    /// When the contact closes; `NEVER` while the coil is off, and once it has.
    closes: u64,
}

/// The machine with its plant.
#[derive(Debug, Clone)]
pub struct Machine {
    words: [Word; WORDS],
    oscillator: Oscillator,
    periods: [u64; WORDS],
    filter: Filter,
    counter: Counter,
    timers: [Timer; 2],
    devices: u32,
    outputs: u8,
    accumulator: u32,
    /// Changes to inputs and to the board that are still to come, each in order of time.
    inputs: std::vec::IntoIter<Change>,
    board: std::vec::IntoIter<Change>,
    power: bool,
    reset: bool,
    /// Now, in picoseconds.
    now: u64,
}

impl Machine {
    /// A machine that holds a program, with power from the beginning unless the stimulus says otherwise.
    #[must_use]
    pub fn new(words: [Word; WORDS], settings: &Settings, stimulus: &Stimulus) -> Machine {
        let oscillator = Oscillator::new(&settings.clock);
        let timer = |delay: Picos| Timer { delay: delay.0, coil: false, closes: NEVER };
        let (inputs, board): (Vec<Change>, Vec<Change>) =
            stimulus.changes.iter().partition(|change| matches!(change.what, What::Input(_)));
        let mut machine = Machine {
            words,
            periods: [oscillator.period; WORDS],
            oscillator,
            filter: Filter::new(settings.filter.0),
            counter: Counter::new(settings.count, settings.setting),
            timers: [timer(settings.t0), timer(settings.t1)],
            devices: 0,
            outputs: 0,
            accumulator: 0,
            inputs: inputs.into_iter(),
            board: board.into_iter(),
            power: true,
            reset: false,
            now: 0,
        };
        machine.show_count();
        machine
    }

    /// The time.
    #[must_use]
    pub fn now(&self) -> Picos {
        Picos(self.now)
    }

    /// The board's period: that of each word, or around which the periods tremble.
    #[must_use]
    pub fn period(&self) -> Picos {
        Picos(self.oscillator.period)
    }

    /// What can be seen of it.
    #[must_use]
    pub fn view(&self) -> View {
        View {
            devices: self.devices,
            coils: u8::from(self.timers[0].coil)
                | u8::from(self.timers[1].coil) << 1
                | u8::from(self.counter.clock) << 2
                | u8::from(self.counter.clear) << 3,
            outputs: self.outputs,
            count: self.counter.count,
            running: self.running(),
        }
    }

    /// Runs to the end of the next scan that is not cut off. `None` if the machine stays without power, or
    /// in reset.
    pub fn scan(&mut self, observer: &mut impl Observer) -> Option<Scan> {
        loop {
            self.board_until(self.now, observer);
            while !self.running() {
                let next = self.board.as_slice().first()?.at.0;
                self.now = self.now.max(next);
                self.board_until(self.now, observer);
            }
            if let Some(scan) = self.run(observer) {
                return Some(scan);
            }
        }
    }

    /// One scan from now on, unless it is cut off.
    fn run(&mut self, observer: &mut impl Observer) -> Option<Scan> {
        let start = self.now;
        while let Some(&Change { at, what: What::Input(input), on }) =
            self.inputs.as_slice().first().filter(|change| change.at.0 <= start)
        {
            self.filter.apply(at.0, input, on);
            self.inputs.next();
        }
        self.devices = self.devices & !INPUTS | u32::from(self.filter.pass(start));
        observer.scan(Picos(start), self.view());
        if !self.oscillator.is_steady() {
            self.oscillator.periods(&mut self.periods);
        }
        let mut begun = start;
        let mut event = self.next_event();
        for index in 0..WORDS {
            let (word, period) = (self.words[index], self.periods[index]);
            let edge = begun + period / 2;
            begun += period;
            if edge >= event {
                if self.events_until(edge, observer).is_break() {
                    return None;
                }
                event = self.next_event();
            }
            let bits = u32::from(word.0);
            let address = bits & 0x1F;
            if bits < 0xC0 {
                // The logic unit as the description's formula has it, less the case of a store.
                let input = (self.devices >> address ^ bits >> 5) & 1;
                let (is_or, is_and) = (bits >> 7, bits >> 6 & 1);
                let accumulator = self.accumulator;
                self.accumulator = input & ((is_and ^ 1) | accumulator) | is_or & accumulator;
            } else {
                let value = (self.accumulator ^ bits >> 5) & 1;
                if address < SPECIAL {
                    // An input has no latch.
                    let latch = 1 << address & !INPUTS;
                    self.devices = self.devices & !latch | value << address & latch;
                } else {
                    self.store(address - SPECIAL, value == 1, edge);
                    event = self.next_event();
                }
                observer.change(Picos(edge), self.view());
            }
        }
        if begun >= event && self.events_until(begun, observer).is_break() {
            return None;
        }
        self.now = begun;
        self.outputs = (self.devices >> 8) as u8;
        observer.change(Picos(begun), self.view());
        Some(Scan { start: Picos(start), time: Picos(begun - start), view: self.view() })
    }

    /// Writes to T0, T1, C0 or its clear.
    fn store(&mut self, which: u32, on: bool, at: u64) {
        match which {
            0 | 1 => {
                let timer = &mut self.timers[which as usize];
                if on && !timer.coil {
                    timer.closes = at.saturating_add(timer.delay);
                } else if !on {
                    timer.closes = NEVER;
                    self.devices &= !(1 << (SPECIAL + which));
                }
                timer.coil = on;
            }
            2 => self.counter.set_clock(on),
            _ => self.counter.set_clear(on),
        }
        self.show_count();
    }

    fn show_count(&mut self) {
        let bit = 1 << Device::C0.address();
        self.devices =
            self.devices & !bit | u32::from(self.counter.matches()) << Device::C0.address();
    }

    fn running(&self) -> bool {
        self.power && !self.reset
    }

    /// When something next happens that no word does.
    fn next_event(&self) -> u64 {
        let board = self.board.as_slice().first().map_or(NEVER, |change| change.at.0);
        board.min(self.timers[0].closes).min(self.timers[1].closes)
    }

    /// What happens until then, in order. Breaks if the scan is cut off.
    fn events_until(&mut self, until: u64, observer: &mut impl Observer) -> ControlFlow<()> {
        loop {
            let at = self.next_event();
            if at > until || at == NEVER {
                return ControlFlow::Continue(());
            }
            for (which, timer) in self.timers.iter_mut().enumerate() {
                if timer.closes <= at {
                    timer.closes = NEVER;
                    self.devices |= 1 << (SPECIAL + which as u32);
                }
            }
            observer.change(Picos(at), self.view());
            self.board_until(at, observer);
            if !self.running() {
                self.now = at;
                return ControlFlow::Break(());
            }
        }
    }

    /// What happens to the board until then.
    fn board_until(&mut self, until: u64, observer: &mut impl Observer) {
        while let Some(&change) =
            self.board.as_slice().first().filter(|change| change.at.0 <= until)
        {
            self.board.next();
            match change.what {
                What::Power => self.power = change.on,
                What::Reset => self.reset = change.on,
                What::ClearCount => self.counter.press(change.on),
                What::Input(_) => {}
            }
            if !self.running() {
                self.stop();
            }
            self.show_count();
            observer.change(change.at, self.view());
        }
    }

    /// Everything but the count begins at 0 again.
    fn stop(&mut self) {
        self.devices = 0;
        self.outputs = 0;
        self.accumulator = 0;
        for timer in &mut self.timers {
            (timer.coil, timer.closes) = (false, NEVER);
        }
        self.counter.reset();
    }
}

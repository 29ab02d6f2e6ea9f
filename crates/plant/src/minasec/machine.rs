//! The machine: program counter, accumulator, devices, and the events between its words.

use super::Settings;
use super::clock::{Clock, Oscillator};
use super::counter::Counter;
use super::filter::Filter;
use super::stimulus::{Change, Stimulus, What};
use scanbound_base::time::Picos;
use scanbound_front_minasec::{Device, WORDS, Word};

/// The addresses of inputs, which no store changes.
const INPUTS: u32 = 0xFF;
/// The first address that is not just a latch: T0.
const SPECIAL: u32 = 28;
/// The time of an event that never occurs.
const NEVER: u64 = u64::MAX;

/// The visible state of the machine at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct View {
    /// The value of each device by its address: latched inputs, output latches, relays, timer contacts, whether the
    /// count equals the setting.
    pub devices: u32,
    /// The values written to T0 (bit 0), T1, C0 and C0's clear input.
    pub coils: u8,
    /// The output terminals.
    pub outputs: u8,
    /// The count.
    pub count: u8,
    /// Whether the program runs: power is on, and the switch is on neither RESET nor HALT.
    pub running: bool,
}

impl View {
    /// The value of a device.
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

/// One emulated scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scan {
    /// When it began.
    pub start: Picos,
    /// How long it took.
    pub time: Picos,
    /// The machine at its end.
    pub view: View,
    /// Whether the clock stood still during it. Then its time is not a scan time.
    pub held: bool,
}

/// What events did to the clock and the scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Went {
    /// The clock continues.
    On,
    /// The scan was aborted.
    Off,
    /// The clock stopped or changed its speed at that moment.
    Over(u64),
}

/// An observer of the machine. It is called in the order of time.
pub trait Observer {
    /// A scan begins, and its inputs are latched.
    fn scan(&mut self, at: Picos, view: View);
    /// Something may have changed.
    fn change(&mut self, at: Picos, view: View);
}

/// No observer.
impl Observer for () {
    fn scan(&mut self, _at: Picos, _view: View) {}
    fn change(&mut self, _at: Picos, _view: View) {}
}

/// An on-delay timer.
#[derive(Debug, Clone, Copy)]
struct Timer {
    delay: u64,
    coil: bool,
    /// When the contact closes. `NEVER` while the coil is off, and after the contact has closed.
    closes: u64,
}

/// The machine, with the changes that the plant makes.
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
    /// Future changes of inputs and of the board, each in the order of time.
    inputs: std::vec::IntoIter<Change>,
    board: std::vec::IntoIter<Change>,
    power: bool,
    reset: bool,
    halt: bool,
    /// The clock's button.
    button: bool,
    clock: Clock,
    /// Whether the clock stood still during this scan.
    held: bool,
    /// Now, in picoseconds.
    now: u64,
}

impl Machine {
    /// A machine with this program. Power is on from the beginning unless the stimulus says otherwise.
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
            halt: false,
            button: false,
            clock: settings.clock.clone(),
            held: false,
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

    /// The board's period: that of each word, or their mean if there is jitter.
    #[must_use]
    pub fn period(&self) -> Picos {
        Picos(self.oscillator.period)
    }

    /// Its visible state.
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
            running: self.running() && !self.halt,
        }
    }

    /// Runs to the end of the next scan that is not aborted. `None` if the machine stays without power, in reset or
    /// halted.
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
            if self.running() && self.halt {
                return None;
            }
        }
    }

    /// Runs one scan. `None` if it is aborted.
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
        let (mut index, mut begun) = (0, start);
        self.held = self.halt;
        if self.halt {
            (index, begun) = self.hold(index, start, observer)?;
        }
        let mut event = self.next_event();
        while index < WORDS {
            let period = self.periods[index];
            let edge = begun + period / 2;
            if edge >= event {
                match self.events_until(edge, observer) {
                    Went::On => {}
                    Went::Off => return None,
                    Went::Over(at) => {
                        // The current word starts again when the clock does.
                        (index, begun) = self.hold(index, at, observer)?;
                        event = self.next_event();
                        continue;
                    }
                }
                event = self.next_event();
            }
            begun += period;
            if self.execute(index, edge, observer) {
                event = self.next_event();
            }
            index += 1;
        }
        if begun >= event {
            match self.events_until(begun, observer) {
                Went::On => {}
                Went::Off => return None,
                // The last word is done: the scan ends with this clock cycle.
                Went::Over(at) => begun = at,
            }
        }
        self.now = begun;
        self.outputs = (self.devices >> 8) as u8;
        observer.change(Picos(begun), self.view());
        let (time, view, held) = (Picos(begun - start), self.view(), self.held);
        Some(Scan { start: Picos(start), time, view, held })
    }

    /// Waits while the clock stands still. Pressing the button executes a word, releasing it moves on to the next.
    /// Returns the word and the time at which the clock continues, or `None` if it does not.
    fn hold(
        &mut self,
        mut index: usize,
        mut at: u64,
        observer: &mut impl Observer,
    ) -> Option<(usize, u64)> {
        let mut high = false;
        while self.halt && index < WORDS {
            self.held = true;
            self.board.as_slice().first()?;
            at = self.next_event();
            let before = self.button;
            if self.events_until(at, observer) == Went::Off {
                return None;
            }
            if self.halt && self.button && !before {
                self.execute(index, at, observer);
                high = true;
            } else if high && !(self.halt && self.button) {
                (index, high) = (index + 1, false);
            }
        }
        Some((index, at))
    }

    /// Executes a word at the edge of its clock. Returns whether it was a store that may change the time of future
    /// events.
    fn execute(&mut self, index: usize, edge: u64, observer: &mut impl Observer) -> bool {
        let word = self.words[index];
        let mut moved = false;
        let bits = u32::from(word.0);
        let address = bits & 0x1F;
        if bits < 0xC0 {
            // The formula of the logic unit in the machine's description, except for stores.
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
                moved = true;
            }
            observer.change(Picos(edge), self.view());
        }
        moved
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

    /// The time of the next event that is not caused by a word.
    fn next_event(&self) -> u64 {
        let board = self.board.as_slice().first().map_or(NEVER, |change| change.at.0);
        board.min(self.timers[0].closes).min(self.timers[1].closes)
    }

    /// Processes events in order up to this time, or until the clock changes.
    fn events_until(&mut self, until: u64, observer: &mut impl Observer) -> Went {
        loop {
            let at = self.next_event();
            if at > until || at == NEVER {
                return Went::On;
            }
            for (which, timer) in self.timers.iter_mut().enumerate() {
                if timer.closes <= at {
                    timer.closes = NEVER;
                    self.devices |= 1 << (SPECIAL + which as u32);
                }
            }
            observer.change(Picos(at), self.view());
            let clock = (self.halt, self.clock.slow);
            self.board_until(at, observer);
            if !self.running() {
                self.now = at;
                return Went::Off;
            }
            if clock != (self.halt, self.clock.slow) {
                return Went::Over(at);
            }
        }
    }

    /// Processes changes of the board up to this time.
    fn board_until(&mut self, until: u64, observer: &mut impl Observer) {
        while let Some(&change) =
            self.board.as_slice().first().filter(|change| change.at.0 <= until)
        {
            self.board.next();
            match change.what {
                What::Power => self.power = change.on,
                What::Reset => self.reset = change.on,
                What::Halt => self.halt = change.on,
                What::Step => self.button = change.on,
                What::Slow => self.run_slow(change.on),
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

    /// Switches the clock's speed. The board's clock keeps its tolerance.
    fn run_slow(&mut self, slow: bool) {
        if self.clock.slow != slow {
            self.clock.slow = slow;
            self.oscillator = Oscillator::new(&self.clock);
            self.periods = [self.oscillator.period; WORDS];
            if !self.oscillator.is_steady() {
                self.oscillator.periods(&mut self.periods);
            }
        }
    }

    /// Stops the machine: everything but the count is set to 0.
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

//! Runs any program scan by scan from power-up, as a table times it, and records what its devices and variables do.
//!
//! Each scan is a real run of [`replay`](scanbound_replay), as are the scans that an audit shows. What comes from
//! outside is what the stimulus sets, and 0 before; what the standard leaves to the controller is done as the standard
//! prefers.

pub mod recording;
pub mod signals;
pub mod vcd;

use crate::stimulus::{Form, read};
use recording::{End, Recording, Scan};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::{Cell, Program};
use scanbound_replay::StopReason;
use scanbound_replay::emulated::Emulated;
use signals::{Place, Signal, Signals, Value};
use std::collections::BTreeMap;

/// The most instructions that one scan may execute.
const MAX_INSTRUCTIONS: u64 = 20_000_000;

/// The form of a stimulus, for messages.
const FORM: &str = "the first row names the columns: the time with its unit (time_ms), and devices or variables of the program; each other row holds a time, and a value for each that is set then: 0 or 1, a number, or the milliseconds of a time";

/// A value that is set from outside before the first scan that begins at this time or later.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// The time since power-up.
    pub at: Picos,
    /// Where the value is set.
    pub place: Place,
    /// The words of the value, low word first.
    pub words: Vec<u16>,
}

/// Reads a stimulus: a CSV with a column for the time, and one for each device or variable that is set.
///
/// # Errors
/// All faults, each with its line.
pub fn stimulus(
    signals: &Signals<'_>,
    name: &str,
    bytes: &[u8],
) -> Result<Vec<Change>, Vec<Diagnostic>> {
    let column = |word: &str| {
        let signal = signals.named(word);
        signal.ok_or_else(|| format!("the program has no device or variable '{word}'"))
    };
    let value = |signal: &Signal, text: &str| {
        let words = signal.place.parse(text);
        words.ok_or_else(|| format!("'{text}' is not a value of {}", signal.name))
    };
    let form = Form { help: FORM, column: &column, value: &value };
    let change =
        |(at, signal, words): (Picos, Signal, Vec<u16>)| Change { at, place: signal.place, words };
    Ok(read(name, bytes, &form)?.into_iter().map(change).collect())
}

/// How long a simulation goes on.
#[derive(Debug, Clone, Copy)]
pub struct Length {
    /// The largest number of scans.
    pub scans: u64,
    /// No scan begins at this time or later.
    pub end: Option<Picos>,
}

/// Runs a program from power-up and records its signals: the watched ones, or all that change if none are named.
/// `times` is parallel to the program's instructions; each scan takes `overhead` in addition.
#[must_use]
pub fn simulate(
    program: &Program,
    (times, overhead): (&[Times], Picos),
    signals: &Signals<'_>,
    watched: &[Signal],
    stimulus: &[Change],
    length: Length,
) -> Recording {
    let mut cpu = Emulated::new(program, times);
    let mut recorder = Recorder::new(signals, watched, &cpu);
    let mut clock = Picos::ZERO;
    // A cyclic task begins a scan at each interval.
    let interval = program.interval.filter(|one| one.0 > 0);
    let mut rest = stimulus;
    while (recorder.recording.scans.len() as u64) < length.scans
        && length.end.is_none_or(|end| clock < end)
    {
        let due = rest.partition_point(|change| change.at <= clock);
        let (now, later) = rest.split_at(due);
        rest = later;
        for change in now {
            set(&mut cpu, change);
        }
        let before = recorder.changes(now.iter().flat_map(|change| change.place.cells()), &cpu);
        cpu.set_clock(clock);
        let scan = cpu.scan(MAX_INSTRUCTIONS);
        let stopped = scan.stopped.as_ref().map(|stopped| match stopped.reason {
            StopReason::Unknown(cause) => End::Unknown(cause),
            StopReason::Excluded | StopReason::Error => End::Error(stopped.at),
            StopReason::TooLong => End::Endless(stopped.at),
        });
        recorder.recording.end = stopped.or(scan.unbounded.map(End::Endless));
        if recorder.recording.end.is_some() {
            break;
        }
        let after = recorder.changes(scan.changed.into_iter(), &cpu);
        let time = scan.total + overhead;
        recorder.recording.scans.push(Scan { start: clock, time, before, after });
        clock += time;
        if let Some(interval) = interval {
            clock = Picos(clock.0.next_multiple_of(interval.0));
        }
    }
    recorder.recording
}

/// Sets a value from outside.
fn set(cpu: &mut Emulated<'_>, change: &Change) {
    for (cell, &word) in change.place.cells().zip(&change.words) {
        let word = match change.place {
            Place::WordBit(_, bit) => cpu.value(cell) & !(1 << bit) | (word & 1) << bit,
            Place::Bit(_) | Place::Words(..) => word,
        };
        cpu.set(cell, word);
    }
}

/// Notes which signals change.
struct Recorder<'s, 'p> {
    signals: &'s Signals<'p>,
    recording: Recording,
    /// The number of the signal at a place.
    numbers: BTreeMap<Place, usize>,
    /// Whether signals are added to the recording when they change.
    is_open: bool,
    /// The signals to which each cell belongs.
    known: BTreeMap<Cell, Vec<Signal>>,
    /// The current values of the signals.
    values: Vec<Value>,
}

impl<'s, 'p> Recorder<'s, 'p> {
    fn new(signals: &'s Signals<'p>, watched: &[Signal], cpu: &Emulated<'_>) -> Recorder<'s, 'p> {
        let mut recorder = Recorder {
            signals,
            recording: Recording::default(),
            numbers: BTreeMap::new(),
            is_open: watched.is_empty(),
            known: BTreeMap::new(),
            values: Vec::new(),
        };
        for signal in watched {
            let value = signal.place.value(|cell| cpu.known_value(cell));
            recorder.add(signal, value);
        }
        recorder
    }

    /// Adds a signal with its value at power-up.
    fn add(&mut self, signal: &Signal, first: Value) -> usize {
        let number = self.values.len();
        self.numbers.insert(signal.place, number);
        self.values.push(first);
        self.recording.signals.push((signal.clone(), first));
        number
    }

    /// The signals among these cells whose values differ from those last noted.
    fn changes(
        &mut self,
        cells: impl Iterator<Item = Cell>,
        cpu: &Emulated<'_>,
    ) -> Vec<(usize, Value)> {
        let mut found = Vec::new();
        for cell in cells {
            let known = self.known.entry(cell).or_insert_with(|| self.signals.of_cell(cell));
            for signal in known.clone() {
                let value = signal.place.value(|cell| cpu.known_value(cell));
                let number = match self.numbers.get(&signal.place) {
                    Some(&number) => number,
                    None if self.is_open => {
                        let first = signal.place.value(|cell| self.signals.initial_value(cell));
                        if value == first || value == Value::Unknown {
                            continue;
                        }
                        self.add(&signal, first)
                    }
                    None => continue,
                };
                if self.values[number] != value {
                    self.values[number] = value;
                    found.push((number, value));
                }
            }
        }
        found.sort_by_key(|(number, _)| *number);
        found
    }
}

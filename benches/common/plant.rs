//! Writes plant programs of any size: stations, each with its step word, relays, interlocks and alarms, under shared
//! modes.
//!
//! The programs behave like real projects as far as the search is concerned: nearly all charges hang together
//! through the mode bits, run flags and neighbours' handshakes, while conflicts are local to a station. One
//! station has about 2,100 instructions, of which some 90 are worth telling on from off.

use std::fmt::Write;

/// A small generator of numbers with a fixed algorithm (xorshift), so that a seed names a program for good.
pub struct Numbers(u64);

impl Numbers {
    /// A generator for a seed.
    pub fn new(seed: u64) -> Self {
        Numbers(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// A number below `limit`.
    pub fn below(&mut self, limit: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 33) % u64::from(limit)) as u32
    }

    fn one_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }
}

/// The list text of one file a station, each ending with END. File 0 holds the modes besides its station.
pub fn plant(stations: u32, seed: u64) -> Vec<String> {
    let mut numbers = Numbers::new(seed);
    (0..stations)
        .map(|station| {
            let mut text = String::new();
            if station == 0 {
                modes(&mut text);
            }
            Station { index: station, of: stations, numbers: &mut numbers, text: &mut text }
                .write();
            text.push_str("END\n");
            text
        })
        .collect()
}

/// Automatic, manual, run, emergency stop, cycle counters: shared by all stations.
fn modes(text: &mut String) {
    text.push_str(
        "LD X0\nANI X1\nAND X2\nOUT M0\n\
         LD X1\nANI X0\nAND X2\nOUT M1\n\
         LD X3\nOR M2\nANI X4\nAND X2\nAND M0\nOUT M2\n\
         LDI X2\nOUT M3\n\
         LDP X5\nINCP D0\n\
         LD> D0 K9999\nMOVP K0 D0\n",
    );
}

struct Station<'a> {
    index: u32,
    of: u32,
    numbers: &'a mut Numbers,
    text: &'a mut String,
}

const STEPS: u32 = 18;

impl Station<'_> {
    fn write(mut self) {
        self.sequence();
        self.step_relays();
        for axis in 0..6 {
            self.axis(axis);
        }
        self.alarms();
        self.recipe();
        self.lamps();
    }

    /// A number below a limit.
    fn below(&mut self, limit: u32) -> u32 {
        self.numbers.below(limit)
    }

    /// Some relay of the station's.
    fn some_m(&mut self, from: u32, limit: u32) -> String {
        let n = from + self.below(limit);
        self.m(n)
    }

    /// Some input of the station's.
    fn some_x(&mut self, limit: u32) -> String {
        let n = self.below(limit);
        self.x(n)
    }

    fn line(&mut self, text: std::fmt::Arguments<'_>) {
        self.text.write_fmt(text).expect("writing to a string");
        self.text.push('\n');
    }

    /// First word of the station's data, relay of its relays, input of its inputs, output of its outputs.
    fn d(&self, n: u32) -> String {
        format!("D{}", 1000 + 200 * self.index + n)
    }
    fn m(&self, n: u32) -> String {
        format!("M{}", 1000 + 400 * self.index + n)
    }
    fn x(&self, n: u32) -> String {
        format!("X{:X}", 0x100 + 0x70 * self.index + n)
    }
    fn y(&self, n: u32) -> String {
        format!("Y{:X}", 0x100 + 0x70 * self.index + n)
    }
    fn neighbour(&self) -> String {
        format!("M{}", 1000 + 400 * ((self.index + 1) % self.of) + 390)
    }

    /// The step word: each step waits for its inputs and moves on; some branch, the last goes home.
    fn sequence(&mut self) {
        let word = self.d(0);
        self.line(format_args!("LD M3\nMOVP K0 {word}"));
        for step in 0..STEPS {
            let here = 10 * step;
            let next = if step + 1 == STEPS { 0 } else { here + 10 };
            let (sensor, fault) = (self.x(step), self.m(399));
            self.line(format_args!("LD= {word} K{here}\nAND {sensor}\nANI {fault}\nAND M2"));
            if self.numbers.one_in(4) {
                let handshake = self.neighbour();
                self.line(format_args!("AND {handshake}"));
            }
            self.line(format_args!("MOV K{next} {word}"));
            if self.numbers.one_in(3) {
                let (from, to) = (self.d(20 + step), self.d(60 + step));
                let count = 4 + self.numbers.below(12);
                self.line(format_args!("LD= {word} K{here}\nAND M0\nBMOV {from} {to} K{count}"));
            }
            if self.numbers.one_in(3) {
                let (a, b, sum) = (self.d(100), self.d(102), self.d(104));
                self.line(format_args!(
                    "LD= {word} K{here}\nAND {sensor}\nD* {a} {b} {sum}\nD+ {a} {b} {a}"
                ));
            }
        }
        let (ready, last) = (self.m(390), 10 * (STEPS - 1));
        self.line(format_args!("LD= {word} K{last}\nAND M2\nOUT {ready}"));
        self.line(format_args!("LD> {word} K50\nAND<= {word} K120\nFMOV K0 {} K8", self.d(150)));
    }

    /// A second, smaller sequence on set and reset relays.
    fn step_relays(&mut self) {
        let count = 6 + self.numbers.below(4);
        let first = self.m(0);
        let mut idle = format!("LDI {first}");
        for relay in 1..count {
            let _ = write!(idle, "\nANI {}", self.m(relay));
        }
        self.line(format_args!("{idle}\nAND M2\nSET {first}"));
        for relay in 0..count {
            let (here, next, sensor) =
                (self.m(relay), self.m((relay + 1) % count), self.x(20 + relay));
            self.line(format_args!("LD {here}\nAND {sensor}\nAND M2\nSET {next}\nRST {here}"));
            let (a, b) = (self.d(110 + relay), self.d(130));
            self.line(format_args!(
                "LD {here}\nAND M0\n* {a} K{} {b}\nDMOV {b} {}",
                2 + relay,
                self.d(132)
            ));
        }
    }

    /// One axis: forward and backward drives that lock each other out, in automatic and manual mode.
    fn axis(&mut self, axis: u32) {
        let base = 40 + 40 * axis;
        let word = self.d(0);
        let (forward, backward) = (self.y(2 * axis), self.y(2 * axis + 1));
        let (end, home, plus, minus) = (
            self.x(40 + 8 * axis),
            self.x(41 + 8 * axis),
            self.x(42 + 8 * axis),
            self.x(43 + 8 * axis),
        );
        let (go, back) = (10 * (1 + 2 * axis), 10 * (2 + 2 * axis));
        let fault = self.m(399);
        self.line(format_args!("LD= {word} K{go}\nAND M0\nLD M1\nAND {plus}\nORB\nANI {end}\nANI {backward}\nANI {fault}\nOUT {forward}"));
        self.line(format_args!("LD= {word} K{back}\nAND M0\nLD M1\nAND {minus}\nORB\nANI {home}\nANI {forward}\nANI {fault}\nOUT {backward}"));
        let timer = format!("T{}", 100 + 10 * self.index + axis);
        self.line(format_args!(
            "LD {forward}\nOR {backward}\nOUT {timer} K50\nLD {timer}\nSET {}",
            self.m(380 + axis)
        ));
        self.line(format_args!(
            "LD {forward}\nMOV K{} {}\nLD {backward}\nMOV K-{} {}",
            500 + axis,
            self.d(160 + axis),
            500 + axis,
            self.d(160 + axis)
        ));
        // The many small relays of a real axis: enable chains, memories, lamps.
        for relay in 0..24 {
            let (out, a, b) = (self.m(base + relay), self.some_x(96), self.some_m(base, 40));
            let mode = self.below(3);
            let c = self.some_m(0, 300);
            self.line(format_args!(
                "LD {a}\nOR {b}\nANI {c}\nLD M{mode}\nORI {fault}\nANB\nOUT {out}"
            ));
        }
    }

    /// Alarms: each latches, is counted, and stops the station.
    fn alarms(&mut self) {
        let reset = self.x(100);
        for alarm in 0..30 {
            let (latch, cause, other) =
                (self.m(340 + alarm), self.some_x(96), self.some_m(40, 240));
            self.line(format_args!(
                "LD {cause}\nANI {other}\nAND M2\nSET {latch}\nLD {reset}\nRST {latch}"
            ));
        }
        let word = self.d(170);
        self.line(format_args!("LD M3\nOR {}\nOUT {}", self.m(340), self.m(399)));
        self.line(format_args!(
            "LDP {}\nMOVP K4{} {word}\nINCP {}",
            self.m(341),
            self.m(340),
            self.d(171)
        ));
    }

    /// Recipe selection by a word: exactly one of eight blocks is moved.
    fn recipe(&mut self) {
        let select = self.d(180);
        for recipe in 0..8 {
            let (from, to) = (format!("D{}", 500 + 10 * recipe), self.d(182));
            self.line(format_args!(
                "LD= {select} K{recipe}\nAND M0\nANI M2\nBMOV {from} {to} K{}",
                2 + recipe
            ));
        }
    }

    /// Lamps and outputs: many contacts, no application instruction.
    fn lamps(&mut self) {
        for lamp in 0..40 {
            let (a, b, c) = (self.some_m(0, 380), self.some_m(0, 380), self.some_x(100));
            let y = self.y(20 + lamp);
            self.line(format_args!("LD {a}\nANI {b}\nLD {c}\nAND M0\nORB\nANI M3\nMPS\nAND {a}\nOUT {y}\nMPP\nANI {c}\nOUT {}", self.m(300 + lamp)));
        }
    }
}

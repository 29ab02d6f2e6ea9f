//! Writes programs that are hard for their size: small stations whose relays meet in conditions all over the program.
//!
//! Sequencers on step words and on relays, interlocked drives, alarms, recipes, manual operation, jumps and
//! master controls, tied together by an automatic, a manual, a stop and a run bit; and relays computed from any
//! earlier relays, so that conflicts reach across the whole program. Every application instruction has times of
//! its own, over three orders of magnitude.

use super::plant::Numbers;
use std::fmt::Write;

/// A program as list text, and its timing table.
pub fn pools(applications: u32, seed: u64) -> (String, String) {
    let mut writer = Writer {
        numbers: Numbers::new(seed),
        text: "LD X3\nOR M0\nANI X2\nAND X0\nOUT M0\n".to_owned(),
        table: "instruction,on_us,off_us\n".to_owned(),
        applications: 0,
        relays: 100,
        inputs: 16,
        outputs: 0,
        words: 100,
        pool: Vec::new(),
    };
    while writer.applications < applications {
        writer.part();
    }
    writer.text.push_str("END\n");
    writer.table.push_str(
        "OUT,0.034,0.034\nMOV,0.08,0.03\nSET,0.034,0.02\nRST,0.034,0.02\nCJ,1.2,0.06\nEND,50,50\n",
    );
    let contacts = "LD LDI AND ANI OR ORI LDP LDF LD= LD> AND<> ORB MPS MRD MPP MC MCR";
    for contact in contacts.split(' ') {
        let _ = writeln!(writer.table, "{contact},0.02,0.02");
    }
    (writer.text, writer.table)
}

struct Writer {
    numbers: Numbers,
    text: String,
    table: String,
    applications: u32,
    relays: u32,
    inputs: u32,
    outputs: u32,
    words: u32,
    /// Relays and outputs that conditions may use.
    pool: Vec<String>,
}

impl Writer {
    fn part(&mut self) {
        match self.numbers.below(12) {
            0 | 1 => self.step_word(),
            2 => self.step_relays(),
            3 => self.interlock(),
            4 => self.alarms(),
            5 => self.recipe(),
            6 => self.manual(),
            7 | 8 => self.logic(),
            9 => self.edges(),
            10 => self.jump(),
            _ => self.master(),
        }
    }

    fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn relay(&mut self) -> String {
        self.relays += 1;
        format!("M{}", self.relays)
    }

    fn input(&mut self) -> String {
        self.inputs += 1;
        format!("X{:X}", self.inputs)
    }

    fn output(&mut self) -> String {
        self.outputs += 1;
        format!("Y{:X}", self.outputs)
    }

    fn pooled(&mut self) -> String {
        let place = self.numbers.below(self.pool.len() as u32);
        self.pool[place as usize].clone()
    }

    /// An application instruction with times of its own, in nanoseconds.
    fn application(&mut self, operand: &str) {
        let name = format!("FB{}", self.applications);
        self.applications += 1;
        let on = match self.numbers.below(3) {
            0 => 800 + self.numbers.below(4_200),
            1 => 5_000 + self.numbers.below(55_000),
            _ => 60_000 + self.numbers.below(340_000),
        };
        let off = if self.numbers.below(3) == 0 { 40 } else { 0 };
        let us = |ns: u32| format!("{}.{:03}", ns / 1000, ns % 1000);
        let _ = writeln!(self.table, "{name},{},{}", us(on), us(off));
        self.line(&format!("{name} {operand}"));
    }

    fn perhaps(&mut self, percent: u32, text: &str) {
        if self.numbers.below(100) < percent {
            self.line(text);
        }
    }

    fn step_word(&mut self) {
        let steps = 4 + self.numbers.below(17);
        self.words += 1;
        let word = format!("D{}", self.words);
        for step in 0..steps {
            if self.numbers.below(2) == 0 {
                let input = self.input();
                self.line(&format!("LD= {word} K{}\nAND {input}", 10 * step));
                self.perhaps(50, "AND M0");
                self.line(&format!("MOV K{} {word}", 10 * (step + 1) % (10 * steps)));
            }
        }
        for step in 0..steps {
            self.line(&format!("LD= {word} K{}", 10 * step));
            self.perhaps(50, "AND M0");
            self.application("D9000");
        }
        if self.numbers.below(2) == 0 {
            let (half, last) = (10 * (steps / 2), 10 * (steps - 1));
            self.line(&format!("LD> {word} K{half}\nAND<> {word} K{last}"));
            self.application("D9001");
        }
    }

    fn step_relays(&mut self) {
        let relays: Vec<String> = (0..4 + self.numbers.below(11)).map(|_| self.relay()).collect();
        self.line(&format!("LDI {}\nANI {}", relays[0], relays[1..].join("\nANI ")));
        self.line(&format!("AND M0\nSET {}", relays[0]));
        for (at, here) in relays.iter().enumerate() {
            let (input, next) = (self.input(), &relays[(at + 1) % relays.len()]);
            self.line(&format!("LD {here}\nAND {input}"));
            self.perhaps(50, "AND M0");
            self.line(&format!("SET {next}\nRST {here}"));
        }
        for here in &relays {
            self.line(&format!("LD {here}"));
            self.perhaps(70, "AND M0");
            self.application("D9002");
        }
        self.pool.extend(relays);
    }

    fn interlock(&mut self) {
        let (forward, backward) = (self.output(), self.output());
        for (this, other) in [(&forward, &backward), (&backward, &forward)] {
            let button = self.input();
            self.line(&format!("LD {button}\nOR {this}\nANI {other}\nANI X2\nOUT {this}"));
        }
        for drive in [&forward, &backward] {
            self.line(&format!("LD {drive}"));
            self.application("D9003");
        }
        self.pool.extend([forward, backward]);
    }

    fn alarms(&mut self) {
        for _ in 0..2 + self.numbers.below(5) {
            let input = self.input();
            self.line(&format!("LD {input}"));
            self.perhaps(50, "ANI X1");
            self.application("D9004");
        }
    }

    fn recipe(&mut self) {
        let inputs = [self.input(), self.input(), self.input()];
        for kind in 0..8 {
            let on = |bit: u32| kind >> bit & 1 == 1;
            let (first, rest) = (if on(0) { "LD" } else { "LDI" }, ["ANI", "AND"]);
            self.line(&format!("{first} {}", inputs[0]));
            self.line(&format!("{} {}", rest[usize::from(on(1))], inputs[1]));
            self.line(&format!("{} {}", rest[usize::from(on(2))], inputs[2]));
            let mode = rest[self.numbers.below(2) as usize];
            self.line(&format!("{mode} X0"));
            self.application("D9005");
        }
    }

    fn manual(&mut self) {
        self.line("LD X1\nANI X0");
        for branch in ["MPS", "MRD", "MPP"] {
            let input = self.input();
            self.line(&format!("{branch}\nAND {input}"));
            self.application("D9006");
        }
    }

    fn logic(&mut self) {
        if self.pool.len() < 2 {
            return;
        }
        let [a, b, c] = [self.pooled(), self.pooled(), self.pooled()];
        let d = if self.numbers.below(2) == 0 { self.pooled() } else { self.input() };
        let (relay, other) = (self.relay(), self.pooled());
        self.line(&format!("LD {a}\nANI {b}\nLDI {c}\nAND {d}\nORB\nOUT {relay}"));
        self.application("D9007");
        self.line(&format!("LDI {relay}\nAND {other}"));
        self.application("D9008");
        self.pool.push(relay);
    }

    fn edges(&mut self) {
        let input = self.input();
        for contact in ["LDP", "LDF"] {
            self.line(&format!("{contact} {input}"));
            self.application("D9009");
        }
    }

    fn jump(&mut self) {
        let label = format!("P{}", self.applications);
        let condition = self.mode();
        let (a, b) = (self.input(), self.input());
        self.line(&format!("LD {condition}\nCJ {label}\nLD {a}"));
        self.application("D9010");
        self.line(&format!("LDI {b}"));
        self.application("D9010");
        self.line(&label);
    }

    fn master(&mut self) {
        let (condition, relay) = (self.mode(), self.relay());
        let (a, b) = (self.input(), self.input());
        self.line(&format!("LD {condition}\nMC N0 {relay}\nLDI {a}"));
        self.application("D9011");
        self.line(&format!("LD {b}"));
        self.application("D9011");
        self.line("MCR N0");
    }

    fn mode(&mut self) -> String {
        match self.numbers.below(3) {
            0 => "X0".to_owned(),
            1 => "X1".to_owned(),
            _ => self.input(),
        }
    }
}

//! What words are found to hold where they count, against a PLC made from the manuals alone: random programs whose counts
//! hang on contacts, guards, jumps and loops never take longer than their bound, whatever stands in memory when the scan
//! starts.

mod common;

use common::audited::{asked, listed, table};
use common::plc::{Device, Line, Luck, Plc, line};
use common::tape::{Tape, cases, on_tapes};
use scanbound::audit::follow;
use scanbound::base::facts::Facts;
use scanbound::passes::values::Trust;
use scanbound::program::{Step, TrustedRange};
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

/// Scans of a program, and after how many of them its power fails.
const SCANS: u64 = 300;
const AFTER_POWER_UP: u64 = 100;

struct Generator<'t, 'a> {
    tape: &'t mut Tape<'a>,
    lines: Vec<String>,
    labels: u32,
    /// Whether there is a routine to be called here.
    routine: bool,
    /// Where the open loops are left to.
    out: Vec<u32>,
}

/// A program, whose counts are often written first, or, where they come from the scan before, last.
fn generate(tape: &mut Tape<'_>, across: bool) -> Vec<String> {
    let mut g = Generator { tape, lines: Vec::new(), labels: 0, routine: false, out: Vec::new() };
    if !across && g.tape.percent(60) {
        let first = g.tape.below(9);
        g.put("LD SM400");
        g.put(format!("FMOV K{first} D10 K3"));
    }
    let routine = g.tape.percent(30);
    g.routine = routine;
    g.items(0, 7);
    if across {
        g.put("LD SM400");
        for _ in 0..1 + g.tape.below(3) {
            let line = g.pick(&[
                "MOV K7 D10",
                "MOV D10 D11",
                "MOV D11 D12",
                "INC D10",
                "+ K3 D11 D12",
                "LIMIT K0 K9 D12 D11",
                "WAND K15 D12",
                "WAND K31 D11 D10",
                "SER K0 D0 D11 K4",
                "- K20 D10 D12",
                "* D10 K2 D11",
            ]);
            g.put(line);
        }
        if g.tape.percent(40) {
            g.put("LD> D10 K20");
            g.put("MOV K0 D10");
        }
    }
    if routine {
        g.contacts();
        g.put("CALL P100");
        g.items(1, 3);
        g.put("FEND");
        g.put("P100");
        g.routine = false;
        g.items(1, 3);
        g.put("RET");
    }
    g.put("END");
    g.lines
}

impl Generator<'_, '_> {
    fn put(&mut self, line: impl Into<String>) {
        self.lines.push(line.into());
    }

    fn pick(&mut self, of: &[&'static str]) -> &'static str {
        self.tape.pick(of)
    }

    fn items(&mut self, depth: u32, most: usize) {
        for _ in 0..1 + self.tape.below(most) {
            self.item(depth);
            if self.tape.done() {
                break;
            }
        }
    }

    fn item(&mut self, depth: u32) {
        match self.tape.below(15) {
            0 if depth < 2 => {
                let count = match self.tape.below(4) {
                    0 => "K3",
                    1 => {
                        // Too many iterations to be followed one by one.
                        self.put("LD SM400");
                        self.put("LIMIT K1 K30000 D0 D13");
                        "D13"
                    }
                    _ => {
                        self.put("LD SM400");
                        self.put("LIMIT K1 K6 D10 D13");
                        "D13"
                    }
                };
                self.put(format!("FOR {count}"));
                let out = self.label();
                self.out.push(out);
                self.items(depth + 1, 3);
                self.out.pop();
                (0..12).for_each(|_| self.put("NOP"));
                self.put("NEXT");
                self.put(format!("P{out}"));
            }
            1 => {
                self.contacts();
                let label = self.label();
                self.put(format!("CJ P{label}"));
                self.items(2, 2);
                self.put(format!("P{label}"));
            }
            2 => {
                self.contacts();
                self.put("MC N0 M9");
                for _ in 0..2 {
                    self.contacts();
                    self.outputs();
                }
                self.put("MCR N0");
            }
            3 => {
                self.put("LD SM400");
                self.put("WAND K7 Z0");
            }
            4 => self.branches(),
            5..=8 => self.again(),
            9 if self.routine => {
                self.contacts();
                self.put("CALL P100");
            }
            10 | 11 if !self.out.is_empty() => {
                self.contacts();
                let leave = self.pick(&["CJ", "BREAK D13"]);
                let out = self.out.last().expect("a loop");
                self.lines.push(format!("{leave} P{out}"));
            }
            _ => {
                self.contacts();
                self.outputs();
            }
        }
    }

    fn label(&mut self) -> u32 {
        self.labels += 1;
        self.labels - 1
    }

    /// Counts under contacts, perhaps something else, and what they count under the same contacts.
    fn again(&mut self) {
        let from = self.lines.len();
        self.contacts();
        let contacts = self.lines[from..].to_vec();
        let to = self.pick(&["D10", "D11", "D12"]);
        let count = match self.tape.below(6) {
            0 => format!("MOV K{} {to}", self.tape.below(40)),
            1 => format!("WAND K15 D0 {to}"),
            2 => format!("SER K0 D0 {to} K4"),
            3 => format!("LIMIT K0 K9 D0 {to}"),
            4 => format!("MOV D12 {to}"),
            _ => format!("BMOV D10 {to} K1"),
        };
        self.put(count);
        if self.tape.percent(40) {
            let by = self.tape.below(6);
            let sign = self.pick(&["+", "-"]);
            self.put(format!("{sign} K{by} {to} {to}"));
        }
        if self.tape.percent(40) {
            let bit = self.pick(&["M0", "M1", "M2"]);
            self.put(format!("OUT {bit}"));
        }
        if self.tape.percent(60) {
            self.item(2);
        }
        let again = self.tape.percent(30);
        if again {
            let count = self.pick(&["K3", "K2", "D13"]);
            self.put(format!("FOR {count}"));
        }
        self.lines.extend(contacts);
        if self.tape.percent(40) {
            self.put(format!("AND> {to} K0"));
        }
        self.put(format!("FMOV D0 D20 {to}"));
        if again {
            if self.tape.percent(70) {
                self.contacts();
                self.outputs();
            }
            self.put("NEXT");
        }
    }

    fn branches(&mut self) {
        self.contacts();
        self.put("MPS");
        self.contact("AND");
        self.outputs();
        if self.tape.percent(50) {
            self.put("MRD");
            self.contact("AND");
            self.outputs();
        }
        self.put("MPP");
        if self.tape.percent(50) {
            self.contact("AND");
        }
        self.outputs();
    }

    fn contacts(&mut self) {
        self.contact("LD");
        for _ in 0..self.tape.below(3) {
            match self.tape.below(8) {
                0 => self.contact("OR"),
                1 => {
                    self.contact("LD");
                    self.contact("AND");
                    let block = self.pick(&["ANB", "ORB"]);
                    self.put(block);
                }
                2 => self.put("INV"),
                3 => self.put("MEP"),
                _ => self.contact("AND"),
            }
        }
    }

    fn contact(&mut self, kind: &str) {
        match self.tape.below(6) {
            0..=2 => {
                let bit = self.pick(&["X0", "M0", "M1", "M2", "D1.0", "SM400", "M0Z0"]);
                let name = match (kind, self.tape.below(5)) {
                    ("LD", 3) => "LDI",
                    ("AND", 3) => "ANI",
                    ("OR", 3) => "ORI",
                    (kind, _) => kind,
                };
                self.put(format!("{name} {bit}"));
            }
            _ => {
                let relation = self.pick(&["=", ">", "<", "<>", ">=", "<="]);
                let (left, right) = (self.word(), self.number());
                self.put(format!("{kind}{relation} {left} {right}"));
            }
        }
    }

    fn word(&mut self) -> &'static str {
        self.pick(&["D10", "D11", "D12", "D0", "D1"])
    }

    fn number(&mut self) -> &'static str {
        self.pick(&["K0", "K1", "K5", "K20", "K-1", "D10", "D11", "D0"])
    }

    fn outputs(&mut self) {
        for _ in 0..1 + self.tape.below(3) {
            self.output();
        }
    }

    fn output(&mut self) {
        let (a, b, to) = (self.word(), self.number(), self.pick(&["D10", "D11", "D12"]));
        let line = match self.tape.below(29) {
            0..=5 => {
                let name = self.pick(&["FMOV", "BMOV"]);
                format!("{name} D0 D20 {to}")
            }
            6..=8 => {
                let value = self.pick(&["K0", "K3", "K7", "K30", "K-2"]);
                format!("MOV {value} {to}")
            }
            9 => format!("MOV {a} {to}"),
            10 | 11 => {
                let name = self.pick(&["+", "-", "*"]);
                format!("{name} {a} {b} {to}")
            }
            12 => format!("WAND K15 {a} {to}"),
            13 => format!("LIMIT K0 K9 {a} {to}"),
            14 => format!("SER K0 D0 {to} K4"),
            15 => format!("/ {a} K7 {to}"),
            16 => format!("DMOV K70003 {to}"),
            17 => format!("INC {to}"),
            18 | 19 => {
                let name = self.pick(&["OUT", "SET", "RST", "PLS", "PLF", "FF"]);
                let bit = self.pick(&["M0", "M1", "M2", "M0Z0"]);
                let bit = if name == "FF" { "M1" } else { bit };
                format!("{name} {bit}")
            }
            24 => format!("XCH D11 {to}"),
            25 => format!("MOV {b} K4M0"),
            26 => format!("DMOV {a} {to}"),
            27 => format!("BMOV D9 D10 {to}"),
            28 => format!("WXOR {a} D0 {to}"),
            20 => format!("MOVP K{} {to}", 1 + self.tape.below(9)),
            21 => format!("BMOV D0 {to} K2"),
            22 => {
                let device = self.pick(&["D5Z0", "D8Z0"]);
                format!("MOV {b} {device}")
            }
            _ => {
                let target = self.pick(&["K1M0", "D1.0"]);
                if target == "D1.0" { format!("SET {target}") } else { format!("MOV {b} {target}") }
            }
        };
        self.put(line);
    }
}

/// What memory holds when the scan starts: numbers of every size, small ones above all.
struct Start(Cell<u64>);

impl Start {
    fn draw(&self) -> u64 {
        // xorshift64 (G. Marsaglia: Xorshift RNGs, Journal of Statistical Software 8, 2003).
        let mut x = self.0.get();
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        self.0.set(x);
        x
    }
}

impl Luck for &Start {
    fn value(&mut self, (area, _): Device) -> u16 {
        let x = self.draw();
        match (area, x % 8) {
            ("D", 0) => (x >> 16) as u16,
            ("D", 1) => (x >> 16) as u16 % 40_000,
            ("D", 2) => 0,
            ("D" | "Z", _) => (x >> 16) as u16 % 40,
            _ => (x >> 16) as u16 % 2,
        }
    }

    fn below(&mut self, n: u32) -> u32 {
        (self.draw() >> 16) as u32 % n
    }
}

/// Keeps memory from scan to scan, cleared at power-up. What comes from outside, and whatever is not trusted, is something
/// else in each scan by chance.
struct Between<'a> {
    /// What is stated of words holds whenever a scan starts.
    stated: &'a BTreeMap<String, (i64, i64)>,
    chance: &'a Start,
    trusted: &'a BTreeSet<String>,
    memory: &'a BTreeMap<Device, u16>,
}

impl Luck for Between<'_> {
    fn value(&mut self, of: Device) -> u16 {
        let known = self.memory.get(&of).copied();
        if self.trusted.contains(&format!("{}{}", of.0, of.1)) {
            return known.unwrap_or(0);
        }
        if let Some(&(low, high)) = self.stated.get(&format!("{}{}", of.0, of.1)) {
            let chosen = low + (self.chance.draw() >> 16) as i64 % (high - low + 1);
            return known.filter(|&value| within(value, (low, high))).unwrap_or(chosen as u16);
        }
        match known {
            Some(value) if !self.chance.draw().is_multiple_of(3) => value,
            _ => { self.chance }.value(of),
        }
    }

    fn below(&mut self, n: u32) -> u32 {
        { self.chance }.below(n)
    }
}

fn within(value: u16, (low, high): (i64, i64)) -> bool {
    (low..=high).contains(&i64::from(value.cast_signed()))
}

/// How many counts there were, how many of them were found to be no longer than a few words, and how many words were
/// trusted.
#[derive(Default)]
struct Tally {
    counts: Cell<u32>,
    small: Cell<u32>,
    trusted: Cell<u32>,
    /// Words of which something was stated, and those of which that was found to be kept.
    stated: Cell<u32>,
    kept: Cell<u32>,
}

/// Some words' ranges.
fn ranges(tape: &mut Tape<'_>) -> Facts {
    let mut facts = Facts::default();
    for word in ["D0", "D1", "D10", "D11", "D12", "D13"] {
        if tape.percent(50) {
            let low = tape.pick(&[0, 0, 1, -1, -40]);
            let high = low + tape.pick(&[3, 20, 60, 3000]);
            facts.ranges.insert(word.to_owned(), (low, high));
        }
    }
    facts
}

/// Some words' ranges, and perhaps that nobody but the program writes some words.
fn both(tape: &mut Tape<'_>) -> Facts {
    let internal = if tape.percent(50) { own(tape).internal } else { Vec::new() };
    Facts { internal, ..ranges(tape) }
}

fn nothing(_: &mut Tape<'_>) -> Facts {
    Facts::default()
}

/// That nobody but the program writes some words.
fn own(_: &mut Tape<'_>) -> Facts {
    Facts { internal: vec!["D0-D2".to_owned(), "D5-D99".to_owned()], ..Facts::default() }
}

fn check(
    tape: &[u16],
    trust: Trust,
    facts: fn(&mut Tape<'_>) -> Facts,
    tally: &Tally,
) -> Result<(), String> {
    let mut tape = Tape::new(tape);
    let facts = facts(&mut tape);
    let lines = generate(&mut tape, trust != Trust::None);
    let text = lines.join("\n") + "\n";
    let table = table("");
    let inputs = listed(text.clone());
    let request = asked(&inputs, &table, &facts, trust);
    let followed = follow(&request).map_err(|why| format!("{why:?}\n{text}"))?;
    // By line: the most units, and of loops the most iterations with the line of their end.
    let mut most: BTreeMap<usize, u64> = BTreeMap::new();
    let mut loops: Vec<(usize, usize, usize)> = Vec::new();
    let instructions = &followed.program.instructions;
    let line_of = |at: usize| instructions[at].place.line as usize;
    for (at, instruction) in instructions.iter().enumerate() {
        if let Some(counted) = instruction.counted() {
            most.insert(line_of(at), counted.most);
            tally.counts.set(tally.counts.get() + 1);
            tally.small.set(tally.small.get() + u32::from(counted.most < 100));
        }
        if let Step::ForBegin { most, end, .. } = instruction.step {
            loops.push((line_of(at), line_of(end), most as usize));
        }
    }
    let ranges = &followed.program.trusted;
    let name = |one: &TrustedRange| followed.program.cell_name(one.cell);
    let trusted: BTreeSet<String> = ranges.iter().map(name).collect();
    tally.trusted.set(tally.trusted.get() + trusted.len() as u32);
    tally.stated.set(tally.stated.get() + facts.ranges.len() as u32);
    let kept = followed.program.kept.iter().map(|&cell| followed.program.cell_name(cell));
    let kept: Vec<String> = kept.collect();
    tally.kept.set(tally.kept.get() + kept.len() as u32);
    let program = [lines.iter().map(|text| line(text)).collect::<Vec<Line>>()];
    let chance = Start(Cell::new(0x9E37_79B9_7F4A_7C15));
    let mut memory: BTreeMap<Device, u16> = BTreeMap::new();
    for scan in 0..SCANS {
        if scan.is_multiple_of(AFTER_POWER_UP) {
            memory.clear();
        }
        let stated = &facts.ranges;
        let luck = Between { stated, chance: &chance, trusted: &trusted, memory: &memory };
        let (executed, left) = Plc::new(&program, luck, Vec::new()).both();
        let fault = |what: String| {
            let told: Vec<String> =
                executed.iter().map(|&(_, at, on, units)| format!("{at} {on} {units}")).collect();
            let listed = lines.iter().enumerate().map(|(at, line)| format!("{:3} {line}", at + 1));
            let listed: Vec<String> = listed.collect();
            Err(format!("{what}\n{}\n{}\n{ranges:?}", listed.join("\n"), told.join(", ")))
        };
        for &(_, at, on, units) in &executed {
            if on && most.get(&at).is_some_and(|&most| units > most) {
                return fault(format!("line {at} counts {units}, at most {}", most[&at]));
            }
        }
        let times = |line: usize| executed.iter().filter(|one| one.1 == line).count();
        for &(begin, end, most) in &loops {
            if times(end) > times(begin) * most {
                return fault(format!("the loop in line {begin} runs more than {most} times"));
            }
        }
        for word in &kept {
            let number = word.strip_prefix('D').and_then(|number| number.parse().ok());
            let Some(&value) = left.get(&("D", number.expect("a D"))) else { continue };
            let (low, high) = facts.ranges[word];
            if !(low..=high).contains(&i64::from(value.cast_signed())) {
                return fault(format!("{word} is left as {value}, and its range as kept"));
            }
        }
        memory.extend(left);
        // What is stated is true of every start: where others leave a word alone, the run ends with what is not.
        let broken = |(&(area, n), &value): (&Device, &u16)| {
            let name = format!("{area}{n}");
            let stated = facts.ranges.get(&name);
            trusted.contains(&name) && stated.is_some_and(|&stated| !within(value, stated))
        };
        let is_over = memory.iter().any(broken);
        for one in ranges {
            let held = memory.iter().find(|((area, n), _)| format!("{area}{n}") == name(one));
            let value = held.map_or(0, |(_, &value)| i64::from(value.cast_signed()));
            if value < one.low || value > one.high {
                return fault(format!("{} is {value} between scans", name(one)));
            }
        }
        if is_over {
            memory.clear();
        }
    }
    Ok(())
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn no_scan_counts_further_than_words_were_found_to_hold() {
    let tally = Tally::default();
    on_tapes(cases(400), 160, |tape| check(tape, Trust::None, nothing, &tally));
    let (counts, small) = (tally.counts.get(), tally.small.get());
    println!("{counts} counts, {small} of them small");
    assert!(small > cases(400) / 4 && small * 10 > counts, "{small} of {counts}");
    assert_eq!(tally.trusted.get(), 0);
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn no_run_from_power_up_breaks_what_words_are_trusted_to_hold() {
    let tally = Tally::default();
    on_tapes(cases(60), 160, |tape| check(tape, Trust::Counts, nothing, &tally));
    on_tapes(cases(60), 160, |tape| check(tape, Trust::Counts, own, &tally));
    on_tapes(cases(60), 160, |tape| check(tape, Trust::All, nothing, &tally));
    for trust in [Trust::Counts, Trust::All] {
        on_tapes(cases(30), 160, |tape| check(tape, trust, both, &tally));
    }
    let (counts, small, trusted) = (tally.counts.get(), tally.small.get(), tally.trusted.get());
    println!("{counts} counts, {small} of them small, {trusted} words trusted");
    assert!(trusted > cases(60) / 20, "{trusted} words trusted");
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn what_is_stated_bounds_counts_and_is_kept_where_that_is_said() {
    let tally = Tally::default();
    on_tapes(cases(300), 160, |tape| check(tape, Trust::None, ranges, &tally));
    let (stated, kept) = (tally.stated.get(), tally.kept.get());
    println!("{kept} of {stated} stated ranges kept");
    assert!(kept * 50 > stated, "{kept} of {stated}");
}

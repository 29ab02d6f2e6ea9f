//! What words are found to hold where they count, against a PLC made from the manuals alone: random programs whose
//! counts hang on contacts, guards, jumps and loops never take longer than their bound, whatever stands in memory when
//! the scan starts.

use common::audited::{asked, listed, table};
use common::counting::{Taste, generate};
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

/// Keeps memory from scan to scan, cleared at power-up. What comes from outside, and whatever is not trusted, is
/// something else in each scan by chance.
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

/// Some words' ranges, and perhaps that only the program writes some words.
fn both(tape: &mut Tape<'_>) -> Facts {
    let internal = if tape.percent(50) { own(tape).internal } else { Vec::new() };
    Facts { internal, ..ranges(tape) }
}

fn nothing(_: &mut Tape<'_>) -> Facts {
    Facts::default()
}

/// That only the program writes some words.
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
    let taste = Taste { across: trust != Trust::None, far: false, long: true };
    let lines = generate(&mut tape, taste);
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
    let ranges = &followed.program.trusted_ranges;
    let name = |one: &TrustedRange| followed.program.cell_name(one.cell);
    let trusted: BTreeSet<String> = ranges.iter().map(name).collect();
    tally.trusted.set(tally.trusted.get() + trusted.len() as u32);
    tally.stated.set(tally.stated.get() + facts.ranges.len() as u32);
    let kept = followed.program.proved_ranges.iter().map(|&cell| followed.program.cell_name(cell));
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

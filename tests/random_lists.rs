//! The bound of random MELSEC lists: its witness reaches it, and neither the interpreter nor a PLC made from the
//! manuals alone finds a scan above it.

mod common;

use common::bound::{Times, bound};
use common::list::{Taste, generate};
use common::plc::{Device, Executed, Line, Luck, Plc, line};
use common::search::holds;
use common::tape::{Tape, cases, on_tapes};
use scanbound::dialect::melsec::decode::{DecodeOptions, decode};
use scanbound::dialect::melsec::device::Family;
use scanbound::dialect::{Input, Project, read};
use scanbound::facts::Facts;
use scanbound::program::Program;
use scanbound::solve::Method;
use scanbound::time::Picos;
use std::collections::BTreeMap;

const PLAIN: Taste = Taste { words: false, control: false, wild: false, items: 6 };

fn program(lines: &[String], facts: &Facts) -> Result<Program, String> {
    let text = lines.join("\n") + "\n";
    let input = Input { name: "main.txt".to_owned(), bytes: text.into_bytes() };
    let told = |faults: Vec<scanbound::diagnostic::Diagnostic>| {
        let line = |f: &scanbound::diagnostic::Diagnostic| {
            format!("{:?} {}: {}", f.line, f.text, f.message)
        };
        faults.iter().map(line).collect::<Vec<_>>().join("\n")
    };
    let Project::Melsec(project) = read(&[input], Some("melsec-list")).map_err(told)? else {
        return Err("not read as MELSEC".to_owned());
    };
    let options = DecodeOptions {
        family: Family::Q,
        is_user_instruction: &|name| name.starts_with("SwOp"),
        facts,
    };
    decode(&project, &options).map_err(told)
}

/// Times for every instruction: both the same where tables cannot tell when which of them counts.
fn times(tape: &mut Tape<'_>, program: &Program) -> Times {
    let drawn = common::ir::times(tape, program.instructions.len());
    program
        .instructions
        .iter()
        .zip(drawn)
        .map(|(instruction, (on, off))| {
            let name = instruction.text.split(' ').next().unwrap_or_default();
            let same = ["PLS", "PLF", "FF"].contains(&name);
            match &instruction.timing {
                None => (Picos::ZERO, Picos::ZERO),
                Some(key) if key.dearer || same => (on.max(off), on.max(off)),
                Some(_) => (on, off),
            }
        })
        .collect()
}

/// Start values by device, the rest by chance.
#[derive(Clone)]
struct Fortune<'w> {
    words: &'w [u16],
    values: BTreeMap<Device, u16>,
    seed: u64,
}

fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

impl Fortune<'_> {
    fn draw(&mut self) -> u64 {
        self.seed = mix(self.seed);
        self.seed
    }

    /// Index registers stay small, so that what is indexed is near.
    fn fresh(&mut self, (area, _): Device) -> u16 {
        let z = self.draw();
        if area == "Z" { (z % 3) as u16 } else { self.words[(z >> 20) as usize % self.words.len()] }
    }
}

impl Luck for &mut Fortune<'_> {
    fn value(&mut self, of: Device) -> u16 {
        if let Some(value) = self.values.get(&of) {
            return *value;
        }
        let word = matches!(of.0, "D" | "W" | "Z" | "T" | "C" | "ST");
        let value = if word { self.fresh(of) } else { (self.draw() >> 33) as u16 & 1 };
        // Loops counted by a word must end in good time.
        self.values.insert(of, value);
        value
    }

    fn below(&mut self, n: u32) -> u32 {
        (self.draw() >> 16) as u32 % n
    }
}

/// What each line costs on and off.
fn prices(program: &Program, times: &Times) -> BTreeMap<usize, (Picos, Picos)> {
    let mut prices = BTreeMap::new();
    for (instruction, (on, off)) in program.instructions.iter().zip(times) {
        if instruction.timing.is_some() {
            let sum: &mut (Picos, Picos) =
                prices.entry(instruction.place.line as usize).or_default();
            *sum = (sum.0 + *on, sum.1 + *off);
        }
    }
    prices
}

fn cost(executed: &[Executed], prices: &BTreeMap<usize, (Picos, Picos)>) -> Picos {
    let price = |(_, line, on): &Executed| {
        let (yes, no) = prices.get(line).copied().unwrap_or_default();
        if *on { yes } else { no }
    };
    executed.iter().map(price).sum()
}

/// Climbs on the PLC from random starts and complains of the first scan above the bound.
fn climb(
    lines: &[String],
    prices: &BTreeMap<usize, (Picos, Picos)>,
    upper: Picos,
    words: &[u16],
    scans: u64,
    interrupts: &[(u32, u32)],
) -> Result<Picos, String> {
    let files: [Vec<Line>; 1] = [lines.iter().map(|text| line(text)).collect()];
    let mut best: Option<(Picos, Fortune<'_>)> = None;
    let mut most = Picos::ZERO;
    for scan in 0..scans {
        let mut fortune = match &best {
            Some((_, fortune)) if scan % 40 != 0 => {
                let mut next = fortune.clone();
                next.seed = mix(next.seed ^ scan);
                for _ in 0..=next.draw() % 3 {
                    let at = next.draw() as usize % next.values.len().max(1);
                    if let Some((&device, &old)) = next.values.iter().nth(at) {
                        let word = matches!(device.0, "D" | "W" | "Z" | "T" | "C" | "ST");
                        let new = if word { next.fresh(device) } else { old ^ 1 };
                        next.values.insert(device, new);
                    }
                }
                next
            }
            _ => Fortune { words, values: BTreeMap::new(), seed: mix(scan) },
        };
        let start = fortune.clone();
        let executed = Plc::new(&files, &mut fortune, interrupts.to_vec()).scan();
        let total = cost(&executed, prices);
        most = most.max(total);
        if total > upper {
            let told: Vec<String> = executed
                .iter()
                .map(|(_, at, on)| format!("  {at} {} {on} {:?}", lines[at - 1], prices.get(at)))
                .collect();
            return Err(format!(
                "the bound is {upper:?}, but a PLC takes {total:?} from {:?}\n{}",
                fortune.values,
                told.join("\n")
            ));
        }
        let restart = scan % 40 == 0;
        if restart || best.as_ref().is_none_or(|(cost, _)| total >= *cost) {
            let kept = Fortune { values: fortune.values, ..start };
            best = Some((total, kept));
        }
    }
    Ok(most)
}

fn check(tape: &[u16], taste: Taste, cap: usize, scans: u64) -> Result<(), String> {
    let mut tape = Tape::new(tape);
    let lines = generate(&mut tape, taste);
    let listing = || lines.join("\n");
    let mut facts = Facts::default();
    facts.interrupts.insert("I0".to_owned(), 2);
    let has_interrupt = lines.iter().any(|line| line == "I0");
    if !has_interrupt {
        facts.interrupts.clear();
    }
    let program = program(&lines, &facts).map_err(|why| format!("{why}\n{}", listing()))?;
    let times = times(&mut tape, &program);
    let with_lines = |why: String| {
        let line = |(i, t): (&scanbound::program::Instruction, _)| {
            format!("{} {} {t:?} {:?} {:?}", i.place.line, i.text, i.step, i.effects)
        };
        let internal: Vec<String> = program.instructions.iter().zip(&times).map(line).collect();
        format!("{why}\n{}\n{}", listing(), internal.join("\n"))
    };
    let bound = bound(&program, &times, Method::Auto).map_err(|why| with_lines(why.to_string()))?;
    holds(&program, &times, &bound, cap).map_err(with_lines)?;
    let words = common::search::words(&program);
    let interrupts = if has_interrupt { &[(0, 2)][..] } else { &[] };
    climb(&lines, &prices(&program, &times), bound.upper, &words, scans, interrupts)
        .map_err(with_lines)?;
    Ok(())
}

#[test]
fn rungs_of_bits() {
    on_tapes(cases(150), 200, |tape| check(tape, PLAIN, 100, 200));
}

#[test]
fn words() {
    let taste = Taste { words: true, ..PLAIN };
    on_tapes(cases(150), 250, |tape| check(tape, taste, 100, 200));
}

#[test]
fn control() {
    let taste = Taste { control: true, ..PLAIN };
    on_tapes(cases(150), 300, |tape| check(tape, taste, 100, 200));
}

#[test]
fn words_and_control() {
    let taste = Taste { words: true, control: true, ..PLAIN };
    on_tapes(cases(120), 400, |tape| check(tape, taste, 100, 200));
}

#[test]
fn what_is_taken_wider() {
    let taste = Taste { words: true, control: true, wild: true, items: 6 };
    on_tapes(cases(120), 400, |tape| check(tape, taste, 100, 200));
}

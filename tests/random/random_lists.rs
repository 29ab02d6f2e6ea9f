//! The bound of random MELSEC lists: its witness reaches it, and neither the interpreter nor a PLC made from the
//! manuals alone finds a scan above it.

use common::bound::{Bound, bound_knowing, bound_within};
use common::list::{Part, Taste, generate};
use common::passed::passed;
use common::plc::{Device, Executed, Line, Luck, Plc, line};
use common::search::{holds, none_above};
use common::tape::{Tape, cases, on_tapes};
use scanbound::base::facts::Facts;
use scanbound::base::time::{Picos, Times};
use scanbound::front::melsec::decode::{DecodeOptions, decode};
use scanbound::front::melsec::memory::Family;
use scanbound::front::melsec::source::RawProject;
use scanbound::front::{Input, read};
use scanbound::program::meaning::Knowledge;
use scanbound::program::{AreaKind, Cell, ChoiceKey, Program};
use scanbound::replay::{FreeValues, real, replay_knowing};
use scanbound::solve::{Limits, Method};
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::{Duration, Instant};

const PLAIN: Taste = Taste { words: false, control: false, wild: false, items: 6 };

/// The range that the facts state for D0 in some projects.
const RANGE: (i64, i64) = (-1, 3);

fn program(files: &[Vec<String>], facts: &Facts) -> Result<Program, String> {
    let input = |(file, lines): (usize, &Vec<String>)| Input {
        name: format!("part{file}.txt"),
        bytes: (lines.join("\n") + "\n").into_bytes(),
    };
    let inputs: Vec<Input> = files.iter().enumerate().map(input).collect();
    let told = |faults: Vec<scanbound::base::diagnostic::Diagnostic>| {
        let line = |f: &scanbound::base::diagnostic::Diagnostic| {
            format!("{:?} {}: {}", f.line, f.text, f.message)
        };
        faults.iter().map(line).collect::<Vec<_>>().join("\n")
    };
    let project = read(&inputs, Some("melsec-list")).map_err(told)?;
    let project: RawProject = project.downcast().ok_or("not read as MELSEC")?;
    let options = DecodeOptions {
        family: Family::Q,
        is_user_instruction: &|name| name.starts_with("SwOp"),
        facts,
        absent_calls_take_no_time: false,
    };
    decode(&project, &options).and_then(passed).map_err(told)
}

/// Times for every instruction: both the same where tables cannot tell when which of them counts.
fn times(tape: &mut Tape<'_>, program: &Program) -> Vec<Times> {
    let drawn = common::ir::times(tape, program.instructions.len());
    program
        .instructions
        .iter()
        .zip(drawn)
        .map(|(instruction, Times { on, off, .. })| {
            let name = instruction.text.split(' ').next().unwrap_or_default();
            let same = ["PLS", "PLF", "FF"].contains(&name);
            match &instruction.timing {
                None => Times::default(),
                Some(key) if key.use_larger_time || same => Times::new(on.max(off), on.max(off)),
                Some(key) if key.counted().is_some() => Times { on, off, per_unit: Picos(37) },
                Some(_) => Times::new(on, off),
            }
        })
        .collect()
}

/// Start values by device, the rest by chance.
#[derive(Clone)]
struct Fortune<'w> {
    words: &'w [u16],
    /// Whether D0 starts within its range.
    ranged: bool,
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
    fn fresh(&mut self, (area, number): Device) -> u16 {
        let z = self.draw();
        match (area, number) {
            ("Z", _) => (z % 3) as u16,
            ("D", 0) if self.ranged => {
                let (low, high) = RANGE;
                (low + (z >> 20) as i64 % (high - low + 1)) as u16
            }
            _ => self.words[(z >> 20) as usize % self.words.len()],
        }
    }
}

impl Luck for &mut Fortune<'_> {
    fn value(&mut self, of: Device) -> u16 {
        if let Some(value) = self.values.get(&of) {
            return *value;
        }
        let word = matches!(of.0, "D" | "W" | "Z" | "T" | "C" | "ST");
        let value = if word { self.fresh(of) } else { (self.draw() >> 33) as u16 & 1 };
        self.values.insert(of, value);
        value
    }

    fn below(&mut self, n: u32) -> u32 {
        (self.draw() >> 16) as u32 % n
    }
}

/// What each line of each file costs on and off.
type Prices = BTreeMap<(usize, usize), Times>;

fn prices(program: &Program, times: &[Times]) -> Prices {
    let mut prices = BTreeMap::new();
    for (instruction, times) in program.instructions.iter().zip(times) {
        if instruction.timing.is_some() {
            let line = (instruction.place.file as usize, instruction.place.line as usize);
            let sum: &mut Times = prices.entry(line).or_default();
            sum.on += times.on;
            sum.off += times.off;
            sum.per_unit += times.per_unit;
        }
    }
    prices
}

fn cost(executed: &[Executed], prices: &Prices) -> Picos {
    let price = |(file, line, on, units): &Executed| {
        let times = prices.get(&(*file, *line)).copied().unwrap_or_default();
        if *on { times.with(*units) } else { times.off }
    };
    executed.iter().map(price).sum()
}

/// Climbs on the PLC from random starts and complains of the first scan above the bound.
fn climb(
    texts: &[Vec<String>],
    prices: &Prices,
    upper: Picos,
    start: &Fortune<'_>,
    scans: u64,
    interrupts: &[(u32, u32)],
) -> Result<Picos, String> {
    let files: Vec<Vec<Line>> =
        texts.iter().map(|lines| lines.iter().map(|text| line(text)).collect()).collect();
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
            _ => Fortune { seed: mix(scan), ..start.clone() },
        };
        let before = fortune.clone();
        let executed = Plc::new(&files, &mut fortune, interrupts.to_vec()).scan();
        let total = cost(&executed, prices);
        most = most.max(total);
        if total > upper {
            let told: Vec<String> = executed
                .iter()
                .map(|(file, at, on, _)| {
                    let price = prices.get(&(*file, *at));
                    format!("  {file}:{at} {} {on} {price:?}", texts[*file][at - 1])
                })
                .collect();
            return Err(format!(
                "the bound is {upper:?}, but a PLC takes {total:?} from {:?}\n{}",
                fortune.values,
                told.join("\n")
            ));
        }
        let restart = scan % 40 == 0;
        if restart || best.as_ref().is_none_or(|(cost, _)| total >= *cost) {
            let kept = Fortune { values: fortune.values, ..before };
            best = Some((total, kept));
        }
    }
    Ok(most)
}

fn check(tape: &[u16], taste: Taste, cap: usize, scans: u64) -> Result<(), String> {
    check_within(tape, taste, cap, scans, None)
}

/// With a time for the search the bound need not be exact, but holds all the same.
fn check_within(
    tape: &[u16],
    taste: Taste,
    cap: usize,
    scans: u64,
    time: Option<Duration>,
) -> Result<(), String> {
    let mut tape = Tape::new(tape);
    let ranged = taste.words && tape.percent(20);
    let several = taste.control && tape.percent(15);
    let mut files = vec![generate(&mut tape, taste, Part::First)];
    if several {
        files.push(generate(&mut tape, taste, Part::Further));
    }
    let listing = || {
        let text = files.iter().map(|lines| lines.join("\n")).collect::<Vec<_>>().join("\n--\n");
        format!("{text}\n{}", if ranged { "D0 starts within its range" } else { "" })
    };
    let mut facts = Facts::default();
    if ranged {
        facts.ranges.insert("D0".to_owned(), RANGE);
    }
    let has_interrupt = files[0].iter().any(|line| line == "I0");
    if has_interrupt {
        facts.interrupts.insert("I0".to_owned(), 2);
    }
    let program = program(&files, &facts).map_err(|why| format!("{why}\n{}", listing()))?;
    let times = times(&mut tape, &program);
    let with_lines = |why: String| {
        let line = |(i, t): (&scanbound::program::Instruction, _)| {
            format!("{} {} {t:?} {:?} {:?}", i.place.line, i.text, i.step, i.effects)
        };
        let internal: Vec<String> = program.instructions.iter().zip(&times).map(line).collect();
        format!("{why}\n{}\n{}", listing(), internal.join("\n"))
    };
    let deadline = time.map(|time| Instant::now() + time);
    let limits = Limits { deadline, ..Limits::default() };
    let bound = bound_within(&program, &times, Method::Auto, &limits)
        .map_err(|why| with_lines(why.to_string()))?;
    match time {
        None => holds(&program, &times, &bound, cap).map_err(with_lines)?,
        Some(_) => none_above(&program, &times, bound.upper, cap).map_err(with_lines)?,
    };
    let words = common::search::words(&program);
    let closer = match time {
        None => learned(&program, &times, &bound, &words).map_err(with_lines)?,
        Some(_) => bound.upper,
    };
    let interrupts = if has_interrupt { &[(0, 2)][..] } else { &[] };
    let start = Fortune { words: &words, ranged, values: BTreeMap::new(), seed: 0 };
    climb(&files, &prices(&program, &times), closer, &start, scans, interrupts)
        .map_err(with_lines)?;
    Ok(())
}

/// Values by chance, the same for the same question.
struct Drawn<'w> {
    words: &'w [u16],
    program: &'w Program,
    seed: u64,
}

impl Drawn<'_> {
    fn draw(&self, question: impl Hash, kind: AreaKind, is_index: bool) -> u16 {
        let mut hasher = DefaultHasher::new();
        (self.seed, question).hash(&mut hasher);
        let z = hasher.finish();
        match kind {
            AreaKind::Bit => (z >> 20) as u16 & 1,
            AreaKind::Word if is_index => (z >> 20) as u16 % 3,
            AreaKind::Word => self.words[(z >> 20) as usize % self.words.len()],
        }
    }
}

impl FreeValues for Drawn<'_> {
    fn start(&mut self, cell: Cell, kind: AreaKind) -> u16 {
        let is_index = self.program.areas[usize::from(cell.area.0)].name == "Z";
        self.draw(cell, kind, is_index)
    }

    fn choice(&mut self, key: &ChoiceKey, kind: AreaKind) -> u16 {
        self.draw(key, kind, false)
    }
}

/// The bound with what is learned of operations in some scans that are run really: its witness reaches it.
fn learned(
    program: &Program,
    times: &[Times],
    bound: &Bound,
    words: &[u16],
) -> Result<Picos, String> {
    let mut knowledge = Knowledge::new();
    for seed in 0..LESSONS {
        let start = || Drawn { words, program, seed };
        let found = real(program, times, start, 5_000);
        if !found.undeclared_writes.is_empty() {
            return Err(format!(
                "writes that its effects do not declare: {:?}",
                found.undeclared_writes
            ));
        }
        for (moment, facts) in found.learned {
            let known = knowledge.entry(moment).or_default();
            for fact in facts {
                if !known.contains(&fact) {
                    known.push(fact);
                }
            }
        }
    }
    if knowledge.is_empty() {
        return Ok(bound.upper);
    }
    let limits = Limits::default();
    let closer = bound_knowing(program, times, &knowledge, Method::Auto, &limits)
        .map_err(|why| why.to_string())?;
    let reached = replay_knowing(program, times, &knowledge, &closer.best);
    if reached.total != closer.lower {
        return Err(format!(
            "with what was learned {:?}, its witness costs {:?}",
            closer.lower, reached.total
        ));
    }
    for seed in 0..2 * LESSONS {
        let start = || Drawn { words, program, seed };
        let found = real(program, times, start, 5_000);
        let excluded = found.replay.broken_ranges.is_empty() && found.stopped.is_none();
        if excluded && found.replay.total > closer.upper {
            return Err(format!(
                "the bound is {:?}, a real scan costs {:?}",
                closer.upper, found.replay.total
            ));
        }
    }
    Ok(closer.upper)
}

/// From so many real scans is learned.
const LESSONS: u64 = 20;

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

#[test]
fn large_projects_are_bounded() {
    let time = Some(Duration::from_secs(1));
    for wild in [false, true] {
        let taste = Taste { words: true, control: true, wild, items: 60 };
        on_tapes(cases(6), 4000, |tape| check_within(tape, taste, 20, 200, time));
    }
}

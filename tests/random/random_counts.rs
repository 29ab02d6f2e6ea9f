//! What words of OMRON programs are found to hold where they count, against a PLC made from the manuals alone: no scan
//! counts further than was found, ends with other values in trusted words, or takes longer than its bound.

use common::audited::{listed, table};
use common::lines::DrawsLines;
use common::omron_plc::{Chance, Plc, Scanned, Word};
use common::tape::{Tape, cases, on_tapes};
use scanbound::audit::{Failure, Request, conclude, follow};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::passes::values::Trust;
use scanbound::program::{Step, TrustedRange};
use scanbound::timing::table::Table;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

/// Scans of a program, and after how many of them its power fails.
const SCANS: u64 = 100;
const AFTER_POWER_UP: u64 = 25;

/// What costs something: each word that is counted, and moves, which tell which of the ways is taken.
const TIMES: &str =
    "XFER,0,0,1\nBCNT,0,0,1\nMAX,0,0,1\nSUM,0,0,1\nSRCH,0,0,1\nMOV,5,2,0\nOUT,1,3,0\n";

struct Generator<'t, 'a> {
    tape: &'t mut Tape<'a>,
    lines: Vec<String>,
    labels: u32,
    /// Whether there is a subroutine to be called here.
    routine: bool,
    /// Whether a loop may be as long as a word says.
    stated: bool,
    /// How many loops are open.
    open: u32,
    interlocked: bool,
}

/// A program, whose counts are often written first, or, where they come from the scan before, last.
fn generate(tape: &mut Tape<'_>, across: bool, stated: bool) -> Vec<String> {
    let lines = Vec::new();
    let mut g =
        Generator { tape, lines, labels: 0, routine: false, stated, open: 0, interlocked: false };
    if !across && g.tape.percent(60) {
        g.put("LD P_On");
        let first = g.tape.below(9);
        g.put(format!("BSET &{first} D10 D12"));
    }
    let routine = g.tape.percent(30);
    g.routine = routine;
    g.items(0, 6);
    if across {
        g.put("LD P_On");
        for _ in 0..1 + g.tape.below(3) {
            let line = g.pick(&[
                "MOV &7 D10",
                "MOV D10 D11",
                "MOV D11 D12",
                "++ D10",
                "+ &3 D11 D12",
                "ANDW #F D12 D12",
                "ANDW #1F D11 D10",
                "- D10 &20 D12",
                "*U D10 &2 D11",
                "/U D10 &3 D12",
            ]);
            g.put(line);
        }
        if g.tape.percent(50) {
            g.put("LD> D10 &20");
            g.put("MOV &0 D10");
        }
    }
    if routine {
        g.contacts();
        g.put("SBS 1");
        g.put("SBN 1");
        g.routine = false;
        g.items(1, 3);
        g.put("RET");
    }
    g.put("END");
    g.lines
}

impl<'a> DrawsLines<'a> for Generator<'_, 'a> {
    fn tape(&mut self) -> &mut Tape<'a> {
        self.tape
    }

    fn lines(&mut self) -> &mut Vec<String> {
        &mut self.lines
    }

    fn item(&mut self, depth: u32) {
        match self.tape.below(14) {
            0 if depth < 2 && !self.interlocked => {
                let count = match self.tape.below(5) {
                    0 if self.stated && self.open == 0 => self.pick(&["D0", "D1"]),
                    1 => "&0",
                    2 | 3 => {
                        self.put("LD P_On");
                        let from = self.word();
                        self.put(format!("ANDW #7 {from} D15"));
                        // What the loop changes is not asked again.
                        "D15"
                    }
                    _ => "&3",
                };
                self.put(format!("FOR {count}"));
                self.open += 1;
                self.items(depth + 1, 3);
                self.open -= 1;
                self.put("NEXT");
            }
            1 if !self.interlocked => {
                self.contacts();
                self.labels += 1;
                let label = self.labels;
                let jump = self.pick(&["JMP", "CJP", "CJPN"]);
                self.put(format!("{jump} {label}"));
                self.items(2, 2);
                self.put(format!("JME {label}"));
            }
            2 if !self.interlocked && depth == 0 => {
                self.contacts();
                self.put("IL");
                self.interlocked = true;
                for _ in 0..2 {
                    self.contacts();
                    self.outputs();
                }
                self.interlocked = false;
                self.put("ILC");
            }
            3..=7 => self.again(),
            8 if self.routine => {
                self.contacts();
                self.put("SBS 1");
            }
            9 if self.open > 0 => {
                self.contacts();
                self.put("BREAK");
            }
            10 => {
                let (a, b) = (self.word(), self.number());
                self.put("LD P_On");
                self.put(format!("CMP {a} {b}"));
                let flag = self.pick(&["P_GT", "P_EQ", "P_LT"]);
                self.put(format!("LD {flag}"));
                self.outputs();
            }
            _ => {
                self.contacts();
                self.outputs();
            }
        }
    }
}

impl Generator<'_, '_> {
    /// A count under contacts, perhaps something else, and what it counts under the same contacts.
    fn again(&mut self) {
        let from = self.lines.len();
        self.contacts();
        let contacts = self.lines[from..].to_vec();
        let to = self.pick(&["D10", "D11", "D12"]);
        let count = match self.tape.below(7) {
            0 => format!("MOV &{} {to}", self.tape.below(40)),
            1 => format!("ANDW #F D0 {to}"),
            2 => format!("/U D0 &3000 {to}"),
            3 => format!("MOV D12 {to}"),
            4 => format!("XFER &1 D10 {to}"),
            5 => format!("BCNT &2 D0 {to}"),
            _ => format!("LMT D0 D5 {to}"),
        };
        self.put(count);
        if self.tape.percent(40) {
            let by = self.tape.below(6);
            let sign = self.pick(&["+", "-"]);
            self.put(format!("{sign} {to} &{by} {to}"));
        }
        if self.tape.percent(50) {
            self.item(2);
        }
        self.lines.extend(contacts);
        if self.tape.percent(40) {
            self.put(format!("AND> {to} &0"));
        }
        self.counted(to);
    }

    fn counted(&mut self, count: &str) {
        let line = match self.tape.below(9) {
            0 => format!("MAX {count} D100 D200"),
            1 => format!("BCNT {count} D100 D200"),
            2 => format!("@XFER {count} D100 D200"),
            3 => format!("SUM {count} D100 D11"),
            4 => format!("SRCH {count} D100 D0"),
            5 => format!("XFER {count} D9 D10"),
            6 => format!("BCNT {count} D100 D11"),
            _ => format!("XFER {count} D100 D200"),
        };
        self.put(line);
    }

    fn contacts(&mut self) {
        self.contact("LD");
        for _ in 0..self.tape.below(3) {
            match self.tape.below(6) {
                0 => self.contact("OR"),
                1 => {
                    self.contact("LD");
                    self.contact("AND");
                    let block = self.pick(&["ANDLD", "ORLD"]);
                    self.put(block);
                }
                _ => self.contact("AND"),
            }
        }
    }

    fn contact(&mut self, kind: &str) {
        if self.tape.percent(50) {
            let bit = self.pick(&["0.00", "W0.00", "W0.01", "W0.02", "D1.00", "P_On"]);
            let not = if self.tape.percent(20) { "NOT" } else { "" };
            self.put(format!("{kind}{not} {bit}"));
        } else {
            let relation = self.pick(&["=", ">", "<", "<>", ">=", "<=", "<S", ">S"]);
            let (left, right) = (self.word(), self.number());
            self.put(format!("{kind}{relation} {left} {right}"));
        }
    }

    fn word(&mut self) -> &'static str {
        self.pick(&["D10", "D11", "D12", "D0", "D1"])
    }

    fn number(&mut self) -> &'static str {
        self.pick(&["&0", "&1", "&5", "&20", "#FFFF", "D10", "D11", "D0"])
    }

    fn outputs(&mut self) {
        for _ in 0..1 + self.tape.below(3) {
            self.output();
        }
    }

    fn output(&mut self) {
        let (a, b, to) = (self.word(), self.number(), self.pick(&["D10", "D11", "D12"]));
        let line = match self.tape.below(36) {
            0..=5 => return self.counted(to),
            6..=8 => {
                let value = self.pick(&["&0", "&3", "&7", "&30", "#FFFE"]);
                format!("MOV {value} {to}")
            }
            9 => format!("MOV {a} {to}"),
            10 | 11 => {
                let name = self.pick(&["+", "-", "*U", "*", "+B", "-B"]);
                format!("{name} {a} {b} {to}")
            }
            12 => format!("ANDW #F {a} {to}"),
            13 => format!("LMT {a} D5 {to}"),
            14 => {
                let name = self.pick(&["/U", "/"]);
                format!("{name} {a} &7 {to}")
            }
            15 => format!("MOVL &70003 {to}"),
            16 => {
                let name = self.pick(&["++", "--", "COM", "ASL", "ASR"]);
                format!("{name} {to}")
            }
            17..=19 => {
                let name = self.pick(&["OUT", "SET", "RSET"]);
                let bit = self.pick(&["W0.00", "W0.01", "W0.02", "D1.00"]);
                format!("{name} {bit}")
            }
            20 => format!("@MOV &{} {to}", 1 + self.tape.below(9)),
            21 => format!("XCHG D11 {to}"),
            22 => format!("MOVL {a} {to}"),
            23 => format!("XFER &2 D9 {to}"),
            24 => format!("XORW {a} D0 {to}"),
            25 => {
                let name = self.pick(&["BCD", "BIN", "NEG", "MVN"]);
                format!("{name} {a} {to}")
            }
            26 => format!("MOV {b} @D13"),
            27 => format!("MOV @D14 {to}"),
            28 => format!("MOV {b} *D13"),
            29 => {
                let to = self.pick(&["D13", "D14"]);
                format!("ANDW #1F {a} {to}")
            }
            30 => format!("SETB {to} &{}", self.tape.below(16)),
            31 => format!("BSET {b} D9 {to}"),
            32 => {
                let from = self.pick(&["D10", "D12", "D50"]);
                format!("MOVR {from} IR0")
            }
            33 => {
                let to = self.pick(&[",IR0", ",IR0+"]);
                format!("MOV {b} {to}")
            }
            34 => {
                let to = self.pick(&["D10", "D11"]);
                format!("MOVL IR0 {to}")
            }
            _ => {
                let line = self.pick(&["MOV &5 DR0", "MOV DR0 D11", "MOVL &6 IR0", "MOV D0 D6"]);
                line.to_owned()
            }
        };
        self.put(line);
    }
}

/// Numbers of every size, small ones above all.
struct Draws(Cell<u64>);

impl Draws {
    fn draw(&self) -> u32 {
        // xorshift64 (G. Marsaglia: Xorshift RNGs, Journal of Statistical Software 8, 2003).
        let mut x = self.0.get();
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        self.0.set(x);
        (x >> 16) as u32
    }

    fn value(&self, (area, _): Word) -> u32 {
        let x = self.draw();
        match (area, x % 64) {
            ("IR", _) => 0x10000 + (x >> 6) % 40,
            (_, 0) => (x >> 6) & 0xFFFF,
            (_, 1) => 0x8000,
            (_, 2..10) => 0,
            _ => (x >> 6) % 40,
        }
    }
}

fn within(value: u32, (low, high): (i64, i64)) -> bool {
    (low..=high).contains(&i64::from((value as u16).cast_signed()))
}

fn name((area, number): Word) -> String {
    format!("{area}{number}")
}

/// Keeps memory from scan to scan, cleared at power-up. What comes from outside, and whatever is not trusted, is
/// something else in each scan by chance.
struct Between<'a> {
    facts: &'a Facts,
    draws: &'a Draws,
    /// Whose value others leave alone.
    keeps: &'a dyn Fn(Word) -> bool,
    memory: &'a BTreeMap<Word, u32>,
}

impl Chance for Between<'_> {
    fn start(&mut self, word: Word) -> u32 {
        let known = self.memory.get(&word).copied();
        if (self.keeps)(word) {
            return known.unwrap_or(0);
        }
        if let Some(&(low, high)) = self.facts.ranges.get(&name(word)) {
            let chosen = low + i64::from(self.draws.draw()) % (high - low + 1);
            return known.filter(|&value| within(value, (low, high))).unwrap_or(chosen as u32);
        }
        match known {
            Some(value) if !self.draws.draw().is_multiple_of(3) => value,
            _ => self.draws.value(word),
        }
    }

    fn below(&mut self, n: u32) -> u32 {
        self.draws.draw() % n
    }
}

#[derive(Default)]
struct Tally {
    counts: Cell<u32>,
    small: Cell<u32>,
    trusted: Cell<u32>,
    scans: Cell<u32>,
    excluded: Cell<u32>,
}

impl Tally {
    fn add(of: &Cell<u32>, more: usize) {
        of.set(of.get() + more as u32);
    }
}

/// What is stated of a program.
type Stated = fn(&mut Tape<'_>, &[String]) -> Facts;

/// What a program is run with.
struct Asked {
    trust: Trust,
    facts: Stated,
    /// Whether words may say how long a loop is.
    loops: bool,
    /// Whether the bound itself is worked out and held against the scans.
    bound: bool,
}

fn nothing(_: &mut Tape<'_>, _: &[String]) -> Facts {
    Facts::default()
}

/// Some words' ranges.
fn ranges(tape: &mut Tape<'_>, _: &[String]) -> Facts {
    let mut facts = Facts::default();
    for word in ["D0", "D1", "D10", "D11", "D12", "D13"] {
        if tape.percent(60) || ["D0", "D1"].contains(&word) {
            let low = tape.pick(&[0, 0, 0, 1]);
            let high = low + tape.pick(&[3, 20, 60]);
            facts.ranges.insert(word.to_owned(), (low, high));
        }
    }
    facts
}

/// What is counted in some of the lines.
fn counts(tape: &mut Tape<'_>, lines: &[String]) -> Facts {
    let mut facts = ranges(tape, lines);
    facts.ranges.retain(|word, _| ["D0", "D1"].contains(&&**word));
    let counts = ["XFER D", "@XFER D", "BCNT D", "MAX D", "SUM D", "SRCH D"];
    for (at, _) in lines
        .iter()
        .enumerate()
        .filter(|(_, line)| counts.iter().any(|count| line.starts_with(count)))
    {
        if tape.percent(60) {
            let low = tape.pick(&[0, 0, 1]);
            let stated = (low, low + tape.pick(&[3, 7, 30]));
            facts.counts.insert(format!("a.txt:{}", at + 1), stated);
        }
    }
    facts
}

fn check(tape: &[u16], asked: &Asked, table: &Table, tally: &Tally) -> Result<(), String> {
    let mut tape = Tape::new(tape);
    let trust = asked.trust;
    let lines = generate(&mut tape, trust != Trust::None, asked.loops);
    let facts = (asked.facts)(&mut tape, &lines);
    let text = lines.join("\n") + "\n";
    let inputs = listed(text.clone());
    let request = Request {
        dialect: Some("omron-cx"),
        table: Some(table),
        trust,
        ..Request::new(&inputs, &facts)
    };
    let told = |failure: Failure| match failure {
        Failure::Input(faults) => {
            let faults = faults.iter().map(|fault| format!("{}: {}", fault.text, fault.message));
            faults.collect::<Vec<_>>().join("\n")
        }
        Failure::Internal(why) => why,
    };
    let followed = follow(&request).map_err(|why| format!("{}\n{text}", told(why)))?;
    // By line: the most words, and of loops the most iterations with the line of their end.
    let mut most: BTreeMap<usize, u64> = BTreeMap::new();
    let mut loops: Vec<(usize, usize, usize)> = Vec::new();
    let instructions = &followed.program.instructions;
    let line_of = |at: usize| instructions[at].place.line as usize;
    for (at, instruction) in instructions.iter().enumerate() {
        if let Some(counted) = instruction.counted() {
            most.insert(line_of(at), counted.most_units());
            Tally::add(&tally.counts, 1);
            Tally::add(&tally.small, usize::from(counted.most < 100));
        }
        if let Step::ForBegin { most, end, .. } = instruction.step {
            loops.push((line_of(at), line_of(end), most as usize));
        }
    }
    let ranges: Vec<TrustedRange> = followed.program.trusted_ranges.clone();
    let names: Vec<String> =
        ranges.iter().map(|one| followed.program.cell_name(one.cell)).collect();
    let trusted: BTreeSet<&String> = names.iter().collect();
    Tally::add(&tally.trusted, trusted.len());
    let kept: Vec<String> = followed
        .program
        .proved_ranges
        .iter()
        .map(|&cell| followed.program.cell_name(cell))
        .collect();
    let bound = match asked.bound {
        true => {
            let concluded = conclude(followed, &request);
            Some(concluded.map_err(|why| format!("{}\n{text}", told(why)))?.audit.bound.upper)
        }
        false => None,
    };
    let writes = |line: &String| {
        line.ends_with(" D1.00") && ["OUT", "SET", "RSET"].iter().any(|name| line.starts_with(name))
    };
    let writes_bits = lines.iter().any(writes);
    let keeps = |word: Word| match trust {
        // Only the program writes anything but inputs and the words that it never writes.
        Trust::All => {
            let never_zero = |&(low, high): &(i64, i64)| !(low..=high).contains(&0);
            !matches!(word, ("CIO" | "D", 0))
                && word.0 != "IR"
                && (word != ("D", 1) || writes_bits)
                && !facts.ranges.get(&name(word)).is_some_and(never_zero)
        }
        _ => trusted.contains(&name(word)),
    };
    let draws = Draws(Cell::new(0x9E37_79B9_7F4A_7C15));
    let mut memory: BTreeMap<Word, u32> = BTreeMap::new();
    for scan in 0..SCANS {
        if scan.is_multiple_of(AFTER_POWER_UP) {
            memory.clear();
        }
        let between = Between { facts: &facts, draws: &draws, keeps: &keeps, memory: &memory };
        let Scanned { executed, left, counts } = Plc::new(&lines, between).scan();
        let stated = |&(line, count): &(usize, u32)| {
            let stated = facts.counts.get(&format!("a.txt:{line}"));
            stated.is_none_or(|&(low, high)| (low..=high).contains(&i64::from(count)))
        };
        if !counts.iter().all(stated) {
            Tally::add(&tally.excluded, 1);
            continue;
        }
        Tally::add(&tally.scans, 1);
        let fault = |what: String| {
            let listed = lines.iter().enumerate().map(|(at, line)| format!("{:3} {line}", at + 1));
            let listed: Vec<String> = listed.collect();
            Err(format!(
                "{what} in scan {scan}\n{}\n{executed:?}\n{ranges:?}\n{:?} {:?}",
                listed.join("\n"),
                facts.ranges,
                facts.counts
            ))
        };
        for &(at, _, units) in &executed {
            if most.get(&at).is_some_and(|&most| units > most) {
                return fault(format!("line {at} counts {units}, at most {}", most[&at]));
            }
        }
        let times = |line: usize| executed.iter().filter(|one| one.0 == line).count();
        for &(begin, end, most) in &loops {
            if times(end) > times(begin) * most {
                return fault(format!("the loop in line {begin} runs more than {most} times"));
            }
        }
        let held = |cell: &str| {
            let held = left.iter().chain(&memory).find(|(word, _)| name(**word) == cell);
            held.map(|(_, &value)| i64::from((value as u16).cast_signed()))
        };
        for word in &kept {
            let (low, high) = facts.ranges[word];
            if held(word).is_some_and(|value| !(low..=high).contains(&value)) {
                return fault(format!("{word} is left as {:?}, and its range as kept", held(word)));
            }
        }
        if let Some(bound) = bound {
            let cost = |&(at, fired, units): &(usize, bool, u64)| {
                let own = match (lines[at - 1].split(' ').next(), fired) {
                    (Some("MOV" | "@MOV"), true) => 5,
                    (Some("MOV" | "@MOV"), false) => 2,
                    (Some("OUT"), true) => 1,
                    (Some("OUT"), false) => 3,
                    _ => 0,
                };
                own + units
            };
            let took = Picos(executed.iter().map(cost).sum::<u64>() * 1_000_000);
            if took > bound {
                return fault(format!("a scan takes {took:?}, at most {bound:?}"));
            }
        }
        memory.extend(left);
        // What is stated is true of every start: where others leave a word alone, the run ends with what is not.
        let broken = |(word, &value): (&Word, &u32)| {
            let stated = facts.ranges.get(&name(*word));
            keeps(*word) && stated.is_some_and(|&stated| !within(value, stated))
        };
        let is_over = memory.iter().any(broken);
        for (one, name) in ranges.iter().zip(&names) {
            let held = memory.iter().find(|(word, _)| self::name(**word) == *name);
            let value = held.map_or(0, |(_, &value)| i64::from((value as u16).cast_signed()));
            let has = |&other: &u16| i64::from(other.cast_signed()) == value;
            let is_one = one.values.is_empty() || one.values.iter().any(has);
            if value < one.low || value > one.high || !is_one {
                return fault(format!("{name} is {value} between scans"));
            }
        }
        if is_over {
            memory.clear();
        }
    }
    Ok(())
}

/// The most words that the last counted instruction handles; none where its count is not followed.
fn most(lines: &str) -> Option<u64> {
    let (inputs, table, facts) =
        (listed(lines.replace("; ", "\n") + "\nEND\n"), table(TIMES), Facts::default());
    let dialect = Some("omron-cx");
    let request = Request { dialect, table: Some(&table), ..Request::new(&inputs, &facts) };
    let followed = follow(&request).unwrap_or_else(|why| panic!("{lines}\n{why:?}"));
    let counted = followed.program.instructions.iter().filter_map(|one| one.counted());
    counted.map(|counted| counted.most).next_back()
}

#[test]
fn a_count_that_no_word_limits_is_as_much_as_the_word_can_say() {
    assert_eq!(most("LD P_On; XFER D0 D100 D200"), Some(65_535));
    assert_eq!(most("LD P_On; MOV &5 D0; XFER D0 D100 D200"), Some(5));
}

/// The most iterations of each loop, in their order.
fn iterations(lines: &str, facts: &str) -> Vec<u32> {
    let (inputs, table) = (listed(lines.replace("; ", "\n") + "\nEND\n"), table(TIMES));
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    let dialect = Some("omron-cx");
    let request = Request { dialect, table: Some(&table), ..Request::new(&inputs, &facts) };
    let followed = follow(&request).unwrap_or_else(|why| panic!("{lines}\n{why:?}"));
    let most = followed.program.instructions.iter().filter_map(|one| match &one.step {
        Step::ForBegin { most, .. } => Some(*most),
        Step::Summary(summary) => summary.iterations.map(|(.., most)| most),
        _ => None,
    });
    most.collect()
}

/// W474, FOR(512) and NEXT(513): a loop runs 0 to 65,535 times; with 0 what stands in it is not carried out.
#[test]
fn a_loop_makes_as_many_iterations_as_its_word_can_say() {
    let of = |first: &str| {
        iterations(&format!("LD P_On; {first}; FOR D0; LD 0.00; OUT W0.00; NEXT"), "")
    };
    assert_eq!(of("MOV &5 D0"), [5]);
    assert_eq!(of("MOV &0 D0"), [0]);
    assert_eq!(of("ANDW #F D1 D0"), [15]);
    // Counts are unsigned.
    assert_eq!(of("MOV &40000 D0"), [40_000]);
    assert_eq!(of("MOV D1 D0"), [65_535]);
    assert_eq!(of("ANDW #9000 D1 D0"), [0x9000]);
    let guarded = "LD> D0 &6; MOV &6 D0; FOR D0; LD 0.00; OUT W0.00; NEXT";
    assert_eq!(iterations(guarded, ""), [6]);
    let behind = "FOR D0; LD P_On; MOV &9 D0; NEXT; FOR D0; LD 0.00; OUT W0.00; NEXT";
    assert_eq!(iterations(behind, "[counts]\n\"a.txt:1\" = [1, 4]\n"), [4, 9]);
    let through = "LD P_On; MOV &5 D0; MOV &0 D9; FOR @D9; LD 0.00; OUT W0.00; NEXT";
    assert_eq!(iterations(through, ""), [65_535], "where the count stands is not followed");
    assert_eq!(iterations(&through.replace("@D9", "A500"), ""), [65_535]);
    assert_eq!(iterations("FOR D0; LD 0.00; OUT W0.00; NEXT", "[counts]\nD0 = [0, 20]\n"), [20]);
}

/// The bound is that of the longest loop, whether it is followed or summed up.
#[test]
fn a_loop_costs_what_its_iterations_cost() {
    let of = |lines: &str| {
        let (inputs, table) = (listed(lines.replace("; ", "\n") + "\nEND\n"), table("MOV,5,2,0\n"));
        let facts = Facts::default();
        let dialect = Some("omron-cx");
        let request = Request { dialect, table: Some(&table), ..Request::new(&inputs, &facts) };
        let concluded = conclude(follow(&request).expect("a model"), &request).expect("an audit");
        let bound = &concluded.audit.bound;
        [bound.upper, bound.lower].map(|time| (time.0 - bound.overhead.0) / 1_000_000)
    };
    let turns = |first: &str| format!("LD P_On; {first}; FOR D0; LD 0.00; MOV &1 D9; NEXT");
    assert_eq!(of(&turns("ANDW #0 D1 D0")), [0, 0]);
    assert_eq!(of(&turns("ANDW #7 D1 D0")), [35, 35]);
    // A count from 32,768 on is no negative one.
    assert_eq!(of(&turns("ORW #FFF0 D1 D0"))[0], 65_535 * 5);
    let exclusive =
        "LD P_On; ANDW #7 D1 D0; FOR D0; LD 0.00; MOV &1 D9; NEXT; LD= D0 &0; MOV &1 D8";
    assert_eq!(of(exclusive), [7 * 5 + 2, 7 * 5 + 2], "with a count of 0 there is no iteration");
}

#[test]
fn a_count_that_the_system_may_change_is_not_followed() {
    assert_eq!(most("LD P_On; MOV &5 A500; XFER A500 D100 D200"), None);
}

/// W474: SRCH gives the address to IR0 and the number of finds to DR0, MAX and MIN where that is asked for the address.
#[test]
fn what_searches_find_goes_to_registers_that_they_do_not_name() {
    let behind = |search: &str, register: &str| {
        most(&format!("LD P_On; MOVL &5 IR0; MOV &5 DR0; {search}; {register}; XFER D10 D100 D200"))
    };
    for (register, searches) in [
        ("MOVL IR0 D10", &["SRCH D0 D100 D2", "MAX D0 D100 D20", "MIN D0 D100 D20"][..]),
        ("MOV DR0 D10", &["SRCH D0 D100 D2"]),
    ] {
        assert_eq!(behind("BCNT D0 D100 D20", register), Some(5));
        for search in searches {
            assert_eq!(behind(search, register), Some(65_535), "{search}");
        }
    }
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn no_scan_counts_further_than_words_were_found_to_hold() {
    let (tally, table) = (Tally::default(), table(TIMES));
    let of = Asked { trust: Trust::None, facts: nothing, loops: false, bound: false };
    on_tapes(cases(80), 160, |tape| check(tape, &of, &table, &tally));
    let (counts, small) = (tally.counts.get(), tally.small.get());
    println!("{counts} counts, {small} of them small");
    assert!(small > cases(80) / 6 && small * 10 > counts, "{small} of {counts}");
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn no_run_from_power_up_breaks_what_words_are_trusted_to_hold() {
    let (tally, table) = (Tally::default(), table(TIMES));
    for trust in [Trust::Counts, Trust::All] {
        let of = Asked { trust, facts: nothing, loops: false, bound: false };
        on_tapes(cases(40), 160, |tape| check(tape, &of, &table, &tally));
    }
    let trusted = tally.trusted.get();
    println!("{} counts, {trusted} words trusted", tally.counts.get());
    assert!(trusted > cases(40) / 20, "{trusted} words trusted");
}

#[test]
#[allow(clippy::print_stdout)] // a long run's figures
fn no_scan_takes_longer_than_its_bound() {
    let (tally, table) = (Tally::default(), table(TIMES));
    for trust in [Trust::None, Trust::Counts, Trust::All] {
        for (facts, loops) in [(nothing as Stated, false), (ranges, true), (counts, true)] {
            let of = Asked { trust, facts, loops, bound: true };
            on_tapes(cases(2), 120, |tape| check(tape, &of, &table, &tally));
        }
    }
    println!("{} scans", tally.scans.get());
}

/// The bound of a program where so much is trusted.
fn bound(lines: &str, trust: Trust, table: &Table) -> Result<Picos, String> {
    let (inputs, facts) = (listed(lines), Facts::default());
    let request = Request {
        dialect: Some("omron-cx"),
        table: Some(table),
        trust,
        ..Request::new(&inputs, &facts)
    };
    let concluded = follow(&request).and_then(|followed| conclude(followed, &request));
    concluded.map(|concluded| concluded.audit.bound.upper).map_err(|why| format!("{why:?}"))
}

#[test]
fn more_trust_never_makes_a_bound_larger() {
    let table = table(TIMES);
    on_tapes(cases(10), 120, |tape| {
        let lines = generate(&mut Tape::new(tape), true, false).join("\n") + "\n";
        let of = |trust| bound(&lines, trust, &table).map_err(|why| format!("{why}\n{lines}"));
        let (none, counts, all) = (of(Trust::None)?, of(Trust::Counts)?, of(Trust::All)?);
        match all <= counts && counts <= none {
            true => Ok(()),
            false => Err(format!("none {none}, counts {counts}, all {all}\n{lines}")),
        }
    });
}

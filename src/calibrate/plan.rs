//! What a calibration measures: blocks, how often they go round, and which step measures what.

use super::forms::{BY_DATA, Form, Left, Shape, operands, rungs};
use super::language::{Language, SETTLING};
use super::program::Block;
use crate::base::time::Picos;
use crate::timing::table::Table;
use serde::{Deserialize, Serialize};

/// How a calibration is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Over how many scans each step is read.
    pub scans: u32,
    /// What a scan is to take at most, by the table.
    pub scan_time: Picos,
    /// How many steps of program memory a part may take.
    pub memory: u32,
}

/// A calibration: the programs of a CPU, and what their results mean.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// The kind of file.
    pub schema: String,
    /// The CPU.
    pub cpu: String,
    /// The built-in table whose times are to be replaced.
    pub table: String,
    /// The table's family.
    pub family: String,
    /// Over how many scans each step is read.
    pub scans: u32,
    /// The programs, which are run one after the other.
    pub parts: Vec<Part>,
    /// What is not measured.
    pub left: Vec<Left>,
}

/// The kind of file that plans are. `calibrate fit` alone reads them, so no schema of them is published.
pub const SCHEMA: &str = "calibration/1";

/// A program that measures, and what its results mean.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Its file.
    pub file: String,
    /// How many steps it measures.
    pub steps: u32,
    /// How many steps of program memory it takes, estimated high.
    pub memory: u32,
    /// How long it takes by the table, in milliseconds.
    pub takes_ms: u64,
    /// How long its longest scan takes by the table, in microseconds.
    pub longest_us: u64,
    /// What is measured.
    pub measures: Vec<Measure>,
    /// Two steps that measure the same, first and last.
    pub reference: [u32; 2],
    /// Blocks of many instructions, to check the others' sum.
    pub sum: Option<Sum>,
}

/// A difference of two steps.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Measure {
    /// The row of a timing table.
    pub row: String,
    /// The line of which there are copies.
    pub line: String,
    /// Whether its time depends on its data.
    pub by_data: bool,
    /// How many units a copy handles; 0 where nothing is counted.
    pub units: u64,
    /// In which state it is measured.
    pub state: State,
    /// How many copies more the first step has.
    pub copies: u64,
    /// How often these are run in a scan.
    pub loops: u64,
    /// Whether each copy brings a coil along.
    pub with_coil: bool,
    /// The step with many copies.
    pub full: u32,
    /// The step with few.
    pub base: u32,
}

/// Whether an instruction fires.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// It does not.
    Off,
    /// It does, on data of this number.
    On(usize),
}

/// A block of one copy of many instructions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sum {
    /// The lines that the first step has beyond the second.
    pub lines: Vec<String>,
    /// How often they are run in a scan.
    pub loops: u64,
    /// The step with all.
    pub full: u32,
    /// The step with few.
    pub base: u32,
}

/// Copies in a rung: a ladder editor shows no more.
const IN_RUNG: u64 = 20;
/// The most copies of a block.
const MOST_COPIES: u64 = 400;
/// The most times round a loop.
const MOST_LOOPS: u64 = 32_767;
/// The most steps of a part: their results are words of one area.
const MOST_STEPS: u32 = 400;

/// So many steps more are reckoned with while a part is laid out: those of a form, of the sum and of the last reference.
const AHEAD: u32 = 16;

/// A part that is being laid out.
struct Building {
    language: Language,
    blocks: Vec<Block>,
    part: Part,
    /// What all its scans take, by the table.
    time: u128,
    forms: Vec<Form>,
}

/// Lays out a calibration. Gives the plan and each part's blocks.
#[must_use]
pub fn lay_out(
    forms: &[Form],
    left: Vec<Left>,
    table: &Table,
    language: Language,
    cpu: &str,
    settings: Settings,
) -> (Plan, Vec<Vec<Block>>) {
    let costs = Costs::of(table, settings);
    let mut left = left;
    let mut done: Vec<(Part, Vec<Block>)> = Vec::new();
    let mut building = Building::new(language);
    for form in forms {
        if form.assumed.0.saturating_mul(2) > settings.scan_time.0 {
            let why = "two of it may take longer than a scan is to take".to_owned();
            left.push(Left { row: form.row.clone(), why, share: form.share });
            continue;
        }
        let added = building.sized(form, &costs) + building.besides(settings);
        let full = building.part.memory + added > settings.memory
            || building.part.steps + AHEAD > MOST_STEPS;
        if full && !building.forms.is_empty() {
            let ended = std::mem::replace(&mut building, Building::new(language));
            done.push(ended.end(&costs, settings));
        }
        building.measure(form, &costs, settings);
    }
    if !building.forms.is_empty() {
        done.push(building.end(&costs, settings));
    }
    let mut parts = Vec::new();
    let mut blocks = Vec::new();
    for (number, (part, own)) in (1..).zip(done) {
        let suffix = if language == Language::Cs { "il" } else { "csv" };
        parts.push(Part { file: format!("part{number}.{suffix}"), ..part });
        blocks.push(own);
    }
    let plan = Plan {
        schema: SCHEMA.to_owned(),
        cpu: cpu.to_owned(),
        table: table.base.clone().unwrap_or_else(|| table.name.clone()),
        family: table.family.clone().unwrap_or_default(),
        scans: settings.scans,
        parts,
        left,
    };
    (plan, blocks)
}

/// What is reckoned with besides the instructions that are measured, by the table.
struct Costs {
    /// A time round a loop.
    round: u64,
    /// A contact and a coil.
    rung: u64,
    /// What a scan takes besides.
    scan: u64,
    /// What a scan is to take at most.
    most: u64,
}

impl Costs {
    fn of(table: &Table, settings: Settings) -> Costs {
        let on = |name: &str| table.row(name).map_or(0, |row| row.on.0);
        let rows = ["@end", "@program"].map(on);
        Costs {
            round: 2 * on("FOR").max(on("@loop")),
            rung: on("LD") + on("OUT").max(on("OUT:M")),
            scan: rows.iter().sum(),
            most: settings.scan_time.0,
        }
    }

    /// How many copies of an instruction go into a block, by tens and twenties: as many as take what a time round the loop
    /// takes.
    fn copies(&self, form: &Form) -> [u64; 2] {
        let each = form.assumed.0.max(1);
        let wanted = self.round.div_ceil(each).clamp(IN_RUNG, MOST_COPIES);
        // One more of each rung is in both blocks.
        let fits = (self.most / each / 2).max(1);
        let copies = wanted.min(fits);
        match copies < IN_RUNG {
            true => [1, copies],
            false => [copies.div_ceil(IN_RUNG), IN_RUNG],
        }
    }

    /// How often a block is run in a scan.
    fn loops(&self, once: u64) -> u64 {
        (self.most / (once + self.round).max(1)).clamp(1, MOST_LOOPS)
    }
}

impl Building {
    fn new(language: Language) -> Building {
        let part = Part {
            file: String::new(),
            steps: 0,
            memory: 0,
            takes_ms: 0,
            longest_us: 0,
            measures: Vec::new(),
            reference: [0, 0],
            sum: None,
        };
        let mut building =
            Building { language, blocks: Vec::new(), part, time: 0, forms: Vec::new() };
        building.reference();
        building
    }

    /// Adds a block, and gives its first step.
    fn add(&mut self, rungs: Vec<String>, loops: u64, operands: Vec<Vec<(u32, u16)>>) -> u32 {
        let first = self.part.steps;
        let states = 1 + u32::try_from(operands.len()).unwrap_or(0);
        self.part.steps += states;
        let label = self.language.label(u32::try_from(self.blocks.len()).unwrap_or(0));
        let loops = u32::try_from(loops).unwrap_or(1);
        let block = Block { first, states, label, loops, operands, rungs };
        self.part.memory += block.size(self.language);
        self.blocks.push(block);
        first
    }

    /// A loop with nothing in it, which shows whether two moments are alike.
    fn reference(&mut self) -> u32 {
        self.add(Vec::new(), 1000, Vec::new())
    }

    /// What measuring a form takes of the program memory.
    fn sized(&self, form: &Form, costs: &Costs) -> u32 {
        let [rungs, copies] = costs.copies(form);
        let lines = u32::try_from(rungs * (copies + 2)).unwrap_or(u32::MAX);
        let each = self.language.size(&form.line) + 1;
        lines * each + 32 * 16
    }

    /// What the head and the sum take of the program memory when all is laid out.
    fn besides(&self, settings: Settings) -> u32 {
        let size =
            |lines: &[String]| lines.iter().map(|line| self.language.size(line)).sum::<u32>();
        let head = self.language.head(self.part.steps + AHEAD, settings.scans);
        let each: Vec<String> = self.forms.iter().map(|form| form.line.clone()).collect();
        size(&head) + 2 * size(&each) + 200
    }

    fn measure(&mut self, form: &Form, costs: &Costs, settings: Settings) {
        let [count, copies] = costs.copies(form);
        let own = |copies: u64| -> Vec<String> {
            let copies = u32::try_from(copies).unwrap_or(1);
            (0..count).flat_map(|_| rungs(&form.line, form.shape, copies, self.language)).collect()
        };
        let (many, few) = (own(copies + 1), own(1));
        let with_coil = form.shape == Shape::Start;
        let each = form.assumed.0 + if with_coil { costs.rung } else { 0 };
        let once = count * ((copies + 1) * each + costs.rung);
        let loops = costs.loops(once);
        let data: Vec<Vec<(u32, u16)>> =
            operands(form.class).iter().map(|one| one.to_vec()).collect();
        let states = data.len();
        let full = self.add(many, loops, data.clone());
        let base = self.add(few, loops, data);
        let on = (0..states).map(State::On);
        for (state, at) in std::iter::once(State::Off).chain(on).zip(0..) {
            self.part.measures.push(Measure {
                row: form.row.clone(),
                line: form.line.clone(),
                by_data: BY_DATA.contains(&form.class),
                units: form.units,
                state,
                copies: count * copies,
                loops,
                with_coil,
                full: full + at,
                base: base + at,
            });
        }
        let scan = |once: u64| u128::from(loops * (once + costs.round) + costs.scan);
        let (long, short) = (scan(once), scan(count * (each + costs.rung)));
        let scans = u128::from(settings.scans + SETTLING) * (1 + states as u128);
        self.time += (long + short) * scans;
        self.took(long);
        self.forms.push(form.clone());
    }

    /// A scan that takes so long.
    fn took(&mut self, time: u128) {
        let us = u64::try_from(time.div_ceil(1_000_000)).unwrap_or(u64::MAX);
        self.part.longest_us = self.part.longest_us.max(us);
    }

    /// A block of a copy of each instruction that stands behind a contact.
    fn sum(&mut self, costs: &Costs, settings: Settings) {
        let plain = |form: &&Form| {
            form.shape == Shape::Action
                && operands(form.class) == operands("")
                && form.assumed.0.saturating_mul(4) < costs.most
        };
        let forms: Vec<Form> = self.forms.iter().filter(plain).cloned().collect();
        if forms.len() < 3 {
            return;
        }
        let state = format!("LD {}", self.language.state());
        let (mut all, mut few, mut lines, mut once) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for rung in forms.chunks(IN_RUNG as usize) {
            all.push(state.clone());
            few.push(state.clone());
            for (at, form) in rung.iter().enumerate() {
                all.push(form.line.clone());
                once += form.assumed.0;
                match at {
                    0 => few.push(form.line.clone()),
                    _ => lines.push(form.line.clone()),
                }
            }
        }
        let loops = costs.loops(once);
        let data = vec![operands("")[0].to_vec()];
        let full = self.add(all, loops, data.clone());
        let base = self.add(few, loops, data);
        // Only the state in which they fire is looked at.
        self.part.sum = Some(Sum { lines, loops, full: full + 1, base: base + 1 });
        let scan = u128::from(loops * (once + costs.round) + costs.scan);
        self.time += scan * u128::from(4 * (settings.scans + SETTLING));
        self.took(scan);
    }

    /// The part, and its blocks.
    fn end(mut self, costs: &Costs, settings: Settings) -> (Part, Vec<Block>) {
        self.sum(costs, settings);
        let last = self.reference();
        self.part.reference = [0, last];
        self.time += u128::from(2 * (1000 * costs.round + costs.scan))
            * u128::from(settings.scans + SETTLING);
        let head = self.language.head(self.part.steps, settings.scans);
        self.part.memory += head.iter().map(|line| self.language.size(line)).sum::<u32>();
        self.part.takes_ms = u64::try_from(self.time / 1_000_000_000).unwrap_or(u64::MAX);
        (self.part, self.blocks)
    }
}

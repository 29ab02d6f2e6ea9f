//! The plan of a calibration: blocks, how often they are executed, and what each step measures.

use super::forms::{BY_DATA, Form, Unmeasured, operands};
use super::language::{Language, SETTLING};
use super::program::{Block, LaidOut};
use scanbound_base::time::Picos;
use scanbound_timing::table::Table;
use serde::{Deserialize, Serialize};

/// The settings of a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// The number of scans over which each step is measured.
    pub scans: u32,
    /// The longest scan, by the table.
    pub scan_time: Picos,
    /// The most steps of program memory for each part.
    pub memory: u32,
}

/// A calibration: the programs for a CPU, and the meaning of their results.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// The version of the file format.
    pub schema: String,
    /// The CPU.
    pub cpu: String,
    /// The built-in table whose times are to be replaced.
    pub table: String,
    /// The table's family.
    pub family: String,
    /// The number of scans over which each step is measured.
    pub scans: u32,
    /// The programs, which are run one after the other.
    pub parts: Vec<Part>,
    /// The instructions that are not measured.
    pub left: Vec<Unmeasured>,
}

/// The version of the format of plans. Only `calibrate fit` reads them, so no schema is published.
pub const SCHEMA: &str = "calibration/2";

/// A measuring program, and the meaning of its results.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Its file.
    pub file: String,
    /// The number of its steps.
    pub steps: u32,
    /// The number of steps at the beginning that measure an empty scan.
    pub empty: u32,
    /// An upper estimate of the program memory that it takes, in steps.
    pub memory: u32,
    /// The time that it runs by the table, in milliseconds.
    pub takes_ms: u64,
    /// The time of its longest scan by the table, in microseconds.
    pub longest_us: u64,
    /// The measurements.
    pub measures: Vec<Measure>,
    /// Two steps that measure the same, at the beginning and at the end.
    pub reference: [u32; 2],
    /// Blocks of many instructions, to check the sum of the single times.
    pub sum: Option<Sum>,
}

/// A measurement: the difference of two steps.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Measure {
    /// The row of a timing table.
    pub row: String,
    /// The line that is copied.
    pub line: String,
    /// The measured instruction: the line itself, or one in the routine that it calls.
    pub own: String,
    /// Whether its time depends on its data.
    pub by_data: bool,
    /// The number of units that a copy handles. 0 if it has no count.
    pub units: u64,
    /// The state in which it is measured.
    pub state: State,
    /// How many more copies the first step has.
    pub copies: u64,
    /// How often they are executed in a scan.
    pub loops: u64,
    /// How often each copy executes the instruction.
    pub runs: u64,
    /// The other instructions that each copy needs.
    pub besides: Vec<Beside>,
    /// The step with many copies.
    pub full: u32,
    /// The step with few copies.
    pub base: u32,
}

/// Another instruction that a copy needs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Beside {
    /// The instruction.
    pub line: String,
    /// Whether it fires.
    pub on: bool,
}

/// Whether an instruction fires.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// It does not fire.
    Off,
    /// It fires, on the list of data with this number.
    On(usize),
}

/// A block with one copy each of many instructions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sum {
    /// The lines that the first step has in addition to the second.
    pub lines: Vec<String>,
    /// How often they are executed in a scan.
    pub loops: u64,
    /// The step with all lines.
    pub full: u32,
    /// The step with few lines.
    pub base: u32,
}

/// The most copies in a rung: ladder editors do not show more.
const IN_RUNG: u64 = 20;
/// The most copies in a block.
const MAX_COPIES: u64 = 400;
/// The most iterations of a loop.
const MAX_LOOPS: u64 = 32_767;
/// The most copies in a rung if each needs its own label.
const LABELLED: u64 = 10;
/// The number of labels that the blocks of such copies need.
const LABELS: u32 = 16;
/// The number of steps at the beginning that measure an empty scan: the time of END varies.
const EMPTY: u32 = 5;
/// The most steps of a part: their results must fit into one area.
const MAX_STEPS: u32 = 400;

/// The number of steps that are kept free while a part is laid out: for a form, the sum and the last reference.
const AHEAD: u32 = 16;

/// A part under construction.
struct Building {
    language: Language,
    laid: LaidOut,
    /// The number of used labels.
    labels: u32,
    part: Part,
    /// The time of all its scans, by the table.
    time: u128,
    forms: Vec<Form>,
}

/// Plans a calibration. Returns the plan and each part's blocks.
#[must_use]
pub fn lay_out(
    forms: &[Form],
    left: Vec<Unmeasured>,
    table: &Table,
    language: Language,
    cpu: &str,
    settings: Settings,
) -> (Plan, Vec<LaidOut>) {
    // The FX1 and FX2 series have no more labels.
    let most_labels = if cpu.starts_with("FX2") || cpu.starts_with("FX1") { 120 } else { 1000 };
    let costs = Costs::of(table, settings);
    let mut left = left;
    let mut done: Vec<(Part, LaidOut)> = Vec::new();
    let mut building = Building::new(language);
    for form in forms {
        if form.assumed.0.saturating_mul(2) > settings.scan_time.0 {
            let why =
                "two copies of it may take longer than the longest permitted scan (--scan-time)"
                    .to_owned();
            left.push(Unmeasured { row: form.row.clone(), why, share: form.share });
            continue;
        }
        let added = building.sized(form, &costs) + building.besides(settings);
        let full = building.part.memory + added > settings.memory
            || building.part.steps + AHEAD > MAX_STEPS
            || building.labels + AHEAD + if form.rung.labels() { LABELS } else { 0 } > most_labels;
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
    let mut laid = Vec::new();
    for (number, (part, own)) in (1..).zip(done) {
        let suffix = if language == Language::Cs { "il" } else { "csv" };
        parts.push(Part { file: format!("part{number}.{suffix}"), ..part });
        laid.push(own);
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
    (plan, laid)
}

/// Estimated times of everything other than the measured instructions, by the table.
struct Costs {
    /// One iteration of a loop.
    round: u64,
    /// A contact and a coil.
    rung: u64,
    /// The overhead of a scan.
    scan: u64,
    /// A block that is skipped.
    skip: u64,
    /// The longest permitted scan.
    most: u64,
}

impl Costs {
    fn of(table: &Table, settings: Settings) -> Costs {
        let on = |name: &str| table.row(name).map_or(0, |row| row.on.0);
        let ends = table.rows().iter().filter(|row| row.name.starts_with("@end:"));
        let ends: u64 = ends.map(|row| row.on.0).sum();
        Costs {
            round: 2 * on("FOR").max(on("@loop")),
            rung: on("LD") + on("OUT").max(on("OUT:M")),
            scan: on("@end") + on("@program") + ends,
            skip: 2 * on("@compare") + on("@jump").max(on("CJ")).max(on("JMP")),
            most: settings.scan_time.0,
        }
    }

    /// The numbers of copies in the two blocks, in multiples of ten and twenty: so many that they take about as long as
    /// the overhead of an iteration.
    fn copies(&self, form: &Form) -> [u64; 2] {
        let each = form.assumed.0.saturating_mul(form.runs).max(1);
        if form.rung.labels() {
            return [1, (self.most / each / 2).clamp(1, LABELLED)];
        }
        let wanted = self.round.div_ceil(each).clamp(IN_RUNG, MAX_COPIES);
        // Both blocks contain one more of each rung.
        let fits = (self.most / each / 2).max(1);
        let copies = wanted.min(fits);
        match copies < IN_RUNG {
            true => [1, copies],
            false => [copies.div_ceil(IN_RUNG), IN_RUNG],
        }
    }

    /// How often a block is executed in a scan.
    fn loops(&self, once: u64) -> u64 {
        (self.most / (once + self.round).max(1)).clamp(1, MAX_LOOPS)
    }
}

impl Building {
    fn new(language: Language) -> Building {
        let part = Part {
            file: String::new(),
            steps: EMPTY,
            empty: EMPTY,
            memory: 0,
            takes_ms: 0,
            longest_us: 0,
            measures: Vec::new(),
            reference: [0, 0],
            sum: None,
        };
        let mut building = Building {
            language,
            laid: LaidOut::default(),
            labels: 0,
            part,
            time: 0,
            forms: Vec::new(),
        };
        building.reference();
        building
    }

    /// An unused label.
    fn label(&mut self) -> u32 {
        self.labels += 1;
        self.language.label(self.labels - 1)
    }

    /// Adds a block, and returns its first step.
    fn add(
        &mut self,
        rungs: Vec<String>,
        loops: u64,
        operands: Vec<Vec<(u32, u16)>>,
        changes: bool,
    ) -> u32 {
        let first = self.part.steps;
        let states = 1 + u32::try_from(operands.len()).unwrap_or(0);
        self.part.steps += states;
        let label = self.label();
        let loops = u32::try_from(loops).unwrap_or(1);
        let block = Block { first, states, label, loops, operands, rungs, changes };
        self.part.memory += block.size(self.language);
        self.laid.blocks.push(block);
        first
    }

    /// An empty loop. Measured twice, it shows whether conditions have changed.
    fn reference(&mut self) -> u32 {
        self.add(Vec::new(), 1000, Vec::new(), false)
    }

    /// The program memory that measuring a form takes.
    fn sized(&self, form: &Form, costs: &Costs) -> u32 {
        let [rungs, copies] = costs.copies(form);
        let size =
            |lines: &[String]| lines.iter().map(|line| self.language.size(line)).sum::<u32>();
        let rung = &form.rung;
        let number = |number: u64| u32::try_from(number).unwrap_or(u32::MAX);
        let copy = self.language.size(&form.line) + size(&rung.before) + size(&rung.after);
        let around = size(&rung.open) + size(&rung.close);
        number(rungs * (copies + 2)) * copy + number(2 * rungs) * around + 32 * 16
    }

    /// The program memory that the head and the sum take at the end.
    fn besides(&self, settings: Settings) -> u32 {
        let size =
            |lines: &[String]| lines.iter().map(|line| self.language.size(line)).sum::<u32>();
        let head = self.language.head(EMPTY, self.part.steps + AHEAD, settings.scans);
        let each: Vec<String> = self.forms.iter().map(|form| form.line.clone()).collect();
        size(&head) + 2 * size(&each) + 200
    }

    fn measure(&mut self, form: &Form, costs: &Costs, settings: Settings) {
        let [count, copies] = costs.copies(form);
        let routine = match form.rung.routine.is_empty() {
            true => 0,
            false => self.label(),
        };
        let own = |building: &mut Building, copies: u64| {
            form.rung.lines(&form.line, [count, copies], routine, || building.label())
        };
        let (many, few) = (own(self, copies + 1), own(self, 1));
        let lines = form.rung.routine.iter();
        let lines = lines.map(|line| line.replace(super::rung::ROUTINE, &routine.to_string()));
        self.laid.routines.extend(lines);
        let others = form.rung.besides(&form.line, &form.own);
        // The times of other instructions are unknown here: assume a rung, or as much as this instruction if that is
        // more.
        let besides = others.len() as u64 * costs.rung.max(form.assumed.0);
        let each = form.assumed.0.saturating_mul(form.runs) + besides;
        let once = count * ((copies + 1) * each + costs.rung);
        let changes = form.rung.changes;
        // It fires in every other iteration.
        let loops = match (costs.loops(once), changes) {
            (loops, true) => loops.next_multiple_of(2).min(MAX_LOOPS - 1),
            (loops, false) => loops,
        };
        let data: Vec<Vec<(u32, u16)>> =
            operands(form.class).iter().map(|one| one.to_vec()).collect();
        let states = data.len();
        let full = self.add(many, loops, data.clone(), changes);
        let base = self.add(few, loops, data, changes);
        let on = (0..states).map(State::On);
        for (state, at) in std::iter::once(State::Off).chain(on).zip(0..) {
            let fires = state != State::Off;
            let with = |on: bool| others.iter().map(move |line| Beside { line: line.clone(), on });
            let mut besides: Vec<Beside> = with(fires).collect();
            let mut rounds = loops;
            if changes && fires {
                // Two iterations count as one: with the edge, and without.
                besides.extend(with(false));
                besides.push(Beside { line: form.own.clone(), on: false });
                rounds = loops / 2;
            }
            self.part.measures.push(Measure {
                row: form.row.clone(),
                line: form.line.clone(),
                own: form.own.clone(),
                by_data: BY_DATA.contains(&form.class),
                units: form.units,
                state,
                copies: count * copies,
                loops: rounds,
                runs: form.runs,
                besides,
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

    /// Adds a scan of this time.
    fn took(&mut self, time: u128) {
        let us = u64::try_from(time.div_ceil(1_000_000)).unwrap_or(u64::MAX);
        self.part.longest_us = self.part.longest_us.max(us);
    }

    /// A block with one copy of each instruction that is placed behind a contact.
    fn sum(&mut self, costs: &Costs, settings: Settings) {
        let plain = |form: &&Form| {
            form.rung.is_action(self.language)
                && form.runs == 1
                && form.own == form.line
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
        let full = self.add(all, loops, data.clone(), false);
        let base = self.add(few, loops, data, false);
        // Only the state in which they fire is used.
        self.part.sum = Some(Sum { lines, loops, full: full + 1, base: base + 1 });
        let scan = u128::from(loops * (once + costs.round) + costs.scan);
        self.time += scan * u128::from(4 * (settings.scans + SETTLING));
        self.took(scan);
    }

    /// The finished part, and its blocks.
    fn end(mut self, costs: &Costs, settings: Settings) -> (Part, LaidOut) {
        self.sum(costs, settings);
        let last = self.reference();
        self.part.reference = [EMPTY, last];
        // Each scan skips the other blocks, and the head takes about as long as a few of them.
        let passed = costs.skip * (self.laid.blocks.len() as u64 + 8) * u64::from(self.part.steps);
        let others = passed + 2 * (1000 * costs.round + costs.scan) + u64::from(EMPTY) * costs.scan;
        self.time += u128::from(others) * u128::from(settings.scans + SETTLING);
        let head = self.language.head(EMPTY, self.part.steps, settings.scans);
        self.part.memory += head.iter().map(|line| self.language.size(line)).sum::<u32>();
        self.part.longest_us += (costs.skip * self.laid.blocks.len() as u64).div_ceil(1_000_000);
        self.part.takes_ms = u64::try_from(self.time / 1_000_000_000).unwrap_or(u64::MAX);
        (self.part, self.laid)
    }
}

//! Random programs of the intermediate representation, without a dialect: every step, source, write and region.

use super::tape::Tape;
use scanbound::base::location::Location;
use scanbound::base::time::{Picos, Times};
use scanbound::program::{
    AccessedDevices, Area, AreaId, AreaKind, BitSource, BitTarget, Cell, ChoiceId, Compare,
    Counted, Effect, Exit, Instruction, Interrupt, Join, Logic, Number, NumberFormat, Program,
    Radix, Region, Relation, StartRange, Step, Summary, TimingKey, Units, When, WordSource,
    WordTarget, Write,
};

const BITS: u32 = 6;
const WORDS: u32 = 3;

pub fn bit(index: u32) -> Cell {
    Cell { area: AreaId(0), index }
}

pub fn word(index: u32) -> Cell {
    Cell { area: AreaId(1), index }
}

/// What a generated program may contain.
#[derive(Debug, Clone, Copy)]
pub struct Taste {
    /// Comparisons, word writes and loops by a word.
    pub words: bool,
    /// Sums and bitwise operations.
    pub arithmetic: bool,
    /// Real comparisons.
    pub reals: bool,
    /// Choices and havocked regions.
    pub choices: bool,
    /// Jumps, calls, loops, master control regions, stops and interrupts.
    pub control: bool,
    /// The most items of a block.
    pub items: usize,
}

/// The target of a jump that is not yet resolved.
struct Pending {
    at: usize,
    /// The exit of a loop summary, or the jump's own target.
    exit: Option<usize>,
    items: usize,
}

struct Generator<'t, 'a> {
    tape: &'t mut Tape<'a>,
    taste: Taste,
    instructions: Vec<Instruction>,
    block: u32,
    slots: u32,
    masters: u32,
    choices: u32,
    /// Choices from this number on belong to the current instruction.
    shareable: u32,
    /// Unresolved calls: instruction and routine.
    calls: Vec<(usize, usize)>,
    routines: usize,
    /// Jumps out of the enclosing loops: one list for each loop that can be left here.
    breaks: Vec<Vec<usize>>,
}

/// A program and times for its instructions.
pub fn generate(tape: &mut Tape<'_>, taste: Taste) -> (Program, Vec<Times>) {
    let mut g = Generator {
        tape,
        taste,
        instructions: Vec::new(),
        block: 0,
        slots: 0,
        masters: 0,
        choices: 0,
        shareable: 0,
        calls: Vec::new(),
        routines: 0,
        breaks: Vec::new(),
    };
    let mut mains = Vec::new();
    let count = if taste.control { 1 + usize::from(g.tape.percent(20)) } else { 1 };
    for _ in 0..count {
        let start = g.instructions.len();
        g.items(0, 0);
        if g.tape.percent(50) {
            g.put(Step::End, vec![]);
        }
        mains.push(start..g.instructions.len());
    }
    let mut interrupts = Vec::new();
    if taste.control && g.tape.percent(15) {
        let entry = g.instructions.len();
        let times = g.tape.pick(&[1, 2, 0]);
        g.items(1, 0);
        g.put(Step::Return, vec![]);
        interrupts.push(Interrupt { name: "I0".to_owned(), entry, times, stated: true });
    }
    let mut entries = Vec::new();
    while entries.len() < g.routines {
        entries.push(g.instructions.len());
        g.items(1, entries.len());
        let last = g.tape.below(20) == 19;
        g.put(if last { Step::End } else { Step::Return }, vec![]);
    }
    for (at, routine) in std::mem::take(&mut g.calls) {
        if let Step::Call { target, .. } = &mut g.instructions[at].step {
            *target = entries[routine];
        }
    }
    let mut ranges = Vec::new();
    if taste.words && g.tape.percent(20) {
        let (low, high) = g.tape.pick(&[(0, 2), (-1, 1), (1, 1), (2, 40_000), (-40_000, -2)]);
        let double = !(-32_768..=32_767).contains(&low) || high > 32_767 || g.tape.percent(20);
        let cells = if double { vec![word(0), word(1)] } else { vec![word(0)] };
        ranges.push(StartRange { cells, low, high, values: Vec::new() });
    }
    let times = times(g.tape, g.instructions.len());
    let area = |name: &str, kind| Area::new(name, kind, Radix::Decimal);
    let program = Program {
        areas: vec![area("M", AreaKind::Bit), area("D", AreaKind::Word)],
        instructions: g.instructions,
        mains,
        interrupts,
        blocks: g.block,
        choices: g.choices,
        stated_ranges: ranges,
        ..Program::default()
    };
    (program, times)
}

/// Times such that almost no two sets of instructions have the same sum; the off-time is sometimes the larger.
pub fn times(tape: &mut Tape<'_>, count: usize) -> Vec<Times> {
    (0..count)
        .map(|_| {
            let (on, off) = match tape.below(4) {
                0 => (100 + tape.below(400), tape.below(10)),
                1 => (10, 10),
                2 => (tape.below(50), 50 + tape.below(200)),
                _ => (tape.below(300), tape.below(300)),
            };
            let per_unit = Picos(if on % 3 == 0 { 0 } else { on as u64 % 50 });
            Times { per_unit, ..Times::new(Picos(on as u64), Picos(off as u64)) }
        })
        .collect()
}

impl Generator<'_, '_> {
    fn put(&mut self, step: Step, effects: Vec<Effect>) -> usize {
        let text = format!("{} {step:?}", self.instructions.len()).into();
        let place = Location { file: 0, line: self.instructions.len() as u32 + 1, step: None };
        let block = self.block;
        let counts = self.taste.words && matches!(step, Step::Act { .. }) && self.tape.percent(40);
        let timing = counts.then(|| Box::new(self.counted()));
        self.instructions.push(Instruction {
            place,
            block,
            text,
            operands: std::sync::Arc::default(),
            timing,
            effects,
            step,
        });
        self.instructions.len() - 1
    }

    /// An instruction whose units are counted by one or two words.
    fn counted(&mut self) -> TimingKey {
        let words =
            (0..1 + usize::from(self.tape.percent(20))).map(|_| self.word_source()).collect();
        let most = self.tape.pick(&[3, 1, 2, 0, 5, 0x4000, 0xFFFF, 0x1_0000, 0x1_2345]);
        let each = self.tape.pick(&[1, 2, 3]);
        TimingKey {
            names: vec!["Op".to_owned()],
            class: "block",
            units: Units::Counted(Counted { words, each, most, executes_up_to: most }),
            use_larger_time: false,
            optional: false,
            accessed: AccessedDevices::default(),
        }
    }

    fn fresh(&mut self) -> ChoiceId {
        self.choices += 1;
        ChoiceId(self.choices - 1)
    }

    /// A block of items. Calls go to routines from `callable` on, so that there is no recursion.
    fn items(&mut self, depth: usize, callable: usize) {
        let count = 1 + self.tape.below(self.taste.items) / (depth + 1);
        let mut pending: Vec<Pending> = Vec::new();
        for _ in 0..count {
            self.block += 1;
            self.item(depth, callable, &mut pending);
            let here = self.instructions.len();
            for jump in &mut pending {
                jump.items -= 1;
            }
            pending.retain(|jump| {
                if jump.items == 0 {
                    aim(&mut self.instructions[jump.at].step, jump.exit, here);
                }
                jump.items > 0
            });
            if self.tape.done() {
                break;
            }
        }
        let here = self.instructions.len();
        for jump in pending {
            aim(&mut self.instructions[jump.at].step, jump.exit, here);
        }
    }

    fn item(&mut self, depth: usize, callable: usize, pending: &mut Vec<Pending>) {
        let kind = if self.taste.control && depth < 3 { self.tape.below(16) } else { 0 };
        match kind {
            10 => {
                self.contacts();
                let fires = self.fires();
                let at = self.put(Step::Jump { fires, target: 0 }, vec![]);
                pending.push(Pending { at, exit: None, items: 1 + 1 + self.tape.below(2) });
            }
            11 if callable < 3 => {
                self.contacts();
                let routine = callable + self.tape.below(3 - callable);
                self.routines = self.routines.max(routine + 1);
                let fires = self.fires();
                let at = self.put(Step::Call { fires, target: 0 }, vec![]);
                self.calls.push((at, routine));
            }
            12 => {
                self.contacts();
                let fires = self.fires();
                let level = self.masters;
                self.put(Step::MasterControlBegin { level, fires }, vec![]);
                let inner = u32::from(self.tape.percent(20));
                if inner == 1 {
                    self.contacts();
                    let fires = self.fires();
                    self.put(Step::MasterControlBegin { level: level + 1, fires }, vec![]);
                }
                let breaks = std::mem::take(&mut self.breaks);
                self.masters += 1 + inner;
                self.items(depth + 1, callable);
                self.masters -= 1 + inner;
                self.breaks = breaks;
                self.put(Step::MasterControlEnd { level }, vec![]);
            }
            13 => self.loops(depth, callable),
            14 if self.taste.choices && self.tape.percent(40) => self.summary(pending),
            14 => {
                self.contacts();
                let fires = self.fires();
                self.put(Step::Stop { fires }, vec![]);
            }
            15 if !self.breaks.is_empty() => {
                self.contacts();
                let fires = self.fires();
                let at = self.put(Step::Jump { fires, target: 0 }, vec![]);
                let out = self.tape.below(self.breaks.len());
                let last = self.breaks.len() - 1 - out;
                self.breaks[last].push(at);
            }
            _ => self.rung(),
        }
    }

    fn loops(&mut self, depth: usize, callable: usize) {
        let count = if self.taste.words && self.tape.percent(50) {
            self.word_source()
        } else {
            WordSource::Const(self.tape.pick(&[1, 2, 0, 3]))
        };
        let least = self.tape.pick(&[0, 0, 1]);
        let most = self.tape.pick(&[2, 1, 3]);
        let begin = self.put(Step::ForBegin { count, least, most, end: 0 }, vec![]);
        self.breaks.push(Vec::new());
        self.items(depth + 1, callable);
        let end = self.put(Step::ForEnd, vec![]);
        if let Step::ForBegin { end: slot, .. } = &mut self.instructions[begin].step {
            *slot = end;
        }
        for at in self.breaks.pop().expect("pushed above") {
            aim(&mut self.instructions[at].step, None, end + 1);
        }
    }

    fn summary(&mut self, pending: &mut Vec<Pending>) {
        let begin = self.put(Step::Nothing, vec![]);
        let first = self.instructions.len();
        self.rung();
        let end = self.put(Step::ForEnd, vec![]);
        let charged = first + self.tape.below(end - first);
        let charges = vec![(charged, 1 + self.tape.below(3) as u64), (end, 2)];
        let havocs = (0..self.tape.below(3)).map(|_| self.region()).collect();
        let choice = self.fresh();
        let exits: Vec<_> = (0..self.tape.below(3)).map(|_| (self.fresh(), Exit::To(0))).collect();
        for exit in 0..exits.len() {
            let items = 1 + self.tape.below(3);
            pending.push(Pending { at: begin, exit: Some(exit), items });
        }
        self.instructions[begin].step = Step::Summary(Box::new(Summary {
            end,
            charges,
            havocs,
            choice,
            exits,
            iterations: None,
        }));
    }

    /// Contacts that give one condition, then instructions that it controls.
    fn rung(&mut self) {
        self.contacts();
        for _ in 0..=self.tape.below(3) {
            let fires = self.fires();
            let effects = self.effects();
            self.put(Step::Act { fires }, effects);
            if self.tape.percent(20) {
                self.contact(Join::And);
            }
            if self.slots > 0 && self.tape.percent(20) {
                let slot = self.tape.below(self.slots as usize) as u32;
                self.put(Step::Fetch(slot), vec![]);
            }
        }
    }

    fn contacts(&mut self) {
        self.contact(Join::Start);
        self.slots = 0;
        let mut open = 0;
        for _ in 0..self.tape.below(5) {
            match self.tape.below(8) {
                0 | 1 => self.contact(Join::And),
                2 => self.contact(Join::Or),
                3 => {
                    self.contact(Join::Load);
                    open += 1;
                }
                4 if open > 0 => {
                    open -= 1;
                    let step = self.tape.pick(&[Step::AndBlock, Step::OrBlock]);
                    self.put(step, vec![]);
                }
                5 => {
                    self.put(Step::Save(self.slots), vec![]);
                    self.slots += 1;
                }
                6 if self.slots > 0 => {
                    let slot = self.tape.below(self.slots as usize) as u32;
                    self.put(Step::Fetch(slot), vec![]);
                }
                7 => {
                    let value = self.tape.pick(&[Logic::Condition.not(), Logic::Condition]);
                    self.put(Step::Logic { join: Join::Replace, value }, vec![]);
                }
                _ => self.contact(Join::And),
            }
        }
        while open > 0 && self.tape.percent(90) {
            open -= 1;
            let step = self.tape.pick(&[Step::AndBlock, Step::OrBlock]);
            self.put(step, vec![]);
        }
    }

    fn contact(&mut self, join: Join) {
        let value = self.logic(2);
        let effects = if self.tape.percent(20) { self.effects() } else { vec![] };
        self.put(Step::Logic { join, value }, effects);
    }

    fn fires(&mut self) -> Logic {
        match self.tape.below(8) {
            0..=4 => Logic::Condition,
            5 => Logic::All(vec![Logic::Condition, self.logic(1)]),
            6 => Logic::All(vec![Logic::Condition, self.logic(1).not()]),
            _ => self.logic(2),
        }
    }

    fn effects(&mut self) -> Vec<Effect> {
        let count = self.tape.pick(&[1, 0, 1, 2, 3]);
        self.shareable = self.choices;
        (0..count)
            .map(|_| {
                let when = self.tape.pick(&[When::Fired, When::Always]);
                Effect { when, write: self.write() }
            })
            .collect()
    }

    fn write(&mut self) -> Write {
        match self.tape.below(8) {
            4..=6 if self.taste.words => {
                let words = 1 + self.tape.below(2);
                let targets = (0..words).map(|_| self.word_target()).collect();
                Write::Words(targets, self.number(words, 2))
            }
            7 if self.taste.choices => {
                // Havocs of one instruction may share their choice.
                let choice = if self.choices > self.shareable && self.tape.percent(50) {
                    ChoiceId(self.choices - 1)
                } else {
                    self.fresh()
                };
                Write::Havoc(self.region(), choice)
            }
            _ => {
                let target = if self.taste.words && self.tape.percent(20) {
                    BitTarget::WordBit(self.word(), self.tape.pick(&[0, 1, 15]))
                } else {
                    BitTarget::Cell(self.bit())
                };
                let value = match self.tape.below(4) {
                    0 => Logic::Condition,
                    1 => Logic::Const(true),
                    2 => Logic::Const(false),
                    _ => self.logic(1),
                };
                Write::Bit(target, value)
            }
        }
    }

    fn region(&mut self) -> Region {
        match self.tape.below(8) {
            0..=3 => Region::Range { first: self.bit(), count: 1 + self.tape.below(2) as u32 },
            4 | 5 => Region::Range { first: self.word(), count: 1 + self.tape.below(2) as u32 },
            6 => Region::Area(self.tape.pick(&[AreaId(0), AreaId(1)])),
            _ => Region::Everything,
        }
    }

    fn bit(&mut self) -> Cell {
        bit(self.tape.below(BITS as usize) as u32)
    }

    fn word(&mut self) -> Cell {
        word(self.tape.below(WORDS as usize) as u32)
    }

    fn logic(&mut self, depth: usize) -> Logic {
        match self.tape.below(12) {
            5 => Logic::cell(self.bit()).not(),
            6 if self.taste.words => {
                Logic::Bit(BitSource::WordBit(self.word(), self.tape.pick(&[0, 1, 15])))
            }
            7 if self.taste.choices => Logic::Bit(BitSource::Free(self.fresh())),
            8 if depth > 0 => {
                let parts = (0..=self.tape.below(2)).map(|_| self.logic(depth - 1)).collect();
                if self.tape.percent(50) { Logic::Any(parts) } else { Logic::All(parts) }
            }
            9 if depth > 0 => self.logic(depth - 1).not(),
            10 if self.tape.percent(30) => self.tape.pick(&[
                Logic::Const(true),
                Logic::Const(false),
                Logic::Condition,
                Logic::All(vec![]),
                Logic::Any(vec![]),
            ]),
            10 | 11 if self.taste.words => self.compare(),
            _ => Logic::cell(self.bit()),
        }
    }

    fn compare(&mut self) -> Logic {
        let relation = self.tape.pick(&[
            Relation::Equal,
            Relation::GreaterOrEqual,
            Relation::NotEqual,
            Relation::Less,
            Relation::LessOrEqual,
            Relation::Greater,
        ]);
        if self.taste.reals && self.tape.percent(30) {
            let format = NumberFormat::Real(self.fresh());
            let (left, right) = (self.real(), self.real());
            return Logic::Compare(Box::new(Compare { relation, format, left, right }));
        }
        let format = self.tape.pick(&[NumberFormat::Signed, NumberFormat::Unsigned]);
        let words = 1 + usize::from(self.tape.percent(30));
        let left = self.number(words, 1);
        let right = self.number(words, 1);
        Logic::Compare(Box::new(Compare { relation, format, left, right }))
    }

    fn real(&mut self) -> Number {
        if self.tape.percent(50) {
            return self.number(2, 0);
        }
        let odd = f32::from_bits(1);
        let value = self.tape.pick(&[0.0, 1.5, -2.0, 1e9, -0.0, f32::NAN, f32::INFINITY, odd]);
        let bits: u32 = value.to_bits();
        Number::Words(vec![WordSource::Const(bits as u16), WordSource::Const((bits >> 16) as u16)])
    }

    fn number(&mut self, words: usize, depth: usize) -> Number {
        if self.taste.arithmetic && depth > 0 && self.tape.percent(30) {
            let join = self.tape.pick(&[
                Number::Add as fn(Box<Number>, Box<Number>) -> Number,
                Number::Sub,
                Number::And,
                Number::Or,
                Number::Xor,
            ]);
            let left = Box::new(self.number(words, depth - 1));
            return join(left, Box::new(self.number(words, depth - 1)));
        }
        if words == 2 && self.tape.percent(30) {
            let first = self.tape.below(2) as u32;
            return Number::Words(vec![
                WordSource::Cell(word(first)),
                WordSource::Cell(word(first + 1)),
            ]);
        }
        Number::Words((0..words).map(|_| self.word_source()).collect())
    }

    fn word_source(&mut self) -> WordSource {
        match self.tape.below(8) {
            0..=2 => WordSource::Cell(self.word()),
            3..=5 => WordSource::Const(self.tape.pick(&[0, 1, 2, 3, 0x7FFF, 0x8000, 0xFFFF])),
            6 => WordSource::Bits {
                first: bit(self.tape.below(3) as u32),
                count: self.tape.pick(&[4, 1, 2, 3]),
            },
            _ if self.taste.choices => WordSource::Free(self.fresh()),
            _ => WordSource::Cell(self.word()),
        }
    }

    fn word_target(&mut self) -> WordTarget {
        match self.tape.below(6) {
            4 => WordTarget::Bits {
                first: bit(self.tape.below(3) as u32),
                count: self.tape.pick(&[4, 1, 2, 3]),
            },
            5 => WordTarget::Discard,
            _ => WordTarget::Cell(self.word()),
        }
    }
}

fn aim(step: &mut Step, exit: Option<usize>, to: usize) {
    match (step, exit) {
        (Step::Jump { target, .. }, None) => *target = to,
        (Step::Summary(summary), Some(exit)) => summary.exits[exit].1 = Exit::To(to),
        _ => unreachable!("only jumps and loop summaries are aimed"),
    }
}

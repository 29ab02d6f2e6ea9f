//! Puts a program together: instructions with their effects, choices, saved branches, notes on what is widened.

use scanbound_base::code::Code;
use scanbound_base::location::Location;
use std::collections::BTreeSet;

use super::memory::Memory;
use super::named;
use super::operand::moved_register;
use super::resolve::Item;
use super::source::Edge;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::builder::{Builder, always};
use scanbound_front::shown;
use scanbound_ir::meaning::Meaning;
use scanbound_ir::{
    Approximated, BitSource, BitTarget, Cell, ChoiceId, Effect, Join, Logic, Program, Region, Step,
    TimingKey, Units, Write,
};

/// Slots from here on hold an instruction's branches; those below are TR0 to TR15.
pub(super) const BRANCHES: u32 = 16;

/// A program while it is put together.
pub(super) struct Assembly {
    pub(super) out: Builder,
    pub(super) memory: Memory,
    /// Faults that came up on the way.
    pub(super) faults: Vec<Diagnostic>,
    /// The file that is being put in.
    pub(super) file: u32,
    /// How many branches wait for a coil.
    pub(super) depth: usize,
    /// Whether the last instruction was a coil: the next LD begins a rung.
    pub(super) closed: bool,
    /// The TRs that hold a branch of this rung.
    pub(super) branches: BTreeSet<u32>,
    /// The flags of timers that the system counts on between instructions.
    pub(super) fast: BTreeSet<Cell>,
    /// Whether the instruction may run more than once a scan.
    pub(super) repeated: bool,
    /// Whether the instruction stands within an interlock: what it sees of edges there, families differ in.
    pub(super) interlocked: bool,
    /// How many instructions remember what they saw.
    edges: u32,
    /// What the instruction remembers when all else is done, until it is put in.
    remembered: Vec<Effect>,
    /// Loops whose count stands in a word: their begin, and the word where it is a known one.
    pub(super) counted: Vec<(usize, Option<Cell>)>,
    /// Index registers that the instruction's operands move, until it is put in.
    moved: Vec<Cell>,
}

impl Assembly {
    pub(super) fn new(memory: Memory, dialect: &str) -> Self {
        let program =
            Program { dialect: dialect.to_owned(), areas: memory.areas(), ..Program::default() };
        Assembly {
            out: Builder::new(program),
            memory,
            faults: Vec::new(),
            file: 0,
            depth: 0,
            closed: true,
            branches: BTreeSet::new(),
            fast: BTreeSet::new(),
            repeated: false,
            interlocked: false,
            edges: 0,
            remembered: Vec::new(),
            counted: Vec::new(),
            moved: Vec::new(),
        }
    }

    /// The instruction that comes next is this.
    pub(super) fn at(&mut self, item: &Item<'_>) {
        let place = Location { file: self.file, line: item.raw.line, step: item.raw.step };
        self.out.at(place, item.raw.text.clone(), named::operands(item));
        self.remembered.clear();
        let memory = self.memory;
        let operands = item.raw.operands.iter();
        self.moved = operands.filter_map(|text| moved_register(text, memory)).collect();
    }

    /// A fault of an instruction.
    pub(super) fn fault(
        &mut self,
        item: &Item<'_>,
        code: Code,
        message: impl Into<String>,
        help: &str,
    ) {
        let file = self.out.program.files.get(self.file as usize).map_or("", |file| &file.name);
        let fault =
            Diagnostic::line(code, file, item.raw.line, shown(&item.raw.text), message, help);
        self.faults.push(fault.at_step(item.raw.step));
    }

    /// A new choice.
    pub(super) fn choice(&mut self) -> ChoiceId {
        self.out.choice()
    }

    /// A choice that the outside makes: how far a timer has run, what an instruction saw in the last scan. Where it
    /// runs more than once a scan, what it saw is its own doing, which is not followed.
    pub(super) fn world(&mut self) -> ChoiceId {
        if self.repeated { self.out.choice() } else { self.out.external_choice() }
    }

    /// A truth value that the outside gives.
    pub(super) fn any(&mut self) -> Logic {
        Logic::Bit(BitSource::Free(self.world()))
    }

    /// A truth value that is not known.
    pub(super) fn free(&mut self) -> Logic {
        self.out.free_bit()
    }

    /// Begins a new rung.
    pub(super) fn rung(&mut self) {
        // What has no price of its own opens no rung.
        let mut priced =
            self.out.program.instructions.iter().rev().filter(|last| last.timing.is_some());
        let begun = priced.next().map_or(0, |last| last.block);
        self.out.program.blocks = begun + 1;
        self.depth = 0;
        self.closed = true;
        self.branches.clear();
    }

    /// The index that the next instruction gets.
    pub(super) fn next(&self) -> usize {
        self.out.next()
    }

    /// Adds an instruction; its index.
    pub(super) fn push(
        &mut self,
        step: Step,
        mut effects: Vec<Effect>,
        timing: Option<TimingKey>,
    ) -> usize {
        if timing.is_some() {
            effects.append(&mut self.remembered);
            for first in std::mem::take(&mut self.moved) {
                let choice = self.choice();
                effects.push(always(Write::Havoc(Region::Range { first, count: 2 }, choice)));
            }
        }
        self.out.add(timing, effects, step)
    }

    /// Notes that the last instruction is taken wider than the PLC does it.
    pub(super) fn note(&mut self, what: impl Into<Approximated>) {
        let instruction = self.next().saturating_sub(1);
        self.out.program.approximate(instruction, what);
    }

    /// Says what gives a choice its value.
    pub(super) fn exactly(&mut self, choice: ChoiceId, meaning: Meaning) {
        self.out.define(choice, meaning);
    }

    /// When an instruction runs whose condition stands on the stack, by its mark. It is put in as one.
    pub(super) fn fires(&mut self, edge: Option<Edge>) -> Logic {
        match edge {
            None => Logic::Condition,
            Some(edge) => self.edge(Logic::Condition, edge),
        }
    }

    /// The same of an instruction that is put in as several.
    pub(super) fn fires_at_will(&mut self, edge: Option<Edge>) -> Logic {
        match edge {
            None => Logic::Condition,
            Some(edge) => self.edge_at_will(Logic::Condition, edge),
        }
    }

    /// Whether a value has changed since the next instruction saw it last. Where it may run more than once a scan, or not be
    /// carried out in an interlock, that is not followed.
    pub(super) fn edge(&mut self, value: Logic, edge: Edge) -> Logic {
        if self.repeated || self.interlocked {
            return self.edge_at_will(value, edge);
        }
        let memory = self.memory.edge(self.edges);
        self.edges += 1;
        self.remembered.push(always(Write::Bit(BitTarget::Cell(memory), value.clone())));
        let was = Logic::cell(memory);
        Logic::All(match edge {
            Edge::Rising => vec![value, was.not()],
            Edge::Falling => vec![value.not(), was],
        })
    }

    fn edge_at_will(&mut self, value: Logic, edge: Edge) -> Logic {
        let changed = self.any();
        Logic::All(match edge {
            Edge::Rising => vec![value, changed],
            Edge::Falling => vec![value.not(), changed],
        })
    }

    /// A coil or application instruction.
    pub(super) fn act(
        &mut self,
        fires: Logic,
        effects: Vec<Effect>,
        timing: Option<TimingKey>,
    ) -> usize {
        self.push(Step::Act { fires }, effects, timing)
    }

    /// A part of an instruction that changes the result.
    fn result(&mut self, join: Join, value: Logic) {
        self.push(Step::Logic { join, value }, Vec::new(), None);
    }

    /// The result becomes its negation.
    pub(super) fn invert(&mut self) {
        self.result(Join::Replace, Logic::Condition.not());
    }

    /// The result becomes true.
    pub(super) fn always(&mut self) {
        self.result(Join::Replace, Logic::Const(true));
    }

    /// Saves the result for the time of this instruction.
    pub(super) fn keep(&mut self) {
        self.push(Step::Save(BRANCHES), Vec::new(), None);
    }

    /// Takes back what `keep` saved.
    pub(super) fn restore(&mut self) {
        self.push(Step::Fetch(BRANCHES), Vec::new(), None);
    }

    /// Fetches a saved branch register as a further branch, or as the first of a rung.
    pub(super) fn fetch(&mut self, register: u32, join: Join, timing: TimingKey) {
        self.result(join, Logic::Const(true));
        self.push(Step::Fetch(register), Vec::new(), Some(timing));
    }

    /// Takes the topmost branches apart, so that `product` can name them; one result stays on the stack.
    pub(super) fn split(&mut self, count: u32) {
        for branch in (1..count).rev() {
            self.push(Step::Save(BRANCHES + branch), Vec::new(), None);
            self.result(Join::Replace, Logic::Const(false));
            self.push(Step::OrBlock, Vec::new(), None);
        }
        self.keep();
        self.depth = self.depth + 1 - count as usize;
    }

    /// The result becomes true where each of the branches is (`true`) or is not (`false`).
    pub(super) fn product(&mut self, branches: &[(u32, bool)]) {
        for (at, &(branch, positive)) in branches.iter().enumerate() {
            if at > 0 {
                self.result(Join::Load, Logic::Const(true));
            }
            self.push(Step::Fetch(BRANCHES + branch), Vec::new(), None);
            if !positive {
                self.invert();
            }
            if at > 0 {
                self.push(Step::AndBlock, Vec::new(), None);
            }
        }
    }

    /// The key of an instruction's time; `dearer` where its condition is not what tables mean by on and off.
    pub(super) fn key(&self, item: &Item<'_>, dearer: bool) -> TimingKey {
        let class = item.row.map_or("special", |row| row.class);
        let mut names = vec![item.name.clone()];
        if let Some(row) = item.row.filter(|row| row.mnemonic != item.name) {
            names.push(row.mnemonic.to_string());
        }
        for (joined, apart) in [
            ("LDNOT", "LD NOT"),
            ("ANDNOT", "AND NOT"),
            ("ORNOT", "OR NOT"),
            ("OUTNOT", "OUT NOT"),
            ("ANDLD", "AND LD"),
            ("ORLD", "OR LD"),
        ] {
            if item.name == joined {
                names.push(apart.to_owned());
            }
        }
        let indirect = item.operands.iter().any(super::operand::Operand::is_indirect);
        let tags = [
            (item.raw.immediate, "immediate"),
            (item.raw.edge.is_some(), "edge"),
            (indirect, "indirect"),
        ];
        let tags = tags.iter().filter(|(has, _)| *has).map(|(_, tag)| *tag);
        let tagged: Vec<String> =
            tags.flat_map(|tag| names.iter().map(move |name| format!("{name}:{tag}"))).collect();
        names.splice(0..0, tagged);
        TimingKey {
            names,
            class,
            units: Units::None,
            use_larger_time: dearer,
            optional: false,
            accessed: named::touched(item, self.memory),
        }
    }
}

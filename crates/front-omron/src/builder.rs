//! Adds instructions to the program: effects, choices, saved branches, and the list of over-approximations.

use scanbound_base::code::Code;
use scanbound_base::location::Location;
use std::collections::{BTreeMap, BTreeSet};

use super::accessed;
use super::memory::Memory;
use super::operand::moved_register;
use super::resolve::Item;
use super::source::Edge;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::builder::{Builder, always, fired};
use scanbound_front::shown;
use scanbound_ir::meaning::Meaning;
use scanbound_ir::{
    Approximated, BitSource, BitTarget, Cell, ChoiceId, Effect, Join, Logic, Program, Region, Step,
    TimingKey, Units, Write,
};

/// The first slot for branches that an instruction saves. Lower slots are those of TR0 to TR15.
pub(super) const BRANCHES: u32 = 16;

/// A program under construction.
pub(super) struct OmronBuilder {
    pub(super) out: Builder,
    pub(super) memory: Memory,
    /// The errors so far.
    pub(super) faults: Vec<Diagnostic>,
    /// The index of the file that is being lowered.
    pub(super) file: u32,
    /// The number of results on the stack: branches of the rung that are not yet combined.
    pub(super) depth: usize,
    /// Whether the next LD begins a rung: at the beginning, and after a coil.
    pub(super) closed: bool,
    /// The temporary relays (TR) that hold a branch of the current rung.
    pub(super) branches: BTreeSet<u32>,
    /// The completion flags of timers that may time out between instructions.
    pub(super) fast: BTreeSet<Cell>,
    /// Whether the current instruction may run several times in a scan.
    pub(super) repeated: bool,
    /// Whether the current instruction is in an interlock, where the CPU families treat edges differently.
    pub(super) interlocked: bool,
    /// The number of hidden bits so far.
    edges: u32,
    /// For each counter (its completion flag): for each instruction that counts it, the hidden bits in which the
    /// instruction remembers its inputs.
    pub(super) counters: BTreeMap<Cell, Vec<Vec<Cell>>>,
    /// The indices of the instructions that reset counters, each with the completion flags of these counters.
    pub(super) counter_resets: Vec<(usize, Vec<Cell>)>,
    /// The effects that store the current instruction's inputs in hidden bits; they are added after its other effects.
    remembered: Vec<Effect>,
    /// Loops whose number of iterations is in a word: the index of the FOR, and the word if it is known.
    pub(super) counted: Vec<(usize, Option<Cell>)>,
    /// The index registers that operands of the current instruction increment or decrement. Their changes are added as
    /// the last effects of the instruction.
    moved: Vec<Cell>,
}

impl OmronBuilder {
    pub(super) fn new(memory: Memory, dialect: &str) -> Self {
        let program =
            Program { dialect: dialect.to_owned(), areas: memory.areas(), ..Program::default() };
        OmronBuilder {
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
            counters: BTreeMap::new(),
            counter_resets: Vec::new(),
            remembered: Vec::new(),
            counted: Vec::new(),
            moved: Vec::new(),
        }
    }

    /// Sets the source position, text and operands of the instructions that are added next, and forgets what the last
    /// instruction still had to store.
    pub(super) fn at(&mut self, item: &Item<'_>) {
        let place = Location { file: self.file, line: item.raw.line, step: item.raw.step };
        self.out.at(place, item.raw.text.clone(), accessed::operands(item));
        self.remembered.clear();
        let memory = self.memory;
        let operands = item.raw.operands.iter();
        self.moved = operands.filter_map(|text| moved_register(text, memory)).collect();
    }

    /// Reports an error at an instruction.
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

    /// A new choice (nondeterministic value).
    pub(super) fn choice(&mut self) -> ChoiceId {
        self.out.choice()
    }

    /// A choice that earlier scans determine: elapsed time, or a value from the last scan. In the analysis of a single
    /// scan it may have any value; in a run from power-up its value is not known. If the instruction may run several
    /// times in a scan, it is an ordinary choice, because the instruction's earlier execution in the same scan is not
    /// modelled.
    pub(super) fn earlier_choice(&mut self) -> ChoiceId {
        if self.repeated {
            return self.out.choice();
        }
        let choice = self.out.external_choice();
        self.out.program.timekeeping.untracked.insert(choice);
        choice
    }

    /// A new bit with any value, for a point that the manuals leave open: it says which of two readings is right.
    pub(super) fn reading(&mut self) -> Logic {
        let choice = self.choice();
        self.out.program.timekeeping.readings.insert(choice);
        Logic::Bit(BitSource::Free(choice))
    }

    /// The expression that says whether an input of the instruction changed since its last execution. In an interlock
    /// it is a reading: CPUs differ in what they remember of an input while the interlock is active.
    pub(super) fn changed(&mut self) -> Logic {
        let choice = self.earlier_choice();
        if self.interlocked {
            self.out.program.timekeeping.readings.insert(choice);
        }
        Logic::Bit(BitSource::Free(choice))
    }

    /// A new cell in which the instruction remembers one of its inputs. `None` if it may run several times in a scan or
    /// be skipped in an interlock.
    pub(super) fn edge_memory(&mut self) -> Option<Cell> {
        let is_modelled = !self.repeated && !self.interlocked;
        is_modelled.then(|| {
            self.edges += 1;
            self.memory.edge(self.edges - 1)
        })
    }

    /// Lets each instruction that resets counters also clear, or not, the hidden bits in which these counters remember
    /// their inputs: no manual says whether a counter whose input stays on counts again after a reset.
    pub(super) fn reset_counters(&mut self) {
        for (at, flags) in std::mem::take(&mut self.counter_resets) {
            let counters = flags.iter().filter_map(|flag| self.counters.get(flag));
            let memories: Vec<Cell> = counters.flatten().flatten().copied().collect();
            for memory in memories {
                let seen = Logic::All(vec![Logic::cell(memory), self.reading()]);
                let effect = fired(Write::Bit(BitTarget::Cell(memory), seen));
                self.out.program.instructions[at].effects.push(effect);
            }
        }
    }

    /// If several instructions count the same counter, lets the hidden bits in which they remember its inputs have any
    /// value: no manual says whether each of the instructions remembers its own input.
    pub(super) fn widen_shared_counters(&mut self) {
        let counters = std::mem::take(&mut self.counters).into_values();
        let shared = counters.filter(|instructions| instructions.len() > 1);
        let shared: BTreeSet<Cell> = shared.flatten().flatten().collect();
        if shared.is_empty() {
            return;
        }
        for at in 0..self.out.program.instructions.len() {
            let mut effects = std::mem::take(&mut self.out.program.instructions[at].effects);
            for effect in &mut effects {
                if let Write::Bit(BitTarget::Cell(cell), value) = &mut effect.write
                    && shared.contains(cell)
                {
                    *value = self.out.free_bit();
                    self.out.program.approximate(
                        at,
                        "several instructions count with this counter: it is unknown whether each of them detects the edges of its own input",
                    );
                }
            }
            self.out.program.instructions[at].effects = effects;
        }
    }

    /// An expression for a bit that something outside the program determines, from a new choice. If the instruction may
    /// run several times in a scan, nothing is known of the choice.
    pub(super) fn external_bit(&mut self) -> Logic {
        let choice = if self.repeated { self.out.choice() } else { self.out.external_choice() };
        Logic::Bit(BitSource::Free(choice))
    }

    /// An expression for a bit that may have any value, from a new choice.
    pub(super) fn free_bit(&mut self) -> Logic {
        self.out.free_bit()
    }

    /// Begins a new rung, with no branches. The rung keeps its number if it has no instruction with a time yet.
    pub(super) fn rung(&mut self) {
        // Instructions without a time do not begin a rung of their own.
        let mut priced =
            self.out.program.instructions.iter().rev().filter(|last| last.timing.is_some());
        let begun = priced.next().map_or(0, |last| last.block);
        self.out.program.blocks = begun + 1;
        self.depth = 0;
        self.closed = true;
        self.branches.clear();
    }

    /// The index of the next instruction to be added.
    pub(super) fn next(&self) -> usize {
        self.out.next()
    }

    /// Adds an instruction and returns its index. One with a time also stores the inputs that it must remember, and
    /// lets the index registers that its operands increment or decrement have any value.
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

    /// Lists an over-approximation at the last instruction.
    pub(super) fn approximate(&mut self, what: impl Into<Approximated>) {
        let instruction = self.next().saturating_sub(1);
        self.out.program.approximate(instruction, what);
    }

    /// Records the operation that computes the value of a choice. As [`Builder::define`], it does nothing if the
    /// program would list too many cells.
    pub(super) fn define(&mut self, choice: ChoiceId, meaning: Meaning) {
        self.out.define(choice, meaning);
    }

    /// The condition under which an instruction with this edge prefix fires. For OMRON instructions that are lowered to
    /// a single instruction of the program.
    pub(super) fn fires(&mut self, edge: Option<Edge>) -> Logic {
        match edge {
            None => Logic::Condition,
            Some(edge) => self.edge(Logic::Condition, edge),
        }
    }

    /// As `fires`, for an OMRON instruction that is lowered to several instructions: its edge is not modelled, but may
    /// occur whenever the condition has the value after the edge.
    pub(super) fn fires_or_not(&mut self, edge: Option<Edge>) -> Logic {
        match edge {
            None => Logic::Condition,
            Some(edge) => self.unknown_edge(Logic::Condition, edge),
        }
    }

    /// The expression that says whether `value` has this edge since the next instruction last executed. If this
    /// instruction may run several times in a scan or be skipped in an interlock, an edge is possible whenever the
    /// value is the new one.
    pub(super) fn edge(&mut self, value: Logic, edge: Edge) -> Logic {
        let Some(memory) = self.edge_memory() else { return self.unknown_edge(value, edge) };
        self.remembered.push(always(Write::Bit(BitTarget::Cell(memory), value.clone())));
        let was = Logic::cell(memory);
        Logic::All(match edge {
            Edge::Rising => vec![value, was.not()],
            Edge::Falling => vec![value.not(), was],
        })
    }

    fn unknown_edge(&mut self, value: Logic, edge: Edge) -> Logic {
        let changed = self.changed();
        Logic::All(match edge {
            Edge::Rising => vec![value, changed],
            Edge::Falling => vec![value.not(), changed],
        })
    }

    /// Adds an instruction that acts where `fires` is true (a coil or an application instruction), and returns its
    /// index.
    pub(super) fn act(
        &mut self,
        fires: Logic,
        effects: Vec<Effect>,
        timing: Option<TimingKey>,
    ) -> usize {
        self.push(Step::Act { fires }, effects, timing)
    }

    /// Adds a part of an instruction that only changes the result of the rung.
    fn result(&mut self, join: Join, value: Logic) {
        self.push(Step::Logic { join, value }, Vec::new(), None);
    }

    /// Negates the result of the rung.
    pub(super) fn invert(&mut self) {
        self.result(Join::Replace, Logic::Condition.not());
    }

    /// Makes the result of the rung true.
    pub(super) fn always(&mut self) {
        self.result(Join::Replace, Logic::Const(true));
    }

    /// Saves the result of the rung, until `restore` after further parts of this instruction.
    pub(super) fn keep(&mut self) {
        self.push(Step::Save(BRANCHES), Vec::new(), None);
    }

    /// Restores the result of the rung that `keep` saved.
    pub(super) fn restore(&mut self) {
        self.push(Step::Fetch(BRANCHES), Vec::new(), None);
    }

    /// Reads a temporary relay as a further branch, or as the first one of a rung.
    pub(super) fn fetch(&mut self, register: u32, join: Join, timing: TimingKey) {
        self.result(join, Logic::Const(true));
        self.push(Step::Fetch(register), Vec::new(), Some(timing));
    }

    /// Saves each of the topmost `count` branches for [`OmronBuilder::product`], the lowest as number 0. Of these
    /// branches one result stays on the stack.
    pub(super) fn split(&mut self, count: u32) {
        for branch in (1..count).rev() {
            self.push(Step::Save(BRANCHES + branch), Vec::new(), None);
            self.result(Join::Replace, Logic::Const(false));
            self.push(Step::OrBlock, Vec::new(), None);
        }
        self.keep();
        self.depth = self.depth + 1 - count as usize;
    }

    /// Makes the result of the rung the conjunction of branches that `split` has saved. Each is given by its number;
    /// one with `false` is negated.
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

    /// The key with which the instruction's time is found in a timing table. With `use_larger_time`, the larger of the
    /// two times counts, because in a timing table the two times depend on another condition than in the lowered
    /// program.
    pub(super) fn key(&self, item: &Item<'_>, use_larger_time: bool) -> TimingKey {
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
            use_larger_time,
            optional: false,
            accessed: accessed::touched(item, self.memory),
        }
    }
}

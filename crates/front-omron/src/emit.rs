//! Emits a program's items: contacts, coils, interlocks, jumps, loops and calls; the rest is in `timers` and `data`.

use super::assembly::Assembly;
use super::catalog::Lead;
use super::frame::Frame;
use super::memory::Memory;
use super::operand::Operand;
use super::resolve::{Item, branch};
use super::source::{Edge, Family};
use super::timers;
use super::{act, data};
use scanbound_base::code::Code;
use scanbound_front::builder::{always, fired};
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{
    BitSource, BitTarget, Effect, Join, Logic, Region, Step, Units, WordSource, Write,
};

/// A call that waits for its subroutine's place.
#[derive(Debug, Clone, Copy)]
pub(super) struct CallSite {
    /// The instruction.
    pub(super) at: usize,
    /// The item in its program.
    pub(super) item: usize,
    /// The subroutine's number.
    pub(super) number: u32,
    /// Whether it is one that the whole project may call.
    pub(super) global: bool,
}

impl CallSite {
    /// The routine's name in the facts.
    pub(super) fn routine(&self) -> String {
        format!("{}SBN{}", if self.global { "G" } else { "" }, self.number)
    }
}

/// Emits one program.
pub(super) struct Emitter<'a> {
    pub(super) asm: &'a mut Assembly,
    pub(super) items: &'a [Item<'a>],
    pub(super) frame: &'a Frame,
    /// The first instruction of each item.
    pub(super) starts: Vec<Option<usize>>,
    /// Jumps and loops, and the items they go to.
    patches: Vec<(usize, usize)>,
    pub(super) calls: Vec<CallSite>,
    /// Levels of the open interlocks.
    interlocks: Vec<u32>,
    /// Whether tasks are switched on and off.
    pub(super) switches: bool,
}

impl<'a> Emitter<'a> {
    pub(super) fn new(asm: &'a mut Assembly, items: &'a [Item<'a>], frame: &'a Frame) -> Self {
        let starts = vec![None; items.len()];
        Emitter {
            asm,
            items,
            frame,
            starts,
            patches: Vec::new(),
            calls: Vec::new(),
            interlocks: Vec::new(),
            switches: false,
        }
    }

    /// Emits all items, then fills in where jumps go; the END's instruction.
    pub(super) fn run(&mut self) -> usize {
        let first = self.frame.routines.first().map(|routine| routine.begin);
        let before_end = first.filter(|&first| self.frame.end.is_none_or(|end| first < end));
        let mut over = None;
        for at in 0..self.items.len() {
            self.asm.at(&self.items[at]);
            if Some(at) == before_end {
                // Here the program is over; what follows only runs when it is called.
                self.asm.rung();
                over = Some(self.asm.push(
                    Step::Jump { fires: Logic::Const(true), target: 0 },
                    Vec::new(),
                    None,
                ));
            }
            self.asm.repeated = self.frame.repeated[at];
            self.asm.interlocked = !self.interlocks.is_empty();
            if !self.frame.dead[at] {
                self.item(at);
            }
        }
        let end = self.frame.end.and_then(|end| self.starts[end]);
        let end = end.unwrap_or_else(|| {
            self.asm.rung();
            self.asm.push(Step::End, Vec::new(), None)
        });
        if let Some(over) = over {
            self.retarget(over, end);
        }
        for (at, item) in std::mem::take(&mut self.patches) {
            // What lands where the subroutines begin has come to the program's end.
            let started =
                self.starts.get(item).copied().flatten().filter(|_| Some(item) != before_end);
            self.retarget(at, started.unwrap_or(end));
        }
        end
    }

    fn retarget(&mut self, at: usize, to: usize) {
        match &mut self.asm.out.program.instructions[at].step {
            Step::Jump { target, .. } => *target = to,
            Step::ForBegin { end, .. } => *end = to,
            _ => {}
        }
    }

    fn item(&mut self, at: usize) {
        let item = &self.items[at];
        self.starts[at] = Some(self.asm.next());
        if let Some(register) = branch(item.raw) {
            self.register(item, register);
            return;
        }
        match item.meaning() {
            "load" | "load-not" | "and" | "and-not" | "or" | "or-not" => self.contact(item),
            "compare" | "compare-signed" | "compare-real" | "compare-unknown" | "test" | "test-not" => {
                let value = data::condition(self.asm, item);
                let flags = data::flags(self.asm, item).into_iter().map(always).collect();
                self.joined(item, item.lead.unwrap_or(Lead::Load), value, flags);
                data::note_unknown(self.asm, item);
            }
            "and-block" => self.block(item, Step::AndBlock),
            "or-block" => self.block(item, Step::OrBlock),
            "invert" | "rise" | "fall" => self.change(item),
            "nothing" => {
                let key = self.asm.key(item, true);
                self.asm.push(Step::Nothing, Vec::new(), Some(key));
            }
            "end" | "interlock-end" | "interlock-number-end" | "jump-end" | "jump-zero-end" | "routine" | "return"
            | "for" | "next" => self.unconditional(at, item),
            "step" => self.asm.fault(
                item,
                Code::NotModelled,
                "step programs (STEP, SNXT) are not modelled",
                "a bound that leaves them out would be too low; write the steps with KEEP or SET and RSET",
            ),
            "timer-holding" | "counter" | "shift-register" | "keep" if self.needs(item, 2 + u32::from(item.meaning() == "shift-register")) => {
                timers::branched(self.asm, item);
                self.asm.depth = 0;
            }
            "counter-reversible" if self.needs(item, 3) => {
                timers::branched(self.asm, item);
                self.asm.depth = 0;
            }
            "timer-holding" | "counter" | "shift-register" | "keep" | "counter-reversible" => self.asm.depth = 0,
            _ if self.needs(item, 1) => self.coil(at, item),
            _ => self.asm.depth = 0,
        }
    }

    /// Whether as many branches are open as the instruction takes.
    fn needs(&mut self, item: &Item<'_>, branches: u32) -> bool {
        let open = self.asm.depth;
        self.asm.closed = true;
        if open == branches as usize {
            return true;
        }
        let (message, help) = if open == 0 {
            (
                "no condition stands before this instruction".to_owned(),
                "a rung begins with LD; LD P_On or LD 25313 for always",
            )
        } else {
            (
                format!("{} takes {branches} of the branches in front, here are {open}", item.name),
                "join branches with AND LD and OR LD; KEEP, CNT and TTIM take two, CNTR and SFT three",
            )
        };
        self.asm.fault(item, Code::Branches, message, help);
        false
    }

    /// `OUT TR0` and `LD TR0`.
    fn register(&mut self, item: &Item<'_>, register: u32) {
        let key = self.asm.key(item, true);
        if item.name == "OUT" {
            if self.asm.depth == 0 {
                self.needs(item, 1);
            }
            self.asm.push(Step::Save(register), Vec::new(), Some(key));
            self.asm.branches.insert(register);
            return;
        }
        if !self.asm.branches.contains(&register) {
            let message = format!("TR{register} holds no branch of this rung");
            self.asm.fault(
                item,
                Code::Branches,
                message,
                "OUT TR comes before LD TR, in the same rung",
            );
        }
        let join = self.loading();
        self.asm.fetch(register, join, key);
    }

    /// How a further branch begins: the first of a rung's part, or one more.
    fn loading(&mut self) -> Join {
        let start = self.asm.closed || self.asm.depth == 0;
        self.asm.depth = if start { 1 } else { self.asm.depth + 1 };
        self.asm.closed = false;
        if start { Join::Start } else { Join::Load }
    }

    fn contact(&mut self, item: &Item<'_>) {
        let memory = self.asm.memory;
        let source = item
            .operands
            .first()
            .and_then(|operand| operand.bit_source(memory, &mut || self.asm.choice()));
        let source = source.unwrap_or(BitSource::Const(false));
        let negated = item.meaning().ends_with("-not");
        let mut effects = Vec::new();
        let mut value = Logic::Bit(source);
        let fast = match source {
            BitSource::Cell(flag) if self.asm.fast.contains(&flag) => Some(flag),
            _ => None,
        };
        if let Some(flag) = fast {
            // It may have run out since it was last run.
            let runs = Logic::cell(memory.runs(flag));
            let between = self.asm.choice();
            self.asm.out.program.timekeeping.between_instructions.insert(between, None);
            let over = Logic::Bit(BitSource::Free(between));
            value = Logic::Any(vec![value, Logic::All(vec![runs, over])]);
        }
        if item.raw.immediate {
            // The input is read anew, with its word.
            let fresh = self.asm.any();
            if let Some(operand @ Operand::Bit(cell, _)) = item.operands.first()
                && Memory::is_refreshed(*cell)
                && let Some(target) = operand.bit_target()
            {
                let region = Region::Range { first: *cell, count: 1 };
                effects.push(always(Write::Havoc(region, self.asm.choice())));
                effects.push(always(Write::Bit(target, fresh.clone())));
            }
            value = fresh;
        }
        value = match (item.raw.edge, negated) {
            (None, false) => value,
            (None, true) => value.not(),
            (Some(edge), false) => self.asm.edge(value, edge),
            (Some(_), true) => self.asm.free(),
        };
        let lead = match item.meaning() {
            "load" | "load-not" => Lead::Load,
            "and" | "and-not" => Lead::And,
            _ => Lead::Or,
        };
        self.joined(item, lead, value, effects);
        if item.raw.edge.is_some() && negated {
            self.asm.note("the edge of a negated contact is taken to be on or off at will");
        }
        if fast.is_some() {
            self.asm.note(
                "this timer may run out between any two instructions while its condition holds",
            );
        }
        if item.operands.first().is_some_and(Operand::is_indirect) {
            self.asm.note(format!(
                "{} is read through an address that is not known: any value is taken",
                item.raw.operands[0]
            ));
        }
    }

    fn joined(&mut self, item: &Item<'_>, lead: Lead, value: Logic, effects: Vec<Effect>) {
        let key = self.asm.key(item, true);
        let join = match lead {
            Lead::Load => {
                if self.asm.closed || self.asm.depth == 0 {
                    self.asm.rung();
                }
                self.loading()
            }
            Lead::And | Lead::Or => {
                if self.asm.depth == 0 {
                    self.needs(item, 1);
                    self.asm.depth = 1;
                }
                self.asm.closed = false;
                if lead == Lead::And { Join::And } else { Join::Or }
            }
        };
        self.asm.push(Step::Logic { join, value }, effects, Some(key));
    }

    fn block(&mut self, item: &Item<'_>, step: Step) {
        if self.asm.depth < 2 {
            let message =
                format!("{} joins two branches, here is {}", item.raw.text, self.asm.depth);
            self.asm.fault(item, Code::Branches, message, "each branch begins with LD");
            return;
        }
        self.asm.depth -= 1;
        let key = self.asm.key(item, true);
        self.asm.push(step, Vec::new(), Some(key));
    }

    /// NOT, UP, DOWN: changes of the result.
    fn change(&mut self, item: &Item<'_>) {
        if self.asm.depth == 0 && !self.needs(item, 1) {
            return;
        }
        self.asm.closed = false;
        let value = match item.meaning() {
            "invert" => Logic::Condition.not(),
            "rise" => self.asm.edge(Logic::Condition, Edge::Rising),
            _ => self.asm.edge(Logic::Condition, Edge::Falling),
        };
        let key = self.asm.key(item, true);
        self.asm.push(Step::Logic { join: Join::Replace, value }, Vec::new(), Some(key));
    }

    fn unconditional(&mut self, at: usize, item: &Item<'_>) {
        if self.asm.depth > 0 && !self.asm.closed {
            let message = "the branch in front of this instruction ends nowhere";
            self.asm.fault(
                item,
                Code::Branches,
                message,
                "end it with a coil or an instruction; this one has no condition",
            );
        }
        self.asm.rung();
        let key = self.asm.key(item, true);
        let step = match item.meaning() {
            "end" => Step::End,
            "return" => Step::Return,
            "interlock-end" => {
                self.interlocks.clear();
                Step::MasterControlEnd { level: 0 }
            }
            "interlock-number-end" => {
                Step::MasterControlEnd { level: self.interlocks.pop().unwrap_or(0) }
            }
            "for" => self.iterations(item),
            "next" => Step::ForEnd,
            "routine" => {
                self.interlocks.clear();
                Step::Nothing
            }
            _ => Step::Nothing,
        };
        let flags = match item.meaning() {
            "for" | "next" => data::flags(self.asm, item).into_iter().map(always).collect(),
            _ => Vec::new(),
        };
        let index = self.asm.push(step, flags, Some(key));
        if let Some(&target) = self.frame.targets.get(&at) {
            self.patches.push((index, target));
        }
    }

    fn iterations(&mut self, item: &Item<'_>) -> Step {
        let most = u32::from(u16::MAX);
        let Some(operand) = item.operands.first() else { return Step::Nothing };
        let Some(iterations) = operand.count(self.asm.memory.family) else {
            if matches!(operand, Operand::Constant(..) | Operand::Real(_) | Operand::Text) {
                let help = "a loop runs 0 to 65535 times: write the count so, such as FOR(512) &10";
                self.asm.fault(item, Code::LoopCount, "this is no count of iterations", help);
                return Step::Nothing;
            }
            // How many iterations the word can say is asked when all that writes it is known.
            let choice = self.asm.choice();
            // The C series counts in decimal digits, and of a word at an address it is not known which it is.
            let word = operand.word().filter(|_| self.asm.memory.family != Family::C);
            if let Some(cell) = word.filter(|&cell| !self.asm.memory.is_volatile(cell)) {
                let kind = ChoiceKind::UnsignedIterations(WordSource::Cell(cell));
                self.asm.out.program.kinds.insert(choice, kind);
            }
            self.asm.counted.push((self.asm.next(), operand.word()));
            return Step::ForBegin { count: WordSource::Free(choice), least: 0, most, end: 0 };
        };
        if iterations > most {
            let help = "a loop runs 0 to 65535 times";
            self.asm.fault(item, Code::LoopCount, "the count is too large", help);
            return Step::Nothing;
        }
        // The count is read as a signed number: it is stated by `least` and `most` alone.
        Step::ForBegin { count: WordSource::Const(0), least: iterations, most: iterations, end: 0 }
    }

    /// An instruction with one condition in front.
    fn coil(&mut self, at: usize, item: &Item<'_>) {
        let interlocked = self.frame.interlocked[at];
        match item.meaning() {
            "out" | "out-not" | "set" | "reset" | "pulse-rise" | "pulse-fall" => {
                self.bit_coil(item, interlocked)
            }
            "interlock" | "interlock-number" => self.interlock(item, interlocked),
            "jump" | "jump-if" | "jump-zero" => self.jump(at, item, interlocked),
            "break" => {
                let fires = self.asm.fires(item.raw.edge);
                let mut key = self.asm.key(item, true);
                let flags = data::flags(self.asm, item).into_iter().map(always).collect();
                if let Some(&next) = self.frame.targets.get(&at) {
                    key.units = Units::Exactly((next - at) as u64);
                    // Behind NEXT: that ends the loop.
                    let index = self.asm.push(Step::Jump { fires, target: 0 }, flags, Some(key));
                    self.patches.push((index, next + 1));
                }
            }
            "call" => {
                let fires = self.asm.fires_at_will(item.raw.edge);
                let key = self.asm.key(item, false);
                self.call(at, item, fires, Vec::new(), key);
            }
            "macro" => self.r#macro(at, item),
            "task" => {
                self.switches = true;
                let key = self.asm.key(item, true);
                let fires = self.asm.fires(item.raw.edge);
                self.asm.act(fires, Vec::new(), Some(key));
                if item.number(self.asm.memory.family).is_none_or(|task| task >= 8000) {
                    self.asm.fault(
                        item,
                        Code::NotModelled,
                        "an interrupt task is switched on as a further cyclic task",
                        "make it a cyclic task in the project",
                    );
                }
            }
            "timer" | "timer-unknown" | "havoc-always" | "reset-timers" => {
                timers::timer(self.asm, item)
            }
            _ => act::act(self.asm, item),
        }
    }

    fn bit_coil(&mut self, item: &Item<'_>, interlocked: bool) {
        let key = self.asm.key(item, false);
        let Some(target) = item.operands.first().and_then(Operand::bit_target) else {
            // Through an index register: any bit anywhere may change.
            let choice = self.asm.choice();
            let regions =
                item.operands.first().map(|operand| operand.regions(Some(1))).unwrap_or_default();
            let effects =
                regions.into_iter().map(|region| always(Write::Havoc(region, choice))).collect();
            let fires = self.asm.fires(item.raw.edge);
            self.asm.act(fires, effects, Some(key));
            self.asm.note(format!(
                "{} is written through an address that is not known: all it may be takes any value",
                item.raw.operands[0]
            ));
            return;
        };
        let bit = |value: Logic| Write::Bit(target, value);
        match item.meaning() {
            "out" => {
                self.asm.act(Logic::Condition, vec![always(bit(Logic::Condition))], Some(key));
            }
            "out-not" if interlocked => {
                // Off while the interlock holds, whatever the negation says.
                self.asm.keep();
                self.asm.invert();
                self.asm.act(Logic::Condition, vec![always(bit(Logic::Condition))], Some(key));
                self.asm.restore();
            }
            "out-not" => {
                self.asm.act(
                    Logic::Condition.not(),
                    vec![always(bit(Logic::Condition.not()))],
                    Some(key),
                );
            }
            "set" | "reset" => {
                let fires = self.asm.fires(item.raw.edge);
                let value = Logic::Const(item.meaning() == "set");
                self.asm.act(fires, vec![fired(bit(value))], Some(key));
            }
            meaning if interlocked => self.interlocked_pulse(meaning, target, key),
            meaning => {
                let is_rising = meaning == "pulse-rise";
                let edge = if is_rising { Edge::Rising } else { Edge::Falling };
                let value = self.asm.edge(Logic::Condition, edge);
                self.asm.act(value.clone(), vec![always(bit(value))], Some(key));
            }
        }
    }

    /// DIFU and DIFD within an interlock: they do not run while it holds, so their bit stays.
    fn interlocked_pulse(
        &mut self,
        meaning: &str,
        target: BitTarget,
        key: scanbound_ir::TimingKey,
    ) {
        self.asm.keep();
        self.asm.always();
        self.asm.act(Logic::Condition, vec![fired(Write::Bit(target, Logic::Const(false)))], None);
        self.asm.restore();
        if meaning == "pulse-fall" {
            self.asm.invert();
        }
        let fires = Logic::All(vec![Logic::Condition, self.asm.any()]);
        self.asm.act(fires, vec![fired(Write::Bit(target, Logic::Const(true)))], Some(key));
        if meaning == "pulse-fall" {
            self.asm.restore();
        }
    }

    fn interlock(&mut self, item: &Item<'_>, interlocked: bool) {
        let key = self.asm.key(item, true);
        let numbered = item.meaning() == "interlock-number";
        let level = if numbered { self.interlocks.len() as u32 + 1 } else { 0 };
        let mut effects = Vec::new();
        if let Some(target) = item.operands.get(1).and_then(Operand::bit_target) {
            let value = if interlocked { self.asm.free() } else { Logic::Condition };
            effects.push(always(Write::Bit(target, value)));
        } else if let (true, Some(operand)) = (numbered, item.operands.get(1)) {
            let choice = self.asm.choice();
            effects.extend(
                operand
                    .regions(Some(1))
                    .into_iter()
                    .map(|region| always(Write::Havoc(region, choice))),
            );
        }
        self.interlocks.push(level);
        self.asm.push(
            Step::MasterControlBegin { level, fires: Logic::Condition },
            effects,
            Some(key),
        );
    }

    fn jump(&mut self, at: usize, item: &Item<'_>, interlocked: bool) {
        let jumps =
            if item.meaning() == "jump-if" { Logic::Condition } else { Logic::Condition.not() };
        let fires = match (item.meaning(), interlocked) {
            (_, false) => jumps,
            ("jump-if", true) => Logic::Any(vec![jumps, self.asm.free()]),
            (_, true) => Logic::All(vec![jumps, self.asm.free()]),
        };
        let mut key = self.asm.key(item, true);
        let Some(&target) = self.frame.targets.get(&at) else { return };
        let zero = self.asm.memory.family == Family::C && item.number(Family::C) == Some(0);
        if zero || item.meaning() == "jump-zero" {
            // These pass over what they skip, instruction by instruction.
            key.names.insert(0, format!("{}:0", item.name));
            key.units = Units::Exactly((target - at - 1) as u64);
        }
        let index = self.asm.push(Step::Jump { fires, target: 0 }, Vec::new(), Some(key));
        self.patches.push((index, target));
        if interlocked {
            self.asm.note(
                "a jump within an interlock may or may not be made while the interlock holds",
            );
        }
    }

    fn call(
        &mut self,
        at: usize,
        item: &Item<'_>,
        fires: Logic,
        effects: Vec<Effect>,
        key: scanbound_ir::TimingKey,
    ) {
        let Some(number) = item.number(self.asm.memory.family) else {
            self.asm.fault(
                item,
                Code::Operand,
                "a subroutine's number is a constant",
                "write it as a number, such as SBS(091) 1",
            );
            return;
        };
        let index = self.asm.push(Step::Call { fires, target: 0 }, effects, Some(key));
        self.calls.push(CallSite {
            at: index,
            item: at,
            number,
            global: item.name.starts_with('G'),
        });
    }

    /// MCRO: parameters in, the subroutine, results out.
    fn r#macro(&mut self, at: usize, item: &Item<'_>) {
        let memory = self.asm.memory;
        let fires = self.asm.fires_at_will(item.raw.edge);
        let key = self.asm.key(item, false);
        let mut effects: Vec<Effect> = data::flags(self.asm, item).into_iter().map(fired).collect();
        // The words for parameters and results differ by CPU: all that it may be take any value.
        let choice = self.asm.choice();
        for (first, count) in memory.parameters() {
            effects.push(fired(Write::Havoc(Region::Range { first, count }, choice)));
        }
        self.call(at, item, fires.clone(), effects, key);
        let choice = self.asm.choice();
        let results =
            item.operands.get(2).map(|operand| operand.regions(Some(4))).unwrap_or_default();
        let effects =
            results.into_iter().map(|region| fired(Write::Havoc(region, choice))).collect();
        self.asm.act(fires, effects, None);
        self.asm.note("the parameters and results of the macro take any value");
    }
}

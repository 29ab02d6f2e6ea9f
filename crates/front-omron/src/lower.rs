//! Lowers contacts, coils, interlocks, jumps, loops and calls; `timers` and `application` lower the rest.

use super::builder::OmronBuilder;
use super::catalog::Connection;
use super::memory::Memory;
use super::operand::Operand;
use super::resolve::{Item, branch};
use super::source::{Edge, Family};
use super::structure::Structure;
use super::timers;
use super::{application, data};
use scanbound_base::code::Code;
use scanbound_front::builder::{always, fired};
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{
    BitSource, BitTarget, Effect, Join, Logic, Region, Step, Units, WordSource, Write,
};

/// A call whose subroutine is not resolved yet.
#[derive(Debug, Clone, Copy)]
pub(super) struct CallSite {
    /// The index of the call instruction in the lowered program.
    pub(super) at: usize,
    /// The index of the call's item in its source program.
    pub(super) item: usize,
    /// The subroutine number.
    pub(super) number: u32,
    /// Whether the call is of a global subroutine (GSBN).
    pub(super) global: bool,
}

impl CallSite {
    /// The name of the subroutine in the facts file: `SBN3`, or `GSBN3` for a global one.
    pub(super) fn routine(&self) -> String {
        format!("{}SBN{}", if self.global { "G" } else { "" }, self.number)
    }
}

/// The state while one program is lowered.
pub(super) struct Lowering<'a> {
    pub(super) builder: &'a mut OmronBuilder,
    pub(super) items: &'a [Item<'a>],
    pub(super) structure: &'a Structure,
    /// The index of the first instruction of each item. `None` if the item was not lowered.
    pub(super) starts: Vec<Option<usize>>,
    /// The instructions of jumps and loops, each with the item to which it leads.
    patches: Vec<(usize, usize)>,
    pub(super) calls: Vec<CallSite>,
    /// The levels of the open interlocks, outermost first: 0 for IL, the nesting depth for MILH and MILR.
    interlocks: Vec<u32>,
    /// Whether an instruction that was lowered switches a task on or off.
    pub(super) switches: bool,
}

impl<'a> Lowering<'a> {
    pub(super) fn new(
        builder: &'a mut OmronBuilder,
        items: &'a [Item<'a>],
        structure: &'a Structure,
    ) -> Self {
        let starts = vec![None; items.len()];
        Lowering {
            builder,
            items,
            structure,
            starts,
            patches: Vec::new(),
            calls: Vec::new(),
            interlocks: Vec::new(),
            switches: false,
        }
    }

    /// Lowers all items except those that never run, then resolves jumps. Returns the index of END, which is added if
    /// it is missing.
    pub(super) fn run(&mut self) -> usize {
        let first = self.structure.routines.first().map(|routine| routine.begin);
        let before_end = first.filter(|&first| self.structure.end.is_none_or(|end| first < end));
        let mut over = None;
        for at in 0..self.items.len() {
            self.builder.at(&self.items[at]);
            if Some(at) == before_end {
                // The program ends here; what follows runs only if it is called.
                self.builder.rung();
                over = Some(self.builder.push(
                    Step::Jump { fires: Logic::Const(true), target: 0 },
                    Vec::new(),
                    None,
                ));
            }
            self.builder.repeated = self.structure.repeated[at];
            self.builder.interlocked = !self.interlocks.is_empty();
            if !self.structure.dead[at] {
                self.item(at);
            }
        }
        let end = self.structure.end.and_then(|end| self.starts[end]);
        let end = end.unwrap_or_else(|| {
            self.builder.rung();
            self.builder.push(Step::End, Vec::new(), None)
        });
        if let Some(over) = over {
            self.retarget(over, end);
        }
        for (at, item) in std::mem::take(&mut self.patches) {
            // A jump to the first subroutine goes to the program's end.
            let started =
                self.starts.get(item).copied().flatten().filter(|_| Some(item) != before_end);
            self.retarget(at, started.unwrap_or(end));
        }
        end
    }

    fn retarget(&mut self, at: usize, to: usize) {
        match &mut self.builder.out.program.instructions[at].step {
            Step::Jump { target, .. } => *target = to,
            Step::ForBegin { end, .. } => *end = to,
            _ => {}
        }
    }

    fn item(&mut self, at: usize) {
        let item = &self.items[at];
        self.starts[at] = Some(self.builder.next());
        if let Some(register) = branch(item.raw) {
            self.register(item, register);
            return;
        }
        match item.meaning() {
            "load" | "load-not" | "and" | "and-not" | "or" | "or-not" => self.contact(item),
            "compare" | "compare-signed" | "compare-real" | "compare-unknown" | "test"
            | "test-not" => {
                let value = data::condition(self.builder, item);
                let flags = data::flags(self.builder, item).into_iter().map(always).collect();
                self.joined(item, item.lead.unwrap_or(Connection::Load), value, flags);
                data::note_unknown(self.builder, item);
            }
            "and-block" => self.block(item, Step::AndBlock),
            "or-block" => self.block(item, Step::OrBlock),
            "invert" | "rise" | "fall" => self.change(item),
            "nothing" => {
                let key = self.builder.key(item, true);
                self.builder.push(Step::Nothing, Vec::new(), Some(key));
            }
            "end"
            | "interlock-end"
            | "interlock-number-end"
            | "jump-end"
            | "jump-zero-end"
            | "routine"
            | "return"
            | "for"
            | "next" => self.unconditional(at, item),
            "step" => self.builder.fault(
                item,
                Code::NotModelled,
                "scanbound does not support step programs (STEP, SNXT)",
                "write the steps with KEEP, or with SET and RSET",
            ),
            "timer-holding" | "counter" | "shift-register" | "keep"
                if self.needs(item, 2 + u32::from(item.meaning() == "shift-register")) =>
            {
                timers::branched(self.builder, item);
                self.builder.depth = 0;
            }
            "counter-reversible" if self.needs(item, 3) => {
                timers::branched(self.builder, item);
                self.builder.depth = 0;
            }
            "timer-holding" | "counter" | "shift-register" | "keep" | "counter-reversible" => {
                self.builder.depth = 0
            }
            _ if self.needs(item, 1) => self.coil(at, item),
            _ => self.builder.depth = 0,
        }
    }

    /// Ends the rung at an instruction that takes this number of branches. Reports an error and returns false if more
    /// or fewer are open.
    fn needs(&mut self, item: &Item<'_>, branches: u32) -> bool {
        let open = self.builder.depth;
        self.builder.closed = true;
        if open == branches as usize {
            return true;
        }
        let (message, help) = if open == 0 {
            (
                "this instruction has no condition before it".to_owned(),
                "begin the rung with LD; use LD P_On or LD 25313 for always",
            )
        } else {
            (
                format!(
                    "{} takes {branches} branches, but the number of open branches before it is {open}",
                    item.name
                ),
                "connect branches with AND LD or OR LD; KEEP, CNT and TTIM take two branches, CNTR and SFT three",
            )
        };
        self.builder.fault(item, Code::Branches, message, help);
        false
    }

    /// Lowers `OUT TR0` and `LD TR0`.
    fn register(&mut self, item: &Item<'_>, register: u32) {
        let key = self.builder.key(item, true);
        if item.name == "OUT" {
            if self.builder.depth == 0 {
                self.needs(item, 1);
            }
            self.builder.push(Step::Save(register), Vec::new(), Some(key));
            self.builder.branches.insert(register);
            return;
        }
        if !self.builder.branches.contains(&register) {
            let message = format!("TR{register} does not hold a branch of this rung");
            self.builder.fault(
                item,
                Code::Branches,
                message,
                "write OUT TR before LD TR, in the same rung",
            );
        }
        let join = self.loading();
        self.builder.fetch(register, join, key);
    }

    /// How the value of LD is combined with the stack: it begins a rung, or one more branch of the current rung.
    fn loading(&mut self) -> Join {
        let start = self.builder.closed || self.builder.depth == 0;
        self.builder.depth = if start { 1 } else { self.builder.depth + 1 };
        self.builder.closed = false;
        if start { Join::Start } else { Join::Load }
    }

    fn contact(&mut self, item: &Item<'_>) {
        let memory = self.builder.memory;
        let source = item
            .operands
            .first()
            .and_then(|operand| operand.bit_source(memory, &mut || self.builder.choice()));
        let source = source.unwrap_or(BitSource::Const(false));
        let negated = item.meaning().ends_with("-not");
        let mut effects = Vec::new();
        let mut value = Logic::Bit(source);
        let fast = match source {
            BitSource::Cell(flag) if self.builder.fast.contains(&flag) => Some(flag),
            _ => None,
        };
        if let Some(flag) = fast {
            // The timer may have timed out since it was last executed.
            let runs = Logic::cell(memory.runs(flag));
            let between = self.builder.choice();
            self.builder.out.program.timekeeping.between_instructions.insert(between, None);
            let over = Logic::Bit(BitSource::Free(between));
            value = Logic::Any(vec![value, Logic::All(vec![runs, over])]);
        }
        if item.raw.immediate {
            // With `!`, the whole input word is read again.
            let fresh = self.builder.external_bit();
            if let Some(operand @ Operand::Bit(cell, _)) = item.operands.first()
                && Memory::is_refreshed(*cell)
                && let Some(target) = operand.bit_target()
            {
                let region = Region::Range { first: *cell, count: 1 };
                effects.push(always(Write::Havoc(region, self.builder.choice())));
                effects.push(always(Write::Bit(target, fresh.clone())));
            }
            value = fresh;
        }
        value = match (item.raw.edge, negated) {
            (None, false) => value,
            (None, true) => value.not(),
            (Some(edge), false) => self.builder.edge(value, edge),
            (Some(_), true) => self.builder.free_bit(),
        };
        let lead = match item.meaning() {
            "load" | "load-not" => Connection::Load,
            "and" | "and-not" => Connection::And,
            _ => Connection::Or,
        };
        self.joined(item, lead, value, effects);
        if item.raw.edge.is_some() && negated {
            self.builder.approximate("scanbound does not follow the edge of a negated contact: the contact may be on or off");
        }
        if fast.is_some() {
            self.builder.approximate(
                "this timer may time out between any two instructions while its condition is on",
            );
        }
        if item.operands.first().is_some_and(Operand::is_indirect) {
            self.builder.approximate(format!(
                "this instruction reads {} through an unknown address: any value is assumed for the operand",
                item.raw.operands[0]
            ));
        }
    }

    fn joined(&mut self, item: &Item<'_>, lead: Connection, value: Logic, effects: Vec<Effect>) {
        let key = self.builder.key(item, true);
        let join = match lead {
            Connection::Load => {
                if self.builder.closed || self.builder.depth == 0 {
                    self.builder.rung();
                }
                self.loading()
            }
            Connection::And | Connection::Or => {
                if self.builder.depth == 0 {
                    self.needs(item, 1);
                    self.builder.depth = 1;
                }
                self.builder.closed = false;
                if lead == Connection::And { Join::And } else { Join::Or }
            }
        };
        self.builder.push(Step::Logic { join, value }, effects, Some(key));
    }

    fn block(&mut self, item: &Item<'_>, step: Step) {
        if self.builder.depth < 2 {
            let message = format!(
                "{} connects two branches, but the number of open branches before it is {}",
                item.raw.text, self.builder.depth
            );
            self.builder.fault(item, Code::Branches, message, "begin each branch with LD");
            return;
        }
        self.builder.depth -= 1;
        let key = self.builder.key(item, true);
        self.builder.push(step, Vec::new(), Some(key));
    }

    /// Lowers NOT, UP and DOWN, which change the result of the rung.
    fn change(&mut self, item: &Item<'_>) {
        if self.builder.depth == 0 && !self.needs(item, 1) {
            return;
        }
        self.builder.closed = false;
        let value = match item.meaning() {
            "invert" => Logic::Condition.not(),
            "rise" => self.builder.edge(Logic::Condition, Edge::Rising),
            _ => self.builder.edge(Logic::Condition, Edge::Falling),
        };
        let key = self.builder.key(item, true);
        self.builder.push(Step::Logic { join: Join::Replace, value }, Vec::new(), Some(key));
    }

    fn unconditional(&mut self, at: usize, item: &Item<'_>) {
        if self.builder.depth > 0 && !self.builder.closed {
            let message = "the branch before this instruction has no output";
            self.builder.fault(
                item,
                Code::Branches,
                message,
                "end the branch with a coil or an instruction that takes a condition",
            );
        }
        self.builder.rung();
        let key = self.builder.key(item, true);
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
            "for" | "next" => data::flags(self.builder, item).into_iter().map(always).collect(),
            _ => Vec::new(),
        };
        let index = self.builder.push(step, flags, Some(key));
        if let Some(&target) = self.structure.targets.get(&at) {
            self.patches.push((index, target));
        }
    }

    fn iterations(&mut self, item: &Item<'_>) -> Step {
        let most = u32::from(u16::MAX);
        let Some(operand) = item.operands.first() else { return Step::Nothing };
        let Some(iterations) = operand.count(self.builder.memory.family) else {
            if matches!(operand, Operand::Constant(..) | Operand::Real(_) | Operand::Text) {
                let help = "write a number from 0 to 65535, such as FOR(512) &10";
                self.builder.fault(
                    item,
                    Code::LoopCount,
                    "the operand of FOR is not a number of iterations",
                    help,
                );
                return Step::Nothing;
            }
            // The range of the word's value is found later, when all its writes are known.
            let choice = self.builder.choice();
            // The C series counts in BCD, which is not analysed; neither is a word at an indirect address.
            let word = operand.word().filter(|_| self.builder.memory.family != Family::C);
            if let Some(cell) = word.filter(|&cell| !self.builder.memory.is_volatile(cell)) {
                let kind = ChoiceKind::UnsignedIterations(WordSource::Cell(cell));
                self.builder.out.program.kinds.insert(choice, kind);
            }
            self.builder.counted.push((self.builder.next(), operand.word()));
            return Step::ForBegin { count: WordSource::Free(choice), least: 0, most, end: 0 };
        };
        if iterations > most {
            let help = "write a number from 0 to 65535";
            self.builder.fault(
                item,
                Code::LoopCount,
                "the number of iterations is above 65535",
                help,
            );
            return Step::Nothing;
        }
        // `count` would be read as a signed number, so the constant is given only as `least` and `most`.
        Step::ForBegin { count: WordSource::Const(0), least: iterations, most: iterations, end: 0 }
    }

    /// Lowers a coil or another instruction that takes exactly one condition and ends the rung.
    fn coil(&mut self, at: usize, item: &Item<'_>) {
        let interlocked = self.structure.interlocked[at];
        match item.meaning() {
            "out" | "out-not" | "set" | "reset" | "pulse-rise" | "pulse-fall" => {
                self.bit_coil(item, interlocked)
            }
            "interlock" | "interlock-number" => self.interlock(item, interlocked),
            "jump" | "jump-if" | "jump-zero" => self.jump(at, item, interlocked),
            "break" => {
                let fires = self.builder.fires(item.raw.edge);
                // BREAK takes the time for skipped instructions only if it leaves the loop.
                let mut key = self.builder.key(item, false);
                let flags = data::flags(self.builder, item).into_iter().map(always).collect();
                if let Some(&next) = self.structure.targets.get(&at) {
                    key.units = Units::Exactly((next - at) as u64);
                    // The jump leads behind NEXT, which ends the loop.
                    let index =
                        self.builder.push(Step::Jump { fires, target: 0 }, flags, Some(key));
                    self.patches.push((index, next + 1));
                }
            }
            "call" => {
                let fires = self.builder.fires_or_not(item.raw.edge);
                let key = self.builder.key(item, false);
                self.call(at, item, fires, Vec::new(), key);
            }
            "macro" => self.r#macro(at, item),
            "task" => {
                self.switches = true;
                let key = self.builder.key(item, true);
                let fires = self.builder.fires(item.raw.edge);
                self.builder.act(fires, Vec::new(), Some(key));
                if item.number(self.builder.memory.family).is_none_or(|task| task >= 8000) {
                    self.builder.fault(
                        item,
                        Code::NotModelled,
                        "this instruction switches an extra cyclic task (task 8000 and up) on or off, or a task whose number is not a constant: scanbound does not support this",
                        "define the task as a cyclic task in the project, and write its number as a constant",
                    );
                }
            }
            "timer" | "timer-unknown" | "havoc-always" | "reset-timers" => {
                timers::timer(self.builder, item)
            }
            _ => application::lower_application(self.builder, item),
        }
    }

    fn bit_coil(&mut self, item: &Item<'_>, interlocked: bool) {
        let key = self.builder.key(item, false);
        let Some(target) = item.operands.first().and_then(Operand::bit_target) else {
            // Through an index register, any bit of any area may change.
            let choice = self.builder.choice();
            let regions =
                item.operands.first().map(|operand| operand.regions(Some(1))).unwrap_or_default();
            let effects =
                regions.into_iter().map(|region| always(Write::Havoc(region, choice))).collect();
            let fires = self.builder.fires(item.raw.edge);
            self.builder.act(fires, effects, Some(key));
            self.builder.approximate(format!(
                "this instruction writes {} through an unknown address: every device that it may write may have any value",
                item.raw.operands[0]
            ));
            return;
        };
        let bit = |value: Logic| Write::Bit(target, value);
        match item.meaning() {
            "out" => {
                self.builder.act(Logic::Condition, vec![always(bit(Logic::Condition))], Some(key));
            }
            "out-not" if interlocked => {
                // In an active interlock the coil is off, even a negated one.
                self.builder.keep();
                self.builder.invert();
                self.builder.act(Logic::Condition, vec![always(bit(Logic::Condition))], Some(key));
                self.builder.restore();
            }
            "out-not" => {
                self.builder.act(
                    Logic::Condition.not(),
                    vec![always(bit(Logic::Condition.not()))],
                    Some(key),
                );
            }
            "set" | "reset" => {
                let fires = self.builder.fires(item.raw.edge);
                let value = Logic::Const(item.meaning() == "set");
                self.builder.act(fires, vec![fired(bit(value))], Some(key));
            }
            meaning if interlocked => self.interlocked_pulse(meaning, target, key),
            meaning => {
                let is_rising = meaning == "pulse-rise";
                let edge = if is_rising { Edge::Rising } else { Edge::Falling };
                let value = self.builder.edge(Logic::Condition, edge);
                self.builder.act(value.clone(), vec![always(bit(value))], Some(key));
            }
        }
    }

    /// Lowers DIFU and DIFD in an interlock. They are not executed while the interlock is active, so their bit keeps
    /// its value.
    fn interlocked_pulse(
        &mut self,
        meaning: &str,
        target: BitTarget,
        key: scanbound_ir::TimingKey,
    ) {
        self.builder.keep();
        self.builder.always();
        self.builder.act(
            Logic::Condition,
            vec![fired(Write::Bit(target, Logic::Const(false)))],
            None,
        );
        self.builder.restore();
        if meaning == "pulse-fall" {
            self.builder.invert();
        }
        let fires = Logic::All(vec![Logic::Condition, self.builder.changed()]);
        self.builder.act(fires, vec![fired(Write::Bit(target, Logic::Const(true)))], Some(key));
        if meaning == "pulse-fall" {
            self.builder.restore();
        }
    }

    fn interlock(&mut self, item: &Item<'_>, interlocked: bool) {
        let key = self.builder.key(item, true);
        let numbered = item.meaning() == "interlock-number";
        let level = if numbered { self.interlocks.len() as u32 + 1 } else { 0 };
        let mut effects = Vec::new();
        if let Some(target) = item.operands.get(1).and_then(Operand::bit_target) {
            let value = if interlocked { self.builder.free_bit() } else { Logic::Condition };
            effects.push(always(Write::Bit(target, value)));
        } else if let (true, Some(operand)) = (numbered, item.operands.get(1)) {
            let choice = self.builder.choice();
            effects.extend(
                operand
                    .regions(Some(1))
                    .into_iter()
                    .map(|region| always(Write::Havoc(region, choice))),
            );
        }
        self.interlocks.push(level);
        self.builder.push(
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
            ("jump-if", true) => Logic::Any(vec![jumps, self.builder.free_bit()]),
            (_, true) => Logic::All(vec![jumps, self.builder.free_bit()]),
        };
        // CJP jumps if its condition is true, as the on-time of a table requires; JMP jumps if it is false.
        let is_by_condition = item.meaning() == "jump-if" && !interlocked;
        let mut key = self.builder.key(item, !is_by_condition);
        let Some(&target) = self.structure.targets.get(&at) else { return };
        let zero = self.builder.memory.family == Family::C && item.number(Family::C) == Some(0);
        if zero || item.meaning() == "jump-zero" {
            // These jumps execute the skipped instructions as NOP. No manual says how long that takes.
            key.names.insert(0, format!("{}:0", item.name));
            key.units = Units::AtMost((target - at - 1) as u64);
        }
        let index = self.builder.push(Step::Jump { fires, target: 0 }, Vec::new(), Some(key));
        self.patches.push((index, target));
        if zero || item.meaning() == "jump-zero" {
            self.builder.approximate(
                "it is unknown how long the PLC takes to skip an instruction: the jump is charged in every scan as if it skipped all instructions up to its JME",
            );
        }
        if interlocked {
            self.builder.approximate("a jump in an active interlock may or may not happen");
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
        let Some(number) = item.number(self.builder.memory.family) else {
            self.builder.fault(
                item,
                Code::Operand,
                "the number of the called subroutine is not a constant",
                "write a constant number, such as SBS(091) 1",
            );
            return;
        };
        let index = self.builder.push(Step::Call { fires, target: 0 }, effects, Some(key));
        self.calls.push(CallSite {
            at: index,
            item: at,
            number,
            global: item.name.starts_with('G'),
        });
    }

    /// Lowers MCRO, which copies parameters, calls a subroutine and copies results. Parameters and results may have any
    /// value.
    fn r#macro(&mut self, at: usize, item: &Item<'_>) {
        let memory = self.builder.memory;
        let fires = self.builder.fires_or_not(item.raw.edge);
        let key = self.builder.key(item, false);
        let mut effects: Vec<Effect> =
            data::flags(self.builder, item).into_iter().map(fired).collect();
        // The words for parameters and results depend on the CPU: all possible ones get any value.
        let choice = self.builder.choice();
        for (first, count) in memory.parameters() {
            effects.push(fired(Write::Havoc(Region::Range { first, count }, choice)));
        }
        self.call(at, item, fires.clone(), effects, key);
        let choice = self.builder.choice();
        let results =
            item.operands.get(2).map(|operand| operand.regions(Some(4))).unwrap_or_default();
        let effects =
            results.into_iter().map(|region| fired(Write::Havoc(region, choice))).collect();
        self.builder.act(fires, effects, None);
        self.builder.approximate("the parameters and results of the macro may have any value");
    }
}

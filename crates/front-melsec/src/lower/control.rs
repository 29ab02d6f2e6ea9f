//! Lowers the control structure: labels, jumps, calls, loops, program ends, interrupts.

use super::access::WordPlace;
use super::rungs::remember;
use super::state::{Lowering, OPEN, key, timing};
use crate::memory::area;
use crate::resolve::{Control, Item};
use crate::source::RawInstruction;
use crate::structure::Part;
use scanbound_base::code::Code;
use scanbound_front::builder::{always, fired};
use scanbound_ir::{
    AreaId, ChoiceKind, Effect, Logic, Number, Region, Step, TimingKey, Units, WordSource, Write,
};

/// The largest number of iterations of a FOR loop that a CPU accepts.
pub(super) const MAX_ITERATIONS: u32 = 32_767;

/// The areas of the function devices, which hold a call's arguments and results.
const FUNCTION_AREAS: [AreaId; 3] = [area("FD"), area("FX"), area("FY")];

impl Lowering<'_> {
    /// Lowers one control instruction, if no error in it was reported.
    pub(super) fn control(&mut self, item: &Item<'_>, control: Control) {
        let (mnemonic, raw) = (&*item.name, item.raw);
        match control {
            Control::Label(_) | Control::Interrupt | Control::LadderState => self.stand_alone(true),
            Control::Jump if mnemonic == "JMP" && self.rung.depth == 0 => self.stand_alone(false),
            Control::Jump | Control::JumpToEnd | Control::Call | Control::Break => {
                self.output_here(mnemonic);
            }
            Control::Stop | Control::Master => _ = self.output_here(mnemonic),
            _ => self.stand_alone(false),
        }
        // If the structure lacks this item, an error was already reported.
        let Some(part) = self.structure.part(self.current.item) else { return };
        match part {
            Part::Label | Part::Interrupt => self.label(mnemonic, part),
            &Part::Jump(to) if control == Control::Break => self.breaks(mnemonic, raw, to),
            &Part::Jump(to) => self.jump(mnemonic, to),
            Part::Call(_) | Part::Absent(_) => self.call(mnemonic, raw, part),
            Part::Return => self.plain(mnemonic, "call", Step::Return),
            Part::LadderEnd => self.plain(mnemonic, "set", Step::Nothing),
            Part::End => self.plain(mnemonic, "nothing", Step::End),
            Part::Stop => self.plain(mnemonic, "special", Step::Stop { fires: Logic::Condition }),
            &Part::For(next) => self.for_begins(raw, next),
            Part::Next => self.plain(mnemonic, "loop", Step::ForEnd),
            &Part::Master(level) => self.master_begins(raw, level),
            &Part::MasterEnd(level) => {
                self.plain(mnemonic, "master", Step::MasterControlEnd { level });
            }
            Part::LadderState(relays) => self.state_begins(&raw.operands[0], relays),
        }
    }

    /// Lowers a control instruction that has no effects besides its step. Jumps and loops may lead to it.
    fn plain(&mut self, mnemonic: &str, class: &'static str, step: Step) {
        let at = self.add(Some(key(mnemonic, class)), Vec::new(), step);
        self.targets.define_target(self.current.item, at);
    }

    /// Lowers a label, or the start of an interrupt program. It has a time only if the timing table gives one.
    fn label(&mut self, mnemonic: &str, part: &Part) {
        let timing = TimingKey {
            names: vec![mnemonic[..1].to_owned()],
            optional: true,
            ..key(mnemonic, "nothing")
        };
        let at = self.add(Some(timing), Vec::new(), Step::Nothing);
        self.targets.define_target(self.current.item, at);
        if *part == Part::Interrupt {
            let stated = self.options.facts.interrupt(mnemonic);
            self.out.interrupt(mnemonic.to_owned(), at, stated);
        }
    }

    fn jump(&mut self, mnemonic: &str, to: usize) {
        let (fires, effects) = match mnemonic {
            "JMP" if !self.may_be_held_off() => (Logic::Const(true), Vec::new()),
            "JMP" => {
                self.approximate("JMP is within a master control region or a step ladder state: the bound covers both cases, with and without the jump");
                (self.free_bit(), Vec::new())
            }
            "SCJ" => {
                // SCJ jumps from the scan after the one in which the condition came true.
                let memory = self.memory();
                let fires = Logic::All(vec![Logic::Condition, Logic::cell(memory)]);
                (fires, vec![remember(memory, Logic::Condition)])
            }
            _ => (Logic::Condition, Vec::new()),
        };
        let at = self.add(Some(key(mnemonic, "jump")), effects, Step::Jump { fires, target: OPEN });
        self.targets.add_jump(at, to);
    }

    fn call(&mut self, mnemonic: &str, raw: &RawInstruction, to: &Part) {
        let pulsed = mnemonic.ends_with('P');
        let label = usize::from(mnemonic.starts_with('E'));
        let mut effects = Vec::new();
        let fires = self.fires(pulsed, &mut effects);
        let passed: Vec<String> = raw.operands[label + 1..].to_vec();
        if !passed.is_empty() {
            // Arguments are passed in function devices; results are copied back after the call.
            let choice = self.choice();
            effects
                .extend(FUNCTION_AREAS.map(|area| fired(Write::Havoc(Region::Area(area), choice))));
        }
        let handed = (!passed.is_empty()).then_some("arguments");
        let timing = timing(mnemonic, pulsed, handed, "call", Units::None, false);
        let off_too = mnemonic.contains("FCALL") || mnemonic == "XCALL";
        let at = if off_too {
            // In the scan after the condition went off, the routine runs with all its coils off.
            let before = self.memory();
            effects.push(remember(before, Logic::Condition));
            let runs = Logic::Any(vec![Logic::Condition, Logic::cell(before)]);
            let call = Step::Call { fires: runs, target: OPEN };
            match to {
                // The stated writes of a missing routine include those with its coils off.
                Part::Absent(_) => self.add(Some(timing), effects, call),
                _ => self.call_with_coils_off(mnemonic, timing, effects, call),
            }
        } else {
            self.add(Some(timing), effects, Step::Call { fires, target: OPEN })
        };
        match to {
            &Part::Call(to) => self.targets.add_jump(at, to),
            Part::Absent(name) => self.targets.absent.push((at, name.clone())),
            _ => {}
        }
        self.havoc_passed(&passed);
    }

    /// Lowers a call that may run its routine with all coils off, and an instruction after it that lets every device
    /// have any value. Returns the index of the call.
    fn call_with_coils_off(
        &mut self,
        mnemonic: &str,
        timing: TimingKey,
        effects: Vec<Effect>,
        call: Step,
    ) -> usize {
        self.approximate(format!(
            "{mnemonic} also runs its routine in the scan after its condition went off, with all coils of the routine off: after the call, every device may have any value"
        ));
        let at = self.add(Some(timing), effects, call);
        self.targets.calls_with_coils_off.push(at);
        let choice = self.choice();
        let havoc = always(Write::Havoc(Region::Everything, choice));
        self.add(None, vec![havoc], Step::Nothing);
        at
    }

    /// Adds an instruction, without a time, that lets everything that a routine may pass back to its caller have any
    /// value: the operands of the call, and the function devices.
    fn havoc_passed(&mut self, passed: &[String]) {
        let mut effects = Vec::new();
        for text in passed {
            // A function device passes back at most four words.
            for region in self.regions(text, Some(4)).unwrap_or_default() {
                effects.push(always(Write::Havoc(region, self.choice())));
            }
        }
        if !passed.is_empty() {
            // Whether the routine's own function devices are copied back is unknown.
            for area in FUNCTION_AREAS {
                effects.push(always(Write::Havoc(Region::Area(area), self.choice())));
            }
        }
        if !effects.is_empty() {
            self.approximate(
                "after the call, its operands and the function devices may have any values",
            );
            self.add(None, effects, Step::Nothing);
        }
    }

    fn for_begins(&mut self, raw: &RawInstruction, next: usize) {
        let text = &raw.operands[0];
        let (low, high, known) = self.count_range(text, i64::from(MAX_ITERATIONS));
        if self.constant(text).is_some() && !(1..=i64::from(MAX_ITERATIONS)).contains(&low) {
            self.fault(
                Code::LoopCount,
                text,
                format!("the number of iterations is `{text}`, but must be 1 to {MAX_ITERATIONS}"),
                "write a number of iterations in this range",
            );
            return;
        }
        let Some(words) = self.read_words(text, 1) else { return };
        let iterations = |n: i64| n.clamp(0, i64::from(MAX_ITERATIONS)) as u32;
        let (count, least, most) = if low >= 1 {
            (words[0], iterations(low), iterations(high))
        } else {
            // With a count below 1, some CPUs run one iteration, others none.
            let choice = self.choice();
            self.out.program.kinds.insert(choice, ChoiceKind::Iterations(words[0]));
            (WordSource::Free(choice), 0, iterations(high).max(1))
        };
        let at = self.add(
            Some(key("FOR", "loop")),
            Vec::new(),
            Step::ForBegin { count, least, most, end: OPEN },
        );
        if !known {
            self.out.program.loops_without_count.insert(at);
        }
        self.targets.add_jump(at, next);
    }

    fn breaks(&mut self, mnemonic: &str, raw: &RawInstruction, to: usize) {
        let Some(place) = self.word_place(&raw.operands[0], 1) else { return };
        let mut effects = match place {
            WordPlace::All(targets) => {
                let left = Number::Words(targets.iter().map(|_| self.free_word()).collect());
                vec![fired(Write::Words(targets, left))]
            }
            WordPlace::Somewhere(region) => vec![fired(Write::Havoc(region, self.choice()))],
            WordPlace::Nowhere => Vec::new(),
        };
        let pulsed = mnemonic.ends_with('P');
        let fires = self.fires(pulsed, &mut effects);
        let timing = timing(mnemonic, pulsed, None, "jump", Units::None, false);
        let at = self.add(Some(timing), effects, Step::Jump { fires, target: OPEN });
        self.targets.add_jump(at, to);
    }
}

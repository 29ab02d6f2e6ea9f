//! Control: labels, jumps, calls, loops, ends, interrupts.

use super::access::WordPlace;
use super::rungs::remember;
use super::{Emitter, OPEN, always, fired, key, timing};
use crate::base::code::Code;
use crate::front::melsec::memory::{Family, area};
use crate::front::melsec::operand::Operand;
use crate::front::melsec::source::{RawInstruction, RawProject};
use crate::program::{
    AreaId, ChoiceKind, Interrupt, Logic, Number, Region, Step, TimingKey, Units, WordSource, Write,
};
use std::collections::BTreeMap;

/// The most iterations that a loop can have.
pub(super) const MOST_ITERATIONS: u32 = 32_767;

/// Loops and calls in each other beyond this are refused: no CPU can follow them either.
pub(super) const MOST_NESTED: usize = 64;

/// Where what a call hands over, and what it hands back, stands for its routine.
const FUNCTION_AREAS: [AreaId; 3] = [area("FD"), area("FX"), area("FY")];

/// A jump, call or loop whose target is not known yet.
pub(super) struct Fixup {
    pub instruction: usize,
    pub label: u32,
    /// The file in which to look first, or the only one for calls by a file's name.
    pub file: usize,
    /// Only this file will do.
    pub only: bool,
}

/// Where control goes in the files that were read so far.
pub(super) struct Routines {
    /// The labels of each file, and where they stand.
    pub labels: Vec<BTreeMap<u32, usize>>,
    /// What jumps to a label, or calls it.
    pub fixups: Vec<Fixup>,
    /// Calls that may run their routine with all its coils off.
    pub calls_with_coils_off: Vec<usize>,
    /// Open loops, by their beginnings.
    pub loops: Vec<usize>,
    /// Jumps to the next end of the main routine.
    pub ends: Vec<usize>,
    /// Interrupt programs.
    pub interrupts: Vec<Interrupt>,
}

impl Routines {
    /// Before anything of a project is read.
    pub fn of(project: &RawProject) -> Routines {
        Routines {
            labels: vec![BTreeMap::new(); project.files.len()],
            fixups: Vec::new(),
            calls_with_coils_off: Vec::new(),
            loops: Vec::new(),
            ends: Vec::new(),
            interrupts: Vec::new(),
        }
    }
}

impl Emitter<'_> {
    /// Decodes control instructions; false if it is none.
    pub(super) fn control(&mut self, mnemonic: &str, raw: &RawInstruction) -> bool {
        match mnemonic {
            "CJ" | "SCJ" | "JMP" | "GOEND" => self.jump(mnemonic, raw),
            "CALL" | "CALLP" | "FCALL" | "FCALLP" | "ECALL" | "ECALLP" | "EFCALL" | "EFCALLP"
            | "XCALL" => {
                self.call(mnemonic, raw);
            }
            "RET" if self.masters.state.is_some() => self.step_ladder_ends(mnemonic, raw),
            "RETSTL" => self.step_ladder_ends(mnemonic, raw),
            "RET" | "SRET" | "IRET" => self.alone(mnemonic, raw, "call", Step::Return),
            "FEND" | "END" => {
                if self.masters.state.is_some() {
                    self.close_state();
                }
                self.alone(mnemonic, raw, "nothing", Step::End);
            }
            "FOR" => self.for_begins(raw),
            "NEXT" => self.for_ends(raw),
            "BREAK" | "BREAKP" => self.breaks(mnemonic, raw),
            "STOP" => {
                if self.output_here(mnemonic) && self.takes(raw, 0) {
                    self.add(
                        Some(key(mnemonic, "special")),
                        Vec::new(),
                        Step::Stop { fires: Logic::Condition },
                    );
                }
            }
            "MC" => self.zone_begins(raw),
            "MCR" => self.zone_ends(raw),
            "STL" => self.state_begins(raw),
            _ => return self.label(mnemonic, raw),
        }
        true
    }

    /// An instruction without operands that stands in a rung of its own.
    pub(super) fn alone(
        &mut self,
        mnemonic: &str,
        raw: &RawInstruction,
        class: &'static str,
        step: Step,
    ) {
        self.stand_alone(false);
        if self.takes(raw, 0) {
            self.add(Some(key(mnemonic, class)), Vec::new(), step);
        }
    }

    /// A pointer's label, or an interrupt's; false if the line is none.
    fn label(&mut self, mnemonic: &str, raw: &RawInstruction) -> bool {
        if !raw.operands.is_empty() {
            return false;
        }
        let operand = self.parsed(mnemonic);
        if !matches!(operand, Ok(Operand::Pointer(_) | Operand::Interrupt(_))) {
            return false;
        }
        self.stand_alone(true);
        let timing = TimingKey {
            names: vec![mnemonic[..1].to_owned()],
            optional: true,
            ..key(mnemonic, "nothing")
        };
        let at = self.add(Some(timing), Vec::new(), Step::Nothing);
        match operand {
            Ok(Operand::Pointer(label)) => {
                if self.routines.labels[self.now.file].insert(label, at).is_some() {
                    self.fault(
                        Code::DoubleLabel,
                        mnemonic,
                        format!("the label {mnemonic} stands twice in this file"),
                        "give each place a label of its own",
                    );
                }
            }
            _ => {
                let stated = self.options.facts.interrupt(mnemonic);
                self.routines.interrupts.push(Interrupt {
                    name: mnemonic.to_owned(),
                    entry: at,
                    times: stated.unwrap_or(1),
                    stated: stated.is_some(),
                });
            }
        }
        true
    }

    /// A pointer operand.
    fn pointer(&mut self, text: &str) -> Option<u32> {
        match self.operand(text)? {
            Operand::Pointer(label) => Some(label),
            _ => {
                self.fault(
                    Code::Operand,
                    text,
                    format!("`{text}` is no label"),
                    "name a label such as P10",
                );
                None
            }
        }
    }

    /// Notes a jump or call whose label is to be found once all files are read; `only` in that file.
    fn fix(&mut self, instruction: usize, label: u32, file: usize, only: bool) {
        self.routines.fixups.push(Fixup { instruction, label, file, only });
    }

    fn jump(&mut self, mnemonic: &str, raw: &RawInstruction) {
        if mnemonic == "JMP" && self.rung.depth == 0 {
            self.stand_alone(false);
        } else {
            self.output_here(mnemonic);
        }
        if !self.takes(raw, usize::from(mnemonic != "GOEND")) {
            return;
        }
        let (fires, effects) = match mnemonic {
            "JMP" if self.masters.open.is_empty() => (Logic::Const(true), Vec::new()),
            "JMP" => {
                self.approximate("JMP within a master control is taken to jump or not");
                (self.free_bit(), Vec::new())
            }
            "SCJ" => {
                // It jumps from the scan on after the one in which the condition came true.
                let memory = self.memory();
                let fires = Logic::All(vec![Logic::Condition, Logic::cell(memory)]);
                (fires, vec![remember(memory, Logic::Condition)])
            }
            _ => (Logic::Condition, Vec::new()),
        };
        let label = match raw.operands.first() {
            None => None,
            Some(text) => match self.pointer(text) {
                Some(label) => Some(label),
                None => return,
            },
        };
        let at = self.add(Some(key(mnemonic, "jump")), effects, Step::Jump { fires, target: OPEN });
        match label {
            // The FX's P63 is END, without a label.
            Some(63) if self.family == Family::Fx => self.routines.ends.push(at),
            Some(label) => self.fix(at, label, self.now.file, true),
            None => self.routines.ends.push(at),
        }
    }

    fn call(&mut self, mnemonic: &str, raw: &RawInstruction) {
        self.output_here(mnemonic);
        let by_file = mnemonic.starts_with('E');
        let pulsed = mnemonic.ends_with('P');
        let first = usize::from(by_file);
        if raw.operands.len() <= first {
            self.takes(raw, first + 1);
            return;
        }
        let file = if by_file { self.file_of(&raw.operands[0]) } else { Some(self.now.file) };
        let label = self.pointer(&raw.operands[first]);
        let (Some(file), Some(label)) = (file, label) else { return };
        let mut effects = Vec::new();
        let fires = self.fires(pulsed, &mut effects);
        let passed: Vec<String> = raw.operands[first + 1..].to_vec();
        if !passed.is_empty() {
            // What is handed over stands in function devices; what comes back is copied behind the call.
            let choice = self.choice();
            effects
                .extend(FUNCTION_AREAS.map(|area| fired(Write::Havoc(Region::Area(area), choice))));
        }
        let handed = (!passed.is_empty()).then_some("arguments");
        let timing = timing(mnemonic, pulsed, handed, "call", Units::None, false);
        let off_too = mnemonic.contains("FCALL") || mnemonic == "XCALL";
        let at = if off_too {
            // On the scan after its condition fell, the routine runs with all its coils off.
            let before = self.memory();
            effects.push(remember(before, Logic::Condition));
            let runs = Logic::Any(vec![Logic::Condition, Logic::cell(before)]);
            self.approximate(format!(
                "{mnemonic} with its condition off is taken to leave any value in every device"
            ));
            let at = self.add(Some(timing), effects, Step::Call { fires: runs, target: OPEN });
            self.routines.calls_with_coils_off.push(at);
            let choice = self.choice();
            let havoc = always(Write::Havoc(Region::Everything, choice));
            self.add(None, vec![havoc], Step::Nothing);
            at
        } else {
            self.add(Some(timing), effects, Step::Call { fires, target: OPEN })
        };
        self.fix(at, label, file, by_file);
        self.havoc_passed(&passed);
    }

    /// What a routine may hand back behind its call takes any value.
    fn havoc_passed(&mut self, passed: &[String]) {
        let mut effects = Vec::new();
        for text in passed {
            // A function device hands back four words at most.
            for region in self.regions(text, Some(4)).unwrap_or_default() {
                effects.push(always(Write::Havoc(region, self.choice())));
            }
        }
        if !passed.is_empty() {
            // Whether a routine's own function devices come back with it is not known.
            for area in FUNCTION_AREAS {
                effects.push(always(Write::Havoc(Region::Area(area), self.choice())));
            }
        }
        if !effects.is_empty() {
            self.approximate("what the routine hands back is taken as any value");
            self.add(None, effects, Step::Nothing);
        }
    }

    /// The file whose program an operand names; a fault is noted.
    fn file_of(&mut self, text: &str) -> Option<usize> {
        let Operand::Text(name) = self.operand(text)? else {
            self.fault(
                Code::Operand,
                text,
                format!("`{text}` is no program's name"),
                "write the name in quotes",
            );
            return None;
        };
        let stem = name.split('.').next().unwrap_or(&name);
        let found =
            self.project.files.iter().position(|file| file.program.eq_ignore_ascii_case(stem));
        if found.is_none() {
            let message = format!("the program `{name}` is not among the files given");
            self.fault(
                Code::NoProgram,
                text,
                message,
                "give all files of the project, each named as its program",
            );
        }
        found
    }

    fn for_begins(&mut self, raw: &RawInstruction) {
        self.stand_alone(false);
        self.routines.loops.push(self.program.instructions.len());
        if self.routines.loops.len() > MOST_NESTED {
            let message = format!("more than {MOST_NESTED} loops stand in each other");
            self.fault(Code::Nesting, "FOR", message, "no CPU allows more than 16");
        }
        if !self.takes(raw, 1) {
            return;
        }
        let text = &raw.operands[0];
        let (low, high, known) = self.count_range(text, i64::from(MOST_ITERATIONS));
        if self.constant(text).is_some() && !(1..=i64::from(MOST_ITERATIONS)).contains(&low) {
            self.fault(
                Code::LoopCount,
                text,
                format!("a loop runs 1 to {MOST_ITERATIONS} times"),
                "write a count of that range",
            );
            return;
        }
        let Some(words) = self.read_words(text, 1) else { return };
        let iterations = |n: i64| n.clamp(0, i64::from(MOST_ITERATIONS)) as u32;
        let (count, least, most) = if low >= 1 {
            (words[0], iterations(low), iterations(high))
        } else {
            // Whether a count below 1 gives one turn or none differs between CPUs.
            let choice = self.choice();
            self.program.kinds.insert(choice, ChoiceKind::Iterations(words[0]));
            (WordSource::Free(choice), 0, iterations(high).max(1))
        };
        let at = self.add(
            Some(key("FOR", "loop")),
            Vec::new(),
            Step::ForBegin { count, least, most, end: OPEN },
        );
        if !known {
            self.program.uncounted.insert(at);
        }
    }

    fn for_ends(&mut self, raw: &RawInstruction) {
        self.stand_alone(false);
        if !self.takes(raw, 0) {
            return;
        }
        let at = self.add(Some(key("NEXT", "loop")), Vec::new(), Step::ForEnd);
        let Some(begin) = self.routines.loops.pop() else {
            self.fault(
                Code::NoLoop,
                "NEXT",
                "`NEXT` without a FOR before it",
                "begin the loop with FOR",
            );
            return;
        };
        if let Some(Step::ForBegin { end, .. }) =
            self.program.instructions.get_mut(begin).map(|i| &mut i.step)
        {
            *end = at;
            if self.masters.of[begin] != self.masters.of[at] {
                self.fault(
                    Code::CrossedMasterControl,
                    "NEXT",
                    "the loop and a master control cut across each other",
                    "close the one within the other",
                );
            }
        }
    }

    fn breaks(&mut self, mnemonic: &str, raw: &RawInstruction) {
        self.output_here(mnemonic);
        if !self.takes(raw, 2) {
            return;
        }
        if self.routines.loops.is_empty() {
            self.fault(
                Code::NoLoop,
                mnemonic,
                "`BREAK` outside a loop",
                "it ends the loop of FOR and NEXT in which it stands",
            );
            return;
        }
        let (place, label) = (self.word_place(&raw.operands[0], 1), self.pointer(&raw.operands[1]));
        let (Some(place), Some(label)) = (place, label) else { return };
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
        self.fix(at, label, self.now.file, true);
    }

    /// What must be closed when a file ends.
    pub(super) fn end_of_file(&mut self) {
        self.check_rung();
        self.close_state();
        if let Some(&begin) = self.routines.loops.first() {
            let line = self.program.instructions.get(begin).map_or(0, |i| i.place.line);
            self.fault(
                Code::OpenLoop,
                "",
                format!("the FOR in line {line} has no NEXT"),
                "end the loop with NEXT",
            );
            self.routines.loops.clear();
        }
        if let Some(&(level, at)) = self.masters.open.first() {
            let line = self.program.instructions[at].place.line;
            self.fault(
                Code::OpenMasterControl,
                "",
                format!("the MC N{level} in line {line} has no MCR"),
                "end the master control with MCR",
            );
            self.masters.open.clear();
        }
        let end = self.program.instructions.iter().rposition(|i| i.step == Step::End).unwrap_or(0);
        for at in std::mem::take(&mut self.routines.ends) {
            let next = (at + 1..end)
                .find(|&i| self.program.instructions[i].step == Step::End)
                .unwrap_or(end);
            if let Step::Jump { target, .. } = &mut self.program.instructions[at].step {
                *target = next;
            }
        }
    }
}

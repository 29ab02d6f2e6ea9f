//! Regions in which coils are off while a condition does not hold: master control and step ladders.

use super::{Emitter, OPEN, key};
use crate::base::code::Code;
use crate::front::melsec::operand::{Operand, Place};
use crate::front::melsec::source::RawInstruction;
use crate::program::{Cell, Effect, Join, Logic, Step, TimingKey};

/// Regions of step ladders lie above all nesting levels of master control.
const STATE_LEVEL: u32 = 1000;

/// An open state of a step ladder (STL).
pub(super) struct State {
    /// The relays that must all be on.
    pub(super) relays: Vec<Cell>,
    /// The jump over it.
    jump: usize,
    /// The first instruction in it.
    begins: usize,
}

/// Open master control regions and the step ladder's open state.
#[derive(Default)]
pub(super) struct Masters {
    /// Open regions: level and the instruction that opened it.
    pub open: Vec<(u32, usize)>,
    /// For each instruction the one that opened the region in which it stands.
    pub of: Vec<Option<usize>>,
    /// The step ladder's open state.
    pub state: Option<State>,
}

impl Emitter<'_> {
    pub(super) fn zone_begins(&mut self, raw: &RawInstruction) {
        self.output_here("MC");
        if !self.takes(raw, 2) {
            return;
        }
        let level = self.nesting(&raw.operands[0]);
        let effects: Option<Vec<Effect>> =
            self.bit_effects(&raw.operands[1], Logic::Condition, true);
        let (Some(level), Some(effects)) = (level, effects) else { return };
        if self.masters.open.last().is_some_and(|&(open, _)| open >= level && open < STATE_LEVEL) {
            self.fault(
                Code::Nesting,
                &raw.operands[0],
                format!("N{level} is open already"),
                "nest master controls with rising numbers",
            );
        }
        let at = self.add(
            Some(key("MC", "master")),
            effects,
            Step::MasterControlBegin { level, fires: Logic::Condition },
        );
        self.masters.open.push((level, at));
    }

    pub(super) fn zone_ends(&mut self, raw: &RawInstruction) {
        self.stand_alone(false);
        if !self.takes(raw, 1) {
            return;
        }
        let Some(level) = self.nesting(&raw.operands[0]) else { return };
        if !self.masters.open.iter().any(|&(open, _)| open == level) {
            self.fault(
                Code::NoMasterControl,
                &raw.operands[0],
                format!("no MC has opened N{level}"),
                "open the master control with MC",
            );
            return;
        }
        self.masters.open.retain(|&(open, _)| open < level);
        self.add(Some(key("MCR", "master")), Vec::new(), Step::MasterControlEnd { level });
    }

    fn nesting(&mut self, text: &str) -> Option<u32> {
        match self.operand(text)? {
            Operand::Nesting(level) => Some(level),
            _ => {
                self.fault(
                    Code::Operand,
                    text,
                    format!("`{text}` is no nesting level"),
                    "write N0 to N14",
                );
                None
            }
        }
    }

    /// A state of a step ladder: a master control region that runs while its relay is on, and perhaps once more behind that,
    /// to switch its coils off.
    pub(super) fn state_begins(&mut self, raw: &RawInstruction) {
        let here = self.program.instructions.len();
        let mut relays = match &self.masters.state {
            // STL directly behind STL: both relays are needed.
            Some(state) if state.begins == here => state.relays.clone(),
            _ => Vec::new(),
        };
        if self.masters.state.is_some() {
            self.close_state();
        }
        self.stand_alone(true);
        if !self.takes(raw, 1) {
            return;
        }
        let text = &raw.operands[0];
        let Some(device) = self.device(text) else { return };
        let relay = match device.place {
            Place::At(kind, index) if device.name == "S" => kind.cell(index),
            _ => None,
        };
        let Some(relay) = relay else {
            self.fault(
                Code::Operand,
                text,
                format!("`{text}` is no step relay"),
                "write S0, S1 ...",
            );
            return;
        };
        relays.push(relay);
        let on = Logic::All(relays.iter().map(|&relay| Logic::cell(relay)).collect());
        self.approximate(format!(
            "{text}: a state that is off may run once more to switch its coils off"
        ));
        let skipped = Logic::All(vec![on.clone().not(), self.free_bit()]);
        let timing = TimingKey { dearer: true, ..key("STL", "set") };
        let jump = self.add(Some(timing), Vec::new(), Step::Jump { fires: skipped, target: OPEN });
        let master =
            self.add(None, Vec::new(), Step::MasterControlBegin { level: STATE_LEVEL, fires: on });
        self.masters.open.push((STATE_LEVEL, master));
        self.add(None, Vec::new(), Step::Logic { join: Join::Start, value: Logic::Const(true) });
        self.rung.depth = 1;
        self.masters.state = Some(State { relays, jump, begins: self.program.instructions.len() });
    }

    /// Ends the open state; the jump over it leads behind.
    pub(super) fn close_state(&mut self) {
        let Some(state) = self.masters.state.take() else { return };
        self.masters.open.retain(|&(open, _)| open < STATE_LEVEL);
        self.add(None, Vec::new(), Step::MasterControlEnd { level: STATE_LEVEL });
        let behind = self.add(None, Vec::new(), Step::Nothing);
        if let Step::Jump { target, .. } = &mut self.program.instructions[state.jump].step {
            *target = behind;
        }
    }

    pub(super) fn step_ladder_ends(&mut self, mnemonic: &str, raw: &RawInstruction) {
        self.close_state();
        self.alone(mnemonic, raw, "set", Step::Nothing);
    }
}

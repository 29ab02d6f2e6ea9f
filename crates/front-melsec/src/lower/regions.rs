//! Regions whose coils are off while a condition is false: master control regions and states of step ladders.

use super::state::{LadderState, Lowering, OPEN, key};
use crate::source::RawInstruction;
use scanbound_ir::{Cell, Effect, Join, Logic, Step, TimingKey};

/// The level of step ladder states in the list of regions; it is above all nesting levels of master control.
const STATE_LEVEL: u32 = 1000;

impl Lowering<'_> {
    /// Whether a master control region or step ladder state may prevent the current instruction from acting.
    pub(super) fn may_be_held_off(&self) -> bool {
        self.structure.site(self.current.item).master.is_some()
    }

    pub(super) fn master_begins(&mut self, raw: &RawInstruction, level: u32) {
        let effects: Option<Vec<Effect>> =
            self.bit_effects(&raw.operands[1], Logic::Condition, true);
        let Some(effects) = effects else { return };
        let begins = Step::MasterControlBegin { level, fires: Logic::Condition };
        self.add(Some(key("MC", "master")), effects, begins);
    }

    /// Begins a state of a step ladder, which the operand `text` names. It is lowered to a master control region that
    /// runs while all its relays are on, and perhaps once more afterwards, to switch its coils off.
    pub(super) fn state_begins(&mut self, text: &str, relays: &[Cell]) {
        let on = Logic::All(relays.iter().map(|&relay| Logic::cell(relay)).collect());
        self.approximate(format!(
            "the state {text} may be executed once more after it became inactive, to switch its coils off"
        ));
        let skipped = Logic::All(vec![on.clone().not(), self.free_bit()]);
        let timing = TimingKey { use_larger_time: true, ..key("STL", "set") };
        let jump = self.add(Some(timing), Vec::new(), Step::Jump { fires: skipped, target: OPEN });
        self.add(None, Vec::new(), Step::MasterControlBegin { level: STATE_LEVEL, fires: on });
        self.add(None, Vec::new(), Step::Logic { join: Join::Start, value: Logic::Const(true) });
        self.rung.depth = 1;
        self.state = Some(LadderState { item: self.current.item, relays: relays.to_vec(), jump });
    }

    /// Ends the open step ladder state, unless it began at the item `next` (then the current item is still in it), and
    /// resolves the jump over the state.
    pub(super) fn leave_state(&mut self, next: Option<usize>) {
        let Some(state) = self.state.take_if(|open| next != Some(open.item)) else { return };
        self.add(None, Vec::new(), Step::MasterControlEnd { level: STATE_LEVEL });
        let behind = self.add(None, Vec::new(), Step::Nothing);
        if let Step::Jump { target, .. } = &mut self.out.program.instructions[state.jump].step {
            *target = behind;
        }
    }
}

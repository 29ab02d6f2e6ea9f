//! Lowers contacts and connections: LD to ORI, edges, ANB, ORB, MPS, MRD, MPP, INV, MEP, MEF, EGP, EGF; finds where
//! rungs begin.

use scanbound_base::code::Code;
use scanbound_front::builder::always;
use std::borrow::Cow;

use super::state::{Lowering, edge, timing};
use crate::operand::upper;
use crate::resolve::Category;
use crate::source::RawInstruction;
use scanbound_ir::{BitTarget, Cell, Effect, Join, Logic, Step, TimingKey, Units, Write};

impl Lowering<'_> {
    pub(super) fn contact(
        &mut self,
        mnemonic: &str,
        raw: &RawInstruction,
        join: Join,
        rising: Option<bool>,
        negated: bool,
    ) {
        let variant = letters(raw.operands.first());
        let key = timing(mnemonic, false, Some(&variant), "contact", Units::None, true);
        // Even if the operand is wrong, the rung continues, so that no further error follows.
        let join = self.join(join, mnemonic);
        let mut effects = Vec::new();
        let mut value = Logic::Const(false);
        if self.takes(raw, 1)
            && let Some(bit) = self.read_bit(&raw.operands[0])
        {
            value = match rising {
                None => bit,
                Some(rising) => {
                    self.note_single(&bit);
                    let memory = self.edge_memory(true);
                    effects.push(remember(memory, bit.clone()));
                    edge(rising, bit, memory)
                }
            };
        }
        let value = if negated { value.not() } else { value };
        self.add(Some(key), effects, Step::Logic { join, value });
    }

    /// Lowers a contact that is true while the program in its operand runs. It may be true or false.
    pub(super) fn program_check(&mut self, mnemonic: &str, raw: &RawInstruction, join: Join) {
        let join = self.join(join, mnemonic);
        self.takes(raw, 1);
        self.approximate("it is unknown whether the program that this contact tests runs: the contact may be true or false");
        let key = timing(mnemonic, false, None, "special", Units::None, true);
        let value = self.free_bit();
        self.add(Some(key), Vec::new(), Step::Logic { join, value });
    }

    /// How a contact is combined with the results before it: [`Join::Start`] if it begins a rung, which is then
    /// recorded. Reports an error if a contact such as AND has none before it.
    pub(super) fn join(&mut self, join: Join, mnemonic: &str) -> Join {
        match join {
            Join::Load
                if self.rung.has_output && self.rung.saved == 0 && !self.is_joined_later() =>
            {
                self.begin_block();
                self.rung.depth = 1;
                Join::Start
            }
            Join::Load => {
                self.rung.depth += 1;
                Join::Load
            }
            other => {
                if self.rung.depth == 0 {
                    let message = format!("`{mnemonic}` has no contact before it");
                    self.fault(
                        Code::NoRung,
                        mnemonic,
                        message,
                        "begin the rung with a contact such as LD",
                    );
                    self.rung.depth = 1;
                    return Join::Start;
                }
                other
            }
        }
    }

    /// Whether a later ANB or ORB connects the block that begins here with what is before it: then the rung continues
    /// after its output.
    fn is_joined_later(&self) -> bool {
        if self.rung.depth == 0 {
            return false;
        }
        let mut blocks = 1;
        let end = self.resolved.files[self.current.file].end;
        for item in &self.resolved.items[self.current.item + 1..end] {
            match item.category {
                Category::Contact { join: Join::Load, .. }
                | Category::Comparison { join: Join::Load, .. } => blocks += 1,
                Category::Contact { .. } | Category::Comparison { .. } | Category::Result => {}
                Category::Block => match blocks {
                    1 => return true,
                    _ => blocks -= 1,
                },
                _ if item.name == "NOP" => {}
                _ => return false,
            }
        }
        false
    }

    /// Begins a new rung, unless a label has just begun one.
    pub(super) fn begin_block(&mut self) {
        if !self.rung.open {
            self.check_rung();
            self.out.program.blocks += 1;
        }
        (self.rung.depth, self.rung.has_output, self.rung.open) = (0, false, false);
    }

    /// Begins a rung for an instruction that needs no condition: a label, an end, or the beginning of a loop.
    /// `joined_by_next`: the next contact belongs to this rung, too.
    pub(super) fn stand_alone(&mut self, joined_by_next: bool) {
        if !self.rung.open {
            self.check_rung();
            self.out.program.blocks += 1;
        }
        (self.rung.depth, self.rung.has_output, self.rung.open) = (0, true, joined_by_next);
    }

    /// Reports an error if the rung that ends here has no output, or an MPS without its MPP.
    pub(super) fn check_rung(&mut self) {
        if !self.rung.has_output && self.rung.depth > 0 {
            self.fault(
                Code::OpenRung,
                "",
                "the rung before this line has no output",
                "end that rung with a coil or an instruction",
            );
        }
        if self.rung.saved > 0 {
            self.fault(
                Code::OpenBranch,
                "",
                "an MPS before this line has no MPP",
                "close the branch with MPP",
            );
            self.rung.saved = 0;
        }
    }

    /// Records that the rung has an output. Reports an error if there is no rung (then returns false) or if blocks of
    /// contacts are not connected.
    pub(super) fn output_here(&mut self, mnemonic: &str) -> bool {
        if self.rung.depth == 0 {
            let message = format!("`{mnemonic}` needs a condition, but has no contact before it");
            self.fault(
                Code::NoRung,
                mnemonic,
                message,
                "begin the rung with a contact such as LD SM400",
            );
            self.begin_block();
            self.rung.has_output = true;
            return false;
        }
        if self.rung.depth > 1 {
            let message = format!(
                "{} blocks of contacts before this instruction are not connected",
                self.rung.depth
            );
            self.fault(Code::Unjoined, mnemonic, message, "connect the blocks with ANB or ORB");
            self.rung.depth = 1;
        }
        self.rung.has_output = true;
        true
    }

    pub(super) fn block(&mut self, mnemonic: &str, raw: &RawInstruction) {
        let key = stack_key(mnemonic);
        if !self.takes(raw, 0) {
            return;
        }
        if self.rung.depth < 2 {
            let message = format!(
                "`{mnemonic}` connects two blocks of contacts, but before it there {}",
                if self.rung.depth == 1 { "is one" } else { "is none" }
            );
            self.fault(Code::NoBlock, mnemonic, message, "begin the second block with LD");
            return;
        }
        self.rung.depth -= 1;
        self.add(
            Some(key),
            Vec::new(),
            if mnemonic == "ANB" { Step::AndBlock } else { Step::OrBlock },
        );
    }

    pub(super) fn branch(&mut self, mnemonic: &str, raw: &RawInstruction) {
        let key = stack_key(mnemonic);
        if !self.takes(raw, 0) {
            return;
        }
        if mnemonic == "MPS" {
            if self.rung.depth == 0 {
                self.fault(
                    Code::NoRung,
                    mnemonic,
                    "`MPS` has no contact before it",
                    "begin the rung with a contact such as LD",
                );
                return;
            }
            self.add(Some(key), Vec::new(), Step::Save(self.rung.saved));
            self.rung.saved += 1;
            return;
        }
        if self.rung.saved == 0 {
            self.fault(
                Code::NoBranch,
                mnemonic,
                format!("`{mnemonic}` has no MPS before it"),
                "put MPS before the first of the branches",
            );
            return;
        }
        let slot = self.rung.saved - 1;
        if mnemonic == "MPP" {
            self.rung.saved = slot;
        }
        self.rung.depth = self.rung.depth.max(1);
        self.rung.has_output = false;
        self.add(Some(key), Vec::new(), Step::Fetch(slot));
    }

    pub(super) fn result(&mut self, mnemonic: &str, raw: &RawInstruction) {
        let key = stack_key(mnemonic);
        let takes_relay = mnemonic.starts_with("EG");
        if !self.takes(raw, usize::from(takes_relay)) {
            return;
        }
        if self.rung.depth == 0 {
            let message = format!("`{mnemonic}` has no contact before it");
            self.fault(Code::NoRung, mnemonic, message, "begin the rung with a contact such as LD");
            return;
        }
        let rising = mnemonic.ends_with('P');
        // Whether an inactive master control region makes the result false here is unknown.
        let result = match (mnemonic, self.may_be_held_off()) {
            ("INV", _) | (_, false) => Logic::Condition,
            _ => self.result_or_off(),
        };
        let (effects, value) = match (mnemonic, takes_relay) {
            ("INV", _) => (Vec::new(), Logic::Condition.not()),
            (_, false) => {
                let memory = self.edge_memory(false);
                (vec![remember(memory, result)], edge(rising, Logic::Condition, memory))
            }
            (_, true) => {
                let text = &raw.operands[0];
                let Some(before) = self.read_bit(text) else { return };
                let Some(effects) = self.bit_effects(text, result, true) else { return };
                let value = if rising {
                    Logic::All(vec![Logic::Condition, before.not()])
                } else {
                    Logic::All(vec![Logic::Condition.not(), before])
                };
                (effects, value)
            }
        };
        self.add(Some(key), effects, Step::Logic { join: Join::Replace, value });
    }
}

impl Lowering<'_> {
    /// An expression for the result of the rung that may also be false where the result is true, as in an inactive
    /// master control region. Adds an instruction without a time, on which the expression depends.
    fn result_or_off(&mut self) -> Logic {
        let within = self.memory();
        let acts = Step::Act { fires: Logic::Const(true) };
        self.add(None, vec![remember(within, Logic::Condition)], acts);
        let on = Logic::Any(vec![Logic::cell(within), self.free_bit()]);
        Logic::All(vec![Logic::Condition, on])
    }
}

impl Lowering<'_> {
    /// The condition on which an instruction fires: the result of the rung, or for a pulse form its rising edge. For a
    /// pulse form, the write of the remembered result is added to the effects.
    pub(super) fn fires(&mut self, pulsed: bool, effects: &mut Vec<Effect>) -> Logic {
        if !pulsed {
            return Logic::Condition;
        }
        let memory = self.edge_memory(false);
        effects.push(remember(memory, Logic::Condition));
        edge(true, Logic::Condition, memory)
    }
}

/// An effect that stores a value in a hidden bit whenever the instruction is reached.
pub(super) fn remember(memory: Cell, value: Logic) -> Effect {
    always(Write::Bit(BitTarget::Cell(memory), value))
}

fn stack_key(mnemonic: &str) -> TimingKey {
    timing(mnemonic, false, None, "stack", Units::None, true)
}

/// The letters with which an operand begins, in upper case, for names of table rows such as `OUT:T`. Empty if there is
/// no operand.
pub(super) fn letters(operand: Option<&String>) -> Cow<'_, str> {
    let text = operand.map_or("", String::as_str);
    upper(&text[..text.bytes().take_while(u8::is_ascii_alphabetic).count()])
}

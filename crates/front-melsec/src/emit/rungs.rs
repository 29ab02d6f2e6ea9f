//! Contacts and the stack: LD to ORI, edges, ANB, ORB, MPS, MRD, MPP, INV, MEP, MEF, EGP, EGF; where rungs begin.

use scanbound_base::code::Code;
use scanbound_front::builder::always;
use std::borrow::Cow;

use super::{Emitter, edge, timing};
use crate::operand::upper;
use crate::resolve::Category;
use crate::source::RawInstruction;
use scanbound_ir::{BitTarget, Cell, Effect, Join, Logic, Step, TimingKey, Units, Write};

/// A rung under way.
pub(super) struct Rung {
    /// Results on the stack.
    pub depth: usize,
    /// Results saved by MPS.
    pub saved: u32,
    /// Whether it has put anything out yet.
    pub has_output: bool,
    /// It was begun by a label or the like, which the next contact joins.
    pub open: bool,
}

impl Default for Rung {
    /// Behind a rung that is complete.
    fn default() -> Rung {
        Rung { depth: 0, saved: 0, has_output: true, open: false }
    }
}

impl Emitter<'_> {
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
        // The rung goes on even where the operand is at fault, so that no further fault follows from it.
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

    /// A contact that is true while a program runs.
    pub(super) fn program_check(&mut self, mnemonic: &str, raw: &RawInstruction, join: Join) {
        let join = self.join(join, mnemonic);
        self.takes(raw, 1);
        self.approximate("whether a program runs is taken as true or false");
        let key = timing(mnemonic, false, None, "special", Units::None, true);
        let value = self.free_bit();
        self.add(Some(key), Vec::new(), Step::Logic { join, value });
    }

    /// How a contact joins, after noting where a rung begins.
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
                    let message = format!("`{mnemonic}` has nothing in front of it");
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

    /// Whether ANB or ORB joins the block that begins here to what is in front of it: the rung then goes on behind
    /// its output.
    fn is_joined_later(&self) -> bool {
        if self.rung.depth == 0 {
            return false;
        }
        let mut blocks = 1;
        let end = self.resolved.files[self.now.file].end;
        for item in &self.resolved.items[self.now.item + 1..end] {
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

    /// Begins a new rung, unless a label just did.
    pub(super) fn begin_block(&mut self) {
        if !self.rung.open {
            self.check_rung();
            self.out.program.blocks += 1;
        }
        (self.rung.depth, self.rung.has_output, self.rung.open) = (0, false, false);
    }

    /// Begins a rung for what stands by itself: labels, ends, loops.
    pub(super) fn stand_alone(&mut self, joined_by_next: bool) {
        if !self.rung.open {
            self.check_rung();
            self.out.program.blocks += 1;
        }
        (self.rung.depth, self.rung.has_output, self.rung.open) = (0, true, joined_by_next);
    }

    /// A rung that ends must have put something out and closed its branches.
    pub(super) fn check_rung(&mut self) {
        if !self.rung.has_output && self.rung.depth > 0 {
            self.fault(
                Code::OpenRung,
                "",
                "the rung before this line puts nothing out",
                "end it with a coil or an instruction",
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

    /// Notes an output of the rung; false, with a fault, if there is no rung or its blocks are not joined.
    pub(super) fn output_here(&mut self, mnemonic: &str) -> bool {
        if self.rung.depth == 0 {
            let message = format!("`{mnemonic}` needs a condition and has none");
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
            let message = format!("{} blocks of contacts are not joined here", self.rung.depth);
            self.fault(Code::Unjoined, mnemonic, message, "join them with ANB or ORB");
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
                "`{mnemonic}` joins two blocks of contacts, here {}",
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
                    "`MPS` has nothing in front of it",
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
                format!("`{mnemonic}` without an MPS before it"),
                "save the result with MPS first",
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
            let message = format!("`{mnemonic}` has nothing in front of it");
            self.fault(Code::NoRung, mnemonic, message, "begin the rung with a contact such as LD");
            return;
        }
        let rising = mnemonic.ends_with('P');
        // What is remembered: whether a master control that is off turns the result off here is not known.
        let result = match (mnemonic, self.is_held()) {
            ("INV", _) | (_, false) => Logic::Condition,
            _ => self.maybe_held_off(),
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

impl Emitter<'_> {
    /// The result, of which it is not known whether master control regions that are off hold it off.
    fn maybe_held_off(&mut self) -> Logic {
        let within = self.memory();
        let acts = Step::Act { fires: Logic::Const(true) };
        self.add(None, vec![remember(within, Logic::Condition)], acts);
        let on = Logic::Any(vec![Logic::cell(within), self.free_bit()]);
        Logic::All(vec![Logic::Condition, on])
    }
}

impl Emitter<'_> {
    /// Where an instruction fires: on its condition, or if it is pulsed, on the rising edge of that, which is then
    /// remembered among the effects.
    pub(super) fn fires(&mut self, pulsed: bool, effects: &mut Vec<Effect>) -> Logic {
        if !pulsed {
            return Logic::Condition;
        }
        let memory = self.edge_memory(false);
        effects.push(remember(memory, Logic::Condition));
        edge(true, Logic::Condition, memory)
    }
}

/// Remembers a value in a hidden bit, whenever the instruction is reached.
pub(super) fn remember(memory: Cell, value: Logic) -> Effect {
    always(Write::Bit(BitTarget::Cell(memory), value))
}

fn stack_key(mnemonic: &str) -> TimingKey {
    timing(mnemonic, false, None, "stack", Units::None, true)
}

/// A device operand's letters, for rows such as `OUT:T`.
pub(super) fn letters(operand: Option<&String>) -> Cow<'_, str> {
    let text = operand.map_or("", String::as_str);
    upper(&text[..text.bytes().take_while(u8::is_ascii_alphabetic).count()])
}

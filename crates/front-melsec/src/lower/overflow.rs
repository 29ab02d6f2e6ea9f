//! Addition and subtraction on the FX and FX5, which do not wrap around on overflow.

use super::access::WordPlace;
use super::state::{Lowering, OverflowHavoc};
use crate::catalog::{Entry, InstructionEffect};
use crate::memory::Family;
use scanbound_front::builder::{always, fired};
use scanbound_ir::{
    BitTarget, Compare, Effect, Logic, Number, NumberFormat, Region, Relation, Step, WordSource,
    WordTarget, Write,
};

impl Lowering<'_> {
    /// Whether the result of the instruction is unknown if it overflows: ADD and SUB of the FX and FX5. The FX stores
    /// part of the carry, with the sign of the exceeded limit (FX programming manual, 5-25); no manual page was found
    /// for the FX5. INC and DEC wrap around, so they do not count.
    pub(super) fn has_unknown_overflow(&self, entry: &Entry) -> bool {
        let name = entry.mnemonic.strip_suffix("_U").unwrap_or(&entry.mnemonic);
        matches!(self.family, Family::Fx | Family::Fx5)
            && matches!(name.strip_prefix('D').unwrap_or(name), "ADD" | "SUB")
    }

    /// The effects of the addition or subtraction of `a` and `b`, written to the operand `text`: the result as if it
    /// wrapped around, and a hidden bit that says whether it overflowed. [`Lowering::havoc_on_overflow`] then adds what
    /// happens on overflow. `None` after an error that was reported.
    pub(super) fn effects_with_overflow(
        &mut self,
        text: &str,
        entry: &Entry,
        (a, b): (Number, Number),
        words: usize,
    ) -> Option<Vec<Effect>> {
        let is_sum = entry.meaning == InstructionEffect::Add;
        let (left, right) = (Box::new(a.clone()), Box::new(b.clone()));
        let result = if is_sum { Number::Add(left, right) } else { Number::Sub(left, right) };
        let targets = match self.word_place(text, words)? {
            WordPlace::All(targets) => targets,
            // The written cells are unknown, so their values are too.
            WordPlace::Somewhere(region) => {
                return Some(vec![fired(Write::Havoc(region, self.choice()))]);
            }
            WordPlace::Nowhere => return Some(Vec::new()),
        };
        let is_unsigned = entry.mnemonic.ends_with("_U");
        let overflow = overflow(&result, (&a, &b), is_sum, is_unsigned, words);
        let cell = self.memory();
        let regions = targets.iter().filter_map(region).collect();
        self.current.on_overflow = Some(OverflowHavoc { overflow: cell, regions });
        self.approximate(format!(
            "on overflow, everything that {} writes may have any value",
            entry.mnemonic
        ));
        Some(vec![
            always(Write::Bit(BitTarget::Cell(cell), Logic::Const(false))),
            fired(Write::Bit(BitTarget::Cell(cell), overflow)),
            fired(Write::Words(targets, result)),
        ])
    }

    /// Adds an instruction, without a time, that lets the cells that the current instruction wrote have any value if it
    /// has overflowed. Does nothing for instructions that cannot overflow.
    pub(super) fn havoc_on_overflow(&mut self) {
        let Some(effects_with_overflow) = self.current.on_overflow.take() else { return };
        let mut effects = Vec::new();
        for region in effects_with_overflow.regions {
            effects.push(fired(Write::Havoc(region, self.choice())));
        }
        self.add(None, effects, Step::Act { fires: Logic::cell(effects_with_overflow.overflow) });
    }
}

/// The condition under which a wrapped-around sum or difference of `a` and `b` exceeded a limit: for example, adding a
/// positive number made it smaller.
fn overflow(
    result: &Number,
    (a, b): (&Number, &Number),
    is_sum: bool,
    is_unsigned: bool,
    words: usize,
) -> Logic {
    let format = if is_unsigned { NumberFormat::Unsigned } else { NumberFormat::Signed };
    let is = |relation, left: &Number, right: &Number| {
        let (left, right) = (left.clone(), right.clone());
        Logic::Compare(Box::new(Compare { relation, format, left, right }))
    };
    let (shrinks, grows) = (is(Relation::Less, result, a), is(Relation::Greater, result, a));
    if is_unsigned {
        return if is_sum { shrinks } else { grows };
    }
    let negative = is(Relation::Less, b, &Number::Words(vec![WordSource::Const(0); words]));
    let (up, down) = if is_sum { (shrinks, grows) } else { (grows, shrinks) };
    Logic::Any(vec![Logic::All(vec![negative.clone().not(), up]), Logic::All(vec![negative, down])])
}

/// The cells of a write's target. `None` if the value is discarded.
fn region(target: &WordTarget) -> Option<Region> {
    match *target {
        WordTarget::Cell(first) => Some(Region::Range { first, count: 1 }),
        WordTarget::Bits { first, count } => Some(Region::Range { first, count: u32::from(count) }),
        WordTarget::Discard => None,
    }
}

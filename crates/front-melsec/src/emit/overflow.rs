//! Sums and differences of the FX and FX5, which do not wrap around at their limits.

use super::Emitter;
use super::access::WordPlace;
use crate::catalog::{Entry, Operation};
use crate::memory::Family;
use scanbound_front::builder::{always, fired};
use scanbound_ir::{
    BitTarget, Cell, Compare, Effect, Logic, Number, NumberFormat, Region, Relation, Step,
    WordSource, WordTarget, Write,
};

/// Regions that are havocked behind an instruction if this bit, that it overflowed, is true.
pub(super) struct OverflowHavoc {
    overflow: Cell,
    regions: Vec<Region>,
}

impl Emitter<'_> {
    /// Whether what is stored on overflow is not known: the FX stores a part of the carry, with the sign of the limit
    /// that is passed (FX programming manual, 5-25); of the FX5 no page was found. Only what these families have in
    /// common with no other is meant: INC and DEC wrap around.
    pub(super) fn overflows_oddly(&self, entry: &Entry) -> bool {
        let name = entry.mnemonic.strip_suffix("_U").unwrap_or(&entry.mnemonic);
        matches!(self.family, Family::Fx | Family::Fx5)
            && matches!(name.strip_prefix('D').unwrap_or(name), "ADD" | "SUB")
    }

    /// The effects of a sum or difference that is any value where it overflows.
    pub(super) fn overflowing(
        &mut self,
        text: &str,
        entry: &Entry,
        (a, b): (Number, Number),
        words: usize,
    ) -> Option<Vec<Effect>> {
        let is_sum = entry.meaning == Operation::Add;
        let (left, right) = (Box::new(a.clone()), Box::new(b.clone()));
        let result = if is_sum { Number::Add(left, right) } else { Number::Sub(left, right) };
        let targets = match self.word_place(text, words)? {
            WordPlace::All(targets) => targets,
            // Which cells are written is not known, so nor are their values.
            WordPlace::Somewhere(region) => {
                return Some(vec![fired(Write::Havoc(region, self.choice()))]);
            }
            WordPlace::Nowhere => return Some(Vec::new()),
        };
        let is_unsigned = entry.mnemonic.ends_with("_U");
        let overflow = overflow(&result, (&a, &b), is_sum, is_unsigned, words);
        let cell = self.memory();
        let regions = targets.iter().filter_map(region).collect();
        self.now.on_overflow = Some(OverflowHavoc { overflow: cell, regions });
        self.approximate(format!(
            "on overflow what {} writes is taken as any value",
            entry.mnemonic
        ));
        Some(vec![
            always(Write::Bit(BitTarget::Cell(cell), Logic::Const(false))),
            fired(Write::Bit(BitTarget::Cell(cell), overflow)),
            fired(Write::Words(targets, result)),
        ])
    }

    /// Adds, behind an instruction that may have overflowed, the havoc of what it wrote.
    pub(super) fn havoc_on_overflow(&mut self) {
        let Some(overflowing) = self.now.on_overflow.take() else { return };
        let mut effects = Vec::new();
        for region in overflowing.regions {
            effects.push(fired(Write::Havoc(region, self.choice())));
        }
        self.add(None, effects, Step::Act { fires: Logic::cell(overflowing.overflow) });
    }
}

/// Whether a result that wraps around has passed a limit: a sum that grows becomes smaller, and so on.
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

/// The cells of a target.
fn region(target: &WordTarget) -> Option<Region> {
    match *target {
        WordTarget::Cell(first) => Some(Region::Range { first, count: 1 }),
        WordTarget::Bits { first, count } => Some(Region::Range { first, count: u32::from(count) }),
        WordTarget::Discard => None,
    }
}

//! A limit on the number of cells that a program lists individually, for block writes and for the operands of
//! operations, because a few lines of source can write millions of cells. The limit is far above what real programs
//! need. Beyond it, block writes become havocs of regions, and choices lose their operations.

use super::flow::written_by;
use super::meaning::{Meaning, OperationInput, Target};
use super::{ChoiceId, Effect, Region, Write};

/// The largest number of cells that the instructions of a program may list together.
const MAX_CELLS: usize = 2_000_000;
/// The effects of an instruction with at most this many cells are neither counted nor replaced.
const FEW: usize = 16;
/// The number of cells as which each of these counts: an operation, besides its operands; an operand or result whose
/// address is computed; an operand that is a Boolean expression.
const KNOWN: usize = 12;

/// The number of cells that a program has listed so far.
#[derive(Debug, Default)]
pub struct CellBudget {
    cells: usize,
}

impl CellBudget {
    /// Whether effects on this many more cells are kept: they fit within the limit, or are so few that they are not
    /// counted.
    #[must_use]
    pub fn has_room(&self, cells: usize) -> bool {
        cells <= FEW || self.cells + cells <= MAX_CELLS
    }

    /// Adds the cells of an instruction's effects to those listed so far, if they fit within the limit. Effects on few
    /// cells are not counted. If they do not fit, replaces the effects by havocs of everything that they write, with
    /// new choices from `choice`. Returns whether they fit.
    pub fn effects(
        &mut self,
        effects: &mut Vec<Effect>,
        mut choice: impl FnMut() -> ChoiceId,
    ) -> bool {
        let cells = effects.iter().map(|effect| cells(&effect.write)).sum();
        if cells <= FEW {
            return true;
        }
        if self.has_room(cells) {
            self.cells += cells;
            return true;
        }
        let mut wide: Vec<Effect> = Vec::new();
        // Adjacent writes become one havoc. Existing havocs are kept, because their choice identifies the operation.
        let mut ours = false;
        for effect in std::mem::take(effects) {
            if let Write::Havoc(..) = effect.write {
                wide.push(effect);
                ours = false;
                continue;
            }
            for region in written_by(&effect.write) {
                let next_to = match wide.last_mut() {
                    Some(Effect { when, write: Write::Havoc(before, _) }) => {
                        ours && *when == effect.when && merge(before, region)
                    }
                    _ => false,
                };
                if !next_to {
                    let write = Write::Havoc(region, choice());
                    wide.push(Effect { when: effect.when, write });
                    ours = true;
                }
            }
        }
        *effects = wide;
        false
    }

    /// Adds the cells of an operation to those listed so far, if they fit within the limit. Returns whether they fit.
    pub fn meaning(&mut self, meaning: &Meaning) -> bool {
        let inputs = meaning.inputs.iter().map(|input| match input {
            OperationInput::Words(words) => words.len(),
            OperationInput::Bits(bits) => bits.len(),
            OperationInput::Number(number) => number.words().count(),
            OperationInput::Truth(_) | OperationInput::Run(..) => KNOWN,
        });
        let outputs = meaning.outputs.iter().map(|output| match output {
            Target::Words(words) => words.len(),
            Target::Bits(bits) => bits.len(),
            Target::Run(..) => KNOWN,
            Target::Nowhere => 1,
        });
        let cells = inputs.chain(outputs).sum::<usize>() + KNOWN;
        let room = self.cells + cells <= MAX_CELLS;
        if room {
            self.cells += cells;
        }
        room
    }
}

/// The number of cells that a write lists as targets and sources. A havoc counts as 1.
fn cells(write: &Write) -> usize {
    match write {
        Write::Bit(..) => 2,
        Write::Words(targets, number) => targets.len() + number.words().count(),
        Write::Havoc(..) => 1,
    }
}

/// Merges range `more` into range `before` if they overlap or touch. Returns whether they were merged; never if one is
/// a whole area.
fn merge(before: &mut Region, more: Region) -> bool {
    let (Region::Range { first, count }, Region::Range { first: other, count: many }) =
        (&mut *before, more)
    else {
        return false;
    };
    if first.area != other.area {
        return false;
    }
    let (from, to) = (first.index.min(other.index), (first.index + *count).max(other.index + many));
    let fits = to - from <= *count + many;
    if fits {
        (first.index, *count) = (from, to - from);
    }
    fits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AreaId, BitTarget, Cell, Logic, When, WordSource, WordTarget};

    fn cell(index: u32) -> Cell {
        Cell { area: AreaId(0), index }
    }

    fn copy(count: u32) -> Effect {
        let targets = (0..count).map(|n| WordTarget::Cell(cell(n))).collect();
        let words = (0..count).map(|n| WordSource::Cell(cell(1000 + n))).collect();
        Effect { when: When::Fired, write: Write::Words(targets, crate::Number::Words(words)) }
    }

    #[test]
    fn what_has_no_room_is_any_value_in_as_few_regions_as_it_takes() {
        let mut budget = CellBudget { cells: MAX_CELLS - 100 };
        let mut fresh = 0;
        let mut choice = || {
            fresh += 1;
            ChoiceId(fresh)
        };
        let mut effects = vec![copy(50)];
        assert!(budget.effects(&mut effects, &mut choice));
        assert_eq!(effects, [copy(50)]);
        let bit = |n: u8| Effect {
            when: When::Always,
            write: Write::Bit(BitTarget::WordBit(cell(70), n), Logic::Const(true)),
        };
        let mut effects = vec![copy(50), bit(1), bit(0), copy(1)];
        assert!(!budget.effects(&mut effects, &mut choice));
        let havocs = |when, first, count, choice| Effect {
            when,
            write: Write::Havoc(Region::Range { first: cell(first), count }, ChoiceId(choice)),
        };
        let expected = [
            havocs(When::Fired, 0, 50, 1),
            havocs(When::Always, 70, 1, 2),
            havocs(When::Fired, 0, 1, 3),
        ];
        assert_eq!(effects, expected);
        let mut few = vec![copy(8)];
        assert!(budget.effects(&mut few, &mut choice) && few == [copy(8)]);
    }
}

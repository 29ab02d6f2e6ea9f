//! A limit on how many cells a program lists one by one, for blocks that are written and for how results are worked out:
//! a few lines of source can write millions. The limit is far above what a plant's program needs. Beyond it, blocks are
//! havocked as regions, and how their values are worked out is not kept.

use super::flow::written_by;
use super::meaning::{Meaning, Operand, Target};
use super::{ChoiceId, Effect, Number, Region, Write};

/// The most cells that a program may list.
const MOST: usize = 2_000_000;
/// An instruction with no more cells than this may list them always.
const FEW: usize = 16;
/// What a `Meaning` takes besides its cells, counted in cells.
const KNOWN: usize = 12;

/// How many cells a program has listed so far.
#[derive(Debug, Default)]
pub struct CellBudget {
    cells: usize,
}

impl CellBudget {
    /// Whether there is room for so many cells.
    #[must_use]
    pub fn has_room(&self, cells: usize) -> bool {
        cells <= FEW || self.cells + cells <= MOST
    }

    /// Leaves an instruction's effects as they are if there is room for them, else havocs all that they write. Whether
    /// they were left.
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
        // Neighbouring writes become one havoc; havocs that were there stay, since an operation is known by its choice.
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
                        ours && *when == effect.when && joined(before, region)
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

    /// Whether there is room to keep how results are worked out; if so, it is taken.
    pub fn meaning(&mut self, meaning: &Meaning) -> bool {
        let inputs = meaning.inputs.iter().map(|input| match input {
            Operand::Words(words) => words.len(),
            Operand::Bits(bits) => bits.len(),
            Operand::Number(number) => words(number),
            Operand::Truth(_) | Operand::Run(..) => KNOWN,
        });
        let outputs = meaning.outputs.iter().map(|output| match output {
            Target::Words(words) => words.len(),
            Target::Bits(bits) => bits.len(),
            Target::Run(..) => KNOWN,
            Target::Nowhere => 1,
        });
        let cells = inputs.chain(outputs).sum::<usize>() + KNOWN;
        let room = self.cells + cells <= MOST;
        if room {
            self.cells += cells;
        }
        room
    }
}

/// How many cells a write names, those that it reads included.
fn cells(write: &Write) -> usize {
    match write {
        Write::Bit(..) => 2,
        Write::Words(targets, number) => targets.len() + words(number),
        Write::Havoc(..) => 1,
    }
}

fn words(number: &Number) -> usize {
    match number {
        Number::Words(words) => words.len(),
        Number::Add(a, b)
        | Number::Sub(a, b)
        | Number::And(a, b)
        | Number::Or(a, b)
        | Number::Xor(a, b) => words(a) + words(b),
    }
}

/// Joins a region to one that it lies in, or is next to.
fn joined(before: &mut Region, more: Region) -> bool {
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
        Effect { when: When::Fired, write: Write::Words(targets, Number::Words(words)) }
    }

    #[test]
    fn what_has_no_room_is_any_value_in_as_few_regions_as_it_takes() {
        let mut budget = CellBudget { cells: MOST - 100 };
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

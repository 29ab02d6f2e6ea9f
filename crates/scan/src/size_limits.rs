//! Keeps the model of a scan within size limits: where single instructions make it too large, the values that they read
//! are replaced by any values.

use super::scan_model_within;
use super::settings::ScanError;
pub use super::settings::SizeLimits;
use scanbound_base::time::Times;
use scanbound_ir::{
    Approximated, BitSource, BitTarget, ChoiceId, Program, Region, SourceMut, Step, WordSource,
    Write,
};
use scanbound_model::ScanModel;
use std::collections::BTreeSet;

/// The values of [`SizeLimits::per_execution`] that are tried in this order until the model fits.
const PER_EXECUTION: [usize; 5] = [1 << 15, 1 << 11, 1 << 7, 1 << 5, 8];

/// The number of times that one limit is tried. After the inputs of costly instructions became any values, others may
/// cost more or less.
const ROUNDS: usize = 3;

/// Executes one scan symbolically into a model for upper bounds, of size [`SizeLimits::in_all`] at most. If single
/// instructions make it too large, `program` is changed: what they read becomes any values, and this is recorded as
/// over-approximation. `None` if the model is still too large.
///
/// # Errors
/// If `is_over` stopped the execution, there are too many executions, a time overflows, or the program is not well
/// formed.
pub fn scan_model_fitted(
    program: &mut Program,
    times: &[Times],
    in_all: usize,
    is_over: &dyn Fn() -> bool,
) -> Result<Option<ScanModel>, ScanError> {
    for per_execution in PER_EXECUTION {
        for _ in 0..ROUNDS {
            match scan_model_within(program, times, &SizeLimits { per_execution, in_all, is_over })
            {
                Ok(model) => return Ok(Some(model)),
                Err(ScanError::TooLarge { costly, .. }) => {
                    if !widen(program, &costly) {
                        break;
                    }
                }
                Err(other) => return Err(other),
            }
        }
    }
    Ok(None)
}

/// Replaces everything that these instructions read, and the words of which they write a bit, by any values, and no
/// longer follows their operations. Returns whether anything was replaced.
fn widen(program: &mut Program, costly: &BTreeSet<usize>) -> bool {
    let mut choices = program.choices;
    let mut choice = || {
        choices += 1;
        ChoiceId(choices - 1)
    };
    let mut wide = Vec::new();
    for &at in costly {
        let instruction = &mut program.instructions[at];
        let mut read = false;
        instruction.each_read_mut(&mut |source| match source {
            SourceMut::Bit(source @ (BitSource::Cell(_) | BitSource::WordBit(..))) => {
                (*source, read) = (BitSource::Free(choice()), true);
            }
            SourceMut::Word(source @ (WordSource::Cell(_) | WordSource::Bits { .. })) => {
                (*source, read) = (WordSource::Free(choice()), true);
            }
            SourceMut::Bit(_) | SourceMut::Word(_) => {}
        });
        for effect in &mut instruction.effects {
            if let Write::Bit(BitTarget::WordBit(first, _), _) = effect.write {
                effect.write = Write::Havoc(Region::Range { first, count: 1 }, choice());
                read = true;
            }
        }
        if read {
            wide.push((
                at,
                match instruction.step {
                    Step::ForBegin { .. } => Approximated::CostlyCount,
                    _ => Approximated::CostlyRead,
                },
            ));
        }
    }
    program.choices = choices;
    // The results of operations that the analysis follows can also be too large, so they become any values too.
    for &at in costly {
        let havocked = program.instructions[at].effects.iter().filter_map(|effect| {
            let Write::Havoc(_, choice) = effect.write else { return None };
            Some(choice)
        });
        let followed: Vec<ChoiceId> =
            havocked.filter(|choice| program.always_followed.contains(choice)).collect();
        for choice in followed {
            program.always_followed.remove(&choice);
            wide.push((at, Approximated::CostlyRead));
        }
    }
    let any = !wide.is_empty();
    wide.into_iter().for_each(|(at, what)| program.approximate(at, what));
    any
}

//! How far a scan is followed: what its model may take, and what is given up where it takes more.

use super::{ScanError, scan_model_within};
use crate::base::time::Times;
use crate::program::{
    Approximated, BitSource, BitTarget, ChoiceId, Program, Region, SourceMut, Step, WordSource,
    Write,
};
use crate::scan::model::ScanModel;
use std::collections::BTreeSet;

/// What following a scan may take, counted in nodes of the circuit and questions to words.
pub struct Reach<'a> {
    /// One execution of one instruction.
    pub once: usize,
    /// All together.
    pub all: usize,
    /// Asked now and then; true ends it.
    pub ended: &'a dyn Fn() -> bool,
}

impl Default for Reach<'_> {
    /// No limit.
    fn default() -> Self {
        Reach { once: usize::MAX, all: usize::MAX, ended: &|| false }
    }
}

/// What a single instruction may take, one try after the other.
const ONCE: [usize; 5] = [1 << 15, 1 << 11, 1 << 7, 1 << 5, 8];

/// How many times instructions that take too much are sought before the next try.
const ROUNDS: usize = 3;

/// Executes one scan symbolically, within what its model may take: where single instructions take much, what they
/// read is taken as any value, and that is listed as an approximation. `None` if that does not suffice.
///
/// # Errors
/// If it is ended, or the program is not well formed.
pub fn scan_model_fitted(
    program: &mut Program,
    times: &[Times],
    all: usize,
    ended: &dyn Fn() -> bool,
) -> Result<Option<ScanModel>, ScanError> {
    for once in ONCE {
        for _ in 0..ROUNDS {
            match scan_model_within(program, times, &Reach { once, all, ended }) {
                Ok(model) => return Ok(Some(model)),
                Err(ScanError::Grown { dear, .. }) => {
                    if !widen(program, &dear) {
                        break;
                    }
                }
                Err(other) => return Err(other),
            }
        }
    }
    Ok(None)
}

/// Takes all that these instructions read, and words of which they write a bit, as any value. Whether any of them
/// read anything.
fn widen(program: &mut Program, dear: &BTreeSet<usize>) -> bool {
    let mut choices = program.choices;
    let mut choice = || {
        choices += 1;
        ChoiceId(choices - 1)
    };
    let mut wide = Vec::new();
    for &at in dear {
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
                    Step::ForBegin { .. } => Approximated::DearCount,
                    _ => Approximated::DearRead,
                },
            ));
        }
    }
    program.choices = choices;
    let any = !wide.is_empty();
    wide.into_iter().for_each(|(at, what)| program.approximate(at, what));
    any
}

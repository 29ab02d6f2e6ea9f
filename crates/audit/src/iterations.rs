//! The largest number of iterations of loops that the model does not follow (loop summaries), from what the model knows
//! about their counts.

use scanbound_base::time::Picos;
use scanbound_model::groups;
use scanbound_model::{Assignment, Charge, LoopCount, ScanModel};
use scanbound_solve::{Limits, Method, maximum};
use std::collections::BTreeMap;

/// If control may reach loops that the model does not follow at more places than this, counted once for each call
/// context, no solver is asked.
const MAX_ASKED: usize = 16;

/// The largest number of iterations of each loop that the model does not follow, by the loop's instruction: the one
/// that the model derived from the form of its count, or a smaller one that the search proves.
pub fn most_iterations(model: &ScanModel, limits: &Limits<'_>) -> BTreeMap<usize, u32> {
    let mut iterations = model.iterations.clone();
    let mut asked: BTreeMap<usize, u32> = BTreeMap::new();
    if model.loop_counts.len() <= MAX_ASKED {
        for count in &model.loop_counts {
            let most = largest(model, count, limits).max(count.least);
            let known = asked.entry(count.instruction).or_default();
            *known = most.max(*known);
        }
    }
    for (instruction, most) in asked {
        iterations.entry(instruction).and_modify(|known| *known = most.min(*known));
    }
    iterations
}

/// An upper bound on the values, not negative, that a count can have when control reaches its loop. 0 if there is none.
///
/// The solver finds it in the same way as a longest scan: each bit of the count is charged with its value, so the
/// longest scan has the largest count.
fn largest(model: &ScanModel, count: &LoopCount, limits: &Limits<'_>) -> u32 {
    let mut bare = ScanModel { charges: Vec::new(), ..model.clone() };
    let (&sign, digits) = count.bits.split_last().expect("a word has bits");
    let there = bare.circuit.and(count.reached, !sign);
    for (place, &bit) in digits.iter().enumerate() {
        let fires = bare.circuit.and(there, bit);
        bare.charges.push(Charge {
            instruction: 0,
            frames: Vec::new(),
            reached: fires,
            fires,
            on: Picos(1 << place),
            off: Picos::ZERO,
            counted: None,
        });
    }
    let zeros = Assignment(vec![0; bare.variables.len()]);
    let always = bare.cost(&bare.constant_charges(), &zeros);
    let found = groups::groups(&bare)
        .iter()
        .map(|group| maximum(&bare, group, Method::Cores, limits).upper)
        .sum::<Picos>();
    u32::try_from((always + found).0).unwrap_or(u32::MAX)
}

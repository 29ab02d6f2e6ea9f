//! A group's charges by rung: the time of each rung, and which of its charges is furthest below its largest time.

use super::{ChargeUse, Fate, RungUse};
use scanbound_base::time::Picos;
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// A rung for the report, and which of its charges is furthest below its larger time.
pub struct RungCharges {
    pub shown: RungUse,
    /// The charge that is furthest below the larger of its two times, as an index into the group's charges. `None` if
    /// all take their larger time.
    pub shortest: Option<usize>,
}

/// The rungs of these charges, the one with the longest possible time first. `comments` gives the comments of a
/// charge's operands.
pub fn rungs(charges: &[ChargeUse], comments: impl Fn(usize) -> Vec<String>) -> Vec<RungCharges> {
    let mut by_block: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (index, charge) in charges.iter().enumerate() {
        by_block.entry(charge.block).or_default().push(index);
    }
    let mut rungs: Vec<RungCharges> = by_block
        .into_iter()
        .filter_map(|(block, members)| rung(block, &members, charges, &comments))
        .collect();
    rungs.sort_by_key(|rung| (Reverse(rung.shown.naive), rung.shown.block));
    rungs
}

/// The rung made of these charges. `None` if there are none.
fn rung(
    block: u32,
    members: &[usize],
    charges: &[ChargeUse],
    comments: impl Fn(usize) -> Vec<String>,
) -> Option<RungCharges> {
    let larger_time = |index: usize| charges[index].on.max(charges[index].off);
    let short =
        |index: usize| larger_time(index).checked_sub(charges[index].share).unwrap_or_default();
    let largest = members.iter().copied().rev().max_by_key(|&index| larger_time(index))?;
    let shown = &charges[largest];
    let full = members.iter().filter(|&&index| short(index) == Picos::ZERO).count();
    let shortest = members.iter().copied().rev().max_by_key(|&index| short(index));
    Some(RungCharges {
        shown: RungUse {
            block,
            at: shown.at,
            instruction: shown.instruction.clone(),
            comments: comments(largest),
            others: members.len() - 1,
            fate: match full {
                0 => Fate::Excluded,
                n if n == members.len() => Fate::Runs,
                _ => Fate::Partly,
            },
            is_charged_off: !shown.runs && shown.share > Picos::ZERO,
            cost: members.iter().map(|&index| charges[index].share).sum(),
            naive: members.iter().map(|&index| larger_time(index)).sum(),
            exclusion: None,
        },
        shortest: shortest.filter(|&index| short(index) > Picos::ZERO),
    })
}

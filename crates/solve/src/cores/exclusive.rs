//! Combines guards that exclude each other by their structure, before any search.
//!
//! A table search stops at its first match, and a step is left before the next is tested: there each guard contains the
//! negation of the earlier ones. At most one of these guards is true, so together they cost at most the largest weight.
//! Without this preparation, every two of them are a core that the solver has to find. Combined they are a staircase:
//! the lightest weight is paid if any of them is true, the difference to the next weight if any but the lightest is
//! true, and so on.

use crate::problem::{Item, Problem};
use rustc_hash::{FxHashMap, FxHashSet};
use scanbound_model::{Circuit, Lit, Node};
use std::cmp::Reverse;

/// The largest number of conjuncts of a guard that are examined.
const MAX_PARTS: usize = 4096;
/// A literal that occurs in more than about this many guards is not examined, because it does not belong to one
/// iteration or step.
const FEW: usize = 16;
/// The largest number of conjuncts of all guards together that are examined.
const MAX_GUARD_PARTS: usize = 25_000_000;

/// A problem whose mutually exclusive guards are combined. It has the same variables as the original, and the same cost
/// under every assignment. Its circuit is the original one followed by the staircases.
pub struct Merged {
    /// The problem in which the items are combined.
    pub problem: Problem,
    /// For each item, the index of the original item. `None` if several items were combined.
    pub origins: Vec<Option<usize>>,
    /// The original items that were combined, and the weight that this saves.
    pub taken: Vec<(Vec<usize>, u64)>,
}

/// Combines the items that exclude each other by their structure: one's guard contains a literal as a conjunct, the
/// other's its negation.
pub fn merge(original: &Problem) -> Merged {
    let together = together(original);
    let mut member: FxHashMap<usize, usize> = FxHashMap::default();
    for (number, items) in together.iter().enumerate() {
        member.extend(items.iter().map(|&item| (item, number)));
    }
    let mut merged = Merged {
        problem: Problem { items: Vec::with_capacity(original.items.len()), ..original.clone() },
        origins: Vec::with_capacity(original.items.len()),
        taken: Vec::with_capacity(together.len()),
    };
    for (place, item) in original.items.iter().enumerate() {
        match member.get(&place) {
            None => merged.push(item.clone(), Some(place)),
            Some(&number) if together[number].last() == Some(&place) => {
                merged.staircase(original, &together[number]);
            }
            Some(_) => {}
        }
    }
    merged
}

impl Merged {
    fn push(&mut self, item: Item, origin: Option<usize>) {
        self.problem.items.push(item);
        self.origins.push(origin);
    }

    fn staircase(&mut self, original: &Problem, items: &[usize]) {
        let mut down: Vec<&Item> = items.iter().map(|&item| &original.items[item]).collect();
        down.sort_by_key(|item| Reverse(item.weight));
        let (mut any, mut charges) = (Lit::FALSE, Vec::new());
        for (place, item) in down.iter().enumerate() {
            any = self.problem.circuit.or(any, item.guard);
            charges.extend_from_slice(&item.charges);
            let weight = item.weight - down.get(place + 1).map_or(0, |next| next.weight);
            if weight == 0 {
                continue;
            }
            if any == Lit::TRUE {
                self.problem.constant += weight;
                continue;
            }
            let mut charges = charges.clone();
            charges.sort_unstable();
            charges.dedup();
            self.push(Item { guard: any, weight, charges }, None);
        }
        let off = down.iter().skip(1).map(|item| item.weight).sum();
        self.taken.push((items.to_vec(), off));
    }
}

/// Disjoint sets of at least two items (indices, ascending), each of mutually exclusive items.
fn together(problem: &Problem) -> Vec<Vec<usize>> {
    // For each literal, the guards that contain it. Literals in too many guards are left to the search.
    let mut saying: FxHashMap<Lit, Vec<usize>> = FxHashMap::default();
    let mut parts = Parts::of(&problem.circuit);
    // A set has one item until a second one is found.
    let mut sets: Vec<Vec<usize>> = Vec::with_capacity(problem.items.len());
    let mut set_of: Vec<usize> = Vec::with_capacity(problem.items.len());
    let mut others: FxHashSet<usize> = FxHashSet::default();
    let mut guard_parts: Vec<Lit> = Vec::new();
    for (place, item) in problem.items.iter().enumerate() {
        others.clear();
        guard_parts.clear();
        parts.each(item.guard, |part| guard_parts.push(part));
        for &part in &guard_parts {
            let opposite = saying.get(&!part).map_or(&[][..], Vec::as_slice);
            others.extend(opposite.iter().filter(|_| opposite.len() <= FEW));
        }
        let mut excluded: FxHashMap<usize, usize> = FxHashMap::default();
        others.iter().for_each(|&other| *excluded.entry(set_of[other]).or_default() += 1);
        for &part in &guard_parts {
            let saying = saying.entry(part).or_default();
            if saying.len() <= FEW {
                saying.push(place);
            }
        }
        let whole = excluded.iter().filter(|&(&set, &count)| sets[set].len() == count);
        let largest = whole.map(|(&set, &count)| (count, Reverse(set))).max();
        let set = match largest {
            Some((_, Reverse(set))) => set,
            None => {
                sets.push(Vec::new());
                sets.len() - 1
            }
        };
        sets[set].push(place);
        set_of.push(set);
    }
    sets.retain(|set| set.len() > 1);
    sets
}

/// Enumerates the conjuncts of guards, each once for each guard.
struct Parts<'a> {
    circuit: &'a Circuit,
    /// For each node: the last guard for which the node was examined.
    seen: Vec<u32>,
    guards: u32,
    looked: usize,
}

impl<'a> Parts<'a> {
    fn of(circuit: &'a Circuit) -> Parts<'a> {
        Parts { circuit, seen: vec![0; circuit.nodes().len()], guards: 0, looked: 0 }
    }

    /// Calls `see` once with the guard and with each conjunct of it, down to the inputs; fewer beyond the limits.
    fn each(&mut self, guard: Lit, mut see: impl FnMut(Lit)) {
        self.guards += 1;
        let mut open = vec![guard];
        let mut left = MAX_PARTS.min(MAX_GUARD_PARTS.saturating_sub(self.looked));
        while let Some(part) = open.pop() {
            if left == 0 {
                return;
            }
            if std::mem::replace(&mut self.seen[part.node()], self.guards) == self.guards {
                continue;
            }
            left -= 1;
            self.looked += 1;
            see(part);
            if let (false, Node::And(a, b)) = (part.is_negated(), self.circuit.nodes()[part.node()])
            {
                open.extend([a, b]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Builder, random};
    use scanbound_model::{Assignment, Atom, VarId};

    fn item(guard: Lit, weight: u64) -> Item {
        Item { guard, weight, charges: vec![weight as usize] }
    }

    #[test]
    fn the_first_find_of_a_search_is_a_staircase() {
        let mut problem = Problem::default();
        let bits: Vec<Lit> = (0..5).map(|n| problem.circuit.atom(Atom::Bit(VarId(n)))).collect();
        let mut found = Lit::FALSE;
        for (&bit, weight) in bits.iter().zip([5, 9, 9, 2, 7]) {
            let first = problem.circuit.and(bit, !found);
            found = problem.circuit.or(found, first);
            problem.items.push(item(first, weight));
        }
        problem.variables = (0..5).map(VarId).collect();
        let merged = merge(&problem);
        assert_eq!(merged.taken, [(vec![0, 1, 2, 3, 4], 5 + 9 + 2 + 7)]);
        let weights: Vec<u64> = merged.problem.items.iter().map(|item| item.weight).collect();
        assert_eq!(weights, [2, 2, 3, 2]);
        assert_eq!(merged.problem.naive(), 9);
        for n in 0..32u16 {
            let all = Assignment((0..5).map(|bit| n >> bit & 1).collect());
            assert_eq!(merged.problem.cost(&all), problem.cost(&all), "{n}");
        }
    }

    #[test]
    fn what_is_taken_together_costs_what_it_did() {
        let mut taken = 0;
        for seed in 0..300 {
            let mut model = random(seed, 30);
            // Some guards exclude others by their structure.
            let fires: Vec<Lit> = model.charges.iter().map(|charge| charge.fires).collect();
            for (at, &own) in fires.iter().enumerate().skip(1).filter(|(at, _)| at % 3 != 0) {
                let before = model.charges[at - 1].fires;
                model.charges[at].fires = model.circuit.and(own, !before);
            }
            let group = Builder { model: model.clone() }.group();
            let problem = Problem::new(&model, &group);
            let merged = merge(&problem);
            let off: u64 = merged.taken.iter().map(|(_, off)| off).sum();
            assert_eq!(problem.naive() - off, merged.problem.naive());
            taken += merged.taken.len();
            let mut number = seed;
            for _ in 0..50 {
                number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(seed | 1);
                let value = |place: usize| (number >> (20 + place % 40)) as u16 & 7;
                let all = Assignment((0..problem.variables.len()).map(value).collect());
                assert_eq!(merged.problem.cost(&all), problem.cost(&all), "seed {seed}");
            }
        }
        assert!(taken > 100, "{taken}");
    }
}

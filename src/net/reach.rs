//! All markings that a net can reach, within a budget: which places are marked together, what is never reached, where
//! it stops.
//!
//! A place that would get a second token keeps one, as a step of a chart is active or not; the first such firing is kept
//! as evidence that the net is unsafe. Transitions fire one after the other in a plain net that is safe: what several bring
//! about at once is reached so, too. Where transitions ask for places that they do not take, they fire in sets.

use super::{Bits, Net};
use std::collections::BTreeMap;

/// Where a place would get a second token.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unsafe {
    /// The place.
    pub place: usize,
    /// The transitions that lead there from the initial marking, the one that puts the second token last.
    pub path: Vec<usize>,
}

/// A marking in which no transition can ever fire.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Deadlock {
    /// What is marked.
    pub marking: Bits,
    /// The transitions that lead there.
    pub path: Vec<usize>,
}

/// What was found of a net.
#[derive(Debug, Clone)]
pub struct Reached {
    /// How many markings were seen.
    pub markings: usize,
    /// Whether these are all.
    pub complete: bool,
    /// For each place those that are marked together with it in some marking.
    pub together: Vec<Bits>,
    /// For each place the shortest way to a marking that has it.
    first: Vec<Option<usize>>,
    /// Which transitions are enabled in some marking.
    pub enabled: Bits,
    /// Second tokens, one evidence for each place.
    pub unsafe_places: Vec<Unsafe>,
    /// Dead ends.
    pub deadlocks: Vec<Deadlock>,
    nodes: Vec<Node>,
}

#[derive(Debug, Clone)]
struct Node {
    marking: Bits,
    from: Option<(usize, Vec<usize>)>,
}

impl Reached {
    /// Whether a place is never marked; known only where the search is complete.
    #[must_use]
    pub fn is_never(&self, place: usize) -> bool {
        self.complete && self.first[place].is_none()
    }

    /// Whether the net is known to be safe: no place ever gets a second token.
    #[must_use]
    pub fn is_safe(&self) -> bool {
        self.complete && self.unsafe_places.is_empty()
    }

    /// The shortest way to a marking that has all these places.
    #[must_use]
    pub fn way_to(&self, places: &[usize]) -> Option<Vec<usize>> {
        let node =
            self.nodes.iter().position(|node| places.iter().all(|&p| node.marking.has(p)))?;
        Some(self.path(node))
    }

    /// The markings that were seen, in the order of their distance from the first.
    pub fn seen(&self) -> impl Iterator<Item = &Bits> {
        self.nodes.iter().map(|node| &node.marking)
    }

    fn path(&self, mut node: usize) -> Vec<usize> {
        let mut path = Vec::new();
        while let Some((before, set)) = &self.nodes[node].from {
            path.extend(set.iter().rev());
            node = *before;
        }
        path.reverse();
        path
    }
}

/// Follows a net from its initial marking, through at most so many markings.
#[must_use]
pub fn reach(net: &Net, budget: usize) -> Reached {
    let mut found = Reached {
        markings: 0,
        complete: true,
        together: vec![Bits::new(net.places); net.places],
        first: vec![None; net.places],
        enabled: Bits::new(net.transitions.len()),
        unsafe_places: Vec::new(),
        deadlocks: Vec::new(),
        nodes: vec![Node { marking: net.start(), from: None }],
    };
    let mut known = BTreeMap::from([(net.start(), ())]);
    let mut at = 0;
    while at < found.nodes.len() {
        let marking = found.nodes[at].marking.clone();
        for place in marking.iter() {
            found.together[place].join(&marking);
            found.first[place].get_or_insert(at);
        }
        let Some(moves) = net.moves(&marking) else {
            found.complete = false;
            at += 1;
            continue;
        };
        let is_dead = moves.is_empty();
        for set in moves {
            set.iter().for_each(|&transition| found.enabled.insert(transition));
            let (next, twice) = net.fire(&set, &marking);
            if let Some(place) = twice
                && found.unsafe_places.iter().all(|one| one.place != place)
            {
                let mut path = found.path(at);
                path.extend(&set);
                found.unsafe_places.push(Unsafe { place, path });
            }
            if known.contains_key(&next) {
                continue;
            }
            if found.nodes.len() >= budget {
                found.complete = false;
                continue;
            }
            known.insert(next.clone(), ());
            found.nodes.push(Node { marking: next, from: Some((at, set)) });
        }
        if is_dead {
            let path = found.path(at);
            found.deadlocks.push(Deadlock { marking, path });
        }
        at += 1;
    }
    found.markings = found.nodes.len();
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::net::testing::net;

    #[test]
    fn what_is_marked_together_is_found_with_a_way() {
        // 0 -> 1 and 2; 1 -> 3; 2 and 3 -> 0
        let found = reach(&net(4, &[0], &[(&[0], &[1, 2]), (&[1], &[3]), (&[2, 3], &[0])]), 100);
        assert!(found.is_safe() && found.deadlocks.is_empty());
        assert_eq!(found.markings, 3);
        assert!(found.together[2].has(1) && found.together[2].has(3) && !found.together[0].has(2));
        assert_eq!(found.way_to(&[2, 3]), Some(vec![0, 1]));
        assert_eq!(found.way_to(&[0, 1]), None);
    }

    #[test]
    fn second_tokens_dead_ends_and_places_never_reached_are_found() {
        // A selection that runs into a join: only one of 1 and 2 is ever marked.
        let stuck = reach(&net(4, &[0], &[(&[0], &[1]), (&[0], &[2]), (&[1, 2], &[3])]), 100);
        assert_eq!(
            stuck.deadlocks.iter().map(|one| one.path.clone()).collect::<Vec<_>>(),
            [[0], [1]]
        );
        assert!(stuck.is_never(3) && !stuck.enabled.has(2));
        // A parallel that is left one branch after the other.
        let twice = reach(&net(3, &[0], &[(&[0], &[1, 2]), (&[1], &[0]), (&[2], &[0])]), 100);
        assert!(!twice.is_safe());
        assert!(twice.unsafe_places.contains(&Unsafe { place: 0, path: vec![0, 1, 2] }));
    }

    #[test]
    fn transitions_that_ask_for_places_fire_in_sets() {
        // 0 -> 2 while 1 is marked, 1 -> 3 while 0 is: one after the other they could not both fire.
        let mut net = net(4, &[0, 1], &[(&[0], &[2]), (&[1], &[3])]);
        net.transitions[0].needs = vec![1];
        net.transitions[1].needs = vec![0];
        let found = reach(&net, 100);
        assert_eq!(found.way_to(&[2, 3]), Some(vec![0, 1]));
        net.transitions[1].bars = vec![0];
        assert_eq!(reach(&net, 100).way_to(&[3]), None);
    }

    #[test]
    fn a_budget_that_is_used_up_is_told() {
        let chain: Vec<(Vec<usize>, Vec<usize>)> = (0..9).map(|n| (vec![n], vec![n + 1])).collect();
        let moves: Vec<(&[usize], &[usize])> =
            chain.iter().map(|(takes, puts)| (&takes[..], &puts[..])).collect();
        let found = reach(&net(10, &[0], &moves), 5);
        assert!(!found.complete && !found.is_never(9) && found.markings == 5);
    }
}

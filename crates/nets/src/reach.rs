//! All markings that a net can reach, within a budget: which places are marked together, what is never reached, where
//! it stops.
//!
//! A place that would get a second token keeps one, as a step of a chart is active or not; the first such firing is kept
//! as evidence that the net is unsafe. Transitions fire one after the other in a plain net that is safe: what several bring
//! about at once is reached so, too. Where transitions ask for places that others of them take, they fire in sets.

use super::{Bits, Net};
use rustc_hash::{FxHashMap, FxHashSet};

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
    /// For each two places, the one with the smaller number first, the same of both.
    both: FxHashMap<(usize, usize), usize>,
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
        let node = match *places {
            [one] => self.first[one]?,
            [one, other] if one != other => *self.both.get(&(one.min(other), one.max(other)))?,
            _ => self.nodes.iter().position(|node| places.iter().all(|&p| node.marking.has(p)))?,
        };
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
        both: FxHashMap::default(),
        enabled: Bits::new(net.transitions.len()),
        unsafe_places: Vec::new(),
        deadlocks: Vec::new(),
        nodes: vec![Node { marking: net.start(), from: None }],
    };
    let firing = net.firing();
    let mut known = FxHashSet::from_iter([net.start()]);
    let mut at = 0;
    while at < found.nodes.len() {
        let marking = found.nodes[at].marking.clone();
        for place in marking.iter() {
            found.first[place].get_or_insert(at);
            if !found.together[place].has_all(&marking) {
                for other in marking.iter().filter(|other| *other > place) {
                    found.both.entry((place, other)).or_insert(at);
                }
                found.together[place].join(&marking);
            }
        }
        let Some(moves) = firing.moves(&marking) else {
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
            if known.contains(&next) {
                continue;
            }
            if found.nodes.len() >= budget {
                found.complete = false;
                continue;
            }
            known.insert(next.clone());
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
    use crate::Transition;
    use crate::testing::net;
    use std::collections::BTreeSet;

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

    /// All markings that are reached when every set of enabled transitions that take no place from each other may fire.
    fn by_sets(net: &Net) -> BTreeSet<Bits> {
        let mut known = BTreeSet::from([net.start()]);
        let mut open = vec![net.start()];
        while let Some(marking) = open.pop() {
            let all = 0..net.transitions.len();
            let enabled: Vec<usize> = all.filter(|&at| net.is_enabled(at, &marking)).collect();
            for mask in 1..1_usize << enabled.len() {
                let members = enabled.iter().enumerate().filter(|(bit, _)| mask >> bit & 1 == 1);
                let set: Vec<usize> = members.map(|(_, &at)| at).collect();
                let mut taken: Vec<usize> =
                    set.iter().flat_map(|&at| net.transitions[at].takes.clone()).collect();
                taken.sort_unstable();
                if taken.windows(2).any(|pair| pair[0] == pair[1]) {
                    continue;
                }
                let next = net.fire(&set, &marking).0;
                if known.insert(next.clone()) {
                    open.push(next);
                }
            }
        }
        known
    }

    #[test]
    fn one_after_the_other_reaches_what_sets_do() {
        let mut seed = 1_u64;
        let mut below = move |limit: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
            (seed >> 33) as usize % limit
        };
        let (mut seen, mut asking) = (0, 0);
        for _ in 0..3_000 {
            // Rings of three places with a token each, whose transitions ask for places of others.
            let rings = 2 + below(3);
            let (mut net, places) = (Net::default(), 3 * rings);
            net.places = places;
            for ring in 0..rings {
                net.initial.push(3 * ring + below(3));
                for at in 0..3 {
                    let (from, to) = (3 * ring + at, 3 * ring + (at + 1) % 3);
                    let mut one =
                        Transition { takes: vec![from], puts: vec![to], ..Transition::default() };
                    for _ in 0..below(3) {
                        let place = below(places);
                        let side = if below(2) == 0 { &mut one.needs } else { &mut one.bars };
                        side.push(place);
                    }
                    net.transitions.push(one);
                }
            }
            let found = reach(&net, 100_000);
            assert!(found.is_safe());
            let markings: BTreeSet<Bits> = found.seen().cloned().collect();
            assert_eq!(markings, by_sets(&net), "{net:?}");
            seen += usize::from(markings.len() > 3);
            asking +=
                net.transitions.iter().filter(|one| one.needs.len() + one.bars.len() > 1).count();
        }
        assert!(seen > 200 && asking > 1_000, "{seen} {asking}");
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

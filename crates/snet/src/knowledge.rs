//! Finds sets of a net's boxes and transitions whose relays are never all on at the end of a scan.
//!
//! These are only candidates: an audit that uses one proves it on the code itself.

use super::check::{sets, structure};
use super::rules::Rules;
use super::translate::{Operand, Spelling};
use super::{Diagram, Kind};
use scanbound_nets::Bits;
use scanbound_nets::relays::{self, Element, Relays};
use scanbound_nets::search::search;
use std::collections::BTreeSet;

/// The largest number of states and scans of the code that are explored.
const STATES: usize = 20_000;
const SCANS: usize = 200_000;
/// The largest number of places for which sets of three are searched.
const MAX_PLACES: usize = 40;
/// The largest number of sets in the result; those of places come first.
const MAX_SETS: usize = 20_000;

/// What the net suggests about its code's relays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Knowledge {
    /// Sets of places and transitions whose relays are never all on; those of places first.
    pub exclusive: Vec<Vec<Operand>>,
    /// Places and transitions whose relays never come on.
    pub never: Vec<Operand>,
    /// Whether all states of the code were explored.
    pub complete: bool,
}

/// Explores the code of a net without structural errors, from its initial marks.
#[must_use]
pub fn knowledge(diagram: &Diagram) -> Knowledge {
    let rules = Rules::new(diagram);
    let places = diagram.places.len();
    let width = places + diagram.transitions.len();
    let mut seen = Seen { together: vec![Bits::new(width); width], markings: BTreeSet::new() };
    seen.add(&marks(diagram, &rules, &rules.initial(), width));
    let (mut complete, mut scans) = (true, 0);
    let found = search(rules.width(), &[rules.initial()], STATES, |_, state, take| {
        if scans > SCANS {
            complete = false;
            return;
        }
        let (sets, is_all) = sets(&rules, state);
        complete &= is_all;
        scans += sets.len();
        for (fired, _) in sets {
            let next = rules.scan(state, &fired);
            let mut on = marks(diagram, &rules, &next, width);
            fired.iter().for_each(|&at| on.insert(places + at));
            seen.add(&on);
            take(0, &next);
        }
        for place in (0..places).filter(|&place| rules.is_running(state, place)) {
            take(0, &rules.run_out(state, place));
        }
    });
    complete &= found.complete;
    let element = |at: usize| match at.checked_sub(places) {
        None => Operand::Place(at),
        Some(transition) => Operand::Transition(transition),
    };
    let is_ever = |at: &usize| seen.together[*at].contains(*at);
    let ever: Vec<usize> = (0..width).filter(is_ever).collect();
    let mut exclusive: BTreeSet<Vec<usize>> = BTreeSet::new();
    for (at, &one) in ever.iter().enumerate() {
        let others = ever[at + 1..].iter().filter(|&&other| !seen.together[one].contains(other));
        exclusive.extend(others.map(|&other| vec![one, other]));
    }
    // These sets also cover states that an incomplete search did not reach.
    for set in structure::at_most_one(diagram) {
        for (at, &one) in set.iter().enumerate() {
            exclusive
                .extend(set[at + 1..].iter().map(|&other| vec![one.min(other), one.max(other)]));
        }
    }
    if complete && places <= MAX_PLACES {
        exclusive.extend(seen.threes(&ever[..ever.partition_point(|&at| at < places)]));
    }
    let mut exclusive: Vec<Vec<usize>> = exclusive.into_iter().collect();
    exclusive.sort_by_key(|set| (set.iter().any(|&at| at >= places), set.len()));
    exclusive.truncate(MAX_SETS);
    let named = |set: Vec<usize>| set.into_iter().map(element).collect();
    let never = (0..width).filter(|at| !is_ever(at)).map(element);
    Knowledge {
        exclusive: exclusive.into_iter().map(named).collect(),
        never: if complete { never.collect() } else { Vec::new() },
        complete,
    }
}

/// What a net without faults says about the relays of its code.
#[must_use]
pub fn relays(diagram: &Diagram) -> Relays {
    let transitions = diagram.transitions.len();
    let number = |operand: Operand| match operand {
        Operand::Transition(at) => Some(at),
        Operand::Place(at) => Some(transitions + at),
        Operand::Contact(_) | Operand::Outer(_) | Operand::FirstScan => None,
    };
    let heads = diagram.transitions.iter().map(|one| &one.head);
    let heads = heads.chain(diagram.places.iter().map(|one| &one.head));
    let addresses: Vec<_> = heads.map(|head| head.address).collect();
    let transition = |at| Element { name: diagram.transition_name(at), is_place: false };
    let place = |at| Element { name: diagram.place_name(at), is_place: true };
    let places = (0..diagram.places.len()).map(place);
    let spellings = Spelling::ALL.map(|(spelling, sign)| {
        let devices = addresses.iter().map(|address| spelling.device((*address)?)).collect();
        relays::Spelling { sign, devices }
    });
    let sets = knowledge(diagram).exclusive.into_iter();
    Relays {
        file: diagram.file.clone(),
        elements: (0..transitions).map(transition).chain(places).collect(),
        exclusive: sets.map(|set| set.into_iter().filter_map(number).collect()).collect(),
        spellings: spellings.into(),
    }
}

/// The places whose relays are on; of counters those that have started.
fn marks(diagram: &Diagram, rules: &Rules, state: &[u64], width: usize) -> Bits {
    let mut on = Bits::new(width);
    for (at, place) in diagram.places.iter().enumerate() {
        let is_on = match place.kind {
            Kind::Counter { .. } => rules.count(state, at) > 0,
            Kind::Box | Kind::Timer { .. } => rules.is_marked(state, at),
        };
        if is_on {
            on.insert(at);
        }
    }
    on
}

/// What was on at the ends of scans.
struct Seen {
    /// For each place, then each transition: what was on together with it.
    together: Vec<Bits>,
    /// The sets of relays that were on.
    markings: BTreeSet<Bits>,
}

impl Seen {
    fn add(&mut self, on: &Bits) {
        if self.markings.len() > SCANS || !self.markings.insert(on.clone()) {
            return;
        }
        for one in on.iter() {
            self.together[one].union_with(on);
        }
    }

    /// Three places that were never all marked, although each two of them were.
    fn threes(&self, places: &[usize]) -> Vec<Vec<usize>> {
        let is_two = |one: usize, other: usize| self.together[one].contains(other);
        let mut found = Vec::new();
        for (at, &a) in places.iter().enumerate() {
            for (further, &b) in places.iter().enumerate().skip(at + 1) {
                if !is_two(a, b) {
                    continue;
                }
                let all = |c: &&usize| {
                    is_two(a, **c)
                        && is_two(b, **c)
                        && !self
                            .markings
                            .iter()
                            .any(|on| on.contains(a) && on.contains(b) && on.contains(**c))
                };
                found.extend(places[further + 1..].iter().filter(all).map(|&c| vec![a, b, c]));
                if found.len() > MAX_SETS {
                    return found;
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    #[test]
    fn two_of_a_cycle_are_apart_and_three_of_two_tokens() {
        let source = "outer E = 00000\nbox A marked\nbox B marked\nbox C\n\
                      transition T1 : A -> C if E\ntransition T2 : C -> A if not E\n\
                      transition T3 : B -> C if not E\ntransition T4 : C -> B if E\n";
        let net = text::read("a.snet", source).expect("a net");
        let known = knowledge(&net);
        let place = |at| Operand::Place(at);
        assert!(known.complete);
        assert!(
            known.exclusive.contains(&vec![place(0), place(1), place(2)]),
            "{:?}",
            known.exclusive
        );
        assert!(!known.exclusive.contains(&vec![place(0), place(1)]));
        let ring = "box A marked\nbox B\nbox C\ntransition T : A -> B\ntransition U : B -> A\n\
                    transition V : C -> \n";
        let known = knowledge(&text::read("b.snet", ring).expect("a net"));
        assert!(known.exclusive.contains(&vec![place(0), place(1)]));
        assert_eq!(known.never, [place(2), Operand::Transition(2)]);
    }
}

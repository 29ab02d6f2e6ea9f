//! Structural properties of a net, from its arcs only: place and transition invariants, siphons and traps.

use crate::{Diagram, Direction, Kind, Signal};
use scanbound_nets::invariant::{exclusive, invariants, transition_invariants};
use scanbound_nets::siphon::{has_marked_trap, siphons, traps};
use scanbound_nets::{Net, Transition};

/// The limit on rows, sets and steps.
const LIMIT: usize = 20_000;

/// A weighted sum of marks that no firing changes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlaceInvariant {
    /// Places and their weights.
    pub weights: Vec<(usize, i64)>,
    /// The sum in the initial state.
    pub sum: i64,
}

/// A siphon: a set of places that stays empty once it is empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Siphon {
    /// The places.
    pub places: Vec<usize>,
    /// Whether it contains an initially marked trap, so that it never becomes empty.
    pub is_kept: bool,
}

/// The structural properties.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Structure {
    /// Place invariants. Emergency stops are ignored: they only remove marks, so the sums are upper limits.
    pub place_invariants: Vec<PlaceInvariant>,
    /// Transition invariants: firings that together restore the state.
    pub transition_invariants: Vec<Vec<(usize, i64)>>,
    /// Minimal siphons.
    pub siphons: Vec<Siphon>,
    /// Minimal traps.
    pub traps: Vec<Vec<usize>>,
    /// Whether all siphons and traps were found within the limit.
    pub complete: bool,
}

/// The net as an ordinary Petri net: without emergency stops, and with timers as boxes. A counter is a place from which
/// its output removes as many tokens as the set value.
#[must_use]
pub fn plain(diagram: &Diagram) -> Net {
    let transition = |at: usize| {
        let counted = |place: usize| match diagram.places[place].kind {
            Kind::Counter { count, .. } => usize::from(count),
            _ => 1,
        };
        let takes = diagram.places_of(at, Direction::Into);
        let mut one = Transition {
            inputs: takes.flat_map(|place| std::iter::repeat_n(place, counted(place))).collect(),
            outputs: diagram.places_of(at, Direction::OutOf).collect(),
            ..Transition::default()
        };
        for gate in diagram.gates_of(at) {
            let Signal::Place(place) = gate.signal else { continue };
            let side = if gate.is_inhibiting { &mut one.inhibitors } else { &mut one.tested };
            side.push(place);
        }
        one
    };
    let marked = diagram.places.iter().enumerate().filter(|(_, place)| place.is_marked);
    Net {
        places: diagram.places.len(),
        transitions: ordinary(diagram).map(transition).collect(),
        initial: marked.map(|(at, _)| at).collect(),
    }
}

/// The transitions except emergency stops.
fn ordinary(diagram: &Diagram) -> impl Iterator<Item = usize> + '_ {
    (0..diagram.transitions.len()).filter(|&at| !diagram.transitions[at].is_stop)
}

/// Sets of places of which at most one is marked at a time, by place invariants.
#[must_use]
pub fn at_most_one(diagram: &Diagram) -> Vec<Vec<usize>> {
    let mut sets = exclusive(&plain(diagram), LIMIT);
    sets.retain(|set| set.len() > 1);
    sets.sort();
    sets
}

/// Computes all structural properties.
#[must_use]
pub fn structure(diagram: &Diagram) -> Structure {
    let net = plain(diagram);
    let weighted = |weights: &Vec<i64>| -> Vec<(usize, i64)> {
        let all = weights.iter().copied().enumerate();
        all.filter(|&(_, weight)| weight > 0).collect()
    };
    let sum = |weights: &Vec<i64>| net.initial.iter().map(|&place| weights[place]).sum();
    let mut place_invariants: Vec<PlaceInvariant> = (invariants(&net, LIMIT).iter())
        .map(|weights| PlaceInvariant { weights: weighted(weights), sum: sum(weights) })
        .collect();
    place_invariants.sort_by(|one, other| one.weights.cmp(&other.weights));
    let numbers: Vec<usize> = ordinary(diagram).collect();
    let named = |weights: &Vec<i64>| {
        weighted(weights).into_iter().map(|(at, weight)| (numbers[at], weight)).collect()
    };
    let mut cycles: Vec<Vec<(usize, i64)>> =
        transition_invariants(&net, LIMIT).iter().map(named).collect();
    cycles.sort();
    let (found, kept) = (siphons(&net, LIMIT), traps(&net, LIMIT));
    let complete = found.complete && kept.complete;
    let is_kept = |places: &[usize]| has_marked_trap(&net, places);
    let siphons = found.sets.into_iter();
    let siphons = siphons.map(|places| Siphon { is_kept: is_kept(&places), places }).collect();
    Structure {
        place_invariants,
        transition_invariants: cycles,
        siphons,
        traps: kept.sets,
        complete,
    }
}

//! Petri nets: places, transitions, which places can be marked together, and which never are.
//!
//! The nets are ordinary: every arc moves one token. This crate knows no PLC language; sequential function charts are
//! nets whose places are the steps (`scanbound_iec`).

mod bits;
pub mod invariant;
pub mod reach;
pub mod relays;
pub mod search;
pub mod siphon;

pub use bits::Bits;

/// A transition. It can fire if all places of `inputs` and `tested` are marked and no place of `inhibitors` is. It then
/// removes the tokens of `inputs` and marks the places of `outputs`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Transition {
    /// Places that must be marked and keep their token (read arcs).
    pub tested: Vec<usize>,
    /// Places that must not be marked (inhibitor arcs).
    pub inhibitors: Vec<usize>,
    /// Places from which it takes a token.
    pub inputs: Vec<usize>,
    /// Places into which it puts a token.
    pub outputs: Vec<usize>,
    /// Whether it can fire in the same step as other transitions that take the same tokens.
    pub shares: bool,
}

/// A Petri net with its initial marking. Places and transitions are numbered from 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Net {
    /// The number of places.
    pub places: usize,
    /// The transitions.
    pub transitions: Vec<Transition>,
    /// The places that are marked initially.
    pub initial: Vec<usize>,
}

impl Net {
    /// The initial marking.
    #[must_use]
    pub fn start(&self) -> Bits {
        Bits::of(self.places, &self.initial)
    }

    /// Whether a transition can fire in this marking.
    #[must_use]
    pub fn is_enabled(&self, transition: usize, marking: &Bits) -> bool {
        let Transition { inputs: takes, tested: needs, inhibitors: bars, .. } =
            &self.transitions[transition];
        takes.iter().chain(needs).all(|&place| marking.contains(place))
            && !bars.iter().any(|&place| marking.contains(place))
    }

    /// Whether any transition can fire together with others that take the same tokens.
    #[must_use]
    pub fn shares(&self) -> bool {
        self.transitions.iter().any(|one| one.shares)
    }

    /// The marking after these transitions have fired in one step, and the first place that would then have two tokens
    /// (it keeps one).
    #[must_use]
    pub fn fire(&self, transitions: &[usize], marking: &Bits) -> (Bits, Option<usize>) {
        let mut next = marking.clone();
        for &at in transitions {
            self.transitions[at].inputs.iter().for_each(|&place| next.remove(place));
        }
        let mut twice = None;
        for place in transitions.iter().flat_map(|&at| &self.transitions[at].outputs) {
            if next.contains(*place) {
                twice = twice.or(Some(*place));
            }
            next.insert(*place);
        }
        (next, twice)
    }

    /// An index for finding the enabled transitions of a marking without testing all of them.
    #[must_use]
    pub fn enabled_index(&self) -> EnabledIndex<'_> {
        let mut watched = vec![Vec::new(); self.places];
        let mut always = Vec::new();
        for (at, Transition { inputs: takes, tested: needs, .. }) in
            self.transitions.iter().enumerate()
        {
            match takes.iter().chain(needs).next() {
                Some(&place) => watched[place].push(at),
                None => always.push(at),
            }
        }
        EnabledIndex { net: self, watched, always, shares: self.shares() }
    }
}

/// A net with the transitions to test for each marked place.
#[derive(Debug, Clone)]
pub struct EnabledIndex<'n> {
    net: &'n Net,
    /// For each place the transitions to test if it is marked. Each transition with an input place is listed at exactly
    /// one of its input places.
    watched: Vec<Vec<usize>>,
    /// Transitions without an input place.
    always: Vec<usize>,
    /// Whether any transition can fire together with others that take the same tokens.
    shares: bool,
}

impl EnabledIndex<'_> {
    /// The enabled transitions, in ascending order.
    #[must_use]
    pub fn enabled(&self, marking: &Bits) -> Vec<usize> {
        let watched = marking.iter().flat_map(|place| &self.watched[place]);
        let all = watched.chain(&self.always).copied();
        let mut found: Vec<usize> = all.filter(|&at| self.net.is_enabled(at, marking)).collect();
        found.sort_unstable();
        found
    }

    /// The sets of transitions that may fire in the next step. If firing one after the other reaches all markings that
    /// simultaneous firing reaches, each set has one transition; else every conflict-free set of enabled transitions is
    /// listed. Transitions with `shares` conflict with none. `None` if there are too many sets.
    #[must_use]
    pub fn next_steps(&self, marking: &Bits) -> Option<Vec<Vec<usize>>> {
        let enabled = self.enabled(marking);
        if !self.shares && self.is_serializable(&enabled) {
            return Some(enabled.into_iter().map(|at| vec![at]).collect());
        }
        let mut sets: Vec<Vec<usize>> = vec![Vec::new()];
        for at in enabled {
            let Transition { inputs: takes, shares, .. } = &self.net.transitions[at];
            let is_free = |set: &&Vec<usize>| {
                let others = set.iter().map(|&other| &self.net.transitions[other]);
                let rivals = others.filter(|other| !shares && !other.shares);
                let mut taken = rivals.flat_map(|other| &other.inputs);
                !taken.any(|place| takes.contains(place))
            };
            let more: Vec<Vec<usize>> =
                sets.iter().filter(is_free).map(|set| [&set[..], &[at]].concat()).collect();
            sets.extend(more);
            if sets.len() > SETS {
                return None;
            }
        }
        sets.remove(0);
        sets.sort_by_key(Vec::len);
        Some(sets)
    }

    /// Whether any set of these enabled transitions can also fire one after the other: in an order in which each fires
    /// before the transitions that disable it without taking its tokens.
    fn is_serializable(&self, enabled: &[usize]) -> bool {
        let of = |at: usize| &self.net.transitions[at];
        let disturbs = |one: usize, asking: usize| {
            let (one, asking) = (of(one), of(asking));
            let unmarks = |place| one.inputs.contains(place) && !one.outputs.contains(place);
            asking.tested.iter().any(unmarks)
                || asking.inhibitors.iter().any(|place| one.outputs.contains(place))
        };
        let asks = |&at: &usize| !of(at).tested.is_empty() || !of(at).inhibitors.is_empty();
        let mut open: Vec<usize> = enabled.iter().copied().filter(asks).collect();
        // A transition that no remaining transition disables can fire last.
        while let Some(last) = open
            .iter()
            .position(|&at| !open.iter().any(|&other| other != at && disturbs(other, at)))
        {
            open.swap_remove(last);
        }
        open.is_empty()
    }
}

/// The largest number of sets that are considered in one marking.
const SETS: usize = 1_024;

/// Nets for unit tests.
#[cfg(any(test, feature = "testing"))]
pub mod testing {
    use super::{Net, Transition};

    /// A net whose transitions are given as pairs of input places and output places.
    pub fn net(places: usize, initial: &[usize], moves: &[(&[usize], &[usize])]) -> Net {
        let transition = |&(takes, puts): &(&[usize], &[usize])| Transition {
            inputs: takes.to_vec(),
            outputs: puts.to_vec(),
            ..Transition::default()
        };
        Net {
            places,
            initial: initial.to_vec(),
            transitions: moves.iter().map(transition).collect(),
        }
    }
}

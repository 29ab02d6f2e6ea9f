//! Petri nets: places, transitions, what can be marked together, and what never is.
//!
//! A net is plain: every arc takes or puts one token. It knows no language; sequential function charts are nets whose
//! places are steps (`scanbound_iec`).

mod bits;
pub mod invariant;
pub mod reach;
pub mod relays;
pub mod search;
pub mod siphon;

pub use bits::Bits;

/// A transition: it can fire when all places of `takes` and `needs` are marked and none of `bars` is, and marks those of
/// `puts`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Transition {
    /// Places that must be marked, and stay so.
    pub needs: Vec<usize>,
    /// Places that must not be marked.
    pub bars: Vec<usize>,
    /// Places that lose a token.
    pub takes: Vec<usize>,
    /// Places that get one.
    pub puts: Vec<usize>,
    /// Whether it can fire at once with others that take the same places.
    pub shares: bool,
}

/// A Petri net with its initial marking. Places and transitions are numbered from 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Net {
    /// How many places there are.
    pub places: usize,
    /// The transitions.
    pub transitions: Vec<Transition>,
    /// The places that have a token at first.
    pub initial: Vec<usize>,
}

impl Net {
    /// The initial marking.
    #[must_use]
    pub fn start(&self) -> Bits {
        Bits::of(self.places, &self.initial)
    }

    /// Whether a transition can fire.
    #[must_use]
    pub fn is_enabled(&self, transition: usize, marking: &Bits) -> bool {
        let Transition { takes, needs, bars, .. } = &self.transitions[transition];
        takes.iter().chain(needs).all(|&place| marking.has(place))
            && !bars.iter().any(|&place| marking.has(place))
    }

    /// Whether transitions share what they take.
    #[must_use]
    pub fn shares(&self) -> bool {
        self.transitions.iter().any(|one| one.shares)
    }

    /// The marking after transitions have fired at once, and the first place that would have two tokens then (it keeps
    /// one).
    #[must_use]
    pub fn fire(&self, transitions: &[usize], marking: &Bits) -> (Bits, Option<usize>) {
        let mut next = marking.clone();
        for &at in transitions {
            self.transitions[at].takes.iter().for_each(|&place| next.remove(place));
        }
        let mut twice = None;
        for place in transitions.iter().flat_map(|&at| &self.transitions[at].puts) {
            if next.has(*place) {
                twice = twice.or(Some(*place));
            }
            next.insert(*place);
        }
        (next, twice)
    }

    /// What finds the transitions that may fire in a marking without looking at all of them.
    #[must_use]
    pub fn firing(&self) -> Firing<'_> {
        let mut watched = vec![Vec::new(); self.places];
        let mut always = Vec::new();
        for (at, Transition { takes, needs, .. }) in self.transitions.iter().enumerate() {
            match takes.iter().chain(needs).next() {
                Some(&place) => watched[place].push(at),
                None => always.push(at),
            }
        }
        Firing { net: self, watched, always, shares: self.shares() }
    }
}

/// A net, and which transitions to look at where a place is marked.
#[derive(Debug, Clone)]
pub struct Firing<'n> {
    net: &'n Net,
    /// For each place transitions that it must be marked for: each stands at one of those that it asks for.
    watched: Vec<Vec<usize>>,
    /// Transitions that ask for no place to be marked.
    always: Vec<usize>,
    /// Whether transitions share what they take.
    shares: bool,
}

impl Firing<'_> {
    /// The transitions that can fire, in their order.
    #[must_use]
    pub fn enabled(&self, marking: &Bits) -> Vec<usize> {
        let watched = marking.iter().flat_map(|place| &self.watched[place]);
        let all = watched.chain(&self.always).copied();
        let mut found: Vec<usize> = all.filter(|&at| self.net.is_enabled(at, marking)).collect();
        found.sort_unstable();
        found
    }

    /// The sets of transitions that may fire next: each alone where what several bring about that fire at once they also do
    /// one after the other, else every set of those that are enabled and take no place from each other, unless one of them
    /// shares it. `None` if these are too many.
    #[must_use]
    pub fn moves(&self, marking: &Bits) -> Option<Vec<Vec<usize>>> {
        let enabled = self.enabled(marking);
        if !self.shares && self.is_serial(&enabled) {
            return Some(enabled.into_iter().map(|at| vec![at]).collect());
        }
        let mut sets: Vec<Vec<usize>> = vec![Vec::new()];
        for at in enabled {
            let Transition { takes, shares, .. } = &self.net.transitions[at];
            let is_free = |set: &&Vec<usize>| {
                let others = set.iter().map(|&other| &self.net.transitions[other]);
                let rivals = others.filter(|other| !shares && !other.shares);
                let mut taken = rivals.flat_map(|other| &other.takes);
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

    /// Whether any of these, which are enabled, can fire one after the other instead of at once: in an order in which each
    /// comes before those that disturb what it asks for without taking it.
    fn is_serial(&self, enabled: &[usize]) -> bool {
        let of = |at: usize| &self.net.transitions[at];
        let disturbs = |one: usize, asking: usize| {
            let (one, asking) = (of(one), of(asking));
            let unmarks = |place| one.takes.contains(place) && !one.puts.contains(place);
            asking.needs.iter().any(unmarks)
                || asking.bars.iter().any(|place| one.puts.contains(place))
        };
        let asks = |&at: &usize| !of(at).needs.is_empty() || !of(at).bars.is_empty();
        let mut open: Vec<usize> = enabled.iter().copied().filter(asks).collect();
        // What is disturbed by none of the rest may come last.
        while let Some(last) = open
            .iter()
            .position(|&at| !open.iter().any(|&other| other != at && disturbs(other, at)))
        {
            open.swap_remove(last);
        }
        open.is_empty()
    }
}

/// How many sets of transitions are looked at in one marking.
const SETS: usize = 1_024;

/// Nets for unit tests.
#[cfg(any(test, feature = "testing"))]
pub mod testing {
    use super::{Net, Transition};

    /// A net of transitions written as what they take and put.
    pub fn net(places: usize, initial: &[usize], moves: &[(&[usize], &[usize])]) -> Net {
        let transition = |&(takes, puts): &(&[usize], &[usize])| Transition {
            takes: takes.to_vec(),
            puts: puts.to_vec(),
            ..Transition::default()
        };
        Net {
            places,
            initial: initial.to_vec(),
            transitions: moves.iter().map(transition).collect(),
        }
    }
}

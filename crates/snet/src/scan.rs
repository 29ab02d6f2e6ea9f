//! The code's rule: in one scan, all transitions are evaluated with the marks at its start, then all enabled ones fire
//! together.
//!
//! The code computes each transition's relay first, then each box: `(marked or an input fires) and no output fires`,
//! then timers and counters. A counter counts when its input's relay turns on, not while it stays on.

use super::rules::{Rules, State};
use std::collections::BTreeSet;

impl Rules {
    /// The transitions whose relays are on in a scan from this state.
    #[must_use]
    pub fn fired(&self, state: &[u64], outers: &[bool]) -> Vec<usize> {
        let all = 0..self.transitions();
        all.filter(|&at| self.is_ready(state, at) && self.gates_allow(at, outers)).collect()
    }

    /// Those of the `ready` transitions (marks and inner gates allow them) that the outer gates allow too.
    pub(super) fn fired_of(&self, ready: &[usize], outers: &[bool]) -> Vec<usize> {
        ready.iter().copied().filter(|&at| self.gates_allow(at, outers)).collect()
    }

    /// A firing order of these transitions, with arbiters ignored.
    pub(super) fn order_of(&self, state: &[u64], fired: &[usize]) -> Option<Vec<usize>> {
        let mut bare = self.clone();
        bare.forget_gates();
        bare.order(state, &[], fired)
    }

    /// Whether marks and gates never allow both to fire in one scan.
    pub(super) fn exclude_each_other(&self, one: usize, other: usize) -> bool {
        let (one, other) = (&self.rules[one], &self.rules[other]);
        let opposite =
            |&(outer, inhibits): &(usize, bool)| other.gates.contains(&(outer, !inhibits));
        one.needs.meets(&other.bars)
            || other.needs.meets(&one.bars)
            || one.gates.iter().any(opposite)
    }

    /// Sets of transitions that must each fire before another one of the set, in a circle. `exclusive` tells which two
    /// never fire in the same scan.
    pub(super) fn circles(&self, exclusive: &impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
        let mut graph = petgraph::graphmap::DiGraphMap::<usize, ()>::new();
        for one in 0..self.transitions() {
            for other in (0..self.transitions()).filter(|&other| other != one) {
                // A transition that changes what another reads must come after it.
                if self.rules[one].hinders(&self.rules[other]) && !exclusive(one, other) {
                    graph.add_edge(other, one, ());
                }
            }
        }
        let sets = petgraph::algo::tarjan_scc(&graph).into_iter().filter(|set| set.len() > 1);
        sets.map(|mut set| {
            set.sort_unstable();
            set
        })
        .collect()
    }

    /// The state after a scan in which the relays of these transitions are on. For timeouts see [`Rules::run_out`].
    #[must_use]
    pub fn scan(&self, state: &[u64], fired: &[usize]) -> State {
        let mut next = state.to_vec();
        for counter in &self.counters {
            next[counter.fired / 64] &= !(1 << (counter.fired % 64));
        }
        for &at in fired {
            let rule = &self.rules[at];
            rule.sets.set(&mut next);
            for &counter in &rule.counts {
                let counter = self.counters[counter];
                let mask = 1 << (counter.fired % 64);
                if state[counter.fired / 64] & mask == 0 {
                    counter.count(&mut next);
                }
                next[counter.fired / 64] |= mask;
            }
        }
        // A mark that is removed is gone, even if it is also added.
        fired.iter().for_each(|&at| self.rules[at].clears.clear(&mut next));
        next
    }

    /// The state without the bits that only the code's rule uses.
    #[must_use]
    pub fn forget(&self, state: &[u64]) -> State {
        let mut bare = state.to_vec();
        for counter in &self.counters {
            bare[counter.fired / 64] &= !(1 << (counter.fired % 64));
        }
        bare
    }

    /// An order in which the net could fire these transitions one after another with the same result as the scan;
    /// `None` if there is none: then code and net differ.
    #[must_use]
    pub fn order(&self, state: &[u64], outers: &[bool], fired: &[usize]) -> Option<Vec<usize>> {
        let end = self.forget(&self.scan(state, fired));
        let mut search =
            Order { rules: self, outers, end, order: Vec::new(), dead: BTreeSet::new() };
        let is_found = search.complete(&self.forget(state), fired);
        is_found.then_some(search.order)
    }

    /// Whether a transition shares no written bit with the others.
    fn is_apart(&self, transition: usize, others: &[usize]) -> bool {
        let one = &self.rules[transition];
        let touches = |at: &usize| one.touches(&self.rules[*at]) || self.rules[*at].touches(one);
        !others.iter().any(touches)
    }
}

/// A search for a firing order.
struct Order<'a> {
    rules: &'a Rules,
    outers: &'a [bool],
    /// The state that must be reached.
    end: State,
    order: Vec<usize>,
    /// Remaining transitions and states from which the end cannot be reached.
    dead: BTreeSet<(Vec<usize>, State)>,
}

impl Order<'_> {
    fn complete(&mut self, state: &[u64], left: &[usize]) -> bool {
        if left.is_empty() {
            return state == self.end;
        }
        let key = (left.to_vec(), state.to_vec());
        if self.dead.contains(&key) {
            return false;
        }
        for (at, &transition) in left.iter().enumerate() {
            if !self.rules.can_fire(state, transition, self.outers) {
                continue;
            }
            let rest: Vec<usize> = [&left[..at], &left[at + 1..]].concat();
            self.order.push(transition);
            if self.complete(&self.rules.fire(state, transition), &rest) {
                return true;
            }
            self.order.pop();
            // An independent transition can go first, because it cannot prevent the others.
            if !self.rules.has_arbiters() && self.rules.is_apart(transition, &rest) {
                break;
            }
        }
        self.dead.insert(key);
        false
    }
}

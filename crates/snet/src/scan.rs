//! The code's rule: in one scan all transitions are looked at on the marks as they are, then all that fire do at once.
//!
//! The code works out every transition's relay first, then every box's, `(marked or an input fires) and no output fires`,
//! then timers and counters. A counter counts when its input's relay comes on, not while it stays on.

use super::rules::{Rules, State};
use std::collections::BTreeSet;

impl Rules {
    /// The transitions whose relays are on in a scan that begins so.
    #[must_use]
    pub fn fired(&self, state: &[u64], outers: &[bool]) -> Vec<usize> {
        let all = 0..self.transitions();
        all.filter(|&at| self.is_ready(state, at) && self.is_open(at, outers)).collect()
    }

    /// Of these transitions, whose marks and inner gates let them fire, those whose outer gates do, too.
    pub(super) fn fired_of(&self, ready: &[usize], outers: &[bool]) -> Vec<usize> {
        ready.iter().copied().filter(|&at| self.is_open(at, outers)).collect()
    }

    /// An order of these transitions with all arbiters left out.
    pub(super) fn order_of(&self, state: &[u64], fired: &[usize]) -> Option<Vec<usize>> {
        let mut bare = self.clone();
        bare.forget_gates();
        bare.order(state, &[], fired)
    }

    /// Whether marks, inner gates or outer gates never let both fire in one scan.
    pub(super) fn exclude_each_other(&self, one: usize, other: usize) -> bool {
        let (one, other) = (&self.rules[one], &self.rules[other]);
        let opposite =
            |&(outer, inhibits): &(usize, bool)| other.gates.contains(&(outer, !inhibits));
        one.needs.meets(&other.bars)
            || other.needs.meets(&one.bars)
            || one.gates.iter().any(opposite)
    }

    /// Sets of transitions of which each has to be before another, round in a circle; `apart` says which never fire in one
    /// scan.
    pub(super) fn circles(&self, apart: &impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
        let mut graph = petgraph::graphmap::DiGraphMap::<usize, ()>::new();
        for one in 0..self.transitions() {
            for other in (0..self.transitions()).filter(|&other| other != one) {
                // What changes what the other looks at comes behind it.
                if self.rules[one].hinders(&self.rules[other]) && !apart(one, other) {
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

    /// The state behind a scan in which the relays of these transitions are on. Timers that run out do so by
    /// [`Rules::run_out`].
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
        // What is taken goes whatever is put.
        fired.iter().for_each(|&at| self.rules[at].clears.clear(&mut next));
        next
    }

    /// The state without what only code remembers.
    #[must_use]
    pub fn forget(&self, state: &[u64]) -> State {
        let mut bare = state.to_vec();
        for counter in &self.counters {
            bare[counter.fired / 64] &= !(1 << (counter.fired % 64));
        }
        bare
    }

    /// An order in which the net could fire these transitions one after another, to come to where the scan comes; `None`
    /// if there is none: there code and net part.
    #[must_use]
    pub fn order(&self, state: &[u64], outers: &[bool], fired: &[usize]) -> Option<Vec<usize>> {
        let end = self.forget(&self.scan(state, fired));
        let mut search =
            Order { rules: self, outers, end, order: Vec::new(), dead: BTreeSet::new() };
        let is_found = search.complete(&self.forget(state), fired);
        is_found.then_some(search.order)
    }

    /// Whether a transition neither reads nor writes what the others write, nor they what it writes.
    fn is_apart(&self, transition: usize, others: &[usize]) -> bool {
        let one = &self.rules[transition];
        let touches = |at: &usize| one.touches(&self.rules[*at]) || self.rules[*at].touches(one);
        !others.iter().any(touches)
    }
}

/// The search for an order.
struct Order<'a> {
    rules: &'a Rules,
    outers: &'a [bool],
    /// Where it must end.
    end: State,
    order: Vec<usize>,
    /// What is left, and from where, when nothing leads to the end.
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
            // What has nothing to do with the others may as well go first: then it is not what stops them.
            if !self.rules.has_arbiters() && self.rules.is_apart(transition, &rest) {
                break;
            }
        }
        self.dead.insert(key);
        false
    }
}

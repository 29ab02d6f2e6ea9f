//! The net's rule: which transitions can fire, the effect of firing (one transition at a time), and when timers time
//! out.
//!
//! A state is a few words of bits. A box has a bit for its mark; a timer has bits for its box's mark and for the
//! timeout (P); a counter has bits for started (c) and counted up (bc), and its count.

use super::{Diagram, Direction, Kind, Signal};

/// A state of a net, to be interpreted by the [`Rules`] that made it.
pub type State = Vec<u64>;

/// A set of bits in a state: pairs of word index and mask.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Mask(Vec<(usize, u64)>);

impl Mask {
    pub(super) fn add(&mut self, bit: usize) {
        let (word, bit) = (bit / 64, 1 << (bit % 64));
        match self.0.iter_mut().find(|(own, _)| *own == word) {
            Some((_, bits)) => *bits |= bit,
            None => self.0.push((word, bit)),
        }
    }

    pub(super) fn all(&self, state: &[u64]) -> bool {
        self.0.iter().all(|&(word, bits)| state[word] & bits == bits)
    }

    pub(super) fn any(&self, state: &[u64]) -> bool {
        self.0.iter().any(|&(word, bits)| state[word] & bits != 0)
    }

    pub(super) fn set(&self, state: &mut [u64]) {
        self.0.iter().for_each(|&(word, bits)| state[word] |= bits);
    }

    pub(super) fn clear(&self, state: &mut [u64]) {
        self.0.iter().for_each(|&(word, bits)| state[word] &= !bits);
    }

    pub(super) fn meets(&self, other: &Mask) -> bool {
        let meets = |&(word, bits): &(usize, u64)| {
            other.0.iter().any(|&(own, others)| own == word && bits & others != 0)
        };
        self.0.iter().any(meets)
    }
}

/// The bits of a counter in a state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counter {
    /// Started to count (c).
    pub(super) begun: usize,
    /// Counted up (bc).
    pub(super) full: usize,
    /// The first bit of the count; all its bits are in one word.
    value: usize,
    /// The number of bits of the count.
    bits: u32,
    /// The set value.
    limit: u64,
    /// Its input fired in the last scan; only the code's rule uses this.
    pub(super) fired: usize,
}

impl Counter {
    fn value(self, state: &[u64]) -> u64 {
        state[self.value / 64] >> (self.value % 64) & ((1 << self.bits) - 1)
    }

    /// Increments the count, up to the set value.
    pub(super) fn count(self, state: &mut [u64]) {
        let value = self.value(state);
        if value < self.limit {
            state[self.value / 64] += 1 << (self.value % 64);
            if value + 1 == self.limit {
                state[self.full / 64] |= 1 << (self.full % 64);
            }
        }
    }
}

/// The condition and effect of a transition.
#[derive(Debug, Clone, Default)]
pub(super) struct Rule {
    /// All of these must be set.
    pub(super) needs: Mask,
    /// None of these may be set.
    pub(super) bars: Mask,
    /// The part of `bars` that are marks of output boxes.
    room: Mask,
    /// The part of `bars` that inhibiting gates read.
    inhibits: Mask,
    /// For an emergency stop: at least one of these must be set.
    any: Option<Mask>,
    /// The bits that firing clears.
    pub(super) clears: Mask,
    /// The bits that firing sets.
    pub(super) sets: Mask,
    /// The counters that firing increments.
    pub(super) counts: Vec<usize>,
    /// The bits that are set when these counters have counted up.
    fills: Mask,
    /// The outer gates, and whether each is inhibiting.
    pub(super) gates: Vec<(usize, bool)>,
    /// The transitions with a higher priority in an arbiter.
    before: Vec<usize>,
}

impl Rule {
    /// Whether its firing may prevent the other from firing, or undo its effect.
    pub(super) fn hinders(&self, other: &Rule) -> bool {
        self.clears.meets(&other.needs)
            || other.any.as_ref().is_some_and(|any| self.clears.meets(any))
            || self.sets.meets(&other.bars)
            || self.fills.meets(&other.bars)
            || self.clears.meets(&other.sets)
    }

    /// Whether it writes a bit that the other reads or writes.
    pub(super) fn touches(&self, other: &Rule) -> bool {
        let any = other.any.as_ref();
        let reads = |mask: &Mask| {
            mask.meets(&other.needs)
                || mask.meets(&other.bars)
                || any.is_some_and(|any| mask.meets(any))
        };
        let touches =
            |mask: &Mask| reads(mask) || mask.meets(&other.clears) || mask.meets(&other.sets);
        touches(&self.clears) || touches(&self.sets) || touches(&self.fills)
    }
}

/// The rules of a net, prepared for execution.
#[derive(Debug, Clone)]
pub struct Rules {
    width: usize,
    pub(super) rules: Vec<Rule>,
    /// For each place, the bit of its mark (of a counter bc).
    marks: Vec<usize>,
    /// For each timer, the bit for its timeout.
    over: Vec<Option<usize>>,
    /// For each counter, its index among the counters.
    counter: Vec<Option<usize>>,
    pub(super) counters: Vec<Counter>,
    initial: State,
    outers: usize,
}

impl Rules {
    /// Prepares the rules of a net.
    #[must_use]
    pub fn new(diagram: &Diagram) -> Rules {
        let mut used = 0;
        let mut bit = || {
            used += 1;
            used - 1
        };
        let marks: Vec<usize> = diagram.places.iter().map(|_| bit()).collect();
        let is_timer = |kind: Kind| matches!(kind, Kind::Timer { .. });
        let over = diagram.places.iter().map(|place| is_timer(place.kind).then(&mut bit)).collect();
        let mut counters = Vec::new();
        let mut counter = vec![None; diagram.places.len()];
        for (at, place) in diagram.places.iter().enumerate() {
            let Kind::Counter { count, .. } = place.kind else { continue };
            counter[at] = Some(counters.len());
            let bits = u16::BITS - count.leading_zeros();
            let (begun, fired) = (bit(), bit());
            let limit = u64::from(count);
            counters.push(Counter { begun, full: marks[at], value: 0, bits, limit, fired });
        }
        for counter in &mut counters {
            let bits = counter.bits as usize;
            if used % 64 + bits > 64 {
                used = used.next_multiple_of(64);
            }
            counter.value = used;
            used += bits;
        }
        let width = used.div_ceil(64).max(1);
        let mut rules = Rules {
            width,
            rules: Vec::new(),
            marks,
            over,
            counter,
            counters,
            initial: vec![0; width],
            outers: diagram.outers.len(),
        };
        let own = |at| rules.rule(diagram, at);
        rules.rules = (0..diagram.transitions.len()).map(own).collect();
        for arbiter in &diagram.arbiters {
            for (at, &transition) in arbiter.transitions.iter().enumerate() {
                rules.rules[transition].before.extend(&arbiter.transitions[..at]);
            }
        }
        for (at, _) in diagram.places.iter().enumerate().filter(|(_, place)| place.is_marked) {
            let bit = rules.marks[at];
            rules.initial[bit / 64] |= 1 << (bit % 64);
        }
        rules
    }

    fn rule(&self, diagram: &Diagram, transition: usize) -> Rule {
        let mut rule = Rule::default();
        for arc in diagram.arcs.iter().filter(|arc| arc.transition == transition) {
            let place = arc.place;
            match arc.direction {
                Direction::Into => {
                    rule.needs.add(self.signal(place));
                    self.empty_place(place, &mut rule.clears);
                }
                Direction::OutOf => {
                    rule.bars.add(self.marks[place]);
                    rule.room.add(self.marks[place]);
                    match self.counter[place] {
                        Some(counter) => {
                            rule.sets.add(self.counters[counter].begun);
                            rule.fills.add(self.marks[place]);
                            rule.counts.push(counter);
                        }
                        None => rule.sets.add(self.marks[place]),
                    }
                }
                Direction::Stop => {
                    let counter = self.counter[place].map(|at| self.counters[at].begun);
                    let any = rule.any.get_or_insert_default();
                    any.add(counter.unwrap_or(self.marks[place]));
                    self.empty_place(place, &mut rule.clears);
                }
            }
        }
        for gate in diagram.gates_of(transition) {
            match gate.signal {
                Signal::Place(place) if gate.is_inhibiting => {
                    rule.bars.add(self.signal(place));
                    rule.inhibits.add(self.signal(place));
                }
                Signal::Place(place) => rule.needs.add(self.signal(place)),
                Signal::Outer(outer) => rule.gates.push((outer, gate.is_inhibiting)),
            }
        }
        rule
    }

    /// The bit that transitions and gates read from a place: of a timer, the timeout.
    fn signal(&self, place: usize) -> usize {
        self.over[place].unwrap_or(self.marks[place])
    }

    fn empty_place(&self, place: usize, mask: &mut Mask) {
        mask.add(self.marks[place]);
        if let Some(over) = self.over[place] {
            mask.add(over);
        }
        if let Some(counter) = self.counter[place].map(|at| self.counters[at]) {
            mask.add(counter.begun);
            (0..counter.bits as usize).for_each(|bit| mask.add(counter.value + bit));
        }
    }

    /// The number of words of a state.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The number of transitions.
    #[must_use]
    pub fn transitions(&self) -> usize {
        self.rules.len()
    }

    /// Removes outer gates and arbiters from the rules.
    pub(super) fn forget_gates(&mut self) {
        for rule in &mut self.rules {
            rule.gates.clear();
            rule.before.clear();
        }
    }

    /// Whether the net has arbiters.
    #[must_use]
    pub fn has_arbiters(&self) -> bool {
        self.rules.iter().any(|rule| !rule.before.is_empty())
    }

    /// The number of outer gates.
    #[must_use]
    pub fn outers(&self) -> usize {
        self.outers
    }

    /// The state without marks, in which the code begins.
    #[must_use]
    pub fn empty(&self) -> State {
        vec![0; self.width]
    }

    /// The state with the initial marks.
    #[must_use]
    pub fn initial(&self) -> State {
        self.initial.clone()
    }

    /// Whether a place is marked: a timer by its box (b), a counter when it has counted up (bc).
    #[must_use]
    pub fn is_marked(&self, state: &[u64], place: usize) -> bool {
        has(state, self.marks[place])
    }

    /// Whether a place is a timer that has timed out (P).
    #[must_use]
    pub fn is_over(&self, state: &[u64], place: usize) -> bool {
        self.over[place].is_some_and(|bit| has(state, bit))
    }

    /// The count of a counter; 0 for other places.
    #[must_use]
    pub fn count(&self, state: &[u64], place: usize) -> u16 {
        let value = self.counter[place].map_or(0, |at| self.counters[at].value(state));
        u16::try_from(value).unwrap_or(u16::MAX)
    }

    /// The value of an inner gate: the mark, or for a timer the timeout.
    #[must_use]
    pub fn says(&self, state: &[u64], place: usize) -> bool {
        has(state, self.signal(place))
    }

    /// Whether marks and inner gates allow a transition to fire; outer gates and arbiters are ignored.
    #[must_use]
    pub fn is_ready(&self, state: &[u64], transition: usize) -> bool {
        let rule = &self.rules[transition];
        rule.needs.all(state)
            && !rule.bars.any(state)
            && rule.any.as_ref().is_none_or(|any| any.any(state))
    }

    /// Whether a transition's outer gates allow it to fire.
    #[must_use]
    pub fn gates_allow(&self, transition: usize, outers: &[bool]) -> bool {
        self.rules[transition].gates.iter().all(|&(outer, inhibits)| outers[outer] != inhibits)
    }

    /// Whether a transition can fire: marks and all gates allow it, and no arbiter prefers another one.
    #[must_use]
    pub fn can_fire(&self, state: &[u64], transition: usize, outers: &[bool]) -> bool {
        let goes = |at: usize| self.is_ready(state, at) && self.gates_allow(at, outers);
        goes(transition) && !self.rules[transition].before.iter().any(|&other| goes(other))
    }

    /// Values of outer gates with which a transition can fire, if possible. Irrelevant gates are omitted.
    #[must_use]
    pub fn gates_to_fire(&self, state: &[u64], transition: usize) -> Option<Vec<(usize, bool)>> {
        if !self.is_ready(state, transition) {
            return None;
        }
        let mut values = Vec::new();
        for &(outer, inhibits) in &self.rules[transition].gates {
            if !assume(&mut values, outer, !inhibits) {
                return None;
            }
        }
        let first: Vec<usize> = self.rules[transition].before.clone();
        let ready: Vec<usize> = first.into_iter().filter(|&at| self.is_ready(state, at)).collect();
        self.held_back(&ready, values)
    }

    /// Values of outer gates with which none of these transitions can fire.
    fn held_back(
        &self,
        transitions: &[usize],
        values: Vec<(usize, bool)>,
    ) -> Option<Vec<(usize, bool)>> {
        let Some((first, rest)) = transitions.split_first() else { return Some(values) };
        self.rules[*first].gates.iter().find_map(|&(outer, inhibits)| {
            let mut more = values.clone();
            assume(&mut more, outer, inhibits).then_some(())?;
            self.held_back(rest, more)
        })
    }

    /// Whether only marks in its output boxes prevent a transition from firing.
    #[must_use]
    pub fn is_held_back(&self, state: &[u64], transition: usize) -> bool {
        let rule = &self.rules[transition];
        rule.room.any(state) && rule.needs.all(state) && !rule.inhibits.any(state)
    }

    /// The outer gates of a transition.
    pub(super) fn outers_of(&self, transition: usize) -> impl Iterator<Item = usize> + '_ {
        self.rules[transition].gates.iter().map(|&(outer, _)| outer)
    }

    /// Whether the known outer gates prevent a transition from firing.
    pub(super) fn is_shut(&self, transition: usize, outers: &[Option<bool>]) -> bool {
        let shuts = |&(outer, inhibits): &(usize, bool)| outers[outer] == Some(inhibits);
        self.rules[transition].gates.iter().any(shuts)
    }

    /// Whether a place is a counter.
    pub(super) fn is_counter(&self, place: usize) -> bool {
        self.counter[place].is_some()
    }

    /// Whether a place is a counter whose input fired in the last scan.
    pub(super) fn has_just_fired(&self, state: &[u64], place: usize) -> bool {
        self.counter[place].is_some_and(|at| has(state, self.counters[at].fired))
    }

    /// The state after a transition fires.
    #[must_use]
    pub fn fire(&self, state: &[u64], transition: usize) -> State {
        let mut next = state.to_vec();
        self.fire_in(&mut next, transition);
        next
    }

    /// Fires a transition in place.
    pub fn fire_in(&self, state: &mut [u64], transition: usize) {
        let rule = &self.rules[transition];
        rule.clears.clear(state);
        rule.sets.set(state);
        rule.counts.iter().for_each(|&counter| self.counters[counter].count(state));
    }

    /// Whether a timer runs: its box is marked, and it has not timed out.
    #[must_use]
    pub fn is_running(&self, state: &[u64], place: usize) -> bool {
        self.over[place].is_some_and(|over| !has(state, over) && has(state, self.marks[place]))
    }

    /// The state after a running timer times out.
    #[must_use]
    pub fn run_out(&self, state: &[u64], place: usize) -> State {
        let mut next = state.to_vec();
        if let Some(over) = self.over[place].filter(|_| self.is_running(state, place)) {
            next[over / 64] |= 1 << (over % 64);
        }
        next
    }
}

fn has(state: &[u64], bit: usize) -> bool {
    state[bit / 64] >> (bit % 64) & 1 == 1
}

/// Adds an assumption about an outer gate; false if it contradicts an earlier one.
fn assume(values: &mut Vec<(usize, bool)>, outer: usize, value: bool) -> bool {
    match values.iter().find(|(own, _)| *own == outer) {
        Some(&(_, own)) => own == value,
        None => {
            values.push((outer, value));
            true
        }
    }
}

//! Determines which steps and actions can be active at the same time, through parallel branches or stored actions, and
//! finds structural faults of a chart.

use super::{Chart, Qualifier};
use crate::show;
use rustc_hash::FxHashSet;
use scanbound_nets::invariant::exclusive;
use scanbound_nets::reach::{Reachability, reach};
use scanbound_nets::{Bits, Net, Transition};
use std::collections::{BTreeMap, VecDeque};

/// The default maximum number of markings that are searched.
pub const BUDGET: usize = 100_000;
/// The maximum number of markings searched for all pairs of stored actions together.
const PAIRS_BUDGET: usize = 1_000_000;
/// The maximum number of rows in the computation of place invariants.
const ROWS: usize = 5_000;

/// A step or action that can be active together with an action.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Other {
    /// A step, by its index.
    Step(usize),
    /// Another action.
    Action(String),
}

/// The reason why two can be active together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum How {
    /// Their steps are in different branches of a parallel sequence.
    Parallel,
    /// They belong to the same step.
    SameStep,
    /// The action is stored by the steps `by`, until a step of `until` is active.
    Stored {
        /// The steps that store it.
        by: Vec<usize>,
        /// The steps that reset it.
        until: Vec<usize>,
    },
}

/// An action, and a step or action that can be active together with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pair {
    /// The name of the action.
    pub action: String,
    /// The other step or action.
    pub other: Other,
    /// The reason.
    pub how: How,
    /// The transitions that lead from the initial situation to it. `None` if the search ended before it found a path.
    pub path: Option<Vec<usize>>,
}

/// A structural fault of a chart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Finding {
    /// A step can be entered while it is active; the transitions that lead there.
    EnteredTwice(usize, Vec<usize>),
    /// A step is never active.
    NeverActive(usize),
    /// A transition never fires, because its preceding steps are never active together.
    NeverClears(usize),
    /// A transition never fires, because its condition requires step flags that do not occur while its preceding steps
    /// are active: the steps, each with the required flag.
    NeverTrue(usize, Vec<(usize, bool)>),
    /// A reachable situation in which no transition is enabled: the active steps, and the transitions that lead there.
    Deadlock(Vec<usize>, Vec<usize>),
    /// An action that these steps store and no step resets.
    NeverReset(String, Vec<usize>),
}

/// The method behind an analysis, with the number of markings seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// All reachable markings were seen.
    Markings(usize),
    /// The number of markings exceeds the limit. Place invariants show which steps exclude each other; all others count
    /// as possible together.
    Invariants(usize),
    /// The number of markings exceeds the limit and invariants do not apply, so any steps may be together.
    Open(usize),
    /// A step can be entered while active, so the net is not safe and any steps may be together.
    Unsafe(usize),
}

/// The result of analysing a chart.
#[derive(Debug, Clone)]
pub struct Analysis {
    /// The method of the analysis.
    pub basis: Basis,
    /// For each step, the steps that can be active together with it.
    pub together: Vec<Bits>,
    /// The pairs that can be active together.
    pub pairs: Vec<Pair>,
    /// The structural faults.
    pub findings: Vec<Finding>,
}

impl Analysis {
    /// Whether it is proved that two steps are never active together.
    #[must_use]
    pub fn are_apart(&self, one: usize, other: usize) -> bool {
        !self.together[one].contains(other)
    }
}

/// Analyses a chart under the standard's rule ([`Rule::One`]). `budget` is the maximum number of markings.
#[must_use]
pub fn analyse(chart: &Chart, budget: usize) -> Analysis {
    analyse_by(chart, budget, Rule::One)
}

/// The maximum number of markings under [`Rule::All`], where many sets of transitions can fire.
pub const BUDGET_OF_ALL: usize = 10_000;

/// Which transitions fire if several compete for a step and are true.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// One of them, as the standard requires.
    One,
    /// All of them, except where all have priorities.
    All,
}

/// Analyses a chart under this rule. Its structural faults are always determined under the standard's rule.
#[must_use]
pub fn analyse_by(chart: &Chart, budget: usize, rule: Rule) -> Analysis {
    let mut net = chart.net();
    let mut reached = reach(&net, budget);
    let mut analysis = of_steps(&net, &reached);
    let actions = Running::all(chart);
    findings(chart, &net, &actions, &reached, &mut analysis);
    let has_priorities = chart.transitions.iter().any(|one| one.has_priority());
    if rule == Rule::All && (chart.competes() || has_priorities) {
        net = chart.net_of_all(&|_, _| false);
        reached = reach(&net, budget.min(BUDGET_OF_ALL));
        (analysis.basis, analysis.together) = together(&net, &reached);
    }
    let together = &analysis.together;
    // Each stored action is searched alone, and each pair of them together.
    let stored = actions.iter().filter(|one| one.is_stored()).count();
    let budget = budget.min(PAIRS_BUDGET / (stored * (stored + 1) / 2).max(1));
    analysis.pairs = Pairing { net: &net, reached: &reached, together, budget }.pairs(&actions);
    analysis
}

/// Only the structural faults of a chart.
#[must_use]
pub fn faults(chart: &Chart, budget: usize) -> Vec<Finding> {
    let net = chart.net();
    let reached = reach(&net, budget);
    let mut analysis = of_steps(&net, &reached);
    findings(chart, &net, &Running::all(chart), &reached, &mut analysis);
    analysis.findings
}

/// Which steps of a chart can be active together on any controller; pairs and faults are left empty.
#[must_use]
pub fn steps_together(chart: &Chart, budget: usize) -> Analysis {
    steps_together_in(&chart.net_of_any(), budget)
}

/// Like [`steps_together`], for a given net of the chart.
#[must_use]
pub fn steps_together_in(net: &Net, budget: usize) -> Analysis {
    of_steps(net, &reach(net, budget))
}

fn of_steps(net: &Net, reached: &Reachability) -> Analysis {
    let (basis, together) = together(net, reached);
    Analysis { basis, together, pairs: Vec::new(), findings: Vec::new() }
}

fn together(net: &Net, reached: &Reachability) -> (Basis, Vec<Bits>) {
    let all = || {
        let everything: Vec<usize> = (0..net.places).collect();
        vec![Bits::of(net.places, &everything); net.places]
    };
    // If transitions that share a place can fire together, markings with double entry are searched as well, so such a
    // net needs no safety.
    if !reached.unsafe_places.is_empty() && !net.shares() {
        return (Basis::Unsafe(reached.markings), all());
    }
    if reached.complete {
        return (Basis::Markings(reached.markings), reached.together.clone());
    }
    if net.shares() {
        return (Basis::Open(reached.markings), all());
    }
    let mut together = all();
    for group in exclusive(net, ROWS) {
        for &one in &group {
            group
                .iter()
                .filter(|&&other| other != one)
                .for_each(|&other| together[one].remove(other));
        }
    }
    (Basis::Invariants(reached.markings), together)
}

fn findings(
    chart: &Chart,
    net: &Net,
    actions: &[Running],
    reached: &Reachability,
    analysis: &mut Analysis,
) {
    let found = &mut analysis.findings;
    for one in &reached.unsafe_places {
        found.push(Finding::EnteredTwice(one.place, one.path.clone()));
    }
    found.extend(
        (0..chart.steps.len())
            .filter(|&step| reached.is_unreachable(step))
            .map(Finding::NeverActive),
    );
    for (at, transition) in chart.transitions.iter().enumerate() {
        let is_reached = transition.from.iter().all(|&step| !reached.is_unreachable(step));
        if reached.complete && !reached.enabled.contains(at) && is_reached {
            found.push(match in_vain(&net.transitions[at], reached) {
                Some(flags) => Finding::NeverTrue(at, flags),
                None => Finding::NeverClears(at),
            });
        }
    }
    let mut left = Bits::new(chart.steps.len());
    chart.transitions.iter().flat_map(|one| &one.from).for_each(|&step| left.insert(step));
    for dead in &reached.deadlocks {
        // A single final step of a chart that runs once is not a fault.
        let steps: Vec<usize> = dead.marking.iter().collect();
        let waits = steps.iter().any(|&step| left.contains(step));
        if waits || steps.is_empty() {
            found.push(Finding::Deadlock(steps, dead.path.clone()));
        }
    }
    for action in actions.iter().filter(|one| one.is_stored() && one.until.is_empty()) {
        found.push(Finding::NeverReset(action.name.clone(), action.by.clone()));
    }
}

/// The required step flags that prevent a transition from firing: the first that never has the required value while its
/// preceding steps are active, or, if there is none, all of them. `None` if its steps are never active together.
fn in_vain(one: &Transition, reached: &Reachability) -> Option<Vec<(usize, bool)>> {
    let with =
        reached.visited().filter(|marking| one.inputs.iter().all(|&step| marking.contains(step)));
    let with: Vec<&Bits> = with.collect();
    if with.is_empty() {
        return None;
    }
    let asked = one.tested.iter().map(|&step| (step, true));
    let all: Vec<(usize, bool)> =
        asked.chain(one.inhibitors.iter().map(|&step| (step, false))).collect();
    let never =
        |&&(step, is): &&(usize, bool)| with.iter().all(|marking| marking.contains(step) != is);
    let alone: Vec<(usize, bool)> = all.iter().filter(never).copied().collect();
    Some(if alone.is_empty() { all } else { vec![alone[0]] })
}

/// The steps that store an action, by their indices.
#[must_use]
pub fn storing(chart: &Chart, action: &str) -> Vec<usize> {
    let own = chart.blocks_of(action).filter(|(_, block)| block.qualifier.is_stored());
    own.map(|(step, _)| step).collect()
}

/// The steps that reset an action, by their indices.
#[must_use]
pub fn resetting(chart: &Chart, action: &str) -> Vec<usize> {
    let own = chart.blocks_of(action).filter(|(_, block)| block.qualifier == Qualifier::R);
    own.map(|(step, _)| step).collect()
}

/// The steps that are never active while the action is stored. Empty if it is not a stored action or the search exceeds
/// `budget`.
#[must_use]
pub fn apart_while_stored(chart: &Chart, net: &Net, action: &str, budget: usize) -> Vec<usize> {
    let own = Running::all(chart).into_iter().find(|one| crate::same(&one.name, action));
    let Some(own) = own.filter(Running::is_stored) else { return Vec::new() };
    let mut beside = Bits::new(chart.steps.len());
    let ways = Stored::new(net, &[&own]).follow(budget, &mut |(marking, stored), _| {
        if stored[0] {
            beside.union_with(marking);
        }
    });
    let all = 0..chart.steps.len();
    if ways.complete { all.filter(|&step| !beside.contains(step)).collect() } else { Vec::new() }
}

/// The state space of a net with stored actions: a marking, and for each action whether it is stored.
struct Stored<'a> {
    actions: &'a [&'a Running],
    net: &'a Net,
}

/// A marking, and for each action whether it is stored.
type State = (Bits, Vec<bool>);
/// A callback that receives a state and its number.
type Seen<'a> = dyn FnMut(&State, usize) + 'a;

/// The states found, with the way each was reached.
struct Ways {
    /// For each state, the number of the preceding state and the transitions that fired; `None` for initial states.
    before: Vec<Option<(usize, Vec<usize>)>>,
    /// Whether all reachable states were found.
    complete: bool,
}

impl Ways {
    /// The transitions from the initial situation to a state.
    fn path(&self, mut state: usize) -> Vec<usize> {
        let mut path = Vec::new();
        while let Some((before, set)) = &self.before[state] {
            path.extend(set.iter().rev());
            state = *before;
        }
        path.reverse();
        path
    }
}

impl<'a> Stored<'a> {
    fn new(net: &'a Net, actions: &'a [&'a Running]) -> Stored<'a> {
        Stored { actions, net }
    }

    /// The possible states of the stored actions after a marking has been reached.
    fn settle(&self, marking: &Bits, before: &[bool]) -> Vec<Vec<bool>> {
        let mut all: Vec<Vec<bool>> = vec![Vec::new()];
        for (action, &was) in self.actions.iter().zip(before) {
            let is_set = action.by.iter().any(|&step| marking.contains(step));
            let is_reset = action.until.iter().any(|&step| marking.contains(step));
            let options: &[bool] = match (is_reset, is_set, action.at_once) {
                (true, ..) => &[false],
                (false, true, true) => &[true],
                (false, true, false) => &[was, true],
                (false, false, _) => &[was],
            };
            all = all
                .into_iter()
                .flat_map(|state| options.iter().map(move |&one| [&state[..], &[one]].concat()))
                .collect();
        }
        all.sort();
        all.dedup();
        all
    }

    /// Calls `see` for every reachable state, in breadth-first order, up to `budget` states.
    fn follow(&self, budget: usize, see: &mut Seen<'_>) -> Ways {
        let mut ways = Ways { before: Vec::new(), complete: true };
        let mut known: FxHashSet<State> = FxHashSet::default();
        let mut open: VecDeque<State> = VecDeque::new();
        let mut add = |ways: &mut Ways, open: &mut VecDeque<State>, state: State, from| {
            if ways.before.len() < budget && known.insert(state.clone()) {
                open.push_back(state);
                ways.before.push(from);
            }
        };
        let firing = self.net.enabled_index();
        let start = self.net.start();
        for stored in self.settle(&start, &vec![false; self.actions.len()]) {
            add(&mut ways, &mut open, (start.clone(), stored), None);
        }
        let mut at = 0;
        while let Some(state) = open.pop_front() {
            see(&state, at);
            let moves = firing.next_steps(&state.0);
            ways.complete &= moves.is_some();
            for set in moves.unwrap_or_default() {
                let (next, _) = self.net.fire(&set, &state.0);
                for stored in self.settle(&next, &state.1) {
                    add(&mut ways, &mut open, (next.clone(), stored), Some((at, set.clone())));
                }
            }
            at += 1;
        }
        ways.complete &= ways.before.len() < budget;
        ways
    }
}

/// An action, and the steps that run, store or reset it.
struct Running {
    name: String,
    /// The steps whose action blocks or own code execute it.
    steps: Vec<usize>,
    /// The steps that store it.
    by: Vec<usize>,
    /// The steps that reset it.
    until: Vec<usize>,
    /// Whether all of its storing blocks store immediately; DS may do so later.
    at_once: bool,
}

impl Running {
    /// The actions of a chart, in the order of their first occurrence.
    fn all(chart: &Chart) -> Vec<Running> {
        let mut all: Vec<Running> = Vec::new();
        let mut known: BTreeMap<String, usize> = BTreeMap::new();
        let mut named = |name: String, all: &mut Vec<Running>| {
            let at = *known.entry(name.to_ascii_lowercase()).or_insert(all.len());
            if at == all.len() {
                let [steps, by, until] = [(); 3].map(|()| Vec::new());
                all.push(Running { name, steps, by, until, at_once: true });
            }
            at
        };
        for (step, own) in chart.steps.iter().enumerate() {
            // The step's own code (CODESYS), except that on exit.
            for path in [&own.entry, &own.active].into_iter().flatten() {
                let at = named(show::path(path), &mut all);
                all[at].run_at(step);
            }
            for block in &own.blocks {
                let at = named(block.target.name(), &mut all);
                let action = &mut all[at];
                if !matches!(block.qualifier, Qualifier::R | Qualifier::P0) {
                    action.run_at(step);
                }
                if block.qualifier.is_stored() {
                    action.by.push(step);
                    action.at_once &= block.qualifier != Qualifier::Ds;
                }
                if block.qualifier == Qualifier::R {
                    action.until.push(step);
                }
            }
        }
        all
    }

    /// Adds a step that runs the action.
    fn run_at(&mut self, step: usize) {
        if self.steps.last() != Some(&step) {
            self.steps.push(step);
        }
    }

    fn is_stored(&self) -> bool {
        !self.by.is_empty()
    }

    /// The reason for pairs of this action if it is stored.
    fn how(&self) -> How {
        How::Stored { by: self.by.clone(), until: self.until.clone() }
    }

    /// Whether one of its own steps is active in the marking.
    fn is_stepped(&self, marking: &Bits) -> bool {
        self.steps.iter().any(|&step| marking.contains(step))
    }
}

/// The situations in which an action is stored.
struct Lasting {
    /// For each step that can be active while the action is stored, the first such state.
    seen: BTreeMap<usize, usize>,
    ways: Ways,
}

impl Lasting {
    /// A shortest path to one of these steps while the action is stored. `None`: impossible; `Some(None)`: not found,
    /// but the search was incomplete.
    fn way_to(&self, steps: &[usize]) -> Option<Option<Vec<usize>>> {
        let first = steps.iter().filter_map(|step| self.seen.get(step)).min();
        match first {
            Some(&at) => Some(Some(self.ways.path(at))),
            // An incomplete search does not exclude it.
            None => (!self.ways.complete).then_some(None),
        }
    }
}

/// Determines the pairs that can be active together.
struct Pairing<'a> {
    net: &'a Net,
    reached: &'a Reachability,
    /// For each step, the steps that can be active together with it.
    together: &'a [Bits],
    /// The maximum number of markings searched for each pair.
    budget: usize,
}

impl Pairing<'_> {
    fn pairs(&self, all: &[Running]) -> Vec<Pair> {
        let lasting: Vec<Option<Lasting>> = all.iter().map(|one| self.lasting(one)).collect();
        let mut pairs = Vec::new();
        for (at, (action, own)) in all.iter().zip(&lasting).enumerate() {
            pairs.extend(self.with_steps(action, own.as_ref()));
            let others = all.iter().zip(&lasting).skip(at + 1);
            let both = |(two, other): (&Running, &Option<Lasting>)| {
                self.of_two((action, own.as_ref()), (two, other.as_ref()))
            };
            pairs.extend(others.filter_map(both));
        }
        pairs
    }

    /// The situations in which an action is stored; `None` if no block stores it.
    fn lasting(&self, action: &Running) -> Option<Lasting> {
        if !action.is_stored() {
            return None;
        }
        let mut seen = BTreeMap::new();
        let ways =
            Stored::new(self.net, &[action]).follow(self.budget, &mut |(marking, stored), at| {
                if stored[0] {
                    for step in marking.iter() {
                        seen.entry(step).or_insert(at);
                    }
                }
            });
        Some(Lasting { seen, ways })
    }

    /// The pairs of the action with steps that do not run it themselves.
    fn with_steps(&self, action: &Running, lasting: Option<&Lasting>) -> Vec<Pair> {
        let others = (0..self.net.places).filter(|step| !action.steps.contains(step));
        let pair = |step: usize| {
            let parallel = action.steps.iter().find(|&&own| self.together[own].contains(step));
            let (how, path) = match (parallel, lasting) {
                (Some(&own), _) => (How::Parallel, self.reached.path_to(&[own, step])),
                (None, Some(lasting)) => (action.how(), lasting.way_to(&[step])?),
                (None, None) => return None,
            };
            Some(Pair { action: action.name.clone(), other: Other::Step(step), how, path })
        };
        others.filter_map(pair).collect()
    }

    /// The pair of two actions, if they can be active together.
    fn of_two(
        &self,
        (one, first): (&Running, Option<&Lasting>),
        (two, second): (&Running, Option<&Lasting>),
    ) -> Option<Pair> {
        let pair = |how, path| {
            let other = Other::Action(two.name.clone());
            Some(Pair { action: one.name.clone(), other, how, path })
        };
        if let Some(step) = one.steps.iter().find(|step| two.steps.contains(step)) {
            return pair(How::SameStep, self.reached.path_to(&[*step]));
        }
        let parallel = one.steps.iter().flat_map(|&a| two.steps.iter().map(move |&b| [a, b]));
        if let Some(steps) = { parallel }.find(|&[a, b]| self.together[a].contains(b)) {
            return pair(How::Parallel, self.reached.path_to(&steps));
        }
        match (first, second) {
            (None, None) => None,
            (Some(lasting), None) => pair(one.how(), lasting.way_to(&two.steps)?),
            (None, Some(lasting)) => pair(two.how(), lasting.way_to(&one.steps)?),
            (Some(_), Some(_)) => self.of_two_stored(one, two),
        }
    }

    /// Like `of_two`, for two stored actions.
    fn of_two_stored(&self, one: &Running, two: &Running) -> Option<Pair> {
        let actions = [one, two];
        // The first action that stays stored after its steps, and the state.
        let mut found = None;
        let ways =
            Stored::new(self.net, &actions).follow(self.budget, &mut |(marking, stored), at| {
                let stepped = actions.map(|action| action.is_stepped(marking));
                let runs = (stored[0] || stepped[0]) && (stored[1] || stepped[1]);
                if runs && found.is_none() {
                    found = Some((if stored[0] && !stepped[0] { one } else { two }, at));
                }
            });
        let (lasting, path) = match found {
            Some((lasting, at)) => (lasting, Some(ways.path(at))),
            None if ways.complete => return None,
            // An incomplete search does not exclude it.
            None => (one, None),
        };
        let (action, other) = (one.name.clone(), Other::Action(two.name.clone()));
        Some(Pair { action, other, how: lasting.how(), path })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Body;
    use crate::parse::file;

    fn chart(text: &str) -> Chart {
        let project = file("a.st", &format!("PROGRAM p {text} END_PROGRAM")).expect("a chart");
        let Body::Chart(chart) = project.pous[0].body.clone() else { panic!("a chart") };
        *chart
    }

    const STORED: &str = "
        INITIAL_STEP s0: END_STEP
        STEP s1: m(S); END_STEP
        STEP s2: v(N); END_STEP
        STEP s3: m(R); END_STEP
        TRANSITION FROM s0 TO s1 := a; END_TRANSITION
        TRANSITION FROM s1 TO s2 := b; END_TRANSITION
        TRANSITION FROM s2 TO s3 := c; END_TRANSITION
        TRANSITION FROM s3 TO s0 := d; END_TRANSITION";

    #[test]
    fn a_stored_action_runs_beside_the_steps_up_to_its_reset() {
        let analysis = analyse(&chart(STORED), BUDGET);
        assert_eq!(analysis.basis, Basis::Markings(4));
        assert!(analysis.findings.is_empty(), "{:?}", analysis.findings);
        let how = How::Stored { by: vec![1], until: vec![3] };
        let pair = |other, path| Pair { action: "m".to_owned(), other, how: how.clone(), path };
        assert_eq!(
            analysis.pairs,
            [
                pair(Other::Step(2), Some(vec![0, 1])),
                pair(Other::Action("v".to_owned()), Some(vec![0, 1])),
            ]
        );
    }

    #[test]
    fn what_is_never_reset_goes_on_and_is_told() {
        let analysis = analyse(&chart(&STORED.replace("m(R);", "")), BUDGET);
        assert_eq!(analysis.findings, [Finding::NeverReset("m".to_owned(), vec![1])]);
        let steps: Vec<_> = analysis.pairs.iter().map(|pair| pair.other.clone()).collect();
        let all = [Other::Step(0), Other::Step(2), Other::Step(3), Other::Action("v".to_owned())];
        assert_eq!(steps, all);
    }

    #[test]
    fn joins_that_can_never_be_and_steps_entered_twice_are_found() {
        let text = "
            INITIAL_STEP a: END_STEP STEP b: END_STEP STEP c: END_STEP STEP d: END_STEP
            TRANSITION FROM a TO b := x; END_TRANSITION
            TRANSITION FROM a TO c := y; END_TRANSITION
            TRANSITION FROM (b, c) TO d := TRUE; END_TRANSITION";
        let analysis = analyse(&chart(text), BUDGET);
        assert_eq!(
            analysis.findings,
            [
                Finding::NeverActive(3),
                Finding::NeverClears(2),
                Finding::Deadlock(vec![1], vec![0]),
                Finding::Deadlock(vec![2], vec![1]),
            ]
        );
        let text = "
            INITIAL_STEP a: END_STEP STEP b: END_STEP STEP c: END_STEP
            TRANSITION FROM a TO (b, c) := x; END_TRANSITION
            TRANSITION FROM b TO a := y; END_TRANSITION
            TRANSITION FROM c TO a := y; END_TRANSITION";
        let analysis = analyse(&chart(text), BUDGET);
        assert!(matches!(analysis.basis, Basis::Unsafe(_)));
        assert!(matches!(analysis.findings[0], Finding::EnteredTwice(..)));
        assert!(!analysis.are_apart(1, 2));
    }

    #[test]
    fn beyond_the_budget_invariants_tell_what_is_apart() {
        let exact = analyse(&chart(STORED), BUDGET);
        let rough = analyse(&chart(STORED), 2);
        assert!(matches!(rough.basis, Basis::Invariants(2)));
        for one in 0..4 {
            for other in 0..4 {
                assert!(exact.are_apart(one, other) || !rough.are_apart(one, other));
                assert_eq!(rough.are_apart(one, other), one != other);
            }
        }
        // An incomplete search excludes nothing that it has not seen.
        assert!(rough.pairs.len() >= exact.pairs.len());
    }
}

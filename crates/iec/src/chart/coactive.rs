//! Which steps and actions can be active at the same time, by parallel sequences and by stored actions alike; and what
//! is wrong with how a chart hangs together.

use super::{Chart, Qualifier};
use crate::show;
use rustc_hash::FxHashSet;
use scanbound_nets::invariant::exclusive;
use scanbound_nets::reach::{Reachability, reach};
use scanbound_nets::{Bits, Net, Transition};
use std::collections::{BTreeMap, VecDeque};

/// How many markings are looked at.
pub const BUDGET: usize = 100_000;
/// How many markings are looked at for all pairs of actions together.
const PAIRS_BUDGET: usize = 1_000_000;
/// How many rows place invariants may take.
const ROWS: usize = 5_000;

/// What can be active together with an action.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Other {
    /// A step.
    Step(usize),
    /// Another action.
    Action(String),
}

/// How two come to be active together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum How {
    /// Their steps stand in different branches of a parallel.
    Parallel,
    /// They belong to the same step.
    SameStep,
    /// The action is stored: by these steps, until one of those is active.
    Stored {
        /// The steps that store.
        by: Vec<usize>,
        /// The steps that reset.
        until: Vec<usize>,
    },
}

/// An action, and what can be active together with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pair {
    /// The action.
    pub action: String,
    /// The other.
    pub other: Other,
    /// How.
    pub how: How,
    /// The transitions that lead there from the start; `None` where the search was cut off before it found a way.
    pub path: Option<Vec<usize>>,
}

/// Something wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Finding {
    /// A step is entered while it is active, on this way.
    EnteredTwice(usize, Vec<usize>),
    /// A step is never active.
    NeverActive(usize),
    /// A transition never clears, since its steps are never active together.
    NeverClears(usize),
    /// A transition never clears, since its condition asks for step flags that are never so while its steps are active:
    /// the steps, and whether each is to be active.
    NeverTrue(usize, Vec<(usize, bool)>),
    /// Steps that are active, and that no transition leads out of, on this way.
    Deadlock(Vec<usize>, Vec<usize>),
    /// An action is stored by these steps, and no step resets it.
    NeverReset(String, Vec<usize>),
}

/// On what the answers rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// All markings were seen.
    Markings(usize),
    /// There are more markings than this; place invariants tell what is never together, the rest may be.
    Invariants(usize),
    /// There are more markings than this, and nothing else tells what excludes what.
    Open(usize),
    /// The chart is not safe, so nothing excludes anything.
    Unsafe(usize),
}

/// What was found of a chart.
#[derive(Debug, Clone)]
pub struct Analysis {
    /// On what it rests.
    pub basis: Basis,
    /// For each step, the steps that can be active together with it.
    pub together: Vec<Bits>,
    /// The pairs.
    pub pairs: Vec<Pair>,
    /// What is wrong.
    pub findings: Vec<Finding>,
}

impl Analysis {
    /// Whether two steps are known never to be active together.
    #[must_use]
    pub fn are_apart(&self, one: usize, other: usize) -> bool {
        !self.together[one].contains(other)
    }
}

/// Studies a chart.
#[must_use]
pub fn analyse(chart: &Chart, budget: usize) -> Analysis {
    analyse_by(chart, budget, Rule::One)
}

/// So many markings are followed where all of competing transitions clear: there are many sets of these.
pub const BUDGET_OF_ALL: usize = 10_000;

/// Which of transitions clear that compete for a step and are true.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// One of them, as the standard has it.
    One,
    /// All, but for those that all have priorities.
    All,
}

/// Studies a chart by a rule of evolution. What is wrong with it is told by the standard's.
#[must_use]
pub fn analyse_by(chart: &Chart, budget: usize, rule: Rule) -> Analysis {
    let mut net = chart.net();
    let mut reached = reach(&net, budget);
    let mut analysis = of_steps(&net, &reached);
    let actions = Running::all(chart);
    findings(chart, &net, &actions, &reached, &mut analysis);
    let has_priorities = chart.transitions.iter().any(|one| one.has_priority);
    if rule == Rule::All && (chart.competes() || has_priorities) {
        net = chart.net_of_all(&|_, _| false);
        reached = reach(&net, budget.min(BUDGET_OF_ALL));
        (analysis.basis, analysis.together) = together(&net, &reached);
    }
    let together = &analysis.together;
    // Each stored action is followed by itself, and each two of them together.
    let stored = actions.iter().filter(|one| one.is_stored()).count();
    let budget = budget.min(PAIRS_BUDGET / (stored * (stored + 1) / 2).max(1));
    analysis.pairs = Pairing { net: &net, reached: &reached, together, budget }.pairs(&actions);
    analysis
}

/// What is wrong with how a chart hangs together, and nothing of what is active together.
#[must_use]
pub fn faults(chart: &Chart, budget: usize) -> Vec<Finding> {
    let net = chart.net();
    let reached = reach(&net, budget);
    let mut analysis = of_steps(&net, &reached);
    findings(chart, &net, &Running::all(chart), &reached, &mut analysis);
    analysis.findings
}

/// Which steps of a chart can be active together on any controller, and nothing of actions or faults.
#[must_use]
pub fn steps_together(chart: &Chart, budget: usize) -> Analysis {
    steps_together_in(&chart.net_of_any(), budget)
}

/// The same by a net of the chart.
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
    // Where transitions fire in sets that share what they take, every marking is seen, also those that are entered
    // twice.
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
        // A single step at the end of a chart that runs once is no fault of its structure.
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

/// The step flags that a transition asks for in vain while its steps are active: those of which each never is so, or
/// else all; nothing if its steps are never active together.
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

/// The steps that store an action.
#[must_use]
pub fn storing(chart: &Chart, action: &str) -> Vec<usize> {
    let own = chart.blocks_of(action).filter(|(_, block)| block.qualifier.is_stored());
    own.map(|(step, _)| step).collect()
}

/// The steps that reset it.
#[must_use]
pub fn resetting(chart: &Chart, action: &str) -> Vec<usize> {
    let own = chart.blocks_of(action).filter(|(_, block)| block.qualifier == Qualifier::R);
    own.map(|(step, _)| step).collect()
}

/// The steps that are never active while an action is stored, by a net of the chart.
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

/// How stored actions stand: for each of some actions, whether it is stored.
struct Stored<'a> {
    actions: &'a [&'a Running],
    net: &'a Net,
}

/// A marking, and which actions are stored in it.
type State = (Bits, Vec<bool>);
/// Is shown a state and its number.
type Seen<'a> = dyn FnMut(&State, usize) + 'a;

/// The states that were seen, by how each was reached.
struct Ways {
    /// For each state the number of the one before it, and the transitions between.
    before: Vec<Option<(usize, Vec<usize>)>>,
    /// Whether these are all.
    complete: bool,
}

impl Ways {
    /// The transitions that lead to a state.
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

    /// What can become of stored actions in a marking.
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

    /// Shows every state that can be reached, in the order of their distance from the start.
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

/// An action, and the steps with which it runs.
struct Running {
    name: String,
    /// The steps during which it can run by itself.
    steps: Vec<usize>,
    /// Those that store it.
    by: Vec<usize>,
    /// Those that reset it.
    until: Vec<usize>,
    /// Whether those that store it do so at once, or may do so later.
    at_once: bool,
}

impl Running {
    /// The actions of a chart, in the order in which they first occur.
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
            // What a step itself does (CODESYS), but for what comes when it has ended.
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

    /// It runs while a step is active.
    fn run_at(&mut self, step: usize) {
        if self.steps.last() != Some(&step) {
            self.steps.push(step);
        }
    }

    fn is_stored(&self) -> bool {
        !self.by.is_empty()
    }

    /// How it comes to run with others if it is stored.
    fn how(&self) -> How {
        How::Stored { by: self.by.clone(), until: self.until.clone() }
    }

    /// Whether one of its own steps is active.
    fn is_stepped(&self, marking: &Bits) -> bool {
        self.steps.iter().any(|&step| marking.contains(step))
    }
}

/// Where an action is stored.
struct Lasting {
    /// For each step that is active while it is, the first state in which it is so.
    seen: BTreeMap<usize, usize>,
    ways: Ways,
}

impl Lasting {
    /// A shortest way to one of these steps while the action is stored, if one was seen; `None` if there is none.
    fn way_to(&self, steps: &[usize]) -> Option<Option<Vec<usize>>> {
        let first = steps.iter().filter_map(|step| self.seen.get(step)).min();
        match first {
            Some(&at) => Some(Some(self.ways.path(at))),
            // What was not seen may be all the same.
            None => (!self.ways.complete).then_some(None),
        }
    }
}

/// Finds what can run together.
struct Pairing<'a> {
    net: &'a Net,
    reached: &'a Reachability,
    /// Which steps can be active together with each.
    together: &'a [Bits],
    /// How many markings are looked at for each pair.
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

    /// Where an action is stored, if it ever is.
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

    /// The steps of others that can be active while an action runs, and how.
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

    /// Whether two actions can run together, and how.
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

    /// The same of two that are stored.
    fn of_two_stored(&self, one: &Running, two: &Running) -> Option<Pair> {
        let actions = [one, two];
        // The first of the two that goes on after its steps, and where.
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
            // What was not seen may be all the same.
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
        // What was not seen is not denied.
        assert!(rough.pairs.len() >= exact.pairs.len());
    }
}

//! Which steps and actions can be active at the same time, by parallel sequences and by stored actions alike; and what is
//! wrong with how a chart hangs together.

use super::{Chart, Qualifier};
use crate::net::invariant::exclusive;
use crate::net::reach::{Reached, reach};
use crate::net::{Bits, Net, Transition};
use std::collections::BTreeMap;

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
    /// They hang on the same step.
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
    /// A transition never clears, since its condition asks for step flags that are never so while its steps are active: the
    /// steps, and whether each is to be active.
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
        !self.together[one].has(other)
    }
}

/// Studies a chart.
#[must_use]
pub fn analyse(chart: &Chart, budget: usize) -> Analysis {
    analyse_by(chart, budget, Rule::One)
}

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
    findings(chart, &net, &reached, &mut analysis);
    if rule == Rule::All && chart.competes() {
        net = chart.net_of_all();
        reached = reach(&net, budget);
        (analysis.basis, analysis.together) = together(&net, &reached);
    }
    let together = &analysis.together;
    // Many actions have many pairs, and each is followed by itself.
    let pairs = chart.actions().len() * (chart.actions().len() + 1) / 2;
    let budget = budget.min(PAIRS_BUDGET / pairs.max(1));
    analysis.pairs = Pairing { chart, net: &net, reached: &reached, together, budget }.pairs();
    analysis
}

/// What is wrong with how a chart hangs together, and nothing of what is active together.
#[must_use]
pub fn faults(chart: &Chart, budget: usize) -> Vec<Finding> {
    let net = chart.net();
    let reached = reach(&net, budget);
    let mut analysis = of_steps(&net, &reached);
    findings(chart, &net, &reached, &mut analysis);
    analysis.findings
}

/// Which steps of a chart can be active together, and nothing of actions or faults.
#[must_use]
pub fn steps_together(chart: &Chart, budget: usize) -> Analysis {
    let net = chart.net();
    of_steps(&net, &reach(&net, budget))
}

fn of_steps(net: &Net, reached: &Reached) -> Analysis {
    let (basis, together) = together(net, reached);
    Analysis { basis, together, pairs: Vec::new(), findings: Vec::new() }
}

fn together(net: &Net, reached: &Reached) -> (Basis, Vec<Bits>) {
    let all = || {
        let everything: Vec<usize> = (0..net.places).collect();
        vec![Bits::of(net.places, &everything); net.places]
    };
    // Where transitions fire in sets that share what they take, every marking is seen, also those that are entered twice.
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

fn findings(chart: &Chart, net: &Net, reached: &Reached, analysis: &mut Analysis) {
    let found = &mut analysis.findings;
    for one in &reached.unsafe_places {
        found.push(Finding::EnteredTwice(one.place, one.path.clone()));
    }
    found.extend(
        (0..chart.steps.len()).filter(|&step| reached.is_never(step)).map(Finding::NeverActive),
    );
    for (at, transition) in chart.transitions.iter().enumerate() {
        let is_reached = transition.from.iter().all(|&step| !reached.is_never(step));
        if reached.complete && !reached.enabled.has(at) && is_reached {
            found.push(match in_vain(&net.transitions[at], reached) {
                Some(flags) => Finding::NeverTrue(at, flags),
                None => Finding::NeverClears(at),
            });
        }
    }
    for dead in &reached.deadlocks {
        // A single step at the end of a chart that runs once is no fault of its structure.
        let steps: Vec<usize> = dead.marking.iter().collect();
        let waits =
            steps.iter().any(|step| chart.transitions.iter().any(|one| one.from.contains(step)));
        if waits || steps.is_empty() {
            found.push(Finding::Deadlock(steps, dead.path.clone()));
        }
    }
    for action in chart.actions() {
        let stores = storing(chart, &action);
        if !stores.is_empty() && resetting(chart, &action).is_empty() {
            found.push(Finding::NeverReset(action, stores));
        }
    }
}

/// The step flags that a transition asks for in vain while its steps are active: those of which each never is so, or else
/// all; nothing if its steps are never active together.
fn in_vain(one: &Transition, reached: &Reached) -> Option<Vec<(usize, bool)>> {
    let with = reached.seen().filter(|marking| one.takes.iter().all(|&step| marking.has(step)));
    let with: Vec<&Bits> = with.collect();
    if with.is_empty() {
        return None;
    }
    let asked = one.needs.iter().map(|&step| (step, true));
    let all: Vec<(usize, bool)> = asked.chain(one.bars.iter().map(|&step| (step, false))).collect();
    let never = |&&(step, is): &&(usize, bool)| with.iter().all(|marking| marking.has(step) != is);
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

/// The steps that are never active while an action is stored.
#[must_use]
pub fn apart_while_stored(chart: &Chart, action: &str, budget: usize) -> Vec<usize> {
    if storing(chart, action).is_empty() {
        return Vec::new();
    }
    let net = chart.net();
    let mut beside = Bits::new(chart.steps.len());
    let complete =
        Stored::new(chart, &net, &[action]).follow(budget, &mut |(marking, stored), _| {
            if stored[0] {
                beside.join(marking);
            }
        });
    let all = 0..chart.steps.len();
    if complete { all.filter(|&step| !beside.has(step)).collect() } else { Vec::new() }
}

/// The steps during which an action can run by itself.
fn own_steps(chart: &Chart, action: &str) -> Vec<usize> {
    let runs = |kind| !matches!(kind, Qualifier::R | Qualifier::P0);
    let own = chart.blocks_of(action).filter(|(_, block)| runs(block.qualifier));
    let mut steps: Vec<usize> = own.map(|(step, _)| step).collect();
    steps.dedup();
    steps
}

/// How stored actions stand: for each of some actions, whether it is stored.
struct Stored<'a> {
    set: Vec<Vec<usize>>,
    /// Whether its storing steps store it at once, or may do so later.
    at_once: Vec<bool>,
    reset: Vec<Vec<usize>>,
    net: &'a Net,
}

/// A marking, and which actions are stored in it.
type State = (Bits, Vec<bool>);
/// A state, the one before it, and the transitions between.
type Visit = (State, Option<(usize, Vec<usize>)>);
/// Is shown a state, and can ask for the way there.
type Seen<'a> = dyn FnMut(&State, &dyn Fn() -> Vec<usize>) + 'a;

impl<'a> Stored<'a> {
    fn new(chart: &Chart, net: &'a Net, actions: &[&str]) -> Stored<'a> {
        let at_once = |action: &&str| {
            chart
                .blocks_of(action)
                .filter(|(_, block)| block.qualifier.is_stored())
                .all(|(_, block)| block.qualifier != Qualifier::Ds)
        };
        Stored {
            set: actions.iter().map(|action| storing(chart, action)).collect(),
            at_once: actions.iter().map(at_once).collect(),
            reset: actions.iter().map(|action| resetting(chart, action)).collect(),
            net,
        }
    }

    /// What can become of stored actions in a marking.
    fn settle(&self, marking: &Bits, before: &[bool]) -> Vec<Vec<bool>> {
        let mut all: Vec<Vec<bool>> = vec![Vec::new()];
        for (at, &was) in before.iter().enumerate() {
            let is_set = self.set[at].iter().any(|&step| marking.has(step));
            let is_reset = self.reset[at].iter().any(|&step| marking.has(step));
            let options: &[bool] = match (is_reset, is_set, self.at_once[at]) {
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

    /// Shows every state that can be reached, with the way there; whether these are all.
    fn follow(&self, budget: usize, see: &mut Seen<'_>) -> bool {
        let actions = self.set.len();
        let mut nodes: Vec<Visit> = Vec::new();
        let mut complete = true;
        let mut known = BTreeMap::new();
        let mut add = |nodes: &mut Vec<Visit>, state: State, from| {
            if nodes.len() < budget && known.insert(state.clone(), ()).is_none() {
                nodes.push((state, from));
            }
        };
        let start = self.net.start();
        for stored in self.settle(&start, &vec![false; actions]) {
            add(&mut nodes, (start.clone(), stored), None);
        }
        let mut at = 0;
        while at < nodes.len() {
            let state = nodes[at].0.clone();
            let way = || {
                let (mut path, mut node) = (Vec::new(), at);
                while let Some((before, set)) = &nodes[node].1 {
                    path.extend(set.iter().rev());
                    node = *before;
                }
                path.reverse();
                path
            };
            see(&state, &way);
            let moves = self.net.moves(&state.0);
            complete &= moves.is_some();
            for set in moves.unwrap_or_default() {
                let (next, _) = self.net.fire(&set, &state.0);
                for stored in self.settle(&next, &state.1) {
                    add(&mut nodes, (next.clone(), stored), Some((at, set.clone())));
                }
            }
            at += 1;
        }
        complete && nodes.len() < budget
    }
}

/// An action, and the steps with which it runs.
struct Running {
    name: String,
    /// Its own steps.
    steps: Vec<usize>,
    /// Those that store it.
    by: Vec<usize>,
    /// How it comes to run with others if it is stored.
    how: How,
}

impl Running {
    fn all(chart: &Chart) -> Vec<Running> {
        let running = |name: String| {
            let (steps, by) = (own_steps(chart, &name), storing(chart, &name));
            let how = How::Stored { by: by.clone(), until: resetting(chart, &name) };
            Running { name, steps, by, how }
        };
        chart.actions().into_iter().map(running).collect()
    }

    fn is_stored(&self) -> bool {
        !self.by.is_empty()
    }

    /// Whether one of its own steps is active.
    fn is_stepped(&self, marking: &Bits) -> bool {
        self.steps.iter().any(|&step| marking.has(step))
    }
}

/// Finds what can run together.
struct Pairing<'a> {
    chart: &'a Chart,
    net: &'a Net,
    reached: &'a Reached,
    /// Which steps can be active together with each.
    together: &'a [Bits],
    /// How many markings are looked at for each pair.
    budget: usize,
}

impl Pairing<'_> {
    fn pairs(&self) -> Vec<Pair> {
        let all = Running::all(self.chart);
        let mut pairs = Vec::new();
        for (at, action) in all.iter().enumerate() {
            pairs.extend(self.with_steps(action));
            pairs.extend(all[at + 1..].iter().filter_map(|other| self.of_two(action, other)));
        }
        pairs
    }

    /// The steps of others that can be active while an action runs, and how.
    fn with_steps(&self, action: &Running) -> Vec<Pair> {
        // A way to each step that is active while the action is stored.
        let mut stored_at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut complete = true;
        if action.is_stored() {
            let stored = Stored::new(self.chart, self.net, &[&action.name]);
            complete = stored.follow(self.budget, &mut |(marking, stored), way| {
                if stored[0] {
                    for step in marking.iter() {
                        stored_at.entry(step).or_insert_with(way);
                    }
                }
            });
        }
        let others = (0..self.chart.steps.len()).filter(|step| !action.steps.contains(step));
        let pair = |step: usize| {
            let parallel = action.steps.iter().find(|&&own| self.together[own].has(step));
            let (how, path) = match (parallel, stored_at.get(&step)) {
                (Some(&own), _) => (How::Parallel, self.reached.way_to(&[own, step])),
                (None, Some(way)) => (action.how.clone(), Some(way.clone())),
                // What was not seen may be all the same.
                (None, None) if action.is_stored() && !complete => (action.how.clone(), None),
                (None, None) => return None,
            };
            Some(Pair { action: action.name.clone(), other: Other::Step(step), how, path })
        };
        others.filter_map(pair).collect()
    }

    /// Whether two actions can run together, and how.
    fn of_two(&self, one: &Running, two: &Running) -> Option<Pair> {
        let pair = |how, path| {
            let other = Other::Action(two.name.clone());
            Some(Pair { action: one.name.clone(), other, how, path })
        };
        if let Some(step) = one.steps.iter().find(|step| two.steps.contains(step)) {
            return pair(How::SameStep, self.reached.way_to(&[*step]));
        }
        let parallel = one.steps.iter().flat_map(|&a| two.steps.iter().map(move |&b| [a, b]));
        if let Some(steps) = { parallel }.find(|&[a, b]| self.together[a].has(b)) {
            return pair(How::Parallel, self.reached.way_to(&steps));
        }
        if !one.is_stored() && !two.is_stored() {
            return None;
        }
        let stored = Stored::new(self.chart, self.net, &[&one.name, &two.name]);
        // The first of the two that goes on after its steps, and the way there.
        let mut found = None;
        let complete = stored.follow(self.budget, &mut |(marking, stored), way| {
            let stepped = [one, two].map(|action| action.is_stepped(marking));
            let runs = (stored[0] || stepped[0]) && (stored[1] || stepped[1]);
            if runs && found.is_none() {
                let lasting = if stored[0] && !stepped[0] { one } else { two };
                found = Some((lasting, way()));
            }
        });
        match found {
            Some((lasting, path)) => pair(lasting.how.clone(), Some(path)),
            None if complete => None,
            // What was not seen may be all the same.
            None if one.is_stored() => pair(one.how.clone(), None),
            None => pair(two.how.clone(), None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iec::Body;
    use crate::iec::parse::file;

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

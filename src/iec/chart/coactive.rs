//! Which steps and actions can be active at the same time, by parallel sequences and by stored actions alike; and what is
//! wrong with how a chart hangs together.

use super::{Chart, Qualifier};
use crate::net::invariant::exclusive;
use crate::net::reach::{Reached, reach};
use crate::net::{Bits, Net};
use std::collections::BTreeMap;

/// How many markings are looked at.
pub const BUDGET: usize = 100_000;
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
    let net = chart.net();
    let reached = reach(&net, budget);
    let (basis, together) = together(&net, &reached);
    let mut analysis = Analysis { basis, together, pairs: Vec::new(), findings: Vec::new() };
    findings(chart, &reached, &mut analysis);
    pairs(chart, &net, &reached, budget, &mut analysis);
    analysis
}

fn together(net: &Net, reached: &Reached) -> (Basis, Vec<Bits>) {
    let all = || {
        let everything: Vec<usize> = (0..net.places).collect();
        vec![Bits::of(net.places, &everything); net.places]
    };
    if !reached.unsafe_places.is_empty() {
        return (Basis::Unsafe(reached.markings), all());
    }
    if reached.complete {
        return (Basis::Markings(reached.markings), reached.together.clone());
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

fn findings(chart: &Chart, reached: &Reached, analysis: &mut Analysis) {
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
            found.push(Finding::NeverClears(at));
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

fn pairs(chart: &Chart, net: &Net, reached: &Reached, budget: usize, analysis: &mut Analysis) {
    let actions = chart.actions();
    let own: Vec<Vec<usize>> = actions.iter().map(|action| own_steps(chart, action)).collect();
    let is_stored: Vec<bool> =
        actions.iter().map(|action| !storing(chart, action).is_empty()).collect();
    for (at, action) in actions.iter().enumerate() {
        let how = How::Stored { by: storing(chart, action), until: resetting(chart, action) };
        let mut first: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut complete = true;
        if is_stored[at] {
            let stored = Stored::new(chart, net, &[action]);
            complete = stored.follow(budget, &mut |(marking, stored), way| {
                if stored[0] {
                    for step in marking.iter() {
                        first.entry(step).or_insert_with(way);
                    }
                }
            });
        }
        for step in 0..chart.steps.len() {
            if own[at].contains(&step) {
                continue;
            }
            let beside = own[at].iter().find(|&&mine| analysis.together[mine].has(step));
            let pair = match beside {
                Some(&mine) => Some((How::Parallel, reached.way_to(&[mine, step]))),
                None if first.contains_key(&step) => Some((how.clone(), first.get(&step).cloned())),
                // What was not seen may be all the same.
                None if is_stored[at] && !complete => Some((how.clone(), None)),
                None => None,
            };
            let action = action.clone();
            let pair = pair.map(|(how, path)| Pair { action, other: Other::Step(step), how, path });
            analysis.pairs.extend(pair);
        }
        for (further, other) in actions.iter().enumerate().skip(at + 1) {
            let pair = both(
                chart,
                net,
                reached,
                budget,
                analysis,
                (at, action),
                (further, other),
                &own,
                &is_stored,
            );
            analysis.pairs.extend(pair);
        }
    }
}

/// Whether two actions can run together, and how.
#[allow(clippy::too_many_arguments)]
fn both(
    chart: &Chart,
    net: &Net,
    reached: &Reached,
    budget: usize,
    analysis: &Analysis,
    (at, action): (usize, &str),
    (further, other): (usize, &str),
    own: &[Vec<usize>],
    is_stored: &[bool],
) -> Option<Pair> {
    let pair = |how, path| {
        Some(Pair { action: action.to_owned(), other: Other::Action(other.to_owned()), how, path })
    };
    if let Some(step) = own[at].iter().find(|step| own[further].contains(step)) {
        return pair(How::SameStep, reached.way_to(&[*step]));
    }
    let beside = own[at].iter().flat_map(|&one| own[further].iter().map(move |&two| (one, two)));
    for (one, two) in beside {
        if analysis.together[one].has(two) {
            return pair(How::Parallel, reached.way_to(&[one, two]));
        }
    }
    if !is_stored[at] && !is_stored[further] {
        return None;
    }
    let stored = Stored::new(chart, net, &[action, other]);
    let mut found = None;
    let runs = |steps: &[usize], marking: &Bits| steps.iter().any(|&step| marking.has(step));
    let complete = stored.follow(budget, &mut |(marking, stored), way| {
        let one = stored[0] || runs(&own[at], marking);
        let two = stored[1] || runs(&own[further], marking);
        if one && two && found.is_none() {
            found = Some((stored[0] && !runs(&own[at], marking), way()));
        }
    });
    let cause = |first: bool| {
        let name = if first { action } else { other };
        How::Stored { by: storing(chart, name), until: resetting(chart, name) }
    };
    match found {
        Some((first, path)) => pair(cause(first), Some(path)),
        None if !complete => pair(cause(is_stored[at]), None),
        None => None,
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

//! The number of times that control can jump back within one turn of a group, found by a search over the states in
//! which its instructions can be executed.

use super::source::{Op, Routine, Source};
use petgraph::algo::condensation;
use petgraph::algo::toposort;
use petgraph::graph::{DiGraph, NodeIndex};
use std::collections::{BTreeMap, BTreeSet};

/// The largest total size of all states of the search. Beyond it, the search ends without a result.
const MAX_STATES: usize = 500_000;
/// The largest number of jumps back in one turn that is unrolled.
pub const MAX_BACK_JUMPS: usize = 64;

/// What is known when the instruction with index `at` is executed. A bit that is in no map may be on or off; a test
/// makes its value known, except that of an input without an image.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct State {
    at: usize,
    /// The condition that the tests so far have computed.
    holds: bool,
    /// The known values of outputs that the routine tests, and of inputs that have an image (known after a test).
    bits: BTreeMap<u32, bool>,
    /// The timers whose state is known: whether each was started in an earlier pass.
    timers: BTreeMap<u32, bool>,
}

/// An upper limit of the number of jumps back in one turn before the turn ends or repeats an earlier state; a turn with
/// more jumps back repeats without end. `None` if the limit would be above [`MAX_BACK_JUMPS`], or if there are too many
/// states to follow. `latched`: an input has one value during a turn, otherwise any value at each test.
#[must_use]
pub fn jumps_back(source: &Source, routine: &Routine, latched: bool) -> Option<usize> {
    let is_back =
        |at: usize| matches!(source.instructions[at].op, Op::Jump(to) | Op::JumpIf(to) if to <= at);
    if !routine.body.clone().any(is_back) {
        return Some(0);
    }
    let tested: BTreeSet<u32> = routine
        .body
        .clone()
        .filter_map(|at| match source.instructions[at].op {
            Op::And { bit, .. } => Some(bit),
            _ => None,
        })
        .collect();
    let direct = if latched { BTreeSet::new() } else { source.inputs() };
    let mut graph: DiGraph<(), usize> = DiGraph::new();
    let mut known: BTreeMap<State, NodeIndex> = BTreeMap::new();
    let mut open: Vec<State> = Vec::new();
    for at in source.positions(routine) {
        let state = State { at, holds: true, bits: BTreeMap::new(), timers: BTreeMap::new() };
        known.insert(state.clone(), graph.add_node(()));
        open.push(state);
    }
    let mut size = 0;
    while let Some(state) = open.pop() {
        size += 10 + state.bits.len() + state.timers.len();
        let from = known[&state];
        for next in successors(source, &tested, &direct, &state) {
            let back = usize::from(next.at <= state.at);
            let to = match known.get(&next) {
                Some(&node) => node,
                None => {
                    let node = graph.add_node(());
                    known.insert(next.clone(), node);
                    open.push(next);
                    node
                }
            };
            graph.add_edge(from, to, back);
        }
        if size > MAX_STATES {
            return None;
        }
    }
    Some(longest(graph)).filter(|&jumps| jumps <= MAX_BACK_JUMPS)
}

/// The largest number of jumps back on a path that uses each edge of the cycles of the graph at most once. The weight
/// of an edge is 1 if it is a jump back, otherwise 0.
fn longest(graph: DiGraph<(), usize>) -> usize {
    let member: BTreeMap<NodeIndex, usize> = petgraph::algo::kosaraju_scc(&graph)
        .into_iter()
        .enumerate()
        .flat_map(|(part, nodes)| nodes.into_iter().map(move |node| (node, part)))
        .collect();
    let mut within: BTreeMap<usize, usize> = BTreeMap::new();
    for edge in graph.raw_edges() {
        if member[&edge.source()] == member[&edge.target()] {
            *within.entry(member[&edge.source()]).or_default() += edge.weight;
        }
    }
    let numbered = graph.map(|node, ()| member[&node], |_, &back| back);
    let parts = condensation(numbered, true);
    let mut most = vec![0_usize; parts.node_count()];
    let order = toposort(&parts, None).expect("a condensed graph has no cycles");
    let mut longest = 0;
    for &node in &order {
        let own = parts[node].first().and_then(|part| within.get(part)).copied().unwrap_or(0);
        most[node.index()] += own;
        longest = longest.max(most[node.index()]);
        let here = most[node.index()];
        let mut walk = parts.neighbors(node).detach();
        while let Some((edge, next)) = walk.next(&parts) {
            most[next.index()] = most[next.index()].max(here + parts[edge]);
        }
    }
    longest
}

/// The states that can follow when the instruction of this state is executed. Empty if the turn ends there.
fn successors(
    source: &Source,
    tested: &BTreeSet<u32>,
    direct: &BTreeSet<u32>,
    state: &State,
) -> Vec<State> {
    let step = |mut state: State| {
        state.at += 1;
        state
    };
    let goes = |to: usize| State { at: to, holds: true, ..state.clone() };
    match source.instructions[state.at].op {
        Op::And { bit, negated } => {
            let values = state.bits.get(&bit).map_or(vec![false, true], |&value| vec![value]);
            let each = values.into_iter().map(|value| {
                let mut next = step(state.clone());
                if !direct.contains(&bit) {
                    next.bits.insert(bit, value);
                }
                next.holds &= value != negated;
                next
            });
            each.collect()
        }
        Op::Timer { timer, tenths } => {
            let mut all = Vec::new();
            let olds = state.timers.get(&timer).map_or(vec![false, true], |&old| vec![old]);
            for old in olds {
                let mut waits = step(state.clone());
                waits.timers.insert(timer, old);
                waits.holds = false;
                all.push(waits);
                if old || tenths == 0 {
                    let mut out = step(state.clone());
                    out.timers.insert(timer, false);
                    all.push(out);
                }
            }
            all
        }
        Op::Out { bit, on } => {
            let mut next = step(state.clone());
            if tested.contains(&bit) {
                next.bits.insert(bit, on);
            }
            vec![next]
        }
        Op::ResetTimer(timer) => {
            // The timer may keep its remaining time.
            let mut reset = step(state.clone());
            reset.timers.insert(timer, false);
            vec![reset, step(state.clone())]
        }
        Op::Jump(to) => vec![goes(to)],
        Op::JumpIf(to) if state.holds => vec![goes(to)],
        Op::JumpIf(_) => vec![goes(state.at + 1)],
        Op::Wait if state.holds => vec![goes(state.at + 1)],
        Op::Wait | Op::End(_) => Vec::new(),
        Op::Label(_) | Op::Groups | Op::Start(_) | Op::Stop(_) | Op::Head(_) => {
            vec![step(state.clone())]
        }
    }
}

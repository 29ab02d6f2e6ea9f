//! Explores all reachable states of a net for all values of outer gates: deadlocks, transitions that never fire,
//! blocked marks.

use super::step::Step;
use crate::rules::{Rules, State};
use crate::{Diagram, Direction};
use scanbound_nets::search::{Search, search};

/// The largest number of dead states that are shown with a run.
const SHOWN: usize = 5;

/// A state in which no transition can ever fire again, for any outer gates and after all timers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dead {
    /// The state.
    pub state: State,
    /// A shortest run to it from the initial marks.
    pub run: Vec<Step>,
    /// Whether an emergency stop can still fire, but nothing else.
    pub but_stop: bool,
    /// Whether the state is reached only after an emergency stop.
    pub is_after_stop: bool,
}

/// A transition that would put a second mark in a box, if the first mark did not block it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Held {
    /// The box.
    pub place: usize,
    /// The transition.
    pub transition: usize,
    /// A shortest run to a state where it is blocked.
    pub run: Vec<Step>,
}

/// The reachable states.
#[derive(Debug)]
pub struct Markings {
    /// The number of explored states.
    pub count: usize,
    /// Whether all states were explored.
    pub complete: bool,
    /// The number of dead states.
    pub dead_count: usize,
    /// The dead states with the shortest runs; those after emergency stops come last.
    pub dead: Vec<Dead>,
    /// Transitions that can never fire; empty if not all states were explored.
    pub never: Vec<usize>,
    /// Transitions that did not fire in any explored state, if not all states were explored.
    pub unseen: Vec<usize>,
    /// Transitions that are blocked by a mark in an output box.
    pub held: Vec<Held>,
}

/// The step of a number: transitions first, then timers.
fn step(rules: &Rules, number: u32) -> Step {
    let number = number as usize;
    number.checked_sub(rules.transitions()).map_or(Step::Fire(number), Step::RunOut)
}

/// The successors of a state; whether another transition than an emergency stop is enabled, and whether an emergency
/// stop is.
fn follow(
    diagram: &Diagram,
    rules: &Rules,
    state: &[u64],
    with_stops: bool,
    take: &mut dyn FnMut(u32, &[u64]),
) -> (bool, bool) {
    let (mut goes, mut stops) = (false, false);
    let mut next = state.to_vec();
    for at in 0..rules.transitions() {
        if rules.gates_to_fire(state, at).is_none() {
            continue;
        }
        let is_stop = diagram.transitions[at].is_stop;
        goes |= !is_stop;
        stops |= is_stop;
        if !is_stop || with_stops {
            next.copy_from_slice(state);
            rules.fire_in(&mut next, at);
            take(u32::try_from(at).unwrap_or(u32::MAX), &next);
        }
    }
    for place in (0..diagram.places.len()).filter(|&place| rules.is_running(state, place)) {
        goes = true;
        let number = rules.transitions() + place;
        take(u32::try_from(number).unwrap_or(u32::MAX), &rules.run_out(state, place));
    }
    (goes, stops)
}

/// Explores a net from its initial marks.
pub(super) fn explore(diagram: &Diagram, rules: &Rules, limit: usize) -> Markings {
    let has_stops = diagram.transitions.iter().any(|transition| transition.is_stop);
    let start = [rules.initial()];
    // First without emergency stops, to find the states that are dead without one.
    let mut calm: Vec<(usize, bool)> = Vec::new();
    let quiet = has_stops.then(|| {
        search(rules.width(), &start, limit, |at, state, take| {
            let (goes, stops) = follow(diagram, rules, state, false, take);
            if !goes {
                calm.push((at, stops));
            }
        })
    });
    let mut dead: Vec<(usize, bool)> = Vec::new();
    let mut fires = vec![false; rules.transitions()];
    let mut held: Vec<(usize, usize, usize)> = Vec::new();
    let mut is_held = vec![false; diagram.places.len()];
    let all = search(rules.width(), &start, limit, |at, state, take| {
        let (goes, stops) = follow(diagram, rules, state, true, &mut |number, next| {
            if let Some(fired) = fires.get_mut(number as usize) {
                *fired = true;
            }
            take(number, next);
        });
        if !goes {
            dead.push((at, stops));
        }
        for transition in 0..rules.transitions() {
            if !rules.is_held_back(state, transition) {
                continue;
            }
            for place in diagram.places_of(transition, Direction::OutOf) {
                if rules.is_marked(state, place) && !is_held[place] {
                    is_held[place] = true;
                    held.push((place, transition, at));
                }
            }
        }
    });
    let run = |search: &Search, at: usize| -> Vec<Step> {
        search.path(at).1.into_iter().map(|number| step(rules, number)).collect()
    };
    let shown = |search: &Search, found: &[(usize, bool)], is_after_stop: bool| -> Vec<Dead> {
        let one = |&(at, but_stop): &(usize, bool)| Dead {
            state: search.state(at).to_vec(),
            run: run(search, at),
            but_stop,
            is_after_stop,
        };
        found.iter().take(SHOWN).map(one).collect()
    };
    let mut told =
        shown(quiet.as_ref().unwrap_or(&all), if has_stops { &calm } else { &dead }, false);
    if let Some(quiet) = &quiet {
        let known: std::collections::BTreeSet<&[u64]> =
            calm.iter().map(|&(at, _)| quiet.state(at)).collect();
        let new = |&&(at, _): &&(usize, bool)| !known.contains(all.state(at));
        let behind: Vec<(usize, bool)> = dead.iter().filter(new).copied().collect();
        // If the first search is incomplete, more states may be dead without an emergency stop.
        told.extend(shown(&all, &behind, quiet.complete));
    }
    let silent = (0..rules.transitions()).filter(|&at| !fires[at]).collect();
    let (never, unseen) = if all.complete { (silent, Vec::new()) } else { (Vec::new(), silent) };
    Markings {
        count: all.len(),
        complete: all.complete,
        dead_count: dead.len(),
        dead: told,
        never,
        unseen,
        held: held
            .into_iter()
            .map(|(place, transition, at)| Held { place, transition, run: run(&all, at) })
            .collect(),
    }
}

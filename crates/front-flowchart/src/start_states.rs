//! The states in which a pass can begin, as formulas over the bits for routine positions, timers and outputs.

use scanbound_ir::{Cell, Logic};
use std::collections::{BTreeMap, BTreeSet};

/// The bits that hold the position of one routine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RoutinePositions {
    /// The bit that says whether the group runs; `None` for the main routine, which always runs.
    pub(super) runs: Option<Cell>,
    /// One bit for each position, of which at most one is on. If none is on, the main routine is at its head, and a
    /// group is stopped.
    pub(super) places: Vec<Cell>,
}

/// A state in which a pass can begin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct StartState {
    /// The position bit of each routine; `None`: the group is stopped, or the main routine is at its head.
    pub(super) places: Vec<Option<Cell>>,
    /// The bits that are on, apart from those of positions.
    pub(super) on: BTreeSet<Cell>,
}

/// Formulas that together are true exactly in these states. They say nothing about bits outside of `cells` and
/// `routines`.
pub(super) fn invariants(
    routines: &[RoutinePositions],
    states: &[StartState],
    cells: &[Cell],
) -> Vec<Logic> {
    let mut all: Vec<Logic> =
        routines.iter().map(|routine| Logic::All(at_most_one(&routine.places))).collect();
    // A group that runs is at exactly one position.
    all.extend(routines.iter().filter_map(|routine| {
        let (runs, stands) = (Logic::cell(routine.runs?), any(&routine.places));
        Some(Logic::Any(vec![
            Logic::All(vec![runs.clone(), stands.clone()]),
            Logic::All(vec![runs.not(), stands.not()]),
        ]))
    }));
    let states: Vec<&StartState> = states.iter().collect();
    all.push(one_of(routines, 0, &states, cells));
    all
}

fn any(cells: &[Cell]) -> Logic {
    Logic::Any(cells.iter().copied().map(Logic::cell).collect())
}

/// Expressions that together say that at most one of the cells is on: not one in each half, and the same within each
/// half.
fn at_most_one(cells: &[Cell]) -> Vec<Logic> {
    if cells.len() < 2 {
        return Vec::new();
    }
    let (left, right) = cells.split_at(cells.len() / 2);
    let mut all = vec![Logic::All(vec![any(left), any(right)]).not()];
    all.extend(at_most_one(left));
    all.extend(at_most_one(right));
    all
}

/// The expression that says that the routines from `at` on, and the cells, are as in one of the states.
fn one_of(
    routines: &[RoutinePositions],
    at: usize,
    states: &[&StartState],
    cells: &[Cell],
) -> Logic {
    let Some(routine) = routines.get(at) else { return on(states, cells) };
    let mut by_place: BTreeMap<Option<Cell>, Vec<&StartState>> = BTreeMap::new();
    for &state in states {
        by_place.entry(state.places[at]).or_default().push(state);
    }
    // Positions with the same condition on the other routines are combined.
    let mut disjuncts: Vec<(Logic, Vec<Logic>)> = Vec::new();
    for (place, states) in by_place {
        let stands = match (place, routine.runs) {
            (Some(cell), _) => Logic::cell(cell),
            (None, Some(runs)) => Logic::cell(runs).not(),
            (None, None) => any(&routine.places).not(),
        };
        let rest = one_of(routines, at + 1, &states, cells);
        match disjuncts.last_mut().filter(|(last, _)| *last == rest) {
            Some((_, places)) => places.push(stands),
            None => disjuncts.push((rest, vec![stands])),
        }
    }
    let disjuncts =
        disjuncts.into_iter().map(|(rest, places)| Logic::All(vec![Logic::Any(places), rest]));
    Logic::Any(disjuncts.collect())
}

/// The expression that says that the cells have the values of one of the states.
fn on(states: &[&StartState], cells: &[Cell]) -> Logic {
    let Some((&cell, rest)) = cells.split_first() else {
        return Logic::Const(!states.is_empty());
    };
    if states.is_empty() {
        return Logic::Const(false);
    }
    let (there, not): (Vec<_>, Vec<_>) = states.iter().partition(|state| state.on.contains(&cell));
    let (there, not) = (on(&there, rest), on(&not, rest));
    if there == not {
        return there;
    }
    let is = Logic::cell(cell);
    Logic::Any(vec![Logic::All(vec![is.clone(), there]), Logic::All(vec![is.not(), not])])
}

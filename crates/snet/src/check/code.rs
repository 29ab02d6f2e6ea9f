//! Compares the code's rule with the net's rule: reports each scan that the net could not follow, with a shortest run
//! to it.

use super::step::{Options, Step};
use super::structure::at_most_one;
use crate::rules::Rules;
use crate::{Diagram, Direction};
use scanbound_nets::search::{Search, search};
use std::collections::BTreeMap;

/// The largest number of transition sets that are examined in one state.
const SETS: usize = 4_096;

/// The start state of the code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Start {
    /// Without marks, as the code starts.
    Empty,
    /// With the initial marks, set by the first scan or by hand.
    Initial,
}

/// Why the net cannot follow a scan.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// Two transitions remove the mark of one place: the mark is doubled.
    TakenTwice(usize, usize, usize),
    /// Two transitions put a mark in one place: a mark is lost.
    FilledTwice(usize, usize, usize),
    /// A transition fires together with an emergency stop (the first index) that removes the same mark: the mark
    /// escapes the stop.
    Escapes(usize, usize, usize),
    /// A transition fires in two consecutive scans, but the counter after it counts once.
    CountedOnce(usize, usize),
    /// Transitions read places that others of them change, so none of them can be first.
    Circle(Vec<usize>),
}

/// A scan that the net cannot follow.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Divergence {
    /// The reason.
    pub cause: Cause,
    /// The start state.
    pub start: Start,
    /// A shortest run; its last scan is the one that differs.
    pub run: Vec<Step>,
}

/// The behaviour of the code.
#[derive(Debug)]
pub struct Code {
    /// The number of explored states.
    pub count: usize,
    /// Whether all states were explored (states after a difference are not).
    pub complete: bool,
    /// The differences between code and net, one for each cause.
    pub divergences: Vec<Divergence>,
    /// Possible causes that neither gates nor place invariants exclude, if not all states were explored.
    pub undecided: Vec<Cause>,
    /// Places whose initial marks the code does not set.
    pub is_left_out: Vec<usize>,
    /// Whether the code never does anything from its own start state.
    pub starts_dead: bool,
    /// The arbiters, which the code does not implement.
    pub arbiters: Vec<usize>,
}

/// Transitions that fire in one scan, and values of outer gates for this.
pub(crate) type Set = (Vec<usize>, Vec<bool>);

/// All sets of transitions that can fire in one scan, each with values of outer gates; whether the list is complete.
pub(crate) fn sets(rules: &Rules, state: &[u64]) -> (Vec<Set>, bool) {
    let ready: Vec<usize> =
        (0..rules.transitions()).filter(|&at| rules.is_ready(state, at)).collect();
    let mut outers: Vec<usize> = ready.iter().flat_map(|&at| rules.outers_of(at)).collect();
    outers.sort_unstable();
    outers.dedup();
    let mut found = Vec::new();
    let mut open = vec![(0, vec![None; rules.outers()])];
    let mut complete = true;
    // Decides gate by gate; gates that no remaining transition reads are skipped.
    while let Some((at, values)) = open.pop() {
        if found.len() >= SETS {
            complete = false;
            break;
        }
        let decides = |outer: &usize| {
            let undecided = |&&own: &&usize| {
                rules.outers_of(own).any(|one| one == *outer) && !rules.is_shut(own, &values)
            };
            rules.has_arbiters() || ready.iter().any(|own| undecided(&own))
        };
        let next = outers[at..].iter().position(decides);
        let Some(next) = next.map(|more| at + more) else {
            let values: Vec<bool> = values.iter().map(|value| value.unwrap_or(false)).collect();
            let fired = rules.fired_of(&ready, &values);
            found.push((fired, values));
            continue;
        };
        for value in [false, true] {
            let mut more = values.clone();
            more[outers[next]] = Some(value);
            open.push((next + 1, more));
        }
    }
    (found, complete)
}

/// The reasons why these transitions have no firing order.
fn causes(diagram: &Diagram, rules: &Rules, state: &[u64], fired: &[usize]) -> Vec<Cause> {
    let mut found = Vec::new();
    for place in 0..diagram.places.len() {
        let of = |direction| -> Vec<usize> {
            diagram.transitions_of(place, direction).filter(|at| fired.contains(at)).collect()
        };
        let (puts, takes, stops) = (of(Direction::OutOf), of(Direction::Into), of(Direction::Stop));
        pairs(&takes, |one, other| found.push(Cause::TakenTwice(place, one, other)));
        pairs(&puts, |one, other| found.push(Cause::FilledTwice(place, one, other)));
        for &stop in &stops {
            for &transition in &takes {
                if rules.order_of(state, &[stop, transition]).is_none() {
                    found.push(Cause::Escapes(stop, transition, place));
                }
            }
        }
        found.extend(
            puts.iter()
                .filter(|_| rules.has_just_fired(state, place))
                .map(|&transition| Cause::CountedOnce(transition, place)),
        );
    }
    if found.is_empty() {
        found.push(Cause::Circle(fired.to_vec()));
    }
    found
}

fn pairs(all: &[usize], mut each: impl FnMut(usize, usize)) {
    for (at, &one) in all.iter().enumerate() {
        all[at + 1..].iter().for_each(|&other| each(one, other));
    }
}

/// Explores the code from both start states.
pub(super) fn explore(diagram: &Diagram, rules: &Rules, options: Options) -> Code {
    let marked: Vec<usize> =
        (0..diagram.places.len()).filter(|&at| diagram.places[at].is_marked).collect();
    let (empty, initial) = (rules.empty(), rules.initial());
    let starts = if options.initial_in_first_scan || marked.is_empty() {
        vec![initial]
    } else {
        vec![empty.clone(), initial]
    };
    let mut table: Vec<Step> = Vec::new();
    let mut numbers: BTreeMap<Vec<usize>, u32> = BTreeMap::new();
    let mut runs_out: BTreeMap<usize, u32> = BTreeMap::new();
    let mut complete = true;
    let mut parted: BTreeMap<Cause, (usize, Vec<usize>)> = BTreeMap::new();
    let found = search(rules.width(), &starts, options.limit / 4, |at, state, take| {
        let (sets, is_all) = sets(rules, state);
        complete &= is_all;
        for (fired, outers) in sets {
            if rules.order(state, &outers, &fired).is_none() {
                for cause in causes(diagram, rules, state, &fired) {
                    parted.entry(cause).or_insert_with(|| (at, fired.clone()));
                }
                continue;
            }
            let next = rules.scan(state, &fired);
            let number = *numbers.entry(fired).or_insert_with_key(|fired| {
                table.push(Step::Scan(fired.clone()));
                u32::try_from(table.len() - 1).unwrap_or(u32::MAX)
            });
            take(number, &next);
        }
        for place in (0..diagram.places.len()).filter(|&place| rules.is_running(state, place)) {
            let number = *runs_out.entry(place).or_insert_with(|| {
                table.push(Step::RunOut(place));
                u32::try_from(table.len() - 1).unwrap_or(u32::MAX)
            });
            take(number, &rules.run_out(state, place));
        }
    });
    let begins = if options.initial_in_first_scan { Start::Initial } else { Start::Empty };
    let divergence = |(cause, (at, fired)): (Cause, (usize, Vec<usize>))| {
        let (from, mut run) = run(&found, &table, at);
        run.push(Step::Scan(fired));
        let start = if from == 0 { begins } else { Start::Initial };
        Divergence { cause, start, run }
    };
    let mut divergences: Vec<Divergence> = parted.into_iter().map(divergence).collect();
    divergences.sort_by_key(|one| one.run.len());
    let complete = complete && found.complete;
    let undecided = if complete { Vec::new() } else { undecided(diagram, rules, &divergences) };
    let is_dead = |at: usize| rules.gates_to_fire(&empty, at).is_none();
    let starts_dead = begins == Start::Empty && (0..rules.transitions()).all(is_dead);
    Code {
        count: found.len(),
        complete,
        divergences,
        undecided,
        is_left_out: if begins == Start::Initial { Vec::new() } else { marked },
        starts_dead,
        arbiters: (0..diagram.arbiters.len()).collect(),
    }
}

fn run(found: &Search, table: &[Step], at: usize) -> (usize, Vec<Step>) {
    let (start, steps) = found.path(at);
    (start, steps.into_iter().map(|number| table[number as usize].clone()).collect())
}

/// The possible causes that neither gates nor place invariants exclude.
fn undecided(diagram: &Diagram, rules: &Rules, known: &[Divergence]) -> Vec<Cause> {
    let groups = at_most_one(diagram);
    let inputs = |at: usize| -> Vec<usize> { diagram.places_of(at, Direction::Into).collect() };
    let exclusive = |one: usize, other: usize| {
        rules.exclude_each_other(one, other)
            || inputs(one).iter().any(|&a| {
                let both =
                    |&b: &usize| a != b && groups.iter().any(|g| g.contains(&a) && g.contains(&b));
                inputs(other).iter().any(both)
            })
    };
    let mut found = Vec::new();
    for place in 0..diagram.places.len() {
        let of = |direction| -> Vec<usize> { diagram.transitions_of(place, direction).collect() };
        let (puts, takes, stops) = (of(Direction::OutOf), of(Direction::Into), of(Direction::Stop));
        let mut add = |cause: Cause, one, other| {
            if !exclusive(one, other) {
                found.push(cause);
            }
        };
        pairs(&takes, |one, other| add(Cause::TakenTwice(place, one, other), one, other));
        pairs(&puts, |one, other| add(Cause::FilledTwice(place, one, other), one, other));
        for &stop in &stops {
            takes.iter().for_each(|&at| add(Cause::Escapes(stop, at, place), stop, at));
        }
        let is_source = |at: usize| inputs(at).is_empty();
        let counts = puts.iter().filter(|&&at| rules.is_counter(place) && is_source(at));
        found.extend(counts.map(|&at| Cause::CountedOnce(at, place)));
    }
    found.extend(rules.circles(&exclusive).into_iter().map(Cause::Circle));
    found.retain(|cause| known.iter().all(|one| one.cause != *cause));
    found
}

//! Runs the code's rule beside the net's: every scan that the net could not follow is told, with the shortest run there.

use super::step::{Options, Step};
use super::structure::at_most_one;
use crate::rules::Rules;
use crate::{Diagram, Direction};
use scanbound_nets::search::{Search, search};
use std::collections::BTreeMap;

/// How many sets of transitions are looked at in one state.
const SETS: usize = 4_096;

/// How a run of the code begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Start {
    /// Without any mark, as the code itself begins.
    Empty,
    /// With the initial marks: put in by the first scan, or by hand.
    Initial,
}

/// Why a scan does what the net does not.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// Two transitions take one place's mark: marks are doubled.
    TakenTwice(usize, usize, usize),
    /// Two transitions fill one place: a mark is lost.
    FilledTwice(usize, usize, usize),
    /// A transition fires beside an emergency stop, the first, which takes from the same place: the mark escapes.
    Escapes(usize, usize, usize),
    /// A transition fires in two scans that follow each other, and the counter behind it counts once.
    CountedOnce(usize, usize),
    /// Transitions look at places that others of them change, so that none can be the first.
    Circle(Vec<usize>),
}

/// A scan that the net could not follow.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parting {
    /// Why.
    pub cause: Cause,
    /// How the run begins.
    pub start: Start,
    /// A shortest run; its last scan is the one that parts.
    pub run: Vec<Step>,
}

/// What the code does.
#[derive(Debug)]
pub struct Code {
    /// How many states of the code were seen.
    pub count: usize,
    /// Whether these are all, up to where code and net part.
    pub complete: bool,
    /// Where code and net part, one for each cause.
    pub partings: Vec<Parting>,
    /// Where not all states were seen: causes that neither gates nor place invariants exclude.
    pub undecided: Vec<Cause>,
    /// Places whose initial marks the code leaves out.
    pub is_left_out: Vec<usize>,
    /// Whether the code, as it begins, never does anything.
    pub starts_dead: bool,
    /// Arbiters, which the code leaves out.
    pub arbiters: Vec<usize>,
}

/// Transitions that fire in one scan, and values of the outer gates with which they do.
pub(crate) type Set = (Vec<usize>, Vec<bool>);

/// The sets of transitions that can fire in one scan, each with values of the outer gates; whether these are all.
pub(crate) fn sets(rules: &Rules, state: &[u64]) -> (Vec<Set>, bool) {
    let ready: Vec<usize> =
        (0..rules.transitions()).filter(|&at| rules.is_ready(state, at)).collect();
    let mut outers: Vec<usize> = ready.iter().flat_map(|&at| rules.outers_of(at)).collect();
    outers.sort_unstable();
    outers.dedup();
    let mut found = Vec::new();
    let mut open = vec![(0, vec![None; rules.outers()])];
    let mut complete = true;
    // Gate by gate, those that no transition hangs on any more left out.
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

/// Why these transitions have no order.
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

/// Follows the code from power-up, and from the initial marks.
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
    let parting = |(cause, (at, fired)): (Cause, (usize, Vec<usize>))| {
        let (from, mut run) = run(&found, &table, at);
        run.push(Step::Scan(fired));
        let start = if from == 0 { begins } else { Start::Initial };
        Parting { cause, start, run }
    };
    let mut partings: Vec<Parting> = parted.into_iter().map(parting).collect();
    partings.sort_by_key(|one| one.run.len());
    let complete = complete && found.complete;
    let undecided = if complete { Vec::new() } else { undecided(diagram, rules, &partings) };
    let is_dead = |at: usize| rules.gates_to_fire(&empty, at).is_none();
    let starts_dead = begins == Start::Empty && (0..rules.transitions()).all(is_dead);
    Code {
        count: found.len(),
        complete,
        partings,
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

/// What may part code and net, as far as neither gates nor place invariants exclude it.
fn undecided(diagram: &Diagram, rules: &Rules, known: &[Parting]) -> Vec<Cause> {
    let groups = at_most_one(diagram);
    let inputs = |at: usize| -> Vec<usize> { diagram.places_of(at, Direction::Into).collect() };
    let apart = |one: usize, other: usize| {
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
            if !apart(one, other) {
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
    found.extend(rules.circles(&apart).into_iter().map(Cause::Circle));
    found.retain(|cause| known.iter().all(|one| one.cause != *cause));
    found
}

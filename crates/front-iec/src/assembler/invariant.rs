//! Invariants of a chart's state: they hold whenever a scan starts, because only the chart writes its state.

use super::memory::{ActionMemory, Memory, all, any};
use scanbound_iec::chart::coactive::{
    BUDGET, BUDGET_OF_ALL, Basis, apart_while_stored, steps_together_in,
};
use scanbound_iec::chart::{Chart, Qualifier};
use scanbound_ir::{Cell, Logic};
use scanbound_nets::reach::reach;
use scanbound_nets::{Bits, Net};

/// The most markings that are examined, for all stored actions of a chart together, to find which steps exclude them.
const STORED_BUDGET: usize = 1_000_000;

/// Up to this many markings are listed in one invariant; beyond, only exclusions are stated.
const MARKINGS: usize = 64;

/// Up to this many steps, each exclusive pair gets an invariant of its own.
const PAIRWISE: usize = 40;

fn on(cell: Cell) -> Logic {
    Logic::cell(cell)
}

fn never(parts: impl IntoIterator<Item = Logic>) -> Logic {
    all(parts).not()
}

/// The invariants of a chart. `always_acts`: whether every scan that executes the chart also executes the control of
/// its actions, after the transitions. `may_restart`: whether the chart may begin again while actions stay stored.
/// `net`: how its steps follow each other on every controller on which it may run.
pub(crate) fn of(
    chart: &Chart,
    memory: &Memory,
    (always_acts, may_restart): (bool, bool),
    net: &Net,
) -> Vec<Logic> {
    let mut found = Vec::new();
    let idle = || on(memory.started).not();
    // Before the chart begins, its state is clear.
    let controls = memory.actions.iter().flat_map(|action| {
        let inputs = action.inputs.iter().flat_map(|input| [input.was, input.stored, input.over]);
        inputs.chain([action.on, action.stored])
    });
    for cell in memory.steps.iter().copied().chain(controls) {
        found.push(any([on(memory.started), on(cell).not()]));
    }
    let analysis = steps_together_in(net, if net.shares() { BUDGET_OF_ALL } else { BUDGET });
    if !matches!(analysis.basis, Basis::Unsafe(_) | Basis::Open(_)) {
        found.extend(markings(net, memory, &analysis.basis));
        for clique in cliques(&analysis.together) {
            let steps: Vec<Cell> = clique.into_iter().map(|step| memory.steps[step]).collect();
            at_most_one(&steps, &mut found);
        }
        // If there are too many markings without stored actions, there are too many with them.
        let budget = match analysis.basis {
            Basis::Markings(_) => BUDGET.min(STORED_BUDGET / memory.actions.len().max(1)),
            Basis::Invariants(_) | Basis::Open(_) | Basis::Unsafe(_) => 0,
        };
        let is_stored =
            |action: &ActionMemory| action.feeds.iter().any(|feed| feed.qualifier.is_stored());
        for (name, action) in chart.actions().iter().zip(&memory.actions) {
            if !is_stored(action) || may_restart {
                continue;
            }
            for step in apart_while_stored(chart, net, name, budget) {
                let inputs = action.feeds.iter().zip(&action.inputs);
                // A delay stored by SD may continue while R is on.
                let outlasts = |kind| kind == Qualifier::Sd && action.has_reset();
                let inputs = inputs
                    .filter(|(feed, _)| feed.qualifier.is_stored() && !outlasts(feed.qualifier));
                let latches = inputs.map(|(_, input)| input.stored).chain([action.stored]);
                found.extend(latches.map(|latch| never([on(latch), on(memory.steps[step])])));
            }
        }
    }
    for action in &memory.actions {
        found.extend(controlled(memory, action, always_acts));
    }
    if always_acts {
        let pairs = memory.were.iter().zip(&memory.steps);
        found.extend(pairs.flat_map(|(&was, &now)| same(on(was), on(now), &idle)));
    }
    found
}

/// The invariants of a chart whose steps change where its next execution begins: a transition that clears had all steps
/// before it active, and of transitions after one step only one clears unless `all_clear`.
pub(crate) fn of_transitions(chart: &Chart, memory: &Memory, all_clear: bool) -> Vec<Logic> {
    let mut found = Vec::new();
    for (number, one) in chart.transitions.iter().enumerate() {
        let clears = || on(memory.clears[number]);
        found.push(any([on(memory.started), clears().not()]));
        found.extend(one.from.iter().map(|&step| never([clears(), on(memory.steps[step]).not()])));
        let shares = |other: usize| {
            let other = &chart.transitions[other].from;
            !all_clear && one.from.iter().any(|step| other.contains(step))
        };
        let rivals = (0..number).filter(|&other| shares(other));
        found.extend(rivals.map(|other| never([clears(), on(memory.clears[other])])));
    }
    found
}

/// Sets of mutually exclusive members, which together cover every exclusive pair. `together`: for each member, those
/// that can be active together with it.
fn cliques(together: &[Bits]) -> Vec<Vec<usize>> {
    let count = together.len();
    let mut found = Vec::new();
    // For each member, those that share a set with it already.
    let mut covered = vec![Bits::new(count); count];
    let mut behind = Bits::of(count, &(0..count).collect::<Vec<_>>());
    for one in 0..count {
        behind.remove(one);
        loop {
            let mut apart = behind.clone();
            apart.remove_all(&together[one]);
            let mut open = apart.clone();
            open.remove_all(&covered[one]);
            let Some(other) = open.iter().next() else { break };
            let mut clique = vec![one];
            let mut next = Some(other);
            while let Some(member) = next {
                clique.push(member);
                apart.remove_all(&together[member]);
                next = apart.next_after(member);
            }
            let members = Bits::of(count, &clique);
            for &own in &clique {
                covered[own].union_with(&members);
            }
            found.push(clique);
        }
    }
    found
}

/// Adds that no two of these steps are active. For many steps, the two halves exclude each other, recursively: a clause
/// for each pair would be a million clauses for 1,500 steps.
fn at_most_one(steps: &[Cell], found: &mut Vec<Logic>) {
    if steps.len() <= PAIRWISE {
        let pairs = steps.iter().enumerate().flat_map(|(at, &one)| {
            steps[at + 1..].iter().map(move |&other| never([on(one), on(other)]))
        });
        found.extend(pairs);
        return;
    }
    let (front, back) = steps.split_at(steps.len() / 2);
    let some = |steps: &[Cell]| any(steps.iter().copied().map(on));
    found.push(never([some(front), some(back)]));
    at_most_one(front, found);
    at_most_one(back, found);
}

fn same(one: Logic, other: Logic, idle: &dyn Fn() -> Logic) -> [Logic; 2] {
    [any([idle(), one.clone().not(), other.clone()]), any([idle(), one, other.not()])]
}

/// The reachable markings, listed in one invariant. None if they are too many or not all known.
fn markings(net: &Net, memory: &Memory, basis: &Basis) -> Option<Logic> {
    let Basis::Markings(count) = *basis else { return None };
    if count > MARKINGS {
        return None;
    }
    let reached = reach(net, BUDGET);
    let marking = |bits: &scanbound_nets::Bits| {
        all(memory.steps.iter().enumerate().map(|(step, &cell)| match bits.contains(step) {
            true => on(cell),
            false => on(cell).not(),
        }))
    };
    let all_of_them = reached.visited().map(marking);
    Some(any([on(memory.started).not()].into_iter().chain(all_of_them)))
}

/// The invariants between the state bits of an action's control.
fn controlled(memory: &Memory, action: &ActionMemory, always_acts: bool) -> Vec<Logic> {
    let mut found = Vec::new();
    let idle = || on(memory.started).not();
    let mut lasting = vec![action.active(memory, Qualifier::N)];
    let mut stored = vec![on(action.stored)];
    let mut pulses = Vec::new();
    let has = |kind| action.feeds.iter().any(|feed| feed.qualifier == kind);
    if !has(Qualifier::S) {
        found.push(on(action.stored).not());
    }
    for (feed, input) in action.feeds.iter().zip(&action.inputs) {
        let active = memory.active(&feed.steps);
        if always_acts {
            found.extend(same(on(input.was), active.clone(), &idle));
        }
        match feed.qualifier {
            Qualifier::L => {
                found.push(never([on(input.over), on(input.was).not()]));
                lasting.push(all([active, on(input.over).not()]));
            }
            Qualifier::D => {
                found.push(never([on(input.over), on(input.was).not()]));
                lasting.push(on(input.over));
            }
            Qualifier::Ds => {
                found.push(never([on(input.over), on(input.was).not()]));
                stored.push(on(input.stored));
            }
            Qualifier::Sd => {
                found.push(never([on(input.over), on(input.stored).not()]));
                stored.push(on(input.over));
            }
            Qualifier::Sl => {
                found.push(never([on(input.over), on(input.stored).not()]));
                stored.push(all([on(input.stored), on(input.over).not()]));
            }
            Qualifier::P => pulses.push(memory.active(&feed.steps)),
            Qualifier::N | Qualifier::R | Qualifier::S | Qualifier::P0 | Qualifier::P1 => {}
        }
        if !feed.qualifier.is_stored() || feed.qualifier == Qualifier::S {
            found.push(on(input.stored).not());
        }
        if !feed.qualifier.is_timed() {
            found.push(on(input.over).not());
        }
    }
    if always_acts {
        // Whether the action was on follows from its lasting inputs, except for pulses, for blocks that overrule each
        // other, and where R ends only stored actions.
        let free = || action.active(memory, Qualifier::R).not();
        let blocks: usize = action.feeds.iter().map(|feed| feed.steps.len()).sum();
        let alone = Logic::Const(blocks < 2);
        let stored = all([any(stored), free()]);
        let sure = any([all([any(lasting.clone()), free(), alone]), stored.clone()]);
        found.push(any([idle(), sure.not(), on(action.on)]));
        found.push(any([idle(), on(action.on).not(), any(lasting), stored, any(pulses)]));
    }
    found
}

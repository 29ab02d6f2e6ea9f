//! What of a chart's memory holds whenever a scan starts: nobody but the chart writes it.

use super::memory::{ActionMemory, Memory, all, any};
use scanbound_iec::chart::coactive::{
    BUDGET, BUDGET_OF_ALL, Basis, apart_while_stored, steps_together_in,
};
use scanbound_iec::chart::{Chart, Qualifier};
use scanbound_ir::{Cell, Logic};
use scanbound_nets::reach::reach;
use scanbound_nets::{Bits, Net};

/// How many markings are looked at for what excludes all stored actions of a chart together.
const STORED_BUDGET: usize = 1_000_000;

/// More markings than this are told by what excludes what, not one by one.
const MARKINGS: usize = 64;

/// Of so many steps each pair is told by itself.
const PAIRWISE: usize = 40;

fn on(cell: Cell) -> Logic {
    Logic::cell(cell)
}

fn never(parts: impl IntoIterator<Item = Logic>) -> Logic {
    all(parts).not()
}

/// What every scan keeps. `always_acts`: whether the control of actions is worked out in every scan in which the chart
/// is carried out, behind the evolution. `net`: how its steps follow each other on every controller that it may run on.
pub(crate) fn of(chart: &Chart, memory: &Memory, always_acts: bool, net: &Net) -> Vec<Logic> {
    let mut found = Vec::new();
    let idle = || on(memory.started).not();
    // Before it begins nothing is remembered.
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
        // Where there are too many markings without stored actions, there are with them.
        let budget = match analysis.basis {
            Basis::Markings(_) => BUDGET.min(STORED_BUDGET / memory.actions.len().max(1)),
            Basis::Invariants(_) | Basis::Open(_) | Basis::Unsafe(_) => 0,
        };
        let is_stored =
            |action: &ActionMemory| action.feeds.iter().any(|feed| feed.qualifier.is_stored());
        for (name, action) in chart.actions().iter().zip(&memory.actions) {
            if !is_stored(action) {
                continue;
            }
            for step in apart_while_stored(chart, net, name, budget) {
                let inputs = action.feeds.iter().zip(&action.inputs);
                // A delay may outlast R.
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

/// Sets of which no two are together, so that each pair that is apart is in one of them. `together`: for each member,
/// those that it can be together with.
fn cliques(together: &[Bits]) -> Vec<Vec<usize>> {
    let count = together.len();
    let mut found = Vec::new();
    // For each member, those that are in a set with it, or come before it.
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

/// That no two of some steps are active. Of many, that no two halves have one: a clause for each pair would be a
/// million for 1,500 steps.
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

/// The markings one by one, where they are few and all known.
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

/// How what an action's control remembers hangs together.
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
        // Whether it was on follows from what lasts, but for pulses, for blocks that overrule each other, and where R
        // holds off only what is stored.
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

//! By how many scans an output may change later than an input. Each device that is read earlier in a scan than it is
//! written costs one more scan.

use petgraph::graphmap::DiGraphMap;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{
    BitSource, ChoiceId, Join, Logic, Program, Region, Role, Source, Step, WordSource, Write, flow,
};
use std::collections::{BTreeMap, BTreeSet};

type Reads = BTreeSet<Region>;

/// An instruction that writes a device, with the cells that it reads.
struct WriteSite {
    at: usize,
    /// Whether the instruction runs at its own place in the scan. False in routines, which run where they are called.
    in_place: bool,
    reads: Reads,
    writes: Vec<Region>,
}

/// An upper bound on the number of additional scans from the change of an input to the change of the last output that
/// follows from it. Each device on the way is assumed to change as soon as the values change from which it is computed.
/// If devices are computed from each other in a circle, the change is assumed to pass through all of them. If the
/// program has no known inputs, the change may begin anywhere; if it has no known outputs, it may end anywhere.
pub fn further_scans(program: &Program) -> u64 {
    let sites = sites(program);
    let mut graph: DiGraphMap<usize, bool> = DiGraphMap::new();
    for site in 0..sites.len() {
        graph.add_node(site);
    }
    for (to, reader) in sites.iter().enumerate() {
        for (from, writer) in sites.iter().enumerate().filter(|&(from, _)| from != to) {
            let is_read = writer
                .writes
                .iter()
                .any(|written| reader.reads.iter().any(|read| flow::overlap(*written, *read)));
            if is_read {
                let is_later = !(writer.in_place && reader.in_place && writer.at < reader.at);
                graph.add_edge(from, to, is_later);
            }
        }
    }
    let is_role = |region: &Region, role: Role| match region {
        Region::Range { first, .. } => program.area(first.area).role == role,
        Region::Area(area) => program.area(*area).role == role,
        Region::Everything => true,
    };
    let has = |role: Role| program.areas.iter().any(|area| area.role == role);
    let is_input = |region: &Region| {
        is_role(region, Role::Input)
            || program.power_up.inputs.iter().any(|input| flow::overlap(*input, *region))
    };
    let knows_inputs = has(Role::Input) || !program.power_up.inputs.is_empty();
    let begins = |site: &WriteSite| !knows_inputs || site.reads.iter().any(is_input);
    let ends = |site: &WriteSite| {
        !has(Role::Output) || site.writes.iter().any(|region| is_role(region, Role::Output))
    };
    // In the order of computation.
    let mut parts = petgraph::algo::tarjan_scc(&graph);
    parts.reverse();
    let mut part_of = vec![0; sites.len()];
    for (part, members) in parts.iter().enumerate() {
        members.iter().for_each(|&site| part_of[site] = part);
    }
    let mut entered: Vec<Option<u64>> = vec![None; parts.len()];
    let mut most = 0;
    for (part, members) in parts.iter().enumerate() {
        if members.iter().any(|&site| begins(&sites[site])) {
            entered[part] = entered[part].max(Some(0));
        }
        let Some(lag) = entered[part] else { continue };
        let is_later = |&&site: &&usize| {
            graph
                .edges_directed(site, petgraph::Direction::Incoming)
                .any(|(from, _, later)| *later && part_of[from] == part)
        };
        let later = members.iter().filter(is_later).count().min(members.len() - 1);
        let lag = lag + later as u64;
        if members.iter().any(|&site| ends(&sites[site])) {
            most = most.max(lag);
        }
        for &site in members {
            for (_, to, later) in graph.edges(site).filter(|(_, to, _)| part_of[*to] != part) {
                let next = &mut entered[part_of[to]];
                *next = (*next).max(Some(lag + u64::from(*later)));
            }
        }
    }
    most
}

/// All instructions that write a device, each with the cells that affect it: those that it reads, and those on which
/// its rung, master control regions, jumps, loops and calls depend.
fn sites(program: &Program) -> Vec<WriteSite> {
    let mut found = Vec::new();
    // What decides whether routines are called.
    let mut calls = Reads::new();
    for main in &program.mains {
        walk(program, main.clone(), &Reads::new(), true, &mut calls, &mut found);
    }
    let in_main = |at: usize| program.mains.iter().any(|main| main.contains(&at));
    let around = calls.clone();
    let mut at = 0;
    while at < program.instructions.len() {
        if in_main(at) {
            at += 1;
            continue;
        }
        let end = (at..program.instructions.len()).find(|&end| in_main(end));
        let end = end.unwrap_or(program.instructions.len());
        walk(program, at..end, &around, false, &mut calls, &mut found);
        at = end;
    }
    // Subroutines are stored behind the end of a main routine.
    let called: BTreeSet<usize> = flow::calls(program).into_iter().map(|(_, to)| to).collect();
    let entries = called.iter().chain(program.interrupts.iter().map(|one| &one.entry));
    let routines: Vec<_> = entries
        .map(|&entry| {
            let last = program.instructions.len().saturating_sub(1);
            entry..=flow::routine_end(program, entry).unwrap_or(last)
        })
        .collect();
    for site in &mut found {
        if routines.iter().any(|routine| routine.contains(&site.at)) {
            site.in_place = false;
            site.reads.extend(&calls);
        }
    }
    found
}

fn walk(
    program: &Program,
    range: std::ops::Range<usize>,
    around: &Reads,
    in_place: bool,
    calls: &mut Reads,
    found: &mut Vec<WriteSite>,
) {
    let mut stack: Vec<Reads> = Vec::new();
    let mut slots: BTreeMap<u32, Reads> = BTreeMap::new();
    let mut masters: Vec<(u32, Reads)> = Vec::new();
    let mut jumps: Vec<(usize, Reads)> = Vec::new();
    // How often the body of a loop runs depends on its count and on everything that ends it.
    let loops: Vec<_> = range
        .clone()
        .filter_map(|at| match &program.instructions[at].step {
            Step::ForBegin { end, .. } => Some(at..=*end),
            Step::Summary(summary) => Some(at..=summary.end),
            _ => None,
        })
        .collect();
    for at in range {
        let instruction = &program.instructions[at];
        jumps.retain(|(target, _)| *target > at);
        let mut own = Reads::new();
        instruction.each_read(&mut |source: Source| match source {
            Source::Bit(BitSource::Free(choice)) | Source::Word(WordSource::Free(choice)) => {
                own.extend(of_choice(program, choice));
            }
            _ => own.extend(source.region()),
        });
        for effect in &instruction.effects {
            if let Write::Havoc(_, choice) = &effect.write {
                own.extend(of_choice(program, *choice));
            }
        }
        if loops.iter().any(|inside| inside.contains(&at)) {
            own.insert(Region::Everything);
        }
        if let Step::Logic { join, value } = &instruction.step {
            let is_new = matches!(join, Join::Start | Join::Load)
                || *join == Join::Replace && !asks_condition(value);
            if *join == Join::Start {
                stack.clear();
            }
            if *join == Join::Replace && is_new {
                stack.pop();
            }
            match stack.last_mut().filter(|_| !is_new) {
                Some(top) => top.extend(own.clone()),
                None => stack.push(own.clone()),
            }
        }
        match &instruction.step {
            Step::AndBlock | Step::OrBlock => {
                let top = stack.pop().unwrap_or_default();
                match stack.last_mut() {
                    Some(below) => below.extend(top),
                    None => stack.push(top),
                }
            }
            Step::Save(slot) => _ = slots.insert(*slot, stack.last().cloned().unwrap_or_default()),
            Step::Fetch(slot) => {
                stack.pop();
                stack.push(slots.get(slot).cloned().unwrap_or_default());
            }
            _ => {}
        }
        let mut reads = own;
        reads.extend(around);
        reads.extend(stack.last().into_iter().flatten());
        reads.extend(masters.iter().flat_map(|(_, reads)| reads));
        reads.extend(jumps.iter().flat_map(|(_, reads)| reads));
        match &instruction.step {
            Step::Jump { target, .. } => jumps.push((*target, reads.clone())),
            Step::Stop { .. } => jumps.push((usize::MAX, reads.clone())),
            Step::Call { .. } => calls.extend(&reads),
            Step::MasterControlBegin { level, .. } => masters.push((*level, reads.clone())),
            Step::MasterControlEnd { level } => masters.retain(|(open, _)| open < level),
            _ => {}
        }
        let writes = flow::written(program, at);
        if !writes.is_empty() {
            found.push(WriteSite { at, in_place, reads, writes });
        }
    }
}

/// The cells on which a choice (nondeterministic value) depends: none (`None`) if it comes from outside the program or
/// only concerns times; otherwise all are assumed.
fn of_choice(program: &Program, choice: ChoiceId) -> Option<Region> {
    match program.kinds.get(&choice) {
        Some(
            ChoiceKind::External
            | ChoiceKind::ExtraTime
            | ChoiceKind::Parameter
            | ChoiceKind::ScanTicks { .. },
        ) => None,
        None | Some(_) => Some(Region::Everything),
    }
}

/// Whether the expression contains the execution condition of its instruction.
fn asks_condition(value: &Logic) -> bool {
    match value {
        Logic::Condition => true,
        Logic::Const(_) | Logic::Bit(_) | Logic::Compare(_) => false,
        Logic::Not(inner) => asks_condition(inner),
        Logic::All(parts) | Logic::Any(parts) => parts.iter().any(asks_condition),
    }
}

//! Excludes contradictions between timers and edges. Instructions store in their own cells whether a timer was running
//! and what an edge's condition was. These cells can exclude that a timer runs and an edge occurs in the same scan,
//! whoever else writes devices.

use scanbound_base::budget::Budget;
use scanbound_ir::{AreaKind, BitTarget, Cell, Logic, Program, Region, Role};
use scanbound_model::{Atom, Circuit, Lit, Node, Origin, ScanModel, VarId};
use scanbound_scan::scan_model_to_end;
use scanbound_scan::size_limits::SizeLimits;
use scanbound_solve::Limits;
use scanbound_solve::inductive::{BitTransition, inductive};
use scanbound_timing::price::Prices;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// The name of this stage in the progress display.
const STAGE: &str = "comparing timers with edges";
/// The stage may use 1/`UNTIL` of the time limit.
const UNTIL: u32 = 4;
/// The proof of the exclusions may take at most this time.
const LONGEST: Duration = Duration::from_secs(5);
/// The most pairs that are checked.
const MAX_PAIRS: usize = 4_000;

/// The model without scans in which a running timer and an edge contradict each other. `None` if nothing is excluded.
/// The exclusions are recorded in the program.
///
/// The exclusions are proved by induction over scans. When a program begins to run, no timer was running, so all of
/// them hold at first.
pub fn exclude(
    program: &mut Program,
    prices: &Prices,
    model: &ScanModel,
    budget: &Budget<'_>,
) -> Option<ScanModel> {
    let [timers, edges] = memory_cells(program, model);
    if timers.is_empty() || edges.is_empty() {
        return None;
    }
    let is_over = || budget.must_stop_at_part(UNTIL);
    let limits = SizeLimits { is_over: &is_over, ..SizeLimits::default() };
    let cells: Vec<Cell> = timers.iter().chain(&edges).copied().collect();
    let bits: Vec<BitTarget> = cells.iter().map(|&cell| BitTarget::Cell(cell)).collect();
    let followed = scan_model_to_end(program, &prices.times(), &limits, &bits);
    let Ok((mut model, ends)) = followed else {
        let what = "the bound may assume combinations of timers and edges that never occur";
        budget.record_stop_at_part(UNTIL, STAGE, what);
        return None;
    };
    let starts = starts(&mut model, &cells);
    let on: Vec<BitTransition> =
        starts.into_iter().zip(ends).map(|(start, end)| BitTransition { start, end }).collect();
    let off = on.iter().map(|bit| BitTransition { start: !bit.start, end: !bit.end });
    let all: Vec<BitTransition> = on.iter().copied().chain(off).collect();
    let pairs = pairs(&model.circuit, &on, timers.len());
    let deadline = Some(Instant::now() + LONGEST);
    let limits = Limits { deadline, cancelled: &is_over, ..Limits::default() };
    let preserved = if pairs.is_empty() { None } else { inductive(&model, &all, pairs, &limits) }?;
    for pair in &preserved {
        let both = model.circuit.all(pair.iter().map(|&bit| all[bit].start));
        model.constraints.push(!both);
        let logic = |&bit: &usize| match cells.get(bit) {
            Some(&cell) => Logic::cell(cell),
            None => Logic::cell(cells[bit - cells.len()]).not(),
        };
        program.invariants.push(Logic::All(pair.iter().map(logic).collect()).not());
    }
    (!preserved.is_empty()).then_some(model)
}

/// The internal cells whose start values the model reads: first those that hold whether a timer is running, then the
/// others, which hold an edge's last condition. Cells that others may write are left out.
fn memory_cells(program: &Program, model: &ScanModel) -> [Vec<Cell>; 2] {
    let expiries = program.timekeeping.expiries.values();
    let running: BTreeSet<Cell> = expiries.map(|one| one.memory).collect();
    let [mut timers, mut edges] = [Vec::new(), Vec::new()];
    for variable in &model.variables {
        let Origin::Start(cell) = variable.origin else { continue };
        let area = program.area(cell.area);
        if area.role == Role::Internal && area.kind == AreaKind::Bit {
            if running.contains(&cell) { &mut timers } else { &mut edges }.push(cell);
        }
    }
    if !timers.is_empty() && !edges.is_empty() {
        // Cells that are written at any moment are not followed.
        let is_own = |cell: &Cell| {
            let within = |region: &Region| region.contains(*cell);
            !program.volatile.iter().any(within) && !program.external.iter().any(within)
        };
        timers.retain(is_own);
        edges.retain(is_own);
    }
    [timers, edges]
}

/// For each cell, the literal of its value when the scan starts.
fn starts(model: &mut ScanModel, cells: &[Cell]) -> Vec<Lit> {
    let variables = model.variables.iter().zip(0..).filter_map(|(one, at)| match one.origin {
        Origin::Start(cell) => Some((cell, VarId(at))),
        _ => None,
    });
    let variables: BTreeMap<Cell, VarId> = variables.collect();
    let circuit: &mut Circuit = &mut model.circuit;
    cells.iter().map(|cell| circuit.atom(Atom::Bit(variables[cell]))).collect()
}

/// Candidate pairs of a running timer and an edge's memory bit that is on, or off, that a scan seems to exclude: when
/// the scan ends, the timer runs only if the bit has the other value. They are indices into the bits; indices of bits
/// that are off follow behind the others.
fn pairs(circuit: &Circuit, bits: &[BitTransition], timers: usize) -> Vec<Vec<usize>> {
    let mut edges: BTreeMap<Lit, Vec<usize>> = BTreeMap::new();
    for (at, bit) in bits.iter().enumerate().skip(timers) {
        edges.entry(bit.end).or_default().push(at);
    }
    let mut pairs = Vec::new();
    for (timer, bit) in bits.iter().enumerate().take(timers) {
        let mut seen = BTreeSet::new();
        let mut open = vec![bit.end];
        while let Some(lit) = open.pop() {
            if !seen.insert(lit) || seen.len() > MAX_PAIRS {
                continue;
            }
            let off = edges.get(&lit).into_iter().flatten().map(|&edge| edge + bits.len());
            let on = edges.get(&!lit).into_iter().flatten().copied();
            pairs.extend(off.chain(on).map(|edge| vec![timer, edge]));
            if let (false, Node::And(a, b)) = (lit.is_negated(), circuit.node(lit)) {
                open.extend([a, b]);
            }
        }
    }
    pairs.truncate(MAX_PAIRS);
    pairs
}

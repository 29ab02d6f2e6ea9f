//! The search for a run from power-up to a scan: a few sequences of inputs are simulated.

use super::real::Found;
use super::{RunScan, Value};
use crate::base::time::{Picos, Times};
use crate::program::{AreaKind, Cell, Program};
use crate::replay::run::{Given, Run};
use crate::solve::Limits;
use crate::timing::price::Prices;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use std::collections::BTreeMap;
use std::rc::Rc;

/// The most scans of a run.
const LONGEST: usize = 8;
/// The number of runs that are tried with inputs that change at random.
const RANDOM: u64 = 64;
/// The most instructions that are executed in all.
const MOST_EXECUTED: u64 = 2_000_000;

/// Which inputs the outside sets in the scans before the last.
#[derive(Clone, Copy)]
enum Before {
    /// Those of the scan that is looked for.
    Same,
    /// None.
    Off,
    /// Its opposite, so that edges come in it.
    Opposite,
    /// Some of them, by this seed.
    Random(u64),
}

/// A run of scans that begins at power-up and ends with one that takes as long as the one that was found; none if no
/// sequence that is tried leads there.
pub fn run(program: &Program, prices: &Prices, found: &Found, limits: &Limits<'_>) -> Vec<RunScan> {
    let late = || limits.deadline.is_some_and(|end| std::time::Instant::now() >= end);
    let times = prices.least_times();
    let mut left = MOST_EXECUTED;
    let tried = [Before::Same, Before::Off, Before::Opposite].into_iter();
    for before in tried.chain((0..RANDOM).map(Before::Random)) {
        if left == 0 || late() || (limits.cancelled)() {
            break;
        }
        if let Some(scans) = simulate(program, &times, found, before, &mut left) {
            let told = |(inputs, took)| RunScan {
                inputs: on(program, &inputs),
                took: prices.overhead_sum() + took,
            };
            return scans.into_iter().map(told).collect();
        }
    }
    Vec::new()
}

/// The inputs that are on, or not 0, by their names.
fn on(program: &Program, inputs: &BTreeMap<Cell, u16>) -> Vec<(String, Value)> {
    let input = |(&cell, &value): (&Cell, &u16)| {
        let value = match program.areas[usize::from(cell.area.0)].kind {
            AreaKind::Bit => Value::Bit(value & 1 == 1),
            AreaKind::Word => Value::Word(value.cast_signed()),
        };
        let is_on = !matches!(value, Value::Bit(false) | Value::Word(0));
        is_on.then(|| (program.cell_name(cell), value))
    };
    inputs.iter().filter_map(input).collect()
}

/// Makes scans until one takes long enough: the inputs of each, and how long it takes without what each scan costs
/// besides its instructions.
fn simulate(
    program: &Program,
    times: &[Times],
    found: &Found,
    before: Before,
    left: &mut u64,
) -> Option<Vec<(BTreeMap<Cell, u16>, Picos)>> {
    let wanted = found.best.replay.total;
    let mut run = Run::new(program, times);
    let sought = found.witness.start.iter().map(|(&cell, &value)| (cell, value));
    let sought: BTreeMap<Cell, u16> = sought.filter(|&(cell, _)| run.sets(cell)).collect();
    let seed = if let Before::Random(seed) = before { seed } else { 0 };
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut scans = Vec::new();
    let choices = Rc::new(found.witness.choices.clone());
    for turn in 0..LONGEST {
        // Inputs that lead there and those of the scan itself take turns.
        let inputs = match before {
            _ if turn % 2 == 1 => sought.clone(),
            Before::Same => sought.clone(),
            Before::Off => BTreeMap::new(),
            Before::Opposite => sought.iter().map(|(&cell, value)| (cell, !value)).collect(),
            Before::Random(_) => {
                sought.keys().map(|&cell| (cell, random.next_u32() as u16)).collect()
            }
        };
        let given = Given { inputs: inputs.clone(), choices: choices.clone() };
        let scan = run.scan(given, *left);
        *left = left.saturating_sub(scan.replay.events.len() as u64);
        if !scan.is_possible() {
            return None;
        }
        scans.push((inputs, scan.replay.total));
        if scan.replay.total >= wanted {
            return Some(scans);
        }
        if scan.stopped.is_some() {
            return None;
        }
    }
    None
}

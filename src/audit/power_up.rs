//! The search for a run from power-up to a scan: a few sequences of inputs are simulated.

use super::real::Found;
use super::{RunScan, Value};
use crate::base::time::{Picos, Times};
use crate::program::{AreaKind, Cell, Program};
use crate::replay::run::{Given, Outside, Run};
use crate::solve::Limits;
use crate::timing::price::Prices;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The most scans of a run.
const LONGEST: usize = 8;
/// The number of runs that are tried with inputs that change at random.
const RANDOM: u64 = 64;
/// So many of them are simulated side by side.
const AT_ONCE: usize = 8;
/// No further ones are simulated when so many instructions were executed.
const MOST_EXECUTED: u64 = 1_500_000;
/// The most instructions of one run.
const MOST_OF_ONE: u64 = 400_000;

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
    let outside = Outside::of(program);
    let simulation = Simulation { times: &times, outside: &outside, found };
    let mut tried: Vec<Before> = vec![Before::Same, Before::Off, Before::Opposite];
    tried.extend((0..RANDOM).map(Before::Random));
    let mut executed = 0;
    for some in tried.chunks(AT_ONCE) {
        if executed >= MOST_EXECUTED || late() || (limits.cancelled)() {
            break;
        }
        let runs: Vec<Simulated> = some.par_iter().map(|&before| simulation.run(before)).collect();
        executed += runs.iter().map(|run| run.executed).sum::<u64>();
        if let Some(scans) = runs.into_iter().find_map(|run| run.leads_there.then_some(run.scans)) {
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

/// What all simulated runs have in common.
struct Simulation<'a> {
    times: &'a [Times],
    outside: &'a Outside<'a>,
    found: &'a Found,
}

/// A simulated run.
struct Simulated {
    /// The inputs of each scan, and how long it takes without what each scan costs besides its instructions.
    scans: Vec<(BTreeMap<Cell, u16>, Picos)>,
    /// Whether its last scan takes long enough.
    leads_there: bool,
    /// How many instructions were executed.
    executed: u64,
}

impl Simulation<'_> {
    /// Makes scans until one takes long enough.
    fn run(&self, before: Before) -> Simulated {
        let wanted = self.found.best.replay.total;
        let mut run = Run::new(self.outside, self.times);
        let sought = self.found.witness.start.iter().map(|(&cell, &value)| (cell, value));
        let sought: BTreeMap<Cell, u16> =
            sought.filter(|&(cell, _)| self.outside.sets(cell)).collect();
        let seed = if let Before::Random(seed) = before { seed } else { 0 };
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut done = Simulated { scans: Vec::new(), leads_there: false, executed: 0 };
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
            let given = Given { inputs: inputs.clone(), choices: &self.found.witness.choices };
            let scan = run.scan(given, MOST_OF_ONE - done.executed);
            done.executed += scan.replay.events.len() as u64;
            if !scan.is_possible() {
                break;
            }
            done.scans.push((inputs, scan.replay.total));
            done.leads_there = scan.replay.total >= wanted;
            if done.leads_there || scan.stopped.is_some() || done.executed >= MOST_OF_ONE {
                break;
            }
        }
        done
    }
}

//! The search for a run from power-up to a scan: a few sequences of inputs are simulated.

use super::real::{RunResults, RunSearch};
use super::{RunScan, Value};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::{AreaId, AreaKind, Cell, Program, Witness, flow};
use scanbound_passes::values::Trust;
use scanbound_replay::run::{Outside, OutsideValues, Run};
use scanbound_replay::{Readings, RealRun, StopReason, Stopped, in_all_readings};
use scanbound_timing::price::Prices;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// The largest number of times that a run sets its inputs: to those of its plan and those of the scan that is to be
/// reached, in turn.
const LONGEST: usize = 8;
/// The largest number of scans with the same inputs before the inputs change.
const SAME: usize = 6;
/// The largest number of times that a run waits for a timer before the inputs change.
const MAX_WAITS: usize = 24;
/// The number of runs that are tried with random changes of the inputs.
const RANDOM: u64 = 64;
/// The number of runs that are simulated in parallel.
const AT_ONCE: usize = 8;
/// After this many executed instructions, no further runs are simulated.
const MAX_EXECUTED: u64 = 1_500_000;
/// The largest number of instructions that the runs of one plan execute together.
const MAX_EXECUTED_PER_RUN: u64 = 400_000;
/// The largest number of combinations of readings that are compared to find those on which each run stops.
const MAX_STOPPED: usize = 4096;

/// The inputs with which a simulated run begins. Afterwards the inputs of the scan that is to be reached and these take
/// turns, each for one scan, or for several ([`InputPlan::waits`]).
#[derive(Clone, Copy)]
enum EarlierInputs {
    /// The same inputs as in the scan that is to be reached.
    Same,
    /// All inputs are off.
    Off,
    /// The opposite inputs of the scan that is to be reached, so that edges occur in that scan.
    Opposite,
    /// Each input has a random value, determined by this seed.
    Random(u64),
    /// The inputs of the longest first scan. Other values from outside are as in that scan, too.
    First,
    /// Each input is, at random, off or as in the scan that is to be reached. The number is the seed.
    Part(u64),
}

/// How the inputs of a simulated run from power-up change.
#[derive(Clone, Copy)]
struct InputPlan {
    before: EarlierInputs,
    /// True: the inputs stay until nothing changes and no timer is running, within limits. False: they change in every
    /// scan.
    waits: bool,
}

/// Searches for a run of scans from power-up whose last scan takes at least as long as the longest scan found. Empty if
/// none of the tried sequences leads there. If the last scan takes longer, it becomes the longest scan found; if none
/// was found before (its time is 0), the longest scan of all tried runs does. If, on controllers with some readings of
/// a standard, each tried run ends with an operation error that stops the CPU and that the program alone causes, the
/// time of the longest scan found is removed: nothing shows that it is possible there.
pub fn run(
    search: &RunSearch<'_>,
    prices: &Prices,
    trust: Trust,
    found: &mut RunResults,
) -> Vec<RunScan> {
    let (program, limits) = (search.program, search.limits);
    let late = || limits.deadline.is_some_and(|end| std::time::Instant::now() >= end);
    let outside = Outside::of(program);
    let overhead = prices.overhead_sum();
    let mut executed = 0;
    let mut errors = AlwaysStopped::default();
    // The start of the longest first scan. It is computed once the simplest runs have failed.
    let mut first = Witness::default();
    let mut longest: Option<Simulated> = None;
    let plans = plans(program);
    // The first run is made alone: what it takes, others must exceed.
    let (alone, others) = plans.split_at(1);
    for (round, some) in [alone].into_iter().chain(others.chunks(AT_ONCE)).enumerate() {
        if executed >= MAX_EXECUTED || late() || (limits.cancelled)() {
            break;
        }
        let mut some = some.to_vec();
        if round == 2
            && let Some(start) = search.first_scan(found, &outside)
        {
            first = start;
            some.insert(0, InputPlan { before: EarlierInputs::First, waits: false });
        }
        let times = search.least;
        let seeks_errors = !program.errors.is_empty() && errors.may_remain();
        let longest_so_far = longest.as_ref().and_then(Simulated::took);
        let simulation = Simulation {
            times,
            outside: &outside,
            found,
            overhead,
            first: &first,
            longest_so_far,
            seeks_errors,
        };
        let runs: Vec<Simulated> = some.par_iter().map(|&plan| simulation.run(plan)).collect();
        executed += runs.iter().map(|run| run.executed).sum::<u64>();
        runs.iter().for_each(|run| errors.narrow(&run.errors));
        for run in runs {
            if run.took() > longest.as_ref().and_then(Simulated::took) {
                longest = Some(run);
            }
        }
        if longest.is_some() && !simulation.seeks_longest() {
            break;
        }
    }
    if let Some(Simulated { last: Some((last, start)), scans, .. }) = longest {
        found.replace(last, start);
        return scans_for_report(program, overhead, scans);
    }
    let is_own = |(_, error): &(Readings, Stopped)| is_own(program, error);
    if let Some((readings, error)) = errors.left.into_iter().flatten().find(is_own)
        && trust == Trust::All
    {
        found.ends_in(error, &readings);
    }
    Vec::new()
}

/// The controllers, by their readings of a standard (points in which they may differ from it), on which each run so far
/// ended with an operation error, each with the error of the first run. `None` before the first run.
#[derive(Default)]
struct AlwaysStopped {
    left: Option<Vec<(Readings, Stopped)>>,
}

impl AlwaysStopped {
    /// Whether, as far as the runs so far show, some controller stops in each run.
    fn may_remain(&self) -> bool {
        self.left.as_ref().is_none_or(|left| !left.is_empty())
    }

    /// Takes note of a further run, which ends with an operation error on the controllers with these readings.
    fn narrow(&mut self, errors: &[(Readings, Stopped)]) {
        let Some(left) = &mut self.left else {
            self.left = Some(errors.to_vec());
            return;
        };
        if errors.len().saturating_mul(left.len()) > MAX_STOPPED {
            // The list stays longer than it has to be.
            return;
        }
        let both = |(one, error): &(Readings, Stopped)| -> Vec<(Readings, Stopped)> {
            let agrees = |other: &Readings| {
                other.iter().all(|(number, value)| one.get(number).is_none_or(|own| own == value))
            };
            let others = errors.iter().filter(|(other, _)| agrees(other));
            let joined =
                |other: &Readings| one.iter().chain(other).map(|(&at, &is)| (at, is)).collect();
            others.map(|(other, _)| (joined(other), error.clone())).collect()
        };
        let mut narrower: Vec<(Readings, Stopped)> = left.iter().flat_map(both).collect();
        narrower.sort_by(|one, other| one.0.cmp(&other.0));
        narrower.dedup_by(|one, other| one.0 == other.0);
        *left = narrower;
    }
}

/// Whether the condition of an operation error reads only cells that the program writes. Nondeterministic values in it
/// are ignored. Otherwise a different run may not have the error.
fn is_own(program: &Program, error: &Stopped) -> bool {
    let written = || (0..program.instructions.len()).flat_map(|at| flow::written(program, at));
    let mut is_own = true;
    if let Some(condition) = program.errors.get(&error.at) {
        condition.each_read(&mut |source| {
            let region = source.region();
            is_own &= region.is_none_or(|read| written().any(|one| flow::overlap(read, one)));
        });
    }
    is_own
}

/// The runs to try, in this order. [`EarlierInputs::First`] is not among them: it is added once the first runs have
/// failed.
fn plans(program: &Program) -> Vec<InputPlan> {
    let first = [EarlierInputs::Same, EarlierInputs::Off, EarlierInputs::Opposite];
    let timekeeping = &program.timekeeping;
    let has_timers = !timekeeping.instructions.is_empty() || !timekeeping.expiries.is_empty();
    let mut plans: Vec<InputPlan> = first.map(|before| InputPlan { before, waits: false }).into();
    if has_timers {
        plans.extend(first.map(|before| InputPlan { before, waits: true }));
    }
    for seed in 0..RANDOM {
        plans.push(InputPlan { before: EarlierInputs::Random(seed), waits: false });
        if has_timers {
            plans.push(InputPlan { before: EarlierInputs::Part(seed), waits: true });
        }
    }
    plans
}

/// The scans for the report. Scans in which the run only waits are left out.
fn scans_for_report(program: &Program, overhead: Picos, scans: Vec<SimulatedScan>) -> Vec<RunScan> {
    let waits = |at: usize| scans.get(at + 1).is_some_and(|next| next.waited);
    let shown = scans.iter().enumerate().filter(|&(at, scan)| !(scan.waited && waits(at)));
    let scans_for_report = |(_, scan): (usize, &SimulatedScan)| RunScan {
        number: scan.number,
        inputs: on(program, &scan.inputs),
        took: overhead + scan.took,
    };
    shown.map(scans_for_report).collect()
}

/// The names of the inputs that are on, or not 0, with their values.
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
    found: &'a RunResults,
    overhead: Picos,
    /// The start values of the longest first scan.
    first: &'a Witness,
    /// The time of the longest scan to which earlier runs lead.
    longest_so_far: Option<Picos>,
    /// Whether runs that do not lead to the scan are of use, too, for the operation errors with which they end.
    seeks_errors: bool,
}

/// A scan of a simulated run.
struct SimulatedScan {
    /// The number of the scan; the first one after power-up has the number 1.
    number: u64,
    inputs: BTreeMap<Cell, u16>,
    /// The time of the scan without the overhead.
    took: Picos,
    /// Whether scans before this one were left out because they repeat the scan before them.
    waited: bool,
}

/// A simulated run.
#[derive(Default)]
struct Simulated {
    scans: Vec<SimulatedScan>,
    /// The scan that the run is for, with its start values: the first that takes at least as long as the longest scan
    /// found. If none was found before, the longest scan of the run.
    last: Option<(RealRun, Witness)>,
    /// The number of scans in `scans` up to `last`, which is the last one of them.
    shown: usize,
    /// The number of instructions that the run executed.
    executed: u64,
    /// The largest number of instructions that the run may execute.
    most: u64,
    /// The operation errors that end the run, each with the readings with which it does.
    errors: Vec<(Readings, Stopped)>,
    /// The devices that the scans so far need ([`RealRun::needed_devices`]).
    needed: BTreeMap<AreaId, u32>,
}

impl Simulated {
    /// The time of the scan in `last`.
    fn took(&self) -> Option<Picos> {
        self.last.as_ref().map(|(last, _)| last.replay.total)
    }
}

impl Simulation<'_> {
    /// Whether no scan was found before, so that the longest scan of each run is wanted.
    fn seeks_longest(&self) -> bool {
        self.found.best.replay.total == Picos::ZERO
    }

    /// The run of a plan. If the run depends on readings of a standard: the shortest of its runs in these readings,
    /// provided that all of them lead to a scan that takes at least as long as the longest scan found. Readings that
    /// cannot lead to a longer scan than earlier runs are not tried to their end.
    fn run(&self, plan: InputPlan) -> Simulated {
        let mut shortest: Option<Simulated> = None;
        let (mut executed, mut errors) = (0, Vec::new());
        let run = |readings: &Readings| {
            let run = Run::new(self.outside, self.times, self.overhead);
            let mut run = run.with_readings(readings.clone());
            let mut one =
                self.simulate(&mut run, plan, MAX_EXECUTED_PER_RUN.saturating_sub(executed));
            one.scans.truncate(one.shown);
            executed += one.executed;
            (one, run.undecided())
        };
        let mut met = BTreeSet::new();
        in_all_readings(run, |readings, mut one| {
            met.extend(readings.keys());
            errors.extend(one.errors.drain(..).map(|(_, error)| (readings.clone(), error)));
            // Of equally long ones, that with the most scans: with the same inputs, it contains the scan of the others.
            let rank = |run: &Simulated| (run.took(), Reverse(run.shown));
            if shortest.as_ref().is_none_or(|old| rank(&one) < rank(old)) {
                shortest = Some(one);
            }
            let took = shortest.as_ref().and_then(Simulated::took);
            took > self.longest_so_far || self.seeks_errors
        });
        let mut shortest = Simulated { executed, errors, ..shortest.unwrap_or_default() };
        if let Some((last, _)) = &mut shortest.last {
            last.readings = met;
        }
        shortest
    }

    /// Simulates scans until one takes at least as long as the longest scan found, a scan is impossible or not followed
    /// to its end, or `most` instructions were executed.
    fn simulate<'p>(&'p self, run: &mut Run<'p>, plan: InputPlan, most: u64) -> Simulated {
        let inputs_of = |witness: &Witness| -> BTreeMap<Cell, u16> {
            let all = witness.start.iter().map(|(&cell, &value)| (cell, value));
            all.filter(|&(cell, _)| self.outside.sets(cell)).collect()
        };
        let sought = inputs_of(&self.found.witness);
        let seed = if let EarlierInputs::Random(seed) | EarlierInputs::Part(seed) = plan.before {
            seed
        } else {
            0
        };
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut done = Simulated { most, ..Simulated::default() };
        let mut number = 0;
        for turn in 0..LONGEST {
            // Alternate between the inputs of the plan and those of the scan itself.
            let inputs = match plan.before {
                _ if turn % 2 == 1 => sought.clone(),
                EarlierInputs::Same => sought.clone(),
                EarlierInputs::First => inputs_of(self.first),
                EarlierInputs::Off => BTreeMap::new(),
                EarlierInputs::Opposite => {
                    sought.iter().map(|(&cell, value)| (cell, !value)).collect()
                }
                EarlierInputs::Random(_) => {
                    sought.keys().map(|&cell| (cell, random.next_u32() as u16)).collect()
                }
                EarlierInputs::Part(_) => {
                    let some = sought.iter().filter(|_| random.next_u32() & 1 == 1);
                    some.map(|(&cell, &value)| (cell, value)).collect()
                }
            };
            let leads = turn % 2 == 0;
            let choices = match plan.before {
                EarlierInputs::First if leads => &self.first.choices,
                _ => &self.found.witness.choices,
            };
            // Values that are tested directly are not among the inputs.
            let seed = match plan.before {
                EarlierInputs::Part(seed) if leads && seed % 2 == 1 => Some(random.next_u64()),
                _ => None,
            };
            let given = OutsideValues { inputs, choices, seed };
            let (mut same, mut waits) = (0, 0);
            let mut waited = 0;
            loop {
                number += 1 + waited;
                if !self.scan(run, &given, (number, waited > 0), &mut done) {
                    return done;
                }
                if !plan.waits {
                    break;
                }
                same += 1;
                waited = match run.wait() {
                    Some(scans) if waits < MAX_WAITS => {
                        (same, waits) = (0, waits + 1);
                        scans
                    }
                    _ if same < SAME && !run.is_steady() => 0,
                    _ => break,
                };
            }
        }
        done
    }

    /// Simulates one scan and adds it to `done`, if it is possible. Returns whether another scan may follow.
    fn scan<'p>(
        &'p self,
        run: &mut Run<'p>,
        given: &OutsideValues<'p>,
        (number, waited): (u64, bool),
        done: &mut Simulated,
    ) -> bool {
        let mut scan = run.scan(given, done.most.saturating_sub(done.executed));
        done.executed += scan.replay.events.len() as u64;
        if !scan.is_possible() {
            let error = scan.stopped.filter(|stopped| stopped.reason == StopReason::Error);
            done.errors.extend(error.map(|error| (Readings::new(), error)));
            return false;
        }
        let took = scan.replay.total;
        let is_over = scan.stopped.is_some() || done.executed >= done.most;
        done.scans.push(SimulatedScan { number, inputs: given.inputs.clone(), took, waited });
        let best = self.found.best.replay.total;
        if given.seed.is_some() && took > best {
            // The random values of this scan cannot be shown in a report.
            return false;
        }
        // If the scan is not followed to its end, an operation error may end it.
        let program = self.outside.program();
        let leads_there = took >= best && (scan.stopped.is_none() || program.errors.is_empty());
        for (&area, &count) in &scan.needed_devices {
            let needed = done.needed.entry(area).or_default();
            *needed = count.max(*needed);
        }
        if leads_there && Some(took) > done.took() {
            scan.needed_devices = done.needed.clone();
            let choices = given.choices.clone();
            let start = Witness { start: run.started(), choices, ..Witness::default() };
            done.last = Some((scan, start));
            done.shown = done.scans.len();
        }
        (!leads_there || self.seeks_longest()) && !is_over
    }
}

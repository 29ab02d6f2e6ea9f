//! The concrete interpreter: runs one scan on given values and adds up the times of its instructions.
//!
//! It implements the meaning that [`scanbound_ir`] states and shares no code with the symbolic execution. If both give
//! the same time for a scan, neither has an error that the other lacks.

mod cases;
pub mod emulated;
mod exact;
mod expiry;
mod free;
mod lists;
mod machine;
mod memory;
mod operation;
mod outcome;
mod pointers;
mod reads;
pub mod run;
mod state;
mod timed;
mod trace;
mod words;

#[cfg(test)]
mod control_tests;
#[cfg(test)]
mod real_tests;
#[cfg(test)]
mod value_tests;

pub use cases::{Readings, in_all_readings};
pub use free::FreeValues;
pub use operation::run as operate;
pub use outcome::{Event, RealRun, Replay, StopReason, Stopped};
pub use trace::{Trace, TracedOperation, TracedRead};

use cases::Cases;
use free::Mode;
use scanbound_base::time::Times;
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{AreaId, Program, Witness};
use std::collections::{BTreeMap, BTreeSet};

/// Runs one scan of the program on the witness's values. `times` holds each instruction's on-time and off-time,
/// parallel to `Program::instructions`.
#[must_use]
pub fn replay(program: &Program, times: &[Times], witness: &Witness) -> Replay {
    replay_with(program, times, witness)
}

/// Makes a real run of at most `most` instructions. If the manuals do not say whether a loop makes one iteration or
/// none, both cases are run, for the first four such loops; and if the path or a time depends on a reading of a
/// standard ([`ChoiceKind::Reading`](scanbound_ir::meaning::ChoiceKind::Reading)), both readings are. The result is the
/// shortest run, or an impossible one if one of the cases is impossible. Its `learned` contains the observations of all
/// runs, and its `needed_devices` are those of all runs. Each call of `free` must give the same values again.
#[must_use]
pub fn real<F: FreeValues>(
    program: &Program,
    times: &[Times],
    mut free: impl FnMut() -> F,
    most: u64,
) -> RealRun {
    let mut best: Option<RealRun> = None;
    let mut learned = Knowledge::new();
    let mut readings = BTreeSet::new();
    let mut needed: BTreeMap<AreaId, u32> = BTreeMap::new();
    // What a controller cannot do that has one of the cases is no lower bound for all.
    let rank = |one: &RealRun| (one.is_possible(), one.replay.total);
    let run = |fixed: &Readings| {
        let (mut shortest, mut undecided): (Option<RealRun>, _) = (None, None);
        let mut next = Some(Cases::of_scan(fixed.clone()));
        while let Some(case) = next {
            let machine = machine::Machine::new(program, times, free(), Mode::Real);
            let (mut found, state) = machine.real(most, case);
            for (moment, facts) in std::mem::take(&mut found.learned) {
                let known = learned.entry(moment).or_default();
                for fact in facts {
                    if !known.contains(&fact) {
                        known.push(fact);
                    }
                }
            }
            for (&area, &count) in &found.needed_devices {
                let most = needed.entry(area).or_default();
                *most = count.max(*most);
            }
            shortest = shortest.into_iter().chain([found]).min_by_key(rank);
            undecided = undecided.or(state.cases.undecided());
            next = state.cases.following();
        }
        (shortest, undecided)
    };
    in_all_readings(run, |fixed, shortest| {
        readings.extend(fixed.keys());
        best = best.take().into_iter().chain(shortest).min_by_key(rank);
        true
    });
    let best = best.expect("there is a case");
    RealRun { learned, readings, needed_devices: needed, ..best }
}

/// Makes one real run of at most `most` instructions, and records what it reads and writes. If there are several cases
/// ([`real`]), it is the first one.
#[must_use]
pub fn traced(
    program: &Program,
    times: &[Times],
    free: impl FreeValues,
    most: u64,
) -> (RealRun, Trace) {
    machine::Machine::new(program, times, free, Mode::Real).traced(most)
}

/// Runs one scan of the program on the witness's values. An operation is executed where the analysis computed it
/// ([`Witness::resolutions`]). Where a real run observed it with the same values, it gives the observed result;
/// elsewhere its result is the witness's value of the choice.
#[must_use]
pub fn replay_knowing(
    program: &Program,
    times: &[Times],
    knowledge: &Knowledge,
    witness: &Witness,
) -> Replay {
    machine::Machine::new(program, times, witness, Mode::Model).knowing(knowledge).scan()
}

/// Runs one scan as the analysis models it (operations may have any result) and asks `free` for each start value and
/// choice when it is needed.
#[must_use]
pub fn replay_with(program: &Program, times: &[Times], free: impl FreeValues) -> Replay {
    machine::Machine::new(program, times, free, Mode::Model).scan()
}

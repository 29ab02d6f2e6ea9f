//! What a real run (a scan simulated as on a PLC) shows about the model's charges and free variables.

use super::real::RunResults;
use scanbound_base::time::Picos;
use scanbound_ir::{ChoiceKey, Frame, Program, Step};
use scanbound_model::{Assignment, Origin, ScanModel};
use scanbound_replay::{RealRun, StopReason, Stopped};
use std::collections::BTreeMap;

/// The end of a message about an operation error: what to state if the CPU continues after it.
const CHOICE: &str = "; if the CPU's parameters let it continue after an operation error, state [scan] on_error = \"continue\"";

/// The executions of a scan, by instruction and call context: whether the instruction fired there, and its time.
pub struct Executed(BTreeMap<(usize, Vec<Frame>), (bool, Picos)>);

impl Executed {
    /// The executions of a real run. Those in the iterations of a loop that the model does not follow are combined into
    /// one, with the sum of their times.
    pub fn of(program: &Program, real: &RealRun) -> Executed {
        let mut executed: BTreeMap<(usize, Vec<Frame>), (bool, Picos)> = BTreeMap::new();
        let is_summary =
            |frame: &&Frame| !matches!(program.instructions[frame.at].step, Step::Summary(_));
        for event in &real.replay.events {
            let frames: Vec<Frame> = event.frames.iter().take_while(is_summary).copied().collect();
            let known = executed.entry((event.instruction, frames)).or_default();
            *known = (known.0 | event.fired, known.1 + event.cost);
        }
        Executed(executed)
    }

    /// Whether control reached the instruction in this call context, whether it fired, and its time. False and zero if
    /// the run did not execute it there.
    pub fn at(&self, instruction: usize, frames: &[Frame]) -> (bool, bool, Picos) {
        let found = self.0.get(&(instruction, frames.to_vec()));
        found.map_or((false, false, Picos::ZERO), |&(fired, cost)| (true, fired, cost))
    }

    /// The instruction and the time of every execution. An instruction occurs once for each call context.
    pub fn costs(&self) -> impl Iterator<Item = (usize, Picos)> + '_ {
        self.0.iter().map(|((instruction, _), (_, cost))| (*instruction, *cost))
    }
}

/// The values of the model's variables in the longest real run: its start values and nondeterministic values. 0 for
/// variables to which the run gave no value.
pub fn started(model: &ScanModel, found: &RunResults) -> Assignment {
    let value = |origin: &Origin| match origin {
        Origin::Start(cell) => found.witness.start.get(cell).copied(),
        Origin::Choice(key) => found.witness.choices.get(key).copied(),
        &Origin::Havocked { cell, since, until } => {
            model.havocs.concerning(cell, since, until).find_map(|moment| {
                let (frames, choice) = (moment.frames.clone(), moment.choice);
                found.witness.choices.get(&ChoiceKey { frames, choice, cell: Some(cell) }).copied()
            })
        }
    };
    Assignment(model.variables.iter().map(|one| value(&one.origin).unwrap_or(0)).collect())
}

/// Why no real run was found that takes as long as the model's longest scan, as a text for reports. `real` is the
/// longest real run found.
pub fn stands_between(program: &Program, real: &RealRun) -> String {
    let at = |instruction: usize| {
        let one = &program.instructions[instruction];
        let file = &one.place.of(&program.files).name;
        let file = if program.files.len() > 1 { format!("{file}:") } else { String::new() };
        format!("`{}` ({file}{})", one.text, one.place.line)
    };
    match &real.stopped {
        Some(Stopped { at: stop, reason: StopReason::Unknown(cause), .. }) if stop == cause => {
            format!(
                "the simulation stops at {}: which instruction follows it is unknown",
                at(*stop)
            )
        }
        Some(Stopped { at: stop, reason: StopReason::Unknown(cause), .. }) => {
            format!(
                "the simulation stops at {}: its path depends on the result of {}, which is unknown",
                at(*stop),
                at(*cause)
            )
        }
        Some(Stopped { at: stop, reason: StopReason::Error, .. }) if !real.readings.is_empty() => {
            format!(
                "on some controllers, an operation error at {} stops the CPU in every scan that was tried; state under [controller] whether yours does this: {}{CHOICE}",
                at(*stop),
                readings(program, real)
            )
        }
        Some(Stopped { at: stop, reason: StopReason::Error, .. }) => {
            format!(
                "an operation error at {} stops the CPU in every scan that was tried{CHOICE}",
                at(*stop)
            )
        }
        Some(Stopped { at: stop, reason: StopReason::TooLong, .. }) => {
            format!(
                "the simulation was stopped at {} because the scan executes more instructions than the simulation's limit",
                at(*stop)
            )
        }
        _ => {
            let why =
                "the model's longest scan needs a combination of values that no simulated scan had";
            let error = program.errors.keys().next();
            let stops = error.map(|&first| {
                format!(
                    "; a simulated scan ends where an operation error stops the CPU (first possible at {}){CHOICE}",
                    at(first)
                )
            });
            let differ = match real.readings.is_empty() {
                true => String::new(),
                false => format!(
                    ", or needs another controller: the simulated scan takes the shortest time that any controller takes; state under [controller] whether yours does this: {}",
                    readings(program, real)
                ),
            };
            why.to_owned() + &differ + &stops.unwrap_or_default()
        }
    }
}

/// The readings of a standard (points in which controllers differ from it) on which a run depends, in quotes as a facts
/// file names them, joined by commas.
fn readings(program: &Program, real: &RealRun) -> String {
    let names = real.readings.iter();
    let names = names.map(|&number| format!("\"{}\"", program.readings[number as usize]));
    names.collect::<Vec<String>>().join(", ")
}

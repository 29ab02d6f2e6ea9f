//! How often interrupts with fixed intervals are due in a scan of a given time.

use super::doubt::Doubt;
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use scanbound_ir::{Frame, Interrupt, Program};
use scanbound_replay::RealRun;
use std::collections::BTreeSet;

/// The largest number of runs of an interrupt of this interval in a scan of this time: one at its start, and one each
/// time that the interval has passed before its end. An interrupt during END processing waits for the next scan. That
/// does not add a run, because one in the END processing of this scan waits, too. If the program can let interrupts
/// wait (`holds_interrupts`), one more may be left over from earlier scans.
pub(super) fn due(scan: Picos, interval: Picos, holds_interrupts: bool) -> u64 {
    let due = scan.0.div_ceil(interval.0.max(1)).max(1);
    due.saturating_add(holds_interrupts.into())
}

/// A doubt for each interrupt with a stated interval that is due more often in a scan of the time `longest` than a scan
/// is charged.
pub(super) fn too_few(program: &Program, facts: &Facts, longest: Picos) -> Vec<Doubt> {
    let of = |one: &Interrupt| {
        let every = *facts.intervals.get(&one.name.to_ascii_uppercase())?;
        let due = due(longest, every, program.scan_control.holds_interrupts);
        let (name, taken) = (one.name.clone(), one.times);
        let is_too_few = one.stated && due > u64::from(taken);
        is_too_few.then_some(Doubt::TooFewInterrupts { name, every, taken, due })
    };
    program.interrupts.iter().filter_map(of).collect()
}

/// The time that a real run spent in interrupt routines that it was given more often than they are due in a scan of its
/// length, `took`. All runs of such a routine count. Without them the scan is shorter, so that others may no longer be
/// due; this is repeated. Zero if there are none.
pub(super) fn not_due(program: &Program, facts: &Facts, run: &RealRun, took: Picos) -> Picos {
    let mut less = Picos::ZERO;
    loop {
        let left = took.checked_sub(less).unwrap_or_default();
        let is_early = |one: &&Interrupt| {
            let every = facts.intervals.get(&one.name.to_ascii_uppercase());
            let before = u64::from(one.times.saturating_sub(1));
            every.is_some_and(|every| every.0.saturating_mul(before) >= left.0 && one.times > 1)
        };
        let early: BTreeSet<usize> =
            program.interrupts.iter().filter(is_early).map(|one| one.entry).collect();
        let events = run.replay.events.iter();
        let of_early = events.filter(|event| Frame::in_interrupt(&event.frames, &early));
        let found: Picos = of_early.map(|event| event.cost).sum();
        if found <= less {
            return less;
        }
        less = found;
    }
}

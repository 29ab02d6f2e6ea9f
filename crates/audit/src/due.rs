//! How often interrupts at fixed intervals are due in a scan of a known time.

use super::doubt::Doubt;
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use scanbound_ir::{Frame, Interrupt, Program};
use scanbound_replay::RealRun;
use std::collections::BTreeSet;

/// How often an interrupt of this interval runs at most in a scan of this time: once at the start, and again each time
/// the interval has passed. One that occurs during END processing waits for the next scan; since one that occurs in the
/// END processing of this scan waits, too, this adds none. If the program can let interrupts wait (`holds_interrupts`),
/// one more may be left from earlier scans.
pub(super) fn due(scan: Picos, interval: Picos, holds_interrupts: bool) -> u64 {
    let due = scan.0.div_ceil(interval.0.max(1)).max(1);
    due.saturating_add(holds_interrupts.into())
}

/// The interrupts that the longest scan was charged too few of: their intervals make them due more often in it.
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

/// How much shorter a scan that was found can be if interrupts ran in it more often than they are due in its time.
/// Removing these interrupts shortens the scan, so that others may no longer be due; this is repeated.
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

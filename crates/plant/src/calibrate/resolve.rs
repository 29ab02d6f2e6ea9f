//! Subtracts the times of the other instructions that copies need besides the measured one.

use super::plan::{Measure, State};
use scanbound_base::time::Picos;
use std::collections::BTreeMap;

/// An interval that contains a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interval {
    /// The smallest possible time.
    pub low: Picos,
    /// The largest possible time.
    pub high: Picos,
}

/// The known times of instructions, by whether they fire.
type Known = BTreeMap<(String, bool), Interval>;

/// Converts measured times of whole copies to times of the instructions alone. Another instruction in the copy that was
/// not measured itself may take anything from no time to all of it.
pub(super) fn resolved(mut measured: Vec<(&Measure, Interval)>) -> Vec<(&Measure, Interval)> {
    let mut known = Known::new();
    let mut done = vec![false; measured.len()];
    let fires = |one: &Measure| one.state != State::Off;
    let mut open: std::collections::BTreeSet<(String, bool)> =
        measured.iter().map(|(one, _)| (one.own.clone(), fires(one))).collect();
    loop {
        // Those whose other instructions are all known. If there are none: those that need each other.
        let settled = |(one, _): &(&Measure, Interval)| {
            one.besides.iter().all(|beside| !open.contains(&(beside.line.clone(), beside.on)))
        };
        let mut now: Vec<usize> =
            (0..measured.len()).filter(|at| !done[*at] && settled(&measured[*at])).collect();
        if now.is_empty() {
            now = (0..measured.len()).filter(|at| !done[*at]).collect();
        }
        if now.is_empty() {
            return measured;
        }
        for &at in &now {
            let (one, whole) = measured[at];
            measured[at].1 = alone(one, whole, &known);
            done[at] = true;
        }
        for &at in &now {
            let (one, time) = measured[at];
            let key = (one.own.clone(), fires(one));
            let wider = |known: &mut Interval| {
                *known = Interval { low: known.low.min(time.low), high: known.high.max(time.high) };
            };
            known.entry(key.clone()).and_modify(wider).or_insert(time);
        }
        for (at, (one, _)) in measured.iter().enumerate() {
            let key = (one.own.clone(), fires(one));
            let waits = measured.iter().zip(&done).any(|((other, _), done)| {
                !done && other.own == one.own && fires(other) == fires(one)
            });
            if done[at] && !waits {
                open.remove(&key);
            }
        }
    }
}

/// The part of a whole copy's time that the instruction takes.
fn alone(one: &Measure, whole: Interval, known: &Known) -> Interval {
    let (mut low, mut high) = (whole.low.0, whole.high.0);
    for beside in &one.besides {
        match known.get(&(beside.line.clone(), beside.on)) {
            Some(time) => {
                low = low.saturating_sub(time.high.0);
                high = high.saturating_sub(time.low.0);
            }
            None => low = 0,
        }
    }
    let runs = one.runs.max(1);
    Interval { low: Picos(low / runs), high: Picos(high.div_ceil(runs)) }
}

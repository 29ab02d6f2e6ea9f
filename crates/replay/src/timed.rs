//! Timers and counters of an emulated CPU: computes the flag and present value that one execution produces.

use super::words::bcd;
use scanbound_base::time::Picos;
use scanbound_ir::Cell;
use scanbound_ir::timers::{TimerKind, TimerOrCounter};
use std::collections::{BTreeMap, BTreeSet};

/// What timers and counters remember between two executions. The key is the cell of the flag.
#[derive(Debug, Clone, Default)]
pub(super) struct TimerMemory {
    /// For each running timer: the tick at which it was last executed, and the number of the scan that executed it.
    ran: BTreeMap<Cell, (u64, u64)>,
    /// Timers of which it is unknown whether, and since when, they run: an input was unknown when they were executed.
    unknown: BTreeSet<Cell>,
    /// The number of the current scan, if scans are counted.
    scan: u64,
    /// For each counter: the values of its inputs at its last execution.
    were: BTreeMap<Cell, Vec<bool>>,
}

/// The values that the instruction of a timer or counter reads when it is executed, and what is known of them.
#[derive(Debug, Clone)]
pub struct TimedInputs {
    /// The time at which the instruction is executed. [`FreeValues::timed`](super::FreeValues::timed) gets the time
    /// since the scan began, and adds the time from power-up to there.
    pub now: Picos,
    /// False inside a master control region that is off. For an instruction without inputs, also if its condition is
    /// false.
    pub condition: bool,
    /// The values of the instruction's input contacts, in the order in which the program gives them.
    pub inputs: Vec<bool>,
    /// What a counter remembers of its counting inputs, where the cells of a run say it.
    pub seen: Vec<Option<bool>>,
    /// The set value as a word, binary or BCD as the instruction expects it.
    pub setting: u16,
    /// The completion flag of the timer or counter before the execution.
    pub flag: bool,
    /// The present value as a word, before the execution.
    pub present: u16,
    /// Whether the completion flag and the present value are known.
    pub is_known: bool,
    /// Whether the timer may have been reset while it was running, since its last execution.
    pub was_reset: bool,
}

impl TimerMemory {
    /// The next time since power-up at which a scan may differ because of this timer: one tick before its end, or its
    /// end. If the program reads present values (`matters`), it is the next tick. `None` if the timer does not run or
    /// has timed out. `at` holds its set value and its present value.
    pub(super) fn next(
        &self,
        timed: &TimerOrCounter,
        at: [u16; 2],
        matters: bool,
    ) -> Option<Picos> {
        let (TimerKind::DownTimer(base)
        | TimerKind::UpTimer(base, _)
        | TimerKind::RetentiveTimer(base)) = timed.kind
        else {
            return None;
        };
        let (last, _) = *self.ran.get(&timed.flag)?;
        let [setting, present] = at.map(|word| match timed.is_decimal {
            true => bcd(&[word]).and_then(|value| u64::try_from(value).ok()),
            false => Some(u64::from(word)),
        });
        let left = match timed.kind {
            TimerKind::DownTimer(_) => present?,
            _ => setting?.saturating_sub(present?),
        };
        let ticks = match left {
            0 => return None,
            _ if matters => 1,
            1 => 1,
            more => more - 1,
        };
        base.0.checked_mul(last.checked_add(ticks)?).map(Picos)
    }

    /// Adds one to the number of the current scan: the next scan begins now.
    pub(super) fn begin_scan(&mut self) {
        self.scan += 1;
    }

    /// Adds `times` to the number of the current scan, for scans that repeat the last one. A timer that was executed in
    /// the last one counts as executed in all of them.
    pub(super) fn repeat_scan(&mut self, times: u64) {
        let last = self.scan;
        self.scan += times;
        for (_, scan) in self.ran.values_mut().filter(|(_, scan)| *scan == last) {
            *scan = self.scan;
        }
    }

    /// Notes that a timer or counter was executed with an unknown input.
    pub(super) fn lose(&mut self, timed: &TimerOrCounter) {
        self.unknown.insert(timed.flag);
    }

    /// The flag and the present value after an execution. `None` if they depend on earlier values that are unknown, if
    /// the timer was running and was not executed in the last scan (manuals do not say how much of that time counts),
    /// or if it depends on whether a timer that was reset goes on or starts anew.
    pub(super) fn execute(
        &mut self,
        timed: &TimerOrCounter,
        found: &TimedInputs,
    ) -> Option<(bool, u16)> {
        let (flag, present) = (found.flag, found.present);
        let last = self.ran.get(&timed.flag);
        let runs = last.is_some();
        let was_skipped = last.is_some_and(|(_, scan)| scan + 1 < self.scan);
        let resets = found.inputs.last() == Some(&true);
        let left = self.execute_known(timed, found, (flag, present));
        if found.was_reset && runs && found.condition {
            let anew = TimerMemory::default().execute_known(timed, found, (flag, present));
            if anew != left {
                return None;
            }
        }
        let (is_at_rest, is_new) = match timed.kind {
            TimerKind::DownTimer(_) | TimerKind::UpTimer(_, false) => (!found.condition, !runs),
            TimerKind::UpTimer(_, true) => (false, false),
            TimerKind::RetentiveTimer(_) | TimerKind::DownCounter | TimerKind::RingCounter => {
                (found.condition && resets, false)
            }
        };
        // With a set value that is not valid BCD, the CPU does not execute the instruction.
        let is_executed = !timed.is_decimal || bcd(&[found.setting]).is_some();
        if is_at_rest && is_executed {
            self.unknown.remove(&timed.flag);
        }
        if self.unknown.contains(&timed.flag) {
            return None;
        }
        let is_new = is_executed && (is_at_rest || is_new);
        (is_new || (found.is_known && !was_skipped)).then_some(left)
    }

    /// As [`Self::execute`], if the flag and the present value are known. If the set value is not valid BCD, nothing
    /// changes.
    fn execute_known(
        &mut self,
        timed: &TimerOrCounter,
        found: &TimedInputs,
        (flag, present): (bool, u16),
    ) -> (bool, u16) {
        let number = |word: u16| match timed.is_decimal {
            true => bcd(&[word]).and_then(|value| u16::try_from(value).ok()),
            false => Some(word),
        };
        // The set value is not a valid number, so the CPU does not execute the instruction.
        let Some(setting) = number(found.setting) else { return (flag, present) };
        let present_before = number(present).unwrap_or(0);
        let (flag, stands) = match timed.kind {
            TimerKind::DownTimer(base) => match self.passed(timed.flag, base, found) {
                None => (false, setting),
                Some(passed) => {
                    let from = if passed.begins { setting } else { present_before.min(setting) };
                    let left = from.saturating_sub(passed.ticks);
                    (left == 0, left)
                }
            },
            TimerKind::UpTimer(base, holds) => match self.passed(timed.flag, base, found) {
                None if holds => (flag, present_before),
                None => (false, 0),
                Some(passed) => {
                    let from = if passed.begins && !holds { 0 } else { present_before };
                    let at = from.saturating_add(passed.ticks).min(setting);
                    (at >= setting || (holds && flag), at)
                }
            },
            TimerKind::RetentiveTimer(base) => {
                let [runs, resets] = [0, 1].map(|at| found.inputs.get(at) == Some(&true));
                let runs = TimedInputs { condition: found.condition && runs, ..found.clone() };
                match self.passed(timed.flag, base, &runs) {
                    _ if found.condition && resets => (false, 0),
                    None => (flag, present_before),
                    Some(passed) => {
                        let at = present_before.saturating_add(passed.ticks).min(setting);
                        (at >= setting, at)
                    }
                }
            }
            TimerKind::DownCounter | TimerKind::RingCounter => {
                self.counted(timed, found, setting, flag, present_before)
            }
        };
        (flag, if timed.is_decimal { digits(stands) } else { stands })
    }

    /// How many ticks have passed since a running timer was last executed. `None` if its condition is false; then it no
    /// longer runs.
    fn passed(&mut self, flag: Cell, base: Picos, found: &TimedInputs) -> Option<PassedTicks> {
        if !found.condition {
            self.ran.remove(&flag);
            return None;
        }
        let now = found.now.0 / base.0.max(1);
        let last = self.ran.insert(flag, (now, self.scan)).map(|(tick, _)| tick);
        let ticks = u16::try_from(now - last.unwrap_or(now)).unwrap_or(u16::MAX);
        Some(PassedTicks { begins: last.is_none(), ticks })
    }

    fn counted(
        &mut self,
        timed: &TimerOrCounter,
        found: &TimedInputs,
        setting: u16,
        flag: bool,
        present_before: u16,
    ) -> (bool, u16) {
        let is_down = timed.kind == TimerKind::DownCounter;
        let is_first = !self.were.contains_key(&timed.flag);
        let resets = found.inputs.last() == Some(&true);
        let start = if is_down { setting } else { 0 };
        // Nothing is known of this counter yet: it is treated as if it had been reset.
        let (flag, present_before) = if is_first { (false, start) } else { (flag, present_before) };
        if !found.condition {
            self.were.entry(timed.flag).or_insert_with(|| found.inputs.clone());
            return (flag, present_before);
        }
        let were = self.were.insert(timed.flag, found.inputs.clone()).unwrap_or_default();
        let was = |at: usize| found.seen.get(at).copied().flatten().or(were.get(at).copied());
        let rises = |at: usize| found.inputs.get(at) == Some(&true) && was(at) != Some(true);
        match (is_down, rises(0), !is_down && rises(1)) {
            _ if resets => (false, start),
            (true, true, _) if present_before > 0 => (present_before == 1, present_before - 1),
            (false, true, false) if present_before >= setting => (true, 0),
            (false, true, false) => (false, present_before + 1),
            (false, false, true) if present_before == 0 => (true, setting),
            (false, false, true) => (false, present_before - 1),
            (true, ..) => (present_before == 0, present_before),
            (false, ..) => (flag, present_before),
        }
    }
}

/// The progress of a running timer: whether it starts now, and the ticks since its last execution (at most 65,535).
struct PassedTicks {
    begins: bool,
    ticks: u16,
}

/// The lowest four decimal digits of a number, as BCD.
fn digits(value: u16) -> u16 {
    (0..4).fold(0, |word, place| word | (value / 10u16.pow(place) % 10) << (4 * place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_ir::{AreaId, WordSource};

    #[test]
    fn a_lost_timer_is_found_again_only_by_an_execution_with_a_false_condition() {
        let cell = |index| Cell { area: AreaId(0), index };
        let timer = TimerOrCounter {
            kind: TimerKind::DownTimer(Picos(100)),
            flag: cell(0),
            present: cell(1),
            setting: WordSource::Const(0),
            is_decimal: true,
            inputs: Vec::new(),
            seen: Vec::new(),
            running: None,
            parts: 0..0,
        };
        let found = |condition, setting| TimedInputs {
            now: Picos(0),
            condition,
            inputs: Vec::new(),
            seen: Vec::new(),
            setting,
            flag: false,
            present: 0,
            is_known: false,
            was_reset: false,
        };
        let mut memory = TimerMemory::default();
        memory.lose(&timer);
        assert_eq!(memory.execute(&timer, &found(true, 0x10)), None);
        // The set value is not valid BCD: the CPU does not execute the timer, so it may still run.
        assert_eq!(memory.execute(&timer, &found(false, 0xA)), None);
        assert_eq!(memory.execute(&timer, &found(true, 0x10)), None);
        assert_eq!(memory.execute(&timer, &found(false, 0x10)), Some((false, 0x10)));
        assert_eq!(memory.execute(&timer, &found(true, 0x10)), Some((false, 0x10)));
    }
}

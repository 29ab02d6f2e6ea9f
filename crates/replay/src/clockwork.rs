//! The timers and counters of an emulated CPU: what becomes of each when its instruction is executed.

use super::words::bcd;
use scanbound_base::time::Picos;
use scanbound_ir::Cell;
use scanbound_ir::timed::{Manner, Timed};
use std::collections::BTreeMap;

/// What is remembered of timers and counters between two executions, by their flags.
#[derive(Debug, Clone, Default)]
pub(super) struct Clockwork {
    /// The tick at which a timer that runs was executed last.
    ran: BTreeMap<Cell, u64>,
    /// What a counter's inputs were.
    were: BTreeMap<Cell, Vec<bool>>,
}

/// What an instruction finds when it is executed.
#[derive(Debug, Clone)]
pub struct Found {
    /// How long the CPU has been running.
    pub now: Picos,
    /// Whether no master control region holds it off, and of one without inputs its condition.
    pub condition: bool,
    /// Its inputs.
    pub inputs: Vec<bool>,
    /// Its setting's word.
    pub setting: u16,
    /// Its flag.
    pub flag: bool,
    /// Its present value's word.
    pub present: u16,
    /// Whether flag and present value are known.
    pub is_known: bool,
}

impl Clockwork {
    /// The next moment at which a timer that was running at its last execution comes closer to its end: one tick before
    /// it, then at its end; at every tick if each of them `matters`. `None` if it does not run or is over. `at` is what its
    /// setting and its present value say.
    pub(super) fn next(&self, timed: &Timed, at: [u16; 2], matters: bool) -> Option<Picos> {
        let (Manner::TimesDown(base) | Manner::TimesUp(base, _) | Manner::AddsUp(base)) =
            timed.manner
        else {
            return None;
        };
        let last = *self.ran.get(&timed.flag)?;
        let [setting, present] = at.map(|word| match timed.is_decimal {
            true => bcd(&[word]).and_then(|value| u64::try_from(value).ok()),
            false => Some(u64::from(word)),
        });
        let left = match timed.manner {
            Manner::TimesDown(_) => present?,
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

    /// The flag and the present value's word that an execution leaves; `None` where that depends on what they were and that
    /// is not known.
    pub(super) fn execute(&mut self, timed: &Timed, found: &Found) -> Option<(bool, u16)> {
        let (flag, present) = (found.flag, found.present);
        let runs = self.ran.contains_key(&timed.flag);
        let resets = found.inputs.last() == Some(&true);
        let left = self.leaves(timed, found, (flag, present));
        let is_new = match timed.manner {
            Manner::TimesDown(_) | Manner::TimesUp(_, false) => !found.condition || !runs,
            Manner::TimesUp(_, true) => false,
            Manner::AddsUp(_) | Manner::CountsDown | Manner::CountsBothWays => resets,
        };
        (found.is_known || is_new).then_some(left)
    }

    /// The same where that is known.
    fn leaves(
        &mut self,
        timed: &Timed,
        found: &Found,
        (flag, present): (bool, u16),
    ) -> (bool, u16) {
        let number = |word: u16| match timed.is_decimal {
            true => bcd(&[word]).and_then(|value| u16::try_from(value).ok()),
            false => Some(word),
        };
        // A setting that is no number: the instruction is not carried out.
        let Some(setting) = number(found.setting) else { return (flag, present) };
        let stood = number(present).unwrap_or(0);
        let (flag, stands) = match timed.manner {
            Manner::TimesDown(base) => match self.passed(timed.flag, base, found) {
                None => (false, setting),
                Some(passed) => {
                    let from = if passed.begins { setting } else { stood.min(setting) };
                    let left = from.saturating_sub(passed.ticks);
                    (left == 0, left)
                }
            },
            Manner::TimesUp(base, holds) => match self.passed(timed.flag, base, found) {
                None if holds => (flag, stood),
                None => (false, 0),
                Some(passed) => {
                    let from = if passed.begins && !holds { 0 } else { stood };
                    let at = from.saturating_add(passed.ticks).min(setting);
                    (at >= setting || (holds && flag), at)
                }
            },
            Manner::AddsUp(base) => {
                let [runs, resets] = [0, 1].map(|at| found.inputs.get(at) == Some(&true));
                let runs = Found { condition: found.condition && runs, ..found.clone() };
                match self.passed(timed.flag, base, &runs) {
                    _ if resets => (false, 0),
                    None => (flag, stood),
                    Some(passed) => {
                        let at = stood.saturating_add(passed.ticks).min(setting);
                        (at >= setting, at)
                    }
                }
            }
            Manner::CountsDown | Manner::CountsBothWays => {
                self.counted(timed, found, setting, flag, stood)
            }
        };
        (flag, if timed.is_decimal { digits(stands) } else { stands })
    }

    /// How many ticks have passed since a timer that runs was executed last.
    fn passed(&mut self, flag: Cell, base: Picos, found: &Found) -> Option<Passed> {
        if !found.condition {
            self.ran.remove(&flag);
            return None;
        }
        let now = found.now.0 / base.0.max(1);
        let last = self.ran.insert(flag, now);
        let ticks = u16::try_from(now - last.unwrap_or(now)).unwrap_or(u16::MAX);
        Some(Passed { begins: last.is_none(), ticks })
    }

    fn counted(
        &mut self,
        timed: &Timed,
        found: &Found,
        setting: u16,
        flag: bool,
        stood: u16,
    ) -> (bool, u16) {
        let is_down = timed.manner == Manner::CountsDown;
        let is_first = !self.were.contains_key(&timed.flag);
        let resets = found.inputs.last() == Some(&true);
        let start = if is_down { setting } else { 0 };
        // A counter of which nothing is known yet stands as if it was reset.
        let (flag, stood) = if is_first { (false, start) } else { (flag, stood) };
        if !found.condition {
            self.were.entry(timed.flag).or_insert_with(|| found.inputs.clone());
            return (flag, stood);
        }
        let were = self.were.insert(timed.flag, found.inputs.clone()).unwrap_or_default();
        let rises =
            |at: usize| found.inputs.get(at) == Some(&true) && were.get(at).copied() != Some(true);
        match (is_down, rises(0), !is_down && rises(1)) {
            _ if resets => (false, start),
            (true, true, _) if stood > 0 => (stood == 1, stood - 1),
            (false, true, false) if stood >= setting => (true, 0),
            (false, true, false) => (false, stood + 1),
            (false, false, true) if stood == 0 => (true, setting),
            (false, false, true) => (false, stood - 1),
            (true, ..) => (stood == 0, stood),
            (false, ..) => (flag, stood),
        }
    }
}

/// What has passed for a timer that runs.
struct Passed {
    begins: bool,
    ticks: u16,
}

/// Four decimal digits.
fn digits(value: u16) -> u16 {
    (0..4).fold(0, |word, place| word | (value / 10u16.pow(place) % 10) << (4 * place))
}

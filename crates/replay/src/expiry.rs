//! Timers in real runs: whether a timer has timed out, and its present value.

use super::state::State;
use super::timed::TimedInputs;
use super::words::bcd;
use scanbound_base::time::Picos;
use scanbound_ir::timers::{Expiry, TimerKind, TimerOrCounter};
use scanbound_ir::{AreaKind, Cell, ChoiceId, WordSource};

impl<'p> State<'p> {
    /// The value of an external choice. If the choice says whether a timer has timed out, or how far it has run,
    /// `given` is corrected, or becomes unknown, where it contradicts the time that can have passed. Otherwise it is
    /// `given`.
    pub(super) fn expiry(&mut self, choice: ChoiceId, given: u16) -> u16 {
        let timekeeping = &self.program.timekeeping;
        if let Some(over) = timekeeping.elapsed.get(&choice) {
            // A timer that starts in this scan has not run yet.
            let expiry = timekeeping.expiries.get(over);
            let starts = expiry.is_some_and(|expiry| self.has_rested(expiry.memory));
            let given = if starts { 0 } else { given };
            let present_value = expiry.and_then(|expiry| self.present_or_remaining(expiry, None));
            if present_value
                .is_some_and(|present_value| i64::from(given.cast_signed()) > present_value + 1)
            {
                self.doubt = self.doubt.or(Some(self.at));
            }
            return given;
        }
        let Some(expiry) = timekeeping.expiries.get(&choice) else { return given };
        let Some(setting) = self.setting(expiry) else {
            self.doubt = self.doubt.or(Some(self.at));
            return given;
        };
        // A run that counts time computes this timer from the simulated time. Where it could not, the result is
        // unknown.
        let given = match self.free.counts_time() && self.current_timer().is_some() {
            true => {
                self.doubt = self.doubt.or(Some(self.at));
                given
            }
            false => self.expired(expiry, setting, given),
        };
        // One scan changes the present value by one unit. This matters if the program has read the value before.
        let is_over = given & 1 != u16::from(expiry.while_running);
        let left = self.present_or_remaining(expiry, Some(setting));
        if is_over && left.is_some_and(|left| left > 1) {
            self.doubt = self.doubt.or(Some(self.at));
        }
        let is_open = |state: &mut Self, present_value: Cell| {
            let present_value = state.read(present_value).cast_signed();
            let setting = i64::from((setting as u16).cast_signed());
            setting < 1
                || present_value < 0
                || (i64::from(present_value) >= setting && given & 1 == 0)
        };
        if expiry.previous.is_some_and(|present_value| is_open(self, present_value)) {
            self.doubt = self.doubt.or(Some(self.at));
        }
        given
    }

    /// In a run of scans that follow each other: whether the choice depends on earlier scans in a way that the run does
    /// not follow (`Timekeeping::untracked`). False in other runs.
    pub(super) fn is_uncounted(&self, choice: ChoiceId) -> bool {
        let follows_scans = self.free.counts_time() || self.free.passed().is_some();
        follows_scans && self.program.timekeeping.untracked.contains(&choice)
    }

    /// The set value of a timer in its units. `None` if it is unknown, may change at any moment, or is not valid BCD.
    fn setting(&mut self, expiry: &Expiry) -> Option<u64> {
        let program = self.program;
        let changes = |word: &WordSource| match *word {
            WordSource::Cell(cell) => program.volatile.iter().any(|region| region.contains(cell)),
            _ => false,
        };
        let outer = self.doubt.take();
        let words: Vec<u16> = expiry.setting.iter().map(|&word| self.word(word)).collect();
        let doubt = std::mem::replace(&mut self.doubt, outer);
        let is_known = doubt.is_none() && !expiry.setting.iter().any(changes);
        let setting = match expiry.is_decimal {
            true => bcd(&words).and_then(|value| u64::try_from(value).ok()),
            false => Some(words.iter().rev().fold(0, |all, &word| all << 16 | u64::from(word))),
        };
        setting.filter(|_| is_known)
    }

    /// Whether the timer has timed out: the value `given` from outside, unless the time decides it.
    fn expired(&mut self, expiry: &Expiry, setting: u64, given: u16) -> u16 {
        let over = u16::from(!expiry.while_running);
        let has_rested = self.has_rested(expiry.memory);
        if !has_rested && expiry.flag.is_some_and(|flag| self.read(flag) & 1 == 1) {
            // A setting that has grown since may or may not matter.
            let is_fixed = expiry.setting.iter().all(|word| matches!(word, WordSource::Const(_)));
            if !is_fixed && given & 1 != over {
                self.doubt = self.doubt.or(Some(self.at));
            }
            return if is_fixed { over } else { given };
        }
        let timekeeping = &self.program.timekeeping;
        if given & 1 == over && timekeeping.are_kept && expiry.can_be_kept() {
            self.doubt = self.doubt.or(Some(self.at));
        }
        let gap = timekeeping.least_gaps.get(&expiry.memory);
        let single = gap.map(|&gap| (gap, Picos(u64::MAX)));
        let ran_for = self.free.ran_for(expiry.memory).or(single);
        let goes_on = ran_for.map(|(least, most)| {
            let now = self.now;
            (least + now, Picos(most.0.saturating_add(now.0)))
        });
        let decided = |ran: Option<(Picos, Picos)>| {
            ran.and_then(|ran| expired_by_time(expiry, setting, ran)).unwrap_or(given)
        };
        if !has_rested {
            return decided(goes_on);
        }
        // PLCs that look at the clock once in a scan have no timer that is over in the scan in which it starts.
        let is_open = expired_by_time(expiry, setting, (Picos::ZERO, self.now)).is_none();
        if expiry.is_asked_again && is_open {
            self.doubt = self.doubt.or(Some(self.at));
        }
        let anew = decided(Some((Picos::ZERO, self.now)));
        if expiry.is_reset && decided(goes_on) != anew {
            self.doubt = self.doubt.or(Some(self.at));
        }
        anew
    }

    /// Whether the timer with this memory cell was at rest at some moment of this scan so far.
    fn has_rested(&mut self, memory: Cell) -> bool {
        let started = self.free.start(memory, AreaKind::Word);
        self.rested.contains(&memory) || self.memories.get(&memory) == Some(&started)
    }

    /// The timer or counter that is being executed, and the index of its first instruction. `None` if the current
    /// instruction belongs to none.
    fn current_timer(&self) -> Option<(usize, &'p TimerOrCounter)> {
        let (&first, timed) =
            self.program.timekeeping.instructions.range(..=self.at).next_back()?;
        let is_current = first == self.at || timed.parts.contains(&self.at);
        is_current.then_some((first, timed))
    }

    /// The present value of the current timer when the scan started; with `setting`, the number of units that remained.
    /// `None` if no earlier instruction has read the value, if it is not valid BCD, or if the run computes timers from
    /// the simulated time.
    fn present_or_remaining(&mut self, expiry: &Expiry, setting: Option<u64>) -> Option<i64> {
        let (first, timed) = self.current_timer()?;
        let read = self.presents.get(&timed.present).copied().flatten();
        if self.free.counts_time() || read.is_none_or(|read| read >= first) {
            return None;
        }
        let (word, _) = self.end_value(expiry.previous.unwrap_or(timed.present));
        let present_value =
            if timed.is_decimal { bcd(&[word])? } else { word.cast_signed().into() };
        let present_value = i64::try_from(present_value).ok()?;
        Some(match (setting, timed.kind) {
            (None, _) | (Some(_), TimerKind::DownTimer(_)) => present_value,
            (Some(setting), _) => i64::try_from(setting).ok()? - present_value,
        })
    }

    /// The completion flag and the present value after a timer or counter was executed. `None` if time is not
    /// simulated, if its cells or its set value are unknown, or if a run does not know whether a counting input rises.
    pub(super) fn executed(
        &mut self,
        timed: &TimerOrCounter,
        now: Picos,
        condition: bool,
        inputs: Vec<bool>,
    ) -> Option<(bool, u16)> {
        if !self.free.simulates_time() {
            return None;
        }
        let outer = self.doubt.take();
        let setting = self.word(timed.setting);
        let setting_doubt = self.doubt.take();
        let (flag, present) = (self.read(timed.flag) & 1 == 1, self.read(timed.present));
        let doubt = std::mem::replace(&mut self.doubt, outer);
        let is_known = doubt.is_none();
        let seen = self.seen(timed);
        let counts = condition && inputs.last() == Some(&false);
        let is_open = counts && inputs.iter().zip(&seen).any(|(&on, seen)| on && seen.is_none());
        let was_reset = timed.running.is_some_and(|running| self.end_value(running).1 != 0);
        let found = TimedInputs {
            now,
            condition,
            inputs,
            seen,
            setting,
            flag,
            present,
            is_known,
            was_reset,
        };
        let after = match setting_doubt {
            Some(_) => {
                self.free.lose_timed(timed);
                None
            }
            None => self.free.timed(timed, &found),
        };
        after.filter(|_| !is_open)
    }

    /// For each counting input of a counter, whether it was on at the last execution. `None` if that is unknown. Empty
    /// if the run is not one whose scans follow each other from power-up.
    fn seen(&mut self, timed: &TimerOrCounter) -> Vec<Option<bool>> {
        if !self.free.counts_time() {
            return Vec::new();
        }
        let memories = timed.seen.iter();
        let value = |(value, unknown): (u16, u16)| (unknown & 1 == 0).then_some(value & 1 == 1);
        memories.map(|memory| memory.and_then(|cell| value(self.end_value(cell)))).collect()
    }
}

/// Whether a timer has timed out, as the value of its choice. `least` and `most` are the possible elapsed times; `None`
/// unless both are below the set value or both above it, by more than the error of the timer's clock.
fn expired_by_time(expiry: &Expiry, setting: u64, (least, most): (Picos, Picos)) -> Option<u16> {
    let time = |units: u64| u128::from(expiry.unit.0) * u128::from(units);
    if u128::from(most.0) < time(setting.saturating_sub(expiry.tick)) {
        return Some(u16::from(expiry.while_running));
    }
    let is_over = u128::from(least.0) > time(setting.saturating_add(expiry.tick));
    is_over.then_some(u16::from(!expiry.while_running))
}

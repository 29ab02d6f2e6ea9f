//! The counter: two BCD digits that count rising edges until they equal the setting, and keep their value without
//! power.

/// The counter with its gates.
#[derive(Debug, Clone)]
pub(super) struct Counter {
    /// The count, 0 to 99.
    pub(super) count: u8,
    /// The rotary switches, 0 to 99.
    setting: u8,
    /// The clock input's latch.
    pub(super) clock: bool,
    /// The clear input's latch.
    pub(super) clear: bool,
    /// The board's clear button.
    button: bool,
    /// The clock behind the gate, which closes when the count equals the setting.
    gated: bool,
}

impl Counter {
    pub(super) fn new(count: u8, setting: u8) -> Counter {
        Counter { count, setting, clock: false, clear: false, button: false, gated: false }
    }

    /// Whether the count equals the setting.
    pub(super) fn matches(&self) -> bool {
        self.count == self.setting
    }

    /// Sets the clock input, as a word of the program does.
    pub(super) fn set_clock(&mut self, on: bool) {
        self.clock = on;
        self.settle();
    }

    /// Sets the clear input, as a word of the program does.
    pub(super) fn set_clear(&mut self, on: bool) {
        self.clear = on;
        self.settle();
    }

    /// Presses or releases the button. It works without power, too.
    pub(super) fn press(&mut self, on: bool) {
        self.button = on;
        self.settle();
    }

    /// Reset: the latches are cleared, the count is kept.
    pub(super) fn reset(&mut self) {
        (self.clock, self.clear) = (false, false);
        self.settle();
    }

    /// Updates the state after one input changed.
    fn settle(&mut self) {
        let clearing = self.clear || self.button;
        if clearing {
            self.count = 0;
        }
        let gated = self.clock && !self.matches();
        if gated && !self.gated && !clearing {
            self.count = (self.count + 1) % 100;
        }
        // Counting up to the setting closes the gate; that is a falling edge, which does not count.
        self.gated = self.clock && !self.matches();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pulse(counter: &mut Counter) {
        counter.set_clock(true);
        counter.set_clock(false);
    }

    #[test]
    fn rising_edges_count_until_the_setting_is_reached() {
        let mut counter = Counter::new(0, 3);
        for expected in [1, 2, 3, 3, 3] {
            assert_eq!(counter.matches(), counter.count == 3);
            pulse(&mut counter);
            assert_eq!(counter.count, expected);
        }
        counter.set_clock(true);
        counter.set_clock(true);
        assert_eq!(counter.count, 3);
    }

    #[test]
    fn a_clock_that_stays_on_counts_once() {
        let mut counter = Counter::new(0, 9);
        counter.set_clock(true);
        counter.set_clock(true);
        assert_eq!(counter.count, 1);
    }

    #[test]
    fn clearing_while_the_clock_is_on_does_not_count() {
        let mut counter = Counter::new(2, 3);
        counter.set_clock(true);
        assert!(counter.matches());
        counter.set_clear(true);
        assert_eq!(counter.count, 0);
        counter.set_clear(false);
        assert_eq!(counter.count, 0);
        counter.set_clock(false);
        pulse(&mut counter);
        assert_eq!(counter.count, 1);
    }

    #[test]
    fn clear_holds_the_count_at_0() {
        let mut counter = Counter::new(7, 9);
        counter.press(true);
        pulse(&mut counter);
        assert_eq!(counter.count, 0);
        counter.press(false);
        pulse(&mut counter);
        assert_eq!(counter.count, 1);
    }

    #[test]
    fn ninety_nine_is_followed_by_0_if_the_setting_was_passed() {
        let mut counter = Counter::new(99, 50);
        pulse(&mut counter);
        assert_eq!(counter.count, 0);
    }

    #[test]
    fn a_setting_of_0_matches_at_once() {
        let mut counter = Counter::new(0, 0);
        assert!(counter.matches());
        pulse(&mut counter);
        assert_eq!(counter.count, 0);
    }
}

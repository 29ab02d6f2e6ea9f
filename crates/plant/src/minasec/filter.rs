//! The input filter: an integrator for each of the eight inputs, with the Schmitt trigger behind it.

/// The filters of the eight inputs.
#[derive(Debug, Clone)]
pub(super) struct Filter {
    /// The time in which the level moves from one end to the other.
    time: u64,
    /// Each input's level, 0 to `time`.
    levels: [u64; 8],
    /// The time for which the levels are valid.
    at: u64,
    /// The levels at the terminals, one bit per input.
    applied: u8,
    /// The filtered inputs, one bit per input.
    passed: u8,
}

impl Filter {
    pub(super) fn new(time: u64) -> Filter {
        Filter { time, levels: [0; 8], at: 0, applied: 0, passed: 0 }
    }

    /// Changes the level at a terminal.
    pub(super) fn apply(&mut self, at: u64, input: u8, on: bool) {
        self.pass(at);
        self.applied = self.applied & !(1 << input) | u8::from(on) << input;
    }

    /// The filtered inputs at a time that is not before the last one.
    pub(super) fn pass(&mut self, at: u64) -> u8 {
        // Inputs whose filter has switched have their levels at one end.
        if self.applied != self.passed
            || self.levels.iter().any(|&level| level != 0 && level != self.time)
        {
            let step = at - self.at;
            for (input, level) in self.levels.iter_mut().enumerate() {
                let bit = 1_u8 << input;
                if self.applied & bit != 0 {
                    *level = level.saturating_add(step).min(self.time);
                    if *level == self.time {
                        self.passed |= bit;
                    }
                } else {
                    *level = level.saturating_sub(step);
                    if *level == 0 {
                        self.passed &= !bit;
                    }
                }
            }
        }
        self.at = at;
        self.passed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_passes_after_the_filters_time() {
        let mut filter = Filter::new(100);
        filter.apply(1000, 3, true);
        assert_eq!(filter.pass(1099), 0);
        assert_eq!(filter.pass(1100), 8);
        filter.apply(2000, 3, false);
        assert_eq!(filter.pass(2099), 8);
        assert_eq!(filter.pass(2100), 0);
    }

    #[test]
    fn what_is_shorter_does_not_pass() {
        let mut filter = Filter::new(100);
        for bounce in 0..20 {
            filter.apply(bounce * 80, 0, true);
            filter.apply(bounce * 80 + 40, 0, false);
            assert_eq!(filter.pass(bounce * 80 + 60), 0);
        }
    }

    #[test]
    fn without_a_filter_edges_pass_at_once() {
        let mut filter = Filter::new(0);
        filter.apply(5, 7, true);
        assert_eq!(filter.pass(5), 0x80);
        filter.apply(6, 7, false);
        assert_eq!(filter.pass(6), 0);
    }
}

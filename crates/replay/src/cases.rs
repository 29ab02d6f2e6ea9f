//! The cases that real runs distinguish: manuals and standards leave some points open, and a lower bound must hold
//! whichever way a controller has them.

use std::collections::BTreeMap;

/// The largest number of loops in a scan for which both cases are tried, one iteration and none.
const MAX_LOOPS: usize = 4;
/// After this many runs, no further reading is fixed. What depends on a reading that is not fixed is unknown, and
/// counts with its least time.
const MAX_RUNS: usize = 64;

/// Whether the controller does something in another way than the standard has it, by the number of
/// [`ChoiceKind::Reading`](scanbound_ir::meaning::ChoiceKind::Reading). A reading without an entry is not fixed.
pub type Readings = BTreeMap<u32, bool>;

/// One case: which way a run takes at each open point.
#[derive(Debug, Clone, Default)]
pub(super) struct Cases {
    /// For each loop of which the manuals do not say whether it makes one iteration or none, in the order of execution:
    /// whether it makes one in this case. Loops beyond the end of the list make none.
    once: Vec<bool>,
    /// The number of loops met so far of which the manuals do not say whether they make one iteration or none.
    met: usize,
    /// Whether both cases, one iteration and none, are tried of a loop of which the manuals do not say which of the two
    /// it makes. Otherwise the run stops at the loop.
    tries_loops: bool,
    /// The readings that are fixed in this case.
    readings: Readings,
    /// Whether all readings that are not in `readings` are those of the standard. Otherwise they are unknown.
    follows_standard: bool,
    /// The unknown readings that the run met, each with the instruction that reads it.
    open: Vec<(usize, u32)>,
    /// The first instruction that made a value unknown on which the run's path or one of its times depends. `None` if
    /// there was none so far.
    cause: Option<usize>,
}

impl Cases {
    /// The first of the cases of a scan with these readings.
    pub(super) fn of_scan(readings: Readings) -> Cases {
        Cases { tries_loops: true, ..Cases::of_run(readings) }
    }

    /// The case of a run of many scans with these readings. The run stops at a loop of which the manuals do not say
    /// whether it makes one iteration or none.
    pub(super) fn of_run(readings: Readings) -> Cases {
        Cases { readings, ..Cases::default() }
    }

    /// The case of a run of many scans on a controller that follows the standard. It also stops at such a loop.
    pub(super) fn of_standard() -> Cases {
        Cases { follows_standard: true, ..Cases::default() }
    }

    /// Whether the next loop of which the manuals do not say whether it makes one iteration or none makes one. `None`
    /// if both cases of this loop are not tried.
    pub(super) fn makes_one(&mut self) -> Option<bool> {
        if !self.tries_loops || self.met >= MAX_LOOPS {
            return None;
        }
        self.met += 1;
        Some(self.once.get(self.met - 1).copied().unwrap_or(false))
    }

    /// Whether the controller follows another reading than the standard's, asked by the instruction `at`. `None` if
    /// that is not fixed.
    pub(super) fn reading(&mut self, number: u32, at: usize) -> Option<bool> {
        let known = self.readings.get(&number).copied();
        let known = known.or(self.follows_standard.then_some(false));
        if known.is_none() && !self.open.contains(&(at, number)) {
            self.open.push((at, number));
        }
        known
    }

    /// Takes note that the path or a time of the run depends on a value that is unknown because of an instruction.
    pub(super) fn depends_on(&mut self, cause: usize) {
        self.cause.get_or_insert(cause);
    }

    /// A reading on which the run depends, or may depend. `None` if it depends on no reading that is not fixed.
    pub(super) fn undecided(&self) -> Option<u32> {
        let cause = self.cause?;
        let first = self.open.iter().find(|(at, _)| *at == cause).or(self.open.first());
        first.map(|&(_, number)| number)
    }

    /// After a run, the next case with the same readings in depth-first order. `None` after the last one.
    pub(super) fn following(mut self) -> Option<Cases> {
        self.once.resize(self.met, false);
        while self.once.last() == Some(&true) {
            self.once.pop();
        }
        *self.once.last_mut()? = true;
        Some(Cases { once: self.once, ..Cases::of_scan(self.readings) })
    }
}

/// Repeats a run in all readings of a standard on which it depends. `run` makes it with these readings fixed, and
/// returns a further reading on which it depends, if there is one. `see` gets the results of the runs that depend on no
/// further reading, with their readings; if it returns false, no more runs are made.
pub fn in_all_readings<T>(
    mut run: impl FnMut(&Readings) -> (T, Option<u32>),
    mut see: impl FnMut(&Readings, T) -> bool,
) {
    let mut left = vec![Readings::new()];
    let mut runs = 0;
    while let Some(mut readings) = left.pop() {
        let (result, undecided) = run(&readings);
        runs += 1;
        match undecided.filter(|_| runs < MAX_RUNS) {
            Some(number) => {
                readings.insert(number, true);
                left.push(readings.clone());
                readings.insert(number, false);
                left.push(readings);
            }
            None if see(&readings, result) => {}
            None => return,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_of_unknown_count_are_tried_in_both_cases() {
        let mut seen = Vec::new();
        let mut next = Some(Cases::of_scan(Readings::new()));
        while let Some(mut one) = next {
            // The second loop is met only if the first makes no iteration.
            let first = one.makes_one().expect("tried");
            seen.push((first, (!first).then(|| one.makes_one().expect("tried"))));
            next = one.following();
        }
        assert_eq!(seen, [(false, Some(false)), (false, Some(true)), (true, None)]);
        let mut many = Cases::of_scan(Readings::new());
        assert!((0..MAX_LOOPS).all(|_| many.makes_one() == Some(false)));
        assert_eq!(many.makes_one(), None);
        assert_eq!(Cases::of_run(Readings::new()).makes_one(), None);
    }

    #[test]
    fn a_reading_is_undecided_if_the_run_depends_on_it() {
        let mut one = Cases::of_scan([(3, true)].into());
        assert_eq!(
            (one.reading(3, 10), one.reading(4, 11), one.reading(5, 12)),
            (Some(true), None, None)
        );
        assert_eq!(one.undecided(), None, "nothing depends on it");
        one.depends_on(12);
        one.depends_on(11);
        assert_eq!(one.undecided(), Some(5));
        let mut other = Cases::of_scan(Readings::new());
        other.reading(4, 11);
        other.depends_on(99);
        assert_eq!(other.undecided(), Some(4), "it may lie behind the cause");
        assert_eq!(Cases::of_run(Readings::new()).reading(4, 11), None);
        assert_eq!(Cases::of_standard().reading(4, 11), Some(false));
    }

    #[test]
    fn a_run_is_repeated_in_all_readings_on_which_it_depends() {
        // Reading 5 matters only if 3 is another one.
        let run = |readings: &Readings| match (readings.get(&3), readings.get(&5)) {
            (None, _) => ((), Some(3)),
            (Some(true), None) => ((), Some(5)),
            _ => ((), None),
        };
        let mut seen = Vec::new();
        in_all_readings(run, |readings, ()| {
            seen.push(readings.clone());
            true
        });
        let both = |five| Readings::from([(3, true), (5, five)]);
        assert_eq!(seen, [Readings::from([(3, false)]), both(false), both(true)]);
        let mut first = 0;
        in_all_readings(run, |_, ()| {
            first += 1;
            false
        });
        assert_eq!(first, 1);
        // Each run meets a new reading.
        let (mut runs, mut left) = (0, 0);
        let endless = |readings: &Readings| {
            runs += 1;
            ((), u32::try_from(readings.len()).ok())
        };
        in_all_readings(endless, |_, ()| {
            left += 1;
            true
        });
        assert!(runs < 2 * MAX_RUNS && left > 1, "{runs} {left}");
    }
}

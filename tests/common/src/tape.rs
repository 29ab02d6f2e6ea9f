//! Random numbers that can be shrunk: a generator reads its decisions from a tape. After its end the tape gives 0.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestError, TestRng, TestRunner};
use std::ops::Mul;

/// The decisions of one generated program. 0 is the simplest decision.
pub struct Tape<'a> {
    cells: &'a [u16],
    at: usize,
}

impl<'a> Tape<'a> {
    pub fn new(cells: &'a [u16]) -> Self {
        Tape { cells, at: 0 }
    }

    /// A number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        let cell = self.cells.get(self.at).copied().unwrap_or(0);
        self.at += 1;
        usize::from(cell) % n
    }

    /// True in this many of 100 cases; false after the end of the tape.
    pub fn percent(&mut self, n: usize) -> bool {
        self.below(100) >= 100 - n
    }

    pub fn pick<T: Clone>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())].clone()
    }

    pub fn done(&self) -> bool {
        self.at >= self.cells.len()
    }
}

/// The number of cases: `standard`, times the factor in the environment variable SCANBOUND_CASES if it is set
/// (50 for a thorough run of some minutes).
pub fn cases<N: From<u32> + Mul<Output = N>>(standard: N) -> N {
    let factor = std::env::var("SCANBOUND_CASES").ok().and_then(|text| text.parse::<u32>().ok());
    standard * N::from(factor.unwrap_or(1))
}

/// The seeds of this many cases, from the one that SCANBOUND_FIRST names (1 without it). With SCANBOUND_SHOW=seeds each
/// is shown before its case is run.
#[allow(clippy::print_stdout, reason = "the seed of a case that takes long or aborts is seen")]
pub fn seeds(standard: u64) -> impl Iterator<Item = u64> {
    let first = std::env::var("SCANBOUND_FIRST").ok().and_then(|text| text.parse::<u64>().ok());
    let first = first.unwrap_or(1);
    let are_shown = std::env::var("SCANBOUND_SHOW").is_ok_and(|what| what == "seeds");
    (first..first + cases(standard)).inspect(move |seed| {
        if are_shown {
            println!("seed {seed}");
        }
    })
}

/// How often a failing tape is shortened: SCANBOUND_SHRINK, if it is set.
fn most_shrinks() -> u32 {
    let most = std::env::var("SCANBOUND_SHRINK").ok().and_then(|text| text.parse().ok());
    most.unwrap_or(4_000)
}

/// Runs the check on this many tapes of at most `length` cells and shrinks the first that fails. The tapes are
/// the same in every run unless SCANBOUND_SEED is set to a number other than 0.
pub fn on_tapes(cases: u32, length: usize, check: impl Fn(&[u16]) -> Result<(), String>) {
    let seed = std::env::var("SCANBOUND_SEED").ok().and_then(|text| text.parse::<u64>().ok());
    let mut bytes = [7; 32];
    bytes[..8].copy_from_slice(&seed.unwrap_or(0).to_le_bytes());
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &bytes);
    let config = Config {
        cases,
        failure_persistence: None,
        max_shrink_iters: most_shrinks(),
        ..Config::default()
    };
    let mut runner = TestRunner::new_with_rng(config, rng);
    let tapes = prop::collection::vec(any::<u16>(), 0..=length);
    let outcome = runner.run(&tapes, |tape| check(&tape).map_err(TestCaseError::fail));
    match outcome {
        Ok(()) => {}
        Err(TestError::Fail(why, tape)) => panic!("{why}\non the tape {tape:?}"),
        Err(abort) => panic!("{abort}"),
    }
}

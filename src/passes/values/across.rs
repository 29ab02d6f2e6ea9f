//! What scans from power-up on keep to, where some words are trusted: a least fixpoint over scans.

use super::run::{Found, Run};
use super::state::Followed;
use crate::base::ring::Ring;
use crate::program::Program;

/// So many scans follow each other until nothing new comes; what grows beyond some of them grows to an end.
const MOST_SCANS: usize = 12;
const EXACT_SCANS: usize = 4;
/// So many instructions are carried out in all of them.
const MOST_ACROSS: u64 = 3_000_000;
/// So many instructions are carried out to find out which trusted words matter.
const MOST_REDUCING: u64 = 300_000;

/// What scans keep to.
#[derive(Default)]
pub struct Kept {
    /// Those of the trusted words of which then more is known than that they hold anything, by slot.
    pub trusted: Vec<usize>,
    /// What was found in any of the scans.
    pub found: Found,
    /// What the words hold when one starts.
    pub start: Vec<Ring>,
    /// What it took, in instructions.
    work: u64,
}

/// What it is worked out from.
pub struct Across<'a> {
    pub program: &'a Program,
    pub followed: &'a Followed,
    /// What words hold when a scan starts, whoever wrote them.
    pub free: &'a [Ring],
    /// The words that are written in every scan, by slot.
    pub always: Vec<usize>,
    /// Whether to give up.
    pub is_over: &'a dyn Fn() -> bool,
}

impl Across<'_> {
    /// What scans keep to where these words are trusted. `None` if it takes too much, or a scan has no end.
    ///
    /// What is not written in every scan and never leaves its value at power-up somebody else must write: it is free, and
    /// then others may be, too.
    pub fn of(&self, trusted: &[usize]) -> Option<Kept> {
        let mut trusted = trusted.to_vec();
        let mut work = 0;
        loop {
            let mut kept = self.fixpoint(&trusted)?;
            work += kept.work;
            let before = trusted.len();
            trusted.retain(|&slot| {
                kept.start[slot] != Ring::constant(0) || self.always.contains(&slot)
            });
            if trusted.len() == before {
                kept.work = work;
                return Some(kept);
            }
            if work > MOST_ACROSS {
                return None;
            }
        }
    }

    fn fixpoint(&self, trusted: &[usize]) -> Option<Kept> {
        let Across { program, followed, free, is_over, .. } = *self;
        let mut start = free.to_vec();
        for &slot in trusted {
            // Stated ranges hold for every start.
            start[slot] = Ring::constant(0);
        }
        let mut work = 0;
        for scan in 0..MOST_SCANS {
            let mut run = Run::new(program, followed, is_over);
            run.scan(followed.holding(start.clone())).ok()??;
            work += run.work;
            let mut next = start.clone();
            for &slot in trusted {
                // A latched word may hold what stood there in the midst of a scan, when the power failed.
                let Some(value) = run.written[slot] else { continue };
                next[slot] = match scan {
                    0..EXACT_SCANS => next[slot].join(value),
                    _ => next[slot].widen(value),
                };
            }
            if next == start {
                let mut trusted = trusted.to_vec();
                trusted.retain(|&slot| start[slot] != Ring::TOP);
                return Some(Kept { trusted, found: run.found, start, work });
            }
            // Without a fixpoint nothing is trusted.
            if work > MOST_ACROSS {
                return None;
            }
            start = next;
        }
        None
    }

    /// The same with as few trusted words as it takes, as far as there is time to find out: many at once are left out,
    /// then fewer. What stays in any case comes first among them.
    pub fn needed(&self, all: Kept, stay: &[usize]) -> Kept {
        let mut kept = all;
        let mut work = 0;
        let mut many = kept.trusted.len().div_ceil(2);
        while many > 0 {
            let mut from = kept.trusted.iter().take_while(|slot| stay.contains(slot)).count();
            while from < kept.trusted.len() {
                work += kept.work;
                if work > MOST_REDUCING {
                    return kept;
                }
                let to = (from + many).min(kept.trusted.len());
                let fewer = [&kept.trusted[..from], &kept.trusted[to..]].concat();
                match self.of(&fewer) {
                    Some(less) if less.found == kept.found => {
                        // What is left before `from` stays needed.
                        from = from.min(less.trusted.len());
                        kept = less;
                    }
                    _ => from = to,
                }
            }
            many /= 2;
        }
        kept
    }
}

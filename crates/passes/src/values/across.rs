//! What scans from power-up on keep to, where some words are trusted: a least fixpoint over scans.

use super::run::{Found, Run};
use super::state::Followed;
use super::value::Value;
use scanbound_ir::Program;

/// So many scans follow each other until nothing new comes; what grows beyond some of them grows to the next limit, and
/// beyond more of them to an end.
const MOST_SCANS: usize = 20;
const EXACT_SCANS: usize = 4;
const LIMITED_SCANS: usize = 12;
/// So often what was found is taken closer.
const NARROWED_SCANS: usize = 2;
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
    pub start: Vec<Value>,
    /// What it took, in instructions.
    work: u64,
}

/// One scan.
struct Scanned {
    found: Found,
    /// What it may leave in each of the trusted words for the next one.
    left: Vec<Value>,
}

/// What it is worked out from.
pub struct Across<'a> {
    pub program: &'a Program,
    pub followed: &'a Followed,
    /// What words hold when a scan starts, whoever wrote them.
    pub free: &'a [Value],
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
                kept.start[slot] != self.at_power_up(slot) || self.always.contains(&slot)
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

    /// What a trusted word holds at power-up.
    fn at_power_up(&self, slot: usize) -> Value {
        Value::constant(self.program.power_up.word(self.followed.words.cells()[slot]))
    }

    fn fixpoint(&self, trusted: &[usize]) -> Option<Kept> {
        let Across { followed, free, .. } = *self;
        let mut start = free.to_vec();
        for &slot in trusted {
            // Stated ranges hold for every start.
            start[slot] = self.at_power_up(slot);
        }
        let mut work = 0;
        for scan in 0..MOST_SCANS {
            let mut scanned = self.scan(&start, trusted, &mut work)?;
            let grow = |slot: usize, (here, there): (Value, Value)| match scan {
                0..EXACT_SCANS => here.join(there),
                _ => {
                    let is_last = scan >= LIMITED_SCANS || work > MOST_ACROSS / 4;
                    followed.limits.widen(slot, here, there, is_last)
                }
            };
            let mut next = start.clone();
            for (&slot, &left) in trusted.iter().zip(&scanned.left) {
                next[slot] = grow(slot, (start[slot], left)).as_start();
            }
            if next == start {
                if scan > EXACT_SCANS {
                    (start, scanned) = self.narrower(start, scanned, trusted, &mut work);
                }
                let mut trusted = trusted.to_vec();
                trusted.retain(|&slot| start[slot] != Value::TOP);
                return Some(Kept { trusted, found: scanned.found, start, work });
            }
            // Without a fixpoint nothing is trusted.
            if work > MOST_ACROSS {
                return None;
            }
            start = next;
        }
        None
    }

    /// A scan that starts so: what is found in it, and what it may leave in each of the trusted words for the next one: what
    /// stands there at its end, or what it wrote at any moment before, should the power fail and the word be latched.
    fn scan(&self, start: &[Value], trusted: &[usize], work: &mut u64) -> Option<Scanned> {
        let Across { program, followed, is_over, .. } = *self;
        let mut run = Run::new(program, followed, is_over);
        let end = run.scan(followed.holding(start.to_vec())).ok()??;
        *work += run.work;
        let forgets = |slot: usize| program.power_up.forgets(followed.words.cells()[slot]);
        let left = |&slot: &usize| match run.written[slot] {
            Some(written) if !forgets(slot) => end.value(slot).join(written),
            _ => end.value(slot),
        };
        Some(Scanned { left: trusted.iter().map(left).collect(), found: run.found })
    }

    /// What scans keep to is taken closer where it was widened: memory is as at power-up or as a scan left it that started
    /// as was found. Each of these is closer than the one before or it is not taken, so a scan keeps to it, too.
    fn narrower(
        &self,
        mut start: Vec<Value>,
        mut scanned: Scanned,
        trusted: &[usize],
        work: &mut u64,
    ) -> (Vec<Value>, Scanned) {
        for _ in 0..NARROWED_SCANS {
            let mut closer = start.clone();
            for (&slot, &left) in trusted.iter().zip(&scanned.left) {
                let value = left.join(self.at_power_up(slot)).as_start();
                if start[slot].holds(&value) {
                    closer[slot] = value;
                }
            }
            if closer == start || *work > MOST_ACROSS / 4 {
                break;
            }
            let Some(next) = self.scan(&closer, trusted, work) else { break };
            start = closer;
            scanned = next;
        }
        (start, scanned)
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

//! Invariants over scans: the values that trusted words have at the start of every scan from power-up on, as a least
//! fixpoint.

use super::Trust;
use super::run::{CountLimits, Run};
use super::state::Tracked;
use super::value::Value;
use super::write::Given;
use scanbound_ir::{Cell, Program};
use std::collections::BTreeSet;

/// A fixpoint must be reached within this many scans, otherwise there is none.
const MAX_SCANS: usize = 20;
/// After this many scans, values are widened to the next limit.
const EXACT_SCANS: usize = 4;
/// After this many scans, values are widened to the smallest or largest number.
const LIMITED_SCANS: usize = 12;
/// The largest number of narrowing steps after the fixpoint.
const NARROWED_SCANS: usize = 2;
/// The largest number of instructions executed in all scans of a fixpoint.
const MAX_FIXPOINT_WORK: u64 = 3_000_000;
/// The largest number of words of a number.
const WORDS: u32 = 4;
/// The largest number of instructions executed to find out which trusted words are needed.
const MAX_REDUCING: u64 = 300_000;

/// A fixpoint over scans: values of the trusted words that hold whenever a scan starts, and the limits that follow.
#[derive(Default)]
pub struct Fixpoint {
    /// The trusted words about which something is known, by slot (index among the tracked words).
    pub trusted: Vec<usize>,
    /// The limits of iterations, units and indexed writes that hold in all scans.
    pub found: CountLimits,
    /// For each tracked word, by slot: its values at the start of every scan.
    pub start: Vec<Value>,
    given: Given,
    /// For each tracked word, by slot: its values at the end of every scan.
    end: Vec<Value>,
    /// The number of instructions that were executed to compute the fixpoint.
    work: u64,
}

struct ScanResult {
    found: CountLimits,
    given: Given,
    end: Vec<Value>,
    /// For each trusted word, the values that the scan may leave in it for the next scan.
    left: Vec<Value>,
}

/// The input of the analysis over scans: the program, what is tracked, and the values at the start of a scan.
pub struct ScanFixpoint<'a> {
    pub program: &'a Program,
    pub followed: &'a Tracked,
    /// For each slot, the values that its word may have at the start of a scan, whoever wrote it.
    pub free: &'a [Value],
    /// What a scan writes that starts with any of these values.
    pub given: &'a Given,
    /// The words, by slot, that no other writer is assumed to write and that hold one value after every scan, whatever
    /// they held before.
    pub steady: Vec<usize>,
    /// Returns true if the analysis must stop, because the time is over.
    pub is_over: &'a dyn Fn() -> bool,
}

impl ScanFixpoint<'_> {
    /// The fixpoint if the words in these slots are trusted. `None` if no fixpoint is found within the limits, or if a
    /// scan has no end or cannot be analysed.
    ///
    /// A word that never changes its value from power-up must have another writer, unless every scan leaves that value
    /// in it whatever it held before. So must a word that the program only ever clears, or to which it writes only
    /// bits, or what the word held. These are removed from the trusted words, which may affect others. That nobody else
    /// writes internal cells is certain.
    pub fn of(&self, trusted: &[usize]) -> Option<Fixpoint> {
        let mut trusted = trusted.to_vec();
        let mut work = 0;
        loop {
            let mut best = self.fixpoint(&trusted)?;
            work += best.work;
            let before = trusted.len();
            let own: BTreeSet<usize> =
                trusted.iter().copied().filter(|&slot| self.is_own(slot, &best)).collect();
            trusted.retain(|slot| {
                let is_part = || best.given.beside.contains(slot) && self.is_next_to(*slot, &own);
                own.contains(slot) || is_part()
            });
            if trusted.len() == before {
                best.work = work;
                return Some(best);
            }
            if work > MAX_FIXPOINT_WORK {
                return None;
            }
        }
    }

    /// Whether nothing shows that a trusted word has another writer.
    fn is_own(&self, slot: usize, best: &Fixpoint) -> bool {
        let cell = self.followed.words.cells()[slot];
        let is_exclusive = Trust::Counts.trusts_exclusive_cell(self.program, cell);
        let is_given =
            best.given.words.contains(&slot) && self.given.words.contains(&slot) || is_exclusive;
        let first = self.at_power_up(slot);
        // If a word counts from what it held, but no scan leaves what it counted, others give it the values.
        let counts = [self.given, &best.given].iter().any(|one| one.computed.contains(&slot));
        let changes = match counts && !is_exclusive {
            true => {
                let given = best.given.independent.get(&slot).map_or(first, |all| all.join(first));
                let end = best.end[slot];
                end.as_constant().is_none() && !given.contains(&end)
            }
            false => best.start[slot] != first,
        };
        is_given && (changes || self.steady.contains(&slot))
    }

    /// Whether one of these words may belong to the same number as the word in this slot.
    fn is_next_to(&self, slot: usize, others: &BTreeSet<usize>) -> bool {
        let Cell { area, index } = self.followed.words.cells()[slot];
        let near = index.saturating_sub(WORDS - 1)..index.saturating_add(WORDS);
        let mut near = near.filter_map(|index| self.followed.words.slot(Cell { area, index }));
        near.any(|other| others.contains(&other))
    }

    /// The value of a trusted word at power-up.
    fn at_power_up(&self, slot: usize) -> Value {
        Value::constant(self.program.power_up.initial_value(self.followed.words.cells()[slot]))
    }

    fn fixpoint(&self, trusted: &[usize]) -> Option<Fixpoint> {
        let ScanFixpoint { followed, free, .. } = *self;
        let mut start = free.to_vec();
        for &slot in trusted {
            // Stated ranges hold for every start value.
            start[slot] = self.at_power_up(slot);
        }
        let mut work = 0;
        for scan in 0..MAX_SCANS {
            let mut scanned = self.scan(&start, trusted, &mut work)?;
            let grow = |slot: usize, (here, there): (Value, Value)| match scan {
                0..EXACT_SCANS => here.join(there),
                _ => {
                    let is_last = scan >= LIMITED_SCANS || work > MAX_FIXPOINT_WORK / 4;
                    followed.limits.widen(slot, here, there, is_last)
                }
            };
            let mut next = start.clone();
            for (&slot, &left) in trusted.iter().zip(&scanned.left) {
                next[slot] = grow(slot, (start[slot], left)).as_start();
            }
            if next == start {
                if scan > EXACT_SCANS {
                    (start, scanned) = self.narrow(start, scanned, trusted, &mut work);
                }
                let mut trusted = trusted.to_vec();
                trusted.retain(|&slot| start[slot] != Value::TOP);
                let ScanResult { found, given, end, .. } = scanned;
                return Some(Fixpoint { trusted, found, start, given, end, work });
            }
            // Without a fixpoint nothing can be trusted.
            if work > MAX_FIXPOINT_WORK {
                return None;
            }
            start = next;
        }
        None
    }

    /// Analyses a scan with these start values: its limits, and for each trusted word the values that it may leave for
    /// the next scan. These are the values at the end of the scan and, for latched words, all values written during it,
    /// because the power may fail at any moment. `None` if the scan cannot be analysed or has no end.
    fn scan(&self, start: &[Value], trusted: &[usize], work: &mut u64) -> Option<ScanResult> {
        let ScanFixpoint { program, followed, is_over, .. } = *self;
        let mut run = Run::new(program, followed, is_over);
        let end = run.scan(followed.holding(start.to_vec())).ok()??;
        *work += run.work;
        let forgets =
            |slot: usize| program.power_up.is_lost_at_power_failure(followed.words.cells()[slot]);
        // What is written to a copy of a latched word counts as written to the word.
        let written = |slot: usize| {
            let copies = program.power_up.lent.get(&followed.words.cells()[slot]);
            let copies =
                copies.into_iter().flatten().map(|&copy| match followed.words.slot(copy) {
                    Some(copy) => run.written[copy],
                    None => Some(Value::TOP),
                });
            [run.written[slot]].into_iter().chain(copies).flatten().reduce(Value::join)
        };
        let left = |&slot: &usize| match written(slot) {
            Some(written) if !forgets(slot) => end.value(slot).join(written),
            _ => end.value(slot),
        };
        let left = trusted.iter().map(left).collect();
        let end = (0..start.len()).map(|slot| end.value(slot)).collect();
        Some(ScanResult { left, found: run.found, given: run.given, end })
    }

    /// Narrowing after widening: at the start of a scan, memory has its power-up values or those that a scan left which
    /// started within the invariant. Each result is contained in the previous one, so it is an invariant too.
    fn narrow(
        &self,
        mut start: Vec<Value>,
        mut scanned: ScanResult,
        trusted: &[usize],
        work: &mut u64,
    ) -> (Vec<Value>, ScanResult) {
        for _ in 0..NARROWED_SCANS {
            let mut closer = start.clone();
            for (&slot, &left) in trusted.iter().zip(&scanned.left) {
                let value = left.join(self.at_power_up(slot)).as_start();
                if start[slot].contains(&value) {
                    closer[slot] = value;
                }
            }
            if closer == start || *work > MAX_FIXPOINT_WORK / 4 {
                break;
            }
            let Some(next) = self.scan(&closer, trusted, work) else { break };
            start = closer;
            scanned = next;
        }
        (start, scanned)
    }

    /// Reduces the trusted words to those that are needed for the same limits, within [`MAX_REDUCING`] instructions:
    /// tries to remove many at once, then fewer. Words in `stay` are kept; they come first.
    pub fn needed(&self, all: Fixpoint, stay: &[usize]) -> Fixpoint {
        let mut best = all;
        let mut work = 0;
        let mut many = best.trusted.len().div_ceil(2);
        while many > 0 {
            let mut from = best.trusted.iter().take_while(|slot| stay.contains(slot)).count();
            while from < best.trusted.len() {
                work += best.work;
                if work > MAX_REDUCING {
                    return best;
                }
                let to = (from + many).min(best.trusted.len());
                let fewer = [&best.trusted[..from], &best.trusted[to..]].concat();
                match self.of(&fewer) {
                    Some(less) if less.found == best.found => {
                        // The words before `from` remain needed.
                        from = from.min(less.trusted.len());
                        best = less;
                    }
                    _ => from = to,
                }
            }
            many /= 2;
        }
        best
    }
}

//! Finds how many units of a timer one scan can take. A timer with a larger set value cannot time out in the scan that
//! starts it.

use super::doubt::{self, Doubt};
use scanbound_base::time::Picos;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{
    Cell, ChoiceId, Number, Program, Region, RegionSet, Source, Step, SummaryReason, WordSource,
    WordTarget, Write, flow,
};
use scanbound_model::{Charge, Lit, ScanModel};
use scanbound_passes::loops;
use scanbound_scan::scan_model;
use scanbound_timing::price::Prices;
use std::collections::BTreeMap;

/// The largest set value of a timer, in binary and in decimal.
const MAX_SET_VALUE: [u64; 2] = [32_767, 9_999];

/// Records in the program how many units of time a scan can take at most, for each timer, if that is known before the
/// scan is followed: from the sum of all instructions that can run.
pub fn resolve_by_sum(program: &mut Program, prices: &Prices) {
    if unresolved_timers(program).is_empty() {
        return;
    }
    let mut sum = program.clone();
    if loops::summarise_all(&mut sum, SummaryReason::TooManyInstructions).is_err() {
        return;
    }
    let mut priced = prices.clone();
    priced.instructions.resize(sum.instructions.len(), None);
    if let Ok(model) = scan_model(&sum, &priced.times()) {
        resolve(program, prices, &model);
    }
}

/// As [`resolve_by_sum`], but from the sum of the larger times of this model's charges. Returns whether something was
/// recorded.
pub fn resolve(program: &mut Program, prices: &Prices, model: &ScanModel) -> bool {
    let open = unresolved_timers(program);
    if open.is_empty() {
        return false;
    }
    let Some(longest) = longest(program, prices, model) else { return false };
    let mut resolved: BTreeMap<ChoiceId, u16> = BTreeMap::new();
    for (choice, unit, is_decimal) in open {
        let ticks = longest.0 / unit.0.max(1) + 1;
        if ticks <= MAX_SET_VALUE[usize::from(is_decimal)] {
            let ticks = u16::try_from(ticks).unwrap_or(u16::MAX);
            resolved.insert(choice, if is_decimal { digits(ticks) } else { ticks });
        }
    }
    let changed = !resolved.is_empty();
    program.timekeeping.most_ticks.extend(resolved);
    changed
}

/// Records in the program how much time passes at least between the executions of a running timer in two scans.
pub fn note_gaps(program: &mut Program, prices: &Prices, model: &ScanModel) {
    let times = prices.least_times();
    let overhead = Picos(prices.overhead_sum().0.saturating_sub(prices.uncertain_refresh().0));
    let mut memories: BTreeMap<Cell, usize> = BTreeMap::new();
    for expiry in program.timekeeping.expiries.values() {
        *memories.entry(expiry.memory).or_default() += 1;
    }
    memories.retain(|_, count| *count == 1);
    if memories.is_empty() || !program.mains.is_sorted_by_key(|main| main.start) {
        return;
    }
    // The last instruction that writes each memory.
    let mut last: BTreeMap<Cell, usize> = BTreeMap::new();
    for (at, instruction) in program.instructions.iter().enumerate() {
        for effect in &instruction.effects {
            let written: Vec<Cell> = match &effect.write {
                Write::Bit(bit, _) => vec![bit.cell()],
                Write::Words(targets, _) => targets.iter().filter_map(word_of).collect(),
                Write::Havoc(..) => Vec::new(),
            };
            for cell in written.into_iter().filter(|cell| memories.contains_key(cell)) {
                last.insert(cell, at);
            }
        }
    }
    let certain = |charge: &&Charge| charge.frames.is_empty() && charge.reached == Lit::TRUE;
    let mut charges: Vec<(usize, Picos)> = Vec::new();
    for charge in model.charges.iter().filter(certain) {
        let times = times[charge.instruction];
        charges.push((charge.instruction, times.on.min(times.off)));
    }
    let gap = |at: usize| {
        let after = charges.iter().filter(|&&(other, _)| other > at);
        after.fold(overhead, |sum, &(_, least)| Picos(sum.0.saturating_add(least.0)))
    };
    let gaps = last.into_iter().map(|(cell, at)| (cell, gap(at))).collect();
    program.timekeeping.least_gaps = gaps;
}

fn word_of(target: &WordTarget) -> Option<Cell> {
    match *target {
        WordTarget::Cell(cell) => Some(cell),
        WordTarget::Bits { .. } | WordTarget::Discard => None,
    }
}

/// The timers for which the largest number of time units in a scan is unknown, and whose present value only they
/// write: the choice of that number, its unit, and whether it is in BCD.
fn unresolved_timers(program: &Program) -> Vec<(ChoiceId, Picos, bool)> {
    let keeping = &program.timekeeping;
    let others = Others::of(program);
    let mut found = Vec::new();
    for (&at, timed) in &keeping.instructions {
        if others.write(timed.present) {
            continue;
        }
        // The other parts of the instruction may read it.
        for part in std::iter::once(at).chain(timed.parts.clone()) {
            program.instructions[part].each_read(&mut |source| {
                if let Source::Word(WordSource::Free(choice)) = source
                    && let Some(&ChoiceKind::ScanTicks { unit, is_decimal, .. }) =
                        program.kinds.get(&choice)
                    && !keeping.most_ticks.contains_key(&choice)
                {
                    found.push((choice, unit, is_decimal));
                }
            });
        }
    }
    found
}

/// An upper bound on the scan: every instruction at its larger time, with the overhead and all points that the CPU can
/// have. `None` if the scan may take longer than that, because a fact is not stated or a loop has no bound, or if the
/// time is too large to represent.
fn longest(program: &Program, prices: &Prices, model: &ScanModel) -> Option<Picos> {
    let is_open = |doubt: &Doubt| !matches!(doubt, Doubt::Points(_));
    let is_endless = |step: &Step| matches!(step, Step::Unbounded { .. });
    if doubt::doubts_before_scan(program, prices).iter().any(is_open)
        || program.missing_routines.iter().any(|one| !one.stated)
        || program.instructions.iter().any(|one| is_endless(&one.step))
    {
        return None;
    }
    let largest = u64::try_from(model.sum_of_largest()).ok()?;
    let others = [prices.overhead_sum(), prices.more_points()];
    others.iter().try_fold(largest, |sum, time| sum.checked_add(time.0)).map(Picos)
}

/// The regions that others than the timer itself may write, in the areas of timers' present values: other instructions,
/// unless they only reset the present value to 0, and external writers.
struct Others(RegionSet);

impl Others {
    fn of(program: &Program) -> Others {
        let presents: Vec<Cell> =
            program.timekeeping.instructions.values().map(|timed| timed.present).collect();
        let mut areas: Vec<_> = presents.iter().map(|cell| cell.area).collect();
        areas.sort_unstable();
        areas.dedup();
        let of_interest = |region: &Region| match *region {
            Region::Range { first, .. } => areas.binary_search(&first.area).is_ok(),
            Region::Area(area) => areas.binary_search(&area).is_ok(),
            Region::Everything => true,
        };
        let mut regions: Vec<Region> = program.external.clone();
        let all = program.timekeeping.instructions.iter();
        let parts = all.flat_map(|(&at, timed)| {
            std::iter::once(at).chain(timed.parts.clone()).map(|part| (part, timed.present))
        });
        let own: BTreeMap<usize, Cell> = parts.collect();
        for (at, instruction) in program.instructions.iter().enumerate() {
            let own = own.get(&at).copied();
            let is_reset = |cell: Cell| {
                instruction.effects.iter().any(|effect| match &effect.write {
                    Write::Words(targets, Number::Words(words)) => {
                        targets[..] == [WordTarget::Cell(cell)]
                            && words[..] == [WordSource::Const(0)]
                    }
                    _ => false,
                })
            };
            let written = flow::written(program, at).into_iter().filter(|region| match *region {
                Region::Range { first, count: 1 } => own != Some(first) && !is_reset(first),
                _ => true,
            });
            regions.extend(written);
        }
        Others(regions.into_iter().filter(of_interest).collect())
    }

    fn write(&self, cell: Cell) -> bool {
        self.0.contains(Region::Range { first: cell, count: 1 })
    }
}

/// The lowest four decimal digits of a number, as BCD.
fn digits(value: u16) -> u16 {
    (0..4).fold(0, |word, place| word | (value / 10u16.pow(place) % 10) << (4 * place))
}

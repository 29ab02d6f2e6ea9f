//! Timers that cannot run out in the scan that starts them, because no scan takes as long as their set value.

use super::doubt::{self, Doubt};
use scanbound_base::time::Picos;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{
    Cell, ChoiceId, Number, Program, Region, SourceMut, Step, SummaryReason, WordSource,
    WordTarget, Write, flow,
};
use scanbound_model::ScanModel;
use scanbound_passes::loops;
use scanbound_scan::scan_model;
use scanbound_timing::price::Prices;
use std::collections::BTreeMap;

/// The largest set value of a timer, in binary and in decimal.
const MAX_SET_VALUE: [u64; 2] = [32_767, 9_999];

/// Records in the program how many units of time a scan can take at most, if that is known before the scan is followed:
/// from the sum of all instructions that can run.
pub fn resolve_by_sum(program: &mut Program, prices: &Prices) {
    if !has_open(program) {
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

/// As [`resolve_by_sum`], but from the longest scan of this model. Returns whether something was recorded.
pub fn resolve(program: &mut Program, prices: &Prices, model: &ScanModel) -> bool {
    if !has_open(program) {
        return false;
    }
    let Some(longest) = longest(program, prices, model) else { return false };
    let others = Others::of(program);
    let mut resolved: BTreeMap<ChoiceId, u16> = BTreeMap::new();
    for (&at, timed) in &program.timekeeping.instructions {
        if others.write(timed.present) {
            continue;
        }
        program.instructions[at].each_read(&mut |source| {
            if let scanbound_ir::Source::Word(WordSource::Free(choice)) = source
                && let Some(&ChoiceKind::ScanTicks { unit, is_decimal }) =
                    program.kinds.get(&choice)
            {
                let ticks = longest.0 / unit.0.max(1) + 1;
                if ticks <= MAX_SET_VALUE[usize::from(is_decimal)] {
                    let ticks = u16::try_from(ticks).unwrap_or(u16::MAX);
                    resolved.insert(choice, if is_decimal { digits(ticks) } else { ticks });
                }
            }
        });
    }
    let mut changed = false;
    let coils: Vec<usize> = program.timekeeping.instructions.keys().copied().collect();
    for at in coils {
        program.instructions[at].each_read_mut(&mut |source| {
            if let SourceMut::Word(word) = source
                && let WordSource::Free(choice) = *word
                && let Some(&ticks) = resolved.get(&choice)
            {
                *word = WordSource::Const(ticks);
                changed = true;
            }
        });
    }
    changed
}

/// Whether there is a timer for which the largest number of time units in a scan is unknown.
fn has_open(program: &Program) -> bool {
    let mut open = false;
    for &at in program.timekeeping.instructions.keys() {
        program.instructions[at].each_read(&mut |source| {
            if let scanbound_ir::Source::Word(WordSource::Free(choice)) = source {
                open |= matches!(program.kinds.get(&choice), Some(ChoiceKind::ScanTicks { .. }));
            }
        });
    }
    open
}

/// An upper bound on a scan in which each unknown value is the worst possible one. `None` if a worst value is unknown.
fn longest(program: &Program, prices: &Prices, model: &ScanModel) -> Option<Picos> {
    let is_open = |doubt: &Doubt| !matches!(doubt, Doubt::Points(_));
    let is_endless = |step: &Step| matches!(step, Step::Unbounded { .. });
    if doubt::before(program, prices).iter().any(is_open)
        || program.missing_routines.iter().any(|one| !one.stated)
        || program.instructions.iter().any(|one| is_endless(&one.step))
    {
        return None;
    }
    let largest = u64::try_from(model.sum_of_largest()).ok()?;
    let others = [prices.overhead_sum(), prices.more_points()];
    others.iter().try_fold(largest, |sum, time| sum.checked_add(time.0)).map(Picos)
}

/// The regions that instructions other than those of a timer write, and that contain present values of timers.
struct Others(Vec<Region>);

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
        for (at, instruction) in program.instructions.iter().enumerate() {
            let own = program.timekeeping.instructions.get(&at).map(|timed| timed.present);
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
        regions.retain(of_interest);
        regions.sort_unstable();
        regions.dedup();
        Others(regions)
    }

    fn write(&self, cell: Cell) -> bool {
        self.0.iter().any(|region| region.contains(cell))
    }
}

/// The lowest four decimal digits of a number, as BCD.
fn digits(value: u16) -> u16 {
    (0..4).fold(0, |word, place| word | (value / 10u16.pow(place) % 10) << (4 * place))
}

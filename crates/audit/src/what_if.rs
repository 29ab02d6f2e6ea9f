//! How much it is worth to state a count, or how much the bound rests on trusting a word: the bound is computed again
//! with that statement, or without that trust. It is not estimated, because the bound is a maximum over several paths
//! and does not change linearly.

use super::Audit;
use super::assumption::Assumption;
use super::failure::Failure;
use super::pipeline::{Concluded, audit};
use super::request::{Progress, Request};
use super::requested::{InternalDevices, LimitedCount, Minor, WhatIf};
use super::solved_bound::SolvedBound;
use super::stated;
use super::unknown::{Unknown, UnknownKind};
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use scanbound_ir::{Program, Role};
use scanbound_passes::values::Trust;
use std::cmp::Reverse;
use std::collections::BTreeSet;

/// The name of this stage in the progress display.
const STAGE: &str = "solving what if";
/// The largest number of unknown values that are limited together.
const MAX_STEPS: usize = 5;
/// The largest number of audits that measure assumptions.
const MAX_PRICING: usize = 64;
/// A change of the bound is listed only if it is at least the lower one of the two bounds divided by this.
const SMALLEST: u64 = 1000;

/// Adds to an audit how much its unknown numbers and its assumptions are worth. `most` are the limits that are tried
/// for the numbers.
///
/// # Errors
/// If the analysis and the interpreter disagree in one of these audits.
pub fn what_if(
    concluded: &mut Concluded,
    request: &Request<'_>,
    most: &[u32],
) -> Result<(), Failure> {
    concluded.audit.what_if = Some(stated_counts(&concluded.audit, request, most)?);
    let program = &concluded.followed.program;
    let own = std::mem::take(&mut concluded.audit.assumptions);
    let bounds = Bounds::of(&concluded.audit);
    let PricedAssumptions { assumptions, minor } = priced(own, program, bounds, request)?;
    concluded.audit.assumptions = assumptions;
    if let Some(what_if) = &mut concluded.audit.what_if {
        what_if.minor = minor;
    }
    Ok(())
}

/// Adds to an audit how much its unknown numbers are worth, and which devices it is worth to state under `[internal]`.
/// `most` are the limits that are tried for the numbers.
///
/// # Errors
/// If the analysis and the interpreter disagree in one of these audits.
pub fn what_if_offered(
    concluded: &mut Concluded,
    request: &Request<'_>,
    most: &[u32],
) -> Result<(), Failure> {
    let counts = stated_counts(&concluded.audit, request, most)?;
    let own = internal_devices(concluded, request)?;
    concluded.audit.what_if = Some(WhatIf { own, ..counts });
    Ok(())
}

/// How much stating the unknown numbers is worth. Each bound comes from a complete audit with the same settings, which
/// may use the whole time limit.
fn stated_counts(audit: &Audit, request: &Request<'_>, most: &[u32]) -> Result<WhatIf, Failure> {
    (request.progress)(Progress::Stage(STAGE));
    let mut most = most.to_vec();
    most.sort_unstable();
    most.dedup();
    let steps = steps(audit, request, &most)?;
    Ok(WhatIf { most, steps, minor: None, own: None })
}

/// The devices for which a statement that only the program writes them lowers the bound: first all are tried together,
/// then those that do not matter are removed. `None` if the statement does not lower the bound by at least a
/// thousandth.
fn internal_devices(
    concluded: &Concluded,
    request: &Request<'_>,
) -> Result<Option<InternalDevices>, Failure> {
    let Some((bounds, mut new)) = trusting_all(&concluded.audit, request)? else {
        return Ok(None);
    };
    // Cells that a front creates have no names for a facts file; others cannot write them anyway.
    let program = &concluded.followed.program;
    let can_be_stated = |device: &String| {
        stated::holder(program, device)
            .is_some_and(|cell| program.area(cell.area).role != Role::Internal)
    };
    new.iter_mut().for_each(|one| one.devices.retain(can_be_stated));
    new.retain(|one| !one.devices.is_empty());
    let all = Request { trust: Trust::All, ..*request };
    let priced = priced(new, program, bounds, &all)?;
    let worth = priced.assumptions.into_iter().filter(|one| one.without.is_some());
    let devices: Vec<String> = worth.flat_map(|one| one.devices).collect();
    let devices = Vec::from_iter(stated::whole(program, devices.iter()));
    let mut facts = request.facts.clone();
    facts.internal.extend(devices.iter().cloned());
    let found = runs(request, &[facts])?.into_iter().flatten().next();
    let lower = found.filter(|found| matters(found.bound.upper, concluded.audit.bound.upper));
    Ok(lower.map(|found| InternalDevices { devices, bound: found.bound }))
}

/// The bound with [`Trust::All`], and the additional assumptions that it rests on. `None` if the difference is too
/// small to report, or if the user chose another trust than [`Trust::Counts`].
pub(super) fn trusting_all(
    audit: &Audit,
    request: &Request<'_>,
) -> Result<Option<(Bounds, Vec<Assumption>)>, Failure> {
    if request.trusted() != Trust::Counts {
        return Ok(None);
    }
    let all = Request { trust: Trust::All, ..*request };
    let found = runs(&all, std::slice::from_ref(request.facts))?.into_iter().flatten().next();
    let Some(found) = found.filter(|found| matters(found.bound.upper, audit.bound.upper)) else {
        return Ok(None);
    };
    let known: BTreeSet<&String> = audit.assumptions.iter().flat_map(|one| &one.devices).collect();
    let is_new = |one: &Assumption| !one.devices.iter().all(|device| known.contains(device));
    let bounds = Bounds { upper: found.bound.upper, watchdog: found.watchdog };
    Ok(Some((bounds, found.assumptions.into_iter().filter(is_new).collect())))
}

/// Whether the bound `lower` is below the bound `upper` by at least a thousandth, so that the difference is worth
/// reporting.
pub(super) fn matters(lower: Picos, upper: Picos) -> bool {
    upper.0 >= lower.0.saturating_add((lower.0 / SMALLEST).max(1))
}

/// What assumptions may lower: the bound of the scan, and that of the longest time between two watchdog restarts.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) upper: Picos,
    watchdog: Option<Picos>,
}

impl Bounds {
    fn of(audit: &Audit) -> Bounds {
        Bounds { upper: audit.bound.upper, watchdog: audit.watchdog.upper }
    }

    /// Whether one of the bounds is so far below that of another audit that the difference is worth reporting.
    fn matter(self, without: &Run) -> bool {
        matters(self.upper, without.bound.upper)
            || self.watchdog.zip(without.watchdog).is_some_and(|(own, one)| matters(own, one))
    }
}

/// The result of an audit with other facts.
pub(super) struct Run {
    pub(super) bound: SolvedBound,
    watchdog: Option<Picos>,
    unknowns: Vec<Unknown>,
    assumptions: Vec<Assumption>,
}

/// Audits with each of these facts, several in parallel. `None` for facts with which the audit has no result: they
/// contradict the program, or the time was over.
pub(super) fn runs(request: &Request<'_>, facts: &[Facts]) -> Result<Vec<Option<Run>>, Failure> {
    let run = |facts: &Facts| {
        let request = Request {
            facts,
            proves_facts: false,
            trace: false,
            confirm: false,
            response: None,
            warnings: &[],
            limit: None,
            progress: &|_| {},
            ..*request
        };
        match audit(&request) {
            Ok(Audit { bound, watchdog, unknowns, assumptions, cuts, elapsed, .. }) => {
                let is_over = request.time_limit.is_some_and(|limit| elapsed >= limit);
                let cut = is_over || !cuts.is_empty();
                let bound = SolvedBound { upper: bound.upper, cut };
                Ok(Some(Run { bound, watchdog: watchdog.upper, unknowns, assumptions }))
            }
            Err(Failure::Input(_)) => Ok(None),
            Err(why) => Err(why),
        }
    };
    // Each audit has its own threads. Otherwise one that waits for another's threads would lose time, and might prove
    // less.
    let threads = rayon::current_num_threads();
    let mut found = Vec::new();
    for few in facts.chunks(threads) {
        let new_pool = || rayon::ThreadPoolBuilder::new().num_threads(threads / few.len()).build();
        let start = |facts| match new_pool() {
            Ok(pool) => pool.install(|| run(facts)),
            Err(_) => run(facts),
        };
        let all: Vec<_> = std::thread::scope(|scope| {
            let all: Vec<_> = few.iter().map(|facts| scope.spawn(move || start(facts))).collect();
            all.into_iter().map(|one| one.join()).collect()
        });
        for one in all {
            found.push(one.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
        }
    }
    Ok(found)
}

/// Limits the first unknown value of the audit, then the first new one of the audit with this limit, and so on, up to
/// [`MAX_STEPS`]: the effect of one is often hidden by the next. Targets of indirect addresses are passed over. If a
/// step changes next to nothing, the count with the longest time is limited next.
fn steps(audit: &Audit, request: &Request<'_>, most: &[u32]) -> Result<Vec<LimitedCount>, Failure> {
    let mut steps: Vec<LimitedCount> = Vec::new();
    let mut facts = vec![request.facts.clone(); most.len()];
    let mut named = audit.unknowns.to_vec();
    let (mut upper, mut counts_first) = (audit.bound.upper, false);
    while steps.len() < MAX_STEPS && !(request.cancelled)() {
        let is_new = |one: &&Unknown| {
            !matches!(one.kind, UnknownKind::Indirect)
                && steps.iter().all(|step| step.unknown.key != one.key)
        };
        let largest =
            named.iter().filter(|_| counts_first).find(|one| is_new(one) && one.counts().is_some());
        let Some(unknown) = largest.or_else(|| named.iter().find(is_new)).cloned() else { break };
        for (facts, &most) in facts.iter_mut().zip(most) {
            unknown.state(facts, most);
        }
        let found = runs(request, &facts)?;
        let bound = |run: &Option<Run>| run.as_ref().map(|run| run.bound);
        let mut solved: Vec<Option<SolvedBound>> = found.iter().map(bound).collect();
        let before = steps.last().map(|step| &step.solved[..]);
        no_higher(&mut solved, before, audit.bound.upper);
        if let Some((run, bound)) = found.into_iter().flatten().zip(solved.iter().flatten()).next()
        {
            counts_first = !matters(bound.upper, upper);
            upper = bound.upper;
            named = run.unknowns;
        }
        steps.push(LimitedCount { unknown, solved });
    }
    Ok(steps)
}

/// Improves bounds of audits that the time limit ended. A bound found with fewer statements, or with larger counts, is
/// valid for them, too: those of the step `before`, those of larger counts, or the bound without any of these
/// statements.
fn no_higher(
    solved: &mut [Option<SolvedBound>],
    before: Option<&[Option<SolvedBound>]>,
    upper: Picos,
) {
    let mut larger = upper;
    for (place, one) in solved.iter_mut().enumerate().rev() {
        let Some(one) = one else { continue };
        if one.cut {
            let before = before.and_then(|before| before[place]).map_or(upper, |one| one.upper);
            one.upper = one.upper.min(before).min(larger);
        }
        larger = larger.min(one.upper);
    }
}

/// By how much assumptions lower the bound.
struct PricedAssumptions {
    /// The assumptions that are worth listing, the most valuable first; then those whose effect was not computed.
    assumptions: Vec<Assumption>,
    /// The assumptions that hardly change the bound, together. `None` if there are none.
    minor: Option<Minor>,
}

/// Finds for each assumption the bound without it. `bounds` are those with all of them. Many are removed at once. If
/// that changes the bound, each half of them is tried, and so on. This works because removing assumptions never lowers
/// the bound.
fn priced(
    mut all: Vec<Assumption>,
    program: &Program,
    bounds: Bounds,
    request: &Request<'_>,
) -> Result<PricedAssumptions, Failure> {
    let without = |left_out: &Vec<usize>| {
        let mut facts = request.facts.clone();
        let devices = left_out.iter().flat_map(|&one| &all[one].devices);
        facts.external.extend(stated::whole(program, devices));
        facts
    };
    let can_be_named = |one: &usize| {
        all[*one].devices.iter().all(|device| stated::holder(program, device).is_some())
    };
    let nameable: Vec<usize> = (0..all.len()).filter(can_be_named).collect();
    let mut open = vec![nameable.clone()];
    let mut prices: Vec<Option<SolvedBound>> = vec![None; all.len()];
    let mut is_minor = vec![false; all.len()];
    let (mut asked, mut without_all) = (0, None);
    while !open.is_empty() && asked + open.len() <= MAX_PRICING && !(request.cancelled)() {
        open.retain(|some| !some.is_empty());
        let facts: Vec<Facts> = open.iter().map(without).collect();
        asked += facts.len();
        let found = runs(request, &facts)?;
        if let [Some(run)] = &found[..]
            && asked == 1
        {
            without_all = Some(run.bound);
        }
        let mut next = Vec::new();
        for (some, run) in open.into_iter().zip(found) {
            match (run, &some[..]) {
                (Some(run), &[one]) if matters(bounds.upper, run.bound.upper) => {
                    prices[one] = Some(run.bound);
                }
                (Some(run), some) if !bounds.matter(&run) => {
                    some.iter().for_each(|&one| is_minor[one] = true);
                }
                (_, [_]) => {}
                (_, some) => {
                    let (some, others) = some.split_at(some.len() / 2);
                    next.extend([some.to_vec(), others.to_vec()]);
                }
            }
        }
        open = next;
    }
    let few: Vec<usize> = nameable.iter().copied().filter(|&one| is_minor[one]).collect();
    // If two assumptions exclude the same scans, each alone is worth nothing.
    let together = match few.len() {
        0 => None,
        count if count == nameable.len() => without_all,
        _ => runs(request, &[without(&few)])?.into_iter().flatten().next().map(|run| run.bound),
    };
    let minor = together.map(|without| Minor { count: few.len(), without });
    for (one, price) in all.iter_mut().zip(&prices) {
        one.without = *price;
    }
    let mut is_minor = is_minor.into_iter();
    all.retain(|_| !is_minor.next().unwrap_or(false));
    all.sort_by_key(|one| Reverse(one.without.map(|bound| bound.upper)));
    Ok(PricedAssumptions { assumptions: all, minor })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_cut_is_no_higher_than_what_is_known_besides() {
        let bound = |upper, cut| Some(SolvedBound { upper: Picos(upper), cut });
        let upper = Picos(100);
        let mut solved = [bound(90, true), None, bound(120, true), bound(70, false)];
        let before = [bound(60, false), None, bound(65, true), bound(80, false)];
        no_higher(&mut solved, Some(&before), upper);
        assert_eq!(solved, [bound(60, true), None, bound(65, true), bound(70, false)]);
        let mut first = [bound(90, true), bound(85, true), bound(120, true)];
        no_higher(&mut first, None, upper);
        assert_eq!(first, [bound(85, true), bound(85, true), bound(100, true)]);
        // A bound that was not cut short is kept as it is.
        let mut whole = [bound(130, false), bound(120, false)];
        no_higher(&mut whole, None, upper);
        assert_eq!(whole, [bound(130, false), bound(120, false)]);
    }
}

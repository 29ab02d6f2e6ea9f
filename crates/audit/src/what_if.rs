//! What stating a count is worth, and what the trust in a word: the bound is solved again with that stated or without that
//! trust. Nothing is estimated: a maximum of several ways is no straight line.

use super::Audit;
use super::assumption::Assumption;
use super::failure::Failure;
use super::pipeline::{Concluded, audit};
use super::request::{Progress, Request};
use super::solved_bound::SolvedBound;
use super::stated;
use super::unknown::{Unknown, UnknownKind};
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use scanbound_ir::{Program, Role};
use scanbound_passes::values::Trust;
use std::cmp::Reverse;
use std::collections::BTreeSet;

/// What it is called while it runs.
const STAGE: &str = "solving what if";
/// So many counts are stated together.
const MOST_STEPS: usize = 5;
/// So many audits may find out what is trusted for how much.
const MOST_PRICING: usize = 64;
/// What lowers the bound by less than the bound divided by this is not listed.
const SMALLEST: u64 = 1000;

/// Bounds that were solved for more than what is stated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WhatIf {
    /// What counts are taken to be at most, ascending.
    pub most: Vec<u32>,
    /// One count after the other, in each step together with those of all steps before.
    pub steps: Vec<Step>,
    /// How much the assumptions are worth of which none is worth listing.
    pub minor: Option<Minor>,
    /// What else would lower the bound if it were trusted.
    pub own: Option<Own>,
}

/// A count that is stated besides those before it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// The count.
    pub unknown: Unknown,
    /// The bound for each of [`WhatIf::most`]; none where it cannot be that at most.
    pub solved: Vec<Option<SolvedBound>>,
}

/// Assumptions that lower the bound by next to nothing each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Minor {
    /// How many.
    pub count: usize,
    /// The bound without all of them.
    pub without: SolvedBound,
}

/// What lowers the bound where nobody but the program writes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Own {
    /// Words and relays by their names.
    pub devices: Vec<String>,
    /// The bound where that is stated of all of them.
    pub bound: SolvedBound,
}

/// Adds to an audit what its unknown counts and its assumptions are worth.
///
/// # Errors
/// That in one of these audits the analysis and the interpreter disagree.
pub fn what_if(
    concluded: &mut Concluded,
    request: &Request<'_>,
    most: &[u32],
) -> Result<(), Failure> {
    concluded.audit.what_if = Some(stated_counts(&concluded.audit, request, most)?);
    let program = &concluded.followed.program;
    let own = std::mem::take(&mut concluded.audit.assumptions);
    let Priced { assumptions, minor } = priced(own, program, concluded.audit.bound.upper, request)?;
    concluded.audit.assumptions = assumptions;
    if let Some(what_if) = &mut concluded.audit.what_if {
        what_if.minor = minor;
    }
    Ok(())
}

/// Adds to an audit what may be stated and what that is worth.
///
/// # Errors
/// That in one of these audits the analysis and the interpreter disagree.
pub fn what_if_offered(
    concluded: &mut Concluded,
    request: &Request<'_>,
    most: &[u32],
) -> Result<(), Failure> {
    let counts = stated_counts(&concluded.audit, request, most)?;
    let own = own(concluded, request)?;
    concluded.audit.what_if = Some(WhatIf { own, ..counts });
    Ok(())
}

/// What the unknown counts are worth. Each bound is that of a whole audit that is asked the same besides, so each has the
/// time limit for itself.
fn stated_counts(audit: &Audit, request: &Request<'_>, most: &[u32]) -> Result<WhatIf, Failure> {
    (request.progress)(Progress::Stage(STAGE));
    let mut most = most.to_vec();
    most.sort_unstable();
    most.dedup();
    let steps = steps(audit, request, &most)?;
    Ok(WhatIf { most, steps, minor: None, own: None })
}

/// What lowers the bound with all trusted: that is asked first, and then what of it matters.
fn own(concluded: &Concluded, request: &Request<'_>) -> Result<Option<Own>, Failure> {
    let Some((upper, mut new)) = trusting_all(&concluded.audit, request)? else { return Ok(None) };
    // What a front makes for itself has no name that a facts file could state: nobody else writes it anyway.
    let areas = &concluded.followed.program.areas;
    let is_hidden = |device: &String| {
        areas.iter().any(|area| area.role == Role::Internal && device.starts_with(&area.name))
    };
    new.iter_mut().for_each(|one| one.devices.retain(|device| !is_hidden(device)));
    new.retain(|one| !one.devices.is_empty());
    let all = Request { trust: Trust::All, ..*request };
    let priced = priced(new, &concluded.followed.program, upper, &all)?;
    let worth = priced.assumptions.into_iter().filter(|one| one.without.is_some());
    let devices: Vec<String> = worth.flat_map(|one| one.devices).collect();
    let devices = Vec::from_iter(stated::whole(&concluded.followed.program, devices.iter()));
    let mut facts = request.facts.clone();
    facts.internal.extend(devices.iter().cloned());
    let found = runs(request, &[facts])?.into_iter().flatten().next();
    let lower = found.filter(|found| matters(found.bound.upper, concluded.audit.bound.upper));
    Ok(lower.map(|found| Own { devices, bound: found.bound }))
}

/// The bound with all trusted, and the assumptions that it rests on besides; none where it is not worth telling, or where
/// the user said whom to trust otherwise.
pub(super) fn trusting_all(
    audit: &Audit,
    request: &Request<'_>,
) -> Result<Option<(Picos, Vec<Assumption>)>, Failure> {
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
    Ok(Some((found.bound.upper, found.assumptions.into_iter().filter(is_new).collect())))
}

/// Whether a bound is so much below another that it is worth telling.
pub(super) fn matters(lower: Picos, upper: Picos) -> bool {
    upper.0 >= lower.0.saturating_add((lower.0 / SMALLEST).max(1))
}

/// What an audit finds that is asked with other facts.
pub(super) struct Run {
    pub(super) bound: SolvedBound,
    unknowns: Vec<Unknown>,
    assumptions: Vec<Assumption>,
}

/// Audits with other facts, several at a time. None where such facts cannot be.
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
            Ok(Audit { bound, unknowns, assumptions, cuts, elapsed, .. }) => {
                let is_over = request.time_limit.is_some_and(|limit| elapsed >= limit);
                let cut = is_over || !cuts.is_empty();
                let bound = SolvedBound { upper: bound.upper, cut };
                Ok(Some(Run { bound, unknowns, assumptions }))
            }
            Err(Failure::Input(_)) => Ok(None),
            Err(why) => Err(why),
        }
    };
    // Each has threads of its own: one that waits for another's would be late by that, and may end with less proved.
    let threads = rayon::current_num_threads();
    let mut found = Vec::new();
    for few in facts.chunks(threads) {
        let own = || rayon::ThreadPoolBuilder::new().num_threads(threads / few.len()).build();
        let start = |facts| match own() {
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

/// States what is named first, then besides that what is named first then, and so on: the bound of one is often hidden
/// behind that of the next. Where that changes next to nothing the dearest count is stated next.
fn steps(audit: &Audit, request: &Request<'_>, most: &[u32]) -> Result<Vec<Step>, Failure> {
    let mut steps: Vec<Step> = Vec::new();
    let mut facts = vec![request.facts.clone(); most.len()];
    let mut named = audit.unknowns.to_vec();
    let (mut upper, mut counts_first) = (audit.bound.upper, false);
    while steps.len() < MOST_STEPS && !(request.cancelled)() {
        let is_new = |one: &&Unknown| {
            !matches!(one.kind, UnknownKind::Indirect)
                && steps.iter().all(|step| step.unknown.key != one.key)
        };
        let dearest =
            named.iter().filter(|_| counts_first).find(|one| is_new(one) && one.counts().is_some());
        let Some(unknown) = dearest.or_else(|| named.iter().find(is_new)).cloned() else { break };
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
        steps.push(Step { unknown, solved });
    }
    Ok(steps)
}

/// Where the time limit ended an audit, what is known of scans with less stated, or with more counted, is no less true of
/// it: the bounds of the step `before` and of larger counts, or the bound with nothing of this stated.
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

/// What assumptions are worth.
struct Priced {
    /// Those that are worth listing, the dearest first.
    assumptions: Vec<Assumption>,
    /// What the others are worth together.
    minor: Option<Minor>,
}

/// The assumptions that are worth listing, the dearest first, and what the others are worth together. Many are left out at
/// once, then, where that matters, half of them: without fewer assumptions no bound is higher.
fn priced(
    mut all: Vec<Assumption>,
    program: &Program,
    upper: Picos,
    request: &Request<'_>,
) -> Result<Priced, Failure> {
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
    while !open.is_empty() && asked + open.len() <= MOST_PRICING && !(request.cancelled)() {
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
            match (run.map(|run| run.bound), &some[..]) {
                (Some(without), &[one]) if matters(upper, without.upper) => {
                    prices[one] = Some(without);
                }
                (Some(without), some) if !matters(upper, without.upper) => {
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
    // Of two that keep the same from happening each is worth nothing by itself.
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
    Ok(Priced { assumptions: all, minor })
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
        // What was not cut is what a run finds, and left as it is.
        let mut whole = [bound(130, false), bound(120, false)];
        no_higher(&mut whole, None, upper);
        assert_eq!(whole, [bound(130, false), bound(120, false)]);
    }
}

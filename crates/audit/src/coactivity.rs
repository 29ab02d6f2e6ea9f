//! How much the bound is lowered because steps and stored actions of charts are mutually exclusive.

use super::Audit;
use super::Value;
use super::failure::Failure;
use super::pipeline::{Concluded, audit};
use super::request::{Progress, Request};
use super::requested::Coactivity;
use super::solved_bound::SolvedBound;
use scanbound_ir::Program;
use std::time::Duration;

/// The second audit may use at least the time limit divided by this, however much of the limit the first audit used.
const LEAST_SHARE: u32 = 10;

/// Adds the bound without the mutual exclusion of charts to the audit, found by a second, complete audit. That one may
/// take what is left of the time limit, but no longer than the first audit, and always a tenth of the limit. Nothing is
/// added if there are no charts, if the request does not use their exclusion or asks only about a limit, if nothing
/// bounds the scan, or if the time ended the second audit without a result.
///
/// # Errors
/// If the analysis and the interpreter disagree in that audit.
pub fn coactivity(concluded: &mut Concluded, request: &Request<'_>) -> Result<(), Failure> {
    concluded.audit.coactivity = of(&concluded.followed.program, &concluded.audit, request)?;
    Ok(())
}

fn of(
    program: &Program,
    found: &Audit,
    request: &Request<'_>,
) -> Result<Option<Coactivity>, Failure> {
    if program.charts.exclusions == 0
        || !request.use_chart_exclusion
        || request.limit.is_some()
        || !found.unbounded.is_empty()
    {
        return Ok(None);
    }
    (request.progress)(Progress::Stage("solving with steps active in any combination"));
    let left = |limit: Duration| {
        limit.saturating_sub(found.elapsed).min(found.elapsed).max(limit / LEAST_SHARE)
    };
    let all = Request {
        use_chart_exclusion: false,
        proves_facts: false,
        confirm: false,
        trace: false,
        time_limit: request.time_limit.map(left),
        ..*request
    };
    let without = match audit(&all) {
        // The input is that of the first audit, so only the time ended this one.
        Err(Failure::Input(_)) => return Ok(None),
        without => without?,
    };
    if !without.unbounded.is_empty() {
        return Ok(None);
    }
    let names = program.charts.active.iter().map(|cell| program.cell_name(*cell));
    let names: std::collections::BTreeSet<String> = names.collect();
    let on = found.witness.iter().filter(|one| one.at_start && one.value == Value::Bit(true));
    let active = on.filter(|one| names.contains(&one.name)).map(|one| one.name.clone());
    // If the time ran out, the second bound may be lower than the first.
    let upper = without.bound.upper.max(found.bound.upper);
    let is_over = all.time_limit.is_some_and(|limit| without.elapsed >= limit);
    let without = SolvedBound { upper, cut: is_over || !without.cuts.is_empty() };
    Ok(Some(Coactivity { without, active: active.collect() }))
}

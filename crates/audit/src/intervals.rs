//! How often interrupts at fixed intervals are charged in a scan: at least as often as they are due in the longest
//! scan.

use super::due::due;
use super::failure::Failure;
use super::pipeline::audit;
use super::request::Request;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use std::collections::BTreeMap;

/// The largest number of audits in which assumed numbers of interrupts may turn out too small. With more, the scan is
/// treated as endless.
const MAX_ROUNDS: usize = 16;
/// With more interrupts of one routine than this, a scan is treated as endless.
const MAX_TIMES: u64 = 100_000;

/// The facts of the request with a number of runs in one scan for each interrupt whose interval is stated. The numbers
/// are enough for the upper bound of an audit with them; they were found by such audits, beginning without interrupts.
///
/// # Errors
/// The errors of the audits, and that the interrupts leave no time for the scan, so that no numbers suffice.
pub fn counted(request: &Request<'_>) -> Result<Facts, Failure> {
    let intervals = &request.facts.intervals;
    let with = |counts: &BTreeMap<String, u64>| {
        let mut facts = request.facts.clone();
        for (name, &times) in counts {
            facts.interrupts.insert(name.clone(), u32::try_from(times).unwrap_or(u32::MAX));
        }
        facts
    };
    let bound = |counts: &BTreeMap<String, u64>| {
        let facts = with(counts);
        let quick = Request { facts: &facts, proves_facts: false, limit: None, ..*request };
        let audit = audit(&quick)?;
        Ok::<_, Failure>((audit.bound.upper, audit.holds_interrupts))
    };
    let none: BTreeMap<String, u64> = intervals.keys().map(|name| (name.clone(), 0)).collect();
    let (alone, holds) = bound(&none)?;
    // The additional time of one interrupt of each routine.
    let mut each = BTreeMap::new();
    for name in intervals.keys() {
        let mut one = none.clone();
        one.insert(name.clone(), 1);
        each.insert(name, bound(&one)?.0.checked_sub(alone).unwrap_or_default());
    }
    let mut scan = alone;
    let mut counts = none;
    let mut rounds = 0;
    loop {
        let next: BTreeMap<String, u64> = intervals
            .iter()
            .map(|(name, &every)| (name.clone(), due(scan, every, holds)))
            .collect();
        if next.values().any(|&times| times > MAX_TIMES) {
            return Err(no_time(request));
        }
        let is_same = next == counts;
        counts = next;
        if is_same {
            // An estimate from these times. The audit then checks whether the counts suffice.
            let (found, _) = bound(&counts)?;
            if intervals.iter().all(|(name, &every)| due(found, every, holds) <= counts[name]) {
                return Ok(with(&counts));
            }
            rounds += 1;
            if rounds > MAX_ROUNDS {
                return Err(no_time(request));
            }
            scan = found;
            continue;
        }
        let mut more = counts.iter().map(|(name, &times)| each[name].0.checked_mul(times));
        let more = more.try_fold(0_u64, |sum, one| sum.checked_add(one?));
        let Some(sum) = more.and_then(|more| alone.0.checked_add(more)) else {
            return Err(no_time(request));
        };
        scan = scan.max(Picos(sum));
    }
}

fn no_time(request: &Request<'_>) -> Failure {
    let every: Vec<String> = request
        .facts
        .intervals
        .iter()
        .map(|(name, every)| format!("{name} every {every}"))
        .collect();
    let message = format!(
        "the scan has no bound: with the stated intervals, the interrupts take all the CPU's time, or are too many in one scan ({})",
        every.join(", ")
    );
    let help = "state longer intervals, or the largest number of interrupts in one scan: --interrupts I28=3";
    let file = request.inputs.first().map_or("", |input| &input.name);
    Failure::from(Diagnostic::file(Code::Facts, file, message, help))
}

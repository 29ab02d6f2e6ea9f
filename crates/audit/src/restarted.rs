//! An upper bound on the longest time between two restarts of the watchdog, from the model of a scan. It knows which
//! conditions exclude each other, which the bound from the program's structure does not.

use scanbound_base::time::Picos;
use scanbound_ir::{Frame, Program, Step};
use scanbound_model::groups::groups;
use scanbound_model::{Assignment, ByUnits, Charge, Lit, ScanModel};
use scanbound_solve::{Limits, Method, maxima, methods};
use std::collections::BTreeSet;

/// The largest number of watchdog restarts in a scan that are examined. Each is a search as long as that of the bound.
const MAX_RESTARTS: usize = 16;

/// An upper bound on the time that passes in a scan without a restart, interrupts not included. `around` is the time
/// outside of the program. `None` if a summarised loop or routine restarts the watchdog, if there are too many
/// restarts, or if the result is not less than `useful`.
pub fn upper(
    program: &Program,
    model: &ScanModel,
    (around, useful): (Picos, Picos),
    limits: &Limits<'_>,
) -> Option<Picos> {
    let entries = program.interrupt_entries();
    let is_main = |charge: &&Charge| !Frame::in_interrupt(&charge.frames, &entries);
    let restarts = &program.scan_control.restarts;
    // The charges of a summary have no order.
    let is_summarised = program.instructions.iter().any(|one| match &one.step {
        Step::Summary(summary) => summary.charges.iter().any(|(at, _)| restarts.contains(at)),
        _ => false,
    });
    let charges: Vec<&Charge> = model.charges.iter().filter(is_main).collect();
    let restart = |at: &usize| restarts.contains(&charges[*at].instruction);
    let places: Vec<usize> = (0..charges.len()).filter(restart).collect();
    if is_summarised || places.len() > MAX_RESTARTS || !model.unbounded.is_empty() {
        return None;
    }
    let mut longest = Picos::ZERO;
    for from in std::iter::once(None).chain(places.iter().copied().map(Some)) {
        longest =
            longest.max(longest_until_restart(model, &charges, (from, restarts), around, limits)?);
        if longest >= useful {
            return None;
        }
    }
    Some(longest)
}

/// An upper bound on the time from the restart `from`, or from the beginning of the scan if that is `None`, to the next
/// restart that fires or the end of the scan. If it begins or ends with the scan, it includes `around`, the time
/// outside of the program. `None` if the time is too large.
fn longest_until_restart(
    model: &ScanModel,
    charges: &[&Charge],
    (from, restarts): (Option<usize>, &BTreeSet<usize>),
    around: Picos,
    limits: &Limits<'_>,
) -> Option<Picos> {
    let mut part = ScanModel { charges: Vec::new(), ..model.clone() };
    // Whether no restart has fired since the beginning of this part.
    let mut counts = from.map_or(Lit::TRUE, |from| charges[from].fires);
    for (at, &charge) in charges.iter().enumerate().skip(from.unwrap_or(0)) {
        let mut along = |lit| part.circuit.and(lit, counts);
        let counted = charge.counted.as_deref().map(|by| {
            let units = by.units.iter().map(|&(handled, more)| (along(handled), more)).collect();
            Box::new(ByUnits { base: by.base, units })
        });
        let (reached, fires) = (along(charge.reached), along(charge.fires));
        // The time of the restart instruction itself may belong to either part, so it counts in both.
        part.charges.push(Charge { reached, fires, counted, ..charge.clone() });
        if restarts.contains(&charge.instruction) && from != Some(at) {
            counts = part.circuit.and(counts, !charge.fires);
        }
    }
    // The beginning of a scan restarts the watchdog, too.
    let end = if from.is_none() { Lit::TRUE } else { counts };
    let outside = Charge {
        instruction: 0,
        frames: Vec::new(),
        reached: end,
        fires: end,
        on: around,
        off: Picos::ZERO,
        counted: None,
    };
    part.charges.push(outside);
    let slices = groups(&part);
    let methods = methods(&slices, Method::Auto);
    let found = maxima(&part, &slices, &methods, limits, &|_, _, _| {});
    let constant = part.cost(&part.constant_charges(), &Assignment(vec![0; part.variables.len()]));
    found.iter().try_fold(constant.0, |sum, one| sum.checked_add(one.upper.0)).map(Picos)
}

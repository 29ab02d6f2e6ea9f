//! The longest time between two restarts of the watchdog, by the model of a scan: what conditions let run together
//! counts.

use scanbound_base::time::Picos;
use scanbound_ir::{Frame, Program, Step};
use scanbound_model::groups::groups;
use scanbound_model::{Assignment, ByUnits, Charge, Lit, ScanModel};
use scanbound_solve::{Limits, Method, maxima, methods};
use std::collections::BTreeSet;

/// The largest number of watchdog restarts in a scan that are examined. Each is a search as long as that of the bound.
const MAX_RESTARTS: usize = 16;

/// No longer time passes in a scan without a restart, where the model can tell, without interrupts. `around` is what
/// passes outside of the program. `None` where a summarised loop or routine restarts the watchdog, or too much does, or
/// where the result is not below `useful`.
pub fn upper(
    program: &Program,
    model: &ScanModel,
    (around, useful): (Picos, Picos),
    limits: &Limits<'_>,
) -> Option<Picos> {
    let entries = program.interrupt_entries();
    let is_main = |charge: &&Charge| !Frame::in_interrupt(&charge.frames, &entries);
    let restarts = &program.scan_control.restarts;
    // What is summarised is charged in no order.
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
        longest = longest.max(behind(model, &charges, (from, restarts), around, limits)?);
        if longest >= useful {
            return None;
        }
    }
    Some(longest)
}

/// The longest time from the scan's begin, or from a restart that fires, to the next restart that fires or the scan's
/// end.
fn behind(
    model: &ScanModel,
    charges: &[&Charge],
    (from, restarts): (Option<usize>, &BTreeSet<usize>),
    around: Picos,
    limits: &Limits<'_>,
) -> Option<Picos> {
    let mut part = ScanModel { charges: Vec::new(), ..model.clone() };
    // Whether time still counts where control stands.
    let mut counts = from.map_or(Lit::TRUE, |from| charges[from].fires);
    for (at, &charge) in charges.iter().enumerate().skip(from.unwrap_or(0)) {
        let mut along = |lit| part.circuit.and(lit, counts);
        let counted = charge.counted.as_deref().map(|by| {
            let units = by.units.iter().map(|&(handled, more)| (along(handled), more)).collect();
            Box::new(ByUnits { base: by.base, units })
        });
        let (reached, fires) = (along(charge.reached), along(charge.fires));
        // What a restart itself takes may count before it and after it.
        part.charges.push(Charge { reached, fires, counted, ..charge.clone() });
        if restarts.contains(&charge.instruction) && from != Some(at) {
            counts = part.circuit.and(counts, !charge.fires);
        }
    }
    // The scan's begin restarts it, too.
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

//! Combines the groups' best assignments into one scan, and compares the time that the analysis gives for it with the
//! interpreter's.

use super::failure::Failure;
use super::request::Request;
use scanbound_base::budget::Budget;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_ir::Program;
use scanbound_model::groups;
use scanbound_model::{Assignment, Group, GroupAssignment, Lit, ScanModel, Values};
use scanbound_replay::Replay;
use scanbound_solve::{Limits, Maximum, Method, maximum};
use std::time::{Duration, Instant};

/// The message if no scan satisfies the stated facts. A later stage replaces it by one that names the facts.
pub(super) const CONTRADICTION: &str =
    "no scan satisfies all facts under [ranges], [counts] and [exclusive]";

/// A scan that satisfies the stated facts is searched for at least this long, even after the time limit.
const GRACE: Duration = Duration::from_secs(2);

/// Combines the groups' best assignments into one, which is possible because groups share no variable. For a group
/// without a feasible assignment, one is searched and stored in `maxima`. Variables that only constraints use get
/// values too, so that the scan satisfies all stated facts. Fails if there is no such scan, or none is found in time.
pub(super) fn together(
    request: &Request<'_>,
    budget: &Budget<'_>,
    model: &ScanModel,
    groups: &[Group],
    maxima: &mut [Maximum],
) -> Result<Assignment, Failure> {
    let mut all = Assignment(vec![0; model.variables.len()]);
    for (group, maximum) in groups.iter().zip(maxima) {
        // A search that ended before it found a feasible scan has no best assignment.
        if !maximum.feasible {
            let constraints = Group { charges: Vec::new(), ..group.clone() };
            (maximum.best, maximum.feasible) =
                (allowed(request, budget, model, &constraints)?, true);
            maximum.lower = model.cost(&group.charges, &maximum.best.complete(model));
        }
        maximum.best.copy_to(&mut all);
    }
    if let Some(rest) = groups::unused_constraints(model, groups) {
        allowed(request, budget, model, &rest)?.copy_to(&mut all);
    }
    Ok(all)
}

/// An assignment that satisfies the constraints of a group without charges. Fails if there is none, or if none is found
/// in time.
fn allowed(
    request: &Request<'_>,
    budget: &Budget<'_>,
    model: &ScanModel,
    constraints: &Group,
) -> Result<GroupAssignment, Failure> {
    let contradicts = Err(Failure::from(Diagnostic::file(
        Code::Facts,
        request.inputs.first().map_or("", |input| &input.name),
        CONTRADICTION,
        "look for two facts about the same word, and for a fact about a number of iterations or units that the program sets to a different constant",
    )));
    // The program sets a count to a constant that contradicts the stated count.
    if constraints.constraints.iter().any(|&index| model.constraints[index] == Lit::FALSE) {
        return contradicts;
    }
    // This is nearly always found at once, so it is searched for even if the time is over.
    let least = Instant::now() + GRACE;
    let deadline = budget.deadline().map(|end| end.max(least));
    let limits = Limits { deadline, ..Limits::default() };
    let found = maximum(model, constraints, Method::Auto, &limits);
    if found.feasible {
        return Ok(found.best);
    }
    if deadline.is_some_and(|end| Instant::now() >= end) {
        return Err(Failure::from(Diagnostic::file(
            Code::Time,
            request.inputs.first().map_or("", |input| &input.name),
            "within the time limit, no scan was found that satisfies all facts under [ranges], [counts] and [exclusive]",
            "give the audit more time (--time-limit), or state fewer facts",
        )));
    }
    contradicts
}

/// Checks that the replayed scan takes as long as the analysis says, that it violates no stated range and no invariant,
/// and that each group's charges take the time that its search gave. Otherwise fails with an internal error.
pub(super) fn confirm(
    program: &Program,
    model: &ScanModel,
    groups: &[Group],
    maxima: &[Maximum],
    assignment: &Assignment,
    replayed: &Replay,
) -> Result<(), Failure> {
    let values = model.circuit.evaluate(assignment);
    let modelled: Picos = model.charges.iter().map(|charge| charge.cost(&values)).sum();
    if replayed.total != modelled {
        return Err(Failure::Internal(format!(
            "the longest scan takes {} in the interpreter, but {modelled} in the analysis{}",
            replayed.total,
            first_difference(program, model, &values, replayed)
        )));
    }
    if let Some(&range) = replayed.broken_ranges.first() {
        let cell = program.cell_name(program.stated_ranges[range].cells[0]);
        return Err(Failure::Internal(format!(
            "the longest scan violates the stated range of {cell}"
        )));
    }
    if !replayed.broken_invariants.is_empty() {
        return Err(Failure::Internal(
            "the longest scan starts with values that an invariant excludes".to_owned(),
        ));
    }
    for (group, maximum) in groups.iter().zip(maxima) {
        let cost: Picos = group.charges.iter().map(|&c| model.charges[c].cost(&values)).sum();
        if cost != maximum.lower || maximum.lower > maximum.upper {
            return Err(Failure::Internal(format!(
                "the longest scan that was found for a group takes {cost}, but the bounds that its search gives are {} and {}",
                maximum.lower, maximum.upper
            )));
        }
    }
    Ok(())
}

/// The first instruction, in program order, with a call context in which its time in the interpreter differs from that
/// in the analysis, as a text for the message. Empty if there is none.
fn first_difference(
    program: &Program,
    model: &ScanModel,
    values: &Values,
    replayed: &Replay,
) -> String {
    let mut costs: std::collections::BTreeMap<(usize, Vec<scanbound_ir::Frame>), (Picos, Picos)> =
        std::collections::BTreeMap::new();
    for charge in &model.charges {
        let key = (charge.instruction, charge.frames.clone());
        costs.entry(key).or_default().0 += charge.cost(values);
    }
    for event in &replayed.events {
        costs.entry((event.instruction, event.frames.to_vec())).or_default().1 += event.cost;
    }
    let different = costs.iter().find(|(_, (modelled, ran))| modelled != ran);
    different.map_or(String::new(), |((instruction, _), (modelled, ran))| {
        let at = &program.instructions[*instruction];
        format!(
            "; first at {}:{} {}: {ran} and {modelled}",
            at.place.of(&program.files).name,
            at.place.line,
            at.text
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{Concluded, Followed, conclude, follow};
    use scanbound_base::facts::Facts;
    use scanbound_front::Input;
    use scanbound_replay::replay;

    #[test]
    fn a_scan_that_the_interpreter_prices_differently_is_an_internal_error() {
        let text = "LD X0\nMOV K1 D0\nLDI X0\nBMOV D0 D10 K5\nEND\n";
        let inputs = [Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() }];
        let facts = Facts::default();
        let request = Request { cpu: Some("Q26UDV"), ..Request::new(&inputs, &facts) };
        let followed = follow(&request).expect("a program");
        let Concluded { followed, mut maxima, .. } =
            conclude(followed, &request).expect("an audit");
        let Followed { program, prices, model, groups, .. } = &followed;
        let budget = Budget::new(Instant::now(), None, request.cancelled, Vec::new());
        let assignment = together(&request, &budget, model, groups, &mut maxima).expect("a scan");
        let times = prices.times();
        let mut replayed = replay(program, &times, &groups::witness(model, &assignment));
        let confirmed = |maxima: &[Maximum], replayed: &Replay| {
            confirm(program, model, groups, maxima, &assignment, replayed)
        };
        let internal =
            |maxima: &[Maximum], replayed: &Replay, what: &str| match confirmed(maxima, replayed) {
                Err(Failure::Internal(told)) => assert!(told.contains(what), "{told}"),
                other => panic!("{other:?}"),
            };
        assert_eq!(confirmed(&maxima, &replayed), Ok(()));
        replayed.total += Picos(1);
        internal(&maxima, &replayed, "in the interpreter, but");
        replayed.total = replay(program, &times, &groups::witness(model, &assignment)).total;
        maxima[0].lower += Picos(1);
        internal(&maxima, &replayed, "its search gives are");
    }
}

//! How each group's maximum was found: the search, its steps, and the second opinion of another solver.

use super::condition;
use super::deciding::depends_on;
use super::failure::Failure;
use super::names::Names;
use super::request::Request;
use rayon::prelude::*;
use scanbound_base::budget::Budget;
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::Program;
use scanbound_model::{Group, ScanModel};
pub use scanbound_solve::trace::{Step, Trace};
use scanbound_solve::{Engine, Item, Limits, Maximum, Opinion, Problem, second_opinion};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The largest number of conditions of a group that are written.
const MAX_CONDITIONS: usize = 200;

/// The number of devices that are named for a condition that is too long to be written.
const MAX_NAMED_DEVICES: usize = 8;

/// How the maximum of a group was searched.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SearchUse {
    /// The search that found the bounds of the group.
    pub engine: Engine,
    /// The second opinion of Z3. `None` if it was not asked for.
    pub opinion: Option<Opinion>,
    /// The steps of the search. `None` if they were not requested.
    pub trace: Option<TraceUse>,
}

impl SearchUse {
    /// A record of a search of which only the method is known: without opinion and steps.
    #[must_use]
    pub fn by(engine: Engine) -> SearchUse {
        SearchUse { engine, opinion: None, trace: None }
    }
}

/// The steps of the search of one group, with names for reports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceUse {
    /// The time that the group takes in every scan.
    pub constant: Picos,
    /// The time that is subtracted from the sum, because the conditions' times include units even where an instruction
    /// processes none.
    pub deducted: Picos,
    /// The conditions in the steps. A step refers to them by index.
    pub conditions: Vec<ConditionUse>,
    /// The steps, in the order of the search.
    pub trace: Trace,
}

/// A condition under which charges take more time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConditionUse {
    /// The number of the rung in which the condition first occurs, followed by a letter if the rung has several
    /// conditions.
    pub label: String,
    /// The time that the condition adds to the scan if it is true.
    pub cost: Picos,
    /// The place of the instruction that takes the most time under this condition.
    pub at: Location,
    /// The text of the instruction that takes the most time under this condition.
    pub instruction: Arc<str>,
    /// The number of the other charges that depend on the condition.
    pub others: usize,
    /// The condition in words (`if X0 and not M5`). If it is too long, or the group has too many: the devices on which
    /// it depends (`by X0, M5`).
    pub condition: String,
}

/// How the maximum of each group was searched, with the steps and opinions that were requested.
pub fn searches(
    maxima: &[Maximum],
    traces: Option<Vec<TraceUse>>,
    opinions: Option<Vec<Opinion>>,
) -> Vec<SearchUse> {
    let mut traces = traces.map(Vec::into_iter);
    let mut opinions = opinions.map(Vec::into_iter);
    let search = |maximum: &Maximum| SearchUse {
        engine: maximum.engine,
        opinion: opinions.as_mut().and_then(Iterator::next),
        trace: traces.as_mut().and_then(Iterator::next),
    };
    maxima.iter().map(search).collect()
}

/// The steps of each group's search, in the order of the groups, with the conditions in words.
pub fn traces(
    program: &Program,
    model: &ScanModel,
    groups: &[Group],
    maxima: &[Maximum],
) -> Vec<TraceUse> {
    let names = Names::new(program);
    let trace = |(group, maximum): (&Group, &Maximum)| {
        let problem = Problem::new(model, group);
        let name = |own: scanbound_model::VarId| {
            names.free(&model.variables[problem.variable(own).0 as usize])
        };
        let block = |charge: usize| program.instructions[model.charges[charge].instruction].block;
        let mut rungs: BTreeMap<u32, usize> = BTreeMap::new();
        for item in &problem.items {
            *rungs.entry(block(item.charges[0])).or_default() += 1;
        }
        let mut met: BTreeMap<u32, usize> = BTreeMap::new();
        let conditions = problem.items.iter().enumerate().map(|(index, item)| {
            let first = block(item.charges[0]);
            let times = met.entry(first).or_default();
            *times += 1;
            let letter = if rungs[&first] > 1 { letters(*times - 1) } else { String::new() };
            let largest = item.charges.iter().rev().copied();
            let largest = largest.max_by_key(|&charge| model.charges[charge].largest_cost());
            let charge = largest.unwrap_or(item.charges[0]);
            let instruction = &program.instructions[model.charges[charge].instruction];
            ConditionUse {
                label: format!("{first}{letter}"),
                cost: Picos(item.weight),
                at: instruction.place,
                instruction: instruction.text.clone(),
                others: item.charges.len() - 1,
                condition: (index < MAX_CONDITIONS)
                    .then(|| condition::text(&problem.circuit, item.guard, &name))
                    .flatten()
                    .map_or_else(|| devices(model, item, &names), |words| format!("if {words}")),
            }
        });
        TraceUse {
            constant: Picos(problem.constant),
            deducted: Picos(problem.deducted),
            conditions: conditions.collect(),
            trace: maximum.trace.clone(),
        }
    };
    groups.iter().zip(maxima).map(trace).collect()
}

/// The devices on which a condition depends, as `by X0, M5 and 3 more`: for a condition that is too long to be written.
fn devices(model: &ScanModel, item: &Item, names: &Names<'_>) -> String {
    let variables = depends_on(model, &item.charges[..1]).into_iter();
    let all = variables.map(|variable| names.device(&model.variables[variable.0 as usize]));
    let mut met = BTreeSet::new();
    let mut devices: Vec<String> = all.filter(|device| met.insert(device.clone())).collect();
    let more = match devices.len().saturating_sub(MAX_NAMED_DEVICES) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    devices.truncate(MAX_NAMED_DEVICES);
    format!("by {}{more}", devices.join(", "))
}

/// The letters that number a condition: a, b, ..., z, aa, ab, ...
fn letters(number: usize) -> String {
    let last = char::from(b'a' + u8::try_from(number % 26).unwrap_or(0));
    let before = if number < 26 { String::new() } else { letters(number / 26 - 1) };
    format!("{before}{last}")
}

/// The second opinion of Z3 on the maximum of every group, in the order of the groups.
///
/// # Errors
/// If Z3 contradicts a search.
pub fn opinions(
    request: &Request<'_>,
    model: &ScanModel,
    groups: &[Group],
    maxima: &[Maximum],
    budget: &Budget<'_>,
) -> Result<Vec<Opinion>, Failure> {
    let deadline = budget.deadline();
    let limits = Limits { deadline, cancelled: request.cancelled, ..Limits::default() };
    let opinions: Vec<Result<Opinion, String>> = groups
        .par_iter()
        .zip(maxima)
        .map(|(group, maximum)| second_opinion(model, group, maximum, &limits))
        .collect();
    let numbered = opinions.into_iter().enumerate();
    let opinions = numbered
        .map(|(index, opinion)| {
            opinion.map_err(|why| Failure::Internal(format!("group {}: {why}", index + 1)))
        })
        .collect::<Result<Vec<Opinion>, Failure>>()?;
    let open = opinions.iter().filter(|opinion| **opinion == Opinion::RanOut).count();
    if open > 0 {
        let all = opinions.len();
        budget.record_stop(
            "confirming",
            format!("Z3 neither confirmed nor refuted the bound of {open} of {all} groups of instructions"),
        );
    }
    Ok(opinions)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_go_on_behind_z() {
        let opinions = [0, 25, 26, 51, 52, 701, 702].map(letters);
        assert_eq!(opinions, ["a", "z", "aa", "az", "ba", "zz", "aaa"]);
    }
}

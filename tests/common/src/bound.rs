//! Computes the bound of a program with the stages of the library.

use scanbound::base::time::{Picos, Times};
use scanbound::program::meaning::Knowledge;
use scanbound::program::{Program, Witness};
use scanbound::scan::groups::{groups, witness};
use scanbound::scan::model::{Assignment, Group, ScanModel, VarId};
use scanbound::scan::size_limits::SizeLimits;
use scanbound::scan::{Purpose, ScanError, scan_model_with_knowledge};
use scanbound::solve::{Limits, Method, maximum};

/// The result of the analysis of a program.
pub struct Bound {
    pub model: ScanModel,
    pub upper: Picos,
    pub lower: Picos,
    pub best: Witness,
    pub calls: u64,
}

pub fn bound(program: &Program, times: &[Times], method: Method) -> Result<Bound, ScanError> {
    bound_within(program, times, method, &Limits::default())
}

/// The same with a search that may end early.
pub fn bound_within(
    program: &Program,
    times: &[Times],
    method: Method,
    limits: &Limits<'_>,
) -> Result<Bound, ScanError> {
    bound_knowing(program, times, &Knowledge::new(), method, limits)
}

/// The same with knowledge about exact choices.
pub fn bound_knowing(
    program: &Program,
    times: &[Times],
    knowledge: &Knowledge,
    method: Method,
    limits: &Limits<'_>,
) -> Result<Bound, ScanError> {
    let model = scan_model_with_knowledge(
        program,
        times,
        knowledge,
        Purpose::UpperBound,
        &SizeLimits::default(),
    )?;
    let constant = |charge: &&scanbound::scan::model::Charge| charge.is_constant();
    let always: Picos = model
        .charges
        .iter()
        .filter(constant)
        .map(|charge| match (charge.reached.node(), charge.fires.node()) {
            (0, _) if charge.reached.is_negated() => Picos::ZERO,
            (0, 0) if charge.fires.is_negated() => charge.off,
            _ => charge.on,
        })
        .sum();
    let mut best = Assignment(vec![0; model.variables.len()]);
    let (mut upper, mut lower, mut calls) = (always, always, 0);
    let mut groups = groups(&model);
    groups.push(rest(&model, &groups));
    for group in groups {
        let found = maximum(&model, &group, method, limits);
        found.best.copy_to(&mut best);
        upper += found.upper;
        lower += found.lower;
        calls += found.calls;
    }
    let best = witness(&model, &best);
    Ok(Bound { model, upper, lower, best, calls })
}

/// The variables and constraints on which no guard with a time depends. They do not change the bound, but the witness
/// must satisfy the constraints.
fn rest(model: &ScanModel, groups: &[Group]) -> Group {
    let left = |constraint: &usize| !groups.iter().any(|g| g.constraints.contains(constraint));
    let constraints = (0..model.constraints.len()).filter(left).collect();
    let free = |variable: &VarId| !groups.iter().any(|g| g.variables.contains(variable));
    let variables = (0..model.variables.len() as u32).map(VarId).filter(free).collect();
    Group { charges: Vec::new(), variables, constraints }
}

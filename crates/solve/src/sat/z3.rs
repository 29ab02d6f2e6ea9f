//! Z3 as the SAT solver of the search by subsets.

use crate::clauses::Clauses;
use z3::ast::Bool;
use z3::{Config, Params, SatResult, Solver, with_z3_config};

/// Calls `work` with a Z3 context of its own, for the searches that it makes on this thread one after the other. With
/// one context for all threads, the choice among equally long scans would differ from run to run.
pub fn with_solver<R: Send + Sync>(work: impl FnOnce() -> R + Send + Sync) -> R {
    with_z3_config(&Config::new(), work)
}

/// A SAT solver with a set of clauses. Literals are those of [`Clauses`].
pub struct Sat {
    solver: Solver,
    variables: Vec<Bool>,
    /// The effort limit that is currently set in the solver.
    effort: u32,
}

impl Sat {
    /// A solver with these clauses. Call it within [`with_solver`].
    pub fn new(clauses: &Clauses) -> Sat {
        let solver = Solver::new_for_logic("QF_FD").unwrap_or_default();
        let variables = (1..=clauses.variables)
            .map(|v| Bool::new_const(u32::try_from(v).unwrap_or(0)))
            .collect();
        let sat = Sat { solver, variables, effort: 0 };
        for clause in clauses.clauses.iter() {
            let literals: Vec<Bool> = clause.iter().map(|&l| sat.literal(l)).collect();
            sat.solver.assert(Bool::or(&literals));
        }
        sat
    }

    fn literal(&self, literal: i32) -> Bool {
        let variable = &self.variables[literal.unsigned_abs() as usize - 1];
        if literal < 0 { variable.not() } else { variable.clone() }
    }

    /// Whether all assumptions can be true together; `None` if this takes more effort (Z3's `rlimit`).
    pub fn check(&mut self, assumptions: &[i32], effort: u32) -> Option<bool> {
        if self.effort != effort {
            self.effort = effort;
            let mut params = Params::new();
            params.set_u32("rlimit", effort);
            self.solver.set_params(&params);
        }
        let assumptions: Vec<Bool> = assumptions.iter().map(|&l| self.literal(l)).collect();
        match self.solver.check_assumptions(&assumptions) {
            SatResult::Sat => Some(true),
            SatResult::Unsat => Some(false),
            SatResult::Unknown => None,
        }
    }

    /// After a positive answer: the values of all variables.
    pub fn model(&self) -> impl Fn(i32) -> bool {
        let model = self.solver.get_model();
        move |literal| {
            let variable = &self.variables[literal.unsigned_abs() as usize - 1];
            let value = model.as_ref().and_then(|model| model.eval(variable, true));
            value.and_then(|value| value.as_bool()).unwrap_or(false)
        }
    }

    /// After a negative answer: a subset of the assumptions that cannot be true together.
    pub fn core(&self, assumptions: &[i32]) -> Vec<i32> {
        let named = self.solver.get_unsat_core();
        assumptions.iter().copied().filter(|&l| named.contains(&self.literal(l))).collect()
    }
}

//! Brings both bounds of a model closer together: searches it, makes real runs of the scans found, and searches again
//! with what these showed.

use super::failure::Failure;
use super::iterations::most_iterations;
use super::model_search::{LARGE, ModelSearch, Searched};
use super::modelling::put_back;
use super::real::{self, EarlyRuns, RunResults};
use super::request::{Progress, Request};
use scanbound_base::budget::Budget;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{Program, Witness};
use scanbound_model::groups;
use scanbound_model::{Group, ScanModel};
use scanbound_scan::size_limits::SizeLimits;
use scanbound_scan::{Purpose, scan_model_with_knowledge};
use scanbound_solve::Limits;
use scanbound_timing::price::Prices;

/// The largest size of a model that includes what real runs showed: its nodes and questions about words.
const MAX_LEARNED_SIZE: usize = 4_000_000;
/// The largest number of rounds in which loops are followed because their number of iterations became known.
const MAX_ROUNDS: usize = 8;

/// The settings with which both bounds are searched.
pub struct Refinement<'a, 'r> {
    pub request: &'a Request<'r>,
    pub budget: &'a Budget<'a>,
    pub limits: Limits<'r>,
    pub doubtful_from: Option<Picos>,
    /// Whether the model is only the structural bound: the sum of all instructions that can run.
    pub structural_only: bool,
}

/// The state of the real runs when a search ends.
pub enum Runs {
    /// All real runs are complete: their results.
    Complete(RunResults),
    /// Only those real runs are complete that do not need the result of the search.
    Early(EarlyRuns),
    /// As `Early`, but made by a second thread in a program with the same instructions.
    Beside(EarlyRuns),
    /// This thread makes no real runs: a second thread makes them.
    OtherThread,
}

impl<'r> Refinement<'_, 'r> {
    /// Returns the model's longest scan, and the real runs made so far. If these show how often summarised loops
    /// iterate, the loops are put back into the program. If another thread already makes real runs of this program
    /// (`early`), none are made here.
    pub fn search(
        &self,
        program: &mut Program,
        prices: &mut Prices,
        (mut model, mut groups): (ScanModel, Vec<Group>),
        early: Option<&Program>,
    ) -> Result<(Searched<'r>, Runs), Failure> {
        let mut knowledge = Knowledge::new();
        // The start of the longest run of the previous round.
        let mut other = Witness::default();
        let mut rounds = 0;
        loop {
            (self.request.progress)(Progress::Stage("searching"));
            let search = self.model_search(program, prices);
            // Searching a large model again takes several times as long as the first search, and what single scans show
            // hardly ever lowers its bound.
            if model.circuit.nodes().len() > LARGE && !self.structural_only {
                let is_same = |early| real::has_same_instructions(early, program);
                return match early.is_some_and(is_same) {
                    true => Ok((search.run(model, groups, &knowledge)?, Runs::OtherThread)),
                    false => self.search_with_runs(&search, (model, groups), &knowledge),
                };
            }
            let searched = search.run(model, groups, &knowledge)?;
            (self.request.progress)(Progress::Stage("simulating scans"));
            let least = prices.least_times();
            let starts = [&searched.witness, &other];
            let found = self.reals(program, &least).run(starts, searched.upper, knowledge);
            let found = found.map_err(Failure::Internal)?;
            let is_open = found.best.replay.total < searched.upper && !self.structural_only;
            if !is_open || found.knowledge.is_empty() {
                return Ok((searched, Runs::Complete(found)));
            }
            let limits = SizeLimits {
                per_execution: usize::MAX,
                in_all: MAX_LEARNED_SIZE,
                is_over: &|| self.budget.must_stop(),
            };
            let times = prices.times();
            let learned = &found.knowledge;
            let known =
                scan_model_with_knowledge(program, &times, learned, Purpose::UpperBound, &limits);
            let Ok(known) = known else { return Ok((searched, Runs::Complete(found))) };
            let iterations = most_iterations(&known, &self.limits);
            if rounds < MAX_ROUNDS
                && let Some(tighter) = put_back(program, prices, learned, &iterations, &limits)
            {
                (*program, *prices, model) = tighter;
                groups = groups::groups(&model);
                (knowledge, other) = (found.knowledge, found.witness);
                rounds += 1;
                continue;
            }
            return Ok((tighter(&search, searched, known, &found)?, Runs::Complete(found)));
        }
    }

    /// Searches a large model once, and at the same time makes the real runs that do not need the result. Both take
    /// about equally long, and each uses mainly one core.
    fn search_with_runs(
        &self,
        search: &ModelSearch<'_, 'r>,
        (model, groups): (ScanModel, Vec<Group>),
        knowledge: &Knowledge,
    ) -> Result<(Searched<'r>, Runs), Failure> {
        let least = search.prices.least_times();
        let reals = self.reals(search.program, &least);
        let (searched, early) =
            rayon::join(|| search.run(model, groups, knowledge), || reals.search_early());
        let early = early.map_err(Failure::Internal)?;
        Ok((searched?, Runs::Early(early)))
    }

    /// Makes the real runs that need the result of the search, and returns the longest run of all. `longest` is the
    /// start of the model's longest scan, and `upper` the bound on all charges.
    pub fn longest(
        &self,
        program: &Program,
        prices: &Prices,
        (longest, upper): (&Witness, Picos),
        runs: Runs,
    ) -> Result<RunResults, Failure> {
        let least = prices.least_times();
        let reals = self.reals(program, &least);
        let early = match runs {
            Runs::Complete(found) => return Ok(found),
            Runs::Early(early) => early,
            Runs::Beside(early) => reals.repeated(early).map_err(Failure::Internal)?,
            Runs::OtherThread => reals.search_early().map_err(Failure::Internal)?,
        };
        reals.continue_from(longest, upper, early).map_err(Failure::Internal)
    }

    fn model_search<'s>(&'s self, program: &'s Program, prices: &'s Prices) -> ModelSearch<'s, 'r> {
        ModelSearch {
            request: self.request,
            program,
            prices,
            budget: self.budget,
            doubtful_from: self.doubtful_from,
            structural_only: self.structural_only,
            limits: self.limits,
        }
    }

    fn reals<'s>(&'s self, program: &'s Program, least: &'s [Times]) -> real::RunSearch<'s> {
        real::RunSearch { program, least, limits: self.limits }
    }
}

/// Searches the model that includes what real runs showed. Returns this result or the one `before`, whichever has the
/// smaller upper bound. `Err` if a possible run takes longer than that bound.
fn tighter<'r>(
    search: &ModelSearch<'_, 'r>,
    before: Searched<'r>,
    known: ScanModel,
    found: &RunResults,
) -> Result<Searched<'r>, Failure> {
    let groups = groups::groups(&known);
    let again = search.run(known, groups, &found.knowledge)?;
    let searched = if again.upper < before.upper { again } else { before };
    if found.best.is_possible() && found.best.replay.total > searched.upper {
        let (took, upper) = (found.best.replay.total, searched.upper);
        return Err(Failure::Internal(format!(
            "a simulated scan takes {took}, more than the bound of {upper}"
        )));
    }
    Ok(searched)
}

//! Brings both bounds of a model closer: searches it, makes real runs of what it finds, and searches again with what
//! these taught.

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

/// The most nodes and questions to words of a model with what was learned.
const MOST_LEARNED: usize = 4_000_000;
/// The most rounds of following summarised loops after all, since their counts were learned.
const MOST_ROUNDS: usize = 8;

/// What both bounds are searched with.
pub struct Refinement<'a, 'r> {
    pub request: &'a Request<'r>,
    pub budget: &'a Budget<'a>,
    pub limits: Limits<'r>,
    pub doubtful_from: Option<Picos>,
    /// Whether the model is only the structural bound: the sum of all that can run.
    pub structural_only: bool,
}

/// The real runs that were made by the end of a search.
pub enum Runs {
    /// All that are made.
    Complete(RunResults),
    /// Those that need nothing from the search.
    Early(EarlyRuns),
    /// None: they are made on another thread.
    OtherThread,
}

impl<'r> Refinement<'_, 'r> {
    /// The model's dearest scan, and the real runs that were made by then. Where these show how many iterations summarised
    /// loops make, the program has these loops again. Real runs of the program that is `scouted` are left to others.
    pub fn search(
        &self,
        program: &mut Program,
        prices: &mut Prices,
        (mut model, mut groups): (ScanModel, Vec<Group>),
        early: Option<&Program>,
    ) -> Result<(Searched<'r>, Runs), Failure> {
        let mut knowledge = Knowledge::new();
        // Where the longest run of the round before starts.
        let mut other = Witness::default();
        let mut rounds = 0;
        loop {
            (self.request.progress)(Progress::Stage("searching"));
            let search = self.model_search(program, prices);
            // To search a large one again takes several times as long as the first time, and what single scans teach
            // hardly ever lowers its bound.
            if model.circuit.nodes().len() > LARGE && !self.structural_only {
                return match early == Some(program) {
                    true => Ok((search.run(model, groups, &knowledge)?, Runs::OtherThread)),
                    false => self.search_with_runs(&search, (model, groups), &knowledge),
                };
            }
            let searched = search.run(model, groups, &knowledge)?;
            (self.request.progress)(Progress::Stage("running it"));
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
                in_all: MOST_LEARNED,
                is_over: &|| self.budget.must_stop(),
            };
            let times = prices.times();
            let learned = &found.knowledge;
            let known =
                scan_model_with_knowledge(program, &times, learned, Purpose::UpperBound, &limits);
            let Ok(known) = known else { return Ok((searched, Runs::Complete(found))) };
            let iterations = most_iterations(&known, &self.limits);
            if rounds < MOST_ROUNDS
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

    /// Searches a large model once, and makes those real runs at the same time that need nothing from the search: each
    /// takes about as long, and much of it on one core only.
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

    /// The longest real run, after the search of the model.
    pub fn longest(
        &self,
        program: &Program,
        prices: &Prices,
        (dearest, upper): (&Witness, Picos),
        runs: Runs,
    ) -> Result<RunResults, Failure> {
        let least = prices.least_times();
        let reals = self.reals(program, &least);
        let early = match runs {
            Runs::Complete(found) => return Ok(found),
            Runs::Early(early) => early,
            Runs::OtherThread => reals.search_early().map_err(Failure::Internal)?,
        };
        reals.continue_from(dearest, upper, early).map_err(Failure::Internal)
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

    fn reals<'s>(&'s self, program: &'s Program, least: &'s [Times]) -> real::Search<'s> {
        real::Search { program, least, limits: self.limits }
    }
}

/// The closer of two searches: the one made before, and that of the model which knows what runs taught of operations.
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
        return Err(Failure::Internal(format!("a scan takes {took}, the bound is {upper}")));
    }
    Ok(searched)
}

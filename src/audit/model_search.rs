//! One search of a model: the maxima of its groups, and its longest scan, replayed by the interpreter.

use super::confirmed::{confirm, together};
use super::failure::Failure;
use super::request::{Progress, Request};
use super::search::Search;
use crate::base::budget::Budget;
use crate::base::time::Picos;
use crate::program::meaning::Knowledge;
use crate::program::{Program, Witness};
use crate::replay::{Replay, replay_knowing};
use crate::scan::groups;
use crate::scan::model::{Assignment, Group, ScanModel};
use crate::solve::Maximum;
use crate::timing::price::Prices;

/// What a model is searched with.
pub struct ModelSearch<'a> {
    pub request: &'a Request<'a>,
    pub program: &'a Program,
    pub prices: &'a Prices,
    pub budget: &'a Budget<'a>,
    pub doubtful_from: Option<Picos>,
    /// Whether the model is only the structural bound: the sum of all that can run.
    pub whole: bool,
}

/// A model's dearest scan, replayed.
pub struct Searched {
    pub model: ScanModel,
    pub groups: Vec<Group>,
    pub maxima: Vec<Maximum>,
    pub assignment: Assignment,
    pub witness: Witness,
    pub replayed: Replay,
    /// The charges' upper bound, without the scan's overhead.
    pub upper: Picos,
    pub ended_early: bool,
}

impl ModelSearch<'_> {
    /// Searches a model that was made with this knowledge.
    pub fn run(
        &self,
        model: ScanModel,
        groups: Vec<Group>,
        knowledge: &Knowledge,
    ) -> Result<Searched, Failure> {
        let zeros = Assignment(vec![0; model.variables.len()]);
        let always = model.cost(&model.constant(), &zeros);
        let search = Search {
            request: self.request,
            prices: self.prices,
            model: &model,
            groups: &groups,
            constant: self.prices.overhead_sum() + always,
            deadline: self.budget.deadline(),
            doubtful_from: self.doubtful_from,
        };
        let (mut maxima, ended_early) = if self.whole { search.sums() } else { search.run() };
        let assignment = together(self.request, self.budget, &model, &groups, &mut maxima)?;
        (self.request.progress)(Progress::Stage("replaying"));
        let witness = groups::witness(&model, &assignment);
        let replayed = replay_knowing(self.program, &self.prices.times(), knowledge, &witness);
        confirm(self.program, &model, &groups, &maxima, &assignment, &replayed)?;
        let upper = always + maxima.iter().map(|maximum| maximum.upper).sum::<Picos>();
        Ok(Searched { model, groups, maxima, assignment, witness, replayed, upper, ended_early })
    }
}

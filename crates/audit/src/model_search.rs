//! One search of a model: the maxima of its groups, and its longest scan, replayed by the interpreter.

use super::confirmed::{confirm, together};
use super::failure::Failure;
use super::request::{Progress, Request};
use super::search::GroupSearch;
use scanbound_base::budget::Budget;
use scanbound_base::time::Picos;
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{Program, Witness};
use scanbound_model::groups;
use scanbound_model::{Assignment, Group, ScanModel};
use scanbound_replay::{Replay, replay_knowing};
use scanbound_solve::{Exclusions, Limits, Maximum};
use scanbound_timing::price::Prices;

/// A model with more nodes than this is large: preparing the explanations then takes as long as a good part of the
/// search.
pub const LARGE: usize = 50_000;

/// The settings with which a model is searched.
pub struct ModelSearch<'a, 'r> {
    pub request: &'a Request<'a>,
    pub program: &'a Program,
    pub prices: &'a Prices,
    pub budget: &'a Budget<'a>,
    pub doubtful_from: Option<Picos>,
    /// Whether the model is only the structural bound: the sum of all instructions that can run.
    pub structural_only: bool,
    /// The limits of the search for explanations.
    pub limits: Limits<'r>,
}

/// The result of searching a model: the maximum of each group, and the longest scan that they make up, replayed.
pub struct Searched<'r> {
    pub model: ScanModel,
    /// What real runs had shown when the model was made.
    pub knowledge: Knowledge,
    pub groups: Vec<Group>,
    pub maxima: Vec<Maximum>,
    pub assignment: Assignment,
    pub witness: Witness,
    pub replayed: Replay,
    /// The upper bound on the sum of all charges, without the scan's overhead.
    pub upper: Picos,
    pub ended_early: bool,
    /// The prepared explanation of one group. `None` if the model is not large.
    pub prepared: Option<PreparedExplanation<'r>>,
}

/// A prepared search that explains why charges of one group (an index into the groups) do not take their larger time.
pub struct PreparedExplanation<'r> {
    pub group: usize,
    pub exclusions: Exclusions<'r>,
}

impl<'r> ModelSearch<'_, 'r> {
    /// Searches the maximum of each group, combines them to one scan and replays it. `knowledge` is what real runs had
    /// shown when the model was made. `Err` if no scan satisfies the stated facts, none is found in time, or the replay
    /// disagrees with the model.
    pub fn run(
        &self,
        model: ScanModel,
        groups: Vec<Group>,
        knowledge: &Knowledge,
    ) -> Result<Searched<'r>, Failure> {
        let zeros = Assignment(vec![0; model.variables.len()]);
        let always = model.cost(&model.constant_charges(), &zeros);
        let search = GroupSearch {
            request: self.request,
            prices: self.prices,
            model: &model,
            groups: &groups,
            constant: self.prices.overhead_sum() + always,
            deadline: self.budget.deadline(),
            doubtful_from: self.doubtful_from,
        };
        let searching = || if self.structural_only { search.sums() } else { search.run() };
        let ((mut maxima, ended_early), prepared) =
            rayon::join(searching, || self.prepared(&model, &groups));
        let assignment = together(self.request, self.budget, &model, &groups, &mut maxima)?;
        (self.request.progress)(Progress::Stage("replaying"));
        let witness = groups::witness(&model, &assignment);
        let replayed = replay_knowing(self.program, &self.prices.times(), knowledge, &witness);
        confirm(self.program, &model, &groups, &maxima, &assignment, &replayed)?;
        let upper = always + maxima.iter().map(|maximum| maximum.upper).sum::<Picos>();
        Ok(Searched {
            model,
            knowledge: knowledge.clone(),
            groups,
            maxima,
            assignment,
            witness,
            replayed,
            upper,
            ended_early,
            prepared,
        })
    }

    /// For a large model, prepares the explanations of the group with the most charges. `None` for other models, for a
    /// structural bound, and if the time is over.
    fn prepared(&self, model: &ScanModel, groups: &[Group]) -> Option<PreparedExplanation<'r>> {
        let is_large = model.circuit.nodes().len() > LARGE && !self.limits.reached();
        let by_size = |&group: &usize| groups[group].charges.len();
        let group =
            (0..groups.len()).max_by_key(by_size).filter(|_| is_large && !self.structural_only)?;
        Some(PreparedExplanation {
            group,
            exclusions: Exclusions::of(model, &groups[group], &self.limits),
        })
    }
}

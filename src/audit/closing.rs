//! Brings both bounds of a model closer: searches it, makes real runs of what it finds, and searches again with what
//! these taught.

use super::failure::Failure;
use super::model_search::{LARGE, ModelSearch, Searched};
use super::modelling::put_back;
use super::real::{self, Found, Scouted};
use super::request::{Progress, Request};
use crate::base::budget::Budget;
use crate::base::time::Picos;
use crate::program::meaning::Knowledge;
use crate::program::{Program, Witness};
use crate::scan::fit::SizeLimits;
use crate::scan::groups;
use crate::scan::model::{Assignment, Charge, Group, Lit, ScanModel};
use crate::scan::{Purpose, scan_model_knowing};
use crate::solve::{Limits, Method, maximum};
use crate::timing::price::Prices;
use std::collections::BTreeMap;

/// The most nodes and questions to words of a model with what was learned.
const MOST_LEARNED: usize = 4_000_000;
/// The most rounds of following summarised loops after all, since their counts were learned.
const MOST_ROUNDS: usize = 8;
/// The most loops of which the solver is asked how large their counts can be.
const MOST_ASKED: usize = 16;

/// What both bounds are searched with.
pub struct Closing<'a, 'r> {
    pub request: &'a Request<'r>,
    pub budget: &'a Budget<'a>,
    pub limits: Limits<'r>,
    pub doubtful_from: Option<Picos>,
    /// Whether the model is only the structural bound: the sum of all that can run.
    pub whole: bool,
}

/// The real runs beside a search.
pub enum Runs {
    /// All that are made.
    Made(Found),
    /// Those that need nothing from it.
    Scouted(Scouted),
    /// They are made beside.
    Beside,
}

impl<'r> Closing<'_, 'r> {
    /// The model's dearest scan, and what real runs found by then. Where these show how many iterations summarised loops make,
    /// the program has these loops again. Of a large one no runs are made where some are made `beside`.
    pub fn search(
        &self,
        program: &mut Program,
        prices: &mut Prices,
        (mut model, mut slices): (ScanModel, Vec<Group>),
        beside: bool,
    ) -> Result<(Searched<'r>, Runs), Failure> {
        let mut knowledge = Knowledge::new();
        let mut other = Witness::default();
        let mut rounds = 0;
        loop {
            (self.request.progress)(Progress::Stage("searching"));
            let search = ModelSearch {
                request: self.request,
                program,
                prices,
                budget: self.budget,
                doubtful_from: self.doubtful_from,
                whole: self.whole,
                limits: self.limits,
            };
            let least = prices.least_times();
            let reals = real::Search { program, least: &least, limits: self.limits };
            // To search a large one again takes several times as long as the first time, and what single scans teach
            // hardly ever lowers its bound.
            let small = model.circuit.nodes().len() <= LARGE;
            if !small && !self.whole && beside {
                return Ok((search.run(model, slices, &knowledge)?, Runs::Beside));
            }
            if !small && !self.whole {
                // Each takes about as long, and much of it on one core only.
                let (searched, scouted) =
                    rayon::join(|| search.run(model, slices, &knowledge), || reals.scout());
                let scouted = scouted.map_err(Failure::Internal)?;
                return Ok((searched?, Runs::Scouted(scouted)));
            }
            let searched = search.run(model, slices, &knowledge)?;
            (self.request.progress)(Progress::Stage("running it"));
            let starts = [&searched.witness, &other];
            let found = reals.run(starts, searched.upper, knowledge).map_err(Failure::Internal)?;
            let open = found.best.replay.total < searched.upper && !self.whole;
            if !small || !open || found.knowledge.is_empty() {
                return Ok((searched, Runs::Made(found)));
            }
            let limits = SizeLimits {
                per_execution: usize::MAX,
                in_all: MOST_LEARNED,
                is_over: &|| self.budget.reached(),
            };
            let times = prices.times();
            let learned = &found.knowledge;
            let known = scan_model_knowing(program, &times, learned, Purpose::UpperBound, &limits);
            let Ok(known) = known else { return Ok((searched, Runs::Made(found))) };
            if rounds < MOST_ROUNDS
                && let Some(closer) =
                    put_back(program, prices, learned, &self.iterations(&known), &limits)
            {
                (*program, *prices, model) = closer;
                slices = groups::groups(&model);
                (knowledge, other) = (found.knowledge, found.witness);
                rounds += 1;
                continue;
            }
            // What was learned of operations makes the bound closer, too.
            let slices = groups::groups(&known);
            let closer = search.run(known, slices, &found.knowledge)?;
            let searched = if closer.upper < searched.upper { closer } else { searched };
            if found.best.is_possible() && found.best.replay.total > searched.upper {
                let (took, upper) = (found.best.replay.total, searched.upper);
                let told = format!("a scan takes {took}, the bound is {upper}");
                return Err(Failure::Internal(told));
            }
            return Ok((searched, Runs::Made(found)));
        }
    }

    /// The longest real run, after the search of the model.
    pub fn longest(
        &self,
        program: &Program,
        prices: &Prices,
        (dearest, upper): (&Witness, Picos),
        runs: Runs,
    ) -> Result<Found, Failure> {
        let least = prices.least_times();
        let reals = real::Search { program, least: &least, limits: self.limits };
        let scouted = match runs {
            Runs::Made(found) => return Ok(found),
            Runs::Scouted(scouted) => scouted,
            Runs::Beside => reals.scout().map_err(Failure::Internal)?,
        };
        reals.run_scouted(dearest, upper, scouted).map_err(Failure::Internal)
    }

    /// How many iterations summarised loops make at most: as the model noted from the form of their counts, or as a
    /// solver finds where that is less.
    fn iterations(&self, model: &ScanModel) -> BTreeMap<usize, u32> {
        let mut iterations = model.iterations.clone();
        let mut asked: BTreeMap<usize, u32> = BTreeMap::new();
        if model.counts.len() <= MOST_ASKED {
            for count in &model.counts {
                let most = self.most(model, count.reached, &count.bits).max(count.least);
                let known = asked.entry(count.instruction).or_default();
                *known = most.max(*known);
            }
        }
        for (instruction, most) in asked {
            iterations.entry(instruction).and_modify(|known| *known = most.min(*known));
        }
        iterations
    }

    /// The most that a number of these bits can be where control gets there, if it is not negative.
    fn most(&self, model: &ScanModel, reached: Lit, bits: &[Lit; 16]) -> u32 {
        let mut bare = ScanModel { charges: Vec::new(), ..model.clone() };
        let there = bare.circuit.and(reached, !bits[15]);
        for (place, &bit) in bits.iter().enumerate().take(15) {
            let fires = bare.circuit.and(there, bit);
            bare.charges.push(Charge {
                instruction: 0,
                frames: Vec::new(),
                reached: fires,
                fires,
                on: Picos(1 << place),
                off: Picos::ZERO,
                counted: None,
            });
        }
        let constant: Vec<usize> =
            (0..15).filter(|&charge| bare.charges[charge].is_constant()).collect();
        let zeros = Assignment(vec![0; bare.variables.len()]);
        let always = bare.cost(&constant, &zeros);
        let found = groups::groups(&bare)
            .iter()
            .map(|group| maximum(&bare, group, Method::Cores, &self.limits).upper)
            .sum::<Picos>();
        u32::try_from((always + found).0).unwrap_or(u32::MAX)
    }
}

//! One part of the program, with a solver of its own.

use super::Search;
use super::ledger::Ledger;
use crate::solve::formula::Formula;
use crate::solve::oracle::Oracle;
use crate::solve::trace::Trace;
use std::cmp::Reverse;
use std::ops::Range;

/// Steps beyond the assumptions that may be spent on finding out whether a core does without a wish.
const CORE_EFFORT: u64 = 30;

/// Steps that may be spent on finding out whether a second wish of a core must fail.
const COUNT_EFFORT: u64 = 10;

/// A part of the program as it leaves the search for a time.
pub struct Part {
    /// The variables of the circuit that it has.
    pub homes: Range<usize>,
    /// Its wishes and its clauses.
    pub ledger: Ledger,
    /// Of its variables: the values in the last scan found for it; empty as long as there is none.
    pub values: Vec<bool>,
    /// Its clauses exclude each other.
    pub contradiction: bool,
    /// The cores that were found, if anyone wants to know.
    pub trace: Trace,
}

impl Part {
    /// A part in which nothing is found yet.
    pub fn new(homes: Range<usize>, ledger: Ledger) -> Part {
        let (values, trace) = (Vec::new(), Trace::default());
        Part { homes, ledger, values, contradiction: false, trace }
    }

    /// Pays for cores until all wishes can hold together. If it is the `whole` program, every model is a scan.
    ///
    /// It goes down in weight step by step, in every round: asked for all wishes of a project of 64 stations at
    /// once, the solver was lost for minutes.
    pub fn solve(&mut self, search: &Search<'_, '_>, whole: bool) {
        let mut asker = Asker { oracle: Oracle::new(search.limits), told: 0 };
        let mut least = self.ledger.wishes(1).next().map_or(1, |(_, weight)| weight);
        // Cores that are paid, and what was paid for each. Their new wishes wait until all that are wished for now
        // can hold together.
        let mut paid: Vec<(Vec<i32>, u64)> = Vec::new();
        loop {
            search.bounds().count();
            let wanted: Vec<i32> = self.ledger.wishes(least).map(|(wish, _)| wish).collect();
            match asker.ask(&self.ledger.formula, &wanted, u64::MAX) {
                None => return,
                Some(false) => {
                    let core = asker.oracle.core();
                    self.contradiction = core.is_empty();
                    if self.contradiction {
                        return;
                    }
                    let core = self.minimised(core, &mut asker);
                    let weight = self.ledger.pay(&core);
                    if search.limits.trace {
                        self.trace.push(search.core(&core, weight));
                    }
                    paid.push((core, weight));
                }
                Some(true) => {
                    if whole {
                        search.found(&mut self.ledger, |literal| asker.oracle.holds(literal));
                    }
                    if paid.is_empty() {
                        let Some(next) = self.ledger.lighter(least) else { break };
                        least = next;
                    }
                    for (core, weight) in paid.drain(..) {
                        self.ledger.relax(&core, weight, |formula, literal| {
                            asker.ask(formula, &[literal], COUNT_EFFORT) == Some(false)
                        });
                    }
                }
            }
            search.bounds().lost(self.ledger.take_lost());
            if search.limits.reached() || (whole && search.bounds().exact()) {
                return;
            }
        }
        // The circuit's variables are their own homes.
        let variables = self.homes.clone().filter_map(|home| i32::try_from(home).ok());
        self.values = variables.map(|variable| asker.oracle.holds(variable)).collect();
    }

    /// As few of a core's wishes as a small effort shows to exclude each other. Cores of two are taken as they are:
    /// wishes that cannot hold even alone are rare.
    fn minimised(&self, mut core: Vec<i32>, asker: &mut Asker<'_>) -> Vec<i32> {
        if core.len() <= 2 {
            return core;
        }
        // The lightest are tried first: without them the core costs more.
        core.sort_by_key(|&l| (Reverse(self.ledger.weight(l)), l.unsigned_abs(), l));
        let mut at = core.len();
        while at > 0 && core.len() > 1 {
            at -= 1;
            let mut rest = core.clone();
            rest.remove(at);
            let steps = rest.len() as u64 + CORE_EFFORT;
            if asker.ask(&self.ledger.formula, &rest, steps) == Some(false) {
                let smaller = asker.oracle.core();
                core.retain(|literal| smaller.contains(literal));
                at = at.min(core.len());
            }
        }
        core
    }
}

/// A solver that is told of a growing formula before each question.
struct Asker<'a> {
    oracle: Oracle<'a>,
    /// How many of the formula's clauses it knows.
    told: usize,
}

impl Asker<'_> {
    /// Whether the clauses and assumptions can hold together; `None` if that was not found out in so many steps.
    fn ask(&mut self, formula: &Formula, assumptions: &[i32], steps: u64) -> Option<bool> {
        formula.teach(self.told, &mut self.oracle);
        self.told = formula.len();
        self.oracle.ask(assumptions, steps)
    }
}

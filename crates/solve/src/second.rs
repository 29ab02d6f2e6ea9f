//! A second opinion on a group's maximum: Z3 checks, from the model itself, whether a scan may cost one picosecond more
//! than the upper bound, and whether the best scan is possible.
//!
//! It shares only the model with the search: no normal form, no clauses, no solver. Words are bit-vectors, and the cost
//! is a sum of integers.

use super::{Limits, Maximum, Opinion};
use scanbound_base::time::Picos;
use scanbound_model::{Assignment, Atom, Group, Lit, Node, ScanModel, VarKind};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};
use z3::ast::{BV, Bool, Int};
use z3::{Config, Model, Optimize, Params, SatResult, Solver, with_z3_config};

/// The largest number of charges of a group for which Z3 is asked.
const CHARGES: usize = 400;
/// The largest number of circuit nodes of a group for which Z3 is asked.
const NODES: usize = 20_000;

/// The effort limit (Z3's `rlimit`) of the query.
const EFFORT: u32 = 8_000_000;
/// The effort limit of Z3's own optimisation, which is used if the query is not answered.
const MAXIMUM_EFFORT: u32 = 20_000_000;

/// Checks a group's maximum with Z3: that `best` is possible and costs the lower bound, and that no scan costs more
/// than the upper bound.
///
/// # Errors
/// If Z3 contradicts the maximum, or does not confirm that `best` is possible; the text says how.
pub fn second_opinion(
    model: &ScanModel,
    group: &Group,
    maximum: &Maximum,
    limits: &Limits<'_>,
) -> Result<Opinion, String> {
    if group.charges.len() > CHARGES {
        return Ok(Opinion::TooLarge);
    }
    let needed = cone(model, group);
    if needed.len() > NODES {
        return Ok(Opinion::TooLarge);
    }
    if limits.reached() {
        return Ok(Opinion::RanOut);
    }
    with_z3_config(&Config::new(), || {
        let asked = Z3Problem::new(model, group, &needed);
        asked.attained(maximum)?;
        asked.no_more(maximum, limits)
    })
}

/// The circuit nodes on which the group's charges and constraints depend, ascending, so that inputs come first.
fn cone(model: &ScanModel, group: &Group) -> Vec<usize> {
    let nodes = model.circuit.nodes();
    let charges = group.charges.iter().map(|&charge| &model.charges[charge]);
    let guards = charges.flat_map(|charge| charge.literals());
    let constraints = group.constraints.iter().map(|&constraint| model.constraints[constraint]);
    let mut open: Vec<usize> = guards.chain(constraints).map(Lit::node).collect();
    let mut needed = std::collections::BTreeSet::new();
    while let Some(node) = open.pop() {
        if needed.insert(node)
            && let Node::And(a, b) = nodes[node]
        {
            open.extend([a.node(), b.node()]);
        }
    }
    needed.into_iter().collect()
}

/// A group as a Z3 problem, in a Z3 expression for each variable and each needed circuit node.
struct Z3Problem<'a> {
    model: &'a ScanModel,
    group: &'a Group,
    bits: BTreeMap<usize, Bool>,
    words: BTreeMap<usize, BV>,
    nodes: BTreeMap<usize, Bool>,
}

impl<'a> Z3Problem<'a> {
    fn new(model: &'a ScanModel, group: &'a Group, needed: &[usize]) -> Z3Problem<'a> {
        let (bits, words, nodes) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        let mut question = Z3Problem { model, group, bits, words, nodes };
        for &index in needed {
            let meaning = match model.circuit.nodes()[index] {
                Node::True => Bool::from_bool(true),
                Node::Atom(atom) => question.atom(atom),
                Node::And(a, b) => Bool::and(&[question.literal(a), question.literal(b)]),
            };
            question.nodes.insert(index, meaning);
        }
        question
    }

    fn atom(&mut self, atom: Atom) -> Bool {
        let variable = atom.variable().0;
        let place = variable as usize;
        let word = || BV::new_const(format!("w{variable}"), 16);
        match atom {
            Atom::Bit(_) => {
                let bit = || Bool::new_const(format!("b{variable}"));
                self.bits.entry(place).or_insert_with(bit).clone()
            }
            Atom::AtLeast(_, least) => {
                let word = self.words.entry(place).or_insert_with(word);
                word.bvuge(BV::from_u64(u64::from(least), 16))
            }
            Atom::WordBit(_, bit) => {
                let word = self.words.entry(place).or_insert_with(word);
                word.extract(u32::from(bit), u32::from(bit)).eq(BV::from_u64(1, 1))
            }
        }
    }

    fn literal(&self, lit: Lit) -> Bool {
        let node = &self.nodes[&lit.node()];
        if lit.is_negated() { node.not() } else { node.clone() }
    }

    fn constraints(&self) -> impl Iterator<Item = Bool> {
        let constraints = self.group.constraints.iter();
        constraints.map(|&constraint| self.literal(self.model.constraints[constraint]))
    }

    /// The total time of the group's charges in picoseconds, as an expression.
    fn total(&self) -> Int {
        let costs = self.group.charges.iter().map(|&charge| {
            let charge = &self.model.charges[charge];
            let (on, units) = charge.cost_if_fired();
            let nothing = Int::from_u64(0);
            let idle = self.literal(charge.reached).ite(&Int::from_u64(charge.off.0), &nothing);
            let units = units.iter().map(|(handled, more)| {
                self.literal(*handled).ite(&Int::from_u64(more.0), &nothing)
            });
            let base = self.literal(charge.fires).ite(&Int::from_u64(on.0), &idle);
            Int::add(&units.chain([base]).collect::<Vec<Int>>())
        });
        Int::add(&costs.collect::<Vec<Int>>())
    }

    fn scan(&self, found: &Model) -> Assignment {
        let mut scan = Assignment(vec![0; self.model.variables.len()]);
        for (&place, bit) in &self.bits {
            let value = found.eval(bit, true).and_then(|value| value.as_bool());
            scan.0[place] = u16::from(value == Some(true));
        }
        for (&place, word) in &self.words {
            let value = found.eval(word, true).and_then(|value| value.as_u64());
            scan.0[place] = value.and_then(|value| u16::try_from(value).ok()).unwrap_or(0);
        }
        scan
    }

    /// Checks that the best scan satisfies the constraints and costs the lower bound.
    fn attained(&self, maximum: &Maximum) -> Result<(), String> {
        let solver = Solver::new();
        self.constraints().for_each(|constraint| solver.assert(constraint));
        let best = maximum.best.complete(self.model).0;
        for (&place, bit) in &self.bits {
            debug_assert_eq!(self.model.variables[place].kind, VarKind::Bit);
            solver.assert(if best[place] != 0 { bit.clone() } else { bit.not() });
        }
        for (&place, word) in &self.words {
            solver.assert(word.eq(BV::from_u64(u64::from(best[place]), 16)));
        }
        solver.assert(self.total().eq(Int::from_u64(maximum.lower.0)));
        match solver.check() {
            SatResult::Sat => Ok(()),
            answer => Err(format!(
                "the best scan found does not take {} according to Z3, which answers {answer:?}",
                maximum.lower
            )),
        }
    }

    /// Checks that no scan costs a picosecond more than the upper bound; if that takes too long, lets Z3 maximise the
    /// cost itself.
    fn no_more(&self, maximum: &Maximum, limits: &Limits<'_>) -> Result<Opinion, String> {
        let solver = Solver::new();
        self.constraints().for_each(|constraint| solver.assert(constraint));
        solver.assert(self.total().gt(Int::from_u64(maximum.upper.0)));
        solver.set_params(&spend(EFFORT, limits));
        match solver.check() {
            SatResult::Unsat => return Ok(Opinion::Confirmed),
            SatResult::Sat => {
                let found = solver.get_model();
                let cost = found.map_or(Picos::ZERO, |found| self.cost(&self.scan(&found)));
                return Err(above(maximum, cost));
            }
            SatResult::Unknown if limits.reached() => return Ok(Opinion::RanOut),
            SatResult::Unknown => {}
        }
        // The same question as an optimisation problem.
        let optimum = Optimize::new();
        self.constraints().for_each(|constraint| optimum.assert(&constraint));
        for &charge in &self.group.charges {
            let charge = &self.model.charges[charge];
            let (reached, fires) = (self.literal(charge.reached), self.literal(charge.fires));
            let idle = Bool::and(&[reached, fires.not()]);
            let (on, units) = charge.cost_if_fired();
            let units = units.iter().map(|(handled, more)| (self.literal(*handled), *more));
            for (holds, cost) in units.chain([(fires, on), (idle, charge.off)]) {
                if cost > Picos::ZERO {
                    optimum.assert_soft(&holds, cost.0, None);
                }
            }
        }
        optimum.set_params(&spend(MAXIMUM_EFFORT, limits));
        if optimum.check(&[]) != SatResult::Sat {
            return Ok(Opinion::RanOut);
        }
        let Some(found) = optimum.get_model() else { return Ok(Opinion::RanOut) };
        let most = self.cost(&self.scan(&found));
        match most {
            most if most > maximum.upper => Err(above(maximum, most)),
            most if most < maximum.lower => Ok(Opinion::RanOut),
            _ => Ok(Opinion::Confirmed),
        }
    }

    fn cost(&self, scan: &Assignment) -> Picos {
        self.model.cost(&self.group.charges, scan)
    }
}

fn above(maximum: &Maximum, cost: Picos) -> String {
    format!(
        "Z3 finds a scan in which the group costs {cost}, but the upper bound is {}",
        maximum.upper
    )
}

/// The effort limit, and the time up to the deadline, as Z3 parameters.
fn spend(effort: u32, limits: &Limits<'_>) -> Params {
    let mut params = Params::new();
    params.set_u32("rlimit", effort);
    if let Some(deadline) = limits.deadline {
        let rest: Duration = deadline.saturating_duration_since(Instant::now());
        params.set_u32("timeout", u32::try_from(rest.as_millis()).unwrap_or(u32::MAX).max(1));
    }
    params
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Builder, random};
    use super::super::{Method, maximum};
    use super::*;

    #[test]
    fn a_right_maximum_is_confirmed_and_a_wrong_one_is_not() {
        for seed in 0..25 {
            let model = random(3000 + seed, 3 + seed % 12);
            let group = Builder { model: model.clone() }.group();
            let limits = Limits::default();
            let found = maximum(&model, &group, Method::Cores, &limits);
            let asked = |found: &Maximum| second_opinion(&model, &group, found, &limits);
            assert_eq!(asked(&found), Ok(Opinion::Confirmed), "seed {seed}");
            // Wrong results: a bound that is a picosecond too low, and a scan that costs a picosecond less than stated.
            if found.upper > Picos::ZERO {
                let low = Picos(found.upper.0 - 1);
                let why = asked(&Maximum { upper: low, ..found.clone() }).expect_err("too low");
                assert!(why.contains("Z3 finds a scan in which the group costs"), "{why}");
            }
            let lower = found.lower + Picos(1);
            let why = asked(&Maximum { lower, ..found.clone() }).expect_err("too high");
            assert!(why.contains("the best scan found does not take"), "{why}");
        }
    }

    #[test]
    fn what_is_too_large_is_not_asked() {
        let model = random(1, 2 * CHARGES as u64);
        let group = Builder { model: model.clone() }.group();
        assert!(group.charges.len() > CHARGES);
        let found = maximum(&model, &group, Method::Cores, &Limits::default());
        let asked = second_opinion(&model, &group, &found, &Limits::default());
        assert_eq!(asked, Ok(Opinion::TooLarge));
        let over = Limits { cancelled: &|| true, ..Limits::default() };
        let small = Group { charges: group.charges[..3].to_vec(), ..group };
        assert_eq!(second_opinion(&model, &small, &found, &over), Ok(Opinion::RanOut));
    }
}

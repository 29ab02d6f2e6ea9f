//! Sequential function charts: steps, transitions, actions, and what follows from how they hang together.

pub mod apart;
pub mod coactive;
pub mod draft;
pub mod expansion;
pub mod explicit;
pub mod names;
pub mod plain;
pub mod structure;
pub mod text;
pub mod told;

use crate::ast::{Expr, Operator, same};
pub use crate::body::{Block, Chart, Macro, Qualifier, Step, Target, Transition};
use crate::show;
use scanbound_nets::Net;
use std::collections::BTreeSet;

/// The action that executes the blocks of drawn conditions, as Beremiz and OpenPLC name it: the first step stores it.
pub const COMPUTED: &str = "COMPUTE_FUNCTION_BLOCKS";

/// What comes in at one input of an action's control.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Feed {
    /// The qualifier.
    pub qualifier: Qualifier,
    /// Its time.
    pub time: Option<Expr>,
    /// The steps of which one has to be active.
    pub steps: Vec<usize>,
}

impl Chart {
    /// The step of this name.
    #[must_use]
    pub fn step(&self, name: &str) -> Option<usize> {
        self.steps.iter().position(|step| same(&step.name, name))
    }

    /// The steps of which one has to be active for the flag of this name to be true: the step of this name, or those
    /// that stand in the place of a macro step.
    #[must_use]
    pub fn flagged(&self, name: &str) -> Option<Vec<usize>> {
        let own = self.macros.iter().find(|one| same(&one.name, name));
        self.step(name).map(|step| vec![step]).or_else(|| own.map(|one| one.steps.clone()))
    }

    /// The steps that are active at first.
    #[must_use]
    pub fn initial(&self) -> Vec<usize> {
        (0..self.steps.len()).filter(|&step| self.steps[step].initial).collect()
    }

    /// Whether transitions compete for a step of which one has no priority.
    #[must_use]
    pub fn competes(&self) -> bool {
        let mut pairs =
            (0..self.transitions.len()).flat_map(|at| (0..at).map(move |other| (at, other)));
        pairs.any(|(at, other)| self.compete(at, other))
    }

    /// Whether two transitions compete for a step, and one of them has no priority.
    #[must_use]
    pub fn compete(&self, one: usize, other: usize) -> bool {
        let (one, other) = (&self.transitions[one], &self.transitions[other]);
        !(one.has_priority && other.has_priority)
            && one.from.iter().any(|step| other.from.contains(step))
    }

    /// Its Petri net where all of competing transitions clear that are true, but for those that all have priorities.
    /// `never_both`: whether the conditions of two transitions are never true together.
    #[must_use]
    pub fn net_of_all(&self, never_both: &dyn Fn(usize, usize) -> bool) -> Net {
        let mut net = self.net_of_any();
        let mut of_step = vec![Vec::new(); self.steps.len()];
        for (at, one) in self.transitions.iter().enumerate() {
            one.from.iter().for_each(|&step| of_step[step].push(at));
        }
        for (at, one) in net.transitions.iter_mut().enumerate() {
            let mut rivals = self.transitions[at].from.iter().flat_map(|&step| &of_step[step]);
            one.shares = !self.transitions[at].has_priority
                && rivals.any(|&other| other != at && !never_both(at, other));
        }
        net
    }

    /// Its Petri net on any controller: some end a step at once when a transition with a priority clears (matiec).
    /// Conditions behind it see the step as off, but for those of transitions that would need one of its steps, too.
    #[must_use]
    pub fn net_of_any(&self) -> Net {
        let mut net = self.net();
        let early: Vec<&Transition> =
            self.transitions.iter().filter(|one| one.has_priority).collect();
        for (one, own) in net.transitions.iter_mut().zip(&self.transitions) {
            let beside = |two: &&&Transition| !two.from.iter().any(|step| own.from.contains(step));
            one.inhibitors
                .retain(|step| !early.iter().filter(beside).any(|two| two.from.contains(step)));
        }
        net
    }

    /// Its Petri net: a place a step. What a condition asks of step flags in any case, its transition asks of the net.
    #[must_use]
    pub fn net(&self) -> Net {
        let transitions = self.transitions.iter().map(|transition| {
            let mut one = scanbound_nets::Transition {
                inputs: transition.from.clone(),
                outputs: transition.to.clone(),
                ..scanbound_nets::Transition::default()
            };
            self.flags(&transition.condition, &mut one);
            one
        });
        Net {
            places: self.steps.len(),
            initial: self.initial(),
            transitions: transitions.collect(),
        }
    }

    /// The step flags that a condition has among the parts that it joins by AND.
    fn flags(&self, condition: &Expr, one: &mut scanbound_nets::Transition) {
        let flag = |expr: &Expr| {
            let Expr::Variable(path) = expr else { return None };
            let (step, part) = path.split_last()?;
            same(part, "X").then(|| self.flagged(&show::path(&step))).flatten()
        };
        match condition {
            Expr::Binary(Operator::And | Operator::AndThen, left, right) => {
                self.flags(left, one);
                self.flags(right, one);
            }
            Expr::Not(inner) => one.inhibitors.extend(flag(inner).unwrap_or_default()),
            // One of several steps is nothing that the net can ask.
            other => {
                one.tested.extend(flag(other).filter(|steps| steps.len() == 1).unwrap_or_default())
            }
        }
    }

    /// The names of the actions that its blocks control, in the order in which they first occur.
    #[must_use]
    pub fn actions(&self) -> Vec<String> {
        let blocks = self.steps.iter().flat_map(|step| &step.blocks);
        let mut known = BTreeSet::new();
        blocks
            .map(|block| block.target.name())
            .filter(|name| known.insert(name.to_ascii_lowercase()))
            .collect()
    }

    /// The blocks of an action, each with its step.
    pub fn blocks_of<'a>(&'a self, action: &'a str) -> impl Iterator<Item = (usize, &'a Block)> {
        let all = self.steps.iter().enumerate();
        all.flat_map(|(at, step)| step.blocks.iter().map(move |block| (at, block)))
            .filter(move |(_, block)| block.target.is_named(action))
    }

    /// What feeds the control of an action: the steps of blocks with the same qualifier and the same time come in
    /// together, as the standard's block has one input for each qualifier.
    #[must_use]
    pub fn inputs_of(&self, action: &str) -> Vec<Feed> {
        let mut found: Vec<Feed> = Vec::new();
        for (step, block) in self.blocks_of(action) {
            let alike =
                |one: &&mut Feed| one.qualifier == block.qualifier && one.time == block.time;
            match found.iter_mut().find(alike) {
                Some(own) => own.steps.push(step),
                None => found.push(Feed {
                    qualifier: block.qualifier,
                    time: block.time.clone(),
                    steps: vec![step],
                }),
            }
        }
        found
    }

    /// What a transition is called: its name, or from where to where it leads.
    #[must_use]
    pub fn transition_name(&self, transition: usize) -> String {
        let Transition { name, from, to, .. } = &self.transitions[transition];
        let names = |steps: &[usize]| {
            steps.iter().map(|&step| self.steps[step].name.as_str()).collect::<Vec<_>>().join(", ")
        };
        match name {
            Some(name) => name.clone(),
            None => format!("{} -> {}", names(from), names(to)),
        }
    }
}

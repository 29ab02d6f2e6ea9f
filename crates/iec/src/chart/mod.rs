//! Sequential function charts: steps, transitions and actions, and analyses of their structure.

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

/// The action that executes the blocks in drawn conditions, as Beremiz and OpenPLC name it. The initial step stores it.
pub const COMPUTED: &str = "COMPUTE_FUNCTION_BLOCKS";

/// The flags by which CODESYS controls a chart. The first two are followed.
pub const CONTROL_FLAGS: [&str; 6] =
    ["SFCInit", "SFCReset", "SFCTip", "SFCTipMode", "SFCPause", "SFCQuitError"];

/// The Boolean flags by which CODESYS tells the state of a chart.
pub const STATE_FLAGS: [&str; 2] = ["SFCError", "SFCTrans"];

/// One input of an action's control block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Feed {
    /// The qualifier of the input.
    pub qualifier: Qualifier,
    /// The time of the input, if it has one.
    pub time: Option<Expr>,
    /// The steps that feed it: the input is true while any of them is active.
    pub steps: Vec<usize>,
}

impl Chart {
    /// The index of the step of this name, ignoring case.
    #[must_use]
    pub fn step(&self, name: &str) -> Option<usize> {
        self.steps.iter().position(|step| same(&step.name, name))
    }

    /// The steps for which the flag `name.X` is true while any of them is active: the step itself, or all steps of a
    /// macro step. `None` if there is neither.
    #[must_use]
    pub fn flagged(&self, name: &str) -> Option<Vec<usize>> {
        let own = self.macros.iter().find(|one| same(&one.name, name));
        self.step(name).map(|step| vec![step]).or_else(|| own.map(|one| one.steps.clone()))
    }

    /// The initial steps.
    #[must_use]
    pub fn initial(&self) -> Vec<usize> {
        (0..self.steps.len()).filter(|&step| self.steps[step].initial).collect()
    }

    /// Whether any two transitions compete ([`Chart::compete`]).
    #[must_use]
    pub fn competes(&self) -> bool {
        let mut pairs =
            (0..self.transitions.len()).flat_map(|at| (0..at).map(move |other| (at, other)));
        pairs.any(|(at, other)| self.compete(at, other))
    }

    /// Whether two transitions share a preceding step and not both of them have a priority.
    #[must_use]
    pub fn compete(&self, one: usize, other: usize) -> bool {
        let (one, other) = (&self.transitions[one], &self.transitions[other]);
        !(one.has_priority() && other.has_priority())
            && one.from.iter().any(|step| other.from.contains(step))
    }

    /// Its Petri net on a controller where competing transitions that are true all fire, except where all of them have
    /// priorities. `never_both` tells whether the conditions of two transitions are never true together.
    #[must_use]
    pub fn net_of_all(&self, never_both: &dyn Fn(usize, usize) -> bool) -> Net {
        let mut net = self.net_of_any();
        let mut of_step = vec![Vec::new(); self.steps.len()];
        for (at, one) in self.transitions.iter().enumerate() {
            one.from.iter().for_each(|&step| of_step[step].push(at));
        }
        for (at, one) in net.transitions.iter_mut().enumerate() {
            let mut rivals = self.transitions[at].from.iter().flat_map(|&step| &of_step[step]);
            one.shares = !self.transitions[at].has_priority()
                && rivals.any(|&other| other != at && !never_both(at, other));
        }
        net
    }

    /// Its Petri net, valid on every controller. Some (matiec) clear a step's flag at once when a transition with a
    /// priority fires, so later conditions see the step as inactive. Inhibitors that this would invalidate are left
    /// out.
    #[must_use]
    pub fn net_of_any(&self) -> Net {
        let mut net = self.net();
        let early: Vec<&Transition> =
            self.transitions.iter().filter(|one| one.has_priority()).collect();
        for (one, own) in net.transitions.iter_mut().zip(&self.transitions) {
            let beside = |two: &&&Transition| !two.from.iter().any(|step| own.from.contains(step));
            one.inhibitors
                .retain(|step| !early.iter().filter(beside).any(|two| two.from.contains(step)));
        }
        net
    }

    /// Its Petri net, with a place for each step. Step flags that a condition requires become tests and inhibitors of
    /// its transition.
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

    /// Adds the step flags that a condition requires, as operands joined by AND, to a transition of the net.
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
            // The net cannot test whether any of several steps is active.
            other => {
                one.tested.extend(flag(other).filter(|steps| steps.len() == 1).unwrap_or_default())
            }
        }
    }

    /// The names of all actions in action blocks, in the order of their first occurrence.
    #[must_use]
    pub fn actions(&self) -> Vec<String> {
        let blocks = self.steps.iter().flat_map(|step| &step.blocks);
        let mut known = BTreeSet::new();
        blocks
            .map(|block| block.target.name())
            .filter(|name| known.insert(name.to_ascii_lowercase()))
            .collect()
    }

    /// The action blocks of an action, with the index of their step.
    pub fn blocks_of<'a>(&'a self, action: &'a str) -> impl Iterator<Item = (usize, &'a Block)> {
        let all = self.steps.iter().enumerate();
        all.flat_map(|(at, step)| step.blocks.iter().map(move |block| (at, block)))
            .filter(move |(_, block)| block.target.is_named(action))
    }

    /// The inputs of an action's control block. Action blocks with the same qualifier and time share one input.
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

    /// The name of a transition for messages: its own, or `from -> to`.
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

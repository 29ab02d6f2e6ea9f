//! Sequential function charts: steps, transitions, actions, and what follows from how they hang together.

pub mod apart;
pub mod coactive;
pub mod control;
pub mod draft;
pub mod evaluate;
pub mod expansion;
pub mod explicit;
pub mod names;
pub mod plain;
pub mod run;
pub mod structure;
pub mod text;
pub mod told;

use super::ast::{Expr, Literal, Operator, Path};
use super::{Body, Pou, same, show};
use scanbound_nets::Net;
use std::collections::BTreeSet;

/// When a step's action runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Qualifier {
    /// Not stored: while the step is active.
    N,
    /// Resets what was stored.
    R,
    /// Stored: until it is reset.
    S,
    /// Limited: while the step is active, at most for the time.
    L,
    /// Delayed: while the step is active, from the time on.
    D,
    /// Pulse: once when the step becomes active.
    P,
    /// Once when the step ends.
    P0,
    /// Once when the step becomes active, with nothing after it.
    P1,
    /// Stored and delayed: from the time on, whether or not the step is still active, until it is reset.
    Sd,
    /// Delayed and stored: from the time on, if the step is still active then, until it is reset.
    Ds,
    /// Stored and limited: at most for the time, whether or not the step is still active, or until it is reset.
    Sl,
}

impl Qualifier {
    /// All.
    pub const ALL: [Qualifier; 11] = [
        Qualifier::N,
        Qualifier::R,
        Qualifier::S,
        Qualifier::L,
        Qualifier::D,
        Qualifier::P,
        Qualifier::P0,
        Qualifier::P1,
        Qualifier::Sd,
        Qualifier::Ds,
        Qualifier::Sl,
    ];

    /// As charts write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["N", "R", "S", "L", "D", "P", "P0", "P1", "SD", "DS", "SL"][self as usize]
    }

    /// The qualifier of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Qualifier> {
        Qualifier::ALL.into_iter().find(|one| same(one.name(), name))
    }

    /// Whether it has a time.
    #[must_use]
    pub fn is_timed(self) -> bool {
        matches!(self, Qualifier::L | Qualifier::D | Qualifier::Sd | Qualifier::Ds | Qualifier::Sl)
    }

    /// Whether the action may go on when the step has ended.
    #[must_use]
    pub fn is_stored(self) -> bool {
        matches!(self, Qualifier::S | Qualifier::Sd | Qualifier::Ds | Qualifier::Sl)
    }
}

/// What an action block controls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// An action of the unit, of an instance in it, or a Boolean variable.
    Path(Path),
    /// What stands in the block itself, and its name: that of its step and its number there.
    Inline(String, Box<Body>),
}

impl Target {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Target::Path(path) => show::path(path),
            Target::Inline(name, _) => name.clone(),
        }
    }

    /// Whether this is its name.
    #[must_use]
    pub fn is_named(&self, name: &str) -> bool {
        match self {
            Target::Path(path) => match path.as_name() {
                Some(own) => same(own, name),
                None => same(&show::path(path), name),
            },
            Target::Inline(own, _) => same(own, name),
        }
    }
}

/// An action block of a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// When the action runs.
    pub qualifier: Qualifier,
    /// Its time.
    pub time: Option<Expr>,
    /// The action.
    pub target: Target,
    /// Its line.
    pub line: u32,
}

impl Block {
    /// Its time in nanoseconds, where it is a constant.
    #[must_use]
    pub fn constant_time(&self) -> Option<i64> {
        match &self.time {
            Some(Expr::Literal(Literal::Time(time))) => Some(*time),
            _ => None,
        }
    }
}

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

/// A step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// Its name.
    pub name: String,
    /// Whether it is active at first.
    pub initial: bool,
    /// Its action blocks.
    pub blocks: Vec<Block>,
    /// Runs once when the step becomes active, before anything else of it (CODESYS).
    pub entry: Option<Path>,
    /// Runs while the step is active, without a last run after it (CODESYS).
    pub active: Option<Path>,
    /// Runs once when the step has ended (CODESYS).
    pub exit: Option<Path>,
    /// Whether it is drawn as a macro step, but without a chart of its own.
    pub is_macro: bool,
    /// Its line.
    pub line: u32,
    /// Its number in the source, where that has one.
    pub id: Option<String>,
}

impl Step {
    /// A step without actions.
    #[must_use]
    pub fn new(name: impl Into<String>, initial: bool, line: u32) -> Step {
        Step {
            name: name.into(),
            initial,
            blocks: Vec::new(),
            entry: None,
            active: None,
            exit: None,
            is_macro: false,
            line,
            id: None,
        }
    }
}

/// A transition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transition {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The steps in front of it.
    pub from: Vec<usize>,
    /// The steps behind it.
    pub to: Vec<usize>,
    /// Its condition.
    pub condition: Expr,
    /// Whether it has a priority of its own.
    pub has_priority: bool,
    /// Its line.
    pub line: u32,
    /// Its number in the source, where that has one.
    pub id: Option<String>,
}

/// A macro step. Its chart stands in its place: the steps in it are named `MACRO.STEP`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Macro {
    /// Its name, behind those of the macro steps that it stands in.
    pub name: String,
    /// The steps that stand in its place, also those of macro steps in it.
    pub steps: Vec<usize>,
    /// The line where it is drawn.
    pub line: u32,
}

/// The action that executes the blocks of drawn conditions, as Beremiz and OpenPLC name it: the first step stores it.
pub const COMPUTED: &str = "COMPUTE_FUNCTION_BLOCKS";

/// A chart. Transitions that compete for a step are in the order of their priority, the first goes first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Chart {
    /// The steps.
    pub steps: Vec<Step>,
    /// The transitions.
    pub transitions: Vec<Transition>,
    /// The macro steps, each in front of those in it.
    pub macros: Vec<Macro>,
    /// The line where it begins.
    pub line: u32,
    /// Which bytes of the file it takes, where it is an element of XML.
    pub span: Option<(usize, usize)>,
}

impl Chart {
    /// The step of this name.
    #[must_use]
    pub fn step(&self, name: &str) -> Option<usize> {
        self.steps.iter().position(|step| same(&step.name, name))
    }

    /// The steps of which one has to be active for the flag of this name to be true: the step of this name, or those that
    /// stand in the place of a macro step.
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

    /// Its Petri net on any controller: some end a step at once when a transition with a priority clears (matiec). Conditions
    /// behind it see the step as off, but for those of transitions that would need one of its steps, too.
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

    /// Whether some of its transitions have priorities.
    #[must_use]
    pub fn has_priorities(&self) -> bool {
        self.transitions.iter().any(|one| one.has_priority)
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

    /// What feeds the control of an action: the steps of blocks with the same qualifier and the same time come in together,
    /// as the standard's block has one input for each qualifier.
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

    /// The body of the action of this name, if it has one; else it is a Boolean variable.
    #[must_use]
    pub fn body<'a>(&'a self, pou: &'a Pou, action: &str) -> Option<&'a Body> {
        let inline =
            self.steps.iter().flat_map(|step| &step.blocks).find_map(|block| match &block.target {
                Target::Inline(name, body) if same(name, action) => Some(body.as_ref()),
                _ => None,
            });
        inline.or_else(|| pou.action(action).map(|named| &named.body))
    }
}

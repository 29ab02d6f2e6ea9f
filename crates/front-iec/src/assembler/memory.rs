//! The cells in which a chart keeps its state from scan to scan.

use scanbound_iec::chart::{Chart, Feed, Qualifier};
use scanbound_ir::tags::ValueForm;
use scanbound_ir::{BitTarget, Cell, Logic, Tag, Type, Write};
use std::sync::Arc;

/// Name of the bit that is true once the chart was executed.
const STARTED: &str = "chart started";

/// The cells of a chart's state. Steps, transitions and actions are in the order of the chart.
pub(crate) struct Memory {
    pub(crate) tag: Tag,
    pub(crate) started: Cell,
    pub(crate) steps: Vec<Cell>,
    pub(crate) were: Vec<Cell>,
    /// The times of all steps, then of all macro steps.
    pub(crate) times: Vec<StepTime>,
    pub(crate) clears: Vec<Cell>,
    pub(crate) actions: Vec<ActionMemory>,
}

/// The time of a step or macro step: its cell, the steps that make it active, and whether one of them is an initial
/// step.
pub(crate) struct StepTime {
    /// The first of the two words that hold the time.
    pub(crate) cell: Cell,
    pub(crate) steps: Vec<usize>,
    pub(crate) initial: bool,
}

/// The state of an action's control.
pub(crate) struct ActionMemory {
    pub(crate) feeds: Vec<Feed>,
    /// The bit that says whether the action was on in the previous scan.
    pub(crate) on: Cell,
    /// The bit that says whether qualifier S has stored the action.
    pub(crate) stored: Cell,
    pub(crate) inputs: Vec<InputMemory>,
}

/// The state bits of one input of an action's control: whether it was active in the previous scan, whether it is
/// stored, and whether its time is over.
#[derive(Clone, Copy)]
pub(crate) struct InputMemory {
    pub(crate) was: Cell,
    pub(crate) stored: Cell,
    pub(crate) over: Cell,
}

fn parts(all: impl IntoIterator<Item = (String, Type)>) -> Type {
    Type::Parts(Arc::new(all.into_iter().collect()))
}

fn bits(names: &[&str]) -> Type {
    parts(names.iter().map(|name| ((*name).to_owned(), Type::Bit)))
}

/// The layout of a chart's state: the started bit, steps, macro steps, transitions, then actions.
pub(crate) fn layout(chart: &Chart) -> Type {
    let mut all = vec![(STARTED.to_owned(), Type::Bit)];
    let time = || ("T".to_owned(), Type::Words(2, ValueForm::Time));
    let step = || {
        let flags = ["X", "was active"].map(|name| (name.to_owned(), Type::Bit));
        parts(flags.into_iter().chain([time()]))
    };
    all.extend(chart.steps.iter().map(|one| (one.name.clone(), step())));
    all.extend(chart.macros.iter().map(|one| (one.name.clone(), parts([time()]))));
    let ways = 0..chart.transitions.len();
    all.extend(ways.map(|at| (format!("transition {} clears", at + 1), Type::Bit)));
    for action in chart.actions() {
        let inputs = 0..chart.inputs_of(&action).len();
        let mut own = vec![("on".to_owned(), Type::Bit), ("stored".to_owned(), Type::Bit)];
        own.extend(
            inputs.map(|at| (format!("input {}", at + 1), bits(&["was", "stored", "over"]))),
        );
        all.push((format!("action {action}"), parts(own)));
    }
    parts(all)
}

/// The cells of a chart's state in a tag that has the layout of [`layout`]. None if the tag is too small.
pub(crate) fn memory(chart: &Chart, tag: &Tag) -> Option<Memory> {
    let mut numbers = 0..;
    let mut next = || tag.part_at(numbers.next()?);
    let part = |of: &Tag, number: usize| of.part_at(number)?.cell();
    let mut found = Memory {
        tag: tag.clone(),
        started: next()?.cell()?,
        steps: Vec::new(),
        were: Vec::new(),
        times: Vec::new(),
        clears: Vec::new(),
        actions: Vec::new(),
    };
    for (at, step) in chart.steps.iter().enumerate() {
        let own = next()?;
        found.steps.push(part(&own, 0)?);
        found.were.push(part(&own, 1)?);
        let (cell, initial) = (part(&own, 2)?, step.initial);
        found.times.push(StepTime { cell, steps: vec![at], initial });
    }
    for one in &chart.macros {
        let initial = one.steps.iter().any(|&step| chart.steps[step].initial);
        let (cell, steps) = (part(&next()?, 0)?, one.steps.clone());
        found.times.push(StepTime { cell, steps, initial });
    }
    for _ in &chart.transitions {
        found.clears.push(next()?.cell()?);
    }
    for name in chart.actions() {
        let own = next()?;
        let feeds = chart.inputs_of(&name);
        let input = |at: usize| {
            let own = own.part_at(2 + at)?;
            let [was, stored, over] = [0, 1, 2].map(|number| part(&own, number));
            Some(InputMemory { was: was?, stored: stored?, over: over? })
        };
        let inputs = (0..feeds.len()).map(input).collect::<Option<_>>()?;
        let (on, stored) = (part(&own, 0)?, part(&own, 1)?);
        found.actions.push(ActionMemory { feeds, on, stored, inputs });
    }
    Some(found)
}

pub(crate) fn all(parts: impl IntoIterator<Item = Logic>) -> Logic {
    Logic::All(parts.into_iter().collect())
}

pub(crate) fn any(parts: impl IntoIterator<Item = Logic>) -> Logic {
    Logic::Any(parts.into_iter().collect())
}

pub(crate) fn set(cell: Cell, value: Logic) -> Write {
    Write::Bit(BitTarget::Cell(cell), value)
}

impl Memory {
    /// True where at least one of these steps is active.
    pub(crate) fn active(&self, steps: &[usize]) -> Logic {
        any(steps.iter().map(|&step| Logic::cell(self.steps[step])))
    }
}

impl ActionMemory {
    /// Whether any input of the action has qualifier R.
    pub(crate) fn has_reset(&self) -> bool {
        self.feeds.iter().any(|feed| feed.qualifier == Qualifier::R)
    }

    /// True where the action is stored, and what stores it has it on.
    pub(crate) fn is_on_by_store(&self) -> Logic {
        let inputs = self.feeds.iter().zip(&self.inputs).map(|(feed, input)| {
            let [stored, over] = [input.stored, input.over].map(Logic::cell);
            match feed.qualifier {
                Qualifier::Sd => over,
                Qualifier::Sl => all([stored, over.not()]),
                _ => stored,
            }
        });
        any([Logic::cell(self.stored)].into_iter().chain(inputs))
    }

    /// True where a step that drives this action with the given qualifier is active.
    pub(crate) fn active(&self, memory: &Memory, qualifier: Qualifier) -> Logic {
        let own = self.feeds.iter().filter(|feed| feed.qualifier == qualifier);
        any(own.map(|feed| memory.active(&feed.steps)))
    }
}

//! Runs a chart by itself, scan by scan, by the standard's rules of evolution.
//!
//! In each scan: (1) all transitions whose steps are active and whose conditions are true are found, on the step flags
//! and values as they are; of those that compete for a step only the first clears; (2) all that clear do so at once:
//! their steps in front are deactivated, then those behind activated, so that a step that is both stays active, and its
//! time runs on; (3) the control of every action is worked out; (4) actions are carried out in the order in which the
//! chart first names them, or in another one that is asked for, Boolean variables taking their state. In the first scan
//! the initial steps are active and nothing clears.

use super::control::{Control, Input, Output};
use super::evaluate::{Memory, Value};
use scanbound::base::facts::ActionOrder;
use scanbound::iec::chart::{Chart, Target};
use scanbound::iec::{Body, Pou, same};

/// What implementations do differently.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Whether a body is carried out once more when its action has ended.
    pub final_scan: bool,
    /// Whether of transitions that compete for a step only the first clears; else all that can do.
    pub priority: bool,
    /// Whether actions are carried out before transitions are looked at.
    pub actions_first: bool,
    /// In which order actions are carried out that run in one scan.
    pub order: ActionOrder,
}

impl Default for Options {
    fn default() -> Options {
        let order = ActionOrder::Named;
        Options { final_scan: true, priority: true, actions_first: false, order }
    }
}

/// A chart that runs.
#[derive(Debug, Clone)]
pub struct Run<'a> {
    chart: &'a Chart,
    pou: &'a Pou,
    options: Options,
    actions: Vec<String>,
    active: Vec<bool>,
    since: Vec<i64>,
    /// Since when each macro step is active.
    macros: Vec<i64>,
    controls: Vec<Control>,
    started: bool,
    /// The values of variables.
    pub memory: Memory,
}

impl<'a> Run<'a> {
    /// A chart of a unit, before its first scan.
    pub fn new(chart: &'a Chart, pou: &'a Pou, options: Options) -> Run<'a> {
        let actions = chart.actions();
        Run {
            active: vec![false; chart.steps.len()],
            since: vec![0; chart.steps.len()],
            macros: vec![0; chart.macros.len()],
            controls: vec![Control::default(); actions.len()],
            started: false,
            memory: Memory::default(),
            chart,
            pou,
            options,
            actions,
        }
    }

    /// Which steps are active.
    pub fn active(&self) -> &[bool] {
        &self.active
    }

    /// What the next scans depend on, except inputs, values and the times of steps.
    pub fn state(&self) -> (Vec<bool>, Vec<Control>) {
        (self.active.clone(), self.controls.clone())
    }

    /// Takes this moment for the beginning of time; what is longer ago than the horizon is taken to be just so long
    /// ago.
    pub fn begin_time_at(&mut self, now: i64, horizon: i64) {
        let all = self.since.iter_mut().chain(&mut self.macros);
        all.for_each(|since| *since = (*since - now).max(-horizon));
        self.controls.iter_mut().for_each(|control| control.begin_time_at(now, horizon));
    }

    /// The names of the actions, as [`Run::scan`] tells of them.
    pub fn actions(&self) -> &[String] {
        &self.actions
    }

    /// The next scan at this time in nanoseconds: what came of each action.
    ///
    /// # Errors
    /// What cannot be carried out, in words.
    pub fn scan(&mut self, now: i64) -> Result<Vec<Output>, String> {
        if !self.started {
            self.started = true;
            for step in self.chart.initial() {
                self.active[step] = true;
                self.since[step] = now;
            }
            self.macros.fill(now);
            return self.act(now);
        }
        if self.options.actions_first {
            let outputs = self.act(now)?;
            self.evolve(now)?;
            return Ok(outputs);
        }
        self.evolve(now)?;
        self.act(now)
    }

    /// Puts step flags and times where expressions find them.
    fn flags(&mut self, now: i64) {
        for (at, step) in self.chart.steps.iter().enumerate() {
            let time = if self.active[at] { now - self.since[at] } else { 0 };
            self.memory.set(&format!("{}.x", step.name), Value::Bool(self.active[at]));
            self.memory.set(&format!("{}.t", step.name), Value::Time(time));
        }
        for (one, &since) in self.chart.macros.iter().zip(&self.macros) {
            let is_active = one.steps.iter().any(|&step| self.active[step]);
            let time = if is_active { now - since } else { 0 };
            self.memory.set(&format!("{}.x", one.name), Value::Bool(is_active));
            self.memory.set(&format!("{}.t", one.name), Value::Time(time));
        }
    }

    fn evolve(&mut self, now: i64) -> Result<(), String> {
        self.flags(now);
        let mut taken = vec![false; self.active.len()];
        let mut cleared = Vec::new();
        for transition in &self.chart.transitions {
            let is_free =
                |&step: &usize| self.active[step] && !(taken[step] && self.options.priority);
            if transition.from.iter().all(is_free) && self.memory.truth(&transition.condition)? {
                transition.from.iter().for_each(|&step| taken[step] = true);
                cleared.push(transition);
            }
        }
        let before = self.active.clone();
        cleared.iter().flat_map(|one| &one.from).for_each(|&step| self.active[step] = false);
        cleared.iter().flat_map(|one| &one.to).for_each(|&step| self.active[step] = true);
        for (step, &was) in before.iter().enumerate() {
            if self.active[step] && !was {
                self.since[step] = now;
            }
        }
        for (one, since) in self.chart.macros.iter().zip(&mut self.macros) {
            let is = |active: &[bool]| one.steps.iter().any(|&step| active[step]);
            if is(&self.active) && !is(&before) {
                *since = now;
            }
        }
        Ok(())
    }

    fn act(&mut self, now: i64) -> Result<Vec<Output>, String> {
        self.flags(now);
        let mut outputs = Vec::new();
        for (action, control) in self.actions.iter().zip(&mut self.controls) {
            let input = |feed: scanbound::iec::chart::Feed| -> Result<Input, String> {
                let time = match &feed.time {
                    None => 0,
                    Some(time) => match self.memory.value(time)? {
                        Value::Time(time) => time,
                        other => return Err(format!("{other:?} is no time")),
                    },
                };
                let active = feed.steps.iter().any(|&step| self.active[step]);
                Ok(Input { qualifier: feed.qualifier, time, active })
            };
            let inputs = self.chart.inputs_of(action);
            let inputs = inputs.into_iter().map(input).collect::<Result<Vec<_>, _>>()?;
            outputs.push(control.scan(&inputs, now, self.options.final_scan));
        }
        for at in self.order(&outputs) {
            let (action, output) = (&self.actions[at], &outputs[at]);
            match body(self.chart, self.pou, action) {
                None => self.memory.set(action, Value::Bool(output.q)),
                Some(Body::Code(_, statements)) if output.runs => self.memory.run(statements)?,
                Some(Body::Code(..) | Body::Drawn(..)) if !output.runs => {}
                Some(_) => return Err(format!("the action {action} is not carried out here")),
            }
        }
        Ok(outputs)
    }

    /// The order in which actions are carried out.
    fn order(&self, outputs: &[Output]) -> Vec<usize> {
        let mut all: Vec<usize> = (0..self.actions.len()).collect();
        match self.options.order {
            ActionOrder::Named => {}
            ActionOrder::Alphabetical => {
                all.sort_by_key(|&at| (outputs[at].q, self.actions[at].to_ascii_uppercase()));
            }
            ActionOrder::Declared => all.sort_by_key(|&at| {
                let name = &self.actions[at];
                let declared = self.pou.actions.iter().position(|one| same(&one.name, name));
                (body(self.chart, self.pou, name).is_some(), declared)
            }),
        }
        all
    }
}

/// The body of the action of this name, if it has one; else it is a Boolean variable.
fn body<'a>(chart: &'a Chart, pou: &'a Pou, action: &str) -> Option<&'a Body> {
    let mut blocks = chart.steps.iter().flat_map(|step| &step.blocks);
    let inline = blocks.find_map(|block| match &block.target {
        Target::Inline(name, body) if same(name, action) => Some(body.as_ref()),
        _ => None,
    });
    inline.or_else(|| pou.action(action).map(|named| &named.body))
}

//! Calls with EN and ENO: what is called is carried out only where EN is true, and ENO says so.

use super::assembler::Assembler;
use super::emit::{Emit, Place};
use super::resolve::Context;
use super::types::{INT, holding};
use super::value::Value;
use scanbound_iec::ast::{Argument, Expr};
use scanbound_iec::fault::Fault;
use scanbound_iec::same;
use scanbound_ir::Logic;

/// A call under a condition, while it is put together.
pub(super) struct Enabled {
    condition: Logic,
    skip: usize,
}

fn argument<'g>(given: &'g [Argument], name: &str, is_output: bool) -> Option<&'g Argument> {
    given.iter().find(|one| {
        one.is_output == is_output && one.name.as_ref().is_some_and(|own| same(own, name))
    })
}

impl Emit<'_> {
    /// Begins a call: what follows is skipped where EN is false.
    pub(super) fn begin_enabled(
        &mut self,
        at: &Context,
        place: &Place,
        given: &[Argument],
        line: u32,
    ) -> Result<Option<Enabled>, Fault> {
        let Some(condition) = self.condition(at, place, given, line)? else { return Ok(None) };
        let skip = self.jump(condition.clone().not(), Some(Assembler::key(&["JMP"], "jump")));
        Ok(Some(Enabled { condition, skip }))
    }

    /// Begins to hand inputs over to an instance. Where EN is false, some controllers do, and leave the body out.
    pub(super) fn begin_inputs(
        &mut self,
        at: &Context,
        place: &Place,
        given: &[Argument],
        line: u32,
    ) -> Result<Option<Enabled>, Fault> {
        let Some(condition) = self.condition(at, place, given, line)? else { return Ok(None) };
        let why = "inputs may or may not be handed over where EN is false";
        let leaves = vec![condition.clone().not(), self.any_bit(why)];
        let skip = self.jump(Logic::All(leaves), None);
        Ok(Some(Enabled { condition, skip }))
    }

    /// Begins the call itself behind its inputs.
    pub(super) fn begin_body(&mut self, inputs: Option<Enabled>) -> Option<Enabled> {
        let Enabled { condition, skip } = inputs?;
        self.land(skip);
        self.landing();
        let skip = self.jump(condition.clone().not(), Some(Assembler::key(&["JMP"], "jump")));
        Some(Enabled { condition, skip })
    }

    /// What outputs are handed to may hold anything where EN is false: controllers differ.
    pub(super) fn open_outputs(
        &mut self,
        at: &Context,
        condition: Option<&Logic>,
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        let is_other = |one: &&Argument| {
            one.is_output && !one.name.as_ref().is_some_and(|name| same(name, "ENO"))
        };
        let targets = given.iter().filter(is_other).filter_map(|one| match &one.value {
            Expr::Variable(path) if !path.first.is_empty() => Some(path),
            _ => None,
        });
        let targets: Vec<_> = targets.collect();
        let Some(condition) = condition.filter(|_| !targets.is_empty()) else { return Ok(()) };
        let skip = self.jump(condition.clone(), None);
        for target in targets {
            self.assign(at, target, Value::Any, line)?;
        }
        self.land(skip);
        self.landing();
        Ok(())
    }

    /// What EN is, if it is given.
    fn condition(
        &mut self,
        at: &Context,
        place: &Place,
        given: &[Argument],
        line: u32,
    ) -> Result<Option<Logic>, Fault> {
        let Some(enable) = argument(given, "EN", false) else { return Ok(None) };
        let mut condition = self.bit(at, &enable.value, line)?;
        if Self::part(place, "EN").is_some() {
            let why = "an input EN that is declared: whether the body is carried out without it";
            condition = Logic::Any(vec![condition, self.any_bit(why)]);
        }
        Ok(Some(self.keep_bit(condition)))
    }

    /// Ends a call, and hands ENO out; the condition, if there was one.
    pub(super) fn end_enabled(
        &mut self,
        at: &Context,
        place: &Place,
        enabled: Option<Enabled>,
        given: &[Argument],
        line: u32,
    ) -> Result<Option<Logic>, Fault> {
        let condition = enabled.map(|enabled| {
            self.land(enabled.skip);
            self.landing();
            enabled.condition
        });
        if let Some(told) = argument(given, "ENO", true) {
            let (target, negated) = match &told.value {
                Expr::Variable(path) if !path.first.is_empty() => (Some(path), false),
                Expr::Not(inner) => match inner.as_ref() {
                    Expr::Variable(path) => (Some(path), true),
                    _ => (None, true),
                },
                _ => (None, false),
            };
            if let Some(target) = target {
                // What is called may tell a fault by itself.
                let may_fail = Self::part(place, "ENO").is_some();
                let runs = condition.clone().unwrap_or(Logic::Const(true));
                let told = match may_fail {
                    true => {
                        let why = "an output ENO that is declared: it may be true or false";
                        Logic::All(vec![runs, self.any_bit(why)])
                    }
                    false => runs,
                };
                let told = if negated { told.not() } else { told };
                self.assign(at, target, Value::Bit(told), line)?;
            }
        }
        Ok(condition)
    }
}

impl Assembler {
    /// The result of a call: any value, where it was not carried out.
    pub(super) fn result_if(
        &mut self,
        condition: Option<Logic>,
        result: Value,
        line: u32,
    ) -> Result<Value, Fault> {
        let Some(condition) = condition else { return Ok(result) };
        let result = self.settled(result);
        let why = "the result of a call whose EN is false may be any value";
        let other = match &result {
            Value::Bit(_) => Value::Bit(self.any_bit(why)),
            Value::Number(kind, _) => Value::Number(*kind, self.any_number(*kind, why)),
            Value::Constant(value) => {
                let kind = holding(INT, *value);
                Value::Number(kind, self.any_number(kind, why))
            }
            Value::Any | Value::Open(..) | Value::Address(..) => return Ok(Value::Any),
        };
        self.chosen(condition, result, other, line)
    }
}

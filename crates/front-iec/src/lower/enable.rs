//! Calls with EN and ENO: what is called is executed only where EN is true, and ENO says so.

use super::Lower;
use super::effects::is_same;
use super::spots::Context;
use crate::assembler::Assembler;
use crate::assembler::value::Value;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::tree::{Call, Enable, Expr, Passed, Place};
use scanbound_ir::Logic;

/// A call under a condition, while it is lowered.
pub(super) struct Enabled {
    condition: Logic,
    skip: usize,
    /// Whether what is called is skipped, too, and not its inputs alone.
    is_body: bool,
}

impl Lower<'_> {
    /// What EN is, if it is given.
    pub(super) fn condition(
        &mut self,
        at: &Context,
        enable: &Enable,
    ) -> Result<Option<Logic>, Fault> {
        let Some(one) = &enable.condition else { return Ok(None) };
        let mut condition = self.bit(at, one)?;
        if enable.is_input {
            let why = "an input EN that is declared: whether the body is carried out without it";
            condition = Logic::Any(vec![condition, self.any_bit(why)]);
        }
        Ok(Some(self.keep_bit(condition)))
    }

    /// Begins to work out the arguments of a function or a method. Where EN is false, some controllers do, and leave the body
    /// out; that matters where an argument calls something.
    pub(super) fn begin_arguments<'e>(
        &mut self,
        at: &Context,
        enable: &Enable,
        mut arguments: impl Iterator<Item = &'e Expr>,
    ) -> Result<Option<Enabled>, Fault> {
        if arguments.any(|one| self.calls_own(one)) {
            return self.begin_inputs(at, enable);
        }
        let condition = self.condition(at, enable)?;
        Ok(condition.map(|condition| self.begin_enabled(condition)))
    }

    /// Begins a call: what follows is skipped where EN is false.
    pub(super) fn begin_enabled(&mut self, condition: Logic) -> Enabled {
        let skip = self.jump(condition.clone().not(), Assembler::jump_key());
        Enabled { condition, skip, is_body: true }
    }

    /// Begins to hand inputs over to an instance. Where EN is false, some controllers do, and leave the body out.
    pub(super) fn begin_inputs(
        &mut self,
        at: &Context,
        enable: &Enable,
    ) -> Result<Option<Enabled>, Fault> {
        let Some(condition) = self.condition(at, enable)? else { return Ok(None) };
        let why = "inputs may or may not be handed over where EN is false";
        let leaves = vec![condition.clone().not(), self.any_bit(why)];
        let skip = self.jump(Logic::All(leaves), None);
        Ok(Some(Enabled { condition, skip, is_body: false }))
    }

    /// Begins the call itself behind its inputs.
    pub(super) fn begin_body(&mut self, inputs: Option<Enabled>) -> Option<Enabled> {
        let inputs = inputs?;
        if inputs.is_body {
            return Some(inputs);
        }
        self.land(inputs.skip);
        self.landing();
        Some(self.begin_enabled(inputs.condition))
    }

    /// Ends a call, and hands ENO out; the condition, if there was one.
    pub(super) fn end_enabled(
        &mut self,
        at: &Context,
        enabled: Option<Enabled>,
        enable: &Enable,
        line: u32,
    ) -> Result<Option<Logic>, Fault> {
        let condition = enabled.map(|enabled| {
            self.land(enabled.skip);
            self.landing();
            enabled.condition
        });
        if let Some((target, negated)) = &enable.result {
            // What is called may tell a fault by itself.
            let runs = condition.clone().unwrap_or(Logic::Const(true));
            let told = match enable.is_output {
                true => {
                    let why = "an output ENO that is declared: it may be true or false";
                    Logic::All(vec![runs, self.any_bit(why)])
                }
                false => runs,
            };
            let told = if *negated { told.not() } else { told };
            self.assign(at, target, None, Value::Bit(told), line)?;
        }
        Ok(condition)
    }

    pub(super) fn open_results(
        &mut self,
        at: &Context,
        condition: Option<&Logic>,
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        let eno = call.enable.result.as_ref().filter(|_| call.enable.is_output);
        let targets = call.passed.iter().filter_map(|(_, passed)| match passed {
            // Where ENO is declared, it is among them, and has its value already.
            Passed::Output(place, _) => Some(place),
            _ => None,
        });
        let targets: Vec<&Place> =
            targets.filter(|place| eno.is_none_or(|(own, _)| !is_same(own, place))).collect();
        self.open_outputs(at, condition, &targets, line)
    }

    /// What outputs are handed to may hold anything where EN is false: controllers differ.
    pub(super) fn open_outputs(
        &mut self,
        at: &Context,
        condition: Option<&Logic>,
        targets: &[&Place],
        line: u32,
    ) -> Result<(), Fault> {
        let Some(condition) = condition.filter(|_| !targets.is_empty()) else { return Ok(()) };
        let skip = self.jump(condition.clone(), None);
        for target in targets {
            self.assign(at, target, None, Value::Any, line)?;
        }
        self.land(skip);
        self.landing();
        Ok(())
    }
}

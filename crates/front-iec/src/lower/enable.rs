//! Lowers calls with EN and ENO: the called code is executed only where EN is true, and ENO reports it.

use super::Lower;
use super::effects::is_same;
use super::enabled::instance_variable;
use super::spots::{Callee, Context, Spot};
use crate::assembler::Assembler;
use crate::assembler::value::Value;
use scanbound_base::code::Code;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::tree::{Call, Enable, Expr, Passed, Place, Target};
use scanbound_ir::{BitTarget, Logic, Step, TimingKey, Write};

/// The state of lowering a call with EN.
pub(super) struct Enabled {
    condition: Logic,
    /// Whether the arguments are evaluated also where EN is false.
    works: Logic,
    skip: usize,
}

impl Lower<'_> {
    /// The condition that EN gives. None if the call has no EN.
    pub(super) fn condition(
        &mut self,
        at: &Context,
        enable: &Enable,
    ) -> Result<Option<Logic>, Fault> {
        let Some(one) = &enable.condition else { return Ok(None) };
        let mut condition = self.bit(at, one)?;
        if enable.is_input {
            let why = "EN is declared as an input: the body may run although it is false";
            condition = Logic::Any(vec![condition, self.any_bit(why)]);
        }
        Ok(Some(self.keep_bit(condition)))
    }

    /// Begins a call with EN. Where EN is false, some controllers jump over the whole call. Others evaluate and pass
    /// the arguments, and call the block, which then tests EN. The difference affects inputs that an instance keeps and
    /// arguments with calls; otherwise only the time. None if the call has no EN.
    pub(super) fn begin_arguments(
        &mut self,
        at: &Context,
        callee: &Callee,
        call: &Call,
        line: u32,
    ) -> Result<Option<Enabled>, Fault> {
        let arguments: Vec<&Expr> = call.values().collect();
        let condition = match (&call.target, callee) {
            (Target::Instance(place, _) | Target::Standard(place, _), callee) => {
                let (Callee::Unit(spot, _) | Callee::Standard(spot, _) | Callee::Method(spot, _)) =
                    callee;
                self.kept_condition(at, (place, spot), &call.enable)?
            }
            _ => self.condition(at, &call.enable)?,
        };
        let keeps = matches!(call.target, Target::Instance(..) | Target::Standard(..));
        let keeps = keeps && !arguments.is_empty();
        self.begin_inputs(at, (&call.enable, condition), &arguments, keeps, line)
    }

    /// The condition of an instance's EN. On controllers where EN is an input like any other, a call that omits it uses
    /// its last value.
    fn kept_condition(
        &mut self,
        at: &Context,
        (place, spot): (&Place, &Spot),
        enable: &Enable,
    ) -> Result<Option<Logic>, Fault> {
        let condition = self.condition(at, enable)?;
        let given = &self.memory.enabled;
        let is_given = given.through_reference
            || given.copied
            || match instance_variable(place) {
                Some(id) => given.variables.contains(&id),
                None => !given.variables.is_empty(),
            };
        if enable.is_input || !is_given {
            return Ok(condition);
        }
        let begin = spot.tag.begin();
        let cell = match self.memory.enabled.cells.get(&begin) {
            // A copy also has the EN value of its source.
            _ if given.copied => None,
            Some(&cell) => cell,
            None => {
                // EN is TRUE at first.
                let name = format!("{}: EN was false", spot.name);
                let cell = self.hidden(&name, scanbound_ir::Type::Bit).and_then(|tag| tag.cell());
                self.memory.enabled.cells.insert(begin, cell);
                cell
            }
        };
        let Some(cell) = cell else {
            let why = "EN may or may not keep its value from the last call";
            return Ok(Some(condition.unwrap_or_else(|| self.any_bit(why))));
        };
        if let Some(given) = &condition {
            let off = Write::Bit(BitTarget::Cell(cell), given.clone().not());
            self.write(vec![off]);
            return Ok(condition);
        }
        let keeps = self.left_open();
        Ok(Some(self.keep_bit(Logic::All(vec![keeps, Logic::cell(cell)]).not())))
    }

    /// Begins the evaluation of the arguments of a call with EN. `keeps`: whether the variables that receive them
    /// outlast the call. None if there is no condition.
    pub(super) fn begin_inputs(
        &mut self,
        at: &Context,
        (enable, condition): (&Enable, Option<Logic>),
        arguments: &[&Expr],
        keeps: bool,
        line: u32,
    ) -> Result<Option<Enabled>, Fault> {
        let Some(condition) = condition else { return Ok(None) };
        if let Some(one) = &enable.condition
            && arguments.iter().any(|argument| self.order_matters(at, one, argument))
        {
            let told = "an argument and EN of one call depend on each other: it is not known which is evaluated first";
            let help = "assign the value of EN to a separate variable first";
            return Err(Fault::new(line, told).code(Code::NotModelled).help(help));
        }
        let works = match keeps || arguments.iter().any(|one| one.calls()) {
            true => self.any_bit("controllers may or may not pass the inputs where EN is false"),
            false => self.extra_time(),
        };
        let skip = self.jump(Logic::All(vec![condition.clone().not(), works.clone().not()]), None);
        Ok(Some(Enabled { condition, works, skip }))
    }

    /// Begins the call itself, after its inputs. Where EN is false, a called block that tests EN takes its larger time.
    pub(super) fn begin_body(
        &mut self,
        inputs: Option<Enabled>,
        called: TimingKey,
    ) -> Option<Enabled> {
        let Enabled { condition, works, skip } = inputs?;
        let called = TimingKey { use_larger_time: true, ..called };
        let calls = self.jump(condition.clone(), None);
        self.builder.add(Some(called), Vec::new(), Step::Nothing);
        for jump in [calls, skip] {
            self.land(jump);
        }
        self.landing();
        let skip = self.jump(condition.clone().not(), Assembler::jump_key());
        Some(Enabled { condition, works, skip })
    }

    /// Ends a call and assigns ENO. Where EN is false, the targets of outputs may hold any value, since controllers
    /// differ. `fails`: where the called function reports a failure. Returns the condition of EN, if there was one.
    pub(super) fn end_enabled(
        &mut self,
        at: &Context,
        enabled: Option<Enabled>,
        enable: &Enable,
        (outputs, fails): (&[&Place], Option<Logic>),
        line: u32,
    ) -> Result<Option<Logic>, Fault> {
        if let Some(Enabled { condition, works, skip }) = &enabled {
            self.land(*skip);
            self.landing();
            if !outputs.is_empty() {
                self.open_outputs(at, (condition, works), outputs, line)?;
            }
        }
        let condition = enabled.map(|enabled| enabled.condition);
        if let Some((target, negated)) = &enable.result {
            // The called block may report a failure by itself.
            let runs = condition.clone().unwrap_or(Logic::Const(true));
            let told = match enable.is_output {
                true => {
                    let why = "an output ENO that is declared: it may be true or false";
                    Logic::All(vec![runs, self.any_bit(why)])
                }
                false => runs,
            };
            let told = match fails {
                Some(fails) => Logic::All(vec![told, fails.not()]),
                None => told,
            };
            let told = if *negated { told.not() } else { told };
            self.assign(at, target, None, Value::Bit(told), line)?;
        }
        Ok(condition)
    }

    /// The places to which a call assigns its outputs, without a declared ENO.
    pub(super) fn outputs<'c>(&self, call: &'c Call) -> Vec<&'c Place> {
        let eno = call.enable.result.as_ref().filter(|_| call.enable.is_output);
        let targets = call.passed.iter().filter_map(|(_, passed)| match passed {
            // A declared ENO is among the outputs; it is assigned separately.
            Passed::Output(place, _) => Some(place),
            _ => None,
        });
        targets.filter(|place| eno.is_none_or(|(own, _)| !is_same(own, place))).collect()
    }

    fn open_outputs(
        &mut self,
        at: &Context,
        (condition, works): (&Logic, &Logic),
        targets: &[&Place],
        line: u32,
    ) -> Result<(), Fault> {
        let skip = self.jump(condition.clone(), None);
        let from = self.builder.next();
        for target in targets {
            self.assign(at, target, None, Value::Any, line)?;
        }
        let stored: Vec<TimingKey> = self.builder.program.instructions[from..]
            .iter()
            .filter_map(|one| one.timing.as_deref().cloned())
            .collect();
        self.charge_nothing(from);
        let leaves = self.jump(works.clone().not(), None);
        targets.iter().for_each(|_| self.cost(&["LD"], "contact"));
        for key in stored {
            self.builder.add(Some(key), Vec::new(), Step::Nothing);
        }
        for jump in [leaves, skip] {
            self.land(jump);
        }
        self.landing();
        Ok(())
    }
}

//! Lowers the actions of charts: inline code, called actions, and Boolean variables.

use super::Lower;
use super::bodies::BodyKey;
use super::cells::add;
use super::charts::Own;
use super::spots::{Context, Found};
use super::statements::{ENDS_CHART, JumpTargets};
use crate::assembler::control::{Before, Output};
use crate::assembler::memory::{all, set};
use crate::assembler::turns;
use crate::assembler::value::Value;
use crate::assembler::{Assembler, OpenEnd};
use scanbound_base::code::Code as FaultCode;
use scanbound_front::builder::always;
use scanbound_iec::Language;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::blocks::Pin;
use scanbound_iec_tree::charts::ActionBody;
use scanbound_iec_tree::declarations::{Code, RoutineId};
use scanbound_iec_tree::tree::{
    Call, Place, Root, Statement, StatementKind, Step as PathStep, Target, each_statement,
};
use scanbound_iec_tree::types::{Elementary, Type as Typed};
use scanbound_ir::{Cell, Logic, Region, Step, Write};

const DRAWN: &str = "controllers execute the blocks of a drawn condition in each scan, or where they evaluate the condition: both are assumed possible, with any result ([sfc] drawn_conditions states which)";

/// A Boolean variable that may keep its value where nothing switches its action.
struct Kept {
    /// The instruction that writes the bit which allows this.
    says: usize,
    cell: Cell,
    /// The instruction that writes the variable.
    writes: usize,
}

impl Lower<'_> {
    /// Lowers the execution of a chart's actions. `outputs`: the result of each action's control.
    pub(super) fn actions(&mut self, own: &Own<'_>, outputs: &[Output]) {
        let rounds = turns::rounds(&own.chart.orders, self.options.charts.action_order);
        let ended: Vec<Logic> = outputs.iter().map(|output| output.on.clone().not()).collect();
        let mut kept: Vec<Vec<Kept>> = outputs.iter().map(|_| Vec::new()).collect();
        let memory = self.instances[own.at.instance].spot.tag.regions();
        turns::in_turns(self, &rounds, &ended, memory, &mut |lower, number| {
            let (action, output) = (&own.chart.actions[number], &outputs[number]);
            lower.at(action.line, &action.name);
            match &action.body {
                ActionBody::Inline(language, code) => {
                    let body = ((own.id, Some(number)), *language);
                    lower.in_block(own.at, body, code, output.runs.clone());
                }
                ActionBody::Variable(place) => {
                    let found = lower.action_variable(own.at, place, output, action.line);
                    kept[number].extend(found);
                }
                ActionBody::Call(call) => lower.action_called(own.at, call, &output.runs),
                ActionBody::Computed(call, _) if lower.options.charts.drawn_last_scan => {
                    lower.action_called(own.at, call, &output.runs);
                }
                ActionBody::Computed(call, computed) => {
                    // Other controllers execute these blocks where they evaluate the condition. No real run depends on
                    // the choice made here.
                    let elsewhere = lower.any_bit(DRAWN);
                    let skip = lower.jump(elsewhere, None);
                    lower.executed(own.at, call, output.runs.clone());
                    lower.land(skip);
                    lower.landing();
                    lower.open_computed(own.at, *computed, action.line);
                }
            }
        });
        for all in kept {
            let own: Vec<usize> = all.iter().map(|one| one.writes).collect();
            for Kept { says, cell, .. } in all {
                self.open_ends.push(OpenEnd::Variable { at: says, cell, own: own.clone() });
            }
        }
    }

    /// Lowers the inline code of an action block, executed where `runs` is true.
    fn in_block(&mut self, at: &Context, body: (BodyKey, Language), code: &Code, runs: Logic) {
        let skip = self.jump(runs.not(), Assembler::jump_key());
        // Generators make a named action of it, and call that.
        if !self.options.charts.actions_first {
            let is_called = self.differs("actions written in the chart are called");
            let skip = self.jump(is_called.not(), None);
            self.cost(&["CAL"], "call");
            self.land(skip);
            self.landing();
        }
        match code {
            Code::Statements(statements) => {
                let around = self.enter(body.0, body.1);
                let mut targets = JumpTargets { ends: Some(Vec::new()), ..JumpTargets::default() };
                self.statements(at, statements, &mut targets);
                targets.ends.into_iter().flatten().for_each(|jump| self.land(jump));
                self.leave(around);
            }
            Code::Unread(fault) => self.fault(fault.clone()),
            Code::Chart(_) => {}
        }
        self.land(skip);
        self.landing();
    }

    /// Assigns the state of an action to its Boolean variable. Returns the variable if it may keep its value and nobody
    /// but the program writes it.
    fn action_variable(
        &mut self,
        at: &Context,
        place: &Place,
        output: &Output,
        line: u32,
    ) -> Option<Kept> {
        let written = self.find(at, place, line).and_then(|found| {
            let bool = self.tree.types.elementary(Elementary::Bool);
            let before = match &found {
                Found::Spot(spot) if spot.ty == bool => {
                    spot.tag.cell().map_or(Before::Any, Before::Cell)
                }
                Found::WordBit(cell, bit, _) => Before::Bit(*cell, *bit),
                _ => Before::Any,
            };
            let (on, open) = self.held(&before, output);
            Ok((self.writes(found, Value::Bit(on), line)?, open))
        });
        let (writes, open) = match written {
            Ok(written) => written,
            Err(fault) => {
                self.fault(fault);
                return None;
            }
        };
        let effects = writes.into_iter().map(always).collect();
        let key = Some(Assembler::key(&["ST"], "move"));
        let writes = self.assembler().builder.add(key, effects, Step::Nothing);
        let (says, cell) = open.filter(|_| !self.options.charts.others_write)?;
        Some(Kept { says, cell, writes })
    }

    /// Lowers the call of an action. Where RETURN ends the action, on some controllers the chart ends too.
    fn action_called(&mut self, at: &Context, call: &Statement, runs: &Logic) {
        let Some(returned) = self.own_action(at, call) else {
            return self.executed(at, call, runs.clone());
        };
        self.write(vec![set(returned, Logic::Const(false))]);
        self.executed(at, call, runs.clone());
        let whole = self.differs(ENDS_CHART);
        let goes_on = self.jump(all([Logic::cell(returned), whole]).not(), None);
        self.assembler().builder.add(None, Vec::new(), Step::Return);
        self.land(goes_on);
        self.landing();
    }

    /// The bit that records a RETURN, for a statement that calls an action of its own instance. None for other
    /// statements, or if the action has no RETURN.
    fn own_action(&mut self, at: &Context, call: &Statement) -> Option<Cell> {
        let StatementKind::Call(Call { target: Target::Action(place, id), .. }) = &call.kind else {
            return None;
        };
        if place.root != Root::This || !place.steps.is_empty() {
            return None;
        }
        let own = self.tree.dispatched(self.instances[at.instance].unit, *id);
        self.returned(at.instance, own)
    }

    /// The bit that records that RETURN ended an action of an instance. None if the action has no RETURN.
    pub(super) fn returned(&mut self, instance: usize, action: RoutineId) -> Option<Cell> {
        let Code::Statements(statements) = &self.tree.routine(action).code else { return None };
        let mut has_any = false;
        each_statement(statements, &mut |one| {
            has_any |= matches!(one.kind, StatementKind::Return(_));
        });
        if !has_any {
            return None;
        }
        if let Some(&known) = self.charts.returned.get(&(instance, action)) {
            return Some(known);
        }
        let cell = self.bit_between();
        self.charts.returned.insert((instance, action), cell);
        Some(cell)
    }

    /// Gives any value to the outputs of the blocks of a drawn condition.
    fn open_computed(&mut self, at: &Context, computed: RoutineId, line: u32) {
        let Code::Statements(statements) = &self.tree.routine(computed).code else { return };
        let mut any = Vec::new();
        for one in statements {
            let kind = match &one.kind {
                StatementKind::CallIf(_, inner) => &inner.kind,
                kind => kind,
            };
            let place = match kind {
                StatementKind::Assign(place, _) | StatementKind::Copy(place, _) => place,
                StatementKind::Call(Call {
                    target: Target::Instance(place, _) | Target::Standard(place, _),
                    ..
                }) => place,
                _ => continue,
            };
            if let Ok(Found::Spot(spot)) = self.find(at, place, line) {
                any.extend(self.given_by(&spot, line));
            }
        }
        let choice = self.builder.choice();
        let writes = any.into_iter().map(|region| Write::Havoc(region, choice)).collect();
        let at = self.write(writes);
        self.program().approximate(at, DRAWN);
    }

    /// The cells that a block of a drawn condition writes and other code can read. Records a fault for a function block
    /// that the project declares.
    fn given_by(&mut self, spot: &super::spots::Spot, line: u32) -> Vec<Region> {
        match self.tree.types.get(spot.ty) {
            Typed::Block(_) => {
                let what = format!(
                    "{}: controllers execute a function block in a drawn condition in each scan, or where they evaluate the condition",
                    spot.name
                );
                let help = "state [sfc] drawn_conditions = \"last-scan\" for the first (Beremiz, OpenPLC), or call it in an action";
                let fault = Fault::new(line, what).code(FaultCode::NotModelled).help(help);
                self.fault(fault);
                Vec::new()
            }
            // The inner state of a timer is not read by other code.
            Typed::Standard(block) if block.is_timer() => [Pin::Q, Pin::Et]
                .into_iter()
                .filter_map(|pin| self.stepped(spot, None, &PathStep::Pin(pin)))
                .flat_map(|part| part.tag.regions())
                .collect(),
            _ => spot.tag.regions(),
        }
    }
}

impl Lower<'_> {
    /// Adds the effects of a chart and of all that it calls.
    pub(super) fn of_chart(
        &mut self,
        at: &Context,
        id: RoutineId,
        chart: &scanbound_iec_tree::charts::Chart,
        found: &mut super::cells::Effects,
    ) {
        let own = self.chart_cell(at.instance, id);
        found.reads.insert(own);
        found.writes.insert(own);
        self.of_actions(at, chart, found);
        for &flag in [&chart.halt, &chart.restart].into_iter().flatten() {
            if let Ok(spot) = self.variable(at, flag) {
                add(&mut found.reads, spot.tag.regions());
            }
        }
    }
}

//! Lowers statements and the routines that contain them.

use super::cells::{Effects, add};
use super::spots::Callee;
use super::spots::{Context, Found, Instance, Spot};
use super::{Entry, Lower};
use crate::assembler::Assembler;
use crate::assembler::memory::set;
use crate::assembler::value::Value;
use scanbound_base::code::Code as FaultCode;
use scanbound_front::builder::always;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, Section};
use scanbound_iec_tree::declarations::{Code, Routine, RoutineKind, Stated, UnitId, VarId};
use scanbound_iec_tree::tree::{Expr, ExprKind, Place, Selector, Statement, StatementKind, Tree};
use scanbound_iec_tree::types::DINT;
use scanbound_ir::{Cell, Logic, Number, Step, Write};
use std::collections::BTreeMap;

/// Text of a reading: how some controllers differ from the standard here.
pub(super) const ENDS_CHART: &str = "RETURN in an action ends the whole chart";

/// Text of a reading, about VAR_TEMP variables with EXTENDS.
const ONLY_OWN_TEMPORARY: &str =
    "a body initialises only the VAR_TEMP of its own block, not of its bases";

/// Pending jumps of a body: to labels, to the ends of loops, and to the end of an action.
#[derive(Default)]
pub(super) struct JumpTargets {
    /// Jumps to labels that are not reached yet, by label number.
    pub(super) labels: BTreeMap<u32, Vec<usize>>,
    /// For each enclosing loop: the jumps to the end of its iteration (CONTINUE), and the jumps out of it (EXIT).
    pub(super) loops: Vec<[Vec<usize>; 2]>,
    /// In an action block: jumps to its end, as RETURN ends only the block on some controllers and the whole chart on
    /// others. None elsewhere.
    pub(super) ends: Option<Vec<usize>>,
    /// In an action: the bit that records that RETURN ended it. None elsewhere.
    pub(super) returned: Option<Cell>,
}

impl Lower<'_> {
    /// Lowers a routine of an instance and returns its first instruction.
    pub(super) fn routine(&mut self, instance: usize, entry: Entry) -> usize {
        let begin = self.builder.next();
        self.routines.known.insert((instance, entry), begin);
        if self.stands_in(instance, entry) {
            return begin;
        }
        self.note_bodiless(instance, entry);
        let tree = self.tree;
        let own = match entry {
            Entry::Body => self.instances[instance].unit,
            Entry::Routine(id) => tree.routine(id).unit,
        };
        let found = match entry {
            Entry::Routine(id) if tree.routine(id).kind != RoutineKind::Body => id,
            _ => self.body_in(own).unwrap_or(tree.unit(own).body),
        };
        let routine = tree.routine(found);
        let unit = tree.unit(routine.unit);
        self.file = unit.file;
        self.at(unit.line, &unit.name);
        self.landing();
        let frame = match routine.kind {
            RoutineKind::Method => self.frame(instance, found).ok(),
            RoutineKind::Body | RoutineKind::Action => None,
        };
        let context = Context { instance, frame };
        let inherits = routine.unit != own;
        let carries = match inherits {
            true => {
                self.any_bit("a block without a body may or may not execute the body of its base")
            }
            false => Logic::Const(true),
        };
        if routine.kind == RoutineKind::Body {
            self.begin_temporary(&context, own, routine.unit, &carries);
            self.edges_stay(&context, routine);
        }
        let inherited = inherits.then(|| self.jump(carries.not(), None));
        self.kept.values.clear();
        self.kept.extents.clear();
        let around = self.enter_routine(found);
        match &routine.code {
            Code::Statements(all) => {
                let is_action = routine.kind == RoutineKind::Action;
                let returned = is_action.then(|| self.returned(instance, found)).flatten();
                let mut targets = JumpTargets { returned, ..JumpTargets::default() };
                self.statements(&context, all, &mut targets);
            }
            Code::Chart(chart) => self.chart(&context, found, chart),
            Code::Unread(fault) => {
                let message = format!("{} ({})", fault.message, routine.language.name());
                self.fault(Fault { message, ..fault.clone() });
            }
        }
        self.leave(around);
        if let Some(inherited) = inherited {
            self.land(inherited);
        }
        self.landing();
        self.assembler().builder.add(None, Vec::new(), Step::Return);
        begin
    }

    /// Refuses a body of a block with inputs declared R_EDGE or F_EDGE if another block of the line of inheritance
    /// declares one, or if the body or what it calls writes one. The parser begins such a body with two statements for
    /// each input, which see its edge, and ends it with one that gives it the passed value again.
    fn edges_stay(&mut self, at: &Context, body: &Routine) {
        let tree = self.tree;
        let Instance { unit, spot } = self.instances[at.instance].clone();
        let inherited = tree.lineage(unit).into_iter().filter(|&one| one != body.unit);
        let inherited = inherited.flat_map(|one| edge_inputs(tree, one)).next();
        let inputs = edge_inputs(tree, body.unit);
        if inherited.is_none() && inputs.is_empty() {
            // Determining what a body changes takes as long as reading it.
            return;
        }
        let code = match &body.code {
            Code::Statements(all) if all.len() >= 3 * inputs.len() => {
                &all[2 * inputs.len()..all.len() - inputs.len()]
            }
            _ => &[],
        };
        let effects = self.found(|own, found| own.of_statements(at, code, found));
        let written = inputs.into_iter().find(|&id| {
            let mut own = Effects::default();
            let input = self.member(&spot, unit, id);
            input.iter().for_each(|input| add(&mut own.reads, input.tag.regions()));
            effects.changes(&own)
        });
        let (id, why) = match (inherited, written) {
            (Some(id), _) => (id, "a block with such an input is extended"),
            (None, Some(id)) => (id, "the body, or what it calls, writes the input"),
            (None, None) => return,
        };
        let (name, block) = (&tree.variable(id).name, &tree.unit(body.unit).name);
        let message = format!("edges of the input {name} are not followed in {block}: {why}");
        let help = "declare it without an edge, and call R_TRIG or F_TRIG yourself";
        let line = tree.unit(body.unit).line;
        self.fault(Fault::new(line, message).code(FaultCode::NotModelled).help(help));
    }

    /// Initialises the VAR_TEMP variables of the unit `own` and of its bases, as each execution of its body does. The
    /// unit `of` declares this body, and `carries` is whether it is executed. Controllers differ in whether they also
    /// initialise the variables of the other units.
    fn begin_temporary(&mut self, at: &Context, own: UnitId, of: UnitId, carries: &Logic) {
        let Instance { unit, spot } = self.instances[at.instance].clone();
        let tree = self.tree;
        let callee = Callee::Unit(spot.clone(), unit);
        if tree.unit(own).kind == PouKind::Function {
            return; // Its call initialises them.
        }
        let is_temp = |id: &VarId| tree.variable(*id).section == Section::Temp;
        for one in tree.lineage(own).into_iter().rev() {
            let all = tree.unit(one).variables.iter().copied();
            let all: Vec<VarId> = all.filter(is_temp).collect();
            if all.is_empty() {
                continue;
            }
            let mut begins = Vec::new();
            if one == of {
                begins.push(carries.clone());
            }
            if one == own {
                begins.push(carries.clone().not());
            }
            let skip = (begins.len() < 2).then(|| {
                begins.push(self.differs(ONLY_OWN_TEMPORARY).not());
                let parts = all.iter().filter_map(|&id| self.member(&spot, unit, id)).collect();
                self.any_value(parts);
                self.jump(Logic::Any(begins).not(), None)
            });
            if let Err(fault) = self.begin_anew(at, &callee, &all, None, tree.unit(unit).line) {
                self.fault(fault);
            }
            if let Some(skip) = skip {
                self.land(skip);
                self.landing();
            }
        }
    }

    /// Gives any value to these variables, but for references, of which only those known are followed.
    fn any_value(&mut self, all: Vec<Spot>) {
        for one in all.into_iter().filter(|one| !self.tree.has_reference(one.ty)) {
            let choice = self.builder.choice();
            let havoc = |region| always(Write::Havoc(region, choice));
            let effects = one.tag.regions().into_iter().map(havoc).collect();
            self.assembler().builder.add(None, effects, Step::Nothing);
        }
    }

    pub(super) fn statements(
        &mut self,
        at: &Context,
        all: &[Statement],
        targets: &mut JumpTargets,
    ) {
        for one in all {
            if self.is_late() {
                return;
            }
            self.at(one.line, &one.text);
            let counted = self.begin_counted(one);
            let done = self.statement(at, one, targets);
            self.end_statement(counted);
            if let Err(fault) = done {
                let fault = if fault.line == 0 { Fault { line: one.line, ..fault } } else { fault };
                let fault = fault.within(&self.instances[at.instance].spot.name);
                self.fault(fault);
            }
        }
    }

    fn statement(
        &mut self,
        at: &Context,
        one: &Statement,
        targets: &mut JumpTargets,
    ) -> Result<(), Fault> {
        let line = one.line;
        match &one.kind {
            StatementKind::Assign(target, value) if Self::is_referred(target) => {
                self.stays(at, target, value, line)?;
                self.through(at, target, one, targets, &|place| {
                    StatementKind::Assign(place, value.clone())
                })
            }
            StatementKind::Latch(target, set, condition) if Self::is_referred(target) => {
                self.stays(at, target, condition, line)?;
                self.through(at, target, one, targets, &|place| {
                    StatementKind::Latch(place, *set, condition.clone())
                })
            }
            StatementKind::Copy(target, from) if Self::is_referred(target) => {
                self.stays(at, target, &reading(from, line), line)?;
                self.through(at, target, one, targets, &|place| {
                    StatementKind::Copy(place, from.clone())
                })
            }
            StatementKind::Copy(target, from) if Self::is_referred(from) => {
                self.stays(at, from, &reading(target, line), line)?;
                self.through(at, from, one, targets, &|place| {
                    StatementKind::Copy(target.clone(), place)
                })
            }
            StatementKind::Assign(target, value) => {
                let value = value.unconverted();
                if self.moves_element(at, target, value) && self.tree.types.is_reference(target.ty)
                {
                    let what =
                        format!("the value may change which variable {} refers to", target.text);
                    let help = "assign the value to a separate variable first";
                    return Err(Fault::new(line, what).code(FaultCode::NotModelled).help(help));
                }
                if self.moves_element(at, target, value) {
                    return self.assign_either_way(at, target, value, line);
                }
                let found = self.open_value(at, value)?;
                self.assign(at, target, Some(value), found, line)
            }
            StatementKind::Keep(id, value) => {
                let found = self.open_value(at, value)?;
                self.keep(*id, Some(value), found);
                Ok(())
            }
            StatementKind::Copy(target, from) => {
                let from = self.find(at, from, line)?;
                let to = self.find(at, target, line)?;
                self.are_of_one_type(&from, &to, line)?;
                let key = self.store_key(&to, None, line)?;
                self.copy(&from, &to, key);
                Ok(())
            }
            StatementKind::Latch(target, set, condition) => {
                self.latched(at, target, *set, condition, line)
            }
            StatementKind::Call(call) => self.call_statement(at, call, line),
            StatementKind::Standard(applied) => self.applied(at, applied, line).map(|_| ()),
            StatementKind::CallIf(condition, inner) => {
                let enable = self.bit(at, condition)?;
                let skip = self.jump(enable.not(), Assembler::jump_key());
                let done = self.statement(at, inner, targets);
                self.land(skip);
                self.landing();
                done
            }
            StatementKind::After(both) => {
                let behind = std::slice::from_ref(&both.1);
                let then = self.found(|own, found| own.of_statements(at, behind, found));
                self.call_before(at, &both.0, &then, line)?;
                self.statement(at, &both.1, targets)
            }
            StatementKind::Foreign(stated) => self.foreign(at, stated, line),
            StatementKind::If(arms, otherwise) => self.conditional(at, arms, otherwise, targets),
            StatementKind::Case(of, arms, otherwise) => {
                self.case(at, of, arms, otherwise, line, targets)
            }
            StatementKind::For(own) => self.counted_loop(at, own, line, targets),
            StatementKind::While(condition, body) => {
                self.while_true(at, condition, body, line, targets)
            }
            StatementKind::Repeat(body, until) => self.repeated(at, body, until, line, targets),
            StatementKind::Exit | StatementKind::Continue => {
                let jump = self.jump(Logic::Const(true), Assembler::jump_key());
                let side = usize::from(matches!(one.kind, StatementKind::Exit));
                match targets.loops.last_mut() {
                    Some(inner) => inner[side].push(jump),
                    None => {
                        return Err(Fault::new(line, "EXIT or CONTINUE is outside of any loop"));
                    }
                }
                Ok(())
            }
            StatementKind::Return(condition) => {
                let returns = self.bit(at, condition)?;
                let stay = self.jump(returns.not(), None);
                if let Some(cell) = targets.returned {
                    self.write(vec![set(cell, Logic::Const(true))]);
                }
                let key = Some(Assembler::key(&["RET"], "jump"));
                if let Some(ends) = &mut targets.ends {
                    let whole = self.differs(ENDS_CHART);
                    ends.push(self.jump(whole.not(), key));
                    self.assembler().builder.add(None, Vec::new(), Step::Return);
                } else {
                    self.assembler().builder.add(key, Vec::new(), Step::Return);
                }
                self.land(stay);
                self.landing();
                Ok(())
            }
            StatementKind::Jump(condition, label) => {
                let fires = self.bit(at, condition)?;
                let jump = self.jump(fires, Assembler::jump_key());
                targets.labels.entry(*label).or_default().push(jump);
                Ok(())
            }
            StatementKind::Label(label) => {
                for jump in targets.labels.remove(label).unwrap_or_default() {
                    self.land(jump);
                }
                self.landing();
                Ok(())
            }
            StatementKind::Either(what, first, second) => {
                self.either_of(at, what, (first, second), targets);
                Ok(())
            }
            StatementKind::Nothing => Ok(()),
            StatementKind::Fault(fault) => Err((**fault).clone()),
        }
    }

    /// Lowers code of another language (a pragma): it takes the time that the user states, and gives any value to the
    /// variables that it is stated to write.
    fn foreign(&mut self, at: &Context, stated: &Stated, line: u32) -> Result<(), Fault> {
        let entry = self.assembler().builder.add(None, Vec::new(), Step::Nothing);
        self.takes_stated_time(entry, stated);
        for place in &stated.writes {
            let place = place.as_ref().map_err(Clone::clone)?;
            let name = &place.text;
            let Some(spot) = self.spot(at, place, line)? else {
                let told =
                    format!("{name}, which the pragma is stated to write, is not a variable");
                let help = "name variables of the unit";
                return Err(Fault::new(line, told).code(FaultCode::Fact).help(help));
            };
            let effects = spot.tag.regions().into_iter().map(|region| {
                let choice = self.builder.choice();
                always(Write::Havoc(region, choice))
            });
            let effects = effects.collect();
            let entry = self.assembler().builder.add(None, effects, Step::Nothing);
            let why = format!(
                "what the pragma writes to {name} may be any value: only its time is stated"
            );
            self.program().approximate(entry, why);
        }
        Ok(())
    }

    /// Lowers a statement once for each variable that the reference in `place` may point to. `kind` builds the
    /// statement for one of them.
    fn through(
        &mut self,
        at: &Context,
        place: &Place,
        of: &Statement,
        targets: &mut JumpTargets,
        kind: &dyn Fn(Place) -> StatementKind,
    ) -> Result<(), Fault> {
        let done = self.each_target(at, place, of.line, &mut |own, place| {
            let one = Statement { kind: kind(place), ..of.clone() };
            own.statement(at, &one, targets).map(|()| Value::Any)
        });
        done.map(|_| ())
    }

    /// Executes one of two bodies that have the same statements in different orders. The statements are counted once.
    fn either_of(
        &mut self,
        at: &Context,
        what: &'static str,
        (first, second): (&[Statement], &[Statement]),
        targets: &mut JumpTargets,
    ) {
        let which = self.differs(what);
        let number = self.tally.current.map(|current| current.next);
        let skip = self.jump(which.not(), None);
        self.statements(at, first, targets);
        let end = self.jump(Logic::Const(true), None);
        self.land(skip);
        self.landing();
        if let (Some(current), Some(number)) = (self.tally.current.as_mut(), number) {
            current.next = number;
        }
        self.statements(at, second, targets);
        self.land(end);
        self.landing();
    }

    fn latched(
        &mut self,
        at: &Context,
        target: &Place,
        set: bool,
        condition: &Expr,
        line: u32,
    ) -> Result<(), Fault> {
        if target.indices().any(Expr::calls) || self.moves_element(at, target, condition) {
            let told = "which element is set may change while its value is evaluated";
            let help = "assign the value to a separate variable first";
            return Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help));
        }
        // The element is also looked up before the condition, because its type is needed; both look-ups are charged.
        self.find(at, target, line)?;
        let fires = self.bit(at, condition)?;
        let found = self.find(at, target, line)?;
        let writes = self.writes(found, Value::Bit(Logic::Const(set)), line)?;
        let row = if set { "S" } else { "R" };
        self.write_if(fires, writes, Some(Assembler::key(&[row], "coil")));
        Ok(())
    }

    /// Lowers IF: each branch tests its condition and jumps to the next branch where it is false.
    fn conditional(
        &mut self,
        at: &Context,
        arms: &[(Expr, Vec<Statement>)],
        otherwise: &[Statement],
        targets: &mut JumpTargets,
    ) -> Result<(), Fault> {
        let mut ends = Vec::new();
        for (number, (condition, body)) in arms.iter().enumerate() {
            let holds = self.bit(at, condition)?;
            let skip = self.jump(holds.not(), Assembler::jump_key());
            let before = self.kept.values.clone();
            self.statements(at, body, targets);
            // A temporary that only one branch sets keeps its earlier value on the other, or has none.
            self.kept.values.extend(before);
            if number + 1 < arms.len() || !otherwise.is_empty() {
                ends.push(self.jump(Logic::Const(true), Assembler::jump_key()));
            }
            self.land(skip);
            self.landing();
        }
        self.statements(at, otherwise, targets);
        self.leave_loop(ends);
        Ok(())
    }

    fn case(
        &mut self,
        at: &Context,
        of: &Expr,
        arms: &[(Vec<Selector>, Vec<Statement>)],
        otherwise: &[Statement],
        line: u32,
        targets: &mut JumpTargets,
    ) -> Result<(), Fault> {
        let mut value = self.value(at, of)?;
        self.give_type(&mut value, of);
        let kind = match &value {
            Value::Number(kind, _) => *kind,
            _ => DINT,
        };
        let number = self.as_number(value, kind);
        // A variable is not copied: no arm is executed before another's selectors are compared.
        let words = self.words(number, kind.words());
        let mut ends = Vec::new();
        for (selectors, body) in arms {
            let mut fits = Vec::new();
            for selector in selectors {
                let own = || Value::Number(kind, Number::Words(words.clone()));
                fits.push(self.fits(at, &own, selector, line)?);
            }
            let skip = self.jump(Logic::Any(fits).not(), Assembler::jump_key());
            self.statements(at, body, targets);
            ends.push(self.jump(Logic::Const(true), Assembler::jump_key()));
            self.land(skip);
            self.landing();
        }
        self.statements(at, otherwise, targets);
        self.leave_loop(ends);
        Ok(())
    }

    fn fits(
        &mut self,
        at: &Context,
        own: &dyn Fn() -> Value,
        selector: &Selector,
        line: u32,
    ) -> Result<Logic, Fault> {
        let low = self.value(at, &selector.low)?;
        let found = match &selector.high {
            None => self.combined(Operator::Equal, own(), low, line)?,
            Some(high) => {
                let high = self.value(at, high)?;
                let above = self.combined(Operator::GreaterOrEqual, own(), low, line)?;
                let below = self.combined(Operator::LessOrEqual, own(), high, line)?;
                self.combined(Operator::And, above, below, line)?
            }
        };
        Ok(match found {
            Value::Bit(logic) => logic,
            _ => Logic::Const(false),
        })
    }

    /// The variable at a place. None if it is a bit of a word, or an element whose index is not constant.
    pub(super) fn spot(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
    ) -> Result<Option<super::spots::Spot>, Fault> {
        Ok(match self.find(at, place, line)? {
            Found::Spot(spot) => Some(spot),
            _ => None,
        })
    }
}

/// The inputs of a unit that are declared R_EDGE or F_EDGE.
fn edge_inputs(tree: &Tree, unit: UnitId) -> Vec<VarId> {
    let is_input = |id: &VarId| {
        let one = tree.variable(*id);
        one.section == Section::Input && one.has_edge
    };
    tree.unit(unit).variables.iter().copied().filter(is_input).collect()
}

/// An expression that reads a place.
fn reading(place: &Place, line: u32) -> Expr {
    Expr { ty: place.ty, kind: ExprKind::Read(place.clone()), line }
}

//! Lowers calls: pass the arguments, execute the routine, and take the results.

use super::aliases::written_by;
use super::cells::{Effects, add};
use super::elements::unknown_number;
use super::enable::Enabled;
use super::spots::{Callee, Context, Found, Spot};
use super::values::shown;
use super::{Entry, Lower};
use crate::assembler::Assembler;
use crate::assembler::types::Ty;
use crate::assembler::value::{Value, constant};
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::Section;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::accesses::{self, Accesses};
use scanbound_iec_tree::blocks::{Pin, StandardBlock};
use scanbound_iec_tree::charts::StepFlag;
use scanbound_iec_tree::declarations::{First, RoutineId, VarId};
use scanbound_iec_tree::tree::{
    Call, Expr, ExprKind, Parameter, Passed, Place, Root, Step as PathStep, Target, Tree,
};
use scanbound_iec_tree::types::Type as Typed;
use scanbound_ir::{Logic, Number, Step, TimingKey};

impl Lower<'_> {
    /// Lowers a call and returns its result. [`Value::Any`] if it has none, or if its content is not modelled.
    pub(super) fn called(&mut self, at: &Context, call: &Call, line: u32) -> Result<Value, Fault> {
        self.called_for(at, call, true, line)
    }

    /// Lowers a call. Returns its result if `is_asked`, else [`Value::Any`].
    fn called_for(
        &mut self,
        at: &Context,
        call: &Call,
        is_asked: bool,
        line: u32,
    ) -> Result<Value, Fault> {
        let found = self.called_here(at, call, is_asked, line)?;
        Ok(if is_asked { found } else { Value::Any })
    }

    fn called_here(
        &mut self,
        at: &Context,
        call: &Call,
        is_asked: bool,
        line: u32,
    ) -> Result<Value, Fault> {
        let tree = self.tree;
        if let Target::Method(place, _) = &call.target {
            self.index_stays(at, place, call, line)?;
        }
        if let Some(found) = self.called_through(at, call, is_asked, line)? {
            return Ok(found);
        }
        match &call.target {
            Target::Function(unit) => {
                let instance = self.function_instance(*unit)?;
                let spot = self.instances[instance].spot.clone();
                let callee = Callee::Unit(spot.clone(), *unit);
                let entry = (instance, Entry::Body);
                self.has_one_name(at, entry, call, line)?;
                let inner = Context { instance, frame: None };
                let variables = tree.unit(*unit).variables.clone();
                let inputs = self.begin_arguments(at, &callee, call, line)?;
                self.hand_over(at, &callee, call, line)?;
                self.begin_anew(&inner, &callee, &variables, Some(call), line)?;
                let enabled = self.begin_body(inputs, called());
                self.call(instance, Entry::Body);
                self.take_back(at, &callee, call, line)?;
                self.end_call(at, &callee, enabled, call, tree.unit(*unit).result, line)
            }
            Target::Method(owner, method) => {
                if let Some(found) = self.each_instance(at, owner, line, &mut |own, place| {
                    let target = Target::Method(place, *method);
                    let call = Call { target, ..call.clone() };
                    own.called_for(at, &call, is_asked, line)
                })? {
                    return Ok(found);
                }
                let instance = self.instance_of(at, owner, line)?;
                let method = tree.dispatched(self.instances[instance].unit, *method);
                self.method(at, instance, method, call, line)
            }
            Target::BaseMethod(method) => self.method(at, at.instance, *method, call, line),
            _ => self.call_statement(at, call, line).map(|()| Value::Any),
        }
    }

    /// Lowers a call whose result is only used in part, by code with the effects `then`. A fault if that code, or the
    /// call itself, may change which result is meant before it is used.
    pub(super) fn call_before(
        &mut self,
        at: &Context,
        call: &Call,
        then: &Effects,
        line: u32,
    ) -> Result<(), Fault> {
        let tree = self.tree;
        let (mut own, mut looked, mut called) =
            (Effects::default(), Effects::default(), Effects::default());
        let frames: Vec<(usize, RoutineId)> = match &call.target {
            Target::Method(owner, method) => {
                self.led_to(at, owner, &mut looked);
                let all = self.instances_at(at, owner, &mut Effects::default()).into_iter();
                all.map(|one| (one, tree.dispatched(self.instances[one].unit, *method))).collect()
            }
            Target::BaseMethod(method) => vec![(at.instance, *method)],
            _ => Vec::new(),
        };
        for (instance, method) in frames {
            add(&mut own.reads, self.frame(instance, method)?.tag.regions());
        }
        self.of_call(at, call, &mut called);
        if then.changes(&own) || called.changes(&looked) {
            let told = "the result of a property may change before a part of it is read or written";
            let help =
                "assign the result to a separate variable, and use the part of that variable";
            return Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help));
        }
        self.called_for(at, call, false, line).map(|_| ())
    }

    fn method(
        &mut self,
        at: &Context,
        instance: usize,
        method: RoutineId,
        call: &Call,
        line: u32,
    ) -> Result<Value, Fault> {
        let tree = self.tree;
        let entry = Entry::Routine(method);
        let call = &self.passed_to_own(method, call, line)?;
        self.is_one_method(instance, method, line)?;
        if instance != at.instance {
            self.member_names_handed((instance, entry), line)?;
        }
        let frame = self.frame(instance, method)?;
        let callee = Callee::Method(frame.clone(), method);
        self.has_one_name(at, (instance, entry), call, line)?;
        let inputs = self.begin_arguments(at, &callee, call, line)?;
        self.hand_over(at, &callee, call, line)?;
        let inner = Context { instance, frame: Some(frame) };
        let variables = tree.routine(method).variables.clone();
        self.begin_anew(&inner, &callee, &variables, Some(call), line)?;
        let enabled = self.begin_body(inputs, called());
        self.call(instance, entry);
        self.take_back(at, &callee, call, line)?;
        self.end_call(at, &callee, enabled, call, tree.routine(method).result, line)
    }

    /// The call with its parameters replaced by those of the overriding method that is executed. A fault if that method
    /// lacks a parameter, or if the call omits a VAR_IN_OUT argument.
    fn passed_to_own(&self, method: RoutineId, call: &Call, line: u32) -> Result<Call, Fault> {
        let tree = self.tree;
        let mut call = call.clone();
        for (parameter, _) in &mut call.passed {
            let Parameter::Variable(id) = parameter else { continue };
            let Some(own) = tree.counterpart(method, *id) else {
                let told =
                    format!("{} takes no {}", tree.routine(method).name, tree.variable(*id).name);
                return Err(Fault::new(line, told).code(FaultCode::UnknownName));
            };
            *id = own;
        }
        let is_given =
            |id: &VarId| call.passed.iter().any(|(own, _)| *own == Parameter::Variable(*id));
        let mut all = tree.routine(method).variables.iter();
        match all.find(|id| tree.variable(**id).section == Section::InOut && !is_given(id)) {
            None => Ok(call),
            Some(id) => {
                let name = &tree.variable(*id).name;
                let told = format!("this call does not pass the VAR_IN_OUT parameter {name}");
                let help =
                    "pass it in every call: controllers differ in what a call without it does";
                Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help))
            }
        }
    }

    /// Refuses a call of a method whose name a base unit also has as a PRIVATE method. In the third edition of the
    /// standard, the base's own calls mean that one; not all controllers do so.
    fn is_one_method(&self, instance: usize, method: RoutineId, line: u32) -> Result<(), Fault> {
        let tree = self.tree;
        let own = tree.routine(method);
        let units = tree.lineage(self.instances[instance].unit).into_iter();
        let methods = units.flat_map(|unit| &tree.unit(unit).methods);
        let methods = methods.map(|&one| tree.routine(one)).filter(|one| one.slot == own.slot);
        if !{ methods }.skip(1).any(|one| one.is_private) {
            return Ok(());
        }
        let told = format!(
            "{} is also a PRIVATE method of a base: controllers differ in which one they call",
            own.name
        );
        let help = "give one of the two another name";
        Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help))
    }

    /// Lowers a call through a reference, as a call of each instance that the reference may point to. Returns the
    /// result, or None if the call uses no reference.
    fn called_through(
        &mut self,
        at: &Context,
        call: &Call,
        is_asked: bool,
        line: u32,
    ) -> Result<Option<Value>, Fault> {
        let (Target::Instance(place, _)
        | Target::Standard(place, _)
        | Target::Action(place, _)
        | Target::Method(place, _)) = &call.target
        else {
            return Ok(None);
        };
        if !Self::is_referred(place) {
            return Ok(None);
        }
        self.each_target(at, place, line, &mut |own, place| {
            let target = match &call.target {
                Target::Standard(_, block) => Target::Standard(place, *block),
                Target::Action(_, action) => Target::Action(place, *action),
                Target::Method(_, method) => Target::Method(place, *method),
                _ => {
                    let unit = own.root_unit(at, place.root).filter(|_| place.steps.is_empty());
                    let unit = unit.or_else(|| own.unit_of(place.ty));
                    Target::Instance(place, unit.ok_or_else(|| unknown_number(line))?)
                }
            };
            own.called_for(at, &Call { target, ..call.clone() }, is_asked, line)
        })
    }

    /// Completes a call of a function or method: sets ENO and returns the result.
    fn end_call(
        &mut self,
        at: &Context,
        callee: &Callee,
        enabled: Option<Enabled>,
        call: &Call,
        result: Option<VarId>,
        line: u32,
    ) -> Result<Value, Fault> {
        let result = match result {
            Some(id) => match self.parameter(callee, Parameter::Variable(id)) {
                Some(spot) => self.result(&spot),
                None => Value::Any,
            },
            None => Value::Any,
        };
        let outputs = self.outputs(call);
        let enable = self.end_enabled(at, enabled, &call.enable, (&outputs, None), line)?;
        Ok(self.result_if(enable, result))
    }

    fn result(&mut self, spot: &Spot) -> Value {
        if spot.tag.cell().is_none() {
            return Value::Any;
        }
        // The result is copied, since another call may follow in the same expression.
        match self.read_spot(spot) {
            value @ Value::Address(..) => self.frozen(value),
            Value::Bit(logic) => Value::Bit(self.keep_bit(logic)),
            Value::Number(kind, number) => {
                let zero = constant(0, kind.words());
                let sum = Number::Add(Box::new(number), Box::new(zero));
                let words = self.words(sum, kind.words());
                Value::Number(kind, Number::Words(words))
            }
            other => other,
        }
    }

    /// Lowers a call that is a statement: its result, if any, is not used.
    pub(super) fn call_statement(
        &mut self,
        at: &Context,
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        let tree = self.tree;
        if let Target::Instance(place, _) | Target::Standard(place, _) | Target::Action(place, _) =
            &call.target
        {
            self.index_stays(at, place, call, line)?;
        }
        if self.called_through(at, call, false, line)?.is_some() {
            return Ok(());
        }
        if let Target::Action(..) | Target::BaseBody(_) | Target::Program(..) = &call.target
            && call.enable.is_given()
        {
            let told = "EN and ENO of an action, of a program or of SUPER^ are not modelled";
            let help = "call it within IF";
            return Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help));
        }
        let retargeted = |target: Target| Call { target, ..call.clone() };
        match &call.target {
            Target::Function(_) | Target::Method(..) | Target::BaseMethod(_) => {
                self.called_for(at, call, false, line).map(|_| ())
            }
            Target::Instance(place, unit) => {
                if self.one_of(at, place, line, &mut |own, place| {
                    own.call_statement(at, &retargeted(Target::Instance(place, *unit)), line)
                })? {
                    return Ok(());
                }
                let instance = self.instance_of(at, place, line)?;
                let spot = self.instances[instance].spot.clone();
                let callee = Callee::Unit(spot, *unit);
                self.has_one_name(at, (instance, Entry::Body), call, line)?;
                let inputs = self.begin_arguments(at, &callee, call, line)?;
                self.hand_over(at, &callee, call, line)?;
                let enabled = self.begin_body(inputs, called());
                self.call(instance, Entry::Body);
                self.take_back(at, &callee, call, line)?;
                let outputs = self.outputs(call);
                self.end_enabled(at, enabled, &call.enable, (&outputs, None), line).map(|_| ())
            }
            Target::Standard(place, block) => {
                if self.one_of(at, place, line, &mut |own, place| {
                    own.call_statement(at, &retargeted(Target::Standard(place, *block)), line)
                })? {
                    return Ok(());
                }
                let Found::Spot(spot) = self.find(at, place, line)? else {
                    return Err(unknown_number(line));
                };
                self.standard_called(at, spot, *block, call, line)
            }
            Target::Program(place, unit) => {
                let instance = self.instance_of(at, place, line)?;
                let callee = Callee::Unit(self.instances[instance].spot.clone(), *unit);
                self.has_one_name(at, (instance, Entry::Body), call, line)?;
                self.hand_over(at, &callee, call, line)?;
                self.call(instance, Entry::Body);
                self.take_back(at, &callee, call, line)
            }
            Target::Action(place, action) => {
                if self
                    .each_instance(at, place, line, &mut |own, place| {
                        let call = retargeted(Target::Action(place, *action));
                        own.call_statement(at, &call, line).map(|()| Value::Any)
                    })?
                    .is_some()
                {
                    return Ok(());
                }
                let instance = self.instance_of(at, place, line)?;
                let unit = self.instances[instance].unit;
                let entry = Entry::Routine(tree.dispatched(unit, *action));
                if instance != at.instance {
                    self.member_names_handed((instance, entry), line)?;
                }
                let callee = Callee::Unit(self.instances[instance].spot.clone(), unit);
                self.has_one_name(at, (instance, entry), call, line)?;
                self.hand_over(at, &callee, call, line)?;
                self.call(instance, entry);
                self.take_back(at, &callee, call, line)
            }
            Target::BaseBody(base) => {
                let unit = self.instances[at.instance].unit;
                let callee = Callee::Unit(self.instances[at.instance].spot.clone(), unit);
                let entry = Entry::Routine(tree.unit(*base).body);
                self.has_one_name(at, (at.instance, entry), call, line)?;
                self.hand_over(at, &callee, call, line)?;
                self.call(at.instance, entry);
                self.take_back(at, &callee, call, line)
            }
        }
    }

    fn standard_called(
        &mut self,
        at: &Context,
        spot: Spot,
        block: StandardBlock,
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        let callee = Callee::Standard(spot.clone(), block);
        let mut within = Effects::default();
        add(&mut within.writes, spot.tag.regions());
        self.outputs_stay(at, &written_by(call), call.given(), within, line)?;
        let inputs = self.begin_arguments(at, &callee, call, line)?;
        self.hand_over(at, &callee, call, line)?;
        let enabled = self.begin_body(inputs, Assembler::block_key(block));
        let cell = |pin: Pin| spot.tag.part_at(block.position(pin)?)?.cell();
        let is_given = |pin| call.passed.iter().any(|(own, _)| *own == Parameter::Pin(pin));
        if !is_given(Pin::Pt) {
            self.presets_left.extend(cell(Pin::Pt));
        }
        self.standard_block(block, &cell);
        self.take_back(at, &callee, call, line)?;
        let outputs = self.outputs(call);
        self.end_enabled(at, enabled, &call.enable, (&outputs, None), line).map(|_| ())
    }

    /// The index of the function block instance at a place. A fault if its array index is not known.
    pub(super) fn instance_of(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
    ) -> Result<usize, Fault> {
        match self.find(at, place, line)? {
            Found::Spot(spot) => {
                let unit = self.unit_of(spot.ty).ok_or_else(|| unknown_number(line))?;
                Ok(self.instance(&spot, unit))
            }
            _ => Err(unknown_number(line)),
        }
    }

    /// Adds a call of a routine of an instance. Its target is set when the routine is lowered.
    pub(super) fn call(&mut self, instance: usize, entry: Entry) {
        self.call_as(called(), instance, entry);
    }

    pub(super) fn call_as(&mut self, key: TimingKey, instance: usize, entry: Entry) {
        let fires = Logic::Const(true);
        let step = Step::Call { fires, target: 0 };
        let at = self.assembler().builder.add(Some(key), Vec::new(), step);
        self.routines.open.push((at, instance, entry));
    }

    /// The memory place of a parameter of what is called. None if it has none.
    pub(super) fn parameter(&mut self, callee: &Callee, one: Parameter) -> Option<Spot> {
        match (callee, one) {
            (Callee::Unit(spot, unit), Parameter::Variable(id)) => self.member(spot, *unit, id),
            (Callee::Method(frame, method), Parameter::Variable(id)) => {
                self.local(frame, *method, id)
            }
            (Callee::Standard(spot, _), Parameter::Pin(pin)) => {
                self.stepped(spot, None, &PathStep::Pin(pin))
            }
            _ => None,
        }
    }

    /// Passes the arguments of a call. All are evaluated before any is passed, because one argument may call the block
    /// that receives the others.
    fn hand_over(
        &mut self,
        at: &Context,
        callee: &Callee,
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        self.passes_in_any_order(at, callee, call, line)?;
        let calls_any = call.values().any(|one| one.calls());
        self.evaluates_in_two_orders(at, call, line)?;
        let (mut one_way, mut both) = (Vec::new(), Vec::new());
        for (parameter, passed) in &call.passed {
            let Some(target) = self.parameter(callee, *parameter) else { continue };
            match passed {
                Passed::ByValue(one) => one_way.push((target, one.unconverted())),
                // VAR_IN_OUT arguments are evaluated last: they have the values that the other arguments leave.
                Passed::InOut(one) => {
                    self.has_known_length(&target, one)?;
                    both.push((target, one.unconverted()));
                }
                Passed::Output(..) | Passed::Dropped => {}
            }
        }
        let (mut found, mut wholes) = (Vec::new(), Vec::new());
        for (group, is_both) in [(one_way, false), (both, true)] {
            if !calls_any {
                for (target, one) in group {
                    if let Some(from) = self.whole(at, one, line)? {
                        wholes.push((from, Found::Spot(target), is_both));
                        continue;
                    }
                    let value = self.open_value(at, one)?;
                    let ty = self.simple(&target);
                    found.push((target, shown(one, value, &ty), is_both, one));
                }
                continue;
            }
            for (_, value, ..) in &mut found {
                let earlier = std::mem::replace(value, Value::Any);
                *value = self.frozen(earlier);
            }
            let exprs: Vec<&Expr> = group.iter().map(|(_, one)| *one).collect();
            let values = self
                .operands(at, &exprs, line, &mut |own, which| own.open_value(at, exprs[which]))?;
            for ((target, one), value) in group.into_iter().zip(values) {
                let ty = self.simple(&target);
                found.push((target, shown(one, value, &ty), is_both, one));
            }
        }
        for (from, target, is_both) in wholes {
            self.are_of_one_type(&from, &target, line)?;
            let key = match is_both {
                // For VAR_IN_OUT, the PLC passes an address: one store.
                true => Assembler::key(&["ST"], "move"),
                false => self.store_key(&target, None, line)?,
            };
            self.copy(&from, &target, key);
        }
        for (target, value, is_both, of) in found {
            let target = Found::Spot(target);
            let key = match is_both {
                true => Assembler::key(&["ST"], "move"),
                false => self.store_key(&target, Some(of), line)?,
            };
            let writes = self.writes(target, value, line)?;
            self.add_always(key, writes);
        }
        Ok(())
    }

    /// Refuses a text that is calculated for a VAR_IN_OUT CONSTANT parameter: it may be longer than declared.
    fn has_known_length(&self, target: &Spot, one: &Expr) -> Result<(), Fault> {
        let is_text = matches!(self.tree.types.get(target.ty), Typed::Text(_));
        if !is_text || !matches!(one.unconverted().kind, ExprKind::Standard(_)) {
            return Ok(());
        }
        let told =
            format!("{} is VAR_IN_OUT and gets a calculated text of any length", target.name);
        let help = "assign the text to a variable first, and pass this";
        Err(Fault::new(one.line, told).code(FaultCode::NotModelled).help(help))
    }

    /// The place of an expression that names a whole structure, array or instance. None for any other expression.
    fn whole(&mut self, at: &Context, one: &Expr, line: u32) -> Result<Option<Found>, Fault> {
        let ExprKind::Read(place) = &one.kind else { return Ok(None) };
        if let scanbound_iec_tree::tree::Root::Temporary(_) = place.root {
            return Ok(None);
        }
        let is_whole = matches!(
            self.tree.types.get(place.ty),
            Typed::Array(..) | Typed::Struct(_) | Typed::Standard(_) | Typed::Block(_)
        );
        if !is_whole {
            return Ok(None);
        }
        self.find(at, place, line).map(Some)
    }

    /// After a call: copies VAR_IN_OUT arguments back to the caller's variables, then assigns the outputs.
    fn take_back(
        &mut self,
        at: &Context,
        callee: &Callee,
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        // A VAR_IN_OUT argument is the caller's own variable, so it has its new value before any output is taken.
        for is_both in [true, false] {
            for (parameter, passed) in &call.passed {
                let (target, negated) = match (passed, is_both) {
                    (Passed::InOut(one), true) => match &one.unconverted().kind {
                        ExprKind::Read(place) => (place, false),
                        _ => continue,
                    },
                    (Passed::Output(place, negated), false) => (place, *negated),
                    _ => continue,
                };
                let Some(from) = self.parameter(callee, *parameter) else { continue };
                let begin = self.builder.next();
                if let (Callee::Standard(_, block), Parameter::Pin(Pin::Cv | Pin::Pv)) =
                    (callee, parameter)
                    && block.is_counter()
                {
                    let cell = from.tag.cell();
                    self.counts.extend(cell);
                }
                if from.tag.cell().is_some() {
                    let mut value = self.read_spot(&from);
                    if let (Value::Bit(logic), true) = (&value, negated) {
                        value = Value::Bit(logic.clone().not());
                    }
                    self.cost(&["LD"], "contact");
                    self.assign(at, target, None, value, line)?;
                } else {
                    let to = self.find(at, target, line)?;
                    let key = match is_both {
                        true => Assembler::key(&["ST"], "move"),
                        false => self.store_key(&to, None, line)?,
                    };
                    self.copy(&Found::Spot(from), &to, key);
                }
                if is_both {
                    let range = begin..self.builder.next();
                    let file = self.file;
                    self.given_back.push((range, file, line));
                }
            }
        }
        Ok(())
    }

    /// Initialises those of these variables that are set again at each call: locals, outputs and inputs that the call
    /// does not pass. Each gets its declared initial value, or else 0.
    pub(super) fn begin_anew(
        &mut self,
        at: &Context,
        callee: &Callee,
        variables: &[VarId],
        call: Option<&Call>,
        line: u32,
    ) -> Result<(), Fault> {
        let is_given = |id: VarId| {
            let passed = call.map_or(&[][..], |call| &call.passed);
            passed.iter().any(|(own, _)| *own == Parameter::Variable(id))
        };
        let tree = self.tree;
        for &id in variables {
            let one = tree.variable(id);
            if one.section == Section::Local && one.constant {
                self.begins_without_call(id, &[], line)?;
            }
        }
        for (place, &id) in variables.iter().enumerate() {
            let one = tree.variable(id);
            let begins = match one.section {
                // Constants of a unit have their declared values at all times.
                Section::Local | Section::Temp | Section::Output => {
                    !one.constant || at.frame.is_some()
                }
                Section::Input => !is_given(id),
                _ => false,
            };
            let spot = match begins {
                true => self.parameter(callee, Parameter::Variable(id)),
                false => None,
            };
            let Some(spot) = spot else { continue };
            self.begins_plain(&spot, one.initial.is_some(), line)?;
            self.begins_without_call(id, &variables[place..], line)?;
            let is_bit = matches!(self.simple(&spot), Ty::Bit);
            let value = match &one.initial {
                None if self.tree.types.is_reference(spot.ty) => Value::Constant(0),
                Some(initial) if self.tree.types.is_reference(spot.ty) => {
                    self.open_value(at, initial)?
                }
                Some(initial) => match (&initial.kind, initial.whole()) {
                    (_, Some(known)) => Value::Constant(known),
                    (ExprKind::Bool(on), _) if is_bit => Value::Bit(Logic::Const(*on)),
                    _ if is_worked_out(initial) && spot.tag.cell().is_some() => {
                        let from = self.builder.next();
                        let found = self.open_value(at, initial)?;
                        if one.constant {
                            self.charge_nothing(from);
                        }
                        let ty = self.simple(&spot);
                        shown(initial, found, &ty)
                    }
                    _ => Value::Any,
                },
                None => match one.first {
                    First::Zero => Value::Constant(0),
                    First::Number(number) => Value::Constant(number),
                    First::Unknown => Value::Any,
                },
            };
            self.forget(&spot, line)?;
            let key = (!one.constant).then(|| self.begin_key(spot.ty));
            let writes = self.writes(Found::Spot(spot), value, line)?;
            let effects = writes.into_iter().map(scanbound_front::builder::always).collect();
            self.assembler().builder.add(key, effects, Step::Nothing);
        }
        Ok(())
    }

    /// Refuses a variable that is initialised at each call if that cannot be modelled: it has an initialisation method
    /// (FB_Init), which takes time in each call, or it holds references together with an initial value or instances.
    fn begins_plain(&self, spot: &Spot, given: bool, line: u32) -> Result<(), Fault> {
        let holds = !self.tree.types.is_reference(spot.ty)
            && self.tree.has_reference(spot.ty)
            && (given || self.instances_of(spot.ty) > 0);
        if !self.begins_with_method(spot.ty) && !holds {
            return Ok(());
        }
        let what = format!(
            "{} begins anew with each call, which is not modelled for this type",
            spot.name
        );
        let help = "declare it as VAR of a function block or of a program";
        Err(Fault::new(line, what).code(FaultCode::NotModelled).help(help))
    }

    /// Refuses a variable that is initialised at each call if its type or its initial value has calls or reads that
    /// take time then. The initial value of one non-constant elementary or text variable may have them, except calls
    /// and reads of variables for an input, since controllers may evaluate it before or after the arguments that are
    /// given, and reads of itself and the variables initialised after it (`later`), which have no value yet.
    fn begins_without_call(&self, id: VarId, later: &[VarId], line: u32) -> Result<(), Fault> {
        let one = self.tree.variable(id);
        let is_single =
            matches!(self.tree.types.get(one.ty), Typed::Elementary(_) | Typed::Text(_));
        let mut is_open = one.type_calls;
        let may_have = is_single && !one.constant;
        if let Some(initial) = one.initial.as_ref().filter(|_| may_have) {
            let later = (one.section != Section::Input).then_some(later);
            let mut varies = Varies { tree: self.tree, later, found: false };
            accesses::of_expr(initial, &mut varies);
            is_open |= varies.found;
        }
        if let Some(initial) = one.initial.as_ref().filter(|_| !may_have) {
            // In a list, evaluating the value of each element would take time.
            initial.each(&mut |inner| {
                is_open |= matches!(
                    inner.kind,
                    ExprKind::Call(_)
                        | ExprKind::After(_)
                        | ExprKind::Standard(_)
                        | ExprKind::Read(_)
                );
            });
        }
        if !is_open {
            return Ok(());
        }
        let what = format!(
            "{} begins anew with each call, and its initial value is evaluated then, which is not modelled",
            one.name
        );
        let help = match one.section {
            Section::Input => "give it a constant value, or pass it in each call",
            _ => "assign the value in the body",
        };
        Err(Fault::new(line, what).code(FaultCode::NotModelled).help(help))
    }
}

/// Whether an initial value depends on when it is evaluated.
struct Varies<'a> {
    tree: &'a Tree,
    /// The variables that have no value yet. `None`: no other variable may be read, and nothing called.
    later: Option<&'a [VarId]>,
    found: bool,
}

impl Accesses for Varies<'_> {
    fn reads(&mut self, place: &Place) {
        let is_plain = !place.steps.contains(&PathStep::Dereference);
        self.found |= match (place.root, self.later) {
            (Root::Variable(id), _) if is_plain && self.tree.variable(id).constant => false,
            (Root::Variable(id), Some(later)) => later.contains(&id),
            (_, later) => later.is_none(),
        };
    }

    fn writes(&mut self, _: &Place) {
        self.found |= self.later.is_none();
    }

    fn takes_address(&mut self, _: &Place) {}

    fn asks(&mut self, _: &StepFlag) {
        self.found |= self.later.is_none();
    }

    fn calls(&mut self, _: &Call) {
        self.found |= self.later.is_none();
    }
}

/// Whether an initial value takes time to evaluate: it is more than a literal or a list of literals.
fn is_worked_out(initial: &Expr) -> bool {
    match &initial.kind {
        ExprKind::Negate(inner) | ExprKind::Not(inner) | ExprKind::Convert(inner) => {
            is_worked_out(inner)
        }
        ExprKind::Read(_)
        | ExprKind::Binary(..)
        | ExprKind::Call(_)
        | ExprKind::After(_)
        | ExprKind::Standard(_)
        | ExprKind::Named(_)
        | ExprKind::Either(_)
        | ExprKind::Fault(_) => true,
        _ => false,
    }
}

/// The timing key of a call.
fn called() -> TimingKey {
    Assembler::key(&["CAL"], "call")
}

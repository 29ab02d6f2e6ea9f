//! Statements, and the routines that they stand in.

use super::assembler::Assembler;
use super::emit::{Emit, Instance, Place, What};
use super::memory::set;
use super::references::{Walk, Way};
use super::resolve::{Context, Found, unknown};
use super::types::{DINT, Kind, Ty, lineage};
use super::value::Value;
use scanbound_base::code::Code;
use scanbound_iec::ast::{
    Argument, Expr, Kind as Statements, Operator, Part, Path, Selector, Statement, visit,
};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, Pou, PouKind, Section, same, show};
use scanbound_iec_tree::blocks::{Pin, StandardBlock};
use scanbound_ir::{Cell, Logic, Number, Step, WordSource, WordTarget, Write};
use std::collections::BTreeMap;

/// What some controllers do.
pub(super) const ENDS_CHART: &str = "RETURN in an action ends the whole chart";

/// Where jumps of a body lead: labels, and the ends of loops.
#[derive(Default)]
pub(super) struct Ways {
    labels: BTreeMap<String, Vec<usize>>,
    seen: Vec<String>,
    /// For each loop around: jumps to its end of an iteration, and jumps out of it.
    pub(super) loops: Vec<[Vec<usize>; 2]>,
    /// In an action block: jumps to its end. Whether RETURN ends it alone, controllers differ.
    ends: Option<Vec<usize>>,
    /// In an action of its own: the bit that says that RETURN ended it.
    returned: Option<Cell>,
}

impl<'p> Emit<'p> {
    /// The body of a routine, and whose file it stands in.
    pub(super) fn body(&self, instance: usize, what: &What) -> Option<(&'p Pou, &'p Body)> {
        let all = lineage(self.project, self.instances[instance].pou);
        match what {
            What::Body => all
                .into_iter()
                .map(|pou| (pou, &pou.body))
                .find(|(_, body)| !is_empty(body))
                .or_else(|| {
                    let own = &self.project.pous[self.instances[instance].pou];
                    Some((own, &own.body))
                }),
            What::Action(name) => {
                all.into_iter().find_map(|pou| Some((pou, &pou.action(name)?.body)))
            }
            What::Method(name) => all.into_iter().find_map(|pou| method_in(pou, name)),
            What::Inherited(from, name) => {
                let mut all = lineage(self.project, *from).into_iter();
                if name.is_empty() {
                    let bodies = all.map(|pou| (pou, &pou.body));
                    return { bodies }.find(|(_, body)| !is_empty(body));
                }
                all.find_map(|pou| method_in(pou, name))
            }
        }
    }

    pub(super) fn method_of(&self, instance: usize, name: &str) -> Option<&'p Pou> {
        let all = lineage(self.project, self.instances[instance].pou);
        all.into_iter().find_map(|pou| pou.methods.iter().find(|method| same(&method.name, name)))
    }

    /// Puts a routine together; where it begins.
    pub(super) fn routine(&mut self, instance: usize, what: &What) -> usize {
        let entry = self.builder.next();
        self.routines.insert((instance, what.clone()), entry);
        self.kept.clear();
        self.kept_extents.clear();
        if self.stands_in(instance, what) {
            return entry;
        }
        self.note_bodiless(instance, what);
        let Some((pou, body)) = self.body(instance, what) else {
            self.landing();
            self.builder.add(None, Vec::new(), Step::Return);
            return entry;
        };
        self.file = pou.file;
        self.at(pou.line, &pou.name);
        self.landing();
        let locals = match what {
            What::Method(name) => self.method_place(instance, name).ok(),
            What::Inherited(from, name) if !name.is_empty() => {
                self.method_place_of(instance, Some(*from), name).ok()
            }
            _ => None,
        };
        let own = self.project.pous.iter().position(|one| std::ptr::eq(one, pou));
        let unit = own.unwrap_or(self.instances[instance].pou);
        let context = Context { instance, locals, unit };
        if *what == What::Body {
            self.begin_temporary(&context);
        }
        // Whether a block without a body of its own carries out that of its base is not the same on all controllers.
        let own = &self.project.pous[self.instances[instance].pou];
        let inherits = *what == What::Body && !std::ptr::eq(own, pou);
        let inherited = inherits.then(|| {
            let why = "whether a block without a body carries out that of its base: it may, or not";
            let carries = self.any_bit(why);
            self.jump(carries.not(), None)
        });
        let around = self.enter(body);
        match body {
            Body::Code(_, statements) => {
                let is_action = matches!(what, What::Action(_));
                let returned = is_action.then(|| self.returned(instance, what)).flatten();
                let mut ways = Ways { returned, ..Ways::default() };
                self.statements(&context, statements, &mut ways);
                for (label, jumps) in ways.labels {
                    if !jumps.is_empty() {
                        let help = "only jumps to labels further down are followed";
                        let fault =
                            Fault::new(pou.line, format!("there is no label {label} further down"));
                        self.fault(fault.code(Code::NoLabel).help(help));
                    }
                }
            }
            Body::Chart(chart) => self.chart(&context, what, pou, chart),
            Body::Unread(language, fault) => {
                let mut fault = fault.clone();
                fault.message = format!("{} ({})", fault.message, language.name());
                self.fault(fault);
            }
        }
        self.leave(around);
        if let Some(inherited) = inherited {
            self.land(inherited);
        }
        self.landing();
        self.builder.add(None, Vec::new(), Step::Return);
        entry
    }

    /// Variables of VAR_TEMP begin anew whenever a body is carried out.
    fn begin_temporary(&mut self, at: &Context) {
        let Instance { pou, place } = self.instances[at.instance].clone();
        let all = lineage(self.project, pou).into_iter().flat_map(|pou| &pou.variables);
        let own: Vec<_> = all.filter(|one| one.section == Section::Temp).cloned().collect();
        if let Err(fault) = self.begin_anew(at, &place, &own, &[], self.project.pous[pou].line) {
            self.fault(fault);
        }
    }

    pub(super) fn statements(&mut self, at: &Context, statements: &[Statement], ways: &mut Ways) {
        for statement in statements {
            if self.is_late() {
                return;
            }
            let text = show::statements(std::slice::from_ref(statement), 0);
            self.at(statement.line, text.lines().next().unwrap_or_default());
            let counted = self.begin_statement(statement);
            let done = self.statement(at, statement, ways);
            self.end_statement(counted);
            if let Err(fault) = done {
                let fault =
                    if fault.line == 0 { Fault { line: statement.line, ..fault } } else { fault };
                let place = &self.instances[at.instance].place.name;
                let fault = fault.within(place);
                self.fault(fault);
            }
        }
    }

    /// Statements that stand in an action block.
    pub(super) fn in_block(&mut self, at: &Context, statements: &[Statement]) {
        let mut ways = Ways { ends: Some(Vec::new()), ..Ways::default() };
        self.statements(at, statements, &mut ways);
        ways.ends.into_iter().flatten().for_each(|jump| self.land(jump));
    }

    /// The bit that says that RETURN ended an action of an instance, if it has one.
    pub(super) fn returned(&mut self, instance: usize, what: &What) -> Option<Cell> {
        let (_, Body::Code(_, statements)) = self.body(instance, what)? else { return None };
        let mut has_any = false;
        visit(statements, &mut |one| has_any |= matches!(one.kind, Statements::Return(_)));
        if !has_any {
            return None;
        }
        if let Some(&known) = self.returned.get(&(instance, what.clone())) {
            return Some(known);
        }
        let cell = self.bit_between();
        self.returned.insert((instance, what.clone()), cell);
        Some(cell)
    }

    /// Statements that stand within a chart.
    pub(super) fn inner(&mut self, at: &Context, statements: &[Statement]) {
        self.statements(at, statements, &mut Ways::default());
    }

    fn statement(&mut self, at: &Context, one: &Statement, ways: &mut Ways) -> Result<(), Fault> {
        let line = one.line;
        match &one.kind {
            Statements::Refer(target, value) => self.referred(at, target, value, line),
            Statements::Assign(target, value) if super::foreign::is_written(value) => {
                self.foreign_written(at, target, line)
            }
            Statements::Assign(target, value) => {
                let is_kept = target.first.starts_with('~');
                let walk = if is_kept { Walk::Unknown } else { self.walk(at, target, true) };
                match walk {
                    Walk::Way(way) => return self.assigned_through(at, way, value, line),
                    Walk::Type(Ty::Reference(kind, _)) => {
                        if self.moves_element(at, target, value) {
                            let what = show::path(target);
                            return Err(super::refer::moves(line, &what));
                        }
                        let found = self.address(at, value, kind, line)?;
                        let place = self.find_plain(at, target, line)?;
                        return self.assign_found(place, None, found, line);
                    }
                    _ => {}
                }
                if let Expr::Variable(from) = value
                    && !is_kept
                    && !self.is_single(at, from)
                    && let Walk::Way(Way::Referred(way)) = self.walk(at, from, true)
                {
                    // A structure or an array.
                    let done = self.each_target(at, &way, line, &mut |emit, path| {
                        let kind = Statements::Assign(target.clone(), Expr::Variable(path));
                        emit.statement(at, &Statement { line, kind }, &mut Ways::default())?;
                        Ok(Value::Any)
                    });
                    return done.map(|_| ());
                }
                if !is_kept
                    && let Some(from) = self.whole_value(at, value, line)?
                    && let Some(to) = self.whole(at, target, line)?
                {
                    self.has_own_type(at, to.place(), value, line)?;
                    return self.copy_whole(&from, &to, line);
                }
                if self.moves_element(at, target, value) {
                    return self.assign_either_way(at, target, value, line);
                }
                let found = self.open_value(at, value, line)?;
                self.assign_of(at, target, Some(value), found, line)
            }
            Statements::Latch(target, set, condition) => {
                match self.walk(at, target, true) {
                    Walk::Way(Way::Referred(way)) => {
                        self.stays(at, &way, condition, line)?;
                        let done = self.each_target(at, &way, line, &mut |emit, path| {
                            let kind = Statements::Latch(path, *set, condition.clone());
                            emit.statement(at, &Statement { line, kind }, ways)?;
                            Ok(Value::Any)
                        });
                        return done.map(|_| ());
                    }
                    Walk::Way(Way::Property(property)) => {
                        // A property is written where the condition holds.
                        let fires = self.bit(at, condition, line)?;
                        let skip = self.jump(fires.not(), Some(Assembler::key(&["JMP"], "jump")));
                        let done = self.property_written(at, &property, &Expr::bool(*set), line);
                        self.land(skip);
                        self.landing();
                        return done;
                    }
                    _ => {}
                }
                let found = self.find(at, target, line)?;
                if let Found::Place(place) = &found
                    && matches!(place.ty, Ty::Standard(..) | Ty::Block(..))
                {
                    // S and R of an instruction list call an instance with its input of that name.
                    let name = Some(if *set { "S" } else { "R" }.to_owned());
                    let given = Argument { name, is_output: false, value: condition.clone() };
                    return self.instance_called(at, place, &[given], line);
                }
                if let Found::Place(place) = &found
                    && matches!(place.ty, Ty::Number(_))
                {
                    let message =
                        format!("{} is a number, which is not set or reset", show::path(target));
                    return Err(Fault::new(line, message).code(Code::Operand));
                }
                if self.moves_element(at, target, condition) {
                    let told = format!(
                        "which element {} is may change while its value is worked out",
                        show::path(target)
                    );
                    let help = "assign the value to a variable of its own before";
                    return Err(Fault::new(line, told).code(Code::NotModelled).help(help));
                }
                let fires = self.bit(at, condition, line)?;
                let found = self.find(at, target, line)?;
                let writes = self.writes(found, Value::Bit(Logic::Const(*set)), line)?;
                let row = if *set { "S" } else { "R" };
                self.write_if(fires, writes, Some(Assembler::key(&[row], "coil")));
                Ok(())
            }
            Statements::Call(target, given) => self.called(at, target, given, line),
            Statements::CallIf(condition, target, given) => {
                if condition.is(true) {
                    return self.called(at, target, given, line);
                }
                let enable = self.bit(at, condition, line)?;
                let skip = self.jump(enable.not(), Some(Assembler::key(&["JMP"], "jump")));
                let done = self.called(at, target, given, line);
                self.land(skip);
                self.landing();
                done
            }
            Statements::If(arms, otherwise) => self.conditional(at, arms, otherwise, line, ways),
            Statements::Either(what, first, second) => {
                self.either_of(at, what, (first, second), ways);
                Ok(())
            }
            Statements::Case(of, arms, otherwise) => self.case(at, of, arms, otherwise, line, ways),
            Statements::For(variable, from, to, by, body) => {
                self.counted(at, variable, (from, to, by.as_ref()), body, line, ways)
            }
            Statements::While(condition, body) => self.while_true(at, condition, body, line, ways),
            Statements::Repeat(body, until) => self.repeated(at, body, until, line, ways),
            Statements::Exit | Statements::Continue => {
                let jump = self.jump(Logic::Const(true), Some(Assembler::key(&["JMP"], "jump")));
                let side = usize::from(one.kind == Statements::Exit);
                match ways.loops.last_mut() {
                    Some(inner) => inner[side].push(jump),
                    None => return Err(Fault::new(line, "no loop is around EXIT or CONTINUE")),
                }
                Ok(())
            }
            Statements::Return(condition) => {
                let returns = self.bit(at, condition, line)?;
                let stay = self.jump(returns.not(), None);
                if let Some(cell) = ways.returned {
                    self.write(vec![set(cell, Logic::Const(true))]);
                }
                let key = Some(Assembler::key(&["RET"], "jump"));
                if let Some(ends) = &mut ways.ends {
                    let whole = self.differs(ENDS_CHART);
                    ends.push(self.jump(whole.not(), key));
                    self.builder.add(None, Vec::new(), Step::Return);
                } else {
                    self.builder.add(key, Vec::new(), Step::Return);
                }
                self.land(stay);
                self.landing();
                Ok(())
            }
            Statements::Jump(condition, label) => {
                let fires = self.bit(at, condition, line)?;
                if ways.seen.iter().any(|seen| same(seen, label)) {
                    let help = "only jumps to labels further down are followed: write it as FOR";
                    return Err(Fault::new(line, format!("the jump to {label} goes back"))
                        .code(Code::JumpBack)
                        .help(help));
                }
                let jump = self.jump(fires, Some(Assembler::key(&["JMP"], "jump")));
                ways.labels.entry(label.to_ascii_uppercase()).or_default().push(jump);
                Ok(())
            }
            Statements::Label(label) => {
                ways.seen.push(label.clone());
                for jump in ways.labels.remove(&label.to_ascii_uppercase()).unwrap_or_default() {
                    self.land(jump);
                }
                self.landing();
                Ok(())
            }
            Statements::Foreign(text, name) => self.foreign(text, name.as_ref(), line),
            Statements::Unread(what) => Err(Fault::new(line, what.clone()).code(Code::NotModelled)),
        }
    }

    /// One of two bodies, which have the same statements in different orders: they are counted once.
    fn either_of(
        &mut self,
        at: &Context,
        what: &'static str,
        (first, second): (&[Statement], &[Statement]),
        ways: &mut Ways,
    ) {
        let which = self.differs(what);
        let number = self.tally.current.map(|current| current.next);
        let skip = self.jump(which.not(), None);
        self.statements(at, first, ways);
        let end = self.jump(Logic::Const(true), None);
        self.land(skip);
        self.landing();
        if let (Some(current), Some(number)) = (self.tally.current.as_mut(), number) {
            current.next = number;
        }
        self.statements(at, second, ways);
        self.land(end);
        self.landing();
    }

    /// The branches of IF: each tests, and jumps to the next one where it is false.
    fn conditional(
        &mut self,
        at: &Context,
        arms: &[(Expr, Vec<Statement>)],
        otherwise: &[Statement],
        line: u32,
        ways: &mut Ways,
    ) -> Result<(), Fault> {
        let mut ends = Vec::new();
        for (number, (condition, body)) in arms.iter().enumerate() {
            let holds = self.bit(at, condition, line)?;
            let skip = self.jump(holds.not(), Some(Assembler::key(&["JMP"], "jump")));
            let kept = self.kept.clone();
            self.statements(at, body, ways);
            self.kept = merged(kept, &self.kept);
            if number + 1 < arms.len() || !otherwise.is_empty() {
                ends.push(self.jump(Logic::Const(true), Some(Assembler::key(&["JMP"], "jump"))));
            }
            self.land(skip);
            self.landing();
        }
        self.statements(at, otherwise, ways);
        for end in ends {
            self.land(end);
        }
        self.landing();
        Ok(())
    }

    fn case(
        &mut self,
        at: &Context,
        of: &Expr,
        arms: &[(Vec<Selector>, Vec<Statement>)],
        otherwise: &[Statement],
        line: u32,
        ways: &mut Ways,
    ) -> Result<(), Fault> {
        let value = self.value(at, of, line)?;
        let kind = match &value {
            Value::Number(kind, _) => *kind,
            _ => DINT,
        };
        let number = self.as_number(value, kind, line)?;
        let words = self.copies(number, kind);
        let mut ends = Vec::new();
        for (selectors, body) in arms {
            let mut fits = Vec::new();
            for selector in selectors {
                let own = || Value::Number(kind, Number::Words(words.clone()));
                let low = self.value(at, &selector.low, line)?;
                fits.push(match &selector.high {
                    None => self.combined(Operator::Equal, own(), low, line)?,
                    Some(high) => {
                        let high = self.value(at, high, line)?;
                        let above = self.combined(Operator::GreaterOrEqual, own(), low, line)?;
                        let below = self.combined(Operator::LessOrEqual, own(), high, line)?;
                        self.combined(Operator::And, above, below, line)?
                    }
                });
            }
            let bits = fits.into_iter().map(|fit| match fit {
                Value::Bit(logic) => logic,
                _ => Logic::Const(false),
            });
            let holds = Logic::Any(bits.collect());
            let skip = self.jump(holds.not(), Some(Assembler::key(&["JMP"], "jump")));
            self.statements(at, body, ways);
            ends.push(self.jump(Logic::Const(true), Some(Assembler::key(&["JMP"], "jump"))));
            self.land(skip);
            self.landing();
        }
        self.statements(at, otherwise, ways);
        for end in ends {
            self.land(end);
        }
        self.landing();
        Ok(())
    }

    /// Assigns to what a path leads to through references, or to a property.
    fn assigned_through(
        &mut self,
        at: &Context,
        way: Way,
        value: &Expr,
        line: u32,
    ) -> Result<(), Fault> {
        match way {
            Way::Property(property) if property.rest.is_empty() => {
                self.property_written(at, &property, value, line)
            }
            Way::Property(property) => {
                let done = self.through_property(at, &property, line, &mut |emit, path| {
                    let kind = Statements::Assign(path, value.clone());
                    emit.statement(at, &Statement { line, kind }, &mut Ways::default())?;
                    Ok(Value::Any)
                });
                done.map(|_| ())
            }
            Way::Referred(way) => {
                self.stays(at, &way, value, line)?;
                let done = self.each_target(at, &way, line, &mut |emit, path| {
                    let kind = Statements::Assign(path, value.clone());
                    emit.statement(at, &Statement { line, kind }, &mut Ways::default())?;
                    Ok(Value::Any)
                });
                done.map(|_| ())
            }
        }
    }

    /// `REF=`
    fn referred(
        &mut self,
        at: &Context,
        target: &Path,
        value: &Expr,
        line: u32,
    ) -> Result<(), Fault> {
        match self.walk(at, target, false) {
            Walk::Way(Way::Referred(way)) => {
                let done = self.each_target(at, &way, line, &mut |emit, path| {
                    emit.referred(at, &path, value, line)?;
                    Ok(Value::Any)
                });
                done.map(|_| ())
            }
            Walk::Type(Ty::Reference(kind, _)) => {
                let found = self.address(at, value, kind, line)?;
                let place = self.find_plain(at, target, line)?;
                self.assign_found(place, None, found, line)
            }
            _ => {
                let what = format!("{} is no reference", show::path(target));
                Err(Fault::new(line, what).code(Code::Operand))
            }
        }
    }

    /// A call through a reference, of what a property gives, or of what the base has (`SUPER^`). Whether it is such a call.
    fn called_through(
        &mut self,
        at: &Context,
        target: &Path,
        given: &[Argument],
        line: u32,
    ) -> Result<bool, Fault> {
        if same(&target.first, "SUPER") {
            let names: Vec<&Part> =
                target.rest.iter().filter(|part| **part != Part::Dereference).collect();
            return match names[..] {
                [] => self.base_called(at, given, line).map(|()| true),
                [Part::Name(name)] => self.inherited(at, name, given, line).map(|_| true),
                _ => Err(unknown(line, &show::path(target))),
            };
        }
        match self.walk(at, target, true) {
            Walk::Way(Way::Referred(way)) => {
                for one in given {
                    self.stays(at, &way, &one.value, line)?;
                }
                self.each_target(at, &way, line, &mut |emit, path| {
                    emit.called(at, &path, given, line)?;
                    Ok(Value::Any)
                })?;
            }
            Walk::Way(Way::Property(property)) if !property.rest.is_empty() => {
                self.through_property(at, &property, line, &mut |emit, path| {
                    emit.called(at, &path, given, line)?;
                    Ok(Value::Any)
                })?;
            }
            Walk::Way(Way::Property(property)) => {
                let why = "whether a property that stands alone is read: it may, or not";
                let reads = self.any_bit(why);
                let skip = self.jump(reads.not(), None);
                let done = self.property_value(at, &property, line);
                self.land(skip);
                self.landing();
                done?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// `SUPER^();` carries out the body of the base.
    fn base_called(&mut self, at: &Context, given: &[Argument], line: u32) -> Result<(), Fault> {
        let base = self.base(at, line)?;
        let place = self.instances[at.instance].place.clone();
        let all = lineage(self.project, base);
        let variables: Vec<_> =
            all.into_iter().rev().flat_map(|pou| pou.variables.clone()).collect();
        self.has_one_name(at, Some(&place.name), &variables, given, line)?;
        self.hand_over(at, &place, &variables, given, line)?;
        let what = What::Inherited(base, String::new());
        if self.body(at.instance, &what).is_some() || self.is_stated(at.instance, &what) {
            self.call(Logic::Const(true), at.instance, what, "CAL");
        } else {
            self.cost(&["CAL"], "call");
        }
        self.take_back(at, &place, &variables, given, line)
    }

    /// The unit that the one whose code this is extends.
    pub(super) fn base(&self, at: &Context, line: u32) -> Result<usize, Fault> {
        let own = &self.project.pous[at.unit];
        let base = own
            .extends
            .as_ref()
            .and_then(|base| self.project.pous.iter().position(|pou| same(&pou.name, base)));
        base.ok_or_else(|| {
            let help = "give the file that declares what it extends";
            unknown(line, "SUPER^").help(help)
        })
    }

    /// A call as a statement.
    pub(super) fn called(
        &mut self,
        at: &Context,
        target: &Path,
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        if let Some(name) = target.as_name().filter(|name| self.has_member(at, name)) {
            if self.body(at.instance, &What::Action(name.to_owned())).is_some() {
                let place = self.instances[at.instance].place.clone();
                self.hand_over(at, &place, &[], given, line)?;
                self.call(
                    Logic::Const(true),
                    at.instance,
                    What::Action(name.to_ascii_uppercase()),
                    "CAL",
                );
                return Ok(());
            }
            if self.method_of(at.instance, name).is_some() {
                return self.method(at, at.instance, name, given, line).map(|_| ());
            }
        }
        if self.called_through(at, target, given, line)?
            || self.one_of_called(at, target, given, line)?
        {
            return Ok(());
        }
        let place = self.find(at, target, line);
        if let Ok(Found::Place(place)) = place {
            return self.instance_called(at, &place, given, line);
        }
        if let Some((owner, name)) = target.split_last()
            && let Ok(Found::Place(owner)) = self.find(at, &owner, line)
        {
            let pou = match owner.ty {
                Ty::Block(pou, _) => Some(pou),
                _ => self
                    .by_name
                    .get(&owner.name.to_ascii_uppercase())
                    .map(|&own| self.instances[own].pou),
            };
            if let Some(pou) = pou {
                let instance = self.instance(&owner, pou);
                if self.body(instance, &What::Action(name.to_owned())).is_some() {
                    if instance != at.instance {
                        self.member_names_handed(pou, name, line)?;
                    }
                    self.hand_over(at, &owner, &[], given, line)?;
                    self.call(
                        Logic::Const(true),
                        instance,
                        What::Action(name.to_ascii_uppercase()),
                        "CAL",
                    );
                    return Ok(());
                }
                return self.method(at, instance, name, given, line).map(|_| ());
            }
        }
        let is_function = |name: &str| {
            self.project
                .pous
                .iter()
                .any(|pou| pou.kind == PouKind::Function && same(&pou.name, name))
        };
        match target.as_name() {
            Some(name) if is_function(name) || given.iter().any(|one| one.is_output) => {
                self.function(at, target, given, line).map(|_| ())
            }
            _ => Err(unknown(line, &show::path(target))),
        }
    }

    fn instance_called(
        &mut self,
        at: &Context,
        place: &Place,
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        match place.ty.clone() {
            Ty::Standard(kind, _) => {
                let given: Vec<Argument> = named(kind, given);
                let inputs = self.begin_inputs(at, place, &given, line)?;
                self.hand_over(at, place, &[], &given, line)?;
                let enabled = self.begin_body(inputs);
                let is_preset = |one: &Argument| one.name.as_ref().is_some_and(|n| same(n, "PT"));
                if !given.iter().any(is_preset) {
                    let preset = Self::part(place, "PT").and_then(|part| part.tag.cell());
                    self.presets_left.extend(preset);
                }
                if let Some(block) = StandardBlock::named(kind) {
                    let cell = |pin: Pin| Self::part(place, pin.name())?.tag.cell();
                    self.standard_block(block, &cell);
                }
                self.take_back(at, place, &[], &given, line)?;
                let enable = self.end_enabled(at, place, enabled, &given, line)?;
                self.open_outputs(at, enable.as_ref(), &given, line)
            }
            Ty::Block(pou, _) => {
                let instance = self.instance(place, pou);
                let all = lineage(self.project, pou);
                let variables: Vec<_> =
                    all.into_iter().rev().flat_map(|pou| pou.variables.clone()).collect();
                self.leaves_none_out(&variables, given, line)?;
                self.has_one_name(at, Some(&place.name), &variables, given, line)?;
                let inputs = self.begin_inputs(at, place, given, line)?;
                self.hand_over(at, place, &variables, given, line)?;
                let enabled = self.begin_body(inputs);
                self.call(Logic::Const(true), instance, What::Body, "CAL");
                self.take_back(at, place, &variables, given, line)?;
                let enable = self.end_enabled(at, place, enabled, given, line)?;
                self.open_outputs(at, enable.as_ref(), given, line)
            }
            Ty::Reference(..) | Ty::Bit | Ty::Number(_) => Ok(()),
            _ => match self.by_name.get(&place.name.to_ascii_uppercase()).copied() {
                Some(instance) => {
                    self.hand_over(at, place, &[], given, line)?;
                    self.call(Logic::Const(true), instance, What::Body, "CAL");
                    Ok(())
                }
                // A name alone does nothing.
                None => Ok(()),
            },
        }
    }
}

impl Assembler {
    pub(super) fn copies(&mut self, number: Number, kind: Kind) -> Vec<WordSource> {
        let first = self.words_between(kind.words());
        let targets = (0..kind.words()).map(|at| WordTarget::Cell(first.plus(at))).collect();
        self.write(vec![Write::Words(targets, number)]);
        (0..kind.words()).map(|at| WordSource::Cell(first.plus(at))).collect()
    }
}

/// The arguments of a standard block with the names that those without one stand for.
fn named(kind: &str, given: &[Argument]) -> Vec<Argument> {
    let inputs: &[&str] = match kind {
        "TON" | "TOF" | "TP" => &["IN", "PT"],
        "CTU" => &["CU", "R", "PV"],
        "CTD" => &["CD", "LD", "PV"],
        "CTUD" => &["CU", "CD", "R", "LD", "PV"],
        "SR" => &["S1", "R"],
        "RS" => &["S", "R1"],
        _ => &["CLK"],
    };
    let with = |(at, one): (usize, &Argument)| Argument {
        name: one.name.clone().or_else(|| inputs.get(at).map(|name| (*name).to_owned())),
        ..one.clone()
    };
    given.iter().enumerate().map(with).collect()
}

fn method_in<'p>(pou: &'p Pou, name: &str) -> Option<(&'p Pou, &'p Body)> {
    let method = pou.methods.iter().find(|method| same(&method.name, name))?;
    Some((pou, &method.body))
}

fn is_empty(body: &Body) -> bool {
    matches!(body, Body::Code(_, statements) if statements.is_empty())
}

/// Values that are kept on one way only hold what they held, or nothing, on the other.
fn merged(
    mut before: BTreeMap<String, Value>,
    after: &BTreeMap<String, Value>,
) -> BTreeMap<String, Value> {
    for (name, value) in after {
        before.entry(name.clone()).or_insert_with(|| value.clone());
    }
    before
}

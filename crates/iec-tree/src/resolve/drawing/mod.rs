//! Resolution of drawings (LD, FBD): the statements they execute, in each order that a tool may use.
//!
//! The value of an element is an expression over the elements that feed it; parallel connections are joined by OR. Each
//! coil, output and pin has its own expression, as in the text of *generators*: tools that translate a drawing to text,
//! such as Beremiz and OpenPLC. A value used more than once within an expression may be stored in a temporary.

mod block;
mod differ;
mod loops;
mod orders;
mod output_types;
mod state;
mod touched;
mod value;
mod worth;

use super::resolver::{Resolver, Scope};
use super::statements::Labels;
use crate::declarations::{First, Owner, VarId, Variable};
use crate::tree::{Expr, ExprKind, Statement, StatementKind};
use crate::types::{Type, TypeId};
use loops::Loops;
use orders::Order;
use scanbound_base::code::Code;
use scanbound_iec::Section;
use scanbound_iec::ast;
use scanbound_iec::drawing::{Drawing, Element, ElementId, ElementKind, Goal};
use scanbound_iec::fault::Fault;
use state::{Drawer, Hidden, Progress, Sheet, at_element, resolved};

impl Resolver<'_> {
    /// The statements of a drawing in order of execution. If tools use different orders with different effects, they
    /// are alternatives of an [`StatementKind::Either`].
    pub(super) fn drawing(
        &mut self,
        scope: Scope,
        drawing: &Drawing,
        labels: &mut Labels,
    ) -> Result<Vec<Statement>, Fault> {
        let sheet = Sheet::new(drawing, scope)?;
        if let Some(goal) = &drawing.goal {
            return self.of_condition(&sheet, goal, labels);
        }
        let mut hidden = Hidden::default();
        let before = (self.tree.temporaries.len(), labels.passed.clone());
        loop {
            let found = self.in_all_orders(&sheet, &mut hidden, labels);
            if !std::mem::take(&mut hidden.is_stale) {
                return found;
            }
            // Each further pass has one more variable, or stores values for the first time, so this ends.
            hidden.temporaries.clear();
            self.tree.temporaries.truncate(before.0);
            labels.passed.clone_from(&before.1);
        }
    }

    fn in_all_orders<'d>(
        &mut self,
        sheet: &Sheet<'d>,
        hidden: &mut Hidden<'d>,
        labels: &mut Labels,
    ) -> Result<Vec<Statement>, Fault> {
        let mut ways: Vec<(&'static str, Progress<'d>)> = Vec::new();
        let before = labels.passed.clone();
        let mut passed = before.clone();
        for order in sheet.orders() {
            labels.passed.clone_from(&before);
            let what = order.what;
            let own = self.in_order(sheet, hidden, labels, order)?;
            passed.extend(&labels.passed);
            if ways.iter().all(|(_, known)| self.differ(known, &own)) {
                ways.push((what, own));
            }
        }
        labels.passed = passed;
        if let Some((_, first)) = ways.first() {
            self.rows_are_clear(sheet, first)?;
        }
        let line = ways.first().and_then(|(_, first)| first.all.first());
        let line = line.map_or(0, |first| sheet.drawing.element(first.owner).line);
        let statements = |own: Progress<'_>| own.all.into_iter().map(|one| one.statement).collect();
        let all = ways.into_iter().map(|(what, own)| (what, statements(own)));
        let either = |(one, before): (_, Vec<Statement>), (what, other)| {
            let kind = StatementKind::Either(what, other, before);
            (one, vec![Statement { kind, text: what.into(), line }])
        };
        Ok(all.reduce(either).map(|(_, statements)| statements).unwrap_or_default())
    }

    /// The statements of the blocks that compute conditions of a chart.
    fn of_condition<'d>(
        &mut self,
        sheet: &Sheet<'d>,
        goal: &'d Goal,
        labels: &mut Labels,
    ) -> Result<Vec<Statement>, Fault> {
        let mut hidden = Hidden::default();
        let loops = Loops::default();
        let mut drawer = Drawer::new(self, sheet, &mut hidden, labels, (loops, false));
        // Edges that feed no block belong to the conditions.
        let mut others = sheet.drawing.all().filter(|(_, one)| one.block().is_none());
        if let Some((id, first)) = others.next().or(sheet.drawing.all().next()) {
            drawer.progress.owner = id;
            for from in &goal.from {
                drawer.used(first, from)?;
            }
        }
        let progress = drawer.progress;
        if goal.from.windows(2).any(|both| both[0] != both[1]) {
            self.goals_are_apart(sheet, &progress)?;
        }
        Ok(progress.all.into_iter().map(|one| one.statement).collect())
    }

    fn in_order<'d>(
        &mut self,
        sheet: &Sheet<'d>,
        hidden: &mut Hidden<'d>,
        labels: &mut Labels,
        order: Order,
    ) -> Result<Progress<'d>, Fault> {
        let how = (order.loops, order.is_generated);
        // Generators evaluate again where other tools use the stored value.
        let differs = order.is_generated && hidden.looks_again;
        let mut drawer = Drawer::new(self, sheet, hidden, labels, how);
        drawer.progress.differs_in_itself = differs;
        for id in order.acting {
            drawer.progress.acting = drawer.number(sheet.drawing.element(id));
            drawer.act(id)?;
        }
        Ok(drawer.progress)
    }
}

impl<'d> Drawer<'_, '_, 'd> {
    /// Executes an element that has an effect; for others it does nothing.
    fn act(&mut self, id: ElementId) -> Result<(), Fault> {
        let outer = std::mem::replace(&mut self.progress.owner, id);
        let done = self.act_as_owner(id);
        self.progress.owner = outer;
        done
    }

    fn act_as_owner(&mut self, id: ElementId) -> Result<(), Fault> {
        let one = self.element(id);
        let line = one.line;
        match &one.kind {
            // Generators omit functions without inputs and outgoing connections, and also jumps, returns and labels.
            ElementKind::Block(block)
                if self.is_generated && one.uses == 0 && block.has_no_pin() =>
            {
                Ok(())
            }
            ElementKind::Block(_) => self.block(id),
            ElementKind::InOut if one.inputs.is_empty() => Ok(()),
            ElementKind::Coil | ElementKind::Out | ElementKind::InOut => self.write(id, one),
            _ if self.is_generated && one.moves() => Ok(()),
            ElementKind::Return => {
                let returns = self.condition(one)?;
                self.add(line, StatementKind::Return(returns), "RETURN".to_owned());
                Ok(())
            }
            ElementKind::Jump(label) => {
                let jumps = self.condition(one)?;
                let jump = self.labels.jump(label, jumps, line);
                self.add(line, resolved(jump), format!("JMP {label}"));
                Ok(())
            }
            ElementKind::Label(label) => {
                let kind = self.labels.label(label);
                self.add(line, kind, format!("{label}:"));
                Ok(())
            }
            // Generators evaluate the edges in front of a connector even if it has no continuation.
            ElementKind::Connector if self.is_generated => self.used(one, &one.inputs).map(|_| ()),
            ElementKind::Other(name) => {
                let what = format!("elements {name} are not followed");
                Err(one.fault(&what).code(Code::NotModelled))
            }
            _ => Ok(()),
        }
    }

    /// The condition of a jump or a return.
    fn condition(&mut self, one: &'d Element) -> Result<Expr, Fault> {
        let value = self.used(one, &one.inputs)?;
        Ok(if one.negated_in { value.not().expr } else { value.expr })
    }

    /// Writes the variable of a coil or an output, once.
    fn write(&mut self, id: ElementId, one: &'d Element) -> Result<(), Fault> {
        if !self.progress.done.insert(id) {
            return Ok(());
        }
        let ast::Expr::Variable(target) = one.operand.as_ref().map_err(Fault::clone)? else {
            return Err(one.fault("it writes to no variable"));
        };
        let is_coil = one.kind == ElementKind::Coil;
        let mut value = self.used(one, &one.inputs)?;
        if is_coil && one.uses > 0 {
            value = self.store(one, (id, ""), value);
        }
        // Generators ignore an edge at an output, and at a coil with a second modifier (negated, set or reset).
        let has_sign = !is_coil || one.negated_in || one.latch.is_some();
        if let Some(edge) = self.edge_beside(one.edge, has_sign) {
            let always = self.truth(true, one.line);
            value = self.edge(one, (id, ""), edge, value, always)?;
        }
        if one.negated_in && (is_coil || self.obeys(true)) {
            value = value.negated();
        }
        let latch = one.latch.filter(|_| !self.is_generated || is_coil && !one.negated_in);
        self.progress.differs_in_itself |= latch != one.latch;
        let is_taken = match &one.inputs[..] {
            // Some controllers do not write an element without an incoming connection.
            [] => self.any(one.line),
            from if !is_coil => self.is_taken(from),
            _ => self.truth(true, one.line),
        };
        let scope = self.sheet.scope;
        let kind = match latch {
            Some(set) => {
                let kind = self.resolver.latch(scope, target, set, &value.value(), one.line);
                match self.sheet.drawing.is_executed_as_drawn {
                    true => kind,
                    false => kind.and_then(|kind| self.resolver.latch_or_if(kind, one.line)),
                }
            }
            None => self.resolver.assign(scope, target, &value.value(), one.line),
        };
        let kind = resolved(kind.map_err(|fault| at_element(one, fault)));
        self.add_if(one.line, is_taken, kind, &scanbound_iec::show::path(target));
        Ok(())
    }
}

impl Resolver<'_> {
    /// A set or reset, or the IF statement that generators write for it.
    fn latch_or_if(&mut self, kind: StatementKind, line: u32) -> Result<StatementKind, Fault> {
        let StatementKind::Latch(target, set, condition) = kind else { return Ok(kind) };
        let text = target.text.clone();
        let value = Expr { kind: ExprKind::Bool(set), ty: self.bool(), line };
        let assigned = self.assigned(target.clone(), value, line)?;
        let one = |kind| vec![Statement { kind, text: text.clone(), line }];
        let generated = StatementKind::If(vec![(condition.clone(), one(assigned))], Vec::new());
        let latch = StatementKind::Latch(target, set, condition);
        Ok(StatementKind::Either(
            "set and reset coils are IF statements",
            one(generated),
            one(latch),
        ))
    }

    /// Declares an internal variable of the method or unit, used only by a drawing.
    fn hidden_variable(&mut self, scope: Scope, name: String, ty: TypeId) -> VarId {
        let owner = match (scope.method, scope.unit) {
            (Some(method), _) => Owner::Routine(method),
            (None, Some(unit)) => Owner::Unit(unit),
            (None, None) => unreachable!("code belongs to a unit"),
        };
        let first = match self.tree.types.get(ty) {
            Type::Elementary(_) => First::Zero,
            _ => First::Unknown,
        };
        let begins = self.begins_plainly(ty);
        let id = VarId::at(self.tree.variables.len());
        let symbol = self.index.symbol(&name);
        self.tree.variables.push(Variable {
            name,
            symbol,
            section: Section::Local,
            ty,
            owner,
            initial: None,
            first,
            begins,
            type_calls: false,
            at: None,
            constant: false,
            retain: false,
            is_internal: true,
            has_edge: false,
            line: 0,
        });
        // The result of a function or method must stay the last variable.
        let (variables, result) = match owner {
            Owner::Routine(method) => {
                let own = &mut self.tree.routines[method.index()];
                (&mut own.variables, own.result)
            }
            _ => {
                let own = &mut self.tree.units[scope.unit.map_or(0, |unit| unit.index())];
                (&mut own.variables, own.result)
            }
        };
        variables.insert(variables.len() - usize::from(result.is_some()), id);
        id
    }
}

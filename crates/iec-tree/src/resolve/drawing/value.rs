//! Evaluation of a drawing: the value of an element's output when it is needed.

use super::state::{Drawer, Output, Term, Use, at_element, resolved};
use super::touched::{Held, Touched};
use super::worth::{Kept, Shape, Worth};
use crate::blocks::{Pin, StandardBlock};
use crate::declarations::TempId;
use crate::show;
use crate::tree::{
    Call, Enable, Expr, ExprKind, Parameter, Passed, Statement, StatementKind, Step, Target,
};
use crate::types::Type;
use scanbound_base::code::Code;
use scanbound_iec::ast::{self, Literal, Operator};
use scanbound_iec::drawing::{Connection, Edge, Element, ElementId, ElementKind};
use scanbound_iec::fault::Fault;
use scanbound_iec::written::{DEPTH, Operand, Path, VISITS, Written, written};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// The maximum number of nodes of one expression: connectors may repeat expressions that are long themselves.
const SIZE: usize = 4 * VISITS;

/// The maximum number of values in a drawing for which controllers differ, since each makes the expressions larger.
const EITHERS: usize = 1000;

/// Up to this many operands are joined in a chain; more are split in halves, so that expressions do not become too
/// deep.
const ROW: usize = 100;

impl<'d> Drawer<'_, '_, 'd> {
    /// A constant `TRUE` or `FALSE`.
    pub(super) fn truth(&self, value: bool, line: u32) -> Worth {
        let expr = Expr { kind: ExprKind::Bool(value), ty: self.resolver.bool(), line };
        Worth { expr, shape: Shape::Truth(value), written: None }
    }

    /// A value that may be anything.
    pub(super) fn any(&mut self, line: u32) -> Worth {
        let ty = self.resolver.unknown();
        Worth::formula(Expr { kind: ExprKind::Either(None), ty, line })
    }

    /// The value of the expression written at an element or pin.
    pub(super) fn written(&mut self, of: &ast::Expr, one: &Element) -> Worth {
        let shape = match of {
            ast::Expr::Literal(Literal::Bool(value)) => Shape::Truth(*value),
            ast::Expr::Literal(_) => Shape::Constant,
            ast::Expr::Variable(_) => Shape::Variable,
            _ => Shape::Formula,
        };
        let mut expr = self.resolver.expression(self.sheet.scope, of, one.line);
        let mut written = Some(Rc::new(of.clone()));
        if let ExprKind::Fault(fault) = &mut expr.kind {
            **fault = at_element(one, (**fault).clone());
            written = None;
        }
        Worth { expr, shape, written }
    }

    fn operand(&mut self, one: &Element) -> Result<Worth, Fault> {
        let operand = one.operand.as_ref().map_err(Fault::clone)?;
        Ok(self.written(operand, one))
    }

    fn binary(&mut self, operator: Operator, one: Worth, other: Worth) -> Worth {
        Worth::formula(self.resolver.operation(operator, one.expr, other.expr))
    }

    fn and(&mut self, one: Worth, other: Worth) -> Worth {
        match (one.is(true), other.is(true)) {
            (true, _) => other,
            (_, true) => one,
            _ => self.binary(Operator::And, one, other),
        }
    }

    /// Either of two values, because controllers differ; if both are equal, that value. A fault if there are too many.
    fn either(&mut self, one: Worth, other: Worth) -> Result<Worth, Fault> {
        if one.expr == other.expr {
            return Ok(one);
        }
        self.progress.eithers += 1;
        if self.progress.eithers > EITHERS {
            let what = format!("controllers differ in more than {EITHERS} values of this drawing");
            let help = "draw it as several actions, or put coils in front of forks";
            return Err(Fault::new(one.expr.line, what).code(Code::NotModelled).help(help));
        }
        Ok(self.one_of(one, other))
    }

    /// Either of two values, because controllers differ.
    pub(super) fn one_of(&mut self, one: Worth, other: Worth) -> Worth {
        let line = one.expr.line;
        let types = &mut self.resolver.tree.types;
        let ty = crate::standard::meeting(types, one.expr.ty, other.expr.ty);
        let both = Some(Box::new((one.expr, other.expr)));
        Worth::formula(Expr { kind: ExprKind::Either(both), ty, line })
    }

    fn all_of(&mut self, operator: Operator, mut ways: Vec<Worth>) -> Option<Worth> {
        if ways.len() > ROW {
            let back = ways.split_off(ways.len() / 2);
            let (front, back) = (self.all_of(operator, ways)?, self.all_of(operator, back)?);
            return Some(self.binary(operator, front, back));
        }
        ways.into_iter().reduce(|one, other| self.binary(operator, one, other))
    }

    /// The value that arrives through connections at one coil, output or pin. Generators write one expression for each
    /// of these, in which contacts are evaluated again.
    pub(super) fn used(
        &mut self,
        one: &'d Element,
        from: &'d [Connection],
    ) -> Result<Worth, Fault> {
        let is_text = self.is_generated || self.sheet.drawing.goal.is_some();
        let sheet = self.sheet;
        let text = written(sheet.drawing, &sheet.behind_edges, from, is_text);
        let is_written_once = text.as_ref().is_some_and(Written::is_written_once);
        let term = Term { is_written_once, ..Term::default() };
        let outer = std::mem::replace(&mut self.term, term);
        let value = match text.filter(|_| self.is_written()) {
            Some(text) => self.text(one, &text),
            None => self.ways(from).map(|ways| self.joined(one.line, ways)),
        };
        self.term = outer;
        value
    }

    /// The value of an expression in the form that generators write.
    fn text(&mut self, end: &'d Element, text: &Written<'d>) -> Result<Worth, Fault> {
        let mut values = BTreeMap::new();
        for &operand in &text.visited {
            let id = operand.0.0;
            let one = self.element(id);
            let value = match one.kind {
                _ if values.contains_key(&operand) => continue,
                ElementKind::Contact => {
                    self.begin_loop(id)?;
                    let value = self.contact(id, one)?;
                    self.note_look(operand.0, &value);
                    value
                }
                // Generators execute this coil in its own place in the order.
                ElementKind::Coil if one.inputs.len() == 1 => {
                    self.begin_loop(id)?;
                    if !self.is_generated {
                        self.act(id)?;
                    }
                    continue;
                }
                _ => self.worth(operand.0)?,
            };
            values.insert(operand, value);
        }
        // Blocks executed during the evaluation may have changed values that were read before.
        let mut looked =
            text.visited.iter().map(|(output, _)| Held::Output(output.0, output.1.to_owned()));
        if looked.any(|held| self.has_changed(&held)) {
            self.looks_again();
        }
        let value = match &text.path {
            Some(path) => self.of_path(path, &values, end.line),
            None => self.truth(false, end.line),
        };
        let mut size = 0;
        value.expr.each(&mut |_| size += 1);
        if size > SIZE {
            let what = "the paths that lead to it fork and join too often";
            let help = "put a coil in between, and use its variable";
            return Err(end.fault(what).code(Code::NotModelled).help(help));
        }
        Ok(value)
    }

    fn of_path(
        &mut self,
        path: &Path<'d>,
        values: &BTreeMap<Operand<'d>, Worth>,
        line: u32,
    ) -> Worth {
        let power = self.truth(true, line);
        let mut joined = |operator, all: &[Rc<Path<'d>>]| {
            let all: Vec<Worth> = all.iter().map(|one| self.of_path(one, values, line)).collect();
            self.all_of(operator, all)
        };
        match path {
            Path::Power => power,
            // Each operand of an expression was visited.
            Path::One(operand) => values[operand].clone(),
            Path::Row(all) => joined(Operator::And, all).unwrap_or(power),
            Path::Fork(all) if all.iter().any(|one| **one == Path::Power) => power,
            Path::Fork(all) => joined(Operator::Or, all).unwrap_or(power),
        }
    }

    /// Records that a stored value is read; if it may have changed since it was first read, requests another pass.
    fn note_look(&mut self, output: Output<'d>, value: &Worth) {
        if self.is_generated || self.sheet.drawing.goal.is_some() {
            return;
        }
        let held = Held::Output(output.0, output.1.to_owned());
        if !self.progress.stored.contains_key(&held) {
            let touched = self.resolver.touched_by(&value.expr);
            self.progress.stored.insert(held, (touched, self.progress.all.len()));
        } else if self.has_changed(&held) {
            self.looks_again();
        }
    }

    /// Requests another pass over the drawing, in which values are stored when they are first read.
    fn looks_again(&mut self) {
        self.hidden.is_stale |= !self.hidden.looks_again;
        self.hidden.looks_again = true;
    }

    /// Executes the blocks at which a feedback loop starts, when an element of the loop is evaluated first.
    fn begin_loop(&mut self, id: ElementId) -> Result<(), Fault> {
        for first in self.loops.first(id, &self.open, &self.progress.done) {
            if !self.comes_later(self.element(first)) {
                self.block(first)?;
            }
        }
        Ok(())
    }

    /// The values that the connections bring.
    fn ways(&mut self, from: &'d [Connection]) -> Result<Vec<Worth>, Fault> {
        let way = |one: &'d Connection| self.worth((one.from, &one.output));
        from.iter().map(way).collect()
    }

    /// Joins the values of several connections by OR; FALSE if there is no connection.
    fn joined(&mut self, line: u32, ways: Vec<Worth>) -> Worth {
        self.all_of(Operator::Or, ways).unwrap_or_else(|| self.truth(false, line))
    }

    fn worth(&mut self, key: Output<'d>) -> Result<Worth, Fault> {
        let id = key.0;
        if let Some(value) = self.term.looked_at.get(&key).filter(|_| self.term.is_written_once) {
            return Ok(value.clone());
        }
        let one = self.element(id);
        self.term.visits += 1;
        let refused =
            |what: &str, help: &str| Err(one.fault(what).code(Code::NotModelled).help(help));
        if self.term.visits > VISITS && !self.term.is_written_once {
            let help = "put a coil in between, and use its variable";
            return refused("the paths through it fork and join too often", help);
        }
        if self.is_fed_back(id, one) {
            return self.fed_back(key, one);
        }
        self.begin_loop(id)?;
        if self.depth >= DEPTH {
            let what = format!("more than {DEPTH} elements are connected to it in series");
            return refused(&what, "put a coil in between");
        }
        if !self.open.insert(id) {
            let what = "the connections through it form a loop";
            return Err(one.fault(what).code(Code::Connection));
        }
        self.depth += 1;
        let found = self.put_out(key, one);
        self.depth -= 1;
        self.open.remove(&id);
        let found = found?;
        // The value of a contact is fixed when it is evaluated; a variable read by a connection is read where it is
        // used.
        let is_plain = match found.shape {
            Shape::Truth(_) | Shape::Constant => true,
            Shape::Variable => !matches!(one.kind, ElementKind::Contact | ElementKind::Coil),
            Shape::Formula => false,
        };
        let value = match self.progress.kept.get(&key).cloned() {
            _ if is_plain => found,
            // Some controllers evaluate it again and some do not; generated text always does.
            Some(kept) if !self.is_generated && self.has_changed(&kept.held) => {
                self.either(kept.value, found)?
            }
            _ => found,
        };
        let is_stored = one.uses >= 2 || self.hidden.looks_again;
        let value = match is_plain || !is_stored {
            true => value,
            false if self.is_written() => {
                self.note_look(key, &value);
                value
            }
            false => self.store(one, key, value),
        };
        self.term.looked_at.insert(key, value.clone());
        Ok(value)
    }

    /// Stores a value in a temporary, because its operands may change before it is used again. For a condition the
    /// value stays as it is.
    pub(super) fn store(&mut self, one: &Element, key: Output<'d>, value: Worth) -> Worth {
        // A condition's operands are written where they are used.
        if self.sheet.drawing.goal.is_some() {
            return value;
        }
        let own = self.next_key(Use::Way, key);
        let id = self.temporary(own, value.expr.ty);
        let (stored, touched) = self.keep(one.line, id, value.expr, None);
        let held = Held::Temporary(id);
        self.progress.stored.insert(held.clone(), (touched, self.progress.all.len()));
        let kept = Kept { value: stored.clone(), held };
        self.progress.kept.entry(key).or_insert(kept);
        stored
    }

    /// Emits the statement that stores a value in a temporary. Returns the value read from the temporary, and the cells
    /// that the stored expression reads.
    pub(super) fn keep(
        &mut self,
        line: u32,
        id: TempId,
        value: Expr,
        shown: Option<String>,
    ) -> (Worth, Touched) {
        self.resolver.tree.temporaries[id.index()].ty = value.ty;
        let place = self.resolver.kept_place(id);
        let touched = self.resolver.touched_by(&value);
        let kind = match value.kind {
            ExprKind::Fault(fault) => StatementKind::Fault(fault),
            _ => StatementKind::Keep(id, value),
        };
        let text = shown.map(|shown| format!("{} := {shown};", place.text));
        let text = text.unwrap_or_else(|| show::statement(&self.resolver.tree, &kind, &place.text));
        self.add(line, kind, text);
        (Worth::variable(place, line), touched)
    }

    /// Whether evaluating a stored value again could give another result.
    fn has_changed(&self, held: &Held) -> bool {
        let mut open = vec![held];
        let mut seen = BTreeSet::new();
        while let Some(held) = open.pop() {
            let Some((value, since)) = self.progress.stored.get(held) else { continue };
            let later = self.progress.all[*since..].iter();
            if { later }.any(|one| self.resolver.may_change(&one.touched, value)) {
                return true;
            }
            open.extend(value.held.iter().filter(|held| seen.insert(*held)));
        }
        false
    }

    /// Whether a block that has not run yet must not run now: its number is later than that of the current element, or
    /// both have numbers and the code is generated.
    fn comes_later(&self, one: &Element) -> bool {
        let numbers = one.order.zip(self.progress.acting);
        numbers.is_some_and(|(own, acting)| own > acting || self.is_generated)
    }

    /// Whether a block's output is read before the block runs in this scan, through a feedback loop or because of a
    /// later execution number. It then has the value of the previous scan.
    fn is_fed_back(&self, id: ElementId, one: &Element) -> bool {
        if one.block().is_none() {
            return false;
        }
        let later = self.comes_later(one) && (one.is_instance() || self.loops.holds(id));
        let is_done = self.progress.done.contains(&id);
        self.open.contains(&id) || (!is_done && (later || self.loops.is_behind(id, &self.open)))
    }

    fn put_out(&mut self, key: Output<'d>, one: &'d Element) -> Result<Worth, Fault> {
        let id = key.0;
        match &one.kind {
            ElementKind::LeftRail => Ok(self.truth(true, one.line)),
            ElementKind::Contact => {
                let ways = self.ways(&one.inputs)?;
                let way = self.joined(one.line, ways);
                let value = self.contact(id, one)?;
                Ok(self.and(way, value))
            }
            // Elements after a coil get the coil's incoming value from before the write, or evaluate it again.
            // Generators execute the coil in its own place in the order, and join several incoming values by AND.
            ElementKind::Coil => {
                if !self.is_generated {
                    self.act(id)?;
                    return self.joining(one);
                }
                let ways = one.inputs.iter().map(|way| self.used(one, std::slice::from_ref(way)));
                let ways = ways.collect::<Result<Vec<_>, _>>()?;
                self.progress.differs_in_itself |= ways.len() > 1;
                let any = self.joined(one.line, ways.clone());
                match self.all_of(Operator::And, ways) {
                    Some(all) => self.either(any, all),
                    None => Ok(any),
                }
            }
            ElementKind::RightRail | ElementKind::Connector | ElementKind::Out => self.joining(one),
            ElementKind::In | ElementKind::InOut => {
                // The incoming value is written before the variable is read; generated code writes it in its own place
                // in the order.
                if !one.inputs.is_empty() && !self.is_generated {
                    self.act(id)?;
                }
                let value = self.operand(one)?;
                Ok(if self.obeys(one.negated_out) { value.not() } else { value })
            }
            ElementKind::Continuation(from) => self.worth((*from, "")),
            ElementKind::Block(_) => {
                if !self.progress.done.contains(&id) {
                    self.comes_in_time(one)?;
                }
                self.block(id)?;
                Ok(self.block_output(id, key.1))
            }
            kind => {
                let what = format!("elements {} are not followed", kind.name());
                Err(one.fault(&what).code(Code::Syntax))
            }
        }
    }

    /// The incoming value of an element that passes it on.
    fn joining(&mut self, one: &'d Element) -> Result<Worth, Fault> {
        if self.is_written() {
            return self.used(one, &one.inputs);
        }
        let ways = self.ways(&one.inputs)?;
        Ok(self.joined(one.line, ways))
    }

    /// The value of a contact's variable, with edge and negation applied.
    fn contact(&mut self, id: ElementId, one: &'d Element) -> Result<Worth, Fault> {
        let value = self.operand(one)?;
        let value = match self.edge_beside(one.edge, one.negated_in) {
            Some(edge) => {
                let always = self.truth(true, one.line);
                self.edge(one, (id, ""), edge, value, always)?
            }
            None => value,
        };
        Ok(if one.negated_in { value.not() } else { value })
    }

    /// Rejects a block that its consumer precedes by execution number, or a block without a number whose consumer has
    /// one.
    fn comes_in_time(&self, one: &Element) -> Result<(), Fault> {
        let Some(_) = self.progress.acting else { return Ok(()) };
        let why = match one.order {
            Some(_) if self.comes_later(one) => "is executed before it, by their numbers",
            Some(_) => return Ok(()),
            None => {
                "has an executionOrderId, and it has none: which of them comes first is not clear"
            }
        };
        let what = format!("the element that uses its result {why}");
        let help = "give it a smaller number than the element that uses its result";
        Err(one.fault(&what).code(Code::NotModelled).help(help))
    }

    /// The output of an edge detection that runs if `looked_at` is true. Generators create an instance for each use,
    /// other tools one for all uses. Both agree as long as all uses see the same value.
    pub(super) fn edge(
        &mut self,
        one: &Element,
        of: Output<'d>,
        edge: Edge,
        value: Worth,
        looked_at: Worth,
    ) -> Result<Worth, Fault> {
        let block = match edge {
            Edge::Rising => StandardBlock::RTrig,
            Edge::Falling => StandardBlock::FTrig,
        };
        let ty = self.resolver.tree.types.id(Type::Standard(block));
        let key = self.next_key(Use::Edge, of);
        let id = self.variable(key, ty);
        if key.2 == 1 && of.1.is_empty() {
            self.note_for_condition(id, one, None);
        }
        let place = self.resolver.start(id);
        let touched = self.resolver.touched_by(&value.expr);
        let bool = self.resolver.bool();
        let clock = Passed::ByValue(self.resolver.converted(value.expr, bool));
        let call = Call {
            target: Target::Standard(place.clone(), block),
            passed: vec![(Parameter::Pin(Pin::Clk), clock)],
            enable: Enable::default(),
        };
        let text = place.text.to_string();
        let kind = match looked_at.is(true) {
            true => StatementKind::Call(call),
            false => {
                let kind = StatementKind::Call(call);
                let inner = Statement { kind, text: place.text.clone(), line: one.line };
                StatementKind::CallIf(looked_at.expr, Box::new(inner))
            }
        };
        // If it feeds no block, an edge in a condition belongs to its contact.
        let is_block_s = self.element(self.progress.owner).block().is_some();
        let owner = match self.sheet.drawing.goal.is_some() && !is_block_s {
            true => of.0,
            false => self.progress.owner,
        };
        let outer = std::mem::replace(&mut self.progress.owner, owner);
        self.add(one.line, resolved(Ok(kind)), text);
        self.progress.owner = outer;
        let mut shows = place;
        shows.steps.push(Step::Pin(Pin::Q));
        shows.ty = bool;
        let shows = Worth::variable(shows, one.line);
        let held = Held::Edge(id);
        let Some(first) = self.progress.edges.get(&of).cloned() else {
            self.progress.stored.insert(held.clone(), (touched, self.progress.all.len()));
            self.progress.edges.insert(of, Kept { value: shows.clone(), held });
            return Ok(shows);
        };
        match self.sheet.has_jumps || self.has_changed(&first.held) {
            // Drawings with an edge before a connector that is used several times are refused.
            true if self.is_generated => Ok(shows),
            true => self.either(first.value, shows),
            false => Ok(first.value),
        }
    }
}

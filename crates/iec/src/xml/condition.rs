//! Translates drawn conditions to expressions. If their blocks are executed by an action in each scan, the outputs are
//! read from variables.

use super::drawn::{drawing, leads_to_something};
use super::reading::Reading;
use crate::ast::{Argument, Expr, Held};
use crate::drawing::{Block, Connection, Drawing, Element, ElementId, ElementKind, Given};
use crate::fault::Fault;
use crate::written::{DEPTH, VISITS};
use roxmltree::Node;
use scanbound_base::code::Code;
use std::collections::BTreeSet;

/// Up to this many operands are joined in a chain; more are split in halves, so that expressions do not become too
/// deep.
const ROW: usize = 100;

/// The condition given by a drawing: the incoming value of its only coil or output, or of the right power rail.
pub(super) fn of_body(reading: &mut Reading<'_, '_>, body: Node<'_, '_>) -> Result<Expr, Fault> {
    let drawing = drawing(reading.text, body)?;
    let is_end = |one: &&Element| match one.kind {
        ElementKind::Coil | ElementKind::Out => true,
        ElementKind::InOut => !one.inputs.is_empty(),
        _ => false,
    };
    let mut ends: Vec<&Element> = drawing.elements.iter().filter(is_end).collect();
    if ends.is_empty() {
        let is_rail = |one: &&Element| one.kind == ElementKind::RightRail;
        ends.extend(drawing.elements.iter().filter(is_rail));
    }
    let [end] = ends[..] else {
        let message = match ends[..] {
            [] => "the condition has no coil or output",
            _ => "the condition has several coils or outputs",
        };
        return Err(reading.text.fault(body, message).help("leave one coil or output in it"));
    };
    let remembers = end.edge.is_some() || end.latch.is_some();
    let moving = drawing.elements.iter().find(|one| one.moves());
    if let Some(one) = moving.or(remembers.then_some(end)) {
        return Err(one.fault("it is not followed in a condition"));
    }
    let (from, is_negated, called) = (end.inputs.clone(), end.negated_in, end.called());
    leads_to_something(&drawing, from.iter().map(|one| one.from))?;
    let value = value(reading, &drawing, from, &called)?;
    Ok(if is_negated { value.not() } else { value })
}

/// The condition connected to a transition.
pub(super) fn of_transition(
    reading: &mut Reading<'_, '_>,
    body: Node<'_, '_>,
    node: Node<'_, '_>,
    called: &str,
    from: &[(&str, Option<&str>)],
) -> Result<Expr, Fault> {
    let drawing = drawing(reading.text, body)?;
    let wires = from.iter().map(|(id, output)| {
        let missing = || {
            let what =
                format!("{called}: a connection refers to localId {id}, which does not exist");
            reading.text.fault(node, what).code(Code::Connection)
        };
        let from = drawing.all().find(|(_, one)| one.local_id == **id).ok_or_else(missing)?.0;
        Ok(Connection { from, output: output.unwrap_or_default().to_owned() })
    });
    let wires = wires.collect::<Result<Vec<_>, Fault>>()?;
    value(reading, &drawing, wires, called)
}

/// Translates the value that arrives through connections.
fn value(
    reading: &mut Reading<'_, '_>,
    drawing: &Drawing,
    from: Vec<Connection>,
    called: &str,
) -> Result<Expr, Fault> {
    if let Some(one) =
        drawing.elements.iter().find(|one| !drawing.is_executed_as_drawn && has_lost_sign(one))
    {
        let what = "generators ignore a negation or an edge of it in a condition";
        let help =
            "negate with a contact or a function NOT, and detect edges with R_TRIG or F_TRIG";
        return Err(one.fault(what).code(Code::NotModelled).help(help));
    }
    let mut blocks = drawing.elements.iter().filter(|one| one.block().is_some());
    if let Some(one) = blocks.find(|one| !drawing.is_executed_as_drawn && one.order.is_some()) {
        let what = "it has an executionOrderId in a condition: generators then do not execute the blocks that feed it";
        let help = "leave its executionOrderId out";
        return Err(one.fault(what).code(Code::NotModelled).help(help));
    }
    let mut walk = Walk {
        drawing,
        called,
        apart: (reading.computes && !drawing.is_executed_as_drawn).then(|| reading.part.clone()),
        acts: false,
        met: BTreeSet::new(),
        open: BTreeSet::new(),
        visits: 0,
    };
    let value = walk.joined(&from)?;
    if walk.acts {
        let part = reading.part.clone();
        reading.compute(part, from, drawing);
    }
    Ok(value)
}

/// Whether an element has a negation or edge that generators ignore.
fn has_lost_sign(one: &Element) -> bool {
    let is_negated = one.negated_in || one.negated_out;
    match &one.kind {
        ElementKind::Block(block) => {
            block.inputs.iter().any(|pin| pin.negated && pin.edge.is_some())
        }
        ElementKind::Contact => is_negated && one.edge.is_some(),
        _ => is_negated,
    }
}

struct Walk<'d> {
    drawing: &'d Drawing,
    /// The element that has the condition, for messages.
    called: &'d str,
    /// The name of the condition if its blocks are executed by an action; otherwise `None`.
    apart: Option<String>,
    /// Whether there are blocks or edges to execute.
    acts: bool,
    /// The blocks visited so far.
    met: BTreeSet<ElementId>,
    open: BTreeSet<ElementId>,
    visits: usize,
}

impl<'d> Walk<'d> {
    fn refused(&self, line: u32, what: &str, help: &str) -> Fault {
        Fault::new(line, format!("{}: {what}", self.called)).code(Code::NotModelled).help(help)
    }

    fn remembers(&self, line: u32) -> Fault {
        let help = "execute the block in an action, and use its output";
        self.refused(line, "a condition with a block that keeps state is not followed", help)
    }

    fn joined(&mut self, from: &[Connection]) -> Result<Expr, Fault> {
        let ways = from.iter().map(|one| self.worth(one.from, &one.output));
        let ways = ways.collect::<Result<Vec<_>, _>>()?;
        // Without a connection the value is FALSE.
        Ok(any_of(&ways).unwrap_or_else(|| Expr::bool(false)))
    }

    fn worth(&mut self, id: ElementId, output: &str) -> Result<Expr, Fault> {
        let one = self.drawing.element(id);
        self.visits += 1;
        if self.visits > VISITS {
            let help = "draw a part of it with a coil, and use that here";
            let what = "its paths fork and join too often to be followed";
            return Err(self.refused(one.line, what, help));
        }
        if self.open.len() > DEPTH {
            let what = format!("more than {DEPTH} elements are connected to it in series");
            return Err(one.fault(&what).code(Code::NotModelled).help("put a coil in between"));
        }
        if !self.open.insert(id) {
            let what = "the connections through it form a loop";
            return Err(one.fault(what).code(Code::Connection));
        }
        let found = self.put_out(id, one, output);
        self.open.remove(&id);
        found
    }

    fn put_out(&mut self, id: ElementId, one: &'d Element, output: &str) -> Result<Expr, Fault> {
        let negated = |value: Expr, negated: bool| if negated { value.not() } else { value };
        match &one.kind {
            ElementKind::LeftRail => Ok(Expr::bool(true)),
            ElementKind::Contact => {
                let way = self.joined(&one.inputs)?;
                let value = match (&one.edge, &self.apart) {
                    (None, _) => one.operand.clone()?,
                    (Some(_), None) => return Err(self.remembers(one.line)),
                    (Some(_), Some(part)) => {
                        self.acts = true;
                        held(part, one, None)
                    }
                };
                Ok(way.and(negated(value, one.negated_in)))
            }
            ElementKind::RightRail | ElementKind::Connector => self.joined(&one.inputs),
            ElementKind::In => Ok(negated(one.operand.clone()?, one.negated_out)),
            ElementKind::InOut if one.inputs.is_empty() => {
                Ok(negated(one.operand.clone()?, one.negated_out))
            }
            ElementKind::Continuation(from) => self.worth(*from, ""),
            ElementKind::Block(block) => self.block(id, one, block, output),
            ElementKind::Coil | ElementKind::Out | ElementKind::InOut => {
                Err(self.remembers(one.line))
            }
            kind => {
                let what = format!("{}: elements {} are not followed", one.called(), kind.name());
                Err(Fault::new(one.line, what))
            }
        }
    }

    fn block(
        &mut self,
        id: ElementId,
        one: &Element,
        block: &Block,
        output: &str,
    ) -> Result<Expr, Fault> {
        let is_first_time = self.met.insert(id);
        let first = block.results().next().unwrap_or_default();
        let named = if output.is_empty() { first } else { output };
        let is_given_back = block.has_input(named) && block.has_output(named);
        let is_written = block.outputs.iter().any(|pin| pin.written.is_some());
        if block.code.is_some() || is_written || is_given_back {
            return Err(self.remembers(one.line));
        }
        let is_enable = named.eq_ignore_ascii_case("ENO");
        let is_negated = block.negates(named);
        let value = match (&self.apart, &block.instance) {
            (None, Some(_)) => return Err(self.remembers(one.line)),
            (None, None) if !is_first_time || named != first => {
                return Err(self.remembers(one.line));
            }
            (None, None) => self.called(one, block)?,
            (Some(_), _) if is_enable && !block.gives_enable() => {
                let what = "ENO of this block is not followed in a condition";
                let help = "use another output of the block, or the condition at EN";
                return Err(self.refused(one.line, what, help));
            }
            (Some(_), Some(instance)) => {
                self.acts = true;
                Expr::Variable(instance.clone()?.with(named))
            }
            (Some(part), None) => {
                self.acts = true;
                held(part, one, Some(named))
            }
        };
        Ok(if is_negated { value.not() } else { value })
    }

    /// The value of a pin; `None` if it is unconnected.
    fn given(&mut self, given: &Given, is_negated: bool) -> Result<Option<Expr>, Fault> {
        let value = match given {
            Given::Nothing => return Ok(None),
            Given::Written(value) => value.clone()?,
            Given::Wired(from) => self.joined(from)?,
        };
        Ok(Some(if is_negated { Expr::Not(Box::new(value)) } else { value }))
    }

    /// The call of a function with its inputs.
    fn called(&mut self, one: &Element, block: &Block) -> Result<Expr, Fault> {
        let mut given = Vec::new();
        for pin in &block.inputs {
            if pin.edge.is_some() {
                return Err(self.remembers(one.line));
            }
            let Some(value) = self.given(&pin.given, pin.negated)? else { continue };
            let name = Some(pin.name.clone()).filter(|name| !name.is_empty());
            given.push(Argument { name, is_output: false, value });
        }
        if block.are_counted(given.iter().filter(|one| !is_enable(one)).count()) {
            given.iter_mut().filter(|one| !is_enable(one)).for_each(|one| one.name = None);
        }
        Ok(Expr::Call(block.function.clone()?, given))
    }
}

fn held(part: &str, one: &Element, output: Option<&str>) -> Expr {
    Expr::Held(Box::new(Held {
        part: part.to_owned(),
        local_id: one.local_id.clone(),
        output: output.map(str::to_owned),
    }))
}

fn is_enable(one: &Argument) -> bool {
    one.name.as_ref().is_some_and(|name| name.eq_ignore_ascii_case("EN"))
}

fn any_of(ways: &[Expr]) -> Option<Expr> {
    if ways.len() <= ROW {
        return ways.iter().cloned().reduce(Expr::or);
    }
    let (front, back) = ways.split_at(ways.len() / 2);
    Some(any_of(front)?.or(any_of(back)?))
}

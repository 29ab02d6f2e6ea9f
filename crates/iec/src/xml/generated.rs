//! Refuses drawings of which generators of text (Beremiz, OpenPLC) make something else than they show.

use crate::ast::{Expr, Operator};
use crate::drawing::{Block, Connection, Drawing, Element, ElementId, ElementKind, Given};
use crate::fault::Fault;
use scanbound_base::code::Code;
use std::collections::BTreeSet;

/// Refuses a drawing that generators do not write as it is shown.
pub(super) fn is_written_as_shown(drawing: &Drawing) -> Result<(), Fault> {
    for one in &drawing.elements {
        if let Some(from) = one.sources().find(|from| is_unclear(drawing.element(from.from), from))
        {
            let from = drawing.element(from.from).called();
            let what = format!("which output of {from} leads to it is not said");
            let help = "draw the connection anew: formalParameter names the output";
            return Err(one.fault(&what).code(Code::Connection).help(help));
        }
        let refused =
            |what: &str, help: &str| Err(one.fault(what).code(Code::NotModelled).help(help));
        if takes_copy(drawing, one) {
            let what = "generators copy what an instance gives to a pin that is handed over in and out, and what such a pin of an instance gives back";
            return refused(what, "connect the variable itself to every element that uses it");
        }
        if one.block().is_some_and(is_swapped) {
            let what = "generators hand its pins over as the file has them, which is not the order of their names";
            return refused(what, "draw the block anew");
        }
        if is_pasted(drawing, one) {
            let what =
                "generators write no parentheses around OR and XOR here, so that AND binds first";
            return refused(what, "assign the value to a variable, and connect that");
        }
    }
    Ok(())
}

/// Whether a connection names no output, and there are several: generators look for it by places.
fn is_unclear(from: &Element, connection: &Connection) -> bool {
    connection.output.is_empty() && from.block().is_some_and(|block| block.outputs.len() > 1)
}

/// Whether an element takes what an instance gives back, or hands an instance's output over in and out.
fn takes_copy(drawing: &Drawing, one: &Element) -> bool {
    let gives_back = |from: &Connection| {
        let source = drawing.element(from.from);
        let Some(block) = source.block().filter(|_| source.is_instance()) else { return false };
        let first = block.outputs.first().map_or("", |pin| &pin.name);
        let named = if from.output.is_empty() { first } else { &from.output };
        block.has_input(named)
    };
    let pins = one.block().into_iter().flat_map(|block| {
        block.inputs.iter().filter(|pin| pin.is_in_out || block.has_output(&pin.name))
    });
    let mut handed = pins.flat_map(|pin| match &pin.given {
        Given::Wired(from) => &from[..],
        Given::Written(_) | Given::Nothing => &[],
    });
    one.sources().any(gives_back) || handed.any(|from| drawing.element(from.from).is_instance())
}

/// Whether the pins of a function that may have more of them, and of which the order matters, stand in another order.
fn is_swapped(block: &Block) -> bool {
    const FUNCTIONS: &[&str] = &["GT", "GE", "LT", "LE", "MUX", "CONCAT"];
    let name = block.function.as_ref().ok().and_then(|path| path.as_name());
    let is_one =
        name.is_some_and(|name| FUNCTIONS.iter().any(|own| name.eq_ignore_ascii_case(own)));
    let number = |name: &str| name.to_ascii_uppercase().strip_prefix("IN")?.parse::<u32>().ok();
    let pins = block.inputs.iter().filter(|pin| !pin.name.eq_ignore_ascii_case("EN"));
    let numbers: Vec<_> = pins.map(|pin| number(&pin.name)).collect();
    is_one && block.instance.is_none() && !numbers.is_sorted()
}

/// Whether OR or XOR is written next to AND without parentheses, in front of an element.
fn is_pasted(drawing: &Drawing, one: &Element) -> bool {
    let is_weak = |from: &Connection| is_weak(drawing, from.from);
    match (&one.kind, &one.inputs[..]) {
        (ElementKind::Contact, [from]) => {
            let is_alone = drawing.element(from.from).kind == ElementKind::LeftRail;
            !is_alone && has_weak_operand(one) || is_weak(from)
        }
        (ElementKind::Contact, [_, _, ..]) => has_weak_operand(one),
        (ElementKind::Coil, [_, _, ..]) if one.uses > 0 => one.inputs.iter().any(is_weak),
        _ => false,
    }
}

/// Whether what an element gives is written as OR or XOR of something.
fn is_weak(drawing: &Drawing, from: ElementId) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![from];
    while let Some(id) = open.pop() {
        let one = drawing.element(id);
        let inputs = match one.kind {
            ElementKind::Contact | ElementKind::In | ElementKind::InOut
                if has_weak_operand(one) =>
            {
                return true;
            }
            ElementKind::Coil => &one.inputs,
            ElementKind::Continuation(from) => &drawing.element(from).inputs,
            _ => continue,
        };
        if one.kind != ElementKind::Coil && inputs.len() > 1 {
            return true;
        }
        open.extend(inputs.iter().map(|one| one.from).filter(|from| seen.insert(*from)));
    }
    false
}

/// Whether an element's expression is an OR or XOR, and is written without a sign around it.
fn has_weak_operand(one: &Element) -> bool {
    let is_signed = one.kind == ElementKind::Contact && (one.negated_in || one.edge.is_some());
    let weak = |operator| matches!(operator, Operator::Or | Operator::Xor | Operator::OrElse);
    !is_signed && matches!(one.operand, Ok(Expr::Binary(operator, ..)) if weak(operator))
}

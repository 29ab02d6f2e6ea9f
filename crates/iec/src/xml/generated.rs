//! Rejects drawings for which text generators (Beremiz, OpenPLC) produce other code than the drawing shows.

use crate::ast::{Expr, Operator};
use crate::drawing::{
    Block, Connection, Drawing, Element, ElementId, ElementKind, Given, InputPin,
};
use crate::fault::Fault;
use scanbound_base::code::Code;
use std::collections::{BTreeMap, BTreeSet};

/// Rejects a drawing that generators do not translate as drawn.
pub(super) fn is_written_as_shown(drawing: &Drawing) -> Result<(), Fault> {
    let mut uses: BTreeMap<ElementId, usize> = BTreeMap::new();
    for one in &drawing.elements {
        if let ElementKind::Continuation(connector) = one.kind {
            *uses.entry(connector).or_default() += one.uses;
        }
    }
    for (id, one) in drawing.all() {
        if let Some(from) = one.sources().find(|from| is_unclear(drawing.element(from.from), from))
        {
            let from = drawing.element(from.from).called();
            let what = format!("the connection to it does not name the output of {from}");
            let help = "draw the connection anew: formalParameter names the output";
            return Err(one.fault(&what).code(Code::Connection).help(help));
        }
        let refused =
            |what: &str, help: &str| Err(one.fault(what).code(Code::NotModelled).help(help));
        if let Some(from) = one.sources().find(|from| drawing.element(from.from).has_no_output()) {
            let from = drawing.element(from.from).called();
            let what = format!(
                "a connection comes from the {from}, which has no output: generators leave it out"
            );
            return refused(&what, "connect it to an element with an output");
        }
        if let ElementKind::Continuation(connector) = one.kind
            && one.uses > 0
            && drawing.element(connector).inputs.is_empty()
        {
            let what = "nothing is connected to its connector: generators leave it out";
            return refused(what, "connect the connector, or remove the continuation");
        }
        if takes_copy(drawing, one) {
            let what = "generators copy an instance's output that goes to a VAR_IN_OUT pin, and the output side of an instance's VAR_IN_OUT pin";
            return refused(what, "connect the variable itself to every element that uses it");
        }
        if one.block().is_some_and(is_swapped) {
            let what = "generators pass its pins in the order of the file, which is not the order of their names";
            return refused(what, "draw the block anew");
        }
        if one.block().is_some_and(takes_enable_as_operand) {
            let what = "it has EN, but no ENO: generators make EN an operand";
            return refused(what, "draw ENO too");
        }
        if one.block().is_some_and(has_gap) {
            let what = "an unconnected pin stands before a connected one: generators leave it out, so that the pins behind it move up";
            return refused(what, "connect the pins of the function without a gap");
        }
        if one.kind != ElementKind::RightRail
            && let Some(coil) = one.leading().find(|from| is_joining_coil(drawing, *from))
        {
            let coil = drawing.element(coil).called();
            let what = format!(
                "it is connected behind the {coil}, to which several connections lead: generators join them by AND here"
            );
            return refused(&what, "use a contact of the coil's variable in a rung of its own");
        }
        if one.kind == ElementKind::Connector
            && uses.get(&id).is_some_and(|uses| *uses > 1)
            && is_behind_edge(drawing, id)
        {
            let what = "a contact with an edge leads to it, and its continuations are used several times: generators detect the edge once";
            return refused(what, "assign the value to a variable, and use that");
        }
        if is_pasted(drawing, one) {
            let what =
                "generators write no parentheses around OR and XOR here, so that AND binds first";
            return refused(what, "assign the value to a variable, and connect that");
        }
    }
    Ok(())
}

/// Whether a connection does not name one of several outputs; generators then choose by position.
fn is_unclear(from: &Element, connection: &Connection) -> bool {
    connection.output.is_empty() && from.block().is_some_and(|block| block.outputs.len() > 1)
}

/// Whether an element uses the output side of an instance's VAR_IN_OUT, or passes an instance's output to a VAR_IN_OUT:
/// generators copy such values.
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

/// Whether it is a coil to which several connections lead. Generators write all that leads to it again for what follows
/// it, joined by AND, with `TRUE` for the left power rail.
fn is_joining_coil(drawing: &Drawing, id: ElementId) -> bool {
    let one = drawing.element(id);
    one.kind == ElementKind::Coil && one.inputs.len() > 1
}

/// The functions that take any number of operands. Generators pass these without names.
const EXTENSIBLE: &[&str] = &[
    "ADD", "MUL", "AND", "OR", "XOR", "MAX", "MIN", "MUX", "CONCAT", "GT", "GE", "EQ", "LE", "LT",
];

/// Whether a function has a connected EN and no output besides its result. Generators then pass EN without its name.
fn takes_enable_as_operand(block: &Block) -> bool {
    let is_enable = |pin: &InputPin| pin.name.eq_ignore_ascii_case("EN");
    let is_given = |pin: &&InputPin| !matches!(pin.given, Given::Nothing);
    let (enables, others): (Vec<_>, Vec<_>) =
        block.inputs.iter().filter(is_given).partition(|pin| is_enable(pin));
    block.instance.is_none()
        && block.code.is_none()
        && matches!(&block.outputs[..], [only] if !only.name.eq_ignore_ascii_case("ENO"))
        && !enables.is_empty()
        && !others.is_empty()
}

/// Whether a function that is called without names has an unconnected pin before a connected one. Generators name the
/// pins only where there is another output than the result, and never those of an extensible function.
fn has_gap(block: &Block) -> bool {
    let is_named = block.outputs.len() > 1 && !is_function_of(block, EXTENSIBLE);
    let pins = block.inputs.iter().filter(|pin| !pin.name.eq_ignore_ascii_case("EN"));
    let mut given = pins.map(|pin| !matches!(pin.given, Given::Nothing));
    block.instance.is_none()
        && !is_named
        && given.any(|is_given| !is_given)
        && given.any(|is_given| is_given)
}

/// Whether a block calls one of these functions.
fn is_function_of(block: &Block, functions: &[&str]) -> bool {
    let name = block.function.as_ref().ok().and_then(|path| path.as_name());
    block.instance.is_none()
        && name.is_some_and(|name| functions.iter().any(|own| name.eq_ignore_ascii_case(own)))
}

/// Whether the numbered pins of an extensible function whose order matters are not in ascending order.
fn is_swapped(block: &Block) -> bool {
    const FUNCTIONS: &[&str] = &["GT", "GE", "LT", "LE", "MUX", "CONCAT"];
    let number = |name: &str| name.to_ascii_uppercase().strip_prefix("IN")?.parse::<u32>().ok();
    let pins = block.inputs.iter().filter(|pin| !pin.name.eq_ignore_ascii_case("EN"));
    let numbers: Vec<_> = pins.map(|pin| number(&pin.name)).collect();
    is_function_of(block, FUNCTIONS) && !numbers.is_sorted()
}

/// Whether a contact with an edge belongs to the expression of a connector.
fn is_behind_edge(drawing: &Drawing, connector: ElementId) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![connector];
    while let Some(id) = open.pop() {
        let one = drawing.element(id);
        let is_followed = match one.kind {
            ElementKind::Contact if one.edge.is_some() => return true,
            ElementKind::Contact | ElementKind::Coil | ElementKind::Connector => true,
            ElementKind::Continuation(_) => true,
            _ => false,
        };
        if is_followed {
            open.extend(one.leading().filter(|from| seen.insert(*from)));
        }
    }
    false
}

/// Whether generators write OR or XOR next to AND without parentheses for this element.
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

/// Whether the value of an element is written as an OR or XOR.
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

/// Whether an element's expression is an OR or XOR that is written without NOT or an edge around it.
fn has_weak_operand(one: &Element) -> bool {
    let is_signed = one.kind == ElementKind::Contact && (one.negated_in || one.edge.is_some());
    let weak = |operator| matches!(operator, Operator::Or | Operator::Xor | Operator::OrElse);
    !is_signed && matches!(one.operand, Ok(Expr::Binary(operator, ..)) if weak(operator))
}

//! Reads bodies in any language, and charts as drawn in PLCopen XML: steps, transitions and bars, joined by
//! connections.

use super::checked::{checked, single};
use super::condition::{of_body, of_transition};
use super::drawn::{drawing, leads_to_something};
use super::generated_order::{Connections, Drawn, of_steps};
use super::node::{
    ACTIVE, BESIDE, ELEMENTS, ENTRY, EXCLUDED, EXIT, LEAST, MOST, Text, child, children, elements,
    inputs, is, position, sources,
};
use super::reading::{Reading, language};
use crate::ast::{Expr, Kind, Literal, Statement};
use crate::chart::draft::{Draft, DraftMacro, DraftTransition};
use crate::chart::expansion::DEEPEST;
use crate::chart::{Block, Chart, Qualifier, Step, Target};
use crate::drawing::{Drawing, Element, ElementId, ElementKind};
use crate::fault::Fault;
use crate::{Body, Language, parse, same};
use roxmltree::Node;
use scanbound_base::code::Code;
use std::collections::{BTreeMap, BTreeSet};

/// Reads the body in an element; a body without code gives an empty one.
pub(super) fn body(reading: &mut Reading<'_, '_>, node: Node<'_, '_>) -> Body {
    let Some((language, inner)) = language(node) else { return Body::empty() };
    if let Err(fault) = single(reading.text, node) {
        reading.refuse(fault.clone());
        return Body::Unread(language, fault);
    }
    if language == Language::Sfc {
        return match chart(reading, inner) {
            Ok(chart) => Body::Chart(Box::new(chart)),
            Err(fault) => {
                reading.refuse(fault.clone());
                Body::Unread(language, fault)
            }
        };
    }
    match executed(reading, language, inner) {
        Ok(found) => found,
        Err(fault) => {
            // Faults of the drawing itself reject the file; code that is only not understood is recorded in the body.
            if matches!(fault.code, Code::Connection | Code::Xml) {
                reading.refuse(fault.clone());
            }
            Body::Unread(language, fault.within(&reading.place))
        }
    }
}

fn executed(
    reading: &mut Reading<'_, '_>,
    language: Language,
    inner: Node<'_, '_>,
) -> Result<Body, Fault> {
    let (written, line) = reading.text.content(inner);
    Ok(match language {
        Language::St => Body::Code(language, parse::statements(&written, line)?),
        Language::Il => Body::Code(language, parse::instruction_list(&written, line)?),
        _ => {
            let drawing = drawing(reading.text, inner)?;
            // Not all tools evaluate what only leads to a connector.
            let is_end = |one: &Element| one.acts() && one.kind != ElementKind::Connector;
            let ends = drawing.all().filter(|(_, one)| is_end(one)).map(|(id, _)| id);
            leads_to_something(&drawing, ends)?;
            let drawing = Some(drawing).filter(Drawing::acts);
            Body::Drawn(language, drawing.into_iter().collect())
        }
    })
}

/// Reads the body of a named transition. It is represented as a RETURN with the condition.
pub(super) fn condition_body(reading: &mut Reading<'_, '_>, node: Node<'_, '_>) -> Body {
    let language = language(node).map_or(Language::St, |(language, _)| language);
    match condition_in(reading, node) {
        Ok(condition) => {
            let kind = Kind::Return(condition);
            Body::Code(language, vec![Statement { line: reading.text.line(node), kind }])
        }
        Err(fault) => {
            if matches!(fault.code, Code::Connection | Code::Xml) {
                reading.refuse(fault.clone());
            }
            Body::Unread(language, fault)
        }
    }
}

/// Reads the condition whose body is in an element.
fn condition_in(reading: &mut Reading<'_, '_>, node: Node<'_, '_>) -> Result<Expr, Fault> {
    let Some((language, inner)) = language(node) else {
        return Err(reading.text.fault(node, "the condition is empty"));
    };
    single(reading.text, node)?;
    let (written, line) = reading.text.content(inner);
    match language {
        Language::St => {
            let first = parse::expression(&written, line);
            first.or_else(|fault| {
                // Beremiz writes the text after the transition's name: `:= condition;`.
                let behind_name = format!("_ {written}\n;");
                let read = parse::statements(&written, line);
                let read = read.or_else(|_| parse::statements(&behind_name, line));
                match &read.map_err(|_| fault.clone())?[..] {
                    [Statement { kind: Kind::Assign(_, value), .. }] => Ok(value.clone()),
                    _ => Err(fault),
                }
            })
        }
        Language::Il => parse::instruction_list_value(&written, line),
        _ => of_body(reading, inner),
    }
}

struct Elements<'a, 'i> {
    nodes: BTreeMap<&'a str, Node<'a, 'i>>,
}

/// The kind of element searched for when connections are followed backwards.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sought {
    /// The steps before a transition.
    Steps,
    /// The transitions before a step.
    Transitions,
}

fn called(node: Node<'_, '_>) -> String {
    let name = node.attribute("name").map(|name| format!(" {name}")).unwrap_or_default();
    format!(
        "{}{name} with localId {}",
        node.tag_name().name(),
        node.attribute("localId").unwrap_or("?")
    )
}

/// Reads a chart.
fn chart(reading: &mut Reading<'_, '_>, body: Node<'_, '_>) -> Result<Chart, Fault> {
    // A transition without a following step is accepted here; tools draw it while a chart is being edited.
    let mut chart = draft(reading, body, &mut Vec::new())?.finish()?;
    chart.span = Some((body.range().start, body.range().end));
    Ok(chart)
}

/// Reads a chart or the chart of a macro step; `within` holds the names of the macro steps around it.
fn draft(
    reading: &mut Reading<'_, '_>,
    body: Node<'_, '_>,
    within: &mut Vec<String>,
) -> Result<Draft, Fault> {
    let text = reading.text;
    let mut drawing = Elements { nodes: BTreeMap::new() };
    for node in elements(body) {
        let name = node.tag_name().name();
        if matches!(name, "comment" | "vendorElement" | "addData" | "documentation") {
            continue;
        }
        let id = node
            .attribute("localId")
            .ok_or_else(|| text.fault(node, format!("an element {name} has no localId")))?;
        if drawing.nodes.insert(id, node).is_some() {
            return Err(text.fault(node, format!("two elements have the localId {id}")));
        }
        checked(text, node)?;
    }
    nothing_is_left_out(text, body)?;
    let mut draft = Draft::new(text.line(body));
    let in_order = from_the_left(elements(body).collect());
    let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
    let mut entered: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for &node in &in_order {
        match node.tag_name().name() {
            "macroStep" if is_expanded(node) => {
                let one = macro_step(reading, node, draft.steps.len(), within)?;
                draft.macros.push(one);
            }
            "step" | "macroStep" => draft.steps.push(step(reading, node)?),
            "transition" => {
                let id = node.attribute("localId").unwrap_or_default();
                numbers.insert(id, draft.transitions.len());
                let from = steps_before(reading, &drawing, node)?;
                let condition = condition(reading, body, node)?;
                draft.transitions.push(DraftTransition {
                    name: None,
                    from,
                    to: Vec::new(),
                    condition,
                    priority: priority(text, node)?,
                    line: text.line(node),
                    id: Some(id.to_owned()),
                });
            }
            _ => {}
        }
    }
    for &node in &in_order {
        let target = match node.tag_name().name() {
            "step" | "macroStep" => node.attribute("name"),
            "jumpStep" => node.attribute("targetName"),
            "actionBlock" => {
                action_block(reading, &drawing, node, &mut draft)?;
                continue;
            }
            _ => continue,
        };
        let target = target.unwrap_or_default();
        let mut before_it = Vec::new();
        for id in before(reading, &drawing, node, &inputs(node), Sought::Transitions)? {
            if let Some(&number) = numbers.get(id) {
                draft.transitions[number].to.push(target.to_owned());
                before_it.push(number);
            }
        }
        entered.insert(node.attribute("localId").unwrap_or_default(), before_it);
    }
    if draft.macros.is_empty() {
        draft.generated = steps_as_generated(body, &draft, &numbers, &entered);
    }
    Ok(draft)
}

/// The steps in the order in which generators write them. `numbers`: the transitions, by `localId`. `entered`: the
/// transitions before each step and jump.
fn steps_as_generated(
    body: Node<'_, '_>,
    draft: &Draft,
    numbers: &BTreeMap<&str, usize>,
    entered: &BTreeMap<&str, Vec<usize>>,
) -> Vec<usize> {
    let steps = draft.steps.iter().enumerate();
    let steps: BTreeMap<&str, usize> = steps.map(|(at, step)| (step.name.as_str(), at)).collect();
    let named = |name: Option<&str>| name.and_then(|name| steps.get(name)).copied();
    let ids: BTreeMap<&str, usize> = elements(body)
        .filter_map(|node| Some((node.attribute("localId")?, named(node.attribute("name"))?)))
        .collect();
    let before = |id: &str| entered.get(id).cloned().unwrap_or_default();
    let mut drawn = Vec::new();
    for node in elements(body) {
        let id = node.attribute("localId").unwrap_or_default();
        match node.tag_name().name() {
            "step" | "macroStep" => drawn.extend(named(node.attribute("name")).map(Drawn::Step)),
            "transition" => drawn.extend(numbers.get(id).copied().map(Drawn::Transition)),
            "actionBlock" => {
                let owners = inputs(node).into_iter().filter_map(|(owner, _)| ids.get(owner));
                drawn.extend(owners.copied().map(Drawn::Step));
            }
            "jumpStep" => {
                let target = named(node.attribute("targetName"));
                drawn.extend(target.map(|target| Drawn::Jump(target, before(id))));
            }
            _ => {}
        }
    }
    let ids = draft.steps.iter().map(|step| step.id.as_deref().unwrap_or_default());
    let from = draft.transitions.iter().map(|one| &one.from);
    let connections = Connections {
        is_initial: draft.steps.iter().map(|step| step.initial).collect(),
        before_step: ids.map(before).collect(),
        before_transition: from
            .map(|from| from.iter().filter_map(|name| named(Some(name))).collect())
            .collect(),
    };
    of_steps(&drawn, &connections)
}

/// Rejects elements beside a chart that would have an effect of their own: only conditions are drawn there.
fn nothing_is_left_out(text: &Text, body: Node<'_, '_>) -> Result<(), Fault> {
    let of = |names: &[&str]| elements(body).find(|one| !names.contains(&one.tag_name().name()));
    if let Some(node) = of(&[ELEMENTS, BESIDE, LOOKED_AT].concat()) {
        let message = format!("{}: no step of the chart executes it", called(node));
        let help = "move it into an action of a step";
        return Err(text.fault(node, message).help(help));
    }
    if of(&[ELEMENTS, BESIDE].concat()).is_none() {
        return Ok(());
    }
    let conditions = elements(body).filter_map(|node| child(node, "condition"));
    let points = conditions.map(|own| child(own, "connectionPointIn").unwrap_or(own));
    let ends: BTreeSet<&str> = points.flat_map(sources).map(|(id, _)| id).collect();
    let drawing = drawing(text, body)?;
    let is_end = |one: &(ElementId, &Element)| ends.contains(&*one.1.local_id);
    leads_to_something(&drawing, drawing.all().filter(is_end).map(|(id, _)| id))
}

/// Elements that conditions consist of and that have no effect of their own.
const LOOKED_AT: &[&str] = &[
    "leftPowerRail",
    "rightPowerRail",
    "contact",
    "inVariable",
    "connector",
    "continuation",
    "block",
];

/// The priority of a transition, if it has one.
fn priority(text: &Text, node: Node<'_, '_>) -> Result<Option<u32>, Fault> {
    let written = node.attribute("priority").map(str::trim).filter(|text| !text.is_empty());
    let number = written.map(str::parse).transpose();
    number.map_err(|_| text.fault(node, format!("{}: its priority is not a number", called(node))))
}

/// The elements in the order of the file, except that transitions after the same element are ordered from left to
/// right.
fn from_the_left<'a, 'i>(mut nodes: Vec<Node<'a, 'i>>) -> Vec<Node<'a, 'i>> {
    let mut rivals: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (at, node) in nodes.iter().enumerate().filter(|(_, node)| is_transition(**node)) {
        if let Some((id, _)) = inputs(*node).first() {
            rivals.entry(id).or_default().push(at);
        }
    }
    for places in rivals.into_values().filter(|places| places.len() > 1) {
        let mut own: Vec<Node<'_, '_>> = places.iter().map(|&at| nodes[at]).collect();
        own.sort_by_key(|&node| position(node).1);
        for (at, node) in places.into_iter().zip(own) {
            nodes[at] = node;
        }
    }
    nodes
}

fn is_transition(node: Node<'_, '_>) -> bool {
    node.tag_name().name() == "transition"
}

/// Whether a macro step contains a chart.
fn is_expanded(node: Node<'_, '_>) -> bool {
    child(node, "body").is_some_and(|body| elements(body).next().is_some())
}

fn macro_step(
    reading: &mut Reading<'_, '_>,
    node: Node<'_, '_>,
    at: usize,
    within: &mut Vec<String>,
) -> Result<DraftMacro, Fault> {
    let text = reading.text;
    let wrong = |message: String| text.fault(node, message).code(Code::Chart);
    let name = node
        .attribute("name")
        .ok_or_else(|| text.fault(node, format!("{}: it has no name", called(node))))?;
    if within.iter().any(|outer| same(outer, name)) {
        return Err(wrong(format!("{}: it stands in a macro step of its own name", called(node)))
            .help("give one of them another name; a macro step cannot hold itself"));
    }
    if within.len() == DEEPEST {
        let message = format!("{}: it stands in {DEEPEST} macro steps", called(node));
        return Err(wrong(message).help("draw the chart with fewer of them in each other"));
    }
    let inner = child(node, "body").and_then(language);
    let Some((Language::Sfc, inner)) = inner else {
        let message = format!("{}: its body is not a chart", called(node));
        return Err(wrong(message).help("draw what it does as SFC"));
    };
    within.push(name.to_owned());
    // The elements in a macro step's chart have their own numbering.
    let outer = std::mem::replace(&mut reading.computes, false);
    let inside = reading.apart(&format!("{name}."), |reading| draft(reading, inner, within));
    reading.computes = outer;
    let inside = inside?;
    within.pop();
    Ok(DraftMacro {
        name: name.to_owned(),
        initial: is(node, "initialStep"),
        blocks: Vec::new(),
        inside,
        at,
        line: text.line(node),
    })
}

fn step(reading: &Reading<'_, '_>, node: Node<'_, '_>) -> Result<Step, Fault> {
    let name = node
        .attribute("name")
        .ok_or_else(|| reading.text.fault(node, format!("{}: it has no name", called(node))))?;
    let mut step = Step::new(name, is(node, "initialStep"), reading.text.line(node));
    step.id = node.attribute("localId").map(str::to_owned);
    step.is_macro = node.tag_name().name() == "macroStep";
    let attributes = node.descendants().filter(|one| one.tag_name().name() == "attribute");
    for one in attributes {
        let (written, line) = reading.text.content(one);
        let (written, guid) = (written.trim(), one.attribute("guid").unwrap_or_default());
        let refused = |what: &str| {
            let message = format!("{}: {what} ({written}), which is not followed", called(node));
            Err(reading.text.fault(node, message).code(Code::NotModelled))
        };
        let slot = match guid {
            ACTIVE => &mut step.active,
            ENTRY => &mut step.entry,
            EXIT => &mut step.exit,
            EXCLUDED if same(written, "TRUE") => return refused("it is excluded"),
            LEAST if !is_no_time(written) => return refused("it has a minimum time"),
            EXCLUDED | LEAST | MOST => continue,
            // The effect of an unknown attribute that names an action is not known.
            _ if reading.has_action(written) && written != name => {
                return refused("an attribute names an action");
            }
            _ => continue,
        };
        if written.is_empty() {
            continue;
        }
        match parse::expression(written, line) {
            Ok(Expr::Variable(path)) => *slot = Some(path),
            _ => return refused("its action is not a name"),
        }
    }
    Ok(step)
}

/// Whether a time is missing or zero.
fn is_no_time(written: &str) -> bool {
    written.is_empty() || parse::duration(written) == Some(0) || written == "0"
}

/// Follows connections backwards to steps or transitions; returns their `localId`s.
fn before<'a>(
    reading: &Reading<'_, '_>,
    drawing: &Elements<'a, '_>,
    node: Node<'_, '_>,
    from: &[(&str, Option<&str>)],
    sought: Sought,
) -> Result<Vec<&'a str>, Fault> {
    let text = reading.text;
    let wrong = |node, message: String| text.fault(node, message).code(Code::Connection);
    let mut found = Vec::new();
    let mut seen = BTreeSet::new();
    one_way(text, node, sought)?;
    let mut open: Vec<(String, Node<'_, '_>)> =
        from.iter().rev().map(|(id, _)| ((*id).to_owned(), node)).collect();
    while let Some((id, behind)) = open.pop() {
        let Some((&id, &one)) = drawing.nodes.get_key_value(id.as_str()) else {
            let message = format!(
                "{}: a connection refers to localId {id}, which does not exist",
                called(behind)
            );
            return Err(wrong(behind, message));
        };
        if !seen.insert(id) {
            if matches!(one.tag_name().name(), "step" | "macroStep" | "transition") {
                continue;
            }
            let message = format!("{}: the connections through it form a loop", called(one));
            return Err(wrong(one, message));
        }
        match (one.tag_name().name(), sought) {
            ("step" | "macroStep", Sought::Steps) | ("transition", Sought::Transitions) => {
                found.push(id)
            }
            ("selectionDivergence" | "simultaneousConvergence", Sought::Steps)
            | ("selectionConvergence" | "simultaneousDivergence", Sought::Transitions) => {
                one_way(text, one, sought)?;
                open.extend(inputs(one).into_iter().rev().map(|(id, _)| (id.to_owned(), one)));
            }
            // A branch that ends in a jump does not take part in the convergence.
            ("jumpStep", _)
                if ["selectionConvergence", "simultaneousConvergence"]
                    .contains(&behind.tag_name().name()) => {}
            // A convergence of selections directly in front of the next selection.
            ("selectionConvergence", Sought::Steps) if is_of_steps(drawing, one) => {
                open.extend(inputs(one).into_iter().rev().map(|(id, _)| (id.to_owned(), one)));
            }
            (other, _) => {
                let what = if sought == Sought::Steps { "a transition" } else { "a step" };
                let message =
                    format!("{}: {what} cannot follow {} ({other})", called(behind), called(one));
                return Err(wrong(behind, message).code(Code::Chart));
            }
        }
    }
    Ok(found)
}

/// Rejects several steps connected directly to one point: it is unclear whether all or one of them must be active.
fn one_way(text: &Text, node: Node<'_, '_>, sought: Sought) -> Result<(), Fault> {
    let are_several = |point: Node<'_, '_>| children(point, "connection").nth(1).is_some();
    let waits_for_all = node.tag_name().name() == "simultaneousConvergence";
    if sought == Sought::Transitions
        || waits_for_all
        || !children(node, "connectionPointIn").any(are_several)
    {
        return Ok(());
    }
    let message = format!("{}: several steps are connected directly to it", called(node));
    let help =
        "draw a simultaneous convergence, if it waits for all of them, or a transition for each";
    Err(text.fault(node, message).code(Code::Chart).help(help))
}

/// Whether a single step leads to a convergence, beside branches that end in jumps, so that it joins nothing.
fn is_of_steps(drawing: &Elements<'_, '_>, node: Node<'_, '_>) -> bool {
    let kind = |(id, _): &(&str, Option<&str>)| {
        drawing.nodes.get(id).map_or("", |one| one.tag_name().name())
    };
    let all: Vec<&str> = inputs(node).iter().map(kind).filter(|kind| *kind != "jumpStep").collect();
    matches!(all[..], ["step" | "macroStep"])
}

fn steps_before(
    reading: &Reading<'_, '_>,
    drawing: &Elements<'_, '_>,
    node: Node<'_, '_>,
) -> Result<Vec<String>, Fault> {
    let from = inputs(node);
    let found = before(reading, drawing, node, &from, Sought::Steps)?;
    if found.is_empty() && !from.is_empty() {
        let message = format!("{}: only branches that end in jumps lead to it", called(node));
        return Err(reading.text.fault(node, message).code(Code::Chart));
    }
    let name = |id: &&str| drawing.nodes[*id].attribute("name").unwrap_or_default().to_owned();
    Ok(found.iter().map(name).collect())
}

fn condition<'a, 'i>(
    reading: &mut Reading<'_, '_>,
    body: Node<'a, 'i>,
    node: Node<'a, 'i>,
) -> Result<Expr, Fault> {
    let text = reading.text;
    let Some(own) = child(node, "condition") else {
        return Err(text.fault(node, format!("{}: it has no condition", called(node))));
    };
    let ways = ["inline", "reference", "connectionPointIn"].into_iter();
    if ways.filter(|name| child(own, name).is_some()).count() > 1 {
        let message = format!("{}: it has two conditions", called(node));
        return Err(text.fault(node, message).code(Code::Chart).help("leave one of them"));
    }
    let value = if let Some(inline) = child(own, "inline") {
        single(text, inline)?;
        let own = format!("t{}", node.attribute("localId").unwrap_or_default());
        match reading.apart(&own, |reading| condition_in(reading, inline)) {
            Ok(value) => value,
            Err(fault) if fault.code == Code::Syntax => any(&fault),
            Err(fault) => return Err(fault),
        }
    } else if let Some(reference) = child(own, "reference") {
        named(reading, reference.attribute("name").unwrap_or_default(), text.line(node))?
    } else {
        let point = child(own, "connectionPointIn").unwrap_or(own);
        let from = sources(point);
        if from.is_empty() {
            return Err(text.fault(node, format!("{}: its condition is empty", called(node))));
        }
        drawn(reading, body, node, &from)?
    };
    match own.attribute("negated") {
        None | Some("false" | "0") => Ok(value),
        Some("true" | "1") if text.is_codesys => Ok(value.not()),
        Some(_) => {
            let message =
                format!("{}: generators ignore the negation of its condition", called(node));
            let help = "negate in the condition itself";
            Err(text.fault(node, message).code(Code::NotModelled).help(help))
        }
    }
}

/// Reads a condition that is drawn beside the chart.
fn drawn<'a, 'i>(
    reading: &mut Reading<'_, '_>,
    body: Node<'a, 'i>,
    node: Node<'a, 'i>,
    from: &[(&str, Option<&str>)],
) -> Result<Expr, Fault> {
    // Elements of the chart itself have no value, but they share its numbering.
    match of_transition(reading, body, node, &called(node), from) {
        Ok(value) => Ok(value),
        Err(fault) if fault.code == Code::Syntax => Ok(any(&fault)),
        Err(fault) => Err(fault),
    }
}

/// A condition that is not understood, which may be true or false.
fn any(fault: &Fault) -> Expr {
    Expr::Unread(fault.message.clone())
}

/// The condition of a named transition, or a Boolean variable of that name.
fn named(reading: &Reading<'_, '_>, name: &str, line: u32) -> Result<Expr, Fault> {
    let own = reading.pou.transitions.iter().find(|one| same(&one.name, name));
    match own.map(|one| &one.body) {
        Some(Body::Code(_, statements)) => match &statements[..] {
            [Statement { kind: Kind::Return(value), .. }] => Ok(value.clone()),
            _ => Ok(any(&Fault::new(line, format!("the transition {name} is empty")))),
        },
        Some(Body::Unread(_, fault)) => Ok(any(fault)),
        _ => parse::expression(name, line),
    }
}

fn action_block(
    reading: &mut Reading<'_, '_>,
    drawing: &Elements<'_, '_>,
    node: Node<'_, '_>,
    draft: &mut Draft,
) -> Result<(), Fault> {
    // An action block without a connection has no effect.
    for (id, _) in inputs(node) {
        let Some(owner) = drawing.nodes.get(id) else {
            let message = format!(
                "{}: a connection refers to localId {id}, which does not exist",
                called(node)
            );
            return Err(reading.text.fault(node, message).code(Code::Connection));
        };
        let name = owner.attribute("name").unwrap_or_default();
        let steps = draft.steps.iter_mut().map(|step| (&step.name, &mut step.blocks));
        let macros = draft.macros.iter_mut().map(|one| (&one.name, &mut one.blocks));
        let is_step = matches!(owner.tag_name().name(), "step" | "macroStep");
        let own = steps.chain(macros).find(|(own, _)| *own == name).filter(|_| is_step);
        let Some((_, blocks)) = own else {
            let message = format!("{}: it belongs to no step", called(node));
            return Err(reading.text.fault(node, message).code(Code::Chart));
        };
        for action in children(node, "action") {
            let block = block(reading, action, name, blocks.len())?;
            blocks.extend(block);
        }
    }
    Ok(())
}

fn block(
    reading: &mut Reading<'_, '_>,
    node: Node<'_, '_>,
    step: &str,
    number: usize,
) -> Result<Option<Block>, Fault> {
    let text = reading.text;
    let line = text.line(node);
    let word = node.attribute("qualifier").filter(|word| !word.is_empty()).unwrap_or("N");
    let qualifier = Qualifier::named(word).ok_or_else(|| {
        let message = format!("step {step}: '{word}' is not an action qualifier");
        let help = "the qualifiers are N, R, S, L, D, P, P0, P1, SD, DS and SL";
        text.fault(node, message).code(Code::Chart).help(help)
    })?;
    let duration = node.attribute("duration").map(str::trim).filter(|text| !text.is_empty());
    let time = match duration.filter(|_| qualifier.is_timed()) {
        None => None,
        Some(written) => {
            let parsed = parse::duration(written).map(|time| Expr::Literal(Literal::Time(time)));
            match parsed {
                Some(time) => Some(time),
                None => Some(parse::expression(written, line)?),
            }
        }
    };
    if time.is_none() && qualifier.is_timed() {
        let message = format!("step {step}: the qualifier {word} has no time");
        let help = "say how long: duration=\"T#2s\"";
        return Err(text.fault(node, message).code(Code::Chart).help(help));
    }
    if elements(node).filter(|one| ["reference", "inline"].contains(&one.tag_name().name())).count()
        > 1
    {
        let message = format!("step {step}: one block names several actions");
        return Err(text
            .fault(node, message)
            .code(Code::Chart)
            .help("give each a block of its own"));
    }
    let target = if let Some(reference) = child(node, "reference") {
        let name = reference.attribute("name").unwrap_or_default();
        match parse::expression(name, line)? {
            Expr::Variable(path) => Target::Path(path),
            _ => return Err(text.fault(node, format!("step {step}: '{name}' is not an action"))),
        }
    } else if let Some(inline) = child(node, "inline") {
        single(text, inline)?;
        if language(inline).is_none() {
            if elements(inline).next().is_some() {
                let message = format!("step {step}: an action is in a language that is not read");
                return Err(text.fault(inline, message).code(Code::Chart));
            }
            return Ok(None);
        }
        let mut name = format!("{step}_{}", number + 1);
        // The name must differ from those of declared actions and variables.
        let is_taken = |name: &str| reading.declares(name);
        while is_taken(&name) {
            name.push('_');
        }
        let outer = std::mem::replace(&mut reading.computes, false);
        let body = reading.apart(&name, |reading| body(reading, inline));
        reading.computes = outer;
        Target::Inline(name, Box::new(body))
    } else {
        return Ok(None);
    };
    Ok(Some(Block { qualifier, is_qualified: true, time, target, line }))
}

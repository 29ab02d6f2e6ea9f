//! Reads ladder and function block diagrams.

use super::checked::checked;
use super::execute::code;
use super::generated::is_written_as_shown;
use super::node::{Text, child, children, elements, is, name_of, order, pins, position};
use crate::ast::{Expr, Path};
use crate::drawing::{
    Block, Connection, Drawing, Edge, Element, ElementId, ElementKind, Given, InputPin, OutputPin,
};
use crate::fault::Fault;
use crate::parse;
use roxmltree::Node;
use scanbound_base::code::Code;
use std::collections::BTreeMap;

/// Elements that are not executed.
const BESIDE: &[&str] = &["comment", "vendorElement", "addData", "documentation", "position"];

/// Functions that some tools draw with a symbol, and their names.
const OPERATORS: &[(&str, &str)] = &[
    ("+", "ADD"),
    ("-", "SUB"),
    ("*", "MUL"),
    ("/", "DIV"),
    ("&", "AND"),
    (">=1", "OR"),
    ("=2k+1", "XOR"),
    (">", "GT"),
    (">=", "GE"),
    ("=", "EQ"),
    ("<=", "LE"),
    ("<", "LT"),
    ("<>", "NE"),
    (":=", "MOVE"),
];

/// The state while a drawing is read.
struct Reader<'a, 'i> {
    text: &'a Text,
    nodes: Vec<Node<'a, 'i>>,
    ids: BTreeMap<&'a str, ElementId>,
}

/// The name of an element for messages.
fn called(node: Node<'_, '_>) -> String {
    format!("{} with localId {}", node.tag_name().name(), node.attribute("localId").unwrap_or("?"))
}

/// Reads the drawing in a body.
pub(super) fn drawing(text: &Text, body: Node<'_, '_>) -> Result<Drawing, Fault> {
    let mut reader = Reader { text, nodes: Vec::new(), ids: BTreeMap::new() };
    for node in elements(body).filter(|node| !BESIDE.contains(&node.tag_name().name())) {
        let missing = || {
            let what = format!("an element {} has no localId", node.tag_name().name());
            text.fault(node, what)
        };
        let id = node.attribute("localId").ok_or_else(missing)?;
        if reader.ids.insert(id, ElementId(reader.nodes.len())).is_some() {
            return Err(text.fault(node, format!("two elements have the localId {id}")));
        }
        checked(text, node)?;
        reader.nodes.push(node);
    }
    let mut found = Vec::new();
    for &node in &reader.nodes {
        found.push(reader.element(node)?);
    }
    let connections = body.descendants().filter(|one| one.tag_name().name() == "connection");
    for from in connections.filter_map(|one| reader.ids.get(one.attribute("refLocalId")?)) {
        found[from.0].uses += 1;
    }
    for at in 0..found.len() {
        if let ElementKind::Continuation(from) = found[at].kind {
            found[from.0].uses += 1;
        }
    }
    let drawing = Drawing { elements: found, is_executed_as_drawn: text.is_codesys, goal: None };
    for one in drawing.elements.iter().filter(|one| one.acts() && one.block().is_none()) {
        one.operand_is_there()?;
    }
    leads_on(&drawing)?;
    if !drawing.is_executed_as_drawn {
        is_written_as_shown(&drawing)?;
    }
    Ok(drawing)
}

impl<'a, 'i> Reader<'a, 'i> {
    fn wrong(&self, node: Node<'_, '_>, what: &str) -> Fault {
        self.text.fault(node, format!("{}: {what}", called(node))).code(Code::Connection)
    }

    fn element(&self, node: Node<'a, 'i>) -> Result<Element, Fault> {
        let kind = self.kind(node)?;
        let operand = match kind {
            ElementKind::Contact | ElementKind::Coil => self.operand(node, "variable"),
            _ => self.operand(node, "expression"),
        };
        let inputs = self.connections(node, node)?;
        let (negated, negated_in, negated_out) =
            (is(node, "negated"), is(node, "negatedIn"), is(node, "negatedOut"));
        Ok(Element {
            local_id: node.attribute("localId").unwrap_or_default().to_owned(),
            negated_in: negated || negated_in,
            negated_out: negated || negated_out,
            kind,
            operand,
            edge: edge(node),
            latch: match node.attribute("storage") {
                Some("set") => Some(true),
                Some("reset") => Some(false),
                _ => None,
            },
            inputs,
            uses: 0,
            order: order(node),
            position: position(node),
            line: self.text.line(node),
        })
    }

    fn kind(&self, node: Node<'a, 'i>) -> Result<ElementKind, Fault> {
        let label = || node.attribute("label").unwrap_or_default().to_owned();
        Ok(match node.tag_name().name() {
            "leftPowerRail" => ElementKind::LeftRail,
            "rightPowerRail" => ElementKind::RightRail,
            "contact" => ElementKind::Contact,
            "coil" => ElementKind::Coil,
            "inVariable" => ElementKind::In,
            "outVariable" => ElementKind::Out,
            "inOutVariable" => ElementKind::InOut,
            "connector" => {
                if self.named_like("connector", node).any(|other| other != node) {
                    return Err(self.wrong(node, "another connector has its name"));
                }
                ElementKind::Connector
            }
            "continuation" => {
                let from = self.named_like("connector", node).next();
                let from = from.and_then(|from| self.ids.get(from.attribute("localId")?));
                let missing = || self.wrong(node, "no connector has its name");
                ElementKind::Continuation(*from.ok_or_else(missing)?)
            }
            "block" => ElementKind::Block(Box::new(self.block(node)?)),
            "label" => ElementKind::Label(label()),
            "jump" => ElementKind::Jump(label()),
            "return" => ElementKind::Return,
            name => ElementKind::Other(name.to_owned()),
        })
    }

    /// The elements of type `kind` with the same name as `node`.
    fn named_like(
        &self,
        kind: &'static str,
        node: Node<'a, 'i>,
    ) -> impl Iterator<Item = Node<'a, 'i>> {
        let all = self.nodes.iter().copied().filter(move |one| one.tag_name().name() == kind);
        all.filter(move |one| one.attribute("name") == node.attribute("name"))
    }

    /// All connections to the points in `at`, which is the element `of` or one of its pins.
    fn connections(&self, of: Node<'_, '_>, at: Node<'_, '_>) -> Result<Vec<Connection>, Fault> {
        let points = children(at, "connectionPointIn");
        let connections = points.flat_map(|point| children(point, "connection"));
        let found = connections.filter_map(|one| Some((one.attribute("refLocalId")?, one)));
        let found = found.map(|(id, one)| {
            let missing = || {
                self.wrong(
                    of,
                    &format!("a connection refers to localId {id}, which does not exist"),
                )
            };
            let from = *self.ids.get(id).ok_or_else(missing)?;
            let output = one.attribute("formalParameter").unwrap_or_default().to_owned();
            Ok(Connection { from, output })
        });
        found.collect()
    }

    fn operand(&self, node: Node<'_, '_>, name: &'static str) -> Result<Expr, Fault> {
        let written = child(node, name);
        if written.is_some_and(|written| written.children().any(|part| !part.is_text())) {
            let what = format!(
                "there is a comment or an element within its {name}: generators read only the text before it"
            );
            return Err(self.wrong(node, &what).code(Code::Xml));
        }
        match written
            .map(|written| self.text.content(written))
            .filter(|(text, _)| !text.trim().is_empty())
        {
            Some((text, line)) => parse::expression(&text, line),
            None => Err(self.text.fault(node, format!("{}: it names no variable", called(node)))),
        }
    }

    fn block(&self, node: Node<'a, 'i>) -> Result<Block, Fault> {
        let mut inputs = Vec::new();
        for list in ["inputVariables", "inOutVariables"] {
            for pin in pins(node, list) {
                let mut points = children(pin, "connectionPointIn");
                let given = match points.find_map(|point| self.text.written(point)) {
                    Some((text, line)) => Given::Written(parse::expression(&text, line)),
                    None => match self.connections(node, pin)? {
                        from if from.is_empty() => Given::Nothing,
                        from => Given::Wired(from),
                    },
                };
                let is_in_out = list == "inOutVariables";
                // The generator of Beremiz and OpenPLC passes nothing here. Their own files have it among the inputs.
                if is_in_out && !self.text.is_codesys && !matches!(given, Given::Nothing) {
                    let name = name_of(pin);
                    let what = format!(
                        "Beremiz and OpenPLC leave out what <inOutVariables> passes to '{name}': move it to <inputVariables>"
                    );
                    return Err(self.wrong(node, &what));
                }
                inputs.push(InputPin {
                    name: name_of(pin).to_owned(),
                    is_in_out,
                    given,
                    negated: is(pin, "negated"),
                    edge: edge(pin),
                });
            }
        }
        let outputs = pins(node, "outputVariables").map(|pin| {
            let mut points = children(pin, "connectionPointOut");
            let written = points.find_map(|point| self.text.written(point));
            let written = written.map(|(text, line)| (self.written_to(node, &text, line), line));
            OutputPin { name: name_of(pin).to_owned(), negated: is(pin, "negated"), written }
        });
        let line = self.text.line(node);
        let instance = node.attribute("instanceName").filter(|name| !name.is_empty());
        let of = node.attribute("typeName").unwrap_or_default();
        let function = OPERATORS.iter().find(|(sign, _)| *sign == of).map_or(of, |(_, name)| name);
        let is_word = function.chars().all(|c| c.is_alphanumeric() || c == '_');
        Ok(Block {
            of: of.to_owned(),
            function: match is_word && !function.is_empty() {
                true => Ok(Path::name(function)),
                false => named(function, line),
            },
            instance: instance.map(|name| named(name, line)),
            inputs,
            outputs: outputs.collect(),
            code: code(self.text, node),
        })
    }

    fn written_to(&self, node: Node<'_, '_>, text: &str, line: u32) -> Result<Path, Fault> {
        match parse::expression(text, line)? {
            Expr::Variable(target) => Ok(target),
            _ => {
                let what = format!("'{}' is written to, but is not a variable", text.trim());
                Err(self.text.fault(node, format!("{}: {what}", called(node))))
            }
        }
    }
}

/// Rejects contacts, blocks and expressions from which no connection leads to one of `ends`: it is unknown whether a
/// controller evaluates them. Expressions are accepted in generated code, which omits them.
pub(super) fn leads_to_something(
    drawing: &Drawing,
    ends: impl IntoIterator<Item = ElementId>,
) -> Result<(), Fault> {
    let taken = drawing.reaching(ends);
    let is_looked_at = |one: &Element| match one.kind {
        ElementKind::Contact | ElementKind::Block(_) => true,
        ElementKind::In | ElementKind::InOut => {
            drawing.is_executed_as_drawn && !matches!(one.operand, Ok(Expr::Literal(_)))
        }
        _ => false,
    };
    match drawing.all().find(|(id, one)| is_looked_at(one) && !taken.contains(id)) {
        None => Ok(()),
        Some((_, one)) => {
            one.operand_is_there()?;
            let what = "it is connected to nothing that is executed: whether a controller evaluates it is not known";
            let help = "connect it to a coil, an output or a block, or take it out of the drawing";
            Err(one.fault(what).code(Code::NotModelled).help(help))
        }
    }
}

/// Rejects loops that pass through no block.
fn leads_on(drawing: &Drawing) -> Result<(), Fault> {
    let passes = |id: &ElementId| {
        let leaves = |kind: &ElementKind| {
            matches!(kind, ElementKind::Block(_) | ElementKind::InOut | ElementKind::Other(_))
        };
        !leaves(&drawing.element(*id).kind)
    };
    let before = |id: ElementId| drawing.element(id).leading().filter(passes).collect::<Vec<_>>();
    let mut seen = vec![false; drawing.elements.len()];
    let mut is_open = vec![false; drawing.elements.len()];
    let acts =
        |(_, one): &(ElementId, &Element)| one.acts() && !matches!(one.kind, ElementKind::Other(_));
    for (start, _) in drawing.all().filter(acts) {
        let mut open = vec![(start, before(start))];
        while let Some((id, ways)) = open.last_mut() {
            let id = *id;
            let Some(next) = ways.pop() else {
                is_open[id.0] = false;
                open.pop();
                continue;
            };
            if is_open[next.0] {
                let what = "the connections through it form a loop";
                return Err(drawing.element(next).fault(what).code(Code::Connection));
            }
            if std::mem::replace(&mut seen[next.0], true) {
                continue;
            }
            drawing.element(next).operand_is_there()?;
            is_open[next.0] = true;
            open.push((next, before(next)));
        }
    }
    Ok(())
}

fn named(name: &str, line: u32) -> Result<Path, Fault> {
    match parse::expression(name, line)? {
        Expr::Variable(path) => Ok(path),
        _ => Err(Fault::new(line, format!("'{name}' is not a name"))),
    }
}

fn edge(node: Node<'_, '_>) -> Option<Edge> {
    match node.attribute("edge") {
        Some("rising") => Some(Edge::Rising),
        Some("falling") => Some(Edge::Falling),
        _ => None,
    }
}

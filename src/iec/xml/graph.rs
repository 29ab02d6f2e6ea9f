//! Ladder and function block diagrams: graphs of contacts, coils and blocks, as statements.
//!
//! What an element puts out is an expression of what leads to it: parallel ways are joined by OR. Where a way forks, its value
//! is kept in a variable, so that nothing is written twice, however often ways fork and join.

use super::node::{Text, child, children, elements, inputs, is, sources};
use super::order::{order, rank};
use super::reading::Reading;
use crate::base::code::Code;
use crate::iec::ast::{Argument, Expr, Kind, Path, Statement};
use crate::iec::fault::Fault;
use crate::iec::parse;
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// How deep ways may be followed.
const DEPTH: usize = 150;

/// A graph, and what of it has been carried out.
pub(super) struct Graph<'a, 'i> {
    text: &'a Text,
    nodes: BTreeMap<&'a str, Node<'a, 'i>>,
    /// How often each output leads somewhere.
    forks: BTreeMap<&'a str, usize>,
    kept: BTreeMap<(&'a str, String), Expr>,
    open: BTreeSet<&'a str>,
    done: BTreeSet<&'a str>,
    statements: Vec<Statement>,
    /// The number of execution of the element that is carried out, if it has one.
    acting: Option<u64>,
}

fn wrong(text: &Text, node: Node<'_, '_>, message: String) -> Fault {
    text.fault(node, message).code(Code::Connection)
}

/// An element and its number, for messages.
fn called(node: Node<'_, '_>) -> String {
    format!("{} with localId {}", node.tag_name().name(), node.attribute("localId").unwrap_or("?"))
}

impl<'a, 'i> Graph<'a, 'i> {
    pub(super) fn new(text: &'a Text, body: Node<'a, 'i>) -> Result<Graph<'a, 'i>, Fault> {
        let mut nodes = BTreeMap::new();
        for node in elements(body) {
            let name = node.tag_name().name();
            if matches!(
                name,
                "comment" | "vendorElement" | "addData" | "documentation" | "position"
            ) {
                continue;
            }
            let id = node
                .attribute("localId")
                .ok_or_else(|| text.fault(node, format!("an element {name} has no localId")))?;
            if nodes.insert(id, node).is_some() {
                return Err(text.fault(node, format!("two elements have the localId {id}")));
            }
        }
        let mut forks = BTreeMap::new();
        for connection in body.descendants().filter(|one| one.tag_name().name() == "connection") {
            if let Some(id) = connection.attribute("refLocalId") {
                *forks.entry(id).or_insert(0) += 1;
            }
        }
        Ok(Graph {
            text,
            nodes,
            forks,
            kept: BTreeMap::new(),
            open: BTreeSet::new(),
            done: BTreeSet::new(),
            statements: Vec::new(),
            acting: None,
        })
    }

    /// All that the graph does, in order.
    pub(super) fn statements(
        &mut self,
        reading: &mut Reading<'_, '_>,
    ) -> Result<Vec<Statement>, Fault> {
        let mut acting: Vec<(_, &'a str)> =
            self.nodes.iter().enumerate().map(|(at, (&id, &node))| (rank(node, at), id)).collect();
        acting.sort();
        for (_, id) in acting {
            self.acting = order(self.nodes[id]);
            self.act(reading, id)?;
        }
        Ok(std::mem::take(&mut self.statements))
    }

    /// The value of a condition that is drawn: what leads to its only coil, or to the right rail, or out of it.
    pub(super) fn result(
        &mut self,
        reading: &mut Reading<'_, '_>,
        body: Node<'a, 'i>,
    ) -> Result<Expr, Fault> {
        let ends = ["coil", "outVariable", "rightPowerRail"];
        let end = ends.iter().find_map(|kind| {
            self.nodes.values().find(|node| node.tag_name().name() == *kind).copied()
        });
        let Some(end) = end else {
            return Err(self.text.fault(body, "nothing says what the condition is"));
        };
        let value = self.joined(reading, end, &inputs(end))?;
        match self.statements.first() {
            Some(_) => Err(Fault::new(
                self.text.line(body),
                "a condition with a block that remembers is not followed",
            )),
            None => Ok(value),
        }
    }

    /// The value that leads in through connections.
    pub(super) fn joined(
        &mut self,
        reading: &mut Reading<'_, '_>,
        node: Node<'_, '_>,
        from: &[(&str, Option<&str>)],
    ) -> Result<Expr, Fault> {
        let mut sum: Option<Expr> = None;
        for (id, output) in from {
            let Some((&id, _)) = self.nodes.get_key_value(*id) else {
                let message = format!(
                    "{}: a connection leads to localId {id}, which is not there",
                    called(node)
                );
                return Err(wrong(self.text, node, message));
            };
            let value = self.value(reading, id, output.unwrap_or_default())?;
            if value.is(true) {
                return Ok(value);
            }
            sum = Some(match sum {
                Some(sum) => sum.or(value),
                None => value,
            });
        }
        // What is not connected carries no power.
        Ok(sum.unwrap_or_else(|| Expr::bool(false)))
    }

    fn value(
        &mut self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        output: &str,
    ) -> Result<Expr, Fault> {
        let key = (id, output.to_owned());
        if let Some(kept) = self.kept.get(&key) {
            return Ok(kept.clone());
        }
        let node = self.nodes[id];
        if self.is_fed_back(id, node) {
            return Ok(self.block_output(reading, id, node, output));
        }
        if !self.open.insert(id) || self.open.len() > DEPTH {
            let message =
                format!("{}: the ways through it come back to where they began", called(node));
            return Err(wrong(self.text, node, message));
        }
        let found = self.put_out(reading, id, node, output);
        self.open.remove(id);
        let mut value = found?;
        let is_plain = matches!(value, Expr::Literal(_) | Expr::Variable(_));
        if !is_plain && self.forks.get(id).is_some_and(|&count| count > 1) {
            let name = reading.hidden(&format!("n{id}"), "", 0);
            let kept = Path::name(name);
            self.add(node, Kind::Assign(kept.clone(), value));
            value = Expr::Variable(kept);
        }
        // A variable may change before it is read again; what is kept does not.
        self.kept.insert(key, value.clone());
        Ok(value)
    }

    /// Whether an output is that of an instance that is not carried out before it is asked for: a way leads back to it, or its
    /// number of execution is a later one. It holds what the scan before left in it.
    fn is_fed_back(&self, id: &str, node: Node<'_, '_>) -> bool {
        let is_instance = node.tag_name().name() == "block"
            && node.attribute("instanceName").is_some_and(|name| !name.is_empty());
        let later = order(node).zip(self.acting).is_some_and(|(own, acting)| own > acting);
        is_instance && (self.open.contains(id) || (later && !self.done.contains(id)))
    }

    fn add(&mut self, node: Node<'_, '_>, kind: Kind) {
        self.statements.push(Statement { line: self.text.line(node), kind });
    }

    fn put_out(
        &mut self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'a, 'i>,
        output: &str,
    ) -> Result<Expr, Fault> {
        match node.tag_name().name() {
            "leftPowerRail" => Ok(Expr::bool(true)),
            "contact" => {
                let way = self.joined(reading, node, &inputs(node))?;
                let variable = self.operand(node, "variable")?;
                let mut value = variable;
                if let Some(edge) = node.attribute("edge").filter(|edge| *edge != "none") {
                    value = self.edge(reading, node, id, edge, value);
                }
                if is(node, "negated") {
                    value = value.not();
                }
                Ok(way.and(value))
            }
            "coil" | "rightPowerRail" => self.joined(reading, node, &inputs(node)),
            "inVariable" | "inOutVariable" => {
                let value = self.operand(node, "expression")?;
                let negated = is(node, "negated") || is(node, "negatedOut");
                Ok(if negated { value.not() } else { value })
            }
            "outVariable" => self.joined(reading, node, &inputs(node)),
            "continuation" => {
                let name = node.attribute("name");
                let from = self.nodes.values().find(|one| {
                    one.tag_name().name() == "connector" && one.attribute("name") == name
                });
                let Some(&from) = from else {
                    let message = format!("{}: no connector has its name", called(node));
                    return Err(wrong(self.text, node, message));
                };
                self.joined(reading, from, &inputs(from))
            }
            "connector" => self.joined(reading, node, &inputs(node)),
            "block" => {
                self.block(reading, id, node)?;
                Ok(self.block_output(reading, id, node, output))
            }
            name => Err(Fault::new(
                self.text.line(node),
                format!("{}: elements {name} are not followed", called(node)),
            )),
        }
    }

    fn operand(&self, node: Node<'_, '_>, name: &'static str) -> Result<Expr, Fault> {
        let Some(written) = child(node, name) else {
            return Err(self.text.fault(node, format!("{}: it names no variable", called(node))));
        };
        let (text, line) = self.text.content(written);
        if text.trim().is_empty() {
            return Err(self.text.fault(node, format!("{}: it names no variable", called(node))));
        }
        parse::expression(&text, line)
    }

    fn edge(
        &mut self,
        reading: &mut Reading<'_, '_>,
        node: Node<'_, '_>,
        id: &str,
        edge: &str,
        value: Expr,
    ) -> Expr {
        let of = if edge == "falling" { "F_TRIG" } else { "R_TRIG" };
        let name = reading.hidden(&format!("e{id}"), of, self.text.line(node));
        let clock = Argument { name: Some("CLK".to_owned()), is_output: false, value };
        self.add(node, Kind::Call(Path::name(name.clone()), vec![clock]));
        Expr::Variable(Path::name(name).with("Q"))
    }

    /// Carries out a block, once.
    fn block(
        &mut self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'a, 'i>,
    ) -> Result<(), Fault> {
        if !self.done.insert(id) {
            return Ok(());
        }
        self.open.insert(id);
        let mut given = Vec::new();
        let mut enable = None;
        for list in ["inputVariables", "inOutVariables"] {
            for one in child(node, list).into_iter().flat_map(|list| children(list, "variable")) {
                let name = one.attribute("formalParameter").unwrap_or_default();
                let from: Vec<_> = children(one, "connectionPointIn").flat_map(sources).collect();
                if from.is_empty() {
                    continue;
                }
                let mut value = self.joined(reading, node, &from)?;
                if let Some(edge) = one.attribute("edge").filter(|edge| *edge != "none") {
                    value = self.edge(reading, node, &format!("{id}_{name}"), edge, value);
                }
                if is(one, "negated") {
                    value = value.not();
                }
                if name.eq_ignore_ascii_case("EN") {
                    enable = Some(value);
                } else {
                    let name = Some(name.to_owned()).filter(|name| !name.is_empty());
                    given.push(Argument { name, is_output: false, value });
                }
            }
        }
        self.open.remove(id);
        let of = node.attribute("typeName").unwrap_or_default();
        let enable = enable.unwrap_or_else(|| Expr::bool(true));
        if let Some(instance) = node.attribute("instanceName").filter(|name| !name.is_empty()) {
            let target = path_of(instance, self.text.line(node))?;
            self.add(node, Kind::CallIf(enable.clone(), target, given));
        } else {
            let result = reading.hidden(&format!("n{id}"), "", 0);
            for other in self.outputs(node).into_iter().skip(1) {
                let value = Expr::name(format!("{result}_{other}"));
                given.push(Argument { name: Some(other), is_output: true, value });
            }
            let call = Expr::Call(path_of(of, self.text.line(node))?, given);
            let carried = Statement {
                line: self.text.line(node),
                kind: Kind::Assign(Path::name(result), call),
            };
            if enable.is(true) {
                self.statements.push(carried);
            } else {
                self.add(node, Kind::If(vec![(enable.clone(), vec![carried])], Vec::new()));
            }
        }
        self.kept.insert((id, "ENO".to_owned()), enable);
        Ok(())
    }

    /// The names of a block's outputs but ENO.
    fn outputs(&self, node: Node<'_, '_>) -> Vec<String> {
        let list = child(node, "outputVariables").into_iter();
        let all = list.flat_map(|list| children(list, "variable"));
        let names = all.map(|one| one.attribute("formalParameter").unwrap_or_default().to_owned());
        names.filter(|name| !name.eq_ignore_ascii_case("ENO")).collect()
    }

    fn block_output(
        &self,
        reading: &mut Reading<'_, '_>,
        id: &str,
        node: Node<'_, '_>,
        output: &str,
    ) -> Expr {
        if output.eq_ignore_ascii_case("ENO") {
            let enable = self.kept.iter().find(|((own, name), _)| *own == id && name == "ENO");
            return enable.map_or_else(|| Expr::bool(true), |(_, value)| value.clone());
        }
        let outputs = self.outputs(node);
        let first = outputs.first().cloned().unwrap_or_default();
        let named = if output.is_empty() { first.clone() } else { output.to_owned() };
        let negated =
            child(node, "outputVariables").into_iter().flat_map(|list| children(list, "variable"));
        let negated = negated
            .filter(|one| one.attribute("formalParameter").unwrap_or_default() == named)
            .any(|one| is(one, "negated"));
        let value = match node.attribute("instanceName").filter(|name| !name.is_empty()) {
            Some(instance) => Expr::Variable(Path::name(instance).with(&named)),
            None => {
                let result = reading.hidden(&format!("n{id}"), "", 0);
                Expr::name(if named == first { result } else { format!("{result}_{named}") })
            }
        };
        if negated { value.not() } else { value }
    }

    /// Carries out an element that does something.
    fn act(&mut self, reading: &mut Reading<'_, '_>, id: &'a str) -> Result<(), Fault> {
        let node = self.nodes[id];
        match node.tag_name().name() {
            "block" => self.block(reading, id, node),
            "coil" | "outVariable" => {
                let name = if node.tag_name().name() == "coil" { "variable" } else { "expression" };
                let Expr::Variable(target) = self.operand(node, name)? else {
                    let message = format!("{}: it writes to no variable", called(node));
                    return Err(self.text.fault(node, message));
                };
                let mut value = self.joined(reading, node, &inputs(node))?;
                if let Some(edge) = node.attribute("edge").filter(|edge| *edge != "none") {
                    value = self.edge(reading, node, id, edge, value);
                }
                if is(node, "negated") {
                    value = value.not();
                }
                let kind = match node.attribute("storage") {
                    Some("set") => Kind::Latch(target, true, value),
                    Some("reset") => Kind::Latch(target, false, value),
                    _ => Kind::Assign(target, value),
                };
                self.add(node, kind);
                Ok(())
            }
            "return" => {
                let value = self.joined(reading, node, &inputs(node))?;
                let value = if is(node, "negated") { value.not() } else { value };
                self.add(node, Kind::Return(value));
                Ok(())
            }
            "jump" => {
                let value = self.joined(reading, node, &inputs(node))?;
                let label = node.attribute("label").unwrap_or_default().to_owned();
                self.add(node, Kind::Jump(value, label));
                Ok(())
            }
            "label" => {
                let label = node.attribute("label").unwrap_or_default().to_owned();
                self.add(node, Kind::Label(label));
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

fn path_of(text: &str, line: u32) -> Result<Path, Fault> {
    match parse::expression(text, line)? {
        Expr::Variable(path) => Ok(path),
        _ => Err(Fault::new(line, format!("'{text}' is no name"))),
    }
}

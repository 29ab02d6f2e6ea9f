//! Ladder and function block diagrams: graphs of contacts, coils and blocks, as statements.
//!
//! What an element puts out is an expression of what leads to it: parallel ways are joined by OR. Each coil, output and pin has
//! an expression of its own, as generators write it; within it, what forks and joins again is kept in a variable.

mod block;
mod computed;
mod execute;
mod kinds;
mod orders;
mod paths;
mod pins;
mod places;
mod rank;
mod value;

use super::checked::{PASSIVE, checked};
use super::node::{Text, elements, inputs, is};
use super::reading::Reading;
use crate::ast::{Expr, Kind, Statement};
use crate::fault::Fault;
use orders::{Carried, Loops, Order};
use places::Places;
pub(super) use rank::{order, rank};
use roxmltree::Node;
use scanbound_base::code::Code;
use std::collections::{BTreeMap, BTreeSet};
use value::{Kept, calls, put_in};

/// A graph, and what of it has been carried out.
#[derive(Clone)]
pub(super) struct Graph<'a, 'i> {
    text: &'a Text,
    nodes: BTreeMap<&'a str, Node<'a, 'i>>,
    /// How often each output leads somewhere.
    forks: BTreeMap<&'a str, usize>,
    /// Whether it has jumps, labels or returns.
    jumps: bool,
    /// Contacts that look at edges, and what they lead to.
    behind_edges: BTreeSet<&'a str>,
    /// Which variables are one and the same.
    places: Places,
    /// Elements that lead back to themselves.
    loops: Loops<'a>,
    /// What outputs were worth when they were first stored.
    kept: BTreeMap<(&'a str, String), Kept>,
    /// Whether it is carried out as generators do.
    generated: bool,
    /// Whether ways to a coil were joined by AND, as generators do where something stands behind it.
    joins_all: bool,
    /// Whether what is asked for twice in the expression that is put together is written once.
    is_written_once: bool,
    /// How many elements have been looked at for it.
    visits: usize,
    /// What outputs are worth in the expression that is put together.
    looked_at: BTreeMap<(&'a str, String), Expr>,
    /// Whether blocks that have been carried out were enabled.
    enables: BTreeMap<&'a str, Expr>,
    /// What blocks were handed in and out.
    given_back: BTreeMap<(&'a str, String), Expr>,
    /// What is stored, by the names that it has.
    named: BTreeMap<String, Kept>,
    /// What edges showed when they were first looked at, and their clocks.
    edges: BTreeMap<String, Kept>,
    /// How often each value was stored and each edge looked at.
    times: BTreeMap<String, usize>,
    eithers: usize,
    open: BTreeSet<&'a str>,
    /// How many elements are being looked at.
    depth: usize,
    done: BTreeSet<&'a str>,
    statements: Vec<Statement>,
    /// The element that each statement belongs to.
    owners: Vec<&'a str>,
    /// The element that is carried out.
    owner: &'a str,
    /// Variables that blocks were handed in and out, and how many statements had been carried out then.
    handed: Vec<(usize, String)>,
    /// How many statements had been carried out before each block that may write what is not its own: globals, and what it
    /// is handed in and out.
    foreign: Vec<usize>,
    /// The number of execution of the element that is carried out, if it has one.
    acting: Option<u64>,
}

fn is_called(node: Node<'_, '_>, name: &str) -> bool {
    node.tag_name().name() == name
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
            checked(text, node)?;
        }
        let mut forks = BTreeMap::new();
        for connection in body.descendants().filter(|one| one.tag_name().name() == "connection") {
            if let Some(id) = connection.attribute("refLocalId") {
                *forks.entry(id).or_insert(0) += 1;
            }
        }
        for (&id, connector) in nodes.iter().filter(|(_, node)| is_called(**node, "connector")) {
            let name = connector.attribute("name");
            let is_other = |(other, node): (&&str, &Node<'_, '_>)| {
                *other != id && is_called(*node, "connector") && node.attribute("name") == name
            };
            if nodes.iter().any(is_other) {
                let message = format!("{}: another connector has its name", called(*connector));
                return Err(wrong(text, *connector, message));
            }
            let goes_on = |node: &&Node<'_, '_>| {
                is_called(**node, "continuation") && node.attribute("name") == name
            };
            *forks.entry(id).or_insert(0) += nodes.values().filter(goes_on).count();
        }
        let acts = ["jump", "return", "label"];
        Ok(Graph {
            text,
            jumps: nodes.values().any(|node| acts.contains(&node.tag_name().name())),
            behind_edges: paths::behind_edges(&nodes),
            nodes,
            forks,
            generated: false,
            joins_all: false,
            is_written_once: true,
            visits: 0,
            places: Places::default(),
            loops: Loops::default(),
            kept: BTreeMap::new(),
            looked_at: BTreeMap::new(),
            enables: BTreeMap::new(),
            given_back: BTreeMap::new(),
            named: BTreeMap::new(),
            edges: BTreeMap::new(),
            times: BTreeMap::new(),
            eithers: 0,
            open: BTreeSet::new(),
            depth: 0,
            done: BTreeSet::new(),
            statements: Vec::new(),
            owners: Vec::new(),
            owner: "",
            handed: Vec::new(),
            foreign: Vec::new(),
            acting: None,
        })
    }

    /// All that the drawing does, in order; where tools keep different orders and these differ, in either.
    pub(super) fn statements(
        mut self,
        reading: &mut Reading<'_, '_>,
    ) -> Result<Vec<Statement>, Fault> {
        let is_numbered = self.nodes.values().any(|node| order(*node).is_some());
        let moves = |node: &&Node<'_, '_>| {
            matches!(node.tag_name().name(), "label" | "jump" | "return") && order(**node).is_none()
        };
        if let Some(&node) = self.nodes.values().find(moves).filter(|_| is_numbered) {
            let message = format!(
                "{}: it has no executionOrderId, but other elements have: what is jumped over is not clear",
                called(node)
            );
            let help = "number it, too, or leave out all numbers: then elements are carried out from top to bottom";
            return Err(self.text.fault(node, message).code(Code::NotModelled).help(help));
        }
        self.places = Places::new(reading, self.nodes.values().copied());
        let orders = self.orders();
        let line = orders.first().and_then(|order| order.acting.first());
        let line = line.map_or(0, |id| self.text.line(self.nodes[id]));
        let mut ways: Vec<(&'static str, Carried<'a>)> = Vec::new();
        for order in orders {
            let what = order.what;
            let carried = self.clone().carried_out(reading, order)?;
            if ways.iter().all(|(_, known)| known.differs(&carried, &self.places)) {
                ways.push((what, carried));
            }
        }
        let all = ways.into_iter().map(|(what, carried)| (what, carried.statements));
        let either = |(one, before): (_, Vec<_>), (what, other)| {
            (one, vec![Statement { line, kind: Kind::Either(what, other, before) }])
        };
        Ok(all.reduce(either).map(|(_, statements)| statements).unwrap_or_default())
    }

    fn carried_out(
        mut self,
        reading: &mut Reading<'_, '_>,
        in_order: Order<'a>,
    ) -> Result<Carried<'a>, Fault> {
        self.loops = in_order.loops;
        self.generated = in_order.generated;
        for id in in_order.acting {
            self.acting = order(self.nodes[id]);
            self.act(reading, id)?;
        }
        let mut carried =
            Carried::new(self.statements, self.owners, &self.foreign, &self.handed, &self.places);
        carried.joins_all = self.joins_all;
        Ok(carried)
    }

    /// The value of a condition that is drawn: what leads to its only coil, or to the right rail, or out of it.
    pub(super) fn result(
        &mut self,
        reading: &mut Reading<'_, '_>,
        body: Node<'a, 'i>,
    ) -> Result<Expr, Fault> {
        let is_end = |node: &Node<'a, 'i>| {
            matches!(node.tag_name().name(), "coil" | "outVariable")
                || (is_called(*node, "inOutVariable") && !inputs(*node).is_empty())
        };
        let all = || self.nodes.values().copied();
        let mut ends: Vec<Node<'a, 'i>> = all().filter(is_end).collect();
        if ends.is_empty() {
            ends.extend(all().filter(|node| is_called(*node, "rightPowerRail")));
        }
        let [end] = ends[..] else {
            let message = match ends[..] {
                [] => "nothing says what the condition is",
                _ => "several elements say what the condition is",
            };
            return Err(self.text.fault(body, message).help("leave one coil or output in it"));
        };
        let acts =
            |node: &Node<'a, 'i>| matches!(node.tag_name().name(), "jump" | "return" | "label");
        let has_edge = end.attribute("edge").is_some_and(|edge| edge != "none");
        let is_stored = end.attribute("storage").is_some_and(|storage| storage != "none");
        if let Some(node) = all().find(acts).or((has_edge || is_stored).then_some(end)) {
            let message = format!("{}: it is not followed in a condition", called(node));
            return Err(self.text.fault(node, message));
        }
        let value = self.condition(reading, end, &inputs(end))?;
        let left = self
            .nodes
            .iter()
            .find(|(id, node)| is_called(**node, "block") && !self.done.contains(*id));
        if let Some((_, &node)) = left {
            let message = format!("{}: the condition does not depend on it", called(node));
            return Err(self.text.fault(node, message));
        }
        Ok(if is(end, "negated") || is(end, "negatedIn") { value.not() } else { value })
    }

    /// The value of a condition that leads in through connections. Nothing but its value is looked at, so nothing that a block
    /// does may be left over.
    pub(super) fn condition(
        &mut self,
        reading: &mut Reading<'_, '_>,
        node: Node<'_, '_>,
        from: &[(&str, Option<&str>)],
    ) -> Result<Expr, Fault> {
        let mut value = self.used(reading, node, from)?;
        if let Some(value) = self.computed(reading, &value)? {
            return Ok(value);
        }
        // Functions, and what is kept where ways fork, are put where they are asked for.
        self.owners.clear();
        for statement in std::mem::take(&mut self.statements).into_iter().rev() {
            let put = match &statement.kind {
                Kind::Assign(target, own) if target.first.starts_with('~') => {
                    put_in(&mut value, target, own).filter(|&times| times < 2 || !calls(own))
                }
                _ => None,
            };
            if put.is_none() {
                let (what, help) = match &statement.kind {
                    Kind::Assign(target, own) if target.first.starts_with('~') && !calls(own) => (
                        "its ways fork and join too often to be followed",
                        "draw a part of it with a coil, and use that here",
                    ),
                    _ => (
                        "a condition with a block that remembers is not followed",
                        "carry the block out in an action, and use what it puts out",
                    ),
                };
                return Err(Fault::new(statement.line, format!("{}: {what}", called(node)))
                    .code(Code::NotModelled)
                    .help(help));
            }
        }
        Ok(value)
    }

    /// Carries out an element that does something.
    fn act(&mut self, reading: &mut Reading<'_, '_>, id: &'a str) -> Result<(), Fault> {
        let outer = std::mem::replace(&mut self.owner, id);
        let done = self.act_as_owner(reading, id);
        self.owner = outer;
        done
    }

    fn act_as_owner(&mut self, reading: &mut Reading<'_, '_>, id: &'a str) -> Result<(), Fault> {
        let node = self.nodes[id];
        match node.tag_name().name() {
            "block" => self.block(reading, id, node),
            "coil" | "outVariable" | "inOutVariable" => {
                if is_called(node, "inOutVariable") && inputs(node).is_empty() {
                    return Ok(());
                }
                if !self.done.insert(id) {
                    return Ok(());
                }
                let name = if node.tag_name().name() == "coil" { "variable" } else { "expression" };
                let Expr::Variable(target) = self.operand(node, name)? else {
                    let message = format!("{}: it writes to no variable", called(node));
                    return Err(self.text.fault(node, message));
                };
                let from = inputs(node);
                let mut value = self.used(reading, node, &from)?;
                if is_called(node, "coil") && self.forks.contains_key(id) {
                    value = self.store(reading, node, (id, String::new()), value);
                }
                if let Some(edge) = node.attribute("edge").filter(|edge| *edge != "none") {
                    value = self.edge(reading, node, id, edge, value);
                }
                if is(node, "negated") || is(node, "negatedIn") {
                    value = Expr::Not(Box::new(value));
                }
                let taken = match is_called(node, "coil") {
                    // Some controllers write nothing where nothing leads to it.
                    _ if from.is_empty() => Expr::any(),
                    false => self.taken(&from),
                    true => Expr::bool(true),
                };
                let kind = match node.attribute("storage") {
                    Some("set") => Kind::Latch(target, true, value),
                    Some("reset") => Kind::Latch(target, false, value),
                    _ => Kind::Assign(target, value),
                };
                let line = self.text.line(node);
                let carried = Statement { line, kind };
                if taken.is(true) {
                    self.carried(carried);
                } else {
                    self.add(node, Kind::If(vec![(taken, vec![carried])], Vec::new()));
                }
                Ok(())
            }
            "return" => {
                let value = self.used(reading, node, &inputs(node))?;
                let value = if is(node, "negated") { value.not() } else { value };
                self.add(node, Kind::Return(value));
                Ok(())
            }
            "jump" => {
                let value = self.used(reading, node, &inputs(node))?;
                let value = if is(node, "negated") { value.not() } else { value };
                let label = node.attribute("label").unwrap_or_default().to_owned();
                self.add(node, Kind::Jump(value, label));
                Ok(())
            }
            "label" => {
                let label = node.attribute("label").unwrap_or_default().to_owned();
                self.add(node, Kind::Label(label));
                Ok(())
            }
            // Generators look at the edges in front of it, whatever it leads to.
            "connector" if self.generated => {
                self.used(reading, node, &inputs(node))?;
                Ok(())
            }
            name if PASSIVE.contains(&name) => Ok(()),
            name => {
                let message = format!("{}: elements {name} are not followed", called(node));
                Err(self.text.fault(node, message).code(Code::NotModelled))
            }
        }
    }
}

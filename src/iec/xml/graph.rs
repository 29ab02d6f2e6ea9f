//! Ladder and function block diagrams: graphs of contacts, coils and blocks, as statements.
//!
//! What an element puts out is an expression of what leads to it: parallel ways are joined by OR. Where a way forks, its value
//! is kept in a variable, so that nothing is written twice, however often ways fork and join.

use super::checked::{PASSIVE, checked};
use super::node::{Text, child, children, elements, inputs, is, sources};
use super::order::{order, rank};
use super::reading::Reading;
use super::standard::is_standard;
use crate::base::code::Code;
use crate::iec::ast::{Argument, EITHER, Expr, Kind, Path, Statement, paths_of, visit};
use crate::iec::fault::Fault;
use crate::iec::{parse, same};
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// How deep ways may be followed.
const DEPTH: usize = 150;

/// What an output has been worked out as.
#[derive(Clone)]
struct Kept {
    value: Expr,
    /// Where it was stored: what was stored, and how many statements had been carried out then.
    stored: Option<(Expr, usize)>,
}

/// A graph, and what of it has been carried out.
pub(super) struct Graph<'a, 'i> {
    text: &'a Text,
    nodes: BTreeMap<&'a str, Node<'a, 'i>>,
    /// How often each output leads somewhere.
    forks: BTreeMap<&'a str, usize>,
    kept: BTreeMap<(&'a str, String), Kept>,
    /// What is stored, by the names that it has.
    named: BTreeMap<String, Kept>,
    open: BTreeSet<&'a str>,
    done: BTreeSet<&'a str>,
    statements: Vec<Statement>,
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
        Ok(Graph {
            text,
            nodes,
            forks,
            kept: BTreeMap::new(),
            named: BTreeMap::new(),
            open: BTreeSet::new(),
            done: BTreeSet::new(),
            statements: Vec::new(),
            handed: Vec::new(),
            foreign: Vec::new(),
            acting: None,
        })
    }

    /// All that the graph does, in order.
    pub(super) fn statements(
        &mut self,
        reading: &mut Reading<'_, '_>,
    ) -> Result<Vec<Statement>, Fault> {
        let mut acting: Vec<(_, &'a str)> =
            self.nodes.iter().map(|(&id, &node)| (rank(node, node.range().start), id)).collect();
        acting.sort();
        if let Some(&node) = acting.iter().map(|(_, id)| &self.nodes[id]).find(|node| {
            matches!(node.tag_name().name(), "label" | "jump" | "return") && order(**node).is_none()
        }) && self.nodes.values().any(|node| order(*node).is_some())
        {
            let message = format!(
                "{}: it has no executionOrderId, but other elements have: what is jumped over is not clear",
                called(node)
            );
            let help = "number it, too, or leave out all numbers: then elements are carried out from top to bottom";
            return Err(self.text.fault(node, message).code(Code::NotModelled).help(help));
        }
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
            let message = format!("{}: the condition does not hang on it", called(node));
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
        let mut value = self.joined(reading, node, from)?;
        // Functions, and what is kept where ways fork, are put where they are asked for.
        for statement in std::mem::take(&mut self.statements).into_iter().rev() {
            let put = match &statement.kind {
                Kind::Assign(target, own) if target.first.starts_with('~') => {
                    put_in(&mut value, target, own).filter(|&times| times < 2 || !calls(own))
                }
                _ => None,
            };
            if put.is_none() {
                let what = "a condition with a block that remembers is not followed";
                let help = "carry the block out in an action, and use what it puts out";
                return Err(Fault::new(statement.line, format!("{}: {what}", called(node)))
                    .code(Code::NotModelled)
                    .help(help));
            }
        }
        Ok(value)
    }

    /// The value that leads in through connections.
    pub(super) fn joined(
        &mut self,
        reading: &mut Reading<'_, '_>,
        node: Node<'_, '_>,
        from: &[(&str, Option<&str>)],
    ) -> Result<Expr, Fault> {
        let mut ways = Vec::new();
        for (id, output) in from {
            let Some((&id, _)) = self.nodes.get_key_value(*id) else {
                let message = format!(
                    "{}: a connection leads to localId {id}, which is not there",
                    called(node)
                );
                return Err(wrong(self.text, node, message));
            };
            let value = self.value(reading, id, output.unwrap_or_default())?;
            ways.push(value);
        }
        // What is not connected carries no power.
        Ok(any_of(&ways).unwrap_or_else(|| Expr::bool(false)))
    }

    fn value(
        &mut self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        output: &str,
    ) -> Result<Expr, Fault> {
        let key = (id, output.to_owned());
        if let Some(kept) = self.kept.get(&key) {
            return Ok(self.again(kept));
        }
        let node = self.nodes[id];
        if self.is_fed_back(id, node) {
            return Ok(self.block_output(reading, id, node, output));
        }
        if self.open.len() >= DEPTH && !self.open.contains(id) {
            let message =
                format!("{}: more than {DEPTH} elements stand in a row behind it", called(node));
            let help = "put a coil in between";
            return Err(self.text.fault(node, message).code(Code::NotModelled).help(help));
        }
        if !self.open.insert(id) {
            let message =
                format!("{}: the ways through it come back to where they began", called(node));
            return Err(wrong(self.text, node, message));
        }
        let found = self.put_out(reading, id, node, output);
        self.open.remove(id);
        let value = found?;
        if self.kept.contains_key(&key) {
            return Ok(value);
        }
        // What a contact lets through is settled when it is looked at; a variable that is wired up is read where it is used.
        let is_plain = match value {
            Expr::Literal(_) => true,
            Expr::Variable(_) => node.tag_name().name() != "contact",
            _ => false,
        };
        if is_plain || self.forks.get(id).is_none_or(|&count| count < 2) {
            self.kept.insert(key, Kept { value: value.clone(), stored: None });
            return Ok(value);
        }
        let name = reading.hidden(&format!("v{id}_{output}"), "", 0);
        Ok(self.store(node, key, name, value))
    }

    /// Stores a value, since what it is made of may change before it is asked for again.
    fn store(
        &mut self,
        node: Node<'_, '_>,
        key: (&'a str, String),
        name: String,
        value: Expr,
    ) -> Expr {
        let path = Path::name(name.clone());
        self.add(node, Kind::Assign(path.clone(), value.clone()));
        let stored = Expr::Variable(path);
        let kept = Kept { value: stored.clone(), stored: Some((value, self.statements.len())) };
        self.named.insert(name, kept.clone());
        self.kept.insert(key, kept);
        stored
    }

    /// A value that was worked out before. Where variables that it is made of have been written since, some controllers look at
    /// them again, and others do not.
    fn again(&self, kept: &Kept) -> Expr {
        let mut left = PLACES;
        self.either(kept, &mut left)
    }

    fn either(&self, kept: &Kept, left: &mut usize) -> Expr {
        let Some((value, _)) = &kept.stored else { return kept.value.clone() };
        if !self.has_changed(kept) {
            return kept.value.clone();
        }
        let behind = names(value).into_iter().filter_map(|name| self.named.get(name));
        let unnamed = |value| Argument { name: None, is_output: false, value };
        let mut other = value.clone();
        for kept in behind {
            *left = left.saturating_sub(1);
            let (Expr::Variable(name), true) = (&kept.value, *left > 0) else {
                // Any value.
                return Expr::Call(Path::name(EITHER), Vec::new());
            };
            let own = self.either(kept, left);
            if own != kept.value && put_in(&mut other, name, &own).is_none() {
                return Expr::Call(Path::name(EITHER), Vec::new());
            }
        }
        Expr::Call(Path::name(EITHER), vec![unnamed(kept.value.clone()), unnamed(other)])
    }

    /// Whether a stored value might be another one if it was worked out again.
    fn has_changed(&self, kept: &Kept) -> bool {
        let mut open = vec![kept];
        let mut seen = BTreeSet::new();
        while let Some(kept) = open.pop() {
            let Some((value, at)) = &kept.stored else { continue };
            if self.may_have_changed(value, *at) {
                return true;
            }
            let behind = names(value).into_iter().filter(|name| seen.insert((*name).to_owned()));
            open.extend(behind.filter_map(|name| self.named.get(name)));
        }
        false
    }

    /// Whether a variable that an expression reads may have been written since so many statements had been carried out.
    fn may_have_changed(&self, value: &Expr, since: usize) -> bool {
        let has_variable = |value: &Expr| {
            let mut one = value.clone();
            let mut found = false;
            paths_of(&mut one, &mut |path| found |= !path.first.starts_with('~'));
            found
        };
        if self.foreign.iter().any(|at| *at >= since) && has_variable(value) {
            return true;
        }
        let handed = self.handed.iter().filter(|(at, _)| *at >= since);
        let mut found = handed.into_iter().any(|(_, name)| reads(value, name));
        visit(&self.statements[since..], &mut |one| match &one.kind {
            Kind::Assign(target, _)
            | Kind::Refer(target, _)
            | Kind::Latch(target, ..)
            | Kind::Call(target, _)
            | Kind::CallIf(_, target, _) => {
                // What has a name of its own here is written once.
                found |= !target.first.starts_with('~') && reads(value, &target.first);
            }
            _ => {}
        });
        found
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
            // What stands behind a coil has what leads to it, as it was before the coil was written.
            "coil" => {
                self.act(reading, id)?;
                let kept = self.kept.get(&(id, String::new()));
                Ok(kept.map_or_else(|| Expr::bool(false), |kept| self.again(kept)))
            }
            "rightPowerRail" => self.joined(reading, node, &inputs(node)),
            "inVariable" | "inOutVariable" => {
                // What leads into it is written before it is read.
                if !inputs(node).is_empty() {
                    self.act(reading, id)?;
                }
                let value = self.operand(node, "expression")?;
                let negated = is(node, "negated") || is(node, "negatedOut");
                Ok(if negated { value.not() } else { value })
            }
            "outVariable" => self.joined(reading, node, &inputs(node)),
            "continuation" => {
                let name = node.attribute("name");
                let from = self.nodes.iter().find(|(_, one)| {
                    is_called(**one, "connector") && one.attribute("name") == name
                });
                let Some((&from, _)) = from else {
                    let message = format!("{}: no connector has its name", called(node));
                    return Err(wrong(self.text, node, message));
                };
                self.value(reading, from, "")
            }
            "connector" => self.joined(reading, node, &inputs(node)),
            "block" => {
                if !self.done.contains(id)
                    && order(node).zip(self.acting).is_some_and(|(own, at)| own > at)
                {
                    let message = format!(
                        "{}: what takes its result is carried out before it, by their numbers",
                        called(node)
                    );
                    let help = "number it before what takes its result";
                    return Err(self.text.fault(node, message).code(Code::NotModelled).help(help));
                }
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
                if let (Expr::Variable(path), "inOutVariables") = (&value, list) {
                    self.handed.push((self.statements.len(), path.first.clone()));
                }
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
        let key = (id, "ENO".to_owned());
        let enable = match enable {
            Expr::Literal(_) => {
                self.kept.insert(key, Kept { value: enable.clone(), stored: None });
                enable
            }
            other => {
                let name = reading.hidden(&format!("v{id}_ENO"), "", 0);
                self.store(node, key, name, other)
            }
        };
        let instance = node.attribute("instanceName").filter(|name| !name.is_empty());
        if !is_standard(of, instance.is_some()) {
            self.foreign.push(self.statements.len());
        }
        if let Some(instance) = instance {
            let target = path_of(instance, self.text.line(node))?;
            self.add(node, Kind::CallIf(enable, target, given));
        } else {
            let result = reading.hidden(&format!("n{id}"), "", 0);
            for other in self.outputs(node).into_iter().skip(1) {
                let value = Expr::name(format!("{result}_{other}"));
                given.push(Argument { name: Some(other), is_output: true, value });
            }
            if !enable.is(true) {
                let name = Some("EN".to_owned());
                given.push(Argument { name, is_output: false, value: enable });
            }
            // Operators are functions, too.
            let is_word = of.chars().all(|c| c.is_alphanumeric() || c == '_') && !of.is_empty();
            let function = match is_word {
                true => Path::name(of),
                false => path_of(of, self.text.line(node))?,
            };
            let call = Expr::Call(function, given);
            self.add(node, Kind::Assign(Path::name(result), call));
        }
        Ok(())
    }

    /// Whether a block that has been carried out was enabled.
    fn enabled(&self, id: &str) -> Expr {
        let enable = self.kept.iter().find(|((own, name), _)| *own == id && name == "ENO");
        enable.map_or_else(|| Expr::bool(true), |(_, kept)| kept.value.clone())
    }

    /// The condition under which an element takes over what leads to it: nothing is taken over from a function that is not
    /// enabled. Of a function block some controllers take over what it put out before.
    fn taken(&self, from: &[(&str, Option<&str>)]) -> Expr {
        let [(id, output)] = from else { return Expr::bool(true) };
        let block = self.nodes.get(id).filter(|node| is_called(**node, "block"));
        let is_enable = output.is_some_and(|output| output.eq_ignore_ascii_case("ENO"));
        let Some(block) = block.filter(|_| !is_enable) else { return Expr::bool(true) };
        let enable = self.enabled(id);
        let has_instance = block.attribute("instanceName").is_some_and(|name| !name.is_empty());
        if enable.is(true) || !has_instance {
            return enable;
        }
        let unnamed = |value| Argument { name: None, is_output: false, value };
        let both = vec![unnamed(enable), unnamed(Expr::bool(true))];
        Expr::Call(Path::name(EITHER), both)
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
            return self.enabled(id);
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
                let mut value = self.joined(reading, node, &from)?;
                if is_called(node, "coil") && self.forks.contains_key(id) {
                    let name = reading.hidden(&format!("v{id}_"), "", 0);
                    value = self.store(node, (id, String::new()), name, value);
                }
                if let Some(edge) = node.attribute("edge").filter(|edge| *edge != "none") {
                    value = self.edge(reading, node, id, edge, value);
                }
                if is(node, "negated") || is(node, "negatedIn") {
                    value = value.not();
                }
                let taken = match is_called(node, "coil") {
                    // Some controllers write nothing where nothing leads to it.
                    _ if from.is_empty() => Expr::Call(Path::name(EITHER), Vec::new()),
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
                    self.statements.push(carried);
                } else {
                    self.add(node, Kind::If(vec![(taken, vec![carried])], Vec::new()));
                }
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
            name if PASSIVE.contains(&name) => Ok(()),
            name => {
                let message = format!("{}: elements {name} are not followed", called(node));
                Err(self.text.fault(node, message).code(Code::NotModelled))
            }
        }
    }
}

/// So many ways are joined one after the other; more in halves, so that no expression is as deep as it is long.
const ROW: usize = 100;

fn any_of(ways: &[Expr]) -> Option<Expr> {
    if ways.len() <= ROW {
        return ways.iter().cloned().reduce(Expr::or);
    }
    let (front, back) = ways.split_at(ways.len() / 2);
    Some(any_of(front)?.or(any_of(back)?))
}

/// More places than this are not put in.
const PLACES: usize = 1000;

/// Puts a value in where a name stands; how often, or nothing if it is too often.
fn put_in(one: &mut Expr, name: &Path, value: &Expr) -> Option<usize> {
    let times = match one {
        Expr::Variable(path) if path == name => {
            *one = value.clone();
            1
        }
        Expr::Variable(_) | Expr::Literal(_) => 0,
        Expr::Not(inner) | Expr::Negate(inner) => put_in(inner, name, value)?,
        Expr::Binary(_, left, right) => put_in(left, name, value)? + put_in(right, name, value)?,
        Expr::Call(_, given) => {
            let put = |sum, one: &mut Argument| Some(sum + put_in(&mut one.value, name, value)?);
            given.iter_mut().try_fold(0, put)?
        }
    };
    (times < PLACES).then_some(times)
}

/// The names of what an expression reads that is kept.
fn names(one: &Expr) -> Vec<&str> {
    match one {
        Expr::Variable(path) if path.first.starts_with('~') => vec![&path.first],
        Expr::Variable(_) | Expr::Literal(_) => Vec::new(),
        Expr::Not(inner) | Expr::Negate(inner) => names(inner),
        Expr::Binary(_, left, right) => [names(left), names(right)].concat(),
        Expr::Call(_, given) => given.iter().flat_map(|one| names(&one.value)).collect(),
    }
}

/// Whether an expression calls anything.
fn calls(one: &Expr) -> bool {
    match one {
        Expr::Call(..) => true,
        Expr::Not(inner) | Expr::Negate(inner) => calls(inner),
        Expr::Binary(_, left, right) => calls(left) || calls(right),
        Expr::Literal(_) | Expr::Variable(_) => false,
    }
}

/// Whether an expression reads a variable, or a part of it.
fn reads(one: &Expr, name: &str) -> bool {
    match one {
        Expr::Variable(path) => same(&path.first, name),
        Expr::Not(inner) | Expr::Negate(inner) => reads(inner, name),
        Expr::Binary(_, left, right) => reads(left, name) || reads(right, name),
        Expr::Call(_, given) => given.iter().any(|one| reads(&one.value, name)),
        Expr::Literal(_) => false,
    }
}

fn path_of(text: &str, line: u32) -> Result<Path, Fault> {
    match parse::expression(text, line)? {
        Expr::Variable(path) => Ok(path),
        _ => Err(Fault::new(line, format!("'{text}' is no name"))),
    }
}

//! Blocks of a drawing: functions and instances.

use super::pins::{is_instance, name_of, pins, result};
use super::{Graph, called, execute, is_called};
use crate::ast::{Argument, Expr, Kind, LOADED, Path, Statement};
use crate::fault::Fault;
use crate::xml::node::{children, is, sources};
use crate::xml::reading::Reading;
use crate::xml::standard::is_standard;
use crate::{TypeRef, parse, same};
use roxmltree::Node;
use std::collections::BTreeSet;

/// Functions that are drawn with a sign.
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

/// Whether a pin stands on both sides of a block.
fn comes_back(node: Node<'_, '_>, name: &str) -> bool {
    pins(node, "outputVariables").any(|pin| name_of(pin).eq_ignore_ascii_case(name))
}

/// Whether what stands at this output is what the block was handed: a VAR_IN_OUT has a pin on either side.
fn is_given_back(node: Node<'_, '_>, output: &str) -> bool {
    let on_the_left =
        ["inputVariables", "inOutVariables"].into_iter().flat_map(|list| pins(node, list));
    !output.is_empty() && { on_the_left }.any(|pin| name_of(pin).eq_ignore_ascii_case(output))
}

impl<'a, 'i> Graph<'a, 'i> {
    /// Carries out a block, once.
    pub(super) fn block(
        &mut self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'a, 'i>,
    ) -> Result<(), Fault> {
        if !self.done.insert(id) {
            return Ok(());
        }
        let outer = std::mem::replace(&mut self.owner, id);
        // What leads on from a block that is fed back may be asked for again on the way to it.
        let nodes = &self.nodes;
        let (mut blocks, passed): (BTreeSet<&str>, BTreeSet<&str>) = std::mem::take(&mut self.open)
            .into_iter()
            .partition(|id| is_called(nodes[id], "block"));
        blocks.insert(id);
        self.open = blocks;
        let given = self.given(reading, id, node);
        self.open.remove(id);
        self.open.extend(passed);
        let done = given.and_then(|(enable, given)| self.call(reading, id, node, enable, given));
        self.owner = outer;
        done
    }

    /// What leads to EN, and to the other pins.
    fn given(
        &mut self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'a, 'i>,
    ) -> Result<(Expr, Vec<Argument>), Fault> {
        let mut given = Vec::new();
        let mut enable = Expr::bool(true);
        for list in ["inputVariables", "inOutVariables"] {
            let mut all: Vec<_> = pins(node, list).collect();
            // Edges at pins may hang on whether the block is enabled.
            if all.iter().any(|pin| pin.attribute("edge").is_some_and(|edge| edge != "none")) {
                all.sort_by_key(|pin| !name_of(*pin).eq_ignore_ascii_case("EN"));
            }
            for one in all {
                let name = name_of(one);
                let from: Vec<_> = children(one, "connectionPointIn").flat_map(sources).collect();
                let written =
                    children(one, "connectionPointIn").find_map(|at| self.text.written(at));
                let mut value = match written {
                    Some((text, line)) => parse::expression(&text, line)?,
                    None if from.is_empty() => continue,
                    None => self.used(reading, node, &from)?,
                };
                if let Some(edge) = one.attribute("edge").filter(|edge| *edge != "none") {
                    let looked_at = match &enable {
                        Expr::Literal(_) => Expr::bool(true),
                        enable => Expr::either(enable.clone(), Expr::bool(true)),
                    };
                    let of = format!("{id}_{name}");
                    value = self.edge_where(reading, node, &of, edge, value, looked_at);
                }
                if is(one, "negated") {
                    // Of a constant, too, it is charged; but EN is known then.
                    value = match name.eq_ignore_ascii_case("EN") {
                        true => value.not(),
                        false => Expr::Not(Box::new(value)),
                    };
                }
                if list == "inOutVariables" || comes_back(node, name) {
                    self.given_back.insert((id, name.to_ascii_lowercase()), value.clone());
                }
                if name.eq_ignore_ascii_case("EN") {
                    enable = match value {
                        Expr::Literal(_) => value,
                        other if self.gives_enable(node) => other,
                        other => self.store(reading, node, (id, "ENO".to_owned()), other),
                    };
                } else {
                    let name = Some(name.to_owned()).filter(|name| !name.is_empty());
                    given.push(Argument { name, is_output: false, value });
                }
            }
        }
        Ok((enable, given))
    }

    /// Calls a block.
    fn call(
        &mut self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'a, 'i>,
        enable: Expr,
        mut given: Vec<Argument>,
    ) -> Result<(), Fault> {
        let of = node.attribute("typeName").unwrap_or_default();
        self.is_of_its_type(reading, node, of)?;
        self.enables.insert(id, enable.clone());
        if let Some(code) = execute::code(node) {
            if !enable.is(true) {
                let loaded = Path::name(format!("{LOADED}{}", reading.hidden(id, "", 0)));
                self.add(node, Kind::Assign(loaded.clone(), enable.clone()));
                self.enables.insert(id, Expr::Variable(loaded));
            }
            return self.execute(node, code, enable);
        }
        if !is_standard(of, is_instance(node)) {
            self.foreign.push(self.statements.len());
        }
        let given_back = self.given_back.iter().filter(|((own, _), _)| *own == id);
        let at = self.statements.len();
        let handed: Vec<_> = given_back
            .filter_map(|(_, value)| match value {
                Expr::Variable(path) => Some(self.places.names(path)),
                _ => None,
            })
            .flatten()
            .map(|name| (at, name.to_owned()))
            .collect();
        self.handed.extend(handed);
        if let Some(instance) = node.attribute("instanceName").filter(|name| !name.is_empty()) {
            let target = path_of(instance, self.text.line(node))?;
            self.add(node, Kind::CallIf(enable, target, given));
        } else {
            let result = result(reading, id);
            if are_counted(node, &given) {
                given.iter_mut().for_each(|one| one.name = None);
            }
            for other in self.outputs(node).into_iter().skip(1) {
                let value = Expr::name(format!("{result}_{other}"));
                given.push(Argument { name: Some(other), is_output: true, value });
            }
            if self.gives_enable(node) {
                let value = Expr::name(format!("{result}_ENO"));
                self.enables.insert(id, value.clone());
                given.push(Argument { name: Some("ENO".to_owned()), is_output: true, value });
            }
            let is_wired = pins(node, "inputVariables").any(|pin| {
                name_of(pin).eq_ignore_ascii_case("EN")
                    && children(pin, "connectionPointIn").flat_map(sources).next().is_some()
            });
            if !enable.is(true) || (is_wired && self.gives_enable(node)) {
                let name = Some("EN".to_owned());
                given.push(Argument { name, is_output: false, value: enable });
            }
            self.begins_anew(reading, id, node);
            // Operators are functions, too.
            let of = OPERATORS.iter().find(|(sign, _)| *sign == of).map_or(of, |(_, name)| name);
            let is_word = of.chars().all(|c| c.is_alphanumeric() || c == '_') && !of.is_empty();
            let function = match is_word {
                true => Path::name(of),
                false => path_of(of, self.text.line(node))?,
            };
            let call = Expr::Call(function, given);
            self.add(node, Kind::Assign(Path::name(result), call));
        }
        self.written_beside(reading, id, node)
    }

    /// Whether generators take ENO of a function into a variable: it is drawn, and no edge at a pin hangs on EN.
    pub(super) fn gives_enable(&self, node: Node<'_, '_>) -> bool {
        let has_edge = |pin: Node<'_, '_>| pin.attribute("edge").is_some_and(|edge| edge != "none");
        !self.text.is_codesys
            && !is_instance(node)
            && pins(node, "outputVariables").any(|pin| name_of(pin).eq_ignore_ascii_case("ENO"))
            && !pins(node, "inputVariables").any(has_edge)
    }

    /// Refuses one of the standard's blocks that is drawn as another one than its instance is.
    fn is_of_its_type(
        &self,
        reading: &Reading<'_, '_>,
        node: Node<'_, '_>,
        of: &str,
    ) -> Result<(), Fault> {
        let instance = node.attribute("instanceName").unwrap_or_default();
        let own = reading.pou.variables.iter().find(|own| same(&own.name, instance));
        let Some(TypeRef::Named(declared)) = own.map(|own| &own.of) else { return Ok(()) };
        let are_two = is_standard(of, true) && is_standard(declared, true) && !same(of, declared);
        if !are_two {
            return Ok(());
        }
        let message =
            format!("{}: it is drawn as {of}, and {instance} is a {declared}", called(node));
        Err(self.text.fault(node, message))
    }

    /// Writes the variables that stand right at a block's outputs (CODESYS, TwinCAT).
    fn written_beside(
        &mut self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'a, 'i>,
    ) -> Result<(), Fault> {
        for pin in pins(node, "outputVariables") {
            let mut written = children(pin, "connectionPointOut");
            let Some((text, line)) = written.find_map(|at| self.text.written(at)) else { continue };
            let Expr::Variable(target) = parse::expression(&text, line)? else {
                let message = format!(
                    "{}: '{}' is written to, and is no variable",
                    called(node),
                    text.trim()
                );
                return Err(self.text.fault(node, message));
            };
            let name = name_of(pin);
            let value = self.block_output(reading, id, node, name);
            let taken = self.taken(&[(id, Some(name))]);
            let statement = Statement { line, kind: Kind::Assign(target, value) };
            match taken.is(true) {
                true => self.carried(statement),
                false => self.add(node, Kind::If(vec![(taken, vec![statement])], Vec::new())),
            }
        }
        Ok(())
    }

    /// Whether a block that has been carried out was enabled.
    fn enabled(&self, id: &str) -> Expr {
        self.enables.get(id).cloned().unwrap_or_else(|| Expr::bool(true))
    }

    /// The condition under which an element takes over what leads to it: nothing is taken over from a function that is not
    /// enabled. Of a function block some controllers take over what it put out before.
    pub(super) fn taken(&self, from: &[(&str, Option<&str>)]) -> Expr {
        let [(id, output)] = from else { return Expr::bool(true) };
        let block = self.nodes.get(id).filter(|node| is_called(**node, "block"));
        let is_enable = output.is_some_and(|output| output.eq_ignore_ascii_case("ENO"));
        let is_enable = is_enable || block.is_some_and(|node| execute::is_box(*node));
        let Some(&block) = block.filter(|_| !is_enable) else { return Expr::bool(true) };
        let enable = self.enabled(id);
        if enable.is(true) || !is_instance(block) {
            return enable;
        }
        Expr::either(enable, Expr::bool(true))
    }

    /// The names of a block's outputs but ENO and what it gives back.
    pub(super) fn outputs(&self, node: Node<'_, '_>) -> Vec<String> {
        let names = pins(node, "outputVariables").map(name_of);
        let own =
            names.filter(|name| !name.eq_ignore_ascii_case("ENO") && !is_given_back(node, name));
        own.map(str::to_owned).collect()
    }

    /// What a block that has been carried out has at one of its outputs.
    pub(super) fn block_output(
        &self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'_, '_>,
        output: &str,
    ) -> Expr {
        if output.eq_ignore_ascii_case("ENO") || execute::is_box(node) {
            return self.enabled(id);
        }
        let outputs = self.outputs(node);
        let first = outputs.first().cloned().unwrap_or_default();
        let named = if output.is_empty() { first.clone() } else { output.to_owned() };
        let negated =
            pins(node, "outputVariables").any(|pin| name_of(pin) == named && is(pin, "negated"));
        let given_back = self.given_back.get(&(id, named.to_ascii_lowercase()));
        let value = match node.attribute("instanceName").filter(|name| !name.is_empty()) {
            _ if given_back.is_some() => given_back.cloned().unwrap_or_else(|| Expr::bool(false)),
            Some(instance) => Expr::Variable(Path::name(instance).with(&named)),
            None => {
                let result = result(reading, id);
                Expr::name(if named == first { result } else { format!("{result}_{named}") })
            }
        };
        if negated { value.not() } else { value }
    }
}

/// Whether a function's pins are only counted, and not from 1 on: CODESYS and TwinCAT count EN, too.
fn are_counted(node: Node<'_, '_>, given: &[Argument]) -> bool {
    let number = |name: &str| {
        let (front, digits) = name.split_at_checked(2)?;
        digits.parse::<u32>().ok().filter(|_| front.eq_ignore_ascii_case("IN"))
    };
    let own = pins(node, "inputVariables").filter(|pin| !name_of(*pin).eq_ignore_ascii_case("EN"));
    let numbers: Option<Vec<u32>> = own.map(|pin| number(name_of(pin))).collect();
    numbers.is_some_and(|numbers| {
        numbers.len() == given.len()
            && numbers.is_sorted()
            && numbers.first().is_some_and(|&first| first > 1)
    })
}

fn path_of(text: &str, line: u32) -> Result<Path, Fault> {
    match parse::expression(text, line)? {
        Expr::Variable(path) => Ok(path),
        _ => Err(Fault::new(line, format!("'{text}' is no name"))),
    }
}

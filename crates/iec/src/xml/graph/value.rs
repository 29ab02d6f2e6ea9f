//! What an output of a drawing's element is worth where it is asked for.

use super::pins::{is_instance, result};
use super::rank::order;
use super::{Graph, called, is_called, wrong};
use crate::ast::{Argument, Expr, Kind, Path, Statement, visit};
use crate::fault::Fault;
use crate::parse;
use crate::xml::node::{child, inputs, is};
use crate::xml::reading::Reading;
use roxmltree::Node;
use scanbound_base::code::Code;
use std::collections::BTreeSet;

/// How deep ways may be followed.
pub(super) const DEPTH: usize = 150;

/// How many elements may be looked at for one expression that looks at some of them more than once.
const VISITS: usize = 5_000;

/// What an output has been worked out as.
#[derive(Clone)]
pub(super) struct Kept {
    pub(super) value: Expr,
    /// Where it was stored: what was stored, and how many statements had been carried out then.
    stored: Option<(Expr, usize)>,
}

impl<'a, 'i> Graph<'a, 'i> {
    /// The value that leads in through connections, for one coil, output or pin: generators write an expression for each of
    /// these, in which contacts are looked at anew.
    pub(super) fn used(
        &mut self,
        reading: &mut Reading<'_, '_>,
        node: Node<'_, '_>,
        from: &[(&str, Option<&str>)],
    ) -> Result<Expr, Fault> {
        let outer = std::mem::take(&mut self.looked_at);
        let (once, visits) = (self.is_written_once, self.visits);
        (self.is_written_once, self.visits) = (self.is_written_once(from), 0);
        let value = self.joined(reading, node, from);
        self.looked_at = outer;
        (self.is_written_once, self.visits) = (once, visits);
        value
    }

    /// The value that leads in through connections.
    fn joined(
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
        if let Some(value) = self.looked_at.get(&key).filter(|_| self.is_written_once) {
            return Ok(value.clone());
        }
        let node = self.nodes[id];
        self.visits += 1;
        if self.visits > VISITS && !self.is_written_once {
            let message = format!("{}: ways through it fork and join too often", called(node));
            let help = "put a coil in between, and use its variable";
            return Err(self.text.fault(node, message).code(Code::NotModelled).help(help));
        }
        if self.is_fed_back(id, node) {
            return self.fed_back(reading, id, node, output);
        }
        for first in self.loops.first(id, &self.open, &self.done) {
            let node = self.nodes[first];
            let comes_later = order(node).zip(self.acting).is_some_and(|(own, at)| own > at);
            if !comes_later {
                self.block(reading, first, node)?;
            }
        }
        if self.depth >= DEPTH {
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
        self.depth += 1;
        let found = self.put_out(reading, id, node, output);
        self.depth -= 1;
        self.open.remove(id);
        let found = found?;
        // What a contact lets through is settled when it is looked at; a variable that is wired up is read where it is used.
        let is_plain = match found {
            Expr::Literal(_) => true,
            Expr::Variable(_) => !matches!(node.tag_name().name(), "contact" | "coil"),
            _ => false,
        };
        let value = match self.kept.get(&key).cloned() {
            _ if is_plain => found,
            // Some controllers look at it again, and others do not.
            Some(kept) if self.has_changed(&kept) => self.either(kept.value, found),
            _ => found,
        };
        if is_plain || self.forks.get(id).is_none_or(|&count| count < 2) {
            self.looked_at.insert(key, value.clone());
            return Ok(value);
        }
        let stored = self.store(reading, node, key.clone(), value);
        self.looked_at.insert(key, stored.clone());
        Ok(stored)
    }

    /// Stores a value, since what it is made of may change before it is asked for again.
    pub(super) fn store(
        &mut self,
        reading: &mut Reading<'_, '_>,
        node: Node<'_, '_>,
        key: (&'a str, String),
        value: Expr,
    ) -> Expr {
        let name = self.name_of(format!("v{}_{}", key.0, key.1));
        let name = reading.hidden(&name, "", 0);
        let path = Path::name(name.clone());
        self.add(node, Kind::Assign(path.clone(), value.clone()));
        let stored = Expr::Variable(path);
        let kept = Kept { value: stored.clone(), stored: Some((value, self.statements.len())) };
        self.named.insert(name, kept.clone());
        self.kept.entry(key).or_insert(kept);
        stored
    }

    /// The name of what is kept once more, with a sign that no output's name has.
    fn name_of(&mut self, what: String) -> String {
        let times = self.times.entry(what.clone()).or_insert(0);
        *times += 1;
        match times {
            1 => what,
            times => format!("{what}~{times}"),
        }
    }

    /// One of two values. Beyond so many of these it is any value, since each makes the expression larger.
    fn either(&mut self, one: Expr, other: Expr) -> Expr {
        if one == other {
            return one;
        }
        self.eithers += 1;
        if self.eithers > PLACES {
            return Expr::any();
        }
        Expr::either(one, other)
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
        let read = self.places.read(value);
        if self.foreign.iter().any(|at| *at >= since) && !read.is_empty() {
            return true;
        }
        let reads = |name: &str| read.iter().any(|own| self.places.are_one(own, name));
        let handed = self.handed.iter().filter(|(at, _)| *at >= since);
        let mut found = handed.into_iter().any(|(_, name)| reads(name));
        visit(&self.statements[since..], &mut |one| match &one.kind {
            Kind::Assign(target, _)
            | Kind::Refer(target, _)
            | Kind::Latch(target, ..)
            | Kind::Call(target, _)
            | Kind::CallIf(_, target, _) => {
                // What has a name of its own here is written once.
                found |= !target.first.starts_with('~') && self.places.names(target).any(reads);
            }
            _ => {}
        });
        found
    }

    /// Whether an output is that of a block that is not carried out before it is asked for: a way leads back to it, or its
    /// number of execution is a later one. It holds what the scan before left in it.
    fn is_fed_back(&self, id: &str, node: Node<'_, '_>) -> bool {
        if !is_called(node, "block") {
            return false;
        }
        let later = order(node).zip(self.acting).is_some_and(|(own, acting)| own > acting);
        let later = later && (is_instance(node) || self.loops.holds(id));
        let is_done = self.done.contains(id);
        self.open.contains(id) || (!is_done && (later || self.loops.is_behind(id, &self.open)))
    }

    /// What the scan before left at an output. The results of functions become variables of the unit for that, as generators
    /// declare them.
    fn fed_back(
        &mut self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'a, 'i>,
        output: &str,
    ) -> Result<Expr, Fault> {
        if !is_instance(node) {
            self.declare(reading, id, node, output)?;
            if output.eq_ignore_ascii_case("ENO") {
                return Ok(Expr::name(format!("{}_ENO", result(reading, id))));
            }
        }
        Ok(self.block_output(reading, id, node, output))
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
            // What stands behind a coil has what leads to it, as it was before the coil was written, or is looked at again.
            // Generators carry the coil out in its own place, and join what leads to it by AND.
            "coil" => {
                if !self.generated {
                    self.act(reading, id)?;
                }
                let from = inputs(node);
                let any = self.joined(reading, node, &from)?;
                if !self.generated || from.len() < 2 {
                    return Ok(any);
                }
                self.joins_all = true;
                let mut all = Expr::bool(true);
                for one in &from {
                    all = all.and(self.joined(reading, node, std::slice::from_ref(one))?);
                }
                Ok(self.either(any, all))
            }
            "rightPowerRail" | "connector" => self.joined(reading, node, &inputs(node)),
            "inVariable" | "inOutVariable" => {
                // What leads into it is written before it is read; by generators in its own place.
                if !inputs(node).is_empty() && !self.generated {
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
            "block" => {
                if !self.done.contains(id) {
                    self.comes_in_time(node)?;
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

    /// Refuses a block that what takes its result is carried out before, by their numbers.
    fn comes_in_time(&self, node: Node<'_, '_>) -> Result<(), Fault> {
        let Some(acting) = self.acting else { return Ok(()) };
        let why = match order(node) {
            Some(own) if own > acting => "is carried out before it, by their numbers",
            Some(_) => return Ok(()),
            None => {
                "has an executionOrderId, and it has none: which of them comes first is not clear"
            }
        };
        let message = format!("{}: what takes its result {why}", called(node));
        let help = "number it before what takes its result";
        Err(self.text.fault(node, message).code(Code::NotModelled).help(help))
    }

    pub(super) fn operand(&self, node: Node<'_, '_>, name: &'static str) -> Result<Expr, Fault> {
        let Some(written) = child(node, name) else {
            return Err(self.text.fault(node, format!("{}: it names no variable", called(node))));
        };
        let (text, line) = self.text.content(written);
        if text.trim().is_empty() {
            return Err(self.text.fault(node, format!("{}: it names no variable", called(node))));
        }
        parse::expression(&text, line)
    }

    /// Whether there is an edge. Generators make an instance for each place that asks for it; others have one for all. They
    /// show the same as long as all of them see the same.
    pub(super) fn edge(
        &mut self,
        reading: &mut Reading<'_, '_>,
        node: Node<'_, '_>,
        id: &str,
        edge: &str,
        value: Expr,
    ) -> Expr {
        self.edge_where(reading, node, id, edge, value, Expr::bool(true))
    }

    /// The same of an edge that is looked at under a condition.
    pub(super) fn edge_where(
        &mut self,
        reading: &mut Reading<'_, '_>,
        node: Node<'_, '_>,
        id: &str,
        edge: &str,
        value: Expr,
        looked_at: Expr,
    ) -> Expr {
        let of = if edge == "falling" { "F_TRIG" } else { "R_TRIG" };
        let name = self.name_of(format!("e{id}"));
        let name = reading.hidden(&name, of, self.text.line(node));
        let clock =
            Argument { name: Some("CLK".to_owned()), is_output: false, value: value.clone() };
        self.add(node, Kind::CallIf(looked_at, Path::name(name.clone()), vec![clock]));
        let shows = |name: &str| Expr::Variable(Path::name(name).with("Q"));
        let Some(kept) = self.edges.get(id).cloned() else {
            let kept = Kept { value: shows(&name), stored: Some((value, self.statements.len())) };
            self.named.insert(name, kept.clone());
            let first = kept.value.clone();
            self.edges.insert(id.to_owned(), kept);
            return first;
        };
        match self.jumps || self.has_changed(&kept) {
            true => self.either(kept.value, shows(&name)),
            false => kept.value,
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
pub(super) fn put_in(one: &mut Expr, name: &Path, value: &Expr) -> Option<usize> {
    let times = match one {
        Expr::Variable(path) if path == name => {
            *one = value.clone();
            1
        }
        other => {
            let put = |sum, one: &mut Expr| Some(sum + put_in(one, name, value)?);
            other.operands_mut().into_iter().try_fold(0, put)?
        }
    };
    (times < PLACES).then_some(times)
}

/// The names of what an expression reads that is kept.
fn names(one: &Expr) -> Vec<&str> {
    match one {
        Expr::Variable(path) if path.first.starts_with('~') => vec![&path.first],
        other => other.operands().into_iter().flat_map(names).collect(),
    }
}

/// Whether an expression calls anything.
pub(super) fn calls(one: &Expr) -> bool {
    matches!(one, Expr::Call(..) | Expr::Either(_)) || one.operands().into_iter().any(calls)
}

impl Graph<'_, '_> {
    pub(super) fn add(&mut self, node: Node<'_, '_>, kind: Kind) {
        let line = self.text.line(node);
        self.carried(Statement { line, kind });
    }

    /// A statement of the element that is carried out.
    pub(super) fn carried(&mut self, statement: Statement) {
        self.statements.push(statement);
        self.owners.push(self.owner);
    }
}

//! The types of results that generators declare variables for.

use super::pins::{is_instance, name_of, pins, result};
use super::{Graph, called};
use crate::ast::{Expr, Literal, Part, Path};
use crate::fault::Fault;
use crate::xml::interface::type_ref;
use crate::xml::node::{child, children, elements, inputs, sources};
use crate::xml::reading::Reading;
use crate::{PouKind, TypeRef, same};
use roxmltree::Node;
use scanbound_base::code::Code;
use std::collections::BTreeSet;

fn named(name: &str) -> Option<TypeRef> {
    Some(TypeRef::Named(name.to_owned()))
}

/// The type of a variable of this name in an element's lists of variables.
fn declared(text: &crate::xml::node::Text, within: Node<'_, '_>, name: &str) -> Option<TypeRef> {
    let all = within.descendants().filter(|one| one.tag_name().name() == "variable");
    let mut own = all.filter(|one| one.attribute("name").is_some_and(|own| same(own, name)));
    own.find_map(|one| child(one, "type")).map(|of| type_ref(text, of))
}

impl<'a, 'i> Graph<'a, 'i> {
    /// Declares the variable of a function's result that is asked for before the function is carried out.
    pub(super) fn declare(
        &self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'a, 'i>,
        output: &str,
    ) -> Result<(), Fault> {
        let is_enable = output.eq_ignore_ascii_case("ENO");
        let first = self.outputs(node).first().cloned().unwrap_or_default();
        let output = if output.is_empty() { first.clone() } else { output.to_owned() };
        let known = self.kind(reading, id, &output, &mut BTreeSet::new());
        let is_own = match is_enable {
            true => self.gives_enable(node),
            false => self.outputs(node).contains(&output),
        };
        let Some(of) = known.filter(|_| is_own) else {
            let message = format!(
                "{}: its result is taken before it is worked out, and its type is not known",
                called(node)
            );
            let help = "write the result to a variable, and read that instead";
            return Err(self.text.fault(node, message).code(Code::NotModelled).help(help));
        };
        let own = result(reading, id);
        let name = if output == first && !is_enable { own } else { format!("{own}_{output}") };
        reading.declare(&name, of, self.text.line(node));
        Ok(())
    }

    /// In a function, generators declare a variable for each result, which begins anew with each call.
    pub(super) fn begins_anew(
        &self,
        reading: &mut Reading<'_, '_>,
        id: &'a str,
        node: Node<'a, 'i>,
    ) {
        if reading.pou.kind != PouKind::Function || self.text.is_codesys {
            return;
        }
        let has_enable = pins(node, "outputVariables").any(|pin| same(name_of(pin), "ENO"));
        let enable = has_enable.then(|| "ENO".to_owned());
        for output in self.outputs(node).into_iter().chain(enable) {
            let of = self.kind(reading, id, &output, &mut BTreeSet::new());
            let of = of.unwrap_or_else(|| TypeRef::Named("BOOL".to_owned()));
            reading.declare(&format!("~begun {id}_{output}"), of, self.text.line(node));
        }
    }

    /// The type of an output, if it is known.
    fn kind(
        &self,
        reading: &Reading<'_, '_>,
        id: &str,
        output: &str,
        seen: &mut BTreeSet<String>,
    ) -> Option<TypeRef> {
        let node = *self.nodes.get(id)?;
        if output.eq_ignore_ascii_case("ENO") {
            return named("BOOL");
        }
        if !seen.insert(format!("{id} {output}")) {
            return None;
        }
        match node.tag_name().name() {
            "contact" | "coil" | "leftPowerRail" | "rightPowerRail" => named("BOOL"),
            "inVariable" | "inOutVariable" => {
                let value = self.operand(node, "expression").ok()?;
                self.kind_of(reading, &value)
            }
            "outVariable" | "connector" => {
                let from = inputs(node);
                from.iter().find_map(|(id, output)| {
                    self.kind(reading, id, output.unwrap_or_default(), seen)
                })
            }
            "continuation" => {
                let name = node.attribute("name");
                let from = self.nodes.iter().find(|(_, one)| {
                    one.tag_name().name() == "connector" && one.attribute("name") == name
                });
                self.kind(reading, from?.0, "", seen)
            }
            "block" if is_instance(node) => {
                self.part_of(node.attribute("typeName").unwrap_or_default(), node, output)
            }
            "block" => self
                .kind_of_function(reading, node, seen)
                .or_else(|| self.kind_of_target(reading, id, output)),
            _ => None,
        }
    }

    /// The type of a variable that an output is written to.
    fn kind_of_target(&self, reading: &Reading<'_, '_>, id: &str, output: &str) -> Option<TypeRef> {
        let mut ends = self.nodes.values().filter(|one| one.tag_name().name() == "outVariable");
        ends.find_map(|&end| {
            let from = inputs(end);
            let is_it = |(own, of): &(&str, Option<&str>)| {
                *own == id && of.is_none_or(|of| of.eq_ignore_ascii_case(output))
            };
            from.iter().find(|one| is_it(one))?;
            self.kind_of(reading, &self.operand(end, "expression").ok()?)
        })
    }

    fn kind_of_function(
        &self,
        reading: &Reading<'_, '_>,
        node: Node<'_, '_>,
        seen: &mut BTreeSet<String>,
    ) -> Option<TypeRef> {
        let name = node.attribute("typeName").unwrap_or_default().to_ascii_uppercase();
        if let Some(own) = self.unit(node, &name) {
            let result = child(child(own, "interface")?, "returnType")?;
            return Some(type_ref(self.text, result));
        }
        if ["GT", "GE", "EQ", "NE", "LE", "LT", ">", ">=", "=", "<>", "<=", "<"]
            .contains(&name.as_str())
        {
            return named("BOOL");
        }
        if let Some((_, to)) = name.split_once("_TO_") {
            return named(to);
        }
        if ![
            "ADD", "SUB", "MUL", "DIV", "MOD", "MOVE", "AND", "OR", "XOR", "NOT", "SEL", "MUX",
            "MIN", "MAX", "LIMIT", "ABS", "SHL", "SHR", "ROL", "ROR",
        ]
        .contains(&name.as_str())
        {
            return None;
        }
        let mut found: Option<TypeRef> = None;
        for pin in pins(node, "inputVariables") {
            let own = name_of(pin);
            let is_other =
                ["EN", "G", "K", "N"].iter().any(|other| own.eq_ignore_ascii_case(other));
            let point = children(pin, "connectionPointIn");
            let from: Vec<_> = point.flat_map(sources).collect();
            for (id, output) in from.into_iter().filter(|_| !is_other) {
                let Some(of) = self.kind(reading, id, output.unwrap_or_default(), seen) else {
                    continue;
                };
                match &found {
                    Some(known) if *known != of => return None,
                    _ => found = Some(of),
                }
            }
        }
        found
    }

    /// The type of an input or output of an instance of this type.
    fn part_of(&self, of: &str, near: Node<'_, '_>, part: &str) -> Option<TypeRef> {
        if let Some(own) = self.unit(near, of) {
            return declared(self.text, child(own, "interface")?, part);
        }
        let standard = ["TON", "TOF", "TP", "CTU", "CTD", "CTUD", "R_TRIG", "F_TRIG", "SR", "RS"];
        if !standard.iter().any(|own| same(own, of)) {
            return None;
        }
        match part.to_ascii_uppercase().as_str() {
            "Q" | "Q1" | "QU" | "QD" => named("BOOL"),
            "ET" => named("TIME"),
            "CV" => named("INT"),
            _ => None,
        }
    }

    /// A unit of the file.
    fn unit<'x, 'y>(&self, near: Node<'x, 'y>, name: &str) -> Option<Node<'x, 'y>> {
        let all = near.document().descendants().filter(|one| one.tag_name().name() == "pou");
        { all }.find(|one| one.attribute("name").is_some_and(|own| same(own, name)))
    }

    fn kind_of(&self, reading: &Reading<'_, '_>, value: &Expr) -> Option<TypeRef> {
        match value {
            Expr::Literal(Literal::Bool(_)) => named("BOOL"),
            Expr::Literal(Literal::Time(_)) => named("TIME"),
            Expr::Literal(Literal::Int(_, Some(of)) | Literal::Real(_, Some(of))) => named(of),
            Expr::Not(inner) | Expr::Negate(inner) => self.kind_of(reading, inner),
            Expr::Variable(path) => self.kind_of_path(reading, path),
            _ => None,
        }
    }

    fn kind_of_path(&self, reading: &Reading<'_, '_>, path: &Path) -> Option<TypeRef> {
        let near = *self.nodes.values().next()?;
        if path.first.starts_with('%') {
            let size = path.first.get(2..3)?.to_ascii_uppercase();
            let of = match size.as_str() {
                "B" => "BYTE",
                "W" => "WORD",
                "D" => "DWORD",
                "L" => "LWORD",
                _ => "BOOL",
            };
            return named(of);
        }
        let mut own = reading.pou.variables.iter().filter(|own| same(&own.name, &path.first));
        let global = || {
            let lists = near.document().descendants();
            let lists = lists.filter(|one| one.tag_name().name() == "globalVars");
            lists
                .filter(|list| elements(*list).next().is_some())
                .find_map(|list| declared(self.text, list, &path.first))
        };
        let of = own.next().map(|own| own.of.clone()).or_else(global)?;
        match (&path.rest[..], of) {
            ([], of) => Some(of),
            ([Part::Bit(_)], _) => named("BOOL"),
            ([Part::Name(part)], TypeRef::Named(of)) => self.part_of(&of, near, part),
            ([Part::Index(_)], TypeRef::Array(_, of)) => Some(*of),
            _ => None,
        }
    }
}

//! Rejects properties of elements that are not supported: ignoring them could make the bound too low.

use super::node::{Text, child, children, elements, has_place, is, order};
use crate::fault::Fault;
use roxmltree::Node;
use scanbound_base::code::Code;

/// Elements that may have the attribute `negated`.
const NEGATED: &[&str] = &["contact", "coil", "inVariable", "outVariable", "jump", "return"];

/// Attributes that are not supported in any element.
const SIGNS: &[&str] = &["edgeIn", "edgeOut", "storageIn", "storageOut"];

/// Rejects an element with an unsupported or malformed attribute, position, pin or connection.
pub(super) fn checked(text: &Text, node: Node<'_, '_>) -> Result<(), Fault> {
    let name = node.tag_name().name();
    let called = format!("{name} with localId {}", node.attribute("localId").unwrap_or("?"));
    let refused = |what: String| {
        let help = "draw it with elements of its own: a contact, a block, a coil";
        Err(text.fault(node, format!("{called}: {what}")).help(help))
    };
    let order_is_told = node.attribute("executionOrderId").is_some_and(|told| told.trim() != "0");
    if order_is_told && order(node).is_none() {
        return refused("its executionOrderId is not a number".to_owned());
    }
    if !has_place(node) {
        return refused("its position is not a pair of numbers".to_owned());
    }
    if name == "actionBlock" && !matches!(node.attribute("negated"), None | Some("false" | "0")) {
        return refused("a negated block of actions is not followed".to_owned());
    }
    let pins = ["inputVariables", "inOutVariables", "outputVariables"];
    let lists = pins.iter().filter_map(|list| child(node, list));
    let has_way =
        children(node, "connectionPointIn").any(|point| child(point, "connection").is_some());
    if ["jump", "return"].contains(&name) && !has_way {
        return refused("nothing is connected to it".to_owned());
    }
    for one in std::iter::once(node).chain(lists.flat_map(|list| children(list, "variable"))) {
        let is_pin = one != node;
        let is_output =
            one.parent().is_some_and(|list| list.tag_name().name() == "outputVariables");
        match one.attribute("edge") {
            None | Some("none") => {}
            Some("rising" | "falling") if is_pin && !is_output => {}
            Some("rising" | "falling") if ["contact", "coil", "outVariable"].contains(&name) => {}
            Some(edge) => return refused(format!("edge=\"{edge}\" is not followed here")),
        }
        match one.attribute("storage") {
            None | Some("none") => {}
            Some("set" | "reset") if !is_pin && ["coil", "outVariable"].contains(&name) => {}
            Some(storage) => return refused(format!("storage=\"{storage}\" is not followed here")),
        }
        let is_eno =
            one.attribute("formalParameter").is_some_and(|name| name.eq_ignore_ascii_case("ENO"));
        if is_output && is_eno && is(one, "negated") {
            return refused("a negated ENO is not followed".to_owned());
        }
        for attribute in ["negated", "negatedIn", "negatedOut"] {
            if !matches!(one.attribute(attribute), None | Some("true" | "false" | "1" | "0")) {
                return refused(format!("{attribute} is neither true nor false"));
            }
            let is_followed = match (attribute, is_pin) {
                ("negated", is_pin) => is_pin || NEGATED.contains(&name),
                (_, is_pin) => !is_pin && name == "inOutVariable",
            };
            if is(one, attribute) && !is_followed {
                return refused(format!("{attribute} is not followed here"));
            }
        }
        let sign = SIGNS.iter().find(|sign| !matches!(one.attribute(**sign), None | Some("none")));
        if let Some(sign) = sign {
            return refused(format!("{sign} is not followed"));
        }
    }
    for list in pins.iter().filter_map(|list| child(node, list)) {
        let names = children(list, "variable").filter_map(|one| one.attribute("formalParameter"));
        let mut names: Vec<String> =
            names.map(str::to_lowercase).filter(|name| !name.is_empty()).collect();
        names.sort();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return refused(format!("it has two pins {}", twice[0]));
        }
    }
    let is_point = |one: &Node<'_, '_>| {
        ["connectionPointIn", "connectionPointOut"].contains(&one.tag_name().name())
    };
    for point in node.descendants().filter(is_point) {
        // At pins of blocks (other than VAR_IN_OUT), a written expression is supported.
        let list = point.parent().and_then(|pin| pin.parent()).map(|list| list.tag_name().name());
        let is_followed = name == "block"
            && match point.tag_name().name() {
                "connectionPointIn" => list == Some("inputVariables"),
                _ => list == Some("outputVariables"),
            };
        if text.written(point).is_some() && (!is_followed || child(point, "connection").is_some()) {
            return refused("an expression in place of a connection is not followed".to_owned());
        }
        if point.tag_name().name() == "connectionPointOut" && child(point, "connection").is_some() {
            return refused("a connection that leads to an output is not followed".to_owned());
        }
        if children(point, "connection").any(|one| one.attribute("refLocalId").is_none()) {
            return Err(text
                .fault(node, format!("{called}: a connection has no refLocalId"))
                .code(Code::Connection));
        }
    }
    Ok(())
}

/// Rejects an element with several bodies, because it is unknown which of them is executed.
pub(super) fn single(text: &Text, node: Node<'_, '_>) -> Result<(), Fault> {
    let languages = ["ST", "IL", "LD", "FBD", "SFC"];
    let is_body = |one: &Node<'_, '_>| languages.contains(&one.tag_name().name());
    if elements(node).filter(is_body).count() > 1 {
        let message = "it has bodies in several languages: which one is executed is not clear";
        return Err(text.fault(node, message).help("leave one of them"));
    }
    Ok(())
}

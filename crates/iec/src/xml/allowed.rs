//! Lists the elements that each element of a unit may contain. Anything else might be executed by a controller, so it
//! is reported with its place.
//!
//! `docs/sfc.md` lists the skipped elements and why they are harmless.

use super::node::{Text, elements};
use crate::comment::is_harmless_attribute;
use crate::fault::Fault;
use roxmltree::Node;
use scanbound_base::code::Code;
use std::collections::BTreeSet;

/// Each element with the elements that it may contain. A name `parent/element` applies only within that parent.
const FORMS: &[(&str, &str)] = &[
    ("pou", "interface actions transitions body addData documentation InterfaceAsPlainText"),
    ("Method", "interface body addData documentation InterfaceAsPlainText"),
    ("method", "interface body addData documentation InterfaceAsPlainText"),
    ("Property", "interface GetAccessor SetAccessor addData documentation InterfaceAsPlainText"),
    ("property", "interface GetAccessor SetAccessor addData documentation InterfaceAsPlainText"),
    ("GetAccessor", "interface body addData documentation InterfaceAsPlainText"),
    ("SetAccessor", "interface body addData documentation InterfaceAsPlainText"),
    (
        "interface",
        "returnType localVars tempVars inputVars outputVars inOutVars externalVars globalVars accessVars addData documentation InterfaceAsPlainText",
    ),
    ("actions", "action"),
    ("actions/action", "body addData documentation"),
    ("transitions", "transition"),
    ("transitions/transition", "body addData documentation"),
    ("body", "ST IL LD FBD SFC addData documentation"),
    ("inline", "ST IL LD FBD SFC addData documentation"),
    ("LD", NETWORK),
    ("FBD", NETWORK),
    ("SFC", CHART),
    ("leftPowerRail", "position connectionPointOut addData documentation"),
    ("rightPowerRail", "position connectionPointIn addData documentation"),
    ("contact", "position connectionPointIn connectionPointOut variable addData documentation"),
    ("coil", "position connectionPointIn connectionPointOut variable addData documentation"),
    ("inVariable", "position connectionPointOut expression addData documentation"),
    ("outVariable", "position connectionPointIn expression addData documentation"),
    (
        "inOutVariable",
        "position connectionPointIn connectionPointOut expression addData documentation",
    ),
    ("connector", "position connectionPointIn addData documentation"),
    ("continuation", "position connectionPointOut addData documentation"),
    ("label", "position addData documentation"),
    ("jump", "position connectionPointIn addData documentation"),
    ("return", "position connectionPointIn addData documentation"),
    ("block", "position inputVariables inOutVariables outputVariables addData documentation"),
    ("inputVariables", "variable"),
    ("inOutVariables", "variable"),
    ("outputVariables", "variable"),
    ("variable", "connectionPointIn connectionPointOut addData documentation"),
    ("connectionPointIn", "relPosition connection expression addData documentation"),
    ("connectionPointOut", "relPosition connection expression addData documentation"),
    ("connectionPointOutAction", "relPosition connection expression addData documentation"),
    ("connection", "position addData documentation"),
    (
        "step",
        "position connectionPointIn connectionPointOut connectionPointOutAction addData documentation",
    ),
    (
        "macroStep",
        "position connectionPointIn connectionPointOut connectionPointOutAction body addData documentation",
    ),
    ("transition", "position connectionPointIn connectionPointOut condition addData documentation"),
    ("condition", "inline reference connectionPointIn connection addData documentation"),
    ("jumpStep", "position connectionPointIn addData documentation"),
    ("actionBlock", "position connectionPointIn connectionPointOut action addData documentation"),
    (
        "action",
        "relPosition reference inline connectionPointIn connectionPointOut addData documentation",
    ),
    ("selectionDivergence", BAR),
    ("selectionConvergence", BAR),
    ("simultaneousDivergence", BAR),
    ("simultaneousConvergence", BAR),
    ("vendorElement", "position alternativeText addData documentation"),
    ("addData", "data"),
    ("reference", ""),
    ("ST", TEXT),
    ("IL", TEXT),
    ("STCode", TEXT),
    ("expression", TEXT),
    ("contact/variable", TEXT),
    ("coil/variable", TEXT),
    ("InterfaceAsPlainText", TEXT),
    ("br", ""),
];

const NETWORK: &str = "comment vendorElement leftPowerRail rightPowerRail contact coil inVariable outVariable inOutVariable connector continuation label jump return block addData documentation position";
const CHART: &str = "comment vendorElement leftPowerRail rightPowerRail contact coil inVariable outVariable inOutVariable connector continuation label jump return block step macroStep transition jumpStep actionBlock selectionDivergence selectionConvergence simultaneousDivergence simultaneousConvergence addData documentation position";
const BAR: &str = "position connectionPointIn connectionPointOut addData documentation";
const TEXT: &str = "xhtml html body p div pre span br b i u em strong font code tt";

/// Elements that do not affect execution: positions, comments and documentation. Interfaces are checked elsewhere.
const UNFOLLOWED: &[&str] =
    &["position", "relPosition", "documentation", "comment", "alternativeText"];

/// Elements that may occur more than once in an element.
const SEVERAL: &[&str] = &[
    "action",
    "transition",
    "variable",
    "connectionPointIn",
    "connectionPointOut",
    "connection",
    "documentation",
    "data",
    "position",
    "localVars",
    "tempVars",
    "inputVars",
    "outputVars",
    "inOutVars",
    "externalVars",
    "globalVars",
    "accessVars",
    "returnType",
];

/// Elements that contain the elements of a drawing.
const DRAWINGS: &[&str] = &["LD", "FBD", "SFC"];

/// Additional data that is read, by name without the vendor's prefix.
const READ: &[&str] =
    &["method", "property", "sfc/element", "stcode", "interfaceasplaintext", "pouinheritance"];

/// Additional data that does not affect execution: object numbers, visibility, types of pins, display of boxes,
/// compiler settings.
const HARMLESS: &[&str] = &[
    "objectid",
    "attributes",
    "accessmodifiers",
    "sfcsettings",
    "buildproperties",
    "fbdcalltype",
    "fbdelementtype",
    "inputparamtypes",
    "outputparamtypes",
    "inputassignments",
    "mixedattrsvarlist",
];

/// The vendors' prefixes of names of additional data.
const NAMESPACES: &[&str] =
    &["http://www.3s-software.com/plcopenxml/", "http://openplc.org/plcopenxml/"];

/// The name of additional data without the vendor's prefix; `None` for other vendors.
pub(super) fn data_name<'a>(data: Node<'a, '_>) -> Option<&'a str> {
    let name = data.attribute("name")?;
    NAMESPACES.iter().find_map(|own| name.strip_prefix(own))
}

/// The fault of additional data with an attribute that may affect execution or variables; `None` if all are known to be
/// harmless.
pub(super) fn attribute(text: &Text, data: Node<'_, '_>) -> Option<Fault> {
    let is_one = |node: &Node<'_, '_>| node.tag_name().name().eq_ignore_ascii_case("attribute");
    let name = |node: Node<'_, '_>| {
        ["Name", "name"].into_iter().find_map(|own| node.attribute(own).map(str::to_owned))
    };
    let mut all = data.descendants().filter(is_one);
    let found = all.find(|node| !name(*node).is_some_and(|name| is_harmless_attribute(&name)))?;
    let told = format!(
        "whether the attribute {} changes execution or the values of variables is not known",
        name(found).unwrap_or_default()
    );
    let help = "take it out of a copy of the file if it changes neither";
    Some(text.fault(found, told).code(Code::Pragma).help(help))
}

/// The faults of everything in a unit that is not read and that a controller may execute.
pub(super) fn unread(text: &Text, unit: Node<'_, '_>) -> Vec<Fault> {
    let mut found = Vec::new();
    let mut open = vec![unit];
    while let Some(node) = open.pop() {
        let name = node.tag_name().name();
        if UNFOLLOWED.contains(&name) {
            continue;
        }
        if name == "data" {
            open.extend(data(text, node, &mut found));
            continue;
        }
        if name == "vendorElement" && !is_title(node) {
            let message = format!("{}: this element is not read", called(node));
            found.push(text.fault(node, message).help(HELP));
            continue;
        }
        if let Some(message) = missing(unit, node) {
            let help = "write its code in ST, IL, LD, FBD or SFC, or give it an empty ST";
            found.push(text.fault(node, message).help(help));
        }
        let Some(form) = form(node) else { continue };
        let is_text = form == TEXT || form.is_empty();
        let stray = node
            .children()
            .find(|one| one.is_text() && one.text().is_some_and(|text| !text.trim().is_empty()));
        if let Some(stray) = stray.filter(|_| !is_text) {
            let message = format!("{}: it contains text that is not read", called(node));
            found.push(Fault { line: text.line(stray), ..text.fault(node, message).help(HELP) });
        }
        let mut seen = BTreeSet::new();
        for inner in elements(node) {
            let own = inner.tag_name().name();
            if !form.split(' ').any(|one| one == own) && !is_loose(inner) {
                let message = format!("{}: it contains <{own}>, which is not read", called(node));
                found.push(text.fault(inner, message).help(HELP));
                continue;
            }
            let is_drawn = DRAWINGS.contains(&name);
            if !is_text && !is_drawn && !SEVERAL.contains(&own) && !seen.insert(own) {
                let message =
                    format!("{}: it has <{own}> twice, and only one is read", called(node));
                found.push(text.fault(inner, message).help("leave one of them"));
                continue;
            }
            if name != "interface" || own == "addData" {
                open.push(inner);
            }
        }
    }
    found.sort_by_key(|fault| fault.line);
    found
}

/// The fault of an element without required contents: a controller might execute what is missing in the file. `None` if
/// nothing is missing.
fn missing(unit: Node<'_, '_>, node: Node<'_, '_>) -> Option<String> {
    let has = |names: &[&str]| elements(node).any(|inner| names.contains(&inner.tag_name().name()));
    let parent = node.parent().map_or("", |parent| parent.tag_name().name());
    match node.tag_name().name() {
        // Functions and function blocks without code are reported where they are called.
        "body"
            if parent != "macroStep" && node.parent() != Some(unit) || is_program(unit, node) =>
        {
            let languages = ["ST", "IL", "LD", "FBD", "SFC", "addData", "CFC"];
            (!has(&languages)).then(|| "its body holds no code".to_owned())
        }
        "Method" | "method" | "GetAccessor" | "SetAccessor"
            if !unit.tag_name().name().eq_ignore_ascii_case("interface") && !has(&["body"]) =>
        {
            Some(format!("{}: it has no body", called(node)))
        }
        "action" if parent == "actions" && !has(&["body"]) => {
            Some(format!("{}: it has no body", called(node)))
        }
        "action"
            if parent == "actionBlock" && !has(&["reference", "inline", "connectionPointIn"]) =>
        {
            Some(format!("{}: it names no action", called(node)))
        }
        "inline" if parent == "action" && !has(&["ST", "IL", "LD", "FBD", "SFC", "addData"]) => {
            Some("an action block holds no code".to_owned())
        }
        "actionBlock"
            if !elements(node).any(|point| {
                point.tag_name().name() == "connectionPointIn"
                    && elements(point).any(|one| one.tag_name().name() == "connection")
            }) =>
        {
            Some(format!("{}: no step is connected to it", called(node)))
        }
        "pou" if node.attribute("pouType") == Some("program") && !has(&["body"]) => {
            Some("it has no body".to_owned())
        }
        _ => None,
    }
}

/// Whether a body is that of a program.
fn is_program(unit: Node<'_, '_>, body: Node<'_, '_>) -> bool {
    body.parent() == Some(unit) && unit.attribute("pouType") == Some("program")
}

const HELP: &str = "write what it does in ST, IL, LD, FBD or SFC, or take it out of the file if the controller executes none of it";

/// The elements that an element may contain, separated by blanks; `None` if it is not listed.
fn form(node: Node<'_, '_>) -> Option<&'static str> {
    let name = node.tag_name().name();
    let around = node.parent().map_or("", |parent| parent.tag_name().name());
    let within = format!("{around}/{name}");
    // In text, all elements of text may be nested.
    if TEXT.split(' ').any(|one| one == name) && form_is_text(node.parent()) {
        return Some(if name == "br" { "" } else { TEXT });
    }
    let found = FORMS.iter().find(|(own, _)| *own == within);
    found.or_else(|| FORMS.iter().find(|(own, _)| *own == name)).map(|(_, form)| *form)
}

fn form_is_text(node: Option<Node<'_, '_>>) -> bool {
    node.filter(Node::is_element).is_some_and(|node| form(node) == Some(TEXT))
}

/// Whether an element is a connection point without a connection.
fn is_loose(node: Node<'_, '_>) -> bool {
    ["connectionPointIn", "connectionPointOut"].contains(&node.tag_name().name())
        && elements(node).all(|one| one.tag_name().name() == "relPosition")
}

/// Whether a vendor's element is the title of a network, as in CODESYS and TwinCAT.
fn is_title(node: Node<'_, '_>) -> bool {
    let mut types = node.descendants().filter(|one| one.tag_name().name() == "ElementType");
    types.next().is_some_and(|one| one.text().is_some_and(|text| text.trim() == "networktitle"))
        && types.next().is_none()
}

/// Checks additional data; returns the elements in it that must be checked, too.
fn data<'a, 'i>(text: &Text, node: Node<'a, 'i>, found: &mut Vec<Fault>) -> Vec<Node<'a, 'i>> {
    let is_empty = !node.has_children();
    let owner = node.parent().and_then(|one| one.parent()).unwrap_or(node);
    let name = data_name(node).unwrap_or_default();
    let has_place = match name {
        "stcode" => owner.tag_name().name() == "block",
        "method" | "property" => ["pou", "Interface"].contains(&owner.tag_name().name()),
        _ => true,
    };
    if has_place && READ.contains(&name) {
        let all = elements(node);
        return all.filter(|one| form(*one).is_some()).collect();
    }
    if !is_empty && !HARMLESS.contains(&name) {
        let shown = node.attribute("name").unwrap_or_default();
        let message = format!("{}: its additional data \"{shown}\" are not read", called(owner));
        found.push(text.fault(node, message).help(HELP));
    }
    Vec::new()
}

/// The name of an element for messages.
fn called(node: Node<'_, '_>) -> String {
    let name = node.attribute("name").map(|name| format!(" {name}")).unwrap_or_default();
    let id = node.attribute("localId").map(|id| format!(" with localId {id}")).unwrap_or_default();
    format!("{}{name}{id}", node.tag_name().name())
}

//! Reads the project's tree: types, units, global variables, tasks.

use super::allowed::{attribute, data_name, unread};
use super::body::{body, condition_body};
use super::chart_settings;
use super::interface::{
    addresses, begins_with, extends, list_of, retain_mixed, type_ref, variables,
};
use super::node::{EXCLUDED, Text, added, child, children, elements};
use super::reading::Reading;
use crate::ast::Path;
use crate::chart::expansion::complete;
use crate::chart::{Block, COMPUTED, CONTROL_FLAGS, Qualifier, Target};
use crate::fault::Fault;
use crate::{
    Body, Named, Pou, PouKind, Project, Section, Task, TypeDeclaration, TypeRef, Variable, parse,
    same,
};
use roxmltree::Node;
use scanbound_base::code::Code;
use std::collections::BTreeSet;

/// The state while a project's tree is read.
pub(super) struct Reader<'t> {
    text: &'t Text,
    project: Project,
    faults: Vec<Fault>,
    /// The programs of which an instance has no name.
    unnamed: BTreeSet<String>,
}

impl<'t> Reader<'t> {
    pub(super) fn new(name: &str, text: &'t Text) -> Reader<'t> {
        let project = Project {
            files: vec![name.to_owned()],
            is_of_codesys: text.is_codesys,
            ..Project::default()
        };
        Reader { text, project, faults: Vec::new(), unnamed: BTreeSet::new() }
    }

    pub(super) fn finish(self) -> Result<Project, Vec<Fault>> {
        if self.faults.is_empty() { Ok(self.project) } else { Err(self.faults) }
    }

    /// Reads all declarations below an element, at any depth, because tools store units in different places.
    pub(super) fn project(&mut self, root: Node<'_, '_>) {
        for node in root.descendants().filter(Node::is_element) {
            match node.tag_name().name() {
                "data" if data_name(node) == Some("attributes") => {
                    let fault = attribute(self.text, node).map(|fault| (0, fault));
                    self.project.unread.extend(fault);
                }
                "SFCSettings" | "BuildProperties" | "attribute" => {
                    let fault = setting(self.text, node).map(|fault| (0, fault));
                    self.project.unread.extend(fault);
                }
                "pou" if node.attribute("pouType").is_some() => {
                    let pou = self.pou(node);
                    let unread = unread(self.text, node).into_iter();
                    let unread = unread.map(|fault| (0, fault.within(&pou.name)));
                    self.project.unread.extend(unread);
                    self.project.pous.push(pou);
                }
                "pou" if child(node, "body").is_some() => {
                    let fault = self.text.fault(node, "this unit has no pouType");
                    self.project.unread.push((0, fault));
                }
                "Interface" if node.attribute("name").is_some() => self.interface(node),
                "dataType" => self.data_type(node),
                "globalVars"
                    if !node.ancestors().any(|one| {
                        ["interface", "MixedAttrsVarList"].contains(&one.tag_name().name())
                    }) =>
                {
                    self.globals(node);
                }
                "task" => self.task(node),
                "pouInstance"
                    if node.parent().is_none_or(|one| one.tag_name().name() != "task") =>
                {
                    let instance = self.instance(node);
                    self.project.tasks.push(Task {
                        name: String::new(),
                        resource: resource(node),
                        interval: None,
                        priority: None,
                        instances: instance.into_iter().collect(),
                    });
                }
                _ => {}
            }
        }
    }

    fn data_type(&mut self, node: Node<'_, '_>) {
        let (Some(name), Some(base)) = (node.attribute("name"), child(node, "baseType")) else {
            return;
        };
        let of = type_ref(self.text, base);
        let bases = added(node).flat_map(|one| children(one, "Extends"));
        let extends = { bases }.find_map(|base| base.text()).map(last_name);
        let name = name.to_owned();
        let line = self.text.line(node);
        let initial = child(node, "initialValue").map(|value| begins_with(value, line));
        let own = TypeDeclaration { name, extends, of, initial, file: 0, line };
        self.project.types.push(own);
    }

    fn globals(&mut self, node: Node<'_, '_>) {
        let mut found = list_of(self.text, node, Section::Global);
        retain_mixed(node, &mut found);
        self.declared(&mut found, &self.plain_text(node), node);
        let name = node.attribute("name").unwrap_or_default();
        self.project.globals.push((name.to_owned(), found));
    }

    /// Adds what a declaration as text says beyond the elements.
    fn declared(&mut self, variables: &mut Vec<Variable>, written: &str, node: Node<'_, '_>) {
        if let Err(fault) = addresses(variables, written) {
            self.faults.push(Fault { line: self.text.line(node), ..fault });
        }
    }

    /// The declaration as text beside an element; empty if there is none.
    fn plain_text(&self, node: Node<'_, '_>) -> String {
        // The declarations of methods and properties are nested deeper and are not included.
        let data = added(node).chain(children(node, "InterfaceAsPlainText"));
        let mut plain = data.filter(|one| one.tag_name().name() == "InterfaceAsPlainText");
        plain.next().map(|one| self.text.content(one).0).unwrap_or_default()
    }

    fn task(&mut self, node: Node<'_, '_>) {
        let name = node.attribute("name").unwrap_or_default().to_owned();
        let interval = node.attribute("interval").and_then(interval);
        let priority = node.attribute("priority").map(str::to_owned);
        let instances =
            children(node, "pouInstance").filter_map(|one| self.instance(one)).collect();
        let resource = resource(node);
        self.project.tasks.push(Task { name, resource, interval, priority, instances });
    }

    /// The names of a program instance and of its program; `None` with a fault if both are missing.
    fn instance(&mut self, node: Node<'_, '_>) -> Option<(String, String)> {
        // TwinCAT leaves the type empty, and the name is the program's.
        let of = node.attribute("typeName").or(node.attribute("type")).filter(|of| !of.is_empty());
        let own = node.attribute("name");
        let Some(name) = own.or(of) else {
            let message = "a pouInstance has neither a name nor a type".to_owned();
            self.faults
                .push(self.text.fault(node, message).help("give it the typeName of its program"));
            return None;
        };
        if own.is_none() && !self.unnamed.insert(name.to_ascii_uppercase()) {
            let message = format!("two instances of the program {name} have no name");
            self.faults.push(self.text.fault(node, message).help("give each a name of its own"));
        }
        Some((name.to_owned(), of.unwrap_or(name).to_owned()))
    }

    fn pou(&mut self, node: Node<'_, '_>) -> Pou {
        let kind = match node.attribute("pouType") {
            Some("program") => PouKind::Program,
            Some("function") => PouKind::Function,
            Some("functionBlock") => PouKind::FunctionBlock,
            other => {
                let message = format!("the pouType {} is not known", other.unwrap_or_default());
                let help = "it is program, function or functionBlock";
                self.project.unread.push((0, self.text.fault(node, message).help(help)));
                PouKind::FunctionBlock
            }
        };
        let mut pou = self.unit(node, kind);
        self.members(added(node), &mut pou);
        if let Err(fault) = parse::apart(&mut self.project, &mut pou) {
            self.faults.push(Fault { line: pou.line, ..fault });
        }
        pou
    }

    /// Reads an interface in the form of CODESYS and TwinCAT.
    fn interface(&mut self, node: Node<'_, '_>) {
        let mut pou = self.unit(node, PouKind::Interface);
        let listed = ["Methods", "Properties"].into_iter().flat_map(|list| children(node, list));
        self.members(listed.flat_map(elements).chain(added(node)), &mut pou);
        // An empty element only lists the interface as an object of the project.
        if !pou.methods.is_empty() || !self.plain_text(node).is_empty() {
            self.project.pous.push(pou);
        }
    }

    /// Reads methods and properties.
    fn members<'a, 'i: 'a>(&mut self, all: impl Iterator<Item = Node<'a, 'i>>, pou: &mut Pou) {
        for part in all {
            match part.tag_name().name() {
                "Method" | "method" => pou.methods.push(self.unit(part, PouKind::Function)),
                "Property" | "property" => self.property(part, pou),
                _ => {}
            }
        }
    }

    /// Reads the accessors of a property as methods.
    fn property(&mut self, node: Node<'_, '_>, pou: &mut Pou) {
        let name = node.attribute("name").unwrap_or_default();
        let of = child(node, "interface").and_then(|one| child(one, "returnType"));
        let of = of.map_or(TypeRef::Named(String::new()), |of| type_ref(self.text, of));
        for (element, reads) in [("GetAccessor", true), ("SetAccessor", false)] {
            let Some(one) = child(node, element) else { continue };
            let mut method = Pou::accessor(name, &of, reads, self.text.line(one));
            let own = self.unit(one, PouKind::Function);
            method.variables.extend(own.variables);
            method.body = own.body;
            pou.methods.push(method);
        }
    }

    /// Reads a unit or a method.
    fn unit(&mut self, node: Node<'_, '_>, kind: PouKind) -> Pou {
        let text = self.text;
        let name = node.attribute("name").unwrap_or_default();
        let interface = child(node, "interface");
        let mut pou = Pou {
            result: interface.and_then(|one| child(one, "returnType")).map(|of| type_ref(text, of)),
            variables: interface.map(|one| variables(text, one)).unwrap_or_default(),
            ..Pou::new(name, kind, text.line(node))
        };
        let mut written = self.plain_text(node);
        if let Some(interface) = interface {
            written += &self.plain_text(interface);
        }
        self.declared(&mut pou.variables, &written, node);
        pou.extends = extends(&written);
        for one in [Some(node), interface].into_iter().flatten().flat_map(added) {
            let bases = || children(one, "Extends").filter_map(|base| base.text());
            if kind == PouKind::Interface {
                pou.implements.extend(bases().map(last_name));
            } else {
                pou.extends = bases().next().map(last_name).or(pou.extends.take());
            }
            let own = children(one, "Implements").filter_map(|own| own.text());
            pou.implements.extend(own.map(last_name));
            pou.is_private |= one.tag_name().name() == "AccessModifiers"
                && one.attribute("Private").is_some_and(|own| own.eq_ignore_ascii_case("true"));
        }
        self.parts(node, &written, &mut pou);
        pou
    }

    /// `plain`: the text in which the unit declares its variables.
    fn parts(&mut self, node: Node<'_, '_>, plain: &str, pou: &mut Pou) {
        let text = self.text;
        let named = |list: &'static str, item: &'static str| {
            child(node, list).into_iter().flat_map(move |list| children(list, item))
        };
        let of_parts = named("transitions", "transition").chain(named("actions", "action"));
        for owner in std::iter::once(node).chain(of_parts) {
            let Some(second) = children(owner, "body").nth(1) else { continue };
            let message = "there is a second body (a second worksheet)";
            let fault = text.fault(second, message).help("put what it does into the first one");
            self.faults.push(fault.within(&pou.name));
        }
        if let Some(second) = second_connector(text, node) {
            let message = format!(
                "another connector of the unit is called {}",
                second.attribute("name").unwrap_or_default()
            );
            let help = "give it a name of its own: generators keep one value for each name";
            self.faults.push(text.fault(second, message).help(help).within(&pou.name));
        }
        for one in named("transitions", "transition").filter(|_| !text.is_codesys) {
            if has_edge(one) && is_named_twice(node, one.attribute("name").unwrap_or_default()) {
                let message = "several transitions of the chart refer to this one, and it detects an edge: generators detect it for each of them";
                let help = "detect the edge with R_TRIG or F_TRIG in an action, and use its output";
                self.faults.push(text.fault(one, message).help(help).within(&pou.name));
            }
        }
        for one in named("transitions", "transition") {
            let name = one.attribute("name").unwrap_or_default().to_owned();
            let mut reading = Reading::new(text, pou, &name);
            reading.computes = true;
            let found = child(one, "body").map(|inner| condition_body(&mut reading, inner));
            self.faults.append(&mut reading.faults);
            let body = found.unwrap_or_else(Body::empty);
            pou.transitions.push(Named { name, body, line: text.line(one) });
        }
        for one in named("actions", "action") {
            let name = one.attribute("name").unwrap_or_default().to_owned();
            let mut reading = Reading::new(text, pou, &name);
            let found = child(one, "body").map(|inner| body(&mut reading, inner));
            self.faults.append(&mut reading.faults);
            let mut body = found.unwrap_or_else(Body::empty);
            chart_settings::apply(text, one, plain, (&mut body, &mut pou.variables));
            pou.actions.push(Named { name, body, line: text.line(one) });
        }
        if let Some(one) = child(node, "body") {
            let mut reading = Reading::new(text, pou, "");
            reading.computes = true;
            let found = body(&mut reading, one);
            self.faults.append(&mut reading.faults);
            pou.body = found;
            chart_settings::apply(text, node, plain, (&mut pou.body, &mut pou.variables));
        }
        if let Err(fault) = store_computed(pou) {
            self.faults.push(fault.within(&pou.name));
        }
        complete(pou);
    }
}

/// Lets the initial step store the action that executes the blocks of drawn conditions, if there is one.
fn store_computed(pou: &mut Pou) -> Result<(), Fault> {
    let Some(at) = pou.actions.iter().position(|one| one.name == COMPUTED && one.line == 0) else {
        return Ok(());
    };
    let others = pou.actions.iter().filter(|one| same(&one.name, COMPUTED));
    if others.count() > 1 {
        let message = format!(
            "an action is called {COMPUTED}, which is the name of the action for drawn conditions"
        );
        return Err(Fault::new(pou.line, message).help("give the action another name"));
    }
    let Body::Chart(chart) = &mut pou.body else {
        // Without a chart, nothing uses the conditions.
        pou.actions.remove(at);
        return Ok(());
    };
    pou.actions[at].line = chart.line;
    let target = Target::Path(Path::name(COMPUTED));
    let block =
        Block { qualifier: Qualifier::S, is_qualified: true, time: None, target, line: chart.line };
    if let Some(first) = chart.steps.iter_mut().find(|step| step.initial) {
        first.blocks.push(block);
    }
    Ok(())
}

/// Whether a contact in the drawing detects an edge.
fn has_edge(drawn: Node<'_, '_>) -> bool {
    drawn.descendants().any(|one| {
        one.tag_name().name() == "contact"
            && one.attribute("edge").is_some_and(|edge| edge != "none")
    })
}

/// Whether several conditions of a unit refer to this transition.
fn is_named_twice(unit: Node<'_, '_>, name: &str) -> bool {
    let named = unit.descendants().filter(|one| {
        let around = one.parent().map_or("", |around| around.tag_name().name());
        one.tag_name().name() == "reference"
            && around == "condition"
            && one.attribute("name").is_some_and(|own| same(own, name))
    });
    named.count() > 1
}

/// A connector with the same name as another one of the unit; not searched for in CODESYS files.
fn second_connector<'a, 'i>(text: &Text, unit: Node<'a, 'i>) -> Option<Node<'a, 'i>> {
    let mut names = BTreeSet::new();
    let all = unit.descendants().filter(|one| one.tag_name().name() == "connector");
    let mut all = all.filter(|_| !text.is_codesys);
    all.find(|one| !names.insert(one.attribute("name")))
}

/// A unit's name without a library's name in front.
fn last_name(name: &str) -> String {
    name.trim().rsplit('.').next().unwrap_or_default().to_owned()
}

/// The nanoseconds of an interval such as `T#20ms` or `PT0.02S`; `None` if it cannot be read, and for `PT0S`.
fn interval(text: &str) -> Option<i64> {
    let plain = text.rsplit('#').next().unwrap_or(text);
    if let Some(time) = parse::duration(plain).filter(|_| !plain.starts_with('P')) {
        return Some(time);
    }
    let rest = plain.strip_prefix("PT")?;
    if same(rest, "0S") {
        return None;
    }
    parse::duration(&rest.to_ascii_lowercase())
}

/// The names of the configuration and resource that hold an element; empty if there is none.
fn resource(node: Node<'_, '_>) -> String {
    let is_holder =
        |one: &Node<'_, '_>| ["configuration", "resource"].contains(&one.tag_name().name());
    let names = node.ancestors().filter(is_holder).map(|one| one.attribute("name").unwrap_or(""));
    let mut names: Vec<&str> = names.collect();
    names.reverse();
    names.join(" ")
}

/// The fault about a setting of CODESYS or TwinCAT that changes what is executed and is not followed. `None` if there
/// is none.
fn setting(text: &Text, node: Node<'_, '_>) -> Option<Fault> {
    let is_true = |one: &Node<'_, '_>| {
        one.text().is_some_and(|text| text.trim().eq_ignore_ascii_case("true"))
    };
    let what = match node.tag_name().name() {
        "SFCSettings" => {
            let owner = node.ancestors().nth(3).map_or("", |one| one.tag_name().name());
            let has_chart = ["pou", "action"].contains(&owner);
            let restarts = |flag: &String| has_chart && CONTROL_FLAGS[..2].contains(&&**flag);
            let flag = chart_settings::declared_flags(node).find(|flag| !restarts(flag))?;
            format!("the settings of the chart use the flag {flag}")
        }
        "BuildProperties" => {
            let is_other = |one: &Node<'_, '_>| one.tag_name().name() != "LinkAlways";
            let property = elements(node).filter(is_other).find(is_true)?.tag_name().name();
            format!("the build property {property} is set")
        }
        _ => {
            let is_excluded = node.attribute("guid") == Some(EXCLUDED) && is_true(&node);
            is_excluded.then(|| "an element is excluded".to_owned())?
        }
    };
    let help = "change this in the programming tool, and export the project again";
    let fault = text.fault(node, format!("{what}, which is not followed"));
    Some(fault.code(Code::NotModelled).help(help))
}

//! Global names that may refer to several declarations.

use super::declared::kind;
use super::index::ByName;
use super::resolver::{Resolver, Scope};
use super::types::is_elementary;
use scanbound_base::code::Code;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Pou, PouKind, Project, TypeRef};
use std::collections::BTreeSet;

/// For each ambiguous global name, in capitals, the kinds of things that it may refer to.
pub(super) fn meanings(project: &Project) -> ByName<BTreeSet<String>> {
    let mut found: ByName<BTreeSet<String>> = ByName::new();
    let mut add = |name: &str, what: String| {
        found.entry(name.to_ascii_uppercase()).or_default().insert(what);
    };
    // Functions are ambiguous only with variables that can be called, because other variables are never called.
    let mut instances = BTreeSet::new();
    for (list, all) in &project.globals {
        if !list.is_empty() {
            add(list, "a list of global variables".to_owned());
        }
        for one in all {
            if !is_elementary(&one.of) {
                instances.insert(one.name.to_ascii_uppercase());
            }
            let of = if list.is_empty() { String::new() } else { format!(" of {list}") };
            add(&one.name, format!("a global variable{of}"));
        }
    }
    for one in &project.types {
        let TypeRef::Enumeration(values, _) = &one.of else { continue };
        values.iter().for_each(|(name, _)| add(name, "a value of an enumeration".to_owned()));
    }
    let is_called = |pou: &&Pou| match pou.kind {
        PouKind::Program => true,
        PouKind::Function => instances.contains(&pou.name.to_ascii_uppercase()),
        PouKind::FunctionBlock | PouKind::Interface => false,
    };
    for pou in project.pous.iter().filter(is_called) {
        add(&pou.name, format!("a {}", kind(pou)));
    }
    found.retain(|_, what| what.len() > 1);
    found
}

impl Resolver<'_> {
    /// Records a fault if code uses an ambiguous global name that its unit does not declare.
    pub(super) fn note_global(&mut self, scope: Scope, name: &str) {
        let (Some(unit), true) = (scope.unit, self.is_code && !self.meanings.is_empty()) else {
            return;
        };
        let key = name.to_ascii_uppercase();
        let Some(what) = self.meanings.get(&key) else { return };
        let what: Vec<&str> = what.iter().map(String::as_str).collect();
        let own = self.tree.unit(unit);
        let told = format!("{}: {key} may mean {}", own.name, what.join(" or "));
        let help = "write the list or the type in front of it, or give one of them another name";
        let fault = Fault::new(own.line, told).code(Code::DeclaredTwice).help(help);
        let fault = (own.file, fault);
        if !self.tree.faults.contains(&fault) {
            self.tree.faults.push(fault);
        }
    }
}

//! Extends a report of an unknown type to all unknown types, so that one run lists everything that is missing.

use crate::declarations::UnitId;
use crate::tree::Tree;
use crate::types::{Type, TypeId};
use scanbound_base::code::Code;
use scanbound_iec::PouKind;
use scanbound_iec::fault::Fault;
use std::collections::{BTreeMap, BTreeSet};

/// The name of the unknown type, in capitals, if the fault reports one.
fn unknown(fault: &Fault) -> Option<String> {
    let is_one = fault.code == Code::UnknownType && !fault.text.is_empty();
    is_one.then(|| fault.text.to_ascii_uppercase())
}

/// If `faults` reports an unknown type, replaces such reports by one for each unknown type that the programs use.
pub fn list_unknown_types(tree: &Tree, faults: &mut Vec<(usize, Fault)>) {
    if !faults.iter().any(|(_, fault)| unknown(fault).is_some()) {
        return;
    }
    let mut found: BTreeMap<String, (usize, Fault)> = BTreeMap::new();
    for (file, fault) in declared(tree) {
        let Some(name) = unknown(&fault) else { continue };
        found.entry(name).or_insert((file, fault));
    }
    faults.retain(|(_, fault)| unknown(fault).is_none_or(|name| !found.contains_key(&name)));
    faults.extend(found.into_values());
}

/// The type faults, with their files, in variables of the programs, of global instances and of all units that these
/// contain or extend.
fn declared(tree: &Tree) -> Vec<(usize, Fault)> {
    fn innermost(tree: &Tree, ty: TypeId) -> &Type {
        match tree.types.get(ty) {
            Type::Array(_, of) => innermost(tree, *of),
            other => other,
        }
    }
    let units = (0..tree.units.len()).map(UnitId::at);
    let mut open: Vec<UnitId> =
        units.filter(|&one| tree.unit(one).kind == PouKind::Program).collect();
    for id in tree.globals.iter().flat_map(|list| &list.variables) {
        if let Type::Block(unit) = innermost(tree, tree.variable(*id).ty) {
            open.push(*unit);
        }
    }
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        let unit = tree.unit(id);
        let methods = unit.methods.iter().flat_map(|&one| &tree.routine(one).variables);
        for variable in unit.variables.iter().chain(methods) {
            match innermost(tree, tree.variable(*variable).ty) {
                Type::Block(unit) => open.push(*unit),
                Type::Faulty(at) => found.push((unit.file, tree.types.fault(*at))),
                _ => {}
            }
        }
        open.extend(unit.base);
    }
    found.sort_by_key(|(file, fault)| (*file, fault.line));
    found
}

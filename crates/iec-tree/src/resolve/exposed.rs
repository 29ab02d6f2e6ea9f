//! Determines which units have variables that code of other units may access.

use super::resolver::Resolver;
use crate::declarations::{Owner, UnitId, VarId};
use crate::types::{Type, TypeId};
use std::collections::BTreeSet;

impl Resolver<'_> {
    /// The units whose variables code of other units may access, if it names the programs `named`. If the project has
    /// references: all units. Otherwise those of global instances and of the named programs, and of all instances
    /// inside these.
    pub(super) fn exposed_units(&self, named: &BTreeSet<UnitId>) -> BTreeSet<UnitId> {
        let tree = &self.tree;
        if tree.types.has_references() {
            return (0..tree.units.len()).map(UnitId::at).collect();
        }
        let globals = tree.globals.iter().flat_map(|list| &list.variables);
        let mut open: Vec<TypeId> = globals.map(|&id| tree.variable(id).ty).collect();
        let mut found = BTreeSet::new();
        let mut expose = |unit: UnitId, open: &mut Vec<TypeId>| {
            for one in tree.lineage(unit) {
                if found.insert(one) {
                    open.extend(tree.unit(one).variables.iter().map(|&id| tree.variable(id).ty));
                }
            }
        };
        named.iter().for_each(|&unit| expose(unit, &mut open));
        let mut seen = BTreeSet::new();
        while let Some(ty) = open.pop() {
            if !seen.insert(ty) {
                continue;
            }
            match tree.types.get(ty) {
                Type::Array(_, of) => open.push(*of),
                Type::Struct(id) => open.extend(tree.types.parts(*id).iter().map(|(_, of)| *of)),
                Type::Block(unit) => expose(*unit, &mut open),
                _ => {}
            }
        }
        found
    }

    /// Whether code of other units may read or write this variable. True for every global variable.
    pub(super) fn is_exposed(&self, id: VarId) -> bool {
        match self.tree.variable(id).owner {
            Owner::Unit(unit) => self.exposed.contains(&unit),
            Owner::Routine(routine) => self.exposed.contains(&self.tree.routine(routine).unit),
            Owner::Global(_) => true,
        }
    }
}

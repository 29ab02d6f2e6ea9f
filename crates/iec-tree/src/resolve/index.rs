//! The declarations of a project, indexed by scope and name.

use crate::declarations::{RoutineId, RoutineKind, UnitId, VarId};
use crate::tree::Tree;
use scanbound_iec::ast::{Part, Path};
use scanbound_iec::{PouKind, Project};
use std::collections::{BTreeMap, BTreeSet};

/// A map whose keys are names in capitals.
pub(super) type ByName<T> = BTreeMap<String, T>;

/// All declared names of a project.
#[derive(Default)]
pub(super) struct Index {
    units: ByName<UnitId>,
    programs: ByName<UnitId>,
    functions: ByName<UnitId>,
    types: ByName<usize>,
    /// The ids of declared types that are already resolved, by the type's index in the project.
    pub(super) known_types: BTreeMap<usize, crate::types::TypeId>,
    /// Global variables by name alone; if several lists declare the name, in order of the lists.
    globals: ByName<Vec<VarId>>,
    /// Global variables by the list's name and the variable's name.
    listed: BTreeMap<(String, String), VarId>,
    /// Names `list.variable` where the list is known only by its file's name.
    of_files: BTreeSet<(String, String)>,
    /// For each unit, its variables and those that it inherits.
    members: Vec<ByName<VarId>>,
    /// The variables of methods.
    locals: BTreeMap<RoutineId, ByName<VarId>>,
    /// For each unit, its actions and methods with those that it inherits.
    actions: Vec<ByName<RoutineId>>,
    methods: Vec<ByName<RoutineId>>,
    /// The number of each variable name ([`crate::declarations::Variable::symbol`]).
    symbols: ByName<u32>,
    /// The number of each routine kind and name ([`crate::declarations::Routine::slot`]).
    slots: BTreeMap<(RoutineKind, String), u32>,
    /// The properties of each unit, inherited ones included.
    properties: Vec<ByName<()>>,
}

fn key(name: &str) -> String {
    name.to_ascii_uppercase()
}

impl Index {
    pub(super) fn new(project: &Project) -> Index {
        let mut found = Index::default();
        for (number, pou) in project.pous.iter().enumerate() {
            let id = UnitId::at(number);
            found.units.entry(key(&pou.name)).or_insert(id);
            let more = match pou.kind {
                PouKind::Program => &mut found.programs,
                PouKind::Function => &mut found.functions,
                PouKind::FunctionBlock | PouKind::Interface => continue,
            };
            more.entry(key(&pou.name)).or_insert(id);
        }
        for (number, one) in project.types.iter().enumerate() {
            found.types.entry(key(&one.name)).or_insert(number);
        }
        found.members = vec![ByName::new(); project.pous.len()];
        found
    }

    /// Adds actions, methods and properties. All units must be declared before.
    pub(super) fn members(&mut self, tree: &Tree) {
        for number in 0..tree.units.len() {
            let (mut actions, mut methods) = (ByName::new(), ByName::new());
            let mut properties = ByName::new();
            let own = UnitId::at(number);
            let is_interface = tree.unit(own).kind == PouKind::Interface;
            let more = tree.unit(own).interfaces.iter().copied().filter(|_| is_interface);
            for unit in tree.lineage(own).into_iter().chain(more) {
                let unit = tree.unit(unit);
                for &one in &unit.actions {
                    actions.entry(key(&tree.routine(one).name)).or_insert(one);
                }
                for &one in &unit.methods {
                    let name = &tree.routine(one).name;
                    methods.entry(key(name)).or_insert(one);
                    if let Some((property, _)) = name.split_once('.') {
                        properties.insert(key(property), ());
                    }
                }
            }
            self.actions.push(actions);
            self.methods.push(methods);
            self.properties.push(properties);
        }
    }

    /// Adds inherited variables to each unit. All variables must be declared before.
    pub(super) fn inherit(&mut self, tree: &Tree) {
        let all: Vec<ByName<VarId>> = (0..tree.units.len())
            .map(|number| {
                let mut found = ByName::new();
                for unit in tree.lineage(UnitId::at(number)).into_iter().rev() {
                    for (name, id) in &self.members[unit.index()] {
                        found.entry(name.clone()).or_insert(*id);
                    }
                }
                found
            })
            .collect();
        self.members = all;
    }

    /// The number of a variable name; equal names, ignoring case, have equal numbers.
    pub(super) fn symbol(&mut self, name: &str) -> u32 {
        let next = u32::try_from(self.symbols.len()).unwrap_or(u32::MAX);
        *self.symbols.entry(key(name)).or_insert(next)
    }

    /// The number of a routine kind and name; equal pairs have equal numbers.
    pub(super) fn slot(&mut self, kind: RoutineKind, name: &str) -> u32 {
        let next = u32::try_from(self.slots.len()).unwrap_or(u32::MAX);
        *self.slots.entry((kind, key(name))).or_insert(next)
    }

    pub(super) fn add_member(&mut self, unit: UnitId, name: &str, id: VarId) {
        self.members[unit.index()].entry(key(name)).or_insert(id);
    }

    pub(super) fn add_local(&mut self, routine: RoutineId, name: &str, id: VarId) {
        self.locals.entry(routine).or_default().entry(key(name)).or_insert(id);
    }

    pub(super) fn add_global(&mut self, list: &str, name: &str, id: VarId) {
        self.globals.entry(key(name)).or_default().push(id);
        self.listed.entry((key(list), key(name))).or_insert(id);
    }

    /// Adds the name `list.name`, where `list` is a file's name, if exactly one global variable has this name.
    pub(super) fn add_of_file(&mut self, list: &str, name: &str) {
        if self.globals(name).len() == 1 {
            self.of_files.insert((key(list), key(name)));
        }
    }

    /// If the path begins with `list.variable` and the list is known only by its file's name, the variable's name.
    pub(super) fn of_file<'p>(&self, path: &'p Path) -> Option<&'p str> {
        let Part::Name(name) = path.rest.first()? else { return None };
        self.of_files.contains(&(key(&path.first), key(name))).then_some(name)
    }

    pub(super) fn unit(&self, name: &str) -> Option<UnitId> {
        self.units.get(&key(name)).copied()
    }

    pub(super) fn program(&self, name: &str) -> Option<UnitId> {
        self.programs.get(&key(name)).copied()
    }

    pub(super) fn function(&self, name: &str) -> Option<UnitId> {
        self.functions.get(&key(name)).copied()
    }

    pub(super) fn declared_type(&self, name: &str) -> Option<usize> {
        self.types.get(&key(name)).copied()
    }

    pub(super) fn globals(&self, name: &str) -> &[VarId] {
        self.globals.get(&key(name)).map_or(&[], Vec::as_slice)
    }

    pub(super) fn listed(&self, list: &str, name: &str) -> Option<VarId> {
        self.listed.get(&(key(list), key(name))).copied()
    }

    pub(super) fn member(&self, unit: UnitId, name: &str) -> Option<VarId> {
        self.members[unit.index()].get(&key(name)).copied()
    }

    pub(super) fn local(&self, routine: RoutineId, name: &str) -> Option<VarId> {
        self.locals.get(&routine)?.get(&key(name)).copied()
    }

    pub(super) fn action(&self, unit: UnitId, name: &str) -> Option<RoutineId> {
        self.actions[unit.index()].get(&key(name)).copied()
    }

    pub(super) fn method(&self, unit: UnitId, name: &str) -> Option<RoutineId> {
        self.methods[unit.index()].get(&key(name)).copied()
    }

    pub(super) fn has_property(&self, unit: UnitId, name: &str) -> bool {
        self.properties[unit.index()].contains_key(&key(name))
    }
}

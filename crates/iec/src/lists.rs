//! Lists of global variables that are named after their files, as CODESYS and TwinCAT have them: `GVL.Level`.

use super::ast::{Expr, Part, Path, path_of, paths_of};
use super::parse::file_stem;
use super::{Body, Pou, Project, TypeRef, Variable, same};
use std::collections::{BTreeMap, BTreeSet};

/// A list's name, and those of its variables.
type List = (String, Vec<String>);

impl Project {
    /// Takes a list's name away where it stands before one of its variables, when all files are read; unless that name, or the
    /// variable's alone, means something else there.
    pub fn unqualify(&mut self) {
        self.name_lists();
        let lists = std::mem::take(&mut self.lists);
        let lists: Vec<&List> = lists.iter().filter(|(list, _)| !self.has_name(list)).collect();
        if lists.is_empty() {
            return;
        }
        let globals = self.globals.iter().flat_map(|(_, all)| all);
        let names: Vec<String> = globals.map(|one| one.name.clone()).collect();
        let is_only = |name: &str| names.iter().filter(|own| same(own, name)).count() == 1;
        let unqualified = |path: &Path| {
            let Some(Part::Name(name)) = path.rest.first() else { return None };
            let is_it = |(list, all): &&&List| {
                same(list, &path.first) && all.iter().any(|own| same(own, name))
            };
            (lists.iter().any(|list| is_it(&list)) && is_only(name)).then(|| name.clone())
        };
        for pou in &mut self.pous {
            in_unit(pou, &[], &unqualified);
        }
        let mut see = |path: &mut Path| shorten(path, &[], &unqualified);
        for (_, all) in &mut self.globals {
            all.iter_mut().for_each(|one| in_variable(one, &mut see));
        }
        for one in &mut self.types {
            in_type(&mut one.of, &mut see);
            one.initial.iter_mut().for_each(|value| paths_of(value, &mut see));
        }
        for one in self.connected.iter_mut().flat_map(|one| &mut one.given) {
            paths_of(&mut one.value, &mut see);
        }
    }

    /// Gives the lists of several files their files' names where two of them declare variables of one name: these are told apart
    /// by the names of the lists.
    fn name_lists(&mut self) {
        let mut named = BTreeMap::new();
        let mut differ = BTreeSet::new();
        for (number, (list, all)) in self.globals.iter().enumerate() {
            for one in all.iter().filter(|_| list.is_empty()) {
                let file = self.file_of_list(number);
                let key = one.name.to_ascii_uppercase();
                let (first_file, first) = *named.entry(key).or_insert((file, one));
                if first_file != file && first != one {
                    differ.extend([first_file, file]);
                }
            }
        }
        let name = |file: usize| file_stem(&self.files[file]).to_owned();
        let has_list = |name: &str| self.lists.iter().any(|(list, _)| same(list, name));
        if !differ.iter().all(|&file| has_list(&name(file)) && !self.has_name(&name(file))) {
            return;
        }
        let names: BTreeMap<usize, String> =
            differ.iter().map(|&file| (file, name(file))).collect();
        self.lists.retain(|(list, _)| !names.values().any(|own| same(own, list)));
        for number in 0..self.globals.len() {
            let Some(own) = names.get(&self.file_of_list(number)) else { continue };
            if self.globals[number].0.is_empty() {
                self.globals[number].0.clone_from(own);
            }
        }
    }

    /// Whether something else has a list's name.
    fn has_name(&self, name: &str) -> bool {
        let units = self.pous.iter().flat_map(|pou| pou.methods.iter().chain([pou]));
        let variables = units.clone().flat_map(|pou| &pou.variables);
        let globals = self.globals.iter().flat_map(|(_, all)| all);
        let tasks = self.tasks.iter().flat_map(|task| &task.instances);
        variables.chain(globals).any(|one| same(&one.name, name))
            || units.flat_map(|pou| &pou.actions).any(|one| same(&one.name, name))
            || self.pous.iter().flat_map(|pou| &pou.methods).any(|one| same(&one.name, name))
            || self.pous.iter().any(|pou| same(&pou.name, name))
            || self.types.iter().any(|one| same(&one.name, name))
            || self.globals.iter().any(|(list, _)| same(list, name))
            || { tasks }.any(|(own, _)| same(own, name))
    }
}

type Unqualified<'u> = &'u dyn Fn(&Path) -> Option<String>;

/// Takes a list's name away, unless one of these variables has the name of the list's.
fn shorten(path: &mut Path, hiding: &[String], unqualified: Unqualified<'_>) {
    let Some(name) = unqualified(path) else { return };
    if !hiding.iter().any(|own| same(own, &name)) {
        path.first = name;
        path.rest.remove(0);
    }
}

fn in_unit(pou: &mut Pou, around: &[String], unqualified: Unqualified<'_>) {
    let own = pou.variables.iter().map(|one| &one.name).chain([&pou.name]);
    let members = pou.methods.iter().map(|one| &one.name);
    let members = members.chain(pou.actions.iter().map(|one| &one.name));
    let hiding: Vec<String> = own.chain(members).chain(around).cloned().collect();
    // What a unit inherits may hide them, too.
    if pou.extends.is_some() {
        return;
    }
    let mut see = |path: &mut Path| shorten(path, &hiding, unqualified);
    pou.variables.iter_mut().for_each(|one| in_variable(one, &mut see));
    in_body(&mut pou.body, &mut see);
    for one in pou.actions.iter_mut().chain(&mut pou.transitions) {
        in_body(&mut one.body, &mut see);
    }
    pou.methods.iter_mut().for_each(|one| in_unit(one, &hiding, unqualified));
}

fn in_variable(one: &mut Variable, see: &mut dyn FnMut(&mut Path)) {
    one.initial.iter_mut().for_each(|value| paths_of(value, see));
    in_type(&mut one.of, see);
}

fn in_type(of: &mut TypeRef, see: &mut dyn FnMut(&mut Path)) {
    match of {
        TypeRef::Array(dimensions, of) => {
            for bound in dimensions.iter_mut().flat_map(|(low, high)| [low, high]) {
                paths_of(bound, see);
            }
            in_type(of, see);
        }
        TypeRef::Text(Some(length)) => paths_of(length, see),
        TypeRef::Struct(parts) => parts.iter_mut().for_each(|one| in_variable(one, see)),
        TypeRef::Subrange(of, bounds) => {
            let (low, high) = &mut **bounds;
            paths_of(low, see);
            paths_of(high, see);
            in_type(of, see);
        }
        TypeRef::Pointer(of) | TypeRef::Reference(of) => in_type(of, see),
        TypeRef::Named(_) | TypeRef::Text(None) | TypeRef::Enumeration(..) => {}
    }
}

fn in_body(body: &mut Body, see: &mut dyn FnMut(&mut Path)) {
    let see = std::cell::RefCell::new(see);
    body.change(
        &mut |expr: &mut Expr| paths_of(expr, &mut |path| (see.borrow_mut())(path)),
        &mut |path| path_of(path, &mut |path| (see.borrow_mut())(path)),
    );
}

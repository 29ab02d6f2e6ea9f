//! What a project names and does not declare: all unknown types where one of them is found, so that one run tells all that is
//! missing; and names of variables.

use super::emit::Emit;
use super::resolve::{Context, unknown};
use super::types::lineage;
use scanbound_base::code::Code;
use scanbound_iec::ast::Path;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Pou, PouKind, Project, Section, TypeRef, Variable, same, show};
use std::collections::BTreeSet;

/// Lists all unknown types in place of the first one, if there is one.
pub(super) fn list_all(emit: &mut Emit<'_>) {
    let is_one = |fault: &Fault| fault.code == Code::UnknownType && !fault.text.is_empty();
    if !emit.faults.iter().any(|(_, fault)| is_one(fault)) {
        return;
    }
    let mut found: Vec<(usize, Fault)> = Vec::new();
    for (file, one) in declared(emit.project) {
        let named = innermost(&one.of);
        let TypeRef::Named(name) = named else { continue };
        if is_declared(emit.project, name) {
            continue;
        }
        if let Err(fault) = emit.types.resolve(named, one.line)
            && is_one(&fault)
            && found.iter().all(|(_, other)| !same(&other.text, &fault.text))
        {
            found.push((file, fault));
        }
    }
    let is_listed = |fault: &Fault| {
        is_one(fault) && found.iter().any(|(_, other)| same(&other.text, &fault.text))
    };
    emit.faults.retain(|(_, fault)| !is_listed(fault));
    emit.faults.extend(found);
}

/// The variables of all units that a program may come to by their types, with their files.
fn declared(project: &Project) -> Vec<(usize, &Variable)> {
    let mut seen: BTreeSet<usize> = BTreeSet::new();
    let is_program = |(_, pou): &(usize, &Pou)| pou.kind == PouKind::Program;
    let programs = project.pous.iter().enumerate().filter(is_program);
    let mut open: Vec<usize> = programs.map(|(at, _)| at).collect();
    let globals = project.globals.iter().flat_map(|(_, all)| all);
    let mut found: Vec<(usize, &Variable)> = Vec::new();
    for one in globals {
        open.extend(unit_of(project, &one.of));
    }
    while let Some(at) = open.pop() {
        if !seen.insert(at) {
            continue;
        }
        let pou = &project.pous[at];
        let all = pou.variables.iter().chain(pou.methods.iter().flat_map(|one| &one.variables));
        for one in all {
            found.push((pou.file, one));
            open.extend(unit_of(project, &one.of));
        }
        let base = pou.extends.as_ref();
        open.extend(
            base.and_then(|base| project.pous.iter().position(|own| same(&own.name, base))),
        );
    }
    found.sort_by_key(|(file, one)| (*file, one.line));
    found
}

fn innermost(of: &TypeRef) -> &TypeRef {
    match of {
        TypeRef::Array(_, of) => innermost(of),
        other => other,
    }
}

fn unit_of(project: &Project, of: &TypeRef) -> Option<usize> {
    let TypeRef::Named(name) = innermost(of) else { return None };
    project.pous.iter().position(|own| same(&own.name, name))
}

fn is_declared(project: &Project, name: &str) -> bool {
    project.pous.iter().any(|own| same(&own.name, name))
        || project.types.iter().any(|own| same(&own.name, name))
}

impl Emit<'_> {
    /// The fault of a name that nothing declares; of VAR_EXTERNAL, the list that declares it is missing.
    pub(super) fn not_declared(&self, at: &Context, path: &Path, line: u32) -> Fault {
        let mut all =
            lineage(self.project, self.instances[at.instance].pou).into_iter().flat_map(|pou| {
                pou.variables.iter().chain(pou.methods.iter().flat_map(|one| &one.variables))
            });
        let is_it =
            |one: &&Variable| one.section == Section::External && same(&one.name, &path.first);
        if all.any(|one| is_it(&one)) {
            let told = format!(
                "{} is declared as VAR_EXTERNAL, and no VAR_GLOBAL declares it",
                path.first
            );
            let help = format!("give the file in which VAR_GLOBAL declares {}, too", path.first);
            return Fault::new(line, told)
                .code(Code::UnknownName)
                .text(show::path(path))
                .help(help);
        }
        unknown(line, &show::path(path))
    }
}

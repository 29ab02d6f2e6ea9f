//! What the resolver knows while it goes through a project, and where it looks for names.

use super::index::{ByName, Index};
use crate::constants::Constants;
use crate::ids::{RoutineId, TempId, UnitId, VarId};
use crate::tree::{Call, Tree};
use scanbound_base::code::Code as FaultCode;
use scanbound_base::facts::StatedCall;
use scanbound_iec::ast::Held;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Project, Section, TypeRef, Variable as Declared};
use std::collections::{BTreeMap, BTreeSet};

/// A project while it is resolved.
pub(super) struct Resolver<'p> {
    pub(super) project: &'p Project,
    pub(super) facts: Facts<'p>,
    pub(super) constants: Constants<'p>,
    pub(super) tree: Tree,
    pub(super) index: Index,
    /// Those that a list keeps, by their numbers.
    pub(super) listed: BTreeMap<u32, TempId>,
    /// The variables that drawn conditions read, by units.
    pub(super) held: BTreeMap<(UnitId, Held), VarId>,
    /// Calls of properties of which a part is named: they come before what names it.
    pub(super) before: Vec<Call>,
    /// Whether code is resolved, not declarations.
    pub(super) is_code: bool,
    /// The global names that may mean several things, and which.
    pub(super) meanings: ByName<BTreeSet<String>>,
    /// The programs that code of other units has named so far.
    pub(super) named_programs: BTreeSet<UnitId>,
    /// The units of whose instances other units may name variables.
    pub(super) exposed: BTreeSet<UnitId>,
}

/// Where names are looked for.
#[derive(Clone, Copy)]
pub(super) struct Scope {
    /// The unit whose code it is; none for lists of global variables.
    pub(super) unit: Option<UnitId>,
    /// Its method.
    pub(super) method: Option<RoutineId>,
    /// The list whose own variables come first.
    pub(super) list: Option<usize>,
}

/// The variables that take memory of their own; globals that a unit only names do not.
pub(super) fn kept(all: &[Declared]) -> impl Iterator<Item = &Declared> {
    all.iter().filter(|one| one.section != Section::External && !one.name.is_empty())
}

/// The fault of a name that nothing declares.
pub(super) fn unknown_name(line: u32, name: &str) -> Fault {
    Fault::new(line, format!("there is no {name}"))
        .code(FaultCode::UnknownName)
        .text(name)
        .help("give all files of the project, or declare it")
}

/// The name of a type as it is written.
pub(super) fn named(of: &TypeRef) -> Option<&str> {
    match of {
        TypeRef::Named(name) => Some(name),
        _ => None,
    }
}

/// What the user states.
#[derive(Clone, Copy)]
pub struct Facts<'f> {
    /// Of calls and of code, by normalised names.
    pub calls: &'f BTreeMap<String, StatedCall>,
    /// For each file of the project the names that facts may call it by.
    pub files: &'f [[&'f str; 2]],
}

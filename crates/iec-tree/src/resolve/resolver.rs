//! The state of name resolution, and the scope in which names are looked up.

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

/// The state while a project is resolved.
pub(super) struct Resolver<'p> {
    pub(super) project: &'p Project,
    pub(super) facts: Facts<'p>,
    pub(super) constants: Constants<'p>,
    pub(super) tree: Tree,
    pub(super) index: Index,
    /// The temporaries of the current statement list, by their numbers.
    pub(super) listed: BTreeMap<u32, TempId>,
    /// The variables that hold the outputs of blocks in drawn conditions, by unit and output.
    pub(super) held: BTreeMap<(UnitId, Held), VarId>,
    /// Calls of property getters whose results the current expression or statement uses in part. They must run before
    /// it.
    pub(super) before: Vec<Call>,
    /// Whether bodies are being resolved, not declarations.
    pub(super) is_code: bool,
    /// The ambiguous global names, and the kinds of things that each may refer to.
    pub(super) meanings: ByName<BTreeSet<String>>,
    /// The programs that code of other units has named so far.
    pub(super) named_programs: BTreeSet<UnitId>,
    /// The units whose variables code of other units may access.
    pub(super) exposed: BTreeSet<UnitId>,
}

/// The scope in which a name is looked up.
#[derive(Clone, Copy)]
pub(super) struct Scope {
    /// The unit that contains the code; `None` for a list of global variables.
    pub(super) unit: Option<UnitId>,
    /// The method that contains the code; `None` outside methods.
    pub(super) method: Option<RoutineId>,
    /// The list of global variables whose declarations are resolved; its own variables come first.
    pub(super) list: Option<usize>,
}

/// The variables that have memory of their own: `VAR_EXTERNAL` and variables without a name are left out.
pub(super) fn kept(all: &[Declared]) -> impl Iterator<Item = &Declared> {
    all.iter().filter(|one| one.section != Section::External && !one.name.is_empty())
}

/// The fault of an undeclared name.
pub(super) fn unknown_name(line: u32, name: &str) -> Fault {
    Fault::new(line, format!("there is no {name}"))
        .code(FaultCode::UnknownName)
        .text(name)
        .help("give all files of the project, or declare it")
}

/// The name in a type reference; `None` if it is not a plain name.
pub(super) fn named(of: &TypeRef) -> Option<&str> {
    match of {
        TypeRef::Named(name) => Some(name),
        _ => None,
    }
}

/// The user's facts that name resolution needs.
#[derive(Clone, Copy)]
pub struct Facts<'f> {
    /// Times and writes stated for calls and pragmas, by normalized name.
    pub calls: &'f BTreeMap<String, StatedCall>,
    /// For each file of the project, the two names by which facts may refer to it.
    pub files: &'f [[&'f str; 2]],
}

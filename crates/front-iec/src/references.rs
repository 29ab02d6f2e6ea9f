//! What is known of references while a project is put together, and where paths lead.

use super::types::{Kind, Refers, Ty};
use scanbound_iec::TypeRef;
use scanbound_iec::ast::{Expr, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_ir::Tag;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A variable, or a part of one, and what it holds.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub(super) name: String,
    pub(super) tag: Tag,
    pub(super) ty: Ty,
}

/// The kind of the word that a reference is.
pub(super) const WORD: Kind = Kind::Whole { bits: 16, signed: false };

/// What is known of references from one time to the next that a project is put together.
#[derive(Default)]
pub(super) struct References {
    /// The variables whose addresses are taken; the word for each is its number here, from 1.
    pub(super) targets: Vec<Place>,
    pub(super) numbers: BTreeMap<String, usize>,
    /// All variables in the order in which they were first asked for: they lie where they lay.
    variables: Vec<Place>,
    asked: BTreeSet<String>,
    /// What references mean while something is done through them, by names that begin with `^`.
    pub(super) bound: BTreeMap<String, Place>,
    pub(super) next: u32,
    /// What of that which begins before the first scan is not followed, with its file.
    pub(super) faults: Vec<(usize, Fault)>,
    /// Whether this is not the last time, and what begins before the first scan is put together, too.
    pub(super) is_draft: bool,
}

impl References {
    /// Begins anew with the variables where they are.
    pub(super) fn again(self, is_draft: bool) -> References {
        let faults = if is_draft { Vec::new() } else { self.faults };
        References { asked: BTreeSet::new(), bound: BTreeMap::new(), faults, is_draft, ..self }
    }

    /// Whether there are any.
    pub(super) fn has_any(&self) -> bool {
        self.is_draft || !self.targets.is_empty()
    }

    pub(super) fn count(&self) -> usize {
        self.targets.len()
    }

    pub(super) fn variables(&self) -> &[Place] {
        &self.variables
    }

    /// The variable of this name, if it is known, and whether it was asked for before.
    pub(super) fn variable(&mut self, name: &str) -> (Option<Place>, bool) {
        let is_again = !self.asked.insert(name.to_owned());
        (self.variables.iter().find(|one| one.name == name).cloned(), is_again)
    }

    pub(super) fn add_variable(&mut self, place: &Place) {
        self.variables.push(place.clone());
    }

    /// What a name that begins with `^` means now.
    pub(super) fn meant(&self, name: &str) -> Option<&Place> {
        self.bound.get(name)
    }
}

/// What a path leads through: the reference that comes first in it.
pub(super) struct Referred {
    pub(super) before: Path,
    pub(super) rest: Vec<Part>,
    pub(super) kind: Refers,
    pub(super) of: Arc<TypeRef>,
    /// Where it is an instance of an array whose number is worked out: the number, the least and the largest.
    pub(super) among: Option<(Expr, i64, i64)>,
}

/// What a path leads to: the property that comes first in it.
pub(super) struct Property {
    /// The instance; nothing for the one whose code this is.
    pub(super) owner: Option<Path>,
    /// The unit whose it is, where that is not the instance's own (`SUPER^`).
    pub(super) base: Option<usize>,
    pub(super) name: String,
    pub(super) rest: Vec<Part>,
}

/// What a path leads through or to that is more than a variable.
pub(super) enum Way {
    Referred(Referred),
    Property(Property),
}

/// Where a path leads by its types.
pub(super) enum Walk {
    Way(Way),
    Type(Ty),
    Unknown,
}

//! Finds the function block instances for which some call passes EN.

use scanbound_iec::Section;
use scanbound_iec_tree::accesses::{Accesses, of_code};
use scanbound_iec_tree::blocks::StandardBlock;
use scanbound_iec_tree::declarations::{UnitId, VarId};
use scanbound_iec_tree::tree::{
    Call, Place, Root, Statement, StatementKind, Step, StepFlag, Target, Tree,
};
use scanbound_iec_tree::types::{Type as Typed, TypeId};
use scanbound_ir::Cell;
use std::collections::{BTreeMap, BTreeSet};

/// The function block instances for which some call passes EN.
#[derive(Default)]
pub(super) struct EnabledInstances {
    /// The variables that are these instances.
    pub(super) variables: BTreeSet<VarId>,
    /// Whether such a call goes through a reference, so that it may concern any instance.
    pub(super) through_reference: bool,
    /// Whether such an instance may be copied or passed, together with the value of its EN.
    pub(super) copied: bool,
    /// For each instance, by its first cells: the bit that says that its last EN was false. None if there was no room
    /// for it.
    pub(super) cells: BTreeMap<[Cell; 2], Option<Cell>>,
}

impl EnabledInstances {
    pub(super) fn of(tree: &Tree) -> EnabledInstances {
        let mut walk = Walk::default();
        tree.routines.iter().for_each(|one| of_code(&one.code, &mut walk));
        let is_passed =
            |section| matches!(section, Section::InOut | Section::Input | Section::Output);
        let passed = tree.variables.iter().filter(|one| is_passed(one.section)).map(|one| one.ty);
        let copied: BTreeSet<TypeId> = passed.chain(walk.copied).collect();
        let is_enabled = |of: &Typed| match of {
            Typed::Standard(block) => walk.blocks.contains(block),
            Typed::Block(unit) => tree.lineage(*unit).iter().any(|one| walk.units.contains(one)),
            _ => false,
        };
        let copied = copied.into_iter().any(|ty| tree.holds(ty, &is_enabled));
        EnabledInstances { copied, ..walk.found }
    }
}

/// Collects the instances for which calls pass EN, their types, and the types of copied variables.
#[derive(Default)]
struct Walk {
    found: EnabledInstances,
    units: BTreeSet<UnitId>,
    blocks: BTreeSet<StandardBlock>,
    copied: BTreeSet<TypeId>,
}

impl Accesses for Walk {
    fn reads(&mut self, _: &Place) {}
    fn writes(&mut self, _: &Place) {}
    fn takes_address(&mut self, _: &Place) {}
    fn asks(&mut self, _: &StepFlag) {}

    fn calls(&mut self, call: &Call) {
        if call.enable.condition.is_none() {
            return;
        }
        let place = match &call.target {
            Target::Instance(place, unit) => {
                self.units.insert(*unit);
                place
            }
            Target::Standard(place, block) => {
                self.blocks.insert(*block);
                place
            }
            _ => return,
        };
        match instance_variable(place) {
            Some(id) => _ = self.found.variables.insert(id),
            None => self.found.through_reference = true,
        }
    }

    fn begins(&mut self, one: &Statement) {
        if let StatementKind::Copy(target, _) | StatementKind::Assign(target, _) = &one.kind {
            self.copied.insert(target.ty);
        }
    }
}

/// The variable at the end of a path to an instance. `None` if a reference leads to it, or no variable is named.
pub(super) fn instance_variable(place: &Place) -> Option<VarId> {
    let mut id = match place.root {
        Root::Variable(id) => Some(id),
        _ => None,
    };
    for step in &place.steps {
        match step {
            Step::Member(member) => id = Some(*member),
            Step::Dereference => id = None,
            _ => {}
        }
    }
    id
}

//! The instances of which a call gives EN.

use scanbound_iec::Section;
use scanbound_iec_tree::charts::{ActionBody, Code};
use scanbound_iec_tree::declarations::VarId;
use scanbound_iec_tree::tree::{
    Place, Root, Statement, StatementKind, Step, Target, Tree, each_statement,
};
use scanbound_ir::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::slice::from_ref;

/// Instances of which a call gives EN.
#[derive(Default)]
pub(super) struct EnabledInstances {
    /// The variables that they are.
    pub(super) variables: BTreeSet<VarId>,
    /// Whether one is called through a reference, so that it may be any.
    pub(super) through_reference: bool,
    /// By where an instance lies, the bit that says that EN was false; none without room.
    pub(super) cells: BTreeMap<[Cell; 2], Option<Cell>>,
}

impl EnabledInstances {
    pub(super) fn of(tree: &Tree) -> EnabledInstances {
        let mut found = EnabledInstances::default();
        tree.routines.iter().for_each(|one| found.of_code(tree, &one.code));
        found
    }

    fn of_code(&mut self, tree: &Tree, code: &Code) {
        match code {
            Code::Statements(all) => self.of_statements(tree, all),
            Code::Chart(chart) => {
                for hooks in &chart.steps {
                    let all = [&hooks.entry, &hooks.active, &hooks.exit];
                    all.into_iter()
                        .flatten()
                        .for_each(|one| self.of_statements(tree, from_ref(one)));
                }
                for action in &chart.actions {
                    match &action.body {
                        ActionBody::Inline(.., code) => self.of_code(tree, code),
                        ActionBody::Call(one) | ActionBody::Computed(one, _) => {
                            self.of_statements(tree, from_ref(one));
                        }
                        ActionBody::Variable(_) => {}
                    }
                }
            }
            Code::Unread(_) => {}
        }
    }

    fn of_statements(&mut self, tree: &Tree, all: &[Statement]) {
        each_statement(all, &mut |one| {
            if let StatementKind::Call(call) = &one.kind
                && let Target::Instance(place, _) | Target::Standard(place, _) = &call.target
                && call.enable.condition.is_some()
            {
                match instance_variable(tree, place) {
                    Some(id) => _ = self.variables.insert(id),
                    None => self.through_reference = true,
                }
            }
        });
    }
}

/// The variable that an instance is. `None` if a reference leads to it, or it is passed in and out.
pub(super) fn instance_variable(tree: &Tree, place: &Place) -> Option<VarId> {
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
    id.filter(|&id| tree.variable(id).section != Section::InOut)
}

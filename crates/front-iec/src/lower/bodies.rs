//! Which bodies a project has.

use scanbound_iec::Language;
use scanbound_iec_tree::charts::ActionBody;
use scanbound_iec_tree::declarations::{Code, RoutineId, RoutineKind};
use scanbound_iec_tree::tree::Tree;
use std::collections::BTreeMap;

/// A routine, or what stands in a block of one that is a chart, by the number of the action there.
pub(super) type BodyKey = (RoutineId, Option<usize>);

/// Numbers of bodies.
pub(super) type Bodies = BTreeMap<BodyKey, usize>;

/// The bodies of a project; the conditions of transitions belong to their charts.
pub(super) fn bodies(tree: &Tree, found: &mut scanbound_ir::Statements) -> Bodies {
    let mut numbers = Bodies::new();
    let mut add = |at, name, language: Language, code: &Code| {
        if !code.is_empty() {
            numbers.insert(at, found.bodies.len());
            let unreadable = match code {
                Code::Unread(fault) => Some(fault.message.clone()),
                Code::Statements(_) | Code::Chart(_) => None,
            };
            let language = language.name();
            found.bodies.push(scanbound_ir::Body { name, language, is_called: false, unreadable });
        }
    };
    for (at, routine) in tree.routines.iter().enumerate() {
        let (id, unit) = (RoutineId::at(at), &tree.unit(routine.unit).name);
        let name = match routine.kind {
            RoutineKind::Body => unit.clone(),
            RoutineKind::Action | RoutineKind::Method => format!("{unit}.{}", routine.name),
        };
        if let Code::Chart(chart) = &routine.code {
            for (number, action) in chart.actions.iter().enumerate() {
                if let ActionBody::Inline(language, code) = &action.body {
                    let name = format!("{name}.{}", action.name);
                    add((id, Some(number)), name, *language, code);
                }
            }
        }
        add((id, None), name, routine.language, &routine.code);
    }
    numbers
}

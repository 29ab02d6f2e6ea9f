//! Numbers the bodies of a project, so that their statements can be counted.

use scanbound_iec::Language;
use scanbound_iec_tree::charts::ActionBody;
use scanbound_iec_tree::declarations::{Code, RoutineId, RoutineKind};
use scanbound_iec_tree::tree::Tree;
use std::collections::BTreeMap;

/// Identifies a body: a routine (None), or the inline code of a chart's action, by the action's number in the chart.
pub(super) type BodyKey = (RoutineId, Option<usize>);

/// The index of each body in the list of bodies.
pub(super) type Bodies = BTreeMap<BodyKey, usize>;

/// Lists the bodies that have code, and numbers them. Conditions of transitions belong to the body of their chart.
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

//! Which bodies a project has, and what is known of their statements while a program is put together.

use scanbound_iec::chart::{Chart, Target};
use scanbound_iec::{Body, Pou, Project};
use std::collections::BTreeMap;

/// What is counted while a program is put together.
#[derive(Default)]
pub(crate) struct Tally {
    /// Bodies that are known, by where they lie in memory.
    pub(crate) bodies: BTreeMap<usize, usize>,
    /// Statements that are known, by their body and their number there.
    pub(crate) known: BTreeMap<(usize, u32), usize>,
    /// The body that is put together.
    pub(crate) current: Option<Current>,
}

/// A body that is put together.
#[derive(Clone, Copy)]
pub(crate) struct Current {
    pub(crate) body: usize,
    /// The number of its next statement.
    pub(crate) next: u32,
    /// Whether it is drawn or a list, so that values are kept between its statements.
    pub(crate) keeps: bool,
    /// Where the instructions begin that keep a value for the next statement, and in which line.
    pub(crate) kept_from: Option<(usize, u32)>,
    /// Whether what is put together stands in a statement that counts for all in it.
    pub(crate) is_within: bool,
}

/// Where a body lies in memory: it is the same one throughout.
pub(crate) fn key(body: &Body) -> usize {
    std::ptr::from_ref(body).addr()
}

/// The bodies of a unit, with their names.
fn bodies<'p>(pou: &'p Pou, name: &str, see: &mut dyn FnMut(String, &'p Body)) {
    one(&pou.body, name.to_owned(), see);
    for action in &pou.actions {
        one(&action.body, format!("{name}.{}", action.name), see);
    }
    for method in &pou.methods {
        bodies(method, &format!("{name}.{}", method.name), see);
    }
}

fn one<'p>(body: &'p Body, name: String, see: &mut dyn FnMut(String, &'p Body)) {
    if let Body::Chart(chart) = body {
        blocks(chart, &name, see);
    }
    if !body.is_empty() {
        see(name, body);
    }
}

fn blocks<'p>(chart: &'p Chart, name: &str, see: &mut dyn FnMut(String, &'p Body)) {
    for block in chart.steps.iter().flat_map(|step| &step.blocks) {
        if let Target::Inline(own, body) = &block.target {
            one(body, format!("{name}.{own}"), see);
        }
    }
}

impl Tally {
    /// The bodies of a project; the conditions of transitions belong to their charts.
    pub(crate) fn of(project: &Project, found: &mut scanbound_ir::Statements) -> Tally {
        let mut tally = Tally::default();
        for pou in &project.pous {
            bodies(pou, &pou.name, &mut |name, body| {
                let unread = match body {
                    Body::Unread(_, fault) => Some(fault.message.clone()),
                    _ => None,
                };
                let language = body.language().name();
                tally.bodies.insert(key(body), found.bodies.len());
                found.bodies.push(scanbound_ir::Body {
                    name,
                    language,
                    is_called: false,
                    unreadable: unread,
                });
            });
        }
        tally
    }
}

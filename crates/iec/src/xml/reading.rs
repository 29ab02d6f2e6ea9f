//! The state while the bodies of one unit are read.

use super::node::{Text, elements};
use crate::chart::COMPUTED;
use crate::drawing::{Connection, Drawing, Goal};
use crate::fault::Fault;
use crate::{Body, Language, Named, Pou, same};
use roxmltree::Node;

/// Reads the bodies of one unit or of one of its actions or transitions.
pub(super) struct Reading<'t, 'p> {
    pub(super) text: &'t Text,
    pub(super) pou: &'p mut Pou,
    /// The unit with the action or transition that is read: its name for messages, and the name of the part within the
    /// unit.
    pub(super) place: String,
    pub(super) part: String,
    pub(super) faults: Vec<Fault>,
    /// Whether the blocks in drawn conditions are executed by the action [`COMPUTED`].
    pub(super) computes: bool,
}

impl<'t, 'p> Reading<'t, 'p> {
    pub(super) fn new(text: &'t Text, pou: &'p mut Pou, part: &str) -> Reading<'t, 'p> {
        let place = if part.is_empty() { pou.name.clone() } else { format!("{}.{part}", pou.name) };
        Reading { text, pou, place, part: part.to_owned(), faults: Vec::new(), computes: false }
    }

    /// Runs `read` for a drawing with its own numbering of elements, under a name of its own within the part.
    pub(super) fn apart<T>(&mut self, name: &str, read: impl FnOnce(&mut Self) -> T) -> T {
        let part = format!("{}{}{name}", self.part, if self.part.is_empty() { "" } else { "_" });
        let outer = std::mem::replace(&mut self.part, part);
        let found = read(self);
        self.part = outer;
        found
    }

    /// Whether the unit has an action or a variable of this name.
    pub(super) fn declares(&self, name: &str) -> bool {
        let actions = self.pou.actions.iter().map(|one| &one.name);
        actions.chain(self.pou.variables.iter().map(|one| &one.name)).any(|own| same(own, name))
    }

    /// Whether the unit has an action of this name.
    pub(super) fn has_action(&self, name: &str) -> bool {
        self.pou.actions.iter().any(|own| same(&own.name, name))
    }

    /// Adds a fault that makes the whole file unusable.
    pub(super) fn refuse(&mut self, fault: Fault) {
        let fault = fault.within(&self.place);
        self.faults.push(fault);
    }

    /// Adds a drawn condition to the action that executes the blocks of conditions. Blocks shared by several conditions
    /// of a drawing are executed once.
    pub(super) fn compute(&mut self, part: String, from: Vec<Connection>, drawing: &Drawing) {
        let own = self.pou.actions.iter_mut().find(|one| one.name == COMPUTED && one.line == 0);
        let mut all = match own.map(|one| &mut one.body) {
            Some(Body::Drawn(_, all)) => Some(all),
            _ => None,
        };
        let mut goals =
            all.iter_mut().flat_map(|all| all.iter_mut().filter_map(|one| one.goal.as_mut()));
        if let Some(goal) = goals.find(|goal| goal.part == part) {
            goal.from.push(from);
            return;
        }
        let drawing = Drawing { goal: Some(Goal { part, from: vec![from] }), ..drawing.clone() };
        match all {
            Some(all) => all.push(drawing),
            None => {
                let body = Body::Drawn(Language::Fbd, vec![drawing]);
                self.pou.actions.push(Named { name: COMPUTED.to_owned(), body, line: 0 });
            }
        }
    }
}

/// The language of a body and its element; `None` if there is none.
pub(super) fn language<'a, 'i>(node: Node<'a, 'i>) -> Option<(Language, Node<'a, 'i>)> {
    elements(node).find_map(|inner| {
        let language = match inner.tag_name().name() {
            "ST" => Language::St,
            "IL" => Language::Il,
            "LD" => Language::Ld,
            "FBD" => Language::Fbd,
            "SFC" => Language::Sfc,
            _ => return None,
        };
        Some((language, inner))
    })
}

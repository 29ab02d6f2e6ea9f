//! What keeps its values when the power fails.

use super::emit::{Emit, Instance};
use super::resolve::full_name;
use super::types::lineage;
use scanbound_iec::same;

impl Emit<'_> {
    /// Whether an instance keeps what it holds when the power fails: it, or one that it stands in, is declared so.
    pub(super) fn is_retained(&self, instance: usize) -> bool {
        let Instance { pou, place } = &self.instances[instance];
        let own = place.name.to_ascii_uppercase();
        let ends = own.match_indices(['.', '[']).map(|(at, _)| at).chain([own.len()]);
        self.project.retains(*pou)
            || ends.into_iter().any(|end| self.is_declared_retained(&own[..end]))
    }

    /// Whether a global variable, a program or a part of an instance of this name, in capitals, is declared so.
    fn is_declared_retained(&self, name: &str) -> bool {
        let globals = self.project.globals.iter();
        let mut globals = globals.flat_map(|(list, all)| all.iter().map(move |one| (list, one)));
        let instance = |name: &str| self.by_name.get(name).map(|&at| &self.instances[at]);
        let is_part = || {
            let (outer, part) = name.rsplit_once('.')?;
            let all = lineage(self.project, instance(outer)?.pou).into_iter();
            Some(all.flat_map(|pou| &pou.variables).any(|one| one.retain && same(&one.name, part)))
        };
        globals.any(|(list, one)| one.retain && same(&full_name(list, one), name))
            || instance(name).is_some_and(|outer| self.project.retains(outer.pou))
            || is_part().unwrap_or(false)
    }
}

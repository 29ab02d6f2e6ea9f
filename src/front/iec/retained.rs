//! What keeps its values when the power fails.

use super::emit::{Emit, Instance};
use super::resolve::full_name;
use super::types::lineage;

impl Emit<'_> {
    /// Whether an instance keeps what it holds when the power fails: it, or one that it stands in, is declared so.
    pub(super) fn is_retained(&self, instance: usize) -> bool {
        let Instance { pou, place } = &self.instances[instance];
        let own = place.name.to_ascii_uppercase();
        let stands_in = |name: String| {
            let rest = own.strip_prefix(&name.to_ascii_uppercase());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        let globals = self.project.globals.iter();
        let mut globals = globals.flat_map(|(list, all)| all.iter().map(move |one| (list, one)));
        let mut parts = self.instances.iter().flat_map(|outer| {
            let units = lineage(self.project, outer.pou).into_iter();
            let all = units.flat_map(|pou| &pou.variables).filter(|one| one.retain);
            all.map(move |one| format!("{}.{}", outer.place.name, one.name))
        });
        let programs = || {
            let all = self.instances.iter().filter(|outer| self.project.retains(outer.pou));
            all.map(|outer| outer.place.name.clone())
        };
        self.project.retains(*pou)
            || globals.any(|(list, one)| one.retain && stands_in(full_name(list, one)))
            || parts.any(stands_in)
            || programs().any(stands_in)
    }
}

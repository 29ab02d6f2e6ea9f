//! Lists of global variables named after their files, as in CODESYS and TwinCAT: `GVL.Level`.

use super::parse::file_stem;
use super::{Project, same};
use std::collections::{BTreeMap, BTreeSet};

impl Project {
    /// Names unnamed lists after their files if lists of two files declare different variables of one name, so that
    /// `list.name` is unambiguous. Only the lists of such files are named; none, if one of the names is unknown or
    /// already in use.
    pub fn name_lists(&mut self) {
        let mut named = BTreeMap::new();
        let mut differ = BTreeSet::new();
        for (number, (list, all)) in self.globals.iter().enumerate() {
            for one in all.iter().filter(|_| list.is_empty()) {
                let file = self.file_of_list(number);
                let key = one.name.to_ascii_uppercase();
                let (first_file, first) = *named.entry(key).or_insert((file, one));
                if first_file != file && first != one {
                    differ.extend([first_file, file]);
                }
            }
        }
        let name = |file: usize| file_stem(&self.files[file]).to_owned();
        let has_list = |name: &str| self.lists.iter().any(|(list, _)| same(list, name));
        if !differ.iter().all(|&file| has_list(&name(file)) && !self.has_name(&name(file))) {
            return;
        }
        let names: BTreeMap<usize, String> =
            differ.iter().map(|&file| (file, name(file))).collect();
        self.lists.retain(|(list, _)| !names.values().any(|own| same(own, list)));
        for number in 0..self.globals.len() {
            let Some(own) = names.get(&self.file_of_list(number)) else { continue };
            if self.globals[number].0.is_empty() {
                self.globals[number].0.clone_from(own);
            }
        }
    }

    /// Whether a variable, action, method, unit, type, named list or program instance has this name.
    #[must_use]
    pub fn has_name(&self, name: &str) -> bool {
        let units = self.pous.iter().flat_map(|pou| pou.methods.iter().chain([pou]));
        let variables = units.clone().flat_map(|pou| &pou.variables);
        let globals = self.globals.iter().flat_map(|(_, all)| all);
        let tasks = self.tasks.iter().flat_map(|task| &task.instances);
        variables.chain(globals).any(|one| same(&one.name, name))
            || units.flat_map(|pou| &pou.actions).any(|one| same(&one.name, name))
            || self.pous.iter().flat_map(|pou| &pou.methods).any(|one| same(&one.name, name))
            || self.pous.iter().any(|pou| same(&pou.name, name))
            || self.types.iter().any(|one| same(&one.name, name))
            || self.globals.iter().any(|(list, _)| same(list, name))
            || { tasks }.any(|(own, _)| same(own, name))
    }
}

//! The names that a new step of a chart must not take.

use super::Target;
use crate::{Pou, Project, TypeRef};
use std::collections::BTreeSet;

/// Names that are taken, whether they are written in upper or lower case.
#[derive(Debug, Clone, Default)]
pub struct Taken(BTreeSet<String>);

impl Taken {
    /// Those that a unit gives: to variables, actions, transitions, methods and steps.
    #[must_use]
    pub fn of(pou: &Pou) -> Taken {
        let mut taken = Taken::default();
        taken.unit(pou);
        taken
    }

    /// Those, and the names of types, units and global variables.
    #[must_use]
    pub fn around(project: &Project, pou: &Pou) -> Taken {
        let mut taken = Taken::of(pou);
        for one in &project.types {
            taken.add(&one.name);
            if let TypeRef::Enumeration(values, _) = &one.of {
                values.iter().for_each(|(name, _)| taken.add(name));
            }
        }
        for (list, variables) in &project.globals {
            taken.add(list);
            variables.iter().for_each(|one| taken.add(&one.name));
        }
        project.pous.iter().for_each(|one| taken.add(&one.name));
        taken
    }

    fn unit(&mut self, pou: &Pou) {
        self.add(&pou.name);
        pou.variables.iter().for_each(|one| self.add(&one.name));
        pou.actions.iter().chain(&pou.transitions).for_each(|one| self.add(&one.name));
        for (_, chart) in pou.charts() {
            for step in &chart.steps {
                self.add(&step.name);
                for block in &step.blocks {
                    // Also a name that nothing declares may be a variable's.
                    match &block.target {
                        Target::Path(path) => self.add(&path.first),
                        Target::Inline(name, _) => self.add(name),
                    }
                }
            }
            chart.macros.iter().for_each(|one| self.add(&one.name));
        }
        for method in &pou.methods {
            self.unit(method);
        }
    }

    /// Takes a name.
    pub fn add(&mut self, name: &str) {
        self.0.insert(name.to_ascii_lowercase());
    }

    /// Takes a free name: the wanted one, else that with a number.
    pub fn free(&mut self, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        let mut number = 2;
        while self.0.contains(&name.to_ascii_lowercase()) {
            name = format!("{wanted}{number}");
            number += 1;
        }
        self.add(&name);
        name
    }
}

//! Names that are in use, so that new steps of a chart get other ones.

use super::Target;
use crate::{Pou, Project, TypeRef};
use std::collections::BTreeSet;

/// A set of names in use, ignoring case.
#[derive(Debug, Clone, Default)]
pub struct Taken(BTreeSet<String>);

impl Taken {
    /// The names that a unit declares or uses: its own, and those of its variables, actions, transitions, methods,
    /// steps and action blocks.
    #[must_use]
    pub fn of(pou: &Pou) -> Taken {
        let mut taken = Taken::default();
        taken.unit(pou);
        taken
    }

    /// The names of [`Taken::of`], and those of the project's types, enumeration values, units and global variables.
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
                    // An undeclared name may be that of a variable.
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

    /// Marks a name as used.
    pub fn add(&mut self, name: &str) {
        self.0.insert(name.to_ascii_lowercase());
    }

    /// Returns an unused name and marks it as used: `wanted`, or `wanted` with a number from 2 on.
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

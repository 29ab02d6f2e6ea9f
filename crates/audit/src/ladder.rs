//! A project's rungs as they are drawn, with what each of their instructions does in the longest scan.

use super::pipeline::Concluded;
use super::{Audit, ChargeUse, comments_in};
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::ladder::{Rung, rungs};
use std::collections::HashMap;
use std::sync::Arc;

/// All rungs of a project.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Ladder {
    /// In the order of the source.
    pub rungs: Vec<Drawn>,
}

/// A rung and what is told of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawn {
    /// The rung.
    pub rung: Rung,
    /// What is told of each of its elements.
    pub told: Vec<Told>,
}

/// What is told of an instruction.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Told {
    /// Its devices and what people call them.
    pub comments: Vec<String>,
    /// What its executions do.
    pub uses: Uses,
}

/// What the executions of an instruction do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Uses {
    /// How many executions have a time.
    pub timed: u64,
    /// How many of them control reaches in the longest scan that was found.
    pub reached: u64,
    /// How many of them run there: of a contact, conduct.
    pub runs: u64,
    /// Their part in the bound, without the table's factor.
    pub share: Picos,
    /// What they would take at the dearer of their times, without the factor likewise.
    pub most: Picos,
}

impl Uses {
    fn add(&mut self, charge: &ChargeUse) {
        self.timed += 1;
        self.reached += u64::from(charge.reached);
        self.runs += u64::from(charge.runs);
        self.share += charge.share;
        self.most += charge.on.max(charge.off);
    }
}

impl Drawn {
    /// What all of its instructions do.
    #[must_use]
    pub fn uses(&self) -> Uses {
        self.told.iter().fold(Uses::default(), |all, Told { uses, .. }| Uses {
            timed: all.timed + uses.timed,
            reached: all.reached + uses.reached,
            runs: all.runs + uses.runs,
            share: all.share + uses.share,
            most: all.most + uses.most,
        })
    }
}

impl Ladder {
    /// The rungs of what was audited.
    #[must_use]
    pub fn of(concluded: &Concluded) -> Ladder {
        let program = &concluded.followed.program;
        let audit = &concluded.audit;
        let mut uses = uses(audit);
        let drawn = |rung: Rung| {
            let told = rung.elements.iter().map(|element| Told {
                comments: comments_in(program, &program.instructions[element.parts.start]),
                uses: uses
                    .remove(&(element.at, element.text.clone()))
                    .map(|uses| Uses {
                        share: audit.bare(uses.share),
                        most: audit.bare(uses.most),
                        ..uses
                    })
                    .unwrap_or_default(),
            });
            Drawn { told: told.collect(), rung }
        };
        Ladder { rungs: rungs(program).into_iter().map(drawn).collect() }
    }
}

/// What the executions of each instruction do, by its place and text.
fn uses(audit: &Audit) -> HashMap<(Location, Arc<str>), Uses> {
    let mut all: HashMap<(Location, Arc<str>), Uses> = HashMap::new();
    let guarded = audit.groups.iter().flat_map(|group| &group.charges);
    for charge in guarded.chain(&audit.always) {
        all.entry((charge.at, charge.instruction.clone())).or_default().add(charge);
    }
    all
}

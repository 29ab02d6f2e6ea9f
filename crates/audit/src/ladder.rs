//! A project's rungs for drawing, with what each of their instructions does in the longest scan.

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

/// A rung, and the notes on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawn {
    /// The rung.
    pub rung: Rung,
    /// The notes on each of its elements.
    pub told: Vec<Told>,
}

/// The notes on an instruction.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Told {
    /// Its devices and their comments.
    pub comments: Vec<String>,
    /// What its executions do.
    pub uses: Uses,
}

/// What the executions of an instruction do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Uses {
    /// How many executions have a time.
    pub timed: u64,
    /// How many of them are reached in the longest scan found.
    pub reached: u64,
    /// How many of them run there. A contact runs if it conducts.
    pub runs: u64,
    /// Their part of the bound, without the table's factor.
    pub share: Picos,
    /// The sum of the larger of their two times, without the factor.
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
    /// The sum over all of its instructions.
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
    /// The rungs of an audited project.
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

//! Collects a project's rungs for drawing, with what each of their instructions does in the longest scan found.

pub use super::drawn::{DrawnRung, Ladder, Notes, Uses};
use super::pipeline::Concluded;
use super::{Audit, comments_in};
use scanbound_base::location::Location;
use scanbound_ir::ladder::{Rung, rungs};
use std::collections::HashMap;
use std::sync::Arc;

impl Ladder {
    /// The rungs of an audited project in source order, with the comments of their operands and what their instructions
    /// do in the longest scan found.
    #[must_use]
    pub fn of(concluded: &Concluded) -> Ladder {
        let program = &concluded.followed.program;
        let audit = &concluded.audit;
        let mut uses = uses(audit);
        let drawn = |rung: Rung| {
            let notes = rung.elements.iter().map(|element| Notes {
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
            DrawnRung { notes: notes.collect(), rung }
        };
        Ladder { rungs: rungs(program).into_iter().map(drawn).collect() }
    }
}

/// What the executions of each instruction with a time do in the longest scan found, by place and text of the
/// instruction. Times include the table's factor.
fn uses(audit: &Audit) -> HashMap<(Location, Arc<str>), Uses> {
    let mut all: HashMap<(Location, Arc<str>), Uses> = HashMap::new();
    let guarded = audit.groups.iter().flat_map(|group| &group.charges);
    for charge in guarded.chain(&audit.always) {
        all.entry((charge.at, charge.instruction.clone())).or_default().add(charge);
    }
    all
}

//! Rungs as they are drawn.

use super::parts::ChargeUse;
use scanbound_base::time::Picos;
use scanbound_ir::ladder::Rung;

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
    pub notes: Vec<Notes>,
}

/// The notes on an instruction.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notes {
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
    pub(super) fn add(&mut self, charge: &ChargeUse) {
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
        self.notes.iter().fold(Uses::default(), |all, Notes { uses, .. }| Uses {
            timed: all.timed + uses.timed,
            reached: all.reached + uses.reached,
            runs: all.runs + uses.runs,
            share: all.share + uses.share,
            most: all.most + uses.most,
        })
    }
}

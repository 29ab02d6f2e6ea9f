//! Rungs as they are drawn.

use super::parts::ChargeUse;
use scanbound_base::time::Picos;
use scanbound_ir::ladder::Rung;

/// All rungs of a project.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Ladder {
    /// The rungs, in the order of the source.
    pub rungs: Vec<DrawnRung>,
}

/// A rung, and the notes on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrawnRung {
    /// The rung.
    pub rung: Rung,
    /// The notes on each element of the rung.
    pub notes: Vec<Notes>,
}

/// The notes on an instruction.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notes {
    /// The devices of the instruction and their comments.
    pub comments: Vec<String>,
    /// What the executions of the instruction do in the longest scan found.
    pub uses: Uses,
}

/// What the executions of an instruction do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Uses {
    /// The number of executions that have a time.
    pub timed: u64,
    /// The number of these executions that control reaches in the longest scan found.
    pub reached: u64,
    /// The number of these executions that fire in the longest scan found. A contact fires if it conducts.
    pub runs: u64,
    /// The part of the bound that these executions take, without the table's factor.
    pub share: Picos,
    /// The sum, over these executions, of the larger of on-time and off-time, without the table's factor.
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

impl DrawnRung {
    /// The sum over all instructions of the rung.
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

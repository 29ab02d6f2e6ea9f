//! Rungs for drawing, with notes on what each instruction does in the longest scan found.

use super::parts::ChargeUse;
use scanbound_base::time::Picos;
use scanbound_ir::ladder::Rung;

/// All rungs of a project, for drawing.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Ladder {
    /// The rungs, in the order of the source.
    pub rungs: Vec<DrawnRung>,
}

/// A rung, and the notes on its instructions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrawnRung {
    /// The rung.
    pub rung: Rung,
    /// The notes on each instruction of the rung, in the order of `Rung::elements`.
    pub notes: Vec<Notes>,
}

/// The notes on an instruction.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notes {
    /// The operands of the instruction that have a comment, each with its comment.
    pub comments: Vec<String>,
    /// What the executions of the instruction do in the longest scan found.
    pub uses: Uses,
}

/// What the executions of an instruction, or of all instructions of a rung, do in the longest scan found. An
/// instruction has one execution for each call context.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Uses {
    /// The number of executions that have a time in the model, whether the scan reaches them or not.
    pub timed: u64,
    /// The number of the executions counted in `timed` that control reaches in the longest scan found.
    pub reached: u64,
    /// The number of the executions counted in `timed` that fire in the longest scan found. A contact fires if it
    /// conducts.
    pub runs: u64,
    /// The part of the bound that the executions counted in `timed` take, without the table's factor.
    pub share: Picos,
    /// The sum, over the executions counted in `timed`, of the larger of on-time and off-time, without the table's
    /// factor.
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
    /// The sums of the uses of all instructions of the rung.
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

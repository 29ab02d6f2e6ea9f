//! The model of one scan: its charges (executed instructions with their times), the guards that say whether each is
//! reached and fires, the free variables, and the constraints on these variables. It is the only interface between the
//! analysis and the solver.

mod circuit;
pub mod groups;
mod havocs;
pub mod lower_bound;
mod shared;

pub use circuit::{Assignment, Atom, Circuit, Lit, Node, Values, VarId};
pub use havocs::{Coverage, ExecutedHavocs, Havoc, Havocs};
pub use shared::Shared;

use scanbound_base::time::Picos;
use scanbound_ir::{Cell, ChoiceId, ChoiceKey, Frame, Resolutions};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The type of a free variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum VarKind {
    /// A bit, tested with [`Atom::Bit`].
    Bit,
    /// A word of sixteen bits, tested with [`Atom::AtLeast`] (unsigned) and [`Atom::WordBit`].
    Word,
}

/// What a free variable stands for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// The value of a cell at the start of the scan.
    Start(Cell),
    /// A choice of the program (a nondeterministic value) in one call context.
    Choice(ChoiceKey),
    /// The value that a cell got from a havoc: from the last one that the scan executes and that may write the cell,
    /// among the havocs of the cell's area in [`ScanModel::havocs`] with the numbers `since` to `until` (exclusive).
    Havocked {
        /// The cell that the variable stands for.
        cell: Cell,
        /// The number of the first havoc of the range, counted from 0 within the cell's area.
        since: u32,
        /// The number after that of the last havoc of the range, counted in the same way.
        until: u32,
    },
}

/// A havoc for which it is unknown which cells it writes: a write through an unknown index, or a write to any cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownWrite {
    /// The instruction, an index into `Program::instructions`.
    pub instruction: usize,
    /// The choice that stands for the written values. All executions with this choice are one entry.
    pub choice: ChoiceId,
    /// Whether the written cells are unknown because an index selects them.
    pub has_index: bool,
    /// The number of times that the symbolic execution of a scan may execute the write: once for each call context and
    /// path.
    pub executions: u32,
    /// Whether, in at least one of the first executions, the index depends on no other unknown write, as far as
    /// examined.
    pub is_independent: bool,
    /// The largest number of values that the index may have in such an execution.
    pub most_values: i64,
    /// Cells whose values at the start of the scan may be the index, or part of it, as far as examined.
    pub start_cells: BTreeSet<Cell>,
    /// The choices of other unknown writes from which the index may come, as far as examined.
    pub depends_on: BTreeSet<ChoiceId>,
}

/// A free variable of the model: a bit or word whose value nothing in the model determines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    /// Whether the variable is a bit or a word.
    pub kind: VarKind,
    /// What the variable stands for.
    pub origin: Origin,
    /// The name of the variable in reports (`X1F`, `D100`, `T0 contact`, `M5 behind line 40`).
    pub name: String,
}

/// One execution of one instruction, and its time: `on` if `fires`, else `off` if `reached`, else nothing. `fires`
/// implies `reached`. If the model determines the number of units, `on` is the time with the most units, and `counted`
/// gives the actual time. A loop that is not followed has charges that stand for many executions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Charge {
    /// The instruction, an index into `Program::instructions`.
    pub instruction: usize,
    /// The call context: calls, loop iterations and interrupts on the path to the instruction.
    pub frames: Vec<Frame>,
    /// The literal that says whether control reaches the instruction.
    pub reached: Lit,
    /// The literal that says whether the instruction is reached and fires.
    pub fires: Lit,
    /// The time if the instruction fires, with the most units and all repetitions.
    pub on: Picos,
    /// The time if control reaches the instruction but it does not fire.
    pub off: Picos,
    /// The on-time by number of units; `None` if the model does not determine this number.
    pub counted: Option<Box<ByUnits>>,
}

/// The on-time of a charge by its number of units.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ByUnits {
    /// The on-time without the times of `units`.
    pub base: Picos,
    /// The time that each literal adds if it is true. Each literal implies that the charge fires.
    pub units: Vec<(Lit, Picos)>,
}

impl Charge {
    /// The larger of the on-time and the off-time.
    #[must_use]
    pub fn largest_cost(&self) -> Picos {
        self.on.max(self.off)
    }

    /// The time of the charge in the scan in which the circuit's nodes have these values.
    #[must_use]
    pub fn cost(&self, values: &Values) -> Picos {
        self.cost_by(|lit| values.get(lit))
    }

    /// The time of the charge in a scan in which `value` gives the values of its literals.
    #[must_use]
    pub fn cost_by(&self, value: impl Fn(Lit) -> bool) -> Picos {
        match (value(self.fires), value(self.reached)) {
            (true, _) => {
                let (base, units) = self.cost_if_fired();
                let handled = units.iter().filter(|(handled, _)| value(*handled));
                base + handled.map(|(_, more)| *more).sum()
            }
            (false, true) => self.off,
            (false, false) => Picos::ZERO,
        }
    }

    /// Whether the time is the same in every scan, as far as constant literals and equal times show.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.guards().next().is_none()
    }

    /// The literals on which the time of the charge depends, without constants.
    pub fn guards(&self) -> impl Iterator<Item = Lit> + '_ {
        let matters = |guard: &Lit| {
            !guard.is_constant()
                && (self.fires_matters() || *guard != self.fires || *guard == self.reached)
        };
        self.literals().filter(matters)
    }

    /// Whether the on-time and the off-time differ, or the on-time depends on a number of units.
    #[must_use]
    pub fn fires_matters(&self) -> bool {
        self.on != self.off || self.counted.is_some()
    }

    /// All literals of the charge, including constants and those that do not affect the time.
    pub fn literals(&self) -> impl Iterator<Item = Lit> + '_ {
        let units = self.cost_if_fired().1.iter().map(|(handled, _)| *handled);
        [self.reached, self.fires].into_iter().chain(units)
    }

    /// The time if the charge fires: the part without units, and the times that literals add.
    #[must_use]
    pub fn cost_if_fired(&self) -> (Picos, &[(Lit, Picos)]) {
        match self.counted.as_deref() {
            None => (self.on, &[]),
            Some(ByUnits { base, units }) => (*base, units),
        }
    }
}

/// A place at which the scan enters an unbounded loop, if control reaches it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unbounded {
    /// The instruction, an index into `Program::instructions`.
    pub instruction: usize,
    /// The call context: calls, loop iterations and interrupts on the path to the loop.
    pub frames: Vec<Frame>,
    /// The literal that says whether control reaches the loop.
    pub reached: Lit,
}

/// The model of one scan.
#[derive(Debug, Clone, Default)]
pub struct ScanModel {
    /// The circuit in which guards and constraints are literals.
    pub circuit: Circuit,
    /// The free variables; a [`VarId`] is an index into them.
    pub variables: Vec<Variable>,
    /// The charges in order of execution. Instructions whose times are 0 have none.
    pub charges: Vec<Charge>,
    /// Literals that are true in every scan.
    pub constraints: Vec<Lit>,
    /// In a model for lower bounds: literals, each of which is true if an operation error may end the scan at one
    /// place, in the order of execution.
    pub errors: Vec<Lit>,
    /// The havocs in order of execution.
    pub havocs: Havocs,
    /// In a model for upper bounds: the free words from which the numbers of iterations of loops that are not followed
    /// are computed, as far as examined.
    pub count_variables: BTreeSet<VarId>,
    /// The havocs for which it is unknown which cells they write, one entry for each choice, in the order of their
    /// first executions.
    pub unknown_writes: Vec<UnknownWrite>,
    /// The places at which a scan enters an unbounded loop.
    pub unbounded: Vec<Unbounded>,
    /// In a model for upper bounds, for loops that are not followed, by the index of their instruction: the largest
    /// number of iterations that the word with their count and the loop's own limits allow, over all times that control
    /// may reach them.
    pub iterations: BTreeMap<usize, u32>,
    /// The numbers of iterations of loops that are not followed, one entry for each time that control may reach a loop.
    /// Only in a model for upper bounds that was built with results of real runs
    /// ([`Knowledge`](scanbound_ir::meaning::Knowledge)); otherwise empty.
    pub loop_counts: Vec<LoopCount>,
    /// Which choices the analysis replaced by computed results or limited to fewer cells, by call context.
    pub resolutions: Arc<Resolutions>,
}

/// The number of iterations of a loop that is not followed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoopCount {
    /// The loop's instruction, an index into `Program::instructions`.
    pub instruction: usize,
    /// The literal that says whether control reaches the loop.
    pub reached: Lit,
    /// The number of iterations as a signed number, least significant bit first.
    pub bits: [Lit; 16],
    /// The number of iterations that the loop may make even if `bits` is a smaller number. [`u32::MAX`] if the count is
    /// not the signed number in `bits`, so that it is not limited.
    pub least: u32,
}

/// A group: charges that share free variables, directly or through other charges. Two groups have no free variable in
/// common.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Group {
    /// Indices into `ScanModel::charges`, ascending. Charges with a constant time are in no group.
    pub charges: Vec<usize>,
    /// The free variables on which the charges depend, through guards or constraints, ascending.
    pub variables: Vec<VarId>,
    /// Indices into `ScanModel::constraints`: the constraints on the group's variables.
    pub constraints: Vec<usize>,
}

/// Values of the variables of one group, ascending by variable, without values of other variables. There may be as many
/// groups as variables, so a full assignment for each group would take too much memory.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GroupAssignment(pub Vec<(VarId, u16)>);

impl GroupAssignment {
    /// Copies these values into an assignment of all variables.
    pub fn copy_to(&self, all: &mut Assignment) {
        for &(variable, value) in &self.0 {
            all.0[variable.0 as usize] = value;
        }
    }

    /// The assignment with these values, and 0 for all other variables.
    #[must_use]
    pub fn complete(&self, model: &ScanModel) -> Assignment {
        let mut all = Assignment(vec![0; model.variables.len()]);
        self.copy_to(&mut all);
        all
    }
}

impl ScanModel {
    /// The total time of these charges (indices into [`ScanModel::charges`]) in the scan with this assignment.
    #[must_use]
    pub fn cost(&self, charges: &[usize], assignment: &Assignment) -> Picos {
        let values = self.circuit.evaluate(assignment);
        charges.iter().map(|&c| self.charges[c].cost(&values)).sum()
    }

    /// The sum of all charges, each at its largest time, in picoseconds. It may be too large for a [`Picos`].
    #[must_use]
    pub fn sum_of_largest(&self) -> u128 {
        self.charges.iter().map(|charge| u128::from(charge.largest_cost().0)).sum()
    }

    /// The charges with a constant time, as indices into `charges`.
    #[must_use]
    pub fn constant_charges(&self) -> Vec<usize> {
        (0..self.charges.len()).filter(|&index| self.charges[index].is_constant()).collect()
    }
}

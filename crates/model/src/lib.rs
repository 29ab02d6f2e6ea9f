//! The narrow waist: the charges of one scan, their guards, the free variables and the constraints among these.

pub mod certain;
mod circuit;
pub mod groups;
mod havocs;
mod shared;

pub use circuit::{Assignment, Atom, Circuit, Lit, Node, Values, VarId};
pub use havocs::{Concerned, Happened, Havoc, Havocs};
pub use shared::Shared;

use scanbound_base::time::Picos;
use scanbound_ir::{Cell, ChoiceId, ChoiceKey, Frame, Settled};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What a free variable holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum VarKind {
    /// A bit: read through `Atom::Bit`.
    Bit,
    /// Sixteen bits: read through `Atom::AtLeast` (unsigned) and `Atom::WordBit`.
    Word,
}

/// What a free variable stands for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// The cell's value when the scan starts.
    Start(Cell),
    /// A choice of the program.
    Choice(ChoiceKey),
    /// The cell's value after it was havocked by the last of these to have happened: what of `ScanModel::havocs`
    /// concerns it.
    Havocked {
        /// The cell.
        cell: Cell,
        /// How many that may write to its area were before these.
        since: u32,
        /// The same with these.
        until: u32,
    },
}

/// A write of any value to where an index says that is not known, or to anywhere at all.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FarWrite {
    /// The instruction, an index into `Program::instructions`.
    pub instruction: usize,
    /// Under which choice.
    pub choice: ChoiceId,
    /// Whether an index says where.
    pub has_index: bool,
    /// How often it is executed.
    pub executions: u32,
    /// Whether in one execution the index comes from nothing that another such write may have left.
    pub is_first: bool,
    /// Cells of which the index may hold what they were when the scan starts.
    pub starts: BTreeSet<Cell>,
    /// Other such writes from which the index may come.
    pub follows: BTreeSet<ChoiceId>,
}

/// A free variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    /// Bit or word.
    pub kind: VarKind,
    /// What it stands for.
    pub origin: Origin,
    /// Its name for people (`X1F`, `D100`, `T0 contact`, `M5 behind line 40`).
    pub name: String,
}

/// One execution of one instruction and what it costs: `on` if `fires`, else `off` if `reached`, else nothing.
/// `fires` implies `reached`. Where the scan works out how many units it handles, `on` is with the most of them, and
/// `counted` says what it costs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Charge {
    /// The instruction, an index into `Program::instructions`.
    pub instruction: usize,
    /// The call context: calls and loop iterations on the path there.
    pub frames: Vec<Frame>,
    /// Whether control gets there.
    pub reached: Lit,
    /// Whether it costs the on-time.
    pub fires: Lit,
    /// Time when it fires, all units and repetitions counted.
    pub on: Picos,
    /// Time when it is reached and does not fire.
    pub off: Picos,
    /// Where the scan works out how many units are handled: what it costs when it fires.
    pub counted: Option<Box<ByUnits>>,
}

/// What a charge costs by the units that are handled.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ByUnits {
    /// Without any.
    pub base: Picos,
    /// What each of these adds where it is true, which implies that the charge fires.
    pub units: Vec<(Lit, Picos)>,
}

impl Charge {
    /// The dearer of the two times.
    #[must_use]
    pub fn dearer(&self) -> Picos {
        self.on.max(self.off)
    }

    /// What it costs where the circuit's nodes have these values.
    #[must_use]
    pub fn cost(&self, values: &Values) -> Picos {
        self.cost_by(|lit| values.get(lit))
    }

    /// What it costs where its literals have these values.
    #[must_use]
    pub fn cost_by(&self, value: impl Fn(Lit) -> bool) -> Picos {
        match (value(self.fires), value(self.reached)) {
            (true, _) => {
                let (base, units) = self.fired();
                let handled = units.iter().filter(|(handled, _)| value(*handled));
                base + handled.map(|(_, more)| *more).sum()
            }
            (false, true) => self.off,
            (false, false) => Picos::ZERO,
        }
    }

    /// Whether no assignment changes what it costs.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.guards().next().is_none()
    }

    /// The literals on which it depends what it costs.
    pub fn guards(&self) -> impl Iterator<Item = Lit> + '_ {
        let matters = |guard: &Lit| {
            !guard.is_constant()
                && (self.fires_matters() || *guard != self.fires || *guard == self.reached)
        };
        self.literals().filter(matters)
    }

    /// Whether it costs something else where it fires than where it is reached and does not.
    #[must_use]
    pub fn fires_matters(&self) -> bool {
        self.on != self.off || self.counted.is_some()
    }

    /// All its literals, those that are constant and those that change nothing included.
    pub fn literals(&self) -> impl Iterator<Item = Lit> + '_ {
        let units = self.fired().1.iter().map(|(handled, _)| *handled);
        [self.reached, self.fires].into_iter().chain(units)
    }

    /// What it costs when it fires: without any unit, and what each of these literals adds.
    #[must_use]
    pub fn fired(&self) -> (Picos, &[(Lit, Picos)]) {
        match self.counted.as_deref() {
            None => (self.on, &[]),
            Some(ByUnits { base, units }) => (*base, units),
        }
    }
}

/// A place at which control goes round a loop for ever, if it gets there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unbounded {
    /// The instruction, an index into `Program::instructions`.
    pub instruction: usize,
    /// The call context: calls and loop iterations on the path there.
    pub frames: Vec<Frame>,
    /// Whether control gets there.
    pub reached: Lit,
}

/// All that one scan may cost.
#[derive(Debug, Clone, Default)]
pub struct ScanModel {
    /// The guards' circuit.
    pub circuit: Circuit,
    /// The free variables; `VarId` is an index.
    pub variables: Vec<Variable>,
    /// The charges, in order of execution.
    pub charges: Vec<Charge>,
    /// What holds in every scan.
    pub constraints: Vec<Lit>,
    /// In a model for lower bounds: where an operation error ends the scan.
    pub errors: Vec<Lit>,
    /// The writes of any value, in order of execution.
    pub havocs: Havocs,
    /// The free words from which the counts of summarised loops come.
    pub counting: BTreeSet<VarId>,
    /// The writes of which it is not known where they go, in order of execution.
    pub far_writes: Vec<FarWrite>,
    /// Where a scan goes round for ever.
    pub unbounded: Vec<Unbounded>,
    /// How many iterations summarised loops make at most, by what their counts can say.
    pub iterations: BTreeMap<usize, u32>,
    /// The counts of these, each time control may get there.
    pub counts: Vec<Iterations>,
    /// What was settled where operations could be carried out.
    pub settled: Arc<Settled>,
}

/// The count of a summarised loop.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Iterations {
    /// The loop, an index into `Program::instructions`.
    pub instruction: usize,
    /// Whether control gets there.
    pub reached: Lit,
    /// The count, a signed number, the least bit first.
    pub bits: [Lit; 16],
    /// The iterations that it may make whatever its count is.
    pub least: u32,
}

/// Charges that share free variables, directly or through others. Groups share none.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Group {
    /// Indices into `ScanModel::charges`, ascending; none is constant.
    pub charges: Vec<usize>,
    /// The free variables they depend on, through guards or constraints, ascending.
    pub variables: Vec<VarId>,
    /// Indices into `ScanModel::constraints` that concern these variables.
    pub constraints: Vec<usize>,
}

/// Values of a group's variables, ascending; all others are 0. There may be as many groups as variables, so that each
/// keeps its own and no more.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Portion(pub Vec<(VarId, u16)>);

impl Portion {
    /// Puts these values into an assignment of all.
    pub fn put(&self, all: &mut Assignment) {
        for &(variable, value) in &self.0 {
            all.0[variable.0 as usize] = value;
        }
    }

    /// These values, and 0 for all else.
    #[must_use]
    pub fn whole(&self, model: &ScanModel) -> Assignment {
        let mut all = Assignment(vec![0; model.variables.len()]);
        self.put(&mut all);
        all
    }
}

impl ScanModel {
    /// What the given charges cost together under an assignment.
    #[must_use]
    pub fn cost(&self, charges: &[usize], assignment: &Assignment) -> Picos {
        let values = self.circuit.evaluate(assignment);
        charges.iter().map(|&c| self.charges[c].cost(&values)).sum()
    }

    /// What all charges cost together, each at its dearest, in picoseconds: it may be more than a time holds.
    #[must_use]
    pub fn dearest(&self) -> u128 {
        self.charges.iter().map(|charge| u128::from(charge.dearer().0)).sum()
    }

    /// The charges that no assignment changes, indices into `charges`.
    #[must_use]
    pub fn constant(&self) -> Vec<usize> {
        (0..self.charges.len()).filter(|&index| self.charges[index].is_constant()).collect()
    }
}

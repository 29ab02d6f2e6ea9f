//! The typed tree of a project.

pub use crate::code::{
    Applied, Call, Enable, Expr, ExprKind, ForLoop, Parameter, Passed, Place, Root, Selector,
    Statement, StatementKind, Step, StepFlag, Target, continues, each_statement,
};
use crate::declarations::{Address, GlobalList, Routine, Temporary, Unit, Variable};
use crate::ids::{AddressId, RoutineId, UnitId, VarId};
use crate::types::{Type, TypeId, Types};
use scanbound_iec::fault::Fault;

/// What a project means, without a name behind it that would have to be looked for.
#[derive(Debug, Default)]
pub struct Tree {
    /// The types.
    pub types: Types,
    /// All variables.
    pub variables: Vec<Variable>,
    /// All units.
    pub units: Vec<Unit>,
    /// All routines.
    pub routines: Vec<Routine>,
    /// The lists of global variables.
    pub globals: Vec<GlobalList>,
    /// The instances of programs.
    pub programs: Vec<ProgramInstance>,
    /// The tasks that run something, the one that the others interrupt first: the one of the least priority, which has
    /// the largest number, then the one with the longest interval.
    pub tasks: Vec<Task>,
    /// Direct addresses that code names.
    pub addresses: Vec<Address>,
    /// Values that lists and drawings keep.
    pub temporaries: Vec<Temporary>,
    /// What is known of each program instance's inputs and outputs, in the order of the project's.
    pub connected: Vec<Connected>,
    /// What is wrong with the project wherever it is executed, with the files.
    pub faults: Vec<(usize, Fault)>,
    /// Whether a declaration gives values to the variables of an instance of the project's blocks.
    pub gives_parts: bool,
    /// Whether something is executed before the first scan that may write variables.
    pub begins_before: bool,
}

impl Tree {
    /// A variable.
    #[must_use]
    pub fn variable(&self, id: VarId) -> &Variable {
        &self.variables[id.index()]
    }

    /// A unit.
    #[must_use]
    pub fn unit(&self, id: UnitId) -> &Unit {
        &self.units[id.index()]
    }

    /// A routine.
    #[must_use]
    pub fn routine(&self, id: RoutineId) -> &Routine {
        &self.routines[id.index()]
    }

    /// A direct address.
    #[must_use]
    pub fn address(&self, id: AddressId) -> &Address {
        &self.addresses[id.index()]
    }

    /// The task of this name.
    #[must_use]
    pub fn task(&self, name: &str) -> Option<usize> {
        self.tasks.iter().position(|task| scanbound_iec::same(&task.name, name))
    }

    /// A unit and those that it extends, the last the first of all.
    #[must_use]
    pub fn lineage(&self, unit: UnitId) -> Vec<UnitId> {
        let mut found = vec![unit];
        while let Some(base) = found.last().and_then(|&one| self.unit(one).base) {
            if found.contains(&base) {
                break;
            }
            found.push(base);
        }
        found
    }

    /// Whether a type, or that of something in its variables, is one of these.
    pub fn holds(&self, ty: TypeId, is: &dyn Fn(&Type) -> bool) -> bool {
        let of = self.types.get(ty);
        is(of)
            || match of {
                Type::Array(_, of) => self.holds(*of, is),
                Type::Struct(id) => self.types.parts(*id).iter().any(|(_, of)| self.holds(*of, is)),
                Type::Block(unit) => {
                    self.members(*unit).into_iter().any(|one| self.holds(self.variable(one).ty, is))
                }
                _ => false,
            }
    }

    /// Whether a variable of a type holds references.
    #[must_use]
    pub fn has_reference(&self, ty: TypeId) -> bool {
        self.holds(ty, &|of| matches!(of, Type::Reference(..) | Type::Interface(_)))
    }

    /// The variables of an instance of a unit as they lie in memory: those of the units that it extends first.
    #[must_use]
    pub fn members(&self, unit: UnitId) -> Vec<VarId> {
        let units = self.lineage(unit).into_iter().rev();
        units.flat_map(|one| self.unit(one).variables.iter().copied()).collect()
    }

    /// What a call of a routine means for an instance of a unit: a method of the same name nearer to it takes its
    /// place.
    #[must_use]
    pub fn dispatched(&self, unit: UnitId, routine: RoutineId) -> RoutineId {
        let own = self.routine(routine).slot;
        let slot = |other: &&RoutineId| self.routine(**other).slot == own;
        let find = |unit: UnitId| {
            let unit = self.unit(unit);
            unit.methods.iter().chain(&unit.actions).find(slot).copied()
        };
        self.lineage(unit).into_iter().find_map(find).unwrap_or(routine)
    }
}

impl Tree {
    /// The variable of a method that takes the place of another one's.
    #[must_use]
    pub fn counterpart(&self, method: RoutineId, of: VarId) -> Option<VarId> {
        let own = self.variable(of).symbol;
        let mut all = self.routine(method).variables.iter();
        all.find(|one| self.variable(**one).symbol == own).copied()
    }
}

/// An instance of a program.
#[derive(Debug, Clone)]
pub struct ProgramInstance {
    /// Its name.
    pub name: String,
    /// The program.
    pub unit: UnitId,
}

/// A task, and what it runs.
#[derive(Debug, Clone)]
pub struct Task {
    /// Its name, for messages.
    pub name: String,
    /// Its interval in nanoseconds, where it has one.
    pub interval: Option<i64>,
    /// Its priority: a large number is a low one.
    pub priority: Option<i64>,
    /// The instances of programs in their order, by their numbers; or what is wrong with one.
    pub programs: Vec<Result<usize, Fault>>,
}

/// What the inputs and outputs of an instance of a program are connected to.
#[derive(Debug, Clone)]
pub struct Connected {
    /// The instance, by its number among those of the tree.
    pub instance: Option<usize>,
    /// Inputs with their values, and outputs with the places that take them; or what is wrong with one.
    pub pairs: Vec<Result<Pair, Fault>>,
    /// The file.
    pub file: usize,
    /// The line.
    pub line: u32,
}

/// An input or output of a program, and what it is connected to.
#[derive(Debug, Clone)]
pub struct Pair {
    /// The input or output.
    pub own: VarId,
    /// Whether it is an output.
    pub is_output: bool,
    /// What it is connected to.
    pub other: Expr,
}

//! The typed tree of a project, with its program instances, tasks and connections.

pub use crate::code::{
    Applied, Call, Enable, Expr, ExprKind, ForLoop, Parameter, Passed, Place, Root, Selector,
    Statement, StatementKind, Step, StepFlag, Target, continues, each_statement,
};
use crate::declarations::{Address, GlobalList, Routine, Temporary, Unit, Variable};
use crate::ids::{AddressId, RoutineId, UnitId, VarId};
use crate::types::{Type, TypeId, Types};
use scanbound_iec::fault::Fault;

/// A resolved project: ids in place of names.
#[derive(Debug, Default)]
pub struct Tree {
    /// The types of the project.
    pub types: Types,
    /// All variables; [`VarId`] is the index.
    pub variables: Vec<Variable>,
    /// All units (programs, function blocks, functions, interfaces); [`UnitId`] is the index.
    pub units: Vec<Unit>,
    /// All bodies, actions and methods; [`RoutineId`] is the index.
    pub routines: Vec<Routine>,
    /// The lists of global variables.
    pub globals: Vec<GlobalList>,
    /// The program instances.
    pub programs: Vec<ProgramInstance>,
    /// The tasks that run a program, the most interruptible first: the background task of programs without a task, then
    /// by priority from none and the largest number (the lowest priority) down, then by interval, the longest first.
    pub tasks: Vec<Task>,
    /// The direct addresses used in code; [`AddressId`] is the index.
    pub addresses: Vec<Address>,
    /// The temporaries of statement lists and drawings; [`crate::ids::TempId`] is the index.
    pub temporaries: Vec<Temporary>,
    /// The connections of program instances' inputs and outputs, in the order of the project.
    pub connected: Vec<Connected>,
    /// Faults that apply whatever is executed, each with its file's index.
    pub faults: Vec<(usize, Fault)>,
    /// Whether a declaration sets initial values of variables inside an instance of one of the project's blocks.
    pub gives_parts: bool,
    /// Whether code runs before the first scan that may write variables, such as an initialization method.
    pub begins_before: bool,
}

impl Tree {
    /// The variable with this id.
    #[must_use]
    pub fn variable(&self, id: VarId) -> &Variable {
        &self.variables[id.index()]
    }

    /// The unit with this id.
    #[must_use]
    pub fn unit(&self, id: UnitId) -> &Unit {
        &self.units[id.index()]
    }

    /// The routine with this id.
    #[must_use]
    pub fn routine(&self, id: RoutineId) -> &Routine {
        &self.routines[id.index()]
    }

    /// The direct address with this id.
    #[must_use]
    pub fn address(&self, id: AddressId) -> &Address {
        &self.addresses[id.index()]
    }

    /// The index of the task of this name, ignoring case.
    #[must_use]
    pub fn task(&self, name: &str) -> Option<usize> {
        self.tasks.iter().position(|task| scanbound_iec::same(&task.name, name))
    }

    /// The unit and its base units: each is followed by the unit that it extends.
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

    /// Whether `is` holds for the type, or for the type of an array element, field or member variable in it, at any
    /// depth. References are not followed.
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

    /// Whether a variable of this type is or contains a reference, pointer or interface.
    #[must_use]
    pub fn has_reference(&self, ty: TypeId) -> bool {
        self.holds(ty, &|of| matches!(of, Type::Reference(..) | Type::Interface(_)))
    }

    /// All variables of an instance of the unit in memory order: inherited ones first, from the topmost base down.
    #[must_use]
    pub fn members(&self, unit: UnitId) -> Vec<VarId> {
        let units = self.lineage(unit).into_iter().rev();
        units.flat_map(|one| self.unit(one).variables.iter().copied()).collect()
    }

    /// The routine that a call executes for an instance of `unit` (dynamic dispatch): the nearest method or action of
    /// the same kind and name in the unit or its bases, otherwise `routine` itself.
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
    /// The parameter or result of `method` with the same name as `of`, a variable of the method that it overrides.
    /// `None` if it has none.
    #[must_use]
    pub fn counterpart(&self, method: RoutineId, of: VarId) -> Option<VarId> {
        let own = self.variable(of).symbol;
        let mut all = self.routine(method).variables.iter();
        all.find(|one| self.variable(**one).symbol == own).copied()
    }
}

/// A program instance.
#[derive(Debug, Clone)]
pub struct ProgramInstance {
    /// Its name.
    pub name: String,
    /// The program's unit.
    pub unit: UnitId,
}

/// A task and the program instances that it runs.
#[derive(Debug, Clone)]
pub struct Task {
    /// Its name, for messages.
    pub name: String,
    /// The interval in nanoseconds; `None` if none is stated.
    pub interval: Option<i64>,
    /// The priority; a larger number is a lower priority. `None` if none is stated.
    pub priority: Option<i64>,
    /// The program instances in order of execution, as indices into [`Tree::programs`]; or the fault that prevents one.
    pub programs: Vec<Result<usize, Fault>>,
}

/// The connections of one program instance's inputs and outputs.
#[derive(Debug, Clone)]
pub struct Connected {
    /// The index of the instance in [`Tree::programs`]; `None` if there is none of that name.
    pub instance: Option<usize>,
    /// The connected inputs and outputs, or the fault of one.
    pub pairs: Vec<Result<Pair, Fault>>,
    /// The index of the file that states the connections.
    pub file: usize,
    /// The line that states them, from 1.
    pub line: u32,
}

/// One connection: an input or output of a program and its counterpart.
#[derive(Debug, Clone)]
pub struct Pair {
    /// The program's input or output variable.
    pub own: VarId,
    /// Whether it is an output.
    pub is_output: bool,
    /// The value for an input, or the variable that receives an output.
    pub other: Expr,
}

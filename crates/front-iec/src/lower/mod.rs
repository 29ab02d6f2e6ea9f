//! Lowers the typed tree to a [`Program`] in one walk. Names are resolved already: nothing here compares names.

mod actions;
mod address;
mod aliases;
mod bodies;
mod calls;
mod cells;
mod charts;
mod counting;
mod decode;
mod effects;
mod elements;
mod enable;
mod enabled;
mod evaluated_again;
mod extents;
pub(super) mod first_values;
mod forget;
mod inputs;
mod loops;
mod places;
mod references;
mod spots;
mod standard;
mod start;
mod statements;
mod values;

pub(crate) use decode::{SourceTraits, decode};

use crate::assembler::competing::Competing;
use crate::assembler::memory::Memory as ChartMemory;
use crate::assembler::types::Extent;
use crate::assembler::value::Value;
use crate::assembler::{Assembler, BETWEEN, HIDDEN, VARIABLES};
use bodies::Bodies;
use cells::Effects;
use enabled::EnabledInstances;
use scanbound_base::budget::{Budget, StopReason};
use scanbound_base::facts::ActionOrder;
use scanbound_iec::Project;
use scanbound_iec_tree::declarations::{AddressId, RoutineId, TempId, UnitId, VarId};
use scanbound_iec_tree::tree::Tree;
use scanbound_ir::{Area, AreaKind, Cell, Program, Radix, RegionSet, Role, Type};
use spots::{Instance, Spot, SpotKey, Targets};
use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::rc::Rc;

/// The instructions that copy a VAR_IN_OUT argument back after a call, and the file index and line of the call.
type GivenBack = (std::ops::Range<usize>, usize, u32);

/// Which code of an instance is executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Entry {
    /// The instance's body: that of its unit, or the nearest one that the unit inherits.
    Body,
    /// This routine: a method, an action, or the body of a particular base unit, regardless of the instance's own unit.
    Routine(RoutineId),
}

/// Options for lowering a program.
struct Options {
    /// Iteration counts that the user states for loops, as [min, max] by place.
    stated_turns: BTreeMap<String, (i64, i64)>,
    /// Whether a loop with no known iteration count may run any number of iterations. If false, such a loop is a fault.
    is_incomplete: bool,
    /// Whether to lower function blocks with charts also if no program has an instance of them.
    with_unused: bool,
    charts: ChartOptions,
}

/// How charts are executed.
struct ChartOptions {
    /// Whether charts are executed as by CODESYS and TwinCAT: actions before transitions are evaluated, and perhaps the
    /// conditions of all transitions in each scan.
    actions_first: bool,
    /// Which transitions clear when several compete without stated priorities.
    competing: Competing,
    /// The order in which actions are executed, if the user states it.
    action_order: Option<ActionOrder>,
    /// Whether the user states that drawn transition conditions read the blocks' outputs from the previous scan.
    drawn_last_scan: bool,
    /// Whether writers other than the program may change variables between scans.
    others_write: bool,
}

/// Data about the charts of all instances, collected during lowering.
#[derive(Default)]
struct Charts {
    /// The state memory (step bits and the like) of each chart, by instance and routine.
    memories: BTreeMap<(usize, RoutineId), Rc<ChartMemory>>,
    /// By instance and routine: the bit that is true if a RETURN ended the action.
    returned: BTreeMap<(usize, RoutineId), Cell>,
    /// A number for each chart. It identifies the chart's state as an effect before that state has cells.
    numbers: BTreeMap<(usize, RoutineId), u32>,
}

/// The state of lowering one program.
struct Lower<'t> {
    assembler: Assembler,
    tree: &'t Tree,
    project: &'t Project,
    options: Options,
    memory: Memory,
    instances: Vec<Instance>,
    routines: Routines,
    given_back: Vec<GivenBack>,
    /// Cache: the effects of routines that were computed so far.
    effects: BTreeMap<(usize, Entry), Effects>,
    kept: Kept,
    charts: Charts,
    /// Index of each body in the program's statement counts.
    bodies: Bodies,
    budget: Option<&'t Budget<'t>>,
    /// Why lowering stopped early (time limit or user), if it did.
    stopped: Option<StopReason>,
}

/// Where variables are stored.
#[derive(Default)]
struct Memory {
    /// The memory layout of each type, indexed by type number; None until it is computed.
    layouts: Vec<Option<Type>>,
    /// The position of each variable within an instance of its unit.
    positions: BTreeMap<(UnitId, VarId), usize>,
    globals: BTreeMap<VarId, Spot>,
    /// Index of the instance that each variable of a block type is, by its memory place.
    instances: BTreeMap<SpotKey, usize>,
    /// Instance index of each program, by program number.
    programs: BTreeMap<usize, usize>,
    /// Instance index of each function, by unit and task number.
    functions: BTreeMap<(UnitId, usize), usize>,
    addresses: BTreeMap<AddressId, Spot>,
    /// The memory for the variables of each method, by instance and method.
    frames: BTreeMap<(usize, RoutineId), Spot>,
    /// The memory of functions and methods. Their variables are initialised again at every call.
    begin_anew: RegionSet,
    targets: Targets,
    enabled: EnabledInstances,
}

/// Values that are kept in temporaries between statements of the body that is being lowered.
#[derive(Default)]
struct Kept {
    values: BTreeMap<TempId, Value>,
    /// The size of each kept value whose content is not modelled ([`Value::Any`]).
    extents: BTreeMap<TempId, Extent>,
}

/// The routines and tasks of a program during lowering.
#[derive(Default)]
struct Routines {
    /// First instruction of each routine that is lowered already, by instance and entry.
    known: BTreeMap<(usize, Entry), usize>,
    /// Calls whose target is still to be set: the call instruction, and the instance and entry that it calls.
    open: Vec<(usize, usize, Entry)>,
    /// Number of the task whose routines are being lowered.
    task: usize,
    /// For each task, the instances of the programs that it runs.
    tasks: Vec<Vec<usize>>,
    /// Cache: for each task, the combined effects of the programs of all other tasks.
    others: BTreeMap<usize, Effects>,
}

impl Deref for Lower<'_> {
    type Target = Assembler;

    fn deref(&self) -> &Assembler {
        &self.assembler
    }
}

impl DerefMut for Lower<'_> {
    fn deref_mut(&mut self) -> &mut Assembler {
        &mut self.assembler
    }
}

impl<'t> Lower<'t> {
    fn new(project: &'t Project, tree: &'t Tree, dialect: &str, options: Options) -> Lower<'t> {
        let area = |name: &str, kind, role| Area { role, ..Area::new(name, kind, Radix::Decimal) };
        let mut program = Program { dialect: dialect.to_owned(), ..Program::default() };
        for (name, role) in
            [("variable ", Role::Memory), ("chart ", Role::Memory), ("value ", Role::Internal)]
        {
            program.areas.push(area(name, AreaKind::Bit, role));
            program.areas.push(area(&format!("{name}word "), AreaKind::Word, role));
        }
        program.charts.areas = HIDDEN.to_vec();
        program.timekeeping.scratch.extend(BETWEEN);
        let bodies = bodies::bodies(tree, &mut program.statements);
        Lower {
            assembler: Assembler::new(program),
            tree,
            project,
            options,
            memory: Memory {
                layouts: vec![None; tree.types.count()],
                enabled: EnabledInstances::of(tree),
                ..Memory::default()
            },
            instances: Vec::new(),
            routines: Routines::default(),
            given_back: Vec::new(),
            effects: BTreeMap::new(),
            kept: Kept::default(),
            charts: Charts::default(),
            bodies,
            budget: None,
            stopped: None,
        }
    }

    /// Whether the time limit or the user has ended the audit. Lowering then stops and returns no program.
    fn is_late(&mut self) -> bool {
        self.stopped = self.stopped.or_else(|| self.budget.and_then(Budget::stop_reason));
        self.stopped.is_some()
    }
}

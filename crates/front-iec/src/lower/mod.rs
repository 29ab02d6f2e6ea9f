//! From the typed tree to the program, in one walk. It compares no names.

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

/// Instructions that give back what was handed over in and out, with the file of the call and its line.
type GivenBack = (std::ops::Range<usize>, usize, u32);

/// What of an instance is executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Entry {
    /// Its body: that of its unit, or of one that it extends.
    Body,
    /// A routine, and the body of a base, whatever the instance's own unit has.
    Routine(RoutineId),
}

/// What is asked of the program.
struct Options {
    /// How often loops are stated to go round, by their places.
    stated_turns: BTreeMap<String, (i64, i64)>,
    /// Whether a loop of which nothing is known is taken to go round any number of times.
    is_incomplete: bool,
    /// Whether function blocks with charts are lowered, too, that no program has an instance of.
    with_unused: bool,
    charts: ChartOptions,
}

/// What is asked of the way in which charts are executed.
struct ChartOptions {
    /// Whether actions are executed before transitions are evaluated.
    actions_first: bool,
    /// Which of transitions clear that compete without priorities.
    competing: Competing,
    /// In which order actions are executed, as the user states.
    action_order: Option<ActionOrder>,
    /// Whether drawn conditions read what their blocks gave in the last scan, as the user states.
    drawn_last_scan: bool,
    /// Whether others than the program may write variables.
    others_write: bool,
}

/// What is known of charts while a program is lowered.
#[derive(Default)]
struct Charts {
    /// What the chart of a routine of an instance remembers.
    memories: BTreeMap<(usize, RoutineId), Rc<ChartMemory>>,
    /// The bits that say that RETURN ended an action.
    returned: BTreeMap<(usize, RoutineId), Cell>,
    /// The numbers of charts, to tell what they remember apart before it has cells.
    numbers: BTreeMap<(usize, RoutineId), u32>,
}

/// A program while it is lowered.
struct Lower<'t> {
    assembler: Assembler,
    tree: &'t Tree,
    project: &'t Project,
    options: Options,
    memory: Memory,
    instances: Vec<Instance>,
    routines: Routines,
    given_back: Vec<GivenBack>,
    /// What routines read and write, when it has been asked for.
    effects: BTreeMap<(usize, Entry), Effects>,
    kept: Kept,
    charts: Charts,
    /// The numbers of bodies whose statements are counted.
    bodies: Bodies,
    budget: Option<&'t Budget<'t>>,
    /// Why lowering stopped early, if it did.
    stopped: Option<StopReason>,
}

/// Where variables lie.
#[derive(Default)]
struct Memory {
    /// How types are laid out, by their numbers.
    layouts: Vec<Option<Type>>,
    /// Where the variables of a unit lie in its instances.
    positions: BTreeMap<(UnitId, VarId), usize>,
    globals: BTreeMap<VarId, Spot>,
    /// Instances that are variables, by where these lie.
    instances: BTreeMap<SpotKey, usize>,
    /// The instances of programs by their numbers, and those of functions by their tasks.
    programs: BTreeMap<usize, usize>,
    functions: BTreeMap<(UnitId, usize), usize>,
    addresses: BTreeMap<AddressId, Spot>,
    /// The variables of methods, by instance.
    frames: BTreeMap<(usize, RoutineId), Spot>,
    /// The variables of functions and methods, which begin anew with every call.
    begin_anew: RegionSet,
    targets: Targets,
    enabled: EnabledInstances,
}

/// What the body that is lowered keeps.
#[derive(Default)]
struct Kept {
    values: BTreeMap<TempId, Value>,
    /// How large they are, of those that are not followed.
    extents: BTreeMap<TempId, Extent>,
}

/// The routines of a program while it is lowered.
#[derive(Default)]
struct Routines {
    /// Where those begin that are lowered.
    known: BTreeMap<(usize, Entry), usize>,
    /// Calls whose routines are not lowered yet.
    open: Vec<(usize, usize, Entry)>,
    /// The task whose routines are lowered.
    task: usize,
    /// The programs that each task runs: their instances.
    tasks: Vec<Vec<usize>>,
    /// What the programs of the other tasks read and write, by task, when it has been asked for.
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

    /// Whether the time limit, or the user, ends the audit now. Then there is no program.
    fn is_late(&mut self) -> bool {
        self.stopped = self.stopped.or_else(|| self.budget.and_then(Budget::stop_reason));
        self.stopped.is_some()
    }
}

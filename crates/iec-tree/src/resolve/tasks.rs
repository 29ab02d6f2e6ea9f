//! Tasks, program instances, and code that runs before the first scan.

use super::resolver::Resolver;
use crate::accesses::{self, Accesses};
use crate::code::{Call, Place, StepFlag, Target};
use crate::declarations::{Owner, UnitId};
use crate::tree::{Expr, ProgramInstance, Task};
use scanbound_base::code::Code;
use scanbound_iec::Variable as Declared;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Pou, PouKind, Project, TypeRef, ast, same};
use std::collections::{BTreeMap, BTreeSet};

/// The name for messages of the task that runs programs without a task.
const NO_TASK: &str = "background";

impl Resolver<'_> {
    /// Creates the tasks and program instances.
    pub(super) fn tasks(&mut self) {
        let project = self.project;
        let own = project.tasks.iter().filter(|task| !task.instances.is_empty()).cloned();
        // Programs without a task run together in one task.
        let (loose, mut named): (Vec<_>, Vec<_>) = own.partition(|task| task.name.is_empty());
        let mut owners: BTreeMap<String, &str> = BTreeMap::new();
        let mut all =
            project.tasks.iter().flat_map(|task| task.instances.iter().map(move |one| (task, one)));
        let shared = all.find_map(|(task, (name, _))| {
            let first = *owners.entry(name.to_ascii_uppercase()).or_insert(&task.resource);
            (!same(first, &task.resource)).then(|| name.clone())
        });
        let is_apart = loose.windows(2).any(|both| !same(&both[0].resource, &both[1].resource));
        if let Some(mut first) = loose.first().cloned() {
            first.instances = loose.into_iter().flat_map(|task| task.instances).collect();
            named.push(first);
        }
        if named.is_empty() {
            let programs = project.pous.iter().filter(|pou| pou.kind == PouKind::Program);
            let instances = programs.map(|pou| (pou.name.clone(), pou.name.clone())).collect();
            let name = String::new();
            let (resource, interval, priority) = (String::new(), None, None);
            named.push(scanbound_iec::Task { name, resource, interval, priority, instances });
        }
        for task in named {
            let programs = task.instances.iter().map(|(name, of)| {
                if let Some(known) = self.instance_named(name) {
                    return Ok(known);
                }
                let unit = self.index.program(of).ok_or_else(|| {
                    let told = format!("the program {of} of the task {} does not exist", task.name);
                    let fault = Fault::new(1, told).code(Code::UnknownType);
                    fault.help("give the file that declares it")
                })?;
                self.tree.programs.push(ProgramInstance { name: name.clone(), unit });
                Ok(self.tree.programs.len() - 1)
            });
            let programs = programs.collect();
            let priority = task.priority.as_ref().and_then(|text| text.parse::<i64>().ok());
            let (name, interval) = (task.name, task.interval);
            self.tree.tasks.push(Task { name, interval, priority, programs });
        }
        self.tree.tasks.sort_by_key(|task| {
            // A task without a priority number has the lowest priority, so it comes first in this order.
            let number = task.priority.unwrap_or(i64::MAX);
            std::cmp::Reverse((task.name.is_empty(), number, task.interval.unwrap_or(0)))
        });
        let tasks = &mut self.tree.tasks;
        for task in tasks.iter_mut().filter(|task| task.name.is_empty()) {
            task.name = NO_TASK.to_owned();
            task.priority = task.priority.or(Some(i64::MAX));
        }
        if let Some(task) = tasks.iter_mut().find(|task| is_apart && task.name == NO_TASK) {
            let told = "programs without a task belong to several resources, which are processors of their own";
            let fault =
                Fault::new(1, told).code(Code::NotModelled).help("audit each resource by itself");
            task.programs.push(Err(fault));
        }
        if let (Some(name), Some(task)) = (shared, tasks.first_mut()) {
            let told = format!("two resources have a program instance {name}");
            let fault =
                Fault::new(1, told).code(Code::NotModelled).help("audit each resource by itself");
            task.programs.push(Err(fault));
        }
        for at in 1..tasks.len() {
            let (before, rest) = tasks.split_at_mut(at);
            let name = &rest[0].name;
            if before.iter().any(|other| same(&other.name, name)) {
                let told = format!("there are two tasks {name}");
                let help = "audit each resource by itself, or rename one";
                let fault = Fault::new(1, told).code(Code::NotModelled).help(help);
                rest[0].programs.push(Err(fault));
            }
        }
    }

    /// Where the project declares no task: leaves the programs that the bodies of others call out of the task that is
    /// assumed. Only these decide when they run.
    pub(super) fn leave_out_called_programs(&mut self) {
        if self.project.tasks.iter().any(|task| !task.instances.is_empty()) {
            return;
        }
        let is_program = |unit: UnitId| self.tree.unit(unit).kind == PouKind::Program;
        let bodies = self.tree.units.iter().map(|unit| self.tree.routine(unit.body));
        let calls: BTreeMap<UnitId, BTreeSet<UnitId>> = bodies
            .filter(|body| is_program(body.unit))
            .map(|body| {
                let mut called = CalledPrograms::default();
                accesses::of_code(&body.code, &mut called);
                (body.unit, called.0)
            })
            .collect();
        let is_called =
            |unit: &UnitId| calls.iter().any(|(by, all)| by != unit && all.contains(unit));
        // What no program that stays calls must stay, too: two programs that call each other.
        let mut open: Vec<UnitId> = calls.keys().copied().filter(|unit| !is_called(unit)).collect();
        let mut left_out = BTreeSet::new();
        while let Some(unit) = open.pop() {
            open.extend(calls[&unit].iter().copied().filter(|&called| left_out.insert(called)));
        }
        let programs = &self.tree.programs;
        for task in &mut self.tree.tasks {
            task.programs.retain(|program| {
                program.as_ref().map_or(true, |&at| !left_out.contains(&programs[at].unit))
            });
        }
    }

    /// The index of the program instance of this name, ignoring case.
    pub(super) fn instance_named(&self, name: &str) -> Option<usize> {
        self.tree.programs.iter().position(|one| same(&one.name, name))
    }

    /// Whether code runs before the first scan that may write variables: an initialization method, or a call in an
    /// initial value.
    pub(super) fn begins_before(&self) -> bool {
        let begins_with = |unit: &crate::declarations::Unit| !unit.begins_with.is_empty();
        self.tree.units.iter().any(begins_with)
            || self.tree.variables.iter().any(|one| {
                let calls = one.type_calls || one.initial.as_ref().is_some_and(Expr::calls);
                calls && !matches!(one.owner, Owner::Routine(_))
            })
    }
}

/// The programs that code calls.
#[derive(Default)]
struct CalledPrograms(BTreeSet<UnitId>);

impl Accesses for CalledPrograms {
    fn reads(&mut self, _: &Place) {}
    fn writes(&mut self, _: &Place) {}
    fn takes_address(&mut self, _: &Place) {}
    fn asks(&mut self, _: &StepFlag) {}
    fn calls(&mut self, call: &Call) {
        if let Target::Program(_, unit) = call.target {
            self.0.insert(unit);
        }
    }
}

/// Whether a declaration sets initial values of variables inside an instance of one of the project's blocks.
pub(super) fn gives_parts(project: &Project) -> bool {
    let gives_to = |initial: &Option<ast::Expr>, of: &TypeRef| {
        !matches!(initial, None | Some(ast::Expr::Literal(_))) && holds_block(project, of)
    };
    let gives = |one: &Declared| gives_to(&one.initial, &one.of);
    let parts = project.types.iter().filter_map(|one| match &one.of {
        TypeRef::Struct(parts) => Some(parts),
        _ => None,
    });
    let units = project.pous.iter().map(|pou| &pou.variables).chain(parts);
    let mut all = units.chain(project.globals.iter().map(|(_, list)| list)).flatten();
    all.any(gives) || project.types.iter().any(|one| gives_to(&one.initial, &one.of))
}

/// Whether a type is or contains one of the project's function blocks.
fn holds_block(project: &Project, of: &TypeRef) -> bool {
    match of {
        TypeRef::Named(name) => {
            let is_block = |pou: &Pou| pou.kind == PouKind::FunctionBlock && same(&pou.name, name);
            let own = project.types.iter().find(|one| same(&one.name, name));
            project.pous.iter().any(is_block)
                || own.is_some_and(|own| holds_block(project, &own.of))
        }
        TypeRef::Array(_, of) => holds_block(project, of),
        TypeRef::Struct(parts) => parts.iter().any(|one| holds_block(project, &one.of)),
        _ => false,
    }
}

//! From a project to a program: tasks, instances of programs, routines.

use super::assembler::Assembler;
use super::emit::{Emit, Place, What};
use super::first_values::{self, First, FirstValue};
use super::refer;
use super::references::References;
use super::resolve::full_name;
use super::types::{Ty, lineage};
use super::within::calls;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, Project, Task, TypeRef, Variable, same};
use scanbound_iec_tree::constants::Scope;
use scanbound_ir::{AreaId, Logic, PowerUp, Program, Region, SourceFile, Step, flow};
use std::collections::{BTreeMap, BTreeSet};

/// What is asked of the way in which charts are carried out.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// Whether methods are carried out before the first scan that no block names (`call_after_init` of CODESYS).
    pub begins_with_more: bool,
    /// Whether actions come before transitions, as CODESYS and TwinCAT have it.
    pub actions_first: bool,
}

/// Instructions that give back what was handed over in and out, with the file of the call and its line.
pub(super) type GivenBack = (std::ops::Range<usize>, usize, u32);

/// More instructions than any program has.
pub(super) const LARGEST: usize = 4_000_000;

/// What a project means. The programs of the task that is asked for run in the scan, else those of the one of the least
/// priority; further tasks interrupt it.
///
/// # Errors
/// All faults.
pub fn decode(
    project: &Project,
    dialect: &str,
    options: Options,
    asked: &scanbound_front::Options<'_>,
) -> Result<Program, Vec<Diagnostic>> {
    let project = &*super::foreign::stated(project, asked.facts);
    let faults = scanbound_iec_tree::resolve::faults(project);
    if !faults.is_empty() {
        return Err(told(project, faults));
    }
    if !refer::has_any(project) {
        return put_together(project, dialect, options, asked, None).map(|(_, found)| found)?;
    }
    // What references can mean is known when all is put together.
    let mut known = References::default().again(true);
    for _ in 0..MAX_ROUNDS {
        let count = known.count();
        known = put_together(project, dialect, options, asked, Some(known))?.0;
        if known.count() == count {
            let last = Some(known.again(false));
            let (known, found) = put_together(project, dialect, options, asked, last)?;
            if known.count() == count || found.is_err() {
                return found;
            }
            break;
        }
        known = known.again(true);
    }
    let told = "which variables references can mean is not found in time";
    let help = "let references mean fewer variables";
    Err(vec![Fault::new(1, told).code(Code::NotModelled).help(help).in_file(&project.files[0])])
}

/// What a project means, or why it means nothing.
type Meant = Result<Program, Vec<Diagnostic>>;

/// How often a project is put together until it is known which variables references can mean.
const MAX_ROUNDS: u32 = 50;

/// Puts a project together, with what is known of its references, if it has any; what is found of these then. Before the last
/// time what it means is of no account.
fn put_together(
    project: &Project,
    dialect: &str,
    options: Options,
    asked: &scanbound_front::Options<'_>,
    references: Option<References>,
) -> Result<(References, Meant), Vec<Diagnostic>> {
    let mut emit = Emit::new(project, dialect);
    if let Some(references) = references {
        let file = project.files.first().map_or("", String::as_str);
        emit.begin_with(references).map_err(|fault| vec![fault.in_file(file)])?;
    }
    let found = emitted(&mut emit, options, asked);
    let references = std::mem::take(&mut emit.references);
    Ok((references, found))
}

fn emitted(
    emit: &mut Emit<'_>,
    options: Options,
    asked: &scanbound_front::Options<'_>,
) -> Result<Program, Vec<Diagnostic>> {
    let project = emit.project;
    emit.actions_first = options.actions_first;
    emit.begins_with_more = options.begins_with_more;
    emit.all_clear = asked.facts.all_clear;
    emit.stops_on_error = asked.facts.stops_on_error.unwrap_or(true);
    emit.action_order = asked.facts.action_order;
    emit.drawn_last_scan = asked.facts.drawn_last_scan;
    emit.others_write = asked.others_write;
    emit.deadline = asked.deadline;
    emit.calls.clone_from(&asked.facts.calls);
    emit.stated_turns.clone_from(&asked.facts.counts);
    emit.is_incomplete = asked.absent_calls_take_no_time;
    emit.faults.extend(project.unread.iter().cloned());
    let mut tasks = tasks(project, emit);
    let is_asked = |task: &Task| asked.task.is_some_and(|name| same(name, &named_task(task)));
    if let Some(at) = tasks.iter().position(is_asked) {
        let own = tasks.remove(at);
        tasks.insert(0, own);
    }
    emit.tasks = tasks.len();
    let mut entries = Vec::new();
    let mut main = 0..0;
    let (mut first, mut image, mut constants) = (None, None, None);
    for (number, task) in tasks.iter().enumerate() {
        entries.push(emit.builder.next());
        // Of several tasks it is not told which one begins.
        if tasks.len() == 1 && first_values::any(project) {
            first = emit.first_scan();
        }
        if number == 0 {
            constants = first_values::has_constants(project).then(|| emit.begin_constants());
            image = emit.begin_image(project);
        }
        // What tasks call is theirs: they may be in the midst of the same routine at once.
        emit.task = number;
        emit.routines.clear();
        for (name, of) in &task.instances {
            program(emit, task, name, of);
        }
        let last = if number == 0 { Step::End } else { Step::Return };
        emit.builder.add(None, Vec::new(), last);
        if number == 0 {
            main.end = emit.builder.next();
        }
        routines(emit);
    }
    if emit.references.is_draft {
        emit.begin_references();
        routines(emit);
        return Ok(Program::default());
    }
    let begun = std::mem::take(&mut emit.references.faults);
    emit.faults.extend(begun);
    one_name_each(&tasks, emit);
    let given_back = std::mem::take(&mut emit.given_back);
    changed_by_others(emit, &entries, &given_back);
    let located = super::address::located(emit);
    let shared = merged(super::address::share(emit, &located, &given_back));
    emit.begin_shared(image, &located);
    let given = emit.constants();
    emit.give_constants(constants, given);
    let instances = emit.instances.iter().map(|one| one.place.clone());
    let all: Vec<Place> = instances.chain(emit.globals.values().cloned()).collect();
    emit.bound_bytes(&located, &all);
    let own = emit.of_functions();
    emit.settle(&own);
    if !emit.faults.is_empty() {
        super::unknown_types::list_all(emit);
        return Err(told(project, std::mem::take(&mut emit.faults)));
    }
    let (mut known, values) = power_up(emit);
    // What shares memory begins with what either of them declares.
    known.cleared.retain(|own| !shared.iter().any(|one| flow::overlap(*own, *one)));
    known.latched = merged(known.latched);
    emit.note_first_values(first, values, &shared, &mut known);
    known.inputs = merged(known.inputs);
    known.cleared = merged(known.cleared);
    emit.program().power_up = known;
    let program = std::mem::take(&mut emit.builder.program);
    Ok(finish(program, project, &tasks, &entries, main, asked))
}

/// A program with what is known of its tasks and files.
pub(super) fn finish(
    mut program: Program,
    project: &Project,
    tasks: &[Task],
    entries: &[usize],
    main: std::ops::Range<usize>,
    asked: &scanbound_front::Options<'_>,
) -> Program {
    program.mains = vec![main];
    if tasks.len() > 1 {
        program.tasks = tasks.iter().map(known_task).collect();
        // Where tasks have one image of inputs, one that begins refreshes it while another runs.
        program.volatile.extend(program.power_up.inputs.clone());
    }
    for (task, &entry) in program.tasks.iter().zip(entries).skip(1) {
        // What a task of a lower priority writes is there between scans.
        let stated = asked.facts.interrupt(&task.name).filter(|_| !asked.uninterrupted);
        let (times, name) = (stated.unwrap_or(0), task.name.clone());
        let stated = stated.is_some();
        program.interrupts.push(scanbound_ir::Interrupt { name, entry, times, stated });
    }
    let all = program.instructions.len();
    let counts = |file: usize| {
        program
            .instructions
            .iter()
            .filter(|one| one.place.file as usize == file && one.timing.is_some())
            .count()
    };
    let files = project.files.iter().enumerate().map(|(at, name)| SourceFile {
        name: name.clone(),
        instructions: if at == 0 { 0..all } else { all..all },
        count: counts(at),
    });
    program.files = files.collect();
    program
}

/// Faults as findings, each once.
pub(super) fn told(project: &Project, faults: Vec<(usize, Fault)>) -> Vec<Diagnostic> {
    let name = |file: usize| project.files.get(file).map_or("", String::as_str);
    let mut told: Vec<Diagnostic> = Vec::new();
    for (file, fault) in faults {
        let one = fault.in_file(name(file));
        if !told.contains(&one) {
            told.push(one);
        }
    }
    told.sort_by(|a, b| (&a.file, a.line).cmp(&(&b.file, b.line)));
    told
}

/// Tasks are told apart by their names.
pub(super) fn one_name_each(tasks: &[Task], emit: &mut Assembler) {
    for (at, task) in tasks.iter().enumerate() {
        let name = named_task(task);
        if tasks[..at].iter().any(|other| same(&named_task(other), &name)) {
            let told = format!("there are two tasks {name}");
            let help = "audit each resource by itself, or rename one";
            emit.faults.push((0, Fault::new(1, told).code(Code::NotModelled).help(help)));
        }
    }
}

/// What is handed over in and out is followed as a copy; on a PLC it changes while the call runs if another task writes it. Such
/// calls are faults.
pub(super) fn changed_by_others(emit: &mut Assembler, entries: &[usize], given_back: &[GivenBack]) {
    let program = &emit.builder.program;
    let task_of = |at: usize| entries.partition_point(|&entry| entry <= at);
    let mut written: BTreeSet<(usize, Region)> = BTreeSet::new();
    for at in 0..program.instructions.len() {
        let regions = flow::written(program, at).into_iter();
        written.extend(regions.map(|region| (task_of(at), region)));
    }
    let mut faults = Vec::new();
    for (range, file, line) in given_back {
        let own: Vec<Region> = range.clone().flat_map(|at| flow::written(program, at)).collect();
        let by_other = |(task, region): &(usize, Region)| {
            *task != task_of(range.start) && own.iter().any(|one| flow::overlap(*one, *region))
        };
        if written.iter().any(by_other) {
            let told = "what is handed over in and out is written by another task, too: it may change \
                while the call runs, which is not followed";
            let help = "copy it to a variable of the task before the call, and back behind it";
            faults.push((*file, Fault::new(*line, told).code(Code::NotModelled).help(help)));
        }
    }
    emit.faults.extend(faults);
}

/// Puts together what is called.
fn routines(emit: &mut Emit<'_>) {
    while let Some((call, instance, what)) = emit.open.pop() {
        let known = emit.routines.get(&(instance, what.clone())).copied();
        let entry = known.unwrap_or_else(|| emit.routine(instance, &what));
        if let Step::Call { target, .. } = &mut emit.builder.program.instructions[call].step {
            *target = entry;
        }
        if emit.is_late() {
            emit.open.clear();
        }
        if emit.builder.next() > LARGEST {
            emit.faults.push((
                0,
                Fault::new(1, "the project has more instructions than any CPU holds")
                    .code(Code::TooMany),
            ));
            emit.open.clear();
        }
    }
}

/// What programs of no task are called together.
const NO_TASK: &str = "background";

pub(super) fn named_task(task: &Task) -> String {
    if task.name.is_empty() { NO_TASK.to_owned() } else { task.name.clone() }
}

/// A task as reports tell it. Programs of no task have the least priority.
pub(super) fn known_task(task: &Task) -> scanbound_ir::Task {
    let least = task.name.is_empty().then_some(i64::MAX);
    let number = task.priority.as_ref().and_then(|text| text.parse().ok());
    let interval = task.interval.and_then(|time| u64::try_from(time).ok()).filter(|&time| time > 0);
    scanbound_ir::Task {
        name: named_task(task),
        interval: interval.and_then(|time| time.checked_mul(1000)).map(Picos),
        priority: number.or(least),
        programs: task.instances.iter().map(|(name, _)| name.clone()).collect(),
    }
}

/// The tasks that run something, the one that the others interrupt first: the one of the least priority, which has the
/// largest number, then the one with the longest interval.
pub(super) fn tasks(project: &Project, emit: &mut Assembler) -> Vec<Task> {
    let mut own: Vec<Task> =
        project.tasks.iter().filter(|task| !task.instances.is_empty()).cloned().collect();
    // Programs of no task run together.
    let (loose, mut named): (Vec<Task>, Vec<Task>) =
        own.drain(..).partition(|task| task.name.is_empty());
    if let Some(mut first) = loose.first().cloned() {
        first.instances = loose.into_iter().flat_map(|task| task.instances).collect();
        named.push(first);
    }
    if named.is_empty() {
        let programs = project.pous.iter().filter(|pou| pou.kind == PouKind::Program);
        let instances: Vec<_> = programs.map(|pou| (pou.name.clone(), pou.name.clone())).collect();
        if instances.is_empty() {
            let help = "give the file that has the PROGRAM which the task runs";
            emit.faults.push((
                0,
                Fault::new(1, "the project has no program").code(Code::NoProgram).help(help),
            ));
        }
        named.push(Task { name: String::new(), interval: None, priority: None, instances });
    }
    let number = |task: &Task| task.priority.as_ref().and_then(|text| text.parse::<i64>().ok());
    named.sort_by_key(|task| {
        let is_loose = task.name.is_empty();
        // A task without a number comes last of all, that is, first here.
        std::cmp::Reverse((is_loose, number(task).unwrap_or(i64::MAX), task.interval.unwrap_or(0)))
    });
    named
}

/// An instance of a program, and its call.
fn program(emit: &mut Emit<'_>, task: &Task, name: &str, of: &str) {
    let project = emit.project;
    let found =
        project.pous.iter().position(|pou| same(&pou.name, of) && pou.kind == PouKind::Program);
    let Some(pou) = found else {
        let message = format!("the program {of} of the task {} is not there", task.name);
        emit.faults.push((
            0,
            Fault::new(1, message).code(Code::UnknownType).help("give the file that declares it"),
        ));
        return;
    };
    emit.file = project.pous[pou].file;
    let placed = emit
        .types
        .instance(pou)
        .and_then(|parts| emit.variable(name, Ty::Parts(parts), project.pous[pou].line));
    match placed {
        Ok(place) => {
            let instance = emit.instance(&place, pou);
            emit.at(project.pous[pou].line, &format!("PROGRAM {name}"));
            let connected = project.connected.iter().find(|one| same(&one.name, name));
            connected.into_iter().for_each(|one| emit.connect(instance, one, false));
            emit.call(Logic::Const(true), instance, What::Body, "PROGRAM");
            connected.into_iter().for_each(|one| emit.connect(instance, one, true));
        }
        Err(fault) => emit.fault(fault),
    }
}

/// What is known of the state after power-up.
fn power_up(emit: &mut Emit<'_>) -> (PowerUp, Vec<FirstValue>) {
    let mut known = PowerUp {
        declares_latched: true,
        cleared: vec![Region::Area(AreaId(2)), Region::Area(AreaId(3))],
        ..PowerUp::default()
    };
    let mut values = Vec::new();
    let project = emit.project;
    // What an instance's declaration gives to its parts is not followed: then no instance is known to begin with 0.
    let given = emit.gives_parts;
    let of_instances = |pou: usize| !given || project.pous[pou].kind == PouKind::Program;
    let instances: Vec<(usize, Place)> = emit
        .instances
        .iter()
        .filter(|one| of_instances(one.pou))
        .map(|one| (one.pou, one.place.clone()))
        .collect();
    for instance in 0..emit.instances.len() {
        if emit.is_retained(instance) {
            known.latched.extend(emit.instances[instance].place.tag.regions());
            let charts = emit.charts.iter().filter(|((of, _), _)| *of == instance);
            known.latched.extend(charts.flat_map(|(_, tag)| tag.regions()));
        }
    }
    for (pou, place) in instances {
        let units = lineage(project, pou);
        for (at, unit) in units.iter().enumerate() {
            let scope: Vec<&[Variable]> =
                units[at..].iter().map(|pou| &pou.variables[..]).collect();
            for variable in &unit.variables {
                if let Some(part) = Emit::part(&place, &variable.name) {
                    values.extend(starts(emit, &mut known, (variable, &scope), &part));
                }
            }
        }
    }
    let globals = emit.globals.clone();
    for (list, all) in &project.globals {
        let scope: &Scope<'_> = if list.is_empty() { &[] } else { &[all] };
        for variable in all {
            let place = globals.get(&full_name(list, variable).to_ascii_uppercase());
            if let Some(place) = place {
                values.extend(starts(emit, &mut known, (variable, scope), place));
            }
        }
    }
    latch_within(emit, &mut known, &globals);
    for place in globals.values().filter(|place| place.name.starts_with("%I")) {
        known.inputs.extend(place.tag.regions());
    }
    // What methods that are carried out before the first scan leave in variables is not followed.
    if emit.begins_with_more || begins_before(project) {
        known.cleared.retain(|own| matches!(own, Region::Area(_)));
        values.clear();
    }
    (known, values)
}

/// Whether something is executed before the first scan that may write variables.
pub(super) fn begins_before(project: &Project) -> bool {
    begins_with_method(project) || begins_with_call(project)
}

/// The same cells in as few regions as there can be.
pub(super) fn merged(all: Vec<Region>) -> Vec<Region> {
    let mut ranges = Vec::new();
    let mut found = Vec::new();
    for one in all {
        match one {
            Region::Range { first, count } => ranges.push((first, count)),
            whole if found.contains(&whole) => {}
            whole => found.push(whole),
        }
    }
    ranges.sort_unstable();
    for (first, count) in ranges {
        match found.last_mut() {
            Some(Region::Range { first: own, count: known })
                if own.area == first.area && first.index <= own.index.saturating_add(*known) =>
            {
                *known = (*known).max((first.index - own.index).saturating_add(count));
            }
            _ => found.push(Region::Range { first, count }),
        }
    }
    found
}

/// Whether a block has a method that is carried out when its instances begin.
fn begins_with_method(project: &Project) -> bool {
    let begins = ["FB_Init", "FB_Reinit"];
    let mut methods = project.pous.iter().flat_map(|pou| &pou.methods);
    methods.any(|one| begins.iter().any(|name| same(name, &one.name)))
}

/// Whether an initial value calls a function of the project's, which may write variables.
fn begins_with_call(project: &Project) -> bool {
    let lists = project.globals.iter().map(|(_, list)| list);
    let variables = project.pous.iter().map(|pou| &pou.variables).chain(lists).flatten();
    let parts = project.types.iter().flat_map(|one| match &one.of {
        TypeRef::Struct(parts) => &parts[..],
        _ => &[],
    });
    let of_types = project.types.iter().map(|one| &one.initial);
    let mut all = variables.chain(parts).map(|one| &one.initial).chain(of_types).flatten();
    all.any(|initial| calls(project, initial))
}

/// What stands in an instance, a structure or an array that survives a loss of power does so, too.
fn latch_within(emit: &Emit<'_>, known: &mut PowerUp, globals: &BTreeMap<String, Place>) {
    let project = emit.project;
    let mut kept: Vec<Place> = Vec::new();
    for one in &emit.instances {
        let all = lineage(project, one.pou).into_iter().flat_map(|pou| &pou.variables);
        let parts = all.filter(|one| one.retain);
        kept.extend(parts.filter_map(|part| Emit::part(&one.place, &part.name)));
    }
    for (list, all) in &project.globals {
        let names = all.iter().filter(|one| one.retain).map(|one| full_name(list, one));
        kept.extend(names.filter_map(|name| globals.get(&name.to_ascii_uppercase()).cloned()));
    }
    let regions = merged(kept.iter().flat_map(|place| place.tag.regions()).collect());
    let own = known.cleared.iter().filter(|own| !matches!(own, Region::Area(_)));
    let own = own.filter(|own| regions.iter().any(|one| flow::overlap(**own, *one)));
    known.latched.extend(own.copied().collect::<Vec<_>>());
    // What charts in them remember.
    for ((instance, _), tag) in &emit.charts {
        let name = &emit.instances[*instance].place.name;
        let is_within = |place: &Place| {
            let begins = name.get(..place.name.len()).is_some_and(|begin| same(begin, &place.name));
            let rest = name.get(place.name.len()..).unwrap_or_default();
            begins && (rest.is_empty() || rest.starts_with(['.', '[']))
        };
        if kept.iter().any(is_within) {
            known.latched.extend(tag.regions());
        }
    }
}

/// Takes note of what a variable begins with; the values that are others than 0.
fn starts(
    emit: &Emit<'_>,
    known: &mut PowerUp,
    (variable, scope): (&Variable, &Scope<'_>),
    place: &Place,
) -> Vec<FirstValue> {
    if variable.at.as_ref().is_some_and(|at| at.starts_with("%I")) {
        known.inputs.extend(place.tag.regions());
        return Vec::new();
    }
    if variable.retain {
        known.latched.extend(place.tag.regions());
    }
    if first_values::is_given(variable) {
        return Vec::new();
    }
    let mut values = emit.first_values(variable, place, scope);
    let zeros = values.extract_if(.., |one| one.first == First::Zero);
    known.cleared.extend(zeros.flat_map(|one| one.regions));
    values.retain(|one| one.first != First::Unknown);
    values
}

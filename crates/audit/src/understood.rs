//! The first stage: the project's files become a program, and its timing table is chosen.

use super::failure::Failure;
use super::request::{Progress, Request};
use super::{counts, indices, stated};
use scanbound_base::budget::{Budget, StopReason};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{Part, StatedFactor};
use scanbound_front::{MachineOptions, Options, Project, stopped};
use scanbound_ir::Program;
use scanbound_passes::values::Trust;
use scanbound_timing::table::{Evidence, Factor, StatedClock, Table};
use std::collections::BTreeSet;

/// The largest number of wrong facts of one kind that are reported.
const MAX_LISTED: usize = 100;

/// The program as the front lowered it, with the stated facts, and its timing table.
#[derive(Clone)]
pub struct Understood {
    pub program: Program,
    pub table: Table,
    /// Which facts and options the user can state for this PLC, such as its clock.
    pub machine: MachineOptions,
    /// The warnings from reading the files and applying the facts.
    pub warnings: Vec<Diagnostic>,
}

impl Understood {
    /// Reads the files, lowers them to a program, chooses the timing table and applies the stated facts.
    pub fn of(request: &Request<'_>, budget: &Budget<'_>) -> Result<Understood, Failure> {
        (request.progress)(Progress::Stage("reading"));
        let project = request.fronts.read(request.inputs, request.dialect, request.reading)?;
        // Lowering may take much longer than reading. A time limit is left to the front: it may have the program soon.
        if let Some(reason @ StopReason::Cancelled) = budget.stop_reason() {
            let file = request.inputs.first().map_or("", |input| &input.name);
            return Err(Failure::from(stopped(reason, file)));
        }
        let (mut program, table) = understand(&*project, request, budget)?;
        let machine = project.machine_options();
        let mut warnings = project.warnings();
        warnings.extend(other_series(request.cpu, project.cpu()));
        warnings.extend(stated::unused_calls(&program, request.facts));
        // The source takes as much memory as the program, and later stages use only the program.
        drop(project);
        warnings.extend(state(&mut program, request)?);
        Ok(Understood { program, table, machine, warnings })
    }

    /// The same program with another table of the same CPU family, to which the user's times, factor and clock are
    /// applied.
    #[must_use]
    pub fn with_table(&self, table: Table, request: &Request<'_>) -> Understood {
        let table = fitted(amended(table, request), &self.program, request);
        Understood { table, ..self.clone() }
    }
}

/// Applies the user's facts to a program: ranges, counts, indices, exclusive bits and who else writes devices. Returns
/// warnings of facts without effect.
///
/// # Errors
/// All facts that do not fit the program.
pub fn state(
    program: &mut Program,
    request: &Request<'_>,
) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let facts = request.facts;
    if request.trusted() == Trust::None {
        program.scan_control.distrust_indices();
    }
    let mut faults = Vec::new();
    let mut collect =
        |check: Result<(), Vec<Diagnostic>>| faults.extend(check.err().into_iter().flatten());
    collect(know_interrupts(program, request));
    collect(stated::know_words(program, facts));
    collect(counts::state(program, facts));
    collect(indices::state(program, facts));
    let external = stated::writers(program, facts, "external", &facts.external);
    collect(stated::know_scan_times(program, facts));
    collect(external.map(|regions| program.external.extend(regions)));
    let internal = stated::writers(program, facts, "internal", &facts.internal);
    collect(internal.map(|regions| program.internal = regions));
    collect(stated::exclude(program, facts));
    if !faults.is_empty() {
        return Err(faults);
    }
    Ok(stated::useless_internal(program, facts, request.trusted()))
}

/// Lowers the source to a program, and chooses its timing table. Refuses facts and options that do not exist for this
/// PLC.
fn understand(
    project: &dyn Project,
    request: &Request<'_>,
    budget: &Budget<'_>,
) -> Result<(Program, Table), Failure> {
    let machine = project.machine_options();
    if request.clock.is_some() && !machine.clock {
        return Err(Failure::from(no_clock()));
    }
    if request.facts.latched.is_some() && !machine.latched {
        let message = "`[io] latched` is not used for programs of this dialect";
        let fault =
            request.facts.fault(["io", "latched"], Part::Key, Code::Facts, message, "remove it");
        return Err(Failure::from(fault));
    }
    if let (Some(what), false) = (request.facts.controller.keys().next(), machine.controller) {
        let message =
            "[controller] cannot be stated for this PLC: it is for programs of IEC 61131-3";
        let fact = ["controller", what];
        let fault = request.facts.fault(fact, Part::Key, Code::Facts, message, "remove it");
        return Err(Failure::from(fault));
    }
    let stated = [
        ("bits", request.facts.index_bits.is_some()),
        ("indirect", request.facts.indirect.is_some()),
    ];
    if let Some((key, _)) = stated.into_iter().find(|(_, stated)| *stated && !machine.index) {
        let message = format!("`[index] {key}` is not used for programs of this dialect");
        let fault =
            request.facts.fault(["index", key], Part::Key, Code::Facts, message, "remove it");
        return Err(Failure::from(fault));
    }
    if let (Some(letters), false) = (request.facts.devices.keys().next(), machine.index) {
        let message = "[devices] is not used for programs of this dialect";
        let fact = ["devices", letters];
        let fault = request.facts.fault(fact, Part::Key, Code::Facts, message, "remove it");
        return Err(Failure::from(fault));
    }
    if let (Some(StatedClock::Period { .. }), [time, ..]) = (request.clock, request.times) {
        let message =
            format!("--clock and --time {} both state how long a program word takes", time.name);
        let found = Diagnostic::file(Code::NoClock, "", message, "remove one of the two options");
        return Err(Failure::from(found));
    }
    let table = choose_table(request, project.cpu())?;
    let program = project.decode(&Options {
        cpu: request.cpu,
        family: table.family.as_deref(),
        is_user_instruction: &|name| table.knows(name),
        facts: request.facts,
        absent_calls_take_no_time: request.incomplete,
        task: request.task,
        uninterrupted: request.alone,
        others_write: request.others_write(),
        budget: Some(budget),
    })?;
    knows_task(&program, request)?;
    let table = fitted(table, &program, request);
    Ok((program, table))
}

/// Refuses a requested task that the project does not have, probably a typing error.
fn knows_task(program: &Program, request: &Request<'_>) -> Result<(), Failure> {
    let Some(asked) = request.task else { return Ok(()) };
    if program.tasks.iter().any(|task| task.name.eq_ignore_ascii_case(asked)) {
        return Ok(());
    }
    let file = request.inputs.first().map_or("", |input| &input.name);
    let names: Vec<&str> = program.tasks.iter().map(|task| task.name.as_str()).collect();
    let help = match names.as_slice() {
        [] => "omit --task: the project does not have several tasks".to_owned(),
        names => format!("the tasks of the project are {}", names.join(", ")),
    };
    let message = format!("--task {asked}: the project has no task of that name");
    Err(Failure::from(Diagnostic::file(Code::UnknownName, file, message, help)))
}

/// The timing table with the stated clock, and with one time for the areas that are aliases of each other in this
/// program.
pub fn fitted(mut table: Table, program: &Program, request: &Request<'_>) -> Table {
    request.clock.into_iter().for_each(|clock| table.set_clock(clock));
    for area in program.areas.iter().filter(|area| !area.aliases.is_empty()) {
        table.join_cells(&[&[area.name.as_str()], area.aliases].concat());
    }
    table
}

/// Refuses stated numbers of runs for interrupt routines that do not exist. They are probably typing errors, so that a
/// real routine has no number.
fn know_interrupts(program: &Program, request: &Request<'_>) -> Result<(), Vec<Diagnostic>> {
    // The task whose scan is bounded may have a stated rate, too, because it interrupts other tasks.
    let tasks = program.tasks.iter().map(|one| &one.name);
    let names = program.interrupts.iter().map(|one| &one.name).chain(tasks);
    let known: BTreeSet<String> = names.map(|name| name.to_ascii_uppercase()).collect();
    let faults: Vec<Diagnostic> = request
        .facts
        .interrupts
        .keys()
        .filter(|label| !known.contains(*label))
        .take(MAX_LISTED)
        .map(|label| {
            let message = format!("interrupts are stated for {label}, but the program has no interrupt routine of that name");
            let names: Vec<&str> =
                program.interrupts.iter().take(MAX_LISTED).map(|one| one.name.as_str()).collect();
            let help = match names.as_slice() {
                [] => "the program has no interrupt routines: remove the line".to_owned(),
                names => format!("the interrupt routines of the program are {}", names.join(", ")),
            };
            request.facts.fault(["interrupts", label], Part::Key, Code::NoInterrupt, message, &help)
        })
        .collect();
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Warns if the user names a CPU of another series than the programs do. Two CPUs are of different series if their
/// tables differ. `None` if there is nothing to warn of, or a CPU is not named or has no table.
pub fn other_series(named: Option<&str>, source: Option<&str>) -> Option<Diagnostic> {
    let (named, source) = (named?, source?);
    if Table::for_cpu(named)? == Table::for_cpu(source)? {
        return None;
    }
    let message = format!(
        "the programs are for {source}, but the CPU {named} that you named is of another series: the audit uses the times and devices of {named}"
    );
    let help = format!("omit the CPU (--cpu, scanbound.toml) unless the programs run on {named}");
    Some(Diagnostic::file(Code::OtherCpu, "", message, help).warning())
}

/// The table that the user names, otherwise the built-in one for the CPU, with the user's times.
pub fn choose_table(request: &Request<'_>, source_cpu: Option<&str>) -> Result<Table, Failure> {
    let file = request.inputs.first().map_or("", |input| &input.name);
    let cpu = request.cpu.or(source_cpu);
    let table = match (request.table, cpu) {
        (Some(table), _) => table.clone(),
        (None, Some(cpu)) => Table::for_cpu(cpu).and_then(Table::builtin).ok_or_else(|| {
            let (file, message) = match request.cpu {
                Some(cpu) => ("", format!("--cpu {cpu}: there is no timing table for this CPU")),
                None => (
                    file,
                    format!("the program's CPU is {cpu}, for which there is no timing table"),
                ),
            };
            Diagnostic::file(Code::NoTable, file, message, Table::advice(cpu))
        })?,
        (None, None) => {
            let names = scanbound_timing::table::builtin::names().join(", ");
            return Err(Failure::from(Diagnostic::file(
                Code::NoTable,
                file,
                "the source does not name its CPU, so its instructions have no times",
                format!(
                    "name the CPU with --cpu, or a table with --table: one of {names}, or your own file"
                ),
            )));
        }
    };
    Ok(amended(table, request))
}

/// The table with the times and the factor that the user stated. With `--strict-times`, without assumed numbers of
/// points.
fn amended(mut table: Table, request: &Request<'_>) -> Table {
    if request.strict_times {
        table.refuse_assumed_points();
    }
    if let Some(StatedFactor { millionths, text }) = &request.facts.factor {
        table.factor = Some(Factor {
            millionths: *millionths,
            text: text.clone(),
            evidence: Evidence::Stated,
            source: "stated in the facts".to_owned(),
        });
    }
    for time in request.times {
        table.amend(&time.name, time.on, time.off);
    }
    table
}

fn no_clock() -> Diagnostic {
    let message = "--clock does not apply to this CPU: not all of its instructions take the same number of clock periods";
    Diagnostic::file(Code::NoClock, "", message, "omit --clock; give times with --table or --time")
}

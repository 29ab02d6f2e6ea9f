//! The road from source text to an audit.

use super::Audit;
use super::asked::Searched;
use super::assemble::Findings;
use super::closing::Closing;
use super::executed::stands_between;
use super::method;
use super::modelling::{keep_in_range, model_of};
use super::power_up;
use super::stated;
use super::unbounded::{self, loops};
use crate::base::budget::{Budget, Cut};
use crate::base::code::Code;
use crate::base::diagnostic::Diagnostic;
use crate::base::facts::{Facts, Part, StatedFactor};
use crate::base::time::Picos;
use crate::front::{FRONTS, Fronts, Input, Options, Project};
use crate::passes::values::{self, Trust};
use crate::program::Program;
use crate::replay::Replay;
use crate::scan::groups;
use crate::scan::model::{Assignment, Group, Portion, ScanModel, Values};
use crate::solve::{Limits, Maximum, Method, maximum};
use crate::timing::price::{self, Prices};
use crate::timing::table::{Evidence, Factor, Override, StatedClock, Table};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// What to audit and how.
pub struct Request<'a> {
    /// The project's files.
    pub inputs: &'a [Input],
    /// What reads them.
    pub fronts: Fronts,
    /// The dialect, if not to be found from the content.
    pub dialect: Option<&'a str>,
    /// The CPU, if the source does not name it or names it wrongly.
    pub cpu: Option<&'a str>,
    /// The timing table, if not to be found by the CPU.
    pub table: Option<&'a Table>,
    /// Times that the user stated.
    pub times: &'a [Override],
    /// The clock that the user stated, for a machine that runs one word a clock.
    pub clock: Option<&'a StatedClock>,
    /// What the user stated about the plant.
    pub facts: &'a Facts,
    /// Whose writes between scans are reckoned with.
    pub trust: Trust,
    /// Whether assumed times are refused.
    pub strict_times: bool,
    /// Which search to use.
    pub method: Method,
    /// Whether each search's steps are kept.
    pub trace: bool,
    /// Whether Z3 is asked for a second opinion on each group's maximum.
    pub confirm: bool,
    /// How long the search may take; the bound is valid whenever it stops.
    pub time_limit: Option<Duration>,
    /// What was noticed before, told in front of what the audit notices.
    pub warnings: &'a [Diagnostic],
    /// If given, the search may end as soon as it is decided whether a scan takes longer than this.
    pub limit: Option<Picos>,
    /// Asked now and then; true stops the search as the time limit does.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Told how far the audit is.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

impl<'a> Request<'a> {
    /// All of a project's longest scan, by what its source names, with no limit.
    #[must_use]
    pub fn new(inputs: &'a [Input], facts: &'a Facts) -> Request<'a> {
        Request {
            inputs,
            fronts: FRONTS,
            dialect: None,
            cpu: None,
            table: None,
            times: &[],
            clock: None,
            facts,
            trust: Trust::None,
            strict_times: false,
            method: Method::Auto,
            trace: false,
            confirm: false,
            time_limit: None,
            warnings: &[],
            limit: None,
            cancelled: &|| false,
            progress: &|_| {},
        }
    }
}

/// So many wrong facts of a kind are told.
const MOST_TOLD: usize = 100;
/// So long a scan that keeps what is stated is looked for where the time is over.
const GRACE: Duration = Duration::from_secs(2);

/// How far an audit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// A stage begins.
    Stage(&'static str),
    /// The bounds of the whole scan have come closer.
    Bounds {
        /// No scan takes longer.
        upper: Picos,
        /// Some scan takes as long.
        lower: Picos,
        /// The group at work, as reports number it.
        group: usize,
        /// Groups whose maximum is known.
        solved: usize,
        /// All groups.
        groups: usize,
    },
}

/// Why there is no audit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Failure {
    /// The input can't be taken; all faults that were found.
    Input(Vec<Diagnostic>),
    /// The program contradicts itself: the analysis and the interpreter disagree.
    Internal(String),
}

impl From<Vec<Diagnostic>> for Failure {
    fn from(faults: Vec<Diagnostic>) -> Failure {
        Failure::Input(faults)
    }
}

impl From<Diagnostic> for Failure {
    fn from(fault: Diagnostic) -> Failure {
        Failure::Input(vec![fault])
    }
}

/// A project followed as far as its scan's model: all that there is to search.
pub struct Followed {
    /// When this began.
    start: Instant,
    /// The program.
    pub program: Program,
    /// The table that prices it.
    pub table: Table,
    /// Every instruction's price.
    pub prices: Prices,
    /// The charges of one scan.
    pub model: ScanModel,
    /// Its slices.
    pub groups: Vec<Group>,
    warnings: Vec<Diagnostic>,
    /// The stages that the time limit or the user cut short.
    cuts: Vec<Cut>,
    /// The model is the sum of all that can run, and says nothing of what can run together.
    whole: bool,
}

/// Audits a project.
///
/// # Errors
/// All faults of the input at once, or that the analysis and the interpreter disagree.
pub fn audit(request: &Request<'_>) -> Result<Audit, Failure> {
    let followed = follow(request)?;
    Ok(conclude(followed, request)?.audit)
}

/// Reads, prices and follows a project, without any search.
///
/// # Errors
/// All faults of the input at once.
pub fn follow(request: &Request<'_>) -> Result<Followed, Failure> {
    let start = Instant::now();
    let budget = Budget::new(start, request.time_limit, request.cancelled, Vec::new());
    let stage = |name| (request.progress)(Progress::Stage(name));

    stage("reading");
    let project = request.fronts.read(request.inputs, request.dialect)?;
    let (mut program, table) = understand(&*project, request)?;
    let found = project.warnings();
    // The source takes as much memory as the program, which is all that the stages behind look at.
    drop(project);
    know_interrupts(&program, request)?;
    stated::know_words(&program, request.facts)?;

    stage("bounding what words count");
    let _invariants = values::narrow(&mut program, request.trust);

    stage("pricing");
    let mut prices = price::price(&program, &table, request.facts)?;
    let unused = unused_times(request.times, &program, &prices);
    let odd = stated::odd(&program, &table, request.facts);
    stated::forget_unnamed(&mut program);
    let warnings = [request.warnings, &found, &unused, &odd].concat();
    if request.strict_times {
        refuse_assumed(&program, &prices)?;
    }
    // By what they were priced nobody asks again.
    for instruction in &mut program.instructions {
        instruction.timing = instruction.timing.take().filter(|key| key.counted().is_some());
    }

    stage("following the scan");
    let (model, whole) = model_of(&mut program, &mut prices, &budget)?;
    keep_in_range(&program, &table, &prices, &model)?;
    let groups = groups::groups(&model);
    let cuts = budget.cuts();
    Ok(Followed { start, program, table, prices, model, groups, warnings, cuts, whole })
}

/// An audit and what it was found in.
pub struct Concluded {
    /// The audit.
    pub audit: Audit,
    /// The project.
    pub followed: Followed,
    /// The groups' maxima.
    pub maxima: Vec<Maximum>,
}

/// Searches the groups' maxima, replays the worst scan and puts the audit together.
///
/// # Errors
/// That the analysis and the interpreter disagree.
pub fn conclude(followed: Followed, request: &Request<'_>) -> Result<Concluded, Failure> {
    let Followed { start, mut program, table, mut prices, model, groups, warnings, cuts, whole } =
        followed;
    let budget = Budget::new(start, request.time_limit, request.cancelled, cuts);
    let deadline = budget.deadline();
    let stage = |name| (request.progress)(Progress::Stage(name));
    let limits = Limits { deadline, cancelled: request.cancelled, ..Limits::default() };
    let doubtful_from = program.shortest_timer;
    let closing = Closing { request, budget: &budget, limits, doubtful_from, whole };
    let (searched, found) = closing.search(&mut program, &mut prices, model, groups)?;
    let times = prices.times();
    let Searched { model, groups, maxima, assignment, replayed, ended_early, .. } = searched;
    let open: Vec<&Maximum> = maxima.iter().filter(|found| found.lower < found.upper).collect();
    if let (false, false) = (open.is_empty(), ended_early) {
        let apart: Picos = open.iter().filter_map(|one| one.upper.checked_sub(one.lower)).sum();
        budget.cut(
            "searching",
            format!(
                "the longest scan may be up to {apart} shorter: {} of {} groups are open",
                open.len(),
                groups.len()
            ),
        );
    }
    let same = found.best.replay.total == replayed.total;
    drop(replayed);
    let findings = Findings {
        program: &program,
        table: &table,
        prices: &prices,
        model: &model,
        groups: &groups,
        maxima: &maxima,
        assignment: &assignment,
        limits: &limits,
        real: Some(&found).filter(|_| !same),
    };
    let mut audit = findings.audit(warnings.clone());
    audit.ended_early = ended_early;
    audit.trust = request.trust;
    if request.trace {
        method::trace(&mut audit, &program, &model, &groups, &maxima);
    }
    if audit.bound.lower < audit.bound.model {
        audit.stands_between = Some(stands_between(&program, &found.best));
    }
    let mut loops = loops(&program, &times, &model, &limits).map_err(Failure::Internal)?;
    if whole {
        loops.open = unbounded::unasked(&program);
    }
    audit.doubts.extend(loops.found.iter().map(|one| {
        format!(
            "a scan can go round the loop to line {} without end: nothing bounds it",
            one.to.line
        )
    }));
    audit.unbounded = loops.found;
    let few = loops.open.iter().take(10);
    audit.doubts.extend(few.map(|one| {
        format!("whether the loop to line {} can run without end was not found out", one.to.line)
    }));
    if let Some(more) = loops.open.len().checked_sub(10).filter(|&more| more > 0) {
        audit.doubts.push(format!("nor was it of {more} more loops"));
    }
    if program.shows_way {
        audit.path = findings.path(&found.best.replay);
    }
    let outlasts = |shortest| outlasts(shortest, audit.bound.upper);
    audit.doubts.extend(program.shortest_timer.and_then(outlasts));
    audit.facts.extend(request.times.iter().map(|Override { name, on, off }| {
        let idle = if on == off { String::new() } else { format!(", {off} where it does not run") };
        format!("{name} takes {on}{idle}")
    }));
    audit.clocked = program.clocked;
    if audit.unbounded.is_empty() && !whole {
        audit.witness_run = power_up::run(&program, &prices, &found, &limits);
        let possible = audit.possible();
        if audit.clocked.is_some() {
            // Every scan takes as long; the clock may be slower, and is not known to be.
            audit.witness_run.iter_mut().for_each(|scan| scan.took = scan.took.min(possible));
        }
    }
    audit.facts.extend(request.facts.of_the_plant());
    audit.facts.extend(request.clock.map(StatedClock::to_string));
    if !loops.open.is_empty() {
        budget.cut("asking for loops without end", "some of them were not asked to the end");
    }
    if request.confirm {
        stage("confirming");
        method::confirm(&mut audit, request, &model, &groups, &maxima, &budget)?;
    }
    audit.cuts = budget.cuts();
    audit.elapsed = start.elapsed();
    let cuts = audit.cuts.clone();
    let followed = Followed { start, program, table, prices, model, groups, warnings, cuts, whole };
    Ok(Concluded { audit, followed, maxima })
}

/// The program that the source means, and the table that prices it.
fn understand(project: &dyn Project, request: &Request<'_>) -> Result<(Program, Table), Failure> {
    let open = project.open();
    if request.clock.is_some() && !open.clock {
        return Err(Failure::from(no_clock()));
    }
    if request.facts.latched.is_some() && !open.latched {
        let message = "[io] latched is stated, but of this PLC it is known";
        let fault =
            request.facts.fault(["io", "latched"], Part::Key, Code::Facts, message, "leave it out");
        return Err(Failure::from(fault));
    }
    if let (Some(StatedClock::Period { .. }), [time, ..]) = (request.clock, request.times) {
        let message = format!("--clock and --time {} both state how long a word takes", time.name);
        let found = Diagnostic::file(Code::NoClock, "", message, "leave one of the two out");
        return Err(Failure::from(found));
    }
    let mut table = choose_table(request, project.cpu())?;
    request.clock.into_iter().for_each(|clock| table.set_clock(clock));
    let program = project.decode(&Options {
        cpu: request.cpu,
        family: table.family.as_deref(),
        is_user_instruction: &|name| table.knows(name),
        facts: request.facts,
    })?;
    for area in program.areas.iter().filter(|area| !area.aliases.is_empty()) {
        table.join_cells(&[&[area.name.as_str()], area.aliases].concat());
    }
    Ok((program, table))
}

/// Why the bound may be too low where a scan could last as long as a timer: in one scan, a timer that was just
/// started has not run out.
fn outlasts(shortest: Picos, upper: Picos) -> Option<String> {
    (upper >= shortest).then(|| {
        format!("a scan may last longer than the shortest timer ({shortest}), which is taken not to run out within the scan that starts it")
    })
}

/// A count for a routine that is not there is a slip of the pen, and another is left without.
fn know_interrupts(program: &Program, request: &Request<'_>) -> Result<(), Failure> {
    let known: BTreeSet<String> =
        program.interrupts.iter().map(|one| one.name.to_ascii_uppercase()).collect();
    let faults: Vec<Diagnostic> = request
        .facts
        .interrupts
        .keys()
        .filter(|label| !known.contains(*label))
        .take(MOST_TOLD)
        .map(|label| {
            let message = format!("how often {label} interrupts a scan is stated, but the program has no interrupt routine of that name");
            let names: Vec<&str> =
                program.interrupts.iter().take(MOST_TOLD).map(|one| one.name.as_str()).collect();
            let help = match names.as_slice() {
                [] => "it has no interrupt routines at all".to_owned(),
                names => format!("its interrupt routines are {}", names.join(", ")),
            };
            request.facts.fault(["interrupts", label], Part::Key, Code::NoInterrupt, message, &help)
        })
        .collect();
    if faults.is_empty() { Ok(()) } else { Err(Failure::Input(faults)) }
}

/// The table that the user names, else the built-in one for the CPU, with the user's times in it.
fn choose_table(request: &Request<'_>, source_cpu: Option<&str>) -> Result<Table, Failure> {
    let file = request.inputs.first().map_or("", |input| &input.name);
    let cpu = request.cpu.or(source_cpu);
    let mut table = match (request.table, cpu) {
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
            let names = crate::timing::table::builtin::names().join(", ");
            return Err(Failure::from(Diagnostic::file(
                Code::NoTable,
                file,
                "the source does not name its CPU, so its instructions have no times",
                format!(
                    "name the CPU with --cpu, or a table with --table: one of {names}, or a file of your own"
                ),
            )));
        }
    };
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
    Ok(table)
}

/// Times that were stated for what the program does not have, perhaps by a slip of the pen, and those that do not hold
/// for all instructions of the name, since the table's rows for some of them stand.
fn unused_times(times: &[Override], program: &Program, prices: &Prices) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    for Override { name, .. } in times {
        let stated = |row: &str| times.iter().any(|time| time.name.eq_ignore_ascii_case(row));
        let (mut used, mut others) = (false, BTreeSet::new());
        for (instruction, price) in program.instructions.iter().zip(&prices.instructions) {
            let Some(price) = price else { continue };
            used |= price.row.split(" + ").any(|row| row.eq_ignore_ascii_case(name));
            let row = price.row.split(" + ").next().unwrap_or_default();
            let names = instruction.timing.iter().flat_map(|key| &key.names);
            if !stated(row) && names.into_iter().any(|other| other.eq_ignore_ascii_case(name)) {
                others.insert(row);
            }
        }
        let rows = others.into_iter().collect::<Vec<_>>().join(", ");
        let (message, help) = match (used, rows.is_empty()) {
            (true, true) => continue,
            (_, false) => (
                format!(
                    "--time {name} does not hold for {rows}: what the table has of these is dearer, or stated"
                ),
                "state these too if they are meant",
            ),
            (false, true) => (
                format!("--time {name}: no instruction of the program has its time from this name"),
                "write the name as the report's table rows do, such as MOV or OUT:T",
            ),
        };
        warnings.push(Diagnostic::file(Code::UnusedTime, "", message, help).warning());
    }
    warnings
}

fn no_clock() -> Diagnostic {
    let message = "--clock says nothing about this CPU: its instructions take different times";
    Diagnostic::file(Code::NoClock, "", message, "leave --clock out; --table and --time give times")
}

fn refuse_assumed(program: &Program, prices: &Prices) -> Result<(), Failure> {
    let mut first: std::collections::BTreeMap<&str, (usize, usize)> =
        std::collections::BTreeMap::new();
    for (index, price) in prices.instructions.iter().enumerate() {
        if let Some(price) = price
            && price.evidence == Evidence::Assumed
        {
            first.entry(&price.row).or_insert((index, 0)).1 += 1;
        }
    }
    let help =
        "give a time with --time or in a table of your own (--table), or leave --strict-times out";
    let mut faults: Vec<Diagnostic> = first
        .into_iter()
        .map(|(row, (index, count))| {
            let more = if count > 1 { format!(" (and {} more)", count - 1) } else { String::new() };
            let message = format!("the time of row {row} is assumed{more}");
            program.fault(&program.instructions[index], Code::AssumedTime, message, help)
        })
        .collect();
    for term in prices.overhead.iter().filter(|term| term.evidence == Evidence::Assumed) {
        let message = format!("the scan's term {} is assumed: {}", term.name, term.why);
        faults.push(Diagnostic::file(Code::AssumedTime, "", message, help));
    }
    if let Some(Factor { text, source, .. }) =
        prices.factor.as_ref().filter(|factor| factor.evidence == Evidence::Assumed)
    {
        let message = format!("the factor {text} on the whole scan is assumed: {source}");
        faults.push(Diagnostic::file(Code::AssumedTime, "", message, help));
    }
    if faults.is_empty() { Ok(()) } else { Err(Failure::Input(faults)) }
}

/// The groups' best assignments in one, since they share no variable; and what else it takes for a scan that
/// keeps the stated facts.
pub(super) fn together(
    request: &Request<'_>,
    budget: &Budget<'_>,
    model: &ScanModel,
    groups: &[Group],
    maxima: &mut [Maximum],
) -> Result<Assignment, Failure> {
    let mut all = Assignment(vec![0; model.variables.len()]);
    for (group, maximum) in groups.iter().zip(maxima) {
        // A search that ended before it found any allowed scan has no best one.
        if !maximum.kept {
            let constraints = Group { charges: Vec::new(), ..group.clone() };
            (maximum.best, maximum.kept) = (allowed(request, budget, model, &constraints)?, true);
            maximum.lower = model.cost(&group.charges, &maximum.best.whole(model));
        }
        maximum.best.put(&mut all);
    }
    if let Some(rest) = groups::unpriced(model, groups) {
        allowed(request, budget, model, &rest)?.put(&mut all);
    }
    Ok(all)
}

/// Some values that keep the constraints of a group without charges.
fn allowed(
    request: &Request<'_>,
    budget: &Budget<'_>,
    model: &ScanModel,
    constraints: &Group,
) -> Result<Portion, Failure> {
    // Nearly always found at once, so it is looked for even where the time is over.
    let least = Instant::now() + GRACE;
    let deadline = budget.deadline().map(|end| end.max(least));
    let limits = Limits { deadline, ..Limits::default() };
    let found = maximum(model, constraints, Method::Auto, &limits);
    if found.kept {
        return Ok(found.best);
    }
    if deadline.is_some_and(|end| Instant::now() >= end) {
        return Err(Failure::from(Diagnostic::file(
            Code::Time,
            request.inputs.first().map_or("", |input| &input.name),
            "in the time given no scan was found that keeps all the stated ranges",
            "give it more time (--time-limit), or state less",
        )));
    }
    Err(Failure::from(Diagnostic::file(
        Code::Facts,
        request.inputs.first().map_or("", |input| &input.name),
        "no scan keeps all the stated ranges",
        "look for two ranges that concern the same word",
    )))
}

/// Holds the scan that was replayed against what the analysis says that it costs.
pub(super) fn confirm(
    program: &Program,
    model: &ScanModel,
    groups: &[Group],
    maxima: &[Maximum],
    assignment: &Assignment,
    replayed: &Replay,
) -> Result<(), Failure> {
    let values = model.circuit.evaluate(assignment);
    let said: Picos = model.charges.iter().map(|charge| charge.cost(&values)).sum();
    if replayed.total != said {
        return Err(Failure::Internal(format!(
            "the interpreter's scan takes {}, the analysis says {said}{}",
            replayed.total,
            first_difference(program, model, &values, replayed)
        )));
    }
    if let Some(&range) = replayed.broken_ranges.first() {
        let cell = program.cell_name(program.ranges[range].cells[0]);
        return Err(Failure::Internal(format!("the worst scan breaks the range of {cell}")));
    }
    if !replayed.broken_invariants.is_empty() {
        return Err(Failure::Internal("the worst scan starts as no scan does".to_owned()));
    }
    for (group, maximum) in groups.iter().zip(maxima) {
        let cost: Picos = group.charges.iter().map(|&c| model.charges[c].cost(&values)).sum();
        if cost != maximum.lower || maximum.lower > maximum.upper {
            return Err(Failure::Internal(format!(
                "a group's best scan costs {cost}, its search says {} to {}",
                maximum.lower, maximum.upper
            )));
        }
    }
    Ok(())
}

/// The first execution that the interpreter and the analysis price differently, for the message.
fn first_difference(
    program: &Program,
    model: &ScanModel,
    values: &Values,
    replayed: &Replay,
) -> String {
    let mut costs: std::collections::BTreeMap<(usize, Vec<crate::program::Frame>), (Picos, Picos)> =
        std::collections::BTreeMap::new();
    for charge in &model.charges {
        let key = (charge.instruction, charge.frames.clone());
        costs.entry(key).or_default().0 += charge.cost(values);
    }
    for event in &replayed.events {
        costs.entry((event.instruction, event.frames.to_vec())).or_default().1 += event.cost;
    }
    let different = costs.iter().find(|(_, (said, ran))| said != ran);
    different.map_or(String::new(), |((instruction, _), (said, ran))| {
        let at = &program.instructions[*instruction];
        format!(
            "; first at {}:{} {}: {ran} and {said}",
            at.place.of(&program.files).name,
            at.place.line,
            at.text
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay::replay;

    #[test]
    fn a_scan_that_the_interpreter_prices_differently_is_an_internal_error() {
        let text = "LD X0\nMOV K1 D0\nLDI X0\nBMOV D0 D10 K5\nEND\n";
        let inputs = [Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() }];
        let facts = Facts::default();
        let request = Request { cpu: Some("Q26UDV"), ..Request::new(&inputs, &facts) };
        let followed = follow(&request).expect("a program");
        let Concluded { followed, mut maxima, .. } =
            conclude(followed, &request).expect("an audit");
        let Followed { program, prices, model, groups, .. } = &followed;
        let budget = Budget::new(followed.start, None, request.cancelled, Vec::new());
        let assignment = together(&request, &budget, model, groups, &mut maxima).expect("a scan");
        let times = prices.times();
        let mut replayed = replay(program, &times, &groups::witness(model, &assignment));
        let confirmed = |maxima: &[Maximum], replayed: &Replay| {
            confirm(program, model, groups, maxima, &assignment, replayed)
        };
        let internal =
            |maxima: &[Maximum], replayed: &Replay, what: &str| match confirmed(maxima, replayed) {
                Err(Failure::Internal(told)) => assert!(told.contains(what), "{told}"),
                other => panic!("{other:?}"),
            };
        assert_eq!(confirmed(&maxima, &replayed), Ok(()));
        replayed.total += Picos(1);
        internal(&maxima, &replayed, "the interpreter's scan takes");
        replayed.total = replay(program, &times, &groups::witness(model, &assignment)).total;
        maxima[0].lower += Picos(1);
        internal(&maxima, &replayed, "its search says");
    }
}

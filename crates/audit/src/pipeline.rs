//! The pipeline from source text to an audit: typed stages, each of which builds on the one before.

use super::Audit;
use super::assemble::{Findings, Finished};
use super::contradiction::{self, Stages};
use super::failure::Failure;
use super::hints::Hints;
use super::method;
use super::model_search::Searched;
use super::modelling::{fit, keep_in_range, model_of};
use super::power_up;
use super::priced::Priced;
use super::proved::{self, Proved};
use super::reachable;
use super::real::{self, EarlyRuns, RunResults};
use super::refinement::{Refinement, Runs};
use super::request::{Progress, Request};
use super::response::Delays;
use super::start_states;
use super::stated;
use super::timer_edges;
use super::timers;
use super::unbounded::{self, Loops};
use super::understood::Understood;
use super::watchdog::ScanControlAnalysis;
use scanbound_base::budget::{Budget, EarlyStop};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Times;
use scanbound_front::MachineOptions;
use scanbound_ir::Program;
use scanbound_ir::meaning::Knowledge;
use scanbound_model::groups;
use scanbound_model::{Group, ScanModel};
use scanbound_passes::values::Trust;
use scanbound_solve::{Limits, Maximum};
use scanbound_timing::price::Prices;
use scanbound_timing::table::Table;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// A project that was read, priced and followed: its program and the model of one scan, whose longest time is then
/// searched.
pub struct Followed {
    /// When the audit began.
    start: Instant,
    /// The program, with what the passes found and what following the scan added.
    pub program: Program,
    /// The timing table.
    pub table: Table,
    /// The times of every instruction, and the overhead of a scan.
    pub prices: Prices,
    /// The model of one scan: its charges, their guards and the constraints.
    pub model: ScanModel,
    /// The groups of the model, the longest time first.
    pub groups: Vec<Group>,
    /// Which facts and options the user can state for this PLC, such as its clock.
    pub machine: MachineOptions,
    warnings: Vec<Diagnostic>,
    /// The stages that the time limit or the user ended early.
    cuts: Vec<EarlyStop>,
    /// Whether the model is only the structural bound, which does not say which instructions can run together.
    structural_only: bool,
    /// The mutually exclusive relays that were found.
    relays: reachable::Relays,
}

impl Followed {
    /// The mutually exclusive relays that were found. Empty if they were not searched for.
    pub(super) fn relays(&self) -> &reachable::Relays {
        &self.relays
    }

    /// Whether the model is only the structural bound, which does not say which instructions can run together.
    pub(super) fn is_structural_only(&self) -> bool {
        self.structural_only
    }
}

/// The functions that other modules use to audit again with other facts.
pub(super) const STAGES: Stages = Stages { read, audit };

/// Audits a project: reads, prices and follows it, searches its longest scan and replays that scan.
///
/// # Errors
/// All faults of the input at once, or that the analysis and the interpreter disagree.
pub fn audit(request: &Request<'_>) -> Result<Audit, Failure> {
    Ok(concluded(request)?.audit)
}

/// As [`audit`], but also returns the program and the model in which the result was found.
///
/// # Errors
/// All faults of the input at once, or that the analysis and the interpreter disagree.
pub fn concluded(request: &Request<'_>) -> Result<Concluded, Failure> {
    let limited = PreparedProject::of(request)?.limit_size(request)?;
    let lower_bound = LowerBoundSearch::of(&limited, request);
    let handover = lower_bound.as_ref().map(|runs| (runs, Mutex::new(Handover::default())));
    let handover = handover.as_ref();
    let (searched, late) = rayon::join(
        || {
            let followed = limited.followed(request)?;
            let early = handover.and_then(|(runs, handover)| {
                let given = (followed.program.clone(), followed.prices.clone());
                Some((runs, complete(handover, |half| half.followed = Some(given))?))
            });
            let known = handover.map(|(runs, _)| &runs.program);
            let (searched, kept) = rayon::join(
                || followed.searched(request, known),
                || early.map(|(runs, (early, given))| runs.kept(request, early, &given)),
            );
            Ok::<_, Failure>((searched?, kept))
        },
        || handover.and_then(|(runs, handover)| runs.run(request, handover)),
    );
    let (searched, kept) = searched?;
    searched.concluded(request, kept.or(late))
}

/// Reads a project's files into a program and applies the stated facts. No pass runs, and nothing is priced or
/// followed.
///
/// # Errors
/// All faults of the input at once.
pub fn read(request: &Request<'_>) -> Result<Program, Failure> {
    Ok(Understood::of(request, &request.budget())?.program)
}

/// A project that is read and priced, before any pass changes it: an emulated CPU runs such a program.
pub struct Ready {
    /// The program as the front lowered it, with the stated facts.
    pub program: Program,
    /// The timing table.
    pub table: Table,
    /// The times of every instruction, and the overhead of a scan.
    pub prices: Prices,
    /// The warnings of reading and pricing; those of the request come first.
    pub warnings: Vec<Diagnostic>,
}

/// Reads and prices a project without running the passes or following it.
///
/// # Errors
/// All faults of the input at once.
pub fn ready(request: &Request<'_>) -> Result<Ready, Failure> {
    let Priced { program, table, prices, warnings } =
        Priced::of(Understood::of(request, &request.budget())?, request)?;
    Ok(Ready { program, table, prices, warnings })
}

/// Reads a project, runs the passes, and prices and follows it, without searching it.
///
/// # Errors
/// All faults of the input at once.
pub fn follow(request: &Request<'_>) -> Result<Followed, Failure> {
    PreparedProject::of(request)?.priced(request)
}

/// A project that was read and processed by the passes: everything that does not depend on times.
#[derive(Clone)]
pub struct PreparedProject {
    start: Instant,
    understood: Understood,
    /// The stages that the time limit or the user ended early.
    cuts: Vec<EarlyStop>,
}

impl PreparedProject {
    /// Reads a project and runs the passes.
    ///
    /// # Errors
    /// All faults of the input at once.
    pub fn of(request: &Request<'_>) -> Result<PreparedProject, Failure> {
        let start = Instant::now();
        let budget = Budget::new(start, request.time_limit, request.cancelled, Vec::new());
        let mut understood = Understood::of(request, &budget)?;
        if !request.use_chart_exclusion {
            let exclusions = std::mem::take(&mut understood.program.charts.exclusions);
            let program = &mut understood.program;
            program.invariants.drain(..exclusions);
            let moved = |end: usize| end.saturating_sub(exclusions);
            program.stated_exclusions =
                moved(program.stated_exclusions.start)..moved(program.stated_exclusions.end);
        }
        let settings =
            scanbound_passes::Settings { trust: request.trusted(), budget: Some(&budget) };
        let report_stage = |name| (request.progress)(Progress::Stage(name));
        request.passes.run(&mut understood.program, &settings, report_stage)?;
        let cuts = budget.early_stops();
        Ok(PreparedProject { start, understood, cuts })
    }

    /// The program, with what the passes found.
    #[must_use]
    pub fn program(&self) -> &Program {
        &self.understood.program
    }

    /// The timing table.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.understood.table
    }

    /// The same project with another timing table of the same CPU family, to which the user's times, factor and clock
    /// are applied. The time limit begins anew.
    #[must_use]
    pub fn with_table(&self, table: Table, request: &Request<'_>) -> PreparedProject {
        let understood = self.understood.with_table(table, request);
        PreparedProject { start: Instant::now(), understood, cuts: self.cuts.clone() }
    }

    /// Prices and follows the project without searching it.
    ///
    /// # Errors
    /// All instructions that have no time; or that the scan cannot be followed, or is too long.
    pub fn priced(self, request: &Request<'_>) -> Result<Followed, Failure> {
        self.limit_size(request)?.followed(request)
    }

    fn limit_size(self, request: &Request<'_>) -> Result<SizeLimited, Failure> {
        let PreparedProject { start, understood, cuts } = self;
        let machine = understood.machine;
        let Priced { mut program, table, mut prices, warnings } = Priced::of(understood, request)?;
        let executed = fit(&mut program)?;
        // Instructions that the summaries added have no price.
        prices.instructions.resize(program.instructions.len(), None);
        timers::resolve_by_sum(&mut program, &prices);
        Ok(SizeLimited { start, program, table, prices, executed, machine, warnings, cuts })
    }
}

/// A priced project in which loops and routines that run too often are charged as a whole, and not followed.
struct SizeLimited {
    start: Instant,
    program: Program,
    table: Table,
    prices: Prices,
    /// The largest number of instructions that a scan executes.
    executed: u64,
    machine: MachineOptions,
    warnings: Vec<Diagnostic>,
    cuts: Vec<EarlyStop>,
}

impl SizeLimited {
    fn followed(self, request: &Request<'_>) -> Result<Followed, Failure> {
        let SizeLimited {
            start,
            mut program,
            table,
            mut prices,
            executed,
            machine,
            warnings,
            cuts,
        } = self;
        let budget = Budget::new(start, request.time_limit, request.cancelled, cuts);
        (request.progress)(Progress::Stage("following the scan"));
        let (mut model, mut structural_only) =
            model_of(&mut program, &mut prices, executed, &budget)?;
        if !structural_only && timers::resolve(&mut program, &prices, &model) {
            (model, structural_only) = model_of(&mut program, &mut prices, executed, &budget)?;
        }
        if !structural_only {
            timers::note_gaps(&mut program, &prices, &model);
            let tighter = timer_edges::exclude(&mut program, &prices, &model, &budget);
            model = tighter.unwrap_or(model);
        }
        let trusts_relays = trusts_relays(&program, request);
        let mut relays = reachable::Relays::default();
        if trusts_relays && request.relays && !structural_only {
            (request.progress)(Progress::Stage(reachable::STAGE));
            let trust = request.trusted();
            let hints = request.net.map_or_else(Vec::new, |net| Hints::of(net, &program).bits());
            let tighter;
            (tighter, relays) =
                reachable::exclude(&mut program, &prices, &model, trust, &hints, &budget);
            model = tighter.unwrap_or(model);
        }
        keep_in_range(&program, &table, &prices, &model)?;
        let groups = groups::groups(&model);
        let cuts = budget.early_stops();
        Ok(Followed {
            start,
            program,
            table,
            prices,
            model,
            groups,
            machine,
            warnings,
            cuts,
            structural_only,
            relays,
        })
    }
}

/// Whether at least some relays are trusted to be written by the program alone, so that mutually exclusive relays are
/// worth searching for: all with [`Trust::All`], those under `[internal]` with [`Trust::Counts`].
fn trusts_relays(program: &Program, request: &Request<'_>) -> bool {
    match request.trusted() {
        Trust::None => false,
        Trust::Counts => !program.internal.is_empty(),
        Trust::All => true,
    }
}

/// The limits of a search: this deadline, and the request's cancellation.
fn limits<'a>(request: &Request<'a>, deadline: Option<Instant>) -> Limits<'a> {
    Limits { deadline, cancelled: request.cancelled, ..Limits::default() }
}

/// If a scan may execute at least this many instructions, real runs are made on another thread while the program is
/// followed and searched, unless the search for exclusive relays is going to change the program.
const MANY: u64 = 10_000;

/// Makes real runs of a large program on another thread, while the program is followed and searched. They give a lower
/// bound.
///
/// Following may change the program: it may replace reads by any value, or follow summarised loops after all. In that
/// case these runs are discarded, and new ones are made after the search. If it only excludes more scans, the longest
/// of these runs is repeated in the changed program, and replaced until an earlier scan can leave its start state.
struct LowerBoundSearch {
    /// The program as it was before the analysis followed it.
    program: Program,
    least: Vec<Times>,
    deadline: Option<Instant>,
}

impl LowerBoundSearch {
    /// The search for a program. `None` for small programs, and for programs that the search for exclusive relays is
    /// going to change.
    fn of(limited: &SizeLimited, request: &Request<'_>) -> Option<LowerBoundSearch> {
        let is_worth_it = limited.executed >= MANY && !trusts_relays(&limited.program, request);
        // No lower bound rests on a present value that others wrote without its flag.
        let program = || {
            let mut program = limited.program.clone();
            let consistency = limited.program.timekeeping.consistency.values();
            program.invariants.extend(consistency.flatten().cloned());
            program
        };
        is_worth_it.then(|| LowerBoundSearch {
            program: program(),
            least: limited.prices.least_times(),
            deadline: request.time_limit.map(|limit| limited.start + limit),
        })
    }

    /// Makes the runs. `None` if the program has not been followed by then: the thread that follows it continues with
    /// these runs.
    fn run(
        &self,
        request: &Request<'_>,
        handover: &Mutex<Handover>,
    ) -> Option<Result<EarlyRuns, String>> {
        let limits = limits(request, self.deadline);
        let search = real::RunSearch { program: &self.program, least: &self.least, limits };
        match search.search_early() {
            Ok(early) => {
                let (early, given) = complete(handover, |half| half.early = Some(early))?;
                Some(self.kept(request, early, &given))
            }
            Err(fault) => Some(Err(fault)),
        }
    }

    /// The runs, of which the longest is repeated in the program as it is when it has been followed, and replaced until
    /// an earlier scan can leave its start state.
    fn kept(
        &self,
        request: &Request<'_>,
        early: EarlyRuns,
        (program, prices): &(Program, Prices),
    ) -> Result<EarlyRuns, String> {
        if !real::has_same_instructions(&self.program, program) {
            return Ok(early);
        }
        let limits = limits(request, self.deadline);
        let search = real::RunSearch { program, least: &self.least, limits };
        search.kept(search.repeated(early)?, prices, request.trusted())
    }
}

/// What one thread leaves for the other one: early real runs, or the program as it is when it has been followed, with
/// its prices. The second thread takes both and continues.
#[derive(Default)]
struct Handover {
    early: Option<EarlyRuns>,
    followed: Option<(Program, Prices)>,
}

/// Leaves one half. Returns both if the other one is there.
fn complete(
    handover: &Mutex<Handover>,
    leave: impl FnOnce(&mut Handover),
) -> Option<(EarlyRuns, (Program, Prices))> {
    let mut halves = handover.lock().unwrap_or_else(PoisonError::into_inner);
    leave(&mut halves);
    match std::mem::take(&mut *halves) {
        Handover { early: Some(early), followed: Some(followed) } => Some((early, followed)),
        half => {
            *halves = half;
            None
        }
    }
}

/// An audit, with the program and model in which it was found.
pub struct Concluded {
    /// The audit.
    pub audit: Audit,
    /// The project, with the model and groups that were searched last. The search may have changed its program.
    pub followed: Followed,
    /// The maximum of each group, parallel to `followed.groups`.
    pub maxima: Vec<Maximum>,
}

/// Searches the groups' maxima, replays the longest scan, makes real runs and assembles the audit.
///
/// # Errors
/// That the analysis and the interpreter disagree.
pub fn conclude(followed: Followed, request: &Request<'_>) -> Result<Concluded, Failure> {
    followed.searched(request, None)?.concluded(request, None)
}

/// A project whose groups' maxima were searched.
struct SearchedProject<'r> {
    /// The project. Its model and groups are in `searched`.
    followed: Followed,
    delays: Option<Delays>,
    searched: Searched<'r>,
    runs: Runs,
}

impl Followed {
    /// Searches the groups' maxima. Also makes real runs, unless a second thread makes them for the same program
    /// (`early`).
    fn searched<'r>(
        mut self,
        request: &Request<'r>,
        early: Option<&Program>,
    ) -> Result<SearchedProject<'r>, Failure> {
        let delays = request.response.map(|given| Delays::of(given, &self.program, &self.table));
        let delays = delays.transpose()?;
        let budget = self.budget(request);
        let refinement = self.refinement(request, &budget);
        let model = (std::mem::take(&mut self.model), std::mem::take(&mut self.groups));
        let found = refinement.search(&mut self.program, &mut self.prices, model, early);
        let (searched, runs) = found
            .map_err(|failure| contradiction::with_contradicting_facts(STAGES, request, failure))?;
        self.cuts = budget.early_stops();
        Ok(SearchedProject { followed: self, delays, searched, runs })
    }

    /// The budget of the next stage. It takes over the list of stages that ended early so far.
    fn budget<'a>(&mut self, request: &Request<'a>) -> Budget<'a> {
        let cuts = std::mem::take(&mut self.cuts);
        Budget::new(self.start, request.time_limit, request.cancelled, cuts)
    }

    fn refinement<'a, 'r>(
        &self,
        request: &'a Request<'r>,
        budget: &'a Budget<'a>,
    ) -> Refinement<'a, 'r> {
        Refinement {
            request,
            budget,
            limits: limits(request, budget.deadline()),
            doubtful_from: self.program.shortest_timer,
            structural_only: self.structural_only,
        }
    }

    /// The loops without a bound that a scan can reach, and those for which this was not decided. For a structural
    /// bound, the latter are all that the program has.
    fn endless_loops(
        &self,
        model: &ScanModel,
        knowledge: &Knowledge,
        limits: &Limits<'_>,
        budget: &Budget<'_>,
    ) -> Result<Loops, Failure> {
        let times = self.prices.times();
        let mut loops = unbounded::loops(&self.program, &times, model, knowledge, limits)
            .map_err(Failure::Internal)?;
        if self.structural_only {
            loops.open = unbounded::unasked(&self.program);
        }
        if !loops.open.is_empty() {
            budget.record_stop(
                "searching for endless loops",
                "whether each loop of the program ends is not decided yet",
            );
        }
        Ok(loops)
    }
}

impl SearchedProject<'_> {
    /// Completes the real runs and builds the audit. `early`: the real runs that another thread made, if any.
    fn concluded(
        self,
        request: &Request<'_>,
        early: Option<Result<EarlyRuns, String>>,
    ) -> Result<Concluded, Failure> {
        let SearchedProject { mut followed, delays, searched, runs } = self;
        let runs = match (runs, early) {
            (Runs::OtherThread, Some(found)) => Runs::Beside(found.map_err(Failure::Internal)?),
            (runs, _) => runs,
        };
        let budget = followed.budget(request);
        note_open(&searched, &budget);
        let refinement = followed.refinement(request, &budget);
        let limits = limits(request, budget.deadline());
        let Followed { program, table, prices, .. } = &followed;
        let Searched {
            model,
            knowledge,
            groups,
            maxima,
            assignment,
            witness,
            replayed,
            upper,
            ended_early,
            prepared,
        } = searched;
        let model_total = replayed.total;
        drop(replayed);
        let findings = Findings {
            request,
            program,
            table,
            prices,
            model: &model,
            machine: followed.machine,
            groups: &groups,
            maxima: &maxima,
            assignment: &assignment,
            limits: &limits,
        };
        let traces = request.trace.then(|| method::traces(program, &model, &groups, &maxima));
        let loops = followed.endless_loops(&model, &knowledge, &limits, &budget)?;
        let is_bounded = loops.found.is_empty() && !followed.structural_only;
        let running = || {
            let found = refinement.longest(program, prices, (&witness, upper), runs)?;
            if !request.use_chart_exclusion {
                // Only the upper bound is wanted: start states that the chart excludes are allowed.
                return Ok((found.without_time(), Vec::new()));
            }
            let least = prices.least_times();
            let search = real::RunSearch { program, least: &least, limits };
            let (trust, longest) = (request.trusted(), (&witness, upper));
            let found = start_states::keep_possible(&search, prices, trust, longest, found);
            let mut found = found.map_err(Failure::Internal)?;
            let sought = |found: &mut RunResults| {
                let is_possible = trust == Trust::All || found.best.is_possible();
                if is_bounded && is_possible {
                    power_up::run(&search, prices, trust, found)
                } else {
                    Vec::new()
                }
            };
            let mut run = sought(&mut found);
            if run.is_empty() && trust == Trust::All {
                // Whether timers have run for so long only a run shows.
                let kept = start_states::keep_timers(&search, prices, trust, longest, &found);
                if let Some(kept) = kept.map_err(Failure::Internal)? {
                    found = kept;
                    run = sought(&mut found);
                }
            }
            if run.is_empty() && found.is_start_undecided {
                found = found.without_time();
                run = sought(&mut found);
            }
            search.within(&found.best, upper).map_err(Failure::Internal)?;
            Ok::<_, Failure>((found, run))
        };
        let (explained, ran) = rayon::join(|| findings.explain(prepared), running);
        let (mut found, run) = ran?;
        let mut proved = Proved::default();
        if request.proves_facts {
            let least = prices.least_times();
            let search = real::RunSearch { program, least: &least, limits };
            proved = proved::proved(&search, request.facts, followed.structural_only, &mut found)
                .map_err(Failure::Internal)?;
        }
        let model_of_scan = Some(&model).filter(|_| !followed.structural_only);
        let analysis = ScanControlAnalysis {
            program,
            prices,
            table,
            facts: request.facts,
            trust: request.trusted(),
            model: model_of_scan,
        };
        let least = prices.least_times();
        let search = real::RunSearch { program, least: &least, limits };
        let watched = analysis.analyse((&found, !run.is_empty()), &search);
        let (watchdog, cycle) = watched.map_err(Failure::Internal)?;
        let left = stated::violations(program, request.facts, &found.violations)?;
        let warnings = [&*followed.warnings, &*left].concat();
        let mut opinions = None;
        if request.confirm {
            (request.progress)(Progress::Stage("confirming"));
            opinions = Some(method::opinions(request, &model, &groups, &maxima, &budget)?);
        }
        let cuts = budget.early_stops();
        let finished = Finished {
            found: &found,
            same: found.best.is_possible()
                && found.best.replay.total == model_total
                && found.witness == witness,
            start: followed.start,
            warnings: warnings.clone(),
            cuts: cuts.clone(),
            ended_early,
            explained,
            searches: method::searches(&maxima, traces, opinions),
            loops,
            run,
            delays,
            proved,
            watchdog,
            cycle,
        };
        let audit = findings.audit(finished);
        let followed = Followed { model, groups, warnings, cuts, ..followed };
        Ok(Concluded { audit, followed, maxima })
    }
}

/// Records how many groups have no exact maximum, if the time limit or the user ended the search.
fn note_open(searched: &Searched<'_>, budget: &Budget<'_>) {
    let unsolved = searched.maxima.iter().filter(|found| found.lower < found.upper);
    let unsolved: Vec<&Maximum> = unsolved.collect();
    if unsolved.is_empty() || searched.ended_early {
        return;
    }
    let open = format!(
        "for {} of {} groups of instructions, the search for the longest time did not end",
        unsolved.len(),
        searched.groups.len()
    );
    budget.record_stop("searching", open);
}

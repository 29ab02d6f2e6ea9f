//! The search for a scan that a PLC can make: a real run of the model's longest scan, then of the longest scan that
//! remains after what this run showed, and so on.

use super::modelling::LONGEST_SCAN;
use super::violations::Violations;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::{ChoiceKind, Knowledge, Operation};
use scanbound_ir::{AreaKind, Cell, ChoiceId, ChoiceKey, Program, Step, Witness, WordSource};
use scanbound_model::groups::{groups, unused_constraints, witness};
use scanbound_model::lower_bound::{Treatment, lower_bound_model};
use scanbound_model::{Assignment, Atom, Lit, Origin, ScanModel, VarId, VarKind};
use scanbound_replay::run::Outside;
use scanbound_replay::{FreeValues, Readings, RealRun, StopReason, Stopped, Trace, real, traced};
use scanbound_scan::size_limits::SizeLimits;
use scanbound_scan::{Purpose, scan_model_with_knowledge};
use scanbound_solve::{Decisions, Limits, Method, maxima, maximum};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

/// The largest number of instructions that a real run executes.
const MAX_INSTRUCTIONS: u64 = 400_000;
/// The largest size of one model that includes what real runs showed: its nodes and questions about words.
const LARGEST: usize = 2_000_000;
/// The same for a large program, in which steering finds more in the same time.
const LARGEST_OF_LARGE: usize = 200_000;
/// The search for longer runs ends when its models have more gates in total.
const MAX_GATES: usize = 1_000_000;
/// The largest number of rounds of the search for longer runs.
const MAX_ROUNDS: usize = 400;
/// From this number of instructions on, a program is large.
const LARGE: usize = 10_000;
/// The largest model, in gates, in which the longest scan after power-up is searched for separately.
const LARGEST_FIRST: usize = 100_000;
/// A model with more gates takes as long as a good part of the bound's search. With such models, the search goes on
/// only as long as each round makes the run longer by 1/`WORTH`.
const MAX_GATES_FOR_SMALL_GAINS: usize = 300_000;
/// A round was worth its time if it made the run longer by at least 1/`WORTH`.
const WORTH: u64 = 100;
/// The largest number of decisions of a solver for a group in a round: a long scan is wanted, not a proof that none is
/// longer.
const MAX_DECISIONS: u64 = 200_000;

/// The longest real run found, and what all runs showed.
#[derive(Clone)]
pub struct RunResults {
    /// The longest real run.
    pub best: RealRun,
    /// The start values of the longest real run, and its nondeterministic values.
    pub witness: Witness,
    /// What all real runs showed about operations.
    pub knowledge: Knowledge,
    /// The stated facts that real runs violate.
    pub violations: Violations,
    /// True if it was not decided whether any scan can start in the state in which the longest real run starts. Unless
    /// a run from power-up leads to the longest real run, no lower bound may then rest on it.
    pub is_start_undecided: bool,
    /// The time and the start values of the longest real run whose start state was examined and not excluded: an
    /// earlier scan may leave it, or that was not decided in time and need not be. `None` if there is none yet.
    pub kept: Option<(Picos, Witness)>,
    /// The number of gates of the last model in which a longer run was searched for. 0 if there was none.
    pub gates: usize,
}

impl RunResults {
    /// The results after the first run: what it showed is added to `knowledge`.
    pub(super) fn first(
        program: &Program,
        run: RealRun,
        start: Witness,
        knowledge: Knowledge,
    ) -> RunResults {
        let mut found = RunResults {
            best: run,
            witness: start,
            knowledge,
            violations: Violations::default(),
            is_start_undecided: false,
            kept: None,
            gates: 0,
        };
        learn(&mut found.knowledge, &mut found.best);
        found.violations.note(program, &found.best, None);
        found
    }

    /// Records what a run showed and violated. Returns whether it showed something new.
    pub(super) fn note(&mut self, program: &Program, run: &mut RealRun) -> bool {
        let news = learn(&mut self.knowledge, run);
        self.violations.note(program, run, None);
        news
    }

    /// If the best run is impossible, sets its time to 0 and removes its events: nothing is then known of any scan.
    fn without_impossible(self) -> RunResults {
        if self.best.is_possible() { self } else { self.without_time() }
    }

    /// Sets the best run's time to 0 and removes its events: nothing is then known of any scan.
    pub(super) fn without_time(mut self) -> RunResults {
        self.best.replay.total = Picos::ZERO;
        self.best.replay.events.clear();
        self.best.needed_devices.clear();
        self.is_start_undecided = false;
        self
    }

    /// Ends the best run with this operation error, sets its time to 0 and removes its events: on controllers with
    /// these readings the error stops the CPU before any scan that takes so long.
    pub(super) fn ends_in(&mut self, error: Stopped, readings: &Readings) {
        self.best.stopped = Some(error);
        self.best.readings = readings.keys().copied().collect();
        self.best.replay.total = Picos::ZERO;
        self.best.replay.events.clear();
        self.best.needed_devices.clear();
    }

    /// Keeps the run as the best one if it takes longer than the best run so far.
    pub(super) fn replace(&mut self, run: RealRun, start: Witness) {
        if run.replay.total > self.best.replay.total {
            (self.best, self.witness) = (run, start);
        }
    }

    /// Replaces the best run by this one if this one is better: a possible run is better than an impossible one, then
    /// the longer one.
    fn keep_better(&mut self, run: RealRun, start: Witness) {
        let rank = |run: &RealRun| (run.is_possible(), run.replay.total);
        if rank(&run) > rank(&self.best) {
            (self.best, self.witness) = (run, start);
        }
    }
}

/// The results of the real runs that were made before the search has found the model's longest scan.
pub struct EarlyRuns {
    pub(super) found: RunResults,
    /// Whether more rounds are worthwhile once further runs have shown more.
    goes_on: bool,
    /// The total number of gates of the models that were searched so far.
    gates: usize,
}

/// A search for long real runs of a program. A real run executes one scan as on a PLC.
pub struct RunSearch<'a> {
    pub program: &'a Program,
    /// The times of the instructions for lower bounds, parallel to the program's instructions: an unknown number of
    /// units counts as 0.
    pub least: &'a [Times],
    pub limits: Limits<'a>,
}

impl RunSearch<'_> {
    /// Makes the real runs that need no result of the bound's search: one in which all values are 0 or the nearest
    /// stated value, and counts of loops the largest; then those of the longest scans that certainly run as in the
    /// model. `Err` if an operation wrote a cell that its effects do not declare, or a word left the range that the
    /// analysis proved.
    pub fn search_early(&self) -> Result<EarlyRuns, String> {
        let start = Witness::default();
        let run = self.real(&start)?;
        let mut found = RunResults::first(self.program, run, start, Knowledge::new());
        let mut gates = 0;
        let goes_on = self.lengthen(&mut found, None, &mut gates)?;
        Ok(EarlyRuns { found, goes_on, gates })
    }

    /// Makes the best run longer: by rounds ([`Self::go_on`]), then by steering if the program is large. Returns
    /// whether further rounds are worthwhile.
    fn lengthen(
        &self,
        found: &mut RunResults,
        upper: Option<Picos>,
        gates: &mut usize,
    ) -> Result<bool, String> {
        // Rounds take long in a large program. If an operation error ends the run, it is led around it first.
        if self.is_large() && !found.best.is_possible() {
            self.steer(found, upper)?;
        }
        let goes_on = self.go_on(found, upper, gates)?;
        if self.is_large() {
            self.steer(found, upper)?;
        }
        Ok(goes_on)
    }

    /// This search, which ends when half of the time that is left has passed.
    pub(super) fn half_time(&self) -> RunSearch<'_> {
        let now = Instant::now();
        let half = |end: Instant| now + end.saturating_duration_since(now) / 2;
        let limits = Limits { deadline: self.limits.deadline.map(half), ..self.limits };
        RunSearch { limits, ..*self }
    }

    /// Repeats the longest of these runs, which were made in a program that has the same instructions, but knows less
    /// about the start of a scan and about timers ([`has_same_instructions`]). If the run turns out to be impossible,
    /// the search goes on.
    ///
    /// # Errors
    /// As for [`Self::search_early`].
    pub fn repeated(&self, early: EarlyRuns) -> Result<EarlyRuns, String> {
        let EarlyRuns { mut found, mut goes_on, mut gates } = early;
        found.best = self.real(&found.witness)?;
        learn(&mut found.knowledge, &mut found.best);
        // An earlier run may have violated a fact in a scan that this program excludes.
        found.violations = Violations::default();
        found.violations.note(self.program, &found.best, None);
        if !found.best.is_possible() {
            found.kept = None;
            gates = 0;
            let repaired = self.repaired(&found)?;
            found = repaired.unwrap_or(found);
            goes_on = self.lengthen(&mut found, None, &mut gates)?;
        }
        Ok(EarlyRuns { found, goes_on, gates })
    }

    /// Makes a real run of the model's longest scan, which starts from `longest`, in addition to the `early` runs, and
    /// makes it longer if it is the longest of all or the program is large. `Err` if an operation wrote a cell that its
    /// effects do not declare, or if a run takes longer than `upper`, the bound on all charges.
    pub fn continue_from(
        &self,
        longest: &Witness,
        upper: Picos,
        early: EarlyRuns,
    ) -> Result<RunResults, String> {
        let EarlyRuns { mut found, goes_on, mut gates } = early;
        self.within(&found.best, upper)?;
        let early = found.best.replay.total;
        let mut one = self.real(longest)?;
        self.within(&one, upper)?;
        found.note(self.program, &mut one);
        // Of two equally long runs, the model's own is shown.
        let before = std::mem::replace(&mut found.best, one);
        let start = std::mem::replace(&mut found.witness, longest.clone());
        // Steering may make this run the longest one, even if it is not.
        if self.is_large() || goes_on && found.best.replay.total > early {
            // The other half of the time is for examining where the run starts.
            self.half_time().lengthen(&mut found, Some(upper), &mut gates)?;
        }
        found.keep_better(before, start);
        self.within(&found.best, upper)?;
        Ok(found.without_impossible())
    }

    /// Makes a real run of the model's longest scan, which starts from `longest`; and one that starts from `other` if
    /// the first is impossible or shorter than `upper`. Makes further rounds as long as a longer run may be found.
    /// `knowledge` is what was learned before. `Err` if an operation wrote a cell that its effects do not declare, or
    /// if a run takes longer than `upper`, the bound on all charges.
    pub fn run(
        &self,
        [longest, other]: [&Witness; 2],
        upper: Picos,
        knowledge: Knowledge,
    ) -> Result<RunResults, String> {
        let run = self.real(longest)?;
        let mut found = RunResults::first(self.program, run, longest.clone(), knowledge);
        if !found.best.is_possible() || found.best.replay.total < upper {
            let mut one = self.real(other)?;
            found.note(self.program, &mut one);
            found.keep_better(one, other.clone());
        }
        self.lengthen(&mut found, Some(upper), &mut 0)?;
        self.within(&found.best, upper)?;
        Ok(found.without_impossible())
    }

    /// Makes further runs as long as a longer one may be found. Each is the longest scan of the model that includes
    /// what all earlier runs showed. No run may take longer than `upper`, if that is given. Returns whether a round was
    /// made and the last one was worthwhile. If earlier rounds have used up the limit on `gates`, one more round is
    /// made.
    fn go_on(
        &self,
        found: &mut RunResults,
        upper: Option<Picos>,
        gates: &mut usize,
    ) -> Result<bool, String> {
        let summary = summary_choices(self.program);
        let mut goes_on = false;
        for _ in 0..MAX_ROUNDS {
            let is_long = upper.is_some_and(|upper| found.best.replay.total >= upper);
            let reached = is_long && found.best.is_possible();
            if reached || (self.limits.cancelled)() || self.is_late() {
                break;
            }
            let Some(model) = self.model_of(&found.knowledge) else { break };
            found.gates = model.circuit.nodes().len();
            let before = *gates;
            let Some((start, most)) = self.longest_known(&model, &summary, gates) else { break };
            if most <= found.best.replay.total && found.best.is_possible() {
                break;
            }
            let mut one = self.real(&start)?;
            let news = found.note(self.program, &mut one);
            let total = one.replay.total;
            goes_on = *gates - before <= MAX_GATES_FOR_SMALL_GAINS
                || !is_hardly_longer(&one, &found.best);
            // A run that was stopped for its length is not repeated from other starts, because each would take as long.
            let left =
                one.stopped.as_ref().is_some_and(|stopped| stopped.reason == StopReason::TooLong);
            found.keep_better(one, start);
            if total >= most || !news || left || !goes_on || *gates > MAX_GATES {
                break;
            }
        }
        Ok(goes_on)
    }

    /// The model that includes what real runs showed. `None` if it is too large to be searched repeatedly, or its times
    /// are too long to be added up.
    fn model_of(&self, knowledge: &Knowledge) -> Option<ScanModel> {
        let in_all = if self.is_large() { LARGEST_OF_LARGE } else { LARGEST };
        let limits = SizeLimits { per_execution: usize::MAX, in_all, is_over: &|| self.is_late() };
        let purpose = Purpose::LowerBound;
        let model =
            scan_model_with_knowledge(self.program, self.least, knowledge, purpose, &limits);
        // If its times cannot be added up, another stage refuses the audit.
        model.ok().filter(|model| model.sum_of_largest() <= u128::from(LONGEST_SCAN.0))
    }

    /// The start of the longest scan among those that certainly run as in the model, and an upper bound on these scans.
    /// If every path depends on unknown values, what depends on them counts with its smallest time. `None` if no scan
    /// satisfies the constraints. Adds the models' size to `gates`.
    fn longest_known(
        &self,
        full: &ScanModel,
        summary: &BTreeSet<ChoiceId>,
        gates: &mut usize,
    ) -> Option<(Witness, Picos)> {
        let standing = |variable| standing(self.program, summary, full, variable);
        *gates += full.circuit.nodes().len();
        [true, false].into_iter().find_map(|is_strict| {
            let model = lower_bound_model(full, &standing, is_strict);
            *gates += model.circuit.nodes().len();
            let (assignment, most) = self.longest(&model)?;
            Some((witness(&model, &assignment), most))
        })
    }

    /// The start of the longest first scan after power-up among those that certainly run as in the model. `None` if the
    /// model is too large, or nothing is known of it.
    pub(super) fn first_scan(&self, found: &RunResults, outside: &Outside<'_>) -> Option<Witness> {
        if found.gates > LARGEST_FIRST {
            return None;
        }
        let mut model = self.model_of(&found.knowledge)?;
        if model.circuit.nodes().len() > LARGEST_FIRST {
            return None;
        }
        let power_up = &self.program.power_up;
        for at in 0..model.variables.len() {
            let Origin::Start(cell) = model.variables[at].origin else { continue };
            let value = match power_up.first_scan.contains(&cell) {
                true => 1,
                false if outside.sets(cell) => continue,
                false if power_up.cleared.iter().any(|region| region.contains(cell)) => {
                    power_up.initial_value(cell)
                }
                false => continue,
            };
            let variable = VarId(u32::try_from(at).ok()?);
            let bits = match model.variables[at].kind {
                VarKind::Bit => vec![(Atom::Bit(variable), value & 1 == 1)],
                VarKind::Word => (0..16)
                    .map(|bit| (Atom::WordBit(variable, bit), value >> bit & 1 == 1))
                    .collect(),
            };
            for (atom, on) in bits {
                let lit = model.circuit.atom(atom);
                model.constraints.push(if on { lit } else { !lit });
            }
        }
        let summary = summary_choices(self.program);
        self.longest_known(&model, &summary, &mut 0).map(|(start, _)| start)
    }

    /// Whether the time is over or the user ended the search.
    pub(super) fn is_over(&self) -> bool {
        (self.limits.cancelled)() || self.is_late()
    }

    fn is_late(&self) -> bool {
        self.limits.deadline.is_some_and(|end| Instant::now() >= end)
    }

    /// Makes a real run. `Err` if an operation wrote a cell that its effects do not declare, or if a word left the
    /// range that the analysis proved.
    pub(super) fn real(&self, witness: &Witness) -> Result<RealRun, String> {
        let counts = counts(self.program);
        let start = || Start { program: self.program, witness, counts: &counts, asked: None };
        let run = real(self.program, self.least, start, MAX_INSTRUCTIONS);
        self.agrees(&run)?;
        Ok(run)
    }

    /// The invariants that a start breaks: indices into `Program::invariants`, and those beyond for
    /// `PowerUp::certain_invariants`.
    pub(super) fn broken(&self, witness: &Witness) -> Vec<usize> {
        let counts = counts(self.program);
        let start = || Start { program: self.program, witness, counts: &counts, asked: None };
        real(self.program, self.least, start, 0).replay.broken_invariants
    }

    /// Makes a real run, in the first case, and records what it reads and writes.
    pub(super) fn traced(&self, witness: &Witness) -> (RealRun, Trace) {
        let counts = counts(self.program);
        let start = Start { program: self.program, witness, counts: &counts, asked: None };
        traced(self.program, self.least, start, MAX_INSTRUCTIONS)
    }

    /// Whether the program is large: a round over a model of it takes as long as many runs, and finds less.
    pub(super) fn is_large(&self) -> bool {
        self.program.instructions.len() >= LARGE
    }

    /// The value of a cell at the start of a real run.
    pub(super) fn start_value(&self, witness: &Witness, cell: Cell) -> u16 {
        let counts = counts(self.program);
        Start { program: self.program, witness, counts: &counts, asked: None }.value(cell)
    }

    /// The start values that a real run reads.
    pub(super) fn started(&self, witness: &Witness) -> BTreeMap<Cell, u16> {
        let (program, counts, asked) = (self.program, counts(self.program), RefCell::default());
        let start = || Start { program, witness, counts: &counts, asked: Some(&asked) };
        let _ = real(program, self.least, start, MAX_INSTRUCTIONS);
        asked.into_inner()
    }

    /// Compares a real run with the analysis. `Err` if they contradict each other.
    fn agrees(&self, run: &RealRun) -> Result<(), String> {
        let program = self.program;
        if let Some(&(instruction, cell)) = run.undeclared_writes.first() {
            let at = &program.instructions[instruction];
            let (file, line) = (&at.place.of(&program.files).name, at.place.line);
            let (text, cell) = (&at.text, program.cell_name(cell));
            return Err(format!(
                "{file}:{line} {text} writes {cell} in a simulated scan, but the analysis says that it does not"
            ));
        }
        let is_kept = |(range, _): &&(usize, i64)| {
            let cells = &program.stated_ranges[*range].cells;
            cells.len() == 1 && program.proved_ranges.contains(&cells[0])
        };
        let left = run.range_violations.iter().find(is_kept).filter(|_| run.is_possible());
        if let Some(&(range, value)) = left {
            let cell = program.cell_name(program.stated_ranges[range].cells[0]);
            return Err(format!(
                "a simulated scan leaves {value} in {cell}, but the analysis proved that the program keeps {cell} in its stated range"
            ));
        }
        Ok(())
    }

    /// `Err` if a run that is possible takes longer than `upper`, the bound on all charges.
    pub(super) fn within(&self, one: &RealRun, upper: Picos) -> Result<(), String> {
        if one.is_possible() && one.replay.total > upper {
            return Err(format!(
                "a simulated scan takes {}, more than the bound of {upper}",
                one.replay.total
            ));
        }
        Ok(())
    }

    /// The longest scan of a model that was found, and an upper bound on all its scans. `None` if the scan found
    /// violates a constraint, as it does if no scan satisfies them.
    pub(super) fn longest(&self, model: &ScanModel) -> Option<(Assignment, Picos)> {
        if model.constraints.contains(&Lit::FALSE) {
            // All charges depend on unknown values: there is nothing to search.
            return None;
        }
        let slices = groups(model);
        let methods = vec![Method::Cores; slices.len()];
        let decisions = Decisions::new(MAX_DECISIONS);
        let limits = Limits { decisions: Some(&decisions), ..self.limits };
        let found = maxima(model, &slices, &methods, &limits, &|_, _, _| {});
        let mut all = Assignment(vec![0; model.variables.len()]);
        let mut most = model.cost(&model.constant_charges(), &all);
        for found in &found {
            most += found.upper;
            found.best.copy_to(&mut all);
        }
        if let Some(rest) = unused_constraints(model, &slices) {
            maximum(model, &rest, Method::Cores, &self.limits).best.copy_to(&mut all);
        }
        let values = model.circuit.evaluate(&all);
        model.constraints.iter().all(|&holds| values.get(holds)).then_some((all, most))
    }
}

/// Whether two programs differ in nothing but the invariants and what is known of their timers.
pub(super) fn has_same_instructions(one: &Program, other: &Program) -> bool {
    let alike = Program {
        invariants: one.invariants.clone(),
        timekeeping: one.timekeeping.clone(),
        ..other.clone()
    };
    alike == *one
}

/// Whether a run is less than 1/`WORTH` longer than the best one. Never if one of the two is impossible: such a run
/// shows where to search next.
fn is_hardly_longer(one: &RealRun, best: &RealRun) -> bool {
    let (took, before) = (one.replay.total.0, best.replay.total.0);
    one.is_possible() && best.is_possible() && took < before.saturating_add(before / WORTH)
}

/// Adds what a run showed to `knowledge`. Returns whether something was new.
fn learn(knowledge: &mut Knowledge, real: &mut RealRun) -> bool {
    let mut news = false;
    for (moment, facts) in std::mem::take(&mut real.learned) {
        let known = knowledge.entry(moment).or_default();
        for fact in facts {
            if !known.contains(&fact) {
                known.push(fact);
                news = true;
            }
        }
    }
    news
}

/// Whether the search for a lower bound may choose a variable's value ([`Treatment::Free`]), must use 0
/// ([`Treatment::Zero`]), or may assume nothing about it ([`Treatment::Unknown`]).
pub(super) fn standing(
    program: &Program,
    summary: &BTreeSet<ChoiceId>,
    model: &ScanModel,
    variable: VarId,
) -> Treatment {
    standing_of(model, variable, &|choice| match program.kinds.get(&choice) {
        None if summary.contains(&choice) => Treatment::Free,
        // The model knows each result that is defined.
        Some(ChoiceKind::Exact(meaning)) if meaning.operation == Operation::Counted => {
            Treatment::Unknown
        }
        Some(
            ChoiceKind::External
            | ChoiceKind::StableExternal(_)
            | ChoiceKind::Exact(_)
            | ChoiceKind::PresentValue { .. }
            | ChoiceKind::Unreachable(_)
            | ChoiceKind::UnsignedIterations(_),
        ) => Treatment::Free,
        Some(
            ChoiceKind::Iterations(_)
            | ChoiceKind::ScanTicks { .. }
            | ChoiceKind::ExtraTime
            | ChoiceKind::Parameter
            | ChoiceKind::Reading(_),
        ) => Treatment::Zero,
        Some(ChoiceKind::AddressOf { .. }) | None => Treatment::Unknown,
    })
}

/// How a variable is treated whose value is that of a choice, or of one of several choices, by how these are. Others
/// are [`Treatment::Free`].
pub(super) fn standing_of(
    model: &ScanModel,
    variable: VarId,
    of: &dyn Fn(ChoiceId) -> Treatment,
) -> Treatment {
    match &model.variables[variable.0 as usize].origin {
        Origin::Start(_) => Treatment::Free,
        Origin::Choice(key) => of(key.choice),
        &Origin::Havocked { cell, since, until } => {
            let mut moments = model.havocs.concerning(cell, since, until);
            let unknown = moments.any(|moment| of(moment.choice) == Treatment::Unknown);
            if unknown { Treatment::Unknown } else { Treatment::Free }
        }
    }
}

/// The choices of loop summaries: loops with a number of iterations that the model does not follow. Real runs show what
/// these loops write.
pub(super) fn summary_choices(program: &Program) -> BTreeSet<ChoiceId> {
    let choices = program.instructions.iter().flat_map(|one| match &one.step {
        Step::Summary(summary) if summary.iterations.is_some() => {
            summary.exits.iter().map(|exit| exit.0).chain([summary.choice]).collect()
        }
        _ => Vec::new(),
    });
    choices.collect()
}

/// The words that hold the number of iterations of loops that the model does not follow, each with the loop's
/// instruction.
fn counts(program: &Program) -> Vec<(usize, Cell)> {
    let summary = |step: &Step| match step {
        Step::Summary(summary) => summary.iterations.map(|(count, ..)| count),
        _ => None,
    };
    let all = program.instructions.iter().enumerate();
    let counts = all.filter_map(|(at, one)| Some((at, summary(&one.step)?)));
    let cells = counts.filter_map(|(at, count)| match count {
        WordSource::Cell(cell) => Some((at, cell)),
        WordSource::Free(choice) => match program.kinds.get(&choice) {
            Some(
                ChoiceKind::Iterations(WordSource::Cell(cell))
                | ChoiceKind::UnsignedIterations(WordSource::Cell(cell)),
            ) => Some((at, *cell)),
            _ => None,
        },
        _ => None,
    });
    cells.collect()
}

/// Further start values of a run that are needed to repeat it from a report: cells that are not 0. Each comes with
/// whether it counts a loop that the run reaches.
pub(super) fn other_starts(
    program: &Program,
    found: &RunResults,
    known: &BTreeSet<Cell>,
) -> Vec<(Cell, u16, bool)> {
    let counts = counts(program);
    let ran: BTreeSet<usize> =
        found.best.replay.events.iter().map(|event| event.instruction).collect();
    let stated = program.stated_ranges.iter().filter_map(|range| match range.cells[..] {
        [cell] => Some(cell),
        _ => None,
    });
    let named = found.witness.start.keys().copied();
    let cells: BTreeSet<Cell> =
        counts.iter().map(|&(_, cell)| cell).chain(stated).chain(named).collect();
    let mut start = Start { program, witness: &found.witness, counts: &counts, asked: None };
    let others = cells.into_iter().filter(|cell| !known.contains(cell));
    let others = others.filter_map(|cell| {
        let value = start.start(cell, program.area(cell.area).kind);
        let matters = counts.iter().any(|&(at, one)| one == cell && ran.contains(&at));
        (value != 0).then_some((cell, value, matters))
    });
    others.collect()
}

/// The start values of a real run: those of the witness. Any other cell has the value nearest to 0 that is stated as
/// possible; a word that counts a loop has the largest.
struct Start<'a> {
    program: &'a Program,
    witness: &'a Witness,
    counts: &'a [(usize, Cell)],
    /// Where the values that the run reads are recorded. `None`: they are not recorded.
    asked: Option<&'a RefCell<BTreeMap<Cell, u16>>>,
}

impl Start<'_> {
    fn value(&self, cell: Cell) -> u16 {
        if let Some(&value) = self.witness.start.get(&cell) {
            return value;
        }
        let is_count = self.counts.iter().any(|&(_, count)| count == cell);
        let stated = self.program.stated_ranges.iter().find(|range| range.cells == [cell]);
        match stated {
            Some(range) if is_count => range.high as u16,
            Some(range) => range.nearest_to_zero() as u16,
            None if is_count => i16::MAX.cast_unsigned(),
            None => 0,
        }
    }
}

impl FreeValues for Start<'_> {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        let value = self.value(cell);
        if let Some(asked) = self.asked {
            asked.borrow_mut().insert(cell, value);
        }
        value
    }

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        self.witness.choices.get(key).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests;

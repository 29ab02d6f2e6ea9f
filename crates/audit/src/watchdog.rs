//! The times that limit a scan or extend it: the watchdog and its restarts, and a constant scan time.

use super::cycle::{Cycle, SettingUse, Stretch, WaitingScan, Watchdog};
use super::real::{RunResults, RunSearch};
use super::{restarted, stretch};
use scanbound_base::facts::Facts;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::{AreaKind, Cell, Frame, Program, Setting, Switch};
use scanbound_model::ScanModel;
use scanbound_passes::values::Trust;
use scanbound_replay::run::{Outside, OutsideValues, Run};
use scanbound_replay::{Event, RealRun};
use scanbound_solve::Limits;
use scanbound_timing::price::Prices;
use scanbound_timing::table::Table;
use std::collections::{BTreeMap, BTreeSet};

/// The number of scans that are simulated in each run from power-up, to see which times they set.
const SCANS: usize = 3;
/// The largest number of instructions that a simulated scan executes.
const MAX_INSTRUCTIONS: u64 = 400_000;
/// The factor by which the largest margin of a check (1000 %) multiplies a time. If a time multiplied by it is still
/// below the watchdog's, a closer bound proves nothing more.
const LARGEST_MARGIN: u64 = 11;

/// The program and settings of an analysis of the watchdog and the constant scan.
pub(super) struct ScanControlAnalysis<'a> {
    pub program: &'a Program,
    pub prices: &'a Prices,
    pub table: &'a Table,
    pub facts: &'a Facts,
    pub trust: Trust,
    /// The model of the scan. `None` if the bound is only the structural one.
    pub model: Option<&'a ScanModel>,
}

/// What was observed in runs from power-up.
#[derive(Default)]
struct Observed {
    /// For each simulated scan: its longest part without a restart of the watchdog.
    stretches: Vec<Stretch>,
    /// Whether a scan of the runs set the watchdog.
    sets_watchdog: bool,
    /// The longest constant scan time that was certainly set in one of the runs, and the scan that waits for it. `None`
    /// if no scan of the runs certainly waits for one.
    constant: Option<(Picos, WaitingScan)>,
}

impl ScanControlAnalysis<'_> {
    /// Determines the watchdog and the constant scan. `is_reached` says whether a run from power-up leads to the
    /// longest scan found.
    pub fn analyse(
        &self,
        (found, is_reached): (&RunResults, bool),
        search: &RunSearch<'_>,
    ) -> Result<(Watchdog, Cycle), String> {
        let control = &self.program.scan_control;
        let is_quiet = control.restarts.is_empty()
            && control.watchdog.is_empty()
            && control.extensions.is_empty()
            && control.constant.is_empty()
            && control.switches.is_empty();
        let observed = if is_quiet { Observed::default() } else { self.observed() };
        let cycle = self.cycle(&observed);
        let mut stretches = Vec::new();
        if !is_quiet {
            stretches = self.others((found, is_reached), search, observed.sets_watchdog)?;
            stretches.extend(observed.stretches);
        }
        Ok((self.watchdog(stretches, &search.limits), cycle))
    }

    fn uses(&self, settings: &BTreeMap<usize, Setting>) -> Vec<SettingUse> {
        let one = |(&at, setting): (&usize, &Setting)| SettingUse {
            times: setting.range(),
            from: match setting {
                Setting::Device(from) => Some(from.clone()),
                Setting::Computed | Setting::Possible | Setting::Range(..) => None,
            },
            ..self.place(at)
        };
        settings.iter().map(one).collect()
    }

    fn place(&self, at: usize) -> SettingUse {
        let instruction = &self.program.instructions[at];
        let (at, instruction) = (instruction.place, instruction.text.clone());
        SettingUse { at, instruction, times: None, from: None }
    }

    fn default(&self) -> Option<Picos> {
        self.facts.watchdog.or(self.table.watchdog())
    }

    fn watchdog(&self, found: Vec<Stretch>, limits: &Limits<'_>) -> Watchdog {
        let control = &self.program.scan_control;
        let default = self.default();
        let times = self.prices.times();
        let around = self.prices.overhead_sum() + self.prices.more_points();
        // All interrupts of a scan may occur before the watchdog is set or extended.
        let interrupts = stretch::interrupts(self.program, &times);
        let before = around + interrupts;
        let settings = control.watchdog.values();
        // A stated time replaces an unknown one.
        let set = settings.map(|setting| match setting.range() {
            Some((least, _)) => least,
            None => self.facts.watchdog.unwrap_or(Picos::ZERO),
        });
        let extensions = &control.extensions;
        let extended = default.map(|time| {
            time + stretch::certain_extension(self.program, &times, (time, before), extensions)
        });
        let least = match self.is_set_first(&times, before) {
            true => set.min(),
            false => set.chain(extended).min(),
        };
        // The model is searched if the structure of the program does not prove enough.
        let upper = stretch::upper(self.program, &times, around).map(|upper| {
            let with_margin = Picos(upper.0.saturating_mul(LARGEST_MARGIN));
            let is_enough = least.or(default).is_none_or(|least| with_margin <= least);
            // If the watchdog's time is unknown, a check proves nothing.
            let model = self.model.filter(|_| !is_enough && least != Some(Picos::ZERO));
            let useful = upper.checked_sub(interrupts).unwrap_or_default();
            let closer = model
                .and_then(|model| restarted::upper(self.program, model, (around, useful), limits));
            closer.map_or(upper, |closer| upper.min(closer + interrupts))
        });
        Watchdog {
            default,
            is_stated: self.facts.watchdog.is_some(),
            device: control.devices[0],
            settings: self.uses(&control.watchdog),
            least,
            restarts: control.restarts.len(),
            upper,
            found,
        }
    }

    /// Whether every run certainly sets the watchdog in its first scan and restarts it after that, within the default
    /// time. Then the default time no longer matters. False if the default time is unknown.
    fn is_set_first(&self, times: &[Times], around: Picos) -> bool {
        let passed = stretch::until_set(self.program, times, around);
        passed.is_some_and(|passed| self.default().is_some_and(|default| passed <= default))
    }

    /// The largest possible watchdog time: the default (`from_default`), those that the program sets (`from_settings`),
    /// or both. `None` if it is unknown.
    fn most(&self, from_settings: bool, from_default: bool) -> Option<Picos> {
        let settings = self.program.scan_control.watchdog.values();
        let settings = settings.map(|setting| match setting.range() {
            Some((_, most)) => most,
            None => self.facts.watchdog.unwrap_or(Picos(u64::MAX)),
        });
        let settings: Vec<Picos> = settings.filter(|_| from_settings).collect();
        if !from_default {
            return settings.into_iter().max();
        }
        Some(settings.into_iter().chain([self.default()?]).max().unwrap_or_default())
    }

    /// The longest times without a watchdog restart in the longest scan found. If it is the first scan of a run, and
    /// runs set the watchdog (`is_set`), also those in a later scan with the same other start values.
    fn others(
        &self,
        (found, is_reached): (&RunResults, bool),
        search: &RunSearch<'_>,
        is_set: bool,
    ) -> Result<Vec<Stretch>, String> {
        let first = &self.program.power_up.first_scan;
        let is_first = first.iter().any(|cell| found.witness.start.get(cell) == Some(&1));
        let later;
        let mut runs = vec![(&found.best, is_first, is_reached)];
        if is_first && is_set {
            let mut witness = found.witness.clone();
            witness.start.retain(|cell, _| !first.contains(cell));
            later = search.real(&witness)?;
            runs.push((&later, false, false));
        }
        let runs = runs.into_iter().filter(|(run, ..)| run.is_possible());
        let stretch = |(run, is_first, is_reached): (&RealRun, bool, bool)| {
            self.stretch(run, !is_set || is_first, is_reached)
        };
        Ok(runs.map(stretch).collect())
    }

    fn stretch(&self, run: &RealRun, may_be_default: bool, is_reached: bool) -> Stretch {
        let events = &run.replay.events;
        let extended: Picos = events
            .iter()
            .filter(|event| event.fired)
            .filter_map(|event| {
                Some(self.program.scan_control.extensions.get(&event.instruction)?.1)
            })
            .sum();
        let watchdog = self.most(true, may_be_default);
        Stretch {
            took: self.longest(events),
            watchdog: watchdog.map(|time| time + extended),
            is_reached,
        }
    }

    /// The longest time that certainly passes in these events of a scan without a restart of the watchdog. Interrupts
    /// do not count.
    fn longest(&self, events: &[Event]) -> Picos {
        let control = &self.program.scan_control;
        let overhead = self.prices.overhead_sum().checked_sub(self.prices.uncertain_refresh());
        let entries = self.program.interrupt_entries();
        let restarts =
            |event: &&Event| event.fired && control.restarts.contains(&event.instruction);
        let interrupts = |event: &&Event| Frame::in_interrupt(&event.frames, &entries);
        // Interrupts may occur less often than charged, or not at all.
        if !events.iter().any(|event| restarts(&event)) {
            let main = events.iter().filter(|event| !interrupts(event));
            return main.map(|event| event.cost).sum::<Picos>() + overhead.unwrap_or_default();
        }
        // An interrupt may restart it at any moment.
        if events.iter().any(|event| restarts(&event) && interrupts(&event)) {
            return Picos::ZERO;
        }
        let (mut longest, mut passed) = (Picos::ZERO, Picos::ZERO);
        for event in events.iter().filter(|event| !interrupts(event)) {
            if restarts(&event) {
                passed = Picos::ZERO;
                continue;
            }
            passed += event.cost;
            longest = longest.max(passed);
        }
        longest
    }

    /// Simulates the program from power-up with all inputs off, and with all on, for a few scans each.
    fn observed(&self) -> Observed {
        let mut observed = Observed::default();
        let times = self.prices.least_times();
        let outside = Outside::of(self.program);
        for value in [0, u16::MAX] {
            let inputs = match value {
                0 => BTreeMap::new(),
                _ => self.inputs(&outside).into_iter().map(|cell| (cell, value)).collect(),
            };
            self.run(&outside, &times, &inputs, &mut observed);
        }
        observed
    }

    /// The cells that the program reads and that something outside of it sets.
    fn inputs(&self, outside: &Outside<'_>) -> BTreeSet<Cell> {
        let mut found = BTreeSet::new();
        for instruction in &self.program.instructions {
            instruction.each_read(&mut |source| {
                use scanbound_ir::{BitSource, Source, WordSource};
                if let Source::Bit(BitSource::Cell(cell) | BitSource::WordBit(cell, _))
                | Source::Word(WordSource::Cell(cell)) = source
                    && outside.sets(cell)
                {
                    found.insert(cell);
                }
            });
        }
        let is_bit = |cell: &Cell| self.program.area(cell.area).kind == AreaKind::Bit;
        found.retain(|cell| is_bit(cell) || self.program.area(cell.area).kind == AreaKind::Word);
        found
    }

    fn run<'r>(
        &self,
        outside: &'r Outside<'r>,
        times: &'r [Times],
        inputs: &BTreeMap<Cell, u16>,
        observed: &mut Observed,
    ) {
        let control = &self.program.scan_control;
        let choices = BTreeMap::new();
        let mut run = Run::new(outside, times, self.prices.overhead_sum());
        let (mut is_set, mut is_on, mut constant) = (false, false, Picos::ZERO);
        for number in 1..=SCANS {
            let given = OutsideValues { inputs: inputs.clone(), choices: &choices, seed: None };
            let scan = run.scan(&given, MAX_INSTRUCTIONS);
            if !scan.is_possible() {
                break;
            }
            observed.stretches.push(self.stretch(&scan, !is_set, true));
            for event in &scan.replay.events {
                let at = event.instruction;
                is_set |= event.fired && control.watchdog.contains_key(&at);
                if (event.fired || event.is_uncertain)
                    && let Some(setting) = control.constant.get(&at)
                {
                    let set = setting.range().filter(|_| !event.is_uncertain);
                    constant = set.map_or(Picos::ZERO, |(least, _)| least);
                }
                is_on = match control.switches.get(&at) {
                    Some(Switch::Condition) => event.fired,
                    Some(Switch::On) => is_on || event.fired,
                    Some(Switch::Off | Switch::PossiblyOff) => {
                        is_on && !event.fired && !event.is_uncertain
                    }
                    Some(Switch::Unknown) => false,
                    None => is_on,
                };
            }
            if scan.stopped.is_some() {
                break;
            }
            if is_on && constant > Picos::ZERO {
                let waits = WaitingScan { number, inputs_on: !inputs.is_empty() };
                let longest = observed.constant.map_or(Picos::ZERO, |one| one.0);
                if constant > longest {
                    observed.constant = Some((constant, waits));
                }
            }
        }
        observed.sets_watchdog |= is_set;
    }

    fn cycle(&self, observed: &Observed) -> Cycle {
        let control = &self.program.scan_control;
        let stated = self.facts.constant_scan;
        let observed = observed.constant;
        let may_be = control.may_be_constant();
        let known = control.constant.values().filter(|_| may_be);
        let known: Vec<Option<Picos>> =
            known.map(|setting| setting.range().map(|range| range.1)).collect();
        // Where the program sets the time only under a condition, something else may set it, too.
        let first: &[Cell] = match self.trust {
            Trust::None => &[],
            Trust::Counts | Trust::All => &self.program.power_up.first_scan,
        };
        let times = self.prices.times();
        let is_own = self.trust == Trust::All
            || stretch::surely_sets(self.program, &times, first, &control.constant);
        let is_open = known.is_empty() || known.contains(&None) || !is_own;
        let is_unknown = may_be && is_open && stated.is_none();
        let upper = known.into_iter().flatten().chain(stated).max();
        Cycle {
            upper: upper.filter(|&time| time > Picos::ZERO),
            interrupts: stretch::interrupts(self.program, &self.prices.times()),
            lower: observed.map(|one| one.0).max(stated).filter(|&time| time > Picos::ZERO),
            waits: observed.map(|one| one.1),
            settings: self.uses(&control.constant),
            switches: control.switches.keys().map(|&at| self.place(at)).collect(),
            devices: [control.devices[1], control.devices[2]],
            is_unknown,
            is_stated: stated.is_some(),
            unstated: control.by_parameters.filter(|_| stated.is_none()),
        }
    }
}

//! Assembles the [`Audit`], the result that a report shows, from what the stages found.

use super::assumption::Assumption;
use super::deciding::{depends_on, needed_variables};
use super::doubt::Doubt;
use super::due;
use super::exactness::Exactness;
use super::executed::{Executed, stands_between, started};
use super::fact::Fact;
use super::method::SearchUse;
use super::model_search::PreparedExplanation;
use super::names::Names;
use super::parts::possible;
use super::proved::Proved;
use super::real::{RunResults, other_starts};
use super::request::Request;
use super::response::Delays;
use super::rung::rungs;
use super::sources::sources;
use super::table_use::TableParts;
use super::unbounded::Loops;
use super::unknown::Unknown;
use super::unknown_writes;
use super::weight::weights;
use super::{
    ApproximationUse, Audit, Bound, ChargeUse, Cycle, Exclusion, FreeValue, GroupUse, NetworkUse,
    OverheadUse, PathStep, RunScan, RungUse, Tie, Value, Watchdog,
};
use scanbound_base::budget::EarlyStop;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_front::MachineOptions;
use scanbound_ir::{AreaKind, Program};
use scanbound_model::{Assignment, Atom, Group, Node, Origin, ScanModel, Values, VarKind};
use scanbound_replay::{Event, Replay};
use scanbound_solve::{Exclusions, Limits, Maximum};
use scanbound_timing::price::Prices;
use scanbound_timing::table::{Evidence, Table};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Instant;

/// The largest number of rungs in a group, the longest ones, for which the audit explains why they do not take their
/// longest time.
const MAX_EXPLAINED: usize = 20;

/// The results of the search for the longest scan, and the program and model that were searched.
pub struct Findings<'a> {
    pub request: &'a Request<'a>,
    pub program: &'a Program,
    pub table: &'a Table,
    pub prices: &'a Prices,
    pub model: &'a ScanModel,
    /// Which properties of this PLC the user may state, because the front does not know them.
    pub machine: MachineOptions,
    pub groups: &'a [Group],
    pub maxima: &'a [Maximum],
    /// The best assignments of all groups, combined: the model's longest scan.
    pub assignment: &'a Assignment,
    /// The limits of the search for explanations.
    pub limits: &'a Limits<'a>,
}

/// The charges and overhead of the bound, with their times in the model's longest scan, and why rungs do not take their
/// longest time in it. The groups are in the order of `Findings::groups`.
pub struct ExplainedBound {
    overhead: Vec<OverheadUse>,
    always: Vec<ChargeUse>,
    groups: Vec<ExplainedGroup>,
}

/// A group's charges in the order of execution, and its rungs, the one with the longest possible time first.
struct ExplainedGroup {
    charges: Vec<ChargeUse>,
    rungs: Vec<RungUse>,
}

/// The results of the stages after the search for the longest scan.
pub struct Finished<'a> {
    /// The longest real run (a scan simulated as on a PLC), and the values with which it starts.
    pub found: &'a RunResults,
    /// Whether the longest real run is the model's longest scan: it has the same start values and takes the same time.
    pub same: bool,
    /// When the audit began.
    pub start: Instant,
    pub warnings: Vec<Diagnostic>,
    pub cuts: Vec<EarlyStop>,
    pub ended_early: bool,
    pub explained: ExplainedBound,
    /// How each group's maximum was found, in the order of the groups.
    pub searches: Vec<SearchUse>,
    pub loops: Loops,
    /// The scans of a run from power-up to the longest real run. Empty if none was found.
    pub run: Vec<RunScan>,
    /// The delays before and after the scan, if a response time was requested.
    pub delays: Option<Delays>,
    /// The stated facts that the program is proved to keep.
    pub proved: Proved,
    pub watchdog: Watchdog,
    pub cycle: Cycle,
}

impl<'a> Findings<'a> {
    /// The unknown values on which the bound depends: first numbers of iterations and units, then targets of writes,
    /// last those numbers that are perhaps unknown only because of a write with an unknown target. `upper` is the
    /// bound.
    fn unknowns(&self, upper: Picos) -> Vec<Unknown> {
        let mut unknowns = Unknown::counted(self.program, &self.prices.times(), upper);
        unknowns.extend(unknown_writes::all(self.program, self.model, self.groups, self.machine));
        unknown_writes::put_last(&mut unknowns, self.program, self.model);
        unknowns
    }

    /// Distributes the bound to its charges, and explains why rungs do not take their longest time, for groups with at
    /// least 0.5 % of the bound and until the time is over. `prepared` may hold the search for the explanations of one
    /// group.
    pub fn explain(&self, mut prepared: Option<PreparedExplanation<'a>>) -> ExplainedBound {
        let names = Names::new(self.program);
        let values = self.model.circuit.evaluate(self.assignment);
        let pick = |charges: &[usize]| -> Vec<ChargeUse> {
            charges.iter().map(|&charge| self.charge(charge, &values, &names)).collect()
        };
        let always = pick(&self.model.constant_charges());
        let overhead: Vec<OverheadUse> = self
            .prices
            .overhead
            .iter()
            .map(|term| OverheadUse {
                name: term.name.clone(),
                time: term.time,
                evidence: term.evidence,
                why: term.why.clone(),
            })
            .collect();
        let upper = self.upper(&always, &overhead);
        let explained = |(index, (group, maximum)): (usize, (&Group, &Maximum))| {
            let prepared = prepared.take_if(|prepared| prepared.group == index);
            let explains = Audit::is_main(maximum.upper, upper) && !self.limits.reached();
            let (mut charges, mut exclusions) = rayon::join(
                || pick(&group.charges),
                || explains.then(|| self.exclusions(group, maximum, prepared)).flatten(),
            );
            if !maximum.feasible {
                // No scan of the group was found: its whole part of the bound is left open.
                charges.iter_mut().for_each(|charge| charge.share = Picos::ZERO);
            }
            let rungs = self.rungs(group, &charges, &names, exclusions.as_mut());
            let larger_time = |charge: &ChargeUse| charge.on.max(charge.off);
            if maximum.upper == charges.iter().map(larger_time).sum() {
                // Nothing was excluded, so the bound is the sum of all charges and each charge's part is known.
                charges.iter_mut().for_each(|charge| charge.share = larger_time(charge));
            }
            ExplainedGroup { charges, rungs }
        };
        let groups = self.groups.iter().zip(self.maxima).enumerate().map(explained).collect();
        ExplainedBound { overhead, always, groups }
    }

    /// Builds the [`Audit`]. What is found only by further audits stays empty in it.
    pub fn audit(&self, finished: Finished<'_>) -> Audit {
        let Finished {
            found,
            same,
            start,
            warnings,
            cuts,
            ended_early,
            explained,
            searches,
            loops,
            run,
            delays,
            proved,
            watchdog,
            cycle,
        } = finished;
        let ExplainedBound { overhead, mut always, mut groups } = explained;
        // The real run, if it is not the assignment's scan.
        let real = Some(found).filter(|_| !same);
        if let Some(real) = real {
            self.show(&Executed::of(self.program, &real.best), &mut groups, &mut always);
        }
        let mut bound = self.bound(&always, &overhead, real);
        let facts = self.request.facts;
        let not_due = due::not_due(self.program, facts, &found.best, bound.lower);
        bound.lower = bound.lower.checked_sub(not_due).unwrap_or_default();
        let run = if not_due > Picos::ZERO { Vec::new() } else { run };
        let all_points = bound.upper + self.prices.more_points();
        let (witness, weighed) = self.witness(&Names::new(self.program), found, same);
        let shares = self.shares(&groups, &always);
        let names = Names::new(self.program);
        let uses = self.uses();
        let groups = groups.into_iter().zip(searches).enumerate();
        let groups = groups
            .map(|(index, (explained, search))| {
                self.group(index, explained, search, &names, &uses, real)
            })
            .collect();
        let parts = TableParts { prices: self.prices, bound: &bound };
        let uppers = self.maxima.iter().map(|maximum| maximum.upper);
        let table = parts.table_use(self.table, &self.costs(real), &shares, uppers);
        let clocked = self.program.words_per_scan;
        let possible = possible(&bound, table.factor.as_ref(), clocked.is_some());
        let stands_between = real
            .filter(|_| bound.lower < bound.model)
            .map(|real| stands_between(self.program, &real.best));
        let networks = self.networks();
        let bound_besides = bound.always + bound.overhead;
        let response = delays.map(|delays| delays.response_time(bound.upper));
        Audit {
            files: self.program.files.iter().map(|file| file.name.clone()).collect(),
            standby: self.program.standby.clone(),
            sources: sources(self.request, self.program, self.table),
            dialect: self.program.dialect.clone(),
            cpu: self.request.cpu.map(str::to_owned).or_else(|| self.program.cpu.clone()),
            instructions: self.program.files.iter().map(|file| file.count).sum(),
            blocks: self.program.blocks,
            clocked,
            table,
            doubts: Doubt::all(self.program, &networks, &loops.found, &loops.open, bound.upper)
                .into_iter()
                .chain(Doubt::of_cycle(&cycle))
                .chain(due::too_few(self.program, self.request.facts, all_points))
                .collect(),
            assumptions: Assumption::all(self.program),
            unknowns: self.unknowns(bound.upper),
            what_if: None,
            coactivity: None,
            bounded_task: match &self.program.tasks[..] {
                [first, _, ..] => Some(first.name.clone()),
                _ => None,
            },
            tasks: Vec::new(),
            net: None,
            ladder: None,
            bound,
            cycle,
            holds_interrupts: self.program.scan_control.holds_interrupts,
            watchdog,
            overhead,
            always,
            groups,
            witness,
            weighed: bound_besides + weighed,
            witness_run: match clocked {
                None => run,
                // Every scan takes the same time. The clock may be slow, but that is not known.
                Some(_) => {
                    let at_most = |scan: RunScan| RunScan { took: scan.took.min(possible), ..scan };
                    run.into_iter().map(at_most).collect()
                }
            },
            needed_devices: self.needed_devices(found),
            stands_between,
            path: match self.program.shows_path {
                true => self.path(&found.best.replay, &names),
                false => Vec::new(),
            },
            unbounded: loops.found,
            facts: Fact::all(self.request, self.program, &proved),
            points: self.prices.points.clone(),
            bases: self.prices.bases.clone(),
            networks,
            approximations: self.approximations(),
            readings: self.program.readings.clone(),
            exactness: Exactness::of(self.program, self.model),
            warnings,
            response,
            ended_early,
            trust: self.request.trust,
            cuts,
            named: self.request.named.to_owned(),
            elapsed: start.elapsed(),
        }
    }

    /// The areas of which the longest scan found needs more devices than each CPU has, with how many it needs.
    fn needed_devices(&self, found: &RunResults) -> Vec<(String, u32)> {
        let needed = found.best.needed_devices.iter();
        needed.map(|(&area, &count)| (self.program.area(area).name.clone(), count)).collect()
    }

    /// The upper bound: the sum of the charges that are the same in every scan, the overhead and the groups' upper
    /// bounds.
    fn upper(&self, always: &[ChargeUse], overhead: &[OverheadUse]) -> Picos {
        let always = always.iter().map(|charge| charge.cost);
        let overhead = overhead.iter().map(|term| term.time);
        always.chain(overhead).chain(self.maxima.iter().map(|maximum| maximum.upper)).sum()
    }

    fn bound(
        &self,
        always: &[ChargeUse],
        overhead: &[OverheadUse],
        real: Option<&RunResults>,
    ) -> Bound {
        let upper = self.upper(always, overhead);
        let always: Picos = always.iter().map(|charge| charge.cost).sum();
        let overhead: Picos = overhead.iter().map(|term| term.time).sum();
        let lower: Picos = self.maxima.iter().map(|maximum| maximum.lower).sum();
        let model = always + overhead + lower;
        let lower = real.map_or(model, |real| overhead + real.best.replay.total);
        Bound {
            upper,
            lower,
            // A search that ends early may have found less in the model than real runs did.
            model: model.max(lower),
            naive: overhead + self.model.charges.iter().map(|charge| charge.largest_cost()).sum(),
            always,
            overhead,
            groups: self.maxima.iter().map(|maximum| maximum.upper).sum(),
        }
    }

    /// Shows a real run: sets which charges of the groups it reaches and fires, and their times in it. Of the charges
    /// that are the same in every scan, only sets whether they fire: they keep their time even if the run stopped
    /// before them. Parts of the bound do not change.
    fn show(&self, executed: &Executed, groups: &mut [ExplainedGroup], always: &mut [ChargeUse]) {
        for (charge, shown) in self.model.constant_charges().into_iter().zip(always) {
            let charge = &self.model.charges[charge];
            shown.runs = executed.at(charge.instruction, &charge.frames).1;
        }
        for (group, explained) in self.groups.iter().zip(groups) {
            for (&charge, shown) in group.charges.iter().zip(&mut explained.charges) {
                let charge = &self.model.charges[charge];
                (shown.reached, shown.runs, shown.cost) =
                    executed.at(charge.instruction, &charge.frames);
            }
        }
    }

    /// The path of a replayed scan through the program: its executions in order, without instructions that have no
    /// price.
    fn path(&self, replayed: &Replay, names: &Names<'_>) -> Vec<PathStep> {
        let priced = |event: &&Event| self.prices.instructions[event.instruction].is_some();
        let step = |event: &Event| {
            let instruction = &self.program.instructions[event.instruction];
            PathStep {
                at: instruction.place,
                instruction: instruction.text.clone(),
                via: names.context(&event.frames),
                held: event.fired,
                cost: event.cost,
            }
        };
        replayed.events.iter().filter(priced).map(step).collect()
    }

    fn charge(&self, index: usize, values: &Values, names: &Names<'_>) -> ChargeUse {
        let charge = &self.model.charges[index];
        let instruction = &self.program.instructions[charge.instruction];
        let price = self.prices.instructions[charge.instruction].as_ref();
        let cost = charge.cost(values);
        ChargeUse {
            at: instruction.place,
            block: instruction.block,
            instruction: instruction.text.clone(),
            via: names.context(&charge.frames),
            on: charge.on,
            off: charge.off,
            runs: values.get(charge.fires),
            reached: values.get(charge.reached),
            cost,
            share: cost,
            routine: names.routine(&charge.frames),
            row: price.map_or_else(Arc::default, |price| price.row.clone()),
            evidence: price.map_or(Evidence::Published, |price| price.evidence),
        }
    }

    fn group(
        &self,
        index: usize,
        ExplainedGroup { charges, rungs }: ExplainedGroup,
        search: SearchUse,
        names: &Names<'_>,
        uses: &[usize],
        real: Option<&RunResults>,
    ) -> GroupUse {
        let (group, maximum) = (&self.groups[index], &self.maxima[index]);
        let mut ties: Vec<Tie> = Vec::new();
        let mut known: BTreeMap<String, usize> = BTreeMap::new();
        for variable in &group.variables {
            let index = variable.0 as usize;
            let variable = &self.model.variables[index];
            let device = names.device(variable);
            let tie = *known.entry(device.clone()).or_insert(ties.len());
            if tie == ties.len() {
                ties.push(Tie { device, comment: names.comment(variable), uses: 0 });
            }
            ties[tie].uses += uses[index];
        }
        let devices = ties.iter().map(|tie| tie.device.clone()).collect();
        ties.sort_by_key(|tie| Reverse(tie.uses));
        let blocks: BTreeSet<u32> = charges.iter().map(|charge| charge.block).collect();
        GroupUse {
            id: index + 1,
            blocks: blocks.into_iter().collect(),
            devices,
            ties,
            upper: maximum.upper,
            lower: match real {
                Some(_) => charges.iter().map(|charge| charge.cost).sum(),
                None => maximum.lower,
            },
            naive: charges.iter().map(|charge| charge.on.max(charge.off)).sum(),
            solver_calls: maximum.calls,
            rungs,
            charges,
            search,
        }
    }

    /// The search that explains why rungs of a group do not take their longest time: the prepared one if there is one,
    /// otherwise a new one. `None` if the group's longest scan takes the larger time of every charge, so that there is
    /// nothing to explain.
    fn exclusions(
        &self,
        group: &Group,
        maximum: &Maximum,
        prepared: Option<PreparedExplanation<'a>>,
    ) -> Option<Exclusions<'a>> {
        let most = group.charges.iter().map(|&charge| self.model.charges[charge].largest_cost());
        let lower = maximum.lower;
        (lower < most.sum()).then(|| match prepared {
            Some(prepared) => prepared.exclusions,
            None => Exclusions::of(self.model, group, self.limits),
        })
    }

    /// The group's rungs, the one with the longest possible time first. With `exclusions`, each of the first
    /// [`MAX_EXPLAINED`] rungs that does not take its longest time gets the reason, if one is found.
    fn rungs(
        &self,
        group: &Group,
        charges: &[ChargeUse],
        names: &Names<'_>,
        exclusions: Option<&mut Exclusions<'_>>,
    ) -> Vec<RungUse> {
        let instruction = |index: usize| {
            &self.program.instructions[self.model.charges[group.charges[index]].instruction]
        };
        let comments = |index: usize| names.comments_in(instruction(index));
        let mut found = rungs(charges, comments);
        let missing: Vec<(usize, usize)> = found
            .iter()
            .take(MAX_EXPLAINED)
            .enumerate()
            .filter_map(|(at, rung)| Some((at, group.charges[rung.shortest?])))
            .collect();
        let wanted: Vec<usize> = missing.iter().map(|(_, charge)| *charge).collect();
        let block =
            |charge: usize| self.program.instructions[self.model.charges[charge].instruction].block;
        if let Some(exclusions) = exclusions {
            let reasons = exclusions.in_scan(self.model, self.assignment, &wanted);
            for ((rung, charge), reason) in missing.into_iter().zip(reasons) {
                found[rung].shown.exclusion = reason.map(|others| Exclusion {
                    blocks: BTreeSet::from_iter(others.iter().map(|&other| block(other)))
                        .into_iter()
                        .collect(),
                    devices: self.shared_devices(group, charge, &others, names),
                });
            }
        }
        found.into_iter().map(|rung| rung.shown).collect()
    }

    /// The names of the devices in the guards of both the charge and one of the others (indices into the charges of the
    /// model). If there are no others: of all devices in the guards of the charge.
    fn shared_devices(
        &self,
        group: &Group,
        charge: usize,
        others: &[usize],
        names: &Names<'_>,
    ) -> Vec<String> {
        let own = depends_on(self.model, &[charge]);
        let theirs = depends_on(self.model, others);
        let shared = group.variables.iter().filter(|variable| {
            own.contains(variable) && (others.is_empty() || theirs.contains(variable))
        });
        let mut devices: Vec<String> = Vec::new();
        for variable in shared {
            let device = names.device(&self.model.variables[variable.0 as usize]);
            if !devices.contains(&device) {
                devices.push(device);
            }
        }
        devices
    }

    /// For each variable of the model, the number of uses of its atoms: by gates on which charges depend, and by guards
    /// of charges whose time is not always the same.
    fn uses(&self) -> Vec<usize> {
        let nodes = self.model.circuit.nodes();
        let mut needed = vec![false; nodes.len()];
        let mut asked = vec![0; nodes.len()];
        for charge in self.model.charges.iter().filter(|charge| !charge.is_constant()) {
            for lit in charge.literals() {
                needed[lit.node()] = true;
                asked[lit.node()] += 1;
            }
        }
        for index in (0..nodes.len()).rev().filter(|&index| index > 0) {
            if let (true, Node::And(a, b)) = (needed[index], nodes[index]) {
                for input in [a.node(), b.node()] {
                    needed[input] = true;
                    asked[input] += 1;
                }
            }
        }
        let mut uses = vec![0; self.model.variables.len()];
        for (node, asked) in nodes.iter().zip(asked) {
            if let Node::Atom(atom @ (Atom::Bit(_) | Atom::AtLeast(..) | Atom::WordBit(..))) = node
            {
                uses[atom.variable().0 as usize] += asked;
            }
        }
        uses
    }

    /// The values of the scan that the report shows: start values first, then nondeterministic values. Also the time of
    /// the groups' charges in the model's scan with these values; each [`FreeValue::worth`] is a part of that time. The
    /// scan is the longest real run, or if `same` the model's longest scan.
    fn witness(
        &self,
        names: &Names<'_>,
        found: &RunResults,
        same: bool,
    ) -> (Vec<FreeValue>, Picos) {
        let charges: Vec<usize> =
            self.groups.iter().flat_map(|group| group.charges.iter().copied()).collect();
        let started = (!same).then(|| started(self.model, found));
        let assignment = started.as_ref().unwrap_or(self.assignment);
        let matters = needed_variables(self.model, assignment, &charges);
        let mut variables: Vec<usize> = self
            .groups
            .iter()
            .flat_map(|group| group.variables.iter().map(|variable| variable.0 as usize))
            .collect();
        variables.sort_unstable();
        let weighed: Vec<usize> = variables.iter().copied().filter(|&one| matters[one]).collect();
        let worth = weights(self.model, assignment, &charges, &weighed);
        let worth: BTreeMap<usize, Picos> = weighed.into_iter().zip(worth).collect();
        let mut known: BTreeMap<String, usize> = BTreeMap::new();
        let mut values: Vec<FreeValue> = variables
            .iter()
            .copied()
            .map(|index| {
                let variable = &self.model.variables[index];
                let name = names.free(variable);
                let times = known.entry(name.clone()).or_default();
                *times += 1;
                let word = assignment.0[index];
                FreeValue {
                    name: match *times {
                        1 => name,
                        n => format!("{name} ({n})"),
                    },
                    comment: names.comment(variable),
                    value: match variable.kind {
                        VarKind::Bit => Value::Bit(word != 0),
                        VarKind::Word => Value::Word(word.cast_signed()),
                    },
                    at_start: matches!(variable.origin, Origin::Start(_)),
                    matters: matters[index],
                    worth: worth.get(&index).copied().unwrap_or_default(),
                }
            })
            .collect();
        let starts =
            variables.iter().filter_map(|&index| match self.model.variables[index].origin {
                Origin::Start(cell) => Some(cell),
                _ => None,
            });
        let others = other_starts(self.program, found, &starts.collect());
        values.extend(others.into_iter().map(|(cell, word, matters)| FreeValue {
            name: self.program.cell_name(cell),
            comment: names.comment_of(cell),
            value: match self.program.area(cell.area).kind {
                AreaKind::Bit => Value::Bit(word != 0),
                AreaKind::Word => Value::Word(word.cast_signed()),
            },
            at_start: true,
            matters,
            worth: Picos::ZERO,
        }));
        values.sort_by_key(|free| !free.at_start);
        (values, self.model.cost(&charges, assignment))
    }

    /// For each charge, its instruction and its part of the bound. What the search left open is in no part.
    fn shares(&self, groups: &[ExplainedGroup], always: &[ChargeUse]) -> Vec<(usize, Picos)> {
        let instruction = |charge: &usize| self.model.charges[*charge].instruction;
        let constant = self.model.constant_charges();
        let grouped = self.groups.iter().zip(groups).flat_map(|(group, explained)| {
            group.charges.iter().map(instruction).zip(explained.charges.iter().map(|one| one.share))
        });
        let always = constant.iter().map(instruction).zip(always.iter().map(|one| one.share));
        grouped.chain(always).collect()
    }

    /// For each execution, its instruction and its time in the scan that the report shows: the real run `real`, or the
    /// model's longest scan.
    fn costs(&self, real: Option<&RunResults>) -> Vec<(usize, Picos)> {
        match real {
            None => {
                let values = self.model.circuit.evaluate(self.assignment);
                let charges = self.model.charges.iter();
                charges.map(|charge| (charge.instruction, charge.cost(&values))).collect()
            }
            Some(found) => Executed::of(self.program, &found.best).costs().collect(),
        }
    }

    fn networks(&self) -> Vec<NetworkUse> {
        let first = |at: usize| self.program.instructions[at].place;
        let uses = self.prices.networks.iter();
        uses.map(|one| NetworkUse { what: one.what.clone(), first: first(one.first) }).collect()
    }

    fn approximations(&self) -> Vec<ApproximationUse> {
        let mut found: Vec<ApproximationUse> = self
            .program
            .approximations
            .iter()
            .map(|one| {
                let instruction = &self.program.instructions[one.instruction];
                ApproximationUse {
                    at: instruction.place,
                    instruction: instruction.text.clone(),
                    what: one.what.clone(),
                }
            })
            .collect();
        found.sort_by_cached_key(|one| (one.at, one.what.to_string()));
        found
    }
}

//! Puts together what a report shows from what the stages found.

use super::assumption::Assumption;
use super::deciding::{deciding, depends_on};
use super::doubt::Doubt;
use super::exactness::Exactness;
use super::executed::{Executed, stands_between, started};
use super::fact::Fact;
use super::made_from::sources;
use super::method::SearchUse;
use super::model_search::Prepared;
use super::names::Names;
use super::proved::Proved;
use super::real::Found;
use super::request::Request;
use super::response::Delays;
use super::unbounded::Loops;
use super::unknown::Unknown;
use super::unknown_writes;
use super::weight::weights;
use super::{
    ApproximationUse, AssumedUse, Audit, Bound, ChargeUse, Exclusion, FactorUse, Fate, FreeValue,
    GroupUse, NetworkUse, OverheadUse, PathStep, RunScan, RungUse, Share, TableUse, Tie, Value,
    possible,
};
use crate::base::budget::Cut;
use crate::base::diagnostic::Diagnostic;
use crate::base::time::Picos;
use crate::front::Open;
use crate::program::Program;
use crate::replay::{Event, Replay};
use crate::scan::model::{Assignment, Atom, Group, Node, Origin, ScanModel, Values, VarKind};
use crate::solve::{Exclusions, Limits, Maximum};
use crate::timing::price::{Price, Prices};
use crate::timing::table::{Evidence, Table};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Instant;

/// For so many rungs a group it is asked why they don't cost their most.
const MOST_EXPLAINED: usize = 20;

/// What the search found, and in what.
pub struct Findings<'a> {
    pub request: &'a Request<'a>,
    pub program: &'a Program,
    pub table: &'a Table,
    pub prices: &'a Prices,
    pub model: &'a ScanModel,
    /// What of the machine the user may state.
    pub open: Open,
    pub groups: &'a [Group],
    pub maxima: &'a [Maximum],
    /// The best assignments of all groups together.
    pub assignment: &'a Assignment,
    /// What ends the search for reasons.
    pub limits: &'a Limits<'a>,
}

/// What the bound's parts are, what they cost in the model's scan, and why rungs don't cost their most there.
pub struct Explained {
    overhead: Vec<OverheadUse>,
    always: Vec<ChargeUse>,
    /// Of each group, its charges and its rungs.
    groups: Vec<(Vec<ChargeUse>, Vec<RungUse>)>,
}

/// What the stages behind the search found.
pub struct Finished<'a> {
    /// The longest real run, and the values with which it starts.
    pub found: &'a Found,
    /// Whether that is the assignment's scan.
    pub same: bool,
    /// When the audit began.
    pub start: Instant,
    pub warnings: Vec<Diagnostic>,
    pub cuts: Vec<Cut>,
    pub ended_early: bool,
    pub explained: Explained,
    /// How each group's maximum was found.
    pub searches: Vec<SearchUse>,
    pub loops: Loops,
    /// A run from power-up, if one was found.
    pub run: Vec<RunScan>,
    /// The delays around the scan, if a response time is asked for.
    pub delays: Option<Delays>,
    /// The facts that the program keeps.
    pub proved: Proved,
}

impl<'a> Findings<'a> {
    /// What the bound rests on and is not known: counts, then where is written.
    fn unknowns(&self, upper: Picos) -> Vec<Unknown> {
        let mut unknowns = Unknown::counted(self.program, &self.prices.times(), upper);
        unknowns.extend(unknown_writes::all(self.program, self.model, self.groups, self.open));
        unknown_writes::put_last(&mut unknowns, self.program, self.model);
        unknowns
    }

    /// Shares out the bound, and asks why rungs don't cost their most; of one group that may be `prepared`.
    pub fn explain(&self, mut prepared: Option<Prepared<'a>>) -> Explained {
        let names = Names::new(self.program);
        let values = self.model.circuit.evaluate(self.assignment);
        let pick = |charges: &[usize]| -> Vec<ChargeUse> {
            charges.iter().map(|&charge| self.charge(charge, &values, &names)).collect()
        };
        let always = pick(&self.model.constant());
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
            if !maximum.kept {
                // No scan of the group was found: all of its part in the bound is open.
                charges.iter_mut().for_each(|charge| charge.share = Picos::ZERO);
            }
            let rungs = self.rungs(group, &charges, &names, exclusions.as_mut());
            let dearer = |charge: &ChargeUse| charge.on.max(charge.off);
            if maximum.upper == charges.iter().map(dearer).sum() {
                // Nothing was taken off: the bound is their sum, so what each takes of it is known.
                charges.iter_mut().for_each(|charge| charge.share = dearer(charge));
            }
            (charges, rungs)
        };
        let groups = self.groups.iter().zip(self.maxima).enumerate().map(explained).collect();
        Explained { overhead, always, groups }
    }

    /// The audit.
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
        } = finished;
        let Explained { overhead, always, mut groups } = explained;
        // The scan that is shown, where it is not that of the assignment.
        let real = Some(found).filter(|_| !same);
        if let Some(real) = real {
            self.show(&Executed::of(self.program, &real.best), &mut groups);
        }
        let bound = self.bound(&always, &overhead, real);
        let names = Names::new(self.program);
        let uses = self.uses();
        let groups = groups.into_iter().zip(searches).enumerate();
        let groups = groups
            .map(|(index, (explained, search))| {
                self.group(index, explained, search, &names, &uses, real)
            })
            .collect();
        let table = self.table(&bound, &overhead, real);
        let clocked = self.program.clocked;
        let possible = possible(&bound, table.factor.as_ref(), clocked.is_some());
        let stands_between = real
            .filter(|_| bound.lower < bound.model)
            .map(|real| stands_between(self.program, &real.best));
        let networks = self.networks();
        let response = delays.map(|delays| delays.around(bound.upper));
        Audit {
            files: self.program.files.iter().map(|file| file.name.clone()).collect(),
            standby: self.program.standby.clone(),
            sources: sources(self.request, self.program, self.table),
            dialect: self.program.dialect.clone(),
            cpu: self.program.cpu.clone(),
            instructions: self.program.files.iter().map(|file| file.count).sum(),
            blocks: self.program.blocks,
            clocked,
            table,
            doubts: Doubt::all(self.program, &networks, &loops.found, &loops.open, bound.upper),
            assumptions: Assumption::all(self.program),
            unknowns: self.unknowns(bound.upper),
            what_if: None,
            coactivity: None,
            tasks: Vec::new(),
            net: None,
            ladder: None,
            bound,
            overhead,
            always,
            groups,
            witness: self.witness(&names, real),
            witness_run: match clocked {
                None => run,
                // Every scan takes as long; the clock may be slower, and is not known to be.
                Some(_) => {
                    let at_most = |scan: RunScan| RunScan { took: scan.took.min(possible), ..scan };
                    run.into_iter().map(at_most).collect()
                }
            },
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

    /// The bound: all that is always paid, and the groups' maxima.
    fn upper(&self, always: &[ChargeUse], overhead: &[OverheadUse]) -> Picos {
        let always = always.iter().map(|charge| charge.cost);
        let overhead = overhead.iter().map(|term| term.time);
        always.chain(overhead).chain(self.maxima.iter().map(|maximum| maximum.upper)).sum()
    }

    fn bound(&self, always: &[ChargeUse], overhead: &[OverheadUse], real: Option<&Found>) -> Bound {
        let upper = self.upper(always, overhead);
        let always: Picos = always.iter().map(|charge| charge.cost).sum();
        let overhead: Picos = overhead.iter().map(|term| term.time).sum();
        let lower: Picos = self.maxima.iter().map(|maximum| maximum.lower).sum();
        let model = always + overhead + lower;
        let lower = real.map_or(model, |real| overhead + real.best.replay.total);
        Bound {
            upper,
            lower,
            // A search that ends early may know less of the model than of real scans.
            model: model.max(lower),
            naive: overhead + self.model.charges.iter().map(|charge| charge.dearer()).sum(),
            always,
            overhead,
            groups: self.maxima.iter().map(|maximum| maximum.upper).sum(),
        }
    }

    /// Takes from a scan that was run what charges cost in it.
    fn show(&self, executed: &Executed, groups: &mut [(Vec<ChargeUse>, Vec<RungUse>)]) {
        for (group, (uses, _)) in self.groups.iter().zip(groups) {
            for (&charge, shown) in group.charges.iter().zip(uses) {
                let charge = &self.model.charges[charge];
                (shown.reached, shown.runs, shown.cost) =
                    executed.at(charge.instruction, &charge.frames);
            }
        }
    }

    /// The path of a scan through the program, instruction by instruction.
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
        (charges, rungs): (Vec<ChargeUse>, Vec<RungUse>),
        search: SearchUse,
        names: &Names<'_>,
        uses: &[usize],
        real: Option<&Found>,
    ) -> GroupUse {
        let (group, maximum) = (&self.groups[index], &self.maxima[index]);
        let mut by_device: BTreeMap<String, (usize, usize, String)> = BTreeMap::new();
        for (order, variable) in group.variables.iter().enumerate() {
            let index = variable.0 as usize;
            let variable = &self.model.variables[index];
            let known = by_device.entry(names.device(variable));
            known.or_insert_with(|| (order, 0, names.comment(variable))).1 += uses[index];
        }
        let mut devices: Vec<(String, (usize, usize, String))> = by_device.into_iter().collect();
        devices.sort_by_key(|(_, (order, ..))| *order);
        let mut ties: Vec<Tie> = devices
            .iter()
            .map(|(device, (_, uses, comment))| Tie {
                device: device.clone(),
                comment: comment.clone(),
                uses: *uses,
            })
            .collect();
        ties.sort_by_key(|tie| Reverse(tie.uses));
        let blocks: BTreeSet<u32> = charges.iter().map(|charge| charge.block).collect();
        GroupUse {
            id: index + 1,
            blocks: blocks.into_iter().collect(),
            devices: devices.into_iter().map(|(device, _)| device).collect(),
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

    /// What is asked why rungs don't cost their most; none if all of the group's do.
    fn exclusions(
        &self,
        group: &Group,
        maximum: &Maximum,
        prepared: Option<Prepared<'a>>,
    ) -> Option<Exclusions<'a>> {
        let most = group.charges.iter().map(|&charge| self.model.charges[charge].dearer());
        let lower = maximum.lower;
        (lower < most.sum()).then(|| match prepared {
            Some(prepared) => prepared.exclusions,
            None => Exclusions::of(self.model, group, self.limits),
        })
    }

    /// The group's rungs, the dearest first, and why the dearest of them don't cost their most.
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
            .take(MOST_EXPLAINED)
            .enumerate()
            .filter_map(|(rung, (_, missing))| Some((rung, group.charges[(*missing)?])))
            .collect();
        let wanted: Vec<usize> = missing.iter().map(|(_, charge)| *charge).collect();
        let block =
            |charge: usize| self.program.instructions[self.model.charges[charge].instruction].block;
        if let Some(exclusions) = exclusions {
            let reasons = exclusions.in_scan(self.model, self.assignment, &wanted);
            for ((rung, charge), reason) in missing.into_iter().zip(reasons) {
                found[rung].0.exclusion = reason.map(|others| Exclusion {
                    blocks: BTreeSet::from_iter(others.iter().map(|&other| block(other)))
                        .into_iter()
                        .collect(),
                    devices: self.shared_devices(group, charge, &others, names),
                });
            }
        }
        found.into_iter().map(|(rung, _)| rung).collect()
    }

    /// The devices on which the charge and one of the others depend; all of its own if there is no other.
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

    /// For each variable how many gates and charges ask for it.
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

    fn witness(&self, names: &Names<'_>, real: Option<&Found>) -> Vec<FreeValue> {
        let charges: Vec<usize> =
            self.groups.iter().flat_map(|group| group.charges.iter().copied()).collect();
        let started = real.map(|found| started(self.model, found));
        let assignment = started.as_ref().unwrap_or(self.assignment);
        let matters = deciding(self.model, assignment, &charges);
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
        let mut found: Vec<FreeValue> = variables
            .into_iter()
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
        found.sort_by_key(|free| !free.at_start);
        found
    }

    fn table(&self, bound: &Bound, overhead: &[OverheadUse], real: Option<&Found>) -> TableUse {
        let assumed = |price: &&Arc<Price>| price.evidence == Evidence::Assumed;
        let mut rows: Vec<AssumedUse> = Vec::new();
        let mut known: BTreeMap<&str, usize> = BTreeMap::new();
        let mut row_of: Vec<Option<usize>> = Vec::new();
        for (instruction, price) in self.program.instructions.iter().zip(&self.prices.instructions)
        {
            let row = price.as_ref().filter(assumed).map(|price| {
                let mnemonic = instruction.text.split(' ').next().unwrap_or_default();
                let name = if price.by_class { mnemonic } else { &price.row };
                let row = *known.entry(name).or_insert_with(|| {
                    rows.push(AssumedUse {
                        name: name.to_owned(),
                        row: price.row.to_string(),
                        by_class: price.by_class,
                        count: 0,
                        time: Picos::ZERO,
                    });
                    rows.len() - 1
                });
                rows[row].count += 1;
                row
            });
            row_of.push(row);
        }
        let costs: Vec<(usize, Picos)> = match real {
            None => {
                let values = self.model.circuit.evaluate(self.assignment);
                let charges = self.model.charges.iter();
                charges.map(|charge| (charge.instruction, charge.cost(&values))).collect()
            }
            Some(found) => Executed::of(self.program, &found.best).costs().collect(),
        };
        for (instruction, cost) in costs {
            if let Some(row) = row_of[instruction] {
                rows[row].time += cost;
            }
        }
        let mut assumed = rows;
        assumed.extend(
            self.prices.overhead.iter().filter(|term| term.evidence == Evidence::Assumed).map(
                |term| AssumedUse {
                    name: term.name.clone(),
                    row: term.name.clone(),
                    by_class: false,
                    count: 0,
                    time: term.time,
                },
            ),
        );
        let factor = self.prices.factor.as_ref();
        assumed.extend(factor.filter(|one| one.evidence == Evidence::Assumed).map(|factor| {
            let own: Picos = assumed.iter().map(|one| one.time).sum();
            let others = bound.lower.checked_sub(own).unwrap_or_default();
            AssumedUse {
                name: format!("factor {}", factor.text),
                row: "@factor".to_owned(),
                by_class: false,
                count: 0,
                time: others.checked_sub(factor.taken_off(others)).unwrap_or_default(),
            }
        }));
        assumed.sort_by(|a, b| (Reverse(a.time), &a.name).cmp(&(Reverse(b.time), &b.name)));
        let assumed_time: Picos = assumed.iter().map(|one| one.time).sum();
        TableUse {
            name: self.table.name.clone(),
            title: self.table.title.clone(),
            notes: self.table.notes.clone(),
            watchdog: self.table.watchdog(),
            factor: factor.map(|factor| {
                let groups = self.maxima.iter().map(|maximum| maximum.upper);
                let parts = overhead.iter().map(|term| term.time).chain(groups);
                let bare: Picos =
                    parts.chain([bound.always]).map(|time| factor.taken_off(time)).sum();
                FactorUse {
                    text: factor.text.clone(),
                    evidence: factor.evidence,
                    source: factor.source.clone(),
                    without: factor.taken_off(bound.upper),
                    millionths: factor.millionths,
                    part: bound.upper.checked_sub(bare).unwrap_or_default(),
                }
            }),
            assumed_share: Share::of(assumed_time, bound.lower),
            assumed,
            assumed_time,
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

/// The group's rungs, the dearest first, each with the charge (by its place among the group's) that falls
/// shortest of its dearer time.
fn rungs(
    charges: &[ChargeUse],
    comments: impl Fn(usize) -> Vec<String>,
) -> Vec<(RungUse, Option<usize>)> {
    let mut by_block: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (index, charge) in charges.iter().enumerate() {
        by_block.entry(charge.block).or_default().push(index);
    }
    let dearer = |index: usize| charges[index].on.max(charges[index].off);
    let short = |index: usize| dearer(index).checked_sub(charges[index].share).unwrap_or_default();
    let mut rungs: Vec<(RungUse, Option<usize>)> = by_block
        .into_iter()
        .filter_map(|(block, own)| {
            let dearest = own.iter().copied().rev().max_by_key(|&index| dearer(index))?;
            let shown = &charges[dearest];
            let full = own.iter().filter(|&&index| short(index) == Picos::ZERO).count();
            let rung = RungUse {
                block,
                at: shown.at,
                instruction: shown.instruction.clone(),
                comments: comments(dearest),
                others: own.len() - 1,
                fate: match full {
                    0 => Fate::Excluded,
                    n if n == own.len() => Fate::Runs,
                    _ => Fate::Partly,
                },
                cost: own.iter().map(|&index| charges[index].share).sum(),
                naive: own.iter().map(|&index| dearer(index)).sum(),
                exclusion: None,
            };
            let missing = own.into_iter().rev().max_by_key(|&index| short(index));
            Some((rung, missing.filter(|&index| short(index) > Picos::ZERO)))
        })
        .collect();
    rungs.sort_by_key(|(rung, _)| (Reverse(rung.naive), rung.block));
    rungs
}

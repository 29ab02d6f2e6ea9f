//! Lowers a project to a program: tasks, instances of programs, and the routines that these call.

use super::address::{self, Located};
use super::first_values::FIRST_SCAN;
use super::spots::Callee;
use super::spots::{Context, Found, Instance, Spot, SpotKey};
use super::{Entry, GivenBack, Lower, Options};
use crate::assembler::Assembler;
use crate::assembler::competing::Competing;
use scanbound_base::code::Code as FaultCode;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{ActionOrder, Facts, Part, normalized};
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_front::builder::always;
use scanbound_front::stopped;
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, Project, Section};
use scanbound_iec_tree::declarations::{
    Code, Owner, Routine, RoutineId, RoutineKind, Stated, UnitId, VarId, Variable,
};
use scanbound_iec_tree::resolve;
use scanbound_iec_tree::tree::{Connected, Expr, ExprKind, Pair, Parameter, Task, Tree};
use scanbound_iec_tree::types::Type as Typed;
use scanbound_ir::meaning::{ChoiceKind, OperationInput, Target};
use scanbound_ir::{
    Cell, MissingRoutine, Number, Program, Region, RegionSet, SourceFile, Step, Tag, WordSource,
    WordTarget, Write, flow,
};
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// Properties of the programming tool that the project's text shows.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SourceTraits {
    /// Whether the tool may execute methods before the first scan that no code calls (`call_after_init` of CODESYS).
    pub(crate) begins_with_more: bool,
}

/// Lowers a project to a program. `with_unused` also lowers function blocks with charts that no program has an instance
/// of.
///
/// # Errors
/// Returns all faults found. If the time limit or the user ended lowering, the only error says so.
pub(crate) fn decode(
    project: &Project,
    dialect: &str,
    traits: SourceTraits,
    with_unused: bool,
    asked: &scanbound_front::Options<'_>,
) -> Result<Program, Vec<Diagnostic>> {
    // The alphabetical order is that of CODESYS and TwinCAT alone. Of other files their settings are not known.
    let has_their_order = asked.facts.action_order == Some(ActionOrder::Alphabetical);
    let actions_first = project.is_of_codesys || has_their_order;
    let faults = resolve::faults(project);
    if !faults.is_empty() {
        return Err(told(project, faults));
    }
    let files: Vec<[&str; 2]> =
        (0..project.files.len()).map(|at| file_names(&project.files, at)).collect();
    let facts = resolve::Facts { calls: &asked.facts.calls, files: &files };
    let tree = resolve::tree(project, facts);
    if !tree.faults.is_empty() {
        return Err(told(project, tree.faults));
    }
    let options = Options {
        stated_turns: asked.facts.counts.clone(),
        is_incomplete: asked.absent_calls_take_no_time,
        with_unused,
        charts: super::ChartOptions {
            actions_first,
            competing: Competing::new(project, asked.facts, actions_first, 0),
            action_order: asked.facts.action_order,
            drawn_last_scan: asked.facts.drawn_last_scan,
            others_write: asked.others_write,
        },
    };
    let mut own = Lower::new(project, &tree, dialect, options);
    own.budget = asked.budget;
    let stated = asked.facts.controller.iter();
    own.stated_readings = stated.map(|(what, &holds)| (what.clone(), (false, holds))).collect();
    own.stops_on_error = asked.facts.stops_on_error.unwrap_or(true);
    own.assembler().faults.extend(project.unread.iter().cloned());
    if tree.tasks.iter().all(|task| task.programs.is_empty()) {
        let help = "give the file that has the PROGRAM which the task runs";
        let fault = Fault::new(1, "the project has no program").code(FaultCode::NoProgram);
        own.assembler().faults.push((0, fault.help(help)));
    }
    let mut tasks: Vec<&Task> = tree.tasks.iter().collect();
    if let Some(at) = asked.task.and_then(|name| tree.task(name)) {
        tasks[..=at].rotate_right(1);
    }
    own.options.charts.competing = Competing::new(project, asked.facts, actions_first, tasks.len());
    own.program_of(&tasks, traits, asked)
}

impl<'t> Lower<'t> {
    fn program_of(
        mut self,
        tasks: &[&Task],
        traits: SourceTraits,
        asked: &scanbound_front::Options<'_>,
    ) -> Result<Program, Vec<Diagnostic>> {
        let (project, tree) = (self.project, self.tree);
        let mut entries = Vec::new();
        let mut main = 0..0;
        let (mut first, mut image, mut constants) = (None, None, None);
        self.place_programs(tasks);
        if let Err(fault) = self.find_targets() {
            self.assembler().faults.push((0, fault));
        }
        for (number, task) in tasks.iter().enumerate() {
            entries.push(self.builder.next());
            // With several tasks, it is not known which one runs first.
            if tasks.len() == 1 && self.has_first_values() {
                first = self.first_scan();
            }
            if number == 0 {
                let mut all = self.tree.variables.iter();
                if all.any(|one| is_lasting(one.owner) && one.is_given()) {
                    constants = Some(self.assembler().begin_constants());
                }
                image = self.begin_image();
            }
            // Each task has its own copies of the routines, because two tasks may be inside the same routine at once.
            self.routines.task = number;
            self.routines.known.clear();
            self.effects.clear();
            for program in &task.programs {
                match program {
                    Ok(at) => self.program_called(*at),
                    Err(fault) => self.assembler().faults.push((0, fault.clone())),
                }
            }
            let last = if number == 0 { Step::End } else { Step::Return };
            if self.options.with_unused {
                self.unused_charts();
            }
            self.assembler().builder.add(None, Vec::new(), last);
            if number == 0 {
                main.end = self.builder.next();
            }
            self.called_routines();
        }
        if self.is_late()
            && let Some(reason) = self.stopped
        {
            return Err(vec![stopped(reason, project.files.first().map_or("", String::as_str))]);
        }
        let given_back = std::mem::take(&mut self.given_back);
        changed_by_others(self.assembler(), &entries, &given_back);
        self.addresses_stay();
        let located = self.located();
        let shared = address::share(self.assembler(), &located, &given_back);
        self.begin_shared(image, &located);
        let given = self.given_constants();
        self.assembler().give_constants(constants, given);
        self.bound_bytes(&located);
        let own = std::mem::take(&mut self.memory.begin_anew);
        let (mut known, values) = self.power_up(traits.begins_with_more);
        // Variables that share memory begin with the value that either of them declares.
        known.cleared.retain(|own| !shared.overlaps(*own));
        let is_within = |all: &[Region], cell| all.iter().any(|one| one.contains(cell));
        let begins_off = |cell| is_within(&known.cleared, cell) && !is_within(&known.latched, cell);
        self.assembler().settle(&own, &begins_off);
        if !self.faults.is_empty() {
            let mut faults = std::mem::take(&mut self.assembler().faults);
            resolve::list_unknown_types(tree, &mut faults);
            return Err(told(project, faults));
        }
        known.latched = RegionSet::from_iter(known.latched).into_regions();
        self.assembler().note_first_values(first, values, &shared, &mut known);
        known.inputs = RegionSet::from_iter(known.inputs).into_regions();
        known.cleared = RegionSet::from_iter(known.cleared).into_regions();
        known.lent = lent(self.program(), &given_back, &known.latched);
        self.program().power_up = known;
        let unknown = self.unknown_readings(asked.facts);
        if !unknown.is_empty() {
            return Err(unknown);
        }
        let program = std::mem::take(&mut self.assembler().builder.program);
        Ok(finish(program, tree, project, tasks, &entries, main, asked))
    }

    /// One error for each statement of the user about the controller on which nothing in this project depends.
    fn unknown_readings(&self, facts: &Facts) -> Vec<Diagnostic> {
        let all = self.stated_readings.iter();
        let (met, not): (Vec<_>, Vec<_>) = all.partition(|(_, (is_met, _))| *is_met);
        let known = met.into_iter().map(|(what, _)| what).chain(&self.builder.program.readings);
        let known: Vec<String> = known.map(|what| format!("\"{what}\"")).collect();
        let help = match known.is_empty() {
            true => {
                "remove it: this project depends on nothing that controllers do in different ways"
                    .to_owned()
            }
            false => format!("remove it, or write one of these: {}", known.join(", ")),
        };
        let fault = |(what, _): (&String, _)| {
            let message = format!("nothing in this project depends on whether '{what}'");
            facts.fault(["controller", what], Part::Key, FaultCode::Fact, message, &help)
        };
        not.into_iter().map(fault).collect()
    }

    /// Whether any lasting variable has an initial value other than 0. If not, no initial values need to be written.
    fn has_first_values(&self) -> bool {
        let mut all = self.tree.variables.iter();
        all.any(|one| is_lasting(one.owner) && !one.is_given() && one.begins.has_number())
    }

    /// Creates the instances of all programs first, since the code of one task may name programs of another.
    fn place_programs(&mut self, tasks: &[&Task]) {
        for task in tasks {
            let placed = task.programs.iter().flatten().map(|&at| self.program_instance(at));
            let own = placed.filter_map(Result::ok).collect();
            self.routines.tasks.push(own);
        }
    }

    /// Adds a call of an instance of each function block that has charts, and of each of its actions that is a chart.
    fn unused_charts(&mut self) {
        let tree = self.tree;
        for (at, unit) in tree.units.iter().enumerate() {
            let id = UnitId::at(at);
            if unit.kind != PouKind::FunctionBlock || self.charts_of(id).is_empty() {
                continue;
            }
            let Ok(instance) = self.unit_instance(&unit.name, id) else { continue };
            self.call(instance, Entry::Body);
            let is_chart =
                |action: &&RoutineId| matches!(tree.routine(**action).code, Code::Chart(_));
            unit.actions
                .iter()
                .filter(is_chart)
                .for_each(|&one| self.call(instance, Entry::Routine(one)));
        }
    }

    /// Adds the call of a program, with the copies of its connected inputs before it and of its outputs after it.
    fn program_called(&mut self, at: usize) {
        let tree = self.tree;
        let program = &tree.programs[at];
        let unit = tree.unit(program.unit);
        self.file = unit.file;
        match self.program_instance(at) {
            Ok(instance) => {
                self.at(unit.line, &format!("PROGRAM {}", program.name));
                let connected = tree.connected.iter().find(|one| one.instance == Some(at));
                connected.into_iter().for_each(|one| self.connect(instance, one, false));
                let key = Assembler::key(&["PROGRAM", "CAL"], "call");
                self.call_as(key, instance, Entry::Body);
                connected.into_iter().for_each(|one| self.connect(instance, one, true));
            }
            Err(fault) => self.fault(fault),
        }
    }

    /// Copies the values connected to a program's inputs or, if `outputs`, from its outputs to the connected variables.
    fn connect(&mut self, instance: usize, connected: &Connected, outputs: bool) {
        let around = std::mem::replace(&mut self.file, connected.file);
        let file = u32::try_from(self.file).unwrap_or(u32::MAX);
        let place = Location { file, line: connected.line, step: None };
        let name = connected.instance.map_or("", |at| &self.tree.programs[at].name);
        let text = format!("PROGRAM {name}").into();
        self.assembler().builder.at(place, text, [].into());
        for pair in &connected.pairs {
            let done = match pair {
                Ok(pair) if pair.is_output == outputs => {
                    self.connect_one(instance, pair, connected.line)
                }
                Ok(_) => Ok(()),
                Err(fault) if !outputs => Err(fault.clone()),
                Err(_) => Ok(()),
            };
            if let Err(fault) = done {
                self.fault(fault);
            }
        }
        self.file = around;
    }

    fn connect_one(&mut self, instance: usize, pair: &Pair, line: u32) -> Result<(), Fault> {
        let at = Context { instance, frame: None };
        let Instance { unit, spot } = self.instances[instance].clone();
        let callee = Callee::Unit(spot, unit);
        let Some(own) = self.parameter(&callee, Parameter::Variable(pair.own)) else {
            return Ok(());
        };
        let ExprKind::Read(place) = &pair.other.kind else {
            let value = self.value(&at, &pair.other)?;
            return self.copied_to(Found::Spot(own), value, line);
        };
        let Some(other) = self.spot(&at, place, line)? else {
            let told = "this connection of a program is not modelled";
            return Err(Fault::new(line, told).code(FaultCode::NotModelled));
        };
        let (from, to) = if pair.is_output { (own, other) } else { (other, own) };
        if from.tag.cell().is_none() {
            let to = Found::Spot(to);
            let key = self.store_key(&to, None, line)?;
            self.copy(&Found::Spot(from), &to, key);
            return Ok(());
        }
        self.cost(&["LD"], "contact");
        let value = self.read_spot(&from);
        self.copied_to(Found::Spot(to), value, line)
    }

    fn copied_to(
        &mut self,
        to: Found,
        value: crate::assembler::value::Value,
        line: u32,
    ) -> Result<(), Fault> {
        let key = self.store_key(&to, None, line)?;
        let writes = self.writes(to, value, line)?;
        self.add_always(key, writes);
        Ok(())
    }

    /// Lowers the routines of all open calls and sets the calls' targets, until no call is open.
    fn called_routines(&mut self) {
        while let Some((call, instance, entry)) = self.routines.open.pop() {
            let known = self.routines.known.get(&(instance, entry)).copied();
            let target = known.unwrap_or_else(|| self.routine(instance, entry));
            let step = &mut self.assembler().builder.program.instructions[call].step;
            if let Step::Call { target: own, .. } = step {
                *own = target;
            }
            if self.is_late() {
                self.routines.open.clear();
            }
            if self.builder.next() > LARGEST {
                let told = "the project has more instructions than any CPU holds";
                let fault = Fault::new(1, told).code(FaultCode::TooMany);
                self.assembler().faults.push((0, fault));
                self.routines.open.clear();
            }
        }
    }

    /// Refuses addresses that become numbers if the source of any code is missing: it may get such a number, from any
    /// variable, and write there.
    fn addresses_stay(&mut self) {
        let tree = self.tree;
        let begins_so = |one: &Variable| {
            let mut takes_address = false;
            let see = &mut |one: &Expr| takes_address |= matches!(one.kind, ExprKind::Address(_));
            one.initial.iter().for_each(|initial| initial.each(see));
            takes_address && !tree.types.is_reference(one.ty)
        };
        let program = &self.builder.program;
        let Some(missing) = program.missing_routines.iter().find(|one| one.stated) else { return };
        let place = self.address_as_number.or_else(|| {
            let begins = tree.variables.iter().any(begins_so);
            begins.then(|| program.instructions[missing.entry].place)
        });
        let Some(place) = place else { return };
        let told = format!(
            "an address becomes a number, and {} has no source: it is not known whether it writes there",
            missing.name
        );
        let help = "keep addresses in references, or give a substitute for the missing source";
        let fault = Fault::new(place.line, told).code(FaultCode::NotModelled).help(help);
        self.assembler().faults.push((place.file as usize, fault));
    }

    /// All variables that are declared with an address, in called instances and in others, and all addresses that the
    /// code uses directly.
    pub(super) fn located(&mut self) -> Vec<Located> {
        let tree = self.tree;
        let mut spots: BTreeMap<SpotKey, (Spot, &str)> = BTreeMap::new();
        for Instance { spot, .. } in self.instances.clone() {
            self.add_located(&spot, None, &mut spots);
        }
        for ((_, method), frame) in self.memory.frames.clone() {
            for &id in &tree.routine(method).variables {
                let local = self.local(&frame, method, id);
                local.iter().for_each(|local| self.add_located(local, Some(id), &mut spots));
            }
        }
        for (id, spot) in self.memory.globals.clone() {
            self.add_located(&spot, Some(id), &mut spots);
        }
        let direct = self.memory.addresses.iter();
        let direct = direct.map(|(id, spot)| (spot.clone(), tree.address(*id).text.as_str()));
        let all = spots.into_values().chain(direct);
        all.filter_map(|(spot, address)| Located::new(tree, &spot, address)).collect()
    }

    /// Adds a variable if it has an address, and all variables with an address in the instances that it contains.
    fn add_located(
        &mut self,
        spot: &Spot,
        id: Option<VarId>,
        found: &mut BTreeMap<SpotKey, (Spot, &'t str)>,
    ) {
        let tree = self.tree;
        if let Some(address) = id.and_then(|id| tree.variable(id).at.as_deref()) {
            found.insert(spot.key(), (spot.clone(), address));
        }
        let has_address = |of: &Typed| match of {
            Typed::Block(unit) => {
                tree.members(*unit).into_iter().any(|id| tree.variable(id).at.is_some())
            }
            _ => false,
        };
        if !tree.holds(spot.ty, &has_address) {
            return;
        }
        match tree.types.get(spot.ty) {
            Typed::Block(unit) => {
                for id in tree.members(*unit) {
                    let part = self.member(spot, *unit, id);
                    part.iter().for_each(|part| self.add_located(part, Some(id), found));
                }
            }
            Typed::Struct(id) => {
                for (at, (_, ty)) in tree.types.parts(*id).iter().enumerate() {
                    let part =
                        spot.tag.part_at(at).map(|tag| Spot { tag, ty: *ty, ..spot.clone() });
                    part.iter().for_each(|part| self.add_located(part, None, found));
                }
            }
            Typed::Array(dimensions, of) => {
                let mut tags = vec![spot.tag.clone()];
                for &(low, high) in dimensions {
                    let inner = |tag: Tag| (low..=high).filter_map(move |at| tag.element(at));
                    tags = tags.into_iter().flat_map(inner).collect();
                }
                for tag in tags {
                    self.add_located(&Spot { tag, ty: *of, ..spot.clone() }, None, found);
                }
            }
            _ => {}
        }
    }

    /// Adds the instruction that sets initial values in the first scan, and returns its index. Its writes are added
    /// when all writers are known. None if its flag cannot be placed.
    fn first_scan(&mut self) -> Option<usize> {
        let bool = scanbound_iec_tree::types::Elementary::Bool;
        let ty = self.tree.types.elementary(bool);
        let spot = self.placed(FIRST_SCAN, ty, 1).ok()?;
        self.at(1, "first values");
        let fires = scanbound_ir::Logic::cell(spot.tag.cell()?);
        Some(self.assembler().builder.add(None, Vec::new(), Step::Act { fires }))
    }

    /// If the user states the time of a missing body, adds a routine that takes this time and gives any value to
    /// everything that the code may write. Returns whether it did.
    pub(super) fn stands_in(&mut self, instance: usize, entry: Entry) -> bool {
        let tree = self.tree;
        let Some((routine, stated)) = self.stated_of(instance, entry) else { return false };
        self.file = tree.unit(routine.unit).file;
        self.at(routine.line, &stated.name);
        self.landing();
        let regions = self.all_it_writes(instance, entry, routine.line, stated);
        let effects = match regions {
            Ok(regions) => {
                let havoc = |region| {
                    let choice = self.assembler().builder.choice();
                    always(Write::Havoc(region, choice))
                };
                regions.into_iter().map(havoc).collect()
            }
            Err(fault) => {
                self.fault(fault);
                Vec::new()
            }
        };
        let begin = self.assembler().builder.add(None, effects, Step::Nothing);
        let why =
            format!("the results of {} may be any value: only its time is stated", stated.name);
        self.program().approximate(begin, why);
        self.takes_stated_time(begin, stated);
        self.assembler().builder.add(None, Vec::new(), Step::Return);
        true
    }

    /// Makes the instruction `entry` take the time that is stated for missing code.
    pub(super) fn takes_stated_time(&mut self, entry: usize, stated: &Stated) {
        let (name, time) = (normalized(&stated.name), stated.time);
        let absent = MissingRoutine { name, entry, time, stated: true, declared: true };
        self.program().missing_routines.push(absent);
    }

    /// The routine of a missing body and what the user states about it. None if the body exists, if nothing is stated
    /// about it, or if the routine is an action.
    pub(super) fn stated_of(
        &self,
        instance: usize,
        entry: Entry,
    ) -> Option<(&'t Routine, &'t Stated)> {
        let tree = self.tree;
        let own = self.instances[instance].unit;
        let from = match entry {
            Entry::Body => own,
            Entry::Routine(id) => match tree.routine(id).kind {
                RoutineKind::Action => return None,
                RoutineKind::Body => tree.routine(id).unit,
                RoutineKind::Method => {
                    let routine = tree.routine(id);
                    return Some((routine, routine.stated.as_ref()?));
                }
            },
        };
        let bodies = tree.lineage(from).into_iter().map(|unit| tree.unit(unit));
        let bodies = bodies.filter(|unit| unit.kind != PouKind::Program);
        let mut bodies = bodies.map(|unit| tree.routine(unit.body));
        let first = bodies.find(|body| !body.code.is_empty() || body.stated.is_some())?;
        Some((first, first.stated.as_ref()?))
    }

    pub(super) fn all_it_writes(
        &mut self,
        instance: usize,
        entry: Entry,
        line: u32,
        stated: &Stated,
    ) -> Result<Vec<Region>, Fault> {
        let mut variables = self.tree.members(self.instances[instance].unit);
        if let Entry::Routine(id) = entry {
            variables.extend(&self.tree.routine(id).variables);
        }
        if variables.iter().any(|&id| self.tree.has_reference(self.tree.variable(id).ty)) {
            let told = format!(
                "{} gets or contains references: it is not known what it writes through them",
                stated.name
            );
            let help = "give its source, or a substitute whose body has the same effects";
            return Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help));
        }
        let mut regions = self.instances[instance].spot.tag.regions();
        if let Entry::Routine(id) = entry
            && self.tree.routine(id).kind == RoutineKind::Method
        {
            regions.extend(self.frame(instance, id)?.tag.regions());
        }
        let at = Context { instance, frame: None };
        for place in &stated.writes {
            let place = place.as_ref().map_err(Clone::clone)?;
            regions.extend(self.root(&at, place.root, line)?.tag.regions());
        }
        Ok(regions)
    }

    /// Records a function, function block or method with an empty body, whose source is probably in another file.
    /// Nothing is recorded for a program. Nor is it recorded if the unit has other code, unless it is a method that has
    /// results.
    pub(super) fn note_bodiless(&mut self, instance: usize, entry: Entry) {
        let tree = self.tree;
        let own = self.instances[instance].unit;
        let (name, code, variables, has_result, kind, file, line) = match entry {
            Entry::Body => {
                let unit = tree.unit(own);
                let code = &tree.routine(unit.body).code;
                let (variables, result) = (&unit.variables, unit.result.is_some());
                (unit.name.clone(), code, variables, result, unit.kind, unit.file, unit.line)
            }
            Entry::Routine(id) if tree.routine(id).kind == RoutineKind::Method => {
                let routine = tree.routine(id);
                let name = format!("{}.{}", tree.unit(own).name, routine.name);
                let file = tree.unit(routine.unit).file;
                let result = routine.result.is_some();
                let kind = PouKind::Function;
                (name, &routine.code, &routine.variables, result, kind, file, routine.line)
            }
            Entry::Routine(_) => return,
        };
        if kind == PouKind::Program || !code.is_empty() {
            return;
        }
        let gives = |id: &_| matches!(tree.variable(*id).section, Section::Output | Section::InOut);
        let gives_something = has_result || variables.iter().any(gives);
        let has_code = |unit: &_| {
            let unit = tree.unit(*unit);
            let all = unit.methods.iter().chain(&unit.actions).chain([&unit.body]);
            { all }.any(|&one| !tree.routine(one).code.is_empty())
        };
        // A unit with other code was read completely. A method with results should still have code of its own.
        let is_whole =
            tree.lineage(own).iter().any(has_code) && (entry == Entry::Body || !gives_something);
        if is_whole {
            return;
        }
        let file = u32::try_from(file).unwrap_or(u32::MAX);
        let place = Location { file, line, step: None };
        let known = &mut self.program().without_body;
        if known.iter().all(|(own, _)| *own != name) {
            known.push((name, place));
        }
    }
}

/// Whether a variable may keep its value from scan to scan. The variables of methods do not.
fn is_lasting(owner: Owner) -> bool {
    !matches!(owner, Owner::Routine(_))
}

/// Completes a program with its main part, tasks, interrupts and files.
fn finish(
    mut program: Program,
    tree: &Tree,
    project: &Project,
    tasks: &[&Task],
    entries: &[usize],
    main: std::ops::Range<usize>,
    asked: &scanbound_front::Options<'_>,
) -> Program {
    program.mains = vec![main];
    program.interval = tasks.first().and_then(|task| known_task(tree, task).interval);
    if tasks.len() > 1 {
        program.tasks = tasks.iter().map(|task| known_task(tree, task)).collect();
        // If the tasks share one input image, a task that starts refreshes it while another one runs.
        program.volatile.extend(program.power_up.inputs.clone());
    }
    for (task, &entry) in program.tasks.iter().zip(entries).skip(1) {
        // Each other task is an interrupt, as often as stated. Unstated, it runs between scans only.
        let stated = asked.facts.interrupt(&task.name).filter(|_| !asked.uninterrupted);
        let (times, name) = (stated.unwrap_or(0), task.name.clone());
        let stated = stated.is_some();
        program.interrupts.push(scanbound_ir::Interrupt { name, entry, times, stated });
    }
    let all = program.instructions.len();
    let mut counts = vec![0; project.files.len()];
    for one in program.instructions.iter().filter(|one| one.timing.is_some()) {
        counts[one.place.file as usize] += 1;
    }
    let files =
        project.files.iter().zip(counts).enumerate().map(|(at, (name, count))| SourceFile {
            name: name.clone(),
            instructions: if at == 0 { 0..all } else { all..all },
            count,
        });
    program.files = files.collect();
    program
}

/// A task for the report, with its interval in picoseconds if it is positive.
fn known_task(tree: &Tree, task: &Task) -> scanbound_ir::Task {
    let interval = task.interval.and_then(|time| u64::try_from(time).ok()).filter(|&time| time > 0);
    let programs = task.programs.iter().flatten();
    scanbound_ir::Task {
        name: task.name.clone(),
        interval: interval.and_then(|time| time.checked_mul(1000)).map(Picos),
        priority: task.priority,
        programs: programs.map(|&at| tree.programs[at].name.clone()).collect(),
    }
}

/// The most instructions that are lowered. A program with more is a fault.
const LARGEST: usize = 4_000_000;

/// Converts faults to diagnostics, without duplicates, sorted by file and line.
fn told(project: &Project, faults: Vec<(usize, Fault)>) -> Vec<Diagnostic> {
    let name = |file: usize| project.files.get(file).map_or("", String::as_str);
    let mut seen = HashSet::new();
    let faults = faults.into_iter().filter(|fault| seen.insert(fault.clone()));
    let mut told: Vec<Diagnostic> = faults.map(|(file, fault)| fault.in_file(name(file))).collect();
    told.sort_by(|a, b| (&a.file, a.line).cmp(&(&b.file, b.line)));
    told
}

/// For each latched cell that calls pass as VAR_IN_OUT: the cells that are copied back to it, directly or through the
/// parameters of other calls.
fn lent(
    program: &Program,
    given_back: &[GivenBack],
    latched: &[Region],
) -> BTreeMap<Cell, BTreeSet<Cell>> {
    let mut copies: BTreeMap<Cell, BTreeSet<Cell>> = BTreeMap::new();
    let instructions = given_back.iter().flat_map(|(range, ..)| range.clone());
    for effect in instructions.flat_map(|at| &program.instructions[at].effects) {
        let copied: Option<(&[WordTarget], &[WordSource])> = match &effect.write {
            Write::Words(targets, Number::Words(sources)) => Some((targets, sources)),
            Write::Havoc(_, choice) => match program.kinds.get(choice) {
                Some(ChoiceKind::Exact(meaning)) => {
                    match (&meaning.inputs[..], &meaning.outputs[..]) {
                        ([OperationInput::Words(sources)], [Target::Words(targets)]) => {
                            Some((targets, sources))
                        }
                        _ => None,
                    }
                }
                _ => None,
            },
            _ => None,
        };
        for (target, source) in copied.into_iter().flat_map(|(to, from)| to.iter().zip(from)) {
            if let (WordTarget::Cell(own), WordSource::Cell(copy)) = (target, source) {
                copies.entry(*own).or_default().insert(*copy);
            }
        }
    }
    let reached = |own: Cell| {
        let (mut open, mut found) = (vec![own], BTreeSet::new());
        while let Some(cell) = open.pop() {
            let more = copies.get(&cell).into_iter().flatten().copied();
            open.extend(more.filter(|&copy| found.insert(copy)));
        }
        found
    };
    let is_latched = |cell: &&Cell| latched.iter().any(|region| region.contains(**cell));
    copies.keys().filter(is_latched).map(|&own| (own, reached(own))).collect()
}

/// Refuses calls with a VAR_IN_OUT argument that another task also writes. The argument is modelled as a copy, but on a
/// PLC it may change while the call runs.
fn changed_by_others(assembler: &mut Assembler, entries: &[usize], given_back: &[GivenBack]) {
    if entries.len() < 2 {
        return;
    }
    let program = &assembler.builder.program;
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
            let told = "a variable that is passed as VAR_IN_OUT is also written by another task: it may change \
                while the call runs, which is not modelled";
            let help = "copy it to a variable of the task before the call, and back after it";
            faults.push((*file, Fault::new(*line, told).code(FaultCode::NotModelled).help(help)));
        }
    }
    assembler.faults.extend(faults);
}

/// The names by which facts may refer to a file: its whole name, and its name without directories if that is unique.
pub(super) fn file_names(files: &[String], file: usize) -> [&str; 2] {
    let whole = files.get(file).map_or("", String::as_str);
    [whole, scanbound_ir::location_text::short_file_name(whole, files.iter().map(String::as_str))]
}

//! Charts as instructions: steps and stored actions are bits that nobody else knows.

use super::assembler::{Assembler, OpenEnd};
use super::control::{Before, Output, Whole};
use super::emit::{Emit, What};
use super::memory::{Memory, all, any, layout, memory, set};
use super::resolve::{Context, Found};
use super::statement::ENDS_CHART;
use super::turns;
use super::types::{Kind, Ty, lineage};
use super::value::Value;
use scanbound_base::code::Code;
use scanbound_base::facts::ActionOrder;
use scanbound_front::builder::always;
use scanbound_iec::ast::{Expr, Kind as Statements, Literal, Path, Statement};
use scanbound_iec::chart::{COMPUTED, Chart, Feed, Target};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, Pou, Section, same};
use scanbound_iec_tree::resolve::orders;
use scanbound_ir::{Cell, Logic, Region, Step, Tag, Write};
use std::collections::BTreeSet;

/// A Boolean variable that may stay as it is where nothing switches its action.
struct Kept {
    /// The instruction that says so.
    says: usize,
    cell: Cell,
    /// The instruction that writes it.
    writes: usize,
}

const DRAWN: &str = "controllers execute the blocks of a drawn condition in each scan, or where they evaluate the condition: either, and any result ([sfc] drawn_conditions states which)";

impl Emit<'_> {
    /// The memory of a chart of an instance.
    pub(super) fn chart_memory(&mut self, instance: usize, what: &What) -> Option<Tag> {
        if let Some(known) = self.charts.get(&(instance, what.clone())) {
            return Some(known.clone());
        }
        let (_, Body::Chart(chart)) = self.body(instance, what)? else { return None };
        let owner = &self.instances[instance].place.name;
        let name = match what {
            What::Body => owner.clone(),
            What::Action(action) | What::Method(action) | What::Inherited(_, action) => {
                format!("{owner}.{action}")
            }
        };
        let tag = self.hidden(&name, layout(chart))?;
        self.charts.insert((instance, what.clone()), tag.clone());
        let own = memory(chart, &tag)?;
        let is_read = |flag: &str| Self::part(&self.instances[instance].place, flag).is_some();
        let always_acts = !self.actions_first && !is_read("SFCInit");
        let mut invariants = super::invariant::of(chart, &own, always_acts, self.all_clear);
        if self.is_retained(instance) {
            // The power may fail in the midst of a scan, and the chart goes on with what stood there.
            invariants.clear();
        }
        let program = self.program();
        program.invariants.extend(invariants);
        program.charts.exclusions = program.invariants.len();
        let actions = own.actions.iter().map(|action| action.on);
        program.charts.active.extend(own.steps.iter().copied().chain(actions));
        Some(tag)
    }

    /// Puts a chart together.
    pub(super) fn chart(&mut self, at: &Context, what: &What, pou: &Pou, chart: &Chart) {
        let tag = self.chart_memory(at.instance, what);
        let Some(memory) = tag.and_then(|tag| memory(chart, &tag)) else {
            let fault = Fault::new(chart.line, "there is no room for the chart");
            return self.fault(fault);
        };
        let flag = |name: &str| {
            let part = Self::part(&self.instances[at.instance].place, name)?;
            part.tag.cell().filter(|_| matches!(part.ty, Ty::Bit))
        };
        let (halt, restart) = (flag("SFCInit"), flag("SFCReset"));
        self.at(chart.line, "SFC");
        let first = self.keep_bit(Logic::cell(memory.started).not());
        let begins = any([first.clone()]
            .into_iter()
            .chain(halt.into_iter().chain(restart).map(Logic::cell)));
        let begins = self.keep_bit(begins);
        self.times_go_on(&memory);
        let mut resets = vec![set(memory.started, Logic::Const(true))];
        for (cell, step) in memory.steps.iter().zip(&chart.steps) {
            resets.push(set(*cell, Logic::Const(step.initial)));
        }
        for action in &memory.actions {
            let own = action.inputs.iter().flat_map(|input| [input.was, input.stored, input.over]);
            let cells = own.chain([action.on, action.stored]);
            resets.extend(cells.map(|cell| set(cell, Logic::Const(false))));
        }
        // matiec looks at transitions in the first scan, too, and enters no step then. It takes actions as they are declared, and
        // has no charts that begin anew with every call, nor those of CODESYS and TwinCAT.
        let may_be_matiec = !self.actions_first
            && matches!(self.action_order, None | Some(ActionOrder::Declared))
            && !self.begun_anew.contains(&at.instance);
        let entered = match may_be_matiec {
            true => self.differs("initial steps are not entered in the first scan"),
            false => Logic::Const(false),
        };
        let entered = all([first.clone(), entered]);
        for (&cell, step) in memory.were.iter().zip(&chart.steps) {
            let was = if step.initial { entered.clone() } else { Logic::Const(false) };
            resets.push(set(cell, was));
        }
        self.write_if(begins.clone(), resets, None);
        self.times_begin(&memory, &begins);
        let stop = halt.map(|halt| self.jump(Logic::cell(halt), None));
        if self.actions_first {
            self.act(at, pou, chart, &memory);
        }
        let looks = match may_be_matiec {
            true => all([first, self.differs("the first scan looks at transitions")]),
            false => Logic::Const(false),
        };
        let skip = self.jump(all([begins, looks.not()]), None);
        self.evolve(at, chart, &memory);
        self.land(skip);
        self.landing();
        if !self.actions_first {
            self.act(at, pou, chart, &memory);
        }
        if let Some(stop) = stop {
            self.land(stop);
            self.landing();
        }
    }

    fn evolve(&mut self, at: &Context, chart: &Chart, memory: &Memory) {
        let none = memory.clears.iter().map(|&cell| set(cell, Logic::Const(false))).collect();
        self.write(none);
        let mut entering = vec![Vec::new(); chart.steps.len()];
        let mut leaving: Vec<Vec<usize>> = vec![Vec::new(); chart.steps.len()];
        for (number, one) in chart.transitions.iter().enumerate() {
            let text = format!("TRANSITION {}", chart.transition_name(number));
            self.at(one.line, &text);
            let from = self.builder.next();
            let before = one.from.iter().flat_map(|&step| &leaving[step]);
            let before: BTreeSet<usize> = before.copied().collect();
            let rivals = before.into_iter().filter(|&other| {
                let other = &chart.transitions[other];
                let has_priorities = one.has_priority && other.has_priority;
                has_priorities || !self.all_clear
            });
            let steps = one.from.iter().map(|&step| Logic::cell(memory.steps[step]));
            let rivals = rivals.map(|other| Logic::cell(memory.clears[other]).not());
            let enabled = all(steps.chain(rivals));
            let enabled = self.keep_bit(enabled);
            one.from.iter().for_each(|&step| leaving[step].push(number));
            one.to.iter().for_each(|&step| entering[step].push(number));
            let key = Assembler::key(&["TRANSITION"], "nothing");
            self.builder.add(Some(key), Vec::new(), Step::Act { fires: enabled.clone() });
            let skip = self.jump(enabled.not(), None);
            match self.bit(at, &one.condition, one.line) {
                Ok(condition) => {
                    let effects = vec![always(set(memory.clears[number], condition.clone()))];
                    let key = Assembler::key(&["CLEAR"], "nothing");
                    self.builder.add(Some(key), effects, Step::Act { fires: condition });
                    if one.has_priority && number + 1 < chart.transitions.len() {
                        self.flags_end_early(memory, &one.from, memory.clears[number]);
                    }
                }
                Err(fault) => {
                    let place = format!(
                        "{}, {}",
                        self.instances[at.instance].place.name,
                        chart.transition_name(number)
                    );
                    let fault = fault.within(&place);
                    self.fault(fault);
                }
            }
            self.land(skip);
            self.landing();
            self.counted_part(from, one.line, &text, 1);
        }
        let clear = |which: &[usize]| any(which.iter().map(|&at| Logic::cell(memory.clears[at])));
        self.times_of_entered(chart, memory);
        let moves = memory.steps.iter().enumerate().map(|(step, &cell)| {
            let (entered, left) = (clear(&entering[step]), clear(&leaving[step]));
            set(cell, any([entered, all([Logic::cell(cell), left.not()])]))
        });
        let moves = moves.collect();
        self.write(moves);
        self.times_end(memory);
    }

    /// On some controllers the steps of a transition that clears by its priority are off at once, for all conditions behind it.
    fn flags_end_early(&mut self, memory: &Memory, from: &[usize], clears: Cell) {
        if self.actions_first {
            return;
        }
        let early = self.differs("a transition with a priority ends its steps at once");
        let stays = self.keep_bit(all([Logic::cell(clears), early]).not());
        let flags = from.iter().map(|&step| memory.steps[step]);
        let ends = flags.map(|flag| set(flag, all([Logic::cell(flag), stays.clone()])));
        self.write(ends.collect());
    }

    /// Steps, then what they carry out as they end, as they begin and while they are active, then actions.
    fn act(&mut self, at: &Context, pou: &Pou, chart: &Chart, memory: &Memory) {
        for (step, one) in chart.steps.iter().enumerate() {
            self.at(one.line, &format!("STEP {}", one.name));
            let key = Assembler::key(&["STEP"], "nothing");
            let fires = Logic::cell(memory.steps[step]);
            self.builder.add(Some(key), Vec::new(), Step::Act { fires });
        }
        // The power may fail in the midst of a scan: then the markings that are kept may be any.
        let is_retained = self.is_retained(at.instance);
        let hooks: [fn(&scanbound_iec::chart::Step) -> &Option<Path>; 3] =
            [|step| &step.exit, |step| &step.entry, |step| &step.active];
        for (number, hook) in hooks.into_iter().enumerate() {
            let own: Vec<usize> =
                (0..chart.steps.len()).filter(|&step| hook(&chart.steps[step]).is_some()).collect();
            let never = vec![Logic::Const(false); own.len()];
            let rounds = turns::of_steps(chart, own.len(), self.all_clear || is_retained);
            turns::in_turns(self, &rounds, &never, &mut |emit, which| {
                let step = &chart.steps[own[which]];
                let Some(path) = hook(step) else { return };
                let [now, was] =
                    [memory.steps[own[which]], memory.were[own[which]]].map(Logic::cell);
                let fires = match number {
                    0 => all([was, now.not()]),
                    1 => all([now, was.not()]),
                    _ => now,
                };
                let text = format!("STEP {}", step.name);
                emit.at(step.line, &text);
                let from = emit.builder.next();
                emit.carried_out(at, path, fires, step.line);
                emit.counted_part(from, step.line, &text, 1);
            });
        }
        for one in &chart.macros {
            // A macro step has a flag and a time of its own to keep up.
            self.at(one.line, &format!("STEP {}", one.name));
            let fires = memory.active(&one.steps);
            let key = Assembler::key(&["STEP"], "nothing");
            self.builder.add(Some(key), Vec::new(), Step::Act { fires });
        }
        let names = chart.actions();
        let mut outputs = Vec::new();
        let whole = Whole {
            reset_only_stored: self.differs("R holds off only what is stored"),
            no_final_scan: self.differs("actions have no final scan"),
        };
        for (name, action) in names.iter().zip(&memory.actions) {
            let line = chart.blocks_of(name).next().map_or(chart.line, |(_, block)| block.line);
            let text = format!("ACTION {name}");
            self.at(line, &text);
            let from = self.builder.next();
            let at_once: Vec<Logic> =
                action.feeds.iter().map(|feed| self.at_once(at, feed, line)).collect();
            outputs.push(self.control(memory, action, &whole, &at_once));
            self.counted_part(from, line, &text, chart.blocks_of(name).count());
        }
        let keep = memory.were.iter().zip(&memory.steps);
        let keep = keep.map(|(&was, &now)| set(was, Logic::cell(now))).collect();
        self.write(keep);
        let rounds = turns::rounds(&orders(chart, pou), self.action_order);
        let ended: Vec<Logic> = outputs.iter().map(|output| output.on.clone().not()).collect();
        let mut variables: Vec<Vec<Kept>> = names.iter().map(|_| Vec::new()).collect();
        turns::in_turns(self, &rounds, &ended, &mut |emit, number| {
            let Some((_, block)) = chart.blocks_of(&names[number]).next() else { return };
            emit.at(block.line, &names[number]);
            let output = &outputs[number];
            match &block.target {
                Target::Inline(_, body) => emit.inline(at, body, output.runs.clone(), block.line),
                Target::Path(path) => {
                    variables[number].extend(emit.controlled(at, pou, path, output, block.line));
                }
            }
        });
        for all in variables {
            let own: Vec<usize> = all.iter().map(|one| one.writes).collect();
            for Kept { says, cell, .. } in all {
                self.open_ends.push(OpenEnd::Variable { at: says, cell, own: own.clone() });
            }
        }
    }

    /// Carries out what stands in an action block itself.
    fn inline(&mut self, at: &Context, body: &Body, runs: Logic, line: u32) {
        let skip = self.jump(runs.not(), Some(Assembler::key(&["JMP"], "jump")));
        match body {
            Body::Code(_, statements) => {
                let around = self.enter(body);
                self.in_block(at, statements);
                self.leave(around);
            }
            Body::Unread(_, fault) => self.fault(fault.clone()),
            Body::Chart(_) => {
                self.fault(Fault::new(line, "a chart within an action block is not followed"));
            }
        }
        self.land(skip);
        self.landing();
    }

    /// An action of the unit, or of an instance, or a Boolean variable.
    fn controlled(
        &mut self,
        at: &Context,
        pou: &Pou,
        path: &Path,
        output: &Output,
        line: u32,
    ) -> Option<Kept> {
        let Output { on, runs, may_stay } = output.clone();
        let is_action =
            path.as_name().is_some_and(|name| pou.actions.iter().any(|one| same(&one.name, name)));
        if !is_action
            && let Ok(found @ (Found::Place(_) | Found::WordBit(..) | Found::Element(_))) =
                self.find(at, path, line)
        {
            let before = match &found {
                Found::Place(place) if matches!(place.ty, Ty::Bit) => {
                    place.tag.cell().map_or(Before::Any, Before::Cell)
                }
                Found::WordBit(cell, bit, _) => Before::Bit(*cell, *bit),
                _ => Before::Any,
            };
            let (on, open) = self.held(&before, on, may_stay);
            let effects = match self.writes(found, Value::Bit(on), line) {
                Ok(writes) => writes.into_iter().map(always).collect(),
                Err(fault) => {
                    self.fault(fault);
                    return None;
                }
            };
            let key = Some(Assembler::key(&["ST"], "move"));
            let writes = self.builder.add(key, effects, Step::Nothing);
            let only_here = self.begins_off(at, path) && !self.others_write;
            let (says, cell) = open.filter(|_| only_here)?;
            return Some(Kept { says, cell, writes });
        }
        let name = path.as_name().map(|name| What::Action(name.to_ascii_uppercase()));
        let returned = name.and_then(|what| self.returned(at.instance, &what));
        let Some(returned) = returned else {
            let skip = self.may_be_elsewhere(pou, path);
            self.carried_out(at, path, runs, line);
            if let Some(skip) = skip {
                self.land(skip);
                self.landing();
                self.open_computed(at, pou, line);
            }
            return None;
        };
        self.write(vec![set(returned, Logic::Const(false))]);
        self.carried_out(at, path, runs, line);
        let whole = self.differs(ENDS_CHART);
        let goes_on = self.jump(all([Logic::cell(returned), whole]).not(), None);
        self.builder.add(None, Vec::new(), Step::Return);
        self.land(goes_on);
        self.landing();
        None
    }

    /// A jump over the action that executes the blocks of drawn conditions, unless the user states that it does so in each scan:
    /// other controllers execute them where they evaluate the condition, and no run may rest on what they take here.
    fn may_be_elsewhere(&mut self, pou: &Pou, path: &Path) -> Option<usize> {
        let is_drawn = matches!(&pou.body, Body::Chart(chart) if chart.span.is_some());
        if !is_drawn || self.drawn_last_scan || path.as_name() != Some(COMPUTED) {
            return None;
        }
        let elsewhere = self.any_bit(DRAWN);
        Some(self.jump(elsewhere, None))
    }

    /// Lets what the blocks of drawn conditions give be any value.
    fn open_computed(&mut self, at: &Context, pou: &Pou, line: u32) {
        let own = pou.actions.iter().find(|one| one.name == COMPUTED);
        let Some(Body::Code(_, statements)) = own.map(|one| &one.body) else { return };
        let choice = self.builder.choice();
        let mut any = Vec::new();
        for one in statements {
            let (Statements::Assign(target, _)
            | Statements::Call(target, _)
            | Statements::CallIf(_, target, _)) = &one.kind
            else {
                continue;
            };
            let Ok(Found::Place(place)) = self.find(at, target, line) else { continue };
            if matches!(place.ty, Ty::Block(..)) {
                let what = format!(
                    "{}: controllers execute a function block in a drawn condition in each scan, or where they evaluate the condition",
                    place.name
                );
                let help = "state [sfc] drawn_conditions = \"last-scan\" for the first (Beremiz, OpenPLC), or call it in an action";
                let fault = Fault::new(line, what).code(Code::NotModelled).help(help);
                self.fault(fault);
            }
            // What a timer remembers is not read by others.
            let outputs = ["Q", "ET"].map(|name| Self::part(&place, name)).into_iter().flatten();
            let regions: Vec<Region> = match place.ty {
                Ty::Standard("TON" | "TOF" | "TP", _) => {
                    outputs.flat_map(|part| part.tag.regions()).collect()
                }
                _ => place.tag.regions(),
            };
            any.extend(regions.into_iter().map(|region| Write::Havoc(region, choice)));
        }
        let at = self.write(any);
        self.program().approximate(at, DRAWN);
    }

    /// Whether a variable of the unit, or a global one, begins with FALSE.
    fn begins_off(&self, at: &Context, path: &Path) -> bool {
        let Some(name) = path.as_name() else { return false };
        let lineage = lineage(self.project, self.instances[at.instance].pou);
        let own = lineage.into_iter().flat_map(|pou| &pou.variables);
        let own = own.filter(|one| one.section != Section::External);
        let globals = self.project.globals.iter().flat_map(|(_, all)| all);
        let mut all = own.chain(globals).filter(|one| same(&one.name, name));
        all.all(|one| one.initial.as_ref().is_none_or(|initial| initial.is(false)))
    }

    /// Whether a timed input's time is 0 or less.
    fn at_once(&mut self, at: &Context, feed: &Feed, line: u32) -> Logic {
        let Some(time) = &feed.time else { return Logic::Const(feed.qualifier.is_timed()) };
        if let Expr::Literal(Literal::Time(time)) = time {
            return Logic::Const(*time <= 0);
        }
        match self.number(at, time, Kind::Time, line) {
            Ok(number) => self.is_no_time(number),
            Err(fault) => {
                self.fault(fault);
                Logic::Const(false)
            }
        }
    }

    /// Calls an action where a condition holds.
    fn carried_out(&mut self, at: &Context, path: &Path, fires: Logic, line: u32) {
        let skip = self.jump(fires.not(), Some(Assembler::key(&["JMP"], "jump")));
        let call = Statement { line, kind: Statements::Call(path.clone(), Vec::new()) };
        // It is counted with the action's control.
        let around = self.leave_out();
        self.inner(at, std::slice::from_ref(&call));
        self.leave(around);
        self.land(skip);
        self.landing();
    }
}

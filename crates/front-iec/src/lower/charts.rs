//! Lowers charts to instructions: steps and stored actions are bits that only the chart accesses.

use super::Lower;
use super::spots::Context;
use super::statements::JumpTargets;
use crate::assembler::Assembler;
use crate::assembler::control::{InputTime, Whole};
use crate::assembler::memory::{Memory, all, any, layout, memory, set};
use crate::assembler::numbers::read;
use crate::assembler::types::{Kind, Ty};
use crate::assembler::value::Value;
use crate::assembler::{invariant, turns};
use scanbound_base::code::Code as FaultCode;
use scanbound_base::facts::ActionOrder;
use scanbound_front::builder::always;
use scanbound_iec::PouKind;
use scanbound_iec::chart::{Chart as Written, Qualifier, Transition};
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::accesses::{self, Accesses};
use scanbound_iec_tree::charts::{Action, ActionBody, Chart, Hooks, StepFlag};
use scanbound_iec_tree::code::{Call, Place};
use scanbound_iec_tree::declarations::{Code, RoutineId, RoutineKind};
use scanbound_iec_tree::tree::{Expr, ExprKind, Statement};
use scanbound_iec_tree::types::time_in_units;
use scanbound_ir::{Cell, Logic, Step, Tag, Write};
use std::collections::BTreeSet;
use std::rc::Rc;

/// Text of a reading: how matiec differs when a chart begins.
const NOT_ENTERED: &str = "initial steps are not entered in the first scan";

/// Text of a reading: in matiec, the time of an initial step counts from the start of the controller's clock.
const RUNS_EARLY: &str = "the times of initial steps run before their chart is first executed";

/// Text of a reading: whether the flags of CODESYS and TwinCAT have an effect.
const FLAGS_CONTROL: &str = "SFCInit and SFCReset, if declared, control the chart";

/// Text of a reading: which conditions CODESYS and TwinCAT evaluate.
const EVALUATES_ALL: &str = "the conditions of all transitions are evaluated in each scan";

/// Text of a reading: whether the body of an action that ends is executed once more.
const NO_FINAL_SCAN: &str = "actions have no final scan";

/// Text of a reading: what a restart of a chart does (CODESYS, TwinCAT).
const RESTART_ENDS: &str =
    "SFCInit and SFCReset execute exit actions and the final scans of actions";

/// Text of a reading: what a restart of a chart leaves as it is (CODESYS, TwinCAT).
const RESTART_KEEPS: &str = "SFCInit and SFCReset leave stored actions stored";

/// Text of a reading: in matiec, conditions see what transitions with priorities before them have cleared.
const CLEARS_AT_ONCE: &str = "a transition with a priority clears its step flags at once";

/// The chart that is being lowered.
pub(super) struct Own<'c> {
    pub(super) at: &'c Context,
    /// The routine whose code is this chart.
    pub(super) id: RoutineId,
    pub(super) chart: &'c Chart,
    pub(super) written: &'c Written,
    pub(super) memory: Rc<Memory>,
}

impl<'t> Lower<'t> {
    /// The state memory of the chart of a routine in an instance, which is created if it is new. None if the routine is
    /// not a chart, or if there is no room.
    pub(super) fn chart_memory(&mut self, instance: usize, id: RoutineId) -> Option<Rc<Memory>> {
        if let Some(known) = self.charts.memories.get(&(instance, id)) {
            return Some(known.clone());
        }
        let Code::Chart(own) = &self.tree.routine(id).code else { return None };
        let chart = &own.written;
        let tag = self.chart_tag(instance, id, chart)?;
        let memory = Rc::new(memory(chart, &tag)?);
        self.charts.memories.insert((instance, id), memory.clone());
        // A retained chart has no invariants: the power may fail within a scan, and the chart continues with the state
        // at that moment.
        let invariants = match self.is_retained(instance) {
            true => Vec::new(),
            false => {
                let always_acts = own.halt.is_none();
                let restarts = own.halt.is_some() || own.restart.is_some();
                let may_restart =
                    restarts && stores_actions(chart) && !self.never_differs(RESTART_KEEPS);
                let options = &self.options.charts;
                let net = options.competing.net(chart);
                let mut found = invariant::of(chart, &memory, (always_acts, may_restart), &net);
                if options.actions_first {
                    let all_clear = options.competing.may_all_clear();
                    found.extend(invariant::of_transitions(chart, &memory, all_clear));
                }
                found
            }
        };
        let program = self.program();
        program.invariants.extend(invariants);
        program.charts.exclusions = program.invariants.len();
        let actions = memory.actions.iter().map(|action| action.on);
        program.charts.active.extend(memory.steps.iter().copied().chain(actions));
        Some(memory)
    }

    fn chart_tag(&mut self, instance: usize, id: RoutineId, chart: &Written) -> Option<Tag> {
        let tree = self.tree;
        let owner = &self.instances[instance];
        let routine = tree.routine(id);
        let is_nearest = match routine.kind {
            RoutineKind::Body => self.body_in(owner.unit) == Some(id),
            _ => tree.dispatched(owner.unit, id) == id,
        };
        let unit = &tree.unit(routine.unit).name;
        let name = match (routine.kind, is_nearest) {
            (RoutineKind::Body, true) => owner.spot.name.clone(),
            (RoutineKind::Body, false) => format!("{}.{unit}", owner.spot.name),
            (_, true) => format!("{}.{}", owner.spot.name, routine.name),
            (_, false) => format!("{}.{unit}::{}", owner.spot.name, routine.name),
        };
        self.hidden(&name, layout(chart))
    }

    /// Lowers a read of a step flag (`STEP.X`) or of a step time (`STEP.T`).
    pub(super) fn step_flag(
        &mut self,
        at: &Context,
        flag: &StepFlag,
        line: u32,
    ) -> Result<Value, Fault> {
        let instance = self.instance_of(at, &flag.owner, line)?;
        self.is_one_chart(instance, flag.chart, line)?;
        let memory = self.chart_memory(instance, flag.chart).ok_or_else(|| no_room(line))?;
        let time = &memory.times[flag.step];
        self.cost(&["LD"], "contact");
        if flag.is_time {
            self.times_read.insert(time.cell);
            return Ok(read(time.cell, &Ty::Number(Kind::Time)));
        }
        let active = match time.steps[..] {
            [step] => Logic::cell(memory.steps[step]),
            _ => memory.active(&time.steps),
        };
        if !time.initial {
            return Ok(Value::Bit(active));
        }
        let early = self.differs("initial steps are active before their chart is first executed");
        let early = all([Logic::cell(memory.started).not(), early]);
        Ok(Value::Bit(any([active, early])))
    }

    /// Refuses a step flag or time of a chart that the instance replaces by another chart, which may have a step of the
    /// same name.
    fn is_one_chart(&self, instance: usize, chart: RoutineId, line: u32) -> Result<(), Fault> {
        let tree = self.tree;
        let unit = self.instances[instance].unit;
        let nearest = match tree.routine(chart).kind {
            RoutineKind::Body => self.body_in(unit).unwrap_or(chart),
            _ => tree.dispatched(unit, chart),
        };
        if nearest == chart || !matches!(tree.routine(nearest).code, Code::Chart(_)) {
            return Ok(());
        }
        let what = format!(
            "{} replaces the chart of its base: it is not known which of the two charts has the step",
            self.instances[instance].spot.name
        );
        let help = "read the step flag within its own chart, and assign it to a variable";
        Err(Fault::new(line, what).code(FaultCode::NotModelled).help(help))
    }

    /// Lowers the chart of a routine.
    pub(super) fn chart(&mut self, at: &Context, id: RoutineId, chart: &Chart) {
        let written = &chart.written;
        let Some(memory) = self.chart_memory(at.instance, id) else {
            return self.fault(no_room(written.line));
        };
        let routine = self.tree.routine(id);
        let keeps_steps = routine.kind != RoutineKind::Method
            && self.tree.unit(routine.unit).kind != PouKind::Function;
        if let Err(fault) = refuse_unsupported(chart, written, keeps_steps) {
            let fault = fault.within(&self.instances[at.instance].spot.name);
            return self.fault(fault);
        }
        let own = Own { at, id, chart, written, memory };
        let flag = |lower: &mut Self, id| {
            let spot = lower.variable(at, id).ok()?;
            spot.tag.cell()
        };
        let halt = chart.halt.and_then(|id| flag(self, id)).map(Logic::cell);
        let restart = chart.restart.and_then(|id| flag(self, id)).map(Logic::cell);
        // Whether declared flags have an effect is a setting.
        let has_flags = halt.is_some() || restart.is_some();
        let known = written.settings.flags_control.then_some(true);
        let are_used = has_flags.then(|| self.differs_unless_known(FLAGS_CONTROL, known));
        let used = |flag: Logic| all([flag].into_iter().chain(are_used.clone()));
        let (halt, restart) = (halt.map(&used), restart.map(&used));
        self.at(written.line, "SFC");
        let first = self.keep_bit(Logic::cell(own.memory.started).not());
        let begins =
            any([first.clone()].into_iter().chain(halt.clone().into_iter().chain(restart)));
        let begins = self.keep_bit(begins);
        let actions_first = self.options.charts.actions_first;
        if actions_first {
            // On CODESYS and TwinCAT, step flags change where the next execution of the chart begins. If RETURN ends
            // the chart before its transitions are evaluated, none of them clears then.
            self.change_steps(&own);
            self.clear_none(&own);
        }
        self.times_go_on(&own.memory);
        // matiec enters no step in the first scan. It executes actions in the order of their declarations, and its
        // projects are not files of CODESYS or TwinCAT.
        let may_be_matiec = !actions_first
            && matches!(self.options.charts.action_order, None | Some(ActionOrder::Declared));
        self.begin_chart(&own, &begins, &first, may_be_matiec);
        // It is not documented whether stored actions are executed while SFCInit is TRUE.
        let goes_on = match halt.is_some() && stores_actions(written) {
            true => self.left_open(),
            false => Logic::Const(false),
        };
        let stop = halt.map(|halt| self.jump(all([halt, goes_on.not()]), None));
        if actions_first {
            self.act(&own, &first, may_be_matiec);
        }
        // Matiec, CODESYS and TwinCAT evaluate transitions in the first scan, and perhaps where SFCReset restarts the
        // chart.
        let may_look = match may_be_matiec || actions_first {
            true => self.differs("transitions are evaluated in the first scan"),
            false => Logic::Const(false),
        };
        let looks = if actions_first { may_look } else { all([first.clone(), may_look]) };
        let skip = self.jump(all([begins, looks.not()]), None);
        self.evaluate_transitions(&own);
        if !actions_first {
            self.change_steps(&own);
        }
        self.land(skip);
        self.landing();
        if !actions_first {
            self.act(&own, &first, may_be_matiec);
        }
        if let Some(stop) = stop {
            self.land(stop);
            self.landing();
        }
    }

    /// Resets the state of a chart to its beginning where `begins` is true. `first`: whether this is the first scan.
    fn begin_chart(&mut self, own: &Own<'_>, begins: &Logic, first: &Logic, may_be_matiec: bool) {
        let memory = &own.memory;
        let mut resets = vec![set(memory.started, Logic::Const(true))];
        for (cell, step) in memory.steps.iter().zip(&own.written.steps) {
            resets.push(set(*cell, Logic::Const(step.initial)));
        }
        resets.extend(memory.clears.iter().map(|&cell| set(cell, Logic::Const(false))));
        // It is not documented whether a restart executes what the end of a step does, and whether stored actions stay
        // stored.
        let restarts = own.chart.halt.is_some() || own.chart.restart.is_some();
        let mut unless_first = |may_differ: bool, reading| match may_differ {
            true => all([first.clone().not(), self.differs(reading)]),
            false => Logic::Const(false),
        };
        let ends = unless_first(restarts, RESTART_ENDS);
        let keeps = unless_first(restarts && stores_actions(own.written), RESTART_KEEPS);
        let kept = |cell: Cell, only: &Logic| set(cell, all([Logic::cell(cell), only.clone()]));
        for action in &memory.actions {
            let goes_on = all([keeps.clone(), action.is_on_by_store()]);
            resets.push(kept(action.on, &any([ends.clone(), goes_on])));
            resets.push(kept(action.stored, &keeps));
            for (feed, input) in action.feeds.iter().zip(&action.inputs) {
                // What is over of DS is the time of its step.
                let (is_stored, is_over) = match feed.qualifier {
                    Qualifier::Sd | Qualifier::Sl => (&keeps, &keeps),
                    Qualifier::Ds => (&keeps, &Logic::Const(false)),
                    _ => (&Logic::Const(false), &Logic::Const(false)),
                };
                resets.extend([kept(input.stored, is_stored), kept(input.over, is_over)]);
                resets.push(kept(input.was, &ends));
            }
        }
        let entered = match may_be_matiec {
            true => self.differs(NOT_ENTERED),
            false => Logic::Const(false),
        };
        let entered = all([first.clone(), entered]);
        for (&cell, step) in memory.were.iter().zip(&own.written.steps) {
            resets.push(if step.initial { set(cell, entered.clone()) } else { kept(cell, &ends) });
        }
        // A pulse occurs only where a step is entered or left.
        for action in &memory.actions {
            let pulses = action.feeds.iter().zip(&action.inputs).filter(|(feed, _)| {
                matches!(feed.qualifier, Qualifier::P | Qualifier::P1 | Qualifier::P0)
                    && feed.steps.iter().any(|&step| own.written.steps[step].initial)
            });
            resets.extend(pulses.map(|(_, input)| set(input.was, entered.clone())));
        }
        self.write_if(begins.clone(), resets, None);
        self.times_begin(memory, begins);
        if may_be_matiec {
            let early = self.differs(RUNS_EARLY);
            let early = all([first.clone(), early]);
            self.times_run_early(memory, &early, &entered_again(own.written));
        }
    }

    /// Evaluates the transitions: which of them clear.
    fn evaluate_transitions(&mut self, own: &Own<'_>) {
        let (chart, memory) = (own.written, &own.memory);
        self.clear_none(own);
        let mut leaving: Vec<Vec<usize>> = vec![Vec::new(); chart.steps.len()];
        let early = self.flags_before_priorities(own);
        let mut ended: Option<Vec<(Cell, Logic, Logic)>> = None;
        for (number, one) in chart.transitions.iter().enumerate() {
            if self.is_late() {
                return;
            }
            if !one.has_priority() {
                // Those with priorities come first here.
                let ended = ended.get_or_insert_with(|| {
                    let gone = |(cell, flag): &(Cell, Logic)| {
                        let gone = all([flag.clone(), Logic::cell(*cell).not()]);
                        (*cell, flag.clone(), self.keep_bit(gone))
                    };
                    early.iter().map(gone).collect()
                });
                self.flags_end_in_any_order(own, number, ended);
            }
            let restored = self.tied_flags_end_in_any_order(own, number, &early);
            let text = format!("TRANSITION {}", chart.transition_name(number));
            self.at(one.line, &text);
            let from = self.builder.next();
            let before = one.from.iter().flat_map(|&step| &leaving[step]);
            let before: BTreeSet<usize> = before.copied().collect();
            let competing = self.options.charts.competing;
            let rivals = self.assembler().rivals(competing, chart, memory, number, &before);
            let steps = one.from.iter().map(|&step| Logic::cell(memory.steps[step]));
            let enabled = all(steps.chain(rivals));
            let enabled = self.keep_bit(enabled);
            one.from.iter().for_each(|&step| leaving[step].push(number));
            let key = Assembler::key(&["TRANSITION"], "nothing");
            self.act_where(key, Vec::new(), enabled.clone());
            let evaluated = match self.options.charts.actions_first {
                true => {
                    // A condition that calls something may do more than take time.
                    let may_do_more = asks_flags(&own.chart.conditions[number]);
                    let known = chart.settings.evaluates_all.filter(|all| !all || !may_do_more);
                    let evaluates_all = self.differs_unless_known(EVALUATES_ALL, known);
                    self.keep_bit(any([enabled.clone(), evaluates_all]))
                }
                false => enabled.clone(),
            };
            let skip = self.jump(evaluated.not(), None);
            match self.bit(own.at, &own.chart.conditions[number]) {
                Ok(condition) => {
                    let condition = all([enabled, condition]);
                    let effects = vec![always(set(memory.clears[number], condition.clone()))];
                    let key = Assembler::key(&["CLEAR"], "nothing");
                    self.act_where(key, effects, condition);
                    if one.has_priority() && number + 1 < chart.transitions.len() {
                        self.flags_end_early(memory, &one.from, memory.clears[number]);
                    }
                }
                Err(fault) => {
                    let owner = &self.instances[own.at.instance].spot.name;
                    let fault =
                        fault.within(&format!("{owner}, {}", chart.transition_name(number)));
                    self.fault(fault);
                }
            }
            self.land(skip);
            self.landing();
            if !restored.is_empty() {
                self.write(restored);
            }
            self.counted_part(from, one.line, &text, 1);
        }
    }

    /// Records that no transition clears.
    fn clear_none(&mut self, own: &Own<'_>) {
        let none = own.memory.clears.iter().map(|&cell| set(cell, Logic::Const(false))).collect();
        self.write(none);
    }

    /// Deactivates the steps before the transitions that clear, and activates those after them.
    fn change_steps(&mut self, own: &Own<'_>) {
        let (chart, memory) = (own.written, &own.memory);
        let clears = |is_one: &dyn Fn(&Transition) -> bool| {
            let some = chart.transitions.iter().zip(&memory.clears).filter(|(one, _)| is_one(one));
            any(some.map(|(_, &cell)| Logic::cell(cell)))
        };
        self.times_of_entered(chart, memory);
        let moves = memory.steps.iter().enumerate().map(|(step, &cell)| {
            let entered = clears(&|one| one.to.contains(&step));
            let left = clears(&|one| one.from.contains(&step));
            set(cell, any([entered, all([Logic::cell(cell), left.not()])]))
        });
        let moves = moves.collect();
        self.write(moves);
        self.times_end(memory);
    }

    fn act_where(
        &mut self,
        key: scanbound_ir::TimingKey,
        effects: Vec<scanbound_ir::Effect>,
        fires: Logic,
    ) {
        self.assembler().builder.add(Some(key), effects, Step::Act { fires });
    }

    /// The flags, as they are now, of the steps that transitions with priorities end at once, if others may come before
    /// them on such controllers (matiec): transitions without a priority or, in a drawn chart, with the same priority.
    fn flags_before_priorities(&mut self, own: &Own<'_>) -> Vec<(Cell, Logic)> {
        let all = &own.written.transitions;
        let is_mixed = all.iter().any(|one| !one.has_priority());
        let may_be_tied = own.written.span.is_some() && own.chart.conditions.iter().any(asks_flags);
        if self.options.charts.actions_first || !(is_mixed || may_be_tied) {
            return Vec::new();
        }
        let ended = all.iter().filter(|one| one.has_priority()).flat_map(|one| &one.from);
        let ended: BTreeSet<usize> = ended.copied().collect();
        let cells = ended.into_iter().map(|step| own.memory.steps[step]);
        cells.map(|cell| (cell, self.keep_bit(Logic::cell(cell)))).collect()
    }

    /// A transition without a priority may come before those with priorities, or after them: it may see the flags of
    /// the steps that these ended, or not. `ended`: the cell of each such flag, what it was, and whether it has ended.
    fn flags_end_in_any_order(
        &mut self,
        own: &Own<'_>,
        number: usize,
        ended: &[(Cell, Logic, Logic)],
    ) {
        let asks = asks_flags(&own.chart.conditions[number]);
        let from = &own.written.transitions[number].from;
        for (cell, flag, gone) in ended {
            if asks || from.iter().any(|&step| own.memory.steps[step] == *cell) {
                let is_after = self.left_open();
                let off = all([gone.clone(), is_after]).not();
                self.write(vec![set(*cell, all([flag.clone(), off]))]);
            }
        }
    }

    /// In a drawn chart it is not known which of the transitions with the same priority comes first: Beremiz and
    /// OpenPLC write them in another order than that of the file. The condition of one may see the flags of the steps
    /// before the others as they were, or as ended. `flags`: the cell of each such flag, and what it was. Returns the
    /// writes that restore the flags behind the condition.
    fn tied_flags_end_in_any_order(
        &mut self,
        own: &Own<'_>,
        number: usize,
        flags: &[(Cell, Logic)],
    ) -> Vec<Write> {
        let transitions = &own.written.transitions;
        let one = &transitions[number];
        let asks = asks_flags(&own.chart.conditions[number]);
        if own.written.span.is_none() || !one.has_priority() || !asks {
            return Vec::new();
        }
        let tied = transitions.iter().filter(|other| other.priority == one.priority);
        let steps = tied.flat_map(|other| &other.from).filter(|step| !one.from.contains(step));
        let cells: BTreeSet<Cell> = steps.map(|&step| own.memory.steps[step]).collect();
        let mut restored = Vec::new();
        for (cell, flag) in flags.iter().filter(|(cell, _)| cells.contains(cell)) {
            let before = self.keep_bit(Logic::cell(*cell));
            let early = self.differs(CLEARS_AT_ONCE);
            let off = all([early, self.left_open()]);
            self.write(vec![set(*cell, all([flag.clone(), off.not()]))]);
            restored.push(set(*cell, before));
        }
        restored
    }

    /// Clears the flags of the steps `from` of a transition with a priority as soon as it clears, on the controllers
    /// that do so. Conditions evaluated later in the scan then see these steps as inactive.
    fn flags_end_early(&mut self, memory: &Memory, from: &[usize], clears: Cell) {
        if self.options.charts.actions_first {
            return;
        }
        let early = self.differs(CLEARS_AT_ONCE);
        let stays = self.keep_bit(all([Logic::cell(clears), early]).not());
        let flags = from.iter().map(|&step| memory.steps[step]);
        let ends = flags.map(|flag| set(flag, all([Logic::cell(flag), stays.clone()])));
        self.write(ends.collect());
    }

    /// Lowers the steps, then their exit, entry and active code, then the actions.
    fn act(&mut self, own: &Own<'_>, first: &Logic, may_be_matiec: bool) {
        let (chart, memory) = (own.written, &own.memory);
        for (step, one) in chart.steps.iter().enumerate() {
            self.at(one.line, &format!("STEP {}", one.name));
            let key = Assembler::key(&["STEP"], "nothing");
            self.act_where(key, Vec::new(), Logic::cell(memory.steps[step]));
        }
        self.hooks(own);
        for one in &chart.macros {
            // A macro step has its own flag and time.
            self.at(one.line, &format!("STEP {}", one.name));
            let key = Assembler::key(&["STEP"], "nothing");
            self.act_where(key, Vec::new(), memory.active(&one.steps));
        }
        // CODESYS's documentation: an action is executed at least twice, the second time when its step has ended.
        let known = self.project.is_of_codesys.then_some(false);
        let whole = Whole {
            reset_only_stored: self.differs("R ends only stored actions"),
            no_final_scan: self.differs_unless_known(NO_FINAL_SCAN, known),
            not_entered: match may_be_matiec {
                true => self.differs(NOT_ENTERED),
                false => Logic::Const(false),
            },
            runs_early: match may_be_matiec {
                true => all([first.clone(), self.differs(RUNS_EARLY)]),
                false => Logic::Const(false),
            },
            initial_steps: (0..chart.steps.len())
                .filter(|&step| chart.steps[step].initial)
                .collect(),
            entered_again: entered_again(chart),
        };
        let mut outputs = Vec::new();
        for (one, action) in own.chart.actions.iter().zip(&memory.actions) {
            if self.is_late() {
                return;
            }
            let text = format!("ACTION {}", one.name);
            self.at(one.line, &text);
            let from = self.builder.next();
            let kinds = action.feeds.iter().map(|feed| feed.qualifier);
            let times = self.input_times(own.at, one, kinds);
            let is_variable = matches!(one.body, ActionBody::Variable(_));
            outputs.push(self.control(memory, action, &whole, &times, is_variable));
            self.counted_part(from, one.line, &text, one.blocks);
        }
        let keep = memory.were.iter().zip(&memory.steps);
        let keep = keep.map(|(&was, &now)| set(was, Logic::cell(now))).collect();
        self.write(keep);
        self.actions(own, &outputs);
    }

    /// Lowers the exit, entry and active code of steps.
    fn hooks(&mut self, own: &Own<'_>) {
        let memory = &own.memory;
        // A power failure within a scan may leave any retained marking.
        let may_be_any =
            self.options.charts.competing.may_all_clear() || self.is_retained(own.at.instance);
        let which: [fn(&Hooks) -> &Option<Statement>; 3] =
            [|step| &step.exit, |step| &step.entry, |step| &step.active];
        for (number, hook) in which.into_iter().enumerate() {
            let all_steps = own.chart.steps.iter().enumerate();
            let hooks: Vec<(usize, &Statement)> =
                all_steps.filter_map(|(at, step)| Some((at, hook(step).as_ref()?))).collect();
            let never = vec![Logic::Const(false); hooks.len()];
            let rounds = turns::of_steps(own.written, hooks.len(), may_be_any);
            let regions = self.instances[own.at.instance].spot.tag.regions();
            turns::in_turns(self, &rounds, &never, regions, &mut |lower, which| {
                let (at, call) = hooks[which];
                let step = &own.written.steps[at];
                let [now, was] = [memory.steps[at], memory.were[at]].map(Logic::cell);
                let fires = match number {
                    0 => all([was, now.not()]),
                    1 => all([now, was.not()]),
                    _ => now,
                };
                let text = format!("STEP {}", step.name);
                lower.at(step.line, &text);
                let from = lower.builder.next();
                lower.executed(own.at, call, fires);
                lower.counted_part(from, step.line, &text, 1);
            });
        }
    }

    /// The time of each input of an action's control.
    fn input_times(
        &mut self,
        at: &Context,
        action: &Action,
        kinds: impl Iterator<Item = Qualifier>,
    ) -> Vec<InputTime> {
        let mut found = Vec::new();
        for (time, kind) in action.times.iter().zip(kinds) {
            let Some(time) = time.as_ref().map(|time| time.unconverted()) else {
                found.push(InputTime { is_over: Logic::Const(kind.is_timed()), units: None });
                continue;
            };
            if let ExprKind::Time(time) = time.kind {
                // Controllers differ in when a time of 0 ends, and whether it ends at all. On some, a time below 1 ms
                // is 0; and what is not modelled may be any time.
                let units = time_in_units(time);
                let is_over = match units {
                    Some(1..) => Logic::Const(false),
                    _ => self.left_open(),
                };
                let units = units.and_then(|units| u32::try_from(units).ok());
                found.push(InputTime { is_over, units });
                continue;
            }
            let number = self.value(at, time);
            let number = number.map(|value| self.as_number(value, Kind::Time));
            let is_over = match number {
                Ok(number) => self.is_no_time(number),
                Err(fault) => {
                    self.fault(fault);
                    Logic::Const(false)
                }
            };
            found.push(InputTime { is_over, units: None });
        }
        found
    }

    /// Lowers a statement that is executed where `fires` is true. It is not counted as a statement by itself.
    pub(super) fn executed(&mut self, at: &Context, one: &Statement, fires: Logic) {
        let skip = self.jump(fires.not(), Assembler::jump_key());
        let around = self.leave_out();
        self.statements(at, std::slice::from_ref(one), &mut JumpTargets::default());
        self.leave(around);
        self.land(skip);
        self.landing();
    }
}

/// The initial steps to which a transition leads, by number.
fn entered_again(chart: &Written) -> Vec<usize> {
    let leads_to = |step: usize| chart.transitions.iter().any(|one| one.to.contains(&step));
    let initial = (0..chart.steps.len()).filter(|&step| chart.steps[step].initial);
    initial.filter(|&step| leads_to(step)).collect()
}

/// Refuses a chart in a function or method, which keep no steps from call to call; a chart that declares a flag of
/// CODESYS that is not followed; and one with a transition from a step with an entry or exit action back to that step.
fn refuse_unsupported(chart: &Chart, written: &Written, keeps_steps: bool) -> Result<(), Fault> {
    let returns = |step: usize| {
        written.transitions.iter().find(|one| one.from.contains(&step) && one.to.contains(&step))
    };
    let hooked = chart
        .steps
        .iter()
        .enumerate()
        .filter(|(_, step)| step.entry.is_some() || step.exit.is_some());
    if let Some(one) = { hooked }.find_map(|(step, _)| returns(step)) {
        let message = "a transition leads back to its own step, which has an entry or exit action: whether these are executed is not known";
        let help = "put another step in between";
        return Err(Fault::new(one.line, message).code(FaultCode::NotModelled).help(help));
    }
    if !keeps_steps {
        let message =
            "functions and methods have no charts, because they keep no steps from call to call";
        let help = "move the chart to a function block";
        return Err(Fault::new(written.line, message).help(help));
    }
    if let Some(name) = chart.other_flag {
        let message = format!(
            "the flag {name} is not followed: with it, CODESYS controls the chart, or tells its state"
        );
        let help = format!("remove {name}; if it is a variable of your own, give it another name");
        return Err(Fault::new(written.line, message).code(FaultCode::NotModelled).help(help));
    }
    Ok(())
}

/// Whether a chart stores actions: with the qualifiers S, SD, DS and SL.
fn stores_actions(written: &Written) -> bool {
    let names = written.actions();
    let mut feeds = names.iter().flat_map(|name| written.inputs_of(name));
    feeds.any(|feed| feed.qualifier.is_stored())
}

/// Whether a condition asks for the flag of a step, or may do so in what it calls.
struct AsksFlags(bool);

/// Whether a condition may read step flags.
fn asks_flags(condition: &Expr) -> bool {
    let mut asks = AsksFlags(false);
    accesses::of_expr(condition, &mut asks);
    asks.0
}

impl Accesses for AsksFlags {
    fn reads(&mut self, _: &Place) {}
    fn writes(&mut self, _: &Place) {}
    fn takes_address(&mut self, _: &Place) {}

    fn asks(&mut self, _: &StepFlag) {
        self.0 = true;
    }

    fn calls(&mut self, _: &Call) {
        self.0 = true;
    }
}

fn no_room(line: u32) -> Fault {
    Fault::new(line, "the chart is too large for the memory that is modelled")
}

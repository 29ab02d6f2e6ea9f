//! Resolution of sequential function charts.

use super::paths::Found;
use super::resolver::{Resolver, Scope};
use super::statements::Labels;
use crate::charts::{Action, ActionBody, Chart, Hooks, Orders, StepFlag};
use crate::declarations::{Code, RoutineId, UnitId, VarId};
use crate::tree::{Expr, ExprKind, Place, Statement};
use crate::types::{Elementary, Type};
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::ast::{self, Kind, Part, Path};
use scanbound_iec::chart::{self as written, COMPUTED, Target};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, Language, Pou, same};

/// The possible orders in which controllers execute the actions of a chart.
#[must_use]
pub fn orders(chart: &written::Chart, pou: &Pou) -> Orders {
    let names = chart.actions();
    // Tools may put `_` after letters and digits, or before them.
    let alphabetical = ["_", " "].map(|sign| {
        let mut order: Vec<usize> = (0..names.len()).collect();
        order.sort_by_key(|&at| names[at].to_ascii_uppercase().replace('_', sign));
        order
    });
    // Boolean variables come first, then actions in order of declaration, then inline bodies and actions of instances.
    let rank = |&at: &usize| {
        let name = &names[at];
        let own = pou.actions.iter().position(|one| same(&one.name, name));
        let first = chart.blocks_of(name).next();
        let is_inline = first.is_some_and(|(_, one)| matches!(one.target, Target::Inline(..)));
        let is_variable = own.is_none() && !is_inline && !name.contains('.');
        (!is_variable, own.unwrap_or(usize::MAX))
    };
    let mut declared: Vec<usize> = (0..names.len()).collect();
    declared.sort_by_key(rank);
    if chart.span.is_none() {
        return Orders { declared, alphabetical, declared_is_clear: true };
    }
    let mut generated = as_generated(chart, &names);
    generated.sort_by_key(|at| rank(at).0);
    let branches =
        |step: usize| chart.transitions.iter().filter(|one| one.from.contains(&step)).count() > 1;
    let is_clear = generated == declared
        && !(0..chart.steps.len()).any(branches)
        && chart.transitions.iter().all(|one| one.to.len() < 2);
    Orders { declared: generated, alphabetical, declared_is_clear: is_clear }
}

/// The actions of a drawn chart in the order in which generators declare them: from step to step.
fn as_generated(chart: &written::Chart, names: &[String]) -> Vec<usize> {
    let blocks = chart.generated.iter().flat_map(|&step| &chart.steps[step].blocks);
    let own = blocks.map(|block| block.target.name());
    let mut found: Vec<usize> =
        own.filter_map(|own| names.iter().position(|name| same(name, &own))).collect();
    let mut known = vec![false; names.len()];
    found.extend(0..names.len());
    found.retain(|&at| !std::mem::replace(&mut known[at], true));
    found
}

fn no_action(name: &str, line: u32) -> ActionBody {
    let what = format!("{name} in an action block is neither an action nor a Boolean variable");
    let help = "name an action, and call the block or set the property there";
    ActionBody::Inline(Language::Sfc, Code::Unread(Fault::new(line, what).help(help)))
}

impl Resolver<'_> {
    pub(super) fn chart(&mut self, scope: Scope, unit: UnitId, chart: &written::Chart) -> Chart {
        let pou = &self.project.pous[unit.index()];
        let steps = chart.steps.iter().map(|step| {
            let mut hook = |path: &Option<Path>| {
                path.as_ref().map(|path| self.called_action(scope, path, step.line))
            };
            Hooks { exit: hook(&step.exit), entry: hook(&step.entry), active: hook(&step.active) }
        });
        let steps = steps.collect();
        let all = chart.transitions.iter();
        let conditions = all.map(|one| self.condition(scope, pou, one)).collect();
        let names = chart.actions();
        let actions = names.iter().map(|name| self.action(scope, pou, chart, name)).collect();
        let [halt, restart, others @ ..] = written::CONTROL_FLAGS;
        let mut others = others.into_iter().chain(written::STATE_FLAGS);
        let own_flag = |at: usize| self.flag(unit, chart.restart_flags[at].as_deref()?);
        Chart {
            written: chart.clone(),
            steps,
            conditions,
            actions,
            orders: orders(chart, pou),
            halt: self.flag(unit, halt).or_else(|| own_flag(0)),
            restart: self.flag(unit, restart).or_else(|| own_flag(1)),
            other_flag: others
                .find(|name| self.flag(unit, name).is_some())
                .or_else(|| self.global_flag(scope, unit)),
        }
    }

    /// The first flag of CODESYS that is not declared in the unit itself, but in a list of global variables or a base.
    fn global_flag(&mut self, scope: Scope, unit: UnitId) -> Option<&'static str> {
        let mut all = written::CONTROL_FLAGS.into_iter().chain(written::STATE_FLAGS);
        all.find(|name| {
            self.flag(unit, name).is_none() && self.one_path(scope, &Path::name(*name), 0).is_ok()
        })
    }

    /// The condition of a transition. It may name a transition of the unit, but not where that is drawn as a variable.
    fn condition(&mut self, scope: Scope, pou: &Pou, one: &written::Transition) -> Expr {
        let name = match &one.condition {
            ast::Expr::Variable(path) => path.as_name(),
            _ => None,
        };
        let own = name.filter(|name| pou.transitions.iter().any(|own| same(&own.name, name)));
        let Some(name) = own else { return self.expression(scope, &one.condition, one.line) };
        let what =
            format!("the condition {name} may be the transition of this name, or a variable");
        let fault = Fault::new(one.line, what).code(FaultCode::NotModelled);
        self.faulty(fault.help("write the condition at the transition itself"), one.line)
    }

    /// The unit's `BOOL` variable of this name, which controls the chart; `None` if it has none.
    fn flag(&self, unit: UnitId, name: &str) -> Option<VarId> {
        let is_bool = |id: &VarId| self.tree.variable(*id).ty == self.bool();
        self.index.member(unit, name).filter(is_bool)
    }

    fn called_action(&mut self, scope: Scope, path: &Path, line: u32) -> Statement {
        let call = ast::Statement { line, kind: Kind::Call(path.clone(), Vec::new()) };
        self.statement(scope, &call, &mut Labels::default())
    }

    fn action(&mut self, scope: Scope, pou: &Pou, chart: &written::Chart, name: &str) -> Action {
        let blocks = chart.blocks_of(name).count();
        let line = chart.blocks_of(name).next().map_or(chart.line, |(_, block)| block.line);
        let times = chart.inputs_of(name).into_iter().map(|feed| {
            let time = feed.time.map(|time| self.expression(scope, &time, line))?;
            let of = self.tree.types.elementary(Elementary::Time);
            Some(self.converted(time, of))
        });
        let times = times.collect();
        let body = self.action_body(scope, pou, chart, name);
        Action { name: name.to_owned(), times, blocks, body, line }
    }

    fn action_body(
        &mut self,
        scope: Scope,
        pou: &Pou,
        chart: &written::Chart,
        name: &str,
    ) -> ActionBody {
        let mut all = chart.steps.iter().flat_map(|step| &step.blocks);
        let Some(block) = all.find(|block| same(&block.target.name(), name)) else {
            return ActionBody::Inline(Language::St, Code::Statements(Vec::new()));
        };
        let line = block.line;
        let path = match &block.target {
            Target::Path(path) => path,
            Target::Inline(_, body) if matches!(**body, Body::Chart(_)) => {
                let told = "a chart within an action block is not followed";
                return ActionBody::Inline(Language::Sfc, Code::Unread(Fault::new(line, told)));
            }
            Target::Inline(_, body) => {
                return ActionBody::Inline(
                    body.language(),
                    self.code(scope, scope.unit, body, line),
                );
            }
        };
        let is_action = |name: &str| pou.actions.iter().any(|one| same(&one.name, name));
        // An inherited action comes before a global variable.
        let is_inherited = |unit: UnitId| {
            let name = path.as_name()?;
            self.index.action(unit, name).filter(|_| self.index.member(unit, name).is_none())
        };
        let is_action =
            path.as_name().is_some_and(is_action) || scope.unit.and_then(is_inherited).is_some();
        let found = if is_action { None } else { self.one_path(scope, path, line).ok() };
        if let Some(Found::Property(_) | Found::Constant(_)) = found {
            return no_action(name, line);
        }
        if let Some(Found::Place(place)) = found {
            if place.ty != self.bool() {
                return no_action(name, line);
            }
            if let Some((_, block)) = chart.blocks_of(name).find(|(_, one)| !one.is_qualified) {
                let what = format!(
                    "the block of the Boolean variable {name} has no qualifier: by the standard, this is N; matiec (Beremiz, OpenPLC) never writes the variable"
                );
                let fault = Fault::new(block.line, what).code(FaultCode::NotModelled);
                let fault = fault.help(format!("write the qualifier: {name}(N)"));
                return ActionBody::Inline(Language::Sfc, Code::Unread(fault));
            }
            return ActionBody::Variable(place);
        }
        let call = self.called_action(scope, path, line);
        let is_drawn = chart.span.is_some() && path.as_name() == Some(COMPUTED);
        let computed = scope.unit.filter(|_| is_drawn);
        match computed.and_then(|unit| self.index.action(unit, COMPUTED)) {
            Some(computed) => ActionBody::Computed(call, computed),
            None => ActionBody::Call(call),
        }
    }

    /// The flag or elapsed time of a step named by `path` (`S.X`, `S.T`), in a chart of this unit or of an instance.
    /// `None` if the path names no step.
    pub(super) fn step_flag(
        &mut self,
        scope: Scope,
        path: &Path,
        line: u32,
    ) -> Result<Option<Expr>, Fault> {
        let [before @ .., Part::Name(flag)] = &path.rest[..] else { return Ok(None) };
        let is_time = same(flag, "T");
        let (Some(unit), true) = (scope.unit, is_time || same(flag, "X")) else { return Ok(None) };
        // A step within macro steps has a name with dots (`M1.S3`), so the names before it are tried as an instance.
        for cut in [0].into_iter().chain((1..=before.len()).rev()) {
            let mut names: Vec<&str> = if cut == 0 { vec![&path.first] } else { Vec::new() };
            let behind = &before[cut.saturating_sub(1)..];
            names.extend(behind.iter().filter_map(|part| match part {
                Part::Name(name) => Some(name.as_str()),
                _ => None,
            }));
            if names.len() != behind.len() + usize::from(cut == 0) {
                continue;
            }
            let name = names.join(".");
            // An owner is looked up only for the name of a step, because its last part may be such a name in turn.
            let is_step = |body| step_in(body, &name).is_some();
            if !self.project.pous.iter().any(|pou| bodies_of(pou).any(is_step)) {
                continue;
            }
            let owner = match cut {
                0 => self.this(unit),
                _ => {
                    let rest = before[..cut - 1].to_vec();
                    let owner = Path { first: path.first.clone(), rest };
                    match self.one_path(scope, &owner, line) {
                        Ok(Found::Place(place)) => place,
                        _ => continue,
                    }
                }
            };
            let Type::Block(of) = *self.tree.types.get(owner.ty) else { continue };
            let Some((chart, step)) = self.step_named(of, &name) else { continue };
            if cut == 0 && before.is_empty() && self.own_variable(scope, &path.first).is_some() {
                let told = format!("{} may be a variable or a step", path.first);
                let help = "give one of them another name";
                return Err(Fault::new(line, told).code(FaultCode::DeclaredTwice).help(help));
            }
            return Ok(Some(self.flag_of(owner, chart, step, is_time, line)));
        }
        Ok(None)
    }

    fn flag_of(
        &self,
        owner: Place,
        chart: RoutineId,
        step: usize,
        is_time: bool,
        line: u32,
    ) -> Expr {
        let of = if is_time { Elementary::Time } else { Elementary::Bool };
        let flag = StepFlag { owner, chart, step, is_time };
        let ty = self.tree.types.elementary(of);
        Expr { kind: ExprKind::Step(Box::new(flag)), ty, line }
    }

    /// The routine of the unit's or a base's chart that has a step or macro step of this name, and the step's index
    /// (macro steps follow the steps).
    fn step_named(&self, unit: UnitId, name: &str) -> Option<(RoutineId, usize)> {
        self.tree.lineage(unit).into_iter().find_map(|unit| {
            let pou = &self.project.pous[unit.index()];
            let ids = [self.tree.unit(unit).body].into_iter().chain(self.actions_of(unit));
            let mut all = bodies_of(pou).zip(ids);
            all.find_map(|(body, id)| step_in(body, name).map(|step| (id, step)))
        })
    }

    fn actions_of(&self, unit: UnitId) -> impl Iterator<Item = RoutineId> {
        self.tree.unit(unit).actions.iter().copied()
    }
}

/// The unit's body and those of its actions.
fn bodies_of(pou: &Pou) -> impl Iterator<Item = &Body> {
    [&pou.body].into_iter().chain(pou.actions.iter().map(|one| &one.body))
}

/// The index of a step or macro step in a chart; macro steps follow the steps.
fn step_in(body: &Body, name: &str) -> Option<usize> {
    let Body::Chart(chart) = body else { return None };
    let of_macro = || {
        let at = chart.macros.iter().position(|one| same(&one.name, name))?;
        Some(chart.steps.len() + at)
    };
    chart.step(name).or_else(of_macro)
}

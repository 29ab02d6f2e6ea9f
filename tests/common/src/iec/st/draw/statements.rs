//! Draws random statements.

use super::super::place;
use super::super::tree::{For, Statement};
use super::*;

impl Draw<'_> {
    pub fn body(
        &mut self,
        project: &Project,
        scope: &Scope,
        many: usize,
        depth: usize,
    ) -> Vec<Statement> {
        (0..many).flat_map(|_| self.statement(project, scope, depth)).collect()
    }

    pub(super) fn assign(&mut self, project: &Project, scope: &Scope) -> Vec<Statement> {
        for _ in 0..4 {
            let ty = self.simple();
            if let Some(to) = self.find(project, scope, &ty, true, 1) {
                let value = match &ty {
                    Ty::Number(_) | Ty::Real | Ty::Time if self.dice.chance(4) => self.literal(&ty),
                    _ => self.value(project, scope, &ty, 2),
                };
                return vec![Statement::Assign(to, value)];
            }
        }
        Vec::new()
    }

    pub(super) fn calls(&mut self, project: &Project, scope: &Scope) -> Option<Statement> {
        let mut inner = scope.clone();
        inner.calls = 1;
        let scope = &inner;
        let call = match self.dice.below(8) {
            0 => self.function(project, scope, None)?,
            1 | 2 if self.has(Feature::Objects) => {
                let name = self.dice.one(&["Run", "Twist"]);
                self.method(project, scope, name)?
            }
            3 if self.has(Feature::Objects) => {
                let place = self.with_level(project, scope)?;
                return Some(Statement::Set(
                    place,
                    "Level",
                    self.value(project, scope, &Ty::int(), 1),
                ));
            }
            4 => self.action(project, scope)?,
            5 | 6 if scope.rank >= Rank::Body => {
                // What a block calls stands in it, or is passed to it.
                let is_program = scope.rank > Rank::Body;
                let own = scope.block;
                let fits = |ty: &Ty| matches!(ty, Ty::Block(of) if is_program || own.is_some_and(|own| *of < own && own == 2));
                let place = self.instance(project, scope, &fits)?;
                let is_inner = matches!(place.root, Root::Member(..))
                    && matches!(place.steps[..], [] | [Step::Element(_)]);
                if !is_program && !is_inner {
                    return None;
                }
                let Ty::Block(block) = place.ty else { return None };
                let variables: Vec<Variable> = project
                    .lineage(block)
                    .into_iter()
                    .rev()
                    .flat_map(|one| project.blocks[one].variables.clone())
                    .collect();
                let given = self.arguments(project, scope, &variables, false)?;
                Call { target: Target::Instance(place), given, unnamed: false, enable: None }
            }
            _ => {
                let fits = |ty: &Ty| matches!(ty, Ty::Standard(_));
                let place = self.instance(project, scope, &fits)?;
                let Ty::Standard(kind) = place.ty else { return None };
                let inputs = place::pins(kind);
                let many = match kind {
                    "R_TRIG" | "F_TRIG" => 1,
                    "CTU" | "CTD" => 3,
                    "CTUD" => 5,
                    _ => 2,
                };
                let mut given = Vec::new();
                for (name, ty) in &inputs[..many] {
                    let value = match *name {
                        "PT" => Expr { ty: Ty::Time, kind: Kind::Time(20) },
                        "PV" => self.literal(&Ty::int()),
                        _ => self.value(project, scope, ty, 1),
                    };
                    given.push(((*name).to_owned(), Argument::In(value)));
                }
                Call { target: Target::Standard(place, kind), given, unnamed: false, enable: None }
            }
        };
        let mut call = call;
        let can = matches!(call.target, Target::Function(_) | Target::Instance(_));
        if can && !call.unnamed && self.has(Feature::Enables) && self.dice.chance(2) {
            let condition = self.value(project, scope, &Ty::Bool, 1);
            let to = match self.dice.chance(2) {
                true => self.handed(project, scope, &Ty::Bool),
                false => None,
            };
            call.enable = Some((condition, to));
        }
        Some(Statement::Call(call))
    }

    pub(super) fn action(&mut self, project: &Project, scope: &Scope) -> Option<Call> {
        let call = |target| Call { target, given: Vec::new(), unnamed: false, enable: None };
        if let Some(block) = scope.block
            && scope.rank == Rank::Body
        {
            let of = project
                .lineage(block)
                .into_iter()
                .find(|&one| !project.blocks[one].actions.is_empty())?;
            return Some(call(Target::Action(None, of, 0)));
        }
        if scope.rank < Rank::Late {
            return None;
        }
        let fits = |ty: &Ty| matches!(ty, Ty::Block(_));
        let place = self.instance(project, scope, &fits)?;
        let Ty::Block(block) = place.ty else { return None };
        let of = project
            .lineage(block)
            .into_iter()
            .find(|&one| !project.blocks[one].actions.is_empty())?;
        Some(call(Target::Action(Some(place), of, 0)))
    }

    /// What is still there when the routine has ended.
    pub(super) fn lasting(&mut self, project: &Project, scope: &Scope, want: &Ty) -> Option<Place> {
        let found = self.handed(project, scope, want)?;
        let lasts = match found.root {
            Root::Member(block, at) => {
                let section = project.blocks[block].variables[at].section;
                !matches!(section, Section::InOut | Section::Temp)
            }
            Root::Local(_) => false,
            _ => true,
        };
        lasts.then_some(found)
    }

    /// Lets a pointer, a reference or an interface mean something else.
    pub(super) fn means(&mut self, project: &Project, scope: &Scope) -> Option<Statement> {
        let all: Vec<(Place, bool)> = scope
            .roots
            .iter()
            .filter(|one| matches!(one.0.ty, Ty::Pointer(_) | Ty::Interface))
            .filter(|one| one.1)
            .cloned()
            .collect();
        let references = self.references(project, scope);
        if !references.is_empty() && (all.is_empty() || self.dice.chance(2)) {
            let own = self.dice.one(&references);
            let of = self.lasting(project, scope, &own.ty)?;
            return Some(Statement::Refer(own, of));
        }
        if all.is_empty() {
            return None;
        }
        let (place, _) = self.dice.one(&all);
        let value = match &place.ty {
            Ty::Pointer(of) => {
                let to = self.lasting(project, scope, of)?;
                Expr { ty: place.ty.clone(), kind: Kind::Address(to) }
            }
            _ => self.meant(project, scope)?,
        };
        Some(Statement::Assign(place, value))
    }

    /// The variables that are references.
    pub(super) fn references(&mut self, project: &Project, scope: &Scope) -> Vec<Place> {
        let is = |place: &&Place| {
            let variable = match place.root {
                Root::Global(at) => &project.globals[at],
                Root::Member(block, at) => &project.blocks[block].variables[at],
                _ => return false,
            };
            matches!(variable.ty, Ty::Reference(_))
        };
        let all = scope.roots.iter().map(|one| &one.0).filter(|one| one.steps.is_empty());
        all.filter(is).cloned().collect()
    }

    pub(super) fn statement(
        &mut self,
        project: &Project,
        scope: &Scope,
        depth: usize,
    ) -> Vec<Statement> {
        let one = match self.dice.below(if depth == 0 { 9 } else { 16 }) {
            4 | 5 | 15 => self.calls(project, scope),
            6 => self.means(project, scope),
            7 if self.has(Feature::Parts) => self.copy(project, scope),
            8 if self.dice.chance(3) => self.find(project, scope, &Ty::Bool, true, 1).map(|to| {
                let when = self.value(project, scope, &Ty::Bool, 1);
                Statement::Latch(to, self.dice.chance(2), when)
            }),
            9 | 10 => {
                let arms = (0..1 + self.dice.below(2))
                    .map(|_| {
                        let many = 1 + self.dice.below(2);
                        let condition = self.value(project, scope, &Ty::Bool, 2);
                        (condition, self.body(project, scope, many, depth - 1))
                    })
                    .collect();
                let many = self.dice.below(2);
                Some(Statement::If(arms, self.body(project, scope, many, depth - 1)))
            }
            11 => Some(self.case(project, scope, depth)),
            12 | 13 => return self.looped(project, scope, depth),
            // Behind the program's end its values are asked for.
            14 if scope.in_loop || scope.rank < Rank::Program => {
                let leave = match scope.in_loop {
                    true => self.dice.one(&[Statement::Exit, Statement::Continue]),
                    false => Statement::Return,
                };
                let when = self.value(project, scope, &Ty::Bool, 1);
                Some(Statement::If(vec![(when, vec![leave])], Vec::new()))
            }
            _ => None,
        };
        one.map_or_else(|| self.assign(project, scope), |one| vec![one])
    }

    pub(super) fn copy(&mut self, project: &Project, scope: &Scope) -> Option<Statement> {
        let is = |ty: &Ty| matches!(ty, Ty::Struct(_) | Ty::Array(..));
        let all: Vec<(Place, bool)> =
            scope.roots.iter().filter(|one| is(&one.0.ty) && one.1).cloned().collect();
        if all.is_empty() {
            return None;
        }
        let (to, _) = self.dice.one(&all);
        let ty = to.ty.clone();
        if matches!(&ty, Ty::Array(_, of) if !of.is_simple() && !matches!(**of, Ty::Struct(_))) {
            return None;
        }
        let from = self.find(project, scope, &ty, false, 1)?;
        Some(Statement::Copy(to, from))
    }

    pub(super) fn case(&mut self, project: &Project, scope: &Scope, depth: usize) -> Statement {
        let ty = if self.dice.chance(4) { Ty::Colour } else { self.number() };
        let mut arms = Vec::new();
        let mut low = if matches!(ty, Ty::Number(of) if of.signed) { -2 } else { 0 };
        let mut colours: Vec<i128> = COLOURS.iter().map(|one| one.1).collect();
        for _ in 0..1 + self.dice.below(3) {
            let mut values = Vec::new();
            for _ in 0..1 + self.dice.below(2) {
                if ty == Ty::Colour {
                    let Some(value) = colours.pop() else { break };
                    values.push((value, value));
                    continue;
                }
                low += self.small(3);
                let from = low;
                low += self.small(3);
                values.push((from, low));
                low += 1;
            }
            if !values.is_empty() {
                let many = 1 + self.dice.below(2);
                arms.push((values, self.body(project, scope, many, depth - 1)));
            }
        }
        let of = self.value(project, scope, &ty, 1);
        let many = self.dice.below(2);
        Statement::Case(of, arms, self.body(project, scope, many, depth - 1))
    }

    pub(super) fn looped(
        &mut self,
        project: &Project,
        scope: &Scope,
        depth: usize,
    ) -> Vec<Statement> {
        let mut inner = scope.clone();
        let Some(counter) = inner.counters.pop() else { return self.assign(project, scope) };
        let ty = counter.ty.clone();
        let of = ty.as_number().expect("a number");
        let written = self.has(Feature::Written) && self.dice.chance(3);
        inner.roots.push((counter.clone(), written));
        inner.in_loop = true;
        let many = 1 + self.dice.below(2);
        let mut body = self.body(project, &inner, many, depth - 1);
        let literal = |value: i128| number_expr(value, &ty);
        // An end, or a start, that is worked out.
        let within = |draw: &mut Self, low: i128, high: i128| {
            let given = vec![literal(low), draw.value(project, scope, &ty, 1), literal(high)];
            standard("LIMIT", given, ty.clone())
        };
        if self.dice.chance(2) {
            let end = 1 + self.small(3);
            let end = match self.dice.below(3) {
                0 => within(self, 0, end + 1),
                _ => literal(end),
            };
            let next = binary("+", read(counter.clone()), literal(1), ty.clone());
            let next = Statement::Assign(counter.clone(), next);
            let start = Statement::Assign(counter.clone(), literal(0));
            let more = match self.has(Feature::Loops) && self.dice.chance(2) {
                true => Some(self.value(project, &inner, &Ty::Bool, 1)),
                false => None,
            };
            body.insert(0, next);
            let is_while = self.dice.chance(2);
            let operator = if is_while { "<" } else { ">=" };
            let mut condition = binary(operator, read(counter), end, Ty::Bool);
            if let Some(more) = more {
                let operator = if is_while { "AND" } else { "OR" };
                condition = binary(operator, condition, more, Ty::Bool);
            }
            return vec![
                start,
                match is_while {
                    true => Statement::While(condition, body),
                    false => Statement::Repeat(body, condition),
                },
            ];
        }
        let all = [
            (0, 2, Some(1)),
            (1, 3, None),
            (3, 0, Some(-1)),
            (0, 5, Some(2)),
            (2, 1, None),
            (4, 1, Some(-2)),
        ];
        let (from, to, by) = self.dice.one(&all);
        let by = if of.signed { by } else { by.filter(|by| *by > 0) };
        let from = if self.dice.chance(4) { within(self, 0, 3) } else { literal(from) };
        let to = if self.dice.chance(4) { within(self, 0, 3) } else { literal(to) };
        vec![Statement::For(Box::new(For { variable: counter, from, to, by, body }))]
    }
}

//! Name resolution: builds the typed tree from the syntax tree. No other module looks up names.

mod ambiguous;
mod calls;
mod charts;
mod declared;
mod drawing;
mod exposed;
mod expressions;
mod given;
mod index;
mod initial;
mod paths;
mod resolver;
mod stated;
mod statements;
mod tasks;
mod types;
mod unknown_types;

pub use charts::orders;

use crate::constants::Constants;
use crate::declarations::{
    Code, First, Initial, Owner, Routine, RoutineId, RoutineKind, Unit, UnitId, VarId, Variable,
};
use crate::tree::{Connected, Expr, ExprKind, Pair, Tree};
use crate::types::{Type, TypeId};
pub use declared::faults;
use index::Index;
pub use resolver::Facts;
use resolver::{Resolver, Scope, kept};
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::ast;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, Pou, PouKind, Project, Section, Variable as Declared, same};
use std::collections::{BTreeMap, BTreeSet};
pub use unknown_types::list_unknown_types;

/// Builds the typed tree of a project whose declarations have no faults ([`faults`]).
#[must_use]
pub fn tree(project: &Project, facts: Facts<'_>) -> Tree {
    // What a drawing may access depends on which programs other units name anywhere. Repeat until the set is stable.
    let mut named = BTreeSet::new();
    loop {
        let (tree, found) = tree_if_named(project, facts, &named);
        if found.is_subset(&named) {
            return tree;
        }
        named.extend(found);
    }
}

/// Builds the typed tree under the assumption that other units name no programs except `named`. Also returns the
/// programs that they do name.
fn tree_if_named(
    project: &Project,
    facts: Facts<'_>,
    named: &BTreeSet<UnitId>,
) -> (Tree, BTreeSet<UnitId>) {
    let mut own = Resolver {
        project,
        facts,
        constants: Constants::new(project),
        tree: Tree { gives_parts: tasks::gives_parts(project), ..Tree::default() },
        index: Index::new(project),
        listed: BTreeMap::new(),
        held: BTreeMap::new(),
        before: Vec::new(),
        is_code: false,
        meanings: ambiguous::meanings(project),
        named_programs: BTreeSet::new(),
        exposed: BTreeSet::new(),
    };
    own.declare();
    own.initial_values();
    own.tree.begins_before = own.begins_before();
    own.exposed = own.exposed_units(named);
    own.bodies();
    own.leave_out_called_programs();
    own.state_routines();
    own.connections();
    (own.tree, own.named_programs)
}

impl<'p> Resolver<'p> {
    fn declare(&mut self) {
        let project = self.project;
        // Units first, because types and variables refer to them.
        for (number, pou) in project.pous.iter().enumerate() {
            let base = pou.extends.as_ref().map(|base| self.index.unit(base).ok_or(base));
            let fault = match base {
                Some(Err(base)) => Some(types::unknown_base(&pou.name, base, pou.line)),
                _ => None,
            };
            let unit = UnitId::at(number);
            let body = self.routine(unit, RoutineKind::Body, &pou.name, &pou.body, pou.line);
            let actions = pou
                .actions
                .iter()
                .map(|one| self.routine(unit, RoutineKind::Action, &one.name, &one.body, one.line));
            let actions = actions.collect();
            let methods = pou.methods.iter().map(|one| {
                let id = self.routine(unit, RoutineKind::Method, &one.name, &one.body, one.line);
                self.tree.routines[id.index()].is_private = one.is_private;
                id
            });
            let methods: Vec<RoutineId> = methods.collect();
            self.tree.units.push(Unit {
                name: pou.name.clone(),
                kind: pou.kind,
                base: base.and_then(Result::ok),
                interfaces: self.interfaces(pou),
                variables: Vec::new(),
                result: None,
                body,
                actions,
                fault,
                retain: project.retains(number),
                begins_with: { &methods }
                    .iter()
                    .copied()
                    .filter(|&one: &RoutineId| {
                        let name = &self.tree.routine(one).name;
                        ["FB_Init", "FB_Reinit"].iter().any(|own| same(own, name))
                    })
                    .collect(),
                begins_with_method: pou.methods.iter().any(is_called_by_itself),
                methods,
                file: pou.file,
                line: pou.line,
            });
        }
        for number in 0..project.pous.len() {
            self.block(UnitId::at(number));
        }
        self.index.members(&self.tree);
        for number in 0..project.pous.len() {
            self.unit_variables(UnitId::at(number));
        }
        self.global_variables();
        self.tasks();
    }

    /// The interfaces that a unit implements (or that an interface extends), with those that these extend.
    fn interfaces(&self, pou: &Pou) -> Vec<UnitId> {
        let mut found: Vec<UnitId> = Vec::new();
        let mut open: Vec<&str> = pou.implements.iter().map(String::as_str).collect();
        while let Some(unit) = open.pop().and_then(|name| self.index.unit(name)) {
            if !found.contains(&unit) {
                found.push(unit);
                let more = &self.project.pous[unit.index()].implements;
                open.extend(more.iter().map(String::as_str));
            }
        }
        found
    }

    fn routine(
        &mut self,
        unit: UnitId,
        kind: RoutineKind,
        name: &str,
        body: &Body,
        line: u32,
    ) -> RoutineId {
        self.tree.routines.push(Routine {
            name: name.to_owned(),
            unit,
            kind,
            slot: self.index.slot(kind, name),
            variables: Vec::new(),
            result: None,
            language: body.language(),
            code: Code::Statements(Vec::new()),
            is_private: false,
            stated: None,
            line,
        });
        RoutineId::at(self.tree.routines.len() - 1)
    }

    /// The variable declarations visible to a unit, or to one of its methods: the method's, the unit's, then those of
    /// its bases.
    fn around(&self, unit: UnitId, method: Option<&'p Pou>) -> Vec<&'p [Declared]> {
        let units = self.tree.lineage(unit);
        let units = units.into_iter().map(|one| &self.project.pous[one.index()]);
        method.into_iter().chain(units).map(|pou| &pou.variables[..]).collect()
    }

    fn unit_variables(&mut self, unit: UnitId) {
        let pou = &self.project.pous[unit.index()];
        let around = self.around(unit, None);
        let mut own = Vec::new();
        for one in kept(&pou.variables) {
            own.push(self.variable(one, Owner::Unit(unit), &around));
        }
        if pou.kind == PouKind::Function {
            let result = self.result(pou, Owner::Unit(unit), &around);
            own.extend(result);
            self.tree.units[unit.index()].result = result;
        }
        self.tree.units[unit.index()].variables = own;
        for (at, method) in pou.methods.iter().enumerate() {
            let id = self.tree.units[unit.index()].methods[at];
            let around = self.around(unit, Some(method));
            let mut own = Vec::new();
            for one in kept(&method.variables) {
                own.push(self.variable(one, Owner::Routine(id), &around));
            }
            let result = self.result(method, Owner::Routine(id), &around);
            own.extend(result);
            let routine = &mut self.tree.routines[id.index()];
            (routine.variables, routine.result) = (own, result);
        }
    }

    fn result(&mut self, pou: &Pou, owner: Owner, around: &[&[Declared]]) -> Option<VarId> {
        let of = pou.result.as_ref()?;
        let result = Declared::new(pou.result_name(), Section::Local, of.clone(), pou.line);
        Some(self.variable(&result, owner, around))
    }

    fn variable(&mut self, one: &Declared, owner: Owner, around: &[&[Declared]]) -> VarId {
        let ty = self.type_of(&one.of, around, one.line);
        let first = match types::is_elementary(&one.of) {
            true => First::Zero,
            false => match self.first_named(&one.of, around) {
                Some(number) => First::Number(number),
                None => First::Unknown,
            },
        };
        self.tree.variables.push(Variable {
            name: one.name.clone(),
            symbol: self.index.symbol(&one.name),
            section: one.section,
            ty,
            owner,
            initial: None,
            first,
            begins: Initial::Unknown,
            type_calls: self.type_calls(&one.of, &mut Vec::new()),
            at: one.at.clone(),
            constant: one.constant,
            retain: one.retain,
            is_internal: one.is_internal,
            has_edge: one.has_edge,
            line: one.line,
        });
        let id = VarId::at(self.tree.variables.len() - 1);
        match owner {
            Owner::Unit(unit) => self.index.add_member(unit, &one.name, id),
            Owner::Routine(routine) => self.index.add_local(routine, &one.name, id),
            Owner::Global(_) => {}
        }
        id
    }

    fn global_variables(&mut self) {
        let project = self.project;
        for (number, (name, all)) in project.globals.iter().enumerate() {
            let around: &[&[Declared]] = if name.is_empty() { &[] } else { &[all] };
            let mut own = Vec::new();
            for one in all {
                let id = self.variable(one, Owner::Global(number), around);
                self.index.add_global(name, &one.name, id);
                own.push(id);
            }
            let name = name.clone();
            self.tree.globals.push(crate::declarations::GlobalList { name, variables: own });
        }
        for (list, all) in project.lists.iter().filter(|(list, _)| !project.has_name(list)) {
            all.iter().for_each(|name| self.index.add_of_file(list, name));
        }
        self.index.inherit(&self.tree);
    }

    /// Resolves the initial values in all declarations.
    fn initial_values(&mut self) {
        let project = self.project;
        for number in 0..project.pous.len() {
            let (unit, pou) = (UnitId::at(number), &project.pous[number]);
            let own = self.tree.unit(unit).variables.clone();
            let scope = Scope { unit: Some(unit), method: None, list: None };
            self.initial_of(scope, &own, &pou.variables);
            for (at, method) in pou.methods.iter().enumerate() {
                let id = self.tree.unit(unit).methods[at];
                let own = self.tree.routine(id).variables.clone();
                let scope = Scope { unit: Some(unit), method: Some(id), list: None };
                self.initial_of(scope, &own, &method.variables);
            }
        }
        for (number, (_, all)) in project.globals.iter().enumerate() {
            let scope = Scope { unit: None, method: None, list: Some(number) };
            let own = self.tree.globals[number].variables.clone();
            for (id, one) in own.into_iter().zip(all) {
                self.initial_one(scope, id, one);
            }
        }
    }

    fn initial_of(&mut self, scope: Scope, own: &[VarId], all: &[Declared]) {
        for (&id, one) in own.iter().zip(kept(all)) {
            self.initial_one(scope, id, one);
        }
    }

    fn initial_one(&mut self, scope: Scope, id: VarId, one: &Declared) {
        let ty = self.tree.variable(id).ty;
        if scope.method.is_none() {
            let project = self.project;
            let around: Vec<&[Declared]> = match (scope.unit, scope.list) {
                (Some(unit), _) => self.around(unit, None),
                (_, Some(list)) if !project.globals[list].0.is_empty() => {
                    vec![&project.globals[list].1]
                }
                _ => Vec::new(),
            };
            self.tree.variables[id.index()].begins = self.begins(one, ty, &around);
        }
        let Some(initial) = &one.initial else { return };
        let found = self.initial(scope, initial, ty, one.line);
        self.tree.variables[id.index()].initial = Some(found);
    }

    /// Resolves the initial value of a variable of type `of`, or of a part of one.
    fn initial(&mut self, scope: Scope, one: &ast::Expr, of: TypeId, line: u32) -> Expr {
        if self.tree.types.is_reference(of) {
            return self.address(scope, one, line);
        }
        let ast::Expr::List(listing, given) = one else {
            return self.expression(scope, one, line);
        };
        if *listing == ast::Listing::Unread && self.tree.has_reference(of) {
            let told = "an initial value of references cannot be read";
            let help = "assign them in the program";
            let fault = Fault::new(line, told).code(FaultCode::NotModelled).help(help);
            return self.faulty(fault, line);
        }
        let mut all = Vec::new();
        for part in given {
            let own = self.part_type(of, part.name.as_deref());
            all.push(self.initial(scope, &part.value, own, line));
        }
        let ty = self.unknown();
        Expr { kind: ExprKind::List(all), ty, line }
    }

    /// The type of an array element, of a field, or of a parameter or variable named in the initialization of an
    /// instance. [`Type::Unknown`] if there is none.
    fn part_type(&mut self, of: TypeId, name: Option<&str>) -> TypeId {
        let unknown = self.unknown();
        match (self.tree.types.get(of).clone(), name) {
            (Type::Array(_, of), _) => of,
            (Type::Struct(id), Some(name)) => {
                let parts = self.tree.types.parts(id);
                parts.iter().find(|(own, _)| same(own, name)).map_or(unknown, |part| part.1)
            }
            (Type::Block(unit), Some(name)) => {
                let units = self.tree.lineage(unit).into_iter();
                let methods = units.flat_map(|unit| self.tree.unit(unit).begins_with.clone());
                let methods: Vec<RoutineId> = methods.collect();
                let taken = methods.iter().find_map(|&method| self.index.local(method, name));
                let own = taken.or_else(|| self.index.member(unit, name));
                own.map_or(unknown, |own| self.tree.variable(own).ty)
            }
            _ => unknown,
        }
    }

    fn bodies(&mut self) {
        self.is_code = true;
        let project = self.project;
        for (number, pou) in project.pous.iter().enumerate() {
            let unit = UnitId::at(number);
            let scope = Scope { unit: Some(unit), method: None, list: None };
            let Unit { body, actions, methods, .. } = self.tree.unit(unit).clone();
            // Actions come first: those for the blocks of conditions declare variables that the conditions read.
            for (id, one) in actions.into_iter().zip(&pou.actions) {
                self.code_of(scope, id, &one.body);
            }
            self.code_of(scope, body, &pou.body);
            for (id, one) in methods.into_iter().zip(&pou.methods) {
                let scope = Scope { method: Some(id), ..scope };
                self.code_of(scope, id, &one.body);
            }
        }
    }

    fn code_of(&mut self, scope: Scope, id: RoutineId, body: &Body) {
        let Routine { unit, line, .. } = self.tree.routines[id.index()];
        self.tree.routines[id.index()].code = self.code(scope, Some(unit), body, line);
    }

    fn code(&mut self, scope: Scope, unit: Option<UnitId>, body: &Body, line: u32) -> Code {
        match (body, unit) {
            (Body::Chart(chart), Some(unit)) => {
                Code::Chart(Box::new(self.chart(scope, unit, chart)))
            }
            (Body::Unread(_, fault), _) => Code::Unread(fault.clone()),
            _ => Code::Statements(self.body(scope, body, line)),
        }
    }

    fn connections(&mut self) {
        for one in &self.project.connected {
            let pairs = one.given.iter().map(|pair| self.pair(one, pair)).collect();
            let (instance, file, line) = (self.instance_named(&one.name), one.file, one.line);
            self.tree.connected.push(Connected { instance, pairs, file, line });
        }
    }

    fn pair(&mut self, of: &scanbound_iec::Connected, one: &ast::Argument) -> Result<Pair, Fault> {
        let line = of.line;
        let program = self.instance_named(&of.name).map(|at| &self.tree.programs[at]);
        let name = one.name.clone().unwrap_or_default();
        let section = if one.is_output { Section::Output } else { Section::Input };
        let own = program.and_then(|program| self.index.member(program.unit, &name));
        let own = own.filter(|&own| self.tree.variable(own).section == section);
        let Some(own) = own else {
            let kind = if one.is_output { "output" } else { "input" };
            let help = "connect a variable of VAR_INPUT by :=, and one of VAR_OUTPUT by =>";
            let told = format!("the program of {} has no {kind} {name}", of.name);
            return Err(Fault::new(line, told).code(FaultCode::UnknownName).text(&name).help(help));
        };
        let refused = || {
            let help = "connect constants, global variables and addresses";
            let what = scanbound_iec::show::expr(&one.value);
            let told = format!("the connection of a program to {what} is not followed");
            Fault::new(line, told).code(FaultCode::NotModelled).help(help)
        };
        let scope = Scope { unit: None, method: None, list: None };
        let other = match &one.value {
            ast::Expr::Variable(_) => self.expression(scope, &one.value, line),
            ast::Expr::Literal(_) | ast::Expr::Negate(_) if !one.is_output => {
                self.expression(scope, &one.value, line)
            }
            _ => return Err(refused()),
        };
        match other.kind {
            ExprKind::Fault(fault) => Err(*fault),
            _ => Ok(Pair { own, is_output: one.is_output, other }),
        }
    }

    fn bool(&self) -> TypeId {
        self.tree.types.elementary(crate::types::Elementary::Bool)
    }

    fn unknown(&mut self) -> TypeId {
        self.tree.types.id(Type::Unknown)
    }
}

/// Whether controllers call a method by themselves: `FB_Init`, `FB_Reinit` or `FB_Exit`.
fn is_called_by_itself(method: &Pou) -> bool {
    ["FB_Init", "FB_Reinit", "FB_Exit"].iter().any(|own| same(own, &method.name))
}

//! What the code of a project names, writes and calls, and whether it may reach a variable by another name.

use super::emit::Emit;
use super::resolve::{Context, Found};
use super::types::lineage;
use super::within::{calls, names_property, variables};
use scanbound_iec::ast::{Argument, Expr, Kind as Statements, Part, Path, Statement};
use scanbound_iec::chart::Target;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, Pou, PouKind, Section, TypeRef, Variable, same};
use scanbound_ir::flow;
use std::collections::BTreeSet;

/// What a path in code is for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Use<'p> {
    Read,
    Write,
    Call,
    /// It is handed over for this input, if that is named, to this function or method, or to an instance.
    Handed(Option<&'p str>, Option<&'p Path>),
}

/// Code: statements, the condition of a transition, or what a block of a step names.
#[derive(Clone, Copy)]
enum Code<'p> {
    Statements(&'p [Statement]),
    Condition(&'p Expr),
    Action(&'p Path),
}

/// The code of a unit's actions, of charts, and of those methods that something names, and that of its body, if it is asked for;
/// each with the variables of the method that it stands in.
fn code_with<'p>(
    pou: &'p Pou,
    with_body: bool,
    named: &BTreeSet<String>,
) -> Vec<(Code<'p>, &'p [Variable])> {
    let methods = pou.methods.iter().filter(|method| is_named(method, named));
    let methods = methods.map(|method| (code(method, true), &method.variables[..]));
    let own = code_beside(pou, with_body);
    let all = std::iter::once((own, &[][..])).chain(methods);
    all.flat_map(|(all, hidden)| all.into_iter().map(move |one| (one, hidden))).collect()
}

/// Whether these names, in capitals, have that of a method, or of the property that it reads or writes.
fn is_named(method: &Pou, named: &BTreeSet<String>) -> bool {
    let has = |name: &str| named.contains(&name.to_ascii_uppercase());
    has(&method.name) || method.property().is_some_and(has)
}

/// The code of a unit's actions, methods and charts, and that of its body, if it is asked for.
fn code(pou: &Pou, with_body: bool) -> Vec<Code<'_>> {
    let mut found = code_beside(pou, with_body);
    found.extend(pou.methods.iter().flat_map(|method| code(method, true)));
    found
}

/// The same without that of its methods.
fn code_beside(pou: &Pou, with_body: bool) -> Vec<Code<'_>> {
    let mut found = Vec::new();
    if with_body {
        found.extend(code_of(&pou.body));
    }
    for one in pou.actions.iter().chain(&pou.transitions) {
        found.extend(code_of(&one.body));
    }
    found
}

/// The code of a body.
fn code_of(body: &Body) -> Vec<Code<'_>> {
    let mut found = Vec::new();
    match body {
        Body::Code(_, statements) => found.push(Code::Statements(statements)),
        Body::Chart(chart) => {
            found.extend(chart.transitions.iter().map(|one| Code::Condition(&one.condition)));
            for block in chart.steps.iter().flat_map(|step| &step.blocks) {
                match &block.target {
                    Target::Inline(_, body) => found.extend(code_of(body)),
                    Target::Path(path) => found.push(Code::Action(path)),
                }
            }
        }
        // Where it is called, that is a fault.
        Body::Unread(..) => {}
    }
    found
}

/// The names that an action, a method or a property of a unit uses and does not declare itself.
pub(super) fn named_in<'p>(pou: &'p Pou, member: &str) -> Vec<&'p str> {
    let mut all: Vec<(Code<'p>, &'p [Variable])> = Vec::new();
    for one in pou.actions.iter().filter(|one| same(&one.name, member)) {
        all.extend(code_of(&one.body).into_iter().map(|code| (code, &[][..])));
    }
    let is_meant = |method: &&Pou| {
        same(&method.name, member) || method.property().is_some_and(|own| same(own, member))
    };
    for method in pou.methods.iter().filter(is_meant) {
        all.extend(code(method, true).into_iter().map(|code| (code, &method.variables[..])));
    }
    let mut found = Vec::new();
    for (code, hidden) in all {
        paths(code, &mut |path, _| {
            let mut names = names(path);
            let first = names.next();
            let is_own = |name: &str| ["THIS", "SUPER"].iter().any(|own| same(own, name));
            found.extend(match first {
                Some(first) if is_own(first) => names.next(),
                first => first.filter(|name| !declares(hidden, name)),
            });
        });
    }
    found
}

/// Shows all paths in a unit's code, each with the variables of the method that it stands in.
pub(super) fn each_path<'p>(pou: &'p Pou, see: &mut dyn FnMut(&'p Path, &'p [Variable])) {
    let mut all = vec![(code_beside(pou, true), &[][..])];
    all.extend(pou.methods.iter().map(|method| (code(method, true), &method.variables[..])));
    for (code, hidden) in all {
        code.into_iter().for_each(|code| paths(code, &mut |path, _| see(path, hidden)));
    }
}

/// Shows all paths of code and what they are for.
fn paths<'p>(code: Code<'p>, see: &mut dyn FnMut(&'p Path, Use<'p>)) {
    let statements = match code {
        Code::Statements(statements) => statements,
        Code::Condition(expr) => return of_expr(expr, see),
        Code::Action(path) => {
            of_path(path, Use::Call, see);
            return of_path(path, Use::Write, see);
        }
    };
    for one in statements {
        let mut within = |all: &'p [Statement]| paths(Code::Statements(all), see);
        match &one.kind {
            Statements::If(arms, otherwise) => {
                arms.iter().for_each(|(_, body)| within(body));
                within(otherwise);
            }
            Statements::Case(_, arms, otherwise) => {
                arms.iter().for_each(|(_, body)| within(body));
                within(otherwise);
            }
            Statements::For(.., body)
            | Statements::While(_, body)
            | Statements::Repeat(body, _) => within(body),
            Statements::Either(_, one, other) => {
                within(one);
                within(other);
            }
            _ => {}
        }
        match &one.kind {
            Statements::Assign(target, _)
            | Statements::Refer(target, _)
            | Statements::Latch(target, ..)
            | Statements::For(target, ..) => of_path(target, Use::Write, see),
            Statements::Call(target, given) | Statements::CallIf(_, target, given) => {
                of_path(target, Use::Call, see);
                of_given(None, given, see);
            }
            _ => {}
        }
        match &one.kind {
            Statements::CallIf(value, ..)
            | Statements::Assign(_, value)
            | Statements::Refer(_, value)
            | Statements::Latch(_, _, value)
            | Statements::Case(value, ..)
            | Statements::While(value, _)
            | Statements::Repeat(_, value)
            | Statements::Return(value)
            | Statements::Jump(value, _) => of_expr(value, see),
            Statements::If(arms, _) => {
                arms.iter().for_each(|(condition, _)| of_expr(condition, see));
            }
            Statements::For(_, from, to, by, _) => {
                [Some(from), Some(to), by.as_ref()]
                    .into_iter()
                    .flatten()
                    .for_each(|one| of_expr(one, see));
            }
            _ => {}
        }
    }
}

fn of_expr<'p>(expr: &'p Expr, see: &mut dyn FnMut(&'p Path, Use<'p>)) {
    match expr {
        Expr::Variable(path) => of_path(path, Use::Read, see),
        Expr::Not(inner) | Expr::Negate(inner) => of_expr(inner, see),
        Expr::Binary(_, left, right) => {
            of_expr(left, see);
            of_expr(right, see);
        }
        Expr::Call(path, given) => {
            of_path(path, Use::Call, see);
            of_given(Some(path), given, see);
        }
        Expr::Literal(_) => {}
    }
}

fn of_given<'p>(
    to: Option<&'p Path>,
    given: &'p [Argument],
    see: &mut dyn FnMut(&'p Path, Use<'p>),
) {
    for one in given {
        let mut value = &one.value;
        if let (true, Expr::Not(inner)) = (one.is_output, value) {
            value = inner;
        }
        match value {
            Expr::Variable(path) => {
                let handed = Use::Handed(one.name.as_deref(), to);
                of_path(path, if one.is_output { Use::Write } else { handed }, see);
            }
            other => of_expr(other, see),
        }
    }
}

fn of_path<'p>(path: &'p Path, used: Use<'p>, see: &mut dyn FnMut(&'p Path, Use<'p>)) {
    see(path, used);
    for part in &path.rest {
        if let Part::Index(all) = part {
            all.iter().for_each(|one| of_expr(one, see));
        }
    }
}

/// The names of a path.
fn names(path: &Path) -> impl DoubleEndedIterator<Item = &str> {
    let parts = path.rest.iter().filter_map(|part| match part {
        Part::Name(name) => Some(name.as_str()),
        _ => None,
    });
    std::iter::once(path.first.as_str()).chain(parts)
}

/// A path without THIS or SUPER in front of it.
fn without_this(path: &Path) -> Path {
    let is_name = |part: &Part| matches!(part, Part::Name(_));
    match path.rest.iter().position(is_name).map(|at| path.rest.split_at(at)) {
        Some((_, [Part::Name(first), rest @ ..]))
            if ["THIS", "SUPER"].iter().any(|own| same(own, &path.first)) =>
        {
            Path { first: first.clone(), rest: rest.to_vec() }
        }
        _ => path.clone(),
    }
}

/// Whether two paths mean the same variable.
pub(super) fn alike(one: &Path, other: &Path) -> bool {
    let part = |(one, other): (&Part, &Part)| match (one, other) {
        (Part::Name(one), Part::Name(other)) => same(one, other),
        (one, other) => one == other,
    };
    same(&one.first, &other.first)
        && one.rest.len() == other.rest.len()
        && one.rest.iter().zip(&other.rest).all(part)
}

/// Whether two paths may mean the same variable, or one a part of the other: any two indices may be the same.
pub(super) fn overlap(one: &Path, other: &Path) -> bool {
    let (one, other) = (without_this(one), without_this(other));
    if same(&one.first, "THIS") || same(&other.first, "THIS") {
        return true;
    }
    let parts = |path: &Path| -> Vec<Part> {
        path.rest.iter().filter(|part| !matches!(part, Part::Bit(_))).cloned().collect()
    };
    let (parts, others) = (parts(&one), parts(&other));
    same(&one.first, &other.first)
        && parts.iter().zip(&others).all(|pair| match pair {
            (Part::Name(one), Part::Name(other)) => same(one, other),
            _ => true,
        })
}

fn declares(variables: &[Variable], name: &str) -> bool {
    let is_own = |one: &Variable| one.section != Section::External;
    variables.iter().any(|one| is_own(one) && same(&one.name, name))
}

impl Emit<'_> {
    /// Whether statements, or what they call, may write a variable.
    pub(super) fn may_write(&self, at: &Context, body: &[Statement], variable: &Path) -> bool {
        self.is_reference_at(at, &without_this(variable))
            || self.may_write_itself(at, body, variable)
    }

    /// The same of a variable that is no reference, or of the word that a reference is: not of what it means.
    pub(super) fn may_write_itself(
        &self,
        at: &Context,
        body: &[Statement],
        variable: &Path,
    ) -> bool {
        let variable = &without_this(variable);
        // Which element an index means may change.
        if variable.rest.iter().any(|part| matches!(part, Part::Index(_) | Part::Dereference)) {
            return true;
        }
        let is_taken = self.is_taken_at(at, variable);
        let (mut writes, mut called) = (self.writes_beside(body, variable), false);
        paths(Code::Statements(body), &mut |path, used| {
            writes |= is_taken && self.changes(used) && self.is_referring(path);
            called |= names_property(self.project, path);
            writes |= self.changes(used) && overlap(path, variable);
            // An instance writes its own variables.
            let is_owner = same(&path.first, &variable.first) && !variable.rest.is_empty();
            writes |= used == Use::Call && is_owner;
        });
        scanbound_iec::ast::visit(body, &mut |one| {
            called |= matches!(one.kind, Statements::Call(..) | Statements::CallIf(..));
            expressions(one, &mut |expr| called |= calls(self.project, expr));
        });
        if writes {
            return true;
        }
        let is_local =
            at.locals.as_ref().is_some_and(|place| Self::part(place, &variable.first).is_some());
        // What is a routine's own, nothing that it calls can reach, unless its address is taken.
        if !called || (is_local && !is_taken) {
            return false;
        }
        let own = lineage(self.project, self.instances[at.instance].pou);
        let is_own = own.iter().any(|pou| declares(&pou.variables, &variable.first));
        let named = self.named_from(body);
        self.callable(&named).any(|pou| {
            // Nothing that is called carries out the body of the same instance. Its own actions and methods name the variable
            // as it does, other units through its instance.
            // But that of a unit which its own extends (`SUPER^()`).
            let related = own.iter().any(|one| same(&one.name, &pou.name));
            let is_first = own.first().is_some_and(|one| same(&one.name, &pou.name));
            let by_name = related || !is_own;
            code_with(pou, !is_first, &named).into_iter().any(|(code, hidden)| {
                let mut found = false;
                paths(code, &mut |path, used| {
                    let part = |name: &str| names(path).skip(1).any(|one| same(one, name));
                    // What a method declares itself is no variable of another's.
                    let is_hidden = declares(hidden, &path.first);
                    let reaches = (by_name && !is_hidden && overlap(path, variable))
                        || (is_taken && self.is_referring(path))
                        || names(variable).any(part)
                        || names(variable).skip(1).any(|name| same(&path.first, name));
                    found |= self.changes(used) && reaches;
                });
                found
            })
        })
    }

    /// All names, in capitals, that statements name, and what they may call, and so on: a method that nothing of these names is
    /// not carried out.
    fn named_from(&self, body: &[Statement]) -> BTreeSet<String> {
        let mut named = BTreeSet::new();
        let take = |code: Code<'_>, named: &mut BTreeSet<String>| {
            paths(code, &mut |path, _| {
                named.extend(names(path).map(str::to_ascii_uppercase));
            });
        };
        take(Code::Statements(body), &mut named);
        loop {
            let before = named.len();
            let known = named.clone();
            for pou in self.callable(&known) {
                for (code, _) in code_with(pou, true, &known) {
                    take(code, &mut named);
                }
            }
            if named.len() == before {
                return named;
            }
        }
    }

    /// The units of which something may be carried out where these names are named: of a program, only by its own name, or that
    /// of one of its actions, methods or named transitions.
    fn callable<'a>(&'a self, named: &'a BTreeSet<String>) -> impl Iterator<Item = &'a Pou> {
        self.project.pous.iter().filter(|pou| {
            let has = |name: &str| named.contains(&name.to_ascii_uppercase());
            let mut parts = pou.actions.iter().chain(&pou.transitions);
            pou.kind != PouKind::Program
                || has(&pou.name)
                || parts.any(|one| has(&one.name))
                || pou.methods.iter().any(|method| is_named(method, named))
        })
    }

    /// Whether what an expression calls may write anything that outlasts the call.
    pub(super) fn acts(&self, expr: &Expr) -> bool {
        let mut open: Vec<&Pou> = Vec::new();
        let mut acts = false;
        let project = self.project;
        let called = |path: &Path| -> Vec<&Pou> {
            let last = names(path).next_back().unwrap_or_default();
            let units = project.pous.iter().filter(|pou| pou.kind == PouKind::Function);
            let methods = project.pous.iter().flat_map(|pou| &pou.methods);
            units.chain(methods).filter(|pou| same(&pou.name, last)).collect()
        };
        let accessors = |path: &Path| -> Vec<&Pou> {
            let methods = project.pous.iter().flat_map(|pou| &pou.methods);
            let is = |one: &&Pou| {
                one.property().is_some_and(|own| names(path).any(|name| same(name, own)))
            };
            methods.filter(is).collect()
        };
        let hands = |used: Use<'_>| match used {
            Use::Handed(name, Some(to)) => {
                let both = |one: &&Variable| {
                    one.section == Section::InOut && name.is_none_or(|name| same(name, &one.name))
                };
                called(to).iter().any(|pou| pou.variables.iter().any(|one| both(&one)))
            }
            used => self.changes(used),
        };
        of_expr(expr, &mut |path, used| {
            open.extend(accessors(path));
            match used {
                Use::Call => open.extend(called(path)),
                used => acts |= hands(used),
            }
        });
        let mut seen: Vec<&Pou> = Vec::new();
        while let (Some(pou), false) = (open.pop(), acts) {
            if seen.iter().any(|own| std::ptr::eq(*own, pou)) {
                continue;
            }
            seen.push(pou);
            // Its own variables begin anew with every call.
            let is_own = |path: &Path| {
                let mut own = pou.variables.iter().filter(|one| same(&one.name, &path.first));
                own.next().map_or(same(pou.result_name(), &path.first), |one| {
                    !matches!(one.section, Section::External | Section::InOut)
                }) && !self.is_referring(path)
            };
            for code in code(pou, true) {
                paths(code, &mut |path, _| open.extend(accessors(path)));
                paths(code, &mut |path, used| match used {
                    Use::Call => {
                        let more = called(path);
                        // What is no function is an instance, which has variables that last, or an action.
                        let is_standard = more.is_empty() && !self.is_declared(pou, path);
                        acts |= more.is_empty() && !is_standard;
                        open.extend(more);
                    }
                    used => acts |= hands(used) && !is_own(path),
                });
            }
        }
        acts
    }

    /// Whether a path may lead through a reference, a pointer or an interface: one of its names is that of one somewhere.
    pub(super) fn is_referring(&self, path: &Path) -> bool {
        self.references.has_any()
            && (path.rest.contains(&Part::Dereference) && !same(&path.first, "THIS")
                || names(path).any(|name| self.is_reference_name(name)))
    }

    /// Whether an address is taken by which a variable can be reached: its own, that of a part, or of what it stands in.
    fn is_taken_at(&self, at: &Context, variable: &Path) -> bool {
        let is_local =
            at.locals.as_ref().is_some_and(|place| Self::part(place, &variable.first).is_some());
        let owner = &self.instances[at.instance].place.name;
        self.is_taken(names(variable)) || (!is_local && self.is_taken_around(owner))
    }

    /// The same of a path in code of an instance, which knows its own variables.
    fn is_reference_at(&self, at: &Context, path: &Path) -> bool {
        let own = at.locals.as_ref().and_then(|place| Self::part(place, &path.first));
        let own = own.or_else(|| Self::part(&self.instances[at.instance].place, &path.first));
        match own {
            Some(place) if path.rest.is_empty() => {
                matches!(place.ty, super::types::Ty::Reference(..))
            }
            _ => self.is_referring(path),
        }
    }

    fn is_reference_name(&self, name: &str) -> bool {
        let methods = || self.project.pous.iter().flat_map(|pou| &pou.methods);
        let units = self.project.pous.iter().chain(methods());
        let parts = self.project.types.iter().filter_map(|one| match &one.of {
            TypeRef::Struct(parts) => Some(parts),
            _ => None,
        });
        let globals = self.project.globals.iter().map(|(_, list)| list);
        let mut all = units.map(|pou| &pou.variables).chain(parts).chain(globals).flatten();
        let named = |one: &Variable| same(&one.name, name);
        all.any(|one| named(one) && super::refer::is_reference(self.project, &one.of))
            || methods().any(|one| {
                let is = |of| super::refer::is_reference(self.project, of);
                same(one.result_name(), name) && one.result.as_ref().is_some_and(is)
            })
    }

    /// Whether a unit knows a variable, an action or a program by the first name of a path.
    fn is_declared(&self, pou: &Pou, path: &Path) -> bool {
        let is = |one: &Variable| same(&one.name, &path.first);
        let globals = self.project.globals.iter().flat_map(|(_, all)| all);
        let units = self.project.pous.iter().flat_map(|pou| &pou.variables);
        let actions = self.project.pous.iter().flat_map(|pou| &pou.actions);
        !path.rest.is_empty()
            || pou.variables.iter().chain(globals).chain(units).any(is)
            || { actions }.any(|one| same(&one.name, &path.first))
            || self.project.pous.iter().any(|one| same(&one.name, &path.first))
    }

    /// Whether it makes a difference which of two expressions is worked out first.
    pub(super) fn order_matters(&self, at: &Context, one: &Expr, other: &Expr) -> bool {
        let changes = |by: &Expr, of: &Expr| {
            if !self.calls_own(by) || !self.acts(by) {
                return false;
            }
            let calls = [Statement { line: 0, kind: Statements::Return(by.clone()) }];
            let mut found = self.calls_own(of);
            variables(of, &mut |path| found = found || self.may_write(at, &calls, path));
            found
        };
        changes(one, other) || changes(other, one)
    }

    /// Whether a variable has an address, and statements write another that has one, or call what may: both may share memory.
    fn writes_beside(&self, body: &[Statement], variable: &Path) -> bool {
        if !self.has_address(&variable.first) {
            return false;
        }
        let mut found = false;
        paths(Code::Statements(body), &mut |path, used| {
            let other = !alike(path, variable) && self.has_address(&path.first);
            found |= self.changes(used) && other;
        });
        scanbound_iec::ast::visit(body, &mut |one| {
            found |= matches!(one.kind, Statements::Call(..) | Statements::CallIf(..));
            expressions(one, &mut |expr| found |= calls(self.project, expr));
        });
        found
    }

    fn has_address(&self, name: &str) -> bool {
        let globals = self.project.globals.iter().flat_map(|(_, list)| list);
        let own = self.project.pous.iter().flat_map(|pou| &pou.variables);
        let is = |one: &Variable| one.at.is_some() && same(&one.name, name);
        name.starts_with('%') || globals.chain(own).any(is)
    }

    /// Whether what a path is for may change what it means.
    fn changes(&self, used: Use<'_>) -> bool {
        match used {
            Use::Write => true,
            Use::Handed(name, to) => {
                // The standard's functions change nothing that they are handed.
                let of_project = to.and_then(|to| names(to).next_back()).is_none_or(|to| {
                    let mut units = self.project.pous.iter();
                    let is = |one: &Pou| same(&one.name, to);
                    units.any(|one| is(one) || one.methods.iter().any(is))
                });
                if !of_project {
                    return false;
                }
                let mut in_out = self.project.pous.iter().flat_map(|pou| {
                    let methods = pou.methods.iter().flat_map(|method| &method.variables);
                    let all = pou.variables.iter().chain(methods);
                    all.filter(|one| one.section == Section::InOut)
                });
                in_out.any(|one| name.is_none_or(|name| same(name, &one.name)))
            }
            Use::Read | Use::Call => false,
        }
    }

    /// Whether an expression names a variable, by whichever name.
    pub(super) fn names_own(
        &mut self,
        at: &Context,
        expr: &Expr,
        variable: &Path,
        line: u32,
    ) -> Result<bool, Fault> {
        let place = |found| match found {
            Found::Place(place) => place.tag.regions(),
            Found::Element(element) => element.whole.tag.regions(),
            _ => Vec::new(),
        };
        let own = place(self.find(at, variable, line)?);
        let mut named: Vec<Path> = Vec::new();
        variables(expr, &mut |path| named.push(path.clone()));
        for path in named {
            if self.has_address(&variable.first) && self.has_address(&path.first) {
                return Ok(true);
            }
            let other = place(self.find(at, &path, line)?);
            if other.iter().any(|one| own.iter().any(|own| flow::overlap(*one, *own))) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether a unit that is called (or a program of another task, too, if they are asked for) may reach a variable by another
    /// name than the one that it has here.
    pub(super) fn is_reached(&self, at: &Context, path: &Path, by_programs: bool) -> bool {
        let path = without_this(path);
        if self.is_referring(&path) || self.is_taken_at(at, &path) {
            return true;
        }
        let pou = &self.project.pous[self.instances[at.instance].pou];
        let own = lineage(self.project, self.instances[at.instance].pou);
        let is_local =
            at.locals.as_ref().is_some_and(|place| Self::part(place, &path.first).is_some());
        if is_local || (pou.kind == PouKind::Function && declares(&pou.variables, &path.first)) {
            return false;
        }
        let others = || {
            self.project.pous.iter().filter(|pou| {
                (by_programs || pou.kind != PouKind::Program)
                    && !own.iter().any(|one| same(&one.name, &pou.name))
            })
        };
        // Whether code of another unit has a path of some kind.
        let any = |is_it: &dyn Fn(&Pou, &Path, Use<'_>) -> bool| {
            others().any(|pou| {
                code(pou, true).into_iter().any(|code| {
                    let mut found = false;
                    paths(code, &mut |path, used| found |= is_it(pou, path, used));
                    found
                })
            })
        };
        // The instance as a whole.
        if same(&path.first, "THIS") {
            return any(&|other, reached, _| {
                !declares(&other.variables, &reached.first) && self.leads_to(&reached.first, pou)
            });
        }
        // Actions and methods of the unit's own that others can call.
        let routines: Vec<&str> = own
            .iter()
            .flat_map(|pou| {
                let actions = pou.actions.iter().map(|one| one.name.as_str());
                actions.chain(pou.methods.iter().map(scanbound_iec::Pou::result_name))
            })
            .collect();
        let is_routine = |path: &Path| {
            names(path).next_back().is_some_and(|last| routines.iter().any(|one| same(one, last)))
        };
        if own.iter().any(|pou| declares(&pou.variables, &path.first)) {
            return any(&|other, reached, used| {
                let hides = declares(&other.variables, &reached.first);
                !hides
                    && self.leads_to(&reached.first, pou)
                    && (used == Use::Call
                        || is_routine(reached)
                        || names(reached).any(|name| same(name, &path.first))
                        || self.is_instance(names(reached).next_back(), pou))
            });
        }
        // A list of globals may stand before the name.
        let last = names(&path).nth(1);
        let is_it =
            |name: &str| same(name, &path.first) || last.is_some_and(|last| same(last, name));
        others().any(|pou| {
            let is_external = |one: &Variable| one.section == Section::External;
            pou.variables.iter().any(|one| is_external(one) && same(&one.name, &path.first))
        }) || any(&|other, reached, used| {
            (!declares(&other.variables, &path.first) && names(reached).any(is_it))
                || (used == Use::Call && reached.rest.iter().any(is_name) && is_routine(reached))
        })
    }

    /// Whether a name that all units may use leads to an instance of a unit: a global variable, a list of these, or a program.
    fn leads_to(&self, name: &str, pou: &Pou) -> bool {
        let globals = self.project.globals.iter().any(|(list, all)| {
            let named = |one: &&Variable| same(list, name) || same(&one.name, name);
            all.iter().filter(named).any(|one| self.contains(&one.of, pou, 0))
        });
        let instances = self.project.tasks.iter().flat_map(|task| &task.instances);
        let mut programs = instances
            .filter(|(own, of)| same(own, name) || same(of, name))
            .map(|(_, of)| of.as_str())
            .chain([name]);
        globals
            || programs.any(|of| {
                let program = self.project.pou(of).filter(|one| one.kind == PouKind::Program);
                program.is_some_and(|one| {
                    same(&one.name, &pou.name)
                        || one.variables.iter().any(|one| self.contains(&one.of, pou, 0))
                })
            })
    }

    /// Whether a variable of this name, of whichever unit or structure, is or has an instance of a unit, or the name means one.
    fn is_instance(&self, name: Option<&str>, pou: &Pou) -> bool {
        let Some(name) = name else { return false };
        let units = self.project.pous.iter().flat_map(|pou| &pou.variables);
        let parts = self.project.types.iter().filter_map(|one| match &one.of {
            TypeRef::Struct(parts) => Some(parts),
            _ => None,
        });
        let mut all = units.chain(parts.flatten());
        self.leads_to(name, pou)
            || all.any(|one| same(&one.name, name) && self.contains(&one.of, pou, 0))
    }

    /// Whether a type is that of a unit, or has an instance of it.
    fn contains(&self, of: &TypeRef, pou: &Pou, depth: u32) -> bool {
        let within =
            |all: &[Variable]| all.iter().any(|one| self.contains(&one.of, pou, depth + 1));
        match of {
            // Types that stand in each other without an end are told elsewhere.
            _ if depth > 40 => false,
            TypeRef::Array(_, of) => self.contains(of, pou, depth + 1),
            TypeRef::Struct(parts) => within(parts),
            TypeRef::Named(name) => {
                let own = self.project.types.iter().find(|one| same(&one.name, name));
                let block = self.project.pous.iter().position(|one| same(&one.name, name));
                let all = block.map(|at| lineage(self.project, at)).unwrap_or_default();
                own.is_some_and(|own| self.contains(&own.of, pou, depth + 1))
                    || all.iter().any(|one| same(&one.name, &pou.name) || within(&one.variables))
            }
            _ => false,
        }
    }
}

fn is_name(part: &Part) -> bool {
    matches!(part, Part::Name(_))
}

/// The expressions of a statement, but for those of statements in it.
fn expressions(one: &Statement, see: &mut dyn FnMut(&Expr)) {
    let mut given = |all: &[Argument]| all.iter().for_each(|one| see(&one.value));
    match &one.kind {
        Statements::Call(_, all) => given(all),
        Statements::CallIf(condition, _, all) => {
            given(all);
            see(condition);
        }
        Statements::Assign(_, value)
        | Statements::Refer(_, value)
        | Statements::Latch(_, _, value) => see(value),
        Statements::If(arms, _) => arms.iter().for_each(|(condition, _)| see(condition)),
        Statements::Case(of, ..) => see(of),
        Statements::For(_, from, to, by, _) => {
            [Some(from), Some(to), by.as_ref()].into_iter().flatten().for_each(see);
        }
        Statements::While(condition, _)
        | Statements::Repeat(_, condition)
        | Statements::Return(condition)
        | Statements::Jump(condition, _) => see(condition),
        _ => {}
    }
}

//! References, pointers and interfaces: a word that says which of the variables is meant whose address the project takes.
//!
//! Which these are is known when all of a project is put together, so that is done until no more are found. What is done
//! through a reference is done to each of them that it can mean, behind a test of the word; if there is one, without a test.

use super::emit::{Emit, Place};
use super::references::{Referred, WORD, Walk, Way};
use super::resolve::{Context, Found};
use super::types::{DINT, Refers, Ty, lineage, same_type};
use super::value::{Value, constant};
use scanbound_base::code::Code;
use scanbound_iec::ast::{Expr, Literal, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, Project, Section, TypeRef, Variable, same, show};
use scanbound_ir::errors::is_outside;
use scanbound_ir::{Compare, Logic, Number, NumberFormat, Relation};

/// More variables than this, one reference is not taken to mean.
const MOST: usize = 64;

/// Whether a project has references, pointers or interfaces.
pub(super) fn has_any(project: &Project) -> bool {
    let methods = project.pous.iter().flat_map(|pou| &pou.methods);
    let units = || project.pous.iter().chain(methods.clone());
    let variables = units().flat_map(|pou| &pou.variables);
    let globals = project.globals.iter().flat_map(|(_, list)| list);
    variables.chain(globals).any(|one| is_reference(project, &one.of))
        || units().filter_map(|pou| pou.result.as_ref()).any(|of| is_reference(project, of))
        || project.types.iter().any(|one| is_reference(project, &one.of))
}

/// Whether a type is that of references, or holds some.
pub(super) fn is_reference(project: &Project, of: &TypeRef) -> bool {
    match of {
        TypeRef::Pointer(_) | TypeRef::Reference(_) => true,
        TypeRef::Array(_, of) => is_reference(project, of),
        TypeRef::Struct(parts) => parts.iter().any(|one| is_reference(project, &one.of)),
        TypeRef::Named(name) => {
            project.pous.iter().any(|pou| pou.kind == PouKind::Interface && same(&pou.name, name))
        }
        _ => false,
    }
}

/// Whether a block implements an interface.
pub(super) fn implements(project: &Project, pou: usize, interface: &str) -> bool {
    fn is_of(project: &Project, own: &str, interface: &str, depth: u32) -> bool {
        same(own, interface)
            || depth < 40
                && project.pou(own).is_some_and(|one| {
                    { &one.implements }
                        .iter()
                        .any(|more| is_of(project, more, interface, depth + 1))
                })
    }
    let all = lineage(project, pou).into_iter().flat_map(|one| &one.implements);
    { all }.any(|own| is_of(project, own, interface, 0))
}

fn not_followed(line: u32, what: String) -> Fault {
    let help = "let it refer to variables of its own type, which the project names (ADR, REF=)";
    Fault::new(line, what).code(Code::NotModelled).help(help)
}

/// The fault that a value may change which variable something means before it is used.
pub(super) fn moves(line: u32, what: &str) -> Fault {
    let what = format!("which variable {what} means may change while the value is worked out");
    let help = "assign the value to a variable of its own before";
    Fault::new(line, what).code(Code::NotModelled).help(help)
}

/// The word of the target of this index.
fn word(index: usize) -> i64 {
    i64::try_from(index + 1).unwrap_or(i64::MAX)
}

impl Emit<'_> {
    /// Whether a reference of a type can mean a variable.
    fn can_mean(&mut self, kind: Refers, of: &TypeRef, place: &Place) -> bool {
        match (kind, of, &place.ty) {
            (Refers::Interface, TypeRef::Named(name), Ty::Block(pou, _)) => {
                implements(self.project, *pou, name)
            }
            (Refers::Interface, ..) => false,
            _ => match (self.types.resolve(of, 0), &place.ty) {
                (Ok(Ty::Block(base, _)), Ty::Block(own, _)) => {
                    let base = &self.project.pous[base];
                    lineage(self.project, *own).into_iter().any(|one| std::ptr::eq(one, base))
                }
                (Ok(ty), own) => same_type(&ty, own),
                (Err(_), _) => false,
            },
        }
    }

    /// The indices of the variables that a reference of a type can mean.
    pub(super) fn candidates(&mut self, kind: Refers, of: &TypeRef) -> Vec<usize> {
        let targets = self.references.targets.clone();
        let each = targets.iter().enumerate();
        each.filter(|(_, place)| self.can_mean(kind, of, place)).map(|(at, _)| at).collect()
    }

    /// Whether the address of something is taken whose place has one of these names.
    pub(super) fn is_taken<'n>(&self, mut names: impl Iterator<Item = &'n str>) -> bool {
        let targets = &self.references.targets;
        names.any(|name| {
            let has = |place: &Place| {
                place.name.split(['.', '[', ']', '(', ')', ':']).any(|part| same(part, name))
            };
            targets.iter().any(has)
        })
    }

    /// Whether the address of an instance of this place's name is taken, or of what it stands in.
    pub(super) fn is_taken_around(&self, owner: &str) -> bool {
        self.references.targets.iter().any(|place| {
            let begins = owner.get(..place.name.len()).is_some_and(|own| same(own, &place.name));
            let rest = owner.get(place.name.len()..).unwrap_or_default();
            begins && (rest.is_empty() || rest.starts_with(['.', '[']))
        })
    }

    /// The variable of this index whose address is taken.
    pub(super) fn target_at(&self, index: usize) -> Place {
        self.references.targets[index].clone()
    }

    fn target(&mut self, place: &Place) -> usize {
        let key = place.name.to_ascii_uppercase();
        if let Some(&known) = self.references.numbers.get(&key) {
            return known;
        }
        self.references.targets.push(place.clone());
        let at = self.references.targets.len() - 1;
        self.references.numbers.insert(key, at);
        at
    }

    /// What stands in a place, references among it.
    pub(super) fn read_of(&mut self, cell: scanbound_ir::Cell, ty: &Ty) -> Value {
        match ty {
            Ty::Reference(kind, of) => {
                let can = self.candidates(*kind, of);
                let words = vec![scanbound_ir::WordSource::Cell(cell)];
                Value::Address(Number::Words(words), can)
            }
            ty => self.as_count(Some(cell), super::expr::read(cell, ty)),
        }
    }

    /// The word of a reference that is to become what an expression says.
    pub(super) fn address(
        &mut self,
        at: &Context,
        expr: &Expr,
        kind: Refers,
        line: u32,
    ) -> Result<Value, Fault> {
        let path = match expr {
            Expr::Literal(Literal::Int(0, _)) => return Ok(Value::Constant(0)),
            Expr::Variable(path) => path,
            Expr::Call(..) => return self.open_value(at, expr, line),
            _ => {
                let what = format!("what {} refers to is not followed", show::expr(expr));
                return Err(not_followed(line, what));
            }
        };
        if path.as_name().is_some_and(|name| same(name, "NULL")) {
            return Ok(Value::Constant(0));
        }
        let is_this =
            same(&path.first, "THIS") && path.rest.iter().all(|p| *p == Part::Dereference);
        if is_this {
            let place = self.instances[at.instance].place.clone();
            self.is_no_copy(&place, line)?;
            let index = self.target(&place);
            return Ok(Value::Address(constant(word(index), 1), vec![index]));
        }
        match self.walk(at, path, false) {
            Walk::Way(Way::Referred(way)) => self.each_target(at, &way, line, &mut |emit, path| {
                emit.address(at, &Expr::Variable(path), kind, line)
            }),
            Walk::Way(Way::Property(property)) => {
                self.through_property(at, &property, line, &mut |emit, path| {
                    emit.address(at, &Expr::Variable(path), kind, line)
                })
            }
            Walk::Type(Ty::Reference(..)) => {
                let found = self.find_plain(at, path, line)?;
                self.cost(&["LD"], "contact");
                let value = match found {
                    Found::Place(place) => {
                        place.tag.cell().map(|cell| self.read_of(cell, &place.ty))
                    }
                    Found::Element(element) => Some(self.element(&element)),
                    _ => None,
                };
                let what = || not_followed(line, format!("{} is not followed", show::path(path)));
                value.ok_or_else(what)
            }
            _ if kind == Refers::Pointer && !path.first.starts_with('^') => {
                let what = format!("{} is no address that is followed", show::path(path));
                Err(not_followed(line, what))
            }
            _ => self.address_of(at, path, line),
        }
    }

    /// The address of a variable.
    pub(super) fn address_of(
        &mut self,
        at: &Context,
        path: &Path,
        line: u32,
    ) -> Result<Value, Fault> {
        match self.walk(at, path, true) {
            Walk::Way(Way::Referred(way)) => {
                return self.each_target(at, &way, line, &mut |emit, path| {
                    emit.address_of(at, &path, line)
                });
            }
            Walk::Way(Way::Property(_)) => {
                let what = format!("{} is a property and has no address", show::path(path));
                return Err(not_followed(line, what));
            }
            _ => {}
        }
        match self.find_plain(at, path, line)? {
            Found::Place(place) => {
                self.is_no_copy(&place, line)?;
                let index = self.target(&place);
                Ok(Value::Address(constant(word(index), 1), vec![index]))
            }
            Found::Element(element) => {
                let what = format!("the address of {} is not followed", show::path(path));
                let place = element.whole.clone();
                let Ty::Array { dimensions, .. } = &place.ty else {
                    return Err(not_followed(line, what));
                };
                let ([(low, high)], Some(Part::Index(indices))) =
                    (&dimensions[..], path.rest.last())
                else {
                    return Err(not_followed(line, what));
                };
                let ([index], (low, high)) = (&indices[..], (*low, *high)) else {
                    return Err(not_followed(line, what));
                };
                if usize::try_from(high - low).is_ok_and(|many| many >= MOST) {
                    return Err(not_followed(line, what));
                }
                let value = self.number(at, index, DINT, line)?;
                let words = self.copies(value, DINT);
                let mut known = None;
                let mut ends = Vec::new();
                for number in low..=high {
                    let mut one = path.clone();
                    one.rest.pop();
                    let literal = Expr::Literal(Literal::Int(number.into(), None));
                    one.rest.push(Part::Index(vec![literal]));
                    let skip = (number < high).then(|| self.unless(&words, number, 2));
                    let found = self.address_of(at, &one, line)?;
                    known = Some(self.gathered(known, found));
                    self.past(skip, &mut ends);
                }
                self.all_land(ends);
                Ok(known.unwrap_or(Value::Any))
            }
            _ => Err(not_followed(line, format!("{} has no address", show::path(path)))),
        }
    }

    /// Refuses the address of what is handed over in and out, or stands in that: it is followed as a copy.
    fn is_no_copy(&self, place: &Place, line: u32) -> Result<(), Fault> {
        let name = place.name.to_ascii_uppercase();
        let is_copy = name.match_indices('.').any(|(at, _)| {
            let rest = &name[at + 1..];
            let part = rest.split(['.', '[']).next().unwrap_or_default();
            let is_own = |one: &Variable| one.section == Section::InOut && same(&one.name, part);
            // What stands before it is an instance, or a method of one.
            let owner = &name[..at];
            let unit = |name: &str| {
                let own = self.by_name.get(name).map(|&own| self.instances[own].pou);
                own.map(|own| lineage(self.project, own)).unwrap_or_default()
            };
            let of_method = owner.strip_suffix("()").and_then(|rest| rest.rsplit_once('.'));
            match of_method {
                Some((instance, _)) => {
                    let all = unit(instance).into_iter().flat_map(|pou| &pou.methods);
                    { all }.any(|method| method.variables.iter().any(is_own))
                }
                None => unit(owner).into_iter().any(|pou| pou.variables.iter().any(is_own)),
            }
        });
        if !is_copy {
            return Ok(());
        }
        let what = format!(
            "the address of {} is taken, which is handed over in and out: not followed",
            place.name
        );
        let help = "hand over a reference or a pointer instead of VAR_IN_OUT";
        Err(Fault::new(line, what).code(Code::NotModelled).help(help))
    }

    /// A jump over what is for one number alone.
    fn unless(&mut self, words: &[scanbound_ir::WordSource], number: i64, size: u32) -> usize {
        self.jump(is_number(words, number, size).not(), None)
    }

    /// Ends what is for one number alone.
    fn past(&mut self, skip: Option<usize>, ends: &mut Vec<usize>) {
        let Some(skip) = skip else { return };
        ends.push(self.jump(Logic::Const(true), None));
        self.land(skip);
        self.landing();
    }

    fn all_land(&mut self, ends: Vec<usize>) {
        ends.into_iter().for_each(|end| self.land(end));
        self.landing();
    }

    /// A value of one way, with that of the ways before.
    fn gathered(&mut self, known: Option<Value>, value: Value) -> Value {
        match known {
            None => self.stored(value, true),
            Some(known) => self.merged(known, value),
        }
    }

    /// Does something to each variable that a reference can mean, under a name that means it meanwhile; the value that it gives.
    pub(super) fn each_target(
        &mut self,
        at: &Context,
        way: &Referred,
        line: u32,
        act: &mut dyn FnMut(&mut Self, Path) -> Result<Value, Fault>,
    ) -> Result<Value, Fault> {
        if let Some((index, low, high)) = &way.among {
            return self.each_element(at, way, (index, *low, *high), line, act);
        }
        let can = self.candidates(way.kind, &way.of);
        let shown = show::path(&way.before);
        if can.is_empty() {
            if self.references.is_draft {
                return Ok(Value::Any);
            }
            return Err(not_followed(line, format!("nothing says what {shown} refers to")));
        }
        if can.len() > MOST {
            let what = format!("{shown} may refer to {} variables", can.len());
            return Err(not_followed(line, what));
        }
        self.cost(&["LD"], "contact");
        let value = match self.find_plain(at, &way.before, line)? {
            Found::Element(element) => self.element(&element),
            Found::Place(place) => match place.tag.cell() {
                Some(cell) => self.read_of(cell, &place.ty),
                None => Value::Any,
            },
            _ => Value::Any,
        };
        let words = match value {
            Value::Address(number, _) => self.copies(number, WORD),
            // With one variable to mean, nothing but whether it means any hangs on the word.
            _ if can.len() == 1 => {
                self.not_followed_where(Logic::Const(true));
                Vec::new()
            }
            _ => return Err(not_followed(line, format!("{shown} is not followed"))),
        };
        if !words.is_empty() {
            let means = |&index: &usize| is_number(&words, word(index), 1);
            self.not_followed_where(Logic::Any(can.iter().map(means).collect()).not());
        }
        let (mut known, mut ends) = (None, Vec::new());
        for (number, &index) in can.iter().enumerate() {
            let skip = (number + 1 < can.len()).then(|| self.unless(&words, word(index), 1));
            let place = self.references.targets[index].clone();
            let value = self.with_name(place, &shown, |emit, name| {
                act(emit, Path { first: name, rest: way.rest.clone() })
            })?;
            match can.len() {
                1 => known = Some(value),
                _ => known = Some(self.gathered(known, value)),
            }
            self.past(skip, &mut ends);
        }
        if can.len() > 1 {
            self.all_land(ends);
        }
        Ok(known.unwrap_or(Value::Any))
    }

    /// Refuses a value that may change which variable a reference means before that is used.
    pub(super) fn stays(
        &mut self,
        at: &Context,
        way: &Referred,
        value: &Expr,
        line: u32,
    ) -> Result<(), Fault> {
        if way.among.is_none() && self.candidates(way.kind, &way.of).len() < 2 {
            return Ok(());
        }
        let may_change = match &way.among {
            Some((index, ..)) => self.order_matters(at, index, value),
            None => {
                let kind = scanbound_iec::ast::Kind::Return(value.clone());
                let calls = [scanbound_iec::ast::Statement { line, kind }];
                self.calls_own(value)
                    && self.acts(value)
                    && self.may_write_itself(at, &calls, &way.before)
            }
        };
        if may_change { Err(moves(line, &show::path(&way.before))) } else { Ok(()) }
    }

    /// Does something to the instance of an array that has a number which is worked out.
    fn each_element(
        &mut self,
        at: &Context,
        way: &Referred,
        (index, low, high): (&Expr, i64, i64),
        line: u32,
        act: &mut dyn FnMut(&mut Self, Path) -> Result<Value, Fault>,
    ) -> Result<Value, Fault> {
        if usize::try_from(high - low).is_ok_and(|many| many >= MOST) {
            let what = format!("{} may mean {} instances", show::path(&way.before), high - low + 1);
            return Err(not_followed(line, what));
        }
        let number = self.number(at, index, DINT, line)?;
        let words = self.copies(number, DINT);
        self.not_followed_where(is_outside(&Number::Words(words.clone()), low, high));
        let (mut known, mut ends) = (None, Vec::new());
        for number in low..=high {
            let skip = (number < high).then(|| self.unless(&words, number, 2));
            let mut path = way.before.clone();
            path.rest.push(Part::Index(vec![Expr::Literal(Literal::Int(number.into(), None))]));
            path.rest.extend(way.rest.iter().cloned());
            let value = act(self, path)?;
            known = Some(self.gathered(known, value));
            self.past(skip, &mut ends);
        }
        self.all_land(ends);
        Ok(known.unwrap_or(Value::Any))
    }

    /// Does something while a name of its own means a variable.
    pub(super) fn with_name<T>(
        &mut self,
        place: Place,
        shown: &str,
        act: impl FnOnce(&mut Self, String) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        self.references.next += 1;
        let name = format!("^{}", self.references.next);
        self.references.bound.insert(name.clone(), place);
        let found = act(self, name.clone());
        self.references.bound.remove(&name);
        found.map_err(|mut fault| {
            fault.message = fault.message.replace(&name, &format!("{shown}^"));
            fault
        })
    }

    /// The word that goes into a reference.
    pub(super) fn reference_word(
        &mut self,
        place: &Place,
        value: Value,
        line: u32,
    ) -> Result<Number, Fault> {
        let Ty::Reference(kind, of) = &place.ty else { return Ok(constant(0, 1)) };
        match value {
            Value::Constant(0) => Ok(constant(0, 1)),
            Value::Address(number, from) => {
                let can = self.candidates(*kind, of);
                match from.iter().find(|one| !can.contains(one)) {
                    Some(&other) if !self.references.is_draft => {
                        let other = &self.references.targets[other].name;
                        let what = format!(
                            "{} may refer to {other}, which is of another type",
                            place.name
                        );
                        Err(not_followed(line, what))
                    }
                    _ => Ok(number),
                }
            }
            // Nothing is known yet of what it refers to.
            _ if self.references.is_draft => Ok(constant(0, 1)),
            _ => Err(not_followed(line, format!("what {} refers to is not followed", place.name))),
        }
    }
}

/// Whether words are a number.
fn is_number(words: &[scanbound_ir::WordSource], number: i64, size: u32) -> Logic {
    Logic::Compare(Box::new(Compare {
        relation: Relation::Equal,
        format: if size == 1 { NumberFormat::Unsigned } else { NumberFormat::Signed },
        left: Number::Words(words.to_vec()),
        right: constant(number, size),
    }))
}

//! Where a path leads by its types alone: to a variable, through a reference, or to a property.

use super::emit::{Emit, Place};
use super::references::{Property, Referred, Walk, Way};
use super::resolve::Context;
use super::types::{Refers, Ty, lineage};
use super::value::Value;
use scanbound_base::code::Code;
use scanbound_iec::ast::{Argument, Expr, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{TypeRef, getter, same, setter, show};
use std::sync::Arc;

impl Emit<'_> {
    /// Where a path leads. `to_end`: a reference at its end stands for what it refers to.
    pub(super) fn walk(&mut self, at: &Context, path: &Path, to_end: bool) -> Walk {
        let Some((place, used)) = self.root(at, path) else {
            if !self.has_property(at.unit, &path.first) {
                return Walk::Unknown;
            }
            let (name, rest) = (path.first.clone(), path.rest.clone());
            return Walk::Way(Way::Property(Property { owner: None, base: None, name, rest }));
        };
        let mut unit = match place.ty {
            Ty::Block(pou, _) => Some(pou),
            _ => {
                let own = self.by_name.get(&place.name.to_ascii_uppercase());
                own.map(|&own| self.instances[own].pou)
            }
        };
        let base = same(&path.first, "SUPER").then(|| self.base(at, 0).ok()).flatten();
        let mut ty = place.ty;
        let before = |to: usize| Path { first: path.first.clone(), rest: path.rest[..to].to_vec() };
        for (number, part) in path.rest.iter().enumerate().skip(used) {
            if let Ty::Reference(kind, of) = &ty {
                let is_told = *part == Part::Dereference;
                // A pointer with an index is not followed.
                if *kind == Refers::Pointer && !is_told {
                    return Walk::Unknown;
                }
                return Walk::Way(Way::Referred(Referred {
                    before: before(number),
                    rest: path.rest[number + usize::from(is_told)..].to_vec(),
                    kind: *kind,
                    of: of.clone(),
                    among: None,
                }));
            }
            if let Some(among) = self.among(at, &ty, part, path.rest.get(number + 1)) {
                return Walk::Way(Way::Referred(Referred {
                    before: before(number),
                    rest: path.rest[number + 1..].to_vec(),
                    kind: Refers::Reference,
                    of: Arc::new(TypeRef::Text(None)),
                    among: Some(among),
                }));
            }
            let next = match (&ty, part) {
                (Ty::Block(_, parts) | Ty::Parts(parts), Part::Name(name)) => {
                    let own = parts.named(name).map(|(_, ty)| ty.clone());
                    if own.is_none() && unit.is_some_and(|unit| self.has_property(unit, name)) {
                        return Walk::Way(Way::Property(Property {
                            owner: Some(before(number)),
                            base: base.filter(|_| number == used),
                            name: name.clone(),
                            rest: path.rest[number + 1..].to_vec(),
                        }));
                    }
                    own
                }
                (Ty::Standard(..), Part::Name(name)) => {
                    let whole =
                        Place { ty: ty.clone(), name: String::new(), tag: place.tag.clone() };
                    Self::part_type(&whole, name)
                }
                (Ty::Array { of, .. }, Part::Index(_)) => Some((**of).clone()),
                _ => None,
            };
            let Some(next) = next else { return Walk::Unknown };
            unit = match next {
                Ty::Block(pou, _) => Some(pou),
                _ => None,
            };
            ty = next;
        }
        match ty {
            Ty::Reference(kind @ Refers::Reference, of) if to_end => {
                let (before, rest) = (path.clone(), Vec::new());
                Walk::Way(Way::Referred(Referred { before, rest, kind, of, among: None }))
            }
            ty => Walk::Type(ty),
        }
    }

    /// Of an instance in an array by a number that is worked out, of which a method, a property or an action is meant: the number,
    /// the least and the largest.
    fn among(
        &self,
        at: &Context,
        ty: &Ty,
        part: &Part,
        next: Option<&Part>,
    ) -> Option<(Expr, i64, i64)> {
        let (Ty::Array { dimensions, of }, Part::Index(indices), Some(Part::Name(name))) =
            (ty, part, next)
        else {
            return None;
        };
        let (Ty::Block(_, parts), [(low, high)], [index]) = (&**of, &dimensions[..], &indices[..])
        else {
            return None;
        };
        let is_variable = parts.named(name).is_some();
        let is_known = self.constant(at, index).is_some();
        (!is_variable && !is_known).then(|| (index.clone(), *low, *high))
    }

    /// Whether a path leads, through references or to a property, to what is no structure or array.
    pub(super) fn is_single(&mut self, at: &Context, path: &Path) -> bool {
        let is_one =
            |ty: &Ty| matches!(ty, Ty::Bit | Ty::Number(_) | Ty::Text(_) | Ty::Reference(..));
        match self.walk(at, path, true) {
            Walk::Way(Way::Property(_)) => true,
            Walk::Way(Way::Referred(way)) => {
                let can = self.candidates(way.kind, &way.of);
                if way.among.is_some() {
                    return true;
                }
                let Some(&first) = can.first() else { return true };
                let place = self.target_at(first);
                let found = self.with_name(place, "", |emit, first| {
                    Ok(emit.is_single(at, &Path { first, rest: way.rest }))
                });
                found.unwrap_or(false)
            }
            Walk::Type(ty) => is_one(&ty),
            Walk::Unknown => false,
        }
    }

    /// The variable that a path begins with, and how many of its parts name that.
    fn root(&mut self, at: &Context, path: &Path) -> Option<(Place, usize)> {
        if let Some(place) = self.references.meant(&path.first) {
            return Some((place.clone(), 0));
        }
        if ["THIS", "SUPER"].iter().any(|own| same(own, &path.first)) {
            let is_name = |part: &Part| *part != Part::Dereference;
            let used = path.rest.iter().position(is_name).unwrap_or(path.rest.len());
            return Some((self.instances[at.instance].place.clone(), used));
        }
        if let Some(place) = self.own_variable(at, &path.first) {
            return Some((place, 0));
        }
        // A property hides global variables.
        if self.has_property(at.unit, &path.first) {
            return None;
        }
        if let Some(place) = self.global(None, &path.first) {
            return Some((place, 0));
        }
        if let Some(Part::Name(name)) = path.rest.first() {
            let project = self.project;
            let list = project.globals.iter().find(|(list, all)| {
                same(list, &path.first) && all.iter().any(|one| same(&one.name, name))
            });
            if let Some(place) = list.and_then(|(list, _)| self.global(Some(list), name)) {
                return Some((place, 1));
            }
        }
        self.program_place(&path.first).map(|place| (place, 0))
    }

    pub(super) fn has_property(&self, unit: usize, name: &str) -> bool {
        let mut methods = lineage(self.project, unit).into_iter().flat_map(|pou| &pou.methods);
        self.types.constants.is_property(name)
            && methods.any(|one| one.property().is_some_and(|own| same(own, name)))
    }

    /// The instance that a property belongs to.
    fn owner(&mut self, at: &Context, property: &Property, line: u32) -> Result<usize, Fault> {
        let Some(path) = &property.owner else { return Ok(at.instance) };
        let found = self.find(at, path, line)?;
        self.instance_at(&found).ok_or_else(|| {
            let what = format!("{}.{} is not followed", show::path(path), property.name);
            let help = "choose the instance with CASE, or by a constant index";
            Fault::new(line, what).code(Code::NotModelled).help(help)
        })
    }

    /// The instance of a unit that was found.
    pub(super) fn instance_at(&mut self, found: &super::resolve::Found) -> Option<usize> {
        let super::resolve::Found::Place(place) = found else { return None };
        match place.ty {
            Ty::Block(pou, _) => Some(self.instance(place, pou)),
            _ => self.by_name.get(&place.name.to_ascii_uppercase()).copied(),
        }
    }

    /// What is read of a property, or of what it gives.
    pub(super) fn property_value(
        &mut self,
        at: &Context,
        property: &Property,
        line: u32,
    ) -> Result<Value, Fault> {
        let instance = self.owner(at, property, line)?;
        let name = getter(&property.name);
        let value = self.method_from(at, instance, property.base, &name, &[], line)?;
        if property.rest.is_empty() && !matches!(value, Value::Address(..)) {
            return Ok(value);
        }
        let read = self.through_result(instance, property, line, &mut |emit, path| {
            emit.open_value(at, &Expr::Variable(path), line)
        })?;
        // The next one who reads it writes it anew.
        Ok(self.frozen(read))
    }

    /// Does something to what a property gives.
    pub(super) fn through_property(
        &mut self,
        at: &Context,
        property: &Property,
        line: u32,
        act: &mut dyn FnMut(&mut Self, Path) -> Result<Value, Fault>,
    ) -> Result<Value, Fault> {
        let instance = self.owner(at, property, line)?;
        let name = getter(&property.name);
        self.method_from(at, instance, property.base, &name, &[], line)?;
        self.through_result(instance, property, line, act)
    }

    fn through_result(
        &mut self,
        instance: usize,
        property: &Property,
        line: u32,
        act: &mut dyn FnMut(&mut Self, Path) -> Result<Value, Fault>,
    ) -> Result<Value, Fault> {
        let unknown = || super::resolve::unknown(line, &property.name);
        let place = self.method_place_of(instance, property.base, &getter(&property.name))?;
        let place = Self::part(&place, &property.name).ok_or_else(unknown)?;
        let rest = property.rest.clone();
        self.with_name(place, &property.name, |emit, first| act(emit, Path { first, rest }))
    }

    /// Writes a property.
    pub(super) fn property_written(
        &mut self,
        at: &Context,
        property: &Property,
        value: &Expr,
        line: u32,
    ) -> Result<(), Fault> {
        let instance = self.owner(at, property, line)?;
        let name = Some(property.name.clone());
        let given = Argument { name, is_output: false, value: value.clone() };
        let name = setter(&property.name);
        self.method_from(at, instance, property.base, &name, &[given], line).map(|_| ())
    }
}

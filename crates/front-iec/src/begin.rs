//! What references mean before the first scan: by declarations, and by what FB_Init is handed and does.

use super::emit::{Emit, Instance, Place};
use super::resolve::Context;
use super::types::{Ty, lineage};
use super::within::each_deep;
use scanbound_base::code::Code;
use scanbound_iec::ast::{Argument, Expr, Part, paths_of};
use scanbound_iec::fault::Fault;
use scanbound_iec::parse::{CONSTRUCTED, LISTED, UNREAD};
use scanbound_iec::{Pou, PouKind, TypeRef, Variable, same};
use std::collections::BTreeSet;

/// Larger arrays are not gone through.
const MOST: i64 = 4096;

impl Emit<'_> {
    /// Finds the variables that references mean before the first scan.
    pub(super) fn begin_references(&mut self) {
        let project = self.project;
        let programs: Vec<usize> = (0..self.instances.len())
            .filter(|&one| self.pou_of(one).kind == PouKind::Program)
            .collect();
        for instance in &programs {
            self.begin_instance(*instance, None);
        }
        let Some(&first) = programs.first() else { return };
        // Global variables are declared where no unit's own variables are known.
        let place =
            Place { ty: Ty::Parts(Default::default()), ..self.instances[first].place.clone() };
        let unit = self.instances[first].pou;
        self.instances.push(Instance { pou: unit, place });
        let at = Context { instance: self.instances.len() - 1, locals: None, unit };
        for (list, all) in &project.globals {
            for one in all {
                let Some(place) = self.global(Some(list), &one.name) else { continue };
                let mut initial = one.initial.clone();
                if let Some(initial) = &mut initial {
                    // The list's own variables come first.
                    paths_of(initial, &mut |path| {
                        if !list.is_empty() && all.iter().any(|own| same(&own.name, &path.first)) {
                            let name = std::mem::replace(&mut path.first, list.clone());
                            path.rest.insert(0, Part::Name(name));
                        }
                    });
                }
                self.begins(&at, &place, initial.as_ref(), one.line);
            }
        }
    }

    /// Refuses what begins anew with each call and holds what is not followed then: what references in it mean at first, and
    /// FB_Init, which takes its time in each call.
    pub(super) fn begins_plain(&self, place: &Place, given: bool, line: u32) -> Result<(), Fault> {
        let has_method = |pou: usize| {
            let mut all = lineage(self.project, pou).into_iter().flat_map(|pou| &pou.methods);
            all.any(|one| {
                ["FB_Init", "FB_Reinit", "FB_Exit"].iter().any(|own| same(own, &one.name))
            })
        };
        let mut found = given && has_reference(&place.ty);
        each_block(&place.ty, &mut |pou, ty| found |= has_method(pou) || has_reference(ty));
        if !found || matches!(place.ty, Ty::Reference(..)) {
            return Ok(());
        }
        let what = format!("{} begins anew with each call, which is not followed", place.name);
        let help = "declare it where it lasts: as VAR of a function block or of the program";
        Err(Fault::new(line, what).code(Code::NotModelled).help(help))
    }

    /// Refuses what begins anew with each call and calls something then, unless it is one value that is worked out there.
    pub(super) fn begins_without_call(
        &self,
        one: &Variable,
        ty: &Ty,
        line: u32,
    ) -> Result<(), Fault> {
        let is_single = matches!(ty, Ty::Bit | Ty::Number(_) | Ty::Text(_) | Ty::Reference(..));
        let mut is_open = false;
        if let Some(initial) = one.initial.as_ref().filter(|_| !is_single || one.constant) {
            // Each element of a list takes the time of its value.
            each_deep(initial, &mut |inner| {
                is_open |= match inner {
                    Expr::Call(path, _) => {
                        ![CONSTRUCTED, LISTED, UNREAD].contains(&path.first.as_str())
                    }
                    Expr::Variable(_) => self.types.constant(inner).is_none(),
                    _ => false,
                };
            });
        }
        if !is_open && !self.type_calls(&one.of, &mut BTreeSet::new()) {
            return Ok(());
        }
        let what = format!(
            "{} begins anew with each call, and its initial value is worked out then, which is not followed",
            one.name
        );
        let help = "assign the value in the body";
        Err(Fault::new(line, what).code(Code::NotModelled).help(help))
    }

    /// Whether what a type gives its variables at first calls anything of the project's.
    fn type_calls(&self, of: &TypeRef, seen: &mut BTreeSet<String>) -> bool {
        let calls_own = |one: &Option<Expr>| one.as_ref().is_some_and(|one| self.calls_own(one));
        match of {
            TypeRef::Array(_, of) | TypeRef::Subrange(of, _) => self.type_calls(of, seen),
            TypeRef::Struct(parts) => {
                parts.iter().any(|one| calls_own(&one.initial) || self.type_calls(&one.of, seen))
            }
            TypeRef::Named(name) if seen.insert(name.to_ascii_uppercase()) => {
                let all = &self.project.types;
                let own = all.iter().find(|one| same(&one.name, name));
                let block = |pou: &Pou| pou.kind == PouKind::FunctionBlock && same(&pou.name, name);
                let units = self.project.pous.iter().position(block);
                let units = units.map(|at| lineage(self.project, at)).unwrap_or_default();
                own.is_some_and(|own| calls_own(&own.initial) || self.type_calls(&own.of, seen))
                    || units
                        .iter()
                        .flat_map(|pou| &pou.variables)
                        .any(|one| calls_own(&one.initial) || self.type_calls(&one.of, seen))
            }
            _ => false,
        }
    }

    /// Carries out FB_Init of an instance, and begins with its variables.
    fn begin_instance(&mut self, instance: usize, from: Option<(&Context, &[Argument])>) {
        let place = self.instances[instance].place.clone();
        for unit in lineage(self.project, self.instances[instance].pou) {
            let own = self.project.pous.iter().position(|one| std::ptr::eq(one, unit));
            let at = Context {
                instance,
                locals: None,
                unit: own.unwrap_or(self.instances[instance].pou),
            };
            for one in &unit.variables {
                let Some(part) = Self::part(&place, &one.name) else { continue };
                self.begins(&at, &part, one.initial.as_ref(), one.line);
            }
            for name in ["FB_Init", "FB_Reinit"] {
                let Some(method) = unit.methods.iter().find(|one| same(&one.name, name)) else {
                    continue;
                };
                let (outer, given) = from.unwrap_or((&at, &[]));
                // Each of them takes what it asks for.
                let is_own = |one: &&Argument| {
                    let mut names = method.variables.iter().map(|own| &own.name);
                    names.any(|own| one.name.as_ref().is_some_and(|name| same(name, own)))
                };
                let given: Vec<Argument> = given.iter().filter(is_own).cloned().collect();
                let done = self.method_from(outer, instance, own, name, &given, method.line);
                self.begin_fault(done, unit.file);
            }
        }
    }

    fn begin_fault<T>(&mut self, done: Result<T, Fault>, file: usize) {
        if let Err(fault) = done {
            self.references.faults.push((file, fault));
        }
    }

    /// Begins with a variable.
    fn begins(&mut self, at: &Context, place: &Place, initial: Option<&Expr>, line: u32) {
        let file = self.project.pous[at.unit].file;
        let given = match initial {
            Some(Expr::Call(path, given)) if path.first == CONSTRUCTED || path.first == LISTED => {
                &given[..]
            }
            _ => &[],
        };
        // What cannot be read may say anything.
        let is_unread = matches!(initial, Some(Expr::Call(path, _)) if path.first == UNREAD);
        if is_unread && has_reference(&place.ty) {
            let what = format!("what references in {} mean at first is not followed", place.name);
            let help = "assign them in the program";
            let fault = Fault::new(line, what).code(Code::NotModelled).help(help);
            return self.begin_fault(Err::<(), _>(fault), file);
        }
        match &place.ty {
            Ty::Reference(kind, _) => {
                let Some(initial) = initial else { return };
                let found = self.address(at, initial, *kind, line);
                let found = found.and_then(|value| self.reference_word(place, value, line));
                self.begin_fault(found, file);
            }
            Ty::Block(pou, _) => {
                let instance = self.instance(place, *pou);
                // What is handed over means what it means here.
                for one in given {
                    let Some(name) = &one.name else { continue };
                    if let Some(part) = Self::part(place, name) {
                        self.begins(at, &part, Some(&one.value), line);
                    }
                }
                self.begin_instance(instance, Some((at, given)));
            }
            Ty::Parts(parts) => {
                for (name, _) in parts.iter() {
                    let own = given
                        .iter()
                        .find(|one| one.name.as_ref().is_some_and(|given| same(given, name)));
                    if let Some(part) = Self::part(place, name) {
                        self.begins(at, &part, own.map(|one| &one.value), line);
                    }
                }
            }
            Ty::Array { dimensions, of } if matters(of) => {
                let [(low, high)] = dimensions[..] else {
                    let what = format!("{}: several dimensions of references", place.name);
                    let fault = Fault::new(line, what).code(Code::NotModelled);
                    return self.begin_fault(Err::<(), _>(fault), file);
                };
                if high - low >= MOST {
                    let what = format!("{} is too large to hold references", place.name);
                    let fault = Fault::new(line, what).code(Code::NotModelled);
                    return self.begin_fault(Err::<(), _>(fault), file);
                }
                for (number, index) in (low..=high).enumerate() {
                    let Some(tag) = place.tag.element(index) else { continue };
                    let name = format!("{}[{index}]", place.name);
                    let one = Place { name, tag, ty: (**of).clone() };
                    self.begins(at, &one, given.get(number).map(|one| &one.value), line);
                }
            }
            _ => {}
        }
    }
}

/// Whether a type holds references.
pub(super) fn has_reference(ty: &Ty) -> bool {
    match ty {
        Ty::Reference(..) => true,
        Ty::Array { of, .. } => has_reference(of),
        Ty::Parts(parts) | Ty::Block(_, parts) => parts.iter().any(|(_, ty)| has_reference(ty)),
        _ => false,
    }
}

/// Shows the blocks in a type.
fn each_block(ty: &Ty, see: &mut dyn FnMut(usize, &Ty)) {
    match ty {
        Ty::Array { of, .. } => each_block(of, see),
        Ty::Parts(parts) => parts.iter().for_each(|(_, ty)| each_block(ty, see)),
        Ty::Block(pou, parts) => {
            see(*pou, ty);
            parts.iter().for_each(|(_, ty)| each_block(ty, see));
        }
        _ => {}
    }
}

/// Whether what a variable of a type begins with may say what references mean.
fn matters(ty: &Ty) -> bool {
    match ty {
        Ty::Reference(..) | Ty::Block(..) => true,
        Ty::Array { of, .. } => matters(of),
        Ty::Parts(parts) => parts.iter().any(|(_, ty)| matters(ty)),
        _ => false,
    }
}

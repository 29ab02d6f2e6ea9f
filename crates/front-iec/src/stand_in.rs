//! Blocks, functions and methods of libraries, of which only the declaration is there: the user states what they take, and what they
//! give may be any value.

use super::begin::has_reference;
use super::emit::{Emit, Place, What};
use super::types::lineage;
use scanbound_base::code::Code;
use scanbound_base::facts::{StatedCall, normalized};
use scanbound_base::location::Location;
use scanbound_front::builder::always;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, Pou, PouKind, Section, Variable, same};
use scanbound_ir::{MissingRoutine, Region, Step, Write};

impl<'p> Emit<'p> {
    /// What stands in for a body that is not there, if that is stated of its unit: where it stood, all that it has may hold
    /// anything. Whether that is so.
    pub(super) fn stands_in(&mut self, instance: usize, what: &What) -> bool {
        let Some((pou, stated)) = self.stated_of(instance, what) else { return false };
        self.file = pou.file;
        self.at(pou.line, &stated.name);
        self.landing();
        let entry = match self.all_it_writes(instance, what, pou, &stated) {
            Ok(regions) => {
                let effects = regions.into_iter().map(|region| {
                    let choice = self.builder.choice();
                    always(Write::Havoc(region, choice))
                });
                let effects = effects.collect();
                self.builder.add(None, effects, Step::Nothing)
            }
            Err(fault) => {
                self.faults.push((pou.file, fault));
                self.builder.add(None, Vec::new(), Step::Nothing)
            }
        };
        let why = format!("what {} gives may be any value: only its time is stated", stated.name);
        self.program().approximate(entry, why);
        let (name, time) = (normalized(&stated.name), stated.time);
        self.program().missing_routines.push(MissingRoutine {
            name,
            entry,
            time,
            stated: true,
            declared: true,
        });
        self.builder.add(None, Vec::new(), Step::Return);
        true
    }

    /// Whether a body is not there, and it is stated what it takes.
    pub(super) fn is_stated(&self, instance: usize, what: &What) -> bool {
        self.stated_of(instance, what).is_some()
    }

    /// Takes note of a body that is not there: its code is likely elsewhere.
    pub(super) fn note_bodiless(&mut self, instance: usize, what: &What) {
        let (from, method) = match what {
            What::Body => (self.instances[instance].pou, None),
            What::Method(name) => (self.instances[instance].pou, Some(name)),
            What::Inherited(..) | What::Action(_) => return,
        };
        let units = lineage(self.project, from);
        let is_same = |own: &&Pou, name: &String| same(&own.name, name);
        let pou = match method {
            None => units.first().copied(),
            Some(name) => {
                units.iter().find_map(|unit| unit.methods.iter().find(|own| is_same(own, name)))
            }
        };
        let Some(pou) = pou.filter(|pou| pou.kind != PouKind::Program) else { return };
        let is_empty = |body: &Body| matches!(body, Body::Code(_, all) if all.is_empty());
        let has_code = |unit: &&Pou| {
            let methods = unit.methods.iter().map(|method| &method.body);
            let actions = unit.actions.iter().map(|action| &action.body);
            !methods.chain(actions).chain([&unit.body]).all(is_empty)
        };
        let gives = |own: &Variable| matches!(own.section, Section::Output | Section::InOut);
        let gives_something = pou.result.is_some() || pou.variables.iter().any(gives);
        // Where a unit has code elsewhere, its file is there; a method that gives something should have some all the same.
        let is_whole = units.iter().any(has_code) && (method.is_none() || !gives_something);
        if !is_empty(&pou.body) || is_whole {
            return;
        }
        let name = match method {
            Some(_) => format!("{}.{}", self.project.pous[from].name, pou.name),
            None => pou.name.clone(),
        };
        let file = u32::try_from(pou.file).unwrap_or(u32::MAX);
        let place = Location { file, line: pou.line, step: None };
        let known = &mut self.program().without_body;
        if known.iter().all(|(own, _)| *own != name) {
            known.push((name, place));
        }
    }

    /// The unit, or the method, whose body is to be carried out and is not there, and what is stated of it.
    fn stated_of(&self, instance: usize, what: &What) -> Option<(&'p Pou, StatedCall)> {
        if self.calls.is_empty() {
            return None;
        }
        let (from, method) = match what {
            What::Body => (self.instances[instance].pou, None),
            What::Inherited(from, name) if name.is_empty() => (*from, None),
            What::Method(name) => (self.instances[instance].pou, Some(name)),
            What::Inherited(from, name) => (*from, Some(name)),
            What::Action(_) => return None,
        };
        for unit in lineage(self.project, from) {
            let own = match method {
                None => Some((unit, unit.name.clone())),
                Some(name) => {
                    let mut methods = unit.methods.iter();
                    let own = methods.find(|method| same(&method.name, name));
                    own.map(|own| (own, format!("{}.{}", unit.name, own.name)))
                }
            };
            let Some((pou, name)) = own.filter(|_| unit.kind != PouKind::Program) else { continue };
            if !matches!(&pou.body, Body::Code(_, statements) if statements.is_empty()) {
                return None;
            }
            if let Some(stated) = self.calls.get(&normalized(&name)) {
                return Some((pou, stated.clone()));
            }
            if method.is_some() {
                return None;
            }
        }
        None
    }

    fn all_it_writes(
        &mut self,
        instance: usize,
        what: &What,
        pou: &Pou,
        stated: &StatedCall,
    ) -> Result<Vec<Region>, Fault> {
        let own = self.instances[instance].place.clone();
        let locals = match what {
            What::Method(name) => Some(self.method_place(instance, name)?),
            What::Inherited(from, name) if !name.is_empty() => {
                Some(self.method_place_of(instance, Some(*from), name)?)
            }
            _ => None,
        };
        let refers = |place: &Place| has_reference(&place.ty);
        if refers(&own) || locals.as_ref().is_some_and(refers) {
            let told = format!(
                "{} is handed or holds references: what it does through them is not known",
                stated.name
            );
            let help = "give its source, or a stand-in with a body that does what it may do";
            return Err(Fault::new(pou.line, told).code(Code::NotModelled).help(help));
        }
        let mut regions = own.tag.regions();
        regions.extend(locals.into_iter().flat_map(|place| place.tag.regions()));
        for name in stated.writes.iter().flatten() {
            match self.global(None, name) {
                Some(place) => regions.extend(place.tag.regions()),
                None => {
                    let told = format!(
                        "{} is stated to write {name}, which is no global variable",
                        stated.name
                    );
                    let help =
                        "name global variables; what a call hands over is counted without that";
                    return Err(Fault::new(pou.line, told).code(Code::Fact).help(help));
                }
            }
        }
        Ok(regions)
    }
}

//! Variables that a call hands over in and out: what is called changes the caller's own variable (IEC 61131-3, VAR_IN_OUT).
//! They are followed as copies that are given back, so a call in which one variable has two names is refused.

use super::emit::{Emit, Place};
use super::function::{is_handed, parameters};
use super::reach::{named_in, overlap};
use super::references::{Walk, Way};
use super::resolve::{Context, Found};
use super::types::{Ty, lineage, same_type};
use scanbound_base::code::Code;
use scanbound_iec::ast::{Argument, Expr, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, PouKind, Section, TypeRef, Variable, same, show};

impl Emit<'_> {
    /// Refuses a call that leaves out what is handed over in and out.
    pub(super) fn leaves_none_out(
        &self,
        variables: &[Variable],
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        let names: Vec<_> = parameters(variables, given).filter_map(|(name, _)| name).collect();
        let mut all = variables.iter().filter(|one| one.section == Section::InOut);
        if let Some(left_out) = all.find(|own| !names.iter().any(|name| same(name, &own.name))) {
            let message =
                format!("{} is handed over in and out, and this call leaves it out", left_out.name);
            let help = "hand it over in every call: what a call without it means differs";
            return Err(Fault::new(line, message).code(Code::NotModelled).help(help));
        }
        Ok(())
    }

    /// Refuses an instance that becomes one of another type, of a block that its own extends: its own methods and actions would
    /// be called there.
    pub(super) fn has_own_type(
        &mut self,
        at: &Context,
        target: &Place,
        value: &Expr,
        line: u32,
    ) -> Result<(), Fault> {
        let Expr::Variable(path) = value else { return Ok(()) };
        if path.first.is_empty() || path.first.starts_with('~') || !holds_block(&target.ty) {
            return Ok(());
        }
        if self.types_of(at, path).iter().all(|ty| same_type(ty, &target.ty)) {
            return Ok(());
        }
        let message = format!(
            "{} is not of the type of {}: which methods are called through it is not followed",
            show::path(path),
            target.name
        );
        let help = "declare what takes it with the type of the instance, or hand over a reference or an interface";
        Err(Fault::new(line, message).code(Code::NotModelled).help(help))
    }

    /// The types that a path can have: through a reference, those of all that it can mean.
    fn types_of(&mut self, at: &Context, path: &Path) -> Vec<Ty> {
        match self.walk(at, path, true) {
            Walk::Type(ty) => vec![ty],
            Walk::Way(Way::Referred(way)) => {
                let can = self.candidates(way.kind, &way.of);
                let mut found = Vec::new();
                for one in can {
                    let (place, rest) = (self.target_at(one), way.rest.clone());
                    let types = self.with_name(place, "", |emit, first| {
                        Ok(emit.types_of(at, &Path { first, rest }))
                    });
                    found.extend(types.unwrap_or_default());
                }
                found
            }
            Walk::Way(Way::Property(_)) | Walk::Unknown => Vec::new(),
        }
    }

    /// Refuses a call that hands over a variable which what is called also reaches by another name: `owner` is the place of
    /// the instance that is called.
    pub(super) fn has_one_name(
        &mut self,
        at: &Context,
        owner: Option<&str>,
        variables: &[Variable],
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        let in_out = variables.iter().filter(|one| one.section == Section::InOut);
        if let Some(one) = { in_out }.find(|one| self.has_chart(&one.of, 0)) {
            let message = format!(
                "{} is handed over in and out, and has a chart, whose state is not followed there",
                one.name
            );
            let help = "call the instance where it is declared";
            return Err(Fault::new(line, message).code(Code::NotModelled).help(help));
        }
        let handed: Vec<&Path> = parameters(variables, given)
            .filter(|(name, _)| name.is_some_and(|name| is_handed(variables, name)))
            .filter_map(|(_, argument)| match &argument.value {
                Expr::Variable(path) => Some(path),
                _ => None,
            })
            .collect();
        let taken: Vec<&Path> = given
            .iter()
            .filter(|one| one.is_output)
            .filter_map(|one| match &one.value {
                Expr::Variable(path) => Some(path),
                _ => None,
            })
            .collect();
        for path in handed.iter().chain(&taken) {
            // Where an element is looked for, or what a pointer means, may be settled before the call or behind it.
            let moves = |emit: &Self, one: &Path| {
                handed.iter().chain(&taken).any(|other| overlap(one, other))
                    || emit.is_reached(at, one, false)
            };
            let mut moved = false;
            for index in path.rest.iter().filter_map(|part| match part {
                Part::Index(indices) => Some(indices),
                _ => None,
            }) {
                moved |= index.iter().any(|index| {
                    let mut found = self.calls_own(index);
                    super::within::variables(index, &mut |one| found |= moves(self, one));
                    found
                });
            }
            let pointer = path.rest.iter().position(|part| *part == Part::Dereference);
            if let Some(end) = pointer.filter(|_| !same(&path.first, "THIS")) {
                let pointer = Path { first: path.first.clone(), rest: path.rest[..end].to_vec() };
                let mut others = handed.iter().chain(&taken).filter(|other| other != &path);
                moved |= others.any(|other| overlap(&pointer, other) && other.rest.len() <= end)
                    || self.is_reached(at, &pointer, false);
            }
            if moved {
                let message =
                    format!("what {} means may change while the call runs", show::path(path));
                let help = "assign the index or the address to a variable that nothing else writes";
                return Err(Fault::new(line, message).code(Code::NotModelled).help(help));
            }
        }
        for (number, path) in handed.iter().enumerate() {
            let twice = handed[..number].iter().any(|other| overlap(path, other));
            if twice || self.is_of(at, owner, path, line)? || self.is_reached(at, path, false) {
                let message = format!(
                    "{} is handed over in and out, and what is called may reach it by another name",
                    show::path(path)
                );
                let help = "hand over a variable of its own, and assign it before and after";
                return Err(Fault::new(line, message).code(Code::NotModelled).help(help));
            }
        }
        Ok(())
    }

    /// Refuses what names, from outside, a variable that an instance's calls hand over in and out: what the last call handed over
    /// is meant.
    pub(super) fn names_handed(&self, pou: usize, name: &str, line: u32) -> Result<(), Fault> {
        if !lineage(self.project, pou).iter().any(|pou| is_handed(&pou.variables, name)) {
            return Ok(());
        }
        let message = format!(
            "{name} is handed over in and out, and reached while no call of its instance hands it over"
        );
        let help =
            "copy it to a variable of the block in its body, or hand it over where it is needed";
        Err(Fault::new(line, message).code(Code::NotModelled).help(help))
    }

    /// The same of what a method, property or action of a unit reaches, alone or by others of the unit.
    pub(super) fn member_names_handed(
        &self,
        pou: usize,
        member: &str,
        line: u32,
    ) -> Result<(), Fault> {
        let all = lineage(self.project, pou);
        if !all.iter().flat_map(|pou| &pou.variables).any(|one| one.section == Section::InOut) {
            return Ok(());
        }
        let mut members = vec![member.to_owned()];
        let mut seen = 0;
        while let Some(member) = members.get(seen).cloned() {
            seen += 1;
            for name in all.iter().flat_map(|pou| named_in(pou, &member)) {
                self.names_handed(pou, name, line)?;
                if !members.iter().any(|known| same(known, name)) {
                    members.push(name.to_owned());
                }
            }
        }
        Ok(())
    }

    /// Whether what a type holds carries out a chart.
    fn has_chart(&self, of: &TypeRef, depth: u32) -> bool {
        let within = |list: &[Variable]| list.iter().any(|one| self.has_chart(&one.of, depth + 1));
        match of {
            // Types that stand in each other without an end are told elsewhere.
            _ if depth > 40 => false,
            TypeRef::Array(_, of) => self.has_chart(of, depth + 1),
            TypeRef::Struct(parts) => within(parts),
            TypeRef::Named(name) => {
                let own = self.project.types.iter().find(|one| same(&one.name, name));
                let block =
                    self.project.pous.iter().position(|pou| {
                        pou.kind == PouKind::FunctionBlock && same(&pou.name, name)
                    });
                let lineage = block.map(|at| lineage(self.project, at)).unwrap_or_default();
                own.is_some_and(|own| self.has_chart(&own.of, depth + 1))
                    || lineage.into_iter().any(|pou| {
                        let actions = pou.actions.iter().map(|action| &action.body);
                        let mut bodies = actions.chain([&pou.body]);
                        bodies.any(|body| matches!(body, Body::Chart(_))) || within(&pou.variables)
                    })
            }
            _ => false,
        }
    }

    /// Whether a variable belongs to the instance that is called.
    fn is_of(
        &mut self,
        at: &Context,
        owner: Option<&str>,
        path: &Path,
        line: u32,
    ) -> Result<bool, Fault> {
        let Some(owner) = owner else { return Ok(false) };
        let name = match self.find(at, path, line)? {
            Found::Place(place) => place.name,
            Found::Element(element) => element.place.name,
            // No bit of a word can be handed over so.
            _ => return Ok(false),
        };
        let (name, owner) = (name.to_ascii_uppercase(), owner.to_ascii_uppercase());
        Ok(name.strip_prefix(&owner).is_some_and(|rest| rest.is_empty() || rest.starts_with('.')))
    }
}

/// Whether a variable of a type is an instance of a block, or holds some.
fn holds_block(ty: &Ty) -> bool {
    match ty {
        Ty::Block(..) => true,
        Ty::Array { of, .. } => holds_block(of),
        Ty::Parts(parts) => parts.iter().any(|(_, ty)| holds_block(ty)),
        _ => false,
    }
}

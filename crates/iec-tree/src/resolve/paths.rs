//! Resolution of paths to variables, parts of variables, constants or properties.

use super::resolver::{Resolver, Scope, unknown_name};
use crate::declarations::{Address, AddressId, Owner, Purpose, TempId, Temporary, UnitId, VarId};
use crate::tree::{Expr, ExprKind, Place, Root, Statement, StatementKind, Step, Target};
use crate::types::{Elementary, Kind, Refers, Type, TypeId, holding};
use scanbound_base::code::Code;
use scanbound_iec::Variable as Declared;
use scanbound_iec::ast::{self, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Section, TypeRef, same, show};
use std::borrow::Cow;

/// The meaning of a path.
pub(super) enum Found {
    /// A variable or a part of one.
    Place(Place),
    /// A constant or a step's flag.
    Constant(Expr),
    /// A property of an instance.
    Property(Property),
}

/// A property of an instance. It is read and written by accessor methods.
pub(super) struct Property {
    /// The instance that has the property.
    pub(super) owner: Place,
    /// Whether the base's accessors are called, without dynamic dispatch (`SUPER^`).
    pub(super) of_base: bool,
    /// The unit that declares or inherits it.
    pub(super) unit: UnitId,
    /// Its name.
    pub(super) name: String,
}

fn is_this(name: &str) -> bool {
    ["THIS", "SUPER"].iter().any(|own| same(own, name))
}

impl Resolver<'_> {
    /// Resolves a path. A `REFERENCE TO` at its end is replaced by its target.
    pub(super) fn path(&mut self, scope: Scope, path: &Path, line: u32) -> Result<Found, Fault> {
        self.path_to(scope, (path, true), line)
    }

    /// Like [`Resolver::path`], but a reference at the end stays a reference.
    pub(super) fn reference(
        &mut self,
        scope: Scope,
        path: &Path,
        line: u32,
    ) -> Result<Found, Fault> {
        self.path_to(scope, (path, false), line)
    }

    fn path_to(
        &mut self,
        scope: Scope,
        (path, to_end): (&Path, bool),
        line: u32,
    ) -> Result<Found, Fault> {
        let path = &*self.without_list(scope, path);
        let rest = &path.rest[..];
        if is_this(&path.first) {
            let Some(unit) = scope.unit else { return Err(unknown_name(line, &path.first)) };
            let behind =
                rest.iter().position(|part| *part != Part::Dereference).unwrap_or(rest.len());
            let start = self.this(unit);
            if same(&path.first, "SUPER")
                && let [Part::Name(name), rest @ ..] = &rest[behind..]
                && let Some(base) = self.tree.unit(unit).base
                && self.index.has_property(base, name)
            {
                let (owner, name) = (start, name.clone());
                let property = Property { owner, of_base: true, unit: base, name };
                return self.of_property(scope, property, rest, (path, to_end), line);
            }
            return self.follow(scope, start, &rest[behind..], (path, to_end), line);
        }
        let own = self.own_variable(scope, &path.first);
        if let Some(flag) = self.step_flag(scope, path, line)? {
            return Ok(Found::Constant(flag));
        }
        if let (None, Some(unit)) = (own, scope.unit)
            && self.index.has_property(unit, &path.first)
        {
            let (owner, name) = (self.this(unit), path.first.clone());
            let property = Property { owner, of_base: false, unit, name };
            return self.of_property(scope, property, rest, (path, to_end), line);
        }
        if own.is_none() {
            self.note_global(scope, &path.first);
        }
        if let Some(constant) = self.named_constant(scope, own, path, line) {
            return Ok(Found::Constant(constant));
        }
        let variable = own.or_else(|| self.global(scope, &path.first));
        if let Some(variable) = variable {
            let start = self.start(variable);
            return self.follow(scope, start, rest, (path, to_end), line);
        }
        if let [Part::Name(name), rest @ ..] = rest
            && let Some(variable) = self.index.listed(&path.first, name)
        {
            let start = self.start(variable);
            return self.follow(scope, start, rest, (path, to_end), line);
        }
        if let Some(at) = self.program_instance(&path.first) {
            let unit = self.tree.programs[at].unit;
            if scope.unit.is_some_and(|own| own != unit) {
                self.named_programs.insert(unit);
            }
            let ty = self.block(unit);
            let start = start(Root::Program(at), ty);
            return self.follow(scope, start, rest, (path, to_end), line);
        }
        let last = path.split_last().map_or(path.first.as_str(), |(_, last)| last);
        let number = self.constants.named(&path.first).or_else(|| {
            let of = format!("{}#{last}", path.first);
            self.constants.named(&of).filter(|_| rest.len() == 1)
        });
        if let Some(number) = number {
            return Ok(Found::Constant(self.untyped(number, line)));
        }
        if path.first.starts_with('%') {
            let start = self.direct(&path.first);
            return self.follow(scope, start, rest, (path, to_end), line);
        }
        Err(self.not_declared(scope, path, line))
    }

    /// Removes the list's name from the path if the list is known only by its file's name and nothing nearer hides the
    /// variable.
    fn without_list<'p>(&self, scope: Scope, path: &'p Path) -> Cow<'p, Path> {
        let is_hidden = |name: &&str| {
            self.own_variable(scope, name).is_some() || {
                let index = &self.index;
                let has = |unit| {
                    index.action(unit, name).is_some()
                        || index.method(unit, name).is_some()
                        || index.has_property(unit, name)
                };
                scope.unit.is_some_and(has)
            }
        };
        match self.index.of_file(path).filter(|name| !is_hidden(name)) {
            Some(first) => {
                let (first, rest) = (first.to_owned(), path.rest[1..].to_vec());
                Cow::Owned(Path { first, rest })
            }
            None => Cow::Borrowed(path),
        }
    }

    /// The place that receives a value; a fault if the path needs a getter's call.
    pub(super) fn target(&mut self, scope: Scope, path: &Path, line: u32) -> Result<Place, Fault> {
        let around = self.before.len();
        let place = self.place(scope, path, line)?;
        match self.before.len() > around {
            true => Err(property_here(line, &show::path(path))),
            false => Ok(place),
        }
    }

    /// The id of a statement list's temporary, which is created at its first use.
    pub(super) fn listed(&mut self, kept: &ast::Temp, ty: TypeId) -> TempId {
        if let Some(&known) = self.listed.get(&kept.number) {
            return known;
        }
        let purpose = if kept.merges { Purpose::Merged } else { Purpose::Between };
        self.tree.temporaries.push(Temporary { purpose, ty, text: kept.text.clone() });
        let id = TempId::at(self.tree.temporaries.len() - 1);
        self.listed.insert(kept.number, id);
        id
    }

    /// An integer constant without a type of its own.
    pub(super) fn untyped(&mut self, value: i64, line: u32) -> Expr {
        let ty = self.tree.types.id(Type::Untyped);
        Expr { kind: ExprKind::Named(value), ty, line }
    }

    /// The current instance (`THIS`) of a unit.
    pub(super) fn this(&mut self, unit: UnitId) -> Place {
        let ty = self.block(unit);
        start(Root::This, ty)
    }

    /// The place of a whole variable.
    pub(super) fn start(&self, variable: VarId) -> Place {
        let one = self.tree.variable(variable);
        Place { text: one.name.as_str().into(), ..start(Root::Variable(variable), one.ty) }
    }

    /// The place of a temporary.
    pub(super) fn kept_place(&self, id: TempId) -> Place {
        let one = &self.tree.temporaries[id.index()];
        Place { text: one.text.as_str().into(), ..start(Root::Temporary(id), one.ty) }
    }

    /// The variable of this name in the method, the unit or its bases; globals are not included.
    pub(super) fn own_variable(&self, scope: Scope, name: &str) -> Option<VarId> {
        let local = scope.method.and_then(|method| self.index.local(method, name));
        local
            .or_else(|| self.index.member(scope.unit?, name))
            .or_else(|| self.static_of_base(scope.unit?, name))
    }

    /// A static variable (VAR_STAT) of a base unit, shared by all instances. It is stored as a global named
    /// `base.name`.
    fn static_of_base(&self, unit: UnitId, name: &str) -> Option<VarId> {
        self.tree.unit(unit).base?;
        let bases = self.tree.lineage(unit).into_iter().skip(1);
        let named = |base: UnitId| format!("{}.{name}", self.tree.unit(base).name);
        bases.map(named).find_map(|name| self.index.globals(&name).first().copied())
    }

    fn global(&self, scope: Scope, name: &str) -> Option<VarId> {
        let of_list = scope.list.and_then(|list| {
            let list = &self.tree.globals[list].name;
            if list.is_empty() { None } else { self.index.listed(list, name) }
        });
        of_list.or_else(|| self.index.globals(name).first().copied())
    }

    fn program_instance(&self, name: &str) -> Option<usize> {
        let all = &self.tree.programs;
        let of =
            |one: &crate::tree::ProgramInstance| self.project.pous[one.unit.index()].name.as_str();
        let named = self.instance_named(name);
        named.or_else(|| all.iter().position(|one| same(of(one), name)))
    }

    fn direct(&mut self, text: &str) -> Place {
        let text = text.to_ascii_uppercase();
        let size = text.trim_start_matches('%').chars().nth(1).unwrap_or('X');
        let of = match size {
            'B' => Elementary::Byte,
            'W' => Elementary::Word,
            'D' => Elementary::Dword,
            'L' => Elementary::Lword,
            _ => Elementary::Bool,
        };
        let ty = self.tree.types.elementary(of);
        let known = self.tree.addresses.iter().position(|one| one.text == text);
        let at = known.unwrap_or_else(|| {
            self.tree.addresses.push(Address { text, ty });
            self.tree.addresses.len() - 1
        });
        start(Root::Address(AddressId::at(at)), ty)
    }

    /// The constant that a plain name refers to, if its value is known and cannot differ; otherwise `None`.
    fn named_constant(
        &mut self,
        scope: Scope,
        own: Option<VarId>,
        path: &Path,
        line: u32,
    ) -> Option<Expr> {
        let name = path.as_name()?;
        let id = match own {
            Some(id) => {
                let one = self.tree.variable(id);
                let is_own = matches!(one.owner, Owner::Unit(_));
                let is_fixed =
                    one.section == Section::Local && one.constant && !self.tree.gives_parts;
                if !(is_own && is_fixed) {
                    return None;
                }
                id
            }
            None => match self.index.globals(name) {
                &[one] if self.tree.variable(one).constant => one,
                _ => return None,
            },
        };
        let declared = self.declared(id)?;
        let initial = declared.initial.as_ref()?;
        let one = self.tree.variable(id);
        let ty = one.ty;
        let bool = self.bool();
        if ty == bool {
            return match initial {
                ast::Expr::Literal(ast::Literal::Bool(value)) => {
                    Some(Expr { kind: ExprKind::Bool(*value), ty, line })
                }
                _ => None,
            };
        }
        if !super::types::is_elementary(&declared.of) {
            return None;
        }
        let kind = self.tree.types.kind(ty).filter(|kind| matches!(kind, Kind::Whole { .. }))?;
        let value = match own {
            Some(_) => {
                // Names in the initial value may refer to other constants in a derived unit.
                let mut is_hidden = false;
                names(initial, &mut |path| is_hidden |= self.hides(scope, path));
                self.constants.number(initial, &[]).filter(|_| !is_hidden)?
            }
            None => self.constants.named(name)?,
        };
        (holding(kind, value) == kind).then_some(Expr { kind: ExprKind::Typed(value), ty, line })
    }

    /// Whether a nearer declaration, or a variable, prevents this path from referring to a global constant or
    /// enumeration value.
    fn hides(&self, scope: Scope, path: &Path) -> bool {
        let path = self.without_list(scope, path);
        let name = &path.first;
        self.own_variable(scope, name).is_some()
            || scope.unit.is_some_and(|unit| self.index.has_property(unit, name))
            || self.index.globals(name).iter().any(|&one| !self.tree.variable(one).constant)
            || !(path.rest.is_empty() || self.constants.is_list_or_type(name))
    }

    /// The declaration of a variable in the syntax tree; `None` for variables of methods.
    fn declared(&self, id: VarId) -> Option<&Declared> {
        let one = self.tree.variable(id);
        let find = |all: &'_ [Declared]| -> Option<usize> {
            all.iter().position(|own| same(&own.name, &one.name) && own.line == one.line)
        };
        let all: &[Declared] = match one.owner {
            Owner::Unit(unit) => &self.project.pous[unit.index()].variables,
            Owner::Global(list) => &self.project.globals[list].1,
            Owner::Routine(_) => return None,
        };
        find(all).map(|at| &all[at])
    }

    /// Appends selectors to a place, one after another, with dereferences of references in between.
    fn follow(
        &mut self,
        scope: Scope,
        start: Place,
        rest: &[Part],
        (path, to_end): (&Path, bool),
        line: u32,
    ) -> Result<Found, Fault> {
        let mut place = Place { text: show::path(path).into(), ..start };
        self.has_type(&place)?;
        for (number, part) in rest.iter().enumerate() {
            if self.dereferenced(&mut place, part, line)? && *part == Part::Dereference {
                continue;
            }
            if let (Type::Block(unit), Part::Name(name)) = (self.tree.types.get(place.ty), part)
                && self.index.member(*unit, name).is_none()
                && self.index.has_property(*unit, name)
            {
                let (unit, name) = (*unit, name.clone());
                let property = Property { owner: place, of_base: false, unit, name };
                let rest = &rest[number + 1..];
                return self.of_property(scope, property, rest, (path, to_end), line);
            }
            let used = path.rest.len() - rest.len() + number;
            let before = Path { first: path.first.clone(), rest: path.rest[..used].to_vec() };
            let (step, ty) = self.step(scope, &place, part, (path, &before), line)?;
            // VAR_IN_OUT is accessible by the instance's own code, because a call is running then.
            let is_own = place.root == Root::This && place.steps.is_empty();
            if let (Step::Member(variable), false) = (&step, is_own) {
                self.names_handed(*variable, line)?;
            }
            place.steps.push(step);
            place.ty = ty;
            self.has_type(&place)?;
        }
        if let (Type::Reference(Refers::Reference, to), true) =
            (self.tree.types.get(place.ty), to_end)
        {
            place.ty = *to;
            place.steps.push(Step::Dereference);
            self.has_type(&place)?;
        }
        Ok(Found::Place(place))
    }

    /// The property, or a part of its value if selectors follow.
    fn of_property(
        &mut self,
        scope: Scope,
        property: Property,
        rest: &[Part],
        (path, to_end): (&Path, bool),
        line: u32,
    ) -> Result<Found, Fault> {
        if rest.is_empty() {
            return Ok(Found::Property(property));
        }
        let start = self.given(scope, property, line)?;
        self.follow(scope, start, rest, (path, to_end), line)
    }

    /// The place of a property's result. The getter's call is queued to run before.
    pub(super) fn given(
        &mut self,
        scope: Scope,
        property: Property,
        line: u32,
    ) -> Result<Place, Fault> {
        let found = self.property_read(scope, &property, line)?;
        let Property { mut owner, of_base, name, .. } = property;
        let ExprKind::Call(call) = found.kind else { return Err(unknown_name(line, &name)) };
        let (Target::Method(_, method) | Target::BaseMethod(method)) = call.target else {
            return Err(unknown_name(line, &name));
        };
        if owner.has_open_index() {
            return Err(property_here(line, &owner.text));
        }
        self.before.push(*call);
        owner.steps.push(Step::Result(method, of_base));
        owner.ty = found.ty;
        Ok(owner)
    }

    /// Like [`Resolver::given`], but a `REFERENCE TO` result is replaced by its target.
    pub(super) fn given_whole(
        &mut self,
        scope: Scope,
        property: Property,
        line: u32,
    ) -> Result<Place, Fault> {
        let mut place = self.given(scope, property, line)?;
        if let Type::Reference(Refers::Reference, to) = *self.tree.types.get(place.ty) {
            place.steps.push(Step::Dereference);
            place.ty = to;
        }
        Ok(place)
    }

    /// Like [`Resolver::path`], but a fault if the path uses a part of a property's value.
    pub(super) fn one_path(
        &mut self,
        scope: Scope,
        path: &Path,
        line: u32,
    ) -> Result<Found, Fault> {
        let around = self.before.len();
        let found = self.path(scope, path, line);
        if self.before.len() > around {
            self.before.truncate(around);
            return found.and(Err(property_here(line, &show::path(path))));
        }
        found
    }

    /// Wraps an expression in the getter calls queued since `around`, so that they run first.
    pub(super) fn after_calls(&mut self, around: usize, mut found: Expr) -> Expr {
        for call in self.before.split_off(around).into_iter().rev() {
            if matches!(found.kind, ExprKind::Fault(_)) {
                return found;
            }
            let (ty, line) = (found.ty, found.line);
            found = Expr { kind: ExprKind::After(Box::new((call, found))), ty, line };
        }
        found
    }

    /// Like [`Resolver::after_calls`], for a statement.
    pub(super) fn statement_after(&mut self, around: usize, mut found: Statement) -> Statement {
        for call in self.before.split_off(around).into_iter().rev() {
            if matches!(found.kind, StatementKind::Fault(_)) {
                return found;
            }
            let (text, line) = (found.text.clone(), found.line);
            found = Statement { kind: StatementKind::After(Box::new((call, found))), text, line };
        }
        found
    }

    /// Dereferences a reference or interface before the next selector. Returns whether it did.
    fn dereferenced(&mut self, place: &mut Place, part: &Part, line: u32) -> Result<bool, Fault> {
        place.ty = match *self.tree.types.get(place.ty) {
            Type::Reference(Refers::Pointer, _) if *part != Part::Dereference => {
                let told = format!("{} is a pointer: ^ was expected after it", place.text);
                return Err(Fault::new(line, told).code(Code::NotModelled));
            }
            Type::Reference(_, to) => to,
            Type::Interface(unit) => self.block(unit),
            _ => return Ok(false),
        };
        place.steps.push(Step::Dereference);
        self.has_type(place)?;
        Ok(true)
    }

    /// Resolves an expression used as the value of a reference: an address, a reference or null.
    pub(super) fn address(&mut self, scope: Scope, one: &ast::Expr, line: u32) -> Expr {
        let around = self.before.len();
        let found = match self.find_address(scope, one, line) {
            Ok(found) => found,
            Err(fault) => self.faulty(fault, line),
        };
        self.after_calls(around, found)
    }

    fn find_address(&mut self, scope: Scope, one: &ast::Expr, line: u32) -> Result<Expr, Fault> {
        let path = match one {
            ast::Expr::Literal(ast::Literal::Int(0, _)) => return Ok(self.null(line)),
            ast::Expr::Variable(path) if self.is_null(scope, path) => return Ok(self.null(line)),
            ast::Expr::Variable(path) => path,
            ast::Expr::Call(..) => return Ok(self.expression(scope, one, line)),
            _ => {
                let told = format!("what {} refers to is not followed", show::expr(one));
                return Err(Fault::new(line, told).code(Code::NotModelled));
            }
        };
        match self.reference(scope, path, line)? {
            Found::Place(place) => match self.tree.types.get(place.ty) {
                Type::Reference(..) | Type::Interface(_) => {
                    let ty = place.ty;
                    Ok(Expr { kind: ExprKind::Read(place), ty, line })
                }
                _ => self.address_of(place, line),
            },
            Found::Property(property) => self.property_read(scope, &property, line),
            Found::Constant(_) => {
                let told = format!("{} has no address", show::path(path));
                Err(Fault::new(line, told).code(Code::NotModelled))
            }
        }
    }

    /// The address of a place; a fault for VAR_IN_OUT and for properties.
    pub(super) fn address_of(&mut self, place: Place, line: u32) -> Result<Expr, Fault> {
        let results = place.steps.iter().rposition(|step| matches!(step, Step::Result(..)));
        if results.is_some_and(|at| {
            !place.steps[at..].iter().any(|step| matches!(step, Step::Dereference))
        }) {
            let told = format!("{} is a property and has no address", place.text);
            return Err(Fault::new(line, told).code(Code::NotModelled));
        }
        // VAR_IN_OUT is modelled as a copy, so its address is not that of the caller's variable.
        let members = place.steps.iter().filter_map(|step| match step {
            Step::Member(id) => Some(*id),
            _ => None,
        });
        let root = match place.root {
            Root::Variable(id) => Some(id),
            _ => None,
        };
        let is_copy = |id: &VarId| self.tree.variable(*id).section == Section::InOut;
        if root.into_iter().chain(members).any(|id| is_copy(&id)) {
            let what = format!(
                "the address of {} is taken, which is VAR_IN_OUT: not followed",
                place.text
            );
            let help = "pass a reference or a pointer instead of VAR_IN_OUT";
            return Err(Fault::new(line, what).code(Code::NotModelled).help(help));
        }
        let ty = self.tree.types.id(Type::Reference(Refers::Pointer, place.ty));
        Ok(Expr { kind: ExprKind::Address(place), ty, line })
    }

    pub(super) fn is_null(&self, scope: Scope, path: &Path) -> bool {
        path.as_name().is_some_and(|name| same(name, "NULL"))
            && self.own_variable(scope, "NULL").is_none()
            && self.index.globals("NULL").is_empty()
    }

    pub(super) fn null(&mut self, line: u32) -> Expr {
        let ty = self.tree.types.id(Type::Untyped);
        Expr { kind: ExprKind::Null, ty, line }
    }

    fn has_type(&self, place: &Place) -> Result<(), Fault> {
        match self.tree.types.get(place.ty) {
            Type::Faulty(at) => Err(self.tree.types.fault(*at)),
            _ => Ok(()),
        }
    }

    /// Rejects an access from outside to a VAR_IN_OUT of an instance: it would refer to the variable passed in the last
    /// call.
    pub(super) fn names_handed(&self, variable: VarId, line: u32) -> Result<(), Fault> {
        let one = self.tree.variable(variable);
        if one.section != Section::InOut {
            return Ok(());
        }
        let message = format!(
            "{} is VAR_IN_OUT, and is accessed while no call of its instance passes it",
            one.name
        );
        let help = "copy it to a variable of the block in its body, or pass it where it is needed";
        Err(Fault::new(line, message).code(Code::NotModelled).help(help))
    }

    fn step(
        &mut self,
        scope: Scope,
        place: &Place,
        part: &Part,
        (path, before): (&Path, &Path),
        line: u32,
    ) -> Result<(Step, TypeId), Fault> {
        let shown = || show::path(path);
        match (self.tree.types.get(place.ty).clone(), part) {
            (Type::Struct(id), Part::Name(name)) => {
                let parts = self.tree.types.parts(id);
                let at = parts.iter().position(|(own, _)| same(own, name));
                let at = at.ok_or_else(|| unknown_name(line, &shown()))?;
                Ok((Step::Part(at), parts[at].1))
            }
            (Type::Block(unit), Part::Name(name)) => match self.index.member(unit, name) {
                Some(id) => Ok((Step::Member(id), self.tree.variable(id).ty)),
                None => Err(unknown_name(line, &shown())),
            },
            (Type::Standard(block), Part::Name(name)) => {
                let pin = block.pin(name).ok_or_else(|| unknown_name(line, &shown()))?;
                Ok((Step::Pin(pin), self.tree.types.elementary(pin.of())))
            }
            (Type::Array(dimensions, of), Part::Index(indices)) => {
                if indices.len() != dimensions.len() {
                    let told = format!("{} has {} dimensions", shown(), dimensions.len());
                    return Err(Fault::new(line, told));
                }
                let mut all = Vec::new();
                for index in indices {
                    all.push(self.expression(scope, index, line));
                }
                let known: Option<Vec<i64>> = all.iter().map(Expr::whole).collect();
                for (number, (low, high)) in known.iter().flatten().zip(&dimensions) {
                    if !(low..=high).contains(&number) {
                        let before = show::path(before);
                        let told = format!("{before}[{number}] lies outside {low}..{high}");
                        return Err(Fault::new(line, told));
                    }
                }
                Ok((Step::Element(all), of))
            }
            (Type::Elementary(of), Part::Bit(bit)) => match of.kind() {
                Some(Kind::Whole { bits, .. }) if *bit < bits => Ok((Step::Bit(*bit), self.bool())),
                _ => Err(Fault::new(line, format!("{} has no bit {bit}", shown()))),
            },
            (Type::Array(..), _) | (_, Part::Index(_)) if matches!(part, Part::Index(_)) => {
                Err(Fault::new(line, format!("{} is not an array", shown())))
            }
            _ => {
                let told = format!("{} is not followed", shown());
                Err(Fault::new(line, told).code(Code::NotModelled))
            }
        }
    }

    /// The fault of an undeclared name, with special messages for VAR_EXTERNAL without a VAR_GLOBAL and for ambiguous
    /// enumeration values.
    fn not_declared(&self, scope: Scope, path: &Path, line: u32) -> Fault {
        let lineage = scope.unit.map(|unit| self.tree.lineage(unit)).unwrap_or_default();
        let mut all = lineage.into_iter().flat_map(|unit| {
            let pou = &self.project.pous[unit.index()];
            pou.variables.iter().chain(pou.methods.iter().flat_map(|one| &one.variables))
        });
        let is_it =
            |one: &Declared| one.section == Section::External && same(&one.name, &path.first);
        if all.any(is_it) {
            let told = format!(
                "{} is declared as VAR_EXTERNAL, and no VAR_GLOBAL declares it",
                path.first
            );
            let help = format!("give the file in which VAR_GLOBAL declares {}, too", path.first);
            return Fault::new(line, told)
                .code(Code::UnknownName)
                .text(show::path(path))
                .help(help);
        }
        let has_value = |of: &TypeRef| {
            let TypeRef::Enumeration(values, _) = of else { return false };
            path.rest.is_empty() && values.iter().any(|(name, _)| same(name, &path.first))
        };
        let types = self.project.types.iter();
        let types: Vec<&str> =
            types.filter(|one| has_value(&one.of)).map(|one| one.name.as_str()).collect();
        if let [first, _, ..] = types[..] {
            let told = format!(
                "{} is a value of the enumerations {}: which one is meant is not clear",
                path.first,
                types.join(" and ")
            );
            let help = format!("write {first}#{}, with the name of its type", path.first);
            let fault = Fault::new(line, told).code(Code::DeclaredTwice);
            return fault.text(show::path(path)).help(help);
        }
        unknown_name(line, &show::path(path))
    }
}

/// The fault of a property used where it is not supported.
pub(super) fn property_here(line: u32, name: &str) -> Fault {
    let what = format!("{name} is a property, which is not followed here");
    let help = "take the result into a variable, and assign that to the property";
    Fault::new(line, what).code(Code::NotModelled).help(help)
}

/// A place without selectors.
pub(super) fn start(root: Root, ty: TypeId) -> Place {
    Place { root, steps: Vec::new(), ty, text: "THIS^".into() }
}

/// Calls `see` for the paths of variables in a constant's initial value.
fn names(one: &ast::Expr, see: &mut dyn FnMut(&Path)) {
    if let ast::Expr::Variable(path) = one {
        see(path);
    }
    one.operands().into_iter().for_each(|inner| names(inner, see));
}

//! Types as they are written, by ids.

use super::resolver::{Resolver, named};
use crate::blocks::StandardBlock;
use crate::declarations::UnitId;
use crate::types::{Elementary, Refers, TEXT, Type, TypeId};
use scanbound_base::code::Code;
use scanbound_base::facts::key;
use scanbound_iec::Variable as Declared;
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, TypeRef, ast, same};

/// The most characters of a text whose declared length is no constant.
const LONGEST_TEXT: u32 = 65_535;

/// Whether a type is one of the standard's own, which begin with 0. An enumeration begins with its first value, and a
/// type of the project's with what that says.
pub(super) fn is_elementary(of: &TypeRef) -> bool {
    named(of).is_some_and(is_elementary_name)
}

/// Whether a name is that of one of the standard's own types.
pub(super) fn is_elementary_name(name: &str) -> bool {
    let is_text = || ["STRING", "WSTRING"].iter().any(|own| scanbound_iec::same(own, name));
    Elementary::named(name).is_some() || is_text()
}

/// The fault of a base that is not there.
pub(super) fn unknown_base(name: &str, base: &str, line: u32) -> Fault {
    Fault::new(line, format!("{name} extends {base}, which is not known"))
        .code(Code::UnknownType)
        .text(base)
        .help("give the file that declares it")
}

/// The help for a name that the project does not declare: what else may be wrong, and what to do where a library has
/// it.
pub(super) fn declare(first: &str, name: &str) -> String {
    format!(
        "{first}; of what a library has, declare inputs and outputs without a body, and state its time in a facts file (--facts): [calls] {} = {{ time = \"50us\" }}",
        key(name)
    )
}

impl<'p> Resolver<'p> {
    /// The type that is meant where these variables hide global names.
    pub(super) fn type_of(&mut self, of: &TypeRef, around: &[&[Declared]], line: u32) -> TypeId {
        match self.find_type(of, around, line) {
            Ok(ty) => ty,
            Err(fault) => self.tree.types.faulty(fault),
        }
    }

    fn find_type(
        &mut self,
        of: &TypeRef,
        around: &[&[Declared]],
        line: u32,
    ) -> Result<TypeId, Fault> {
        let constant = |own: &Self, one: &ast::Expr| own.constants.number(one, around);
        let ty = match of {
            TypeRef::Named(name) => return self.named_type(name, line),
            TypeRef::Text(None) => Type::Text(TEXT),
            TypeRef::Text(Some(length)) => {
                let known = constant(self, length).and_then(|one| u32::try_from(one).ok());
                Type::Text(known.unwrap_or(LONGEST_TEXT))
            }
            TypeRef::Pointer(of) => {
                Type::Reference(Refers::Pointer, self.type_of(of, around, line))
            }
            TypeRef::Reference(of) => {
                Type::Reference(Refers::Reference, self.type_of(of, around, line))
            }
            TypeRef::Enumeration(_, None) => Type::Elementary(Elementary::Int),
            TypeRef::Enumeration(_, Some(base)) => return self.find_type(base, around, line),
            TypeRef::Subrange(of, _) => return self.find_type(of, around, line),
            TypeRef::Struct(parts) => {
                let id = self.tree.types.new_struct();
                let mut own = Vec::new();
                for one in parts {
                    own.push((one.name.clone(), self.declared_part(one, around)?));
                }
                self.tree.types.set_parts(id, own);
                Type::Struct(id)
            }
            TypeRef::Array(dimensions, of) => {
                let element = self.find_type(of, around, line)?;
                let bound = |own: &Self, one: &ast::Expr| {
                    let told = "an array's bound is no constant";
                    constant(own, one).ok_or_else(|| Fault::new(line, told).code(Code::UnknownType))
                };
                let mut bounds = Vec::new();
                for (low, high) in dimensions {
                    bounds.push((bound(self, low)?, bound(self, high)?));
                }
                if bounds.iter().any(|(low, high)| low > high) {
                    let told = "an array ends before it begins";
                    return Err(Fault::new(line, told).code(Code::UnknownType));
                }
                Type::Array(bounds, element)
            }
        };
        Ok(self.tree.types.id(ty))
    }

    fn named_type(&mut self, name: &str, line: u32) -> Result<TypeId, Fault> {
        if let Some(found) = Elementary::named(name) {
            return Ok(self.tree.types.elementary(found));
        }
        if ["STRING", "WSTRING"].iter().any(|own| scanbound_iec::same(own, name)) {
            return Ok(self.tree.types.id(Type::Text(TEXT)));
        }
        if let Some(unit) = self.index.unit(name) {
            match self.project.pous[unit.index()].kind {
                PouKind::FunctionBlock => return Ok(self.block(unit)),
                PouKind::Interface => return Ok(self.tree.types.id(Type::Interface(unit))),
                PouKind::Program | PouKind::Function => {}
            }
        }
        if let Some(at) = self.index.declared_type(name) {
            let own = &self.project.types[at];
            // Bases that are declared gave it their parts when all files were read.
            if let Some(base) = &own.extends {
                return Err(unknown_base(&own.name, base, line));
            }
            if let Some(&known) = self.index.known_types.get(&at) {
                return Ok(known);
            }
            if let TypeRef::Struct(parts) = &own.of {
                // It may refer to itself.
                let id = self.tree.types.new_struct();
                let ty = self.tree.types.id(Type::Struct(id));
                self.index.known_types.insert(at, ty);
                let mut all = Vec::new();
                for one in parts {
                    let found = self.declared_part(one, &[]);
                    let found = found.unwrap_or_else(|fault| self.tree.types.faulty(fault));
                    all.push((one.name.clone(), found));
                }
                self.tree.types.set_parts(id, all);
                return Ok(ty);
            }
            let ty = self.find_type(&own.of, &[], line)?;
            self.refers_to_nothing(ty, own.initial.as_ref(), own.line)?;
            self.index.known_types.insert(at, ty);
            return Ok(ty);
        }
        match StandardBlock::named(name) {
            Some(block) => Ok(self.tree.types.id(Type::Standard(block))),
            None => Err(Fault::new(line, format!("the type {name} is not known"))
                .code(Code::UnknownType)
                .text(name)
                .help(declare("give the file that declares it", name))),
        }
    }

    /// The type of a part of a structure.
    fn declared_part(&mut self, one: &Declared, around: &[&[Declared]]) -> Result<TypeId, Fault> {
        let ty = self.find_type(&one.of, around, one.line)?;
        self.refers_to_nothing(ty, one.initial.as_ref(), one.line)?;
        Ok(ty)
    }

    /// Refuses a type that says what its references mean at first: only declarations of variables are asked for that.
    fn refers_to_nothing(
        &self,
        ty: TypeId,
        initial: Option<&ast::Expr>,
        line: u32,
    ) -> Result<(), Fault> {
        fn names(one: &ast::Expr) -> bool {
            let is_null = |path: &ast::Path| path.as_name().is_some_and(|name| same(name, "NULL"));
            matches!(one, ast::Expr::Variable(path) if !is_null(path))
                || one.operands().into_iter().any(names)
        }
        let is_reference = |of: &Type| matches!(of, Type::Reference(..) | Type::Interface(_));
        let refers = match initial.is_some_and(names) || calls(initial) {
            // The variables of blocks are not known yet.
            true => self.tree.holds(ty, &|of| {
                is_reference(of) || (calls(initial) && matches!(of, Type::Block(_)))
            }),
            false => false,
        };
        if !refers {
            return Ok(());
        }
        let told = "what references mean at first is said by a type, which is not followed";
        let help = "give the variable of this type an initial value, or assign it in the program";
        Err(Fault::new(line, told).code(Code::NotModelled).help(help))
    }

    /// The type of instances of a unit.
    pub(super) fn block(&mut self, unit: UnitId) -> TypeId {
        self.tree.types.id(Type::Block(unit))
    }

    /// The number of the first value of an enumeration, which its variables begin with unless a declaration says
    /// another.
    pub(super) fn first_named(&self, of: &TypeRef, around: &[&[Declared]]) -> Option<i64> {
        match of {
            TypeRef::Enumeration(values, _) => match values.first()? {
                (_, Some(number)) => self.constants.number(number, around),
                (_, None) => Some(0),
            },
            TypeRef::Named(name) => {
                let own = &self.project.types[self.index.declared_type(name)?];
                let is_one = matches!(own.of, TypeRef::Enumeration(..)) && own.initial.is_none();
                is_one.then(|| self.first_named(&own.of, &[]))?
            }
            _ => None,
        }
    }

    /// Whether what a type gives its variables at first calls anything.
    pub(super) fn type_calls(&self, of: &TypeRef, seen: &mut Vec<String>) -> bool {
        match of {
            TypeRef::Array(_, of) | TypeRef::Subrange(of, _) => self.type_calls(of, seen),
            TypeRef::Struct(parts) => parts
                .iter()
                .any(|one| calls(one.initial.as_ref()) || self.type_calls(&one.of, seen)),
            TypeRef::Named(name) => {
                let key = name.to_ascii_uppercase();
                if seen.contains(&key) {
                    return false;
                }
                seen.push(key);
                let own = self.index.declared_type(name).map(|at| &self.project.types[at]);
                let unit = self.index.unit(name).map(|unit| self.tree.lineage(unit));
                let units = unit.unwrap_or_default().into_iter();
                let mut variables =
                    units.flat_map(|unit| &self.project.pous[unit.index()].variables);
                own.is_some_and(|own| calls(own.initial.as_ref()) || self.type_calls(&own.of, seen))
                    || variables
                        .any(|one| calls(one.initial.as_ref()) || self.type_calls(&one.of, seen))
            }
            _ => false,
        }
    }
}

/// Whether an initial value calls anything.
fn calls(one: Option<&ast::Expr>) -> bool {
    fn within(one: &ast::Expr) -> bool {
        let indices = match one {
            ast::Expr::Variable(path) => &path.rest[..],
            _ => &[],
        };
        let calls =
            |part: &ast::Part| matches!(part, ast::Part::Index(all) if all.iter().any(within));
        matches!(one, ast::Expr::Call(..))
            || indices.iter().any(calls)
            || one.operands().into_iter().any(within)
    }
    one.is_some_and(within)
}

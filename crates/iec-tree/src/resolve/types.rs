//! Resolution of type references to type ids.

use super::resolver::{Resolver, named};
use crate::blocks::StandardBlock;
use crate::declarations::UnitId;
use crate::types::{Elementary, Refers, TEXT, Type, TypeId};
use scanbound_base::code::Code;
use scanbound_base::facts::key;
use scanbound_iec::Variable as Declared;
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, TypeRef, ast, same};

/// The assumed length, in characters, of a string whose declared length is not constant.
const LONGEST_TEXT: u32 = 65_535;

/// Whether a type is elementary or a string by its standard name. Variables of such types start with 0 or empty;
/// enumerations and declared types may have another default.
pub(super) fn is_elementary(of: &TypeRef) -> bool {
    named(of).is_some_and(is_elementary_name)
}

/// Whether a name is that of an elementary or string type of the standard.
pub(super) fn is_elementary_name(name: &str) -> bool {
    let is_text = || ["STRING", "WSTRING"].iter().any(|own| scanbound_iec::same(own, name));
    Elementary::named(name).is_some() || is_text()
}

/// The fault of a unit or type that extends an unknown one.
pub(super) fn unknown_base(name: &str, base: &str, line: u32) -> Fault {
    Fault::new(line, format!("{name} extends {base}, which is not known"))
        .code(Code::UnknownType)
        .text(base)
        .help("give the file that declares it")
}

/// The help for an undeclared name: `first`, then how to declare and state the time of a library's block or function.
pub(super) fn declare(first: &str, name: &str) -> String {
    format!(
        "{first}; for a block or function of a library, declare its inputs and outputs without a body, and state its time in a facts file (--facts): [calls] {} = {{ time = \"50us\" }}",
        key(name)
    )
}

impl<'p> Resolver<'p> {
    /// The id of a type; names in it are hidden by the variables `around`. A fault gives a [`Type::Faulty`].
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
                    let told = "an array's bound is not a constant";
                    constant(own, one).ok_or_else(|| Fault::new(line, told).code(Code::UnknownType))
                };
                let mut bounds = Vec::new();
                for (low, high) in dimensions {
                    bounds.push((bound(self, low)?, bound(self, high)?));
                }
                if bounds.iter().any(|(low, high)| low > high) {
                    let told = "an array's upper bound is below its lower bound";
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
            // Known bases were merged into the structure when all files were read, so the remaining one is unknown.
            if let Some(base) = &own.extends {
                return Err(unknown_base(&own.name, base, line));
            }
            if let Some(&known) = self.index.known_types.get(&at) {
                return Ok(known);
            }
            if let TypeRef::Struct(parts) = &own.of {
                // Register the id first, because the structure may refer to itself.
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

    /// The type of a structure's field.
    fn declared_part(&mut self, one: &Declared, around: &[&[Declared]]) -> Result<TypeId, Fault> {
        let ty = self.find_type(&one.of, around, one.line)?;
        self.refers_to_nothing(ty, one.initial.as_ref(), one.line)?;
        Ok(ty)
    }

    /// Rejects a type whose default initial value sets references. Only initial values in variable declarations are
    /// analysed for targets.
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
            // The variables of blocks are not declared yet, so any block is rejected if the value contains a call.
            true => self.tree.holds(ty, &|of| {
                is_reference(of) || (calls(initial) && matches!(of, Type::Block(_)))
            }),
            false => false,
        };
        if !refers {
            return Ok(());
        }
        let told = "a type gives references an initial value, which is not followed";
        let help = "give the variable of this type an initial value, or assign it in the program";
        Err(Fault::new(line, told).code(Code::NotModelled).help(help))
    }

    /// The type of instances of a unit.
    pub(super) fn block(&mut self, unit: UnitId) -> TypeId {
        self.tree.types.id(Type::Block(unit))
    }

    /// The number of an enumeration type's first value, the default of its variables. `None` if it is unknown, if the
    /// type is no enumeration, or if its declaration states another default.
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

    /// Whether the default initial value of a type contains a call, at any depth. `seen` holds the names already
    /// visited.
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

/// Whether an initial value contains a call, also in indices.
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

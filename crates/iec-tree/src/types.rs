//! Types: elementary ones by name, all others by number.

use crate::blocks::StandardBlock;
pub use crate::elementary::{DINT, Elementary, INT, Kind, common, holding, time_in_units};
use crate::ids::UnitId;
use scanbound_iec::fault::Fault;
use std::collections::BTreeMap;

/// How something refers to a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refers {
    /// `POINTER TO`: `p^` is the variable.
    Pointer,
    /// `REFERENCE TO`: its name is the variable.
    Reference,
}

/// A type, by its number among [`Types`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct TypeId(u32);

/// A structure, by its number among [`Types`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct StructId(u32);

/// The most characters of a text that is declared without a length: 80 with CODESYS, 126 with matiec, 254 with Siemens.
pub const TEXT: u32 = 254;

/// A type.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Type {
    /// One of the standard's; enumerations and subranges are the type of their numbers.
    Elementary(Elementary),
    /// Text of at most so many characters.
    Text(u32),
    /// An array, with the first and the last index of each dimension.
    Array(Vec<(i64, i64)>, TypeId),
    /// A structure of the project's.
    Struct(StructId),
    /// A function block of the standard's.
    Standard(StandardBlock),
    /// A function block of the project's, or the variables of a program or a function.
    Block(UnitId),
    /// An interface: it stands for an instance.
    Interface(UnitId),
    /// A reference or a pointer to a variable.
    Reference(Refers, TypeId),
    /// A whole constant that has no type of its own yet.
    Untyped,
    /// A value of which even the type is not followed.
    Unknown,
    /// No value: what a call gives that has no result.
    Nothing,
    /// What is written is no type; why, by its number among the faults.
    Faulty(u32),
}

/// The types of a project, each once.
#[derive(Debug)]
pub struct Types {
    all: Vec<Type>,
    known: BTreeMap<Type, TypeId>,
    /// The parts of each structure: their names and types.
    structs: Vec<Vec<(String, TypeId)>>,
    faults: Vec<Fault>,
}

impl Default for Types {
    fn default() -> Types {
        let mut types = Types {
            all: Vec::new(),
            known: BTreeMap::new(),
            structs: Vec::new(),
            faults: Vec::new(),
        };
        for one in Elementary::ALL {
            types.id(Type::Elementary(one));
        }
        types
    }
}

impl Types {
    /// The id of a type.
    pub fn id(&mut self, of: Type) -> TypeId {
        if let Some(&known) = self.known.get(&of) {
            return known;
        }
        let id = TypeId(u32::try_from(self.all.len()).unwrap_or(u32::MAX));
        self.all.push(of.clone());
        self.known.insert(of, id);
        id
    }

    /// The id of a type, if anything has it.
    #[must_use]
    pub fn find(&self, of: &Type) -> Option<TypeId> {
        self.known.get(of).copied()
    }

    /// The id of an elementary type.
    #[must_use]
    pub fn elementary(&self, of: Elementary) -> TypeId {
        TypeId(of as u32)
    }

    /// The type of an id.
    #[must_use]
    pub fn get(&self, id: TypeId) -> &Type {
        &self.all[id.index()]
    }

    /// Whether there are references, pointers or interfaces.
    #[must_use]
    pub fn has_references(&self) -> bool {
        self.all.iter().any(|one| matches!(one, Type::Reference(..) | Type::Interface(_)))
    }

    /// Whether a type is that of references, pointers or interfaces.
    #[must_use]
    pub fn is_reference(&self, id: TypeId) -> bool {
        matches!(self.get(id), Type::Reference(..) | Type::Interface(_))
    }

    /// How many types there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// A structure whose parts are told later ([`Types::set_parts`]).
    pub fn new_struct(&mut self) -> StructId {
        self.structs.push(Vec::new());
        StructId(u32::try_from(self.structs.len() - 1).unwrap_or(u32::MAX))
    }

    /// Tells the parts of a structure.
    pub fn set_parts(&mut self, id: StructId, parts: Vec<(String, TypeId)>) {
        self.structs[id.0 as usize] = parts;
    }

    /// The parts of a structure.
    #[must_use]
    pub fn parts(&self, id: StructId) -> &[(String, TypeId)] {
        &self.structs[id.0 as usize]
    }

    /// What is no type, and why.
    pub fn faulty(&mut self, fault: Fault) -> TypeId {
        let at = self.faults.iter().position(|one| *one == fault).unwrap_or_else(|| {
            self.faults.push(fault);
            self.faults.len() - 1
        });
        self.id(Type::Faulty(u32::try_from(at).unwrap_or(u32::MAX)))
    }

    /// Why something is no type.
    #[must_use]
    pub fn fault(&self, at: u32) -> Fault {
        self.faults[at as usize].clone()
    }

    /// The kind of number that a type is, if it is one.
    #[must_use]
    pub fn kind(&self, id: TypeId) -> Option<Kind> {
        match self.get(id) {
            Type::Elementary(of) => of.kind(),
            _ => None,
        }
    }
}

impl TypeId {
    /// Its number.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

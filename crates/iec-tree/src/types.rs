//! Types of variables and values, each stored once and referred to by an id.

use crate::blocks::StandardBlock;
pub use crate::elementary::{DINT, Elementary, INT, Kind, common, holding, time_in_units};
use crate::ids::UnitId;
use scanbound_iec::fault::Fault;
use std::collections::BTreeMap;

/// The kind of a reference to a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refers {
    /// `POINTER TO`: `p^` names the variable.
    Pointer,
    /// `REFERENCE TO`: the reference's own name names the variable.
    Reference,
}

/// The id of a type: its index in [`Types`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct TypeId(u32);

/// The id of a structure type: its index in [`Types`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct StructId(u32);

/// The assumed length, in characters, of a string declared without a length. It is the largest default of these: 80 in
/// CODESYS, 126 in matiec, 254 at Siemens.
pub const TEXT: u32 = 254;

/// The longest result of a conversion to a text, in characters: 255 in CODESYS, 254 at Siemens.
pub const CONVERTED_TEXT: u32 = 255;

/// The type of a variable or a value.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Type {
    /// An elementary type of the standard. Enumerations and subranges have the type of their numbers.
    Elementary(Elementary),
    /// A string of at most this many characters.
    Text(u32),
    /// An array: the lower and upper bound of each dimension, and the element type.
    Array(Vec<(i64, i64)>, TypeId),
    /// A structure declared in the project.
    Struct(StructId),
    /// A standard function block, such as `TON`.
    Standard(StandardBlock),
    /// A function block declared in the project, or the variables of a program or function.
    Block(UnitId),
    /// An interface: a value of it refers to an instance of a block.
    Interface(UnitId),
    /// A reference or pointer to a variable of the given type.
    Reference(Refers, TypeId),
    /// An integer literal that has not yet received a type from its context.
    Untyped,
    /// A value whose type is not known.
    Unknown,
    /// No value: the type of a call without a result.
    Nothing,
    /// A faulty type; the index gives the reason ([`Types::fault`]).
    Faulty(u32),
}

/// All types of a project, without duplicates.
#[derive(Debug)]
pub struct Types {
    all: Vec<Type>,
    known: BTreeMap<Type, TypeId>,
    /// The field names and types of each structure.
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
    /// The id of a type, which is added if it is new.
    pub fn id(&mut self, of: Type) -> TypeId {
        if let Some(&known) = self.known.get(&of) {
            return known;
        }
        let id = TypeId(u32::try_from(self.all.len()).unwrap_or(u32::MAX));
        self.all.push(of.clone());
        self.known.insert(of, id);
        id
    }

    /// The id of a type; `None` if the project does not contain it.
    #[must_use]
    pub fn find(&self, of: &Type) -> Option<TypeId> {
        self.known.get(of).copied()
    }

    /// The id of an elementary type.
    #[must_use]
    pub fn elementary(&self, of: Elementary) -> TypeId {
        TypeId(of as u32)
    }

    /// The type with this id.
    #[must_use]
    pub fn get(&self, id: TypeId) -> &Type {
        &self.all[id.index()]
    }

    /// Whether the project contains any reference, pointer or interface type.
    #[must_use]
    pub fn has_references(&self) -> bool {
        self.all.iter().any(|one| matches!(one, Type::Reference(..) | Type::Interface(_)))
    }

    /// Whether the type itself is a reference, pointer or interface.
    #[must_use]
    pub fn is_reference(&self, id: TypeId) -> bool {
        matches!(self.get(id), Type::Reference(..) | Type::Interface(_))
    }

    /// The length of the longest string type of the project. 0 if there is none.
    #[must_use]
    pub fn longest_text(&self) -> u32 {
        let length = |one: &Type| match one {
            Type::Text(length) => Some(*length),
            _ => None,
        };
        self.all.iter().filter_map(length).max().unwrap_or(0)
    }

    /// The number of types.
    #[must_use]
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Adds a structure type without fields. [`Types::set_parts`] sets them later, so that a structure may refer to
    /// itself.
    pub fn new_struct(&mut self) -> StructId {
        self.structs.push(Vec::new());
        StructId(u32::try_from(self.structs.len() - 1).unwrap_or(u32::MAX))
    }

    /// Sets the fields of a structure.
    pub fn set_parts(&mut self, id: StructId, parts: Vec<(String, TypeId)>) {
        self.structs[id.0 as usize] = parts;
    }

    /// The fields of a structure: names and types, in order of declaration.
    #[must_use]
    pub fn parts(&self, id: StructId) -> &[(String, TypeId)] {
        &self.structs[id.0 as usize]
    }

    /// The id of a faulty type, with the reason.
    pub fn faulty(&mut self, fault: Fault) -> TypeId {
        let at = self.faults.iter().position(|one| *one == fault).unwrap_or_else(|| {
            self.faults.push(fault);
            self.faults.len() - 1
        });
        self.id(Type::Faulty(u32::try_from(at).unwrap_or(u32::MAX)))
    }

    /// The reason for the [`Type::Faulty`] with this index.
    #[must_use]
    pub fn fault(&self, at: u32) -> Fault {
        self.faults[at as usize].clone()
    }

    /// The kind of number of an elementary type; `None` for `BOOL` and for all other types.
    #[must_use]
    pub fn kind(&self, id: TypeId) -> Option<Kind> {
        match self.get(id) {
            Type::Elementary(of) => of.kind(),
            _ => None,
        }
    }
}

impl TypeId {
    /// Its index in [`Types`].
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

//! Types: elementary ones by name, all others by number.

use crate::blocks::StandardBlock;
use crate::declarations::UnitId;
use scanbound_iec::fault::Fault;
use std::collections::BTreeMap;

/// A number's type as it is computed with: how many bits it has, and how they are read. Times are milliseconds in 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A whole number, or a string of bits.
    Whole {
        /// How many bits.
        bits: u8,
        /// Whether the highest one is a sign.
        signed: bool,
    },
    /// `REAL`
    Real,
    /// `TIME`
    Time,
    /// A number of so many words whose arithmetic is not followed: long reals, dates.
    Opaque(u8),
}

/// `INT`
pub const INT: Kind = Kind::Whole { bits: 16, signed: true };
/// `DINT`
pub const DINT: Kind = Kind::Whole { bits: 32, signed: true };

impl Kind {
    /// How many words of 16 bits it takes.
    #[must_use]
    pub fn words(self) -> u32 {
        match self {
            Kind::Whole { bits, .. } => u32::from(bits.div_ceil(16)),
            Kind::Real | Kind::Time => 2,
            Kind::Opaque(words) => u32::from(words),
        }
    }

    /// Whether it has a sign.
    #[must_use]
    pub fn is_signed(self) -> bool {
        !matches!(self, Kind::Whole { signed: false, .. })
    }
}

/// The kind in which a number meets a constant: its own where the constant fits, else one that holds both.
#[must_use]
pub fn holding(kind: Kind, value: i64) -> Kind {
    let Kind::Whole { bits, signed } = kind else { return kind };
    let (least, most) = match signed {
        true => (-(1_i128 << (bits - 1)), (1 << (bits - 1)) - 1),
        false => (0, (1 << bits) - 1),
    };
    let fits = |bits: u32| (-(1_i128 << (bits - 1))..1 << (bits - 1)).contains(&value.into());
    match value {
        value if (least..=most).contains(&value.into()) => kind,
        _ if bits < 32 && fits(32) => DINT,
        _ if bits < 64 => Kind::Whole { bits: 64, signed: true },
        _ => Kind::Opaque(4),
    }
}

/// The kind in which two numbers meet.
#[must_use]
pub fn common(one: Kind, two: Kind) -> Kind {
    let rank = |kind: Kind| match kind {
        Kind::Whole { bits, .. } => u32::from(bits),
        Kind::Time => 100,
        Kind::Real => 200,
        Kind::Opaque(_) => 300,
    };
    match (one, two) {
        (Kind::Whole { bits, signed }, Kind::Whole { bits: other, signed: also })
            if signed != also =>
        {
            let (with_sign, without) = if signed { (bits, other) } else { (other, bits) };
            if with_sign > without {
                return Kind::Whole { bits: with_sign, signed: true };
            }
            // Both must fit; there is nothing wider than 64 bits.
            match bits.max(other) {
                64.. => Kind::Opaque(4),
                bits => Kind::Whole { bits: bits * 2, signed: true },
            }
        }
        _ if rank(one) >= rank(two) => one,
        _ => two,
    }
}

/// The standard's elementary types but texts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "their names are the standard's")]
pub enum Elementary {
    Bool,
    Sint,
    Int,
    Dint,
    Lint,
    Usint,
    Uint,
    Udint,
    Ulint,
    Byte,
    Word,
    Dword,
    Lword,
    Real,
    Lreal,
    Time,
    /// A long time, a date or a time of day.
    Date,
}

impl Elementary {
    /// All, in the order of their ids ([`Types::elementary`]).
    pub const ALL: [Elementary; 17] = [
        Elementary::Bool,
        Elementary::Sint,
        Elementary::Int,
        Elementary::Dint,
        Elementary::Lint,
        Elementary::Usint,
        Elementary::Uint,
        Elementary::Udint,
        Elementary::Ulint,
        Elementary::Byte,
        Elementary::Word,
        Elementary::Dword,
        Elementary::Lword,
        Elementary::Real,
        Elementary::Lreal,
        Elementary::Time,
        Elementary::Date,
    ];

    /// The type of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Elementary> {
        use Elementary as E;
        Some(match name.to_ascii_uppercase().as_str() {
            "BOOL" | "BIT" => E::Bool,
            "SINT" => E::Sint,
            "INT" => E::Int,
            "DINT" => E::Dint,
            "LINT" => E::Lint,
            "USINT" | "CHAR" => E::Usint,
            "BYTE" => E::Byte,
            "UINT" | "WCHAR" => E::Uint,
            "WORD" => E::Word,
            "UDINT" => E::Udint,
            "DWORD" => E::Dword,
            "ULINT" => E::Ulint,
            "LWORD" => E::Lword,
            "REAL" => E::Real,
            "LREAL" => E::Lreal,
            "TIME" => E::Time,
            "LTIME" | "DATE" | "DT" | "DATE_AND_TIME" | "TOD" | "TIME_OF_DAY" | "LDATE" | "LDT"
            | "LTOD" => E::Date,
            _ => return None,
        })
    }

    /// As what it is computed with; nothing for a truth value.
    #[must_use]
    pub fn kind(self) -> Option<Kind> {
        use Elementary as E;
        let whole = |bits, signed| Some(Kind::Whole { bits, signed });
        match self {
            E::Bool => None,
            E::Sint => whole(8, true),
            E::Int => whole(16, true),
            E::Dint => whole(32, true),
            E::Lint => whole(64, true),
            E::Usint | E::Byte => whole(8, false),
            E::Uint | E::Word => whole(16, false),
            E::Udint | E::Dword => whole(32, false),
            E::Ulint | E::Lword => whole(64, false),
            E::Real => Some(Kind::Real),
            E::Time => Some(Kind::Time),
            E::Lreal | E::Date => Some(Kind::Opaque(4)),
        }
    }

    /// The type that holds what a kind of number gives.
    #[must_use]
    pub fn of(kind: Kind) -> Elementary {
        use Elementary as E;
        match kind {
            Kind::Whole { bits: ..=8, signed: true } => E::Sint,
            Kind::Whole { bits: ..=8, signed: false } => E::Usint,
            Kind::Whole { bits: ..=16, signed: true } => E::Int,
            Kind::Whole { bits: ..=16, signed: false } => E::Uint,
            Kind::Whole { bits: ..=32, signed: true } => E::Dint,
            Kind::Whole { bits: ..=32, signed: false } => E::Udint,
            Kind::Whole { signed: true, .. } => E::Lint,
            Kind::Whole { signed: false, .. } => E::Ulint,
            Kind::Real => E::Real,
            Kind::Time => E::Time,
            Kind::Opaque(_) => E::Lreal,
        }
    }

    /// Whether it is a string of bits.
    #[must_use]
    pub fn is_bits(self) -> bool {
        use Elementary as E;
        matches!(self, E::Byte | E::Word | E::Dword | E::Lword)
    }
}

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

/// A structure: its name, if it has one, and the names and types of its parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Struct {
    /// The parts in their order.
    pub parts: Vec<(String, TypeId)>,
}

/// The types of a project, each once.
#[derive(Debug)]
pub struct Types {
    all: Vec<Type>,
    known: BTreeMap<Type, TypeId>,
    structs: Vec<Struct>,
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
        let at = Elementary::ALL.iter().position(|&one| one == of).unwrap_or(0);
        TypeId(u32::try_from(at).unwrap_or(0))
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

    /// How many types there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// A structure whose parts are told later ([`Types::set_parts`]).
    pub fn new_struct(&mut self) -> StructId {
        self.structs.push(Struct { parts: Vec::new() });
        StructId(u32::try_from(self.structs.len() - 1).unwrap_or(u32::MAX))
    }

    /// Tells the parts of a structure.
    pub fn set_parts(&mut self, id: StructId, parts: Vec<(String, TypeId)>) {
        self.structs[id.0 as usize].parts = parts;
    }

    /// The parts of a structure.
    #[must_use]
    pub fn parts(&self, id: StructId) -> &[(String, TypeId)] {
        &self.structs[id.0 as usize].parts
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

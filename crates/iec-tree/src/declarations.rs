//! What a project declares, by ids: units, routines, variables.

pub use crate::charts::Code;
use crate::code::Expr;
pub use crate::code::Stated;
pub use crate::ids::{AddressId, RoutineId, TempId, UnitId, VarId};
use crate::types::TypeId;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Language, PouKind, Section};

/// Whose a variable is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Owner {
    /// Each instance of a unit has its own; a function has one instance.
    Unit(UnitId),
    /// A method has its own, one for each instance.
    Routine(RoutineId),
    /// It is global: the number of its list.
    Global(usize),
}

/// What a variable begins with where its declaration says nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum First {
    /// 0, as the standard's elementary types do.
    Zero,
    /// The first value of its enumeration.
    Number(i64),
    /// It is not followed.
    Unknown,
}

/// What a variable begins with before the first scan, as its declaration and its type say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Initial {
    /// 0, with all that it has.
    Zero,
    /// A number that is not 0: 1 for a bit that is on, half milliseconds for a time, the bits of a real.
    Number(i64),
    /// What each part begins with, of a structure or a block of the standard's.
    Parts(Vec<Initial>),
    /// What each element begins with; the last index counts fastest.
    Elements(Vec<Initial>),
    /// Something that is not worked out.
    Unknown,
    /// Nothing is said here: of text, and of what stands in instances of the project's blocks.
    Nothing,
}

impl Initial {
    /// Whether all of it begins with 0.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        match self {
            Initial::Zero => true,
            Initial::Parts(all) | Initial::Elements(all) => {
                !all.is_empty() && all.iter().all(Initial::is_zero)
            }
            Initial::Number(_) | Initial::Unknown | Initial::Nothing => false,
        }
    }

    /// Of how many variables without parts it says something.
    #[must_use]
    pub fn size(&self) -> usize {
        match self {
            Initial::Parts(all) | Initial::Elements(all) => all.iter().map(Initial::size).sum(),
            Initial::Nothing => 0,
            Initial::Zero | Initial::Number(_) | Initial::Unknown => 1,
        }
    }

    /// Whether any of it is a number that is known.
    #[must_use]
    pub fn has_number(&self) -> bool {
        match self {
            Initial::Parts(all) | Initial::Elements(all) => all.iter().any(Initial::has_number),
            Initial::Number(_) => true,
            Initial::Zero | Initial::Unknown | Initial::Nothing => false,
        }
    }
}

/// A variable.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Its name, for messages.
    pub name: String,
    /// Variables of one name have one number: a method that takes another one's place is passed what that one is.
    pub symbol: u32,
    /// Its section.
    pub section: Section,
    /// Its type.
    pub ty: TypeId,
    /// Whose it is.
    pub owner: Owner,
    /// What its declaration gives it at first.
    pub initial: Option<Expr>,
    /// What it begins with without that.
    pub first: First,
    /// What it begins with before the first scan.
    pub begins: Initial,
    /// Whether what its type gives it at first calls anything.
    pub type_calls: bool,
    /// Its address.
    pub at: Option<String>,
    /// Whether nothing writes it.
    pub constant: bool,
    /// Whether it keeps its value when the power fails.
    pub retain: bool,
    /// Whether a reader made it: the memory of an edge, or of what a drawing reads before it is worked out.
    pub is_internal: bool,
    /// Its line.
    pub line: u32,
}

/// A program organization unit.
#[derive(Debug, Clone)]
pub struct Unit {
    /// Its name, for messages.
    pub name: String,
    /// What it is.
    pub kind: PouKind,
    /// The unit that it extends.
    pub base: Option<UnitId>,
    /// The interfaces that it implements, those that these extend among them.
    pub interfaces: Vec<UnitId>,
    /// Its own variables in their order; of a function its result is the last.
    pub variables: Vec<VarId>,
    /// Its result, of a function.
    pub result: Option<VarId>,
    /// Its body.
    pub body: RoutineId,
    /// Its actions.
    pub actions: Vec<RoutineId>,
    /// Its methods.
    pub methods: Vec<RoutineId>,
    /// Why instances of it cannot be laid out, if they cannot.
    pub fault: Option<Fault>,
    /// Whether it keeps all its variables when the power fails.
    pub retain: bool,
    /// Its methods that are executed before the first scan for each instance (`FB_Init`, `FB_Reinit`).
    pub begins_with: Vec<RoutineId>,
    /// Whether a method is executed when its instances begin or end.
    pub begins_with_method: bool,
    /// Its file.
    pub file: usize,
    /// Its line.
    pub line: u32,
}

/// What of a unit a routine is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RoutineKind {
    /// Its body.
    Body,
    /// An action.
    Action,
    /// A method.
    Method,
}

impl Variable {
    /// Whether it is a constant that has its value whenever a scan begins. Inputs may be constant, too, and are handed
    /// over.
    #[must_use]
    pub fn is_given(&self) -> bool {
        let is_own = matches!(self.section, Section::Local | Section::Global);
        self.constant && self.at.is_none() && is_own
    }
}

/// A body, an action or a method.
#[derive(Debug, Clone)]
pub struct Routine {
    /// Its name, for messages; of a body that of its unit.
    pub name: String,
    /// Its unit.
    pub unit: UnitId,
    /// What of the unit it is.
    pub kind: RoutineKind,
    /// Routines of one kind and name have one number: what extends a unit may put its own in the place of the unit's.
    pub slot: u32,
    /// The variables of a method; its result is the last.
    pub variables: Vec<VarId>,
    /// The result of a method.
    pub result: Option<VarId>,
    /// The language in which it is written.
    pub language: Language,
    /// What it does.
    pub code: Code,
    /// Whether only its unit may call it.
    pub is_private: bool,
    /// What the user states of it, if its code is not there.
    pub stated: Option<Stated>,
    /// Its line.
    pub line: u32,
}

/// A list of global variables.
#[derive(Debug, Clone)]
pub struct GlobalList {
    /// Its name; empty where it has none.
    pub name: String,
    /// Its variables.
    pub variables: Vec<VarId>,
}

/// What a value is kept for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Purpose {
    /// It leads on from one statement to others, as the processor's result does.
    Between,
    /// It is the result of a drawn function: generators store it, and load it again.
    Result,
    /// It is stored as part of something else, and only loaded again.
    Loaded,
    /// It is the result of each of the ways that meet at a label.
    Merged,
}

/// A value that a list or a drawing keeps.
#[derive(Debug, Clone)]
pub struct Temporary {
    /// What for.
    pub purpose: Purpose,
    /// Its type.
    pub ty: TypeId,
    /// Where it comes from, for messages.
    pub text: String,
}

/// A direct address.
#[derive(Debug, Clone)]
pub struct Address {
    /// As it is written, in capitals.
    pub text: String,
    /// The type of what lies there.
    pub ty: TypeId,
}

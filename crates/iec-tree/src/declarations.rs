//! Declarations of a project: units, routines and variables, referred to by ids.

pub use crate::charts::Code;
use crate::code::Expr;
pub use crate::code::Stated;
pub use crate::ids::{AddressId, RoutineId, TempId, UnitId, VarId};
use crate::types::TypeId;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Language, PouKind, Section};

/// The scope that owns a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Owner {
    /// A unit: each instance has its own copy. A function has a single instance.
    Unit(UnitId),
    /// A method: each instance of its unit has its own copy.
    Routine(RoutineId),
    /// A list of global variables, by its index in [`crate::tree::Tree::globals`].
    Global(usize),
}

/// The initial value that a variable's type gives it if its declaration states none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum First {
    /// 0: the default of the standard's elementary types and texts.
    Zero,
    /// The first value of its enumeration type.
    Number(i64),
    /// Not determined.
    Unknown,
}

/// The value of a variable before the first scan, from its declaration and its type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Initial {
    /// 0, in all of its parts.
    Zero,
    /// A nonzero number: 1 for a true bit; a time in units of 0.5 ms; the IEEE 754 bits of a `REAL`.
    Number(i64),
    /// The values of a structure's fields, or of a standard block's pins in memory order.
    Parts(Vec<Initial>),
    /// The values of an array's elements in memory order: the last index varies fastest.
    Elements(Vec<Initial>),
    /// The value was not computed and may be anything.
    Unknown,
    /// No statement here: text, and the variables inside instances of the project's own blocks.
    Nothing,
}

impl Initial {
    /// Whether every part is 0. `false` for an empty list.
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

    /// The number of elementary values that it describes; [`Initial::Nothing`] counts as 0.
    #[must_use]
    pub fn size(&self) -> usize {
        match self {
            Initial::Parts(all) | Initial::Elements(all) => all.iter().map(Initial::size).sum(),
            Initial::Nothing => 0,
            Initial::Zero | Initial::Number(_) | Initial::Unknown => 1,
        }
    }

    /// Whether any part has a known nonzero number.
    #[must_use]
    pub fn has_number(&self) -> bool {
        match self {
            Initial::Parts(all) | Initial::Elements(all) => all.iter().any(Initial::has_number),
            Initial::Number(_) => true,
            Initial::Zero | Initial::Unknown | Initial::Nothing => false,
        }
    }
}

/// A declared variable.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Its name, for messages.
    pub name: String,
    /// The number of its name: variables of equal names share one. It matches parameters of a method to those of the
    /// method that it overrides.
    pub symbol: u32,
    /// The section of its declaration, such as `VAR_INPUT`.
    pub section: Section,
    /// Its type.
    pub ty: TypeId,
    /// The scope that owns it.
    pub owner: Owner,
    /// The initial value in its declaration, if one is written.
    pub initial: Option<Expr>,
    /// The initial value that its type gives if none is written.
    pub first: First,
    /// Its value before the first scan. For declared variables of methods it is [`Initial::Unknown`].
    pub begins: Initial,
    /// Whether the initial value given by its type contains a call.
    pub type_calls: bool,
    /// Its address (`AT %...`) as written, if it has one.
    pub at: Option<String>,
    /// Whether it is declared `CONSTANT`, so that nothing writes it.
    pub constant: bool,
    /// Whether it is retentive: it keeps its value without power.
    pub retain: bool,
    /// Whether the reader created it: the memory of an edge, or of a value that a drawing reads before computing it.
    pub is_internal: bool,
    /// Whether it is an input declared R_EDGE or F_EDGE.
    pub has_edge: bool,
    /// Its line, from 1.
    pub line: u32,
}

/// A program organization unit.
#[derive(Debug, Clone)]
pub struct Unit {
    /// Its name, for messages.
    pub name: String,
    /// The kind of unit: program, function block, function or interface.
    pub kind: PouKind,
    /// The unit that it extends; `None` if it extends none or that unit is unknown.
    pub base: Option<UnitId>,
    /// The interfaces that it implements, and those that these extend. For an interface, those that it extends.
    pub interfaces: Vec<UnitId>,
    /// Its own variables in order of declaration, without inherited ones; a function's result is the last.
    pub variables: Vec<VarId>,
    /// The result variable; `None` unless it is a function with a result.
    pub result: Option<VarId>,
    /// The routine of its body.
    pub body: RoutineId,
    /// The routines of its actions.
    pub actions: Vec<RoutineId>,
    /// The routines of its methods and property accessors.
    pub methods: Vec<RoutineId>,
    /// The fault that prevents instances of it, such as an unknown base; `None` if there is none.
    pub fault: Option<Fault>,
    /// Whether all of its variables are retentive.
    pub retain: bool,
    /// Its methods that run for each instance before the first scan (`FB_Init`, `FB_Reinit`).
    pub begins_with: Vec<RoutineId>,
    /// Whether it has a method that the controller calls by itself: `FB_Init`, `FB_Reinit` or `FB_Exit`.
    pub begins_with_method: bool,
    /// The index of its file.
    pub file: usize,
    /// Its line, from 1.
    pub line: u32,
}

/// The role of a routine in its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RoutineKind {
    /// The body.
    Body,
    /// An action.
    Action,
    /// A method or a property accessor.
    Method,
}

impl Variable {
    /// Whether it is a constant with a fixed value in every scan: a local or global `CONSTANT` without an address.
    /// Constant inputs are excluded, because the caller sets them.
    #[must_use]
    pub fn is_given(&self) -> bool {
        let is_own = matches!(self.section, Section::Local | Section::Global);
        self.constant && self.at.is_none() && is_own
    }
}

/// A body, an action or a method.
#[derive(Debug, Clone)]
pub struct Routine {
    /// Its name, for messages; for a body, the name of its unit.
    pub name: String,
    /// The unit that contains it.
    pub unit: UnitId,
    /// Its role in the unit.
    pub kind: RoutineKind,
    /// Equal for routines of the same kind and name, so that a derived unit's routine is found as the override of its
    /// base's.
    pub slot: u32,
    /// The variables of a method, its result last; empty for bodies and actions.
    pub variables: Vec<VarId>,
    /// The result variable of a method; `None` if it has none.
    pub result: Option<VarId>,
    /// The language in which it is written.
    pub language: Language,
    /// Its resolved code; no statements if the code is missing.
    pub code: Code,
    /// Whether the method is `PRIVATE`: only its own unit may call it.
    pub is_private: bool,
    /// The time and writes that the user states in a facts file for a routine without code.
    pub stated: Option<Stated>,
    /// Its line, from 1.
    pub line: u32,
}

/// A list of global variables.
#[derive(Debug, Clone)]
pub struct GlobalList {
    /// Its name; empty if it has none.
    pub name: String,
    /// Its variables.
    pub variables: Vec<VarId>,
}

/// The role of a temporary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Purpose {
    /// It carries an intermediate result from one statement to later ones, as an accumulator does.
    Between,
    /// It is the result of a drawn function. Generated code stores and reloads it.
    Result,
    /// Another part of the code already stores it; only loads are added.
    Loaded,
    /// It is the accumulator's value at a label: each path to the label stores it.
    Merged,
}

/// A temporary of a statement list or a drawing.
#[derive(Debug, Clone)]
pub struct Temporary {
    /// The reason for which the value is stored.
    pub purpose: Purpose,
    /// Its type.
    pub ty: TypeId,
    /// The source that computes it, for messages.
    pub text: String,
}

/// A direct address, such as `%IX0.1`.
#[derive(Debug, Clone)]
pub struct Address {
    /// The address as written, in capitals.
    pub text: String,
    /// The type of the data at the address.
    pub ty: TypeId,
}

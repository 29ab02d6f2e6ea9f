//! Programs as a tree: types, declarations, expressions and statements. Variables are named by what declares them and
//! their number there.

use std::rc::Rc;

/// A whole number, or a string of bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Number {
    pub name: &'static str,
    pub bits: u32,
    pub signed: bool,
    /// Whether it is a string of bits.
    pub is_bits: bool,
}

const fn number(name: &'static str, bits: u32, signed: bool, is_bits: bool) -> Number {
    Number { name, bits, signed, is_bits }
}

pub const NUMBERS: &[Number] = &[
    number("SINT", 8, true, false),
    number("INT", 16, true, false),
    number("DINT", 32, true, false),
    number("LINT", 64, true, false),
    number("USINT", 8, false, false),
    number("UINT", 16, false, false),
    number("UDINT", 32, false, false),
    number("ULINT", 64, false, false),
    number("BYTE", 8, false, true),
    number("WORD", 16, false, true),
    number("DWORD", 32, false, true),
    number("LWORD", 64, false, true),
];

impl Number {
    /// What of a value the type keeps.
    pub fn keep(self, value: i128) -> i128 {
        let low = value & ((1 << self.bits) - 1);
        if self.signed && low >> (self.bits - 1) & 1 == 1 { low - (1 << self.bits) } else { low }
    }

    pub fn holds(self, value: i128) -> bool {
        self.keep(value) == value
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum Ty {
    Bool,
    Number(Number),
    Real,
    Time,
    Text,
    /// The project's enumeration.
    Colour,
    Array(Rc<[(i128, i128)]>, Rc<Ty>),
    Struct(usize),
    /// A function block of the project's.
    Block(usize),
    /// One of the standard's.
    Standard(&'static str),
    /// The project's interface.
    Interface,
    Pointer(Rc<Ty>),
    Reference(Rc<Ty>),
}

/// The enumeration's values; a variable begins with the first.
pub const COLOURS: &[(&str, i128)] = &[("red", 2), ("green", 3), ("blue", 5), ("black", 0)];

impl Ty {
    pub fn named(name: &str) -> Ty {
        Ty::Number(*NUMBERS.iter().find(|one| one.name == name).expect("a type's name"))
    }

    pub fn int() -> Ty {
        Ty::named("INT")
    }

    pub fn as_number(&self) -> Option<Number> {
        if let Ty::Number(of) = self { Some(*of) } else { None }
    }

    /// Whether a variable of it holds a single value that can be compared and assigned.
    pub fn is_simple(&self) -> bool {
        matches!(self, Ty::Bool | Ty::Number(_) | Ty::Real | Ty::Time | Ty::Text | Ty::Colour)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Section {
    Local,
    Temp,
    Static,
    /// Of a method: kept by each instance.
    Instance,
    Input,
    Output,
    InOut,
    Constant,
    Retain,
}

/// What a variable begins with.
#[derive(Debug, Clone)]
pub enum Initial {
    Value(Expr),
    Elements(Vec<Expr>),
    /// Values of some parts by their names.
    Parts(Vec<(String, Expr)>),
}

#[derive(Debug, Clone)]
pub struct Variable {
    pub name: String,
    pub ty: Ty,
    pub section: Section,
    pub initial: Option<Initial>,
    /// Its direct address: `%MW4`.
    pub at: Option<String>,
}

impl Variable {
    pub fn new(name: &str, ty: Ty, section: Section) -> Variable {
        Variable { name: name.to_owned(), ty, section, initial: None, at: None }
    }

    pub fn begins(mut self, value: Expr) -> Variable {
        self.initial = Some(Initial::Value(value));
        self
    }

    pub fn at(mut self, address: &str) -> Variable {
        self.at = Some(address.to_owned());
        self
    }
}

/// A structure: its name, the structure that it extends, its parts.
#[derive(Debug, Clone)]
pub struct Struct {
    pub name: &'static str,
    pub base: Option<usize>,
    pub parts: Vec<Variable>,
}

/// A function or a method: its result, its variables, its statements.
#[derive(Debug, Clone)]
pub struct Routine {
    pub name: String,
    pub result: Option<Ty>,
    /// With a result, the first variable holds it.
    pub variables: Vec<Variable>,
    pub body: Vec<Statement>,
}

/// The way in which a property is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    Get,
    Set,
}

/// A function block, or the program.
#[derive(Debug, Clone)]
pub struct Block {
    pub name: String,
    pub base: Option<usize>,
    pub has_interface: bool,
    pub variables: Vec<Variable>,
    pub methods: Vec<Routine>,
    /// Properties: what reads or writes the value, which is the routine's first variable.
    pub properties: Vec<(Access, Routine)>,
    pub actions: Vec<(String, Vec<Statement>)>,
    pub body: Vec<Statement>,
}

#[derive(Debug, Clone)]
pub struct Project {
    pub structs: Vec<Struct>,
    pub globals: Vec<Variable>,
    pub functions: Vec<Routine>,
    /// The last one is the program.
    pub blocks: Vec<Block>,
}

/// What declares the variable with which a path begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Root {
    Global(usize),
    /// A variable of the instance whose code it is: the block that declares it, its number.
    Member(usize, usize),
    /// A variable of the routine.
    Local(usize),
    /// The instance itself.
    This,
    /// A direct address, by its number in [`ADDRESSES`].
    Address(usize),
}

/// Direct addresses that code names.
pub const ADDRESSES: &[(&str, &str)] =
    &[("%MW2", "WORD"), ("%MX5.1", "BOOL"), ("%MB4", "BYTE"), ("%MD1", "DWORD")];

#[derive(Debug, Clone)]
pub enum Step {
    Part(String),
    Member(usize, usize),
    Pin(&'static str),
    Element(Vec<Expr>),
    Bit(u32),
    Dereference,
}

#[derive(Debug, Clone)]
pub struct Place {
    pub root: Root,
    pub steps: Vec<Step>,
    pub ty: Ty,
}

impl Place {
    pub fn new(root: Root, ty: Ty) -> Place {
        Place { root, steps: Vec::new(), ty }
    }

    pub fn then(mut self, step: Step, ty: Ty) -> Place {
        self.steps.push(step);
        self.ty = ty;
        self
    }
}

#[derive(Debug, Clone)]
pub struct Expr {
    pub ty: Ty,
    pub kind: Kind,
}

#[derive(Debug, Clone)]
pub enum Kind {
    /// A number and how it is written: with its type, and in which base.
    Number(i128, bool, u32),
    Bool(bool),
    Real(f32),
    /// Milliseconds.
    Time(i128),
    Text(&'static str),
    Colour(usize),
    /// The address of nothing.
    Null,
    Read(Place),
    Not(Box<Expr>),
    Negate(Box<Expr>),
    Binary(&'static str, Box<Expr>, Box<Expr>),
    /// A value becomes one of a wider type, which is not written.
    Widen(Box<Expr>),
    Standard(String, Vec<Expr>),
    Call(Box<Call>),
    /// What a property gives: of an instance, or of the one whose code it is.
    Get(Option<Place>, &'static str),
    /// `ADR(x)` or `REF(x)`.
    Address(Place),
    /// `__ISVALIDREF(r)`
    IsValid(Place),
}

#[derive(Debug, Clone)]
pub enum Target {
    Function(usize),
    Instance(Place),
    Standard(Place, &'static str),
    /// A method of an instance, or of the one whose code it is.
    Method(Option<Place>, &'static str),
    /// `SUPER^.m()`, seen from this block.
    BaseMethod(usize, &'static str),
    /// `SUPER^()`, seen from this block.
    BaseBody(usize),
    /// An action, declared by this block.
    Action(Option<Place>, usize, usize),
}

#[derive(Debug, Clone)]
pub enum Argument {
    In(Expr),
    InOut(Place),
    Out(Place),
}

#[derive(Debug, Clone)]
pub struct Call {
    pub target: Target,
    /// What is passed, with the parameters' names.
    pub given: Vec<(String, Argument)>,
    /// Whether the names are left out.
    pub unnamed: bool,
    /// `EN`, and where `ENO` goes.
    pub enable: Option<(Expr, Option<Place>)>,
}

/// The lowest and highest values of the labels of a CASE.
pub type Ranges = Vec<(i128, i128)>;

#[derive(Debug, Clone)]
pub enum Statement {
    Assign(Place, Expr),
    /// A structure or an array becomes another one's value.
    Copy(Place, Place),
    /// `r REF= x;`
    Refer(Place, Place),
    /// `x S= c;` or `x R= c;`
    Latch(Place, bool, Expr),
    Call(Call),
    /// A property of an instance, or of the one whose code it is.
    Set(Option<Place>, &'static str, Expr),
    If(Vec<(Expr, Vec<Statement>)>, Vec<Statement>),
    Case(Expr, Vec<(Ranges, Vec<Statement>)>, Vec<Statement>),
    For(Box<For>),
    While(Expr, Vec<Statement>),
    Repeat(Vec<Statement>, Expr),
    Exit,
    Continue,
    Return,
}

#[derive(Debug, Clone)]
pub struct For {
    pub variable: Place,
    pub from: Expr,
    pub to: Expr,
    pub by: Option<i128>,
    pub body: Vec<Statement>,
}

impl Project {
    /// A block and those that it extends, the last the first of all.
    pub fn lineage(&self, block: usize) -> Vec<usize> {
        let mut found = vec![block];
        while let Some(base) = self.blocks[found[found.len() - 1]].base {
            found.push(base);
        }
        found
    }

    /// The parts of a structure, those that it inherits first.
    pub fn parts(&self, of: usize) -> Vec<&Variable> {
        let own = &self.structs[of];
        let mut found = own.base.map_or(Vec::new(), |base| self.parts(base));
        found.extend(&own.parts);
        found
    }

    /// The method that an instance of a block has under a name, with the block that declares it.
    pub fn method(&self, block: usize, name: &str) -> Option<(usize, &Routine)> {
        self.lineage(block).into_iter().find_map(|one| {
            let own = self.blocks[one].methods.iter().find(|method| method.name == name)?;
            Some((one, own))
        })
    }

    pub fn property(&self, block: usize, name: &str, access: Access) -> Option<(usize, &Routine)> {
        self.lineage(block).into_iter().find_map(|one| {
            let mut all = self.blocks[one].properties.iter();
            let own = all.find(|own| own.0 == access && own.1.name == name)?;
            Some((one, &own.1))
        })
    }

    /// The program's number among the blocks.
    pub fn program(&self) -> usize {
        self.blocks.len() - 1
    }
}

//! Typed expressions and statements.

use crate::blocks::{Pin, StandardBlock};
use crate::ids::{AddressId, RoutineId, TempId, UnitId, VarId};
use crate::standard::Function;
use crate::types::TypeId;
use scanbound_base::time::Picos;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use std::sync::Arc;

/// Where a path of a variable begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Root {
    /// A variable: of the instance whose code it is, of its routine, or a global one.
    Variable(VarId),
    /// The instance whose code it is.
    This,
    /// The instance of a program, by its number among those of the tree.
    Program(usize),
    /// A direct address.
    Address(AddressId),
    /// A value that is kept.
    Temporary(TempId),
    /// A variable that a reference means, by its number among those whose address is taken; only lowering has it.
    Target(u32),
}

/// A step of a path.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// A part of a structure, by its number.
    Part(usize),
    /// A variable of an instance.
    Member(VarId),
    /// A pin of an instance of a standard block.
    Pin(Pin),
    /// An element of an array, one index a dimension.
    Element(Vec<Expr>),
    /// A bit of a number.
    Bit(u8),
    /// What a reference, a pointer or an interface means.
    Dereference,
    /// The result of a method of an instance, as its last call left it; whether that of a base is meant.
    Result(RoutineId, bool),
}

/// A variable or a part of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Where its path begins.
    pub root: Root,
    /// How it goes on.
    pub steps: Vec<Step>,
    /// The type of what lies there.
    pub ty: TypeId,
    /// As it is written, for messages.
    pub text: Arc<str>,
}

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// The type of its value.
    pub ty: TypeId,
    /// Its line.
    pub line: u32,
}

/// What an expression is.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    /// A truth value.
    Bool(bool),
    /// A whole number as it is written, without a type.
    Whole(i64),
    /// A whole number that has a type of its own: a written one, or that of a constant.
    Typed(i64),
    /// The value of an enumeration, or of a constant without a type of its own.
    Named(i64),
    /// A real number as it is written.
    Real(String),
    /// A duration in nanoseconds.
    Time(i64),
    /// A long real or a date, which is not followed.
    Opaque,
    /// Text.
    Text(String),
    /// The value of a variable.
    Read(Place),
    /// Whether a step of a chart is active, or for how long.
    Step(Box<StepFlag>),
    /// The address of a variable.
    Address(Place),
    /// The address of nothing.
    Null,
    /// `NOT`
    Not(Box<Expr>),
    /// `-`
    Negate(Box<Expr>),
    /// Two operands of one type, and what is done with them.
    Binary(Operator, Box<Expr>, Box<Expr>),
    /// The value becomes one of the expression's type by itself.
    Convert(Box<Expr>),
    /// What the project's own functions and methods give.
    Call(Box<Call>),
    /// What a function of the standard's gives.
    Standard(Box<Applied>),
    /// What a value is made of that a declaration lists: elements, or parts by their numbers. It is not worked out.
    List(Vec<Expr>),
    /// A call, and what is worked out behind it: a part of what the call gives.
    After(Box<(Call, Expr)>),
    /// One of two values: controllers differ; of none, any value.
    Either(Option<Box<(Expr, Expr)>>),
    /// What is wrong with it.
    Fault(Box<Fault>),
}

/// A function of the standard's with its inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Applied {
    /// Which one.
    pub function: Function,
    /// Its name in capitals.
    pub name: String,
    /// Its inputs as they are written.
    pub inputs: Vec<Expr>,
    /// The inputs in the function's order: indices into `inputs`. Nothing where one is left out.
    pub order: Option<Vec<usize>>,
    /// Its outputs besides its result, which may be anything.
    pub outputs: Vec<Place>,
    /// `EN` and `ENO`.
    pub enable: Enable,
}

impl Applied {
    /// Whether it gives more than its result.
    #[must_use]
    pub fn gives_more(&self) -> bool {
        self.enable.result.is_some() || !self.outputs.is_empty()
    }
}

/// `EN` and `ENO` of a call.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Enable {
    /// What `EN` is given.
    pub condition: Option<Expr>,
    /// Whether what is called declares `EN` itself.
    pub is_input: bool,
    /// Where `ENO` goes, and whether it is negated on the way.
    pub result: Option<(Place, bool)>,
    /// Whether what is called declares `ENO` itself.
    pub is_output: bool,
}

impl Enable {
    /// Whether either is there.
    #[must_use]
    pub fn is_given(&self) -> bool {
        self.condition.is_some() || self.result.is_some()
    }
}

/// What a call calls.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// A function of the project's.
    Function(UnitId),
    /// An instance of a function block of the project's.
    Instance(Place, UnitId),
    /// An instance of a standard block.
    Standard(Place, StandardBlock),
    /// An action of an instance.
    Action(Place, RoutineId),
    /// A method of an instance, which a method of the same name nearer to the instance's unit takes the place of.
    Method(Place, RoutineId),
    /// The method that the base has (`SUPER^.m()`).
    BaseMethod(RoutineId),
    /// The body that the base has (`SUPER^()`).
    BaseBody(UnitId),
    /// A program, by its instance.
    Program(Place, UnitId),
}

/// A parameter of what is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// A variable of what is called.
    Variable(VarId),
    /// A pin of a standard block.
    Pin(Pin),
}

/// How a value is passed.
#[derive(Debug, Clone, PartialEq)]
pub enum Passed {
    /// As a value, which becomes one of the parameter's type.
    ByValue(Expr),
    /// What is called changes the caller's own variable.
    InOut(Expr),
    /// A result goes there, maybe negated.
    Output(Place, bool),
    /// The result goes nowhere.
    Dropped,
}

/// A call of what the project declares, or of a standard block.
#[derive(Debug, Clone, PartialEq)]
pub struct Call {
    /// What is called.
    pub target: Target,
    /// What is passed, in the order in which it is written.
    pub passed: Vec<(Parameter, Passed)>,
    /// `EN` and `ENO`.
    pub enable: Enable,
}

impl Call {
    /// The values that it passes.
    pub fn values(&self) -> impl Iterator<Item = &Expr> {
        self.passed.iter().filter_map(|(_, passed)| match passed {
            Passed::ByValue(one) | Passed::InOut(one) => Some(one),
            Passed::Output(..) | Passed::Dropped => None,
        })
    }

    /// The values that it passes, and what `EN` is given.
    pub fn given(&self) -> impl Iterator<Item = &Expr> {
        self.values().chain(&self.enable.condition)
    }
}

/// A statement.
#[derive(Debug, Clone)]
pub struct Statement {
    /// What it does.
    pub kind: StatementKind,
    /// Its first line, for messages.
    pub text: Arc<str>,
    /// Its line.
    pub line: u32,
}

/// One of a `CASE`'s values, or a range of them.
#[derive(Debug, Clone)]
pub struct Selector {
    /// The value, or the least.
    pub low: Expr,
    /// The largest.
    pub high: Option<Expr>,
}

/// `FOR`
#[derive(Debug, Clone)]
pub struct ForLoop {
    /// What it counts.
    pub variable: Place,
    /// The first value.
    pub from: Expr,
    /// The last value.
    pub to: Expr,
    /// By how much it is counted on; nothing where that is no number that is known.
    pub by: Option<i64>,
    /// What is repeated.
    pub body: Vec<Statement>,
}

/// What a statement does.
#[derive(Debug, Clone)]
pub enum StatementKind {
    /// A value goes to a variable.
    Assign(Place, Expr),
    /// A value is kept for other statements of the body.
    Keep(TempId, Expr),
    /// A structure, an array or an instance is copied.
    Copy(Place, Place),
    /// A variable is set (true) or reset where a condition holds.
    Latch(Place, bool, Expr),
    /// Something is called.
    Call(Call),
    /// A function of the standard's is called for its outputs.
    Standard(Applied),
    /// A call under a condition.
    CallIf(Expr, Box<Statement>),
    /// A call, and what is done behind it to a part of what the call gives.
    After(Box<(Call, Statement)>),
    /// Code of another language, of which the user states what it does.
    Foreign(Stated),
    /// `IF`
    If(Vec<(Expr, Vec<Statement>)>, Vec<Statement>),
    /// `CASE`
    Case(Expr, Vec<(Vec<Selector>, Vec<Statement>)>, Vec<Statement>),
    /// `FOR`
    For(Box<ForLoop>),
    /// `WHILE`
    While(Expr, Vec<Statement>),
    /// `REPEAT`
    Repeat(Vec<Statement>, Expr),
    /// `EXIT`
    Exit,
    /// `CONTINUE`
    Continue,
    /// `RETURN`, under a condition.
    Return(Expr),
    /// A jump to a label of the body, by its number, under a condition.
    Jump(Expr, u32),
    /// A label of the body, by its number.
    Label(u32),
    /// One or the other: controllers differ, and this says how the first one is special.
    Either(&'static str, Vec<Statement>, Vec<Statement>),
    /// A name alone, which does nothing.
    Nothing,
    /// What is wrong with it.
    Fault(Box<Fault>),
}

impl Place {
    /// The indices of its elements, in the order of its path.
    pub fn indices(&self) -> impl Iterator<Item = &Expr> {
        self.steps.iter().flat_map(|step| match step {
            Step::Element(indices) => &indices[..],
            _ => &[],
        })
    }

    /// The indices that are worked out.
    pub fn open_indices(&self) -> impl Iterator<Item = &Expr> {
        self.indices().filter(|index| index.whole().is_none())
    }

    /// Whether an index is worked out.
    #[must_use]
    pub fn has_open_index(&self) -> bool {
        self.open_indices().next().is_some()
    }
}

impl Expr {
    /// Without the calls that come before it.
    #[must_use]
    pub fn after_calls(&self) -> &Expr {
        match &self.kind {
            ExprKind::After(both) => both.1.after_calls(),
            _ => self,
        }
    }

    /// Without what becomes of it by itself.
    #[must_use]
    pub fn unconverted(&self) -> &Expr {
        match &self.kind {
            ExprKind::Convert(inner) => inner.unconverted(),
            _ => self,
        }
    }

    /// The whole number that it is, if that is known.
    #[must_use]
    pub fn whole(&self) -> Option<i64> {
        match &self.kind {
            ExprKind::Whole(value) | ExprKind::Typed(value) | ExprKind::Named(value) => {
                Some(*value)
            }
            ExprKind::Convert(inner) => inner.whole(),
            ExprKind::Negate(inner) => inner.whole()?.checked_neg(),
            ExprKind::Binary(operator, left, right) => {
                operator.of_constants(left.whole()?, right.whole()?)
            }
            _ => None,
        }
    }

    /// Shows what it is directly made of, what calls pass and what `EN` is given included; not what stands in indices.
    pub fn each_operand(&self, see: &mut dyn FnMut(&Expr)) {
        match &self.kind {
            ExprKind::Not(inner) | ExprKind::Negate(inner) | ExprKind::Convert(inner) => see(inner),
            ExprKind::Binary(_, left, right) => {
                see(left);
                see(right);
            }
            ExprKind::Standard(applied) => {
                applied.inputs.iter().chain(&applied.enable.condition).for_each(see);
            }
            ExprKind::Call(call) => call.given().for_each(see),
            ExprKind::After(both) => {
                both.0.given().for_each(&mut *see);
                see(&both.1);
            }
            ExprKind::List(all) => all.iter().for_each(see),
            ExprKind::Either(Some(both)) => {
                see(&both.0);
                see(&both.1);
            }
            ExprKind::Bool(_)
            | ExprKind::Whole(_)
            | ExprKind::Typed(_)
            | ExprKind::Named(_)
            | ExprKind::Real(_)
            | ExprKind::Time(_)
            | ExprKind::Opaque
            | ExprKind::Text(_)
            | ExprKind::Read(_)
            | ExprKind::Step(_)
            | ExprKind::Address(_)
            | ExprKind::Null
            | ExprKind::Either(None)
            | ExprKind::Fault(_) => {}
        }
    }

    /// Shows it and all in it, but not what stands in indices.
    pub fn each(&self, see: &mut dyn FnMut(&Expr)) {
        see(self);
        self.each_operand(&mut |one| one.each(see));
    }

    /// Shows what in it calls what the project declares, or is a function of the standard's that gives more than its
    /// result; what stands in indices counts, too.
    pub fn each_call(&self, see: &mut dyn FnMut(&Expr)) {
        self.each(&mut |one| match &one.kind {
            ExprKind::Call(_) | ExprKind::After(_) => see(one),
            ExprKind::Standard(applied) if applied.gives_more() => see(one),
            ExprKind::Read(place) | ExprKind::Address(place) => {
                place.indices().for_each(|index| index.each_call(see));
            }
            ExprKind::Step(flag) => flag.owner.indices().for_each(|index| index.each_call(see)),
            _ => {}
        });
    }

    /// Whether it calls what the project declares, or a function of the standard's that gives more than its result.
    #[must_use]
    pub fn calls(&self) -> bool {
        let mut found = false;
        self.each_call(&mut |_| found = true);
        found
    }
}

/// Calls `see` with statements and all that they contain.
pub fn each_statement<'s>(all: &'s [Statement], see: &mut dyn FnMut(&'s Statement)) {
    for one in all {
        see(one);
        one.bodies().into_iter().for_each(|body| each_statement(body, see));
    }
}

/// Whether a CONTINUE is among the statements of a loop, and none of an inner loop's.
#[must_use]
pub fn continues(all: &[Statement]) -> bool {
    all.iter().any(|one| match &one.kind {
        StatementKind::Continue => true,
        StatementKind::For(_) | StatementKind::While(..) | StatementKind::Repeat(..) => false,
        _ => one.bodies().into_iter().any(continues),
    })
}

impl Statement {
    /// The lists of statements that it contains.
    fn bodies(&self) -> Vec<&[Statement]> {
        match &self.kind {
            StatementKind::If(arms, otherwise) => {
                arms.iter().map(|(_, body)| &body[..]).chain([&otherwise[..]]).collect()
            }
            StatementKind::Case(_, arms, otherwise) => {
                arms.iter().map(|(_, body)| &body[..]).chain([&otherwise[..]]).collect()
            }
            StatementKind::For(own) => vec![&own.body],
            StatementKind::While(_, body) | StatementKind::Repeat(body, _) => vec![body],
            StatementKind::Either(_, one, other) => vec![one, other],
            StatementKind::CallIf(_, inner) => vec![std::slice::from_ref(inner)],
            StatementKind::After(both) => vec![std::slice::from_ref(&both.1)],
            _ => Vec::new(),
        }
    }
}

/// A step or a macro step of a chart of an instance, and what is read of it.
#[derive(Debug, Clone, PartialEq)]
pub struct StepFlag {
    /// The instance.
    pub owner: Place,
    /// The routine that is the chart.
    pub chart: RoutineId,
    /// The number of the step; those of macro steps follow those of steps.
    pub step: usize,
    /// Whether it is asked for how long the step is active (`S.T`), or whether it is (`S.X`).
    pub is_time: bool,
}

/// What the user states of code that is not there, or that is of another language.
#[derive(Debug, Clone)]
pub struct Stated {
    /// What it is called in the facts, for messages.
    pub name: String,
    /// How long it takes.
    pub time: Picos,
    /// What it may write besides the variables of its instance; or what is wrong with that.
    pub writes: Vec<Result<Place, Fault>>,
}

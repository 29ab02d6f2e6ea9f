//! Typed expressions and statements.

use crate::blocks::{Pin, StandardBlock};
use crate::ids::{AddressId, RoutineId, TempId, UnitId, VarId};
use crate::standard::Function;
use crate::types::TypeId;
use scanbound_base::time::Picos;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use std::sync::Arc;

/// The start of a [`Place`]'s path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Root {
    /// A variable of the current instance, of the current routine, or a global one.
    Variable(VarId),
    /// The current instance (`THIS`).
    This,
    /// A program instance, by its index in [`crate::tree::Tree::programs`].
    Program(usize),
    /// A direct address.
    Address(AddressId),
    /// A value stored by a statement list or a drawing.
    Temporary(TempId),
    /// A variable that a reference may point to, by its index among the variables whose address is taken. Only lowering
    /// creates it.
    Target(u32),
}

/// One selector of a [`Place`]'s path.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// A field of a structure, by its index.
    Part(usize),
    /// A variable of a block instance.
    Member(VarId),
    /// A pin of a standard block's instance.
    Pin(Pin),
    /// An array element, with one index for each dimension.
    Element(Vec<Expr>),
    /// A bit of an integer or bit string, by its number.
    Bit(u8),
    /// The target of a reference, a pointer or an interface.
    Dereference,
    /// The result of a method of an instance, left by its last call. `true`: the method of the base, not an override.
    Result(RoutineId, bool),
}

/// A resolved variable path: a variable or a part of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The start of the path.
    pub root: Root,
    /// The selectors that follow, from the start on.
    pub steps: Vec<Step>,
    /// The type of the value at the place.
    pub ty: TypeId,
    /// The source text of the path, for messages.
    pub text: Arc<str>,
}

/// A typed expression.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    /// The kind of expression, with its operands.
    pub kind: ExprKind,
    /// The type of its value.
    pub ty: TypeId,
    /// Its line, from 1.
    pub line: u32,
}

/// The kinds of expressions, with their operands.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    /// `TRUE` or `FALSE`.
    Bool(bool),
    /// An integer literal without a type prefix.
    Whole(i64),
    /// An integer with its own type: a literal with a prefix, or a typed constant's value.
    Typed(i64),
    /// The integer of an enumeration value, or of a constant whose type does not affect the expression.
    Named(i64),
    /// A `REAL` literal in its source spelling.
    Real(String),
    /// A duration in nanoseconds.
    Time(i64),
    /// A long real or a date: its value is not modelled.
    Opaque,
    /// A string literal.
    Text(String),
    /// The value of a variable.
    Read(Place),
    /// The flag of a chart's step (`S.X`) or its elapsed time (`S.T`).
    Step(Box<StepFlag>),
    /// The address of a variable, for a reference or pointer.
    Address(Place),
    /// The null reference.
    Null,
    /// `NOT`
    Not(Box<Expr>),
    /// `-`
    Negate(Box<Expr>),
    /// A binary operator whose operands have been converted to one type.
    Binary(Operator, Box<Expr>, Box<Expr>),
    /// An implicit conversion of the operand to the expression's type.
    Convert(Box<Expr>),
    /// The result of a call of one of the project's functions or methods.
    Call(Box<Call>),
    /// The result of a standard function.
    Standard(Box<Applied>),
    /// The listed initial values of an array or structure. The list is kept for the calls in it; it is not evaluated.
    List(Vec<Expr>),
    /// A call that runs first, then an expression that reads a part of the call's result.
    After(Box<(Call, Expr)>),
    /// Either of two values, because controllers differ; `None`: any value.
    Either(Option<Box<(Expr, Expr)>>),
    /// A faulty expression. The fault is reported if the expression is executed.
    Fault(Box<Fault>),
}

/// A call of a standard function.
#[derive(Debug, Clone, PartialEq)]
pub struct Applied {
    /// The function that is called.
    pub function: Function,
    /// The function's name in capitals.
    pub name: String,
    /// The inputs in source order.
    pub inputs: Vec<Expr>,
    /// Indices into `inputs`, in the order of the function's parameters; `None` if an input is missing.
    pub order: Option<Vec<usize>>,
    /// The variables that receive outputs other than the result. Their values may be anything.
    pub outputs: Vec<Place>,
    /// `EN` and `ENO`.
    pub enable: Enable,
}

impl Applied {
    /// Whether it writes more than its result: other outputs or `ENO`.
    #[must_use]
    pub fn gives_more(&self) -> bool {
        self.enable.result.is_some() || !self.outputs.is_empty()
    }
}

/// `EN` and `ENO` of a call.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Enable {
    /// The value passed to `EN`; `None` if `EN` is not passed.
    pub condition: Option<Expr>,
    /// Whether the called unit declares `EN` as an input of its own.
    pub is_input: bool,
    /// The variable that receives `ENO`, and whether the value is negated; `None` if `ENO` is not used.
    pub result: Option<(Place, bool)>,
    /// Whether the called unit declares `ENO` as an output of its own.
    pub is_output: bool,
}

impl Enable {
    /// Whether the call uses `EN` or `ENO`.
    #[must_use]
    pub fn is_given(&self) -> bool {
        self.condition.is_some() || self.result.is_some()
    }
}

/// The target of a call.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// A function declared in the project.
    Function(UnitId),
    /// An instance of a function block declared in the project.
    Instance(Place, UnitId),
    /// An instance of a standard function block.
    Standard(Place, StandardBlock),
    /// An action of an instance.
    Action(Place, RoutineId),
    /// A method of an instance, with dynamic dispatch: an override in the instance's own unit is executed in its place.
    Method(Place, RoutineId),
    /// A method of the base unit (`SUPER^.m()`), without dynamic dispatch.
    BaseMethod(RoutineId),
    /// The body of the base unit (`SUPER^()`).
    BaseBody(UnitId),
    /// A program instance.
    Program(Place, UnitId),
}

/// A parameter of the called unit or block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// A variable of the called unit or method.
    Variable(VarId),
    /// A pin of a standard block.
    Pin(Pin),
}

/// The passing mode of an argument.
#[derive(Debug, Clone, PartialEq)]
pub enum Passed {
    /// An input: the value, converted to the parameter's type.
    ByValue(Expr),
    /// VAR_IN_OUT: the callee reads and writes the caller's variable.
    InOut(Expr),
    /// An output: the variable that receives it, and whether the value is negated.
    Output(Place, bool),
    /// An output that is not used.
    Dropped,
}

/// A call of a unit, action or method of the project, or of a standard block.
#[derive(Debug, Clone, PartialEq)]
pub struct Call {
    /// The called unit, routine or block.
    pub target: Target,
    /// The arguments in source order, with their parameters.
    pub passed: Vec<(Parameter, Passed)>,
    /// `EN` and `ENO`.
    pub enable: Enable,
}

impl Call {
    /// The values passed as inputs and VAR_IN_OUT.
    pub fn values(&self) -> impl Iterator<Item = &Expr> {
        self.passed.iter().filter_map(|(_, passed)| match passed {
            Passed::ByValue(one) | Passed::InOut(one) => Some(one),
            Passed::Output(..) | Passed::Dropped => None,
        })
    }

    /// The values passed as inputs and VAR_IN_OUT, then the value of `EN`.
    pub fn given(&self) -> impl Iterator<Item = &Expr> {
        self.values().chain(&self.enable.condition)
    }
}

/// A typed statement.
#[derive(Debug, Clone)]
pub struct Statement {
    /// The kind of statement, with its operands.
    pub kind: StatementKind,
    /// The first line of its source, for messages.
    pub text: Arc<str>,
    /// Its line, from 1.
    pub line: u32,
}

/// A label of a `CASE` arm: a value or a range.
#[derive(Debug, Clone)]
pub struct Selector {
    /// The value, or the lower limit of the range.
    pub low: Expr,
    /// The upper limit; `None` for a single value.
    pub high: Option<Expr>,
}

/// The parts of a `FOR` loop.
#[derive(Debug, Clone)]
pub struct ForLoop {
    /// The control variable.
    pub variable: Place,
    /// The first value, converted to the variable's type.
    pub from: Expr,
    /// The final value.
    pub to: Expr,
    /// The step; `None` if it is not a known constant.
    pub by: Option<i64>,
    /// The loop body.
    pub body: Vec<Statement>,
}

/// The kinds of statements, with their operands.
#[derive(Debug, Clone)]
pub enum StatementKind {
    /// Assigns the value to the variable.
    Assign(Place, Expr),
    /// Stores a value in a temporary for later statements of the body.
    Keep(TempId, Expr),
    /// Copies an array, structure or instance; the target is the first operand.
    Copy(Place, Place),
    /// Writes `true` (set) or `false` (reset) to the variable if the condition is true; otherwise leaves it unchanged.
    Latch(Place, bool, Expr),
    /// A call of a unit, action, method or standard block.
    Call(Call),
    /// A call of a standard function as a statement, for its outputs.
    Standard(Applied),
    /// A call that is executed only if the condition is true.
    CallIf(Expr, Box<Statement>),
    /// A call that runs first, then a statement that uses a part of the call's result.
    After(Box<(Call, Statement)>),
    /// Code of another language, whose time and writes the user states.
    Foreign(Stated),
    /// `IF`: the conditions with their bodies, then the `ELSE` body.
    If(Vec<(Expr, Vec<Statement>)>, Vec<Statement>),
    /// `CASE`: the selector expression, the labels with their bodies, then the `ELSE` body.
    Case(Expr, Vec<(Vec<Selector>, Vec<Statement>)>, Vec<Statement>),
    /// `FOR`, with its parts.
    For(Box<ForLoop>),
    /// `WHILE`: the condition and the body.
    While(Expr, Vec<Statement>),
    /// `REPEAT`: the body and the `UNTIL` condition that ends the loop.
    Repeat(Vec<Statement>, Expr),
    /// `EXIT`
    Exit,
    /// `CONTINUE`
    Continue,
    /// `RETURN`, if the condition is true.
    Return(Expr),
    /// A forward jump to the label with this number in the body, if the condition is true.
    Jump(Expr, u32),
    /// The label with this number in the body.
    Label(u32),
    /// Either of two statement lists is executed, because controllers differ. The text says what distinguishes the
    /// first.
    Either(&'static str, Vec<Statement>, Vec<Statement>),
    /// A statement without effect, such as a name alone.
    Nothing,
    /// A faulty statement. The fault is reported if the statement is executed.
    Fault(Box<Fault>),
}

impl Place {
    /// The array indices in the path, in order.
    pub fn indices(&self) -> impl Iterator<Item = &Expr> {
        self.steps.iter().flat_map(|step| match step {
            Step::Element(indices) => &indices[..],
            _ => &[],
        })
    }

    /// The array indices that are not integer constants.
    pub fn open_indices(&self) -> impl Iterator<Item = &Expr> {
        self.indices().filter(|index| index.whole().is_none())
    }

    /// Whether an array index is not an integer constant.
    #[must_use]
    pub fn has_open_index(&self) -> bool {
        self.open_indices().next().is_some()
    }
}

impl Expr {
    /// The expression without the calls that run before it ([`ExprKind::After`]).
    #[must_use]
    pub fn after_calls(&self) -> &Expr {
        match &self.kind {
            ExprKind::After(both) => both.1.after_calls(),
            _ => self,
        }
    }

    /// The expression without the implicit conversions around it.
    #[must_use]
    pub fn unconverted(&self) -> &Expr {
        match &self.kind {
            ExprKind::Convert(inner) => inner.unconverted(),
            _ => self,
        }
    }

    /// The value of an integer constant expression; `None` if it is not one.
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

    /// Calls `see` for the direct operands, including a call's arguments and `EN`. Indices in paths are not visited.
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

    /// Calls `see` for the expression and all operands in it, at any depth. Indices in paths are not visited.
    pub fn each(&self, see: &mut dyn FnMut(&Expr)) {
        see(self);
        self.each_operand(&mut |one| one.each(see));
    }

    /// Calls `see` for every expression in it, indices included, that calls code of the project or a standard function
    /// that writes more than its result.
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

    /// Whether it, indices included, calls code of the project or a standard function that writes more than its result.
    #[must_use]
    pub fn calls(&self) -> bool {
        let mut found = false;
        self.each_call(&mut |_| found = true);
        found
    }
}

/// Calls `see` for every statement and for all nested statements, outer ones first.
pub fn each_statement<'s>(all: &'s [Statement], see: &mut dyn FnMut(&'s Statement)) {
    for one in all {
        see(one);
        one.bodies().into_iter().for_each(|body| each_statement(body, see));
    }
}

/// Whether the statements contain a `CONTINUE` that belongs to the enclosing loop, not to an inner one.
#[must_use]
pub fn continues(all: &[Statement]) -> bool {
    all.iter().any(|one| match &one.kind {
        StatementKind::Continue => true,
        StatementKind::For(_) | StatementKind::While(..) | StatementKind::Repeat(..) => false,
        _ => one.bodies().into_iter().any(continues),
    })
}

impl Statement {
    /// The statement lists nested directly in this statement.
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

/// A read of a step's or macro step's flag or elapsed time.
#[derive(Debug, Clone, PartialEq)]
pub struct StepFlag {
    /// The instance that executes the chart.
    pub owner: Place,
    /// The routine whose code is the chart.
    pub chart: RoutineId,
    /// The index of the step; macro steps are numbered after all steps.
    pub step: usize,
    /// Whether the elapsed time (`S.T`) is read, not the flag (`S.X`).
    pub is_time: bool,
}

/// The user's statement about code that is missing or in another language.
#[derive(Debug, Clone)]
pub struct Stated {
    /// Its key in the facts file, for messages.
    pub name: String,
    /// Its execution time.
    pub time: Picos,
    /// The variables that it may write besides those of its instance, or the fault in a stated name.
    pub writes: Vec<Result<Place, Fault>>,
}

//! Expressions and statements: the common syntax tree of the textual and graphic languages of IEC 61131-3.

/// Whether two names are equal, ignoring ASCII case.
#[must_use]
pub fn same(one: &str, other: &str) -> bool {
    one.eq_ignore_ascii_case(other)
}

/// One selector of a variable's path, after the first name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    /// `.name`: a field of a structure or a variable of an instance.
    Name(String),
    /// `[i, j]`: an array element, with one index for each dimension.
    Index(Vec<Expr>),
    /// `.5`: a bit of a word, by its number.
    Bit(u8),
    /// `^`: the variable that a pointer points to.
    Dereference,
}

/// A path that names a variable or a part of one: `Axes[2].Delay.Q`, `%IX0.1`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path {
    /// The first name, or the whole direct address.
    pub first: String,
    /// The selectors after the first name; empty for a plain name.
    pub rest: Vec<Part>,
}

impl Path {
    /// The path that consists of this name alone.
    pub fn name(name: impl Into<String>) -> Path {
        Path { first: name.into(), rest: Vec::new() }
    }

    /// Appends `.part` to the path.
    #[must_use]
    pub fn with(mut self, part: &str) -> Path {
        self.rest.push(Part::Name(part.to_owned()));
        self
    }

    /// The name, if the path is a single name without selectors; otherwise `None`.
    #[must_use]
    pub fn as_name(&self) -> Option<&str> {
        self.rest.is_empty().then_some(&self.first)
    }

    /// Splits `a.b.c` into the path `a.b` and the name `c`. `None` for a single name, or if the last selector is not a
    /// name.
    #[must_use]
    pub fn split_last(&self) -> Option<(Path, &str)> {
        let (last, before) = self.rest.split_last()?;
        let Part::Name(last) = last else { return None };
        Some((Path { first: self.first.clone(), rest: before.to_vec() }, last))
    }
}

/// A binary operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Operator {
    /// `OR`
    Or,
    /// `XOR`
    Xor,
    /// `AND`, `&`
    And,
    /// `AND_THEN`: the right operand is executed only if the left one is true.
    AndThen,
    /// `OR_ELSE`: the right operand is executed only if the left one is false.
    OrElse,
    /// `=`
    Equal,
    /// `<>`
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterOrEqual,
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
    /// `MOD`
    Modulo,
    /// `**`
    Power,
}

impl Operator {
    /// All operators in the order of the enum: symbol in structured text, name as a function or instruction, and
    /// precedence (larger binds tighter).
    const ALL: [(Operator, &'static str, &'static str, u8); 17] = [
        (Operator::Or, "OR", "OR", 1),
        (Operator::Xor, "XOR", "XOR", 2),
        (Operator::And, "AND", "AND", 3),
        (Operator::AndThen, "AND_THEN", "AND", 3),
        (Operator::OrElse, "OR_ELSE", "OR", 1),
        (Operator::Equal, "=", "EQ", 4),
        (Operator::NotEqual, "<>", "NE", 4),
        (Operator::Less, "<", "LT", 5),
        (Operator::LessOrEqual, "<=", "LE", 5),
        (Operator::Greater, ">", "GT", 5),
        (Operator::GreaterOrEqual, ">=", "GE", 5),
        (Operator::Add, "+", "ADD", 6),
        (Operator::Subtract, "-", "SUB", 6),
        (Operator::Multiply, "*", "MUL", 7),
        (Operator::Divide, "/", "DIV", 7),
        (Operator::Modulo, "MOD", "MOD", 7),
        (Operator::Power, "**", "EXPT", 8),
    ];

    /// The symbol in structured text, such as `+` or `AND`.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        Operator::ALL[self as usize].1
    }

    /// The name as a function or an IL instruction, such as `ADD`. `AND_THEN` and `OR_ELSE` give `AND` and `OR`.
    #[must_use]
    pub fn name(self) -> &'static str {
        Operator::ALL[self as usize].2
    }

    /// The operator with this function name, which must be in capitals; never `AndThen` or `OrElse`.
    #[must_use]
    pub fn named(name: &str) -> Option<Operator> {
        Operator::ALL.iter().find(|(_, _, own, _)| *own == name).map(|(own, ..)| *own)
    }

    /// The precedence, 1 to 8; a larger number binds tighter.
    #[must_use]
    pub fn binding(self) -> u8 {
        Operator::ALL[self as usize].3
    }

    /// The result for two integer constants. `None` for comparisons, `**` and the short-circuit operators, on overflow
    /// or division by zero, and for bit operations on negative numbers.
    #[must_use]
    pub fn of_constants(self, left: i64, right: i64) -> Option<i64> {
        match self {
            Operator::Add => left.checked_add(right),
            Operator::Subtract => left.checked_sub(right),
            Operator::Multiply => left.checked_mul(right),
            Operator::Divide => left.checked_div(right),
            Operator::Modulo => left.checked_rem(right),
            Operator::And if left >= 0 && right >= 0 => Some(left & right),
            Operator::Or if left >= 0 && right >= 0 => Some(left | right),
            Operator::Xor if left >= 0 && right >= 0 => Some(left ^ right),
            _ => None,
        }
    }

    /// Replaces a short-circuit operator by the one that always executes both operands; other operators stay.
    #[must_use]
    pub fn eager(self) -> Operator {
        match self {
            Operator::AndThen => Operator::And,
            Operator::OrElse => Operator::Or,
            other => other,
        }
    }

    /// Whether it is `OR`, `XOR` or `AND`, which are associative. The short-circuit forms do not count.
    #[must_use]
    pub fn is_of_bits(self) -> bool {
        matches!(self, Operator::Or | Operator::Xor | Operator::And)
    }
}

/// A literal constant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Literal {
    /// `TRUE` or `FALSE`.
    Bool(bool),
    /// An integer, with the type prefix if one is written (`INT#5`).
    Int(i128, Option<String>),
    /// A real number in its source spelling, with the type prefix if one is written.
    Real(String, Option<String>),
    /// A duration in nanoseconds.
    Time(i64),
    /// A character string.
    Text(String),
    /// A date or a time of day in its source spelling.
    Date(String),
}

/// An expression of the syntax tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Expr {
    /// A literal constant.
    Literal(Literal),
    /// The value of a variable.
    Variable(Path),
    /// `NOT`
    Not(Box<Expr>),
    /// `-`
    Negate(Box<Expr>),
    /// A binary operator and its left and right operands.
    Binary(Operator, Box<Expr>, Box<Expr>),
    /// The result of a call of a function or method.
    Call(Path, Vec<Argument>),
    /// The initial value that a declaration gives to a structure, an array or an instance.
    List(Listing, Vec<Argument>),
    /// The value that an earlier [`Kind::Keep`] stored in this temporary.
    Kept(Temp),
    /// The output of a block or edge contact that belongs to the drawing of a condition and is executed by an action.
    Held(Box<Held>),
    /// An expression that could not be read. The text says why.
    Unread(String),
}

/// An unnamed temporary: an instruction list stores the accumulator in it ([`Kind::Keep`]) for later statements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Temp {
    /// Its number, unique among the temporaries of the same body.
    pub number: u32,
    /// Whether it holds the accumulator's value at a label, which every path to the label assigns.
    pub merges: bool,
    /// The source that computes the value, for messages.
    pub text: String,
}

/// A block's output, or an edge contact's value, in the drawing of a condition, where an action executes the drawing.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Held {
    /// The name of the condition's drawing, unique within the unit.
    pub part: String,
    /// The `localId` of the block or contact.
    pub local_id: String,
    /// The name of the block's output; `None` for a contact.
    pub output: Option<String>,
}

/// What an [`Expr::List`] contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Listing {
    /// Named fields of a structure, or arguments of an instance's initialization method: `b : B(x := 1)`.
    Parts,
    /// The elements of an array: `a : ARRAY[1..2] OF INT := [1, 2]`.
    Elements,
    /// A value that could not be read; the list holds the calls that it may contain.
    Unread,
}

impl Expr {
    /// The literal `TRUE` or `FALSE`.
    #[must_use]
    pub fn bool(value: bool) -> Expr {
        Expr::Literal(Literal::Bool(value))
    }

    /// The value of the variable with this name.
    pub fn name(name: impl Into<String>) -> Expr {
        Expr::Variable(Path::name(name))
    }

    /// The negation; of a Boolean literal, the opposite literal.
    #[must_use]
    #[allow(clippy::should_implement_trait)]
    pub fn not(self) -> Expr {
        match self {
            Expr::Literal(Literal::Bool(value)) => Expr::bool(!value),
            other => Expr::Not(Box::new(other)),
        }
    }

    /// The conjunction; if one operand is the literal `TRUE`, the other operand.
    #[must_use]
    pub fn and(self, other: Expr) -> Expr {
        match (self, other) {
            (Expr::Literal(Literal::Bool(true)), one)
            | (one, Expr::Literal(Literal::Bool(true))) => one,
            (one, two) => Expr::Binary(Operator::And, Box::new(one), Box::new(two)),
        }
    }

    /// The disjunction, without simplification.
    #[must_use]
    pub fn or(self, other: Expr) -> Expr {
        Expr::Binary(Operator::Or, Box::new(self), Box::new(other))
    }

    /// The direct operands and arguments. Indices in paths are not included.
    #[must_use]
    pub fn operands(&self) -> Vec<&Expr> {
        match self {
            Expr::Literal(_)
            | Expr::Variable(_)
            | Expr::Kept(_)
            | Expr::Held(_)
            | Expr::Unread(_) => Vec::new(),
            Expr::Not(inner) | Expr::Negate(inner) => vec![inner],
            Expr::Binary(_, left, right) => vec![left, right],
            Expr::Call(_, given) | Expr::List(_, given) => {
                given.iter().map(|one| &one.value).collect()
            }
        }
    }

    /// Like [`Expr::operands`], but mutable.
    pub fn operands_mut(&mut self) -> Vec<&mut Expr> {
        match self {
            Expr::Literal(_)
            | Expr::Variable(_)
            | Expr::Kept(_)
            | Expr::Held(_)
            | Expr::Unread(_) => Vec::new(),
            Expr::Not(inner) | Expr::Negate(inner) => vec![inner],
            Expr::Binary(_, left, right) => vec![left, right],
            Expr::Call(_, given) | Expr::List(_, given) => {
                given.iter_mut().map(|one| &mut one.value).collect()
            }
        }
    }

    /// Whether it is the Boolean literal `value`.
    #[must_use]
    pub fn is(&self, value: bool) -> bool {
        *self == Expr::bool(value)
    }
}

/// One argument of a call, or one entry of a list of initial values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Argument {
    /// The parameter's name; `None` for a positional argument.
    pub name: Option<String>,
    /// Whether it is an output argument (`=>`), which receives a result.
    pub is_output: bool,
    /// The value passed in; of an output argument, the variable that receives the result. An output written with `NOT`
    /// has [`Expr::Not`] here.
    pub value: Expr,
}

/// A statement with its line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Statement {
    /// The line in the file, from 1.
    pub line: u32,
    /// The kind of statement, with its operands.
    pub kind: Kind,
}

/// One label of a `CASE` arm: a value or a range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selector {
    /// The value, or the lower limit of the range.
    pub low: Expr,
    /// The upper limit; `None` for a single value.
    pub high: Option<Expr>,
}

/// The kinds of statements, with their operands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// `target := value;`
    Assign(Path, Expr),
    /// The rest of a chained assignment (`target := variable := value;`): assigns the variable that was just assigned.
    Chained(Path, Expr),
    /// Stores a value in a temporary ([`Temp`]) for later statements.
    Keep(Temp, Expr),
    /// `reference REF= variable;`
    Refer(Path, Expr),
    /// `instance(arguments);`: a call of an instance, action, method or function as a statement.
    Call(Path, Vec<Argument>),
    /// A call that is executed only if the condition is true, as in `CALC` or a block with EN.
    CallIf(Expr, Path, Vec<Argument>),
    /// `IF`: the conditions with their bodies (`ELSIF` included), then the `ELSE` body.
    If(Vec<(Expr, Vec<Statement>)>, Vec<Statement>),
    /// `CASE`: the selector expression, the labels with their bodies, then the `ELSE` body.
    Case(Expr, Vec<(Vec<Selector>, Vec<Statement>)>, Vec<Statement>),
    /// `FOR`: the variable, its first value, the limit, the step (`None`: 1) and the body.
    For(Path, Expr, Expr, Option<Expr>, Vec<Statement>),
    /// `WHILE`: the condition and the body.
    While(Expr, Vec<Statement>),
    /// `REPEAT`: the body and the `UNTIL` condition that ends the loop.
    Repeat(Vec<Statement>, Expr),
    /// `EXIT`.
    Exit,
    /// `CONTINUE`.
    Continue,
    /// `RETURN`, if the condition is true.
    Return(Expr),
    /// A jump to the label of this name, if the condition is true.
    Jump(Expr, String),
    /// A jump target.
    Label(String),
    /// A set coil (`true`) or reset coil (`false`): writes that value to its variable if the expression is true,
    /// otherwise leaves the variable unchanged.
    Latch(Path, bool, Expr),
    /// A statement that could not be read, with the reason. It may have any effect.
    Unread(String),
    /// A pragma that may contain code of another language. The text includes its braces.
    Foreign(String),
}

/// Calls `see` for every statement, and for those nested in loops, `IF` and `CASE`, outer ones first.
pub fn visit(statements: &[Statement], see: &mut dyn FnMut(&Statement)) {
    for statement in statements {
        see(statement);
        match &statement.kind {
            Kind::If(arms, otherwise) => {
                arms.iter().for_each(|(_, body)| visit(body, see));
                visit(otherwise, see);
            }
            Kind::Case(_, arms, otherwise) => {
                arms.iter().for_each(|(_, body)| visit(body, see));
                visit(otherwise, see);
            }
            Kind::For(.., body) | Kind::While(_, body) | Kind::Repeat(body, _) => visit(body, see),
            _ => {}
        }
    }
}

/// Calls `see` for every path in an expression, mutably: variables, called names, and the paths in indices.
pub fn paths_of(expr: &mut Expr, see: &mut dyn FnMut(&mut Path)) {
    if let Expr::Variable(path) | Expr::Call(path, _) = expr {
        path_of(path, see);
    }
    expr.operands_mut().into_iter().for_each(|one| paths_of(one, see));
}

/// Calls `see` for the paths in the indices of a path, then for the path, mutably.
pub fn path_of(path: &mut Path, see: &mut dyn FnMut(&mut Path)) {
    for part in &mut path.rest {
        if let Part::Index(indices) = part {
            indices.iter_mut().for_each(|index| paths_of(index, see));
        }
    }
    see(path);
}

/// Calls `expr` for the outermost expressions of the statements, and `path` for the paths that are written or called;
/// nested statements are included. Neither looks inside an expression.
pub fn change(
    statements: &mut [Statement],
    expr: &mut dyn FnMut(&mut Expr),
    path: &mut dyn FnMut(&mut Path),
) {
    for statement in statements {
        match &mut statement.kind {
            Kind::Assign(target, value)
            | Kind::Chained(target, value)
            | Kind::Refer(target, value)
            | Kind::Latch(target, _, value) => {
                path(target);
                expr(value);
            }
            Kind::Call(target, given) => {
                path(target);
                given.iter_mut().for_each(|one| expr(&mut one.value));
            }
            Kind::CallIf(condition, target, given) => {
                expr(condition);
                path(target);
                given.iter_mut().for_each(|one| expr(&mut one.value));
            }
            Kind::If(arms, otherwise) => {
                for (condition, body) in arms {
                    expr(condition);
                    change(body, expr, path);
                }
                change(otherwise, expr, path);
            }
            Kind::Case(of, arms, otherwise) => {
                expr(of);
                for (selectors, body) in arms {
                    for selector in selectors {
                        expr(&mut selector.low);
                        selector.high.iter_mut().for_each(&mut *expr);
                    }
                    change(body, expr, path);
                }
                change(otherwise, expr, path);
            }
            Kind::For(variable, from, to, by, body) => {
                path(variable);
                [from, to].into_iter().for_each(&mut *expr);
                by.iter_mut().for_each(&mut *expr);
                change(body, expr, path);
            }
            Kind::While(condition, body) | Kind::Repeat(body, condition) => {
                expr(condition);
                change(body, expr, path);
            }
            Kind::Return(condition) | Kind::Jump(condition, _) | Kind::Keep(_, condition) => {
                expr(condition);
            }
            Kind::Exit | Kind::Continue | Kind::Label(_) | Kind::Unread(_) | Kind::Foreign(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Operator;

    #[test]
    fn operators_stand_at_their_numbers() {
        for (at, (one, ..)) in Operator::ALL.into_iter().enumerate() {
            assert_eq!(one as usize, at, "{one:?}");
        }
    }
}

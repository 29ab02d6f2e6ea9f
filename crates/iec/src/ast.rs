//! Expressions and statements, as all textual and graphic languages of IEC 61131-3 come down to them.

/// Whether two names are the same: upper and lower case do not tell them apart.
#[must_use]
pub fn same(one: &str, other: &str) -> bool {
    one.eq_ignore_ascii_case(other)
}

/// A part of a variable's path, behind its first name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    /// A named part of a structure or an instance.
    Name(String),
    /// Elements of an array, one index a dimension.
    Index(Vec<Expr>),
    /// A bit of a word.
    Bit(u8),
    /// What a pointer points to.
    Dereference,
}

/// A variable, or a part of one: `Axes[2].Delay.Q`, `%IX0.1`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path {
    /// Its first name.
    pub first: String,
    /// What follows.
    pub rest: Vec<Part>,
}

impl Path {
    /// A variable of this name.
    pub fn name(name: impl Into<String>) -> Path {
        Path { first: name.into(), rest: Vec::new() }
    }

    /// The path with a named part behind it.
    #[must_use]
    pub fn with(mut self, part: &str) -> Path {
        self.rest.push(Part::Name(part.to_owned()));
        self
    }

    /// The name, where it is one name alone.
    #[must_use]
    pub fn as_name(&self) -> Option<&str> {
        self.rest.is_empty().then_some(&self.first)
    }

    /// The path and the name at its end, where names alone lead there.
    #[must_use]
    pub fn split_last(&self) -> Option<(Path, &str)> {
        let (last, before) = self.rest.split_last()?;
        let Part::Name(last) = last else { return None };
        Some((Path { first: self.first.clone(), rest: before.to_vec() }, last))
    }
}

/// An operator of two operands.
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
    /// All, with how structured text writes each, its name as a function or an instruction, and how strongly it binds.
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

    /// As structured text writes it.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        Operator::ALL[self as usize].1
    }

    /// Its name as a function or an instruction.
    #[must_use]
    pub fn name(self) -> &'static str {
        Operator::ALL[self as usize].2
    }

    /// The operator of this name, in capitals.
    #[must_use]
    pub fn named(name: &str) -> Option<Operator> {
        Operator::ALL.iter().find(|(_, _, own, _)| *own == name).map(|(own, ..)| *own)
    }

    /// How strongly it binds; a larger number binds more.
    #[must_use]
    pub fn binding(self) -> u8 {
        Operator::ALL[self as usize].3
    }

    /// What it makes of two whole constants.
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

    /// The operator with the same result that executes both operands.
    #[must_use]
    pub fn eager(self) -> Operator {
        match self {
            Operator::AndThen => Operator::And,
            Operator::OrElse => Operator::Or,
            other => other,
        }
    }

    /// Whether it joins truth values or bits, of which it does not matter how they are grouped.
    #[must_use]
    pub fn is_of_bits(self) -> bool {
        matches!(self, Operator::Or | Operator::Xor | Operator::And)
    }
}

/// A constant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Literal {
    /// A truth value.
    Bool(bool),
    /// A whole number, with the type that is written in front of it.
    Int(i128, Option<String>),
    /// A real number as it is written, with its type.
    Real(String, Option<String>),
    /// A duration in nanoseconds.
    Time(i64),
    /// Text.
    Text(String),
    /// A date or a time of day, as it is written.
    Date(String),
}

/// An expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Expr {
    /// A constant.
    Literal(Literal),
    /// A variable's value.
    Variable(Path),
    /// `NOT`
    Not(Box<Expr>),
    /// `-`
    Negate(Box<Expr>),
    /// Two operands and what is done with them.
    Binary(Operator, Box<Expr>, Box<Expr>),
    /// The result of a function or a method.
    Call(Path, Vec<Argument>),
    /// What a declaration gives at first to something that has parts.
    List(Listing, Vec<Argument>),
    /// A value that a list keeps ([`Kind::Keep`]).
    Kept(Temp),
    /// What an element of a drawn condition gives.
    Held(Box<Held>),
    /// What cannot be read, and why.
    Unread(String),
}

/// A value that a list keeps from one instruction to others. It has no name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Temp {
    /// Its number among those of its list.
    pub number: u32,
    /// Whether each of the ways that meet at a label gives it a value.
    pub merges: bool,
    /// Where it comes from, for messages.
    pub text: String,
}

/// What a block, or a contact that looks at an edge, of a drawn condition gives, where an action executes it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Held {
    /// The condition, by a name of its own within the unit.
    pub part: String,
    /// The `localId` of the block or contact.
    pub local_id: String,
    /// Which output of the block; none of a contact.
    pub output: Option<String>,
}

/// What the values of a list are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Listing {
    /// Named parts of a structure, or what the method takes that begins an instance: `b : B(x := 1)`.
    Parts,
    /// The elements of an array: `a : ARRAY[1..2] OF INT := [1, 2]`.
    Elements,
    /// A value that cannot be read: what may be called in it.
    Unread,
}

impl Expr {
    /// A truth value.
    #[must_use]
    pub fn bool(value: bool) -> Expr {
        Expr::Literal(Literal::Bool(value))
    }

    /// A variable of this name.
    pub fn name(name: impl Into<String>) -> Expr {
        Expr::Variable(Path::name(name))
    }

    /// The negation.
    #[must_use]
    #[allow(clippy::should_implement_trait)]
    pub fn not(self) -> Expr {
        match self {
            Expr::Literal(Literal::Bool(value)) => Expr::bool(!value),
            other => Expr::Not(Box::new(other)),
        }
    }

    /// Both.
    #[must_use]
    pub fn and(self, other: Expr) -> Expr {
        match (self, other) {
            (Expr::Literal(Literal::Bool(true)), one)
            | (one, Expr::Literal(Literal::Bool(true))) => one,
            (one, two) => Expr::Binary(Operator::And, Box::new(one), Box::new(two)),
        }
    }

    /// One of both.
    #[must_use]
    pub fn or(self, other: Expr) -> Expr {
        Expr::Binary(Operator::Or, Box::new(self), Box::new(other))
    }

    /// The expressions of which it is made, but for indices.
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

    /// The same, to be changed.
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

    /// Whether it is this truth value.
    #[must_use]
    pub fn is(&self, value: bool) -> bool {
        *self == Expr::bool(value)
    }
}

/// What is handed to a function, a method or an instance, or taken from it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Argument {
    /// The parameter's name, where it is given.
    pub name: Option<String>,
    /// Whether it takes a result (`=>`).
    pub is_output: bool,
    /// What is handed over, or where the result goes; `NOT` in front of a result's name negates it.
    pub value: Expr,
}

/// A statement and its line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Statement {
    /// The line in the file, from 1.
    pub line: u32,
    /// What it does.
    pub kind: Kind,
}

/// The choices of a `CASE`: values, or ranges of values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selector {
    /// The least.
    pub low: Expr,
    /// The largest; the least itself where it is a single value.
    pub high: Option<Expr>,
}

/// What a statement does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// `target := value;`
    Assign(Path, Expr),
    /// A value is kept for other statements.
    Keep(Temp, Expr),
    /// `reference REF= variable;`
    Refer(Path, Expr),
    /// `instance(arguments);`, also of an action, a method or a function.
    Call(Path, Vec<Argument>),
    /// A call under a condition: a block with EN, `CALC`.
    CallIf(Expr, Path, Vec<Argument>),
    /// `IF`, with its arms and the `ELSE`.
    If(Vec<(Expr, Vec<Statement>)>, Vec<Statement>),
    /// `CASE`, with its arms and the `ELSE`.
    Case(Expr, Vec<(Vec<Selector>, Vec<Statement>)>, Vec<Statement>),
    /// `FOR` variable, from, to, by.
    For(Path, Expr, Expr, Option<Expr>, Vec<Statement>),
    /// `WHILE`.
    While(Expr, Vec<Statement>),
    /// `REPEAT`, until.
    Repeat(Vec<Statement>, Expr),
    /// `EXIT`.
    Exit,
    /// `CONTINUE`.
    Continue,
    /// `RETURN`, under a condition.
    Return(Expr),
    /// A jump to a label, under a condition.
    Jump(Expr, String),
    /// A label.
    Label(String),
    /// A coil that sets (true) or resets its variable where the value is true.
    Latch(Path, bool, Expr),
    /// What is not understood, in words; it may have done anything.
    Unread(String),
    /// A pragma that may hold code of another language, with its braces.
    Foreign(String),
}

/// Shows every expression and every statement of some statements.
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

/// Shows every path of an expression, to be changed: variables, what is called, and those in indices.
pub fn paths_of(expr: &mut Expr, see: &mut dyn FnMut(&mut Path)) {
    if let Expr::Variable(path) | Expr::Call(path, _) = expr {
        path_of(path, see);
    }
    expr.operands_mut().into_iter().for_each(|one| paths_of(one, see));
}

/// Shows a path and those in its indices, to be changed.
pub fn path_of(path: &mut Path, see: &mut dyn FnMut(&mut Path)) {
    for part in &mut path.rest {
        if let Part::Index(indices) = part {
            indices.iter_mut().for_each(|index| paths_of(index, see));
        }
    }
    see(path);
}

/// Shows every expression of some statements, to be changed; what is written and what is called as a path of its own.
pub fn change(
    statements: &mut [Statement],
    expr: &mut dyn FnMut(&mut Expr),
    path: &mut dyn FnMut(&mut Path),
) {
    for statement in statements {
        match &mut statement.kind {
            Kind::Assign(target, value)
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

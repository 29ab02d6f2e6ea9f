//! The parser of expressions and literals.

use super::cursor::Cursor;
use crate::ast::{Argument, Expr, Literal, Operator, Part, Path};
use crate::fault::Fault;
use crate::lexer::Token;
use crate::same;

/// Parses an expression.
pub(super) fn expression(cursor: &mut Cursor) -> Result<Expr, Fault> {
    binary(cursor, 0)
}

fn operator(cursor: &mut Cursor) -> Option<Operator> {
    Some(match cursor.peek() {
        Token::Sign(sign) => match *sign {
            "&" => Operator::And,
            "=" => Operator::Equal,
            "<>" => Operator::NotEqual,
            "<" => Operator::Less,
            "<=" => Operator::LessOrEqual,
            ">" => Operator::Greater,
            ">=" => Operator::GreaterOrEqual,
            "+" => Operator::Add,
            "-" => Operator::Subtract,
            "*" => Operator::Multiply,
            "/" => Operator::Divide,
            "**" => Operator::Power,
            _ => return None,
        },
        Token::Word(word) => match word.to_ascii_uppercase().as_str() {
            "OR" => Operator::Or,
            "OR_ELSE" => Operator::OrElse,
            "XOR" => Operator::Xor,
            "AND" => Operator::And,
            "AND_THEN" => Operator::AndThen,
            "MOD" => Operator::Modulo,
            _ => return None,
        },
        _ => return None,
    })
}

/// The maximum number of operands in a chain without brackets; chains of AND, OR and XOR may be longer.
const MAX_IN_A_ROW: usize = 200;

/// From this many operands on, a chain of AND, OR or XOR becomes a balanced tree.
const MANY: usize = 16;

fn binary(cursor: &mut Cursor, least: u8) -> Result<Expr, Fault> {
    let line = cursor.line();
    let mut left = cursor.deeper(unary)?;
    let mut row = 0;
    while let Some(by) = operator(cursor).filter(|one| one.binding() > least) {
        let mut all = vec![left];
        while operator(cursor) == Some(by) {
            cursor.next();
            all.push(cursor.deeper(|cursor| binary(cursor, by.binding()))?);
        }
        if all.len() >= MANY && all.iter().all(can_be_grouped) && by.is_of_bits() {
            left = by_halves(by, all);
            continue;
        }
        row += all.len();
        if row > MAX_IN_A_ROW {
            let told = format!("more than {MAX_IN_A_ROW} operands are in one chain");
            let help = "assign a part of them to a variable of its own";
            return Err(Fault::new(line, told).help(help));
        }
        let joined = |one, two| Expr::Binary(by, Box::new(one), Box::new(two));
        left = all.into_iter().reduce(joined).unwrap_or(Expr::Literal(Literal::Bool(false)));
    }
    Ok(left)
}

/// Joins the operands of an associative operator as a balanced tree, to limit its depth.
fn by_halves(operator: Operator, mut all: Vec<Expr>) -> Expr {
    match all.len() {
        0 => Expr::Literal(Literal::Bool(false)),
        1 => all.remove(0),
        many => {
            let right = all.split_off(many / 2);
            let [left, right] = [all, right].map(|half| Box::new(by_halves(operator, half)));
            Expr::Binary(operator, left, right)
        }
    }
}

/// Whether an operand's type does not depend on how it is grouped. A constant does not qualify, because it takes its
/// type from the operand beside it.
fn can_be_grouped(one: &Expr) -> bool {
    match one {
        Expr::Variable(_) | Expr::Literal(Literal::Bool(_)) => true,
        Expr::Not(inner) => can_be_grouped(inner),
        Expr::Binary(operator, left, right) => {
            let is_relation = (4..=5).contains(&operator.binding());
            is_relation || (can_be_grouped(left) && can_be_grouped(right))
        }
        _ => false,
    }
}

/// Parses an operand: a sign or NOT may precede it, other operators only occur in brackets.
pub(super) fn unary(cursor: &mut Cursor) -> Result<Expr, Fault> {
    if cursor.take_word("NOT") {
        return Ok(Expr::Not(Box::new(cursor.deeper(unary)?)));
    }
    if cursor.take_sign("-") {
        let inner = cursor.deeper(unary)?;
        return Ok(match inner {
            Expr::Literal(Literal::Int(value, of)) => Expr::Literal(Literal::Int(-value, of)),
            Expr::Literal(Literal::Real(text, of)) => {
                Expr::Literal(Literal::Real(format!("-{text}"), of))
            }
            Expr::Literal(Literal::Time(value)) => Expr::Literal(Literal::Time(-value)),
            other => Expr::Negate(Box::new(other)),
        });
    }
    if cursor.take_sign("+") {
        return cursor.deeper(unary);
    }
    if cursor.take_sign("(") {
        let inner = cursor.deeper(expression)?;
        cursor.sign(")")?;
        return Ok(inner);
    }
    primary(cursor)
}

fn primary(cursor: &mut Cursor) -> Result<Expr, Fault> {
    let line = cursor.line();
    match cursor.peek().clone() {
        Token::Number(text) => {
            cursor.next();
            literal(&text, line).map(Expr::Literal)
        }
        Token::Text(text) => {
            cursor.next();
            Ok(Expr::Literal(Literal::Text(text)))
        }
        Token::Direct(text) => {
            cursor.next();
            Ok(Expr::name(text.to_ascii_uppercase()))
        }
        Token::Word(word) if same(&word, "TRUE") || same(&word, "FALSE") => {
            cursor.next();
            Ok(Expr::bool(same(&word, "TRUE")))
        }
        // Operators may be called as functions: AND(a, b).
        Token::Word(word) if is_operator(&word) && matches!(cursor.second(), Token::Sign("(")) => {
            cursor.next();
            Ok(Expr::Call(Path::name(word), arguments(cursor)?))
        }
        Token::Word(word) if is_keyword(&word) => Err(cursor.unexpected("an expression")),
        Token::Word(_) => {
            let path = path(cursor)?;
            if cursor.is_sign("(") {
                return Ok(Expr::Call(path, arguments(cursor)?));
            }
            Ok(Expr::Variable(path))
        }
        _ => Err(cursor.unexpected("an expression")),
    }
}

fn is_operator(word: &str) -> bool {
    ["AND", "OR", "XOR", "MOD"].iter().any(|operator| same(operator, word))
}

/// Parses the path of a variable, or an enumeration value `Type#Value`.
pub(super) fn path(cursor: &mut Cursor) -> Result<Path, Fault> {
    let mut path = match cursor.peek().clone() {
        Token::Direct(text) => {
            cursor.next();
            Path::name(text.to_ascii_uppercase())
        }
        _ => Path::name(cursor.name("a variable")?),
    };
    if cursor.is_sign("#") {
        // An enumeration value with its type in front.
        cursor.next();
        path.first = format!("{}#{}", path.first, cursor.name("a value's name")?);
        return Ok(path);
    }
    loop {
        if cursor.take_sign(".") {
            let line = cursor.line();
            let part = match cursor.next() {
                Token::Word(name) => Part::Name(name),
                Token::Direct(text) => bit(text.trim_start_matches(['%', 'X', 'x']), line)?,
                Token::Number(text) => bit(&text, line)?,
                _ => {
                    return Err(Fault::new(line, "after the dot the name of a field was expected"));
                }
            };
            path.rest.push(part);
        } else if cursor.take_sign("[") {
            let mut indices = vec![cursor.deeper(expression)?];
            while cursor.take_sign(",") {
                indices.push(cursor.deeper(expression)?);
            }
            cursor.sign("]")?;
            path.rest.push(Part::Index(indices));
        } else if cursor.take_sign("^") {
            path.rest.push(Part::Dereference);
        } else {
            return Ok(path);
        }
    }
}

fn bit(text: &str, line: u32) -> Result<Part, Fault> {
    let number = text.parse().ok().filter(|&bit: &u8| bit < 64);
    number.map(Part::Bit).ok_or_else(|| Fault::new(line, format!("'{text}' is not a bit number")))
}

/// Parses arguments in brackets.
pub(super) fn arguments(cursor: &mut Cursor) -> Result<Vec<Argument>, Fault> {
    cursor.sign("(")?;
    let mut found = Vec::new();
    while !cursor.take_sign(")") {
        found.push(cursor.deeper(argument)?);
        if !cursor.take_sign(",") {
            cursor.sign(")")?;
            break;
        }
    }
    Ok(found)
}

pub(super) fn argument(cursor: &mut Cursor) -> Result<Argument, Fault> {
    let start = cursor.place();
    let negated = cursor.take_word("NOT");
    if let Token::Word(name) = cursor.peek().clone() {
        if !negated && matches!(cursor.second(), Token::Sign(":=")) {
            cursor.next();
            cursor.next();
            // `IN := ,` passes nothing and leaves the input unchanged.
            if cursor.is_sign(",") || cursor.is_sign(")") {
                let value = Expr::name(name.clone());
                return Ok(Argument { name: Some(name), is_output: true, value });
            }
            return Ok(Argument { name: Some(name), is_output: false, value: expression(cursor)? });
        }
        if matches!(cursor.second(), Token::Sign("=>")) {
            cursor.next();
            cursor.next();
            if cursor.is_sign(",") || cursor.is_sign(")") {
                // `Q => ,` drops the output.
                return Ok(Argument { name: Some(name), is_output: true, value: Expr::name("") });
            }
            let target = Expr::Variable(path(cursor)?);
            let value = if negated { target.not() } else { target };
            return Ok(Argument { name: Some(name), is_output: true, value });
        }
    }
    cursor.back_to(start);
    Ok(Argument { name: None, is_output: false, value: expression(cursor)? })
}

/// A number or a typed literal.
fn literal(text: &str, line: u32) -> Result<Literal, Fault> {
    let fault = || Fault::new(line, format!("'{text}' is not a constant")).text(text);
    let Some((of, value)) = text.split_once('#') else {
        return plain(text, None).ok_or_else(fault);
    };
    let of = of.to_ascii_uppercase();
    match of.as_str() {
        "T" | "TIME" | "LT" | "LTIME" => {
            let help = "write a time as T#1m30s or T#500ms";
            duration(value).map(Literal::Time).ok_or_else(|| fault().help(help))
        }
        "D" | "DATE" | "DT" | "DATE_AND_TIME" | "TOD" | "TIME_OF_DAY" | "LDT" | "LTOD"
        | "LDATE" => Ok(Literal::Date(text.to_owned())),
        "BOOL" => match value.to_ascii_uppercase().as_str() {
            "1" | "TRUE" => Ok(Literal::Bool(true)),
            "0" | "FALSE" => Ok(Literal::Bool(false)),
            _ => Err(fault()),
        },
        "2" | "8" | "16" => plain(text, None).ok_or_else(fault),
        _ => plain(value, Some(of)).ok_or_else(fault),
    }
}

fn plain(text: &str, of: Option<String>) -> Option<Literal> {
    let digits: String = text.chars().filter(|&c| c != '_').collect();
    let is_real = of.as_deref().is_some_and(|of| of.ends_with("REAL"));
    if let Some((base, value)) = digits.split_once('#') {
        let (negative, base) = match base.strip_prefix('-') {
            Some(base) => (true, base),
            None => (false, base),
        };
        let base: u32 = base.parse().ok().filter(|base| [2, 8, 16].contains(base))?;
        let number = i128::from_str_radix(value, base).ok().filter(|_| !value.starts_with('-'))?;
        return Some(Literal::Int(if negative { -number } else { number }, of));
    }
    if is_real || digits.contains(['.', 'e', 'E']) {
        let is_number = digits.chars().all(|c| c.is_ascii_digit() || ".eE+-".contains(c));
        return is_number.then_some(Literal::Real(digits, of));
    }
    digits.parse().ok().map(|number| Literal::Int(number, of))
}

/// The nanoseconds of a duration such as `1m30s_5ms` or `-2.5s`; `None` if it cannot be read or does not fit. Fractions
/// of a nanosecond are dropped.
#[must_use]
pub fn duration(text: &str) -> Option<i64> {
    let (sign, text) = match text.strip_prefix('-') {
        Some(rest) => (-1, rest),
        None => (1, text),
    };
    let text: String = text.chars().filter(|&c| c != '_').collect::<String>().to_ascii_lowercase();
    let mut rest = text.as_str();
    let mut sum = 0_i128;
    if rest.is_empty() {
        return None;
    }
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.')?;
        let (number, tail) = rest.split_at(digits);
        let unit = tail.find(|c: char| !c.is_ascii_lowercase()).unwrap_or(tail.len());
        let each: i128 = match &tail[..unit] {
            "d" => 86_400_000_000_000,
            "h" => 3_600_000_000_000,
            "m" => 60_000_000_000,
            "s" => 1_000_000_000,
            "ms" => 1_000_000,
            "us" => 1_000,
            "ns" => 1,
            _ => return None,
        };
        let (whole, part) = number.split_once('.').unwrap_or((number, ""));
        if whole.is_empty() || part.len() > 12 {
            return None;
        }
        sum += whole.parse::<i128>().ok()?.checked_mul(each)?;
        if !part.is_empty() {
            let scale = 10_i128.pow(u32::try_from(part.len()).ok()?);
            sum += part.parse::<i128>().ok()?.checked_mul(each)? / scale;
        }
        rest = &tail[unit..];
    }
    i64::try_from(sum * sign).ok()
}

/// Whether a word is a keyword, which cannot name a variable.
pub(super) fn is_keyword(word: &str) -> bool {
    const KEYWORDS: &[&str] = &[
        "IF",
        "THEN",
        "ELSE",
        "ELSIF",
        "END_IF",
        "CASE",
        "OF",
        "END_CASE",
        "FOR",
        "TO",
        "BY",
        "DO",
        "END_FOR",
        "WHILE",
        "END_WHILE",
        "REPEAT",
        "UNTIL",
        "END_REPEAT",
        "EXIT",
        "RETURN",
        "CONTINUE",
        "AND",
        "OR",
        "XOR",
        "NOT",
        "MOD",
        "VAR",
        "END_VAR",
        "STEP",
        "INITIAL_STEP",
        "END_STEP",
        "TRANSITION",
        "END_TRANSITION",
        "END_ACTION",
        "END_PROGRAM",
        "END_FUNCTION",
        "END_FUNCTION_BLOCK",
    ];
    KEYWORDS.iter().any(|keyword| same(keyword, word))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show;

    fn read(text: &str) -> String {
        show::expr(&crate::parse::expression(text, 1).expect(text))
    }

    #[test]
    fn operators_bind_as_the_standard_says() {
        for (text, is) in [
            ("NOT a AND b OR c", "NOT a AND b OR c"),
            ("(a OR b) & c", "(a OR b) AND c"),
            ("a OR (b OR c)", "a OR b OR c"),
            ("a OR (b AND c)", "a OR b AND c"),
            ("a AND (b OR c)", "a AND (b OR c)"),
            ("a - (b - c) * 2 ** 3", "a - (b - c) * 2 ** 3"),
            ("x.y[1, i + 1].3 >= -5", "x.y[1, i + 1].3 >= -5"),
            ("MAX(a, IN2 := b)", "MAX(a, IN2 := b)"),
            ("s1.T >= T#1m30s", "s1.T >= T#90s"),
            ("16#FF = 2#1_1", "255 = 3"),
            ("NOT (a = b)", "NOT (a = b)"),
            ("Color#red", "Color#red"),
        ] {
            assert_eq!(read(text), is, "{text}");
            assert_eq!(read(&read(text)), is, "{text}");
        }
    }

    #[test]
    fn many_operands_of_bits_stand_no_deeper_than_need_be() {
        fn depth(one: &Expr) -> usize {
            match one {
                Expr::Binary(_, left, right) => 1 + depth(left).max(depth(right)),
                _ => 0,
            }
        }
        let row = |many: usize, by: &str| -> String {
            (0..many).map(|at| format!("x{at}")).collect::<Vec<_>>().join(by)
        };
        let read = |text: &str| crate::parse::expression(text, 1);
        for by in [" OR ", " AND ", " XOR "] {
            let found = read(&row(5000, by)).expect("an expression");
            assert!(depth(&found) <= 13, "{by}: {}", depth(&found));
            assert_eq!(show::expr(&found), row(5000, by));
        }
        // Sums and calls keep their order from left to right.
        assert_eq!(depth(&read(&row(200, " + ")).expect("a sum")), 199);
        assert!(read(&row(201, " + ")).is_err());
        assert_eq!(depth(&read(&row(40, "() OR ")).expect("calls")), 39);
    }

    #[test]
    fn durations_are_exact() {
        for (text, ns) in [
            ("1d2h3m4s5ms6us7ns", Some(93_784_005_006_007)),
            ("2.5s", Some(2_500_000_000)),
            ("-10ms", Some(-10_000_000)),
            ("500MS", Some(500_000_000)),
            ("5", None),
            ("", None),
            ("5x", None),
            ("99999999999999999999999d", None),
        ] {
            assert_eq!(duration(text), ns, "{text}");
        }
    }

    #[test]
    fn what_is_no_expression_is_told() {
        for text in ["", "a AND", "(a", "a b", "THEN", "a[1", "T#5", "16#G", "a.", "f(a"] {
            assert!(crate::parse::expression(text, 3).is_err(), "{text}");
        }
        let deep = format!("{}a{}", "(".repeat(5000), ")".repeat(5000));
        assert!(crate::parse::expression(&deep, 1).is_err());
    }
}

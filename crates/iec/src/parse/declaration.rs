//! The parser of declarations of variables and types.

use super::cursor::Cursor;
use super::expression::{arguments, expression};
use crate::ast::{Argument, Expr, Listing, Literal, Path};
use crate::fault::Fault;
use crate::lexer::Token;
use crate::{Section, TypeDeclaration, TypeRef, Variable, same};

/// Consumes the keyword of a section, such as `VAR_INPUT`; `None` if there is none at the cursor.
pub(super) fn section(cursor: &mut Cursor) -> Option<Section> {
    let Token::Word(word) = cursor.peek() else { return None };
    let section = match word.to_ascii_uppercase().as_str() {
        "VAR" | "VAR_CONFIG" | "VAR_ACCESS" => Section::Local,
        "VAR_TEMP" => Section::Temp,
        "VAR_INPUT" => Section::Input,
        "VAR_OUTPUT" => Section::Output,
        "VAR_IN_OUT" => Section::InOut,
        "VAR_EXTERNAL" => Section::External,
        "VAR_GLOBAL" => Section::Global,
        "VAR_STAT" => Section::Static,
        "VAR_INST" => Section::Instance,
        _ => return None,
    };
    cursor.next();
    Some(section)
}

/// Access modifiers of sections.
const ACCESS: &[&str] = &["PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL"];

/// Parses the variables of a section up to END_VAR, which is consumed.
pub(super) fn variables(cursor: &mut Cursor, section: Section) -> Result<Vec<Variable>, Fault> {
    let (mut constant, mut retain) = (false, false);
    loop {
        if cursor.take_word("CONSTANT") {
            constant = true;
        } else if cursor.take_word("RETAIN") || cursor.take_word("PERSISTENT") {
            retain = true;
        } else if cursor.take_word("NON_RETAIN") {
        } else if cursor.is_one_of(ACCESS) && matches!(cursor.second(), Token::Word(_)) {
            // Access modifiers do not affect execution.
            cursor.next();
        } else {
            break;
        }
    }
    let mut found = Vec::new();
    while !cursor.take_word("END_VAR") {
        let line = cursor.line();
        let mut names = vec![cursor.name("a variable's name or END_VAR")?];
        let mut at = None;
        if cursor.take_word("AT") {
            at = Some(direct(cursor)?);
        }
        while cursor.take_sign(",") {
            names.push(cursor.name("a variable's name")?);
        }
        cursor.sign(":")?;
        let of = cursor.deeper(type_ref)?;
        let edge = edge(cursor);
        let initial = if cursor.is_sign("(") {
            // The arguments of the instance's method FB_Init.
            Some(Expr::List(Listing::Parts, cursor.deeper(arguments)?))
        } else if cursor.take_sign(":=") || refers(cursor) {
            Some(cursor.deeper(initial)?)
        } else {
            None
        };
        cursor.sign(";")?;
        for name in names {
            if let Some(of) = edge.clone() {
                let memory = Variable::new(edge_memory(&name), Section::Local, of, line);
                found.push(Variable { retain, is_internal: true, ..memory });
            }
            found.push(Variable {
                initial: initial.clone(),
                at: at.clone(),
                constant,
                retain,
                has_edge: edge.is_some(),
                ..Variable::new(name, section, of.clone(), line)
            });
        }
    }
    Ok(found)
}

/// Consumes `REF=`; whether it was there.
fn refers(cursor: &mut Cursor) -> bool {
    let is = cursor.is_word("REF") && matches!(cursor.second(), Token::Sign("="));
    if is {
        cursor.next();
        cursor.next();
    }
    is
}

fn direct(cursor: &mut Cursor) -> Result<String, Fault> {
    match cursor.next() {
        Token::Direct(text) => Ok(text.to_ascii_uppercase()),
        _ => {
            let line = cursor.line();
            Err(Fault::new(line, "after AT a direct address such as %IX0.1 was expected"))
        }
    }
}

/// Parses an initial value. A list that cannot be read becomes [`Listing::Unread`] with the calls that it may contain.
fn initial(cursor: &mut Cursor) -> Result<Expr, Fault> {
    let place = cursor.place();
    if let Some(listed) = listed(cursor) {
        return Ok(listed);
    }
    cursor.back_to(place);
    if cursor.is_sign("[") || cursor.is_sign("(") {
        let close = if cursor.is_sign("[") { "]" } else { ")" };
        let open = if close == "]" { "[" } else { "(" };
        let mut depth = 0_u32;
        // The calls that the list may contain: `G(0)` is one, the repetition `3(0)` is not.
        let mut calls = Vec::new();
        loop {
            if *cursor.peek() == Token::End {
                return Err(cursor.unexpected(close));
            }
            if let Token::Word(name) = cursor.peek().clone()
                && *cursor.second() == Token::Sign("(")
            {
                let value = Expr::Call(Path::name(name), Vec::new());
                calls.push(Argument { name: None, is_output: false, value });
            }
            if cursor.is_sign(open) {
                depth += 1;
            }
            if cursor.is_sign(close) {
                depth -= 1;
            }
            cursor.next();
            if depth == 0 {
                break;
            }
        }
        if cursor.is_sign(";") && open == "[" {
            return Ok(Expr::List(Listing::Unread, calls));
        }
        cursor.back_to(place);
        if let Ok(value) = expression(cursor) {
            return Ok(value);
        }
        cursor.back_to(place);
        while !cursor.is_sign(";") && *cursor.peek() != Token::End {
            cursor.next();
        }
        return Ok(Expr::List(Listing::Unread, calls));
    }
    expression(cursor)
}

/// Parses a list of elements, or of fields by name. `None` if it has another form or is too long; the cursor may then
/// have moved.
fn listed(cursor: &mut Cursor) -> Option<Expr> {
    let is_parts = cursor.is_sign("(") && is_enumeration(cursor);
    if is_parts && !names_parts(cursor) || !is_parts && !cursor.is_sign("[") {
        return None;
    }
    cursor.next();
    let close = if is_parts { ")" } else { "]" };
    let mut found = Vec::new();
    let mut listed = 0_usize;
    while !cursor.take_sign(close) {
        let mut name = None;
        if is_parts {
            name = Some(cursor.name("a part's name").ok()?);
            cursor.sign(":=").ok()?;
        }
        let times = if is_parts { 1 } else { repeated(cursor) };
        let value = cursor.deeper(initial).ok()?;
        listed = listed.saturating_add(values_in(&value).saturating_mul(times));
        if times != 1 && !cursor.take_sign(")") || listed > MAX_LISTED {
            return None;
        }
        let one = Argument { name, is_output: false, value };
        found.extend(std::iter::repeat_n(one, times));
        if !cursor.take_sign(",") && !cursor.is_sign(close) {
            return None;
        }
    }
    Some(Expr::List(if is_parts { Listing::Parts } else { Listing::Elements }, found))
}

/// The maximum number of values that a list is expanded to.
pub(crate) const MAX_LISTED: usize = 20_000;

/// The number of values in an initial value: the value itself and all values nested in it.
pub(crate) fn values_in(value: &Expr) -> usize {
    match value {
        Expr::Call(_, given) | Expr::List(_, given) => {
            1 + given.iter().map(|one| values_in(&one.value)).sum::<usize>()
        }
        _ => 1,
    }
}

/// Consumes the start of a repetition, such as `3(`, and returns its count; 1 without consuming anything if there is
/// none.
fn repeated(cursor: &mut Cursor) -> usize {
    let place = cursor.place();
    if let Token::Number(written) = cursor.next()
        && let Ok(times @ 2..) = written.parse()
        && cursor.take_sign("(")
    {
        return times;
    }
    cursor.back_to(place);
    1
}

/// Whether the brackets at the cursor begin with a field's name and `:=`.
fn names_parts(cursor: &mut Cursor) -> bool {
    let place = cursor.place();
    cursor.next();
    let is = cursor.name("a name").is_ok() && cursor.is_sign(":=");
    cursor.back_to(place);
    is
}

/// Parses a type.
pub(super) fn type_ref(cursor: &mut Cursor) -> Result<TypeRef, Fault> {
    if cursor.take_word("ARRAY") {
        cursor.sign("[")?;
        let mut dimensions = Vec::new();
        loop {
            let low = expression(cursor)?;
            cursor.sign("..")?;
            dimensions.push((low, expression(cursor)?));
            if !cursor.take_sign(",") {
                break;
            }
        }
        cursor.sign("]")?;
        cursor.word("OF")?;
        let of = cursor.deeper(type_ref)?;
        return Ok(TypeRef::Array(dimensions, Box::new(of)));
    }
    if cursor.take_word("STRUCT") {
        let mut parts = Vec::new();
        while !cursor.take_word("END_STRUCT") {
            let line = cursor.line();
            let mut names = vec![cursor.name("a part's name or END_STRUCT")?];
            while cursor.take_sign(",") {
                names.push(cursor.name("a part's name")?);
            }
            cursor.sign(":")?;
            let of = cursor.deeper(type_ref)?;
            let start = if cursor.take_sign(":=") { Some(cursor.deeper(initial)?) } else { None };
            cursor.sign(";")?;
            parts.extend(names.into_iter().map(|name| Variable {
                initial: start.clone(),
                ..Variable::new(name, Section::Local, of.clone(), line)
            }));
        }
        return Ok(TypeRef::Struct(parts));
    }
    if cursor.take_sign("(") {
        let mut values = Vec::new();
        loop {
            let name = cursor.name("a value's name")?;
            let number = if cursor.take_sign(":=") { Some(expression(cursor)?) } else { None };
            values.push((name, number));
            if !cursor.take_sign(",") {
                break;
            }
        }
        cursor.sign(")")?;
        // CODESYS writes the base type after the values.
        let base = cursor.is_one_of(NUMBERS).then(|| cursor.name("a type")).transpose()?;
        return Ok(TypeRef::Enumeration(values, base.map(|base| Box::new(TypeRef::Named(base)))));
    }
    if cursor.take_word("POINTER") {
        cursor.word("TO")?;
        return Ok(TypeRef::Pointer(Box::new(cursor.deeper(type_ref)?)));
    }
    if cursor.take_word("REFERENCE") {
        cursor.word("TO")?;
        return Ok(TypeRef::Reference(Box::new(cursor.deeper(type_ref)?)));
    }
    if cursor.take_word("REF_TO") {
        return Ok(TypeRef::Pointer(Box::new(cursor.deeper(type_ref)?)));
    }
    let mut name = cursor.name("a type")?;
    while cursor.take_sign(".") {
        name = cursor.name("a type")?;
    }
    if same(&name, "STRING") || same(&name, "WSTRING") {
        let mut length = None;
        for (open, close) in [("(", ")"), ("[", "]")] {
            if cursor.take_sign(open) {
                length = Some(Box::new(expression(cursor)?));
                cursor.sign(close)?;
            }
        }
        return Ok(TypeRef::Text(length));
    }
    // An enumeration whose base type stands in front of its values.
    if cursor.is_sign("(") && is_enumeration(cursor) {
        if !NUMBERS.iter().any(|number| same(number, &name)) {
            return Ok(TypeRef::Named(name));
        }
        return match type_ref(cursor)? {
            TypeRef::Enumeration(values, _) => {
                Ok(TypeRef::Enumeration(values, Some(Box::new(TypeRef::Named(name)))))
            }
            other => Ok(other),
        };
    }
    // A subrange. Its limits are not enforced at run time.
    if cursor.is_sign("(") {
        cursor.next();
        let least = expression(cursor)?;
        let most = match cursor.take_sign("..") {
            true => expression(cursor)?,
            false => least.clone(),
        };
        cursor.sign(")")?;
        return Ok(TypeRef::Subrange(Box::new(TypeRef::Named(name)), Box::new((least, most))));
    }
    Ok(TypeRef::Named(name))
}

/// The possible base types of enumerations.
const NUMBERS: &[&str] = &[
    "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "BYTE", "WORD", "DWORD",
    "LWORD",
];

/// Whether the brackets at the cursor hold named values, not a range or a length.
fn is_enumeration(cursor: &mut Cursor) -> bool {
    let place = cursor.place();
    let is = cursor.take_sign("(")
        && cursor.name("a name").is_ok()
        && (cursor.is_sign(",") || cursor.is_sign(":="));
    cursor.back_to(place);
    is
}

/// The name of the trigger instance for an input declared R_EDGE or F_EDGE.
#[must_use]
pub(super) fn edge_memory(name: &str) -> String {
    format!("{name}.edge")
}

/// Consumes R_EDGE or F_EDGE and returns the type of the trigger instance; `None` if neither is at the cursor.
fn edge(cursor: &mut Cursor) -> Option<TypeRef> {
    let of = match (cursor.take_word("R_EDGE"), cursor.take_word("F_EDGE")) {
        (true, _) => "R_TRIG",
        (_, true) => "F_TRIG",
        _ => return None,
    };
    Some(TypeRef::Named(of.to_owned()))
}

/// Parses the declarations between TYPE, already consumed, and END_TYPE.
pub(super) fn types(cursor: &mut Cursor) -> Result<Vec<TypeDeclaration>, Fault> {
    let mut found = Vec::new();
    while !cursor.take_word("END_TYPE") {
        let line = cursor.line();
        let name = cursor.name("a type's name or END_TYPE")?;
        let extends = match cursor.take_word("EXTENDS") {
            true => Some(cursor.name("a type's name")?),
            false => None,
        };
        cursor.sign(":")?;
        let of = type_ref(cursor)?;
        let start = if cursor.take_sign(":=") { Some(initial(cursor)?) } else { None };
        cursor.take_sign(";");
        found.push(TypeDeclaration { name, extends, of, initial: start, file: 0, line });
    }
    Ok(found)
}

/// Parses the properties of a task in brackets: the interval in nanoseconds and the priority, if stated.
pub(super) fn task(cursor: &mut Cursor) -> Result<(Option<i64>, Option<String>), Fault> {
    let (mut interval, mut priority) = (None, None);
    for Argument { name, value, .. } in super::expression::arguments(cursor)? {
        match (name.as_deref().map(str::to_ascii_uppercase).as_deref(), value) {
            (Some("INTERVAL"), Expr::Literal(Literal::Time(time))) => interval = Some(time),
            (Some("PRIORITY"), Expr::Literal(Literal::Int(number, _))) => {
                priority = Some(number.to_string());
            }
            _ => {}
        }
    }
    Ok((interval, priority))
}

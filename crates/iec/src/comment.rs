//! Comments and pragmas: where they end, and which of them affect execution.

use super::fault::Fault;
use scanbound_base::code::Code;
use std::borrow::Cow;

/// The rule for comments that contain the start of another comment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Comments {
    /// Comments nest: the outer comment ends after the inner one.
    Nested,
    /// Comments do not nest: the first end mark closes the outer comment.
    Flat,
}

/// The effect of a pragma.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Pragma {
    /// It changes neither execution nor variables. A few attributes that matter are searched for elsewhere, in the
    /// whole text.
    Harmless,
    /// It may contain code, such as C for Beremiz and OpenPLC, or something unknown.
    Code,
}

/// The kind of text that the lexer skips.
pub(super) enum Skipped {
    /// A comment, or a pragma without effect.
    Blank,
    /// A pragma that a controller may execute.
    Code,
}

/// The start and end marks of comments.
const BLOCKS: [(&str, &str); 2] = [("(*", "*)"), ("/*", "*/")];

/// The lengths of a comment or pragma at the start of a text, under both rules, in bytes.
struct Ends {
    flat: usize,
    /// `None` if an inner comment has no end.
    nested: Option<usize>,
}

impl Ends {
    /// The lengths of a comment with these marks at the start of the text; `None` if no end mark follows.
    fn of(text: &str, open: &str, close: &str) -> Option<Ends> {
        let bytes = text.as_bytes();
        let begins = |at: usize, sign: &str| bytes[at..].starts_with(sign.as_bytes());
        let (mut at, mut depth, mut flat) = (open.len(), 1_usize, None);
        while at < bytes.len() {
            if begins(at, close) {
                at += close.len();
                flat = flat.or(Some(at));
                depth -= 1;
                if depth == 0 {
                    return Some(Ends { flat: at.min(flat.unwrap_or(at)), nested: Some(at) });
                }
            } else if begins(at, open) {
                at += open.len();
                depth += 1;
            } else {
                at += 1;
            }
        }
        Some(Ends { flat: flat?, nested: None })
    }

    /// The lengths of a pragma at the start of the text. If it begins with two braces it ends with two.
    fn of_pragma(text: &str) -> Option<Ends> {
        let ends = Ends::of(text, "{", "}")?;
        if !text.starts_with("{{") {
            return Some(ends);
        }
        let flat = text.find("}}").map_or(ends.flat, |at| at + 2);
        Some(Ends { flat, ..ends })
    }

    fn by(&self, reading: Comments) -> Option<usize> {
        match reading {
            Comments::Flat => Some(self.flat),
            Comments::Nested => self.nested,
        }
    }
}

/// The length of a `//` comment at the start of the text; `None` if there is none.
fn line_comment(rest: &str) -> Option<usize> {
    rest.starts_with("//").then(|| rest.find('\n').unwrap_or(rest.len()))
}

/// The kind and length of a comment or pragma at the start of the text; `None` if there is none. A fault if the two
/// nesting rules disagree.
pub(super) fn skipped(rest: &str, line: u32) -> Result<Option<(Skipped, usize)>, Fault> {
    if let Some(length) = line_comment(rest) {
        if rest[..length].trim_end_matches('\r').contains('\r') {
            let told = "a carriage return without a line feed is in this comment: some tools end the line there, and execute what follows";
            return Err(Fault::new(line, told)
                .code(Code::Comments)
                .help("save the file with the line ends of one system"));
        }
        return Ok(Some((Skipped::Blank, length)));
    }
    let no_end = |open: &str| {
        let told = format!("the comment that begins with {open} has no end");
        Fault::new(line, told).help(format!("write its end, or take the {open} away"))
    };
    for (open, close) in BLOCKS {
        if rest.starts_with(open) {
            let ends = Ends::of(rest, open, close).ok_or_else(|| no_end(open))?;
            let length = agreed(&ends, rest, open, line)?;
            return Ok(Some((Skipped::Blank, length)));
        }
    }
    if !rest.starts_with('{') {
        return Ok(None);
    }
    let ends = Ends::of_pragma(rest).ok_or_else(|| no_end("{"))?;
    let length = agreed(&ends, rest, "{", line)?;
    let skipped = match pragma(&rest[..length], line)? {
        Pragma::Harmless => Skipped::Blank,
        Pragma::Code => Skipped::Code,
    };
    Ok(Some((skipped, length)))
}

/// The length on which both nesting rules agree; a fault if they disagree.
fn agreed(ends: &Ends, rest: &str, open: &str, line: u32) -> Result<usize, Fault> {
    if ends.nested == Some(ends.flat) {
        return Ok(ends.flat);
    }
    let last = |length: usize| line + newlines(&rest[..length]);
    let nested = match ends.nested {
        Some(length) => format!("in line {} if they nest", last(length)),
        None => "nowhere if they nest".to_owned(),
    };
    let (what, several) = if open == "{" { ("pragma", "pragmas") } else { ("comment", "comments") };
    let told = format!(
        "this {what} contains another {open}: it ends in line {} if {several} do not nest, and {nested}",
        last(ends.flat)
    );
    let help = "state how the controller reads it: --comments flat (they do not nest) or --comments nested; or remove the inner one";
    let text = rest.lines().next().unwrap_or_default();
    Err(Fault::new(line, told).code(Code::Comments).text(text).help(help))
}

/// The number of line feeds in a text.
pub(super) fn newlines(text: &str) -> u32 {
    u32::try_from(text.matches('\n').count()).unwrap_or(u32::MAX)
}

/// Replaces comments by blanks, keeping the line structure, under the stated nesting rule.
#[must_use]
pub fn without_comments(text: &str, reading: Comments) -> Cow<'_, str> {
    let mut out = String::new();
    let (mut at, mut copied) = (0, 0);
    while let Some(found) = text[at..].find(['(', '/', '{', '\'', '"']) {
        at += found;
        let rest = &text[at..];
        if rest.starts_with(['\'', '"']) {
            at += quoted(rest).unwrap_or(1);
            continue;
        }
        let block = BLOCKS.iter().find(|(open, _)| rest.starts_with(open));
        let ends = block.and_then(|(open, close)| Ends::of(rest, open, close));
        let length = match line_comment(rest) {
            Some(length) => Some(length),
            None => ends.and_then(|ends| ends.by(reading)),
        };
        if let Some(length) = length {
            out += &text[copied..at];
            out.extend(rest[..length].chars().map(|c| if c == '\n' { c } else { ' ' }));
            at += length;
            copied = at;
            continue;
        }
        if block.is_some() {
            // It has no end. Leave it, so that the parser reports it.
            break;
        }
        // A pragma stays, but its inner braces are replaced, so that both rules agree on its end.
        let ends = rest.starts_with('{').then(|| Ends::of_pragma(rest)).flatten();
        let Some(length) = ends.and_then(|ends| ends.by(reading)) else {
            if rest.starts_with('{') {
                break;
            }
            at += 1;
            continue;
        };
        let doubled = usize::from(rest.starts_with("{{")) + 1;
        let inner = rest.get(doubled..length.saturating_sub(doubled)).unwrap_or_default();
        if inner.contains(['{', '}']) {
            out += &text[copied..at + doubled];
            out.extend(inner.chars().map(|c| match c {
                '{' => '(',
                '}' => ')',
                other => other,
            }));
            copied = at + doubled + inner.len();
        }
        at += length;
    }
    if copied == 0 {
        return Cow::Borrowed(text);
    }
    out += &text[copied..];
    Cow::Owned(out)
}

/// The length of the quoted text at the start; `None` if it has no end.
pub(super) fn quoted(rest: &str) -> Option<usize> {
    let quote = rest.chars().next()?;
    let mut escaped = false;
    for (at, c) in rest.char_indices().skip(1) {
        if c == quote && !escaped {
            return Some(at + 1);
        }
        escaped = c == '$' && !escaped;
    }
    None
}

/// The first words of conditional pragmas.
const CONDITIONS: &[&str] = &["if", "elsif", "else", "end_if"];

/// The first words of pragmas without code or effect on execution: messages, folding, symbols for conditional pragmas
/// (which are rejected themselves), names of bits, style checks.
const HARMLESS: &[&str] = &[
    "text",
    "info",
    "warning",
    "error",
    "region",
    "endregion",
    "define",
    "undefine",
    "bitaccess",
    "analysis",
    "flag",
];

/// Attributes of CODESYS and TwinCAT that affect display, checks, editing or communication, but not execution. Those
/// that begin with `call_after_` are searched for in the whole text.
const ATTRIBUTES: &[&str] = &[
    "analysis",
    "call_after_global_init_slot",
    "call_after_init",
    "call_after_online_change_slot",
    "call_on_type_change",
    "conditionalshow",
    "conditionalshow_all_locals",
    "const_replaced",
    "const_non_replaced",
    "displaymode",
    "estimated-stack-usage",
    "expandfully",
    "hide",
    "hide_all_locals",
    "init_on_onlchange",
    "linkalways",
    "monitoring",
    "nameprefix",
    "naming",
    "no_check",
    "no_copy",
    "no_explicit_call",
    "no_instance_in_retain",
    "obsolete",
    "opc.ua.da",
    "opc.ua.da.access",
    "opc.ua.da.structuredtype",
    // The memory layout of structures, on which nothing here depends.
    "pack_mode",
    "pingroup",
    "pin_presentation_order_inputs",
    "pin_presentation_order_outputs",
    "qualified_only",
    "reflection",
    "strict",
    "suppress_warning_0",
    "symbol",
    "tccontextname",
    "tcdisplayscale",
    "tcdisplayunit",
    "tchmisymbol.show",
    "tclinkto",
    "tclinktooso",
    "tcnosymbol",
    "to_string",
    "warning disable",
    "warning restore",
];

/// Classifies a pragma, given with its braces; a fault if its effect on execution is unknown.
fn pragma(text: &str, line: u32) -> Result<Pragma, Fault> {
    let inner = text[1..text.len() - 1].trim();
    let end = inner.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(inner.len());
    let (word, rest) = inner.split_at(end);
    let word = word.to_ascii_lowercase();
    let rest = rest.trim();
    let refused = |told: String, help: &str| {
        Err(Fault::new(line, told).code(Code::Pragma).text(text).help(help))
    };
    if word == "attribute" {
        let name = quoted(rest).map(|length| &rest[1..length - 1]);
        if name.is_some_and(is_harmless_attribute) {
            return Ok(Pragma::Harmless);
        }
        let told = format!(
            "whether {} changes execution or the values of variables is not known",
            super::fault::short(text)
        );
        return refused(told, "take it out of a copy of the file if it changes neither");
    }
    let is_code = without_quotes(rest).contains(';');
    if CONDITIONS.contains(&word.as_str()) && !is_code {
        let told = format!(
            "{} selects what is compiled, and which part is selected is not known",
            super::fault::short(text)
        );
        return refused(told, "give a copy of the file with only the parts that are compiled");
    }
    let begins_anew = word == "flag" && rest.to_ascii_lowercase().contains("noinit");
    let is_assigned = rest.starts_with(['(', '{', '=', '.', '-']);
    let is_harmless = HARMLESS.contains(&word.as_str()) && !is_code && !is_assigned && !begins_anew;
    Ok(if is_harmless || inner.is_empty() { Pragma::Harmless } else { Pragma::Code })
}

/// Whether the attribute of this name does not affect execution.
pub(super) fn is_harmless_attribute(name: &str) -> bool {
    let name = name.trim().to_ascii_lowercase();
    let first = name.split_whitespace().take(2).collect::<Vec<_>>().join(" ");
    ATTRIBUTES.contains(&name.as_str()) || ATTRIBUTES.contains(&first.as_str())
}

/// The text without its quoted parts.
fn without_quotes(text: &str) -> String {
    let mut found = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(['\'', '"']) {
        found += &rest[..at];
        rest = &rest[at..];
        rest = &rest[quoted(rest).unwrap_or(rest.len())..];
    }
    found + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(text: &str) -> usize {
        skipped(text, 1).expect("both readings agree").expect("a comment").1
    }

    #[test]
    fn both_readings_must_agree() {
        assert_eq!(length("(* a *) b *)"), 7);
        assert_eq!(length("(* { // *) b"), 10);
        assert_eq!(length("// (* b\nc"), 7);
        assert_eq!(length("{region 'a'} b"), 12);
        assert_eq!(length("{{ a }} b"), 7);
        for text in ["(* (* *) *)", "(* (* *)", "/* /* */ */", "{ a { b } }", "{{ {{ }} }}"] {
            let fault = skipped(text, 7).err().expect(text);
            assert_eq!((fault.code, fault.line), (Code::Comments, 7), "{text}");
        }
        assert_eq!(skipped("(* a", 1).err().expect("no end").code, Code::Syntax);
    }

    #[test]
    fn stated_readings_leave_blanks() {
        let text = "a (* x (* y *) b\n*) c // (*\n'(*' {d{e}f}";
        let flat = without_comments(text, Comments::Flat);
        assert_eq!(flat, format!("a {:12} b\n*) c      \n'(*' {{d(e}}f}}", ""));
        let nested = without_comments(text, Comments::Nested);
        assert_eq!(nested, format!("a {:14}\n   c      \n'(*' {{d(e)f}}", ""));
        assert!(matches!(without_comments("a + b", Comments::Flat), Cow::Borrowed(_)));
        assert_eq!(without_comments("a (* b", Comments::Flat), "a (* b");
        assert_eq!(without_comments("a (* (* b *)", Comments::Nested), "a (* (* b *)");
    }

    #[test]
    fn pragmas_are_told_apart() {
        let of = |text: &str| pragma(text, 1).map_err(|fault| fault.code);
        for text in [
            "{attribute 'hide'}",
            "{attribute 'symbol' := 'read;write'}",
            "{attribute 'warning disable' := 'C1'}",
            "{warning 'a; b'}",
            "{region \"x\"}",
            "{ ENDREGION }",
            "{define X}",
            "{}",
        ] {
            assert_eq!(of(text), Ok(Pragma::Harmless), "{text}");
        }
        for text in [
            "{usleep(1);}",
            "{{ a }}",
            "{if (a) b();}",
            "{error(1)}",
            "{external}",
            "{disable code generation}",
            "{flag noinit on}",
            "{warning = 3; }",
            "{#include \"a.h\"}",
        ] {
            assert_eq!(of(text), Ok(Pragma::Code), "{text}");
        }
        for text in [
            "{IF defined (X)}",
            "{END_IF}",
            "{else}",
            "{attribute 'no_init'}",
            "{attribute 'TcRetain' := '1'}",
            "{attribute}",
        ] {
            assert_eq!(of(text), Err(Code::Pragma), "{text}");
        }
    }
}

//! Limits for XML files, so that parsing stays fast: the XML parser compares each namespace with all enclosing ones,
//! and each attribute with all others of its element.

use crate::fault::Fault;
use scanbound_base::code::Code;

/// The maximum number of namespaces declared in an element and those around it.
const SPACES: usize = 200;

/// The maximum number of attributes of an element.
const ATTRIBUTES: usize = 500;

/// The maximum nesting depth of elements.
const DEPTH: usize = 1_000;

/// Rejects a text that exceeds a limit. Malformed XML is accepted here, because the parser reports it.
pub(super) fn within(text: &str) -> Result<(), Fault> {
    let mut around: Vec<usize> = Vec::new();
    let mut spaces = 0;
    let mut at = 0;
    while let Some(next) = text[at..].find('<').map(|next| at + next) {
        let rest = &text[next..];
        let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("<!", ">")];
        if let Some((_, end)) = skipped.iter().find(|(begin, _)| rest.starts_with(begin)) {
            let Some(length) = rest.find(end) else { return Ok(()) };
            at = next + length + end.len();
            continue;
        }
        let Some(tag) = tag(rest) else { return Ok(()) };
        at = next + tag.length;
        if rest.starts_with("</") {
            spaces -= around.pop().unwrap_or(0).min(spaces);
            continue;
        }
        let told = |what: String| {
            let line = text[..next].matches('\n').count() + 1;
            let line = u32::try_from(line).unwrap_or(u32::MAX);
            let help = "no tool writes so many: export it again as PLCopen XML";
            Err(Fault::new(line, what).code(Code::TooLarge).help(help))
        };
        if tag.attributes > ATTRIBUTES {
            return told(format!("an element has more than {ATTRIBUTES} attributes"));
        }
        if tag.is_closed {
            continue;
        }
        around.push(tag.spaces);
        spaces += tag.spaces;
        if spaces > SPACES {
            return told(format!(
                "more than {SPACES} namespaces are declared in an element and those around it"
            ));
        }
        if around.len() > DEPTH {
            return told(format!("more than {DEPTH} elements are nested"));
        }
    }
    Ok(())
}

/// A tag: its length in bytes, the number of its attributes and of its namespace declarations.
struct Tag {
    length: usize,
    attributes: usize,
    spaces: usize,
    is_closed: bool,
}

/// Reads a tag up to its end; `None` if it has no end.
fn tag(text: &str) -> Option<Tag> {
    let bytes = text.as_bytes();
    let mut tag = Tag { length: 0, attributes: 0, spaces: 0, is_closed: false };
    let mut at = 1;
    loop {
        match bytes.get(at)? {
            b'>' => {
                tag.is_closed = bytes[at - 1] == b'/';
                tag.length = at + 1;
                return Some(tag);
            }
            quote @ (b'"' | b'\'') => {
                at += 1 + bytes[at + 1..].iter().position(|byte| byte == quote)?;
            }
            b'=' => tag.attributes += 1,
            b'x' if text[at..].starts_with("xmlns") && bytes[at - 1].is_ascii_whitespace() => {
                tag.spaces += 1;
            }
            _ => {}
        }
        at += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::within;

    #[test]
    fn what_is_nested_too_deep_is_refused_with_its_line() {
        let nested = |count: usize, tag: &str| {
            format!("<a>\n{}{}</a>", tag.repeat(count), "</e>".repeat(count))
        };
        assert_eq!(within(&nested(100, "<e xmlns:n=\"u\">")), Ok(()));
        let fault = within(&nested(300, "<e xmlns:n=\"u\">")).expect_err("too many");
        assert_eq!(fault.line, 2);
        assert!(within(&nested(2_000, "<e>")).is_err());
        // One after the other there may be any number.
        assert_eq!(within(&"<e xmlns='>'/><e xmlns=\"u\"></e><!-- <e> -->".repeat(3_000)), Ok(()));
        let many: String = (0..600).map(|number| format!(" a{number}='='")).collect();
        assert!(within(&format!("<e{many}/>")).is_err());
        assert_eq!(within("<e a='"), Ok(()));
    }
}

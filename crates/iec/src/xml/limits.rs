//! What a file may hold at most, so that reading it takes no longer than its length says: a reader of XML compares each
//! name space with all around it, and each attribute with all others of its element.

use crate::fault::Fault;
use scanbound_base::code::Code;

/// How many name spaces may be declared in elements around each other.
const SPACES: usize = 200;

/// How many attributes an element may have.
const ATTRIBUTES: usize = 500;

/// How deep elements may stand in each other.
const DEPTH: usize = 1_000;

/// Refuses a text that a reader would take too long for. What is no XML is for the reader to tell.
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
            return told(format!("more than {SPACES} name spaces are declared around an element"));
        }
        if around.len() > DEPTH {
            return told(format!("more than {DEPTH} elements stand in each other"));
        }
    }
    Ok(())
}

/// A tag: how long it is, and what it declares.
struct Tag {
    length: usize,
    attributes: usize,
    spaces: usize,
    is_closed: bool,
}

/// Reads a tag up to its end; nothing, if it has none.
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

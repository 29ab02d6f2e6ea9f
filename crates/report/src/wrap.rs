//! Text on lines that are no wider than the page.

use unicode_width::UnicodeWidthStr;

/// What belongs to the number in front of it.
const UNITS: [&str; 9] = ["%", "ps", "ns", "us", "ms", "s", "min", "h", "days"];

/// The words on lines of at most so many columns; a word that is longer has a line of its own.
#[must_use]
pub fn lines(text: &str, room: usize) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for word in words(text) {
        match found.last_mut() {
            Some(line) if line.width() + 1 + word.width() <= room => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => found.push(word),
        }
    }
    found
}

/// Words between which a line may end: a number and its unit are one.
fn words(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for word in text.split(' ') {
        let unit = word.trim_end_matches([',', ';', ':', ')', '.']);
        match found.last_mut() {
            Some(number)
                if UNITS.contains(&unit) && number.ends_with(|c: char| c.is_ascii_digit()) =>
            {
                number.push(' ');
                number.push_str(word);
            }
            _ => found.push(word.to_owned()),
        }
    }
    found
}

/// The same as one text, each line indented.
#[must_use]
pub fn paragraph(indent: usize, text: &str, width: usize) -> String {
    let blanks = " ".repeat(indent);
    let lines = lines(text, width.saturating_sub(indent));
    lines.iter().map(|line| format!("{blanks}{line}\n")).collect()
}

/// As much of the text as has room, with points where some was left out.
#[must_use]
pub fn cut(text: &str, room: usize) -> String {
    if text.width() <= room {
        return text.to_owned();
    }
    let mut kept = String::new();
    for letter in text.chars() {
        if kept.width() + letter.to_string().width() + 3 > room {
            break;
        }
        kept.push(letter);
    }
    kept.trim_end().to_owned() + "..."
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_to_the_width_under_wide_letters() {
        assert_eq!(lines("a bb ccc dddddddd e", 5), ["a bb", "ccc", "dddddddd", "e"]);
        assert_eq!(lines("at 10 %), 5 ms", 6), ["at", "10 %),", "5 ms"]);
        assert_eq!(lines("起動 停止 x", 9), ["起動 停止", "x"]);
        assert_eq!(paragraph(2, "a bb ccc", 7), "  a bb\n  ccc\n");
        assert_eq!(cut("MOV K1 D100", 11), "MOV K1 D100");
        assert_eq!(cut("MOV K1 D100", 10), "MOV K1...");
        assert_eq!(cut("起動停止", 7), "起動...");
    }
}

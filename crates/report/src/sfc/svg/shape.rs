//! Pieces of a picture: lines, boxes and texts around the line that flow takes through them.

use std::fmt::Write;
use unicode_width::UnicodeWidthChar;

/// How wide a letter of the picture is taken to be, in tenths of pixels. Fonts differ, so it is rather too much.
fn letter(c: char) -> i32 {
    match c {
        'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | '(' | ')' | '['
        | ']' => 45,
        'm' | 'w' | 'M' | 'W' | '@' | '%' | '#' | '=' | '<' | '>' | '+' => 102,
        ' ' | 'f' | 't' | 'r' | '/' | '-' => 52,
        'A'..='Z' | '_' | '&' => 86,
        c if c.width() == Some(2) => 125,
        _ => 78,
    }
}

/// How wide a text is taken to be, in pixels.
pub(super) fn wide(text: &str) -> i32 {
    let sum = text.chars().map(letter).fold(0, i32::saturating_add);
    sum.saturating_add(9) / 10
}

/// The beginning of a text that is at most so wide, with an ellipsis where it is cut.
pub(super) fn cut(text: &str, width: i32) -> String {
    if wide(text) <= width {
        return text.to_owned();
    }
    let mut room = width.saturating_sub(12).saturating_mul(10);
    let fits = |c: &char| {
        room = room.saturating_sub(letter(*c));
        room >= 0
    };
    let kept: String = text.chars().take_while(fits).collect();
    kept.trim_end().to_owned() + "\u{2026}"
}

/// The text as XML has it.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// What is drawn.
#[derive(Debug, Clone)]
pub(super) enum What {
    /// A line to a place that is so far away, of this class.
    Line(i32, i32, &'static str),
    /// A box of this size and class.
    Rect(i32, i32, &'static str),
    /// A text that begins here, and all of it where it is cut.
    Text(String, Option<String>, &'static str),
    /// The head of an arrow that points down to here.
    Head,
    /// A step: how wide its box is, and how far to the right and down its blocks reach. The place is in the midst of
    /// its upper edge.
    Step(usize, i32, i32, i32),
}

/// The height of a step's box.
pub(super) const STEP: i32 = 30;
/// The space between branches.
const GAP: i32 = 24;

/// A piece of the picture. Flow enters it at 0, 0 and leaves it below.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    /// How far it extends to the left of the line of flow.
    pub left: i32,
    /// How far to the right.
    pub right: i32,
    /// How high it is.
    pub height: i32,
    /// What is drawn, each from its place.
    pub items: Vec<(i32, i32, What)>,
}

impl Shape {
    pub fn line(&mut self, from: (i32, i32), to: (i32, i32), class: &'static str) {
        let (left, right) = (from.0.min(to.0), from.0.max(to.0));
        self.reach(-left, right);
        self.items.push((from.0, from.1, What::Line(to.0 - from.0, to.1 - from.1, class)));
    }

    pub fn rect(&mut self, at: (i32, i32), size: (i32, i32), class: &'static str) {
        self.reach(-at.0, at.0 + size.0);
        self.items.push((at.0, at.1, What::Rect(size.0, size.1, class)));
    }

    /// A text that is cut where it is wider than that.
    pub fn text(&mut self, at: (i32, i32), text: &str, most: i32, class: &'static str) {
        let shown = cut(text, most);
        self.reach(0, at.0 + wide(&shown) + 4);
        let whole = (shown != text).then(|| text.to_owned());
        self.items.push((at.0, at.1, What::Text(shown, whole, class)));
    }

    /// Two lines side by side, where parallel branches begin or end.
    pub fn double(&mut self, from: i32, to: i32, y: i32) {
        self.line((from, y), (to, y), "");
        self.line((from, y + 4), (to, y + 4), "");
    }

    /// The line of flow goes on for so long.
    pub fn down(&mut self, by: i32) {
        if by > 0 {
            self.line((0, self.height), (0, self.height + by), "");
        }
        self.height += by;
    }

    /// Makes room.
    pub fn reach(&mut self, left: i32, right: i32) {
        self.left = self.left.max(left);
        self.right = self.right.max(right);
    }

    /// Puts another piece at a place.
    pub fn put(&mut self, (x, y): (i32, i32), other: Shape) {
        self.reach(other.left - x, other.right + x);
        self.items.extend(other.items.into_iter().map(|(dx, dy, what)| (x + dx, y + dy, what)));
    }

    /// Puts another piece behind what is there.
    pub fn add(&mut self, other: Shape) {
        let height = other.height;
        self.put((0, self.height), other);
        self.height += height;
    }

    /// Puts pieces beside each other, the first on the line of flow; where the line of each is, and how high they are.
    pub fn beside(&mut self, all: Vec<Shape>, y: i32) -> (Vec<i32>, i32) {
        let (mut places, mut height) = (Vec::new(), 0);
        let mut edge = None;
        for one in all {
            let x = edge.map_or(0, |edge: i32| edge + GAP + one.left);
            edge = Some(x + one.right);
            height = height.max(one.height);
            places.push(x);
            self.put((x, y), one);
        }
        (places, height)
    }

    /// Writes what is drawn, moved by so much.
    pub fn write(&self, (x, y): (i32, i32), into: &mut String) {
        for (left, top, what) in &self.items {
            let (x, y) = (x + left, y + top);
            let _ = match what {
                What::Line(dx, dy, class) => {
                    writeln!(into, "<path{} d=\"M{x} {y}l{dx} {dy}\"/>", classed(class))
                }
                What::Rect(width, height, class) => writeln!(
                    into,
                    "<rect{} x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>",
                    classed(class)
                ),
                What::Text(text, whole, class) => {
                    let title =
                        whole.as_ref().map(|all| format!("<title>{}</title>", escaped(all)));
                    writeln!(
                        into,
                        "<text{} x=\"{x}\" y=\"{y}\">{}{}</text>",
                        classed(class),
                        title.unwrap_or_default(),
                        escaped(text)
                    )
                }
                What::Head => {
                    writeln!(into, "<path class=\"head\" d=\"M{x} {y}l-5 -9h10z\"/>")
                }
                What::Step(..) => Ok(()),
            };
        }
    }
}

fn classed(class: &str) -> String {
    if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_to_a_width_with_an_ellipsis() {
        assert_eq!(cut("start", 100), "start");
        let short = cut("a AND b AND c AND d", 60);
        assert!(short.ends_with('\u{2026}') && wide(&short) <= 70, "{short}");
        assert!(wide("\u{6b21}\u{306e}\u{5de5}\u{7a0b}") >= 48, "as wide as they are high");
    }

    #[test]
    fn pieces_beside_each_other_do_not_overlap() {
        let one = |left, right| Shape { left, right, height: 10, items: Vec::new() };
        let mut all = Shape::default();
        let (places, height) = all.beside(vec![one(5, 20), one(30, 7), one(1, 1)], 0);
        assert_eq!((places, height), (vec![0, 20 + GAP + 30, 20 + GAP + 37 + GAP + 1], 10));
    }
}

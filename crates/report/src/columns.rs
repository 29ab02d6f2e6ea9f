//! Text in columns, right under wide characters and colour codes.

use super::wrap;
use anstyle::Style;
use unicode_width::UnicodeWidthStr;

/// One field of a row.
#[derive(Debug, Clone)]
pub struct Cell {
    text: String,
    style: Style,
    right: bool,
}

/// A field set flush left.
pub fn left(text: impl Into<String>) -> Cell {
    Cell { text: text.into(), style: Style::new(), right: false }
}

/// A field set flush right.
pub fn right(text: impl Into<String>) -> Cell {
    Cell { right: true, ..left(text) }
}

impl Cell {
    /// The same in a style.
    #[must_use]
    pub fn styled(mut self, style: Style) -> Cell {
        self.style = style;
        self
    }
}

/// Room that the last field of a row has at least, before it moves to a line of its own.
const LEAST: usize = 24;

/// The rows with their columns aligned, two blanks between, each row indented and on a line of its own.
/// The last field of a row stretches no column.
#[must_use]
pub fn columns(indent: usize, rows: &[Vec<Cell>]) -> String {
    fitted(indent, rows, usize::MAX)
}

/// The same on a page of this width: the last field of a row goes on below itself, or where it has no room below its
/// row.
#[must_use]
pub fn fitted(indent: usize, rows: &[Vec<Cell>], width: usize) -> String {
    let mut widths: Vec<usize> = Vec::new();
    for row in rows {
        for (column, cell) in row.iter().enumerate() {
            if column == widths.len() {
                widths.push(0);
            }
            if column + 1 < row.len() || cell.right {
                widths[column] = widths[column].max(cell.text.width());
            }
        }
    }
    let mut text = String::new();
    for row in rows {
        let mut line = " ".repeat(indent);
        let mut used = indent;
        for (column, cell) in row.iter().enumerate() {
            let wide = widths[column].max(cell.text.width());
            let last = column + 1 == row.len();
            if last && !cell.right && used + cell.text.width() > width {
                let (below, room) = match width.saturating_sub(used) {
                    room if room >= LEAST => (used, room),
                    _ => {
                        text.push_str(line.trim_end());
                        text.push('\n');
                        line = " ".repeat(indent + 4);
                        (indent + 4, width.saturating_sub(indent + 4))
                    }
                };
                let lines = wrap::lines(&cell.text, room);
                let lines: Vec<String> = lines.iter().map(|one| paint(cell.style, one)).collect();
                line.push_str(&lines.join(&format!("\n{}", " ".repeat(below))));
                continue;
            }
            let blanks = " ".repeat(wide - cell.text.width());
            if cell.right {
                line.push_str(&blanks);
            }
            line.push_str(&paint(cell.style, &cell.text));
            if !last {
                line.push_str(if cell.right { "" } else { &blanks });
                line.push_str("  ");
                used += wide + 2;
            }
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// The text in a style; plain text has no codes.
#[must_use]
pub fn paint(style: Style, text: &str) -> String {
    if style == Style::new() || text.is_empty() {
        return text.to_owned();
    }
    format!("{style}{text}{style:#}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_hold_under_wide_characters_and_colours() {
        let bold = Style::new().bold();
        let rows = vec![
            vec![left("起動").styled(bold), right("1"), left("x")],
            vec![left("stop"), right("100"), left("a long last field")],
            vec![left("a"), right("")],
        ];
        let text = anstream::adapter::strip_str(&columns(1, &rows)).to_string();
        assert_eq!(text, " 起動    1  x\n stop  100  a long last field\n a\n");
    }

    #[test]
    fn a_long_last_field_goes_on_below_itself_or_below_its_row() {
        let rows = vec![vec![left("state"), left("the counts that nobody knows, one by one")]];
        let below = " state  the counts that nobody\n        knows, one by one\n";
        assert_eq!(fitted(1, &rows, 32), below);
        let under = " state\n     the counts that nobody\n     knows, one by one\n";
        assert_eq!(fitted(1, &rows, 28), under);
    }
}

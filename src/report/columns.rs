//! Text in columns, right under wide characters and colour codes.

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

/// The rows with their columns aligned, two blanks between, each row indented and on a line of its own.
/// The last field of a row stretches no column.
#[must_use]
pub fn columns(indent: usize, rows: &[Vec<Cell>]) -> String {
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
        for (column, cell) in row.iter().enumerate() {
            let blanks = " ".repeat(widths[column].saturating_sub(cell.text.width()));
            let last = column + 1 == row.len();
            if cell.right {
                line.push_str(&blanks);
            }
            line.push_str(&paint(cell.style, &cell.text));
            if !cell.right && !last {
                line.push_str(&blanks);
            }
            if !last {
                line.push_str("  ");
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
}

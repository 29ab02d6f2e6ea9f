//! A rung drawn in text: contacts in series and in parallel, coils at the right.

use scanbound_ir::ladder::{Drawing, Path, Rung, Symbol};
use std::collections::BTreeMap;
use unicode_width::UnicodeWidthStr;

/// A cell of the drawing has at least so many columns.
const NARROWEST: usize = 9;
/// A contact's label is cut to so many columns.
const WIDEST: usize = 22;

/// Draws a rung in lines. `label` says what stands above an element's symbol, or in its box; of a box the whole text.
#[must_use]
pub fn draw(rung: &Rung, label: &dyn Fn(usize) -> String) -> String {
    let labels: Vec<String> = (0..rung.elements.len()).map(label).collect();
    let is_box =
        |element: usize| matches!(rung.elements[element].symbol, Symbol::Box | Symbol::Condition);
    let wide = |(element, label): (usize, &String)| match is_box(element) {
        true => 0,
        false => label.width().min(WIDEST) + 2,
    };
    let width = labels.iter().enumerate().map(wide).max().unwrap_or(0).max(NARROWEST);
    let mut sheet = Sheet { rung, labels, width, cells: BTreeMap::new(), texts: Vec::new() };
    let rails: Vec<usize> =
        (0..rung.paths.len()).filter(|&path| sheet.path(path).from.is_none()).collect();
    let right = rails.iter().map(|&path| sheet.reach(path, 0)).max().unwrap_or(0);
    let mut row = 0;
    for path in rails {
        row += sheet.put_path(path, 0, row, right);
    }
    sheet.text()
}

/// Directions in which a wire leaves a place.
const EAST: u8 = 1;
const SOUTH: u8 = 2;
const WEST: u8 = 4;
const NORTH: u8 = 8;

/// The left rail stands in the first column.
const RAIL: usize = 1;

struct Sheet<'a> {
    rung: &'a Rung,
    labels: Vec<String>,
    /// Columns of a cell.
    width: usize,
    /// Wires, by line and column.
    cells: BTreeMap<(usize, usize), u8>,
    /// Texts over them: line, column.
    texts: Vec<(usize, usize, String)>,
}

impl<'a> Sheet<'a> {
    fn path(&self, path: usize) -> &'a Path {
        &self.rung.paths[path]
    }

    fn children(&self, path: usize) -> Vec<usize> {
        (0..self.rung.paths.len()).filter(|&other| self.path(other).from == Some(path)).collect()
    }

    /// How many cells an element takes.
    fn cells_of(&self, element: usize) -> usize {
        match self.rung.elements[element].symbol {
            Symbol::Box | Symbol::Condition => {
                (self.labels[element].width() + 5).div_ceil(self.width)
            }
            _ => 1,
        }
    }

    /// Cells across and down.
    fn size(&self, drawing: &Drawing) -> (usize, usize) {
        match drawing {
            Drawing::One(element) => (self.cells_of(*element), 1),
            Drawing::Series(all) => all.iter().fold((0, 1), |(across, down), one| {
                let (more, high) = self.size(one);
                (across + more, down.max(high))
            }),
            Drawing::Parallel(all) => all.iter().fold((0, 0), |(across, down), one| {
                let (wide, more) = self.size(one);
                (across.max(wide), down + more)
            }),
        }
    }

    /// The column of cells in which the last of a path and of those behind it ends.
    fn reach(&self, path: usize, from: usize) -> usize {
        let end = from + self.size(&self.path(path).conditions).0;
        self.children(path)
            .iter()
            .map(|&child| self.reach(child, end))
            .max()
            .unwrap_or(end)
            .max(end)
    }

    /// Puts a path and all behind it; how many rows they take.
    fn put_path(&mut self, path: usize, column: usize, row: usize, right: usize) -> usize {
        let Path { conditions, driven, .. } = self.path(path);
        let (across, down) = self.size(conditions);
        self.put(conditions, column, row);
        let end = column + across;
        let mut rows = 0;
        let mut last = row;
        for &element in driven {
            last = row + rows;
            self.wire(last, end, right);
            self.put_driven(element, right, last);
            rows += 1;
        }
        for child in self.children(path) {
            last = row + rows;
            rows += self.put_path(child, end, last, right);
        }
        self.fall(end, row, last);
        down.max(rows)
    }

    fn put(&mut self, drawing: &Drawing, column: usize, row: usize) {
        match drawing {
            Drawing::One(element) => self.put_one(*element, column, row),
            Drawing::Series(all) => {
                let mut column = column;
                for one in all {
                    self.put(one, column, row);
                    column += self.size(one).0;
                }
            }
            Drawing::Parallel(all) => {
                let across = self.size(drawing).0;
                let (mut at, mut last) = (row, row);
                for one in all {
                    self.put(one, column, at);
                    let (wide, down) = self.size(one);
                    self.wire(at, column + wide, column + across);
                    last = at;
                    at += down;
                }
                self.fall(column, row, last);
                self.fall(column + across, row, last);
            }
        }
    }

    fn column(&self, cell: usize) -> usize {
        RAIL + cell * self.width
    }

    fn put_one(&mut self, element: usize, column: usize, row: usize) {
        let cells = self.cells_of(element);
        self.wire(row, column, column + cells);
        let (from, to) = (self.column(column), self.column(column + cells));
        let (line, label) = (Sheet::line(row), self.labels[element].clone());
        let symbol = match self.rung.elements[element].symbol {
            Symbol::Contact => "┤ ├",
            Symbol::Negated => "┤/├",
            _ => {
                self.texts.push((line, from + 2, format!("[ {label} ]")));
                return;
            }
        };
        let middle = (from + to) / 2;
        let label = cut(&label);
        self.texts.push((line - 1, middle.saturating_sub(label.width() / 2).max(from + 1), label));
        self.texts.push((line, middle - 1, symbol.to_owned()));
    }

    fn put_driven(&mut self, element: usize, column: usize, row: usize) {
        let (line, at) = (Sheet::line(row), self.column(column));
        let label = self.labels[element].clone();
        let symbol = match self.rung.elements[element].symbol {
            Symbol::Coil => format!("─( )  {label}"),
            Symbol::Set => format!("─(S)  {label}"),
            Symbol::Reset => format!("─(R)  {label}"),
            _ => format!("─[ {label} ]"),
        };
        self.texts.push((line, at + 1, symbol));
        self.join(line, at, EAST | WEST);
    }

    fn line(row: usize) -> usize {
        2 * row + 1
    }

    fn join(&mut self, line: usize, column: usize, ways: u8) {
        *self.cells.entry((line, column)).or_default() |= ways;
    }

    /// A wire in a row from one column of cells to another.
    fn wire(&mut self, row: usize, from: usize, to: usize) {
        let (line, from, to) = (Sheet::line(row), self.column(from), self.column(to));
        for column in from..to {
            self.join(line, column, EAST);
            self.join(line, column + 1, WEST);
        }
    }

    /// A wire down, left of a column of cells.
    fn fall(&mut self, column: usize, from: usize, to: usize) {
        let column = self.column(column);
        for line in Sheet::line(from)..Sheet::line(to) {
            self.join(line, column, SOUTH);
            self.join(line + 1, column, NORTH);
        }
    }

    fn text(mut self) -> String {
        let last = self.cells.keys().map(|&(line, _)| line).max().unwrap_or(1);
        for line in 0..=last {
            self.join(line, RAIL, if line == 0 { SOUTH } else { SOUTH | NORTH });
        }
        let mut text = String::new();
        for line in 0..=last {
            let mut texts: Vec<&(usize, usize, String)> =
                self.texts.iter().filter(|(at, ..)| *at == line).collect();
            texts.sort_by_key(|(_, column, _)| *column);
            let end =
                self.cells.range((line, 0)..(line + 1, 0)).next_back().map_or(0, |(&(_, c), _)| c);
            let (mut column, mut own) = (0, String::new());
            let mut texts = texts.into_iter().peekable();
            while column <= end || texts.peek().is_some() {
                if let Some((_, _, told)) = texts.next_if(|(_, at, _)| *at <= column) {
                    own += told;
                    column += told.width();
                    continue;
                }
                own.push(wire(self.cells.get(&(line, column)).copied().unwrap_or(0)));
                column += 1;
            }
            text += own.trim_end();
            text.push('\n');
        }
        text
    }
}

fn cut(label: &str) -> String {
    let mut short = String::new();
    for letter in label.chars() {
        if short.width() >= WIDEST {
            return short + "…";
        }
        short.push(letter);
    }
    short
}

fn wire(ways: u8) -> char {
    const SIGNS: [char; 16] =
        [' ', '─', '│', '┌', '─', '─', '┐', '┬', '│', '└', '│', '├', '┘', '┴', '┤', '┼'];
    SIGNS[usize::from(ways & 15)]
}

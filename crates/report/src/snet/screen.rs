//! A page of a net on a terminal.

use super::View;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use scanbound_snet::picture::{Drawn, HALF, Line, Node, Sheet, Spot, gate_text, label};
use scanbound_snet::{Diagram, Direction, Kind, Signal};
use std::collections::BTreeMap;
use unicode_width::UnicodeWidthChar;

/// What is on, lit, or marked.
fn on() -> Style {
    Style::new().fg(Color::Green).add_modifier(Modifier::BOLD)
}

fn lit() -> Style {
    Style::new().fg(Color::Yellow).add_modifier(Modifier::BOLD)
}

fn off() -> Style {
    Style::new().add_modifier(Modifier::DIM)
}

/// Draws on a part of a buffer, whose upper left corner shows the sheet's spot `from`.
struct Painter<'a> {
    buffer: &'a mut Buffer,
    area: Rect,
    from: Spot,
    /// What everything is drawn with that is not drawn otherwise.
    base: Style,
}

impl Painter<'_> {
    fn put(&mut self, x: i32, y: i32, one: char, style: Style) {
        let (Ok(column), Ok(row)) =
            (u16::try_from(x - self.from.x), u16::try_from(y - self.from.y))
        else {
            return;
        };
        let width = u16::try_from(one.width().unwrap_or(1)).unwrap_or(1);
        if column + width <= self.area.width && row < self.area.height {
            let (column, row) = (self.area.x + column, self.area.y + row);
            if let Some(cell) = self.buffer.cell_mut((column, row)) {
                cell.set_char(one).set_style(self.base.patch(style));
            }
        }
    }

    fn text(&mut self, mut x: i32, y: i32, text: &str, style: Style) {
        for one in text.chars() {
            self.put(x, y, one, style);
            x += i32::try_from(one.width().unwrap_or(0)).unwrap_or(0);
        }
    }
}

/// Draws a page. `from` is the sheet's spot in the upper left corner.
pub fn draw(
    buffer: &mut Buffer,
    area: Rect,
    diagram: &Diagram,
    sheet: &Sheet,
    view: &View,
    from: Spot,
) {
    let base = if view.is_old { off() } else { Style::new() };
    let mut painter = Painter { buffer, area, from, base };
    lines(&mut painter, diagram, sheet);
    for one in &sheet.nodes {
        match one.node {
            Node::Place(at) => place(&mut painter, diagram, one, at, view),
            Node::Transition(at) => transition(&mut painter, diagram, one, at, view),
        }
    }
}

const UP: u8 = 1;
const RIGHT: u8 = 2;
const DOWN: u8 = 4;
const LEFT: u8 = 8;

/// The character of a line that leads to these sides.
fn joined(sides: u8) -> char {
    const ALL: [char; 16] =
        [' ', '│', '─', '└', '│', '│', '┌', '├', '─', '┘', '─', '┴', '┐', '┤', '┬', '┼'];
    ALL[usize::from(sides & 15)]
}

fn lines(painter: &mut Painter<'_>, diagram: &Diagram, sheet: &Sheet) {
    let mut sides: BTreeMap<(i32, i32), u8> = BTreeMap::new();
    let mut heads: Vec<(Spot, char)> = Vec::new();
    for line in &sheet.lines {
        let Some(corners) = whole(diagram, sheet, line) else { continue };
        for pair in corners.windows(2) {
            let (mut at, to) = (pair[0], pair[1]);
            let (dx, dy) = ((to.x - at.x).signum(), (to.y - at.y).signum());
            let (out, back) = match (dx, dy) {
                (1, _) => (RIGHT, LEFT),
                (-1, _) => (LEFT, RIGHT),
                (_, 1) => (DOWN, UP),
                _ => (UP, DOWN),
            };
            while (at.x != to.x && dx != 0) || (at.y != to.y && dy != 0) {
                *sides.entry((at.x, at.y)).or_default() |= out;
                at = Spot { x: at.x + dx, y: at.y + dy };
                *sides.entry((at.x, at.y)).or_default() |= back;
            }
        }
        let is_stop = diagram.arcs[line.arc].direction == Direction::Stop;
        let (Some(&first), Some(&last)) = (corners.first(), corners.last()) else { continue };
        heads.push((last, if comes_from_below(diagram, sheet, line, last) { '▲' } else { '▼' }));
        if is_stop {
            heads.push((first, '*'));
        }
    }
    for ((x, y), sides) in sides {
        painter.put(x, y, joined(sides), Style::new());
    }
    for (spot, head) in heads {
        painter.put(spot.x, spot.y, head, Style::new());
    }
}

/// Whether a line meets what it leads to from below.
fn comes_from_below(diagram: &Diagram, sheet: &Sheet, line: &Line, end: Spot) -> bool {
    let arc = diagram.arcs[line.arc];
    let to = match arc.direction {
        Direction::OutOf => Node::Place(arc.place),
        Direction::Into | Direction::Stop => Node::Transition(arc.transition),
    };
    sheet.nodes.iter().any(|one| one.node == to && end.y > one.at.y)
}

/// The corners of a line with those behind gates that stand below each other.
fn whole(diagram: &Diagram, sheet: &Sheet, line: &Line) -> Option<Vec<Spot>> {
    let transition = diagram.arcs[line.arc].transition;
    let one = sheet.nodes.iter().find(|one| one.node == Node::Transition(transition))?;
    let below = one.at.y + one.rows;
    let mut corners = line.corners.clone();
    let is_out = diagram.arcs[line.arc].direction == Direction::OutOf;
    let end = if is_out { corners.first() } else { corners.last() };
    if let Some(end) = end.filter(|end| end.y == below && one.rows > 1) {
        let lifted = Spot { x: end.x, y: one.at.y + 1 };
        if is_out {
            corners.insert(0, lifted);
        } else {
            corners.push(lifted);
        }
    }
    // A line of one row still has an arrow.
    if let [only] = corners[..] {
        corners.push(only);
    }
    Some(corners)
}

fn place(painter: &mut Painter<'_>, diagram: &Diagram, one: &Drawn, at: usize, view: &View) {
    let Spot { x, y } = one.at;
    let kind = diagram.places[at].kind;
    let shown = view.places.get(at);
    let marked = shown.and_then(|shown| shown.is_marked);
    let over = shown.is_some_and(|shown| shown.is_over);
    let style = if marked == Some(true) { on() } else { Style::new() };
    let (top, bottom) = match kind {
        Kind::Box => ("┌───┐", "└───┘"),
        Kind::Timer { .. } => ("┌───┐", "└─P─┘"),
        Kind::Counter { .. } => ("╭─c─╮", "└───┘"),
    };
    let mark = match marked {
        Some(true) => "│ ● │",
        Some(false) => "│   │",
        None => "│ ? │",
    };
    let guest = if one.is_guest { off() } else { style };
    for (row, text) in (0..).zip([top, mark, bottom]) {
        painter.text(x - HALF, y + row, text, guest);
    }
    if over && matches!(kind, Kind::Timer { .. }) {
        painter.put(x, y + 2, 'P', lit());
    }
    let mut beside = label(diagram, one.node, one.is_guest);
    if let (Some(standing), Some(second)) =
        (shown.and_then(|shown| shown.standing.clone()), beside.get_mut(1))
    {
        *second = standing;
    }
    for (row, text) in (1..).zip(&beside) {
        painter.text(x + HALF + 2, y + row, text, style);
    }
}

fn transition(painter: &mut Painter<'_>, diagram: &Diagram, one: &Drawn, at: usize, view: &View) {
    let Spot { x, y } = one.at;
    let own = &diagram.transitions[at];
    let style = if view.lit.get(at) == Some(&true) { lit() } else { Style::new() };
    painter.text(x - HALF, y, if own.is_stop { "═════" } else { "━━━━━" }, style);
    let mut name = label(diagram, one.node, one.is_guest).concat();
    for arbiter in &diagram.arbiters {
        if let Some(turn) = arbiter.transitions.iter().position(|other| *other == at) {
            name += &format!(" ({}:{})", arbiter.head.name, turn + 1);
        }
    }
    painter.text(x + HALF + 2, y, &name, style);
    let gates: Vec<_> = diagram.gates_of(at).collect();
    for (row, gate) in (0..).zip(&gates) {
        let (is_first, is_last) = (row == 0, row as usize + 1 == gates.len());
        let join = match (is_first, is_last) {
            (true, true) => '─',
            (true, false) => '┬',
            (false, false) => '┤',
            (false, true) => '┘',
        };
        let value = match gate.signal {
            Signal::Outer(outer) => view.outers.get(outer).copied().flatten(),
            Signal::Place(place) => view.places.get(place).and_then(|shown| {
                let timer = matches!(diagram.places[place].kind, Kind::Timer { .. });
                shown.is_marked.map(|marked| if timer { shown.is_over } else { marked })
            }),
        };
        let style = match value {
            Some(true) => on(),
            Some(false) => off(),
            None => Style::new(),
        };
        let text = gate_text(diagram, gate.signal);
        let width: usize = text.chars().filter_map(UnicodeWidthChar::width).sum();
        let left = x - HALF - 2 - i32::try_from(width).unwrap_or(0);
        painter.text(left, y + row, &text, style);
        painter.put(x - HALF - 2, y + row, if gate.is_inhibiting { '○' } else { '●' }, style);
        painter.put(x - HALF - 1, y + row, join, Style::new());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_snet::picture::sheets;
    use scanbound_snet::text::read;

    /// A page as text, its trailing blanks left out.
    fn shown(text: &str, from: Spot, size: (u16, u16)) -> String {
        let diagram = read("a.snet", text).expect("a net");
        let sheets = sheets(&diagram);
        let area = Rect::new(0, 0, size.0, size.1);
        let mut buffer = Buffer::empty(area);
        draw(&mut buffer, area, &diagram, &sheets[0], &View::initial(&diagram), from);
        let rows = (0..size.1).map(|y| {
            let row: String = (0..size.0).map(|x| buffer[(x, y)].symbol()).collect();
            row.trim_end().to_owned() + "\n"
        });
        rows.collect::<String>().trim_end().to_owned()
    }

    const NET: &str = "outer E01\nouter 停止\nbox A marked\ntimer W 2.5s\n\
                       transition T1 : A -> W if E01 not 停止\nstop T00 : W *-> if 停止\ntransition T2 : W -> A\n";

    #[test]
    fn a_net_is_drawn_with_its_symbols() {
        insta::assert_snapshot!(shown(NET, Spot { x: 0, y: 0 }, (60, 30)));
    }

    #[test]
    fn what_lies_beyond_the_window_is_left_out() {
        let whole = shown(NET, Spot { x: 0, y: 0 }, (60, 30));
        let part = shown(NET, Spot { x: 0, y: 3 }, (60, 4));
        let lines: Vec<&str> = whole.lines().skip(3).take(4).collect();
        assert_eq!(part, lines.join("\n"));
        assert_eq!(shown(NET, Spot { x: 500, y: 0 }, (20, 20)), "");
    }
}

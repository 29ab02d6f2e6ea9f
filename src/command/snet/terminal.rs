//! Shows a net on the whole terminal: its pages, the visible part, and a line of text below.

use ratatui::buffer::Buffer;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Paragraph, Widget, Wrap};
use scanbound::report::snet::{View, screen};
use scanbound::snet::Diagram;
use scanbound::snet::picture::{Sheet, Spot, sheets};
use std::io;
use std::time::Duration;

/// A net's pages, and which one is shown.
pub struct Pages<'a> {
    diagram: &'a Diagram,
    sheets: Vec<Sheet>,
    page: usize,
    from: Spot,
}

/// A key that does not concern the pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pressed {
    /// The end.
    Quit,
    /// A letter or another sign.
    Key(char),
    /// Backspace.
    Back,
    /// Any other key.
    Other,
}

impl<'a> Pages<'a> {
    /// The pages of a net. The first one is shown.
    pub fn new(diagram: &'a Diagram) -> Pages<'a> {
        Pages { diagram, sheets: sheets(diagram), page: 0, from: Spot { x: 0, y: 0 } }
    }

    /// Waits for a key for at most this time. Keys for moving the picture are handled here.
    pub fn pressed(&mut self, patience: Duration) -> io::Result<Option<Pressed>> {
        if !event::poll(patience)? {
            return Ok(None);
        }
        let Event::Key(key) = event::read()? else { return Ok(Some(Pressed::Other)) };
        if key.kind == KeyEventKind::Release {
            return Ok(Some(Pressed::Other));
        }
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        Ok(Some(self.key(key.code, control)))
    }

    /// Handles a key: moves the picture or turns the page, and returns what else the key means; `Other` if nothing.
    pub fn key(&mut self, code: KeyCode, control: bool) -> Pressed {
        let step = |from: i32, by: i32, most: i32| (from + by).clamp(0, most.max(0));
        let size = self.sheets.get(self.page).map_or(Spot { x: 0, y: 0 }, |sheet| sheet.size);
        match code {
            KeyCode::Char('c') if control => return Pressed::Quit,
            KeyCode::Char('q') | KeyCode::Esc => return Pressed::Quit,
            KeyCode::Char(one) => return Pressed::Key(one),
            KeyCode::Enter => return Pressed::Key('\n'),
            KeyCode::Backspace => return Pressed::Back,
            KeyCode::Up => self.from.y = step(self.from.y, -2, size.y - 3),
            KeyCode::Down => self.from.y = step(self.from.y, 2, size.y - 3),
            KeyCode::Left => self.from.x = step(self.from.x, -4, size.x - 8),
            KeyCode::Right => self.from.x = step(self.from.x, 4, size.x - 8),
            KeyCode::PageUp | KeyCode::BackTab => self.turn(self.sheets.len() - 1),
            KeyCode::PageDown | KeyCode::Tab => self.turn(1),
            _ => {}
        }
        Pressed::Other
    }

    fn turn(&mut self, by: usize) {
        self.page = (self.page + by) % self.sheets.len().max(1);
        self.from = Spot { x: 0, y: 0 };
    }

    /// Draws the current page with a heading above and text below.
    pub fn draw(&self, buffer: &mut Buffer, area: Rect, view: &View, head: &str, words: &[String]) {
        let below = u16::try_from(words.len()).unwrap_or(1);
        let rows = [Constraint::Length(1), Constraint::Min(3), Constraint::Length(below)];
        let [top, middle, bottom] = Layout::vertical(rows).areas(area);
        let Some(sheet) = self.sheets.get(self.page) else { return };
        let page = &self.diagram.pages[sheet.page].name;
        let place = match self.sheets.len() {
            1 => page.clone(),
            count => format!("{page} ({} of {count})", self.page + 1),
        };
        let bold = Style::new().add_modifier(Modifier::BOLD);
        Line::styled(format!("{place}  {head}"), bold).render(top, buffer);
        screen::draw(buffer, middle, self.diagram, sheet, view, self.from);
        let words = words.iter().map(|line| Line::raw(line.clone())).collect::<Vec<_>>();
        Paragraph::new(words).wrap(Wrap { trim: false }).render(bottom, buffer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use scanbound::snet::text::read;

    const NET: &str = "net Two\npage P\nbox A marked\ntransition T : A -> Q.B\npage Q\nbox B\n\
                       transition U : B -> P.A\n";

    /// The screen as text.
    fn shown(pages: &Pages<'_>, view: &View) -> String {
        let mut terminal = Terminal::new(TestBackend::new(40, 16)).expect("a terminal");
        let words = ["words".to_owned()];
        let draw = |frame: &mut ratatui::Frame<'_>| {
            let area = frame.area();
            pages.draw(frame.buffer_mut(), area, view, "head", &words);
        };
        terminal.draw(draw).expect("drawn");
        terminal.backend().to_string()
    }

    #[test]
    fn pages_are_turned_and_moved() {
        let diagram = read("a.snet", NET).expect("a net");
        let mut pages = Pages::new(&diagram);
        let view = View::initial(&diagram);
        let first = shown(&pages, &view);
        assert!(first.contains("P (1 of 2)  head") && first.contains("│ ● │ A"), "{first}");
        assert!(first.contains("Q.B") && first.contains("words"), "{first}");
        assert_eq!(pages.key(KeyCode::Tab, false), Pressed::Other);
        let second = shown(&pages, &view);
        assert!(second.contains("Q (2 of 2)") && second.contains("│   │ B"), "{second}");
        pages.key(KeyCode::Tab, false);
        assert_eq!(shown(&pages, &view), first);
        for _ in 0..50 {
            pages.key(KeyCode::Down, false);
        }
        assert_ne!(shown(&pages, &view), first);
        for _ in 0..50 {
            pages.key(KeyCode::Up, false);
        }
        assert_eq!(shown(&pages, &view), first);
        assert_eq!(pages.key(KeyCode::Char('c'), true), Pressed::Quit);
        assert_eq!(pages.key(KeyCode::Char('s'), false), Pressed::Key('s'));
    }
}

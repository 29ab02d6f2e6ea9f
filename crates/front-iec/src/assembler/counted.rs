//! Which instructions a statement becomes (`docs/sfc.md` says what counts as one).

use super::Assembler;
use super::tally::Current;
use scanbound_base::location::Location;

/// A statement that is put together.
pub(crate) enum Counted {
    /// It counts: its place among the ranges.
    Begun { at: usize, covers: bool },
    /// It only keeps a value for the next one.
    Kept,
    /// It is a part of another.
    Part,
}

impl Assembler {
    /// What is put together from here on is the body of this number; gives what to go back to. `keeps`: whether it is
    /// drawn or a list, so that values are kept between statements.
    pub(crate) fn enter_body(&mut self, known: Option<usize>, keeps: bool) -> Option<Current> {
        let current = known.map(|known| {
            self.program().statements.bodies[known].is_called = true;
            Current { body: known, next: 0, keeps, kept_from: None, is_within: false }
        });
        std::mem::replace(&mut self.tally.current, current)
    }

    /// What is put together from here on is not counted; gives what to go back to.
    pub(crate) fn leave_out(&mut self) -> Option<Current> {
        self.tally.current.take()
    }

    /// Goes back to the body around.
    pub(crate) fn leave(&mut self, before: Option<Current>) {
        // A value that nothing takes is a statement of its own.
        if let Some((from, line)) = self.tally.current.and_then(|current| current.kept_from) {
            self.counted_part(from, line, "", 1);
        }
        self.tally.current = before;
    }

    /// The statement ends here.
    pub(crate) fn end_statement(&mut self, counted: Counted) {
        let Counted::Begun { at, covers } = counted else { return };
        let end = self.builder.next();
        self.program().statements.ranges[at].0.end = end;
        if let (true, Some(current)) = (covers, self.tally.current.as_mut()) {
            current.is_within = false;
        }
    }

    /// What was put together since then is a part of a chart that stands for so many statements.
    pub(crate) fn counted_part(&mut self, from: usize, line: u32, text: &str, count: usize) {
        if self.tally.current.is_none() || count == 0 {
            return;
        }
        let at = self.range(from, line, text, u32::try_from(count).unwrap_or(u32::MAX));
        let end = self.builder.next();
        self.program().statements.ranges[at].0.end = end;
    }

    /// The next statement of the body, from this instruction on; its place among the ranges.
    pub(crate) fn range(&mut self, from: usize, line: u32, text: &str, count: u32) -> usize {
        let file = u32::try_from(self.file).unwrap_or(u32::MAX);
        let (mut body, mut number) = (0, 0);
        if let Some(current) = self.tally.current.as_mut() {
            (body, number) = (current.body, current.next);
            current.next += 1;
        }
        let found = &mut self.builder.program.statements;
        let statement = *self.tally.known.entry((body, number)).or_insert_with(|| {
            let place = Location { file, line, step: None };
            let text: String = text.chars().take(120).collect();
            found.all.push(scanbound_ir::Statement { body, place, text: text.into(), count });
            found.all.len() - 1
        });
        found.ranges.push((from..from, statement));
        found.ranges.len() - 1
    }
}

//! Records which instructions belong to which statement, for the statement count (`docs/sfc.md` says what counts as one
//! statement).

use super::Assembler;
use super::tally::Current;
use scanbound_base::location::Location;

/// How a statement that is being lowered is counted.
pub(crate) enum Counted {
    /// It counts as a statement: its index among the instruction ranges, and whether it also covers the statements
    /// inside it.
    Begun { at: usize, covers: bool },
    /// It only keeps a value for the next statement.
    Kept,
    /// It is part of another statement.
    Part,
}

impl Assembler {
    /// Starts a body: the statements lowered from here on belong to the body with this index (None: they are not
    /// counted). `keeps`: whether the body is a diagram or an instruction list, so that values are kept between its
    /// statements. Returns the state to pass to [`Assembler::leave`].
    pub(crate) fn enter_body(&mut self, known: Option<usize>, keeps: bool) -> Option<Current> {
        let current = known.map(|known| {
            self.program().statements.bodies[known].is_called = true;
            Current { body: known, next: 0, keeps, kept_from: None, is_within: false }
        });
        std::mem::replace(&mut self.tally.current, current)
    }

    /// Stops counting. Returns the state to pass to [`Assembler::leave`].
    pub(crate) fn leave_out(&mut self) -> Option<Current> {
        self.tally.current.take()
    }

    /// Ends a body and returns to the one around it.
    pub(crate) fn leave(&mut self, before: Option<Current>) {
        // A kept value that no statement uses counts as a statement.
        if let Some((from, line)) = self.tally.current.and_then(|current| current.kept_from) {
            self.counted_part(from, line, "", 1);
        }
        self.tally.current = before;
    }

    /// Ends a statement: it consists of the instructions added since it began.
    pub(crate) fn end_statement(&mut self, counted: Counted) {
        let Counted::Begun { at, covers } = counted else { return };
        let end = self.builder.next();
        self.program().statements.ranges[at].0.end = end;
        if let (true, Some(current)) = (covers, self.tally.current.as_mut()) {
            current.is_within = false;
        }
    }

    /// Counts the instructions from `from` on as a part of a chart (such as a transition) that stands for `count`
    /// statements. Nothing if no body is being counted.
    pub(crate) fn counted_part(&mut self, from: usize, line: u32, text: &str, count: usize) {
        if self.tally.current.is_none() || count == 0 {
            return;
        }
        let at = self.range(from, line, text, u32::try_from(count).unwrap_or(u32::MAX));
        let end = self.builder.next();
        self.program().statements.ranges[at].0.end = end;
    }

    /// Begins the next statement of the current body at instruction `from`. Returns its index among the instruction
    /// ranges.
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

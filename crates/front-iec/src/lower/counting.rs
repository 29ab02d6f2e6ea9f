//! Which instructions a statement becomes (`docs/sfc.md` says what counts as one).

use super::super::assembler::Assembler;
use super::super::tally::Current;
use super::Lower;
use scanbound_iec_tree::declarations::RoutineId;
use scanbound_iec_tree::tree::{Statement, StatementKind};

impl Lower<'_> {
    /// What is lowered from here on is this routine; gives what to go back to.
    pub(super) fn enter_routine(&mut self, id: RoutineId) -> Option<Current> {
        let known = self.counted_body(id);
        self.assembler().enter_body(known, false)
    }
}

impl Assembler {
    /// A statement begins; gives its place among the ranges, if it counts.
    pub(super) fn begin_counted(&mut self, one: &Statement) -> Option<usize> {
        let is_part = self.tally.current.is_none_or(|current| current.is_within);
        if is_part || matches!(one.kind, StatementKind::Label(_)) {
            return None;
        }
        let here = self.builder.next();
        Some(self.range(here, one.line, &one.text, 1))
    }

    /// It ends here.
    pub(super) fn end_counted(&mut self, counted: Option<usize>) {
        let Some(at) = counted else { return };
        let end = self.builder.next();
        self.program().statements.ranges[at].0.end = end;
    }
}

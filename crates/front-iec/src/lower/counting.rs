//! Finds which statements to count while they are lowered (`docs/sfc.md` says what counts as one).

use super::Lower;
use super::bodies::BodyKey;
use crate::assembler::counted::Counted;
use crate::assembler::tally::Current;
use scanbound_iec::Language;
use scanbound_iec_tree::declarations::RoutineId;
use scanbound_iec_tree::tree::{ExprKind, Root, Statement, StatementKind, Target};

impl Lower<'_> {
    /// Starts counting the statements of a routine. Returns the state to pass to
    /// [`Assembler::leave`](crate::assembler::Assembler::leave).
    pub(super) fn enter_routine(&mut self, id: RoutineId) -> Option<Current> {
        self.enter((id, None), self.tree.routine(id).language)
    }

    /// Starts counting the statements of a body, as [`Lower::enter_routine`].
    pub(super) fn enter(&mut self, body: BodyKey, language: Language) -> Option<Current> {
        let known = self.bodies.get(&body).copied();
        self.assembler().enter_body(known, language != Language::St)
    }

    /// Begins counting a statement; `end_statement` ends it.
    pub(super) fn begin_counted(&mut self, one: &Statement) -> Counted {
        let here = self.builder.next();
        let is_kept = self.keeps_a_value(one);
        let Some(current) = self.tally.current.as_mut() else { return Counted::Part };
        let is_part = matches!(one.kind, StatementKind::Label(_) | StatementKind::Either(..));
        if current.is_within || is_part {
            return Counted::Part;
        }
        if is_kept {
            current.kept_from.get_or_insert((here, one.line));
            return Counted::Kept;
        }
        let from = current.kept_from.take().map_or(here, |(from, _)| from);
        // A block with EN in a diagram is lowered as an IF around its call.
        let covers = current.keeps && matches!(one.kind, StatementKind::If(..));
        current.is_within |= covers;
        let at = self.range(from, one.line, &one.text, 1);
        Counted::Begun { at, covers }
    }

    /// Whether a statement only keeps a value for the next one. A block in a diagram, whose result is kept too, is a
    /// statement itself.
    fn keeps_a_value(&self, one: &Statement) -> bool {
        match &one.kind {
            StatementKind::Keep(_, value) => !matches!(
                value.kind,
                ExprKind::Call(_) | ExprKind::Standard(_) | ExprKind::Either(_)
            ),
            // The state of an edge contact in a diagram.
            StatementKind::Call(call) => match &call.target {
                Target::Standard(place, _) | Target::Instance(place, _) => match place.root {
                    Root::Variable(id) => self.tree.variable(id).is_internal,
                    _ => false,
                },
                _ => false,
            },
            StatementKind::CallIf(_, inner) => self.keeps_a_value(inner),
            _ => false,
        }
    }
}

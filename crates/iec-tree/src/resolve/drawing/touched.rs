//! What the statements of a drawing read and write.

use super::super::resolver::Resolver;
use crate::accesses::{Accesses, of_expr, of_statements};
use crate::declarations::{AddressId, TempId, VarId};
use crate::tree::{
    Call, Expr, Place, Root, Statement, StatementKind, Step, StepFlag, Target, Tree,
};
use crate::types::{Kind, Type};
use scanbound_iec::Section;
use scanbound_iec::drawing::ElementId;
use std::collections::BTreeSet;

/// What is read or written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Cell {
    /// A variable, or a part of it.
    Variable(VarId),
    /// A direct address.
    Address(AddressId),
    /// An instance of a program.
    Program(usize),
    /// All that is shared with other units.
    Shared,
    /// Anything: what is jumped over depends on where the jump stands, and a reference may mean any variable.
    All,
}

/// Under what a value is held: what it was made of is known.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Held {
    Temporary(TempId),
    Edge(VarId),
    /// An output that is not stored.
    Output(ElementId, String),
}

/// What a statement or an expression touches.
#[derive(Debug, Default)]
pub(super) struct Touched {
    pub(super) reads: BTreeSet<Cell>,
    pub(super) writes: BTreeSet<Cell>,
    /// What is held that it reads.
    pub(super) held: BTreeSet<Held>,
}

/// Finds what is touched.
struct Walk<'t> {
    tree: &'t Tree,
    found: Touched,
}

impl Walk<'_> {
    /// The cells of a place; none of what is only held.
    fn cells(&self, place: &Place) -> Vec<Cell> {
        let member = match place.steps.first() {
            Some(Step::Member(own)) => Some(Cell::Variable(*own)),
            _ => None,
        };
        let own = match place.root {
            Root::Temporary(_) => return Vec::new(),
            Root::Variable(id) if self.is_edge(id) => return Vec::new(),
            Root::Variable(id) => Cell::Variable(id),
            Root::This => member.unwrap_or(Cell::All),
            Root::Program(number) => member.unwrap_or(Cell::Program(number)),
            Root::Address(id) => Cell::Address(id),
            Root::Target(_) => Cell::All,
        };
        let is_handed = |cell: Cell| match cell {
            Cell::Variable(id) => self.tree.variable(id).section == Section::InOut,
            _ => false,
        };
        let through = match place.steps.iter().any(|step| matches!(step, Step::Dereference)) {
            true => Some(Cell::All),
            // What is handed over in and out may be any variable of the caller's.
            false => is_handed(own).then_some(Cell::Shared),
        };
        std::iter::once(own).chain(through).collect()
    }

    /// Whether a variable is the memory of an edge that is drawn.
    fn is_edge(&self, id: VarId) -> bool {
        let one = self.tree.variable(id);
        one.is_internal && matches!(self.tree.types.get(one.ty), Type::Standard(_))
    }
}

impl Accesses for Walk<'_> {
    fn reads(&mut self, place: &Place) {
        self.found.reads.extend(self.cells(place));
        match place.root {
            Root::Temporary(id) => _ = self.found.held.insert(Held::Temporary(id)),
            Root::Variable(id) if self.is_edge(id) => _ = self.found.held.insert(Held::Edge(id)),
            _ => {}
        }
    }

    fn writes(&mut self, place: &Place) {
        // A part is written, or a bit: the rest stays.
        self.reads(place);
        self.found.writes.extend(self.cells(place));
    }

    fn takes_address(&mut self, place: &Place) {
        self.reads(place);
    }

    fn asks(&mut self, flag: &StepFlag) {
        // The steps of the own chart stay while its actions are executed.
        if flag.owner.root != Root::This || !flag.owner.steps.is_empty() {
            self.reads(&flag.owner);
        }
    }

    fn calls(&mut self, call: &Call) {
        match &call.target {
            Target::Standard(place, _) => return self.writes(place),
            // Code of the own instance may write all that the instance has.
            Target::BaseMethod(_) | Target::BaseBody(_) => _ = self.found.writes.insert(Cell::All),
            Target::Function(_) => {}
            Target::Instance(place, _)
            | Target::Action(place, _)
            | Target::Method(place, _)
            | Target::Program(place, _) => self.writes(place),
        }
        // It may write what is not its own.
        self.found.writes.insert(Cell::Shared);
    }

    fn begins(&mut self, one: &Statement) {
        match &one.kind {
            StatementKind::Case(..)
            | StatementKind::For(_)
            | StatementKind::Foreign(_)
            | StatementKind::While(..)
            | StatementKind::Repeat(..)
            | StatementKind::Exit
            | StatementKind::Continue
            | StatementKind::Return(_)
            | StatementKind::Jump(..)
            | StatementKind::Label(_) => _ = self.found.writes.insert(Cell::All),
            StatementKind::Assign(..)
            | StatementKind::Keep(..)
            | StatementKind::Copy(..)
            | StatementKind::Latch(..)
            | StatementKind::Call(_)
            | StatementKind::Standard(_)
            | StatementKind::CallIf(..)
            | StatementKind::After(_)
            | StatementKind::If(..)
            | StatementKind::Either(..)
            | StatementKind::Nothing
            | StatementKind::Fault(_) => {}
        }
    }
}

/// An address: its area, its size, and its numbers; and whether a variable there is no larger than that.
pub(super) type At<'t> = (Option<char>, &'t str, &'t str, bool);

/// Whether addresses such as `%QX0.1` and `%QW0` may overlap: two of one size are apart unless they are equal, or one
/// of them is that of an array or a structure.
fn overlap(one: &At<'_>, other: &At<'_>) -> bool {
    one.0 == other.0 && (!one.3 || !other.3 || one.1 != other.1 || one.2 == other.2)
}

impl Resolver<'_> {
    /// What statements touch.
    pub(super) fn touched(&self, all: &[Statement]) -> Touched {
        let mut walk = Walk { tree: &self.tree, found: Touched::default() };
        of_statements(all, &mut walk);
        walk.found
    }

    /// What an expression touches.
    pub(super) fn touched_by(&self, one: &Expr) -> Touched {
        let mut walk = Walk { tree: &self.tree, found: Touched::default() };
        of_expr(one, &mut walk);
        walk.found
    }

    /// Whether a statement may change a value.
    pub(super) fn may_change(&self, one: &Touched, value: &Touched) -> bool {
        if one.writes.is_empty() || value.reads.is_empty() {
            return false;
        }
        let is_any = |cell: &Cell| matches!(cell, Cell::All | Cell::Shared);
        one.writes.iter().any(is_any)
            || value.reads.contains(&Cell::All)
            || value.reads.contains(&Cell::Shared)
                && one.writes.iter().any(|one| self.is_shared(*one))
            || one.writes.iter().any(|one| value.reads.iter().any(|own| self.are_one(*one, *own)))
    }

    /// Whether something else than the unit may write or read a cell.
    pub(super) fn is_shared(&self, cell: Cell) -> bool {
        let Cell::Variable(id) = cell else { return true };
        let one = self.tree.variable(id);
        one.at.is_some()
            || !matches!(
                one.section,
                Section::Local | Section::Temp | Section::Input | Section::Output
            )
            || self.is_exposed(id)
    }

    /// Where a cell has an address.
    pub(super) fn at(&self, cell: Cell) -> Option<At<'_>> {
        let (text, is_plain) = match cell {
            Cell::Variable(id) => {
                let one = self.tree.variable(id);
                let kind = self.tree.types.kind(one.ty);
                let is_bool = one.ty == self.bool();
                let is_plain = is_bool || kind.is_some_and(|kind| !matches!(kind, Kind::Opaque(_)));
                (one.at.as_deref()?, is_plain)
            }
            Cell::Address(id) => (self.tree.address(id).text.as_str(), true),
            _ => return None,
        };
        let mut letters = text.trim_start_matches('%').chars();
        let area = letters.next().map(|area| area.to_ascii_uppercase());
        let rest = letters.as_str();
        let digits = rest.trim_start_matches(|c: char| c.is_ascii_alphabetic());
        let size = &rest[..rest.len() - digits.len()];
        // A bit may be written without its letter.
        let size = if size.eq_ignore_ascii_case("X") { "" } else { size };
        Some((area, size, digits, is_plain))
    }

    pub(super) fn are_one(&self, one: Cell, other: Cell) -> bool {
        one == other
            || self.at(one).zip(self.at(other)).is_some_and(|(one, two)| overlap(&one, &two))
    }
}

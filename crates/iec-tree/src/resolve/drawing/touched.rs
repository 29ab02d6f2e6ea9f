//! The variables that the statements of a drawing read and write.

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

/// The unit of access analysis: a variable or a group of variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Cell {
    /// A whole variable; accesses to parts count for the whole.
    Variable(VarId),
    /// A direct address.
    Address(AddressId),
    /// All variables of a program instance.
    Program(usize),
    /// All variables shared with other units.
    Shared,
    /// Anything. Used for jumps, whose effect depends on their position, and for references, which may point anywhere.
    All,
}

/// The storage of a value whose operands are recorded.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Held {
    Temporary(TempId),
    Edge(VarId),
    /// An output whose value is not stored.
    Output(ElementId, String),
}

/// The accesses of a statement or an expression.
#[derive(Debug, Default)]
pub(super) struct Touched {
    pub(super) reads: BTreeSet<Cell>,
    pub(super) writes: BTreeSet<Cell>,
    /// The stored values that it reads.
    pub(super) held: BTreeSet<Held>,
}

/// Collects the accesses.
struct Walk<'t> {
    tree: &'t Tree,
    found: Touched,
}

impl Walk<'_> {
    /// The cells of a place. Empty for temporaries and edge memories, which are tracked as [`Held`].
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
            // VAR_IN_OUT may refer to any variable of the caller.
            false => is_handed(own).then_some(Cell::Shared),
        };
        std::iter::once(own).chain(through).collect()
    }

    /// Whether a variable is the memory of a drawn edge detection.
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
        // A part or a bit may be written while the rest stays, so a write counts as a read, too.
        self.reads(place);
        self.found.writes.extend(self.cells(place));
    }

    fn takes_address(&mut self, place: &Place) {
        self.reads(place);
    }

    fn asks(&mut self, flag: &StepFlag) {
        // The steps of the instance's own chart do not change while its actions run.
        if flag.owner.root != Root::This || !flag.owner.steps.is_empty() {
            self.reads(&flag.owner);
        }
    }

    fn calls(&mut self, call: &Call) {
        match &call.target {
            Target::Standard(place, _) => return self.writes(place),
            // Code of the own instance may write all of its variables.
            Target::BaseMethod(_) | Target::BaseBody(_) => _ = self.found.writes.insert(Cell::All),
            Target::Function(_) => {}
            Target::Instance(place, _)
            | Target::Action(place, _)
            | Target::Method(place, _)
            | Target::Program(place, _) => self.writes(place),
        }
        // The callee may write variables outside of its instance.
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

/// An address: its area, size letter and number; and whether the data there is no larger than that size.
pub(super) type At<'t> = (Option<char>, &'t str, &'t str, bool);

/// Whether two addresses such as `%QX0.1` and `%QW0` may overlap. Addresses of one size overlap only if they are equal,
/// unless an array or structure lies at one of them.
fn overlap(one: &At<'_>, other: &At<'_>) -> bool {
    one.0 == other.0 && (!one.3 || !other.3 || one.1 != other.1 || one.2 == other.2)
}

impl Resolver<'_> {
    /// The accesses of statements.
    pub(super) fn touched(&self, all: &[Statement]) -> Touched {
        let mut walk = Walk { tree: &self.tree, found: Touched::default() };
        of_statements(all, &mut walk);
        walk.found
    }

    /// The accesses of an expression.
    pub(super) fn touched_by(&self, one: &Expr) -> Touched {
        let mut walk = Walk { tree: &self.tree, found: Touched::default() };
        of_expr(one, &mut walk);
        walk.found
    }

    /// Whether executing `one` may change the value of the expression `value`.
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

    /// Whether code outside the unit may read or write the cell.
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

    /// The address of a cell; `None` if it has none.
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
        // A bit's address may omit the size letter X.
        let size = if size.eq_ignore_ascii_case("X") { "" } else { size };
        Some((area, size, digits, is_plain))
    }

    pub(super) fn are_one(&self, one: Cell, other: Cell) -> bool {
        one == other
            || self.at(one).zip(self.at(other)).is_some_and(|(one, two)| overlap(&one, &two))
    }
}

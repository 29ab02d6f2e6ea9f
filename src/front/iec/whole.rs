//! Structures and arrays as wholes: assigned, handed over and given back; and values that later calls must not change.

use super::emit::{Emit, Place};
use super::resolve::{Context, Element, Found};
use super::types::layout;
use super::value::Value;
use crate::iec::ast::{Expr, Path};
use crate::iec::fault::Fault;
use crate::program::{BitTarget, Cell, Logic, Region, WordSource, WordTarget, Write};

/// More cells than this are not copied one by one.
const MOST: u32 = 20_000;

/// Where a structure or an array lies.
pub(super) enum Whole {
    Place(Place),
    /// It is an element of unknown number.
    Element(Element),
}

impl Emit<'_> {
    /// The structure or array that a path means, if it means one.
    pub(super) fn whole(
        &mut self,
        at: &Context,
        path: &Path,
        line: u32,
    ) -> Result<Option<Whole>, Fault> {
        Ok(match self.find(at, path, line)? {
            Found::Place(place) if place.tag.cell().is_none() => Some(Whole::Place(place)),
            Found::Element(element) if element.place.tag.cell().is_none() => {
                Some(Whole::Element(element))
            }
            _ => None,
        })
    }

    /// The same of an expression.
    pub(super) fn whole_value(
        &mut self,
        at: &Context,
        expr: &Expr,
        line: u32,
    ) -> Result<Option<Whole>, Fault> {
        match expr {
            Expr::Variable(path) if !path.first.is_empty() && !self.is_single(at, path) => {
                self.whole(at, path, line)
            }
            _ => Ok(None),
        }
    }

    /// Copies a structure or an array, charged as one store: cell by cell where both are laid out alike, else what is written may
    /// be anything.
    pub(super) fn copy_whole(&mut self, from: &Whole, to: &Whole) {
        self.cost(&["LD"], "contact");
        let key = Some(Self::key(&["ST"], "move"));
        let always = crate::front::builder::always;
        let writes = match (from, to) {
            (Whole::Place(from), Whole::Place(to)) => copies(from, to),
            _ => None,
        };
        if let Some(writes) = writes {
            let effects = writes.into_iter().map(always).collect();
            self.builder.add(key, effects, crate::program::Step::Nothing);
            return;
        }
        let regions = match to {
            Whole::Place(to) => to.tag.regions(),
            Whole::Element(element) => element.whole.tag.regions(),
        };
        let choice = self.builder.choice();
        let effects = regions.into_iter().map(|region| always(Write::Havoc(region, choice)));
        let at = self.builder.add(key, effects.collect(), crate::program::Step::Nothing);
        let why = "a structure or array as a whole that is not followed: it may hold anything";
        self.program().approximate(at, why);
    }

    /// A value as it is now, whatever is called next.
    pub(super) fn frozen(&mut self, value: Value) -> Value {
        match value {
            Value::Bit(logic) => Value::Bit(self.keep_bit(logic)),
            Value::Number(kind, number) => {
                let words = self.copied(number, kind.words());
                Value::Number(kind, crate::program::Number::Words(words))
            }
            Value::Address(number, can) => {
                let words = self.copied(number, 1);
                Value::Address(crate::program::Number::Words(words), can)
            }
            Value::Open(kind, number, beyond) => {
                let words = self.copied(number, kind.words());
                let beyond = self.keep_bit(beyond);
                Value::Open(kind, crate::program::Number::Words(words), beyond)
            }
            other => other,
        }
    }
}

/// What copies each cell of one to that of the other, if they are laid out alike.
fn copies(from: &Place, to: &Place) -> Option<Vec<Write>> {
    if layout(&from.ty) != layout(&to.ty) {
        return None;
    }
    let size = layout(&to.ty).size()?;
    if size[0].checked_add(size[1])? > MOST {
        return None;
    }
    let cells = |place: &Place| -> Vec<Cell> {
        let each = |region: Region| match region {
            Region::Range { first, count } => (0..count).map(|at| first.plus(at)).collect(),
            _ => Vec::new(),
        };
        place.tag.regions().into_iter().flat_map(each).collect()
    };
    let pairs = cells(from).into_iter().zip(cells(to));
    let bits = usize::try_from(size[0]).ok()?;
    Some(
        pairs
            .enumerate()
            .map(|(at, (source, target))| match at < bits {
                true => Write::Bit(BitTarget::Cell(target), Logic::cell(source)),
                false => {
                    let number = crate::program::Number::Words(vec![WordSource::Cell(source)]);
                    Write::Words(vec![WordTarget::Cell(target)], number)
                }
            })
            .collect(),
    )
}

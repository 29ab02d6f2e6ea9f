//! Structures and arrays as wholes: assigned, handed over and given back; and values that later calls must not change.

use super::assembler::Assembler;
use super::emit::{Emit, Place};
use super::open::parted;
use super::resolve::{Context, Element, Found};
use super::types::{DINT, Kind};
use super::value::{Value, constant};
use scanbound_iec::ast::{Expr, Path};
use scanbound_iec::fault::Fault;
use scanbound_ir::{
    BitSource, BitTarget, Cell, Logic, Number, Region, Tag, TimingKey, WordSource, WordTarget,
    Write,
};

/// More cells than this are not copied one by one.
const MOST: u32 = 20_000;

/// Where a structure or an array lies.
pub(super) enum Whole {
    Place(Place),
    /// It is an element of unknown number.
    Element(Element),
}

impl Whole {
    /// Where it lies, or the first element that it may be.
    pub(super) fn place(&self) -> &Place {
        match self {
            Whole::Place(place) => place,
            Whole::Element(element) => &element.place,
        }
    }
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

    /// Copies a structure, an array or an instance, charged by its elements: cell by cell where both are laid out alike, else
    /// what is written may be anything.
    pub(super) fn copy_whole(&mut self, from: &Whole, to: &Whole, line: u32) -> Result<(), Fault> {
        let found = match to {
            Whole::Place(to) => Found::Place(to.clone()),
            Whole::Element(element) => Found::Element(element.clone()),
        };
        let key = self.store_key(&found, None, line)?;
        self.copy_charged(from, to, key);
        Ok(())
    }

    /// What is handed over in and out is copied here, and on a controller its address is.
    pub(super) fn copy_handed(&mut self, from: &Whole, to: &Whole) {
        self.copy_charged(from, to, Assembler::key(&["ST"], "move"));
    }

    fn copy_charged(&mut self, from: &Whole, to: &Whole, key: TimingKey) {
        self.cost(&["LD"], "contact");
        let key = Some(key);
        let always = scanbound_front::builder::always;
        let writes = match (from, to) {
            (Whole::Place(from), Whole::Place(to)) => copies(from, to),
            _ => None,
        };
        if let Some(writes) = writes {
            let effects = writes.into_iter().map(always).collect();
            self.builder.add(key, effects, scanbound_ir::Step::Nothing);
            return;
        }
        let regions = match to {
            Whole::Place(to) => to.tag.regions(),
            Whole::Element(element) => element.whole.tag.regions(),
        };
        let choice = self.builder.choice();
        let effects = regions.into_iter().map(|region| always(Write::Havoc(region, choice)));
        let at = self.builder.add(key, effects.collect(), scanbound_ir::Step::Nothing);
        let why = "a structure or array as a whole that is not followed: it may hold anything";
        self.program().approximate(at, why);
    }
}

impl Assembler {
    /// A value as it is now, in cells of its own. `merges`: another way may come to where it is kept with one that does not
    /// fit its type.
    pub(super) fn stored(&mut self, value: Value, merges: bool) -> Value {
        match value {
            Value::Number(kind @ Kind::Whole { .. }, number) if merges => {
                self.kept_open(kind, number, Logic::Const(false))
            }
            Value::Open(kind, number, beyond) => self.kept_open(kind, number, beyond),
            Value::Bit(logic) => {
                let cell = self.bit_between();
                self.write(vec![Write::Bit(BitTarget::Cell(cell), logic)]);
                Value::Bit(Logic::cell(cell))
            }
            Value::Address(number, can) => {
                let words = self.copied(number, 1);
                Value::Address(Number::Words(words), can)
            }
            Value::Constant(value) => {
                let words = self.copied(constant(value, 2), 2);
                Value::Number(DINT, Number::Words(words))
            }
            Value::Number(kind, number) => {
                let words = self.copied(number, kind.words());
                Value::Number(kind, Number::Words(words))
            }
            other => other,
        }
    }

    /// Writes a value to where another way has kept one for the same purpose; any value, if they are not of one kind.
    pub(super) fn merged(&mut self, known: Value, value: Value) -> Value {
        match (&known, value.clone()) {
            (Value::Bit(Logic::Bit(BitSource::Cell(cell))), Value::Bit(logic)) => {
                self.write(vec![Write::Bit(BitTarget::Cell(*cell), logic)]);
                known
            }
            (
                Value::Open(kind, Number::Words(words), Logic::Bit(BitSource::Cell(cell))),
                Value::Number(own, _) | Value::Open(own, ..),
            ) if *kind == own => {
                let (value, beyond) = parted(value);
                let beyond = beyond.unwrap_or(Logic::Const(false));
                self.write(vec![Write::Bit(BitTarget::Cell(*cell), beyond)]);
                self.merged(Value::Number(*kind, Number::Words(words.clone())), value);
                known
            }
            (Value::Address(Number::Words(words), can), Value::Address(number, more)) => {
                let [WordSource::Cell(cell)] = words[..] else { return Value::Any };
                self.write(vec![Write::Words(vec![WordTarget::Cell(cell)], number)]);
                let mut can = can.clone();
                can.extend(more);
                Value::Address(Number::Words(words.clone()), can)
            }
            (Value::Number(kind, Number::Words(words)), Value::Number(own, number))
                if *kind == own =>
            {
                let target = |word: &WordSource| match word {
                    WordSource::Cell(cell) => Some(WordTarget::Cell(*cell)),
                    _ => None,
                };
                match words.iter().map(target).collect() {
                    Some(targets) => {
                        self.write(vec![Write::Words(targets, number)]);
                        known
                    }
                    None => Value::Any,
                }
            }
            _ => Value::Any,
        }
    }

    /// A value as it is now, whatever is called next.
    pub(super) fn frozen(&mut self, value: Value) -> Value {
        match value {
            Value::Bit(logic) => Value::Bit(self.keep_bit(logic)),
            Value::Number(kind, number) => {
                let words = self.copied(number, kind.words());
                Value::Number(kind, Number::Words(words))
            }
            Value::Address(number, can) => {
                let words = self.copied(number, 1);
                Value::Address(Number::Words(words), can)
            }
            Value::Open(kind, number, beyond) => {
                let words = self.copied(number, kind.words());
                let beyond = self.keep_bit(beyond);
                Value::Open(kind, Number::Words(words), beyond)
            }
            other => other,
        }
    }
}

/// What copies each cell of one to that of the other, if they are laid out alike.
pub(super) fn copies(from: &Place, to: &Place) -> Option<Vec<Write>> {
    copy_cells(&from.tag, &to.tag)
}

/// What copies each cell of one to that of the other, if they are laid out alike.
pub(super) fn copy_cells(from: &Tag, to: &Tag) -> Option<Vec<Write>> {
    if from.of != to.of {
        return None;
    }
    let size = to.of.size()?;
    if size[0].checked_add(size[1])? > MOST {
        return None;
    }
    let cells = |tag: &Tag| -> Vec<Cell> {
        let each = |region: Region| match region {
            Region::Range { first, count } => (0..count).map(|at| first.plus(at)).collect(),
            _ => Vec::new(),
        };
        tag.regions().into_iter().flat_map(each).collect()
    };
    let pairs = cells(from).into_iter().zip(cells(to));
    let bits = usize::try_from(size[0]).ok()?;
    Some(
        pairs
            .enumerate()
            .map(|(at, (source, target))| match at < bits {
                true => Write::Bit(BitTarget::Cell(target), Logic::cell(source)),
                false => {
                    let number = Number::Words(vec![WordSource::Cell(source)]);
                    Write::Words(vec![WordTarget::Cell(target)], number)
                }
            })
            .collect(),
    )
}

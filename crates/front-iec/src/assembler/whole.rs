//! Copies of values: to temporaries that later writes do not change, and of whole structures and arrays.

use super::Assembler;
use super::open::parted;
use super::types::{DINT, Kind, holding};
use super::value::{Value, constant};
use scanbound_ir::{
    BitSource, BitTarget, Cell, Logic, Number, Region, Tag, WordSource, WordTarget, Write,
};

/// The most cells that are copied one by one.
const MOST: u32 = 20_000;

impl Assembler {
    /// Copies a value to new temporary cells. `merges`: another path may later store a value there that does not fit
    /// its type, so an integer also gets an overflow bit, and a constant becomes a DINT. Else it stays a constant.
    pub(crate) fn stored(&mut self, value: Value, merges: bool) -> Value {
        match value {
            Value::Constant(_) if !merges => value,
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
                let kind = holding(DINT, value);
                let words = self.copied(constant(value, kind.words()), kind.words());
                Value::Number(kind, Number::Words(words))
            }
            Value::Number(kind, number) => {
                let words = self.copied(number, kind.words());
                Value::Number(kind, Number::Words(words))
            }
            other => other,
        }
    }

    /// Writes a value to the cells in which another path stored `known` with [`Assembler::stored`], and returns the
    /// merged value. [`Value::Any`] if the two are of different kinds.
    pub(crate) fn merged(&mut self, known: Value, value: Value) -> Value {
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

    /// Copies a value to temporary cells, so that later calls do not change it. A constant stays a constant.
    pub(crate) fn frozen(&mut self, value: Value) -> Value {
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

/// The writes that copy a tag to another one, cell by cell. None if their layouts differ or they have too many cells.
pub(crate) fn copy_cells(from: &Tag, to: &Tag) -> Option<Vec<Write>> {
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

//! The bits and words that an expression reads.

use super::value::{BitSource, Logic, Number, Region, WordSource};

/// What an instruction reads: a bit or a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A bit that an expression reads.
    Bit(BitSource),
    /// A word that an expression reads.
    Word(WordSource),
}

impl Source {
    /// The cells that are read; `None` for constants and nondeterministic values.
    #[must_use]
    pub fn region(self) -> Option<Region> {
        let cells = |first, count| Some(Region::Range { first, count });
        match self {
            Source::Bit(BitSource::Cell(cell) | BitSource::WordBit(cell, _))
            | Source::Word(WordSource::Cell(cell)) => cells(cell, 1),
            Source::Word(WordSource::Bits { first, count }) => cells(first, count.into()),
            Source::Bit(_) | Source::Word(_) => None,
        }
    }
}

/// Like [`Source`], but the expression's source can be replaced by a new one.
#[derive(Debug, PartialEq, Eq)]
pub enum SourceMut<'a> {
    /// A bit that an expression reads.
    Bit(&'a mut BitSource),
    /// A word that an expression reads.
    Word(&'a mut WordSource),
}

impl Logic {
    /// Calls `see` with every bit and word that the expression reads.
    pub fn each_read(&self, see: &mut dyn FnMut(Source)) {
        logic(self, see);
    }

    /// Calls `change` with every bit and word that the expression reads, which may replace it.
    pub fn each_read_mut(&mut self, change: &mut dyn FnMut(SourceMut<'_>)) {
        logic_mut(self, change);
    }
}

pub(super) fn logic(of: &Logic, see: &mut dyn FnMut(Source)) {
    match of {
        Logic::Condition | Logic::Const(_) => {}
        Logic::Bit(source) => see(Source::Bit(*source)),
        Logic::Not(inner) => logic(inner, see),
        Logic::All(parts) | Logic::Any(parts) => parts.iter().for_each(|part| logic(part, see)),
        Logic::Compare(compare) => {
            number(&compare.left, see);
            number(&compare.right, see);
        }
    }
}

pub(super) fn number(of: &Number, see: &mut dyn FnMut(Source)) {
    of.words().for_each(|source| see(Source::Word(source)));
}

pub(super) fn logic_mut(of: &mut Logic, change: &mut dyn FnMut(SourceMut<'_>)) {
    match of {
        Logic::Condition | Logic::Const(_) => {}
        Logic::Bit(source) => change(SourceMut::Bit(source)),
        Logic::Not(inner) => logic_mut(inner, change),
        Logic::All(parts) | Logic::Any(parts) => {
            parts.iter_mut().for_each(|part| logic_mut(part, change))
        }
        Logic::Compare(compare) => {
            number_mut(&mut compare.left, change);
            number_mut(&mut compare.right, change);
        }
    }
}

pub(super) fn number_mut(of: &mut Number, change: &mut dyn FnMut(SourceMut<'_>)) {
    match of {
        Number::Words(sources) => {
            sources.iter_mut().for_each(|source| change(SourceMut::Word(source)))
        }
        Number::Add(a, b)
        | Number::Sub(a, b)
        | Number::And(a, b)
        | Number::Or(a, b)
        | Number::Xor(a, b) => {
            number_mut(a, change);
            number_mut(b, change);
        }
    }
}

//! Visits every place from which an instruction reads, to inspect or to replace it.

use super::{BitSource, Instruction, Logic, Number, Region, Step, Units, WordSource, Write};

/// What an instruction reads: a bit or a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A bit.
    Bit(BitSource),
    /// A word.
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

/// Like [`Source`], but replaceable.
#[derive(Debug, PartialEq, Eq)]
pub enum SourceMut<'a> {
    /// A bit.
    Bit(&'a mut BitSource),
    /// A word.
    Word(&'a mut WordSource),
}

impl Instruction {
    /// Calls `see` with every source of the step, of the effects, of the loop count and of the unit count. It omits
    /// choices that are not sources: those of real comparisons, havocked regions and loop summaries.
    pub fn each_read(&self, see: &mut dyn FnMut(Source)) {
        if let Some(fires) = self.step.fires() {
            logic(fires, see);
        }
        let count = match &self.step {
            Step::ForBegin { count, .. } => Some(*count),
            Step::Summary(summary) => summary.iterations.map(|(count, ..)| count),
            _ => None,
        };
        if let Some(count) = count {
            see(Source::Word(count));
        }
        if let Some(counted) = self.counted() {
            counted.words.iter().for_each(|word| see(Source::Word(*word)));
        }
        for effect in &self.effects {
            match &effect.write {
                Write::Bit(_, value) => logic(value, see),
                Write::Words(_, value) => number(value, see),
                Write::Havoc(..) => {}
            }
        }
    }

    /// Calls `change` with every source that [`Instruction::each_read`] visits, in the same order.
    pub fn each_read_mut(&mut self, change: &mut dyn FnMut(SourceMut<'_>)) {
        match &mut self.step {
            Step::Logic { value, .. } => logic_mut(value, change),
            Step::Act { fires }
            | Step::Jump { fires, .. }
            | Step::Call { fires, .. }
            | Step::Stop { fires }
            | Step::MasterControlBegin { fires, .. } => logic_mut(fires, change),
            Step::ForBegin { count, .. } => change(SourceMut::Word(count)),
            Step::Summary(summary) => {
                if let Some((count, ..)) = &mut summary.iterations {
                    change(SourceMut::Word(count));
                }
            }
            Step::AndBlock
            | Step::OrBlock
            | Step::Save(_)
            | Step::Fetch(_)
            | Step::Return
            | Step::End
            | Step::Unbounded { .. }
            | Step::ForEnd
            | Step::MasterControlEnd { .. }
            | Step::Nothing => {}
        }
        if let Some(Units::Counted(counted)) = self.timing.as_mut().map(|key| &mut key.units) {
            counted.words.iter_mut().for_each(|word| change(SourceMut::Word(word)));
        }
        for effect in &mut self.effects {
            match &mut effect.write {
                Write::Bit(_, value) => logic_mut(value, change),
                Write::Words(_, value) => number_mut(value, change),
                Write::Havoc(..) => {}
            }
        }
    }
}

impl Logic {
    /// Calls `see` with every source of the expression.
    pub fn each_read(&self, see: &mut dyn FnMut(Source)) {
        logic(self, see);
    }

    /// Calls `change` with every source of the expression.
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
    match of {
        Number::Words(sources) => sources.iter().for_each(|source| see(Source::Word(*source))),
        Number::Add(a, b)
        | Number::Sub(a, b)
        | Number::And(a, b)
        | Number::Or(a, b)
        | Number::Xor(a, b) => {
            number(a, see);
            number(b, see);
        }
    }
}

fn logic_mut(of: &mut Logic, change: &mut dyn FnMut(SourceMut<'_>)) {
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

fn number_mut(of: &mut Number, change: &mut dyn FnMut(SourceMut<'_>)) {
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

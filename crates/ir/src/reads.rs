//! Visits every place from which an instruction reads, to inspect or to replace it.

use super::source::{Source, SourceMut, logic, logic_mut, number, number_mut};
use super::{Instruction, Step, Units, Write};

impl Instruction {
    /// Calls `see` with every bit and word that the step, the effects, the loop count or the unit count reads. Choices
    /// that are not read as a bit or word are omitted: those of comparisons of real numbers, of havocs and of loop
    /// summaries.
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

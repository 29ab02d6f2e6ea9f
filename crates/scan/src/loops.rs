//! Loops: executed iteration by iteration, or charged as a summary.

use super::run::{Activation, ForLoop, Run, RungResults};
use super::settings::{Purpose, ScanError};
use super::unknown_writes;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{BitSource, Exit, Frame, Logic, Summary, WordSource};
use scanbound_model::{Lit, LoopCount, Unbounded};

impl Run<'_> {
    /// Executes a loop iteration by iteration. Returns the index of the instruction after its end.
    pub(super) fn for_loop(
        &mut self,
        act: &mut Activation,
        for_loop: ForLoop,
    ) -> Result<usize, ScanError> {
        self.exclude_other_counts(act.active, for_loop.at, for_loop.count);
        self.check_iterations(act.active, for_loop.at, for_loop.count, for_loop.most);
        self.iterations(act, for_loop)?;
        Ok(for_loop.end + 1)
    }

    /// Charges a loop or routine that is not followed, and havocs everything that it may write. Returns the index of
    /// the instruction after its end.
    pub(super) fn summary(
        &mut self,
        act: &mut Activation,
        at: usize,
        summary: &Summary,
    ) -> Result<usize, ScanError> {
        let Summary { end, charges, havocs, choice, exits, iterations } = summary;
        if let Some((count, _, most)) = *iterations {
            self.exclude_other_counts(act.active, at, count);
            self.check_iterations(act.active, at, count, most);
        }
        match *iterations {
            Some(iterations) if self.purpose == Purpose::LowerBound => {
                self.charge_by_count(act.active, at, charges, iterations)?;
            }
            Some(iterations) => {
                self.note_most_iterations(act.active, at, iterations);
                self.charge_summary(act.active, charges)?;
            }
            None => self.charge_summary(act.active, charges)?,
        }
        for &region in havocs {
            self.memory.havoc(region, act.active, &self.frames, *choice);
        }
        act.results = RungResults::default();
        for &(choice, exit) in exits {
            let taken = self.logic(&Logic::Bit(BitSource::Free(choice)), Lit::TRUE, at);
            let fired = self.memory.circuit().and(act.active, taken);
            self.leave(act, exit, taken, fired);
        }
        Ok(end + 1)
    }

    /// Leaves a loop that is not followed by one of its exits where control is here and `fires` is true; `fired` is
    /// both together.
    fn leave(&mut self, act: &mut Activation, exit: Exit, fires: Lit, fired: Lit) {
        if let Exit::To(target) = exit {
            return self.jump(act, target, fires, fired);
        }
        let circuit = self.memory.circuit();
        act.active = circuit.and(act.active, !fires);
        match exit {
            Exit::Return => act.returned = circuit.or(act.returned, fired),
            Exit::Stop => self.stopped = circuit.or(self.stopped, fired),
            Exit::Unbounded(instruction) => {
                self.stopped = circuit.or(self.stopped, fired);
                let frames = self.frames.clone();
                self.memory.model.unbounded.push(Unbounded { instruction, frames, reached: fired });
            }
            Exit::End | Exit::To(_) => {}
        }
    }

    /// The word that gives the number of iterations, and whether the word is signed (a negative count means no
    /// iteration).
    pub(super) fn count(&self, count: WordSource) -> (WordSource, bool) {
        let kind = match count {
            WordSource::Free(choice) => self.program.kinds.get(&choice),
            _ => None,
        };
        match kind {
            Some(ChoiceKind::UnsignedIterations(word)) => (*word, false),
            _ => (count, true),
        }
    }

    /// Executes a loop iteration by iteration, `most` at most. From iteration number `least` on, each has the guard
    /// that the count includes it.
    fn iterations(&mut self, act: &mut Activation, for_loop: ForLoop) -> Result<(), ScanError> {
        let ForLoop { at, count, least, most, end } = for_loop;
        let given_up = self.memory.words.given_up;
        let (count, is_signed) = self.count(count);
        let count = self.word(count, at);
        let largest = if is_signed { 0x7FFF } else { 0xFFFF };
        let mut done = Lit::FALSE;
        for iteration in 0..most {
            if act.active == Lit::FALSE {
                break;
            }
            if iteration >= least {
                // Another iteration is made if the count exceeds the number of iterations so far.
                let first = u16::try_from(iteration + 1).ok().filter(|&first| first <= largest);
                let circuit = &mut self.memory.model.circuit;
                let more = first.map_or(Lit::FALSE, |first| {
                    self.memory.words.in_range(circuit, count, first, largest)
                });
                if self.memory.words.given_up > given_up {
                    self.costly.insert(at);
                    break;
                }
                let circuit = self.memory.circuit();
                let finished = circuit.and(act.active, !more);
                done = circuit.or(done, finished);
                act.active = circuit.and(act.active, more);
            }
            self.frames.push(Frame { at, iteration });
            let result = self.span(act, at + 1, end + 1);
            self.frames.pop();
            result?;
        }
        if done != Lit::FALSE {
            // The results of the last iteration are valid only if it was executed.
            act.results = RungResults::default();
        }
        act.active = self.memory.circuit().or(act.active, done);
        Ok(())
    }

    /// Records how many iterations a loop that is not followed can make in this call context, within `least..=most`,
    /// and from which free words this number is computed.
    fn note_most_iterations(
        &mut self,
        reached: Lit,
        at: usize,
        (count, least, most): (WordSource, u32, u32),
    ) {
        let (word, once) = match count {
            WordSource::Free(choice) => match self.program.kinds.get(&choice) {
                Some(ChoiceKind::Iterations(word)) => (*word, 1),
                // The limit that follows is for signed numbers.
                _ => (count, u32::MAX),
            },
            word => (word, 0),
        };
        let word = self.word(word, at);
        let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
        self.memory.model.count_variables.extend(unknown_writes::parts(words, &[word]));
        let known = words.most(circuit, word);
        let iterations = known.map_or(u32::MAX, |most| u32::try_from(most).unwrap_or(0).max(once));
        if !self.knowledge.is_empty() {
            // With observed results, the solver may prove a limit on the count that the structure of the word does not
            // show.
            let bits = words.bits(circuit, word);
            let least = once.max(least);
            self.memory.model.loop_counts.push(LoopCount { instruction: at, reached, bits, least });
        }
        let all = self.memory.model.iterations.entry(at).or_default();
        *all = iterations.clamp(least, most).max(*all);
    }

    /// Excludes scans in which the loop is reached and its count is outside the range that the user stated, if there is
    /// one.
    fn exclude_other_counts(&mut self, reached: Lit, at: usize, count: WordSource) {
        let Some(&(low, high)) = self.program.stated_counts.get(&at) else { return };
        let (word, is_signed) = match count {
            WordSource::Free(choice) => match self.program.kinds.get(&choice) {
                Some(ChoiceKind::Iterations(word)) => (*word, true),
                Some(ChoiceKind::UnsignedIterations(word)) => (*word, false),
                _ => return,
            },
            word => (word, true),
        };
        let word = self.word(word, at);
        let within = self.within(&[word], is_signed, low, high);
        self.exclude_unless(reached, within);
    }
}

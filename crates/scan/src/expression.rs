//! Evaluates the expressions of instructions symbolically, to guards and words.

use super::number;
use super::run::Run;
use super::word::{Gate, Word};
use scanbound_ir::{BitSource, Compare, Logic, Number, NumberFormat, Program, WordSource};
use scanbound_model::Lit;

impl Run<'_> {
    /// The literal of a Boolean expression that instruction `at` evaluates; `condition` is the value of
    /// [`Logic::Condition`].
    pub(super) fn logic(&mut self, logic: &Logic, condition: Lit, at: usize) -> Lit {
        match logic {
            Logic::Condition => condition,
            Logic::Const(value) => Lit::constant(*value),
            Logic::Bit(BitSource::Const(value)) => Lit::constant(*value),
            Logic::Bit(BitSource::Cell(cell)) => self.simplified_bit(*cell),
            Logic::Bit(BitSource::WordBit(cell, bit)) => {
                let word = self.simplified_word(*cell);
                self.memory.words.bits(&mut self.memory.model.circuit, word)[usize::from(*bit)]
            }
            Logic::Bit(BitSource::Free(choice)) => self.bit_choice(*choice, at),
            Logic::Not(inner) => !self.logic(inner, condition, at),
            Logic::All(parts) => {
                let lits: Vec<Lit> =
                    parts.iter().map(|part| self.logic(part, condition, at)).collect();
                self.memory.circuit().all(lits)
            }
            Logic::Any(parts) => {
                let lits: Vec<Lit> =
                    parts.iter().map(|part| self.logic(part, condition, at)).collect();
                self.memory.circuit().any(lits)
            }
            Logic::Compare(compare) => self.compare(compare, at),
        }
    }

    fn compare(&mut self, compare: &Compare, at: usize) -> Lit {
        let left = self.number(&compare.left, at);
        let right = self.number(&compare.right, at);
        let special = match compare.format {
            NumberFormat::Real(choice) => {
                Some(self.logic(&Logic::Bit(BitSource::Free(choice)), Lit::TRUE, at))
            }
            NumberFormat::Signed | NumberFormat::Unsigned => None,
        };
        let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
        match special {
            Some(special) => {
                number::compare_real(words, circuit, compare.relation, &left, &right, special)
            }
            None => {
                let signed = compare.format == NumberFormat::Signed;
                number::compare(words, circuit, compare.relation, signed, &left, &right)
            }
        }
    }

    /// The symbolic words of a number that instruction `at` reads.
    pub(super) fn number(&mut self, number: &Number, at: usize) -> Vec<Word> {
        let (a, b) = match number {
            Number::Words(sources) => {
                return sources.iter().map(|&source| self.word(source, at)).collect();
            }
            Number::Add(a, b)
            | Number::Sub(a, b)
            | Number::And(a, b)
            | Number::Or(a, b)
            | Number::Xor(a, b) => (self.number(a, at), self.number(b, at)),
        };
        let words = &mut self.memory.words;
        match number {
            Number::Add(..) => number::add(words, &a, &b, false),
            Number::Sub(..) => number::add(words, &a, &b, true),
            Number::And(..) => number::bitwise(words, &a, &b, Gate::And),
            Number::Or(..) => number::bitwise(words, &a, &b, Gate::Or),
            Number::Xor(..) => number::bitwise(words, &a, &b, Gate::Xor),
            Number::Words(_) => a,
        }
    }

    /// The symbolic word of a source that instruction `at` reads.
    pub(super) fn word(&mut self, source: WordSource, at: usize) -> Word {
        match source {
            WordSource::Const(value) => self.memory.words.constant(value),
            WordSource::Cell(cell) => self.simplified_word(cell),
            WordSource::Bits { first, count } => {
                let bits = std::array::from_fn(|i| {
                    if i < usize::from(count) {
                        self.simplified_bit(first.plus(i as u32))
                    } else {
                        Lit::FALSE
                    }
                });
                self.memory.words.of_bits(&self.memory.model.circuit, bits)
            }
            WordSource::Free(choice) => self.word_choice(choice, at),
        }
    }
}

/// The name of a choice of instruction `at` for reports: the instruction's text and its place in the source.
pub(super) fn describe(program: &Program, at: usize) -> String {
    let instruction = &program.instructions[at];
    format!("`{}` in {}", instruction.text, program.location_text(instruction.place))
}

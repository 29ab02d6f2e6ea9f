//! Symbolic 16-bit words: constants, free words, if-then-else, sums, bitwise operations, and words composed of bits.
//!
//! A word only records how it is computed. Its bits, or whether it lies in a range, are computed when a guard needs
//! them (`answer`). Most results of a program's arithmetic affect no guard, so they cost nothing.

use super::derived::{Derived, Function};
use super::term::{Answers, CarryDefinition, Node};
pub use super::term::{Carry, Gate, Word};
use rustc_hash::FxHashSet;
use scanbound_model::{Atom, Circuit, Lit, Shared, VarId};
use std::collections::BTreeSet;

/// The largest number of parts that [`Words::most`] examines to find the maximum of a word.
const MAX_PARTS: usize = 64;
/// [`Words::most`] looks for a smaller constant only if at least this much of the allowed work remains.
const LEAST_ALLOWANCE: usize = 1 << 14;

/// All symbolic words of a scan, with equal words shared, and the queries on them that were answered.
#[derive(Debug)]
pub struct Words {
    nodes: Shared<Node>,
    given_bits: Shared<[Lit; 16]>,
    carries: Shared<CarryDefinition>,
    derived: Shared<Derived>,
    pub(super) answers: Answers,
    /// The steps that queries of the current instruction may still take.
    pub allowance: usize,
    /// The steps that all queries have taken so far.
    pub spent: usize,
    /// The number of free bits in place of the answers of queries that were given up, because they exceeded the allowed
    /// steps. If it is not 0, the model must be discarded.
    pub given_up: u32,
}

impl Default for Words {
    /// No words, and no limit on the steps of queries.
    fn default() -> Self {
        let mut carries = Shared::default();
        carries.number(CarryDefinition::None);
        carries.number(CarryDefinition::Always);
        Words {
            nodes: Shared::default(),
            given_bits: Shared::default(),
            carries,
            derived: Shared::default(),
            answers: Answers::default(),
            allowance: usize::MAX,
            spent: 0,
            given_up: 0,
        }
    }
}

impl Words {
    /// The symbolic word of a constant.
    pub fn constant(&mut self, value: u16) -> Word {
        self.shared(Node::Const(value))
    }

    /// The symbolic word of a free variable, which may have any value.
    pub fn free(&mut self, variable: VarId) -> Word {
        self.shared(Node::Free(variable))
    }

    /// If-then-else: `then` if `condition`, else `other`.
    pub fn either(&mut self, condition: Lit, then: Word, other: Word) -> Word {
        if condition == Lit::TRUE || then == other {
            return then;
        }
        if condition == Lit::FALSE {
            return other;
        }
        // In the else branch, a nested if-then-else with the same condition is decided.
        let other = match self.node(other) {
            Node::Either(c, _, b) if c == condition => b,
            Node::Either(c, a, _) if c == !condition => a,
            _ => other,
        };
        if then == other { then } else { self.shared(Node::Either(condition, then, other)) }
    }

    /// The sum of a word and a constant, modulo 65,536.
    pub fn plus(&mut self, word: Word, addend: u16) -> Word {
        match self.node(word) {
            _ if addend == 0 => word,
            Node::Const(value) => self.constant(value.wrapping_add(addend)),
            Node::Plus(inner, first) => self.plus(inner, first.wrapping_add(addend)),
            _ => self.shared(Node::Plus(word, addend)),
        }
    }

    /// The sum of a word, a constant and a carry, modulo 65,536, and the carry out.
    pub fn plus_carried(&mut self, word: Word, addend: u16, carry: Carry) -> (Word, Carry) {
        match (carry, self.as_constant(word)) {
            (Carry::NONE, _) if addend == 0 => (word, Carry::NONE),
            (Carry::ALWAYS, _) if addend == u16::MAX => (word, Carry::ALWAYS),
            (Carry::ALWAYS, _) => self.plus_carried(word, addend + 1, Carry::NONE),
            (Carry::NONE, Some(value)) => {
                let (sum, over) = value.overflowing_add(addend);
                (self.constant(sum), if over { Carry::ALWAYS } else { Carry::NONE })
            }
            (Carry::NONE, None) => {
                (self.plus(word, addend), self.carry(CarryDefinition::Carried(word, addend, carry)))
            }
            _ => {
                let sum = self.shared(Node::Carried(word, addend, carry));
                (sum, self.carry(CarryDefinition::Carried(word, addend, carry)))
            }
        }
    }

    /// The sum of two words and a carry, modulo 65,536, and the carry out.
    pub fn sum(&mut self, a: Word, b: Word, carry: Carry) -> (Word, Carry) {
        let (a, b) = (a.min(b), a.max(b));
        let sum = self.shared(Node::Sum(a, b, carry));
        (sum, self.carry(CarryDefinition::Sum(a, b, carry)))
    }

    /// A bitwise operation on two words.
    pub fn bitwise(&mut self, gate: Gate, a: Word, b: Word) -> Word {
        let (a, b) = (a.min(b), a.max(b));
        let (first, second) = (self.as_constant(a), self.as_constant(b));
        if let (Some(a), Some(b)) = (first, second) {
            return self.constant(match gate {
                Gate::And => a & b,
                Gate::Or => a | b,
                Gate::Xor => a ^ b,
            });
        }
        let (word, constant) = if first.is_some() { (b, first) } else { (a, second) };
        match (gate, constant) {
            (Gate::And | Gate::Or, _) if a == b => a,
            (Gate::Xor, _) if a == b => self.constant(0),
            (Gate::And, Some(u16::MAX)) | (Gate::Or | Gate::Xor, Some(0)) => word,
            (Gate::And, Some(0)) => self.constant(0),
            (Gate::Or, Some(u16::MAX)) => self.constant(u16::MAX),
            _ => self.shared(Node::Bitwise(gate, a, b)),
        }
    }

    /// The lowest `wanted` words of the result of an operation on two numbers of one or two words each.
    pub fn derived(
        &mut self,
        function: Function,
        first: &[Word],
        second: &[Word],
        wanted: usize,
    ) -> Vec<Word> {
        let pair = |number: &[Word]| [number[0], number[number.len() - 1]];
        let words = u8::try_from(first.len()).unwrap_or(1);
        let asked = u8::try_from(wanted).unwrap_or(1);
        let (first, second) = (pair(first), pair(second));
        let own = Derived { function, words, first, second, wanted: asked };
        let number = self.derived.number(own);
        (0..asked).map(|place| self.shared(Node::Derived(number, place))).collect()
    }

    pub(super) fn derived_of(&self, number: u32) -> Derived {
        self.derived.get(number)
    }

    /// A word composed of sixteen bits, least significant first. A constant, or the free word, if the bits are exactly
    /// those.
    pub fn of_bits(&mut self, circuit: &Circuit, bits: [Lit; 16]) -> Word {
        if bits.iter().all(|b| b.is_constant()) {
            let value = (0..16).fold(0, |value, i| value | u16::from(bits[i] == Lit::TRUE) << i);
            return self.constant(value);
        }
        let is_bit_of = |i: usize| match circuit.node(bits[i]) {
            scanbound_model::Node::Atom(Atom::WordBit(v, bit))
                if usize::from(bit) == i && !bits[i].is_negated() =>
            {
                Some(v)
            }
            _ => None,
        };
        if let Some(variable) = is_bit_of(0)
            && (1..16).all(|i| is_bit_of(i) == Some(variable))
        {
            return self.free(variable);
        }
        let number = self.given_bits.number(bits);
        self.shared(Node::Bits(number))
    }

    /// The word's value if it is a constant; `None` for all other words, even if they can have only one value.
    pub fn as_constant(&self, word: Word) -> Option<u16> {
        match self.node(word) {
            Node::Const(value) => Some(value),
            _ => None,
        }
    }

    /// An upper limit of the word as a signed number; `None` if nothing limits it, or the word has too many parts.
    ///
    /// It is the maximum that the word's parts allow, or a smaller non-negative constant among its parts that the word
    /// is proved never to exceed. Such a constant occurs where a program limits a count before it uses it.
    pub fn most(&mut self, circuit: &mut Circuit, word: Word) -> Option<i16> {
        let mut constants = BTreeSet::new();
        let most = self.greatest(circuit, word, &mut constants);
        let asked =
            if self.allowance >= LEAST_ALLOWANCE { 0..most.unwrap_or(0).max(0) } else { 0..0 };
        let never_above = constants.range(asked).copied().find(|constant| {
            let more = constant.cast_unsigned() + 1;
            self.range_if_allowed(circuit, word, more, 0x7FFF) == Some(Lit::FALSE)
        });
        never_above.or(most).filter(|&most| most < i16::MAX)
    }

    /// The largest signed number that the word's parts allow. Adds the constants among these parts to `constants`.
    /// `None` if there are too many parts, or computing their bits exceeds the allowed steps.
    fn greatest(
        &mut self,
        circuit: &mut Circuit,
        word: Word,
        constants: &mut BTreeSet<i16>,
    ) -> Option<i16> {
        let (mut open, mut seen) = (vec![(word, 0u16)], FxHashSet::default());
        let mut most = i16::MIN;
        while let Some((word, addend)) = open.pop() {
            if !seen.insert((word, addend)) {
                continue;
            }
            if seen.len() > MAX_PARTS {
                return None;
            }
            most = most.max(match self.node(word) {
                Node::Const(value) => {
                    let value = value.wrapping_add(addend).cast_signed();
                    constants.insert(value);
                    value
                }
                Node::Either(_, a, b) => {
                    open.extend([(a, addend), (b, addend)]);
                    continue;
                }
                Node::Plus(inner, more) => {
                    open.push((inner, addend.wrapping_add(more)));
                    continue;
                }
                Node::Free(_) => i16::MAX,
                Node::Bits(_)
                | Node::Bitwise(..)
                | Node::Sum(..)
                | Node::Carried(..)
                | Node::Derived(..) => {
                    let bits = self.bits_if_allowed(circuit, word)?;
                    let may = |i: usize| bits[i] != Lit::FALSE;
                    let most = (0..15).fold(0u16, |most, i| most | u16::from(may(i)) << i);
                    let negative = bits[15] == Lit::TRUE;
                    match most.checked_add(addend).map(u16::cast_signed) {
                        Some(most) if most >= 0 && !negative && !may(15) => most,
                        _ if negative && addend == 0 => -1,
                        _ => i16::MAX,
                    }
                }
            });
        }
        Some(most)
    }

    /// Subtracts `work` steps from the allowed ones; `false` if fewer were left.
    pub(super) fn spend(&mut self, work: usize) -> bool {
        self.spent += work;
        let enough = self.allowance >= work;
        self.allowance = self.allowance.saturating_sub(work);
        enough
    }

    pub(super) fn node(&self, word: Word) -> Node {
        self.nodes.get(word.0)
    }

    pub(super) fn bits_of_number(&self, number: u32) -> [Lit; 16] {
        self.given_bits.get(number)
    }

    pub(super) fn carry_of(&self, carry: Carry) -> CarryDefinition {
        self.carries.get(carry.0)
    }

    fn carry(&mut self, of: CarryDefinition) -> Carry {
        Carry(self.carries.number(of))
    }

    fn shared(&mut self, node: Node) -> Word {
        Word(self.nodes.number(node))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_model::Assignment;

    /// Compares a word with a function of one free word, for all queries, at several values.
    fn check(build: impl Fn(&mut Words, &mut Circuit, Word) -> Word, meaning: impl Fn(u16) -> u16) {
        let (mut words, mut circuit) = (Words::default(), Circuit::default());
        let free = words.free(VarId(0));
        let word = build(&mut words, &mut circuit, free);
        let edges = [0, 1, 2, 5, 6, 99, 100, 101, 0x7FFF, 0x8000, 0xFFFE, 0xFFFF];
        let mut asked = Vec::new();
        for low in edges {
            for high in edges {
                asked.push((low, high, words.in_range(&mut circuit, word, low, high)));
            }
        }
        let bits = words.bits(&mut circuit, word);
        for value in edges.into_iter().chain([3, 4, 50, 102, 0x1234, 0x8001]) {
            let values = circuit.evaluate(&Assignment(vec![value]));
            let expected = meaning(value);
            for &(low, high, lit) in &asked {
                assert_eq!(
                    values.get(lit),
                    (low..=high).contains(&expected),
                    "{value} in {low}..={high}"
                );
            }
            for (i, &bit) in bits.iter().enumerate() {
                assert_eq!(values.get(bit), expected >> i & 1 == 1, "bit {i} of {value}");
            }
        }
    }

    #[test]
    fn a_free_word_is_itself() {
        check(|_, _, free| free, |v| v);
    }

    #[test]
    fn sums_wrap_around() {
        for addend in [1, 5, 0x7FFF, 0x8000, 0xFFFF] {
            check(|words, _, free| words.plus(free, addend), |v| v.wrapping_add(addend));
        }
    }

    #[test]
    fn either_or_takes_the_side_of_its_condition() {
        check(
            |words, circuit, free| {
                let is_five = words.in_range(circuit, free, 5, 5);
                let hundred = words.constant(100);
                let sum = words.plus(free, 2);
                words.either(is_five, hundred, sum)
            },
            |v| if v == 5 { 100 } else { v.wrapping_add(2) },
        );
    }

    #[test]
    fn bits_make_words() {
        check(
            |words, circuit, free| {
                let mut bits = words.bits(circuit, free);
                bits[0] = Lit::TRUE;
                bits[7] = !bits[7];
                words.of_bits(circuit, bits)
            },
            |v| (v | 1) ^ 0x80,
        );
    }

    #[test]
    fn a_chain_of_many_writes_does_not_exhaust_the_stack() {
        let (mut words, mut circuit) = (Words::default(), Circuit::default());
        let mut word = words.free(VarId(0));
        for v in 1..200_000 {
            let condition = circuit.atom(Atom::Bit(VarId(v)));
            let constant = words.constant(v as u16);
            word = words.either(condition, constant, word);
        }
        assert!(!words.in_range(&mut circuit, word, 3, 9).is_constant());
    }
}

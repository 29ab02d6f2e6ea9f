//! Symbolic 16-bit words: constants, free words, either-or, sums with a constant, and words put together from bits.

use crate::scan::model::{self, Atom, Circuit, Lit, VarId};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeSet;

/// So many parts of a word are looked at for the most that it can be.
const MOST_PARTS: usize = 64;
/// Asking that of them takes less than this.
const ASKED: usize = 1 << 14;

/// A symbolic word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Word(u32);

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Node {
    Const(u16),
    Free(VarId),
    Either(Lit, Word, Word),
    Plus(Word, u16),
    Bits([Lit; 16]),
}

/// All symbolic words of a scan, equal ones shared, and what was already asked of them.
#[derive(Debug)]
pub struct Words {
    nodes: Vec<Node>,
    known: FxHashMap<Node, Word>,
    ranges: FxHashMap<Range, Lit>,
    bits: FxHashMap<Word, [Lit; 16]>,
    /// What may still be spent on the questions of the instruction at work.
    pub allowance: usize,
    /// What was spent on questions so far.
    pub spent: usize,
    /// How many questions were given up since they took more than was allowed. Their answers are made up, so the
    /// model that they stand in is of no use.
    pub given_up: u32,
}

/// The question whether a word, unsigned, lies between two values, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Range(Word, u16, u16);

impl Default for Words {
    /// No words, and no limit to what a question may take.
    fn default() -> Self {
        Words {
            nodes: Vec::new(),
            known: FxHashMap::default(),
            ranges: FxHashMap::default(),
            bits: FxHashMap::default(),
            allowance: usize::MAX,
            spent: 0,
            given_up: 0,
        }
    }
}

impl Words {
    /// A constant.
    pub fn constant(&mut self, value: u16) -> Word {
        self.intern(Node::Const(value))
    }

    /// A free word.
    pub fn free(&mut self, variable: VarId) -> Word {
        self.intern(Node::Free(variable))
    }

    /// `then` if `condition`, else `other`.
    pub fn either(&mut self, condition: Lit, then: Word, other: Word) -> Word {
        if condition == Lit::TRUE || then == other {
            return then;
        }
        if condition == Lit::FALSE {
            return other;
        }
        // Below a condition the same condition is decided.
        let other = match self.node(other) {
            Node::Either(c, _, b) if c == condition => b,
            Node::Either(c, a, _) if c == !condition => a,
            _ => other,
        };
        if then == other { then } else { self.intern(Node::Either(condition, then, other)) }
    }

    /// Sum with a constant, wrapping.
    pub fn plus(&mut self, word: Word, addend: u16) -> Word {
        match self.node(word) {
            _ if addend == 0 => word,
            Node::Const(value) => self.constant(value.wrapping_add(addend)),
            Node::Plus(inner, first) => self.plus(inner, first.wrapping_add(addend)),
            _ => self.intern(Node::Plus(word, addend)),
        }
    }

    /// A word of sixteen bits, the least first.
    pub fn of_bits(&mut self, circuit: &Circuit, bits: [Lit; 16]) -> Word {
        if bits.iter().all(|b| b.is_constant()) {
            let value = (0..16).fold(0, |value, i| value | u16::from(bits[i] == Lit::TRUE) << i);
            return self.constant(value);
        }
        let is_bit_of = |i: usize| match circuit.node(bits[i]) {
            model::Node::Atom(Atom::WordBit(v, bit))
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
        self.intern(Node::Bits(bits))
    }

    /// The word's value, if it is a constant.
    pub fn as_constant(&self, word: Word) -> Option<u16> {
        match self.node(word) {
            Node::Const(value) => Some(value),
            _ => None,
        }
    }

    /// The most that the word can be as a signed number, where something bounds it.
    ///
    /// That is what its parts can be, or one of the constants among them that the word is found never to exceed, as
    /// where a program limits a count before it uses it.
    pub fn most(&mut self, circuit: &mut Circuit, word: Word) -> Option<i16> {
        let mut constants = BTreeSet::new();
        let most = self.greatest(word, &mut constants)?;
        let asked = if self.allowance >= ASKED { 0..most.max(0) } else { 0..0 };
        for &constant in constants.range(asked) {
            let above = self.in_range(circuit, word, constant.cast_unsigned() + 1, 0x7FFF);
            if above == Lit::FALSE {
                return Some(constant);
            }
        }
        Some(most).filter(|&most| most < i16::MAX)
    }

    /// The greatest signed number that the word's parts allow, and the constants that it may be. `None` if there are
    /// too many parts to look at.
    fn greatest(&self, word: Word, constants: &mut BTreeSet<i16>) -> Option<i16> {
        let (mut open, mut seen) = (vec![(word, 0u16)], FxHashSet::default());
        let mut most = i16::MIN;
        while let Some((word, addend)) = open.pop() {
            if !seen.insert((word, addend)) {
                continue;
            }
            if seen.len() > MOST_PARTS {
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
                Node::Bits(bits) => {
                    let may = |i: usize| bits[i] != Lit::FALSE;
                    let most = (0..15).fold(0u16, |most, i| most | u16::from(may(i)) << i);
                    let negative = bits[15] == Lit::TRUE;
                    match most.checked_add(addend).map(u16::cast_signed) {
                        Some(most) if most >= 0 && !negative && !may(15) => most,
                        _ if negative && addend == 0 => -1,
                        _ => i16::MAX,
                    }
                }
                Node::Free(_) => i16::MAX,
            });
        }
        Some(most)
    }

    /// Whether the word, unsigned, lies in `low..=high`.
    ///
    /// Works through chains of either-or without recursion: a step word written in a thousand rungs is a
    /// chain a thousand deep.
    pub fn in_range(&mut self, circuit: &mut Circuit, word: Word, low: u16, high: u16) -> Lit {
        let asked = Range(word, low, high);
        let mut open = vec![asked];
        while let Some(&range) = open.last() {
            if self.answer(range).is_some() {
                open.pop();
                continue;
            }
            if !self.spend(1) {
                return self.made_up(circuit);
            }
            let (parts, missing) = self.parts(range);
            if missing {
                open.extend(
                    parts.into_iter().flatten().filter(|&part| self.answer(part).is_none()),
                );
                continue;
            }
            let lit = self.combine(circuit, range, parts);
            self.ranges.insert(range, lit);
            open.pop();
        }
        self.answer(asked).expect("the loop above answers what was asked")
    }

    /// The answer, where it is known.
    fn answer(&self, Range(word, low, high): Range) -> Option<Lit> {
        if low > high {
            return Some(Lit::FALSE);
        }
        if low == 0 && high == u16::MAX {
            return Some(Lit::TRUE);
        }
        self.ranges.get(&Range(word, low, high)).copied()
    }

    /// The questions to other words that this one comes down to, and whether one is still open.
    fn parts(&self, Range(word, low, high): Range) -> ([Option<Range>; 2], bool) {
        let parts = match self.node(word) {
            Node::Either(_, a, b) => [Some(Range(a, low, high)), Some(Range(b, low, high))],
            Node::Plus(inner, addend) => {
                let (low, high) = (low.wrapping_sub(addend), high.wrapping_sub(addend));
                if low <= high {
                    [Some(Range(inner, low, high)), None]
                } else {
                    [Some(Range(inner, low, u16::MAX)), Some(Range(inner, 0, high))]
                }
            }
            Node::Const(_) | Node::Free(_) | Node::Bits(_) => [None, None],
        };
        let missing = parts.into_iter().flatten().any(|part| self.answer(part).is_none());
        (parts, missing)
    }

    fn combine(&self, circuit: &mut Circuit, range: Range, parts: [Option<Range>; 2]) -> Lit {
        let Range(word, low, high) = range;
        let [first, second] = parts.map(|part| part.and_then(|part| self.answer(part)));
        match self.node(word) {
            Node::Const(value) => Lit::constant((low..=high).contains(&value)),
            Node::Free(variable) => {
                let from = circuit.atom(Atom::AtLeast(variable, low));
                let beyond = match high.checked_add(1) {
                    Some(next) => circuit.atom(Atom::AtLeast(variable, next)),
                    None => Lit::FALSE,
                };
                circuit.and(from, !beyond)
            }
            Node::Bits(bits) if low == high => {
                circuit.all((0..16).map(|i| if low >> i & 1 == 1 { bits[i] } else { !bits[i] }))
            }
            Node::Bits(bits) => {
                let from = bits_at_least(circuit, &bits, low);
                let beyond = match high.checked_add(1) {
                    Some(next) => bits_at_least(circuit, &bits, next),
                    None => Lit::FALSE,
                };
                circuit.and(from, !beyond)
            }
            Node::Either(condition, ..) => {
                let known = |lit: Option<Lit>| lit.expect("both sides were answered first");
                circuit.ite(condition, known(first), known(second))
            }
            Node::Plus(..) => circuit.any([first, second].into_iter().flatten()),
        }
    }

    /// The word's bits, the least first.
    pub fn bits(&mut self, circuit: &mut Circuit, word: Word) -> [Lit; 16] {
        let mut open = vec![word];
        while let Some(&word) = open.last() {
            if self.bits.contains_key(&word) {
                open.pop();
                continue;
            }
            let inputs = match self.node(word) {
                Node::Either(_, a, b) => [Some(a), Some(b)],
                Node::Plus(inner, _) => [Some(inner), None],
                _ => [None, None],
            };
            let before = open.len();
            open.extend(
                inputs.into_iter().flatten().filter(|input| !self.bits.contains_key(input)),
            );
            if open.len() > before {
                continue;
            }
            if !self.spend(16) {
                return std::array::from_fn(|_| self.made_up(circuit));
            }
            let bits = match self.node(word) {
                Node::Const(value) => std::array::from_fn(|i| Lit::constant(value >> i & 1 == 1)),
                Node::Free(variable) => {
                    std::array::from_fn(|i| circuit.atom(Atom::WordBit(variable, i as u8)))
                }
                Node::Bits(bits) => bits,
                Node::Either(condition, a, b) => {
                    let (a, b) = (self.bits[&a], self.bits[&b]);
                    std::array::from_fn(|i| circuit.ite(condition, a[i], b[i]))
                }
                Node::Plus(inner, addend) => {
                    let addend = std::array::from_fn(|i| Lit::constant(addend >> i & 1 == 1));
                    let inner = self.bits[&inner];
                    add_bits(circuit, &inner, &addend, Lit::FALSE).0
                }
            };
            self.bits.insert(word, bits);
            open.pop();
        }
        self.bits[&word]
    }

    /// Takes off what is allowed; false if that is used up.
    fn spend(&mut self, work: usize) -> bool {
        self.spent += work;
        let enough = self.allowance >= work;
        self.allowance = self.allowance.saturating_sub(work);
        enough
    }

    /// An answer that nothing else depends on, in place of one that took too much.
    fn made_up(&mut self, circuit: &mut Circuit) -> Lit {
        self.given_up += 1;
        circuit.atom(Atom::Bit(VarId(u32::MAX - self.given_up)))
    }

    fn node(&self, word: Word) -> Node {
        self.nodes[word.0 as usize]
    }

    fn intern(&mut self, node: Node) -> Word {
        if let Some(&word) = self.known.get(&node) {
            return word;
        }
        let word = Word(u32::try_from(self.nodes.len()).expect("too many words"));
        self.nodes.push(node);
        self.known.insert(node, word);
        word
    }
}

/// Whether sixteen bits, unsigned, are at least a constant.
fn bits_at_least(circuit: &mut Circuit, bits: &[Lit; 16], threshold: u16) -> Lit {
    (0..16).fold(Lit::TRUE, |at_least, i| {
        if threshold >> i & 1 == 1 {
            circuit.and(bits[i], at_least)
        } else {
            circuit.or(bits[i], at_least)
        }
    })
}

/// Sum of two words and a carry; the sum's bits and the carry out.
pub fn add_bits(
    circuit: &mut Circuit,
    a: &[Lit; 16],
    b: &[Lit; 16],
    carry: Lit,
) -> ([Lit; 16], Lit) {
    let mut carry = carry;
    let sum = std::array::from_fn(|i| {
        let half = circuit.xor(a[i], b[i]);
        let sum = circuit.xor(half, carry);
        let generate = circuit.and(a[i], b[i]);
        let propagate = circuit.and(half, carry);
        carry = circuit.or(generate, propagate);
        sum
    });
    (sum, carry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::model::Assignment;

    /// Checks a word against a function of one free word, for all questions at some values.
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

//! Answers queries on symbolic words with guards: whether a word lies in a range, its bits, and the carry of a sum.

use super::term::{Carry, CarryDefinition, Gate, Node, Query, Range, Word};
use super::word::Words;
use scanbound_model::{Atom, Circuit, Lit, VarId};

impl Words {
    /// The literal that says whether the word, unsigned, lies in `low..=high`. If the computation exceeds the allowed
    /// steps, it is a new free bit, and [`Words::given_up`] is raised by one.
    pub fn in_range(&mut self, circuit: &mut Circuit, word: Word, low: u16, high: u16) -> Lit {
        self.range_if_allowed(circuit, word, low, high)
            .unwrap_or_else(|| self.arbitrary_bit(circuit))
    }

    /// As [`Words::in_range`], but `None` if the computation exceeds the allowed steps ([`Words::allowance`]).
    pub(super) fn range_if_allowed(
        &mut self,
        circuit: &mut Circuit,
        word: Word,
        low: u16,
        high: u16,
    ) -> Option<Lit> {
        let range = Range(word, low, high);
        self.answer(circuit, Query::Range(range)).then(|| self.known_range(range)).flatten()
    }

    /// The first range query that was answered by this literal. `None` if there is none.
    pub(super) fn range_test(&self, lit: Lit) -> Option<Range> {
        self.answers.asked.get(&lit).copied()
    }

    /// The word's bits, least significant first. If the computation exceeds the allowed steps, they are new free bits,
    /// and [`Words::given_up`] is raised by 16, one for each bit.
    pub fn bits(&mut self, circuit: &mut Circuit, word: Word) -> [Lit; 16] {
        let bits = self.bits_if_allowed(circuit, word);
        bits.unwrap_or_else(|| std::array::from_fn(|_| self.arbitrary_bit(circuit)))
    }

    /// The bits of a word, least significant first; `None` if computing them exceeds the allowed work.
    pub(super) fn bits_if_allowed(
        &mut self,
        circuit: &mut Circuit,
        word: Word,
    ) -> Option<[Lit; 16]> {
        self.answer(circuit, Query::Bits(word)).then(|| self.known_bits(word)).flatten()
    }

    /// Answers a query, and before it the queries on which it depends. Returns `false` if that exceeds the allowed
    /// steps ([`Words::allowance`]).
    ///
    /// It uses no recursion, because words can depend on thousands of others: a step number that a thousand rungs write
    /// is a chain of a thousand words.
    fn answer(&mut self, circuit: &mut Circuit, question: Query) -> bool {
        let mut open = std::mem::take(&mut self.answers.open);
        open.push(question);
        let mut enough = true;
        while let Some(&question) = open.last() {
            if self.is_known(question) {
                open.pop();
                continue;
            }
            enough = self.spend(match question {
                Query::Range(_) => 1,
                Query::Bits(_) | Query::Carry(_) => 8,
            });
            if !enough {
                break;
            }
            let needs = self.needs(question);
            let before = open.len();
            open.extend(needs.into_iter().flatten().filter(|&need| !self.is_known(need)));
            if open.len() == before {
                self.compute(circuit, question);
                open.pop();
            }
        }
        open.clear();
        self.answers.open = open;
        enough
    }

    fn is_known(&self, question: Query) -> bool {
        match question {
            Query::Range(range) => self.known_range(range).is_some(),
            Query::Bits(word) => self.known_bits(word).is_some(),
            Query::Carry(carry) => self.known_carry(carry).is_some(),
        }
    }

    fn known_range(&self, range: Range) -> Option<Lit> {
        let Range(word, low, high) = range;
        match self.node(word) {
            _ if low > high => Some(Lit::FALSE),
            _ if low == 0 && high == u16::MAX => Some(Lit::TRUE),
            Node::Const(value) => Some(Lit::constant((low..=high).contains(&value))),
            _ => self.answers.ranges.get(&range).copied(),
        }
    }

    fn known_bits(&self, word: Word) -> Option<[Lit; 16]> {
        match self.node(word) {
            Node::Const(value) => Some(bits_of(value)),
            Node::Bits(number) => Some(self.bits_of_number(number)),
            _ => self.answers.bits.get(&word).copied(),
        }
    }

    fn known_carry(&self, carry: Carry) -> Option<Lit> {
        match self.carry_of(carry) {
            CarryDefinition::None => Some(Lit::FALSE),
            CarryDefinition::Always => Some(Lit::TRUE),
            _ => self.answers.carries.get(&carry).copied(),
        }
    }

    /// The queries that must be answered before this query can be answered.
    fn needs(&mut self, question: Query) -> [Option<Query>; 4] {
        let range = |word, low, high| Some(Query::Range(Range(word, low, high)));
        let bits = |word| Some(Query::Bits(word));
        match question {
            Query::Range(Range(word, low, high)) => match self.node(word) {
                Node::Either(_, a, b) => [range(a, low, high), range(b, low, high), None, None],
                Node::Plus(inner, addend) => {
                    let [first, second] = before_sum(addend, low, high);
                    let range = |(low, high)| range(inner, low, high);
                    [first.and_then(range), second.and_then(range), None, None]
                }
                Node::Carried(inner, addend, carry) => {
                    let [with, without] = self.possible_sums(inner, addend);
                    let carry = Some(Query::Carry(carry));
                    [carry, range(with, low, high), range(without, low, high), None]
                }
                Node::Sum(..) | Node::Bitwise(..) | Node::Derived(..) => {
                    [bits(word), None, None, None]
                }
                Node::Const(_) | Node::Free(_) | Node::Bits(_) => [None; 4],
            },
            Query::Bits(word) => match self.node(word) {
                Node::Either(_, a, b) | Node::Bitwise(_, a, b) => [bits(a), bits(b), None, None],
                Node::Plus(inner, _) => [bits(inner), None, None, None],
                Node::Sum(a, b, carry) => [bits(a), bits(b), Some(Query::Carry(carry)), None],
                Node::Carried(inner, addend, carry) => {
                    let [with, without] = self.possible_sums(inner, addend);
                    [Some(Query::Carry(carry)), bits(with), bits(without), None]
                }
                Node::Derived(number, _) => {
                    let derived = self.derived_of(number);
                    let mut operands = derived.operands().map(Query::Bits);
                    std::array::from_fn(|_| operands.next())
                }
                Node::Const(_) | Node::Free(_) | Node::Bits(_) => [None; 4],
            },
            Query::Carry(carry) => match self.carry_of(carry) {
                CarryDefinition::None | CarryDefinition::Always => [None; 4],
                CarryDefinition::Sum(a, b, below) => {
                    [bits(a), bits(b), Some(Query::Carry(below)), None]
                }
                CarryDefinition::Carried(word, addend, Carry::NONE) => {
                    [range(word, 0u16.wrapping_sub(addend), u16::MAX), None, None, None]
                }
                CarryDefinition::Carried(word, addend, below) => {
                    let [without, with] = overflows(addend);
                    let range = |(low, high)| range(word, low, high);
                    [Some(Query::Carry(below)), range(without), range(with), None]
                }
            },
        }
    }

    /// Computes an answer from the answers of the queries on which it depends.
    fn compute(&mut self, circuit: &mut Circuit, question: Query) {
        match question {
            Query::Range(range) => self.work_out_range(circuit, range),
            Query::Bits(word) => self.work_out_bits(circuit, word),
            Query::Carry(carry) => self.work_out_carry(circuit, carry),
        }
    }

    fn work_out_range(&mut self, circuit: &mut Circuit, asked: Range) {
        let Range(word, low, high) = asked;
        let within = |words: &Words, word| words.answered_range(Range(word, low, high));
        let lit = match self.node(word) {
            Node::Const(_) => return,
            Node::Free(variable) => {
                let from = circuit.atom(Atom::AtLeast(variable, low));
                let beyond = match high.checked_add(1) {
                    Some(next) => circuit.atom(Atom::AtLeast(variable, next)),
                    None => Lit::FALSE,
                };
                circuit.and(from, !beyond)
            }
            Node::Either(condition, a, b) => {
                let [yes, no] = [a, b].map(|word| within(self, word));
                circuit.ite(condition, yes, no)
            }
            Node::Plus(inner, addend) => {
                let parts = before_sum(addend, low, high).into_iter().flatten();
                let part = |(low, high)| self.answered_range(Range(inner, low, high));
                circuit.any(parts.map(part))
            }
            Node::Carried(inner, addend, carry) => {
                let sums = self.possible_sums(inner, addend);
                let [with, without] = sums.map(|word| within(self, word));
                circuit.ite(self.answered_carry(carry), with, without)
            }
            Node::Bits(_) | Node::Sum(..) | Node::Bitwise(..) | Node::Derived(..) => {
                bits_in_range(circuit, &self.answered_bits(word), low, high)
            }
        };
        self.answers.ranges.insert(asked, lit);
        if !lit.is_constant() {
            self.answers.asked.entry(lit).or_insert(asked);
        }
    }

    fn work_out_bits(&mut self, circuit: &mut Circuit, word: Word) {
        let found = match self.node(word) {
            Node::Const(_) | Node::Bits(_) => return,
            Node::Derived(number, place) => {
                let derived = self.derived_of(number);
                let mut operands = derived.operands().map(|word| self.answered_bits(word));
                let count = usize::from(derived.words);
                let first: Vec<Lit> = operands.by_ref().take(count).flatten().collect();
                let second: Vec<Lit> = operands.flatten().collect();
                let all = derived.bits(circuit, &first, &second);
                let from = 16 * usize::from(place);
                std::array::from_fn(|at| all[from + at])
            }
            Node::Free(variable) => {
                std::array::from_fn(|i| circuit.atom(Atom::WordBit(variable, i as u8)))
            }
            Node::Either(condition, a, b) => {
                let (a, b) = (self.answered_bits(a), self.answered_bits(b));
                std::array::from_fn(|i| circuit.ite(condition, a[i], b[i]))
            }
            Node::Plus(inner, addend) => {
                let inner = self.answered_bits(inner);
                add_bits(circuit, &inner, &bits_of(addend), Lit::FALSE).0
            }
            Node::Bitwise(gate, a, b) => {
                let (a, b) = (self.answered_bits(a), self.answered_bits(b));
                std::array::from_fn(|i| match gate {
                    Gate::And => circuit.and(a[i], b[i]),
                    Gate::Or => circuit.or(a[i], b[i]),
                    Gate::Xor => circuit.xor(a[i], b[i]),
                })
            }
            Node::Sum(a, b, carry) => self.sum_of(circuit, a, b, carry).0,
            Node::Carried(inner, addend, carry) => {
                let sums = self.possible_sums(inner, addend);
                let [with, without] = sums.map(|word| self.answered_bits(word));
                let carry = self.answered_carry(carry);
                std::array::from_fn(|i| circuit.ite(carry, with[i], without[i]))
            }
        };
        self.answers.bits.insert(word, found);
    }

    fn work_out_carry(&mut self, circuit: &mut Circuit, carry: Carry) {
        let lit = match self.carry_of(carry) {
            CarryDefinition::None | CarryDefinition::Always => return,
            CarryDefinition::Sum(a, b, below) => self.sum_of(circuit, a, b, below).1,
            CarryDefinition::Carried(word, addend, below) => {
                let [without, with] = overflows(addend);
                let within = |(low, high)| self.answered_range(Range(word, low, high));
                match below {
                    Carry::NONE => within(without),
                    _ => circuit.ite(self.answered_carry(below), within(with), within(without)),
                }
            }
        };
        self.answers.carries.insert(carry, lit);
    }

    /// The bits of a sum of two words and a carry, and the carry out.
    fn sum_of(&self, circuit: &mut Circuit, a: Word, b: Word, carry: Carry) -> ([Lit; 16], Lit) {
        let carry = self.answered_carry(carry);
        add_bits(circuit, &self.answered_bits(a), &self.answered_bits(b), carry)
    }

    fn answered_range(&self, range: Range) -> Lit {
        self.known_range(range).expect("it was answered before")
    }

    fn answered_bits(&self, word: Word) -> [Lit; 16] {
        self.known_bits(word).expect("they were answered before")
    }

    fn answered_carry(&self, carry: Carry) -> Lit {
        self.known_carry(carry).expect("it was answered before")
    }

    /// The two possible sums of a word and a constant: with and without a carry.
    fn possible_sums(&mut self, word: Word, addend: u16) -> [Word; 2] {
        [self.plus(word, addend.wrapping_add(1)), self.plus(word, addend)]
    }

    /// A new free bit in place of an answer that would take more than the allowed work. The model is discarded in this
    /// case.
    fn arbitrary_bit(&mut self, circuit: &mut Circuit) -> Lit {
        self.given_up += 1;
        circuit.atom(Atom::Bit(VarId(u32::MAX - self.given_up)))
    }
}

/// The ranges in which a word lies exactly if its sum with a constant lies in this range; two ranges if the sum wraps
/// around.
fn before_sum(addend: u16, low: u16, high: u16) -> [Option<(u16, u16)>; 2] {
    let (low, high) = (low.wrapping_sub(addend), high.wrapping_sub(addend));
    if low <= high { [Some((low, high)), None] } else { [Some((low, u16::MAX)), Some((0, high))] }
}

/// The ranges of a word in which adding `addend` overflows: without a carry, and with a carry.
fn overflows(addend: u16) -> [(u16, u16); 2] {
    let without = if addend == 0 { (1, 0) } else { (0u16.wrapping_sub(addend), u16::MAX) };
    [without, (u16::MAX - addend, u16::MAX)]
}

/// The bits of a constant.
fn bits_of(value: u16) -> [Lit; 16] {
    std::array::from_fn(|i| Lit::constant(value >> i & 1 == 1))
}

/// The literal that says whether the number in sixteen bits, unsigned, lies in `low..=high`.
fn bits_in_range(circuit: &mut Circuit, bits: &[Lit; 16], low: u16, high: u16) -> Lit {
    if low == high {
        return circuit.all((0..16).map(|i| if low >> i & 1 == 1 { bits[i] } else { !bits[i] }));
    }
    let from = bits_at_least(circuit, bits, low);
    let beyond = match high.checked_add(1) {
        Some(next) => bits_at_least(circuit, bits, next),
        None => Lit::FALSE,
    };
    circuit.and(from, !beyond)
}

/// The literal that says whether the number in sixteen bits, unsigned, is at least `threshold`.
fn bits_at_least(circuit: &mut Circuit, bits: &[Lit; 16], threshold: u16) -> Lit {
    (0..16).fold(Lit::TRUE, |at_least, i| {
        if threshold >> i & 1 == 1 {
            circuit.and(bits[i], at_least)
        } else {
            circuit.or(bits[i], at_least)
        }
    })
}

/// A ripple-carry adder for two words: the bits of the sum and the carry out.
fn add_bits(circuit: &mut Circuit, a: &[Lit; 16], b: &[Lit; 16], carry: Lit) -> ([Lit; 16], Lit) {
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

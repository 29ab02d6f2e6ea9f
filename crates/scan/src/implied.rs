//! What follows where a condition (a literal, mostly a guard) is true, found from its structure without a solver.

use super::intervals::Intervals;
use super::term::{Carry, Gate, Node, Range, Word};
use super::word::Words;
use rustc_hash::{FxHashMap, FxHashSet};
use scanbound_base::word_interval::WordInterval;
use scanbound_model::{Atom, Circuit, Lit, VarId};
use std::cell::RefCell;
use std::rc::Rc;

/// The largest number of conjuncts of a condition that are examined.
const MAX_PARTS: usize = 2048;
/// The largest number of parts of a word that are examined to find its interval.
const MAX_WORD_PARTS: usize = 256;
/// The largest recursion depth when testing whether a literal is implied.
const DEEPEST: u32 = 5;
/// The largest number of steps in simplifying a literal, and of assumptions about words in a search for an interval.
const MAX_CHOICES: usize = 64;
/// The largest number of if-then-else words that one simplification examines to remove branches that are not taken.
const MAX_REMOVED: u32 = 16;
/// The largest depth to which the interval of a word's part is computed under the condition. Below it, the interval
/// that holds in every scan is used.
const DEEPEST_PART: u32 = 8;

/// What is known where a condition is true: literals that are all true there, and the ranges of words that follow from
/// them. It is not complete; what is missing is unknown.
#[derive(Debug, Default, Clone)]
pub struct Implications {
    parts: FxHashSet<Lit>,
    /// The unsigned ranges of free words that the condition implies.
    ranges: FxHashMap<VarId, (u16, u16)>,
    /// The intervals of words that follow from literals that are answers to range queries.
    words: FxHashMap<Word, WordInterval>,
    /// What holds in every scan, in addition; `None` if this value is itself what holds in every scan.
    always: Option<Rc<Implications>>,
    /// Cache: for each literal that was asked, its value where the condition is true; `None` if not determined.
    asked: RefCell<FxHashMap<Lit, Option<bool>>>,
}

impl Implications {
    /// What the constraints imply. As they hold in every scan, so does this.
    pub fn always(circuit: &Circuit, words: &Words, constraints: &[Lit]) -> Implications {
        let mut given = Implications::default();
        given.take(circuit, words, constraints.to_vec(), MAX_PARTS + 8 * constraints.len());
        given
    }

    /// What is implied by a condition, in addition to what holds in every scan.
    pub fn by(
        circuit: &Circuit,
        words: &Words,
        always: &Rc<Implications>,
        condition: Lit,
    ) -> Implications {
        let mut given = Implications { always: Some(always.clone()), ..Implications::default() };
        given.take(circuit, words, vec![condition], MAX_PARTS);
        given
    }

    fn take(&mut self, circuit: &Circuit, words: &Words, mut open: Vec<Lit>, most: usize) {
        while let Some(part) = open.pop() {
            if part == Lit::TRUE || self.parts.len() >= most || !self.parts.insert(part) {
                continue;
            }
            self.keep(words, part);
            match (circuit.node(part), part.is_negated()) {
                (scanbound_model::Node::And(a, b), false) => open.extend([a, b]),
                (scanbound_model::Node::Atom(Atom::AtLeast(word, least)), is_below) => {
                    let (low, high) = self.ranges.entry(word).or_insert((0, u16::MAX));
                    match is_below {
                        false => *low = least.max(*low),
                        true => *high = least.saturating_sub(1).min(*high),
                    }
                }
                _ => {}
            }
        }
    }

    fn has(&self, part: Lit) -> bool {
        self.parts.contains(&part) || self.always.as_ref().is_some_and(|always| always.has(part))
    }

    /// A word that has the same value wherever the condition of these implications holds, with the outer if-then-else
    /// removed where the condition decides it; a constant if the value is known.
    pub fn word_within(&self, circuit: &Circuit, words: &mut Words, word: Word) -> Word {
        let single = |(low, high): (u16, u16)| (low == high).then_some(low);
        if let Some(value) = self.word(word).as_constant() {
            return words.constant(value);
        }
        let mut word = word;
        while let Node::Either(condition, then, other) = words.node(word) {
            word = match () {
                () if self.holds(circuit, words, condition) => then,
                () if self.holds(circuit, words, !condition) => other,
                () => break,
            };
        }
        match words.node(word) {
            Node::Free(variable) => match single(self.range(variable)) {
                Some(value) => words.constant(value),
                None => word,
            },
            _ => word,
        }
    }

    /// A word that has the same value wherever the condition of these implications holds, without the if-then-else
    /// branches that are not taken there; at most [`MAX_REMOVED`] are examined. `known` caches results for this
    /// condition.
    pub fn simplified(
        &self,
        circuit: &Circuit,
        words: &mut Words,
        word: Word,
        known: &mut FxHashMap<Word, Word>,
    ) -> Word {
        let outer = self.word_within(circuit, words, word);
        let (short, _) = self.simplify(circuit, words, outer, known, &mut { MAX_REMOVED });
        // The same word must always be simplified to the same one, however much of it is examined: what a comparison
        // says of the simplified word is found again only by this word.
        known.extend([(outer, short), (short, short)]);
        short
    }

    /// The simplified word, and whether all of its if-then-else branches were examined; `left` is how many still may
    /// be.
    fn simplify(
        &self,
        circuit: &Circuit,
        words: &mut Words,
        word: Word,
        known: &mut FxHashMap<Word, Word>,
        left: &mut u32,
    ) -> (Word, bool) {
        let Node::Either(condition, then, other) = words.node(word) else { return (word, true) };
        if let Some(&known) = known.get(&word) {
            return (known, true);
        }
        if *left == 0 {
            return (word, false);
        }
        *left -= 1;
        let (found, whole) = match self.within(circuit, words, condition) {
            Lit::TRUE => self.simplify(circuit, words, then, known, left),
            Lit::FALSE => self.simplify(circuit, words, other, known, left),
            condition => {
                let (other, all) = self.simplify(circuit, words, other, known, left);
                let (then, both) = self.simplify(circuit, words, then, known, left);
                (words.either(condition, then, other), all && both)
            }
        };
        if whole {
            known.insert(word, found);
        }
        (found, whole)
    }

    /// The values that a word can have where the condition of these implications holds, each with the literal that says
    /// whether the word has it. `None` if there are more than `most`, if too many parts would have to be examined, or
    /// if the word is computed from one whose values are not listed here.
    pub fn possible_values(
        &self,
        circuit: &mut Circuit,
        words: &mut Words,
        word: Word,
        most: usize,
    ) -> Option<Vec<(Lit, u16)>> {
        let mut found: Vec<(Lit, u16)> = Vec::new();
        let mut open = vec![(Lit::TRUE, self.word_within(circuit, words, word), 0u16)];
        let mut looked = 0;
        while let Some((holds, word, addend)) = open.pop() {
            looked += 1;
            if looked > 4 * most {
                return None;
            }
            match words.node(word) {
                Node::Const(value) => {
                    add_case(circuit, &mut found, most, (holds, value.wrapping_add(addend)))?;
                }
                Node::Plus(inner, more) => {
                    let inner = self.word_within(circuit, words, inner);
                    open.push((holds, inner, addend.wrapping_add(more)));
                }
                Node::Either(condition, then, other) => {
                    for (condition, word) in [(condition, then), (!condition, other)] {
                        let holds = circuit.and(holds, condition);
                        if holds != Lit::FALSE {
                            open.push((holds, self.word_within(circuit, words, word), addend));
                        }
                    }
                }
                Node::Free(variable) => {
                    let (low, high) = self.range(variable);
                    if low > high || usize::from(high - low) >= most {
                        return None;
                    }
                    for value in low..=high {
                        let from = circuit.atom(Atom::AtLeast(variable, value));
                        let beyond = match value.checked_add(1) {
                            Some(next) => circuit.atom(Atom::AtLeast(variable, next)),
                            None => Lit::FALSE,
                        };
                        let here = circuit.and(from, !beyond);
                        let holds = circuit.and(holds, here);
                        add_case(circuit, &mut found, most, (holds, value.wrapping_add(addend)))?;
                    }
                }
                Node::Sum(a, b, Carry::NONE) => {
                    let few = most.min(8);
                    let (first, second) = (
                        self.possible_values(circuit, words, a, few)?,
                        self.possible_values(circuit, words, b, few)?,
                    );
                    for &(one, a) in &first {
                        for &(other, b) in &second {
                            let both = circuit.and(one, other);
                            let holds = circuit.and(holds, both);
                            let value = a.wrapping_add(b).wrapping_add(addend);
                            add_case(circuit, &mut found, most, (holds, value))?;
                        }
                    }
                }
                _ => return None,
            }
        }
        Some(found)
    }

    /// Records the interval of a word if this literal, which is true, is the answer to a range query or its negation.
    fn keep(&mut self, words: &Words, part: Lit) {
        if let Some((word, ring)) = interval_of_literal(words, part) {
            let known = self.words.entry(word).or_insert(WordInterval::TOP);
            *known = known.meet(ring);
        }
    }

    /// Applies what is known about simplified words also to the original words. `before` maps a simplified word to the
    /// original, and the condition under which both are equal.
    pub fn apply_to_originals(
        &mut self,
        before: &FxHashMap<Word, (Word, Lit)>,
        circuit: &Circuit,
        words: &Words,
    ) {
        let known: Vec<(Word, WordInterval)> =
            self.words.iter().map(|(&word, &ring)| (word, ring)).collect();
        for (short, ring) in known {
            self.asked.get_mut().clear();
            if let Some(&(word, under)) = before.get(&short)
                && self.holds(circuit, words, under)
            {
                let known = self.words.entry(word).or_insert(WordInterval::TOP);
                *known = known.meet(ring);
            }
        }
    }

    /// The interval of a word that follows from range queries on this very word, not on its parts.
    pub fn word(&self, word: Word) -> WordInterval {
        let known = self.words.get(&word).copied().unwrap_or(WordInterval::TOP);
        self.always.as_ref().map_or(known, |always| known.meet(always.word(word)))
    }

    /// Computes the intervals of a word and of the words of which it is a sum or among which it selects, each once, and
    /// stores them in `spans`.
    pub fn compute(&self, circuit: &Circuit, words: &Words, spans: &mut Intervals, word: Word) {
        let mut open = vec![word];
        while let Some(&word) = open.last() {
            let parts: [Option<Word>; 2] = match words.node(word) {
                _ if !spans.is_open(word) => [None, None],
                Node::Plus(inner, _) => [Some(inner), None],
                Node::Sum(a, b, Carry::NONE) | Node::Either(_, a, b) => [Some(a), Some(b)],
                _ => [None, None],
            };
            let before = open.len();
            open.extend(parts.into_iter().flatten().filter(|&part| spans.is_open(part)));
            if open.len() > before {
                continue;
            }
            open.pop();
            if spans.is_open(word) {
                let found = self.span(circuit, words, spans, word);
                spans.store(word, found);
            }
        }
    }

    /// An interval that contains the values of a word where the condition of these implications holds. `spans` has
    /// intervals that hold in every scan.
    pub fn span(
        &self,
        circuit: &Circuit,
        words: &Words,
        spans: &Intervals,
        word: Word,
    ) -> WordInterval {
        let mut looking =
            IntervalSearch { circuit, words, spans, said_more: Vec::new(), looked: 0 };
        self.span_where(&mut looking, word, 0)
    }

    /// As [`Implications::span`], with the assumptions of the if-then-else branches on the way to this part.
    fn span_where(&self, looking: &mut IntervalSearch<'_>, word: Word, depth: u32) -> WordInterval {
        let IntervalSearch { circuit, words, .. } = *looking;
        let more = looking.said_more.iter().filter(|(of, _)| *of == word).map(|(_, ring)| *ring);
        let known = more.fold(self.word(word), WordInterval::meet).meet(looking.spans.known(word));
        looking.looked += 1;
        if looking.looked > MAX_WORD_PARTS
            || depth > DEEPEST_PART
            || looking.said_more.len() > MAX_CHOICES
        {
            return known;
        }
        let found = match words.node(word) {
            Node::Const(value) => WordInterval::constant(value),
            Node::Free(variable) => {
                let (low, high) = self.range(variable);
                WordInterval::of(low.into(), high.into())
            }
            Node::Plus(inner, addend) => self
                .span_where(looking, inner, depth + 1)
                .wrapping_add(WordInterval::constant(addend)),
            Node::Sum(a, b, Carry::NONE) => {
                let a = self.span_where(looking, a, depth + 1);
                a.wrapping_add(self.span_where(looking, b, depth + 1))
            }
            Node::Either(condition, then, other) => {
                let mut both: Option<WordInterval> = None;
                for (condition, word) in [(condition, then), (!condition, other)] {
                    let condition = self.within(circuit, words, condition);
                    if condition == Lit::FALSE {
                        continue;
                    }
                    let before = looking.said_more.len();
                    conjuncts(circuit, condition, 3, &mut |part| {
                        looking.said_more.extend(interval_of_literal(words, part));
                    });
                    let one = self.span_where(looking, word, depth + 1);
                    looking.said_more.truncate(before);
                    both = Some(both.map_or(one, |both| both.join(one)));
                }
                both.unwrap_or(WordInterval::TOP)
            }
            Node::Bitwise(Gate::And, a, b) => {
                let [a, b] = [a, b].map(|word| words.as_constant(word));
                a.or(b).map_or(WordInterval::TOP, |mask| WordInterval::of(0, mask.into()))
            }
            Node::Bits(number) => {
                let bits = words.bits_of_number(number);
                let most = bits.iter().enumerate().filter(|(_, bit)| **bit != Lit::FALSE);
                WordInterval::of(0, most.map(|(place, _)| 1 << place).sum())
            }
            Node::Bitwise(..) | Node::Sum(..) | Node::Carried(..) | Node::Derived(..) => {
                WordInterval::TOP
            }
        };
        found.meet(known)
    }

    /// The unsigned range (inclusive) of a free word where the condition of these implications holds.
    pub fn range(&self, word: VarId) -> (u16, u16) {
        let (low, high) = self.ranges.get(&word).copied().unwrap_or((0, u16::MAX));
        let always = self.always.as_ref().map_or((0, u16::MAX), |always| always.range(word));
        (low.max(always.0), high.min(always.1))
    }

    /// Whether the literal is known to be true where the condition of these implications holds. `false` may also mean
    /// that it is unknown.
    pub fn holds(&self, circuit: &Circuit, words: &Words, lit: Lit) -> bool {
        self.certain_value(circuit, words, lit) == Some(true)
    }

    /// The value of a literal where the condition of these implications holds, from the cache or computed; `None` if it
    /// is not determined.
    fn certain_value(&self, circuit: &Circuit, words: &Words, lit: Lit) -> Option<bool> {
        if let Some(&known) = self.asked.borrow().get(&lit) {
            return known;
        }
        let value = self.value(circuit, words, lit, DEEPEST);
        self.asked.borrow_mut().insert(lit, value);
        value
    }

    /// The value of a literal where the condition of these implications holds; `None` if the condition does not
    /// determine it, or if that would need more than `depth` levels of gates.
    fn value(&self, circuit: &Circuit, words: &Words, lit: Lit, depth: u32) -> Option<bool> {
        if lit.is_constant() {
            return Some(lit == Lit::TRUE);
        }
        if self.has(lit) {
            return Some(true);
        }
        if self.has(!lit) {
            return Some(false);
        }
        for (asked, is) in [(lit, true), (!lit, false)] {
            let Some(Range(word, low, high)) = words.range_test(asked) else { continue };
            let (known, asked) = (self.word(word), WordInterval::of(low.into(), high.into()));
            if asked.contains(known) {
                return Some(is);
            }
            if asked.is_disjoint(known) {
                return Some(!is);
            }
        }
        let value = match circuit.node(lit) {
            scanbound_model::Node::And(a, b) if depth > 0 => {
                match self.value(circuit, words, a, depth - 1) {
                    Some(false) => Some(false),
                    first => match (first, self.value(circuit, words, b, depth - 1)) {
                        (_, Some(false)) => Some(false),
                        (Some(true), Some(true)) => Some(true),
                        _ => None,
                    },
                }
            }
            scanbound_model::Node::Atom(Atom::AtLeast(word, least)) => {
                let (low, high) = self.range(word);
                match () {
                    () if low >= least => Some(true),
                    () if high < least => Some(false),
                    () => None,
                }
            }
            _ => None,
        };
        value.map(|value| value != lit.is_negated())
    }

    /// A literal that has the same value wherever the condition of these implications holds; simpler if possible.
    pub fn within(&self, circuit: &Circuit, words: &Words, lit: Lit) -> Lit {
        let mut lit = lit;
        for _ in 0..MAX_CHOICES {
            if let Some(value) = self.certain_value(circuit, words, lit) {
                return Lit::constant(value);
            }
            let scanbound_model::Node::And(a, b) = circuit.node(lit) else { return lit };
            let rest = match (self.holds(circuit, words, a), self.holds(circuit, words, b)) {
                (true, _) => b,
                (_, true) => a,
                _ => return lit,
            };
            lit = if lit.is_negated() { !rest } else { rest };
        }
        lit
    }
}

/// The state of a search for the interval of a word.
struct IntervalSearch<'a> {
    circuit: &'a Circuit,
    words: &'a Words,
    /// The intervals of words that are valid in every scan.
    spans: &'a Intervals,
    /// The words and intervals that follow from the conditions of the if-then-else branches on the way to this part.
    said_more: Vec<(Word, WordInterval)>,
    /// The number of expressions that the search has examined.
    looked: usize,
}

/// Adds a value to the possible values of a word; `None` if there are then more than `most`.
fn add_case(
    circuit: &mut Circuit,
    cases: &mut Vec<(Lit, u16)>,
    most: usize,
    (holds, value): (Lit, u16),
) -> Option<()> {
    match cases.iter().position(|&(_, known)| known == value) {
        Some(place) => cases[place].0 = circuit.or(cases[place].0, holds),
        None if cases.len() < most => cases.push((holds, value)),
        None => return None,
    }
    Some(())
}

/// The word and its interval, if the literal says that a word lies in a range or outside it.
fn interval_of_literal(words: &Words, part: Lit) -> Option<(Word, WordInterval)> {
    if let Some(Range(word, low, high)) = words.range_test(part) {
        return Some((word, WordInterval::of(low.into(), high.into())));
    }
    let Range(word, low, high) = words.range_test(!part)?;
    Some((word, WordInterval::all_except(low, high)))
}

/// Calls `see` with a condition, its conjuncts, their conjuncts and so on, down to `depth` levels.
fn conjuncts(circuit: &Circuit, condition: Lit, depth: u32, see: &mut dyn FnMut(Lit)) {
    see(condition);
    if let (false, scanbound_model::Node::And(a, b), 1..) =
        (condition.is_negated(), circuit.node(condition), depth)
    {
        conjuncts(circuit, a, depth - 1, see);
        conjuncts(circuit, b, depth - 1, see);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_model::Assignment;

    /// The next pseudo-random number, less than `most`.
    fn next(seed: &mut u64, most: u64) -> u64 {
        *seed =
            seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 33) % most
    }

    const VALUES: [u16; 10] = [0, 1, 3, 4, 5, 7, 100, 0x7FFF, 0x8000, 0xFFFF];

    fn value(seed: &mut u64) -> u16 {
        VALUES[next(seed, 10) as usize]
    }

    /// Random words and literals computed from two free words and three bits, and from each other.
    fn grown(seed: &mut u64) -> (Words, Circuit, Vec<Word>, Vec<Lit>) {
        let (mut words, mut circuit) = (Words::default(), Circuit::default());
        let mut all: Vec<Word> = (0..2).map(|variable| words.free(VarId(variable))).collect();
        let mut lits: Vec<Lit> =
            (2..5).map(|variable| circuit.atom(Atom::Bit(VarId(variable)))).collect();
        for _ in 0..24 {
            let lit = |seed: &mut u64| {
                let lit = lits[next(seed, lits.len() as u64) as usize];
                if next(seed, 2) == 0 { lit } else { !lit }
            };
            let word = |seed: &mut u64| all[next(seed, all.len() as u64) as usize];
            match next(seed, 8) {
                0 | 1 => {
                    let (a, b) = (lit(seed), lit(seed));
                    let lit = circuit.and(a, b);
                    lits.push(lit);
                }
                2..=4 => {
                    let (a, b) = (value(seed), value(seed));
                    let asked = word(seed);
                    let lit = words.in_range(&mut circuit, asked, a.min(b), a.max(b));
                    lits.push(lit);
                }
                5 | 6 => {
                    let (condition, then) = (lit(seed), word(seed));
                    let other =
                        if next(seed, 2) == 0 { words.constant(value(seed)) } else { word(seed) };
                    all.push(words.either(condition, other, then));
                }
                _ => {
                    let (a, b) = (word(seed), word(seed));
                    let sum = match next(seed, 3) {
                        0 => words.sum(a, b, Carry::NONE).0,
                        1 => words.bitwise(Gate::And, a, b),
                        _ => words.plus(a, value(seed)),
                    };
                    all.push(sum);
                }
            }
        }
        (words, circuit, all, lits)
    }

    /// Whatever is said to follow from a condition is true in every assignment in which the condition is true.
    #[test]
    fn what_a_condition_implies_holds_wherever_it_does() {
        let mut seed = 7;
        let (mut met, mut closer, mut shorter, mut told) = (0, 0, 0, 0);
        for _ in 0..800 {
            let (mut words, mut circuit, all, lits) = grown(&mut seed);
            let condition = lits[next(&mut seed, lits.len() as u64) as usize];
            let other = lits[next(&mut seed, lits.len() as u64) as usize];
            let condition = circuit.and(condition, other);
            let constraint = lits[next(&mut seed, lits.len() as u64) as usize];
            let always = Rc::new(Implications::always(&circuit, &words, &[constraint]));
            let given = Implications::by(&circuit, &words, &always, condition);
            let mut spans = Intervals::default();
            let lits: Vec<(Lit, Lit)> =
                lits.iter().map(|&lit| (lit, given.within(&circuit, &words, lit))).collect();
            shorter += lits.iter().filter(|(lit, within)| lit != within).count();
            let mut asked = Vec::new();
            for &word in &all {
                let within = given.word_within(&circuit, &mut words, word);
                let cases = given.possible_values(&mut circuit, &mut words, word, 8);
                always.compute(&circuit, &words, &mut spans, word);
                let span = given.span(&circuit, &words, &spans, word);
                closer += usize::from(span != WordInterval::TOP);
                told += usize::from(cases.is_some());
                let [bits, same] = [word, within].map(|word| words.bits(&mut circuit, word));
                asked.push((bits, same, cases, span));
            }
            for _ in 0..60 {
                let bit = |seed: &mut u64| next(seed, 2) as u16;
                let assignment = Assignment(vec![
                    value(&mut seed),
                    value(&mut seed),
                    bit(&mut seed),
                    bit(&mut seed),
                    bit(&mut seed),
                ]);
                let values = circuit.evaluate(&assignment);
                if !values.get(condition) || !values.get(constraint) {
                    continue;
                }
                met += 1;
                for &(lit, within) in &lits {
                    assert_eq!(values.get(lit), values.get(within));
                }
                let number = |bits: &[Lit; 16]| {
                    (0..16).fold(0, |n, i| n | u16::from(values.get(bits[i])) << i)
                };
                for (bits, same, cases, span) in &asked {
                    let value = number(bits);
                    assert_eq!(value, number(same));
                    assert!(
                        span.contains(WordInterval::constant(value)),
                        "{value} is not in {span:?}"
                    );
                    let Some(cases) = cases else { continue };
                    let holding = cases.iter().filter(|(holds, _)| values.get(*holds));
                    assert_eq!(holding.map(|case| case.1).collect::<Vec<u16>>(), [value]);
                }
            }
        }
        assert!(
            met > 2_000 && closer > 1_000 && shorter > 500 && told > 500,
            "{met} {closer} {shorter} {told}"
        );
    }
}

//! What is known while a condition holds: ranges of words, and the bits and comparisons of which it is composed.

use super::value::Value;
use std::rc::Rc;

/// The largest number of literals of a conjunction that are kept. The other literals are forgotten, so that it is no
/// longer exact.
const MAX_LITERALS: usize = 24;

/// The values that a word may have while some condition is true (or false). It no longer applies after the next write
/// of the word, which has another stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WordFact {
    /// The slot of the word: its index among the tracked words.
    pub slot: usize,
    /// Identifies the write that gave the word this value.
    pub stamp: u32,
    /// The values that the word may have.
    pub value: Value,
}

/// A Boolean value at one moment of the scan, or its negation: the value of a bit since its last write, or the result
/// of a contact or comparison at its last execution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Literal {
    /// The bit's slot, its index among the tracked bits; `None` for the result of a contact or comparison.
    pub bit: Option<usize>,
    /// Identifies the write of the bit, or the execution of the contact or comparison.
    pub stamp: u32,
    /// `false` for a negated literal.
    pub on: bool,
}

impl Literal {
    /// The negation of the literal.
    fn negated(self) -> Literal {
        Literal { on: !self.on, ..self }
    }
}

/// What is known about a Boolean value, such as the result of a rung: whether it is constant, the literals of which it
/// is composed, and the facts about words that follow from it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Condition {
    /// Whether the condition is known to be true whenever this instruction is reached.
    pub surely: bool,
    /// Whether the condition is known to be false whenever this instruction is reached.
    pub never: bool,
    /// What is known about words while the condition is true. `None`: nothing.
    known: Option<Rc<[WordFact]>>,
    /// Literals that are true whenever the condition is true. `None` if no such literal is known.
    literals: Option<Rc<[Literal]>>,
    /// Whether the condition is equivalent to the conjunction of `literals`.
    exact: bool,
    /// What is known about words while the condition is false and the literals of `context` are true. `None`: nothing.
    off: Option<Rc<[WordFact]>>,
    /// The literals that must be true so that the facts in `off` hold. `None`: these facts hold everywhere.
    context: Option<Rc<[Literal]>>,
    /// For each literal of the condition that says something about words when it is false: what it then says. `None` if
    /// there is no such literal.
    denied: Option<Rc<[FactsIfFalse]>>,
}

/// What is known about words if a certain literal is false.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FactsIfFalse {
    literal: Literal,
    known: Rc<[WordFact]>,
    /// The literals that must be true so that the facts hold. `None`: the facts need no further literal.
    context: Option<Rc<[Literal]>>,
}

fn chained<T: Clone + PartialEq>(a: Option<&Rc<[T]>>, b: Option<&Rc<[T]>>) -> Option<Rc<[T]>> {
    match (a, b) {
        (None, one) | (one, None) => one.cloned(),
        (Some(a), Some(b)) if Rc::ptr_eq(a, b) => Some(Rc::clone(a)),
        (Some(a), Some(b)) => {
            Some(a.iter().chain(b.iter().filter(|one| !a.contains(one))).cloned().collect())
        }
    }
}

impl Condition {
    /// A condition that is always true.
    pub fn always() -> Condition {
        Condition { surely: true, exact: true, ..Condition::default() }
    }

    /// A condition that is always true, or always false.
    pub fn constant(value: bool) -> Condition {
        Condition { surely: value, never: !value, exact: value, ..Condition::default() }
    }

    /// A condition that is equivalent to one literal.
    pub fn literal(literal: Literal) -> Condition {
        Condition { literals: Some([literal].into()), exact: true, ..Condition::default() }
    }

    /// A condition that is equivalent to the conjunction of these literals; `literal` comes first.
    pub fn of(literal: Literal, others: &[Literal]) -> Condition {
        let others = others.iter().copied().filter(|other| *other != literal);
        let all: Rc<[Literal]> = std::iter::once(literal).chain(others).collect();
        Condition { literals: Some(all), exact: true, ..Condition::default() }
    }

    /// Adds facts that hold while the condition is true.
    pub fn with_facts(mut self, known: impl Iterator<Item = WordFact>) -> Condition {
        let more: Rc<[WordFact]> = known.collect();
        self.known = chained(self.known.as_ref(), Some(&more)).filter(|known| !known.is_empty());
        self
    }

    /// Adds facts that hold while the condition is false, and limits all its facts to states in which the literals of
    /// `context` are true.
    pub fn with_facts_if_false(
        mut self,
        known: impl Iterator<Item = WordFact>,
        context: &[Literal],
    ) -> Condition {
        let off: Rc<[WordFact]> = known.collect();
        self.off = Some(off).filter(|off| !off.is_empty());
        self.context = (!context.is_empty()).then(|| context.into());
        self.deny_own();
        self
    }

    /// If the condition is one literal: moves what is known while the condition is false to that literal.
    fn deny_own(&mut self) {
        if let (true, [literal, ..], Some(off)) = (self.exact, self.literals(), &self.off) {
            let (known, context) = (Rc::clone(off), self.context.clone());
            let own = FactsIfFalse { literal: *literal, known, context };
            self.denied = Some([own].into());
        }
    }

    /// Literals that are true whenever the condition is true.
    pub fn literals(&self) -> &[Literal] {
        self.literals.as_deref().unwrap_or(&[])
    }

    /// The literals to whose conjunction the condition is equivalent; `None` if that is not known.
    pub fn conjunction(&self) -> Option<Rc<[Literal]>> {
        self.literals.clone().filter(|_| self.exact)
    }

    /// Facts about words that hold while the condition is true.
    pub fn words(&self) -> &[WordFact] {
        self.known.as_deref().unwrap_or(&[])
    }

    /// Facts about words that hold while the condition is false, whatever else is true.
    pub fn words_off(&self) -> &[WordFact] {
        self.off.as_deref().filter(|_| self.context.is_none()).unwrap_or(&[])
    }

    /// The possible values of a word if `literal` is false and the literals `before` it are true. `None` if nothing is
    /// known.
    fn denied(
        &self,
        literal: Literal,
        before: &[Literal],
        slot: usize,
        stamp: u32,
    ) -> Option<Value> {
        let is_there = |context: &Rc<[Literal]>| context.iter().all(|one| before.contains(one));
        let denied = self.denied.as_deref().unwrap_or(&[]).iter();
        let mut of_it = denied.filter(|denied| denied.literal == literal);
        let denied = of_it.find(|denied| denied.context.as_ref().is_none_or(is_there))?;
        let known = denied.known.iter().filter(|known| known.slot == slot && known.stamp == stamp);
        known.map(|known| known.value).reduce(Value::closer)
    }

    /// The cases in which the condition is false, each with its true literals and the possible values of a word. `None`
    /// if not all cases are known, or if none limits the word.
    pub fn cases_if_false(&self, slot: usize, stamp: u32) -> Option<Vec<(Vec<Literal>, Value)>> {
        self.denied.as_ref()?;
        let literals = self.conjunction()?;
        let way = |(place, &literal): (usize, &Literal)| {
            let before = &literals[..place];
            match self.denied(literal, before, slot, stamp) {
                Some(lies) => (before.to_vec(), lies),
                None => (vec![literal.negated()], Value::TOP),
            }
        };
        let ways: Vec<(Vec<Literal>, Value)> = literals.iter().enumerate().map(way).collect();
        ways.iter().any(|(_, lies)| *lies != Value::TOP).then_some(ways)
    }

    /// The negation, as far as it can be expressed: a constant stays constant, and the negation of a single literal is
    /// exact.
    pub fn negation(&self) -> Condition {
        let literals = match (self.exact, self.literals()) {
            (true, [one]) => Some([one.negated()].into()),
            _ => None,
        };
        let mut opposite = Condition {
            surely: self.never,
            never: self.surely,
            // Facts that hold only in a context are dropped.
            known: self.off.clone().filter(|_| self.context.is_none()),
            exact: literals.is_some() || self.never,
            literals,
            off: self.known.clone(),
            context: self.context.clone(),
            denied: None,
        };
        opposite.deny_own();
        opposite
    }

    /// What is known about the conjunction of two conditions.
    pub fn and(&self, other: &Condition) -> Condition {
        let literals = chained(self.literals.as_ref(), other.literals.as_ref());
        let all = literals.as_ref().is_none_or(|all| all.len() <= MAX_LITERALS);
        Condition {
            surely: self.surely && other.surely,
            never: self.never || other.never,
            known: chained(self.known.as_ref(), other.known.as_ref()),
            literals: if all { literals } else { literals.map(|all| all[..MAX_LITERALS].into()) },
            exact: self.exact && other.exact && all,
            off: match (self.holds_anyway(), other.holds_anyway()) {
                (true, _) => other.off.clone(),
                (_, true) => self.off.clone(),
                _ => None,
            },
            context: chained(self.context.as_ref(), other.context.as_ref()),
            denied: chained(self.denied.as_ref(), other.denied.as_ref()),
        }
    }

    /// Whether the condition is true in every scan, independent of literals.
    fn holds_anyway(&self) -> bool {
        self.surely && self.literals().is_empty()
    }

    /// What is known about the disjunction of two conditions: the literals that both have, and the facts that hold
    /// while both are false. If one of the two is never true, the result is the other.
    pub fn or(&self, other: &Condition) -> Condition {
        match (self.never, other.never) {
            (true, _) => return other.clone(),
            (_, true) => return self.clone(),
            _ => {}
        }
        let both = |literal: &&Literal| other.literals().contains(literal);
        let both: Rc<[Literal]> = self.literals().iter().filter(both).copied().collect();
        let surely = self.surely || other.surely;
        Condition {
            surely,
            never: false,
            known: None,
            literals: Some(both).filter(|both| !surely && !both.is_empty()),
            exact: surely,
            off: chained(self.off.as_ref(), other.off.as_ref()),
            context: chained(self.context.as_ref(), other.context.as_ref()),
            denied: None,
        }
    }

    /// What is known after two paths have joined, on which the value was this one or the other: only whether it is
    /// constant, if they differ.
    pub fn either(&self, other: &Condition) -> Condition {
        if self == other {
            return self.clone();
        }
        Condition {
            surely: self.surely && other.surely,
            never: self.never && other.never,
            ..Condition::default()
        }
    }

    /// Makes sure that literals describe the condition exactly: if they do not, it gets a new literal with this
    /// `stamp`, which must be new.
    pub fn with_literal(self, stamp: impl FnOnce() -> u32) -> Condition {
        if self.surely || self.never || self.exact {
            return self;
        }
        let own = Literal { bit: None, stamp: stamp(), on: true };
        let named = Condition { exact: true, ..Condition::literal(own) }.and(&self);
        // The new literal alone describes the condition.
        let mut named = Condition { exact: true, off: self.off.clone(), denied: None, ..named };
        named.deny_own();
        named
    }
}

/// A write of a word that is executed only under some condition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConditionalWrite {
    /// The write was executed if and only if all these literals are true; `None` if that is unknown.
    pub when: Option<Rc<[Literal]>>,
    /// The value written.
    pub value: Value,
}

/// Whether a conditional write was executed; `ConditionalWrite`: unknown.
pub enum WasExecuted {
    Yes,
    No,
    ConditionalWrite,
}

impl ConditionalWrite {
    /// Whether the write was executed, given that these literals are true.
    pub fn happened(&self, holds: &[Literal]) -> WasExecuted {
        let Some(when) = &self.when else { return WasExecuted::ConditionalWrite };
        if when.iter().any(|one| holds.contains(&one.negated())) {
            WasExecuted::No
        } else if when.iter().all(|one| holds.contains(one)) {
            WasExecuted::Yes
        } else {
            WasExecuted::ConditionalWrite
        }
    }
}

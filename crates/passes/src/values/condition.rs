//! What is known while a condition holds: ranges of words, and which contacts it was seen from.

use super::value::Value;
use std::rc::Rc;

/// A condition of more contacts than these is told apart from others by some of them only.
const MOST_LITERALS: usize = 24;

/// What is known of a word while a condition holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Known {
    /// The word's slot, and the write that its value is from.
    pub slot: usize,
    pub stamp: u32,
    /// What it is one of.
    pub lies: Value,
}

/// A truth value at one moment of the scan, or its negation: what a bit holds since it was last written, or what a contact
/// or comparison gave when it was last come by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Literal {
    /// The bit's slot; `None` for what was seen once.
    pub bit: Option<usize>,
    /// Which write of the bit, or which seeing.
    pub stamp: u32,
    /// Whether it is on.
    pub on: bool,
}

impl Literal {
    /// The opposite.
    fn negated(self) -> Literal {
        Literal { on: !self.on, ..self }
    }
}

/// What is known of a condition.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Condition {
    /// It holds in every scan.
    pub surely: bool,
    /// It holds in none.
    pub never: bool,
    /// What holds with it.
    known: Option<Rc<[Known]>>,
    /// These are true whenever it holds.
    literals: Option<Rc<[Literal]>>,
    /// It holds whenever they are true, too.
    exact: bool,
    /// What holds where it does not.
    off: Option<Rc<[Known]>>,
    /// What is known of it is known where these are true; where nothing is said, anywhere.
    context: Option<Rc<[Literal]>>,
    /// What holds where one of the literals is not true.
    denied: Option<Rc<[Denied]>>,
}

/// What is known of words where a literal is not true.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Denied {
    literal: Literal,
    known: Rc<[Known]>,
    /// Where these are true.
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
    /// What always holds.
    pub fn always() -> Condition {
        Condition { surely: true, exact: true, ..Condition::default() }
    }

    /// What always holds, or never.
    pub fn constant(value: bool) -> Condition {
        Condition { surely: value, never: !value, exact: value, ..Condition::default() }
    }

    /// What holds exactly if this does.
    pub fn literal(literal: Literal) -> Condition {
        Condition { literals: Some([literal].into()), exact: true, ..Condition::default() }
    }

    /// What holds exactly if this does, and the others besides.
    pub fn of(literal: Literal, others: &[Literal]) -> Condition {
        let others = others.iter().copied().filter(|other| *other != literal);
        let all: Rc<[Literal]> = std::iter::once(literal).chain(others).collect();
        Condition { literals: Some(all), exact: true, ..Condition::default() }
    }

    /// A condition that this is known of, besides what it says of itself.
    pub fn knowing(mut self, known: impl Iterator<Item = Known>) -> Condition {
        let more: Rc<[Known]> = known.collect();
        self.known = chained(self.known.as_ref(), Some(&more)).filter(|known| !known.is_empty());
        self
    }

    /// A condition that this is known of where it does not hold, and all that is known of it only where these are true.
    pub fn denying(mut self, known: impl Iterator<Item = Known>, context: &[Literal]) -> Condition {
        let off: Rc<[Known]> = known.collect();
        self.off = Some(off).filter(|off| !off.is_empty());
        self.context = (!context.is_empty()).then(|| context.into());
        self.deny_own();
        self
    }

    /// Where it is one literal, what holds without it holds where that is not true.
    fn deny_own(&mut self) {
        if let (true, [literal, ..], Some(off)) = (self.exact, self.literals(), &self.off) {
            let (known, context) = (Rc::clone(off), self.context.clone());
            let own = Denied { literal: *literal, known, context };
            self.denied = Some([own].into());
        }
    }

    /// What is true whenever it holds.
    pub fn literals(&self) -> &[Literal] {
        self.literals.as_deref().unwrap_or(&[])
    }

    /// The literals of which it is the conjunction, if it is one.
    pub fn conjunction(&self) -> Option<Rc<[Literal]>> {
        self.literals.clone().filter(|_| self.exact)
    }

    /// What it says of words.
    pub fn words(&self) -> &[Known] {
        self.known.as_deref().unwrap_or(&[])
    }

    /// What it says of words wherever it does not hold.
    pub fn words_off(&self) -> &[Known] {
        self.off.as_deref().filter(|_| self.context.is_none()).unwrap_or(&[])
    }

    /// What is said of a value of a word where this literal is not true, and those before it in the condition are.
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
        known.map(|known| known.lies).reduce(Value::closer)
    }

    /// The ways in which it may not hold, if they are all known and one of them says something of a value of a word: what
    /// is true on each, and what that value is one of there.
    pub fn ways_off(&self, slot: usize, stamp: u32) -> Option<Vec<(Vec<Literal>, Value)>> {
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

    /// What can be told of the opposite: decided if it is, and exact if it is of one contact.
    pub fn negation(&self) -> Condition {
        let literals = match (self.exact, self.literals()) {
            (true, [one]) => Some([one.negated()].into()),
            _ => None,
        };
        let mut opposite = Condition {
            surely: self.never,
            never: self.surely,
            // What is known only where something else holds is not said.
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

    /// Both.
    pub fn and(&self, other: &Condition) -> Condition {
        let literals = chained(self.literals.as_ref(), other.literals.as_ref());
        let all = literals.as_ref().is_none_or(|all| all.len() <= MOST_LITERALS);
        Condition {
            surely: self.surely && other.surely,
            never: self.never || other.never,
            known: chained(self.known.as_ref(), other.known.as_ref()),
            literals: if all { literals } else { literals.map(|all| all[..MOST_LITERALS].into()) },
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

    /// Whether it holds in every scan, whatever was seen before.
    fn holds_anyway(&self) -> bool {
        self.surely && self.literals().is_empty()
    }

    /// One at least.
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

    /// One of the two, as two ways meet.
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

    /// The same, told apart from others: with a literal of its own where it is not exactly known by those that it has.
    /// `stamp` is a new one.
    pub fn seen(self, stamp: impl FnOnce() -> u32) -> Condition {
        if self.surely || self.never || self.exact {
            return self;
        }
        let own = Literal { bit: None, stamp: stamp(), on: true };
        let named = Condition { exact: true, ..Condition::literal(own) }.and(&self);
        // That literal alone says all.
        let mut named = Condition { exact: true, off: self.off.clone(), denied: None, ..named };
        named.deny_own();
        named
    }
}

/// What a write put into a word that need not have happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Perhaps {
    /// It happened exactly if all of these were true; `None` if that is not known.
    pub when: Option<Rc<[Literal]>>,
    /// What it wrote.
    pub value: Value,
}

/// Whether something happened, by what holds.
pub enum Happened {
    Yes,
    No,
    Perhaps,
}

impl Perhaps {
    /// Whether it happened where these are true.
    pub fn happened(&self, holds: &[Literal]) -> Happened {
        let Some(when) = &self.when else { return Happened::Perhaps };
        if when.iter().any(|one| holds.contains(&one.negated())) {
            Happened::No
        } else if when.iter().all(|one| holds.contains(one)) {
            Happened::Yes
        } else {
            Happened::Perhaps
        }
    }
}

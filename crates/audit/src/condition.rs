//! Writes a guard (a Boolean expression over free variables) in words: which devices must be on or off, and in which
//! ranges words must be.

use scanbound_model::{Atom, Circuit, Lit, Node, VarId};
use std::collections::BTreeMap;

/// A condition with more terms than this is not written: one that long is not readable.
const LONGEST: usize = 40;

/// The condition under which the literal `guard` is true, in words such as `X0 and D0 = 10`. `name` gives the names of
/// variables. `None` if the condition has too many terms to be readable.
pub fn text(circuit: &Circuit, guard: Lit, name: &dyn Fn(VarId) -> String) -> Option<String> {
    let mut writer = Writer { circuit, name, left: LONGEST };
    Some(writer.formula(guard)?.text(false))
}

/// A condition as a tree of conjunctions and disjunctions. Its leaves are texts.
enum ConditionFormula {
    Leaf(String),
    /// `true`: all of these formulas hold. `false`: at least one of them holds.
    Joined(bool, Vec<ConditionFormula>),
}

impl ConditionFormula {
    fn text(&self, inner: bool) -> String {
        match self {
            ConditionFormula::Leaf(text) => text.clone(),
            ConditionFormula::Joined(all, parts) => {
                let parts: Vec<String> = parts.iter().map(|part| part.text(true)).collect();
                let joined = parts.join(if *all { " and " } else { " or " });
                if inner { format!("({joined})") } else { joined }
            }
        }
    }
}

struct Writer<'a> {
    circuit: &'a Circuit,
    name: &'a dyn Fn(VarId) -> String,
    /// The number of terms that may still be written before the text is too long.
    left: usize,
}

impl Writer<'_> {
    fn formula(&mut self, lit: Lit) -> Option<ConditionFormula> {
        let holds = !lit.is_negated();
        Some(match self.circuit.node(lit) {
            Node::True => ConditionFormula::Leaf(if holds { "always" } else { "never" }.to_owned()),
            Node::Atom(Atom::AtLeast(word, least)) => self.leaf(word, (least, u16::MAX), holds)?,
            Node::Atom(atom) => {
                self.left = self.left.checked_sub(1)?;
                let name = (self.name)(atom.variable());
                let bit = match atom {
                    Atom::WordBit(_, bit) => format!(".{bit:X}"),
                    _ => String::new(),
                };
                ConditionFormula::Leaf(format!("{}{name}{bit}", if holds { "" } else { "not " }))
            }
            Node::And(..) => self.joined(lit, holds)?,
        })
    }

    /// An and-gate (`holds`) or its negation, merged with the and-gates that are its inputs. Comparisons of the same
    /// word are merged into one range. `None` if it has too many terms.
    fn joined(&mut self, gate: Lit, holds: bool) -> Option<ConditionFormula> {
        let mut open = vec![gate.node()];
        let mut ranges: BTreeMap<VarId, (u16, u16)> = BTreeMap::new();
        let mut inputs = Vec::new();
        while let Some(node) = open.pop() {
            let Node::And(a, b) = self.circuit.nodes()[node] else { continue };
            for lit in [b, a] {
                match (self.circuit.node(lit), lit.is_negated()) {
                    (Node::And(..), false) => open.push(lit.node()),
                    (Node::Atom(Atom::AtLeast(word, least)), negated) => {
                        if !ranges.contains_key(&word) {
                            inputs.push((lit, Some(word)));
                        }
                        let range = ranges.entry(word).or_insert((0, u16::MAX));
                        if negated {
                            range.1 = range.1.min(least - 1);
                        } else {
                            range.0 = range.0.max(least);
                        }
                    }
                    _ => inputs.push((lit, None)),
                }
                if inputs.len() > LONGEST {
                    return None;
                }
            }
        }
        // Sort operands by their first use, which is the order a reader expects.
        inputs.sort_by_key(|(lit, _)| lit.node());
        let mut parts = Vec::new();
        for (lit, word) in inputs {
            parts.push(match word {
                Some(word) => self.leaf(word, ranges[&word], holds)?,
                None => self.formula(if holds { lit } else { !lit })?,
            });
        }
        Some(match (parts.len(), parts.pop()) {
            (1, Some(only)) => only,
            (_, last) => {
                parts.extend(last);
                ConditionFormula::Joined(holds, parts)
            }
        })
    }

    /// That a word lies within a range of unsigned numbers (`holds`) or outside of it, written as a comparison of
    /// signed numbers. `None` if no more terms may be written.
    fn leaf(
        &mut self,
        word: VarId,
        (low, high): (u16, u16),
        holds: bool,
    ) -> Option<ConditionFormula> {
        self.left = self.left.checked_sub(1)?;
        let name = (self.name)(word);
        if low > high {
            return Some(ConditionFormula::Leaf(if holds { "never" } else { "always" }.to_owned()));
        }
        // A range from positive to negative numbers is written as the complement of a range around 0.
        let around = low < 0x8000 && high >= 0x8000;
        let (low, high, within) = match around {
            true => (high.wrapping_add(1).cast_signed(), low.wrapping_sub(1).cast_signed(), !holds),
            false => (low.cast_signed(), high.cast_signed(), holds),
        };
        Some(ConditionFormula::Leaf(match (within, low, high) {
            (true, i16::MIN, -1) => format!("{name} < 0"),
            (false, i16::MIN, -1) => format!("{name} >= 0"),
            (true, ..) if low == high => format!("{name} = {low}"),
            (false, ..) if low == high => format!("{name} <> {low}"),
            (true, i16::MIN, _) => format!("{name} <= {high}"),
            (false, i16::MIN, _) => format!("{name} > {high}"),
            (true, _, i16::MAX) => format!("{name} >= {low}"),
            (false, _, i16::MAX) => format!("{name} < {low}"),
            (true, ..) => format!("{low} <= {name} <= {high}"),
            (false, ..) => format!("({name} < {low} or {name} > {high})"),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_read_as_on_the_ladder() {
        let mut circuit = Circuit::default();
        let bits: Vec<Lit> = (0..3).map(|v| circuit.atom(Atom::Bit(VarId(v)))).collect();
        let word = VarId(3);
        let name = |variable: VarId| match variable {
            VarId(3) => "D0".to_owned(),
            VarId(v) => format!("X{v}"),
        };
        let mut text_of = |lit: &dyn Fn(&mut Circuit) -> Lit| {
            let lit = lit(&mut circuit);
            text(&circuit, lit, &name).expect("short")
        };
        assert_eq!(text_of(&|c| c.and(bits[0], bits[1])), "X0 and X1");
        assert_eq!(text_of(&|c| c.or(!bits[0], !bits[2])), "not X0 or not X2");
        let nested = |c: &mut Circuit| {
            let or = c.or(bits[1], bits[2]);
            c.and(bits[0], or)
        };
        assert_eq!(text_of(&nested), "X0 and (X1 or X2)");
        assert_eq!(text_of(&|_| Lit::TRUE), "always");
        let range = |low: u16, high: u16| {
            move |c: &mut Circuit| {
                let low = c.atom(Atom::AtLeast(word, low));
                let above =
                    high.checked_add(1).map_or(Lit::FALSE, |n| c.atom(Atom::AtLeast(word, n)));
                c.and(low, !above)
            }
        };
        assert_eq!(text_of(&range(10, 10)), "D0 = 10");
        assert_eq!(text_of(&|c| !range(10, 10)(c)), "D0 <> 10");
        assert_eq!(text_of(&range(10, 20)), "10 <= D0 <= 20");
        assert_eq!(text_of(&range(10, 0x7FFF)), "D0 >= 10");
        assert_eq!(text_of(&|c| !range(10, 0x7FFF)(c)), "D0 < 10");
        assert_eq!(text_of(&range(0x8000, u16::MAX)), "D0 < 0");
        assert_eq!(text_of(&range(10, u16::MAX)), "(D0 < 0 or D0 > 9)");
        assert_eq!(text_of(&range(0, 9)), "0 <= D0 <= 9");
        assert_eq!(text_of(&range(0, 0x7FFF)), "D0 >= 0");
        assert_eq!(text_of(&|c| c.atom(Atom::WordBit(word, 10))), "D0.A");
        let both = |c: &mut Circuit| {
            let ten = range(10, 10)(c);
            c.and(ten, bits[0])
        };
        assert_eq!(text_of(&both), "X0 and D0 = 10");
    }

    #[test]
    fn what_is_too_long_is_not_written_out() {
        let mut circuit = Circuit::default();
        let bits: Vec<Lit> = (0..100).map(|v| circuit.atom(Atom::Bit(VarId(v)))).collect();
        let name = |variable: VarId| format!("X{}", variable.0);
        let all = circuit.all(bits.clone());
        assert_eq!(text(&circuit, all, &name), None);
        let odd = bits.into_iter().reduce(|a, b| circuit.xor(a, b)).expect("bits");
        assert_eq!(text(&circuit, odd, &name), None);
    }
}

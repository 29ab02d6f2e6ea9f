//! How TIME is represented: a signed 32-bit number of half milliseconds.
//!
//! An even number is a time in whole milliseconds. An odd number stands for any time between two of these, since some
//! controllers measure more finely (matiec in nanoseconds): `t.ET > T#1ms AND t.ET < T#2ms` can be true there. Two
//! times with the same odd number may differ, so their comparison may have either result, and their sum may be any
//! value.
//!
//! Controllers have times longer than 12 days: CODESYS up to 49 days, unsigned; matiec in seconds and nanoseconds. So
//! the largest number also stands for all longer times, and the smallest for all below it. A comparison of two such
//! times may have either result, and arithmetic on them may give any value.

use super::Assembler;
use super::types::Kind;
use super::value::{constant, signed};
use scanbound_base::time::Picos;
use scanbound_ir::{BitSource, Logic, Number, Relation, WordSource};

/// The unit of TIME: 0.5 ms.
pub(crate) const UNIT: Picos = Picos(500_000_000);

/// How many units a controller that counts whole milliseconds may be early or late: 1 ms.
pub(crate) const TICK: u64 = 2;

/// The smallest and the largest signed 32-bit number.
const EDGES: [i64; 2] = [i32::MIN as i64, i32::MAX as i64];

impl Assembler {
    /// The condition under which a comparison of two times may have either result: both have the same number, and it
    /// stands for more than one time. `None`: never. The operands are copied to temporaries, since they are read twice.
    pub(crate) fn edge_of_comparison(
        &mut self,
        left: &mut Number,
        right: &mut Number,
    ) -> Option<Logic> {
        let fixed = [fixed(left), fixed(right)];
        if fixed.iter().flatten().any(|value| value % 2 == 0 && !EDGES.contains(value)) {
            return None;
        }
        for (one, value) in [&mut *left, &mut *right].into_iter().zip(fixed) {
            if value.is_none() {
                *one = Number::Words(self.copied(one.clone(), 2));
            }
        }
        let both = |edge| Logic::All(vec![equals(left, edge), equals(right, edge)]);
        let same = signed(Relation::Equal, left.clone(), right.clone());
        let between = is_between(left).map(|between| Logic::All(vec![same, between]));
        Some(Logic::Any(EDGES.map(both).into_iter().chain(between).collect()))
    }
}

/// True where a time lies between two whole milliseconds. `None`: never.
pub(crate) fn is_between(time: &Number) -> Option<Logic> {
    let Number::Words(words) = time else { return Some(Logic::Const(true)) };
    match *words.first()? {
        WordSource::Const(low) => (low % 2 == 1).then_some(Logic::Const(true)),
        WordSource::Cell(cell) => Some(Logic::Bit(BitSource::WordBit(cell, 0))),
        _ => Some(Logic::Const(true)),
    }
}

/// True where the number is the smallest or largest one, which also stands for other times.
pub(crate) fn is_edge(time: &Number) -> Logic {
    Logic::Any(EDGES.map(|edge| equals(time, edge)).to_vec())
}

/// Whether a number is a TIME that may be the smallest or largest number: one that is not constant, or such a constant.
pub(crate) fn may_be_edge(kind: Kind, number: &Number) -> bool {
    kind == Kind::Time && fixed(number).is_none_or(|value| EDGES.contains(&value))
}

fn equals(time: &Number, edge: i64) -> Logic {
    signed(Relation::Equal, time.clone(), constant(edge, 2))
}

/// The value of a constant time; None if it is not constant.
fn fixed(number: &Number) -> Option<i64> {
    match number {
        Number::Words(words) => match words[..] {
            [WordSource::Const(low), WordSource::Const(high)] => {
                Some(i64::from((u32::from(high) << 16 | u32::from(low)).cast_signed()))
            }
            _ => None,
        },
        _ => None,
    }
}

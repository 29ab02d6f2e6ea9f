//! What stands for a time: a number of half milliseconds in 32 bits with a sign.
//!
//! An even number is a time of whole milliseconds; an odd number is any time between two of these, since controllers
//! measure times more finely (matiec in nanoseconds): `t.ET > T#1ms AND t.ET < T#2ms` can be true there. Two times with
//! the same odd number may differ, so their comparison may come out either way, and their sum may be any.
//!
//! Controllers hold longer times than 12 days: CODESYS up to 49 days without a sign, matiec seconds and nanoseconds. So
//! the largest number stands for itself and all longer times, the smallest for itself and all below: a comparison of
//! two such times may come out either way, and what is made of them may be any.

use super::Assembler;
use super::types::Kind;
use super::value::{constant, signed};
use scanbound_base::time::Picos;
use scanbound_ir::{BitSource, Logic, Number, Relation, WordSource};

/// The unit of times.
pub(crate) const UNIT: Picos = Picos(500_000_000);

/// How many of the units a controller that counts whole milliseconds may be early or late by.
pub(crate) const TICK: u64 = 2;

/// The least and the largest number that 32 bits hold.
const EDGES: [i64; 2] = [i32::MIN as i64, i32::MAX as i64];

impl Assembler {
    /// When a comparison of two times may come out either way: if both have the same number, and that stands for more
    /// than one time. `None`: never. The numbers are copied, since they are read twice.
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

/// Where a time lies between two whole milliseconds. `None`: never.
pub(crate) fn is_between(time: &Number) -> Option<Logic> {
    let Number::Words(words) = time else { return Some(Logic::Const(true)) };
    match *words.first()? {
        WordSource::Const(low) => (low % 2 == 1).then_some(Logic::Const(true)),
        WordSource::Cell(cell) => Some(Logic::Bit(BitSource::WordBit(cell, 0))),
        _ => Some(Logic::Const(true)),
    }
}

/// Where a time may be another than its value.
pub(crate) fn is_edge(time: &Number) -> Logic {
    Logic::Any(EDGES.map(|edge| equals(time, edge)).to_vec())
}

/// Whether a number of this kind is a TIME that is no constant, or one at an edge.
pub(crate) fn may_be_edge(kind: Kind, number: &Number) -> bool {
    kind == Kind::Time && fixed(number).is_none_or(|value| EDGES.contains(&value))
}

fn equals(time: &Number, edge: i64) -> Logic {
    signed(Relation::Equal, time.clone(), constant(edge, 2))
}

/// The value of a constant time.
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

//! Times beyond 24 days. A time has 32 bits of milliseconds here, with a sign. Controllers hold more: CODESYS up to 49 days
//! without a sign, matiec seconds and nanoseconds. So the largest time stands for itself and all longer ones, the smallest
//! for itself and all below: a comparison of two such times may come out either way, and what is made of them may be any.

use super::Assembler;
use super::types::Kind;
use super::value::constant;
use scanbound_ir::{Compare, Logic, Number, NumberFormat, Relation, WordSource};

/// The least and the largest time that 32 bits hold, in milliseconds.
const EDGES: [i64; 2] = [i32::MIN as i64, i32::MAX as i64];

impl Assembler {
    /// When a comparison of two times may come out either way: if both are at the same edge, where each stands for any
    /// time beyond. `None`: never. The numbers are copied, since they are read twice.
    pub(crate) fn edge_of_comparison(
        &mut self,
        left: &mut Number,
        right: &mut Number,
    ) -> Option<Logic> {
        let fixed = [fixed(left), fixed(right)];
        if fixed.iter().flatten().any(|value| !EDGES.contains(value)) {
            return None;
        }
        for (one, value) in [&mut *left, &mut *right].into_iter().zip(fixed) {
            if value.is_none() {
                *one = Number::Words(self.copied(one.clone(), 2));
            }
        }
        let both = |edge| Logic::All(vec![equals(left, edge), equals(right, edge)]);
        Some(Logic::Any(EDGES.map(both).to_vec()))
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
    let (left, right) = (time.clone(), constant(edge, 2));
    let (relation, format) = (Relation::Equal, NumberFormat::Signed);
    Logic::Compare(Box::new(Compare { relation, format, left, right }))
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

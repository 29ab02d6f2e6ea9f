//! Arithmetic on two numbers of one kind.

use super::Assembler;
use super::open::{beyond, opened};
use super::time_range::{is_between, is_edge};
use super::types::Kind;
use super::value::{self, Value, constant, wrapped};
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_ir::meaning::{Arithmetic, Operation, OperationInput as Input};
use scanbound_ir::{Logic, Number, Region, Relation, WordSource, Write};

impl Assembler {
    /// Lowers an operator on two numbers of one kind, without a charge. The result may overflow ([`Value::Open`]); it
    /// is any number where the operation is not modelled.
    pub(crate) fn arithmetic(
        &mut self,
        operator: Operator,
        kind: Kind,
        left: Number,
        right: Number,
    ) -> Result<Value, Fault> {
        use Operator as O;
        let words = kind.words();
        if kind == Kind::Real {
            let arithmetic = match operator {
                O::Add => Arithmetic::Add,
                O::Subtract => Arithmetic::Sub,
                O::Multiply => Arithmetic::Multiply,
                O::Divide => Arithmetic::Divide,
                _ => {
                    return Ok(Value::Number(
                        kind,
                        self.any_number(kind, "the function's result may be any number"),
                    ));
                }
            };
            let inputs = vec![Input::Number(left), Input::Number(right)];
            return Ok(Value::Number(
                kind,
                self.worked_out(2, Some((Operation::Real(arithmetic), inputs, 2))),
            ));
        }
        if kind == Kind::Time && matches!(operator, Operator::Add | Operator::Subtract) {
            return Ok(Value::Number(kind, self.time_worked_out(operator, left, right)));
        }
        if kind == Kind::Time {
            let why = "a fraction of a time may be finer than 1 ms, a multiple longer than 12 days, and controllers represent times differently: the result may be any time";
            return Ok(Value::Number(kind, self.any_number(kind, why)));
        }
        if matches!(kind, Kind::Opaque(_)) {
            let why = "arithmetic of LREAL and dates is not modelled: the result may be any value";
            return Ok(Value::Number(kind, self.any_number(kind, why)));
        }
        let boxed = |one, two| (Box::new(one), Box::new(two));
        let mut beyond = beyond(operator, kind, &left, &right);
        let number = match operator {
            O::Add => {
                let (one, two) = boxed(left, right);
                Number::Add(one, two)
            }
            O::Subtract => {
                let (one, two) = boxed(left, right);
                Number::Sub(one, two)
            }
            O::And => {
                let (one, two) = boxed(left, right);
                Number::And(one, two)
            }
            O::Or => {
                let (one, two) = boxed(left, right);
                Number::Or(one, two)
            }
            O::Xor => {
                let (one, two) = boxed(left, right);
                Number::Xor(one, two)
            }
            O::Multiply if words <= 2 => {
                let (low, open) = self.product(kind, left, right);
                beyond = Some(open);
                low
            }
            O::Divide | O::Modulo if words <= 2 => {
                // For the lowest value divided by -1, processors stop as for a division by 0, or give another result.
                let lowest = super::open::beyond(O::Divide, kind, &left, &right);
                lowest.into_iter().for_each(|lowest| self.stops_where(lowest));
                let inputs = vec![Input::Number(left), Input::Number(right)];
                let operation = Operation::DivideJoined { signed: kind.is_signed() };
                let both = self.worked_out(2 * words, Some((operation, inputs, 2 * words)));
                let Number::Words(both) = both else { return Ok(Value::Any) };
                let words = usize::try_from(words).unwrap_or(0);
                let own = if operator == O::Divide { &both[..words] } else { &both[words..] };
                Number::Words(own.to_vec())
            }
            _ => self
                .any_number(kind, "arithmetic that is not modelled: the result may be any number"),
        };
        Ok(opened(Value::Number(kind, wrapped(kind, number)), beyond))
    }

    /// The low words of a product, and the condition under which it does not fit its kind. There, the low words are any
    /// value, since compilers differ in how many bits they keep.
    fn product(&mut self, kind: Kind, left: Number, right: Number) -> (Number, Logic) {
        let (words, signed) = (kind.words(), kind.is_signed());
        let inputs = vec![Input::Number(left), Input::Number(right)];
        let operation = Operation::Multiply { signed };
        let whole = self.worked_out(2 * words, Some((operation, inputs, 2 * words)));
        let whole = self.copied(whole, 2 * words);
        let (low, high) = whole.split_at(usize::try_from(words).unwrap_or(0));
        let number = |words: &[WordSource]| Number::Words(words.to_vec());
        let is = if signed { value::signed } else { value::unsigned };
        let bits = match kind {
            Kind::Whole { bits, .. } => bits,
            _ => 32,
        };
        let beyond = match (words, signed) {
            (1, true) => Logic::Any(vec![
                is(Relation::Less, number(&whole), constant(-(1 << (bits - 1)), 2)),
                is(Relation::Greater, number(&whole), constant((1 << (bits - 1)) - 1, 2)),
            ]),
            (1, false) => is(Relation::Greater, number(&whole), constant((1 << bits) - 1, 2)),
            (_, true) => {
                let negative = is(Relation::Less, number(low), constant(0, 2));
                let all = is(Relation::Equal, number(high), constant(-1, 2));
                let none = is(Relation::Equal, number(high), constant(0, 2));
                Logic::Any(vec![
                    Logic::All(vec![negative.clone(), all]),
                    Logic::All(vec![negative.not(), none]),
                ])
                .not()
            }
            (_, false) => is(Relation::NotEqual, number(high), constant(0, 2)),
        };
        let low = low.to_vec();
        let beyond = self.keep_bit(beyond);
        self.open_where(beyond.clone(), &low);
        (Number::Words(low), beyond)
    }

    /// The sum or difference of two times. It is any time where it may be negative or longer than 12 days, since
    /// controllers differ there (unsigned times wrap to very long ones), and where both operands lie between whole
    /// milliseconds.
    pub(crate) fn time_worked_out(
        &mut self,
        operator: Operator,
        left: Number,
        right: Number,
    ) -> Number {
        let both = [left, right].map(|one| Number::Words(self.words(one, 2)));
        let [left, right] = both;
        let below =
            |left: &Number, right: Number| value::signed(Relation::Less, left.clone(), right);
        let zero = || constant(0, 2);
        // If an operand is out of range, the result may be too, whatever its 32 bits are.
        let mut differs: Vec<Logic> = [&left, &right].map(|one| below(one, zero())).into();
        differs.extend([&left, &right].map(is_edge));
        if let (Some(one), Some(other)) = (is_between(&left), is_between(&right)) {
            differs.push(Logic::All(vec![one, other]));
        }
        let words = match operator {
            Operator::Subtract => {
                differs.push(below(&left, right.clone()));
                self.copied(Number::Sub(Box::new(left), Box::new(right)), 2)
            }
            _ => {
                let sum = self.copied(Number::Add(Box::new(left), Box::new(right)), 2);
                differs.push(below(&Number::Words(sum.clone()), zero()));
                sum
            }
        };
        let differs = self.keep_bit(Logic::Any(differs));
        if let Some(&WordSource::Cell(first)) = words.first() {
            let choice = self.builder.choice();
            self.program().statements.undefined_by_language.insert(choice);
            let any = Write::Havoc(Region::Range { first, count: 2 }, choice);
            let at = self.write_if(differs, vec![any], None);
            let why = "controllers differ for times below 0 or beyond 12 days, and some measure more finely than in ms: the result may be any time";
            self.program().approximate(at, why);
        }
        Number::Words(words)
    }
}

//! Lowers conversions between types.

use super::Assembler;
use super::mixed::below_zero;
use super::time_range::{is_edge, may_be_edge};
use super::types::{DINT, Kind, Ty, holding};
use super::value::{Value, constant, signed, unsigned, wrapped};
use scanbound_ir::meaning::{Operation, OperationInput as Input};
use scanbound_ir::{BitSource, Logic, Number, Relation, WordSource};

/// Text of a reading: how some controllers convert, by the third edition of the standard.
const LAST_BIT: &str = "a number is converted to BOOL by its last bit alone";
/// Text of a reading: how some controllers convert, by the third edition of the standard.
const SAME_BITS: &str = "REAL and bit strings are converted bit by bit";
/// Text of a reading: how some controllers convert, by the third edition of the standard.
const NO_SIGN: &str = "a number that is converted to a longer bit string is filled up with 0 bits";

/// A type in the name of a conversion, with whether it is a bit string (BYTE, WORD and the like).
type Named = (bool, Ty);

impl Assembler {
    /// Converts a number from one kind to another and charges it. Any value where a TIME is at the edge of its range.
    pub(crate) fn converted(&mut self, number: Number, from: Kind, to: Kind) -> Number {
        self.charge_conversion(from, to);
        if from == to || !may_be_edge(from, &number) {
            return self.converted_for_nothing(number, from, to);
        }
        let time = Number::Words(self.copied(number, from.words()));
        let found = self.converted_for_nothing(time.clone(), from, to);
        let found = self.copied(found, to.words());
        self.open_where(is_edge(&time), &found);
        Number::Words(found)
    }

    fn converted_for_nothing(&mut self, number: Number, from: Kind, to: Kind) -> Number {
        if from == to {
            return number;
        }
        let whole = |kind: Kind| matches!(kind, Kind::Whole { .. } | Kind::Time);
        match (from, to) {
            (from, to) if whole(from) && whole(to) => {
                let (have, want) = (from.words(), to.words());
                if want == have {
                    return wrapped(to, number);
                }
                let mut words = self.words(number, have);
                if want < have {
                    words.truncate(usize::try_from(want).unwrap_or(0));
                    return wrapped(to, Number::Words(words));
                }
                words.resize(usize::try_from(want).unwrap_or(0), WordSource::Const(0));
                let wide = Number::Words(words);
                if !from.is_signed() {
                    return wide;
                }
                // Sign extension into the upper words.
                let sign = || Box::new(constant(1 << (16 * have - 1), want));
                let flipped = Number::Xor(Box::new(wide), sign());
                Number::Sub(Box::new(flipped), sign())
            }
            // The operation takes its input as signed, so an unsigned number needs a longer type.
            (from @ Kind::Whole { bits: 16, signed: false }, Kind::Real) => {
                let longer = self.converted_for_nothing(number, from, DINT);
                self.converted_for_nothing(longer, DINT, to)
            }
            (from, Kind::Real) if whole(from) && from.words() <= 2 => {
                let words = Number::Words(self.words(number, from.words()));
                let same = vec![Input::Number(words.clone())];
                let found = self.worked_out(2, Some((Operation::ToReal, same, 2)));
                if let (false, Number::Words(found)) = (from.is_signed(), &found) {
                    self.open_where(below_zero(from, &words), found);
                }
                found
            }
            (Kind::Real, to) if whole(to) && to.words() <= 2 => {
                let words = to.words();
                let size = u8::try_from(words).unwrap_or(1);
                let operation = Operation::FromReal(size);
                let found =
                    self.worked_out(words, Some((operation, vec![Input::Number(number)], words)));
                // Beyond the range of the type, the result depends on the processor.
                let found = self.copied(found, words);
                let is = |relation, value| {
                    signed(relation, Number::Words(found.clone()), constant(value, words))
                };
                let beyond = match to {
                    Kind::Whole { bits: 8, signed } => {
                        let (least, most) = if signed { (-128, 127) } else { (0, 255) };
                        vec![is(Relation::Less, least), is(Relation::Greater, most)]
                    }
                    Kind::Whole { signed: false, .. } => vec![is(Relation::Less, 0)],
                    _ => Vec::new(),
                };
                if !beyond.is_empty() {
                    self.open_where(Logic::Any(beyond), &found);
                }
                wrapped(to, Number::Words(found))
            }
            _ => self
                .any_number(to, "a conversion that is not modelled: the result may be any number"),
        }
    }

    /// Lowers a conversion function, such as `INT_TO_REAL` or `TO_REAL`. `from` is the source type if the name has one.
    pub(crate) fn named_conversion(
        &mut self,
        value: Value,
        from: Option<Named>,
        (to_bits, to): Named,
    ) -> Value {
        let value = self.as_named(value, from.as_ref().map(|(_, ty)| ty), &to);
        let Value::Number(kind, number) = value else {
            return self.conversion(value, &to);
        };
        let words = self.copied(number, kind.words());
        let own = || Value::Number(kind, Number::Words(words.clone()));
        let plain = self.conversion(own(), &to);
        match (kind, &to, plain) {
            (Kind::Whole { .. }, Ty::Bit, Value::Bit(any)) => {
                let Some(WordSource::Cell(first)) = words.first() else { return own() };
                let last = Logic::Bit(BitSource::WordBit(*first, 0));
                let either = Logic::All(vec![any, self.differs(LAST_BIT).not()]);
                Value::Bit(Logic::Any(vec![last, either]))
            }
            // Of a fraction, some controllers test the integer part or its last bit.
            (_, Ty::Bit, Value::Bit(any)) => Value::Bit(self.open_bit(any.clone(), any)),
            (
                Kind::Whole { bits, signed: true },
                Ty::Number(to @ Kind::Whole { bits: longer, .. }),
                plain,
            ) if to_bits && bits < *longer => {
                let unsigned = Kind::Whole { bits, signed: false };
                let low = wrapped(unsigned, Number::Words(words.clone()));
                let other = Value::Number(*to, self.converted(low, unsigned, *to));
                let below = below_zero(kind, &Number::Words(words.clone()));
                let which = Logic::All(vec![below, self.differs(NO_SIGN)]);
                self.chosen(which, other, plain)
            }
            (Kind::Whole { signed, .. }, Ty::Number(Kind::Real), plain)
                if from.as_ref().map_or(!signed, |(of_bits, _)| *of_bits) =>
            {
                let mut bits = words.clone();
                bits.resize(2, WordSource::Const(0));
                let other = Value::Number(Kind::Real, Number::Words(bits));
                let which = self.differs(SAME_BITS);
                self.chosen(which, other, plain)
            }
            (Kind::Real, Ty::Number(to), plain) if to_bits => {
                let unsigned = Kind::Whole { bits: 32, signed: false };
                let other = self.converted(Number::Words(words.clone()), unsigned, *to);
                let which = self.differs(SAME_BITS);
                self.chosen(which, Value::Number(*to, other), plain)
            }
            (_, _, plain) => plain,
        }
    }

    /// The argument of a conversion, as a value of its source type `from` if that is named.
    fn as_named(&mut self, value: Value, from: Option<&Ty>, to: &Ty) -> Value {
        match (value, from, to) {
            (value @ Value::Constant(_), Some(Ty::Number(kind)), _) => {
                Value::Number(*kind, self.as_number(value, *kind))
            }
            // Its size in bits is not known.
            (Value::Constant(..0), None, Ty::Number(kind @ Kind::Whole { signed: false, .. })) => {
                let why = "a negative number that becomes a bit string may have any number of bits";
                Value::Number(*kind, self.any_number(*kind, why))
            }
            (Value::Constant(value), None, Ty::Bit) => {
                let kind = holding(DINT, value);
                Value::Number(kind, constant(value, kind.words()))
            }
            (Value::Constant(value @ 0..=0xFFFF_FFFF), None, Ty::Number(Kind::Real)) => {
                Value::Number(Kind::Whole { bits: 32, signed: false }, constant(value, 2))
            }
            (Value::Number(own, number), Some(Ty::Number(kind)), _) => {
                let is_shorter = matches!(
                    (own, kind),
                    (Kind::Whole { bits, .. }, Kind::Whole { bits: longer, .. }) if bits < *longer
                );
                let is_other = matches!(
                    (own, kind),
                    (Kind::Whole { bits, signed }, Kind::Whole { bits: same, signed: also })
                        if bits == *same && signed != *also
                );
                match (is_shorter, is_other) {
                    (true, _) => Value::Number(*kind, self.converted(number, own, *kind)),
                    (_, true) => {
                        let number = Number::Words(self.copied(number, own.words()));
                        let signed = match own {
                            Kind::Whole { bits, .. } => Kind::Whole { bits, signed: true },
                            own => own,
                        };
                        let below = below_zero(signed, &number);
                        match to {
                            Ty::Number(to) => {
                                let beyond = Some(below);
                                let (number, _) = self.operand((own, number, beyond), *to, None);
                                Value::Number(*to, number)
                            }
                            _ => Value::Number(own, number),
                        }
                    }
                    _ => Value::Number(own, number),
                }
            }
            (value, _, _) => value,
        }
    }

    /// Converts a value to a type as an implicit conversion does.
    pub(crate) fn conversion(&mut self, value: Value, to: &Ty) -> Value {
        match (to, value) {
            (Ty::Bit, Value::Bit(logic)) => Value::Bit(logic),
            (Ty::Bit, Value::Number(kind, number)) => {
                Value::Bit(unsigned(Relation::NotEqual, number, constant(0, kind.words())))
            }
            (Ty::Bit, Value::Constant(value)) => Value::Bit(Logic::Const(value != 0)),
            (Ty::Number(kind), Value::Any) => {
                self.charge_any_conversion(*kind);
                let why = "a conversion that is not modelled: the result may be any number";
                Value::Number(*kind, self.any_number(*kind, why))
            }
            (Ty::Number(kind), value) => Value::Number(*kind, self.as_number(value, *kind)),
            (Ty::Bit, Value::Any) => Value::Bit(
                self.any_bit("a conversion that is not modelled: the result may be true or false"),
            ),
            _ => Value::Any,
        }
    }
}

//! Lowers calls of standard functions.

use super::Lower;
use super::cells::Effects;
use super::spots::Context;
use super::values::{is_rounded, shown, works};
use crate::assembler::Assembler;
use crate::assembler::open::{beyond, complement, opened, parted};
use crate::assembler::results::{beside_numbers, crosses};
use crate::assembler::selected::limits;
use crate::assembler::types::{DINT, Extent, Kind, Ty};
use crate::assembler::value::{Value, constant, signed, unsigned, wrapped};
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::standard::{Function, Shift, Simple};
use scanbound_iec_tree::tree::{Applied, Expr};
use scanbound_ir::{Logic, Number, Relation, Step};

/// The type that the name of a conversion gives. Texts are [`Ty::Whole`].
fn ty(of: Simple) -> Ty {
    match of {
        Simple::Elementary(of) => of.kind().map_or(Ty::Bit, Ty::Number),
        Simple::Text => Ty::Whole,
    }
}

impl Lower<'_> {
    /// Lowers a call of a standard function, with EN and ENO if given, and returns its result.
    pub(super) fn applied(
        &mut self,
        at: &Context,
        of: &Applied,
        line: u32,
    ) -> Result<Value, Fault> {
        let results = of.enable.result.iter().map(|(place, _)| place);
        let written: Vec<_> = of.outputs.iter().chain(results).collect();
        let given = of.inputs.iter().chain(&of.enable.condition);
        self.outputs_stay(at, &written, given, Effects::default(), line)?;
        self.writes_each_once(at, &[], &written, line)?;
        if !of.enable.is_given() {
            return self.seen_bits(at, of, line);
        }
        let inputs: Vec<&Expr> = of.inputs.iter().collect();
        let outputs: Vec<_> = of.outputs.iter().collect();
        // A separate test of EN takes at most the time of the function.
        if of.enable.condition.is_some() {
            self.cost(&["JMP"], "jump");
        }
        let condition = self.condition(at, &of.enable)?;
        let enabled = self.begin_inputs(at, (&of.enable, condition), &inputs, false, line)?;
        let result = self.seen_bits(at, of, line)?;
        let result = self.frozen(result);
        let fails = match of.enable.result {
            Some(_) => self.may_fail(of, &result),
            None => None,
        };
        let enable = self.end_enabled(at, enabled, &of.enable, (&outputs, fails), line)?;
        Ok(self.result_if(enable, result))
    }

    /// The condition under which ENO may report a failure: a division by zero, or a result that does not fit its type.
    /// None if the function cannot fail. Controllers differ in which failures they report.
    fn may_fail(&mut self, of: &Applied, result: &Value) -> Option<Logic> {
        let fits = |from: &Option<Simple>, to: &Simple| match (from.map(ty), ty(*to)) {
            (Some(from), to) if from == to => true,
            (Some(Ty::Bit), Ty::Number(_)) => true,
            (Some(Ty::Number(from)), Ty::Number(to)) => match (from, to) {
                (Kind::Whole { bits, signed }, Kind::Whole { bits: to, signed: with_sign }) => {
                    bits < to && (with_sign || !signed)
                }
                _ => false,
            },
            _ => false,
        };
        let where_too_large = match &of.function {
            Function::Move
            | Function::Not
            | Function::Sel
            | Function::Extreme { .. }
            | Function::Measured(_) => return None,
            Function::Convert { from, to, .. } if fits(from, to) => return None,
            Function::Operator { operator, .. } => {
                let divides =
                    matches!(operator, Operator::Divide | Operator::Modulo | Operator::Power);
                let divisor = of.inputs.last().and_then(Expr::whole);
                let works = divides
                    || matches!(operator, Operator::Add | Operator::Subtract | Operator::Multiply);
                match result {
                    _ if !works => return None,
                    _ if divides && divisor.is_none_or(|divisor| divisor == 0) => None,
                    Value::Open(_, _, beyond) => Some(beyond.clone()),
                    Value::Number(Kind::Whole { .. }, _) | Value::Constant(_) => return None,
                    _ => None,
                }
            }
            _ => None,
        };
        let says_so = self.left_open();
        Some(Logic::All([Some(says_so), where_too_large].into_iter().flatten().collect()))
    }

    /// The result of a function. It is any value where it depends on how many bits the compiler keeps of its inputs.
    fn seen_bits(&mut self, at: &Context, of: &Applied, line: u32) -> Result<Value, Fault> {
        let found = self.worked(at, of, line)?;
        let shows = of.function.shows_bits();
        // A 64-bit result shows the excess bits of a 32-bit sum.
        let is_long = matches!(found, Value::Number(Kind::Whole { bits: 64, .. }, _));
        if of.function.chooses() && of.inputs.iter().any(is_rounded) {
            return Ok(self.between(found));
        }
        let differs = (shows || is_long) && of.inputs.iter().any(works);
        Ok(if differs { self.between(found) } else { found })
    }

    /// Evaluates the inputs of a function and applies it, each number at the size of its type.
    fn worked(&mut self, at: &Context, of: &Applied, line: u32) -> Result<Value, Fault> {
        let inputs: Vec<&Expr> = of.inputs.iter().collect();
        let is_choice = matches!(of.function, Function::Sel | Function::Mux);
        let values = self.operands(at, &inputs, line, &mut |own, which| {
            if !(is_choice && inputs[which].calls()) {
                return own.open_value(at, inputs[which]);
            }
            let why = "an input with a call may be skipped if another input is selected";
            let leaves = own.any_bit(why);
            let left = own.jump(leaves, None);
            own.open_value(at, inputs[which])?;
            own.land(left);
            own.landing();
            Ok(Value::Any)
        })?;
        for target in &of.outputs {
            self.assign(at, target, None, Value::Any, line)?;
        }
        let Some(order) = &of.order else {
            let why =
                format!("not all inputs of {} are connected: the result may be any value", of.name);
            let at = self.builder.add(None, Vec::new(), Step::Nothing);
            self.program().approximate(at, why);
            return Ok(Value::Any);
        };
        let mut values: Vec<Value> = order.iter().map(|&at| values[at].clone()).collect();
        if of.function.chooses() {
            for (value, &at) in values.iter_mut().zip(order) {
                self.give_type(value, inputs[at]);
            }
        }
        // Operators and LIMIT with constant limits handle inputs that overflow their type. For all other functions, the
        // result is any value there.
        let has_limits = of.function == Function::Limit
            && matches!(&values[..], [low, value, high] if limits(low, value, high).is_some());
        if of.function.is_operator() || has_limits {
            return self.of_values(of, values, line);
        }
        let (values, open): (Vec<Value>, Vec<_>) = values.into_iter().map(parted).unzip();
        let open: Vec<Logic> = open.into_iter().flatten().collect();
        let open = (!open.is_empty()).then(|| self.keep_bit(Logic::Any(open)));
        let found = self.of_values(of, values, line)?;
        Ok(self.any_where(found, open))
    }

    /// Makes a value that is not modelled any number of its expression's type: beside a number of a shorter type it may
    /// be larger than that.
    pub(super) fn give_type(&mut self, value: &mut Value, of: &Expr) {
        if let (Value::Any, Some(kind)) = (&*value, self.tree.types.kind(of.ty)) {
            let why = "a value that is not modelled: it may be any number of its type";
            *value = Value::Number(kind, self.any_number(kind, why));
        }
    }

    /// Lowers a function applied to values that are evaluated already.
    fn of_values(
        &mut self,
        of: &Applied,
        mut values: Vec<Value>,
        line: u32,
    ) -> Result<Value, Fault> {
        let upper = of.name.as_str();
        let first = of.inputs.first();
        if of.function != Function::Move {
            values.iter().for_each(|value| self.note_address(value));
        }
        let seen = |value: Option<Value>, to: &Ty| match first {
            Some(input) => value.map(|value| shown(input, value, to)),
            None => value,
        };
        if !matches!(of.function, Function::Measured(_) | Function::Unfollowed("SIZEOF")) {
            let extents = of.inputs.iter().map(|one| self.extent(one));
            let whole = extents.fold(Extent::One, Extent::and);
            self.charge_whole(whole);
        }
        match (&of.function, values.len()) {
            (Function::Decimal { reads, to, .. }, _) => {
                self.cost(&[upper, "CONVERT"], "conversion");
                let value = self.decimal(values.into_iter().next().unwrap_or(Value::Any), *reads);
                match to {
                    Some(to) => Ok(self.charged_already(|own| own.conversion(value, &ty(*to)))),
                    // For an untyped BCD conversion, compilers differ in the number of digits.
                    None => Ok(Value::Any),
                }
            }
            (Function::Convert { from, to, .. }, _) => {
                let of_text = match from {
                    Some(from) => from.is_text(),
                    // A value that is not modelled may be a text.
                    None => matches!(values.first(), Some(Value::Any)),
                };
                match of_text || to.is_text() {
                    true => self.cost(&[upper, "FUNCTION"], "special"),
                    false => self.cost(&[upper, "CONVERT"], "conversion"),
                }
                let of_time = match from {
                    Some(from) => from.is_time(),
                    None => matches!(values.first(), Some(Value::Number(Kind::Time, _))),
                };
                if of_time != to.is_time() {
                    return Ok(self.of_any_unit(&ty(*to)));
                }
                let value = seen(values.into_iter().next(), &ty(*to));
                let value = value.ok_or_else(|| Fault::new(line, "a conversion has one input"))?;
                let named = |one: Simple| (one.is_bits(), ty(one));
                let (from, to) = (from.map(named), named(*to));
                Ok(self.charged_already(|own| own.named_conversion(value, from, to)))
            }
            (Function::Operator { operator, .. }, 2..) => self.folded(*operator, values, line),
            (Function::Operator { .. }, _) => Ok(Value::Any),
            (Function::Move, 1) => {
                self.cost(&["MOVE", "ST"], "move");
                Ok(values.remove(0))
            }
            (Function::Not, 1) => {
                self.cost(&["NOT"], "logic");
                Ok(complement(values.remove(0)))
            }
            (Function::Sel, 3) => {
                self.cost(&["SEL"], "move");
                let (two, one) = (values.remove(2), values.remove(1));
                let which = match values.remove(0) {
                    Value::Bit(logic) => logic,
                    _ => self.any_bit(
                        "a selection whose condition is not modelled: it may be either input",
                    ),
                };
                Ok(self.chosen(which, two, one))
            }
            (Function::Extreme { .. } | Function::Limit, 3..) if crosses(&values) => {
                self.crossed(upper, &values, line)
            }
            (Function::Extreme { larger }, 2..) => {
                let larger = *larger;
                let mut rest = values.into_iter();
                let mut best = rest.next().unwrap_or(Value::Any);
                for next in rest {
                    self.cost(&[upper], "compare");
                    best = self.better(best, next, larger, line)?;
                }
                Ok(best)
            }
            (Function::Limit, 3) => {
                self.cost(&["LIMIT"], "compare");
                let (high, value, low) = (values.remove(2), values.remove(1), values.remove(0));
                self.limited(low, value, high, line)
            }
            (Function::Abs, 1) => self.absolute(values.remove(0), line),
            (Function::Shift(Shift { .. }), 2) => {
                self.cost(&[upper, "FUNCTION"], "special");
                let (places, moved) = (values.remove(1), values.remove(0));
                let found = self.moved(upper, moved, places);
                if matches!(found, Value::Any) {
                    let at = self.builder.next() - 1;
                    let why = format!("the result of {upper} may be any value");
                    self.program().approximate(at, why);
                }
                Ok(found)
            }
            (Function::Mux, 2..) => {
                self.cost(&["MUX", "FUNCTION"], "special");
                let inputs = beside_numbers(&values[1..]);
                match crosses(&inputs) {
                    true => Ok(self.any_crossed(&inputs)),
                    false => self.multiplexed(values, line),
                }
            }
            (Function::Measured(value), _) => {
                self.cost(&["FUNCTION"], "special");
                Ok(Value::Constant(*value))
            }
            (Function::Unfollowed(_) | Function::Abs | Function::Shift(_) | Function::Mux, _) => {
                self.cost(&[upper, "FUNCTION"], "special");
                let extent = of.inputs.first().map_or(Extent::One, |one| self.extent(one));
                self.any_result(upper, values.first(), extent, line)
            }
            (
                Function::Move
                | Function::Not
                | Function::Sel
                | Function::Extreme { .. }
                | Function::Limit,
                _,
            ) => {
                let help = "give it the number of inputs that the standard requires";
                Err(Fault::new(line, format!("{upper} has a wrong number of inputs")).help(help))
            }
        }
    }
}

impl Assembler {
    pub(in super::super) fn crossed(
        &mut self,
        name: &str,
        values: &[Value],
        line: u32,
    ) -> Result<Value, Fault> {
        self.cost(&[name], "compare");
        for value in values.windows(2) {
            self.better(value[0].clone(), value[1].clone(), true, line)?;
        }
        Ok(self.any_crossed(values))
    }

    /// Any value that a selection from signed and unsigned numbers may have.
    fn any_crossed(&mut self, values: &[Value]) -> Value {
        let why = "compilers compare signed with unsigned numbers in different ways";
        let is_long =
            |value: &Value| matches!(value, Value::Number(Kind::Whole { bits: 32.., .. }, _));
        let kind = match values.iter().any(is_long) {
            true => Kind::Whole { bits: 64, signed: true },
            false => DINT,
        };
        Value::Number(kind, self.any_number(kind, why))
    }

    /// Lowers ABS and charges it. The absolute value of the lowest number of a type does not fit it. A type other than
    /// an integer or TIME gives any value.
    pub(in super::super) fn absolute(&mut self, value: Value, line: u32) -> Result<Value, Fault> {
        let is_whole =
            matches!(value, Value::Number(Kind::Whole { .. } | Kind::Time, _) | Value::Constant(_));
        self.cost(&["ABS"], if is_whole { "arithmetic" } else { "real" });
        let Value::Number(kind @ (Kind::Whole { .. } | Kind::Time), number) = value else {
            return self.any_result("ABS", Some(&value), Extent::One, line);
        };
        let words = self.words(number, kind.words());
        let number = Number::Words(words);
        let zero = || constant(0, kind.words());
        let below = if kind.is_signed() { signed } else { unsigned };
        let negative = below(Relation::Less, number.clone(), zero());
        let flipped = match kind {
            Kind::Time => self.time_worked_out(Operator::Subtract, zero(), number.clone()),
            _ => wrapped(kind, Number::Sub(Box::new(zero()), Box::new(number.clone()))),
        };
        // The lowest number of a type has no positive counterpart.
        let beyond = beyond(Operator::Subtract, kind, &zero(), &number);
        let beyond = beyond.filter(|_| kind.is_signed());
        let [flipped, number] = [flipped, number].map(|one| Value::Number(kind, one));
        Ok(opened(self.chosen(negative, flipped, number), beyond))
    }
}

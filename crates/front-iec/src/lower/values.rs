//! Lowers expressions to values, and assignments to writes.

use super::Lower;
use super::spots::{Context, Element, Found, Spot};
use crate::assembler::Assembler;
use crate::assembler::numbers::{ROUNDED, read, row};
use crate::assembler::open::{complement, opened, parted};
use crate::assembler::types::{Extent, Kind, Ty, holding};
use crate::assembler::value::{Value, constant, is_real, real, targets, within};
use scanbound_base::code::Code;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::declarations::{Purpose, TempId};
use scanbound_iec_tree::standard::Function;
use scanbound_iec_tree::tree::{Expr, ExprKind, Place, Root};
use scanbound_iec_tree::types::Type as Typed;
use scanbound_iec_tree::types::time_in_units;
use scanbound_ir::meaning::{Count, Meaning, Operation, OperationInput as Input, Shape, Target};
use scanbound_ir::{BitSource, BitTarget, Logic, Number, Region, WordSource, Write};

/// Evaluates some operands and returns their values in source order. The flag asks for evaluation from right to left.
type Work<'w, 't> = dyn FnMut(&mut Lower<'t>, bool) -> Result<Vec<Value>, Fault> + 'w;

/// Text of a reading: how some controllers differ from the standard here.
const RIGHT_FIRST: &str = "operands are evaluated from right to left";
/// Text of a reading: how some controllers differ from the standard here.
const TARGET_FIRST: &str = "the index of an assigned element is evaluated before the value";

/// The most calls in one expression whose order is modelled both ways. Beyond it, the lowered code would grow too
/// large.
pub(super) const MAX_CALLS: usize = 6;

/// Whether an expression is a literal that REAL cannot represent exactly. Some compilers take it as a long real (LREAL)
/// until it is stored.
pub(super) fn is_rounded(one: &Expr) -> bool {
    matches!(&one.unconverted().kind, ExprKind::Real(text) if !is_real(text))
}

/// The value of an operand of AND or OR. `NOT 0` or `NOT 1` beside an integer is the integer -1 or -2, not a Boolean;
/// any other value is unchanged.
fn masked(expr: &Expr, value: Value, beside: &Value) -> Value {
    match (&expr.unconverted().kind, value, beside) {
        (ExprKind::Not(inner), Value::Any, Value::Number(Kind::Whole { .. }, _)) => {
            match inner.kind {
                ExprKind::Whole(number @ (0 | 1)) => {
                    Value::Constant(if number == 0 { -1 } else { -2 })
                }
                _ => Value::Any,
            }
        }
        (_, value, _) => value,
    }
}

/// Whether an expression contains an addition, a subtraction, or the negation of anything but a literal.
fn sums(one: &Expr) -> bool {
    let mut found = false;
    one.each(&mut |one| {
        found |= match &one.kind {
            ExprKind::Binary(operator, ..) => {
                matches!(operator, Operator::Add | Operator::Subtract)
            }
            ExprKind::Negate(inner) => !is_literal(inner),
            ExprKind::Standard(applied) => matches!(
                applied.function,
                Function::Operator {
                    operator: Operator::Add | Operator::Subtract,
                    of_times: false
                }
            ),
            _ => false,
        };
    });
    found
}

fn multiplies(one: &Expr) -> bool {
    let mut found = false;
    one.each(&mut |one| {
        found |= match &one.kind {
            ExprKind::Binary(operator, ..) => *operator == Operator::Multiply,
            ExprKind::Standard(applied) => matches!(
                applied.function,
                Function::Operator { operator: Operator::Multiply, of_times: false }
            ),
            _ => false,
        };
    });
    found
}

/// Whether an expression contains an operation whose result may need more bits than its type: addition, subtraction,
/// multiplication, negation, NOT, ABS or SHL.
pub(super) fn works(one: &Expr) -> bool {
    let mut complements = false;
    one.each(&mut |one| {
        complements |= match &one.kind {
            ExprKind::Not(_) => true,
            ExprKind::Standard(applied) => match applied.function {
                Function::Not | Function::Abs => true,
                Function::Shift(shift) => shift.left && !shift.rotates,
                _ => false,
            },
            _ => false,
        };
    });
    complements || sums(one) || multiplies(one)
}

fn is_literal(one: &Expr) -> bool {
    matches!(
        one.kind,
        ExprKind::Bool(_)
            | ExprKind::Whole(_)
            | ExprKind::Typed(_)
            | ExprKind::Real(_)
            | ExprKind::Time(_)
            | ExprKind::Opaque
            | ExprKind::Text(_)
    )
}

/// The value of an expression where it is converted to a type. A result of arithmetic in 32 bits or more that becomes a
/// longer type or REAL may exceed its type (it depends on how many bits the compiler keeps); as a Boolean it may be
/// either. Other values are unchanged.
pub(super) fn shown(of: &Expr, value: Value, ty: &Ty) -> Value {
    match (value, ty) {
        (Value::Number(kind @ Kind::Whole { bits: own @ 32.., .. }, number), Ty::Number(to))
            if !matches!(to, Kind::Whole { bits, .. } if *bits <= own) && works(of) =>
        {
            Value::Open(kind, number, Logic::Const(true))
        }
        (Value::Number(Kind::Whole { bits: 32.., .. }, _), Ty::Bit) if works(of) => Value::Any,
        (value, _) => value,
    }
}

/// Whether an expression consists only of untyped integer literals and operations on them.
fn is_untyped(one: &Expr) -> bool {
    match &one.unconverted().kind {
        ExprKind::Whole(_) => true,
        ExprKind::Negate(inner) => is_untyped(inner),
        ExprKind::Binary(_, left, right) => is_untyped(left) && is_untyped(right),
        ExprKind::Standard(applied) => {
            let own = match &applied.function {
                Function::Extreme { .. } | Function::Limit | Function::Move | Function::Abs => {
                    Some(0)
                }
                Function::Sel | Function::Mux => Some(1),
                Function::Operator { operator, of_times: false } => matches!(
                    operator,
                    Operator::Add
                        | Operator::Subtract
                        | Operator::Multiply
                        | Operator::Divide
                        | Operator::Modulo
                )
                .then_some(0),
                _ => None,
            };
            let order = applied.order.as_deref().unwrap_or_default();
            own.is_some_and(|from| {
                order.iter().skip(from).all(|&at| is_untyped(&applied.inputs[at]))
            })
        }
        _ => false,
    }
}

/// Whether every intermediate result of constants in an expression satisfies `fits`. Results that are not known are
/// taken to fit.
fn all_fit(one: &Expr, fits: &dyn Fn(i64) -> bool) -> bool {
    let one = one.unconverted();
    match &one.kind {
        ExprKind::Negate(inner) => all_fit(inner, fits),
        ExprKind::Binary(_, left, right) => {
            let own = literal_value(one).is_none_or(fits);
            own && all_fit(left, fits) && all_fit(right, fits)
        }
        ExprKind::Standard(applied) => applied.inputs.iter().all(|one| all_fit(one, fits)),
        _ => true,
    }
}

/// The value of an expression of untyped integer literals. None if it contains anything else, or overflows.
pub(super) fn literal_value(one: &Expr) -> Option<i64> {
    let one = one.unconverted();
    match &one.kind {
        ExprKind::Whole(value) => Some(*value),
        ExprKind::Negate(inner) => literal_value(inner)?.checked_neg(),
        ExprKind::Binary(operator, left, right) => {
            operator.of_constants(literal_value(left)?, literal_value(right)?)
        }
        _ => None,
    }
}

/// Whether a constant expression, evaluated in the type of the other operand, may overflow that type. A single literal
/// never counts as overflow.
pub(super) fn wraps_in(one: &Expr, value: &Value, kind: Kind) -> bool {
    let one = one.unconverted();
    let is_written = match &one.kind {
        ExprKind::Negate(inner) => is_literal(inner),
        _ => is_literal(one),
    };
    if is_written || !matches!(kind, Kind::Whole { .. }) {
        return false;
    }
    let is_longer = |own: &Kind| match (own, kind) {
        (Kind::Whole { bits: own, .. }, Kind::Whole { bits, .. }) => *own > bits,
        _ => false,
    };
    let fits = |value: i64| holding(kind, value) == kind;
    match value {
        Value::Constant(value) => !fits(*value) || !all_fit(one, &fits),
        Value::Number(own, _) | Value::Open(own, ..) => {
            is_untyped(one) && (is_longer(own) || !all_fit(one, &fits))
        }
        _ => false,
    }
}

fn may_have_wrapped(one: &Expr, value: &Value, other: &Value) -> bool {
    match other {
        Value::Number(kind, _) | Value::Open(kind, ..) => wraps_in(one, value, *kind),
        _ => false,
    }
}

fn wrong(line: u32, what: &str) -> Fault {
    Fault::new(line, what).code(Code::Operand)
}

impl<'t> Lower<'t> {
    /// Lowers an expression and charges its instructions. Where the result does not fit its type, it becomes any
    /// number.
    pub(super) fn value(&mut self, at: &Context, one: &Expr) -> Result<Value, Fault> {
        let value = self.open_value(at, one)?;
        Ok(self.settled(value))
    }

    /// Lowers an expression like [`Lower::value`], but the result may be [`Value::Open`]: the caller uses only the bits
    /// of the type, or handles the overflow itself.
    pub(super) fn open_value(&mut self, at: &Context, one: &Expr) -> Result<Value, Fault> {
        let line = one.line;
        Ok(match &one.kind {
            ExprKind::Bool(value) => Value::Bit(Logic::Const(*value)),
            ExprKind::Whole(value) | ExprKind::Named(value) => Value::Constant(*value),
            ExprKind::Typed(value) => match self.tree.types.kind(one.ty) {
                Some(kind) => Value::Number(kind, within(kind, *value)),
                None => Value::Constant(*value),
            },
            ExprKind::Real(text) => {
                real(text).map_or(Value::Any, |bits| Value::Number(Kind::Real, bits))
            }
            ExprKind::Time(time) => Value::Number(Kind::Time, self.time(*time)),
            ExprKind::Opaque => {
                let why = "LREAL and dates are not modelled: this may be any value";
                Value::Number(Kind::Opaque(4), self.any_number(Kind::Opaque(4), why))
            }
            ExprKind::Text(_) | ExprKind::List(_) => Value::Any,
            ExprKind::Read(place) => self.read(at, place, line)?,
            ExprKind::Step(flag) => self.step_flag(at, flag, line)?,
            ExprKind::Not(inner) => {
                let value = self.open_value(at, inner)?;
                self.cost(&["NOT"], "logic");
                complement(value)
            }
            ExprKind::Negate(inner) => {
                let value = self.open_value(at, inner)?;
                self.negated(value)?
            }
            ExprKind::Binary(operator, left, right) => {
                self.binary(at, *operator, left.unconverted(), right.unconverted(), line)?
            }
            ExprKind::Convert(inner) => {
                let value = self.open_value(at, inner)?;
                match self.tree.types.kind(one.ty) {
                    Some(kind) => Value::Number(kind, self.as_number(value, kind)),
                    None => value,
                }
            }
            ExprKind::Call(call) => self.called(at, call, line)?,
            ExprKind::After(both) => {
                let then = self.found(|own, found| own.of_expr(at, &both.1, found));
                self.call_before(at, &both.0, &then, line)?;
                let value = self.open_value(at, &both.1)?;
                // The next call overwrites it.
                self.frozen(value)
            }
            ExprKind::Standard(applied) => self.applied(at, applied, line)?,
            ExprKind::Address(place) => self.address(at, place, line)?,
            ExprKind::Null => Value::Constant(0),
            ExprKind::Either(None) => Value::Any,
            ExprKind::Either(Some(both)) => {
                let one = self.value(at, &both.0)?;
                let other = self.value(at, &both.1)?;
                let which = self.differs("a branch that forks is not evaluated again");
                self.chosen(which, one, other)
            }
            ExprKind::Fault(fault) => return Err((**fault).clone()),
        })
    }

    fn read(&mut self, at: &Context, place: &Place, line: u32) -> Result<Value, Fault> {
        if let Root::Temporary(id) = place.root {
            let known = self.kept.values.get(&id).cloned();
            let found = known.ok_or_else(|| self.nothing_kept(id, line))?;
            let purpose = self.tree.temporaries[id.index()].purpose;
            if matches!(purpose, Purpose::Result | Purpose::Loaded) {
                self.cost(&["LD"], "contact");
            }
            return Ok(found);
        }
        let through = &mut |own: &mut Self, place: Place| own.read(at, &place, line);
        if let Some(found) = self.each_target(at, place, line, through)? {
            return Ok(found);
        }
        if self.is_bit_of_element(at, place)
            && let Some(found) = self.each_instance(at, place, line, through)?
        {
            return Ok(found);
        }
        let found = self.find(at, place, line)?;
        if matches!(self.tree.types.get(place.ty), Typed::Standard(_) | Typed::Block(_)) {
            let message = format!("{} is an instance, and is used as a value", place.text);
            let help = "use one of its outputs, or call it with CAL or with its name and brackets";
            return Err(Fault::new(line, message).code(Code::NotModelled).help(help));
        }
        self.cost(&["LD"], "contact");
        Ok(match found {
            Found::WordBit(cell, bit, _) => Value::Bit(Logic::Bit(BitSource::WordBit(cell, bit))),
            Found::Spot(spot) => self.read_spot(&spot),
            Found::Element(element) => self.element(&element),
        })
    }

    /// The value of the variable at a spot. [`Value::Any`] for a text, a structure or an array.
    pub(super) fn read_spot(&mut self, spot: &Spot) -> Value {
        let Some(cell) = spot.tag.cell() else { return Value::Any };
        if self.tree.types.is_reference(spot.ty) {
            let words = vec![WordSource::Cell(cell)];
            return Value::Address(Number::Words(words), self.candidates(spot.ty));
        }
        match self.simple(spot) {
            Ty::Bit => Value::Bit(Logic::cell(cell)),
            ty @ Ty::Number(_) => self.as_count(Some(cell), read(cell, &ty)),
            _ => Value::Any,
        }
    }

    /// The type of a spot: a bit, a number, or [`Ty::Whole`] for everything that is not an elementary bit or number.
    pub(super) fn simple(&self, spot: &Spot) -> Ty {
        match self.tree.types.get(spot.ty) {
            Typed::Elementary(of) => of.kind().map_or(Ty::Bit, Ty::Number),
            _ => Ty::Whole,
        }
    }

    /// The value of an array element with an index computed at run time. [`Value::Any`] if its content is not modelled.
    pub(super) fn element(&mut self, element: &Element) -> Value {
        if self.tree.types.is_reference(element.spot.ty) {
            let Some(address) = element.address(false) else { return Value::Any };
            let run = Input::Run(address, Shape::Cells, Count::Exactly(1));
            let number = self.worked_out(1, Some((Operation::Copy, vec![run], 1)));
            return Value::Address(number, self.candidates(element.spot.ty));
        }
        let simple = self.simple(&element.spot);
        let is_bit = matches!(simple, Ty::Bit);
        let Some(address) = element.address(is_bit) else { return Value::Any };
        let words = match simple {
            Ty::Number(kind) => kind.words(),
            Ty::Bit => 1,
            _ => return Value::Any,
        };
        let run = Input::Run(address, Shape::Cells, Count::Exactly(words));
        if let Ty::Number(kind) = simple {
            let number = self.worked_out(words, Some((Operation::Copy, vec![run], words)));
            let cell = element.spot.tag.cell();
            return self.as_count(cell, Value::Number(kind, number));
        }
        let (cell, choice) = (self.bit_between(), self.builder.choice());
        let outputs = vec![Target::Bits(vec![BitTarget::Cell(cell)])];
        let meaning = Meaning { operation: Operation::Copy, inputs: vec![run], outputs };
        self.builder.define_followed(choice, meaning);
        self.write(vec![Write::Havoc(Region::Range { first: cell, count: 1 }, choice)]);
        Value::Bit(Logic::cell(cell))
    }

    fn binary(
        &mut self,
        at: &Context,
        operator: Operator,
        left: &Expr,
        right: &Expr,
        line: u32,
    ) -> Result<Value, Fault> {
        if matches!(operator, Operator::AndThen | Operator::OrElse) {
            let one = self.open_value(at, left)?;
            let first = self.as_bit(one, line)?;
            return self.may_skip(at, operator, first, right);
        }
        if matches!(operator, Operator::And | Operator::Or) {
            let mut found = self.both_ways(at, &[left, right], line, &mut |own, turned| {
                let (first, second) = if turned { (right, left) } else { (left, right) };
                let mut one = own.open_value(at, first)?;
                if second.calls() {
                    one = own.frozen(one);
                    if let Value::Bit(first) = &one {
                        let first = first.clone();
                        return own.may_skip(at, operator, first, second).map(|one| vec![one]);
                    }
                }
                let two = own.open_value(at, second)?;
                let (one, two) = (masked(first, one, &two), two);
                let (one, two) = (one.clone(), masked(second, two, &one));
                let (one, two) = if turned { (two, one) } else { (one, two) };
                own.combined(operator, one, two, line).map(|one| vec![one])
            })?;
            return Ok(found.pop().unwrap_or(Value::Any));
        }
        let both = [left, right];
        let mut values = self
            .operands(at, &both, line, &mut |own, which| own.open_value(at, both[which]))?
            .into_iter();
        let (one, two) = (values.next(), values.next());
        if let (Some(Value::Any), _) | (_, Some(Value::Any)) = (&one, &two) {
            let (left, right) = (self.extent(left), self.extent(right));
            self.charge_comparison(left, right);
        }
        let (Some(one), Some(two)) = (one, two) else { return Ok(Value::Any) };
        self.again(at, operator, (left, right), matches!(one, Value::Bit(_)))?;
        let wraps = may_have_wrapped(left, &one, &two) || may_have_wrapped(right, &two, &one);
        let found = self.combined(operator, one, two, line)?;
        Ok(match found {
            found if wraps => self.between(found),
            Value::Bit(_) if both.iter().any(|one| is_rounded(one)) => {
                Value::Bit(self.any_bit(ROUNDED))
            }
            found => found,
        })
    }

    /// Lowers the second operand so that it is skipped if the first one decides the result. AND_THEN and OR_ELSE always
    /// skip it, by a jump. AND and OR may skip or evaluate an operand that calls something, because compilers differ.
    fn may_skip(
        &mut self,
        at: &Context,
        operator: Operator,
        first: Logic,
        right: &Expr,
    ) -> Result<Value, Fault> {
        let line = right.line;
        let is_and = operator.eager() == Operator::And;
        let settles = if is_and { first.clone().not() } else { first.clone() };
        let cell = self.bit_between();
        self.write(vec![Write::Bit(BitTarget::Cell(cell), first)]);
        let skip = if operator == operator.eager() {
            let skips = self.any_bit(
                "an operand with a call may be skipped if the other operand decides the result",
            );
            self.jump(Logic::All(vec![settles, skips]), None)
        } else {
            self.jump(settles, Assembler::jump_key())
        };
        let two = self.value(at, right)?;
        let both = self.combined(operator, Value::Bit(Logic::cell(cell)), two, line)?;
        let both = self.as_bit(both, line)?;
        self.write(vec![Write::Bit(BitTarget::Cell(cell), both)]);
        self.land(skip);
        self.landing();
        Ok(Value::Bit(Logic::cell(cell)))
    }

    /// Evaluates some expressions from left to right. Where the order changes a result, also from right to left, and
    /// either is possible. Returns the values in source order.
    pub(super) fn operands(
        &mut self,
        at: &Context,
        exprs: &[&Expr],
        line: u32,
        eval: &mut dyn FnMut(&mut Lower<'t>, usize) -> Result<Value, Fault>,
    ) -> Result<Vec<Value>, Fault> {
        self.both_ways(at, exprs, line, &mut |own, turned| {
            let mut values: Vec<Value> = exprs.iter().map(|_| Value::Any).collect();
            for number in 0..exprs.len() {
                let which = if turned { exprs.len() - 1 - number } else { number };
                // A call must not change the values that are evaluated already.
                if exprs[which].calls() {
                    for value in &mut values {
                        let earlier = std::mem::replace(value, Value::Any);
                        *value = own.frozen(earlier);
                    }
                }
                values[which] = eval(own, which)?;
            }
            Ok(values)
        })
    }

    fn both_ways(
        &mut self,
        at: &Context,
        exprs: &[&Expr],
        line: u32,
        work: &mut Work<'_, 't>,
    ) -> Result<Vec<Value>, Fault> {
        // Only a call can change what another operand reads.
        if !exprs.iter().any(|one| one.calls()) {
            return work(self, false);
        }
        let pairs = (1..exprs.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
        let pairs: Vec<(usize, usize)> = pairs.collect();
        if !pairs.iter().any(|&(one, other)| self.order_matters(at, exprs[one], exprs[other])) {
            return work(self, false);
        }
        let calls: usize = exprs.iter().map(|one| self.acting_calls(at, one)).sum();
        if calls > MAX_CALLS {
            let told = "this expression has too many calls, and one of them changes what \
                others read";
            let help = "assign the results of the calls to separate variables first";
            return Err(Fault::new(line, told).code(Code::NotModelled).help(help));
        }
        let other = self.differs(RIGHT_FIRST);
        let turned = self.jump(other, None);
        let mut found: Vec<Value> = work(self, false)?
            .into_iter()
            .map(|value| match value {
                Value::Constant(_) => value,
                value => self.stored(value, true),
            })
            .collect();
        let end = self.jump(Logic::Const(true), None);
        self.land(turned);
        self.landing();
        for (own, value) in found.iter_mut().zip(work(self, true)?) {
            let known = std::mem::replace(own, Value::Any);
            *own = match (&known, &value) {
                (Value::Constant(one), Value::Constant(two)) if one == two => known,
                _ => self.merged(known, value),
            };
        }
        self.land(end);
        self.landing();
        Ok(found)
    }

    /// Lowers an expression to a bit. A value that is not modelled becomes any bit; a number other than a constant 0 or
    /// 1 is a fault.
    pub(super) fn bit(&mut self, at: &Context, one: &Expr) -> Result<Logic, Fault> {
        match self.value(at, one)? {
            Value::Bit(logic) => Ok(logic),
            Value::Constant(value @ (0 | 1)) => Ok(Logic::Const(value != 0)),
            Value::Any | Value::Address(..) => {
                Ok(self.any_bit("a condition whose value is not modelled: it may be true or false"))
            }
            Value::Constant(_) | Value::Number(..) | Value::Open(..) => {
                Err(wrong(one.line, "a number is used where a Boolean is required"))
            }
        }
    }

    /// Stores a value in a temporary that later statements of the body read. A temporary of purpose `Merged` that has a
    /// value already may hold either one.
    pub(super) fn keep(&mut self, id: TempId, of: Option<&Expr>, value: Value) {
        if let (Value::Any, Some(of)) = (&value, of) {
            let own = self.extent(of);
            let known = self.kept.extents.get(&id).copied().unwrap_or(Extent::One);
            self.kept.extents.insert(id, known.larger(own));
        }
        let purpose = self.tree.temporaries[id.index()].purpose;
        if purpose == Purpose::Merged
            && let Some(known) = self.kept.values.get(&id).cloned()
        {
            let merged = self.merged(known, value);
            self.kept.values.insert(id, merged);
            return;
        }
        if purpose == Purpose::Result {
            self.cost(&["ST"], "move");
        }
        let kept = self.stored(value, purpose == Purpose::Merged);
        self.kept.values.insert(id, kept);
    }

    /// Lowers an assignment of a value to a place and charges the store. `of` is the expression of the value, if it is
    /// known.
    pub(super) fn assign(
        &mut self,
        at: &Context,
        target: &Place,
        of: Option<&Expr>,
        value: Value,
        line: u32,
    ) -> Result<(), Fault> {
        if let Root::Temporary(id) = target.root {
            self.keep(id, of, value);
            return Ok(());
        }
        let through = &mut |own: &mut Self, place: Place| {
            own.assign(at, &place, of, value.clone(), line).map(|()| Value::Any)
        };
        if self.each_target(at, target, line, through)?.is_some()
            || self.is_bit_of_element(at, target)
                && self.each_instance(at, target, line, through)?.is_some()
        {
            return Ok(());
        }
        let found = self.find(at, target, line)?;
        self.assign_found(found, of, value, line)
    }

    /// Lowers an assignment to a place that was found already, and charges the store.
    pub(super) fn assign_found(
        &mut self,
        found: Found,
        of: Option<&Expr>,
        value: Value,
        line: u32,
    ) -> Result<(), Fault> {
        let ty = match &found {
            Found::Spot(spot) => Some(self.simple(spot)),
            Found::Element(element) => Some(self.simple(&element.spot)),
            Found::WordBit(..) => None,
        };
        let value = match (&ty, of) {
            (Some(Ty::Number(kind)), Some(of)) if wraps_in(of, &value, *kind) => {
                self.between(Value::Number(*kind, constant(0, kind.words())))
            }
            (Some(ty), Some(of)) => shown(of, value, ty),
            _ => value,
        };
        let key = self.store_key(&found, of, line)?;
        let writes = self.writes(found, value, line)?;
        self.add_always(key, writes);
        Ok(())
    }

    /// Lowers an assignment to an array element both ways: the index is evaluated after the value or before it.
    pub(super) fn assign_either_way(
        &mut self,
        at: &Context,
        target: &Place,
        value: &Expr,
        line: u32,
    ) -> Result<(), Fault> {
        let other = self.differs(TARGET_FIRST);
        let first = self.jump(other, None);
        // The value is stored, because the index may change what it is read from.
        let found = match self.open_value(at, value)? {
            known @ Value::Constant(_) => known,
            found => self.stored(found, true),
        };
        self.assign(at, target, Some(value), found, line)?;
        let end = self.jump(Logic::Const(true), None);
        self.land(first);
        self.landing();
        let place = self.find(at, target, line)?;
        let place = self.staying(place);
        let found = self.open_value(at, value)?;
        self.assign_found(place, Some(value), found, line)?;
        self.land(end);
        self.landing();
        Ok(())
    }

    /// Whether evaluating a value may change which array element a path selects, or evaluating the path may change the
    /// value.
    pub(super) fn moves_element(&mut self, at: &Context, target: &Place, value: &Expr) -> bool {
        let indices: Vec<&Expr> = target.indices().collect();
        indices.into_iter().any(|index| self.order_matters(at, index, value))
    }

    /// The writes that assign a value to a place, without a charge.
    pub(super) fn writes(
        &mut self,
        found: Found,
        value: Value,
        line: u32,
    ) -> Result<Vec<Write>, Fault> {
        let spot = match found {
            Found::WordBit(cell, bit, last) => {
                let logic = self.as_bit(value, line)?;
                let bits = (bit..=last).map(|bit| BitTarget::WordBit(cell, bit));
                return Ok(bits.map(|bit| Write::Bit(bit, logic.clone())).collect());
            }
            Found::Element(element) => return self.element_writes(&element, value, line),
            Found::Spot(spot) => spot,
        };
        if let (true, Some(cell)) = (self.tree.types.is_reference(spot.ty), spot.tag.cell()) {
            let number = self.reference_word(spot.ty, value, line)?;
            return Ok(vec![Write::Words(targets(cell, 1), number)]);
        }
        Ok(match (self.simple(&spot), spot.tag.cell()) {
            (Ty::Bit, Some(cell)) => {
                vec![Write::Bit(BitTarget::Cell(cell), self.as_bit(value, line)?)]
            }
            (Ty::Number(kind), Some(cell)) => {
                let number = self.as_number(value, kind);
                vec![Write::Words(targets(cell, kind.words()), number)]
            }
            // A text shares the memory of its address.
            (_, Some(_)) => {
                let choice = self.builder.choice();
                spot.tag.regions().into_iter().map(|region| Write::Havoc(region, choice)).collect()
            }
            _ => {
                let choice = self.builder.choice();
                let at = self.builder.next();
                let why = "a whole structure or array that is not modelled: it may hold any value";
                self.program().approximate(at, why);
                spot.tag.regions().into_iter().map(|region| Write::Havoc(region, choice)).collect()
            }
        })
    }

    fn element_writes(
        &mut self,
        element: &Element,
        value: Value,
        line: u32,
    ) -> Result<Vec<Write>, Fault> {
        let simple = self.simple(&element.spot);
        let is_bit = matches!(simple, Ty::Bit);
        let region = element.region();
        let Some(((first, count), address)) = region.zip(element.address(is_bit)) else {
            let message = format!(
                "{}: writing a whole array element with a run-time index is not modelled",
                element.spot.name
            );
            return Err(Fault::new(line, message).code(Code::NotModelled));
        };
        let choice = self.builder.choice();
        let outputs = vec![Target::Run(address, Shape::Cells)];
        let input = match simple {
            Ty::Bit => Input::Truth(self.as_bit(value, line)?),
            Ty::Number(kind) => Input::Number(self.as_number(value, kind)),
            _ if self.tree.types.is_reference(element.spot.ty) => {
                Input::Number(self.reference_word(element.spot.ty, value, line)?)
            }
            // A text shares the memory of its address.
            _ => return Ok(vec![Write::Havoc(Region::Range { first, count }, choice)]),
        };
        let meaning = Meaning { operation: Operation::Copy, inputs: vec![input], outputs };
        self.builder.define_followed(choice, meaning);
        Ok(vec![Write::Havoc(Region::Range { first, count }, choice)])
    }
}

impl Assembler {
    /// A duration in nanoseconds as a TIME number. Any time, reported as over-approximated, if it is finer than the
    /// unit of TIME or beyond its range.
    pub(in super::super) fn time(&mut self, nanoseconds: i64) -> Number {
        match time_in_units(nanoseconds) {
            Some(units) => constant(units.into(), 2),
            None => self.any_number(
                Kind::Time,
                "a time finer than 1 ms or beyond 12 days is not modelled: it may be any time",
            ),
        }
    }

    /// Lowers a negation and charges it as a subtraction from 0; a constant is negated without a charge. The result may
    /// overflow its type.
    pub(in super::super) fn negated(&mut self, value: Value) -> Result<Value, Fault> {
        if let Value::Constant(value) = value {
            return Ok(Value::Constant(value.wrapping_neg()));
        }
        let (value, beyond) = parted(value);
        let kind = match value {
            Value::Number(kind, _) => Some(kind),
            _ => None,
        };
        let is_real = kind.is_none_or(|kind| matches!(kind, Kind::Real | Kind::Opaque(_)));
        let class = if is_real { "real" } else { "arithmetic" };
        let names = [row(Operator::Subtract, kind), row(Operator::Subtract, None)];
        self.cost(&names, class);
        let Value::Number(kind, number) = value else { return Ok(Value::Any) };
        let zero = constant(0, kind.words());
        let negated = self.arithmetic(Operator::Subtract, kind, zero, number)?;
        Ok(opened(negated, beyond))
    }
}

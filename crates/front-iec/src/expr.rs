//! Expressions, as what the analysis follows.

use super::assembler::Assembler;
use super::emit::Emit;
use super::mixed::{mixed, typed};
use super::open::{complement, joined, may_have_wrapped, opened, parted, wraps_in};
use super::references::WORD;
use super::references::{Walk, Way};
use super::resolve::{Context, Element, Found};
use super::types::{ANY_UNIT, DINT, Kind, Refers, Ty, holding};
use super::value::{Value, constant, is_real, real, within};
use super::within::shown;
use scanbound_base::code::Code;
use scanbound_front::builder::always;
use scanbound_iec::ast::{Argument, EITHER, Expr, Literal, Operator, Path, RESULT, is_loaded};
use scanbound_iec::fault::Fault;
use scanbound_iec::parse::MERGED;
use scanbound_iec::{same, show};
pub(super) use scanbound_iec_tree::types::common;
use scanbound_ir::meaning::{Count, Meaning, Operation, OperationInput as Input, Shape, Target};
use scanbound_ir::{
    BitSource, BitTarget, Cell, ChoiceId, Compare, Logic, Number, NumberFormat, Region, Relation,
    Step, WordSource, WordTarget, Write,
};

/// The value that stands in a place.
pub(super) fn read(cell: Cell, ty: &Ty) -> Value {
    match ty {
        Ty::Bit => Value::Bit(Logic::cell(cell)),
        Ty::Number(kind) => {
            let words = (0..kind.words()).map(|at| WordSource::Cell(cell.plus(at)));
            Value::Number(*kind, Number::Words(words.collect()))
        }
        _ => Value::Any,
    }
}

/// What is told where addresses are compared that are no variables' own.
const ADDRESSES: &str = "a comparison of addresses may come out either way";

/// The word of a reference, of one that is compared with nothing, too.
fn address_word(value: &Value) -> Option<Number> {
    match value {
        Value::Address(number, _) => Some(number.clone()),
        Value::Constant(0) => Some(constant(0, 1)),
        _ => None,
    }
}

/// What is told of literals that REAL does not hold.
pub(super) const ROUNDED: &str = "a literal that REAL does not hold may be a long real: compared, it is larger or smaller than that REAL";

/// Whether REAL does not hold a literal: some compilers take it as a long real where it is not stored.
pub(super) fn is_rounded(one: &Expr) -> bool {
    let Expr::Literal(Literal::Real(text, None)) = one else { return false };
    !is_real(text)
}

/// `NOT 1` is no truth value beside a whole number.
fn masked(expr: &Expr, value: Value, beside: &Value) -> Value {
    match (expr, value, beside) {
        (Expr::Not(inner), Value::Any, Value::Number(Kind::Whole { .. }, _)) => match **inner {
            Expr::Literal(Literal::Int(number @ (0 | 1), None)) => {
                Value::Constant(if number == 0 { -1 } else { -2 })
            }
            _ => Value::Any,
        },
        (_, value, _) => value,
    }
}

fn wrong(line: u32, expr: &Expr, what: &str) -> Fault {
    Fault::new(line, format!("{} {what}", show::expr(expr))).code(Code::Operand)
}

impl Emit<'_> {
    /// The value of an expression; what it takes is charged. Where it does not fit its type, it is any number.
    pub(super) fn value(&mut self, at: &Context, expr: &Expr, line: u32) -> Result<Value, Fault> {
        let value = self.open_value(at, expr, line)?;
        Ok(self.settled(value))
    }

    /// The same for what takes no more bits of it than its type has, or knows what to do with the others.
    pub(super) fn open_value(
        &mut self,
        at: &Context,
        expr: &Expr,
        line: u32,
    ) -> Result<Value, Fault> {
        match expr {
            Expr::Literal(literal) => self.literal(literal, expr, line),
            Expr::Variable(path) => self.variable_value(at, path, line),
            Expr::Not(inner) => {
                let value = self.open_value(at, inner, line)?;
                self.cost(&["NOT"], "logic");
                Ok(complement(value))
            }
            Expr::Negate(inner) => {
                let value = self.open_value(at, inner, line)?;
                self.negated(value)
            }
            Expr::Binary(operator, left, right) => self.binary(at, *operator, left, right, line),
            Expr::Call(path, given) if path.first == EITHER => self.either(at, given, line),
            // What a drawing says and cannot be read: it may be anything, and take any time.
            Expr::Call(path, given) if path.first.starts_with('~') => {
                let why = given.first().map_or_else(String::new, |why| show::expr(&why.value));
                Err(Fault::new(line, format!("a condition cannot be read: {why}"))
                    .code(Code::NotModelled))
            }
            Expr::Call(path, given) => self.function(at, path, given, line),
        }
    }

    fn literal(&mut self, literal: &Literal, expr: &Expr, line: u32) -> Result<Value, Fault> {
        Ok(match literal {
            Literal::Bool(value) => Value::Bit(Logic::Const(*value)),
            Literal::Int(value, of) => {
                let small =
                    i64::try_from(*value).or_else(|_| u64::try_from(*value).map(u64::cast_signed));
                let value = small.map_err(|_| wrong(line, expr, "is too large"))?;
                match of.as_deref().and_then(super::types::elementary) {
                    Some(Ty::Number(kind @ Kind::Whole { .. })) => {
                        Value::Number(kind, within(kind, value))
                    }
                    Some(Ty::Bit) => Value::Bit(Logic::Const(value != 0)),
                    _ => Value::Constant(value),
                }
            }
            Literal::Real(text, of) if of.as_deref() != Some("LREAL") => {
                real(text).map_or(Value::Any, |bits| Value::Number(Kind::Real, bits))
            }
            Literal::Time(time) => Value::Number(Kind::Time, self.time(*time)),
            Literal::Real(..) | Literal::Date(_) => {
                let why = "a long real or a date is not followed: it may be any";
                Value::Number(Kind::Opaque(4), self.any_number(Kind::Opaque(4), why))
            }
            Literal::Text(_) => Value::Any,
        })
    }

    fn variable_value(&mut self, at: &Context, path: &Path, line: u32) -> Result<Value, Fault> {
        if same(&path.first, "THIS") && path.rest.is_empty() {
            return self.address(at, &Expr::Variable(path.clone()), Refers::Pointer, line);
        }
        match self.walk(at, path, true) {
            Walk::Way(Way::Referred(way)) => {
                return self.each_target(at, &way, line, &mut |emit, path| {
                    emit.variable_value(at, &path, line)
                });
            }
            Walk::Way(Way::Property(property)) => return self.property_value(at, &property, line),
            Walk::Unknown if path.as_name().is_some_and(|name| same(name, "NULL")) => {
                return Ok(Value::Constant(0));
            }
            _ => {}
        }
        let found = self.find_plain(at, path, line)?;
        if let Found::Place(place) = &found
            && matches!(place.ty, Ty::Standard(..) | Ty::Block(..))
        {
            let message =
                format!("{} is an instance: as a value it is not followed", show::path(path));
            let help = "name one of its outputs, or call it with CAL or its name and brackets";
            return Err(Fault::new(line, message).code(Code::NotModelled).help(help));
        }
        if !matches!(found, Found::Value(_)) || is_loaded(&path.first) {
            self.cost(&["LD"], "contact");
        }
        Ok(match found {
            Found::Value(value) => value,
            Found::WordBit(cell, bit, _) => Value::Bit(Logic::Bit(BitSource::WordBit(cell, bit))),
            Found::Place(place) => match place.tag.cell() {
                Some(cell) => self.read_of(cell, &place.ty),
                None => Value::Any,
            },
            Found::Element(element) => self.element(&element),
            Found::Elapsed(time) => read(time, &Ty::Number(Kind::Time)),
        })
    }

    /// The value of an element whose number is worked out.
    pub(super) fn element(&mut self, element: &Element) -> Value {
        let is_one = matches!(element.place.ty, Ty::Bit | Ty::Number(_) | Ty::Reference(..));
        let (Some(address), true) = (element.address(), is_one) else {
            return Value::Any;
        };
        let words = match element.place.ty {
            Ty::Number(kind) => kind.words(),
            _ => 1,
        };
        let run = Input::Run(address, Shape::Cells, Count::Exactly(words));
        if let Ty::Number(kind) = element.place.ty {
            let number = self.worked_out(words, Some((Operation::Copy, vec![run], words)));
            let cell = element.place.tag.cell();
            return self.as_count(cell, Value::Number(kind, number));
        }
        if let Ty::Reference(kind, of) = element.place.ty.clone() {
            let number = self.worked_out(words, Some((Operation::Copy, vec![run], words)));
            return Value::Address(number, self.candidates(kind, &of));
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
            let one = self.open_value(at, left, line)?;
            let first = self.as_bit(one, line)?;
            return self.may_skip(at, operator, first, right, line);
        }
        if matches!(operator, Operator::And | Operator::Or) {
            return self.in_either_order(at, &[left, right], line, &mut |emit, turned| {
                let (first, second) = if turned { (right, left) } else { (left, right) };
                let mut one = emit.open_value(at, first, line)?;
                if emit.calls_own(second) {
                    one = emit.frozen(one);
                    if let Value::Bit(first) = &one {
                        return emit.may_skip(at, operator, first.clone(), second, line);
                    }
                }
                let two = emit.open_value(at, second, line)?;
                let (one, two) = (masked(first, one, &two), two);
                let (one, two) = (one.clone(), masked(second, two, &one));
                let (one, two) = if turned { (two, one) } else { (one, two) };
                emit.combined(operator, one, two, line)
            });
        }
        let both = [left, right];
        let mut values = self
            .operands(at, &both, line, &mut |emit, which| emit.open_value(at, both[which], line))?
            .into_iter();
        let (one, two) = (values.next(), values.next());
        if let (Some(Value::Any), _) | (_, Some(Value::Any)) = (&one, &two) {
            let (left, right) = (self.extent(at, left), self.extent(at, right));
            self.charge_comparison(left, right);
        }
        let (Some(one), Some(two)) = (one, two) else { return Ok(Value::Any) };
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

    /// Lowers the second operand so that it is skipped if the first one decides the result: always for AND_THEN and
    /// OR_ELSE, which take a jump for it; perhaps for AND and OR whose second operand calls something, as compilers differ.
    fn may_skip(
        &mut self,
        at: &Context,
        operator: Operator,
        first: Logic,
        right: &Expr,
        line: u32,
    ) -> Result<Value, Fault> {
        let is_and = operator.eager() == Operator::And;
        let settles = if is_and { first.clone().not() } else { first.clone() };
        let cell = self.bit_between();
        self.write(vec![Write::Bit(BitTarget::Cell(cell), first)]);
        let skip = if operator == operator.eager() {
            let skips = self.any_bit("an operand that calls something may be left out where the result is settled without it");
            self.jump(Logic::All(vec![settles, skips]), None)
        } else {
            self.jump(settles, Some(Assembler::key(&["JMP"], "jump")))
        };
        let two = self.value(at, right, line)?;
        let both = self.combined(operator, Value::Bit(Logic::cell(cell)), two, line)?;
        let both = self.as_bit(both, line)?;
        self.write(vec![Write::Bit(BitTarget::Cell(cell), both)]);
        self.land(skip);
        self.landing();
        Ok(Value::Bit(Logic::cell(cell)))
    }

    /// One of two values, of which it is not known which.
    fn either(&mut self, at: &Context, given: &[Argument], line: u32) -> Result<Value, Fault> {
        let [one, two] = given else { return Ok(Value::Any) };
        let one = self.value(at, &one.value, line)?;
        let two = self.value(at, &two.value, line)?;
        let which = self.differs("a way that forks is not looked at again");
        self.chosen(which, one, two, line)
    }

    /// An expression as a bit.
    pub(super) fn bit(&mut self, at: &Context, expr: &Expr, line: u32) -> Result<Logic, Fault> {
        match self.value(at, expr, line)? {
            Value::Bit(logic) => Ok(logic),
            Value::Constant(value @ (0 | 1)) => Ok(Logic::Const(value != 0)),
            Value::Any | Value::Address(..) => {
                Ok(self.any_bit("a condition that is not followed: it may be true or false"))
            }
            Value::Constant(_) | Value::Number(..) | Value::Open(..) => {
                Err(wrong(line, expr, "is a number, where a truth value is asked for"))
            }
        }
    }

    /// An expression as a number of a kind.
    pub(super) fn number(
        &mut self,
        at: &Context,
        expr: &Expr,
        kind: Kind,
        line: u32,
    ) -> Result<Number, Fault> {
        let value = self.value(at, expr, line)?;
        self.as_number(value, kind, line)
    }

    /// Writes a value where a path leads; charged as a store.
    pub(super) fn assign(
        &mut self,
        at: &Context,
        target: &Path,
        value: Value,
        line: u32,
    ) -> Result<(), Fault> {
        self.assign_of(at, target, None, value, line)
    }

    /// The same with the value of an expression.
    pub(super) fn assign_of(
        &mut self,
        at: &Context,
        target: &Path,
        of: Option<&Expr>,
        value: Value,
        line: u32,
    ) -> Result<(), Fault> {
        if target.first.starts_with('~')
            && target.rest.is_empty()
            && !self.has_variable(at, &target.first)
        {
            if let (Value::Any, Some(of)) = (&value, of) {
                self.note_extent(at, &target.first, of);
            }
            if target.first.starts_with(MERGED)
                && let Some(known) = self.kept.get(&target.first).cloned()
            {
                let merged = self.merged(known, value);
                self.kept.insert(target.first.clone(), merged);
                return Ok(());
            }
            if target.first.starts_with(RESULT) {
                self.cost(&["ST"], "move");
            }
            let kept = self.stored(value, target.first.starts_with(MERGED));
            self.kept.insert(target.first.clone(), kept);
            return Ok(());
        }
        // A reference is given back as it is, all else goes to what it refers to.
        let to_end = !matches!(value, Value::Address(..));
        match self.walk(at, target, to_end) {
            Walk::Way(Way::Referred(way)) => {
                let done = self.each_target(at, &way, line, &mut |emit, path| {
                    emit.assign_of(at, &path, of, value.clone(), line)?;
                    Ok(Value::Any)
                });
                return done.map(|_| ());
            }
            Walk::Way(Way::Property(_)) => {
                let what =
                    format!("{} is a property, which is not followed here", show::path(target));
                let help = "take the result into a variable, and assign that to the property";
                return Err(Fault::new(line, what).code(Code::NotModelled).help(help));
            }
            _ => {}
        }
        let found = self.find_plain(at, target, line)?;
        self.assign_found(found, of, value, line)
    }

    /// Writes a value to what was found.
    pub(super) fn assign_found(
        &mut self,
        found: Found,
        of: Option<&Expr>,
        value: Value,
        line: u32,
    ) -> Result<(), Fault> {
        let ty = match &found {
            Found::Place(place) => Some(&place.ty),
            Found::Element(element) => Some(&element.place.ty),
            _ => None,
        };
        let value = match (ty, of) {
            (Some(Ty::Number(kind)), Some(of)) if wraps_in(of, &value, *kind) => {
                self.between(Value::Number(*kind, constant(0, kind.words())))
            }
            (Some(ty), Some(of)) => shown(of, value, ty),
            _ => value,
        };
        let key = self.store_key(&found, of, line)?;
        let writes = self.writes(found, value, line)?;
        let effects = writes.into_iter().map(always).collect();
        self.builder.add(Some(key), effects, Step::Nothing);
        Ok(())
    }

    /// What writes a value to what was found.
    pub(super) fn writes(
        &mut self,
        found: Found,
        value: Value,
        line: u32,
    ) -> Result<Vec<Write>, Fault> {
        let place = match found {
            Found::WordBit(cell, bit, last) => {
                let logic = self.as_bit(value, line)?;
                let bits = (bit..=last).map(|bit| BitTarget::WordBit(cell, bit));
                return Ok(bits.map(|bit| Write::Bit(bit, logic.clone())).collect());
            }
            Found::Value(_) | Found::Elapsed(_) => {
                return Err(Fault::new(line, "a constant or a step's flag cannot be written")
                    .code(Code::Operand));
            }
            Found::Element(element) => return self.element_writes(&element, value, line),
            Found::Place(place) => place,
        };
        Ok(match (&place.ty, place.tag.cell()) {
            (Ty::Bit, Some(cell)) => {
                let logic = self.as_bit(value, line)?;
                vec![Write::Bit(BitTarget::Cell(cell), logic)]
            }
            (Ty::Number(kind), Some(cell)) => {
                let number = self.as_number(value, *kind, line)?;
                let targets = (0..kind.words()).map(|at| WordTarget::Cell(cell.plus(at))).collect();
                vec![Write::Words(targets, number)]
            }
            (Ty::Reference(..), Some(cell)) => {
                let number = self.reference_word(&place, value, line)?;
                vec![Write::Words(vec![WordTarget::Cell(cell)], number)]
            }
            (Ty::Text(_), _) => Vec::new(),
            _ => {
                let choice = self.builder.choice();
                let at = self.builder.next();
                let why =
                    "a structure or array as a whole that is not followed: it may hold anything";
                self.program().approximate(at, why);
                place.tag.regions().into_iter().map(|region| Write::Havoc(region, choice)).collect()
            }
        })
    }

    fn element_writes(
        &mut self,
        element: &Element,
        value: Value,
        line: u32,
    ) -> Result<Vec<Write>, Fault> {
        let region = element.region();
        let Some(((first, count), address)) = region.zip(element.address()) else {
            let message = format!(
                "{}: a whole element of unknown number is not followed",
                element.place.name
            );
            return Err(Fault::new(line, message).code(Code::NotModelled));
        };
        let choice: ChoiceId = self.builder.choice();
        let outputs = vec![Target::Run(address, Shape::Cells)];
        let input = match element.place.ty {
            Ty::Bit => Input::Truth(self.as_bit(value, line)?),
            Ty::Number(kind) => {
                let number = self.as_number(value, kind, line)?;
                Input::Number(number)
            }
            Ty::Reference(..) => Input::Number(self.reference_word(&element.place, value, line)?),
            _ => return Ok(Vec::new()),
        };
        let meaning = Meaning { operation: Operation::Copy, inputs: vec![input], outputs };
        self.builder.define_followed(choice, meaning);
        Ok(vec![Write::Havoc(Region::Range { first, count }, choice)])
    }
}

impl Assembler {
    /// Two values and what is done with them.
    pub(super) fn combined(
        &mut self,
        operator: Operator,
        one: Value,
        two: Value,
        line: u32,
    ) -> Result<Value, Fault> {
        use Operator as O;
        let operator = operator.eager();
        let relation = match operator {
            O::Equal => Some(Relation::Equal),
            O::NotEqual => Some(Relation::NotEqual),
            O::Less => Some(Relation::Less),
            O::LessOrEqual => Some(Relation::LessOrEqual),
            O::Greater => Some(Relation::Greater),
            O::GreaterOrEqual => Some(Relation::GreaterOrEqual),
            _ => None,
        };
        let (one, two) = match (one, two) {
            // TRUE and 1 are the same where bits are asked for.
            (Value::Bit(bit), Value::Constant(value)) => {
                (Value::Bit(bit), Value::Bit(Logic::Const(value != 0)))
            }
            (Value::Constant(value), Value::Bit(bit)) => {
                (Value::Bit(Logic::Const(value != 0)), Value::Bit(bit))
            }
            (Value::Constant(one), Value::Constant(two)) => {
                let kind = holding(holding(DINT, one), two);
                // What constants make has the type of what it is used with, as they have.
                if let (None, Some(value)) = (relation, operator.of_constants(one, two)) {
                    let names = [row(operator, Some(kind)), row(operator, None)];
                    self.cost(&names, class_of(operator, kind));
                    return Ok(Value::Constant(value));
                }
                let number = |value| Value::Number(kind, constant(value, kind.words()));
                (number(one), number(two))
            }
            other => other,
        };
        if let (Some(relation @ (Relation::Equal | Relation::NotEqual)), Some(left), Some(right)) =
            (relation, address_word(&one), address_word(&two))
            && matches!((&one, &two), (Value::Address(..), _) | (_, Value::Address(..)))
        {
            self.cost(&[row(operator, Some(WORD)), row(operator, None)], "compare");
            let compare = Compare { relation, format: NumberFormat::Unsigned, left, right };
            return Ok(Value::Bit(Logic::Compare(Box::new(compare))));
        }
        let ((one, open), (two, also)) = (parted(one), parted(two));
        match typed(one, two) {
            (Value::Bit(one), Value::Bit(two)) => {
                self.cost(&[row(operator, None)], "logic");
                let differ = || {
                    let only = |a: &Logic, b: &Logic| Logic::All(vec![a.clone(), b.clone().not()]);
                    Logic::Any(vec![only(&one, &two), only(&two, &one)])
                };
                Ok(Value::Bit(match operator {
                    O::And => Logic::All(vec![one, two]),
                    O::Or => Logic::Any(vec![one, two]),
                    O::Xor | O::NotEqual => differ(),
                    O::Equal => differ().not(),
                    _ => {
                        return Err(Fault::new(
                            line,
                            format!("bits have no {}", operator.symbol()),
                        ));
                    }
                }))
            }
            (Value::Number(own, one), Value::Constant(two)) => {
                let kind = holding(own, two);
                let one = self.operand((own, one, open), kind, relation);
                let two = (self.constant_as(kind, two), None);
                self.numbers(operator, relation, kind, one, two)
            }
            (Value::Constant(one), Value::Number(own, two)) => {
                let kind = holding(own, one);
                let one = (self.constant_as(kind, one), None);
                let two = self.operand((own, two, also), kind, relation);
                self.numbers(operator, relation, kind, one, two)
            }
            (Value::Address(..), _) | (_, Value::Address(..)) if relation.is_some() => {
                self.cost(&[row(operator, Some(WORD)), row(operator, None)], "compare");
                Ok(Value::Bit(self.any_bit(ADDRESSES)))
            }
            (Value::Number(one, _), Value::Number(two, _))
                if (one == Kind::Time) != (two == Kind::Time)
                    && (relation.is_some()
                        || matches!(operator, O::Add | O::Subtract)
                            && ![one, two].iter().any(|kind| matches!(kind, Kind::Opaque(_)))) =>
            {
                let names = [row(operator, Some(Kind::Time)), row(operator, None)];
                self.cost(&names, class_of(operator, Kind::Time));
                Ok(match relation {
                    Some(_) => Value::Bit(self.any_bit(ANY_UNIT)),
                    None => Value::Number(Kind::Time, self.any_number(Kind::Time, ANY_UNIT)),
                })
            }
            (Value::Number(one_kind, one), Value::Number(two_kind, two)) => {
                if let Some(kind) = mixed(one_kind, two_kind) {
                    let one = self.operand((one_kind, one, open), kind, relation);
                    let two = self.operand((two_kind, two, also), kind, relation);
                    return self.mixed_numbers(operator, relation, kind, one, two);
                }
                let kind = common(one_kind, two_kind);
                let one = self.operand((one_kind, one, open), kind, relation);
                let two = self.operand((two_kind, two, also), kind, relation);
                self.numbers(operator, relation, kind, one, two)
            }
            _ => {
                self.cost(&[row(operator, None), "FUNCTION"], "special");
                Ok(match relation {
                    Some(_) => Value::Bit(self.any_bit(
                        "a comparison of texts, dates or long reals may come out either way",
                    )),
                    None => Value::Any,
                })
            }
        }
    }

    fn constant_as(&mut self, kind: Kind, value: i64) -> Number {
        match kind {
            Kind::Real => real(&value.to_string()).unwrap_or_else(|| constant(0, 2)),
            _ => within(kind, value),
        }
    }

    pub(super) fn numbers(
        &mut self,
        operator: Operator,
        relation: Option<Relation>,
        kind: Kind,
        (left, open): (Number, Option<Logic>),
        (right, also): (Number, Option<Logic>),
    ) -> Result<Value, Fault> {
        let names = [row(operator, Some(kind)), row(operator, None)];
        self.cost(&names, class_of(operator, kind));
        let Some(relation) = relation else {
            let beyond = joined(operator, kind, (&left, open), (&right, also));
            let found = self.arithmetic(operator, kind, left, right)?;
            // A quotient shows all bits of what is divided.
            return Ok(match operator {
                Operator::Divide | Operator::Modulo | Operator::Power => {
                    let beyond = beyond.map(|beyond| self.keep_bit(beyond));
                    self.any_where(found, beyond)
                }
                _ => opened(found, beyond),
            });
        };
        if matches!(kind, Kind::Opaque(_)) {
            return Ok(Value::Bit(
                self.any_bit("a comparison of long reals or dates may come out either way"),
            ));
        }
        let format = match kind {
            Kind::Real => {
                let choice = self.builder.choice();
                NumberFormat::Real(choice)
            }
            kind if kind.is_signed() => NumberFormat::Signed,
            _ => NumberFormat::Unsigned,
        };
        let (mut left, mut right) = (left, right);
        let edge = match kind {
            Kind::Time => self.edge_of_comparison(&mut left, &mut right),
            _ => None,
        };
        let compare = Logic::Compare(Box::new(Compare { relation, format, left, right }));
        let beyond: Vec<Logic> = open.into_iter().chain(also).chain(edge).collect();
        Ok(Value::Bit(match beyond.is_empty() {
            true => compare,
            false => self.open_bit(compare, Logic::Any(beyond)),
        }))
    }

    /// A value as a number of a kind.
    pub(super) fn as_number(
        &mut self,
        value: Value,
        kind: Kind,
        line: u32,
    ) -> Result<Number, Fault> {
        match value {
            Value::Number(from, _) if (from == Kind::Time) != (kind == Kind::Time) => {
                Ok(self.any_number(kind, ANY_UNIT))
            }
            Value::Number(from, number) => Ok(self.converted(number, from, kind)),
            Value::Open(from, number, beyond) => {
                Ok(self.operand((from, number, Some(beyond)), kind, None).0)
            }
            Value::Constant(value) => Ok(self.constant_as(kind, value)),
            Value::Any | Value::Address(..) => {
                self.charge_any_conversion(kind);
                Ok(self.any_number(kind, "a value that is not followed: it may be any number"))
            }
            Value::Bit(logic) => {
                let _ = line;
                Ok(self.bit_number(logic, kind))
            }
        }
    }

    /// 1 or 0.
    fn bit_number(&mut self, logic: Logic, kind: Kind) -> Number {
        let first = self.words_between(kind.words());
        let targets = (0..kind.words()).map(|at| WordTarget::Cell(first.plus(at))).collect();
        self.write(vec![Write::Words(targets, constant(0, kind.words()))]);
        let one = self.constant_as(kind, 1);
        let targets = (0..kind.words()).map(|at| WordTarget::Cell(first.plus(at))).collect();
        self.write_if(logic, vec![Write::Words(targets, one)], None);
        Number::Words((0..kind.words()).map(|at| WordSource::Cell(first.plus(at))).collect())
    }

    /// The words of a number as they are now.
    pub(super) fn copied(&mut self, number: Number, words: u32) -> Vec<WordSource> {
        let first = self.words_between(words);
        let targets = (0..words).map(|at| WordTarget::Cell(first.plus(at))).collect();
        self.write(vec![Write::Words(targets, number)]);
        (0..words).map(|at| WordSource::Cell(first.plus(at))).collect()
    }

    pub(super) fn as_bit(&mut self, value: Value, line: u32) -> Result<Logic, Fault> {
        match value {
            Value::Bit(logic) => Ok(logic),
            Value::Constant(value @ (0 | 1)) => Ok(Logic::Const(value != 0)),
            Value::Any | Value::Address(..) => {
                Ok(self.any_bit("a value that is not followed: it may be true or false"))
            }
            Value::Constant(_) | Value::Number(..) | Value::Open(..) => {
                Err(Fault::new(line, "a number stands where a truth value is asked for")
                    .code(Code::Operand))
            }
        }
    }
}

/// The row that prices an operator.
pub(super) fn row(operator: Operator, kind: Option<Kind>) -> &'static str {
    use Operator as O;
    let is_real = matches!(kind, Some(Kind::Real | Kind::Opaque(_)));
    match (operator, is_real) {
        (O::Or | O::OrElse, _) => "OR",
        (O::Xor, _) => "XOR",
        (O::And | O::AndThen, _) => "AND",
        (O::Equal, _) => "EQ",
        (O::NotEqual, _) => "NE",
        (O::Less, _) => "LT",
        (O::LessOrEqual, _) => "LE",
        (O::Greater, _) => "GT",
        (O::GreaterOrEqual, _) => "GE",
        (O::Add, false) => "ADD",
        (O::Subtract, false) => "SUB",
        (O::Multiply, false) => "MUL",
        (O::Divide, false) => "DIV",
        (O::Modulo, _) => "MOD",
        (O::Power, _) => "EXPT",
        (O::Add, true) => "ADD:REAL",
        (O::Subtract, true) => "SUB:REAL",
        (O::Multiply, true) => "MUL:REAL",
        (O::Divide, true) => "DIV:REAL",
    }
}

/// The class that prices an operator.
fn class_of(operator: Operator, kind: Kind) -> &'static str {
    use Operator as O;
    match (kind, operator) {
        (_, O::Power) => "special",
        (Kind::Real | Kind::Opaque(_), _) => "real",
        (_, O::Multiply) => "multiply",
        (_, O::Divide | O::Modulo) => "divide",
        (_, O::Equal | O::NotEqual | O::Less | O::LessOrEqual | O::Greater | O::GreaterOrEqual) => {
            "compare"
        }
        _ => "arithmetic",
    }
}

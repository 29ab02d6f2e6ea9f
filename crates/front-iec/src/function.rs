//! Functions: the standard's, and the project's own.

use super::assembler::Assembler;
use super::convert::lengthens_bits;
use super::emit::{Emit, Place, What};
use super::expr::{is_rounded, row};
use super::mixed::mixed;
use super::open::{complement, parted};
use super::resolve::{Context, Found, unknown};
use super::types::{ANY_UNIT, DINT, Extent, INT, Kind, Ty, declare, elementary, is_elementary};
use super::value::Value;
use super::whole::Whole;
use super::within::{shown, works};
use scanbound_base::code::Code;
use scanbound_front::builder::always;
use scanbound_iec::ast::{Argument, Expr, Operator, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::parse::{CONSTRUCTED, LISTED, UNREAD};
use scanbound_iec::{Pou, PouKind, Section, Variable, same, show};
use scanbound_ir::{Logic, Number, Step};

impl<'p> Emit<'p> {
    /// The result of a function or a method.
    pub(super) fn function(
        &mut self,
        at: &Context,
        path: &Path,
        given: &[Argument],
        line: u32,
    ) -> Result<Value, Fault> {
        // A method of the unit's own hides functions.
        if let Some(name) = path.as_name()
            && self.has_member(at, name)
            && self.method_of(at.instance, name).is_some()
        {
            return self.method(at, at.instance, name, given, line);
        }
        if let Some(value) = self.function_through(at, path, given, line)? {
            return Ok(value);
        }
        if let Some(name) = path.as_name() {
            let own = self
                .project
                .pous
                .iter()
                .position(|pou| same(&pou.name, name) && pou.kind == PouKind::Function);
            if let Some(pou) = own {
                return self.own_function(at, pou, given, line);
            }
            return self.standard(at, name, given, line);
        }
        if let Some((owner, name)) = path.split_last() {
            let found = self.find(at, &owner, line)?;
            if let Some(instance) = self.instance_at(&found) {
                return self.method(at, instance, name, given, line);
            }
        }
        Err(unknown(line, &show::path(path)))
    }

    /// A function of the project's: its variables are its own, and begin anew at each call.
    fn own_function(
        &mut self,
        at: &Context,
        pou: usize,
        given: &[Argument],
        line: u32,
    ) -> Result<Value, Fault> {
        let project = self.project;
        let own = &project.pous[pou];
        // Each task has its own: one may interrupt another in the midst of the function.
        let name = match self.task {
            0 => format!("function {}", own.name),
            task => format!("function {} of task {}", own.name, task + 1),
        };
        let instance = match self.by_name.get(&name.to_ascii_uppercase()) {
            Some(&known) => known,
            None => {
                let parts = self.types.variables(pou, None)?;
                let place = self.variable(&name, Ty::Parts(parts), own.line)?;
                self.instance(&place, pou)
            }
        };
        let place = self.instances[instance].place.clone();
        self.leaves_none_out(&own.variables, given, line)?;
        self.has_one_name(at, None, &own.variables, given, line)?;
        let enabled = self.begin_enabled(at, &place, given, line)?;
        self.hand_over(at, &place, &own.variables, given, line)?;
        let inner = Context { instance, locals: None, unit: pou };
        self.begin_anew(&inner, &place, &own.variables, given, line)?;
        self.begin_result(&inner, &place, own, line)?;
        self.call(Logic::Const(true), instance, What::Body, "CAL");
        self.take_back(at, &place, &own.variables, given, line)?;
        let result = match own.result {
            Some(_) => self.result(&place, &own.name, line)?,
            None => Value::Any,
        };
        let enable = self.end_enabled(at, &place, enabled, given, line)?;
        self.open_outputs(at, enable.as_ref(), given, line)?;
        self.result_if(enable, result, line)
    }

    pub(super) fn result(&mut self, place: &Place, name: &str, line: u32) -> Result<Value, Fault> {
        let own = Self::part(place, name).ok_or_else(|| unknown(line, name))?;
        let Some(cell) = own.tag.cell() else { return Ok(Value::Any) };
        // It is kept, since another call may follow in the same expression.
        let value = self.read_of(cell, &own.ty);
        Ok(match value {
            Value::Address(..) => self.frozen(value),
            Value::Bit(logic) => Value::Bit(self.keep_bit(logic)),
            Value::Number(kind, number) => {
                let zero = super::value::constant(0, kind.words());
                let sum = Number::Add(Box::new(number), Box::new(zero));
                let words = self.words(sum, kind.words());
                Value::Number(kind, Number::Words(words))
            }
            other => other,
        })
    }

    /// Takes outputs, and gives what was handed over in and out back.
    pub(super) fn take_back(
        &mut self,
        at: &Context,
        place: &Place,
        variables: &[Variable],
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        let is_both = |name: &str| is_handed(variables, name);
        // What is handed over in and out is the caller's own variable: it has its value before any output is taken.
        let (handed, others): (Vec<_>, Vec<_>) = parameters(variables, given)
            .filter_map(|(name, argument)| Some((name?, argument)))
            .filter(|(name, argument)| argument.is_output || is_both(name))
            .partition(|(name, _)| is_both(name));
        for (name, argument) in handed.into_iter().chain(others) {
            let (target, negated) = match &argument.value {
                Expr::Variable(path) if !path.first.is_empty() => (path, false),
                Expr::Not(inner) => match inner.as_ref() {
                    Expr::Variable(path) => (path, true),
                    _ => continue,
                },
                _ => continue,
            };
            let Some(from) = Self::part(place, name) else { continue };
            let begin = self.builder.next();
            self.note_count(&place.ty, &from);
            if let Some(cell) = from.tag.cell() {
                let mut value = self.read_of(cell, &from.ty);
                if let (Value::Bit(logic), true) = (&value, negated) {
                    value = Value::Bit(logic.clone().not());
                }
                self.cost(&["LD"], "contact");
                self.assign(at, target, value, line)?;
            } else if let Some(to) = self.whole(at, target, line)? {
                let from = Whole::Place(from);
                match is_both(name) {
                    true => self.copy_handed(&from, &to),
                    false => self.copy_whole(&from, &to, line)?,
                }
            }
            if is_both(name) {
                self.given_back.push((begin..self.builder.next(), self.file, line));
            }
        }
        Ok(())
    }

    /// What is not handed over begins anew: as it is declared, else with 0.
    pub(super) fn begin_anew(
        &mut self,
        at: &Context,
        place: &Place,
        variables: &[Variable],
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        let is_given = |own: &str| {
            parameters(variables, given).any(|(name, _)| name.is_some_and(|name| same(name, own)))
        };
        let begins = |one: &&Variable| match one.section {
            // The constants of a unit are known by their declaration.
            Section::Local | Section::Temp | Section::Output => {
                !one.constant || at.locals.is_some()
            }
            Section::Input => !is_given(&one.name),
            Section::InOut
            | Section::External
            | Section::Global
            | Section::Static
            | Section::Instance => false,
        };
        for one in variables.iter().filter(|one| one.section == Section::Local && one.constant) {
            let ty = Self::part_type(place, &one.name).unwrap_or(Ty::Bit);
            self.begins_without_call(one, &ty, line)?;
        }
        for one in variables.iter().filter(begins) {
            let Some(part) = Self::part(place, &one.name) else { continue };
            self.begins_plain(&part, one.initial.is_some(), line)?;
            self.begins_without_call(one, &part.ty, line)?;
            let value = match &one.initial {
                initial if matches!(part.ty, Ty::Reference(..)) => match (initial, &part.ty) {
                    (Some(initial), Ty::Reference(kind, _)) => {
                        self.address(at, initial, *kind, line)?
                    }
                    _ => Value::Constant(0),
                },
                Some(initial) => match self.constant(at, initial) {
                    Some(known) => Value::Constant(known),
                    None if is_worked_out(initial) && part.tag.cell().is_some() => {
                        let work = |emit: &mut Self| emit.open_value(at, initial, line);
                        let found = match one.constant {
                            true => self.charged_already(work),
                            false => work(self),
                        }?;
                        shown(initial, found, &part.ty)
                    }
                    None => Value::Any,
                },
                None if is_elementary(one) => Value::Constant(0),
                None => self.types.first_named(&one.of).map_or(Value::Any, Value::Constant),
            };
            let value = match (&part.ty, value, &one.initial) {
                (Ty::Bit, Value::Any, Some(initial)) if initial.is(true) || initial.is(false) => {
                    Value::Bit(Logic::Const(initial.is(true)))
                }
                (_, value, _) => value,
            };
            self.forget(&part, line)?;
            let key = (!one.constant).then(|| self.begin_key(&part.ty));
            let writes = self.writes(Found::Place(part), value, line)?;
            let effects = writes.into_iter().map(always).collect();
            self.builder.add(key, effects, Step::Nothing);
        }
        Ok(())
    }

    /// The result begins with what its type begins with.
    pub(super) fn begin_result(
        &mut self,
        at: &Context,
        place: &Place,
        of: &Pou,
        line: u32,
    ) -> Result<(), Fault> {
        let Some(ty) = &of.result else { return Ok(()) };
        let result = Variable {
            name: of.result_name().to_owned(),
            section: Section::Local,
            of: ty.clone(),
            initial: None,
            at: None,
            constant: false,
            retain: false,
            line: of.line,
        };
        self.begin_anew(at, place, &[result], &[], line)
    }

    /// A function of the standard.
    fn standard(
        &mut self,
        at: &Context,
        name: &str,
        given: &[Argument],
        line: u32,
    ) -> Result<Value, Fault> {
        if !given.iter().any(|one| is_named(one, "EN") || is_named(one, "ENO")) {
            return self.seen_bits(at, name, given, line);
        }
        let place = self.instances[at.instance].place.clone();
        let none = Place { ty: Ty::Parts(Default::default()), ..place };
        let enabled = self.begin_enabled(at, &none, given, line)?;
        let result = self.seen_bits(at, name, given, line)?;
        let result = self.frozen(result);
        let enable = self.end_enabled(at, &none, enabled, given, line)?;
        self.open_outputs(at, enable.as_ref(), given, line)?;
        self.result_if(enable, result, line)
    }

    /// What a function of the standard works out, or anything where that shows how many bits are kept of its inputs.
    fn seen_bits(
        &mut self,
        at: &Context,
        name: &str,
        given: &[Argument],
        line: u32,
    ) -> Result<Value, Fault> {
        let found = self.worked(at, name, given, line)?;
        let upper = name.to_ascii_uppercase();
        let shows = SHOWS_BITS.contains(&upper.as_str())
            || decimal(&upper).is_some()
            || lengthens_bits(&upper);
        let mut inputs = given.iter().filter(|one| !one.is_output).map(|one| &one.value);
        // What was given more bits than 32 shows those of a sum of 32.
        let is_long = matches!(found, Value::Number(Kind::Whole { bits: 64, .. }, _));
        let chooses = CHOOSES.contains(&upper.as_str());
        if chooses && inputs.clone().any(is_rounded) {
            return Ok(self.between(found));
        }
        let differs = (shows || is_long) && inputs.any(works);
        Ok(if differs { self.between(found) } else { found })
    }

    /// What a function of the standard works out, each number at the size of its type.
    fn worked(
        &mut self,
        at: &Context,
        name: &str,
        given: &[Argument],
        line: u32,
    ) -> Result<Value, Fault> {
        let upper = name.to_ascii_uppercase();
        let inputs = given.iter().filter(|one| !one.is_output && !is_named(one, "EN"));
        let inputs: Vec<&Expr> = inputs.map(|one| &one.value).collect();
        if inputs.len() > MAX_INPUTS {
            let told = format!("{upper} has more than {MAX_INPUTS} inputs");
            let help = "give a part of them to another call";
            return Err(Fault::new(line, told).code(Code::NotModelled).help(help));
        }
        let values = self.operands(at, &inputs, line, &mut |emit, which| {
            let may_be_left =
                matches!(upper.as_str(), "SEL" | "MUX") && emit.calls_own(inputs[which]);
            if !may_be_left {
                return emit.open_value(at, inputs[which], line);
            }
            let why = "an input that calls something may be left out where another one is chosen";
            let leaves = emit.any_bit(why);
            let left = emit.jump(leaves, None);
            emit.open_value(at, inputs[which], line)?;
            emit.land(left);
            emit.landing();
            Ok(Value::Any)
        })?;
        for argument in given.iter().filter(|one| one.is_output && !is_named(one, "ENO")) {
            if let Expr::Variable(target) = &argument.value {
                self.assign(at, target, Value::Any, line)?;
            }
        }
        let Some(values) = in_order(given, values) else {
            let why =
                format!("not all inputs of {upper} are connected: the result may be any value");
            let at = self.builder.add(None, Vec::new(), Step::Nothing);
            self.program().approximate(at, why);
            return Ok(Value::Any);
        };
        // Operators know what to do with what does not fit its type. Of all else the result may be any there.
        if OPERATORS.contains(&upper.as_str()) {
            return self.of_values(at, name, given, &inputs, values, line);
        }
        let (values, open): (Vec<Value>, Vec<_>) = values.into_iter().map(parted).unzip();
        let open: Vec<Logic> = open.into_iter().flatten().collect();
        let open = (!open.is_empty()).then(|| self.keep_bit(Logic::Any(open)));
        let found = self.of_values(at, name, given, &inputs, values, line)?;
        Ok(self.any_where(found, open))
    }

    /// What a function of the standard makes of values.
    fn of_values(
        &mut self,
        at: &Context,
        name: &str,
        given: &[Argument],
        inputs: &[&Expr],
        mut values: Vec<Value>,
        line: u32,
    ) -> Result<Value, Fault> {
        let upper = name.to_ascii_uppercase();
        let first = given.iter().find(|one| !one.is_output && !is_named(one, "EN"));
        let seen = |value: Option<Value>, to: &Ty| match first {
            Some(input) => value.map(|value| shown(&input.value, value, to)),
            None => value,
        };
        self.charge_inputs(at, &upper, inputs);
        if let Some((reads, to)) = decimal(&upper) {
            self.cost(&[&upper, "CONVERT"], "conversion");
            let value = self.decimal(values.into_iter().next().unwrap_or(Value::Any), reads);
            return match to {
                Some(to) => self.charged_already(|emit| emit.conversion(Some(value), &to, line)),
                // Without a type, compilers differ in how many digits there are.
                None => Ok(Value::Any),
            };
        }
        if let Some((from, to)) = upper.split_once("_TO_") {
            let to = elementary(to).map(|of| (to, of)).ok_or_else(|| unknown(line, name))?;
            let from = elementary(from).map(|of| (from, of)).ok_or_else(|| unknown(line, name))?;
            match is_text(&from.1) || is_text(&to.1) {
                true => self.cost(&[&upper, "FUNCTION"], "special"),
                false => self.cost(&[&upper, "CONVERT"], "conversion"),
            }
            if is_time(&from.1) != is_time(&to.1) {
                return Ok(self.of_any_unit(&to.1));
            }
            let value = seen(values.into_iter().next(), &to.1);
            return self.charged_already(|emit| {
                emit.named_conversion(value, Some(named(from)), named(to), line)
            });
        }
        let to = upper.strip_prefix("TO_").and_then(|to| Some((to, elementary(to)?)));
        if let Some(to) = to {
            // What is not followed may be a text.
            let of_text = matches!(values.first(), Some(Value::Any)) || is_text(&to.1);
            match of_text {
                true => self.cost(&[&upper, "FUNCTION"], "special"),
                false => self.cost(&[&upper, "CONVERT"], "conversion"),
            }
            let from = values.first();
            let of_time = matches!(from, Some(Value::Number(Kind::Time, _)));
            if of_time != is_time(&to.1) {
                return Ok(self.of_any_unit(&to.1));
            }
            let value = seen(values.into_iter().next(), &to.1);
            return self
                .charged_already(|emit| emit.named_conversion(value, None, named(to), line));
        }
        let operator = match upper.as_str() {
            "ADD" | "ADD_TIME" => Some(Operator::Add),
            "SUB" | "SUB_TIME" => Some(Operator::Subtract),
            "MUL" | "MULTIME" => Some(Operator::Multiply),
            "DIV" | "DIVTIME" => Some(Operator::Divide),
            "MOD" => Some(Operator::Modulo),
            "EXPT" => Some(Operator::Power),
            "AND" => Some(Operator::And),
            "OR" => Some(Operator::Or),
            "XOR" => Some(Operator::Xor),
            "GT" => Some(Operator::Greater),
            "GE" => Some(Operator::GreaterOrEqual),
            "EQ" => Some(Operator::Equal),
            "NE" => Some(Operator::NotEqual),
            "LE" => Some(Operator::LessOrEqual),
            "LT" => Some(Operator::Less),
            _ => None,
        };
        if let Some(operator) = operator.filter(|_| values.len() > 1) {
            return self.folded(operator, values, line);
        }
        if operator.is_some() {
            return Ok(Value::Any);
        }
        match (upper.as_str(), values.len()) {
            ("MOVE", 1) => {
                self.cost(&["MOVE", "ST"], "move");
                Ok(values.remove(0))
            }
            ("NOT", 1) => match values.remove(0) {
                Value::Bit(logic) => {
                    self.cost(&["NOT"], "logic");
                    Ok(Value::Bit(logic.not()))
                }
                other => {
                    self.cost(&[row(Operator::Xor, None)], "arithmetic");
                    Ok(complement(other))
                }
            },
            ("SEL", 3) => {
                self.cost(&["SEL"], "move");
                let (two, one) = (values.remove(2), values.remove(1));
                let which = match values.remove(0) {
                    Value::Bit(logic) => logic,
                    _ => self.any_bit("a choice that is not followed"),
                };
                self.chosen(which, two, one, line)
            }
            ("MAX" | "MIN" | "LIMIT", 3..) if crosses(&values) => {
                self.crossed(&upper, &values, line)
            }
            ("MAX" | "MIN", 2..) => {
                let mut rest = values.into_iter();
                let mut best = rest.next().unwrap_or(Value::Any);
                for next in rest {
                    self.cost(&[&upper], "compare");
                    best = self.better(best, next, upper == "MAX", line)?;
                }
                Ok(best)
            }
            ("LIMIT", 3) => {
                self.cost(&["LIMIT"], "compare");
                let (high, value, low) = (values.remove(2), values.remove(1), values.remove(0));
                self.limited(low, value, high, line)
            }
            ("ABS", 1) => self.absolute(values.remove(0), line),
            ("SHL" | "SHR" | "ROL" | "ROR", 2) => {
                self.cost(&[&upper, "FUNCTION"], "special");
                let (places, of) = (values.remove(1), values.remove(0));
                let found = self.moved(&upper, of, places);
                if matches!(found, Value::Any) {
                    let at = self.builder.next() - 1;
                    self.program()
                        .approximate(at, format!("the result of {upper} may be any value"));
                }
                Ok(found)
            }
            ("MUX", 2..) => {
                self.cost(&["MUX", "FUNCTION"], "special");
                self.multiplexed(values, line)
            }
            _ if FOLLOWED_NOT.contains(&upper.as_str()) => {
                self.cost(&[&upper, "FUNCTION"], "special");
                let extent = inputs.first().map_or(Extent::One, |one| self.extent(at, one));
                self.any_result(&upper, values.first(), extent, line)
            }
            _ => {
                let help = declare("give all files of the project", name);
                Err(unknown(line, &format!("function {name}")).help(help))
            }
        }
    }

    /// What is done for something that is charged as a whole.
    pub(super) fn charged_already<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let from = self.builder.next();
        let found = work(self);
        self.charge_nothing(from);
        found
    }
}

impl Assembler {
    /// The result of a function that is not followed: any of the type that it gives for what it is given.
    pub(super) fn any_result(
        &mut self,
        name: &str,
        given: Option<&Value>,
        extent: Extent,
        line: u32,
    ) -> Result<Value, Fault> {
        let why = format!("the result of {name} may be any value");
        let kind = match (name, given) {
            (name, Some(Value::Number(kind @ (Kind::Real | Kind::Opaque(_)), _)))
                if name == "ABS" || OF_REALS.contains(&name) =>
            {
                Some(*kind)
            }
            ("LEN" | "FIND", _) if matches!(extent, Extent::Characters(..=0x7FFF)) => Some(INT),
            ("TRUNC" | "LEN" | "FIND" | "SIZEOF", _) => Some(DINT),
            ("TIME", _) => Some(Kind::Time),
            ("LTIME", _) => Some(Kind::Opaque(4)),
            (name, given) => {
                // It is given what it works with: controllers differ in whether that is a real or a long real.
                if OF_REALS.contains(&name) && matches!(given, Some(Value::Number(..))) {
                    self.cost(&["CONVERT"], "conversion");
                }
                None
            }
        };
        let Some(kind) = kind else {
            let at = self.builder.add(None, Vec::new(), Step::Nothing);
            self.program().approximate(at, why);
            return Ok(Value::Any);
        };
        let any = Value::Number(kind, self.any_number(kind, &why));
        match (name, extent) {
            ("LEN" | "FIND", Extent::Characters(most)) => {
                let most = Value::Constant(i64::try_from(most).unwrap_or(i64::MAX));
                self.charged_already(|emit| emit.limited(Value::Constant(0), any, most, line))
            }
            _ => Ok(any),
        }
    }

    pub(super) fn folded(
        &mut self,
        operator: Operator,
        values: Vec<Value>,
        line: u32,
    ) -> Result<Value, Fault> {
        let is_relation = operator.binding() == 4 || operator.binding() == 5;
        if is_relation && values.len() > 2 {
            // Each against the next.
            let pairs: Vec<_> =
                values.windows(2).map(|pair| (pair[0].clone(), pair[1].clone())).collect();
            let mut all = Vec::new();
            for (one, two) in pairs {
                if let Value::Bit(logic) = self.combined(operator, one, two, line)? {
                    all.push(logic);
                }
            }
            return Ok(Value::Bit(Logic::All(all)));
        }
        let mut rest = values.into_iter();
        let Some(mut sum) = rest.next() else { return Ok(Value::Any) };
        for next in rest {
            sum = self.combined(operator, sum, next, line)?;
        }
        Ok(sum)
    }

    /// A time as another type, or the other way round.
    pub(super) fn of_any_unit(&mut self, to: &Ty) -> Value {
        match to {
            Ty::Bit => Value::Bit(self.any_bit(ANY_UNIT)),
            Ty::Number(kind) => Value::Number(*kind, self.any_number(*kind, ANY_UNIT)),
            _ => Value::Any,
        }
    }
}

/// Whether a type that a conversion names is a string of bits, and the type.
fn named((name, ty): (&str, Ty)) -> (bool, Ty) {
    (["BYTE", "WORD", "DWORD", "LWORD"].contains(&name), ty)
}

/// Whether numbers with a sign and without stand together that are as long.
pub(super) fn crosses(values: &[Value]) -> bool {
    let kinds: Vec<Kind> = values
        .iter()
        .filter_map(|value| match value {
            Value::Number(kind, _) | Value::Open(kind, ..) => Some(*kind),
            _ => None,
        })
        .collect();
    let pairs = kinds.iter().flat_map(|one| kinds.iter().map(move |other| (*one, *other)));
    { pairs }.any(|(one, other)| mixed(one, other).is_some())
}

/// Whether an initial value takes time: it is more than a number, a list of such, or one that is not read.
fn is_worked_out(initial: &Expr) -> bool {
    match initial {
        Expr::Literal(_) => false,
        Expr::Negate(inner) | Expr::Not(inner) => is_worked_out(inner),
        Expr::Call(path, _) => ![CONSTRUCTED, LISTED, UNREAD].contains(&path.first.as_str()),
        Expr::Variable(_) | Expr::Binary(..) => true,
    }
}

/// Whether it is a duration. What number it is as another type hangs on the unit: milliseconds or seconds.
fn is_time(ty: &Ty) -> bool {
    matches!(ty, Ty::Number(Kind::Time))
}

fn is_text(ty: &Ty) -> bool {
    matches!(ty, Ty::Text(_))
}

/// Whether a variable of this name is handed over in and out.
pub(super) fn is_handed(variables: &[Variable], name: &str) -> bool {
    variables.iter().any(|one| one.section == Section::InOut && same(&one.name, name))
}

/// Arguments with the names of the parameters that they are for: those without a name stand for the inputs in their order.
pub(super) fn parameters<'a>(
    variables: &'a [Variable],
    given: &'a [Argument],
) -> impl Iterator<Item = (Option<&'a String>, &'a Argument)> {
    let is_input = |one: &&Variable| matches!(one.section, Section::Input | Section::InOut);
    let mut inputs = variables.iter().filter(is_input);
    given
        .iter()
        .map(move |one| (one.name.as_ref().or_else(|| inputs.next().map(|input| &input.name)), one))
}

fn is_named(one: &Argument, name: &str) -> bool {
    one.name.as_ref().is_some_and(|own| same(own, name))
}

/// The values of a standard function's inputs in their order, whichever order they are named in. Nothing, if one is left out.
fn in_order(given: &[Argument], values: Vec<Value>) -> Option<Vec<Value>> {
    let inputs = given.iter().filter(|one| !one.is_output && !is_named(one, "EN"));
    let names: Option<Vec<String>> =
        inputs.map(|one| one.name.as_ref().map(|name| name.to_ascii_uppercase())).collect();
    let Some(names) = names else { return Some(values) };
    let rank = |name: &str| match name.strip_prefix("IN") {
        Some("") => 1,
        Some(number) => number.parse::<u32>().map_or(u32::MAX, |number| number.saturating_add(2)),
        None if ["G", "K", "MN"].contains(&name) => 0,
        None => u32::MAX,
    };
    let mut ranked: Vec<(u32, Value)> = names.iter().map(|name| rank(name)).zip(values).collect();
    ranked.sort_by_key(|(rank, _)| *rank);
    // IN1, IN2 and so on, or IN0 and so on behind a choice.
    let numbered: Vec<u32> =
        ranked.iter().map(|(rank, _)| *rank).filter(|rank| (2..u32::MAX).contains(rank)).collect();
    let first = if ranked.iter().any(|(rank, _)| *rank == 0) { 2 } else { 3 };
    let is_whole = numbered.iter().zip(first..).all(|(own, expected)| *own == expected);
    is_whole.then(|| ranked.into_iter().map(|(_, value)| value).collect())
}

/// Of a function that reads (or writes) decimal digits of four bits: that, and the type of the number that it gives.
fn decimal(name: &str) -> Option<(bool, Option<Ty>)> {
    if let Some((digits, number)) = name.split_once("BCD_TO_") {
        let is_own = digits.is_empty() || elementary(digits.strip_suffix('_')?).is_some();
        return elementary(number).filter(|_| is_own).map(|to| (true, Some(to)));
    }
    let (number, digits) = name.split_once("_TO_BCD")?;
    elementary(number)?;
    match digits.strip_prefix('_') {
        Some(to) => Some((false, Some(elementary(to)?))),
        None => digits.is_empty().then_some((false, None)),
    }
}

/// Functions of the standard that compare their inputs, or give one of them.
const CHOOSES: &[&str] = &["MAX", "MIN", "LIMIT", "SEL", "MUX", "GT", "GE", "EQ", "NE", "LE", "LT"];

/// A function of the standard has no more inputs.
const MAX_INPUTS: usize = 200;

/// Functions of the standard that are operators, too, or give what they are given.
const OPERATORS: &[&str] = &[
    "ADD", "SUB", "MUL", "DIV", "MOD", "AND", "OR", "XOR", "NOT", "GT", "GE", "EQ", "NE", "LE",
    "LT", "MOVE",
];

/// Functions of the standard that bring to light how many bits are kept of what they are given.
const SHOWS_BITS: &[&str] =
    &["MUL", "MULTIME", "DIV", "DIVTIME", "MOD", "SHL", "SHR", "ROL", "ROR", "MUX", "ABS"];

/// Functions of the standard that are given reals or long reals, and give such.
const OF_REALS: &[&str] =
    &["SQRT", "LN", "LOG", "EXP", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN"];

/// Functions of the standard whose results may be any value.
const FOLLOWED_NOT: &[&str] = &[
    "SQRT",
    "LN",
    "LOG",
    "EXP",
    "SIN",
    "COS",
    "TAN",
    "ASIN",
    "ACOS",
    "ATAN",
    "TRUNC",
    "SHL",
    "SHR",
    "ROL",
    "ROR",
    "MUX",
    "LEN",
    "LEFT",
    "RIGHT",
    "MID",
    "CONCAT",
    "INSERT",
    "DELETE",
    "REPLACE",
    "FIND",
    "SIZEOF",
    "ABS",
    "CONCAT_DATE_TOD",
    "TIME",
    "LTIME",
];

//! Several values that are worked out one after the other: operands, arguments, indices. The standard leaves their order open:
//! where what one of them calls changes what another one is worked out from, they are taken from left to right or from right
//! to left.

use super::assembler::Assembler;
use super::emit::{Emit, Place};
use super::function::{is_handed, parameters};
use super::resolve::{Context, Found, unknown};
use super::types::Ty;
use super::value::Value;
use super::whole::Whole;
use super::within::{each_deep, shown};
use scanbound_base::code::Code;
use scanbound_front::builder::always;
use scanbound_iec::ast::{Argument, Expr, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::{Variable, same};
use scanbound_ir::{Logic, Step};

/// What some controllers do.
const RIGHT_FIRST: &str = "operands are worked out from right to left";
/// What some controllers do.
const TARGET_FIRST: &str = "an element is looked for before the value that it is assigned";

/// With more calls in one expression than this it would be put together too often.
const MAX_CALLS: usize = 6;

/// What works out some values, from right to left where that is asked for.
type Work<'w, E> = dyn FnMut(&mut E, bool) -> Result<Vec<Value>, Fault> + 'w;

impl Emit<'_> {
    /// What is worked out of some expressions in their order, or, where this makes a difference, in the other one, too.
    pub(super) fn in_either_order(
        &mut self,
        at: &Context,
        exprs: &[&Expr],
        line: u32,
        work: &mut dyn FnMut(&mut Self, bool) -> Result<Value, Fault>,
    ) -> Result<Value, Fault> {
        let mut found = self.both_ways(at, exprs, line, &mut |emit, turned| {
            work(emit, turned).map(|value| vec![value])
        })?;
        Ok(found.pop().unwrap_or(Value::Any))
    }

    /// The values of some expressions. `eval` works one of them out.
    pub(super) fn operands(
        &mut self,
        at: &Context,
        exprs: &[&Expr],
        line: u32,
        eval: &mut dyn FnMut(&mut Self, usize) -> Result<Value, Fault>,
    ) -> Result<Vec<Value>, Fault> {
        self.both_ways(at, exprs, line, &mut |emit, turned| {
            let mut values: Vec<Value> = exprs.iter().map(|_| Value::Any).collect();
            for number in 0..exprs.len() {
                let which = if turned { exprs.len() - 1 - number } else { number };
                // What is there already is not changed by what is called next.
                if emit.calls_own(exprs[which]) {
                    for value in &mut values {
                        let earlier = std::mem::replace(value, Value::Any);
                        *value = emit.frozen(earlier);
                    }
                }
                values[which] = eval(emit, which)?;
            }
            Ok(values)
        })
    }

    fn both_ways(
        &mut self,
        at: &Context,
        exprs: &[&Expr],
        line: u32,
        work: &mut Work<'_, Self>,
    ) -> Result<Vec<Value>, Fault> {
        // Only what is called changes what others read.
        if !exprs.iter().any(|one| self.calls_own(one)) {
            return work(self, false);
        }
        let pairs = (1..exprs.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
        if !{ pairs }.any(|(one, other)| self.order_matters(at, exprs[one], exprs[other])) {
            return work(self, false);
        }
        let mut calls = 0;
        for expr in exprs {
            each_deep(expr, &mut |one| {
                let is_one = matches!(one, Expr::Call(..)) && self.calls_own(one) && self.acts(one);
                calls += usize::from(is_one);
            });
        }
        if calls > MAX_CALLS {
            let told = "so many calls in one expression, of which one changes what others read: \
                their order is not followed";
            let help = "assign what they give to variables of their own before";
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

    /// Assigns an element, which is looked for behind its value, or before that.
    pub(super) fn assign_either_way(
        &mut self,
        at: &Context,
        target: &Path,
        value: &Expr,
        line: u32,
    ) -> Result<(), Fault> {
        let other = self.differs(TARGET_FIRST);
        let first = self.jump(other, None);
        let found = self.open_value(at, value, line)?;
        self.assign_of(at, target, Some(value), found, line)?;
        let end = self.jump(Logic::Const(true), None);
        self.land(first);
        self.landing();
        let place = self.find(at, target, line)?;
        let place = self.staying(place);
        let found = self.open_value(at, value, line)?;
        self.assign_found(place, Some(value), found, line)?;
        self.land(end);
        self.landing();
        Ok(())
    }

    /// Whether working out a value may change which element a path means, or the other way round.
    pub(super) fn moves_element(&self, at: &Context, target: &Path, value: &Expr) -> bool {
        let indices = target.rest.iter().filter_map(|part| match part {
            scanbound_iec::ast::Part::Index(indices) => Some(indices),
            _ => None,
        });
        { indices }.flatten().any(|index| self.order_matters(at, index, value))
    }

    /// Gives inputs their values. All are worked out first: one of them may call what the others are handed to.
    pub(super) fn hand_over(
        &mut self,
        at: &Context,
        place: &Place,
        variables: &[Variable],
        given: &[Argument],
        line: u32,
    ) -> Result<(), Fault> {
        let calls_any = given.iter().any(|one| self.calls_own(&one.value));
        let (mut values, mut wholes) = (Vec::new(), Vec::new());
        let (mut one_way, mut both) = (Vec::new(), Vec::new());
        for (name, argument) in parameters(variables, given) {
            let name =
                name.ok_or_else(|| Fault::new(line, format!("{} takes fewer values", place.name)))?;
            let is_enable = same(name, "EN") && Self::part(place, name).is_none();
            if argument.is_output || is_enable {
                continue;
            }
            let target = Self::part(place, name)
                .ok_or_else(|| unknown(line, &format!("{}.{name}", place.name)))?;
            self.has_own_type(at, &target, &argument.value, line)?;
            // What is handed over in and out is what the others have left of it.
            let group = if is_handed(variables, name) { &mut both } else { &mut one_way };
            group.push((target, &argument.value));
        }
        for (group, is_both) in [(one_way, false), (both, true)] {
            if !calls_any {
                for (target, value) in group {
                    if let Ty::Reference(kind, _) = target.ty {
                        let found = self.address(at, value, kind, line)?;
                        values.push((target, found, is_both, value));
                        continue;
                    }
                    if let Some(from) = self.whole_value(at, value, line)? {
                        wholes.push((from, Whole::Place(target), is_both));
                        continue;
                    }
                    let found = self.open_value(at, value, line)?;
                    values.push((target.clone(), shown(value, found, &target.ty), is_both, value));
                }
                continue;
            }
            for (_, value, ..) in &mut values {
                let earlier = std::mem::replace(value, Value::Any);
                *value = self.frozen(earlier);
            }
            let exprs: Vec<&Expr> = group.iter().map(|(_, value)| *value).collect();
            let found =
                self.operands(at, &exprs, line, &mut |emit, which| match group[which].0.ty {
                    Ty::Reference(kind, _) => emit.address(at, exprs[which], kind, line),
                    _ => emit.open_value(at, exprs[which], line),
                })?;
            for ((target, value), found) in group.into_iter().zip(found) {
                values.push((target.clone(), shown(value, found, &target.ty), is_both, value));
            }
        }
        for (from, target, is_both) in &wholes {
            match is_both {
                true => self.copy_handed(from, target),
                false => self.copy_whole(from, target, line)?,
            }
        }
        for (target, value, is_both, of) in values {
            let target = Found::Place(target);
            // In and out an address is handed over.
            let key = match is_both {
                true => Assembler::key(&["ST"], "move"),
                false => self.store_key(&target, Some(of), line)?,
            };
            let writes = self.writes(target, value, line)?;
            let effects = writes.into_iter().map(always).collect();
            self.builder.add(Some(key), effects, Step::Nothing);
        }
        Ok(())
    }
}

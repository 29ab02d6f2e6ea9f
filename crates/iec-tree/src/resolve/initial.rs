//! The values of variables before the first scan, from their declarations.

use super::resolver::Resolver;
use crate::blocks::{Pin, StandardBlock};
use crate::constants::Scope;
use crate::declarations::Initial;
use crate::types::{Elementary, Kind, Type, TypeId, holding, time_in_units};
use scanbound_iec::Variable as Declared;
use scanbound_iec::ast::{Argument, Expr, Listing, Literal};
use scanbound_iec::{Section, TypeRef, same};

/// Arrays with more elements, or more elementary values in all, are not evaluated.
const MAX_ELEMENTS: usize = 20_000;

/// The maximum depth of constants or type names that refer to each other.
const DEPTH: u32 = 100;

/// A declaration: its type, its initial value if one is written, and the variables that hide global names in that
/// value.
#[derive(Clone, Copy)]
struct Written<'e> {
    of: &'e TypeRef,
    initial: Option<&'e Expr>,
    scope: &'e Scope<'e>,
}

impl Resolver<'_> {
    /// The value of a variable and its parts before the first scan. [`Initial::Nothing`] for text and for instances of
    /// the project's blocks.
    pub(super) fn begins(&self, one: &Declared, ty: TypeId, scope: &Scope<'_>) -> Initial {
        let written = Written { of: &one.of, initial: one.initial.as_ref(), scope };
        self.begins_as(ty, written)
    }

    /// The value before the first scan of a variable of this type without an initial value.
    pub(super) fn begins_plainly(&self, ty: TypeId) -> Initial {
        let of = TypeRef::Named(String::new());
        self.begins_as(ty, Written { of: &of, initial: None, scope: &[] })
    }

    fn begins_as(&self, ty: TypeId, written: Written<'_>) -> Initial {
        let (written, is_open) = self.underlying(written);
        match self.tree.types.get(ty) {
            // Controllers differ on whether a subrange starts with 0 or with its lower limit.
            Type::Elementary(_) if written.initial.is_none() && is_open => Initial::Unknown,
            Type::Elementary(of) => self.single(*of, written).unwrap_or(Initial::Unknown),
            Type::Reference(..) | Type::Interface(_) => match written.initial {
                None => Initial::Zero,
                Some(_) => Initial::Unknown,
            },
            Type::Array(dimensions, of) => {
                self.elements(dimensions, *of, written).unwrap_or(Initial::Unknown)
            }
            Type::Struct(id) => {
                let (TypeRef::Struct(parts), Some(given)) =
                    (written.of, given(written.initial, Listing::Parts))
                else {
                    return Initial::Unknown;
                };
                let types = self.tree.types.parts(*id).iter();
                let all = parts.iter().zip(types).map(|(one, (_, ty))| {
                    let (initial, scope) = match given.iter().find(|own| is_for(own, &one.name)) {
                        Some(own) => (Some(&own.value), written.scope),
                        None => (one.initial.as_ref(), &[] as &Scope<'_>),
                    };
                    self.begins_as(*ty, Written { of: &one.of, initial, scope })
                });
                Initial::Parts(all.collect())
            }
            Type::Standard(block) => self.pins(*block, written),
            _ => Initial::Nothing,
        }
    }

    fn pins(&self, block: StandardBlock, written: Written<'_>) -> Initial {
        let Some(given) = given(written.initial, Listing::Parts) else { return Initial::Unknown };
        let all = block.pins().map(|pin| {
            let own = given.iter().find(|one| is_for(one, pin.name()));
            // Controllers differ on whether `F_TRIG` detects an edge in its first call.
            match (block, pin, own) {
                (StandardBlock::FTrig, Pin::Was, _) => Initial::Unknown,
                (.., None) => Initial::Zero,
                (.., Some(own)) => {
                    let written = Written { initial: Some(&own.value), ..written };
                    self.single(pin.of(), written).unwrap_or(Initial::Unknown)
                }
            }
        });
        Initial::Parts(all.collect())
    }

    /// The values of an array's elements; `None` if there are too many or the list has an unsupported form.
    fn elements(
        &self,
        dimensions: &[(i64, i64)],
        of: TypeId,
        written: Written<'_>,
    ) -> Option<Initial> {
        let TypeRef::Array(_, inner) = written.of else { return None };
        let values = given(written.initial, Listing::Elements)?;
        let plain = self.begins_as(of, Written { of: inner, initial: None, scope: &[] });
        if values.is_empty() && plain.is_zero() {
            return Some(Initial::Zero);
        }
        let mut counts = dimensions.iter().map(|(low, high)| usize::try_from(high - low + 1).ok());
        let count = counts.try_fold(1_usize, |all, count| all.checked_mul(count?))?;
        // In several dimensions, nested lists cannot be distinguished from the values of elements.
        let is_nested = |one: &Argument| given(Some(&one.value), Listing::Elements).is_some();
        // A repetition `N(7)` looks like a call; its count is not evaluated here.
        let is_call = |one: &Argument| matches!(one.value, Expr::Call(..));
        if count > MAX_ELEMENTS
            || values.len() > count
            || values.iter().any(is_call)
            || (dimensions.len() > 1 && values.iter().any(is_nested))
        {
            return None;
        }
        let mut all = Vec::new();
        let mut size = 0;
        for at in 0..count {
            let one = match values.get(at) {
                Some(one) => {
                    let initial = Some(&one.value);
                    self.begins_as(of, Written { of: inner, initial, scope: written.scope })
                }
                None => plain.clone(),
            };
            size += one.size();
            if size > MAX_ELEMENTS {
                return None;
            }
            all.push(one);
        }
        Some(Initial::Elements(all))
    }

    /// Follows type names and subranges to the underlying type and takes the first initial value on the way. The flag
    /// is true if a subrange occurs whose lower limit is not known to be 0.
    fn underlying<'e>(&'e self, written: Written<'e>) -> (Written<'e>, bool) {
        let mut found = written;
        let mut is_open = false;
        for _ in 0..DEPTH {
            match found.of {
                TypeRef::Named(name) if Elementary::named(name).is_none() => {
                    let Some(at) = self.index.declared_type(name) else { break };
                    let own = &self.project.types[at];
                    if let (None, Some(initial)) = (found.initial, &own.initial) {
                        (found.initial, found.scope) = (Some(initial), &[]);
                    }
                    found.of = &own.of;
                }
                TypeRef::Subrange(of, range) => {
                    is_open |= self.constants.number(&range.0, found.scope) != Some(0);
                    found.of = of;
                }
                _ => break,
            }
        }
        (found, is_open)
    }

    /// The value of an elementary variable; `None` if it is not known.
    fn single(&self, of: Elementary, written: Written<'_>) -> Option<Initial> {
        let Written { of: declared, initial, scope } = written;
        let number = match (of.kind(), initial) {
            (None | Some(Kind::Real | Kind::Time), None) => 0,
            (None, Some(initial)) => match self.constant_literal(initial, scope, 0) {
                Some((Literal::Bool(on), negated)) => i64::from(*on != negated),
                _ => i64::from(self.constants.number(initial, scope)? != 0),
            },
            (Some(kind @ Kind::Whole { .. }), _) => {
                let value = match initial {
                    Some(initial) => self.constants.number(initial, scope)?,
                    None if matches!(declared, TypeRef::Enumeration(..)) => {
                        self.first_named(declared, &[])?
                    }
                    None => 0,
                };
                (holding(kind, value) == kind).then_some(value)?
            }
            (Some(Kind::Real), Some(initial)) => {
                let (text, negated) = match self.constant_literal(initial, scope, 0)? {
                    (Literal::Real(text, _), negated) => (text.clone(), negated),
                    (Literal::Int(value, _), negated) => (value.to_string(), negated),
                    _ => return None,
                };
                let value: f32 = text.parse().ok()?;
                i64::from(if negated { -value } else { value }.to_bits())
            }
            (Some(Kind::Time), Some(initial)) => match self.constant_literal(initial, scope, 0)? {
                (Literal::Time(time), false) => i64::from(time_in_units(*time)?),
                _ => return None,
            },
            _ => return None,
        };
        Some(if number == 0 { Initial::Zero } else { Initial::Number(number) })
    }

    /// The literal that an expression consists of, directly or through constants, and whether `-` or `NOT` negates it.
    fn constant_literal<'e>(
        &'e self,
        one: &'e Expr,
        scope: &Scope<'e>,
        depth: u32,
    ) -> Option<(&'e Literal, bool)> {
        let deeper = |one: &'e Expr, scope: &Scope<'e>| {
            (depth < DEPTH).then(|| self.constant_literal(one, scope, depth + 1))?
        };
        match one {
            Expr::Literal(literal) => Some((literal, false)),
            Expr::Negate(inner) | Expr::Not(inner) => {
                deeper(inner, scope).map(|(literal, negated)| (literal, !negated))
            }
            Expr::Variable(path) => {
                let of_file = self.index.of_file(path).filter(|_| path.rest.len() == 1);
                let name = path.as_name().or(of_file)?;
                let is_it =
                    |one: &&Declared| one.section != Section::External && same(&one.name, name);
                let own = scope.iter().enumerate().find_map(|(at, all)| {
                    let own: &'e [Declared] = all;
                    Some((at, own.iter().find(is_it)?))
                });
                if let Some((at, own)) = own.filter(|_| of_file.is_none()) {
                    let initial = own.initial.as_ref().filter(|_| own.constant)?;
                    return deeper(initial, &scope[at..]);
                }
                let mut all = self.constants.globals(name);
                let (list, variables, own) = all.next().filter(|_| all.next().is_none())?;
                let initial = own.initial.as_ref().filter(|_| own.constant)?;
                if list.is_empty() { deeper(initial, &[]) } else { deeper(initial, &[variables]) }
            }
            _ => None,
        }
    }
}

/// The entries of an initial value of this kind; empty if there is no initial value. `None` if the value has another
/// form.
fn given(initial: Option<&Expr>, kind: Listing) -> Option<&[Argument]> {
    match initial {
        None => Some(&[]),
        Some(Expr::List(own, given)) if *own == kind => Some(given),
        Some(_) => None,
    }
}

fn is_for(one: &Argument, name: &str) -> bool {
    one.name.as_ref().is_some_and(|own| same(own, name))
}

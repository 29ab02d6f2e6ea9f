//! Calls of instances that stand in arrays, by numbers that are worked out.

use super::emit::Emit;
use super::resolve::{Context, Found};
use super::types::{DINT, Ty};
use super::value::constant;
use scanbound_base::code::Code;
use scanbound_iec::ast::{Argument, Expr, Literal, Part, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::same;
use scanbound_ir::errors::is_outside;
use scanbound_ir::{Compare, Logic, Number, NumberFormat, Relation};

/// An array of so many instances is called by a number that is worked out.
const MAX_INSTANCES: i64 = 64;

impl Emit<'_> {
    /// Calls the instance of an array that has this number, where that is worked out: the one of all whose number it is.
    /// Whether it is such a call.
    pub(super) fn one_of_called(
        &mut self,
        at: &Context,
        target: &Path,
        given: &[Argument],
        line: u32,
    ) -> Result<bool, Fault> {
        // The first number that is worked out.
        let mut parts = target.rest.iter().enumerate();
        let found = parts.find_map(|(end, part)| match part {
            Part::Index(indices) => match &indices[..] {
                [index] if self.constant(at, index).is_none() => Some((end, index)),
                _ => None,
            },
            _ => None,
        });
        let Some((end, index)) = found else { return Ok(false) };
        let owner = Path { first: target.first.clone(), rest: target.rest[..end].to_vec() };
        let behind = &target.rest[end + 1..];
        let Ok(Found::Place(all)) = self.find(at, &owner, line) else { return Ok(false) };
        let Ty::Array { dimensions, of } = &all.ty else { return Ok(false) };
        if !holds_instance(of, behind) {
            return Ok(false);
        }
        let (low, high) = match dimensions[..] {
            [(low, high)] if high - low < MAX_INSTANCES => (low, high),
            _ => {
                let told = format!("{}: an instance of unknown number is called", all.name);
                let help = "call one of an array of up to 64 instances, or write CASE";
                return Err(Fault::new(line, told).code(Code::NotModelled).help(help));
            }
        };
        let number = self.number(at, index, DINT, line)?;
        let words = self.copies(number, DINT);
        self.not_followed_where(is_outside(&Number::Words(words.clone()), low, high));
        for number in low..=high {
            let own = Compare {
                relation: Relation::Equal,
                format: NumberFormat::Signed,
                left: Number::Words(words.clone()),
                right: constant(number, 2),
            };
            let skip = self.jump(Logic::Compare(Box::new(own)).not(), None);
            let mut one = owner.clone();
            let number = Literal::Int(number.into(), None);
            one.rest.push(Part::Index(vec![Expr::Literal(number)]));
            one.rest.extend_from_slice(behind);
            let done = self.called(at, &one, given, line);
            self.land(skip);
            self.landing();
            done?;
        }
        Ok(true)
    }
}

/// Whether some parts lead from a type to an instance.
fn holds_instance(from: &Ty, parts: &[Part]) -> bool {
    let Some((first, rest)) = parts.split_first() else {
        return matches!(from, Ty::Standard(..) | Ty::Block(..));
    };
    match (from, first) {
        (Ty::Parts(all) | Ty::Block(_, all), Part::Name(name)) => {
            let own = all.iter().find(|(own, _)| same(own, name));
            own.is_some_and(|(_, ty)| holds_instance(ty, rest))
        }
        (Ty::Array { of, .. }, Part::Index(_)) => holds_instance(of, rest),
        _ => false,
    }
}

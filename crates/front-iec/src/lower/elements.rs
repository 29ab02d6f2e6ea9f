//! Calls of instances that stand in arrays, by numbers that are worked out.

use super::Lower;
use super::references::is_number;
use super::spots::Context;
use crate::assembler::value::Value;
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::tree::{Expr, ExprKind, Place, Step as PathStep};
use scanbound_iec_tree::types::{DINT, Type as Typed};
use scanbound_ir::errors::is_outside;
use scanbound_ir::{Number, WordSource};
use std::ops::RangeInclusive;

/// An array of so many instances is called by a number that is worked out.
const MOST_INSTANCES: i64 = 64;

impl Lower<'_> {
    /// The first array element of a path whose number is worked out: the path before it, its number, its bounds.
    fn worked_out_element(&self, at: &Context, place: &Place) -> Option<(usize, Expr, i64, i64)> {
        let mut ty = self.root_type(at, place)?;
        for (number, step) in place.steps.iter().enumerate() {
            if let (PathStep::Element(indices), Typed::Array(dimensions, _)) =
                (step, self.tree.types.get(ty))
                && indices.iter().any(|one| one.whole().is_none())
            {
                let ([index], [(low, high)]) = (&indices[..], &dimensions[..]) else { return None };
                return Some((number, index.clone(), *low, *high));
            }
            ty = self.step_type(ty, step)?;
        }
        None
    }

    /// Whether a path means a bit of an array's element whose number is worked out.
    pub(super) fn is_bit_of_element(&self, at: &Context, place: &Place) -> bool {
        matches!(place.steps.last(), Some(PathStep::Bit(_)))
            && self.worked_out_element(at, place).is_some()
    }

    /// The type where a path begins; nothing for a program's instance or the own one, which hold no array at once.
    pub(super) fn root_type(
        &self,
        at: &Context,
        place: &Place,
    ) -> Option<scanbound_iec_tree::types::TypeId> {
        let unit = self.root_unit(at, place.root);
        match place.root {
            scanbound_iec_tree::tree::Root::Variable(id) => Some(self.tree.variable(id).ty),
            scanbound_iec_tree::tree::Root::Address(id) => Some(self.tree.address(id).ty),
            scanbound_iec_tree::tree::Root::Temporary(_) => None,
            scanbound_iec_tree::tree::Root::Target(number) => {
                Some(self.memory.targets.spots[number as usize].ty)
            }
            _ => self.tree.types.find(&Typed::Block(unit?)),
        }
    }

    pub(super) fn step_type(
        &self,
        ty: scanbound_iec_tree::types::TypeId,
        step: &PathStep,
    ) -> Option<scanbound_iec_tree::types::TypeId> {
        match (self.tree.types.get(ty), step) {
            (Typed::Struct(id), PathStep::Part(number)) => {
                Some(self.tree.types.parts(*id)[*number].1)
            }
            (_, PathStep::Member(id)) => Some(self.tree.variable(*id).ty),
            (_, PathStep::Result(method, _)) => {
                Some(self.tree.variable(self.tree.routine(*method).result?).ty)
            }
            (Typed::Array(_, of), PathStep::Element(_)) => Some(*of),
            _ => None,
        }
    }

    fn with_index(place: &Place, step: usize, number: i64, index: &Expr) -> Place {
        let mut place = place.clone();
        let kind = ExprKind::Named(number);
        place.steps[step] = PathStep::Element(vec![Expr { kind, ..index.clone() }]);
        place
    }

    /// The number of the element that a path means where it is worked out, as words, with what [`Lower::worked_out_element`]
    /// says of it.
    fn number_of_element(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
    ) -> Result<Option<(usize, Expr, RangeInclusive<i64>, Vec<WordSource>)>, Fault> {
        let Some((step, index, low, high)) = self.worked_out_element(at, place) else {
            return Ok(None);
        };
        if high - low >= MOST_INSTANCES {
            return Err(unknown_number(line));
        }
        let value = self.value(at, &index)?;
        let number = self.as_number(value, DINT);
        let words = self.copied(number, 2);
        self.not_followed_where(is_outside(&Number::Words(words.clone()), low, high));
        Ok(Some((step, index, low..=high, words)))
    }

    /// Calls the instance of an array that has the number which is worked out. Whether it is such a call.
    pub(super) fn one_of(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
        act: &mut dyn FnMut(&mut Self, Place) -> Result<(), Fault>,
    ) -> Result<bool, Fault> {
        let found = self.number_of_element(at, place, line)?;
        let Some((step, index, numbers, words)) = found else { return Ok(false) };
        for number in numbers {
            let skip = self.jump(is_number(&words, number, 2).not(), None);
            let done = act(self, Self::with_index(place, step, number, &index));
            self.land(skip);
            self.landing();
            done?;
        }
        Ok(true)
    }

    /// Does something to the instance of an array that has a number which is worked out. What it gives, if it is such a call.
    pub(super) fn each_instance(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
        act: &mut dyn FnMut(&mut Self, Place) -> Result<Value, Fault>,
    ) -> Result<Option<Value>, Fault> {
        let found = self.number_of_element(at, place, line)?;
        let Some((step, index, numbers, words)) = found else { return Ok(None) };
        let (mut known, mut ends) = (None, Vec::new());
        let last = *numbers.end();
        for number in numbers {
            let skip = (number < last).then(|| self.jump(is_number(&words, number, 2).not(), None));
            let value = act(self, Self::with_index(place, step, number, &index))?;
            known = Some(self.gathered(known, value));
            self.past(skip, &mut ends);
        }
        self.all_land(ends);
        Ok(Some(known.unwrap_or(Value::Any)))
    }
}

pub(super) fn unknown_number(line: u32) -> Fault {
    let help = "use an array of up to 64 elements with one index, or write CASE";
    Fault::new(line, "an element of unknown number is called, or a bit of it is named")
        .code(FaultCode::NotModelled)
        .help(help)
}

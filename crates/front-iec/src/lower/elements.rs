//! Operations on instances in arrays with run-time indices: lowered once for each possible index.

use super::Lower;
use super::references::is_number;
use super::spots::Context;
use crate::assembler::value::Value;
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::tree::{Expr, ExprKind, Place, Step as PathStep};
use scanbound_iec_tree::types::{DINT, Type as Typed};
use scanbound_ir::errors::is_outside;
use scanbound_ir::{Logic, Number, WordSource};

/// The most elements of an array that may be called with a run-time index.
const MOST_INSTANCES: i64 = 64;

/// A run-time index in a path, with its range in the array.
struct WorkedOut {
    /// The number of the step in the path.
    step: usize,
    /// The position of this index among the indices of the step.
    number: usize,
    index: Expr,
    low: i64,
    high: i64,
    /// The number of elements that the run-time indices of this step can select.
    elements: i64,
}

impl WorkedOut {
    /// The path with this index replaced by a constant.
    fn known(&self, place: &Place, number: i64) -> Place {
        let mut place = place.clone();
        if let PathStep::Element(indices) = &mut place.steps[self.step] {
            indices[self.number].kind = ExprKind::Named(number);
        }
        place
    }
}

impl Lower<'_> {
    /// The first run-time index of a path. None if all indices are constant, or if the type of the path is not known.
    fn worked_out_index(&self, at: &Context, place: &Place) -> Option<WorkedOut> {
        let mut ty = self.root_type(at, place)?;
        for (step, one) in place.steps.iter().enumerate() {
            if let (PathStep::Element(indices), Typed::Array(dimensions, _)) =
                (one, self.tree.types.get(ty))
            {
                let is_open = |(index, _): &(&Expr, _)| index.whole().is_none();
                let open = indices.iter().zip(dimensions).filter(is_open);
                let elements = open.fold(1i64, |all, (_, (low, high))| {
                    all.saturating_mul(high.saturating_sub(*low).saturating_add(1))
                });
                if let Some(number) = indices.iter().position(|one| one.whole().is_none()) {
                    let (low, high) = *dimensions.get(number)?;
                    let index = indices[number].clone();
                    return Some(WorkedOut { step, number, index, low, high, elements });
                }
            }
            ty = self.step_type(ty, one)?;
        }
        None
    }

    /// Whether a path ends in a bit of an array element with a run-time index.
    pub(super) fn is_bit_of_element(&self, at: &Context, place: &Place) -> bool {
        matches!(place.steps.last(), Some(PathStep::Bit(_)))
            && self.worked_out_index(at, place).is_some()
    }

    /// The type of the place at which a path begins. None for a temporary.
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

    /// Runs `act` for each value of the first run-time index of a path, behind a test. Returns false if the path has no
    /// such index.
    pub(super) fn one_of(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
        act: &mut dyn FnMut(&mut Self, Place) -> Result<(), Fault>,
    ) -> Result<bool, Fault> {
        let Some(open) = self.worked_out_index(at, place) else { return Ok(false) };
        let words = self.number_of(at, &open, line)?;
        for number in open.low..=open.high {
            let skip = self.unless_element(&words, number, &open);
            let done = act(self, open.known(place, number));
            self.land(skip);
            self.landing();
            done?;
        }
        Ok(true)
    }

    /// Runs `act` for each value of the first run-time index of a path, behind a test. Returns the merged value, or
    /// None if the path has no such index.
    pub(super) fn each_instance(
        &mut self,
        at: &Context,
        place: &Place,
        line: u32,
        act: &mut dyn FnMut(&mut Self, Place) -> Result<Value, Fault>,
    ) -> Result<Option<Value>, Fault> {
        let Some(open) = self.worked_out_index(at, place) else { return Ok(None) };
        let words = self.number_of(at, &open, line)?;
        let (mut known, mut ends) = (None, Vec::new());
        for number in open.low..=open.high {
            let skip = Some(self.unless_element(&words, number, &open));
            let value = act(self, open.known(place, number))?;
            known = Some(self.gathered(known, value));
            self.past(skip, &mut ends);
        }
        Ok(Some(self.otherwise_any(known, ends)))
    }

    /// Adds a jump past the code for one value of a run-time index. With an index outside the array, the last element's
    /// code may be executed: the controller then calls it for memory behind the array.
    fn unless_element(&mut self, words: &[WordSource], number: i64, open: &WorkedOut) -> usize {
        let is_other = is_number(words, number, 2).not();
        if number < open.high {
            return self.jump(is_other, None);
        }
        let within = is_outside(&Number::Words(words.to_vec()), open.low, open.high).not();
        let passes = Logic::Any(vec![within, self.extra_time().not()]);
        self.jump(Logic::All(vec![is_other, passes]), None)
    }

    /// Evaluates a run-time index into two words. A fault if it can select too many elements.
    fn number_of(
        &mut self,
        at: &Context,
        open: &WorkedOut,
        line: u32,
    ) -> Result<Vec<WordSource>, Fault> {
        if open.elements > MOST_INSTANCES {
            return Err(unknown_number(line));
        }
        let value = self.value(at, &open.index)?;
        let number = self.as_number(value, DINT);
        let words = self.copied(number, 2);
        self.not_followed_where(is_outside(&Number::Words(words.clone()), open.low, open.high));
        Ok(words)
    }
}

pub(super) fn unknown_number(line: u32) -> Fault {
    let help = "use an array of up to 64 elements, or write CASE";
    Fault::new(line, "an array element with a run-time index is called, or a bit of it is used")
        .code(FaultCode::NotModelled)
        .help(help)
}

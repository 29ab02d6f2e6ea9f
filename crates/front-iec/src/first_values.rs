//! What variables hold before the first scan, as they are declared: 0, or another constant; a bit that is on then is turned on as
//! the first scan begins. That is told of what the program writes: what it only reads is a parameter that somebody else may set.

use super::assembler::Assembler;
use super::emit::{Emit, Place};
use super::types::{Kind, Ty, is_elementary};
use super::value::{real, within};
use scanbound_iec::ast::{Expr, Literal};
use scanbound_iec::{Project, TypeRef, Variable, same};
use scanbound_iec_tree::constants::Scope;
use scanbound_ir::{
    BitSource, BitTarget, Cell, Effect, Logic, Number, PowerUp, Region, Step, When, WordSource,
    Write, flow,
};

/// The name of the bit that is on in the first scan alone.
pub(super) const FIRST_SCAN: &str = "first scan";

/// A variable and its first value, which is not 0: a bit that is on, or words.
pub(super) struct FirstValue {
    region: Region,
    cell: Cell,
    words: Option<Number>,
}

/// The first value of a variable: its words, or nothing for a bit that is on.
pub(super) fn first_value(region: Region, cell: Cell, words: Option<Number>) -> FirstValue {
    FirstValue { region, cell, words }
}

/// What is known of the value with which a variable begins.
pub(super) enum Begins {
    Zero,
    Value(FirstValue),
}

impl Emit<'_> {
    /// With what a variable begins, if that is known; `scope`: what hides global names where it is declared.
    pub(super) fn begins_with(
        &self,
        variable: &Variable,
        place: &Place,
        scope: &Scope<'_>,
    ) -> Option<Begins> {
        let initial = variable.initial.as_ref();
        let constant = |one: &Expr| self.types.constants.number(one, scope);
        if let (Ty::Standard(..), None) = (&place.ty, initial) {
            return Some(Begins::Zero);
        }
        if !is_elementary(variable) && !self.is_enumeration(&variable.of) {
            return None;
        }
        let cell = place.tag.cell()?;
        let words = match &place.ty {
            Ty::Bit => {
                let on = match initial {
                    None => false,
                    Some(Expr::Literal(Literal::Bool(on))) => *on,
                    Some(other) => constant(other)? != 0,
                };
                if !on {
                    return Some(Begins::Zero);
                }
                None
            }
            Ty::Number(kind) => {
                let number = match (kind, initial) {
                    (Kind::Whole { bits: ..=32, .. }, None) => {
                        let first = self.types.first_named(&variable.of);
                        within(*kind, if is_elementary(variable) { 0 } else { first? })
                    }
                    (Kind::Real | Kind::Time | Kind::Whole { .. }, None) => within(*kind, 0),
                    (Kind::Whole { bits: ..=32, .. }, Some(initial)) => {
                        within(*kind, constant(initial)?)
                    }
                    (Kind::Real, Some(Expr::Literal(Literal::Real(text, _)))) => real(text)?,
                    (Kind::Real, Some(Expr::Literal(Literal::Int(value, _)))) => {
                        real(&value.to_string())?
                    }
                    (Kind::Time, Some(Expr::Literal(Literal::Time(time)))) => {
                        let ms = i32::try_from(time / 1_000_000).ok()?;
                        (time % 1_000_000 == 0).then(|| within(*kind, ms.into()))?
                    }
                    _ => return None,
                };
                if number == within(*kind, 0) {
                    return Some(Begins::Zero);
                }
                Some(number)
            }
            _ => return None,
        };
        let region = *place.tag.regions().first()?;
        Some(Begins::Value(FirstValue { region, cell, words }))
    }

    fn is_enumeration(&self, of: &TypeRef) -> bool {
        match of {
            TypeRef::Enumeration(..) => true,
            TypeRef::Named(name) => {
                let own = self.project.types.iter().find(|one| same(&one.name, name));
                own.is_some_and(|own| matches!(own.of, TypeRef::Enumeration(..)))
            }
            _ => false,
        }
    }

    /// Where bits are turned on as the first scan begins; which, is given when it is known what the program writes.
    pub(super) fn first_scan(&mut self) -> Option<usize> {
        let place = self.variable(FIRST_SCAN, Ty::Bit, 1).ok()?;
        self.at(1, "first values");
        let fires = Logic::cell(place.tag.cell()?);
        Some(self.builder.add(None, Vec::new(), Step::Act { fires }))
    }
}

impl Assembler {
    /// Takes note of the first values of what the program writes, unless power may fail without a loss of them, or memory is
    /// shared.
    pub(super) fn note_first_values(
        &mut self,
        at: Option<usize>,
        values: Vec<FirstValue>,
        shared: &[Region],
        known: &mut PowerUp,
    ) {
        let Some(at) = at else { return };
        let program = &self.builder.program;
        let Step::Act { fires: Logic::Bit(bit) } = &program.instructions[at].step else { return };
        let BitSource::Cell(first) = *bit else { return };
        let written: Vec<Region> =
            (0..program.instructions.len()).flat_map(|at| flow::written(program, at)).collect();
        let kept = |region: Region| {
            let mut others = known.latched.iter().chain(shared);
            !others.any(|other| flow::overlap(region, *other))
        };
        let is_written = |region: Region| written.iter().any(|own| flow::overlap(region, *own));
        let values: Vec<FirstValue> =
            values.into_iter().filter(|one| kept(one.region) && is_written(one.region)).collect();
        known.cleared.extend(values.iter().map(|one| one.region));
        for FirstValue { cell, words, .. } in values {
            let Some(Number::Words(words)) = words else {
                let write = Write::Bit(BitTarget::Cell(cell), Logic::Const(true));
                let effect = Effect { when: When::Fired, write };
                self.program().instructions[at].effects.push(effect);
                known.first_scan = vec![first];
                known.after_clear = Some(BitTarget::Cell(first));
                continue;
            };
            for (cell, word) in (0..).map(|at| cell.plus(at)).zip(words) {
                if let WordSource::Const(word) = word {
                    known.values.insert(cell, word);
                }
            }
        }
    }
}

/// Whether any variable is declared with a first value: nothing is to be written without one.
pub(super) fn any(project: &Project) -> bool {
    let lists = project.globals.iter().map(|(_, list)| list);
    let all = project.pous.iter().map(|pou| &pou.variables).chain(lists);
    all.flatten().any(|one| one.initial.is_some() && !one.constant)
}

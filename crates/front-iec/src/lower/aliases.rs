//! Variables that a call hands over in and out: what is called changes the caller's own variable (IEC 61131-3, VAR_IN_OUT).
//! They are followed as copies that are given back, so a call in which one variable has two names is refused.

use super::cells::{Effects, add};
use super::spots::{Callee, Context, Instance};
use super::{Entry, Lower};
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, Section};
use scanbound_iec_tree::declarations::VarId;
use scanbound_iec_tree::tree::{Call, Expr, ExprKind, Parameter, Passed, Place, Step};
use std::collections::BTreeSet;

impl Lower<'_> {
    /// Refuses a call that hands over a variable which what is called also reaches by another name.
    pub(super) fn has_one_name(
        &mut self,
        at: &Context,
        called: (usize, Entry),
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        let tree = self.tree;
        for (parameter, _) in &call.passed {
            if let Parameter::Variable(id) = parameter
                && tree.variable(*id).section == Section::InOut
                && self.has_charts(tree.variable(*id).ty)
            {
                let message = format!(
                    "{} is handed over in and out, and has a chart, whose state is not followed there",
                    tree.variable(*id).name
                );
                let help = "call the instance where it is declared";
                return Err(Fault::new(line, message).code(FaultCode::NotModelled).help(help));
            }
        }
        let handed: Vec<&Place> = handed_over(call).collect();
        let taken = call.passed.iter().filter_map(|(_, passed)| match passed {
            Passed::Output(place, _) => Some(place),
            _ => None,
        });
        let taken: Vec<&Place> = taken.collect();
        if handed.is_empty() && taken.iter().all(|place| place.indices().next().is_none()) {
            return Ok(());
        }
        let within = self.effects_of(called);
        for place in handed.iter().chain(&taken) {
            // Where an element is looked for may be settled before the call or behind it.
            let indices: Vec<&Expr> =
                place.indices().filter(|index| index.whole().is_none()).collect();
            let mut moved = false;
            for index in indices {
                let looked = self.found(|own, found| own.of_expr(at, index, found));
                let mut changed = Effects::default();
                for other in handed.iter().chain(&taken) {
                    self.written(at, other, &mut changed);
                }
                moved |=
                    self.calls_own(index) || within.changes(&looked) || changed.changes(&looked);
            }
            if moved {
                let message = format!("what {} means may change while the call runs", place.text);
                let help = "assign the index or the address to a variable that nothing else writes";
                return Err(Fault::new(line, message).code(FaultCode::NotModelled).help(help));
            }
        }
        let mut before = Effects::default();
        for place in handed {
            let own = self.found(|own, found| own.written(at, place, found));
            if own.meets(&before) || own.meets(&within) {
                let message = format!(
                    "{} is handed over in and out, and what is called may reach it by another name",
                    place.text
                );
                let help = "hand over a variable of its own, and assign it before and after";
                return Err(Fault::new(line, message).code(FaultCode::NotModelled).help(help));
            }
            before.join(&own);
        }
        Ok(())
    }

    /// Refuses a call that depends on the order in which it passes inputs and takes outputs: that in which they are written, or
    /// that in which they are declared.
    pub(super) fn passes_in_any_order(
        &mut self,
        at: &Context,
        callee: &Callee,
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        let mut taken: Vec<Effects> = Vec::new();
        let mut places: Vec<&Place> = Vec::new();
        let results = call.enable.result.iter().map(|(place, _)| place);
        let outputs = self.outputs(call).into_iter().chain(results);
        for (place, is_output) in
            handed_over(call).map(|place| (place, false)).chain(outputs.map(|place| (place, true)))
        {
            let mut own = Effects::default();
            self.written(at, place, &mut own);
            let meets = |(one, other): (&Effects, &&Place)| {
                is_output && !are_other_parts(place, other) && own.changes(one)
            };
            if taken.iter().zip(&places).any(meets) {
                let told = format!(
                    "{} is given two values by one call: controllers differ in which of them it keeps",
                    place.text
                );
                let help =
                    "give the outputs variables of their own, and assign these behind the call";
                return Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help));
            }
            taken.push(own);
            places.push(place);
        }
        let keeps = match callee {
            Callee::Unit(_, unit) => self.tree.unit(*unit).kind != PouKind::Function,
            Callee::Standard(..) => true,
            Callee::Method(..) => false,
        };
        if !keeps {
            return Ok(());
        }
        for (parameter, passed) in &call.passed {
            let Some(spot) = self.parameter(callee, *parameter) else { continue };
            let (Passed::ByValue(_) | Passed::InOut(_)) = passed else { continue };
            let mut own = Effects::default();
            add(&mut own.writes, spot.tag.regions());
            for (other, passed) in &call.passed {
                let (Passed::ByValue(one) | Passed::InOut(one)) = passed else { continue };
                if other != parameter && self.may_read(at, one, (*parameter, &own)) {
                    let told = format!(
                        "{} is passed by a call that also reads it: controllers differ in which value is read",
                        spot.name
                    );
                    let help = "assign what is read to a variable of its own before the call";
                    return Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help));
                }
            }
        }
        Ok(())
    }

    /// Whether an expression may read a parameter that lies in what `own` writes. Where it reads an instance whose index
    /// is not known, another input or output of it is not the parameter.
    fn may_read(
        &mut self,
        at: &Context,
        one: &Expr,
        (parameter, own): (Parameter, &Effects),
    ) -> bool {
        let mut parts: Vec<Expr> = Vec::new();
        let mut is_plain = true;
        one.each(&mut |part| match &part.kind {
            ExprKind::Read(_) => parts.push(part.clone()),
            ExprKind::Call(_) | ExprKind::After(_) | ExprKind::Address(_) => is_plain = false,
            _ => {}
        });
        if !is_plain {
            parts = vec![one.clone()];
        }
        parts.iter().any(|part| {
            if let ExprKind::Read(place) = &part.kind
                && is_other_member(place, parameter)
            {
                return place.indices().any(|index| self.may_read(at, index, (parameter, own)));
            }
            let mut read = Effects::default();
            self.of_expr(at, part, &mut read);
            own.changes(&read)
        })
    }

    /// Refuses a call whose arguments change what the others read, if they stand in an order that is neither that in
    /// which they are declared nor its reverse: both are covered, and a third one is not.
    pub(super) fn evaluates_in_two_orders(
        &mut self,
        at: &Context,
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        let declared: Vec<Option<VarId>> = call
            .passed
            .iter()
            .map(|(parameter, _)| match parameter {
                Parameter::Variable(id) => Some(*id),
                Parameter::Pin(_) => None,
            })
            .collect();
        let in_order = |pair: &[Option<VarId>]| pair[0].is_some() && pair[0] < pair[1];
        let exprs: Vec<&Expr> = call.values().collect();
        if exprs.len() < 3 || declared.windows(2).all(in_order) {
            return Ok(());
        }
        let pairs = (1..exprs.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
        let tied: BTreeSet<usize> = pairs
            .filter(|&(one, other)| self.order_matters(at, exprs[one], exprs[other]))
            .flat_map(|(one, other)| [one, other])
            .collect();
        if tied.len() < 3 {
            return Ok(());
        }
        let told = "arguments of one call change what the others read: controllers evaluate them as they are written or as they are declared";
        let help = "give the arguments in the order in which they are declared, or assign what they call to variables before";
        Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help))
    }

    /// Refuses a call of an action or a method, from outside, that reaches what its instance's calls hand over in and out: what
    /// the last call handed over is meant.
    pub(super) fn member_names_handed(
        &mut self,
        called: (usize, Entry),
        line: u32,
    ) -> Result<(), Fault> {
        let tree = self.tree;
        let Instance { unit, spot } = self.instances[called.0].clone();
        let both: Vec<VarId> = tree
            .members(unit)
            .into_iter()
            .filter(|&one| tree.variable(one).section == Section::InOut)
            .collect();
        if both.is_empty() || self.stated_of(called.0, called.1).is_some() {
            return Ok(());
        }
        let effects = self.effects_of(called);
        for id in both {
            let Some(part) = self.member(&spot, unit, id) else { continue };
            let mut own = Effects::default();
            add(&mut own.reads, part.tag.regions());
            if own.meets(&effects) {
                let name = &tree.variable(id).name;
                let message = format!(
                    "{name} is handed over in and out, and reached while no call of its instance hands it over"
                );
                let help = "copy it to a variable of the block in its body, or hand it over where it is needed";
                let code = FaultCode::NotModelled;
                let fault = Fault::new(line, message);
                return Err(fault.code(code).help(help));
            }
        }
        Ok(())
    }
}

/// What a call hands over in and out.
fn handed_over(call: &Call) -> impl Iterator<Item = &Place> {
    call.passed.iter().filter_map(|(_, passed)| match passed {
        Passed::InOut(one) => match &one.unconverted().kind {
            ExprKind::Read(place) => Some(place),
            _ => None,
        },
        _ => None,
    })
}

/// Whether two places are different bits of numbers or different parts of structures, whatever they are parts of.
fn are_other_parts(one: &Place, other: &Place) -> bool {
    match (one.steps.last(), other.steps.last()) {
        (Some(Step::Bit(one)), Some(Step::Bit(other))) => one != other,
        (Some(Step::Part(part)), Some(Step::Part(another))) => {
            part != another && one.steps.len() == other.steps.len() && one.root == other.root
        }
        _ => false,
    }
}

/// Whether a place is a variable or a pin of an instance, and not this one.
fn is_other_member(place: &Place, parameter: Parameter) -> bool {
    match (place.steps.last(), parameter) {
        (Some(Step::Member(id)), Parameter::Variable(own)) => *id != own,
        (Some(Step::Pin(pin)), Parameter::Pin(own)) => *pin != own,
        _ => false,
    }
}

//! Checks for aliases of VAR_IN_OUT arguments. The called code changes the caller's own variable (IEC 61131-3).
//! Lowering passes a copy and copies it back, so a call in which one variable has two names is refused.

use super::cells::{Effects, add};
use super::references::references_in;
use super::spots::{Callee, Context, Instance};
use super::{Entry, Lower};
use scanbound_base::code::Code as FaultCode;
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, Section};
use scanbound_iec_tree::declarations::VarId;
use scanbound_iec_tree::tree::{
    Call, Expr, ExprKind, Parameter, Passed, Place, Root, Step, Target,
};
use std::collections::BTreeSet;

impl Lower<'_> {
    /// Refuses a call with a VAR_IN_OUT argument that the called code also reaches by another name, or that has a
    /// chart.
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
                    "{} is passed as VAR_IN_OUT, and has a chart, whose state is not modelled there",
                    tree.variable(*id).name
                );
                let help = "call the instance where it is declared";
                return Err(Fault::new(line, message).code(FaultCode::NotModelled).help(help));
            }
        }
        let handed: Vec<&Place> = handed_over(call).collect();
        let written = written_by(call);
        if handed.is_empty() && written.iter().all(|place| self.is_fixed(at, place)) {
            return Ok(());
        }
        let within = self.effects_of(called);
        self.outputs_stay(at, &written, call.given(), within.clone(), line)?;
        let mut before = Effects::default();
        for place in handed {
            let own = self.found(|own, found| own.written(at, place, found));
            if own.meets(&before) || own.meets(&within) {
                let message = format!(
                    "{} is passed as VAR_IN_OUT, and the called code may use it by another name",
                    place.text
                );
                let help = "pass a separate variable, and copy it before and after the call";
                return Err(Fault::new(line, message).code(FaultCode::NotModelled).help(help));
            }
            before.join(&own);
        }
        Ok(())
    }

    /// Refuses a call whose outputs go to places with run-time indices or references that the call may change, because
    /// controllers evaluate these before or after the call. `within`: the effects of the call itself; `given`: its
    /// arguments.
    pub(super) fn outputs_stay<'e>(
        &mut self,
        at: &Context,
        places: &[&Place],
        given: impl Iterator<Item = &'e Expr>,
        mut within: Effects,
        line: u32,
    ) -> Result<(), Fault> {
        let moving: Vec<&Place> =
            places.iter().copied().filter(|place| !self.is_fixed(at, place)).collect();
        if moving.is_empty() {
            return Ok(());
        }
        given.for_each(|one| self.of_expr(at, one, &mut within));
        places.iter().for_each(|place| self.written(at, place, &mut within));
        for place in moving {
            let looked = self.found(|own, found| own.led_to(at, place, found));
            if place.indices().any(Expr::calls) || within.changes(&looked) {
                let message = format!(
                    "the variable that {} refers to may change while the call runs",
                    place.text
                );
                let help = "assign the index or the address to a variable that nothing else writes";
                return Err(Fault::new(line, message).code(FaultCode::NotModelled).help(help));
            }
        }
        Ok(())
    }

    /// Whether a path always leads to the same place: its indices are constants, and each of its references has only
    /// one target.
    fn is_fixed(&mut self, at: &Context, place: &Place) -> bool {
        !place.has_open_index() && references_in(place).iter().all(|one| self.means_one(at, one))
    }

    /// Refuses a call that may change which instance its path selects, or whose path changes what the call reads. Some
    /// compilers look the instance up once, others again for each input, for the body and for each output. A method's
    /// instance is looked up once, before or after its arguments.
    pub(super) fn index_stays(
        &mut self,
        at: &Context,
        place: &Place,
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        if self.is_fixed(at, place) {
            return Ok(());
        }
        let looked = self.found(|own, found| own.led_to(at, place, found));
        let takes = |passed: &Passed| matches!(passed, Passed::InOut(_) | Passed::Output(..));
        let then = self.found(|own, found| {
            call.given().for_each(|one| own.of_expr(at, one, found));
            if !matches!(call.target, Target::Method(..)) {
                own.passed_to(at, place, &call.passed, found);
            }
            if call.enable.result.is_some() || call.passed.iter().any(|(_, passed)| takes(passed)) {
                own.of_call(at, call, found);
            }
        });
        let (looked, then) = (self.lasting(at, looked), self.lasting(at, then));
        // Some controllers skip the whole call where EN is false.
        let is_again = match call.target {
            Target::Method(..) => call.enable.condition.is_some(),
            _ => !call.passed.is_empty() || call.enable.is_given(),
        };
        let is_again = is_again && place.indices().any(Expr::calls);
        if !is_again && !then.changes(&looked) && !looked.changes(&then) {
            return self.charge_indices_again(at, place, call);
        }
        let told = format!("the instance that {} refers to may change within its call", place.text);
        let help =
            "assign the index or the reference to a variable that nothing in the call writes";
        Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help))
    }

    /// Refuses a call in which an output is assigned to a variable that another output or a VAR_IN_OUT argument also
    /// writes.
    pub(super) fn writes_each_once(
        &mut self,
        at: &Context,
        handed: &[&Place],
        outputs: &[&Place],
        line: u32,
    ) -> Result<(), Fault> {
        let mut taken: Vec<Effects> = Vec::new();
        let places: Vec<&Place> = handed.iter().chain(outputs).copied().collect();
        for (number, place) in places.iter().enumerate() {
            let own = self.found(|own, found| own.written(at, place, found));
            let meets = |(one, other): (&Effects, &&Place)| {
                number >= handed.len() && !are_other_parts(place, other) && own.changes(one)
            };
            if taken.iter().zip(&places).any(meets) {
                let told = format!(
                    "{} is given two values by one call: controllers differ in which of them it keeps",
                    place.text
                );
                let help = "give each output a separate variable, and copy these after the call";
                return Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help));
            }
            taken.push(own);
        }
        Ok(())
    }

    /// Refuses a call whose result depends on the order in which its inputs are passed and its outputs taken:
    /// controllers use the written order or the declared order.
    pub(super) fn passes_in_any_order(
        &mut self,
        at: &Context,
        callee: &Callee,
        call: &Call,
        line: u32,
    ) -> Result<(), Fault> {
        let results = call.enable.result.iter().map(|(place, _)| place);
        let outputs: Vec<&Place> = self.outputs(call).into_iter().chain(results).collect();
        let handed: Vec<&Place> = handed_over(call).collect();
        self.writes_each_once(at, &handed, &outputs, line)?;
        let keeps = match callee {
            Callee::Unit(_, unit) => self.tree.unit(*unit).kind != PouKind::Function,
            Callee::Standard(..) => true,
            Callee::Method(..) => false,
        };
        if !keeps {
            return Ok(());
        }
        let mut all = Effects::default();
        for (parameter, passed) in &call.passed {
            let Some(spot) = self.parameter(callee, *parameter) else { continue };
            let (Passed::ByValue(_) | Passed::InOut(_)) = passed else { continue };
            let mut own = Effects::default();
            add(&mut own.writes, spot.tag.regions());
            all.join(&own);
            let others = call.passed.iter().filter(|(other, _)| other != parameter);
            let others = others.filter_map(|(_, passed)| match passed {
                Passed::ByValue(one) | Passed::InOut(one) => Some(one),
                Passed::Output(..) | Passed::Dropped => None,
            });
            for one in others.chain(&call.enable.condition) {
                if self.may_read(at, one, (*parameter, &own)) {
                    let told = format!(
                        "{} is passed by a call that also reads it: controllers differ in which value is read",
                        spot.name
                    );
                    let help =
                        "assign the value that is read to a separate variable before the call";
                    return Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help));
                }
            }
        }
        self.outputs_stay(at, &written_by(call), std::iter::empty(), all, line)
    }

    /// Whether an expression may read a parameter, whose cells are the writes of `own`. In an instance with an unknown
    /// index, other inputs and outputs are not this parameter.
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
            ExprKind::Address(_) | ExprKind::Step(_) => is_plain = false,
            _ => {}
        });
        if !is_plain || one.calls() {
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

    /// Refuses a call in which three or more arguments depend on the order of their evaluation, unless they are written
    /// in declared order. The written order and its reverse are modelled; a third order is not.
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
        let told = "arguments of one call change what the others read: controllers evaluate them in written or in declared order";
        let help = "write the arguments in declared order, or assign the results of their calls to variables first";
        Err(Fault::new(line, told).code(FaultCode::NotModelled).help(help))
    }

    /// Refuses a call, from outside, of an action or method that uses a VAR_IN_OUT variable of its instance: the
    /// argument of the instance's last call is meant.
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
                    "{name} is a VAR_IN_OUT parameter, and is used outside of the calls of its instance that pass it"
                );
                let help =
                    "copy it to a variable of the block in its body, or pass it where it is needed";
                let code = FaultCode::NotModelled;
                let fault = Fault::new(line, message);
                return Err(fault.code(code).help(help));
            }
        }
        Ok(())
    }
}

/// The caller's places that a call writes: VAR_IN_OUT arguments, output targets and the target of ENO.
pub(super) fn written_by(call: &Call) -> Vec<&Place> {
    let taken = call.passed.iter().filter_map(|(_, passed)| match passed {
        Passed::Output(place, _) => Some(place),
        _ => None,
    });
    let results = call.enable.result.iter().map(|(place, _)| place);
    handed_over(call).chain(taken).chain(results).collect()
}

/// The caller's places that a call passes as VAR_IN_OUT.
fn handed_over(call: &Call) -> impl Iterator<Item = &Place> {
    call.passed.iter().filter_map(|(_, passed)| match passed {
        Passed::InOut(one) => match &one.unconverted().kind {
            ExprKind::Read(place) => Some(place),
            _ => None,
        },
        _ => None,
    })
}

/// Whether a path uses no reference.
fn is_direct(place: &Place) -> bool {
    !matches!(place.root, Root::Target(_))
        && !place.steps.iter().any(|step| matches!(step, Step::Dereference))
}

/// Whether two places are different bits of integers, or different parts of structures, so that they cannot overlap
/// even if their array indices are equal.
fn are_other_parts(one: &Place, other: &Place) -> bool {
    let is_other = match (one.steps.last(), other.steps.last()) {
        (Some(Step::Bit(one)), Some(Step::Bit(other))) => one != other,
        (Some(Step::Part(one)), Some(Step::Part(other))) => one != other,
        _ => false,
    };
    is_other
        && one.root == other.root
        && one.steps.len() == other.steps.len()
        && is_direct(one)
        && is_direct(other)
}

/// Whether a place is a variable or pin of an instance, reached without a reference, and neither `parameter` nor a part
/// of it.
fn is_other_member(place: &Place, parameter: Parameter) -> bool {
    let is_own = |step: &Step| match (step, parameter) {
        (Step::Member(id), Parameter::Variable(own)) => *id == own,
        (Step::Pin(pin), Parameter::Pin(own)) => *pin == own,
        _ => false,
    };
    let is_member = matches!(
        (place.steps.last(), parameter),
        (Some(Step::Member(_)), Parameter::Variable(_)) | (Some(Step::Pin(_)), Parameter::Pin(_))
    );
    is_member && is_direct(place) && !place.steps.iter().any(is_own)
}

//! Expressions that compilers to C may evaluate several times or not at all: the operands of XOR and MOD, compiled as
//! `l && !r || !l && r` and `r == 0 ? 0 : l % r`, and the indices of a called instance, which are repeated in each line
//! that passes an argument.

use super::Lower;
use super::spots::Context;
use super::values::{MAX_CALLS, literal_value};
use scanbound_base::code::Code;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::tree::{Call, Expr, ExprKind, Passed, Place, Target};

impl Lower<'_> {
    /// Charges the operands of a Boolean XOR or of MOD that some compilers evaluate once more. A fault if this may
    /// change more than the time.
    pub(super) fn again(
        &mut self,
        at: &Context,
        operator: Operator,
        (left, right): (&Expr, &Expr),
        is_truth_value: bool,
    ) -> Result<(), Fault> {
        match operator {
            Operator::Xor if is_truth_value => {
                self.charge_again(at, left)?;
                if self.order_matters(at, left, right) {
                    return Err(evaluated_again(left.line));
                }
            }
            Operator::Modulo => {
                self.charge_again(at, right)?;
                // Where the divisor is 0, these compilers skip the left operand.
                if literal_value(right).is_none_or(|by| by == 0) && self.leaves_more(at, left) {
                    return Err(evaluated_again(left.line));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Charges an operand of XOR or MOD once more. Plain variables are part of the time of the operator. A fault if the
    /// operand has side effects, or if too many XOR and MOD are nested in it.
    fn charge_again(&mut self, at: &Context, operand: &Expr) -> Result<(), Fault> {
        if !takes_time(operand) {
            return Ok(());
        }
        let within = doublings(operand);
        if self.leaves_more(at, operand) {
            return Err(evaluated_again(operand.line));
        }
        if within > MAX_CALLS {
            let told = format!(
                "more than {MAX_CALLS} XOR and MOD are nested in an operand of XOR or MOD: some compilers double its time with each"
            );
            let help = "assign a part of the expression to a separate variable first";
            return Err(Fault::new(operand.line, told).code(Code::NotModelled).help(help));
        }
        self.charge_where_again(at, &[operand], 1)
    }

    /// Charges expressions `times` more, where the compiler evaluates them again.
    fn charge_where_again(
        &mut self,
        at: &Context,
        all: &[&Expr],
        times: usize,
    ) -> Result<(), Fault> {
        let again = self.extra_time();
        let skip = self.jump(again.not(), None);
        for one in std::iter::repeat_n(all, times).flatten() {
            self.open_value(at, one)?;
        }
        self.land(skip);
        self.landing();
        Ok(())
    }

    /// Charges the indices of a called instance once more for each line that passes or takes a value, since they are
    /// evaluated in each.
    pub(super) fn charge_indices_again(
        &mut self,
        at: &Context,
        place: &Place,
        call: &Call,
    ) -> Result<(), Fault> {
        let indices: Vec<&Expr> = place.indices().filter(|one| takes_time(one)).collect();
        // A VAR_IN_OUT argument is passed before the body and copied back after it.
        let both = |one: &&(_, Passed)| matches!(one.1, Passed::InOut(_));
        let lines = call.passed.len()
            + call.passed.iter().filter(both).count()
            + usize::from(call.enable.condition.is_some())
            + usize::from(call.enable.result.is_some());
        if indices.is_empty() || lines == 0 || matches!(call.target, Target::Method(..)) {
            return Ok(());
        }
        self.charge_where_again(at, &indices, lines)
    }

    /// Whether an expression has calls that may have side effects.
    fn leaves_more(&mut self, at: &Context, one: &Expr) -> bool {
        let effects = self.expression_effects(at, one);
        one.calls() && (effects.anything || !effects.writes.is_empty())
    }
}

/// Whether an expression takes more time than a constant or a plain variable.
fn takes_time(one: &Expr) -> bool {
    let mut takes = false;
    one.each(&mut |one| {
        takes |= match &one.kind {
            ExprKind::Call(_) | ExprKind::After(_) | ExprKind::Standard(_) | ExprKind::Not(_) => {
                true
            }
            ExprKind::Binary(..) | ExprKind::Negate(_) => one.whole().is_none(),
            ExprKind::Read(place) | ExprKind::Address(place) => place.has_open_index(),
            ExprKind::Step(flag) => flag.owner.has_open_index(),
            // The walk also visits the expressions inside these.
            ExprKind::Convert(_) | ExprKind::List(_) | ExprKind::Either(_) => false,
            ExprKind::Bool(_)
            | ExprKind::Whole(_)
            | ExprKind::Typed(_)
            | ExprKind::Named(_)
            | ExprKind::Real(_)
            | ExprKind::Time(_)
            | ExprKind::Opaque
            | ExprKind::Text(_)
            | ExprKind::Null
            | ExprKind::Fault(_) => false,
        };
    });
    takes
}

/// The number of XOR and MOD in an expression and its indices. Each may double the time.
fn doublings(one: &Expr) -> usize {
    let mut count = 0;
    one.each(&mut |one| match &one.kind {
        ExprKind::Binary(Operator::Xor | Operator::Modulo, ..) => count += 1,
        ExprKind::Read(place) | ExprKind::Address(place) => {
            count += place.indices().map(doublings).sum::<usize>();
        }
        ExprKind::Step(flag) => count += flag.owner.indices().map(doublings).sum::<usize>(),
        _ => {}
    });
    count
}

/// The fault of a XOR or MOD whose operands have calls with side effects.
fn evaluated_again(line: u32) -> Fault {
    let told =
        "an operand of XOR or MOD calls something: some compilers evaluate it twice, or not at all";
    let help = "assign the result of the call to a separate variable first";
    Fault::new(line, told).code(Code::NotModelled).help(help)
}

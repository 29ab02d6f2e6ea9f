//! XOR and MOD as compilers write them in C: `l && !r || !l && r`, and `r == 0 ? 0 : l % r`. Their operands may be evaluated
//! twice, or not at all.

use super::Lower;
use super::spots::Context;
use super::values::{MAX_CALLS, literal_value};
use scanbound_base::code::Code;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::tree::{Expr, ExprKind};

impl Lower<'_> {
    /// Charges what of a XOR of truth values or a MOD some compilers evaluate once more. Refuses operands for which this
    /// makes a difference to more than the time.
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
                // Where the divisor is 0, these compilers leave the left operand out.
                if literal_value(right).is_none_or(|by| by == 0) && self.leaves_more(at, left) {
                    return Err(evaluated_again(left.line));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Charges an operand once more, if it calls something: compilers that write XOR of truth values with AND and OR
    /// evaluate it twice, and so do those that test the divisor of MOD. Refuses one that leaves more than its value.
    fn charge_again(&mut self, at: &Context, operand: &Expr) -> Result<(), Fault> {
        if !self.calls_own(operand) {
            return Ok(());
        }
        let mut within = 0;
        operand.each(&mut |one| {
            let ExprKind::Binary(operator, ..) = &one.kind else { return };
            within += usize::from(matches!(operator, Operator::Xor | Operator::Modulo));
        });
        if within > MAX_CALLS || self.leaves_more(at, operand) {
            return Err(evaluated_again(operand.line));
        }
        let twice = self.extra_time();
        let skip = self.jump(twice.not(), None);
        self.open_value(at, operand)?;
        self.land(skip);
        self.landing();
        Ok(())
    }

    /// Whether an expression calls what writes variables, or may.
    fn leaves_more(&mut self, at: &Context, one: &Expr) -> bool {
        let effects = self.expression_effects(at, one);
        self.calls_own(one) && (effects.anything || !effects.writes.is_empty())
    }
}

/// The fault of a XOR or MOD whose operands' calls do more than give a value, or of which too many stand in each other.
fn evaluated_again(line: u32) -> Fault {
    let told =
        "an operand of XOR or MOD calls something: some compilers evaluate it twice, or not at all";
    let help = "assign what the call gives to a variable of its own before";
    Fault::new(line, told).code(Code::NotModelled).help(help)
}

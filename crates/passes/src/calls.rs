//! Rejects recursion, for which a scan has no bound, and calls nested deeper than any CPU allows.

use super::pass::Pass;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_ir::{Program, flow};

/// The deepest nesting of calls that is accepted. No CPU allows a deeper one.
const MAX_NESTING: usize = 64;

/// Rejects routines that call themselves, directly or through others, and calls nested more than 64 deep. Changes
/// nothing.
pub const PASS: Pass = Pass { name: "following calls", run: |program, _| check(program) };

fn check(program: &Program) -> Result<(), Vec<Diagnostic>> {
    let (at, code, message, help) = if let Some(at) = flow::recursion(program) {
        let message = "this call is recursive, so the scan has no bound".to_owned();
        (
            at,
            Code::Recursion,
            message,
            "remove this call, or the call that leads back to this subroutine",
        )
    } else if let Some(at) = flow::nested_beyond(program, MAX_NESTING) {
        let message = format!("calls are nested more than {MAX_NESTING} deep");
        (
            at,
            Code::Nesting,
            message,
            "reduce the nesting of calls: most CPUs allow 16 levels, none more than 64",
        )
    } else {
        return Ok(());
    };
    Err(vec![program.fault(&program.instructions[at], code, message, help)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_ir::{Logic, Step, testing};

    /// A program of `calls` routines, each of which calls the next; the last one calls routine `last`.
    fn chain(calls: usize, last: usize) -> Program {
        let call = |target| [Step::Call { fires: Logic::Const(true), target }, Step::Return];
        let mut steps = vec![Step::Call { fires: Logic::Const(true), target: 2 }, Step::End];
        (1..calls).for_each(|n| steps.extend(call(2 + 2 * n)));
        steps.extend(if last > 0 { call(last) } else { [Step::Nothing, Step::Return] });
        testing::program(steps)
    }

    #[test]
    fn calls_may_stand_in_each_other_but_not_in_a_circle_nor_too_deep() {
        let code = |calls, last| check(&chain(calls, last)).map_err(|faults| faults[0].code);
        assert_eq!(code(1, 0), Ok(()));
        assert_eq!(code(MAX_NESTING, 0), Ok(()));
        assert_eq!(code(MAX_NESTING + 1, 0), Err(Code::Nesting));
        assert_eq!(code(3, 2), Err(Code::Recursion));
        assert_eq!(code(1, 2), Err(Code::Recursion));
    }
}

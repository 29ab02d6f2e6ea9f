//! Calls that lead back to themselves, or stand too deep in each other: such a scan has no bound, or none that a PLC runs.

use super::Pass;
use crate::base::code::Code;
use crate::base::diagnostic::Diagnostic;
use crate::program::{Program, flow};

/// More calls stand in each other on no CPU.
const MOST_NESTED: usize = 64;

/// Routines are refused that call themselves, be it by way of others.
pub const PASS: Pass = Pass { name: "following calls", run: |program, _| check(program) };

fn check(program: &Program) -> Result<(), Vec<Diagnostic>> {
    let (at, code, message, help) = if let Some(at) = flow::recursion(program) {
        let message = "this call leads back to itself: the scan has no bound".to_owned();
        (at, Code::Recursion, message, "subroutines must not call each other in a circle")
    } else if let Some(at) = flow::nested_beyond(program, MOST_NESTED) {
        let message = format!("more than {MOST_NESTED} calls stand in each other");
        (at, Code::Nesting, message, "no CPU allows more than 64; most allow 16")
    } else {
        return Ok(());
    };
    Err(vec![program.fault(&program.instructions[at], code, message, help)])
}

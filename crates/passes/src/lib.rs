//! Passes, from program to program: what is the same for every dialect.
//!
//! A pass is a file and its line in `PASSES`. A pass keeps every scan that the program has: it may let a program do more,
//! never less.

pub mod calls;
pub mod interrupts;
pub mod loops;
mod pass;
pub mod values;

pub use pass::{Pass, Passes, Settings};
#[cfg(any(test, feature = "testing"))]
use scanbound_base::diagnostic::Diagnostic;
#[cfg(any(test, feature = "testing"))]
use scanbound_ir::Program;

/// All passes, in the order in which they run.
pub static PASSES: Passes = Passes(&[&calls::PASS, &loops::PASS, &interrupts::PASS, &values::PASS]);

/// What a front handed over, through the passes that a program's meaning needs.
///
/// # Errors
/// The faults of the first pass that finds any.
#[cfg(any(test, feature = "testing"))]
pub fn passed(mut program: Program) -> Result<Program, Vec<Diagnostic>> {
    let passes = Passes(&[&calls::PASS, &loops::PASS, &interrupts::PASS]);
    passes.run(&mut program, &Settings::default(), |_| {})?;
    Ok(program)
}

//! Transformations from program to program that are the same for every dialect.
//!
//! A pass is a file with an entry in [`PASSES`]. It preserves every scan of the program: it may add behaviour, but
//! never remove any.

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

/// All passes in execution order.
pub static PASSES: Passes = Passes(&[&calls::PASS, &loops::PASS, &interrupts::PASS, &values::PASS]);

/// The program after the passes without which a scan cannot be followed: all but the one that bounds values.
///
/// # Errors
/// The errors of the first pass that finds any.
#[cfg(any(test, feature = "testing"))]
pub fn passed(mut program: Program) -> Result<Program, Vec<Diagnostic>> {
    let passes = Passes(&[&calls::PASS, &loops::PASS, &interrupts::PASS]);
    passes.run(&mut program, &Settings::default(), |_| {})?;
    Ok(program)
}

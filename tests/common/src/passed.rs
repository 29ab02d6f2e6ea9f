//! A program before the analysis of the values of its words.

use scanbound::base::diagnostic::Diagnostic;
use scanbound::passes::{Passes, Settings, calls, interrupts, loops};
use scanbound::program::Program;

/// The passes that every program needs.
static PASSES: Passes = Passes(&[&calls::PASS, &loops::PASS, &interrupts::PASS]);

/// A front's program after these passes.
pub fn passed(mut program: Program) -> Result<Program, Vec<Diagnostic>> {
    PASSES.run(&mut program, &Settings::default(), |_| {})?;
    Ok(program)
}

//! A program as it is before anything is known of what its words hold.

use scanbound::base::diagnostic::Diagnostic;
use scanbound::passes::{Passes, Settings, calls, interrupts, loops};
use scanbound::program::Program;

/// The passes that a program's meaning needs.
static PASSES: Passes = Passes(&[&calls::PASS, &loops::PASS, &interrupts::PASS]);

/// What a front handed over, through these passes.
pub fn passed(mut program: Program) -> Result<Program, Vec<Diagnostic>> {
    PASSES.run(&mut program, &Settings::default(), |_| {})?;
    Ok(program)
}

//! Passes, from program to program: what is the same for every dialect.
//!
//! A pass is a file and its line in `passes!`; they run in this order on what a front hands over. A pass keeps every
//! scan that the program has: it may let a program do more, never less.

use scanbound_base::budget::Budget;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_ir::Program;
use values::Trust;

/// Declares the passes' modules and lists what each has as its `PASS`.
macro_rules! passes {
    ($($name:ident,)*) => {
        $(pub mod $name;)*

        /// All passes, in the order in which they run.
        pub static PASSES: Passes = Passes(&[$(&$name::PASS),*]);
    };
}

passes! {
    calls,
    loops,
    interrupts,
    values,
}

/// A pass.
#[derive(Debug, Clone, Copy)]
pub struct Pass {
    /// What it does, told while it runs.
    pub name: &'static str,
    /// Does it. Faults are those of programs whose scan has no bound.
    pub run: fn(&mut Program, &Settings<'_>) -> Result<(), Vec<Diagnostic>>,
}

/// What the user may choose of passes, and what they may take.
#[derive(Clone, Copy, Default)]
pub struct Settings<'a> {
    /// Whose writes between scans are reckoned with.
    pub trust: Trust,
    /// Until when they may go on, if there is a limit.
    pub budget: Option<&'a Budget<'a>>,
}

/// Some passes, as a registry lists them.
#[derive(Debug, Clone, Copy)]
pub struct Passes(pub &'static [&'static Pass]);

impl Passes {
    /// Runs them in their order, each told of before it begins.
    ///
    /// # Errors
    /// The faults of the first pass that finds any.
    pub fn run(
        self,
        program: &mut Program,
        settings: &Settings<'_>,
        mut told: impl FnMut(&'static str),
    ) -> Result<(), Vec<Diagnostic>> {
        for pass in self.0 {
            told(pass.name);
            (pass.run)(program, settings)?;
        }
        program.approximations.sort();
        program.approximations.dedup();
        Ok(())
    }
}

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

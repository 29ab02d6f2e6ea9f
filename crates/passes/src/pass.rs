//! What a pass is, and what its user may choose.

use scanbound_base::budget::Budget;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_ir::{Cell, Program, Role};

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

/// Whose writes between scans are reckoned with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Trust {
    /// Anybody's, to every device.
    None,
    /// Anybody's, but to the words that serve as counts, lengths or indices, or that these are worked out from, and that
    /// the program writes in every scan.
    #[default]
    Counts,
    /// Anybody's to what the program does not write itself, or only ever clears.
    All,
}

impl Trust {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Trust::None => "none",
            Trust::Counts => "counts",
            Trust::All => "all",
        }
    }

    /// Whether a cell that nobody but the program has reason to write is trusted whatever it serves: all, or what the
    /// user states to be so and what a front makes for itself.
    #[must_use]
    pub fn holds_alone(self, program: &Program, cell: Cell) -> bool {
        match self {
            Trust::None => false,
            Trust::Counts => {
                is_internal(program, cell) || program.area(cell.area).role == Role::Hidden
            }
            Trust::All => true,
        }
    }
}

/// Whether the user states that nobody but the program writes a cell.
pub(crate) fn is_internal(program: &Program, cell: Cell) -> bool {
    program.internal.iter().any(|region| region.holds(cell))
}

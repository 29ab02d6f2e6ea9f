//! The definition of a pass, and the options of passes.

use scanbound_base::budget::Budget;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_ir::{Cell, Program, Role};

/// A pass: a step of the analysis that checks or changes the program before its scan is followed.
#[derive(Debug, Clone, Copy)]
pub struct Pass {
    /// What the pass does, for progress messages.
    pub name: &'static str,
    /// Runs the pass. Errors mean that a scan of the program has no bound, or one that is too large to count.
    pub run: fn(&mut Program, &Settings<'_>) -> Result<(), Vec<Diagnostic>>,
}

/// The user's options for passes, and the time budget.
#[derive(Clone, Copy, Default)]
pub struct Settings<'a> {
    /// Which words other writers are assumed to write between scans, besides what the facts name under `[external]`.
    pub trust: Trust,
    /// The time budget of the analysis; `None`: no limit.
    pub budget: Option<&'a Budget<'a>>,
}

/// A list of passes, in the order in which they run.
#[derive(Debug, Clone, Copy)]
pub struct Passes(pub &'static [&'static Pass]);

impl Passes {
    /// Runs the passes in order; `before` is called with the name of each before it runs. Then sorts the program's list
    /// of over-approximations, without duplicates.
    ///
    /// # Errors
    /// The errors of the first pass that finds any; the passes after it do not run.
    pub fn run(
        self,
        program: &mut Program,
        settings: &Settings<'_>,
        mut before: impl FnMut(&'static str),
    ) -> Result<(), Vec<Diagnostic>> {
        for pass in self.0 {
            before(pass.name);
            (pass.run)(program, settings)?;
        }
        program.approximations.sort();
        program.approximations.dedup();
        Ok(())
    }
}

/// Which words other writers (such as an HMI) are assumed to write between scans (`--trust`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Trust {
    /// Other writers may write any word. No word is trusted.
    None,
    /// Other writers may write any word except two kinds: words that give counts, lengths or indices, or from which
    /// these are computed, and that the program writes in every scan; and internal words.
    #[default]
    Counts,
    /// Other writers may write only words that the program does not write itself, or only clears.
    All,
}

impl Trust {
    /// The name in options and reports, such as `counts`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Trust::None => "none",
            Trust::Counts => "counts",
            Trust::All => "all",
        }
    }

    /// Whether a cell is trusted whatever it is used for, provided that no other writer has a reason to write it: with
    /// `All` every such cell; with `Counts` only internal cells and those that the user states to be internal.
    #[must_use]
    pub fn trusts_exclusive_cell(self, program: &Program, cell: Cell) -> bool {
        match self {
            Trust::None => false,
            Trust::Counts => {
                is_internal(program, cell) || program.area(cell.area).role == Role::Internal
            }
            Trust::All => true,
        }
    }
}

/// Whether the user states that only the program writes a cell.
pub(crate) fn is_internal(program: &Program, cell: Cell) -> bool {
    program.internal.iter().any(|region| region.contains(cell))
}

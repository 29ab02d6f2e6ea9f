//! Bodies and statements of the source, and the instructions into which they were translated.

use super::ChoiceId;
use scanbound_base::location::Location;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// A body of code: a program unit, an action, a method, or an action block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Body {
    /// The name of the program, function block, function or action.
    pub name: String,
    /// The abbreviation of the body's language, such as ST.
    pub language: &'static str,
    /// Whether a scan can call the body.
    pub is_called: bool,
    /// Why the body could not be read. `None` if it was read.
    pub unreadable: Option<String>,
}

/// A statement of a body. Nested statements are counted separately.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Statement {
    /// The body that contains the statement, an index into `Statements::bodies`.
    pub body: usize,
    /// The position of the statement.
    pub place: Location,
    /// The first line of the statement.
    pub text: Arc<str>,
    /// The number of source statements for which this statement stands: for the control of an action, the number of
    /// blocks that name the action; otherwise 1.
    pub count: u32,
}

/// The bodies and statements of a project, if its front provides them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Statements {
    /// All bodies, including those that nothing calls.
    pub bodies: Vec<Body>,
    /// The statements of the bodies that are called.
    pub all: Vec<Statement>,
    /// For each instance of a statement, its instructions and its index in `all`. An outer statement comes before the
    /// statements nested in it.
    pub ranges: Vec<(Range<usize>, usize)>,
    /// Choices that exist only because the language leaves a result undefined. Choices of the kind `ChoiceKind::Exact`
    /// whose result is unknown are not included.
    pub undefined_by_language: BTreeSet<ChoiceId>,
}

impl Statements {
    /// For each of the first `instructions` instructions: the innermost statement to which it belongs, an index into
    /// `all`. `None` if it belongs to none.
    #[must_use]
    pub fn by_instruction(&self, instructions: usize) -> Vec<Option<usize>> {
        let mut found = vec![None; instructions];
        for (range, statement) in &self.ranges {
            let within = range.start.min(instructions)..range.end.min(instructions);
            found[within].fill(Some(*statement));
        }
        found
    }
}

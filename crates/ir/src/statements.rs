//! Bodies and statements of the source, and which instructions they became.

use super::ChoiceId;
use scanbound_base::location::Location;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// Something with a body of its own: a unit, an action, a method, an action block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// The short name of the language in which it is written.
    pub language: &'static str,
    /// Whether a scan can come to it.
    pub is_called: bool,
    /// Why it could not be read, if it could not.
    pub unread: Option<String>,
}

/// A statement of a body. What stands within another's is counted by itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Statement {
    /// Its body, an index into `Statements::bodies`.
    pub body: usize,
    /// Where it stands.
    pub place: Location,
    /// Its first line.
    pub text: Arc<str>,
    /// For how many it stands: an action's control, for all blocks that name the action; else 1.
    pub count: u32,
}

/// The bodies and statements of a project, where its front tells them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Statements {
    /// All bodies, those that nothing calls, too.
    pub bodies: Vec<Body>,
    /// The statements of those that are called.
    pub all: Vec<Statement>,
    /// Which instructions a statement became, once for each instance; it stands before those that stand within it.
    pub ranges: Vec<(Range<usize>, usize)>,
    /// What takes any value only where the language leaves open what it is, besides exact choices where these are not
    /// settled.
    pub unsettled: BTreeSet<ChoiceId>,
}

impl Statements {
    /// For each instruction the innermost statement that it belongs to.
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

//! What is executed: statements, drawings and charts, as they stand in the source.

use crate::ast::{Expr, Literal, Path, Statement, change, same};
use crate::drawing::Drawing;
use crate::fault::Fault;
use crate::show;

/// A language of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Language {
    /// Structured text.
    St,
    /// Instruction list.
    Il,
    /// Ladder diagram.
    Ld,
    /// Function block diagram.
    Fbd,
    /// Sequential function chart.
    Sfc,
}

impl Language {
    /// Its short name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Language::St => "ST",
            Language::Il => "IL",
            Language::Ld => "LD",
            Language::Fbd => "FBD",
            Language::Sfc => "SFC",
        }
    }
}

/// What is executed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Body {
    /// Statements, and the language that they were written in.
    Code(Language, Vec<Statement>),
    /// Drawings that are executed one after another, and their language.
    Drawn(Language, Vec<Drawing>),
    /// A chart.
    Chart(Box<Chart>),
    /// What could not be read, and why.
    Unread(Language, Fault),
}

impl Body {
    /// A body without a statement.
    #[must_use]
    pub fn empty() -> Body {
        Body::Code(Language::St, Vec::new())
    }

    /// Whether nothing stands in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        match self {
            Body::Code(_, statements) => statements.is_empty(),
            Body::Drawn(_, drawings) => drawings.is_empty(),
            Body::Chart(_) | Body::Unread(..) => false,
        }
    }

    /// The language that it was written in.
    #[must_use]
    pub fn language(&self) -> Language {
        match self {
            Body::Code(language, _) | Body::Drawn(language, _) | Body::Unread(language, _) => {
                *language
            }
            Body::Chart(_) => Language::Sfc,
        }
    }

    /// Shows every expression, to be changed; what is written and what is called as a path of its own.
    pub fn change(&mut self, expr: &mut dyn FnMut(&mut Expr), path: &mut dyn FnMut(&mut Path)) {
        match self {
            Body::Code(_, statements) => change(statements, expr, path),
            Body::Drawn(_, drawings) => drawings.iter_mut().for_each(|one| one.change(expr, path)),
            Body::Chart(chart) => {
                chart.transitions.iter_mut().for_each(|one| expr(&mut one.condition));
                for block in chart.steps.iter_mut().flat_map(|step| &mut step.blocks) {
                    block.time.iter_mut().for_each(&mut *expr);
                    match &mut block.target {
                        Target::Inline(_, body) => body.change(expr, path),
                        Target::Path(target) => path(target),
                    }
                }
            }
            Body::Unread(..) => {}
        }
    }
}

/// A body with a name: an action, or the condition of a named transition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// What it does.
    pub body: Body,
    /// Its line.
    pub line: u32,
}

/// When a step's action runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Qualifier {
    /// Not stored: while the step is active.
    N,
    /// Resets what was stored.
    R,
    /// Stored: until it is reset.
    S,
    /// Limited: while the step is active, at most for the time.
    L,
    /// Delayed: while the step is active, from the time on.
    D,
    /// Pulse: once when the step becomes active.
    P,
    /// Once when the step ends.
    P0,
    /// Once when the step becomes active, with nothing after it.
    P1,
    /// Stored and delayed: from the time on, whether or not the step is still active, until it is reset.
    Sd,
    /// Delayed and stored: from the time on, if the step is still active then, until it is reset.
    Ds,
    /// Stored and limited: at most for the time, whether or not the step is still active, or until it is reset.
    Sl,
}

impl Qualifier {
    /// All.
    pub const ALL: [Qualifier; 11] = [
        Qualifier::N,
        Qualifier::R,
        Qualifier::S,
        Qualifier::L,
        Qualifier::D,
        Qualifier::P,
        Qualifier::P0,
        Qualifier::P1,
        Qualifier::Sd,
        Qualifier::Ds,
        Qualifier::Sl,
    ];

    /// As charts write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["N", "R", "S", "L", "D", "P", "P0", "P1", "SD", "DS", "SL"][self as usize]
    }

    /// The qualifier of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Qualifier> {
        Qualifier::ALL.into_iter().find(|one| same(one.name(), name))
    }

    /// Whether it has a time.
    #[must_use]
    pub fn is_timed(self) -> bool {
        matches!(self, Qualifier::L | Qualifier::D | Qualifier::Sd | Qualifier::Ds | Qualifier::Sl)
    }

    /// Whether the action may go on when the step has ended.
    #[must_use]
    pub fn is_stored(self) -> bool {
        matches!(self, Qualifier::S | Qualifier::Sd | Qualifier::Ds | Qualifier::Sl)
    }
}

/// What an action block controls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// An action of the unit, of an instance in it, or a Boolean variable.
    Path(Path),
    /// What stands in the block itself, and its name: that of its step and its number there.
    Inline(String, Box<Body>),
}

impl Target {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Target::Path(path) => show::path(path),
            Target::Inline(name, _) => name.clone(),
        }
    }

    /// Whether this is its name.
    #[must_use]
    pub fn is_named(&self, name: &str) -> bool {
        match self {
            Target::Path(path) => match path.as_name() {
                Some(own) => same(own, name),
                None => same(&show::path(path), name),
            },
            Target::Inline(own, _) => same(own, name),
        }
    }
}

/// An action block of a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// When the action runs.
    pub qualifier: Qualifier,
    /// Its time.
    pub time: Option<Expr>,
    /// The action.
    pub target: Target,
    /// Its line.
    pub line: u32,
}

impl Block {
    /// Its time in nanoseconds, where it is a constant.
    #[must_use]
    pub fn constant_time(&self) -> Option<i64> {
        match &self.time {
            Some(Expr::Literal(Literal::Time(time))) => Some(*time),
            _ => None,
        }
    }
}

/// A step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// Its name.
    pub name: String,
    /// Whether it is active at first.
    pub initial: bool,
    /// Its action blocks.
    pub blocks: Vec<Block>,
    /// Runs once when the step becomes active, before anything else of it (CODESYS).
    pub entry: Option<Path>,
    /// Runs while the step is active, without a last run after it (CODESYS).
    pub active: Option<Path>,
    /// Runs once when the step has ended (CODESYS).
    pub exit: Option<Path>,
    /// Whether it is drawn as a macro step, but without a chart of its own.
    pub is_macro: bool,
    /// Its line.
    pub line: u32,
    /// Its number in the source, where that has one.
    pub id: Option<String>,
}

impl Step {
    /// A step without actions.
    #[must_use]
    pub fn new(name: impl Into<String>, initial: bool, line: u32) -> Step {
        Step {
            name: name.into(),
            initial,
            blocks: Vec::new(),
            entry: None,
            active: None,
            exit: None,
            is_macro: false,
            line,
            id: None,
        }
    }
}

/// A transition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transition {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The steps in front of it.
    pub from: Vec<usize>,
    /// The steps behind it.
    pub to: Vec<usize>,
    /// Its condition.
    pub condition: Expr,
    /// Whether it has a priority of its own.
    pub has_priority: bool,
    /// Its line.
    pub line: u32,
    /// Its number in the source, where that has one.
    pub id: Option<String>,
}

/// A macro step. Its chart stands in its place: the steps in it are named `MACRO.STEP`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Macro {
    /// Its name, behind those of the macro steps that it stands in.
    pub name: String,
    /// The steps that stand in its place, also those of macro steps in it.
    pub steps: Vec<usize>,
    /// The line where it is drawn.
    pub line: u32,
}

/// A chart. Transitions that compete for a step are in the order of their priority, the first goes first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Chart {
    /// The steps.
    pub steps: Vec<Step>,
    /// The transitions.
    pub transitions: Vec<Transition>,
    /// The macro steps, each in front of those in it.
    pub macros: Vec<Macro>,
    /// The line where it begins.
    pub line: u32,
    /// Which bytes of the file it takes, where it is an element of XML.
    pub span: Option<(usize, usize)>,
}

#[cfg(test)]
mod tests {
    use super::Qualifier;

    #[test]
    fn qualifiers_and_their_names_stand_at_their_numbers() {
        for (at, one) in Qualifier::ALL.into_iter().enumerate() {
            assert_eq!(one as usize, at, "{one:?}");
            assert_eq!(one.name(), format!("{one:?}").to_uppercase());
        }
    }
}

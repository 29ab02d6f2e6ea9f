//! Bodies of units: statements, drawings and charts, in the form of the source.

use crate::ast::{Expr, Literal, Path, Statement, change, same};
use crate::drawing::Drawing;
use crate::fault::Fault;
use crate::show;

/// A programming language of IEC 61131-3.
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
    /// The usual abbreviation, such as `ST`.
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

/// The executable part of a unit, an action or a method.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Body {
    /// Statements, with the language of the source.
    Code(Language, Vec<Statement>),
    /// Networks of LD or FBD in the order of execution.
    Drawn(Language, Vec<Drawing>),
    /// A sequential function chart.
    Chart(Box<Chart>),
    /// A body that could not be read, and the reason.
    Unread(Language, Fault),
}

impl Body {
    /// An ST body without statements.
    #[must_use]
    pub fn empty() -> Body {
        Body::Code(Language::St, Vec::new())
    }

    /// Whether it has no statements or drawings. A chart and an unreadable body do not count as empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        match self {
            Body::Code(_, statements) => statements.is_empty(),
            Body::Drawn(_, drawings) => drawings.is_empty(),
            Body::Chart(_) | Body::Unread(..) => false,
        }
    }

    /// The language of the source.
    #[must_use]
    pub fn language(&self) -> Language {
        match self {
            Body::Code(language, _) | Body::Drawn(language, _) | Body::Unread(language, _) => {
                *language
            }
            Body::Chart(_) => Language::Sfc,
        }
    }

    /// Calls `expr` for every outermost expression, and `path` for every path that is written or called, both mutably.
    /// Hooks of a step (`entry`, `active`, `exit`) are not visited.
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

/// A named body: an action, or the condition of a named transition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// The code to execute, or that gives the condition.
    pub body: Body,
    /// The line of its declaration, from 1.
    pub line: u32,
}

/// The qualifier of an action block: when the action runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Qualifier {
    /// Not stored: the action runs while the step is active.
    N,
    /// Reset: ends a stored action.
    R,
    /// Stored: the action runs until it is reset.
    S,
    /// Limited: runs while the step is active, but no longer than the block's time.
    L,
    /// Delayed: runs while the step is active, but only after the block's time.
    D,
    /// Pulse: runs once when the step becomes active.
    P,
    /// Runs once when the step ends.
    P0,
    /// Runs once when the step becomes active, without a final run afterwards.
    P1,
    /// Stored and delayed: runs from the end of the time until it is reset, even if the step ends before that time.
    Sd,
    /// Delayed and stored: runs from the end of the time until it is reset, if the step is still active at that moment.
    Ds,
    /// Stored and limited: runs until the time ends or until it is reset, even if the step ends earlier.
    Sl,
}

impl Qualifier {
    /// All qualifiers in the order of the enum.
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

    /// The qualifier's spelling in a chart, such as `SD`.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["N", "R", "S", "L", "D", "P", "P0", "P1", "SD", "DS", "SL"][self as usize]
    }

    /// The qualifier of this name, ignoring case; `None` if there is none.
    #[must_use]
    pub fn named(name: &str) -> Option<Qualifier> {
        Qualifier::ALL.into_iter().find(|one| same(one.name(), name))
    }

    /// Whether it needs a time: `L`, `D`, `SD`, `DS` and `SL`.
    #[must_use]
    pub fn is_timed(self) -> bool {
        matches!(self, Qualifier::L | Qualifier::D | Qualifier::Sd | Qualifier::Ds | Qualifier::Sl)
    }

    /// Whether the action can continue after the step has ended: `S`, `SD`, `DS` and `SL`.
    #[must_use]
    pub fn is_stored(self) -> bool {
        matches!(self, Qualifier::S | Qualifier::Sd | Qualifier::Ds | Qualifier::Sl)
    }
}

/// The action or variable that an action block controls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// An action of the unit or of an instance in it, or a Boolean variable.
    Path(Path),
    /// A body written in the block itself. Its name is made of the step's name and the block's number in the step.
    Inline(String, Box<Body>),
}

impl Target {
    /// The path as text, or the name of the inline body.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Target::Path(path) => show::path(path),
            Target::Inline(name, _) => name.clone(),
        }
    }

    /// Whether [`Target::name`] equals this name, ignoring case.
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
    /// The qualifier: when the action runs.
    pub qualifier: Qualifier,
    /// Whether the qualifier is written; otherwise it is N by default.
    pub is_qualified: bool,
    /// The time of `L`, `D`, `SD`, `DS` or `SL`; `None` if none is written.
    pub time: Option<Expr>,
    /// The action or Boolean variable that the block controls.
    pub target: Target,
    /// Its line, from 1.
    pub line: u32,
}

impl Block {
    /// The time in nanoseconds; `None` if it is missing or is not a literal.
    #[must_use]
    pub fn constant_time(&self) -> Option<i64> {
        match &self.time {
            Some(Expr::Literal(Literal::Time(time))) => Some(*time),
            _ => None,
        }
    }
}

/// A step of a chart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// Its name.
    pub name: String,
    /// Whether it is an initial step, active when the chart starts.
    pub initial: bool,
    /// Its action blocks.
    pub blocks: Vec<Block>,
    /// Runs once when the step becomes active, before its other code (CODESYS).
    pub entry: Option<Path>,
    /// Runs while the step is active, without a final run after the step ends (CODESYS).
    pub active: Option<Path>,
    /// Runs once when the step has ended (CODESYS).
    pub exit: Option<Path>,
    /// Whether it is a macro step whose own chart is missing.
    pub is_macro: bool,
    /// Its line, from 1.
    pub line: u32,
    /// The identifier of its element in the source, if it has one.
    pub id: Option<String>,
}

impl Step {
    /// A step without action blocks.
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

/// A transition of a chart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transition {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The preceding steps, as indices into [`Chart::steps`].
    pub from: Vec<usize>,
    /// The following steps, as indices into [`Chart::steps`].
    pub to: Vec<usize>,
    /// The condition under which it fires.
    pub condition: Expr,
    /// The priority that the source states for it; a smaller number comes first.
    pub priority: Option<u32>,
    /// Its line, from 1.
    pub line: u32,
    /// The identifier of its element in the source, if it has one.
    pub id: Option<String>,
}

impl Transition {
    /// Whether the source states a priority for it.
    #[must_use]
    pub fn has_priority(&self) -> bool {
        self.priority.is_some()
    }
}

/// A macro step. The chart contains its steps in place of it, under the names `MACRO.STEP`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Macro {
    /// Its name, with the names of the enclosing macro steps in front.
    pub name: String,
    /// The steps of its chart and of the macro steps nested in it, as indices into [`Chart::steps`].
    pub steps: Vec<usize>,
    /// The line of the macro step in the outer chart.
    pub line: u32,
}

/// A sequential function chart. Transitions that share a preceding step stand in order of priority, the highest first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Chart {
    /// All steps, those of macro steps included.
    pub steps: Vec<Step>,
    /// The transitions.
    pub transitions: Vec<Transition>,
    /// The macro steps, each before those nested in it.
    pub macros: Vec<Macro>,
    /// The line where it begins, from 1.
    pub line: u32,
    /// The first byte and the end of its XML element in the file; `None` if it was written as text.
    pub span: Option<(usize, usize)>,
    /// The steps in the order in which Beremiz and OpenPLC write a drawn chart as text. Empty if it was written as text
    /// or has macro steps, which these tools do not know.
    pub generated: Vec<usize>,
    /// The variables of the unit that the tool declares as this chart's flags `SFCInit` and `SFCReset`, where the
    /// program declares none.
    pub restart_flags: [Option<String>; 2],
    /// What the file's settings say of this chart.
    pub settings: ChartSettings,
}

/// What the settings of CODESYS or TwinCAT in a file say of a chart.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ChartSettings {
    /// Whether the variables `SFCInit` and `SFCReset` certainly control the chart: the chart uses both flags, and the
    /// file shows which variables they are.
    pub flags_control: bool,
    /// Whether the conditions of transitions are evaluated even where their steps are not active. `None`: not known.
    pub evaluates_all: Option<bool>,
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

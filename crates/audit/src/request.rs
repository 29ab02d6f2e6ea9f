//! What an audit is asked, and what it tells while it runs.

use super::response::Given;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Facts;
use scanbound_base::time::Picos;
use scanbound_front::{Fronts, Input, SourceOptions};
use scanbound_fronts::FRONTS;
use scanbound_nets::relays::Relays;
use scanbound_passes::values::Trust;
use scanbound_passes::{PASSES, Passes};
use scanbound_solve::Method;
use scanbound_timing::table::{Override, StatedClock, Table};
use std::time::Duration;

/// What to audit and how.
pub struct Request<'a> {
    /// The project's files.
    pub inputs: &'a [Input],
    /// The arguments that name them, as a shell takes them, for commands that are offered; empty: none is needed.
    pub named: &'a str,
    /// What reads them.
    pub fronts: Fronts,
    /// What is made of the program that was read, before it is priced.
    pub passes: Passes,
    /// The dialect, if not to be found from the content.
    pub dialect: Option<&'a str>,
    /// How source text is read where its language leaves it open.
    pub reading: SourceOptions,
    /// The CPU, if the source does not name it or names it wrongly.
    pub cpu: Option<&'a str>,
    /// The timing table, if not to be found by the CPU.
    pub table: Option<&'a Table>,
    /// Times that the user stated.
    pub times: &'a [Override],
    /// The clock that the user stated, for a machine that runs one word a clock.
    pub clock: Option<&'a StatedClock>,
    /// What the user stated about the plant.
    pub facts: &'a Facts,
    /// Whether routines that are not there, and of which nothing is stated, are let pass as if they took no time. What is
    /// found then is no bound.
    pub incomplete: bool,
    /// Whose writes between scans are reckoned with.
    pub trust: Trust,
    /// Whether what charts say excludes each other is used.
    pub use_chart_exclusion: bool,
    /// The task whose scan is bounded, where the project has several.
    pub task: Option<&'a str>,
    /// Whether that scan is bounded as if no other task interrupted it, whatever is stated.
    pub alone: bool,
    /// Whether it is asked which facts the program keeps, and which it breaks.
    pub proves_facts: bool,
    /// Whether relays are kept apart that scans keep apart, where they are trusted.
    pub relays: bool,
    /// The net that the program is the code of, if it is one's: what it knows of relays is asked of the code.
    pub net: Option<&'a Relays>,
    /// Whether assumed times are refused.
    pub strict_times: bool,
    /// Which search to use.
    pub method: Method,
    /// Whether each search's steps are kept.
    pub trace: bool,
    /// Whether Z3 is asked for a second opinion on each group's maximum.
    pub confirm: bool,
    /// The delays given for a worst response time, if one is asked for.
    pub response: Option<Given>,
    /// How long the search may take; the bound is valid whenever it stops.
    pub time_limit: Option<Duration>,
    /// What was noticed before, told in front of what the audit notices.
    pub warnings: &'a [Diagnostic],
    /// If given, the search may end as soon as it is decided whether a scan takes longer than this.
    pub limit: Option<Picos>,
    /// Asked now and then; true stops the search as the time limit does.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Told how far the audit is.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

impl<'a> Request<'a> {
    /// Whose writes between scans are reckoned with: anybody's, where scans after a download count.
    #[must_use]
    pub fn trusted(&self) -> Trust {
        if self.facts.download { Trust::None } else { self.trust }
    }

    /// Whether others than the program may write what it declares between scans.
    #[must_use]
    pub fn others_write(&self) -> bool {
        self.trusted() != Trust::All || !self.facts.external.is_empty()
    }

    /// All of a project's longest scan, by what its source names, with no limit.
    #[must_use]
    pub fn new(inputs: &'a [Input], facts: &'a Facts) -> Request<'a> {
        Request {
            inputs,
            named: "",
            fronts: FRONTS,
            passes: PASSES,
            dialect: None,
            reading: SourceOptions::default(),
            cpu: None,
            table: None,
            times: &[],
            clock: None,
            facts,
            trust: Trust::default(),
            incomplete: false,
            use_chart_exclusion: true,
            task: None,
            alone: false,
            proves_facts: true,
            relays: true,
            net: None,
            strict_times: false,
            method: Method::Auto,
            trace: false,
            confirm: false,
            response: None,
            time_limit: None,
            warnings: &[],
            limit: None,
            cancelled: &|| false,
            progress: &|_| {},
        }
    }
}

/// How far an audit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// A stage begins.
    Stage(&'static str),
    /// The bounds of the whole scan have come closer.
    Bounds {
        /// No scan takes longer.
        upper: Picos,
        /// Some scan takes as long.
        lower: Picos,
        /// The group at work, as reports number it.
        group: usize,
        /// Groups whose maximum is known.
        solved: usize,
        /// All groups.
        groups: usize,
    },
}

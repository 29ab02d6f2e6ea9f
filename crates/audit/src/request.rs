//! The settings of an audit, and its progress reports.

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
use std::time::{Duration, Instant};

/// What to audit and how.
pub struct Request<'a> {
    /// The project's files.
    pub inputs: &'a [Input],
    /// The command line arguments that name them, quoted for a shell, for commands that a report suggests. Empty if
    /// none is needed.
    pub named: &'a str,
    /// The fronts that read them.
    pub fronts: Fronts,
    /// The passes that process the program before it is priced.
    pub passes: Passes,
    /// The dialect. `None`: it is detected from the content.
    pub dialect: Option<&'a str>,
    /// How source text is read where its language allows several ways.
    pub reading: SourceOptions,
    /// The CPU, if the source does not name it or names it wrongly.
    pub cpu: Option<&'a str>,
    /// The timing table. `None`: it is chosen by the CPU.
    pub table: Option<&'a Table>,
    /// Times that the user stated.
    pub times: &'a [Override],
    /// The clock that the user stated, for a machine that executes one word per clock cycle.
    pub clock: Option<&'a StatedClock>,
    /// The facts that the user stated.
    pub facts: &'a Facts,
    /// Whether calls to routines without code and without stated facts are accepted as if they took no time. The result
    /// is then not a bound.
    pub incomplete: bool,
    /// Which writers between scans are assumed.
    pub trust: Trust,
    /// Whether the mutual exclusion of charts' steps is used.
    pub use_chart_exclusion: bool,
    /// The task whose scan is bounded, if the project has several.
    pub task: Option<&'a str>,
    /// Whether that scan is bounded as if no other task interrupted it, even if interrupts are stated.
    pub alone: bool,
    /// Whether it is checked which facts the program keeps and which it violates.
    pub proves_facts: bool,
    /// Whether mutual exclusion of relays that scans preserve is searched for and used, if relays are trusted.
    pub relays: bool,
    /// The net that the program was generated from, if any: its knowledge about relays is checked on the code.
    pub net: Option<&'a Relays>,
    /// Whether assumed times are refused.
    pub strict_times: bool,
    /// Which search to use.
    pub method: Method,
    /// Whether each search's steps are recorded.
    pub trace: bool,
    /// Whether Z3 is asked for a second opinion on each group's maximum.
    pub confirm: bool,
    /// The delays for a worst-case response time, if one is requested.
    pub response: Option<Given>,
    /// How long the search may take. The bound is valid whenever it stops.
    pub time_limit: Option<Duration>,
    /// Earlier warnings, which are reported before those of the audit.
    pub warnings: &'a [Diagnostic],
    /// If given, the search may end as soon as it is decided whether a scan takes longer than this.
    pub limit: Option<Picos>,
    /// Called now and then. If it returns true, the search stops as at the time limit.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Called with the progress of the audit.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

impl<'a> Request<'a> {
    /// The writers between scans that are assumed: anybody, if scans after a download count.
    #[must_use]
    pub fn trusted(&self) -> Trust {
        if self.facts.download { Trust::None } else { self.trust }
    }

    /// When the time limit is over that begins now.
    #[must_use]
    pub fn deadline(&self) -> Option<Instant> {
        self.time_limit.and_then(|limit| Instant::now().checked_add(limit))
    }

    /// Whether others than the program may write its own variables between scans.
    #[must_use]
    pub fn others_write(&self) -> bool {
        self.trusted() != Trust::All || !self.facts.external.is_empty()
    }

    /// A request for a project's longest scan, with the CPU that the source names and without limits.
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
    /// The bounds of the whole scan have improved.
    Bounds {
        /// No scan takes longer.
        upper: Picos,
        /// Some scan takes this long.
        lower: Picos,
        /// The group being searched, numbered as in reports.
        group: usize,
        /// The number of groups whose maximum is known.
        solved: usize,
        /// The number of all groups.
        groups: usize,
    },
}

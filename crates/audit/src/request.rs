//! The settings of an audit, and its progress reports.

use super::response::Given;
use scanbound_base::budget::Budget;
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
    /// The command line arguments that name the project's files, quoted for a shell. Reports use them to suggest
    /// commands. Empty if none is needed.
    pub named: &'a str,
    /// The fronts that read them.
    pub fronts: Fronts,
    /// The passes that process the program before it is priced.
    pub passes: Passes,
    /// The dialect of the source. `None`: it is detected from the content of the files.
    pub dialect: Option<&'a str>,
    /// How source text is read where its language allows several ways.
    pub reading: SourceOptions,
    /// The CPU, if the source does not name it or names a wrong one.
    pub cpu: Option<&'a str>,
    /// The timing table. `None`: it is chosen by the CPU.
    pub table: Option<&'a Table>,
    /// Times that the user stated.
    pub times: &'a [Override],
    /// The clock that the user stated, for a PLC that executes one program word per clock period.
    pub clock: Option<&'a StatedClock>,
    /// The facts that the user stated.
    pub facts: &'a Facts,
    /// Whether calls to routines without code and without stated facts are accepted as if they took no time. The result
    /// is then not a bound.
    pub incomplete: bool,
    /// Which writers are assumed to write between scans.
    pub trust: Trust,
    /// Whether the mutual exclusion of charts' steps is used.
    pub use_chart_exclusion: bool,
    /// The task whose scan is bounded, if the project has several.
    pub task: Option<&'a str>,
    /// Whether the task's scan is bounded as if no other task interrupted it, even if interrupts are stated.
    pub alone: bool,
    /// Whether it is checked which facts the program keeps and which it violates.
    pub proves_facts: bool,
    /// Whether the audit searches for mutually exclusive relays, and uses those that scans preserve, if relays are
    /// trusted.
    pub relays: bool,
    /// The net from which the program was generated. What the net states about relays is checked on the code. `None` if
    /// there is no net.
    pub net: Option<&'a Relays>,
    /// Whether the audit ends with an error if it needs an assumed time.
    pub strict_times: bool,
    /// Which search to use.
    pub method: Method,
    /// Whether the steps of each search are recorded.
    pub trace: bool,
    /// Whether Z3 is asked for a second opinion on each group's maximum.
    pub confirm: bool,
    /// The delays for a worst-case response time, if one is requested.
    pub response: Option<Given>,
    /// The longest time that the search may take. The bound is valid whenever the search stops.
    pub time_limit: Option<Duration>,
    /// Earlier warnings, which are reported before those of the audit.
    pub warnings: &'a [Diagnostic],
    /// If given, the search may end as soon as it is decided whether a scan takes longer than this time.
    pub limit: Option<Picos>,
    /// Called regularly. If it returns true, the search stops as at the time limit.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Called with the progress of the audit.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

impl<'a> Request<'a> {
    /// The writers between scans that are assumed: any, if the bound must cover scans after a download.
    #[must_use]
    pub fn trusted(&self) -> Trust {
        if self.facts.download { Trust::None } else { self.trust }
    }

    /// A time budget that begins now.
    #[must_use]
    pub fn budget(&self) -> Budget<'a> {
        Budget::new(Instant::now(), self.time_limit, self.cancelled, Vec::new())
    }

    /// Whether other writers than the program may write its variables between scans.
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

/// A progress report of an audit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// A stage begins.
    Stage(&'static str),
    /// The bounds of the whole scan have improved.
    Bounds {
        /// The upper bound of the whole scan.
        upper: Picos,
        /// The lower bound of the whole scan: some scan takes this long.
        lower: Picos,
        /// The group being searched, numbered as in reports.
        group: usize,
        /// The number of groups whose maximum is known.
        solved: usize,
        /// The number of all groups.
        groups: usize,
    },
}

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

/// The project to audit, and the settings of the audit.
pub struct Request<'a> {
    /// The project's files, each with its name and its bytes: programs, and tables of device comments.
    pub inputs: &'a [Input],
    /// The command line arguments that name the project's files, quoted for a shell. Reports use them to suggest
    /// commands. Empty if none is needed.
    pub named: &'a str,
    /// The fronts that may read the files: each is the reader of one dialect or more.
    pub fronts: Fronts,
    /// The passes that process the program before it is priced.
    pub passes: Passes,
    /// The dialect of the source. `None`: it is detected from the content of the files.
    pub dialect: Option<&'a str>,
    /// How source text is read where its language allows several ways.
    pub reading: SourceOptions,
    /// The name of the CPU. It replaces the one that the source names. `None`: the CPU is the one that the source
    /// names.
    pub cpu: Option<&'a str>,
    /// The timing table. `None`: the built-in table for the CPU.
    pub table: Option<&'a Table>,
    /// The times of instructions that the user stated on the command line. Each replaces the row of its name in the
    /// table.
    pub times: &'a [Override],
    /// The clock that the user stated, for a PLC that executes one program word per clock period. It is an error for
    /// other PLCs. `None` if not stated.
    pub clock: Option<&'a StatedClock>,
    /// What the user states because the source does not say it, such as ranges of words.
    pub facts: &'a Facts,
    /// Whether calls to routines without code and without stated facts are accepted as if they took no time. The result
    /// is then not a bound.
    pub incomplete: bool,
    /// Which words other writers than the program are assumed to write between scans. [`Request::trusted`] is what the
    /// audit uses.
    pub trust: Trust,
    /// Whether the bound may rest on the fact that steps of a chart (SFC) are mutually exclusive.
    pub use_chart_exclusion: bool,
    /// The name of the task whose scan is bounded, if the project has several. `None`: the first task.
    pub task: Option<&'a str>,
    /// Whether the task's scan is bounded as if no other task interrupted it, even if interrupts are stated.
    pub alone: bool,
    /// Whether the audit checks which stated ranges and exclusive sets the program itself keeps from scan to scan, and
    /// which it violates.
    pub proves_facts: bool,
    /// Whether the audit searches for sets of mutually exclusive relays, and uses the sets that it proves. It does so
    /// only if relays are trusted.
    pub relays: bool,
    /// The net from which the program was generated. What the net states about relays is checked on the code. `None` if
    /// there is no net.
    pub net: Option<&'a Relays>,
    /// Whether the audit ends with an error if it needs an assumed time (`--strict-times`).
    pub strict_times: bool,
    /// Which search finds the maximum of each group.
    pub method: Method,
    /// Whether the steps of each search are recorded for the report.
    pub trace: bool,
    /// Whether Z3 is asked for a second opinion on each group's maximum. If it contradicts one, the audit ends with an
    /// error.
    pub confirm: bool,
    /// The delays for a worst-case response time, if one is requested.
    pub response: Option<Given>,
    /// The longest time that the whole audit may take. `None`: no limit. The bound is valid whenever the search stops,
    /// but it may be higher than with more time.
    pub time_limit: Option<Duration>,
    /// Earlier warnings, which are reported before those of the audit.
    pub warnings: &'a [Diagnostic],
    /// If given, the search may end as soon as it is decided whether a scan takes longer than this time. The bounds are
    /// then less close. `None`: no such limit.
    pub limit: Option<Picos>,
    /// Called regularly. If it returns true, the search stops as at the time limit.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Called with the progress of the audit.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

impl<'a> Request<'a> {
    /// [`Request::trust`]; but [`Trust::None`] (others may write any word between scans) if the facts say that the
    /// bound must also cover scans after a download.
    #[must_use]
    pub fn trusted(&self) -> Trust {
        if self.facts.download { Trust::None } else { self.trust }
    }

    /// A time budget that begins now, with the request's time limit and cancellation.
    #[must_use]
    pub fn budget(&self) -> Budget<'a> {
        Budget::new(Instant::now(), self.time_limit, self.cancelled, Vec::new())
    }

    /// Whether other writers than the program may write its variables between scans. False only if the trust is
    /// [`Trust::All`] and the facts name no device that others write.
    #[must_use]
    pub fn others_write(&self) -> bool {
        self.trusted() != Trust::All || !self.facts.external.is_empty()
    }

    /// A request with the default settings: all fronts and passes, the CPU that the source names and its built-in
    /// table, no net, no time limit and no limit to decide.
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
    /// A stage begins. The text is its name for the display.
    Stage(&'static str),
    /// The search has reported bounds of one group. These are the bounds of the whole scan that follow.
    Bounds {
        /// The upper bound of the whole scan.
        upper: Picos,
        /// The time of the longest scan of the model that was found so far. It may need values that are not known to be
        /// possible.
        lower: Picos,
        /// The group whose bounds were reported, numbered from 1 as in reports.
        group: usize,
        /// The number of groups whose maximum is known.
        solved: usize,
        /// The number of all groups.
        groups: usize,
    },
}

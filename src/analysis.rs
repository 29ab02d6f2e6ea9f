//! A bound in a few lines of Rust: files in, a report out.

use crate::audit::verdict::{Check, Margin, Verdict};
use crate::audit::{self, Audit, Request};
use crate::base::diagnostic::Diagnostic;
use crate::base::facts::Facts;
use crate::base::time::Picos;
use crate::front::{FRONTS, Fronts, Input};
use crate::passes::values::Trust;
use crate::report::FORMATS;
use crate::report::format::{Detail, Extent};
use crate::timing::table::{Table, parse_override};
use std::fmt;
use std::time::Duration;

/// One project whose longest scan is asked for.
///
/// # Examples
///
/// ```
/// let program = "LD X0\nMOV K1 D0\nLDI X0\nMOV K2 D1\nEND\n";
/// let analysis = scanbound::Analysis::new().file("main.il", program).cpu("Q26UDV");
/// let report = analysis.time("MOV=1.5us/0.3us").run()?;
/// // The two moves are mutually exclusive, so the bound is below the sum of all instructions.
/// assert!(report.is_exact() && report.upper() < report.audit().bound.naive);
/// # Ok::<(), scanbound::Error>(())
/// ```
#[derive(Clone)]
#[must_use]
pub struct Analysis {
    inputs: Vec<Input>,
    fronts: Fronts,
    dialect: Option<String>,
    cpu: Option<String>,
    /// Name and content.
    table: Option<(String, Vec<u8>)>,
    times: Vec<String>,
    facts: Option<(String, String)>,
    trust: Trust,
    task: Option<String>,
    time_limit: Option<Duration>,
}

impl Default for Analysis {
    fn default() -> Self {
        Analysis::new()
    }
}

impl Analysis {
    /// An analysis without files. Without further calls, the CPU, the dialect and the timing table are found from the
    /// files.
    pub fn new() -> Analysis {
        Analysis {
            inputs: Vec::new(),
            fronts: FRONTS,
            dialect: None,
            cpu: None,
            table: None,
            times: Vec::new(),
            facts: None,
            trust: Trust::default(),
            task: None,
            time_limit: None,
        }
    }

    /// Adds a file: a program, or device comments. All files are one project, and programs run in the order in which
    /// they are added.
    pub fn file(mut self, name: impl Into<String>, content: impl Into<Vec<u8>>) -> Analysis {
        self.inputs.push(Input { name: name.into(), bytes: content.into() });
        self
    }

    /// Adds several files.
    pub fn files<N: Into<String>, C: Into<Vec<u8>>>(
        self,
        files: impl IntoIterator<Item = (N, C)>,
    ) -> Analysis {
        files.into_iter().fold(self, |analysis, (name, content)| analysis.file(name, content))
    }

    /// Reads programs with these fronts in place of the built-in ones.
    pub fn fronts(mut self, fronts: Fronts) -> Analysis {
        self.fronts = fronts;
        self
    }

    /// Names the dialect of the programs (`--dialect`).
    pub fn dialect(mut self, name: impl Into<String>) -> Analysis {
        self.dialect = Some(name.into());
        self
    }

    /// Names the CPU (`--cpu`).
    pub fn cpu(mut self, name: impl Into<String>) -> Analysis {
        self.cpu = Some(name.into());
        self
    }

    /// Takes the times from this CSV (`docs/timing-tables.md`) instead of a built-in table. Messages name it by `name`.
    pub fn table(mut self, name: impl Into<String>, csv: impl Into<Vec<u8>>) -> Analysis {
        self.table = Some((name.into(), csv.into()));
        self
    }

    /// States the time of one instruction, such as `MOV=1.5us/0.3us` (`--time`).
    pub fn time(mut self, time: impl Into<String>) -> Analysis {
        self.times.push(time.into());
        self
    }

    /// States facts as TOML (`--facts`). Messages name the text by `name`.
    pub fn facts(mut self, name: impl Into<String>, toml: impl Into<String>) -> Analysis {
        self.facts = Some((name.into(), toml.into()));
        self
    }

    /// Sets which writers between scans the bound assumes (`--trust`).
    pub fn trust(mut self, trust: Trust) -> Analysis {
        self.trust = trust;
        self
    }

    /// Names the task whose scan is bounded, if the project has several.
    pub fn task(mut self, name: impl Into<String>) -> Analysis {
        self.task = Some(name.into());
        self
    }

    /// Ends the search after this time. The bound is valid whenever the search ends.
    pub fn time_limit(mut self, limit: Duration) -> Analysis {
        self.time_limit = Some(limit);
        self
    }

    /// Computes the bound.
    ///
    /// # Errors
    /// [`Error::Input`] with all faults of the files, the facts, the table and the stated times; [`Error::Internal`] if
    /// the analysis and the interpreter disagree, which is a fault of scanbound.
    pub fn run(&self) -> Result<Report, Error> {
        let facts = match &self.facts {
            Some((name, toml)) => Facts::parse(name, toml).map_err(Error::Input)?,
            None => Facts::default(),
        };
        let table = match &self.table {
            Some((name, csv)) => Some(Table::parse(name, csv).map_err(Error::Input)?.table),
            None => None,
        };
        let times: Result<Vec<_>, _> = self.times.iter().map(|time| parse_override(time)).collect();
        let times = times.map_err(Error::Argument)?;
        let request = Request {
            fronts: self.fronts,
            dialect: self.dialect.as_deref(),
            cpu: self.cpu.as_deref(),
            table: table.as_ref(),
            times: &times,
            trust: self.trust,
            task: self.task.as_deref(),
            time_limit: self.time_limit,
            ..Request::new(&self.inputs, &facts)
        };
        match audit::audit(&request) {
            Ok(audit) => Ok(Report { audit }),
            Err(audit::Failure::Input(faults)) => Err(Error::Input(faults)),
            Err(audit::Failure::Internal(what)) => Err(Error::Internal(what)),
        }
    }
}

/// What is known about the longest scan.
#[derive(Debug, Clone)]
pub struct Report {
    audit: Audit,
}

impl Report {
    /// No scan takes longer, unless something that the report lists as not stated adds time ([`Report::check`] takes
    /// that into account).
    #[must_use]
    pub fn upper(&self) -> Picos {
        self.audit.bound.upper
    }

    /// A scan that takes this long was found, and nothing known excludes it.
    #[must_use]
    pub fn lower(&self) -> Picos {
        self.audit.bound.lower
    }

    /// Whether both are equal.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.audit.bound.exact()
    }

    /// Whether every scan stays within a limit: proved, refuted, or undecided with the reasons.
    #[must_use]
    pub fn check(&self, limit: Picos) -> Verdict {
        Check::new(&self.audit, limit, Margin::default()).verdict
    }

    /// The report in a format of `--format` (`text`, `json`, `csv`, `html`, ...); `None` if there is no such format.
    #[must_use]
    pub fn render(&self, format: &str) -> Option<String> {
        let format = FORMATS.iter().find(|one| one.name == format)?;
        let mut bytes = Vec::new();
        // Writing to memory cannot fail.
        (format.audit)(
            &self.audit,
            None,
            Extent { detail: Detail::Full, ..Extent::default() },
            &mut bytes,
        )
        .ok()?;
        String::from_utf8(bytes).ok()
    }

    /// The complete result, as the formats show it. Its fields may change with each version.
    #[must_use]
    pub fn audit(&self) -> &Audit {
        &self.audit
    }
}

/// Why there is no report.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// The files, the facts or the table have faults.
    Input(Vec<Diagnostic>),
    /// A stated time is not of the form `NAME=TIME`.
    Argument(String),
    /// The analysis and the interpreter disagree: a fault of scanbound.
    Internal(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Input(faults) => {
                let lines: Vec<String> = faults.iter().map(Diagnostic::brief).collect();
                f.write_str(&lines.join("\n"))
            }
            Error::Argument(what) => f.write_str(what),
            Error::Internal(what) => write!(f, "internal error: {what}"),
        }
    }
}

impl std::error::Error for Error {}

//! Writes results that are lists: as text, JSON or CSV.

use super::Failure;
use super::output::{self, Target, apart, say};
use super::progress;
use super::values::format_or_suffix;
use clap::{Args, ValueEnum};
use scanbound::report::format::{Detail, Extent};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The format and target of a list.
#[derive(Debug, Args)]
#[command(next_help_heading = "Report")]
pub struct SheetOptions {
    /// The report's format [default: by the suffix of --output, otherwise text]
    #[arg(long, value_enum)]
    format: Option<SheetFormat>,
    /// Write the report to a file, which appears only when it is complete
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Show every entry
    #[arg(short, long)]
    verbose: bool,
    /// Show only errors: the report goes only to a file (--output), and the exit code is the answer
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
}

/// A form of lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SheetFormat {
    /// For people
    #[value(alias = "txt")]
    Text,
    /// For programs (docs/json.md)
    Json,
    /// For spreadsheets
    Csv,
}

/// A list in each format, and its answer in one sentence.
pub struct Sheet<'a> {
    /// The text; has colour codes.
    pub text: &'a dyn Fn(Extent) -> String,
    /// Writes it as JSON.
    pub json: &'a dyn Fn(&mut dyn Write) -> io::Result<()>,
    /// Writes it as CSV.
    pub csv: &'a dyn Fn(&mut dyn Write) -> io::Result<()>,
    /// The text for stderr if the list goes to a file.
    pub answer: String,
}

/// The target and format of a list.
pub struct Place {
    /// `None` if nothing is to be shown.
    target: Option<Target>,
    quiet: bool,
    form: SheetFormat,
    extent: Extent,
}

impl SheetOptions {
    /// The target, which must not be one of the files that are read.
    pub fn place(&self, reads: &[&Path]) -> Result<Place, Failure> {
        apart(reads, &[("--output", self.output.as_deref())])?;
        if self.quiet {
            progress::hide();
        }
        let form = format_or_suffix(self.format, self.output.as_deref())?;
        let target = match (&self.output, self.quiet) {
            (None, true) => None,
            (file, _) => Some(Target::new(file.as_deref())?),
        };
        let usual = Extent::default();
        let page = target.as_ref().and_then(Target::page);
        let (width, height) = page.unwrap_or((usual.width, usual.height));
        let detail = if self.verbose { Detail::Full } else { Detail::Usual };
        let quiet = self.quiet;
        Ok(Place { target, quiet, form, extent: Extent { width, height, detail, ..usual } })
    }
}

impl Place {
    /// Writes the list. If it does not go to stdout, the answer goes to stderr.
    pub fn write(self, sheet: &Sheet<'_>) -> Result<(), Failure> {
        let Place { target, quiet, form, extent } = self;
        let Some(target) = target else { return Ok(()) };
        let is_shown = quiet || matches!(target, Target::Stdout);
        target.fill(|out| match form {
            SheetFormat::Text => out.write_all((sheet.text)(extent).as_bytes()),
            SheetFormat::Json => (sheet.json)(out),
            SheetFormat::Csv => (sheet.csv)(out),
        })?;
        if !is_shown {
            let lines = scanbound::report::wrapped(&sheet.answer, output::width_of_stderr());
            say(&lines);
        }
        Ok(())
    }
}

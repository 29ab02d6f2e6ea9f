//! The options that `audit` and `check` have in common, and the audit that they request.

use super::documents::{Document, Documents};
use super::output::{self, Target, say};
use super::project_file::{self, ProjectFile};
use super::source_text::SourceText;
use super::values::Most;
use super::{Failure, progress, tables, values};
use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum, ValueHint};
use scanbound::audit::breakdown::By;
use scanbound::audit::intervals;
use scanbound::audit::ladder::Ladder;
use scanbound::audit::verdict::Check;
use scanbound::audit::{Audit, Concluded, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::diagnostic::Diagnostic;
use scanbound::base::facts::{Facts, InterruptRate};
use scanbound::front::input::{Gathered, Ignore, gather, read_small, survey};
use scanbound::front::{FRONTS, Input};
use scanbound::passes::PASSES;
use scanbound::passes::values::Trust;
use scanbound::report::format::{Detail, Extent, Format, Project};
use scanbound::report::method;
use scanbound::report::{FORMATS, formats, text};
use scanbound::solve::Method;
use scanbound::timing::table::{Override, StatedClock, Table, parse_override};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// The project and how it is audited.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Project")]
pub struct ProjectOptions {
    /// Program files of one project, in the order of execution; a directory stands for the programs in it, - for stdin
    /// [default: those of scanbound.toml, which is read only if no program is named, docs/pipelines.md]
    #[arg(value_name = "PROGRAM")]
    programs: Vec<PathBuf>,
    /// Whether a project file named them.
    #[arg(skip)]
    from_file: bool,
    /// Leave out files of these names or paths (*, ?, [a-z], {a,b}, ** for directories); may be repeated
    #[arg(long, value_name = "PATTERN")]
    ignore: Vec<String>,
    /// Timing table: a built-in one (see `scanbound tables`) or a CSV file [default: by the program's CPU]
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    table: Option<String>,
    /// The CPU, if the program does not name it
    #[arg(long, value_name = "NAME")]
    cpu: Option<String>,
    /// The dialect [default: found from the content]
    #[arg(long, value_name = "NAME", value_parser = values::dialect())]
    dialect: Option<String>,
    #[command(flatten)]
    source_text: SourceText,
    /// Facts that the program does not contain: ranges of words, interrupts, I/O points and bases, networks (TOML)
    #[arg(long, value_name = "FILE")]
    facts: Option<PathBuf>,
    /// How often an interrupt routine runs: at most this many times in one scan (I0=2), or once in each interval
    /// (I28=4ms); may be repeated
    #[arg(long, value_name = "LABEL=COUNT|INTERVAL", value_parser = interrupt)]
    interrupts: Vec<(String, InterruptRate)>,
    /// The task whose scan is bounded, if an IEC 61131-3 project has several [default: the one with the lowest
    /// priority]
    #[arg(long, value_name = "NAME")]
    task: Option<String>,
    /// The time of an instruction if it runs, and if it does not; may be repeated
    #[arg(long, value_name = "NAME=ON[/OFF]", value_parser = parse_override)]
    time: Vec<Override>,
    /// The clock of a MINASEC-U: a frequency (30.3kHz), the period of a word (33us), fast or slow
    #[arg(long, value_name = "CLOCK")]
    clock: Option<StatedClock>,
    /// Which writers between two scans are assumed: none = any device may hold anything when a scan starts; counts =
    /// words used as counts, lengths or indices are written only by this program; all = every device that this program
    /// writes is written only by it
    #[arg(long, value_enum, default_value = "counts")]
    trust: TrustName,
    /// Refuse times that the table only assumes
    #[arg(long)]
    strict_times: bool,
    /// The time after which the audit ends, in any stage, with what is proved by then
    #[arg(long, value_name = "DURATION", default_value = "60s", value_parser = values::span, allow_hyphen_values = true)]
    time_limit: Duration,
    /// The number of threads [default: one per processor]
    #[arg(long, value_name = "N", value_parser = values::positive::<u16>, allow_negative_numbers = true)]
    jobs: Option<u16>,
    /// How the maximum of a group is searched for
    #[arg(long, value_enum, default_value = "auto")]
    method: MethodName,
}

/// How the search is followed and checked.
#[derive(Debug, Args)]
#[command(next_help_heading = "Search")]
pub struct SearchOptions {
    /// Show every condition, query and answer of the search (docs/method.md): on stderr, or in full in a file
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    trace_search: Option<Option<PathBuf>>,
    /// Ask Z3 independently whether any group can take a picosecond more; the report shows which groups it confirms
    #[arg(long)]
    confirm: bool,
}

/// Additional bounds that are computed.
#[derive(Debug, Args)]
#[command(next_help_heading = "Search")]
pub struct WhatIfOptions {
    /// Compute the bound again with limits on the unknown counts, one after the other, and without the trust in each
    /// word; each may use the whole time limit [default: 20,100]
    #[arg(long, value_name = "COUNTS", num_args = 0..=1, require_equals = true, default_missing_value = "20,100", value_parser = values::most)]
    what_if: Option<Most>,
}

impl WhatIfOptions {
    /// The limits for unknown counts, if requested.
    pub fn most(&self) -> Option<&[u32]> {
        self.what_if.as_ref().map(|Most(most)| most.as_slice())
    }
}

/// Where a trace goes, if requested.
pub enum TraceTarget {
    /// Nowhere.
    None,
    /// To stderr, in short.
    Stderr,
    /// To a file, in full.
    File(Target),
}

impl SearchOptions {
    /// The request, extended by these options.
    pub fn of<'a>(&self, request: &Request<'a>) -> Request<'a> {
        Request { trace: self.trace_search.is_some(), confirm: self.confirm, ..*request }
    }

    /// Where the trace goes.
    fn target(&self) -> Result<TraceTarget, Failure> {
        Ok(match &self.trace_search {
            None => TraceTarget::None,
            Some(None) => TraceTarget::Stderr,
            Some(Some(file)) => TraceTarget::File(Target::new(Some(file))?),
        })
    }
}

impl TraceTarget {
    /// Writes the trace.
    pub fn write(self, audit: &Audit) -> Result<(), Failure> {
        match self {
            TraceTarget::None => Ok(()),
            TraceTarget::Stderr => {
                say(&method::trace(audit, method::TERMINAL));
                Ok(())
            }
            TraceTarget::File(target) => target.write(&method::trace(audit, method::FILE)),
        }
    }
}

/// The report's format and target.
#[derive(Debug, Args)]
#[command(next_help_heading = "Report")]
pub struct ReportOptions {
    /// The report's format [default: by the suffix of --output, otherwise text]. If several files have suffixes of
    /// other formats, this format is written to stdout
    #[arg(long, value_name = "FORMAT", value_parser = values::format())]
    format: Option<String>,
    /// Write the report to a file, which appears only when it is complete; may be repeated, each file's suffix names
    /// its format
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// How many groups, and rungs of each, the text shows
    #[arg(long, value_name = "N", default_value_t = Extent::default().top, value_parser = values::count::<usize>, allow_negative_numbers = true)]
    top: usize,
    /// Divide the bound by programs, routines, rungs or instructions: parts that add up to it
    #[arg(long, value_enum, value_name = "WHAT")]
    by: Option<ByName>,
    /// Show more: for a check everything that audit shows, for an audit every entry
    #[arg(short, long)]
    verbose: bool,
    /// Show only errors: reports go only to files (--output), and the exit code is the answer
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum ByName {
    /// Files
    Program,
    /// Called routines, and the rest of each file
    Routine,
    /// Rungs, the longest time first
    Rung,
    /// Instruction names
    Instruction,
}

impl From<ByName> for By {
    fn from(name: ByName) -> By {
        match name {
            ByName::Program => By::Program,
            ByName::Routine => By::Routine,
            ByName::Rung => By::Rung,
            ByName::Instruction => By::Instruction,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum TrustName {
    /// Any device may hold anything when a scan starts
    None,
    /// Only this program writes words that are used as counts, lengths or indices
    Counts,
    /// Only this program writes the devices that it writes
    All,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum MethodName {
    /// By subsets if the group is small, otherwise by cores
    Auto,
    /// The paper's search: ask Z3 which rungs can run together, and exclude conflicts
    Subsets,
    /// Guided by unsatisfiable cores, on BatSat
    Cores,
}

fn interrupt(text: &str) -> Result<(String, InterruptRate), String> {
    let form = || {
        "give the routine's label and a count or an interval, such as I0=2 or I28=4ms".to_owned()
    };
    let (label, count) = text.split_once('=').ok_or_else(form)?;
    let count = count.trim().parse().map_err(|()| form())?;
    Ok((label.trim().to_owned(), count))
}

impl ProjectOptions {
    /// These options, completed by the project file here if no program is named.
    pub fn or_here(&self) -> Result<ProjectOptions, Failure> {
        match self.programs.is_empty() {
            true => Ok(self.completed(&ProjectFile::here()?)),
            false => Ok(self.clone()),
        }
    }

    /// The same for a command that begins a facts file: the one that the project file names need not exist yet.
    pub fn or_here_without_facts(&self) -> Result<ProjectOptions, Failure> {
        let mut project = self.or_here()?;
        if self.facts.is_none() {
            project.facts = project.facts.filter(|file| file.exists());
        }
        Ok(project)
    }

    /// The named table, or the CPU.
    pub fn table_or_cpu(&self) -> Option<&str> {
        self.table.as_deref().or(self.cpu.as_deref())
    }

    /// The named table, and the CPU.
    pub fn table_and_cpu(&self) -> (Option<&str>, Option<&str>) {
        (self.table.as_deref(), self.cpu.as_deref())
    }

    /// Whether no program is named.
    pub fn is_open(&self) -> bool {
        self.programs.is_empty()
    }

    /// These options, completed by a project file.
    pub fn completed(&self, file: &ProjectFile) -> ProjectOptions {
        let own = self.clone();
        ProjectOptions {
            programs: file.programs.clone(),
            from_file: true,
            ignore: [own.ignore, file.ignore.clone()].concat(),
            table: own.table.or_else(|| file.table.clone()),
            cpu: own.cpu.or_else(|| file.cpu.clone()),
            dialect: own.dialect.or_else(|| file.dialect.clone()),
            facts: own.facts.or_else(|| file.facts.clone()),
            ..own
        }
    }

    /// These options without the last of the files, and that file; `None` if there is no other.
    pub fn split_last(&self) -> Option<(ProjectOptions, PathBuf)> {
        let mut rest = self.clone();
        let last = rest.programs.pop()?;
        (!rest.programs.is_empty()).then_some((rest, last))
    }

    /// These options with each of two programs separately. `None` if there are not two.
    pub fn two(&self) -> Option<(ProjectOptions, ProjectOptions)> {
        let [old, new] = self.programs.as_slice() else { return None };
        let with = |one: &PathBuf| ProjectOptions { programs: vec![one.clone()], ..self.clone() };
        Some((with(old), with(new)))
    }

    /// The arguments that name the project and its CPU, quoted for a shell. Of many programs, only the first.
    fn named(&self) -> String {
        if self.from_file {
            return String::new();
        }
        let programs = self.programs.iter().map(|path| path.display().to_string());
        let mut words: Vec<String> = programs.take(MAX_NAMED).map(|path| quoted(&path)).collect();
        if self.programs.len() > MAX_NAMED {
            words.push("...".to_owned());
        }
        let options =
            [("--cpu", &self.cpu), ("--dialect", &self.dialect), ("--table", &self.table)];
        for (option, value) in options {
            words.extend(value.iter().map(|value| format!("{option} {}", quoted(value))));
        }
        let facts = self.facts.iter().map(|file| quoted(&file.display().to_string()));
        words.extend(facts.map(|file| format!("--facts {file}")));
        words.extend(self.source_text.written());
        words.join(" ")
    }

    /// The files that are read.
    pub fn reads(&self) -> Vec<&Path> {
        let table = self.table.as_deref().map(Path::new);
        self.programs
            .iter()
            .map(PathBuf::as_path)
            .chain(table)
            .chain(self.facts.as_deref())
            .collect()
    }

    /// The files that are read, and the project file if no program is named.
    pub fn watched(&self) -> Vec<PathBuf> {
        let own =
            |project: &ProjectOptions| project.reads().into_iter().map(Path::to_owned).collect();
        if !self.is_open() {
            return own(self);
        }
        // The user is going to correct a project file that cannot be read.
        let files: Vec<PathBuf> = self.or_here().as_ref().map(own).unwrap_or_default();
        files.into_iter().chain([PathBuf::from(project_file::NAME)]).collect()
    }

    /// Reads the files and audits them.
    pub fn audit(&self, search: &SearchOptions) -> Result<Audit, Failure> {
        if search.confirm && !scanbound::solve::HAS_Z3 {
            let help = "--confirm needs Z3, and this scanbound was built without it: build it with the feature z3";
            return Err(anyhow!(help).into());
        }
        self.with_request(|request| Ok(audit(&search.of(request))?))
    }

    /// Reads the files and calls a function with the request, on the requested number of threads.
    pub fn with_request<T: Send>(
        &self,
        work: impl FnOnce(&Request<'_>) -> Result<T, Failure> + Send,
    ) -> Result<T, Failure> {
        let facts = facts(self.facts.as_deref())?;
        let table = self.table.as_deref().map(|name| tables::find("--table ", name)).transpose()?;
        let mut gathered = gather(&self.programs, &self.ignored()?)?;
        let table = table.map(|parsed| {
            gathered.warnings.extend(parsed.warnings);
            parsed.table
        });
        self.asked(facts, table, gathered, work)
    }

    /// Calls a function with a request for code that is not in a file.
    pub fn with_code<T: Send>(
        &self,
        code: Input,
        cpu: Option<&str>,
        work: impl FnOnce(&Request<'_>) -> Result<T, Failure> + Send,
    ) -> Result<T, Failure> {
        let mut own = self.clone();
        if own.table.is_none() {
            own.cpu = own.cpu.or_else(|| cpu.map(str::to_owned));
        }
        let facts = facts(own.facts.as_deref())?;
        let table = own.table.as_deref().map(|name| tables::find("--table ", name)).transpose()?;
        let mut gathered = Gathered { inputs: vec![code], warnings: Vec::new() };
        let table = table.map(|parsed| {
            gathered.warnings.extend(parsed.warnings);
            parsed.table
        });
        own.asked(facts, table, gathered, work)
    }

    /// The same with everything that can be read, and with all faults and warnings.
    pub fn with_what_can_be_read<T: Send>(
        &self,
        work: impl FnOnce(&Request<'_>, Vec<Diagnostic>) -> Result<T, Failure> + Send,
    ) -> Result<T, Failure> {
        let mut found = Vec::new();
        let facts = readable(facts(self.facts.as_deref()), &mut found)?.unwrap_or_default();
        let table = self.table.as_deref().map(|name| tables::find("--table ", name));
        let table = table.map(|table| readable(table, &mut found)).transpose()?.flatten();
        let table = table.map(|parsed| {
            found.extend(parsed.warnings);
            parsed.table
        });
        let Gathered { inputs, warnings } = survey(&self.programs, &self.ignored()?);
        found.extend(warnings);
        let gathered = Gathered { inputs, warnings: Vec::new() };
        self.asked(facts, table, gathered, |request| work(request, found))
    }

    fn ignored(&self) -> Result<Ignore, Failure> {
        let patterns = self.ignore.iter().map(String::as_str);
        Ignore::parse(patterns).map_err(|error| anyhow!("--ignore {error}").into())
    }

    /// Calls a function with the request for what was read.
    fn asked<T: Send>(
        &self,
        mut facts: Facts,
        table: Option<Table>,
        mut gathered: Gathered,
        work: impl FnOnce(&Request<'_>) -> Result<T, Failure> + Send,
    ) -> Result<T, Failure> {
        let stop = stop_on_interrupt()?;
        for (label, count) in &self.interrupts {
            facts.state_interrupt(label, *count);
        }
        let line = progress::Line::new();
        let named = self.named();
        self.source_text.recode(&mut gathered.inputs);
        let request = Request {
            inputs: &gathered.inputs,
            named: &named,
            fronts: FRONTS,
            passes: PASSES,
            dialect: self.dialect.as_deref(),
            reading: self.source_text.reading(),
            cpu: self.cpu.as_deref(),
            table: table.as_ref(),
            times: &self.time,
            clock: self.clock.as_ref(),
            facts: &facts,
            use_chart_exclusion: true,
            task: self.task.as_deref(),
            alone: false,
            proves_facts: true,
            relays: true,
            net: None,
            incomplete: false,
            trust: match self.trust {
                TrustName::None => Trust::None,
                TrustName::Counts => Trust::Counts,
                TrustName::All => Trust::All,
            },
            strict_times: self.strict_times,
            method: match self.method {
                MethodName::Auto => Method::Auto,
                MethodName::Subsets => Method::Subsets,
                MethodName::Cores => Method::Cores,
            },
            trace: false,
            confirm: false,
            response: None,
            time_limit: Some(self.time_limit),
            limit: None,
            cancelled: &|| stop.load(Ordering::Relaxed),
            warnings: &gathered.warnings,
            progress: &|progress| line.show(progress),
        };
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(self.jobs.map_or(0, usize::from))
            .stack_size(STACK)
            .build()
            .context("the threads cannot be started")?;
        threads.install(|| {
            if request.facts.intervals.is_empty() {
                return work(&request);
            }
            let counted = intervals::counted(&request)?;
            work(&Request { facts: &counted, ..request })
        })
    }
}

/// Bytes of a thread's stack: nesting in programs is followed recursively, up to its limits.
const STACK: usize = 64 << 20;

/// Where reports go, and the format of each.
pub struct Reports(Vec<(Target, &'static Format)>);

impl Reports {
    /// Draws the project's rungs, if one of the reports shows them.
    pub fn draw(&self, concluded: &mut Concluded) {
        if self.0.iter().any(|(_, format)| format.draws) {
            concluded.audit.ladder = Some(Ladder::of(concluded));
        }
    }

    /// Reports why a project was not audited, in the formats that can, and returns the failure.
    pub fn refused(self, project: &ProjectOptions, failure: Failure) -> Result<Failure, Failure> {
        let file = project.programs.first().map_or(String::new(), |one| one.display().to_string());
        for (target, format) in self.0.into_iter().filter(|(_, format)| format.tells_faults) {
            let mut document = Document::begin(format, Extent::default(), target)?;
            let (file, exit_code) = (file.as_str(), failure.code());
            document.add(&Project { file, exit_code, checked: failure.checked() })?;
            document.end()?;
        }
        Ok(failure)
    }
}

impl ReportOptions {
    /// The format requested by name.
    fn named(&self) -> Option<&'static Format> {
        self.format.as_deref().and_then(|name| formats::named(FORMATS, name))
    }

    /// The target and format of each report. A single report has the format requested by name, otherwise that of its
    /// file's suffix. Of several, each has the format of its suffix, and stdout gets the one requested by name if no
    /// file has it.
    fn reports(&self) -> Result<Vec<(Option<&Path>, &'static Format)>, Failure> {
        let named = self.named();
        let called = |file| named.map_or_else(|| format_of(file), Ok);
        Ok(match self.output.as_slice() {
            [] if self.quiet => Vec::new(),
            [] => vec![(None, named.unwrap_or(&FORMATS[0]))],
            [file] => vec![(Some(file), called(file)?)],
            files => {
                let format = |file| format_of(file).or_else(|_| called(file));
                let all = files.iter().map(|file| Ok((Some(file.as_path()), format(file)?)));
                let all: Result<Vec<(Option<&Path>, &'static Format)>, Failure> = all.collect();
                let mut all = all?;
                let is_missing =
                    |named: &&Format| all.iter().all(|(_, one)| one.name != named.name);
                let missing = named.filter(is_missing);
                all.extend(missing.map(|named| (None, named)));
                all
            }
        })
    }

    /// The targets of the reports and of the trace, if requested.
    pub fn targets(
        &self,
        project: &ProjectOptions,
        search: &SearchOptions,
    ) -> Result<(Reports, TraceTarget), Failure> {
        let trace = search.trace_search.as_ref().and_then(Option::as_deref);
        let outputs = self.output.iter().map(|file| ("--output", Some(file.as_path())));
        let written: Vec<_> = outputs.chain([("--trace-search", trace)]).collect();
        output::apart(&project.reads(), &written)?;
        if self.quiet {
            progress::hide();
        }
        let reports = self.reports()?.into_iter();
        let reports: Result<Vec<_>, Failure> =
            reports.map(|(file, format)| Ok((Target::new(file)?, format))).collect();
        Ok((Reports(reports?), search.target()?))
    }

    /// Writes an audit's reports.
    pub fn write(
        &self,
        audit: &Audit,
        check: Option<&Check>,
        reports: Reports,
    ) -> Result<(), Failure> {
        let answer = |extent| text::answer(audit, check, extent);
        let detail = if check.is_some() { Detail::Short } else { Detail::Usual };
        self.fill(reports, detail, answer, |format, extent, out| {
            (format.audit)(audit, check, extent, out)
        })
    }

    /// Writes each report. If none goes to stdout, the answer goes to stderr.
    pub fn fill(
        &self,
        Reports(reports): Reports,
        detail: Detail,
        answer: impl Fn(Extent) -> String,
        write: impl Fn(&Format, Extent, &mut dyn Write) -> std::io::Result<()>,
    ) -> Result<(), Failure> {
        let is_shown = reports.iter().any(|(target, _)| matches!(target, Target::Stdout));
        for (target, format) in reports {
            let extent = self.extent(detail, &target);
            let fill = |out: &mut dyn Write| write(format, extent, out);
            if format.escapes { target.fill_escaped(fill) } else { target.fill(fill) }?;
        }
        if !is_shown && !self.quiet {
            say(&answer(Extent { width: output::width_of_stderr(), ..Extent::default() }));
        }
        Ok(())
    }

    /// The targets of documents that cover several projects, which read these files.
    pub fn documents(&self, read: &[&Path]) -> Result<Documents, Failure> {
        let written: Vec<_> =
            self.output.iter().map(|file| ("--output", Some(file.as_path()))).collect();
        output::apart(read, &written)?;
        if self.quiet {
            progress::hide();
        }
        let begin = |(file, format)| {
            let target = Target::new(file)?;
            Document::begin(format, self.extent(Detail::Short, &target), target)
        };
        let all: Result<Vec<Document>, Failure> = self.reports()?.into_iter().map(begin).collect();
        Ok(Documents(all?))
    }

    /// Writes a project's answer to stderr, unless a document on stdout contains it.
    pub fn tell(&self, documents: &Documents, file: &str, audit: &Audit, check: &Check) {
        if self.quiet || documents.is_shown() {
            return;
        }
        let extent = Extent { width: output::width_of_stderr(), ..Extent::default() };
        say(&format!("{file}\n{}", text::answer(audit, Some(check), extent)));
    }

    /// The files that are written.
    pub fn writes(&self, search: &SearchOptions) -> Vec<PathBuf> {
        let trace = search.trace_search.iter().flatten();
        self.output.iter().chain(trace).cloned().collect()
    }

    /// How much of a report is shown, and the page size.
    fn extent(&self, detail: Detail, target: &Target) -> Extent {
        let usual = Extent::default();
        let (width, height) = target.page().unwrap_or((usual.width, usual.height));
        let (detail, values) = match (self.verbose, detail) {
            (false, detail) => (detail, usual.values),
            (true, Detail::Short) => (Detail::Usual, usual.values),
            (true, _) => (Detail::Full, usize::MAX),
        };
        Extent { top: self.top, values, detail, by: self.by.map(By::from), width, height }
    }
}

/// The number of programs that are named in a suggested command.
const MAX_NAMED: usize = 3;

/// A word quoted for a shell.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+:,=@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

/// The report format of a file's suffix; text if it has none.
fn format_of(file: &Path) -> Result<&'static Format, Failure> {
    if file.extension().is_none() {
        return Ok(&FORMATS[0]);
    }
    formats::by_suffix(FORMATS, &file.to_string_lossy()).ok_or_else(|| {
        let known = FORMATS.iter().flat_map(|format| format.suffixes);
        let known: Vec<String> = known.map(|suffix| format!(".{suffix}")).collect();
        let (name, known) = (file.display(), known.join(", "));
        anyhow!(
            "--output {name}: no report format has this suffix: use one of {known}, or give --format"
        )
        .into()
    })
}

pub(super) fn facts(path: Option<&Path>) -> Result<Facts, Failure> {
    let Some(path) = path else { return Ok(Facts::default()) };
    let name = path.display().to_string();
    let bytes = read_small(path).with_context(|| format!("--facts {name} cannot be read"))?;
    let text = String::from_utf8(bytes).map_err(|_| {
        let message = "the facts file is not text in UTF-8";
        vec![Diagnostic::file(Code::Facts, &name, message, "save it as UTF-8")]
    })?;
    Ok(Facts::parse(&name, &text)?)
}

/// The result, or `None` if it failed; the faults are then recorded.
fn readable<T>(
    read: Result<T, Failure>,
    found: &mut Vec<Diagnostic>,
) -> Result<Option<T>, Failure> {
    match read {
        Ok(read) => Ok(Some(read)),
        Err(Failure::Input(faults)) => {
            found.extend(faults);
            Ok(None)
        }
        Err(why) => Err(why),
    }
}

/// Becomes true at the first Ctrl-C or SIGTERM, which ends the audit with what is proved so far. The second ends the
/// program. The handler is installed once, even if several projects are audited.
pub fn stop_on_interrupt() -> Result<Arc<AtomicBool>, Failure> {
    static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    if let Some(stop) = STOP.get() {
        return Ok(Arc::clone(stop));
    }
    let stop = Arc::clone(STOP.get_or_init(Arc::default));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        say("stopping; press Ctrl-C again to abort at once\n");
    })
    .context("Ctrl-C and SIGTERM cannot be watched for")?;
    Ok(stop)
}

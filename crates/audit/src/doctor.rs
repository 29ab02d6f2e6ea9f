//! Examines a project without an audit: lists everything that was read and everything that prevents a bound. It goes on
//! after the first fault.

use super::pipeline::STAGES;
use super::priced::refuse_assumed;
use super::request::Request;
use super::understood::{choose_table, fitted, other_series, state};
use super::{Failure, contradiction, doubt};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::{Diagnostic, Severity};
use scanbound_front::{FileKind, Input, Options, Project};
use scanbound_ir::Program;
use scanbound_timing::price;
use scanbound_timing::table::Table;
use std::collections::BTreeSet;

/// The result of examining a project without an audit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnosis {
    /// The files that were examined, in the order of the request.
    pub files: Vec<ExaminedFile>,
    /// The CPU that the user names, otherwise the one that the project names. `None` if neither names one, or nothing
    /// could be read.
    pub cpu: Option<String>,
    /// The name of the timing table for the CPU, or of the one that the user names. `None` if none was found.
    pub table: Option<String>,
    /// The findings, in the order of [`Section::ALL`].
    pub findings: Vec<Finding>,
}

impl Diagnosis {
    /// Whether no finding prevents a bound. Facts that are not stated do not prevent one, but it may then be too low.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.findings.iter().all(|one| !one.section.is_grave())
    }
}

/// A file that was examined.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExaminedFile {
    /// The name of the file as the user gave it.
    pub name: String,
    /// What the file contains.
    pub what: ExaminedKind,
    /// The number of instructions in the file. `None` if the file is not a program, or if no program could be decoded.
    pub instructions: Option<usize>,
    /// Whether the file contains only subroutines, which run only if they are called.
    pub standby: bool,
}

/// The contents of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExaminedKind {
    /// A program in this dialect. `as named`: the user named the dialect, and it cannot be told from the contents.
    Program(&'static str),
    /// Names and comments of devices.
    Comments,
    /// A file that was excluded because it has errors, or whose contents are not recognised.
    Refused,
}

/// The sections of the list of findings. The first five prevent a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Section {
    /// Text that cannot be read or understood, and all errors that belong to no other section.
    Refused,
    /// Instructions that no front knows.
    Unknown,
    /// Missing routines and labels.
    Missing,
    /// Instructions for which the table has no time, or only an assumed one although the user excludes these.
    NoTime,
    /// Facts, options or rows of the table that do not fit the program.
    Stated,
    /// Reasons why a bound may be too low, mostly facts that it needs and that are not stated.
    NotStated,
    /// Files among the programs that were left out.
    LeftOut,
    /// Other warnings.
    Noticed,
}

impl Section {
    /// All sections, in the order of the list.
    pub const ALL: [Section; 8] = [
        Section::Refused,
        Section::Unknown,
        Section::Missing,
        Section::NoTime,
        Section::Stated,
        Section::NotStated,
        Section::LeftOut,
        Section::Noticed,
    ];

    /// The name of the section in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Section::Refused => "refused",
            Section::Unknown => "unknown",
            Section::Missing => "missing",
            Section::NoTime => "without-time",
            Section::Stated => "stated-wrongly",
            Section::NotStated => "not-stated",
            Section::LeftOut => "left-out",
            Section::Noticed => "noticed",
        }
    }

    /// Whether the findings of this section prevent a bound.
    #[must_use]
    pub fn is_grave(self) -> bool {
        self < Section::NotStated
    }

    fn of(fault: &Diagnostic) -> Section {
        match (fault.severity, fault.code) {
            (Severity::Warning, Code::LeftOut) => Section::LeftOut,
            (Severity::Warning, _) => Section::Noticed,
            (_, Code::UnknownInstruction) => Section::Unknown,
            (_, Code::NoSubroutine | Code::NoLabel) => Section::Missing,
            (_, Code::NoTime | Code::AssumedTime) => Section::NoTime,
            (
                _,
                Code::Facts
                | Code::Fact
                | Code::BrokenFact
                | Code::NoInterrupt
                | Code::NoTable
                | Code::NoBase
                | Code::NoClock
                | Code::NoSuchDialect,
            ) => Section::Stated,
            (_, code) if code.name().starts_with("table-") => Section::Stated,
            _ => Section::Refused,
        }
    }
}

/// A finding, perhaps at several places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The section in which the finding is listed.
    pub section: Section,
    /// The code of the finding. `None` in the section [`Section::NotStated`].
    pub code: Option<Code>,
    /// What is wrong.
    pub message: String,
    /// What the user can do. Empty in the section [`Section::NotStated`], where `message` says it.
    pub help: String,
    /// The files and lines, in their order. The line is `None` if the finding is about a whole file. The list is empty
    /// if it is about no file.
    pub places: Vec<(String, Option<u32>)>,
    /// The source text at the first place. Empty if there is none.
    pub text: String,
}

/// Examines a project as far as possible: reads and decodes it, looks for its timing table, checks the facts against
/// the program, and prices it. `noticed` are findings made while its files were collected.
#[must_use]
pub fn diagnose(request: &Request<'_>, noticed: Vec<Diagnostic>) -> Diagnosis {
    let mut doctor = Doctor {
        request,
        found: noticed,
        dropped: BTreeSet::new(),
        cpu: None,
        table: None,
        doubts: Vec::new(),
    };
    let program = doctor.read_all();
    if doctor.found.iter().all(|one| one.severity != Severity::Error) {
        doctor.add(contradiction::of(STAGES, request));
    }
    let files =
        request.inputs.iter().map(|input| doctor.examined(input, program.as_ref())).collect();
    let Doctor { found, cpu, table, doubts, .. } = doctor;
    Diagnosis { files, cpu, table, findings: findings(found, doubts) }
}

struct Doctor<'r, 'a> {
    request: &'r Request<'a>,
    found: Vec<Diagnostic>,
    /// The names of files that are excluded from further stages because they have errors.
    dropped: BTreeSet<String>,
    cpu: Option<String>,
    table: Option<String>,
    doubts: Vec<doubt::Doubt>,
}

impl Doctor<'_, '_> {
    /// Runs the stages. If one finds faults, it is repeated without the files that have them. Returns the program, or
    /// `None` if no file is left that can be read.
    fn read_all(&mut self) -> Option<Program> {
        loop {
            let project = self.read()?;
            self.cpu = self.request.cpu.or(project.cpu()).map(str::to_owned);
            let table = match choose_table(self.request, project.cpu()) {
                Ok(table) => Some(table),
                Err(why) => {
                    self.note(why);
                    None
                }
            };
            self.table = table.as_ref().map(|table| table.name.clone());
            self.add(project.warnings());
            self.add(other_series(self.request.cpu, project.cpu()).into_iter().collect());
            let Some(program) = self.decode(&*project, table.as_ref()) else {
                // Each round excludes files, or nothing is left to examine.
                continue;
            };
            return Some(self.price(program, table));
        }
    }

    /// Reads the remaining files. Files that cannot be read are excluded. `None` if no file is left, or if the fault
    /// belongs to no file.
    fn read(&mut self) -> Option<Box<dyn Project>> {
        loop {
            let left: Vec<Input> = self.remaining_files().cloned().collect();
            if left.is_empty() && !self.found.is_empty() {
                return None;
            }
            match self.request.fronts.read(&left, self.request.dialect, self.request.reading) {
                Ok(project) => return Some(project),
                Err(faults) => {
                    let before = self.dropped.len();
                    self.drop_faulty(&faults);
                    self.add(faults);
                    if self.dropped.len() == before {
                        return None;
                    }
                }
            }
        }
    }

    /// Decodes the programs. Unknown instructions and missing routines are reported and then accepted, so that other
    /// faults are found too. Files with other faults are excluded; then the result is `None`, and the caller repeats
    /// the reading without them.
    fn decode(&mut self, project: &dyn Project, table: Option<&Table>) -> Option<Program> {
        let budget = self.request.budget();
        let options = |knows: &dyn Fn(&str) -> bool, incomplete: bool| {
            project.decode(&Options {
                cpu: self.request.cpu,
                family: table.and_then(|table| table.family.as_deref()),
                is_user_instruction: knows,
                facts: self.request.facts,
                absent_calls_take_no_time: incomplete,
                task: self.request.task,
                uninterrupted: self.request.alone,
                others_write: self.request.others_write(),
                budget: Some(&budget),
            })
        };
        let knows = |name: &str| table.is_some_and(|table| table.knows(name));
        let faults = match options(&knows, false) {
            Ok(program) => return Some(program),
            Err(faults) => faults,
        };
        let lenient = options(&|_| true, true);
        let is_whole = self.dropped.is_empty();
        // A call to an excluded file is not a fault.
        let calls = |fault: &Diagnostic| matches!(fault.code, Code::NoSubroutine | Code::NoLabel);
        self.add(faults.into_iter().filter(|fault| is_whole || !calls(fault)).collect());
        match lenient {
            Ok(program) => Some(program),
            Err(faults) => {
                let before = self.dropped.len();
                self.drop_faulty(&faults);
                if self.dropped.len() == before {
                    // The faults belong to no file, so no file can be excluded.
                    let all: Vec<String> =
                        self.remaining_files().map(|input| input.name.clone()).collect();
                    self.dropped.extend(all);
                }
                None
            }
        }
    }

    /// Checks the stated facts (unless files were excluded), calls and loops, and whether the table has the times.
    /// Returns the program.
    fn price(&mut self, mut program: Program, table: Option<Table>) -> Program {
        if self.dropped.is_empty() {
            match state(&mut program, self.request) {
                Ok(noticed) | Err(noticed) => self.add(noticed),
            }
        }
        let settings = scanbound_passes::Settings { trust: self.request.trusted(), budget: None };
        // The analysis of values affects only the bound; the other passes may refuse a program.
        let structure = scanbound_passes::Passes(&[
            &scanbound_passes::calls::PASS,
            &scanbound_passes::loops::PASS,
        ]);
        if let Err(faults) = structure.run(&mut program.clone(), &settings, |_| {}) {
            self.add(faults);
        }
        let Some(table) = table else { return program };
        let table = fitted(table, &program, self.request);
        match price::price(&program, &table, self.request.facts) {
            Ok(prices) => {
                self.doubts = doubt::doubts_before_scan(&program, &prices);
                if let (true, Err(why)) =
                    (self.request.strict_times, refuse_assumed(&program, &prices))
                {
                    self.note(why);
                }
            }
            Err(faults) => {
                let is_known = |fault: &Diagnostic| {
                    let at = (&fault.file, fault.line);
                    self.found.iter().any(|one| {
                        one.code == Code::UnknownInstruction && (&one.file, one.line) == at
                    })
                };
                let faults = faults.into_iter().filter(|fault| !is_known(fault)).collect();
                self.add(faults);
            }
        }
        program
    }

    fn remaining_files(&self) -> impl Iterator<Item = &Input> {
        self.request.inputs.iter().filter(|input| !self.dropped.contains(&input.name))
    }

    fn drop_faulty(&mut self, faults: &[Diagnostic]) {
        let grave = faults.iter().filter(|fault| fault.severity == Severity::Error);
        let names: BTreeSet<String> = grave.map(|fault| fault.file.clone()).collect();
        let faulty: Vec<String> = self
            .remaining_files()
            .filter(|input| names.contains(&input.name))
            .map(|one| one.name.clone())
            .collect();
        self.dropped.extend(faulty);
    }

    /// Adds those findings that are not in the list yet.
    fn add(&mut self, faults: Vec<Diagnostic>) {
        for fault in faults {
            if !self.found.contains(&fault) {
                self.found.push(fault);
            }
        }
    }

    fn note(&mut self, why: Failure) {
        if let Failure::Input(faults) = why {
            self.add(faults);
        }
    }

    fn examined(&self, input: &Input, program: Option<&Program>) -> ExaminedFile {
        let own = |program: &Program| {
            program.files.iter().find(|file| file.name == input.name).map(|file| file.count)
        };
        let what = match self.request.fronts.detect(input) {
            _ if self.dropped.contains(&input.name) => ExaminedKind::Refused,
            Ok(FileKind::Program(dialect)) => ExaminedKind::Program(dialect.name),
            Ok(FileKind::Comments) => ExaminedKind::Comments,
            Err(_) => self
                .request
                .dialect
                .map_or(ExaminedKind::Refused, |_| ExaminedKind::Program("as named")),
        };
        let is_standby = |program: &Program| {
            program.standby.iter().any(|&file| program.files[file].name == input.name)
        };
        ExaminedFile {
            name: input.name.clone(),
            what,
            instructions: program.and_then(own),
            standby: program.is_some_and(is_standby),
        }
    }
}

/// All findings as a list, sorted by section. Findings with the same code and message are listed once, with all their
/// places.
fn findings(found: Vec<Diagnostic>, doubts: Vec<doubt::Doubt>) -> Vec<Finding> {
    let mut findings: Vec<Finding> = Vec::new();
    for fault in found {
        let section = Section::of(&fault);
        let known = findings.iter_mut().find(|one| {
            one.section == section && one.code == Some(fault.code) && one.message == fault.message
        });
        let place = (!fault.file.is_empty()).then_some((fault.file, fault.line));
        match known {
            Some(known) => known.places.extend(place),
            None => findings.push(Finding {
                section,
                code: Some(fault.code),
                message: fault.message,
                help: fault.help,
                places: place.into_iter().collect(),
                text: fault.text,
            }),
        }
    }
    findings.extend(doubts.into_iter().map(|doubt| Finding {
        section: Section::NotStated,
        code: None,
        message: doubt.to_string(),
        help: String::new(),
        places: Vec::new(),
        text: String::new(),
    }));
    findings.sort_by_key(|one| one.section);
    findings
}

//! Reads a MELSEC project: the programs in the given order, and the device comments.

use super::source::{RawFile, RawInstruction, RawProject};
use super::{comments, csv, list, words};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::{Diagnostic, Severity};
use scanbound_front::{Dialect, Faults, Input, decoded, empty_comment_files, shown, stem};

/// Words in the headings of program and comment files, in several languages, by which the code page of a file is
/// recognised.
pub(super) fn known_words() -> Vec<&'static str> {
    csv::MARKS.into_iter().chain(comments::MARKS).collect()
}

/// Reads programs, all in one `dialect`, and comment files. The programs keep their order, in which they run in a scan.
/// An unreadable comment file gives only a warning.
///
/// # Errors
///
/// The diagnostics of all files, warnings included, if at least one is an error: of each file at most 50 errors and 50
/// warnings.
pub fn read(
    dialect: &Dialect,
    programs: &[&Input],
    comment_files: &[&Input],
) -> Result<RawProject, Vec<Diagnostic>> {
    let mut project = RawProject { dialect: dialect.name, ..RawProject::default() };
    for input in programs {
        let mut faults = Faults::new(&input.name);
        let file = read_program(dialect, input, &mut faults);
        if let (Some(file), false) = (file, faults.any_error()) {
            project.files.push(file);
        }
        project.warnings.extend(faults.into_diagnostics());
    }
    check_cpus(&mut project);
    for input in comment_files {
        // Comments are only shown in reports, so an error in them does not stop the audit.
        match decoded(input, &known_words()) {
            Ok(text) => comments::read(&text, &mut project.comments),
            Err(fault) => project.warnings.push(fault.warning()),
        }
    }
    if project.warnings.iter().any(|found| found.severity == Severity::Error) {
        return Err(project.warnings);
    }
    project.warnings.extend(empty_comment_files(comment_files));
    Ok(project)
}

fn read_program(dialect: &Dialect, input: &Input, faults: &mut Faults<'_>) -> Option<RawFile> {
    let text = decoded(input, &known_words()).map_err(|fault| faults.push(fault)).ok()?;
    if words::has_long_line(&text, faults) {
        return None;
    }
    let (cpu, instructions): (Option<String>, Vec<RawInstruction>) = if dialect.name
        == list::DIALECT
    {
        (None, list::read(&text, faults))
    } else if let Some(layout) = csv::layout(&text) {
        let instructions = csv::read(&text, &layout, faults);
        (layout.cpu, instructions)
    } else {
        faults.error_in_line(
            Code::NoHeads,
            1,
            text.lines().next().unwrap_or_default(),
            "the column headings are missing",
            "export the program again: the title, the CPU and seven column headings must come before the instructions",
        );
        return None;
    };
    Some(RawFile {
        name: input.name.clone(),
        program: stem(&input.name).to_owned(),
        cpu,
        instructions,
        source: if dialect.name == list::DIALECT { text.into_owned() } else { String::new() },
    })
}

/// Reports each file that names another CPU than the first file that names one: as an error if only one of them is an
/// FX or FX5, because these number inputs and outputs in octal; otherwise as a warning.
fn check_cpus(project: &mut RawProject) {
    let mut named = project.files.iter().filter_map(|file| Some((file, file.cpu.as_deref()?)));
    let Some((first, cpu)) = named.next() else { return };
    let other: Vec<Diagnostic> = named
        .filter(|(_, other)| *other != cpu)
        .map(|(file, other)| {
            let fault = Diagnostic::file(
                Code::OtherCpu,
                &file.name,
                format!(
                    "this program is for {}, but the program in {} is for {cpu}",
                    shown(other),
                    first.name
                ),
                "audit the files of each CPU separately",
            );
            if other.starts_with("FX") == cpu.starts_with("FX") { fault.warning() } else { fault }
        })
        .collect();
    project.warnings.extend(other);
}

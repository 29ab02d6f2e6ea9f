//! Reads an OMRON project from its files, in the given order.

use super::source::{Family, RawFile, RawProject};
use super::{C, CXT, cxt, list};
use crate::diagnostic::{Diagnostic, Severity};
use crate::dialect::{Dialect, Faults, Input, decoded, stem};

/// Reads the programs, all written in `dialect`.
///
/// # Errors
/// The faults of all files.
pub fn read(dialect: &Dialect, programs: &[&Input]) -> Result<RawProject, Vec<Diagnostic>> {
    let mut found = Vec::new();
    let mut files = Vec::new();
    for input in programs {
        let mut faults = Faults::new(&input.name);
        match decoded(input) {
            Ok(text) if dialect.name == CXT => {
                let mut file = cxt::read(&text, &input.name, &mut faults);
                file.source = text.into_owned();
                files.push(file);
            }
            Ok(text) => {
                let program = list::read(&text, stem(&input.name), &mut faults);
                files.push(RawFile {
                    name: input.name.clone(),
                    programs: vec![program],
                    source: text.into_owned(),
                    ..RawFile::default()
                });
            }
            Err(fault) => faults.push(fault),
        }
        found.extend(faults.into_diagnostics());
    }
    if found.iter().any(|fault| fault.severity == Severity::Error) {
        return Err(found);
    }
    let named = files.iter().find_map(|file| file.cpu.as_deref());
    let family = match (dialect.name == C, named) {
        (true, _) => Family::C,
        (false, Some(cpu)) => cxt::family(cpu),
        (false, None) => Family::Cs,
    };
    Ok(RawProject { dialect: dialect.name, family, files, warnings: found })
}

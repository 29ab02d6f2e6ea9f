//! Reads an OMRON project from its files, in the given order.

use super::source::{C, CXT, Family, RawFile, RawInstruction, RawProject, Symbols};
use super::{cxt, list, symbols};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::{Diagnostic, Severity};
use scanbound_front::numbering::{self, NumberedLine};
use scanbound_front::{Dialect, Faults, Input, decoded, empty_comment_files, shown, stem};

/// Reads programs, all in one `dialect`, and symbol tables.
///
/// # Errors
/// The errors and warnings of all files, if at least one is an error: of each file at most 50 of each. Or only the
/// error that the CPU is not supported.
pub fn read(
    dialect: &Dialect,
    programs: &[&Input],
    comment_files: &[&Input],
) -> Result<RawProject, Vec<Diagnostic>> {
    let mut found = Vec::new();
    let mut files = Vec::new();
    for input in programs {
        let mut faults = Faults::new(&input.name);
        match decoded(input, &[]) {
            Ok(text) if dialect.name == CXT => {
                let mut file = cxt::read(&text, &input.name, &mut faults);
                file.source = text.into_owned();
                files.push(file);
            }
            Ok(text) => {
                let program = list::read(&text, stem(&input.name), &mut faults);
                numbering::check(numbered(&program.instructions, dialect.name == C), &mut faults);
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
    let mut known = Symbols::new();
    for input in comment_files {
        let mut faults = Faults::new(&input.name);
        match decoded(input, &[]) {
            Ok(text) if symbols::sniff(&text) => symbols::read(&text, &mut known, &mut faults),
            Ok(_) => {}
            Err(fault) => faults.push(fault),
        }
        found.extend(faults.into_diagnostics());
    }
    for file in &mut files {
        for (name, symbol) in &known {
            file.symbols.entry(name.clone()).or_insert_with(|| symbol.clone());
        }
    }
    if found.iter().any(|fault| fault.severity == Severity::Error) {
        return Err(found);
    }
    found.extend(missing_ends(&files, dialect.name == C));
    let named = files.iter().find_map(|file| file.cpu.as_deref());
    found.extend(named.and_then(|cpu| parallel_processing(cpu, &files)));
    let family = match (dialect.name == C, named) {
        (true, _) => Family::C,
        (false, Some(cpu)) => cxt::family(cpu).map_err(|message| {
            let name = files.first().map_or("", |file| &file.name);
            vec![Diagnostic::file(
                Code::OtherCpu,
                name,
                message,
                "scanbound supports C200H, C1000H, C2000H, CQM1, CPM and SRM1 CPUs, and the CS, CJ and CP series: give a program for one of these",
            )]
        })?,
        (false, None) => Family::Cs,
    };
    found.extend(empty_comment_files(comment_files));
    Ok(RawProject { dialect: dialect.name, family, files, warnings: found })
}

/// A warning for CPUs that have parallel processing (CS1 and CJ1 CPUs with `-H`): with asynchronous memory access,
/// peripheral servicing may write at any moment. `None` for other CPUs.
fn parallel_processing(cpu: &str, files: &[RawFile]) -> Option<Diagnostic> {
    let device = cpu.trim().to_ascii_uppercase();
    let can = ["CS1", "CJ1"].iter().any(|name| device.starts_with(name)) && device.contains("-H");
    let file = files.first().map_or("", |file| &file.name);
    let message = format!(
        "{} can service peripherals in parallel with the program (parallel processing)",
        cpu.trim()
    );
    let help = "the bound holds in normal mode and with synchronous memory access; with asynchronous access, values may change within a scan";
    can.then(|| Diagnostic::file(Code::Parallel, file, message, help).warning())
}

/// Warns of programs without END. With `joined` (C series), the files are the parts of one program, so only the last
/// file must have END.
fn missing_ends(files: &[RawFile], joined: bool) -> Vec<Diagnostic> {
    let is_end = |raw: &RawInstruction| {
        raw.mnemonic.eq_ignore_ascii_case("END")
            || (raw.mnemonic.is_empty() && raw.number.is_some_and(|number| number.value == 1))
    };
    let asked = files.iter().skip(if joined { files.len().saturating_sub(1) } else { 0 });
    let programs = asked.flat_map(|file| file.programs.iter().map(move |program| (file, program)));
    let open = programs.filter(|(_, program)| !program.instructions.iter().any(is_end));
    let warnings = open.filter_map(|(file, program)| {
        let last = program.instructions.last()?;
        let message = "the program has no END: scanbound assumes that the program ends here";
        let help =
            "if the file is truncated, export it again; otherwise write END after the last instruction";
        let text = shown(&last.text);
        let error = Diagnostic::line(Code::NoEnd, &file.name, last.line, text, message, help);
        Some(error.at_step(last.step).warning())
    });
    warnings.collect()
}

/// The instructions with their addresses. With `by_one` (C series), each instruction occupies one address. In other
/// lists the numbers may be rung numbers: if two successive instructions have the same number, the numbers are not
/// checked.
fn numbered(
    instructions: &[RawInstruction],
    by_one: bool,
) -> impl Iterator<Item = NumberedLine<'_>> {
    let doubled =
        instructions.windows(2).any(|two| two[0].step.is_some() && two[0].step == two[1].step);
    let is_told = by_one || !doubled;
    instructions.iter().map(move |one| NumberedLine {
        line: one.line,
        address: one.step.filter(|_| is_told),
        takes: by_one.then_some(1),
        text: &one.text,
        restarts: one.mnemonic == "END" || one.number.is_some_and(|number| number.value == 1),
    })
}

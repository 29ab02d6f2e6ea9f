//! Checks a program against a limit and ends with the exit code of the verdict, as `scanbound check` does.
#![allow(clippy::print_stdout)]

use scanbound::audit::verdict::Verdict;
use scanbound::base::time::Picos;
use std::error::Error;
use std::process::ExitCode;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "samples/transfer-line/line.il".to_owned());
    let limit = arguments.next().unwrap_or_else(|| "10ms".to_owned());
    let (answer, code) = check(&name, &limit)?;
    println!("{answer}");
    Ok(ExitCode::from(code))
}

/// The verdict in words, and its exit code.
///
/// # Errors
/// A file cannot be read, the program cannot be analysed, or the limit is not a time.
pub fn check(name: &str, limit: &str) -> Result<(String, u8), Box<dyn Error>> {
    let facts = std::fs::read_to_string("samples/transfer-line/facts.toml")?;
    let report = scanbound::Analysis::new()
        .file(name, std::fs::read(name)?)
        .cpu("Q26UDV")
        .facts("facts.toml", facts)
        .run()?;
    let limit: Picos = limit.parse()?;
    Ok(match report.check(limit) {
        Verdict::Proved => (format!("proved: no scan takes more than {limit}"), 0),
        Verdict::Refuted => (format!("refuted: a scan takes {}", report.lower()), 1),
        Verdict::Undecided(reasons) => {
            let reasons = reasons.iter().map(|reason| format!("\n- {reason}"));
            (format!("undecided:{}", reasons.collect::<String>()), 3)
        }
    })
}

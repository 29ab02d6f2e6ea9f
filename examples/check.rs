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
    let facts = std::fs::read_to_string("samples/transfer-line/facts.toml")?;
    let report = scanbound::Analysis::new()
        .file(name.as_str(), std::fs::read(&name)?)
        .cpu("Q26UDV")
        .facts("facts.toml", facts)
        .run()?;
    let limit: Picos = limit.parse()?;
    Ok(match report.check(limit) {
        Verdict::Proved => {
            println!("proved: no scan takes more than {limit}");
            ExitCode::SUCCESS
        }
        Verdict::Refuted => {
            println!("refuted: a scan takes {}", report.lower());
            ExitCode::from(1)
        }
        Verdict::Undecided(reasons) => {
            println!("undecided:");
            reasons.iter().for_each(|reason| println!("- {reason}"));
            ExitCode::from(3)
        }
    })
}

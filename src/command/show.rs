//! `scanbound show`: rungs drawn as ladder.

use super::options::ProjectOptions;
use super::{Failure, Outcome};
use anyhow::anyhow;
use clap::Args;
use scanbound::audit::{self, comments_in};
use scanbound::program::Program;
use scanbound::program::ladder::{Rung, Symbol, rungs};
use scanbound::report::ladder::draw;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::ops::RangeInclusive;

const EXAMPLES: &str = "\
Examples:
  scanbound show PLC/ --rung 35           one rung, numbered as reports number them
  scanbound show PLC/ --rung 35-40        some
  scanbound show PLC/ --line MAIN.csv:120 the rung that this line belongs to";

/// The arguments of `show`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    project: ProjectOptions,
    /// The rung as numbered in reports, or the first and the last; default: all
    #[arg(long, value_name = "NUMBER", value_parser = numbers, conflicts_with = "line")]
    rung: Option<RangeInclusive<u32>>,
    /// The rung that contains this line; the number alone if there is only one file
    #[arg(long, value_name = "FILE:LINE")]
    line: Option<String>,
}

fn numbers(text: &str) -> Result<RangeInclusive<u32>, String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let number = |text: &str| text.trim().parse::<u32>().ok().filter(|&number| number > 0);
    match (number(first), number(last)) {
        (Some(first), Some(last)) if first <= last => Ok(first..=last),
        _ => Err("write a rung's number, or the first and the last: 35, 35-40".to_owned()),
    }
}

/// Draws the requested rungs.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let program = arguments.project.with_request(|request| Ok(audit::read(request)?))?;
    let all = rungs(&program);
    let shown: Vec<&Rung> = match (&arguments.rung, &arguments.line) {
        (Some(numbers), _) => all.iter().filter(|rung| numbers.contains(&rung.number)).collect(),
        (None, Some(line)) => all.iter().filter(|rung| is_at(&program, rung, line)).collect(),
        (None, None) => all.iter().collect(),
    };
    if shown.is_empty() {
        let last = all.last().map_or(0, |rung| rung.number);
        let message = match &arguments.line {
            Some(line) => {
                format!("--line {line}: no rung contains this line; write FILE:LINE as in reports")
            }
            None => format!("--rung: the project has rungs 1 to {last}"),
        };
        return Err(anyhow!(message).into());
    }
    let texts = shown.into_iter().map(|rung| drawn(&program, rung));
    super::output::Target::new(None)?.write(&texts.collect::<Vec<_>>().join("\n"))?;
    Ok(Outcome::Done)
}

/// Whether a line belongs to a rung.
fn is_at(program: &Program, rung: &Rung, line: &str) -> bool {
    let (file, number) = line.rsplit_once(':').unwrap_or(("", line));
    let name = &program.files[rung.file as usize].name;
    let is_file =
        file.is_empty() && program.files.len() == 1 || name.ends_with(file) && !file.is_empty();
    is_file && rung.elements.iter().any(|one| number.parse() == Ok(one.at.line))
}

/// A rung with its number and place, and the comments of its devices.
fn drawn(program: &Program, rung: &Rung) -> String {
    let name = &program.files[rung.file as usize].name;
    let first = rung.elements.first().map_or(0, |one| one.at.line);
    let mut text = format!("rung {}  {name}:{first}\n", rung.number);
    text += &draw(rung, &|element| rung.elements[element].label().to_owned());
    let mut told = BTreeSet::new();
    for element in &rung.elements {
        for comment in comments_in(program, &program.instructions[element.parts.start]) {
            if element.symbol != Symbol::Link && told.insert(comment.clone()) {
                let _ = writeln!(text, "  {comment}");
            }
        }
    }
    text
}

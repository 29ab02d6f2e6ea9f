//! `scanbound tables`: lists the timing tables, shows one, or checks a user's.

use super::output::{self, Target};
use super::{Failure, Outcome};
use anyhow::Context;
use clap::Args;
use scanbound::base::code::Code;
use scanbound::base::diagnostic::Diagnostic;
use scanbound::front::input::read_small;
use scanbound::report::tables;
use scanbound::timing::table::{Parsed, Table, builtin};
use std::path::Path;

const EXAMPLES: &str = "\
Examples:
  scanbound tables                           the built-in tables
  scanbound tables qnudv                     one of them, row by row
  scanbound tables --check my.csv            the faults of a table of your own";

/// The arguments of `tables`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The table to show, a built-in one or a file [default: list the built-in ones]
    #[arg(value_name = "NAME|FILE")]
    name: Option<String>,
    /// Check your own table: show its faults, or count its rows
    #[arg(long, value_name = "FILE", conflicts_with = "name")]
    check: Option<String>,
}

/// Lists, shows or checks.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let text = match (&arguments.check, &arguments.name) {
        (Some(file), _) => {
            let bytes = read_small(Path::new(file))
                .with_context(|| format!("--check {file}: this table cannot be read"))?;
            let parsed = Table::parse(file, &bytes)?;
            output::tell(&parsed.warnings);
            tables::checked(&parsed.table)
        }
        (None, Some(name)) => tables::one(&find("", name)?.table),
        (None, None) => tables::list(&builtin::list()),
    };
    Target::Stdout.write(&text)?;
    Ok(Outcome::Done)
}

/// A built-in table by its name, or one read from a file. `option` precedes the name in messages.
pub fn find(option: &str, name: &str) -> Result<Parsed, Failure> {
    match Table::builtin(name) {
        Some(table) => Ok(Parsed { table, warnings: Vec::new() }),
        None => read(option, name),
    }
}

fn read(option: &str, name: &str) -> Result<Parsed, Failure> {
    let bytes = read_small(Path::new(name)).map_err(|error| {
        let names = builtin::names();
        let likeness = |known: &str| strsim::jaro_winkler(known, &name.to_ascii_lowercase());
        let near = names
            .iter()
            .filter(|known| likeness(known) > 0.75)
            .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let meant = match (Table::for_cpu(name), near) {
            (Some(table), _) => format!("the table for this CPU is {table}; "),
            (None, Some(known)) => format!("did you mean {known}? "),
            (None, None) => String::new(),
        };
        Failure::Input(vec![Diagnostic::file(
            Code::NoTable,
            "",
            format!(
                "{option}{name}: neither a built-in timing table nor a file that can be read: {error}"
            ),
            format!("{meant}the built-in tables are {}", names.join(", ")),
        )])
    })?;
    Ok(Table::parse(name, &bytes)?)
}

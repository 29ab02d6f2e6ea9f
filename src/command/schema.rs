//! `scanbound schema`: the JSON schemas of all JSON output.

use super::output::Target;
use super::{Failure, Outcome};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use scanbound::report::schema::{Published, SCHEMAS};

const EXAMPLES: &str = "\
Examples:
  scanbound schema audit > audit.schema.json
  scanbound schema                           list the schemas";

/// The arguments of `schema`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The kind of JSON (docs/json.md) [default: list them]
    #[arg(value_name = "NAME", value_parser = name())]
    name: Option<String>,
}

fn name() -> PossibleValuesParser {
    let value = |one: &Published| PossibleValue::new(one.name).help(one.about);
    PossibleValuesParser::new(SCHEMAS.iter().map(value))
}

/// Writes a schema to stdout, or the list of schemas.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let row = |one: &Published| format!("{:8} {:21} {}\n", one.name, one.id, one.about);
    let asked = arguments.name.as_deref();
    let found = asked.and_then(|name| SCHEMAS.iter().find(|one| one.name == name));
    let text = found.map_or_else(|| SCHEMAS.iter().map(row).collect(), Published::text);
    Target::Stdout.write(&text)?;
    Ok(Outcome::Done)
}

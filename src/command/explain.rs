//! `scanbound explain`: what is known of an instruction, or the meaning of a finding code.

use super::output::Target;
use super::values::format_or_suffix;
use super::{Failure, Outcome, tables};
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use scanbound::audit::explain::{ExplainedInstruction, explain, names};
use scanbound::front::FRONTS;
use scanbound::report::explain::{json, text};
use scanbound::report::format::Extent;
use scanbound::report::page;
use scanbound::timing::table::{Table, builtin};
use std::path::PathBuf;

pub const ABOUT: &str = "\
Show what is known of an instruction, or the meaning of a finding code

For an instruction: its time when it is executed and when it is not, the table rows and documents these come from, how \
reliable they are, its variants, and how exactly the analysis models it. These are the values that an audit uses. For a \
code, such as no-time or limit-refuted: its meaning, an example, what to do.";

const EXAMPLES: &str = "\
Examples:
  scanbound explain BMOV --cpu Q26UDV        its times, evidence, source, variants
  scanbound explain BMOV                     by every timing table that has it
  scanbound explain no-time                  a code of reports, SARIF and scanbound doctor
  scanbound explain codes                    all codes

Exit codes: 0 done, 2 there is no such instruction or code";

/// The least similarity of a name that is suggested in place of an unknown one.
const ALIKE: f64 = 0.7;

/// The output format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PageFormat {
    /// For people
    #[value(alias = "txt")]
    Text,
    /// For programs (docs/json.md)
    Json,
}

/// The arguments of `explain`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// An instruction, a finding code, or the word `codes`
    #[arg(value_name = "NAME|CODE")]
    name: String,
    /// The CPU whose table gives the times
    #[arg(long, value_name = "NAME")]
    cpu: Option<String>,
    /// The timing table: a built-in one or a CSV file
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "cpu")]
    table: Option<String>,
    /// The output format; finding codes are always shown as text
    #[arg(long, value_enum)]
    format: Option<PageFormat>,
    /// Write to this file, which appears only when it is complete; without --format, its suffix names the format
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Explains an instruction or a finding code.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let target = Target::new(arguments.output.as_deref())?;
    let name = arguments.name.trim();
    if let Some(page) = page::of(&name.to_ascii_lowercase()) {
        target.write(page)?;
        return Ok(Outcome::Done);
    }
    let usual = Extent::default();
    let (width, height) = target.page().unwrap_or((usual.width, usual.height));
    let extent = Extent { width, height, ..usual };
    if name.eq_ignore_ascii_case("codes") {
        target.write(&page::list(width))?;
        return Ok(Outcome::Done);
    }
    let found: Vec<ExplainedInstruction> =
        tables_of(arguments)?.iter().filter_map(|table| explain(name, table, FRONTS)).collect();
    if found.is_empty() {
        return Err(unknown(name, arguments).into());
    }
    let format = format_or_suffix(arguments.format, arguments.output.as_deref())?;
    target.fill(|out| match (format, found.as_slice()) {
        (PageFormat::Json, found) => json::write(found, out),
        (PageFormat::Text, [one]) => out.write_all(text::one(one, extent).as_bytes()),
        (PageFormat::Text, found) => out.write_all(text::several(found, extent).as_bytes()),
    })?;
    Ok(Outcome::Done)
}

/// The requested tables: that of the CPU, or all.
fn tables_of(arguments: &Arguments) -> Result<Vec<Table>, Failure> {
    if let Some(name) = &arguments.table {
        return Ok(vec![tables::find("--table ", name)?.table]);
    }
    let Some(cpu) = &arguments.cpu else {
        return Ok(builtin::names().into_iter().filter_map(Table::builtin).collect());
    };
    let table = Table::for_cpu(cpu).and_then(Table::builtin);
    let unknown =
        || anyhow!("--cpu {cpu}: there is no timing table for this CPU; {}", Table::advice(cpu));
    Ok(vec![table.ok_or_else(unknown)?])
}

/// The message for an unknown name.
fn unknown(name: &str, arguments: &Arguments) -> anyhow::Error {
    let (upper, lower) = (name.to_ascii_uppercase(), name.to_ascii_lowercase());
    let all = names(FRONTS);
    if all.contains(&upper) {
        let of = arguments.cpu.as_ref().or(arguments.table.as_ref());
        let of = of.map_or(String::new(), |of| format!(" of {of}"));
        return anyhow!(
            "{upper} is not an instruction{of}: omit --cpu and --table to see which tables have it"
        );
    }
    let instructions =
        all.iter().map(|known| (strsim::jaro_winkler(known, &upper), known.as_str()));
    let codes = page::names().map(|known| (strsim::jaro_winkler(known, &lower), known));
    let near = instructions.chain(codes).filter(|(alike, _)| *alike >= ALIKE);
    let near = near.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, known)| known);
    let meant = near.map_or(String::new(), |known| format!(" did you mean {known}?"));
    anyhow!(
        "{name} is neither an instruction nor a code:{meant} `scanbound explain codes` lists the codes, `scanbound tables qnudv` the rows of a table"
    )
}

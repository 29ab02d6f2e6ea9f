//! `scanbound convert`: MINASEC-U programs from assembly to machine code and back.

use super::output::{Target, apart};
use super::sink::Sink;
use super::{Failure, Outcome, values};
use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};
use scanbound::base::code::Code;
use scanbound::base::diagnostic::Diagnostic;
use scanbound::front::input::read_one;
use scanbound::front::minasec::{Source, assembly, machine_code};
use scanbound::front::read;
use std::io::Write;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  scanbound convert program.asm -o program.hex
  scanbound convert program.hex              assembly on stdout";

/// The arguments of `convert`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A MINASEC-U program: assembly, Intel HEX, or the program memory's bytes; - for stdin
    #[arg(value_name = "PROGRAM")]
    program: PathBuf,
    /// The dialect [default: found from the content]
    #[arg(long, value_name = "NAME", value_parser = values::minasec())]
    dialect: Option<String>,
    /// What to write [default: by the suffix of the output, otherwise assembly]
    #[arg(long, value_enum)]
    to: Option<CodeFormat>,
    /// Write to a file, which appears only when it is complete
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum CodeFormat {
    /// Assembly, up to the last word that is not empty
    Asm,
    /// A listing: addresses, and the switch settings for each word
    List,
    /// Intel HEX of all 256 words
    Hex,
    /// The 256 bytes themselves
    Bin,
}

impl CodeFormat {
    fn of_name(file: &Path) -> Option<CodeFormat> {
        match file.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "asm" | "txt" | "s" => Some(CodeFormat::Asm),
            "lst" => Some(CodeFormat::List),
            "hex" | "ihx" | "ihex" => Some(CodeFormat::Hex),
            "bin" => Some(CodeFormat::Bin),
            _ => None,
        }
    }
}

/// Reads a MINASEC-U program from a file.
pub fn source(file: &Path, dialect: Option<&str>) -> Result<Source, Failure> {
    let input = read_one(file).with_context(|| format!("{} cannot be read", file.display()))?;
    let name = input.name.clone();
    let project = read(&[input], dialect)?;
    project.downcast().ok_or_else(|| {
        Failure::Input(vec![Diagnostic::file(
            Code::OtherDialect,
            &name,
            "this is a program, but not for a MINASEC-U",
            "give MINASEC-U assembly (LD X00, ST Y00), Intel HEX or the memory's 256 bytes",
        )])
    })
}

/// Converts.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let named = arguments.output.as_deref().map(CodeFormat::of_name);
    let form = match (arguments.to, named) {
        (Some(form), _) | (None, Some(Some(form))) => form,
        (None, None) => CodeFormat::Asm,
        (None, Some(None)) => {
            let help = "the suffix of --output names no form of the program: use .asm, .lst, .hex or .bin, or choose the form with --to";
            return Err(anyhow!(help).into());
        }
    };
    apart(&[&arguments.program], &[("--output", arguments.output.as_deref())])?;
    let source = source(&arguments.program, arguments.dialect.as_deref())?;
    let mut sink = Sink::open(Target::new(arguments.output.as_deref())?)?;
    let written = match form {
        CodeFormat::Asm => sink.write_all(assembly::write(&source.words).as_bytes()),
        CodeFormat::List => sink.write_all(assembly::write_listing(&source.words).as_bytes()),
        CodeFormat::Hex => sink.write_all(machine_code::write_hex(&source.words).as_bytes()),
        CodeFormat::Bin => sink.write_all(&source.bytes()),
    };
    sink.finish(written)?;
    Ok(Outcome::Done)
}

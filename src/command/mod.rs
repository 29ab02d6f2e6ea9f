//! The command line: arguments, the commands, and the exit codes (docs/exit-codes.md).

mod advise;
mod audit;
mod calibrate;
mod check;
mod compare;
mod completions;
mod convert;
mod cpus;
mod diff;
mod doctor;
mod documents;
mod emulate;
mod exit;
mod explain;
mod export;
mod facts;
mod line;
mod live;
mod options;
mod outcome;
mod output;
mod progress;
mod project_file;
mod schema;
mod serve;
mod sfc;
mod sheet;
mod show;
mod sink;
mod snet;
mod source_text;
mod tables;
mod values;
mod version;
mod watch;

pub use exit::code;
pub use outcome::{Failure, Outcome};

use clap::{ColorChoice, CommandFactory, Parser, Subcommand};

/// How long can one scan of a PLC program take at most?
///
/// Reads programs for MELSEC (GX Works2, GX Works3 and GX Developer CSV, list text), OMRON (mnemonics, .cxt), MINASEC-U
/// and flowchart PCs, and in the languages of IEC 61131-3 (PLCopen XML, text). Takes the times of instructions from a
/// timing table, and proves an upper bound on the scan time. Shows the longest scan found, and the reasons.
#[derive(Debug, Parser)]
#[command(version, long_version = version::long(), propagate_version = true, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Whether output is coloured; auto: on a terminal, unless NO_COLOR is set
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t)]
    color: ColorChoice,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Print the bound on the scan time, its parts, and the longest scan found
    Audit(audit::Arguments),
    /// Prove that no scan exceeds a limit, or show one that does
    Check(check::Arguments),
    /// Write a facts file with suggestions of what to state, where, and how much it is worth
    Facts(facts::Arguments),
    /// Write the problem of a group for a MaxSAT or SMT solver
    Export(export::Arguments),
    /// Draw rungs as ladder
    Show(show::Arguments),
    /// Analyse sequential function charts: what runs together; rewrite stored actions as explicit parallels
    #[command(long_about = sfc::ABOUT)]
    Sfc(sfc::Arguments),
    /// Work with nets for sequence control (S-nets): check them, generate code
    Snet(snet::Arguments),
    /// Compare measured scan times with the bound; the last file holds the measurements
    Compare(compare::Arguments),
    /// Compare two versions of a project: what each change costs
    Diff(diff::Arguments),
    /// List everything that prevents a bound, and what to do about it
    #[command(long_about = doctor::ABOUT)]
    Doctor(doctor::Arguments),
    /// Show which one additional fact or interlock would lower the bound most
    #[command(long_about = advise::ABOUT)]
    Advise(advise::Arguments),
    /// Compare the scan time on every CPU of the family; find the slowest that stays within a limit
    #[command(long_about = cpus::ABOUT)]
    Cpus(cpus::Arguments),
    /// Run a program scan by scan: what its devices do, and how long each scan takes
    #[command(long_about = emulate::ABOUT)]
    Emulate(emulate::Arguments),
    /// Emulate a CPU that runs a program and answers requests like a PLC
    #[command(long_about = serve::ABOUT)]
    Serve(serve::Arguments),
    /// Read a PLC's scan times while it runs, and compare them with the bound
    #[command(long_about = live::ABOUT)]
    Live(live::Arguments),
    /// Write a program that measures a CPU's instructions, and make a timing table from its results
    #[command(long_about = calibrate::ABOUT)]
    Calibrate(calibrate::Arguments),
    /// Assemble or disassemble a MINASEC-U program
    Convert(convert::Arguments),
    /// Show what is known of an instruction, or the meaning of a finding code
    #[command(long_about = explain::ABOUT)]
    Explain(explain::Arguments),
    /// List the timing tables, show one, or check your own
    Tables(tables::Arguments),
    /// Write the JSON schema of a report
    Schema(schema::Arguments),
    /// Write shell completions
    Completions(completions::Completions),
    /// Write manual pages for `man`
    Man(completions::Man),
}

/// Runs the command that the arguments name. If it fails, nothing is written to stdout, except by formats that report
/// faults.
pub fn run(cli: &Cli) -> Result<Outcome, Failure> {
    output::colour(cli.color);
    match &cli.command {
        Command::Audit(arguments) => audit::run(arguments),
        Command::Check(arguments) => check::run(arguments),
        Command::Facts(arguments) => facts::run(arguments),
        Command::Show(arguments) => show::run(arguments),
        Command::Export(arguments) => export::run(arguments),
        Command::Sfc(arguments) => sfc::run(arguments),
        Command::Snet(arguments) => snet::run(arguments),
        Command::Compare(arguments) => compare::run(arguments),
        Command::Diff(arguments) => diff::run(arguments),
        Command::Doctor(arguments) => doctor::run(arguments),
        Command::Advise(arguments) => advise::run(arguments),
        Command::Cpus(arguments) => cpus::run(arguments),
        Command::Emulate(arguments) => emulate::run(arguments),
        Command::Serve(arguments) => serve::run(arguments),
        Command::Live(arguments) => live::run(arguments),
        Command::Calibrate(arguments) => calibrate::run(arguments),
        Command::Convert(arguments) => convert::run(arguments),
        Command::Explain(arguments) => explain::run(arguments),
        Command::Tables(arguments) => tables::run(arguments),
        Command::Schema(arguments) => schema::run(arguments),
        Command::Completions(arguments) => completions::completions(arguments, Cli::command()),
        Command::Man(arguments) => completions::man(arguments, Cli::command()),
    }
}

#[cfg(test)]
mod tests {
    use super::exit::ended;
    use super::*;
    use anyhow::anyhow;
    use scanbound::base::code::Code;
    use scanbound::base::diagnostic::Diagnostic;

    fn told(failure: &Failure) -> String {
        anstream::adapter::strip_str(&failure.message()).to_string()
    }

    #[test]
    fn a_panic_is_an_internal_error() {
        let text = ended(|| panic!("the analysis is wrong")).expect_err("a panic");
        let formatted = ended(|| panic!("{} is wrong", "X0")).expect_err("a panic");
        let other = ended(|| std::panic::panic_any(7)).expect_err("a panic");
        for (failure, what) in
            [(text, "the analysis is wrong"), (formatted, "X0 is wrong"), (other, "a panic")]
        {
            assert_eq!(failure.code(), 70);
            assert_eq!(
                told(&failure),
                format!(
                    "error: internal error: {what}\nThis is a fault of scanbound and says nothing about your program. Please report it.\n"
                )
            );
        }
        assert_eq!(code(|| panic!("wrong")), 70);
    }

    #[test]
    fn an_audit_that_contradicts_itself_is_an_internal_error() {
        let failure = scanbound::audit::Failure::Internal("2 us is not 3 us".to_owned());
        assert_eq!(code(|| Err(Failure::from(failure))), 70);
    }

    #[test]
    fn every_end_has_its_code() {
        let fault = Diagnostic::file(Code::NoTime, "a.il", "wrong", "mend it");
        let input = scanbound::audit::Failure::Input(vec![fault]);
        assert_eq!(code(|| Err(Failure::from(input))), 2);
        assert_eq!(code(|| Err(Failure::from(anyhow!("no such file")))), 2);
        assert_eq!(told(&Failure::from(anyhow!("one").context("two"))), "error: two: one\n");
        let outcomes = [Outcome::Done, Outcome::Refuted, Outcome::Undecided];
        assert_eq!(outcomes.map(|outcome| code(move || Ok(outcome))), [0, 1, 3]);
    }
}

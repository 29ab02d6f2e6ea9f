//! The command line over the library.

mod command;

use clap::Parser;
use std::panic::catch_unwind;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let cli = command::Cli::parse();
    let ended = catch_unwind(|| command::run(&cli)).unwrap_or_else(|panic| {
        let what = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let what = what.or_else(|| panic.downcast_ref::<String>().cloned());
        Err(command::Failure::Internal(what.unwrap_or_else(|| "a panic".to_owned())))
    });
    match ended {
        Ok(outcome) => ExitCode::from(outcome.code()),
        Err(failure) => {
            failure.tell();
            ExitCode::from(failure.code())
        }
    }
}

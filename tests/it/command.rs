//! The command, run as a user runs it.

use std::path::Path;
use std::process::{Command, Output};

/// The command, in the directory of the repository and without colours.
pub fn binary() -> Command {
    let mut binary = Command::new(env!("CARGO_BIN_EXE_scanbound"));
    binary.current_dir(env!("CARGO_MANIFEST_DIR")).env("NO_COLOR", "1");
    binary
}

/// Runs the command in a directory.
pub fn scanbound(arguments: &[&str], directory: &Path) -> Output {
    binary().args(arguments).current_dir(directory).output().expect("the command runs")
}

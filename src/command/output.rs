//! Writes results to stdout or a file, and messages to stderr.

use super::Failure;
use anyhow::Context;
use scanbound::diagnostic::Diagnostic;
use scanbound::render;
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Writes a result to stdout, or whole to the file. A reader that has gone away is not an error.
pub fn result(text: &str, file: Option<&Path>) -> Result<(), Failure> {
    if let Some(file) = file {
        return write_whole(&anstream::adapter::strip_str(text).to_string(), file);
    }
    let mut stdout = anstream::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(anyhow::Error::from(error).context("stdout cannot be written").into())
        }
        _ => Ok(()),
    }
}

/// Writes the file whole or not at all: a new file takes the old one's place when it is complete.
fn write_whole(text: &str, file: &Path) -> Result<(), Failure> {
    let context = || format!("{} cannot be written", file.display());
    // A device or a pipe must stay what it is, and a link must keep pointing.
    let target = match file.canonicalize() {
        Ok(real) if real.is_file() => real,
        Ok(_) => {
            std::fs::write(file, text).with_context(context)?;
            return Ok(());
        }
        Err(_) => file.to_owned(),
    };
    let directory = match target.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let mut whole = new_file(directory).with_context(context)?;
    whole.write_all(text.as_bytes()).with_context(context)?;
    if let Ok(old) = target.metadata() {
        whole.as_file().set_permissions(old.permissions()).with_context(context)?;
    }
    whole.persist(&target).map_err(|error| error.error).with_context(context)?;
    Ok(())
}

#[cfg(unix)]
fn new_file(directory: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    // The user's mask takes away what it must, as for any new file.
    let usual = std::fs::Permissions::from_mode(0o666);
    tempfile::Builder::new().permissions(usual).tempfile_in(directory)
}

#[cfg(not(unix))]
fn new_file(directory: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    tempfile::NamedTempFile::new_in(directory)
}

/// Shows findings on stderr.
pub fn tell(findings: &[Diagnostic]) {
    say(&render::diagnostics(findings));
}

/// Shows one message without a place on stderr.
pub fn complain(message: &str) {
    let style = anstyle::AnsiColor::BrightRed.on_default().bold();
    say(&format!("{style}error{style:#}: {message}\n"));
}

fn say(text: &str) {
    // Nobody is left to tell if stderr is gone.
    let _ = anstream::stderr().lock().write_all(text.as_bytes());
}

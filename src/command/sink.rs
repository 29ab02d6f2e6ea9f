//! Writes long results piece by piece to a target.

use super::Failure;
use super::output::Target;
use anyhow::{Context, anyhow};
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::PathBuf;
use tempfile::NamedTempFile;

/// An open target. If it is not finished, no file appears.
pub enum Sink {
    /// Stdout.
    Stdout(BufWriter<io::Stdout>),
    /// A pipe or a device.
    Through(BufWriter<File>, PathBuf),
    /// A file that appears when it is complete.
    Whole(BufWriter<NamedTempFile>, PathBuf),
}

impl Sink {
    /// Begins to write to the target.
    pub fn open(target: Target) -> Result<Sink, Failure> {
        Ok(match target {
            Target::Stdout => Sink::Stdout(BufWriter::new(io::stdout())),
            Target::Through(file) => {
                let open = File::options().write(true).open(&file);
                let open = open.with_context(|| format!("{} cannot be written", file.display()))?;
                Sink::Through(BufWriter::new(open), file)
            }
            Target::Whole { new, file } => Sink::Whole(BufWriter::new(new), file),
        })
    }

    /// Finishes the target, with the result of writing. It is not an error if the reader of stdout has gone.
    pub fn finish(mut self, written: io::Result<()>) -> Result<(), Failure> {
        let flushed = written.and_then(|()| self.flush());
        match self {
            Sink::Stdout(_) => match flushed {
                Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                    Err(anyhow!(error).context("stdout cannot be written").into())
                }
                _ => Ok(()),
            },
            Sink::Through(_, file) => {
                Ok(flushed.with_context(|| format!("{} cannot be written", file.display()))?)
            }
            Sink::Whole(writer, file) => {
                let context = || format!("{} cannot be written", file.display());
                flushed.with_context(context)?;
                let new = writer.into_inner().map_err(|error| error.into_error());
                Target::keep(new.with_context(context)?, &file)
            }
        }
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Sink::Stdout(out) => out.write(bytes),
            Sink::Through(out, _) => out.write(bytes),
            Sink::Whole(out, _) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Sink::Stdout(out) => out.flush(),
            Sink::Through(out, _) => out.flush(),
            Sink::Whole(out, _) => out.flush(),
        }
    }
}

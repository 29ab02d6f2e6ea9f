//! Documents of several projects, written piece by piece.

use super::Failure;
use super::output::Target;
use super::sink::Sink;
use anstream::adapter::strip_bytes;
use scanbound::report::format::{Checks, Extent, Format, Project};
use std::io::{self, Write};

/// A document that is being written.
pub struct Document {
    checks: Box<dyn Checks>,
    extent: Extent,
    sink: Sink,
    is_plain: bool,
}

impl Document {
    /// Begins it.
    pub fn begin(format: &Format, extent: Extent, target: Target) -> Result<Document, Failure> {
        let colour = || anstream::AutoStream::choice(&io::stdout());
        let is_plain =
            !matches!(target, Target::Stdout) || colour() == anstream::ColorChoice::Never;
        Ok(Document { checks: (format.checks)(), extent, sink: Sink::open(target)?, is_plain })
    }

    /// Adds a project.
    pub fn add(&mut self, project: &Project<'_>) -> Result<(), Failure> {
        let mut told = Vec::new();
        let added = self.checks.add(project, self.extent, &mut told);
        self.write(added, &told)
    }

    /// Writes what is left, and closes it.
    pub fn end(mut self) -> Result<(), Failure> {
        let mut told = Vec::new();
        let ended = self.checks.end(&mut told);
        self.write(ended, &told)?;
        self.sink.finish(Ok(()))
    }

    fn write(&mut self, made: io::Result<()>, told: &[u8]) -> Result<(), Failure> {
        let stripped = self.is_plain.then(|| strip_bytes(told).into_vec());
        let written = made.and_then(|()| {
            self.sink.write_all(stripped.as_deref().unwrap_or(told))?;
            self.sink.flush()
        });
        match written {
            // It is not an error if the reader of stdout has gone.
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                Err(anyhow::anyhow!(error).context("the report cannot be written").into())
            }
            _ => Ok(()),
        }
    }
}

/// All documents that are requested.
pub struct Documents(pub Vec<Document>);

impl Documents {
    /// Whether one of them goes to stdout.
    pub fn is_shown(&self) -> bool {
        self.0.iter().any(|one| matches!(one.sink, Sink::Stdout(_)))
    }

    /// Adds a project to each.
    pub fn add(&mut self, project: &Project<'_>) -> Result<(), Failure> {
        self.0.iter_mut().try_for_each(|one| one.add(project))
    }

    /// Ends them all.
    pub fn end(self) -> Result<(), Failure> {
        self.0.into_iter().try_for_each(Document::end)
    }
}

//! Reads nets for all these commands.

use crate::command::outcome::Failure;
use anyhow::Context;
use clap::ValueEnum;
use scanbound::front::input::read_small;
use scanbound::snet::faults::faults;
use scanbound::snet::translate::assign;
use scanbound::snet::{Diagram, pnml, text};
use std::path::Path;

/// How the code gets the initial marks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum Initial {
    /// Not at all: the operator sets them
    #[default]
    LeftOut,
    /// The PLC's first scan sets them
    FirstScan,
}

/// Reads a net from a file.
pub(super) fn read(file: &Path) -> Result<Diagram, Failure> {
    let name = file.display().to_string();
    let bytes = read_small(file).with_context(|| format!("{name} cannot be read"))?;
    let input = scanbound::front::Input { name: name.clone(), bytes };
    let text = scanbound::front::decoded(&input, &[]).map_err(|fault| vec![fault])?.into_owned();
    let is_pnml = pnml::is_pnml(&text);
    Ok(if is_pnml { pnml::read(&name, &text)? } else { text::read(&name, &text)? })
}

/// Reads a net from a file and refuses one that is not valid. Assigns relays to elements without one, if requested.
pub(in crate::command) fn read_sound(file: &Path, assigns: bool) -> Result<Diagram, Failure> {
    let mut diagram = read(file)?;
    let found = faults(&diagram);
    if !found.is_empty() {
        return Err(found.into());
    }
    if assigns {
        assign(&mut diagram);
    }
    Ok(diagram)
}

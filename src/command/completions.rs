//! `scanbound completions` and `scanbound man`: shell completions and manual pages, generated from the command line's
//! description.

use super::output::Target;
use super::{Failure, Outcome};
use anyhow::Context;
use clap::{Args, Command};
use clap_complete::Shell;
use std::path::PathBuf;

const COMPLETIONS: &str = "\
Examples:
  scanbound completions bash > ~/.local/share/bash-completion/completions/scanbound
  scanbound completions zsh > ~/.zfunc/_scanbound                     a directory of $fpath
  scanbound completions fish > ~/.config/fish/completions/scanbound.fish
  scanbound completions powershell >> $PROFILE";

const MAN: &str = "\
Examples:
  scanbound man | man -l -                                            the page of scanbound
  scanbound man ~/.local/share/man/man1                               all pages, where man looks for them";

/// The arguments of `completions`.
#[derive(Debug, Args)]
#[command(after_help = COMPLETIONS)]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Writes the completions of a shell to stdout.
pub fn completions(arguments: &Completions, mut command: Command) -> Result<Outcome, Failure> {
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, name, &mut script);
    Target::Stdout.fill(|out| out.write_all(&script))?;
    Ok(Outcome::Done)
}

/// The arguments of `man`.
#[derive(Debug, Args)]
#[command(after_help = MAN)]
pub struct Man {
    /// Write a page for each command into this directory [default: the page of scanbound to stdout]
    #[arg(value_name = "DIRECTORY")]
    directory: Option<PathBuf>,
}

/// Writes the manual's pages.
pub fn man(arguments: &Man, command: Command) -> Result<Outcome, Failure> {
    match &arguments.directory {
        Some(directory) => {
            let context = || format!("the pages cannot be written to {}", directory.display());
            std::fs::create_dir_all(directory).with_context(context)?;
            clap_mangen::generate_to(command, directory).with_context(context)?;
        }
        None => {
            let mut page = Vec::new();
            clap_mangen::Man::new(command).render(&mut page).context("the page")?;
            Target::Stdout.fill(|out| out.write_all(&page))?;
        }
    }
    Ok(Outcome::Done)
}

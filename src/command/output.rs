//! Writes results to stdout or a file, and messages to stderr.

use super::{Failure, project_file};
use anstream::StripStream;
use anyhow::{Context, anyhow};
use clap::ColorChoice;
use scanbound::base::diagnostic::Diagnostic;
use scanbound::front::input::{Ignore, survey};
use scanbound::report::format::Extent;
use scanbound::report::{render, wrapped};
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;
use terminal_size::{Height, Width};

/// Sets whether output is coloured.
pub fn colour(choice: ColorChoice) {
    match choice {
        ColorChoice::Auto => anstream::ColorChoice::Auto,
        ColorChoice::Always => anstream::ColorChoice::Always,
        ColorChoice::Never => anstream::ColorChoice::Never,
    }
    .write_global();
}

/// The name for stdin among inputs, and for stdout among outputs.
const STREAM: &str = "-";

/// Refuses outputs that would overwrite inputs or each other. Each output comes with its option.
pub fn apart(read: &[&Path], written: &[(&str, Option<&Path>)]) -> Result<(), Failure> {
    let all = read.iter().flat_map(|&file| [vec![file.to_owned()], within(file)].concat());
    let read: Vec<(PathBuf, PathBuf)> = all.map(|file| (resolved(&file), file)).collect();
    let mut known: Vec<(PathBuf, &str)> = Vec::new();
    for &(option, file) in written {
        let Some(file) = file else { continue };
        let real = resolved(file);
        // Streams and devices are not overwritten.
        if file == Path::new(STREAM) || real.exists() && !real.is_file() {
            continue;
        }
        let name = file.display();
        if let Some((_, input)) = read.iter().find(|(input, _)| *input == real) {
            let input = input.display();
            return Err(anyhow!(
                "{option} {name} would overwrite {input}, which is an input: name another file"
            )
            .into());
        }
        if let Some((_, other)) = known.iter().find(|(other, _)| *other == real) {
            return Err(
                anyhow!("{option} and {other} both name {name}: name two different files").into()
            );
        }
        known.push((real, option));
    }
    Ok(())
}

/// Whether a file of this name exists and would be replaced. False for streams and devices.
pub fn is_there(file: &Path) -> bool {
    file != Path::new(STREAM) && file.is_file()
}

/// The files that are read from a directory, and its project file. Empty for a file.
fn within(directory: &Path) -> Vec<PathBuf> {
    if !directory.is_dir() {
        return Vec::new();
    }
    // Faults in them are reported when they are read.
    let found = survey(&[directory.to_owned()], &Ignore::default());
    let files = found.inputs.into_iter().map(|input| PathBuf::from(input.name));
    files.chain([directory.join(project_file::NAME)]).collect()
}

/// The path with links resolved, as far as it exists.
fn resolved(file: &Path) -> PathBuf {
    if let Ok(real) = file.canonicalize() {
        return real;
    }
    let directory = file.parent().filter(|parent| *parent != Path::new(""));
    let directory = directory.unwrap_or(Path::new(".")).canonicalize();
    match (directory, file.file_name()) {
        (Ok(directory), Some(name)) => directory.join(name),
        _ => file.to_owned(),
    }
}

/// Where a result goes. It is opened before the work begins, so that a wrong name is reported at once.
pub enum Target {
    /// Stdout.
    Stdout,
    /// A file that appears only when it is complete: a temporary file replaces it at the end.
    Whole { new: NamedTempFile, file: PathBuf },
    /// A pipe or a device, which is written directly and not replaced.
    Through(PathBuf),
}

impl Target {
    /// The file, or stdout if none is named or it is `-`.
    pub fn new(file: Option<&Path>) -> Result<Target, Failure> {
        let file = file.filter(|file| *file != Path::new(STREAM));
        let Some(file) = file else { return Ok(Target::Stdout) };
        let context = || cannot(file);
        // A link must still point to the same file.
        let real = match file.canonicalize() {
            Ok(real) if real.is_file() => real,
            Ok(real) if real.is_dir() => {
                return Err(anyhow!("it is a directory").context(context()).into());
            }
            Ok(real) => return Ok(Target::Through(real)),
            Err(_) => file.to_owned(),
        };
        let directory = match real.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        directory.metadata().with_context(context)?;
        let new = new_file(directory).map_err(|error| error.kind().into());
        let new = new.map_err(|error: std::io::Error| anyhow!(error)).with_context(context)?;
        Ok(Target::Whole { new, file: real })
    }

    /// The columns and lines of the terminal. `None` if it is not a terminal.
    pub fn page(&self) -> Option<(usize, usize)> {
        match self {
            Target::Stdout => page_of(terminal_size::terminal_size_of(std::io::stdout())),
            Target::Whole { .. } | Target::Through(_) => None,
        }
    }

    /// Replaces the old file by the complete one.
    pub fn keep(new: NamedTempFile, file: &Path) -> Result<(), Failure> {
        let context = || cannot(file);
        if let Ok(old) = file.metadata() {
            new.as_file().set_permissions(old.permissions()).with_context(context)?;
        }
        new.persist(file).map_err(|error| error.error).with_context(context)?;
        Ok(())
    }

    /// Writes a text.
    pub fn write(self, text: &str) -> Result<(), Failure> {
        self.fill(|out| out.write_all(text.as_bytes()))
    }

    /// Writes the result, without colours if it goes to a file. It is not an error if the reader of stdout has gone.
    pub fn fill(self, fill: impl Fn(&mut dyn Write) -> std::io::Result<()>) -> Result<(), Failure> {
        self.fill_with(fill, |file| Box::new(StripStream::new(file)))
    }

    /// The same for a result without colours and control characters.
    pub fn fill_escaped(
        self,
        fill: impl Fn(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<(), Failure> {
        self.fill_with(fill, |file| Box::new(file))
    }

    fn fill_with(
        self,
        fill: impl Fn(&mut dyn Write) -> std::io::Result<()>,
        to: impl Fn(File) -> Box<dyn Write>,
    ) -> Result<(), Failure> {
        let plain = |file: File| -> std::io::Result<()> {
            let mut out = BufWriter::new(to(file));
            fill(&mut out)?;
            out.flush()
        };
        match self {
            Target::Stdout => {
                let mut stdout = BufWriter::new(anstream::stdout().lock());
                match fill(&mut stdout).and_then(|()| stdout.flush()) {
                    Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                        return Err(anyhow!(error).context("stdout cannot be written").into());
                    }
                    _ => {}
                }
            }
            Target::Through(file) => {
                File::create(&file).and_then(plain).with_context(|| cannot(&file))?;
            }
            Target::Whole { new, file } => {
                let context = || cannot(&file);
                new.reopen().and_then(plain).with_context(context)?;
                return Target::keep(new, &file);
            }
        }
        Ok(())
    }
}

/// The width of messages: that of the terminal, otherwise the usual one.
pub fn width_of_stderr() -> usize {
    terminal().unwrap_or(Extent::default().width)
}

/// The columns of the terminal that messages go to. `None` if they go elsewhere.
pub fn terminal() -> Option<usize> {
    page_of(terminal_size::terminal_size_of(std::io::stderr())).map(|(width, _)| width)
}

/// The limits of the page width: columns stay readable, and lines do not become too long to read.
const WIDTHS: std::ops::RangeInclusive<usize> = 40..=160;

fn page_of(size: Option<(Width, Height)>) -> Option<(usize, usize)> {
    let (Width(width), Height(height)) = size?;
    Some((usize::from(width).clamp(*WIDTHS.start(), *WIDTHS.end()), usize::from(height)))
}

fn cannot(file: &Path) -> String {
    format!("{} cannot be written", file.display())
}

#[cfg(unix)]
fn new_file(directory: &Path) -> std::io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    // The user's umask applies, as for any new file.
    let usual = std::fs::Permissions::from_mode(0o666);
    tempfile::Builder::new().permissions(usual).tempfile_in(directory)
}

#[cfg(not(unix))]
fn new_file(directory: &Path) -> std::io::Result<NamedTempFile> {
    NamedTempFile::new_in(directory)
}

/// Shows findings on stderr.
pub fn tell(findings: &[Diagnostic]) {
    say(&render::diagnostics(findings, terminal()));
}

/// A message without a place.
pub fn complaint(message: &str) -> String {
    let style = anstyle::AnsiColor::BrightRed.on_default().bold();
    let fitted = |line: &str| match terminal() {
        Some(width) => wrapped(line, width.saturating_sub("error: ".len())).trim_end().to_owned(),
        None => line.to_owned(),
    };
    let lines: Vec<String> = message.lines().map(fitted).collect();
    format!("{style}error{style:#}: {}\n", lines.join("\n"))
}

/// Shows a text on stderr.
pub fn say(text: &str) {
    // If stderr is closed, nobody can be told.
    let _ = anstream::stderr().lock().write_all(text.as_bytes());
}

impl Failure {
    /// The message for the user.
    pub fn message(&self) -> String {
        match self {
            Failure::Input(faults) => scanbound::report::render::diagnostics(faults, terminal()),
            Failure::Usage(error) => complaint(&format!("{error:#}")),
            Failure::Internal(what) => complaint(&format!(
                "internal error: {what}\nThis is a fault of scanbound and says nothing about your program. Please report it."
            )),
        }
    }
}

//! `scanbound.toml`: the settings of a project's check, so that the command line need not repeat them.

use super::Failure;
use super::values::{self, Limit};
use anyhow::{Context, anyhow};
use scanbound::audit::verdict::{Margin, MostAssumed};
use scanbound::front::input::read_small;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Its name.
pub const NAME: &str = "scanbound.toml";

/// The keys of the file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    programs: Vec<PathBuf>,
    #[serde(default)]
    ignore: Vec<String>,
    cpu: Option<String>,
    dialect: Option<String>,
    table: Option<String>,
    facts: Option<PathBuf>,
    limit: Option<String>,
    margin: Option<String>,
    max_assumed: Option<String>,
}

/// The settings in a project's file. Paths are relative to the current directory.
#[derive(Debug, Clone)]
pub struct ProjectFile {
    /// The programs in the order of execution.
    pub programs: Vec<PathBuf>,
    /// The files to leave out.
    pub ignore: Vec<String>,
    /// The CPU.
    pub cpu: Option<String>,
    /// The dialect.
    pub dialect: Option<String>,
    /// The table's name or file.
    pub table: Option<String>,
    /// The facts file.
    pub facts: Option<PathBuf>,
    /// The limit of `check`.
    pub limit: Option<Limit>,
    /// Its margin.
    pub margin: Option<Margin>,
    /// The largest permitted share of assumed times.
    pub max_assumed: Option<MostAssumed>,
}

impl ProjectFile {
    /// Reads a file.
    pub fn read(file: &Path) -> Result<ProjectFile, Failure> {
        let name = file.display();
        let bytes = read_small(file).with_context(|| format!("{name} cannot be read"))?;
        let text = String::from_utf8(bytes).with_context(|| format!("{name} is not UTF-8"))?;
        let written: Written = toml::from_str(&text)
            .map_err(|error| anyhow!("{name}: {}", error.to_string().trim_end()))?;
        if written.programs.is_empty() {
            return Err(anyhow!("{name}: programs is empty: name files or a directory").into());
        }
        // Without `.` components, which code hosts do not resolve.
        let place = |path: &Path| -> PathBuf {
            let joined = file.parent().map_or(path.to_owned(), |at| at.join(path));
            joined.components().collect()
        };
        let wrong = |key: &str, why: String| Failure::from(anyhow!("{name}: {key}: {why}"));
        let limit = written.limit.as_deref().map(values::limit).transpose();
        let margin = written.margin.as_deref().map(str::parse).transpose();
        let max_assumed = written.max_assumed.as_deref().map(str::parse).transpose();
        // A table is a file beside the project, if there is one of that name. Otherwise it is a built-in one.
        let table = written.table.map(|table| {
            let beside = place(Path::new(&table));
            if beside.is_file() { beside.display().to_string() } else { table }
        });
        Ok(ProjectFile {
            programs: written.programs.iter().map(|path| place(path)).collect(),
            ignore: written.ignore,
            cpu: written.cpu,
            dialect: written.dialect,
            table,
            facts: written.facts.map(|path| place(&path)),
            limit: limit.map_err(|why| wrong("limit", why))?,
            margin: margin.map_err(|why| wrong("margin", why))?,
            max_assumed: max_assumed.map_err(|why| wrong("max_assumed", why))?,
        })
    }

    /// The project file in the current directory.
    pub fn here() -> Result<ProjectFile, Failure> {
        let file = Path::new(NAME);
        if !file.is_file() {
            let told = "no program is named, and there is no scanbound.toml here: name the program's files or their directory";
            return Err(anyhow!(told).into());
        }
        ProjectFile::read(file)
    }
}

/// An addition to a message about a missing setting: the project file here is not read if programs are named. Empty if
/// there is no project file.
pub fn unread() -> &'static str {
    match Path::new(NAME).is_file() {
        true => "; the scanbound.toml here is read only if no program is named",
        false => "",
    }
}

/// All project files in and below a directory, sorted by path. Hidden directories and links to directories are skipped.
pub fn all(directory: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut found = Vec::new();
    collect(directory, &mut found)?;
    found.sort();
    match found.is_empty() {
        true => Err(anyhow!("there is no scanbound.toml here or below").into()),
        false => Ok(found),
    }
}

fn collect(directory: &Path, found: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let context = || format!("{} cannot be listed", directory.display());
    for entry in std::fs::read_dir(directory).with_context(context)? {
        let entry = entry.with_context(context)?;
        let (name, kind) = (entry.file_name(), entry.file_type().with_context(context)?);
        if kind.is_dir() && !name.to_string_lossy().starts_with('.') {
            collect(&entry.path(), found)?;
        } else if name == NAME {
            let path = entry.path();
            found.push(path.strip_prefix(".").map_or(path.clone(), Path::to_owned));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound::base::time::Picos;

    fn written(text: &str) -> Result<ProjectFile, String> {
        let directory = tempfile::tempdir().expect("a directory");
        let file = directory.path().join(NAME);
        std::fs::write(&file, text).expect("written");
        ProjectFile::read(&file).map_err(|failure| match failure {
            Failure::Usage(error) => format!("{error:#}"),
            other => format!("{other:?}"),
        })
    }

    #[test]
    fn a_file_says_all_that_a_check_needs() {
        let text =
            "programs = [\"MAIN.csv\"]\ncpu = \"Q26UDV\"\nlimit = \"10ms\"\nmargin = \"20%\"\n";
        let found = written(text).expect("a project");
        assert!(found.programs[0].ends_with("MAIN.csv") && found.programs[0].is_absolute());
        assert_eq!(found.limit, Some(Limit::Time(Picos(10_000_000_000))));
        assert_eq!(found.margin.map(|margin| margin.to_string()), Some("20 %".to_owned()));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_key() {
        for (text, told) in [
            ("programs = []\n", "programs is empty"),
            ("programs = [\"a\"]\nlimt = \"1s\"\n", "limt"),
            ("programs = [\"a\"]\nlimit = \"10\"\n", "limit: give a unit"),
            ("programs = [\"a\"]\nmargin = \"10\"\n", "margin: '10' is not a percentage"),
            ("cpu = \"Q26UDV\"\n", "programs"),
        ] {
            let error = written(text).expect_err(text);
            assert!(error.contains(told), "{error}");
        }
    }
}

//! The patterns of `--ignore`.

use std::cell::Cell;
use std::path::Path;

use globset::{GlobBuilder, GlobMatcher};

/// The patterns of `--ignore`, and for each whether it has matched a file.
#[derive(Debug, Clone, Default)]
pub struct Ignore {
    patterns: Vec<Pattern>,
}

#[derive(Debug, Clone)]
struct Pattern {
    text: String,
    matcher: GlobMatcher,
    /// Whether the pattern is compared with paths instead of file names.
    path: bool,
    used: Cell<bool>,
}

impl Ignore {
    /// Parses patterns: `*`, `?`, `[a-z]`, `{a,b}`, and `**` for any directories.
    ///
    /// # Errors
    /// What is wrong with the first invalid pattern.
    pub fn parse<'p>(patterns: impl IntoIterator<Item = &'p str>) -> Result<Ignore, String> {
        let read = |text: &str| {
            let bare = text.trim_start_matches("./").trim_end_matches('/');
            let glob = GlobBuilder::new(bare)
                .literal_separator(true)
                .build()
                .map_err(|error| format!("'{text}' is not a valid pattern: {}", error.kind()))?;
            let (matcher, path) = (glob.compile_matcher(), bare.contains('/'));
            Ok(Pattern { text: text.to_owned(), matcher, path, used: Cell::new(false) })
        };
        Ok(Ignore { patterns: patterns.into_iter().map(read).collect::<Result<_, String>>()? })
    }

    /// Whether a pattern excludes a file or directory. A pattern without `/` is compared with its name, one with `/`
    /// with its path, both the full one and that below `directory`.
    pub(super) fn matches(&self, path: &Path, directory: Option<&Path>) -> bool {
        let inner = directory.and_then(|directory| path.strip_prefix(directory).ok());
        let name = path.file_name().map(Path::new);
        let hit = |pattern: &&Pattern| {
            let hit = if pattern.path {
                pattern.matcher.is_match(path)
                    || inner.is_some_and(|inner| pattern.matcher.is_match(inner))
            } else {
                name.is_some_and(|name| pattern.matcher.is_match(name))
            };
            pattern.used.set(pattern.used.get() || hit);
            hit
        };
        // Every pattern is tried, so that each match is recorded.
        self.patterns.iter().filter(hit).count() > 0
    }

    /// The patterns that have matched no file or directory so far.
    pub(super) fn unused(&self) -> impl Iterator<Item = &str> {
        self.patterns.iter().filter(|one| !one.used.get()).map(|one| one.text.as_str())
    }
}

/// A pattern that matches only this file name.
pub(super) fn escaped(name: &str) -> String {
    globset::escape(name)
}

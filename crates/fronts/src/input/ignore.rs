//! Patterns of files that the user leaves out.

use std::cell::Cell;
use std::path::Path;

use globset::{GlobBuilder, GlobMatcher};

/// Patterns, and which of them have left something out.
#[derive(Debug, Clone, Default)]
pub struct Ignore {
    patterns: Vec<Pattern>,
}

#[derive(Debug, Clone)]
struct Pattern {
    text: String,
    matcher: GlobMatcher,
    /// Whether it is held against paths, not file names.
    path: bool,
    used: Cell<bool>,
}

impl Ignore {
    /// Reads patterns: `*`, `?`, `[a-z]`, `{a,b}`, and `**` for any directories.
    ///
    /// # Errors
    /// What is wrong with the first that is no pattern.
    pub fn parse<'p>(patterns: impl IntoIterator<Item = &'p str>) -> Result<Ignore, String> {
        let read = |text: &str| {
            let bare = text.trim_start_matches("./").trim_end_matches('/');
            let glob = GlobBuilder::new(bare)
                .literal_separator(true)
                .build()
                .map_err(|error| format!("'{text}' is no pattern: {}", error.kind()))?;
            let (matcher, path) = (glob.compile_matcher(), bare.contains('/'));
            Ok(Pattern { text: text.to_owned(), matcher, path, used: Cell::new(false) })
        };
        Ok(Ignore { patterns: patterns.into_iter().map(read).collect::<Result<_, String>>()? })
    }

    /// Whether a pattern leaves a file or directory out. A pattern without `/` is held against its name, one
    /// with `/` against its path, also as seen from the directory that is named.
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
        // All are asked, so that each is known to be used.
        self.patterns.iter().filter(hit).count() > 0
    }

    /// The patterns that left nothing out.
    pub(super) fn unused(&self) -> impl Iterator<Item = &str> {
        self.patterns.iter().filter(|one| !one.used.get()).map(|one| one.text.as_str())
    }
}

/// A file's name as a pattern that means it alone.
pub(super) fn escaped(name: &str) -> String {
    globset::escape(name)
}

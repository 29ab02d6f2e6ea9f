//! `--watch`: runs a command again whenever a file that it reads has changed.

use super::options::stop_on_interrupt;
use super::output::say;
use super::{Failure, Outcome};
use anyhow::anyhow;
use clap::Args;
use notify::{RecommendedWatcher, RecursiveMode, Watcher};
use scanbound::front::input::STDIN;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime};

/// The interval for checking for Ctrl-C.
const STEP: Duration = Duration::from_millis(100);
/// The interval for checking files even without a notification, because network drives send none.
const LOOK: Duration = Duration::from_secs(2);
/// A change counts as complete when the file has not changed for this time.
const SETTLED: Duration = Duration::from_millis(250);

/// Whether a command is run again and again.
#[derive(Debug, Args)]
#[command(next_help_heading = "Report")]
pub struct WatchOptions {
    /// Run again whenever a program, the facts, the table or scanbound.toml changes; Ctrl-C ends
    #[arg(long)]
    pub watch: bool,
}

impl WatchOptions {
    /// Runs the command once, or again whenever one of its input files has changed, until Ctrl-C. Then the last run's
    /// exit code counts. Files that a run writes do not count as changes.
    pub fn run(
        &self,
        read: impl Fn() -> Vec<PathBuf>,
        written: &[PathBuf],
        run: impl Fn() -> Result<Outcome, Failure>,
    ) -> Result<Outcome, Failure> {
        if !self.watch {
            return run();
        }
        let stop = stop_on_interrupt()?;
        let mut bell = Bell::new();
        loop {
            let files = read();
            if files.iter().any(|file| file == Path::new(STDIN)) {
                return Err(anyhow!("--watch: stdin cannot be watched: name a file").into());
            }
            // The state before the run: a change during the run starts another one.
            let before = State::of(&files, written);
            bell.watch(&files);
            let code = super::exit::code_of(run());
            if !stop.load(Ordering::Relaxed) {
                say(&format!("watching {}; Ctrl-C ends\n", before.count()));
            }
            match bell.changed(&before, || State::of(&files, written), &stop) {
                Some(changed) => say(&format!("\n{} changed\n", changed.display())),
                None => return Ok(Outcome::Told(code)),
            }
        }
    }
}

/// The modification time and size of each file; for a directory, of the files in it.
#[derive(Debug, PartialEq, Eq)]
struct State(BTreeMap<PathBuf, (Option<SystemTime>, u64)>);

impl State {
    fn of(files: &[PathBuf], written: &[PathBuf]) -> State {
        let mut found = BTreeMap::new();
        let written: BTreeSet<PathBuf> =
            written.iter().filter_map(|file| file.canonicalize().ok()).collect();
        let mut put = |file: PathBuf| {
            // Unfinished reports beside the programs have names that begin with a point.
            let hidden = |name: &std::ffi::OsStr| name.as_encoded_bytes().starts_with(b".");
            if file.file_name().is_some_and(hidden)
                || file.canonicalize().is_ok_and(|file| written.contains(&file))
            {
                return;
            }
            if let Ok(data) = file.metadata() {
                found.insert(file, (data.modified().ok(), data.len()));
            }
        };
        for file in files {
            match std::fs::read_dir(file) {
                Ok(entries) => entries.flatten().for_each(|entry| put(entry.path())),
                Err(_) => put(file.clone()),
            }
        }
        State(found)
    }

    /// The number of files, as text.
    fn count(&self) -> String {
        match self.0.len() {
            1 => "1 file".to_owned(),
            count => format!("{count} files"),
        }
    }

    /// The first file that differs between the two states, or is in only one of them.
    fn first_other<'a>(&'a self, other: &'a State) -> Option<&'a Path> {
        let differs = |(file, state): &(&PathBuf, &(Option<SystemTime>, u64)), there: &State| {
            there.0.get(*file) != Some(*state)
        };
        let here = self.0.iter().find(|entry| differs(entry, other));
        let there = || other.0.iter().find(|entry| differs(entry, self));
        here.or_else(there).map(|(file, _)| file.as_path())
    }
}

/// Rings when something happens in the watched directories.
struct Bell {
    watcher: Option<RecommendedWatcher>,
    watched: BTreeSet<PathBuf>,
    rung: Receiver<()>,
}

impl Bell {
    /// If the system cannot report changes, the bell never rings, and files are checked at intervals.
    fn new() -> Bell {
        let (ring, rung) = channel();
        let watcher = notify::recommended_watcher(move |_| {
            // The receiver is gone when the program ends.
            let _ = ring.send(());
        });
        Bell { watcher: watcher.ok(), watched: BTreeSet::new(), rung }
    }

    /// Watches the directories of files, because a file may be replaced by a new one of the same name.
    fn watch(&mut self, files: &[PathBuf]) {
        let Some(watcher) = &mut self.watcher else { return };
        for file in files {
            let directory = match file.parent() {
                _ if file.is_dir() => file,
                Some(parent) if parent != Path::new("") => parent,
                _ => Path::new("."),
            };
            if self.watched.insert(directory.to_owned()) {
                // A directory that cannot be watched is checked at intervals.
                let _ = watcher.watch(directory, RecursiveMode::NonRecursive);
            }
        }
    }

    /// Waits until files have changed and then stayed unchanged. Returns the first changed file, or `None` after
    /// Ctrl-C.
    fn changed(
        &self,
        before: &State,
        now: impl Fn() -> State,
        stop: &AtomicBool,
    ) -> Option<PathBuf> {
        let mut looked = Instant::now();
        // A change during the run has already rung.
        let mut is_rung = true;
        while !stop.load(Ordering::Relaxed) {
            if is_rung || looked.elapsed() >= LOOK {
                looked = Instant::now();
                let mut state = now();
                if let Some(changed) = before.first_other(&state).map(Path::to_owned) {
                    loop {
                        sleep(SETTLED);
                        let later = now();
                        if later == state || stop.load(Ordering::Relaxed) {
                            return Some(changed).filter(|_| !stop.load(Ordering::Relaxed));
                        }
                        state = later;
                    }
                }
            }
            is_rung = match self.rung.recv_timeout(STEP) {
                Ok(()) => true,
                Err(RecvTimeoutError::Timeout) => false,
                Err(RecvTimeoutError::Disconnected) => {
                    sleep(STEP);
                    false
                }
            };
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn what_is_read_is_watched_and_what_is_written_is_not() {
        let directory = tempfile::tempdir().expect("a directory");
        let at = |name: &str| directory.path().join(name);
        let write = |name: &str, text: &str| fs::write(at(name), text).expect("written");
        write("a.il", "END\n");
        let files = [directory.path().to_owned(), at("nowhere.toml")];
        let written = [at("report.json")];
        let state = || State::of(&files, &written);
        let before = state();
        assert_eq!((before.count().as_str(), before.first_other(&state())), ("1 file", None));
        write("report.json", "{}");
        write(".tmp", "{");
        assert_eq!(before.first_other(&state()), None);
        write("b.il", "END\n");
        assert_eq!(before.first_other(&state()), Some(at("b.il").as_path()));
        fs::remove_file(at("b.il")).expect("removed");
        write("a.il", "LD X0\nEND\n");
        assert_eq!(before.first_other(&state()), Some(at("a.il").as_path()));
        fs::remove_file(at("a.il")).expect("removed");
        assert_eq!(before.first_other(&state()), Some(at("a.il").as_path()));
    }
}

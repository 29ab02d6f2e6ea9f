//! A position in the source, used by all stages from the readers to the reports.

/// A line of one of the project's files, and the PLC's step number there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Location {
    /// Index into the project's list of files. Four bytes, because every instruction has a location.
    pub file: u32,
    /// Line in the file, from 1.
    pub line: u32,
    /// The PLC's step number, if the source gives it.
    pub step: Option<u32>,
}

impl Location {
    /// The element of `files` that belongs to this location's file. `files` has one element for each file of the
    /// project, in the project's order.
    ///
    /// # Panics
    /// If `files` has too few elements.
    #[must_use]
    pub fn of<T>(self, files: &[T]) -> &T {
        &files[self.file as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_location_picks_its_file_and_sorts_as_one_reads() {
        let at = |file, line| Location { file, line, step: None };
        assert_eq!(*at(1, 3).of(&["a", "b"]), "b");
        assert!(at(0, 9) < at(1, 1) && at(0, 1) < at(0, 2));
    }
}

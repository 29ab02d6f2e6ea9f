//! Where something stands in the source: one type from the readers to the reports.

/// A line of one of a project's files, and the PLC's step there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Location {
    /// Index into the project's files. Every instruction has a location, so it is a small number.
    pub file: u32,
    /// Line in the file, from 1.
    pub line: u32,
    /// The PLC's step number, where the source gives it.
    pub step: Option<u32>,
}

impl Location {
    /// What belongs to its file, of what there is one of for each file of the project, in their order.
    ///
    /// # Panics
    /// If these are not all the files of the project.
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

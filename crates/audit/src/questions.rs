//! Writes the groups' problems and the proofs of their answers as files for other solvers.

use super::invariants::{Invariants, invariants};
use super::pipeline::{Concluded, Followed};
use scanbound_solve::{Maximum, export};

/// The file format of a group's maximisation problem for other solvers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuestionFormat {
    /// WCNF, the text format of solvers for weighted partial MaxSAT.
    Wcnf,
    /// SMT-LIB 2 with `assert-soft`, for solvers that optimise, such as Z3.
    Smt2,
}

/// A file for the user to write: a problem for a solver, or the index of such files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// The name of the file, without a directory.
    pub name: String,
    /// The content of the file.
    pub text: String,
}

/// The instruction of a charge in one line: its file, line and text.
fn describe(followed: &Followed, charge: usize) -> String {
    let program = &followed.program;
    let instruction = &program.instructions[followed.model.charges[charge].instruction];
    let file = &instruction.place.of(&program.files).name;
    format!("{file}:{} {}", instruction.place.line, instruction.text)
}

/// The text of the problem of one group, numbered from 1 as in reports. `None` if there is no such group.
#[must_use]
pub fn question(followed: &Followed, group: usize, form: QuestionFormat) -> Option<String> {
    let group = followed.groups.get(group.checked_sub(1)?)?;
    let charge = |charge| describe(followed, charge);
    Some(match form {
        QuestionFormat::Wcnf => export::wcnf(&followed.model, group, &charge),
        QuestionFormat::Smt2 => export::smt2(&followed.model, group, &charge),
    })
}

/// Two SMT-LIB 2 files for each group: that it cannot exceed its upper bound (unsatisfiable), and the scan that reaches
/// its lower bound (satisfiable). Then the files about what the groups rest on, and an index of all files.
pub fn certificates(concluded: &Concluded) -> impl Iterator<Item = File> {
    let followed = &concluded.followed;
    let Invariants { files, index } = invariants(concluded);
    let mut text = "Problems for SMT solvers (SMT-LIB 2). A solver that gives the answer listed here confirms the statement after it.\n\n".to_owned();
    for (maximum, number) in concluded.maxima.iter().zip(1..) {
        let Maximum { upper, lower, .. } = maximum;
        text += &format!(
            "group-{number}-bound.smt2: unsat. The group takes at most {}.\n",
            upper.best_text()
        );
        text += &format!(
            "group-{number}-scan.smt2: sat. There is a scan in which it takes {}.\n",
            lower.best_text()
        );
    }
    for line in index {
        text += &line;
        text.push('\n');
    }
    let index = File { name: "README.txt".to_owned(), text };
    let groups = followed.groups.iter().zip(&concluded.maxima).enumerate();
    let groups = groups.flat_map(move |(index, (group, maximum))| {
        let charge = |charge| describe(followed, charge);
        let bound = export::certificate(&followed.model, group, maximum.upper, &charge);
        let scan = export::attained(&followed.model, group, &maximum.best, maximum.lower, &charge);
        let number = index + 1;
        [
            File { name: format!("group-{number}-bound.smt2"), text: bound },
            File { name: format!("group-{number}-scan.smt2"), text: scan },
        ]
    });
    let files = files.into_iter().map(|(name, text)| File { name: name.to_owned(), text });
    groups.chain(files).chain([index])
}

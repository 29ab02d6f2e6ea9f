//! IEC 61131-3: reads programs in its languages into a syntax tree, and analyses sequential function charts.
//!
//! This crate gives the programs no meaning: a front end lowers the syntax tree for the analysis. Charts are analysed
//! here: divided into loops, selections and parallel branches ([`chart::structure`]), searched for actions that can run
//! together ([`chart::coactive`]), and rewritten so that parallel control by stored actions becomes visible
//! ([`chart::explicit`]).

pub mod ast;
mod body;
pub mod chart;
pub mod comment;
pub mod drawing;
pub mod fault;
mod lexer;
mod lists;
pub mod parse;
mod project;
pub mod show;
pub mod written;
pub mod xml;

pub use ast::same;
pub use body::{Body, Language, Named};
use comment::{Comments, without_comments};
use fault::Fault;
pub use project::{
    Connected, Pou, PouKind, Project, Section, Task, TypeDeclaration, TypeRef, Variable, getter,
    setter,
};

/// Reads a file of PLCopen XML, or program units in text. `name` is the file's name.
///
/// # Errors
/// The faults found in the file.
pub fn read(name: &str, text: &str) -> Result<Project, Vec<Fault>> {
    read_as(name, text, None)
}

/// Like [`read`], but with the rule for nested comments fixed by `comments`; `None` is the same as [`read`].
///
/// # Errors
/// The faults found in the file.
pub fn read_as(name: &str, text: &str, comments: Option<Comments>) -> Result<Project, Vec<Fault>> {
    if xml::begins(text) {
        return xml::file_as(name, text, comments);
    }
    match comments {
        Some(reading) => parse::file(name, &without_comments(text, reading)),
        None => parse::file(name, text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_one_project_are_joined() {
        let mut one = read("a.st", "PROGRAM a x := 1; END_PROGRAM").expect("a program");
        let two = "FUNCTION_BLOCK b x := 1; END_FUNCTION_BLOCK CONFIGURATION c PROGRAM i : a; END_CONFIGURATION";
        one.join(read("b.st", two).expect("a function block"));
        assert_eq!((one.pou("B").map(|pou| pou.file), one.files.len()), (Some(1), 2));
        assert_eq!(one.tasks[0].instances, [("i".to_owned(), "a".to_owned())]);
    }
}

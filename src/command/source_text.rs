//! Options for reading source text.

use clap::{Args, ValueEnum};
use scanbound::front::FRONTS;
use scanbound::front::{Encoding, Input, SourceOptions};
use scanbound::iec::comment::Comments;

/// How source text is read where the file leaves it open.
#[derive(Debug, Clone, Copy, Args)]
pub struct SourceText {
    /// How comments within comments are read in IEC 61131-3 text: flat = the first end closes the comment, nested = the
    /// end of the outer one does [default: a file in which these differ is refused]
    #[arg(long, value_enum)]
    comments: Option<CommentsName>,
    /// The encoding of files that are not UTF-8, such as windows-1252, windows-1251, shift_jis [default: found from the
    /// content]
    #[arg(long, value_name = "NAME")]
    encoding: Option<Encoding>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CommentsName {
    Flat,
    Nested,
}

impl SourceText {
    /// The settings for the fronts.
    pub fn reading(self) -> SourceOptions {
        SourceOptions {
            comments: self.comments.map(|name| match name {
                CommentsName::Flat => Comments::Flat,
                CommentsName::Nested => Comments::Nested,
            }),
        }
    }

    /// Converts files in the stated encoding to UTF-8.
    pub fn recode(self, inputs: &mut [Input]) {
        if let Some(encoding) = self.encoding {
            inputs.iter_mut().for_each(|input| input.recode(encoding, FRONTS));
        }
    }

    /// The options as command line arguments.
    pub fn written(self) -> Vec<String> {
        let comments = self.comments.map(|name| match name {
            CommentsName::Flat => "--comments flat".to_owned(),
            CommentsName::Nested => "--comments nested".to_owned(),
        });
        let encoding = self.encoding.map(|encoding| format!("--encoding {encoding}"));
        comments.into_iter().chain(encoding).collect()
    }
}

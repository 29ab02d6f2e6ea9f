//! PLCopen TC6 XML (1.01, 2.0, 2.01), also in the form of CODESYS and TwinCAT, which put some units into additional
//! data.
//!
//! Document types and entities are rejected, so that a small file cannot expand to a large one.

mod allowed;
mod body;
mod chart_settings;
mod checked;
mod condition;
mod drawing;
mod drawn;
mod execute;
mod generated;
mod generated_order;
mod interface;
mod kept;
mod limits;
mod node;
mod project;
mod reading;
pub mod write;

use super::Project;
use super::comment::Comments;
use super::fault::Fault;
use node::{Text, is_ascribed};
use roxmltree::{Document, Error};
use scanbound_base::code::Code;

/// Whether a file that begins with this text is a project in PLCopen XML.
#[must_use]
pub fn begins(text: &str) -> bool {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    text.starts_with('<')
        && text.contains("<project")
        && (text.contains("plcopen.org") || text.contains("tc6"))
        || text.starts_with('<') && text.contains("project xmlns") && text.contains("plcopen")
}

/// Reads a project. `name` is the file's name.
///
/// # Errors
/// All faults that were found in the file.
pub fn file(name: &str, text: &str) -> Result<Project, Vec<Fault>> {
    file_as(name, text, None)
}

/// Like [`file`], but with the rule for nested comments in its code fixed by `comments`, unless that is `None`.
pub(super) fn file_as(
    name: &str,
    text: &str,
    comments: Option<Comments>,
) -> Result<Project, Vec<Fault>> {
    let text = text.trim_start_matches('\u{feff}');
    limits::within(text).map_err(|fault| vec![fault])?;
    let document = Document::parse(text).map_err(|error| vec![malformed(&error)])?;
    let text = Text::new(text, &document, comments);
    if let Some(fault) = is_ascribed(&text, &document) {
        return Err(vec![fault]);
    }
    let mut reader = project::Reader::new(name, &text);
    reader.project(document.root_element());
    reader.finish()
}

fn malformed(error: &Error) -> Fault {
    let line = error.pos().row;
    let help = match error {
        Error::DtdDetected => {
            "take the document type out: PLCopen XML has none, and entities are not read"
        }
        _ => "export it again as PLCopen XML",
    };
    Fault::new(line, error.to_string()).code(Code::Xml).help(help)
}

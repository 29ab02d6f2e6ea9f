//! What an audit was made from, as JSON.

use scanbound_audit::Audit;
use schemars::JsonSchema;
use serde::Serialize;

#[derive(Serialize, JsonSchema)]
pub(super) struct Program<'a> {
    files: &'a [String],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    standby: Vec<&'a str>,
    dialect: &'a str,
    cpu: Option<&'a str>,
    instructions: usize,
    blocks: u32,
}

/// A file that was read, or the timing table.
#[derive(Serialize, JsonSchema)]
pub(super) struct Input<'a> {
    #[schemars(extend("enum" = ["program", "comments", "table", "facts"]))]
    what: &'static str,
    name: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    date: Option<&'a str>,
    sha256: &'a str,
}

pub(super) fn program(audit: &Audit) -> Program<'_> {
    Program {
        files: &audit.files,
        standby: audit.standby.iter().map(|&file| audit.files[file].as_str()).collect(),
        dialect: &audit.dialect,
        cpu: audit.cpu.as_deref(),
        instructions: audit.instructions,
        blocks: audit.blocks,
    }
}

pub(super) fn inputs(audit: &Audit) -> Vec<Input<'_>> {
    audit
        .sources
        .iter()
        .map(|one| Input {
            what: one.what.name(),
            name: &one.name,
            date: one.date.as_deref(),
            sha256: &one.sha256,
        })
        .collect()
}

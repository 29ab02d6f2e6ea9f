//! Places in the source, with the instruction that stands there.

use scanbound_base::location::Location;
use schemars::JsonSchema;
use serde::Serialize;
use std::sync::Arc;

#[derive(Serialize, JsonSchema)]
pub(super) struct UnknownPlace<'a> {
    pub file: u32,
    pub line: u32,
    pub instruction: &'a str,
}

pub(super) fn places(all: &[(Location, Arc<str>)]) -> Vec<UnknownPlace<'_>> {
    all.iter()
        .map(|(at, instruction)| UnknownPlace { file: at.file, line: at.line, instruction })
        .collect()
}

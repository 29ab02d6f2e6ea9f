//! The format.

use super::{projects, write};
use crate::format::Format;
use crate::{compare, diff};

/// JSON for programs.
pub const FORMAT: Format = Format {
    name: "json",
    about: "For programs (docs/json.md)",
    suffixes: &["json"],
    draws: false,
    escapes: true,
    audit: |audit, check, _, out| write(audit, check, out),
    compare: |found, out| out.write_all(compare::json::render(found).as_bytes()),
    diff: |found, _, out| diff::json::write(found, out),
    checks: || Box::<projects::Document>::default(),
    tells_faults: false,
};

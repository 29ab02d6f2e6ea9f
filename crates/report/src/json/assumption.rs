//! What is trusted of words and relays.

use super::place::{UnknownPlace, places};
use schemars::JsonSchema;
use serde::Serialize;
use std::ops::Not;

/// What a word holds whenever a scan starts, or which relays are never both on then.
#[derive(Serialize, JsonSchema)]
pub(super) struct Assumption<'a> {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<[i64; 2]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    values: Vec<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    most_on: Option<usize>,
    written: Vec<UnknownPlace<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    upper_without_ps: Option<u64>,
    #[serde(skip_serializing_if = "Not::not")]
    cut: bool,
}

pub(super) fn assumption(one: &scanbound_audit::Assumption) -> Assumption<'_> {
    Assumption {
        name: one.name(),
        range: one.range.map(|(low, high)| [low, high]),
        values: one.values(),
        most_on: (one.range.is_none() && one.most != 1).then_some(one.most),
        written: places(&one.written),
        upper_without_ps: one.without.map(|bound| bound.upper.0),
        cut: one.without.is_some_and(|bound| bound.cut),
    }
}

//! What a net does to the bound of its code.

use scanbound_audit::NetBound;
use scanbound_audit::net::Set;
use schemars::JsonSchema;
use serde::Serialize;

/// What a net does to the bound of its code.
#[derive(Serialize, JsonSchema)]
pub(super) struct Net<'a> {
    net: &'a str,
    without_ps: u64,
    alone_ps: u64,
    marked: Vec<&'a str>,
    kept: Vec<Kept<'a>>,
    not_used: Vec<NotUsed<'a>>,
}

/// Elements of which few are on at once, as the code keeps it.
#[derive(Serialize, JsonSchema)]
struct Kept<'a> {
    elements: &'a [String],
    relays: &'a [String],
    most_on: usize,
}

/// Elements that are never all on by the net, on which nothing rests.
#[derive(Serialize, JsonSchema)]
struct NotUsed<'a> {
    elements: &'a [String],
    relays: &'a [String],
    why: String,
}

impl<'a> Net<'a> {
    pub(super) fn of(found: &'a NetBound) -> Net<'a> {
        let kept =
            |one: &'a Set| Kept { elements: &one.elements, relays: &one.relays, most_on: one.most };
        let not_used = found.unused.iter().map(|one| NotUsed {
            elements: &one.set.elements,
            relays: &one.set.relays,
            why: one.why.to_string(),
        });
        Net {
            net: &found.net,
            without_ps: found.without.0,
            alone_ps: found.alone.0,
            marked: found.marked.iter().map(String::as_str).collect(),
            kept: found.used.iter().map(kept).collect(),
            not_used: not_used.collect(),
        }
    }
}

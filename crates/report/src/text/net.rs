//! What a net knows of its code, and what of that the bound rests on.

use super::words::{count, list};
use crate::format::Extent;
use scanbound_audit::net::Set;
use scanbound_audit::{Audit, NetBound};
use std::collections::BTreeMap;

/// So many elements or sets are named that are not used for one reason.
const MAX_NAMED: usize = 6;

/// The marks when the longest scan starts, what the code keeps of what the net knows, and what not.
pub(super) fn section(audit: &Audit, extent: Extent) -> String {
    let Some(found) = &audit.net else { return String::new() };
    let mut lines = vec![match found.marked.is_empty() {
        true => "no box that the longest scan depends on is marked when it starts".to_owned(),
        false => format!("marked when the longest scan starts: {}", found.marked.join(", ")),
    }];
    let (places, others): (Vec<&Set>, Vec<&Set>) =
        found.used.iter().partition(|set| set.is_of_places);
    lines.extend(places.iter().take(extent.values).map(|set| kept(set)));
    let more = |n: usize, what: [&str; 2]| {
        let told = format!("{} that every scan keeps: JSON lists them", count(n, what[0], what[1]));
        (n > 0).then_some(told)
    };
    let further = places.len().saturating_sub(extent.values);
    lines.extend(more(further, ["further set of boxes", "further sets of boxes"]));
    lines.extend(more(others.len(), ["set with transitions", "sets with transitions"]));
    lines.extend(dropped(found));
    let title = format!("What net {} knows of the code's relays", found.net);
    list(&title, &lines, extent)
}

fn kept(set: &Set) -> String {
    let of = |(name, relay): (&String, &String)| format!("{name} ({relay})");
    let names: Vec<String> = set.elements.iter().zip(&set.relays).map(of).collect();
    let names = names.join(", ");
    match set.most {
        1 => format!("one at most, as every scan keeps it: {names}"),
        _ => format!("never all, as every scan keeps it: {names}"),
    }
}

/// What is not used, by the reason, with the elements or sets that it is told of.
fn dropped(found: &NetBound) -> Vec<String> {
    let mut by_reason: BTreeMap<String, (usize, Vec<String>)> = BTreeMap::new();
    for one in &found.unused {
        let of = one.why.element().map_or_else(|| one.set.elements.join(" with "), str::to_owned);
        let (sets, names) = by_reason.entry(one.why.reason()).or_default();
        *sets += 1;
        if !names.contains(&of) {
            names.push(of);
        }
    }
    let told = |(why, (sets, names)): (String, (usize, Vec<String>))| {
        let more = names.len().saturating_sub(MAX_NAMED);
        let mut named = names.into_iter().take(MAX_NAMED).collect::<Vec<_>>().join(", ");
        if more > 0 {
            named += &format!(" and {more} more");
        }
        format!("not used: {}, for {named}: {why}", count(sets, "set", "sets"))
    };
    by_reason.into_iter().map(told).collect()
}

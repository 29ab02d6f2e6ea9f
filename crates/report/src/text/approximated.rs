//! What is over-approximated, and where.

use super::words::{capped, count, heading, item, more, place, wrapped};
use crate::format::{Detail, Extent};
use scanbound_audit::{ApproximationUse, Audit};
use std::collections::BTreeMap;

/// So many kinds are told, and of each so many places, unless all are asked for.
const MAX_KINDS: usize = 6;
const MAX_PLACES: usize = 3;

pub(super) fn approximations(audit: &Audit, extent: Extent) -> String {
    if audit.approximations.is_empty() {
        return String::new();
    }
    // The same said of several instructions is said once: of `it`.
    let mut kinds: Vec<(String, Vec<&ApproximationUse>)> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    for one in &audit.approximations {
        let mnemonic = mnemonic(one);
        let what = one.what.to_string();
        let mut kind = String::with_capacity(what.len());
        for (index, word) in what.split(' ').enumerate() {
            kind.push_str(if index > 0 { " " } else { "" });
            kind.push_str(if word == mnemonic { "it" } else { word });
        }
        let at = *known.entry(kind.clone()).or_insert_with(|| {
            kinds.push((kind, Vec::new()));
            kinds.len() - 1
        });
        kinds[at].1.push(one);
    }
    kinds.sort_by_key(|(_, uses)| std::cmp::Reverse(uses.len()));
    let title = format!(
        "Over-approximated at {}: the bound can only be too high by these",
        count(audit.approximations.len(), "place", "places")
    );
    let is_full = extent.detail == Detail::Full;
    let shown = if is_full { kinds.len() } else { extent.values.min(MAX_KINDS) };
    let mut text = heading(&title, extent);
    for (kind, uses) in kinds.iter().take(shown) {
        let alone = uses.iter().all(|one| mnemonic(one) == mnemonic(uses[0]));
        let what = if alone { &uses[0].what.to_string() } else { kind };
        let entries: Vec<String> = uses
            .iter()
            .map(|one| match alone {
                true => place(audit, one.at),
                false => format!("{} {}", mnemonic(one), place(audit, one.at)),
            })
            .collect();
        text += &item(2, what, extent);
        let most = if is_full { usize::MAX } else { MAX_PLACES };
        text += &wrapped("      ", &capped(&entries, most), extent);
    }
    text + &more(kinds.len(), shown, "kind", "kinds")
}

fn mnemonic(one: &ApproximationUse) -> &str {
    one.instruction.split(' ').next().unwrap_or_default()
}

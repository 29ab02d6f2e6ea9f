//! Nets as PNML (ISO/IEC 15909-2), place/transition nets: what other tools for Petri nets read and write.
//!
//! Boxes, timers, counters and outer gates are places, all of capacity 1: each place to which a transition leads also inhibits
//! it. Permissive gates are read arcs, inhibiting ones inhibitor arcs, arcs to an emergency stop reset arcs. What such nets do
//! not have (addresses, timers, counters, pages of gates, arbiters) stands in elements for this tool; a net without them is
//! read as boxes and transitions.

mod node;
mod read;
mod write;

pub use read::read;
pub use write::write;

/// What this tool's own elements name.
const TOOL: &str = "scanbound";
const VERSION: &str = "1";
/// The grammar, and the type of nets.
const GRAMMAR: &str = "http://www.pnml.org/version-2009/grammar/pnml";
const TYPE: &str = "http://www.pnml.org/version-2009/grammar/ptnet";

/// Whether a text is PNML.
#[must_use]
pub fn is_pnml(text: &str) -> bool {
    let head: String = text.chars().take(2000).collect();
    head.trim_start_matches('\u{feff}').trim_start().starts_with('<') && head.contains("<pnml")
}

#[cfg(test)]
mod tests;

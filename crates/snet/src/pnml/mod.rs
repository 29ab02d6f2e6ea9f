//! Nets as PNML (ISO/IEC 15909-2), place/transition nets, the exchange format of Petri net tools.
//!
//! Boxes, timers, counters and outer gates are places with capacity 1: a transition's output places also inhibit it.
//! Permissive gates are read arcs, inhibiting gates are inhibitor arcs, arcs to an emergency stop are reset arcs.
//! Everything else (addresses, timers, counters, pages of gates, arbiters) is in tool-specific elements; a net without
//! them is read as boxes and transitions.

mod node;
mod read;
mod write;

pub use read::read;
pub use write::write;

/// The name in tool-specific elements.
const TOOL: &str = "scanbound";
const VERSION: &str = "1";
/// The namespace of PNML, and the type of the nets.
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

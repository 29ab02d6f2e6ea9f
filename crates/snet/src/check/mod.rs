//! Analyses a net: structure, reachable states, deadlocks, and differences between the net and its code.

mod code;
mod markings;
mod step;
pub mod structure;

pub(super) use code::sets;
pub use code::{Cause, Code, Divergence, Start};
pub use markings::{Dead, Held, Markings};
pub use step::{Options, Step};

use super::Diagram;
use super::rules::{Rules, State};
use structure::Structure;

/// The result of the analysis.
#[derive(Debug)]
pub struct Check {
    /// Structural properties.
    pub structure: Structure,
    /// The reachable states by the net's rule.
    pub markings: Markings,
    /// The behaviour of the code.
    pub code: Code,
}

impl Check {
    /// Whether no error was found: there is no deadlock except after an emergency stop, and the code follows the net in
    /// all states that were explored.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.markings.dead.iter().all(|dead| dead.is_after_stop)
            && self.markings.never.is_empty()
            && self.code.divergences.is_empty()
            && self.code.is_left_out.is_empty()
            && self.code.undecided.is_empty()
    }
}

/// Analyses a net that has no structural errors.
#[must_use]
pub fn check(diagram: &Diagram, options: Options) -> Check {
    let rules = Rules::new(diagram);
    Check {
        structure: structure::structure(diagram),
        markings: markings::explore(diagram, &rules, options.limit),
        code: code::explore(diagram, &rules, options),
    }
}

/// The marked places of a state as a text: `B01, TM01 (over), CN01 (3 of 5)`.
#[must_use]
pub fn marking(diagram: &Diagram, rules: &Rules, state: &State) -> String {
    let told = (0..diagram.places.len()).filter_map(|place| {
        let name = diagram.place_name(place);
        match diagram.places[place].kind {
            super::Kind::Counter { count, .. } => {
                let counted = rules.count(state, place);
                (counted > 0).then(|| format!("{name} ({counted} of {count})"))
            }
            _ if rules.is_over(state, place) => Some(format!("{name} (over)")),
            _ => rules.is_marked(state, place).then_some(name),
        }
    });
    let told: Vec<String> = told.collect();
    if told.is_empty() { "nothing".to_owned() } else { told.join(", ") }
}

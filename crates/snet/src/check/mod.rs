//! Studies a net: what its arcs tell, what it can come to, where it stops, and where its code does something else.

mod code;
mod markings;
mod step;
pub mod structure;

pub(super) use code::sets;
pub use code::{Cause, Code, Parting, Start};
pub use markings::{Dead, Held, Markings};
pub use step::{Options, Step};

use super::Diagram;
use super::rules::{Rules, State};
use structure::Structure;

/// All that is known of a net.
#[derive(Debug)]
pub struct Check {
    /// What its arcs tell.
    pub structure: Structure,
    /// What it can come to by its own rule.
    pub markings: Markings,
    /// What its code does.
    pub code: Code,
}

impl Check {
    /// Whether nothing is wrong: no deadlock but behind an emergency stop, and the code follows the net, as far as was
    /// looked.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.markings.dead.iter().all(|dead| dead.is_after_stop)
            && self.markings.never.is_empty()
            && self.code.partings.is_empty()
            && self.code.is_left_out.is_empty()
            && self.code.undecided.is_empty()
    }
}

/// Studies a net that has no faults.
#[must_use]
pub fn check(diagram: &Diagram, options: Options) -> Check {
    let rules = Rules::new(diagram);
    Check {
        structure: structure::structure(diagram),
        markings: markings::explore(diagram, &rules, options.limit),
        code: code::explore(diagram, &rules, options),
    }
}

/// What is marked in a state, in words: `B01, TM01 (over), CN01 (3 of 5)`.
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

//! A net as it is drawn: its elements on their pages, each with its line in the source.

use super::address::Address;

/// Where an element's middle is drawn on its page, in units of the drawing's grid, to the right and down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Point {
    /// To the right.
    pub x: i32,
    /// Down.
    pub y: i32,
}

/// A page of the drawing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Page {
    /// Its name.
    pub name: String,
    /// Where it stands in the source, from 1.
    pub line: u32,
}

/// What places, transitions and gates have alike.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Head {
    /// The name, unlike all others of its page (of all outer gates).
    pub name: String,
    /// Its page, an index into [`Diagram::pages`].
    pub page: usize,
    /// Where it stands in the source, from 1.
    pub line: u32,
    /// The relay that the code writes for it; of an outer gate, that it reads.
    pub address: Option<Address>,
    /// Where it is drawn, if the source says so.
    pub at: Option<Point>,
}

/// What a place is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A box.
    Box,
    /// A timer module: a box (b) and the timer (P) that runs while it is marked.
    Timer {
        /// The timer's number.
        number: Option<u16>,
        /// Its set value, in tenths of a second.
        tenths: u16,
    },
    /// A counter module: it counts (c) up to its set value and is marked then (bc).
    Counter {
        /// The counter's number.
        number: Option<u16>,
        /// Its set value.
        count: u16,
    },
}

/// A box, a timer module or a counter module: what arcs join with transitions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Name, page, line, address: the relay of a box, of a timer's box (b), of a counter's c.
    pub head: Head,
    /// What it is.
    pub kind: Kind,
    /// Whether it is marked at first.
    pub is_marked: bool,
}

/// A transition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transition {
    /// Name, page, line and address.
    pub head: Head,
    /// Whether it is an emergency-stop transition: it fires when any of its places is marked, and takes all their marks.
    pub is_stop: bool,
}

/// Which way an arc leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// From a place to a transition, which takes the mark.
    Into,
    /// From a transition to a place, which gets a mark.
    OutOf,
    /// From a place to an emergency-stop transition (drawn with `*`).
    Stop,
}

/// An arc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arc {
    /// An index into [`Diagram::places`].
    pub place: usize,
    /// An index into [`Diagram::transitions`].
    pub transition: usize,
    /// Which way it leads.
    pub direction: Direction,
    /// Where it stands in the source.
    pub line: u32,
}

/// What a gate looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Signal {
    /// An inner gate: of a box whether it is marked, of a timer whether its time is over (P), of a counter whether it has
    /// counted up (bc). An index into [`Diagram::places`].
    Place(usize),
    /// An outer gate: an index into [`Diagram::outers`].
    Outer(usize),
}

/// A gate at a transition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gate {
    /// An index into [`Diagram::transitions`].
    pub transition: usize,
    /// What it looks at.
    pub signal: Signal,
    /// Whether it holds the transition back while it is 1 (inhibiting); else while it is 0 (permissive).
    pub is_inhibiting: bool,
    /// Where it stands in the source.
    pub line: u32,
}

/// A signal from outside the net, one for all pages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outer {
    /// Name, page, line and address.
    pub head: Head,
}

/// An arbiter: of these transitions, in this order, only the first that can fire does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arbiter {
    /// Name, page and line; it has no address.
    pub head: Head,
    /// Indices into [`Diagram::transitions`], the one that goes first in front.
    pub transitions: Vec<usize>,
}

/// A net as it is drawn.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Diagram {
    /// The file it was read from, as messages name it.
    pub file: String,
    /// The net's name; may be empty.
    pub name: String,
    /// Pages; there is one at least.
    pub pages: Vec<Page>,
    /// Signals from outside.
    pub outers: Vec<Outer>,
    /// Boxes, timers and counters.
    pub places: Vec<Place>,
    /// Transitions, emergency-stop transitions among them.
    pub transitions: Vec<Transition>,
    /// Arcs. Those of one transition stand in the order in which the source has them.
    pub arcs: Vec<Arc>,
    /// Gates. Those of one transition stand in the order in which the source has them.
    pub gates: Vec<Gate>,
    /// Arbiters.
    pub arbiters: Vec<Arbiter>,
}

impl Diagram {
    /// The places at the other ends of a transition's arcs of one direction.
    pub fn places_of(
        &self,
        transition: usize,
        direction: Direction,
    ) -> impl Iterator<Item = usize> + '_ {
        let own = move |arc: &&Arc| arc.transition == transition && arc.direction == direction;
        self.arcs.iter().filter(own).map(|arc| arc.place)
    }

    /// The transitions at the other ends of a place's arcs of one direction.
    pub fn transitions_of(
        &self,
        place: usize,
        direction: Direction,
    ) -> impl Iterator<Item = usize> + '_ {
        let own = move |arc: &&Arc| arc.place == place && arc.direction == direction;
        self.arcs.iter().filter(own).map(|arc| arc.transition)
    }

    /// The gates at a transition.
    pub fn gates_of(&self, transition: usize) -> impl Iterator<Item = &Gate> + '_ {
        self.gates.iter().filter(move |gate| gate.transition == transition)
    }

    /// A place's name, with its page in front where there are several.
    #[must_use]
    pub fn place_name(&self, place: usize) -> String {
        self.full_name(&self.places[place].head)
    }

    /// A transition's name, with its page in front where there are several.
    #[must_use]
    pub fn transition_name(&self, transition: usize) -> String {
        self.full_name(&self.transitions[transition].head)
    }

    /// A signal's name; that of an outer gate never has a page.
    #[must_use]
    pub fn signal_name(&self, signal: Signal) -> String {
        match signal {
            Signal::Place(place) => self.place_name(place),
            Signal::Outer(outer) => self.outers[outer].head.name.clone(),
        }
    }

    fn full_name(&self, head: &Head) -> String {
        if self.pages.len() == 1 {
            return head.name.clone();
        }
        format!("{}.{}", self.pages[head.page].name, head.name)
    }

    /// The same without files and lines: what two texts of one net have in common.
    #[must_use]
    pub fn without_lines(&self) -> Diagram {
        let mut bare = self.clone();
        bare.file.clear();
        bare.pages.iter_mut().for_each(|page| page.line = 0);
        bare.outers.iter_mut().for_each(|one| one.head.line = 0);
        bare.places.iter_mut().for_each(|one| one.head.line = 0);
        bare.transitions.iter_mut().for_each(|one| one.head.line = 0);
        bare.arbiters.iter_mut().for_each(|one| one.head.line = 0);
        bare.arcs.iter_mut().for_each(|arc| arc.line = 0);
        bare.gates.iter_mut().for_each(|gate| gate.line = 0);
        bare.arcs.sort_by_key(|arc| (arc.transition, arc.direction));
        bare.gates.sort_by_key(|gate| gate.transition);
        bare
    }
}

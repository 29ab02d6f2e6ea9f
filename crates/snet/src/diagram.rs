//! A net as it is drawn: elements on pages, each with its source line.

use super::address::Address;

/// The centre of an element on its page, in units of the drawing grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Point {
    /// Distance to the right.
    pub x: i32,
    /// Distance down.
    pub y: i32,
}

/// A page of the drawing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Page {
    /// Its name.
    pub name: String,
    /// Its source line, from 1.
    pub line: u32,
}

/// What places, transitions and outer gates have in common.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Head {
    /// The name; it is unique on its page (for outer gates, among all outer gates).
    pub name: String,
    /// Its page, an index into [`Diagram::pages`].
    pub page: usize,
    /// The source line, from 1.
    pub line: u32,
    /// The relay that the code writes for the element; for an outer gate, the relay that the code reads.
    pub address: Option<Address>,
    /// The drawing position, if the source has one.
    pub at: Option<Point>,
}

/// The type of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A box.
    Box,
    /// A timer module: a box (b), and a timer (P) that runs while the box is marked.
    Timer {
        /// The timer's number.
        number: Option<u16>,
        /// Its set value, in tenths of a second.
        tenths: u16,
    },
    /// A counter module: it counts (c) up to its set value, and is then marked (bc).
    Counter {
        /// The counter's number.
        number: Option<u16>,
        /// Its set value.
        count: u16,
    },
}

/// A box, timer module or counter module. Arcs connect places with transitions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Name, page, line and address. The address is the relay of the box, of the timer's box (b), or of the counter's
    /// c.
    pub head: Head,
    /// Its type.
    pub kind: Kind,
    /// Whether it has an initial mark.
    pub is_marked: bool,
}

/// A transition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transition {
    /// Name, page, line and address.
    pub head: Head,
    /// Whether it is an emergency-stop transition: it fires if any of its places is marked, and removes all their
    /// marks.
    pub is_stop: bool,
}

/// The direction of an arc.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// From a place to a transition, which removes the mark.
    Into,
    /// From a transition to a place, which receives a mark.
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
    /// Its direction.
    pub direction: Direction,
    /// Its source line.
    pub line: u32,
}

/// The signal that a gate reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Signal {
    /// An inner gate, an index into [`Diagram::places`]: of a box whether it is marked, of a timer whether it has timed
    /// out (P), of a counter whether it has counted up (bc).
    Place(usize),
    /// An outer gate: an index into [`Diagram::outers`].
    Outer(usize),
}

/// A gate at a transition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gate {
    /// An index into [`Diagram::transitions`].
    pub transition: usize,
    /// The signal that it reads.
    pub signal: Signal,
    /// Whether it blocks the transition while the signal is 1 (inhibiting); otherwise it blocks while the signal is 0
    /// (permissive).
    pub is_inhibiting: bool,
    /// Its source line.
    pub line: u32,
}

/// A signal from outside the net. It belongs to all pages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outer {
    /// Name, page, line and address.
    pub head: Head,
}

/// An arbiter: only the first of these transitions that can fire does so.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arbiter {
    /// Name, page and line; it has no address.
    pub head: Head,
    /// Indices into [`Diagram::transitions`], highest priority first.
    pub transitions: Vec<usize>,
}

/// A net as it is drawn.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Diagram {
    /// The name of the source file.
    pub file: String,
    /// The net's name; may be empty.
    pub name: String,
    /// The pages, at least one.
    pub pages: Vec<Page>,
    /// Signals from outside.
    pub outers: Vec<Outer>,
    /// Boxes, timers and counters.
    pub places: Vec<Place>,
    /// Transitions, including emergency stops.
    pub transitions: Vec<Transition>,
    /// Arcs; those of one transition are in source order.
    pub arcs: Vec<Arc>,
    /// Gates; those of one transition are in source order.
    pub gates: Vec<Gate>,
    /// Arbiters.
    pub arbiters: Vec<Arbiter>,
}

impl Diagram {
    /// The places that are connected to a transition by arcs of this direction.
    pub fn places_of(
        &self,
        transition: usize,
        direction: Direction,
    ) -> impl Iterator<Item = usize> + '_ {
        let own = move |arc: &&Arc| arc.transition == transition && arc.direction == direction;
        self.arcs.iter().filter(own).map(|arc| arc.place)
    }

    /// The transitions that are connected to a place by arcs of this direction.
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

    /// The name of a place, with its page if there are several pages.
    #[must_use]
    pub fn place_name(&self, place: usize) -> String {
        self.full_name(&self.places[place].head)
    }

    /// The name of a transition, with its page if there are several pages.
    #[must_use]
    pub fn transition_name(&self, transition: usize) -> String {
        self.full_name(&self.transitions[transition].head)
    }

    /// The name of a signal; an outer gate never has a page.
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

    /// The net without file name and lines, to compare two sources.
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

//! S-nets: Petri nets for sequence control, with gates, timers, counters and emergency stops; read, checked, translated.
//!
//! A [`Diagram`] is a net as it is drawn: boxes, transitions, arcs and gates on pages, with addresses for the code that is
//! made of them. [`text`] reads and writes it as text; [`faults`] tells what of it cannot be, with the line.
//! The net and its rules follow Nishimi and Kinoshita's paper; `docs/snet.md` says how.

pub mod address;
pub mod check;
mod diagram;
pub mod faults;
pub mod knowledge;
pub mod monitor;
pub mod picture;
pub mod pnml;
pub mod rules;
mod scan;
pub mod simulation;
pub mod stimulus;
pub mod text;
pub mod translate;
pub mod verify;

pub use diagram::{
    Arbiter, Arc, Diagram, Direction, Gate, Head, Kind, Outer, Page, Place, Point, Signal,
    Transition,
};

#[cfg(test)]
mod tests;

//! S-nets: Petri nets for sequence control, with gates, timers, counters and emergency stops; read, checked,
//! translated.
//!
//! A [`Diagram`] is a net as it is drawn: boxes, transitions, arcs and gates on pages, with the addresses for its code.
//! [`text`] reads and writes it as text; [`faults`] reports errors in its structure. The net and its rules follow the
//! paper by Nishimi and Kinoshita; `docs/snet.md` explains them.

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

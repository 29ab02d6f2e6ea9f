//! CPUs that run programs: a MINASEC-U clock by clock, any CPU by a table's times, and programs that measure real ones.

pub mod calibrate;
mod devices;
pub mod emulated;
pub mod minasec;
pub mod simulation;
mod stimulus;

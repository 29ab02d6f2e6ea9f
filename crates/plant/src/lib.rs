//! CPUs that run programs: a MINASEC-U clock by clock, any CPU by a table's times, and programs that measure real ones.

pub mod calibrate;
pub mod emulated;
pub mod minasec;

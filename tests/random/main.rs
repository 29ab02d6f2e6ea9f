//! Random programs of every dialect: bounds against interpreters, and damaged inputs.

mod closing;
#[path = "../it/command.rs"]
#[allow(dead_code)] // the other tests use more of it
mod command;
mod hostile;
mod iec_drawn_random;
mod iec_object_random;
mod iec_random;
#[path = "../it/measured.rs"]
mod measured;
mod melsec_soundness;
mod narrowed;
mod random_counts;
mod random_facts;
mod random_lists;
mod random_omron;
mod random_programs;
mod random_values;
mod snet_random;

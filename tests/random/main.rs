//! Random programs of every dialect: bounds against interpreters, and damaged inputs.

#[path = "../common/mod.rs"]
mod common;

mod closing;
mod hostile;
mod iec_drawn_random;
mod iec_object_random;
mod iec_random;
mod melsec_soundness;
mod narrowed;
mod random_counts;
mod random_facts;
mod random_lists;
mod random_omron;
mod random_programs;
mod random_values;
mod snet_random;

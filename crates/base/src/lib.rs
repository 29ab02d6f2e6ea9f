//! What every stage stands on: exact times, findings with their places, how long all may take, what the user states,
//! columns of tables, checksums of files.

pub mod budget;
pub mod checksum;
pub mod code;
pub mod column;
pub mod diagnostic;
pub mod facts;
pub mod location;
pub mod near;
pub mod ring;
pub mod spoken;
pub mod time;

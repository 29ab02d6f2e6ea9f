//! What all other crates use: exact times, findings with their places, the time budget, the user's facts, columns of
//! tables, checksums of files.

pub mod budget;
pub mod checksum;
pub mod code;
pub mod column;
pub mod diagnostic;
pub mod facts;
pub mod location;
pub mod suggestion;
pub mod time;
pub mod time_text;
pub mod word_interval;

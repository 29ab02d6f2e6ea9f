//! Talks with PLCs and answers as one: frames of SLMP, FINS and Host Link, and the connections that carry them.
//!
//! Frames are pure functions from bytes to bytes (`slmp`, `fins`, `hostlink`), for both ends. [`client`] asks over a
//! connection, and only reads: it has no frame that writes. [`server`] answers for an emulated CPU. [`registers`] says
//! where a CPU keeps its scan times.

pub mod client;
pub mod device;
mod fault;
pub mod fins;
pub mod hostlink;
pub mod registers;
pub mod server;
pub mod slmp;
mod transport;

pub use fault::Fault;

/// What a CPU is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It runs its program.
    Run,
    /// It does not.
    Stop,
}

/// The memory and the state of a CPU that a server answers for.
pub trait Memory {
    /// Words from a device on, sixteen bits a word where the area holds bits; none where there are no such devices.
    fn words(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<u16>>;

    /// Bits from a device on; none where there are no such devices, or words.
    fn bits(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<bool>>;

    /// What it is doing.
    fn state(&mut self) -> State;

    /// The CPU's name.
    fn model(&mut self) -> String;

    /// The mean, the largest and the least scan time, in tenths of a millisecond.
    fn scan_times(&mut self) -> [u32; 3];
}

/// How far the beginning of a stream of bytes is a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// More bytes are needed.
    More,
    /// The frame has so many bytes.
    Frame(usize),
    /// No frame begins so.
    Garbage,
}

//! Reads PLCs and serves emulated ones: frames of SLMP, FINS and Host Link, and the connections that carry them.
//!
//! Pure functions encode and decode frames (`slmp`, `fins`, `hostlink`), for both ends. [`client`] sends requests over
//! a connection; there is no request that writes. [`server`] answers for an emulated CPU. [`registers`] lists
//! where a CPU stores its scan times. [`station`] reads a unit on a serial line and recovers when frames are
//! lost; [`pty`] is a serial line between two programs.

pub mod client;
pub mod device;
mod fault;
pub mod fins;
pub mod hostlink;
#[cfg(unix)]
pub mod pty;
pub mod registers;
pub mod serial;
pub mod server;
pub mod slmp;
pub mod station;
mod transport;

pub use fault::Fault;

/// The state of a CPU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It runs its program.
    Run,
    /// It does not run its program.
    Stop,
}

/// The timer and counter instructions whose set values can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coil {
    /// A timer in tenths of a second.
    Timer,
    /// A timer in hundredths of a second.
    FastTimer,
    /// A retentive timer.
    TotalizingTimer,
    /// A counter that counts down.
    Counter,
    /// A counter that counts up and down.
    ReversibleCounter,
}

impl Coil {
    const NAMES: [(Coil, &'static str); 5] = [
        (Coil::Timer, "TIM"),
        (Coil::FastTimer, "TIMH"),
        (Coil::TotalizingTimer, "TTIM"),
        (Coil::Counter, "CNT"),
        (Coil::ReversibleCounter, "CNTR"),
    ];

    /// Its mnemonic.
    #[must_use]
    pub fn name(self) -> &'static str {
        Coil::NAMES.iter().find(|(coil, _)| *coil == self).map_or("", |(_, name)| name)
    }

    /// The instruction with this mnemonic.
    #[must_use]
    pub fn named(name: &str) -> Option<Coil> {
        Coil::NAMES.iter().find(|(_, one)| *one == name).map(|(coil, _)| *coil)
    }
}

/// A set value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// A number.
    Number(u16),
    /// The word that holds it, in BCD.
    Word {
        /// Its area.
        area: &'static str,
        /// Its number.
        index: u32,
    },
}

/// The memory and the state of a CPU that a server answers for.
pub trait Memory {
    /// Words from a device on, sixteen bits a word if the area holds bits. `None` if these devices do not exist.
    fn words(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<u16>>;

    /// Bits from a device on. `None` if these devices do not exist or are words.
    fn bits(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<bool>>;

    /// The set value of the first such instruction from a program address on. `None` if there is no such instruction.
    fn setting(&mut self, _coil: Coil, _number: u32, _from: u32) -> Option<Setting> {
        None
    }

    /// The state of the CPU.
    fn state(&mut self) -> State;

    /// The CPU's name.
    fn model(&mut self) -> String;

    /// The mean, the largest and the smallest scan time, in tenths of a millisecond.
    fn scan_times(&mut self) -> [u32; 3];
}

/// Whether a stream of bytes begins with a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// More bytes are needed.
    More,
    /// The first frame has this many bytes.
    Frame(usize),
    /// The bytes do not begin a frame.
    Garbage,
}

//! Talks with PLCs and answers as one: frames of SLMP, FINS and Host Link, and the connections that carry them.
//!
//! Frames are pure functions from bytes to bytes (`slmp`, `fins`, `hostlink`), for both ends. [`client`] asks over a
//! connection, and only reads: it has no frame that writes. [`server`] answers for an emulated CPU. [`registers`] says
//! where a CPU keeps its scan times. [`station`] asks a unit on a serial line, and finds its way back when frames are
//! lost; [`pty`] is such a line without wires.

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

/// What a CPU is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It runs its program.
    Run,
    /// It does not.
    Stop,
}

/// The instructions that time and count, as far as they have set values that can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coil {
    /// A timer in tenths of a second.
    Timer,
    /// A timer in hundredths of a second.
    FastTimer,
    /// A timer that adds up.
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

    /// The one with this mnemonic.
    #[must_use]
    pub fn named(name: &str) -> Option<Coil> {
        Coil::NAMES.iter().find(|(_, one)| *one == name).map(|(coil, _)| *coil)
    }
}

/// A set value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// The number.
    Number(u16),
    /// The word that holds it, in decimal digits.
    Word {
        /// Its area.
        area: &'static str,
        /// Its number.
        index: u32,
    },
}

/// The memory and the state of a CPU that a server answers for.
pub trait Memory {
    /// Words from a device on, sixteen bits a word where the area holds bits; none where there are no such devices.
    fn words(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<u16>>;

    /// Bits from a device on; none where there are no such devices, or words.
    fn bits(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<bool>>;

    /// The set value of the first such instruction from a program address on; none where there is none.
    fn setting(&mut self, _coil: Coil, _number: u32, _from: u32) -> Option<Setting> {
        None
    }

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

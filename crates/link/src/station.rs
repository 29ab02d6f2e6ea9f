//! A Host Link unit that is read repeatedly. Each answer is matched with its request.
//!
//! An answer does not name the words that it contains, so a late answer could be mistaken for the next one. Therefore,
//! after every error a test request with unique characters is sent first: when they come back, no earlier answer can
//! follow. A line that was closed is opened again.

use super::client::is_address;
use super::device::Device;
use super::fault::{Fault, Wrong};
use super::hostlink;
use super::serial::Settings;
use super::transport::Transport;
use super::{Coil, Setting, Split, State};
use std::time::{Duration, Instant};

/// A unit and its line.
pub struct Station {
    peer: String,
    unit: u8,
    settings: Settings,
    patience: Duration,
    line: Option<Transport>,
    /// Whether the next answer will belong to the next request.
    in_step: bool,
    tests: u32,
}

impl Station {
    /// A unit with this number on a serial line, or behind a serial device server (`HOST:PORT`). Nothing is sent yet.
    #[must_use]
    pub fn new(peer: &str, unit: u8, settings: Settings, patience: Duration) -> Station {
        let peer = peer.to_owned();
        Station { peer, unit, settings, patience, line: None, in_step: false, tests: 0 }
    }

    /// Opens the line, unless it is open.
    ///
    /// # Errors
    /// It cannot be opened.
    pub fn open(&mut self) -> Result<(), Fault> {
        if self.line.is_none() {
            self.in_step = false;
            self.line = Some(match is_address(&self.peer) {
                true => Transport::tcp(&self.peer, self.patience)?,
                false => Transport::serial(&self.peer, Some(self.settings), self.patience)?,
            });
        }
        Ok(())
    }

    /// Whether the line is open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.line.is_some()
    }

    /// Sends a request and decodes the answer with `read`.
    fn ask<T>(
        &mut self,
        request: &[u8],
        read: impl FnOnce(&[u8]) -> Result<T, Wrong>,
    ) -> Result<T, Fault> {
        let done = self.open().and_then(|()| self.step()).and_then(|()| {
            let line = self.line()?;
            line.ask(request, hostlink::split)
        });
        let result = done.and_then(|frame| read(&frame).map_err(|wrong| wrong.from(&self.peer)));
        match &result {
            Ok(_) | Err(Fault::EndCode { .. } | Fault::Usage(_)) => {}
            Err(Fault::Closed { .. } | Fault::Unreachable { .. } | Fault::Refused { .. }) => {
                self.line = None;
            }
            Err(Fault::Half { closed: true, .. }) => self.line = None,
            // After any error, further bytes of the answer may still arrive.
            Err(Fault::TimedOut { .. } | Fault::Half { .. } | Fault::NoAnswer { .. }) => {
                self.in_step = false;
            }
        }
        result
    }

    fn line(&mut self) -> Result<&mut Transport, Fault> {
        let peer = &self.peer;
        self.line.as_mut().ok_or_else(|| Fault::Closed { peer: peer.clone() })
    }

    /// Ensures that the next answer will belong to the next request.
    fn step(&mut self) -> Result<(), Fault> {
        if self.in_step {
            return Ok(());
        }
        self.tests = self.tests.wrapping_add(1);
        let request = hostlink::test_request(self.unit, &format!("{:06}", self.tests % 1_000_000));
        let (end, peer, after) = (Instant::now() + self.patience, self.peer.clone(), self.patience);
        let line = self.line()?;
        line.discard();
        line.send(&request)?;
        loop {
            if Instant::now() >= end {
                return Err(Fault::TimedOut { peer, after });
            }
            match line.next(frame_or_noise) {
                // The rest of an earlier answer, or noise.
                Ok(frame) if frame.ends_with(&request) => break,
                Ok(_) => {}
                Err(fault) => return Err(fault),
            }
        }
        self.in_step = true;
        Ok(())
    }

    /// Reads words from a device on, all at the same moment.
    ///
    /// # Errors
    /// The unit does not answer, or refuses.
    pub fn words(&mut self, device: Device, count: u16) -> Result<Vec<u16>, Fault> {
        let request = hostlink::request(self.unit, device, count);
        self.ask(&request, |frame| hostlink::words(frame, &request, count))
    }

    /// The present values of timers and counters from this number on, as words.
    ///
    /// # Errors
    /// The unit does not answer, or refuses.
    pub fn present(&mut self, first: u32, count: u16) -> Result<Vec<u16>, Fault> {
        let request = hostlink::present_request(self.unit, first, count);
        self.ask(&request, |frame| hostlink::words(frame, &request, count))
    }

    /// The flags of timers and counters from this number on.
    ///
    /// # Errors
    /// The unit does not answer, or refuses.
    pub fn flags(&mut self, first: u32, count: u16) -> Result<Vec<bool>, Fault> {
        let request = hostlink::flags_request(self.unit, first, count);
        self.ask(&request, |frame| hostlink::flags(frame, &request, count))
    }

    /// The set value of a timer or counter, if it is a number.
    ///
    /// # Errors
    /// The unit does not answer, or refuses.
    pub fn number(&mut self, coil: Coil, number: u32) -> Result<Setting, Fault> {
        let request = hostlink::number_request(self.unit, coil, number);
        self.ask(&request, |frame| hostlink::setting(frame, &request))
    }

    /// The set value, or the word that holds it, of the first such instruction from a program address on.
    ///
    /// # Errors
    /// The unit does not answer, or refuses.
    pub fn setting(&mut self, from: u32, coil: Coil, number: u32) -> Result<Setting, Fault> {
        let request = hostlink::setting_request(self.unit, from, coil, number);
        self.ask(&request, |frame| hostlink::setting(frame, &request))
    }

    /// Whether the CPU runs.
    ///
    /// # Errors
    /// The unit does not answer, or refuses.
    pub fn state(&mut self) -> Result<State, Fault> {
        let request = hostlink::state_request(self.unit);
        self.ask(&request, |frame| hostlink::state(frame, &request))
    }
}

/// The same as [`hostlink::split`], but skips to the next `@` if no frame begins.
fn frame_or_noise(bytes: &[u8]) -> Split {
    match bytes.first() {
        Some(b'@') => match hostlink::split(bytes) {
            // An `@` may also be noise.
            Split::Garbage => Split::Frame(1),
            known => known,
        },
        Some(_) => Split::Frame(bytes.iter().position(|byte| *byte == b'@').unwrap_or(bytes.len())),
        None => Split::More,
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests;

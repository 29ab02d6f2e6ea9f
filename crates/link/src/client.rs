//! Reads scan times, devices and the state of a PLC. Nothing here writes to a PLC.

use super::device::{Area, AreaKind, Device};
use super::fault::{Fault, Wrong};
use super::fins::{self, Nodes};
use super::registers::{Register, Registers};
use super::slmp::{self, Code, Query};
use super::transport::Transport;
use super::{Split, State, hostlink, serial};
use scanbound_base::time::Picos;
use std::time::Duration;

/// The protocol of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protocol {
    /// SLMP, which is the MC protocol's 3E frame, over TCP.
    Slmp(Code),
    /// FINS over UDP.
    FinsUdp,
    /// FINS over TCP.
    FinsTcp,
    /// Host Link in C-mode, on a serial line or over TCP through a serial device server: the unit's number, and the
    /// line's settings, unless it is already set.
    HostLink(u8, Option<serial::Settings>),
}

/// A connected PLC.
pub struct Plc {
    protocol: Protocol,
    transport: Transport,
    nodes: Nodes,
    /// The number of the last request.
    id: u8,
}

/// The scan times that a CPU keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanTimes {
    /// The last scan.
    pub current: Picos,
    /// The shortest scan since the CPU started.
    pub least: Option<Picos>,
    /// The longest scan since the CPU started.
    pub most: Option<Picos>,
}

/// Finds the end of an answer in a stream.
fn slmp_answer(bytes: &[u8]) -> Split {
    slmp::split(bytes, true)
}

/// A datagram is always one whole frame.
fn datagram(bytes: &[u8]) -> Split {
    if bytes.is_empty() { Split::More } else { Split::Frame(bytes.len()) }
}

impl Plc {
    /// Connects. Each answer may take at most `patience`.
    ///
    /// # Errors
    /// The PLC cannot be reached, or has no connection left.
    pub fn connect(protocol: Protocol, peer: &str, patience: Duration) -> Result<Plc, Fault> {
        let transport = match protocol {
            Protocol::Slmp(_) | Protocol::FinsTcp => Transport::tcp(peer, patience)?,
            Protocol::FinsUdp => Transport::udp(peer, patience)?,
            Protocol::HostLink(..) if is_address(peer) => Transport::tcp(peer, patience)?,
            Protocol::HostLink(_, settings) => Transport::serial(peer, settings, patience)?,
        };
        let (own, plc) = transport.nodes();
        let mut plc = Plc { protocol, transport, nodes: Nodes { own, plc }, id: 0 };
        if protocol == Protocol::FinsTcp {
            let frame = plc.transport.ask(&fins::hello(), fins::split)?;
            plc.nodes = fins::nodes(&frame).map_err(|wrong| plc.wrong(wrong))?;
        }
        Ok(plc)
    }

    /// The address or the serial line of the PLC.
    #[must_use]
    pub fn peer(&self) -> &str {
        self.transport.peer()
    }

    fn wrong(&self, wrong: Wrong) -> Fault {
        wrong.from(self.transport.peer())
    }

    /// The areas that the protocol can read.
    #[must_use]
    pub fn areas(&self) -> &'static [Area] {
        match self.protocol {
            Protocol::Slmp(_) => slmp::AREAS,
            Protocol::FinsUdp | Protocol::FinsTcp => fins::AREAS,
            Protocol::HostLink(..) => hostlink::AREAS,
        }
    }

    /// The device with this name.
    ///
    /// # Errors
    /// The protocol cannot read a device with this name.
    pub fn device(&self, name: &str) -> Result<Device, Fault> {
        Device::named(name, self.areas())
            .ok_or_else(|| Fault::Usage(format!("this protocol cannot read {name}")))
    }

    /// Sends a FINS request and returns the data of the answer.
    fn fins(&mut self, ask: fins::Query) -> Result<Vec<u8>, Fault> {
        self.id = self.id.wrapping_add(1);
        let request = fins::request(ask, self.nodes, self.id);
        let frame = match self.protocol {
            Protocol::FinsTcp => {
                let wrapped = fins::over_tcp(fins::Over::Frame, 0, &request);
                let frame = self.transport.ask(&wrapped, fins::split)?;
                fins::unwrapped(&frame).map_err(|wrong| self.wrong(wrong))?.to_vec()
            }
            _ => self.transport.ask(&request, datagram)?,
        };
        let data = fins::accepted(&frame, &request).map_err(|wrong| self.wrong(wrong))?;
        Ok(data.to_vec())
    }

    /// Reads words from a device on, all at the same moment.
    ///
    /// # Errors
    /// The PLC does not answer, or refuses.
    pub fn words(&mut self, device: Device, count: u16) -> Result<Vec<u16>, Fault> {
        let words = match self.protocol {
            Protocol::Slmp(code) => {
                let request = slmp::request(Query::Words(device, count), code);
                let frame = self.transport.ask(&request, slmp_answer)?;
                slmp::words(&frame, count)
            }
            Protocol::FinsUdp | Protocol::FinsTcp => {
                let data = self.fins(fins::Query::Words(device, count))?;
                fins::words(&data, count)
            }
            Protocol::HostLink(unit, _) => {
                let request = hostlink::request(unit, device, count);
                let frame = self.transport.ask(&request, hostlink::split)?;
                hostlink::words(&frame, &request, count)
            }
        };
        words.map_err(|wrong| self.wrong(wrong))
    }

    /// Reads any number of words from a device on, in as many requests as necessary.
    ///
    /// # Errors
    /// The PLC does not answer, or refuses.
    pub fn many(&mut self, device: Device, count: u32) -> Result<Vec<u16>, Fault> {
        let most = match self.protocol {
            Protocol::Slmp(_) => slmp::MAX_WORDS,
            Protocol::FinsUdp | Protocol::FinsTcp => fins::MAX_WORDS,
            Protocol::HostLink(..) => hostlink::MAX_WORDS,
        };
        let mut words = Vec::new();
        let mut done = 0;
        while done < count {
            let part = (count - done).min(most);
            let from = Device { index: device.index + done, ..device };
            words.extend(self.words(from, u16::try_from(part).unwrap_or(1))?);
            done += part;
        }
        Ok(words)
    }

    /// The value of a device: a bit, or a word.
    ///
    /// # Errors
    /// The PLC does not answer, or refuses.
    pub fn value(&mut self, device: Device) -> Result<u16, Fault> {
        match (self.protocol, device.area.kind) {
            (Protocol::Slmp(code), AreaKind::Bit) => {
                let request = slmp::request(Query::Bits(device, 1), code);
                let frame = self.transport.ask(&request, slmp_answer)?;
                let bits = slmp::bits(&frame, 1).map_err(|wrong| self.wrong(wrong))?;
                Ok(u16::from(bits.first().copied().unwrap_or(false)))
            }
            _ => {
                let words = self.words(device, 1)?;
                let word = words.first().copied().unwrap_or(0);
                Ok(device.bit.map_or(word, |bit| word >> bit & 1))
            }
        }
    }

    fn time(&mut self, register: Register) -> Result<Picos, Fault> {
        let name = format!("{}{}", register.area, register.first);
        let device = self.device(&name)?;
        let words = self.words(device, register.form.words())?;
        register.form.read(&words).ok_or_else(|| {
            let why = format!(
                "{name} contains {words:?}, which is not a scan time: check that --cpu names the right family"
            );
            self.wrong(Wrong::NoAnswer(why))
        })
    }

    /// The scan times that the CPU stores.
    ///
    /// # Errors
    /// The PLC does not answer, refuses, or its registers do not hold times.
    pub fn scan_times(&mut self, registers: &Registers) -> Result<ScanTimes, Fault> {
        let current = self.time(registers.current)?;
        let least = registers.least.map(|register| self.time(register)).transpose()?;
        let most = registers.most.map(|register| self.time(register)).transpose()?;
        Ok(ScanTimes { current, least, most })
    }

    /// Whether the CPU runs.
    ///
    /// # Errors
    /// The PLC does not answer, or refuses.
    pub fn state(&mut self, family: &str) -> Result<State, Fault> {
        match self.protocol {
            Protocol::Slmp(_) if family == "fx" => {
                // A relay that is on while the program runs.
                let device = self.device("M8000")?;
                Ok(if self.value(device)? == 1 { State::Run } else { State::Stop })
            }
            Protocol::Slmp(_) => {
                // The operating state in its lowest four bits: 0 is RUN.
                let device = self.device("SD203")?;
                Ok(if self.value(device)? & 0xF == 0 { State::Run } else { State::Stop })
            }
            Protocol::FinsUdp | Protocol::FinsTcp => {
                let data = self.fins(fins::Query::State)?;
                fins::state(&data).map_err(|wrong| self.wrong(wrong))
            }
            Protocol::HostLink(unit, _) => {
                let request = hostlink::state_request(unit);
                let frame = self.transport.ask(&request, hostlink::split)?;
                hostlink::state(&frame, &request).map_err(|wrong| self.wrong(wrong))
            }
        }
    }

    /// The CPU's name. `None` if the protocol has no request for it.
    ///
    /// # Errors
    /// The PLC does not answer, or refuses.
    pub fn model(&mut self) -> Result<Option<String>, Fault> {
        let Protocol::Slmp(code) = self.protocol else { return Ok(None) };
        let frame = self.transport.ask(&slmp::request(Query::Model, code), slmp_answer)?;
        slmp::model(&frame).map(Some).map_err(|wrong| self.wrong(wrong))
    }
}

/// Whether the name is an address with a port. Otherwise it is a serial line.
pub(super) fn is_address(peer: &str) -> bool {
    peer.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok())
}

#[cfg(test)]
mod tests;

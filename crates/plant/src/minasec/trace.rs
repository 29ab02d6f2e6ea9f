//! Writes an emulated run as CSV with one row for each scan.

use super::machine::Scan;
use scanbound_front_minasec::{Device, DeviceKind};
use std::io::{self, Write};

/// The column of scan times. Emulated times are never called measured.
pub const SCAN_TIME: &str = "emulated_us";

/// Writes a trace: when each scan began and how long it took, the latched inputs, the output terminals after it,
/// relays, timers' contacts, whether the count equals its setting, and the count.
#[derive(Debug)]
pub struct Trace<W> {
    out: W,
    scans: u64,
}

impl<W: Write> Trace<W> {
    /// Starts a trace and writes its heading.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(mut out: W) -> io::Result<Trace<W>> {
        write!(out, "scan,start_us,{SCAN_TIME}")?;
        for device in shown() {
            write!(out, ",{device}")?;
        }
        writeln!(out, ",count")?;
        Ok(Trace { out, scans: 0 })
    }

    /// Writes a scan.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn scan(&mut self, scan: &Scan) -> io::Result<()> {
        self.scans += 1;
        write!(self.out, "{},{},{}", self.scans, scan.start.us_text(), scan.time.us_text())?;
        let devices = scan.view.devices & !0xFF00 | u32::from(scan.view.outputs) << 8;
        for device in shown() {
            write!(self.out, ",{}", devices >> device.address() & 1)?;
        }
        writeln!(self.out, ",{}", scan.view.count)
    }

    /// Writes the buffered rest.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// The devices that have a value.
fn shown() -> impl Iterator<Item = Device> {
    Device::all().filter(|device| device.kind() != DeviceKind::Clear)
}

//! Writes an emulated run as a value change dump (VCD) for GTKWave and PulseView.

use super::machine::{Machine, Observer, View};
use super::stimulus::{Change, Stimulus, What};
use scanbound_base::time::Picos;
use scanbound_front_minasec::{Device, DeviceKind};
use std::io::{self, Write};
use vcd::{IdCode, SimulationCommand, TimescaleUnit, VarType, Writer};

/// The comment in the file. `compare` recognises emulated files by it.
pub const EMULATED: &str = "emulated by scanbound, not measured";

/// Writes the dump while the machine runs. [`Dump::finish`] returns the first write error.
pub struct Dump<W: Write> {
    out: Writer<W>,
    /// Rises when a scan begins, and falls one word later.
    scan: IdCode,
    terminals: Vec<IdCode>,
    devices: Vec<(Device, IdCode)>,
    outputs: Vec<IdCode>,
    coils: [IdCode; 4],
    count: IdCode,
    running: IdCode,
    plant: std::vec::IntoIter<Change>,
    last: View,
    /// The length of the scan's pulse, and when it falls next.
    pulse: Picos,
    falls: Option<Picos>,
    at: Option<Picos>,
    fault: Option<io::Error>,
}

impl<W: Write> Dump<W> {
    /// Starts a dump. The stimulus gives the levels at the input terminals, the machine the initial state.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(out: W, stimulus: &Stimulus, machine: &Machine) -> io::Result<Dump<W>> {
        let view = machine.view();
        let mut out = Writer::new(out);
        out.version(concat!("scanbound ", env!("CARGO_PKG_VERSION")))?;
        out.comment(EMULATED)?;
        out.timescale(1, TimescaleUnit::PS)?;
        out.add_module("minasec_u")?;
        let scan = out.add_wire(1, "scan")?;
        let running = out.add_wire(1, "running")?;
        let mut eight = |module: &str, letter: char| -> io::Result<Vec<IdCode>> {
            out.add_module(module)?;
            let codes = (0..8).map(|bit| out.add_wire(1, &format!("{letter}0{bit}"))).collect();
            out.upscope()?;
            codes
        };
        let terminals = eight("input_terminals", 'X')?;
        let outputs = eight("output_terminals", 'Y')?;
        out.add_module("devices")?;
        let mut devices = Vec::new();
        for device in Device::all().filter(|device| device.kind() != DeviceKind::Clear) {
            devices.push((device, out.add_wire(1, &device.to_string())?));
        }
        out.upscope()?;
        out.add_module("coils")?;
        let mut coil = |device: Device| out.add_wire(1, &device.to_string());
        let coils = [coil(Device::T0)?, coil(Device::T1)?, coil(Device::C0)?, coil(Device::CLEAR)?];
        out.upscope()?;
        let count = out.add_var(VarType::Reg, 8, "count", None)?;
        out.upscope()?;
        out.enddefinitions()?;
        let plant: Vec<Change> = stimulus
            .changes
            .iter()
            .filter(|change| matches!(change.what, What::Input(_)))
            .copied()
            .collect();
        let mut dump = Dump {
            out,
            scan,
            terminals,
            devices,
            outputs,
            coils,
            count,
            running,
            plant: plant.into_iter(),
            last: view,
            pulse: machine.period(),
            falls: None,
            at: None,
            fault: None,
        };
        dump.out.begin(SimulationCommand::Dumpvars)?;
        dump.out.change_scalar(dump.scan, false)?;
        for &terminal in &dump.terminals {
            dump.out.change_scalar(terminal, false)?;
        }
        dump.values(view, None)?;
        dump.out.end()?;
        Ok(dump)
    }

    /// Writes the values that differ from the last ones, or all.
    fn values(&mut self, view: View, last: Option<View>) -> io::Result<()> {
        let differs = |now: u32, before: Option<u32>, bit: usize| {
            before.is_none_or(|before| (now ^ before) >> bit & 1 == 1)
        };
        for &(device, code) in &self.devices {
            let bit = usize::from(device.address());
            if differs(view.devices, last.map(|last| last.devices), bit) {
                self.out.change_scalar(code, view.devices >> bit & 1 == 1)?;
            }
        }
        for (codes, now, before) in [
            (&self.outputs[..], view.outputs, last.map(|last| last.outputs)),
            (&self.coils[..], view.coils, last.map(|last| last.coils)),
        ] {
            for (bit, &code) in codes.iter().enumerate() {
                if differs(u32::from(now), before.map(u32::from), bit) {
                    self.out.change_scalar(code, now >> bit & 1 == 1)?;
                }
            }
        }
        if last.is_none_or(|last| last.count != view.count) {
            let bits = (0..8).rev().map(|bit| vcd::Value::from(view.count >> bit & 1 == 1));
            self.out.change_vector(self.count, bits)?;
        }
        if last.is_none_or(|last| last.running != view.running) {
            self.out.change_scalar(self.running, view.running)?;
        }
        Ok(())
    }

    /// Writes a time stamp, unless the dump has already reached this time.
    fn moment(&mut self, at: Picos) -> io::Result<()> {
        if self.at.is_none_or(|now| now < at) {
            self.at = Some(at);
            self.out.timestamp(at.0)?;
        }
        Ok(())
    }

    /// Writes the changes up to this time that the machine does not report: those of the terminals, and the end of the
    /// scan's pulse.
    fn until(&mut self, at: Picos) -> io::Result<()> {
        loop {
            let plant = self.plant.as_slice().first().copied().filter(|change| change.at <= at);
            let falls = self.falls.filter(|&falls| falls <= at);
            match (plant, falls) {
                (None, None) => return Ok(()),
                (Some(change), falls) if falls.is_none_or(|falls| change.at <= falls) => {
                    self.plant.next();
                    if let What::Input(input) = change.what {
                        self.moment(change.at)?;
                        self.out.change_scalar(self.terminals[usize::from(input)], change.on)?;
                    }
                }
                (_, Some(falls)) => {
                    self.falls = None;
                    self.moment(falls)?;
                    self.out.change_scalar(self.scan, false)?;
                }
                (Some(_), None) => {}
            }
        }
    }

    fn write(&mut self, at: Picos, view: View, scan: bool) -> io::Result<()> {
        self.until(at)?;
        if scan {
            self.moment(at)?;
            self.falls = Some(at + self.pulse);
            self.out.change_scalar(self.scan, true)?;
        }
        if view != self.last {
            self.moment(at)?;
            let last = std::mem::replace(&mut self.last, view);
            self.values(view, Some(last))?;
        }
        Ok(())
    }

    fn take(&mut self, at: Picos, view: View, scan: bool) {
        if self.fault.is_none() {
            self.fault = self.write(at, view, scan).err();
        }
    }

    /// Ends the dump.
    ///
    /// # Errors
    /// The first write error.
    pub fn finish(mut self, at: Picos) -> io::Result<()> {
        match self.fault.take() {
            Some(fault) => Err(fault),
            None => {
                self.until(at)?;
                self.moment(at)?;
                self.out.flush()
            }
        }
    }
}

impl<W: Write> Observer for Dump<W> {
    fn scan(&mut self, at: Picos, view: View) {
        self.take(at, view, true);
    }

    fn change(&mut self, at: Picos, view: View) {
        self.take(at, view, false);
    }
}

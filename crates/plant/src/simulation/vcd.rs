//! Writes a simulated run as a value change dump (VCD) for GTKWave and PulseView.

use super::recording::Recording;
use super::signals::{Place, Value};
use crate::minasec::vcd::EMULATED;
use scanbound_base::time::Picos;
use scanbound_ir::tags::ValueForm;
use std::io::{self, Write};
use vcd::{IdCode, SimulationCommand, TimescaleUnit, VarType, Writer};

/// The unit of a run in a dump: picoseconds, as in tables.
const UNIT: (u32, TimescaleUnit) = (1, TimescaleUnit::PS);

/// A signal of the dump: its code, and its width in bits; 0 for real numbers.
struct Wire {
    code: IdCode,
    width: u32,
}

/// Writes a recording. `scan` rises when a scan begins and falls halfway through it.
///
/// # Errors
/// If it cannot be written.
pub fn write(recording: &Recording, out: impl Write) -> io::Result<()> {
    let mut out = Writer::new(out);
    out.version(concat!("scanbound ", env!("CARGO_PKG_VERSION")))?;
    out.comment(EMULATED)?;
    out.timescale(UNIT.0, UNIT.1)?;
    out.add_module("program")?;
    let pulse = out.add_wire(1, "scan")?;
    let mut wires = Vec::new();
    for (signal, first) in &recording.signals {
        let name = signal.name.replace(char::is_whitespace, "_");
        let (kind, width) = match (signal.place, first) {
            (Place::Bit(_) | Place::WordBit(..), _) => (VarType::Wire, 1),
            (Place::Words(.., ValueForm::Real), _) => (VarType::Real, 0),
            (Place::Words(.., ValueForm::Time), _) => (VarType::Reg, 64),
            (Place::Words(_, count, _), _) => (VarType::Reg, 16 * count),
        };
        let code = out.add_var(kind, if width == 0 { 64 } else { width }, &name, None)?;
        wires.push(Wire { code, width });
    }
    out.upscope()?;
    out.enddefinitions()?;
    out.begin(SimulationCommand::Dumpvars)?;
    out.change_scalar(pulse, false)?;
    for (wire, (_, first)) in wires.iter().zip(&recording.signals) {
        change(&mut out, wire, *first)?;
    }
    out.end()?;
    let mut end = Picos::ZERO;
    for scan in &recording.scans {
        out.timestamp(scan.start.0)?;
        out.change_scalar(pulse, true)?;
        for &(number, value) in &scan.before {
            change(&mut out, &wires[number], value)?;
        }
        out.timestamp(scan.start.0 + scan.time.0 / 2)?;
        out.change_scalar(pulse, false)?;
        end = scan.start + scan.time;
        if !scan.after.is_empty() {
            out.timestamp(end.0)?;
        }
        for &(number, value) in &scan.after {
            change(&mut out, &wires[number], value)?;
        }
    }
    out.timestamp(end.0)?;
    out.flush()
}

fn change(out: &mut Writer<impl Write>, wire: &Wire, value: Value) -> io::Result<()> {
    match value {
        Value::Unknown if wire.width == 1 => out.change_scalar(wire.code, vcd::Value::X),
        Value::Unknown if wire.width == 0 => out.change_real(wire.code, f32::NAN.into()),
        Value::Unknown => out.change_vector(wire.code, (0..wire.width).map(|_| vcd::Value::X)),
        Value::Whole(value) if wire.width == 1 => out.change_scalar(wire.code, value != 0),
        // A time is the number of its microseconds.
        Value::Time(_) | Value::Whole(_) => {
            let value = match value {
                Value::Time(halves) => i128::from(halves) * 500,
                Value::Whole(value) => value,
                Value::Unknown | Value::Real(_) => 0,
            };
            let bits = (0..wire.width).rev().map(|bit| vcd::Value::from(value >> bit & 1 == 1));
            out.change_vector(wire.code, bits)
        }
        Value::Real(value) => out.change_real(wire.code, value.into()),
    }
}

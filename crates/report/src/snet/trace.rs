//! What a simulation goes through, as CSV and as a value change dump.

use scanbound_snet::simulation::{Happened, Simulation};
use scanbound_snet::{Diagram, Kind};
use std::io::{self, Write};
use vcd::{IdCode, SimulationCommand, TimescaleUnit, Value, VarType, Writer};

/// Names of what is traced besides transitions, in the order of their values: marks, timers' and counters' parts,
/// gates.
fn names(diagram: &Diagram) -> Vec<(String, u32)> {
    let mut found = Vec::new();
    for (at, place) in diagram.places.iter().enumerate() {
        let name = diagram.place_name(at);
        let more = match place.kind {
            Kind::Box => None,
            Kind::Timer { .. } => Some((format!("{name}.P"), 1)),
            Kind::Counter { .. } => Some((format!("{name}.count"), 16)),
        };
        found.push((name, 1));
        found.extend(more);
    }
    found.extend(diagram.outers.iter().map(|outer| (outer.head.name.clone(), 1)));
    found
}

/// Their values now.
fn values(net: &Simulation<'_>) -> Vec<u16> {
    let (diagram, now, rules) = (net.diagram(), net.now(), net.rules());
    let mut found = Vec::new();
    for (at, place) in diagram.places.iter().enumerate() {
        found.push(u16::from(rules.is_marked(&now.state, at)));
        match place.kind {
            Kind::Box => {}
            Kind::Timer { .. } => found.push(u16::from(rules.is_over(&now.state, at))),
            Kind::Counter { .. } => found.push(rules.count(&now.state, at)),
        }
    }
    found.extend(now.outers.iter().map(|&on| u16::from(on)));
    found
}

/// Writes a row a change.
pub struct Rows<W: Write> {
    out: csv::Writer<W>,
    last: Vec<u16>,
}

impl<W: Write> Rows<W> {
    /// Begins with the heads and the beginning.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn new(out: W, net: &Simulation<'_>) -> io::Result<Rows<W>> {
        let mut out = csv::Writer::from_writer(out);
        let heads = ["time_ms".to_owned(), "fired".to_owned()].into_iter();
        out.write_record(heads.chain(names(net.diagram()).into_iter().map(|(name, _)| name)))?;
        let mut rows = Rows { out, last: Vec::new() };
        rows.row(net, 0, &Happened::default())?;
        Ok(rows)
    }

    /// Writes what a step that began at a time came to, unless that changed nothing.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn row(&mut self, net: &Simulation<'_>, ms: u64, happened: &Happened) -> io::Result<()> {
        let values = values(net);
        if values == self.last && happened.is_nothing() {
            return Ok(());
        }
        let fired: Vec<String> =
            happened.fired.iter().map(|&at| net.diagram().transition_name(at)).collect();
        let cells = [ms.to_string(), fired.join(" ")].into_iter();
        self.out.write_record(cells.chain(values.iter().map(u16::to_string)))?;
        self.last = values;
        Ok(())
    }

    /// Ends.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Writes a value change dump.
pub struct Dump<W: Write> {
    out: Writer<W>,
    wires: Vec<(IdCode, u32)>,
    transitions: Vec<IdCode>,
    last: Vec<u16>,
    fired: Vec<usize>,
    at: Option<u64>,
}

impl<W: Write> Dump<W> {
    /// Begins with the beginning.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn new(out: W, net: &Simulation<'_>) -> io::Result<Dump<W>> {
        let mut out = Writer::new(out);
        // Names in such files have no blanks.
        let word = |name: &str| name.replace(char::is_whitespace, "_");
        out.version(concat!("scanbound ", env!("CARGO_PKG_VERSION")))?;
        out.timescale(1, TimescaleUnit::MS)?;
        out.add_module("snet")?;
        let mut wires = Vec::new();
        for (name, width) in names(net.diagram()) {
            let kind = if width == 1 { VarType::Wire } else { VarType::Reg };
            wires.push((out.add_var(kind, width, &word(&name), None)?, width));
        }
        let mut transitions = Vec::new();
        for at in 0..net.diagram().transitions.len() {
            transitions.push(out.add_wire(1, &word(&net.diagram().transition_name(at)))?);
        }
        out.upscope()?;
        out.enddefinitions()?;
        out.begin(SimulationCommand::Dumpvars)?;
        let last = values(net);
        for (&(wire, width), &value) in wires.iter().zip(&last) {
            change(&mut out, wire, width, value)?;
        }
        for &wire in &transitions {
            out.change_scalar(wire, Value::V0)?;
        }
        out.end()?;
        Ok(Dump { out, wires, transitions, last, fired: Vec::new(), at: None })
    }

    fn moment(&mut self, ms: u64) -> io::Result<()> {
        if self.at != Some(ms) {
            self.out.timestamp(ms)?;
            self.at = Some(ms);
        }
        Ok(())
    }

    /// Writes what a step that began at a time came to; transitions that fired are on until it ends at `net`'s time.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn row(&mut self, net: &Simulation<'_>, ms: u64, happened: &Happened) -> io::Result<()> {
        let values = values(net);
        if values == self.last && happened.is_nothing() && self.fired.is_empty() {
            return Ok(());
        }
        self.moment(ms)?;
        for at in std::mem::take(&mut self.fired) {
            if !happened.fired.contains(&at) {
                self.out.change_scalar(self.transitions[at], Value::V0)?;
            }
        }
        for &at in &happened.fired {
            self.out.change_scalar(self.transitions[at], Value::V1)?;
        }
        for (at, (&value, &last)) in values.iter().zip(&self.last).enumerate() {
            if value != last {
                let (wire, width) = self.wires[at];
                change(&mut self.out, wire, width, value)?;
            }
        }
        self.fired.clone_from(&happened.fired);
        self.last = values;
        Ok(())
    }

    /// Ends at a time.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self, ms: u64) -> io::Result<()> {
        self.moment(ms)?;
        for at in std::mem::take(&mut self.fired) {
            self.out.change_scalar(self.transitions[at], Value::V0)?;
        }
        self.out.flush()
    }
}

fn change<W: Write>(out: &mut Writer<W>, wire: IdCode, width: u32, value: u16) -> io::Result<()> {
    if width == 1 {
        return out.change_scalar(wire, value & 1 == 1);
    }
    let bits = (0..width).rev().map(|bit| Value::from(value >> bit & 1 == 1));
    out.change_vector(wire, bits)
}

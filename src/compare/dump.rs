//! Reads a captured signal from a value change dump.

use super::Measurements;
use super::capture::{Edges, Origin, Selection, fault};
use crate::diagnostic::Diagnostic;
use crate::emulate::vcd::EMULATED;
use crate::time::Picos;
use vcd::{Command, Header, IdCode, Parser, Scope, ScopeItem, Value};

/// Most signals that a message names.
const NAMED: usize = 20;

/// Reads the edges of the signal that is selected, or of the only one.
pub(super) fn read(
    name: &str,
    bytes: &[u8],
    selection: &Selection<'_>,
) -> Result<Measurements, Vec<Diagnostic>> {
    let broken = |error: &dyn std::fmt::Display| {
        vec![fault(name, format!("not a value change dump: {error}"), "export the capture again")]
    };
    let mut parser = Parser::new(bytes);
    let header = parser.parse_header().map_err(|error| broken(&error))?;
    let Some((value, unit)) = header.timescale else {
        let help = "export the capture again, with a $timescale";
        return Err(vec![fault(name, "the dump has no timescale", help)]);
    };
    let picos = |ticks: u64| {
        i128::from(ticks) * i128::from(value) * 1_000_000_000_000 / i128::from(unit.divisor())
    };
    let signals = Signals::of(&header);
    let (signal, code) = signals.find(name, selection.signal)?;
    let mut edges = Edges::new(selection.edge);
    let mut at = 0_i128;
    // Levels that follow each other at one moment are a glitch of the tool, not edges.
    let mut level = None;
    let mut emulated = mentions(&header.items);
    for command in parser {
        match command.map_err(|error| broken(&error))? {
            Command::Timestamp(time) => {
                if let Some(level) = level.take() {
                    edges.level(at, level);
                }
                at = picos(time);
            }
            Command::ChangeScalar(id, value) if id == code => level = Some(bit(value)),
            Command::ChangeVector(id, value) if id == code => {
                level = Some(value.iter().last().and_then(bit));
            }
            Command::Comment(text) => emulated |= text.contains(EMULATED),
            _ => {}
        }
    }
    if let Some(level) = level {
        edges.level(at, level);
    }
    let tick = u64::try_from(picos(1)).ok().map(|tick| Picos(tick.max(1)));
    let resolution = tick.filter(|_| !emulated);
    Origin { name, resolution, emulated }.of_edges(&signal, &edges)
}

fn bit(value: Value) -> Option<bool> {
    match value {
        Value::V0 => Some(false),
        Value::V1 => Some(true),
        Value::X | Value::Z => None,
    }
}

fn mentions(items: &[ScopeItem]) -> bool {
    items.iter().any(|item| matches!(item, ScopeItem::Comment(text) if text.contains(EMULATED)))
}

/// The signals of one bit, by path.
struct Signals(Vec<(String, IdCode)>);

impl Signals {
    fn of(header: &Header) -> Signals {
        let mut signals = Signals(Vec::new());
        signals.take(&header.items, "");
        signals
    }

    fn take(&mut self, items: &[ScopeItem], path: &str) {
        for item in items {
            match item {
                ScopeItem::Var(var) if var.size == 1 => {
                    self.0.push((format!("{path}{}", var.reference), var.code));
                }
                ScopeItem::Scope(Scope { identifier, items, .. }) => {
                    self.take(items, &format!("{path}{identifier}."));
                }
                _ => {}
            }
        }
    }

    /// The signal of a name: its whole path, or its last part where that is the name of one only.
    fn find(&self, file: &str, wanted: Option<&str>) -> Result<(String, IdCode), Vec<Diagnostic>> {
        let names = || {
            let mut names: Vec<&str> =
                self.0.iter().take(NAMED).map(|(name, _)| name.as_str()).collect();
            if self.0.len() > NAMED {
                names.push("...");
            }
            names.join(", ")
        };
        let matching = |wanted: &str| -> Vec<&(String, IdCode)> {
            let whole: Vec<_> = self.0.iter().filter(|(path, _)| path == wanted).collect();
            if !whole.is_empty() {
                return whole;
            }
            let last = |path: &str| path.rsplit('.').next().is_some_and(|last| last == wanted);
            self.0.iter().filter(|(path, _)| last(path)).collect()
        };
        let found = match wanted {
            Some(wanted) => matching(wanted),
            None => self.0.iter().collect(),
        };
        match (&found[..], wanted) {
            // The same wire may have several names.
            ([first, rest @ ..], _) if rest.iter().all(|other| other.1 == first.1) => {
                Ok((first.0.clone(), first.1))
            }
            ([], Some(wanted)) => {
                let message = format!("the dump has no signal '{wanted}' of one bit");
                Err(vec![fault(file, message, format!("its signals are {}", names()))])
            }
            ([], None) => Err(vec![fault(
                file,
                "the dump has no signal of one bit",
                "capture the scan's pulse",
            )]),
            (_, Some(wanted)) => {
                let message = format!("the dump has several signals '{wanted}'");
                let help = format!("give the whole path: one of {}", names());
                Err(vec![fault(file, message, help)])
            }
            (_, None) => {
                let message = "the dump has several signals";
                let help = format!("name the scan's with --signal: one of {}", names());
                Err(vec![fault(file, message, help)])
            }
        }
    }
}

//! Reads a captured signal from a value change dump.

use super::Measurements;
use super::number::Decimal;
use super::signal::{Edges, Origin, Selection, fault};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_plant::minasec::vcd::EMULATED;
use std::borrow::Cow;
use vcd::{Command, Header, IdCode, ParseError, Parser, Scope, ScopeItem, Value, VarType};

/// Replaces a blank within a name while the dump is read.
const FIXED_BLANK: &str = "\u{A0}";
/// The most signals that a message names.
const NAMED: usize = 20;

/// Reads the edges of the selected signal, or of the only one.
pub(super) fn read(
    name: &str,
    bytes: &[u8],
    selection: &Selection<'_>,
) -> Result<Measurements, Vec<Diagnostic>> {
    let broken = |error: &std::io::Error| {
        let mut found =
            fault(name, format!("not a value change dump: {error}"), "export the capture again");
        let inner = error.get_ref().and_then(|inner| inner.downcast_ref::<ParseError>());
        found.line = inner.and_then(|inner| u32::try_from(inner.line()).ok());
        vec![found]
    };
    let bytes = in_one_word(bytes);
    let mut parser = Parser::new(&*bytes);
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
    let mut emulated = mentions(&header.items);
    let gate = match selection.during {
        Some(wanted) => Some(signals.find(name, Some(wanted))?.1),
        // The emulator's dumps show when the machine runs.
        None if emulated => signals.beside(&signal, "running"),
        None => None,
    };
    let is_real = signals.0.iter().any(|one| one.code == code && one.real);
    if is_real && selection.threshold.is_none() {
        let help = "give the switching level with --threshold, such as --threshold 2.5 or 0.8..2.0";
        return Err(vec![fault(name, format!("the signal '{signal}' is analog"), help)]);
    }
    let mut edges = Edges::new(selection.edge);
    let mut at = 0_i128;
    // Several levels at the same moment are a glitch of the tool, not edges.
    let mut level = None;
    let mut gap = Gap::default();
    while let Some(command) = parser.next() {
        match command.map_err(|error| broken(&error))? {
            Command::Timestamp(time) => {
                if let Some(level) = level.take() {
                    edges.level(at, level);
                }
                gap.tell(&mut edges);
                let now = picos(time);
                if now < at {
                    let mut found =
                        fault(name, "time runs backwards here", "export the capture again");
                    found.line = u32::try_from(parser.line()).ok();
                    return Err(vec![found]);
                }
                at = now;
            }
            Command::ChangeScalar(id, value) if Some(id) == gate => gap.set(bit(value)),
            Command::ChangeReal(id, value) if id == code => {
                // As text, because decimals are compared exactly.
                let value = Decimal::Point.level(&value.to_string());
                match value.zip(selection.threshold) {
                    Some((value, threshold)) => {
                        if let Some(found) = threshold.level(value) {
                            level = Some(Some(found));
                        }
                    }
                    None => level = Some(None),
                }
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
    gap.tell(&mut edges);
    let tick = u64::try_from(picos(1)).ok().map(|tick| Picos(tick.max(1)));
    let resolution = tick.filter(|_| !emulated);
    Origin { name, resolution, emulated }.of_edges(&signal, &edges)
}

/// Whether the machine stands still.
#[derive(Default)]
struct Gap {
    /// Now.
    open: bool,
    /// At some time since the last report.
    seen: bool,
}

impl Gap {
    fn set(&mut self, running: Option<bool>) {
        self.open = running != Some(true);
        self.seen |= self.open;
    }

    /// Reports what was seen at this moment, after an edge at the same moment.
    fn tell(&mut self, edges: &mut Edges) {
        edges.stands(self.open, self.seen);
        self.seen = false;
    }
}

/// The dump with blanks within names replaced by fixed blanks, which the parser accepts in names.
fn in_one_word(bytes: &[u8]) -> Cow<'_, [u8]> {
    let end = find(bytes, b"$enddefinitions").unwrap_or(bytes.len());
    let Ok(header) = std::str::from_utf8(&bytes[..end]) else { return Cow::Borrowed(bytes) };
    let (mut out, mut done, mut changed) = (String::new(), 0, false);
    for (at, keyword) in header.match_indices('$') {
        let rest = &header[at + keyword.len()..];
        let words = match rest.split_whitespace().next() {
            Some("var") => 4,
            Some("scope") => 2,
            _ => continue,
        };
        let Some(length) = rest.find("$end").filter(|_| at >= done) else { continue };
        let tokens: Vec<&str> = rest[..length].split_whitespace().collect();
        let named = tokens.get(words..).unwrap_or_default();
        // An index in brackets is separate from the name.
        let index = named.last().filter(|last| last.starts_with('[') && named.len() > 1);
        let name = &named[..named.len() - usize::from(index.is_some())];
        if name.len() < 2 {
            continue;
        }
        changed = true;
        out.push_str(&header[done..at]);
        out.push('$');
        out.push_str(&tokens[..words].join(" "));
        out.push(' ');
        out.push_str(&name.join(FIXED_BLANK));
        if let Some(index) = index {
            out.push(' ');
            out.push_str(index);
        }
        out.push(' ');
        done = at + keyword.len() + length;
    }
    if !changed {
        return Cow::Borrowed(bytes);
    }
    out.push_str(&header[done..]);
    Cow::Owned([out.as_bytes(), &bytes[end..]].concat())
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|window| window == wanted)
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

/// A signal of one bit, or a real-valued one.
#[derive(Clone)]
struct Signal {
    path: String,
    code: IdCode,
    real: bool,
}

/// The one-bit and real-valued signals, by path.
struct Signals(Vec<Signal>);

impl Signals {
    fn of(header: &Header) -> Signals {
        let mut signals = Signals(Vec::new());
        signals.take(&header.items, "");
        signals
    }

    fn take(&mut self, items: &[ScopeItem], path: &str) {
        for item in items {
            match item {
                ScopeItem::Var(var) if var.size == 1 || var.var_type == VarType::Real => {
                    let name = var.reference.replace(FIXED_BLANK, " ");
                    let real = var.var_type == VarType::Real;
                    self.0.push(Signal { path: format!("{path}{name}"), code: var.code, real });
                }
                ScopeItem::Scope(Scope { identifier, items, .. }) => {
                    let name = identifier.replace(FIXED_BLANK, " ");
                    self.take(items, &format!("{path}{name}."));
                }
                _ => {}
            }
        }
    }

    /// The signal of this name in the scope of another signal.
    fn beside(&self, other: &str, name: &str) -> Option<IdCode> {
        let scope = other.rfind('.').map_or("", |at| &other[..=at]);
        let wanted = format!("{scope}{name}");
        self.0.iter().find(|one| one.path == wanted && !one.real).map(|one| one.code)
    }

    /// The signal of this name: its whole path, or its last part if that is unique.
    fn find(&self, file: &str, wanted: Option<&str>) -> Result<(String, IdCode), Vec<Diagnostic>> {
        let names = || {
            let mut names: Vec<&str> =
                self.0.iter().take(NAMED).map(|one| one.path.as_str()).collect();
            if self.0.len() > NAMED {
                names.push("...");
            }
            names.join(", ")
        };
        let matching = |wanted: &str| -> Vec<&Signal> {
            let whole: Vec<_> = self.0.iter().filter(|one| one.path == wanted).collect();
            if !whole.is_empty() {
                return whole;
            }
            let last = |path: &str| path.rsplit('.').next().is_some_and(|last| last == wanted);
            self.0.iter().filter(|one| last(&one.path)).collect()
        };
        let found = match wanted {
            Some(wanted) => matching(wanted),
            None => self.0.iter().collect(),
        };
        match (&found[..], wanted) {
            // The same wire may have several names.
            ([first, rest @ ..], _) if rest.iter().all(|other| other.code == first.code) => {
                Ok((first.path.clone(), first.code))
            }
            ([], Some(wanted)) => {
                let message = format!("the dump has no one-bit signal '{wanted}'");
                Err(vec![fault(file, message, format!("its signals are {}", names()))])
            }
            ([], None) => {
                Err(vec![fault(file, "the dump has no one-bit signal", "capture the scan's pulse")])
            }
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

//! Executes one scan of a code symbolically.

use super::circuit::{Circuit, Function};
use super::words::{Line, Word};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use std::collections::{BTreeMap, BTreeSet};

/// A value, as two functions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Value {
    /// As a function of the values written so far. A difference here shows where an error is made.
    pub(super) near: Function,
    /// As a function of the relays at the start of the scan.
    pub(super) deep: Function,
}

impl Value {
    fn and(self, other: Value, circuit: &mut Circuit) -> Value {
        let near = circuit.and(self.near, other.near);
        Value { near, deep: circuit.and(self.deep, other.deep) }
    }

    fn or(self, other: Value, circuit: &mut Circuit) -> Value {
        let near = circuit.or(self.near, other.near);
        Value { near, deep: circuit.or(self.deep, other.deep) }
    }

    fn not(self, circuit: &mut Circuit) -> Value {
        let near = circuit.not(self.near);
        Value { near, deep: circuit.not(self.deep) }
    }
}

/// The value of a relay, or the condition of a timer or counter.
#[derive(Debug, Clone)]
pub(super) struct Given {
    pub(super) line: u32,
    pub(super) text: String,
    pub(super) value: Value,
    pub(super) setting: String,
}

/// A counter that counts after its reset.
#[derive(Debug)]
pub(super) struct LateCount {
    /// The line where it counts.
    pub(super) line: Line,
    pub(super) counter: String,
    /// The line of its reset.
    pub(super) reset: u32,
}

/// The effect of one scan.
#[derive(Debug, Default)]
pub(super) struct Done {
    /// The last value of each relay by name; timers and counters by the name of their input.
    pub(super) given: BTreeMap<String, Given>,
    pub(super) late: Vec<LateCount>,
}

/// Executes one scan of a code; `own` are the net's relays.
pub(super) fn scan(
    lines: &[Line],
    own: &BTreeSet<String>,
    file: &str,
    circuit: &mut Circuit,
) -> Result<Done, Diagnostic> {
    let mut scan = Scan {
        circuit,
        own,
        now: BTreeMap::new(),
        stack: Vec::new(),
        is_out: false,
        done: Done::default(),
    };
    for line in lines.iter().take_while(|line| line.word != Word::End) {
        scan.carry_out(line).ok_or_else(|| {
            let message = "the instruction has too few conditions before it";
            let help = "check that the list is complete";
            Diagnostic::line(Code::NoCondition, file, line.line, line.text.as_str(), message, help)
        })?;
    }
    Ok(scan.done)
}

/// The state during the scan.
struct Scan<'a> {
    circuit: &'a mut Circuit,
    own: &'a BTreeSet<String>,
    /// The current value of each written relay.
    now: BTreeMap<String, Value>,
    stack: Vec<Value>,
    /// Whether the last instruction was an output, so that the next LD begins a new condition.
    is_out: bool,
    done: Done,
}

impl Scan<'_> {
    /// Executes an instruction; `None` if it has too few conditions before it.
    fn carry_out(&mut self, line: &Line) -> Option<()> {
        let begins_anew = std::mem::take(&mut self.is_out);
        match &line.word {
            Word::Load(is_closed, name) => {
                if begins_anew {
                    self.stack.clear();
                }
                let value = self.contact(name, *is_closed);
                self.stack.push(value);
            }
            Word::And(is_closed, name) => {
                let (one, other) = (self.stack.pop()?, self.contact(name, *is_closed));
                self.stack.push(one.and(other, self.circuit));
            }
            Word::Or(is_closed, name) => {
                let (one, other) = (self.stack.pop()?, self.contact(name, *is_closed));
                self.stack.push(one.or(other, self.circuit));
            }
            Word::AndBlock => {
                let (other, one) = (self.stack.pop()?, self.stack.pop()?);
                self.stack.push(one.and(other, self.circuit));
            }
            Word::OrBlock => {
                let (other, one) = (self.stack.pop()?, self.stack.pop()?);
                self.stack.push(one.or(other, self.circuit));
            }
            Word::Out(is_inverted, name) => {
                let value = self.top()?;
                let value = if *is_inverted { value.not(self.circuit) } else { value };
                self.write(line, name, value);
            }
            Word::Set(name) => {
                let (condition, before) = (self.top()?, self.contact(name, false));
                let value = condition.or(before, self.circuit);
                self.write(line, name, value);
            }
            Word::Reset(name) => {
                let (condition, before) = (self.top()?, self.contact(name, false));
                let value = condition.not(self.circuit).and(before, self.circuit);
                self.write(line, name, value);
            }
            Word::Keep(name) => {
                let ([set, reset], before) = (self.top_two()?, self.contact(name, false));
                let on = set.or(before, self.circuit);
                let value = on.and(reset.not(self.circuit), self.circuit);
                self.write(line, name, value);
            }
            Word::Timer(name, setting) => {
                let condition = self.top()?;
                self.give(line, format!("{name}, condition"), condition, setting);
                self.run(name);
            }
            Word::Counter(name, setting) => {
                let [count, reset] = self.top_two()?;
                self.give(line, format!("{name}, count"), count, setting);
                self.give(line, format!("{name}, reset"), reset, "");
                self.run(name);
            }
            Word::Count(name, setting) => {
                let reset = self.done.given.get(&format!("{name}, reset")).map(|one| one.line);
                let (line, counter) = (line.clone(), name.clone());
                let count = self.top()?;
                self.give(&line, format!("{name}, count"), count, setting);
                self.done.late.extend(reset.map(|reset| LateCount { line, counter, reset }));
                self.run(name);
            }
            Word::ResetCounter(name) => {
                let reset = self.top()?;
                self.give(line, format!("{name}, reset"), reset, "");
                self.run(name);
            }
            Word::End => {}
        }
        Some(())
    }

    /// The last condition.
    fn top(&self) -> Option<Value> {
        self.stack.last().copied()
    }

    /// The last two conditions, in their order.
    fn top_two(&self) -> Option<[Value; 2]> {
        self.stack.last_chunk().copied()
    }

    fn contact(&mut self, name: &str, is_closed: bool) -> Value {
        let start = self.circuit.value(name);
        let value = self.now.get(name).copied().unwrap_or(Value { near: start, deep: start });
        if is_closed { value.not(self.circuit) } else { value }
    }

    fn give(&mut self, line: &Line, name: String, value: Value, setting: &str) {
        let (text, setting) = (line.text.clone(), setting.to_owned());
        self.done.given.insert(name, Given { line: line.line, text, value, setting });
    }

    /// Writes a relay. From here on, one of the net's own relays is a new variable; others have the written value.
    fn write(&mut self, line: &Line, name: &str, value: Value) {
        self.give(line, name.to_owned(), value, "");
        let near = match self.own.contains(name) {
            true => self.circuit.value(&in_this_scan(name)),
            false => value.near,
        };
        self.now.insert(name.to_owned(), Value { near, deep: value.deep });
        self.is_out = true;
    }

    /// From here on, the contact of a timer or counter is its value of this scan.
    fn run(&mut self, name: &str) {
        let now = self.circuit.value(&in_this_scan(name));
        self.now.insert(name.to_owned(), Value { near: now, deep: now });
        self.is_out = true;
    }
}

/// The variable for a relay, timer or counter after it was written or executed in this scan.
fn in_this_scan(name: &str) -> String {
    format!("{name} in this scan")
}

/// The relay, timer or counter that a variable or input name belongs to.
pub(super) fn owner(name: &str) -> &str {
    name.split(',').next().unwrap_or(name).trim_end_matches(" in this scan")
}

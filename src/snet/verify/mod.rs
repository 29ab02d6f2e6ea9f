//! Holds code against a net: every relay's next value, every timer's and counter's conditions, as functions of relays.
//!
//! Instructions are carried out in their order. Each function is compared, by satisfiability, with the one of the net's own
//! code: first over what was last written before it, so that a fault is told where it is made; where that differs, over the
//! relays as they are when the scan starts, since other code may come to the same. If nothing differs, both do the same in
//! every scan, whatever they begin with.

mod circuit;
mod melsec;
mod words;

use super::Diagram;
use super::translate::{Listing, Operand};
use crate::base::code::Code;
use crate::base::diagnostic::Diagnostic;
use circuit::{Circuit, Function};
use std::collections::{BTreeMap, BTreeSet};
use words::{Line, Word, name, of_net, read};

/// Where code and net differ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The line of the code that gives the value; none where there is no such line.
    pub line: Option<u32>,
    /// What stands there.
    pub text: String,
    /// What differs.
    pub message: String,
    /// Values of relays with which it does.
    pub values: Vec<(String, bool)>,
}

/// Functions over what was last written, and over the start of the scan.
type Pair = (Function, Function);

/// What a relay is given, or under which condition a timer or counter runs.
#[derive(Debug, Clone)]
struct Given {
    line: u32,
    text: String,
    value: Pair,
    setting: String,
}

/// One scan of a code.
#[derive(Debug, Default)]
struct Scan {
    /// What stands for a relay that was written.
    now: BTreeMap<String, Pair>,
    /// The last that each is given: relays by their names, timers and counters with the name of their input.
    given: BTreeMap<String, Given>,
    stack: Vec<Pair>,
    /// Where a counter counts behind its reset, with its name and the reset's line.
    early: Vec<(Line, String, u32)>,
    /// Whether the last instruction was an output, so that the next LD begins anew.
    is_out: bool,
}

impl Scan {
    fn contact(&self, name: &str, is_closed: bool, circuit: &mut Circuit) -> Pair {
        let start = circuit.value(name);
        let (near, deep) = self.now.get(name).copied().unwrap_or((start, start));
        if is_closed { (circuit.not(near), circuit.not(deep)) } else { (near, deep) }
    }

    fn give(&mut self, line: &Line, name: String, value: Pair, setting: &str) {
        let (text, setting) = (line.text.clone(), setting.to_owned());
        self.given.insert(name, Given { line: line.line, text, value, setting });
    }

    /// A relay is written. The net's own relays stand for themselves from here on, others for what they are given.
    fn write(
        &mut self,
        line: &Line,
        name: &str,
        value: Pair,
        own: &BTreeSet<String>,
        circuit: &mut Circuit,
    ) {
        self.give(line, name.to_owned(), value, "");
        let near = if own.contains(name) {
            circuit.value(&format!("{name} in this scan"))
        } else {
            value.0
        };
        self.now.insert(name.to_owned(), (near, value.1));
    }
}

fn scan(
    lines: &[Line],
    own: &BTreeSet<String>,
    file: &str,
    circuit: &mut Circuit,
) -> Result<Scan, Diagnostic> {
    let mut scan = Scan::default();
    for line in lines {
        let fault = || {
            let message = "the instruction has too few conditions in front of it";
            let help = "see that the list is whole";
            Diagnostic::line(Code::NoCondition, file, line.line, line.text.as_str(), message, help)
        };
        let top = |scan: &Scan, below: usize| -> Result<Pair, Diagnostic> {
            let at = scan.stack.len().checked_sub(below + 1).ok_or_else(fault)?;
            Ok(scan.stack[at])
        };
        let is_out = std::mem::take(&mut scan.is_out);
        match &line.word {
            Word::Load(is_closed, name) => {
                if is_out {
                    scan.stack.clear();
                }
                let value = scan.contact(name, *is_closed, circuit);
                scan.stack.push(value);
            }
            Word::And(is_closed, name) => {
                let (one, other) = (top(&scan, 0)?, scan.contact(name, *is_closed, circuit));
                scan.stack.pop();
                scan.stack.push((circuit.and(one.0, other.0), circuit.and(one.1, other.1)));
            }
            Word::Or(is_closed, name) => {
                let (one, other) = (top(&scan, 0)?, scan.contact(name, *is_closed, circuit));
                scan.stack.pop();
                scan.stack.push((circuit.or(one.0, other.0), circuit.or(one.1, other.1)));
            }
            Word::AndBlock | Word::OrBlock => {
                let (one, other) = (top(&scan, 1)?, top(&scan, 0)?);
                scan.stack.truncate(scan.stack.len() - 2);
                scan.stack.push(if line.word == Word::AndBlock {
                    (circuit.and(one.0, other.0), circuit.and(one.1, other.1))
                } else {
                    (circuit.or(one.0, other.0), circuit.or(one.1, other.1))
                });
            }
            Word::Out(is_inverted, name) => {
                let mut value = top(&scan, 0)?;
                if *is_inverted {
                    value = (circuit.not(value.0), circuit.not(value.1));
                }
                scan.write(line, name, value, own, circuit);
                scan.is_out = true;
            }
            Word::Set(name) => {
                let (condition, before) = (top(&scan, 0)?, scan.contact(name, false, circuit));
                let value = (circuit.or(condition.0, before.0), circuit.or(condition.1, before.1));
                scan.write(line, name, value, own, circuit);
                scan.is_out = true;
            }
            Word::Reset(name) => {
                let (condition, before) = (top(&scan, 0)?, scan.contact(name, false, circuit));
                let not = (circuit.not(condition.0), circuit.not(condition.1));
                let value = (circuit.and(not.0, before.0), circuit.and(not.1, before.1));
                scan.write(line, name, value, own, circuit);
                scan.is_out = true;
            }
            Word::Keep(name) => {
                let (set, reset) = (top(&scan, 1)?, top(&scan, 0)?);
                let before = scan.contact(name, false, circuit);
                let on = (circuit.or(set.0, before.0), circuit.or(set.1, before.1));
                let not = (circuit.not(reset.0), circuit.not(reset.1));
                let value = (circuit.and(on.0, not.0), circuit.and(on.1, not.1));
                scan.write(line, name, value, own, circuit);
                scan.is_out = true;
            }
            Word::Timer(name, setting) => {
                let condition = top(&scan, 0)?;
                scan.give(line, format!("{name}, condition"), condition, setting);
                run(&mut scan, name, circuit);
            }
            Word::Counter(name, setting) => {
                let (count, reset) = (top(&scan, 1)?, top(&scan, 0)?);
                scan.give(line, format!("{name}, count"), count, setting);
                scan.give(line, format!("{name}, reset"), reset, "");
                run(&mut scan, name, circuit);
            }
            Word::Count(name, setting) => {
                let reset = scan.given.get(&format!("{name}, reset")).map(|one| one.line);
                scan.early.extend(reset.map(|reset| (line.clone(), name.clone(), reset)));
                let count = top(&scan, 0)?;
                scan.give(line, format!("{name}, count"), count, setting);
                run(&mut scan, name, circuit);
            }
            Word::ResetCounter(name) => {
                let reset = top(&scan, 0)?;
                scan.give(line, format!("{name}, reset"), reset, "");
                run(&mut scan, name, circuit);
            }
            Word::End => break,
        }
    }
    Ok(scan)
}

/// From here on a timer's or counter's contact is what it comes to in this scan.
fn run(scan: &mut Scan, name: &str, circuit: &mut Circuit) {
    let now = circuit.value(&format!("{name} in this scan"));
    scan.now.insert(name.to_owned(), (now, now));
    scan.is_out = true;
}

/// Holds a code against the net's own.
///
/// # Errors
/// What of the code is not understood, with its line.
pub fn verify(
    diagram: &Diagram,
    listing: &Listing,
    file: &str,
    code: &str,
) -> Result<Vec<Difference>, Vec<Diagnostic>> {
    let outers: BTreeSet<String> =
        (0..diagram.outers.len()).map(|at| name(diagram, Operand::Outer(at))).collect();
    let lines = if melsec::is_melsec(code) {
        melsec::read(file, code, &outers)?
    } else {
        read(file, code)?
    };
    let mut circuit = Circuit::default();
    let wanted = of_net(diagram, listing);
    let own: BTreeSet<String> = wanted
        .iter()
        .filter_map(|line| match &line.word {
            Word::Out(_, name) => Some(name.clone()),
            _ => None,
        })
        .collect();
    let net = scan(&wanted, &own, &diagram.file, &mut circuit).map_err(|fault| vec![fault])?;
    let found = scan(&lines, &own, file, &mut circuit).map_err(|fault| vec![fault])?;
    let called = called(diagram);
    let tell = |name: &str| {
        let relay = name.split([',']).next().unwrap_or(name).trim_end_matches(" in this scan");
        called.get(relay).map_or(name.to_owned(), |own| format!("{own} ({name})"))
    };
    let mut differences = Vec::new();
    for (name, wanted) in &net.given {
        let Some(given) = found.given.get(name) else {
            let message = format!("nothing gives {}", tell(name));
            differences.push(Difference {
                line: None,
                text: String::new(),
                message,
                values: Vec::new(),
            });
            continue;
        };
        let mut add = |message: String, values: Vec<(String, bool)>| {
            let values = values.into_iter().map(|(own, value)| (tell(&own), value)).collect();
            differences.push(Difference {
                line: Some(given.line),
                text: given.text.clone(),
                message,
                values,
            });
        };
        if given.setting != wanted.setting {
            let number =
                |text: &str| if text.is_empty() { "0".to_owned() } else { text.to_owned() };
            let (is, should) = (number(&given.setting), number(&wanted.setting));
            add(format!("{} is set to {is}, and the net says {should}", tell(name)), Vec::new());
        }
        if let Some(values) = circuit.difference(given.value.0, wanted.value.0)
            && circuit.difference(given.value.1, wanted.value.1).is_some()
        {
            add(format!("{} is not what the net says", tell(name)), values);
        }
    }
    for (line, name, reset) in &found.early {
        let message = format!(
            "{} counts behind its reset in line {reset}: it would count in the scan that resets it",
            tell(name)
        );
        let (line, text) = (Some(line.line), line.text.clone());
        differences.push(Difference { line, text, message, values: Vec::new() });
    }
    // Outer gates come from outside.
    for outer in 0..diagram.outers.len() {
        let name = name(diagram, Operand::Outer(outer));
        if let Some(given) = found.given.get(&name) {
            let message = format!("{} is written, and comes from outside", tell(&name));
            let (line, text) = (Some(given.line), given.text.clone());
            differences.push(Difference { line, text, message, values: Vec::new() });
        }
    }
    differences.sort_by_key(|one| one.line.unwrap_or(u32::MAX));
    Ok(differences)
}

/// What the net calls each relay, timer and counter.
fn called(diagram: &Diagram) -> BTreeMap<String, String> {
    let transitions = (0..diagram.transitions.len())
        .map(|at| (name(diagram, Operand::Transition(at)), diagram.transition_name(at)));
    let places = (0..diagram.places.len()).flat_map(|at| {
        let own = diagram.place_name(at);
        [Operand::Place(at), Operand::Contact(at)]
            .map(|operand| (name(diagram, operand), own.clone()))
    });
    let outers = (0..diagram.outers.len())
        .map(|at| (name(diagram, Operand::Outer(at)), diagram.outers[at].head.name.clone()));
    transitions.chain(places).chain(outers).collect()
}

#[cfg(test)]
mod tests;

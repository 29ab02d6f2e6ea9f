//! Holds code against a net: every relay's next value, every timer's and counter's conditions, as functions of relays.
//!
//! Instructions are carried out in their order. Each function is compared, by satisfiability, with the one of the net's own
//! code: first over what was last written before it, so that a fault is told where it is made; where that differs, over the
//! relays as they are when the scan starts, since other code may come to the same. If nothing differs, both do the same in
//! every scan, whatever they begin with.

mod circuit;
mod melsec;
mod scan;
mod words;

use super::Diagram;
use super::translate::{Listing, Operand};
use circuit::Circuit;
use scan::{Given, LateCount, owner, scan};
use scanbound_base::diagnostic::Diagnostic;
use std::collections::{BTreeMap, BTreeSet};
use words::{Word, name, of_net, read};

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
    let telling = Telling { circuit: &circuit, called: called(diagram) };
    let mut differences = Vec::new();
    for (name, wanted) in &net.given {
        differences.extend(telling.compared(name, found.given.get(name), wanted));
    }
    differences.extend(found.late.iter().map(|one| telling.late(one)));
    // Outer gates come from outside.
    let written = outers.iter().filter_map(|name| Some((name, found.given.get(name)?)));
    differences.extend(written.map(|(name, given)| {
        let message = format!("{} is written, and comes from outside", telling.name(name));
        given.differs(message, Vec::new())
    }));
    differences.sort_by_key(|one| one.line.unwrap_or(u32::MAX));
    Ok(differences)
}

impl Given {
    fn differs(&self, message: String, values: Vec<(String, bool)>) -> Difference {
        Difference { line: Some(self.line), text: self.text.clone(), message, values }
    }
}

/// Tells of differences, by the net's names.
struct Telling<'a> {
    circuit: &'a Circuit,
    /// What the net calls each relay, timer and counter.
    called: BTreeMap<String, String>,
}

impl Telling<'_> {
    fn name(&self, name: &str) -> String {
        let own = self.called.get(owner(name));
        own.map_or(name.to_owned(), |own| format!("{own} ({name})"))
    }

    /// How what is given differs from what is wanted.
    fn compared(&self, name: &str, given: Option<&Given>, wanted: &Given) -> Vec<Difference> {
        let told = self.name(name);
        let Some(given) = given else {
            let message = format!("nothing gives {told}");
            return vec![Difference {
                line: None,
                text: String::new(),
                message,
                values: Vec::new(),
            }];
        };
        let mut found = Vec::new();
        if given.setting != wanted.setting {
            let number = |text: &str| if text.is_empty() { "0" } else { text }.to_owned();
            let (is, should) = (number(&given.setting), number(&wanted.setting));
            let message = format!("{told} is set to {is}, and the net says {should}");
            found.push(given.differs(message, Vec::new()));
        }
        let differ = |one, other| self.circuit.difference(one, other);
        if let Some(values) = differ(given.value.near, wanted.value.near)
            && differ(given.value.deep, wanted.value.deep).is_some()
        {
            let values = values.into_iter().map(|(own, value)| (self.name(&own), value)).collect();
            found.push(given.differs(format!("{told} is not what the net says"), values));
        }
        found
    }

    fn late(&self, one: &LateCount) -> Difference {
        let message = format!(
            "{} counts behind its reset in line {}: it would count in the scan that resets it",
            self.name(&one.counter),
            one.reset
        );
        let (line, text) = (Some(one.line.line), one.line.text.clone());
        Difference { line, text, message, values: Vec::new() }
    }
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

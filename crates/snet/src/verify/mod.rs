//! Verifies code against a net: compares each relay's next value, and each timer's and counter's conditions, as
//! functions of relays.
//!
//! Instructions are executed symbolically in their order. A SAT solver compares each function with the one of the net's
//! own code: first as a function of the values written so far, so that an error is reported where it is made; if these
//! differ, as a function of the relays at the start of the scan, because other code may compute the same. If nothing
//! differs, both codes do the same in each scan, from any start state.

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

/// A difference between code and net.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The line of the code that writes the value; `None` if there is no such line.
    pub line: Option<u32>,
    /// The text of this line.
    pub text: String,
    /// What differs.
    pub message: String,
    /// Values of relays for which they differ.
    pub values: Vec<(String, bool)>,
}

/// Compares a code with the net's own code.
///
/// # Errors
/// Instructions of the code that are not supported, with their lines.
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
    let describer = Describer { circuit: &circuit, called: called(diagram) };
    let mut differences = Vec::new();
    for (name, wanted) in &net.given {
        differences.extend(describer.compared(name, found.given.get(name), wanted));
    }
    differences.extend(found.late.iter().map(|one| describer.late(one)));
    // Outer gates are inputs, so the code must not write them.
    let written = outers.iter().filter_map(|name| Some((name, found.given.get(name)?)));
    differences.extend(written.map(|(name, given)| {
        let message = format!("{} is written, but it is an input of the net", describer.name(name));
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

/// Describes differences with the net's names.
struct Describer<'a> {
    circuit: &'a Circuit,
    /// The name of each relay, timer and counter in the net.
    called: BTreeMap<String, String>,
}

impl Describer<'_> {
    fn name(&self, name: &str) -> String {
        let own = self.called.get(owner(name));
        own.map_or(name.to_owned(), |own| format!("{own} ({name})"))
    }

    /// The differences between a given and an expected function.
    fn compared(&self, name: &str, given: Option<&Given>, wanted: &Given) -> Vec<Difference> {
        let told = self.name(name);
        let Some(given) = given else {
            let message = format!("the code does not write {told}");
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
            let message = format!("{told} has the set value {is}, but the net has {should}");
            found.push(given.differs(message, Vec::new()));
        }
        let differ = |one, other| self.circuit.difference(one, other);
        if let Some(values) = differ(given.value.near, wanted.value.near)
            && differ(given.value.deep, wanted.value.deep).is_some()
        {
            let values = values.into_iter().map(|(own, value)| (self.name(&own), value)).collect();
            found.push(given.differs(format!("{told} differs from the net"), values));
        }
        found
    }

    fn late(&self, one: &LateCount) -> Difference {
        let message = format!(
            "{} counts after its reset in line {}, so it would count in the scan that resets it",
            self.name(&one.counter),
            one.reset
        );
        let (line, text) = (Some(one.line.line), one.line.text.clone());
        Difference { line, text, message, values: Vec::new() }
    }
}

/// The net's name of each relay, timer and counter.
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

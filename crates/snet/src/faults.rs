//! Checks the structure of a net: elements with a wrong number of arcs, addresses that are used twice or cannot be
//! used.

use super::address::Address;
use super::{Diagram, Direction, Head, Kind};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use std::collections::BTreeMap;

/// All errors in a net's structure and addresses, in the order of their lines.
#[must_use]
pub fn faults(diagram: &Diagram) -> Vec<Diagnostic> {
    let mut found = structure(diagram);
    found.extend(addresses(diagram));
    found.sort_by_key(|fault| fault.line);
    found
}

fn fault(diagram: &Diagram, code: Code, line: u32, message: String, help: &str) -> Diagnostic {
    Diagnostic::line(code, &diagram.file, line, "", message, help)
}

fn structure(diagram: &Diagram) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for (at, place) in diagram.places.iter().enumerate() {
        let count = |direction| diagram.transitions_of(at, direction).count();
        let (inputs, outputs, stops) =
            (count(Direction::OutOf), count(Direction::Into), count(Direction::Stop));
        let name = diagram.place_name(at);
        let mut tell = |message: String, help: &str| {
            found.push(fault(diagram, Code::NetElement, place.head.line, message, help));
        };
        match place.kind {
            Kind::Box if inputs + outputs == 0 => tell(
                format!("the box {name} has no arc from or to a transition"),
                "connect it with a transition, or remove it",
            ),
            Kind::Timer { .. } if outputs != 1 => tell(
                format!("the timer {name} has {outputs} arcs to transitions, but must have one"),
                "lead one arc from the timer to a transition; to branch, lead that transition to a box, and branch from the box",
            ),
            Kind::Counter { .. } if inputs != 1 || outputs != 1 => tell(
                format!(
                    "the counter {name} has {inputs} arcs from transitions and {outputs} to transitions, but must have one of each"
                ),
                "use one transition before the counter and one after it",
            ),
            _ => {}
        }
        if stops > 1 {
            tell(
                format!("{name} has {stops} arcs to emergency stops, but may have only one"),
                "use one emergency-stop transition with all gates that stop it",
            );
        }
    }
    for (at, transition) in diagram.transitions.iter().enumerate() {
        let name = diagram.transition_name(at);
        if diagram.arcs.iter().all(|arc| arc.transition != at) {
            let (message, help) = if transition.is_stop {
                (
                    format!("the emergency stop {name} has no arc: it stops nothing"),
                    "write the places that it stops: stop T00 : B01 B02 *-> if E09",
                )
            } else {
                (
                    format!("the transition {name} has no arc"),
                    "connect it with a box (transition T01 : B01 -> B02), or remove it",
                )
            };
            found.push(fault(diagram, Code::NetElement, transition.head.line, message, help));
        }
    }
    found.extend(doubled(diagram));
    found
}

/// Two arcs of one direction between the same two elements.
fn doubled(diagram: &Diagram) -> Vec<Diagnostic> {
    let mut seen = BTreeMap::new();
    let mut found = Vec::new();
    for arc in &diagram.arcs {
        let key = (arc.place, arc.transition, arc.direction);
        if let Some(line) = seen.insert(key, arc.line) {
            let (place, transition) =
                (diagram.place_name(arc.place), diagram.transition_name(arc.transition));
            let message =
                format!("{place} and {transition} already have the same arc in line {line}");
            let help = "remove this arc";
            found.push(fault(diagram, Code::NetArc, arc.line, message, help));
        }
    }
    found
}

fn addresses(diagram: &Diagram) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut relays = BTreeMap::new();
    let written = (diagram.transitions.iter().enumerate())
        .map(|(at, one)| (diagram.transition_name(at), &one.head))
        .chain(
            diagram.places.iter().enumerate().map(|(at, one)| (diagram.place_name(at), &one.head)),
        );
    let read = diagram.outers.iter().map(|one| (one.head.name.clone(), &one.head));
    let all: Vec<(String, &Head, bool)> = (written.map(|(name, head)| (name, head, true)))
        .chain(read.map(|(name, head)| (name, head, false)))
        .collect();
    let is_input = |head: &&Head| head.address.is_some_and(Address::is_point);
    let inputs: Vec<&Head> = diagram.outers.iter().map(|one| &one.head).filter(is_input).collect();
    for (name, head, is_written) in all {
        let Some(address) = head.address else { continue };
        let mut tell = |message: String, help: &str| {
            found.push(fault(diagram, Code::NetAddress, head.line, message, help));
        };
        let is_same = |outer: &&Head| outer.address == Some(address);
        let input = inputs.iter().find(|outer| {
            outer.address.is_some_and(|input| input.word == address.word)
                && !inputs.iter().any(is_same)
        });
        if let (true, true, Some(outer)) = (is_written, address.is_point(), input) {
            tell(
                format!(
                    "{name} = {address}: the CPU overwrites word {:03} when it reads the inputs, because the outer gate {} in line {} is in it",
                    address.word, outer.name, outer.line
                ),
                "give it a relay in a word without outer gates",
            );
        }
        if is_written && !address.is_writable() {
            tell(
                format!("{name} = {address}: the CPU itself writes this relay"),
                "give it a relay from 00000 to 23515, HR or LR",
            );
        }
        match relays.get(&address) {
            Some((other, line)) => tell(
                format!("{name} = {address}: {other} in line {line} already has this relay"),
                "give each element a different relay",
            ),
            None => drop(relays.insert(address, (name, head.line))),
        }
    }
    found.extend(numbers(diagram));
    found
}

/// Checks the numbers of timers and counters, which share one set.
fn numbers(diagram: &Diagram) -> Vec<Diagnostic> {
    let mut seen: BTreeMap<u16, (String, u32)> = BTreeMap::new();
    let mut found = Vec::new();
    for (at, place) in diagram.places.iter().enumerate() {
        let (Kind::Timer { number: Some(number), .. } | Kind::Counter { number: Some(number), .. }) =
            place.kind
        else {
            continue;
        };
        let name = diagram.place_name(at);
        if let Some((other, line)) = seen.get(&number) {
            let message =
                format!("{name} has number {number:03}, but {other} in line {line} has it too");
            let help = "give each timer and counter a different number, 000 to 511";
            found.push(fault(diagram, Code::NetAddress, place.head.line, message, help));
        } else {
            seen.insert(number, (name, place.head.line));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::read;

    fn told(text: &str) -> Vec<(u32, String)> {
        let diagram = read("n.snet", text).expect("a net");
        faults(&diagram).into_iter().map(|one| (one.line.unwrap_or(0), one.message)).collect()
    }

    #[test]
    fn a_net_that_hangs_together_has_no_faults() {
        assert_eq!(
            told("box B01\ntimer TM 1s\ntransition T01 : B01 -> TM\ntransition T02 : TM ->"),
            []
        );
    }

    #[test]
    fn elements_without_arcs_or_with_too_many_are_told_with_their_lines() {
        let text = "box B01\ntimer TM 1s\ncounter CN 3\ntransition T01\nstop T00\nstop T09 : TM *->\nstop T08 : TM *->";
        let lines: Vec<u32> = told(text).into_iter().map(|(line, _)| line).collect();
        assert_eq!(lines, [1, 2, 2, 3, 4, 5]);
        let twice = told(
            "timer TM 1s\ntransition T1 : -> TM\ntransition T2 : TM ->\ntransition T3 : TM ->",
        );
        assert_eq!(twice.len(), 1);
        assert!(twice[0].1.contains("2 arcs to transitions"), "{twice:?}");
        let arcs = told("box B\ntransition T : B ->\narc B -> T");
        assert!(arcs.len() == 1 && arcs[0].0 == 3, "{arcs:?}");
    }

    #[test]
    fn addresses_are_given_once_and_to_what_can_have_them() {
        let net = "outer E = 00001\nbox B = 00001\nbox C = 25315\ntimer TM 1s TIM 5\ncounter CN 2 CNT 005\n\
                   transition T : B -> TM C\ntransition U : TM -> CN\ntransition V : CN -> if E";
        let found = told(net);
        assert_eq!(found.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [1, 3, 5], "{found:?}");
        assert!(told("outer E = 25500\nbox B\ntransition T : B -> if E").is_empty());
    }

    #[test]
    fn nothing_is_written_where_inputs_are_read() {
        let net = "outer E = 00001\nouter F = 03000\nbox B = 00002\nbox C = 03001\ntransition T = 00003 : B -> C if E\n\
                   transition U = 00100 : C -> B if F";
        let found = told(net);
        assert_eq!(found.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [3, 5], "{found:?}");
        assert!(found[0].1.contains("the CPU overwrites word 000"), "{found:?}");
    }
}

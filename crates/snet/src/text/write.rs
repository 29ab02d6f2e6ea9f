//! Writes a net as text. Reading it gives the same net.

use super::super::{Diagram, Direction, Gate, Head, Kind, Signal};
use std::fmt::Write as _;

/// The net as text.
#[must_use]
pub fn write(diagram: &Diagram) -> String {
    let mut out = String::new();
    if !diagram.name.is_empty() {
        line(&mut out, format_args!("net {}", diagram.name));
    }
    for outer in &diagram.outers {
        line(&mut out, format_args!("outer {}{}", outer.head.name, tail(&outer.head)));
    }
    for (page, own) in diagram.pages.iter().enumerate() {
        if !out.is_empty() {
            out.push('\n');
        }
        line(&mut out, format_args!("page {}", own.name));
        places(diagram, page, &mut out);
        transitions(diagram, page, &mut out);
        for arbiter in diagram.arbiters.iter().filter(|one| one.head.page == page) {
            let of = |&at: &usize| reference(diagram, page, &diagram.transitions[at].head);
            let names: Vec<String> = arbiter.transitions.iter().map(of).collect();
            let (name, rest) = (&arbiter.head.name, tail(&arbiter.head));
            line(&mut out, format_args!("arbiter {name}{rest} : {}", names.join(" ")));
        }
    }
    out
}

fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{text}");
}

/// The address and the drawing position.
fn tail(head: &Head) -> String {
    let address = head.address.map_or(String::new(), |address| format!(" = {address}"));
    let at = head.at.map_or(String::new(), |at| format!(" at {},{}", at.x, at.y));
    address + &at
}

fn places(diagram: &Diagram, page: usize, out: &mut String) {
    for place in diagram.places.iter().filter(|place| place.head.page == page) {
        let (name, rest) = (&place.head.name, tail(&place.head));
        let marked = if place.is_marked { " marked" } else { "" };
        let numbered = |letters: &str, number: Option<u16>| {
            number.map_or(String::new(), |number| format!(" {letters} {number:03}"))
        };
        match place.kind {
            Kind::Box => line(out, format_args!("box {name}{marked}{rest}")),
            Kind::Timer { number, tenths } => {
                let (value, own) = (seconds(tenths), numbered("TIM", number));
                line(out, format_args!("timer {name} {value}{marked}{own}{rest}"));
            }
            Kind::Counter { number, count } => {
                let own = numbered("CNT", number);
                line(out, format_args!("counter {name} {count}{marked}{own}{rest}"));
            }
        }
    }
}

/// Tenths of a second in the notation of the text: `5.0s`.
fn seconds(tenths: u16) -> String {
    format!("{}.{}s", tenths / 10, tenths % 10)
}

fn transitions(diagram: &Diagram, page: usize, out: &mut String) {
    for (at, transition) in diagram.transitions.iter().enumerate() {
        if transition.head.page != page {
            continue;
        }
        let joined = |direction: Direction| -> String {
            let places = diagram.places_of(at, direction);
            places
                .map(|place| format!(" {}", reference(diagram, page, &diagram.places[place].head)))
                .collect()
        };
        let mut gates: String =
            diagram.gates_of(at).map(|gate| self::gate(diagram, page, gate)).collect();
        if !gates.is_empty() {
            gates.insert_str(0, " if");
        }
        let (name, rest) = (&transition.head.name, tail(&transition.head));
        let arcs = if transition.is_stop {
            format!("{} *->", joined(Direction::Stop))
        } else {
            format!("{} ->{}", joined(Direction::Into), joined(Direction::OutOf))
        };
        let word = if transition.is_stop { "stop" } else { "transition" };
        line(out, format_args!("{word} {name}{rest} :{arcs}{gates}"));
    }
}

fn gate(diagram: &Diagram, page: usize, gate: &Gate) -> String {
    let not = if gate.is_inhibiting { "not " } else { "" };
    let name = match gate.signal {
        Signal::Place(place) => reference(diagram, page, &diagram.places[place].head),
        Signal::Outer(outer) => diagram.outers[outer].head.name.clone(),
    };
    format!(" {not}{name}")
}

/// An element's name, as it must be written on this page.
fn reference(diagram: &Diagram, page: usize, head: &Head) -> String {
    if head.page == page {
        return head.name.clone();
    }
    format!("{}.{}", diagram.pages[head.page].name, head.name)
}

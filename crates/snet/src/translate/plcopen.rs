//! Writes a net as a sequential function chart, if possible: boxes become steps.
//!
//! A chart has no emergency stops and no counters, and each of its transitions needs a step before and after it. The
//! other parts of the firing rule (empty output boxes, gates) become part of the transition condition.

use crate::address::Area;
use crate::{Diagram, Direction, Head, Kind, Signal};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use std::fmt::Write as _;

/// Writes the net as PLCopen XML.
///
/// # Errors
/// Elements that a chart cannot have, with their lines.
pub fn write(diagram: &Diagram) -> Result<String, Vec<Diagnostic>> {
    let faults = refused(diagram);
    if !faults.is_empty() {
        return Err(faults);
    }
    let whole = |message: String| {
        vec![Diagnostic::file(Code::NetElement, &diagram.file, message, "use --to c200h")]
    };
    let project = scanbound_iec::read(&diagram.file, &text(diagram)).map_err(|faults| {
        whole(format!("the net cannot be written as a chart: {}", faults[0].message))
    })?;
    scanbound_iec::xml::write::project(&project)
        .map_err(|why| whole(format!("the net cannot be written as a chart: {why}")))
}

fn refused(diagram: &Diagram) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut tell = |head: &Head, message: String, help: &str| {
        let fault = Diagnostic::line(Code::NetElement, &diagram.file, head.line, "", message, help);
        found.push(fault);
    };
    let elsewhere = "use --to c200h, cx or melsec";
    for (at, one) in diagram.transitions.iter().enumerate() {
        let name = diagram.transition_name(at);
        let has = |direction| diagram.places_of(at, direction).next().is_some();
        if one.is_stop {
            tell(&one.head, format!("{name}: a chart has no emergency stops"), elsewhere);
        } else if !has(Direction::Into) || !has(Direction::OutOf) {
            let message =
                format!("{name}: in a chart each transition needs a step before and after it");
            tell(&one.head, message, elsewhere);
        }
    }
    for (at, place) in diagram.places.iter().enumerate() {
        if matches!(place.kind, Kind::Counter { .. }) {
            let message = format!("{}: a chart has no counters", diagram.place_name(at));
            tell(&place.head, message, elsewhere);
        }
    }
    if diagram.places.iter().all(|place| !place.is_marked) {
        let message = "no box has an initial mark, but a chart needs an initial step".to_owned();
        found.push(Diagnostic::file(
            Code::NetElement,
            &diagram.file,
            message,
            "mark a box: box B01 marked",
        ));
    }
    found
}

/// Makes an identifier of IEC 61131-3; characters of other scripts become their numbers.
fn identifier(text: &str) -> String {
    let mut name = String::new();
    for c in text.chars() {
        match c {
            c if c.is_ascii_alphanumeric() => name.push(c),
            c if c.is_ascii() => name.push('_'),
            c => drop(write!(name, "u{:X}", u32::from(c)).is_ok()),
        }
    }
    name
}

fn step(diagram: &Diagram, place: usize) -> String {
    format!("S_{}", identifier(&diagram.place_name(place)))
}

/// The chart in textual form.
fn text(diagram: &Diagram) -> String {
    let mut out = String::from("PROGRAM net\nVAR\n");
    for outer in &diagram.outers {
        let address = outer.head.address.filter(|address| address.area == Area::Internal);
        let at = address.map_or(String::new(), |one| format!(" AT %IX{}.{}", one.word, one.bit));
        let _ = writeln!(out, "  E_{}{at} : BOOL;", identifier(&outer.head.name));
    }
    out += "END_VAR\n";
    for (at, place) in diagram.places.iter().enumerate() {
        let word = if place.is_marked { "INITIAL_STEP" } else { "STEP" };
        let _ = writeln!(out, "{word} {}: END_STEP", step(diagram, at));
    }
    for at in 0..diagram.transitions.len() {
        let names = |direction| -> String {
            let all: Vec<String> =
                diagram.places_of(at, direction).map(|place| step(diagram, place)).collect();
            if all.len() == 1 { all[0].clone() } else { format!("({})", all.join(", ")) }
        };
        let (from, to) = (names(Direction::Into), names(Direction::OutOf));
        let _ = writeln!(
            out,
            "TRANSITION FROM {from} TO {to} := {}; END_TRANSITION",
            condition(diagram, at)
        );
    }
    out += "END_PROGRAM\n";
    out
}

fn condition(diagram: &Diagram, at: usize) -> String {
    let over = |place: usize| match diagram.places[place].kind {
        Kind::Timer { tenths, .. } => {
            let name = step(diagram, place);
            Some(format!("{name}.T >= T#{}ms", u32::from(tenths) * 100))
        }
        _ => None,
    };
    let mut parts: Vec<String> = diagram.places_of(at, Direction::Into).filter_map(over).collect();
    let room = diagram.places_of(at, Direction::OutOf);
    parts.extend(room.map(|place| format!("NOT {}.X", step(diagram, place))));
    for gate in diagram.gates_of(at) {
        let value = match gate.signal {
            Signal::Outer(outer) => format!("E_{}", identifier(&diagram.outers[outer].head.name)),
            Signal::Place(place) => {
                let name = format!("{}.X", step(diagram, place));
                over(place).map_or(name.clone(), |over| format!("({name} AND {over})"))
            }
        };
        parts.push(if gate.is_inhibiting { format!("NOT {value}") } else { value });
    }
    if parts.is_empty() { "TRUE".to_owned() } else { parts.join(" AND ") }
}

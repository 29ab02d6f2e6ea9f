//! Nets for Graphviz.

use super::View;
use scanbound_snet::picture::seconds;
use scanbound_snet::{Diagram, Direction, Kind, Signal};
use std::fmt::Write;

/// One graph, a cluster a page: boxes with their marks, bars, gates as dots and circles at the ends of their lines.
#[must_use]
pub fn render(diagram: &Diagram, view: &View) -> String {
    let mut text = "digraph snet {\n  rankdir=TB;\n  node [fontname=\"sans-serif\"];\n".to_owned();
    for (number, page) in diagram.pages.iter().enumerate() {
        let name = escaped(&page.name);
        let _ = writeln!(text, "  subgraph cluster_{number} {{\n    label=\"{name}\";");
        for (at, place) in diagram.places.iter().enumerate() {
            if place.head.page != number {
                continue;
            }
            let mark = match view.places.get(at).and_then(|shown| shown.is_marked) {
                Some(true) => "\\n●",
                Some(false) => "",
                None => "\\n?",
            };
            let name = escaped(&place.head.name);
            let (shape, more) = match place.kind {
                Kind::Box => ("box", String::new()),
                Kind::Timer { tenths, .. } => ("record", format!("|P {}", seconds(tenths))),
                Kind::Counter { count, .. } => ("Mrecord", format!("|c /{count}")),
            };
            // In records a bar parts fields; what names hold of these characters is no part.
            let own = if more.is_empty() { name } else { fielded(&name) };
            let braces = if more.is_empty() { ["", ""] } else { ["{", "}"] };
            let _ = writeln!(
                text,
                "    p{at} [shape={shape}, label=\"{}{own}{mark}{more}{}\"];",
                braces[0], braces[1]
            );
        }
        for (at, one) in diagram.transitions.iter().enumerate() {
            if one.head.page != number {
                continue;
            }
            let lit = view.lit.get(at) == Some(&true);
            let colour = match (lit, one.is_stop) {
                (true, _) => "orange",
                (_, true) => "red",
                (_, false) => "black",
            };
            let height = if one.is_stop { "0.12" } else { "0.06" };
            let _ = writeln!(
                text,
                "    t{at} [shape=box, style=filled, fillcolor={colour}, width=0.7, height={height}, fixedsize=true, label=\"\", xlabel=\"{}\"];",
                escaped(&one.head.name)
            );
        }
        text += "  }\n";
    }
    for (at, outer) in diagram.outers.iter().enumerate() {
        let _ =
            writeln!(text, "  e{at} [shape=plaintext, label=\"{}\"];", escaped(&outer.head.name));
    }
    for arc in &diagram.arcs {
        let (place, transition) = (arc.place, arc.transition);
        let _ = match arc.direction {
            Direction::Into => writeln!(text, "  p{place} -> t{transition};"),
            Direction::OutOf => writeln!(text, "  t{transition} -> p{place};"),
            Direction::Stop => writeln!(text, "  p{place} -> t{transition} [label=\"*\"];"),
        };
    }
    for gate in &diagram.gates {
        let from = match gate.signal {
            Signal::Place(place) => format!("p{place}"),
            Signal::Outer(outer) => format!("e{outer}"),
        };
        let head = if gate.is_inhibiting { "odot" } else { "dot" };
        let _ = writeln!(
            text,
            "  {from} -> t{} [arrowhead={head}, style=dashed, constraint=false];",
            gate.transition
        );
    }
    for (at, arbiter) in diagram.arbiters.iter().enumerate() {
        let _ = writeln!(
            text,
            "  a{at} [shape=circle, label=\"A\", xlabel=\"{}\"];",
            escaped(&arbiter.head.name)
        );
        for (turn, transition) in arbiter.transitions.iter().enumerate() {
            let _ = writeln!(
                text,
                "  a{at} -> t{transition} [arrowhead=none, style=dotted, label=\"{}\"];",
                turn + 1
            );
        }
    }
    text + "}\n"
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"")
}

fn fielded(text: &str) -> String {
    let mut found = String::new();
    for one in text.chars() {
        if "{}|<> ".contains(one) {
            found.push('\\');
        }
        found.push(one);
    }
    found
}

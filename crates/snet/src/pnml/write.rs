//! Writes a net as PNML. Reading it gives the same net.

use super::{GRAMMAR, TOOL, TYPE, VERSION};
use crate::picture::{Node, POINTS, sheets};
use crate::{Arbiter, Diagram, Direction, Head, Kind, Signal};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The net as PNML.
#[must_use]
pub fn write(diagram: &Diagram) -> String {
    let mut out = Writer { out: String::new(), diagram, laid: BTreeMap::new() };
    for sheet in sheets(diagram) {
        for one in sheet.nodes.iter().filter(|one| !one.is_guest) {
            let at = (one.at.x * POINTS.0, one.at.y * POINTS.1);
            out.laid.insert(one.node, at);
        }
    }
    out.net();
    out.out
}

struct Writer<'a> {
    out: String,
    diagram: &'a Diagram,
    /// The computed positions of elements that have none.
    laid: BTreeMap<Node, (i32, i32)>,
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// An element for this tool only.
fn own(inner: &str) -> String {
    format!("<toolspecific tool=\"{TOOL}\" version=\"{VERSION}\">{inner}</toolspecific>")
}

impl Writer<'_> {
    fn line(&mut self, depth: usize, text: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.out, "{}{text}", "  ".repeat(depth));
    }

    fn net(&mut self) {
        let diagram = self.diagram;
        self.line(0, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
        self.line(0, &format!("<pnml xmlns=\"{GRAMMAR}\">"));
        self.line(1, &format!("<net id=\"net\" type=\"{TYPE}\">"));
        if !diagram.name.is_empty() {
            self.line(2, &format!("<name><text>{}</text></name>", escaped(&diagram.name)));
        }
        for (page, one) in diagram.pages.iter().enumerate() {
            self.line(2, &format!("<page id=\"pg{page}\">"));
            self.line(3, &format!("<name><text>{}</text></name>", escaped(&one.name)));
            self.elements(page);
            self.arcs(page);
            for arbiter in diagram.arbiters.iter().filter(|one| one.head.page == page) {
                self.arbiter(arbiter);
            }
            self.line(2, "</page>");
        }
        self.line(1, "</net>");
        self.line(0, "</pnml>");
    }

    fn elements(&mut self, page: usize) {
        let diagram = self.diagram;
        for (at, outer) in
            diagram.outers.iter().enumerate().filter(|(_, one)| one.head.page == page)
        {
            let inner = format!("<outer{}/>", address(&outer.head));
            self.element("place", &format!("e{at}"), &outer.head, None, false, &inner);
        }
        for (at, place) in
            diagram.places.iter().enumerate().filter(|(_, one)| one.head.page == page)
        {
            let numbered =
                |number: Option<u16>| number.map_or(String::new(), |n| format!(" number=\"{n}\""));
            let (address, kind) = (address(&place.head), place.kind);
            let inner = match kind {
                Kind::Box => format!("<box{address}/>"),
                Kind::Timer { number, tenths } => {
                    format!("<timer tenths=\"{tenths}\"{}{address}/>", numbered(number))
                }
                Kind::Counter { number, count } => {
                    format!("<counter count=\"{count}\"{}{address}/>", numbered(number))
                }
            };
            let node = Some(Node::Place(at));
            self.element("place", &format!("p{at}"), &place.head, node, place.is_marked, &inner);
        }
        let transitions = diagram.transitions.iter().enumerate();
        for (at, one) in transitions.filter(|(_, one)| one.head.page == page) {
            let name = if one.is_stop { "stop" } else { "transition" };
            let inner = format!("<{name}{}/>", address(&one.head));
            let node = Some(Node::Transition(at));
            self.element("transition", &format!("t{at}"), &one.head, node, false, &inner);
        }
    }

    fn element(
        &mut self,
        tag: &str,
        id: &str,
        head: &Head,
        node: Option<Node>,
        is_marked: bool,
        inner: &str,
    ) {
        self.line(3, &format!("<{tag} id=\"{id}\">"));
        self.line(4, &format!("<name><text>{}</text></name>", escaped(&head.name)));
        let laid = node.and_then(|node| self.laid.get(&node).copied());
        let position = head.at.map(|at| (at.x, at.y)).or(laid);
        if let Some((x, y)) = position {
            self.line(4, &format!("<graphics><position x=\"{x}\" y=\"{y}\"/></graphics>"));
        }
        if is_marked {
            self.line(4, "<initialMarking><text>1</text></initialMarking>");
        }
        let laid_out = if head.at.is_none() && position.is_some() { "<laid-out/>" } else { "" };
        self.line(4, &own(&format!("{inner}{laid_out}")));
        self.line(3, &format!("</{tag}>"));
    }

    fn arcs(&mut self, page: usize) {
        let diagram = self.diagram;
        let is_here = |transition: usize| diagram.transitions[transition].head.page == page;
        for (at, arc) in diagram.arcs.iter().enumerate().filter(|(_, arc)| is_here(arc.transition))
        {
            let (place, transition) = (format!("p{}", arc.place), format!("t{}", arc.transition));
            match arc.direction {
                Direction::Into => self.arc(&format!("a{at}"), &place, &transition, ""),
                Direction::Stop => {
                    self.arc(&format!("a{at}"), &place, &transition, "<type value=\"reset\"/>");
                }
                Direction::OutOf => {
                    self.arc(&format!("a{at}"), &transition, &place, "");
                    let capacity = format!("<type value=\"inhibitor\"/>{}", own("<capacity/>"));
                    self.arc(&format!("k{at}"), &place, &transition, &capacity);
                }
            }
        }
        for (at, gate) in
            diagram.gates.iter().enumerate().filter(|(_, gate)| is_here(gate.transition))
        {
            let from = match gate.signal {
                Signal::Place(place) => format!("p{place}"),
                Signal::Outer(outer) => format!("e{outer}"),
            };
            let kind = if gate.is_inhibiting { "inhibitor" } else { "read" };
            let inner = format!("<type value=\"{kind}\"/>{}", own("<gate/>"));
            self.arc(&format!("g{at}"), &from, &format!("t{}", gate.transition), &inner);
        }
    }

    fn arc(&mut self, id: &str, from: &str, to: &str, inner: &str) {
        let head = format!("<arc id=\"{id}\" source=\"{from}\" target=\"{to}\"");
        self.line(
            3,
            &if inner.is_empty() { format!("{head}/>") } else { format!("{head}>{inner}</arc>") },
        );
    }

    fn arbiter(&mut self, arbiter: &Arbiter) {
        let ids: Vec<String> = arbiter.transitions.iter().map(|at| format!("t{at}")).collect();
        let at =
            arbiter.head.at.map_or(String::new(), |at| format!(" x=\"{}\" y=\"{}\"", at.x, at.y));
        let name = escaped(&arbiter.head.name);
        let number = self.diagram.arbiters.iter().position(|one| one == arbiter).unwrap_or(0);
        let inner = format!(
            "<arbiter number=\"{number}\" name=\"{name}\" transitions=\"{}\"{at}/>",
            ids.join(" ")
        );
        self.line(3, &own(&inner));
    }
}

fn address(head: &Head) -> String {
    head.address.map_or(String::new(), |address| format!(" address=\"{address}\""))
}

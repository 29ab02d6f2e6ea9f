//! Reads a net from PNML.

use super::node::{Text, children, own, text_of};
use super::{TOOL, TYPE};
use crate::text::is_name;
use crate::{
    Arbiter, Arc, Diagram, Direction, Gate, Head, Kind, Outer, Page, Place, Point, Signal,
    Transition,
};
use roxmltree::Node;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use std::collections::{BTreeMap, BTreeSet};

/// Reads a net.
///
/// # Errors
/// Everything that is not a place/transition net with at most one mark in each place, with its line.
pub fn read(file: &str, text: &str) -> Result<Diagram, Vec<Diagnostic>> {
    let text = text.trim_start_matches('\u{feff}');
    let document = roxmltree::Document::parse(text).map_err(|error| {
        let line = error.pos().row;
        let shown = text.lines().nth(line as usize - 1).unwrap_or_default();
        let help = "export it again from the net editor";
        vec![Diagnostic::line(
            Code::Xml,
            file,
            line,
            shown.trim(),
            format!("no XML: {error}"),
            help,
        )]
    })?;
    let mut reader = Reader {
        file,
        text: Text::new(text),
        diagram: Diagram { file: file.to_owned(), ..Diagram::default() },
        nodes: BTreeMap::new(),
        taken: BTreeSet::new(),
        faults: Vec::new(),
        arcs: Vec::new(),
        arbiters: Vec::new(),
    };
    reader.document(document.root_element());
    let Reader { diagram, faults, .. } = reader;
    if faults.is_empty() { Ok(diagram) } else { Err(faults) }
}

/// The element that an id stands for.
#[derive(Debug, Clone, PartialEq, Eq)]
enum IdTarget {
    Place(usize),
    Outer(usize),
    Transition(usize),
    /// Another id.
    Reference(String),
}

struct Reader<'t, 'd> {
    file: &'t str,
    text: Text<'t>,
    diagram: Diagram,
    nodes: BTreeMap<String, IdTarget>,
    /// Names in use, by page.
    taken: BTreeSet<(usize, String)>,
    faults: Vec<Diagnostic>,
    arcs: Vec<Node<'d, 'd>>,
    arbiters: Vec<(usize, Node<'d, 'd>)>,
}

/// The number in an id such as `p12`, which restores the element order of files that this tool wrote.
fn number(id: &str) -> usize {
    id.trim_start_matches(|c: char| !c.is_ascii_digit()).parse().unwrap_or(usize::MAX)
}

impl<'d> Reader<'_, 'd> {
    fn fault(&mut self, node: Node<'_, '_>, message: impl Into<String>, help: &str) {
        let line = self.text.line(node);
        let shown = self.text.shown(line);
        self.faults.push(Diagnostic::line(Code::NetSyntax, self.file, line, shown, message, help));
    }

    fn document(&mut self, root: Node<'d, 'd>) {
        let nets: Vec<Node<'_, '_>> = children(root, "net").collect();
        let [net] = nets[..] else {
            let message = format!("the file has {} nets, but only one can be read", nets.len());
            self.fault(root, message, "export one net as PNML");
            return;
        };
        if net.attribute("type").is_some_and(|own| own != TYPE && !own.ends_with("ptnet")) {
            let help = "export the net as a place/transition net";
            self.fault(net, "this is not a place/transition net", help);
        }
        self.diagram.name = text_of(net, "name").unwrap_or_default();
        let pages: Vec<Node<'_, '_>> = net
            .descendants()
            .filter(|node| node.is_element() && node.tag_name().name() == "page")
            .collect();
        // Older files have no pages.
        let pages = if pages.is_empty() { vec![net] } else { pages };
        for (page, &node) in pages.iter().enumerate() {
            let name = text_of(node, "name").filter(|_| node != net);
            let name = self.named(usize::MAX, &name.unwrap_or_else(|| "MAIN".to_owned()));
            self.diagram.pages.push(Page { name, line: self.text.line(node) });
            self.page(page, node);
        }
        self.order();
        let mut arcs = std::mem::take(&mut self.arcs);
        arcs.sort_by_key(|arc| arc.attribute("id").map_or(usize::MAX, number));
        for arc in arcs {
            self.arc(arc);
        }
        self.drop_capacities();
        let mut arbiters = std::mem::take(&mut self.arbiters);
        arbiters.sort_by_key(|(_, one)| one.attribute("number").map_or(usize::MAX, number));
        for (page, node) in arbiters {
            self.arbiter(page, node);
        }
    }

    /// A valid name that no other element of the page has.
    fn named(&mut self, page: usize, name: &str) -> String {
        let fits = |c: char| is_name(&c.to_string());
        let mut plain: String = name.chars().map(|c| if fits(c) { c } else { '_' }).collect();
        if !is_name(&plain) {
            plain = format!("N{plain}");
        }
        let (first, mut more) = (plain.clone(), 2);
        while !self.taken.insert((page, plain.clone())) {
            plain = format!("{first}_{more}");
            more += 1;
        }
        plain
    }

    fn page(&mut self, page: usize, node: Node<'d, 'd>) {
        for one in node.children().filter(Node::is_element) {
            match one.tag_name().name() {
                "place" => self.place(page, one),
                "transition" => self.transition(page, one),
                "referencePlace" | "referenceTransition" => {
                    match (one.attribute("id"), one.attribute("ref")) {
                        (Some(id), Some(to)) => {
                            self.nodes.insert(id.to_owned(), IdTarget::Reference(to.to_owned()));
                        }
                        _ => self.fault(
                            one,
                            "a reference place or transition has no id or no ref",
                            "give it an id and a ref",
                        ),
                    }
                }
                "arc" => self.arcs.push(one),
                "toolspecific" if one.attribute("tool") == Some(TOOL) => {
                    self.arbiters.extend(children(one, "arbiter").map(|arbiter| (page, arbiter)));
                }
                _ => {}
            }
        }
    }

    fn note(&mut self, node: Node<'_, '_>, known: IdTarget) {
        let Some(id) = node.attribute("id") else {
            self.fault(node, "an element has no id", "give it a unique id");
            return;
        };
        if self.nodes.insert(id.to_owned(), known).is_some() {
            self.fault(
                node,
                format!("the id {id} is given twice"),
                "give each element a unique id",
            );
        }
    }

    /// Reads name, page, line, address and position.
    fn head(&mut self, page: usize, node: Node<'_, '_>, inner: Option<Node<'_, '_>>) -> Head {
        let id = node.attribute("id").unwrap_or("N");
        let name = text_of(node, "name").filter(|name| !name.is_empty());
        let is_outer = inner.is_some_and(|inner| inner.tag_name().name() == "outer");
        // Outer gates belong to all pages and have separate names.
        let name =
            self.named(if is_outer { usize::MAX - 1 } else { page }, name.as_deref().unwrap_or(id));
        let mut address = None;
        if let Some(text) = inner.and_then(|inner| inner.attribute("address")) {
            match text.parse() {
                Ok(read) => address = Some(read),
                Err(why) => self.fault(
                    node,
                    format!("{text} is not an address: {why}"),
                    "correct the address",
                ),
            }
        }
        let position = children(node, "graphics")
            .flat_map(|graphics| children(graphics, "position"))
            .next()
            .filter(|_| own(node, "laid-out").is_none());
        let coordinate = |at: Node<'_, '_>, name: &str| {
            let text = at.attribute(name)?;
            text.split('.').next()?.parse::<i32>().ok()
        };
        let at = position
            .and_then(|at| Some(Point { x: coordinate(at, "x")?, y: coordinate(at, "y")? }));
        Head { name, page, line: self.text.line(node), address, at }
    }

    fn place(&mut self, page: usize, node: Node<'_, '_>) {
        let kinds = ["outer", "box", "timer", "counter"];
        let inner = kinds.iter().find_map(|kind| own(node, kind));
        let head = self.head(page, node, inner);
        let value = |name: &str| inner?.attribute(name)?.parse::<u16>().ok();
        let kind = match inner.map(|inner| inner.tag_name().name()) {
            Some("outer") => {
                self.note(node, IdTarget::Outer(self.diagram.outers.len()));
                self.diagram.outers.push(Outer { head });
                return;
            }
            Some("timer") => {
                Kind::Timer { number: value("number"), tenths: value("tenths").unwrap_or(0) }
            }
            Some("counter") => {
                Kind::Counter { number: value("number"), count: value("count").unwrap_or(1) }
            }
            _ => Kind::Box,
        };
        let marking = text_of(node, "initialMarking").unwrap_or_else(|| "0".to_owned());
        // Some tools write a colour before the number.
        let marks = marking.rsplit(',').next().unwrap_or_default().trim().parse::<u32>();
        let is_marked = match marks {
            Ok(marks @ 0..=1) => marks == 1,
            _ => {
                let message = format!("{} has the initial marking '{marking}'", head.name);
                self.fault(
                    node,
                    message,
                    "write 0 or 1: a place of an S-net holds at most one mark",
                );
                false
            }
        };
        self.note(node, IdTarget::Place(self.diagram.places.len()));
        self.diagram.places.push(Place { head, kind, is_marked });
    }

    fn transition(&mut self, page: usize, node: Node<'_, '_>) {
        let stop = own(node, "stop");
        let head = self.head(page, node, stop.or_else(|| own(node, "transition")));
        self.note(node, IdTarget::Transition(self.diagram.transitions.len()));
        self.diagram.transitions.push(Transition { head, is_stop: stop.is_some() });
    }

    /// Restores the element order of files that this tool wrote page by page.
    fn order(&mut self) {
        let numbers = |nodes: &BTreeMap<String, IdTarget>, of: fn(&IdTarget) -> Option<usize>| {
            let mut found: Vec<(usize, usize)> =
                nodes.iter().filter_map(|(id, known)| Some((of(known)?, number(id)))).collect();
            found.sort_unstable();
            // The new index of each place.
            let mut order: Vec<usize> = (0..found.len()).collect();
            order.sort_by_key(|&at| found.get(at).map(|(_, number)| *number));
            order
        };
        let place =
            |known: &IdTarget| if let IdTarget::Place(at) = known { Some(*at) } else { None };
        let outer =
            |known: &IdTarget| if let IdTarget::Outer(at) = known { Some(*at) } else { None };
        let transition =
            |known: &IdTarget| if let IdTarget::Transition(at) = known { Some(*at) } else { None };
        let (places, outers, transitions) = (
            numbers(&self.nodes, place),
            numbers(&self.nodes, outer),
            numbers(&self.nodes, transition),
        );
        // An id that occurs twice is already an error.
        if places.len() != self.diagram.places.len()
            || outers.len() != self.diagram.outers.len()
            || transitions.len() != self.diagram.transitions.len()
        {
            return;
        }
        let to =
            |order: &[usize], old: usize| order.iter().position(|&one| one == old).unwrap_or(old);
        for known in self.nodes.values_mut() {
            match known {
                IdTarget::Place(at) => *at = to(&places, *at),
                IdTarget::Outer(at) => *at = to(&outers, *at),
                IdTarget::Transition(at) => *at = to(&transitions, *at),
                IdTarget::Reference(_) => {}
            }
        }
        let diagram = &mut self.diagram;
        diagram.places = places.iter().map(|&at| diagram.places[at].clone()).collect();
        diagram.outers = outers.iter().map(|&at| diagram.outers[at].clone()).collect();
        diagram.transitions =
            transitions.iter().map(|&at| diagram.transitions[at].clone()).collect();
    }

    /// The element of an id, resolving references.
    fn known(&self, id: &str) -> Option<IdTarget> {
        let mut id = id.to_owned();
        for _ in 0..100 {
            match self.nodes.get(&id)? {
                IdTarget::Reference(to) => id.clone_from(to),
                known => return Some(known.clone()),
            }
        }
        None
    }

    fn arc(&mut self, node: Node<'_, '_>) {
        let ends = ["source", "target"].map(|end| node.attribute(end).unwrap_or_default());
        let found = ends.map(|id| self.known(id));
        for (id, known) in ends.iter().zip(&found) {
            if known.is_none() {
                let message = format!("the arc leads from or to '{id}', which is not an element");
                self.fault(node, message, "write the ids of a place and a transition");
                return;
            }
        }
        let weight = text_of(node, "inscription").unwrap_or_else(|| "1".to_owned());
        if weight.rsplit(',').next().map(str::trim) != Some("1") {
            let message = format!("the arc has the weight '{weight}'");
            self.fault(node, message, "write 1: a place of an S-net holds at most one mark");
            return;
        }
        let kind = children(node, "type").next();
        let kind = kind.and_then(|kind| kind.attribute("value").or_else(|| kind.text()));
        let kind = kind.map(str::trim).or_else(|| node.attribute("type")).unwrap_or("normal");
        let line = self.text.line(node);
        let (direction, place, transition) = match found {
            [Some(IdTarget::Place(place)), Some(IdTarget::Transition(to))] => {
                (Direction::Into, place, to)
            }
            [Some(IdTarget::Transition(from)), Some(IdTarget::Place(place))] => {
                (Direction::OutOf, place, from)
            }
            [Some(IdTarget::Outer(outer)), Some(IdTarget::Transition(transition))] => {
                let (signal, is_inhibiting) = (Signal::Outer(outer), kind == "inhibitor");
                self.diagram.gates.push(Gate { transition, signal, is_inhibiting, line });
                return;
            }
            _ => {
                let message =
                    "the arc connects two places or two transitions, or leads to an outer gate";
                self.fault(
                    node,
                    message,
                    "put a transition between two places, a place between two transitions",
                );
                return;
            }
        };
        let mut gate = |is_inhibiting: bool| {
            let signal = Signal::Place(place);
            self.diagram.gates.push(Gate { transition, signal, is_inhibiting, line });
        };
        match (kind, direction) {
            ("inhibitor", Direction::Into) if own(node, "capacity").is_some() => {}
            ("inhibitor", Direction::Into) if own(node, "gate").is_some() => gate(true),
            // From another tool; whether it only expresses the capacity is decided when all arcs are known.
            ("inhibitor", Direction::Into) => {
                gate(true);
                if let Some(last) = self.diagram.gates.last_mut() {
                    last.line |= FOREIGN;
                }
            }
            ("read" | "test", _) => gate(false),
            ("reset", Direction::Into) => {
                self.diagram.arcs.push(Arc { place, transition, direction: Direction::Stop, line });
            }
            ("normal", direction) => {
                self.diagram.arcs.push(Arc { place, transition, direction, line });
            }
            (other, _) => {
                let message = format!("an S-net has no arcs of type '{other}'");
                self.fault(node, message, "use normal, inhibitor, read or reset arcs");
            }
        }
    }

    /// Removes inhibitor arcs of other tools that only say that a place holds at most one mark.
    fn drop_capacities(&mut self) {
        let arcs = &self.diagram.arcs;
        self.diagram.gates.retain(|gate| {
            let fills = |arc: &Arc| {
                arc.transition == gate.transition
                    && arc.direction == Direction::OutOf
                    && gate.signal == Signal::Place(arc.place)
            };
            gate.line & FOREIGN == 0 || !arcs.iter().any(fills)
        });
        self.diagram.gates.iter_mut().for_each(|gate| gate.line &= !FOREIGN);
    }

    fn arbiter(&mut self, page: usize, node: Node<'_, '_>) {
        let ids = node.attribute("transitions").unwrap_or_default();
        let mut transitions = Vec::new();
        for id in ids.split_whitespace() {
            match self.known(id) {
                Some(IdTarget::Transition(at)) => transitions.push(at),
                _ => self.fault(
                    node,
                    format!("'{id}' is not a transition"),
                    "write the ids of transitions",
                ),
            }
        }
        let name = self.named(page, node.attribute("name").unwrap_or("A"));
        let number = |name: &str| node.attribute(name)?.parse::<i32>().ok();
        let at = number("x").zip(number("y")).map(|(x, y)| Point { x, y });
        let head = Head { name, page, line: self.text.line(node), address: None, at };
        self.diagram.arbiters.push(Arbiter { head, transitions });
    }
}

/// Added to the line of a gate that another tool wrote; no file has so many lines.
const FOREIGN: u32 = 1 << 31;

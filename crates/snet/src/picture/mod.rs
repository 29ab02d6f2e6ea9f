//! Computes where the elements of a net are drawn and along which lines its arcs run, on a grid of text characters. A
//! picture has a fixed number of points for each grid cell.
//!
//! A page whose elements all have positions is drawn with them. Any other page is arranged in layers, from the marked
//! places down; arcs that lead up run between the columns.

mod drawn;
mod layers;
mod route;

pub use drawn::{Drawn, HALF, Node, ROWS, Spot};

use super::{Diagram, Direction, Kind, Signal};
use unicode_width::UnicodeWidthStr;

/// An arc's line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// An index into `Diagram::arcs`.
    pub arc: usize,
    /// The corners from the start of the arc to its arrow; all parts are horizontal or vertical.
    pub corners: Vec<Spot>,
}

/// A drawn page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sheet {
    /// An index into `Diagram::pages`.
    pub page: usize,
    /// Its elements.
    pub nodes: Vec<Drawn>,
    /// Its arcs.
    pub lines: Vec<Line>,
    /// The numbers of columns and rows.
    pub size: Spot,
}

/// The size of a grid cell in points of a drawing.
pub const POINTS: (i32, i32) = (8, 16);

/// The text of a gate next to its transition.
#[must_use]
pub fn gate_text(diagram: &Diagram, signal: Signal) -> String {
    diagram.signal_name(signal)
}

/// The lines of text next to an element: its name, and the set value of a timer or counter.
#[must_use]
pub fn label(diagram: &Diagram, node: Node, is_guest: bool) -> Vec<String> {
    match node {
        Node::Place(at) => {
            let place = &diagram.places[at];
            let name = if is_guest { diagram.place_name(at) } else { place.head.name.clone() };
            match place.kind {
                Kind::Box => vec![name],
                Kind::Timer { tenths, .. } => vec![name, seconds(tenths)],
                Kind::Counter { count, .. } => vec![name, format!("/{count}")],
            }
        }
        Node::Transition(at) => {
            let name = &diagram.transitions[at].head.name;
            vec![if is_guest { diagram.transition_name(at) } else { name.clone() }]
        }
    }
}

/// Tenths of a second as a text.
#[must_use]
pub fn seconds(tenths: u16) -> String {
    format!("{}.{} s", tenths / 10, tenths % 10)
}

fn width(text: &str) -> i32 {
    i32::try_from(text.width()).unwrap_or(i32::MAX / 4)
}

fn measured(diagram: &Diagram, node: Node, is_guest: bool) -> Drawn {
    let beside = label(diagram, node, is_guest);
    // Space for the current value of a timer or counter.
    let room = if beside.len() > 1 { 14 } else { 0 };
    let right = HALF + 2 + beside.iter().map(|text| width(text)).max().unwrap_or(0).max(room);
    let (rows, left) = match node {
        Node::Place(_) => (ROWS, HALF),
        Node::Transition(at) => {
            let gates: Vec<i32> =
                diagram.gates_of(at).map(|gate| width(&gate_text(diagram, gate.signal))).collect();
            let rows = i32::try_from(gates.len()).unwrap_or(1).max(1);
            (rows, HALF + gates.iter().max().map_or(0, |widest| widest + 3))
        }
    };
    Drawn { node, is_guest, at: Spot { x: 0, y: 0 }, rows, reach: (left, right) }
}

/// The sheets of a net, one for each page.
#[must_use]
pub fn sheets(diagram: &Diagram) -> Vec<Sheet> {
    (0..diagram.pages.len()).map(|page| sheet(diagram, page)).collect()
}

fn page_of(diagram: &Diagram, node: Node) -> usize {
    match node {
        Node::Place(at) => diagram.places[at].head.page,
        Node::Transition(at) => diagram.transitions[at].head.page,
    }
}

fn sheet(diagram: &Diagram, page: usize) -> Sheet {
    let places = (0..diagram.places.len()).map(Node::Place);
    let transitions = (0..diagram.transitions.len()).map(Node::Transition);
    let mut nodes: Vec<Node> =
        places.chain(transitions).filter(|node| page_of(diagram, *node) == page).collect();
    // An arc is drawn on the page of its transition; its place may belong to another page.
    let arcs: Vec<usize> = (0..diagram.arcs.len())
        .filter(|&arc| diagram.transitions[diagram.arcs[arc].transition].head.page == page)
        .collect();
    for &arc in &arcs {
        let place = Node::Place(diagram.arcs[arc].place);
        if !nodes.contains(&place) {
            nodes.push(place);
        }
    }
    let mut drawn: Vec<Drawn> =
        nodes.iter().map(|&node| measured(diagram, node, page_of(diagram, node) != page)).collect();
    let index = |node: Node| nodes.iter().position(|other| *other == node);
    let ends: Vec<(usize, usize)> = arcs
        .iter()
        .filter_map(|&arc| {
            let arc = diagram.arcs[arc];
            let (place, transition) =
                (index(Node::Place(arc.place))?, index(Node::Transition(arc.transition))?);
            Some(match arc.direction {
                Direction::OutOf => (transition, place),
                Direction::Into | Direction::Stop => (place, transition),
            })
        })
        .collect();
    let stated = nodes.iter().map(|&node| {
        let head = match node {
            Node::Place(at) => &diagram.places[at].head,
            Node::Transition(at) => &diagram.transitions[at].head,
        };
        head.at.filter(|_| head.page == page)
    });
    let stated: Option<Vec<_>> = stated.collect();
    let corners = match stated.filter(|all| !all.is_empty()) {
        Some(stated) => {
            for (one, at) in drawn.iter_mut().zip(stated) {
                one.at = Spot { x: at.x.div_euclid(POINTS.0), y: at.y.div_euclid(POINTS.1) };
            }
            shift(&mut drawn);
            route::around(&drawn, &ends)
        }
        None => {
            let first: Vec<usize> = nodes
                .iter()
                .enumerate()
                .filter(
                    |(_, node)| matches!(node, Node::Place(at) if diagram.places[*at].is_marked),
                )
                .map(|(at, _)| at)
                .collect();
            layers::laid_out(&mut drawn, &ends, &first)
        }
    };
    let lines: Vec<Line> =
        arcs.into_iter().zip(corners).map(|(arc, corners)| Line { arc, corners }).collect();
    let ends = drawn.iter().map(|one| Spot { x: one.at.x + one.reach.1, y: one.at.y + one.rows });
    let corners = lines.iter().flat_map(|line| line.corners.iter().copied());
    let all: Vec<Spot> = ends.chain(corners).collect();
    let most = |of: fn(&Spot) -> i32| all.iter().map(of).max().unwrap_or(0) + 2;
    let size = Spot { x: most(|spot| spot.x), y: most(|spot| spot.y) };
    Sheet { page, nodes: drawn, lines, size }
}

/// Moves everything so that nothing is left of or above the sheet.
fn shift(drawn: &mut [Drawn]) {
    let left = drawn.iter().map(|one| one.at.x - one.reach.0).min().unwrap_or(0);
    let top = drawn.iter().map(|one| one.at.y).min().unwrap_or(0);
    for one in drawn {
        one.at = Spot { x: one.at.x - left + 1, y: one.at.y - top + 1 };
    }
}

#[cfg(test)]
mod tests;

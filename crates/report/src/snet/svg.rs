//! Nets as pictures.

use super::View;
use scanbound_snet::picture::{Drawn, HALF, Line, Node, POINTS, Sheet, Spot, gate_text, label};
use scanbound_snet::{Diagram, Direction, Kind};
use std::fmt::Write;

const STYLE: &str = "text{font:12px sans-serif}.name{font-weight:bold}.symbol{fill:white;stroke:black;stroke-width:1.5}\
.guest{stroke-dasharray:4}.bar{fill:black}.stop{fill:#b00}.lit{fill:#e90}path{stroke:black;fill:none}\
.dash{stroke:gray;stroke-dasharray:3}.mark{fill:black}.small{font-size:10px}.off{fill:white;stroke:black}";

/// All pages of a net below each other, as what `view` says shows in them.
#[must_use]
pub fn render(diagram: &Diagram, sheets: &[Sheet], view: &View) -> String {
    let mut body = String::new();
    let (mut top, mut widest) = (10, 0);
    let title = if diagram.name.is_empty() { &diagram.file } else { &diagram.name };
    let _ = writeln!(body, "<title>{}</title>", escaped(title));
    for sheet in sheets {
        let name = escaped(&diagram.pages[sheet.page].name);
        let _ = writeln!(body, "<text x=\"10\" y=\"{}\" class=\"name\">{name}</text>", top + 12);
        let _ = writeln!(body, "<g transform=\"translate(10 {})\">", top + 20);
        page(diagram, sheet, view, &mut body);
        body += "</g>\n";
        widest = widest.max(sheet.size.x * POINTS.0 + 20);
        top += 20 + sheet.size.y * POINTS.1 + 20;
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{widest}\" height=\"{top}\" viewBox=\"0 0 {widest} {top}\">\n\
         <style>{STYLE}</style>\n\
         <defs><marker id=\"arrow\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"8\" markerHeight=\"8\" orient=\"auto\">\
         <path d=\"M0 0 L8 4 L0 8 z\" style=\"fill:black;stroke:none\"/></marker></defs>\n\
         <rect width=\"{widest}\" height=\"{top}\" style=\"fill:white\"/>\n{body}</svg>\n"
    )
}

/// The middle of a spot, in points.
fn middle(spot: Spot) -> (i32, i32) {
    (spot.x * POINTS.0 + POINTS.0 / 2, spot.y * POINTS.1 + POINTS.1 / 2)
}

fn page(diagram: &Diagram, sheet: &Sheet, view: &View, body: &mut String) {
    for line in &sheet.lines {
        arc(diagram, sheet, line, body);
    }
    for one in &sheet.nodes {
        match one.node {
            Node::Place(at) => place(diagram, one, at, view, body),
            Node::Transition(at) => transition(diagram, one, at, view, body),
        }
    }
    for (number, arbiter) in diagram.arbiters.iter().enumerate() {
        arbitrated(diagram, sheet, number, &arbiter.transitions, body);
    }
}

/// Where a line meets a symbol above (`true`) or below it.
fn border(one: &Drawn, is_above: bool) -> i32 {
    match (one.node, is_above) {
        (Node::Place(_), true) => one.at.y * POINTS.1,
        (Node::Place(_), false) => (one.at.y + one.rows) * POINTS.1,
        (Node::Transition(_), true) => middle(one.at).1 - 3,
        (Node::Transition(_), false) => middle(one.at).1 + 3,
    }
}

fn arc(diagram: &Diagram, sheet: &Sheet, line: &Line, body: &mut String) {
    let own = diagram.arcs[line.arc];
    let node = |node| sheet.nodes.iter().find(|one| one.node == node);
    let (Some(place), Some(transition)) =
        (node(Node::Place(own.place)), node(Node::Transition(own.transition)))
    else {
        return;
    };
    let (from, to) = match own.direction {
        Direction::OutOf => (transition, place),
        Direction::Into | Direction::Stop => (place, transition),
    };
    let (Some(&first), Some(&last)) = (line.corners.first(), line.corners.last()) else { return };
    let mut points: Vec<(i32, i32)> = line.corners.iter().map(|&spot| middle(spot)).collect();
    points.insert(0, (middle(first).0, border(from, first.y < from.at.y)));
    points.push((middle(last).0, border(to, last.y < to.at.y)));
    // Corners on a straight line are none.
    let mut bent: Vec<(i32, i32)> = Vec::new();
    for point in points {
        if let [.., before, last] = bent[..]
            && ((before.0 == last.0 && last.0 == point.0)
                || (before.1 == last.1 && last.1 == point.1))
        {
            bent.pop();
        }
        bent.push(point);
    }
    let way: Vec<String> = bent.iter().map(|(x, y)| format!("{x} {y}")).collect();
    let _ = writeln!(body, "<path d=\"M{}\" marker-end=\"url(#arrow)\"/>", way.join(" L"));
    if own.direction == Direction::Stop {
        let (x, y) = middle(first);
        let _ = writeln!(body, "<text x=\"{}\" y=\"{}\" class=\"name\">*</text>", x + 3, y + 6);
    }
}

fn place(diagram: &Diagram, one: &Drawn, at: usize, view: &View, body: &mut String) {
    let (x, y) = middle(one.at);
    let (left, top) = (x - HALF * POINTS.0 - 4, y - POINTS.1 / 2);
    let (width, height) = (2 * HALF * POINTS.0 + 8, one.rows * POINTS.1);
    let guest = if one.is_guest { " guest" } else { "" };
    let kind = diagram.places[at].kind;
    let _ = match kind {
        Kind::Counter { .. } => writeln!(
            body,
            "<circle class=\"symbol{guest}\" cx=\"{x}\" cy=\"{}\" r=\"9\"/><text x=\"{}\" y=\"{}\" class=\"small\">c</text>\
             <rect class=\"symbol{guest}\" x=\"{left}\" y=\"{}\" width=\"{width}\" height=\"{}\"/>",
            top + 10,
            x - 3,
            top + 13,
            top + 19,
            height - 19
        ),
        Kind::Box | Kind::Timer { .. } => writeln!(
            body,
            "<rect class=\"symbol{guest}\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>"
        ),
    };
    if let Kind::Timer { .. } = kind {
        // The timer's part P, on the side where it leads on.
        let over = view.places.get(at).is_some_and(|shown| shown.is_over);
        let class = if over { "symbol lit" } else { "symbol" };
        let _ = writeln!(
            body,
            "<rect class=\"{class}\" x=\"{left}\" y=\"{}\" width=\"{width}\" height=\"14\"/><text x=\"{}\" y=\"{}\" class=\"small\">P</text>",
            top + height - 14,
            x - 3,
            top + height - 3
        );
    }
    let shown = view.places.get(at);
    let centre = match kind {
        Kind::Box => top + height / 2,
        Kind::Timer { .. } => top + (height - 14) / 2,
        Kind::Counter { .. } => top + 19 + (height - 19) / 2,
    };
    match shown.and_then(|shown| shown.is_marked) {
        Some(true) => {
            let _ = writeln!(body, "<circle class=\"mark\" cx=\"{x}\" cy=\"{centre}\" r=\"6\"/>");
        }
        Some(false) => {}
        None => {
            let _ = writeln!(body, "<text x=\"{}\" y=\"{}\">?</text>", x - 3, centre + 4);
        }
    }
    let mut beside = label(diagram, one.node, one.is_guest);
    if let (Some(standing), Some(second)) =
        (shown.and_then(|shown| shown.standing.clone()), beside.get_mut(1))
    {
        *second = standing;
    }
    for (row, text) in (0..).zip(&beside) {
        let at = top + height / 2 + 4 + row * 15;
        let _ =
            writeln!(body, "<text x=\"{}\" y=\"{at}\">{}</text>", left + width + 6, escaped(text));
    }
}

fn transition(diagram: &Diagram, one: &Drawn, at: usize, view: &View, body: &mut String) {
    let (x, y) = middle(one.at);
    let (left, width) = (x - HALF * POINTS.0 - 4, 2 * HALF * POINTS.0 + 8);
    let is_stop = diagram.transitions[at].is_stop;
    let class = match (view.lit.get(at), is_stop) {
        (Some(true), _) => "lit",
        (_, true) => "stop",
        (_, false) => "bar",
    };
    let (up, height) = if is_stop { (4, 8) } else { (2, 5) };
    let _ = writeln!(
        body,
        "<rect class=\"{class}\" x=\"{left}\" y=\"{}\" width=\"{width}\" height=\"{height}\"/>",
        y - up
    );
    for text in label(diagram, one.node, one.is_guest) {
        let _ = writeln!(
            body,
            "<text x=\"{}\" y=\"{}\">{}</text>",
            left + width + 6,
            y + 4,
            escaped(&text)
        );
    }
    for (row, gate) in (0..).zip(diagram.gates_of(at)) {
        let level = y + row * POINTS.1;
        let end = left - 6;
        let dash = match gate.signal {
            scanbound_snet::Signal::Place(_) => " class=\"dash\"",
            scanbound_snet::Signal::Outer(_) => "",
        };
        let _ =
            writeln!(body, "<path{dash} d=\"M{} {level} L{end} {level} L{left} {y}\"/>", end - 6);
        // A dot permits, a circle inhibits.
        let class = if gate.is_inhibiting { "off" } else { "mark" };
        let _ = writeln!(body, "<circle class=\"{class}\" cx=\"{end}\" cy=\"{level}\" r=\"3\"/>");
        let _ = writeln!(
            body,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            end - 9,
            level + 4,
            escaped(&gate_text(diagram, gate.signal))
        );
    }
}

/// An arbiter: a circle, and a dashed line to each of its transitions with its turn.
fn arbitrated(
    diagram: &Diagram,
    sheet: &Sheet,
    number: usize,
    transitions: &[usize],
    body: &mut String,
) {
    let ends: Vec<(usize, (i32, i32))> = transitions
        .iter()
        .enumerate()
        .filter_map(|(turn, &at)| {
            let one = sheet.nodes.iter().find(|one| one.node == Node::Transition(at))?;
            Some((turn, middle(one.at)))
        })
        .collect();
    let Some(&(_, first)) = ends.first() else { return };
    let count = i32::try_from(ends.len()).unwrap_or(1);
    let x = ends.iter().map(|(_, end)| end.0).sum::<i32>() / count;
    let y = first.1 - 26;
    for (turn, (to, level)) in &ends {
        let _ = writeln!(body, "<path class=\"dash\" d=\"M{x} {y} L{to} {level}\"/>");
        let (x, y) = (to + (x - to) / 4, level + (y - level) / 4);
        let _ = writeln!(body, "<text x=\"{x}\" y=\"{y}\" class=\"small\">{}</text>", turn + 1);
    }
    let name = escaped(&diagram.arbiters[number].head.name);
    let _ = writeln!(
        body,
        "<circle class=\"symbol\" cx=\"{x}\" cy=\"{y}\" r=\"9\"/><text x=\"{}\" y=\"{}\" class=\"small\">A</text>\
         <text x=\"{}\" y=\"{}\" class=\"small\">{name}</text>",
        x - 3,
        y + 4,
        x + 12,
        y - 6
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

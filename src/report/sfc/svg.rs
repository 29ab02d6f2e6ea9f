//! Charts as pictures.

use super::Study;
use super::layout::places;
use std::fmt::Write;

const WIDTH: usize = 300;
const HEIGHT: usize = 110;

/// One picture, the charts below each other.
#[must_use]
pub fn render(studies: &[Study<'_>]) -> String {
    let mut body = String::new();
    let (mut top, mut widest) = (20, 0);
    for study in studies {
        let _ = writeln!(
            body,
            "<text x=\"20\" y=\"{}\" class=\"name\">{}</text>",
            top + 5,
            escaped(&study.name)
        );
        let (width, height) = one(study, top + 20, &mut body);
        widest = widest.max(width);
        top += height + 60;
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{widest}\" height=\"{top}\" viewBox=\"0 0 {widest} {top}\">\n\
         <style>text{{font:12px sans-serif}}.name{{font-weight:bold}}rect{{fill:none;stroke:black}}\
         line,path{{stroke:black;fill:none}}.bar{{stroke-width:3}}.back{{stroke:gray;stroke-dasharray:4}}\
         .macro{{stroke:gray;stroke-dasharray:2}}</style>\n\
         <rect width=\"{widest}\" height=\"{top}\" style=\"fill:white;stroke:none\"/>\n{body}</svg>\n"
    )
}

fn one(study: &Study<'_>, top: usize, body: &mut String) -> (usize, usize) {
    let places = places(study.chart);
    let at = |step: usize| (20 + places[step].1 * WIDTH, top + places[step].0 * HEIGHT);
    for (number, step) in study.chart.steps.iter().enumerate() {
        let (x, y) = at(number);
        let _ = writeln!(body, "<rect x=\"{x}\" y=\"{y}\" width=\"100\" height=\"30\"/>");
        if step.initial {
            let _ = writeln!(
                body,
                "<rect x=\"{}\" y=\"{}\" width=\"94\" height=\"24\"/>",
                x + 3,
                y + 3
            );
        }
        let _ =
            writeln!(body, "<text x=\"{}\" y=\"{}\">{}</text>", x + 8, y + 20, escaped(&step.name));
        for (row, block) in step.blocks.iter().enumerate() {
            let time = block.time.as_ref().map(|time| format!(" {}", crate::iec::show::expr(time)));
            let told = format!(
                "{}{} {}",
                block.qualifier.name(),
                time.unwrap_or_default(),
                block.target.name()
            );
            let _ = writeln!(
                body,
                "<text x=\"{}\" y=\"{}\">{}</text>",
                x + 108,
                y + 12 + row * 14,
                escaped(&told)
            );
        }
    }
    for one in &study.chart.macros {
        frame(&one.name, &one.steps, &places, &at, body);
    }
    for (number, one) in study.chart.transitions.iter().enumerate() {
        let (x, y) = at(one.from[0]);
        let beside = study.chart.transitions[..number]
            .iter()
            .filter(|other| other.from[0] == one.from[0])
            .count();
        let (x, y) = (x + 50 + beside * 60, y + 60);
        let _ = writeln!(
            body,
            "<line class=\"bar\" x1=\"{}\" y1=\"{y}\" x2=\"{}\" y2=\"{y}\"/>",
            x - 12,
            x + 12
        );
        let condition = crate::iec::show::expr(&one.condition);
        let shown: String = condition.chars().take(40).collect();
        let _ = writeln!(body, "<text x=\"{}\" y=\"{}\">{}</text>", x + 16, y + 4, escaped(&shown));
        for &step in &one.from {
            let (from, below) = at(step);
            let _ = writeln!(body, "<path d=\"M{} {} L{x} {y}\"/>", from + 50, below + 30);
        }
        for &step in &one.to {
            let (to, above) = at(step);
            let class = if above <= y { " class=\"back\"" } else { "" };
            let _ = writeln!(body, "<path{class} d=\"M{x} {y} L{} {above}\"/>", to + 50);
        }
    }
    let columns = places.iter().map(|place| place.1).max().unwrap_or(0) + 1;
    let levels = places.iter().map(|place| place.0).max().unwrap_or(0) + 1;
    (40 + columns * WIDTH, levels * HEIGHT)
}

/// A frame around the steps of a macro step, where no other step stands among them.
fn frame(
    name: &str,
    steps: &[usize],
    places: &[(usize, usize)],
    at: &dyn Fn(usize) -> (usize, usize),
    body: &mut String,
) {
    let side = |of: fn(&(usize, usize)) -> usize| {
        let all = steps.iter().map(|&step| of(&places[step]));
        all.clone().min().unwrap_or(0)..=all.max().unwrap_or(0)
    };
    let (levels, columns) = (side(|place| place.0), side(|place| place.1));
    let stands = |place: &(usize, usize)| levels.contains(&place.0) && columns.contains(&place.1);
    let alone = (0..places.len()).all(|step| steps.contains(&step) || !stands(&places[step]));
    let found = steps.iter().map(|&step| at(step));
    let (left, top) =
        found.clone().fold((usize::MAX, usize::MAX), |(x, y), (a, b)| (x.min(a), y.min(b)));
    let (right, bottom) = found.fold((0, 0), |(x, y), (a, b)| (x.max(a), y.max(b)));
    if alone {
        let (width, height) = (right - left + 270, bottom - top + 50);
        let _ = writeln!(
            body,
            "<rect class=\"macro\" x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\"/>",
            left - 10,
            top - 14
        );
        let _ =
            writeln!(body, "<text x=\"{}\" y=\"{}\">{}</text>", left - 6, top - 3, escaped(name));
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

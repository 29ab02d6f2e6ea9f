//! Charts as pictures: the flow from top to bottom, with action blocks, and bars beside the steps over which an action
//! may be stored.

mod flow;
mod shape;

use self::flow::{FRAME, Flow, LANE, NAME};
use self::shape::{STEP, Shape, What, escaped, wide};
use super::Study;
use scanbound_iec::chart::coactive::{How, Other, resetting, storing};
use std::fmt::Write;

const STYLE: &str = "text{font:12px sans-serif}.name{font-weight:bold}rect{fill:none;stroke:black}path{stroke:black;\
    fill:none}.bar{stroke-width:4}.head{fill:black}.step{fill:white}.with{font-style:italic}\
    .mid{text-anchor:middle}.macro{stroke:gray;stroke-dasharray:4;fill:#f6f6f6}.lane{font-size:10px}";
/// What the bars of stored actions are filled with.
const COLOURS: [&str; 8] =
    ["#9ecae1", "#fdbf6f", "#a1d99b", "#cab2d6", "#fb9a99", "#e3dc8a", "#c9a68a", "#c4c4c4"];
/// How wide a row of charts becomes before the next one begins.
const PAGE: i32 = 1_600;
/// The space around charts.
const MARGIN: i32 = 24;

/// One picture, the charts beside and below each other.
#[must_use]
pub fn render(studies: &[Study<'_>]) -> String {
    let mut body = String::new();
    let (mut x, mut y, mut row, mut widest) = (MARGIN, MARGIN, 0, 0);
    for study in studies {
        let chart = Picture::new(study);
        let (width, height) = chart.size();
        if x > MARGIN && x + width > PAGE {
            (x, y, row) = (MARGIN, y + row + MARGIN, 0);
        }
        chart.write((x, y), &mut body);
        x += width + 2 * MARGIN;
        row = row.max(height);
        widest = widest.max(x - MARGIN);
    }
    let height = y + row + MARGIN;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{widest}\" height=\"{height}\" \
         viewBox=\"0 0 {widest} {height}\">\n<style>{STYLE}</style>\n\
         <rect width=\"{widest}\" height=\"{height}\" style=\"fill:white;stroke:none\"/>\n{body}</svg>\n"
    )
}

/// An action that may be stored.
struct Lasting {
    name: String,
    told: String,
    /// The steps over which.
    steps: Vec<usize>,
}

/// Where a step is drawn: the midst of its upper edge, how wide it is, and how far its blocks reach.
#[derive(Clone, Copy)]
struct Place {
    x: i32,
    y: i32,
    width: i32,
    right: i32,
    height: i32,
}

struct Picture<'a> {
    study: &'a Study<'a>,
    lasting: Vec<Lasting>,
    shape: Shape,
    places: Vec<Option<Place>>,
    /// How far the bars are from the line of flow.
    half: i32,
}

impl<'a> Picture<'a> {
    fn new(study: &'a Study<'a>) -> Picture<'a> {
        let chart = study.chart;
        let lasting = lasting(study);
        let lanes = |step: usize| {
            let own = |one: &Lasting| one.steps.contains(&step);
            lasting.iter().rposition(own).map_or(0, |last| last + 1)
        };
        let mut across = vec![Vec::new(); chart.steps.len()];
        for &at in &study.structure.jumps {
            let from = &chart.transitions[at].from;
            if from.len() > 1 && !study.structure.has(at) {
                from.iter().for_each(|&step| across[step].push(at));
            }
        }
        let order = study.structure.part.steps();
        let mut frames = vec![0; chart.steps.len()];
        for one in &chart.macros {
            let first = order.iter().find(|step| one.steps.contains(step));
            first.into_iter().for_each(|&step| frames[step] += 1);
        }
        let lanes = (0..chart.steps.len()).map(lanes).collect();
        let flow = Flow { chart, across, lanes, frames };
        let shape = flow.tree(&study.structure.part);
        let mut places = vec![None; chart.steps.len()];
        for (x, y, what) in &shape.items {
            if let What::Step(step, width, right, height) = *what {
                places[step] = Some(Place { x: *x, y: *y, width, right, height });
            }
        }
        Picture { study, lasting, shape, places, half: flow.half() }
    }

    /// How high the lines above the chart are.
    fn head(&self) -> i32 {
        28 + 18 * self.lasting.len() as i32
    }

    fn size(&self) -> (i32, i32) {
        let texts = self.lasting.iter().map(|one| wide(&one.told) + 20);
        let texts = texts.chain([wide(&self.study.name) * 11 / 10]).max().unwrap_or(0);
        let macros = if self.study.chart.macros.is_empty() { 0 } else { 24 };
        let width = self.shape.left + self.shape.right + macros;
        (width.max(texts), self.head() + self.shape.height)
    }

    fn write(&self, (x, y): (i32, i32), body: &mut String) {
        let name = escaped(&self.study.name);
        let _ = writeln!(body, "<text x=\"{x}\" y=\"{}\" class=\"name\">{name}</text>", y + 12);
        for (number, one) in self.lasting.iter().enumerate() {
            let (y, colour) = (y + 20 + 18 * number as i32, colour(number));
            let _ = writeln!(
                body,
                "<rect x=\"{x}\" y=\"{y}\" width=\"12\" height=\"12\" style=\"fill:{colour}\"/>\
                 <text x=\"{}\" y=\"{}\">{}</text>",
                x + 18,
                y + 10,
                escaped(&one.told)
            );
        }
        let inner = if self.study.chart.macros.is_empty() { 0 } else { 12 };
        let at = (x + inner + self.shape.left, y + self.head());
        self.frames(at, body);
        self.lanes(at, body);
        self.shape.write(at, body);
    }

    /// The bars of stored actions. Where a step follows another one below it, the bar goes on between them.
    fn lanes(&self, (x, y): (i32, i32), body: &mut String) {
        let ways = &self.study.chart.transitions;
        for (number, one) in self.lasting.iter().enumerate() {
            let mut own: Vec<(Place, usize)> = one
                .steps
                .iter()
                .filter_map(|&step| self.places[step].map(|place| (place, step)))
                .collect();
            own.sort_by_key(|(place, _)| (place.x, place.y));
            let mut bars: Vec<(Place, usize, i32)> = Vec::new();
            for (place, step) in own {
                let follows = |before: usize| {
                    ways.iter().any(|one| one.from.contains(&before) && one.to.contains(&step))
                };
                match bars.last_mut() {
                    Some((first, last, end)) if first.x == place.x && follows(*last) => {
                        (*last, *end) = (step, place.y + STEP);
                    }
                    _ => bars.push((place, step, place.y + STEP)),
                }
            }
            for (first, _, end) in bars {
                let left = x + first.x - self.half - LANE * (number as i32 + 1);
                let (top, height) = (y + first.y, end - first.y);
                let _ = writeln!(
                    body,
                    "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{height}\" style=\"fill:{}\">\
                     <title>{}</title></rect>",
                    LANE - 2,
                    colour(number),
                    escaped(&one.told)
                );
                if wide(&one.name) <= height {
                    let (x, y) = (left + 9, top + (height + wide(&one.name) * 5 / 6) / 2);
                    let _ = writeln!(
                        body,
                        "<text class=\"lane\" transform=\"translate({x} {y}) rotate(-90)\">{}</text>",
                        escaped(&one.name)
                    );
                }
            }
        }
    }

    /// Frames around the steps of macro steps, where no other step stands among them.
    fn frames(&self, (x, y): (i32, i32), body: &mut String) {
        let macros = &self.study.chart.macros;
        let order = self.study.structure.part.steps();
        for one in macros {
            let own: Vec<Place> = one.steps.iter().filter_map(|&step| self.places[step]).collect();
            // Those within stand closer.
            let within = macros.iter().filter(|other| {
                other.steps.len() < one.steps.len()
                    && other.steps.iter().all(|step| one.steps.contains(step))
            });
            let first = order.iter().find(|step| one.steps.contains(step));
            let alike =
                within.clone().filter(|other| first.is_some_and(|at| other.steps.contains(at)));
            let (within, alike) = (within.count() as i32 + 1, alike.count() as i32 + 1);
            let least = |of: &dyn Fn(&Place) -> i32| own.iter().map(of).min().unwrap_or(0);
            let left = least(&|place| place.x - place.width / 2) - FRAME * within;
            let top = least(&|place| place.y) - (NAME + FRAME) * alike + FRAME - 3;
            let right = FRAME * within - least(&|place| -(place.x + place.right));
            let bottom = 2 + 3 * within - least(&|place| -(place.y + place.height));
            let stands = |place: &Place| {
                (left..right).contains(&place.x) && (top..bottom).contains(&place.y)
            };
            let others = self.places.iter().enumerate();
            let mut others = others.filter(|(step, _)| !one.steps.contains(step));
            if own.is_empty() || others.any(|(_, place)| place.as_ref().is_some_and(stands)) {
                continue;
            }
            let right = right.max(left + wide(&one.name) + 12);
            let _ = writeln!(
                body,
                "<rect class=\"macro\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\
                 <text x=\"{}\" y=\"{}\">{}</text>",
                x + left,
                y + top,
                right - left,
                bottom - top,
                x + left + 5,
                y + top + 13,
                escaped(&one.name)
            );
        }
    }
}

fn colour(number: usize) -> &'static str {
    COLOURS[number % COLOURS.len()]
}

/// The actions that may be stored beyond the steps that store them.
fn lasting(study: &Study<'_>) -> Vec<Lasting> {
    let chart = study.chart;
    let all = chart.actions().into_iter().filter_map(|name| {
        let by = storing(chart, &name);
        if by.is_empty() {
            return None;
        }
        let until = resetting(chart, &name);
        let told = study.how(&name, &How::Stored { by: by.clone(), until });
        let beside = study.analysis.pairs.iter().filter(|pair| {
            pair.action == name && matches!(pair.how, How::Stored { .. } | How::Parallel)
        });
        let beside = beside.filter_map(|pair| match pair.other {
            Other::Step(step) => Some(step),
            Other::Action(_) => None,
        });
        let mut steps: Vec<usize> = by.into_iter().chain(beside).collect();
        steps.sort_unstable();
        steps.dedup();
        Some(Lasting { told: format!("{name}: {told}"), name, steps })
    });
    all.collect()
}

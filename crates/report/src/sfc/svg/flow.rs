//! How the tree of a chart becomes a picture: what follows stands below, branches stand beside each other.

use super::super::rows;
use super::shape::{STEP, Shape, What, wide};
use scanbound_iec::chart::structure::Part;
use scanbound_iec::chart::{Chart, Step};
use scanbound_iec::show;

/// How wide a condition or a name of an action may be.
const TEXT: i32 = 300;
/// How wide the bar of a stored action is.
pub(super) const LANE: i32 = 13;

/// A chart, and what the picture shows besides its tree.
pub(super) struct Flow<'a> {
    pub chart: &'a Chart,
    /// For each step the transitions that it joins with steps of other branches, and that are not in the tree.
    pub across: Vec<Vec<usize>>,
    /// For each step how many bars of stored actions are kept free at its left.
    pub lanes: Vec<usize>,
    /// For each step the macro steps whose frame begins above it.
    pub frames: Vec<usize>,
}

/// The space that a macro step's frame takes around what stands in it.
pub(super) const FRAME: i32 = 8;
/// The space of its name.
pub(super) const NAME: i32 = 16;

/// What flow comes through one after the other.
enum Segment<'a> {
    Step(usize),
    Transition(usize),
    Selection(&'a [Part]),
    Parallel(&'a [Part]),
    Others(&'a [Part]),
    /// Ways that lead out at this place.
    Sides(Vec<Side<'a>>),
}

#[derive(Clone, Copy)]
enum Side<'a> {
    /// A way of the tree.
    Way(&'a Part),
    /// A transition that this step joins with others.
    Join(usize, usize),
    /// The transition that ends the main way.
    Last(usize),
}

impl Flow<'_> {
    /// How far bars of stored actions are from the line of flow.
    pub fn half(&self) -> i32 {
        let frames = FRAME * self.chart.macros.len() as i32;
        let boxes = self.chart.steps.iter().map(|step| width(step) / 2);
        boxes.max().unwrap_or(0) + frames + 4
    }

    /// The picture of a tree.
    pub fn tree(&self, part: &Part) -> Shape {
        self.flow(part, false)
    }

    /// The segments of a part.
    fn segments<'p>(&self, part: &'p Part, into: &mut Vec<Segment<'p>>) {
        let side = |into: &mut Vec<Segment<'p>>, side| match into.last_mut() {
            Some(Segment::Sides(sides)) => sides.push(side),
            _ => into.push(Segment::Sides(vec![side])),
        };
        match part {
            Part::Step(step) => {
                into.push(Segment::Step(*step));
                self.across[*step].iter().for_each(|&at| side(into, Side::Join(*step, at)));
            }
            Part::Transition(at) => into.push(Segment::Transition(*at)),
            Part::Sequence(parts) => parts.iter().for_each(|part| self.segments(part, into)),
            Part::Selection(parts) => into.push(Segment::Selection(parts)),
            Part::Parallel(parts) => into.push(Segment::Parallel(parts)),
            Part::Loop(body, way) | Part::Exit(body, way) => {
                self.segments(body, into);
                side(into, Side::Way(way));
            }
            Part::Tangle(parts) => into.push(Segment::Others(parts)),
        }
    }

    /// A part; whether flow goes on below it.
    fn flow(&self, part: &Part, goes_on: bool) -> Shape {
        let mut segments = Vec::new();
        self.segments(part, &mut segments);
        let mut shape = Shape::default();
        let mut at = 0;
        while at < segments.len() {
            let is_last = at + 1 == segments.len();
            match &segments[at] {
                Segment::Step(step) => shape.add(self.step(*step)),
                Segment::Transition(one) => shape.add(self.transition(*one)),
                Segment::Selection(parts) => shape.add(self.selection(parts, &[])),
                Segment::Parallel(parts) => shape.add(self.parallel(parts, goes_on || !is_last)),
                Segment::Others(parts) => {
                    let all = parts.iter().map(|part| self.flow(part, false)).collect();
                    let (_, height) = shape.beside(all, shape.height);
                    shape.height += height;
                }
                Segment::Sides(sides) => {
                    let ends = at + 2 == segments.len() && !goes_on;
                    if let (true, Some(Segment::Transition(one))) = (ends, segments.get(at + 1)) {
                        let all: Vec<Side<'_>> =
                            [Side::Last(*one)].into_iter().chain(sides.iter().copied()).collect();
                        shape.add(self.ends(&all));
                        return shape;
                    }
                    // What flow goes on with is one of the branches, too.
                    let next = match segments.get(at + 1) {
                        Some(Segment::Selection(parts)) => parts,
                        Some(Segment::Transition(one)) => &[Part::Transition(*one)][..],
                        _ => &[],
                    };
                    if next.is_empty() && is_last && !goes_on {
                        shape.add(self.ends(sides));
                    } else {
                        shape.add(self.selection(next, sides));
                    }
                    at += usize::from(!next.is_empty());
                }
            }
            at += 1;
        }
        let targets = part.last();
        if !goes_on && !targets.is_empty() {
            shape.add(self.jump(&targets));
        }
        shape
    }

    /// A step with its action blocks.
    fn step(&self, at: usize) -> Shape {
        let step = &self.chart.steps[at];
        let width = width(step);
        let rows = cells(step);
        let mut shape = Shape::default();
        shape.rect((-width / 2, 0), (width, STEP), "step");
        if step.initial {
            shape.rect((3 - width / 2, 3), (width - 6, STEP - 6), "");
        }
        shape.items.push((0, 19, What::Text(step.name.clone(), None, "mid")));
        shape.height = STEP;
        if !rows.is_empty() {
            self.blocks(width, &rows, &mut shape);
        }
        shape.items.push((0, 0, What::Step(at, width, shape.right, shape.height)));
        if self.lanes[at] > 0 {
            shape.reach(self.half() + LANE * self.lanes[at] as i32, 0);
        }
        if self.frames[at] == 0 {
            return shape;
        }
        let mut framed = Shape::default();
        framed.down((NAME + FRAME) * self.frames[at] as i32);
        framed.add(shape);
        framed.reach(framed.left + FRAME * 2, framed.right + FRAME * 2);
        framed
    }

    /// The action blocks of a step whose box is so wide.
    fn blocks(&self, width: i32, rows: &[Cells], shape: &mut Shape) {
        let column = |of: fn(&Cells) -> &str| {
            rows.iter().map(|row| wide(of(row)).min(TEXT)).max().unwrap_or(0) + 12
        };
        let columns = [column(|row| &row[0]), column(|row| &row[1]), column(|row| &row[2])];
        let left = width - width / 2 + 14;
        shape.line((width - width / 2, STEP / 2), (left, STEP / 2), "");
        for (number, row) in rows.iter().enumerate() {
            let (mut x, y) = (left, 5 + 20 * number as i32);
            for (text, width) in row.iter().zip(columns) {
                shape.rect((x, y), (width, 20), "");
                shape.text((x + 6, y + 14), text, TEXT, "");
                x += width;
            }
        }
        shape.reach(0, left + columns.iter().sum::<i32>());
        shape.down((5 + 20 * rows.len() as i32 - STEP).max(0));
    }

    fn transition(&self, at: usize) -> Shape {
        let one = &self.chart.transitions[at];
        let mut shape = Shape::default();
        shape.down(28);
        shape.line((-11, 14), (11, 14), "bar");
        let condition = show::expr(&one.condition);
        let told = match &one.name {
            Some(name) if *name != condition => format!("{name}: {condition}"),
            _ => condition,
        };
        shape.text((17, 18), &told, TEXT, "");
        shape
    }

    /// The arrow at the end of a way that jumps.
    fn jump(&self, transitions: &[usize]) -> Shape {
        let mut names: Vec<&str> = Vec::new();
        for &at in transitions {
            for &step in &self.chart.transitions[at].to {
                let name = self.chart.steps[step].name.as_str();
                if !names.contains(&name) {
                    names.push(name);
                }
            }
        }
        let mut shape = Shape::default();
        shape.down(12);
        shape.items.push((0, 20, What::Head));
        shape.text((9, 19), &names.join(", "), TEXT, "");
        shape.reach(8, 8);
        shape.height = 30;
        shape
    }

    fn side(&self, side: Side<'_>) -> Shape {
        let (step, at) = match side {
            Side::Way(part) => return self.flow(part, false),
            Side::Join(step, at) => (step, at),
            Side::Last(at) => {
                let mut shape = self.transition(at);
                shape.add(self.jump(&[at]));
                return shape;
            }
        };
        let from = &self.chart.transitions[at].from;
        let others: Vec<&str> = from
            .iter()
            .filter(|&&other| other != step)
            .map(|&other| self.chart.steps[other].name.as_str())
            .collect();
        let mut shape = Shape::default();
        shape.down(10);
        shape.double(-14, 14, 10);
        shape.text((18, 16), &format!("with {}", others.join(", ")), TEXT, "with");
        shape.height = 14;
        // What the steps join to stands at the first of them.
        if from.first() == Some(&step) {
            shape.add(self.transition(at));
            shape.add(self.jump(&[at]));
        } else {
            shape.height = 30;
        }
        shape
    }

    /// Ways out of which nothing goes on below.
    fn ends(&self, sides: &[Side<'_>]) -> Shape {
        let all: Vec<Shape> = sides.iter().map(|&side| self.side(side)).collect();
        let mut shape = Shape::default();
        if all.len() > 1 {
            shape.down(10);
        }
        let y = shape.height;
        let (places, height) = shape.beside(all, y);
        if let (true, Some(&last)) = (places.len() > 1, places.last()) {
            shape.line((0, y), (last, y), "");
        }
        shape.height += height;
        shape
    }

    /// Branches that join again, and ways beside them that do not.
    fn selection(&self, parts: &[Part], sides: &[Side<'_>]) -> Shape {
        let mut all: Vec<Shape> = parts.iter().map(|part| self.flow(part, true)).collect();
        if all.is_empty() {
            all.push(Shape { left: 12, right: 12, ..Shape::default() });
        }
        let joined = all.len();
        let heights: Vec<i32> = all.iter().map(|one| one.height).collect();
        all.extend(sides.iter().map(|&side| self.side(side)));
        let mut shape = Shape::default();
        shape.down(10);
        let (places, height) = shape.beside(all, 10);
        let bottom = 10 + height;
        shape.line((0, 10), (places[places.len() - 1], 10), "");
        for (&x, own) in places[..joined].iter().zip(heights) {
            if own < height {
                shape.line((x, 10 + own), (x, bottom), "");
            }
        }
        if joined > 1 {
            shape.line((0, bottom), (places[joined - 1], bottom), "");
        }
        shape.height = bottom;
        shape.down(8);
        shape
    }

    /// Branches that are gone through together; whether they are joined.
    fn parallel(&self, parts: &[Part], is_joined: bool) -> Shape {
        let all: Vec<Shape> = parts.iter().map(|part| self.flow(part, is_joined)).collect();
        let heights: Vec<i32> = all.iter().map(|one| one.height).collect();
        let mut shape = Shape::default();
        let (places, height) = shape.beside(all, 16);
        let last = places[places.len() - 1];
        shape.double(-14, last + 14, 0);
        places.iter().for_each(|&x| shape.line((x, 4), (x, 16), ""));
        let bottom = 16 + height + 8;
        shape.height = bottom;
        if is_joined {
            for (&x, own) in places.iter().zip(heights) {
                shape.line((x, 16 + own), (x, bottom), "");
            }
            shape.double(-14, last + 14, bottom);
            shape.height = bottom + 4;
        }
        shape
    }
}

/// Qualifier, time and name of an action block.
type Cells = [String; 3];

fn cells(step: &Step) -> Vec<Cells> {
    let all = rows(step);
    all.map(|row| [row.qualifier.to_owned(), row.time.unwrap_or_default(), row.action]).collect()
}

/// How wide a step's box is.
fn width(step: &Step) -> i32 {
    (wide(&step.name) + 22).max(60)
}

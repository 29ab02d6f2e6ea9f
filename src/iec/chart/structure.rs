//! A chart as a tree of sequences, selections, parallels and loops, found by taking its net together step by step.
//!
//! Each rule replaces a part of the net by one place or one transition that stands for it, and keeps the net's behaviour:
//! a place between two transitions is taken into one transition, two places with a transition between into one place, two
//! transitions between the same places become a selection, two places between the same transitions a parallel, and a
//! transition from a place to itself a loop. What no rule applies to any more is not well nested, and is shown as it is.

use super::Chart;
use std::collections::BTreeMap;

/// A part of a chart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    /// A step.
    Step(usize),
    /// A transition.
    Transition(usize),
    /// Parts that follow each other.
    Sequence(Vec<Part>),
    /// Parts of which one is gone through.
    Selection(Vec<Part>),
    /// Parts that are gone through at the same time.
    Parallel(Vec<Part>),
    /// A part, and the way that leads from its end to its beginning.
    Loop(Box<Part>, Box<Part>),
    /// Parts that do not nest.
    Tangle(Vec<Part>),
}

impl Part {
    /// Puts two parts behind each other.
    fn then(self, next: Part) -> Part {
        let mut all = match self {
            Part::Sequence(parts) => parts,
            one => vec![one],
        };
        match next {
            Part::Sequence(parts) => all.extend(parts),
            one => all.push(one),
        }
        Part::Sequence(all)
    }

    /// Whether it is a tangle, or has one in it.
    #[must_use]
    pub fn is_tangled(&self) -> bool {
        match self {
            Part::Step(_) | Part::Transition(_) => false,
            Part::Tangle(_) => true,
            Part::Sequence(parts) | Part::Selection(parts) | Part::Parallel(parts) => {
                parts.iter().any(Part::is_tangled)
            }
            Part::Loop(body, back) => body.is_tangled() || back.is_tangled(),
        }
    }

    /// How many selections, parallels and loops it has.
    #[must_use]
    pub fn count(&self) -> [usize; 3] {
        let own = match self {
            Part::Selection(_) => [1, 0, 0],
            Part::Parallel(_) => [0, 1, 0],
            Part::Loop(..) => [0, 0, 1],
            _ => [0, 0, 0],
        };
        let inner: Vec<&Part> = match self {
            Part::Step(_) | Part::Transition(_) => Vec::new(),
            Part::Sequence(parts)
            | Part::Selection(parts)
            | Part::Parallel(parts)
            | Part::Tangle(parts) => parts.iter().collect(),
            Part::Loop(body, back) => vec![body, back],
        };
        inner
            .into_iter()
            .map(Part::count)
            .fold(own, |sum, more| [sum[0] + more[0], sum[1] + more[1], sum[2] + more[2]])
    }
}

#[derive(Debug, Clone)]
struct Place {
    part: Part,
    initial: bool,
}

#[derive(Debug, Clone)]
struct Move {
    part: Part,
    from: Vec<usize>,
    to: Vec<usize>,
}

struct Net {
    places: Vec<Option<Place>>,
    moves: Vec<Option<Move>>,
}

/// The tree of a chart.
#[must_use]
pub fn structure(chart: &Chart) -> Part {
    let place = |(at, step): (usize, &super::Step)| {
        Some(Place { part: Part::Step(at), initial: step.initial })
    };
    let way = |(at, one): (usize, &super::Transition)| {
        Some(Move { part: Part::Transition(at), from: one.from.clone(), to: one.to.clone() })
    };
    let mut net = Net {
        places: chart.steps.iter().enumerate().map(place).collect(),
        moves: chart.transitions.iter().enumerate().map(way).collect(),
    };
    while net.select() || net.parallel() || net.pass() || net.follow() || net.turn() {}
    let mut rest: Vec<Part> = net.places.into_iter().flatten().map(|place| place.part).collect();
    rest.extend(net.moves.into_iter().flatten().map(|one| one.part));
    if rest.len() == 1 { rest.remove(0) } else { Part::Tangle(rest) }
}

/// The transitions that put a token into a place, and those that take one.
type Around = (Vec<usize>, Vec<usize>);

/// A part, which another one takes the place of.
fn taken(part: &mut Part) -> Part {
    std::mem::replace(part, Part::Sequence(Vec::new()))
}

fn many(
    parts: [Part; 2],
    wrap: fn(Vec<Part>) -> Part,
    open: fn(Part) -> Result<Vec<Part>, Part>,
) -> Part {
    let mut flat = Vec::new();
    for part in parts {
        match open(part) {
            Ok(inner) => flat.extend(inner),
            Err(one) => flat.push(one),
        }
    }
    wrap(flat)
}

impl Net {
    /// What stands around each place.
    fn around(&self) -> Vec<Around> {
        let mut around = vec![Around::default(); self.places.len()];
        for (at, one) in self.moves.iter().enumerate() {
            let Some(one) = one else { continue };
            one.to.iter().for_each(|&place| around[place].0.push(at));
            one.from.iter().for_each(|&place| around[place].1.push(at));
        }
        around
    }

    /// Transitions between the same places.
    fn select(&mut self) -> bool {
        let mut known: BTreeMap<(Vec<usize>, Vec<usize>), usize> = BTreeMap::new();
        let mut changed = false;
        for at in 0..self.moves.len() {
            let Some(one) = &self.moves[at] else { continue };
            let first = *known.entry((one.from.clone(), one.to.clone())).or_insert(at);
            if first == at {
                continue;
            }
            let second = self.moves[at].take();
            if let (Some(one), Some(other)) = (&mut self.moves[first], second) {
                one.part =
                    many([taken(&mut one.part), other.part], Part::Selection, |part| match part {
                        Part::Selection(inner) => Ok(inner),
                        other => Err(other),
                    });
            }
            changed = true;
        }
        changed
    }

    /// Places between the same transitions.
    fn parallel(&mut self) -> bool {
        let around = self.around();
        let mut known: BTreeMap<(&Around, bool), usize> = BTreeMap::new();
        let mut changed = false;
        for (at, own) in around.iter().enumerate() {
            let Some(one) = &self.places[at] else { continue };
            if own.0.is_empty() || own.1.is_empty() {
                continue;
            }
            let first = *known.entry((own, one.initial)).or_insert(at);
            if first == at {
                continue;
            }
            let second = self.places[at].take();
            if let (Some(one), Some(other)) = (&mut self.places[first], second) {
                one.part =
                    many([taken(&mut one.part), other.part], Part::Parallel, |part| match part {
                        Part::Parallel(inner) => Ok(inner),
                        other => Err(other),
                    });
            }
            changed = true;
        }
        if changed {
            let Net { places, moves } = self;
            for one in moves.iter_mut().flatten() {
                one.from.retain(|&place| places[place].is_some());
                one.to.retain(|&place| places[place].is_some());
            }
        }
        changed
    }

    /// Places that one transition leads into, alone, and another out of, alone.
    fn pass(&mut self) -> bool {
        let mut around = self.around();
        let mut changed = false;
        for place in 0..self.places.len() {
            let (&[into], &[out]) = (&around[place].0[..], &around[place].1[..]) else { continue };
            let [Some(before), Some(behind)] = [&self.moves[into], &self.moves[out]] else {
                continue;
            };
            if into == out
                || before.to != [place]
                || behind.from != [place]
                || self.places[place].as_ref().is_none_or(|one| one.initial)
            {
                continue;
            }
            let (inner, behind) = (self.places[place].take(), self.moves[out].take());
            if let (Some(before), Some(inner), Some(behind)) =
                (&mut self.moves[into], inner, behind)
            {
                for &next in &behind.to {
                    let way = around[next].0.iter_mut().filter(|way| **way == out);
                    way.for_each(|way| *way = into);
                }
                before.part = taken(&mut before.part).then(inner.part).then(behind.part);
                before.to = behind.to;
            }
            changed = true;
        }
        changed
    }

    /// Two places with a transition between them that is the only way out of the one and into the other.
    fn follow(&mut self) -> bool {
        let around = self.around();
        for way in 0..self.moves.len() {
            let Some(one) = &self.moves[way] else { continue };
            let (&[from], &[to]) = (&one.from[..], &one.to[..]) else { continue };
            if from == to || around[from].1 != [way] || around[to].0 != [way] {
                continue;
            }
            if self.places[to].as_ref().is_none_or(|second| second.initial) {
                continue;
            }
            let (between, second) = (self.moves[way].take(), self.places[to].take());
            if let (Some(first), Some(between), Some(second)) =
                (&mut self.places[from], between, second)
            {
                first.part = taken(&mut first.part).then(between.part).then(second.part);
            }
            for one in self.moves.iter_mut().flatten() {
                one.from.iter_mut().filter(|place| **place == to).for_each(|place| *place = from);
            }
            return true;
        }
        false
    }

    /// A transition from a place to itself.
    fn turn(&mut self) -> bool {
        for way in 0..self.moves.len() {
            let Some(one) = &self.moves[way] else { continue };
            let (&[from], &[to]) = (&one.from[..], &one.to[..]) else { continue };
            if from != to {
                continue;
            }
            let back = Box::new(one.part.clone());
            if let Some(place) = &mut self.places[from] {
                let body = Box::new(place.part.clone());
                place.part = Part::Loop(body, back);
            }
            self.moves[way] = None;
            return true;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iec::Body;
    use crate::iec::parse::file;

    fn told(chart: &Chart, part: &Part) -> String {
        let all = |parts: &[Part], sign: &str| {
            parts
                .iter()
                .map(|part| told(chart, part))
                .filter(|text| !text.is_empty())
                .collect::<Vec<_>>()
                .join(sign)
        };
        match part {
            Part::Step(step) => chart.steps[*step].name.clone(),
            Part::Transition(_) => String::new(),
            Part::Sequence(parts) => all(parts, " "),
            Part::Selection(parts) => format!("({})", all(parts, " | ")),
            Part::Parallel(parts) => format!("[{}]", all(parts, " & ")),
            Part::Loop(body, back) => {
                format!("{{{}}}", all(&[(**body).clone(), (**back).clone()], " ^ "))
            }
            Part::Tangle(parts) => format!("?{}?", all(parts, ", ")),
        }
    }

    fn of(steps: &str, ways: &[(&str, &str)]) -> String {
        let mut text = "PROGRAM p\n".to_owned();
        for (at, step) in steps.split(' ').enumerate() {
            let word = if at == 0 { "INITIAL_STEP" } else { "STEP" };
            text += &format!("{word} {step}: END_STEP\n");
        }
        for (from, to) in ways {
            text += &format!("TRANSITION FROM {from} TO {to} := x; END_TRANSITION\n");
        }
        text += "END_PROGRAM";
        let project = file("a.st", &text).expect("a chart");
        let Body::Chart(chart) = &project.pous[0].body else { panic!("a chart") };
        told(chart, &structure(chart))
    }

    #[test]
    fn loops_selections_and_parallels_nest() {
        assert_eq!(of("a b c", &[("a", "b"), ("b", "c"), ("c", "a")]), "{a ^ b c}");
        assert_eq!(
            of("a b c d", &[("a", "b"), ("a", "c"), ("b", "d"), ("c", "d"), ("d", "a")]),
            "{a ^ (b | c) d}"
        );
        assert_eq!(
            of("a b c d e", &[("a", "(b, c)"), ("b", "d"), ("(c, d)", "e"), ("e", "a")]),
            "{a ^ [b d & c] e}"
        );
        assert_eq!(
            of(
                "a b c d e",
                &[("a", "(b, c)"), ("b", "d"), ("b", "e"), ("d", "e"), ("(c, e)", "a")]
            ),
            "{a ^ [b (d) e & c]}"
        );
    }

    #[test]
    fn what_does_not_nest_is_shown_as_it_is() {
        // A way out of one branch of a parallel.
        let text = of("a b c d", &[("a", "(b, c)"), ("b", "d"), ("(b, c)", "a"), ("d", "a")]);
        assert!(text.starts_with('?'), "{text}");
    }
}

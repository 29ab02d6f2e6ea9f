//! A chart as a tree of sequences, selections, parallels and loops, found by taking its net together step by step.
//!
//! Each rule replaces a part of the net by one place or one transition that stands for it, and keeps the net's behaviour:
//! a place between two transitions is taken into one transition, two places with a transition between into one place, two
//! transitions between the same places become a selection, two places between the same transitions a parallel, and a
//! transition from a place to itself a loop. What no rule applies to any more is not well nested, and is shown as it is.

use super::Chart;

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

fn many(
    mut parts: Vec<Part>,
    wrap: fn(Vec<Part>) -> Part,
    open: fn(Part) -> Result<Vec<Part>, Part>,
) -> Part {
    let mut flat = Vec::new();
    for part in parts.drain(..) {
        match open(part) {
            Ok(inner) => flat.extend(inner),
            Err(one) => flat.push(one),
        }
    }
    wrap(flat)
}

impl Net {
    /// The transitions that put a token into a place, and those that take one.
    fn around(&self, place: usize) -> (Vec<usize>, Vec<usize>) {
        let that = |side: fn(&Move) -> &Vec<usize>| {
            let all = self.moves.iter().enumerate();
            let own =
                all.filter(|(_, one)| one.as_ref().is_some_and(|one| side(one).contains(&place)));
            own.map(|(at, _)| at).collect::<Vec<_>>()
        };
        (that(|one| &one.to), that(|one| &one.from))
    }

    /// Two transitions between the same places.
    fn select(&mut self) -> bool {
        for first in 0..self.moves.len() {
            for second in first + 1..self.moves.len() {
                let (Some(one), Some(other)) = (&self.moves[first], &self.moves[second]) else {
                    continue;
                };
                if one.from != other.from || one.to != other.to {
                    continue;
                }
                let parts = vec![one.part.clone(), other.part.clone()];
                let part = many(parts, Part::Selection, |part| match part {
                    Part::Selection(inner) => Ok(inner),
                    other => Err(other),
                });
                if let Some(one) = &mut self.moves[first] {
                    one.part = part;
                }
                self.moves[second] = None;
                return true;
            }
        }
        false
    }

    /// Two places between the same transitions.
    fn parallel(&mut self) -> bool {
        let around: Vec<_> = (0..self.places.len()).map(|place| self.around(place)).collect();
        for first in 0..self.places.len() {
            for second in first + 1..self.places.len() {
                let (Some(one), Some(other)) = (&self.places[first], &self.places[second]) else {
                    continue;
                };
                let alike = around[first] == around[second] && one.initial == other.initial;
                if !alike || around[first].0.is_empty() || around[first].1.is_empty() {
                    continue;
                }
                let parts = vec![one.part.clone(), other.part.clone()];
                let part = many(parts, Part::Parallel, |part| match part {
                    Part::Parallel(inner) => Ok(inner),
                    other => Err(other),
                });
                if let Some(one) = &mut self.places[first] {
                    one.part = part;
                }
                self.places[second] = None;
                for one in self.moves.iter_mut().flatten() {
                    one.from.retain(|&place| place != second);
                    one.to.retain(|&place| place != second);
                }
                return true;
            }
        }
        false
    }

    /// A place that one transition leads into, alone, and another out of, alone.
    fn pass(&mut self) -> bool {
        for place in 0..self.places.len() {
            let Some(inner) = self.places[place].as_ref().filter(|one| !one.initial).cloned()
            else {
                continue;
            };
            let (into, out) = self.around(place);
            let (&[into], &[out]) = (&into[..], &out[..]) else { continue };
            let (Some(before), Some(behind)) = (&self.moves[into], &self.moves[out]) else {
                continue;
            };
            if into == out || before.to != [place] || behind.from != [place] {
                continue;
            }
            let part = before.part.clone().then(inner.part).then(behind.part.clone());
            let joined = Move { part, from: before.from.clone(), to: behind.to.clone() };
            self.moves[into] = Some(joined);
            self.moves[out] = None;
            self.places[place] = None;
            return true;
        }
        false
    }

    /// Two places with a transition between them that is the only way out of the one and into the other.
    fn follow(&mut self) -> bool {
        for way in 0..self.moves.len() {
            let Some(one) = &self.moves[way] else { continue };
            let (&[from], &[to]) = (&one.from[..], &one.to[..]) else { continue };
            if from == to || self.around(from).1 != [way] || self.around(to).0 != [way] {
                continue;
            }
            let (Some(first), Some(second)) = (&self.places[from], &self.places[to]) else {
                continue;
            };
            if second.initial {
                continue;
            }
            let part = first.part.clone().then(one.part.clone()).then(second.part.clone());
            if let Some(first) = &mut self.places[from] {
                first.part = part;
            }
            self.places[to] = None;
            self.moves[way] = None;
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

//! Divides a chart into sequences, selections, parallels and loops by reducing its net.
//!
//! Each rule replaces a part of the net by one place or transition and preserves the behaviour. A place between two
//! transitions is merged into one transition; two places with a transition between them become one place. Two
//! transitions between the same places become a selection, two places between the same transitions a parallel, and a
//! transition from a place to itself a loop. A transition into a place that none leaves becomes an exit.
//!
//! If no rule applies and more than one element remains, the chart is not properly nested. Then transitions are treated
//! as jumps, one at a time, until the rest can be reduced: each time the one whose removal leaves the smallest net.

use super::Chart;
use std::collections::BTreeMap;

/// A node of a chart's tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    /// A step, by its index in the chart.
    Step(usize),
    /// A transition, by its index in the chart.
    Transition(usize),
    /// Parts in sequence.
    Sequence(Vec<Part>),
    /// Alternative branches, of which one is executed.
    Selection(Vec<Part>),
    /// Branches that are executed at the same time.
    Parallel(Vec<Part>),
    /// The loop's body, and the part that leads from its end back to its start.
    Loop(Box<Part>, Box<Part>),
    /// A part, and a branch that leaves the nesting from its end: the branch ends in a jump or in a final step.
    Exit(Box<Part>, Box<Part>),
    /// Parts that could not be combined; they are connected only by jumps.
    Tangle(Vec<Part>),
}

/// The tree of a chart and the jumps outside of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outline {
    /// The tree.
    pub part: Part,
    /// The transitions treated as jumps. Those from one step end the exit branches of the tree; those that join several
    /// branches are not in the tree.
    pub jumps: Vec<usize>,
    /// The number of jumps that lead back.
    pub returns: usize,
}

impl Outline {
    /// The numbers of selections, parallels and loops. A jump back counts as a loop.
    #[must_use]
    pub fn count(&self) -> [usize; 3] {
        let [selections, parallels, loops] = self.part.count();
        [selections, parallels, loops + self.returns]
    }

    /// Whether the tree contains a transition.
    #[must_use]
    pub fn has(&self, transition: usize) -> bool {
        self.part.has(transition)
    }
}

impl Part {
    /// The two parts in sequence.
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

    /// The direct child parts.
    fn inner(&self) -> Vec<&Part> {
        match self {
            Part::Step(_) | Part::Transition(_) => Vec::new(),
            Part::Sequence(parts)
            | Part::Selection(parts)
            | Part::Parallel(parts)
            | Part::Tangle(parts) => parts.iter().collect(),
            Part::Loop(body, way) | Part::Exit(body, way) => vec![body, way],
        }
    }

    /// The numbers of selections, parallels and loops in it. Several exits of one part count as one selection.
    fn count(&self) -> [usize; 3] {
        let own = match self {
            Part::Selection(_) => [1, 0, 0],
            Part::Exit(body, _) if !matches!(**body, Part::Exit(..)) => [1, 0, 0],
            Part::Parallel(_) => [0, 1, 0],
            Part::Loop(..) => [0, 0, 1],
            _ => [0, 0, 0],
        };
        // An exit and a selection after it belong to one selection.
        let is_one = |pair: &&[Part]| matches!(pair, [Part::Exit(..), Part::Selection(_)]);
        let twice = match self {
            Part::Sequence(parts) => parts.windows(2).filter(is_one).count(),
            _ => 0,
        };
        let [selections, parallels, loops] = self
            .inner()
            .into_iter()
            .map(Part::count)
            .fold(own, |sum, more| [sum[0] + more[0], sum[1] + more[1], sum[2] + more[2]]);
        [selections - twice, parallels, loops]
    }

    /// The steps in it, in the order of the tree.
    #[must_use]
    pub fn steps(&self) -> Vec<usize> {
        match self {
            Part::Step(step) => vec![*step],
            other => other.inner().into_iter().flat_map(Part::steps).collect(),
        }
    }

    /// The number of steps in exit branches.
    fn outside(&self) -> usize {
        match self {
            Part::Exit(body, way) => body.outside() + way.steps().len(),
            other => other.inner().into_iter().map(Part::outside).sum(),
        }
    }

    /// The transitions at its end; empty if it ends in a step.
    #[must_use]
    pub fn last(&self) -> Vec<usize> {
        match self {
            Part::Transition(one) => vec![*one],
            Part::Sequence(parts) => parts.last().map(Part::last).unwrap_or_default(),
            Part::Selection(parts) => parts.iter().flat_map(Part::last).collect(),
            _ => Vec::new(),
        }
    }

    fn has(&self, transition: usize) -> bool {
        match self {
            Part::Transition(one) => *one == transition,
            other => other.inner().into_iter().any(|part| part.has(transition)),
        }
    }

    /// Collects the last transitions of the parts that lead back in loops.
    fn returning(&self, into: &mut Vec<usize>) {
        if let Part::Loop(_, back) = self {
            into.extend(back.last());
        }
        self.inner().into_iter().for_each(|part| part.returning(into));
    }
}

#[derive(Debug, Clone)]
struct Place {
    part: Part,
    initial: bool,
}

impl Place {
    /// Adds an exit branch.
    fn exit(&mut self, way: Part) {
        let body = std::mem::replace(&mut self.part, Part::Tangle(Vec::new()));
        self.part = Part::Exit(Box::new(body), Box::new(way));
    }
}

#[derive(Debug, Clone)]
struct Move {
    part: Part,
    from: Vec<usize>,
    to: Vec<usize>,
}

#[derive(Clone)]
struct Net {
    places: Vec<Option<Place>>,
    moves: Vec<Option<Move>>,
}

/// Up to this many transitions, each is tried as a jump if the net is not properly nested.
const TRIED: usize = 60;

/// Computes the tree of a chart.
#[must_use]
pub fn structure(chart: &Chart) -> Outline {
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
    net.reduce();
    let mut jumps = Vec::new();
    let levels = levels(chart);
    while let Some((next, more)) = net.broken(&levels) {
        net = next;
        jumps.extend(more);
    }
    let mut rest: Vec<Part> = net.places.into_iter().flatten().map(|place| place.part).collect();
    let part = if rest.len() == 1 { rest.remove(0) } else { Part::Tangle(rest) };
    jumps.sort_unstable();
    let returns = returns(chart, &part, &jumps);
    Outline { part, jumps, returns }
}

/// The distance of each step from the initial steps, in transitions; `usize::MAX` if unreachable.
fn levels(chart: &Chart) -> Vec<usize> {
    let mut levels = vec![usize::MAX; chart.steps.len()];
    let mut open = chart.initial();
    open.iter().for_each(|&step| levels[step] = 0);
    let mut at = 0;
    while at < open.len() {
        let step = open[at];
        at += 1;
        for one in chart.transitions.iter().filter(|one| one.from.contains(&step)) {
            for &behind in &one.to {
                if levels[behind] == usize::MAX {
                    levels[behind] = levels[step] + 1;
                    open.push(behind);
                }
            }
        }
    }
    levels
}

/// The number of jumps that lead back: their source can be reached from their target without using a jump or a loop's
/// way back.
fn returns(chart: &Chart, part: &Part, jumps: &[usize]) -> usize {
    let mut back = jumps.to_vec();
    part.returning(&mut back);
    let leads_back = |jump: &&usize| {
        let one = &chart.transitions[**jump];
        let mut seen = one.to.clone();
        let mut at = 0;
        while at < seen.len() {
            let step = seen[at];
            at += 1;
            for (way, next) in chart.transitions.iter().enumerate() {
                if next.from.contains(&step) && !back.contains(&way) {
                    let new: Vec<usize> =
                        next.to.iter().filter(|step| !seen.contains(step)).copied().collect();
                    seen.extend(new);
                }
            }
        }
        one.from.iter().any(|step| seen.contains(step))
    };
    jumps.iter().filter(leads_back).count()
}

/// The transitions into a place, and those out of it.
type Around = (Vec<usize>, Vec<usize>);

/// Takes a part out and leaves an empty sequence.
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
    /// Applies the rules until none applies.
    fn reduce(&mut self) {
        while self.select()
            || self.parallel()
            || self.pass()
            || self.follow()
            || self.turn()
            || self.end()
        {}
    }

    /// The number of steps in exit branches.
    fn outside(&self) -> usize {
        let places = self.places.iter().flatten().map(|place| place.part.outside());
        let moves = self.moves.iter().flatten().map(|one| one.part.outside());
        places.chain(moves).sum()
    }

    /// The number of places and transitions that remain.
    fn size(&self) -> usize {
        self.places.iter().flatten().count() + self.moves.iter().flatten().count()
    }

    /// The net after one transition has been made a jump, and the transitions of that jump: the choice that leaves the
    /// smallest net. `None` if no transition is left.
    fn broken(&self, levels: &[usize]) -> Option<(Net, Vec<usize>)> {
        let left = self.moves.iter().enumerate();
        let left = left.filter_map(|(at, one)| one.as_ref().map(|one| (at, one)));
        // Places added after a join that became a jump have no distance.
        let level = |place: &usize| levels.get(*place).copied().unwrap_or(usize::MAX);
        let is_back =
            |one: &Move| one.to.iter().map(level).max() <= one.from.iter().map(level).min();
        let mut ways: Vec<(bool, usize)> = left.map(|(at, one)| (!is_back(one), at)).collect();
        ways.sort_unstable();
        // If there are too many candidates, some become jumps without being tried.
        if ways.len() > TRIED {
            ways.truncate((ways.len() - TRIED).div_ceil(4));
            let mut jumps = Vec::new();
            let mut net = self.clone();
            for (_, at) in ways {
                jumps.extend(net.drop_way(at));
            }
            net.reduce();
            return Some((net, jumps));
        }
        let all = ways.into_iter().map(|(_, at)| {
            let mut net = self.clone();
            let jumps = net.drop_way(at);
            net.reduce();
            (net, jumps)
        });
        all.min_by_key(|(net, jumps)| (net.size(), net.outside(), jumps.len()))
    }

    /// Makes a transition of the net a jump; the chart's transitions that jump.
    fn drop_way(&mut self, way: usize) -> Vec<usize> {
        let Some(one) = self.moves[way].take() else { return Vec::new() };
        let jumps = one.part.last();
        match (&one.from[..], one.part) {
            (&[from], part) => {
                if let Some(place) = &mut self.places[from] {
                    place.exit(part);
                }
            }
            // The part after a join stays as a place with an exit.
            (_, Part::Sequence(mut parts)) if parts.len() > 2 => {
                let last = parts.pop();
                let first = parts.remove(0);
                let rest = if parts.len() == 1 { parts.remove(0) } else { Part::Sequence(parts) };
                let mut behind = Place { part: rest, initial: false };
                last.into_iter().for_each(|way| behind.exit(way));
                self.places.push(Some(behind));
                let to = vec![self.places.len() - 1];
                self.moves[way] = Some(Move { part: first, from: one.from, to });
            }
            _ => {}
        }
        jumps
    }

    /// For each place, the transitions into and out of it.
    fn around(&self) -> Vec<Around> {
        let mut around = vec![Around::default(); self.places.len()];
        for (at, one) in self.moves.iter().enumerate() {
            let Some(one) = one else { continue };
            one.to.iter().for_each(|&place| around[place].0.push(at));
            one.from.iter().for_each(|&place| around[place].1.push(at));
        }
        around
    }

    /// Merges transitions between the same places into selections.
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

    /// Merges places between the same transitions into parallels.
    fn parallel(&mut self) -> bool {
        let around = self.around();
        let mut known: BTreeMap<(&Around, bool), usize> = BTreeMap::new();
        let mut changed = false;
        for (at, own) in around.iter().enumerate() {
            let Some(one) = &self.places[at] else { continue };
            if own.0.is_empty() && own.1.is_empty() {
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

    /// Merges a place into one transition if it is the only output of a single transition and the only input of
    /// another.
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

    /// Merges two places if the transition between them is the only one out of the first and into the second.
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

    /// Turns a transition from a place to itself into a loop.
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

    /// Turns single transitions into final places into exits.
    fn end(&mut self) -> bool {
        let mut into: Vec<Vec<usize>> = vec![Vec::new(); self.places.len()];
        let mut leads_on = vec![false; self.places.len()];
        for (at, one) in self.moves.iter().enumerate() {
            for one in one.iter() {
                one.to.iter().for_each(|&place| into[place].push(at));
                one.from.iter().for_each(|&place| leads_on[place] = true);
            }
        }
        let mut ended = false;
        for place in 0..self.places.len() {
            let is_end =
                !leads_on[place] && self.places[place].as_ref().is_some_and(|one| !one.initial);
            let &[way] = &into[place][..] else { continue };
            let is_single = self.moves[way]
                .as_ref()
                .is_some_and(|one| one.from.len() == 1 && one.to.len() == 1);
            if !is_end || !is_single {
                continue;
            }
            let (Some(last), Some(one)) = (self.places[place].take(), self.moves[way].take())
            else {
                continue;
            };
            if let Some(before) = self.places[one.from[0]].as_mut() {
                before.exit(one.part.then(last.part));
            }
            ended = true;
        }
        ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Body;
    use crate::parse::file;

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
            Part::Exit(body, way) => {
                format!("<{}>", all(&[(**body).clone(), (**way).clone()], " / "))
            }
            Part::Tangle(parts) => format!("?{}?", all(parts, ", ")),
        }
    }

    fn of(steps: &str, ways: &[(&str, &str)]) -> String {
        let chart = chart(steps, ways);
        let outline = structure(&chart);
        let jumps = outline.jumps.iter().map(|&at| chart.transition_name(at));
        jumps.fold(told(&chart, &outline.part), |text, jump| text + "; " + &jump)
    }

    fn chart(steps: &str, ways: &[(&str, &str)]) -> Chart {
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
        let Body::Chart(chart) = project.pous[0].body.clone() else { panic!("a chart") };
        *chart
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
    fn ways_that_do_not_nest_are_jumps() {
        // A way out of one branch of a parallel.
        let ways = [("a", "(b, c)"), ("b", "d"), ("(b, c)", "a"), ("d", "a")];
        assert_eq!(of("a b c d", &ways), "{a ^ [<b / d> & c]}; d -> a");
        // From one branch of a selection into another.
        let ways =
            [("a", "b"), ("a", "c"), ("b", "d"), ("c", "e"), ("d", "f"), ("e", "f"), ("f", "a")];
        assert_eq!(of("a b c d e f", &ways), "{a ^ (b d | c e) f}");
        let across = [&ways[..], &[("b", "e")]].concat();
        let text = of("a b c d e f", &across);
        assert!(text.ends_with("; b -> e") && !text.contains('?'), "{text}");
        assert_eq!(structure(&chart("a b c d e f", &across)).count(), [2, 0, 1]);
        // A join of steps that stand in different branches, in one of them in the midst: it leads back.
        let ways = [("a", "(b, c)"), ("c", "d"), ("(b, d)", "a"), ("(b, c)", "a")];
        assert_eq!(of("a b c d", &ways), "{a ^ [b & c d]}; b, c -> a");
        assert_eq!(structure(&chart("a b c d", &ways)).count(), [0, 1, 2]);
    }

    #[test]
    fn charts_that_end_nest() {
        assert_eq!(of("a b c", &[("a", "b"), ("a", "c")]), "<<a / b> / c>");
        assert_eq!(of("a b c", &[("a", "(b, c)"), ("b", "b"), ("c", "c")]), "a [{b} & {c}]");
        // A step that nothing leads to stands by itself, with the way out of it.
        assert_eq!(of("a b c", &[("a", "b"), ("b", "a"), ("c", "a")]), "?{a ^ b}, <c>?; c -> a");
    }
}

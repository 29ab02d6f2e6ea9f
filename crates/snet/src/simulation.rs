//! A net that goes on in time: by its own rule a transition fires each step, by its code's all that can do so in a scan.

use super::rules::{Rules, State};
use super::{Diagram, Kind};

/// By which rule a net goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// One transition after another.
    Net,
    /// All that can fire when a scan begins.
    Code,
}

/// What happened in a step.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Happened {
    /// Timers whose time was over, indices into `Diagram::places`.
    pub run_out: Vec<usize>,
    /// Transitions that fired.
    pub fired: Vec<usize>,
}

impl Happened {
    /// Whether nothing did.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.run_out.is_empty() && self.fired.is_empty()
    }
}

/// A moment of a simulation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Moment {
    /// Milliseconds since it began.
    pub ms: u64,
    /// The state of the net.
    pub state: State,
    /// The outer gates.
    pub outers: Vec<bool>,
    /// Since when each timer runs; by place.
    since: Vec<Option<u64>>,
    /// What fired last.
    pub fired: Vec<usize>,
}

/// A net and its moments up to now.
pub struct Simulation<'a> {
    diagram: &'a Diagram,
    rules: Rules,
    rule: Rule,
    /// How long a firing, or a scan, takes.
    step_ms: u64,
    now: Moment,
    past: Vec<Moment>,
}

/// So many moments can be gone back.
const MOST_PAST: usize = 100_000;

impl<'a> Simulation<'a> {
    /// A net at its beginning, with its initial marks or without. All outer gates are off.
    #[must_use]
    pub fn new(diagram: &'a Diagram, rule: Rule, is_marked: bool, step_ms: u64) -> Simulation<'a> {
        let rules = Rules::new(diagram);
        let state = if is_marked { rules.initial() } else { rules.empty() };
        let outers = vec![false; diagram.outers.len()];
        let since = vec![None; diagram.places.len()];
        let now = Moment { ms: 0, state, outers, since, fired: Vec::new() };
        let step_ms = step_ms.max(1);
        let mut found = Simulation { diagram, rules, rule, step_ms, now, past: Vec::new() };
        found.note_timers();
        found
    }

    /// The net.
    #[must_use]
    pub fn diagram(&self) -> &'a Diagram {
        self.diagram
    }

    /// Its rules.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// The moment that it has come to.
    #[must_use]
    pub fn now(&self) -> &Moment {
        &self.now
    }

    /// Sets an outer gate.
    pub fn set(&mut self, outer: usize, on: bool) {
        self.now.outers[outer] = on;
    }

    /// Keeps the present moment, to be gone back to.
    pub fn keep(&mut self) {
        if self.past.len() == MOST_PAST {
            self.past.remove(0);
        }
        self.past.push(self.now.clone());
    }

    /// Goes back to the moment kept last; false if there is none.
    pub fn back(&mut self) -> bool {
        match self.past.pop() {
            Some(moment) => {
                self.now = moment;
                true
            }
            None => false,
        }
    }

    /// The transitions that can fire now.
    #[must_use]
    pub fn firable(&self) -> Vec<usize> {
        let (state, outers) = (&self.now.state, &self.now.outers);
        match self.rule {
            Rule::Net => (0..self.rules.transitions())
                .filter(|&at| self.rules.can_fire(state, at, outers))
                .collect(),
            Rule::Code => self.rules.fired(state, outers),
        }
    }

    /// Makes a step: timers whose time has come run out; then `choose` picks which of the transitions that can fire does,
    /// or, by the code's rule, all do.
    pub fn step(&mut self, choose: impl FnOnce(&[usize]) -> usize) -> Happened {
        let run_out = self.run_out();
        let firable = self.firable();
        let fired = match (self.rule, firable.is_empty()) {
            (Rule::Net, true) => Vec::new(),
            (Rule::Net, false) => vec![firable[choose(&firable).min(firable.len() - 1)]],
            (Rule::Code, _) => firable,
        };
        match self.rule {
            Rule::Net => {
                for &at in &fired {
                    self.now.state = self.rules.fire(&self.now.state, at);
                }
            }
            Rule::Code => self.now.state = self.rules.scan(&self.now.state, &fired),
        }
        self.now.fired.clone_from(&fired);
        self.now.ms += self.step_ms;
        self.note_timers();
        Happened { run_out, fired }
    }

    /// Lets the time of timers be over for which it has come.
    fn run_out(&mut self) -> Vec<usize> {
        let mut found = Vec::new();
        for at in 0..self.diagram.places.len() {
            if self.due(at).is_some_and(|due| due <= self.now.ms) {
                self.now.state = self.rules.run_out(&self.now.state, at);
                found.push(at);
            }
        }
        self.note_timers();
        found
    }

    /// When a timer that runs will be over.
    fn due(&self, place: usize) -> Option<u64> {
        let Kind::Timer { tenths, .. } = self.diagram.places[place].kind else { return None };
        Some(self.now.since[place]? + 100 * u64::from(tenths))
    }

    /// When the next timer will be over.
    #[must_use]
    pub fn next_due(&self) -> Option<u64> {
        (0..self.diagram.places.len()).filter_map(|place| self.due(place)).min()
    }

    /// Lets time go by without a step, to the first step at or behind a time.
    pub fn wait_until(&mut self, ms: u64) {
        let steps = ms.saturating_sub(self.now.ms).div_ceil(self.step_ms);
        self.now.ms += steps * self.step_ms;
        if steps > 0 {
            self.now.fired.clear();
        }
    }

    /// Since when timers run.
    fn note_timers(&mut self) {
        for at in 0..self.diagram.places.len() {
            let runs = self.rules.is_running(&self.now.state, at);
            let since = &mut self.now.since[at];
            *since = if runs { since.or(Some(self.now.ms)) } else { None };
        }
    }

    /// How long a timer has been running, in tenths of a second: all its time once that is over.
    #[must_use]
    pub fn elapsed(&self, place: usize) -> u16 {
        let Kind::Timer { tenths, .. } = self.diagram.places[place].kind else { return 0 };
        if self.rules.is_over(&self.now.state, place) {
            return tenths;
        }
        let ran = self.now.since[place].map_or(0, |since| (self.now.ms - since) / 100);
        u16::try_from(ran).unwrap_or(u16::MAX).min(tenths)
    }

    /// Whether no transition can ever fire again, whatever outer gates do and after all timers.
    #[must_use]
    pub fn is_dead(&self) -> bool {
        is_dead(&self.rules, &self.now.state, self.diagram.places.len())
    }
}

/// Whether no transition can fire from here, whatever outer gates do and whichever timers run out.
fn is_dead(rules: &Rules, state: &State, places: usize) -> bool {
    let can =
        |state: &State| (0..rules.transitions()).any(|at| rules.gates_to_fire(state, at).is_some());
    let running: Vec<usize> = (0..places).filter(|&at| rules.is_running(state, at)).collect();
    // A timer that is over may hold back what it did not before: each set of those that are over counts.
    let mut open = vec![(state.clone(), 0)];
    let mut left = 1 << 16;
    while let Some((state, from)) = open.pop() {
        if can(&state) || left == 0 {
            return false;
        }
        left -= 1;
        for (next, &place) in running.iter().enumerate().skip(from) {
            open.push((rules.run_out(&state, place), next + 1));
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::read;

    fn first(_: &[usize]) -> usize {
        0
    }

    #[test]
    fn timers_run_while_their_box_is_marked() {
        let text = "outer GO\nbox A marked\ntimer W 0.5s\nbox B\ntransition T : A -> W if GO\n\
                    transition U : W -> B\n";
        let diagram = read("a.snet", text).expect("a net");
        let mut net = Simulation::new(&diagram, Rule::Net, true, 10);
        assert!(net.step(first).is_nothing() && net.next_due().is_none() && !net.is_dead());
        net.set(0, true);
        assert_eq!(net.step(first).fired, [0]);
        assert_eq!((net.next_due(), net.elapsed(1)), (Some(520), 0));
        net.wait_until(300);
        assert_eq!(net.elapsed(1), 2);
        assert!(net.step(first).is_nothing());
        net.keep();
        net.wait_until(520);
        let happened = net.step(first);
        assert_eq!((happened.run_out, happened.fired), (vec![1], vec![1]));
        assert!(net.is_dead(), "nothing leads out of B");
        assert!(net.back() && net.now().ms == 310 && !net.is_dead());
        assert!(!net.back());
    }

    #[test]
    fn the_code_fires_all_at_once_and_begins_without_marks() {
        let text = "box A marked\nbox B\nbox C\ntransition T : A -> B\ntransition U : A -> C\n";
        let diagram = read("a.snet", text).expect("a net");
        let mut net = Simulation::new(&diagram, Rule::Net, true, 10);
        assert_eq!(net.step(|firable| firable.len() - 1).fired, [1]);
        assert!(net.is_dead());
        let mut code = Simulation::new(&diagram, Rule::Code, true, 10);
        assert_eq!(code.step(first).fired, [0, 1]);
        assert!(
            code.rules().is_marked(&code.now().state, 1)
                && code.rules().is_marked(&code.now().state, 2)
        );
        assert!(Simulation::new(&diagram, Rule::Code, false, 10).is_dead(), "the mark is left out");
    }

    #[test]
    fn a_timer_that_inhibits_when_it_is_over_does_not_make_a_deadlock_before() {
        let text = "timer W 1.0s marked\nbox X marked\nbox Y\nbox Z\ntransition T : X -> Y if not W\n\
                    transition U : W Z ->\n";
        let diagram = read("a.snet", text).expect("a net");
        let net = Simulation::new(&diagram, Rule::Net, true, 10);
        assert!(!net.is_dead());
        let mut late = Simulation::new(&diagram, Rule::Net, true, 10);
        late.wait_until(1000);
        assert_eq!(late.step(first).run_out, [0]);
        assert!(late.is_dead());
    }
}

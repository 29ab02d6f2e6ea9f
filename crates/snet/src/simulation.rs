//! Simulates a net in time. By the net's rule one transition fires in each step; by the code's rule all that can fire
//! in a scan do.

use super::rules::{Rules, State};
use super::{Diagram, Kind};

/// The firing rule of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// The net's rule: one transition at a time.
    Net,
    /// The code's rule: all transitions that can fire when a scan begins.
    Code,
}

/// What happened in a step.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Happened {
    /// Timers that timed out (indices into `Diagram::places`).
    pub run_out: Vec<usize>,
    /// Transitions that fired.
    pub fired: Vec<usize>,
}

impl Happened {
    /// Whether nothing happened.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.run_out.is_empty() && self.fired.is_empty()
    }
}

/// The state of a simulation at one time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Moment {
    /// Milliseconds since the start.
    pub ms: u64,
    /// The state of the net.
    pub state: State,
    /// The values of the outer gates.
    pub outers: Vec<bool>,
    /// For each place, the time at which its timer started.
    since: Vec<Option<u64>>,
    /// The transitions that fired last.
    pub fired: Vec<usize>,
}

/// A net with its simulation history.
pub struct Simulation<'a> {
    diagram: &'a Diagram,
    rules: Rules,
    rule: Rule,
    /// The duration of a firing or scan.
    step_ms: u64,
    now: Moment,
    past: Vec<Moment>,
}

/// The largest number of moments in the history.
const MAX_HISTORY: usize = 100_000;

impl<'a> Simulation<'a> {
    /// Starts a simulation, with the initial marks or without marks. All outer gates are off.
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

    /// The current moment.
    #[must_use]
    pub fn now(&self) -> &Moment {
        &self.now
    }

    /// Sets an outer gate.
    pub fn set(&mut self, outer: usize, on: bool) {
        self.now.outers[outer] = on;
    }

    /// Saves the current moment in the history.
    pub fn keep(&mut self) {
        if self.past.len() == MAX_HISTORY {
            self.past.remove(0);
        }
        self.past.push(self.now.clone());
    }

    /// Returns to the moment that was saved last; false if there is none.
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

    /// Makes one step: due timers time out, then `choose` selects one of the transitions that can fire (by the code's
    /// rule all fire).
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

    /// Lets all due timers time out.
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

    /// The time at which a running timer times out.
    fn due(&self, place: usize) -> Option<u64> {
        let Kind::Timer { tenths, .. } = self.diagram.places[place].kind else { return None };
        Some(self.now.since[place]? + 100 * u64::from(tenths))
    }

    /// The next time at which a timer times out.
    #[must_use]
    pub fn next_due(&self) -> Option<u64> {
        (0..self.diagram.places.len()).filter_map(|place| self.due(place)).min()
    }

    /// Advances the time without a step, to the first step time at or after `ms`.
    pub fn wait_until(&mut self, ms: u64) {
        let steps = ms.saturating_sub(self.now.ms).div_ceil(self.step_ms);
        self.now.ms += steps * self.step_ms;
        if steps > 0 {
            self.now.fired.clear();
        }
    }

    /// Updates the start times of the timers.
    fn note_timers(&mut self) {
        for at in 0..self.diagram.places.len() {
            let runs = self.rules.is_running(&self.now.state, at);
            let since = &mut self.now.since[at];
            *since = if runs { since.or(Some(self.now.ms)) } else { None };
        }
    }

    /// The elapsed time of a timer in tenths of a second; its whole set value after it timed out.
    #[must_use]
    pub fn elapsed(&self, place: usize) -> u16 {
        let Kind::Timer { tenths, .. } = self.diagram.places[place].kind else { return 0 };
        if self.rules.is_over(&self.now.state, place) {
            return tenths;
        }
        let ran = self.now.since[place].map_or(0, |since| (self.now.ms - since) / 100);
        u16::try_from(ran).unwrap_or(u16::MAX).min(tenths)
    }

    /// Whether no transition can ever fire again, for any outer gates and after all timers.
    #[must_use]
    pub fn is_dead(&self) -> bool {
        is_dead(&self.rules, &self.now.state, self.diagram.places.len())
    }
}

/// Whether no transition can fire from here, for any outer gates and after any set of timers timed out.
fn is_dead(rules: &Rules, state: &State, places: usize) -> bool {
    let can =
        |state: &State| (0..rules.transitions()).any(|at| rules.gates_to_fire(state, at).is_some());
    let running: Vec<usize> = (0..places).filter(|&at| rules.is_running(state, at)).collect();
    // A timed-out timer may inhibit a transition, so each set of timed-out timers is examined.
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

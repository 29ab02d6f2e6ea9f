//! What a study of an S-net found, in words, with the runs that show it.

pub mod json;
pub mod text;

use scanbound_snet::check::{Cause, Check, Dead, Divergence, Start, Step, marking};
use scanbound_snet::rules::Rules;
use scanbound_snet::{Diagram, Kind};

/// A net and what was found of it.
#[derive(Debug)]
pub struct Study<'a> {
    /// The net.
    pub diagram: &'a Diagram,
    /// What was found.
    pub check: &'a Check,
}

/// Something to look at.
#[derive(Debug)]
struct NetFinding {
    /// A short name that stays the same.
    kind: &'static str,
    /// Whether it makes the net unsound.
    is_error: bool,
    /// The line of what it is about.
    line: u32,
    message: String,
    help: &'static str,
    /// How the run begins, and its steps; none where there is nothing to run.
    run: Option<(&'static str, Vec<String>)>,
}

impl Study<'_> {
    fn place(&self, at: usize) -> String {
        self.diagram.place_name(at)
    }

    fn transition(&self, at: usize) -> String {
        self.diagram.transition_name(at)
    }

    /// A transition with the values that its outer gates need.
    fn firing(&self, at: usize) -> String {
        let gates = self.diagram.gates_of(at).filter_map(|gate| match gate.signal {
            scanbound_snet::Signal::Outer(outer) => {
                let value = if gate.is_inhibiting { "off" } else { "on" };
                Some(format!("{} {value}", self.diagram.outers[outer].head.name))
            }
            scanbound_snet::Signal::Place(_) => None,
        });
        let gates: Vec<String> = gates.collect();
        let gates =
            if gates.is_empty() { String::new() } else { format!(" ({})", gates.join(", ")) };
        self.transition(at) + &gates
    }

    fn step(&self, step: &Step) -> String {
        match step {
            Step::Fire(at) => self.firing(*at),
            Step::RunOut(place) => format!("{} runs out", self.place(*place)),
            Step::Scan(fired) if fired.is_empty() => "a scan in which nothing fires".to_owned(),
            Step::Scan(fired) => {
                let all: Vec<String> = fired.iter().map(|&at| self.firing(at)).collect();
                format!("scan: {}", all.join(" and "))
            }
        }
    }

    fn run(&self, start: &'static str, run: &[Step]) -> Option<(&'static str, Vec<String>)> {
        Some((start, run.iter().map(|step| self.step(step)).collect()))
    }

    fn transition_line(&self, at: usize) -> u32 {
        self.diagram.transitions[at].head.line
    }

    fn place_line(&self, at: usize) -> u32 {
        self.diagram.places[at].head.line
    }

    /// All that is to look at, the gravest first.
    fn found(&self) -> Vec<NetFinding> {
        let mut all: Vec<NetFinding> =
            self.check.markings.dead.iter().map(|one| self.dead(one)).collect();
        all.extend(self.check.code.divergences.iter().map(|one| self.divergence(one)));
        for cause in &self.check.code.undecided {
            let (kind, line, message, help) = self.cause(cause);
            let message = format!("not excluded, and not found either: {message}");
            all.push(NetFinding { kind, is_error: true, line, message, help, run: None });
        }
        all.extend(self.check.markings.never.iter().map(|&at| NetFinding {
            kind: "never-fires",
            is_error: true,
            line: self.transition_line(at),
            message: format!("{} can never fire, whatever the outer gates", self.transition(at)),
            help: "see which of its boxes are never marked together, or marked all the time",
            run: None,
        }));
        all.extend(self.left_out());
        all.extend(self.check.code.arbiters.iter().map(|&at| NetFinding {
            kind: "arbiter-left-out",
            is_error: false,
            line: self.diagram.arbiters[at].head.line,
            message: format!(
                "the code leaves the arbiter {} out",
                self.diagram.arbiters[at].head.name
            ),
            help: "let an inhibiting gate at each of its transitions say which goes first",
            run: None,
        }));
        all.extend(self.check.markings.held.iter().map(|held| NetFinding {
            kind: "held-back",
            is_error: false,
            line: self.place_line(held.place),
            message: format!(
                "{} would get a second mark from {}, if its one mark did not hold that back",
                self.place(held.place),
                self.transition(held.transition)
            ),
            help: "as a Petri net without capacities the net is not safe; boxes hold one mark, so this is no fault by itself",
            run: self.run("from the initial marks", &held.run),
        }));
        all.sort_by_key(|one| !one.is_error);
        all
    }

    fn dead(&self, dead: &Dead) -> NetFinding {
        let rules = Rules::new(self.diagram);
        let marked = marking(self.diagram, &rules, &dead.state);
        let what =
            if dead.but_stop { "only an emergency stop can fire" } else { "nothing can ever fire" };
        let behind = if dead.is_after_stop { ", behind an emergency stop" } else { "" };
        NetFinding {
            kind: if dead.is_after_stop {
                "dead-after-stop"
            } else if dead.but_stop {
                "deadlock-but-stop"
            } else {
                "deadlock"
            },
            is_error: !dead.is_after_stop,
            line: self.diagram.pages[0].line,
            message: format!("deadlock{behind}: with {marked} marked, {what}"),
            help: if dead.is_after_stop {
                "give the net a transition that puts the first marks in again, by a gate of its own"
            } else {
                "follow the run: what its last firing takes, somebody waits for"
            },
            run: self.run("from the initial marks", &dead.run),
        }
    }

    fn divergence(&self, divergence: &Divergence) -> NetFinding {
        let (kind, line, message, help) = self.cause(&divergence.cause);
        let start = match divergence.start {
            Start::Empty => "the code begins without marks",
            Start::Initial => "the code begins with the initial marks",
        };
        NetFinding {
            kind,
            is_error: true,
            line,
            message,
            help,
            run: self.run(start, &divergence.run),
        }
    }

    fn cause(&self, cause: &Cause) -> (&'static str, u32, String, &'static str) {
        match cause {
            Cause::TakenTwice(place, one, other) => (
                "taken-twice",
                self.place_line(*place),
                format!(
                    "{} and {} take the one mark of {} in one scan: marks are doubled",
                    self.transition(*one),
                    self.transition(*other),
                    self.place(*place)
                ),
                "give one of them an inhibiting gate for what lets the other fire",
            ),
            Cause::FilledTwice(place, one, other) => (
                "filled-twice",
                self.place_line(*place),
                format!(
                    "{} and {} both fill {} in one scan: a mark is lost",
                    self.transition(*one),
                    self.transition(*other),
                    self.place(*place)
                ),
                "give one of them an inhibiting gate for what lets the other fire",
            ),
            Cause::Escapes(stop, transition, place) => (
                "escapes-stop",
                self.transition_line(*stop),
                format!(
                    "{} takes the mark of {} in the scan in which {} stops it: the mark escapes",
                    self.transition(*transition),
                    self.place(*place),
                    self.transition(*stop)
                ),
                "give that transition the emergency stop's gate as an inhibiting one",
            ),
            Cause::CountedOnce(transition, counter) => (
                "counted-once",
                self.transition_line(*transition),
                format!(
                    "{} fires in scan after scan, and {} counts only when its relay comes on",
                    self.transition(*transition),
                    self.place(*counter)
                ),
                "put a box in front of the transition, so that its relay falls between two firings",
            ),
            Cause::Circle(transitions) => {
                let names: Vec<String> =
                    transitions.iter().map(|&at| self.transition(at)).collect();
                let line = transitions.first().map_or(1, |&at| self.transition_line(at));
                (
                    "no-order",
                    line,
                    format!(
                        "{} fire in one scan, and in no order could they do so one after another",
                        names.join(", ")
                    ),
                    "see which of them changes what another's gates look at",
                )
            }
        }
    }

    fn left_out(&self) -> Option<NetFinding> {
        let code = &self.check.code;
        let first = *code.is_left_out.first()?;
        let names: Vec<String> = code.is_left_out.iter().map(|&at| self.place(at)).collect();
        let dead = if code.starts_dead { ", and so never does anything" } else { "" };
        Some(NetFinding {
            kind: if code.starts_dead { "starts-dead" } else { "marks-left-out" },
            is_error: true,
            line: self.place_line(first),
            message: format!("the code begins without the marks of {}{dead}", names.join(", ")),
            help: "--initial first-scan puts them in when the PLC starts; or give the net a transition that does",
            run: None,
        })
    }

    /// What the net has, in words.
    fn contents(&self) -> String {
        let count =
            |is: fn(Kind) -> bool| self.diagram.places.iter().filter(|p| is(p.kind)).count();
        let stops = self.diagram.transitions.iter().filter(|one| one.is_stop).count();
        let parts = [
            (count(|kind| kind == Kind::Box), "box", "boxes"),
            (count(|kind| matches!(kind, Kind::Timer { .. })), "timer", "timers"),
            (count(|kind| matches!(kind, Kind::Counter { .. })), "counter", "counters"),
            (self.diagram.transitions.len() - stops, "transition", "transitions"),
            (stops, "emergency stop", "emergency stops"),
            (self.diagram.outers.len(), "outer gate", "outer gates"),
            (self.diagram.arbiters.len(), "arbiter", "arbiters"),
        ];
        let told = parts.into_iter().filter(|(count, ..)| *count > 0);
        let told = told
            .map(|(count, one, many)| format!("{count} {}", if count == 1 { one } else { many }));
        told.collect::<Vec<_>>().join(", ")
    }

    /// A sum of weighted names.
    fn sum(&self, weights: &[(usize, i64)], name: impl Fn(usize) -> String) -> String {
        let one = |&(at, weight): &(usize, i64)| {
            if weight == 1 { name(at) } else { format!("{weight} {}", name(at)) }
        };
        weights.iter().map(one).collect::<Vec<_>>().join(" + ")
    }
}

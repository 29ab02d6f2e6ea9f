//! Random S-nets, and a second implementation of the net's rule, written from docs/snet.md only.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng as _;
use scanbound::snet::{Diagram, Direction, Kind, Signal};
use std::fmt::Write as _;

/// Random numbers.
pub struct Random(Pcg64Mcg);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(Pcg64Mcg::new(u128::from(seed) << 1 | 0xcafe_f00d))
    }

    pub fn below(&mut self, limit: usize) -> usize {
        (self.0.next_u64() % limit as u64) as usize
    }

    pub fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }
}

/// A net of at most this many boxes, as text, with addresses.
pub fn random_net(random: &mut Random, most: usize) -> String {
    let boxes = 1 + random.below(most);
    let transitions = 1 + random.below(most);
    let timers = random.below(3).min(transitions);
    let counters = random.below(2).min(transitions);
    let mut text = String::from("outer E0 = 00000\nouter E1 = 00001\nouter E2 = 00002\n");
    let mut takes = vec![Vec::new(); transitions];
    let mut puts = vec![Vec::new(); transitions];
    for n in 0..boxes {
        let marked = if random.one_in(3) { " marked" } else { "" };
        let _ = writeln!(text, "box B{n}{marked} = {:05}", 300 + n);
        takes[random.below(transitions)].push(format!("B{n}"));
        puts[random.below(transitions)].push(format!("B{n}"));
    }
    for n in 0..timers {
        let _ = writeln!(text, "timer TM{n} 0.3s = {:05} TIM {n}", 500 + n);
        takes[random.below(transitions)].push(format!("TM{n}"));
        puts[random.below(transitions)].push(format!("TM{n}"));
    }
    for n in 0..counters {
        let _ =
            writeln!(text, "counter CN{n} {} = {:05} CNT {}", 1 + random.below(3), 600 + n, 10 + n);
        takes[random.below(transitions)].push(format!("CN{n}"));
        puts[random.below(transitions)].push(format!("CN{n}"));
    }
    let all: Vec<String> = (0..boxes)
        .map(|n| format!("B{n}"))
        .chain((0..timers).map(|n| format!("TM{n}")))
        .chain((0..counters).map(|n| format!("CN{n}")))
        .collect();
    for n in 0..random.below(2) {
        let stopped: Vec<&str> =
            all.iter().filter(|_| random.one_in(2)).map(String::as_str).collect();
        let _ = writeln!(text, "stop X{n} = {:05} : {} *-> if E2", 710 + n, stopped.join(" "));
    }
    for n in 0..transitions {
        for _ in 0..random.below(2) {
            let one = all[random.below(boxes)].clone();
            let side = if random.one_in(2) { &mut takes[n] } else { &mut puts[n] };
            if !side.contains(&one) {
                side.push(one);
            }
        }
        let mut gates = String::new();
        for _ in 0..random.below(3) {
            let not = if random.one_in(2) { " not" } else { "" };
            let name = if random.one_in(3) {
                all[random.below(all.len())].clone()
            } else {
                format!("E{}", random.below(3))
            };
            let _ = write!(gates, "{} {not} {name}", if gates.is_empty() { " if" } else { "" });
        }
        let (takes, puts) = (takes[n].join(" "), puts[n].join(" "));
        let _ = writeln!(text, "transition T{n} = {:05} : {takes} -> {puts}{gates}", 400 + n);
    }
    if transitions > 1 && random.one_in(4) {
        text += "arbiter A0 : T0 T1\n";
    }
    text
}

/// A ring of boxes with some marks, as text, sometimes with a timer, a stop or a short cut.
pub fn ring_net(random: &mut Random) -> String {
    let boxes = 2 + random.below(4);
    let marked = 1 + random.below(boxes);
    let mut source = "outer E0 = 00000\nouter E1 = 00001\nouter E2 = 00002\n".to_owned();
    let timer = random.below(3 * boxes);
    for n in 0..boxes {
        let (kind, more) = if n == timer { ("timer", "0.5s ") } else { ("box", "") };
        let number = if n == timer { "TIM 0" } else { "" };
        let mark = if n < marked { "marked " } else { "" };
        source += &format!("{kind} B{n} {more}{mark}= {:05} {number}\n", 300 + n);
    }
    let gate = |random: &mut Random| match random.below(3) {
        0 => String::new(),
        1 => format!(" if E{}", random.below(3)),
        _ => format!(" if not E{}", random.below(3)),
    };
    for n in 0..boxes {
        let next = (n + 1) % boxes;
        let gate = gate(random);
        source += &format!("transition T{n} = {:05} : B{n} -> B{next}{gate}\n", 400 + n);
    }
    if random.one_in(5) && boxes != timer + 1 {
        let (from, to) = (boxes - 1, random.below(boxes - 1));
        source += &format!("transition S = 00414 : B{from} -> B{to} if E0\n");
    }
    if random.one_in(5) {
        source += &format!("stop X = 00415 : B0 B{} *-> if E2\n", 1 + random.below(boxes - 1));
    }
    source
}

/// A state of a net.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Plain {
    /// For each place: its mark; for a counter, whether it has counted to its set value.
    pub marked: Vec<bool>,
    /// For each place: whether its timer has finished.
    pub over: Vec<bool>,
    /// For each place: the count of its counter.
    pub counts: Vec<u16>,
}

impl Plain {
    pub fn initial(net: &Diagram) -> Plain {
        Plain {
            marked: net.places.iter().map(|place| place.is_marked).collect(),
            over: vec![false; net.places.len()],
            counts: vec![0; net.places.len()],
        }
    }

    fn signal(&self, net: &Diagram, place: usize) -> bool {
        match net.places[place].kind {
            Kind::Timer { .. } => self.over[place],
            _ => self.marked[place],
        }
    }

    fn goes(&self, net: &Diagram, transition: usize, outers: &[bool]) -> bool {
        let mut stops = net.places_of(transition, Direction::Stop).peekable();
        let stopped = |place: usize| self.marked[place] || self.counts[place] > 0;
        net.places_of(transition, Direction::Into).all(|place| self.signal(net, place))
            && !net.places_of(transition, Direction::OutOf).any(|place| self.marked[place])
            && (stops.peek().is_none() || stops.any(stopped))
            && net.gates_of(transition).all(|gate| {
                let value = match gate.signal {
                    Signal::Place(place) => self.signal(net, place),
                    Signal::Outer(outer) => outers[outer],
                };
                value != gate.is_inhibiting
            })
    }

    /// Whether a transition can fire with these outer gates.
    pub fn can_fire(&self, net: &Diagram, transition: usize, outers: &[bool]) -> bool {
        self.goes(net, transition, outers)
            && net.arbiters.iter().all(|arbiter| {
                let mut first =
                    arbiter.transitions.iter().take_while(|&&other| other != transition);
                !arbiter.transitions.contains(&transition)
                    || !first.any(|&other| self.goes(net, other, outers))
            })
    }

    pub fn fire(&self, net: &Diagram, transition: usize) -> Plain {
        let mut next = self.clone();
        for direction in [Direction::Into, Direction::Stop] {
            for place in net.places_of(transition, direction) {
                (next.marked[place], next.over[place], next.counts[place]) = (false, false, 0);
            }
        }
        for place in net.places_of(transition, Direction::OutOf) {
            if let Kind::Counter { count, .. } = net.places[place].kind {
                next.counts[place] += 1;
                next.marked[place] = next.counts[place] == count;
            } else {
                next.marked[place] = true;
            }
        }
        next
    }

    /// The states after one timer has finished.
    pub fn run_out(&self, net: &Diagram) -> Vec<Plain> {
        let runs = |&place: &usize| {
            matches!(net.places[place].kind, Kind::Timer { .. })
                && self.marked[place]
                && !self.over[place]
        };
        let all = (0..net.places.len()).filter(runs);
        all.map(|place| {
            let mut next = self.clone();
            next.over[place] = true;
            next
        })
        .collect()
    }
}

/// All combinations of this many outer gates.
pub fn valuations(count: usize) -> Vec<Vec<bool>> {
    (0..1_usize << count).map(|bits| (0..count).map(|at| bits >> at & 1 == 1).collect()).collect()
}

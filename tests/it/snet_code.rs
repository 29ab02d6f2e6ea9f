//! Code of S-nets, run by the interpreter: it follows the net's rule wherever `snet check` says so, and parts from it
//! only where that told it. Every target is read back by its own front.

use common::chart_run::evaluate::Value;
use common::chart_run::run::{Options as RunOptions, Run};
use common::passed::passed;
use common::snet::{Plain, Random, random_net, ring_net, valuations};
use scanbound::base::facts::Facts;
use scanbound::base::time::{Picos, Times};
use scanbound::front::{Input, Options, read};
use scanbound::iec;
use scanbound::program::{AreaId, Cell, Program};
use scanbound::replay::emulated::Emulated;
use scanbound::snet::address::Address;
use scanbound::snet::check::{Cause, check};
use scanbound::snet::faults::faults;
use scanbound::snet::translate::{c200h, cx, listing, melsec, plcopen};
use scanbound::snet::verify::verify;
use scanbound::snet::{Diagram, Direction, Kind, check as study, text};

fn net(text: &str) -> Diagram {
    text::read("n.snet", text).unwrap_or_else(|why| panic!("{text}\n{why:?}"))
}

fn program(dialect: Option<&str>, code: &str) -> Program {
    let input = Input { name: "a.txt".to_owned(), bytes: code.as_bytes().to_vec() };
    let facts = Facts::default();
    let project = read(&[input], dialect).unwrap_or_else(|why| panic!("{code}\n{why:?}"));
    let decoded = project.decode(&Options::new(&facts)).and_then(passed);
    decoded.unwrap_or_else(|why| panic!("{code}\n{why:?}"))
}

fn word(word: u16) -> Cell {
    Cell { area: AreaId(0), index: u32::from(word) }
}

/// A relay of the internal ones.
fn is_on(cpu: &Emulated<'_>, address: Option<Address>) -> bool {
    let address = address.expect("an address");
    cpu.value(word(address.word)) >> address.bit & 1 == 1
}

fn number(kind: Kind) -> u32 {
    match kind {
        Kind::Timer { number, .. } | Kind::Counter { number, .. } => {
            u32::from(number.expect("a number"))
        }
        Kind::Box => panic!("a box has no number"),
    }
}

/// The state of a net as the PLC has it; counts as the present values say.
fn seen(net: &Diagram, cpu: &Emulated<'_>) -> Plain {
    let mut state = Plain::initial(net);
    for (at, place) in net.places.iter().enumerate() {
        let relay = is_on(cpu, place.head.address);
        let flag = |kind| cpu.value(Cell { area: AreaId(6), index: number(kind) }) == 1;
        state.marked[at] = match place.kind {
            Kind::Counter { .. } => flag(place.kind),
            _ => relay,
        };
        if let Kind::Timer { .. } = place.kind {
            state.over[at] = flag(place.kind);
        }
        if let Kind::Counter { count, .. } = place.kind {
            let present = cpu.value(Cell { area: AreaId(7), index: number(place.kind) });
            // It counts down, in BCD, and has no value before its first scan.
            let left = (0..4)
                .fold(0, |sum, digit| sum + (present >> (4 * digit) & 15) * 10_u16.pow(digit));
            state.counts[at] = if relay { count - left } else { 0 };
        }
    }
    state
}

/// Whether the net could fire these one after another and come to where the code came. Timers may run out behind it.
fn follows(net: &Diagram, state: &Plain, left: &[usize], outers: &[bool], end: &Plain) -> bool {
    if left.is_empty() {
        let mut state = state.clone();
        for at in 0..net.places.len() {
            state.over[at] |= end.over[at] && state.marked[at];
        }
        return state == *end;
    }
    left.iter().enumerate().any(|(at, &transition)| {
        let rest = [&left[..at], &left[at + 1..]].concat();
        state.can_fire(net, transition, outers)
            && follows(net, &state.fire(net, transition), &rest, outers, end)
    })
}

fn transitions(cause: &Cause) -> Vec<usize> {
    match cause {
        Cause::TakenTwice(_, one, other)
        | Cause::FilledTwice(_, one, other)
        | Cause::Escapes(one, other, _) => {
            vec![*one, *other]
        }
        Cause::CountedOnce(one, _) => vec![*one],
        Cause::Circle(all) => all.clone(),
    }
}

#[test]
fn code_parts_from_the_net_where_check_says_and_nowhere_else() {
    let more: u64 =
        std::env::var("SCANBOUND_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let mut random = Random::new(7);
    let (mut nets, mut parted, mut scans, mut fired_together) = (0, 0, 0, 0);
    while nets < 700 * more {
        let source = random_net(&mut random, 8);
        let diagram = net(&source);
        if !faults(&diagram).is_empty() {
            continue;
        }
        nets += 1;
        let first_scan = random.one_in(2);
        let options =
            study::Options { initial_in_first_scan: first_scan, ..study::Options::default() };
        let told = check(&diagram, options).code;
        assert!(told.complete);
        let list = listing(&diagram, first_scan).expect("addresses");
        let code = c200h(&diagram, &list);
        assert_eq!(verify(&diagram, &list, "code", &code).expect("a code"), []);
        let program = program(None, &code);
        let times = vec![Times::new(Picos(1), Picos(1)); program.instructions.len()];
        let mut cpu = Emulated::new(&program, &times);
        let mut before = if first_scan {
            Plain::initial(&diagram)
        } else {
            Plain { marked: vec![false; diagram.places.len()], ..Plain::initial(&diagram) }
        };
        let mut clock = 0;
        for scan in 0..60 {
            let all = valuations(3);
            let outers = &all[random.below(all.len())];
            let bits = outers.iter().enumerate().map(|(at, &on)| u16::from(on) << at).sum();
            cpu.set(word(0), bits);
            cpu.set(word(253), if scan == 0 { 1 << 15 | 1 << 13 } else { 1 << 13 });
            cpu.set_clock(Picos(clock));
            clock += 1_000_000_000 * (1 + random.below(250) as u64);
            let ran = cpu.scan(10_000);
            assert!(ran.stopped.is_none(), "{code}");
            let after = seen(&diagram, &cpu);
            let fired: Vec<usize> = (0..diagram.transitions.len())
                .filter(|&at| is_on(&cpu, diagram.transitions[at].head.address))
                .collect();
            scans += 1;
            fired_together += usize::from(fired.len() > 1);
            if !follows(&diagram, &before, &fired, outers, &after) {
                let is_told = told.divergences.iter().any(|divergence| {
                    transitions(&divergence.cause).iter().all(|at| fired.contains(at))
                });
                assert!(
                    is_told,
                    "{source}\nscan {scan}: {before:?}\nfired {fired:?}\n{after:?}\n{told:?}"
                );
                parted += 1;
                break;
            }
            before = after;
        }
    }
    assert!(
        parted > 40 && scans > 10_000 && fired_together > 100,
        "{parted} {scans} {fired_together}"
    );
}

const NET: &str = "\
outer E1 = 00001
outer E2 = 00002
box A marked = 00300
box B = 00301
timer TM 0.2s = 00302 TIM 3
counter CN 2 = HR0002 CNT 4
transition T = 00310 : A -> TM if E1 not CN
transition U = 00311 : TM -> CN A
transition V = 00312 : CN -> B
transition W = 00313 : B -> if E1
transition R = 00315 : -> A if E1 not E2
stop X = 00314 : A TM CN *-> if E2
";

#[test]
fn the_other_lists_are_read_back_and_do_the_same() {
    let diagram = net(NET);
    let list = listing(&diagram, true).expect("addresses");
    // A counter's instruction stands there once for each way in which it may go.
    let count = |program: &Program| {
        let mut texts: Vec<&str> = program.instructions.iter().map(|one| &*one.text).collect();
        texts.dedup();
        texts.into_iter().filter(|text| !text.starts_with("END")).count()
    };
    let own = program(None, &c200h(&diagram, &list));
    let cs = program(Some("omron-cx"), &cx(&diagram, &list).expect("a list"));
    assert_eq!(count(&own), count(&cs));
    let q = program(Some("melsec-list"), &melsec(&diagram, &list).expect("a list"));
    // One more: what counts and what resets are two instructions there.
    assert_eq!(count(&own) + 1, count(&q));
    // Both run beside each other on the same gates.
    let times =
        |program: &Program| vec![Times::new(Picos(1), Picos(1)); program.instructions.len()];
    let (first, second, third) = (times(&own), times(&cs), times(&q));
    let mut cpus =
        [Emulated::new(&own, &first), Emulated::new(&cs, &second), Emulated::new(&q, &third)];
    let find = |program: &Program, name: &str| {
        let at = program.areas.iter().position(|area| area.name == name).expect("the area");
        AreaId(u16::try_from(at).expect("few"))
    };
    let (x, m, sm) = (find(&q, "X"), find(&q, "M"), find(&q, "SM"));
    let first_cycle = Cell { area: find(&cs, "A"), index: 200 };
    let mut random = Random::new(3);
    let mut changes = 0;
    let mut last = 0;
    for scan in 0..400_u64 {
        let (e1, e2) = (!random.one_in(3), random.one_in(25));
        let clock = Picos(scan * 100_000_000_000);
        let bits = u16::from(e1) << 1 | u16::from(e2) << 2;
        cpus[0].set(word(0), bits);
        cpus[0].set(word(253), if scan == 0 { 1 << 15 } else { 0 });
        cpus[1].set(word(0), bits);
        cpus[1].set(first_cycle, if scan == 0 { 1 << 11 } else { 0 });
        cpus[2].set(Cell { area: x, index: 1 }, u16::from(e1));
        cpus[2].set(Cell { area: x, index: 2 }, u16::from(e2));
        cpus[2].set(Cell { area: sm, index: 402 }, u16::from(scan == 0));
        for cpu in &mut cpus {
            cpu.set_clock(clock);
            assert!(cpu.scan(10_000).stopped.is_none());
        }
        let relays = cpus[0].value(word(3));
        assert_eq!(relays, cpus[1].value(word(3)), "scan {scan}");
        let marks =
            (0..16).map(|bit| cpus[2].value(Cell { area: m, index: 48 + bit }) << bit).sum::<u16>();
        assert_eq!(relays, marks, "scan {scan}");
        changes += u32::from(relays != last);
        last = relays;
    }
    assert!(changes > 50, "{changes}");
}

#[test]
fn a_net_that_is_a_chart_becomes_one_that_is_read_back() {
    let source = "outer E1 = 00001\nbox A marked\nbox B\ntimer TM 0.5s\nbox C\n\
                  transition T : A -> B TM if E1\ntransition U : B TM -> C if not A\ntransition V : C -> A if TM not E1";
    let diagram = net(source);
    let xml = plcopen(&diagram).expect("a chart");
    let project = iec::read("a.xml", &xml).expect("PLCopen XML");
    let charts = project.charts();
    assert_eq!(charts.len(), 1);
    let chart = charts[0].2;
    assert_eq!((chart.steps.len(), chart.transitions.len()), (4, 3));
    assert!(program(None, &xml).instructions.len() > 4);
}

/// A net's chart, scan by scan.
struct Charted<'a> {
    net: &'a Diagram,
    state: Plain,
    since: Vec<i64>,
}

impl Charted<'_> {
    /// What docs/snet.md says of the next scan: all transitions are looked at as the marks are, those that compete for
    /// a step in the order of the file. What it begins with, and which fire.
    fn scan(&mut self, now: i64, outers: &[bool]) -> (Plain, Vec<usize>) {
        for (at, place) in self.net.places.iter().enumerate() {
            if let Kind::Timer { tenths, .. } = place.kind {
                let elapsed = now - self.since[at];
                self.state.over[at] = self.state.marked[at] && elapsed >= i64::from(tenths) * TENTH;
            }
        }
        let (mut taken, mut fired) = (vec![false; self.net.places.len()], Vec::new());
        for at in 0..self.net.transitions.len() {
            let inputs: Vec<usize> = self.net.places_of(at, Direction::Into).collect();
            if self.state.can_fire(self.net, at, outers) && inputs.iter().all(|&one| !taken[one]) {
                inputs.iter().for_each(|&one| taken[one] = true);
                fired.push(at);
            }
        }
        let before = self.state.clone();
        for direction in [Direction::Into, Direction::OutOf] {
            for place in fired.iter().flat_map(|&at| self.net.places_of(at, direction)) {
                self.state.marked[place] = direction == Direction::OutOf;
            }
        }
        for (place, &was) in before.marked.iter().enumerate() {
            if self.state.marked[place] && !was {
                self.since[place] = now;
            }
            self.state.over[place] &= self.state.marked[place];
        }
        (before, fired)
    }
}

const TENTH: i64 = 100_000_000;

#[test]
fn charts_of_random_nets_run_as_the_net_does() {
    let mut random = Random::new(77);
    let (mut nets, mut fired_in_all, mut followed) = (0, 0, 0);
    while nets < 60 {
        let source =
            if random.one_in(4) { random_net(&mut random, 5) } else { ring_net(&mut random) };
        let diagram = net(&source);
        if !faults(&diagram).is_empty() || !diagram.arbiters.is_empty() {
            continue;
        }
        let Ok(xml) = plcopen(&diagram) else { continue };
        nets += 1;
        let project = iec::read("a.xml", &xml).expect("PLCopen XML");
        let charts = project.charts();
        let (_, pou, chart) = charts[0];
        let mut run = Run::new(chart, pou, RunOptions::default());
        let places: Vec<usize> = (0..diagram.places.len())
            .map(|at| {
                let name = format!("S_{}", diagram.place_name(at));
                chart.steps.iter().position(|step| step.name == name).expect("a step")
            })
            .collect();
        let options = study::Options { initial_in_first_scan: true, ..study::Options::default() };
        let code = check(&diagram, options).code;
        let agrees = code.complete && code.divergences.is_empty();
        let since = vec![0; places.len()];
        let mut wanted = Charted { net: &diagram, state: Plain::initial(&diagram), since };
        run.scan(0).expect("a scan");
        for scan in 1..80 {
            let outers: Vec<bool> = (0..diagram.outers.len()).map(|_| random.one_in(2)).collect();
            for (outer, &is_on) in diagram.outers.iter().zip(&outers) {
                run.memory.set(&format!("E_{}", outer.head.name), Value::Bool(is_on));
            }
            let now = scan * TENTH;
            let (before, fired) = wanted.scan(now, &outers);
            run.scan(now).unwrap_or_else(|why| panic!("{source}\n{why}"));
            let active: Vec<bool> = places.iter().map(|&step| run.active()[step]).collect();
            assert_eq!(active, wanted.state.marked, "scan {scan}, {fired:?} fired\n{source}");
            fired_in_all += fired.len();
            // Where the code does what the net does, so does the chart.
            if agrees && !fired.is_empty() {
                let is_followed = follows(&diagram, &before, &fired, &outers, &wanted.state);
                assert!(is_followed, "scan {scan}, {fired:?} fired\n{source}");
                followed += 1;
            }
        }
    }
    assert!(fired_in_all > 500 && followed > 50, "{fired_in_all} fired, {followed} followed");
}

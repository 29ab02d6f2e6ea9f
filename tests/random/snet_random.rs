//! Random S-nets: what `snet check` says of them against all that the net's rule, written down once more, can do.

use common::tape::cases;

use common::snet::{Plain, Random, random_net, valuations};
use scanbound::snet::check::{Options, Step, check};
use scanbound::snet::faults::faults;
use scanbound::snet::{Diagram, text};
use std::collections::BTreeSet;

/// A random net without faults.
fn net(random: &mut Random, most: usize) -> Option<(String, Diagram)> {
    let source = random_net(random, most);
    let diagram =
        text::read("random.snet", &source).unwrap_or_else(|why| panic!("{source}\n{why:?}"));
    faults(&diagram).is_empty().then_some((source, diagram))
}

/// All states that a net can come to, and those of them in which nothing but an emergency stop can fire; `None` if
/// there are too many.
fn brute(net: &Diagram) -> Option<(BTreeSet<Plain>, BTreeSet<Plain>)> {
    let (mut seen, mut dead) = (BTreeSet::from([Plain::initial(net)]), BTreeSet::new());
    let mut open = vec![Plain::initial(net)];
    while let Some(state) = open.pop() {
        let mut next = state.run_out(net);
        let mut goes = !next.is_empty();
        for outers in valuations(net.outers.len()) {
            for at in (0..net.transitions.len()).filter(|&at| state.can_fire(net, at, &outers)) {
                goes |= !net.transitions[at].is_stop;
                next.push(state.fire(net, at));
            }
        }
        if !goes {
            dead.insert(state);
        }
        for one in next {
            if seen.insert(one.clone()) {
                open.push(one);
            }
        }
        if seen.len() > 3_000 {
            return None;
        }
    }
    Some((seen, dead))
}

/// Whether a run's steps all are possible; where it ends.
fn follow(net: &Diagram, run: &[Step]) -> Option<Plain> {
    let mut state = Plain::initial(net);
    for step in run {
        state = match step {
            Step::Fire(at) => {
                let fires = |outers: &Vec<bool>| state.can_fire(net, *at, outers);
                valuations(net.outers.len()).iter().any(fires).then(|| state.fire(net, *at))?
            }
            Step::RunOut(place) => {
                let over = |one: &Plain| one.over[*place] != state.over[*place];
                state.run_out(net).into_iter().find(over)?
            }
            Step::Scan(_) => return None,
        };
    }
    Some(state)
}

#[test]
fn deadlocks_are_those_of_brute_force() {
    let mut random = Random::new(1);
    let (mut tried, mut with) = (0, 0);
    while tried < cases(400_u64) {
        let Some((source, diagram)) = net(&mut random, 12) else { continue };
        let Some((seen, dead)) = brute(&diagram) else { continue };
        tried += 1;
        let found = check(&diagram, Options::default()).markings;
        assert!(found.complete);
        assert_eq!((found.count, found.dead_count), (seen.len(), dead.len()), "{source}");
        with += u32::from(!dead.is_empty());
        assert_eq!(found.dead.is_empty(), dead.is_empty(), "{source}");
        for one in &found.dead {
            let end =
                follow(&diagram, &one.run).unwrap_or_else(|| panic!("{source}\n{:?}", one.run));
            assert!(dead.contains(&end), "{source}\n{:?} leads to {end:?}", one.run);
            let stops = one
                .run
                .iter()
                .any(|step| matches!(step, Step::Fire(at) if diagram.transitions[*at].is_stop));
            assert_eq!(stops, one.is_after_stop, "{source}\n{:?}", one.run);
        }
        // What is said never to fire does not.
        for &at in &found.never {
            let fires = |state: &Plain| {
                valuations(diagram.outers.len())
                    .iter()
                    .any(|outers| state.can_fire(&diagram, at, outers))
            };
            assert!(!seen.iter().any(fires), "{source}");
        }
    }
    assert!(with > 100, "{with} of {tried}");
}

#[test]
fn a_million_markings_are_all_seen() {
    // Twenty boxes that come and go by themselves.
    let boxes: String = (0..20)
        .map(|n| format!("box B{n}\ntransition I{n} : -> B{n}\ntransition O{n} : B{n} -> \n"))
        .collect();
    let diagram = text::read("many.snet", &boxes).expect("a net");
    let found = check(&diagram, Options::default());
    assert_eq!((found.markings.count, found.markings.complete), (1 << 20, true));
    // The code moves all of them in every scan: two states.
    assert!(found.code.complete && found.code.divergences.is_empty() && found.code.count == 2);
    // A search that ends too soon says so, and gates and invariants still tell that the code follows.
    let few = check(&diagram, Options { limit: 4, ..Options::default() });
    assert!(!few.markings.complete && !few.markings.dead.iter().any(|dead| dead.but_stop));
    assert!(few.code.undecided.is_empty());
}

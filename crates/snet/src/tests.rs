//! The two rules: the net's, one transition after another, and the code's, all at once.

use super::rules::Rules;
use super::text::read;
use super::{Diagram, rules::State};

fn net(text: &str) -> (Diagram, Rules) {
    let diagram = read("n.snet", text).expect("a net");
    let rules = Rules::new(&diagram);
    (diagram, rules)
}

/// What is marked, by names; timers that are over with `!`, counters with their counts.
fn marked(diagram: &Diagram, rules: &Rules, state: &State) -> String {
    let name = |at: usize| {
        let (mark, count) = (rules.is_marked(state, at), rules.count(state, at));
        let over = if rules.is_over(state, at) { "!" } else { "" };
        let count = if count > 0 { format!("{count}") } else { String::new() };
        (mark || !count.is_empty()).then(|| format!("{}{over}{count}", diagram.place_name(at)))
    };
    (0..diagram.places.len()).filter_map(name).collect::<Vec<_>>().join(" ")
}

#[test]
fn a_transition_needs_its_inputs_room_behind_it_and_its_gates() {
    let text = "outer E\nouter S\nbox A marked\nbox B\nbox C marked\n\
                transition T : A -> B if E C not S\ntransition U : B ->";
    let (diagram, rules) = net(text);
    let start = rules.initial();
    assert!(rules.can_fire(&start, 0, &[true, false]));
    assert!(
        !rules.can_fire(&start, 0, &[false, false]) && !rules.can_fire(&start, 0, &[true, true])
    );
    assert_eq!(rules.gates_to_fire(&start, 0), Some(vec![(0, true), (1, false)]));
    let next = rules.fire(&start, 0);
    assert_eq!(marked(&diagram, &rules, &next), "B C");
    assert!(!rules.is_ready(&next, 0) && rules.is_ready(&next, 1));
    let (_, full) = net("box A marked\nbox B marked\ntransition T : A -> B");
    assert!(!full.is_ready(&full.initial(), 0));
}

#[test]
fn a_timer_lets_go_when_its_time_is_over_and_forgets_it_with_its_mark() {
    let text = "timer TM 1s\nbox A\ntransition T : -> TM\ntransition U : TM -> A\nstop X : TM *->";
    let (diagram, rules) = net(text);
    let running = rules.fire(&rules.empty(), 0);
    assert!(rules.is_running(&running, 0) && !rules.is_ready(&running, 1));
    assert!(!rules.is_ready(&running, 0), "upstream looks at the box");
    let over = rules.run_out(&running, 0);
    assert_eq!(marked(&diagram, &rules, &over), "TM!");
    assert_eq!(marked(&diagram, &rules, &rules.fire(&over, 1)), "A");
    assert_eq!(rules.fire(&over, 2), rules.empty());
    assert!(!rules.is_ready(&rules.empty(), 2));
}

#[test]
fn a_counter_counts_to_its_value_and_begins_anew_behind_its_output() {
    let text = "counter CN 3\nbox A\ntransition T : -> CN\ntransition U : CN -> A\nstop X : CN *->";
    let (diagram, rules) = net(text);
    let mut state = rules.empty();
    for count in ["CN1", "CN2", "CN3"] {
        assert!(rules.is_ready(&state, 0) && !rules.is_ready(&state, 1));
        state = rules.fire(&state, 0);
        assert_eq!(marked(&diagram, &rules, &state), count);
        // Whatever it has counted is stopped.
        assert_eq!(rules.fire(&state, 2), rules.empty());
    }
    assert!(!rules.is_ready(&state, 0) && rules.is_marked(&state, 0));
    assert_eq!(marked(&diagram, &rules, &rules.fire(&state, 1)), "A");
}

#[test]
fn an_arbiter_lets_the_first_go() {
    let text = "outer E\nbox A marked\nbox B\nbox C\ntransition T : A -> B if E\ntransition U : A -> C\narbiter X : T U";
    let (_, rules) = net(text);
    let start = rules.initial();
    assert!(rules.can_fire(&start, 0, &[true]) && !rules.can_fire(&start, 1, &[true]));
    assert!(rules.can_fire(&start, 1, &[false]));
    assert_eq!(rules.gates_to_fire(&start, 1), Some(vec![(0, false)]));
    // The code knows no arbiter.
    assert_eq!(rules.fired(&start, &[true]), [0, 1]);
    assert_eq!(rules.order(&start, &[true], &[0, 1]), None);
}

#[test]
fn a_scan_that_the_net_could_follow_has_an_order() {
    // T leaves A, whose mark U looks at: U first.
    let (diagram, rules) = net(
        "box A marked\nbox B\nbox C marked\nbox D\ntransition T : A -> B\ntransition U : C -> D if A",
    );
    let start = rules.initial();
    let fired = rules.fired(&start, &[]);
    assert_eq!(marked(&diagram, &rules, &rules.scan(&start, &fired)), "B D");
    assert_eq!(rules.order(&start, &[], &fired), Some(vec![1, 0]));
    // Each leaves what the other looks at: no order.
    let (_, crossed) =
        net("box A marked\nbox C marked\ntransition T : A -> if C\ntransition U : C -> if A");
    let start = crossed.initial();
    assert_eq!(crossed.order(&start, &[], &crossed.fired(&start, &[])), None);
}

#[test]
fn two_transitions_that_take_or_fill_one_box_have_no_order() {
    for text in [
        "box A marked\nbox B\nbox C\ntransition T : A -> B\ntransition U : A -> C",
        "box A\ntransition T : -> A\ntransition U : -> A",
    ] {
        let (_, rules) = net(text);
        let start = rules.initial();
        let fired = rules.fired(&start, &[]);
        assert_eq!((fired.len(), rules.order(&start, &[], &fired)), (2, None), "{text}");
    }
}

#[test]
fn a_mark_escapes_from_a_stop_that_fires_beside() {
    let escaping = "box A marked\nbox B\ntransition T : A -> B\nstop X : A *->";
    let (diagram, rules) = net(escaping);
    let start = rules.initial();
    assert_eq!(marked(&diagram, &rules, &rules.scan(&start, &[0, 1])), "B");
    assert_eq!(rules.order(&start, &[], &[0, 1]), None);
    // Where the stop takes from both, T first and then the stop comes to the same.
    let (_, held) = net("box A marked\nbox B\ntransition T : A -> B\nstop X : A B *->");
    assert_eq!(held.order(&held.initial(), &[], &[0, 1]), Some(vec![0, 1]));
    assert_eq!(held.scan(&held.initial(), &[0, 1]), held.empty());
}

#[test]
fn a_counters_edge_is_not_seen_twice() {
    let (diagram, rules) = net("counter CN 3\ntransition T : -> CN\ntransition U : CN ->");
    let first = rules.scan(&rules.empty(), &[0]);
    assert!(rules.order(&rules.empty(), &[], &[0]).is_some());
    let second = rules.scan(&first, &[0]);
    assert_eq!(marked(&diagram, &rules, &second), "CN1");
    assert_eq!(rules.order(&first, &[], &[0]), None);
    // In between its relay falls.
    let third = rules.scan(&rules.scan(&second, &[]), &[0]);
    assert_eq!(marked(&diagram, &rules, &third), "CN2");
}

#[test]
fn wide_nets_take_more_words() {
    let boxes: String = (0..150).map(|n| format!("box B{n}\n")).collect();
    let moves: String =
        (0..149).map(|n| format!("transition T{n} : B{n} -> B{}\n", n + 1)).collect();
    let (_, rules) = net(&format!(
        "{boxes}{moves}transition S : -> B0\ncounter CN 9999\ntransition U : B149 -> CN\ntransition V : CN ->"
    ));
    assert!(rules.width() > 2);
    let mut state = rules.fire(&rules.empty(), 149);
    for at in 0..149 {
        assert!(rules.is_ready(&state, at));
        state = rules.fire(&state, at);
    }
    assert!(rules.is_marked(&state, 149) && rules.is_ready(&state, 150));
    assert_eq!(rules.count(&rules.fire(&state, 150), 150), 1);
}

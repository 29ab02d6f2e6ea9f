//! Nothing is drawn upon something else, and every arc leads from one of its ends to the other.

use super::*;
use crate::text::read;

fn drawn(text: &str) -> (Diagram, Vec<Sheet>) {
    let diagram = read("a.snet", text).expect("a net");
    let sheets = sheets(&diagram);
    (diagram, sheets)
}

/// Whether two elements with what is written beside them have a cell in common.
fn overlap(a: &Drawn, b: &Drawn) -> bool {
    let (left, right) =
        (|one: &Drawn| one.at.x - one.reach.0, |one: &Drawn| one.at.x + one.reach.1);
    left(a) <= right(b)
        && left(b) <= right(a)
        && a.at.y < b.at.y + b.rows
        && b.at.y < a.at.y + a.rows
}

fn check(diagram: &Diagram, sheets: &[Sheet]) {
    for sheet in sheets {
        for (at, one) in sheet.nodes.iter().enumerate() {
            assert!(one.at.x >= one.reach.0 && one.at.y >= 0, "{one:?}");
            assert!(one.at.x + one.reach.1 < sheet.size.x && one.at.y + one.rows < sheet.size.y);
            for other in &sheet.nodes[..at] {
                assert!(!overlap(one, other), "{one:?} {other:?}");
            }
        }
        for line in &sheet.lines {
            let arc = diagram.arcs[line.arc];
            let node = |node| sheet.nodes.iter().find(|one| one.node == node).expect("drawn");
            let (place, transition) =
                (node(Node::Place(arc.place)), node(Node::Transition(arc.transition)));
            let (from, to) = match arc.direction {
                Direction::OutOf => (transition, place),
                Direction::Into | Direction::Stop => (place, transition),
            };
            for (end, spot) in [(from, line.corners.first()), (to, line.corners.last())] {
                let spot = spot.expect("a corner");
                let near_row = [end.at.y - 1, end.at.y + end.rows].contains(&spot.y);
                assert!(near_row && (spot.x - end.at.x).abs() <= HALF, "{line:?} {end:?}");
            }
            for pair in line.corners.windows(2) {
                assert!(pair[0].x == pair[1].x || pair[0].y == pair[1].y, "{line:?}");
            }
            // No line goes through a symbol.
            for pair in line.corners.windows(2) {
                for one in &sheet.nodes {
                    let (x, y) = (
                        pair[0].x.min(pair[1].x)..=pair[0].x.max(pair[1].x),
                        pair[0].y.min(pair[1].y)..=pair[0].y.max(pair[1].y),
                    );
                    let hits = (one.at.x - HALF..=one.at.x + HALF)
                        .any(|column| x.contains(&column))
                        && (one.at.y..one.at.y + one.rows).any(|row| y.contains(&row));
                    assert!(!hits, "{line:?} goes through {one:?}");
                }
            }
        }
    }
}

#[test]
fn a_circle_is_laid_out_from_its_mark_down() {
    let (diagram, sheets) = drawn(
        "outer GO\nbox A marked\nbox B\ntransition T : A -> B if GO\ntransition U : B -> A if not GO\n",
    );
    check(&diagram, &sheets);
    let row = |node| sheets[0].nodes.iter().find(|one| one.node == node).expect("it").at.y;
    assert!(row(Node::Place(0)) < row(Node::Transition(0)));
    assert!(row(Node::Transition(0)) < row(Node::Place(1)));
    assert!(row(Node::Place(1)) < row(Node::Transition(1)));
}

#[test]
fn what_stands_on_another_page_is_shown_as_a_guest() {
    let (diagram, sheets) = drawn(
        "page P\nbox A marked\ntransition T : A -> Q.B\npage Q\nbox B\ntransition U : B -> P.A\n",
    );
    check(&diagram, &sheets);
    assert_eq!(sheets.len(), 2);
    let guests = sheets[0].nodes.iter().filter(|one| one.is_guest);
    assert_eq!(guests.map(|one| one.node).collect::<Vec<_>>(), [Node::Place(1)]);
}

#[test]
fn stated_positions_are_kept() {
    let (_, sheets) = drawn(
        "box A marked at 80,32\nbox B at 80,320\ntransition T at 80,160 : A -> B\n\
         transition U at 240,160 : B -> A\n",
    );
    let at = |node| sheets[0].nodes.iter().find(|one| one.node == node).expect("it").at;
    let (a, b) = (at(Node::Place(0)), at(Node::Place(1)));
    assert_eq!((b.x - a.x, b.y - a.y), (0, 18));
    assert_eq!(at(Node::Transition(1)).x - at(Node::Transition(0)).x, 20);
}

#[test]
fn random_nets_are_drawn_without_overlaps() {
    let mut seed = 1u32;
    let mut next = |below: u32| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 16) % below
    };
    for _ in 0..60 {
        let (places, transitions) = (1 + next(9), 1 + next(9));
        let mut text = String::from("outer E1\nouter 非常停止\n");
        for place in 0..places {
            text += &match next(4) {
                0 => format!("timer W{place} 1.{}s\n", next(10)),
                1 => format!("counter C{place} {}\n", 1 + next(9)),
                _ => format!("box 箱{place}\n"),
            };
        }
        let names: Vec<String> = text
            .lines()
            .skip(2)
            .map(|line| line.split(' ').nth(1).expect("a name").to_owned())
            .collect();
        for transition in 0..transitions {
            let some = |next: &mut dyn FnMut(u32) -> u32| {
                let mut found: Vec<&str> = Vec::new();
                for _ in 0..next(3) {
                    found.push(&names[next(places) as usize]);
                }
                found.sort_unstable();
                found.dedup();
                found.join(" ")
            };
            let (from, to) = (some(&mut next), some(&mut next));
            let gates = ["", " if E1", " if 非常停止 not E1"][next(3) as usize];
            text += &format!("transition T{transition} : {from} -> {to}{gates}\n");
        }
        let (diagram, sheets) = drawn(&text);
        check(&diagram, &sheets);
    }
}

//! What is written is read as the same net, and what other tools write as what it is.

use super::*;
use crate::Direction;
use crate::text;

fn there_and_back(source: &str) {
    let diagram = text::read("a.snet", source).expect("a net");
    let written = write(&diagram);
    let back = read("a.pnml", &written).unwrap_or_else(|faults| panic!("{faults:?}\n{written}"));
    assert_eq!(back.without_lines(), diagram.without_lines(), "{written}");
    assert!(is_pnml(&written) && !is_pnml(source));
}

#[test]
fn nets_come_back_as_they_were() {
    there_and_back("box A\ntransition T : A ->\n");
    there_and_back(
        "net 充填 <1> & \"2\"\nouter 起動 = 00000\nouter E2 at 5,6\n\npage LINE\nbox IDLE marked = 00300 at 120,80\n\
         timer FILL 2.5s = 00301 TIM 000\ncounter TEN 10 = HR0102 CNT 001 at 0,-8\n\
         transition BEGIN = 00310 : IDLE -> FILL if 起動 not PACK.BUSY not FILL\n\
         transition DONE = 00311 at 7,9 : FILL -> TEN IDLE if not E2\nstop HALT = 00312 : FILL TEN *-> if E2\n\
         arbiter ONE at 3,4 : DONE BEGIN\n\npage PACK\nbox BUSY = 00303\n\
         transition TAKE = 00313 : LINE.TEN -> BUSY if LINE.FILL\ntransition READY = 00314 : BUSY -> \n\
         arbiter TWO : READY TAKE LINE.DONE\n",
    );
}

#[test]
fn random_nets_come_back_as_they_were() {
    let mut seed = 7u32;
    let mut next = |below: u32| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 16) % below
    };
    for _ in 0..100 {
        let mut source = String::from("outer E0\nouter E1\n");
        let mut names: Vec<String> = Vec::new();
        for page in 0..1 + next(3) {
            source += &format!("page P{page}\n");
            for place in 0..1 + next(6) {
                let marked = if next(3) == 0 { " marked" } else { "" };
                source += &match next(4) {
                    0 => format!("timer W{place} {}.{}s{marked}\n", next(99), next(10)),
                    1 => format!("counter C{place} {}\n", 1 + next(99)),
                    _ => format!("box C{place}{marked} at {},{}\n", next(500), next(500)),
                };
                let own = source.lines().last().and_then(|line| line.split(' ').nth(1));
                names.push(format!("P{page}.{}", own.expect("a name")));
            }
            for transition in 0..next(5) {
                let mut pick = || -> String {
                    let mut found: Vec<&str> =
                        (0..next(3)).map(|_| &*names[next(names.len() as u32) as usize]).collect();
                    found.sort_unstable();
                    found.dedup();
                    found.join(" ")
                };
                let (from, to, gate) = (pick(), pick(), pick());
                let gate = gate.split(' ').next().filter(|gate| !gate.is_empty());
                let gate =
                    gate.map_or(" if not E1".to_owned(), |gate| format!(" if E0 not {gate}"));
                source += &match next(4) {
                    0 => format!("stop T{transition} : {from} *->{gate}\n"),
                    _ => format!("transition T{transition} : {from} -> {to}{gate}\n"),
                };
            }
        }
        there_and_back(&source);
    }
}

#[test]
fn a_net_of_another_tool_is_read_as_boxes_and_transitions() {
    let source = r#"<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"><net id="n" type="http://www.pnml.org/version-2009/grammar/ptnet">
<page id="g"><place id="x"><name><text>ready now</text></name><graphics><position x="10.5" y="20"/></graphics>
<initialMarking><text>1</text></initialMarking></place>
<place id="y"/><transition id="go"/><transition id="back"><name><text>go</text></name></transition>
<referencePlace id="r" ref="y"/>
<arc id="1" source="x" target="go"/><arc id="2" source="go" target="r"><inscription><text>1</text></inscription></arc>
<arc id="3" source="y" target="back"/><arc id="4" source="back" target="x"/>
<arc id="5" source="y" target="go"><type value="inhibitor"/></arc>
<arc id="6" source="x" target="back"><type value="read"/></arc></page></net></pnml>"#;
    let diagram = read("b.pnml", source).expect("a net");
    let names: Vec<&str> = diagram.places.iter().map(|place| &*place.head.name).collect();
    assert_eq!(names, ["ready_now", "y"]);
    assert!(diagram.places[0].is_marked && diagram.places[0].head.at.is_some_and(|at| at.x == 10));
    let names: Vec<&str> = diagram.transitions.iter().map(|one| &*one.head.name).collect();
    assert_eq!(names, ["go", "go_2"]);
    assert_eq!(diagram.places_of(0, Direction::OutOf).collect::<Vec<_>>(), [1]);
    // The inhibitor says but that y holds one mark; the read arc is a gate.
    assert_eq!(diagram.gates.len(), 1);
    assert!(!diagram.gates[0].is_inhibiting);
    // And as a net of ours it goes on.
    let again = text::read("b.snet", &text::write(&diagram)).expect("a net");
    assert_eq!(again.without_lines(), diagram.without_lines());
}

#[test]
fn faults_have_their_line() {
    let fault = |inner: &str| {
        let source = format!(
            "<pnml><net id=\"n\">\n<place id=\"a\"/>\n<place id=\"b\"/>\n<transition id=\"t\"/>\n{inner}\n</net></pnml>"
        );
        let faults = read("c.pnml", &source).expect_err("a fault");
        (faults[0].line, faults[0].message.clone())
    };
    for (inner, message) in [
        ("<arc id=\"1\" source=\"a\" target=\"b\"/>", "connects two places"),
        ("<arc id=\"1\" source=\"a\" target=\"q\"/>", "'q', which is not an element"),
        (
            "<arc id=\"1\" source=\"a\" target=\"t\"><inscription><text>2</text></inscription></arc>",
            "the weight '2'",
        ),
        ("<arc id=\"1\" source=\"a\" target=\"t\"><type value=\"magic\"/></arc>", "'magic'"),
        (
            "<place id=\"c\"><initialMarking><text>3</text></initialMarking></place>",
            "the initial marking '3'",
        ),
        ("<place id=\"a\"/>", "given twice"),
        ("<place/>", "has no id"),
    ] {
        let (line, told) = fault(inner);
        assert_eq!(line, Some(5), "{told}");
        assert!(told.contains(message), "{told}");
    }
    let faults = read("c.pnml", "<pnml>\n<net>\n</pnml>").expect_err("no XML");
    assert_eq!(faults[0].line, Some(3));
    assert!(read("c.pnml", "<pnml/>").is_err());
}

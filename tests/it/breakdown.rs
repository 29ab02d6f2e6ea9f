//! The parts of random programs' bounds add up to them, to the picosecond, and what a condition is worth is no more
//! than the scan.

use proptest::prelude::*;
use scanbound::audit::breakdown::{By, Piece};
use scanbound::audit::{Audit, Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use std::time::Duration;

/// Rungs that share contacts, compare words, loop and call; each number picks one.
fn program(rungs: &[(u8, u8, u8)]) -> String {
    let mut text = String::new();
    for &(kind, a, b) in rungs {
        let (a, b) = (a % 4, b % 4);
        text += &match kind % 8 {
            0 => format!("LD X{a}\nANI X{b}\nMOV K{b} D{a}\n"),
            1 => format!("LD M{a}\nOR X{b}\nOUT M{b}\n"),
            2 => format!("LD= D{a} K{b}\nBMOV D10 D20 K{}\n", a + 2),
            3 => format!("LDI X{a}\nAND M{b}\nBMOV D10 D30 D{a}\n"),
            4 => format!("FOR K{}\nLD X{a}\nINC D{b}\nNEXT\n", b + 1),
            5 => format!("LD X{a}\nCALL P{}\n", b % 2),
            6 => format!("LDP X{a}\nFMOV K0 D40 K{}\n", b + 1),
            _ => format!("LD> D{a} D{b}\nDMOV D0 D50\n"),
        };
    }
    text + "FEND\nP0\nLD X0\nMOV K5 D60\nRET\nP1\nLD M0\nFMOV K1 D70 K9\nRET\nEND\n"
}

fn audited(text: &str, time_limit: Option<Duration>) -> Audit {
    let half = text.find("FEND").expect("an end of the main routine");
    let first = format!("{}END\n", "LD X1\nMOV K3 D80\n".repeat(half % 3 + 1));
    let input = |name: &str, text: &str| Input { name: name.into(), bytes: text.into() };
    let inputs = [input("first.il", &first), input("main.il", text)];
    let facts = Facts::parse("facts.toml", "[io]\ninputs = 16\noutputs = 16\n").expect("facts");
    let request = Request { cpu: Some("Q26UDV"), time_limit, ..Request::new(&inputs, &facts) };
    audit(&request).unwrap_or_else(|failure| panic!("{text}\n{failure:?}"))
}

fn holds(audit: &Audit) {
    for by in By::ALL {
        let parts = audit.breakdown(by);
        let sum: Picos = parts.iter().map(|part| part.time).sum();
        assert_eq!(sum, audit.bound.upper, "{}", by.name());
        assert!(parts.iter().all(|part| part.always <= part.time && part.time <= part.most));
        let factors = parts.iter().filter(|part| matches!(part.piece, Piece::Factor(_))).count();
        assert_eq!(factors, usize::from(audit.table.factor.is_some()));
    }
    assert!(audit.assumed_part() <= audit.bound.upper);
    for value in &audit.witness {
        assert!(value.worth <= audit.bound.upper && (value.matters || value.worth == Picos::ZERO));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_parts_add_up(rungs in prop::collection::vec(any::<(u8, u8, u8)>(), 1..12)) {
        let text = program(&rungs);
        holds(&audited(&text, None));
        // What was not searched for is a part of its own, or all that can run is.
        let cut = audited(&text, Some(Duration::ZERO));
        holds(&cut);
        if cut.bound.upper == cut.bound.naive {
            prop_assert!(cut.is_settled() && cut.breakdown(By::Rung).iter().all(|part| part.piece != Piece::Open));
        }
    }
}

#[test]
fn a_routine_is_told_by_its_label() {
    let text = program(&[(5, 0, 0), (5, 1, 1), (0, 0, 1)]);
    let parts = audited(&text, None).breakdown(By::Routine);
    let names: Vec<String> = parts
        .iter()
        .filter_map(|part| match &part.piece {
            Piece::Routine(file, name) => {
                Some(format!("{file} {}", name.as_deref().unwrap_or("-")))
            }
            _ => None,
        })
        .collect();
    let mut sorted = names.clone();
    sorted.sort();
    assert_eq!(sorted, ["0 -", "1 -", "1 P0", "1 P1"]);
}

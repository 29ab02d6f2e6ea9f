//! What the report names as not known: counts, and writes of which it is not known where they go, causes before what
//! follows.

use common::audited::{asked, listed, table};
use scanbound::audit::{Audit, UnknownKind, conclude, follow, what_if};
use scanbound::base::facts::Facts;
use scanbound::passes::values::Trust;

/// An audit, with what it would be if what it names were at most so many.
fn with(text: &str, facts: &str, most: &[u32]) -> Audit {
    let (inputs, table) =
        (listed(text.replace("; ", "\n") + "\n"), table("Op1,1,0,0\nOp9,9,0,0\n"));
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    let request = asked(&inputs, &table, &facts, Trust::Counts);
    let mut concluded = conclude(follow(&request).expect("a model"), &request).expect("an audit");
    what_if(&mut concluded, &request, most).expect("audits");
    concluded.audit
}

/// What is named: the line for the facts file, and what an index comes from.
fn named(text: &str, facts: &str) -> Vec<String> {
    let audit = with(text, facts, &[]);
    let told = |one: &scanbound::audit::Unknown| format!("{}{}", one.fact, one.origin());
    audit.unknowns.iter().map(told).collect()
}

#[test]
fn an_index_of_which_nothing_is_known_is_named_with_what_it_comes_from() {
    let text = "LD X0; MOV D10 Z0; MOV K1 D1000Z0; LD= D5 K3; Op9; END";
    let line = "\"a.txt:3\" = [0, 99], from the value of D10 at the start of the scan";
    assert_eq!(named(text, ""), [line]);
    assert_eq!(named(text, "[index]\n\"a.txt:3\" = [0, 99]\n"), [""; 0]);
    assert_eq!(named(text, "[index]\nZ0 = [0, 5000]\n"), [""; 0], "it is known how far");
    let known = "LD X0; MOV K7 Z0; MOV K1 D1000Z0; LD= D5 K3; Op9; END";
    assert_eq!(named(known, ""), [""; 0]);
    let kept = "LD X0; WAND K255 D10 Z0; MOV K1 D1000Z0; LD= D5 K3; Op9; END";
    assert_eq!(named(kept, ""), [""; 0], "one of 256 words is no far write");
}

#[test]
fn what_nothing_depends_on_is_not_named() {
    assert_eq!(named("LD X0; MOV K1 D1000Z0; LD X1; Op9; END", ""), [""; 0]);
    assert_eq!(named("LD X0; MOV K1 D1000Z0; LD= W5 K3; Op9; END", ""), [""; 0]);
    assert_eq!(named("LD= D5 K3; Op9; LD X0; MOV K1 D1000Z0; END", ""), [""; 0]);
}

#[test]
fn what_follows_from_another_is_not_named_until_that_is_stated() {
    // The second index is what the first write may have left; the third is not.
    let text = "LD X0; MOV K1 D1000Z0; LD X0; MOV D2000 Z1; MOV K1 W0Z1; LD X0; MOV W2000 Z2; MOV K1 R0Z2; LD= R5 K3; Op9; LD= D9 K4; Op1; END";
    let lines = ["\"a.txt:2\" = [0, 99], from the value of Z0 at the start of the scan"];
    assert_eq!(named(text, ""), lines);
    let stated = "[index]\n\"a.txt:2\" = [0, 99]\n";
    let second = ["\"a.txt:5\" = [0, 99], from the value of D2000 at the start of the scan"];
    assert_eq!(named(text, stated), second);
}

#[test]
fn a_count_comes_behind_the_write_that_may_change_it() {
    let loops = "FOR D50; LD X1; Op9; NEXT; LD SM400; MOV K3 D50; ";
    let text = format!("{loops}LD X0; MOV K1 D1000Z0; END");
    let lines = [
        "\"a.txt:8\" = [0, 99], from the value of Z0 at the start of the scan",
        "\"a.txt:1\" = [0, 20]",
    ];
    assert_eq!(named(&text, ""), lines);
    let text = format!("{loops}LD X0; MOV K1 @D1000; END");
    let lines = ["indirect = [\"D0-D99\"]", "\"a.txt:1\" = [0, 20]"];
    assert_eq!(named(&text, ""), lines);
    // Nobody writes this one: it is what stating helps.
    let text = "FOR D51; LD X1; Op9; NEXT; LD X0; MOV K1 D1000Z0; LD= D5 K3; Op1; END";
    let lines = [
        "\"a.txt:1\" = [0, 20]",
        "\"a.txt:6\" = [0, 99], from the value of Z0 at the start of the scan",
    ];
    assert_eq!(named(text, ""), lines);
}

#[test]
fn the_bits_of_an_index_are_named_where_they_matter() {
    let text = "LD X0; MOV K5 Z0; MOV K1 ZR1000Z0; LD= ZR5 K3; Op9; END";
    assert_eq!(named(text, ""), ["bits = 16"]);
    assert_eq!(named(text, "[index]\nbits = 16\n"), [""; 0]);
}

#[test]
fn an_index_is_named_whatever_device_it_is_added_to() {
    // All that 16 bits can say is some of the area, and not from there on.
    let text = "LD X0; MOV D10 Z0; MOV K1 ZR40000Z0; LD= ZR50000 K3; Op9; END";
    let line = "\"a.txt:3\" = [0, 99], from the value of D10 at the start of the scan";
    assert_eq!(named(text, "[index]\nbits = 16\n"), [line]);
}

#[test]
fn what_is_solved_for_an_index_is_the_bound_with_that_fact() {
    let text = "FOR D50; LD X1; Op9; NEXT; LD SM400; MOV K3 D50; LD X0; MOV K1 D1000Z0; LD X0; MOV K5 Z1; MOV K1 ZR1000Z1; FOR ZR20; LD X2; Op1; NEXT; LD SM400; MOV K5 ZR20; END";
    let found = with(text, "", &[20, 1000]);
    let what_if = found.what_if.as_ref().expect("it was asked for");
    let kinds: Vec<bool> = what_if
        .steps
        .iter()
        .map(|step| matches!(step.unknown.kind, UnknownKind::Count(_)))
        .collect();
    assert!(kinds.contains(&false), "{:?}", what_if.steps);
    let mut before = [found.bound.upper; 2];
    for (index, step) in what_if.steps.iter().enumerate() {
        for (value, (&most, solved)) in what_if.most.iter().zip(&step.solved).enumerate() {
            let mut facts = [String::from("[counts]\n"), String::from("[index]\n")];
            for step in &what_if.steps[..=index] {
                let table = usize::from(step.unknown.table() == "index");
                let line =
                    step.unknown.fact.replace("20]", "99]").replace("99]", &format!("{most}]"));
                facts[table] += &(line + "\n");
            }
            let solved = solved.expect("a bound").upper;
            assert_eq!(solved, with(text, &facts.concat(), &[]).bound.upper, "{facts:?}");
            assert!(solved <= before[value]);
            before[value] = solved;
        }
    }
    assert!(before[0] < found.bound.upper);
}

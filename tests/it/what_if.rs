//! What stating counts is worth and what trust is: each bound that is told beside the bound is that of an audit which
//! is asked just so.

use common::audited::{asked, listed, table};
use scanbound::audit::{
    Audit, LimitedCount, Request, SolvedBound, WhatIf, audit, conclude, follow, what_if,
};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::passes::values::Trust;
use scanbound::timing::table::Table;
use std::time::Duration;

/// The times of all programs here, in microseconds.
fn times() -> Table {
    table("Op1,1,0,0\nFMOV,0,0,1\nBMOV,0,0,10000\n")
}

/// An audit with what it would be if these counts were stated.
fn with(text: &str, facts: &str, trust: Trust, most: &[u32]) -> Audit {
    let (inputs, table) = (listed(text.replace("; ", "\n") + "\n"), times());
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    let request = asked(&inputs, &table, &facts, trust);
    let mut concluded = conclude(follow(&request).expect("a model"), &request).expect("an audit");
    what_if(&mut concluded, &request, most).expect("audits");
    concluded.audit
}

fn solved(audit: &Audit) -> &WhatIf {
    audit.what_if.as_ref().expect("it was asked for")
}

/// The bound of an audit by itself.
fn bound(text: &str, facts: &str, trust: Trust) -> u64 {
    let (inputs, table) = (listed(text.replace("; ", "\n") + "\n"), times());
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    audit(&asked(&inputs, &table, &facts, trust)).expect("an audit").bound.upper.0
}

#[test]
fn each_bound_is_that_of_a_run_with_those_facts() {
    // What D52 counts is less than a thousandth of what D51 does, and so not named before D51 is stated.
    let text = "LD X0; BMOV D2000 D1000 D51; LD X1; FMOV K0 D1000 D50; LD X2; FMOV K0 D1000 D51; FOR D52; LD X3; Op1; NEXT; FOR K3; LD X4; Op1; NEXT; END";
    for (facts, words) in [("", &["D51", "D50", "D52"][..]), ("D50 = [0, 7]\n", &["D51", "D52"])] {
        let found = with(text, &format!("[counts]\n{facts}"), Trust::None, &[100, 5, 100]);
        let named: Vec<&str> = found.unknowns.iter().map(|one| &*one.word).collect();
        assert_eq!(named, ["D51"], "the others are small against it");
        let what_if = solved(&found);
        assert_eq!(what_if.most, [5, 100]);
        let solved: Vec<&str> = what_if.steps.iter().map(|step| &*step.unknown.word).collect();
        assert_eq!(solved, words);
        let mut before = [found.bound.upper.0; 2];
        for (index, step) in what_if.steps.iter().enumerate() {
            for (value, (&most, upper)) in what_if.most.iter().zip(&step.solved).enumerate() {
                let line = |line: &String| line.replace("20]", &format!("{most}]"));
                let stated = what_if.steps[..=index].iter().map(|step| line(&step.unknown.fact));
                let lines: Vec<String> = stated.collect();
                let stated = format!("[counts]\n{facts}{}\n", lines.join("\n"));
                let SolvedBound { upper: Picos(upper), cut } = upper.expect("a bound");
                assert!(!cut, "no time limit");
                assert_eq!(upper, bound(text, &stated, Trust::None), "{stated}");
                assert!(upper < before[value], "{stated}");
                before[value] = upper;
            }
        }
    }
}

#[test]
fn where_the_time_limit_ends_an_audit_its_bound_says_so() {
    let text =
        "LD X0; BMOV D2000 D1000 D51; LD X1; FMOV K0 D1000 D50; LDI X0; FMOV K0 D1000 D52; END";
    let (inputs, table) = (listed(text.replace("; ", "\n") + "\n"), times());
    let facts = Facts::default();
    for (limit, is_cut) in [(Some(Duration::ZERO), true), (None, false)] {
        let request = Request { time_limit: limit, ..asked(&inputs, &table, &facts, Trust::None) };
        let followed = follow(&request).expect("a model");
        let mut concluded = conclude(followed, &request).expect("an audit");
        what_if(&mut concluded, &request, &[5, 100]).expect("audits");
        let steps = &solved(&concluded.audit).steps;
        assert!(!steps.is_empty());
        let mut before = [concluded.audit.bound.upper; 2];
        for (index, step) in steps.iter().enumerate() {
            let lines = |most: u32| {
                let line =
                    |step: &LimitedCount| step.unknown.fact.replace("20]", &format!("{most}]"));
                steps[..=index].iter().map(line).collect::<Vec<_>>().join("\n")
            };
            for (value, (most, one)) in [5, 100].into_iter().zip(&step.solved).enumerate() {
                let one = one.expect("a bound");
                let whole = bound(text, &format!("[counts]\n{}\n", lines(most)), Trust::None);
                assert_eq!(one.cut, is_cut);
                assert!(one.upper.0 >= whole && one.upper <= before[value], "{one}");
                assert!(is_cut || one.upper.0 == whole, "{one}");
                before[value] = one.upper;
            }
        }
    }
}

#[test]
fn no_more_than_five_counts_are_stated_and_none_where_all_are_known() {
    let moves = (50..56).map(|d| format!("LD X{}; FMOV K0 D1000 D{d}; ", d - 50));
    let found = with(&format!("{}END", moves.collect::<String>()), "", Trust::None, &[20]);
    assert_eq!((found.unknowns.len(), solved(&found).steps.len()), (6, 5));
    let found = with("FOR K9; LD X0; Op1; NEXT; END", "", Trust::None, &[20]);
    assert_eq!(
        *solved(&found),
        WhatIf { most: vec![20], steps: Vec::new(), minor: None, own: None }
    );
}

#[test]
fn a_count_that_cannot_be_so_low_has_no_bound_there() {
    let text = "FOR D50; LD X0; Op1; NEXT; LD X3; MOV D9 D50; FOR D50; LD X1; Op1; NEXT; FOR D50; LD X2; Op1; NEXT; END";
    let facts = "[counts]\n\"a.txt:1\" = [30, 40]\n";
    let found = with(text, facts, Trust::None, &[20, 35]);
    let [step] = &solved(&found).steps[..] else { panic!("{:?}", found.what_if) };
    assert_eq!(step.unknown.key, "D50");
    let at_most = format!("{facts}D50 = [0, 35]");
    let bounds = [None, Some(bound(text, &at_most, Trust::None))];
    assert_eq!(
        step.solved.iter().map(|one| one.map(|one| one.upper.0)).collect::<Vec<_>>(),
        bounds
    );
}

/// Blocks of these lengths, which the program writes behind them in every scan.
fn blocks(lengths: &[(&str, u32, u32)]) -> String {
    let block = |(block, d, length): &(_, u32, u32)| {
        let at_most = format!("LD SM400; WAND K63 D{d}; LD X{d}");
        format!("{at_most}; {block} D1000 D{d}; LD SM400; MOV K{length} D{d}; ")
    };
    lengths.iter().map(block).collect::<String>() + "END"
}

fn names(audit: &Audit) -> Vec<String> {
    audit.assumptions.iter().map(|one| one.name()).collect()
}

#[test]
fn an_assumption_costs_what_the_bound_is_without_it() {
    let text = blocks(&[
        ("BMOV D2000", 50, 45),
        ("FMOV K0", 51, 9),
        ("BMOV D2000", 52, 30),
        ("FMOV K0", 53, 5),
    ]);
    for trust in [Trust::Counts, Trust::All] {
        let found = with(&text, "", trust, &[]);
        assert_eq!(names(&found), ["D52", "D50"], "the longest first");
        let mut last = u64::MAX;
        for one in &found.assumptions {
            let without = one.without.expect("a price").upper.0;
            let stated = format!("[external]\ndevices = [{:?}]", one.name());
            assert_eq!(without, bound(&text, &stated, trust), "{stated}");
            assert!(without > found.bound.upper.0 && without <= last);
            last = without;
        }
        // 58 us of 750 ms: less than 0.1 %, each and both.
        let stated = "[external]\ndevices = ['D51', 'D53']";
        let minor = solved(&found).minor.expect("two that are not listed");
        assert_eq!((minor.count, minor.without.upper.0), (2, bound(&text, stated, trust)));
    }
}

#[test]
fn what_each_is_worth_nothing_alone_is_solved_together() {
    // Both relays of either pair must be on for the block, and each pair is kept apart.
    let steps = "LDI M0; ANI M1; AND X4; SET M0; LD M0; AND X0; SET M1; RST M0; LD M1; AND X1; SET M0; RST M1; LDI M2; ANI M3; AND X4; SET M2; LD M2; AND X2; SET M3; RST M2; LD M3; AND X3; SET M2; RST M3; ";
    let text = format!("LD M0; AND M1; AND M2; AND M3; FMOV K0 D1000 K5000; {steps}END");
    let found = with(&text, "", Trust::All, &[]);
    assert_eq!(names(&found), Vec::<String>::new());
    let minor = solved(&found).minor.expect("the pairs");
    assert!(minor.count >= 2);
    assert!(minor.without.upper > found.bound.upper);
    assert_eq!(minor.without.upper.0, bound(&text, "", Trust::None));
}

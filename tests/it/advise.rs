//! Which statement lowers a bound most: each bound that is told is that of an audit with that line among the facts. And
//! what the fact [exclusive] states is believed, no more and no less.

use common::audited::{asked, listed, table};
use scanbound::audit::advise::{Advice, AdviceKind, AdviceSettings, advise};
use scanbound::audit::{Audit, Failure, audit, conclude, follow};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::passes::values::Trust;
use std::collections::BTreeMap;
use std::time::Duration;

/// The times of all programs here, in microseconds.
const TIMES: &str =
    "Op1,1,0,0\nOp2,2,0,0\nOp4,4,0,0\nOp8,8,0,0\nOp16,16,0,0\nOp32,32,0,0\nFMOV,0,0,0.0001\n";

fn bound(text: &str, facts: &str, trust: Trust) -> Result<Audit, Failure> {
    let (inputs, table) = (listed(text.replace("; ", "\n") + "\n"), table(TIMES));
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    audit(&asked(&inputs, &table, &facts, trust))
}

fn advised(text: &str, facts: &str, settings: AdviceSettings<'_>) -> (Advice, Picos) {
    let (inputs, table) = (listed(text.replace("; ", "\n") + "\n"), table(TIMES));
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    let request = asked(&inputs, &table, &facts, Trust::Counts);
    let concluded = conclude(follow(&request).expect("a model"), &request).expect("an audit");
    (advise(&concluded, &request, settings).expect("advice"), concluded.audit.bound.upper)
}

const ALL: AdviceSettings<'_> = AdviceSettings { most: &[20, 3], budget: None };

/// A count, a pair that nothing keeps apart, and steps that only the program writes.
const TEXT: &str = "LD X0; FMOV K0 D1000 D50; \
    LD M10; Op16; LD M11; Op8; \
    LDI M0; ANI M1; AND X1; SET M0; LD M0; AND X2; SET M1; RST M0; LD M1; AND X3; RST M1; \
    LD M0; AND M1; Op32; END";

#[test]
fn each_bound_is_that_of_an_audit_with_the_line() {
    let own = "[counts]\nD51 = [0, 9]\n";
    for facts in ["", own, "[exclusive]\nsets = [[\"X0\", \"M10\"]]\n"] {
        let (advice, upper) =
            advised(&TEXT.replace("END", "LD X5; FMOV K0 D1000 D51; END"), facts, ALL);
        assert_eq!(advice.upper, Some(upper));
        assert_eq!(advice.untried, 0);
        let kinds: Vec<AdviceKind> = advice.found.iter().map(|one| one.statement.kind).collect();
        for kind in [AdviceKind::Count, AdviceKind::Exclusive, AdviceKind::Internal] {
            assert!(kinds.contains(&kind), "{kind:?} of {kinds:?} with {facts}");
        }
        assert!(advice.found.windows(2).all(|two| two[0].bound.upper <= two[1].bound.upper));
        for one in &advice.found {
            // The line goes into its table; one that states more of the same key takes its place.
            let mut tables: BTreeMap<String, Vec<String>> = BTreeMap::new();
            let mut table = String::new();
            for line in facts.lines() {
                match line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
                    Some(name) => table = name.to_owned(),
                    None => tables.entry(table.clone()).or_default().push(line.to_owned()),
                }
            }
            let lines = tables.entry(one.statement.table.to_owned()).or_default();
            if one.statement.table != "counts" {
                lines.clear();
            }
            lines.push(one.statement.line.clone());
            let stated: String = tables
                .iter()
                .map(|(name, lines)| format!("[{name}]\n{}\n", lines.join("\n")))
                .collect();
            let text = TEXT.replace("END", "LD X5; FMOV K0 D1000 D51; END");
            let alone = bound(&text, &stated, Trust::Counts).expect("an audit");
            assert_eq!(one.bound.upper, alone.bound.upper, "{stated}");
            assert!(one.bound.upper < upper, "{stated}");
        }
    }
}

#[test]
fn the_pair_that_pays_most_comes_first_and_what_gates_the_same_is_no_pair() {
    // M1 and M2 run Op32 and Op16, M3 runs Op1; X0 is needed for all, X1 with it for nothing else.
    let text = "LD X0; AND X1; MPS; AND M1; Op32; MRD; AND M2; Op16; MPP; AND M3; Op1; END";
    let (advice, _) = advised(text, "", AdviceSettings { most: &[20], budget: None });
    let lines: Vec<&str> = advice.found.iter().map(|one| one.statement.line.as_str()).collect();
    assert_eq!(
        lines,
        ["sets = [[\"M1\", \"M2\"]]", "sets = [[\"M1\", \"M3\"]]", "sets = [[\"M2\", \"M3\"]]",]
    );
    let uppers: Vec<u64> = advice.found.iter().map(|one| one.bound.upper.0 / 1_000_000).collect();
    assert_eq!(uppers, [33, 48, 48]);
    let places: Vec<&str> =
        advice.found[0].statement.places.iter().map(|(_, text)| &**text).collect();
    assert_eq!(places, ["Op32", "Op16"]);
}

#[test]
fn a_budget_ends_the_asking_and_says_so() {
    let none = AdviceSettings { most: &[20], budget: Some(Duration::ZERO) };
    let (advice, _) = advised(TEXT, "", none);
    assert!(advice.found.is_empty() && advice.untried > 1 && advice.useless == 0);
    // Where all is known there is nothing to ask.
    let (advice, upper) = advised("LD X0; Op1; END", "", ALL);
    assert_eq!((advice.found.len(), advice.untried, advice.upper), (0, 0, Some(upper)));
}

/// Rungs as the inputs that must be on, those that must be off, and what they cost in microseconds.
const RUNGS: [(u32, u32, u64); 6] = [
    (0b0001, 0, 8),
    (0b0010, 0, 4),
    (0b0100, 0b0001, 2),
    (0b1001, 0, 1),
    (0b0110, 0, 16),
    (0b1000, 0b0010, 32),
];

#[test]
fn bits_that_exclude_each_other_leave_the_scans_that_there_are() {
    let names = ["X0", "M5", "D7.3", "X1F"];
    let mut lines = Vec::new();
    for (on, off, cost) in RUNGS {
        let bits = (0..4).filter(|bit| (on | off) >> bit & 1 == 1);
        for (place, bit) in bits.enumerate() {
            let begin = if place == 0 { "LD" } else { "AN" };
            let negated = off >> bit & 1 == 1;
            let end = match (place, negated) {
                (0, true) => "I",
                (0, false) => "",
                (_, true) => "I",
                (_, false) => "D",
            };
            lines.push(format!("{begin}{end} {}", names[bit]));
        }
        lines.push(format!("Op{cost}"));
    }
    lines.push("END".to_owned());
    let text = lines.join("; ");
    let pairs: Vec<(usize, usize)> =
        (0..4).flat_map(|one| (one + 1..4).map(move |other| (one, other))).collect();
    let cost = |start: u32| -> u64 {
        let runs = |&&(on, off, _): &&(u32, u32, u64)| start & on == on && start & off == 0;
        RUNGS.iter().filter(runs).map(|(.., cost)| cost * 1_000_000).sum()
    };
    for stated in 0..1u32 << pairs.len() {
        let stated: Vec<&(usize, usize)> = pairs
            .iter()
            .enumerate()
            .filter(|(n, _)| stated >> n & 1 == 1)
            .map(|(_, pair)| pair)
            .collect();
        let keeps = |start: &u32| {
            stated.iter().all(|(one, other)| start >> one & 1 == 0 || start >> other & 1 == 0)
        };
        let longest = (0..16).filter(keeps).map(cost).max().expect("all off is a start");
        let sets: Vec<String> = stated
            .iter()
            .map(|(one, other)| format!("[{:?}, {:?}]", names[*one], names[*other]))
            .collect();
        let facts = format!("[exclusive]\nsets = [{}]\n", sets.join(", "));
        let found = bound(&text, &facts, Trust::Counts).expect("an audit");
        assert_eq!((found.bound.upper.0, found.bound.lower.0), (longest, longest), "{facts}");
        assert_eq!(found.facts.len(), stated.len(), "each is listed");
    }
    // A set of four is all of its pairs.
    let facts = "[exclusive]\nsets = [[\"X0\", \"M5\", \"D7.3\", \"X1F\"]]\n";
    let found = bound(&text, facts, Trust::Counts).expect("an audit");
    let longest = [1, 2, 4, 8].map(cost).into_iter().max().expect("one on");
    assert_eq!(found.bound.upper.0, longest);
}

#[test]
fn what_is_no_bit_or_no_set_is_refused() {
    let refused = |sets: &str| {
        let facts = format!("[exclusive]\nsets = {sets}\n");
        match bound("LD X0; Op1; END", &facts, Trust::Counts) {
            Err(Failure::Input(faults)) => {
                assert!(faults.iter().all(|fault| fault.code == Code::Fact), "{faults:?}");
                faults.iter().map(|fault| fault.message.clone()).collect::<Vec<_>>().join("; ")
            }
            other => panic!("{sets}: {other:?}"),
        }
    };
    assert_eq!(
        refused("[[\"X0\", \"Q7\"]]"),
        "'Q7' under [exclusive] is not a bit that scanbound knows by this name"
    );
    assert_eq!(
        refused("[[\"X0\", \"D0\"]]"),
        "'D0' under [exclusive] is not a bit that scanbound knows by this name"
    );
    assert_eq!(
        refused("[[\"X0\", \"D0.G\"]]"),
        "'D0.G' under [exclusive] is not a bit that scanbound knows by this name"
    );
    assert_eq!(refused("[[\"X0\", \"x0\"]]"), "'x0' occurs twice in a set of [exclusive]");
    for bad in ["[[\"X0\"]]", "[\"X0\", \"X1\"]", "[[1, 2]]", "7"] {
        let faults =
            Facts::parse("f.toml", &format!("[exclusive]\nsets = {bad}\n")).expect_err(bad);
        assert_eq!(faults[0].message, "sets must be a list of lists, each with at least two bits");
    }
    assert!(Facts::parse("f.toml", "[exclusive]\nset = [[\"X0\", \"X1\"]]\n").is_err());
}

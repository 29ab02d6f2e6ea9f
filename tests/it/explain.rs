//! What is told of instructions is what audits do with them, and every code that can be met is told of.

use crate::command::binary;
use scanbound::audit::explain::{Follow, explain, names};
use scanbound::audit::{Request, audit};
use scanbound::base::code::Code;
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::{FRONTS, Input};
use scanbound::report::page;
use scanbound::timing::table::{Table, builtin};
use std::collections::BTreeSet;

fn table(name: &str) -> Table {
    Table::builtin(name).expect("a built-in table")
}

#[test]
fn a_line_takes_what_an_audit_of_it_charges() {
    let facts = Facts::default();
    for (name, cpu) in
        [("BMOV", "qnudv"), ("MOV", "q02"), ("DMOVP", "l26"), ("BCD", "fx3u"), ("WSUM", "iqr")]
    {
        let found = explain(name, &table(cpu), FRONTS).expect(name);
        for form in &found.forms {
            // The larger of the two times is what the sum of all charges has beyond that without the line.
            let mut own = table(cpu);
            own.factor = None;
            let sum = |text: String| {
                let inputs = [Input { name: "a.il".to_owned(), bytes: text.into_bytes() }];
                let request = Request {
                    table: Some(&own),
                    dialect: Some("melsec-list"),
                    ..Request::new(&inputs, &facts)
                };
                let charged = audit(&request).expect("an audit");
                let groups = charged.groups.iter().flat_map(|group| &group.charges);
                groups
                    .chain(&charged.always)
                    .filter(|one| *one.instruction == *form.line)
                    .map(|one| one.on)
                    .sum::<Picos>()
            };
            let price = form.price.as_ref().expect("a time");
            assert_eq!(
                sum(format!("LD X0\n{}\nEND\n", form.line)),
                price.on,
                "{} by {cpu}",
                form.line
            );
        }
    }
}

#[test]
fn what_is_followed_is_told_of_every_kind() {
    let q = table("qnudv");
    let follow = |name: &str| explain(name, &q, FRONTS).expect(name).forms[0].follow;
    assert_eq!(follow("MOV"), Follow::Exactly);
    assert_eq!(follow("LD"), Follow::Exactly);
    assert_eq!(follow("OUT"), Follow::Exactly);
    // Rows of the table in docs/values.md that the bound's model does not carry out.
    for name in ["LIMIT", "SUM", "BCD", "/"] {
        assert_eq!(follow(name), Follow::Range, "{name}");
    }
    // "All else", of which real runs know what it does.
    for name in ["SWAP", "DECO"] {
        assert!(follow(name) > Follow::Range, "{name}");
    }
    assert_eq!(follow("SIN"), Follow::Unknown);
    assert_eq!(follow("NOP"), Follow::Nothing);
    // What becomes of condition flags is not what is asked.
    let cs = explain("MOV", &table("cj2m"), FRONTS).expect("MOV");
    assert_eq!(cs.forms[0].follow, Follow::Exactly);
}

#[test]
fn every_instruction_that_is_known_can_be_told_of() {
    let tables: Vec<Table> = builtin::names().into_iter().map(table).collect();
    let mut silent = Vec::new();
    for name in names(FRONTS) {
        let told = tables.iter().filter_map(|table| explain(&name, table, FRONTS));
        if !told.into_iter().any(|one| !one.forms.is_empty()) {
            silent.push(name);
        }
    }
    // What stands in frames of its own is told of by its variants.
    assert!(silent.len() < 60, "{} have no line that shows them: {silent:?}", silent.len());
    assert!(explain("NOTHING", &tables[0], FRONTS).is_none());
}

#[test]
fn variants_are_told() {
    let found = explain("BMOV", &table("qnudv"), FRONTS).expect("BMOV");
    assert!(found.variants.contains(&"BMOVP".to_owned()), "{:?}", found.variants);
    let found = explain("MOV", &table("qnudv"), FRONTS).expect("MOV");
    for variant in ["DMOV", "MOVP", "EMOV", "DMOVP"] {
        assert!(found.variants.iter().any(|one| one == variant), "{variant}: {:?}", found.variants);
    }
    let found = explain("DMOVP", &table("qnudv"), FRONTS).expect("DMOVP");
    assert!(found.variants.contains(&"DMOV".to_owned()), "{:?}", found.variants);
}

#[test]
fn every_code_has_a_page_that_says_what_to_do() {
    let all: Vec<&str> = page::names().collect();
    assert_eq!(all.len(), all.iter().collect::<BTreeSet<_>>().len(), "none is there twice");
    for code in Code::ALL {
        assert!(all.contains(&code.name()));
    }
    for name in all {
        let text = page::of(name).expect(name);
        assert!(text.starts_with(&format!("# {name}\n")), "{name}");
        for part in ["\n## Example\n\n", "\n## What to do\n\n"] {
            let (_, rest) = text.split_once(part).unwrap_or_else(|| panic!("{name} has {part}"));
            assert!(rest.trim().len() > 10, "{name}");
        }
    }
    assert!(page::of("nothing").is_none());
}

/// What a command's SARIF log names as its rules.
fn rules(arguments: &[&str]) -> BTreeSet<String> {
    let output =
        binary().args(arguments).args(["--format", "sarif"]).output().expect("the program starts");
    let log: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let results = log["runs"][0]["results"].as_array().expect("results");
    results.iter().map(|one| one["ruleId"].as_str().expect("a rule").to_owned()).collect()
}

#[test]
fn every_rule_of_a_log_is_told_of() {
    let mut met = rules(&["check", "samples/recipes", "--limit", "1us"]);
    met.extend(rules(&["check", "samples/recipes", "--limit", "1s"]));
    met.extend(rules(&["audit", "samples/filler"]));
    met.extend(rules(&["diff", "samples/filler/MAIN.csv", "samples/filler/SUB.csv"]));
    for rule in &met {
        assert!(page::of(rule).is_some(), "{rule}");
    }
    assert!(met.len() >= 7, "{met:?}");
}

//! Times and what the user states of the plant, from the source text to the bound and the verdict.

use scanbound::audit::{Audit, Evidence, Request, audit};
use scanbound::dialect::Input;
use scanbound::facts::Facts;
use scanbound::solve::Method;
use scanbound::table::Table;
use scanbound::time::Picos;

/// Rungs with every kind of charge, and points of both sides.
const PROGRAM: &str = "LD X0\nMOV D0 D1\nLDI X0\nOUT Y0\nLD M0\nBMOV D0 D10 K5\nEND\n";

fn table(rows: &str) -> Table {
    let text = format!("instruction,on_us,off_us,per_unit_us,unit,evidence,source\n{rows}");
    Table::parse("own.csv", text.as_bytes()).expect("a table").table
}

fn audited(text: &str, table: &Table, facts: &str) -> Audit {
    let inputs = [Input { name: "a.il".to_owned(), bytes: text.as_bytes().to_vec() }];
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    let request = Request {
        inputs: &inputs,
        dialect: None,
        cpu: None,
        table: Some(table),
        times: &[],
        clock: None,
        facts: &facts,
        strict_times: false,
        method: Method::Auto,
        trace: false,
        confirm: false,
        time_limit: None,
        limit: None,
        warnings: &[],
        cancelled: &|| false,
        progress: &|_| {},
    };
    audit(&request).expect("an audit")
}

#[test]
fn a_factor_is_a_part_of_the_bound_and_assumed_where_it_is() {
    for evidence in ["assumed", "published"] {
        let own = table(&format!("@base,qnudv\n@factor,1.2345,,,,{evidence},why\n"));
        let audit = audited(PROGRAM, &own, "");
        let factor = audit.table.factor.as_ref().expect("a factor");
        let parts = [audit.bound.always].into_iter();
        let parts = parts.chain(audit.overhead.iter().map(|term| term.time));
        let parts = parts.chain(audit.groups.iter().map(|group| group.upper));
        let bare: Picos = parts.map(|time| audit.bare(time)).sum();
        assert_eq!(bare + factor.part, audit.bound.upper);
        let share = u128::from(factor.part.0) * 12_345 / (u128::from(audit.bound.upper.0) * 2_345);
        assert!(factor.part > Picos::ZERO && share <= 1, "{share}");
        let row = audit.table.assumed.iter().find(|one| one.row == "@factor");
        assert_eq!(row.is_some(), evidence == "assumed");
        let sum: Picos = audit.table.assumed.iter().map(|one| one.time).sum();
        assert_eq!(sum, audit.table.assumed_time);
        let text = scanbound::report::text::render(&audit, None, Default::default());
        assert!(text.contains("factor 1.2345"), "{text}");
        let csv = scanbound::report::csv::render(&audit);
        assert!(csv.contains(&format!("factor 1.2345,,,,,,,{evidence},@factor,factor,")), "{csv}");
        let json = scanbound::report::json::render(&audit, None);
        assert!(json.contains(&format!("\"ps\": {}", factor.part.0)), "{json}");
    }
    // All that a scan takes beyond its one published time is the factor's.
    let own =
        table("@factor,1.25,,,,assumed,why\n@end,80,,,,published,page\nLD,0,0\nOUT,0,0\nEND,0,0\n");
    let audit = audited("LD X0\nOUT M0\nEND\n", &own, "");
    assert_eq!(audit.bound.upper, Picos(100_000_000));
    assert_eq!(audit.table.assumed_time, Picos(20_000_000));
    assert_eq!(audit.overhead[0].evidence, Evidence::Published);
}

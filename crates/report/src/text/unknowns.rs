//! What the bound depends on and nobody stated, and how much stating it lowers the bound.

use super::style::FAINT;
use super::words::{heading, item, more, place};
use crate::columns::{Cell, fitted, left, right};
use crate::format::Extent;
use scanbound_audit::{Audit, Counts, SolvedBound, Unknown};
use scanbound_base::time_text::{about, at_most};
use std::cmp::Reverse;

/// What is not known and what to state of it: counts, then where is written.
pub(super) fn unknowns(audit: &Audit, extent: Extent) -> String {
    if audit.unknowns.is_empty() {
        return String::new();
    }
    let solve = match audit.what_if {
        Some(_) => "",
        None => "--what-if solves the bound for counts and indices of at most 20 and 100",
    };
    counts(audit, extent)
        + &indices(audit, extent)
        + &item(2, solve, extent)
        + &solved(audit, extent)
}

fn counts(audit: &Audit, extent: Extent) -> String {
    let counted = || audit.unknowns.iter().filter_map(|one| Some((one, one.counts()?)));
    let Some((first, _)) = counted().next() else { return String::new() };
    let row = |(one, counts): (&Unknown, &Counts)| {
        let each = about(counts.each);
        vec![
            right(about(counts.cost)),
            left(place(audit, one.places[0].0)),
            left(instruction(one)),
            left(format!("{} assumed up to {}, {each} each", one.word, counts.most)).styled(FAINT),
        ]
    };
    let mut all: Vec<(&Unknown, &Counts)> = counted().collect();
    all.sort_by_key(|(_, counts)| Reverse(counts.cost));
    let rows: Vec<Vec<Cell>> = all.into_iter().take(extent.values).map(row).collect();
    heading("The bound depends on unstated counts, the largest time first", extent)
        + &fitted(2, &rows, extent.width)
        + &more(counted().count(), extent.values, "count", "counts")
        + &item(2, "say in a facts file (--facts) what they are, such as at most 20:", extent)
        + &format!("      [counts]\n      {}\n", first.fact)
}

/// Where it is not known where is written.
fn indices(audit: &Audit, extent: Extent) -> String {
    let far = || audit.unknowns.iter().filter(|one| one.counts().is_none());
    if far().next().is_none() {
        return String::new();
    }
    let row = |one: &Unknown| {
        vec![
            left(place(audit, one.places[0].0)),
            left(instruction(one)),
            left(format!("{}{}", one.word, one.origin())).styled(FAINT),
        ]
    };
    let rows: Vec<Vec<Cell>> = far().take(extent.values).map(row).collect();
    let facts = far().take(extent.values).map(|one| format!("      {}\n", one.fact));
    heading("It is not known where these write: any such device may hold anything then", extent)
        + &fitted(2, &rows, extent.width)
        + &more(far().count(), extent.values, "place", "places")
        + &item(2, "say in a facts file (--facts) how far, such as:", extent)
        + "      [index]\n"
        + &facts.collect::<String>()
}

/// The first instruction, and how many others there are.
fn instruction(one: &Unknown) -> String {
    match one.places.len() {
        1 => one.places[0].1.to_string(),
        n => format!("{} and {} more", one.places[0].1, n - 1),
    }
}

/// The bounds where these counts are stated, and those that are named then.
fn solved(audit: &Audit, extent: Extent) -> String {
    let Some(what_if) = audit.what_if.as_ref().filter(|one| !one.steps.is_empty()) else {
        return String::new();
    };
    let mut head = vec![left("")];
    head.extend(what_if.most.iter().map(|most| right(format!("at most {most}"))));
    let any_cut = what_if.steps.iter().flat_map(|step| &step.solved).flatten().any(|one| one.cut);
    let mark = |one: &SolvedBound| match one.cut {
        true => " *",
        false if any_cut => "  ",
        false => "",
    };
    let rows = what_if.steps.iter().enumerate().map(|(index, step)| {
        let and = if index == 0 { "" } else { "and " };
        let unknown = &step.unknown;
        let mut row = vec![left(format!("{and}{}", unknown.word))];
        row.extend(step.solved.iter().map(|bound| match bound {
            Some(bound) => right(at_most(bound.upper) + mark(bound)),
            None => right("cannot be"),
        }));
        row.push(left(place(audit, unknown.places[0].0)).styled(FAINT));
        row
    });
    let rows: Vec<Vec<Cell>> = [head].into_iter().chain(rows).collect();
    let limit = match any_cut {
        true => "* or less: the time limit ended that audit; a longer --time-limit may find less",
        false => "",
    };
    heading("The bound where these are stated, each together with those above it", extent)
        + &fitted(2, &rows, extent.width)
        + &item(2, limit, extent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_audit::fixture::fixture;
    use scanbound_audit::{LimitedCount, WhatIf};
    use scanbound_base::time::Picos;

    #[test]
    fn a_bound_that_the_time_limit_cut_is_marked() {
        let mut audit = fixture();
        let unknown = audit.unknowns[0].clone();
        let told = |audit: &Audit| {
            let text = solved(audit, Extent::default());
            anstream::adapter::strip_str(&text).to_string()
        };
        for (cut, marks) in [(false, 0), (true, 2)] {
            let bound = |ms: u64, cut| Some(SolvedBound { upper: Picos(ms * 1_000_000_000), cut });
            let step = LimitedCount {
                unknown: unknown.clone(),
                solved: vec![bound(20, false), bound(30, cut)],
            };
            let steps = vec![step];
            audit.what_if = Some(WhatIf { most: vec![20, 100], steps, minor: None, own: None });
            let text = told(&audit);
            assert!(text.contains("20 ms") && text.contains("30 ms"), "{text}");
            // Beside the bound, and in the line that says what it means.
            assert_eq!(text.matches('*').count(), marks, "{text}");
            assert_eq!(text.contains("30 ms *"), cut, "{text}");
        }
    }
}

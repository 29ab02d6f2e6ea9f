//! How much of the source is followed exactly, by language, and what keeps the rest from it.

use super::words::{capped, count, heading, item, more, place, wrapped};
use crate::audit::{Audit, Construct, InexactUse, LanguageUse, Share};
use crate::base::time::Picos;
use crate::report::columns::{Cell, fitted, left, right};
use crate::report::format::{Detail, Extent};

/// So many constructs are told, and of each so many places, unless all are asked for.
const MOST_KINDS: usize = 5;
const MOST_PLACES: usize = 3;

pub(super) fn section(audit: &Audit, extent: Extent) -> String {
    let Some(found) = &audit.exactness else { return String::new() };
    let (statements, exact) = found.total();
    let title = match statements - exact {
        0 => format!("Followed exactly: all {statements} statements"),
        _ => format!(
            "Followed exactly: {exact} of {statements} statements ({})",
            share(exact, statements)
        ),
    };
    let rows: Vec<Vec<Cell>> = found.languages.iter().map(language).collect();
    let mut text = heading(&title, extent) + &fitted(2, &rows, extent.width);
    let is_full = extent.detail == Detail::Full;
    let all = found.constructs.len();
    let shown = if is_full { all } else { extent.values.min(MOST_KINDS).min(all) };
    for one in &found.constructs[..shown] {
        text += &construct(audit, one, is_full, extent);
    }
    text += &more(all, shown, "construct", "constructs");
    for (body, why) in &found.unread {
        text += &item(2, &format!("{body} is not read, and not called: {why}"), extent);
    }
    text
}

/// A part of a whole, in percent.
fn share(part: u64, whole: u64) -> Share {
    Share::of(Picos(part), Picos(whole))
}

fn language(one: &LanguageUse) -> Vec<Cell> {
    let LanguageUse { language, called, uncalled, statements, exact } = *one;
    let mut bodies = match called {
        1 => "in 1 body".to_owned(),
        called => format!("in {called} bodies"),
    };
    if uncalled > 0 {
        bodies += &format!("; {uncalled} more that nothing calls");
    }
    let part = match statements {
        0 => String::new(),
        _ => share(exact, statements).to_string(),
    };
    vec![
        left(language),
        right(exact.to_string()),
        left("of"),
        right(statements.to_string()),
        right(part),
        left(bodies),
    ]
}

fn construct(audit: &Audit, one: &Construct, is_full: bool, extent: Extent) -> String {
    let told = |at: &InexactUse| format!("{} ({})", place(audit, at.at), at.body);
    let places: Vec<String> = one.places.iter().map(told).collect();
    let most = if is_full { usize::MAX } else { MOST_PLACES };
    let number = usize::try_from(one.statements).unwrap_or(usize::MAX);
    let what = format!("{}: {}", count(number, "statement", "statements"), one.what);
    item(2, &what, extent) + &wrapped("      ", &capped(&places, most), extent)
}

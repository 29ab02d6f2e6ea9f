//! How much of the source is followed exactly, by language, and what keeps the rest from it.

use super::words::{capped, count, heading, item, more, place, wrapped};
use crate::columns::{Cell, fitted, left, right};
use crate::format::{Detail, Extent};
use scanbound_audit::{Audit, Construct, InexactUse, LanguageUse, Share};
use scanbound_base::time::Picos;

/// So many constructs are told, and of each so many places, unless all are asked for.
const MAX_KINDS: usize = 5;
const MAX_PLACES: usize = 3;

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
    let shown = if is_full { all } else { extent.values.min(MAX_KINDS).min(all) };
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
    let most = if is_full { usize::MAX } else { MAX_PLACES };
    let number = usize::try_from(one.statements).unwrap_or(usize::MAX);
    let what = format!("{}: {}", count(number, "statement", "statements"), one.what);
    item(2, &what, extent) + &wrapped("      ", &capped(&places, most), extent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_audit::Exactness;
    use scanbound_audit::fixture::fixture;
    use scanbound_base::location::Location;

    /// Constructs that keep 7, 6, 5, ... statements from being followed exactly.
    fn found(constructs: u64) -> Audit {
        let place = |line| InexactUse {
            at: Location { file: 0, line, step: None },
            body: "main".to_owned(),
            text: "x := y;".into(),
        };
        let constructs: Vec<Construct> = (0..constructs)
            .map(|at| Construct {
                what: format!("construct {at}"),
                statements: 7 - at,
                places: (1..8 - u32::try_from(at).unwrap_or(0)).map(place).collect(),
            })
            .collect();
        let open: u64 = constructs.iter().map(|one| one.statements).sum();
        let language = |language, called, uncalled, statements, exact| LanguageUse {
            language,
            called,
            uncalled,
            statements,
            exact,
        };
        let languages = vec![
            language("ST", 3, 2, 100, 100 - open),
            language("SFC", 1, 0, 12, 12),
            language("LD", 0, 1, 0, 0),
        ];
        let unread = vec![("other".to_owned(), "it is drawn".to_owned())];
        Audit { exactness: Some(Exactness { languages, constructs, unread }), ..fixture() }
    }

    #[test]
    fn the_most_frequent_constructs_are_told_and_all_with_every_detail() {
        let short = section(&found(7), Extent::default());
        let plain = anstream::adapter::strip_str(&short).to_string();
        let expected = "
Followed exactly: 84 of 112 statements (75.0 %)
  ST   72  of  100   72.0 %  in 3 bodies; 2 more that nothing calls
  SFC  12  of   12  100.0 %  in 1 body
  LD    0  of    0           in 0 bodies; 1 more that nothing calls
  7 statements: construct 0
      ";
        assert!(plain.starts_with(expected), "{plain}");
        assert!(plain.contains("and 4 more") && plain.contains("construct 4"), "{plain}");
        assert!(plain.contains("and 2 constructs (-v)") && !plain.contains("construct 5"));
        assert!(plain.ends_with("other is not read, and not called: it is drawn\n"), "{plain}");
        let full = Extent { detail: Detail::Full, ..Extent::default() };
        let full = section(&found(7), full);
        assert!(full.contains("construct 6") && !full.contains("more\n"), "{full}");
    }

    #[test]
    fn where_nothing_is_left_it_is_one_line_and_none_for_other_dialects() {
        let all = section(&found(0), Extent::default());
        assert!(all.contains("Followed exactly: all 112 statements"), "{all}");
        assert_eq!(section(&fixture(), Extent::default()), "");
    }
}

//! An audit as text for people: a screen that answers, and behind it what the answer rests on.

mod approximated;
mod bound;
mod exactness;
mod exclusion;
mod founded;
mod net;
pub(super) mod next;
pub(super) mod parts;
mod scan;
pub(super) mod screen;
mod style;
mod unknowns;
pub(super) mod verdict;
mod watchdog;
pub(super) mod words;

use super::columns::paint;
use super::format::{Detail, Extent, Format, InARow};
use super::{compare, diff, response};
use scanbound_audit::Audit;
use scanbound_audit::verdict::{Check, Verdict};
pub(super) use words::place;
use words::{list, warnings};

/// Text to be read.
pub const FORMAT: Format = Format {
    name: "text",
    about: "To be read",
    suffixes: &["txt"],
    draws: false,
    escapes: false,
    audit: |audit, check, extent, out| out.write_all(render(audit, check, extent).as_bytes()),
    compare: |found, out| out.write_all(compare::text::render(found).as_bytes()),
    diff: |found, extent, out| out.write_all(diff::text::render(found, extent).as_bytes()),
    checks: || {
        Box::new(InARow {
            heading: |file| format!("{}\n", paint(style::BOLD, file)),
            fault: |what| format!("error: {what}\n"),
            audit: FORMAT.audit,
        })
    },
    tells_faults: false,
};

/// The audit, headed by the check's answer if there is one. Has colour codes.
#[must_use]
pub fn render(audit: &Audit, check: Option<&Check>, extent: Extent) -> String {
    let mut text = screen::first(audit, check, extent);
    if let Some(by) = extent.by {
        text += &parts::asked(audit, by, extent);
    }
    if extent.detail == Detail::Short {
        if check.is_some_and(|check| check.verdict == Verdict::Refuted) {
            text += &super::path::loops(audit);
            text += &scan::conditions(audit, extent);
            text += &scan::run(audit, extent);
        }
    } else {
        text += &sections(audit, extent);
    }
    if text.lines().count() >= extent.height {
        // What has scrolled away is said once more.
        text += &format!("\n{}", answer(audit, check, extent));
    }
    text
}

/// The answer alone: a check's verdict, or the bound.
#[must_use]
pub fn answer(audit: &Audit, check: Option<&Check>, extent: Extent) -> String {
    verdict::answer(audit, check).lines(extent.width)
}

/// All behind the first screen.
fn sections(audit: &Audit, extent: Extent) -> String {
    let doubts: Vec<String> = audit.all_doubts().iter().map(ToString::to_string).collect();
    let mut text = unknowns::unknowns(audit, extent);
    text += &response::section(audit, extent.width);
    text += &super::path::loops(audit);
    text += &bound::exact(audit, extent);
    text += &bound::groups(audit, extent);
    text += &net::section(audit, extent);
    text += &exclusion::excluded(audit, extent);
    if extent.detail == Detail::Full {
        for group in audit.main_groups(extent.top).0 {
            text += &exclusion::group(audit, group, extent);
        }
    }
    text += &scan::conditions(audit, extent);
    text += &scan::run(audit, extent);
    text += &super::path::path(audit);
    text += &founded::assumed(audit, extent);
    let notes: Vec<String> =
        audit.table.notes.iter().cloned().chain(watchdog::unstated(audit)).collect();
    text += &list("What the table's times do not hold", &notes, extent);
    text += &list("What was stated and is believed", &founded::facts(audit), extent);
    text += &founded::trusted(audit, extent);
    text += &list("Left open: what is not stated may make the bound too low", &doubts, extent);
    text += &exactness::section(audit, extent);
    text += &approximated::approximations(audit, extent);
    text + &list("Warnings", &warnings(audit), extent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_audit::fixture::fixture;
    use scanbound_audit::verdict::Margin;
    use scanbound_base::time::Picos;

    fn plain(audit: &Audit, check: Option<&Check>, extent: Extent) -> String {
        anstream::adapter::strip_str(&render(audit, check, extent)).to_string()
    }

    fn short(audit: &Audit, check: &Check) -> String {
        let extent = Extent { detail: Detail::Short, top: 0, ..Extent::default() };
        render(audit, Some(check), extent)
    }

    #[test]
    fn the_fixture_as_text() {
        insta::assert_snapshot!(plain(&fixture(), None, Extent::default()));
    }

    #[test]
    fn the_fixture_in_full() {
        let extent = Extent { detail: Detail::Full, ..Extent::default() };
        insta::assert_snapshot!(plain(&fixture(), None, extent));
    }

    #[test]
    fn the_fixture_in_short_keeps_to_a_screen() {
        let extent = Extent { detail: Detail::Short, ..Extent::default() };
        let text = plain(&fixture(), None, extent);
        assert!(text.lines().count() < extent.height, "{text}");
        insta::assert_snapshot!(text);
    }

    #[test]
    fn no_line_is_wider_than_the_page() {
        use unicode_width::UnicodeWidthStr;
        for width in [76, 80, 120] {
            let extent = Extent { detail: Detail::Full, width, ..Extent::default() };
            let text = plain(&fixture(), None, extent);
            for line in text.lines() {
                assert!(line.width() <= width, "{width}: {line}");
            }
        }
    }

    #[test]
    fn an_exact_and_short_report() {
        let mut audit = fixture();
        audit.bound.lower = audit.bound.upper;
        audit.table.assumed.clear();
        let extent = Extent { top: 1, values: 1, ..Extent::default() };
        insta::assert_snapshot!(plain(&audit, None, extent));
    }

    #[test]
    fn the_answers_of_a_check() {
        let mut audit = fixture();
        let margin: Margin = "10%".parse().expect("a margin");
        let mut answers = String::new();
        for (limit, doubts) in [(600, true), (300, true), (460, true), (600, false)] {
            if !doubts {
                audit.doubts.clear();
            }
            let check = Check::new(&audit, Picos(limit * 1_000_000), margin);
            answers += &anstream::adapter::strip_str(&short(&audit, &check)).to_string();
        }
        insta::assert_snapshot!(answers);
    }

    #[test]
    fn a_bound_that_rests_on_assumed_times_alone_is_not_said_to_be_too_low() {
        let mut audit = fixture();
        let told = |audit: &Audit| {
            let check = Check::new(audit, Picos(600_000_000), Margin::default());
            let check = check.if_assumed_at_most(audit, "0%".parse().expect("a share"));
            anstream::adapter::strip_str(&short(audit, &check)).to_string()
        };
        let one_line = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(one_line(told(&audit)).contains(", but may be too low "));
        audit.doubts.clear();
        let alone = "; but more of it than is allowed rests on assumed times ";
        assert!(one_line(told(&audit)).contains(alone));
        // The answer by itself announces nothing that does not follow.
        let check = Check::new(&audit, Picos(600_000_000), Margin::default());
        let check = check.if_assumed_at_most(&audit, "0%".parse().expect("a share"));
        assert!(!answer(&audit, Some(&check), Extent::default()).trim_end().ends_with(':'));
    }
}

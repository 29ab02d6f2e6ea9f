//! The bound to the picosecond, how it was found, and its groups.

use super::style::{BAD, BOLD, CARE, FAINT};
use super::words::{count, heading, place};
use crate::columns::{Cell, fitted, left, right};
use crate::format::Extent;
use crate::method;
use scanbound_audit::{Audit, Evidence, Share};
use scanbound_base::time::Picos;
use scanbound_base::time_text::Scale;

/// The bound, the longest scan found, the structural bound, and which search it was.
pub(super) fn exact(audit: &Audit, extent: Extent) -> String {
    let bound = &audit.bound;
    let time = |time: Picos| right(time.text_like(bound.naive));
    let reached = match audit.is_reached() {
        true => "; a run from power-up leads to it",
        false => "; nothing excludes that a scan starts so, no run from power-up to it was found",
    };
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut row =
        |name: &str, time: Cell, what: String| rows.push(vec![left(name), time, left(what)]);
    if !audit.unbounded.is_empty() {
        row(
            "longest scan",
            right("unbounded").styled(BAD),
            match audit.is_endless() {
                true => "a scan can go round a loop without end".to_owned(),
                false => "nothing is known that ends a loop".to_owned(),
            },
        );
        row(
            "cut off",
            time(bound.upper),
            "at most, if each scan ends where it comes to such a loop".to_owned(),
        );
    } else if audit.possible() == bound.upper {
        let what = match audit.uncounted_doubts().is_empty() {
            true => {
                let points = match audit.upper_with_all_points() > bound.upper {
                    true => " with the points that the program names",
                    false => "",
                };
                format!(
                    "exact{points}: a scan that takes this long was found and replayed{reached}"
                )
            }
            false => format!(
                "a scan that takes this long was found and replayed{reached}; one that takes longer is not excluded, since not all that counts is stated"
            ),
        };
        row("longest scan", time(bound.upper).styled(BOLD), what);
    } else {
        row("longest scan", time(bound.upper).styled(BOLD), at_most_told(audit).to_owned());
        let what = format!("at least: a scan that takes this long was found and replayed{reached}");
        row("", time(audit.possible()).styled(BOLD), what);
    }
    if !audit.needed_devices.is_empty() {
        let all =
            audit.needed_devices.iter().map(|(name, least)| format!("{least} devices {name}"));
        let all = all.collect::<Vec<_>>().join(" and ");
        let what =
            format!("the scan found needs a CPU with at least {all}, which parameters decide");
        row("", left(""), what);
    }
    if let Some(why) = &audit.stands_between {
        let what =
            format!("the longest scan with the known values of devices; between the two: {why}");
        row("by the search", time(bound.model), what);
    }
    row(
        "structural bound",
        time(bound.naive),
        format!(
            "sum of all instructions, each at its larger time; mutual exclusion saves {}{} ({})",
            if audit.ended_early { "at least " } else { "" },
            bound.saved(),
            Share::of(bound.saved(), bound.naive)
        ),
    );
    if let Some(found) = &audit.coactivity {
        let without = found.without.upper;
        let saved = without.checked_sub(bound.upper).unwrap_or(Picos::ZERO);
        let most = if found.without.cut { "at most " } else { "" };
        let active = match found.active.is_empty() {
            true => "no step is active and no action on".to_owned(),
            false => format!("active and on are {}", found.active.join(", ")),
        };
        row(
            "without charts",
            time(without),
            format!(
                "if their steps and stored actions did not exclude each other: co-activity takes off {most}{saved} ({}); when the longest scan starts, {active}",
                Share::of(saved, without)
            ),
        );
    }
    if let Some(found) = &audit.net {
        let saved = found.without.checked_sub(bound.upper).unwrap_or(Picos::ZERO);
        let by_net = found.alone.checked_sub(bound.upper).unwrap_or(Picos::ZERO);
        let what = format!(
            "with only what the audit finds of relays by itself: net {} takes off {by_net} ({})",
            found.net,
            Share::of(by_net, found.alone)
        );
        row("without the net", time(found.alone), what);
        let what = format!(
            "if relays could be on in any combination when a scan starts: that the code keeps some apart takes off {saved} ({})",
            Share::of(saved, found.without)
        );
        row("without relays", time(found.without), what);
    }
    if let Some(first) = audit.networks.iter().map(|one| one.first).min() {
        let what: Vec<&str> = audit.networks.iter().map(|one| one.what.as_str()).collect();
        rows.push(vec![
            left("plus network refresh").styled(CARE),
            right("not stated"),
            left(format!(
                "of {}, first used in {}: [network] refresh = \"1.5ms\" or \"none\"",
                what.join(", "),
                place(audit, first)
            )),
        ]);
    }
    let mut told = |name: &str, what: Option<String>| {
        rows.extend(what.map(|what| vec![left(name), right(""), left(what)]));
    };
    told("search", method::searched(audit));
    told("confirmed", method::confirmed(audit));
    heading("The bound, exactly", extent) + &fitted(2, &rows, extent.width)
}

/// What the bound says of scans.
fn at_most_told(audit: &Audit) -> &'static str {
    match (audit.uncounted_doubts().is_empty(), audit.upper_with_all_points() > audit.bound.upper) {
        (false, _) => "at most, but for what is not stated",
        (true, true) => "at most, with the points that the program names",
        (true, false) => "at most: no scan takes longer",
    }
}

/// The bound by its groups: charges that no device ties together have maxima that add up.
pub(super) fn groups(audit: &Audit, extent: Extent) -> String {
    let bound = &audit.bound;
    // The factor is a row of its own here, so the others are without it.
    let always = "what no state of the plant changes".to_owned();
    let scale = Scale::of(bound.upper);
    let mut parts = vec![("always".to_owned(), audit.bare(bound.always), always)];
    for term in &audit.overhead {
        let why = term.why.split(';').next().unwrap_or_default();
        let assumed = if term.evidence == Evidence::Assumed { " (assumed)" } else { "" };
        parts.push((term.name.clone(), audit.bare(term.time), format!("{why}{assumed}")));
    }
    let (shown, rest) = audit.main_groups(extent.top);
    for group in shown {
        let exact = if group.exact() { "exact" } else { "at most" };
        let what = format!("{exact}; structural {}", scale.up(audit.bare(group.naive)));
        parts.push((format!("group {}", group.id), audit.bare(group.upper), what));
    }
    if !rest.is_empty() {
        let small: Picos = rest.iter().map(|group| audit.bare(group.upper)).sum();
        let name = count(rest.len(), "small group", "small groups");
        parts.push((name, small, String::new()));
    }
    if let Some(factor) = &audit.table.factor {
        let assumed = if factor.evidence == Evidence::Assumed { " (assumed)" } else { "" };
        let what = format!("on the rows above{assumed}");
        parts.push((format!("factor {}", factor.text), factor.part, what));
    }
    let times: Vec<Picos> = parts.iter().map(|(_, time, _)| *time).collect();
    let told = scale.parts(&times);
    let rows: Vec<Vec<Cell>> = parts
        .into_iter()
        .zip(told)
        .map(|((name, time, what), told)| {
            let share = Share::of(time, bound.upper).to_string();
            vec![left(name), right(told), right(share), left(what).styled(FAINT)]
        })
        .collect();
    heading("Parts of the bound: groups that depend on no common device add up", extent)
        + &fitted(2, &rows, extent.width)
}

//! What a clock's tolerance adds, and the worst response time, as parts of the text report.

use super::columns::{fitted, left, right};
use scanbound_audit::Audit;
use scanbound_timing::table::Evidence;

/// The longest scan without the table's factor, where the factor is a clock's tolerance.
pub(super) fn nominal(audit: &Audit) -> Option<String> {
    audit.clocked?;
    let factor = audit.table.factor.as_ref()?;
    Some(format!(
        "{} without the factor {} on the whole scan ({}): {}",
        factor.without.best_text(),
        factor.text,
        factor.evidence,
        factor.source
    ))
}

/// The worst response time with its parts; nothing if it was not asked for.
pub(super) fn section(audit: &Audit, width: usize) -> String {
    let Some(response) = &audit.response else { return String::new() };
    let row = |name: &str, time: String, what: String| vec![left(name), right(time), left(what)];
    let evidence = |evidence: Evidence| match evidence {
        Evidence::Assumed => "assumed: ",
        Evidence::Stated => "",
        Evidence::Measured => "measured: ",
        Evidence::Published => "published: ",
    };
    let delay = |name: &str, delay: &scanbound_audit::response::Delay| {
        row(name, delay.time.best_text(), format!("{}{}", evidence(delay.evidence), delay.source))
    };
    let scans = response.scan.times(response.scans);
    let rows = [
        delay("input", &response.input),
        row(
            "scans",
            scans.best_text(),
            format!(
                "{} x {}: an edge that just missed a scan's input latch waits for the next{}",
                response.scans,
                response.scan,
                match response.scans {
                    0..=2 => "",
                    _ => "; a relay that is read before it is written costs one more",
                }
            ),
        ),
        delay("output", &response.output),
        row(
            "together",
            response.total.best_text(),
            "at most, where no timer, counter or step on the way waits".to_owned(),
        ),
    ];
    format!("\nFrom an input's edge to an output's\n{}", fitted(2, &rows, width))
}

//! Scan times that are being read, on a terminal: the figures, and how they lie below the bound.

use crate::columns::{columns, left, right};
use scanbound_audit::Share;
use scanbound_base::time::Picos;
use scanbound_measured::live::{Reading, Watch};
use scanbound_measured::{Figures, Histogram};

/// How wide the largest bin is drawn.
const WIDTH: usize = 40;

/// The figures and the histogram; nothing if nothing was read.
#[must_use]
pub fn screen(watch: &Watch) -> String {
    let times = watch.times();
    let (Some(last), Some(figures)) = (watch.readings().last(), Figures::of(&times)) else {
        return String::new();
    };
    let Reading { at, time, longest, .. } = last;
    let mut rows = vec![
        vec![left("readings"), right(format!("{} in {} s", figures.count, at.as_secs()))],
        vec![left("now"), right(time.to_string())],
        vec![left("shortest"), right(figures.least.to_string())],
        vec![left("longest"), right(figures.most.to_string())],
    ];
    if let Some(longest) = longest {
        rows.push(vec![left("longest since RUN"), right(longest.to_string())]);
    }
    if let Some(bound) = watch.bound() {
        let share = Share::of(figures.most, bound);
        rows.push(vec![left("bound"), right(bound.to_string()), left(format!("{share} reached"))]);
    }
    format!("{}{}", columns(2, &rows), histogram(&times, &figures, watch.bound()))
}

/// Bins, and a line where the bound is.
fn histogram(times: &[Picos], figures: &Figures, bound: Option<Picos>) -> String {
    let histogram = Histogram::of(times, figures);
    let largest = histogram.bins.iter().map(|bin| bin.count).max().unwrap_or(1).max(1);
    let mut rows = Vec::new();
    let mut drawn = false;
    for bin in &histogram.bins {
        if let Some(bound) = bound.filter(|bound| !drawn && *bound < bin.from) {
            drawn = true;
            rows.push(at_bound(bound));
        }
        // At least a mark for a bin that is not empty.
        let length = (bin.count * WIDTH).div_ceil(largest);
        let from = right(format!("{} us", bin.from.us_text()));
        rows.push(vec![from, right(bin.count.to_string()), left("#".repeat(length))]);
    }
    if histogram.beyond > 0 {
        let beyond = format!("up to {}", figures.most);
        rows.push(vec![right("beyond"), right(histogram.beyond.to_string()), left(beyond)]);
    }
    if let Some(bound) = bound.filter(|_| !drawn) {
        rows.push(at_bound(bound));
    }
    columns(2, &rows)
}

fn at_bound(bound: Picos) -> Vec<crate::columns::Cell> {
    vec![right(format!("{} us", bound.us_text())), right(""), left("- bound -")]
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_link::client::ScanTimes;
    use std::time::Duration;

    #[test]
    fn the_bound_stands_where_it_lies() {
        let tenth = |tenths: u64| Picos(tenths * 100_000_000);
        let mut watch = Watch::new(Some(tenth(50)));
        assert_eq!(screen(&watch), "");
        for at in 0..20 {
            let current = tenth(30 + at % 4);
            let times = ScanTimes { current, least: None, most: Some(tenth(33)) };
            watch.take(Duration::from_secs(at), times);
        }
        let shown = anstream::adapter::strip_str(&screen(&watch)).to_string();
        let lines: Vec<&str> = shown.lines().map(str::trim_end).collect();
        assert!(lines[0].contains("20 in 19 s"), "{shown}");
        assert!(shown.contains("66.0 % reached"), "{shown}");
        assert!(lines.last().is_some_and(|line| line.ends_with("- bound -")), "{shown}");
        let bars = lines.iter().filter(|line| line.ends_with('#')).count();
        assert_eq!(bars, 4, "{shown}");
    }
}

//! Where the elements of a chart are drawn.

use crate::iec::chart::Chart;

/// The level and the column of each step: its distance from the initial steps, and its number there.
pub(super) fn places(chart: &Chart) -> Vec<(usize, usize)> {
    let mut levels = vec![None; chart.steps.len()];
    let mut open = chart.initial();
    open.iter().for_each(|&step| levels[step] = Some(0));
    let mut at = 0;
    while at < open.len() {
        let step = open[at];
        at += 1;
        let next = levels[step].map(|level: usize| level + 1);
        for one in chart.transitions.iter().filter(|one| one.from.contains(&step)) {
            for &behind in &one.to {
                if levels[behind].is_none() {
                    levels[behind] = next;
                    open.push(behind);
                }
            }
        }
    }
    let beyond = levels.iter().flatten().max().map_or(0, |last| last + 1);
    let mut counts: Vec<usize> = Vec::new();
    let place = |level: Option<usize>| {
        let level = level.unwrap_or(beyond);
        if counts.len() <= level {
            counts.resize(level + 1, 0);
        }
        counts[level] += 1;
        (level, counts[level] - 1)
    };
    levels.into_iter().map(place).collect()
}

//! A comparison as JSON, schema `scanbound.compare/1` (docs/json.md): keys may be added, none changes its meaning.

use scanbound_measured::{Comparison, Fit, Ratio};
use schemars::JsonSchema;
use serde::Serialize;

#[derive(Serialize, JsonSchema)]
pub(crate) struct Report<'a> {
    schema: &'static str,
    files: &'a [String],
    source: Source<'a>,
    bound: Bound<'a>,
    scans: Scans,
    #[schemars(extend("enum" = ["within", "above"]))]
    verdict: &'static str,
    tightness_thousandths: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    above: Option<Above>,
    below_least: usize,
    missed_pulses: usize,
    histogram: Histogram,
    #[serde(skip_serializing_if = "Option::is_none")]
    fit: Option<FitResult>,
    doubts: &'a [String],
}

#[derive(Serialize, JsonSchema)]
struct Source<'a> {
    file: &'a str,
    how: &'a str,
    emulated: bool,
    resolution_ps: Option<u64>,
}

#[derive(Serialize, JsonSchema)]
struct Bound<'a> {
    table: &'a str,
    upper_ps: u64,
    lower_ps: u64,
    least_ps: u64,
    assumed_ps: u64,
}

#[derive(Serialize, JsonSchema)]
struct Scans {
    count: usize,
    min_ps: u64,
    mean_ps: u64,
    median_ps: u64,
    p999_ps: u64,
    max_ps: u64,
    max_at: usize,
}

#[derive(Serialize, JsonSchema)]
struct Above {
    count: usize,
    first: usize,
    by_ps: u64,
    within_resolution: bool,
}

#[derive(Serialize, JsonSchema)]
struct Histogram {
    width_ps: u64,
    bins: Vec<Bin>,
    beyond: usize,
}

#[derive(Serialize, JsonSchema)]
struct Bin {
    from_ps: u64,
    count: usize,
}

#[derive(Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum FitResult {
    Clock { shortest_ps: u64, mean_ps: u64, longest_ps: u64, bound_ps: u64, lowers_bound: bool },
    Scale { least: String, most: Option<String>, explains: bool, bound_ps: u64, lowers_bound: bool },
}

/// The comparison on indented lines.
#[must_use]
pub fn render(found: &Comparison) -> String {
    let (figures, bounds, measured) = (&found.figures, &found.bounds, &found.measured);
    let report = Report {
        schema: "scanbound.compare/1",
        files: &found.files,
        source: Source {
            file: &measured.file,
            how: &measured.how,
            emulated: measured.emulated,
            resolution_ps: measured.resolution.map(|time| time.0),
        },
        bound: Bound {
            table: &bounds.table,
            upper_ps: bounds.upper.0,
            lower_ps: bounds.lower.0,
            least_ps: bounds.least.0,
            assumed_ps: bounds.assumed.0,
        },
        scans: Scans {
            count: figures.count,
            min_ps: figures.least.0,
            mean_ps: figures.mean.0,
            median_ps: figures.median.0,
            p999_ps: figures.p999.0,
            max_ps: figures.most.0,
            max_at: figures.most_at,
        },
        verdict: if found.above.is_some() { "above" } else { "within" },
        tightness_thousandths: found.tightness.0,
        above: found.above.map(|above| Above {
            count: above.count,
            first: above.first,
            by_ps: above.by.0,
            within_resolution: above.within_resolution,
        }),
        below_least: found.below,
        missed_pulses: found.missed,
        histogram: Histogram {
            width_ps: found.histogram.width.0,
            bins: found
                .histogram
                .bins
                .iter()
                .map(|bin| Bin { from_ps: bin.from.0, count: bin.count })
                .collect(),
            beyond: found.histogram.beyond,
        },
        fit: found.fit.as_ref().map(fit),
        doubts: &bounds.doubts,
    };
    let mut text = serde_json::to_string_pretty(&report).expect("plain data has a JSON form");
    text.push('\n');
    text
}

fn fit(fit: &Fit) -> FitResult {
    match fit {
        Fit::Clock(scanbound_measured::Clock { shortest, mean, longest, bound, lowers }) => {
            FitResult::Clock {
                shortest_ps: shortest.0,
                mean_ps: mean.0,
                longest_ps: longest.0,
                bound_ps: bound.0,
                lowers_bound: *lowers,
            }
        }
        Fit::Scale(scale) => FitResult::Scale {
            least: scale.least.to_string(),
            most: scale.most.as_ref().map(Ratio::to_string),
            explains: scale.explains(),
            bound_ps: scale.bound.0,
            lowers_bound: scale.lowers,
        },
    }
}

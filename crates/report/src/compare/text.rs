//! A comparison as text for people: the verdict, the figures, a histogram, and what the measurements support.

use crate::columns::{columns, left, paint, right};
use anstyle::{AnsiColor, Style};
use scanbound_audit::Share;
use scanbound_base::time::Picos;
use scanbound_measured::{Above, Clock, Comparison, Fit, Scale};

const BOLD: Style = Style::new().bold();
const GOOD: Style = AnsiColor::Green.on_default().bold();
const CARE: Style = AnsiColor::Yellow.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();
/// How wide the largest bin is drawn.
const WIDTH: usize = 40;

/// The comparison. Has colour codes.
#[must_use]
pub fn render(found: &Comparison) -> String {
    let mut text = verdict(found);
    text += &figures(found);
    text += &histogram(found);
    text += &meaning(found);
    if let Some(fit) = &found.fit {
        text += &self::fit(found, fit);
    }
    for warning in &found.measured.warnings {
        text += &format!("\n{}: {}\n", paint(CARE, "warning"), warning.message);
    }
    text
}

/// The verdict in a sentence.
#[must_use]
pub fn answer(found: &Comparison) -> String {
    let text = anstream::adapter::strip_str(&verdict(found)).to_string();
    text.trim_end().to_owned()
}

/// What the scans are: measured, unless their file says that they are not.
fn kind(found: &Comparison) -> &'static str {
    if found.measured.emulated { "emulated" } else { "measured" }
}

fn verdict(found: &Comparison) -> String {
    let (kind, bound) = (kind(found), found.bounds.upper);
    match found.above {
        None => format!(
            "{}: all {} {kind} scans take at most the bound of {bound}; the longest takes {} of it\n",
            paint(GOOD, "WITHIN"),
            found.figures.count,
            found.tightness
        ),
        Some(Above { count, first, by, within_resolution }) => {
            let fine = if within_resolution {
                ", which is within what the capture can tell apart"
            } else {
                ""
            };
            format!(
                "{}: {count} of {} {kind} scans take longer than the bound of {bound}, by up to {by} ({}){fine}; the first is scan {first}\n",
                paint(BAD, "ABOVE"),
                found.figures.count,
                Share::of(by, bound)
            )
        }
    }
}

/// A row of the figures.
pub(crate) struct Figure {
    pub(crate) name: &'static str,
    pub(crate) time: String,
    pub(crate) share: String,
    pub(crate) note: String,
}

/// The bound and what was measured.
pub(crate) fn figure_rows(found: &Comparison) -> Vec<Figure> {
    let figures = &found.figures;
    let bounds = &found.bounds;
    // Short scans in microseconds, so that three decimals tell them apart.
    let shown = if bounds.upper < Picos(2_000_000_000) { us } else { ms };
    let of_bound = |time: Picos| Share::of(time, bounds.upper).to_string();
    let row = |name, time: Picos, note: String| Figure {
        name,
        time: shown(time),
        share: of_bound(time),
        note,
    };
    let told = match (bounds.doubts.is_empty(), bounds.upper == bounds.lower) {
        (false, _) => "may be too low, since not all that it needs is stated; by the table",
        (true, true) => "no scan takes longer, exact, by the table",
        (true, false) => "no scan takes longer, by the table",
    };
    let mut rows = vec![row("bound", bounds.upper, format!("{told} {}", bounds.table))];
    if bounds.upper != bounds.lower {
        rows.push(row("", bounds.lower, "some scan takes as long, by the table".to_owned()));
    }
    rows.extend([
        row("longest", figures.most, format!("scan {}", figures.most_at)),
        row("99.9 %", figures.p999, "of the scans take no longer".to_owned()),
        row("mean", figures.mean, String::new()),
        row("shortest", figures.least, String::new()),
    ]);
    rows
}

fn figures(found: &Comparison) -> String {
    let row = |one: Figure| vec![left(one.name), right(one.time), right(one.share), left(one.note)];
    let rows: Vec<_> = figure_rows(found).into_iter().map(row).collect();
    let files = found.files.join(", ");
    let resolution = found
        .measured
        .resolution
        .map_or(String::new(), |resolution| format!(", told apart to {resolution}"));
    format!(
        "\n{files}\n{}: {} scans, {}{resolution}\n\n{}",
        found.measured.file,
        found.figures.count,
        found.measured.how,
        columns(2, &rows)
    )
}

fn histogram(found: &Comparison) -> String {
    let histogram = &found.histogram;
    let largest = histogram.bins.iter().map(|bin| bin.count).max().unwrap_or(1).max(1);
    let mut rows = Vec::new();
    for bin in &histogram.bins {
        // At least a sliver for a bin that is not empty.
        let eighths = (bin.count * WIDTH * 8).div_ceil(largest);
        rows.push(vec![
            right(format!("{} us", bin.from.us_text())),
            right(bin.count.to_string()),
            left(bar(eighths)),
        ]);
    }
    if histogram.beyond > 0 {
        rows.push(vec![
            right("beyond"),
            right(histogram.beyond.to_string()),
            left(format!("far above the others, up to {}", found.figures.most)),
        ]);
    }
    format!(
        "\n{}\n{}",
        paint(BOLD, &format!("Scans by their time, {} a line", histogram.width)),
        columns(2, &rows)
    )
}

/// A bar of so many eighths of a character.
fn bar(eighths: usize) -> String {
    const PARTS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    "█".repeat(eighths / 8) + PARTS[eighths % 8]
}

fn meaning(found: &Comparison) -> String {
    let notes = notes(found);
    if notes.is_empty() {
        return String::new();
    }
    let notes: String = notes.iter().map(|note| format!("  {note}\n")).collect();
    format!("\n{}\n{notes}", paint(BOLD, "What this can mean"))
}

/// What the comparison can mean.
pub(crate) fn notes(found: &Comparison) -> Vec<String> {
    let bounds = &found.bounds;
    let kind = kind(found);
    let mut notes: Vec<String> = Vec::new();
    if found.above.is_some() {
        let assumed = if bounds.assumed > Picos::ZERO {
            format!(
                " ({} of the bound rests on assumed times)",
                Share::of(bounds.assumed, bounds.upper)
            )
        } else {
            String::new()
        };
        notes.push(format!(
            "the table {} may not be this CPU's, or a time in it is too short{assumed}",
            bounds.table
        ));
        if bounds.clocked.is_some() {
            notes.push(
                "the clock may be slower than the table has it: measure it and state it with --clock"
                    .to_owned(),
            );
        } else {
            notes.push("an interrupt routine or communication may have run more often than was stated (--interrupts, @end rows of the table)".to_owned());
        }
        if found.histogram.beyond > 0 {
            notes.push(format!(
                "{} far above all others: the machine may have stood still there, or been without power",
                count(found.histogram.beyond, "interval")
            ));
        }
        notes.extend(bounds.doubts.iter().cloned());
    }
    if found.missed > 0 {
        notes.push(format!(
            "{} may have missed a pulse: about a whole number of usual scans ({})",
            count(found.missed, "interval"),
            found.figures.median
        ));
    }
    if found.below > 0 {
        notes.push(format!(
            "{} shorter than any scan can be by the table ({}): {} than the {kind} machine, or this is another program",
            count(found.below, "scan"),
            bounds.least,
            if bounds.clocked.is_some() { "its clock is slower" } else { "its instructions take longer" }
        ));
    }
    let usual = u128::from(found.figures.median.0);
    if usual > 20 * u128::from(bounds.upper.0) || usual * 1000 < u128::from(bounds.least.0) {
        notes.push(format!(
            "scans of {} against a bound of {}: is the unit right?",
            found.figures.median, bounds.upper
        ));
    }
    notes
}

fn fit(found: &Comparison, fit: &Fit) -> String {
    let kind = kind(found);
    let bound = found.bounds.upper;
    let change = |bound_then: Picos, lowers: bool| {
        let direction = match lowers {
            true => paint(CARE, "lower than"),
            false if bound_then == bound => "the same as".to_owned(),
            false => "higher than".to_owned(),
        };
        format!(
            "  the bound would be {bound_then}, {direction} {bound}; nothing was changed\n  it rests on {} {kind} scans, and says nothing about a hotter or colder day or another board\n",
            found.figures.count
        )
    };
    let body = match fit {
        Fit::Clock(Clock { shortest, mean, longest, bound, lowers }) => {
            format!(
                "  a word takes {} to {}, {} in the mean: {}, {} to {}\n  --clock {}us holds for the slowest\n{}",
                us(*shortest),
                us(*longest),
                us(*mean),
                khz(*mean),
                khz(*longest),
                khz(*shortest),
                longest.us_text(),
                change(*bound, *lowers)
            )
        }
        Fit::Scale(scale) => self::scale(scale, kind) + &change(scale.bound, scale.lowers),
    };
    let far = match found.histogram.beyond {
        0 => String::new(),
        beyond => format!(
            "  {} far above all others and in these figures: leave out what was no scan\n",
            count(beyond, "interval")
        ),
    };
    format!("\n{}\n{body}{far}", paint(BOLD, &format!("What the {kind} scans support")))
}

fn scale(scale: &Scale, kind: &str) -> String {
    let mut text = format!(
        "  with all times of the table multiplied by {} or more, no {kind} scan lies above the bound\n",
        scale.least
    );
    match scale.most {
        Some(most) if scale.explains() => {
            text += &format!(
                "  by {most} at most: beyond that, every scan would take longer than the shortest {kind}\n"
            );
        }
        Some(most) => {
            text += &format!(
                "  by more than {most}, every scan would take longer than the shortest {kind}: no one scale explains them all\n"
            );
        }
        None => {
            text += "  there is no upper limit: a scan may avoid all that it does\n";
        }
    }
    if scale.least.0 > 1_000_000 {
        text += &format!("  as a row of a table of your own: @factor,{},\n", scale.least);
    }
    text
}

fn count(number: usize, what: &str) -> String {
    if number == 1 { format!("1 {what} is") } else { format!("{number} {what}s are") }
}

fn ms(time: Picos) -> String {
    fixed(time.0, 1_000_000, 3) + " ms"
}

fn us(time: Picos) -> String {
    fixed(time.0, 1_000, 3) + " us"
}

/// A number of `unit / 10^places` as a decimal, rounded to the nearest.
fn fixed(value: u64, last: u64, places: usize) -> String {
    let rounded = (value + last / 2) / last;
    let unit = 10_u64.pow(places as u32);
    format!("{}.{:0places$}", rounded / unit, rounded % unit)
}

/// The frequency of a period, to a hertz.
fn khz(period: Picos) -> String {
    let hertz = 1_000_000_000_000_u64.checked_div(period.0).unwrap_or(0);
    format!("{}.{:03} kHz", hertz / 1000, hertz % 1000)
}

//! Holds measured scan times against the bound: statistics, how tight the bound is, and the verdict.

pub mod capture;
mod delimited;
mod dump;
mod figures;
mod fit;
mod heading;
mod histogram;
pub mod live;
mod number;
mod signal;
mod sigrok;

pub use capture::{Edge, Selection, Threshold};
pub use figures::{Bounds, Figures};
pub use fit::{Clock, Fit, Ratio, Scale};
pub use histogram::{Bin, Histogram};
pub use number::Decimal;

use scanbound_audit::Share;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;

/// Scan times as they were captured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measurements {
    /// The file.
    pub file: String,
    /// How the times were had from the file, in words.
    pub how: String,
    /// The scan times, in the order in which they were captured; not empty.
    pub times: Vec<Picos>,
    /// How finely the capture tells times, where the file says so.
    pub resolution: Option<Picos>,
    /// Whether the file says that an emulator made it.
    pub emulated: bool,
    /// What was noticed on the way.
    pub warnings: Vec<Diagnostic>,
}

/// Measured scan times held against the bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Comparison {
    /// The program's files.
    pub files: Vec<String>,
    /// What was measured.
    pub measured: Measurements,
    /// What the analysis says.
    pub bounds: Bounds,
    /// The figures of the measurement.
    pub figures: Figures,
    /// The longest measured scan as a part of the bound.
    pub tightness: Share,
    /// The scans above the bound.
    pub above: Option<Above>,
    /// How many scans are shorter than any scan can be by the table.
    pub below: usize,
    /// Intervals that look as if a pulse had been missed: about a whole number of usual scans.
    pub missed: usize,
    /// How the scan times are spread.
    pub histogram: Histogram,
    /// What the measurements say about the table, if asked for.
    pub fit: Option<Fit>,
}

/// Scans above the bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Above {
    /// How many.
    pub count: usize,
    /// The first one's number, from 1.
    pub first: usize,
    /// By how much the longest is above.
    pub by: Picos,
    /// Whether that is less than the capture's resolution.
    pub within_resolution: bool,
}

impl Comparison {
    /// Holds measurements against bounds. `None` if nothing was measured.
    #[must_use]
    pub fn new(
        files: Vec<String>,
        bounds: Bounds,
        measured: Measurements,
        fit: bool,
    ) -> Option<Comparison> {
        let figures = Figures::of(&measured.times)?;
        let resolution = measured.resolution.unwrap_or(Picos::ZERO);
        let over = |&(_, time): &(usize, &Picos)| *time > bounds.upper;
        let mut over = measured.times.iter().enumerate().filter(over);
        let above = over.next().map(|(first, _)| {
            let by = Picos(figures.most.0 - bounds.upper.0);
            Above {
                count: 1 + over.count(),
                first: first + 1,
                by,
                within_resolution: by <= resolution,
            }
        });
        let below = measured
            .times
            .iter()
            .filter(|time| bounds.least.0.saturating_sub(time.0) > resolution.0)
            .count();
        let missed = measured.times.iter().filter(|&&time| missed(time, figures.median)).count();
        Some(Comparison {
            files,
            tightness: Share::of(figures.most, bounds.upper),
            above,
            below,
            missed,
            histogram: Histogram::of(&measured.times, &figures),
            fit: fit.then(|| Fit::of(&figures, &bounds, resolution)),
            figures,
            measured,
            bounds,
        })
    }
}

/// Whether an interval is about two or more usual scans: within a tenth of one.
fn missed(time: Picos, usual: Picos) -> bool {
    if usual == Picos::ZERO {
        return false;
    }
    let (whole, rest) = (time.0 / usual.0, time.0 % usual.0);
    let off = rest.min(usual.0 - rest);
    let nearest = whole + u64::from(rest > usual.0 / 2);
    nearest >= 2 && off <= usual.0 / 10
}

#[cfg(test)]
mod format_tests;
#[cfg(test)]
mod tests;

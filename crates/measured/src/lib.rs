//! Compares measured scan times with the bound: statistics, how tight the bound is, and the verdict.

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

/// Scan times from a capture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measurements {
    /// The file.
    pub file: String,
    /// How the times were obtained from the file, for reports.
    pub how: String,
    /// The scan times in the order of the capture. Not empty.
    pub times: Vec<Picos>,
    /// The time resolution of the capture, if the file gives it.
    pub resolution: Option<Picos>,
    /// Whether the file says that an emulator made it.
    pub emulated: bool,
    /// The warnings.
    pub warnings: Vec<Diagnostic>,
}

/// Measured scan times compared with the bound.
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
    /// The longest measured scan as a share of the bound.
    pub tightness: Share,
    /// The scans above the bound.
    pub above: Option<Above>,
    /// The number of scans that are shorter than any scan can be by the table.
    pub below: usize,
    /// The number of intervals in which a pulse was probably missed: they are close to a multiple of the usual scan
    /// time.
    pub missed: usize,
    /// The distribution of the scan times.
    pub histogram: Histogram,
    /// The suggestion for the table, if requested.
    pub fit: Option<Fit>,
}

/// Scans above the bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Above {
    /// The number of scans.
    pub count: usize,
    /// The number of the first one, counted from 1.
    pub first: usize,
    /// By how much the longest exceeds the bound.
    pub by: Picos,
    /// Whether that is less than the capture's resolution.
    pub within_resolution: bool,
}

impl Comparison {
    /// Compares measurements with bounds. `None` if nothing was measured.
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

/// Whether an interval is within a tenth of a usual scan time of two or more of them.
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
